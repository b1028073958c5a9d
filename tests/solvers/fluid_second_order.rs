//! The real OpenFOAM with a scheme of second order in time, which remembers two steps and their lengths.

use crate::fluid_support::*;
use fsi_driver::Vec3;
use fsi_driver::fluid::Fluid;

/// A step that is tried at full length first and then taken at half of it leaves the same memory as one that is half as
/// long from the beginning.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_step_that_is_halved_after_a_trial_counts_as_a_short_one_in_the_next() {
    let run = |trial_first: bool| {
        let channel = Channel::new(true);
        let schemes = channel.case().join("system/fvSchemes");
        let text = std::fs::read_to_string(&schemes).unwrap();
        assert!(text.contains("Euler;"));
        std::fs::write(&schemes, text.replace("Euler;", "backward;")).unwrap();
        let mut fluid = channel.start();
        let interface = fluid.interface().clone();
        let half = 0.5 * STEP;
        for (n, length) in [STEP, STEP, half, half, STEP].into_iter().enumerate() {
            let right = prescribed(&interface, n + 1);
            if n == 2 && trial_first {
                let wild: Vec<Vec3> = right.iter().map(|u| u * 2.0).collect();
                fluid.solve(&wild, STEP, correctors(2)).unwrap();
                fluid.forget_trial();
            }
            fluid.solve(&right, length, correctors(5)).unwrap();
            fluid.accept(n == 4).unwrap();
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
