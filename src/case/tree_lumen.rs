//! The lumen of a tree from the surface that a segmentation gives: whether it surrounds the centre-lines, without what
//! closes it at their ends, smoothed.

use super::lumen::{Mistake, TRIANGLES, times};
use super::{LengthUnit, TreeKeys, TreeLine};
use crate::Vec3;
use crate::files::{Fault, fault};
use crate::polydata::{OVERLAP, OpenEdge, PolyData, RayHit, Surface, SurfaceSearch};
use std::collections::HashSet;
use std::f64::consts::TAU;
use std::path::Path;

/// Most points and triangles of a surface.
pub(super) const MOST_TRIANGLES: usize = 400_000;
/// Rays of a cross-section, and how many of them may meet nothing, where they look along another branch.
const RAYS: usize = 12;
const MISSING: usize = 4;
/// Distance of cross-sections, in radii.
const STEP: f64 = 0.5;
/// What closes a branch lies within so many radii of its end, and its normals are closer to the line than this
/// (cosine).
const CAP: f64 = 2.5;
const CLOSING: f64 = 0.7;
/// It is open there if its edge encloses this area, in squared radii.
const OPEN: f64 = 0.5;
/// Half a sphere has less than this share of its radius so far before its tip, in radii.
const ROUND: f64 = 0.8;
const BEFORE_TIP: f64 = 0.3;
/// A sac has a neck that is narrower than this share of its radius, within so many radii of its end.
const NECK: f64 = 0.87;
const NECK_WITHIN: f64 = 8.0;
/// A hole has at least this area, in squared radii.
const CRACK: f64 = 1e-3;
/// Distances of a surface from its line, in radii, that are taken for the same unit.
const SAME_UNIT: [f64; 2] = [0.4, 2.5];
/// Shares of the places of all lines that a surface surrounds in a wrong and in the right unit.
const FITS: [f64; 2] = [0.5, 0.8];
/// A surface that leaves more than this share of a line bare, and reaches further beyond the lines than so many radii,
/// is another vessel's, or moved.
const MISPLACED: f64 = 0.05;
const BEYOND: f64 = 1.5;
/// A line in the middle of its lumen is less than so many radii beside it, as a median.
const OFF_CENTRE: f64 = 0.3;
/// Within so many radii of a line there is no more than one surface around it.
const NESTED: f64 = 2.5;
/// What lies further from all lines, in radii, is none of the vessel.
const FAR: f64 = 6.0;
/// Waves of a lumen that are longer than so many radii are no noise.
const SMOOTHEST: f64 = 4.0;
/// Coordinates are kept to this, m.
const DIGITS: f64 = 1e-10;

/// A place of a centre-line.
struct LinePlace {
    x: Vec3,
    along: Vec3,
    radius: f64,
    /// From the beginning of the line, m.
    s: f64,
}

fn places(line: &TreeLine) -> Vec<LinePlace> {
    let mut places = Vec::new();
    let mut s = 0.0;
    let radii = line.radii.windows(2);
    for (points, radii) in line.points.windows(2).zip(radii) {
        let [a, b] = [points[0], points[1]].map(Vec3::from);
        let length = (b - a).norm();
        let pieces = (length / (STEP * radii[0].min(radii[1]))).ceil().max(1.0);
        for i in 0..pieces as usize {
            let u = i as f64 / pieces;
            places.push(LinePlace {
                x: a + (b - a) * u,
                along: (b - a) / length,
                radius: radii[0] + (radii[1] - radii[0]) * u,
                s: s + length * u,
            });
        }
        s += length;
    }
    if let (Some(last), Some(x), Some(radius)) =
        (places.last(), line.points.last(), line.radii.last())
    {
        places.push(LinePlace {
            x: Vec3::from(*x),
            along: last.along,
            radius: *radius,
            s,
        });
    }
    places
}

impl TreeKeys {
    /// Reads the surface of the lumen, if the case names one: its triangles then stand in it. Whether it did.
    ///
    /// The lines must have been checked.
    ///
    /// # Errors
    /// The key to blame, and what is wrong.
    pub(super) fn read_lumen(&mut self) -> Result<bool, Mistake> {
        const KEY: &str = "tree.lumen";
        let Some(path) = &self.lumen else {
            return Ok(false);
        };
        let named = |fault: Fault| (KEY, format!("{}: {fault}", path.display()));
        let Some(unit) = self.unit_of_lumen() else {
            return Err((KEY, "expected its unit of length next to it: tree.lumen_unit = \"mm\", \"m\", \"cm\" or \"um\"".into()));
        };
        if !self.lumen_triangles.is_empty() {
            return Err((
                KEY,
                "the case has tree.lumen_triangles as well: leave out one of the two".into(),
            ));
        }
        let surface = read_surface(path, unit).map_err(named)?;
        let lines: Vec<Vec<LinePlace>> = self.line.iter().flatten().map(places).collect();
        let names = self.names();
        let surface = fitted(surface, &lines, &names, &self.closed, unit).map_err(named)?;
        let smoothing = self.lumen_smoothing.unwrap_or(TRIANGLES * surface.edge());
        let mut radii: Vec<f64> = lines.iter().flatten().map(|place| place.radius).collect();
        radii.sort_by(f64::total_cmp);
        let most = SMOOTHEST * radii[radii.len() / 2];
        if self.lumen_smoothing.is_some_and(|given| given > most) {
            let reason = format!(
                "expected at most {most:.1e}, {SMOOTHEST} times the median radius of the lumen: longer waves are its own shape"
            );
            return Err(("tree.lumen_smoothing_m", reason));
        }
        let surface = surface.smoothed(smoothing);
        let kept = |x: &Vec3| x.map(|c| (c / DIGITS).round() * DIGITS).into();
        self.lumen_points = surface.points().iter().map(kept).collect();
        self.lumen_triangles = (0..surface.triangles())
            .map(|number| surface.triangle(number))
            .collect();
        Ok(true)
    }

    fn unit_of_lumen(&self) -> Option<LengthUnit> {
        self.lumen_unit.or(self.unit)
    }

    /// Which of the lines end within a sac: beyond a neck, where the file's surface is closed and round. None if that
    /// cannot be read.
    pub fn sacs(&self) -> Vec<usize> {
        let surface = (self.lumen.as_ref().zip(self.unit_of_lumen()))
            .and_then(|(path, unit)| read_surface(path, unit).ok());
        let Some(search) = surface.map(SurfaceSearch::new) else {
            return Vec::new();
        };
        let edges = search.surface().open_edges();
        let lines = self.line.iter().flatten().map(places).enumerate();
        let sacs = lines.filter(|(_, line)| {
            let mouth = Mouth::last(line);
            mouth.is_behind_a_neck(line) && !mouth.is_open(&edges) && mouth.is_round(&search)
        });
        sacs.map(|(number, _)| number).collect()
    }

    /// The line that runs furthest beside the middle of its lumen's surface, along most of its way, if one does: in
    /// words.
    pub fn off_centre(&self) -> Option<String> {
        let search = SurfaceSearch::new(self.lumen_surface().ok()??);
        let off = |line: &TreeLine| {
            let ways = places(line).into_iter().filter_map(|place| {
                let arms = arms(&search, &place, 1.0);
                // Of a circle of which one point is looked from, the mean of these is half of the way to its middle.
                let middle: Vec3 = arms.iter().sum::<Vec3>() * (2.0 / RAYS as f64);
                (arms.len() == RAYS).then_some(middle.norm() / place.radius)
            });
            let mut ways: Vec<f64> = ways.collect();
            ways.sort_by(f64::total_cmp);
            ways.get(ways.len() / 2).copied().unwrap_or(0.0)
        };
        let names = self.names().into_iter().skip(1);
        let all = self.line.iter().flatten().map(off).zip(names);
        let (off, name) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (off > OFF_CENTRE).then(|| {
            format!(
                "the line to \"{name}\" runs {off:.2} radii beside the middle of the surface (tree.lumen), although the two are to be of \
                 one vessel in the same coordinates"
            )
        })
    }

    /// The surface of the lumen, if there is one.
    ///
    /// # Errors
    /// If its triangles have points that there are not.
    pub fn lumen_surface(&self) -> Result<Option<Surface>, Fault> {
        if self.lumen_triangles.is_empty() {
            return Ok(None);
        }
        let points = self.lumen_points.iter().map(|x| Vec3::from(*x));
        Surface::of_points(points.collect(), self.lumen_triangles.clone()).map(Some)
    }
}

fn read_surface(path: &Path, unit: LengthUnit) -> Result<Surface, Fault> {
    let data = PolyData::read(path).map_err(Fault::whole)?;
    let surface = Surface::new(&data, unit.metres())?;
    let count = surface.triangles();
    if count > MOST_TRIANGLES {
        return Err(fault!(
            "{count} triangles are more than {MOST_TRIANGLES}: simplify it (in MeshLab \"Quadric Edge Collapse Decimation\")"
        ));
    }
    Ok(surface)
}

/// The part of a surface around the lines, open at their ends but for those that are `closed`.
fn fitted(
    surface: Surface,
    lines: &[Vec<LinePlace>],
    names: &[String],
    closed: &[String],
    unit: LengthUnit,
) -> Result<Surface, Fault> {
    let search = SurfaceSearch::new(surface);
    right_unit(&search, lines, unit)?;
    for (line, name) in lines.iter().zip(&names[1..]) {
        surrounded(&search, line, lines, [name, &names[0]])?;
    }
    not_nested(&search, lines)?;
    let surface = search.surface();
    holes(surface, lines)?;
    let open = lines
        .iter()
        .zip(&names[1..])
        .filter(|(_, name)| !closed.contains(name));
    let mouths = open.map(|(line, _)| Mouth::last(line));
    let edges = surface.open_edges();
    let caps: HashSet<usize> = mouths
        .chain([Mouth::first(&lines[0])])
        .flat_map(|mouth| mouth.cap(&search, &edges))
        .collect();
    let is_far = |corners: [Vec3; 3]| {
        let far = |place: &LinePlace| (place.x - corners[0]).norm() > FAR * place.radius;
        lines.iter().flatten().all(far)
    };
    surface.filtered(|number, corners| !caps.contains(&number) && !is_far(corners))
}

/// Where a line leaves the lumen.
struct Mouth {
    /// The end of the line, m.
    x: Vec3,
    radius: f64,
    /// Unit vector out of the lumen.
    outward: Vec3,
    /// The line from within the lumen to its end, m.
    way: Vec<Vec3>,
}

impl Mouth {
    fn first(line: &[LinePlace]) -> Self {
        let end = &line[0];
        let near = line.iter().take_while(|p| p.s <= OVERLAP * end.radius);
        let mut way: Vec<Vec3> = near.map(|place| place.x).collect();
        way.reverse();
        Self {
            x: end.x,
            radius: end.radius,
            outward: -end.along,
            way,
        }
    }

    fn last(line: &[LinePlace]) -> Self {
        let end = &line[line.len() - 1];
        let near = line.iter();
        let near = near.skip_while(|p| end.s - p.s > OVERLAP * end.radius);
        Self {
            x: end.x,
            radius: end.radius,
            outward: end.along,
            way: near.map(|place| place.x).collect(),
        }
    }

    /// Whether the surface is open here.
    fn is_open(&self, edges: &[OpenEdge]) -> bool {
        edges.iter().any(|edge| {
            (edge.centre - self.x).norm() < OVERLAP * self.radius
                && edge.area > OPEN * self.radius.powi(2)
        })
    }

    /// Where the line passes the surface, or would if it went on.
    fn met(&self, search: &SurfaceSearch) -> Option<(RayHit, Vec3)> {
        let beyond = self.x + self.outward * (OVERLAP * self.radius);
        let way: Vec<&Vec3> = self.way.iter().chain([&beyond]).collect();
        way.windows(2)
            .find_map(|pair| search.between(pair[0], pair[1]))
    }

    /// Whether the lumen grows narrow towards what closes it, as half a sphere does and the end of a tube does not.
    fn is_round(&self, search: &SurfaceSearch) -> bool {
        let Some((_, x)) = self.met(search) else {
            return false;
        };
        let before = LinePlace {
            x: x - self.outward * (BEFORE_TIP * self.radius),
            along: self.outward,
            radius: self.radius,
            s: 0.0,
        };
        let mut around = around(search, &before, 1.0);
        around.sort_by(f64::total_cmp);
        around.len() >= RAYS - MISSING && around[around.len() / 2] < ROUND * self.radius
    }

    /// Whether the lumen is narrower on the way here, along its line.
    fn is_behind_a_neck(&self, line: &[LinePlace]) -> bool {
        let length = line[line.len() - 1].s;
        let near = line.iter();
        let near = near.filter(|place| length - place.s < NECK_WITHIN * self.radius);
        near.map(|place| place.radius).fold(self.radius, f64::min) < NECK * self.radius
    }

    /// The triangles that close the surface here, if it is not open: that which the line passes, or would if it went
    /// on, and those next to it that lie across the line as well. (The wall of another branch may lie across it too.)
    fn cap(&self, search: &SurfaceSearch, edges: &[OpenEdge]) -> HashSet<usize> {
        if self.is_open(edges) {
            return HashSet::new();
        }
        let lies_across = |[a, b, c]: [Vec3; 3]| {
            let (middle, across) = ((a + b + c) / 3.0, (b - a).cross(&(c - a)).normalize());
            let arm = middle - self.x;
            arm.norm() < CAP * self.radius
                && arm.dot(&self.outward).abs() < OVERLAP * self.radius
                && across.dot(&self.outward).abs() > CLOSING
        };
        let Some((met, _)) = self.met(search) else {
            return HashSet::new();
        };
        let surface = search.surface();
        match lies_across(surface.triangle(met.triangle).map(|i| surface.points()[i])) {
            true => surface.connected(met.triangle, lies_across),
            false => HashSet::new(),
        }
    }
}

/// A unit vector across a line.
fn across(place: &LinePlace) -> Vec3 {
    let side = match place.along.x.abs() < 0.8 {
        true => Vec3::x(),
        false => Vec3::y(),
    };
    place.along.cross(&side).normalize()
}

/// Ways to the surface, times `factor`, around a place; those of rays that meet it.
fn arms(search: &SurfaceSearch, place: &LinePlace, factor: f64) -> Vec<Vec3> {
    let first = across(place);
    let second = place.along.cross(&first);
    let rays = (0..RAYS).filter_map(|i| {
        let (sin, cos) = (TAU * i as f64 / RAYS as f64).sin_cos();
        let direction = first * cos + second * sin;
        let hit = search.ray(&(place.x / factor), &direction)?;
        Some(direction * (hit.distance * factor))
    });
    rays.collect()
}

/// Their lengths.
fn around(search: &SurfaceSearch, place: &LinePlace, factor: f64) -> Vec<f64> {
    let arms = arms(search, place, factor).into_iter();
    arms.map(|arm| arm.norm()).collect()
}

fn is_surrounded(search: &SurfaceSearch, place: &LinePlace) -> bool {
    around(search, place, 1.0).len() >= RAYS - MISSING
}

/// That the surface is not in another unit than is said.
fn right_unit(
    search: &SurfaceSearch,
    lines: &[Vec<LinePlace>],
    said: LengthUnit,
) -> Result<(), Fault> {
    let share = |factor: f64| {
        let all = || lines.iter().flatten().step_by(3);
        let fits = |place: &&LinePlace| {
            let mut met = around(search, place, factor);
            met.sort_by(f64::total_cmp);
            let [least, most] = SAME_UNIT.map(|radii| radii * place.radius);
            met.len() >= RAYS - MISSING && (least..most).contains(&met[met.len() / 4])
        };
        all().filter(fits).count() as f64 / all().count() as f64
    };
    if share(1.0) >= FITS[0] {
        return Ok(());
    }
    let others = LengthUnit::ALL.into_iter().filter(|other| *other != said);
    let factor = |other: &LengthUnit| other.metres() / said.metres();
    if let Some(other) = others.clone().find(|other| share(factor(other)) >= FITS[1]) {
        return Err(fault!(
            "the surface is {} the centre-lines need: in {other} it fits, in {said} it does not; correct its unit \
             (tree.lumen_unit, or tree.unit of the lines)",
            times(1.0 / factor(&other))
        ));
    }
    Ok(())
}

/// That the surface is around one of the lines, but for a bit at its ends.
fn surrounded(
    search: &SurfaceSearch,
    line: &[LinePlace],
    lines: &[Vec<LinePlace>],
    [name, inlet]: [&str; 2],
) -> Result<(), Fault> {
    let bare: Vec<bool> = (line.iter())
        .map(|place| !is_surrounded(search, place))
        .collect();
    let length = line[line.len() - 1].s;
    let counts = |i: &usize| {
        let near = OVERLAP * line[*i].radius;
        bare[*i] && line[*i].s > near && line[*i].s < length - near
    };
    let mut counted = (0..line.len()).filter(counts);
    let Some(first) = counted.next() else {
        return Ok(());
    };
    let last = counted.next_back().unwrap_or(first);
    let is_cut_twice = bare[..=first].iter().chain(&bare[last..]).all(|bare| *bare);
    let share = bare.iter().filter(|bare| **bare).count() as f64 / bare.len() as f64;
    let (own, of_lines) = (search.surface().bounds(), bounds(lines, 0.0));
    let [low, high] = bounds(lines, BEYOND);
    let reaches_beyond = own[0].inf(&low) != low || own[1].sup(&high) != high;
    if share > MISPLACED && (is_cut_twice || reaches_beyond) {
        let show = |p: Vec3| format!("({:.4}, {:.4}, {:.4})", p.x, p.y, p.z);
        let [own, of_lines] =
            [own, of_lines].map(|[low, high]| format!("from {} to {} m", show(low), show(high)));
        return Err(fault!(
            "the surface does not enclose the line to \"{name}\", {:.0} % of which lie outside, first {:.2} mm from its beginning. The surface \
             reaches {own}, the lines {of_lines}: are both in the same coordinates and units (tree.lumen_unit, or tree.unit of the lines)?",
            1e2 * share,
            1e3 * line[first].s
        ));
    }
    let place = &line[first];
    let x = place.x;
    let there = format!("({:.4e}, {:.4e}, {:.4e}) m", x.x, x.y, x.z);
    if bare[first..].iter().all(|bare| *bare) {
        return Err(fault!(
            "in the branch to \"{name}\" the surface ends at {there}, {:.2} mm before the centre-line does: cut the line off there, or take a \
             longer surface",
            1e3 * (length - place.s)
        ));
    }
    if bare[..=first].iter().all(|bare| *bare) {
        return Err(fault!(
            "at \"{inlet}\" the surface begins only {:.2} mm after the centre-line does: cut the line off there, or take a longer surface",
            1e3 * line
                .iter()
                .zip(&bare)
                .find(|(_, bare)| !**bare)
                .map_or(0.0, |(place, _)| place.s)
        ));
    }
    Err(fault!(
        "the line to \"{name}\" leaves the surface at {there}, {:.2} mm from its beginning: it has a hole there, or the line runs next to it",
        1e3 * place.s
    ))
}

/// Least and largest coordinates (m) of the lines, and of what lies within so many radii of them.
fn bounds(lines: &[Vec<LinePlace>], radii: f64) -> [Vec3; 2] {
    let start = [f64::INFINITY, f64::NEG_INFINITY].map(Vec3::repeat);
    lines.iter().flatten().fold(start, |[low, high], place| {
        let slack = Vec3::repeat(radii * place.radius);
        [low.inf(&(place.x - slack)), high.sup(&(place.x + slack))]
    })
}

/// That no surface lies within another: a ray from a line would meet both.
fn not_nested(search: &SurfaceSearch, lines: &[Vec<LinePlace>]) -> Result<(), Fault> {
    let meets_two = |place: &&LinePlace| {
        let side = across(place);
        let reach = NESTED * place.radius;
        let both = [side, -side];
        (both.iter()).all(|side| search.crossings(&place.x, side, reach) == 2)
    };
    let twice = lines.iter().flatten().filter(meets_two).count();
    match 2 * twice > lines.iter().flatten().count() {
        true => Err(
            "one surface lies within another, or next to it: rays from the centre-lines meet two. Delete the one that is not the \
             lumen, such as the outside of the wall"
                .into(),
        ),
        false => Ok(()),
    }
}

/// A surface may be open where a line ends, and nowhere else near the lines.
fn holes(surface: &Surface, lines: &[Vec<LinePlace>]) -> Result<(), Fault> {
    let starts = lines.iter().map(|line| &line[0]);
    let ends = lines.iter().map(|line| &line[line.len() - 1]);
    let ends: Vec<&LinePlace> = starts.chain(ends).collect();
    for edge in surface.open_edges() {
        let p = edge.centre;
        let is_end = |end: &&LinePlace| (p - end.x).norm() < CAP * end.radius;
        let all = lines.iter().flatten();
        let off = |place: &&LinePlace| (p - place.x).norm() / place.radius;
        let Some(nearest) = all.min_by(|a, b| off(a).total_cmp(&off(b))) else {
            continue;
        };
        let is_crack = edge.area < CRACK * nearest.radius.powi(2);
        if is_crack || off(&nearest) > CAP || ends.iter().any(is_end) {
            continue;
        }
        return Err(fault!(
            "the surface has a hole of {} edges around ({:.4e}, {:.4e}, {:.4e}) m: it must be closed, or open at the ends of the lines only \
             (a branch that is cut off there needs a centre-line, or must be closed)",
            edge.edges,
            p.x,
            p.y,
            p.z
        ));
    }
    Ok(())
}
