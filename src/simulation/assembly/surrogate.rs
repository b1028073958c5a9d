//! The surrogate of a case: a one-dimensional tube whose wall yields as the structure does.

use crate::Vec3;
use crate::case::{
    self, BloodVessel, Case, InletCondition, OutletCondition, OutletElements, Problem, Solver,
};
use crate::coupling::acceleration::surrogate::{
    Axis, End, Sections, SparseSection, SurrogateBlood, TubeSurrogate,
};
use crate::coupling::acceleration::{Identity, Surrogate};
use crate::coupling::flatten;
use crate::coupling::transfer::Transfer;
use crate::fluid::FluidInterface;
use crate::geometry::{Vessel, elastic_pieces};
use crate::pfem::{Solid, SurfaceLoad, SurfacePoint};

/// Pressure (Pa) that probes the wall without load: so small that one tangent serves for all sections.
const PROBE: f64 = 1.0;
/// Share of the pressure in a loaded wall that probes it: likewise, and above the rounding errors of what it adds to.
const SHARE: f64 = 1e-3;
/// Relative residual of the answers: a surrogate need not be accurate.
const PROBE_TOLERANCE: f64 = 1e-3;
/// Most rings of wall points that have a section each: every section costs a solution of the structure.
const MOST_RINGS: usize = 63;

/// The surrogate that the case asks for. Its wall is what `solid`, which is at rest under a `pressure` (Pa), answers to a
/// little more within a time step.
pub fn surrogate<S: Solid>(
    case: &Case,
    interface: &FluidInterface,
    solid: &mut S,
    transfer: &Transfer<S::Location>,
    pressure: f64,
) -> Result<Box<dyn Surrogate>, String> {
    let vessel = match &case.problem {
        _ if case.coupling.surrogate == case::SurrogateModel::None => {
            return Ok(Box::new(Identity));
        }
        // Nothing moves.
        Problem::Vessel(vessel) if vessel.is_rigid() => return Ok(Box::new(Identity)),
        Problem::Vessel(vessel) => vessel,
        Problem::Flag(_) | Problem::Own(_) => {
            return Err("the surrogate is a tube, and the case has none".into());
        }
    };
    let geometry = Vessel::new(vessel);
    let [first, last] = [0, geometry.sections().len() - 1].map(|i| &geometry.sections()[i]);
    let [before, behind] = [-first.from, last.to - geometry.end()];
    let open = |rigid_length| End::Pressure { rigid_length };
    let (inlet, outlet) = match case.coupling.surrogate {
        case::SurrogateModel::None => return Ok(Box::new(Identity)),
        case::SurrogateModel::Tube => ends(vessel, before, behind),
        case::SurrogateModel::OpenTube => (open(before), open(behind)),
    };
    let sections =
        sections(vessel, case.fluid.solver, &interface.points).map_err(|e| e.to_string())?;
    let count = sections.count();

    let probe = PROBE.max(SHARE * pressure.abs());
    // The residual is measured against the whole load.
    let tolerance = match pressure {
        0.0 => PROBE_TOLERANCE,
        _ => PROBE_TOLERANCE * SHARE / (count as f64).sqrt(),
    };
    let rest = flatten(&transfer.accepted_displacement(solid));
    let mut answers = Vec::new();
    for section in 0..count {
        let wet = solid.wet_points();
        let at = |point: &SurfacePoint| pressure + probe * sections.share(section, &point.position);
        let load = SurfaceLoad {
            pressure: wet.iter().map(at).collect(),
            shear: vec![Vec3::zeros(); wet.len()],
        };
        let trial = solid
            .solve(&load, case.time.step, tolerance, None)
            .map_err(|e| e.to_string())?;
        answers.push((flatten(&transfer.displacement(solid, &trial)) - &rest) / probe);
    }
    let blood = SurrogateBlood {
        density: case.blood.density,
        viscosity: case.blood.viscosity,
        time_step: case.time.step,
        radial_inertia: true,
    };
    Ok(Box::new(TubeSurrogate::new(
        sections, &answers, blood, inlet, outlet,
    )))
}

/// What happens at the ends of the tube, behind rigid pieces of these lengths (m).
fn ends(vessel: &BloodVessel, before: f64, behind: f64) -> (End, End) {
    let inlet = vessel.inlet.as_ref().and_then(|inlet| inlet.condition);
    let inlet = match inlet.unwrap_or_default() {
        InletCondition::Flow => End::Flow,
        InletCondition::Pressure => End::Pressure {
            rigid_length: before,
        },
    };
    let OutletElements { proximal, distal } = vessel.outlet_elements();
    let outlet = match (vessel.outlet_condition(), distal) {
        (OutletCondition::Pressure, _) => End::Pressure {
            rigid_length: behind,
        },
        (_, None) => End::Resistance {
            resistance: proximal,
            rigid_length: behind,
        },
        (_, Some((resistance, compliance))) => End::Windkessel {
            proximal,
            resistance,
            compliance,
            rigid_length: 0.0,
        },
    };
    (inlet, outlet)
}

/// The sections of the surrogate of a case whose wall has these `points` (m): one for each ring of points between the
/// ends, or for every other one if they are many; fewer if they are uneven.
pub fn sections(
    vessel: &BloodVessel,
    solver: Solver,
    points: &[Vec3],
) -> Result<Sections, SparseSection> {
    let (geometry, fluid) = (Vessel::new(vessel), &vessel.fluid);
    let axis = Axis {
        line: geometry.centre_line().clone(),
        length: geometry.end(),
    };
    let along = match solver {
        Solver::OpenFoam => elastic_pieces(&geometry.spans(&fluid.mesh)).len(),
        Solver::Native => {
            elastic_pieces(&geometry.spans(&fluid.native)).len() * fluid.native.degree
        }
        // Whose rings are not known: as many as there may be, fewer where those are too many.
        Solver::External => MOST_RINGS + 1,
    };
    let rings = along - 1;
    let half = rings.div_ceil(2);
    let mut count = if rings > MOST_RINGS { half } else { rings };
    loop {
        match Sections::new(points, axis.clone(), count) {
            Err(_) if count > 1 => count = count.div_ceil(2),
            sections => return sections,
        }
    }
}
