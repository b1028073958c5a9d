//! Where the branches of a tree meet, for those who show it.

use super::{Stack, Tree};
use crate::Vec3;

/// A place where branches meet.
pub struct MeetingPlace<'a> {
    /// The branch where the blood comes from.
    pub parent: &'a Stack,
    /// Those where it leaves, sorted by their walls.
    pub daughters: Vec<&'a Stack>,
    /// Where they part, m.
    pub centre: Vec3,
    /// Radius of the parent, m.
    pub radius: f64,
}

impl Tree {
    /// Where its branches meet, downstream.
    pub fn meeting_places(&self) -> Vec<MeetingPlace<'_>> {
        let stacks = self.stacks();
        let last = stacks.iter().filter_map(|stack| stack.from).max();
        let place = |number: usize| {
            let begins = |stack: &&Stack| stack.from == Some(number);
            let mut daughters: Vec<&Stack> = stacks.iter().filter(begins).collect();
            daughters.sort_by_key(|stack| stack.wall);
            let of_side = daughters
                .iter()
                .find_map(|stack| Some(&stacks[stack.plugs?]));
            let parent =
                of_side.or_else(|| stacks.iter().find(|stack| stack.to == Some(number)))?;
            Some(MeetingPlace {
                centre: daughters.first()?.sections[0].centre,
                radius: parent.radius(parent.sections.len() / 2),
                parent,
                daughters,
            })
        };
        (0..=last.unwrap_or(0)).filter_map(place).collect()
    }

    /// What one of its branches is called, if `names` are those of walls: branches with one wall are numbered.
    pub fn branch_name(&self, stack: &Stack, names: &[String]) -> String {
        let name = names.get(stack.wall).cloned().unwrap_or_default();
        let mut alike = self.stacks().iter().filter(|it| it.wall == stack.wall);
        match (
            alike.clone().count(),
            alike.position(|it| std::ptr::eq(it, stack)),
        ) {
            (2.., Some(number)) => format!("{name} {}", number + 1),
            _ => name,
        }
    }

    /// Which branches meet at a place, in a sentence; `names` are those of walls.
    pub fn told(&self, place: &MeetingPlace<'_>, names: &[String]) -> String {
        let (thin, others): (Vec<&Stack>, Vec<&Stack>) =
            (place.daughters.iter()).partition(|stack| stack.plugs.is_some());
        let [thin, others] = [thin, others].map(|stacks| {
            let names = stacks
                .into_iter()
                .map(|stack| self.branch_name(stack, names));
            names.collect::<Vec<_>>().join(", ")
        });
        let parent = self.branch_name(place.parent, names);
        match (&thin[..], &others[..]) {
            ("", _) => format!("{parent} divides into {others}."),
            (_, "") => format!("{thin} begins at the side of {parent}."),
            _ => format!("{thin} begins at the side of {parent}, which goes on as {others}."),
        }
    }
}

impl Stack {
    /// Mean radius (m) of the cross-section of this number.
    pub fn radius(&self, section: usize) -> f64 {
        let section = &self.sections[section];
        let all = section.rim.iter().map(|x| (x - section.centre).norm());
        all.sum::<f64>() / section.rim.len() as f64
    }
}

impl MeetingPlace<'_> {
    /// From the middle of the parent to it, m.
    pub fn downstream(&self) -> Vec3 {
        let sections = &self.parent.sections;
        self.centre - sections[sections.len() / 2].centre
    }
}
