//! The sizes of a case's flow, and of its meshes, before it is computed.

use crate::case::{BloodVessel, Case, Solver, VesselSide};
use crate::fluid::native::vessel_mesh::element_widths;
use crate::geometry::{Vessel, cell_widths};
use crate::hemodynamics::FlowNumbers;
use crate::hemodynamics::resolution::{FlowSetting, PointSpacing};

/// Of a case whose flow is prescribed; none of others.
pub fn flow_numbers(case: &Case) -> Option<FlowNumbers> {
    let vessel = case.vessel()?;
    let inlet = vessel.prescribed_at(VesselSide::Start, case.time.period);
    let samples: Vec<[f64; 2]> = (inlet.ok()?.flow()?).samples(case.time.step).collect();
    flow_numbers_of(case, &samples)
}

/// Of a case with this flow, pairs of time (s) and flow (m³/s); none if it is not a vessel, or nothing flows.
pub fn flow_numbers_of(case: &Case, samples: &[[f64; 2]]) -> Option<FlowNumbers> {
    let keys = case.vessel()?;
    let vessel = Vessel::new(keys);
    let setting = FlowSetting {
        viscosity: case.blood.viscosity / case.blood.density,
        time_step: case.time.step,
        period: case.time.period,
        scheme: case.time.scheme,
        spacing: spacing(keys, case.fluid.solver),
        cells: vessel.spans(&keys.fluid.mesh),
        vessel: &vessel,
    };
    FlowNumbers::new(&setting, samples)
}

fn spacing(vessel: &BloodVessel, solver: Solver) -> Option<PointSpacing> {
    let native = &vessel.fluid.native;
    let (widths, has_elements) = match solver {
        Solver::OpenFoam => (cell_widths(&vessel.fluid.mesh), false),
        Solver::Native => {
            let widths = element_widths(native.core, native.radial);
            (widths.map(|width| width / native.degree as f64), true)
        }
        Solver::External => return None,
    };
    let [across, at_wall] = widths;
    Some(PointSpacing {
        across,
        at_wall,
        has_elements,
    })
}
