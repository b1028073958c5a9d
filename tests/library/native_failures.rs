//! What the driver's own solver for the blood says when it finds no solution: what failed, and where. It lives, and
//! finds the next one.

use fsi_driver::Vec3;
use fsi_driver::case::{Case, Preset};
use fsi_driver::fluid::native::NativeFluid;
use fsi_driver::fluid::{Fluid, FluidEffort, FluidError, Wanted};

const TIME_STEP: f64 = 0.002;
const EFFORT: FluidEffort = FluidEffort {
    max_sweeps: 1,
    residual: 1.0,
    from_old_state: false,
};

fn fluid() -> NativeFluid {
    let few = [
        ("fluid.native.degree", "3"),
        ("fluid.native.core", "1"),
        ("fluid.native.axial_extension", "2"),
        ("fluid.native.axial_per_section", "2"),
    ];
    let few = few.map(|(key, value)| (key.to_owned(), value.to_owned()));
    let case = Case::load("tests/cases/S-0.0".as_ref(), Preset::Demo, &few).unwrap();
    NativeFluid::new(&case).unwrap()
}

/// A wall that is pressed inwards by a share of its radius where `pressed` says so.
fn pressed(fluid: &NativeFluid, share: f64, pressed: impl Fn(&Vec3) -> bool) -> Vec<Vec3> {
    let inwards = |x: &Vec3| match pressed(x) {
        true => Vec3::new(0.0, -share * x.y, -share * x.z),
        false => Vec3::zeros(),
    };
    fluid.interface().points.iter().map(inwards).collect()
}

fn refused(fluid: &mut NativeFluid, displacement: &[Vec3]) -> String {
    match fluid.solve(displacement, TIME_STEP, EFFORT) {
        Err(FluidError::NotSolved(text)) => text,
        other => panic!("{other:?}"),
    }
}

/// The place that a text names, m.
fn place(text: &str) -> Vec3 {
    let inner = text.split(['[', '(']).nth(1).unwrap();
    let inner = inner.split([']', ')']).next().unwrap();
    let numbers: Vec<f64> = inner.split(", ").map(|n| n.parse().unwrap()).collect();
    Vec3::from_column_slice(&numbers)
}

/// Each failure has its own sentence with a place and the next trial is solved.
#[test]
fn each_failure_names_a_place() {
    let (mut fluid, mut other) = (fluid(), fluid());
    let little = pressed(&fluid, -0.01, |x| x.x > 0.02 && x.x < 0.05);
    let expected = other.solve(&little, TIME_STEP, EFFORT).unwrap();

    // A displacement that is not a number
    let mut lost = little.clone();
    lost[7].z = f64::NAN;
    let text = refused(&mut fluid, &lost);
    assert!(
        text.contains("point 7 of the wall") && text.contains("not a finite number"),
        "{text}"
    );
    assert_eq!(place(&text), fluid.interface().points[7]);

    // The two sides of the artery change places
    let mut crushed = pressed(&fluid, 1.5, |x| x.x > 0.04);
    crushed.iter_mut().for_each(|u| u.z = 0.0);
    let text = refused(&mut fluid, &crushed);
    assert!(text.contains("inside out at"), "{text}");
    assert!(place(&text).x > 0.03, "{text}");

    let found = fluid.solve(&little, TIME_STEP, EFFORT).unwrap();
    assert_eq!(found, expected);
    assert!(fluid.accept(Wanted::default()).is_ok());
}
