//! What holds the wall of a vessel: its ends, and the tissue around it.

use crate::Vec3;
use crate::case::{BloodVessel, InletEnd, VesselEnd};
use crate::curve::{NearestPoint, SpaceCurve};
use crate::pfem::supports::{
    Axis, AxisPoint, Direction, Foundation, PressureAround, Profile, Support, on_springs, sliding,
    sliding_radially,
};
use std::sync::Arc;

/// The axis of a vessel with this centre-line.
#[derive(Debug)]
pub struct AlongLine(pub SpaceCurve);

impl Axis for AlongLine {
    fn nearest(&self, x: &Vec3) -> AxisPoint {
        axis_point(&self.0.nearest(x))
    }
}

/// A place on a centre-line as one on an axis.
pub fn axis_point(nearest: &NearestPoint) -> AxisPoint {
    AxisPoint {
        s: nearest.s,
        position: nearest.frame.origin,
        tangent: nearest.frame.tangent,
    }
}

/// What holds the wall of a vessel with this centre-line: its ends, and the tissue around it.
pub fn of_vessel(vessel: &BloodVessel, line: &SpaceCurve) -> Vec<Support> {
    if vessel.is_rigid() {
        // The lumen holds, and what is around it stays with it.
        return ["start", "inner", "end"]
            .map(|name| Support::Clamped(name.into()))
            .into();
    }
    let mut supports = match vessel.inlet_end() {
        InletEnd::Clamped => vec![Support::Clamped("start".into())],
        InletEnd::Sliding => vec![sliding("start")],
        InletEnd::Radial => sliding_radially("start").into(),
    };
    let (outlet, spring) = vessel.outlet_end();
    match outlet {
        VesselEnd::Clamped => supports.push(Support::Clamped("end".into())),
        VesselEnd::Sliding => supports.push(sliding("end")),
        VesselEnd::Radial => supports.extend(sliding_radially("end")),
        VesselEnd::Springs => supports.push(on_springs("end", spring)),
    }
    supports.extend(tissue(vessel, line).into_iter().map(Support::Foundation));
    supports
}

/// The springs and dampers around a vessel with this centre-line: of one direction, and of their own along the axis.
pub fn tissue(vessel: &BloodVessel, line: &SpaceCurve) -> Vec<Foundation> {
    let Some(tissue) = &vessel.surroundings else {
        return Vec::new();
    };
    let axis = axis(line);
    let direction = tissue.direction.unwrap_or_default().into();
    let kinds = [
        (direction, tissue.spring, tissue.damping),
        (Direction::Axial, tissue.axial_spring, tissue.axial_damping),
    ];
    let foundation = |(direction, spring, damping)| Foundation {
        surface: "outer".into(),
        spring: Profile(vessel.along(spring)),
        damping: Profile(vessel.along(damping)),
        direction,
        at_rest: tissue.at_rest.unwrap_or_default().into(),
        axis: axis.clone(),
    };
    let all = kinds.into_iter().map(foundation);
    let none = Profile::default();
    all.filter(|tissue| tissue.spring != none || tissue.damping != none)
        .collect()
}

/// Whether the elastic part of a vessel, from the arc length 0 on, lies on the x-axis.
pub fn is_x_axis(line: &SpaceCurve) -> bool {
    let knots: Vec<f64> = line.knots().into_iter().filter(|s| *s >= 0.0).collect();
    let middles = knots.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let mut places = middles.chain(knots.iter().copied());
    places.all(|s| {
        let frame = line.frame(s);
        frame.tangent == Vec3::x() && frame.origin == Vec3::new(s, 0.0, 0.0)
    })
}

/// The axis along which values around a vessel with this centre-line are told, if it is not the x-axis.
fn axis(line: &SpaceCurve) -> Option<Arc<dyn Axis>> {
    (!is_x_axis(line)).then(|| Arc::new(AlongLine(line.clone())) as Arc<dyn Axis>)
}

/// Pressure on the outer surface of a vessel with this centre-line, if there is any.
pub fn pressure_around(vessel: &BloodVessel, line: &SpaceCurve) -> Option<PressureAround> {
    let pressure = vessel.surroundings.as_ref()?.pressure;
    let pressure = Profile(vessel.along(pressure));
    (pressure != Profile::default()).then(|| PressureAround {
        pressure,
        axis: axis(line),
    })
}
