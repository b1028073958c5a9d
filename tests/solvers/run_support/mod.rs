//! Very small coupled runs for tests of what happens when they are disturbed: 1280 cells, steps of a tenth of a second.
#![allow(dead_code)] // each test file uses a part

pub use crate::file_support::copy;
use rustix::process::{Pid, Signal, kill_process};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

pub const STEP: f64 = 0.002;
/// Makes the preset `demo` that small.
pub const SMALL: [&str; 4] = [
    "--set",
    "fluid.mesh.axial_extension=4",
    "fluid.mesh.axial_per_section=6",
    "structure.axial_per_section=2",
];

/// Files and checkpoints often.
const OFTEN: [&str; 2] = [
    "output.structure_interval_s=0.01",
    "output.checkpoint_interval_min=0",
];

/// `--set` and those of these settings whose keys `more` does not set itself: a key is given once.
pub fn unless_set<'a>(settings: &[&'a str], more: &[&str]) -> Vec<&'a str> {
    let key = |setting: &str| setting.split('=').next().unwrap().to_owned();
    let open = settings
        .iter()
        .filter(|setting| !more.iter().any(|other| key(other) == key(setting)));
    let open: Vec<&str> = open.copied().filter(|word| *word != "--set").collect();
    [&["--set"][..], &open].concat()
}

/// A run in the folder `out`.
pub fn driver(out: &Path, steps: usize, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["--case", "tests/cases/S-0.25", "--preset", "demo"])
        .arg("--out")
        .arg(out)
        .args(["--end-time", &format!("{:.3}", STEP * steps as f64)])
        .args(unless_set(&[&SMALL[..], &OFTEN].concat(), more))
        .args(more);
    command
}

/// Runs to the end, which must be a good one.
pub fn complete(mut command: Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    output
}

pub fn text(output: &Output) -> String {
    format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}

/// Replaces what a file has.
pub fn edit(file: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(file).unwrap();
    assert!(text.contains(from), "{} has no {from:?}", file.display());
    fs::write(file, text.replace(from, to)).unwrap();
}

/// Starts in the background.
pub fn start(command: &mut Command) -> Child {
    command
        .arg("--quiet")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Rows of a CSV file without its wall-clock columns, as text: equal means equal to the last digit.
pub fn rows(path: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let clocks = ["fluid_s", "structure_s", "coupling_s", "wall_s"];
    let headers = reader.headers().unwrap().clone();
    let row = |row: csv::StringRecord| {
        let cells = headers.iter().zip(&row);
        let kept = cells.filter(|(name, _)| !clocks.contains(name));
        kept.map(|(name, cell)| format!("{name}={cell}")).collect()
    };
    reader.records().map(|r| row(r.unwrap())).collect()
}

/// Both runs must have left the same.
pub fn assert_same_run(a: &Path, b: &Path) {
    for file in ["wall.bin", "hemodynamics.json", "wall-shear.csv"] {
        let [x, y] = [a, b].map(|run| std::fs::read(run.join(file)).unwrap());
        assert!(x == y, "{file} differs");
    }
    let has_sections = a.join("sections.csv").is_file();
    let tables = [
        "history.csv",
        "iterations.csv",
        "regions.csv",
        "openings.csv",
    ];
    let sections = has_sections.then_some("sections.csv");
    for file in tables.into_iter().chain(sections) {
        let (x, y) = (rows(&a.join(file)), rows(&b.join(file)));
        for (i, (x, y)) in x.iter().zip(&y).enumerate() {
            assert_eq!(x, y, "{file}, row {i}");
        }
        assert_eq!(x.len(), y.len(), "{file}");
    }
}

/// Accepted steps in the history so far.
pub fn steps_done(out: &Path) -> usize {
    let text = std::fs::read(out.join("history.csv")).unwrap_or_default();
    let lines = text.iter().filter(|byte| **byte == b'\n').count();
    lines.saturating_sub(1)
}

/// Step of the newest checkpoint.
pub fn newest_checkpoint(out: &Path) -> Option<usize> {
    let files = std::fs::read_dir(out.join("checkpoints")).ok()?;
    let step = |path: PathBuf| {
        path.file_name()?
            .to_str()?
            .strip_suffix(".checkpoint")?
            .parse()
            .ok()
    };
    files.filter_map(|file| step(file.ok()?.path())).max()
}

/// Numbers of the processes that work in a folder below `root`.
pub fn processes_in(root: &Path) -> Vec<i32> {
    let Ok(root) = root.canonicalize() else {
        return Vec::new();
    };
    let number = |entry: std::fs::DirEntry| {
        let cwd = std::fs::read_link(entry.path().join("cwd")).ok()?;
        let name = entry.file_name();
        cwd.starts_with(&root)
            .then(|| name.to_str()?.parse().ok())?
    };
    let all = std::fs::read_dir("/proc").unwrap().flatten();
    all.filter_map(number).collect()
}

pub fn signal(process: i32, signal: Signal) {
    let _ = kill_process(Pid::from_raw(process).unwrap(), signal);
}

pub fn eventually(what: &str, limit: Duration, mut condition: impl FnMut() -> bool) {
    let since = Instant::now();
    while !condition() {
        assert!(since.elapsed() < limit, "{what}: not within {limit:?}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

pub fn wait_for_steps(child: &mut Child, out: &Path, steps: usize) {
    eventually("the steps are done", Duration::from_secs(300), || {
        child.try_wait().unwrap().is_some() || steps_done(out) >= steps
    });
}
