//! Values of the command line that follow from those of the case: `*0.8` of what it has, tables of lists by their
//! names, and single numbers of lists by their indices.

use super::error::CaseError;
use super::schema::ValueKind;
use super::source::CaseValue;
use super::stack::Stack;
use super::value::{self, shorten};
use crate::files::{Fault, fault};
use fsi_numerics::twelve_digits;
use toml::Value;

/// The entries with indices for names, `vessel.material[media].mu_Pa`, values for factors, and whole lists for single
/// numbers of them, `vessel.radii_m[3]`.
pub(super) fn resolve(
    entries: Vec<CaseValue>,
    stack: &Stack,
    errors: &mut Vec<CaseError>,
) -> Vec<CaseValue> {
    let mut resolved: Vec<CaseValue> = Vec::new();
    for mut entry in entries {
        let found = with_index(&entry.key, stack).and_then(|key| {
            entry.key = key;
            let element = element(&entry.key, stack).map(|(list, i)| (list.to_owned(), i));
            let Some((list, index)) = element else {
                entry.value = scaled(&entry, stack)?;
                return Ok(());
            };
            let earlier = resolved.iter().rev().find(|earlier| earlier.key == list);
            let whole = earlier.or_else(|| stack.entry(&list));
            let whole = whole.map(|whole| &whole.value);
            entry.value = with_element(whole, index, &entry.value, stack.kind_of(&list))?;
            entry.key = list;
            Ok(())
        });
        match found {
            Ok(()) => {
                resolved.retain(|earlier| earlier.key != entry.key);
                resolved.push(entry);
            }
            Err(fault) => errors.push(CaseError::Nonsense {
                found: shorten(&entry.value),
                place: entry.place,
                key: entry.key,
                message: fault.to_string(),
            }),
        }
    }
    resolved
}

/// The list and the index of `path`, if that is a single number of a list: `vessel.radii_m[3]`.
pub(super) fn element<'a>(path: &'a str, stack: &Stack) -> Option<(&'a str, usize)> {
    let (list, index) = value::split_index(path)?;
    let kind = stack.kind_of(list)?;
    let is_list = matches!(
        kind,
        ValueKind::Numbers(_) | ValueKind::Sizes(_) | ValueKind::Amplitudes(_)
    );
    is_list.then_some((list, index))
}

/// The list `whole` with another number at `index`, or a multiple of the one that it has.
fn with_element(
    whole: Option<&Value>,
    index: usize,
    number: &Value,
    kind: Option<ValueKind>,
) -> Result<Value, Fault> {
    let mut all = whole.and_then(Value::as_array).cloned().unwrap_or_default();
    if let Some(ValueKind::Amplitudes(most)) = kind
        && index < most
    {
        all.resize(all.len().max(index + 1), Value::Float(0.0));
    }
    let count = all.len();
    let Some(place) = all.get_mut(index) else {
        return Err(match count {
            0 => fault!("the case has no such list: give all of it"),
            _ => fault!("the list has {count} numbers, from [0] to [{}]", count - 1),
        });
    };
    let factor = number.as_str().and_then(|text| text.strip_prefix('*'));
    *place = match factor {
        None => number.clone(),
        Some(factor) => times(place, read_factor(factor)?)
            .ok_or("the value of the case is not a number, so it cannot be multiplied")?,
    };
    Ok(Value::Array(all))
}

fn read_factor(text: &str) -> Result<f64, Fault> {
    let factor = text.trim().parse().ok();
    factor
        .filter(|factor: &f64| factor.is_finite())
        .ok_or_else(|| "expected a number after the *, such as *0.8".into())
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
                | ValueKind::Amplitudes(_)
                | ValueKind::Rows(_)
                | ValueKind::Radii(..)
                | ValueKind::Points(_)
        )
    });
    let Some(factor) = factor.filter(|_| is_number) else {
        return Ok(entry.value.clone());
    };
    let factor = read_factor(factor)?;
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
