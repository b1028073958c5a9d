//! A two-element windkessel in the periodic state, and the one that makes given pressures of a given flow.

use crate::case::{FlowCurve, Windkessel};

/// Steps in which a period is integrated.
pub(super) const STEPS: usize = 2000;
/// Time constants that are looked at, in periods.
pub(super) const TIME_CONSTANTS: [f64; 2] = [1e-2, 1e4];
/// Relative accuracy of the time constant.
const ACCURACY: f64 = 1e-10;

/// `C dp/dt + p/R = Q`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoElements {
    /// Resistance R, Pa s/m³.
    pub resistance: f64,
    /// Compliance C, m³/Pa.
    pub compliance: f64,
}

impl From<&Windkessel> for TwoElements {
    fn from(windkessel: &Windkessel) -> Self {
        Self {
            resistance: windkessel.resistance,
            compliance: windkessel.compliance,
        }
    }
}

/// Pressures of a windkessel over a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pressures {
    /// Mean over the period, Pa.
    pub mean: f64,
    /// Lowest, Pa.
    pub lowest: f64,
    /// Highest, Pa.
    pub highest: f64,
}

impl Pressures {
    /// Those of a curve of samples over a period.
    pub fn of(pressures: &[f64]) -> Self {
        Self {
            mean: pressures.iter().sum::<f64>() / pressures.len() as f64,
            lowest: pressures.iter().copied().fold(f64::INFINITY, f64::min),
            highest: pressures.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }
}

/// Why no windkessel makes the pressures that are wanted.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoWindkessel {
    /// Blood flows back as much as forth.
    #[error("the mean flow is {0:.3e} m³/s, and a resistance needs a positive one")]
    NoMeanFlow(f64),
    /// Even without compliance the pressure would vary less.
    #[error(
        "the flow varies so little that its pressures cannot be further apart than {:.0} % of the highest",
        100.0 * (1.0 - .0)
    )]
    FlowTooSteady(f64),
    /// The proximal resistance alone exceeds them.
    #[error(
        "with a proximal resistance of {0:.3e} Pa s/m³ no windkessel gives these pressures: its own pressure would vary too little, or its highest would exceed the wanted one; a tenth of the whole resistance is usual"
    )]
    ProximalTooLarge(f64),
    /// The vessel itself stores more than the windkessel may.
    #[error(
        "the vessel's own compliance is {vessel:.3e} m³/Pa, but only {all:.3e} m³/Pa may there be in all: pressures \
         will be closer together than that"
    )]
    VesselTooSoft {
        /// Compliance of the vessel, m³/Pa.
        vessel: f64,
        /// Compliance that makes the pressures, m³/Pa.
        all: f64,
    },
}

impl TwoElements {
    /// Pressures in the periodic state under a flow (m³/s), exact for one that is linear over each of many steps.
    pub fn pressures(&self, curve: &FlowCurve) -> Pressures {
        let period = curve.period();
        let step = period / STEPS as f64;
        let rate = step / (self.resistance * self.compliance);
        let decay = (-rate).exp();
        // Weights of the flows at both ends of a step; what a small rate leaves of 1 - (1 - decay)/rate is lost in
        // rounding.
        let late = match rate < 1e-4 {
            true => rate * (0.5 - rate / 6.0),
            false => 1.0 + (-rate).exp_m1() / rate,
        };
        let early = -(-rate).exp_m1() - late;
        let flow: Vec<f64> = (0..=STEPS).map(|i| curve.flow(i as f64 * step)).collect();
        let march = |start: f64| {
            let next = |p: &mut f64, q: &[f64]| {
                *p = decay * *p + self.resistance * (early * q[0] + late * q[1]);
                Some(*p)
            };
            flow.windows(2).scan(start, next).collect::<Vec<f64>>()
        };
        // The end is the start times the decay over a period, and what the flow brings.
        let brought = march(0.0)[STEPS - 1];
        let pressures = march(brought / -(-rate * STEPS as f64).exp_m1());
        Pressures::of(&pressures)
    }

    /// The windkessel downstream of a vessel of the compliance `vessel` (m³/Pa) that makes pressures between `lowest`
    /// and `highest` (Pa, both positive) of a flow into the vessel. With `tau = R C` the pressure is R times a function
    /// of time and tau; tau follows from the ratio of its extremes, which rises with it, and R from the highest.
    ///
    /// # Errors
    /// If there is none.
    pub fn between(
        lowest: f64,
        highest: f64,
        curve: &FlowCurve,
        vessel: f64,
    ) -> Result<Self, NoWindkessel> {
        let of = |tau: f64| {
            let unit = Self {
                resistance: 1.0,
                compliance: tau,
            };
            unit.pressures(curve)
        };
        let [mut short, mut long] = TIME_CONSTANTS.map(|periods| periods * curve.period());
        let mean = of(long).mean;
        if mean <= 0.0 {
            return Err(NoWindkessel::NoMeanFlow(mean));
        }
        let ratio = |pressures: &Pressures| pressures.lowest / pressures.highest;
        let wanted = lowest / highest;
        let steadiest = ratio(&of(short));
        if wanted <= steadiest {
            return Err(NoWindkessel::FlowTooSteady(steadiest));
        }
        while long / short > 1.0 + ACCURACY {
            let tau = (short * long).sqrt();
            match ratio(&of(tau)) < wanted {
                true => short = tau,
                false => long = tau,
            }
        }
        let resistance = highest / of(long).highest;
        let all = long / resistance;
        if all <= vessel {
            return Err(NoWindkessel::VesselTooSoft { vessel, all });
        }
        Ok(Self {
            resistance,
            compliance: all - vessel,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Inflow;
    use crate::tabular::units::MMHG;

    fn pulse(base: f64, amplitude: f64) -> FlowCurve {
        let inflow = Inflow::pulse(base, amplitude, 0.5, 0.8);
        FlowCurve::Pulse {
            inflow,
            period: 1.0,
        }
    }

    /// Forty time constants by the classical Runge-Kutta method, which knows nothing of periods.
    fn marched(windkessel: TwoElements, curve: &FlowCurve) -> [f64; 2] {
        let TwoElements {
            resistance,
            compliance,
        } = windkessel;
        let step = 1e-3;
        let rate = |t: f64, p: f64| (curve.flow(t) - p / resistance) / compliance;
        let steps = (40.0 * resistance * compliance / step).ceil() as usize;
        let (mut p, mut extremes) = (0.0, [f64::INFINITY, 0.0_f64]);
        for n in 0..steps {
            let t = n as f64 * step;
            let a = rate(t, p);
            let b = rate(t + 0.5 * step, p + 0.5 * step * a);
            let c = rate(t + 0.5 * step, p + 0.5 * step * b);
            let d = rate(t + step, p + step * c);
            p += step / 6.0 * (a + 2.0 * (b + c) + d);
            if n + 1000 >= steps {
                extremes = [extremes[0].min(p), extremes[1].max(p)];
            }
        }
        extremes
    }

    #[test]
    fn the_proposed_windkessel_makes_the_requested_pressures() {
        for (base, amplitude, vessel) in [(3.5e-6, 4.5e-6, 0.0), (1.35e-6, 5.2e-6, 2.6e-11)] {
            let curve = pulse(base, amplitude);
            let wanted = [80.0 * MMHG, 120.0 * MMHG];
            let found = TwoElements::between(wanted[0], wanted[1], &curve, vessel).unwrap();
            let all = TwoElements {
                compliance: found.compliance + vessel,
                ..found
            };
            for (pressure, wanted) in marched(all, &curve).into_iter().zip(wanted) {
                let error = pressure / wanted - 1.0;
                // The largest and smallest of 2000 values, and steps of 0.5 ms: 2e-6.
                assert!(error.abs() < 5e-6, "{error:e}");
            }
        }
    }

    #[test]
    fn the_mean_pressure_is_that_of_the_mean_flow() {
        let curve = pulse(3.5e-6, 4.5e-6);
        let mean: f64 = (0..10_000)
            .map(|i| curve.flow((i as f64 + 0.5) * 1e-4))
            .sum::<f64>()
            / 1e4;
        for compliance in [1e-12, 1.2e-10, 1e-6] {
            let windkessel = TwoElements {
                resistance: 2.85e9,
                compliance,
            };
            let error = windkessel.pressures(&curve).mean / (2.85e9 * mean) - 1.0;
            assert!(error.abs() < 1e-6, "{compliance:e}: {error:e}");
        }
    }

    #[test]
    fn what_no_windkessel_can_make_is_said() {
        let between = |curve: &FlowCurve, lowest, vessel| {
            TwoElements::between(lowest * MMHG, 120.0 * MMHG, curve, vessel).unwrap_err()
        };
        let steady = between(&pulse(3.5e-6, 0.1e-6), 80.0, 0.0);
        assert!(matches!(steady, NoWindkessel::FlowTooSteady(_)), "{steady}");
        assert!(
            steady.to_string().contains("further apart than 3 %"),
            "{steady}"
        );
        let backwards = between(&pulse(-3.5e-6, 0.0), 80.0, 0.0);
        assert!(
            matches!(backwards, NoWindkessel::NoMeanFlow(_)),
            "{backwards}"
        );
        let soft = between(&pulse(3.5e-6, 4.5e-6), 80.0, 1e-9);
        assert!(matches!(soft, NoWindkessel::VesselTooSoft { .. }), "{soft}");
    }
}
