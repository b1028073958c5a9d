//! Quadrilaterals of a surface in groups of n by n, as elements with curved sides need them.
//!
//! Each quadrilateral has a place `(a, b)` in its group, counted along its own first and last edge. A place decides
//! those of its neighbours: across an edge lies the next place, or the first one of another group. So one place decides
//! all those of a connected surface, and a surface can be grouped if going around leads to no contradiction: around
//! vertices where not four quadrilaterals meet, which must be corners of groups, and around closed rows, whose length
//! must be a multiple of n.

use crate::Vec3;
use std::collections::HashMap;

/// A surface of quadrilaterals that all turn the same way round.
#[derive(Debug, Clone, PartialEq)]
pub struct Quads {
    /// Positions of the points, m.
    pub points: Vec<Vec3>,
    /// Points of each face; the normal by the right-hand rule points outward.
    pub faces: Vec<[usize; 4]>,
}

/// Points of a group in rows: `points[i + (n + 1) j]` is the i-th along the first direction, the j-th along the second;
/// the first, the second and outward are right-handed.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Indices into the points of the surface.
    pub points: Vec<usize>,
    /// One of its faces.
    pub face: usize,
}

/// Why a surface cannot be grouped.
#[derive(Debug, Clone, PartialEq)]
pub struct Ungrouped {
    /// Near which point.
    pub near: Vec3,
    /// What is there.
    pub reason: &'static str,
}

/// Across each edge of each face: the face there and which of its edges it is.
type Neighbours = Vec<[Option<(usize, usize)>; 4]>;

impl Quads {
    fn middle(&self, face: usize) -> Vec3 {
        let corners = self.faces[face].iter().map(|&p| self.points[p]);
        corners.sum::<Vec3>() / 4.0
    }

    /// # Errors
    /// If more than two faces share an edge, or two of them turn different ways round.
    pub fn neighbours(&self) -> Result<Neighbours, Ungrouped> {
        let mut sides: HashMap<(usize, usize), (usize, usize)> = HashMap::new();
        for (f, face) in self.faces.iter().enumerate() {
            for k in 0..4 {
                let side = (face[k], face[(k + 1) % 4]);
                if sides.insert(side, (f, k)).is_some() {
                    return Err(Ungrouped {
                        near: self.points[side.0],
                        reason: "more than two faces meet at an edge there",
                    });
                }
            }
        }
        let across = |f: usize, k: usize| {
            let face = self.faces[f];
            sides.get(&(face[(k + 1) % 4], face[k])).copied()
        };
        Ok((0..self.faces.len())
            .map(|f| [0, 1, 2, 3].map(|k| across(f, k)))
            .collect())
    }

    /// Groups of `n` by `n` faces.
    ///
    /// # Errors
    /// Where that is not possible.
    pub fn grouped(&self, n: usize) -> Result<Vec<Group>, Ungrouped> {
        let neighbours = self.neighbours()?;
        let mut places = vec![None; self.faces.len()];
        for seed in 0..self.faces.len() {
            if places[seed].is_some() {
                continue;
            }
            let mut first = None;
            let all = (0..n * n).map(|i| [i % n, i / n]);
            let found = all.into_iter().find_map(|place| {
                let found = spread(&neighbours, seed, place, n);
                found
                    .map_err(|face| first.get_or_insert(face).to_owned())
                    .ok()
            });
            let Some(found) = found else {
                return Err(Ungrouped {
                    near: self.middle(first.unwrap_or(seed)),
                    reason: "the faces do not lie in rows and blocks of a multiple of that number",
                });
            };
            for (face, place) in found {
                places[face] = Some(place);
            }
        }
        let mut used = vec![false; self.faces.len()];
        let mut groups = Vec::new();
        for (face, place) in places.iter().enumerate() {
            let last = n - 1;
            let turned = match place {
                Some([0, 0]) => 0,
                Some([a, 0]) if *a == last => 1,
                Some([a, b]) if *a == last && *b == last => 2,
                Some([0, b]) if *b == last => 3,
                _ => continue,
            };
            if !used[face] {
                groups.push(self.group(&neighbours, face, turned, n, &mut used)?);
            }
        }
        Ok(groups)
    }

    /// The group with `corner` as its first face, whose edges count from `turned` on.
    fn group(
        &self,
        neighbours: &Neighbours,
        corner: usize,
        turned: usize,
        n: usize,
        used: &mut [bool],
    ) -> Result<Group, Ungrouped> {
        // Across edge k of a face that is turned by r: the face there, and by how much that is turned.
        let across = |(face, r): (usize, usize), k: usize| {
            let (next, edge) = neighbours[face][(k + r) % 4]?;
            Some((next, (edge + 6 - k) % 4))
        };
        let mut points = vec![0; (n + 1) * (n + 1)];
        let mut row = Some((corner, turned));
        for j in 0..n {
            let mut at = row;
            for i in 0..n {
                let Some((face, r)) = at.filter(|(face, _)| !used[*face]) else {
                    return Err(Ungrouped {
                        near: self.middle(corner),
                        reason: "the faces do not lie in rows and blocks of a multiple of that number",
                    });
                };
                used[face] = true;
                let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                for (k, (i, j)) in corners.into_iter().enumerate() {
                    points[i + (n + 1) * j] = self.faces[face][(k + r) % 4];
                }
                if i + 1 < n {
                    at = across((face, r), 1);
                }
            }
            if j + 1 < n {
                row = row.and_then(|at| across(at, 2));
            }
        }
        Ok(Group {
            points,
            face: corner,
        })
    }
}

/// Places of all faces that hang together with `seed`, or the face at which they contradict each other.
fn spread(
    neighbours: &Neighbours,
    seed: usize,
    place: [usize; 2],
    n: usize,
) -> Result<HashMap<usize, [usize; 2]>, usize> {
    let mut places = HashMap::from([(seed, place)]);
    let mut next = vec![seed];
    while let Some(face) = next.pop() {
        let place = places[&face];
        for k in 0..4 {
            let [depth, along] = seen_from(place, k, n);
            let Some((other, edge)) = neighbours[face][k] else {
                // Groups end at the rim.
                if depth != 0 {
                    return Err(face);
                }
                continue;
            };
            let there = place_from([(n - depth) % n, n - 1 - along], edge, n);
            match places.get(&other) {
                Some(known) if *known == there => {}
                Some(_) => return Err(other),
                None => {
                    places.insert(other, there);
                    next.push(other);
                }
            }
        }
    }
    Ok(places)
}

/// How many faces of its group lie between a face and the side of the group beyond its edge `k`, and how many before it
/// along that side.
fn seen_from([a, b]: [usize; 2], k: usize, n: usize) -> [usize; 2] {
    let last = n - 1;
    [[b, a], [last - a, b], [last - b, last - a], [a, last - b]][k]
}

/// The inverse of [`seen_from`].
fn place_from([depth, along]: [usize; 2], k: usize, n: usize) -> [usize; 2] {
    let last = n - 1;
    [
        [along, depth],
        [last - depth, along],
        [last - along, last - depth],
        [depth, last - along],
    ][k]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block of `na` by `nb` faces, closed along the first direction if `is_ring`; every third face begins at another
    /// corner.
    fn block(na: usize, nb: usize, is_ring: bool) -> Quads {
        let columns = if is_ring { na } else { na + 1 };
        let point = |i: usize, j: usize| i % columns + columns * j;
        let points = (0..columns * (nb + 1))
            .map(|p| Vec3::new((p % columns) as f64, (p / columns) as f64, 0.0));
        let faces = (0..na * nb).map(|f| {
            let (i, j) = (f % na, f / na);
            let mut face = [
                point(i, j),
                point(i + 1, j),
                point(i + 1, j + 1),
                point(i, j + 1),
            ];
            face.rotate_left(f % 3);
            face
        });
        Quads {
            points: points.collect(),
            faces: faces.collect(),
        }
    }

    #[test]
    fn blocks_and_rings_are_grouped_where_counts_are_multiples() {
        for (quads, n, count) in [
            (block(6, 9, false), 3, 6),
            (block(8, 4, true), 4, 2),
            (block(8, 4, true), 2, 8),
            (block(5, 3, false), 1, 15),
        ] {
            let groups = quads.grouped(n).unwrap();
            assert_eq!(groups.len(), count);
            for group in &groups {
                let at = |i: usize, j: usize| quads.points[group.points[i + (n + 1) * j]];
                let (first, second) = (at(1, 0) - at(0, 0), at(0, 1) - at(0, 0));
                // Seen from outside they turn counter-clockwise; the ring is flat and folded at one place.
                let area = first.cross(&second).z;
                assert!((area - 1.0).abs() < 1e-12 || area < -2.0, "{area}");
                let mut all = group.points.clone();
                all.sort_unstable();
                all.dedup();
                assert_eq!(all.len(), (n + 1) * (n + 1));
            }
        }
        assert!(block(6, 9, false).grouped(2).is_err());
        assert!(block(6, 8, true).grouped(4).is_err());
    }

    /// Three blocks that share a corner, as a cube has.
    #[test]
    fn corners_where_three_blocks_meet_are_corners_of_groups() {
        let n = 4;
        let mut points: Vec<Vec3> = Vec::new();
        let mut number = |x: [usize; 3]| {
            let x = Vec3::new(x[0] as f64, x[1] as f64, x[2] as f64);
            let known = points.iter().position(|p| *p == x);
            known.unwrap_or_else(|| {
                points.push(x);
                points.len() - 1
            })
        };
        let mut faces = Vec::new();
        for axis in 0..3 {
            for i in 0..n {
                for j in 0..n {
                    let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                    faces.push(corners.map(|(i, j)| {
                        let mut x = [n; 3];
                        (x[(axis + 1) % 3], x[(axis + 2) % 3]) = (i, j);
                        number(x)
                    }));
                }
            }
        }
        let quads = Quads { points, faces };
        assert_eq!(quads.grouped(4).unwrap().len(), 3);
        assert_eq!(quads.grouped(2).unwrap().len(), 12);
        assert!(quads.grouped(3).is_err());
    }
}
