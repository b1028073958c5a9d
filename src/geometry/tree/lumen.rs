//! The lumen of a tree: the surface of a file, or as an implicit surface the smooth union of the tubes around its
//! centre-lines.

use crate::Vec3;
use crate::polydata::{RayHit, SurfaceSearch};
use std::sync::Arc;

/// How far the tubes of two centre-lines blend where they part, in radii.
const FILLET: f64 = 0.5;
/// Distance of the samples of a centre-line, in radii.
const STEP: f64 = 0.1;
/// Half of the stretch of a centre-line over which its direction is taken, in radii.
const WINDOW: f64 = 1.0;
/// A ray ends here, in radii of the place that it starts from.
const REACH: f64 = 4.0;
/// Steps of a ray before it is refined.
const RAY_STEPS: usize = 40;
/// Cosines between a ray and the normal of a surface from a file. Above the first one the ray says where the wall is,
/// below the second one the place that is nearest to where the tubes have it.
const UPRIGHT: [f64; 2] = [0.6, 0.4];

/// A centre-line from the root of a tree to one of its ends, with its radii. The parts that several share may differ
/// by a fraction of a radius.
#[derive(Debug, Clone)]
pub struct CentreLine {
    /// Samples, m.
    points: Vec<Vec3>,
    radii: Vec<f64>,
    /// Arc length at each, m.
    s: Vec<f64>,
    /// Whether the lumen ends with it, as half a sphere.
    pub is_closed: bool,
}

/// A place of a centre-line that is nearest to a point.
#[derive(Debug, Clone, Copy)]
pub struct Foot {
    /// Arc length, m.
    pub s: f64,
    /// Centre, m.
    pub centre: Vec3,
    /// Radius, m.
    pub radius: f64,
    /// Distance of the point, m.
    pub distance: f64,
}

impl CentreLine {
    /// Through points (m) with these radii (m): a Catmull-Rom spline over the chord lengths, sampled.
    pub fn new(points: &[Vec3], radii: &[f64]) -> Self {
        let n = points.len();
        let tangent = |i: usize| -> (Vec3, f64) {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
            let [h, k] = [i - a, b - i].map(|d| d as f64);
            let (before, after) = (
                (points[i] - points[a]).norm(),
                (points[b] - points[i]).norm(),
            );
            match (h > 0.0, k > 0.0) {
                // The parabola through three points.
                (true, true) => {
                    let (x, y) = (
                        (points[i] - points[a]) / before,
                        (points[b] - points[i]) / after,
                    );
                    let (p, q) = (
                        (radii[i] - radii[a]) / before,
                        (radii[b] - radii[i]) / after,
                    );
                    let w = after / (before + after);
                    (x * w + y * (1.0 - w), p * w + q * (1.0 - w))
                }
                (false, _) => (
                    (points[b] - points[i]) / after,
                    (radii[b] - radii[i]) / after,
                ),
                (_, false) => (
                    (points[i] - points[a]) / before,
                    (radii[i] - radii[a]) / before,
                ),
            }
        };
        let (mut fine, mut fine_radii) = (vec![points[0]], vec![radii[0]]);
        for i in 0..n - 1 {
            let length = (points[i + 1] - points[i]).norm();
            let pieces = (length / (STEP * radii[i].min(radii[i + 1])))
                .ceil()
                .max(1.0) as usize;
            let ((t0, r0), (t1, r1)) = (tangent(i), tangent(i + 1));
            for k in 1..=pieces {
                let u = k as f64 / pieces as f64;
                let [a, b] = [(1.0 + 2.0 * u) * (1.0 - u).powi(2), u * u * (3.0 - 2.0 * u)];
                let [c, d] = [u * (1.0 - u).powi(2) * length, -u * u * (1.0 - u) * length];
                fine.push(points[i] * a + points[i + 1] * b + t0 * c + t1 * d);
                fine_radii.push(radii[i] * a + radii[i + 1] * b + r0 * c + r1 * d);
            }
        }
        Self::sampled(fine, fine_radii)
    }

    fn sampled(points: Vec<Vec3>, radii: Vec<f64>) -> Self {
        let mut s = vec![0.0];
        for pair in points.windows(2) {
            s.push(s[s.len() - 1] + (pair[1] - pair[0]).norm());
        }
        Self {
            points,
            radii,
            s,
            is_closed: false,
        }
    }

    /// The mean of lines that begin as one branch, as far as the arc length `end` (m) of the first one.
    pub fn mean(lines: &[&Self], end: f64) -> Self {
        let samples = lines[0].places().take_while(|s| *s <= end);
        let share = 1.0 / lines.len() as f64;
        // At the same arc length, so that lines that mirror each other have a mean in the mirror's plane.
        let mean = samples.map(|s| {
            let centre: Vec3 = lines.iter().map(|line| line.at(s) * share).sum();
            (
                centre,
                lines.iter().map(|line| line.radius(s) * share).sum::<f64>(),
            )
        });
        let (points, radii): (Vec<Vec3>, Vec<f64>) = mean.unzip();
        Self::sampled(points, radii)
    }

    /// Length, m.
    pub fn length(&self) -> f64 {
        self.s[self.s.len() - 1]
    }

    /// Arc lengths (m) of its samples.
    pub fn places(&self) -> impl Iterator<Item = f64> {
        self.s.iter().copied()
    }

    fn piece(&self, s: f64) -> (usize, f64) {
        let last = self.s.len() - 2;
        let i = (self.s.partition_point(|x| *x <= s)).clamp(1, last + 1) - 1;
        (i, (s - self.s[i]) / (self.s[i + 1] - self.s[i]))
    }

    /// Centre (m) at an arc length (m); on the tangent beyond the ends.
    pub fn at(&self, s: f64) -> Vec3 {
        let (i, u) = self.piece(s);
        self.points[i] + (self.points[i + 1] - self.points[i]) * u
    }

    /// Radius (m) at an arc length (m).
    pub fn radius(&self, s: f64) -> f64 {
        let (i, u) = self.piece(s.clamp(0.0, self.length()));
        self.radii[i] + (self.radii[i + 1] - self.radii[i]) * u
    }

    /// Unit tangent at an arc length (m), the mean over a radius on both sides: cross-sections do not turn faster than
    /// that where a line has a kink.
    pub fn tangent(&self, s: f64) -> Vec3 {
        let h = WINDOW * self.radius(s).min(0.25 * self.length());
        let s = s.clamp(h, self.length() - h);
        (self.at(s + h) - self.at(s - h)).normalize()
    }

    /// The place whose tube is nearest to a point, among samples within `reach` of `around`, if there is one.
    fn foot_near(&self, x: &Vec3, range: std::ops::Range<usize>) -> Foot {
        let mut best: Option<(f64, Foot)> = None;
        for i in range.start..range.end.min(self.points.len() - 1) {
            let (a, b) = (self.points[i], self.points[i + 1]);
            let ab = b - a;
            let u = ((x - a).dot(&ab) / ab.norm_squared()).clamp(0.0, 1.0);
            let centre = a + ab * u;
            let radius = self.radii[i] + (self.radii[i + 1] - self.radii[i]) * u;
            let distance = (x - centre).norm();
            let off = distance - radius;
            if best.is_none_or(|(other, _)| off < other) {
                let s = self.s[i] + (self.s[i + 1] - self.s[i]) * u;
                best = Some((
                    off,
                    Foot {
                        s,
                        centre,
                        radius,
                        distance,
                    },
                ));
            }
        }
        best.expect("a centre-line has two points").1
    }

    /// The place of the line whose tube is nearest to a point.
    pub fn foot(&self, x: &Vec3) -> Foot {
        self.foot_near(x, 0..self.points.len())
    }
}

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
