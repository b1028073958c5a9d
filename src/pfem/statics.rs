//! Static analysis: the load grows in steps from zero to its full value.
//!
//! Each step starts from the solution of the one before; its first Newton iteration is the extrapolation along the tangent
//! of the path. A step that finds no equilibrium is cut in half; after a step that needs few iterations the next ones
//! grow. (To extrapolate displacements through earlier solutions was tried: in a nearly incompressible wall the terms of
//! second order then make the start worse, and three times as many iterations are needed.)

use super::SolidError;
use super::discretization::Discretization;
use super::factor::Factorization;
use super::newton::{self, Equilibrium, NewtonOptions, Residual};
use super::quasi_newton::KeptTangent;
use super::solid::SurfaceLoad;
use super::stats::Stats;
use super::surface::{LoadKind, Surface};

/// Iterations of a load step after which the next one is longer.
const FEW_ITERATIONS: usize = 5;

/// A full load.
#[derive(Debug, Clone)]
pub enum Load<'a> {
    /// On a surface.
    Surface {
        /// Where.
        surface: &'a Surface,
        /// How much.
        values: SurfaceLoad,
        /// On which area.
        kind: LoadKind,
    },
    /// Forces on all coefficients that do not depend on the displacement, N; see [`Discretization::body_forces`].
    Forces(Vec<f64>),
}

/// How the load grows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticOptions {
    /// Load steps to begin with.
    pub steps: usize,
    /// Relative residual of every step.
    pub tolerance: f64,
    /// Newton's method; the full one by default.
    pub newton: NewtonOptions,
}

impl Default for StaticOptions {
    fn default() -> Self {
        Self {
            steps: 4,
            tolerance: 1e-10,
            newton: NewtonOptions {
                max_iterations: 25,
                tangent_cost: None,
            },
        }
    }
}

/// One load step of a static analysis.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadStep {
    /// Share of the full load.
    pub factor: f64,
    /// Relative residuals of Newton's method.
    pub residuals: Vec<f64>,
    /// Displacement coefficients in equilibrium with it.
    pub displacement: Vec<f64>,
}

/// Static equilibrium under the full load.
#[derive(Debug, Clone)]
pub struct Equilibrated {
    /// Displacement coefficients.
    pub displacement: Vec<f64>,
    /// The way there.
    pub steps: Vec<LoadStep>,
    /// What it cost.
    pub stats: Stats,
}

/// Finds the static equilibrium of `body` under all `loads`. Coefficients that are held have their values in `held`
/// times the load factor, or are zero.
pub fn solve(
    body: &Discretization,
    loads: &[Load],
    held: Option<&[f64]>,
    options: &StaticOptions,
) -> Result<Equilibrated, SolidError> {
    body.supports
        .check_rigid_motions(&body.numbering, &body.mapping)?;
    let mut problem = Statics {
        body,
        loads,
        factor: 0.0,
        floor: body.round_off()?,
    };
    let mut stats = Stats::default();
    let mut steps: Vec<LoadStep> = Vec::new();
    let (mut reached, mut d) = (0.0, vec![0.0; body.coefficients()]);
    let mut increment = 1.0 / options.steps.max(1) as f64;
    let shortest = increment / 1024.0;
    loop {
        let mut factor = reached + increment;
        if factor > 1.0 - 1e-9 {
            factor = 1.0;
        }
        problem.factor = factor;
        let mut start = d.clone();

        if let Some(values) = held {
            for (i, &is_held) in body.supports.held().iter().enumerate() {
                if is_held {
                    start[i] = factor * values[i];
                }
            }
        }
        let mut kept: Option<KeptTangent> = None;
        let tolerance = if factor < 1.0 {
            options.tolerance.max(1e-6)
        } else {
            options.tolerance
        };
        match newton::solve(&problem, start, tolerance, &options.newton, &mut kept) {
            Ok(solution) => {
                stats += solution.stats;
                if solution.stats.iterations <= FEW_ITERATIONS {
                    increment *= 1.5;
                }
                steps.push(LoadStep {
                    factor,
                    residuals: solution.residuals,
                    displacement: solution.d.clone(),
                });
                if factor >= 1.0 {
                    return Ok(Equilibrated {
                        displacement: solution.d,
                        steps,
                        stats,
                    });
                }
                (reached, d) = (factor, solution.d);
            }
            Err(error) => {
                increment *= 0.5;
                if increment < shortest {
                    return Err(SolidError::NoEquilibrium(format!(
                        "the load could be raised to {:.2} % only: {error}",
                        100.0 * reached
                    )));
                }
            }
        }
    }
}

/// Finds the static equilibrium under all `loads` at once, by Newton's method from `start`, such as the
/// [prolonged](super::prolongation) solution in a smaller space.
pub fn solve_from(
    body: &Discretization,
    loads: &[Load],
    start: Vec<f64>,
    options: &StaticOptions,
) -> Result<Equilibrated, SolidError> {
    let problem = Statics {
        body,
        loads,
        factor: 1.0,
        floor: body.round_off()?,
    };
    let (tolerance, newton) = (options.tolerance, &options.newton);
    let solution = newton::solve(&problem, start, tolerance, newton, &mut None)?;
    Ok(Equilibrated {
        steps: vec![LoadStep {
            factor: 1.0,
            residuals: solution.residuals,
            displacement: solution.d.clone(),
        }],
        displacement: solution.d,
        stats: solution.stats,
    })
}

fn scaled(load: &SurfaceLoad, factor: f64) -> SurfaceLoad {
    SurfaceLoad {
        pressure: load.pressure.iter().map(|p| factor * p).collect(),
        shear: load.shear.iter().map(|s| s * factor).collect(),
    }
}

struct Statics<'a> {
    body: &'a Discretization,
    loads: &'a [Load<'a>],
    factor: f64,
    floor: f64,
}

impl Statics<'_> {
    /// Forces of all loads at the present load factor.
    fn external(&self, d: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; d.len()];
        for load in self.loads {
            match load {
                Load::Surface {
                    surface,
                    values,
                    kind,
                } => {
                    let values = scaled(values, self.factor);
                    surface.add_forces(&self.body.numbering, d, &values, *kind, &mut forces);
                }
                Load::Forces(full) => {
                    forces
                        .iter_mut()
                        .zip(full)
                        .for_each(|(f, full)| *f += self.factor * full);
                }
            }
        }
        forces
    }
}

impl Equilibrium for Statics<'_> {
    fn residual(&self, d: &[f64]) -> Result<Residual, SolidError> {
        let internal = self.body.restrict(&self.body.internal_forces(d)?);
        let external = self.body.restrict(&self.external(d));
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        Ok(Residual {
            scale: if self.loads.is_empty() {
                norm(&internal)
            } else {
                norm(&external)
            },
            vector: internal.iter().zip(&external).map(|(i, e)| i - e).collect(),
            floor: self.floor,
        })
    }

    fn tangent(&self, d: &[f64], linearized_at: Option<&[f64]>) -> Result<Vec<f64>, SolidError> {
        let following: Vec<(&Surface, SurfaceLoad)> = self
            .loads
            .iter()
            .filter_map(|load| match load {
                Load::Surface {
                    surface,
                    values,
                    kind: LoadKind::Follower,
                } => Some((*surface, scaled(values, self.factor))),
                _ => None,
            })
            .collect();
        let following: Vec<(&Surface, &SurfaceLoad)> =
            following.iter().map(|(s, l)| (*s, l)).collect();
        let mut values = self.body.tangent(d, linearized_at, &following)?;
        self.body.pattern.hold(&mut values);
        Ok(values)
    }

    fn factorize(&self, tangent: &[f64]) -> Result<Factorization, SolidError> {
        self.body.factorize(tangent)
    }

    fn moved(&self, d: &[f64], step: &[f64], scale: f64) -> Vec<f64> {
        self.body.moved(d, step, scale)
    }
}
