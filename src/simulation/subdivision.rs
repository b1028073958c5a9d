//! How long the next time step is: that of the case, or a part of it for a while after a step has failed.

use serde::{Deserialize, Serialize};

/// Units in which a time step of the case is counted: it can be halved this far.
const UNITS: usize = 1 << MOST_HALVINGS;
/// Most halvings that a case may ask for.
pub const MOST_HALVINGS: usize = 4;
/// Steps of the case without trouble after which the parts become twice as long.
const CALM: usize = 10;

/// Where a run is within a time step of its case. A checkpoint is only written between two of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct StepSubdivision {
    /// Parts of which a step consists: a power of two.
    parts: usize,
    /// Units of the current step that have been done.
    done: usize,
    /// Steps without trouble since the parts last changed.
    calm: usize,
}

impl Default for StepSubdivision {
    fn default() -> Self {
        Self {
            parts: 1,
            done: 0,
            calm: 0,
        }
    }
}

impl StepSubdivision {
    /// Parts of which a step consists.
    pub fn parts(self) -> usize {
        self.parts
    }

    /// Units of the current step that have been done.
    pub fn done(self) -> usize {
        self.done
    }

    /// Share of the current step that is done when the next part is.
    pub fn reaches(self) -> f64 {
        (self.done + UNITS / self.parts) as f64 / UNITS as f64
    }

    /// Whether the next part ends the step.
    pub fn completes(self) -> bool {
        self.done + UNITS / self.parts == UNITS
    }

    /// Cuts steps into this many parts, a power of two, if they are not that short already.
    pub fn refine(&mut self, parts: usize) {
        if parts > self.parts {
            self.parts = parts.min(UNITS);
            self.calm = 0;
        }
    }

    /// A part was accepted.
    pub fn advance(&mut self) {
        self.done += UNITS / self.parts;
        if self.done < UNITS {
            return;
        }
        self.done = 0;
        self.calm += 1;
        if self.parts > 1 && self.calm == CALM {
            self.parts /= 2;
            self.calm = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_add_up_to_steps_and_grow_again() {
        let mut subdivision = StepSubdivision::default();
        subdivision.refine(4);
        subdivision.refine(2);
        let mut ends = Vec::new();
        for _ in 0..4 {
            ends.push((subdivision.reaches(), subdivision.completes()));
            subdivision.advance();
        }
        assert_eq!(
            ends,
            [(0.25, false), (0.5, false), (0.75, false), (1.0, true)]
        );
        let mut parts = 4;
        while subdivision.parts() > 1 || subdivision.done() > 0 {
            subdivision.advance();
            parts += 1;
        }
        assert_eq!(parts, 10 * 4 + 10 * 2);
    }

    #[test]
    fn a_part_that_fails_is_halved_within_its_step() {
        let mut subdivision = StepSubdivision::default();
        subdivision.refine(2);
        subdivision.advance();
        subdivision.refine(4);
        assert_eq!(
            (subdivision.reaches(), subdivision.completes()),
            (0.75, false)
        );
        subdivision.advance();
        assert_eq!(
            (subdivision.reaches(), subdivision.completes()),
            (1.0, true)
        );
    }
}
