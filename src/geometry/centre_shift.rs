//! How far a tube has moved sideways: the shift of the centres of its cross-sections.

use crate::Vec3;
use nalgebra::Matrix3;

/// From this share of the radius on, a shift of the centre is large.
const LARGE: f64 = 1.0 / 3.0;
/// A cross-section whose points leave a larger angle free (degrees) does not go round.
const GAP: f64 = 75.0;

/// The cross-section of a tube whose centre has moved farthest aside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CentreShift {
    /// Centre of the cross-section in the reference configuration, m.
    pub centre: Vec3,
    /// How far the centre has moved across the tube's axis, m.
    pub shift: f64,
    /// Mean radius of the cross-section in the reference configuration, m.
    pub radius: f64,
    /// Largest displacement of any point of the tube, m.
    pub largest_displacement: f64,
}

impl CentreShift {
    /// Looks at a surface with these `points` (m) that have moved by `displacement` (m), in slices about one radius
    /// long across its long axis. `None` if most of its slices do not go round, as those of a tube do.
    pub fn of(points: &[Vec3], displacement: &[Vec3]) -> Option<Self> {
        let count = points.len() as f64;
        let middle = points.iter().sum::<Vec3>() / count;
        let spread: Matrix3<f64> = points
            .iter()
            .map(|x| (x - middle) * (x - middle).transpose())
            .sum();
        let spread = spread.symmetric_eigen();
        let axis: Vec3 = spread
            .eigenvectors
            .column(spread.eigenvalues.imax())
            .into_owned();
        let across = |v: &Vec3| v - axis * v.dot(&axis);

        let along: Vec<f64> = points.iter().map(|x| (x - middle).dot(&axis)).collect();
        let start = along.iter().copied().fold(f64::INFINITY, f64::min);
        let end = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let distances = points.iter().map(|x| across(&(x - middle)).norm());
        let thickness = distances.sum::<f64>() / count;
        let slices = ((end - start) / thickness).floor().max(1.0);
        let mut members = vec![Vec::new(); slices as usize];
        for (i, s) in along.iter().enumerate() {
            let slice = (s - start) / (end - start) * slices;
            members[(slice as usize).min(slices as usize - 1)].push(i);
        }

        let largest = displacement.iter().map(Vec3::norm).fold(0.0, f64::max);
        let slice = |members: &Vec<usize>| {
            let mean = |values: &[Vec3]| {
                members.iter().map(|&i| values[i]).sum::<Vec3>() / members.len() as f64
            };
            let centre = mean(points);
            let arms: Vec<Vec3> = members
                .iter()
                .map(|&i| across(&(points[i] - centre)))
                .collect();
            goes_round(&arms, &axis).then(|| Self {
                centre,
                shift: across(&mean(displacement)).norm(),
                radius: arms.iter().map(Vec3::norm).sum::<f64>() / arms.len() as f64,
                largest_displacement: largest,
            })
        };
        let round: Vec<Self> = members.iter().filter_map(slice).collect();
        // The end of a flag goes round, too.
        let is_tube = 2 * round.len() > members.len();
        let all = round.into_iter().filter(|_| is_tube);
        all.max_by(|a, b| a.shift.total_cmp(&b.shift))
    }

    /// Whether the tube has buckled sideways, as far as that can be seen: it has moved sideways by a good part of its
    /// radius, and that is most of its motion.
    pub fn is_large(&self) -> bool {
        self.shift > LARGE * self.radius && self.shift > 0.5 * self.largest_displacement
    }
}

/// Whether vectors across an axis point to all sides.
fn goes_round(arms: &[Vec3], axis: &Vec3) -> bool {
    let Some(first) = arms.iter().find(|arm| arm.norm() > 0.0) else {
        return false;
    };
    let east = first.normalize();
    let north = axis.cross(&east);
    let angle = |arm: &Vec3| arm.dot(&north).atan2(arm.dot(&east)).to_degrees();
    let mut angles: Vec<f64> = arms.iter().map(angle).collect();
    angles.sort_by(f64::total_cmp);
    let last = angles[0] + 360.0 - angles[angles.len() - 1];
    let gaps = angles.windows(2).map(|pair| pair[1] - pair[0]);
    gaps.fold(last, f64::max) < GAP
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// Points of a tube of radius 2 mm and length 60 mm along a slanting line.
    fn tube() -> Vec<Vec3> {
        let point = |ring: usize, k: usize| {
            let (x, phi) = (0.06 * ring as f64 / 40.0, TAU * k as f64 / 16.0);
            turned(Vec3::new(x, 2e-3 * phi.cos(), 2e-3 * phi.sin()))
        };
        (0..=40)
            .flat_map(|ring| (0..16).map(move |k| point(ring, k)))
            .collect()
    }

    fn turned(v: Vec3) -> Vec3 {
        nalgebra::Rotation3::from_euler_angles(0.3, -0.4, 0.5) * v
    }

    fn displaced(motion: impl Fn(f64, f64) -> Vec3) -> Vec<Vec3> {
        let motion = &motion;
        let at = |ring: usize| {
            (0..16).map(move |k| turned(motion(ring as f64 / 40.0, TAU * k as f64 / 16.0)))
        };
        (0..=40).flat_map(at).collect()
    }

    #[test]
    fn a_bent_tube_has_moved_sideways_where_it_has_moved_most() {
        let bow = |s: f64, phi: f64| {
            let widened = 3e-4 * (PI * s).sin();
            let aside = 9e-3 * (PI * s).sin().powi(2);
            Vec3::new(1e-3 * s, widened * phi.cos() + aside, widened * phi.sin())
        };
        let found = CentreShift::of(&tube(), &displaced(bow)).unwrap();
        assert!((found.shift / 9e-3 - 1.0).abs() < 0.01, "{found:?}");
        assert!((found.radius / 2e-3 - 1.0).abs() < 0.01, "{found:?}");
        let middle = turned(Vec3::new(0.03, 0.0, 0.0));
        assert!((found.centre - middle).norm() < 1.5e-3, "{found:?}");
        assert!(found.is_large());
    }

    #[test]
    fn a_widened_lengthened_or_little_shifted_tube_has_not_buckled() {
        let widened = |_: f64, phi: f64| 1.5e-3 * Vec3::new(0.0, phi.cos(), phi.sin());
        let found = CentreShift::of(&tube(), &displaced(widened)).unwrap();
        assert!(found.shift < 1e-12 && !found.is_large(), "{found:?}");
        let lengthened = |s: f64, _: f64| Vec3::new(5e-3 * s, 0.0, 0.0);
        let found = CentreShift::of(&tube(), &displaced(lengthened)).unwrap();
        assert!(found.shift < 1e-12 && !found.is_large(), "{found:?}");
        // Of the amplified imperfection of an artery, not of its buckling.
        let little = |s: f64, phi: f64| widened(s, phi) + Vec3::new(0.0, 5e-4, 0.0);
        let found = CentreShift::of(&tube(), &displaced(little)).unwrap();
        assert!((found.shift - 5e-4).abs() < 1e-12 && !found.is_large());
    }

    #[test]
    fn a_plate_is_not_a_tube() {
        let corner = |i: usize| Vec3::new(0.35 * (i / 4) as f64 / 30.0, 0.01, 0.005);
        let signs = |i: usize| Vec3::new(1.0, [1.0, -1.0][i % 2], [1.0, -1.0][i / 2 % 2]);
        let points: Vec<Vec3> = (0..124)
            .map(|i| corner(i).component_mul(&signs(i)))
            .collect();
        let aside = vec![Vec3::new(0.0, 0.08, 0.0); points.len()];
        assert_eq!(CentreShift::of(&points, &aside), None);
        // Nor is one whose end is closed, although points lie all around the middle there.
        let end = [[0.01, 0.0], [-0.01, 0.0], [0.0, 0.005], [0.0, -0.005]];
        let closed: Vec<Vec3> = points
            .into_iter()
            .chain(end.map(|[y, z]| Vec3::new(0.35, y, z)))
            .collect();
        let aside = vec![Vec3::new(0.0, 0.08, 0.0); closed.len()];
        assert_eq!(CentreShift::of(&closed, &aside), None);
    }
}
