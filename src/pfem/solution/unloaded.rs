//! The unloaded shape of a body whose loaded one is given: the inverse problem of statics.
//!
//! Sought is the displacement `u` that leads from `X = x - u` to the given shape `x` and is in equilibrium there,
//! ```text
//! r(u) = f_int(u; X = x - u) - f_ext(x) = 0
//! ```
//! (Govindjee and Mihalic, *Computational methods for inverse finite elastostatics*, Comput. Methods Appl. Mech. Engrg.
//! 136, 1996). Forces stand on the given shape, which does not change: neither do pressures that follow the surface.
//! Nor can the body buckle here, for the moments of these forces are known. The load grows in steps, and the logarithm
//! of a prestretch with it. Each begins with a fixed-point iteration,
//! ```text
//! g(u) = -K⁻¹ r(u),      u ← u + g(u),
//! ```
//! with the tangent `K` of the internal forces, the unloaded shape fixed, at the end of the step before (what is
//! extrapolated from there is compressed, so that its stresses are wrong by more than themselves): one step of Newton's
//! method of the loading in place of all of it, otherwise the iteration of Sellier (*An iterative method for the
//! inverse elasto-static problem*, J. Fluids Struct. 27, 2011). What `K` leaves out, the change of the unloaded shape,
//! [Anderson's acceleration](super::anderson) learns from the iterates.
//!
//! That is cheap, but where fibres stiffen, or loading is close to buckling, `K` has too little to do with the problem.
//! From the step on in which it fails, Newton's method takes its place,
//! ```text
//! J s = -r(u),     u ← u + α s,      J = ∂f_int/∂u - ∂f_int/∂X.
//! ```
//! `J` has no symmetry. What it makes of a vector is the difference of two residuals; GMRES solves the linear system,
//! with `K` at `u` as preconditioner, which has the stiffness of the volume in common with `J`. A step that makes `|K⁻¹
//! r|` no smaller is shortened (Deuflhard's natural monotonicity test: the norm of `r` itself always rises first, since
//! linear steps violate incompressibility by terms of second order).
//!
//! Where no unloaded shape exists, or steps are too long, `J` becomes singular and Newton's method wanders: GMRES
//! leaves one linear system after the other unsolved, and the residual does not fall. Such an attempt ends at once,
//! since a shorter step costs less than the iterations that are left. In short steps the method may wander: some of
//! them converge after all.

use super::super::discretization::Discretization;
use super::super::linear_algebra::factor::Factorization;
use super::super::linear_algebra::gmres;
use super::super::solid::{NoUnloadedShape, SolidError};
use super::anderson::Anderson;
use super::listener;
use nalgebra::DVector;
use std::cell::Cell;

/// Steps of the load to begin with.
const STEPS: f64 = 4.0;
/// The shortest step.
const SHORTEST: f64 = 1.0 / 256.0;
/// Steps of this length or less are short: Newton's method may wander in them.
const SHORT: f64 = 1.0 / 64.0;
/// Relative residual at the end of all steps but the last.
const ON_THE_WAY: f64 = 1e-4;
/// The same of the last.
const TOLERANCE: f64 = 1e-9;
/// Most iterations of a step by fixed-point iterations, and by Newton's method.
const MOST_ITERATIONS: usize = 60;
const MOST_NEWTON_ITERATIONS: usize = 20;
/// Relative error of the linear systems.
const LINEAR: f64 = 1e-2;
/// Most applications of `J` for one of them.
const MOST_APPLICATIONS: usize = 60;
/// Newton's method wanders if so many linear systems in a row are unsolved after that many applications ...
const UNSOLVED: usize = 2;
/// ... and the residual has not fallen to this share of the first one.
const FALLEN: f64 = 0.5;
/// Strain by which residuals are apart from which `J` is a difference: the terms of second order times the bulk modulus
/// are then as small as rounding, both about 1e-4 of the difference.
const APART: f64 = 1e-8;
/// The smallest share of a step of Newton's method.
const SHORTEST_SHARE: f64 = 1.0 / 64.0;

/// What was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Displacement coefficients from the unloaded shape to the given one, m.
    pub displacement: Vec<f64>,
    /// Iterations of all steps of the load.
    pub iterations: usize,
    /// Steps of the load.
    pub steps: usize,
    /// Share of the load from which on Newton's method was needed, if it was.
    pub newton_from: Option<f64>,
}

/// The displacement that leads to the shape of `body` and is in equilibrium with the forces `external` (N) there. Held
/// coefficients have their values in `moved`, whose others are a guess; they are zero without.
///
/// # Errors
/// [`NoUnloadedShape`] if the iteration does not converge.
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
        newton_from: None,
    };
    let floor = body.round_off()?;
    let inside_out = Cell::new(None);
    let (mut reached, mut increment) = (0.0, 1.0 / STEPS);
    // The step before, by whose direction the next one is begun.
    let mut slope: Option<Vec<f64>> = moved.map(<[f64]>::to_vec);
    while reached < 1.0 {
        let factor = f64::min(reached + increment, 1.0);
        let begin = |slope| begun(body, &found.displacement, slope, (reached, factor), moved);
        let goal = Goal {
            body,
            external,
            factor,
            floor,
            has_reactions: moved.is_some() || body.is_prestretched(),
            tolerance: if factor < 1.0 { ON_THE_WAY } else { TOLERANCE },
            may_wander: increment <= SHORT,
            inside_out: &inside_out,
        };
        let by_fixed_point = (found.newton_from.is_none())
            .then(|| goal.accelerated(&found.displacement, begin(slope.as_deref())));
        let result = match by_fixed_point {
            Some(Ok(converged)) => Ok(converged),
            _ => {
                found.newton_from.get_or_insert(reached);
                goal.newton(&found.displacement, begin(moved))
            }
        };
        match result {
            Ok((displacement, iterations)) => {
                let change = displacement.iter().zip(&found.displacement);
                let scale = 1.0 / (factor - reached);
                slope = Some(change.map(|(now, before)| (now - before) * scale).collect());
                found.displacement = displacement;
                found.iterations += iterations;
                found.steps += 1;
                reached = factor;
                listener::tell("unloading the wall", reached);
            }
            Err(_) if increment > SHORTEST => increment *= 0.5,
            Err(error) => {
                let middle = |element| body.mapping.at(element, [0.0; 3]).position.into();
                return Err(SolidError::NoUnloadedShape(Box::new(NoUnloadedShape {
                    reached,
                    place: inside_out.get().map(middle),
                    last: error.to_string(),
                })));
            }
        }
    }
    Ok(found)
}

/// Where the iteration for the share `factor` of the load begins: along the `slope` from the displacement at `reached`,
/// with the held coefficients where they then are.
fn begun(
    body: &Discretization,
    displacement: &[f64],
    slope: Option<&[f64]>,
    (reached, factor): (f64, f64),
    moved: Option<&[f64]>,
) -> Vec<f64> {
    let mut start = displacement.to_vec();
    let along = slope.into_iter().flatten();
    (start.iter_mut().zip(along)).for_each(|(u, du)| *u += (factor - reached) * du);
    if let Some(moved) = moved {
        let held = body.supports.held().iter().zip(moved);
        let held = held.map(|(held, value)| held.then_some(factor * value));
        (start.iter_mut().zip(held)).for_each(|(u, held)| *u = held.unwrap_or(*u));
    }
    start
}

/// A displacement, its residual (N), and the norm of that relative to the forces.
type Iterate = (Vec<f64>, DVector<f64>, f64);

/// Equilibrium in the given shape with a share of the load.
struct Goal<'a> {
    body: &'a Discretization,
    external: &'a [f64],
    factor: f64,
    floor: f64,
    /// Whether ends that were moved, or hold a prestretched body, exert forces, against which the residual is measured
    /// too.
    has_reactions: bool,
    tolerance: f64,
    /// Whether Newton's method goes on where it wanders.
    may_wander: bool,
    /// The last element that was inside out.
    inside_out: &'a Cell<Option<usize>>,
}

impl Goal<'_> {
    /// The residual of the equations, N, and its norm relative to the forces.
    fn residual(&self, displacement: &[f64]) -> Result<(DVector<f64>, f64), SolidError> {
        let all = self.internal_forces(displacement)?;
        let [internal, external] = [&all[..], self.external].map(|f| self.body.restrict(f));
        let pairs = internal.iter().zip(&external);
        let residual: Vec<f64> = pairs.map(|(i, e)| i - self.factor * e).collect();
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let size = norm(&residual);
        if !size.is_finite() {
            return Err(SolidError::NoEquilibrium("the stresses overflow".into()));
        }
        let mut scale = self.factor * norm(&external);
        if self.has_reactions {
            scale = scale.max(norm(&all));
        }
        let relative = if size <= self.floor {
            0.0
        } else {
            size / scale
        };
        Ok((DVector::from_vec(residual), relative))
    }

    /// The internal forces in the shape that a displacement comes from.
    fn internal_forces(&self, displacement: &[f64]) -> Result<Vec<f64>, SolidError> {
        let unloaded = self.body.unloaded_with(displacement, self.factor);
        let all = unloaded.and_then(|unloaded| unloaded.internal_forces(displacement));
        if let Err(SolidError::Inverted { element, .. }) = all {
            self.inside_out.set(Some(element));
        }
        all
    }

    /// The tangent of the internal forces in the unloaded shape that a displacement comes from.
    fn tangent(&self, displacement: &[f64]) -> Result<Factorization, SolidError> {
        let unloaded = self.body.unloaded_with(displacement, self.factor)?;
        let mut tangent = unloaded.tangent(displacement, None, &[])?;
        unloaded.pattern.hold(&mut tangent);
        unloaded.factorize(&tangent)
    }

    /// The step of Newton's method from a residual `K⁻¹ r` of the preconditioned equations, linearized at a
    /// displacement; and whether the linear system is solved.
    fn newton_step(
        &self,
        at: &[f64],
        preconditioner: &Factorization,
        preconditioned: &DVector<f64>,
    ) -> Result<(DVector<f64>, bool), SolidError> {
        let (here, _) = self.residual(at)?;
        let size = self.body.element_size();
        let apply = |direction: &DVector<f64>| {
            let apart = APART * size / direction.amax();
            let (there, _) = self.residual(&self.body.moved(at, direction.as_slice(), apart))?;
            let mut image = (there - &here) / apart;
            preconditioner.solve(image.as_mut_slice())?;
            Ok(image)
        };
        let (step, applications) =
            gmres::solve(&-preconditioned, LINEAR, MOST_APPLICATIONS, apply)?;
        Ok((step, applications < MOST_APPLICATIONS))
    }

    /// The displacement, and the iterations that it took, from `start` with the tangent of `before`.
    fn accelerated(
        &self,
        before: &[f64],
        start: Vec<f64>,
    ) -> Result<(Vec<f64>, usize), SolidError> {
        let factorization = self.tangent(before)?;
        let mut acceleration = Anderson::default();
        let mut displacement = start;
        let mut history = Vec::new();
        for iteration in 0..=MOST_ITERATIONS {
            let (mut step, relative) = self.residual(&displacement)?;
            history.push(relative);
            if relative <= self.tolerance {
                return Ok((displacement, iteration));
            }
            factorization.solve(step.as_mut_slice())?;
            let change = acceleration.step(-step);
            displacement = self.body.moved(&displacement, change.as_slice(), 1.0);
        }
        Err(SolidError::NoEquilibrium(self.diagnosis(&history)))
    }

    /// The same by Newton's method. The first step is linearized `before` the start, where there was equilibrium: what
    /// is extrapolated from there is compressed, so that its stresses are wrong by more than themselves.
    fn newton(&self, before: &[f64], start: Vec<f64>) -> Result<(Vec<f64>, usize), SolidError> {
        let mut displacement = start;
        let (mut residual, mut relative) = self.residual(&displacement)?;
        let mut history = vec![relative];
        let mut unsolved = 0;
        for iteration in 0..MOST_NEWTON_ITERATIONS {
            if relative <= self.tolerance {
                return Ok((displacement, iteration));
            }
            let wanders = unsolved >= UNSOLVED && relative > FALLEN * history[0];
            if wanders && !self.may_wander {
                return Err(SolidError::NoEquilibrium(self.diagnosis(&history)));
            }
            let at = match iteration {
                0 => before.to_vec(),
                _ => displacement.clone(),
            };
            let preconditioner = self.tangent(&at)?;
            let now = preconditioned(&preconditioner, residual)?;
            let (step, is_solved) = self.newton_step(&at, &preconditioner, &now)?;
            unsolved = if is_solved { 0 } else { unsolved + 1 };
            // The first step leads from one load to another.
            let most = |share: f64| match iteration {
                0 => f64::INFINITY,
                _ => (1.0 - 0.25 * share) * now.norm(),
            };
            let shortened = self.shortened(&displacement, &step, &preconditioner, most);
            let Some(next) = shortened? else {
                return Err(SolidError::NoEquilibrium(self.diagnosis(&history)));
            };
            (displacement, residual, relative) = next;
            history.push(relative);
        }
        Err(SolidError::NoEquilibrium(self.diagnosis(&history)))
    }

    /// The displacement after the largest share of a step that leaves at most as much of the preconditioned residual as
    /// `most` says, its residual and the norm of that; none if there is no such share.
    fn shortened(
        &self,
        displacement: &[f64],
        step: &DVector<f64>,
        preconditioner: &Factorization,
        most: impl Fn(f64) -> f64,
    ) -> Result<Option<Iterate>, SolidError> {
        let mut share = 1.0;
        while share >= SHORTEST_SHARE {
            let moved = self.body.moved(displacement, step.as_slice(), share);
            if let Ok((residual, relative)) = self.residual(&moved) {
                let next = preconditioned(preconditioner, residual.clone())?;
                if next.norm() <= most(share) {
                    return Ok(Some((moved, residual, relative)));
                }
            }
            share *= 0.5;
        }
        Ok(None)
    }

    fn diagnosis(&self, history: &[f64]) -> String {
        let last = history.iter().rev().take(6).rev();
        let last: Vec<String> = last.map(|r| format!("{r:.1e}")).collect();
        format!(
            "relative residuals {} did not reach {:.0e}",
            last.join(", "),
            self.tolerance
        )
    }
}

/// `K⁻¹ r` of a residual.
fn preconditioned(
    preconditioner: &Factorization,
    mut residual: DVector<f64>,
) -> Result<DVector<f64>, SolidError> {
    preconditioner.solve(residual.as_mut_slice())?;
    Ok(residual)
}
