//! `fsi-driver check`, and the trial start of OpenFOAM that a run makes as well.

use crate::run_support::{driver, eventually, processes_in, signal, start, text};
use rustix::process::Signal;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

fn check(settings: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args([
        "check",
        "openfoam-case/S-0.25",
        "--preset",
        "demo",
    ]);
    if !settings.is_empty() {
        command.arg("--set").args(settings);
    }
    command
}

fn refused(output: &Output, part: &str) {
    assert_eq!(output.status.code(), Some(2), "{}", text(output));
    assert!(text(output).contains(part), "{}", text(output));
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn check_says_how_large_a_case_is_and_tries_openfoam() {
    let good = check(&[]).output().unwrap();
    let said = text(&good);
    assert!(good.status.success(), "{said}");
    for part in ["5040 cells", "OpenFOAM takes the templates"] {
        assert!(said.contains(part), "{said}");
    }
    let large = check(&["structure.p=10", "structure.circumferential=1000"]);
    refused(&{ large }.output().unwrap(), "GB of memory");
    let bad = check(&["structure.p=2", "time.step_s=7"]).output().unwrap();
    refused(&bad, "structure.p");
    refused(&bad, "time.step_s");
}

#[test]
fn without_openfoam_everything_else_is_checked() {
    let without = |settings: &[&str]| check(settings).env("PATH", "/nowhere").output().unwrap();
    let good = without(&[]);
    assert_eq!(good.status.code(), Some(0), "{}", text(&good));
    let sentence = "OpenFOAM was left out: OpenFOAM's `pimpleFoam` is not installed here";
    assert!(text(&good).contains(sentence), "{}", text(&good));
    let native = without(&["fluid.solver=\"native\""]);
    assert_eq!(native.status.code(), Some(0), "{}", text(&native));
    // Measured: 192 MB.
    for part in ["OpenFOAM is not needed", "memory  about 0.21 GB"] {
        assert!(text(&native).contains(part), "{}", text(&native));
    }
    refused(
        &without(&["output.probes_m=[[0.01, 1.0, 0.0]]"]),
        "output.probes_m",
    );
    refused(&without(&["fluid.templates=\"tests\""]), "fluid.templates");
}

/// A search path that finds a `pimpleFoam` in the new folder `programs` that never answers: a script around another
/// program.
fn never_answers(programs: &Path) -> String {
    std::fs::create_dir(programs).unwrap();
    let fake = programs.join("pimpleFoam");
    std::fs::write(&fake, "#!/bin/sh\nsleep 600\nexit 1\n").unwrap();
    std::fs::set_permissions(&fake, std::fs::Permissions::from_mode(0o755)).unwrap();
    let path = std::env::var("PATH").unwrap();
    format!("{}:{path}", programs.display())
}

/// What the driver leaves of it in its folder for
/// temporary files, after a signal during the trial, is nothing.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_signal_during_the_trial_start_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (programs, temporary, out) = (
        folder.path().join("bin"),
        folder.path().join("tmp"),
        folder.path().join("run"),
    );
    std::fs::create_dir(&temporary).unwrap();
    let path = never_answers(&programs);
    let mut check = check(&[]);
    check.stdout(Stdio::null());
    for (mut command, by) in [
        (check, Signal::INT),
        (driver(&out, 1, &[]), Signal::TERM),
        (driver(&out, 1, &[]), Signal::HUP),
    ] {
        command.env("PATH", &path).env("TMPDIR", &temporary);
        let mut child = match command.get_args().any(|word| word == "check") {
            true => command.stderr(Stdio::null()).spawn().unwrap(),
            false => start(&mut command),
        };
        let minutes = Duration::from_secs(300);
        eventually("the solver is started for trial", minutes, || {
            processes_in(&temporary).len() == 2 // the script and what it has started
        });
        signal(child.id() as i32, by);
        let status = child.wait().unwrap();
        assert_eq!(status.code(), Some(130), "{command:?}");
        assert_eq!(left_in(&temporary), Vec::<String>::new());
        assert_eq!(processes_in(&temporary), Vec::<i32>::new());
        assert!(!out.exists());
    }
}

/// What is said at a signal before there is anything to save.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_signal_during_the_trial_start_promises_no_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let (programs, temporary) = (folder.path().join("bin"), folder.path().join("tmp"));
    let path = never_answers(&programs);
    std::fs::create_dir(&temporary).unwrap();
    let mut command = driver(&folder.path().join("run"), 1, &[]);
    command.env("PATH", path).env("TMPDIR", &temporary);
    let child = command.stderr(Stdio::piped()).spawn().unwrap();
    eventually("the trial", Duration::from_secs(300), || {
        processes_in(&temporary).len() == 2
    });
    signal(child.id() as i32, Signal::INT);
    let output = child.wait_with_output().unwrap();
    let said = text(&output);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(
        said.contains("interrupted: the start is given up"),
        "{said}"
    );
    assert!(
        said.ends_with("interrupted: nothing was written\n"),
        "{said}"
    );
    assert!(!said.contains("checkpoint"), "{said}");
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_signal_after_the_trial_start_ends_check_at_once() {
    let mut command = check(&[]);
    command
        .arg("--wall")
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    lines
        .find(|line| line.as_ref().unwrap().starts_with("memory"))
        .unwrap()
        .unwrap();
    signal(child.id() as i32, Signal::INT); // while the wall is put under pressure
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

fn left_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let name = |entry: std::io::Result<std::fs::DirEntry>| entry.unwrap().file_name();
    entries
        .map(|entry| name(entry).to_string_lossy().into_owned())
        .collect()
}
