//! A loaded part of the boundary: quadrature points, forces of pressure and shear, stiffness of pressure.
//!
//! With `x_1`, `x_2` the tangents of the deformed face along its two local directions, chosen so that `s x_1 × x_2`
//! points out of the solid (`s = ±1`), a pressure `p` on the deformed area exerts
//! ```text
//! f_a  = -∫ p s N_a x_1 × x_2 dξ dη,
//! K^{ij}_ab = ∫ p s N_a ε_ijk (N_b,1 x_2k - N_b,2 x_1k) dξ dη            (∂(-f)/∂d; its symmetric part is used)
//! ```
//! (Bonet and Wood, *Nonlinear Continuum Mechanics for Finite Element Analysis*, 1997, section 8.5). The stiffness of a
//! constant pressure is symmetric if the edge of the surface is clamped or slides in a plane.

use super::super::SolidError;
use super::super::solid::{SurfaceLoad, SurfacePoint};
use super::super::space::numbering::Numbering;
use super::super::space::{Mode, Space};
use super::super::supports::modes_on_face;
use super::PAIRS;
use super::mapping::{MappedLattice, Mapping};
use crate::Vec3;
use crate::mesh::HexFace;
use fsi_numerics::quadrature::Rule;
use fsi_numerics::words;
use std::collections::HashMap;

words! {
    /// The area on which a load acts.
    #[derive(Default)]
    pub enum LoadKind {
        /// Per deformed area; pressure follows the deformed normal.
        Follower = "follower" (default),
        /// Per reference area; pressure keeps the reference normal.
        Dead = "dead",
    }
}

/// The modes that do not vanish on one of the six faces, at its quadrature points.
#[derive(Debug, Clone)]
struct FaceShapes {
    /// Local modes of the element.
    modes: Vec<usize>,
    /// `[points][modes]`: value and derivatives along the two directions of the face.
    values: Vec<Vec<[f64; 3]>>,
    /// Places of the points in the lattice of [`face_axes`], and their weights.
    points: Vec<(usize, f64)>,
    /// Orientation `s`.
    outward: f64,
}

/// Quadrature over a part of the boundary.
#[derive(Debug, Clone)]
pub struct Surface {
    /// The faces.
    pub faces: Vec<(usize, HexFace)>,
    shapes: HashMap<HexFace, FaceShapes>,
    /// Quadrature points, face by face.
    pub points: Vec<SurfacePoint>,
    /// Reference tangents at the points.
    tangents: Vec<[Vec3; 2]>,
    points_per_face: usize,
    of_element: HashMap<usize, Vec<usize>>,
}

/// The two directions of a face in the order that makes `g_1 × g_2` point along its positive axis.
pub fn directions(face: HexFace) -> [usize; 2] {
    [[1, 2], [2, 0], [0, 1]][face.axis as usize]
}

/// Point of the element at coordinates `(a, b)` of a face.
pub fn on_face(face: HexFace, a: f64, b: f64) -> [f64; 3] {
    let [first, second] = directions(face);
    let mut xi = [if face.upper { 1.0 } else { -1.0 }; 3];
    (xi[first], xi[second]) = (a, b);
    xi
}

/// The lattice of points in an element that lie `along` both directions of a face.
fn face_axes(face: HexFace, along: &[f64]) -> [&[f64]; 3] {
    let mut axes = [along; 3];
    axes[face.axis as usize] = if face.upper { &[1.0] } else { &[-1.0] };
    axes
}

/// Value of a mode at a point of a face, and its derivatives along the face's two directions.
pub fn mode_on_face(mode: Mode, space: &Space, face: HexFace, xi: [f64; 3]) -> [f64; 3] {
    let tables: [(Vec<f64>, Vec<f64>); 3] = std::array::from_fn(|d| {
        super::super::space::basis::shape_functions(space.degrees[d], xi[d])
    });
    let product = |derived: Option<usize>| -> f64 {
        (0..3)
            .map(|d| {
                let (values, derivatives) = &tables[d];
                if derived == Some(d) {
                    derivatives[mode[d]]
                } else {
                    values[mode[d]]
                }
            })
            .product()
    };
    let [first, second] = directions(face);
    [product(None), product(Some(first)), product(Some(second))]
}

impl Surface {
    /// Prepares `points` × `points` Gauss quadrature on the faces.
    pub fn new(
        numbering: &Numbering,
        space: &Space,
        mapping: &Mapping,
        faces: &[(usize, HexFace)],
        points: usize,
    ) -> Result<Self, SolidError> {
        let rule = Rule::gauss_legendre(points);
        let mut shapes: HashMap<HexFace, FaceShapes> = HashMap::new();
        let mut lattices: HashMap<HexFace, MappedLattice> = HashMap::new();
        let mut surface_points = Vec::new();
        let mut tangents = Vec::new();
        let mut of_element: HashMap<usize, Vec<usize>> = HashMap::new();
        for (index, &(element, face)) in faces.iter().enumerate() {
            of_element.entry(element).or_default().push(index);
            let table = shapes
                .entry(face)
                .or_insert_with(|| FaceShapes::new(numbering, space, face, &rule));
            let lattice = lattices.entry(face);
            let mapped = lattice.or_insert_with(|| mapping.on(face_axes(face, &rule.points)));
            let mapped = mapped(element);
            for &(place, weight) in &table.points {
                let mapped = &mapped[place];
                let [t1, t2] = directions(face).map(|d| Vec3::from(mapped.jacobian.column(d)));
                let normal = t1.cross(&t2) * table.outward;
                let jacobian = normal.norm();
                if jacobian.is_nan() || jacobian <= 0.0 {
                    return Err(SolidError::Inverted {
                        element,
                        jacobian,
                        position: mapped.position.into(),
                    });
                }
                surface_points.push(SurfacePoint {
                    position: mapped.position,
                    normal: normal / jacobian,
                    area: weight * jacobian,
                });
                tangents.push([t1, t2]);
            }
        }
        Ok(Self {
            faces: faces.to_vec(),
            shapes,
            points: surface_points,
            tangents,
            points_per_face: points * points,
            of_element,
        })
    }

    /// The same faces of a body of another shape.
    pub fn reshaped(
        &self,
        numbering: &Numbering,
        space: &Space,
        mapping: &Mapping,
    ) -> Result<Self, SolidError> {
        Self::new(numbering, space, mapping, &self.faces, self.points_along())
    }

    /// Gauss points along either direction of a face.
    pub fn points_along(&self) -> usize {
        self.points_per_face.isqrt()
    }

    /// Forces of a load on the surface, added to `forces`.
    pub fn add_forces(
        &self,
        numbering: &Numbering,
        displacement: &[f64],
        load: &SurfaceLoad,
        kind: LoadKind,
        forces: &mut [f64],
    ) {
        for (face, &(element, orientation)) in self.faces.iter().enumerate() {
            let shapes = &self.shapes[&orientation];
            let functions = &numbering.of_element[element];
            let signs = &numbering.signs[element];
            for q in 0..self.points_per_face {
                let point = face * self.points_per_face + q;
                let [x1, x2] = match kind {
                    LoadKind::Follower => self.tangents(numbering, displacement, face, q),
                    LoadKind::Dead => self.tangents[point],
                };
                let normal = x1.cross(&x2) * shapes.outward;
                let shear = load.shear[point] * normal.norm();
                let force = (shear - normal * load.pressure[point]) * shapes.points[q].1;
                for (&m, value) in shapes.modes.iter().zip(&shapes.values[q]) {
                    if let Some(f) = functions[m] {
                        let scale = signs[m] * value[0];
                        (0..3).for_each(|i| forces[3 * f + i] += scale * force[i]);
                    }
                }
            }
        }
    }

    /// Symmetric part of the stiffness of a following pressure on the faces of one element, added to its blocks of
    /// [`PAIRS`].
    pub fn add_stiffness(
        &self,
        numbering: &Numbering,
        displacement: &[f64],
        load: &SurfaceLoad,
        element: usize,
        blocks: &mut [f64],
    ) {
        let n = numbering.modes.len();
        for &face in self.of_element.get(&element).into_iter().flatten() {
            let shapes = &self.shapes[&self.faces[face].1];
            for q in 0..self.points_per_face {
                let [x1, x2] = self.tangents(numbering, displacement, face, q);
                let pressure = load.pressure[face * self.points_per_face + q];
                let scale = 0.5 * pressure * shapes.outward * shapes.points[q].1;
                // ε_ijk for the pairs (0, 1), (0, 2), (1, 2).
                for (pair, k, sign) in [(3, 2, 1.0), (4, 1, -1.0), (5, 0, 1.0)] {
                    debug_assert_eq!(PAIRS[pair].0 + PAIRS[pair].1 + k, 3);
                    let block = &mut blocks[pair * n * n..(pair + 1) * n * n];
                    let (a, b) = (sign * scale * x2[k], sign * scale * x1[k]);
                    for (&m_b, [v_b, b_1, b_2]) in shapes.modes.iter().zip(&shapes.values[q]) {
                        let slope_b = a * b_1 - b * b_2;
                        for (&m_a, [v_a, a_1, a_2]) in shapes.modes.iter().zip(&shapes.values[q]) {
                            block[m_a + n * m_b] += v_a * slope_b - v_b * (a * a_1 - b * a_2);
                        }
                    }
                }
            }
        }
    }

    /// Values (m, m/s) of a field of coefficients at all points.
    pub fn values(&self, numbering: &Numbering, field: &[f64]) -> Vec<Vec3> {
        let at_point = |point: usize| -> Vec3 {
            let (element, shapes, q) = self.place(point);
            let (functions, signs) = (&numbering.of_element[element], &numbering.signs[element]);
            let modes = shapes.modes.iter().zip(&shapes.values[q]);
            let parts = modes.filter_map(|(&m, value)| {
                let f = 3 * functions[m]?;
                Some(Vec3::new(field[f], field[f + 1], field[f + 2]) * (signs[m] * value[0]))
            });
            parts.sum()
        };
        (0..self.points.len()).map(at_point).collect()
    }

    /// Adds forces (N) at all points to those of the coefficients.
    pub fn add_point_forces(&self, numbering: &Numbering, at_points: &[Vec3], forces: &mut [f64]) {
        for (point, force) in at_points.iter().enumerate() {
            let (element, shapes, q) = self.place(point);
            for (&m, value) in shapes.modes.iter().zip(&shapes.values[q]) {
                if let Some(f) = numbering.of_element[element][m] {
                    let scale = numbering.signs[element][m] * value[0];
                    (0..3).for_each(|i| forces[3 * f + i] += scale * force[i]);
                }
            }
        }
    }

    /// Visits the points on the faces of one element, each with the modes that do not vanish there and their values.
    pub fn visit(&self, element: usize, mut visitor: impl FnMut(usize, &[(usize, f64)])) {
        for &face in self.of_element.get(&element).into_iter().flatten() {
            for point in face * self.points_per_face..(face + 1) * self.points_per_face {
                let (_, shapes, q) = self.place(point);
                let values = shapes.modes.iter().zip(&shapes.values[q]);
                let functions: Vec<_> = values.map(|(&m, value)| (m, value[0])).collect();
                visitor(point, &functions);
            }
        }
    }

    /// Element and shapes of a point, and its number on its face.
    fn place(&self, point: usize) -> (usize, &FaceShapes, usize) {
        let (face, q) = (point / self.points_per_face, point % self.points_per_face);
        let (element, orientation) = self.faces[face];
        (element, &self.shapes[&orientation], q)
    }

    /// Deformed area vectors (normal out of the body times area, quadrature weight included, m²) at all points.
    pub fn deformed_areas(&self, numbering: &Numbering, displacement: &[f64]) -> Vec<Vec3> {
        (0..self.points.len())
            .map(|point| {
                let (face, q) = (point / self.points_per_face, point % self.points_per_face);
                let [x1, x2] = self.tangents(numbering, displacement, face, q);
                let shapes = &self.shapes[&self.faces[face].1];
                x1.cross(&x2) * (shapes.outward * shapes.points[q].1)
            })
            .collect()
    }

    /// By how much the surface is stretched and turned between two displacements: root mean square, over all points, of
    /// the change of its tangents relative to their length.
    pub fn change(&self, numbering: &Numbering, from: &[f64], to: &[f64]) -> f64 {
        let changes = (0..self.points.len()).map(|point| {
            let (face, q) = (point / self.points_per_face, point % self.points_per_face);
            let [from, to] = [from, to].map(|d| self.tangents(numbering, d, face, q));
            let share = |i: usize| (to[i] - from[i]).norm_squared() / from[i].norm_squared();
            share(0) + share(1)
        });
        (changes.sum::<f64>() / self.points.len() as f64).sqrt()
    }

    /// Deformed tangents at point `q` of a face.
    fn tangents(
        &self,
        numbering: &Numbering,
        displacement: &[f64],
        face: usize,
        q: usize,
    ) -> [Vec3; 2] {
        let (element, orientation) = self.faces[face];
        let shapes = &self.shapes[&orientation];
        let functions = &numbering.of_element[element];
        let [mut x1, mut x2] = self.tangents[face * self.points_per_face + q];
        for (&m, value) in shapes.modes.iter().zip(&shapes.values[q]) {
            if let Some(f) = functions[m] {
                let sign = numbering.signs[element][m];
                let d = Vec3::new(
                    displacement[3 * f],
                    displacement[3 * f + 1],
                    displacement[3 * f + 2],
                );
                x1 += d * (sign * value[1]);
                x2 += d * (sign * value[2]);
            }
        }
        [x1, x2]
    }
}

impl FaceShapes {
    fn new(numbering: &Numbering, space: &Space, face: HexFace, rule: &Rule) -> Self {
        let modes: Vec<usize> = modes_on_face(numbering, face).collect();
        let [first, second] = directions(face);
        let sizes = face_axes(face, &rule.points).map(<[f64]>::len);
        let strides = [1, sizes[0], sizes[0] * sizes[1]];
        let (mut points, mut values) = (Vec::new(), Vec::new());
        for (j, (b, wb)) in rule.points.iter().zip(&rule.weights).enumerate() {
            for (i, (a, wa)) in rule.points.iter().zip(&rule.weights).enumerate() {
                points.push((i * strides[first] + j * strides[second], wa * wb));
                let xi = on_face(face, *a, *b);
                let value = |&m: &usize| mode_on_face(numbering.modes[m], space, face, xi);
                values.push(modes.iter().map(value).collect());
            }
        }
        Self {
            modes,
            values,
            points,
            outward: if face.upper { 1.0 } else { -1.0 },
        }
    }
}
