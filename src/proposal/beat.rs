//! How long a beat is, and time steps of which a whole number make one.

use super::{ProposalError, ProposalInput, told};
use crate::case::PeriodicTable;

/// A beat without a curve, s.
const PERIOD: f64 = 1.0;
/// Durations that are allowed, s, and those of hearts.
pub const ALLOWED: [f64; 2] = [1e-3, 1e3];
const OF_HEARTS: [f64; 2] = [0.15, 3.0];
/// A curve may end so much before the beat does, as a share of it.
const GAP: f64 = 0.02;
/// A beat has a multiple of so many steps, so that files that are written every tenth one meet the same times in each
/// beat.
const STEPS: f64 = 10.0;

/// A beat.
#[derive(Debug, Clone, PartialEq)]
pub struct Beat {
    /// Its duration, s.
    pub period: f64,
    /// What to tell of it.
    pub remarks: Vec<String>,
}

impl Beat {
    /// That of the input, or else of the curve of the flow, if there is one that is not to be stretched.
    ///
    /// # Errors
    /// If the curve does not say how long it is, or does not fit.
    pub fn of(input: &ProposalInput) -> Result<Self, ProposalError> {
        let mut remarks = Vec::new();
        let asked = input.period;
        let (Some(path), None) = (&input.flow, input.flow_period) else {
            let period = asked.unwrap_or(PERIOD);
            return Ok(Self { period, remarks });
        };
        let file = path.display();
        let (shown, last) = PeriodicTable::period_of_flow(path, input.flow_unit)
            .map_err(|e| told::in_options(&e.to_string()))?;
        let period = match (asked, shown) {
            (Some(period), _) if last > period * (1.0 + 1e-9) => {
                return Err(ProposalError::Input(format!(
                    "--period {period}: the curve in {file} reaches to {last} s; --flow-period {} stretches it to the beat",
                    shown.unwrap_or(last)
                )));
            }
            (Some(period), _) => period,
            (None, Some(period)) => {
                let closed = match last < period * (1.0 - 1e-9) {
                    true => ", with one more step back to its first value",
                    false => "",
                };
                remarks.push(format!(
                    "beat      {period} s, as long as the curve in {file}{closed} (--period gives another)"
                ));
                period
            }
            (None, None) => {
                return Err(ProposalError::Input(format!(
                    "--flow {file}: the curve does not come back to its first value, and its steps differ: say how long a beat \
                     is, --period S"
                )));
            }
        };
        let [short, long] = ALLOWED;
        if !(short..=long).contains(&period) {
            return Err(ProposalError::Input(format!(
                "--flow {file}: the curve is {period} s long, and beats are {short} to {long} s: are its times in another unit? \
                 --flow-period S says how long it is"
            )));
        }
        if !(OF_HEARTS[0]..=OF_HEARTS[1]).contains(&period) && asked.is_none() {
            remarks.push(format!(
                "warning: a beat of {period} s; are the times of {file} seconds?"
            ));
        }
        if let Some(shown) = shown.filter(|shown| *shown < (1.0 - GAP) * period) {
            remarks.push(format!(
                "warning: the curve in {file} is {shown} s long, and the beat {period} s; in between it is interpolated \
                 (--flow-period {shown} stretches it)"
            ));
        }
        Ok(Self { period, remarks })
    }
}

/// The largest step (s) up to `most`, and hardly less than that, of which a whole number make a period: `most` itself,
/// or a number of steps that ends with a zero.
pub fn fitting(most: f64, period: f64) -> f64 {
    let steps = period / most;
    if steps >= 1.0 && (steps - steps.round()).abs() < 1e-6 * steps {
        return period / steps.round();
    }
    period / (STEPS * (steps / STEPS).ceil())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_fit_any_beat() {
        for (period, steps) in [
            (1.0, 500.0),
            (0.6, 300.0),
            (1.1, 550.0),
            (0.917, 460.0),
            (0.955, 480.0),
            (0.821, 420.0),
            (0.857, 430.0),
            (0.8571429, 430.0),
            (std::f64::consts::FRAC_1_SQRT_2, 360.0),
            (0.001, 10.0),
        ] {
            let step = fitting(0.002, period);
            let found = period / step;
            assert!((found - steps).abs() < 1e-9, "{period}: {found}");
        }
    }
}
