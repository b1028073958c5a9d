//! A junction: half-discs that share an axis, one between each two neighbouring branches.
//!
//! The branches, parent and daughters, lie around an axis across the plane in which they spread. Each two neighbours
//! share a half-disc from the axis to a key point of the lumen's surface between them: the apex of two daughters, or a
//! point on the outer side of parent and daughter. A branch begins or ends with the cross-section, folded along the
//! axis, of the half-discs on its two sides; a few cross-sections further on it is plane. (Compare Verma et al. 2005
//! and De Santis et al. 2011, whose branches share one line as well.)

use super::apex::{Apex, apex_between, apex_of_chord};
use super::error::TreeError;
use super::layout::Layout;
use super::lumen::Lumen;
use super::section::{CrossSection, worst_between};
use super::slicer::{Slicer, across};
use super::unfolding::Unfolding;
use crate::Vec3;
use crate::curve::CentreLine;
use std::f64::consts::PI;

/// Plane cross-sections end so far upstream of the centre, in radii of the parent ...
const PARENT_CUT: f64 = 1.5;
/// ... and begin so far downstream of the apices, in radii of the daughter.
const DAUGHTER_CUT: f64 = 1.0;
/// The plane cross-sections of a branch take at least this many radii.
pub(super) const LEAST_LENGTH: f64 = 0.3;
/// The smallest angle between two half-discs, rad.
const LEAST_ANGLE: f64 = 0.35;

/// The end of a branch at a junction.
#[derive(Debug, Clone, Copy)]
pub struct BranchEnd {
    /// One of the lines that begin, or go on, with it.
    pub line: usize,
    /// Where its plane cross-sections begin, or end, m.
    pub cut: Vec3,
}

/// Where branches meet.
#[derive(Debug, Clone)]
pub struct Junction {
    /// The middle of the axis, m.
    pub centre: Vec3,
    /// Unit vector along the axis.
    pub axis: Vec3,
    /// The parent.
    pub parent: BranchEnd,
    /// The daughters, in the order of the half-discs.
    pub daughters: Vec<BranchEnd>,
    /// Rims of the half-discs (m), from one end of the axis to the other: between parent and first daughter, daughter
    /// and daughter, last daughter and parent.
    rims: Vec<Vec<Vec3>>,
    /// The smallest scaled Jacobian of the hexahedra around it.
    pub worst: f64,
}

/// Lines that part: each with the arc length (m) up to which it lies in another's tube.
pub type Parting = [(usize, f64)];

/// The directions in which branches spread.
struct Spread {
    /// Along the parent.
    flow: Vec3,
    /// Across it, from one daughter to the others.
    across: Vec3,
    /// Across both.
    axis: Vec3,
}

/// What all layouts of a junction have in common.
pub struct Site<'a> {
    pub slicer: &'a Slicer,
    trunk: &'a CentreLine,
    /// The lines that part, from one side to the other.
    pub order: Vec<(usize, f64)>,
    spread: Spread,
}

impl Junction {
    /// The folded cross-section of the parent (`None`) or of a daughter; its rim begins at the end of the axis and
    /// turns counter-clockwise about the flow.
    pub fn section(&self, daughter: Option<usize>) -> CrossSection {
        let (low, high) = match daughter {
            None => (0, self.rims.len() - 1),
            Some(i) => (i, i + 1),
        };
        let back = self.rims[high].iter().rev().skip(1);
        let mut rim: Vec<Vec3> = self.rims[low].iter().chain(back).copied().collect();
        rim.pop();
        CrossSection::new(self.centre, rim)
    }

    /// Across the plane cross-section where the parent (`None`) or a daughter begins, at the arc length `s` (m): along
    /// its line, but from the neck of a sac that ends there.
    pub fn tangent(&self, daughter: Option<usize>, line: &CentreLine, s: f64) -> Vec3 {
        if !line.is_closed || s < line.length() {
            return line.tangent(s);
        }
        let neck = self.section(daughter).rim;
        let middle = neck.iter().sum::<Vec3>() / neck.len() as f64;
        (line.at(s) - middle).normalize()
    }

    /// See [`Junction::worst`]; if that is less than `least`, the scaled Jacobian of the first such hexahedron.
    ///
    /// # Errors
    /// If the surface is open there.
    pub fn quality(&self, site: &Site, least: impl Fn() -> f64) -> Result<f64, TreeError> {
        let Site { slicer, trunk, .. } = site;
        let degree = slicer.grid.degree();
        let daughters = self.daughters.iter().enumerate();
        let daughters = daughters.map(|(i, end)| (Some(i), *end));
        let mut worst = f64::INFINITY;
        for (daughter, end) in [(None, self.parent)].into_iter().chain(daughters) {
            let line = match daughter {
                None => trunk,
                Some(_) => &slicer.lumen.lines[end.line],
            };
            let foot = line.foot(&end.cut);
            let tangent = self.tangent(daughter, line, foot.s);
            let (upstream, radius) = (daughter.is_none(), foot.radius);
            let first = across(&self.axis, &tangent);
            let plane = slicer.plane_near(line, foot.s, [&tangent, &first], 0.0, upstream)?;
            let mut last = self.section(daughter);
            let unfolding = Unfolding::new(slicer, last.clone(), plane, &tangent, radius, upstream);
            // Layer by layer of cells or elements: the first is mostly the worst.
            for layer in 0..unfolding.intervals() / degree {
                let mut sections = vec![last];
                sections.extend(unfolding.sections(layer * degree + 1..=(layer + 1) * degree)?);
                last = sections[degree].clone();
                if upstream {
                    sections.reverse();
                }
                worst = worst.min(worst_between(&slicer.grid, &sections, least()));
                if worst < least() {
                    return Ok(worst);
                }
            }
        }
        Ok(worst)
    }
}

impl<'a> Site<'a> {
    pub fn new(slicer: &'a Slicer, trunk: &'a CentreLine, parting: &Parting) -> Self {
        let lumen = &slicer.lumen;
        let spread = Spread::of(lumen, parting);
        let mut order = parting.to_vec();
        let place = |&(line, s): &(usize, f64)| past(&lumen.lines[line], s).dot(&spread.across);
        order.sort_by(|a, b| place(a).total_cmp(&place(b)));
        Self {
            slicer,
            trunk,
            order,
            spread,
        }
    }

    /// The apices between neighbours, found in each way that there is.
    pub fn apices(&self) -> Vec<Result<Vec<Vec3>, TreeError>> {
        let lumen = &self.slicer.lumen;
        let ways: &[Apex] = match lumen.surface {
            Some(_) => &[apex_of_chord, apex_between],
            None => &[apex_between],
        };
        let pairs = self.order.windows(2);
        let apices = |way: &Apex| {
            let apex = |pair: &[(usize, f64)]| way(lumen, &self.spread.flow, pair[0], pair[1]);
            pairs.clone().map(apex).collect()
        };
        ways.iter().map(apices).collect()
    }

    /// The junction with this layout between these apices; how good it is is not known yet.
    ///
    /// # Errors
    /// If the lines leave at angles that are too small, or the surface is open there.
    pub fn junction(&self, apices: &[Vec3], layout: &Layout) -> Result<Junction, TreeError> {
        let Slicer { lumen, grid, .. } = self.slicer;
        let (trunk, order) = (self.trunk, &self.order);
        let Spread { flow, across, axis } = &self.spread.leaning(layout.lean);
        let mean = |all: &mut dyn Iterator<Item = Vec3>| all.sum::<Vec3>() / order.len() as f64;
        let crotch = apices.iter().sum::<Vec3>() / apices.len() as f64;
        let upstream = crotch - flow * (layout.back * trunk.radius(trunk.length()));
        let radius = trunk.foot(&upstream).radius;
        let mut centre = crotch - flow * (layout.back * radius);
        // Between the lines there, and in the middle of the lumen along the axis.
        for _ in 0..2 {
            let feet = mean(
                &mut order
                    .iter()
                    .map(|(line, _)| lumen.lines[*line].foot(&centre).centre),
            );
            let off = feet + across * (layout.aside * radius) - centre;
            centre += off - flow * off.dot(flow);
            let near = lumen.near(&centre);
            let [up, down] = [*axis, -axis].map(|direction| near.ray(&centre, &direction));
            let (up, down) = up.zip(down).ok_or(TreeError::Open(centre))?;
            centre += axis * (0.5 * (up - down));
        }
        let daughters: Vec<BranchEnd> = (order.iter().enumerate())
            .map(|(i, &(line, s))| {
                let path = &lumen.lines[line];
                // Those on its two sides.
                let own = &apices[i.saturating_sub(1)..(i + 1).min(apices.len())];
                let feet = own.iter().map(|apex| path.foot(apex).s);
                let beyond = feet.fold(s, f64::max);
                let cut = beyond + layout.cuts[1] * DAUGHTER_CUT * path.radius(s);
                let is_short = path.length() - cut < LEAST_LENGTH * path.radius(cut);
                let cut = match path.is_closed && is_short {
                    true => path.length(),
                    false => cut,
                };
                BranchEnd {
                    line,
                    cut: path.at(cut),
                }
            })
            .collect();
        // Angles about the axis, from the flow's direction on: halfway between parent and daughter, and the apices.
        let angle = |x: &Vec3| {
            let arm = x - centre;
            arm.dot(across).atan2(arm.dot(flow))
        };
        let of_daughter = |end: &BranchEnd| angle(&end.cut);
        let [first, at_apices, last] = layout.turned;
        let mut keys = vec![0.5 * (of_daughter(&daughters[0]) - PI) + first];
        keys.extend(apices.iter().map(|apex| angle(apex) + at_apices));
        keys.push(0.5 * (of_daughter(&daughters[daughters.len() - 1]) + PI) + last);
        if keys.windows(2).any(|pair| pair[1] - pair[0] < LEAST_ANGLE) {
            return Err(TreeError::Angle(crotch));
        }
        let near = lumen.near(&centre);
        let half = grid.around() / 2;
        let rim = |theta: &f64| {
            let key = flow * theta.cos() + across * theta.sin();
            let points = (0..=half).map(|a| {
                let phi = grid.angle(a);
                let direction = axis * phi.cos() + key * phi.sin();
                near.wall(&centre, &direction)
                    .ok_or(TreeError::Open(centre))
            });
            points.collect::<Result<Vec<Vec3>, TreeError>>()
        };
        let rims = keys.iter().map(rim).collect::<Result<_, _>>()?;
        Ok(Junction {
            parent: BranchEnd {
                line: order[0].0,
                cut: trunk.at(trunk.foot(&centre).s - layout.cuts[0] * PARENT_CUT * radius),
            },
            centre,
            axis: *axis,
            daughters,
            rims,
            worst: f64::INFINITY,
        })
    }
}

impl Spread {
    fn of(lumen: &Lumen, parting: &Parting) -> Self {
        let upstream = |&(line, s): &(usize, f64)| {
            let line = &lumen.lines[line];
            line.tangent((s - 2.0 * line.radius(s)).max(0.0))
        };
        let flow = parting.iter().map(upstream).sum::<Vec3>().normalize();
        let mut widest = Vec3::zeros();
        for (i, (a, s)) in parting.iter().enumerate() {
            for (b, t) in &parting[..i] {
                let arm = past(&lumen.lines[*b], *t) - past(&lumen.lines[*a], *s);
                let arm = arm - flow * flow.dot(&arm);
                if arm.norm() > widest.norm() {
                    widest = arm;
                }
            }
        }
        let across = widest.normalize();
        Self {
            flow,
            across,
            axis: flow.cross(&across),
        }
    }

    /// With the axis leaning downstream by this angle, rad.
    fn leaning(&self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self {
            flow: self.flow * cos - self.axis * sin,
            axis: self.axis * cos + self.flow * sin,
            across: self.across,
        }
    }
}

/// A centre-line one radius past the arc length `s` (m).
fn past(line: &CentreLine, s: f64) -> Vec3 {
    line.at(s + line.radius(s))
}
