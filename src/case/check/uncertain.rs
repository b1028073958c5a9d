//! Whether uncertain inputs are of keys that the case has, and can be what the tables say.

use super::Report;
use crate::case::schema::ValueKind;
use crate::case::stack::Stack;
use crate::case::uncertain::{NOT_DEFINITE, inputs};
use crate::case::{Case, Uncertain, relative, spelling};

pub(super) fn check(case: &Case, stack: &Stack, report: &mut Report<'_>) {
    let uncertain = case.uncertain.as_deref().unwrap_or_default();
    let mut usual = Vec::new();
    let mut all_right = true;
    let mut wrong = |key: &str, what: String| {
        all_right = false;
        report(&[key], true, what);
    };
    let mut taken: Vec<String> = Vec::new();
    for (i, input) in uncertain.iter().enumerate() {
        let key = |name: &str| format!("uncertain[{i}].{name}");
        if uncertain[..i].iter().any(|other| other.name == input.name) {
            let what = "another input has this name: choose a different one";
            wrong(&key("name"), what.into());
        }
        for found in &input.keys {
            match relative::with_index(found, stack) {
                Ok(path) if taken.contains(&path) => wrong(
                    &key("keys"),
                    format!("{found} is listed twice: an input has each of its keys alone"),
                ),
                Ok(path) => {
                    if let Err(what) = varies(found, &path, stack) {
                        wrong(&key("keys"), what);
                    }
                    taken.push(path);
                }
                Err(fault) => wrong(&key("keys"), fault.to_string()),
            }
        }
        let value = input.value_in(case);
        match input.distribution(value.unwrap_or(1.0)) {
            Err((name, what)) => wrong(&key(name), what),
            Ok(distribution) => {
                let [low, high] = Uncertain::range(&distribution);
                let kind = relative::with_index(&input.keys[0], stack).ok();
                let kind = kind.and_then(|path| stack.kind_of(&path));
                let advice = "take a smaller variation, add low and high, or take lognormal";
                match (value, kind) {
                    (Some(_), Some(ValueKind::Real(range)))
                        if !range.contains(low) || !range.contains(high) =>
                    {
                        let what = format!(
                            "its values reach from {low:.3e} to {high:.3e}, and {} is {range}: {advice}",
                            input.keys[0]
                        );
                        wrong(&key("distribution"), what);
                    }
                    (None, _) if low <= 0.0 => wrong(
                        &key("distribution"),
                        format!(
                            "it is a factor of its keys, with values from {low:.3e} on, and a factor is above 0: {advice}"
                        ),
                    ),
                    _ => {}
                }
            }
        }
        usual.push(value.unwrap_or(1.0));
    }
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
    if all_right && inputs(uncertain, correlations, &usual).is_err() {
        report(&["correlation[0].coefficient"], true, NOT_DEFINITE.into());
    }
}

/// Whether a key has a value that can be multiplied, or why not.
fn varies(found: &str, path: &str, stack: &Stack) -> Result<(), String> {
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
