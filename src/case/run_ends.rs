//! When a run may be over.

use super::Case;

/// The numbers of the steps after which a run may be over: the last one, and, where it runs until it is periodic, those
/// that end a beat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunEnds {
    last: usize,
    /// The first that ends a beat, and the steps of a beat.
    beats: Option<[usize; 2]>,
}

impl RunEnds {
    /// After the last step alone.
    pub fn last_only(last: usize) -> Self {
        Self { last, beats: None }
    }

    /// Those of a case. From rest the blood takes most of a beat to begin to flow; what flows already is nearly
    /// periodic after half.
    pub fn of(case: &Case) -> Self {
        let beat = case.steps_of_a_beat().max(1);
        let first = match case.steps_before() {
            Some(_) => beat + beat.div_ceil(2),
            None => 2 * beat,
        };
        Self {
            last: case.steps(),
            beats: case.until_periodic().map(|_| [first, beat]),
        }
    }

    /// The number of the last step.
    pub fn last(self) -> usize {
        self.last
    }

    /// Whether a run may be over after this step.
    pub fn contains(self, step: usize) -> bool {
        self.from(step) == step
    }

    /// The first of them from a step on.
    pub fn from(self, step: usize) -> usize {
        let Some([first, beat]) = self.beats else {
            return self.last;
        };
        let beats = step.saturating_sub(first).div_ceil(beat);
        (first + beats * beat).min(self.last)
    }

    /// The steps before the first and up to the last one of the beat that a step belongs to, if a run may be over after
    /// beats: of the last whole one for what comes after it, up to the first for what comes before.
    pub fn beat_of(self, step: usize) -> Option<[usize; 2]> {
        let [first, beat] = self.beats.filter(|[first, _]| *first <= self.last)?;
        let before = first % beat;
        if step <= before && before > 0 {
            return Some([0, before]);
        }
        let whole = (self.last - before) / beat;
        let number = (step.saturating_sub(before + 1) / beat).min(whole - 1);
        Some([number, number + 1].map(|n| before + n * beat))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_may_end_with_a_beat_but_not_with_the_first() {
        let ends = |beats| -> Vec<usize> {
            let ends = RunEnds { last: 14, beats };
            (1..=14).filter(|&step| ends.contains(step)).collect()
        };
        assert_eq!(ends(Some([8, 4])), [8, 12, 14]);
        assert_eq!(ends(Some([6, 4])), [6, 10, 14]);
        assert_eq!(ends(None), [14]);
        let ends = RunEnds {
            last: 14,
            beats: Some([6, 4]),
        };
        assert_eq!(
            [0, 6, 7, 11, 14].map(|step| ends.from(step)),
            [6, 6, 10, 14, 14]
        );
    }

    /// The last whole one counts for what is left of another.
    #[test]
    fn steps_belong_to_beats() {
        let beats = |last, first| {
            let ends = RunEnds {
                last,
                beats: Some([first, 8]),
            };
            [0, 1, 4, 5, 8, 9, 12, 13, 16, 24, 25].map(|step| ends.beat_of(step))
        };
        let [a, b, c] = [[0, 8], [8, 16], [16, 24]].map(Some);
        assert_eq!(beats(25, 16), [a, a, a, a, a, b, b, b, b, c, c]);
        let [start, d, e] = [[0, 4], [4, 12], [12, 20]].map(Some);
        assert_eq!(beats(25, 12), [start, start, start, d, d, d, d, e, e, e, e]);
        assert_eq!(beats(11, 12), [None; 11]);
        assert_eq!(RunEnds::last_only(20).beat_of(3), None);
    }
}
