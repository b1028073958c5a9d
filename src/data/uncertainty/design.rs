//! Where the samples of a study lie in the unit cube.

use std::fmt;
use std::str::FromStr;

/// Of all random numbers: a study that is repeated has the same samples.
const SEED: u64 = 1;
/// Samples of a study, at most: so many have a stratification in Sobol's sequence.
const MOST: usize = 1 << 16;

/// How points are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Sobol,
    LatinHypercube,
    /// Points of Sobol's sequence, as many as a chaos of this degree asks for.
    Chaos,
}

const WORDS: [(&str, Kind); 3] = [
    ("sobol", Kind::Sobol),
    ("lhs", Kind::LatinHypercube),
    ("pce", Kind::Chaos),
];

/// Samples of a study: `sobol:64`, `lhs:64`, `pce:2`, each perhaps with what was added later, `sobol:64+32`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Design {
    kind: Kind,
    /// The number of samples, or the degree of the chaos.
    number: usize,
    added: Vec<usize>,
}

impl Design {
    /// Whether a text begins as a design does: a file has another name.
    pub fn is_meant(text: &str) -> bool {
        WORDS
            .iter()
            .any(|(word, _)| text.split(':').next() == Some(word))
    }

    /// The same with more samples, which do not change those that it has.
    pub fn extended(mut self, more: usize) -> Self {
        self.added.push(more);
        self
    }

    /// Points of the unit cube of so many inputs; `None` if there would be too many.
    pub fn points(&self, inputs: usize) -> Option<Vec<Vec<f64>>> {
        let first = match self.kind {
            // Twice as many as the chaos has coefficients.
            Kind::Chaos => {
                2 * (1..=inputs).fold(1, |n: usize, i| n.saturating_mul(self.number + i) / i)
            }
            Kind::Sobol | Kind::LatinHypercube => self.number,
        };
        let blocks: Vec<usize> = std::iter::once(first)
            .chain(self.added.iter().copied())
            .collect();
        let all = blocks.iter().fold(0, |n: usize, m| n.saturating_add(*m));
        if all > MOST || inputs > sobol_burley::NUM_DIMENSIONS as usize {
            return None;
        }
        Some(match self.kind {
            Kind::Sobol | Kind::Chaos => (0..all).map(|i| sobol_point(i, inputs)).collect(),
            Kind::LatinHypercube => {
                let blocks = blocks.iter().enumerate();
                blocks
                    .flat_map(|(i, &count)| latin_hypercube(count, inputs, SEED + i as u64))
                    .collect()
            }
        })
    }
}

impl FromStr for Design {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "{text:?} is not a number of samples: expected sobol:N, lhs:N, or pce:D for a polynomial of degree D (from \
                 1 to 9), such as sobol:64"
            )
        };
        let (word, numbers) = text.split_once(':').ok_or_else(wrong)?;
        let (_, kind) = WORDS
            .iter()
            .find(|(known, _)| *known == word)
            .ok_or_else(wrong)?;
        let numbers: Vec<usize> = numbers
            .split('+')
            .map(|n| n.trim().parse().ok().filter(|n| (1..=MOST).contains(n)))
            .collect::<Option<_>>()
            .ok_or_else(wrong)?;
        if *kind == Kind::Chaos && numbers[0] > 9 {
            return Err(wrong());
        }
        Ok(Self {
            kind: *kind,
            number: numbers[0],
            added: numbers[1..].to_vec(),
        })
    }
}

impl fmt::Display for Design {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = WORDS.iter().find(|(_, kind)| *kind == self.kind);
        write!(f, "{}:{}", word.map_or("", |(word, _)| word), self.number)?;
        self.added.iter().try_for_each(|more| write!(f, "+{more}"))
    }
}

/// The point `i` of Sobol's sequence with Owen's scrambling (Burley 2020, Practical hash-based Owen scrambling).
pub fn sobol_point(i: usize, inputs: usize) -> Vec<f64> {
    let coordinate = |d: u32| f64::from(sobol_burley::sample(i as u32, d, SEED as u32));
    // The middle of the interval that the 24 bits stand for: 0 has no quantile.
    let middle = 2.0_f64.powi(-25);
    (0..inputs as u32).map(|d| coordinate(d) + middle).collect()
}

/// `count` points of which each of `count` slices along each axis has one.
fn latin_hypercube(count: usize, inputs: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = Random(seed);
    let mut points = vec![vec![0.0; inputs]; count];
    for axis in 0..inputs {
        let mut slices: Vec<usize> = (0..count).collect();
        for i in (1..count).rev() {
            slices.swap(i, random.below(i + 1));
        }
        for (point, slice) in points.iter_mut().zip(slices) {
            point[axis] = (slice as f64 + random.unit()) / count as f64;
        }
    }
    points
}

/// SplitMix64 (Steele, Lea and Flood 2014).
pub(super) struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Between 0 and 1, without either.
    pub fn unit(&mut self) -> f64 {
        ((self.next() >> 11) as f64 + 0.5) / 2.0_f64.powi(53)
    }

    /// A whole number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(design: &str, inputs: usize) -> Vec<Vec<f64>> {
        design.parse::<Design>().unwrap().points(inputs).unwrap()
    }

    /// Of 64 points each slice of a 64th along each axis has one, and so have 8 by 8 squares of the first two.
    #[test]
    fn both_designs_are_stratified() {
        for design in ["sobol:64", "lhs:64"] {
            let points = points(design, 7);
            for axis in 0..7 {
                let mut slices: Vec<usize> =
                    points.iter().map(|p| (64.0 * p[axis]) as usize).collect();
                slices.sort_unstable();
                assert!(slices.iter().copied().eq(0..64), "{design}, axis {axis}");
            }
        }
        let mut squares: Vec<_> = points("sobol:64", 2)
            .iter()
            .map(|p| ((8.0 * p[0]) as usize, (8.0 * p[1]) as usize))
            .collect();
        squares.sort_unstable();
        squares.dedup();
        assert_eq!(squares.len(), 64);
    }

    #[test]
    fn more_samples_leave_earlier_ones_as_they_are() {
        for design in ["sobol:20", "lhs:20", "pce:1"] {
            let design: Design = design.parse().unwrap();
            let (before, after) = (design.points(3).unwrap(), design.clone().extended(5));
            let points = after.points(3).unwrap();
            assert_eq!(points[..before.len()], before);
            assert_eq!(points.len(), before.len() + 5);
            assert_eq!(after, after.to_string().parse().unwrap());
        }
        // 28 coefficients of degree 2 in 6 inputs
        assert_eq!(points("pce:2", 6).len(), 56);
        for wrong in [
            "sobol",
            "sobol:0",
            "lhs:x",
            "pce:10",
            "halton:3",
            "sobol:8+",
            "sobol:70000",
        ] {
            assert!(wrong.parse::<Design>().is_err(), "{wrong}");
        }
    }
}
