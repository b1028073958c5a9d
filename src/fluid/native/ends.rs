//! What is prescribed where the blood enters and leaves: flow with a profile or pressure at the inlet; a windkessel, a
//! resistance or a pressure at the outlet.

use super::FlowError;
use super::spectral_elements::SpectralElements;
use super::taylor_hood_space::Face;
use super::time_scheme::Weights;
use crate::Vec3;
use crate::case::{BloodVessel, Case, FlowCurve, OutletElements, PressureCurve, Ramp, Start};
use crate::fluid::inlet_velocity::InletVelocity;
use crate::geometry::Vessel;
use std::f64::consts::PI;

/// What drives the blood at the inlet.
pub enum NativeInlet {
    /// A flow.
    Flow(FlowInlet),
    /// A static pressure.
    Pressure(PressureCurve),
}

/// A prescribed flow. Fields hold a velocity into the vessel on the inlet, one component after the other, zero
/// elsewhere and on its rim.
pub struct FlowInlet {
    curve: FlowCurve,
    velocity: InletVelocity,
    /// Velocity for a flow of 1 m³/s that is not among the terms.
    rest: Vec<f64>,
    /// Velocity of each term (m/s) while its factor is 1, and the flow that it brings, m³/s.
    terms: Vec<(Vec<f64>, f64)>,
}

impl FlowInlet {
    /// For the faces of the inlet of a mesh whose nodes lie at `positions` (m).
    fn new(
        case: &Case,
        vessel: &BloodVessel,
        space: &SpectralElements,
        inlet: &[Face],
        walls: &[Face],
        positions: &[f64],
    ) -> Result<Self, FlowError> {
        let curve = FlowCurve::new(&vessel.inflow, case.time.period)
            .map_err(|error| FlowError::Model(error.to_string()))?;
        let nodes = space.space.nodes;
        let mut flux = vec![0.0; 3 * nodes];
        let mut area = Vec3::zeros();
        for &face in inlet {
            let points = space.face_points(face, positions);
            area += points.areas.iter().sum::<Vec3>();
            space.add_face_load(&points.nodes, &points.areas, &mut flux);
        }
        let (inward, area) = (-area.normalize(), area.norm());
        let velocity = InletVelocity::new(
            vessel.inlet_profile(),
            &curve,
            (area / PI).sqrt(),
            case.blood.viscosity / case.blood.density,
        );
        let geometry = Vessel::new(vessel);
        let rim = space.space.nodes_of(walls);
        let inner: Vec<(usize, f64)> = (space.space.nodes_of(inlet).into_iter())
            .filter(|node| rim.binary_search(node).is_err())
            .map(|node| (node, geometry.inlet_share(&space.vector(positions, node))))
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
        Ok(Self {
            curve,
            velocity,
            rest,
            terms,
        })
    }

    /// Flow (m³/s) at a time (s), before the ramp.
    pub fn flow(&self, t: f64) -> f64 {
        self.curve.flow(t)
    }

    /// Adds the velocity (m/s) at a time (s), times `share`.
    pub fn add_velocity(&self, t: f64, share: f64, field: &mut [f64]) {
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

/// What the blood finds at the outlet: `p + R_p Q` with the pressure `p` of the windkessel `C dp/dt + p/R = Q`, or with
/// a prescribed one.
pub struct NativeOutlet {
    elements: OutletElements,
    pressure: PressureCurve,
}

impl NativeOutlet {
    /// Pressure behind the proximal resistance at the end of a step that ends at the time `t` (s): a constant (Pa), and
    /// a part for each unit of outflow (Pa s/m³). `last` are the pressures at the ends of the last step and of the one
    /// before.
    pub fn behind(&self, t: f64, w: Weights, last: [f64; 2]) -> [f64; 2] {
        let Some((resistance, compliance)) = self.elements.distal else {
            return [self.pressure.pressure(t), 0.0];
        };
        let [last, before] = last;
        let per_flow = 1.0 / (compliance * w.new + 1.0 / resistance);
        let constant = -compliance * (w.old * last + w.older * before) * per_flow;
        [constant, per_flow]
    }

    /// Resistance between the outlet and that pressure, Pa s/m³.
    pub fn proximal(&self) -> f64 {
        self.elements.proximal
    }
}

/// Inlet and outlet, and the smooth start of both.
pub struct Ends {
    /// The inlet.
    pub inlet: NativeInlet,
    /// The outlet.
    pub outlet: NativeOutlet,
    ramp: Ramp,
    /// Whether the pressures are ramped from zero as the inflow is; if not, from that of the equilibrium (Pa) at the
    /// start.
    equilibrium: Option<f64>,
}

impl Ends {
    /// Those of a case, for the faces of inlet and walls of a mesh whose nodes lie at `positions` (m).
    ///
    /// # Errors
    /// If a curve cannot be read.
    pub fn new(
        case: &Case,
        vessel: &BloodVessel,
        space: &SpectralElements,
        inlet: &[Face],
        walls: &[Face],
        positions: &[f64],
    ) -> Result<Self, FlowError> {
        let period = case.time.period;
        let unreadable = |error: crate::case::TableError| FlowError::Model(error.to_string());
        Ok(Self {
            inlet: match vessel.inlet_pressure(period).map_err(unreadable)? {
                Some(pressure) => NativeInlet::Pressure(pressure),
                None => {
                    let inlet = FlowInlet::new(case, vessel, space, inlet, walls, positions)?;
                    NativeInlet::Flow(inlet)
                }
            },
            outlet: NativeOutlet {
                elements: vessel.outlet_elements(),
                pressure: vessel.outlet_pressure(period).map_err(unreadable)?,
            },
            ramp: case.ramp.clone(),
            equilibrium: (vessel.start() == Start::Equilibrium)
                .then(|| vessel.equilibrium_pressure()),
        })
    }

    /// Share of the inflow that acts at a time (s).
    pub fn inflow_share(&self, t: f64) -> f64 {
        self.ramp.factor(t)
    }

    /// Share of the outlet's pressure that acts at a time (s).
    pub fn outlet_share(&self, t: f64) -> f64 {
        match self.equilibrium {
            None => self.ramp.factor(t),
            Some(_) => 1.0,
        }
    }

    /// The prescribed pressure (Pa) at the inlet at a time (s), of the curve's value then.
    pub fn inlet_pressure(&self, t: f64, of_curve: f64) -> f64 {
        let start = self.equilibrium.unwrap_or(0.0);
        start + self.ramp.factor(t) * (of_curve - start)
    }
}
