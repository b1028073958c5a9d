//! Names and units of the columns of a table, from the lines above its rows.

use super::cells::{Delimiter, no_number, number};
use super::units::Unit;
use super::{Column, Fault, Row};

/// What the lines above the rows say.
pub struct Heading {
    pub columns: Vec<Column>,
    /// The line of names.
    pub header: Option<(usize, String)>,
    /// Comments and titles.
    pub notes: Vec<String>,
}

/// The columns of rows with `count` cells, from the lines `above` them (cells and texts), or else from `comments`.
pub fn find<'a>(
    above: &[Row],
    texts: impl Iterator<Item = &'a str>,
    comments: &[(usize, &str)],
    count: usize,
    delimiter: Delimiter,
    is_header: &dyn Fn(&[String]) -> bool,
) -> Result<Heading, Fault> {
    let above: Vec<(usize, &str)> = above.iter().map(|row| row.line).zip(texts).collect();
    let notes = || {
        let notes = comments.iter().chain(&above);
        notes.map(|(_, text)| (*text).to_owned()).collect()
    };
    let given = |(line, text): (usize, &str), cells, units: Option<Vec<String>>| Heading {
        columns: columns(cells, units),
        header: Some((line, text.to_owned())),
        notes: notes(),
    };
    let fits = |text: &str| match count {
        0 => Some(delimiter.split(text)).filter(|cells| !cells.is_empty()),
        _ => cells(text, count, delimiter),
    };
    refuse_rows(&above, delimiter)?;
    // The last lines above the rows, a line of units perhaps after that of names.
    if let Some((last, before)) = above.split_last() {
        let found = fits(last.1);
        if let (Some(units), Some(names)) = (found.clone().filter(|c| are_units(c)), before.last())
            && let Some(names_found) = fits(names.1)
        {
            return Ok(given(*names, names_found, Some(units)));
        }
        if let Some(cells) = found {
            return Ok(given(*last, cells, None));
        }
        let found = delimiter.split(last.1).len();
        if found > 1 {
            let expected = format!("expected names of {count} columns, as many as the rows have");
            let reason = format!("{expected}, found {found}: {:?}", last.1);
            return Err(Fault::at(last.0, reason));
        }
    }
    // In comments, if the names are known.
    let mut units = None;
    for &(line, text) in comments
        .iter()
        .rev()
        .filter(|(_, text)| !text.trim().is_empty())
        .take(4)
    {
        let Some(cells) = cells(text, count, delimiter) else {
            continue;
        };
        if are_units(&cells) {
            units = units.or(Some(cells));
        } else if is_header(&cells) {
            return Ok(given((line, text), cells, units));
        }
    }
    Ok(Heading {
        columns: columns(vec![String::new(); count], units),
        header: None,
        notes: notes(),
    })
}

/// A row with a mistake is no line of names.
fn refuse_rows(above: &[(usize, &str)], delimiter: Delimiter) -> Result<(), Fault> {
    for (i, (line, text)) in above.iter().rev().take(2).enumerate() {
        let cells = delimiter.split(text);
        let is_number = |cell: &&String| number(cell, true).is_some();
        if cells.len() > 1
            && (is_number(&&cells[0]) || i == 0 && cells.iter().any(|cell| is_number(&cell)))
            && let Some(odd) = cells
                .iter()
                .find(|cell| !is_number(cell) && !cell.is_empty())
        {
            return Err(Fault::at(*line, no_number(odd)));
        }
    }
    Ok(())
}

fn columns(names: Vec<String>, units: Option<Vec<String>>) -> Vec<Column> {
    let units = units.unwrap_or_default();
    let unit = |i: usize| units.get(i).cloned();
    let columns = names.into_iter().enumerate();
    columns
        .map(|(i, name)| Column {
            name,
            unit: unit(i),
        })
        .collect()
}

/// Cells of a line of names for so many columns, whatever separates them.
fn cells(text: &str, count: usize, delimiter: Delimiter) -> Option<Vec<String>> {
    let others = Delimiter::ALL
        .into_iter()
        .filter(|other| *other != delimiter);
    for delimiter in std::iter::once(delimiter).chain(others) {
        let mut cells = delimiter.split(text);
        if delimiter == Delimiter::Blanks && cells.len() != count {
            cells = joined(&cells);
        }
        // R leaves out the name of the column with the numbers of the rows.
        if cells.len() + 1 == count && count > 2 && text.contains('"') {
            cells.insert(0, String::new());
        }
        if cells.len() == count {
            return Some(cells);
        }
        // Names of the first columns only, the others without.
        if delimiter == Delimiter::Comma
            && cells.len() > 1
            && cells.len() < count
            && text.trim_end().ends_with(',')
        {
            cells.resize(count, String::new());
            return Some(cells);
        }
    }
    None
}

/// Words with the units in brackets that follow them: `time (s)` is one name.
fn joined(words: &[String]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let open = |name: &str| {
        let count = |marks: [char; 2]| name.matches(marks).count();
        count(['(', '[']) > count([')', ']'])
    };
    for word in words {
        match names.last_mut() {
            Some(last) if word.starts_with(['(', '[']) || open(last) => {
                last.push(' ');
                last.push_str(word);
            }
            _ => names.push(word.clone()),
        }
    }
    names
}

/// Whether all cells are units, as in the second line of a header.
fn are_units(cells: &[String]) -> bool {
    let is_unit = |cell: &String| {
        let bare = cell.trim_matches(['(', ')', '[', ']', ' ']);
        Unit::parse(cell).is_some() || ["", "-", "–", "1", "none"].contains(&bare)
    };
    cells.iter().all(is_unit) && cells.iter().any(|cell| Unit::parse(cell).is_some())
}
