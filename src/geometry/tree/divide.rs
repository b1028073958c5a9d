//! Takes the lines of a tree apart into branches, junction by junction.

use super::Tree;
use super::branch::Branch;
use super::choice::{Choice, Obstacle};
use super::error::TreeError;
use super::junction::Parting;
use super::meeting::Meeting;
use super::slicer::Slicer;
use crate::curve::{CentreLine, Fork, Partings};

/// What has been taken apart.
pub(super) struct Division<'a> {
    slicer: Slicer,
    junctions: Vec<Meeting>,
    branches: Vec<Branch>,
    partings: &'a Partings,
    choice: Option<&'a mut Choice>,
}

/// Lines that begin as one branch and part.
struct Parted {
    axis: CentreLine,
    fork: Fork,
    junction: Meeting,
}

impl<'a> Division<'a> {
    /// A tree of all lines of the lumen, or with a choice of those that can be meshed, without its cross-sections.
    pub fn tree(
        slicer: Slicer,
        partings: &'a Partings,
        choice: Option<&'a mut Choice>,
    ) -> Result<Tree, TreeError> {
        let left_out = &slicer.lumen.left_out;
        let all = (0..slicer.lumen.lines.len()).filter(|line| !left_out[*line]);
        let all: Vec<usize> = all.collect();
        let mut division = Self {
            slicer,
            junctions: Vec::new(),
            branches: Vec::new(),
            partings,
            choice,
        };
        division.divide(all, None)?;
        Ok(Tree {
            slicer: division.slicer,
            junctions: division.junctions,
            branches: division.branches,
            stacks: Vec::new(),
        })
    }

    /// Takes lines apart that begin as one branch.
    fn divide(
        &mut self,
        mut lines: Vec<usize>,
        from: Option<(usize, usize)>,
    ) -> Result<(), TreeError> {
        let parted = loop {
            if let [only] = lines[..] {
                self.branches.push(Branch {
                    axis: self.slicer.lumen.lines[only].clone(),
                    lines,
                    from,
                    to: None,
                });
                return Ok(());
            }
            match self.part(&lines) {
                Ok(parted) => break parted,
                Err(obstacle) => {
                    let Some(choice) = &mut self.choice else {
                        return Err(obstacle.reason);
                    };
                    let reason = obstacle.reason.clone();
                    choice.leave_out(obstacle)?;
                    if choice.is_again() {
                        return Err(reason);
                    }
                    self.slicer.lumen.left_out = choice.flags();
                    lines.retain(|line| !self.slicer.lumen.left_out[*line]);
                }
            }
        };
        let at = self.junctions.len();
        self.branches.push(Branch {
            axis: parted.axis,
            lines,
            from,
            to: Some(at),
        });
        let daughters = parted.junction.daughters().iter().map(|end| end.line);
        let daughters: Vec<usize> = daughters.collect();
        self.junctions.push(parted.junction);
        for (daughter, line) in daughters.into_iter().enumerate() {
            let class = parted.fork.class(line).to_vec();
            self.divide(class, Some((at, daughter)))?;
        }
        Ok(())
    }

    /// Where lines that begin as one branch part.
    fn part(&mut self, lines: &[usize]) -> Result<Parted, Obstacle> {
        let all = &self.slicer.lumen.lines;
        let fork = self.partings.fork(all, lines).map_err(|pair| {
            let line = &all[pair.0];
            Obstacle {
                reason: TreeError::Within(pair.0, pair.1, line.at(line.length())),
                groups: vec![vec![pair.0]],
            }
        })?;
        let together: Vec<&CentreLine> = lines.iter().map(|i| &all[*i]).collect();
        let axis = CentreLine::mean(&together, fork.first);
        let parting: Vec<(usize, f64)> = (fork.daughters.iter())
            .map(|(class, s)| (class[0], *s))
            .collect();
        let junction = self.meeting(&axis, &parting, &fork);
        match junction {
            Ok(junction) => Ok(Parted {
                // The cross-sections around a side branch are those of the line that goes straight on.
                axis: match &junction {
                    Meeting::Fan(_) => axis,
                    Meeting::Side(side) => self.path(&fork, side.parent.line),
                },
                fork,
                junction,
            }),
            Err(reason) => Err(Obstacle {
                reason,
                groups: fork.daughters.into_iter().map(|(class, _)| class).collect(),
            }),
        }
    }

    fn meeting(
        &mut self,
        axis: &CentreLine,
        parting: &Parting,
        fork: &Fork,
    ) -> Result<Meeting, TreeError> {
        if let Some(choice) = &self.choice
            && let Some(known) = choice.known(parting)
        {
            return known;
        }
        let found = Meeting::new(&self.slicer, axis, parting, |line| self.path(fork, line));
        match &mut self.choice {
            Some(choice) => choice.remember(found, parting),
            None => found,
        }
    }

    /// The mean of the lines that part with this one.
    fn path(&self, fork: &Fork, line: usize) -> CentreLine {
        let all = &self.slicer.lumen.lines;
        let class: Vec<&CentreLine> = fork.class(line).iter().map(|i| &all[*i]).collect();
        match class[..] {
            [only] => only.clone(),
            _ => CentreLine::mean(&class, f64::INFINITY),
        }
    }
}
