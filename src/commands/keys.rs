//! `fsi-driver keys [WORD]`: the keys of a case.

use super::Failure;
use crate::analysis::solid_file::SolidFile;
use crate::case::Case;
use crate::case::defaults;
use crate::case::schema::{Key, ValueKind};
use crate::case::spelling;
use crate::output::terminal::print;
use std::fmt::Write as _;

/// Columns of a page, at most and where the terminal does not tell.
const WIDTH: usize = 80;
/// Up to so many keys are shown with what the defaults say of them.
const FEW: usize = 3;

/// What is asked for.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Only keys with this in their name or meaning, such as time, viscosity or iqn_ls.
    #[arg(value_name = "WORD")]
    word: Option<String>,
    /// The keys of the file of `fsi-driver solid` in place of those of case.toml.
    #[arg(long)]
    solid: bool,
    /// Everything as a JSON schema, by which editors complete and check the file.
    #[arg(long, conflicts_with = "word")]
    json_schema: bool,
}

/// Prints the keys, or the schema.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (schema, title) = match arguments.solid {
        true => (SolidFile::schema(), "tube of fsi-driver solid"),
        false => (Case::schema(), "case.toml of fsi-driver"),
    };
    if arguments.json_schema {
        return Ok(print(format_args!("{:#}\n", schema.to_json(title)))?);
    }
    let word = arguments.word.as_deref().unwrap_or_default();
    let found: Vec<&Key> = (schema.keys().iter())
        .filter(|key| speaks_of(key, &word.to_lowercase()))
        .collect();
    if found.is_empty() {
        let parts = schema
            .keys()
            .iter()
            .flat_map(|key| key.path.split(['.', '_']));
        let near = spelling::closest(word, parts.filter(|part| part.len() > 2));
        let near = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
        return Err(Failure::Input(format!(
            "no key has `{word}` in its name, its meaning or its words{near} (`fsi-driver keys` shows all)"
        )));
    }
    let remarks = found.len() <= FEW && !arguments.solid;
    let mut text = String::new();
    for key in found {
        describe(key, !arguments.solid, remarks, &mut text);
    }
    Ok(print(text)?)
}

/// Whether the key has `word` in its path, its meaning, or the words that it allows.
fn speaks_of(key: &Key, word: &str) -> bool {
    let words = match key.kind {
        ValueKind::Word(words) | ValueKind::PathOr(words) => words,
        _ => &[],
    };
    let choices = key.choices.iter().map(|choice| choice.word);
    let words = words.iter().map(|(word, _)| *word);
    let mut texts = [key.path.as_str(), key.about].into_iter();
    texts.any(|text| text.to_lowercase().contains(word))
        || words.chain(choices).any(|text| text.contains(word))
}

/// Path, default and origin in one line, meaning and range below.
fn describe(key: &Key, of_case: bool, remark: bool, text: &mut String) {
    let explained = defaults::explained().get(&key.path).filter(|_| of_case);
    let mut line = key.path.clone();
    if let Some(value) = explained.and_then(|explained| explained.value.as_ref()) {
        let _ = match value.as_array() {
            Some(rows) => write!(line, " = [{} rows]", rows.len()),
            None => write!(line, " = {value}"),
        };
    }
    let origin = explained.and_then(|explained| explained.origin);
    let origin = origin.map_or(String::new(), |origin| format!("[{origin}]"));
    let gap = WIDTH.saturating_sub(line.chars().count() + origin.len());
    let _ = match origin.is_empty() {
        true => writeln!(text, "{line}"),
        false => writeln!(text, "{line}{}{origin}", " ".repeat(gap.max(1))),
    };
    let mut about = key.about.to_owned();
    let (words, or_path) = match key.kind {
        ValueKind::Word(words) => (words, ""),
        ValueKind::PathOr(words) => (words, "a path in quotes, or "),
        kind => {
            let _ = write!(about, ": {kind}");
            (&[][..], "")
        }
    };
    if let Some(unit) = key.unit() {
        let _ = write!(about, " {unit}");
    }
    if !key.choices.is_empty() {
        let choices: Vec<_> = key.choices.iter().map(|choice| choice.word).collect();
        let _ = write!(about, "; of {}", choices.join(", "));
    }
    if let Some(absent) = key.absent {
        let _ = write!(about, "; absent: {absent}");
    }
    for only in &key.only {
        let _ = write!(about, "; read only {}", only.when);
    }
    if !words.is_empty() {
        let _ = write!(about, "; {or_path}one of");
    }
    wrap(&about, 4, 4, text);
    let widest = words.iter().map(|(word, _)| word.len()).max().unwrap_or(0);
    for (word, meaning) in words {
        let line = format!("{word:<widest$}  {meaning}");
        wrap(&line, 6, 8 + widest, text);
    }
    if let Some(explained) = explained.filter(|explained| remark && !explained.remark.is_empty()) {
        wrap(&format!("defaults.toml: {}", explained.remark), 4, 6, text);
    }
}

/// Appends a paragraph; its first line begins in column `first`, the others in column `next`.
fn wrap(paragraph: &str, first: usize, next: usize, text: &mut String) {
    let mut line = " ".repeat(first);
    let mut begun = false;
    // Blanks within a line stay as they are: they align the meanings of words.
    for (i, word) in paragraph.split(' ').enumerate() {
        let width = line.chars().count() + usize::from(i > 0) + word.chars().count();
        if begun && !word.is_empty() && width > WIDTH {
            let _ = writeln!(text, "{}", line.trim_end());
            line = " ".repeat(next);
        } else if i > 0 {
            line.push(' ');
        }
        line.push_str(word);
        begun = true;
    }
    let _ = writeln!(text, "{}", line.trim_end());
}
