//! What is gathered step by step over a window of time.

use super::shear::ShearStatistics;
use super::wall::{WallState, widened};
use crate::Vec3;
use crate::case::Window;
use crate::fluid::{ElementModes, HighestModes};
use serde::{Deserialize, Serialize};

/// Integrals over a window, as far as the run has come.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WindowStatistics {
    /// The window that was asked for.
    pub window: Window,
    /// Steps that were seen.
    pub steps: usize,
    /// Time that the run has reached, s.
    reached: f64,
    /// Of the wall shear stress.
    pub shear: ShearStatistics,
    /// Integral of the points' displacement, m s.
    displacement: Vec<Vec3>,
    /// Integrals of the highest modes of the fluid's element at each face; empty if it has none.
    pub modes_at_wall: Vec<HighestModes>,
    /// The same of the whole fluid.
    pub modes: HighestModes,
}

impl WindowStatistics {
    /// Nothing yet, of a wall with that many faces and points.
    pub fn new(window: Window, faces: usize, points: usize) -> Self {
        Self {
            window,
            steps: 0,
            reached: 0.0,
            shear: ShearStatistics::new(faces),
            displacement: vec![Vec3::zeros(); points],
            modes_at_wall: Vec::new(),
            modes: HighestModes::default(),
        }
    }

    /// Time that the run has reached, s.
    pub fn reached(&self) -> f64 {
        self.reached
    }

    /// The same of a run that has reached a time (s) before it.
    pub fn after(self, reached: f64) -> Self {
        Self { reached, ..self }
    }

    /// Adds the end of a step with the highest modes of the fluid's elements, if it has any and the step lies in the
    /// window; it began where the one before ended, and is at most `longest` (s) long.
    pub fn add(&mut self, state: &WallState, modes: Option<&ElementModes>, longest: f64) {
        let step = (state.time - self.reached).min(longest);
        self.reached = state.time;
        if !self.window.contains(state.time, step) {
            return;
        }
        let shear: Vec<Vec3> = state.shear.iter().map(widened).collect();
        self.shear.add(&shear, step);
        for (sum, u) in self.displacement.iter_mut().zip(&state.displacement) {
            *sum += widened(u) * step;
        }
        if let Some(modes) = modes {
            self.modes.add(&modes.domain, step);
            (self.modes_at_wall).resize(modes.at_wall.len(), HighestModes::default());
            for (sum, modes) in self.modes_at_wall.iter_mut().zip(&modes.at_wall) {
                sum.add(modes, step);
            }
        }
        self.steps += 1;
    }

    /// Whether the whole window was seen.
    pub fn is_complete(&self) -> bool {
        let duration = self.window.end_s - self.window.start_s;
        (self.shear.duration() - duration).abs() < 1e-6 * duration
    }

    /// Mean displacement of the points, m; zero if no step was seen.
    pub fn mean_displacement(&self) -> Vec<Vec3> {
        let duration = self.shear.duration();
        let mean = |sum: &Vec3| if duration > 0.0 { sum / duration } else { *sum };
        self.displacement.iter().map(mean).collect()
    }
}
