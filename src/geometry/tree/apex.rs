//! Points of the wall between lines that part: the key points of a junction.

use super::error::TreeError;
use super::lumen::Lumen;
use crate::Vec3;
use crate::curve::CentreLine;

/// How far the surface may lie from where lines part, in radii.
const REACH: f64 = 4.0;

/// Finds the point of the wall between two lines that part, for the direction of the flow upstream, and each line with
/// the arc length (m) where it parts.
pub type Apex = fn(&Lumen, &Vec3, (usize, f64), (usize, f64)) -> Result<Vec3, TreeError>;

/// Places that are looked at along the lines, from two radii upstream of where they part to eight downstream.
const STEPS: usize = 200;

/// Arc length (m) of such a place from there on, for lines of this radius (m).
fn step(i: usize, radius: f64) -> f64 {
    radius * (-2.0 + 10.0 * i as f64 / STEPS as f64)
}

/// Where halfway between the walls of two lines the wall is met. Where the lines leave in nearly opposite directions,
/// these places may stay within a surface: it is then met along the flow.
pub fn apex_between(
    lumen: &Lumen,
    flow: &Vec3,
    (a, s): (usize, f64),
    (b, t): (usize, f64),
) -> Result<Vec3, TreeError> {
    let (p, q) = (&lumen.lines[a], &lumen.lines[b]);
    let r = p.radius(s).max(q.radius(t));
    let at = |u: f64| {
        let (f, g) = (p.radius(s + u), q.radius(t + u));
        (p.at(s + u) * g + q.at(t + u) * f) / (f + g)
    };
    let u = |i: usize| step(i, r);
    if let Some(surface) = &lumen.surface {
        // From the shared branch out of the lumen.
        let leaves = |i: usize| surface.between(&at(u(i)), &at(u(i + 1)));
        let ahead = || {
            let mean = (past_tangent(p, s) + past_tangent(q, t) + flow).normalize();
            let hit = surface.ray(&at(0.0), &mean)?;
            let x = at(0.0) + mean * hit.distance;
            (hit.distance < REACH * r).then_some((hit, x))
        };
        let met = (0..STEPS).find_map(leaves).or_else(ahead);
        return met.map(|(_, x)| x).ok_or(TreeError::Apex(p.at(s)));
    }
    let is_inside = |u: f64| lumen.near(&p.at(s + u)).value(&at(u)) < 0.0;
    let mut is_next = is_inside(u(0));
    let place = (0..STEPS).find(|i| {
        let is_this = std::mem::replace(&mut is_next, is_inside(u(i + 1)));
        is_this && !is_next
    });
    let i = place.ok_or(TreeError::Apex(p.at(s)))?;
    let [low, _] = halved([u(i), u(i + 1)], 50, is_inside);
    Ok(at(low))
}

/// Where the chord between places of the two lines, further and further downstream, touches the surface first. What
/// lies halfway between the lines may be within a sac.
pub fn apex_of_chord(
    lumen: &Lumen,
    _: &Vec3,
    (a, s): (usize, f64),
    (b, t): (usize, f64),
) -> Result<Vec3, TreeError> {
    let (p, q) = (&lumen.lines[a], &lumen.lines[b]);
    let r = p.radius(s).max(q.radius(t));
    let none = || TreeError::Apex(p.at(s));
    let surface = lumen.surface.as_ref().ok_or_else(none)?;
    let on = |line: &CentreLine, s: f64| line.at(s.min(line.length()));
    let crossed = |u: f64| surface.between(&on(p, s + u), &on(q, t + u));
    let first = (1..=STEPS).find(|i| crossed(step(*i, r)).is_some());
    let first = first.ok_or_else(none)?;
    let ends = [step(first - 1, r), step(first, r)];
    let [_, high] = halved(ends, 20, |u| crossed(u).is_none());
    let back = surface.between(&on(q, t + high), &on(p, s + high));
    let ((_, from), (_, to)) = crossed(high).zip(back).ok_or_else(none)?;
    Ok(surface.nearest(&(0.5 * (from + to))))
}

/// Ends of an interval that is halved so often: what is true at the lower end stays so, and false at the upper one.
fn halved([mut low, mut high]: [f64; 2], times: usize, is_low: impl Fn(f64) -> bool) -> [f64; 2] {
    for _ in 0..times {
        let middle = 0.5 * (low + high);
        match is_low(middle) {
            true => low = middle,
            false => high = middle,
        }
    }
    [low, high]
}

/// The tangent of a line a radius downstream of a place.
fn past_tangent(line: &CentreLine, s: f64) -> Vec3 {
    line.tangent(s + line.radius(s))
}
