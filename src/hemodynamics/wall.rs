//! The wet surface as a list of faces, in the vessel's coordinates: x along the centre-line, φ around it from its
//! frame's first direction (+y on the x-axis) towards the second (+z).

use super::place::Place;
use super::region::{Region, RegionExtent, is_in_box, share};
use super::rings::Rings;
use crate::Vec3;
use crate::curve::{SpaceCurve, nearest_of};
use crate::geometry::PolyMesh;
use crate::interpolation::Nearest;
use std::collections::{BTreeSet, HashMap};

/// What the fluid does to the wall, and where the wall is, at the end of a step. In single precision, as it is stored:
/// what is computed from it while running is then what is computed from the stored values.
#[derive(Debug, Clone, PartialEq)]
pub struct WallState {
    /// Time, s.
    pub time: f64,
    /// Wall shear stress on each face, Pa.
    pub shear: Vec<[f32; 3]>,
    /// Displacement of each point, m.
    pub displacement: Vec<[f32; 3]>,
}

impl WallState {
    /// Rounds the fields.
    pub fn new(time: f64, shear: &[Vec3], displacement: &[Vec3]) -> Self {
        let round = |v: &Vec3| [v.x, v.y, v.z].map(|c| c as f32);
        Self {
            time,
            shear: shear.iter().map(round).collect(),
            displacement: displacement.iter().map(round).collect(),
        }
    }
}

/// A vector in double precision.
pub fn widened(v: &[f32; 3]) -> Vec3 {
    Vec3::from(v.map(f64::from))
}

/// The unloaded wet surface.
#[derive(Debug, Clone, PartialEq)]
pub struct WetSurface {
    /// Positions of the points, m.
    pub points: Vec<Vec3>,
    /// Points of each face; the normal by the right-hand rule points out of the lumen.
    pub faces: Vec<Vec<u32>>,
    /// The centre-line, or those of the branches.
    lines: Vec<SpaceCurve>,
    /// Which of them each face is around; of a single one nothing is said.
    line_of: Vec<usize>,
    /// Arc length of the centre of each face, m.
    along: Vec<f64>,
    /// The patch that each face belongs to; none where that is not known.
    patches: Vec<String>,
}

/// Area (m²) of a face, and its part of the surface integral of `F·n` (m³), which gives the volume between two
/// cross-sections by the divergence theorem: with the coordinates `y`, `z` in the cross-section, and `q = κ·(y, z)` for
/// the curvature `κ` of the centre-line, `F = (y, z) (1/2 - q/3)/(1 - q)` lies in the cross-section and has the
/// divergence 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Area, m².
    pub area: f64,
    /// Part of the volume, m³.
    pub volume: f64,
}

impl WetSurface {
    /// A surface around the x-axis.
    pub fn new(points: Vec<Vec3>, faces: Vec<Vec<u32>>) -> Self {
        let surface = Self {
            points,
            faces,
            lines: Vec::new(),
            line_of: Vec::new(),
            along: Vec::new(),
            patches: Vec::new(),
        };
        surface.around(SpaceCurve::x_axis(0.0, 1.0))
    }

    /// The same surface around a centre-line.
    #[must_use]
    pub fn around(self, line: SpaceCurve) -> Self {
        let middles = self.middles();
        Self {
            along: middles.map(|middle| line.nearest(&middle).s).collect(),
            lines: vec![line],
            line_of: Vec::new(),
            ..self
        }
    }

    /// The same surface, which is on patches, around the centre-lines of branches, each with the patch of its wall:
    /// each face around the nearest of its patch.
    #[must_use]
    pub fn along_branches(self, lines: &[(String, SpaceCurve)]) -> Self {
        if lines.is_empty() {
            return self;
        }
        let place = |(face, middle): (usize, Vec3)| {
            let all = || lines.iter().map(|(_, line)| line).enumerate();
            let of_patch = all().filter(|(i, _)| self.is_of_patch(face, &lines[*i].0));
            let found = nearest_of(of_patch, &middle).or_else(|| nearest_of(all(), &middle));
            let (line, nearest) = found.expect("there is a line");
            (line, nearest.s)
        };
        let (line_of, along) = self.middles().enumerate().map(place).unzip();
        Self {
            lines: lines.iter().map(|(_, line)| line.clone()).collect(),
            line_of,
            along,
            ..self
        }
    }

    /// The number of the centre-line of a face.
    pub fn line_number(&self, face: usize) -> usize {
        self.line_of.get(face).copied().unwrap_or(0)
    }

    /// The centre-line of a face.
    fn line(&self, face: usize) -> &SpaceCurve {
        &self.lines[self.line_number(face)]
    }

    /// The centre-line of the face nearest to a point (m).
    fn line_at(&self, point: &Vec3) -> &SpaceCurve {
        if self.line_of.is_empty() {
            return &self.lines[0];
        }
        let far = self.middles().map(|middle| (middle - point).norm_squared());
        let nearest = far.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        self.line(nearest.map_or(0, |(face, _)| face))
    }

    /// The same surface, which consists of these patches of a fluid's `mesh` at rest: each face is of the patch that
    /// has a face with its points, or the nearest one.
    #[must_use]
    pub fn on_patches(self, mesh: &PolyMesh, names: &[String]) -> Self {
        let corners = |points: &mut dyn Iterator<Item = &Vec3>| {
            let mut corners: Vec<[u64; 3]> =
                points.map(|x| [x.x, x.y, x.z].map(f64::to_bits)).collect();
            corners.sort_unstable();
            corners
        };
        let faces = names.iter().flat_map(|name| {
            let faces = mesh.patch_faces(name).iter();
            let points = |face: &Vec<usize>| face.iter().map(|&p| mesh.points[p]).collect();
            faces.map(move |face| (name, points(face)))
        });
        let faces: Vec<(&String, Vec<Vec3>)> = faces.collect();
        let known: HashMap<_, &String> = (faces.iter())
            .map(|(name, points)| (corners(&mut points.iter()), *name))
            .collect();
        let middles = faces.iter();
        let middles = middles.map(|(_, points)| points.iter().sum::<Vec3>() / points.len() as f64);
        let nearest = Nearest::of(&middles.collect::<Vec<_>>());
        let patch = |(face, middle): (&Vec<u32>, Vec3)| {
            let mut points = face.iter().map(|&p| &self.points[p as usize]);
            let found = known.get(&corners(&mut points)).copied();
            let nearest = || nearest.to(&middle, |_| true).map(|number| faces[number].0);
            found.or_else(nearest).cloned().unwrap_or_default()
        };
        let patches = self.faces.iter().zip(self.middles()).map(patch).collect();
        Self { patches, ..self }
    }

    /// Centres (m) of the unloaded faces.
    pub fn middles(&self) -> impl Iterator<Item = Vec3> + use<> {
        let middle = |face: &Vec<u32>| {
            let sum: Vec3 = face.iter().map(|&p| self.points[p as usize]).sum();
            sum / face.len() as f64
        };
        let middles: Vec<Vec3> = self.faces.iter().map(middle).collect();
        middles.into_iter()
    }

    /// The place of a point of the unloaded wall, and its distance (m) from the centre-line.
    pub fn place(&self, point: &Vec3) -> (Place, f64) {
        self.place_along(self.line_at(point), point)
    }

    fn place_along(&self, line: &SpaceCurve, point: &Vec3) -> (Place, f64) {
        let found = line.nearest(point);
        let [y, z] = found.across;
        let place = Place {
            x_m: found.s,
            phi_deg: z.atan2(y).to_degrees(),
            position_m: Some((*point).into()),
        };
        (place, y.hypot(z))
    }

    /// Distance (m) from the centre-line of a displaced point of a face.
    pub fn distance(&self, face: usize, position: &Vec3) -> f64 {
        let nearest = self.line(face).nearest_from(position, self.along[face]);
        let [y, z] = nearest.across;
        y.hypot(z)
    }

    /// Centres of the unloaded faces.
    pub fn places(&self) -> Vec<Place> {
        let faces = self.middles().enumerate();
        faces
            .map(|(face, middle)| self.place_along(self.line(face), &middle).0)
            .collect()
    }

    /// Share of each face in a region; faces outside are left out.
    pub fn shares(&self, region: &Region) -> Vec<(usize, f64)> {
        let share = |(number, face): (usize, &Vec<u32>)| match &region.extent {
            RegionExtent::Whole {} => 1.0,
            RegionExtent::Patch { patch } => f64::from(self.is_of_patch(number, patch)),
            RegionExtent::Box { box_m } => {
                let middle: Vec3 = face.iter().map(|&p| self.points[p as usize]).sum();
                f64::from(is_in_box(box_m, &(middle / face.len() as f64)))
            }
            RegionExtent::Along { from_m, to_m } => self.share_along(number, [*from_m, *to_m]),
            RegionExtent::Branch { patch, .. } if !self.is_of_patch(number, patch) => 0.0,
            RegionExtent::Branch { .. } => {
                self.share_along(number, region.along_branch().unwrap_or_default())
            }
        };
        let shares = self.faces.iter().enumerate().map(share).enumerate();
        shares.filter(|(_, share)| *share > 0.0).collect()
    }

    /// Share of a face between two places (m) along its centre-line.
    fn share_along(&self, face: usize, part: [f64; 2]) -> f64 {
        let at = |p: &u32| self.line(face).nearest(&self.points[*p as usize]).s;
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = (self.faces[face].iter().map(at))
            .fold(ends, |(low, high), x| (low.min(x), high.max(x)));
        // At the closed end of a line its last point is the nearest of all.
        match low < high {
            true => share(part, low, high),
            false => f64::from((part[0]..=part[1]).contains(&low)),
        }
    }

    /// Arc length (m) of the centre of a face along its centre-line.
    pub fn along(&self, face: usize) -> f64 {
        self.along[face]
    }

    /// Whether a face belongs to a patch.
    pub fn is_of_patch(&self, face: usize, patch: &str) -> bool {
        self.patches.get(face).is_some_and(|own| own == patch)
    }

    /// The points in a region, in ascending order.
    pub fn points_in(&self, region: &Region) -> Vec<usize> {
        let all = self.points.iter().enumerate();
        let within: Vec<usize> = match &region.extent {
            RegionExtent::Whole {} => all.map(|(i, _)| i).collect(),
            RegionExtent::Box { box_m } => all
                .filter(|(_, x)| is_in_box(box_m, x))
                .map(|(i, _)| i)
                .collect(),
            RegionExtent::Along { from_m, to_m } => all
                .filter(|(_, x)| (*from_m..=*to_m).contains(&self.place(x).0.x_m))
                .map(|(i, _)| i)
                .collect(),
            RegionExtent::Patch { .. } | RegionExtent::Branch { .. } => {
                let faces = self.shares(region).into_iter();
                let points: BTreeSet<u32> = faces
                    .flat_map(|(face, _)| self.faces[face].clone())
                    .collect();
                points.into_iter().map(|p| p as usize).collect()
            }
        };
        within
    }

    /// Volume (m³) that each face has swept outward on the straight ways of its points from rest, in triangles between
    /// each side and the middle. Exact: while its corners move at constant speeds, the area vector of a triangle is
    /// quadratic in time.
    pub fn swept(&self, displacement: &[[f32; 3]]) -> Vec<f64> {
        let swept = |face: &Vec<u32>| {
            let corner = |i: usize| {
                let point = face[i % face.len()] as usize;
                (self.points[point], widened(&displacement[point]))
            };
            let all = (0..face.len()).map(corner);
            let middle = all.fold((Vec3::zeros(), Vec3::zeros()), |sum, (x, u)| {
                (sum.0 + x / face.len() as f64, sum.1 + u / face.len() as f64)
            });
            let of_side = |i: usize| {
                let ((a, u), (b, v)) = (corner(i), corner(i + 1));
                let (a, b) = (a - middle.0, b - middle.0);
                let (da, db) = (u - middle.1, v - middle.1);
                let area = a.cross(&b) + 0.5 * (a.cross(&db) + da.cross(&b)) + da.cross(&db) / 3.0;
                0.5 * area.dot(&(u + v + middle.1)) / 3.0
            };
            (0..face.len()).map(of_side).sum()
        };
        self.faces.iter().map(swept).collect()
    }

    /// Positions (m) of the points that are displaced by `displacement` (m).
    pub fn displaced(&self, displacement: &[[f32; 3]]) -> Vec<Vec3> {
        let pairs = self.points.iter().zip(displacement);
        pairs.map(|(x, u)| x + widened(u)).collect()
    }

    /// Distance (m) of each face from the centre of its cross-section, with the points at `positions` (m). The centre
    /// moves sideways where the vessel bends; it is on the centre-line if the faces do not lie in rings.
    pub fn radii(&self, positions: &[Vec3]) -> Vec<f64> {
        let at = |p: &u32| positions[*p as usize];
        let on_line = self.along.iter().enumerate();
        let mut middles: Vec<Vec3> = on_line
            .map(|(face, s)| self.line(face).frame(*s).origin)
            .collect();
        let rings = match self.line_of.is_empty() {
            true => Rings::new(&self.places()),
            false => None,
        };
        for ring in rings.iter().flat_map(Rings::faces) {
            let centre = |face: &usize| {
                let points = &self.faces[*face];
                points.iter().map(at).sum::<Vec3>() / points.len() as f64
            };
            let middle = ring.iter().map(centre).sum::<Vec3>() / ring.len() as f64;
            ring.iter().for_each(|face| middles[*face] = middle);
        }
        let radius = |(number, ((face, middle), s)): (usize, ((&Vec<u32>, &Vec3), &f64))| {
            let frame = self.line(number).frame(*s);
            let across = face.iter().map(|p| frame.across(&(at(p) - middle)));
            across.map(|[y, z]| y.hypot(z)).sum::<f64>() / face.len() as f64
        };
        let faces = self.faces.iter().zip(&middles).zip(&self.along);
        faces.enumerate().map(radius).collect()
    }

    /// Extents of the faces with the points at `positions` (m): triangles between each side and the middle.
    pub fn extents(&self, positions: &[Vec3]) -> Vec<Extent> {
        let extent = |(number, (face, s)): (usize, (&Vec<u32>, &f64))| {
            let line = self.line(number);
            let corner = |i: usize| positions[face[i % face.len()] as usize];
            let middle = (0..face.len()).map(corner).sum::<Vec3>() / face.len() as f64;
            let mut extent = Extent {
                area: 0.0,
                volume: 0.0,
            };
            for i in 0..face.len() {
                let (a, b) = (corner(i), corner(i + 1));
                let vector = 0.5 * (a - middle).cross(&(b - middle));
                let centre = (a + b + middle) / 3.0;
                extent.area += vector.norm();
                let nearest = line.nearest_from(&centre, *s);
                let [y, z] = nearest.across;
                let [bend_y, bend_z] = nearest.frame.across(&line.curvature(nearest.s));
                let [normal_y, normal_z] = nearest.frame.across(&vector);
                let q = bend_y * y + bend_z * z;
                extent.volume += (0.5 - q / 3.0) / (1.0 - q) * (y * normal_y + z * normal_z);
            }
            extent
        };
        let faces = self.faces.iter().zip(&self.along);
        faces.enumerate().map(extent).collect()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::{PI, TAU};

    /// A tube of radius 2 m from x = 0 to 4 m.
    pub fn tube(along: usize, around: usize) -> WetSurface {
        let mut points = Vec::new();
        let mut faces = Vec::new();
        for i in 0..=along {
            for j in 0..around {
                let phi = TAU * j as f64 / around as f64;
                let x = 4.0 * i as f64 / along as f64;
                points.push(Vec3::new(x, 2.0 * phi.cos(), 2.0 * phi.sin()));
                let at = |i: usize, j: usize| (i * around + j % around) as u32;
                if i < along {
                    faces.push(vec![at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
                }
            }
        }
        WetSurface::new(points, faces)
    }

    /// A face of a branch is around that branch, although the one before it, if it went on straight, would be nearer.
    #[test]
    fn faces_are_around_the_branch_that_reaches_them() {
        let (sin, cos) = 20f64.to_radians().sin_cos();
        let (junction, along, across) = (
            Vec3::x(),
            Vec3::new(cos, sin, 0.0),
            Vec3::new(sin, -cos, 0.0),
        );
        let before = SpaceCurve::through(&[Vec3::zeros(), junction], Vec3::z());
        let after = SpaceCurve::through(&[junction, junction + along * 3.0], Vec3::z());
        let middle = junction + along * 2.0 + across * 0.5;
        let corners = [along, Vec3::z(), -along - Vec3::z()];
        let points = corners.map(|corner| middle + corner * 0.1).to_vec();
        let mut wall = WetSurface::new(points, vec![vec![0, 1, 2]]);
        wall.patches = vec!["between".into()];
        let lines = [
            ("between".to_owned(), before),
            ("between".to_owned(), after),
        ];
        let wall = wall.along_branches(&lines);
        assert_eq!(wall.line_number(0), 1);
        assert_relative_eq!(wall.along(0), 2.0, max_relative = 1e-6);
    }

    /// A part of a tube has its area and volume also between the cross sections of the mesh.
    #[test]
    fn parts_of_a_tube_have_exact_area_and_volume() {
        let wall = tube(7, 400);
        let region = Region::along("artery".into(), 0.9, 3.1);
        let still = vec![[0.0; 3]; wall.points.len()];
        let extents = wall.extents(&wall.displaced(&still));
        let sum = |part: fn(&Extent) -> f64| -> f64 {
            let shares = wall.shares(&region).into_iter();
            shares
                .map(|(face, share)| share * part(&extents[face]))
                .sum()
        };
        assert_relative_eq!(sum(|e| e.area), TAU * 2.0 * 2.2, max_relative = 1e-4);
        assert_relative_eq!(sum(|e| e.volume), PI * 4.0 * 2.2, max_relative = 1e-4);
    }

    #[test]
    fn what_a_tube_sweeps_is_what_it_grows_by() {
        let wall = tube(7, 40);
        let wider: Vec<[f32; 3]> = (wall.points.iter())
            .map(|x| [0.0, 0.25 * x.y as f32, 0.25 * x.z as f32])
            .collect();
        let swept: f64 = wall.swept(&wider).iter().sum();
        let polygon = 40.0 * 0.5 * (TAU / 40.0).sin();
        let grown = polygon * 4.0 * (2.5f64.powi(2) - 2f64.powi(2));
        assert_relative_eq!(swept, grown, max_relative = 1e-6);
    }

    #[test]
    fn a_tube_that_moves_sideways_keeps_its_radii() {
        let wall = tube(4, 24);
        let shifted = wall.points.iter().map(|x| x + Vec3::new(0.0, 5.0, 1.0));
        for radius in wall.radii(&shifted.collect::<Vec<_>>()) {
            assert_relative_eq!(radius, 2.0, max_relative = 1e-12);
        }
    }

    #[test]
    fn places_are_given_by_axis_and_angle() {
        let places = tube(4, 8).places();
        assert_relative_eq!(places[0].x_m, 0.5);
        assert_relative_eq!(places[0].phi_deg, 22.5, max_relative = 1e-12);
        assert_relative_eq!(places[8 + 5].x_m, 1.5);
        assert_relative_eq!(places[8 + 5].phi_deg, -112.5, max_relative = 1e-12);
    }
}
