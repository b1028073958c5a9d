//! What is printed where nobody reads, where nothing can be written, and in narrow terminals.

use crate::run_support::{complete, driver, text};
use std::fs::File;
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments);
    command
}

/// Standard output is a pipe whose reader has gone.
fn without_reader(mut command: Command) -> Output {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    command.stdout(writer).stderr(Stdio::piped());
    command.spawn().unwrap().wait_with_output().unwrap()
}

/// Standard output is a full disk.
fn on_full_disk(mut command: Command) -> Output {
    let full = File::options().write(true).open("/dev/full").unwrap();
    command.stdout(full).stderr(Stdio::piped());
    command.spawn().unwrap().wait_with_output().unwrap()
}

/// A reader that stops gets no message; a full disk is reported in a sentence.
fn assert_graceful(arguments: &[&str]) {
    let output = without_reader(command(arguments));
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    assert!(!text(&output).contains("Broken pipe"), "{}", text(&output));
    assert_full(arguments, &on_full_disk(command(arguments)));
}

fn assert_full(what: &[&str], output: &Output) {
    let said = text(output);
    assert_eq!(output.status.code(), Some(1), "{what:?}: {said}");
    let last = said.lines().last().unwrap();
    assert!(
        last.starts_with("error: cannot write to standard output: No space left on device"),
        "{what:?}: {said}"
    );
    assert!(!said.contains("panicked"), "{said}");
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn commands_survive_readers_that_go_and_full_disks() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (run, page, tube) = (path("run"), path("page.html"), path("tube"));
    // The run itself: its results are there even if it cannot say so.
    assert_full(&["run"], &on_full_disk(driver(Path::new(&run), 2, &[])));
    let summary = std::fs::read_to_string(folder.path().join("run/summary.json")).unwrap();
    assert!(summary.contains("\"complete\""), "{summary}");
    let again = without_reader(driver(Path::new(&run), 2, &["--resume"]));
    assert!(again.status.success(), "{}", text(&again));

    let all: [&[&str]; 7] = [
        &["--help"],
        &["--version"],
        &["check", "openfoam-case/S-0.25"],
        &["hemodynamics", &run],
        &["report", &run, "--out", &page],
        &["compare", &run, &run],
        &[
            "solid",
            "docs/solid.toml",
            "--out",
            &tube,
            "--force",
            "--quiet",
        ],
    ];
    all.into_iter().for_each(assert_graceful);
}

/// The lines that a command prints in a terminal with that many columns.
fn in_terminal(columns: usize, command: &str) -> Vec<String> {
    let shell = format!("stty cols {columns}; {command}");
    let output = Command::new("script")
        .args(["--quiet", "--return", "--command", &shell, "/dev/null"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .env("TERM", "xterm") // without it there is no progress to be shown
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output));
    let lines = text(&output);
    lines.lines().map(|l| l.trim_end().to_owned()).collect()
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn lines_of_results_and_progress_fit_into_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    complete(driver(&run, 2, &[]));
    let program = env!("CARGO_BIN_EXE_fsi-driver");
    let tube = folder.path().join("tube");
    let commands = [
        format!(
            "cd {} && {program} hemodynamics run",
            folder.path().display()
        ),
        format!("{program} check openfoam-case/S-0.25"),
        format!(
            "{program} solid docs/solid.toml --force --quiet --out {}",
            tube.display()
        ),
    ];
    for columns in [60, 80, 100] {
        for command in &commands {
            let lines = in_terminal(columns, command);
            assert!(lines.len() > 2, "{lines:?}");
            for line in &lines {
                // Progress is written over itself.
                for shown in line.split(['\r', '\x1b']) {
                    let shown = shown.trim_start_matches("[2K").trim_end();
                    // A path cannot be broken.
                    let fits = shown.chars().count() <= columns || shown.contains("/tube");
                    assert!(fits, "{columns} columns: {shown}");
                }
            }
        }
        let steps = driver(&run, 4, &["--force"]);
        let arguments: Vec<_> = steps.get_args().map(|a| a.to_string_lossy()).collect();
        let lines = in_terminal(columns, &format!("{program} {}", arguments.join(" ")));
        let shown = lines.iter().flat_map(|line| line.split(['\r', '\x1b']));
        let progress: Vec<&str> = shown.filter(|text| text.contains("t = 0.00")).collect();
        assert!(!progress.is_empty(), "{lines:?}");
        for text in progress {
            // What follows in the same line is padding, and then the next line.
            let line = text.split_inclusive(" left").next().unwrap();
            let line = line.trim_start_matches("[2K");
            assert!(line.ends_with(" left"), "{columns}: {text}");
            assert!(line.chars().count() < columns, "{columns}: {text}");
        }
    }
}
