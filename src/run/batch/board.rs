//! One table of progress for all models: it updates in a terminal, and is printed now and then elsewhere.

use super::models::{BatchRun, Outcome};
use crate::case::{Case, RunEnds};
use crate::output::progress::human;
use crate::output::run_files::RunFiles;
use crate::output::tables::{self, HistoryRow};
use crate::output::terminal;
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::{Duration, Instant};

/// Steps over which the speed of a model is averaged.
const RECENT: usize = 50;
/// Columns of a line next to its bar.
const BESIDE_BAR: usize = 54;
/// Time between two tables where they do not update.
const INTERVAL: Duration = Duration::from_secs(60);
/// Models that all have a line; of more, only those that work have one.
const MOST_LINES: usize = 16;

/// The table.
pub struct Board {
    rows: Vec<ModelRow>,
    jobs: usize,
    quiet: bool,
    lines: Option<Lines>,
    last_shown: Option<Instant>,
    last: Vec<Outcome>,
    start: Instant,
    /// Models that were done at the start.
    models_before: usize,
}

/// The lines in a terminal.
struct Lines {
    all: MultiProgress,
    models: Vec<ProgressBar>,
    total: ProgressBar,
}

/// What is known of a model.
struct ModelRow {
    name: String,
    files: RunFiles,
    case: Case,
    /// After which it may end next, or has ended.
    steps: usize,
    done: usize,
    /// Of these, steps that an earlier study has done.
    done_before: usize,
    /// Seconds per step, lately.
    pace: Option<f64>,
}

impl ModelRow {
    fn look(&mut self) {
        let Ok(history) = tables::read::<HistoryRow>(&self.files.history()) else {
            return; // not there yet
        };
        let reached = history.last().map_or(0.0, |row| row.time_s);
        self.done = (reached / self.case.time.step + 1e-6) as usize;
        self.steps = RunEnds::of(&self.case).from(self.done);
        let recent = &history[history.len().saturating_sub(RECENT)..];
        if !recent.is_empty() {
            self.pace =
                Some(recent.iter().map(|row| row.wall_s).sum::<f64>() / recent.len() as f64);
        }
    }

    fn message(&self, outcome: &Outcome) -> String {
        match (outcome, self.pace) {
            (Outcome::Working, Some(pace)) => {
                let left = human(pace * (self.steps - self.done.min(self.steps)) as f64);
                format!("{pace:.2} s/step, {left} left")
            }
            (Outcome::Working, None) => "starting".into(),
            (Outcome::Waiting, _) => "waiting".into(),
            (Outcome::Done, _) => "done".into(),
            (Outcome::Interrupted, _) => "interrupted".into(),
            (Outcome::Failed(_), _) => "failed".into(),
        }
    }
}

impl Board {
    /// A table of models, `jobs` of which work at once; `quiet` shows nothing.
    pub fn new(models: &[BatchRun], jobs: usize, quiet: bool) -> Self {
        let rows: Vec<ModelRow> = models
            .iter()
            .map(|model| {
                let mut row = ModelRow {
                    name: model.name.clone(),
                    files: RunFiles::new(&model.out),
                    steps: RunEnds::of(&model.case).from(0),
                    case: model.case.case.clone(),
                    done: 0,
                    done_before: 0,
                    pace: None,
                };
                row.look();
                row.done_before = row.done;
                row
            })
            .collect();
        let columns = terminal::columns(&std::io::stderr()).filter(|_| !quiet);
        let lines = columns.map(|columns| {
            let all = MultiProgress::with_draw_target(ProgressDrawTarget::stderr());
            let bar = columns.saturating_sub(BESIDE_BAR).clamp(4, 24);
            let template = format!("{{prefix:10}} {{bar:{bar}}} {{pos:>5}}/{{len}} {{wide_msg}}");
            let style = ProgressStyle::with_template(&template).expect("the template is valid");
            let line = |_| all.add(ProgressBar::new(1).with_style(style.clone()));
            let count = match rows.len() <= MOST_LINES {
                true => rows.len(),
                false => jobs,
            };
            let models = (0..count).map(line).collect();
            let plain = ProgressStyle::with_template("{msg}").expect("the template is valid");
            let total = all.add(ProgressBar::new(1).with_style(plain));
            Lines { all, models, total }
        });
        Self {
            last: Vec::new(),
            rows,
            jobs,
            quiet,
            lines,
            last_shown: None,
            start: Instant::now(),
            models_before: (models.iter())
                .filter(|model| model.outcome() == Outcome::Done)
                .count(),
        }
    }

    /// Shows how far the models are.
    pub fn show(&mut self, outcomes: &[Outcome]) {
        if self.quiet {
            return;
        }
        let changed = self.last != outcomes;
        let is_due = self
            .last_shown
            .is_none_or(|last| last.elapsed() >= INTERVAL);
        if self.lines.is_none() && !changed && !is_due {
            return;
        }
        for ((i, row), outcome) in self.rows.iter_mut().enumerate().zip(outcomes) {
            if *outcome == Outcome::Working || changed && self.last.get(i) != Some(outcome) {
                row.look();
            }
        }
        let total = self.total(outcomes);
        let is_short = self.rows.len() <= MOST_LINES;
        let is_told = |outcome: &Outcome| is_short || *outcome == Outcome::Working;
        let told = self.rows.iter().zip(outcomes);
        let told = told.filter(|(_, outcome)| is_told(outcome));
        if let Some(lines) = &self.lines {
            for ((row, outcome), bar) in told.zip(&lines.models) {
                bar.set_prefix(row.name.clone());
                bar.set_length(row.steps as u64);
                bar.set_position(row.done as u64);
                bar.set_message(row.message(outcome));
            }
            lines.total.set_message(total);
        } else {
            let mut table = String::new();
            for (row, outcome) in told {
                let (done, steps) = (row.done, row.steps);
                let message = row.message(outcome);
                table += &format!("{:10} {done:>5}/{steps} {message}\n", row.name);
            }
            terminal::note(format_args!("{table}{total}"));
        }
        self.last = outcomes.to_vec();
        self.last_shown = Some(Instant::now());
    }

    /// Models that are done, and the time that all will be.
    fn total(&self, outcomes: &[Outcome]) -> String {
        let count = |wanted: fn(&Outcome) -> bool| outcomes.iter().filter(|o| wanted(o)).count();
        let done = count(|outcome| *outcome == Outcome::Done);
        let mut text = format!("{done} of {} models done", self.rows.len());
        let failed = count(|outcome| matches!(outcome, Outcome::Failed(_)));
        if failed > 0 {
            text += &format!(", {failed} failed");
        }
        let paces: Vec<f64> = self.rows.iter().filter_map(|row| row.pace).collect();
        if paces.is_empty() || done == self.rows.len() {
            return text;
        }
        let usual = paces.iter().sum::<f64>() / paces.len() as f64;
        // Of each model the seconds of the steps that were done here, and of those that are left.
        let work = self.rows.iter().zip(outcomes).map(|(row, outcome)| {
            let done = row.done.min(row.steps);
            let left = match outcome {
                Outcome::Working | Outcome::Waiting => row.steps - done,
                _ => 0,
            };
            let here = done - row.done_before.min(done);
            [here, left].map(|steps| steps as f64 * row.pace.unwrap_or(usual))
        });
        let work: Vec<[f64; 2]> = work.collect();
        let [here, left] = [0, 1].map(|k| work.iter().map(|w| w[k]).sum::<f64>());
        // Work is shared evenly at best, and no model can be divided.
        let longest = work.iter().map(|w| w[1]).fold(0.0, f64::max);
        // The steps are not all that a model takes: once one is whole, what has passed tells the rest.
        let jobs = match done > self.models_before && here > 0.0 {
            true => here / self.start.elapsed().as_secs_f64(),
            false => self.jobs as f64,
        };
        text += &format!(", about {} left for all", human((left / jobs).max(longest)));
        text
    }

    /// Something that the user should know.
    pub fn note(&self, text: &str) {
        match &self.lines {
            Some(lines) => lines.all.suspend(|| terminal::note(text)),
            None => terminal::note(text),
        }
    }

    /// Leaves the last table standing.
    pub fn finish(&self) {
        if let Some(lines) = &self.lines {
            lines.models.iter().for_each(ProgressBar::abandon);
            lines.total.abandon();
        }
    }
}
