//! Units as people write them: `ml/min`, `cm³ s⁻¹`, `cm^3/sec`, `mL·min-1`, `dyn/cm2`, `mm Hg`.

/// A text where a unit belongs that is none, or one of something else.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{text:?} is not a unit of {}: expected {}", called(*.wanted), offered(*.wanted))]
pub struct ForeignUnit {
    /// What was found.
    pub text: String,
    /// What it should be a unit of.
    pub wanted: Dimension,
}

/// A unit in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Its size.
    pub size: f64,
    /// Powers of length, mass and time.
    pub dimension: Dimension,
}

/// Powers of length, mass and time.
pub type Dimension = [i8; 3];

/// A millimetre of mercury, Pa.
pub const MMHG: f64 = 133.322;

/// Length.
pub const LENGTH: Dimension = [1, 0, 0];
/// Time.
pub const TIME: Dimension = [0, 0, 1];
/// Volume per time.
pub const FLOW: Dimension = [3, 0, -1];
/// Force per area.
pub const PRESSURE: Dimension = [-1, 1, -2];
/// Length per time.
pub const VELOCITY: Dimension = [1, 0, -1];
const VOLUME: Dimension = [3, 0, 0];
const AREA: Dimension = [2, 0, 0];
const FORCE: Dimension = [1, 1, -2];
const MASS: Dimension = [0, 1, 0];

/// Spellings, size and dimension. Upper and lower case are the same, except where they make two units; names have a
/// plural and are also written as in America.
const SYMBOLS: &[(&[&str], f64, Dimension)] = &[
    (&["m", "metre"], 1.0, LENGTH),
    (&["dm"], 0.1, LENGTH),
    (&["cm", "centimetre"], 1e-2, LENGTH),
    (&["mm", "millimetre"], 1e-3, LENGTH),
    (&["um", "micron", "micrometre"], 1e-6, LENGTH),
    (&["l", "litre", "ltr"], 1e-3, VOLUME),
    (&["dl"], 1e-4, VOLUME),
    (&["cl"], 1e-5, VOLUME),
    (&["ml", "cc", "ccm", "millilitre"], 1e-6, VOLUME),
    (&["ul", "microlitre"], 1e-9, VOLUME),
    (&["s", "sec", "second"], 1.0, TIME),
    (&["ms", "msec", "millisecond"], 1e-3, TIME),
    (&["us", "usec"], 1e-6, TIME),
    (&["min", "minute"], 60.0, TIME),
    (&["h", "hr", "hour"], 3600.0, TIME),
    (&["g", "gram"], 1e-3, MASS),
    (&["kg"], 1.0, MASS),
    (&["N", "newton"], 1.0, FORCE),
    (&["mN"], 1e-3, FORCE),
    (&["dyn", "dyne"], 1e-5, FORCE),
    (&["Pa", "pascal"], 1.0, PRESSURE),
    (&["hPa"], 1e2, PRESSURE),
    (&["kPa"], 1e3, PRESSURE),
    (&["mPa"], 1e-3, PRESSURE),
    (&["MPa"], 1e6, PRESSURE),
    (&["bar"], 1e5, PRESSURE),
    (&["mbar"], 1e2, PRESSURE),
    (&["mmHg", "torr"], MMHG, PRESSURE),
    (&["cmHg"], 10.0 * MMHG, PRESSURE),
    (&["mmH2O"], 9.80665, PRESSURE),
    (&["cmH2O"], 98.0665, PRESSURE),
    (&["atm"], 101_325.0, PRESSURE),
    (&["psi"], 6894.757, PRESSURE),
    (&["barye", "ba"], 0.1, PRESSURE),
    (&["mls"], 1e-6, FLOW),
    (&["mlmin", "mlpm"], 1e-6 / 60.0, FLOW),
    (&["ls"], 1e-3, FLOW),
    (&["lmin", "lpm"], 1e-3 / 60.0, FLOW),
    (&["m3s"], 1.0, FLOW),
    (&["cm3s", "ccs"], 1e-6, FLOW),
    (&["mm3s"], 1e-9, FLOW),
    (&["dyncm2"], 0.1, PRESSURE),
];

/// Sizes that are often products of others.
const EXACT: [f64; 8] = [1.0, 1e-3, 1e-6, 1e-9, 1e-6 / 60.0, 1e-3 / 60.0, 0.1, 1e6];

/// What a quantity of some dimension is called, for messages.
pub fn called(dimension: Dimension) -> &'static str {
    match dimension {
        LENGTH => "length",
        TIME => "time",
        FLOW => "flow",
        PRESSURE => "pressure",
        VELOCITY => "velocity",
        VOLUME => "volume",
        AREA => "area",
        FORCE => "force",
        MASS => "mass",
        _ => "another quantity",
    }
}

/// The units to write for a quantity, for messages; all usual spellings of them are known.
pub fn offered(dimension: Dimension) -> &'static str {
    match dimension {
        FLOW => "m3/s, cm3/s, mm3/s, ml/s, ml/min, l/s, l/min",
        PRESSURE => "Pa, kPa, mmHg, cmH2O, dyn/cm2, mbar",
        LENGTH => "m, cm, mm, um",
        _ => "s, ms, min",
    }
}

impl Unit {
    /// Understands products and quotients of symbols with powers, in brackets or not, with letters and digits of any
    /// alphabet.
    pub fn parse(text: &str) -> Option<Self> {
        let text = plain(text);
        let (size, text) = power_of_ten(&text);
        let mut unit = Self {
            size,
            dimension: [0; 3],
        };
        let mut count = 0;
        for (i, quotient) in text.split('/').enumerate() {
            for (j, factor) in quotient
                .split([' ', '.'])
                .filter(|f| !f.is_empty())
                .enumerate()
            {
                let (symbol, power) = factor_of(factor)?;
                let power = if i > 0 && j == 0 { -power } else { power };
                unit.size *= symbol.size.powi(power);
                for (sum, of) in unit.dimension.iter_mut().zip(symbol.dimension) {
                    *sum = sum.checked_add(of.checked_mul(i8::try_from(power).ok()?)?)?;
                }
                count += 1;
            }
        }
        // Without what products of powers of ten lose in the last digit.
        let exact = EXACT
            .iter()
            .find(|exact| (unit.size / **exact - 1.0).abs() < 1e-12);
        unit.size = exact.copied().unwrap_or(unit.size);
        (count > 0 && unit.dimension != [0; 3]).then_some(unit)
    }

    /// A unit that is among those understood.
    pub fn known(text: &str) -> Self {
        Self::parse(text).expect("the unit is known")
    }

    /// The unit with which a column's name ends, as `flow_ml_min`, `Q (ml/min)`, `Q / ml/min` or `pressure [mmHg]`.
    ///
    /// # Errors
    /// What stands in brackets after the name, if that looks like a unit and is none of this dimension.
    pub fn of_name(name: &str, wanted: Dimension) -> Result<Option<Self>, ForeignUnit> {
        if let Some((_, rest)) = name.rsplit_once(['(', '[', '{']) {
            let inside = rest.trim_end_matches([')', ']', '}', ' ']);
            return match Self::parse(inside) {
                Some(unit) if unit.dimension == wanted => Ok(Some(unit)),
                None if !inside.contains(['/', '^', '³']) => Ok(None),
                _ => Err(ForeignUnit {
                    text: inside.to_owned(),
                    wanted,
                }),
            };
        }
        // Every way to cut off what stands before the unit
        let cuts = name.match_indices(['_', ' ', '/', ',']);
        let found = cuts.filter_map(|(i, _)| {
            let words: Vec<&str> = (name[i + 1..].split(['_', ' ', ',']))
                .filter(|word| !word.is_empty() && *word != "in")
                .collect();
            // In a name there is no slash between ml and min.
            let last = words.last().map_or("", |word| *word);
            let quotient = match words.len() {
                0 | 1 => None,
                n => Some(format!("{}/{last}", words[..n - 1].join(" "))),
            };
            let is_wanted = |unit: &Self| unit.dimension == wanted;
            (quotient.as_deref().and_then(Self::parse).filter(is_wanted))
                .or_else(|| Self::parse(&words.join(" ")).filter(is_wanted))
        });
        Ok(found.into_iter().next())
    }

    /// The only unit of this dimension that a line of text names, such as `flow in mm^3/s`; none if it names several.
    pub fn within(text: &str, wanted: Dimension) -> Option<Self> {
        let words = text.split([' ', '\t', ',', ';', ':', '=', '"']);
        let mut units = words.filter_map(|word| {
            let word = word.trim_matches(['(', ')', '[', ']', '.']);
            Self::parse(word).filter(|unit| unit.dimension == wanted)
        });
        let first = units.next()?;
        units.all(|unit| unit.is(&first)).then_some(first)
    }

    /// Whether both have the same size.
    pub fn is(&self, other: &Self) -> bool {
        (self.size / other.size - 1.0).abs() < 1e-6
    }
}

/// One symbol with its power, as `cm3`, `s-1` or `mmHg`.
fn factor_of(factor: &str) -> Option<(Unit, i32)> {
    if let Some(unit) = symbol(factor) {
        return Some((unit, 1));
    }
    let digits = factor.find(|c: char| c.is_ascii_digit() || c == '-')?;
    let power: i32 = factor[digits..].parse().ok()?;
    let unit = symbol(&factor[..digits])?;
    (power != 0 && power.abs() < 10).then_some((unit, power))
}

fn symbol(word: &str) -> Option<Unit> {
    let british = word
        .to_lowercase()
        .replace("meter", "metre")
        .replace("liter", "litre");
    let is_name = |known: &str| known.len() > 2 && known.chars().all(|c| c.is_ascii_lowercase());
    let is_plural = |known: &str| is_name(known) && british.strip_suffix('s') == Some(known);
    let find = |is: &dyn Fn(&str) -> bool| {
        let found = SYMBOLS
            .iter()
            .find(|(words, ..)| words.iter().any(|known| is(known)));
        found.map(|(_, size, dimension)| Unit {
            size: *size,
            dimension: *dimension,
        })
    };
    find(&|known| known == word)
        .or_else(|| {
            // MPA might be either.
            let is_clear = british != "mpa";
            find(&|known| is_clear && known.eq_ignore_ascii_case(&british))
        })
        .or_else(|| find(&is_plural))
}

/// A power of ten before a unit, as in `10^-6 m^3/s`, and the rest.
fn power_of_ten(text: &str) -> (f64, &str) {
    let bare = text.trim_start_matches(['x', 'X', ' ']);
    let Some((head, rest)) = bare.split_once(' ') else {
        return (1.0, text);
    };
    let power = head
        .strip_prefix("10")
        .and_then(|power| power.parse::<i32>().ok());
    let size = match power.filter(|power| power.abs() < 13) {
        Some(power) => Some(10f64.powi(power)),
        None => (head.parse::<f64>().ok()).filter(|_| head.contains(['e', 'E'])),
    };
    match size.filter(|size| *size > 0.0 && size.is_finite()) {
        Some(size) => (size, rest),
        None => (1.0, text),
    }
}

/// In ASCII, without brackets and signs of powers.
fn plain(text: &str) -> String {
    let mut plain = String::new();
    for c in text.trim().replace("**", "").chars() {
        match c {
            '(' | ')' | '[' | ']' | '{' | '}' | '^' | '$' | '\\' => {}
            '⁰' => plain.push('0'),
            '¹' => plain.push('1'),
            '²' | '₂' => plain.push('2'),
            '³' => plain.push('3'),
            '⁴'..='⁹' => plain.extend(char::from_digit(c as u32 - '⁰' as u32, 10)),
            '⁻' | '−' | '–' => plain.push('-'),
            '\u{b5}' | '\u{3bc}' => plain.push('u'),
            'ℓ' => plain.push('l'),
            '·' | '⋅' | '*' | '×' | '\u{a0}' | '\u{202f}' => plain.push(' '),
            '∕' | '⁄' => plain.push('/'),
            c => plain.push(c),
        }
    }
    let words: Vec<&str> = (plain.split_whitespace())
        .map(|word| {
            if word.eq_ignore_ascii_case("per") {
                "/"
            } else {
                word
            }
        })
        .collect();
    let joined = words.join(" ");
    let lower = joined.to_lowercase();
    for (apart, whole) in [
        ("mm hg", "mmHg"),
        ("cm hg", "cmHg"),
        ("cm h2o", "cmH2O"),
        ("mm h2o", "mmH2O"),
    ] {
        if lower == apart {
            return whole.into();
        }
    }
    joined
}

#[cfg(test)]
mod tests;
