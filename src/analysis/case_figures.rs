//! A vessel's case in the figures by which flow and wall are known, before anything is meshed.

use super::tube_law::{self, TubeLaw};
use super::windkessel::{Pressures, STEPS};
use crate::case::{Case, FlowCurve, Solver, VesselSide};
use crate::geometry::Vessel;
use std::f64::consts::{PI, TAU};

/// Places along a vessel where its radius is looked at.
const PLACES: usize = 400;

/// What is to be expected of the blood and its vessel.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseFigures {
    /// Smallest, mean and largest radius of the evaluated part of the lumen, in the shape that the case gives, m.
    pub radii: [f64; 3],
    /// Length of that part, m.
    pub length: f64,
    /// The flow, if one is prescribed.
    pub flow: Option<FlowFigures>,
    /// Pressures in the periodic state.
    pub pressures: Option<Pressures>,
    /// Womersley number of the mean radius and the beat.
    pub womersley: f64,
    /// Sections with an elastic wall.
    pub walls: Vec<TubeFigures>,
}

/// A prescribed flow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlowFigures {
    /// Mean over the beat, m³/s.
    pub mean: f64,
    /// Largest magnitude, m³/s.
    pub peak: f64,
    /// Smallest and largest value, m³/s.
    pub range: [f64; 2],
    /// Mean velocity in a cross-section of the mean radius, on average and at the peak, m/s.
    pub velocity: [f64; 2],
    /// Reynolds number of mean velocity and diameter where the vessel is narrowest, on average and at the peak.
    pub reynolds: [f64; 2],
}

/// The wall of a section, as a long tube of its middle.
#[derive(Debug, Clone, PartialEq)]
pub struct TubeFigures {
    /// What the section is called.
    pub name: String,
    /// Thickness by radius of the lumen, unloaded.
    pub thickness_ratio: f64,
    /// Radius of the lumen under the mean pressure, m.
    pub radius: Option<f64>,
    /// The same under the highest one, m.
    pub highest_radius: Option<f64>,
    /// Speed of pulse waves there, held along the axis, m/s.
    pub wave_speed: Option<f64>,
    /// Growth of the radius from the lowest pressure to the highest.
    pub distension: Option<f64>,
}

impl CaseFigures {
    /// Of a case; `None` if it has no vessel, or a curve that cannot be read.
    pub fn of(case: &Case) -> Option<Self> {
        let keys = case.vessel()?;
        let geometry = Vessel::new(keys);
        let length = geometry.end();
        let radii = (0..=PLACES)
            .map(|i| tube_law::mean_radius(&geometry, length * i as f64 / PLACES as f64));
        let radii: Vec<f64> = radii.collect();
        let mean = radii.iter().sum::<f64>() / radii.len() as f64;
        let fold = |start, pick: fn(f64, f64) -> f64| radii.iter().copied().fold(start, pick);
        let radii = [fold(f64::INFINITY, f64::min), mean, fold(0.0, f64::max)];
        let nu = case.blood.viscosity / case.blood.density;
        let inlet = keys.prescribed_at(VesselSide::Start, case.time.period);
        let flow = (inlet.ok()?.flow()).map(|curve| FlowFigures::new(curve, radii, nu));
        let expected = |own: f64| Pressures::expected(keys, case.time.period, own).ok();
        let without = expected(0.0)?;
        let own = tube_law::compliance(case, [without.lowest, without.highest]);
        let pressures = expected(own)?;
        let walls = tube_law::of_sections(case);
        let wall = |(section, law): &(_, TubeLaw)| {
            TubeFigures::new(section, law, &pressures, case.blood.density)
        };
        Some(Self {
            radii,
            length,
            flow,
            womersley: mean * (TAU / case.time.period / nu).sqrt(),
            walls: walls.iter().map(wall).collect(),
            pressures: Some(pressures),
        })
    }

    /// What the pressures assume of the walls, if there are elastic ones.
    pub fn as_tubes(&self) -> &'static str {
        match self.walls.is_empty() {
            true => "",
            false => ", assuming that the walls widen like long tubes",
        }
    }
}

/// Fewer steps than that in a beat do not follow a pulse.
const FEW_STEPS: f64 = 50.0;
/// Cells that the fastest blood may pass in a step before the step is to blame.
const MANY_CELLS: f64 = 10.0;

/// Why the time step of a case may be too large, if its flow says so; for runs that fail.
pub fn step_is_large(case: &Case) -> Option<String> {
    let flow = CaseFigures::of(case)?.flow.filter(|flow| flow.peak > 0.0)?;
    let vessel = case.vessel()?;
    let (step, steps) = (case.time.step, case.time.period / case.time.step);
    let geometry = Vessel::new(vessel);
    let spans = match case.fluid.solver {
        Solver::Native => geometry.spans(&vessel.fluid.native),
        Solver::OpenFoam | Solver::External => geometry.spans(&vessel.fluid.mesh),
    };
    let within = match case.fluid.solver {
        Solver::Native => vessel.fluid.native.degree as f64,
        Solver::OpenFoam | Solver::External => 1.0,
    };
    let passed = spans.iter().map(|span| {
        let cell = (span.to - span.from) / (span.pieces as f64 * within);
        let radius = tube_law::mean_radius(&geometry, 0.5 * (span.from + span.to));
        flow.peak / (PI * radius.powi(2)) * step / cell
    });
    let passed = passed.fold(0.0, f64::max);
    let pulses = flow.range[1] - flow.range[0] > 1e-3 * flow.peak;
    let found = match (pulses && steps < FEW_STEPS, passed > MANY_CELLS) {
        (true, _) => format!("a beat has {steps:.0} steps"),
        (false, true) => format!(
            "the fastest blood passes {passed:.0} cells or nodes in a step (its Courant number)"
        ),
        (false, false) => return None,
    };
    Some(format!(
        "time.step_s = {step:?} may be too large: {found}; try a tenth of it"
    ))
}

impl FlowFigures {
    fn new(curve: &FlowCurve, [narrow, mean_radius, _]: [f64; 3], nu: f64) -> Self {
        let times = (0..STEPS).map(|i| curve.period() * i as f64 / STEPS as f64);
        let flows: Vec<f64> = times.map(|t| curve.flow(t)).collect();
        let mean = flows.iter().sum::<f64>() / flows.len() as f64;
        let low = flows.iter().copied().fold(f64::INFINITY, f64::min);
        let high = flows.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let peak = low.abs().max(high.abs());
        Self {
            mean,
            peak,
            range: [low, high],
            velocity: [mean, peak].map(|flow| flow / (PI * mean_radius.powi(2))),
            reynolds: [mean.abs(), peak].map(|flow| 2.0 * flow / (PI * narrow * nu)),
        }
    }
}

impl TubeFigures {
    fn new(
        section: &crate::geometry::Section,
        law: &TubeLaw,
        pressures: &Pressures,
        density: f64,
    ) -> Self {
        let [low, mean, high] = [pressures.lowest, pressures.mean, pressures.highest]
            .map(|pressure| law.radius(pressure));
        Self {
            name: section.name.clone(),
            thickness_ratio: law.thickness_ratio(),
            radius: mean,
            highest_radius: high,
            wave_speed: law.wave_speed(pressures.mean, density),
            distension: low.zip(high).map(|(low, high)| high / low - 1.0),
        }
    }
}
