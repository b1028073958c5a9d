//! A windkessel of three elements downstream of a vessel that stores blood as well, in the periodic state, and the one
//! that makes given pressures of a given flow.

use super::windkessel::{NoWindkessel, Pressures, STEPS, TIME_CONSTANTS};
use crate::case::FlowCurve;
use nalgebra::{Matrix2, Vector2};

/// Relative accuracy of resistance and time constant.
const ACCURACY: f64 = 1e-9;

/// `C dp/dt + p/R = Q_out`, `P = p + R_p Q_out` in the vessel, and `C_v dP/dt = Q - Q_out`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThreeElements {
    /// Resistance R_p before the windkessel, Pa s/m³.
    pub proximal: f64,
    /// Resistance R, Pa s/m³.
    pub resistance: f64,
    /// Compliance C, m³/Pa.
    pub compliance: f64,
    /// Compliance C_v of the vessel, m³/Pa.
    pub vessel: f64,
}

impl ThreeElements {
    /// Pressures in the vessel in the periodic state under a flow (m³/s) into it, by the trapezoidal rule.
    pub fn pressures(&self, curve: &FlowCurve) -> Pressures {
        let step = curve.period() / STEPS as f64;
        let flow: Vec<f64> = (0..=STEPS).map(|i| curve.flow(i as f64 * step)).collect();
        let pressures = match self.vessel > 0.0 {
            true => self.with_vessel(&flow, step),
            false => self.without_vessel(&flow, step),
        };
        Pressures::of(&pressures)
    }

    fn without_vessel(&self, flow: &[f64], step: f64) -> Vec<f64> {
        let rate = 0.5 * step / (self.resistance * self.compliance);
        let decay = (1.0 - rate) / (1.0 + rate);
        let gain = 0.5 * step / self.compliance / (1.0 + rate);
        let march = |mut p: f64| -> Vec<f64> {
            (flow.windows(2))
                .map(|q| {
                    p = decay * p + gain * (q[0] + q[1]);
                    p
                })
                .collect()
        };
        let brought = march(0.0)[STEPS - 1];
        let all = march(brought / (1.0 - decay.powi(STEPS as i32)));
        let with = all.iter().zip(&flow[1..]);
        with.map(|(p, q)| p + self.proximal * q).collect()
    }

    fn with_vessel(&self, flow: &[f64], step: f64) -> Vec<f64> {
        // Of (P, p)
        let (a, b) = (1.0 / self.proximal, 1.0 / self.resistance);
        let system = Matrix2::new(
            -a / self.vessel,
            a / self.vessel,
            a / self.compliance,
            -(a + b) / self.compliance,
        );
        let half = 0.5 * step * system;
        let implicit = (Matrix2::identity() - half).try_inverse();
        let implicit = implicit.unwrap_or_else(Matrix2::zeros);
        let forward = implicit * (Matrix2::identity() + half);
        let gain = implicit * Vector2::new(0.5 * step / self.vessel, 0.0);
        let march = |mut x: Vector2<f64>| -> Vec<Vector2<f64>> {
            (flow.windows(2))
                .map(|q| {
                    x = forward * x + gain * (q[0] + q[1]);
                    x
                })
                .collect()
        };
        let brought = march(Vector2::zeros())[STEPS - 1];
        let over_period = (0..STEPS).fold(Matrix2::identity(), |all, _| forward * all);
        let start = (Matrix2::identity() - over_period).try_inverse();
        let start = start.unwrap_or_else(Matrix2::zeros) * brought;
        march(start).iter().map(|x| x[0]).collect()
    }

    /// The windkessel downstream of the resistance `proximal` (Pa s/m³) and a vessel of the compliance `vessel` (m³/Pa)
    /// that makes pressures between `lowest` and `highest` (Pa, both positive) of a flow into the vessel. For each time
    /// constant `tau = R C` the highest pressure rises with R; of these the lowest rises with tau.
    ///
    /// # Errors
    /// If there is none.
    pub fn between(
        lowest: f64,
        highest: f64,
        curve: &FlowCurve,
        proximal: f64,
        vessel: f64,
    ) -> Result<Self, NoWindkessel> {
        let of = |tau: f64, resistance: f64| Self {
            proximal,
            resistance,
            compliance: tau / resistance,
            vessel,
        };
        let [mut short, mut long] = TIME_CONSTANTS.map(|periods| periods * curve.period());
        let samples = 1000;
        let mean =
            (0..samples).map(|i| curve.flow(curve.period() * f64::from(i) / f64::from(samples)));
        let mean = mean.sum::<f64>() / f64::from(samples);
        if mean <= 0.0 {
            return Err(NoWindkessel::NoMeanFlow(mean));
        }
        // The resistance that makes the highest pressure, if there is one
        let fitted = |tau: f64| -> Option<Self> {
            let top = |resistance: f64| of(tau, resistance).pressures(curve).highest;
            let (mut low, mut high) = (1e-6 * highest / mean, 2.0 * highest / mean);
            if top(low) > highest {
                return None;
            }
            while high / low > 1.0 + ACCURACY {
                let middle = (low * high).sqrt();
                match top(middle) < highest {
                    true => low = middle,
                    false => high = middle,
                }
            }
            Some(of(tau, low))
        };
        let bottom = |tau: f64| fitted(tau).map(|found| found.pressures(curve).lowest);
        let Some(widest) = bottom(short) else {
            return Err(NoWindkessel::ProximalTooLarge(proximal));
        };
        if lowest <= widest {
            return Err(match vessel > 0.0 {
                true => NoWindkessel::VesselTooSoft {
                    vessel,
                    all: vessel,
                },
                false => NoWindkessel::FlowTooSteady(widest / highest),
            });
        }
        if bottom(long).is_none_or(|found| found < lowest) {
            return Err(NoWindkessel::ProximalTooLarge(proximal));
        }
        while long / short > 1.0 + ACCURACY {
            let tau = (short * long).sqrt();
            match bottom(tau).is_some_and(|found| found < lowest) {
                true => short = tau,
                false => long = tau,
            }
        }
        fitted(long).ok_or(NoWindkessel::ProximalTooLarge(proximal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Inflow;
    use crate::tabular::units::MMHG;

    fn pulse() -> FlowCurve {
        let inflow = Inflow::pulse(3.5e-6, 4.5e-6, 0.5, 0.8);
        FlowCurve::Pulse {
            inflow,
            period: 1.0,
        }
    }

    /// Forty time constants by the classical Runge-Kutta method.
    fn marched(w: ThreeElements, curve: &FlowCurve) -> [f64; 2] {
        let step = 5e-4;
        let rates = |t: f64, [vessel, p]: [f64; 2]| {
            let out = (vessel - p) / w.proximal;
            [
                (curve.flow(t) - out) / w.vessel,
                (out - p / w.resistance) / w.compliance,
            ]
        };
        let along = |x: [f64; 2], d: [f64; 2], h: f64| [x[0] + h * d[0], x[1] + h * d[1]];
        let steps = (40.0 * w.resistance * w.compliance / step) as usize;
        let (mut x, mut extremes) = ([90.0 * MMHG; 2], [f64::INFINITY, 0.0_f64]);
        for n in 0..steps {
            let t = n as f64 * step;
            let a = rates(t, x);
            let b = rates(t + 0.5 * step, along(x, a, 0.5 * step));
            let c = rates(t + 0.5 * step, along(x, b, 0.5 * step));
            let d = rates(t + step, along(x, c, step));
            for i in 0..2 {
                x[i] += step / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]);
            }
            if n + 2000 >= steps {
                extremes = [extremes[0].min(x[0]), extremes[1].max(x[0])];
            }
        }
        extremes
    }

    #[test]
    fn the_proposed_windkessel_makes_the_requested_pressures() {
        let (curve, wanted) = (pulse(), [80.0 * MMHG, 120.0 * MMHG]);
        let found = ThreeElements::between(wanted[0], wanted[1], &curve, 2e8, 2.6e-11).unwrap();
        for (pressure, wanted) in marched(found, &curve).into_iter().zip(wanted) {
            let error = pressure / wanted - 1.0;
            assert!(error.abs() < 1e-5, "{error:e}");
        }
        // A vessel that stores next to nothing is as none.
        let [without, hardly] = [0.0, 1e-14]
            .map(|own| ThreeElements::between(wanted[0], wanted[1], &curve, 2e8, own).unwrap());
        assert!((without.resistance / hardly.resistance - 1.0).abs() < 1e-3);
        assert!((without.compliance / hardly.compliance - 1.0).abs() < 1e-2);
    }

    #[test]
    fn a_resistance_that_makes_more_than_the_pressures_is_refused() {
        let wanted = [80.0 * MMHG, 120.0 * MMHG];
        let error = ThreeElements::between(wanted[0], wanted[1], &pulse(), 2e9, 0.0).unwrap_err();
        assert!(
            matches!(error, NoWindkessel::ProximalTooLarge(_)),
            "{error}"
        );
    }
}
