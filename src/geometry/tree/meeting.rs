//! How branches meet: as equals, or a thin one at the side of another.
//!
//! What the worst cell is like decides, that of a usual mesh in cells and that of one in elements: so both have the
//! same junctions.

use super::Tree;
use super::branch::Branch;
use super::error::{Parted, TreeError};
use super::junction::{BranchEnd, Junction, Parting};
use super::lumen::Lumen;
use super::plan::{GOOD, Plan, Search};
use super::section::SectionGrid;
use super::shape::{INCLINED, Shape, USUAL};
use super::side::{self, Side};
use super::slicer::Slicer;
use crate::Vec3;
use crate::curve::CentreLine;
use std::sync::Arc;

/// A branch is thin whose radius is less than this share of that of the one that goes straight on, and may be meshed as
/// one that is less than the second ...
const THIN: f64 = 0.65;
const WIDEST: f64 = 0.85;
/// ... by the cosine of the angle that it turns.
const STRAIGHT: f64 = 0.5;
/// A thin one meets the other as an equal if a usual junction of half-discs is good; else the better one of the two
/// ways counts if it is better than this. Half-discs may lie in an unusual layout ...
const LEAST: f64 = 0.02;
/// ... unless the thin one has less than this share of the other's radius, and would squeeze them.
const SQUEEZED: f64 = 0.45;
/// Other shapes of a thin branch than the usual one are tried if that is not good and the cosine of the angle at which
/// the branch leaves is above this (50°; backwards 130°): elsewhere they gain little, and the usual one is more
/// accurate.
const INCLINATION: f64 = 0.643;
/// How much of the lines is meshed to find that out, in radii upstream and downstream.
const AROUND: f64 = 10.0;

/// Where branches meet.
#[derive(Debug, Clone)]
pub enum Meeting {
    /// As equals.
    Fan(Junction),
    /// A thin one begins at the side of another.
    Side(Side),
}

impl Meeting {
    /// Lines that part, as equals unless one goes straight on and the other is thin and would be squeezed.
    pub fn new(
        slicer: &Slicer,
        trunk: &CentreLine,
        parting: &Parting,
        path: impl Fn(usize) -> CentreLine,
    ) -> Result<Self, TreeError> {
        let lumen = &slicer.lumen;
        let refused = |error| Err(parted(lumen, trunk, parting, error));
        let middle = trunk.at(trunk.length());
        let thin = |share: f64| thin(lumen, parting, share);
        let is_squeezed = thin(SQUEEZED).is_some();
        let planned = |slicer: &Slicer| Plan::new(slicer, trunk, parting);
        // In the cells or elements that are asked for.
        let fan = || {
            let search = Search::new(slicer, trunk, parting);
            let usual = search.usual();
            let of_usual = usual.as_ref().map_or(-1.0, |plan| plan.worst);
            let other = || search.adapted(&planned(&like(slicer)).ok()?).ok();
            let other = (of_usual <= GOOD && !is_squeezed).then(other).flatten();
            let better = other.filter(|plan| plan.worst > of_usual);
            match better.map_or(usual, Ok)? {
                plan if plan.worst > 0.0 => search.junction(&plan).map(Self::Fan),
                _ => Err(TreeError::InsideOut(middle)),
            }
        };
        let Some(pair) = thin(WIDEST) else {
            return fan().or_else(refused);
        };
        let is_thin = thin(THIN).is_some();
        let least = |plans: [Result<Plan, TreeError>; 2]| {
            let [cells, elements] = plans.map(|plan| plan.map_or(-1.0, |plan| plan.worst));
            cells.min(elements)
        };
        let usual_plan = |slicer: Slicer| Search::new(&slicer, trunk, parting).usual();
        let is_thin_sac = is_thin && lumen.lines[pair[1]].is_closed;
        let of_fan = (!is_thin_sac).then(|| least(usual(lumen).map(usual_plan)));
        let enough = if is_thin { GOOD } else { LEAST };
        if of_fan.is_some_and(|quality| quality > enough) {
            return fan().or_else(refused);
        }
        let of_side = Self::side_shape(lumen, trunk, &path, pair);
        let found = of_side.as_ref().map_or(-1.0, |(quality, _)| *quality);
        let of_fan = of_fan.map(|of_usual| match found > GOOD || is_squeezed {
            true => of_usual,
            false => least(usual(lumen).map(|slicer| planned(&slicer))),
        });
        let side = || {
            let [line, branch] = pair;
            match of_side? {
                (quality, shape) if quality > LEAST => {
                    Side::new(slicer, &path(line), line, branch, shape).map(Self::Side)
                }
                _ => Err(TreeError::InsideOut(middle)),
            }
        };
        let meeting = match of_fan {
            None => side().or_else(|error| fan().map_err(|_| error)),
            Some(of_fan) if is_thin || found > of_fan => match found > of_fan {
                true => side().or_else(|error| fan().map_err(|_| error)),
                false => fan().or_else(|_| side()),
            },
            Some(_) => fan().or_else(|error| side().map_err(|_| error)),
        };
        meeting.or_else(refused)
    }

    /// The shape of a branch at the side of another, and the scaled Jacobian of the worst cell or element there: the
    /// first one that is good, or the best.
    fn side_shape(
        lumen: &Lumen,
        trunk: &CentreLine,
        path: &impl Fn(usize) -> CentreLine,
        [line, branch]: [usize; 2],
    ) -> Result<(f64, Shape), TreeError> {
        let [parent, thin] = [path(line), path(branch)];
        let s = trunk.length();
        let r = trunk.radius(s);
        let exit = thin.leaves(&parent).unwrap_or(s);
        let along = thin.tangent(exit + thin.radius(exit));
        let onward = parent.tangent(parent.foot(&thin.at(exit)).s);
        let is_inclined = along.dot(&onward).abs() > INCLINATION;
        let begin = s - AROUND * r;
        let parent = parent.part(begin, exit + AROUND * r);
        let thin = thin.part(begin, exit + AROUND * thin.radius(exit));
        let beside = Lumen::new(
            vec![parent.clone(), thin.clone()],
            lumen.surface.as_ref().map(Arc::clone),
        );
        let slicers = usual(&beside);
        let quality = |shape| Self::side_quality(&slicers, [&parent, &thin], shape);
        let usual = quality(USUAL);
        let mut best = usual.as_ref().ok().map(|q| (*q, USUAL));
        let others = if is_inclined { &INCLINED[..] } else { &[] };
        for &shape in others {
            if best.is_some_and(|(q, _)| q > GOOD) {
                break;
            }
            let found = quality(shape).ok().map(|q| (q, shape));
            if found.map(|(q, _)| q) > best.map(|(q, _)| q) {
                best = found;
            }
        }
        // If none fits, the error is that of the usual one.
        best.map_or_else(|| usual.map(|q| (q, USUAL)), Ok)
    }

    /// The scaled Jacobian of the worst cell or element around a branch of this shape at the side of another.
    fn side_quality(
        slicers: &[Slicer],
        [parent, thin]: [&CentreLine; 2],
        shape: Shape,
    ) -> Result<f64, TreeError> {
        let mut worst = f64::INFINITY;
        for slicer in slicers {
            let side = Side::new(slicer, parent, 0, 1, shape)?;
            let branch = |line: usize, axis: &CentreLine, from, to| Branch {
                lines: vec![line],
                axis: axis.clone(),
                from,
                to,
            };
            let branches = vec![
                branch(0, parent, None, Some(0)),
                branch(0, parent, Some((0, 0)), None),
                branch(1, thin, Some((0, 1)), None),
            ];
            let tree = Tree::of_parts(slicer.clone(), vec![Self::Side(side)], branches)?;
            let found = tree.qualities().into_iter().map(|(quality, _)| quality);
            worst = found.fold(worst, f64::min);
        }
        Ok(worst)
    }

    /// The middle, m.
    pub fn centre(&self) -> &Vec3 {
        match self {
            Self::Fan(fan) => &fan.centre,
            Self::Side(side) => &side.centre,
        }
    }

    /// From where the rims of a branch count, that of the parent or of a daughter.
    pub fn axis(&self, daughter: Option<usize>) -> Vec3 {
        match (self, daughter) {
            (Self::Fan(fan), _) => fan.axis,
            (Self::Side(side), Some(1)) => side.flow,
            (Self::Side(side), _) => side.axis,
        }
    }

    pub fn parent(&self) -> &BranchEnd {
        match self {
            Self::Fan(fan) => &fan.parent,
            Self::Side(side) => &side.parent,
        }
    }

    pub fn daughters(&self) -> &[BranchEnd] {
        match self {
            Self::Fan(fan) => &fan.daughters,
            Self::Side(side) => &side.daughters,
        }
    }
}

/// Usual cells, and usual elements.
fn usual(lumen: &Lumen) -> [Slicer; 2] {
    let nodes = fsi_numerics::quadrature::Rule::gauss_lobatto(5).points;
    let slicer = |(grid, along)| Slicer {
        lumen: lumen.clone(),
        grid,
        along,
    };
    [
        (SectionGrid::of_cells(6, 5, 3.0), 0.4),
        (SectionGrid::of_elements(2, 2, 1.5, &nodes), 1.0),
    ]
    .map(slicer)
}

/// Usual cells if these are cells, or usual elements.
fn like(slicer: &Slicer) -> Slicer {
    let [cells, elements] = usual(&slicer.lumen);
    match slicer.grid.degree() {
        1 => cells,
        _ => elements,
    }
}

/// What is wrong where lines part, with the angles and radii there.
fn parted(lumen: &Lumen, trunk: &CentreLine, parting: &Parting, error: TreeError) -> TreeError {
    let end = trunk.length();
    let radius = trunk.radius(end);
    let upstream = trunk.tangent(end - 4.0 * radius);
    let daughter = |&(line, s): &(usize, f64)| {
        let line = &lumen.lines[line];
        let s = s + line.radius(s);
        let cosine = upstream.dot(&line.tangent(s)).clamp(-1.0, 1.0);
        (cosine.acos().to_degrees(), line.radius(s) / radius)
    };
    let parted = Parted {
        place: trunk.at(end),
        daughters: parting.iter().map(daughter).collect(),
    };
    TreeError::Parting(Box::new(parted), Box::new(error))
}

/// The line that goes straight on, and that of a thin branch beside it, if these are the two that part.
fn thin(lumen: &Lumen, parting: &Parting, share: f64) -> Option<[usize; 2]> {
    let &[(a, s), (b, t)] = parting else {
        return None;
    };
    let is_thin = |(line, s): (usize, f64), (branch, t): (usize, f64)| {
        let (line, branch) = (&lumen.lines[line], &lumen.lines[branch]);
        let at = |line: &CentreLine, s: f64, radii: f64| s + radii * line.radius(s);
        let upstream = line.tangent(at(line, s, -2.0));
        let downstream = line.tangent(at(line, s, 1.0));
        let t = branch.leaves(line).unwrap_or(t);
        let wide = line
            .radius(at(line, s, 1.0))
            .min(line.radius(at(line, s, -2.0)));
        side::neck(branch, t) < share * wide && upstream.dot(&downstream) > STRAIGHT
    };
    match (is_thin((a, s), (b, t)), is_thin((b, t), (a, s))) {
        (true, _) => Some([a, b]),
        (_, true) => Some([b, a]),
        _ => None,
    }
}
