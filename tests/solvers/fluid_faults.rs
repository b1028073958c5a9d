//! What goes wrong between driver and OpenFOAM: mismatch, death on either side, silence, interruption.

use crate::fluid_support::*;
use fsi_driver::case::TransportKind;
use fsi_driver::fluid::openfoam::OpenFoam;
use fsi_driver::fluid::{Fluid, FluidError, Wanted};
use rustix::process::{Pid, Signal, kill_process, test_kill_process};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

fn pid(number: u32) -> Pid {
    Pid::from_raw(number as i32).unwrap()
}

fn text_of(error: FluidError) -> String {
    error.to_string()
}

fn eventually(what: &str, limit: Duration, mut condition: impl FnMut() -> bool) {
    let since = Instant::now();
    while !condition() {
        assert!(since.elapsed() < limit, "{what}: not within {limit:?}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Processes of the solver that work in a folder; the folder is a fresh one, so they can only be ours.
fn solvers_in(case: &Path) -> usize {
    let case = case.canonicalize().unwrap();
    std::fs::read_dir("/proc")
        .unwrap()
        .filter_map(|entry| std::fs::read_link(entry.ok()?.path().join("cwd")).ok())
        .filter(|folder| *folder == case)
        .count()
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_wrong_time_step_ends_both_sides_and_says_what_differs() {
    let mut channel = Channel::new(false);
    channel.settings.terms.time_step = 0.001;
    let Err(error) = OpenFoam::start(channel.settings.clone()) else {
        panic!("must be refused")
    };
    let text = text_of(error);
    assert!(
        text.contains("time step 0.001 s here, 0.002 s there"),
        "{text}"
    );
    let log = std::fs::read_to_string(&channel.settings.log).unwrap();
    assert!(
        log.contains("the driver refuses") && log.contains("time step 0.001 s"),
        "{log}"
    );
    assert_eq!(solvers_in(channel.case()), 0);
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn another_wall_is_refused() {
    let mut channel = Channel::new(false);
    let mut expected = channel.start().interface().clone();
    expected.points[7][1] += 1e-6;
    channel.settings.terms.interface = Some(expected.clone());
    let Err(error) = OpenFoam::start(channel.settings.clone()) else {
        panic!("must be refused")
    };
    let text = text_of(error);
    assert!(text.contains("point 7 at"), "{text}");
    expected.points.pop();
    channel.settings.terms.interface = Some(expected);
    let Err(error) = OpenFoam::start(channel.settings.clone()) else {
        panic!("must be refused")
    };
    assert!(text_of(error).contains("points here"));
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_missing_mesh_is_reported_with_the_end_of_the_log() {
    let channel = Channel::new(false);
    std::fs::remove_dir_all(channel.case().join("constant/polyMesh")).unwrap();
    let since = Instant::now();
    let Err(error) = OpenFoam::start(channel.settings.clone()) else {
        panic!("must be refused")
    };
    let text = text_of(error);
    assert!(
        text.contains("log.pimpleFoam") && text.contains("polyMesh"),
        "{text}"
    );
    assert!(since.elapsed() < Duration::from_secs(5));
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn the_death_of_the_solver_is_noticed_at_once() {
    for transport in [TransportKind::Socket, TransportKind::Files] {
        let mut channel = Channel::new(false);
        channel.settings.transport = transport;
        let mut fluid = channel.start();
        let displacement = prescribed(fluid.interface(), 1);
        fluid.solve(&displacement, STEP, correctors(2)).unwrap();
        kill_process(pid(fluid.process_id()), Signal::KILL).unwrap();
        let since = Instant::now();
        let text = text_of(fluid.solve(&displacement, STEP, correctors(2)).unwrap_err());
        assert!(
            since.elapsed() < Duration::from_secs(1),
            "{:?}",
            since.elapsed()
        );
        assert!(
            text.contains("log.pimpleFoam") && text.contains("signal: 9"),
            "{text}"
        );
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn cells_turned_inside_out_are_reported_with_their_place() {
    for ranks in [1, 2] {
        let mut channel = Channel::new(false);
        channel.settings.ranks = ranks;
        let mut fluid = channel.start();
        let mut displacement = bulge(fluid.interface(), -1e-2);
        displacement.iter_mut().for_each(|u| u[2] = 0.0); // else it would be turned by half a turn
        let text = text_of(fluid.solve(&displacement, STEP, correctors(2)).unwrap_err());
        assert!(
            text.contains("cells of the fluid's mesh inside out, the worst near (0.0"),
            "{text}"
        );
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_trial_that_is_not_finite_is_refused_and_the_solver_lives() {
    let channel = Channel::new(false);
    let mut fluid = channel.start();
    let good = prescribed(fluid.interface(), 1);
    let mut wild = good.clone();
    wild[3][1] = f64::NAN;
    let error = fluid.solve(&wild, STEP, correctors(2)).unwrap_err();
    assert!(matches!(error, FluidError::NotSolved(_)), "{error}");
    assert!(error.to_string().contains("point 3"), "{error}");
    fluid.solve(&good, STEP, correctors(2)).unwrap();
    fluid.accept(Wanted::default()).unwrap();
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_silent_solver_is_given_up_after_the_answer_limit() {
    let mut channel = Channel::new(false);
    channel.settings.answer_limit = Duration::from_secs(1);
    let mut fluid = channel.start();
    let displacement = prescribed(fluid.interface(), 1);
    kill_process(pid(fluid.process_id()), Signal::STOP).unwrap();
    let text = text_of(fluid.solve(&displacement, STEP, correctors(2)).unwrap_err());
    assert!(
        text.contains("no answer from the fluid within 1 s"),
        "{text}"
    );
    let since = Instant::now();
    drop(fluid);
    assert!(
        since.elapsed() < Duration::from_secs(12),
        "a stopped process ends by SIGKILL"
    );
    assert_eq!(solvers_in(channel.case()), 0);
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_solver_that_is_told_to_stop_ends_by_itself() {
    for ranks in [1, 2] {
        let mut channel = Channel::new(false);
        channel.settings.ranks = ranks;
        for (within_a_step, last_lines) in [
            (true, "the driver stopped the run within a time step"),
            (false, "End"),
        ] {
            let mut fluid = channel.start();
            let displacement = prescribed(fluid.interface(), 1);
            fluid.solve(&displacement, STEP, correctors(2)).unwrap();
            if !within_a_step {
                fluid.accept(Wanted::default()).unwrap();
            }
            let since = Instant::now();
            drop(fluid);
            assert!(
                since.elapsed() < Duration::from_secs(3),
                "{:?}",
                since.elapsed()
            );
            let log = std::fs::read_to_string(&channel.settings.log).unwrap();
            assert!(
                log.contains(last_lines) && !log.contains("ignal"),
                "{ranks} {last_lines}: {log}"
            );
        }
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn an_interrupt_ends_the_wait_and_the_solver() {
    let channel = Channel::new(false);
    let mut fluid = channel.start();
    let displacement = prescribed(fluid.interface(), 1);
    let flag = channel.settings.interrupt.clone();
    let watch = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(300));
        flag.store(true, Ordering::Relaxed);
    });
    let since = Instant::now();
    let error = fluid
        .solve(&displacement, STEP, correctors(1000))
        .unwrap_err();
    assert!(matches!(error, FluidError::Interrupted), "{error}");
    assert!(since.elapsed() < Duration::from_secs(2));
    drop(fluid);
    assert!(since.elapsed() < Duration::from_secs(5));
    assert_eq!(solvers_in(channel.case()), 0);
    watch.join().unwrap();
}

/// Not a test of its own: the driver that [`a_killed_driver_leaves_no_solver`] starts and kills.
#[test]
#[ignore = "helper process of another test"]
fn victim() {
    let Some(case) = std::env::var_os("FLUID_VICTIM_CASE") else {
        return;
    };
    let mut channel = Channel::new(false);
    channel.settings.case = case.into();
    channel.settings.log = channel.settings.case.join("log.pimpleFoam");
    channel.settings.ranks = std::env::var("FLUID_VICTIM_RANKS")
        .unwrap()
        .parse()
        .unwrap();
    if std::env::var_os("FLUID_VICTIM_FILES").is_some() {
        channel.settings.transport = TransportKind::Files;
    }
    let mut fluid = channel.start();
    let displacement = prescribed(fluid.interface(), 1);
    fluid.solve(&displacement, STEP, correctors(2)).unwrap();
    std::fs::write(channel.settings.case.join("ready"), "").unwrap();
    std::thread::sleep(Duration::from_secs(60));
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_killed_driver_leaves_no_solver() {
    for (ranks, files) in [(1, false), (1, true), (2, false), (2, true)] {
        let channel = Channel::new(false);
        let mut command = Command::new(std::env::current_exe().unwrap());
        command
            .args(["--ignored", "--exact", "fluid_faults::victim"])
            .env("FLUID_VICTIM_CASE", channel.case())
            .env("FLUID_VICTIM_RANKS", ranks.to_string())
            .stdout(Stdio::null());
        if files {
            command.env("FLUID_VICTIM_FILES", "1");
        }
        let mut driver = command.spawn().unwrap();
        let ready = channel.case().join("ready");
        eventually("the victim runs", Duration::from_secs(60), || {
            ready.exists()
        });
        assert!(solvers_in(channel.case()) >= ranks);
        driver.kill().unwrap();
        driver.wait().unwrap();
        assert!(test_kill_process(pid(driver.id())).is_err());
        eventually("the solver has gone", Duration::from_secs(5), || {
            solvers_in(channel.case()) == 0
        });
    }
}
