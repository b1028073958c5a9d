//! Newton's method with a kept tangent.
//!
//! The factorized tangent is used again as long as the residual falls well, in one solution and in those that follow.
//! The norm of the residual is allowed to rise after a step with a fresh tangent: in a nearly incompressible body the
//! first, linear step always violates incompressibility by a term of second order times the bulk modulus.

use super::super::SolidError;
use super::super::element::predicted_pressure::Volumes;
use super::quasi_newton::KeptTangent;
use super::stats::{Stats, timed};
use std::sync::Arc;

/// A system of nonlinear equations `r(d) = 0` with a symmetric tangent.
pub trait Equilibrium {
    /// Residual at `d`, which is solved with a kept tangent, if there is one, and which a step with it led to from the
    /// residual `previous`.
    fn residual(
        &self,
        d: &[f64],
        kept: Option<&KeptTangent>,
        previous: Option<&Residual>,
    ) -> Result<Residual, SolidError>;
    /// Assembles the tangent `∂r/∂d` at `d`, which is a full step of Newton's method away from `linearized_at`, if
    /// known.
    fn tangent(&self, d: &[f64], linearized_at: Option<&[f64]>) -> Result<Vec<f64>, SolidError>;
    /// Factorizes a tangent that was assembled at `d`.
    fn factorize(&self, d: &[f64], tangent: &[f64]) -> Result<KeptTangent, SolidError>;
    /// `d + scale * step`, where the step is a solution of the linear system.
    fn moved(&self, d: &[f64], step: &[f64], scale: f64) -> Vec<f64>;
}

/// The residual and what it is measured against.
#[derive(Debug, Clone)]
pub struct Residual {
    /// Entries of the equations.
    pub vector: Vec<f64>,
    /// Euclidean norm of the forces whose difference the residual is.
    pub scale: f64,
    /// Norm below which the residual is round-off.
    pub floor: f64,
    /// From which the pressure of the next iterate is predicted, if it is.
    pub volumes: Option<Arc<Volumes>>,
}

impl Residual {
    /// Euclidean norm.
    pub fn norm(&self) -> f64 {
        self.vector.iter().map(|r| r * r).sum::<f64>().sqrt()
    }

    fn relative(&self) -> f64 {
        let norm = self.norm();
        if norm <= self.floor {
            0.0
        } else {
            norm / self.scale
        }
    }
}

/// When to stop and when to factorize again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewtonOptions {
    /// Most iterations of one solution.
    pub max_iterations: usize,
    /// What a fresh tangent costs, in iterations with a kept one; `None` is the full Newton method with a fresh tangent
    /// in each iteration.
    pub tangent_cost: Option<f64>,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self {
            max_iterations: 25,
            tangent_cost: Some(10.0),
        }
    }
}

/// A solution and the way to it.
#[derive(Debug, Clone)]
pub struct Solution {
    /// `d` with `r(d) = 0`.
    pub d: Vec<f64>,
    /// Relative residuals, from the start to the last.
    pub residuals: Vec<f64>,
    /// What it cost.
    pub stats: Stats,
}

/// Solves `problem` from `start` to the relative residual `tolerance`. `kept` is a tangent from earlier solutions,
/// replaced when it has become too old.
pub fn solve(
    problem: &impl Equilibrium,
    start: Vec<f64>,
    tolerance: f64,
    options: &NewtonOptions,
    kept: &mut Option<KeptTangent>,
) -> Result<Solution, SolidError> {
    let mut stats = Stats::default();
    let mut d = start;
    let mut residual = evaluate(problem, &d, kept.as_ref(), None, &mut stats)?;
    let mut history = vec![residual.relative()];
    // Relative residuals since the tangent in use was taken up.
    let mut since = history.clone();
    let mut linearized_at: Option<Vec<f64>> = None;
    let mut rises = 0;
    loop {
        let previous = history[history.len() - 1];
        // A load that has changed by less than the tolerance still has its answer, which a coupling waits for.
        if previous <= tolerance && (stats.iterations > 0 || previous == 0.0) {
            break;
        }
        if stats.iterations == options.max_iterations || rises > 4 {
            return Err(SolidError::NoEquilibrium(diagnosis(&history, tolerance)));
        }
        if kept.is_some() && !pays(&since, tolerance, options) {
            *kept = None;
        }
        let fresh = kept.is_none();
        let tangent = match kept {
            Some(tangent) => tangent,
            None => {
                let fresh = linearized(problem, &d, linearized_at.as_deref(), &mut stats)?;
                since = vec![previous];
                let fresh = kept.insert(fresh);
                if fresh.predicts_pressure() {
                    residual = evaluate(problem, &d, Some(fresh), None, &mut stats)?;
                }
                fresh
            }
        };
        let mut step = residual.vector.clone();
        timed(&mut stats.substitution_s, || tangent.solve(&mut step))?;
        stats.iterations += 1;

        let taken = stepped(problem, &d, &step, (tangent, fresh), &residual, &mut stats)?;
        let Some((moved, new, scale)) = taken.filter(|(_, new, _)| {
            let relative = new.relative();
            fresh || relative < previous || (stats.iterations == 1 && relative < 1.0)
        }) else {
            // The old tangent led astray: forget it together with its step.
            *kept = None;
            continue;
        };
        let relative = new.relative();
        rises = if relative > previous { rises + 1 } else { 0 };
        if relative < previous && !tangent.predicts_pressure() {
            let change = (new.vector.iter().zip(&residual.vector)).map(|(new, old)| new - old);
            let change = change.collect();
            step.iter_mut().for_each(|s| *s *= scale);
            tangent.learn(step, change);
        }
        let old = std::mem::replace(&mut d, moved);
        linearized_at = fresh.then_some(old);
        residual = new;
        history.push(relative);
        since.push(relative);
    }
    if let Some(tangent) = kept {
        tangent.solved();
    }
    Ok(Solution {
        d,
        residuals: history,
        stats,
    })
}

/// The residual at `d`, if the stresses are finite there.
fn evaluate(
    problem: &impl Equilibrium,
    d: &[f64],
    kept: Option<&KeptTangent>,
    previous: Option<&Residual>,
    stats: &mut Stats,
) -> Result<Residual, SolidError> {
    stats.residuals += 1;
    let residual = timed(&mut stats.residual_s, || {
        problem.residual(d, kept, previous)
    })?;
    // A finite difference of infinite forces would be taken for an equilibrium.
    if residual.norm().is_finite() && residual.scale.is_finite() {
        return Ok(residual);
    }
    Err(SolidError::NoEquilibrium(
        "the stresses overflow; the load is too large for one step: take smaller ones".into(),
    ))
}

/// A fresh tangent at `d`.
fn linearized(
    problem: &impl Equilibrium,
    d: &[f64],
    linearized_at: Option<&[f64]>,
    stats: &mut Stats,
) -> Result<KeptTangent, SolidError> {
    stats.assemblies += 1;
    let values = timed(&mut stats.assembly_s, || problem.tangent(d, linearized_at))?;
    stats.factorizations += 1;
    timed(&mut stats.factorization_s, || problem.factorize(d, &values))
}

/// Where a step leads: the new place, its residual, and by what the step was scaled. One with a fresh tangent that
/// turns an element inside out is shortened; one with an old tangent leads nowhere then.
fn stepped(
    problem: &impl Equilibrium,
    d: &[f64],
    step: &[f64],
    (tangent, fresh): (&KeptTangent, bool),
    residual: &Residual,
    stats: &mut Stats,
) -> Result<Option<(Vec<f64>, Residual, f64)>, SolidError> {
    let mut scale = -1.0;
    loop {
        let moved = problem.moved(d, step, scale);
        match evaluate(problem, &moved, Some(tangent), Some(residual), stats) {
            Ok(new) => return Ok(Some((moved, new, scale))),
            Err(_) if !fresh => return Ok(None),
            Err(error) if f64::abs(scale) < 0.02 => return Err(error),
            Err(_) => scale *= 0.5,
        }
    }
}

/// Iterations that a solution needs with a fresh tangent.
const FRESH_ITERATIONS: f64 = 3.0;

/// Whether to go on with a tangent that has led to the relative residuals `since`, as far as their decay tells.
fn pays(since: &[f64], tolerance: f64, options: &NewtonOptions) -> bool {
    let Some(cost) = options.tangent_cost else {
        return false;
    };
    // The first step may raise the residual, by terms of second order.
    let span = since.len().saturating_sub(2).min(2);
    if span == 0 {
        return true;
    }
    let last = since[since.len() - 1];
    let decay = (last / since[since.len() - 1 - span]).ln() / span as f64;
    decay < 0.0 && (tolerance / last).ln() / decay < cost + FRESH_ITERATIONS
}

fn diagnosis(history: &[f64], tolerance: f64) -> String {
    let last: Vec<String> = history
        .iter()
        .rev()
        .take(8)
        .rev()
        .map(|r| format!("{r:.1e}"))
        .collect();
    format!(
        "relative residuals {} did not reach {tolerance:.0e} in {} Newton iterations; take smaller steps",
        last.join(", "),
        history.len() - 1
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forces that overflow.
    struct Burst;

    impl Equilibrium for Burst {
        fn residual(
            &self,
            _: &[f64],
            _: Option<&KeptTangent>,
            _: Option<&Residual>,
        ) -> Result<Residual, SolidError> {
            Ok(Residual {
                vector: vec![1.0],
                scale: f64::INFINITY,
                floor: 0.0,
                volumes: None,
            })
        }

        fn tangent(&self, _: &[f64], _: Option<&[f64]>) -> Result<Vec<f64>, SolidError> {
            unreachable!("there is nothing to linearize")
        }

        fn factorize(&self, _: &[f64], _: &[f64]) -> Result<KeptTangent, SolidError> {
            unreachable!("there is nothing to factorize")
        }

        fn moved(&self, d: &[f64], _: &[f64], _: f64) -> Vec<f64> {
            d.to_vec()
        }
    }

    #[test]
    fn infinite_forces_are_no_equilibrium() {
        let found = solve(
            &Burst,
            vec![0.0],
            1e-6,
            &NewtonOptions::default(),
            &mut None,
        );
        assert!(matches!(found, Err(SolidError::NoEquilibrium(_))));
    }
}
