//! A one-dimensional tube as surrogate: area-averaged flow, linearized, in a wall of local compliance.
//!
//! With `x` the change of the radius of each section, `p` of its pressure, `Q` of the flow between sections (m³/s):
//! ```text
//! mass       2 pi r l x_i / dt + Q_{i+1} - Q_i = 0
//! momentum   l (rho/dt + 8 pi mu/A) / A  Q_i = p_{i-1} - p_i
//! wall       k_i x_i = p_i - rho r/(4 dt²) x_i     (the last term: radial inertia of the blood)
//! ```
//! This is the implicit Euler method for the equations of Hughes and Lubliner (1973) about the state at rest. The
//! radial inertia is the next term of the added mass `rho I0(kr)/(k I1(kr)) = rho (2/(k² r) + r/4 + …)` of a wave
//! of wave number k in a tube of radius r. Eliminating `Q` and `x` leaves one tridiagonal system for `p`.

use super::{Sections, Surrogate, Tridiagonal};
use nalgebra::DVector;
use std::f64::consts::PI;

/// What the surrogate knows of the fluid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blood {
    /// Density, kg/m³.
    pub density: f64,
    /// Dynamic viscosity, Pa s.
    pub viscosity: f64,
    /// Time step, s.
    pub time_step: f64,
    /// Whether the radial inertia of the blood is taken into account (a three-dimensional fluid has it).
    pub radial_inertia: bool,
}

/// What happens at an end of the tube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// The flow is prescribed (a rigid tube before it makes no difference).
    Flow,
    /// The pressure is prescribed behind a rigid piece.
    Pressure {
        /// Length of the rigid piece, m; it has the radius of the adjacent section.
        rigid_length: f64,
    },
    /// A windkessel `C dp/dt + p/R = Q` behind a rigid piece.
    Windkessel {
        /// R, Pa s/m³.
        resistance: f64,
        /// C, m³/Pa.
        compliance: f64,
        /// Length of the rigid piece, m; it has the radius of the adjacent section.
        rigid_length: f64,
    },
}

/// The surrogate: sections, the wall's stiffness in each, and the ends.
///
/// The stiffness is what the structure answers to a change of pressure within a time step: the pressure over the
/// radial displacement of each section, inertia included. It comes from one solve with the structure's tangent under
/// unit pressure and [`Sections::average`] of its displacement.
///
/// Displacements that sections cannot express (short waves, sections that do not stay round) pass unchanged: there
/// the added mass is small.
#[derive(Debug, Clone, PartialEq)]
pub struct TubeSurrogate {
    sections: Sections,
    blood: Blood,
    /// k, Pa/m.
    stiffness: Vec<f64>,
    inlet: End,
    outlet: End,
    /// Current radius of each section, m.
    radius: Vec<f64>,
}

impl TubeSurrogate {
    /// A surrogate about the reference configuration; `stiffness` (Pa/m) has one value a section.
    pub fn new(
        sections: Sections,
        stiffness: Vec<f64>,
        blood: Blood,
        inlet: End,
        outlet: End,
    ) -> Self {
        assert_eq!(stiffness.len(), sections.count(), "one stiffness a section");
        let radius = sections.reference_radius();
        Self {
            sections,
            blood,
            stiffness,
            inlet,
            outlet,
            radius,
        }
    }

    /// rho/dt and wall friction over the area: pressure drop per length and flow, Pa s/m⁴.
    fn inertance(&self, radius: f64) -> f64 {
        let area = PI * radius * radius;
        (self.blood.density / self.blood.time_step + 8.0 * PI * self.blood.viscosity / area) / area
    }

    /// Flow per pressure difference between the middle of the section at an end and what lies behind it, m³/(Pa s).
    fn conductance(&self, end: End, radius: f64) -> f64 {
        let (rigid_length, impedance) = match end {
            End::Flow => return 0.0,
            End::Pressure { rigid_length } => (rigid_length, 0.0),
            End::Windkessel {
                resistance,
                compliance,
                rigid_length,
            } => {
                let admittance = compliance / self.blood.time_step + 1.0 / resistance;
                (rigid_length, 1.0 / admittance)
            }
        };
        let length = 0.5 * self.sections.length() + rigid_length;
        1.0 / (length * self.inertance(radius) + impedance)
    }

    /// The change of radius of each section that removes the residual `r` (m) of its radius.
    pub fn widen(&self, r: &[f64]) -> Vec<f64> {
        let (n, length, dt) = (r.len(), self.sections.length(), self.blood.time_step);
        let between = |i: usize| {
            let radius = 0.5 * (self.radius[i - 1] + self.radius[i]);
            1.0 / (length * self.inertance(radius))
        };
        let mut flow: Vec<f64> = vec![self.conductance(self.inlet, self.radius[0])];
        flow.extend((1..n).map(between));
        flow.push(self.conductance(self.outlet, self.radius[n - 1]));

        let mut matrix = Tridiagonal::zeros(n);
        let mut right = vec![0.0; n];
        let mut wall = vec![0.0; n];
        for i in 0..n {
            let storage = 2.0 * PI * self.radius[i] * length / dt;
            let added = if self.blood.radial_inertia {
                self.blood.density * self.radius[i] / (4.0 * dt * dt)
            } else {
                0.0
            };
            wall[i] = self.stiffness[i] + added;
            matrix.lower[i] = -flow[i];
            matrix.upper[i] = -flow[i + 1];
            matrix.diagonal[i] = flow[i] + flow[i + 1] + storage / wall[i];
            right[i] = -storage / wall[i] * self.stiffness[i] * r[i];
        }
        let p = matrix.solve(&right);
        (0..n)
            .map(|i| (self.stiffness[i] * r[i] + p[i]) / wall[i])
            .collect()
    }
}

impl Surrogate for TubeSurrogate {
    fn predict(&self, residual: &DVector<f64>) -> DVector<f64> {
        let r = self.sections.average(residual);
        let x = self.widen(&r);
        let change: Vec<f64> = x.iter().zip(&r).map(|(x, r)| x - r).collect();
        residual + self.sections.spread(&change)
    }

    fn finish_step(&mut self, d: &DVector<f64>) {
        let reference = self.sections.reference_radius();
        let change = self.sections.average(d);
        self.radius = reference.iter().zip(change).map(|(r, x)| r + x).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::super::Axis;
    use super::*;
    use crate::Vec3;

    /// A tube of 50 mm length and 5 mm radius, stiffness 1.2e7 Pa/m.
    fn tube(inlet: End, outlet: End, radial_inertia: bool) -> TubeSurrogate {
        let ring = |i: u32| {
            (0..4).map(move |k| {
                let (sin, cos) = (f64::from(k) * 0.5 * PI).sin_cos();
                Vec3::new(f64::from(i) * 5e-4, 5e-3 * cos, 5e-3 * sin)
            })
        };
        let points: Vec<Vec3> = (0..101).flat_map(ring).collect();
        let axis = Axis {
            origin: Vec3::zeros(),
            direction: Vec3::x(),
        };
        let sections = Sections::new(&points, axis, 50).unwrap();
        let blood = Blood {
            density: 1000.0,
            viscosity: 0.0,
            time_step: 1e-3,
            radial_inertia,
        };
        TubeSurrogate::new(sections, vec![1.2e7; 50], blood, inlet, outlet)
    }

    #[test]
    fn a_standing_wave_meets_the_added_mass_of_a_tube() {
        // Both pressures zero: sin(pi x/L) is a mode, with the added mass 2 rho/(k² r) + rho r/4.
        let open = End::Pressure { rigid_length: 0.0 };
        let mode: Vec<f64> = (0..50)
            .map(|i| (PI * (f64::from(i) + 0.5) / 50.0).sin())
            .collect();
        let k2 = (PI / 0.05_f64).powi(2);
        for (inertia, extra) in [(false, 0.0), (true, 1.0)] {
            let mass = 1000.0 * (2.0 / (k2 * 5e-3) + extra * 5e-3 / 4.0);
            let expected = 1.0 / (1.0 + mass / 1e-6 / 1.2e7);
            let x = tube(open, open, inertia).widen(&mode);
            assert!(
                (x[25] / mode[25] / expected - 1.0).abs() < 1e-3,
                "{} {expected}",
                x[25]
            );
        }
    }

    #[test]
    fn a_closed_tube_keeps_its_volume() {
        let x = tube(End::Flow, End::Flow, true).widen(&[1e-4; 50]);
        assert!(x.iter().sum::<f64>().abs() < 1e-15, "{:?}", x);
    }

    #[test]
    fn other_displacements_pass_unchanged() {
        let surrogate = tube(End::Flow, End::Pressure { rigid_length: 0.0 }, true);
        let shift = DVector::from_fn(3 * 4 * 101, |i, _| [0.3, -0.2, 0.1][i % 3]);
        assert!((surrogate.predict(&shift) - shift).norm() < 1e-12);
    }
}
