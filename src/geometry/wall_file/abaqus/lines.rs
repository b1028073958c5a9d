//! Lines of an input file and of those that it includes.

use crate::files::{Fault, fault, read_regular, text};
use std::path::Path;

/// Files that include each other, at most.
const DEPTH: usize = 10;

/// A line that is no comment.
pub struct Line {
    pub text: String,
    /// Where it stands: `line 3`, with the name of an included file.
    pub place: String,
}

/// All lines of a file, those of `*INCLUDE` and of data in files of their own in their places; a keyword that goes on
/// after a comma is one line.
pub fn read(path: &Path) -> Result<Vec<Line>, Fault> {
    let mut lines = Vec::new();
    add(path, "", 0, &mut lines)?;
    Ok(lines)
}

fn add(path: &Path, name: &str, depth: usize, lines: &mut Vec<Line>) -> Result<(), Fault> {
    let bytes = read_regular(path, super::super::MOST_BYTES)
        .map_err(|e| format!("it cannot be read: {e}"))?;
    let text = text::decode(&bytes)?;
    let mut is_open = false;
    for (number, line) in text::lines(&text) {
        let line = line.trim();
        if line.is_empty() || line.starts_with("**") {
            continue;
        }
        let place = format!("{name}line {number}");
        match lines.last_mut().filter(|_| is_open) {
            Some(keyword) => keyword.text += line,
            None => lines.push(Line {
                text: line.to_owned(),
                place: place.clone(),
            }),
        }
        let whole = lines
            .last()
            .map_or("", |line| line.text.as_str())
            .to_owned();
        is_open = whole.starts_with('*') && whole.ends_with(',');
        if is_open || !whole.starts_with('*') {
            continue;
        }
        // *INCLUDE, INPUT=file; *NODE, INPUT=file
        let (word, options) = keyword(&whole);
        let Some(input) = options
            .iter()
            .find(|(key, _)| key == "INPUT")
            .map(|(_, file)| file)
        else {
            continue;
        };
        if word == "INCLUDE" {
            lines.pop();
        }
        if depth == DEPTH {
            return Err(fault!(
                "{place}: more than {DEPTH} files include each other: is it a cycle?"
            ));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let name = format!("{input}, ");
        add(&folder.join(input), &name, depth + 1, lines).map_err(|e| {
            match e.message.starts_with("it cannot") {
                true => fault!("{place}: {input}: {e}"),
                false => e,
            }
        })?;
    }
    Ok(())
}

/// The word of a keyword in capitals, and its options; their names in capitals too.
pub fn keyword(line: &str) -> (String, Vec<(String, String)>) {
    let mut parts = line.trim_start_matches('*').split(',').map(str::trim);
    // Blanks within a keyword may be several.
    let word = parts
        .next()
        .unwrap_or_default()
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ");
    let options = parts.filter(|part| !part.is_empty()).map(|part| {
        let (key, value) = part.split_once('=').unwrap_or((part, ""));
        (
            key.trim().to_ascii_uppercase(),
            value.trim().trim_matches('"').to_owned(),
        )
    });
    (word.to_ascii_uppercase(), options.collect())
}
