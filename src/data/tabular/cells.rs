//! Cells of a line, and the numbers in them.

/// What stands between columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delimiter {
    Tab,
    Semicolon,
    Bar,
    Comma,
    Blanks,
}

impl Delimiter {
    /// In the order in which they are tried: a comma may be that of a decimal, and blanks may surround any other.
    pub const ALL: [Self; 5] = [
        Self::Tab,
        Self::Semicolon,
        Self::Bar,
        Self::Comma,
        Self::Blanks,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Tab => "tabs",
            Self::Semicolon => "semicolons",
            Self::Bar => "bars",
            Self::Comma => "commas",
            Self::Blanks => "blanks",
        }
    }

    pub fn byte(self) -> u8 {
        match self {
            Self::Tab => b'\t',
            Self::Semicolon => b';',
            Self::Bar => b'|',
            Self::Comma => b',',
            Self::Blanks => b' ',
        }
    }

    /// Cells of a line, without empty ones at its end.
    pub fn split(self, line: &str) -> Vec<String> {
        let mut cells: Vec<String> = match line.contains('"') {
            false if self == Self::Blanks => line.split_whitespace().map(str::to_owned).collect(),
            false => {
                let cells = line.split(char::from(self.byte()));
                cells.map(|cell| trim(cell).to_owned()).collect()
            }
            true => self.split_quoted(line),
        };
        while cells.last().is_some_and(String::is_empty) {
            cells.pop();
        }
        cells
    }

    fn split_quoted(self, line: &str) -> Vec<String> {
        let line = match self {
            Self::Blanks => one_blank(line),
            _ => line.to_owned(),
        };
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(self.byte())
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(line.as_bytes());
        let record = reader.records().next().and_then(Result::ok);
        let cells = record.unwrap_or_default();
        cells.iter().map(|cell| trim(cell).to_owned()).collect()
    }
}

/// With one blank for several, except in quotes.
fn one_blank(line: &str) -> String {
    let (mut out, mut is_quoted) = (String::new(), false);
    for c in line.trim().chars() {
        is_quoted ^= c == '"';
        match c.is_whitespace() && !is_quoted {
            true if out.ends_with(' ') => {}
            true => out.push(' '),
            false => out.push(c),
        }
    }
    out
}

pub fn trim(cell: &str) -> &str {
    cell.trim_matches(|c: char| c.is_whitespace() || c == '\u{feff}' || c == '\u{200b}')
}

/// A number with a decimal point, or with a comma if there may be some; also with Fortran's `D` and a typographic
/// minus.
pub fn number(cell: &str, has_commas: bool) -> Option<f64> {
    if let Ok(number) = cell.parse() {
        return Some(number);
    }
    let begins = cell.starts_with(|c: char| c.is_ascii_digit() || "+-.,\u{2212}".contains(c));
    if !begins {
        return None;
    }
    let mut plain = cell.replace('\u{2212}', "-").replace(['D', 'd'], "e");
    if has_commas && !plain.contains('.') {
        plain = plain.replacen(',', ".", 1);
    }
    plain.parse().ok()
}

/// What is wrong with a cell that is not a number.
pub fn no_number(cell: &str) -> String {
    let advice = match cell.contains('.') && cell.contains(',') {
        true => ": write no marks between thousands",
        false => "",
    };
    format!("expected a number, found {cell:?}{advice}")
}
