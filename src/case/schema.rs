//! What a key of a case is and which values it allows; the keys themselves stand in the table `keys`.

pub use super::keys::{KEYS, MATERIAL, MATERIAL_TABLES, MATERIALS, OPTIONAL_TABLES};

/// One key of `case.toml`.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Dotted path, such as `time.step_s`; the unit is part of the name.
    pub path: &'static str,
    /// Which values are allowed.
    pub kind: Kind,
    /// Whether the key may be absent.
    pub optional: bool,
    /// What the value is, in a few words.
    pub about: &'static str,
}

/// Which values a key allows.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// A number within a range.
    Real(Range),
    /// A whole number from the first to the second.
    Whole(i64, i64),
    /// One of these words.
    Word(&'static [&'static str]),
    /// `true` or `false`.
    Flag,
    /// A path, relative to the file that names it.
    Path,
    /// Rows of numbers of equal length from 0 to 1; first and last row zero.
    Rows,
    /// Points of space.
    Points,
    /// A whole number within the limits, or one for each of the three local directions.
    Degrees(i64, i64),
    /// A whole number within the limits, or this word.
    WholeOr(i64, i64, &'static str),
    /// Two or more numbers.
    Numbers,
}

/// A range of real numbers.
#[derive(Debug, Clone, Copy)]
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

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Range {
            low,
            with_low,
            high,
        } = *self;
        match with_low {
            true => write!(f, "a number from {low:?} to {high:?}"),
            false => write!(f, "a number above {low:?}, at most {high:?}"),
        }
    }
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Kind::Real(range) => range.fmt(f),
            Kind::Whole(low, high) => write!(f, "a whole number from {low} to {high}"),
            Kind::Word(words) => write!(f, "one of \"{}\"", words.join("\", \"")),
            Kind::Flag => f.write_str("true or false"),
            Kind::Path => f.write_str("a path in quotes"),
            Kind::Degrees(low, high) => write!(
                f,
                "a whole number from {low} to {high}, or three of them in brackets"
            ),
            Kind::WholeOr(low, high, word) => {
                write!(f, "a whole number from {low} to {high}, or \"{word}\"")
            }
            Kind::Numbers => f.write_str("two or more numbers in brackets"),
            Kind::Rows => f.write_str("rows of equally many numbers from 0 to 1, at least 3 by 3, the first and the last row zero"),
            Kind::Points => f.write_str("points in brackets, such as [[0.02, 3e-3, 0.0]]"),
        }
    }
}

/// Parameters of the material of that name.
pub fn parameters(material: &str) -> &'static [Key] {
    MATERIALS
        .iter()
        .find(|(name, _)| *name == material)
        .map_or(&[], |(_, keys)| keys)
}

/// The part of the wall and the parameter that a path such as `wall.media.k2` names.
pub fn split_material(path: &str) -> Option<(&'static str, &str)> {
    MATERIAL_TABLES
        .iter()
        .find_map(|table| Some((*table, path.strip_prefix(table)?.strip_prefix('.')?)))
}

/// The first name of a path: the table at the root of the file.
pub fn root(path: &str) -> &str {
    path.split('.').next().unwrap_or(path)
}

/// What is known of the key at `path`.
pub fn find(path: &str) -> Option<Key> {
    let Some((_, parameter)) = split_material(path) else {
        return KEYS.iter().find(|key| key.path == path).copied();
    };
    let mut all = MATERIALS
        .iter()
        .flat_map(|(_, keys)| *keys)
        .chain([&MATERIAL]);
    all.find(|key| key.path == parameter).copied()
}

/// All paths that may appear in a file.
pub fn all_paths() -> Vec<String> {
    let mut paths: Vec<String> = KEYS.iter().map(|key| key.path.to_owned()).collect();
    for table in MATERIAL_TABLES {
        for key in MATERIALS
            .iter()
            .flat_map(|(_, keys)| *keys)
            .chain([&MATERIAL])
        {
            let path = format!("{table}.{}", key.path);
            if !paths.contains(&path) {
                paths.push(path);
            }
        }
    }
    paths
}
