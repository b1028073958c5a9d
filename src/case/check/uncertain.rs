//! Whether uncertain inputs are of keys that the case has, and can be what the tables say.

use super::Report;
use crate::schema::ValueKind;
use crate::stack::Stack;
use crate::uncertain::{MOST_LETTERS, NOT_DEFINITE, inputs, value_of};
use crate::{Case, Correlation, Uncertain, relative, spelling};

pub(super) fn check(case: &Case, stack: &Stack, report: &mut Report<'_>) {
    let mut inputs = FoundInputs::default();
    for (i, input) in case.uncertain.iter().flatten().enumerate() {
        inputs.add(i, input, case, stack);
    }
    let correlations = case.correlation.as_deref().unwrap_or_default();
    for i in 0..correlations.len() {
        inputs.check_pair(i, correlations);
    }
    for (key, what) in &inputs.mistakes {
        report(&[key], true, what.clone());
    }
    if inputs.mistakes.is_empty() && inputs.are_contradictory(correlations) {
        report(&["correlation[0].coefficient"], true, NOT_DEFINITE.into());
    }
}

/// The inputs so far, each with a single number.
#[derive(Default)]
struct FoundInputs {
    spread: Vec<Uncertain>,
    /// Values of the case; 1 of a factor.
    usual: Vec<f64>,
    /// Keys that they have.
    taken: Vec<String>,
    /// Keys, and what is wrong with them.
    mistakes: Vec<(String, String)>,
}

impl FoundInputs {
    fn add(&mut self, i: usize, input: &Uncertain, case: &Case, stack: &Stack) {
        let parts = input.spread(case);
        if input.name.contains(']') {
            let what = "a name has no ]: choose a different one";
            self.wrong(i, "name", what.into());
        }
        let is_long = |part: &&Uncertain| part.name.chars().count() > MOST_LETTERS;
        if let Some(long) = parts.iter().find(is_long) {
            let what = format!(
                "{:?} would have more than {MOST_LETTERS} characters: choose a shorter one",
                long.name
            );
            self.wrong(i, "name", what);
        }
        for part in parts {
            if self.spread.iter().any(|other| other.name == part.name) {
                let what = "another input has this name: choose a different one";
                self.wrong(i, "name", what.into());
            }
            for found in &part.keys {
                if let Err(what) = self.take(found, case, stack) {
                    self.wrong(i, "keys", what);
                }
            }
            let value = part.value_in(case);
            if let Err((name, what)) = fits(&part, value, stack) {
                self.wrong(i, name, what);
            }
            self.usual.push(value.unwrap_or(1.0));
            self.spread.push(part);
        }
    }

    /// Takes a key, or says why it cannot be an input's.
    fn take(&mut self, found: &str, case: &Case, stack: &Stack) -> Result<(), String> {
        let path = relative::with_index(found, stack).map_err(|fault| fault.to_string())?;
        if self.taken.contains(&path) {
            return Err(format!(
                "{found} is listed twice: an input has each of its keys alone"
            ));
        }
        let varies = varies(found, &path, case, stack);
        self.taken.push(path);
        varies
    }

    fn wrong(&mut self, i: usize, name: &str, what: String) {
        self.mistakes.push((format!("uncertain[{i}].{name}"), what));
    }

    fn check_pair(&mut self, i: usize, correlations: &[Correlation]) {
        let pair = &correlations[i];
        let mut wrong = |name: &str, what| {
            self.mistakes
                .push((format!("correlation[{i}].{name}"), what))
        };
        for (name, found) in [("first", &pair.first), ("second", &pair.second)] {
            let names: Vec<&str> = self
                .spread
                .iter()
                .map(|input| input.name.as_str())
                .collect();
            if names.contains(&found.as_str()) {
                continue;
            }
            wrong(
                name,
                match names.as_slice() {
                    [] => "the case has no [[uncertain]] inputs".to_owned(),
                    names => format!(
                        "no [[uncertain]] is called so; there is {}",
                        names.join(", ")
                    ),
                },
            );
        }
        let is_same = |other: &Correlation| {
            [&other.first, &other.second] == [&pair.first, &pair.second]
                || [&other.second, &other.first] == [&pair.first, &pair.second]
        };
        if pair.first == pair.second || correlations[..i].iter().any(is_same) {
            let what = "expected a pair of two different inputs that no other [[correlation]] has";
            wrong("second", what.into());
        }
    }

    fn are_contradictory(&self, correlations: &[Correlation]) -> bool {
        inputs(&self.spread, correlations, &self.usual).is_err()
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
