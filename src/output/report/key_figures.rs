//! The figures that a run ends in, for tables over many runs.

use super::page::significant;
use crate::analysis::{ARTERY, BYPASS, MID_ARTERY};
use crate::hemodynamics::periodicity::PeriodDifference;
use crate::hemodynamics::summary::{RegionSummary, VesselSummary};
use crate::output::record::RunSummary;
use crate::output::refinement::Limit;
use crate::output::results::Results;
use crate::tabular::units::MMHG;

/// What is shown where a run has no such figure.
const NONE: &str = "–";

/// How far two runs are apart in a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Distance {
    /// Relative to the first one, in per cent.
    Relative,
    /// In the figure's own unit: of what may be zero.
    Absolute,
    /// In the figure's own unit; a place, which jumps.
    Place,
}

/// A figure of a run.
#[derive(Debug, Clone, Copy)]
pub struct KeyFigure {
    /// What, with its unit.
    pub name: &'static str,
    /// Significant digits that are shown.
    digits: usize,
    value: fn(&Results) -> Option<f64>,
    distance: Distance,
}

impl KeyFigure {
    const fn new(name: &'static str, digits: usize, value: fn(&Results) -> Option<f64>) -> Self {
        Self {
            name,
            digits,
            value,
            distance: Distance::Relative,
        }
    }

    const fn absolute(self) -> Self {
        Self {
            distance: Distance::Absolute,
            ..self
        }
    }

    const fn place(self) -> Self {
        Self {
            distance: Distance::Place,
            ..self
        }
    }

    /// Whether it is a place, which jumps where others change a little.
    pub fn is_place(&self) -> bool {
        self.distance == Distance::Place
    }

    /// Of a run, if it has it.
    pub fn of(&self, run: &Results) -> Option<f64> {
        (self.value)(run).filter(|value| value.is_finite())
    }

    /// With its uncertainty, as people read it.
    pub fn show_limit(&self, limit: &Limit) -> String {
        let Limit { value, uncertainty } = *limit;
        if uncertainty <= 0.0 {
            return significant(value, self.digits);
        }
        let places = (1 - uncertainty.log10().floor() as i32).clamp(0, 9) as usize;
        let text = format!("{value:.places$} ± {uncertainty:.places$}");
        text.replace('-', "\u{2212}")
    }

    /// As people read it.
    pub fn show(&self, run: &Results) -> String {
        self.of(run)
            .map_or(NONE.into(), |value| significant(value, self.digits))
    }

    /// By how much `other` is larger: "+0.3 %", or in the figure's own unit.
    pub fn show_change(&self, run: &Results, other: &Results) -> String {
        let both = (self.value)(run).zip((self.value)(other));
        let change = both.map(|(a, b)| match self.distance {
            Distance::Relative => 100.0 * (b - a) / a.abs(),
            Distance::Absolute | Distance::Place => b - a,
        });
        let Some(change) = change.filter(|change| change.is_finite()) else {
            return NONE.into();
        };
        let sign = if change > 0.0 { "+" } else { "" };
        let unit = match self.distance {
            Distance::Relative => " %",
            Distance::Absolute | Distance::Place => "",
        };
        format!("{sign}{}{unit}", significant(change, 2))
    }
}

fn vessel(run: &Results, value: fn(&VesselSummary) -> f64) -> Option<f64> {
    run.hemodynamics.vessel.as_ref().map(value)
}

fn region(run: &Results, name: &str, value: fn(&RegionSummary) -> f64) -> Option<f64> {
    run.hemodynamics.region(name).map(value)
}

fn summary(run: &Results, value: fn(&RunSummary) -> f64) -> Option<f64> {
    run.summary.as_ref().map(value)
}

fn last(differences: &[PeriodDifference]) -> Option<f64> {
    differences.last().map(|d| 100.0 * d.relative)
}

const STEPS: KeyFigure = KeyFigure::new("steps", 1, |run| summary(run, |s| s.totals.steps as f64));
const ITERATIONS: KeyFigure = KeyFigure::new("coupling iterations per step", 3, |run| {
    summary(run, |s| s.mean_coupling_iterations)
});
const MOST_ITERATIONS: KeyFigure = KeyFigure::new("most in a step", 1, |run| {
    summary(run, |s| s.totals.max_coupling_iterations as f64)
});

/// What a run has cost, and how near to periodic it is.
pub const COURSE: [KeyFigure; 6] = [
    STEPS,
    ITERATIONS,
    MOST_ITERATIONS,
    KeyFigure::new("s per step", 3, |run| summary(run, |s| s.seconds_per_step)),
    KeyFigure::new("period to period, outflow / %", 2, |run| {
        last(&run.hemodynamics.periodicity.outflow)
    }),
    KeyFigure::new("period to period, displacement / %", 2, |run| {
        last(&run.hemodynamics.periodicity.max_displacement)
    }),
];

/// How large a run is, and how its coupling went.
pub const COUPLING: [KeyFigure; 6] = [
    KeyFigure::new("cells or elements of the fluid", 1, |run| {
        summary(run, |s| s.fluid_cells as f64)
    }),
    KeyFigure::new("unknowns of the wall", 1, |run| {
        summary(run, |s| s.structure_dofs as f64)
    }),
    STEPS,
    ITERATIONS,
    MOST_ITERATIONS,
    KeyFigure::new("attempts that failed", 1, |run| {
        summary(run, |s| s.totals.failed_attempts as f64)
    }),
];

/// What a run has found, over its window.
pub const RESULTS: [KeyFigure; 15] = [
    KeyFigure::new("outlet pressure, lowest / mmHg", 3, |run| {
        vessel(run, |v| v.p_out_Pa.min / MMHG)
    }),
    KeyFigure::new("outlet pressure, highest / mmHg", 4, |run| {
        vessel(run, |v| v.p_out_Pa.max / MMHG)
    }),
    KeyFigure::new("artery volume / ml", 4, |run| {
        region(run, ARTERY, |r| 1e6 * r.mean_volume())
    }),
    KeyFigure::new("artery mean WSS / Pa", 3, |run| {
        region(run, ARTERY, |r| r.mean_wall_shear_Pa.mean)
    }),
    KeyFigure::new("mid-artery mean TAWSS / Pa", 3, |run| {
        region(run, MID_ARTERY, |r| r.TAWSS_Pa.mean)
    }),
    KeyFigure::new("mid-artery largest WSS / Pa", 3, |run| {
        region(run, MID_ARTERY, |r| r.max_wall_shear_Pa.max)
    }),
    KeyFigure::new("largest WSS at x / mm", 3, |run| {
        region(run, MID_ARTERY, |r| 1e3 * r.max_wall_shear_Pa.at.x_m)
    })
    .place(),
    KeyFigure::new("bypass mean TAWSS / Pa", 3, |run| {
        region(run, BYPASS, |r| r.TAWSS_Pa.mean)
    }),
    KeyFigure::new("bypass largest OSI", 3, |run| {
        region(run, BYPASS, |r| r.OSI.max)
    })
    .absolute(),
    KeyFigure::new("artery largest OSI", 3, |run| {
        region(run, ARTERY, |r| r.OSI.max)
    })
    .absolute(),
    KeyFigure::new("mid-artery largest OSI", 2, |run| {
        region(run, MID_ARTERY, |r| r.OSI.max)
    })
    .absolute(),
    KeyFigure::new("largest OSI at x / mm", 3, |run| {
        region(run, MID_ARTERY, |r| 1e3 * r.OSI.max_at.x_m)
    })
    .place(),
    KeyFigure::new("mid-artery mean OSI", 2, |run| {
        region(run, MID_ARTERY, |r| r.OSI.mean)
    })
    .absolute(),
    KeyFigure::new("mid-artery largest von Mises / kPa", 4, |run| {
        region(run, MID_ARTERY, |r| 1e-3 * r.max_von_mises_Pa.max)
    }),
    KeyFigure::new("largest displacement / mm", 4, |run| {
        vessel(run, |v| 1e3 * v.max_displacement_m.max)
    }),
];
