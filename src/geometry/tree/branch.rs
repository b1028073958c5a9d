//! What a tree consists of between its junctions.

use super::section::CrossSection;
use super::side::Hole;
use crate::Vec3;
use crate::curve::CentreLine;

/// A stretch between two junctions, or a junction and an end of the tree.
#[derive(Debug, Clone)]
pub struct Branch {
    /// The lines that go through it.
    pub lines: Vec<usize>,
    /// Their mean.
    pub axis: CentreLine,
    /// Junction where it begins, and which daughter it is there.
    pub from: Option<(usize, usize)>,
    /// Junction where it ends.
    pub to: Option<usize>,
}

/// The cross-sections of a branch.
#[derive(Debug, Clone)]
pub struct Stack {
    /// The line of the tree that ends with it, if one does.
    pub end: Option<usize>,
    /// The number of its wall: 0 of the root, that of its line plus one where it ends with it, and one more than the
    /// last of these for branches between junctions.
    pub wall: usize,
    /// Junction where it begins; the root, which is the first branch, has none.
    pub from: Option<usize>,
    /// Junction where it ends.
    pub to: Option<usize>,
    /// Cross-sections, downstream.
    pub sections: Vec<CrossSection>,
    /// What the middle of each one goes with when the wall moves.
    pub middles: Vec<Middle>,
    /// Where a side branch begins in it.
    pub hole: Option<Hole>,
    /// The stack in whose hole it begins.
    pub plugs: Option<usize>,
    /// The wall over the last core, row by row (m), if it is closed.
    pub top: Option<Vec<Vec3>>,
}

impl Stack {
    /// The junction that the cross-section of this number is folded at.
    pub(super) fn junction(&self, section: usize) -> Option<usize> {
        match section {
            0 => self.from,
            last if last + 1 == self.sections.len() => self.to,
            _ => None,
        }
    }
}

/// What the middle of a cross-section goes with: on the way from a plane cross-section to a junction, less and less
/// with the whole of its rim, and more and more with the two points of it where the axis of the junction ends, which
/// all branches there share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Middle {
    /// One of these points of the rim; the other one is opposite.
    pub axis: usize,
    /// Share of the whole rim.
    pub share: f64,
}
