//! Cases as runs have left them, also runs of earlier versions.

use super::problem::arranged;
use super::{Case, defaults, templates};

/// Tables of settings of the method. Those that came later than a run cannot have changed its results.
const METHOD: [&str; 5] = ["time", "structure", "fluid", "coupling", "output"];

impl Case {
    /// Reads the text of a `case.resolved.toml`. Settings of the method that came later than the run have their
    /// defaults.
    ///
    /// # Errors
    /// If a value of the physics is missing, or one cannot be read.
    pub fn of_earlier_run(text: &str) -> Result<Self, toml::de::Error> {
        let defaults: toml::Table = toml::from_str(defaults::TEXT)?;
        let mut case: toml::Table = toml::from_str(text)?;
        for name in METHOD {
            let (Some(toml::Value::Table(own)), Some(toml::Value::Table(all))) =
                (case.get_mut(name), defaults.get(name))
            else {
                continue;
            };
            for (key, value) in all {
                own.entry(key.clone()).or_insert_with(|| value.clone());
            }
        }
        let mut case: Self = toml::Value::Table(arranged(&case)).try_into()?;
        // The record names what is built in by its word.
        let word = case.fluid.templates.to_str().unwrap_or_default();
        if let Ok(folder) = templates::folder(word) {
            case.fluid.templates = folder;
        }
        Ok(case)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Preset;
    use std::path::Path;

    /// Settings that came later have their defaults; physics that is not there is an error.
    #[test]
    fn a_case_of_an_earlier_version_is_completed() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/H-0.5");
        let case = Case::load(&folder, Preset::Coarse, &[]).unwrap();
        let text = case.to_toml_string();
        assert_eq!(Case::of_earlier_run(&text).unwrap(), case.case);
        // Once the record of a flag had the keys of a vessel as well.
        let flag = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/turek-hron");
        let flag = Case::load(&flag, Preset::Demo, &[]).unwrap();
        let both = flag.to_toml_string() + "[inflow]\nbase_m3_s = 1e-6\n";
        assert_eq!(Case::of_earlier_run(&both).unwrap(), flag.case);
        let without = |key: &str| -> String {
            let lines = text.lines().filter(|line| !line.starts_with(key));
            lines.collect::<Vec<_>>().join("\n")
        };
        assert_eq!(
            Case::of_earlier_run(&without("wall_history")).unwrap(),
            case.case
        );
        let refused = Case::of_earlier_run(&without("viscosity_Pa_s")).unwrap_err();
        assert!(refused.to_string().contains("viscosity_Pa_s"), "{refused}");
    }
}
