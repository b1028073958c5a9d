//! The surrogate of a case: a one-dimensional tube whose wall yields as the structure does.

use crate::Vec3;
use crate::case::{self, Case};
use crate::coupling::acceleration::surrogate::{Axis, Blood, End, Sections, TubeSurrogate};
use crate::coupling::acceleration::{Identity, Surrogate};
use crate::coupling::flatten;
use crate::coupling::transfer::Transfer;
use crate::fluid::FluidInterface;
use crate::pfem::{Solid, SurfaceLoad};

/// Uniform pressure (Pa) that probes the wall: far above round-off, far below what makes the wall nonlinear.
const PROBE: f64 = 100.0;
/// The stiffness of a section is at most this many times the smallest one: next to a clamped end hardly anything moves.
const STIFFEST: f64 = 1e3;

/// The surrogate that the case asks for. The stiffness of each section is what a first time step of `solid`, which is at
/// rest, answers to a uniform pressure: inertia included.
pub fn surrogate<S: Solid>(
    case: &Case,
    interface: &FluidInterface,
    solid: &mut S,
    transfer: &Transfer<S::Location>,
) -> Result<Box<dyn Surrogate>, String> {
    let g = &case.geometry;
    let open = |rigid_length| End::Pressure { rigid_length };
    let (inlet, outlet) = match case.coupling.surrogate {
        case::Surrogate::None => return Ok(Box::new(Identity)),
        case::Surrogate::Tube => {
            let windkessel = End::Windkessel {
                resistance: case.windkessel.resistance,
                compliance: case.windkessel.compliance,
                rigid_length: 0.0,
            };
            (End::Flow, windkessel)
        }
        case::Surrogate::OpenTube => (open(g.extension_length), open(0.0)),
    };
    // The deformable part is straight in all models.
    let axis = Axis {
        origin: Vec3::zeros(),
        direction: Vec3::x(),
    };
    // Two rings of wall points a section.
    let count = case.fluid.mesh.axial_per_section;
    let sections = Sections::new(&interface.points, axis, count).map_err(|e| e.to_string())?;

    let points = solid.wet_points().len();
    let probe = SurfaceLoad {
        pressure: vec![PROBE; points],
        shear: vec![Vec3::zeros(); points],
    };
    let tolerance = case.structure.newton_tolerance.max(1e-6);
    let trial = solid
        .solve(&probe, case.time.step, tolerance, None)
        .map_err(|e| e.to_string())?;
    let widening = sections.average(&flatten(&transfer.displacement(solid, &trial)));
    let widest = widening.iter().copied().fold(0.0, f64::max);
    let stiffness = widening
        .iter()
        .map(|x| PROBE / x.max(widest / STIFFEST))
        .collect();
    let blood = Blood {
        density: case.blood.density,
        viscosity: case.blood.viscosity,
        time_step: case.time.step,
        radial_inertia: true,
    };
    Ok(Box::new(TubeSurrogate::new(
        sections, stiffness, blood, inlet, outlet,
    )))
}
