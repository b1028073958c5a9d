//! Static analysis: the load grows in steps from zero to its full value.
//!
//! Each step starts from the solution of the one before; its first Newton iteration is the extrapolation along the
//! tangent of the path. A step that finds no equilibrium is cut in half; after a step that needs few iterations the
//! next ones grow. (To extrapolate displacements through earlier solutions was tried: in a nearly incompressible wall
//! the terms of second order then make the start worse, and three times as many iterations are needed.)
//!
//! An equilibrium whose tangent has negative eigenvalues is unstable. The step is then cut too, since a long one may
//! have led past a stable path that turns; if that does not help, the path has lost its stability, and
//! [`AtBifurcation`] says what to do. The stable path that branches off is reached with a small force in the direction
//! of the buckling mode, which is taken away beyond the bifurcation.

use super::super::SolidError;
use super::super::discretization::Discretization;
use super::super::element::surface::{LoadKind, Surface};
use super::super::solid::SurfaceLoad;
use super::listener;
use super::newton::{self, Equilibrium, NewtonOptions, Residual};
use super::quasi_newton::KeptTangent;
use super::stability::{self, AtBifurcation, Bifurcation, LowestMode};
use super::stats::Stats;
use std::cell::OnceCell;

/// Iterations of a load step after which the next one is longer.
const FEW_ITERATIONS: usize = 5;
/// Share of the full load within which a bifurcation is enclosed before its place is interpolated.
const ENCLOSURE: f64 = 2e-3;
/// Eigenvalues above minus this share of the unloaded body's lowest one are not negative: those of a straight tube's
/// bend are zero in any direction across it.
const INDIFFERENT: f64 = 1e-3;
/// Share of the critical load at which the force is applied that leads to the stable branch.
const BELOW: f64 = 0.9;
/// By how much the load exceeds the critical one before the force is taken away that led to the stable branch.
const BEYOND: f64 = 1.05;
/// Displacement that this force causes when it is applied, relative to the size of an element.
const PUSH: f64 = 0.02;

/// A full load.
#[derive(Debug, Clone)]
pub enum Load<'a> {
    /// On a surface.
    Surface {
        /// Where.
        surface: &'a Surface,
        /// How much there is of it from the beginning, if not nothing.
        before: Option<SurfaceLoad>,
        /// How much in the end.
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
    /// Relative residual of the last step.
    pub tolerance: f64,
    /// Relative residual of the steps before, if that is larger.
    pub tolerance_on_the_way: f64,
    /// Newton's method; the full one by default.
    pub newton: NewtonOptions,
    /// What to do where the path loses its stability.
    pub at_bifurcation: AtBifurcation,
}

impl Default for StaticOptions {
    fn default() -> Self {
        Self {
            steps: 4,
            tolerance: 1e-10,
            tolerance_on_the_way: 1e-6,
            newton: NewtonOptions {
                max_iterations: 25,
                tangent_cost: None,
            },
            at_bifurcation: AtBifurcation::default(),
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

/// Static equilibrium under the full load, or what was reached of it.
#[derive(Debug, Clone)]
pub struct Equilibrated {
    /// Displacement coefficients without load: zero, or those of a body that was stretched before.
    pub unloaded: Vec<f64>,
    /// Share of the full load: less than one if the analysis ended at a bifurcation.
    pub factor: f64,
    /// Displacement coefficients.
    pub displacement: Vec<f64>,
    /// Where stability was lost first, if it was watched and lost.
    pub bifurcation: Option<Bifurcation>,
    /// The way there.
    pub steps: Vec<LoadStep>,
    /// What it cost.
    pub stats: Stats,
}

impl Equilibrated {
    /// The displacement under the full load; an error if the analysis ended at a bifurcation.
    pub fn complete(self) -> Result<Self, SolidError> {
        if self.factor >= 1.0 {
            return Ok(self);
        }
        Err(SolidError::NoEquilibrium(format!(
            "it loses its stability at {:.2} % of the load",
            100.0 * self.factor
        )))
    }
}

/// Finds the static equilibrium of `body` under all `loads`. Coefficients that are held have their values in `held`
/// times the load factor, or are zero.
pub fn solve(
    body: &Discretization,
    loads: &[Load],
    held: Option<&[f64]>,
    options: &StaticOptions,
) -> Result<Equilibrated, SolidError> {
    let unloaded = vec![0.0; body.coefficients()];
    let prescribed = held.map(|values| Prescribed {
        values,
        is_guess: false,
    });
    follow(body, loads, unloaded, prescribed, options)
}

/// The same from an equilibrium without loads, such as [`stretch`] finds: what is held stays where it is there.
pub fn solve_onto(
    body: &Discretization,
    unloaded: Vec<f64>,
    loads: &[Load],
    options: &StaticOptions,
) -> Result<Equilibrated, SolidError> {
    follow(body, loads, unloaded, None, options)
}

/// Equilibrium without loads of a body whose held coefficients are moved to the values in `guess`; each step begins
/// with its share of the whole guess, so that no element has to take up all of it.
///
/// # Errors
/// If there is none, or the body buckles on the way.
pub fn stretch(
    body: &Discretization,
    guess: &[f64],
    options: &StaticOptions,
) -> Result<Equilibrated, SolidError> {
    let prescribed = Some(Prescribed {
        values: guess,
        is_guess: true,
    });
    let found = follow(
        body,
        &[],
        vec![0.0; body.coefficients()],
        prescribed,
        options,
    )?;
    if found.factor < 1.0 {
        return Err(SolidError::NoEquilibrium(format!(
            "it buckles when its ends are moved, at {:.2} % of the way",
            100.0 * found.factor
        )));
    }
    Ok(found)
}

fn follow(
    body: &Discretization,
    loads: &[Load],
    unloaded: Vec<f64>,
    prescribed: Option<Prescribed>,
    options: &StaticOptions,
) -> Result<Equilibrated, SolidError> {
    body.check_rigid_motions()?;
    let moved = |f: &Prescribed| f.is_guess;
    let mut problem = Statics {
        whole: body,
        partly: None,
        loads,
        factor: 0.0,
        push: None,
        unloaded: OnceCell::new(),
        floor: body.round_off()?,
        has_reactions: prescribed.as_ref().is_some_and(moved)
            || unloaded.iter().any(|&d| d != 0.0)
            || body.is_prestretched(),
    };
    let mut path = Path {
        prescribed,
        options,
        factor: 0.0,
        displacement: unloaded.clone(),
        unloaded: unloaded.clone(),
        increment: 1.0 / options.steps.max(1) as f64,
        steps: Vec::new(),
        stats: Stats::default(),
    };
    let bifurcation = path.follow(&mut problem, 1.0, true)?;
    if let Some(bifurcation) = &bifurcation {
        match options.at_bifurcation {
            AtBifurcation::Stop => {}
            AtBifurcation::Continue => {
                path.follow(&mut problem, 1.0, false)?;
            }
            AtBifurcation::Switch => path.switch(&mut problem, bifurcation)?,
        }
    }
    Ok(Equilibrated {
        unloaded,
        factor: path.factor,
        displacement: path.displacement,
        bifurcation,
        steps: path.steps,
        stats: path.stats,
    })
}

/// Displacement coefficients that grow with the load factor.
struct Prescribed<'a> {
    /// At the full load; those that are held count.
    values: &'a [f64],
    /// Whether the others are worth starting from.
    is_guess: bool,
}

/// A path of equilibria, as far as it is known.
struct Path<'a> {
    prescribed: Option<Prescribed<'a>>,
    options: &'a StaticOptions,
    /// Displacement coefficients at the factor zero.
    unloaded: Vec<f64>,
    /// Share of the full load.
    factor: f64,
    displacement: Vec<f64>,
    /// The next step.
    increment: f64,
    steps: Vec<LoadStep>,
    stats: Stats,
}

impl Path<'_> {
    /// Raises the load to the `target`, or to where stability is lost if that is watched.
    fn follow(
        &mut self,
        problem: &mut Statics,
        target: f64,
        watched: bool,
    ) -> Result<Option<Bifurcation>, SolidError> {
        let shortest = 1.0 / (1024 * self.options.steps.max(1)) as f64;
        while self.factor < target {
            let mut factor = self.factor + self.increment;
            if factor > target - 1e-9 {
                factor = target;
            }
            problem.set_factor(factor)?;
            let mut kept: Option<KeptTangent> = None;
            match self.step(problem, &mut kept) {
                Ok(solution) => {
                    let unstable = |kept: &KeptTangent| kept.negative_eigenvalues() > 0;
                    if watched
                        && kept.as_ref().is_some_and(unstable)
                        && !problem.is_stable(&solution.d)?
                    {
                        if factor - self.factor > ENCLOSURE {
                            self.increment = 0.5 * (factor - self.factor);
                            continue;
                        }
                        let beyond = problem.lowest_mode(&solution.d)?;
                        return self.bifurcation(problem, factor, beyond).map(Some);
                    }
                    if solution.stats.iterations <= FEW_ITERATIONS {
                        self.increment *= 1.5;
                    }
                    self.accept(factor, solution);
                }
                Err(error) => {
                    self.increment *= 0.5;
                    if self.increment < shortest {
                        return Err(SolidError::NoEquilibrium(format!(
                            "the load could be raised to {:.2} % only: {error}",
                            100.0 * self.factor
                        )));
                    }
                }
            }
        }
        Ok(None)
    }

    /// Solves at the present load of the problem.
    fn step(
        &self,
        problem: &Statics,
        kept: &mut Option<KeptTangent>,
    ) -> Result<newton::Solution, SolidError> {
        let mut start = self.displacement.clone();
        if let Some(Prescribed { values, is_guess }) = self.prescribed {
            for (i, &is_held) in problem.body().supports.held().iter().enumerate() {
                if is_held {
                    start[i] = problem.factor * values[i];
                } else if is_guess {
                    start[i] += (problem.factor - self.factor) * values[i];
                }
            }
        }
        let options = self.options;
        let tolerance = match problem.factor < 1.0 {
            true => options.tolerance.max(options.tolerance_on_the_way),
            false => options.tolerance,
        };
        newton::solve(problem, start, tolerance, &options.newton, kept)
    }

    fn accept(&mut self, factor: f64, solution: newton::Solution) {
        self.stats += solution.stats;
        self.steps.push(LoadStep {
            factor,
            residuals: solution.residuals,
            displacement: solution.d.clone(),
        });
        (self.factor, self.displacement) = (factor, solution.d);
        listener::tell("loading the wall", factor);
    }

    /// The bifurcation between the present load and the one at which the mode `beyond` has a negative eigenvalue.
    fn bifurcation(
        &self,
        problem: &mut Statics,
        unstable: f64,
        beyond: LowestMode,
    ) -> Result<Bifurcation, SolidError> {
        problem.set_factor(self.factor)?;
        let before = problem.lowest_mode(&self.displacement)?.eigenvalue.max(0.0);
        let share = before / (before - beyond.eigenvalue.min(-f64::MIN_POSITIVE));
        Ok(Bifurcation {
            factor: self.factor + share * (unstable - self.factor),
            displacement: self.displacement.clone(),
            mode: beyond.shape,
        })
    }

    /// Follows the stable path that branches off at a bifurcation.
    fn switch(
        &mut self,
        problem: &mut Statics,
        bifurcation: &Bifurcation,
    ) -> Result<(), SolidError> {
        let lost = |why: &str| {
            SolidError::NoEquilibrium(format!(
                "the stable path beyond the bifurcation at {:.2} % of the load was not found: {why}",
                100.0 * bifurcation.factor
            ))
        };
        // Back to where the force bends the body a little and not yet out of all proportion.
        let is_below = |step: &LoadStep| step.factor <= BELOW * bifurcation.factor;
        self.steps.retain(is_below);
        (self.factor, self.displacement) = match self.steps.last() {
            Some(step) => (step.factor, step.displacement.clone()),
            None => (0.0, self.unloaded.clone()),
        };
        problem.set_factor(self.factor)?;
        let mode = problem.lowest_mode(&self.displacement)?;
        let push = PUSH * problem.body().element_size();
        problem.push = Some(mode.force.iter().map(|f| f * push).collect());
        self.increment = (1.0 - BELOW) * bifurcation.factor;
        let target = f64::min(1.0, BEYOND * bifurcation.factor);
        if self.follow(problem, target, true)?.is_some() {
            return Err(lost("with a push along the mode it is unstable, too"));
        }
        problem.push = None;
        let solution = self.step(problem, &mut None)?;
        if !problem.is_stable(&solution.d)? {
            return Err(lost("without the push it is unstable, too"));
        }
        self.accept(problem.factor, solution);
        if self.follow(problem, 1.0, true)?.is_some() {
            return Err(lost("it bifurcates again"));
        }
        Ok(())
    }
}

/// Finds the static equilibrium under all `loads` at once, by Newton's method from `start`, such as the
/// [prolonged](super::super::space::prolongation) solution in a smaller space.
pub fn solve_from(
    body: &Discretization,
    loads: &[Load],
    start: Vec<f64>,
    options: &StaticOptions,
) -> Result<Equilibrated, SolidError> {
    let problem = Statics {
        whole: body,
        partly: None,
        loads,
        factor: 1.0,
        push: None,
        unloaded: OnceCell::new(),
        floor: body.round_off()?,
        has_reactions: false,
    };
    let (tolerance, newton) = (options.tolerance, &options.newton);
    let solution = newton::solve(&problem, start, tolerance, newton, &mut None)?;
    Ok(Equilibrated {
        unloaded: vec![0.0; body.coefficients()],
        factor: 1.0,
        bifurcation: None,
        steps: vec![LoadStep {
            factor: 1.0,
            residuals: solution.residuals,
            displacement: solution.d.clone(),
        }],
        displacement: solution.d,
        stats: solution.stats,
    })
}

/// The load on a surface at a load factor.
fn at_factor(before: Option<&SurfaceLoad>, load: &SurfaceLoad, factor: f64) -> SurfaceLoad {
    let mut at = SurfaceLoad {
        pressure: load.pressure.iter().map(|p| factor * p).collect(),
        shear: load.shear.iter().map(|s| s * factor).collect(),
    };
    if let Some(before) = before {
        let pressures = at.pressure.iter_mut().zip(&before.pressure);
        pressures.for_each(|(p, before)| *p += (1.0 - factor) * before);
        let shears = at.shear.iter_mut().zip(&before.shear);
        shears.for_each(|(s, before)| *s += before * (1.0 - factor));
    }
    at
}

struct Statics<'a> {
    /// Prestretched as much as it is.
    whole: &'a Discretization,
    /// Prestretched by the share of the load, if it is prestretched and that share is not 1.
    partly: Option<Discretization>,
    loads: &'a [Load<'a>],
    factor: f64,
    /// Forces that lead away from an unstable path, N.
    push: Option<Vec<f64>>,
    /// The lowest eigenvalue without load.
    unloaded: OnceCell<f64>,
    floor: f64,
    /// Whether ends that were moved exert forces, against which the residual is measured too.
    has_reactions: bool,
}

impl Statics<'_> {
    /// The body at the present load.
    fn body(&self) -> &Discretization {
        self.partly.as_ref().unwrap_or(self.whole)
    }

    /// Sets the load factor, and the logarithm of the prestretch with it.
    fn set_factor(&mut self, factor: f64) -> Result<(), SolidError> {
        self.factor = factor;
        let is_partly = self.whole.is_prestretched() && factor != 1.0;
        self.partly = match is_partly {
            true => Some(self.whole.prestretched_by(factor)?),
            false => None,
        };
        Ok(())
    }

    /// Whether an equilibrium at the present load is stable, or indifferent.
    fn is_stable(&self, d: &[f64]) -> Result<bool, SolidError> {
        let unloaded = match self.unloaded.get() {
            Some(&eigenvalue) => eigenvalue,
            None => {
                let rest = vec![0.0; d.len()];
                let mut tangent = self.body().tangent(&rest, None, &[])?;
                self.body().pattern.hold(&mut tangent);
                let factorization = self.body().factorize(&tangent)?;
                let lowest = stability::lowest_mode(self.body(), &factorization)?;
                *self.unloaded.get_or_init(|| lowest.eigenvalue)
            }
        };
        let mut tangent = self.tangent(d, None)?;
        (self.body().pattern).add_diagonal(INDIFFERENT * unloaded, &mut tangent);
        Ok(self.body().is_positive_definite(&tangent))
    }

    /// The mode whose eigenvalue is closest to zero, at the present load.
    fn lowest_mode(&self, d: &[f64]) -> Result<LowestMode, SolidError> {
        let factorization = self.body().factorize(&self.tangent(d, None)?)?;
        stability::lowest_mode(self.body(), &factorization)
    }

    /// Forces of all loads at the present load factor.
    fn external(&self, d: &[f64]) -> Vec<f64> {
        let mut forces = self.push.clone().unwrap_or_else(|| vec![0.0; d.len()]);
        for load in self.loads {
            match load {
                Load::Surface {
                    surface,
                    before,
                    values,
                    kind,
                } => {
                    let values = at_factor(before.as_ref(), values, self.factor);
                    surface.add_forces(&self.body().numbering, d, &values, *kind, &mut forces);
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
    fn residual(
        &self,
        d: &[f64],
        _: Option<&KeptTangent>,
        _: Option<&Residual>,
    ) -> Result<Residual, SolidError> {
        let all = self.body().internal_forces(d)?;
        let internal = self.body().restrict(&all);
        let external = self.body().restrict(&self.external(d));
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let scale = match self.loads {
            [] => norm(&internal),
            _ => norm(&external),
        };
        Ok(Residual {
            scale: if self.has_reactions {
                scale.max(norm(&all))
            } else {
                scale
            },
            vector: internal.iter().zip(&external).map(|(i, e)| i - e).collect(),
            floor: self.floor,
            volumes: None,
        })
    }

    fn tangent(&self, d: &[f64], linearized_at: Option<&[f64]>) -> Result<Vec<f64>, SolidError> {
        let following: Vec<(&Surface, SurfaceLoad)> = self
            .loads
            .iter()
            .filter_map(|load| match load {
                Load::Surface {
                    surface,
                    before,
                    values,
                    kind: LoadKind::Follower,
                } => {
                    let values = at_factor(before.as_ref(), values, self.factor);
                    Some((*surface, values))
                }
                _ => None,
            })
            .collect();
        let following: Vec<(&Surface, &SurfaceLoad)> =
            following.iter().map(|(s, l)| (*s, l)).collect();
        let mut values = self.body().tangent(d, linearized_at, &following)?;
        self.body().pattern.hold(&mut values);
        Ok(values)
    }

    fn factorize(&self, _: &[f64], tangent: &[f64]) -> Result<KeptTangent, SolidError> {
        Ok(KeptTangent::new(self.body().factorize(tangent)?, None))
    }

    fn moved(&self, d: &[f64], step: &[f64], scale: f64) -> Vec<f64> {
        self.body().moved(d, step, scale)
    }
}
