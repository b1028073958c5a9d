//! Lengths and pressures of the command line, with their unit after the number: 0.7mm, 80mmHg.

use crate::tabular::units::{Dimension, LENGTH, PRESSURE, Unit};

/// A value in its SI unit, and as it was typed.
#[derive(Debug, Clone)]
pub struct Given {
    /// In the SI unit.
    pub si: f64,
    /// With its unit.
    pub typed: String,
}

impl Given {
    fn new(si: f64, typed: &str) -> Self {
        let typed = typed.to_owned();
        Self { si, typed }
    }
}

/// A length in metres; a number alone counts in metres.
pub fn length(text: &str) -> Result<Given, String> {
    (text.trim().parse().ok().filter(|x: &f64| x.is_finite()))
        .or_else(|| quantity(text, LENGTH))
        .map(|si| Given::new(si, text))
        .ok_or_else(|| "expected a length such as 3mm, 0.3cm, or a number in metres".into())
}

/// A pressure in pascals, with its unit.
pub fn pressure(text: &str) -> Result<Given, String> {
    let advice = "expected a pressure with its unit, such as 80mmHg, 10.7kPa or 10666Pa";
    let si = quantity(text, PRESSURE).ok_or(advice)?;
    Ok(Given::new(si, text))
}

fn quantity(text: &str, dimension: Dimension) -> Option<f64> {
    let is_of_unit = |c: char| c.is_alphabetic() && !c.eq_ignore_ascii_case(&'e');
    let (number, unit) = text.split_at(text.find(is_of_unit)?);
    let unit = Unit::parse(unit).filter(|unit| unit.dimension == dimension)?;
    let number: f64 = number.trim().parse().ok()?;
    number.is_finite().then_some(number * unit.size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_follow_the_number() {
        for (text, metres) in [
            ("0.7mm", 0.7e-3),
            ("3 mm", 3e-3),
            ("0.3CM", 3e-3),
            ("2e-3", 2e-3),
            ("-3m", -3.0),
            ("500um", 5e-4),
        ] {
            let found = length(text).unwrap().si;
            assert!((found - metres).abs() < 1e-12, "{text}: {found}");
        }
        for (text, pascals) in [("80mmHg", 10665.76), ("10.7 kPa", 10700.0), ("1e4Pa", 1e4)] {
            let found = pressure(text).unwrap().si;
            assert!((found - pascals).abs() < 1e-6, "{text}: {found}");
        }
        for wrong in ["", "mm", "3 inch", "nan", "infm", "3mmm", "µm"] {
            assert!(length(wrong).is_err(), "{wrong}");
        }
        for wrong in ["80", "mmHg", "80 mm", "80 mmhg2"] {
            assert!(pressure(wrong).is_err(), "{wrong}");
        }
    }
}
