//! Structured hexahedra through the wall of a tube around the x-axis, or around any centre-line.
//!
//! The wall is a stack of layers between surfaces `r_0(x, φ) < r_1(x, φ) < …`, with `φ` turning from +y to +z. The
//! local coordinates of an element run along +x (0), around the circumference (1) and outward (2). For these to be
//! right-handed the circumferential one runs *against* `φ`: `e_x × (-e_φ) = e_r`.

use super::{HexFace, HexMesh, HexShape};
use crate::Vec3;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Surfaces around the x-axis, or around a centre-line with the arc length `x`, star-shaped in every cross-section.
pub trait Surfaces: Send + Sync {
    /// Radius (m) of surface `index`, counted from the lumen outward, at the axial position `x` (m) and angle `phi`.
    fn radius(&self, index: usize, x: f64, phi: f64) -> f64;

    /// The point (m) of the cross-section at `x` with the coordinates `y` and `z` in its plane.
    fn point(&self, x: f64, y: f64, z: f64) -> Vec3 {
        Vec3::new(x, y, z)
    }
}

/// Where the elements of a wall begin and end.
#[derive(Debug, Clone, PartialEq)]
pub struct WallGrid {
    /// Axial positions of the element boundaries, increasing, m.
    pub stations: Vec<f64>,
    /// Elements around the circumference, at least 3.
    pub circumferential: usize,
    /// Elements through each layer.
    pub radial_per_layer: usize,
    /// Number of layers; there is one more surface.
    pub layers: usize,
}

impl WallGrid {
    fn axial(&self) -> usize {
        self.stations.len() - 1
    }

    fn radial(&self) -> usize {
        self.layers * self.radial_per_layer
    }

    /// Hexahedra between `surfaces`; `region(axial element, layer)` names the material.
    ///
    /// # Panics
    /// If the grid has no element, or fewer than three around the circumference.
    pub fn mesh(
        self,
        surfaces: Arc<dyn Surfaces>,
        region: impl Fn(usize, usize) -> usize,
    ) -> HexMesh {
        let (na, nc, nr) = (self.axial(), self.circumferential, self.radial());
        assert!(
            na > 0 && nc >= 3 && nr > 0,
            "a wall needs an element in every direction, and three around"
        );
        let vertex = |i: usize, j: usize, k: usize| (i * nc + j % nc) * (nr + 1) + k;
        let (mut hexes, mut regions) = (Vec::new(), Vec::new());
        let mut named: [Vec<(usize, HexFace)>; 4] = Default::default();
        let [inner, outer, start, end] = &mut named;
        for i in 0..na {
            for j in 0..nc {
                for k in 0..nr {
                    let element = hexes.len();
                    hexes.push(std::array::from_fn(|v| {
                        vertex(i + (v & 1), j + (v >> 1 & 1), k + (v >> 2 & 1))
                    }));
                    regions.push(region(i, k / self.radial_per_layer));
                    let name = |here: bool, list: &mut Vec<_>, axis, upper| {
                        if here {
                            list.push((element, HexFace { axis, upper }));
                        }
                    };
                    name(k == 0, inner, 2, false);
                    name(k == nr - 1, outer, 2, true);
                    name(i == 0, start, 0, false);
                    name(i == na - 1, end, 0, true);
                }
            }
        }
        let names = ["inner", "outer", "start", "end"].map(String::from);
        let surface_lists: BTreeMap<_, _> = names.into_iter().zip(named).collect();
        let shape = WallShape {
            grid: self,
            surfaces,
        };
        let mut vertices = vec![Vec3::zeros(); (na + 1) * nc * (nr + 1)];
        for (element, hex) in hexes.iter().enumerate() {
            for (v, &index) in hex.iter().enumerate() {
                let corner = [v & 1, v >> 1 & 1, v >> 2 & 1].map(|bit| 2.0 * bit as f64 - 1.0);
                vertices[index] = shape.position(element, corner);
            }
        }
        HexMesh {
            vertices,
            hexes,
            regions,
            surfaces: surface_lists,
            directions: super::WallDirections::Local,
            shape: Arc::new(shape),
        }
    }
}

/// Shape of the elements of a [`WallGrid`]: `x` and `φ` are linear in the local coordinates, and so is the radius
/// between the two surfaces of the layer.
struct WallShape {
    grid: WallGrid,
    surfaces: Arc<dyn Surfaces>,
}

impl HexShape for WallShape {
    fn position(&self, element: usize, xi: [f64; 3]) -> Vec3 {
        let (nc, nr, per_layer) = (
            self.grid.circumferential,
            self.grid.radial(),
            self.grid.radial_per_layer,
        );
        let [s, t, w] = xi.map(|coordinate| 0.5 * (1.0 + coordinate));
        let (i, j, k) = (element / (nc * nr), element / nr % nc, element % nr);
        let x = (1.0 - s) * self.grid.stations[i] + s * self.grid.stations[i + 1];
        // Element nc-1 ends at the angle where element 0 begins: the same floating-point number for both.
        let turn = (j as f64 + t) / nc as f64;
        let phi = -TAU * if turn >= 1.0 { turn - 1.0 } else { turn };
        let layer = k / per_layer;
        let depth = ((k % per_layer) as f64 + w) / per_layer as f64;
        let [below, above] = [layer, layer + 1].map(|index| self.surfaces.radius(index, x, phi));
        let radius = (1.0 - depth) * below + depth * above;
        (self.surfaces).point(x, radius * phi.cos(), radius * phi.sin())
    }
}

/// `n + 1` equally spaced stations from `start` to `end`.
pub fn equal_stations(start: f64, end: f64, n: usize) -> Vec<f64> {
    (0..=n)
        .map(|i| {
            if i == n {
                end
            } else {
                start + (end - start) * i as f64 / n as f64
            }
        })
        .collect()
}

/// A straight circular tube of several layers along the x-axis from x = 0, for verification; the region of an element
/// is the index of its layer, counted from the inside. Lengths in m.
///
/// ```
/// // The two-layer artery of the paper's first test case, initial mesh 2 × 4 × 2.
/// let mesh = fsi_pfem::mesh::tube_mesh(3e-3, &[0.5e-3, 0.5e-3], 10e-3, 2, 4, 1);
/// assert_eq!(mesh.hexes.len(), 16);
/// assert_eq!(mesh.surfaces["inner"].len(), 8);
/// ```
///
/// # Panics
/// If there is no layer, no element in some direction, or fewer than three around the circumference.
pub fn tube_mesh(
    inner_radius: f64,
    layer_thickness: &[f64],
    length: f64,
    axial: usize,
    circumferential: usize,
    radial_per_layer: usize,
) -> HexMesh {
    struct Circular(Vec<f64>);
    impl Surfaces for Circular {
        fn radius(&self, index: usize, _x: f64, _phi: f64) -> f64 {
            self.0[index]
        }
    }
    let radii = std::iter::once(inner_radius)
        .chain(
            layer_thickness
                .iter()
                .scan(inner_radius, |radius, thickness| {
                    *radius += thickness;
                    Some(*radius)
                }),
        )
        .collect();
    let grid = WallGrid {
        stations: equal_stations(0.0, length, axial),
        circumferential,
        radial_per_layer,
        layers: layer_thickness.len(),
    };
    grid.mesh(Arc::new(Circular(radii)), |_, layer| layer)
}
