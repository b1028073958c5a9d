//! Runs and studies of vessels with a random lumen.

use crate::native_run::{FEW, Row, history};
use crate::run_support::*;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The field of four modes over the artery.
const RANDOM: &str = "[random_lumen]\nstandard_deviation_m = 0.2e-3\nlength_along_m = 0.01\nangle_around_deg = 120.0\nfrom_m = 0.03\n\
                      to_m = 0.06\nmodes = 4\n";
const INPUT: &str = "[[uncertain]]\nname = \"lumen\"\nkeys = [\"random_lumen.amplitudes\"]\ndistribution = \"standard_normal\"\n";

/// A straight model with these tables.
fn case(folder: &Path, name: &str, tables: &str) -> PathBuf {
    let defaults = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/defaults.toml");
    let case = folder.join(name);
    std::fs::create_dir(&case).unwrap();
    let text = format!("extends = {defaults:?}\n{tables}\n");
    std::fs::write(case.join("case.toml"), text).unwrap();
    case
}

fn command(word: &[&str], case: &Path, out: &Path, steps: usize, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command
        .args(word)
        .arg(case)
        .arg("--out")
        .arg(out)
        .args([
            "--preset",
            "demo",
            "--end-time",
            &format!("{:.3}", STEP * steps as f64),
        ])
        .args(FEW)
        .args([
            "structure.axial_per_section=2",
            "output.checkpoint_interval_min=0",
        ])
        .args(more);
    command.output().unwrap()
}

/// With all amplitudes zero a run is the one without the table, to the last digit; with others it is not, and has the
/// same digits when it is resumed.
#[test]
fn zero_amplitudes_give_the_same_history() {
    let folder = tempfile::tempdir().unwrap();
    let case = |name: &str, tables: &str| case(folder.path(), name, tables);
    let [smooth, zero, random] = [
        case("smooth", ""),
        case("zero", RANDOM),
        case(
            "random",
            &format!("{RANDOM}amplitudes = [1.0, -0.5, 0.4]\n"),
        ),
    ];
    let out = |name: &str| folder.path().join(format!("run-{name}"));
    let run = |case: &Path, name: &str, steps: usize, more: &[&str]| {
        let done = command(&["--case"], case, &out(name), steps, more);
        assert!(done.status.success(), "{}", text(&done));
    };
    run(&smooth, "smooth", 3, &[]);
    run(&zero, "zero", 3, &[]);
    run(&random, "random", 3, &[]);
    run(&random, "again", 1, &[]);
    run(&random, "again", 3, &["--resume"]);
    assert_same_run(&out("zero"), &out("smooth"));
    assert_same_run(&out("again"), &out("random"));
    let [random, smooth] = ["random", "smooth"].map(|name| history(&out(name)));
    let last = |rows: &[Row]| rows.last().unwrap().volume;
    // The first mode is a bulge of the artery.
    let wider = last(&random) / last(&smooth) - 1.0;
    assert!((0.005..0.1).contains(&wider), "{wider}");
}

/// Each mode is an input of the study, of its tables and its page; samples that were lost come back to the last digit.
#[test]
fn a_study_samples_each_mode() {
    let folder = tempfile::tempdir().unwrap();
    let case = case(folder.path(), "own", &format!("{RANDOM}{INPUT}"));
    let out = folder.path().join("out");
    let study = |more: &[&str]| {
        command(
            &["study", "--jobs", "2", "--quiet", "--cases"],
            &case,
            &out,
            2,
            more,
        )
    };
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let done = study(&["--samples", "sobol:5"]);
    assert!(done.status.success(), "{}", text(&done));
    let samples = read("samples.csv");
    let heads: Vec<String> = (0..4)
        .map(|i| format!("random_lumen.amplitudes[{i}]"))
        .collect();
    let lines: Vec<&str> = samples.lines().collect();
    assert_eq!(lines[1], format!("name,{}", heads.join(",")));
    let all = lines[2..].iter().flat_map(|line| line.split(',').skip(1));
    let all: Vec<f64> = all.map(|cell| cell.parse().unwrap()).collect();
    assert!(
        all.len() == 20 && all.iter().all(|x| x.abs() <= 3.0),
        "{all:?}"
    );
    assert!(all.iter().any(|x| x.abs() > 1.0), "{all:?}");
    let record = read("own-002/case.resolved.toml");
    let amplitudes: Vec<&str> = lines[3].split(',').skip(1).collect();
    assert!(
        record.contains(&format!("amplitudes = [{}]", amplitudes.join(", "))),
        "{record}"
    );
    // A mode that is wider moves the volume; that is seen with so few samples already.
    let indices = read("indices.csv");
    for i in 1..=4 {
        assert!(indices.contains(&format!("\"lumen {i}\"")), "{indices}");
    }
    let lost = read("own-002/regions.csv");
    std::fs::remove_dir_all(out.join("own-002")).unwrap();
    let done = study(&["--extend", "1"]);
    assert!(done.status.success(), "{}", text(&done));
    assert_eq!(read("own-002/regions.csv"), lost);
    let page = Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .arg("report")
        .arg(&out)
        .output();
    assert!(page.unwrap().status.success());
    let html = read("report.html");
    assert!(html.contains("6 of 6 samples were used") && html.contains("lumen 4"));
}

/// A sample whose lumen would close is named and counts as failed; the others run.
#[test]
fn a_sample_that_cannot_be_run_counts_as_failed() {
    let folder = tempfile::tempdir().unwrap();
    let random = RANDOM.replace("0.2e-3", "0.5e-3");
    let case = case(folder.path(), "own", &format!("{random}{INPUT}"));
    let out = folder.path().join("out");
    let study = |more: &[&str]| {
        let word = ["study", "--jobs", "2", "--quiet", "--cases"];
        command(&word, &case, &out, 1, more)
    };
    let done = study(&["--samples", "sobol:6"]);
    let said = text(&done);
    assert_eq!(done.status.code(), Some(1), "{said}");
    let part = "samples cannot be run, and count as failed";
    let count = said.split(" of 6 ").next().unwrap();
    let count: usize = count.rsplit(' ').next().unwrap().parse().unwrap();
    assert!((1..=4).contains(&count) && said.contains(part), "{said}");
    assert!(
        said.contains(&format!(
            "indices and moments are of {} of 6 samples",
            6 - count
        )),
        "{said}"
    );
    let runs = (1..=6).filter(|i| out.join(format!("own-00{i}")).exists());
    assert_eq!(runs.count(), 6 - count, "{said}");
    // Each is named with its inputs and the reason.
    let named = said
        .lines()
        .filter(|line| line.contains("(lumen 1 = ") && line.contains("`random_lumen"));
    assert_eq!(named.count(), 2 * count, "{said}");
    let again = study(&["--resume"]);
    assert!(text(&again).contains(part), "{}", text(&again));
}
