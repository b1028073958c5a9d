//! Hexahedra with Lagrange polynomials: where a point lies in one, and the value of a field there.

use crate::{Vec3, lagrange};

/// A curved cell reaches beyond its nodes by this share of their extent at most.
const BULGE: f64 = 0.1;
/// A point lies in a cell if no local coordinate exceeds 1 by more: what is on a face lies in both.
const EDGE: f64 = 1e-6;
/// Steps of Newton's method; from the middle of a cell it takes four or five.
const MOST_STEPS: usize = 30;
/// It has converged once a step is shorter than this, in local coordinates.
const CONVERGED: f64 = 1e-12;

/// A cell: a polynomial in each of the local coordinates in [-1, 1], known by its values at `rule` in each of them.
#[derive(Debug, Clone, Copy)]
pub struct LagrangeCell<'a> {
    /// Local coordinates of the nodes along each axis.
    pub rule: &'a [f64],
    /// The nodes, fastest along the first axis.
    pub nodes: &'a [u32],
}

/// What a cell lies within.
#[derive(Debug, Clone, PartialEq)]
pub struct Extent {
    low: Vec3,
    high: Vec3,
}

impl Extent {
    /// Whether a point (m) may lie in the cell.
    pub fn contains(&self, x: &Vec3) -> bool {
        (0..3).all(|c| (self.low[c]..=self.high[c]).contains(&x[c]))
    }
}

impl LagrangeCell<'_> {
    /// What the cell lies within, with room for its curvature; `positions` (m) are those of all nodes.
    pub fn extent(&self, positions: &impl Fn(usize) -> Vec3) -> Extent {
        let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for &node in self.nodes {
            let x = positions(node as usize);
            (low, high) = (low.inf(&x), high.sup(&x));
        }
        let margin = BULGE * (high - low);
        Extent {
            low: low - margin,
            high: high + margin,
        }
    }

    /// Local coordinates of the point `x` (m), if it lies in the cell.
    pub fn locate(&self, positions: &impl Fn(usize) -> Vec3, x: &Vec3) -> Option<Vec3> {
        let nodal = self.nodal(positions);
        let mut xi = Vec3::zeros();
        for _ in 0..MOST_STEPS {
            let (here, jacobian) = lagrange::vector_and_slopes(self.rule, &nodal, &xi);
            let step = jacobian.lu().solve(&(x - here))?;
            xi += step;
            // What has left for good does not lie here; before, it may come back.
            if !xi.iter().all(|c| c.abs() < 3.0) {
                return None;
            }
            if step.amax() < CONVERGED {
                return (xi.amax() <= 1.0 + EDGE).then_some(xi);
            }
        }
        None
    }

    /// Values of the nodes' polynomials at a place in local coordinates.
    pub fn shapes(&self, xi: &Vec3) -> Vec<f64> {
        lagrange::products(&[0, 1, 2].map(|d| lagrange::values(self.rule, xi[d])))
    }

    /// Value of a vector field at a place in local coordinates.
    pub fn value(&self, field: &impl Fn(usize) -> Vec3, xi: &Vec3) -> Vec3 {
        lagrange::vector_and_slopes(self.rule, &self.nodal(field), xi).0
    }

    fn nodal(&self, field: &impl Fn(usize) -> Vec3) -> Vec<Vec3> {
        (self.nodes.iter())
            .map(|&node| field(node as usize))
            .collect()
    }
}

/// The cell in which a point (m) lies deepest, with its local coordinates there; none outside all of them.
pub fn find<'a>(
    cells: impl Iterator<Item = (LagrangeCell<'a>, &'a Extent)>,
    positions: &impl Fn(usize) -> Vec3,
    x: &Vec3,
) -> Option<(usize, Vec3)> {
    let near = cells
        .enumerate()
        .filter(|(_, (_, extent))| extent.contains(x));
    let found = near.filter_map(|(e, (cell, _))| Some((e, cell.locate(positions, x)?)));
    { found }.min_by(|(_, a), (_, b)| a.amax().total_cmp(&b.amax()))
}
