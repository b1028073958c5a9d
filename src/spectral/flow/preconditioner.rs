//! What the preconditioner is made for, and when it is made again: that depends on the state at the beginning of a step
//! alone, so that a resumed run repeats the uninterrupted one.

use super::{FlowSettings, FlowState};
use crate::FlowError;
use crate::metric::Metric;
use crate::pressure::SchurComplement;
use crate::rheology::ViscosityField;
use crate::shear_thinning::VariableViscosity;
use crate::spectral_elements::SpectralElements;
use serde::{Deserialize, Serialize};

/// The preconditioner is renewed once the mesh has moved by this share of the flow's width. S-0.25 from 0.3 s on: 3.4
/// iterations per trial with 0.05, 3.7 with 0.1, 4.0 with 0.2, and twice as many preconditioners with half of it.
const FAR: f64 = 0.1;
/// Or once the time steps differ by this factor.
const OTHER_STEP: f64 = 5.0;
/// Or once the diagonal of the momentum operator differs by this factor anywhere, as the viscosity has changed.
const OTHER_DIAGONAL: f64 = 2.0;

/// A moment of a flow for which a preconditioner is made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MadeFor {
    /// Positions of the nodes, m.
    pub positions: Vec<f64>,
    /// `∫ mu |∇v_i|²` for each node, Pa s m.
    pub viscous_diagonal: Vec<f64>,
    /// Weight of the new velocity in its rate, 1/s.
    pub weight: f64,
}

/// A preconditioner.
pub struct Preconditioner {
    /// What it was made for.
    pub made_for: MadeFor,
    /// Schur complement of the pressure.
    pub schur: SchurComplement,
}

impl Preconditioner {
    /// For blood of a `density` (kg/m³) whose velocity is prescribed at the `fixed` nodes.
    ///
    /// # Errors
    /// If the mesh is inside out, or the pressure is not fixed by any outlet.
    pub fn new(
        space: &SpectralElements,
        density: f64,
        fixed: &[bool],
        made_for: MadeFor,
    ) -> Result<Self, FlowError> {
        let metric = Metric::new(space, &made_for.positions)?;
        let mass = made_for.mass(&metric, density);
        let inverse = made_for.inverse_diagonal(fixed, &mass);
        Ok(Self {
            schur: SchurComplement::new(space, &metric, &inverse)?,
            made_for,
        })
    }
}

impl MadeFor {
    /// That of the state if it is still near, or the state itself.
    ///
    /// # Errors
    /// If the mesh is inside out.
    pub fn choose(
        space: &SpectralElements,
        settings: &FlowSettings,
        width: f64,
        state: &FlowState,
        weight: f64,
    ) -> Result<Self, FlowError> {
        let positions = &state.positions[0];
        let earlier = state.preconditioner.as_ref().filter(|earlier| {
            let distances = (earlier.positions.iter().zip(positions)).map(|(a, b)| (a - b).abs());
            let ratio = weight / earlier.weight;
            distances.fold(0.0, f64::max) <= FAR * width
                && (1.0 / OTHER_STEP..=OTHER_STEP).contains(&ratio)
        });
        let constant = settings.rheology.constant();
        if let (Some(earlier), Some(_)) = (earlier, constant) {
            return Ok(earlier.clone());
        }
        let metric = Metric::new(space, positions)?;
        let viscosity = match constant {
            Some(viscosity) => ViscosityField::Constant(viscosity),
            None => {
                let [velocity, _] = &state.velocity;
                let now = VariableViscosity::new(space, &metric, &settings.rheology, velocity);
                ViscosityField::AtGauss(now.at_gauss)
            }
        };
        let now = Self {
            viscous_diagonal: metric.viscous_diagonal(space, &viscosity),
            positions: positions.clone(),
            weight,
        };
        let mass = now.mass(&metric, settings.density);
        let is_near = |earlier: &&Self| {
            let diagonals = now.viscous_diagonal.iter().zip(&earlier.viscous_diagonal);
            diagonals.zip(&mass).all(|((now, earlier), mass)| {
                let ratio = (mass + now) / (mass + earlier);
                (1.0 / OTHER_DIAGONAL..=OTHER_DIAGONAL).contains(&ratio)
            })
        };
        Ok(earlier.filter(is_near).cloned().unwrap_or(now))
    }

    /// Inertia of the nodes within a step, kg/s.
    fn mass(&self, metric: &Metric, density: f64) -> Vec<f64> {
        let mass = metric.mass.iter();
        mass.map(|m| density * self.weight * m).collect()
    }

    /// Inverse of the diagonal of the momentum operator with this inertia (kg/s), zero at the `fixed` nodes.
    pub fn inverse_diagonal(&self, fixed: &[bool], mass: &[f64]) -> Vec<f64> {
        (fixed.iter().zip(mass).zip(&self.viscous_diagonal))
            .map(|((&fixed, mass), viscous)| if fixed { 0.0 } else { 1.0 / (mass + viscous) })
            .collect()
    }
}
