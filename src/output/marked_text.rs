//! Places in a text that a program fills: between `<!-- table: WORDS -->` and `<!-- end of table -->`, each on a line
//! of its own, which pages of Markdown do not show.

const BEGIN: &str = "<!-- table:";
const CLOSE: &str = "-->";
const END: &str = "<!-- end of table -->";

/// Why a text cannot be filled.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum MarkedTextError<E> {
    /// A mark is wrong.
    #[error("line {line}: {reason}")]
    Mark {
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong and how it should be.
        reason: String,
    },
    /// There is nothing to put into a place.
    #[error("line {line}: {error}")]
    Content {
        /// Number of the line of its mark, from 1.
        line: usize,
        /// Why.
        error: E,
    },
}

/// The text with its places filled again: `content` answers to the words of a mark. How many there are stands next to
/// it.
///
/// # Errors
/// If a mark is not closed or ends nothing, or if there is no content for one.
pub fn fill<E>(
    text: &str,
    mut content: impl FnMut(&[&str]) -> Result<String, E>,
) -> Result<(String, usize), MarkedTextError<E>> {
    let mut filled = String::with_capacity(text.len());
    let mut count = 0;
    let mut open: Option<usize> = None;
    for (line, whole) in (1..).zip(text.split_inclusive('\n')) {
        let wrong = |reason: String| MarkedTextError::Mark { line, reason };
        let trimmed = whole.trim();
        if let Some(words) = trimmed.strip_prefix(BEGIN) {
            if let Some(before) = open {
                return Err(wrong(format!(
                    "the table that begins in line {before} has no end before this one: `{END}` on a line of its own ends it"
                )));
            }
            let words = words
                .strip_suffix(CLOSE)
                .ok_or_else(|| wrong(format!("the mark has to end with `{CLOSE}`")))?;
            let words: Vec<&str> = words.split_whitespace().collect();
            let inside =
                content(&words).map_err(|error| MarkedTextError::Content { line, error })?;
            filled += whole;
            filled += &inside;
            (open, count) = (Some(line), count + 1);
        } else if trimmed == END {
            if open.take().is_none() {
                return Err(wrong(format!("`{END}` ends no table")));
            }
            filled += whole;
        } else if open.is_none() {
            filled += whole;
        }
    }
    match open {
        None => Ok((filled, count)),
        Some(line) => Err(MarkedTextError::Mark {
            line,
            reason: format!("the table has no end: `{END}` on a line of its own ends it"),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn doubled(text: &str) -> Result<(String, usize), MarkedTextError<String>> {
        fill(text, |words| match words {
            ["none"] => Err("nothing there".into()),
            words => Ok(format!("{0} {0}\n", words.join("+"))),
        })
    }

    #[test]
    fn only_text_between_the_marks_is_replaced() {
        let text = "a\n<!-- table: x y -->\nold\nolder\n<!-- end of table -->\nb\n";
        let filled = "a\n<!-- table: x y -->\nx+y x+y\n<!-- end of table -->\nb\n";
        assert_eq!(doubled(text), Ok((filled.into(), 1)));
        assert_eq!(doubled(filled), Ok((filled.into(), 1)));
        assert_eq!(doubled("no mark"), Ok(("no mark".into(), 0)));
    }

    #[test]
    fn wrong_marks_are_named_with_their_line() {
        let reason = |text| doubled(text).unwrap_err().to_string();
        assert!(reason("a\n<!-- table: x -->\n").starts_with("line 2: the table has no end"));
        assert!(
            reason("<!-- end of table -->").starts_with("line 1: `<!-- end of table -->` ends no")
        );
        assert!(reason("<!-- table: x\n").starts_with("line 1: the mark has to end"));
        let nested = "<!-- table: x -->\n<!-- table: y -->\n<!-- end of table -->\n";
        assert!(reason(nested).starts_with("line 2: the table that begins in line 1"));
        let empty = "<!-- table: none -->\n<!-- end of table -->\n";
        assert_eq!(reason(empty), "line 1: nothing there");
    }
}
