//! The flow at points that stay where they are, while the mesh moves over them.
//!
//! A point is looked for in the elements near it by Newton's method on the mapping `x(ξ) = Σ lᵢ(ξ) xᵢ`; where all
//! `|ξ_d| <= 1`, velocity and pressure are the values of their own polynomials there.

use super::spectral_elements::SpectralElements;
use crate::Vec3;
use crate::fluid::FluidProbe;
use crate::fluid::lagrange_cell::{Extent, LagrangeCell, find};

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
    let position = |node: usize| space.vector(positions, node);
    let elements = || (0..space.space.elements).map(|e| element(space, e));
    let extents: Vec<Extent> = elements().map(|cell| cell.extent(&position)).collect();
    let of_point = |x: &Vec3| {
        let Some((e, xi)) = find(elements().zip(&extents), &position, x) else {
            return FluidProbe {
                pressure: f64::NAN,
                velocity: Vec3::repeat(f64::NAN),
            };
        };
        let field = |node: usize| space.vector(velocity, node);
        let pressures = LagrangeCell {
            rule: &space.basis.pressure_nodes.points,
            nodes: space.space.element_pressures(e),
        };
        let shapes = pressures.shapes(&xi).into_iter();
        FluidProbe {
            pressure: (pressures.nodes.iter().zip(shapes))
                .map(|(&node, shape)| shape * pressure[node as usize])
                .sum(),
            velocity: element(space, e).value(&field, &xi),
        }
    };
    points.iter().map(of_point).collect()
}

/// An element with the nodes of its velocity.
fn element(space: &SpectralElements, e: usize) -> LagrangeCell<'_> {
    LagrangeCell {
        rule: &space.basis.nodes.points,
        nodes: space.space.element(e),
    }
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

    /// A linear velocity is met on a bent mesh and smooth fields the better the higher the degree.
    #[test]
    fn velocity_converges_on_a_bent_mesh() {
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
                element(&space, e).value(&|i| space.vector(&positions, i), &xi)
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
    fn points_outside_are_undefined() {
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
