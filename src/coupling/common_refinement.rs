//! The common refinement of two meshes of one surface, and an interpolation between them that conserves forces.
//!
//! Each face of the wall is cut with the faces of the fluid next to it, in the plane of its mean normal. The force of a
//! face of the fluid is divided between the faces of the wall in proportion to the areas that they share, so the forces
//! on the wall add up to those of the fluid, whatever the meshes (Jaiman, Jiao, Geubelle, Loth, *Conservative load
//! transfer along curved fluid-solid interface with non-matching meshes*, J. Comput. Phys. 218, 2006). Within a face of
//! the wall the load varies as the pointwise interpolation says.

use super::interpolation::{AGREEMENT, Interpolation, Sources, SparseRow};
use crate::Vec3;
use crate::fluid::FluidInterface;
use crate::pfem::SurfacePoint;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// Faces lie next to each other if they are not farther apart than this share of the size of the larger one.
const BESIDE: f64 = 0.25;
/// A face of the wall counts as covered if its area differs by at most this share from that of the fluid's faces next
/// to it: facets differ a little from the curved face that they stand for.
const COVERED: f64 = 1e-2;
/// With less than this share covered, the load is taken for constant on a face: the interpolation would extrapolate.
const MOSTLY: f64 = 0.9;

/// Which part of each face of the fluid lies next to which face of the wall.
#[derive(Debug, Clone)]
pub struct CommonRefinement {
    faces: Vec<WallFace>,
    /// Area (m²) of each face of the fluid.
    areas: Vec<f64>,
    /// Area (m²) of the fluid's faces that lie next to no face of the wall.
    lost: f64,
}

/// A face of the wall.
#[derive(Debug, Clone)]
struct WallFace {
    /// Its quadrature points.
    points: Range<usize>,
    centre: Vec3,
    /// Area, m².
    area: f64,
    /// The same seen along the mean normal, m².
    shadow: f64,
    /// Area of the fluid's faces next to it over its own, both seen along its mean normal.
    covered: f64,
    pieces: Vec<Overlap>,
}

/// The part of a face of the fluid that lies next to a face of the wall.
#[derive(Debug, Clone)]
struct Overlap {
    /// The face of the fluid.
    face: usize,
    /// Its area, m²; in the end over the area of all pieces of this face.
    share: f64,
    /// Cosine between the normals of the two faces.
    cosine: f64,
    centre: Vec3,
}

impl CommonRefinement {
    /// Of the fluid's faces and those of the wall with these `outlines`, to which the quadrature `points` belong in
    /// order, as many to each.
    pub(super) fn new(
        fluid: &FluidInterface,
        sources: &Sources,
        outlines: &[Vec<Vec3>],
        points: &[SurfacePoint],
    ) -> Self {
        let at_rest = vec![Vec3::zeros(); fluid.points.len()];
        let areas: Vec<f64> = (fluid.face_areas(&at_rest).iter())
            .map(Vec3::norm)
            .collect();
        let each = points.len() / outlines.len().max(1);
        let cut = |(number, outline): (usize, &Vec<Vec3>)| {
            WallFace::cut(
                fluid,
                sources,
                outline,
                number * each..(number + 1) * each,
                points,
            )
        };
        let mut faces: Vec<WallFace> = outlines.par_iter().enumerate().map(cut).collect();
        let mut totals = vec![0.0; fluid.faces.len()];
        let pieces = faces.iter().flat_map(|face| &face.pieces);
        pieces.for_each(|piece| totals[piece.face] += piece.share);
        for face in &mut faces {
            let mut covered = 0.0;
            for piece in &mut face.pieces {
                piece.share /= totals[piece.face];
                covered += piece.share * areas[piece.face] * piece.cosine;
            }
            face.covered = covered / face.shadow;
            if (face.covered - 1.0).abs() <= COVERED {
                face.covered = 1.0;
            }
        }
        let lost = areas
            .iter()
            .zip(&totals)
            .filter(|(_, total)| **total == 0.0);
        Self {
            lost: lost.map(|(area, _)| area).sum(),
            faces,
            areas,
        }
    }

    /// Share of the wall's area that has no face of the fluid next to it, and carries no load.
    pub fn uncovered(&self) -> f64 {
        let bare = |face: &WallFace| (1.0 - face.covered).max(0.0) * face.area;
        let area: f64 = self.faces.iter().map(|face| face.area).sum();
        self.faces.iter().map(bare).sum::<f64>() / area
    }

    /// Two corners (m) of a box around the middles of the faces of the wall of which less than half is covered.
    pub fn bare_place(&self) -> Option<[Vec3; 2]> {
        let bare = self.faces.iter().filter(|face| face.covered < 0.5);
        let around = |[low, high]: [Vec3; 2], x: Vec3| [low.inf(&x), high.sup(&x)];
        let centres = bare.map(|face| face.centre);
        centres
            .map(|x| [x, x])
            .reduce(|found, [x, _]| around(found, x))
    }

    /// Share of the fluid's wetted area that has no face of the wall next to it, and whose load is lost.
    pub fn lost(&self) -> f64 {
        self.lost / self.areas.iter().sum::<f64>()
    }

    /// The `pointwise` interpolation to the wall's quadrature `points`, with what its mean on each face of the wall
    /// lacks of the mean of the fluid's faces next to it.
    pub(super) fn conserving(
        &self,
        pointwise: &Interpolation,
        fluid: &FluidInterface,
        sources: &Sources,
        points: &[SurfacePoint],
    ) -> Interpolation {
        let mut centres = vec![Vec3::zeros(); fluid.faces.len()];
        for piece in self.faces.iter().flat_map(|face| &face.pieces) {
            centres[piece.face] += piece.share * piece.centre;
        }
        let rows = |face: &WallFace| -> Vec<SparseRow> {
            let mut change = Weights::default();
            self.add_mean(face, fluid, sources, &centres, &mut change);
            if face.covered > MOSTLY {
                let range = face.points.clone();
                let area: f64 = points[range.clone()].iter().map(|point| point.area).sum();
                for (row, point) in pointwise.rows[range.clone()].iter().zip(&points[range]) {
                    change.add(row, -point.area / area);
                }
            }
            let at_point = |point: usize| {
                let mut weights = change.clone();
                if face.covered > MOSTLY {
                    weights.add(&pointwise.rows[point], 1.0);
                }
                let weights = weights.0.into_iter();
                weights
                    .map(|(source, weight)| (source, face.covered * weight))
                    .collect()
            };
            face.points.clone().map(at_point).collect()
        };
        Interpolation {
            rows: self.faces.par_iter().flat_map_iter(rows).collect(),
        }
    }

    /// Adds the mean of the load on the pieces next to a face of the wall. On a face of the fluid that lies next to
    /// several, the load is taken for linear, about the middle of all its pieces (`centres`).
    fn add_mean(
        &self,
        face: &WallFace,
        fluid: &FluidInterface,
        sources: &Sources,
        centres: &[Vec3],
        mean: &mut Weights,
    ) {
        let area = |piece: &Overlap| piece.share * self.areas[piece.face];
        let total: f64 = face.pieces.iter().map(area).sum();
        for piece in &face.pieces {
            let weight = area(piece) / total;
            mean.add(&[(piece.face, 1.0)], weight);
            if piece.share < 1.0 {
                let centre = &fluid.face_centres[piece.face];
                let at = centre + (piece.centre - centres[piece.face]);
                mean.add(&sources.weights(piece.face, centre, &at), weight);
                mean.add(&sources.weights(piece.face, centre, centre), -weight);
            }
        }
    }
}

/// Sums of weights by source.
#[derive(Clone, Default)]
struct Weights(BTreeMap<usize, f64>);

impl Weights {
    fn add(&mut self, row: &[(usize, f64)], factor: f64) {
        for (source, weight) in row {
            *self.0.entry(*source).or_default() += factor * weight;
        }
    }
}

impl WallFace {
    /// Cuts a face of the wall with all that lies next to it; shares are areas (m²) still.
    fn cut(
        fluid: &FluidInterface,
        sources: &Sources,
        outline: &[Vec3],
        points: Range<usize>,
        all_points: &[SurfacePoint],
    ) -> Self {
        let own = &all_points[points.clone()];
        let normal = own
            .iter()
            .map(|point| point.normal * point.area)
            .sum::<Vec3>();
        let normal = normal.try_normalize(0.0).unwrap_or_else(Vec3::z);
        let centre = outline.iter().sum::<Vec3>() / outline.len() as f64;
        let plane = Plane::new(centre, normal);
        let arms = outline.iter().map(|x| (x - centre).norm());
        let radius = arms.fold(0.0, f64::max);
        let polygon: Vec<[f64; 2]> = outline.iter().map(|x| plane.flat(x)).collect();
        let heights: Vec<([f64; 2], f64)> = (own.iter())
            .map(|point| (plane.flat(&point.position), plane.height(&point.position)))
            .collect();
        // How high the wall lies at its quadrature point nearest to `at`.
        let height = |at: [f64; 2]| {
            let distance = |x: &[f64; 2]| (x[0] - at[0]).hypot(x[1] - at[1]);
            let nearest = heights
                .iter()
                .min_by(|a, b| distance(&a.0).total_cmp(&distance(&b.0)));
            nearest.map_or(0.0, |(_, height)| *height)
        };
        let piece = |(face, middle): (usize, &Vec3)| {
            let away = (middle - centre).norm() - radius;
            let cosine = -sources.normals[face].dot(&normal);
            let corners = &fluid.faces[face];
            let corner = |i: usize| fluid.points[corners[i % corners.len()] as usize];
            let reach = sources.reach[face];
            if away > reach || cosine < AGREEMENT {
                return None;
            }
            let (mut area, mut moment) = (0.0, [0.0; 2]);
            for i in 0..corners.len() {
                let triangle = [*middle, corner(i), corner(i + 1)].map(|x| plane.flat(&x));
                let (part, at) = area_and_centre(&clipped(&polygon, triangle));
                area += part;
                moment = [moment[0] + part * at[0], moment[1] + part * at[1]];
            }
            if area <= 0.0 {
                return None;
            }
            let flat = moment.map(|moment| moment / area);
            // The place on the face itself.
            let above = plane.lifted(flat);
            let rise = sources.normals[face].dot(&(middle - above)) / -cosine;
            let is_near = (rise - height(flat)).abs() <= BESIDE * radius.max(reach);
            is_near.then(|| Overlap {
                face,
                share: area / cosine,
                cosine,
                centre: above + rise * normal,
            })
        };
        let faces = fluid.face_centres.iter().enumerate();
        Self {
            points,
            centre,
            area: own.iter().map(|point| point.area).sum(),
            shadow: area_and_centre(&polygon).0,
            covered: 0.0,
            pieces: faces.filter_map(piece).collect(),
        }
    }
}

/// A plane with two directions in it.
struct Plane {
    origin: Vec3,
    directions: [Vec3; 2],
    normal: Vec3,
}

impl Plane {
    fn new(origin: Vec3, normal: Vec3) -> Self {
        let aside = Vec3::ith(normal.iamin(), 1.0);
        let first = normal.cross(&aside).normalize();
        Self {
            origin,
            directions: [first, normal.cross(&first)],
            normal,
        }
    }

    /// Coordinates in the plane.
    fn flat(&self, x: &Vec3) -> [f64; 2] {
        self.directions
            .map(|direction| direction.dot(&(x - self.origin)))
    }

    fn height(&self, x: &Vec3) -> f64 {
        self.normal.dot(&(x - self.origin))
    }

    fn lifted(&self, [x, y]: [f64; 2]) -> Vec3 {
        self.origin + x * self.directions[0] + y * self.directions[1]
    }
}

/// Twice the signed area of a triangle, positive counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The part of a polygon within a triangle (Sutherland and Hodgman 1974).
fn clipped(polygon: &[[f64; 2]], mut triangle: [[f64; 2]; 3]) -> Vec<[f64; 2]> {
    let sense = turn(triangle[0], triangle[1], triangle[2]);
    if sense == 0.0 {
        return Vec::new();
    }
    if sense < 0.0 {
        triangle.swap(1, 2);
    }
    let mut rest = polygon.to_vec();
    for i in 0..3 {
        let (from, to) = (triangle[i], triangle[(i + 1) % 3]);
        let mut kept = Vec::with_capacity(rest.len() + 2);
        for (j, &b) in rest.iter().enumerate() {
            let a = rest[(j + rest.len() - 1) % rest.len()];
            let (side_a, side_b) = (turn(from, to, a), turn(from, to, b));
            if (side_a < 0.0) != (side_b < 0.0) {
                let t = side_a / (side_a - side_b);
                kept.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
            }
            if side_b >= 0.0 {
                kept.push(b);
            }
        }
        rest = kept;
    }
    rest
}

/// Area of a polygon, whatever its sense, and its centre of area.
fn area_and_centre(polygon: &[[f64; 2]]) -> (f64, [f64; 2]) {
    let Some(&first) = polygon.first() else {
        return (0.0, [0.0; 2]);
    };
    let (mut twice, mut moment) = (0.0, [0.0; 2]);
    for pair in polygon.windows(2) {
        let part = turn(first, pair[0], pair[1]);
        twice += part;
        for (i, moment) in moment.iter_mut().enumerate() {
            *moment += part * (first[i] + pair[0][i] + pair[1][i]) / 3.0;
        }
    }
    match twice == 0.0 {
        true => (0.0, first),
        false => (0.5 * twice.abs(), moment.map(|moment| moment / twice)),
    }
}
