//! A case for the user's vessel, written from a centre-line, a surface, or from nothing but a name: meshes,
//! time step and windkessel follow from the lumen's radius and the flow.

mod beat;
mod changes;
mod ends;
mod files;
mod impossible;
mod sac;
mod smoothing;
mod text;
mod told;
mod tree;
mod wall;

pub use ends::{end_radii, tree_shares};

use crate::analysis::three_elements::ThreeElements;
use crate::analysis::windkessel::TwoElements;
use crate::case::{
    Case, FlowCurve, FlowUnit, FluidMesh, LengthUnit, Preset, Ramp, ResolvedCase, TOO_SHARP,
};
use crate::geometry::Vessel;
use crate::tabular::units::MMHG;
use beat::Beat;
use changes::Changes;
use files::VesselSizes;
use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};
use text::Numbers;

/// Pressures that the windkessel is proposed for, mmHg.
const PRESSURES: [f64; 2] = [80.0, 120.0];
/// Thickness of an artery's wall, as a share of the radius.
const THICKNESS: f64 = 0.3;
/// Where a line bends too sharply for its wall, the least radius of a bend that is tried first, relative to the
/// narrowest outside of the wall, the last one, relative to the widest, and the ratio of those between.
const LEAST_BENDS: [f64; 3] = [1.15, 2.0, 1.12];
/// The proximal resistance of a windkessel of three elements, as a share of the whole.
const PROXIMAL: [f64; 3] = [0.1, 0.05, 0.02];
/// The largest step, that of the defaults, s.
const STEP: f64 = 2e-3;
/// A vessel without files has this radius (m), and is so many radii long.
const RADIUS: f64 = 3e-3;
const RADII: f64 = 16.0;
/// Cells at the wall are thinner than this share of the Stokes layer.
const LAYER: f64 = 0.25;
/// The fastest blood passes at most so many cells in a step.
const COURANT: f64 = 5.0;
/// Speed of a pulse in an artery, m/s.
const PULSE: f64 = 5.0;
/// The blood's added mass returns the longest wave of a wall of length L about (L/(π c dt))² times as large within a
/// step (130 mm in 0.1 ms: 6,800 times). Steps are not so small that it is more than this.
const ADDED_MASS: f64 = 100.0;
/// Steps of a beat, and time constants, in which a windkessel is brought into its periodic state.
const STEPS: f64 = 2000.0;
const BEATS: f64 = 20.0;
/// The least compliance of a windkessel, relative to that of it and the vessel together.
const STIFFEST: f64 = 0.05;
/// From this Reynolds number on flow in tubes may be turbulent.
const TURBULENT: f64 = 2000.0;

crate::case::words! {
    /// What the vessel is like.
    #[derive(Default, clap::ValueEnum)]
    pub enum Like {
        /// One section of an artery of two layers.
        Uniform = "uniform" (default),
        /// An artery with a narrowing in its middle.
        Stenosis = "stenosis",
        /// An artery with a widening in its middle.
        Aneurysm = "aneurysm",
        /// A graft between two parts of an artery.
        Graft = "graft",
    }
}

/// What the user has.
#[derive(Debug, Clone, Default)]
pub struct ProposalInput {
    /// File of the centre-line.
    pub line: Option<PathBuf>,
    /// Files of the other branches of a tree, if each has one.
    pub branches: Vec<PathBuf>,
    /// File of the lumen's surface.
    pub lumen: Option<PathBuf>,
    /// Unit of both, unless the first says its own.
    pub unit: Option<LengthUnit>,
    /// Unit of the surface, if it is another.
    pub lumen_unit: Option<LengthUnit>,
    /// Which of several lines.
    pub branch: Option<String>,
    /// Whether the blood flows against the order of the line's points.
    pub is_reversed: bool,
    /// Radius of the lumen (m), if no file knows it.
    pub radius: Option<f64>,
    /// What the vessel is like.
    pub like: Like,
    /// File of the flow.
    pub flow: Option<PathBuf>,
    /// Unit of the flows in that file, if it does not say it itself.
    pub flow_unit: Option<FlowUnit>,
    /// Duration of a period of that file (s), if it is not that of a beat.
    pub flow_period: Option<f64>,
    /// Duration of a beat (s), if it is not that of the file.
    pub period: Option<f64>,
    /// Length (m) of the waves of the line that are halved, if it is not to be chosen.
    pub smoothing: Option<f64>,
    /// Radii next to where a tree's branches part within which its lines are replaced, if that is not to be chosen.
    pub junction_smoothing: Option<f64>,
    /// Thickness of the artery's wall, m.
    pub thickness: Option<f64>,
    /// Pressure (Pa) under which the vessel has the shape of the files.
    pub loaded: Option<f64>,
    /// Whether the windkessel has a proximal resistance.
    pub is_rcr: bool,
    /// Whether tissue surrounds the wall.
    pub has_tissue: bool,
    /// Names of the openings of a tree, the inlet first, if they are not to be chosen.
    pub names: Vec<String>,
    /// Names of the ends of a tree whose lines are left out.
    pub leave_out: Vec<String>,
    /// Names of the ends of a tree that lie within a sac and are no openings.
    pub closed: Vec<String>,
    /// Radius (m) of the thinnest vessel of a tree that counts, if there is a limit.
    pub least_radius: Option<f64>,
    /// Ways of smoothing the lines of a tree that are known to lead to no mesh or no wall, see [`Proposal::way`].
    pub ruled_out: Vec<usize>,
    /// Ways of smoothing them that are known to lead to a mesh, see [`Proposal::with_mesh`].
    pub known: Vec<(usize, f64)>,
    /// Whether lines are left out without which the others have a mesh.
    pub leaves_impossible_out: bool,
    /// Shares of the flow of a tree's outlets, if they do not follow from their radii.
    pub split: Vec<f64>,
    /// Exponent of the radius that they follow from.
    pub murray: Option<f64>,
}

/// A case that is complete, and what it was made from.
#[derive(Debug, Clone)]
pub struct Proposal {
    /// The text of `case.toml`.
    pub text: String,
    /// Files that stand next to it, by their names there.
    pub files: Vec<(String, PathBuf)>,
    /// What a user wants to know of it, a line each.
    pub remarks: Vec<String>,
    /// Which way of smoothing the lines of a tree it takes, if there are more.
    pub way: Option<usize>,
    /// Those that were tried and with which the lines have a mesh: with its smallest scaled Jacobian.
    pub with_mesh: Vec<(usize, f64)>,
    /// Those with which they have none.
    pub without_mesh: Vec<usize>,
    /// The same case with thinner walls, whose shares of the radius are these, if the thickness was not given.
    thinner: VecDeque<(f64, String)>,
}

/// Why there is no proposal.
#[derive(Debug, thiserror::Error)]
pub enum ProposalError {
    /// Something is missing or does not fit.
    #[error("{0}")]
    Input(String),
    /// The vessel makes no case.
    #[error("no case can be made from this:\n{0}")]
    Case(String),
    /// Nothing can be written.
    #[error("cannot write a case for a trial: {0}")]
    Io(#[from] std::io::Error),
}

impl From<String> for ProposalError {
    fn from(what: String) -> Self {
        Self::Input(what)
    }
}

impl From<&str> for ProposalError {
    fn from(what: &str) -> Self {
        Self::Input(what.to_owned())
    }
}

impl Proposal {
    /// Makes a case that has been loaded and checked.
    ///
    /// # Errors
    /// What is missing, or all mistakes of the case.
    pub fn new(input: &ProposalInput) -> Result<Self, ProposalError> {
        if tree::is_meant(input)? {
            return tree::proposal(input);
        }
        let of_trees = [
            ("--names", !input.names.is_empty()),
            ("--leave-out", !input.leave_out.is_empty()),
            ("--closed", !input.closed.is_empty()),
            ("--leave-out-impossible", input.leaves_impossible_out),
            ("--least-radius", input.least_radius.is_some()),
            ("--junction-smoothing", input.junction_smoothing.is_some()),
            ("--split", !input.split.is_empty()),
            ("--murray", input.murray.is_some()),
        ];
        if let Some((option, _)) = of_trees.into_iter().find(|(_, is_given)| *is_given) {
            let reason = "is for a vessel that branches: --from a .vtp, .vtk or .swc with several ends, or --from a table for each branch";
            return Err(ProposalError::Input(format!("{option} {reason}")));
        }
        let (input, mut remarks) = told::files(input)?;
        let input = &input;
        let sizes = files::sizes(input)?;
        let mut files = Vec::new();
        for path in [&input.line, &input.lumen, &input.flow]
            .into_iter()
            .flatten()
        {
            let name = path
                .file_name()
                .map(|name| name.to_string_lossy().into_owned());
            files.push((name.unwrap_or_default(), path.clone()));
        }
        let beat = Beat::of(input)?;
        let mut numbers = Numbers::new(&sizes, beat.period);
        let trial = tempfile::tempdir()?;
        for (name, path) in &files {
            std::fs::copy(path, trial.path().join(name))
                .map_err(|error| ProposalError::Input(format!("{}: {error}", path.display())))?;
        }
        let case = loaded(trial.path(), input, &sizes, &mut numbers)?;
        remarks.extend(beat.remarks);
        if let Some(keys) = case.vessel()
            && let Some(changes) = Changes::of(keys, &sizes, input)?
        {
            if changes.is_another() && input.smoothing.is_none() {
                return Err(ProposalError::Input(another(&changes)));
            }
            remarks.extend(changes.remarks());
            if let Some(least) = numbers.least_bend {
                remarks.push(format!(
                    "warning: bends of less than {:.2} mm are rounded off, because the wall could not follow them; a thinner one \
                     could (--thickness)",
                    1e3 * least
                ));
            }
        }
        let (figures, more) = Figures::of(&case, input)?;
        remarks.extend(more);
        numbers.choose(&case, &figures, input);
        let text = text::case(input, &numbers);
        load(trial.path(), &text, input, Preset::Paper)?;
        Ok(Self {
            text,
            files,
            remarks,
            way: None,
            with_mesh: Vec::new(),
            without_mesh: Vec::new(),
            thinner: VecDeque::new(),
        })
    }
}

impl Proposal {
    /// Of a vessel that branches, the same case with the next thinner wall, whose share of the radius is returned; none
    /// if its thickness was given, or there is no thinner one.
    pub fn make_thinner(&mut self) -> Option<f64> {
        let (share, text) = self.thinner.pop_front()?;
        self.text = text;
        Some(share)
    }
}

/// The case; where its line bends too sharply for the wall, with bends that are rounded off as little as it takes.
fn loaded(
    folder: &Path,
    input: &ProposalInput,
    sizes: &VesselSizes,
    numbers: &mut Numbers,
) -> Result<ResolvedCase, ProposalError> {
    let first = match load(folder, &text::case(input, numbers), input, Preset::Paper) {
        Err(ProposalError::Case(errors)) if errors.contains(TOO_SHARP) && sizes.line.is_some() => {
            errors
        }
        other => return other,
    };
    let [narrowest, widest, ratio] = LEAST_BENDS;
    let outside = sizes
        .radii
        .map(|r| r + input.thickness.unwrap_or(THICKNESS * r));
    let mut least = narrowest * outside[0];
    while least <= widest * outside[1] {
        numbers.least_bend = Some(files::rounded(least));
        match load(folder, &text::case(input, numbers), input, Preset::Paper) {
            Err(ProposalError::Case(errors)) if errors.contains(TOO_SHARP) => least *= ratio,
            other => return other,
        }
    }
    Err(ProposalError::Case(first))
}

/// Why a line whose points would be moved too far is refused, and what can be done.
fn another(changes: &Changes) -> String {
    format!(
        "--from: to follow this line the wall needs it so smooth that points move by up to {:.3} mm, {:.0} % of the radius, and its length \
         changes from {:.2} to {:.2} mm. Is the line that of one vessel, in the right unit? A thinner wall bends more sharply \
         (--thickness); --smoothing {:.0}um takes it as it would be",
        1e3 * changes.moved[0],
        100.0 * changes.moved[1],
        1e3 * changes.lengths[0],
        1e3 * changes.lengths[1],
        1e6 * changes.smoothing,
    )
}

fn load(
    folder: &Path,
    text: &str,
    input: &ProposalInput,
    preset: Preset,
) -> Result<ResolvedCase, ProposalError> {
    std::fs::write(folder.join("case.toml"), text)?;
    Case::load(folder, preset, &[])
        .map_err(|errors| ProposalError::Case(told::mistakes(&errors, input, folder)))
}

/// Resistance (Pa s/m³) and compliance (m³/Pa) of a windkessel, its proximal resistance, and the pressure at t = 0
/// (Pa) from which the ramp leads straight into the periodic state.
#[derive(Debug, Clone)]
struct Windkessel {
    resistance: f64,
    compliance: f64,
    proximal: Option<f64>,
    /// Share of the vessel in the compliance of both.
    own: f64,
    /// Whether the vessel stores more than these pressures allow.
    is_vessel_too_soft: bool,
    /// Its mean pressure in the periodic state, Pa.
    mean: f64,
    start: f64,
}

impl Windkessel {
    /// What the vessel itself stores, in words.
    fn of_vessel(&self) -> String {
        if self.is_vessel_too_soft {
            return "; the vessel itself is too soft for that: the pulse pressure will be smaller"
                .into();
        }
        match (100.0 * self.own).round() {
            0.0 => String::new(),
            share => {
                format!(
                    "; the vessel itself has {share} % of the compliance, estimated from long tubes of its radii"
                )
            }
        }
    }
}

/// What meshes and times follow from.
struct Figures {
    /// Smallest and mean radius of the lumen, m.
    radii: [f64; 2],
    curve: FlowCurve,
    /// Mean flow and the largest one, m³/s.
    flows: [f64; 2],
    /// Thickness √(2ν/ω) of the Stokes layer of the beat, m.
    layer: f64,
    /// Length of the elastic part, and of its shortest section, m.
    lengths: [f64; 2],
}

impl Figures {
    fn of(
        case: &ResolvedCase,
        input: &ProposalInput,
    ) -> Result<(Self, Vec<String>), ProposalError> {
        let mistake = |message: &str| ProposalError::Input(message.into());
        let keys = case
            .vessel()
            .ok_or_else(|| mistake("the case has no vessel"))?;
        let vessel = Vessel::new(keys);
        let end = vessel.end();
        let mean_at = |s: f64| {
            let angles = (0..16).map(|i| vessel.lumen_radius(s, TAU * f64::from(i) / 16.0));
            angles.sum::<f64>() / 16.0
        };
        let along = |places: usize| -> Vec<f64> {
            (0..=places)
                .map(|i| mean_at(end * i as f64 / places as f64))
                .collect()
        };
        // So close to each other that no narrowing is missed.
        let narrow = along(200).into_iter().fold(f64::INFINITY, f64::min);
        let radii = along(((10.0 * end / narrow).ceil() as usize).clamp(200, 5000));
        let range = radii
            .iter()
            .fold([f64::INFINITY, 0.0f64], |[low, high], r| {
                [low.min(*r), high.max(*r)]
            });
        let mean = radii.iter().sum::<f64>() / radii.len() as f64;
        let curve = FlowCurve::new(&keys.inflow, case.time.period)
            .map_err(|e| ProposalError::Input(e.to_string()))?;
        let period = case.time.period;
        let flows: Vec<f64> = (0..1000)
            .map(|i| curve.flow(period * f64::from(i) / 1000.0))
            .collect();
        let of_flow = [
            flows.iter().sum::<f64>() / 1000.0,
            flows.iter().fold(0.0f64, |most, q| most.max(q.abs())),
        ];
        let plausible = told::plausible(input, &curve, of_flow, mean)?;
        let nu = case.blood.viscosity / case.blood.density;
        let omega = TAU / period;
        let womersley = mean * (omega / nu).sqrt();
        let reynolds = 2.0 * of_flow[1] / (PI * range[0] * nu);
        let mut remarks = vec![
            format!(
                "lumen     radius {:.2} to {:.2} mm, {:.2} mm on average; elastic over {:.1} mm of the centre-line",
                1e3 * range[0],
                1e3 * range[1],
                1e3 * mean,
                1e3 * end
            ),
            format!(
                "flow      {:.0} ml/min on average{}, at most {:.1} ml/s; Womersley number {womersley:.2}, Reynolds number at most {reynolds:.0}",
                6e7 * of_flow[0],
                if input.flow.is_some() {
                    ""
                } else {
                    ", chosen for the radius (--flow gives your own)"
                },
                1e6 * of_flow[1]
            ),
        ];
        if reynolds > TURBULENT {
            remarks.push(turbulent());
        }
        remarks.extend(plausible);
        let lengths = (vessel.elastic_sections()).map(|section| section.to - section.from);
        let shortest = lengths.fold(end, f64::min);
        let figures = Self {
            radii: [range[0], mean],
            curve,
            flows: of_flow,
            layer: (2.0 * nu / omega).sqrt(),
            lengths: [end, shortest],
        };
        Ok((figures, remarks))
    }

    /// The windkessel for 80 to 120 mmHg downstream of a vessel of the compliance `vessel` (m³/Pa), with the pressure
    /// at t = 0 from which a ramp of this duration (s) leads into its periodic state, without the blood that fills the
    /// vessel meanwhile.
    ///
    /// A flow that is too steady for these pressures gets their mean; without a mean flow there is none. A vessel that
    /// is too soft for them gets a windkessel of [`STIFFEST`].
    fn windkessel(&self, ramp: f64, is_rcr: bool, vessel: f64) -> Option<Windkessel> {
        let [low, high] = PRESSURES.map(|p| p * MMHG);
        let mut found = match TwoElements::between(low, high, &self.curve, 0.0) {
            Ok(found) => found,
            Err(_) if self.flows[0] > 0.0 => {
                let resistance = 0.5 * (low + high) / self.flows[0];
                TwoElements {
                    resistance,
                    compliance: 0.5 * self.curve.period() / resistance,
                }
            }
            Err(_) => return None,
        };
        let most = (1.0 - STIFFEST) * found.compliance;
        let is_vessel_too_soft = vessel > most;
        let vessel = vessel.min(most);
        found.compliance -= vessel;
        let mut proximal = None;
        for share in PROXIMAL.into_iter().filter(|_| is_rcr) {
            let before = share * found.resistance;
            if let Ok(all) = ThreeElements::between(low, high, &self.curve, before, vessel) {
                (found.resistance, found.compliance) = (all.resistance, all.compliance);
                proximal = Some(before);
                break;
            }
        }
        let tau = found.resistance * (found.compliance + vessel);
        let step = self.curve.period() / STEPS;
        let march = |from: f64, to: f64, start: f64, share: &dyn Fn(f64) -> f64| {
            let steps = ((to - from) / step).ceil().max(1.0);
            let h = (to - from) / steps;
            (0..steps as usize).fold(start, |p, i| {
                let t = from + (i as f64 + 0.5) * h;
                let flow = share(t) * self.curve.flow(t);
                // Exact for a constant flow.
                p * (-h / tau).exp() - flow * found.resistance * (-h / tau).exp_m1()
            })
        };
        let periods = (BEATS * tau / self.curve.period()).ceil();
        let before = -periods * self.curve.period();
        let mean = found.pressures(&self.curve).mean;
        let own = vessel / (found.compliance + vessel);
        let periodic = march(before, ramp, mean, &|_| 1.0);
        let rise = |t: f64| Ramp { duration: ramp }.factor(t);
        let brought = march(0.0, ramp, 0.0, &rise);
        let start = (periodic - brought) * (ramp / tau).exp();
        Some(Windkessel {
            resistance: found.resistance,
            compliance: found.compliance,
            proximal,
            own,
            is_vessel_too_soft,
            mean,
            start,
        })
    }

    /// Rings of cells between core and wall, and their grading, so that the cell at the wall resolves the Stokes layer.
    fn rings(&self, least: usize, grading: f64) -> (usize, f64) {
        let thin = |rings: usize, grading: f64| {
            let ratio = match rings {
                1 => 1.0,
                _ => grading.powf(-1.0 / (rings - 1) as f64),
            };
            let all: f64 = (0..rings).map(|k| ratio.powi(k as i32)).sum();
            // From the core, at about half of the radius, to the wall.
            0.45 * self.radii[1] * ratio.powi(rings as i32 - 1) / all <= LAYER * self.layer
        };
        let gradings = [grading, 4.0, 6.0];
        let choices = (least..=16).flat_map(|rings| gradings.map(|grading| (rings, grading)));
        choices
            .into_iter()
            .find(|(rings, grading)| thin(*rings, *grading))
            .unwrap_or((16, 6.0))
    }

    /// A time step of 1, 2 or 5 times a power of ten, at most `most`.
    fn step(&self, mesh: &FluidMesh, most: f64) -> f64 {
        let radius = self.radii[0];
        let speed = 2.0 * self.flows[1] / (PI * radius * radius);
        let [length, shortest] = self.lengths;
        let cell = shortest / mesh.axial_per_section as f64;
        let least = length / (PI * PULSE * ADDED_MASS.sqrt());
        let wanted = (COURANT * cell / speed).max(least).min(most);
        let power = 10f64.powf(wanted.log10().floor());
        let steps = [5.0, 2.0, 1.0].map(|digit| digit * power);
        steps
            .into_iter()
            .find(|step| *step <= wanted * (1.0 + 1e-9))
            .unwrap_or(most)
    }
}

fn turbulent() -> String {
    format!(
        "warning: above a Reynolds number of about {TURBULENT:.0} flow may be turbulent, and the blood is computed as laminar"
    )
}

#[cfg(test)]
mod tests;
