//! The wall of a tube: an elastic ring in every cell, joined by axial tension.
//!
//! `m d²x/dt² + k x - T d²x/dz² = p` for the radial displacement x (the "generalized string" of Quarteroni, Tuveri and
//! Veneziani 2000), Newmark's method without numerical damping as in the paper; clamped ends.

use super::flow::{Number, real};
use super::tridiagonal::Tridiagonal;

/// Constants of the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallSetup {
    /// k: pressure per radial displacement, Pa/m; `E h/r²` for a thin wall.
    pub stiffness: f64,
    /// T: axial tension per circumference, N/m.
    pub tension: f64,
    /// m: mass per area, kg/m².
    pub mass: f64,
}

/// The wall at the end of the last accepted time step; starts at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct StringWall {
    setup: WallSetup,
    /// Length of a cell, m.
    cell: f64,
    /// Time step, s.
    time_step: f64,
    displacement: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
}

impl StringWall {
    /// A wall of `n` cells at rest.
    pub fn at_rest(setup: WallSetup, n: usize, cell: f64, time_step: f64) -> Self {
        Self {
            setup,
            cell,
            time_step,
            displacement: vec![0.0; n],
            velocity: vec![0.0; n],
            acceleration: vec![0.0; n],
        }
    }

    /// Pressure per radial displacement within a time step, inertia included, without tension, Pa/m.
    pub fn dynamic_stiffness(&self) -> f64 {
        self.setup.stiffness + 4.0 * self.setup.mass / self.time_step.powi(2)
    }

    /// The part of the acceleration that the last step fixes: `a = 4 x/dt² - memory` (Newmark, beta = 1/4).
    fn memory(&self, i: usize) -> f64 {
        let dt = self.time_step;
        4.0 / (dt * dt) * self.displacement[i] + 4.0 / dt * self.velocity[i] + self.acceleration[i]
    }

    /// The radial displacement under the pressures at the end of the next step, m.
    pub fn solve(&self, pressure: &[f64]) -> Vec<f64> {
        let n = pressure.len();
        let coupling = self.setup.tension / self.cell.powi(2);
        let mut matrix = Tridiagonal::zeros(n);
        let right: Vec<f64> = (0..n)
            .map(|i| pressure[i] + self.setup.mass * self.memory(i))
            .collect();
        for i in 0..n {
            // The clamped end lies half a cell away: a mirrored value of opposite sign.
            let mirrored = usize::from(i == 0) + usize::from(i + 1 == n);
            matrix.diagonal[i] = self.dynamic_stiffness() + (2 + mirrored) as f64 * coupling;
            (matrix.lower[i], matrix.upper[i]) = (-coupling, -coupling);
        }
        matrix.solve(&right)
    }

    /// What is missing to equilibrium of ring `i` at the end of the next step, Pa.
    pub fn balance<T: Number>(&self, i: usize, displacement: &[T], pressure: T) -> T {
        let x = displacement[i];
        let previous = if i > 0 { displacement[i - 1] } else { -x };
        let after = displacement.get(i + 1).copied().unwrap_or(-x);
        let bend =
            (previous + after - x * real(2.0)) * real(self.setup.tension / self.cell.powi(2));
        let inertia = x * real(4.0 / self.time_step.powi(2)) - real(self.memory(i));
        inertia * real(self.setup.mass) + x * real(self.setup.stiffness) - bend - pressure
    }

    /// Accepts the displacement as the end of the step.
    pub fn accept(&mut self, displacement: Vec<f64>) {
        let dt = self.time_step;
        for (i, x) in displacement.iter().enumerate() {
            let acceleration = 4.0 / (dt * dt) * x - self.memory(i);
            self.velocity[i] += 0.5 * dt * (self.acceleration[i] + acceleration);
            self.acceleration[i] = acceleration;
        }
        self.displacement = displacement;
    }
}
