//! The cross-sections of a branch: plane between its ends, folded where it meets others as equals, bent where a thin
//! one begins at its side.

use super::Tree;
use super::branch::{Branch, Middle, Stack};
use super::error::TreeError;
use super::junction::LEAST_LENGTH;
use super::meeting::Meeting;
use super::section::CrossSection;
use super::side::{Hole, plug};
use super::slicer::across;
use super::unfolding::Unfolding;
use crate::Vec3;
use crate::polydata::OVERLAP;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

/// What leads from junctions to plane cross-sections takes at least this share of what it has where there is room.
const TIGHTEST: f64 = 0.45;

/// Goes with the whole of its rim.
const WHOLE: Middle = Middle {
    axis: 0,
    share: 1.0,
};

/// From 0 to 1 with no slope at either end.
fn without_kink(u: f64) -> f64 {
    u * u * (3.0 - 2.0 * u)
}

impl Tree {
    /// The plane cross-sections that a surface surrounds. At the open ends of the tree it may be closed, or end, a bit
    /// before the lines do.
    fn whole(
        &self,
        branch: &Branch,
        stations: &[f64],
        tangents: &[Vec3],
        first: &[Vec3],
    ) -> Range<usize> {
        let count = stations.len();
        let line = &branch.axis;
        if self.slicer.lumen.surface.is_none() {
            return 0..count;
        }
        let is_whole = |i: &usize| {
            let i = *i;
            (self.slicer).is_whole(line.at(stations[i]), &tangents[i], &first[i])
        };
        // So far from an end at most.
        let near = |end: f64| OVERLAP * line.radius(end);
        let at_start = (0..count).take_while(|i| stations[*i] <= near(0.0));
        let start = at_start.filter(|_| branch.from.is_none());
        let start = start
            .clone()
            .find(is_whole)
            .or_else(|| start.last().map(|i| i + 1));
        let length = line.length();
        let at_end = (0..count)
            .rev()
            .take_while(|i| length - stations[*i] <= near(length));
        let end = at_end.filter(|_| branch.to.is_none() && !line.is_closed);
        let end = end
            .clone()
            .find(is_whole)
            .or_else(|| end.last().and_then(|i| i.checked_sub(1)));
        let start = start.unwrap_or(0).min(count - 1);
        start..end.map_or(count, |last| last + 1).max(start + 1)
    }

    /// From where to where (m) along its axis the cross-sections of a branch are plane. What leads to junctions of
    /// equals is shorter where there is little room.
    fn plane_part(&self, branch: &Branch) -> Result<[f64; 2], TreeError> {
        let line = &branch.axis;
        // Where the plane part would begin or end, and the limit that it may be moved to.
        let end_at = |junction: usize, cut: &Vec3| {
            let meeting = &self.junctions[junction];
            let cut = line.foot(cut).s;
            match meeting {
                Meeting::Fan(fan) => [cut, line.foot(&fan.centre).s],
                Meeting::Side(_) => [cut, cut],
            }
        };
        let [begin, from] = branch.from.map_or([0.0; 2], |(junction, daughter)| {
            end_at(
                junction,
                &self.junctions[junction].daughters()[daughter].cut,
            )
        });
        let [end, to] = branch.to.map_or([line.length(); 2], |junction| {
            end_at(junction, &self.junctions[junction].parent().cut)
        });
        let least = LEAST_LENGTH * line.radius(begin);
        if end - begin >= least {
            return Ok([begin, end]);
        }
        // A sac may be so short that the one where its dome begins is all there is.
        if branch.to.is_none() && line.is_closed && end - from >= LEAST_LENGTH * line.radius(end) {
            return Ok([end, end]);
        }
        let room = (to - from) - least;
        let needed = (begin - from) + (to - end);
        let share = room / needed;
        if share >= TIGHTEST {
            return Ok([from + (begin - from) * share, to - (to - end) * share]);
        }
        let place = |junction: usize| *self.junctions[junction].centre();
        let (found, needed) = (to - from, needed * TIGHTEST + least);
        Err(match (branch.from, branch.to) {
            (Some((a, _)), Some(b)) => TreeError::Close(place(a), place(b), found.max(0.0), needed),
            (Some((junction, _)), None) | (None, Some(junction)) => {
                TreeError::Short(place(junction), found.max(0.0), needed)
            }
            (None, None) => TreeError::Short(line.at(0.0), line.length(), least),
        })
    }

    /// The cross-sections of a branch.
    pub(super) fn stack(&self, branch: &Branch) -> Result<Stack, TreeError> {
        let line = &branch.axis;
        let plane_part = self.plane_part(branch)?;
        let (sections, tangents, frames) = self.plane_sections(branch, plane_part)?;
        let mut stack = Stack {
            end: (branch.to.is_none() && !line.is_closed).then_some(branch.lines[0]),
            wall: self.wall(branch),
            from: branch.from.map(|(junction, _)| junction),
            to: branch.to,
            middles: vec![WHOLE; sections.len()],
            sections,
            hole: None,
            plugs: None,
            top: None,
        };
        let [first, last] = [0, tangents.len() - 1];
        let [at_begin, at_end] = plane_part.map(|s| line.radius(s));
        self.begin(&mut stack, branch, &tangents[first], at_begin)?;
        match branch.to {
            Some(to) => self.end(&mut stack, to, &frames, &tangents[last], at_end)?,
            None if line.is_closed => {
                let (dome, top) = (self.slicer).dome(line, &tangents[last], &frames.first[last])?;
                stack.middles.extend(vec![WHOLE; dome.len()]);
                stack.sections.extend(dome);
                stack.top = Some(top);
            }
            None => {}
        }
        Ok(stack)
    }

    /// The plane cross-sections of a branch, with the tangents of its line there.
    fn plane_sections(
        &self,
        branch: &Branch,
        [begin, end]: [f64; 2],
    ) -> Result<(Vec<CrossSection>, Vec<Vec3>, Frames), TreeError> {
        let line = &branch.axis;
        let stations = self.slicer.stations(line, begin, end);
        let from = branch.from.map(|(at, end)| (&self.junctions[at], end));
        let tangents: Vec<Vec3> = match (&stations[..], from) {
            ([only], Some((Meeting::Fan(fan), daughter))) => {
                vec![fan.tangent(Some(daughter), line, *only)]
            }
            _ => stations.iter().map(|s| line.tangent(*s)).collect(),
        };
        let axis = |junction: usize, end| self.junctions[junction].axis(end);
        let frames = Frames::new(
            &tangents,
            (branch.from).map(|(junction, daughter)| axis(junction, Some(daughter))),
            branch.to.map(|junction| axis(junction, None)),
        );
        let whole = self.whole(branch, &stations, &tangents, &frames.first);
        let section = |i: usize| {
            let nearest = i.clamp(whole.start, whole.end - 1);
            let share = (stations[i] - begin) / (end - begin).max(f64::MIN_POSITIVE);
            let (tangent, first) = (&tangents[nearest], &frames.first[nearest]);
            let turned = frames.turn * share * share * (3.0 - 2.0 * share);
            let is_inlet = branch.from.is_none();
            let section = (self.slicer).plane_near(
                line,
                stations[nearest],
                [tangent, first],
                turned,
                is_inlet,
            )?;
            Ok(match nearest == i {
                true => section,
                false => section.moved(line.at(stations[i]), [tangent, &tangents[i]]),
            })
        };
        let found: Vec<Result<CrossSection, TreeError>> =
            (0..stations.len()).into_par_iter().map(section).collect();
        // Of several mistakes always the same one.
        let sections = found.into_iter().collect::<Result<_, TreeError>>()?;
        Ok((sections, tangents, frames))
    }

    /// Puts what leads from the junction where a branch begins, if there is one, before its plane cross-sections.
    fn begin(
        &self,
        stack: &mut Stack,
        branch: &Branch,
        tangent: &Vec3,
        radius: f64,
    ) -> Result<(), TreeError> {
        let rings = self.slicer.grid.rings.len();
        let from = (branch.from).map(|(junction, end)| (&self.junctions[junction], end));
        let folded = match from {
            None => return Ok(()),
            Some((Meeting::Side(side), 0)) => {
                stack.sections[0] = side.sections[side.sections.len() - 1].clone();
                return Ok(());
            }
            Some((Meeting::Side(_), _)) => {
                stack.plugs = self.stacks.iter().position(|other| other.to == stack.from);
                self.plug(stack.plugs, rings)
            }
            Some((Meeting::Fan(fan), daughter)) => fan.section(Some(daughter)),
        };
        let plane = stack.sections[0].clone();
        let unfolding = Unfolding::new(&self.slicer, folded, plane, tangent, radius, false);
        let (between, places) = unfolding.all_folded()?;
        let is_plug = stack.plugs.is_some();
        let held = places.iter().map(|u| Middle {
            axis: 0,
            share: if is_plug { 1.0 } else { without_kink(*u) },
        });
        stack.middles.splice(0..0, held);
        stack.sections.splice(0..0, between);
        if is_plug {
            let plug = (0..rings).map(|ring| self.plug(stack.plugs, ring));
            stack.sections.splice(0..0, plug);
            stack.middles.splice(0..0, vec![WHOLE; rings]);
        }
        Ok(())
    }

    /// Puts what leads to the junction where a branch ends behind its plane cross-sections.
    fn end(
        &self,
        stack: &mut Stack,
        junction: usize,
        frames: &Frames,
        tangent: &Vec3,
        radius: f64,
    ) -> Result<(), TreeError> {
        let axis = frames.quarters * self.slicer.grid.core;
        match &self.junctions[junction] {
            Meeting::Fan(fan) => {
                let mut folded = fan.section(None);
                folded.rim.rotate_right(axis);
                let plane = stack.sections[stack.sections.len() - 1].clone();
                let unfolding = Unfolding::new(&self.slicer, folded, plane, tangent, radius, true);
                let (between, places) = unfolding.all_folded()?;
                stack.sections.extend(between.into_iter().rev());
                let held = places.iter().rev().map(|u| Middle {
                    axis,
                    share: without_kink(*u),
                });
                stack.middles.extend(held);
            }
            Meeting::Side(side) => {
                stack.hole = Some(Hole {
                    first: stack.sections.len() + side.first,
                    middle: axis,
                    shape: side.shape,
                });
                (stack.middles).extend(vec![WHOLE; side.sections.len()]);
                stack
                    .sections
                    .extend(side.sections.iter().cloned().map(|mut section| {
                        section.rim.rotate_right(axis);
                        if let Some(inner) = &mut section.inner {
                            inner.rotate_right(axis);
                        }
                        section
                    }));
            }
        }
        Ok(())
    }

    /// The cross-section of a plug at a ring of the stack that it is in, at rest.
    fn plug(&self, parent: Option<usize>, ring: usize) -> CrossSection {
        let grid = self.grid();
        let Some((parent, hole)) =
            parent.and_then(|i| Some((&self.stacks[i], self.stacks[i].hole?)))
        else {
            unreachable!("a side branch comes after its parent")
        };
        let rows = hole.first..=hole.first + grid.core;
        let rows: Vec<Vec<Vec3>> = (parent.sections[rows].iter())
            .map(|section| grid.positions(section, 1.0))
            .collect();
        plug(grid, &hole.shape, ring, |(i, j), ring| {
            let row = (grid.core / 2).wrapping_add_signed(i);
            let point = (hole.middle + grid.around()).wrapping_add_signed(j) % grid.around();
            rows[row][grid.ring_point(ring, point)]
        })
    }
}

/// The directions from which the rims of a branch's cross-sections count: transported along it without rotation.
struct Frames {
    first: Vec<Vec3>,
    /// Angle (rad) by which they are turned in addition on the way from one junction to the other, at most 45° ...
    turn: f64,
    /// ... so that the last one is that of the junction after so many quarters of a turn.
    quarters: usize,
}

impl Frames {
    fn new(tangents: &[Vec3], start: Option<Vec3>, end: Option<Vec3>) -> Self {
        let transported = |first: Vec3, tangents: &mut dyn Iterator<Item = &Vec3>| {
            let mut direction = first;
            let all = tangents.map(|tangent| {
                direction = across(&direction, tangent);
                direction
            });
            all.collect::<Vec<Vec3>>()
        };
        let mut frames = Self {
            first: Vec::new(),
            turn: 0.0,
            quarters: 0,
        };
        if let (None, Some(end)) = (start, end) {
            frames.first = transported(end, &mut tangents.iter().rev());
            frames.first.reverse();
            return frames;
        }
        let any = [Vec3::x(), Vec3::y()][usize::from(tangents[0].x.abs() > 0.9)];
        frames.first = transported(start.unwrap_or(any), &mut tangents.iter());
        let (last, tangent) = (frames.first.last(), tangents.last());
        if let (Some(end), Some(last), Some(tangent)) = (end, last, tangent) {
            let off = end.dot(&tangent.cross(last)).atan2(end.dot(last));
            let quarters = (off / FRAC_PI_2).round();
            frames.turn = off - quarters * FRAC_PI_2;
            frames.quarters = quarters.rem_euclid(4.0) as usize;
        }
        frames
    }
}
