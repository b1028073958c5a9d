//! Whether uncertain inputs are of keys that the case has, and can be what the tables say.

use super::Report;
use crate::case::schema::ValueKind;
use crate::case::stack::Stack;
use crate::case::uncertain::{MOST_LETTERS, NOT_DEFINITE, inputs, value_of};
use crate::case::{Case, Uncertain, relative, spelling};

pub(super) fn check(case: &Case, stack: &Stack, report: &mut Report<'_>) {
    let uncertain = case.uncertain.as_deref().unwrap_or_default();
    let mut usual = Vec::new();
    // Each with a single number.
    let mut spread: Vec<Uncertain> = Vec::new();
    let mut all_right = true;
    let mut wrong = |key: &str, what: String| {
        all_right = false;
        report(&[key], true, what);
    };
    let mut taken: Vec<String> = Vec::new();
    for (i, input) in uncertain.iter().enumerate() {
        let key = |name: &str| format!("uncertain[{i}].{name}");
        if input.name.contains(']') {
            wrong(
                &key("name"),
                "a name has no ]: choose a different one".into(),
            );
        }
        let parts = input.spread(case);
        let long = parts
            .iter()
            .find(|part| part.name.chars().count() > MOST_LETTERS);
        if let Some(long) = long {
            let what = format!(
                "{:?} would have more than {MOST_LETTERS} characters: choose a shorter one",
                long.name
            );
            wrong(&key("name"), what);
        }
        for part in parts {
            if spread
                .iter()
                .any(|other: &Uncertain| other.name == part.name)
            {
                let what = "another input has this name: choose a different one";
                wrong(&key("name"), what.into());
            }
            for found in &part.keys {
                match relative::with_index(found, stack) {
                    Ok(path) if taken.contains(&path) => wrong(
                        &key("keys"),
                        format!("{found} is listed twice: an input has each of its keys alone"),
                    ),
                    Ok(path) => {
                        if let Err(what) = varies(found, &path, case, stack) {
                            wrong(&key("keys"), what);
                        }
                        taken.push(path);
                    }
                    Err(fault) => wrong(&key("keys"), fault.to_string()),
                }
            }
            let value = part.value_in(case);
            if let Err((name, what)) = fits(&part, value, stack) {
                wrong(&key(name), what);
            }
            usual.push(value.unwrap_or(1.0));
            spread.push(part);
        }
    }
    let uncertain = spread;
    let correlations = case.correlation.as_deref().unwrap_or_default();
    for (i, pair) in correlations.iter().enumerate() {
        let key = |name: &str| format!("correlation[{i}].{name}");
        for (name, found) in [("first", &pair.first), ("second", &pair.second)] {
            if !uncertain.iter().any(|input| input.name == *found) {
                let names: Vec<&str> = uncertain.iter().map(|input| input.name.as_str()).collect();
                let what = match names.as_slice() {
                    [] => "the case has no [[uncertain]] inputs".to_owned(),
                    names => format!(
                        "no [[uncertain]] is called so; there is {}",
                        names.join(", ")
                    ),
                };
                wrong(&key(name), what);
            }
        }
        let is_same = |other: &crate::case::Correlation| {
            [&other.first, &other.second] == [&pair.first, &pair.second]
                || [&other.second, &other.first] == [&pair.first, &pair.second]
        };
        if pair.first == pair.second || correlations[..i].iter().any(is_same) {
            let what = "expected a pair of two different inputs that no other [[correlation]] has";
            wrong(&key("second"), what.into());
        }
    }
    if all_right && inputs(&uncertain, correlations, &usual).is_err() {
        report(&["correlation[0].coefficient"], true, NOT_DEFINITE.into());
    }
}

/// Whether the distribution of an input is one, and allowed for its key, which has this value; otherwise the key to
/// blame, and why.
fn fits(
    input: &Uncertain,
    value: Option<f64>,
    stack: &Stack,
) -> Result<(), (&'static str, String)> {
    let distribution = input.distribution(value.unwrap_or(1.0))?;
    let [low, high] = Uncertain::range(&distribution);
    let kind = relative::with_index(&input.keys[0], stack).ok();
    let kind = kind.and_then(|path| stack.kind_of(&path));
    let advice = "take a smaller variation, add low and high, or take lognormal";
    match (value, kind) {
        (Some(_), Some(ValueKind::Real(range)))
            if !range.contains(low) || !range.contains(high) =>
        {
            Err((
                "distribution",
                format!(
                    "its values reach from {low:.3e} to {high:.3e}, and {} is {range}: {advice}",
                    input.keys[0]
                ),
            ))
        }
        (None, _) if low <= 0.0 => Err((
            "distribution",
            format!(
                "it is a factor of its keys, with values from {low:.3e} on, and a factor is above 0: {advice}"
            ),
        )),
        _ => Ok(()),
    }
}

/// Whether a key has a value that can be multiplied, or why not.
fn varies(found: &str, path: &str, case: &Case, stack: &Stack) -> Result<(), String> {
    if let Some((list, index)) = relative::element(path, stack) {
        return match value_of(case, list).and_then(|all| Some(all.as_array()?.len())) {
            Some(count) if index < count => Ok(()),
            Some(count) => Err(format!(
                "{list} has {count} numbers, from [0] to [{}]",
                count - 1
            )),
            None => Err(format!(
                "the case has no value for {list}: add it to the case"
            )),
        };
    }
    let Some(kind) = stack.kind_of(path) else {
        let near = spelling::suggest(path, &stack.alternatives(path));
        let near = match near.first() {
            Some(near) => format!("; did you mean {near}?"),
            None => "; `fsi-driver keys` lists all".to_owned(),
        };
        return Err(format!("no key is called {found}{near}"));
    };
    let is_real = matches!(
        kind,
        ValueKind::Real(_)
            | ValueKind::Numbers(_)
            | ValueKind::Sizes(_)
            | ValueKind::Amplitudes(_)
            | ValueKind::Rows(_)
            | ValueKind::Radii(..)
            | ValueKind::Points(_)
    );
    if !is_real || path.starts_with("uncertain") || path.starts_with("correlation") {
        return Err(format!(
            "{found} is {kind}; only what is a real number, or a list of them, can be uncertain"
        ));
    }
    match stack.entry(path) {
        Some(_) => Ok(()),
        None => Err(format!(
            "the case has no value for {found}: add it to the case"
        )),
    }
}
