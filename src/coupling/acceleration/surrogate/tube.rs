//! A one-dimensional tube as surrogate: area-averaged flow, linearized, in the structure's own wall.
//!
//! With `x` the change of the radius of each section, `p` of its mean pressure, `Q` of the flow between sections
//! (m³/s), `q` what the radial inertia of the blood adds to the pressure at the wall:
//! ```text
//! mass       2 pi r l x_i / dt + Q_{i+1} - Q_i = 0
//! momentum   l (rho/dt + 8 pi mu/A) / A  Q_i = p_{i-1} - p_i
//! inertia    q - r²/24 q'' = -rho r/(4 dt²) x
//! wall       x = residual + S (p + q)
//! ```
//! This is the implicit Euler method for the equations of Hughes and Lubliner (1973) about the state at rest. Mean
//! pressure and radial inertia together are the Padé approximation `2/(k² r) + r/4/(1 + k² r²/24)` of the added mass
//! `rho I0(kr)/(k I1(kr))` of a wave of wave number k in a tube of radius r, which is good to 4 % up to `kr = 4`.

use super::{Sections, Surrogate};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// What the surrogate knows of the fluid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurrogateBlood {
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
    /// A pressure that is proportional to the flow, behind a rigid piece.
    Resistance {
        /// Pa s/m³.
        resistance: f64,
        /// Length of the rigid piece, m; it has the radius of the adjacent section.
        rigid_length: f64,
    },
    /// A windkessel `C dp/dt + p/R = Q` behind a rigid piece and a resistance.
    Windkessel {
        /// Resistance before the windkessel, Pa s/m³.
        proximal: f64,
        /// R, Pa s/m³.
        resistance: f64,
        /// C, m³/Pa.
        compliance: f64,
        /// Length of the rigid piece, m; it has the radius of the adjacent section.
        rigid_length: f64,
    },
}

/// The surrogate: sections, the wall's answer to a pressure in each, and the ends.
///
/// The answer is that of the structure within a time step, inertia included, to the pressure that is 1 Pa in one section
/// and falls linearly to zero at the next ([`Sections::share`]): the displacement of all wall points.
///
/// Of displacements that no such pressures cause (sections that do not stay round) a fixed share passes: the added mass
/// of a wave with m periods around the circumference is `rho r/m` when it is long, and m = `AROUND` stands for all.
#[derive(Debug, Clone, PartialEq)]
pub struct TubeSurrogate {
    sections: Sections,
    blood: SurrogateBlood,
    /// A column for each section, m/Pa.
    answers: DMatrix<f64>,
    /// **S**: the same averaged over sections.
    compliance: DMatrix<f64>,
    /// The pseudo-inverse of **S**: there may be more sections than the structure has waves to tell them apart.
    cause: DMatrix<f64>,
    inlet: End,
    outlet: End,
    /// From a residual of the radii to the pressures whose answer, with the share `rest` of the residual, is the change
    /// that removes it, Pa/m.
    pressure: DMatrix<f64>,
    /// What of a residual passes that pressures of the sections do not cause.
    rest: f64,
}

/// Periods around the circumference of the displacements that sections cannot express.
const AROUND: f64 = 4.0;
/// Pressures to which the wall yields less than by this share of the average are not sought in a residual.
const LEAST_COMPLIANCE: f64 = 1e-2;

impl TubeSurrogate {
    /// A surrogate about the reference configuration; `answers` (m/Pa) has one displacement of all points a section.
    pub fn new(
        sections: Sections,
        answers: &[DVector<f64>],
        blood: SurrogateBlood,
        inlet: End,
        outlet: End,
    ) -> Self {
        assert_eq!(answers.len(), sections.count(), "one answer a section");
        let averages: Vec<f64> = answers.iter().flat_map(|d| sections.average(d)).collect();
        let n = sections.count();
        let compliance = DMatrix::from_vec(n, n, averages);
        let least = LEAST_COMPLIANCE * compliance.norm() / (n as f64).sqrt();
        let cause = compliance.clone().pseudo_inverse(least);
        let mut surrogate = Self {
            blood,
            answers: DMatrix::from_columns(answers),
            compliance,
            cause: cause.expect("the limit is not negative"),
            inlet,
            outlet,
            pressure: DMatrix::zeros(n, n),
            rest: 1.0,
            sections,
        };
        surrogate.linearize(&surrogate.sections.reference_radius());
        surrogate
    }

    /// rho/dt and wall friction over the area: pressure drop per length and flow, Pa s/m⁴.
    fn inertance(&self, radius: f64) -> f64 {
        let area = PI * radius * radius;
        (self.blood.density / self.blood.time_step + 8.0 * PI * self.blood.viscosity / area) / area
    }

    /// Flow per pressure difference between the centre of the section next to an end and what lies behind it, m³/(Pa s).
    fn conductance(&self, end: End, radius: f64) -> f64 {
        let (rigid_length, impedance) = match end {
            End::Flow => return 0.0,
            End::Pressure { rigid_length } => (rigid_length, 0.0),
            End::Resistance {
                resistance,
                rigid_length,
            } => (rigid_length, resistance),
            End::Windkessel {
                proximal,
                resistance,
                compliance,
                rigid_length,
            } => {
                let admittance = compliance / self.blood.time_step + 1.0 / resistance;
                (rigid_length, proximal + 1.0 / admittance)
            }
        };
        let length = self.sections.length() + rigid_length;
        1.0 / (length * self.inertance(radius) + impedance)
    }

    /// Prepares the answers of a tube of the given radii (m).
    fn linearize(&mut self, radius: &[f64]) {
        let (n, length, dt) = (radius.len(), self.sections.length(), self.blood.time_step);
        let mut flow: Vec<f64> = vec![self.conductance(self.inlet, radius[0])];
        flow.extend(radius.windows(2).map(|pair| {
            let mean = 0.5 * (pair[0] + pair[1]);
            1.0 / (length * self.inertance(mean))
        }));
        flow.push(self.conductance(self.outlet, radius[n - 1]));

        let mut outflow = DMatrix::zeros(n, n);
        let mut spreading = DMatrix::identity(n, n);
        for i in 0..n {
            outflow[(i, i)] = flow[i] + flow[i + 1];
            for j in [i.checked_sub(1), Some(i + 1).filter(|j| *j < n)] {
                let Some(j) = j else { continue };
                outflow[(i, j)] = -flow[i.max(j)];
                let share = (radius[i] / length).powi(2) / 24.0;
                spreading[(i, i)] += share;
                spreading[(i, j)] -= share;
            }
        }
        let storage = DMatrix::from_fn(n, n, |i, j| {
            f64::from(i == j) * 2.0 * PI * radius[i] * length / dt
        });
        let inertia = if self.blood.radial_inertia {
            let local = DMatrix::from_fn(n, n, |i, j| {
                f64::from(i == j) * self.blood.density * radius[i] / (4.0 * dt * dt)
            });
            solve(spreading, &local)
        } else {
            DMatrix::zeros(n, n)
        };
        // x = B (residual + S p), then (outflow + storage B S) p = -storage B residual.
        let identity = DMatrix::identity(n, n);
        let b = solve(&identity + &self.compliance * &inertia, &identity);
        let widening = &b * &self.compliance;
        let mean = -solve(outflow + &storage * &widening, &(&storage * &b));
        let change = &mean - inertia * (b + widening * &mean);

        if self.blood.radial_inertia {
            let softest = self.compliance.column_sum().max();
            let added =
                self.blood.density * radius.iter().sum::<f64>() / n as f64 / (AROUND * dt * dt);
            self.rest = 1.0 / (1.0 + added * softest);
        }
        self.pressure = change + (1.0 - self.rest) * &self.cause;
    }

    /// The change of radius of each section that removes the residual `r` (m) of its radius.
    #[cfg(test)]
    pub(super) fn widen(&self, r: &[f64]) -> Vec<f64> {
        let r = DVector::from_column_slice(r);
        let x = self.rest * &r + &self.compliance * (&self.pressure * &r);
        x.as_slice().to_vec()
    }
}

/// `matrix⁻¹ right`; none of the matrices here is singular.
fn solve(matrix: DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    matrix
        .lu()
        .solve(right)
        .expect("the wall yields to pressure")
}

impl Surrogate for TubeSurrogate {
    fn predict(&self, residual: &DVector<f64>) -> DVector<f64> {
        let r = DVector::from_vec(self.sections.average(residual));
        self.rest * residual + &self.answers * (&self.pressure * r)
    }

    fn finish_step(&mut self, d: &DVector<f64>) {
        let reference = self.sections.reference_radius();
        let change = self.sections.average(d);
        let radius: Vec<f64> = reference.iter().zip(change).map(|(r, x)| r + x).collect();
        self.linearize(&radius);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Axis;
    use super::*;
    use crate::Vec3;
    use crate::curve::SpaceCurve;

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
            line: SpaceCurve::x_axis(0.0, 0.05),
            length: 0.05,
        };
        let sections = Sections::new(&points, axis, 49).unwrap();
        let blood = SurrogateBlood {
            density: 1000.0,
            viscosity: 0.0,
            time_step: 1e-3,
            radial_inertia,
        };
        // Each section answers for itself.
        let answer = |i: usize| {
            let unit: Vec<f64> = (0..49).map(|j| f64::from(i == j) / 1.2e7).collect();
            sections.spread(&unit)
        };
        let answers: Vec<_> = (0..49).map(answer).collect();
        TubeSurrogate::new(sections, &answers, blood, inlet, outlet)
    }

    #[test]
    fn a_standing_wave_meets_the_added_mass_of_a_tube() {
        // Both pressures zero: sin(pi x/L) is a mode, with the added mass 2 rho/(k² r) + rho r/4.
        let open = End::Pressure { rigid_length: 0.0 };
        let mode: Vec<f64> = (1..50).map(|i| (PI * f64::from(i) / 50.0).sin()).collect();
        let k2 = (PI / 0.05_f64).powi(2);
        for (inertia, extra) in [(false, 0.0), (true, 1.0)] {
            let mass = 1000.0 * (2.0 / (k2 * 5e-3) + extra * 5e-3 / 4.0);
            let expected = 1.0 / (1.0 + mass / 1e-6 / 1.2e7);
            let x = tube(open, open, inertia).widen(&mode);
            assert!(
                (x[24] / mode[24] / expected - 1.0).abs() < 1e-3,
                "{} {expected}",
                x[24]
            );
        }
    }

    #[test]
    fn a_closed_tube_keeps_its_volume() {
        let x = tube(End::Flow, End::Flow, true).widen(&[1e-4; 49]);
        assert!(x.iter().sum::<f64>().abs() < 1e-15, "{:?}", x);
    }

    #[test]
    fn of_other_displacements_a_share_passes() {
        let surrogate = tube(End::Flow, End::Pressure { rigid_length: 0.0 }, true);
        let shift = DVector::from_fn(3 * 4 * 101, |i, _| [0.3, -0.2, 0.1][i % 3]);
        // rho r/4 against the stiffness of 1.2e7 Pa/m
        let share = 1.0 / (1.0 + 1000.0 * 5e-3 / 4.0 / 1e-6 / 1.2e7);
        let left = surrogate.predict(&shift) - share * &shift;
        assert!(left.norm() < 1e-6 * shift.norm(), "{}", left.norm());
    }
}
