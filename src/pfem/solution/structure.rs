//! The dynamic structure: Newmark's method or implicit Euler in time, Newton's in every step.
//!
//! Unknowns are the displacement coefficients `d` at the end of a step of length `dt`. With Newmark's parameters
//! `β = 1/4`, `γ = 1/2` (the trapezoidal rule: second order, no numerical damping)
//! ```text
//! a = (d - d_n)/(β dt²) - v_n/(β dt) - (1/(2β) - 1) a_n,      v = v_n + dt ((1 - γ) a_n + γ a),
//! r(d) = M (a + α v) + C v + f_int(d) - f_ext(d) = 0,
//! K    = ∂(f_int - f_ext)/∂d + γ/(β dt) C + (1/(β dt²) + α γ/(β dt)) M
//! ```
//! where `f_ext` holds the loads and the weight, `C` are the dampers around the body and `α` is the mass-proportional
//! damping (section 2.1). Other parameters damp high frequencies, see [`TimeScheme`]; with implicit Euler (first order,
//! damps much) `v = (d - d_n)/dt` and `a = (v - v_n)/dt`.

mod equilibrium;

use super::super::discretization::{self, Discretization};
use super::super::element::surface::{LoadKind, Surface};
use super::super::evaluation::locate::{Location, Locator};
use super::super::evaluation::samples;
use super::super::solid::{Solid, SolidError, StressPeak, SurfaceLoad, SurfacePoint};
use super::super::supports::{self, PressureAround, Profile, Support};
use super::equation_of_motion::{EquationOfMotion, InternalForces, TimeStep};
pub use super::equation_of_motion::{Gravity, Linearization};
use super::modes::{self, NaturalMode};
use super::newton::{self, Equilibrium, NewtonOptions};
use super::quasi_newton::{KeptTangent, QuasiNewtonPairs};
use super::renewal::{self, AGED, Kept, Renewal, WORN};
use super::stability_watch::StabilityWatch;
use super::stats::Stats;
pub use super::time_scheme::State;
use super::time_scheme::TimeScheme;
use crate::Vec3;
use crate::material::Law;
use crate::mesh::HexMesh;
use equilibrium::TissueAtRest;
use fsi_numerics::twelve_digits;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Most halvings of the load when a step finds no equilibrium at once.
const MAX_CUTS: u32 = 6;

/// Choices of a dynamic structure.
#[derive(Debug, Clone)]
pub struct StructureOptions {
    /// Space, mapping and quadrature.
    pub discretization: discretization::Options,
    /// Density of the reference configuration, kg/m³.
    pub density: f64,
    /// Mass-proportional damping `α`, 1/s.
    pub damping: f64,
    /// Time integration.
    pub time_scheme: TimeScheme,
    /// The area on which pressures and shear act.
    pub load: LoadKind,
    /// Newton's method.
    pub newton: NewtonOptions,
    /// Surface that carries the load.
    pub wet_surface: String,
    /// Supports.
    pub supports: Vec<Support>,
    /// Pressure on the surface `outer` that is always there.
    pub outer_pressure: Option<PressureAround>,
    /// Weight; none if absent.
    pub gravity: Option<Gravity>,
}

/// All that a structure keeps from one time step to the next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StructureMemory {
    /// Its time, s.
    pub time: f64,
    /// The accepted state.
    pub state: State,
    /// Whence the kept tangent comes, and the experience with it. They decide how Newton's method goes on, and so the
    /// last digits.
    pub tangent: Option<(Linearization, QuasiNewtonPairs)>,
    /// Whence the tangent comes that will take its place, and after how many steps from then on.
    pub renewal: Option<(Linearization, usize)>,
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
    load: SurfaceLoad,
    dt: f64,
}

/// A structure in motion.
pub struct Structure {
    pub(super) equation: Arc<EquationOfMotion>,
    locator: Locator,
    newton: NewtonOptions,
    state: State,
    /// Tangent of an earlier solution.
    kept: Option<Kept>,
    /// Takes its place after a number of steps.
    renewal: Option<Renewal>,
    /// Steps for which a renewal has time.
    lead: usize,
    /// The internal forces that were computed last.
    forces: Option<InternalForces>,
    watch: StabilityWatch,
    total: Stats,
    given: Given,
    /// Where the tissue around it is at rest, if that is a loaded state.
    tissue: Option<TissueAtRest>,
    /// Time of the accepted state, s.
    time: f64,
    prescribed: Option<Prescribed>,
}

/// A motion in place of what follows from loads.
#[derive(Debug, Clone, PartialEq)]
pub struct PrescribedMotion {
    /// Displacement (m) of each vertex of the mesh where the factor is 1.
    pub displacement: Vec<Vec3>,
    /// The factor over time (s).
    pub factor: Profile,
}

/// The same as coefficients.
struct Prescribed {
    displacement: Vec<f64>,
    factor: Profile,
}

impl Prescribed {
    fn at(&self, time: f64) -> Vec<f64> {
        let factor = self.factor.at(time);
        self.displacement.iter().map(|d| factor * d).collect()
    }
}

/// The shape as it is given, from which displacements of the wet surface count.
struct Given {
    /// Quadrature points of the wet surface.
    wet_points: Vec<SurfacePoint>,
    /// Displacement coefficients that lead there from the reference configuration, m; none where it is that one.
    displacement: Option<Vec<f64>>,
}

impl Given {
    /// Displacement (m) from the given shape where the one from the reference configuration has the coefficients `d`.
    fn displacement(&self, d: &[f64], at: &[Location]) -> Vec<Vec3> {
        let values = at.iter().map(|location| match &self.displacement {
            None => location.evaluate(d),
            Some(given) => location.evaluate(d) - location.evaluate(given),
        });
        values.collect()
    }
}

impl Structure {
    /// A structure at rest in its reference configuration; `materials` by region of the mesh.
    pub fn new<M>(
        mesh: &HexMesh,
        materials: &[M],
        options: &StructureOptions,
    ) -> Result<Self, SolidError>
    where
        for<'a> Law: From<&'a M>,
    {
        let discretization = &options.discretization;
        let body = Discretization::new(mesh, materials, &options.supports, discretization)?;
        Self::of_body(mesh, body, options)
    }

    fn of_body(
        mesh: &HexMesh,
        body: Discretization,
        options: &StructureOptions,
    ) -> Result<Self, SolidError> {
        let discretization = &options.discretization;
        let faces = supports::surface(mesh, &options.wet_surface)?;
        let points = discretization
            .quadrature_points
            .into_iter()
            .max()
            .unwrap_or(1);
        let surface =
            |faces| Surface::new(&body.numbering, &body.space, &body.mapping, faces, points);
        let wet = surface(faces)?;
        let outer = options.outer_pressure.as_ref().map(|around| {
            let outer = surface(supports::surface(mesh, "outer")?)?;
            let places = outer.points.iter().map(|point| &point.position);
            let load = SurfaceLoad {
                pressure: places.map(|x| around.at(x)).collect(),
                shear: vec![Vec3::zeros(); outer.points.len()],
            };
            Ok::<_, SolidError>((outer, load))
        });
        let locator = Locator::new(&body, faces);
        let given = Given {
            wet_points: wet.points.clone(),
            displacement: None,
        };
        let mass = mass(&body, options.density);
        let equation = EquationOfMotion {
            floor: body.round_off()?,
            wet,
            outer: outer.transpose()?,
            weight: options
                .gravity
                .map(|gravity| gravity.weight(&body, options.density)),
            mass_matrix: body.pattern.scalar_matrix(&mass),
            mass,
            density: options.density,
            damping: options.damping,
            time_scheme: options.time_scheme,
            load: options.load,
            body,
        };
        Self::unmoved(equation, locator, options.newton, given)
    }

    /// The structure before `displacement` (m, all coefficients) led it to the shape that is given, unloaded and at
    /// rest there. Points of the wet surface are found, and their displacements counted, in the given shape all the
    /// same.
    ///
    /// # Errors
    /// If the displacement turns an element inside out.
    pub fn unloaded_by(self, displacement: Vec<f64>) -> Result<Self, SolidError> {
        let old = &self.equation;
        let body = old.body.unloaded_by(&displacement)?;
        let reshaped =
            |surface: &Surface| surface.reshaped(&body.numbering, &body.space, &body.mapping);
        let outer = old.outer.as_ref();
        let outer = outer.map(|(surface, load)| Ok((reshaped(surface)?, load.clone())));
        let mass = mass(&body, old.density);
        let equation = EquationOfMotion {
            floor: body.round_off()?,
            wet: reshaped(&old.wet)?,
            outer: outer.transpose()?,
            weight: (old.weight.as_ref()).map(|weight| weight.gravity.weight(&body, old.density)),
            mass_matrix: body.pattern.scalar_matrix(&mass),
            mass,
            density: old.density,
            damping: old.damping,
            time_scheme: old.time_scheme,
            load: old.load,
            body,
        };
        let given = Given {
            displacement: Some(displacement),
            ..self.given
        };
        Ok(Self {
            lead: self.lead,
            ..Self::unmoved(equation, self.locator, self.newton, given)?
        })
    }

    /// At rest, without displacement, just let go.
    fn unmoved(
        equation: EquationOfMotion,
        locator: Locator,
        newton: NewtonOptions,
        given: Given,
    ) -> Result<Self, SolidError> {
        let zero = vec![0.0; equation.body.coefficients()];
        Ok(Self {
            state: State {
                a: equation.acceleration_by_weight()?,
                d: zero.clone(),
                v: zero,
            },
            equation: Arc::new(equation),
            locator,
            newton,
            given,
            tissue: None,
            time: 0.0,
            prescribed: None,
            kept: None,
            renewal: None,
            lead: 1,
            forces: None,
            watch: StabilityWatch::default(),
            total: Stats::default(),
        })
    }

    /// The same structure next to a fluid that needs about so many `seconds` for a time step, on the machine for which
    /// the costs of the structure are known. Of a large wall next to a small fluid a tangent is given several steps to
    /// be made.
    #[must_use]
    pub fn with_background_seconds(self, seconds: f64) -> Self {
        let lead = renewal::lead(&self.equation.body, seconds);
        Self { lead, ..self }
    }

    /// The same structure, but moved as prescribed whatever loads it, from time 0 on; in a space of degree 1, whose
    /// functions are those of the vertices. It has no stresses.
    #[must_use]
    pub fn moving_as(self, motion: &PrescribedMotion) -> Self {
        let body = &self.equation.body;
        let mut displacement = vec![0.0; body.coefficients()];
        for (vertex, &function) in body.numbering.of_vertex.iter().enumerate() {
            let own = &mut displacement[3 * function..3 * function + 3];
            own.copy_from_slice(motion.displacement[vertex].as_slice());
        }
        let factor = motion.factor.clone();
        Self {
            prescribed: Some(Prescribed {
                displacement,
                factor,
            }),
            ..self
        }
    }

    /// A trial that ends at the displacement `d` (m).
    fn trial(
        &self,
        d: Vec<f64>,
        residuals: Vec<f64>,
        stats: Stats,
        load: &SurfaceLoad,
        dt: f64,
    ) -> Trial {
        let (v, a) = (self.equation.time_scheme).rates(&self.state, &d, dt);
        Trial {
            state: State { d, v, a },
            residuals,
            stats,
            load: load.clone(),
            dt,
        }
    }

    /// Whether the accepted state has another shape than the one that is given.
    pub fn is_displaced(&self) -> bool {
        match &self.given.displacement {
            None => self.state.d.iter().any(|&d| d != 0.0),
            Some(given) => self.state.d != *given,
        }
    }

    /// The discretized body.
    pub fn body(&self) -> &Discretization {
        &self.equation.body
    }

    /// The loaded surface.
    pub(super) fn wet_surface(&self) -> &Surface {
        &self.equation.wet
    }

    /// The pressure outside, with its surface.
    pub(super) fn outer(&self) -> Option<(&Surface, &SurfaceLoad)> {
        let outer = self.equation.outer.as_ref();
        outer.map(|(surface, load)| (surface, load))
    }

    /// The last accepted state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Replaces the accepted state, as when a run is resumed, and forgets the kept tangent.
    pub fn set_state(&mut self, state: State) -> Result<(), SolidError> {
        let expected = self.equation.body.coefficients();
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

    /// Forgets the kept tangent, so that the next solution depends on nothing but the state, the load and the start.
    /// A run that refreshes when it writes a checkpoint is repeated bit by bit by one that resumes there.
    pub fn refresh(&mut self) {
        (self.kept, self.renewal) = (None, None);
        self.forces = None;
    }

    /// Where the next step begins: the acceleration would bring in the undamped noise of volumetric modes.
    fn predicted(&self, dt: f64) -> Vec<f64> {
        let State { d, v, .. } = &self.state;
        d.iter().zip(v).map(|(d, v)| d + dt * v).collect()
    }

    /// Sees to a new tangent if that in use is worn. Where the wall moves so fast that those of accepted states would
    /// be too old when they are ready, it is that of the predicted displacement, for the next step; where it moves
    /// faster still, that one would be renewed within the step all the same.
    fn renew_if_worn(&mut self, load: SurfaceLoad, dt: f64) {
        let Some(kept) = &self.kept else {
            return;
        };
        let is_worn = self.renewal.is_none() && kept.tangent.solutions() >= WORN * self.lead;
        let predicted = self.predicted(dt);
        let change_from = |d: &[f64]| {
            let EquationOfMotion { body, wet, .. } = &*self.equation;
            wet.change(&body.numbering, d, &predicted)
        };
        let aged = AGED * self.lead as f64;
        let lasts = aged / (self.lead + 1) as f64..=2.0 * AGED;
        if kept.tangent.predicts_pressure() && lasts.contains(&change_from(&self.state.d)) {
            if change_from(&kept.from.d) > aged {
                self.renew(Some(predicted), load, dt);
            }
        } else if is_worn {
            self.renew(None, load, dt);
        }
    }

    /// Has a tangent factorized while the fluid works: that of the accepted state, for one of the steps to come, or
    /// that of the displacement `predicted` for the next one.
    fn renew(&mut self, predicted: Option<Vec<f64>>, load: SurfaceLoad, dt: f64) {
        let (steps, linearized_at) = match predicted {
            Some(_) => (0, Some(self.state.d.clone())),
            None => (self.lead, None),
        };
        let from = Linearization {
            d: predicted.unwrap_or_else(|| self.state.d.clone()),
            linearized_at,
            v: self.relevant_velocity(),
            load,
            dt,
        };
        self.total.assemblies += 1;
        self.total.factorizations += 1;
        self.renewal = Renewal::start(&self.equation, from, steps);
    }

    /// The velocity, if viscous stresses depend on it.
    fn relevant_velocity(&self) -> Option<Vec<f64>> {
        (self.equation.body.is_viscous()).then(|| self.state.v.clone())
    }

    /// Pressure of a load, mean over the reference area, Pa.
    fn mean_pressure(&self, load: &SurfaceLoad) -> f64 {
        let points = self.equation.wet.points.iter();
        let (force, area) = (points.zip(&load.pressure))
            .fold((0.0, 0.0), |(force, area), (point, p)| {
                (force + p * point.area, area + point.area)
            });
        force / area
    }

    /// Cost of all solutions so far.
    pub fn stats(&self) -> Stats {
        self.total
    }

    /// Strain energy (J) of a displacement with `points` Gauss points per direction.
    pub fn strain_energy(&self, d: &[f64], points: [usize; 3]) -> Result<f64, SolidError> {
        self.equation.body.energy(d, points)
    }

    /// Kinetic energy (J) of a velocity.
    pub fn kinetic_energy(&self, v: &[f64]) -> f64 {
        let momentum = self.equation.mass_matrix.multiply(v);
        0.5 * momentum.iter().zip(v).map(|(p, v)| p * v).sum::<f64>()
    }

    /// The `count` lowest natural modes of the undeformed structure.
    pub fn natural_modes(&self, count: usize) -> Result<Vec<NaturalMode>, SolidError> {
        modes::lowest(&self.equation.body, &self.equation.mass_matrix, count)
    }

    fn check(&self, load: &SurfaceLoad) -> Result<(), SolidError> {
        let points = self.equation.wet.points.len();
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
        let mut cost = Stats::default();
        let kept = self.kept.take().filter(|kept| kept.from.dt == dt);
        let (mut kept, from) = kept.map(|kept| (kept.tangent, kept.from)).unzip();
        let (assembled, forces) = (RefCell::new(from), RefCell::new(self.forces.take()));
        let renewal = RefCell::new(self.renewal.take());
        let cancel = || *renewal.borrow_mut() = None;
        let step = TimeStep {
            equation: &self.equation,
            old: &self.state,
            end: self.time + dt,
            load,
            dt,
            offset: None,
            assembled: &assembled,
            before_assembly: &cancel,
            forces: &forces,
        };
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
        self.forces = forces.into_inner();
        self.renewal = renewal.into_inner();
        let mut solution = result?;
        solution.stats += cost;
        Ok(solution)
    }
}

/// Density (kg/m³) times the mass integrals of a body, one scalar per pair of functions.
fn mass(body: &Discretization, density: f64) -> Vec<f64> {
    let mut mass = body.pattern.scalar_values(|e| body.elements.mass(e));
    mass.iter_mut().for_each(|m| *m *= density);
    mass
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
    let initial = step.residual(&start, None, None)?.vector;
    let (mut d, mut reached, mut increment) = (start, 0.0, 1.0);
    loop {
        let target = f64::min(reached + increment, 1.0);
        let partial = TimeStep {
            offset: (target < 1.0).then(|| (&initial[..], 1.0 - target)),
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

impl Solid for Structure {
    type Trial = Trial;
    type Location = Location;
    type Memory = StructureMemory;

    fn wet_points(&self) -> &[SurfacePoint] {
        &self.given.wet_points
    }

    fn wet_faces(&self) -> Vec<Vec<Vec3>> {
        self.locator.outlines()
    }

    fn locate(&self, points: &[Vec3]) -> Result<Vec<Location>, SolidError> {
        let (locator, body) = (&self.locator, &self.equation.body);
        let located: Vec<_> = (points.par_iter())
            .map(|x| locator.locate(body, x))
            .collect();
        located.into_iter().collect() // the first error, whichever thread was faster
    }

    fn solve(
        &mut self,
        load: &SurfaceLoad,
        dt: f64,
        tolerance: f64,
        start: Option<&Trial>,
    ) -> Result<Trial, SolidError> {
        self.check(load)?;
        if let Some(motion) = &self.prescribed {
            let d = motion.at(self.time + dt);
            return Ok(self.trial(d, vec![0.0], Stats::default(), load, dt));
        }
        let start = match start {
            Some(trial) => trial.state.d.clone(),
            None => self.predicted(dt),
        };
        if let Some(renewal) = self.renewal.take_if(|renewal| renewal.steps == 0) {
            self.kept = renewal.ready(&mut self.total).or(self.kept.take());
        }
        let solution = self.robust_solve(load, dt, tolerance, start)?;
        self.total += solution.stats;
        Ok(self.trial(solution.d, solution.residuals, solution.stats, load, dt))
    }

    fn foreseen(&self, dt: f64, at: &[Location]) -> Option<Vec<Vec3>> {
        let motion = self.prescribed.as_ref()?;
        Some(self.given.displacement(&motion.at(self.time + dt), at))
    }

    fn displacement(&self, trial: &Trial, at: &[Location]) -> Vec<Vec3> {
        self.given.displacement(&trial.state.d, at)
    }

    fn deformed_areas(&self, trial: &Trial) -> Vec<Vec3> {
        self.equation
            .wet
            .deformed_areas(&self.equation.body.numbering, &trial.state.d)
    }

    fn notice(&mut self) -> Option<String> {
        let pressure = 1e-3 * self.watch.tell()?;
        Some(format!(
            "under a mean pressure of {pressure:.2} kPa the wall stands by its inertia alone; in statics it would buckle. \
             Displacements from here on are those of a wall that bends sideways"
        ))
    }

    fn accept(&mut self, trial: Trial) {
        self.state = trial.state;
        self.time = twelve_digits(self.time + trial.dt);
        if self.prescribed.is_some() {
            return;
        }
        let (pressure, state) = (self.mean_pressure(&trial.load), &self.state);
        self.watch
            .accepted(&self.equation, pressure, || Linearization {
                d: state.d.clone(),
                linearized_at: None,
                v: None,
                load: trial.load.clone(),
                dt: trial.dt,
            });
        // They were predicted with a tangent that may be replaced.
        self.forces = None;
        if let Some(renewal) = &mut self.renewal {
            renewal.steps -= 1;
            if renewal.steps == 0
                && let Some(renewal) = self.renewal.take()
            {
                self.kept = renewal.ready(&mut self.total).or(self.kept.take());
            }
        }
        self.renew_if_worn(trial.load, trial.dt);
    }

    fn accepted_displacement(&self, at: &[Location]) -> Vec<Vec3> {
        self.given.displacement(&self.state.d, at)
    }

    fn stress_peaks(&self) -> Result<Vec<StressPeak>, SolidError> {
        match self.prescribed {
            Some(_) => Ok(Vec::new()),
            None => samples::stress_peaks(self.body(), &self.state.d),
        }
    }

    fn memory(&self) -> StructureMemory {
        StructureMemory {
            time: self.time,
            state: self.state.clone(),
            tangent: (self.kept.as_ref())
                .map(|kept| (kept.from.clone(), kept.tangent.experience.clone())),
            renewal: (self.renewal.as_ref()).map(|renewal| (renewal.from.clone(), renewal.steps)),
        }
    }

    fn recall(&mut self, memory: StructureMemory) -> Result<(), SolidError> {
        self.set_state(memory.state)?;
        self.time = memory.time;
        let renewal = memory.renewal.iter().map(|(from, _)| from);
        for from in (memory.tangent.iter().map(|(from, _)| from)).chain(renewal) {
            self.check(&from.load)?;
            let lengths = [Some(&from.d), from.linearized_at.as_ref(), from.v.as_ref()];
            if (lengths.iter().flatten()).any(|d| d.len() != self.state.d.len()) {
                return Err(SolidError::Model(
                    "the stored tangent belongs to another discretization".into(),
                ));
            }
        }
        // One that cannot be factorized is done without, as in the run that goes on.
        self.kept = memory.tangent.and_then(|(from, experience)| {
            let mut tangent = (self
                .equation
                .factorized_tangent(&from, &AtomicBool::new(false)))
            .ok()?;
            tangent.experience = experience;
            Some(Kept { from, tangent })
        });
        self.renewal =
            (memory.renewal).and_then(|(from, steps)| Renewal::start(&self.equation, from, steps));
        Ok(())
    }
}
