//! The static equilibrium in which a structure can be when time begins.

use super::super::SolidError;
use super::super::element::surface::LoadKind;
use super::super::solid::SurfaceLoad;
use super::statics::{self, Load, StaticOptions};
use super::structure::{State, Structure};

impl Structure {
    /// Displacement coefficients in static equilibrium under a pressure (Pa) on the wet surface and the one outside, after
    /// held coefficients were moved to the values in `moved`, which are those of a guess of the whole displacement.
    ///
    /// # Errors
    /// If there is no stable one; the text says how far it went.
    pub fn equilibrium(
        &self,
        pressure: f64,
        moved: Option<&[f64]>,
    ) -> Result<Vec<f64>, SolidError> {
        let (body, options) = (self.body(), StaticOptions::default());
        let unloaded = match moved {
            None => vec![0.0; body.coefficients()],
            Some(guess) => statics::stretch(body, guess, &options)?.displacement,
        };
        let inner = self.wet_surface();
        let uniform = SurfaceLoad::uniform_pressure(pressure, inner.points.len());
        let acting = (pressure != 0.0).then_some((inner, &uniform));
        let loads: Vec<Load> = (acting.into_iter())
            .chain(self.outer())
            .map(|(surface, values)| Load::Surface {
                surface,
                values: values.clone(),
                kind: LoadKind::Follower,
            })
            .collect();
        if loads.is_empty() {
            return Ok(unloaded);
        }
        let found = statics::solve_onto(body, unloaded, &loads, &options)?;
        if let Some(bifurcation) = found.bifurcation {
            return Err(SolidError::NoEquilibrium(format!(
                "it loses its stability and moves aside at {:.2} kPa of {:.2} kPa",
                1e-3 * bifurcation.factor * pressure,
                1e-3 * pressure
            )));
        }
        Ok(found.displacement)
    }

    /// Makes the structure at rest with this displacement its state.
    ///
    /// # Errors
    /// If the displacement belongs to another structure.
    pub fn set_at_rest(&mut self, displacement: Vec<f64>) -> Result<(), SolidError> {
        let still = vec![0.0; displacement.len()];
        self.set_state(State {
            d: displacement,
            v: still.clone(),
            a: still,
        })
    }
}
