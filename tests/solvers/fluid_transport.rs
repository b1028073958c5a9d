//! The same run over a socket, over files, on two ranks, and continued from a written time.

use crate::fluid_support::*;
use fsi_driver::case::TransportKind;
use fsi_driver::fluid::openfoam::OpenFoam;
use fsi_driver::fluid::{Fluid, FluidError, FluidMemory, FluidStep};
use rustix::process::{Pid, Signal, kill_process};

const STEPS: usize = 4;

/// Runs steps `from + 1 ..= to` and returns the reports; the fields of `to` are written.
fn run(channel: &Channel, from: usize, to: usize) -> Vec<FluidStep> {
    let mut fluid = channel.start();
    let interface = fluid.interface().clone();
    (from + 1..=to)
        .map(|n| {
            let right = prescribed(&interface, n);
            let first: Vec<_> = right.iter().map(|u| u * 0.9).collect();
            fluid.solve(&first, STEP, correctors(2)).unwrap();
            fluid.solve(&right, STEP, correctors(6)).unwrap();
            fluid.accept(keep(n == to)).unwrap().without_costs()
        })
        .collect()
}

fn numbers(step: &FluidStep) -> Vec<f64> {
    vec![
        step.inflow(),
        step.outflow(),
        step.inlet_pressure(),
        step.outlet_pressure(),
        step.outlet_model_pressure(),
        step.volume,
    ]
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn files_and_socket_carry_the_same_run() {
    let mut channel = Channel::new(false);
    let by_socket = run(&channel, 0, STEPS);
    channel.settings.transport = TransportKind::Files;
    let by_files = run(&channel, 0, STEPS);
    assert_eq!(by_socket, by_files);
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn two_ranks_agree_with_one() {
    let mut channel = Channel::new(true);
    let serial_interface = channel.start().interface().clone();
    let serial = run(&channel, 0, STEPS);
    channel.settings.ranks = 2;
    assert_eq!(channel.start().interface(), &serial_interface);
    let parallel = run(&channel, 0, STEPS);
    for (a, b) in parallel.iter().zip(&serial) {
        let shear = difference(&flat(&a.wall_shear), &flat(&b.wall_shear));
        println!("wall shear {shear:e}");
        assert!(shear < 1e-6, "wall shear differs by {shear:e}");
        for (x, y) in numbers(a).iter().zip(numbers(b)) {
            assert!((x - y).abs() <= 1e-6 * y.abs().max(1e-6), "{x} {y}");
        }
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_run_continues_to_the_bit_from_a_written_time() {
    let straight = run(&Channel::refined(false, 2), 0, 2 * STEPS);
    let mut channel = Channel::refined(false, 2);
    run(&channel, 0, STEPS);
    channel.settings.terms.start_time = STEPS as f64 * STEP;
    let continued = run(&channel, STEPS, 2 * STEPS);
    for (a, b) in continued.iter().zip(&straight[STEPS..]) {
        let (x, y) = (flat(&a.wall_shear), flat(&b.wall_shear));
        println!("t = {} {:e}", a.time, difference(&x, &y));
    }
    assert_eq!(continued, straight[STEPS..]);
}

/// It does so whether it died or went on meanwhile.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_solver_recalls_its_state_to_the_bit() {
    let channel = Channel::new(false);
    let mut fluid = channel.start();
    let interface = fluid.interface().clone();
    let step = |fluid: &mut OpenFoam, n: usize, write| {
        let right = prescribed(&interface, n + 1);
        fluid.solve(&right, STEP, correctors(4)).unwrap();
        fluid.accept(keep(write)).unwrap().without_costs()
    };
    assert!(
        fluid.memory(&|_| true).unwrap().files.is_empty(),
        "what it began with"
    );
    step(&mut fluid, 0, false);
    // A step that has not been written is no state to go back to.
    let error = fluid.memory(&|_| true).unwrap_err();
    assert!(matches!(error, FluidError::Storage(_)), "{error}");
    step(&mut fluid, 1, true);
    let memory = fluid.memory(&|_| true).unwrap();
    assert!(memory.files.iter().any(|file| file.ends_with("0.004/U")));
    let straight = [2, 3].map(|n| step(&mut fluid, n, false));
    for death in [false, true] {
        let before = fluid.process_id();
        if death {
            fluid
                .solve(&prescribed(&interface, 9), STEP, correctors(1))
                .unwrap();
            kill_process(Pid::from_raw(before as i32).unwrap(), Signal::KILL).unwrap();
            let error = fluid.solve(&prescribed(&interface, 9), STEP, correctors(1));
            assert!(matches!(error, Err(FluidError::Died(_))));
        }
        fluid.recall(&memory).unwrap();
        assert_ne!(fluid.process_id(), before);
        let again = fluid.process_id();
        fluid.recall(&memory).unwrap();
        assert_eq!(fluid.process_id(), again, "it is there already");
        assert_eq!([2, 3].map(|n| step(&mut fluid, n, false)), straight);
    }
    let foreign = FluidMemory {
        state: vec![1],
        files: Vec::new(),
    };
    assert!(matches!(fluid.recall(&foreign), Err(FluidError::Died(_))));
    // Another one resumes from it in a new process.
    drop(fluid);
    let mut fluid = OpenFoam::resume(channel.settings.clone(), &memory).unwrap();
    assert_eq!([2, 3].map(|n| step(&mut fluid, n, false)), straight);
}
