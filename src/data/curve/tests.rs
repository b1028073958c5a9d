//! Curves with known frames.

use super::*;
use std::f64::consts::{FRAC_PI_2, TAU};

fn is_frame(frame: &Frame) {
    let Frame {
        tangent,
        first,
        second,
        ..
    } = frame;
    for (a, b, value) in [
        (tangent, tangent, 1.0),
        (first, first, 1.0),
        (second, second, 1.0),
        (tangent, first, 0.0),
        (first, second, 0.0),
    ] {
        assert!((a.dot(b) - value).abs() < 1e-13, "{frame:?}");
    }
    assert!((tangent.cross(first) - second).norm() < 1e-13);
}

#[test]
fn an_arc_ends_where_geometry_says_and_its_frame_turns_with_it() {
    let bend = Bend {
        curvature: 50.0,
        torsion: 0.0,
        towards: 0.0,
    };
    let curve = SpaceCurve::of_pieces(
        Frame::along_x(),
        &[(0.01, Bend::default()), (FRAC_PI_2 / 50.0, bend)],
    );
    let end = curve.frame(curve.ends()[1]);
    assert!((end.origin - Vec3::new(0.03, 0.02, 0.0)).norm() < 1e-15);
    assert!((end.tangent - Vec3::y()).norm() < 1e-14);
    assert!((end.first + Vec3::x()).norm() < 1e-14);
    assert!((curve.curvature(0.02).norm() - 50.0).abs() < 1e-11);
    is_frame(&end);
}

#[test]
fn a_spline_through_a_helix_has_its_length_and_frames() {
    let bend = Bend::helix(6e-3, 0.02, 0.3);
    let length = TAU * 6e-3_f64.hypot(0.02 / TAU);
    let helix = SpaceCurve::of_pieces(Frame::along_x(), &[(length, bend)]);
    let spline = |n: usize| {
        let points: Vec<Vec3> = (0..=n)
            .map(|i| helix.frame(length * i as f64 / n as f64).origin)
            .collect();
        SpaceCurve::through(&points, Vec3::y())
    };
    // In the middle: a natural spline knows nothing of the curvature at its ends.
    let error = |n: usize| {
        let curve = spline(n);
        let shift = 0.5 * (curve.ends()[1] - length);
        // Between two points.
        let s = length * (0.5 + 0.5 / n as f64);
        let [a, b] = [curve.frame(s + shift), helix.frame(s)];
        is_frame(&a);
        ((a.origin - b.origin).norm(), (a.first - b.first).norm())
    };
    let ((coarse, _), (fine, turned)) = (error(40), error(160));
    assert!(
        coarse < 2e-7 && fine < 2e-9 && coarse / fine > 50.0,
        "{coarse:e} {fine:e}"
    );
    // The beginning of the spline is not quite that of the helix, and so is its first frame: first order.
    assert!(turned < 2e-2, "{turned:e}");
}

#[test]
fn points_near_a_curve_are_found_again() {
    let points: Vec<Vec3> = (0..20)
        .map(|i| 5e-3 * i as f64)
        .map(|x| Vec3::new(x, 0.01 * (60.0 * x).sin(), 0.02 * (30.0 * x).cos()))
        .collect();
    let curve = SpaceCurve::through(&points, Vec3::z()).counted_from(0.02);
    let arc = Bend {
        curvature: 100.0,
        torsion: 30.0,
        towards: 1.0,
    };
    let pieces = SpaceCurve::of_pieces(Frame::along_x(), &[(0.02, arc), (0.01, Bend::default())]);
    for curve in [curve, pieces] {
        let [from, to] = curve.ends();
        for i in 0..=50 {
            let s = from + (to - from) * (1.2 * f64::from(i) / 50.0 - 0.1);
            let frame = curve.frame(s);
            is_frame(&frame);
            let found = curve.nearest(&frame.point(2e-3, -1e-3));
            assert!((found.s - s).abs() < 1e-12, "{} instead of {s}", found.s);
            assert!((found.across[0] - 2e-3).abs() + (found.across[1] + 1e-3).abs() < 1e-12);
            let ahead = curve.frame(s + 1e-7).tangent - curve.frame(s - 1e-7).tangent;
            let inside = s > from + 1e-6 && s < to - 1e-6 && (s - 0.02).abs() > 1e-6;
            assert!(!inside || (ahead / 2e-7 - curve.curvature(s)).norm() < 1e-4);
        }
    }
}

/// A straight line and a nearly straight arc are the same curve up to what the arc bends.
#[test]
fn an_arc_of_a_million_metres_is_straight() {
    let bend = Bend {
        curvature: 1e-6,
        ..Bend::default()
    };
    let arc = SpaceCurve::of_pieces(Frame::along_x(), &[(0.06, bend)]);
    for s in [0.01, 0.03, 0.06] {
        let frame = arc.frame(s);
        let bent = Vec3::new(s, 0.5e-6 * s * s, 0.0);
        assert!(
            (frame.origin - bent).norm() < 1e-16,
            "{:e}",
            (frame.origin - bent).norm()
        );
    }
}

/// Groups of pieces are skipped that cannot be nearest: as if all had been looked at.
#[test]
fn the_nearest_place_of_a_line_is_found_by_groups() {
    let points: Vec<Vec3> = (0..60)
        .map(|i| f64::from(i) * 0.4)
        .map(|t| Vec3::new(t.sin() * (3.0 + t), (1.3 * t).cos() * 4.0, 0.5 * t))
        .collect();
    let radii: Vec<f64> = (0..60).map(|i| 0.3 + 0.2 * f64::from(i % 7)).collect();
    let line = CentreLine::new(&points, &radii);
    let pieces = line.points.len() - 1;
    assert!(pieces > 1000);
    let (mut inside, mut skipped) = (0, 0);
    for i in 0..200 {
        let t = f64::from(i);
        let x = Vec3::new(
            9.0 * (2.1 * t).sin(),
            6.0 * (1.7 * t).cos(),
            12.0 * (0.9 * t).sin().abs(),
        );
        let of_piece = |k: usize| {
            let foot = line.foot_near(&x, k..k + 1);
            foot.distance - foot.radius
        };
        let least = (0..pieces).map(of_piece).fold(f64::INFINITY, f64::min);
        let foot = line.foot(&x);
        assert!((foot.distance - foot.radius - least).abs() < 1e-12);
        inside += usize::from(least < 0.0);
        assert!(least > 0.0 || line.may_surround(&x));
        skipped += usize::from(!line.may_surround(&x));
        let is_near = |k: &usize| (line.points[*k] - x).norm() < 2.0 + 2.0 * line.radii[*k];
        let all = || 0..line.points.len();
        let expected = all().find(is_near).zip(all().rfind(is_near));
        assert_eq!(line.samples_near(&x, 2.0).map(|[a, b]| (a, b)), expected);
    }
    assert!((5..195).contains(&inside), "{inside}");
    assert!(skipped > 20, "{skipped}");
    // A line of one group has no others to skip.
    let short = CentreLine::new(&[Vec3::zeros(), Vec3::x()], &[1.0; 2]);
    assert!(short.may_surround(&Vec3::y()) && !short.may_surround(&(Vec3::y() * 9.0)));
}
