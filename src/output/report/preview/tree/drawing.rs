//! The lumen and the wall around it as triangles and lines.

use super::super::{CELL, EDGE, FIBRE};
use super::Drawn;
use crate::Vec3;
use crate::case::Material;
use crate::geometry::HexMesh;
use std::collections::{HashMap, HashSet};

/// Pieces of a side of an element in the picture and in the view to rotate.
pub const PIECES: usize = 4;
/// The wall is left out where it faces the eye: from this cosine of the angle on.
const OPEN: f64 = 0.25;
/// Half of the length of a fibre, in radii.
const LONG: f64 = 0.25;

/// Triangles with what they are (materials, then the lumen), and lines.
#[derive(Default)]
pub struct Drawing {
    /// Corners, m.
    pub points: Vec<Vec3>,
    /// Numbers of the corners.
    pub triangles: Vec<[u32; 3]>,
    /// What each of these is of.
    pub parts: Vec<usize>,
    /// Straight lines (m) with their colours.
    pub lines: Vec<([Vec3; 2], [u8; 3])>,
}

impl Drawing {
    /// Whether fibres are drawn: they are of the outermost layer, which may have none.
    pub fn has_fibres(&self) -> bool {
        self.lines.iter().any(|(_, colour)| *colour == FIBRE)
    }
}

impl Drawn<'_> {
    /// The lumen, and the wall where it does not hide that from somebody who looks from `eye`: all of it, or what lies
    /// within a ball (middle and radius, m).
    pub fn drawing(&self, eye: &Vec3, ball: Option<(Vec3, f64)>) -> Drawing {
        let is_within = |x: &Vec3| ball.is_none_or(|(middle, radius)| (x - middle).norm() < radius);
        let mut drawing = Drawing::default();
        let surface = self.domain.surface();
        let mut numbers: HashMap<usize, u32> = HashMap::new();
        for name in &self.domain.wet_patches {
            let faces = surface.patch_faces(name).iter();
            let is_drawn = |face: &&Vec<usize>| face.iter().all(|i| is_within(&surface.points[*i]));
            for face in faces.filter(is_drawn) {
                let corners: Vec<u32> = (face.iter())
                    .map(|i| {
                        *numbers.entry(*i).or_insert_with(|| {
                            drawing.points.push(surface.points[*i]);
                            drawing.points.len() as u32 - 1
                        })
                    })
                    .collect();
                for i in 1..corners.len() - 1 {
                    drawing
                        .triangles
                        .push([corners[0], corners[i], corners[i + 1]]);
                    drawing.parts.push(self.names.len());
                }
                for (i, a) in face.iter().enumerate() {
                    let b = face[(i + 1) % face.len()];
                    if *a < b {
                        drawing
                            .lines
                            .push(([surface.points[*a], surface.points[b]], CELL));
                    }
                }
            }
        }
        if self.case.has_elastic_wall() {
            self.wall(eye, &is_within, &mut drawing);
        }
        drawing
    }

    fn wall(&self, eye: &Vec3, is_within: &dyn Fn(&Vec3) -> bool, drawing: &mut Drawing) {
        let mesh = &self.domain.solid;
        let middle = self.middle();
        let is_kept = |e: &usize| {
            let mut corners = mesh.hexes[*e].iter().map(|i| &mesh.vertices[*i]);
            if !corners.all(is_within) {
                return false;
            }
            let x = mesh.shape.position(*e, [0.0; 3]);
            let (centre, radius) = middle(&x);
            (x - centre).dot(eye) < OPEN * radius
        };
        let kept: Vec<usize> = (0..mesh.hexes.len()).filter(is_kept).collect();
        // Faces that two of them share are within the wall.
        let mut faces: HashMap<[usize; 4], Vec<(usize, usize, bool)>> = HashMap::new();
        for &e in &kept {
            for (axis, upper) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
                let corners = (0..8).filter(|v| (v >> axis & 1 == 1) == upper);
                let mut corners: Vec<usize> = corners.map(|v| mesh.hexes[e][v]).collect();
                corners.sort_unstable();
                let key = [corners[0], corners[1], corners[2], corners[3]];
                faces.entry(key).or_default().push((e, axis, upper));
            }
        }
        let inner = mesh.surfaces.get("inner").into_iter().flatten();
        let inner: HashSet<(usize, usize, bool)> = inner
            .map(|(e, face)| (*e, face.axis as usize, face.upper))
            .collect();
        let mut single: Vec<(usize, usize, bool)> = (faces.into_values())
            .filter(|all| all.len() == 1 && !inner.contains(&all[0]))
            .map(|all| all[0])
            .collect();
        single.sort_unstable();
        for (e, axis, upper) in single {
            self.face(e, axis, upper, drawing);
            if (axis, upper) == (2, true) {
                self.fibres(
                    mesh,
                    e,
                    middle(&mesh.shape.position(e, [0.0; 3])).1,
                    drawing,
                );
            }
        }
    }

    /// Points of a face of an element, row by row, where it is cut into pieces.
    pub fn lattice(&self, e: usize, axis: usize, upper: bool) -> Vec<Vec3> {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let along = |i: usize| 2.0 * i as f64 / PIECES as f64 - 1.0;
        let n = PIECES + 1;
        let at = |k: usize| {
            let mut xi = [if upper { 1.0 } else { -1.0 }; 3];
            (xi[a], xi[b]) = (along(k % n), along(k / n));
            self.domain.solid.shape.position(e, xi)
        };
        (0..n * n).map(at).collect()
    }

    /// A face of an element in pieces, with its edges.
    fn face(&self, e: usize, axis: usize, upper: bool, drawing: &mut Drawing) {
        let points = self.lattice(e, axis, upper);
        let first = drawing.points.len() as u32;
        let n = PIECES + 1;
        drawing.points.extend(&points);
        for k in (0..n * n).filter(|k| k % n < PIECES && k / n < PIECES) {
            let corner = |k: usize| first + k as u32;
            let [p, q, r, s] = [k, k + 1, k + n + 1, k + n].map(corner);
            drawing.triangles.extend([[p, q, r], [p, r, s]]);
            drawing.parts.extend([self.domain.solid.regions[e]; 2]);
        }
        let at = |i: usize, j: usize| points[j * n + i];
        for i in 0..PIECES {
            for side in [0, PIECES] {
                drawing.lines.push(([at(i, side), at(i + 1, side)], EDGE));
                drawing.lines.push(([at(side, i), at(side, i + 1)], EDGE));
            }
        }
    }

    /// Both families of fibres in the middle of an outer face.
    fn fibres(&self, mesh: &HexMesh, e: usize, radius: f64, drawing: &mut Drawing) {
        let Some(Material::HolzapfelGasserOgden {
            fibre_angle_deg, ..
        }) = self.domain.materials.get(mesh.regions[e])
        else {
            return;
        };
        let xi = [0.0, 0.0, 1.0];
        let h = 1e-3;
        let slope = |k: usize| {
            let (mut low, mut high) = (xi, xi);
            (low[k], high[k]) = (xi[k] - h, xi[k] + h);
            (mesh.shape.position(e, high) - mesh.shape.position(e, low)) / (2.0 * h)
        };
        let [along, around] = mesh
            .directions
            .tangents(e, xi, slope(0), slope(1))
            .map(|t| t.normalize());
        let x = mesh.shape.position(e, xi);
        let (sin, cos) = fibre_angle_deg.to_radians().sin_cos();
        for family in [1.0, -1.0] {
            let arm = (around * cos + along * (family * sin)) * (LONG * radius);
            drawing.lines.push(([x - arm, x + arm], FIBRE));
        }
    }
}
