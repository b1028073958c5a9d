//! The lumen `r(s, φ)` of a vessel from the surface that a segmentation gives: rays from the centre-line in its
//! cross-sections.

use super::{LengthUnit, VesselDescription};
use crate::Vec3;
use crate::curve::SpaceCurve;
use crate::files::{Fault, fault};
use crate::interpolation::{MonotoneCubic, SmoothingSpline, smooth_periodic};
use crate::polydata::{Crossing, OVERLAP, PolyData, Surface};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Rays of a cross-section.
const RAYS: usize = 72;
/// Every so many of them become a column of the table.
const RAYS_OF_A_COLUMN: usize = 2;
/// Cross-sections for a length of one radius, and how many there are at least and at most.
const ROWS_OF_A_RADIUS: f64 = 3.0;
const ROWS: [f64; 2] = [12.0, 600.0];
/// A triangle whose normal is closer to the centre-line than this (cosine) closes the vessel and is none of its wall.
const CLOSING: f64 = 0.9;
/// Neighbouring rays may differ by this factor.
const JUMP: f64 = 1.25;
/// The centre-line may come so close to the wall, relative to the mean radius of the cross-section.
const NARROW: f64 = 0.1;
/// A hole has at least this area, in squared radii.
const CRACK: f64 = 1e-4;
/// A vessel is thinner than this share of its length.
const STUBBY: f64 = 0.125;
/// Ends of a surface lie so close to those of its line, relative to its size.
const ENDS: f64 = 0.3;
/// Sizes of surface and centre-line differ by less, in the same unit.
const SAME_UNIT: f64 = 40.0;
/// Waves along the surface that are halved, in lengths of a triangle, if the case does not say.
pub(super) const TRIANGLES: f64 = 3.0;

/// Which key is to blame, and what is wrong.
pub(super) type Mistake = (&'static str, String);

impl VesselDescription {
    /// Mean radius of the lumen along a centre-line whose table of radii stands in the case; and the largest of each
    /// cross-section.
    pub(super) fn table_laws(&self, length: f64) -> Option<[MonotoneCubic; 2]> {
        let rows = &self.lumen_radii;
        let last = rows.len().checked_sub(1).filter(|last| *last > 0)?;
        let law = |of_row: fn(&[f64]) -> f64| {
            let places = (0..=last).map(|i| length * i as f64 / last as f64);
            MonotoneCubic::new(
                places.collect(),
                rows.iter().map(|row| of_row(row)).collect(),
            )
        };
        let largest = |row: &[f64]| row.iter().copied().fold(0.0, f64::max);
        Some([
            law(|row| row.iter().sum::<f64>() / row.len() as f64),
            law(largest),
        ])
    }

    /// Reads the surface of the lumen, if the case names one: its radii then stand in it. Whether it did.
    ///
    /// The centre-line must have been checked.
    ///
    /// # Errors
    /// The key to blame, and what is wrong.
    pub(super) fn read_lumen(&mut self) -> Result<bool, Mistake> {
        const KEY: &str = "vessel.lumen";
        let Some(path) = &self.lumen else {
            return Ok(false);
        };
        let named = |fault: Fault| (KEY, format!("{}: {fault}", path.display()));
        let Some(unit) = self.lumen_unit.or(self.unit) else {
            return Err((KEY, "expected its unit of length next to it: vessel.lumen_unit = \"mm\", \"m\", \"cm\" or \"um\"".into()));
        };
        let data = PolyData::read(path).map_err(named)?;
        let surface = Surface::new(&data, unit.metres()).map_err(named)?;
        let curve = self.curve();
        let rows = rows_of(&surface, &curve, self.lumen_smoothing);
        // A wrong unit shows in many ways.
        let other = other_unit(&surface, &curve, unit, rows.is_err());
        let rows = match other {
            Some(reason) => Err(reason.into()),
            None => rows,
        };
        let column = |row: &[f64; RAYS]| row.iter().step_by(RAYS_OF_A_COLUMN).copied().collect();
        self.lumen_radii = rows.map_err(named)?.iter().map(column).collect();
        Ok(true)
    }
}

/// The radii of the surface around the line, smoothed.
fn rows_of(
    surface: &Surface,
    curve: &SpaceCurve,
    smoothing: Option<f64>,
) -> Result<Vec<[f64; RAYS]>, Fault> {
    let section = |s: f64| {
        let frame = curve.frame(s);
        surface.rays(&frame.origin, [&frame.first, &frame.second], RAYS)
    };
    same_size(surface, curve)?;

    let length = curve.ends()[1];
    let tries: Vec<Vec<Option<Crossing>>> = (1..10)
        .into_par_iter()
        .map(|i| section(length * f64::from(i) / 10.0))
        .collect();
    let mut radii: Vec<f64> = tries.iter().flatten().flatten().map(|c| c.radius).collect();
    radii.sort_by(f64::total_cmp);
    let Some(radius) = radii.get(radii.len() / 2).copied() else {
        return Err(apart(surface, curve));
    };
    let count = (length / radius * ROWS_OF_A_RADIUS)
        .ceil()
        .clamp(ROWS[0], ROWS[1]) as usize;
    let places: Vec<f64> = (0..=count)
        .map(|i| length * i as f64 / count as f64)
        .collect();
    let sections: Vec<Vec<Option<Crossing>>> = places.par_iter().map(|s| section(*s)).collect();
    let mut rows = whole(&sections, &places, radius)?;
    holes(surface, curve, radius)?;
    star_shaped(&rows, &places)?;

    let mut chords: Vec<f64> = sections
        .iter()
        .flatten()
        .flatten()
        .map(|c| c.chord)
        .collect();
    chords.sort_by(f64::total_cmp);
    let halved = smoothing.unwrap_or(TRIANGLES * chords[chords.len() / 2]);
    smooth(&mut rows, &places, halved);
    Ok(rows)
}

/// That the surface is in another unit than is said, if it fits the line in that one and not in this.
fn other_unit(
    surface: &Surface,
    curve: &SpaceCurve,
    said: LengthUnit,
    has_failed: bool,
) -> Option<String> {
    let length = curve.ends()[1];
    let places: Vec<Vec3> = (0..=40)
        .map(|i| curve.frame(length * f64::from(i) / 40.0).origin)
        .collect();
    let is_bare = has_failed && surrounded(surface, curve, 1.0) < 3;
    let other = LengthUnit::ALL
        .into_iter()
        .filter(|other| *other != said)
        .find(|other| {
            let factor = other.metres() / said.metres();
            let fits = surface_fits(surface.bounds(), &places, factor);
            fits || is_bare && surrounded(surface, curve, factor) >= 7
        })?;
    let is_sure = has_failed || !surface_fits(surface.bounds(), &places, 1.0);
    is_sure.then(|| format!(
        "the surface is {} the centre-line needs: in {other} it fits, in {said} it does not; correct its unit \
         (vessel.lumen_unit, or vessel.unit of the line)",
        times(said.metres() / other.metres())
    ))
}

/// So many times as large or as small as.
pub(super) fn times(factor: f64) -> String {
    let (number, word) = match factor > 1.0 {
        true => (factor, "larger"),
        false => (1.0 / factor, "smaller"),
    };
    let number = match number.round() as u64 {
        10 => "ten".to_owned(),
        100 => "a hundred".to_owned(),
        1000 => "a thousand".to_owned(),
        other => other.to_string(),
    };
    format!("{number} times {word} than")
}

/// Whether a surface with these bounds, times `factor`, begins and ends where the points of a line do.
fn surface_fits(bounds: [Vec3; 2], line: &[Vec3], factor: f64) -> bool {
    let start = [f64::INFINITY, f64::NEG_INFINITY].map(Vec3::repeat);
    let of_line = line
        .iter()
        .fold(start, |[low, high], p| [low.inf(p), high.sup(p)]);
    let size = (of_line[1] - of_line[0]).norm();
    let off = (0..2).map(|i| (bounds[i] * factor - of_line[i]).amax());
    off.fold(0.0, f64::max) < ENDS * size
}

/// At how many of nine places the surface, times `factor`, surrounds the line as a vessel does.
fn surrounded(surface: &Surface, curve: &SpaceCurve, factor: f64) -> usize {
    let length = curve.ends()[1];
    let is_around = |i: &i32| {
        let frame = curve.frame(length * f64::from(*i) / 10.0);
        // The line shrinks instead of the surface.
        let rays = surface.rays(
            &(frame.origin / factor),
            [&frame.first, &frame.second],
            RAYS,
        );
        let met = rays.iter().flatten();
        let met: Vec<f64> = met.map(|c| c.radius * factor).collect();
        4 * met.len() > 3 * RAYS && met.iter().all(|radius| *radius < STUBBY * length)
    };
    (1..10).filter(is_around).count()
}

/// Surface and centre-line have about the same size if they have the same unit.
fn same_size(surface: &Surface, curve: &SpaceCurve) -> Result<(), Fault> {
    let [low, high] = surface.bounds();
    let (size, length) = ((high - low).norm(), curve.ends()[1]);
    let ratio = size / length;
    if (1.0 / SAME_UNIT..SAME_UNIT).contains(&ratio) {
        return Ok(());
    }
    Err(fault!(
        "the surface is {size:.3e} m across, and the centre-line {length:.3e} m long: is the unit of one of them wrong \
         (vessel.unit, vessel.lumen_unit)?"
    ))
}

/// Where the two lie if no ray meets the surface.
fn apart(surface: &Surface, curve: &SpaceCurve) -> Fault {
    let [low, high] = surface.bounds();
    let [start, end] = curve.ends().map(|s| curve.frame(s).origin);
    let show = |p: Vec3| format!("({:.4}, {:.4}, {:.4})", p.x, p.y, p.z);
    fault!(
        "the centre-line, from {} to {} m, lies outside of the surface, which reaches from {} to {} m: are both in the same \
         coordinates and units?",
        show(start),
        show(end),
        show(low),
        show(high)
    )
}

/// The radii of each cross-section; near the ends of the line those of the nearest cross-section that is whole.
fn whole(
    sections: &[Vec<Option<Crossing>>],
    places: &[f64],
    radius: f64,
) -> Result<Vec<[f64; RAYS]>, Fault> {
    let row = |section: &Vec<Option<Crossing>>| -> Option<[f64; RAYS]> {
        let mut row = [0.0; RAYS];
        for (value, crossing) in row.iter_mut().zip(section) {
            *value = crossing.filter(|c| c.slant < CLOSING)?.radius;
        }
        Some(row)
    };
    let found: Vec<Option<[f64; RAYS]>> = sections.iter().map(row).collect();
    let length = places[places.len() - 1];
    let (first, last) = match (
        found.iter().position(Option::is_some),
        found.iter().rposition(Option::is_some),
    ) {
        (Some(first), Some(last)) => (first, last),
        _ => (0, 0),
    };
    let is_end = |i: usize| {
        i < first && places[first] <= OVERLAP * radius
            || i > last && length - places[last] <= OVERLAP * radius
    };
    if let Some(i) = (0..found.len()).find(|i| found[*i].is_none() && !is_end(*i)) {
        let missing = sections[i]
            .iter()
            .filter(|crossing| crossing.is_none())
            .count();
        let place = format!("{:.4e} m from the beginning of the centre-line", places[i]);
        return Err(match missing {
            0 => {
                fault!("{place} the surface crosses the vessel: it is closed there, or has a step")
            }
            _ if 3 * missing >= RAYS => fault!(
                "{place} the line leaves the surface: {missing} of {RAYS} rays from it meet nothing; is the line longer than the \
                 surface, or next to it?"
            ),
            _ => fault!(
                "{place} the surface has a hole: {missing} of {RAYS} rays from the centre-line pass through it; close it"
            ),
        });
    }
    let nearest = |i: usize| found[i.clamp(first, last)].unwrap_or([radius; RAYS]);
    Ok((0..found.len()).map(nearest).collect())
}

/// A surface may be open where the vessel ends, and nowhere else.
fn holes(surface: &Surface, curve: &SpaceCurve, radius: f64) -> Result<(), Fault> {
    let length = curve.ends()[1];
    let edges = surface.open_edges();
    for (i, edge) in edges.iter().enumerate() {
        let nearest = curve.nearest(&edge.centre);
        let away = nearest.across[0].hypot(nearest.across[1]);
        let is_within = nearest.s > OVERLAP * radius && nearest.s < length - OVERLAP * radius;
        // What lies further away are ends of other branches; cracks without width let no ray through.
        if !is_within || away >= 1.5 * radius || edge.area < CRACK * radius * radius {
            continue;
        }
        let p = edge.centre;
        let place = format!(
            "around ({:.4}, {:.4}, {:.4}) m, {:.4e} m from the beginning of the centre-line",
            p.x, p.y, p.z, nearest.s
        );
        let others = edges.iter().enumerate().filter(|(j, _)| *j != i);
        let mut others = others.map(|(_, other)| (other.centre - p).norm());
        return Err(match others.find(|gap| *gap < 0.1 * radius) {
            Some(gap) => fault!(
                "two parts of the surface do not meet {place}: a crack of about {gap:.1e} m; merge the points on both sides \
                 of it (in MeshLab \"Merge Close Vertices\")"
            ),
            None => fault!(
                "the surface has a hole of {} edges {place}: it must be closed, or open at the vessel's ends only",
                edge.edges
            ),
        });
    }
    Ok(())
}

/// A lumen that a ray leaves once has no jumps.
fn star_shaped(rows: &[[f64; RAYS]], places: &[f64]) -> Result<(), Fault> {
    for (row, s) in rows.iter().zip(places) {
        let place = |ray: usize| {
            format!(
                "{s:.4e} m from the beginning of the centre-line, at {:.0}°,",
                (TAU * ray as f64 / RAYS as f64).to_degrees()
            )
        };
        let mean = row.iter().sum::<f64>() / RAYS as f64;
        if let Some(ray) = (0..RAYS).find(|ray| row[*ray] < NARROW * mean) {
            return Err(fault!(
                "{} the centre-line is only {:.3e} m from the surface, whose mean radius is {mean:.3e} m: the line must run \
                 through the middle; compute it again, or smooth it less",
                place(ray),
                row[ray]
            ));
        }
        for ray in 0..RAYS {
            let (a, b) = (row[ray], row[(ray + 1) % RAYS]);
            if a / b > JUMP || b / a > JUMP {
                return Err(fault!(
                    "{} the radius jumps from {a:.3e} to {b:.3e} m: a branch, which must be cut off and closed, or a \
                     cross-section that is not star-shaped about the centre-line",
                    place(ray)
                ));
            }
        }
    }
    Ok(())
}

/// Takes out what the triangles bring in: waves of the length `halved` keep half of their height, around and along.
fn smooth(rows: &mut [[f64; RAYS]], places: &[f64], halved: f64) {
    if halved == 0.0 {
        return;
    }
    for row in rows.iter_mut() {
        let around = TAU * row.iter().sum::<f64>() / RAYS as f64;
        let smooth = smooth_periodic(row, around, halved);
        row.copy_from_slice(&smooth);
    }
    let along = SmoothingSpline::new(places, rows, halved);
    rows.copy_from_slice(along.values());
}
