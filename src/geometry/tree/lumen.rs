//! The lumen of a tree: the surface of a file, or as an implicit surface the smooth union of the tubes around its
//! centre-lines.

use crate::Vec3;
use crate::curve::{CentreLine, Foot};
use crate::polydata::{RayHit, SurfaceSearch};
use std::cell::OnceCell;
use std::sync::Arc;

/// How far the tubes of two centre-lines blend where they part, in radii.
const FILLET: f64 = 0.5;
/// A ray ends here, in radii of the place that it starts from.
const REACH: f64 = 4.0;
/// Where a ray ends is as exact as this, in that.
const EXACT: f64 = 1e-13;
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
    /// The lines without the case's features; none if it has none.
    pub(super) plain: Vec<CentreLine>,
    /// Which lines are no part of it.
    pub(super) left_out: Vec<bool>,
}

/// The parts of a lumen that are near a place.
pub struct Near<'a> {
    lumen: &'a Lumen,
    ranges: Vec<(usize, std::ops::Range<usize>)>,
    reach: f64,
    /// The place, m: most rays begin here.
    middle: Vec3,
    /// Its value.
    at_middle: OnceCell<f64>,
}

impl Lumen {
    /// The lumen around lines, or within a surface around them.
    pub fn new(lines: Vec<CentreLine>, surface: Option<Arc<SurfaceSearch>>) -> Self {
        Self {
            left_out: vec![false; lines.len()],
            plain: Vec::new(),
            lines,
            surface,
        }
    }

    /// The lines that are part of it, with their numbers.
    fn parts(&self) -> impl Iterator<Item = (usize, &CentreLine)> {
        let all = self.lines.iter().enumerate();
        all.filter(|(i, _)| !self.left_out[*i])
    }

    /// What lies within four of the largest radii there around a place.
    pub fn near(&self, x: &Vec3) -> Near<'_> {
        let around = self.parts().filter(|(_, line)| line.may_surround(x));
        let feet = around.map(|(_, line)| line.foot(x));
        let inside = feet.filter(|foot| foot.distance < foot.radius);
        let widest = inside.map(|foot| foot.radius).fold(0.0, f64::max);
        match &self.surface {
            // A surface may be wider than the tubes within it.
            Some(_) if widest == 0.0 => self.near_wall(x),
            _ => self.within(x, REACH * widest),
        }
    }

    /// What lies within four radii of the nearest tube around a place of the wall.
    pub fn near_wall(&self, x: &Vec3) -> Near<'_> {
        let feet = self.parts().map(|(_, line)| line.foot(x));
        let off = |foot: &Foot| foot.distance - foot.radius;
        let nearest = feet.min_by(|a, b| off(a).total_cmp(&off(b)));
        self.within(x, REACH * nearest.map_or(0.0, |foot| foot.radius))
    }

    /// What lies within so many metres of a place.
    fn within(&self, x: &Vec3, reach: f64) -> Near<'_> {
        let mut ranges: Vec<(usize, std::ops::Range<usize>)> = Vec::new();
        for (i, line) in self.parts() {
            let Some([first, last]) = line.samples_near(x, reach) else {
                continue;
            };
            let range = first.saturating_sub(1)..last + 2;
            // Lines that coincide here have one tube.
            let is_same = |(other, known): &(usize, std::ops::Range<usize>)| {
                *known == range && self.lines[*other].coincides(line, range.clone())
            };
            if !ranges.iter().any(is_same) {
                ranges.push((i, range));
            }
        }
        Near {
            ranges,
            lumen: self,
            reach,
            middle: *x,
            at_middle: OnceCell::new(),
        }
    }
}

impl Near<'_> {
    /// Below 0 inside, above outside; about the distance from the surface, m. Tubes of two centre-lines blend where
    /// their surfaces point apart, not where they coincide: over `k = FILLET r (1 - n_a · n_b)/2` by
    /// `min(a, b) - max(k - |a - b|, 0)²/(4 k)`.
    pub fn value(&self, x: &Vec3) -> f64 {
        let (x, share) = self.lumen.without_features(x);
        let lines = self.lumen.lines_without_features();
        let mut all: Vec<(f64, Vec3, f64)> = Vec::with_capacity(self.ranges.len());
        for (line, range) in &self.ranges {
            let foot = lines[*line].foot_near(&x, range.clone());
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
        share * (nearest - blend)
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

    /// The place of the wall that is nearest to one next to it; none where no line is near.
    pub fn nearest(&self, x: &Vec3) -> Option<Vec3> {
        if let Some(surface) = &self.lumen.surface {
            return Some(surface.nearest(x));
        }
        let (x, share) = self.lumen.without_features(x);
        let lines = self.lumen.lines_without_features();
        let feet = self.ranges.iter();
        let feet = feet.map(|(line, range)| lines[*line].foot_near(&x, range.clone()));
        let off = |foot: &Foot| foot.distance - foot.radius;
        let foot = feet.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        let arm = x - foot.centre;
        (foot.distance > 0.0).then(|| foot.centre + arm * (share * foot.radius / foot.distance))
    }

    /// The place of the wall next to one (m), along a unit vector across it or, on a surface from a file, the nearest
    /// one; none within the distance `farthest` (m), or beyond the end of the surface.
    pub fn along(&self, x: &Vec3, across: &Vec3, farthest: f64) -> Option<Vec3> {
        if let Some(surface) = &self.lumen.surface {
            let nearest = surface.nearest_within(x)?;
            return ((nearest - x).norm() <= farthest).then_some(nearest);
        }
        let at = |t: f64| self.value(&(x + across * t));
        let own = at(0.0);
        if own == 0.0 {
            return Some(*x);
        }
        // Outward from a place inside, inward from one outside, about as far as the value says.
        let sense = -own.signum();
        let mut inner: (f64, f64) = (0.0, own);
        let mut step = own.abs();
        loop {
            let t = sense * (inner.0.abs() + step).min(farthest);
            let outer = (t, at(t));
            if outer.1 * own <= 0.0 {
                let [low, high] = if own > 0.0 {
                    [outer, inner]
                } else {
                    [inner, outer]
                };
                return Some(x + across * self.zero(at, [low, high]));
            }
            if t.abs() >= farthest {
                return None;
            }
            (inner, step) = (outer, 2.0 * step);
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
        let (mut low, mut high) = ((0.0, 0.0), None);
        let mut t = 0.0;
        for _ in 0..4 * RAY_STEPS {
            let value = match t == 0.0 && *from == self.middle {
                true => *self.at_middle.get_or_init(|| at(t)),
                false => at(t),
            };
            if value >= 0.0 {
                high = Some((t, value));
                break;
            }
            low = (t, value);
            // The surface is about as far as the value says.
            t += (-0.9 * value).max(0.02 * step);
            if t > self.reach {
                break;
            }
        }
        let high = high.filter(|(t, _)| *t > 0.0)?;
        Some(self.zero(at, [low, high]))
    }

    /// Where a function, about a distance (m), is zero between a place below and one above: the secant's place, that of
    /// an end that stays with half of its value (Illinois). The ends are given with their values.
    fn zero(&self, at: impl Fn(f64) -> f64, ends: [(f64, f64); 2]) -> f64 {
        let exact = EXACT * self.reach;
        let [(mut low, mut below), (mut high, mut above)] = ends;
        let mut stays = 0i8;
        for _ in 0..60 {
            let t = low + (high - low) * (below / (below - above)).clamp(0.0, 1.0);
            let value = at(t);
            if value.abs() < exact || high - low < exact {
                return t;
            }
            match value < 0.0 {
                true => {
                    (low, below) = (t, value);
                    above *= if stays == 1 { 0.5 } else { 1.0 };
                    stays = 1;
                }
                false => {
                    (high, above) = (t, value);
                    below *= if stays == -1 { 0.5 } else { 1.0 };
                    stays = -1;
                }
            }
        }
        0.5 * (low + high)
    }
}
