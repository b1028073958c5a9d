//! What the tests of the structural solver share.
#![allow(dead_code)]

pub mod radial;

use fsi_driver::Vec3;
use fsi_driver::case::Material;
use fsi_driver::geometry::{HexFace, HexMesh, HexShape};
use fsi_driver::paper::convergence::cases::TestCase;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Media and adventitia of table 1 of the paper.
pub fn artery() -> Vec<Material> {
    TestCase::Circular.materials()
}

/// Reproducible numbers in [-1, 1].
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub fn vector(&mut self, n: usize, size: f64) -> Vec<f64> {
        (0..n).map(|_| size * self.next()).collect()
    }
}

/// Elements with straight edges.
struct Trilinear {
    vertices: Vec<Vec3>,
    hexes: Vec<[usize; 8]>,
}

impl HexShape for Trilinear {
    fn position(&self, element: usize, xi: [f64; 3]) -> Vec3 {
        let weight = |v: usize| -> f64 {
            (0..3)
                .map(|d| {
                    if v >> d & 1 == 1 {
                        0.5 + 0.5 * xi[d]
                    } else {
                        0.5 - 0.5 * xi[d]
                    }
                })
                .product()
        };
        (0..8)
            .map(|v| self.vertices[self.hexes[element][v]] * weight(v))
            .sum()
    }
}

/// All faces of a mesh that belong to one element only.
pub fn boundary(hexes: &[[usize; 8]]) -> Vec<(usize, HexFace)> {
    let mut faces: BTreeMap<Vec<usize>, Vec<(usize, HexFace)>> = BTreeMap::new();
    for (e, hex) in hexes.iter().enumerate() {
        for axis in 0..3u8 {
            for upper in [false, true] {
                let on_face = (0..8).filter(|v| (v >> axis & 1 == 1) == upper);
                let mut key: Vec<usize> = on_face.map(|v| hex[v]).collect();
                key.sort_unstable();
                faces
                    .entry(key)
                    .or_default()
                    .push((e, HexFace { axis, upper }));
            }
        }
    }
    faces
        .into_values()
        .filter(|f| f.len() == 1)
        .flatten()
        .collect()
}

/// The 24 orders of an element's vertices that keep it right-handed.
pub fn rotations() -> Vec<[usize; 8]> {
    let mut all = Vec::new();
    for axes in [
        [0, 1, 2],
        [1, 2, 0],
        [2, 0, 1],
        [1, 0, 2],
        [0, 2, 1],
        [2, 1, 0],
    ] {
        let odd = axes[1] != (axes[0] + 1) % 3;
        for flips in 0..8usize {
            if (flips.count_ones() % 2 == 1) == odd {
                all.push(std::array::from_fn(|v| {
                    (0..3).map(|d| ((v >> d ^ flips >> d) & 1) << axes[d]).sum()
                }));
            }
        }
    }
    all
}

/// A box of `counts` elements, its inner vertices moved by `distortion` of the size of an element, its elements turned
/// at random. The surface `boundary` is the whole boundary.
pub fn distorted_box(counts: [usize; 3], distortion: f64, turned: bool) -> HexMesh {
    let mut numbers = Numbers(11);
    let [na, nb, nc] = counts;
    let vertex = |i: usize, j: usize, k: usize| i + (na + 1) * (j + (nb + 1) * k);
    let mut vertices = Vec::new();
    for k in 0..=nc {
        for j in 0..=nb {
            for i in 0..=na {
                let index = [i, j, k];
                vertices.push(Vec3::from_fn(|d, _| {
                    let inner = (0..3).all(|d| index[d] > 0 && index[d] < counts[d]);
                    let moved = if inner {
                        distortion * numbers.next()
                    } else {
                        0.0
                    };
                    (index[d] as f64 + moved) / counts[d] as f64
                }));
            }
        }
    }
    let orders = rotations();
    let mut hexes = Vec::new();
    for k in 0..nc {
        for j in 0..nb {
            for i in 0..na {
                let hex: [usize; 8] = std::array::from_fn(|v| {
                    vertex(i + (v & 1), j + (v >> 1 & 1), k + (v >> 2 & 1))
                });
                let order = orders[(12.0 + 11.99 * numbers.next()) as usize];
                hexes.push(if turned { order.map(|v| hex[v]) } else { hex });
            }
        }
    }
    let surfaces = BTreeMap::from([("boundary".to_string(), boundary(&hexes))]);
    HexMesh {
        directions: fsi_driver::geometry::WallDirections::Local,
        shape: Arc::new(Trilinear {
            vertices: vertices.clone(),
            hexes: hexes.clone(),
        }),
        regions: vec![0; hexes.len()],
        vertices,
        hexes,
        surfaces,
    }
}
