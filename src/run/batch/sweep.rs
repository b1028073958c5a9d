//! The variants of a case in a study: values of keys in all combinations, one at a time, or row by row from a file.

use crate::case::{Override, ValuePlace};
use crate::run::{CaseSelection, Failure};
use std::collections::BTreeSet;
use std::path::Path;

/// Longest part of a folder's name that tells a value.
const LONGEST: usize = 40;

/// Keys that change together, with their values.
struct Sweep {
    keys: Vec<String>,
    /// Each with a value for every key, and what it is called.
    values: Vec<(Vec<String>, String)>,
}

/// What a study varies.
pub struct Variation<'a> {
    /// `KEY=VALUE,…`, linked keys joined by `+`.
    pub sweeps: &'a [String],
    /// Whether each value is tried by itself, next to the case as it is, and not in all combinations.
    pub one_at_a_time: bool,
    /// A table with a column a key and a row a variant.
    pub samples: Option<&'a Path>,
}

impl Variation<'_> {
    /// The selections, each with what it adds to the name of its model.
    ///
    /// # Errors
    /// If a sweep or the table cannot be understood.
    pub fn variants(
        &self,
        selection: &CaseSelection,
    ) -> Result<Vec<(String, CaseSelection)>, Failure> {
        if let Some(path) = self.samples {
            return samples(path, selection);
        }
        let sweeps = self.sweeps.iter().map(|sweep| Sweep::parse(sweep));
        let sweeps: Vec<Sweep> = sweeps.collect::<Result<_, _>>()?;
        let keys: Vec<&str> = sweeps.iter().map(|sweep| sweep.keys[0].as_str()).collect();
        let labels = labels(&keys);
        let mut all = vec![(String::new(), selection.clone())];
        if self.one_at_a_time {
            for (sweep, label) in sweeps.iter().zip(&labels) {
                let alone = sweep.values.iter();
                all.extend(
                    alone.map(|value| {
                        with(&(String::new(), selection.clone()), sweep, value, label)
                    }),
                );
            }
            return Ok(all);
        }
        for (sweep, label) in sweeps.iter().zip(&labels) {
            let each = |before: &(String, CaseSelection)| {
                let values = sweep.values.iter();
                values
                    .map(|value| with(before, sweep, value, label))
                    .collect::<Vec<_>>()
            };
            all = all.iter().flat_map(each).collect();
        }
        Ok(all)
    }
}

fn with(
    (before, selection): &(String, CaseSelection),
    sweep: &Sweep,
    (values, name): &(Vec<String>, String),
    label: &str,
) -> (String, CaseSelection) {
    let mut selection = selection.clone();
    for (key, value) in sweep.keys.iter().zip(values) {
        selection.given.push(Override {
            place: ValuePlace::Sweep,
            key: key.clone(),
            value: value.clone(),
        });
    }
    (format!("{before}-{label}={}", in_a_name(name)), selection)
}

impl Sweep {
    fn parse(text: &str) -> Result<Self, Failure> {
        let wrong = |why: &str| Failure::Input(format!("--sweep {text}: {why}"));
        let (keys, values) = text.split_once('=').ok_or_else(|| {
            wrong("expected KEY=VALUE,VALUE…, such as wall.media.k1_Pa=500,1000 or wall.media.k1_Pa=*0.8,*1.2")
        })?;
        let keys: Vec<String> = keys.split('+').map(|key| key.trim().to_owned()).collect();
        if keys.iter().any(String::is_empty) {
            return Err(wrong("a key is missing: linked keys are KEY+KEY=VALUE,…"));
        }
        let mut found: Vec<(Vec<String>, String)> = Vec::new();
        for value in outer_parts(values, ',') {
            let parts: Vec<String> = match keys.len() {
                1 => vec![value.to_owned()],
                _ => outer_parts(value, ':')
                    .into_iter()
                    .map(str::to_owned)
                    .collect(),
            };
            if parts.iter().any(String::is_empty) {
                return Err(wrong("a value is missing between the commas"));
            }
            if found.iter().any(|(_, name)| name == value) {
                return Err(wrong(&format!("the value {value} is listed twice")));
            }
            let parts = match parts.len() {
                1 => vec![parts[0].clone(); keys.len()],
                n if n == keys.len() => parts,
                n => {
                    return Err(wrong(&format!(
                        "{value} has {n} values for {} linked keys: give one for all, or one for each with colons between",
                        keys.len()
                    )));
                }
            };
            found.push((parts, value.to_owned()));
        }
        Ok(Self {
            keys,
            values: found,
        })
    }
}

/// The parts of a text between separators outside brackets and quotes.
fn outer_parts(text: &str, separator: char) -> Vec<&str> {
    let (mut parts, mut from, mut depth, mut quoted) = (Vec::new(), 0, 0_i32, false);
    for (at, letter) in text.char_indices() {
        match letter {
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth -= 1,
            letter if letter == separator && depth == 0 && !quoted => {
                parts.push(text[from..at].trim());
                from = at + letter.len_utf8();
            }
            _ => {}
        }
    }
    parts.push(text[from..].trim());
    parts
}

/// The shortest ends of dotted keys that tell them apart.
fn labels(keys: &[&str]) -> Vec<String> {
    let end = |key: &str, parts: usize| {
        let all: Vec<&str> = key.split('.').collect();
        all[all.len().saturating_sub(parts)..].join(".")
    };
    let longest = keys.iter().map(|key| key.split('.').count()).max();
    let distinct = |parts: &usize| {
        let ends: BTreeSet<String> = keys.iter().map(|key| end(key, *parts)).collect();
        ends.len() == keys.len()
    };
    let parts = (1..=longest.unwrap_or(1)).find(distinct).unwrap_or(1);
    keys.iter().map(|key| in_a_name(&end(key, parts))).collect()
}

/// A key or a value as a part of a folder's name, which a shell takes as it is.
fn in_a_name(text: &str) -> String {
    let letter = |c: char| match c {
        '*' => 'x',
        c if c.is_ascii_alphanumeric() || "._-+".contains(c) => c,
        _ => '-',
    };
    let letters = text.chars().filter(|c| *c != ']');
    let name: String = letters.map(letter).take(LONGEST).collect();
    name.trim_matches('-').to_owned()
}

/// The variants of a table: a column a key (linked ones with `+`), perhaps one with a `name`; an empty cell leaves the
/// case's own value.
fn samples(
    path: &Path,
    selection: &CaseSelection,
) -> Result<Vec<(String, CaseSelection)>, Failure> {
    let wrong = |what: &dyn std::fmt::Display| {
        Failure::Input(format!("--samples {}: {what}", path.display()))
    };
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_path(path)
        .map_err(|e| wrong(&e))?;
    let heads = reader.headers().map_err(|e| wrong(&e))?.clone();
    let heads: Vec<&str> = heads
        .iter()
        .map(|head| head.trim_start_matches('\u{feff}'))
        .collect();
    if heads.iter().all(|head| *head == "name") || heads.iter().any(|head| head.is_empty()) {
        return Err(wrong(
            &"expected a first line with keys, such as name,vessel.radius_m,wall.media.k1_Pa",
        ));
    }
    let mut found: Vec<(String, CaseSelection)> = Vec::new();
    for (number, row) in reader.records().enumerate() {
        let row = row.map_err(|e| wrong(&e))?;
        let mut chosen = selection.clone();
        let mut name = format!("{:03}", number + 1);
        for (head, cell) in heads.iter().zip(&row) {
            match (*head, cell) {
                (_, "") => {}
                ("name", cell) => name = in_a_name(cell),
                (keys, cell) => chosen.given.extend(keys.split('+').map(|key| Override {
                    place: ValuePlace::Sweep,
                    key: key.trim().to_owned(),
                    value: cell.to_owned(),
                })),
            }
        }
        let name = format!("-{name}");
        if found.iter().any(|(other, _)| *other == name) {
            return Err(wrong(&format!("two rows are called {}", &name[1..])));
        }
        found.push((name, chosen));
    }
    match found.is_empty() {
        true => Err(wrong(&"the table has no row")),
        false => Ok(found),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Preset;

    fn variants(
        sweeps: &[&str],
        one_at_a_time: bool,
        samples: Option<&Path>,
    ) -> Result<Vec<(String, Vec<String>)>, String> {
        let sweeps: Vec<String> = sweeps.iter().map(|sweep| (*sweep).to_owned()).collect();
        let variation = Variation {
            sweeps: &sweeps,
            one_at_a_time,
            samples,
        };
        let selection = CaseSelection::new(Preset::Demo, Vec::new());
        let found = variation.variants(&selection).map_err(|e| e.to_string())?;
        let shown = |(name, selection): (String, CaseSelection)| {
            let given = selection.given.iter();
            (
                name,
                given.map(|o| format!("{}={}", o.key, o.value)).collect(),
            )
        };
        Ok(found.into_iter().map(shown).collect())
    }

    fn names(found: &[(String, Vec<String>)]) -> Vec<&str> {
        found.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// Values combine or stand alone, and linked keys change together.
    #[test]
    fn sweeps_combine_values_and_link_keys() {
        let two = [
            "a.k1_Pa=500,*2",
            "b[media].mu_Pa+b[adventitia].mu_Pa=*0.8,1:2",
        ];
        let all = variants(&two, false, None).unwrap();
        assert_eq!(
            names(&all),
            [
                "-k1_Pa=500-mu_Pa=x0.8",
                "-k1_Pa=500-mu_Pa=1-2",
                "-k1_Pa=x2-mu_Pa=x0.8",
                "-k1_Pa=x2-mu_Pa=1-2"
            ]
        );
        assert_eq!(
            all[1].1,
            ["a.k1_Pa=500", "b[media].mu_Pa=1", "b[adventitia].mu_Pa=2"]
        );
        let alone = variants(&two, true, None).unwrap();
        assert_eq!(
            names(&alone),
            ["", "-k1_Pa=500", "-k1_Pa=x2", "-mu_Pa=x0.8", "-mu_Pa=1-2"]
        );
        let same_end = variants(&["m[a].k=1", "m[b].k=2"], false, None).unwrap();
        assert_eq!(names(&same_end), ["-m-a.k=1-m-b.k=2"]);
        // Commas within a list are no separators.
        let lists = variants(&["s[0].t=[1e-3, 2e-3],*2"], false, None).unwrap();
        assert_eq!(lists[0].1, ["s[0].t=[1e-3, 2e-3]"]);
        assert_eq!(lists.len(), 2);
        for (sweep, part) in [
            ("a=1,1", "twice"),
            ("a=1,,2", "missing between"),
            ("a", "expected KEY=VALUE"),
            ("a+=1", "a key is missing"),
            ("a+b=1:2:3", "3 values for 2 linked keys"),
        ] {
            let wrong = variants(&[sweep], false, None).unwrap_err();
            assert!(wrong.contains(part), "{wrong}");
        }
    }

    #[test]
    fn samples_are_rows_of_a_table() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("samples.csv");
        std::fs::write(
            &path,
            "name, a.k, b.m+c.m\nsoft, *0.5, 1\n, 2, *3\nstiff, , 4\n",
        )
        .unwrap();
        let found = variants(&[], false, Some(&path)).unwrap();
        assert_eq!(names(&found), ["-soft", "-002", "-stiff"]);
        assert_eq!(found[0].1, ["a.k=*0.5", "b.m=1", "c.m=1"]);
        assert_eq!(found[2].1, ["b.m=4", "c.m=4"]);
        for (text, part) in [
            ("name\nx\n", "expected a first line with keys"),
            ("a.k\n", "has no row"),
            ("name,a\nx,1\nx,2\n", "two rows are called x"),
            ("a,b\n1\n", "1 fields"),
        ] {
            std::fs::write(&path, text).unwrap();
            let wrong = variants(&[], false, Some(&path)).unwrap_err();
            assert!(wrong.contains(part), "{wrong}");
        }
    }
}
