//! Elements in the lumen of a vessel: an O-grid of a few quadrilaterals, swept along the centre-line.
//!
//! All nodes of a cross-section follow from those on the wall, by a fixed blend: rings of nodes lie between the wall
//! and the section's centre, the square in the middle is spanned by its four sides. The same blend makes the unloaded
//! mesh and moves it, so the mesh depends on the wall's displacement alone, not on the way there.

use super::basis::Basis;
use super::lumen_mesh::LumenMesh;
use super::taylor_hood_space::{Boundary, Face, Plane, Side, TaylorHoodSpace};
use crate::Vec3;
use crate::fluid::FluidInterface;
use crate::fluid::field::equally_spaced;
use crate::geometry::o_grid::ring_point;
use crate::geometry::{AxialNumbers, Span, Vessel, elastic_pieces};
use crate::lagrange;
use fsi_numerics::{Layers, subdivided};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
use std::ops::Range;

/// Distance of the square's corners from the centre, relative to the lumen's radius.
const CORNER: f64 = 0.7;
/// Shape of the square's sides: 0 straight, 1 arcs of a circle.
const BULGE: f64 = 0.5;

/// Widths of elements as shares of the radius, for so many along a side of the square and from there to the wall: of
/// those in the middle, and of those at the wall where they are widest.
pub(crate) fn element_widths(core: usize, radial: usize) -> [f64; 2] {
    let side = CORNER * ((1.0 - BULGE) * FRAC_PI_4.cos() + BULGE);
    [2.0 * side / core as f64, (1.0 - side) / radial as f64]
}

/// Numbers of elements, and their degree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeshResolution {
    /// Degree of the velocity.
    pub degree: usize,
    /// Elements along a side of the square in the middle, and a quarter of those around.
    pub core: usize,
    /// Elements from the square to the wall.
    pub radial: usize,
    /// Elements along the rigid extension.
    pub axial_extension: usize,
    /// Elements along the graft, and as many along the artery; along ten radii of other vessels.
    pub axial_per_section: usize,
}

/// Numbering and shape of the nodes of one degree in a cross-section.
#[derive(Debug, Clone)]
struct SectionNodes {
    /// Nodes along a side of the square, less one.
    side: usize,
    /// Place of each of these along the side, from 0 to 1.
    along: Vec<f64>,
    /// Distance of the rings of nodes from the square (0) to the wall (1).
    rings: Vec<f64>,
}

impl SectionNodes {
    /// For elements whose nodes lie at `nodes` in [-1, 1].
    fn new(resolution: &MeshResolution, nodes: &[f64]) -> Self {
        Self {
            side: resolution.core * (nodes.len() - 1),
            along: subdivided(resolution.core, nodes),
            rings: subdivided(resolution.radial, nodes),
        }
    }

    fn around(&self) -> usize {
        4 * self.side
    }

    fn nodes(&self) -> usize {
        (self.side + 1).pow(2) + self.around() * (self.rings.len() - 1)
    }

    fn core_node(&self, i: usize, j: usize) -> usize {
        j * (self.side + 1) + i
    }

    /// Node `a` around ring `ring`: see [`ring_point`].
    fn ring_node(&self, ring: usize, a: usize) -> usize {
        ring_point(self.side, ring, a)
    }

    /// Angle of the nodes `a` of all rings.
    fn angle(&self, a: usize) -> f64 {
        -FRAC_PI_4 + FRAC_PI_2 * ((a / self.side) as f64 + self.along[a % self.side])
    }

    /// Quadrilaterals and, as patch 0, the sides on the wall.
    fn plane(&self, resolution: &MeshResolution, degree: usize) -> Plane {
        let mut plane = Plane {
            nodes: self.nodes(),
            quads: Vec::new(),
            edges: Vec::new(),
        };
        let each = |f: &dyn Fn(usize, usize) -> usize| -> Vec<usize> {
            let n = degree + 1;
            (0..n * n).map(|k| f(k % n, k / n)).collect()
        };
        for y in 0..resolution.core {
            for x in 0..resolution.core {
                let node = |i, j| self.core_node(x * degree + i, y * degree + j);
                plane.quads.push(each(&node));
            }
        }
        for ring in 0..resolution.radial {
            for a in 0..4 * resolution.core {
                if ring + 1 == resolution.radial {
                    let outer = Side {
                        axis: 0,
                        upper: true,
                    };
                    plane.edges.push((plane.quads.len(), outer, 0));
                }
                let node = |i, j| self.ring_node(ring * degree + i, a * degree + j);
                plane.quads.push(each(&node));
            }
        }
        plane
    }

    /// Places all nodes of a section from those on the wall.
    fn place(&self, wall: &[Vec3], at: &mut [Vec3]) {
        let (n, around) = (self.side, self.around());
        // Mean over the angle, by the trapezoidal rule
        let centre: Vec3 = (0..around)
            .map(|a| {
                let to = self.angle((a + 1) % around);
                let from = self.angle((a + around - 1) % around);
                wall[a] * (0.5 * (to - from).rem_euclid(TAU) / TAU)
            })
            .sum();
        for a in 0..around {
            let from_middle_of_side = FRAC_PI_4 * (2.0 * self.along[a % n] - 1.0);
            let straight = FRAC_PI_4.cos() / from_middle_of_side.cos();
            let core = CORNER * ((1.0 - BULGE) * straight + BULGE);
            for (ring, t) in self.rings.iter().enumerate() {
                let share = core * (1.0 - t) + t;
                at[self.ring_node(ring, a)] = centre + (wall[a] - centre) * share;
            }
        }
        // Coons' transfinite interpolation of the four sides
        for j in 1..n {
            for i in 1..n {
                let (s, t) = (self.along[i], self.along[j]);
                let p = |i, j| at[self.core_node(i, j)];
                let sides = p(i, 0) * (1.0 - t) + p(i, n) * t + p(0, j) * (1.0 - s) + p(n, j) * s;
                let corners = (p(0, 0) * (1.0 - t) + p(0, n) * t) * (1.0 - s)
                    + (p(n, 0) * (1.0 - t) + p(n, n) * t) * s;
                at[self.core_node(i, j)] = sides - corners;
            }
        }
    }
}

/// The mesh of a vessel's lumen, and the lattice of points on its deformable wall: as many equal parts per element and
/// direction as the degree, so that a polynomial of this degree is known by its values there.
#[derive(Debug, Clone)]
pub struct VesselMesh {
    resolution: MeshResolution,
    /// Layers of elements with an elastic wall.
    elastic: Range<usize>,
    section: SectionNodes,
    /// Numbering of the unknowns.
    space: TaylorHoodSpace,
    /// The unloaded wall's nodes, layer by layer, m.
    wall: Vec<Vec3>,
    interface: FluidInterface,
    /// Row `i`: values at node `i` of an element's side from those at the lattice's points on it.
    from_lattice: Vec<Vec<f64>>,
}

impl VesselMesh {
    /// The mesh in a vessel.
    pub fn new(vessel: &Vessel, resolution: MeshResolution) -> Self {
        let MeshResolution { degree, core, .. } = resolution;
        let basis = Basis::new(degree);
        let section = SectionNodes::new(&resolution, &basis.nodes.points);
        let pressure_section = SectionNodes::new(&resolution, &basis.pressure_nodes.points);
        let line = vessel.centre_line();
        let spans = vessel.spans(AxialNumbers::of_spectral_elements(
            resolution.axial_extension,
            resolution.axial_per_section,
        ));
        let elastic = elastic_pieces(&spans);
        let stations = |nodes: &[f64]| -> Vec<f64> {
            let mut stations = vec![f64::NAN];
            for Span {
                from, to, pieces, ..
            } in &spans
            {
                stations.pop();
                let places = subdivided(*pieces, nodes);
                stations.extend(places.iter().map(|t| from + (to - from) * t));
            }
            stations
        };
        let surface = |s: f64, phi: f64| {
            let r = vessel.lumen_radius(s, phi);
            line.frame(s).point(r * phi.cos(), r * phi.sin())
        };
        let around = section.around();
        let wall = (stations(&basis.nodes.points).iter())
            .flat_map(|&s| (0..around).map(move |a| (s, a)))
            .map(|(s, a)| surface(s, section.angle(a)))
            .collect();

        let uniform = equally_spaced(degree);
        let all = stations(&uniform);
        let rings = &all[elastic.start * degree..=elastic.end * degree];
        let angle = |a: f64| -FRAC_PI_4 + FRAC_PI_2 * a / (core * degree) as f64;
        let points: Vec<Vec3> = (rings.iter())
            .flat_map(|&s| (0..around).map(move |a| (s, a)))
            .map(|(s, a)| surface(s, angle(a as f64)))
            .collect();
        let (mut faces, mut face_centres) = (Vec::new(), Vec::new());
        let order = Layers { each: around };
        for ring in 0..rings.len() - 1 {
            for a in 0..around {
                let at = |ring: usize, a: usize| order.number(ring, a % around) as u32;
                faces.push(vec![
                    at(ring, a),
                    at(ring, a + 1),
                    at(ring + 1, a + 1),
                    at(ring + 1, a),
                ]);
                let middle = 0.5 * (rings[ring] + rings[ring + 1]);
                face_centres.push(surface(middle, angle(a as f64 + 0.5)));
            }
        }
        let layers = spans.iter().map(|span| span.pieces).sum();
        Self {
            space: TaylorHoodSpace::swept(
                &section.plane(&resolution, degree),
                &pressure_section.plane(&resolution, degree - 1),
                degree,
                layers,
            ),
            from_lattice: (basis.nodes.points.iter())
                .map(|&x| lagrange::values(&uniform, x))
                .collect(),
            interface: FluidInterface {
                points,
                faces,
                face_centres,
            },
            resolution,
            elastic,
            section,
            wall,
        }
    }

    /// The order of the elements' faces on the wall.
    fn mantle(&self) -> Layers {
        Layers {
            each: 4 * self.resolution.core,
        }
    }

    /// The order of points and faces of the wall.
    fn rings(&self) -> Layers {
        Layers {
            each: self.section.around(),
        }
    }
}

impl LumenMesh for VesselMesh {
    fn space(&self) -> &TaylorHoodSpace {
        &self.space
    }

    /// The deformable wall as a lattice, ring by ring downstream; its faces have the elements' own order: all around,
    /// then the next ring.
    fn interface(&self) -> &FluidInterface {
        &self.interface
    }

    fn moving_walls(&self) -> Vec<Face> {
        let walls = self
            .space
            .faces_of(|patch| matches!(patch, Boundary::Mantle(_)));
        walls[self.mantle().numbers(self.elastic.clone())].to_vec()
    }

    fn parts(&self) -> Vec<(usize, usize)> {
        let degree = self.resolution.degree;
        let mantle = self.mantle();
        let part = |face: usize| {
            let [ring, a] = self.rings().place(face);
            let element = mantle.number(ring / degree, a / degree);
            (element, ring % degree * degree + a % degree)
        };
        (0..self.interface.faces.len()).map(part).collect()
    }

    fn elastic_elements(&self) -> Range<usize> {
        let MeshResolution { core, radial, .. } = self.resolution;
        let layers = Layers {
            each: core * core + 4 * core * radial,
        };
        layers.numbers(self.elastic.clone())
    }

    fn positions(&self, displacement: &[Vec3]) -> Vec<f64> {
        let (degree, around) = (self.resolution.degree, self.rings().each);
        let mut wall = self.wall.clone();
        let [first, last] = [self.elastic.start, self.elastic.end].map(|layer| layer * degree);
        let deformable = &mut wall[self.rings().numbers(first..last + 1)];
        let rings = deformable.len() / around;
        let rows = deformable.par_chunks_mut(around).enumerate();
        rows.for_each(|(k, row)| {
            let (layer, i) = element_and_node(k, rings - 1, degree);
            for (a, x) in row.iter_mut().enumerate() {
                let (part, j) = (a / degree, a % degree);
                for (l, along) in self.from_lattice[i].iter().enumerate() {
                    let ring = (layer * degree + l) * around;
                    for (m, across) in self.from_lattice[j].iter().enumerate() {
                        let point = ring + (part * degree + m) % around;
                        *x += displacement[point] * (along * across);
                    }
                }
            }
        });
        let plane = self.section.nodes();
        let mut nodes = vec![Vec3::zeros(); self.space.nodes];
        (nodes.par_chunks_mut(plane).zip(wall.par_chunks(around)))
            .for_each(|(section, wall)| self.section.place(wall, section));
        let component = |c: usize| nodes.iter().map(move |x| x[c]);
        (0..3).flat_map(component).collect()
    }
}

/// The element, and the node in it, of node `k` of a row of elements that ends with node `last`.
fn element_and_node(k: usize, last: usize, degree: usize) -> (usize, usize) {
    if k == last {
        (k / degree - 1, degree)
    } else {
        (k / degree, k % degree)
    }
}
