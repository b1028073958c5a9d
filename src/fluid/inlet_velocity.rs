//! How a prescribed flow is spread over an inlet: uniformly, as a parabola, or as Womersley's solution for each of its
//! harmonics.
//!
//! The velocity into the vessel, times the area of the inlet, is a sum of terms that are each a shape times a factor in
//! time, and a shape `rest` for whatever flow these terms do not bring: all of it with a plug or a parabola. So the
//! flow through any mesh of the inlet is the prescribed one.

use crate::case::{FlowCurve, InletProfile};
use nalgebra::Complex;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Times in a period from which harmonics are taken.
const SAMPLES: usize = 4096;
/// Most harmonics.
const MOST: usize = 60;
/// Harmonics end where all that follow are smaller than this share of the largest.
const LEAST: f64 = 1e-6;

/// The shapes over an inlet.
#[derive(Debug, Clone, PartialEq)]
pub struct InletVelocity {
    profile: InletProfile,
    /// Mean flow, and the amplitude of each harmonic, m³/s; none but for Womersley's profile.
    harmonics: Vec<Complex<f64>>,
    /// Angular frequency of the first one, 1/s.
    frequency: f64,
    /// Womersley's number of the first one.
    alpha: f64,
}

impl InletVelocity {
    /// For a flow through a round inlet of about the given `radius` (m) and blood of a `kinematic_viscosity` (m²/s).
    pub fn new(
        profile: InletProfile,
        curve: &FlowCurve,
        radius: f64,
        kinematic_viscosity: f64,
    ) -> Self {
        let frequency = TAU / curve.period();
        let harmonics = match profile {
            InletProfile::Plug | InletProfile::Parabolic => Vec::new(),
            InletProfile::Womersley => harmonics(curve),
        };
        Self {
            profile,
            harmonics,
            frequency,
            alpha: radius * (frequency / kinematic_viscosity).sqrt(),
        }
    }

    /// Angular frequency of the first harmonic, 1/s.
    pub fn frequency(&self) -> f64 {
        self.frequency
    }

    /// The shape of what the terms do not bring, at a point whose distance from the middle is this share of the radius:
    /// the velocity relative to the mean one.
    pub fn rest(&self, share: f64) -> f64 {
        match self.profile {
            InletProfile::Plug | InletProfile::Womersley => 1.0,
            InletProfile::Parabolic => parabola(share),
        }
    }

    /// The shapes of the terms at such a point, as velocity times area (m³/s): the mean, then a pair for each harmonic.
    pub fn terms(&self, share: f64) -> Vec<f64> {
        let mut terms = Vec::new();
        for (n, flow) in self.harmonics.iter().enumerate() {
            if n == 0 {
                terms.push(flow.re * parabola(share));
                continue;
            }
            let value = flow * womersley(self.alpha * (n as f64).sqrt(), share);
            terms.extend([value.re, -value.im]);
        }
        terms
    }

    /// The factors of the terms at the time `t` (s): 1, then cosine and sine of each harmonic.
    pub fn factors(&self, t: f64) -> Vec<f64> {
        let phase = |n: usize| n as f64 * self.frequency * t;
        (0..self.harmonics.len())
            .flat_map(|n| match n {
                0 => vec![1.0],
                _ => vec![phase(n).cos(), phase(n).sin()],
            })
            .collect()
    }
}

/// Poiseuille's velocity relative to its mean.
fn parabola(share: f64) -> f64 {
    2.0 * (1.0 - share * share).max(0.0)
}

/// Mean and harmonics of a curve: `Re sum Q_n exp(i n omega t)`.
fn harmonics(curve: &FlowCurve) -> Vec<Complex<f64>> {
    let step = curve.period() / SAMPLES as f64;
    let flows: Vec<f64> = (0..SAMPLES).map(|i| curve.flow(i as f64 * step)).collect();
    let of = |n: usize| -> Complex<f64> {
        let term = |(i, q): (usize, &f64)| {
            let turns = (i * n % SAMPLES) as f64 / SAMPLES as f64;
            Complex::from_polar(*q, -TAU * turns)
        };
        let sum: Complex<f64> = flows.iter().enumerate().map(term).sum();
        sum * if n == 0 { 1.0 } else { 2.0 } / SAMPLES as f64
    };
    let mut all: Vec<Complex<f64>> = (0..=MOST).map(of).collect();
    let largest = all.iter().map(|q| q.norm()).fold(0.0, f64::max);
    while all.len() > 1 && all[all.len() - 1].norm() < LEAST * largest {
        all.pop();
    }
    all
}

/// Womersley's (1955) velocity relative to its mean over the section, for a Womersley number and time as `exp(i omega
/// t)`: `(1 - J0(Λ r)/J0(Λ)) / (1 - 2 J1(Λ)/(Λ J0(Λ)))` with `Λ = i^1.5 alpha`, at a share r of the radius.
fn womersley(alpha: f64, share: f64) -> Complex<f64> {
    let lambda = Complex::from_polar(alpha, 3.0 * FRAC_PI_4);
    let [wall, slope] = bessel(lambda);
    let [inner, _] = bessel(lambda * share.min(1.0));
    let decay = (lambda.im * (share.min(1.0) - 1.0)).exp();
    (Complex::from(1.0) - inner / wall * decay) / (Complex::from(1.0) - slope / wall * 2.0 / lambda)
}

/// Bessel's functions J0 and J1 times `exp(-|Im z|)`: by their series, for large z by Hankel's (Abramowitz and Stegun
/// 9.1.10 and 9.2.5).
fn bessel(z: Complex<f64>) -> [Complex<f64>; 2] {
    let scale = (-z.im.abs()).exp();
    if z.norm() < 25.0 {
        let quarter = -z * z / 4.0;
        let (mut term, mut sums) = (Complex::from(1.0), [Complex::from(0.0); 2]);
        for k in 0..120 {
            let k = f64::from(k);
            sums[0] += term;
            sums[1] += term / (k + 1.0);
            term *= quarter / ((k + 1.0) * (k + 1.0));
        }
        return [sums[0] * scale, sums[1] * z / 2.0 * scale];
    }
    [0.0, 1.0].map(|order: f64| {
        let mu = 4.0 * order * order;
        let (mut p, mut q) = (Complex::from(1.0), Complex::from(0.0));
        let mut term = Complex::from(1.0);
        for k in 1..12 {
            let odd = f64::from(2 * k - 1);
            term *= (mu - odd * odd) / (f64::from(k) * 8.0) / z;
            match k % 4 {
                1 => q += term,
                2 => p -= term,
                3 => q -= term,
                _ => p += term,
            }
        }
        let angle = z - order * FRAC_PI_2 - FRAC_PI_4;
        let i = Complex::i();
        // exp(±i angle - |Im z|), neither of which overflows
        let scaled = |exponent: Complex<f64>| (exponent - z.im.abs()).exp();
        let (plus, minus) = (scaled(i * angle), scaled(-i * angle));
        let (cosine, sine) = ((plus + minus) / 2.0, (plus - minus) / (2.0 * i));
        (Complex::from(2.0 / PI) / z).sqrt() * (p * cosine - q * sine)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Inflow;

    #[test]
    fn bessel_functions_are_those_of_tables() {
        // Abramowitz and Stegun, table 9.1 and 9.12 (ber and bei at 5)
        let [j0, j1] = bessel(Complex::from(5.0));
        assert!((j0.re + 0.177_596_771_314_338_3).abs() < 1e-14, "{j0}");
        assert!((j1.re + 0.327_579_137_591_465_2).abs() < 1e-14, "{j1}");
        let z = Complex::from_polar(5.0, 3.0 * FRAC_PI_4);
        let [kelvin, _] = bessel(z);
        let kelvin = kelvin * z.im.abs().exp();
        assert!((kelvin.re + 6.230_082_478_7).abs() < 1e-9, "{kelvin}");
        assert!((kelvin.im - 0.116_034_381_6).abs() < 1e-9, "{kelvin}");
    }

    #[test]
    fn both_ways_to_bessel_functions_meet() {
        for angle in [0.3, 3.0 * FRAC_PI_4] {
            let [below, above] =
                [24.999_999_999, 25.000_000_001].map(|r| bessel(Complex::from_polar(r, angle)));
            for (a, b) in below.iter().zip(&above) {
                let error = ((a - b) / a).norm();
                assert!(error < 1e-8, "{angle}: {error:e}");
            }
        }
    }

    #[test]
    fn the_profile_has_the_flow_of_the_curve_and_none_at_the_wall() {
        let inflow = Inflow::pulse(3.5e-6, 4.5e-6, 0.5, 0.8);
        let curve = FlowCurve::new(&inflow, 1.0).unwrap();
        // What the harmonics lack of the curve, which begins with a kink: 4.8e-4
        for (radius, most) in [(3e-3, 6e-4), (15e-3, 6e-4)] {
            let inlet = InletVelocity::new(InletProfile::Womersley, &curve, radius, 3.3e-6);
            for t in [0.0, 0.13, 0.2, 0.77] {
                let velocity = |share: f64| -> f64 {
                    let terms = inlet.terms(share).into_iter();
                    terms.zip(inlet.factors(t)).map(|(a, b)| a * b).sum()
                };
                assert!(velocity(1.0).abs() < 1e-16);
                // Over the area by the middle rule in the square of the share
                let n = 4000;
                let mean = (0..n).map(|i| velocity(((f64::from(i) + 0.5) / f64::from(n)).sqrt()));
                let flow = mean.sum::<f64>() / f64::from(n);
                let error = flow / curve.flow(t) - 1.0;
                assert!(error.abs() < most, "{radius} {t}: {error:e}");
            }
        }
    }
}
