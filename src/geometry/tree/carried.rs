//! Which lines of a tree have a mesh, if not all of them have.
//!
//! Where something has none, the branch with the least flow is left out of those whose absence would help: at a
//! junction one of its daughters, between two junctions that are too close a branch that leaves at one of them. Then
//! the others are tried again, until they have a mesh.

use super::branch::Branch;
use super::choice::{Choice, FLAT, Obstacle};
use super::divide::Division;
use super::error::TreeError;
use super::meeting::Meeting;
use super::section::SectionGrid;
use super::slicer::Slicer;
use super::{Lumen, Tree};
use crate::Vec3;
use crate::curve::Partings;

/// Something that is so many radii from the nearest junction is the branch's own.
const OWN: f64 = 5.0;
/// Trees are tried at most so many times.
const PASSES: usize = 40;

/// What is carried of a tree.
#[derive(Debug)]
pub struct Carried {
    /// Lines that are left out, and why, in the order in which they are.
    pub left_out: Vec<(usize, TreeError)>,
    /// The smallest scaled Jacobian of the others.
    pub worst: f64,
}

impl Carried {
    /// Leaves out what has no mesh in one of these grids, whose cells or elements have these lengths in radii; of what
    /// hinders each other, that with the least flow.
    ///
    /// # Errors
    /// If less than two lines would be left.
    pub fn new(
        lumen: Lumen,
        flows: Vec<f64>,
        grids: &[(SectionGrid, f64)],
    ) -> Result<Self, TreeError> {
        let partings = Partings::new(&lumen.lines);
        let mut choice = Choice::new(flows);
        let mut worst = f64::INFINITY;
        for (grid, along) in grids {
            choice.begin_grid();
            let slicer = Slicer {
                lumen: lumen.clone(),
                grid: grid.clone(),
                along: *along,
            };
            let mut found = None;
            for pass in 0..PASSES {
                if pass + 1 == PASSES {
                    choice.give_up();
                }
                found = choice.pass(slicer.clone(), &partings)?;
                if found.is_some() {
                    break;
                }
            }
            worst = worst.min(found.unwrap_or(f64::NEG_INFINITY));
        }
        Ok(Self {
            left_out: choice.into_left_out(),
            worst,
        })
    }
}

impl Choice {
    /// Leaves out what hinders the others; the smallest scaled Jacobian if nothing does.
    fn pass(&mut self, mut slicer: Slicer, partings: &Partings) -> Result<Option<f64>, TreeError> {
        slicer.lumen.left_out = self.begin_pass();
        let mut tree = match Division::tree(slicer, partings, Some(&mut *self)) {
            Ok(tree) => tree,
            Err(_) if self.is_again() => return Ok(None),
            Err(reason) => return Err(reason),
        };
        let (obstacles, worst) = tree.obstacles();
        if obstacles.is_empty() {
            return Ok(Some(worst));
        }
        for obstacle in obstacles {
            self.leave_out(obstacle)?;
            if self.is_again() {
                break;
            }
        }
        Ok(None)
    }
}

impl Tree {
    /// What has no mesh between the junctions, one obstacle at most at each; and the smallest scaled Jacobian, if all
    /// branches have a mesh.
    fn obstacles(&mut self) -> (Vec<Obstacle>, f64) {
        let mut all = Vec::new();
        let mut touched = vec![false; self.junctions.len()];
        let mut add = |tree: &Self, branch: &Branch, reason: TreeError| {
            let ends = [branch.from.map(|(at, _)| at), branch.to];
            let is_new = !ends.iter().flatten().any(|at| touched[*at]);
            for at in ends.into_iter().flatten() {
                touched[at] = true;
            }
            if is_new {
                let groups = tree.groups(branch, &reason);
                all.push(Obstacle { reason, groups });
            }
        };
        let mut is_whole = true;
        let mut worst = f64::INFINITY;
        for branch in &self.branches {
            let begins_at_side = matches!(
                branch
                    .from
                    .map(|(at, daughter)| (&self.junctions[at], daughter)),
                Some((Meeting::Side(_), 1))
            );
            let parent = (branch.from)
                .and_then(|(at, _)| self.stacks.iter().find(|stack| stack.to == Some(at)));
            if begins_at_side && parent.is_none() {
                continue;
            }
            match self.stack(branch) {
                Ok(stack) => self.stacks.push(stack),
                Err(reason) => {
                    is_whole = false;
                    add(self, branch, reason);
                }
            }
        }
        if is_whole {
            for (stack, (quality, x)) in self.worst_by_stack() {
                worst = worst.min(quality);
                if quality < FLAT {
                    add(self, &self.branches[stack], TreeError::Flat(x, quality));
                }
            }
        }
        (all, worst)
    }

    /// The smallest scaled Jacobian in each stack, and where that is, m.
    fn worst_by_stack(&self) -> Vec<(usize, (f64, Vec3))> {
        let mut worst = vec![(f64::INFINITY, Vec3::zeros()); self.stacks.len()];
        for (stack, quality, x) in self.qualities_by_stack() {
            if quality < worst[stack].0 {
                worst[stack] = (quality, x);
            }
        }
        worst.into_iter().enumerate().collect()
    }

    /// Groups of lines without one of which a branch may have a mesh.
    fn groups(&self, branch: &Branch, reason: &TreeError) -> Vec<Vec<usize>> {
        let leaves = |at: usize| -> Vec<Vec<usize>> {
            let daughters = self.branches.iter();
            let daughters =
                daughters.filter(|other| other.from.is_some_and(|(from, _)| from == at));
            daughters.map(|other| other.lines.clone()).collect()
        };
        let from = branch.from.map(|(at, _)| at);
        let beside = || {
            let all = from.map(leaves).unwrap_or_default().into_iter();
            all.filter(|lines| *lines != branch.lines)
        };
        let beyond = || branch.to.map(leaves).unwrap_or_default();
        match reason {
            TreeError::Close(..) => beside().chain(beyond()).collect(),
            TreeError::Short(..) if branch.to.is_none() => vec![branch.lines.clone()],
            _ => {
                let place = reason.place().unwrap_or_default();
                let off = |at: &usize| (self.junctions[*at].centre() - place).norm();
                let ends = from.into_iter().chain(branch.to);
                let nearest = ends.min_by(|a, b| off(a).total_cmp(&off(b)));
                let radius = branch.axis.foot(&place).radius;
                match nearest.filter(|at| off(at) < OWN * radius) {
                    Some(at) => leaves(at),
                    None if from.is_some() => vec![branch.lines.clone()],
                    None => beyond(),
                }
            }
        }
    }
}
