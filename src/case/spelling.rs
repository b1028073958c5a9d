//! What may have been meant by a misspelt key or word.

/// The one of the known `paths` that was most likely meant by the unknown `path`: one spelt nearly the same, or the
/// same in another table.
pub fn suggest(path: &str, paths: &[String]) -> Option<String> {
    fn name(path: &str) -> &str {
        path.rsplit('.').next().unwrap_or_default()
    }
    let wanted = name(path);
    let near = paths
        .iter()
        .map(|known| (edit_distance(path, known), known))
        .min();
    let near = near
        .filter(|(distance, _)| *distance <= tolerance(wanted))
        .map(|(_, known)| known);
    near.or_else(|| paths.iter().find(|known| name(known) == wanted))
        .cloned()
}

/// The allowed word that `found` is most likely a misspelling of.
pub fn closest<'a>(found: &str, allowed: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let best = allowed
        .into_iter()
        .map(|word| (edit_distance(found, word), word))
        .min()?;
    (best.0 <= tolerance(found)).then_some(best.1)
}

/// Wrong letters with which a word is still recognized.
fn tolerance(word: &str) -> usize {
    1.max(word.chars().count() / 3)
}

/// Levenshtein's distance: how many letters must be inserted, removed or replaced.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
