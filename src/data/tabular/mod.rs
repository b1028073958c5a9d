//! Tables of numbers as other programs and people write them.
//!
//! Columns are separated by tabs, semicolons, bars, commas or blanks; decimals by points or commas. Before the rows
//! there may be comments, titles, a line of names, a line of units and a line of counts. [`Sheet::read`] finds out
//! which of these a file has; what its columns mean is for those to say who asked for it.

mod cells;
mod header;
mod sniff;
pub mod units;

pub use crate::files::Fault;
use crate::files::{read_regular, text};
use cells::{Delimiter, no_number, number};
use std::path::Path;
use units::{Dimension, ForeignUnit, Unit};

/// Far larger than anything that people measure.
const MOST_BYTES: u64 = 64 << 20;
/// More rows than any measured curve has.
const MOST_ROWS: usize = 1_000_000;

/// A table.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// Columns, from left to right.
    pub columns: Vec<Column>,
    /// Rows, each with as many cells as there are columns.
    pub rows: Vec<Row>,
    /// Comments and titles before the rows.
    pub notes: Vec<String>,
    /// The line with the names of the columns, if there is one.
    pub header: Option<(usize, String)>,
    delimiter: Delimiter,
    has_decimal_commas: bool,
}

/// What the header says of a column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Column {
    /// Its name, with the unit if it is given; empty without a header.
    pub name: String,
    /// Its unit, if that stands in a line of units.
    unit: Option<String>,
}

/// Cells of a line.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The line, counted from 1.
    pub line: usize,
    /// Its cells.
    pub cells: Vec<String>,
}

impl Sheet {
    /// Reads a table whose rows have `least` numbers or more. A comment counts as the line of names only if `is_header`
    /// knows the names in it.
    ///
    /// # Errors
    /// What is wrong, with the line.
    pub fn read(
        path: &Path,
        least: usize,
        is_header: impl Fn(&[String]) -> bool,
    ) -> Result<Self, Fault> {
        let bytes = read_regular(path, MOST_BYTES).map_err(|e| Fault::whole(e.to_string()))?;
        let text = text::decode(&bytes).map_err(Fault::whole)?;
        Self::parse(&text, least, is_header)
    }

    /// As [`Sheet::read`], of a text.
    ///
    /// # Errors
    /// As there.
    pub fn parse(
        text: &str,
        least: usize,
        is_header: impl Fn(&[String]) -> bool,
    ) -> Result<Self, Fault> {
        sniff::parse(text, least, &is_header)
    }

    /// A table of words and numbers whose first line names its columns, `first` among them; in numbers there are points
    /// instead of commas.
    ///
    /// # Errors
    /// What is wrong, with the line.
    pub fn of_words(path: &Path, first: &str) -> Result<Self, Fault> {
        let bytes = read_regular(path, MOST_BYTES).map_err(|e| Fault::whole(e.to_string()))?;
        let text = text::decode(&bytes).map_err(Fault::whole)?;
        sniff::parse_words(&text, first)
    }

    /// The number in a cell.
    ///
    /// # Errors
    /// If there is none, or one that is not finite.
    pub fn number(&self, row: &Row, column: usize) -> Result<f64, Fault> {
        let cell = row.cells.get(column).map_or("", String::as_str);
        match number(cell, self.has_decimal_commas) {
            Some(number) if number.is_finite() => Ok(number),
            _ => Err(Fault::at(
                row.line,
                match cell {
                    "" => format!("expected a number in column {}, found none", column + 1),
                    _ => no_number(cell),
                },
            )),
        }
    }

    /// The unit of a column: from a line of units, or from its name.
    ///
    /// # Errors
    /// The text, if it is not a unit of this dimension.
    pub fn unit(&self, column: usize, wanted: Dimension) -> Result<Option<Unit>, ForeignUnit> {
        let Some(Column { name, unit }) = self.columns.get(column) else {
            return Ok(None);
        };
        match unit.as_deref().filter(|unit| !unit.trim().is_empty()) {
            None => Unit::of_name(name, wanted),
            Some(text) => match Unit::parse(text).filter(|unit| unit.dimension == wanted) {
                Some(unit) => Ok(Some(unit)),
                None => Err(ForeignUnit {
                    text: text.to_owned(),
                    wanted,
                }),
            },
        }
    }

    /// The only unit of this dimension that the comments and titles name.
    pub fn noted_unit(&self, wanted: Dimension) -> Option<Unit> {
        let mut units = (self.notes.iter()).filter_map(|note| Unit::within(note, wanted));
        let first = units.next()?;
        units.all(|unit| unit.is(&first)).then_some(first)
    }

    /// What the file looks like, as `21 rows, columns separated by tabs, decimal commas`.
    pub fn shape(&self) -> String {
        format!(
            "{} rows, columns separated by {}{}",
            self.rows.len(),
            self.delimiter.name(),
            match self.has_decimal_commas {
                true => ", decimal commas",
                false => "",
            }
        )
    }

    /// The names of columns, or their numbers, for messages.
    pub fn listed(&self, columns: impl IntoIterator<Item = usize>) -> String {
        let names = columns.into_iter().map(|i| {
            match self.columns.get(i).map_or("", |column| &column.name) {
                "" => format!("column {}", i + 1),
                name => format!("{name:?}"),
            }
        });
        names.collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests;
