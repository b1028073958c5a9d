//! Lengths and pressures of the command line, with their unit after the number: 0.7mm, 80mmHg.

/// Units of lengths in metres, and of pressures in pascals.
const LENGTHS: [(&str, f64); 4] = [("mm", 1e-3), ("cm", 1e-2), ("um", 1e-6), ("m", 1.0)];
const PRESSURES: [(&str, f64); 3] = [("mmHg", 133.322), ("kPa", 1e3), ("Pa", 1.0)];

/// A length in metres; a number alone counts in metres.
pub fn length(text: &str) -> Result<f64, String> {
    let advice = "expected a length such as 3mm, 0.3cm, or a number in metres";
    quantity(text, &LENGTHS, Some(1.0)).ok_or_else(|| advice.to_owned())
}

/// A pressure in pascals, with its unit.
pub fn pressure(text: &str) -> Result<f64, String> {
    let advice = "expected a pressure with its unit, such as 80mmHg, 10.7kPa or 10666Pa";
    quantity(text, &PRESSURES, None).ok_or_else(|| advice.to_owned())
}

fn quantity(text: &str, units: &[(&str, f64)], alone: Option<f64>) -> Option<f64> {
    let text = text.trim();
    let found = units.iter().find_map(|(unit, size)| {
        let split = text.len().checked_sub(unit.len())?;
        let (number, last) = (text.get(..split)?, text.get(split..)?);
        last.eq_ignore_ascii_case(unit).then_some((number, *size))
    });
    let (number, size) = found.or(alone.map(|size| (text, size)))?;
    let number: f64 = number.trim().parse().ok()?;
    number.is_finite().then_some(number * size)
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
            let found = length(text).unwrap();
            assert!((found - metres).abs() < 1e-12, "{text}: {found}");
        }
        for (text, pascals) in [("80mmHg", 10665.76), ("10.7 kPa", 10700.0), ("1e4Pa", 1e4)] {
            let found = pressure(text).unwrap();
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
