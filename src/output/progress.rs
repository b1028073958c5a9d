//! The line of progress: one that updates in a terminal, plain lines elsewhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::collections::VecDeque;
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

/// Steps over which the speed is averaged: steps differ (ramp, systole), so only the last ones say what comes.
const WINDOW: usize = 50;
/// Shortest time between two plain lines.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// Progress of a run over a known number of time steps.
pub struct Progress {
    quiet: bool,
    bar: Option<ProgressBar>,
    steps: u64,
    done: u64,
    recent: VecDeque<f64>,
    last_line: Option<Instant>,
}

impl Progress {
    /// Progress of `steps` steps; `quiet` shows nothing.
    pub fn new(steps: u64, quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let style = ProgressStyle::with_template("{bar:24} {pos}/{len} {msg}")
                .expect("the template is valid");
            ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::stderr())
                .with_style(style)
        });
        Self {
            quiet,
            bar,
            steps,
            done: 0,
            recent: VecDeque::new(),
            last_line: None,
        }
    }

    /// The step number `done` was accepted.
    pub fn step(&mut self, done: u64, time: f64, iterations: usize, residual: f64, seconds: f64) {
        self.done = done;
        self.recent.push_back(seconds);
        if self.recent.len() > WINDOW {
            self.recent.pop_front();
        }
        if self.quiet {
            return;
        }
        let mean = self.recent.iter().sum::<f64>() / self.recent.len() as f64;
        let left = human(mean * (self.steps - self.done) as f64);
        let text = format!(
            "t = {time:.4} s  {iterations} iterations  residual {residual:.1e}  {mean:.2} s/step  {left} left"
        );
        if let Some(bar) = &self.bar {
            bar.set_position(self.done);
            bar.set_message(text);
        } else if self.done == self.steps
            || self
                .last_line
                .is_none_or(|last| last.elapsed() >= PLAIN_INTERVAL)
        {
            say(&format!("step {}/{}  {text}", self.done, self.steps));
            self.last_line = Some(Instant::now());
        }
    }

    /// Something that the user should know.
    pub fn note(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| say(text)),
            None => say(text),
        }
    }

    /// Leaves the last line standing.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.abandon();
        }
    }
}

/// A line on standard error, if anybody is still there to see it.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// A duration as a person says it: `45 s`, `12 min`, `3 h 05 min`.
pub fn human(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round() as u64;
    match seconds {
        s if s < 99.5 => format!("{s:.0} s"),
        s if s < 5970.0 => format!("{minutes} min"),
        _ => format!("{} h {:02} min", minutes / 60, minutes % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::human;

    #[test]
    fn durations_are_said_as_a_person_would() {
        assert_eq!(
            [human(0.4), human(99.0), human(100.0), human(3600.0)],
            ["0 s", "99 s", "2 min", "60 min"]
        );
        assert_eq!(human(11100.0), "3 h 05 min");
    }
}
