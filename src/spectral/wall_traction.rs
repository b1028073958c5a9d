//! What the fluid does to the wall.

use super::shear_thinning::rate_of_shear;
use super::spectral_elements::SpectralElements;
use super::surface::face_values;
use super::taylor_hood_space::{Face, Side};
use crate::Vec3;
use crate::rheology::Rheology;
use fsi_numerics::lagrange;
use nalgebra::Matrix3;
use rayon::prelude::*;

/// Pressure, and viscous stress, on a part of the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallLoad {
    /// Pressure, Pa.
    pub pressure: f64,
    /// Viscous part of the load of the fluid on the wall, `-mu n·dev(2 sym ∇u)`, Pa; **n** points out of the fluid.
    pub shear: Vec3,
}

/// Positions in [-1, 1] of the middles of as many equal parts as the degree.
pub fn middles(degree: usize) -> Vec<f64> {
    (0..degree)
        .map(|i| (2.0 * i as f64 + 1.0) / degree as f64 - 1.0)
        .collect()
}

/// The load at the middles of the parts of each face (see [`middles`]), fastest along the face's first axis. All faces
/// lie on the outer side of the first local axis. `reactions` is `mu ∂u/∂n` at the nodes
/// ([`Flow::viscous_reactions`](super::Flow::viscous_reactions)); without it, it is taken from the gradients within the
/// elements.
pub fn wall_loads(
    space: &SpectralElements,
    faces: &[Face],
    rheology: &Rheology,
    positions: &[f64],
    velocity: &[f64],
    pressure: &[f64],
    reactions: Option<&[f64]>,
) -> Vec<Vec<WallLoad>> {
    let n = space.basis.nodes.len();
    let n3 = space.node_count();
    let nodes = &space.basis.nodes.points;
    let at = middles(space.basis.degree());
    let rows = |points: &[f64], f: fn(&[f64], f64) -> Vec<f64>| -> Vec<Vec<f64>> {
        at.iter().map(|&x| f(points, x)).collect()
    };
    let (values, slopes) = (
        rows(nodes, lagrange::values),
        rows(nodes, lagrange::derivatives),
    );
    let pressure_values = rows(&space.basis.pressure_nodes.points, lagrange::values);
    let across = &space.basis.nodal_derivative[n - 1];
    let outer = Side {
        axis: 0,
        upper: true,
    };
    (faces.par_iter())
        .map(|&face| {
            assert_eq!(face.side, outer, "walls lie on the outer side");
            // Derivatives along the three local axes at the middles
            let derivatives = |field: &[f64]| -> [Vec<Vec3>; 3] {
                let mut local = vec![0.0; 3 * n3];
                space.gather(face.element, field, &mut local);
                let value = |i: usize| Vec3::new(local[i], local[n3 + i], local[2 * n3 + i]);
                // Nodes on the side, and the derivative across it there
                let on: Vec<Vec3> = (0..n * n).map(|k| value(k * n + n - 1)).collect();
                let through: Vec<Vec3> = (0..n * n)
                    .map(|k| (0..n).map(|i| value(k * n + i) * across[i]).sum())
                    .collect();
                [
                    face_values(&values, &values, &through),
                    face_values(&slopes, &values, &on),
                    face_values(&values, &slopes, &on),
                ]
            };
            let x = derivatives(positions);
            let u = derivatives(velocity);
            let p: Vec<f64> = space
                .face_pressures(face)
                .into_iter()
                .map(|i| pressure[i])
                .collect();
            let p = face_values(&pressure_values, &pressure_values, &p);
            let reactions = reactions.map(|reactions| {
                let nodes = space.face_nodes(face).into_iter();
                let nodal: Vec<Vec3> = nodes.map(|i| space.vector(reactions, i)).collect();
                face_values(&values, &values, &nodal)
            });
            (0..p.len())
                .map(|k| {
                    let columns =
                        |d: &[Vec<Vec3>; 3]| Matrix3::from_columns(&[d[0][k], d[1][k], d[2][k]]);
                    let inverse = columns(&x).try_inverse().unwrap_or_else(Matrix3::zeros);
                    let gradient = columns(&u) * inverse; // ∂u_i/∂x_j
                    let normal = x[1][k].cross(&x[2][k]).normalize();
                    let strain = gradient + gradient.transpose();
                    let viscosity = rheology.viscosity(rate_of_shear(&gradient));
                    let deviator = strain - Matrix3::identity() * (strain.trace() / 3.0);
                    let mut shear = -viscosity * (deviator * normal);
                    if let Some(reactions) = &reactions {
                        // Along the wall only: what the pressure lacks there is not viscous
                        let other = viscosity * (gradient * normal) - reactions[k];
                        shear += other - normal * other.dot(&normal);
                    }
                    WallLoad {
                        pressure: p[k],
                        shear,
                    }
                })
                .collect()
        })
        .collect()
}
