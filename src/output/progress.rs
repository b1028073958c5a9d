//! The line of progress: one that updates in a terminal, plain lines elsewhere.

use super::terminal;
use crate::case::RunEnds;
use crate::pfem::solution::listener::{self, Work};
use crate::simulation::observer::{AcceptedStep, AcceptedWall, Note, Observer};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::collections::VecDeque;
use std::io::stderr;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Steps over which the speed is averaged: steps differ (ramp, systole), so only the last ones say what comes.
const WINDOW: usize = 50;
/// Shortest time between two plain lines.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);
/// Columns of the bar, if there is room.
const BAR: std::ops::RangeInclusive<usize> = 8..=24;

/// Progress of a run over its time steps.
pub struct Progress {
    quiet: bool,
    bar: Option<ProgressBar>,
    ends: RunEnds,
    done: u64,
    recent: VecDeque<f64>,
    last_line: Option<Instant>,
    /// Until the first step is done, where no line is drawn before.
    first: Option<Work>,
}

impl Progress {
    /// Progress up to the step after which a run may be over next; `quiet` shows nothing.
    pub fn new(ends: RunEnds, quiet: bool) -> Self {
        Self {
            quiet,
            bar: bar(Some(ends.from(0) as u64)).filter(|_| !quiet),
            ends,
            done: 0,
            recent: VecDeque::new(),
            last_line: None,
            first: None,
        }
    }

    /// The first step begins.
    pub fn begin(&mut self) {
        self.first = (self.bar.is_none() && !self.quiet).then(|| Work::begin("the first step"));
    }

    /// The step number `done` was accepted.
    pub fn step(&mut self, done: u64, time: f64, iterations: usize, residual: f64, seconds: f64) {
        self.done = done;
        self.first = None;
        self.recent.push_back(seconds);
        if self.recent.len() > WINDOW {
            self.recent.pop_front();
        }
        if self.quiet {
            return;
        }
        let mean = self.recent.iter().sum::<f64>() / self.recent.len() as f64;
        // One that has come to such an end says so, and if it goes on, with the next step how far.
        let steps = self.ends.from(done as usize) as u64;
        let figures = Figures {
            done,
            steps,
            time,
            iterations,
            residual,
            seconds: mean,
            left: human(mean * (steps - done) as f64),
        };
        if let Some(bar) = &self.bar {
            bar.set_length(steps);
            bar.set_position(done);
            let columns = terminal::columns(&stderr()).unwrap_or(usize::MAX);
            bar.set_message(figures.line(columns));
        } else if done == steps
            || self
                .last_line
                .is_none_or(|last| last.elapsed() >= PLAIN_INTERVAL)
        {
            terminal::note(format_args!("step {}", figures.text(usize::MAX)));
            self.last_line = Some(Instant::now());
        }
    }

    /// Something that the user should know.
    fn say(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| terminal::note(text)),
            None => terminal::note(text),
        }
    }

    /// Leaves the last line standing.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.abandon();
        }
    }
}

/// Shows what is being prepared, and how far it is, where that takes long.
pub fn tell_preparation() {
    listener::listen(tell);
    if terminal::columns(&stderr()).is_none() {
        // Most of it says nothing while it works.
        std::thread::spawn(|| {
            loop {
                std::thread::sleep(PLAIN_INTERVAL);
                if let Ok(Some(preparation)) = NOW.lock().as_deref() {
                    terminal::note(preparation.text());
                }
            }
        });
    }
}

/// What is being prepared.
static NOW: Mutex<Option<Preparation>> = Mutex::new(None);

struct Preparation {
    what: &'static str,
    begin: Instant,
    /// The share of it that is done, if that is known, now and when it was first told: of how long that took nothing is
    /// known.
    share: Option<f64>,
    first_share: f64,
    /// When that share was told, and how many seconds one like the last piece of it takes for all.
    told: Instant,
    whole: f64,
    bar: Option<ProgressBar>,
}

impl Preparation {
    fn advance(&mut self, share: Option<f64>) {
        if let (Some(before), Some(now)) = (self.share, share)
            && now > before
        {
            self.whole = self.told.elapsed().as_secs_f64() / (now - before);
            self.told = Instant::now();
        }
        self.share = share;
    }

    fn text(&self) -> String {
        let seconds = self.begin.elapsed().as_secs_f64();
        let Some(share) = self.share else {
            return format!("{}, since {}", self.what, human(seconds));
        };
        let since = share - self.first_share;
        // What becomes slower goes on as slowly as it now is.
        let whole = f64::max(seconds / since, self.whole);
        let left = match since > 0.0 {
            true => format!(", about {} left", human(whole * (1.0 - share))),
            false => String::new(),
        };
        format!("{}: {:.0} %{left}", self.what, 100.0 * share)
    }
}

fn tell(what: &'static str, share: Option<f64>) {
    let Ok(mut now) = NOW.lock() else { return };
    let is_another = now.as_ref().is_none_or(|now| now.what != what);
    let is_done = share.is_some_and(|share| share >= 1.0);
    if is_another && is_done {
        return;
    }
    if is_another || is_done {
        if let Some(Preparation { bar: Some(bar), .. }) = now.take() {
            bar.finish_and_clear();
        }
        if is_done {
            return;
        }
    }
    let preparation = now.get_or_insert_with(|| Preparation {
        what,
        begin: Instant::now(),
        share: None,
        first_share: share.unwrap_or(0.0),
        told: Instant::now(),
        whole: 0.0,
        bar: bar(None),
    });
    preparation.advance(share);
    if let Some(bar) = &preparation.bar {
        let style = match share {
            None => "{msg} ({elapsed})",
            Some(_) => "{msg}",
        };
        bar.set_style(ProgressStyle::with_template(style).expect("the template is valid"));
        let text = share.map_or_else(|| what.to_owned(), |_| preparation.text());
        bar.set_message(text);
        bar.enable_steady_tick(Duration::from_secs(1));
    }
}

/// A line that changes, if standard error is a terminal.
fn bar(steps: Option<u64>) -> Option<ProgressBar> {
    terminal::columns(&stderr()).map(|_| {
        let style = ProgressStyle::with_template("{msg}").expect("the template is valid");
        ProgressBar::with_draw_target(steps, ProgressDrawTarget::stderr()).with_style(style)
    })
}

/// What the line says.
struct Figures {
    done: u64,
    steps: u64,
    time: f64,
    iterations: usize,
    residual: f64,
    seconds: f64,
    left: String,
}

impl Figures {
    /// As much as fits into `columns`; the least important figures are left out first.
    fn text(&self, columns: usize) -> String {
        // In the order in which they are shown, with their rank.
        let all = [
            (0, format!("{}/{}", self.done, self.steps)),
            (1, format!("t = {:.4} s", self.time)),
            (3, format!("{} iterations", self.iterations)),
            (5, format!("residual {:.1e}", self.residual)),
            (4, format!("{:.2} s/step", self.seconds)),
            (2, format!("{} left", self.left)),
        ];
        let text = |ranks: usize| {
            let shown = all.iter().filter(|(rank, _)| *rank < ranks);
            let shown: Vec<&str> = shown.map(|(_, figure)| figure.as_str()).collect();
            shown.join("  ")
        };
        let fitting = (1..=all.len()).rev().map(text).find(|t| t.len() <= columns);
        fitting.unwrap_or_default()
    }

    /// A line for a terminal: a bar before the text, if there is room.
    fn line(&self, columns: usize) -> String {
        // A terminal may wrap a line that ends in its last column.
        let columns = columns.saturating_sub(1);
        let text = self.text(columns);
        let room = columns.saturating_sub(text.len() + 1).min(*BAR.end());
        if !BAR.contains(&room) {
            return text;
        }
        let share = self.done as f64 / self.steps.max(1) as f64;
        let full = ((share * room as f64) as usize).min(room);
        format!("{}{} {text}", "█".repeat(full), "░".repeat(room - full))
    }
}

impl<S> Observer<S> for Progress {
    type Memory = ();

    fn accepted(&mut self, accepted: &AcceptedStep, _: &AcceptedWall<S>) -> std::io::Result<()> {
        let done = accepted.number - usize::from(!accepted.completes);
        let iterations = &accepted.step.iterations;
        let residual = iterations.last().map_or(0.0, |last| last.measure.residual);
        self.step(
            done as u64,
            accepted.time(),
            iterations.len(),
            residual,
            accepted.seconds,
        );
        Ok(())
    }

    fn note(&mut self, note: &Note) {
        match note {
            Note::Slow { .. } if self.quiet => {}
            Note::Slow { time, text } => self.say(&format!("t = {time:.6} s: {text}")),
            Note::Notice { time, text } => self.say(&format!("t = {time:.6} s: {text}")),
            Note::Rescue(text) => self.say(text),
        }
    }

    fn memory(&self) -> std::io::Result<()> {
        Ok(())
    }

    fn rewind(&mut self, (): ()) -> std::io::Result<()> {
        Ok(())
    }
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
    use super::{Figures, Preparation, human};
    use std::time::{Duration, Instant};

    #[test]
    fn a_preparation_says_how_long_it_will_take_once_that_is_known() {
        let after_30_s = |share: Option<f64>| {
            let preparation = Preparation {
                what: "loading the wall",
                begin: Instant::now() - Duration::from_secs(30),
                share,
                first_share: 0.25,
                told: Instant::now(),
                whole: 0.0,
                bar: None,
            };
            preparation.text()
        };
        assert_eq!(after_30_s(None), "loading the wall, since 30 s");
        assert_eq!(after_30_s(Some(0.25)), "loading the wall: 25 %");
        // Half of it took 30 s, and a quarter is left.
        assert_eq!(
            after_30_s(Some(0.75)),
            "loading the wall: 75 %, about 15 s left"
        );
        // The last hundredth took 10 s, as long as half of all before.
        let mut slower = Preparation {
            what: "loading the wall",
            begin: Instant::now() - Duration::from_secs(30),
            share: Some(0.75),
            first_share: 0.25,
            told: Instant::now() - Duration::from_secs(10),
            whole: 60.0,
            bar: None,
        };
        slower.advance(Some(0.76));
        assert_eq!(slower.text(), "loading the wall: 76 %, about 4 min left");
    }

    #[test]
    fn a_line_fits_into_the_terminal_and_holds_whole_figures() {
        let figures = Figures {
            done: 12345,
            steps: 15000,
            time: 2.469,
            iterations: 12,
            residual: 1.25e-6,
            seconds: 12.25,
            left: "9 h 02 min".into(),
        };
        let whole = figures.text(usize::MAX);
        assert_eq!(
            whole,
            "12345/15000  t = 2.4690 s  12 iterations  residual 1.3e-6  12.25 s/step  9 h 02 min left"
        );
        for columns in 12..150 {
            let line = figures.line(columns);
            assert!(line.chars().count() < columns, "{line}");
            let text = line.trim_start_matches(['█', '░', ' ']);
            for figure in text.split("  ") {
                assert!(whole.split("  ").any(|f| f == figure), "{columns}: {line}");
            }
        }
        assert_eq!(
            figures.line(60),
            "12345/15000  t = 2.4690 s  12 iterations  9 h 02 min left"
        );
        assert_eq!(
            figures.line(80),
            "12345/15000  t = 2.4690 s  12 iterations  12.25 s/step  9 h 02 min left"
        );
        assert!(figures.line(100).starts_with("████████░░ 12345/15000  t"));
    }

    #[test]
    fn durations_are_said_as_a_person_would() {
        assert_eq!(
            [human(0.4), human(99.0), human(100.0), human(3600.0)],
            ["0 s", "99 s", "2 min", "60 min"]
        );
        assert_eq!(human(11100.0), "3 h 05 min");
    }
}
