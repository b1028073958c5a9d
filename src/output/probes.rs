//! `probes.csv`: the motion of chosen points of the wet surface.

use super::tables::{ProbeRow, Table};
use crate::Vec3;
use crate::pfem::{Solid, SolidError};
use std::io;

/// Points of the wet surface of a structure, and the table of their motion.
pub struct Probes<S: Solid> {
    points: Vec<Vec3>,
    locations: Vec<S::Location>,
    table: Table,
}

impl<S: Solid> Probes<S> {
    /// Finds the points (reference positions, m) on the wet surface of `solid`.
    pub fn new(points: Vec<Vec3>, solid: &S, table: Table) -> Result<Self, SolidError> {
        Ok(Self {
            locations: solid.locate(&points)?,
            points,
            table,
        })
    }

    /// Displacement (m) of each point in a trial.
    pub fn displacement(&self, solid: &S, trial: &S::Trial) -> Vec<Vec3> {
        solid.displacement(trial, &self.locations)
    }

    /// Adds a row for each point.
    pub fn append(&mut self, time: f64, displacement: &[Vec3]) -> io::Result<()> {
        let pairs = self.points.iter().zip(displacement).enumerate();
        let rows: Vec<_> = pairs
            .map(|(probe, (x, u))| ProbeRow {
                time_s: time,
                probe,
                x_m: x.x,
                y_m: x.y,
                z_m: x.z,
                ux_m: u.x,
                uy_m: u.y,
                uz_m: u.z,
            })
            .collect();
        self.table.append(&rows)
    }
}
