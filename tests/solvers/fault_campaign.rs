//! Driver and solver are killed at random moments of a coupled run, again and again: it always goes on, leaves no
//! process behind, loses no more than the steps since the last checkpoint, and ends with the history of a run that
//! nobody disturbed.
//!
//! The long campaign, `cargo test --release --test solvers fault_campaign -- --ignored`, takes about ten minutes.

use crate::run_support::*;
use rustix::process::Signal;
use std::path::Path;
use std::process::Child;
use std::time::{Duration, Instant};

/// What is done to a run.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    /// SIGKILL of the driver.
    KillDriver,
    /// SIGKILL of the solver.
    KillSolver,
    /// SIGTERM, on which the driver saves and ends.
    TerminateDriver,
    /// Ctrl-C twice.
    InterruptTwice,
    /// The solver gets a floating point exception.
    CrashSolver,
    /// The solver stops answering.
    HangSolver,
}

const FAULTS: [Fault; 8] = [
    Fault::KillDriver,
    Fault::KillSolver,
    Fault::TerminateDriver,
    Fault::KillSolver,
    Fault::KillDriver,
    Fault::CrashSolver,
    Fault::InterruptTwice,
    Fault::HangSolver,
];

/// What can happen to a driver that computes the blood itself.
const OWN_FAULTS: [Fault; 3] = [
    Fault::KillDriver,
    Fault::TerminateDriver,
    Fault::InterruptTwice,
];

/// Repeatable numbers in 0..1 (Lehmer's generator).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0 * 48271 % 0x7fff_ffff;
        self.0 as f64 / f64::from(0x7fff_ffff)
    }
}

/// Whether a process has a handler for a signal.
fn catches(process: i32, signal: Signal) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let mut lines = status.lines();
    let caught = lines.find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
    let caught = u64::from_str_radix(caught.trim(), 16).unwrap();
    caught >> (signal.as_raw() - 1) & 1 == 1
}

/// Strikes; returns whether the driver survives it.
fn strike(fault: Fault, child: &mut Child, out: &Path) -> bool {
    let driver = child.id() as i32;
    let solver = |kind| processes_in(out).into_iter().for_each(|p| signal(p, kind));
    match fault {
        Fault::KillDriver => signal(driver, Signal::KILL),
        Fault::TerminateDriver => signal(driver, Signal::TERM),
        Fault::InterruptTwice => {
            // What a shell starts in the background ignores Ctrl-C until it listens.
            eventually("the driver listens", Duration::from_secs(10), || {
                catches(driver, Signal::INT)
            });
            signal(driver, Signal::INT);
            signal(driver, Signal::INT);
        }
        Fault::KillSolver => solver(Signal::KILL),
        Fault::CrashSolver => solver(Signal::FPE),
        Fault::HangSolver => solver(Signal::STOP),
    }
    matches!(
        fault,
        Fault::KillSolver | Fault::CrashSolver | Fault::HangSolver
    )
}

/// A run with `settings` is struck by `faults` in turn; `more` holds for the run that is struck alone.
fn campaign(
    faults: &[Fault],
    [kills, steps]: [usize; 2],
    seed: u64,
    settings: &[&str],
    more: &[&str],
) {
    let folder = tempfile::tempdir().unwrap();
    let (straight, out) = (folder.path().join("straight"), folder.path().join("run"));
    let clock = Instant::now();
    complete(driver(&straight, steps, settings));
    let pace = clock.elapsed().as_secs_f64() / steps as f64;
    let mut random = Random(seed);
    let mut more = [settings, more].concat();
    more.extend(["--set", "fluid.answer_limit_s=4"]);
    let mut child = start(&mut driver(&out, steps, &more));
    // Before that there is nothing to resume.
    eventually("the run has a folder", Duration::from_secs(60), || {
        out.join("case.resolved.toml").exists()
    });
    more.push("--resume");
    let mut resumed = 0;
    for kill in 0..kills {
        let fault = faults[kill % faults.len()];
        // Mostly amid the steps, sometimes while everything is starting or before the first step.
        if kill % 5 > 0 {
            let left = steps - 2 * (kills - kill).min(steps / 2);
            let target = (steps_done(&out) + 1).min(left);
            wait_for_steps(&mut child, &out, target);
        }
        // Not so long that the run would end before its last kill.
        let share = pace * (steps - steps_done(&out)) as f64 / (kills - kill + 1) as f64;
        std::thread::sleep(Duration::from_secs_f64(share.min(0.6) * random.next()));
        let done = steps_done(&out);
        println!("{kill}: {fault:?} after {done} steps");
        if child.try_wait().unwrap().is_some() {
            // The kill before struck a solver that was just starting.
            assert!(done < steps, "the run has ended before kill {kill}");
            child = start(&mut driver(&out, steps, &more));
            resumed += 1;
        }
        if strike(fault, &mut child, &out) {
            continue;
        }
        let status = child.wait().unwrap();
        assert!(!status.success(), "{status}");
        eventually("the solver has gone", Duration::from_secs(10), || {
            processes_in(&out).is_empty()
        });
        // A checkpoint after each step: at most the step is lost whose checkpoint was being written.
        let saved = newest_checkpoint(&out).unwrap_or(0);
        assert!(
            saved + 1 >= done,
            "{done} steps were done, {saved} are saved"
        );
        child = start(&mut driver(&out, steps, &more));
        resumed += 1;
    }
    let status = child.wait().unwrap();
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    assert!(status.success(), "{summary}");
    assert!(processes_in(&out).is_empty());
    println!("resumed {resumed} times\n{summary}");
    let (x, y) = (out.join("history.csv"), straight.join("history.csv"));
    assert_eq!(rows(&x), rows(&y));
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn ten_kills_change_nothing() {
    campaign(&FAULTS, [10, 40], 20_171_027, &[], &[]);
}

#[test]
fn kills_of_a_driver_with_the_native_fluid_change_nothing() {
    campaign(
        &OWN_FAULTS,
        [6, 24],
        20_261_122,
        &crate::native_run::FEW,
        &[],
    );
}

#[test]
#[ignore = "about ten minutes"]
fn a_hundred_kills_change_nothing() {
    campaign(&FAULTS, [104, 400], 1, &[], &[]);
}
