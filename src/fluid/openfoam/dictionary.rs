//! OpenFOAM's dictionaries, read as far as one must to know that OpenFOAM can read them.
//!
//! Braces, brackets and semicolons must be in order. Macros and directives other than `#include` are not followed: what
//! holds one may have any entry.

use super::names::{FIELDS, INITIAL_VELOCITY, included};
use regex_lite::Regex;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Files that include each other, at most.
const MAX_DEPTH: usize = 10;
/// Dictionaries within each other, at most.
const MAX_NESTING: usize = 100;
/// Larger files are fields of another mesh.
const MOST_BYTES: u64 = 16 << 20;
/// Files that are written when a run begins.
const GENERATED: [&str; 3] = [
    "system/fsiParameters",
    "system/fsiConnection",
    "system/fsiProbes",
];

/// What keeps OpenFOAM from reading a file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}:{line}: {message}", .path.display())]
pub struct DictionaryError {
    /// The file.
    pub path: PathBuf,
    /// The line, counted from 1.
    pub line: usize,
    /// What is wrong.
    pub message: String,
}

/// Why a file is not included that lies somewhere else.
const OUTSIDE: &str =
    "which lies outside the case: a run keeps a copy of the case, so copy it into the case";

impl DictionaryError {
    /// Whether a file is included that the copy of the case will not have.
    pub fn leaves_the_case(&self) -> bool {
        self.message.ends_with(OUTSIDE)
    }
}

/// What a keyword stands for.
#[derive(Debug, Clone, PartialEq)]
pub enum Entry {
    /// Entries of its own.
    Dictionary(Dictionary),
    /// Words up to a semicolon, without brackets.
    Words(Vec<String>),
}

/// Entries in the order of the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Dictionary {
    entries: Vec<(String, Entry)>,
    /// Whether a keyword is a pattern, in quotes.
    has_patterns: bool,
    /// Whether it may have entries that are not seen here.
    is_open: bool,
    /// Whether it includes what is written of the openings of a vessel.
    has_openings: bool,
}

impl Dictionary {
    /// Reads a file of the case, or of the templates of a case, in the folder `case`.
    ///
    /// # Errors
    /// The first mistake.
    pub fn read(case: &Path, file: &Path) -> Result<Self, DictionaryError> {
        let mut root = Self::default();
        read_into(case, &case.join(file), 0, &mut root)?;
        Ok(root)
    }

    /// The entry of a keyword.
    pub fn get(&self, keyword: &str) -> Option<&Entry> {
        let mut entries = self.entries.iter();
        let named = entries.find(|(name, _)| name == keyword);
        named.map(|(_, entry)| entry)
    }

    /// The entry that holds for a keyword: that of its name, or else of the last pattern that it matches.
    pub fn matching(&self, keyword: &str) -> Option<&Entry> {
        self.get(keyword).or_else(|| {
            let pattern = |text: &str| Regex::new(&format!("^(?:{text})$")).ok();
            let mut entries = self.entries.iter().rev().filter(|_| self.has_patterns);
            let entry =
                entries.find(|(text, _)| pattern(text).is_some_and(|p| p.is_match(keyword)));
            entry.map(|(_, entry)| entry)
        })
    }

    /// The dictionary of a keyword.
    pub fn dictionary(&self, keyword: &str) -> Option<&Dictionary> {
        match self.get(keyword)? {
            Entry::Dictionary(dictionary) => Some(dictionary),
            Entry::Words(_) => None,
        }
    }

    /// The first word of a keyword.
    pub fn word(&self, keyword: &str) -> Option<&str> {
        match self.get(keyword)? {
            Entry::Words(words) => words.first().map(String::as_str),
            Entry::Dictionary(_) => None,
        }
    }

    /// All words of a keyword; none if there are none.
    pub fn words(&self, keyword: &str) -> &[String] {
        match self.get(keyword) {
            Some(Entry::Words(words)) => words,
            _ => &[],
        }
    }

    /// The keywords in their order.
    pub fn keywords(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|(name, _)| name.as_str())
    }

    /// The dictionaries among the entries.
    pub fn dictionaries(&self) -> impl Iterator<Item = &Dictionary> {
        self.entries.iter().filter_map(|(_, entry)| match entry {
            Entry::Dictionary(dictionary) => Some(dictionary),
            Entry::Words(_) => None,
        })
    }

    /// Whether there may be an entry for this keyword: there is, or a pattern in quotes or a macro may stand for it.
    pub fn may_have(&self, keyword: &str) -> bool {
        self.is_open || self.has_patterns || self.get(keyword).is_some()
    }

    /// Whether it includes what is written of the openings of a vessel when a run begins.
    pub fn has_openings(&self) -> bool {
        self.has_openings
    }

    /// Adds an entry: a dictionary to the one of that name, if there is one.
    fn add(&mut self, keyword: String, entry: Entry) {
        let named = self.entries.iter_mut().rev();
        let mut named = named.filter(|(name, _)| *name == keyword);
        match (named.next(), entry) {
            (Some((_, Entry::Dictionary(earlier))), Entry::Dictionary(more)) => {
                earlier.has_patterns |= more.has_patterns;
                earlier.is_open |= more.is_open;
                earlier.has_openings |= more.has_openings;
                for (keyword, entry) in more.entries {
                    earlier.add(keyword, entry);
                }
            }
            (Some((_, earlier)), entry) => *earlier = entry,
            (None, entry) => self.entries.push((keyword, entry)),
        }
    }
}

fn read_into(
    case: &Path,
    path: &Path,
    depth: usize,
    into: &mut Dictionary,
) -> Result<(), DictionaryError> {
    let wrong = |message: String| DictionaryError {
        path: path.to_owned(),
        line: 1,
        message,
    };
    let kind = fs::metadata(path).map_err(|e| wrong(e.to_string()))?;
    if !kind.is_file() {
        return Err(wrong("this is not a file".into()));
    }
    if kind.len() > MOST_BYTES {
        into.is_open = true;
        return Ok(());
    }
    let bytes = fs::read(path).map_err(|e| wrong(e.to_string()))?;
    let text = String::from_utf8_lossy(&bytes);
    let mut parser = Parser {
        case,
        path,
        depth,
        nesting: 0,
        letters: text.chars().collect(),
        at: 0,
        line: 1,
    };
    parser.entries(into, None)
}

#[derive(Debug, PartialEq)]
enum Token {
    Word(String),
    /// In quotes.
    Text(String),
    /// `#name`
    Directive(String),
    /// A brace, a bracket or a semicolon.
    Mark(char),
}

struct Parser<'a> {
    case: &'a Path,
    path: &'a Path,
    depth: usize,
    nesting: usize,
    letters: Vec<char>,
    at: usize,
    line: usize,
}

impl Parser<'_> {
    fn error(&self, line: usize, message: impl Into<String>) -> DictionaryError {
        DictionaryError {
            path: self.path.to_owned(),
            line,
            message: message.into(),
        }
    }

    /// Entries up to the end of the file, or to the brace that closes that of the line `opened`.
    fn entries(
        &mut self,
        into: &mut Dictionary,
        opened: Option<usize>,
    ) -> Result<(), DictionaryError> {
        loop {
            let token = self.token()?;
            let line = self.line;
            match (token, opened) {
                (None, None) | (Some(Token::Mark('}')), Some(_)) => return Ok(()),
                (None, Some(line)) => {
                    return Err(self.error(line, "the brace `{` is never closed"));
                }
                (Some(Token::Mark(';')), _) => {}
                (Some(Token::Mark(mark)), _) => {
                    return Err(self.error(line, format!("expected a keyword, found `{mark}`")));
                }
                (Some(Token::Directive(name)), _) if name == "include" => {
                    match self.token()? {
                        Some(Token::Text(file)) => self.include(&file, line, into)?,
                        _ => {
                            return Err(
                                self.error(line, "expected a file in quotes after #include")
                            );
                        }
                    };
                }
                (Some(Token::Directive(name)), _) => {
                    // Velocities of the driver's take the place of an entry that is there.
                    let is_known = name == "includeIfPresent"
                        && matches!(self.token()?, Some(Token::Text(file)) if file.ends_with(INITIAL_VELOCITY));
                    if !is_known {
                        into.is_open = true;
                        self.skip_line();
                    }
                }
                (Some(Token::Word(word)), _) if word.starts_with('$') => into.is_open = true,
                (Some(Token::Text(pattern)), _) => {
                    into.has_patterns = true;
                    let entry = self.value(&pattern, line)?;
                    into.add(pattern, entry);
                }
                (Some(Token::Word(keyword)), _) => {
                    let entry = self.value(&keyword, line)?;
                    // The rest of a binary file is not text.
                    let binary = matches!(&entry, Entry::Dictionary(header)
                        if keyword == "FoamFile" && header.word("format") == Some("binary"));
                    into.add(keyword, entry);
                    if binary {
                        into.is_open = true;
                        return Ok(());
                    }
                }
            }
        }
    }

    /// What follows a keyword that stands in this line.
    fn value(&mut self, keyword: &str, line: usize) -> Result<Entry, DictionaryError> {
        let unended = |parser: &Self| {
            parser.error(
                line,
                format!("the entry `{keyword}` has no end: expected `;`"),
            )
        };
        let mut words = Vec::new();
        let mut open: Vec<(char, usize)> = Vec::new();
        let mut first = true;
        loop {
            let token = self.token()?;
            let here = self.line;
            match token {
                None => return Err(unended(self)),
                Some(Token::Mark('{')) if first => {
                    if self.nesting == MAX_NESTING {
                        let reason =
                            format!("more than {MAX_NESTING} dictionaries within each other");
                        return Err(self.error(here, reason));
                    }
                    let mut dictionary = Dictionary::default();
                    self.nesting += 1;
                    self.entries(&mut dictionary, Some(here))?;
                    self.nesting -= 1;
                    return Ok(Entry::Dictionary(dictionary));
                }
                Some(Token::Mark(';')) if open.is_empty() => return Ok(Entry::Words(words)),
                Some(Token::Mark(';')) => {}
                Some(Token::Mark(mark)) if "{([".contains(mark) => open.push((mark, here)),
                Some(Token::Mark(mark)) => match open.pop() {
                    None if mark == '}' => return Err(unended(self)),
                    None => {
                        return Err(
                            self.error(here, format!("nothing is open that `{mark}` closes"))
                        );
                    }
                    Some((opened, _)) if closing(opened) == mark => {}
                    Some((opened, there)) => {
                        return Err(self.error(
                            here,
                            format!("`{mark}` does not close the `{opened}` of line {there}"),
                        ));
                    }
                },
                Some(Token::Word(word) | Token::Text(word)) => words.push(word),
                // The value is calculated, or code.
                Some(Token::Directive(name)) => words.push(format!("#{name}")),
            }
            first = false;
        }
    }

    fn include(
        &mut self,
        file: &str,
        line: usize,
        into: &mut Dictionary,
    ) -> Result<(), DictionaryError> {
        let places = [
            ("$FOAM_CASE/", ""),
            ("${FOAM_CASE}/", ""),
            ("<case>/", ""),
            ("<system>/", "system/"),
            ("<constant>/", "constant/"),
        ];
        let found = places.iter().find_map(|(name, folder)| {
            let rest = file.strip_prefix(name)?;
            Some(format!("{folder}{rest}"))
        });
        let path = match found {
            Some(inside) if GENERATED.contains(&inside.as_str()) => return Ok(()),
            Some(inside) if FIELDS.iter().any(|field| included(field) == inside) => {
                into.has_openings = true;
                return Ok(());
            }
            Some(inside) => self.case.join(inside),
            None if file.contains(['$', '<', '~']) => {
                into.is_open = true;
                return Ok(());
            }
            None => self.path.with_file_name(file),
        };
        if path.is_file() && leaves(self.case, &path) {
            return Err(self.error(line, format!("it includes {file:?}, {OUTSIDE}")));
        }
        if !path.is_file() {
            return Err(self.error(line, format!("it includes {file:?}, which is not there")));
        }
        if self.depth == MAX_DEPTH {
            return Err(self.error(
                line,
                format!("more than {MAX_DEPTH} files include each other: is it a cycle?"),
            ));
        }
        read_into(self.case, &path, self.depth + 1, into)
    }

    fn peek(&self, ahead: usize) -> Option<char> {
        self.letters.get(self.at + ahead).copied()
    }

    fn next(&mut self) -> Option<char> {
        let letter = self.peek(0)?;
        self.at += 1;
        self.line += usize::from(letter == '\n');
        Some(letter)
    }

    fn skip_line(&mut self) {
        while self.peek(0).is_some_and(|letter| letter != '\n') {
            self.at += 1;
        }
    }

    fn at_comment(&self) -> bool {
        self.peek(0) == Some('/') && matches!(self.peek(1), Some('/' | '*'))
    }

    /// Skips blanks and comments.
    fn skip_blanks(&mut self) -> Result<(), DictionaryError> {
        loop {
            if self.at_comment() && self.peek(1) == Some('/') {
                self.skip_line();
            } else if self.at_comment() {
                let begin = self.line;
                self.take_until("*/")
                    .ok_or_else(|| self.error(begin, "the comment `/*` is never closed"))?;
            } else if self.peek(0).is_some_and(char::is_whitespace) {
                self.next();
            } else {
                return Ok(());
            }
        }
    }

    /// Goes on after the next occurrence of `end`; None if there is none.
    fn take_until(&mut self, end: &str) -> Option<String> {
        let mut text = String::new();
        while !text.ends_with(end) {
            text.push(self.next()?);
        }
        Some(text)
    }

    fn token(&mut self) -> Result<Option<Token>, DictionaryError> {
        self.skip_blanks()?;
        let line = self.line;
        let Some(letter) = self.peek(0) else {
            return Ok(None);
        };
        if "{}()[];".contains(letter) {
            self.at += 1;
            return Ok(Some(Token::Mark(letter)));
        }
        if letter == '"' {
            self.at += 1;
            let mut text = String::new();
            loop {
                match self.next() {
                    Some('"') => return Ok(Some(Token::Text(text))),
                    Some('\\') => text.extend(self.next()),
                    Some(letter) => text.push(letter),
                    None => return Err(self.error(line, "the quotes `\"` are never closed")),
                }
            }
        }
        if letter == '#' && self.peek(1) == Some('{') {
            self.take_until("#}")
                .ok_or_else(|| self.error(line, "the code `#{` is never closed"))?;
            return Ok(Some(Token::Text(String::new())));
        }
        let word = self.word();
        Ok(Some(match word.strip_prefix('#') {
            Some(name) => Token::Directive(name.to_owned()),
            None => Token::Word(word),
        }))
    }

    /// A word, such as `div(phi,U)`: brackets belong to it if they are closed before the next blank. Not to a number.
    fn word(&mut self) -> String {
        let begin = self.at;
        let number = self
            .peek(0)
            .is_some_and(|c| c.is_ascii_digit() || "+-.".contains(c));
        let mut bracket = None;
        let mut depth = 0;
        loop {
            match self.peek(0) {
                Some('{') if self.letters[begin] == '$' && self.at == begin + 1 => {
                    while self.peek(0).is_some_and(|c| c != '}' && !c.is_whitespace()) {
                        self.at += 1;
                    }
                }
                Some('(') if number => break,
                Some('(') => {
                    depth += 1;
                    bracket.get_or_insert(self.at);
                }
                Some(')') if depth > 0 => depth -= 1,
                None | Some('{' | '}' | '[' | ']' | ')' | ';' | '"') => break,
                Some(letter) if letter.is_whitespace() => break,
                Some(_) if self.at_comment() => break,
                Some(_) => {}
            }
            self.at += 1;
        }
        if let Some(bracket) = bracket.filter(|at| depth > 0 && *at > begin) {
            self.at = bracket;
        }
        self.at = self.at.max(begin + 1).min(self.letters.len());
        self.letters[begin..self.at].iter().collect()
    }
}

/// Whether a path that begins as that of the case leads out of it.
fn leaves(case: &Path, path: &Path) -> bool {
    let Ok(inside) = path.strip_prefix(case) else {
        return false;
    };
    let mut depth = 0;
    inside.components().any(|part| {
        depth += match part {
            Component::ParentDir => -1,
            Component::Normal(_) => 1,
            _ => 0,
        };
        depth < 0
    })
}

fn closing(open: char) -> char {
    match open {
        '{' => '}',
        '(' => ')',
        _ => ']',
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Dictionary, DictionaryError> {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("other"), "included yes;\n").unwrap();
        fs::write(folder.path().join("dict"), text).unwrap();
        Dictionary::read(folder.path(), Path::new("dict"))
    }

    #[test]
    fn what_openfoam_reads_is_read() {
        let read = read(
            "// a comment }\nFoamFile { class dictionary; }\n/* { */\n#include \"other\"\n#include \"$FOAM_CASE/system/fsiParameters\"\n\
             nu $kinematicViscosity;\ndiv(phi,U) Gauss linearUpwind grad(U);\ndiv((nuEff*dev2(T(grad(U))))) Gauss linear;\n\
             dimensions [0 2 -2 0 0 0 0];\nvalue nonuniform List<vector> 2((0 0 1)(0 1 0));\nempty;\n\
             table ((0 1)\n (1 2)); inner { \"(a|b)\" { type x; } list ( { a 1; } \"b;c\" ); sub { x 1; } sub { y 2; y 3; } code #{ if (a) { b; #}; n ($ranks 1 1); }\n",
        )
        .unwrap();
        assert_eq!(read.word("included"), Some("yes"));
        assert_eq!(read.word("div(phi,U)"), Some("Gauss"));
        assert_eq!(read.word("value"), Some("nonuniform"));
        assert_eq!(read.word("empty"), None);
        let inner = read.dictionary("inner").unwrap();
        assert!(inner.may_have("a") && !read.may_have("a"));
        let of_pattern = |name| match inner.matching(name) {
            Some(Entry::Dictionary(found)) => found.word("type"),
            _ => None,
        };
        assert_eq!(
            ["a", "b", "ab"].map(of_pattern),
            [Some("x"), Some("x"), None]
        );
        assert_eq!(inner.dictionaries().count(), 2);
        let merged = inner.dictionary("sub").unwrap();
        assert_eq!((merged.word("x"), merged.word("y")), (Some("1"), Some("3")));
        // What cannot be followed may say anything.
        for open in [
            "$other;\n",
            "#includeEtc \"caseDicts/x\"\n",
            "#include \"$HOME/x\"\n",
        ] {
            assert!(super::tests::read(open).unwrap().may_have("a"), "{open}");
        }
    }

    #[test]
    fn files_that_are_not_dictionaries_are_refused_with_the_line() {
        for (text, line, message) in [
            ("rubbish", 1, "`rubbish` has no end: expected `;`"),
            ("a 1;\n\nb { c 2;\n", 3, "`{` is never closed"),
            ("a 1;\n}\n", 2, "expected a keyword, found `}`"),
            ("a (1 2];\n", 1, "`]` does not close the `(` of line 1"),
            ("a 1);\n", 1, "nothing is open that `)` closes"),
            ("b {\n c 2\n}\n", 2, "`c` has no end"),
            ("a \"b;\n", 1, "quotes"),
            ("/* a\n", 1, "comment"),
            (
                "#include \"nothing\"\n",
                1,
                "\"nothing\", which is not there",
            ),
            ("a 1;\n#include \"dict\"\n", 2, "is it a cycle"),
            ("a \u{0}\u{1};\n)", 2, "found `)`"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.message.contains(message), "{text:?}: {error}");
            assert_eq!(error.line, line, "{text:?}: {error}");
        }
    }
}
