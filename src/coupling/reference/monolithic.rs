//! Flow and wall of the tube solved together by Newton's method.

use super::flow::{COMPLEX_STEP, FlowTrial, Number, real};
use super::{Flow, StringWall};
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::PI;

/// Radial displacements, pressures and flows as one vector of unknowns.
pub struct Monolithic {
    /// The flow.
    pub flow: Flow,
    /// The wall.
    pub wall: StringWall,
    /// Radii at rest, m.
    pub radius: Vec<f64>,
    /// Solution of the last step: n displacements, n pressures, n + 1 flows, each in a unit that makes it about 1.
    unknowns: DVector<f64>,
}

/// Units of the unknowns: m, Pa, m³/s.
const UNITS: [f64; 3] = [1e-4, 1e3, 1e-6];

impl Monolithic {
    /// The tube at rest.
    pub fn new(flow: Flow, wall: StringWall, radius: Vec<f64>) -> Self {
        let unknowns = DVector::zeros(3 * radius.len() + 1);
        Self {
            flow,
            wall,
            radius,
            unknowns,
        }
    }

    /// The equations at the end of the next step: balance of each ring, mass of each cell, momentum at the ends of
    /// the cells, and the conditions at inlet and outlet.
    fn equations<T: Number>(&self, unknowns: &[T]) -> Vec<T> {
        let n = self.radius.len();
        let scaled = |range: std::ops::Range<usize>, unit: f64| -> Vec<T> {
            unknowns[range].iter().map(|x| *x * real(unit)).collect()
        };
        let x = scaled(0..n, UNITS[0]);
        let p = scaled(n..2 * n, UNITS[1]);
        let q = scaled(2 * n..3 * n + 1, UNITS[2]);
        let area: Vec<T> = (0..n)
            .map(|i| {
                let radius = x[i] + real(self.radius[i]);
                radius * radius * real(PI)
            })
            .collect();
        let mut equations = Vec::with_capacity(3 * n + 1);
        for i in 0..n {
            equations.push(self.wall.balance(i, &x, p[i]) * real(1.0 / UNITS[1]));
            let mass = q[i] - q[i + 1] - self.flow.storage(i, &area);
            equations.push(mass * real(1.0 / UNITS[2]));
        }
        equations.push(self.flow.inlet_balance(&area, &q, &p));
        for i in 1..=n {
            let downstream = if i < n {
                p[i]
            } else {
                self.flow.downstream_pressure(q[n])
            };
            let momentum = p[i - 1] - downstream - self.flow.drop(i, &area, &q);
            equations.push(momentum * real(1.0 / UNITS[1]));
        }
        equations
    }

    /// Solves the next step and accepts it; returns the radial displacements, m.
    pub fn step(&mut self) -> Vec<f64> {
        let n = self.radius.len();
        let mut u = self.unknowns.clone();
        for _ in 0..20 {
            let residual = DVector::from_vec(self.equations::<f64>(u.as_slice()));
            let mut trial: Vec<_> = u.iter().map(|x| Complex::new(*x, 0.0)).collect();
            let mut jacobian = DMatrix::zeros(u.len(), u.len());
            for k in 0..u.len() {
                trial[k].im = COMPLEX_STEP;
                for (i, value) in self.equations(&trial).iter().enumerate() {
                    jacobian[(i, k)] = value.im / COMPLEX_STEP;
                }
                trial[k].im = 0.0;
            }
            let change = jacobian
                .lu()
                .solve(&residual)
                .expect("the tube's Jacobian is regular");
            u -= &change;
            if change.norm() <= 1e-13 * u.norm() {
                break;
            }
        }
        let of = |range: std::ops::Range<usize>, unit: f64| -> Vec<f64> {
            u.as_slice()[range].iter().map(|x| x * unit).collect()
        };
        let x = of(0..n, UNITS[0]);
        let area = x
            .iter()
            .zip(&self.radius)
            .map(|(x, r)| PI * (r + x).powi(2))
            .collect();
        self.flow.accept(FlowTrial {
            area,
            flow: of(2 * n..3 * n + 1, UNITS[2]),
            pressure: of(n..2 * n, UNITS[1]),
        });
        self.wall.accept(x.clone());
        self.unknowns = u;
        x
    }
}
