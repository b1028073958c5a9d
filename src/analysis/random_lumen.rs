//! What a random lumen makes of a vessel: whether lumen and wall are still there, whether the elements resolve it, how
//! much of the field its modes carry.

use crate::case::{BloodVessel, Case, Problem, RandomLumen, Solver};
use crate::geometry::{Span, Surfaces, Vessel};
use std::f64::consts::TAU;
use std::fmt;

/// Share of the radius without the field that a lumen keeps at least, and share of its thickness that a layer does.
const LEAST: [f64; 2] = [0.2, 0.1];
/// Elements of a curved shape may be so many correlation lengths long, cells with plane faces so many.
const LONGEST: [f64; 2] = [2.0, 0.5];
/// Places that are looked at along a field, and angles at each.
const ALONG: usize = 120;
const AROUND: usize = 72;

/// The random lumen of a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RandomLumenFigures {
    /// Modes that are kept.
    pub modes: usize,
    /// Their share of the variance.
    pub share: f64,
    /// Largest standard deviation of the radius by the kept modes, m.
    pub deviation: f64,
    /// The same relative to the radius there without the field.
    pub relative: f64,
    /// Smallest and largest change of the radius in this realization, m.
    pub change: [f64; 2],
}

impl fmt::Display for RandomLumenFigures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [low, high] = self.change.map(|change| 1e3 * change);
        write!(
            f,
            "random: {} modes carry {:.1} % of the variance; their standard deviation is {:.3} mm at most, three of which \
             change the radius by {:.2} mm ({:.0} %); in this realization it changes by {low:.2} to {high:.2} mm",
            self.modes,
            100.0 * self.share,
            1e3 * self.deviation,
            3e3 * self.deviation,
            300.0 * self.relative,
        )
    }
}

/// Arc lengths and angles all over a field.
fn places(keys: &RandomLumen) -> impl Iterator<Item = [f64; 2]> {
    let (from, length) = (keys.from, keys.to - keys.from);
    (0..ALONG).flat_map(move |i| {
        let s = from + length * (i as f64 + 0.5) / ALONG as f64;
        (0..AROUND).map(move |j| [s, TAU * j as f64 / AROUND as f64])
    })
}

/// A vessel, the same without its random field, and the keys of that.
fn with_and_without(vessel: &BloodVessel) -> Option<(Vessel, Vessel, &RandomLumen)> {
    let keys = vessel.random_lumen.as_ref()?;
    let mut smooth = vessel.clone();
    smooth.random_lumen = None;
    Some((Vessel::new(vessel), Vessel::new(&smooth), keys))
}

/// Figures of the random lumen of a case, if it has one.
pub fn figures(case: &Case) -> Option<RandomLumenFigures> {
    let (vessel, smooth, keys) = with_and_without(case.vessel()?)?;
    let field = keys.field()?;
    let modes = keys.modes.min(field.all());
    let mut figures = RandomLumenFigures {
        modes,
        share: field.shares().iter().sum(),
        deviation: 0.0,
        relative: 0.0,
        change: [0.0; 2],
    };
    let single = |k: usize| {
        let mut amplitudes = vec![0.0; k + 1];
        amplitudes[k] = 1.0;
        field.realization(&amplitudes)
    };
    let singles: Vec<_> = (0..modes).map(single).collect();
    for [s, phi] in places(keys) {
        let values = singles.iter().map(|mode| mode.value(s, phi).powi(2));
        let deviation = values.sum::<f64>().sqrt();
        let radius = smooth.lumen_radius(s, phi);
        let change = vessel.lumen_radius(s, phi) - radius;
        figures.deviation = figures.deviation.max(deviation);
        figures.relative = figures.relative.max(deviation / radius);
        figures.change = [figures.change[0].min(change), figures.change[1].max(change)];
    }
    Some(figures)
}

/// What is wrong with the random lumen of a case: keys, and a sentence each.
pub fn mistakes(case: &Case) -> Vec<(&'static str, String)> {
    let Problem::Vessel(keys_of_vessel) = &case.problem else {
        return Vec::new();
    };
    let Some((vessel, smooth, keys)) = with_and_without(keys_of_vessel) else {
        return Vec::new();
    };
    let sections = vessel.sections();
    let ends = [sections[0].from, sections[sections.len() - 1].to];
    // Lengths are rarely exact in binary.
    let spare = 1e-9 * (ends[1] - ends[0]);
    for (key, s) in [
        ("random_lumen.from_m", keys.from),
        ("random_lumen.to_m", keys.to),
    ] {
        if s < ends[0] - spare || s > ends[1] + spare {
            let what = format!(
                "the vessel reaches from s = {:.6} to {:.6} m, and the field must lie within",
                ends[0], ends[1]
            );
            return vec![(key, what)];
        }
    }
    let mut mistakes = unresolved(case, &vessel, keys_of_vessel, keys);
    mistakes.extend(closed(&vessel, &smooth, keys));
    mistakes
}

/// Correlation lengths that are too short for the elements.
fn unresolved(
    case: &Case,
    vessel: &Vessel,
    meshes: &BloodVessel,
    keys: &RandomLumen,
) -> Vec<(&'static str, String)> {
    let (wall, native, cells) = (&meshes.structure, &meshes.fluid.native, &meshes.fluid.mesh);
    let mut parts = match case.fluid.solver {
        Solver::Native => vec![(
            "fluid.native.axial_per_section",
            "fluid.native.core",
            vessel.spans(native),
            4 * native.core,
            LONGEST[0],
        )],
        Solver::OpenFoam | Solver::External => vec![(
            "fluid.mesh.axial_per_section",
            "fluid.mesh.core",
            vessel.spans(cells),
            4 * cells.core,
            LONGEST[1],
        )],
    };
    if case.has_elastic_wall() {
        parts.push((
            "structure.axial_per_section",
            "structure.circumferential",
            vessel.spans(wall),
            wall.circumferential,
            LONGEST[0],
        ));
    }
    let mut mistakes = Vec::new();
    for (along, around, spans, count, longest) in parts {
        let reached = |span: &&Span| span.to > keys.from && span.from < keys.to;
        let lengths = spans.iter().filter(reached);
        let lengths = lengths.map(|span| (span.to - span.from) / span.pieces as f64);
        let length = lengths.fold(0.0, f64::max);
        if length > longest * keys.along {
            let what = format!(
                "elements or cells there are {length:.3e} m long ({along}), which resolves {:.3e} m and more: take more of \
                 them, or a longer correlation length",
                length / longest
            );
            mistakes.push(("random_lumen.length_along_m", what));
        }
        let angle = 360.0 / count as f64;
        if keys
            .around_deg
            .is_some_and(|around| angle > longest * around)
        {
            let what = format!(
                "{count} elements or cells lie around ({around}), which resolves {:.1} degrees and more: take more of them, \
                 or a larger angle",
                angle / longest
            );
            mistakes.push(("random_lumen.angle_around_deg", what));
        }
    }
    mistakes
}

/// Where the lumen is nearly closed, or a layer of the wall nearly gone.
fn closed(vessel: &Vessel, smooth: &Vessel, keys: &RandomLumen) -> Option<(&'static str, String)> {
    let thickness = |vessel: &Vessel, k: usize, [s, phi]: [f64; 2]| {
        vessel.radius(k, s, phi) - vessel.radius(k - 1, s, phi)
    };
    let mut worst: Option<(f64, String)> = None;
    for place in places(keys) {
        let [s, phi] = place;
        let lumen = vessel.lumen_radius(s, phi);
        let mut shares = vec![(lumen / smooth.lumen_radius(s, phi), LEAST[0], lumen, 0)];
        shares.extend((1..=vessel.layers()).map(|k| {
            let now = thickness(vessel, k, place);
            (now / thickness(smooth, k, place), LEAST[1], now, k)
        }));
        for (share, least, now, layer) in shares {
            if share >= least
                || worst
                    .as_ref()
                    .is_some_and(|(other, _)| *other <= share / least)
            {
                continue;
            }
            let what = match layer {
                0 => "the radius of the lumen".to_owned(),
                layer => format!("the thickness of layer {layer} of the wall"),
            };
            let told = format!(
                "{what} is {:.3} mm at s = {s:.4} m, {:.0} degrees, {:.0} % of what it is without the field, and {:.0} % are \
                 needed: take smaller amplitudes or a smaller standard deviation",
                1e3 * now,
                phi.to_degrees(),
                100.0 * share,
                100.0 * least
            );
            worst = Some((share / least, told));
        }
    }
    worst.map(|(_, told)| ("random_lumen.amplitudes", told))
}
