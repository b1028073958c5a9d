//! Numbering along a sweep.

use std::ops::Range;

/// Things that are numbered layer by layer along a sweep, as many in each layer: the cells of a vessel section by
/// section, the faces and points of its wall ring by ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layers {
    /// How many lie in each layer.
    pub each: usize,
}

impl Layers {
    /// The number of the one at a place in a layer.
    #[inline]
    pub fn number(self, layer: usize, place: usize) -> usize {
        layer * self.each + place
    }

    /// The layer of a number, and its place there.
    #[inline]
    pub fn place(self, number: usize) -> [usize; 2] {
        [number / self.each, number % self.each]
    }

    /// The numbers of all in some layers.
    pub fn numbers(self, layers: Range<usize>) -> Range<usize> {
        layers.start * self.each..layers.end * self.each
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_places_are_inverse() {
        let layers = Layers { each: 5 };
        let all: Vec<usize> = layers.numbers(2..4).collect();
        assert_eq!(all, [10, 11, 12, 13, 14, 15, 16, 17, 18, 19]);
        for number in all {
            let [layer, place] = layers.place(number);
            assert!((2..4).contains(&layer));
            assert_eq!(layers.number(layer, place), number);
        }
    }
}
