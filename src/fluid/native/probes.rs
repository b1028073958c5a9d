//! The flow at points that stay where they are, while the mesh moves over them.
//!
//! A point is looked for in the elements near it by Newton's method on the mapping `x(ξ) = Σ lᵢ(ξ) xᵢ`; where all `|ξ_d| <= 1`,
//! velocity and pressure are the values of their own polynomials there.

use super::basis::{lagrange, lagrange_derivatives};
use super::spectral_elements::SpectralElements;
use crate::Vec3;
use crate::fluid::FluidProbe;
use nalgebra::Matrix3;

/// A curved element reaches beyond its nodes by this share of their extent at most.
const BULGE: f64 = 0.1;
/// A point lies in an element if no local coordinate exceeds 1 by more: what is on a face lies in both.
const EDGE: f64 = 1e-6;
/// Steps of Newton's method; from the middle of an element it takes four or five.
const MOST_STEPS: usize = 30;
/// It has converged once a step is shorter than this, in local coordinates.
const CONVERGED: f64 = 1e-12;

/// Pressure and velocity at `points` (m), for fields with one component after the other; NaN outside the fluid.
pub fn probe(
    space: &SpectralElements,
    positions: &[f64],
    velocity: &[f64],
    pressure: &[f64],
    points: &[Vec3],
) -> Vec<FluidProbe> {
    if points.is_empty() {
        return Vec::new();
    }
    let boxes = boxes(space, positions);
    let of_point = |x: &Vec3| {
        let near = (0..boxes.len()).filter(|&e| boxes[e].contains(x));
        let found = near.filter_map(|e| Some((e, locate(space, e, positions, x)?)));
        // On an edge between elements, the one in which it lies deepest.
        let depth = |xi: &Vec3| xi.amax();
        let best = { found }.min_by(|(_, a), (_, b)| depth(a).total_cmp(&depth(b)));
        let Some((e, xi)) = best else {
            return FluidProbe {
                pressure: f64::NAN,
                velocity: Vec3::repeat(f64::NAN),
            };
        };
        let (u, _) = vector_at(space, e, velocity, &xi);
        let values = [0, 1, 2].map(|d| lagrange(&space.basis.pressure_nodes.points, xi[d]));
        let nodes = space.space.element_pressures(e).iter();
        let shapes = products(&values);
        FluidProbe {
            pressure: nodes
                .zip(shapes)
                .map(|(&node, shape)| shape * pressure[node as usize])
                .sum(),
            velocity: u,
        }
    };
    points.iter().map(of_point).collect()
}

/// What an element lies within.
struct Extent {
    low: Vec3,
    high: Vec3,
}

impl Extent {
    fn contains(&self, x: &Vec3) -> bool {
        (0..3).all(|c| (self.low[c]..=self.high[c]).contains(&x[c]))
    }
}

fn boxes(space: &SpectralElements, positions: &[f64]) -> Vec<Extent> {
    let n = space.space.nodes;
    let of_element = |e: usize| {
        let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for &node in space.space.element(e) {
            let x = Vec3::from_fn(|c, _| positions[c * n + node as usize]);
            (low, high) = (low.inf(&x), high.sup(&x));
        }
        let margin = BULGE * (high - low);
        Extent {
            low: low - margin,
            high: high + margin,
        }
    };
    (0..space.space.elements).map(of_element).collect()
}

/// Local coordinates of the point `x` in element `e`, if it lies there.
fn locate(space: &SpectralElements, e: usize, positions: &[f64], x: &Vec3) -> Option<Vec3> {
    let mut xi = Vec3::zeros();
    for _ in 0..MOST_STEPS {
        let (here, jacobian) = vector_at(space, e, positions, &xi);
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

/// A vector field of the velocity's degree, with its derivatives by the local coordinates.
fn vector_at(space: &SpectralElements, e: usize, field: &[f64], xi: &Vec3) -> (Vec3, Matrix3<f64>) {
    let points = &space.basis.nodes.points;
    let values = [0, 1, 2].map(|d| lagrange(points, xi[d]));
    let slopes = [0, 1, 2].map(|d| lagrange_derivatives(points, xi[d]));
    let derived = [0, 1, 2].map(|d| {
        let mut factors = values.clone();
        factors[d].clone_from(&slopes[d]);
        products(&factors)
    });
    let (shapes, nodes) = (products(&values), space.space.nodes);
    let (mut value, mut slope) = (Vec3::zeros(), Matrix3::zeros());
    for (i, &node) in space.space.element(e).iter().enumerate() {
        for c in 0..3 {
            let f = field[c * nodes + node as usize];
            value[c] += shapes[i] * f;
            for d in 0..3 {
                slope[(c, d)] += derived[d][i] * f;
            }
        }
    }
    (value, slope)
}

/// Products of one-dimensional values, fastest along ξ.
fn products(values: &[Vec<f64>; 3]) -> Vec<f64> {
    let [x, y, z] = values;
    let plane = z.iter().flat_map(|c| y.iter().map(move |b| b * c));
    plane.flat_map(|bc| x.iter().map(move |a| a * bc)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::taylor_hood_space::{Plane, TaylorHoodSpace};
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// A quarter of a tube's wall, bent and sheared along its axis: nothing is straight.
    fn bent(radial: f64, angle: f64, along: f64) -> Vec3 {
        let (r, phi) = (1.0 + radial, FRAC_PI_2 * angle);
        let x = 2.0 * along + 0.2 * (3.0 * phi).sin();
        Vec3::new(x, r * phi.cos() + 0.1 * along * along, r * phi.sin())
    }

    /// The mesh with its positions, and the places in the unit cube of all nodes of velocity and pressure.
    fn mesh(degree: usize) -> (SpectralElements, Vec<f64>, [Vec<Vec3>; 2]) {
        let cells = [2, 3];
        let space = TaylorHoodSpace::swept(
            &Plane::grid(cells, degree),
            &Plane::grid(cells, degree - 1),
            degree,
            2,
        );
        let space = SpectralElements::new(space).unwrap();
        let size = Vec3::new(2.0, 3.0, 2.0);
        let places = |pressure: bool| {
            let (rule, count) = match pressure {
                true => (&space.basis.pressure_nodes, space.space.pressures),
                false => (&space.basis.nodes, space.space.nodes),
            };
            let mut places = vec![Vec3::zeros(); count];
            let n = rule.len();
            for e in 0..space.space.elements {
                let first = Vec3::new((e % 2) as f64, (e / 2 % 3) as f64, (e / 6) as f64);
                let nodes = match pressure {
                    true => space.space.element_pressures(e),
                    false => space.space.element(e),
                };
                for (i, &node) in nodes.iter().enumerate() {
                    let local = [i % n, i / n % n, i / n / n].map(|i| 0.5 + 0.5 * rule.points[i]);
                    places[node as usize] = (first + Vec3::from(local)).component_div(&size);
                }
            }
            places
        };
        let places = [places(false), places(true)];
        let nodes: Vec<Vec3> = places[0].iter().map(|s| bent(s.x, s.y, s.z)).collect();
        let positions = (0..3)
            .flat_map(|c| nodes.iter().map(move |x| x[c]))
            .collect();
        (space, positions, places)
    }

    /// Points within the body, on the edges of its elements, and at its corners.
    fn places() -> Vec<Vec3> {
        let axis = [0.0, 0.11, 0.5, 2.0 / 3.0, 0.97, 1.0];
        let pairs = axis.iter().flat_map(|&a| axis.iter().map(move |&b| (a, b)));
        pairs
            .flat_map(|(a, b)| axis.iter().map(move |&c| Vec3::new(a, b, c)))
            .collect()
    }

    #[test]
    fn a_linear_velocity_is_met_on_a_bent_mesh_and_smooth_fields_the_better_the_higher_the_degree()
    {
        let linear = |x: &Vec3| Vec3::new(1.0 + x.y, 2.0 * x.z - x.x, x.x + x.y + x.z);
        let smooth = |x: &Vec3| (1.3 * x.x).sin() * (0.7 * x.y).cos() + x.z * x.z;
        let mut errors = Vec::new();
        for degree in [4, 6] {
            let (space, positions, [_, pressures]) = mesh(degree);
            let n = space.space.nodes;
            let at = |i: usize| Vec3::from_fn(|c, _| positions[c * n + i]);
            let velocity: Vec<f64> = (0..3)
                .flat_map(|c| (0..n).map(move |i| (c, i)))
                .map(|(c, i)| linear(&at(i))[c])
                .collect();
            // The mesh's own curved shape, not that which it stands for.
            let middle = |place: &Vec3| {
                let scaled = place.component_mul(&Vec3::new(2.0, 3.0, 2.0));
                let cell = Vec3::from_fn(|d, _| scaled[d].floor().min([1.0, 2.0, 1.0][d]));
                let e = cell.x as usize + 2 * cell.y as usize + 6 * cell.z as usize;
                let xi = (scaled - cell) * 2.0 - Vec3::repeat(1.0);
                vector_at(&space, e, &positions, &xi).0
            };
            let pressure: Vec<f64> = pressures
                .iter()
                .map(|place| smooth(&middle(place)))
                .collect();
            let points: Vec<Vec3> = places().iter().map(middle).collect();
            let found = probe(&space, &positions, &velocity, &pressure, &points);
            let mut worst = 0.0_f64;
            for (x, found) in points.iter().zip(&found) {
                let error = (found.velocity - linear(x)).norm();
                assert!(error < 1e-11, "{x:?}: {error:e}");
                worst = worst.max((found.pressure - smooth(x)).abs());
            }
            errors.push(worst);
        }
        for (found, measured) in errors.iter().zip([2.468e-3, 2.077e-5]) {
            assert!((found / measured - 1.0).abs() < 0.01, "{errors:?}");
        }
    }

    #[test]
    fn points_outside_are_no_numbers() {
        let (space, positions, _) = mesh(4);
        let (n, p) = (space.space.nodes, space.space.pressures);
        let outside = [
            bent(-0.01, 0.5, 0.5), // just within the bore
            bent(1.01, 0.5, 0.5),
            bent(0.5, 1.01, 0.5),
            bent(0.5, 0.5, -0.01),
            Vec3::zeros(),
            Vec3::repeat(1e9),
            Vec3::repeat(f64::NAN),
        ];
        let found = probe(
            &space,
            &positions,
            &vec![1.0; 3 * n],
            &vec![1.0; p],
            &outside,
        );
        for (x, found) in outside.iter().zip(found) {
            assert!(found.pressure.is_nan(), "{x:?}");
            assert!(found.velocity.iter().all(|u| u.is_nan()), "{x:?}");
        }
    }
}
