//! All that is printed: to standard output by [`print()`], to standard error by [`note`].
//!
//! The reader may stop, and a disk may be full, at any moment: neither is a reason to panic. In a terminal, lines
//! are broken between words; elsewhere they are left as they are.

use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::os::fd::AsFd;

/// Columns where a terminal does not say how many it has.
const USUAL_COLUMNS: usize = 80;

/// Why standard output took no more.
#[derive(Debug, thiserror::Error)]
#[error("cannot write to standard output: {0}")]
pub struct PrintError(#[from] io::Error);

/// Prints to standard output. A reader that has had enough (`| head -1`) is no error.
///
/// # Errors
/// If the rest cannot be written, as on a full disk.
pub fn print(text: impl Display) -> Result<(), PrintError> {
    let mut out = io::stdout().lock();
    let written = write(&mut out, text).and_then(|()| out.flush());
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// Prints a line to standard error, if it is still open.
pub fn note(text: impl Display) {
    let _ = write(&mut io::stderr().lock(), format_args!("{text}\n"));
}

fn write(to: &mut (impl Write + IsTerminal + AsFd), text: impl Display) -> io::Result<()> {
    let text = text.to_string();
    match columns(to) {
        Some(columns) => to.write_all(wrapped(&text, columns).as_bytes()),
        None => to.write_all(text.as_bytes()),
    }
}

/// Columns of a terminal; `None` of anything else.
pub fn columns(of: &(impl IsTerminal + AsFd)) -> Option<usize> {
    if !of.is_terminal() {
        return None;
    }
    let size = rustix::termios::tcgetwinsize(of.as_fd());
    let columns = size.map_or(0, |size| usize::from(size.ws_col));
    Some(if columns > 0 { columns } else { USUAL_COLUMNS })
}

/// The text with every line that is longer than `columns` broken between words, but not before a unit or around an
/// equals sign if there is another place. What follows is indented as far as the text after the first gap of two
/// blanks.
fn wrapped(text: &str, columns: usize) -> String {
    let lines = text.split('\n').map(|line| broken(line, columns));
    lines.collect::<Vec<_>>().join("\n")
}

fn broken(line: &str, columns: usize) -> String {
    let letters: Vec<char> = line.chars().collect();
    let indent = hanging_indent(&letters, columns);
    let (mut pieces, mut rest, mut room) = (Vec::new(), &letters[..], columns);
    while rest.len() > room {
        let first_word = rest.iter().position(|c| *c != ' ').unwrap_or(rest.len());
        let blanks = || (first_word..=room).rev().filter(|i| rest[*i] == ' ');
        let Some(at) = (blanks().find(|i| !belongs_together(rest, *i))).or_else(|| blanks().next())
        else {
            break;
        };
        pieces.push(rest[..at].iter().collect::<String>());
        let next = rest[at..].iter().position(|c| *c != ' ');
        rest = next.map_or(&[], |n| &rest[at + n..]);
        room = columns - indent;
    }
    pieces.push(rest.iter().collect());
    pieces.join(&format!("\n{:indent$}", ""))
}

/// Whether the blank at `i` lies between a number and its unit or next to an equals sign.
fn belongs_together(letters: &[char], i: usize) -> bool {
    let neighbour = |at: Option<usize>| at.and_then(|at| letters.get(at)).copied().unwrap_or(' ');
    let (before, after) = (neighbour(i.checked_sub(1)), neighbour(i.checked_add(1)));
    before.is_ascii_digit() && after.is_alphabetic() || before == '=' || after == '='
}

fn hanging_indent(letters: &[char], columns: usize) -> usize {
    let margin = letters.iter().position(|c| *c != ' ').unwrap_or(0);
    let text = &letters[margin..];
    let gap = text.windows(2).position(|pair| pair == [' ', ' ']);
    let column = gap.and_then(|gap| {
        let after = text[gap..].iter().position(|c| *c != ' ')?;
        Some(margin + gap + after)
    });
    match column {
        Some(column) if 2 * column <= columns => column,
        _ => (margin + 4).min(columns / 2),
    }
}

#[cfg(test)]
mod tests {
    use super::wrapped;

    /// The next line starts below the text of the first.
    #[test]
    fn long_lines_are_broken_between_words() {
        let line =
            "Newton iterations    41 (0.31 s assembly, 0.12 s solution, 0.52 s in all, 38 MB)";
        assert_eq!(wrapped(line, 100), line);
        let narrow = "Newton iterations    41 (0.31 s assembly,\n                     0.12 s solution, 0.52 s\n                     in all, 38 MB)";
        assert_eq!(wrapped(line, 46), narrow);
        let osi = "artery OSI 0.00312 (at most 0.01234 at x = 0.0345 m, -163°)";
        assert_eq!(
            wrapped(osi, 45),
            "artery OSI 0.00312 (at most 0.01234 at\n    x = 0.0345 m, -163°)"
        );
    }

    #[test]
    fn no_line_is_too_long_and_no_word_is_lost_at_any_width() {
        let text =
            "a page of text:\n  with 12 words, 3.25e-7 m³/s and x = 1 m on a line\n\nand more\n";
        for columns in 14..80 {
            let found = wrapped(text, columns);
            assert!(found.lines().all(|line| line.chars().count() <= columns));
            let words = |text: &str| {
                let words = text.split_whitespace().map(str::to_owned);
                words.collect::<Vec<_>>()
            };
            assert_eq!(words(&found), words(text));
        }
        let word = "/a/path/that/cannot/be/broken/anywhere";
        assert_eq!(wrapped(word, 10), word);
    }
}
