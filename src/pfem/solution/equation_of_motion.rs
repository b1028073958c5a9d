//! The semidiscrete equation of motion of a body, and its residual and tangent in one time step.

use super::super::SolidError;
use super::super::discretization::Discretization;
use super::super::element::Motion;
use super::super::element::predicted_pressure::Volumes;
use super::super::element::surface::{LoadKind, Surface};
use super::super::linear_algebra::sparse::ScalarMatrix;
use super::super::solid::SurfaceLoad;
use super::newton::{Equilibrium, Residual};
use super::quasi_newton::KeptTangent;
use super::time_scheme::{State, TimeScheme};
use crate::Vec3;
use fsi_numerics::half_cosine;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What a tangent was assembled from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Linearization {
    /// Displacement coefficients, m.
    pub d: Vec<f64>,
    /// Those that a full step of Newton's method led from to `d`.
    pub linearized_at: Option<Vec<f64>>,
    /// Velocity coefficients, m/s, if viscous stresses depend on them.
    pub v: Option<Vec<f64>>,
    /// The load.
    pub load: SurfaceLoad,
    /// Length of the time step, s.
    pub dt: f64,
}

/// A body's weight, which grows by half a cosine at the beginning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gravity {
    /// Acceleration, m/s².
    pub acceleration: Vec3,
    /// How long it grows from t = 0 on, s; at 0 all of it acts at once.
    pub ramp: f64,
}

impl Gravity {
    /// Forces (N) on a body of this density (kg/m³).
    pub(super) fn weight(self, body: &Discretization, density: f64) -> Weight {
        Weight {
            forces: body.body_forces(density * self.acceleration),
            gravity: self,
        }
    }
}

/// The forces of a body's weight.
pub struct Weight {
    /// All of them, at all coefficients, N.
    forces: Vec<f64>,
    /// What they are made from.
    pub gravity: Gravity,
}

impl Weight {
    /// Forces at the time `t` (s), N.
    fn at(&self, t: f64) -> Vec<f64> {
        let share = half_cosine(t, self.gravity.ramp);
        self.forces.iter().map(|force| share * force).collect()
    }
}

/// What of `M (a + α v) + C v + f_int(d) = f_ext(d)` stays the same from step to step.
pub struct EquationOfMotion {
    /// The discretized body.
    pub body: Discretization,
    /// The loaded surface.
    pub wet: Surface,
    /// A pressure that acts all the time, on another surface.
    pub outer: Option<(Surface, SurfaceLoad)>,
    /// The body's weight.
    pub weight: Option<Weight>,
    /// Density times the mass integrals, one scalar per pair of functions.
    pub mass: Vec<f64>,
    /// The same for products.
    pub mass_matrix: ScalarMatrix,
    /// Density of the reference configuration, kg/m³.
    pub density: f64,
    /// Mass-proportional damping `α`, 1/s.
    pub damping: f64,
    /// How velocity and acceleration follow from the displacement.
    pub time_scheme: TimeScheme,
    /// The area on which pressures and shear act.
    pub load: LoadKind,
    /// Norm of the residual below which it is round-off, N.
    pub floor: f64,
}

impl EquationOfMotion {
    /// Assembles the tangent, with single components held.
    fn tangent(&self, at: &Linearization) -> Result<Vec<f64>, SolidError> {
        let body = &self.body;
        let (velocity, acceleration) = self.time_scheme.slopes(at.dt);
        let still = vec![0.0; if at.v.is_some() { 0 } else { at.d.len() }];
        let motion = Motion {
            velocity: at.v.as_deref().unwrap_or(&still),
            slope: velocity,
        };
        let mut values = self.tangent_without_inertia(at, Some(&motion))?;
        let mass = acceleration + self.damping * velocity;
        body.pattern.add_scalar(mass, &self.mass, &mut values);
        body.pattern.hold(&mut values);
        Ok(values)
    }

    /// The part of internal forces and following loads, and of what resists a motion.
    fn tangent_without_inertia(
        &self,
        at: &Linearization,
        motion: Option<&Motion>,
    ) -> Result<Vec<f64>, SolidError> {
        let mut following = Vec::new();
        if self.load == LoadKind::Follower {
            following.push((&self.wet, &at.load));
            following.extend(self.outer.as_ref().map(|(surface, load)| (surface, load)));
        }
        (self.body).moving_tangent(&at.d, at.linearized_at.as_deref(), &following, motion)
    }

    /// Whether an equilibrium with this displacement and load would be stable without inertia.
    pub fn is_statically_stable(&self, at: &Linearization) -> Result<bool, SolidError> {
        let mut values = self.tangent_without_inertia(at, None)?;
        self.body.pattern.hold(&mut values);
        Ok(self.body.is_positive_definite(&values))
    }

    /// Factorizes a tangent that was assembled at `d`.
    fn factorize(
        &self,
        d: &[f64],
        tangent: &[f64],
        cancelled: &AtomicBool,
    ) -> Result<KeptTangent, SolidError> {
        let factorization = self.body.factorize_moving(cancelled, tangent)?;
        Ok(KeptTangent::new(
            factorization,
            self.body.volume_gradients(d)?,
        ))
    }

    /// Acceleration of all coefficients (m/s²) by the weight alone, when the body is let go: `M a = f`. Newmark's
    /// method begins with it, and without it would never forget half a step of that velocity.
    pub fn acceleration_by_weight(&self) -> Result<Vec<f64>, SolidError> {
        let body = &self.body;
        let still = vec![0.0; body.coefficients()];
        let Some(weight) = &self.weight else {
            return Ok(still);
        };
        let mut values = vec![0.0; body.pattern.entries()];
        body.pattern.add_scalar(1.0, &self.mass, &mut values);
        body.pattern.hold(&mut values);
        let mut acceleration = body.restrict(&weight.at(0.0));
        body.factorize(&values)?.solve(&mut acceleration)?;
        Ok(body.moved(&still, &acceleration, 1.0))
    }

    /// Weight at the time `t` (s), pressures on surfaces and viscous resistance, N.
    fn external_forces(&self, t: f64, load: &SurfaceLoad, d: &[f64], v: &[f64]) -> Vec<f64> {
        let mut external = match &self.weight {
            Some(weight) => weight.at(t),
            None => vec![0.0; d.len()],
        };
        let outer = self.outer.as_ref().map(|(surface, load)| (surface, load));
        for (surface, load) in std::iter::once((&self.wet, load)).chain(outer) {
            surface.add_forces(&self.body.numbering, d, load, self.load, &mut external);
        }
        if let Some(resistance) = self.body.viscous_forces(d, v) {
            let pairs = external.iter_mut().zip(resistance);
            pairs.for_each(|(force, resistance)| *force -= resistance);
        }
        external
    }

    /// Assembles the tangent and factorizes it, unless it is `cancelled`.
    pub fn factorized_tangent(
        &self,
        at: &Linearization,
        cancelled: &AtomicBool,
    ) -> Result<KeptTangent, SolidError> {
        self.factorize(&at.d, &self.tangent(at)?, cancelled)
    }
}

/// What the body answered to a displacement: a coupling iteration starts where the last one ended, with another load
/// only.
#[derive(Debug, Clone)]
pub struct InternalForces {
    displacement: Vec<f64>,
    forces: Vec<f64>,
    volumes: Option<Arc<Volumes>>,
}

/// The equations of one time step.
#[derive(Clone, Copy)]
pub struct TimeStep<'a> {
    /// The equation of motion.
    pub equation: &'a EquationOfMotion,
    /// State at the beginning of the step.
    pub old: &'a State,
    /// Time at its end, s.
    pub end: f64,
    /// Load at its end.
    pub load: &'a SurfaceLoad,
    /// Its length, s.
    pub dt: f64,
    /// A residual that is taken away, and the share of it.
    pub offset: Option<(&'a [f64], f64)>,
    /// Whence the tangent comes that was assembled last.
    pub assembled: &'a RefCell<Option<Linearization>>,
    /// Called before a tangent is assembled: one that is on its way, from an older state, is not needed any more.
    pub before_assembly: &'a dyn Fn(),
    /// The internal forces that were computed last.
    pub forces: &'a RefCell<Option<InternalForces>>,
}

impl TimeStep<'_> {
    /// Velocity and acceleration at the end of the step.
    pub fn rates(&self, d: &[f64]) -> (Vec<f64>, Vec<f64>) {
        self.equation.time_scheme.rates(self.old, d, self.dt)
    }

    /// Those that were computed last, if they belong to `d`.
    fn known_forces(&self, d: &[f64]) -> Option<(Vec<f64>, Option<Arc<Volumes>>)> {
        let last = self.forces.borrow();
        let last = last.as_ref().filter(|last| last.displacement == d);
        last.map(|last| (last.forces.clone(), last.volumes.clone()))
    }
}

impl Equilibrium for TimeStep<'_> {
    fn residual(
        &self,
        d: &[f64],
        kept: Option<&KeptTangent>,
        before: Option<&Residual>,
    ) -> Result<Residual, SolidError> {
        let &Self {
            equation,
            end,
            load,
            ..
        } = self;
        let EquationOfMotion {
            body,
            mass_matrix,
            damping,
            floor,
            ..
        } = equation;
        let (v, a) = self.rates(d);
        let a = equation.time_scheme.balanced(self.old, a);
        let rates: Vec<f64> = a.iter().zip(&v).map(|(a, v)| a + damping * v).collect();
        let known = self.known_forces(d);
        let is_new = known.is_none();
        let (internal, (inertia, external)) = rayon::join(
            || {
                let before = before.and_then(|before| before.volumes.as_deref());
                let origin = kept.and_then(|kept| kept.origin(before));
                known.map_or_else(
                    || {
                        let (forces, volumes) = body.forces_from(d, origin)?;
                        Ok((forces, volumes.map(Arc::new)))
                    },
                    Ok,
                )
            },
            || {
                let inertia = mass_matrix.multiply(&rates);
                let external = equation.external_forces(end, load, d, &v);
                (body.restrict(&inertia), body.restrict(&external))
            },
        );
        let (internal, volumes) = internal?;
        if is_new {
            *self.forces.borrow_mut() = Some(InternalForces {
                displacement: d.to_vec(),
                forces: internal.clone(),
                volumes: volumes.clone(),
            });
        }
        let internal = body.restrict(&internal);
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let scale = norm(&inertia).max(norm(&internal)).max(norm(&external));
        let mut vector: Vec<f64> = (0..inertia.len())
            .map(|i| inertia[i] + internal[i] - external[i])
            .collect();
        if let Some((initial, share)) = self.offset {
            vector
                .iter_mut()
                .zip(initial)
                .for_each(|(r, r0)| *r -= share * r0);
        }
        Ok(Residual {
            vector,
            scale,
            floor: *floor,
            volumes,
        })
    }

    fn tangent(&self, d: &[f64], linearized_at: Option<&[f64]>) -> Result<Vec<f64>, SolidError> {
        let at = Linearization {
            d: d.to_vec(),
            linearized_at: linearized_at.map(<[f64]>::to_vec),
            v: (self.equation.body.is_viscous()).then(|| self.rates(d).0),
            load: self.load.clone(),
            dt: self.dt,
        };
        // Its memory and its threads are of more use here.
        (self.before_assembly)();
        let values = self.equation.tangent(&at)?;
        *self.assembled.borrow_mut() = Some(at);
        Ok(values)
    }

    fn factorize(&self, d: &[f64], tangent: &[f64]) -> Result<KeptTangent, SolidError> {
        // Those known belong to the volume gradients of another tangent.
        *self.forces.borrow_mut() = None;
        self.equation.factorize(d, tangent, &AtomicBool::new(false))
    }

    fn moved(&self, d: &[f64], step: &[f64], scale: f64) -> Vec<f64> {
        self.equation.body.moved(d, step, scale)
    }
}
