//! The dynamic structure: Newmark's method or implicit Euler in time, Newton's in every step.
//!
//! Unknowns are the displacement coefficients `d` at the end of a step of length `dt`. With Newmark's parameters
//! `β = 1/4`, `γ = 1/2` (the trapezoidal rule: second order, no numerical damping)
//! ```text
//! a = (d - d_n)/(β dt²) - v_n/(β dt) - (1/(2β) - 1) a_n,      v = v_n + dt ((1 - γ) a_n + γ a),
//! r(d) = M (a + α v) + f_int(d) - f_ext(d) = 0,                K = ∂(f_int - f_ext)/∂d + (1/(β dt²) + α γ/(β dt)) M
//! ```
//! where `α` is the mass-proportional damping (section 2.1); with implicit Euler (first order, damps much)
//! `v = (d - d_n)/dt` and `a = (v - v_n)/dt`.

use super::discretization::{self, Discretization};
use super::factor::Factorization;
use super::locate::{Location, Locator};
use super::modes::{self, NaturalMode};
use super::newton::{self, Equilibrium, NewtonOptions, Residual};
use super::quasi_newton::{Experience, KeptTangent};
use super::solid::{Solid, SolidError, SurfaceLoad, SurfacePoint};
use super::stats::Stats;
use super::supports::{self, Support};
use super::surface::{LoadKind, Surface};
use super::time_scheme::TimeScheme;
use crate::Vec3;
use crate::case::Material;
use crate::geometry::HexMesh;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;

/// Most halvings of the load when a step finds no equilibrium at once.
const MAX_CUTS: u32 = 6;

/// Choices of a dynamic structure.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureOptions {
    /// Space, mapping and quadrature.
    pub discretization: discretization::Options,
    /// Density of the reference configuration, kg/m³.
    pub density: f64,
    /// Mass-proportional damping `α`, 1/s.
    pub damping: f64,
    /// Time integration.
    pub time_scheme: TimeScheme,
    /// Newton's method.
    pub newton: NewtonOptions,
    /// Surface that carries the load.
    pub wet_surface: String,
    /// Supports.
    pub supports: Vec<Support>,
}

/// Displacement, velocity and acceleration coefficients of all functions, held ones included.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Displacement, m.
    pub d: Vec<f64>,
    /// Velocity, m/s.
    pub v: Vec<f64>,
    /// Acceleration, m/s².
    pub a: Vec<f64>,
}

/// What a tangent was assembled from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Linearization {
    /// Displacement coefficients, m.
    pub d: Vec<f64>,
    /// Those that a full step of Newton's method led from to `d`.
    pub linearized_at: Option<Vec<f64>>,
    /// The load.
    pub load: SurfaceLoad,
    /// Length of the time step, s.
    pub dt: f64,
}

/// All that a structure keeps from one time step to the next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// The accepted state.
    pub state: State,
    /// Whence the kept tangent comes, and the experience with it. They decide how Newton's method goes on, and so the
    /// last digits.
    pub tangent: Option<(Linearization, Experience)>,
}

/// A factorized tangent, and what it was assembled from.
struct Kept {
    from: Linearization,
    tangent: KeptTangent,
}

/// The solution of a time step that has not been accepted.
#[derive(Debug, Clone)]
pub struct Trial {
    /// State at the end of the step.
    pub state: State,
    /// Relative residuals of Newton's method.
    pub residuals: Vec<f64>,
    /// What the solution cost.
    pub stats: Stats,
}

/// A structure in motion.
pub struct Structure {
    body: Discretization,
    wet: Surface,
    locator: Locator,
    /// Density times the mass integrals, one scalar per pair of functions.
    mass: Vec<f64>,
    damping: f64,
    time_scheme: TimeScheme,
    newton: NewtonOptions,
    floor: f64,
    state: State,
    /// Tangent of an earlier solution.
    kept: Option<Kept>,
    total: Stats,
}

impl Structure {
    /// A structure at rest in its reference configuration; `materials` by region of the mesh.
    pub fn new(
        mesh: &HexMesh,
        materials: &[Material],
        options: &StructureOptions,
    ) -> Result<Self, SolidError> {
        let discretization = &options.discretization;
        let body = Discretization::new(mesh, materials, &options.supports, discretization)?;
        let faces = supports::surface(mesh, &options.wet_surface)?;
        let points = discretization
            .quadrature_points
            .into_iter()
            .max()
            .unwrap_or(1);
        let wet = Surface::new(&body.numbering, &body.space, &body.mapping, faces, points)?;
        let locator = Locator::new(&body, faces);
        let mut mass = body.pattern.scalar_values(|e| body.elements.mass(e));
        mass.iter_mut().for_each(|m| *m *= options.density);
        let zero = vec![0.0; body.coefficients()];
        Ok(Self {
            floor: body.round_off()?,
            wet,
            locator,
            mass,
            damping: options.damping,
            time_scheme: options.time_scheme,
            newton: options.newton,
            state: State {
                d: zero.clone(),
                v: zero.clone(),
                a: zero,
            },
            kept: None,
            total: Stats::default(),
            body,
        })
    }

    /// The discretized body.
    pub fn body(&self) -> &Discretization {
        &self.body
    }

    /// The loaded surface.
    pub fn wet_surface(&self) -> &Surface {
        &self.wet
    }

    /// The last accepted state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Replaces the accepted state, as when a run is resumed, and forgets the kept tangent.
    pub fn set_state(&mut self, state: State) -> Result<(), SolidError> {
        let expected = self.body.coefficients();
        for (name, vector) in [
            ("displacement", &state.d),
            ("velocity", &state.v),
            ("acceleration", &state.a),
        ] {
            if vector.len() != expected {
                return Err(SolidError::Model(format!(
                    "the stored {name} has {} coefficients, the structure {expected}: it belongs to another discretization",
                    vector.len()
                )));
            }
        }
        self.state = state;
        self.refresh();
        Ok(())
    }

    /// What is needed to continue later, to the last bit.
    pub fn memory(&self) -> Memory {
        Memory {
            state: self.state.clone(),
            tangent: (self.kept.as_ref())
                .map(|kept| (kept.from.clone(), kept.tangent.experience.clone())),
        }
    }

    /// Continues as the structure whose memory this is.
    pub fn recall(&mut self, memory: Memory) -> Result<(), SolidError> {
        self.set_state(memory.state)?;
        let Some((from, experience)) = memory.tangent else {
            return Ok(());
        };
        self.check(&from.load)?;
        let lengths = [Some(&from.d), from.linearized_at.as_ref()];
        if lengths
            .iter()
            .flatten()
            .any(|d| d.len() != self.state.d.len())
        {
            return Err(SolidError::Model(
                "the stored tangent belongs to another discretization".into(),
            ));
        }
        let step = TimeStep {
            structure: self,
            load: &from.load,
            dt: from.dt,
            offset: None,
            assembled: &RefCell::new(None),
        };
        let tangent = step.tangent(&from.d, from.linearized_at.as_deref())?;
        let factorization = step.factorize(&tangent)?;
        self.kept = Some(Kept {
            from,
            tangent: KeptTangent::new(factorization, experience),
        });
        Ok(())
    }

    /// Forgets the kept tangent, so that the next solution depends on nothing but the state, the load and the start.
    /// A run that refreshes when it writes a checkpoint is repeated bit by bit by one that resumes there.
    pub fn refresh(&mut self) {
        self.kept = None;
    }

    /// Cost of all solutions so far.
    pub fn stats(&self) -> Stats {
        self.total
    }

    /// Strain energy (J) of a displacement with `points` Gauss points per direction.
    pub fn strain_energy(&self, d: &[f64], points: [usize; 3]) -> Result<f64, SolidError> {
        self.body.energy(d, points)
    }

    /// Kinetic energy (J) of a velocity.
    pub fn kinetic_energy(&self, v: &[f64]) -> f64 {
        let momentum = self.body.pattern.multiply_scalar(&self.mass, v);
        0.5 * momentum.iter().zip(v).map(|(p, v)| p * v).sum::<f64>()
    }

    /// The `count` lowest natural modes of the undeformed structure.
    pub fn natural_modes(&self, count: usize) -> Result<Vec<NaturalMode>, SolidError> {
        modes::lowest(&self.body, &self.mass, count)
    }

    fn check(&self, load: &SurfaceLoad) -> Result<(), SolidError> {
        let points = self.wet.points.len();
        if load.pressure.len() != points || load.shear.len() != points {
            return Err(SolidError::Model(format!(
                "the load has {} pressures and {} shears, but the wet surface {points} quadrature points",
                load.pressure.len(),
                load.shear.len()
            )));
        }
        let finite = load.pressure.iter().all(|p| p.is_finite())
            && load.shear.iter().all(|s| s.iter().all(|c| c.is_finite()));
        if !finite {
            return Err(SolidError::Model(
                "the load on the wet surface is not finite".into(),
            ));
        }
        Ok(())
    }

    /// Newton's method from `start`; if that fails, from the old state with a fresh tangent in each iteration, and then
    /// with the residual there taken away and given back in smaller and smaller portions.
    fn robust_solve(
        &mut self,
        load: &SurfaceLoad,
        dt: f64,
        tolerance: f64,
        start: Vec<f64>,
    ) -> Result<newton::Solution, SolidError> {
        let kept = self.kept.take().filter(|kept| kept.from.dt == dt);
        let (mut kept, from) = kept.map(|k| (k.tangent, k.from)).unzip();
        let assembled = RefCell::new(from);
        let step = TimeStep {
            structure: self,
            load,
            dt,
            offset: None,
            assembled: &assembled,
        };
        let mut cost = Stats::default();
        let direct = newton::solve(&step, start, tolerance, &self.newton, &mut kept);
        let result = match direct {
            Ok(solution) => Ok(solution),
            Err(_) => {
                kept = None;
                let full = NewtonOptions {
                    tangent_cost: None,
                    ..self.newton
                };
                continuation(
                    &step,
                    self.state.d.clone(),
                    tolerance,
                    &full,
                    &mut kept,
                    &mut cost,
                )
            }
        };
        // There is never more than one factorization, so it is of the tangent that was assembled last.
        self.kept = kept
            .zip(assembled.into_inner())
            .map(|(tangent, from)| Kept { from, tangent });
        let mut solution = result?;
        solution.stats += cost;
        Ok(solution)
    }
}

/// Solves `r(d) = (1 - λ) r(d_0)` for λ growing from 0 to 1.
fn continuation(
    step: &TimeStep,
    start: Vec<f64>,
    tolerance: f64,
    options: &NewtonOptions,
    kept: &mut Option<KeptTangent>,
    cost: &mut Stats,
) -> Result<newton::Solution, SolidError> {
    let initial = step.residual(&start)?.vector;
    let (mut d, mut reached, mut increment) = (start, 0.0, 1.0);
    loop {
        let target = f64::min(reached + increment, 1.0);
        let partial = TimeStep {
            offset: (target < 1.0).then(|| (initial.clone(), 1.0 - target)),
            ..*step
        };
        match newton::solve(&partial, d.clone(), tolerance, options, kept) {
            Ok(solution) if target >= 1.0 => return Ok(solution),
            Ok(solution) => {
                *cost += solution.stats;
                (d, reached) = (solution.d, target);
            }
            Err(_) if increment > 0.5f64.powi(MAX_CUTS as i32) => {
                *kept = None;
                increment *= 0.5;
            }
            Err(error) => return Err(error),
        }
    }
}

/// The equations of one time step.
struct TimeStep<'a> {
    structure: &'a Structure,
    load: &'a SurfaceLoad,
    dt: f64,
    offset: Option<(Vec<f64>, f64)>,
    /// Whence the tangent comes that was assembled last.
    assembled: &'a RefCell<Option<Linearization>>,
}

impl TimeStep<'_> {
    /// Velocity and acceleration at the end of the step.
    fn rates(&self, d: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let structure = self.structure;
        structure.time_scheme.rates(&structure.state, d, self.dt)
    }
}

impl Equilibrium for TimeStep<'_> {
    fn residual(&self, d: &[f64]) -> Result<Residual, SolidError> {
        let structure = self.structure;
        let body = &structure.body;
        let (v, a) = self.rates(d);
        let rates: Vec<f64> = a
            .iter()
            .zip(&v)
            .map(|(a, v)| a + structure.damping * v)
            .collect();
        let inertia = body.restrict(&body.pattern.multiply_scalar(&structure.mass, &rates));
        let internal = body.restrict(&body.internal_forces(d)?);
        let mut external = vec![0.0; d.len()];
        structure.wet.add_forces(
            &body.numbering,
            d,
            self.load,
            LoadKind::Follower,
            &mut external,
        );
        let external = body.restrict(&external);
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let scale = norm(&inertia).max(norm(&internal)).max(norm(&external));
        let mut vector: Vec<f64> = (0..inertia.len())
            .map(|i| inertia[i] + internal[i] - external[i])
            .collect();
        if let Some((initial, share)) = &self.offset {
            vector
                .iter_mut()
                .zip(initial)
                .for_each(|(r, r0)| *r -= share * r0);
        }
        Ok(Residual {
            vector,
            scale,
            floor: structure.floor,
        })
    }

    fn tangent(&self, d: &[f64], linearized_at: Option<&[f64]>) -> Result<Vec<f64>, SolidError> {
        let structure = self.structure;
        let body = &structure.body;
        let mut values = body.tangent(d, linearized_at, &[(&structure.wet, self.load)])?;
        let (velocity, acceleration) = structure.time_scheme.slopes(self.dt);
        let mass = acceleration + structure.damping * velocity;
        body.pattern.add_scalar(mass, &structure.mass, &mut values);
        body.pattern.hold(&mut values);
        *self.assembled.borrow_mut() = Some(Linearization {
            d: d.to_vec(),
            linearized_at: linearized_at.map(<[f64]>::to_vec),
            load: self.load.clone(),
            dt: self.dt,
        });
        Ok(values)
    }

    fn factorize(&self, tangent: &[f64]) -> Result<Factorization, SolidError> {
        self.structure.body.factorize(tangent)
    }

    fn moved(&self, d: &[f64], step: &[f64], scale: f64) -> Vec<f64> {
        self.structure.body.moved(d, step, scale)
    }
}

impl Solid for Structure {
    type Trial = Trial;
    type Location = Location;

    fn wet_points(&self) -> &[SurfacePoint] {
        &self.wet.points
    }

    fn locate(&self, points: &[Vec3]) -> Result<Vec<Location>, SolidError> {
        points
            .iter()
            .map(|x| self.locator.locate(&self.body, x))
            .collect()
    }

    fn solve(
        &mut self,
        load: &SurfaceLoad,
        dt: f64,
        tolerance: f64,
        start: Option<&Trial>,
    ) -> Result<Trial, SolidError> {
        self.check(load)?;
        let start = match start {
            Some(trial) => trial.state.d.clone(),
            // The acceleration would bring in the undamped noise of volumetric modes.
            None => {
                let State { d, v, .. } = &self.state;
                d.iter().zip(v).map(|(d, v)| d + dt * v).collect()
            }
        };
        let solution = self.robust_solve(load, dt, tolerance, start)?;
        self.total += solution.stats;
        let step = TimeStep {
            structure: self,
            load,
            dt,
            offset: None,
            assembled: &RefCell::new(None),
        };
        let (v, a) = step.rates(&solution.d);
        Ok(Trial {
            state: State {
                d: solution.d,
                v,
                a,
            },
            residuals: solution.residuals,
            stats: solution.stats,
        })
    }

    fn displacement(&self, trial: &Trial, at: &[Location]) -> Vec<Vec3> {
        at.iter()
            .map(|location| location.evaluate(&trial.state.d))
            .collect()
    }

    fn deformed_areas(&self, trial: &Trial) -> Vec<Vec3> {
        self.wet
            .deformed_areas(&self.body.numbering, &trial.state.d)
    }

    fn accept(&mut self, trial: Trial) {
        self.state = trial.state;
    }
}
