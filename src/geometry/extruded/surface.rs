//! The wet patches of a fluid's mesh as one surface: its points, faces, rims, normals, radii.

use super::grouping::Quads;
use crate::Vec3;
use crate::geometry::PolyMesh;
use rayon::prelude::*;
use rstar::RTree;
use std::collections::{BTreeMap, HashMap};

/// Points whose balls are found one after the other.
const IN_TURN: usize = 64;

/// Why a wall cannot grow from the patches.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    /// There is no such patch.
    #[error("the mesh has no patch {name:?}; it has \"{}\"", .known.join("\", \""))]
    NoPatch {
        /// The name.
        name: String,
        /// Those that there are.
        known: Vec<String>,
    },
    /// It has no faces.
    #[error("the patch {0:?} has no faces")]
    Empty(String),
    /// A face has more or fewer than four corners.
    #[error(
        "a face of the patch {patch:?} near ({:.4e}, {:.4e}, {:.4e}) m has {corners} corners; a wall can grow from quadrilaterals \
         only: give the wall in a file (wall.file)", .near.x, .near.y, .near.z
    )]
    NoQuadrilateral {
        /// The patch.
        patch: String,
        /// The number of corners.
        corners: usize,
        /// Where.
        near: Vec3,
    },
}

/// The wet surface with what lies around it.
#[derive(Debug, Clone, PartialEq)]
pub struct WetQuads {
    /// Points and faces; normals point out of the fluid, into the wall.
    pub quads: Quads,
    /// The patch of each face, by its place among their names.
    pub patches: Vec<usize>,
    /// Each edge of the rim, in the sense in which its face runs through it, with the patch beyond.
    pub rim: BTreeMap<(usize, usize), String>,
}

impl PolyMesh {
    /// Faces of the patch of that name.
    ///
    /// # Errors
    /// If it is missing or empty.
    pub fn wet_faces(&self, name: &str) -> Result<&[Vec<usize>], SurfaceError> {
        if self.patch(name).is_none() {
            return Err(SurfaceError::NoPatch {
                name: name.into(),
                known: self.patches.iter().map(|p| p.name.clone()).collect(),
            });
        }
        match self.patch_faces(name) {
            [] => Err(SurfaceError::Empty(name.into())),
            faces => Ok(faces),
        }
    }
}

impl WetQuads {
    /// The patches of these names.
    ///
    /// # Errors
    /// If one is missing or empty, or a face has not four corners.
    pub fn new(mesh: &PolyMesh, names: &[String]) -> Result<Self, SurfaceError> {
        let mut numbers = HashMap::new();
        let (mut points, mut faces, mut patches) = (Vec::new(), Vec::new(), Vec::new());
        for (patch, name) in names.iter().enumerate() {
            for face in mesh.wet_faces(name)? {
                let corners = face.iter().map(|&point| {
                    *numbers.entry(point).or_insert_with(|| {
                        points.push(mesh.points[point]);
                        points.len() - 1
                    })
                });
                let corners: Vec<usize> = corners.collect();
                let corners = corners.try_into().map_err(|corners: Vec<usize>| {
                    SurfaceError::NoQuadrilateral {
                        patch: name.clone(),
                        corners: corners.len(),
                        near: points[corners[0]],
                    }
                })?;
                faces.push(corners);
                patches.push(patch);
            }
        }
        let quads = Quads { points, faces };
        let mut beyond = HashMap::new();
        for patch in mesh.patches.iter().filter(|p| !names.contains(&p.name)) {
            for face in mesh.patch_faces(&patch.name) {
                for (i, a) in face.iter().enumerate() {
                    let b = &face[(i + 1) % face.len()];
                    if let (Some(a), Some(b)) = (numbers.get(a), numbers.get(b)) {
                        beyond.insert((*a.min(b), *a.max(b)), patch.name.clone());
                    }
                }
            }
        }
        let mut open: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        for face in &quads.faces {
            for k in 0..4 {
                let (a, b) = (face[k], face[(k + 1) % 4]);
                if open.remove(&(b, a)).is_none() {
                    open.insert((a, b), 0);
                }
            }
        }
        let rim = open.into_keys().filter_map(|(a, b)| {
            let patch = beyond.get(&(a.min(b), a.max(b)))?;
            Some(((a, b), patch.clone()))
        });
        Ok(Self {
            rim: rim.collect(),
            quads,
            patches,
        })
    }

    /// Outward unit normals at the points, with weights that are exact for points on a sphere: Max, *Weights for
    /// computing vertex normals from facet normals*, J. Graphics Tools 4 (1999); then `passes` times averaged with
    /// those of the points at the other ends of edges, which count half.
    pub fn normals(&self, passes: usize) -> Vec<Vec3> {
        let (points, faces) = (&self.quads.points, &self.quads.faces);
        let mut sums = vec![Vec3::zeros(); points.len()];
        for face in faces {
            for k in 0..4 {
                let at = points[face[k]];
                let next = points[face[(k + 1) % 4]] - at;
                let previous = points[face[(k + 3) % 4]] - at;
                let weight = next.norm_squared() * previous.norm_squared();
                sums[face[k]] += next.cross(&previous) / weight.max(f64::MIN_POSITIVE);
            }
        }
        let mut normals: Vec<Vec3> = sums.iter().map(Vec3::normalize).collect();
        let around = self.points_around();
        for _ in 0..passes {
            let average = |(own, around): (&Vec3, &Vec<usize>)| {
                let others: Vec3 = around.iter().map(|&p| normals[p]).sum();
                (own + others / around.len().max(1) as f64).normalize()
            };
            normals = normals.iter().zip(&around).map(average).collect();
        }
        normals
    }

    /// Unit normals of the planes in which the rims lie, by the patches there.
    pub(super) fn rim_normals(&self) -> BTreeMap<&str, Vec3> {
        let mut corners: BTreeMap<&str, Vec<(Vec3, Vec3)>> = BTreeMap::new();
        for ((a, b), patch) in &self.rim {
            let edge = (self.quads.points[*a], self.quads.points[*b]);
            corners.entry(patch).or_default().push(edge);
        }
        let normal = |edges: Vec<(Vec3, Vec3)>| {
            let origin = edges[0].0;
            let area = |(a, b): &(Vec3, Vec3)| (a - origin).cross(&(b - origin));
            edges.iter().map(area).sum::<Vec3>().normalize()
        };
        let all = corners.into_iter();
        all.map(|(patch, edges)| (patch, normal(edges))).collect()
    }

    /// Values at the points, of which each patch has one at each of its points, `value(patch, point)`: where patches
    /// meet, halfway between the smallest and the largest.
    pub fn by_patch(&self, value: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        let mut ranges = vec![(f64::INFINITY, f64::NEG_INFINITY); self.quads.points.len()];
        for (face, &patch) in self.quads.faces.iter().zip(&self.patches) {
            for &point in face {
                let (least, most) = &mut ranges[point];
                let value = value(patch, point);
                (*least, *most) = (least.min(value), most.max(value));
            }
        }
        let middle = |(least, most): (f64, f64)| 0.5 * (least + most);
        ranges.into_iter().map(middle).collect()
    }

    /// The points at the other ends of the edges of each point.
    pub fn points_around(&self) -> Vec<Vec<usize>> {
        let mut around = vec![Vec::new(); self.quads.points.len()];
        for face in &self.quads.faces {
            for k in 0..4 {
                let (a, b) = (face[k], face[(k + 1) % 4]);
                around[a].push(b);
                around[b].push(a);
            }
        }
        for of_point in &mut around {
            of_point.sort_unstable();
            of_point.dedup();
        }
        around
    }

    /// Radius (m) of the largest ball that touches the surface at each point from within and holds no other point of
    /// it: the radius of a tube, and about that of the lumen where there is none. A ball that is too large shrinks
    /// until it touches the point nearest to its centre, and so on (Ma, Bae and Choi, The Visual Computer 28, 2012).
    pub fn radii(&self, normals: &[Vec3]) -> Vec<f64> {
        let points = &self.quads.points;
        let tree = RTree::bulk_load(points.iter().map(|x| [x.x, x.y, x.z]).collect());
        // Larger than any ball that two points say.
        let largest = (points.iter())
            .map(|x| (x - points[0]).norm())
            .fold(0.0, f64::max);
        let radius = |x: &Vec3, n: &Vec3, touched: &mut Option<Vec3>| {
            let touching = |y: &Vec3| {
                let d = y - x;
                let depth = -d.dot(n);
                // Of two points on a ball with the normal n at x: |d|² = 2 r depth.
                (depth > 1e-9 * d.norm()).then(|| d.norm_squared() / (2.0 * depth))
            };
            let known = touched.as_ref().and_then(touching);
            let known = known.filter(|radius| *radius < largest);
            let (mut radius, mut is_touched) = (known.unwrap_or(largest), known.is_some());
            loop {
                let centre = x - n * radius;
                let nearest = tree.nearest_neighbor([centre.x, centre.y, centre.z]);
                let nearest = nearest.map(|y| Vec3::from(*y));
                let smaller = nearest.as_ref().and_then(touching);
                match smaller.filter(|smaller| *smaller < radius) {
                    Some(smaller) => {
                        (radius, is_touched) = (smaller, true);
                        *touched = nearest;
                    }
                    None if is_touched => return radius,
                    // So flat that its ball is larger than the surface, or open.
                    None => {
                        let radii = points.iter().filter_map(touching);
                        return radii.fold(f64::INFINITY, f64::min);
                    }
                }
            }
        };
        // What the ball of a point touches is near what that of the next one does: a ball that touches it is hardly too
        // large. One that is as large as the vessel shrinks often, and what is nearest to a place far away is found
        // slowly.
        let in_turn = |(points, normals): (&[Vec3], &[Vec3])| -> Vec<f64> {
            let mut touched = None;
            let pairs = points.iter().zip(normals);
            pairs.map(|(x, n)| radius(x, n, &mut touched)).collect()
        };
        let groups = points.par_chunks(IN_TURN).zip(normals.par_chunks(IN_TURN));
        groups.flat_map_iter(in_turn).collect()
    }
}
