//! Values of the command line that follow from those of the case: `*0.8` of what it has, and tables of lists by their
//! names.

use super::error::CaseError;
use super::schema::ValueKind;
use super::source::CaseValue;
use super::stack::Stack;
use super::value::shorten;
use crate::files::{Fault, fault};
use fsi_numerics::twelve_digits;
use toml::Value;

/// The entry with indices for names, `vessel.material[media].mu_Pa`, and a value for a factor.
pub(super) fn resolve(
    mut entry: CaseValue,
    stack: &Stack,
    errors: &mut Vec<CaseError>,
) -> Option<CaseValue> {
    let resolved = with_index(&entry.key, stack).and_then(|key| {
        entry.key = key;
        entry.value = scaled(&entry, stack)?;
        Ok(())
    });
    match resolved {
        Ok(()) => Some(entry),
        Err(fault) => {
            errors.push(CaseError::Nonsense {
                found: shorten(&entry.value),
                place: entry.place,
                key: entry.key,
                message: fault.to_string(),
            });
            None
        }
    }
}

/// `list[name].key` as `list[0].key`.
pub(super) fn with_index(key: &str, stack: &Stack) -> Result<String, Fault> {
    let Some((list, rest)) = key.split_once('[') else {
        return Ok(key.to_owned());
    };
    let Some((name, rest)) = rest.split_once(']') else {
        return Ok(key.to_owned());
    };
    let name = name.trim_matches('"');
    if name.parse::<usize>().is_ok() {
        return Ok(key.to_owned());
    }
    let named = |index: usize| {
        stack
            .entry(&format!("{list}[{index}].name"))?
            .value
            .as_str()
    };
    let names: Vec<&str> = (0..).map_while(named).collect();
    match names.iter().position(|known| *known == name) {
        Some(index) => Ok(format!("{list}[{index}]{rest}")),
        None if names.is_empty() => Err(fault!("the case has no tables [[{list}]] with names")),
        None => Err(fault!(
            "no [[{list}]] is called {name:?}; there is {}",
            names.join(", ")
        )),
    }
}

/// The value, or that of the case times its factor.
fn scaled(entry: &CaseValue, stack: &Stack) -> Result<Value, Fault> {
    let factor = entry.value.as_str().and_then(|text| text.strip_prefix('*'));
    let kind = stack.kind_of(&entry.key);
    let is_number = kind.is_some_and(|kind| {
        matches!(
            kind,
            ValueKind::Real(_)
                | ValueKind::Whole(..)
                | ValueKind::WholeOr(..)
                | ValueKind::Numbers(_)
                | ValueKind::Sizes(_)
                | ValueKind::Rows(_)
                | ValueKind::Radii(..)
                | ValueKind::Points(_)
        )
    });
    let Some(factor) = factor.filter(|_| is_number) else {
        return Ok(entry.value.clone());
    };
    let factor: f64 = (factor.trim().parse())
        .ok()
        .filter(|factor: &f64| factor.is_finite())
        .ok_or("expected a number after the *, such as *0.8")?;
    let base = stack
        .entry(&entry.key)
        .ok_or("the case has no value for it to multiply: give the value itself")?;
    let product = times(&base.value, factor);
    product
        .ok_or_else(|| "the value of the case is not a number, so it cannot be multiplied".into())
}

fn times(value: &Value, factor: f64) -> Option<Value> {
    Some(match value {
        // 2.475e8, not 2.4750000000000003e8
        Value::Float(x) => Value::Float(twelve_digits(x * factor)),
        Value::Integer(i) => {
            let product = *i as f64 * factor;
            match (product - product.round()).abs() < 1e-9 {
                true => Value::Integer(product.round() as i64),
                // Refused where a whole number is expected
                false => Value::Float(product),
            }
        }
        Value::Array(values) => values
            .iter()
            .map(|value| times(value, factor))
            .collect::<Option<_>>()
            .map(Value::Array)?,
        _ => return None,
    })
}
