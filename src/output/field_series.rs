//! Displacement and stress in the wall over time, for ParaView.

use super::stress_fields::{StressFields, stress_fields};
use super::vtu::{Cells, Values, VtuGrid, VtuSeries};
use crate::pfem::evaluation::samples::{Sampler, Samples};
use crate::pfem::{SolidError, Structure};
use crate::simulation::observer::AcceptedStep;
use std::io;
use std::path::PathBuf;

/// Writes the wall's fields in intervals.
pub struct FieldSeries {
    series: VtuSeries,
    sampler: Sampler,
    /// s
    interval: f64,
}

impl FieldSeries {
    /// Of `solid`, every `interval` (s), added to `series`.
    pub fn new(series: VtuSeries, interval: f64, solid: &Structure) -> Result<Self, SolidError> {
        // As many pieces per element and direction as the degree, so that its curves can be seen.
        let degree = solid.body().space.max_degree();
        let sampler = Sampler::new(solid.body(), degree + 1)?;
        Ok(Self {
            series,
            sampler,
            interval,
        })
    }

    /// Adds the end of a step if it is due.
    pub fn add(&mut self, accepted: &AcceptedStep, solid: &Structure) -> io::Result<()> {
        if !accepted.is_due(self.interval) {
            return Ok(());
        }
        self.write(accepted.time(), solid)
    }

    /// Adds the initial state, if the wall is loaded then: its points are unloaded, and their displacement
    /// leads to the loaded shape.
    pub fn begin(&mut self, solid: &Structure) -> io::Result<()> {
        if solid.state().d.iter().all(|&d| d == 0.0) {
            return Ok(());
        }
        self.write(0.0, solid)
    }

    fn write(&mut self, time: f64, solid: &Structure) -> io::Result<()> {
        let (body, d) = (solid.body(), &solid.state().d);
        let samples = self.sampler.sample(body, d).map_err(io::Error::other)?;
        let stresses = stress_fields(&samples);
        let grid = grid(&self.sampler, &samples, &stresses);
        self.series.add(time, &grid)
    }

    /// Times (s) and files of what was written.
    pub fn entries(&self) -> &[(f64, String)] {
        self.series.entries()
    }

    /// Goes back to these `entries` of the series in the file `path`.
    pub fn rewind(&mut self, path: PathBuf, entries: Vec<(f64, String)>) -> io::Result<()> {
        self.series = VtuSeries::resume(path, entries)?;
        Ok(())
    }
}

fn grid<'a>(sampler: &'a Sampler, samples: &'a Samples, stresses: &'a StressFields) -> VtuGrid<'a> {
    VtuGrid {
        points: &sampler.points,
        cells: Cells::Hexes(&sampler.hexes),
        point_data: stresses.point_data(samples),
        cell_data: vec![
            ("material", Values::Integers(&sampler.regions)),
            ("element", Values::Integers(&sampler.element_of_hex)),
        ],
    }
}
