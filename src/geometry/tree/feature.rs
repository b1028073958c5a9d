//! Parts of branches that are narrower or wider than their lines and the surface say.

use super::described::cell_grid;
use super::{Lumen, Tree, TreeError};
use crate::Vec3;
use crate::case::{self, TreeFeature, TreeKeys};
use crate::curve::Foot;
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
            without_features: self.lines,
            ..self
        };
        if let Some(search) = &lumen.surface {
            let surface = search.surface();
            let moved = surface.points().iter().map(|x| {
                let (centre, share) = lumen.narrowed(x);
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
        !self.without_features.is_empty()
    }

    /// How far (m) a place of the wall lies further inside than without features; 0 where it is further out.
    pub fn lost(&self, x: &Vec3) -> f64 {
        let (centre, share) = self.narrowed(x);
        ((x - centre).norm() * (1.0 / share - 1.0)).max(0.0)
    }

    /// The centre of the cross-section next to a place, m, and its radius relative to that without features.
    fn narrowed(&self, x: &Vec3) -> (Vec3, f64) {
        let feet = self.without_features.iter().zip(&self.lines);
        let feet = feet.map(|(before, line)| (before.foot(x), line));
        let off = |foot: &Foot| foot.distance - foot.radius;
        let nearest = feet.min_by(|(a, _), (b, _)| off(a).total_cmp(&off(b)));
        nearest.map_or((*x, 1.0), |(foot, line)| {
            (foot.centre, line.radius(foot.s) / foot.radius)
        })
    }
}
