//! Which marks separate columns and decimals, and where the rows begin.

use super::cells::{Delimiter, number, trim};
use super::header::{self, Heading};
use super::{Column, Fault, MOST_ROWS, Row, Sheet};
use crate::files::text::lines;

/// A line that is neither blank nor a comment.
type Line<'a> = (usize, &'a str);

/// Lines with content, comments, and the delimiter that a spreadsheet has noted.
fn sorted(text: &str) -> (Vec<Line<'_>>, Vec<Line<'_>>, Option<Delimiter>) {
    let (mut body, mut comments, mut noted) = (Vec::new(), Vec::new(), None);
    for (number, line) in lines(text) {
        let line = trim(line);
        let is_comment = |line: &str| line.starts_with(['#', '%', '!']) || line.starts_with("//");
        if line.is_empty() || line.chars().all(|c| ",;\t \"".contains(c)) {
            continue;
        }
        let bare = line.trim_matches('"');
        if let Some(mark) = bare.strip_prefix("sep=")
            && body.is_empty()
        {
            let mark = mark.bytes().next();
            noted = Delimiter::ALL.into_iter().find(|d| Some(d.byte()) == mark);
        } else if is_comment(line) || is_comment(bare) {
            comments.push((
                number,
                line.trim_matches(|c: char| c == '"' || "#%!/".contains(c)),
            ));
        } else {
            body.push((number, line));
        }
    }
    (body, comments, noted)
}

/// The delimiter with which most lines are rows of numbers, and all of their cells are there.
fn delimiter(body: &[Line<'_>], least: usize) -> Option<Delimiter> {
    const LOOKED_AT: usize = 2000;
    let score = |delimiter: Delimiter| {
        let rows = body.iter().take(LOOKED_AT).filter_map(|(_, line)| {
            let cells = delimiter.split(line);
            let has_commas = delimiter != Delimiter::Comma || line.contains('"');
            let numbers = cells
                .iter()
                .filter(|cell| number(cell, has_commas).is_some())
                .count();
            let empty = cells.iter().filter(|cell| cell.is_empty()).count();
            match numbers >= least {
                true if numbers == cells.len() => Some(100),
                true if numbers + empty == cells.len() => Some(10),
                true => Some(1),
                false => None,
            }
        });
        rows.sum::<usize>()
    };
    let scores = Delimiter::ALL.map(|delimiter| (delimiter, score(delimiter)));
    let most = scores.iter().map(|(_, score)| *score).max().unwrap_or(0);
    let best = scores.iter().find(|(_, score)| *score == most && most > 0);
    best.map(|(delimiter, _)| *delimiter)
}

pub fn parse(
    text: &str,
    least: usize,
    is_header: &dyn Fn(&[String]) -> bool,
) -> Result<Sheet, Fault> {
    let (body, comments, noted) = sorted(text);
    let delimiter = noted
        .or_else(|| (1..=least).rev().find_map(|least| delimiter(&body, least)))
        .unwrap_or(Delimiter::Comma);
    let split: Vec<Row> = (body.iter())
        .map(|&(line, text)| Row {
            line,
            cells: delimiter.split(text),
        })
        .collect();
    let may_have_commas = delimiter != Delimiter::Comma || text.contains('"');
    let start = first_row(&split, least, may_have_commas);
    let (above, rows) = split.split_at(start);
    let rows = without_counts(rows, least)?;
    // As many columns as the first row has, or as have names if no row has more.
    let first = rows.first().map_or(0, |row| row.cells.len());
    let widest = rows.iter().map(|row| row.cells.len()).max().unwrap_or(0);
    let named = above.last().map_or(0, |row| row.cells.len());
    let first = if (first..=named).contains(&widest) {
        named
    } else {
        first
    };
    let has_decimal_commas = decimals(rows, may_have_commas)?;
    let texts = body[..start].iter().map(|(_, text)| *text);
    let Heading {
        columns,
        header,
        notes,
    } = header::find(above, texts, &comments, first, delimiter, is_header)?;
    let count = columns.len();
    let fits = |row: &Row| (least.min(count)..=count).contains(&row.cells.len());
    if let Some(row) = rows.iter().find(|row| !fits(row)) {
        let reason = format!("expected {count} numbers, found {}", row.cells.len());
        return Err(Fault::at(row.line, reason));
    }
    if let Some(row) = rows.get(MOST_ROWS) {
        let reason = format!("more than {MOST_ROWS} rows: this cannot be the right file");
        return Err(Fault::at(row.line, reason));
    }
    Ok(Sheet {
        columns,
        rows: rows.to_vec(),
        notes,
        header,
        delimiter,
        has_decimal_commas,
    })
}

/// The first row of numbers, after titles and names.
fn first_row(rows: &[Row], least: usize, may_have_commas: bool) -> usize {
    let numbers = |row: &Row| {
        let numbers = row
            .cells
            .iter()
            .filter(|cell| number(cell, may_have_commas).is_some());
        numbers.count()
    };
    let begins = |row: &Row| {
        let numbers = numbers(row);
        numbers >= least || numbers > 0 && numbers == row.cells.len()
    };
    let mut start = rows.iter().position(begins).unwrap_or(rows.len());
    // A line of counts may stand above the names.
    if let Some(pair) = rows.get(start..start + 2)
        && pair[0].cells.len() < least
        && !begins(&pair[1])
        && let Some(next) = rows[start + 1..].iter().position(begins)
    {
        start += 1 + next;
    }
    start
}

/// Rows without a line of counts before them: their number, which SimVascular lets that of Fourier modes follow.
fn without_counts(rows: &[Row], least: usize) -> Result<&[Row], Fault> {
    let [first, rest @ ..] = rows else {
        return Ok(rows);
    };
    let whole = |cell: &String| cell.parse::<usize>().ok();
    let counts: Option<Vec<usize>> = first.cells.iter().map(whole).collect();
    let (Some(counts), Some(second)) = (counts, rest.first()) else {
        return Ok(rows);
    };
    let next = second.cells.first().and_then(|cell| number(cell, true));
    let is_count = match counts[..] {
        [_] => second.cells.len() >= least && least > 1,
        // Times would increase.
        [n, _] => {
            n > 1
                && (least > 2 && second.cells.len() > 2 || next.is_some_and(|next| next < n as f64))
        }
        _ => false,
    };
    match counts.first() {
        Some(&n) if is_count && n == rest.len() => Ok(rest),
        Some(&n) if is_count => Err(Fault::at(
            first.line,
            format!(
                "this line seems to count the rows, {n}, but {} follow: the file is cut off, or this is not a line of counts",
                rest.len()
            ),
        )),
        _ => Ok(rows),
    }
}

/// Whether decimals have commas.
fn decimals(rows: &[Row], may_have_commas: bool) -> Result<bool, Fault> {
    let has = |mark: char| {
        rows.iter().find(|row| {
            let mut cells = row
                .cells
                .iter()
                .filter(|cell| cell.matches(mark).count() == 1);
            cells.any(|cell| number(&cell.replace([',', '.'], ""), false).is_some())
        })
    };
    match (has(',').filter(|_| may_have_commas), has('.')) {
        (Some(comma), Some(point)) => Err(Fault::at(
            comma.line.max(point.line),
            format!(
                "line {} has a comma within a number and line {} a point: write decimals alike, and no marks between thousands",
                comma.line, point.line
            ),
        )),
        (comma, _) => Ok(comma.is_some()),
    }
}

/// A table of words and numbers, whose first line has the column `first`.
pub fn parse_words(text: &str, first: &str) -> Result<Sheet, Fault> {
    let (body, ..) = sorted(text);
    let Some(((line, names), rows)) = body.split_first() else {
        return Err(Fault::whole("the file has no line of names"));
    };
    let has = |delimiter: &Delimiter| delimiter.split(names).iter().any(|name| name == first);
    let delimiter = Delimiter::ALL.into_iter().find(has);
    let delimiter = delimiter.unwrap_or(Delimiter::Comma);
    let columns: Vec<Column> = (delimiter.split(names).into_iter())
        .map(|name| Column { name, unit: None })
        .collect();
    let has_decimal_commas = delimiter != Delimiter::Comma;
    let mut all = Vec::new();
    for &(line, row) in rows {
        let mut cells = delimiter.split(row);
        if cells.len() > columns.len() {
            return Err(Fault::at(
                line,
                format!("expected {} fields, found {}", columns.len(), cells.len()),
            ));
        }
        cells.resize(columns.len(), String::new());
        for cell in &mut cells {
            if let Some(number) = number(cell, has_decimal_commas) {
                *cell = number.to_string();
            }
        }
        all.push(Row { line, cells });
    }
    Ok(Sheet {
        columns,
        rows: all,
        notes: Vec::new(),
        header: Some((*line, (*names).to_owned())),
        delimiter,
        has_decimal_commas,
    })
}
