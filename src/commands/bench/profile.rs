//! What OpenFOAM says of its own seconds: the file `uniform/profiling` of a written time, a stock feature that
//! `profiling {}` in `controlDict` switches on.

use std::collections::HashMap;
use std::fs;
use std::io;
use std::path::Path;

/// Seconds of each section of the solver that measures itself, those within it included.
pub type Profile = HashMap<String, f64>;

/// Reads the profile in the folder of a written time; empty if the case's templates do not ask for one.
pub fn read(time: &Path) -> io::Result<Profile> {
    match fs::read_to_string(time.join("uniform/profiling")) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Profile::new()),
        text => Ok(parse(&text?)),
    }
}

/// Entries are dictionaries with a `description` and a `totalTime`; sections that appear below several others are added.
fn parse(text: &str) -> Profile {
    let mut profile = Profile::new();
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
