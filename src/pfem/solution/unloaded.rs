//! The unloaded shape of a body whose loaded one is given: the inverse problem of statics.
//!
//! Sought is the displacement `u` that leads from `X = x - u` to the given shape `x` and is in equilibrium there,
//! ```text
//! r(u) = f_int(u; X = x - u) - f_ext(x) = 0
//! ```
//! (Govindjee and Mihalic, *Computational methods for inverse finite elastostatics*, Comput. Methods Appl. Mech. Engrg. 136,
//! 1996). A pressure that follows the surface does not change meanwhile, since it is the given surface that carries it. The
//! load grows in steps. Each is a fixed-point iteration,
//! ```text
//! g(u) = -K⁻¹ r(u),      u ← u + g(u),
//! ```
//! with the tangent `K` of the internal forces, the unloaded shape fixed, at the end of the step before (what is
//! extrapolated from there is compressed, so that its stresses are wrong by more than themselves): one step of Newton's
//! method of the loading in place of all of it, otherwise the iteration of Sellier (*An iterative method for the inverse
//! elasto-static problem*, J. Fluids Struct. 27, 2011). What `K` leaves out, the change of the unloaded shape, Anderson's acceleration learns from the
//! iterates: with the differences `ΔU` and `ΔG` of all of them
//! ```text
//! u ← u + g - (ΔU + ΔG) γ,       γ = argmin |g - ΔG γ|
//! ```
//! (Walker and Ni, *Anderson acceleration for fixed-point iterations*, SIAM J. Numer. Anal. 49, 2011), which for a linear
//! problem is GMRES. Without it the iteration diverges near buckling, where loading multiplies any bend.

use super::super::SolidError;
use super::super::discretization::Discretization;
use super::super::linear_algebra::factor::Factorization;
use nalgebra::{DMatrix, DVector};

/// Steps of the load to begin with.
const STEPS: f64 = 4.0;
/// The shortest step.
const SHORTEST: f64 = 1.0 / 256.0;
/// Relative residual at the end of all steps but the last.
const ON_THE_WAY: f64 = 1e-4;
/// The same of the last.
const TOLERANCE: f64 = 1e-9;
/// Most iterations of a step.
const MOST_ITERATIONS: usize = 60;

/// What was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Displacement coefficients from the unloaded shape to the given one, m.
    pub displacement: Vec<f64>,
    /// Iterations of all steps of the load.
    pub iterations: usize,
    /// Steps of the load.
    pub steps: usize,
}

/// The displacement that leads to the shape of `body` and is in equilibrium with the forces `external` (N) there. Held
/// coefficients have their values in `moved`, whose others are a guess; they are zero without.
///
/// # Errors
/// If the iteration does not converge.
pub fn find(
    body: &Discretization,
    external: &[f64],
    moved: Option<&[f64]>,
) -> Result<Found, SolidError> {
    body.check_rigid_motions()?;
    let mut found = Found {
        displacement: vec![0.0; body.coefficients()],
        iterations: 0,
        steps: 0,
    };
    let floor = body.round_off()?;
    let (mut reached, mut increment) = (0.0, 1.0 / STEPS);
    // The step before, by whose direction the next one is begun.
    let mut slope: Option<Vec<f64>> = moved.map(<[f64]>::to_vec);
    while reached < 1.0 {
        let factor = f64::min(reached + increment, 1.0);
        let along = slope.iter().flatten();
        let mut start = found.displacement.clone();
        (start.iter_mut().zip(along)).for_each(|(u, du)| *u += (factor - reached) * du);
        if let Some(moved) = moved {
            let held = body.supports.held().iter().zip(moved);
            let held = held.map(|(held, value)| held.then_some(factor * value));
            (start.iter_mut().zip(held)).for_each(|(u, held)| *u = held.unwrap_or(*u));
        }
        let goal = Goal {
            body,
            external,
            factor,
            floor,
            has_reactions: moved.is_some(),
            tolerance: if factor < 1.0 { ON_THE_WAY } else { TOLERANCE },
        };
        match goal.solve(&found.displacement, start) {
            Ok((displacement, iterations)) => {
                let change = displacement.iter().zip(&found.displacement);
                let scale = 1.0 / (factor - reached);
                slope = Some(change.map(|(now, before)| (now - before) * scale).collect());
                found.displacement = displacement;
                found.iterations += iterations;
                found.steps += 1;
                reached = factor;
            }
            Err(_) if increment > SHORTEST => increment *= 0.5,
            Err(error) => {
                return Err(SolidError::NoEquilibrium(format!(
                    "no unloaded shape was found from which more than {:.1} % of the load lead to the given one: {error}",
                    100.0 * reached
                )));
            }
        }
    }
    Ok(found)
}

/// Equilibrium in the given shape with a share of the load.
struct Goal<'a> {
    body: &'a Discretization,
    external: &'a [f64],
    factor: f64,
    floor: f64,
    /// Whether ends that were moved exert forces, against which the residual is measured too.
    has_reactions: bool,
    tolerance: f64,
}

impl Goal<'_> {
    /// The residual of the equations, N, and its norm relative to the forces.
    fn residual(&self, displacement: &[f64]) -> Result<(Vec<f64>, f64), SolidError> {
        let all = self
            .body
            .before(displacement)?
            .internal_forces(displacement)?;
        let [internal, external] = [&all[..], self.external].map(|f| self.body.restrict(f));
        let pairs = internal.iter().zip(&external);
        let residual: Vec<f64> = pairs.map(|(i, e)| i - self.factor * e).collect();
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let size = norm(&residual);
        let mut scale = self.factor * norm(&external);
        if self.has_reactions {
            scale = scale.max(norm(&all));
        }
        Ok((
            residual,
            if size <= self.floor {
                0.0
            } else {
                size / scale
            },
        ))
    }

    /// The tangent of the internal forces in the unloaded shape that a displacement comes from.
    fn tangent(&self, displacement: &[f64]) -> Result<Factorization, SolidError> {
        let unloaded = self.body.before(displacement)?;
        let mut tangent = unloaded.tangent(displacement, None, &[])?;
        unloaded.pattern.hold(&mut tangent);
        unloaded.factorize(&tangent)
    }

    /// The displacement, and the iterations that it took, from `start` with the tangent of `before`.
    fn solve(&self, before: &[f64], start: Vec<f64>) -> Result<(Vec<f64>, usize), SolidError> {
        let factorization = self.tangent(before)?;
        let mut acceleration = Anderson::default();
        let mut displacement = start;
        for iteration in 0..=MOST_ITERATIONS {
            let (residual, relative) = self.residual(&displacement)?;
            if relative <= self.tolerance {
                return Ok((displacement, iteration));
            }
            if !relative.is_finite() {
                break;
            }
            let mut step = residual;
            factorization.solve(&mut step)?;
            let change = acceleration.step(-DVector::from_vec(step));
            displacement = self.body.moved(&displacement, change.as_slice(), 1.0);
        }
        Err(SolidError::NoEquilibrium(format!(
            "the iteration for the unloaded shape did not reach {:.0e} in {MOST_ITERATIONS} iterations",
            self.tolerance
        )))
    }
}

/// Anderson's acceleration, from the differences of all iterates.
#[derive(Default)]
struct Anderson {
    /// The last fixed-point residual and the change of the iterate that followed.
    last: Option<(DVector<f64>, DVector<f64>)>,
    /// `(Δu, Δg)`.
    differences: Vec<(DVector<f64>, DVector<f64>)>,
}

impl Anderson {
    /// The change of the iterate after the fixed-point residual `g`.
    fn step(&mut self, g: DVector<f64>) -> DVector<f64> {
        if let Some((before, change)) = self.last.take() {
            self.differences.push((change, &g - before));
        }
        let mut change = g.clone();
        if !self.differences.is_empty() {
            let columns: Vec<_> = self.differences.iter().map(|(_, dg)| dg.clone()).collect();
            let matrix = DMatrix::from_columns(&columns);
            let (q, r) = matrix.qr().unpack();
            // Columns that say nothing new make `R` singular: then the plain step remains.
            if let Some(gamma) = r.solve_upper_triangular(&q.tr_mul(&g)) {
                for ((du, dg), gamma) in self.differences.iter().zip(gamma.iter()) {
                    change.axpy(-gamma, du, 1.0);
                    change.axpy(-gamma, dg, 1.0);
                }
            }
        }
        self.last = Some((g, change.clone()));
        change
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn anderson_solves_a_linear_problem_that_the_plain_iteration_diverges_from() {
        // u = A u + b with eigenvalues -2, 0.5 and 3 of A.
        let a = DVector::from_vec(vec![-2.0, 0.5, 3.0]);
        let b = DVector::from_vec(vec![3.0, 1.0, -4.0]);
        let mut u = DVector::zeros(3);
        let mut acceleration = Anderson::default();
        for _ in 0..4 {
            let g = a.component_mul(&u) + &b - &u;
            u += acceleration.step(g);
        }
        let exact = DVector::from_vec(vec![1.0, 2.0, 2.0]);
        assert!((u - exact).norm() < 1e-12);
    }
}
