//! A table of plain text, as HTML, as CSV, or in Markdown.

use super::page;
use std::path::Path;

/// Heads and rows of cells.
#[derive(Debug, Clone, PartialEq)]
pub struct PageTable {
    heads: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl PageTable {
    /// A table without rows.
    pub fn new<T: Into<String>>(heads: impl IntoIterator<Item = T>) -> Self {
        Self {
            heads: heads.into_iter().map(Into::into).collect(),
            rows: Vec::new(),
        }
    }

    /// One that was stored; none if there is none.
    pub fn stored(path: &Path) -> Option<Self> {
        let mut reader = csv::Reader::from_path(path).ok()?;
        let cells = |row: &csv::StringRecord| row.iter().map(str::to_owned).collect();
        let heads = cells(reader.headers().ok()?);
        let rows: Result<Vec<_>, _> = reader.records().collect();
        let rows = rows.ok()?.iter().map(cells).collect();
        Some(Self { heads, rows })
    }

    /// Adds a row.
    ///
    /// # Panics
    /// If it has not a cell for each head.
    pub fn push(&mut self, row: Vec<String>) {
        assert_eq!(row.len(), self.heads.len(), "a cell for each head");
        self.rows.push(row);
    }

    /// Its columns as rows: many figures of few runs.
    pub fn transposed(&self) -> Self {
        let (heads, rows) = transposed(self.heads.clone(), self.rows.clone());
        Self { heads, rows }
    }

    /// For a page.
    pub fn to_html(&self) -> String {
        let heads: Vec<String> = self.heads.iter().map(|h| page::escape(h)).collect();
        let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
        let escaped = |row: &Vec<String>| row.iter().map(|cell| page::escape(cell)).collect();
        let rows: Vec<Vec<String>> = self.rows.iter().map(escaped).collect();
        page::table(&heads, &rows)
    }

    /// Comma-separated, each cell in quotes that is not a number.
    pub fn to_csv(&self) -> String {
        let line = |cells: &Vec<String>| {
            let quoted = cells.iter().map(|cell| match cell.parse::<f64>() {
                Ok(number) if number.is_finite() => cell.clone(),
                _ => format!("\"{}\"", cell.replace('"', "\"\"")),
            });
            quoted.collect::<Vec<_>>().join(",") + "\n"
        };
        std::iter::once(&self.heads)
            .chain(&self.rows)
            .map(line)
            .collect()
    }

    /// For a page of Markdown.
    pub fn to_markdown(&self) -> String {
        let line = |cells: &Vec<String>| {
            let escaped: Vec<String> = cells.iter().map(|c| c.replace('|', "\\|")).collect();
            format!("| {} |\n", escaped.join(" | "))
        };
        let rule = vec!["---".to_owned(); self.heads.len()];
        [&self.heads, &rule]
            .into_iter()
            .chain(&self.rows)
            .map(line)
            .collect()
    }
}

/// Columns as rows: the heads of the rows become those of the columns.
pub fn transposed(heads: Vec<String>, rows: Vec<Vec<String>>) -> (Vec<String>, Vec<Vec<String>>) {
    let mut rows: Vec<_> = rows.into_iter().map(Vec::into_iter).collect();
    let mut columns = heads.into_iter().map(|head| {
        let cells = rows.iter_mut().filter_map(Iterator::next);
        std::iter::once(head).chain(cells).collect()
    });
    let heads = columns.next().unwrap_or_default();
    (heads, columns.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transposed_table_has_its_heads_in_the_first_column() {
        let mut table = PageTable::new(["case", "a", "b"]);
        table.push(["S", "1", "2"].map(str::to_owned).to_vec());
        table.push(["H", "3", "4"].map(str::to_owned).to_vec());
        let markdown = table.transposed().to_markdown();
        assert_eq!(
            markdown,
            "| case | S | H |\n| --- | --- | --- |\n| a | 1 | 3 |\n| b | 2 | 4 |\n"
        );
        assert_eq!(table.transposed().transposed(), table);
    }

    #[test]
    fn what_would_end_a_cell_is_escaped() {
        let mut table = PageTable::new(["a|b", "\"c\""]);
        table.push(vec!["1 < 2".into(), "x|y".into()]);
        assert_eq!(
            table.to_markdown(),
            "| a\\|b | \"c\" |\n| --- | --- |\n| 1 < 2 | x\\|y |\n"
        );
        assert_eq!(table.to_csv(), "\"a|b\",\"\"\"c\"\"\"\n\"1 < 2\",\"x|y\"\n");
        assert!(table.to_html().contains("1 &lt; 2"));
    }
}
