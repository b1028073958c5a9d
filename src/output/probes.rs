//! The motion of chosen points of the wet surface, for `probes.csv`.

use super::tables::ProbeRow;
use crate::Vec3;
use crate::pfem::{Solid, SolidError};

/// Points of the wet surface of a structure.
pub struct Probes<S: Solid> {
    points: Vec<Vec3>,
    locations: Vec<S::Location>,
}

impl<S: Solid> Probes<S> {
    /// Finds the points (reference positions, m) on the wet surface of `solid`.
    pub fn new(points: Vec<Vec3>, solid: &S) -> Result<Self, SolidError> {
        let locations = solid.locate(&points)?;
        Ok(Self { points, locations })
    }

    /// Displacement (m) of each point in a trial.
    pub fn displacement(&self, solid: &S, trial: &S::Trial) -> Vec<Vec3> {
        solid.displacement(trial, &self.locations)
    }

    /// A row for each point.
    pub fn rows(&self, time: f64, displacement: &[Vec3]) -> Vec<ProbeRow> {
        let pairs = self.points.iter().zip(displacement).enumerate();
        let row = |(probe, (x, u)): (usize, (&Vec3, &Vec3))| ProbeRow {
            time_s: time,
            probe,
            x_m: x.x,
            y_m: x.y,
            z_m: x.z,
            ux_m: u.x,
            uy_m: u.y,
            uz_m: u.z,
        };
        pairs.map(row).collect()
    }
}
