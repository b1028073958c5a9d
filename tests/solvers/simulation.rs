//! A simulation with a user-supplied fluid: that of the example, which keeps its state in memory.

#[path = "../../examples/own_fluid/main.rs"]
#[allow(dead_code)] // its `main`
mod example;

use example::{Row, Rows, elastic_tube};
use fsi_driver::Vec3;
use fsi_driver::case::Case;
use fsi_driver::fluid::{
    Fluid, FluidEffort, FluidError, FluidInterface, FluidMemory, FluidStep, FluidTrial, Wanted,
};
use fsi_driver::pfem::{Solid, Structure};
use fsi_driver::simulation::Simulation;
use fsi_driver::simulation::assembly::{Domain, couple};
use fsi_driver::simulation::checkpoint::{Found, Store};
use std::error::Error;
use std::path::Path;

type Blood = example::fluid::OneDimensionalFluid;

/// What happens to a fluid in its `call`-th solution, from 1, and again in the one after that.
#[derive(Clone, Copy)]
enum Accident {
    Nothing,
    Died {
        call: usize,
    },
    NotSolved {
        call: usize,
    },
    /// From this call on its equations are not solved, unless it may spend more sweeps than usual.
    Unfinished {
        call: usize,
    },
    /// The reports of these steps, counted as often as they are repeated, have ten times the inflow.
    Leaks {
        from: usize,
        to: usize,
    },
}

/// A fluid with an accident.
struct Unlucky {
    fluid: Blood,
    accident: Accident,
    calls: usize,
    dead: bool,
    recalls: usize,
    forgotten: usize,
    accepted: usize,
    usual_sweeps: u32,
}

impl Fluid for Unlucky {
    fn interface(&self) -> &FluidInterface {
        self.fluid.interface()
    }

    fn solve(&mut self, d: &[Vec3], dt: f64, e: FluidEffort) -> Result<FluidTrial, FluidError> {
        self.calls += 1;
        self.forgotten += usize::from(e.from_old_state);
        match self.accident {
            Accident::Died { call } if call == self.calls => self.dead = true,
            Accident::NotSolved { call } if (call..call + 2).contains(&self.calls) => {
                return Err(FluidError::NotSolved("it does not converge".into()));
            }
            _ => {}
        }
        if self.dead {
            return Err(FluidError::Died("it is dead; ".into()));
        }
        let mut trial = self.fluid.solve(d, dt, e)?;
        if let Accident::Unfinished { call } = self.accident
            && self.calls >= call
            && e.max_sweeps <= self.usual_sweeps
        {
            trial.cost.residual = 0.5;
        }
        Ok(trial)
    }

    fn accept(&mut self, wanted: Wanted) -> Result<FluidStep, FluidError> {
        let mut step = self.fluid.accept(wanted)?;
        self.accepted += 1;
        if let Accident::Leaks { from, to } = self.accident
            && (from..=to).contains(&self.accepted)
        {
            step.openings[0].flow *= 10.0;
        }
        Ok(step)
    }

    fn memory(&mut self, needed: &dyn Fn(f64) -> bool) -> Result<FluidMemory, FluidError> {
        self.fluid.memory(needed)
    }

    fn recall(&mut self, memory: &FluidMemory) -> Result<(), FluidError> {
        self.recalls += 1;
        self.dead = false;
        self.fluid.recall(memory)
    }
}

type Run = Simulation<Unlucky, Structure, Rows>;

fn run(case: &Case, folder: &Path, accident: Accident) -> Run {
    try_to_run(case, folder, accident).unwrap()
}

fn try_to_run(case: &Case, folder: &Path, accident: Accident) -> Result<Run, Box<dyn Error>> {
    let fluid = Unlucky {
        fluid: Blood::new(case),
        accident,
        calls: 0,
        dead: false,
        recalls: 0,
        forgotten: 0,
        accepted: 0,
        usual_sweeps: case.fluid.max_correctors,
    };
    let coupling = couple(case, &Domain::new(case).unwrap(), fluid).unwrap();
    example::run(case, coupling, folder)
}

/// 0.1 ms per step.
fn rows(end: &str, folder: &Path) -> Vec<Row> {
    let simulation = run(&elastic_tube(end).unwrap(), folder, Accident::Nothing);
    assert!(simulation.observer.notes.is_empty());
    simulation.observer.rows
}

#[test]
fn blood_of_ones_own_is_coupled_and_resumes_to_the_last_digit() {
    let folder = tempfile::tempdir().unwrap();
    let [straight, parts] = ["straight", "parts"].map(|name| folder.path().join(name));
    let rows_at_once = rows("0.0012", &straight);
    assert_eq!(rows_at_once.len(), 12);
    assert_eq!(rows("0.0005", &parts), rows_at_once[..5]);
    assert_eq!(rows("0.0012", &parts), rows_at_once);

    // What comes in and does not go out widens the tube.
    for pair in rows_at_once.windows(2) {
        let [before, now] = [&pair[0], &pair[1]];
        let rate = (now.volume - before.volume) / 1e-4;
        assert!((now.inflow - now.outflow - rate).abs() < 1e-12, "{now:?}");
    }
    let last = rows_at_once[11];
    println!("{last:?}");
    assert!(last.displacement > 1e-6 && last.inlet_pressure > 10.0);
}

/// A fluid that has died is recalled and one that finds nothing is asked with more care.
#[test]
fn dead_fluids_are_recalled_failed_ones_repeated() {
    let case = elastic_tube("0.0008").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, accident| run(&case, &folder.path().join(name), accident);
    let straight = run("straight", Accident::Nothing);
    let call = straight.coupling.fluid.calls / 2;

    let died = run("died", Accident::Died { call });
    assert_eq!(died.observer.rows, straight.observer.rows);
    let (fluid, totals) = (&died.coupling.fluid, died.totals());
    assert_eq!((fluid.recalls, fluid.forgotten), (1, 0));
    assert_eq!((totals.fluid_restarts, totals.failed_attempts), (1, 1));
    let note = &died.observer.notes[0];
    assert!(note.contains("continues from"), "{note}");

    // Twice: the third attempt, from the last displacement, succeeds.
    let unsolved = run("unsolved", Accident::NotSolved { call });
    let (fluid, totals) = (&unsolved.coupling.fluid, unsolved.totals());
    assert_eq!((fluid.recalls, fluid.forgotten), (0, 2));
    assert_eq!((totals.fluid_restarts, totals.failed_attempts), (0, 2));
    let note = &unsolved.observer.notes[1];
    assert!(note.contains("tried again more carefully"), "{note}");
    let pairs = unsolved.observer.rows.iter().zip(&straight.observer.rows);
    for (a, b) in pairs {
        assert!(
            (a.displacement / b.displacement - 1.0).abs() < 1e-4,
            "{a:?} {b:?}"
        );
    }
}

/// Equations that are not solved get more sweeps and mass that is lost another attempt.
#[test]
fn unsolved_equations_get_more_sweeps() {
    let case = elastic_tube("0.0008").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, accident| run(&case, &folder.path().join(name), accident);
    let straight = run("straight", Accident::Nothing);
    let totals = straight.totals();
    assert!(totals.max_mass_lost < 1e-9, "{:e}", totals.max_mass_lost);
    assert_eq!((totals.unfinished_steps, totals.failed_attempts), (0, 0));
    let alike = |other: &Run| {
        assert_eq!(other.observer.rows.len(), 8);
        for (a, b) in other.observer.rows.iter().zip(&straight.observer.rows) {
            assert!(
                (a.displacement / b.displacement - 1.0).abs() < 1e-4,
                "{a:?} {b:?}"
            );
        }
    };

    // In each step from the one on that holds this call.
    let call = straight.coupling.fluid.calls / 2;
    let unfinished = run("unfinished", Accident::Unfinished { call });
    let (fluid, totals) = (&unfinished.coupling.fluid, unfinished.totals());
    assert_eq!((fluid.recalls, totals.unfinished_steps), (0, 0));
    // Measured: 6.
    assert!(
        (4..=8).contains(&totals.failed_attempts),
        "{}",
        totals.failed_attempts
    );
    let note = &unfinished.observer.notes[0];
    for words in [
        "began with a residual of 0.500",
        "tried again more carefully",
    ] {
        assert!(note.contains(words), "{note}");
    }
    alike(&unfinished);

    let leaks = run("leaks", Accident::Leaks { from: 4, to: 5 });
    let (fluid, totals) = (&leaks.coupling.fluid, leaks.totals());
    assert_eq!(
        (fluid.recalls, totals.fluid_restarts, totals.failed_attempts),
        (2, 0, 2)
    );
    assert!(totals.max_mass_lost < 1e-9, "{:e}", totals.max_mass_lost);
    let note = &leaks.observer.notes[1];
    for words in [
        "the fluid loses mass",
        "goes back to",
        "tries the step again more carefully",
    ] {
        assert!(note.contains(words), "{note}");
    }
    alike(&leaks);
}

/// A fluid that always loses mass ends the run and leaves the step before.
#[test]
fn a_fluid_that_loses_mass_ends_the_run() {
    let case = elastic_tube("0.0008").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let always = Accident::Leaks {
        from: 4,
        to: usize::MAX,
    };
    let error = try_to_run(&case, folder.path(), always)
        .map(|_| ())
        .unwrap_err()
        .to_string();
    // In the shortest of the shorter steps the wall fails before the fluid is judged.
    for words in ["step 4 (t = 0.0003", "All 5 attempts at this step failed"] {
        assert!(error.contains(words), "{error}");
    }
    let newest: Found<<Structure as Solid>::Memory, Rows> =
        Store::new(folder.path()).newest().unwrap();
    assert_eq!(newest.checkpoint.step(), 3);
    assert!(newest.checkpoint.totals.max_mass_lost < 1e-9);
}
