//! Runs `fsi-driver solid` on files written for a test.
#![allow(dead_code)]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The example of the documentation.
pub fn example() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/solid.toml");
    std::fs::read_to_string(path).unwrap()
}

/// A folder with a file `tube.toml`.
pub struct TubeCase {
    pub folder: tempfile::TempDir,
}

impl TubeCase {
    pub fn new(text: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("tube.toml"), text).unwrap();
        Self { folder }
    }

    pub fn results(&self) -> PathBuf {
        self.folder.path().join("tube-results")
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
            .current_dir(self.folder.path())
            .args(["solid", "tube.toml", "--quiet"])
            .args(arguments)
            .output()
            .unwrap()
    }

    /// Runs and reads the summary.
    pub fn solve(&self) -> Value {
        let output = self.run(&[]);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{error}");
        let text = std::fs::read(self.results().join("summary.json")).unwrap();
        serde_json::from_slice(&text).unwrap()
    }

    /// Runs a file that must be refused; what is said about it.
    pub fn refused(&self) -> String {
        let output = self.run(&[]);
        assert_eq!(output.status.code(), Some(2));
        let left: Vec<_> = std::fs::read_dir(self.folder.path()).unwrap().collect();
        assert_eq!(left.len(), 1, "something was written");
        String::from_utf8(output.stderr).unwrap()
    }
}

/// A number of a summary.
pub fn number(summary: &Value, key: &str) -> f64 {
    summary[key]
        .as_f64()
        .unwrap_or_else(|| panic!("no number {key}"))
}

/// Mean radial displacements of a summary.
pub fn radial(summary: &Value) -> Vec<f64> {
    let list = summary["radial_displacement_m"].as_array().unwrap();
    list.iter().map(|u| u.as_f64().unwrap()).collect()
}

/// The example with another line for a key.
pub fn with(text: &str, changes: &[(&str, &str)]) -> String {
    let mut text = text.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "the example has no `{from}`");
        text = text.replacen(from, to, 1);
    }
    text
}
