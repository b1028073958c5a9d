//! The commands of the tutorials run as they are printed.
//!
//! The shell and Python blocks of a page run one after the other in one scratch folder, which has `openfoam-case` and
//! `examples` beside it as a source tree has. `<!-- not run: REASON -->` before a block leaves it out.

use crate::python_reader::python;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// A block of a page: its language and text.
struct Block {
    language: String,
    text: String,
}

/// The blocks of a page that are to be run.
fn blocks(page: &str) -> Vec<Block> {
    let mut found = Vec::new();
    let mut lines = page.lines();
    let mut left_out = false;
    while let Some(line) = lines.next() {
        if let Some(language) = line.strip_prefix("```") {
            let text: Vec<_> = lines.by_ref().take_while(|line| *line != "```").collect();
            if ["sh", "python"].contains(&language) && !left_out {
                found.push(Block {
                    language: language.into(),
                    text: text.join("\n") + "\n",
                });
            }
        }
        left_out = line.starts_with("<!-- not run: ");
    }
    found
}

/// Runs all blocks of a tutorial and returns what they printed.
fn run(page: &str) -> String {
    let Some(python) = python() else {
        return String::new();
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("docs/tutorials").join(page)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for name in ["openfoam-case", "examples"] {
        symlink(root.join(name), folder.path().join(name)).unwrap();
    }
    // The commands say `fsi-driver` and `python3`, whatever these are here.
    let programs = folder.path().join("programs");
    std::fs::create_dir(&programs).unwrap();
    symlink(
        env!("CARGO_BIN_EXE_fsi-driver"),
        programs.join("fsi-driver"),
    )
    .unwrap();
    let say_path = ["-c", "import sys; print(sys.executable)"];
    let real = Command::new(python).args(say_path).output().unwrap();
    let real = String::from_utf8(real.stdout).unwrap();
    let wrapper = format!("#!/bin/sh\nexec {} \"$@\"\n", real.trim());
    let wrapped = programs.join("python3");
    std::fs::write(&wrapped, wrapper).unwrap();
    let executable = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(&wrapped, executable).unwrap();
    let path = std::env::var("PATH").unwrap();
    let path = format!("{}:{path}", programs.display());

    let found = blocks(&text);
    assert!(!found.is_empty(), "{page} has no command");
    let mut printed = String::new();
    for block in found {
        let mut command = match block.language.as_str() {
            "sh" => Command::new("sh"),
            _ => Command::new(&wrapped),
        };
        let options: &[&str] = if block.language == "sh" {
            &["-ec"]
        } else {
            &["-c"]
        };
        let output = command
            .current_dir(folder.path())
            .env("PATH", &path)
            .args(options)
            .arg(&block.text)
            .output()
            .unwrap();
        let said = crate::run_support::text(&output);
        assert!(output.status.success(), "{page}:\n{}\n{said}", block.text);
        printed += &said;
    }
    printed
}

/// The text printed contains the words.
fn says(printed: &str, words: &[&str]) {
    for word in words {
        assert!(
            printed.is_empty() || printed.contains(word),
            "no {word} in\n{printed}"
        );
    }
}

#[test]
fn first_run() {
    says(
        &run("first-run.md"),
        &[
            "25 steps to t = 0.2500 s",
            "first/report.html",
            "wall.media.mu_Pa",
        ],
    );
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn two_fluids() {
    says(&run("two-fluids.md"), &["outlet pressure / Pa"]);
}

#[test]
fn your_vessel() {
    says(
        &run("your-vessel.md"),
        &["my-vessel/preview.png", "can be run", "my-run/report.html"],
    );
}

#[test]
fn windkessel() {
    let printed = run("windkessel.md");
    says(
        &printed,
        &[
            "resistance_Pa_s_m3 = 2.4403e9",
            "compliance_m3_Pa = 2.3008e-10",
        ],
    );
}

#[test]
fn prestress() {
    says(
        &run("prestress.md"),
        &["it buckles at 31.11 kPa", "prestretched/report.html"],
    );
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn fsi1() {
    says(&run("fsi1.md"), &["400 steps of 0.05 s"]);
}

#[test]
fn own_fluid_python() {
    says(
        &run("own-fluid-python.md"),
        &["all passed", "tube-1d/report.html"],
    );
}

#[test]
fn analysis_python() {
    let printed = run("analysis-python.md");
    says(&printed, &["outlet pressure 7", "OSI at most 0.0"]);
}

#[test]
fn every_tutorial_is_tested() {
    let pages = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/tutorials"));
    let tests = include_str!("tutorials.rs");
    for page in pages.unwrap() {
        let name = page.unwrap().file_name().into_string().unwrap();
        // Its command is `cargo run`, which `.ci/run` calls.
        if name != "own-fluid-rust.md" {
            assert!(
                tests.contains(&format!("run(\"{name}\")")),
                "{name} is in no test"
            );
        }
    }
}
