//! Centre-lines with radii, from the root of a tree to its ends, and where they part.

use crate::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// Distance of the samples of a centre-line, in radii.
const STEP: f64 = 0.1;
/// Half of the stretch of a centre-line over which its direction is taken, in radii.
const WINDOW: f64 = 1.0;
/// Lines part at one junction if they do within this many radii.
const TOGETHER: f64 = 1.5;
/// Samples on both sides of the last foot among which the next one is looked for first.
const AHEAD: usize = 12;
/// Pieces between samples that are looked at as a whole first.
const GROUP: usize = 16;
/// Bounds of a group, lengths and numbers of pieces may be off by rounding, relative to their size.
const ROUNDING: f64 = 1e-9;

/// A centre-line from the root of a tree to one of its ends, with its radii. The parts that several share may differ
/// by a fraction of a radius.
#[derive(Debug, Clone)]
pub struct CentreLine {
    /// Samples, m.
    pub points: Vec<Vec3>,
    /// Radius at each, m.
    pub radii: Vec<f64>,
    /// Arc length at each, m.
    s: Vec<f64>,
    /// Pieces between samples, group by group.
    balls: Vec<Ball>,
    /// [`Ball::off`] of a point changes by at most this from one group to the next, m.
    spacing: f64,
    /// The largest radius of a sample, m.
    widest: f64,
    /// Whether the lumen ends with it, as half a sphere.
    pub is_closed: bool,
}

/// What a group of pieces lies in.
#[derive(Debug, Clone, Copy)]
struct Ball {
    middle: Vec3,
    /// No place of the tubes around the pieces is farther from the middle, m.
    reach: f64,
}

impl Ball {
    fn of(points: &[Vec3], radii: &[f64]) -> Self {
        let middle = points.iter().sum::<Vec3>() / points.len() as f64;
        let off = points
            .iter()
            .zip(radii)
            .map(|(x, r)| (x - middle).norm() + r);
        Self {
            middle,
            reach: off.fold(0.0, f64::max) * (1.0 + ROUNDING),
        }
    }

    /// A point is not nearer to any of the tubes, m.
    fn off(&self, x: &Vec3) -> f64 {
        (x - self.middle).norm() * (1.0 - ROUNDING) - self.reach
    }

    /// How near a point looks, for a comparison of several: the power of the point.
    #[inline(always)]
    fn power(&self, x: &Vec3) -> f64 {
        self.squared(x) - self.reach * self.reach
    }

    /// Square of the distance of a point from the middle, m².
    #[inline(always)]
    fn squared(&self, x: &Vec3) -> f64 {
        let middle = &self.middle;
        let [dx, dy, dz] = [x.x - middle.x, x.y - middle.y, x.z - middle.z];
        dx * dx + dy * dy + dz * dz
    }

    /// Whether a tube may lie within a `distance` (m) of a point: false only where that is less than [`Ball::off`].
    #[inline(always)]
    fn may_be_within(&self, x: &Vec3, distance: f64) -> bool {
        let most = distance + self.reach;
        let squared = self.squared(x) * (1.0 - 2.0 * ROUNDING);
        most >= 0.0 && squared <= most * most
    }
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
            // A whole number but for rounding, which is another where the line is turned, is that number.
            let pieces = length / (STEP * radii[i].min(radii[i + 1])) - ROUNDING;
            let pieces = pieces.ceil().max(1.0) as usize;
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
        let pieces = points.len() - 1;
        let groups = (0..pieces).step_by(GROUP).map(|i| {
            let samples = i..=(i + GROUP).min(pieces);
            Ball::of(&points[samples.clone()], &radii[samples])
        });
        let balls: Vec<Ball> = groups.collect();
        let pairs = balls.windows(2);
        let apart = pairs.map(|pair| {
            (pair[1].middle - pair[0].middle).norm() + (pair[1].reach - pair[0].reach).abs()
        });
        Self {
            spacing: apart.fold(0.0, f64::max) * (1.0 + ROUNDING),
            widest: radii.iter().copied().fold(0.0, f64::max),
            balls,
            points,
            radii,
            s,
            is_closed: false,
        }
    }

    /// The mean of lines that begin as one branch, as far as the arc length `end` (m) of the first one.
    pub fn mean(lines: &[&Self], end: f64) -> Self {
        // The end may be a sample of another line, at the same place but for rounding.
        let samples = (lines[0].places()).take_while(|s| *s <= end * (1.0 + ROUNDING));
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

    /// The part between two arc lengths (m), which may lie beyond its ends.
    pub fn part(&self, from: f64, to: f64) -> Self {
        let inside = self.s.iter().enumerate();
        let inside = inside
            .filter(|(_, s)| (from..=to).contains(*s))
            .map(|(i, _)| i);
        let (points, radii): (Vec<Vec3>, Vec<f64>) =
            inside.map(|i| (self.points[i], self.radii[i])).unzip();
        Self {
            is_closed: self.is_closed && to >= self.length(),
            ..Self::sampled(points, radii)
        }
    }

    /// The same line with the radii (m) that a function has of the arc length and the radius (m) of each sample.
    pub fn with_radii(&self, radius: impl Fn(f64, f64) -> f64) -> Self {
        let radii = self.s.iter().zip(&self.radii);
        Self {
            is_closed: self.is_closed,
            ..Self::sampled(
                self.points.clone(),
                radii.map(|(s, r)| radius(*s, *r)).collect(),
            )
        }
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

    /// The place whose tube is nearest to a point, among the pieces of this range.
    pub fn foot_near(&self, x: &Vec3, range: Range<usize>) -> Foot {
        let end = range.end.min(self.points.len() - 1);
        let groups = range.start / GROUP..end.div_ceil(GROUP);
        let mut best = (f64::INFINITY, range.start, 0.0);
        // Loops without iterators, which the driver's level of optimization leaves as calls: a third of a mesh's
        // seconds.
        let look_at = |group: usize, best: &mut (f64, usize, f64)| {
            let mut i = range.start.max(group * GROUP);
            let last = end.min((group + 1) * GROUP);
            while i < last {
                let (off, u) = self.off(x, i, best.0);
                // Of several that are as near, the first.
                if off < best.0 || off == best.0 && i < best.1 {
                    *best = (off, i, u);
                }
                i += 1;
            }
        };
        // The group that looks nearest says how near the others must be.
        let (mut nearest, mut least) = (groups.start, f64::INFINITY);
        let mut group = groups.start;
        while group < groups.end {
            let power = self.balls[group].power(x);
            if power < least {
                (nearest, least) = (group, power);
            }
            group += 1;
        }
        if nearest < groups.end {
            look_at(nearest, &mut best);
        }
        let mut group = groups.start;
        while group < groups.end {
            if group != nearest && self.balls[group].may_be_within(x, best.0) {
                look_at(group, &mut best);
            }
            group += 1;
        }
        let (_, i, u) = best;
        let centre = self.points[i] + (self.points[i + 1] - self.points[i]) * u;
        Foot {
            s: self.s[i] + (self.s[i + 1] - self.s[i]) * u,
            centre,
            radius: self.radii[i] + (self.radii[i + 1] - self.radii[i]) * u,
            distance: (x - centre).norm(),
        }
    }

    /// How far (m) a point is from the tube around a piece, and where on the piece that is; infinitely far if that is
    /// more than `nearest`. Most of the seconds that a mesh takes go by here: few pieces need a division or a root.
    #[inline(always)]
    fn off(&self, x: &Vec3, i: usize, nearest: f64) -> (f64, f64) {
        let (a, b) = (&self.points[i], &self.points[i + 1]);
        let [dx, dy, dz] = [b.x - a.x, b.y - a.y, b.z - a.z];
        let [px, py, pz] = [x.x - a.x, x.y - a.y, x.z - a.z];
        let along = px * dx + py * dy + pz * dz;
        let whole = dx * dx + dy * dy + dz * dz;
        let u = if along <= 0.0 {
            0.0
        } else if along >= whole {
            1.0
        } else {
            along / whole
        };
        let [px, py, pz] = [px - dx * u, py - dy * u, pz - dz * u];
        let radius = self.radii[i] + (self.radii[i + 1] - self.radii[i]) * u;
        let squared = px * px + py * py + pz * pz;
        let most = nearest + radius;
        if most < 0.0 || squared * (1.0 - ROUNDING) > most * most {
            return (f64::INFINITY, u);
        }
        (squared.sqrt() - radius, u)
    }

    /// Groups of pieces whose tubes may be so near (m) to a point.
    fn groups_within(&self, x: &Vec3, distance: f64) -> impl Iterator<Item = usize> {
        let mut next = 0;
        std::iter::from_fn(move || {
            while let Some(ball) = self.balls.get(next) {
                let group = next;
                let beyond = ball.off(x) - distance;
                // Where a group is far, the following ones are as well.
                let skipped = (beyond / self.spacing) as usize;
                next = next.saturating_add(skipped.max(1));
                if beyond <= 0.0 {
                    return Some(group);
                }
            }
            None
        })
    }

    /// Whether a point may lie in its tube: false only where it certainly does not.
    pub fn may_surround(&self, x: &Vec3) -> bool {
        self.groups_within(x, 0.0).next().is_some()
    }

    /// From the first to the last sample that are nearer to a point than `reach` (m) and two radii.
    pub fn samples_near(&self, x: &Vec3, reach: f64) -> Option<[usize; 2]> {
        let is_near = |k: &usize| (self.points[*k] - x).norm() < reach + 2.0 * self.radii[*k];
        let last = self.points.len() - 1;
        let samples = |group: usize| group * GROUP..=((group + 1) * GROUP).min(last);
        // The tube around a sample is nearer than `reach` and one radius.
        let groups: Vec<usize> = self.groups_within(x, reach + self.widest).collect();
        let first = (groups.iter()).find_map(|group| samples(*group).find(is_near))?;
        let mut backwards = groups.iter().rev();
        let last = backwards.find_map(|group| samples(*group).rev().find(is_near));
        Some([first, last.unwrap_or(first)])
    }

    /// Whether the samples of a range, and the one beyond it, are those of another line.
    pub fn coincides(&self, other: &Self, range: Range<usize>) -> bool {
        let [own, others] = [self, other].map(|line| {
            let samples = range.start..(range.end + 1).min(line.points.len());
            (&line.points[samples.clone()], &line.radii[samples])
        });
        own == others
    }

    /// The place of the line whose tube is nearest to a point.
    pub fn foot(&self, x: &Vec3) -> Foot {
        self.foot_near(x, 0..self.points.len())
    }

    /// The arc length (m) at which it first leaves the tube around another one; none if it never does.
    pub fn leaves(&self, other: &Self) -> Option<f64> {
        let mut near = 0usize;
        let mut is_common = true;
        let is_outside = |(i, s): (usize, f64)| {
            let x = self.points[i];
            // Lines of a file often have their first points in common.
            is_common &= other.points.get(i) == Some(&x);
            if is_common {
                near = i;
                return None;
            }
            // The tube is mostly where it was last.
            let around = near.saturating_sub(AHEAD)..near + AHEAD;
            let foot = other.foot_near(&x, around);
            let foot = match foot.distance < foot.radius {
                true => foot,
                false => other.foot(&x),
            };
            near = other.s.partition_point(|s| *s < foot.s);
            (foot.distance >= foot.radius).then_some(s)
        };
        self.places().enumerate().find_map(is_outside)
    }
}

/// Lines that begin as one branch and part.
#[derive(Debug, Clone, PartialEq)]
pub struct Fork {
    /// The arc length (m) at which the first one leaves another.
    pub first: f64,
    /// Classes of lines that stay together there: the number of each line, and the arc length (m) up to which the first
    /// one of the class lies in the tube of a line of another class.
    pub daughters: Vec<(Vec<usize>, f64)>,
}

/// Lines that never leave each other's tubes: their numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inseparable(pub usize, pub usize);

impl Fork {
    /// The lines that stay together with this one, the first of a class.
    pub fn class(&self, line: usize) -> &[usize] {
        let class = self.daughters.iter().find(|(class, _)| class[0] == line);
        class.map_or(&[], |(class, _)| class)
    }
}

/// Where each of several lines leaves the tubes of the others.
#[derive(Debug, Clone)]
pub struct Partings {
    /// Arc length (m) by line and other line; none if it never does.
    apart: Vec<Vec<Option<f64>>>,
}

impl Partings {
    /// Of all pairs.
    pub fn new(lines: &[CentreLine]) -> Self {
        let of_line = |a: usize| {
            let others = lines.iter().enumerate();
            others.map(move |(b, other)| match a == b {
                true => Some(f64::INFINITY),
                false => lines[a].leaves(other),
            })
        };
        let all = (0..lines.len()).into_par_iter();
        Self {
            apart: all.map(|a| of_line(a).collect()).collect(),
        }
    }

    /// Where lines part, again and again, until each is alone or stays with another.
    pub fn forks(&self, all: &[CentreLine]) -> Vec<Fork> {
        let mut forks = Vec::new();
        let mut together: Vec<Vec<usize>> = vec![(0..all.len()).collect()];
        while let Some(lines) = together.pop() {
            if lines.len() > 1
                && let Ok(fork) = self.fork(all, &lines)
            {
                together.extend(fork.daughters.iter().map(|(class, _)| class.clone()));
                forks.push(fork);
            }
        }
        forks
    }

    /// Where these of all lines, two at least, part.
    ///
    /// # Errors
    /// If one does not leave another.
    pub fn fork(&self, all: &[CentreLine], lines: &[usize]) -> Result<Fork, Inseparable> {
        let leave = |a: usize, b: usize| self.apart[a][b].ok_or(Inseparable(a, b));
        let of_line = |&a: &usize| lines.iter().map(|&b| leave(a, b)).collect();
        let apart: Vec<Vec<f64>> = lines.iter().map(of_line).collect::<Result<_, _>>()?;
        let first = (apart.iter().flatten().copied()).fold(f64::INFINITY, f64::min);
        let reach = TOGETHER * all[lines[0]].radius(first);
        let mut classes: Vec<Vec<usize>> = Vec::new();
        for i in 0..lines.len() {
            let mut known = classes.iter_mut();
            match known.find(|class| apart[class[0]][i] > first + reach) {
                Some(class) => class.push(i),
                None => classes.push(vec![i]),
            }
        }
        if let [class] = &classes[..] {
            return Err(Inseparable(lines[class[0]], lines[class[1]]));
        }
        let leaves_others = |class: &Vec<usize>| {
            let others = (0..lines.len()).filter(|j| !class.contains(j));
            others.map(|j| apart[class[0]][j]).fold(0.0, f64::max)
        };
        let daughters = classes.iter().map(|class| {
            let numbers = class.iter().map(|i| lines[*i]).collect();
            (numbers, leaves_others(class))
        });
        Ok(Fork {
            first,
            daughters: daughters.collect(),
        })
    }
}
