//! The lumen of a tree: the surface of a file, or as an implicit surface the smooth union of the tubes around its
//! centre-lines.

use crate::Vec3;
use crate::curve::{CentreLine, Foot};
use crate::polydata::{RayHit, SurfaceSearch};
use std::sync::Arc;

/// How far the tubes of two centre-lines blend where they part, in radii.
const FILLET: f64 = 0.5;
/// A ray ends here, in radii of the place that it starts from.
const REACH: f64 = 4.0;
/// Steps of a ray before it is refined.
const RAY_STEPS: usize = 40;
/// Cosines between a ray and the normal of a surface from a file. Above the first one the ray says where the wall is,
/// below the second one the place that is nearest to where the tubes have it.
const UPRIGHT: [f64; 2] = [0.6, 0.4];

/// What the blood fills.
#[derive(Debug, Clone)]
pub struct Lumen {
    /// One for each end.
    pub lines: Vec<CentreLine>,
    /// Its wall, if that is not the union of the tubes around these lines.
    pub surface: Option<Arc<SurfaceSearch>>,
}

/// The parts of a lumen that are near a place.
pub struct Near<'a> {
    lumen: &'a Lumen,
    ranges: Vec<(usize, std::ops::Range<usize>)>,
    reach: f64,
}

impl Lumen {
    /// What lies within four of the largest radii there around a place.
    pub fn near(&self, x: &Vec3) -> Near<'_> {
        let feet: Vec<Foot> = self.lines.iter().map(|line| line.foot(x)).collect();
        let inside = feet.iter().filter(|foot| foot.distance < foot.radius);
        let mut widest = inside.map(|foot| foot.radius).fold(0.0, f64::max);
        if widest == 0.0 && self.surface.is_some() {
            // A surface may be wider than the tubes within it.
            let off = |foot: &&Foot| foot.distance - foot.radius;
            let nearest = feet.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            widest = nearest.map_or(0.0, |foot| foot.radius);
        }
        let reach = REACH * widest;
        let ranges = self.lines.iter().enumerate().filter_map(|(i, line)| {
            let is_near = |k: &usize| (line.points[*k] - x).norm() < reach + 2.0 * line.radii[*k];
            let first = (0..line.points.len()).find(is_near)?;
            let last = (0..line.points.len()).rfind(is_near)?;
            Some((i, first.saturating_sub(1)..last + 2))
        });
        Near {
            ranges: ranges.collect(),
            lumen: self,
            reach,
        }
    }
}

impl Near<'_> {
    /// Below 0 inside, above outside; about the distance from the surface, m. Tubes of two centre-lines blend where
    /// their surfaces point apart, not where they coincide: over `k = FILLET r (1 - n_a · n_b)/2` by
    /// `min(a, b) - max(k - |a - b|, 0)²/(4 k)`.
    pub fn value(&self, x: &Vec3) -> f64 {
        let mut all: Vec<(f64, Vec3, f64)> = Vec::with_capacity(self.ranges.len());
        for (line, range) in &self.ranges {
            let foot = self.lumen.lines[*line].foot_near(x, range.clone());
            let normal = (x - foot.centre) / foot.distance.max(1e-300);
            all.push((foot.distance - foot.radius, normal, foot.radius));
        }
        let nearest = all
            .iter()
            .map(|(off, _, _)| *off)
            .fold(f64::INFINITY, f64::min);
        let mut blend: f64 = 0.0;
        for (i, (a, n_a, r_a)) in all.iter().enumerate() {
            for (b, n_b, r_b) in &all[..i] {
                let k = FILLET * r_a.min(*r_b) * 0.5 * (1.0 - n_a.dot(n_b));
                let h = (k - (a - b).abs()).max(0.0);
                if k > 0.0 {
                    // What it adds to the nearest of all.
                    blend = blend.max(nearest - (a.min(*b) - h * h / (4.0 * k)));
                }
            }
        }
        nearest - blend
    }

    /// Where the wall is, seen from a place (m) inside along a unit vector; none if there is none.
    pub fn wall(&self, from: &Vec3, direction: &Vec3) -> Option<Vec3> {
        let of_tubes = || Some(from + direction * self.tubes(from, direction)?);
        let Some(surface) = &self.lumen.surface else {
            return of_tubes();
        };
        let hit = self.hit(surface, from, direction)?;
        let [upright, grazing] = UPRIGHT;
        let slope = hit.normal.dot(direction).abs();
        let own = ((slope - grazing) / (upright - grazing)).clamp(0.0, 1.0);
        let met = from + direction * hit.distance;
        match (own < 1.0).then(of_tubes).flatten() {
            Some(tube) => Some(surface.nearest(&(met * own + tube * (1.0 - own)))),
            None => Some(met),
        }
    }

    fn hit(&self, surface: &SurfaceSearch, from: &Vec3, direction: &Vec3) -> Option<RayHit> {
        let hit = surface.ray(from, direction)?;
        (hit.distance < self.reach).then_some(hit)
    }

    /// Distance (m) of the wall from a place inside along a unit vector; none if it is not met.
    pub fn ray(&self, from: &Vec3, direction: &Vec3) -> Option<f64> {
        match &self.lumen.surface {
            Some(surface) => Some(self.hit(surface, from, direction)?.distance),
            None => self.tubes(from, direction),
        }
    }

    /// As [`Near::ray`], of the tubes around the lines.
    fn tubes(&self, from: &Vec3, direction: &Vec3) -> Option<f64> {
        let step = self.reach / RAY_STEPS as f64;
        let at = |t: f64| self.value(&(from + direction * t));
        let (mut low, mut high) = (0.0, None);
        let mut t = 0.0;
        for _ in 0..4 * RAY_STEPS {
            let value = at(t);
            if value >= 0.0 {
                high = Some(t);
                break;
            }
            low = t;
            // The surface is about as far as the value says.
            t += (-0.9 * value).max(0.02 * step);
            if t > self.reach {
                break;
            }
        }
        let mut high = high.filter(|high| *high > 0.0)?;
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            match at(middle) < 0.0 {
                true => low = middle,
                false => high = middle,
            }
            if high - low < 1e-12 * self.reach {
                break;
            }
        }
        Some(0.5 * (low + high))
    }
}
