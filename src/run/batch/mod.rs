//! Many runs, each in a process of its own, several at once, with one table of progress.

mod board;
mod models;
mod sampling;
mod sweep;
mod worker;

use super::Interrupt;
pub use board::Board;
pub use models::{
    BatchRun, ImpossibleSample, Outcome, StudyModels, find, prepare, refuse_earlier, refuse_farther,
};
pub use sampling::Samples;
use std::collections::VecDeque;
use std::io;
use std::time::Duration;
pub use sweep::Variation;
pub use worker::Worker;

/// Time between two looks at the models.
const LOOK: Duration = Duration::from_millis(500);

/// Keeps `jobs` models at work until all are done, or until the user asks to end; returns what became of each.
pub fn work(
    models: &[BatchRun],
    interrupt: &Interrupt,
    mut board: Board,
    jobs: usize,
    start: impl Fn(&BatchRun) -> io::Result<Worker>,
) -> Vec<Outcome> {
    let mut outcomes: Vec<Outcome> = models.iter().map(BatchRun::outcome).collect();
    let mut waiting: VecDeque<usize> = (0..models.len())
        .filter(|&i| outcomes[i] == Outcome::Waiting)
        .collect();
    let mut working: Vec<(usize, Worker)> = Vec::new();
    loop {
        if interrupt.asked() {
            waiting.clear();
            working
                .iter_mut()
                .for_each(|(_, worker)| worker.interrupt());
        }
        while working.len() < jobs
            && let Some(i) = waiting.pop_front()
        {
            match start(&models[i]) {
                Ok(worker) => {
                    outcomes[i] = Outcome::Working;
                    working.push((i, worker));
                }
                Err(error) => outcomes[i] = Outcome::Failed(format!("cannot be started: {error}")),
            }
        }
        working.retain_mut(|(i, worker)| match worker.outcome() {
            Outcome::Working => true,
            ended => {
                outcomes[*i] = ended;
                false
            }
        });
        board.show(&outcomes);
        if working.is_empty() && waiting.is_empty() {
            board.finish();
            return outcomes;
        }
        std::thread::sleep(LOOK);
    }
}
