//! A choice of lines that have a mesh together: what is left out so far, and what is known of the rest.

use super::error::TreeError;
use super::junction::Parting;
use super::meeting::Meeting;
use std::collections::HashMap;

/// A mesh whose worst cell has a smaller scaled Jacobian is not carried.
pub(super) const FLAT: f64 = 0.05;
/// Junctions that are tried, at most.
const MEETINGS: usize = 600;

/// Why lines do not part, and groups of them: without one of these, others may.
pub(super) struct Obstacle {
    pub reason: TreeError,
    pub groups: Vec<Vec<usize>>,
}

/// A line that is left out.
struct Left {
    line: usize,
    reason: TreeError,
    /// In favour of these, if another choice was possible.
    favoured: Vec<usize>,
}

/// What is left out, and what is known of the rest.
pub(super) struct Choice {
    /// Through each line.
    flows: Vec<f64>,
    left_out: Vec<Left>,
    /// Lines that have no mesh whatever the others are.
    hopeless: Vec<bool>,
    /// Whether lines are back, and those that have been tried must be tried again.
    is_again: bool,
    /// Whether too much has been tried.
    is_lost: bool,
    /// Junctions, by the lines that part there and where they do.
    meetings: HashMap<Vec<(usize, u64)>, Result<Meeting, TreeError>>,
}

fn key(parting: &Parting) -> Vec<(usize, u64)> {
    parting
        .iter()
        .map(|(line, s)| (*line, s.to_bits()))
        .collect()
}

impl Choice {
    /// Of lines with these flows: none is left out.
    pub fn new(flows: Vec<f64>) -> Self {
        Self {
            hopeless: vec![false; flows.len()],
            flows,
            left_out: Vec::new(),
            is_again: false,
            is_lost: false,
            meetings: HashMap::new(),
        }
    }

    /// Forgets the junctions, which are different in another grid.
    pub fn begin_grid(&mut self) {
        self.meetings.clear();
    }

    /// Tries all lines again that are not left out; says which are.
    pub fn begin_pass(&mut self) -> Vec<bool> {
        self.is_again = false;
        self.flags()
    }

    /// Leaves nothing more out: the next obstacle ends the search.
    pub fn give_up(&mut self) {
        self.is_lost = true;
    }

    /// What is left out, and why.
    pub fn into_left_out(self) -> Vec<(usize, TreeError)> {
        let left_out = self.left_out.into_iter();
        left_out.map(|left| (left.line, left.reason)).collect()
    }

    /// The junction that was found here before.
    pub fn known(&self, parting: &Parting) -> Option<Result<Meeting, TreeError>> {
        self.meetings.get(&key(parting)).cloned()
    }

    /// What a junction turned out to be: good enough, or why not.
    pub fn remember(
        &mut self,
        found: Result<Meeting, TreeError>,
        parting: &Parting,
    ) -> Result<Meeting, TreeError> {
        if self.meetings.len() > MEETINGS {
            self.is_lost = true;
        }
        let found = found.and_then(|meeting| {
            let quality = match &meeting {
                Meeting::Fan(fan) => fan.worst,
                Meeting::Side(_) => FLAT,
            };
            match quality < FLAT {
                true => Err(TreeError::Flat(*meeting.centre(), quality)),
                false => Ok(meeting),
            }
        });
        self.meetings.insert(key(parting), found.clone());
        found
    }

    /// Leaves the group of lines out that has the least flow. If there is but one, that one is to blame: what was left
    /// out in favour of it comes back.
    pub fn leave_out(&mut self, obstacle: Obstacle) -> Result<(), TreeError> {
        let Obstacle { reason, groups } = obstacle;
        if self.is_lost {
            return Err(reason);
        }
        if let [only] = &groups[..] {
            for line in only {
                self.hopeless[*line] = true;
                let is_due_to = |left: &Left| left.line == *line || left.favoured.contains(line);
                let before = self.left_out.len();
                let hopeless = &self.hopeless;
                (self.left_out)
                    .retain(|left| hopeless[left.line] && left.line != *line || !is_due_to(left));
                self.is_again |= self.left_out.len() < before;
                self.left_out.push(Left {
                    line: *line,
                    reason: reason.clone(),
                    favoured: Vec::new(),
                });
            }
            let hopeless = self.hopeless.iter().filter(|is_hopeless| **is_hopeless);
            let is_left = self.flows.len() >= hopeless.count() + 2;
            return if is_left { Ok(()) } else { Err(reason) };
        }
        let kept = self.flows.len() - self.left_out.len();
        let flow = |group: &&Vec<usize>| group.iter().map(|line| self.flows[*line]).sum::<f64>();
        let fit = groups.iter();
        let fit = fit.filter(|group| !group.is_empty() && group.len() + 2 <= kept);
        let Some(group) = fit.min_by(|a, b| flow(a).total_cmp(&flow(b))).cloned() else {
            return Err(reason);
        };
        let favoured: Vec<usize> = groups
            .into_iter()
            .filter(|other| *other != group)
            .flatten()
            .collect();
        self.left_out.extend(group.into_iter().map(|line| Left {
            line,
            reason: reason.clone(),
            favoured: favoured.clone(),
        }));
        Ok(())
    }

    /// Whether lines are back that have not been tried.
    pub fn is_again(&self) -> bool {
        self.is_again
    }

    /// Which lines are no part of the lumen.
    pub fn flags(&self) -> Vec<bool> {
        let mut flags = vec![false; self.flows.len()];
        self.left_out
            .iter()
            .for_each(|left| flags[left.line] = true);
        flags
    }
}
