//! Parts of branches that are narrower or wider than their lines and the surface say.

use super::described::cell_grid;
use super::{Lumen, Tree, TreeError};
use crate::Vec3;
use crate::case::{self, TreeFeature, TreeKeys};
use crate::curve::{CentreLine, Foot};
use crate::geometry::feature::Bump;
use crate::polydata::{Surface, SurfaceSearch};
use std::sync::Arc;

/// A feature of a branch as that of a vessel whose arc length is that of a line.
fn of_vessel(keys: &TreeFeature, at: f64) -> case::Feature {
    match *keys {
        TreeFeature::Stenosis {
            length,
            area_reduction,
            profile,
            ..
        } => case::Feature::Stenosis {
            at,
            length,
            area_reduction,
            profile,
            eccentricity: None,
            side_deg: None,
        },
        TreeFeature::Aneurysm {
            length,
            growth,
            profile,
            ..
        } => case::Feature::Aneurysm {
            at,
            length,
            growth,
            profile,
            eccentricity: None,
            side_deg: None,
        },
    }
}

impl Lumen {
    /// With the features of a case. Those of a branch with an end of its own are on its line, those of the root on all.
    ///
    /// # Errors
    /// If it has no mesh without them, from which it is known where branches begin, or one lies beyond its branch.
    pub(super) fn with_features(self, keys: &TreeKeys) -> Result<Self, TreeError> {
        let Some(features) = keys.feature.as_deref().filter(|all| !all.is_empty()) else {
            return Ok(self);
        };
        let (grid, length) = cell_grid(keys);
        let branches = Tree::new(self.clone(), grid, length)?.lines();
        let mut lines = self.lines.clone();
        for feature in features {
            let (name, at) = (feature.branch(), feature.at());
            let number = (keys.names().iter().position(|end| end == name))
                .expect("the check of the case knows the branch");
            let branch = branches.iter().find(|(wall, _)| *wall == number);
            let Some((_, branch)) = branch else { continue };
            let end = branch.ends()[1];
            if at > end {
                return Err(TreeError::Beyond(name.to_owned(), at, end));
            }
            let x = branch.frame(at).origin;
            for (i, line) in lines.iter_mut().enumerate() {
                if number == 0 || number == i + 1 {
                    let bump = Bump::new(&of_vessel(feature, line.foot(&x).s));
                    *line = line.with_radii(|s, r| bump.radius(s, r));
                }
            }
        }
        let mut lumen = Self {
            lines,
            plain: self.lines,
            ..self
        };
        if let Some(search) = &lumen.surface {
            let surface = search.surface();
            let moved = surface.points().iter().map(|x| {
                let (centre, share) = lumen.scaled(x);
                centre + (x - centre) * share
            });
            let triangles = (0..surface.triangles()).map(|i| surface.triangle(i));
            let surface = Surface::of_points(moved.collect(), triangles.collect());
            let surface = surface.map_err(TreeError::Surface)?;
            lumen.surface = Some(Arc::new(SurfaceSearch::new(surface)));
        }
        Ok(lumen)
    }

    /// Whether the case has features.
    pub fn has_features(&self) -> bool {
        !self.plain.is_empty()
    }

    /// The lines with their radii without features.
    pub(super) fn lines_without_features(&self) -> &[CentreLine] {
        match self.has_features() {
            true => &self.plain,
            false => &self.lines,
        }
    }

    /// Where a place (m) would be without features, and its distance from the centre relative to that there.
    pub(super) fn without_features(&self, x: &Vec3) -> (Vec3, f64) {
        let (centre, share) = self.scaled(x);
        match share == 1.0 {
            true => (*x, 1.0),
            false => (centre + (x - centre) / share, share),
        }
    }

    /// Where a place of the wall (m) would be without what narrows the lumen there.
    pub fn without_narrowing(&self, x: &Vec3) -> Vec3 {
        let (healthy, share) = self.without_features(x);
        if share < 1.0 { healthy } else { *x }
    }

    /// The centre of the cross-section that a place is in, m, and its radius relative to that without features.
    fn scaled(&self, x: &Vec3) -> (Vec3, f64) {
        let feet = self.plain.iter().zip(&self.lines);
        let feet = feet.map(|(plain, line)| (plain.foot(x), line));
        let off = |foot: &Foot| foot.distance - foot.radius;
        let nearest = feet.min_by(|(a, _), (b, _)| off(a).total_cmp(&off(b)));
        nearest.map_or((*x, 1.0), |(foot, line)| {
            (foot.centre, line.radius(foot.s) / foot.radius)
        })
    }
}
