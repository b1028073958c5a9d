//! The real OpenFOAM with a scheme of second order in time, which remembers two steps and their lengths.

use crate::fluid_support::*;
use fsi_driver::Vec3;
use fsi_driver::fluid::{Fluid, Wanted};

/// A step that is tried at full length first and then taken at half of it leaves the same memory as one that is half as
/// long from the beginning.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_halved_step_counts_as_a_short_one() {
    let run = |trial_first: bool| {
        let channel = Channel::new(true);
        channel.replace("system/fsiParameters", "Euler;", "backward;");
        let mut fluid = channel.start();
        let interface = fluid.interface().clone();
        let half = 0.5 * STEP;
        for (n, length) in [STEP, STEP, half, half, STEP].into_iter().enumerate() {
            let right = prescribed(&interface, n + 1);
            let mut effort = correctors(5);
            if n == 2 && trial_first {
                let wild: Vec<Vec3> = right.iter().map(|u| u * 2.0).collect();
                fluid.solve(&wild, STEP, correctors(2)).unwrap();
                effort.from_old_state = true;
            }
            fluid.solve(&right, length, effort).unwrap();
            fluid.accept(keep(n == 4)).unwrap();
        }
        drop(fluid);
        let written = channel.case().join("0.008");
        ["p", "U", "phi"].map(|name| read_internal_field(&written.join(name)))
    };
    for (a, b) in run(true).iter().zip(&run(false)) {
        assert!(b.len() > 100);
        println!("{} numbers, difference {:e}", b.len(), difference(a, b));
        assert!(difference(a, b) < 1e-9, "{:e}", difference(a, b));
    }
}

/// Sum over the faces of the viscous traction along a wall that slides to and fro along itself as `1 - cos(2πt/T)`, at
/// t = T/8.
fn friction(step_of: usize, condition: &str) -> f64 {
    let period = 0.08;
    let channel = Channel::new(true);
    channel.replace("system/fsiParameters", "Euler;", "backward;");
    channel.replace("0/U", "fsiWallVelocity", condition);
    let mut fluid = channel.start();
    let interface = fluid.interface().clone();
    let step = STEP / step_of as f64;
    let mut found = 0.0;
    for n in 1..=5 * step_of {
        let along = 1e-4 * (1.0 - (std::f64::consts::TAU * n as f64 * step / period).cos());
        // Nothing but the wall itself moves, and that along its plane
        let wall: Vec<Vec3> = (interface.points.iter())
            .map(|x| match (x[0] - 0.01).min(0.02 - x[0]) > 1e-6 {
                true => Vec3::new(along, 0.0, 0.0),
                false => Vec3::zeros(),
            })
            .collect();
        fluid.solve(&wall, step, correctors(5)).unwrap();
        let step = fluid.accept(Wanted::default()).unwrap();
        found = step.wall_shear.iter().map(|t| t[0]).sum();
    }
    found
}

/// OpenFOAM's own condition takes the wall's velocity half a step late along the tangent.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_wall_that_slides_drags_the_blood_to_second_order() {
    for (condition, measured) in [("fsiWallVelocity", 3.70), ("movingWallVelocity", 1.96)] {
        let [a, b, c] = [1, 2, 4].map(|parts| friction(parts, condition));
        let ratio = (a - b) / (b - c);
        println!("{condition}: {a:e} {b:e} {c:e}, differences fall by {ratio}");
        assert!(
            (ratio / measured - 1.0).abs() < 0.05,
            "{condition}: {ratio}"
        );
    }
}
