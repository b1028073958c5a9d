//! Shapes of pressures on a wall, from which a surrogate is made: along branches, or on a surface of any form.

use crate::Vec3;
use crate::curve::SpaceCurve;
use nalgebra::DVector;

/// How far the shape of a node of a surface reaches, in the largest distance of a place from the nearest node: further
/// than 1, so that each place is reached; the further, the less shapes can be told apart.
const REACH: f64 = 1.5;

/// A node along a branch.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    /// Arc length, m.
    s: f64,
    /// Number of the shape that is 1 there and the same all around; nodes of several branches at a junction share it.
    whole: usize,
    /// Number of the node for waves around the circumference; junctions have one for each branch, other ends none, as
    /// their rims are held.
    own: Option<usize>,
}

/// Shapes of pressures on a wall, which add up to 1 almost everywhere.
pub trait PressureShapes {
    /// How many there are.
    fn count(&self) -> usize;

    /// The combination of them that is 1 (almost) everywhere.
    fn one(&self) -> DVector<f64>;

    /// Those that are not zero at `x` (m), where the wall has this normal of any length out of the blood, with their
    /// values.
    fn at(&self, x: &Vec3, normal: &Vec3) -> Vec<(usize, f64)>;
}

/// Shapes on the walls of branches: along each centre-line they are linear from node to node; around it
/// they are waves: 1, and for each number of periods cosine and sine.
#[derive(Debug, Clone)]
pub struct BranchShapes {
    lines: Vec<(SpaceCurve, Vec<Node>)>,
    whole: usize,
    /// Positions (m) of the nodes that waves have.
    own: Vec<Vec3>,
    periods: usize,
}

impl BranchShapes {
    /// Nodes at distances of about `spacing` (m) along branches; where ends of lines are nearer to each other than
    /// `near` (m), they are one node. Waves have up to so many `periods`.
    pub fn along(lines: &[SpaceCurve], spacing: f64, near: f64, periods: usize) -> Self {
        let ends: Vec<Vec3> = (lines.iter())
            .flat_map(|line| line.ends().map(|s| line.frame(s).origin))
            .collect();
        let junction = |x: &Vec3| {
            let mut all = (0..ends.len()).filter(|i| (ends[*i] - x).norm() < near);
            let first = all.next();
            all.next().and(first)
        };
        let mut numbers = vec![None; ends.len()];
        let mut shapes = Self {
            lines: Vec::new(),
            whole: 0,
            own: Vec::new(),
            periods,
        };
        for line in lines {
            let mut nodes = Vec::new();
            for (s, is_end) in places(line, spacing, |s| {
                junction(&line.frame(s).origin).map_or(spacing, |_| spacing.max(near))
            }) {
                let at = line.frame(s).origin;
                let junction = junction(&at).filter(|_| is_end);
                let known = junction.and_then(|end| numbers[end]);
                let whole = known.unwrap_or(shapes.whole);
                shapes.whole = shapes.whole.max(whole + 1);
                if let Some(end) = junction {
                    numbers[end] = Some(whole);
                }
                let own = (!is_end || junction.is_some()).then(|| {
                    shapes.own.push(at);
                    shapes.own.len() - 1
                });
                nodes.push(Node { s, whole, own });
            }
            shapes.lines.push((line.clone(), nodes));
        }
        shapes
    }

    /// Number of shapes that are the same all around; they come first.
    pub fn whole(&self) -> usize {
        self.whole
    }

    /// Positions (m) of the nodes that waves have.
    pub fn nodes(&self) -> &[Vec3] {
        &self.own
    }

    /// The shape of a wave at a node: waves 0 and 1 are cosine and sine of one period, 2 and 3 of two, …
    pub fn wave(&self, wave: usize, node: usize) -> usize {
        self.whole + wave * self.own.len() + node
    }

    /// Groups of nodes that are further apart than `apart` (m) from each other.
    pub fn groups(&self, apart: f64) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (node, x) in self.own.iter().enumerate() {
            let is_far = |other: &usize| (self.own[*other] - x).norm() > apart;
            match groups.iter_mut().find(|group| group.iter().all(is_far)) {
                Some(group) => group.push(node),
                None => groups.push(vec![node]),
            }
        }
        groups
    }
}

impl PressureShapes for BranchShapes {
    fn count(&self) -> usize {
        self.whole + 2 * self.periods * self.own.len()
    }

    fn one(&self) -> DVector<f64> {
        let is_whole = |shape: usize| f64::from(u8::from(shape < self.whole));
        DVector::from_iterator(self.count(), (0..self.count()).map(is_whole))
    }

    fn at(&self, x: &Vec3, _normal: &Vec3) -> Vec<(usize, f64)> {
        let places = self.lines.iter().map(|(line, nodes)| {
            let (nearest, [from, to]) = (line.nearest(x), line.ends());
            // Not from where the line would go on.
            let on_line = line.frame(nearest.s.clamp(from, to)).origin;
            ((on_line - x).norm(), nearest, nodes)
        });
        let Some((_, nearest, nodes)) = places.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return Vec::new();
        };
        let s = nearest.s;
        let after = nodes
            .partition_point(|node| node.s < s)
            .clamp(1, nodes.len() - 1);
        let (before, after) = (nodes[after - 1], nodes[after]);
        let share = ((s - before.s) / (after.s - before.s)).clamp(0.0, 1.0);
        let angle = nearest.across[1].atan2(nearest.across[0]);
        let mut found = Vec::new();
        for (node, value) in [(before, 1.0 - share), (after, share)] {
            found.push((node.whole, value));
            for period in 1..=self.periods {
                let (sine, cosine) = (period as f64 * angle).sin_cos();
                let number = |wave: usize| Some(self.wave(2 * (period - 1) + wave, node.own?));
                found.extend(number(0).map(|number| (number, value * cosine)));
                found.extend(number(1).map(|number| (number, value * sine)));
            }
        }
        found
    }
}

/// Arc lengths (m) of the nodes of a line, and whether it ends there: the first and the last one between lie as far
/// from the ends as `first` says, since near a junction most of the wall is nearer to other lines.
fn places(line: &SpaceCurve, spacing: f64, first: impl Fn(f64) -> f64) -> Vec<(f64, bool)> {
    let [from, to] = line.ends();
    let (begin, end) = (from + first(from), to - first(to));
    let pieces = ((end - begin) / spacing).round().max(1.0) as usize;
    let between = (0..=pieces).map(|i| (begin + (end - begin) * i as f64 / pieces as f64, false));
    let between = between.filter(|(s, _)| from < *s && *s < to);
    [(from, true)]
        .into_iter()
        .chain(between)
        .chain([(to, true)])
        .collect()
}

/// Shapes on a surface of any form: hats around nodes that lie as far from each other as so many can. Places whose
/// normals differ are further apart, and those that face away from each other, as the two sides of a thin body,
/// infinitely.
#[derive(Debug, Clone)]
pub struct SurfaceShapes {
    /// Positions (m) and unit normals.
    nodes: Vec<(Vec3, Vec3)>,
    /// How far a hat reaches, m.
    reach: f64,
}

impl SurfaceShapes {
    /// At most so many on a surface of the given faces: their middles (m) and areas out of the blood, m².
    pub fn on(faces: &[(Vec3, Vec3)], most: usize) -> Self {
        let mut nodes = Vec::new();
        let mut far = vec![f64::INFINITY; faces.len()];
        while let Some((next, _)) = (far.iter().copied().enumerate())
            .reduce(|a, b| if b.1 > a.1 { b } else { a })
            .filter(|(_, left)| nodes.len() < most && *left > 0.0)
        {
            let node = (faces[next].0, faces[next].1.normalize());
            for (far, (x, area)) in far.iter_mut().zip(faces) {
                *far = far.min(distance(&node, x, &area.normalize()));
            }
            nodes.push(node);
        }
        let largest = far
            .into_iter()
            .filter(|far| far.is_finite())
            .fold(0.0, f64::max);
        Self {
            nodes,
            reach: REACH * largest,
        }
    }
}

/// From a node to a place with this unit normal, m.
fn distance((node, out): &(Vec3, Vec3), x: &Vec3, normal: &Vec3) -> f64 {
    let cosine = out.dot(normal);
    match cosine > 0.0 {
        true => (node - x).norm() / cosine,
        false => f64::INFINITY,
    }
}

impl PressureShapes for SurfaceShapes {
    fn count(&self) -> usize {
        self.nodes.len()
    }

    fn one(&self) -> DVector<f64> {
        DVector::repeat(self.count(), 1.0)
    }

    fn at(&self, x: &Vec3, normal: &Vec3) -> Vec<(usize, f64)> {
        let normal = normal.normalize();
        let hat = |node| (1.0 - distance(node, x, &normal) / self.reach).max(0.0);
        let hats = self.nodes.iter().map(hat).enumerate();
        let mut hats: Vec<_> = hats.filter(|(_, value)| *value > 0.0).collect();
        let sum: f64 = hats.iter().map(|(_, value)| value).sum();
        for (_, value) in &mut hats {
            *value /= sum;
        }
        hats
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sides_of_a_thin_plate_have_shapes_of_their_own() {
        let middle = |i: usize| 0.01 * (f64::from(i as u32 % 40) + 0.5);
        let face = |i: usize| {
            let side = if i < 40 { 1.0 } else { -1.0 };
            (
                Vec3::new(middle(i), 1e-4 * side, 0.0),
                Vec3::y() * 1e-4 * side,
            )
        };
        let faces: Vec<_> = (0..80).map(face).collect();
        let shapes = SurfaceShapes::on(&faces, 20);
        assert_eq!(shapes.count(), 20);
        let at = |(x, area): (Vec3, Vec3)| shapes.at(&x, &area);
        for i in 0..40 {
            let [above, below] = [at(face(i)), at(face(i + 40))];
            let sum: f64 = above.iter().map(|(_, value)| value).sum();
            assert!((sum - 1.0).abs() < 1e-12);
            assert!(
                above
                    .iter()
                    .all(|(shape, _)| below.iter().all(|(other, _)| other != shape))
            );
        }
    }
}
