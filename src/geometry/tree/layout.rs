//! Where the half-discs of a junction lie, and where its branches become plane.

use std::ops::Range;

/// What is varied in the search for a better junction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    /// Distance of the centre upstream of the apices, in radii of the parent there.
    pub back: f64,
    /// How far it lies from the middle between the lines, across the flow, in the same.
    pub aside: f64,
    /// How much the axis leans downstream, rad.
    pub lean: f64,
    /// How much half-discs are turned about the axis (rad): the first one, those at the apices, the last one.
    pub turned: [f64; 3],
    /// Lengths of what leads to the plane cross-sections of the parent and of the daughters, relative to the usual.
    pub cuts: [f64; 2],
}

impl Layout {
    /// How many numbers it has ...
    pub const NUMBERS: Range<usize> = 0..8;
    /// ... and those with which the half-discs between daughters go through the apices.
    pub const AT_APICES: Range<usize> = 0..7;

    /// With the centre so far upstream, and nothing else that is unusual.
    pub fn usual(back: f64) -> Self {
        Self {
            back,
            aside: 0.0,
            lean: 0.0,
            turned: [0.0; 3],
            cuts: [1.0; 2],
        }
    }

    /// With one of its numbers changed by so many of the longest steps; none if that is out of its range.
    pub fn varied(mut self, number: usize, steps: f64) -> Option<Self> {
        let [first, at_apices, last] = &mut self.turned;
        let [of_parent, of_daughters] = &mut self.cuts;
        let (number, longest, range) = match number {
            0 => (&mut self.back, 0.3, 0.15..=2.5),
            1 => (&mut self.aside, 0.2, -0.6..=0.6),
            2 => (&mut self.lean, 0.2, -0.6..=0.6),
            3 => (first, 0.2, -0.6..=0.6),
            4 => (last, 0.2, -0.6..=0.6),
            5 => (of_parent, 0.3, 0.4..=2.2),
            6 => (of_daughters, 0.3, 0.4..=2.2),
            _ => (at_apices, 0.2, -0.6..=0.6),
        };
        *number += steps * longest;
        range.contains(number).then_some(self)
    }
}
