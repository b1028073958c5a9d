//! Area-averaged flow in a tube whose wall moves in a prescribed way.
//!
//! ```text
//! mass       dA/dt + dQ/dx = 0
//! momentum   dQ/dt + d(Q²/A)/dx + A/rho dp/dx + 8 pi nu Q/A = 0
//! ```
//! (Hughes and Lubliner 1973; the tube as test of coupling schemes: Degroote, Bruggeman, Haelterman and Vierendeels
//! 2008.) Implicit Euler, staggered: areas and pressures in the middle of n cells, flows at their n + 1 ends. As in
//! any incompressible fluid in a moving wall, the areas alone fix the flow but for one number, the inflow.

use nalgebra::{Complex, ComplexField};
use std::f64::consts::PI;

/// A real number, or a complex one whose imaginary part carries a derivative (Squire and Trapp 1998).
pub trait Number: ComplexField<RealField = f64> + Copy {}
impl<T: ComplexField<RealField = f64> + Copy> Number for T {}

/// Step of the complex-step derivative: so small that its square vanishes.
pub const COMPLEX_STEP: f64 = 1e-200;

/// What drives the flow at the inlet, as function of time.
#[derive(Debug, Clone, Copy)]
pub enum Inlet {
    /// Flow, m³/s.
    Flow(fn(f64) -> f64),
    /// Pressure, Pa.
    Pressure(fn(f64) -> f64),
}

/// The outlet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outlet {
    /// A fixed pressure, Pa.
    Pressure(f64),
    /// `C dp/dt + p/R = Q`.
    Windkessel {
        /// R, Pa s/m³.
        resistance: f64,
        /// C, m³/Pa.
        compliance: f64,
    },
}

/// Constants of the flow.
#[derive(Debug, Clone, Copy)]
pub struct TubeFluid {
    /// Density, kg/m³.
    pub density: f64,
    /// Kinematic viscosity, m²/s.
    pub viscosity: f64,
    /// Time step, s.
    pub time_step: f64,
    /// Length of a cell, m.
    pub cell: f64,
    /// Inlet.
    pub inlet: Inlet,
    /// Outlet.
    pub outlet: Outlet,
}

/// The flow at the end of the last accepted time step; starts at rest.
#[derive(Debug, Clone)]
pub struct Flow {
    /// Constants.
    pub fluid: TubeFluid,
    /// Time, s.
    time: f64,
    /// Areas of the cells, m².
    area: Vec<f64>,
    /// Flows between the cells, m³/s.
    flow: Vec<f64>,
    /// Pressure at the outlet, Pa.
    outlet_pressure: f64,
}

/// A trial of the next time step.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowTrial {
    /// Areas of the cells, m².
    pub area: Vec<f64>,
    /// Flows between the cells, m³/s.
    pub flow: Vec<f64>,
    /// Pressures in the cells, Pa.
    pub pressure: Vec<f64>,
}

impl Flow {
    /// Blood at rest in a tube with these radii (m).
    pub fn at_rest(fluid: TubeFluid, radius: &[f64]) -> Self {
        Self {
            fluid,
            time: 0.0,
            area: radius.iter().map(|r| PI * r * r).collect(),
            flow: vec![0.0; radius.len() + 1],
            outlet_pressure: 0.0,
        }
    }

    /// The flow through the tube of the given radii at the end of the next step.
    pub fn solve(&self, radius: &[f64]) -> FlowTrial {
        let area: Vec<f64> = radius.iter().map(|r| PI * r * r).collect();
        let time = self.time + self.fluid.time_step;
        let inflow = match self.fluid.inlet {
            Inlet::Flow(flow) => flow(time),
            Inlet::Pressure(pressure) => self.inflow(&area, pressure(time)),
        };
        let (flow, pressure, _) = self.profile(&area, inflow);
        FlowTrial {
            area,
            flow,
            pressure,
        }
    }

    /// Accepts the trial.
    pub fn accept(&mut self, trial: FlowTrial) {
        let outflow = *trial.flow.last().expect("a tube has ends");
        self.outlet_pressure = self.downstream_pressure(outflow);
        self.time += self.fluid.time_step;
        (self.area, self.flow) = (trial.area, trial.flow);
    }

    /// The inflow that makes the pressure at the inlet `pressure`, by Newton's method.
    fn inflow(&self, area: &[f64], pressure: f64) -> f64 {
        let area: Vec<_> = area.iter().map(|a| Complex::from_real(*a)).collect();
        let mut inflow = self.flow[0];
        for _ in 0..30 {
            let (_, _, inlet) = self.profile(&area, Complex::new(inflow, COMPLEX_STEP));
            let change = (pressure - inlet.re) / (inlet.im / COMPLEX_STEP);
            inflow += change;
            if change.abs() <= 1e-14 * inflow.abs() {
                break;
            }
        }
        inflow
    }

    /// Flows, pressures and the pressure at the inlet for a given inflow: mass from the inlet to the outlet, then
    /// momentum back.
    fn profile<T: Number>(&self, area: &[T], inflow: T) -> (Vec<T>, Vec<T>, T) {
        let n = area.len();
        let mut flow = vec![inflow];
        for i in 0..n {
            flow.push(flow[i] - self.storage(i, area));
        }
        let mut downstream = self.downstream_pressure(flow[n]);
        let mut pressure = vec![downstream; n];
        for i in (1..=n).rev() {
            downstream += self.drop(i, area, &flow);
            pressure[i - 1] = downstream;
        }
        let inlet = downstream + self.drop(0, area, &flow);
        (flow, pressure, inlet)
    }

    /// What cell `i` takes up: inflow less outflow, m³/s.
    pub fn storage<T: Number>(&self, i: usize, area: &[T]) -> T {
        (area[i] - real(self.area[i])) * real(self.fluid.cell / self.fluid.time_step)
    }

    /// Pressure upstream less pressure downstream of the cell end `i`, Pa: from the middle of a cell to the middle of
    /// the next, half a cell at inlet and outlet.
    pub fn drop<T: Number>(&self, i: usize, area: &[T], flow: &[T]) -> T {
        let n = area.len();
        let momentum = |cell: usize| {
            let q = (flow[cell] + flow[cell + 1]) * real(0.5);
            q * q / area[cell]
        };
        let through = |section: T| flow[i] * flow[i] / section;
        let (length, section, gain) = if i == 0 {
            (0.5, area[0], momentum(0) - through(area[0]))
        } else if i == n {
            (0.5, area[n - 1], through(area[n - 1]) - momentum(n - 1))
        } else {
            let section = (area[i - 1] + area[i]) * real(0.5);
            (1.0, section, momentum(i) - momentum(i - 1))
        };
        let length: T = real(length * self.fluid.cell);
        let acceleration = (flow[i] - real(self.flow[i])) * real(1.0 / self.fluid.time_step);
        let friction = flow[i] / section * real(8.0 * PI * self.fluid.viscosity);
        (length * (acceleration + friction) + gain) / section * real(self.fluid.density)
    }

    /// Pressure downstream of the outlet for an outflow, Pa.
    pub fn downstream_pressure<T: Number>(&self, outflow: T) -> T {
        match self.fluid.outlet {
            Outlet::Pressure(pressure) => real(pressure),
            Outlet::Windkessel {
                resistance,
                compliance,
            } => {
                let capacity = compliance / self.fluid.time_step;
                (outflow + real(capacity * self.outlet_pressure))
                    * real(1.0 / (capacity + 1.0 / resistance))
            }
        }
    }

    /// The inlet's condition at the end of the next step, as an equation to be zero.
    pub fn inlet_balance<T: Number>(&self, area: &[T], flow: &[T], pressure: &[T]) -> T {
        let time = self.time + self.fluid.time_step;
        match self.fluid.inlet {
            Inlet::Flow(prescribed) => flow[0] - real(prescribed(time)),
            Inlet::Pressure(prescribed) => {
                real::<T>(prescribed(time)) - pressure[0] - self.drop(0, area, flow)
            }
        }
    }
}

/// A real number as `T`.
pub fn real<T: Number>(x: f64) -> T {
    T::from_real(x)
}
