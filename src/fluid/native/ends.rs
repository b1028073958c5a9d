//! What is prescribed where the blood enters and leaves: a flow with a profile, a share of the flow, or a pressure
//! `a + b Q`.

use super::open_inflow::{OpenEnd, OpenInflow};
use super::spectral_elements::SpectralElements;
use super::taylor_hood_space::{Boundary, Face};
use super::time_scheme::Weights;
use crate::Vec3;
use crate::case::{
    Case, Condition, FlowCurve, InletProfile, Opening, PressureModel, Ramp, VesselSide,
};
use crate::fluid::inlet_velocity::InletVelocity;
use crate::geometry::Vessel;
use std::f64::consts::PI;

/// An opening of the vessel.
pub struct NativeOpening {
    /// Its name.
    pub name: String,
    /// At which end of the vessel it is.
    pub side: VesselSide,
    /// Its faces.
    pub faces: Vec<Face>,
    /// What is prescribed.
    pub condition: NativeCondition,
}

/// What is prescribed at an opening.
pub enum NativeCondition {
    /// A flow.
    Flow(FlowInlet),
    /// This share of what enters leaves.
    FlowSplit(f64, FlowInlet),
    /// A pressure.
    Pressure(PressureModel),
}

impl NativeOpening {
    /// The part of the boundary through which fluid comes and goes under a pressure, if it is one.
    pub fn open(&self) -> Option<OpenEnd> {
        match &self.condition {
            NativeCondition::Flow(_) | NativeCondition::FlowSplit(..) => None,
            NativeCondition::Pressure(_) => Some(OpenEnd {
                faces: self.faces.clone(),
                inflow: match self.side {
                    VesselSide::Start => OpenInflow::AlongNormal,
                    VesselSide::End => OpenInflow::NoEnergy,
                },
            }),
        }
    }
}

/// A prescribed flow. Fields hold a velocity into the vessel on the opening, one component after the other, zero
/// elsewhere and on its rim.
pub struct FlowInlet {
    curve: FlowCurve,
    velocity: InletVelocity,
    /// Velocity for a flow of 1 m³/s that is not among the terms.
    rest: Vec<f64>,
    /// Velocity of each term (m/s) while its factor is 1, and the flow that it brings, m³/s.
    terms: Vec<(Vec<f64>, f64)>,
}

/// An opening in a mesh.
struct MeshedOpening<'a> {
    /// That of which it is an end; of a tree it is a disc.
    vessel: Option<&'a Vessel>,
    end: VesselSide,
    space: &'a SpectralElements,
    faces: Vec<Face>,
    walls: &'a [Face],
    /// Of the nodes, m.
    positions: &'a [f64],
    /// Kinematic viscosity, m²/s.
    viscosity: f64,
}

impl FlowInlet {
    fn new(curve: FlowCurve, profile: InletProfile, at: &MeshedOpening<'_>) -> Self {
        let (space, positions) = (at.space, at.positions);
        let nodes = space.space.nodes;
        let mut flux = vec![0.0; 3 * nodes];
        let (mut area, mut moment) = (Vec3::zeros(), Vec3::zeros());
        for &face in &at.faces {
            let points = space.face_points(face, positions);
            area += points.areas.iter().sum::<Vec3>();
            let places = space.face_field(&points.nodes, positions);
            moment += places
                .iter()
                .zip(&points.areas)
                .map(|(x, area)| x * area.norm())
                .sum::<Vec3>();
            space.add_face_load(&points.nodes, &points.areas, &mut flux);
        }
        let (inward, area) = (-area.normalize(), area.norm());
        let radius = (area / PI).sqrt();
        let velocity = InletVelocity::new(profile, &curve, radius, at.viscosity);
        let share = |x: &Vec3| match at.vessel {
            Some(vessel) => vessel.opening_share(at.end, x),
            None => (x - moment / area).norm() / radius,
        };
        let rim = space.space.nodes_of(at.walls);
        let inner: Vec<(usize, f64)> = (space.space.nodes_of(&at.faces).into_iter())
            .filter(|node| rim.binary_search(node).is_err())
            .map(|node| (node, share(&space.vector(positions, node))))
            .collect();
        let field = |at: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let mut field = vec![0.0; 3 * nodes];
            for (i, &(node, _)) in inner.iter().enumerate() {
                for c in 0..3 {
                    field[c * nodes + node] = at(i) * inward[c];
                }
            }
            field
        };
        let flow = |field: &[f64]| -field.iter().zip(&flux).map(|(u, q)| u * q).sum::<f64>();
        let mut rest = field(&|i| velocity.rest(inner[i].1));
        let of_rest = flow(&rest);
        rest.iter_mut().for_each(|u| *u /= of_rest);
        let of_nodes: Vec<Vec<f64>> = inner
            .iter()
            .map(|(_, share)| velocity.terms(*share))
            .collect();
        let terms = (0..velocity.factors(0.0).len())
            .map(|k| {
                let field = field(&|i| of_nodes[i][k] / area);
                let flow = flow(&field);
                (field, flow)
            })
            .collect();
        Self {
            curve,
            velocity,
            rest,
            terms,
        }
    }

    /// Flow (m³/s) at a time (s), before the ramp.
    fn flow(&self, t: f64) -> f64 {
        self.curve.flow(t)
    }

    /// Adds the velocity (m/s) of a flow (m³/s).
    fn add_flow(&self, flow: f64, field: &mut [f64]) {
        for (u, shape) in field.iter_mut().zip(&self.rest) {
            *u += flow * shape;
        }
    }

    /// Adds the velocity (m/s) at a time (s), times `share`.
    fn add_velocity(&self, t: f64, share: f64, field: &mut [f64]) {
        let factors = self.velocity.factors(t);
        let of_terms: f64 = (self.terms.iter().zip(&factors))
            .map(|((_, flow), factor)| flow * factor)
            .sum();
        let rest = share * (self.curve.flow(t) - of_terms);
        for (u, shape) in field.iter_mut().zip(&self.rest) {
            *u += rest * shape;
        }
        for ((term, _), factor) in self.terms.iter().zip(&factors) {
            for (u, shape) in field.iter_mut().zip(term) {
                *u += share * factor * shape;
            }
        }
    }
}

/// What is prescribed at an opening at the end of a step.
#[derive(Debug, Clone, Copy)]
pub enum OpeningCondition {
    /// A flow into the vessel, m³/s.
    Flow(f64),
    /// A pressure downstream of the proximal resistance, if there is one: a constant (Pa), and a part for each unit of
    /// outflow, Pa s/m³.
    Downstream([f64; 2]),
}

/// A step, for what is prescribed at its end.
pub struct Coming<'a> {
    /// Its end, s.
    pub time: f64,
    /// Of the backward difference.
    pub weights: Weights,
    /// Pressures downstream of each opening at the ends of the last step and of the one before, Pa.
    pub downstream: &'a [[f64; 2]],
    /// Rate (m³/s) at which the vessel makes room.
    pub growth: &'a dyn Fn() -> f64,
}

/// Pressure downstream of the proximal resistance of a model at the end of a step that ends at the time `t` (s): a
/// constant (Pa), and a part for each unit of outflow (Pa s/m³). `last` are the pressures at the ends of the last step
/// and of the one before.
fn downstream(model: &PressureModel, t: f64, w: Weights, last: [f64; 2]) -> [f64; 2] {
    let Some((resistance, compliance)) = model.distal else {
        return [model.downstream.pressure(t), 0.0];
    };
    let [last, previous] = last;
    let per_flow = 1.0 / (compliance * w.new + 1.0 / resistance);
    let constant = -compliance * (w.old * last + w.older * previous) * per_flow;
    [constant, per_flow]
}

/// The openings, and their smooth start.
pub struct NativeOpenings {
    /// The openings, those at starts first.
    pub openings: Vec<NativeOpening>,
    ramp: Ramp,
    /// Whether the pressures are ramped from zero as the inflow is; if not, from that of the equilibrium (Pa) at the
    /// start.
    equilibrium: Option<f64>,
}

impl NativeOpenings {
    /// Those of a case, each with the number of the end of the mesh that it is; the nodes lie at `positions` (m).
    /// `equilibrium` is the pressure (Pa) of the equilibrium in which the run starts.
    pub fn new(
        case: &Case,
        openings: Vec<(Opening, usize)>,
        equilibrium: Option<f64>,
        space: &SpectralElements,
        walls: &[Face],
        positions: &[f64],
    ) -> Self {
        let vessel = case.vessel().map(Vessel::new);
        let end = |(opening, end): (Opening, usize)| {
            let place = MeshedOpening {
                vessel: vessel.as_ref(),
                end: opening.end,
                space,
                faces: space.space.faces_of(|face| face == Boundary::End(end)),
                walls,
                positions,
                viscosity: case.blood.viscosity / case.blood.density,
            };
            let condition = match opening.condition {
                Condition::Flow(curve, profile) => {
                    NativeCondition::Flow(FlowInlet::new(curve, profile, &place))
                }
                Condition::FlowSplit(fraction) => {
                    let none = FlowCurve::none(case.time.period);
                    let outlet = FlowInlet::new(none, InletProfile::Plug, &place);
                    NativeCondition::FlowSplit(fraction, outlet)
                }
                Condition::Pressure(model) => NativeCondition::Pressure(model),
            };
            NativeOpening {
                name: opening.name,
                side: opening.end,
                faces: place.faces,
                condition,
            }
        };
        Self {
            openings: openings.into_iter().map(end).collect(),
            ramp: case.ramp.clone(),
            equilibrium,
        }
    }

    /// Pressures downstream of the openings at t = 0, before any ramp, twice (Pa); 0 where there is none.
    pub fn downstream_at_start(&self) -> Vec<[f64; 2]> {
        let ends = self.openings.iter();
        ends.map(|end| match &end.condition {
            NativeCondition::Pressure(model) => [model.initial; 2],
            NativeCondition::Flow(_) | NativeCondition::FlowSplit(..) => [0.0; 2],
        })
        .collect()
    }

    /// What is prescribed at each opening at the end of a step.
    pub fn prescribed(&self, step: &Coming<'_>) -> Vec<OpeningCondition> {
        let ends = self.openings.iter().zip(step.downstream);
        ends.map(|(end, &last)| match &end.condition {
            NativeCondition::Flow(inlet) => {
                OpeningCondition::Flow(self.flow_share(step.time) * inlet.flow(step.time))
            }
            // A share f of the inflow Q leaves, and the rest is what the vessel takes in: Q = f Q + dV/dt.
            NativeCondition::FlowSplit(fraction, _) => {
                OpeningCondition::Flow(-fraction / (1.0 - fraction) * (step.growth)())
            }
            NativeCondition::Pressure(model) => {
                OpeningCondition::Downstream(downstream(model, step.time, step.weights, last))
            }
        })
        .collect()
    }

    /// Adds the velocities (m/s) of what is `prescribed` at the time `t` (s) to a field; gives the pressures that act
    /// at the open ends, in their order.
    pub fn apply(
        &self,
        prescribed: &[OpeningCondition],
        t: f64,
        field: &mut [f64],
    ) -> Vec<[f64; 2]> {
        let mut pressures = Vec::new();
        for (end, prescribed) in self.openings.iter().zip(prescribed) {
            match (&end.condition, prescribed) {
                (NativeCondition::Flow(inlet), _) => {
                    inlet.add_velocity(t, self.flow_share(t), field);
                }
                (NativeCondition::FlowSplit(_, outlet), OpeningCondition::Flow(flow)) => {
                    outlet.add_flow(*flow, field);
                }
                (NativeCondition::Pressure(model), OpeningCondition::Downstream(downstream)) => {
                    let of_model = [downstream[0], downstream[1] + model.proximal];
                    pressures.push(self.acting(end.side, t, of_model));
                }
                _ => unreachable!("a pressure or a flow"),
            }
        }
        pressures
    }

    /// Pressure (Pa) at an opening with this outflow (m³/s) and this pressure (Pa) downstream at a time (s), where it
    /// is prescribed to the last digit: at an end of the vessel.
    pub fn pressure_at(
        &self,
        end: &NativeOpening,
        t: f64,
        downstream: f64,
        out: f64,
    ) -> Option<f64> {
        match (&end.condition, end.side) {
            (NativeCondition::Pressure(model), VesselSide::End) => {
                let at_end = [downstream + model.proximal * out, 0.0];
                Some(self.acting(end.side, t, at_end)[0])
            }
            _ => None,
        }
    }

    /// Share of prescribed flows that acts at a time (s).
    fn flow_share(&self, t: f64) -> f64 {
        self.ramp.factor(t)
    }

    /// What of a pressure (Pa), a constant and a part for each unit of outflow, acts at an opening at a time (s): with
    /// a start in equilibrium all of it at an end of the vessel; at a start it rises from that of the equilibrium.
    fn acting(&self, side: VesselSide, t: f64, [constant, per_flow]: [f64; 2]) -> [f64; 2] {
        let (start, share) = match (self.equilibrium, side) {
            (Some(_), VesselSide::End) => return [constant, per_flow],
            (start, _) => (start.unwrap_or(0.0), self.ramp.factor(t)),
        };
        [start + share * (constant - start), share * per_flow]
    }
}
