//! Flow at the inlet over time, and the smooth start.

use super::periodic_table::samples;
use super::{Inflow, PeriodicTable, Ramp, TableError};
use fsi_numerics::half_cosine;
use std::f64::consts::PI;

/// A periodic flow curve.
#[derive(Debug, Clone, PartialEq)]
pub enum FlowCurve {
    /// `base + amplitude sin²(π (t/systole)^exponent)` for t < systole within a period, then `base`.
    Pulse {
        /// The parameters.
        inflow: Inflow,
        /// Duration of a period, s.
        period: f64,
    },
    /// Values of a file, m³/s.
    Table(PeriodicTable),
}

impl FlowCurve {
    /// The curve of a case; reads its file if there is one.
    ///
    /// # Errors
    /// What is wrong with the file, with the line.
    pub fn new(inflow: &Inflow, period: f64) -> Result<Self, TableError> {
        let curve = match &inflow.file {
            None => Self::Pulse {
                inflow: inflow.clone(),
                period,
            },
            Some(path) => Self::Table(PeriodicTable::of_flow(
                path,
                inflow.unit,
                inflow.file_period,
                period,
            )?),
        };
        Ok(match inflow.mean.filter(|_| curve.has_mean()) {
            Some(mean) => curve.times(mean / curve.means()[0]),
            None => curve,
        })
    }

    /// Means (m³/s) of the flow and of its magnitude over a period.
    fn means(&self) -> [f64; 2] {
        let samples: Vec<[f64; 2]> = self.samples(self.period()).collect();
        let mean = |value: fn(f64) -> f64| {
            let parts = samples.windows(2).map(|ends| {
                0.5 * (value(ends[0][1]) + value(ends[1][1])) * (ends[1][0] - ends[0][0])
            });
            parts.sum::<f64>() / self.period()
        };
        [mean(|flow| flow), mean(f64::abs)]
    }

    /// What a mean that is asked for needs.
    pub(super) const NO_MEAN: &str = "the mean of the curve is zero, and no factor makes another mean of it: leave this key out, or \
                                      change the curve";

    /// Whether a factor can give it any mean.
    pub(super) fn has_mean(&self) -> bool {
        let [mean, magnitude] = self.means();
        mean.abs() > 1e-6 * magnitude
    }

    /// Flow (m³/s) at the time `t` (s), before the ramp.
    pub fn flow(&self, t: f64) -> f64 {
        match self {
            Self::Pulse { inflow, period } => {
                let t = t.rem_euclid(*period);
                if t >= inflow.systole {
                    return inflow.base;
                }
                inflow.base
                    + inflow.amplitude
                        * (PI * (t / inflow.systole).powf(inflow.exponent))
                            .sin()
                            .powi(2)
            }
            Self::Table(table) => table.value(t),
        }
    }

    /// No flow at all times, with a period (s).
    pub fn none(period: f64) -> Self {
        Self::Pulse {
            inflow: Inflow::pulse(0.0, 0.0, period, 1.0),
            period,
        }
    }

    /// The curve times a factor.
    pub fn times(&self, factor: f64) -> Self {
        match self {
            Self::Pulse { inflow, period } => Self::Pulse {
                inflow: Inflow {
                    base: factor * inflow.base,
                    amplitude: factor * inflow.amplitude,
                    ..inflow.clone()
                },
                period: *period,
            },
            Self::Table(table) => Self::Table(table.times(factor)),
        }
    }

    /// One period as pairs of time (s) and flow (m³/s) to interpolate linearly, from 0 to the period's end: ten
    /// thousand or more, among them every multiple of the time `step` (s), of its half, its quarter, …, if it divides
    /// the period.
    pub fn samples(&self, step: f64) -> impl Iterator<Item = [f64; 2]> {
        samples(self.period(), step, |t| self.flow(t))
    }

    /// Duration of a period, s.
    pub fn period(&self) -> f64 {
        match self {
            Self::Pulse { period, .. } => *period,
            Self::Table(table) => table.period(),
        }
    }

    /// The table of a file.
    pub fn table(&self) -> Option<&PeriodicTable> {
        match self {
            Self::Pulse { .. } => None,
            Self::Table(table) => Some(table),
        }
    }

    /// The times (s) between which a table has no value; see [`PeriodicTable::gap`].
    pub fn gap(&self, times: f64) -> Option<[f64; 2]> {
        match self {
            Self::Pulse { .. } => None,
            Self::Table(table) => table.gap(times),
        }
    }
}

impl Ramp {
    /// Factor on inflow and outlet pressure at the time `t` (s): see [`half_cosine`].
    pub fn factor(&self, t: f64) -> f64 {
        half_cosine(t, self.duration)
    }
}
