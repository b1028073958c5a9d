//! What may have been meant by a misspelt key or word.

use super::error::CaseError;
use super::source::CaseValue;
use strsim::levenshtein;

/// After so many mistakes nobody looks for what may have been meant by another unknown key.
const PATIENCE: usize = 20;
/// Most keys that are suggested at once.
const MOST_KEYS: usize = 4;
/// Longer names are nobody's misspelling.
const LONGEST: usize = 100;

/// Reports a key that no file has; `known` are the paths that it might be a misspelling of.
pub fn unknown_key(
    entry: CaseValue,
    known: impl FnOnce(&str) -> Vec<String>,
    errors: &mut Vec<CaseError>,
) {
    let suggestions = match errors.len() < PATIENCE {
        true => suggest(&entry.key, &known(&entry.key)),
        false => Vec::new(),
    };
    errors.push(CaseError::UnknownKey {
        place: entry.place,
        key: entry.key,
        suggestions,
    });
}

/// Those of the known `paths` that were most likely meant by the unknown `path`: the one spelt nearly the same; or
/// else those of the same name in other tables; or else those in the same table that are named more precisely, such as
/// `geometry.graft_length_m` for `geometry.length_m`; or else those that are called as its table, such as
/// `output.probes_m` for `output.probe[0].point_m`.
pub fn suggest(path: &str, paths: &[String]) -> Vec<String> {
    fn split(path: &str) -> (&str, &str) {
        path.rsplit_once('.').unwrap_or(("", path))
    }
    if path.len() > LONGEST {
        return Vec::new();
    }
    let (table, wanted) = split(path);
    let near = paths.iter().map(|known| (levenshtein(path, known), known));
    if let Some((_, known)) = near.min().filter(|(d, _)| *d <= tolerance(wanted)) {
        return vec![known.clone()];
    }
    let alike = |fits: &dyn Fn(&str, &str) -> bool| -> Vec<String> {
        let found = paths.iter().filter(|known| {
            let (table, name) = split(known);
            fits(table, name)
        });
        found.take(MOST_KEYS).cloned().collect()
    };
    let same = alike(&|_, name| name == wanted);
    if !same.is_empty() {
        return same;
    }
    let words: Vec<&str> = wanted.split('_').collect();
    let found = alike(&|known, name| {
        known == table && words.iter().all(|word| name.split('_').any(|w| w == *word))
    });
    // In place of a table that there is not.
    let (above, list) = split(table.split('[').next().unwrap_or_default());
    let is_near = |word: &str| !list.is_empty() && levenshtein(word, list) <= 1;
    match found.is_empty() {
        true => alike(&|known, name| known == above && name.split('_').any(is_near)),
        false => found,
    }
}

/// The allowed word that `found` is most likely a misspelling of.
pub fn closest<'a>(found: &str, allowed: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if found.len() > LONGEST {
        return None;
    }
    let best = allowed
        .into_iter()
        .map(|word| (levenshtein(found, word), word))
        .min()?;
    (best.0 <= tolerance(found)).then_some(best.1)
}

/// Wrong letters with which a word is still recognized.
fn tolerance(word: &str) -> usize {
    1.max(word.chars().count() / 3)
}
