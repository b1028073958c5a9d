//! What an accepted step of a case must not exceed.

use crate::case::{BloodVessel, Case, Problem, Solver, TableError};
use crate::coupling::acceptance::Limits;
use crate::geometry::Vessel;
use std::f64::consts::{PI, TAU};

/// Pressures may be so many times what drives the flow: errors that grow from step to step pass that within a few
/// steps, and no flow that is driven does.
const PRESSURES: f64 = 100.0;
/// Velocities, whose squares are pressures, likewise.
const VELOCITIES: f64 = 10.0;
/// Places along the vessel, and around it, where its radius is looked at.
const ALONG: usize = 400;
const AROUND: usize = 16;

/// The limits of a case. What templates, programs and user-supplied OpenFOAM cases prescribe is not known here.
///
/// # Errors
/// If a curve cannot be read.
pub(super) fn limits(case: &Case) -> Result<Limits, TableError> {
    let any = Limits::of_any_liquid(case.blood.density, case.fluid.pressure_residual);
    let is_known = match case.fluid.solver {
        Solver::Native => true,
        Solver::OpenFoam => case.fluid.has_conditions_of_the_case(),
        Solver::External => false,
    };
    let drive = match &case.problem {
        Problem::Vessel(vessel) if is_known => of_vessel(case, vessel)?,
        _ => return Ok(any),
    };
    let pressure = match drive.pressure > 0.0 {
        true => (PRESSURES * drive.pressure).min(any.pressure),
        false => any.pressure,
    };
    Ok(match drive.speed > 0.0 {
        true => Limits {
            pressure,
            flow: VELOCITIES * drive.speed * drive.area,
            ..any
        },
        // Still blood: residuals and losses are shares of next to nothing.
        false => Limits {
            pressure,
            residual: f64::INFINITY,
            is_closed: false,
            ..any
        },
    })
}

/// What drives a flow.
struct Drive {
    /// Sum of the pressures that are prescribed and of those that the prescribed flow needs, Pa.
    pressure: f64,
    /// Velocity in the narrowest cross-section, m/s.
    speed: f64,
    /// The widest cross-section, m².
    area: f64,
}

fn of_vessel(case: &Case, vessel: &BloodVessel) -> Result<Drive, TableError> {
    let geometry = Vessel::new(vessel);
    let sections = geometry.sections();
    let (from, to) = (sections[0].from, sections[sections.len() - 1].to);
    let place = |i: usize| from + (to - from) * i as f64 / ALONG as f64;
    let area = |s: f64| {
        let around = (0..AROUND).map(|j| geometry.lumen_radius(s, TAU * j as f64 / AROUND as f64));
        PI * around.map(|r| r * r).sum::<f64>() / AROUND as f64
    };
    let areas = || (0..=ALONG).map(|i| area(place(i)));
    let narrowest = areas().fold(f64::INFINITY, f64::min);
    let widest = areas().fold(0.0, f64::max);

    let (step, period) = (case.time.step, case.time.period);
    let largest = |rows: &mut dyn Iterator<Item = [f64; 2]>| {
        rows.map(|[_, value]| value.abs()).fold(0.0, f64::max)
    };
    let openings = vessel.openings(period)?;
    let models = || (openings.iter()).filter_map(|opening| opening.condition.pressure());
    let tissue = vessel.surroundings.as_ref().and_then(|s| s.pressure);
    let mut pressure = tissue.unwrap_or(0.0).abs();
    for model in models() {
        let downstream = model.downstream.samples(step, period);
        pressure += largest(&mut downstream.into_iter()) + model.initial.abs();
    }
    let flows = openings
        .iter()
        .filter_map(|opening| opening.condition.flow());
    let flows: Vec<f64> = (flows.map(|curve| largest(&mut curve.samples(step)))).collect();
    let density = case.blood.density;
    let speed = match flows.is_empty() {
        true => (2.0 * pressure / density).sqrt(), // Bernoulli
        false => {
            let flow = flows.into_iter().fold(0.0, f64::max);
            let speed = 2.0 * flow / narrowest; // a parabola's
            let viscosity = case.blood.rheology().viscosity(0.0);
            let resistance = models()
                .map(|model| {
                    model.proximal + model.distal.map_or(0.0, |(resistance, _)| resistance)
                })
                .fold(0.0, f64::max);
            let friction = 8.0 * PI * viscosity * (to - from) / narrowest.powi(2); // Poiseuille
            let inertia = density * (to - from) / narrowest / step; // a start within a step
            pressure += (resistance + friction + inertia) * flow + density * speed * speed;
            speed
        }
    };
    Ok(Drive {
        pressure,
        speed,
        area: widest,
    })
}
