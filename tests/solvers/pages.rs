//! The commands and snippets of README, tutorials and how-to pages run as they are printed.
//!
//! The shell and Python blocks of a page run one after the other in one scratch folder with copies of `openfoam-case`
//! and `examples`. Every key of a TOML block must exist, and every line of a Rust block must stand in an example. `<!--
//! not run: REASON -->` before a block leaves it out, `<!-- needs OpenFOAM -->` without the feature `openfoam`.

use crate::python_reader::python;
use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;

/// A block of a page: its language and text.
struct CodeBlock {
    language: String,
    text: String,
}

/// The blocks of a page that are to be tested.
fn blocks(page: &str) -> Vec<CodeBlock> {
    let mut found = Vec::new();
    let mut lines = page.lines();
    let mut left_out = false;
    while let Some(line) = lines.next() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            let indent = line.len() - line.trim_start().len();
            let text: Vec<_> = lines
                .by_ref()
                .take_while(|line| line.trim() != "```")
                .map(|line| line.get(indent..).unwrap_or_default())
                .collect();
            if !left_out {
                found.push(CodeBlock {
                    language: language.into(),
                    text: text.join("\n") + "\n",
                });
            }
        }
        left_out = line.starts_with("<!-- not run: ")
            || line == "<!-- needs OpenFOAM -->" && !cfg!(feature = "openfoam");
    }
    found
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Writes a program of one line of shell.
fn program(path: &Path, line: &str) {
    fs::write(path, format!("#!/bin/sh\n{line}\n")).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
}

/// Tests all blocks of a page and returns what they printed. Runs end after `end` seconds, if that is given; on a page
/// that resumes runs, those without an end of their own.
fn run(page: &str, end: Option<&str>) -> String {
    let Some(python) = python() else {
        return String::new();
    };
    let text = fs::read_to_string(root().join(page)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for name in ["openfoam-case", "examples"] {
        let mut copy = Command::new("cp");
        copy.arg("-r").arg(root().join(name)).arg(at(name));
        assert!(copy.status().unwrap().success());
    }
    // Those of the README may have left runs, which would be in the way.
    let mut clear = Command::new("find");
    clear.args([at("openfoam-case"), at("examples")]);
    clear.args([
        "-name", "run-*", "-type", "d", "-prune", "-exec", "rm", "-r", "{}", "+",
    ]);
    assert!(clear.status().unwrap().success());
    // The commands say `fsi-driver`, `cargo run`, `python3` and a browser, whatever these are here.
    for name in ["programs", "target/release"] {
        fs::create_dir_all(at(name)).unwrap();
    }
    let fsi = env!("CARGO_BIN_EXE_fsi-driver");
    symlink(fsi, at("target/release/fsi-driver")).unwrap();
    let shorten = end.map_or(String::new(), |end| {
        // The end that a command gives matters where a later one resumes the run.
        let own = match text.contains("--resume") {
            true => "",
            false => "n=$#; for w in \"$@\"; do [ \"$last\" != --end-time ] || w=$end; last=$w; set -- \"$@\" \"$w\"; done; shift $n",
        };
        format!(
            "end={end}; case \" $* \" in *' --end-time '*) {own};; *' --case '*) case $1 in --case|run) set -- \"$@\" --end-time $end;; esac;; esac; "
        )
    });
    program(
        &at("programs/fsi-driver"),
        &format!("{shorten}exec {fsi} \"$@\""),
    );
    program(
        &at("programs/cargo"),
        &format!("[ \"$1 $2 $3\" = 'run --release --' ] && shift 3 && exec {fsi} \"$@\""),
    );
    program(&at("programs/xdg-open"), "test -f \"$1\"");
    let say_path = ["-c", "import sys; print(sys.executable)"];
    let real = Command::new(python).args(say_path).output().unwrap();
    let real = String::from_utf8(real.stdout).unwrap();
    program(
        &at("programs/python3"),
        &format!("exec {} \"$@\"", real.trim()),
    );
    let path = format!(
        "{}:{}",
        at("programs").display(),
        std::env::var("PATH").unwrap()
    );

    let found = blocks(&text);
    assert!(!found.is_empty(), "{page} has no block to test");
    let mut printed = String::new();
    for block in found {
        let (program, option) = match block.language.as_str() {
            "sh" => ("sh", "-ec"),
            "python" => ("python3", "-c"),
            "toml" => {
                has_known_keys(page, &block.text);
                continue;
            }
            "rust" => {
                is_of_an_example(page, &block.text);
                continue;
            }
            _ => continue,
        };
        let output = Command::new("env")
            .arg(format!("PATH={path}"))
            // As if the package were installed, with the program of the search path.
            .arg(format!(
                "PYTHONPATH={}",
                root().join("src/python").display()
            ))
            .arg("PYTHONDONTWRITEBYTECODE=1")
            .args([program, option])
            .arg(&block.text)
            .current_dir(folder.path())
            .output()
            .unwrap();
        let said = crate::run_support::text(&output);
        assert!(output.status.success(), "{page}:\n{}\n{said}", block.text);
        // Tables made from kept runs.
        if block.text.contains("/kept/") {
            let rows = said.lines().filter(|line| line.starts_with('|'));
            rows.for_each(|row| assert!(text.contains(row), "{page} should have\n{said}"));
        }
        printed += &said;
    }
    printed
}

/// Every key of a snippet is one of a case, or of a file of `fsi-driver solid`.
fn has_known_keys(page: &str, snippet: &str) {
    let mut known = BTreeSet::from(["extends".to_owned()]);
    for of in [&["keys"][..], &["keys", "--solid"]] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
        let keys = command.args(of).output().unwrap();
        let keys = String::from_utf8(keys.stdout).unwrap();
        let paths = keys.lines().filter(|line| !line.starts_with(' '));
        known.extend(paths.map(|line| line.split(' ').next().unwrap().to_owned()));
    }
    let table = snippet.replace('…', "");
    let table: toml::Table =
        toml::from_str(&table).unwrap_or_else(|e| panic!("{page}: {e}\n{snippet}"));
    let mut found = Vec::new();
    paths(&toml::Value::Table(table), "", &mut found);
    for path in found {
        assert!(known.contains(&path), "{page}: no key is called {path}");
    }
}

/// The paths of all keys below, those of lists of tables with `[]`.
fn paths(value: &toml::Value, path: &str, found: &mut Vec<String>) {
    match value {
        toml::Value::Table(table) => {
            for (key, value) in table {
                let dot = if path.is_empty() { "" } else { "." };
                paths(value, &format!("{path}{dot}{key}"), found);
            }
        }
        toml::Value::Array(rows) if rows.iter().any(toml::Value::is_table) => {
            for row in rows {
                paths(row, &format!("{path}[]"), found);
            }
        }
        _ => found.push(path.to_owned()),
    }
}

/// Every line of a snippet stands in one of the examples.
fn is_of_an_example(page: &str, snippet: &str) {
    let plain = |text: &str| {
        let code = text.lines().map(|line| line.split("//").next().unwrap());
        code.collect::<String>().replace(char::is_whitespace, "")
    };
    let examples = [
        "coupled_vessel.rs",
        "own_fluid/main.rs",
        "own_fluid/fluid.rs",
    ];
    let examples = examples
        .map(|name| plain(&fs::read_to_string(root().join("examples").join(name)).unwrap()));
    for statement in plain(snippet).split_inclusive(';') {
        assert!(
            examples.iter().any(|example| example.contains(statement)),
            "{page}: no example has {statement}"
        );
    }
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
        &run("docs/tutorials/first-run.md", None),
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
    says(
        &run("docs/tutorials/two-fluids.md", None),
        &["outlet pressure / Pa"],
    );
}

#[test]
fn your_vessel() {
    says(
        &run("docs/tutorials/your-vessel.md", None),
        &["my-vessel/preview.png", "can be run", "my-run/report.html"],
    );
}

#[test]
fn carotid() {
    says(
        &run("docs/tutorials/carotid.md", None),
        &[
            "internal 65.0 %",
            "my-carotid/preview.png",
            "can be run",
            "my-carotid-run/report.html",
            "the vessel itself has",
        ],
    );
}

#[test]
fn uncertainty() {
    says(
        &run("docs/tutorials/uncertainty.md", None),
        &["few/report.html", "# sobol:3+1", "inflow.mean_m3_s"],
    );
}

#[test]
fn windkessel() {
    let printed = run("docs/tutorials/windkessel.md", None);
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
        &run("docs/tutorials/prestress.md", None),
        &["it buckles at 31.11 kPa", "prestretched/report.html"],
    );
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn fsi1() {
    says(
        &run("docs/tutorials/fsi1.md", None),
        &["400 steps of 0.05 s"],
    );
}

#[test]
fn own_fluid_python() {
    says(
        &run("docs/tutorials/own-fluid-python.md", None),
        &["all passed", "tube-1d/report.html"],
    );
}

#[test]
fn analysis_python() {
    let printed = run("docs/tutorials/analysis-python.md", None);
    says(
        &printed,
        &["outlet pressure 7", "OSI at most 0.0", "2 steps"],
    );
}

#[test]
fn own_fluid_rust() {
    // Its command is `cargo run --example`, which `.ci/run` calls.
    run("docs/tutorials/own-fluid-rust.md", None);
}

#[test]
fn readme() {
    let printed = run("README.md", None);
    says(&printed, &["25 steps to t = 0.2500 s", "run-demo"]);
}

#[test]
fn running() {
    run("docs/running.md", Some("0.004"));
}

#[test]
fn how_to_vessels() {
    let printed = run("docs/vessels.md", Some("0.02"));
    says(&printed, &["my-vessel/preview.png", "run-demo/report.html"]);
}

#[test]
fn how_to_artery_state() {
    let printed = run("docs/artery-state.md", None);
    says(&printed, &["4.542 mm", "can be run"]);
}

#[test]
fn how_to_own_fluid() {
    says(&run("docs/own-fluid.md", None), &["all passed"]);
}

#[test]
fn how_to_snippets() {
    for page in ["boundary-conditions.md", "blood.md"] {
        run(&format!("docs/{page}"), None);
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn how_to_own_case() {
    says(&run("docs/own-case.md", None), &["can be run"]);
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn examples_of_vessels() {
    let vessels = "uniform curved stenosis aneurysm graft carotid surface";
    for vessel in vessels.split(' ') {
        run(
            &format!("examples/vessels/{vessel}/README.md"),
            Some("0.004"),
        );
    }
    run("examples/straight-artery/README.md", Some("0.004"));
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn examples_of_own_cases() {
    for (case, end) in [
        ("tube", "2e-4"),
        ("bifurcation", "0.01"),
        ("flap", "0.01"),
        ("flap-one-cell-deep", "0.01"),
        ("carotid", "0.005"),
    ] {
        run(&format!("examples/own-case/{case}/README.md"), Some(end));
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn how_to_trees() {
    says(&run("docs/trees.md", Some("0.005")), &["can be run"]);
    for tree in [
        "aneurysm",
        "aorta",
        "arteries",
        "carotid",
        "side-branch",
        "y",
    ] {
        run(&format!("examples/trees/{tree}/README.md"), Some("0.005"));
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn benchmarks_of_moving_walls() {
    for (case, end) in [
        ("elastic-tube", "1e-4"),
        ("single-arteries", "0.01"),
        ("slow-inflation", "0.1"),
        ("womersley-thick", "0.005"),
        ("silicone-filament", "0.01"),
    ] {
        run(&format!("openfoam-case/{case}/README.md"), Some(end));
    }
}

/// Every page of the book's tutorials and how-tos with a block that could be tested is in a test above.
#[test]
fn every_page_is_tested() {
    let summary = fs::read_to_string(root().join("docs/book/SUMMARY.md")).unwrap();
    let (guides, _) = summary.split_once("# Theory").unwrap();
    let tests = include_str!("pages.rs");
    let pages = guides
        .split("](")
        .skip(1)
        .map(|rest| rest.split(')').next().unwrap());
    for page in pages {
        let text = fs::read_to_string(root().join(page)).unwrap();
        let tested =
            |block: &CodeBlock| ["sh", "python", "toml", "rust"].contains(&block.language.as_str());
        let name = page
            .rsplit('/')
            .find(|part| *part != "README.md")
            .unwrap_or(page);
        assert!(
            !blocks(&text).iter().any(tested) || tests.contains(name),
            "{page} is in no test"
        );
    }
}
