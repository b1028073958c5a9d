//! The natural cubic spline through points, by its arc length.

use super::Frame;
use crate::Vec3;
use crate::quadrature::Rule;

/// Nodes in each interval between two points: frames are carried from one to the next.
const NODES: usize = 8;
/// Points of the quadrature of the arc length between two nodes.
const POINTS: usize = 5;

/// The parameter `u` is the length of the polygon through the points.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    knots: Vec<f64>,
    points: Vec<Vec3>,
    /// Second derivatives by the parameter at the points.
    bends: Vec<Vec3>,
    nodes: Vec<Node>,
    /// Of the arc length between two nodes.
    quadrature: Rule,
    /// Arc length where it begins.
    start: f64,
}

#[derive(Debug, Clone, PartialEq)]
struct Node {
    u: f64,
    s: f64,
    frame: Frame,
}

impl Spline {
    pub fn new(points: &[Vec3], first: Vec3) -> Self {
        assert!(points.len() >= 2, "a curve needs two points");
        let mut knots = vec![0.0];
        for pair in points.windows(2) {
            knots.push(knots[knots.len() - 1] + (pair[1] - pair[0]).norm());
        }
        let bends = second_derivatives(&knots, points);
        let mut spline = Self {
            knots,
            points: points.to_vec(),
            bends,
            nodes: Vec::new(),
            quadrature: Rule::gauss_legendre(POINTS),
            start: 0.0,
        };
        let [origin, tangent, _] = spline.at(0.0);
        let mut node = Node {
            u: 0.0,
            s: 0.0,
            frame: Frame::new(origin, tangent, perpendicular(&tangent, first)),
        };
        let mut nodes = vec![node.clone()];
        for i in 0..points.len() - 1 {
            let (from, to) = (spline.knots[i], spline.knots[i + 1]);
            for k in 1..=NODES {
                let u = match k {
                    NODES => to,
                    _ => from + (to - from) * k as f64 / NODES as f64,
                };
                node = Node {
                    u,
                    s: node.s + spline.length_between(node.u, u),
                    frame: spline.carried(&node.frame, u),
                };
                nodes.push(node.clone());
            }
        }
        spline.nodes = nodes;
        spline
    }

    pub fn length(&self) -> f64 {
        self.nodes[self.nodes.len() - 1].s
    }

    /// Arc lengths of the points.
    pub fn knots(&self) -> Vec<f64> {
        let points = self.nodes.iter().step_by(NODES);
        points.map(|node| self.start + node.s).collect()
    }

    pub fn shifted(&self, by: f64) -> Self {
        Self {
            start: self.start + by,
            ..self.clone()
        }
    }

    pub fn frame(&self, s: f64) -> Frame {
        let (node, u) = self.parameter(s);
        self.carried(&self.nodes[node].frame, u)
    }

    /// `dT/ds = (c'' - T (T·c'')) / |c'|²`.
    pub fn curvature(&self, s: f64) -> Vec3 {
        let (_, u) = self.parameter(s);
        let [_, slope, bend] = self.at(u);
        let tangent = slope.normalize();
        (bend - tangent * tangent.dot(&bend)) / slope.norm_squared()
    }

    /// The last node before the arc length `s`, and the parameter there.
    fn parameter(&self, s: f64) -> (usize, f64) {
        let s = s - self.start;
        let next = self.nodes.partition_point(|node| node.s <= s);
        let index = next.clamp(1, self.nodes.len() - 1) - 1;
        let (before, after) = (&self.nodes[index], &self.nodes[index + 1]);
        let share = (s - before.s) / (after.s - before.s);
        let mut u = before.u + share * (after.u - before.u);
        // Newton's method; the speed |c'| is nearly 1.
        for _ in 0..20 {
            let error = s - before.s - self.length_between(before.u, u);
            u += error / self.at(u)[1].norm();
            if error.abs() <= 1e-15 * self.length() {
                break;
            }
        }
        (index, u)
    }

    /// Position and its first two derivatives by the parameter.
    fn at(&self, u: f64) -> [Vec3; 3] {
        let next = self.knots.partition_point(|knot| *knot <= u);
        let i = next.clamp(1, self.knots.len() - 1) - 1;
        let h = self.knots[i + 1] - self.knots[i];
        let (a, b) = ((self.knots[i + 1] - u) / h, (u - self.knots[i]) / h);
        let (p, q) = (self.points[i], self.points[i + 1]);
        let (v, w) = (self.bends[i], self.bends[i + 1]);
        let cubic = (v * (a * a * a - a) + w * (b * b * b - b)) * (h * h / 6.0);
        let slope = (w * (3.0 * b * b - 1.0) - v * (3.0 * a * a - 1.0)) * (h / 6.0);
        [p * a + q * b + cubic, (q - p) / h + slope, v * a + w * b]
    }

    /// Arc length between two parameters within one interval.
    fn length_between(&self, from: f64, to: f64) -> f64 {
        let half = 0.5 * (to - from);
        let speed = |x: f64| self.at(from + half * (1.0 + x))[1].norm();
        let Rule { points, weights } = &self.quadrature;
        let parts = points.iter().zip(weights);
        half * parts.map(|(x, weight)| weight * speed(*x)).sum::<f64>()
    }

    /// A frame carried to the parameter `u` by double reflection: fourth order (Wang, Jüttler, Zheng and Liu,
    /// *Computation of rotation minimizing frames*, ACM Trans. Graph. 27, 2008).
    fn carried(&self, frame: &Frame, u: f64) -> Frame {
        let [origin, slope, _] = self.at(u);
        let tangent = slope.normalize();
        let reflect = |v: Vec3, mirror: &Vec3| match mirror.norm_squared() {
            0.0 => v,
            squared => v - mirror * (2.0 * mirror.dot(&v) / squared),
        };
        let chord = origin - frame.origin;
        let mirror = tangent - reflect(frame.tangent, &chord);
        let first = reflect(reflect(frame.first, &chord), &mirror);
        Frame::new(origin, tangent, first)
    }
}

/// A direction that is not along the tangent: `wanted`, or else the axis that is farthest from it.
fn perpendicular(tangent: &Vec3, wanted: Vec3) -> Vec3 {
    let across = wanted - tangent * (tangent.dot(&wanted) / tangent.norm_squared());
    if across.norm() > 1e-6 * wanted.norm() {
        return wanted;
    }
    let axes = [Vec3::y(), Vec3::z(), Vec3::x()];
    let along = |axis: &Vec3| axis.dot(tangent).abs();
    let farthest = axes
        .into_iter()
        .min_by(|a, b| along(a).total_cmp(&along(b)));
    farthest.unwrap_or_else(Vec3::y)
}

/// Second derivatives at the knots of the natural cubic spline, by Thomas' algorithm.
fn second_derivatives(knots: &[f64], points: &[Vec3]) -> Vec<Vec3> {
    let n = points.len();
    let mut bends = vec![Vec3::zeros(); n];
    let h = |i: usize| knots[i + 1] - knots[i];
    let slope = |i: usize| (points[i + 1] - points[i]) / h(i);
    let (mut upper, mut right) = (vec![0.0; n], vec![Vec3::zeros(); n]);
    for i in 1..n - 1 {
        let (below, diagonal) = (h(i - 1), 2.0 * (h(i - 1) + h(i)));
        let pivot = diagonal - below * upper[i - 1];
        upper[i] = h(i) / pivot;
        right[i] = ((slope(i) - slope(i - 1)) * 6.0 - right[i - 1] * below) / pivot;
    }
    for i in (1..n.saturating_sub(1)).rev() {
        bends[i] = right[i] - bends[i + 1] * upper[i];
    }
    bends
}
