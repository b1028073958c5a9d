//! A tube as surrogate: potential flow, linearized, in the structure's own wall.
//!
//! Within a time step the blood answers to a radial acceleration of the wall, `x/dt²` where the wall has moved by `x`,
//! by a pressure whose Laplacian is zero. It is expanded in waves around the circumference and in powers of the
//! distance from the axis, of which two are enough, between stations along the tube:
//! ```text
//! p(s, ξ, θ) = Σ_m Σ_k a_mk(s) ξ^(m + 2k) cos mθ  (and sin mθ),   ξ = distance/r,  k = 0, 1
//! ∫ ∇p·∇q dV = -rho/dt² ∮ x q dS - rho/dt Σ_ends C mean(p) mean(q)    for all q of this kind
//! x = residual + S p                                                  at the wall
//! ```
//! with the flow `C p` out of an end (Galerkin's method; implicit Euler in time). The mean pressure of a cross-section
//! also overcomes Poiseuille's friction. The added mass of a wave along the tube is `rho I_m(kr)/(k I_m'(kr))` then
//! (Hughes and Lubliner 1973 for long ones): good to 3 % up to `kr = 4` for m = 0.

use super::Stations;
use crate::coupling::acceleration::Surrogate;
use crate::lagrange::values_and_derivatives as lagrange;
use crate::quadrature::Rule;
use nalgebra::{DMatrix, DVector, Dyn, LU};
use std::f64::consts::PI;
use std::ops::Range;

/// What the surrogate knows of the fluid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurrogateBlood {
    /// Density, kg/m³.
    pub density: f64,
    /// Dynamic viscosity, Pa s.
    pub viscosity: f64,
    /// Displacement over velocity, and velocity over acceleration, of what happens within a time step: its length with
    /// implicit Euler, s.
    pub time_step: f64,
    /// Whether the radial inertia of the blood is taken into account (a three-dimensional fluid has it).
    pub radial_inertia: bool,
}

/// What happens at an end of the tube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TubeEnd {
    /// The flow is prescribed (a rigid tube before it makes no difference).
    Flow,
    /// The pressure is prescribed downstream of a rigid piece.
    Pressure {
        /// Length of the rigid piece, m; it has the radius of the adjacent section.
        rigid_length: f64,
    },
    /// A pressure that is proportional to the flow, downstream of a rigid piece.
    Resistance {
        /// Pa s/m³.
        resistance: f64,
        /// Length of the rigid piece, m; it has the radius of the adjacent section.
        rigid_length: f64,
    },
    /// A windkessel `C dp/dt + p/R = Q` downstream of a rigid piece and a resistance.
    Windkessel {
        /// Proximal resistance of the windkessel, Pa s/m³.
        proximal: f64,
        /// R, Pa s/m³.
        resistance: f64,
        /// C, m³/Pa.
        compliance: f64,
        /// Length of the rigid piece, m; it has the radius of the adjacent section.
        rigid_length: f64,
    },
}

/// Beside an end that holds the flow, and a wall that holds the volume, no pressure would be determined: so little,
/// relative to the tube itself, flows out of any end.
const LEAK: f64 = 1e-9;

/// Sweeps over the waves: each takes most of the error away.
const SWEEPS: usize = 6;

/// The wall's answer to a pressure at every n-th station at once, so far apart that each point feels the nearest only.
pub struct Comb {
    /// Its first station.
    first: usize,
    step: usize,
    /// Displacement of all points, m/Pa.
    answer: DVector<f64>,
    /// The station that each of them belongs to.
    nearest: Vec<usize>,
}

impl Comb {
    /// The `answer` (m/Pa) to the stations `first`, `first + step`, …
    pub fn new(stations: &Stations, first: usize, step: usize, answer: DVector<f64>) -> Self {
        Self {
            nearest: stations.nearest(first, step),
            first,
            step,
            answer,
        }
    }

    /// Whether a station is one of its own.
    fn asks(&self, station: usize) -> bool {
        station % self.step == self.first
    }

    /// The answer to one of its stations.
    fn answer_of(&self, station: usize) -> DVector<f64> {
        DVector::from_fn(self.answer.len(), |i, _| {
            let own = self.nearest[i / 3] == station;
            if own { self.answer[i] } else { 0.0 }
        })
    }

    /// Adds the answer to these pressures (Pa) at all stations.
    fn add(&self, pressures: &[f64], change: &mut DVector<f64>) {
        for (i, change) in change.iter_mut().enumerate() {
            *change += pressures[self.nearest[i / 3]] * self.answer[i];
        }
    }
}

/// The surrogate: stations, the wall's answer to a pressure at each, and the ends.
///
/// The answer is that of the structure within a time step, inertia included, to the pressure that is 1 Pa at one
/// station and falls linearly to zero at the next ([`Stations::share`]): the displacement of all wall points. To waves
/// around the circumference the wall answers near by only, so that several stations are asked at once ([`Comb`]). What
/// stations and waves cannot express passes.
pub struct TubeSurrogate {
    stations: Stations,
    blood: SurrogateBlood,
    /// A column for each station, m/Pa.
    answers: DMatrix<f64>,
    /// The same from wave 1 on.
    to_waves: Vec<Vec<Comb>>,
    /// **S**: both as amplitudes of all waves at the stations, all stations of wave 0 first.
    compliance: DMatrix<f64>,
    inlet: TubeEnd,
    outlet: TubeEnd,
    /// By periods around the circumference: from amplitudes of the displacement to those of the pressure, Pa/m.
    pressure: Vec<DMatrix<f64>>,
    /// By periods around the circumference, cosine and sine together: 1 less the pressure that the wall's answer to a
    /// pressure causes.
    both: Vec<LU<f64, Dyn, Dyn>>,
}

impl TubeSurrogate {
    /// A surrogate about the reference configuration; `answers` (m/Pa) has one displacement of all points for each
    /// station, `to_waves` combs of all stations for each wave but the first.
    pub fn new(
        stations: Stations,
        answers: &[DVector<f64>],
        to_waves: Vec<Vec<Comb>>,
        blood: SurrogateBlood,
        inlet: TubeEnd,
        outlet: TubeEnd,
    ) -> Self {
        let n = stations.count();
        assert_eq!(answers.len(), n, "one answer a station");
        assert_eq!(to_waves.len() + 1, stations.waves(), "one answer a wave");
        let amplitudes =
            |d: &DVector<f64>| DVector::from_column_slice(stations.amplitudes(d).as_slice());
        let mut columns: Vec<_> = answers.iter().map(amplitudes).collect();
        for combs in &to_waves {
            for station in 0..n {
                let comb = combs.iter().find(|comb| comb.asks(station));
                let comb = comb.expect("a wave's combs have all stations between them");
                columns.push(amplitudes(&comb.answer_of(station)));
            }
        }
        let mut surrogate = Self {
            blood,
            compliance: DMatrix::from_columns(&columns),
            answers: DMatrix::from_columns(answers),
            to_waves,
            inlet,
            outlet,
            pressure: Vec::new(),
            both: Vec::new(),
            stations,
        };
        surrogate.linearize(&surrogate.stations.reference_radius());
        surrogate
    }

    /// rho/dt and wall friction over rho/dt.
    fn friction(&self, radius: f64) -> f64 {
        let SurrogateBlood {
            density,
            viscosity,
            time_step,
            ..
        } = self.blood;
        1.0 + 8.0 * viscosity * time_step / (density * radius * radius)
    }

    /// Flow per pressure at an end, m³/(Pa s).
    fn conductance(&self, end: TubeEnd, radius: f64) -> f64 {
        let inertance = self.blood.density / self.blood.time_step * self.friction(radius)
            / (PI * radius * radius);
        let leak = LEAK / (self.stations.length() * inertance);
        let (rigid_length, impedance) = match end {
            TubeEnd::Flow => return leak,
            TubeEnd::Pressure { rigid_length } => (rigid_length, 0.0),
            TubeEnd::Resistance {
                resistance,
                rigid_length,
            } => (rigid_length, resistance),
            TubeEnd::Windkessel {
                proximal,
                resistance,
                compliance,
                rigid_length,
            } => {
                let admittance = compliance / self.blood.time_step + 1.0 / resistance;
                (rigid_length, proximal + 1.0 / admittance)
            }
        };
        let most = 1.0 / (LEAK * self.stations.length() * inertance);
        (1.0 / (rigid_length * inertance + impedance)).clamp(leak, most)
    }

    /// Pressure at the stations (Pa) that the blood in a tube of the given radii (m) answers to a radial displacement
    /// (m) of each, for waves of so many periods around the circumference.
    fn response(&self, periods: usize, radius: &[f64]) -> DMatrix<f64> {
        let SurrogateBlood {
            density, time_step, ..
        } = self.blood;
        let terms = if self.blood.radial_inertia { 2 } else { 1 };
        let count = radius.len() + 2;
        // The stations at the ends are as wide as their neighbours.
        let radius_at = |station: usize| radius[station.clamp(1, radius.len()) - 1];
        let power = |k: usize| (periods + 2 * k) as f64;
        let mut energy = DMatrix::<f64>::zeros(count * terms, count * terms);
        let mut widening = DMatrix::<f64>::zeros(count * terms, radius.len());
        for (first, arcs) in self.stations.pieces() {
            let (n, from, to) = (arcs.len(), arcs[0], arcs[arcs.len() - 1]);
            let r = (first..first + n).map(radius_at).sum::<f64>() / n as f64;
            let friction = if periods == 0 { self.friction(r) } else { 1.0 };
            let rule = Rule::gauss_legendre(n);
            for (x, weight) in rule.points.iter().zip(&rule.weights) {
                let weight = 0.5 * weight * (to - from);
                let (value, slope) = lagrange(arcs, from + 0.5 * (x + 1.0) * (to - from));
                for i in 0..n {
                    for j in 0..n {
                        let (product, slopes) =
                            (weight * value[i] * value[j], weight * slope[i] * slope[j]);
                        for k in 0..terms {
                            for l in 0..terms {
                                let sum = power(k) + power(l);
                                let along = r * r / (sum + 2.0) / friction;
                                let across = power(k) * power(l) + (periods * periods) as f64;
                                let across = if sum > 0.0 { across / sum } else { 0.0 };
                                energy[((first + i) * terms + k, (first + j) * terms + l)] +=
                                    along * slopes + across * product;
                            }
                            // The ends are held.
                            if (1..=radius.len()).contains(&(first + j)) {
                                widening[((first + i) * terms + k, first + j - 1)] += r * product;
                            }
                        }
                    }
                }
            }
        }
        if periods == 0 {
            for (end, station) in [(self.inlet, 0), (self.outlet, count - 1)] {
                let flow = self.conductance(end, radius_at(station));
                let flow = density / (2.0 * PI * time_step) * flow;
                for k in 0..terms {
                    for l in 0..terms {
                        let means = ((k + 1) * (l + 1)) as f64;
                        energy[(station * terms + k, station * terms + l)] += flow / means;
                    }
                }
            }
        }
        let coefficients = energy
            .cholesky()
            .expect("pressure gradients and ends have positive energy")
            .solve(&widening);
        let factor = -density / (time_step * time_step);
        DMatrix::from_fn(radius.len(), radius.len(), |i, j| {
            let at_wall = (0..terms).map(|k| coefficients[((i + 1) * terms + k, j)]);
            factor * at_wall.sum::<f64>()
        })
    }

    /// Prepares the answers of a tube of the given radii (m).
    fn linearize(&mut self, radius: &[f64]) {
        let smoothing = self.stations.smoothing();
        let pressure = |m| self.response(m, radius) * &smoothing;
        self.pressure = (0..=self.stations.periods()).map(pressure).collect();
        let both = |periods| {
            let rows = self.rows_of(periods);
            let own = self
                .compliance
                .view((rows.start, rows.start), (rows.len(), rows.len()));
            let caused = self.caused(periods, &own.into_owned());
            (DMatrix::identity(rows.len(), rows.len()) - caused).lu()
        };
        self.both = (0..=self.stations.periods()).map(both).collect();
    }

    /// The pressure at each station that removes a residual with these amplitudes (m), all stations of wave 0 first: by
    /// Gauss and Seidel's method, since a wall of few elements, or one that is not round, answers to a wave by others
    /// too, but less.
    fn pressures(&self, residual: &DVector<f64>) -> DVector<f64> {
        let (n, waves) = (self.stations.count(), self.stations.waves());
        let mut pressures = DVector::zeros(n * waves);
        for _ in 0..if waves > 1 { SWEEPS } else { 1 } {
            // Cosine and sine together, so that it does not matter where the angle is counted from.
            for periods in 0..=self.stations.periods() {
                let (rows, mut others) = (self.rows_of(periods), pressures.clone());
                let (from, count) = (rows.start, rows.len());
                others.rows_mut(from, count).fill(0.0);
                let widening =
                    residual.rows(from, count) + self.compliance.rows(from, count) * &others;
                let widening = DMatrix::from_column_slice(count, 1, widening.as_slice());
                let own = self.both[periods].solve(&self.caused(periods, &widening));
                let own = own.expect("blood answers a wall that widens by a pressure against it");
                pressures.rows_mut(from, count).copy_from(&own);
            }
        }
        pressures
    }

    /// The rows of the waves of so many periods among the amplitudes of all.
    fn rows_of(&self, periods: usize) -> Range<usize> {
        let n = self.stations.count();
        match periods {
            0 => 0..n,
            m => (2 * m - 1) * n..(2 * m + 1) * n,
        }
    }

    /// The pressures (Pa) that the blood answers to these amplitudes (m) of the waves of so many periods, column by
    /// column.
    fn caused(&self, periods: usize, widening: &DMatrix<f64>) -> DMatrix<f64> {
        let n = self.stations.count();
        let mut caused = widening.clone();
        for from in (0..widening.nrows()).step_by(n) {
            let pressures = &self.pressure[periods] * widening.rows(from, n);
            caused.rows_mut(from, n).copy_from(&pressures);
        }
        caused
    }

    /// The change of radius of each station that removes the residual `r` (m) of its radius.
    #[cfg(test)]
    pub(super) fn widen(&self, r: &[f64]) -> Vec<f64> {
        let r = DVector::from_column_slice(r);
        let (n, waves) = (r.len(), self.stations.waves());
        let residual = r.resize_vertically(n * waves, 0.0);
        let x = &residual + &self.compliance * self.pressures(&residual);
        x.as_slice()[..n].to_vec()
    }
}

impl Surrogate for TubeSurrogate {
    fn predict(&self, residual: &DVector<f64>) -> DVector<f64> {
        let amplitudes = self.stations.amplitudes(residual);
        let pressures = self.pressures(&DVector::from_column_slice(amplitudes.as_slice()));
        let n = self.stations.count();
        let mut change = residual + &self.answers * pressures.rows(0, n);
        for (i, combs) in self.to_waves.iter().enumerate() {
            let pressures = &pressures.as_slice()[(i + 1) * n..(i + 2) * n];
            combs
                .iter()
                .for_each(|comb| comb.add(pressures, &mut change));
        }
        change
    }

    fn finish_step(&mut self, d: &DVector<f64>) {
        let change = self.stations.amplitudes(d);
        let reference = self.stations.reference_radius();
        let widened = reference.iter().enumerate();
        let radius: Vec<f64> = widened.map(|(i, r)| r + change[(i, 0)]).collect();
        self.linearize(&radius);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, StationOptions, SurrogateWall, TubePlace};
    use super::*;
    use crate::Vec3;
    use crate::curve::SpaceCurve;

    const STIFFNESS: f64 = 1.2e7;
    const RING: usize = 8;

    fn points() -> Vec<Vec3> {
        let ring = |i: u32| {
            (0..RING).map(move |k| {
                let (sin, cos) = (k as f64 * 2.0 * PI / RING as f64).sin_cos();
                Vec3::new(f64::from(i) * 5e-4, 5e-3 * cos, 5e-3 * sin)
            })
        };
        (0..101).flat_map(ring).collect()
    }

    /// A tube of 50 mm length and 5 mm radius, stiffness 1.2e7 Pa/m.
    fn tube(inlet: TubeEnd, outlet: TubeEnd, radial_inertia: bool) -> TubeSurrogate {
        let points = points();
        let axis = Axis {
            line: SpaceCurve::x_axis(0.0, 0.05),
            length: 0.05,
        };
        let options = StationOptions {
            shape: SurrogateWall::Elements(4),
            most: 99,
            around: 2,
        };
        let stations = Stations::new(&points, axis, options).unwrap();
        let blood = SurrogateBlood {
            density: 1000.0,
            viscosity: 0.0,
            time_step: 1e-3,
            radial_inertia,
        };
        // Each point answers for itself.
        let answer = |pressure: &dyn Fn(TubePlace) -> f64| {
            let d = points.iter().flat_map(|x| {
                let radial = Vec3::new(0.0, x.y, x.z) / 5e-3;
                (pressure(stations.place(x)) / STIFFNESS * radial).data.0[0]
            });
            DVector::from_iterator(3 * points.len(), d)
        };
        let answers: Vec<_> = (0..stations.count())
            .map(|i| answer(&|x| stations.share(i, x)))
            .collect();
        let comb = |wave, first| {
            let shares = |x: TubePlace| -> f64 {
                let stations = (first..99).step_by(9).map(|i| stations.share(i, x));
                stations.sum()
            };
            let answer = answer(&|x| shares(x) * stations.uniform(wave, x));
            Comb::new(&stations, first, 9, answer)
        };
        let to_waves = (1..stations.waves())
            .map(|wave| (0..9).map(|first| comb(wave, first)).collect())
            .collect();
        TubeSurrogate::new(stations, &answers, to_waves, blood, inlet, outlet)
    }

    fn standing_wave(half_waves: f64) -> Vec<f64> {
        (1..100)
            .map(|i| (half_waves * PI * f64::from(i) / 100.0).sin())
            .collect()
    }

    #[test]
    fn a_standing_wave_meets_the_added_mass_of_a_tube() {
        let open = TubeEnd::Pressure { rigid_length: 0.0 };
        // Without radial inertia 2 rho/(k² r); with it rho I0(kr)/(k I1(kr)): kr = 0.314159, 1.256637, 2.513274.
        for (half_waves, bessel) in [(1.0, 6.444_4), (4.0, 1.886_9), (8.0, 1.304_7)] {
            let k: f64 = half_waves * PI / 0.05;
            for (inertia, mass) in [
                (false, 2000.0 / (k * k * 5e-3)),
                (true, 1000.0 * bessel / k),
            ] {
                let mode = standing_wave(half_waves);
                let expected = 1.0 / (1.0 + mass / 1e-6 / STIFFNESS);
                let x = tube(open, open, inertia).widen(&mode);
                let share = x[5] / mode[5];
                assert!(
                    (share / expected - 1.0).abs() < 0.01,
                    "{half_waves} {inertia}: {share} {expected}"
                );
            }
        }
    }

    #[test]
    fn waves_around_the_circumference_meet_their_added_mass() {
        // rho I_m(kr)/(k I_m'(kr)) with kr = 0.314159: about rho r/m
        let open = TubeEnd::Pressure { rigid_length: 0.0 };
        let surrogate = tube(open, open, true);
        for (wave, periods) in [(1, 1.0), (2, 1.0), (3, 2.0), (4, 2.0)] {
            let d = points().into_iter().flat_map(|x| {
                let radial = Vec3::new(0.0, x.y, x.z) / 5e-3;
                let along = (PI * x.x / 0.05).sin();
                (along
                    * surrogate
                        .stations
                        .uniform(wave, surrogate.stations.place(&x))
                    * radial)
                    .data
                    .0[0]
            });
            let d = DVector::from_iterator(3 * 101 * RING, d);
            let left = surrogate.predict(&d);
            let share = left.dot(&d) / d.norm_squared();
            let expected = 1.0 / (1.0 + 1000.0 * 5e-3 / periods / 1e-6 / STIFFNESS);
            assert!(
                (share / expected - 1.0).abs() < 0.02,
                "{wave}: {share} {expected}"
            );
        }
    }

    #[test]
    fn a_closed_tube_keeps_its_volume() {
        let surrogate = tube(TubeEnd::Flow, TubeEnd::Flow, true);
        let x = surrogate.widen(&standing_wave(1.0));
        let kept: f64 = surrogate
            .stations
            .pieces()
            .map(|(first, arcs)| {
                // Boole's rule for the fourth degree
                let at = |i: usize| if (1..=99).contains(&i) { x[i - 1] } else { 0.0 };
                let weights = [7.0, 32.0, 12.0, 32.0, 7.0];
                let sum: f64 = (0..5).map(|i| weights[i] * at(first + i)).sum();
                sum / 90.0 * (arcs[4] - arcs[0])
            })
            .sum();
        // Of 0.03 m² before
        assert!(kept.abs() < 1e-6, "{kept}");
    }

    #[test]
    fn what_no_wave_expresses_passes() {
        let surrogate = tube(TubeEnd::Flow, TubeEnd::Pressure { rigid_length: 0.0 }, true);
        let along = DVector::from_fn(3 * 101 * RING, |i, _| [0.3, 0.0, 0.0][i % 3]);
        let left = surrogate.predict(&along) - &along;
        assert!(left.norm() < 1e-9 * along.norm(), "{}", left.norm());
    }
}
