//! Averages over beats: what happens at the same phase of each period.

use super::shear::ShearStatistics;
use super::wall::{WallState, WetSurface, widened};
use crate::Vec3;
use crate::case::Window;

/// Divides a period into equal phases, from its start (not included) to its end (included).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phases {
    /// Length of the period, s.
    pub period: f64,
    /// How many.
    pub count: usize,
}

impl Phases {
    /// The phase, from 0, in which the step ends that ends at `time` (s) and is `step` (s) long.
    pub fn of(self, time: f64, step: f64) -> usize {
        // Half a step before its end, a step is within one phase whatever the rounding.
        let share = ((time - 0.5 * step) / self.period).rem_euclid(1.0);
        ((share * self.count as f64) as usize).min(self.count - 1)
    }

    /// The beat, from 0, of such a step.
    pub fn beat(self, time: f64, step: f64) -> usize {
        ((time - 0.5 * step) / self.period).max(0.0) as usize
    }

    /// End of a phase within the period, s.
    pub fn end(self, phase: usize) -> f64 {
        self.period * (phase + 1) as f64 / self.count as f64
    }
}

/// A phase of a quantity over all beats of a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseMean {
    /// Beats that have a value.
    pub beats: usize,
    /// Mean over these of the beats' means.
    pub mean: f64,
    /// Their standard deviation, that of a sample; 0 if there is only one.
    pub deviation: f64,
}

/// Phase means of a quantity with the `values` at the `times` (s) of steps that are `step` (s) long; `None` for a phase
/// without any. Times beyond the window do not count.
pub fn phase_means(
    phases: Phases,
    window: Window,
    step: f64,
    times: &[f64],
    values: &[f64],
) -> Vec<Option<PhaseMean>> {
    // Of each phase: beat, sum and number of its values.
    let mut sums: Vec<Vec<(usize, f64, usize)>> = vec![Vec::new(); phases.count];
    for (&time, value) in times.iter().zip(values) {
        if !window.contains(time, step) {
            continue;
        }
        let (beats, beat) = (&mut sums[phases.of(time, step)], phases.beat(time, step));
        match beats.last_mut() {
            Some((last, sum, n)) if *last == beat => (*sum, *n) = (*sum + value, *n + 1),
            _ => beats.push((beat, *value, 1)),
        }
    }
    let mean = |beats: Vec<(usize, f64, usize)>| {
        let n = beats.len();
        let means: Vec<f64> = beats.iter().map(|(_, sum, n)| sum / *n as f64).collect();
        let mean = means.iter().sum::<f64>() / n as f64;
        let squares: f64 = means.iter().map(|m| (m - mean).powi(2)).sum();
        (n > 0).then(|| PhaseMean {
            beats: n,
            mean,
            deviation: (squares / (n.max(2) - 1) as f64).sqrt(),
        })
    };
    sums.into_iter().map(mean).collect()
}

/// Wall shear stress and shape of the wall at each phase, averaged over all beats of a window.
#[derive(Debug, Clone)]
pub struct WallPhases {
    phases: Phases,
    window: Window,
    step: f64,
    shear: Vec<ShearStatistics>,
    displacement: Vec<Vec<Vec3>>,
}

impl WallPhases {
    /// Nothing yet, of steps of the length `step` (s).
    pub fn new(phases: Phases, window: Window, step: f64, wall: &WetSurface) -> Self {
        Self {
            phases,
            window,
            step,
            shear: vec![ShearStatistics::new(wall.faces.len()); phases.count],
            displacement: vec![vec![Vec3::zeros(); wall.points.len()]; phases.count],
        }
    }

    /// Adds the end of a step, if it lies in the window.
    pub fn add(&mut self, state: &WallState) {
        if !self.window.contains(state.time, self.step) {
            return;
        }
        let phase = self.phases.of(state.time, self.step);
        let shear: Vec<Vec3> = state.shear.iter().map(widened).collect();
        self.shear[phase].add(&shear, self.step);
        let sums = self.displacement[phase].iter_mut();
        for (sum, u) in sums.zip(&state.displacement) {
            *sum += widened(u) * self.step;
        }
    }

    /// Each phase that was seen: its end within the period (s), mean wall shear stress (Pa, vector and magnitude) of
    /// each face, and mean displacement (m) of each point.
    pub fn means(&self) -> impl Iterator<Item = (f64, Vec<Vec3>, Vec<f64>, Vec<Vec3>)> + '_ {
        let all = self.shear.iter().zip(&self.displacement).enumerate();
        let seen = all.filter(|(_, (shear, _))| shear.duration() > 0.0);
        seen.map(|(phase, (shear, sums))| {
            let duration = shear.duration();
            let displacement = sums.iter().map(|sum| sum / duration).collect();
            let (vector, magnitude) = (shear.mean(), shear.time_averaged());
            (self.phases.end(phase), vector, magnitude, displacement)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::TAU;

    const STEP: f64 = 0.002;

    fn phases(count: usize) -> Phases {
        Phases { period: 0.8, count }
    }

    #[test]
    fn every_step_has_its_phase_and_beat_despite_rounding() {
        for count in [1, 10, 400] {
            let mut seen = vec![0; count];
            for n in 1..=800 {
                let time = n as f64 * STEP;
                seen[phases(count).of(time, STEP)] += 1;
                assert_eq!(phases(count).beat(time, STEP), usize::from(n > 400));
            }
            assert!(seen.iter().all(|n| *n == 800 / count), "{seen:?}");
        }
        assert_relative_eq!(phases(10).end(9), 0.8);
    }

    #[test]
    fn means_over_beats_are_those_of_a_wave_whose_mean_drifts() {
        // Beats with the offsets 0, 1 and 5; the first does not lie in the window.
        let times: Vec<f64> = (1..=1200).map(|n| n as f64 * STEP).collect();
        let offset = |t: f64| [0.0, 1.0, 5.0][phases(4).beat(t, STEP)];
        let values = times.iter().map(|t| offset(*t) + (TAU * t / 0.8).sin());
        let values: Vec<f64> = values.collect();
        let window = Window {
            start_s: 0.8,
            end_s: 2.4,
        };
        let found = phase_means(phases(400), window, STEP, &times, &values);
        for (phase, found) in found.into_iter().enumerate() {
            let found = found.unwrap();
            let wave = (TAU * (phase + 1) as f64 / 400.0).sin();
            assert_eq!(found.beats, 2);
            assert_relative_eq!(found.mean, 3.0 + wave, epsilon = 1e-12);
            assert_relative_eq!(found.deviation, 8.0_f64.sqrt(), max_relative = 1e-12);
        }
        let short = Window {
            start_s: 0.8,
            end_s: 1.2,
        };
        let found = phase_means(phases(4), short, STEP, &times, &values);
        assert_eq!(found.iter().filter(|phase| phase.is_some()).count(), 2);
        assert_eq!(found[0].unwrap().deviation, 0.0);
    }
}
