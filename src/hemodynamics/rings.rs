//! Values between the faces of a wall: from one mesh to another, or to the pixels of a map.

use super::place::Place;

/// Faces of a wall in rings around the axis, as meshes that are swept along a vessel have them.
#[derive(Debug, Clone, PartialEq)]
pub struct Rings(Vec<Ring>);

#[derive(Debug, Clone, PartialEq)]
struct Ring {
    x: f64,
    /// Angle (degrees) and index of each face, by the angle.
    faces: Vec<(f64, usize)>,
}

/// Faces of a ring are so close, relative to the length of the wall: of a straight vessel, and of bent ones.
const STRAIGHT: f64 = 1e-6;
const BENT: [f64; 3] = [1e-5, 1e-4, 1e-3];

impl Rings {
    /// Sorts the faces; `None` if they do not lie in rings. On a bent vessel the centres of a ring's faces do not lie
    /// in one cross-section exactly: what is apart by less than [`BENT`] of the wall's length counts as one ring if all
    /// rings have as many faces, or what is numbered ring by ring.
    pub fn new(places: &[Place]) -> Option<Self> {
        let straight = Self::within(places, STRAIGHT)?;
        let is_fine =
            |Self(rings): &Self| rings.len() >= 2 && rings.iter().all(|ring| ring.faces.len() >= 3);
        if is_fine(&straight) {
            return Some(straight);
        }
        let is_even = |Self(rings): &Self| {
            rings
                .iter()
                .all(|ring| ring.faces.len() == rings[0].faces.len())
        };
        let bent = BENT
            .into_iter()
            .filter_map(|share| Self::within(places, share));
        let by_number = Self::by_number(places);
        bent.chain(by_number)
            .find(|rings| is_fine(rings) && is_even(rings))
    }

    /// Faces that follow each other within this share of the wall's length form a ring.
    fn within(places: &[Place], share: f64) -> Option<Self> {
        let mut all: Vec<(usize, Place)> = places.iter().copied().enumerate().collect();
        all.sort_by(|a, b| a.1.x_m.total_cmp(&b.1.x_m));
        let length = all.last()?.1.x_m - all.first()?.1.x_m;
        let mut rings: Vec<Vec<(usize, Place)>> = Vec::new();
        for (face, place) in all {
            match rings.last_mut() {
                Some(ring) if place.x_m - ring[ring.len() - 1].1.x_m <= share * length => {
                    ring.push((face, place));
                }
                _ => rings.push(vec![(face, place)]),
            }
        }
        Some(Self(
            rings
                .iter()
                .map(|ring| Ring::of(ring, STRAIGHT * length))
                .collect(),
        ))
    }

    /// Faces whose angles repeat with their numbers.
    fn by_number(places: &[Place]) -> Option<Self> {
        let all: Vec<(usize, Place)> = places.iter().copied().enumerate().collect();
        let repeats = |n: usize| {
            let pairs = places.iter().zip(&places[n..]);
            let apart = pairs
                .map(|(a, b)| ((b.phi_deg - a.phi_deg + 540.0).rem_euclid(360.0) - 180.0).abs());
            places.len().is_multiple_of(n) && apart.fold(0.0, f64::max) < 90.0 / n as f64
        };
        let n = (3..=places.len() / 2).find(|n| repeats(*n))?;
        Some(Self(
            all.chunks_exact(n)
                .map(|ring| Ring::of(ring, 0.0))
                .collect(),
        ))
    }

    /// The faces of each ring.
    pub fn faces(&self) -> impl Iterator<Item = Vec<usize>> + '_ {
        let faces = |ring: &Ring| ring.faces.iter().map(|(_, face)| *face).collect();
        self.0.iter().map(faces)
    }

    /// The value at `x` (m) and `phi` (degrees): linear around the two neighbouring rings and between them; beyond the
    /// first and the last ring as on them.
    pub fn value(&self, values: &[f64], x: f64, phi: f64) -> f64 {
        let Self(rings) = self;
        let next = rings.partition_point(|ring| ring.x <= x);
        if next == 0 || next == rings.len() {
            return rings[next.min(rings.len() - 1)].value(values, phi);
        }
        let (before, after) = (&rings[next - 1], &rings[next]);
        let share = (x - before.x) / (after.x - before.x);
        (1.0 - share) * before.value(values, phi) + share * after.value(values, phi)
    }
}

impl Ring {
    /// At the place of its first face if all are within `flat` (m) of it, or else at the mean of all.
    fn of(faces: &[(usize, Place)], flat: f64) -> Self {
        let places = || faces.iter().map(|(_, place)| place.x_m);
        let spread = places().fold(0.0, |most: f64, x| most.max((x - faces[0].1.x_m).abs()));
        let x = match spread <= flat {
            true => faces[0].1.x_m,
            false => places().sum::<f64>() / faces.len() as f64,
        };
        let mut faces: Vec<(f64, usize)> = faces
            .iter()
            .map(|(face, place)| (place.phi_deg, *face))
            .collect();
        faces.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { x, faces }
    }

    fn value(&self, values: &[f64], phi: f64) -> f64 {
        let n = self.faces.len();
        let next = self.faces.partition_point(|(angle, _)| *angle <= phi);
        let (before, after) = (self.faces[(next + n - 1) % n], self.faces[next % n]);
        let between = (after.0 - before.0).rem_euclid(360.0);
        let share = (phi - before.0).rem_euclid(360.0) / between;
        (1.0 - share) * values[before.1] + share * values[after.1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemodynamics::wall::tests::tube;

    /// Largest error over the wall, for a field that is smooth around.
    fn error(along: usize, around: usize) -> f64 {
        let field = |p: &Place| (1.3 * p.x_m).sin() + (2.0 * p.phi_deg.to_radians()).cos();
        let places = tube(along, around).places();
        let values: Vec<f64> = places.iter().map(field).collect();
        let rings = Rings::new(&places).unwrap();
        let other = tube(37, 53).places();
        let inner = other.iter().filter(|p| (0.5..3.5).contains(&p.x_m));
        let errors = inner.map(|p| (rings.value(&values, p.x_m, p.phi_deg) - field(p)).abs());
        errors.fold(0.0, f64::max)
    }

    #[test]
    fn the_error_falls_with_the_square_of_the_mesh_size() {
        let ratio = error(10, 16) / error(20, 32);
        assert!((3.0..5.5).contains(&ratio), "{ratio}");
        assert!(error(40, 64) < 0.01);
    }

    #[test]
    fn a_bent_wall_has_rings_too() {
        let straight = tube(10, 16).places();
        let rings = Rings::new(&straight).unwrap();
        // Centres of faces move along by less than the rings are apart, or by more.
        for most in [1e-3, 0.3] {
            let moved = |p: &Place| Place {
                x_m: p.x_m + most * p.phi_deg.to_radians().cos() * (p.x_m - 2.0),
                ..*p
            };
            let bent = Rings::new(&straight.iter().map(moved).collect::<Vec<_>>()).unwrap();
            let faces = |rings: &Rings| rings.faces().collect::<Vec<_>>();
            assert_eq!(faces(&bent), faces(&rings), "{most}");
        }
    }

    #[test]
    fn values_at_faces_are_kept_across_the_cut_at_180_degrees() {
        let places = tube(5, 7).places();
        let values: Vec<f64> = (0..places.len()).map(|i| i as f64).collect();
        let rings = Rings::new(&places).unwrap();
        for (place, value) in places.iter().zip(&values) {
            assert!((rings.value(&values, place.x_m, place.phi_deg) - value).abs() < 1e-9);
        }
        let [a, b] = [-180.0, 180.0].map(|phi| rings.value(&values, 1.0, phi));
        assert!((a - b).abs() < 1e-9);
        assert_eq!(Rings::new(&places[..2]), None);
    }
}
