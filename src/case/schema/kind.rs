//! Which values a key allows.

use std::fmt;

/// Which values a key allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ValueKind {
    /// A number within a range.
    Real(Range),
    /// A whole number from the first to the second.
    Whole(i64, i64),
    /// One of these words; each with its meaning.
    Word(&'static [(&'static str, &'static str)]),
    /// `true` or `false`.
    Flag,
    /// A line of text with at most so many characters.
    Text(usize),
    /// A path, relative to the file that names it.
    Path,
    /// A program and its arguments, at most so many words.
    Command(usize),
    /// A path, or one of these words for what is built into the program; each with its meaning.
    PathOr(&'static [(&'static str, &'static str)]),
    /// Rows of numbers of equal length from 0 to 1; first and last row zero. At most so many rows and columns.
    Rows(usize),
    /// Rows of equally many numbers above zero; at most so many rows, and so many columns.
    Radii(usize, usize),
    /// At most so many points of space.
    Points(usize),
    /// At most so many lists of three whole numbers from 0 on.
    Triples(usize),
    /// A whole number within the limits, or one for each of the three local directions.
    Degrees(i64, i64),
    /// A whole number within the limits, or this word.
    WholeOr(i64, i64, &'static str),
    /// Two or more numbers, at most so many.
    Numbers(usize),
    /// One or more numbers above zero, at most so many.
    Sizes(usize),
    /// One or more numbers, at most so many; those that are left out at the end are 0.
    Amplitudes(usize),
    /// One or more names, at most so many.
    Names(usize),
}

/// A range of real numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Lower end.
    pub low: f64,
    /// Whether the lower end itself is allowed.
    pub with_low: bool,
    /// Upper end, allowed.
    pub high: f64,
}

impl Range {
    /// Whether the number is allowed; NaN never is.
    pub fn contains(self, value: f64) -> bool {
        value <= self.high && (value > self.low || self.with_low && value == self.low)
    }
}

/// A number above `low`, at most `high`.
pub const fn above(low: f64, high: f64) -> ValueKind {
    ValueKind::Real(Range {
        low,
        with_low: false,
        high,
    })
}

/// A number from `low` to `high`.
pub const fn from(low: f64, high: f64) -> ValueKind {
    ValueKind::Real(Range {
        low,
        with_low: true,
        high,
    })
}

/// A whole number from `low` to `high`.
pub const fn whole(low: i64, high: i64) -> ValueKind {
    ValueKind::Whole(low, high)
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Range {
            low,
            with_low,
            high,
        } = *self;
        match with_low {
            true => write!(f, "a number from {} to {}", short(low), short(high)),
            false => write!(f, "a number above {}, at most {}", short(low), short(high)),
        }
    }
}

/// A number in few digits: 1e15 rather than 1000000000000000.0.
fn short(number: f64) -> String {
    match number.abs() {
        0.0 | 1e-3..1e4 => format!("{number:?}"),
        _ => format!("{number:e}"),
    }
}

impl fmt::Display for ValueKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ValueKind::Real(range) => range.fmt(f),
            ValueKind::Whole(low, high) => write!(f, "a whole number from {low} to {high}"),
            ValueKind::Word(words) => {
                let words: Vec<_> = words.iter().map(|(word, _)| *word).collect();
                write!(f, "one of \"{}\"", words.join("\", \""))
            }
            ValueKind::Flag => f.write_str("true or false"),
            ValueKind::Text(most) => write!(f, "a line of 1 to {most} characters in quotes"),
            ValueKind::Path => f.write_str("a path in quotes"),
            ValueKind::Command(most) => write!(
                f,
                "a program and its arguments, 1 to {most} words in brackets, such as [\"python3\", \"my_fluid.py\"]"
            ),
            ValueKind::PathOr(words) => {
                let words: Vec<_> = words.iter().map(|(word, _)| *word).collect();
                write!(f, "a path in quotes, or \"{}\"", words.join("\", \""))
            }
            ValueKind::Degrees(low, high) => write!(
                f,
                "a whole number from {low} to {high}, or three of them in brackets"
            ),
            ValueKind::WholeOr(low, high, word) => {
                write!(f, "a whole number from {low} to {high}, or \"{word}\"")
            }
            ValueKind::Numbers(most) => write!(f, "2 to {most} numbers in brackets"),
            ValueKind::Amplitudes(most) => write!(f, "1 to {most} numbers in brackets"),
            ValueKind::Sizes(most) => write!(f, "1 to {most} numbers above 0 in brackets"),
            ValueKind::Names(most) => write!(f, "1 to {most} names in quotes, in brackets"),
            ValueKind::Rows(most) => write!(
                f,
                "rows of equally many numbers from 0 to 1, at least 3 by 3, at most {most} by {most}, the first and the last \
                 row zero"
            ),
            ValueKind::Radii(rows, columns) => write!(
                f,
                "rows of equally many numbers above 0, 2 to {rows} rows of 4 to {columns} numbers"
            ),
            ValueKind::Points(most) => write!(
                f,
                "at most {most} points in brackets, such as [[0.02, 3e-3, 0.0]]"
            ),
            ValueKind::Triples(most) => write!(
                f,
                "at most {most} lists of three whole numbers from 0 on in brackets, such as [[0, 1, 2]]"
            ),
        }
    }
}
