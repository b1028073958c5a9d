//! What OpenFOAM says of its own seconds: the file `uniform/profiling` of a written time, a stock feature that
//! `profiling {}` in `controlDict` switches on.

use std::collections::HashMap;
use std::fs;
use std::io;
use std::path::PathBuf;

/// Seconds of each section of the solver that measures itself, those within it included.
type SectionSeconds = HashMap<String, f64>;

/// Parts of the solver's work, and the sections in which it spends them.
const PARTS: [(&str, &str); 3] = [
    ("mesh motion", "fsi::moveWall"),
    ("momentum", "fvMatrix::solve.U"),
    ("pressure", "fvMatrix::solve.p"),
];

/// The seconds of each part by the profile among the `files` of a written time; none if the case's templates do not ask
/// for one.
pub fn seconds_by_part(files: &[PathBuf]) -> io::Result<Vec<(String, f64)>> {
    let Some(file) = files
        .iter()
        .find(|file| file.ends_with("uniform/profiling"))
    else {
        return Ok(Vec::new());
    };
    let profile = parse(&fs::read_to_string(file)?);
    let seconds = |section: &str| profile.get(section).copied().unwrap_or(0.0);
    let parts = PARTS.map(|(part, section)| (part.to_owned(), seconds(section)));
    Ok(parts.into())
}

/// Entries are dictionaries with a `description` and a `totalTime`; sections that appear below several others are
/// added.
fn parse(text: &str) -> SectionSeconds {
    let mut profile = SectionSeconds::new();
    let mut section = None;
    for line in text.lines() {
        let Some((key, value)) = line
            .trim()
            .trim_end_matches(';')
            .split_once(char::is_whitespace)
        else {
            continue;
        };
        match key {
            "description" => section = Some(value.trim().trim_matches('"').to_owned()),
            "totalTime" => {
                if let (Some(name), Ok(seconds)) = (section.take(), value.trim().parse::<f64>()) {
                    *profile.entry(name).or_default() += seconds;
                }
            }
            _ => {}
        }
    }
    profile
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn sections_are_added_over_their_callers() {
        let text = "profiling\n{\n    trigger0\n    {\n        id  0;\n        description     \"fvMatrix::solve.p\";\n        calls 3;\n        totalTime       1.5;\n        childTime 0;\n    }\n    trigger1\n    {\n        description     \"fvMatrix::solve.p\";\n        totalTime       0.25;\n    }\n    trigger2\n    {\n        description     \"application::main\";\n        totalTime       9;\n    }\n}\n";
        let profile = parse(text);
        assert_eq!(profile["fvMatrix::solve.p"], 1.75);
        assert_eq!(profile["application::main"], 9.0);
        assert_eq!(profile.len(), 2);
    }
}
