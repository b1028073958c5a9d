//! The same run over a socket, over files, on two ranks, and continued from a written time.

mod fluid_support;

use fluid_support::*;
use fsi_driver::case::Transport;
use fsi_driver::fluid::{Fluid, FluidStep};

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
            fluid.accept(n == to).unwrap()
        })
        .collect()
}

fn numbers(step: &FluidStep) -> Vec<f64> {
    vec![
        step.inflow,
        step.outflow,
        step.inlet_pressure,
        step.outlet_pressure,
        step.windkessel_pressure,
        step.volume,
    ]
}

#[test]
fn files_and_socket_carry_the_same_run() {
    let mut channel = Channel::new(false);
    let by_socket = run(&channel, 0, STEPS);
    channel.settings.transport = Transport::Files;
    let by_files = run(&channel, 0, STEPS);
    assert_eq!(by_socket, by_files);
}

#[test]
fn two_ranks_agree_with_one() {
    let mut channel = Channel::new(true);
    let serial_interface = channel.start().interface().clone();
    let serial = run(&channel, 0, STEPS);
    channel.settings.ranks = 2;
    assert_eq!(channel.start().interface(), &serial_interface);
    let parallel = run(&channel, 0, STEPS);
    for (a, b) in parallel.iter().zip(&serial) {
        let tractions = difference(&flat(&a.tractions), &flat(&b.tractions));
        println!("tractions {tractions:e}");
        assert!(tractions < 1e-6, "tractions differ by {tractions:e}");
        for (x, y) in numbers(a).iter().zip(numbers(b)) {
            assert!((x - y).abs() <= 1e-6 * y.abs().max(1e-6), "{x} {y}");
        }
    }
}

#[test]
fn a_run_continues_to_the_bit_from_a_written_time() {
    let straight = run(&Channel::refined(false, 2), 0, 2 * STEPS);
    let mut channel = Channel::refined(false, 2);
    run(&channel, 0, STEPS);
    channel.settings.terms.start_time = STEPS as f64 * STEP;
    let continued = run(&channel, STEPS, 2 * STEPS);
    for (a, b) in continued.iter().zip(&straight[STEPS..]) {
        let (x, y) = (flat(&a.tractions), flat(&b.tractions));
        println!("t = {} {:e}", a.time, difference(&x, &y));
    }
    assert_eq!(continued, straight[STEPS..]);
}
