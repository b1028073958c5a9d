//! The static equilibrium in which a structure can be when time begins.

use super::super::SolidError;
use super::super::element::surface::{LoadKind, Surface};
use super::super::solid::SurfaceLoad;
use super::statics::{self, Load, StaticOptions};
use super::structure::{State, Structure};
use super::unloaded;

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
        let found = self.inflate(pressure, moved, &StaticOptions::default())?;
        if let Some(bifurcation) = found.bifurcation {
            return Err(SolidError::NoEquilibrium(format!(
                "it loses its stability and moves aside at {:.2} kPa of {:.2} kPa",
                1e-3 * bifurcation.factor * pressure,
                1e-3 * pressure
            )));
        }
        Ok(found.displacement)
    }

    /// The same as far as it is stable.
    ///
    /// # Errors
    /// If none is found.
    pub fn inflate(
        &self,
        pressure: f64,
        moved: Option<&[f64]>,
        options: &StaticOptions,
    ) -> Result<statics::Equilibrated, SolidError> {
        let body = self.body();
        let loads: Vec<Load> = (self.pressures(pressure).into_iter())
            .map(|(surface, values)| Load::Surface {
                surface,
                values,
                kind: LoadKind::Follower,
            })
            .collect();
        let unloaded = match moved {
            None => vec![0.0; body.coefficients()],
            Some(guess) => {
                let stretched = statics::stretch(body, guess, options)?;
                if loads.is_empty() {
                    return Ok(stretched);
                }
                stretched.displacement
            }
        };
        statics::solve_onto(body, unloaded, &loads, options)
    }

    /// The pressure (Pa) on the wet surface and the one outside, if they are not zero.
    fn pressures(&self, pressure: f64) -> Vec<(&Surface, SurfaceLoad)> {
        let inner = self.wet_surface();
        let uniform = SurfaceLoad::uniform_pressure(pressure, inner.points.len());
        let acting = (pressure != 0.0).then_some((inner, uniform));
        let outer = self.outer();
        let outer = outer.map(|(surface, values)| (surface, values.clone()));
        acting.into_iter().chain(outer).collect()
    }

    /// The unloaded shape from which a pressure (Pa) on the wet surface and the one outside lead to the shape of this
    /// structure; held coefficients move by their values in `moved` on the way, whose others are a guess.
    ///
    /// # Errors
    /// If none is found; the text says how far it went.
    pub fn unloaded_shape(
        &self,
        pressure: f64,
        moved: Option<&[f64]>,
    ) -> Result<unloaded::Found, SolidError> {
        let body = self.body();
        let given = vec![0.0; body.coefficients()];
        let mut forces = given.clone();
        for (surface, load) in self.pressures(pressure) {
            surface.add_forces(
                &body.numbering,
                &given,
                &load,
                LoadKind::Follower,
                &mut forces,
            );
        }
        unloaded::find(body, &forces, moved)
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
