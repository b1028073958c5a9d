//! The static equilibrium in which a structure can be at t = 0.
//!
//! Where tissue is at rest in a loaded state, that state is an equilibrium which is known: a wall is led from there to
//! other pressures, not from its unloaded shape, which the tissue would pull open.

use super::{State, Structure};
use crate::Vec3;
use crate::element::surface::{LoadKind, Surface};
use crate::solid::{SolidError, SurfaceLoad};
use crate::solution::statics::{self, Load, StaticOptions};
use crate::solution::unloaded;
use std::sync::Arc;

/// The equilibrium in which the tissue around a wall exerts nothing.
pub(super) struct TissueAtRest {
    /// Pressure inside, Pa.
    pressure: f64,
    /// Displacement coefficients, m.
    displacement: Vec<f64>,
}

impl Structure {
    /// Displacement coefficients in static equilibrium under a pressure (Pa) on the wet surface and the one outside,
    /// after held coefficients were moved to the values in `moved`, which are those of a guess of the whole
    /// displacement.
    ///
    /// # Errors
    /// If there is no stable one; the text says how far it went.
    pub fn equilibrium(
        &self,
        pressure: f64,
        moved: Option<&[f64]>,
    ) -> Result<Vec<f64>, SolidError> {
        // The way does not matter. S-0.25 takes 12 iterations in two steps, 16 in four, and 9 in one, but in one step a
        // wall that loses its stability is more likely to end in another equilibrium.
        let options = StaticOptions {
            steps: 2,
            tolerance_on_the_way: 1e-2,
            ..StaticOptions::default()
        };
        let found = self.inflate(pressure, moved, &options)?;
        if let Some(bifurcation) = found.bifurcation {
            return Err(SolidError::NoEquilibrium(format!(
                "it loses its stability and bends sideways at {:.2} kPa of {:.2} kPa",
                1e-3 * self.pressure_at(bifurcation.factor, pressure),
                1e-3 * pressure
            )));
        }
        Ok(found.displacement)
    }

    /// The pressure (Pa) inside at a factor of the load on the way of [`inflate`](Self::inflate) to a pressure.
    pub fn pressure_at(&self, factor: f64, pressure: f64) -> f64 {
        match &self.tissue {
            None => factor * pressure,
            Some(rest) => rest.pressure + factor * (pressure - rest.pressure),
        }
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
        let rest = self.tissue.as_ref();
        let loads = self.loads(pressure, rest);
        if let Some(rest) = rest {
            return statics::solve_onto(body, rest.displacement.clone(), &loads, options);
        }
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

    /// The same by Newton's method from a `start` nearby, whose held coefficients are kept: stable or not.
    ///
    /// # Errors
    /// If none is found.
    pub fn equilibrium_from(&self, pressure: f64, start: Vec<f64>) -> Result<Vec<f64>, SolidError> {
        let loads = self.loads(pressure, None);
        let found = statics::solve_from(self.body(), &loads, start, &StaticOptions::default())?;
        Ok(found.displacement)
    }

    /// Area of the wet surface at a displacement, m².
    pub fn wet_area(&self, displacement: &[f64]) -> f64 {
        let areas = (self.wet_surface()).deformed_areas(&self.body().numbering, displacement);
        areas.iter().map(Vec3::norm).sum()
    }

    /// [`Self::pressures`] as loads.
    fn loads(&self, pressure: f64, rest: Option<&TissueAtRest>) -> Vec<Load<'_>> {
        let pressures = self.pressures(pressure, rest).into_iter();
        pressures
            .map(|(surface, values, before)| Load::Surface {
                surface,
                before,
                values,
                kind: self.equation.load,
            })
            .collect()
    }

    /// The pressure (Pa) on the wet surface and the one outside, if they are not zero, each with what of it is there
    /// where tissue is at `rest`.
    fn pressures(
        &self,
        pressure: f64,
        rest: Option<&TissueAtRest>,
    ) -> Vec<(&Surface, SurfaceLoad, Option<SurfaceLoad>)> {
        let inner = self.wet_surface();
        let uniform = |pressure| SurfaceLoad::uniform_pressure(pressure, inner.points.len());
        let acts = pressure != 0.0 || rest.is_some_and(|rest| rest.pressure != 0.0);
        let before = rest.map(|rest| uniform(rest.pressure));
        let acting = acts.then(|| (inner, uniform(pressure), before));
        let outer = self.outer();
        let outer =
            outer.map(|(surface, values)| (surface, values.clone(), rest.map(|_| values.clone())));
        acting.into_iter().chain(outer).collect()
    }

    /// Share of the pressure (Pa) on the wet surface that the tissue around the wall carries at a displacement: the
    /// forces with which its springs press the outer surface inwards, over those with which the pressure presses the
    /// inner one outwards.
    pub fn tissue_share(&self, pressure: f64, displacement: &[f64]) -> f64 {
        let inwards = self.body().inward_spring_force(displacement);
        inwards / (pressure * self.wet_area(displacement))
    }

    /// Tissue that is to be at rest in a loaded state is so in the equilibrium under this pressure (Pa) inside, with
    /// this displacement (m, all coefficients).
    ///
    /// # Errors
    /// If the structure works on a step.
    pub fn set_tissue_at_rest(
        &mut self,
        pressure: f64,
        displacement: Vec<f64>,
    ) -> Result<(), SolidError> {
        let equation = Arc::get_mut(&mut self.equation)
            .ok_or_else(|| SolidError::Model("the wall is in use".into()))?;
        equation.body.set_tissue_at_rest(&displacement);
        self.tissue = Some(TissueAtRest {
            pressure,
            displacement,
        });
        Ok(())
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
        for (surface, load, _) in self.pressures(pressure, None) {
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
