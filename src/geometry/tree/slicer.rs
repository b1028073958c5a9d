//! Cross-sections of a lumen, and the places of a line at which they are.

use super::error::TreeError;
use super::lumen::Lumen;
use super::section::{CrossSection, SectionGrid};
use crate::Vec3;
use crate::curve::CentreLine;
use crate::polydata::OVERLAP;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Heights of the last cross-section's rim and core in the half sphere that closes a branch, in radii.
const RIM_OF_DOME: f64 = 0.6;
const CORE_OF_DOME: f64 = 0.4;

/// Cuts a lumen into cross-sections.
#[derive(Debug, Clone)]
pub struct Slicer {
    /// What is cut.
    pub lumen: Lumen,
    /// Cells of a cross-section.
    pub grid: SectionGrid,
    /// Length of a cell or an element along a branch, in radii.
    pub along: f64,
}

impl Slicer {
    /// The plane cross-section at a centre, its rim from the direction `first` on, turned by an angle (rad).
    pub fn plane(
        &self,
        centre: Vec3,
        tangent: &Vec3,
        first: &Vec3,
        turned: f64,
    ) -> Result<CrossSection, TreeError> {
        let second = tangent.cross(first);
        let directions = (0..self.grid.around()).map(|a| {
            let phi = self.grid.angle(a) + turned;
            first * phi.cos() + second * phi.sin()
        });
        self.cut(centre, directions)
    }

    /// The plane cross-section at the arc length `s` (m) of a line, across `tangent`, its rim from the direction
    /// `first` on, turned by an angle (rad). Where the surface ends before, it is that of a place up to 1.5 radii
    /// closer to the junction, which lies downstream of an inlet and upstream of an outlet, moved there.
    pub fn plane_near(
        &self,
        line: &CentreLine,
        s: f64,
        [tangent, first]: [&Vec3; 2],
        turned: f64,
        downstream: bool,
    ) -> Result<CrossSection, TreeError> {
        const STEPS: usize = 15;
        let centre = line.at(s);
        if self.lumen.surface.is_none() || self.is_whole(centre, tangent, first) {
            return self.plane(centre, tangent, first, turned);
        }
        let sense = if downstream { 1.0 } else { -1.0 };
        let step = sense * OVERLAP / STEPS as f64 * line.radius(s);
        let mut places = (1..=STEPS).map(|i| {
            let s = s + i as f64 * step;
            let tangent = line.tangent(s);
            (line.at(s), tangent, across(first, &tangent))
        });
        let whole = places.find(|(x, tangent, first)| self.is_whole(*x, tangent, first));
        let (x, along, first) = whole.ok_or(TreeError::Open(centre))?;
        let plane = self.plane(x, &along, &first, turned)?;
        Ok(plane.moved(centre, [&along, tangent]))
    }

    /// Where a branch ends as half a sphere: cross-sections beyond the plane one at the end of its line, whose rims are
    /// bent towards the edges of a cube's side in that sphere, and the wall over the core of the last one, row by row.
    pub fn dome(
        &self,
        line: &CentreLine,
        tangent: &Vec3,
        first: &Vec3,
    ) -> Result<(Vec<CrossSection>, Vec<Vec3>), TreeError> {
        let grid = &self.grid;
        let centre = line.at(line.length());
        let second = tangent.cross(first);
        let near = self.lumen.near(&centre);
        let wall = |direction: Vec3| {
            let wall = near.wall(&centre, &direction.normalize());
            wall.ok_or(TreeError::Open(centre))
        };
        let on_side = |x: f64, y: f64| tangent + first * x + second * y;
        let n = grid.core + 1;
        let slope = |i: usize| (FRAC_PI_4 * (2.0 * grid.place(i) - 1.0)).tan();
        let top = (0..n * n).map(|k| wall(on_side(slope(k % n), slope(k / n))));
        let up = tangent * line.radius(line.length());
        let section = |u: f64| {
            let rim = (0..grid.around()).map(|a| {
                let phi = grid.angle(a);
                let from_middle = phi - FRAC_PI_2 * (phi / FRAC_PI_2).round();
                let polar = FRAC_PI_2 * (1.0 - u) + (1.0 / from_middle.cos()).atan() * u;
                let across = first * phi.cos() + second * phi.sin();
                wall(tangent * polar.cos() + across * polar.sin())
            });
            Ok(CrossSection {
                lift: up * ((CORE_OF_DOME - RIM_OF_DOME) * u),
                ..CrossSection::new(
                    centre + up * (RIM_OF_DOME * u),
                    rim.collect::<Result<_, _>>()?,
                )
            })
        };
        let places = grid.divided(FRAC_PI_4 / self.along);
        let sections = places[1..].iter().map(|&u| section(u));
        Ok((
            sections.collect::<Result<_, TreeError>>()?,
            top.collect::<Result<_, _>>()?,
        ))
    }

    /// Whether all rays of a plane cross-section meet the wall.
    pub fn is_whole(&self, centre: Vec3, tangent: &Vec3, first: &Vec3) -> bool {
        let near = self.lumen.near(&centre);
        let second = tangent.cross(first);
        (0..self.grid.around()).all(|a| {
            let (sin, cos) = self.grid.angle(a).sin_cos();
            let direction = first * cos + second * sin;
            near.wall(&centre, &direction).is_some()
        })
    }

    /// The cross-section whose rim lies in these directions from a centre.
    fn cut(
        &self,
        centre: Vec3,
        directions: impl Iterator<Item = Vec3>,
    ) -> Result<CrossSection, TreeError> {
        let near = self.lumen.near(&centre);
        let point = |direction: Vec3| {
            let wall = near.wall(&centre, &direction);
            wall.ok_or(TreeError::Open(centre))
        };
        let rim = directions.map(point).collect::<Result<_, _>>()?;
        Ok(CrossSection::new(centre, rim))
    }

    /// Places of a line from `begin` to `end` (m), those of the points of cells or elements.
    pub fn stations(&self, line: &CentreLine, begin: f64, end: f64) -> Vec<f64> {
        const SAMPLES: usize = 400;
        if end <= begin {
            return vec![end];
        }
        let h = (end - begin) / SAMPLES as f64;
        let mut sum = vec![0.0];
        for i in 0..SAMPLES {
            let radius = line.radius(begin + (i as f64 + 0.5) * h);
            sum.push(sum[i] + h / (self.along * radius));
        }
        let place = |share: f64| {
            let goal = sum[SAMPLES] * share;
            let i = sum.partition_point(|x| *x <= goal).clamp(1, SAMPLES) - 1;
            begin + h * (i as f64 + (goal - sum[i]) / (sum[i + 1] - sum[i]))
        };
        let places = self.grid.divided(sum[SAMPLES]).into_iter();
        places.map(place).collect()
    }
}

/// A direction without its part along `tangent`.
pub fn across(direction: &Vec3, tangent: &Vec3) -> Vec3 {
    (direction - tangent * tangent.dot(direction)).normalize()
}
