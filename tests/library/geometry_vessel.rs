//! The vessel's formulas: bicubic spline, cosine blend, centre-lines.

use approx::assert_relative_eq;
use fsi_driver::Vec3;
use fsi_driver::case::{BloodVessel, Case, Preset};
use fsi_driver::geometry::{Imperfection, Surfaces, Vessel};
use fsi_driver::interpolation::BicubicSurface;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};
use std::path::Path;

fn load(model: &str) -> BloodVessel {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("openfoam-case")
        .join(model);
    let case = Case::load(&folder, Preset::Coarse, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    case.vessel().unwrap().clone()
}

proptest! {
    #[test]
    fn a_surface_interpolates_and_repeats_itself(values in prop::collection::vec(prop::collection::vec(-1.0..1.0f64, 5), 7)) {
        let surface = BicubicSurface::new(&values);
        let (largest, ..) = surface.maximum();
        let (smallest, ..) = surface.minimum();
        for (i, row) in values.iter().enumerate() {
            for (j, &value) in row.iter().enumerate() {
                let (u, v) = (i as f64 / 6.0, j as f64 / 5.0);
                prop_assert!((surface.value(u, v) - value).abs() < 1e-12);
                prop_assert!((surface.value(u, v + 1.0) - value).abs() < 1e-12);
                prop_assert!(value <= largest && value >= smallest);
            }
        }
    }

    #[test]
    fn the_extremes_of_a_surface_are_extremes(
        values in prop::collection::vec(prop::collection::vec(0.0..1.0f64, 5), 7),
        u in 0.0..1.0f64,
        v in 0.0..1.0f64,
    ) {
        let surface = BicubicSurface::new(&values);
        let ((largest, ..), (smallest, ..)) = (surface.maximum(), surface.minimum());
        prop_assert!(surface.value(u, v) <= largest + 1e-12);
        prop_assert!(surface.value(u, v) >= smallest - 1e-12);
    }
}

/// They are twice continuously differentiable.
#[test]
fn surfaces_are_smooth_and_flat_at_their_ends() {
    let values: Vec<Vec<f64>> = (0..7)
        .map(|i| {
            (0..5)
                .map(|j| f64::from((7 * i + 3 * j * j) % 11))
                .collect()
        })
        .collect();
    let surface = BicubicSurface::new(&values);
    let h = 1e-4;
    let second = |f: &dyn Fn(f64) -> f64, at: f64| (f(at + h) - 2.0 * f(at) + f(at - h)) / (h * h);
    for knot in [1.0 / 6.0, 0.5] {
        let along = |u| surface.value(u, 0.33);
        assert_relative_eq!(
            second(&along, knot - 2.0 * h),
            second(&along, knot + 2.0 * h),
            max_relative = 1e-2
        );
    }
    let around = |v| surface.value(0.4, v);
    assert_relative_eq!(
        second(&around, -2.0 * h),
        second(&around, 2.0 * h),
        max_relative = 1e-2
    );
    for v in [0.0, 0.123, 0.77] {
        // Flat: the difference over h shrinks with h.
        assert!((surface.value(1e-6, v) - surface.value(0.0, v)).abs() < 1e-6 * 0.1);
        assert!((surface.value(1.0 - 1e-6, v) - surface.value(1.0, v)).abs() < 1e-6 * 0.1);
    }
}

#[test]
fn the_imperfection_is_at_most_d_max_and_zero_at_the_ends() {
    for (model, d_max) in [
        ("S-0.0", 0.0),
        ("S-0.25", 0.25e-3),
        ("H-0.5", 0.5e-3),
        ("A-0.75", 0.75e-3),
    ] {
        let case = load(model);
        let vessel = Vessel::new(&case);
        let depth = |x: f64, phi: f64| vessel.imperfection().unwrap().depth(x, phi);
        let mut largest = 0.0f64;
        for i in 0..=600 {
            for j in 0..360 {
                let d = depth(
                    0.03 + 0.03 * f64::from(i) / 600.0,
                    f64::from(j).to_radians(),
                );
                assert!(d >= -1e-12, "{model}: d = {d:e}");
                largest = largest.max(d);
            }
        }
        assert!(largest <= d_max * (1.0 + 1e-12), "{model}: {largest:e}");
        assert!(largest >= 0.999 * d_max, "{model}: {largest:e}");
        for phi in [0.0, 1.0, 4.0] {
            assert_eq!(
                (depth(0.03, phi), depth(0.06, phi), depth(0.02, phi)),
                (0.0, 0.0, 0.0)
            );
            assert_relative_eq!(
                depth(0.04, phi),
                depth(0.04, phi + TAU),
                max_relative = 1e-12
            );
        }
    }
}

/// What the surface was chosen by: the narrowest place lies well inside the evaluated part, which ends at 33.75 and
/// 56.25 mm.
#[test]
fn the_imperfection_is_deepest_within_the_evaluated_part() {
    let vessel = Vessel::new(&load("S-0.5"));
    let deepest = |x: f64| {
        let around = (0..720).map(|i| (0.5 * f64::from(i)).to_radians());
        let depths = around.map(|phi| vessel.imperfection().unwrap().depth(x, phi));
        depths.fold(0.0, f64::max) / 0.5e-3
    };
    let along: Vec<(f64, f64)> = (0..=600)
        .map(|i| 0.03 + 5e-5 * f64::from(i))
        .map(|x| (x, deepest(x)))
        .collect();
    let (at, largest) = (along.iter().copied())
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap();
    println!(
        "{largest} at {at}; {} and {}",
        deepest(0.035),
        deepest(0.055)
    );
    assert!((0.04..0.05).contains(&at) && largest > 0.999, "{at}");
    for edge in [0.035, 0.055] {
        assert!(deepest(edge) < 0.65, "{}", deepest(edge));
    }
}

#[test]
fn the_scaled_surface_is_the_same_surface() {
    let (small, large) = (Vessel::new(&load("S-0.25")), Vessel::new(&load("S-0.75")));
    for (x, phi) in [(0.035, 0.2), (0.045, 2.0), (0.055, 5.0)] {
        let [a, b] = [&small, &large].map(|vessel| vessel.imperfection().unwrap().depth(x, phi));
        assert_relative_eq!(3.0 * a, b, max_relative = 1e-12);
    }
}

#[test]
fn support_values_that_are_all_zero_give_a_regular_vessel() {
    let nothing = Imperfection::new(&vec![vec![0.0; 5]; 7], [0.0, 0.01], 1e-3);
    assert_eq!(nothing.depth(0.005, 1.0), 0.0);
}

#[test]
fn the_blend_is_half_a_cosine_outside_the_evaluated_part() {
    let case = load("S-0.75");
    let vessel = Vessel::new(&case);
    // Of the outer surface, which the imperfection leaves alone: 4.5 mm in the graft, 4.3 mm in the artery.
    let blend = |x: f64| (4.5e-3 - vessel.radius(2, x, 0.4)) / 0.2e-3;
    for (x, w) in [
        (0.0, 0.0),
        (0.02625, 0.0),
        (0.03, 0.5),
        (0.03375, 1.0),
        (0.06, 1.0),
    ] {
        assert_relative_eq!(blend(x), w, epsilon = 1e-12);
    }
    assert_relative_eq!(
        blend(0.028125),
        0.5 * (1.0 - (PI / 4.0).cos()),
        epsilon = 1e-12
    );
    // Equation (17) in the artery.
    let (x, phi) = (0.04, 1.3);
    let d = vessel.imperfection().unwrap().depth(x, phi);
    assert!(d > 1e-5);
    for (surface, radius) in [(0, 3.2e-3 - d), (1, 3.75e-3 - d / 3.0), (2, 4.3e-3)] {
        assert_relative_eq!(vessel.radius(surface, x, phi), radius, max_relative = 1e-12);
    }
    for (surface, radius) in [(0, 4.0e-3), (1, 4.25e-3), (2, 4.5e-3)] {
        assert_relative_eq!(
            vessel.radius(surface, 0.01, phi),
            radius,
            max_relative = 1e-12
        );
    }
}

#[test]
fn the_surfaces_of_every_model_stay_in_order() {
    for model in ["S-0.0", "H-0.25", "A-0.5", "S-0.75"] {
        let vessel = Vessel::new(&load(model));
        for i in 0..=120 {
            for j in 0..72 {
                let (x, phi) = (0.06 * f64::from(i) / 120.0, f64::from(5 * j).to_radians());
                let [lumen, interface, outer] =
                    [0, 1, 2].map(|surface| vessel.radius(surface, x, phi));
                assert!(
                    lumen > 1.5e-3 && interface - lumen > 0.2e-3 && outer - interface > 0.2e-3,
                    "{model} {x} {phi}"
                );
            }
        }
    }
}

/// Centre lines have equal length and unit speed and end along the axis.
#[test]
fn centre_lines_have_unit_speed() {
    for model in ["S-0.0", "H-0.0", "A-0.0"] {
        let vessel = Vessel::new(&load(model));
        let line = vessel.centre_line();
        assert_eq!(line.ends(), [-0.045, 0.06]);
        let end = line.frame(0.0);
        assert_eq!(
            (end.origin, end.tangent, end.first, end.second),
            (Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z())
        );
        let (mut length, h) = (0.0, 1e-6);
        for i in 0..4500 {
            let s = -0.045 + f64::from(i) * 1e-5;
            length += (line.frame(s + 1e-5).origin - line.frame(s).origin).norm();
            let frame = line.frame(s);
            // Before its beginning the line is straight.
            let inside = s.max(-0.045 + h);
            let ahead = line.frame(inside + h).origin;
            let tangent = (ahead - line.frame(inside - h).origin) / (2.0 * h);
            assert!(
                (tangent - line.frame(inside).tangent).norm() < 1e-7,
                "{model} at {s}: tangent"
            );
            // Right-handed, orthonormal, and turning only about axes in its own plane.
            assert!(
                (frame.first.cross(&frame.second) - frame.tangent).norm() < 1e-12,
                "{model} at {s}: frame"
            );
            let turned = line.frame(inside + h).first - line.frame(inside - h).first;
            let twist = turned.dot(&line.frame(inside).second) / (2.0 * h);
            assert!(twist.abs() < 1e-6, "{model} at {s}: twist {twist:e} 1/m");
        }
        assert_relative_eq!(length, 0.045, max_relative = 1e-5);
        let (before, after) = (line.frame(-1e-9), line.frame(1e-9));
        assert!(
            (before.tangent - after.tangent).norm() < 1e-6
                && (before.first - after.first).norm() < 1e-6
        );
    }
}

#[test]
fn the_helix_makes_one_turn_and_the_arc_its_angle() {
    let start = |model: &str| Vessel::new(&load(model)).centre_line().frame(-0.045);
    // One turn: the same tangent again, displaced along the helix' axis by the pitch.
    let helix = start("H-0.0");
    assert!((helix.tangent - Vec3::x()).norm() < 1e-12);
    let pitch = (0.045f64.powi(2) - (TAU * 6e-3).powi(2)).sqrt();
    assert_relative_eq!(helix.origin.norm(), pitch, max_relative = 1e-12);
    let arc = start("A-0.0");
    assert_relative_eq!(
        arc.tangent.dot(&Vec3::x()),
        120f64.to_radians().cos(),
        max_relative = 1e-12
    );
    let radius = 0.045 / 120f64.to_radians();
    assert_relative_eq!(
        (arc.origin - Vec3::y() * radius).norm(),
        radius,
        max_relative = 1e-12
    );
}

#[test]
fn volumes_fall_almost_linearly_with_d_max() {
    let volume = |model: &str| Vessel::new(&load(model)).lumen_volume(0.03, 0.06);
    let [v0, v1, v2, v3] = ["S-0.0", "S-0.25", "S-0.5", "S-0.75"].map(volume);
    for (here, line) in [(v1, (2.0 * v0 + v3) / 3.0), (v2, (v0 + 2.0 * v3) / 3.0)] {
        assert_relative_eq!(here, line, max_relative = 0.02);
    }
    let graft = Vessel::new(&load("S-0.0")).lumen_volume(0.0, 0.02625);
    assert_relative_eq!(graft, PI * 16e-6 * 0.02625, max_relative = 1e-9);
}
