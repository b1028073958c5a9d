//! What a finished run says about its acceleration.

use crate::Vec3;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// The figures of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Whether it came to its end.
    pub complete: bool,
    /// Accepted time steps.
    pub steps: usize,
    /// Coupling iterations of a step by the criterion that ended them: mean and largest number.
    pub by_criterion: [f64; 2],
    /// The same by the first fixed-point residual below the tolerance.
    pub by_residual: ByResidual,
    /// Seconds of a step in fluid, structure, and all together.
    pub seconds: [f64; 3],
    /// Attempts at a step that failed.
    pub failed: usize,
    /// ProbeMotion of the probes.
    pub motion: ProbeMotion,
}

/// Coupling iterations until the fixed-point residual, relative to the displacement, is below the tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ByResidual {
    /// Mean of a step.
    pub mean: f64,
    /// Largest number of a step.
    pub most: usize,
    /// Steps that were accepted before; they count as one iteration more, which is the least that they would have
    /// needed.
    pub open: usize,
}

/// Displacement (m) of all probes at the end of each step.
pub type ProbeMotion = Vec<Vec<Vec3>>;

#[derive(Deserialize)]
struct SummaryFile {
    status: String,
    steps: usize,
    mean_coupling_iterations: f64,
    max_coupling_iterations: usize,
    failed_attempts: usize,
    seconds_per_step: f64,
    seconds: ModelSeconds,
}

#[derive(Deserialize)]
struct ModelSeconds {
    fluid_s: f64,
    structure_s: f64,
}

#[derive(Deserialize)]
struct ModelIteration {
    time_s: f64,
    attempt: usize,
    iteration: usize,
    residual: f64,
}

#[derive(Deserialize)]
struct Probe {
    time_s: f64,
    ux_m: f64,
    uy_m: f64,
    uz_m: f64,
}

impl Measured {
    /// Reads the results in the folder `run`, whose coupling has the relative `tolerance`; none if it did not end.
    pub fn read(run: &Path, tolerance: f64) -> io::Result<Option<Self>> {
        let Ok(text) = std::fs::read(run.join("summary.json")) else {
            return Ok(None);
        };
        let summary: SummaryFile = serde_json::from_slice(&text)?;
        if summary.status == "interrupted" {
            return Ok(None);
        }
        let per_step = |seconds: f64| seconds / summary.steps.max(1) as f64;
        let rows: Vec<ModelIteration> = rows(&run.join("iterations.csv"))?;
        let probes: Vec<Probe> = rows_if_any(&run.join("probes.csv"))?;
        Ok(Some(Self {
            complete: summary.status == "complete",
            steps: summary.steps,
            by_criterion: [
                summary.mean_coupling_iterations,
                summary.max_coupling_iterations as f64,
            ],
            by_residual: by_residual(&rows, tolerance),
            seconds: [
                per_step(summary.seconds.fluid_s),
                per_step(summary.seconds.structure_s),
                summary.seconds_per_step,
            ],
            failed: summary.failed_attempts,
            motion: motion(&probes),
        }))
    }

    /// Largest difference of the probes' displacement to `other` at any step, relative to their largest displacement
    /// (both as root mean square over the probes).
    pub fn difference(&self, other: &Self) -> f64 {
        let square = |step: &[Vec3]| step.iter().map(Vec3::norm_squared).sum::<f64>();
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let size = largest(&mut other.motion.iter().map(|step| square(step)));
        let pairs = self.motion.iter().zip(&other.motion);
        let difference = largest(&mut pairs.map(|(a, b)| {
            let differences: Vec<Vec3> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            square(&differences)
        }));
        (difference / size).sqrt()
    }
}

fn rows<T: DeserializeOwned>(path: &Path) -> io::Result<Vec<T>> {
    let mut reader = csv::Reader::from_path(path)?;
    Ok(reader.deserialize().collect::<Result<_, _>>()?)
}

fn rows_if_any<T: DeserializeOwned>(path: &Path) -> io::Result<Vec<T>> {
    if path.exists() {
        rows(path)
    } else {
        Ok(Vec::new())
    }
}

fn by_residual(rows: &[ModelIteration], tolerance: f64) -> ByResidual {
    // By step, whose time is its name: the last attempt's iterations, and the first of them below the tolerance.
    let mut steps: BTreeMap<u64, (usize, Option<usize>)> = BTreeMap::new();
    for row in rows {
        let step = steps.entry(row.time_s.to_bits()).or_default();
        if row.iteration == 1 && row.attempt >= 1 {
            *step = (0, None);
        }
        step.0 = row.iteration;
        if row.residual < tolerance {
            step.1.get_or_insert(row.iteration);
        }
    }
    let counts: Vec<usize> = steps
        .values()
        .map(|(all, first)| first.unwrap_or(all + 1))
        .collect();
    ByResidual {
        mean: counts.iter().sum::<usize>() as f64 / counts.len().max(1) as f64,
        most: counts.iter().copied().max().unwrap_or(0),
        open: steps.values().filter(|(_, first)| first.is_none()).count(),
    }
}

fn motion(probes: &[Probe]) -> ProbeMotion {
    probes
        .chunk_by(|a, b| a.time_s == b.time_s)
        .map(|step| {
            step.iter()
                .map(|p| Vec3::new(p.ux_m, p.uy_m, p.uz_m))
                .collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Iterations are counted to the first small residual of the last attempt.
    #[test]
    fn iterations_are_counted_to_the_first_small_residual() {
        let row = |time_s, attempt, iteration, residual| ModelIteration {
            time_s,
            attempt,
            iteration,
            residual,
        };
        let rows = [
            row(0.1, 1, 1, 1e-7), // failed for another reason
            row(0.1, 2, 1, 1e-2),
            row(0.1, 2, 2, 1e-7),
            row(0.1, 2, 3, 1e-8),
            row(0.2, 1, 1, 1e-3),
            row(0.2, 1, 2, 2e-6),
        ];
        let found = by_residual(&rows, 1e-6);
        let expected = ByResidual {
            mean: 2.5,
            most: 3,
            open: 1,
        };
        assert_eq!(found, expected);
    }
}
