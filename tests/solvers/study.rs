//! A study of very small models with the real OpenFOAM: done, failed, interrupted, killed, resumed.

use crate::run_support::*;
use rustix::process::Signal;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime};

/// A folder of cases, each with these lines.
pub fn cases(folder: &Path, models: &[(&str, &str)]) -> PathBuf {
    let defaults = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/defaults.toml");
    let cases = folder.join("cases");
    for (name, lines) in models {
        let case = cases.join(name);
        std::fs::create_dir_all(&case).unwrap();
        let text = format!("extends = {defaults:?}\n{lines}\n");
        std::fs::write(case.join("case.toml"), text).unwrap();
    }
    cases
}

pub fn study(cases: &Path, out: &Path, steps: usize, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command
        .args(["study", "--preset", "demo", "--jobs", "2", "--cases"])
        .arg(cases)
        .arg("--out")
        .arg(out)
        .args(["--end-time", &format!("{:.3}", STEP * steps as f64)])
        .args(SMALL)
        .args(more);
    command
}

/// Drivers and solvers of the runs below `out`.
pub fn processes_about(out: &Path) -> Vec<String> {
    let words = |entry: std::fs::DirEntry| std::fs::read(entry.path().join("cmdline")).ok();
    let drivers = std::fs::read_dir("/proc")
        .unwrap()
        .flatten()
        .filter_map(words);
    let drivers = drivers.map(|words| String::from_utf8_lossy(&words).replace('\0', " "));
    let named = drivers.filter(|words| words.contains(&*out.to_string_lossy()));
    let solvers = processes_in(out)
        .into_iter()
        .map(|number| number.to_string());
    named.chain(solvers).collect()
}

pub fn changed_at(path: &Path) -> SystemTime {
    std::fs::metadata(path).unwrap().modified().unwrap()
}

pub const STRAIGHT: &str = "[model]\nextension = \"straight\"\nd_max_m = 0.0";

/// A model that fails does not stop the others and what is done is not done again.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_failed_model_does_not_stop_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let hopeless = format!("{STRAIGHT}\n[coupling]\ne_abs_m = 1e-14\nmax_iterations = 3");
    let models = [
        ("S-0", STRAIGHT),
        ("H-0", &hopeless),
        ("A-0", STRAIGHT),
        ("other", ""),
    ];
    let cases = cases(folder.path(), &models);
    let out = folder.path().join("study");

    let output = study(&cases, &out, 3, &[]).output().unwrap();
    let said = text(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("1 of 3 models failed") && said.contains("H-0: "),
        "{said}"
    );
    assert!(
        said.contains("attempts at this step failed") && said.contains("2 of 3 models done"),
        "{said}"
    );
    assert_eq!(
        [steps_done(&out.join("S-0")), steps_done(&out.join("A-0"))],
        [3, 3]
    );
    assert!(!out.join("other").exists());
    let refused = study(&cases, &out, 3, &[]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused).contains("--resume"), "{}", text(&refused));

    // An earlier end is no end: what is there has come farther, and stays as it is.
    let before = changed_at(&out.join("A-0/hemodynamics.json"));
    let refused = study(&cases, &out, 2, &["--resume"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused));
    let reason =
        "A-0: time.end_s (--end-time): 0.004 s, but the run to be resumed has reached t = 0.006 s";
    assert!(text(&refused).contains(reason), "{}", text(&refused));
    assert_eq!(changed_at(&out.join("A-0/hemodynamics.json")), before);

    // One case is mended, one is changed, one stays as it is.
    let before = changed_at(&out.join("A-0/history.csv"));
    let thicker = STRAIGHT.replace("0.0", "0.25e-3");
    self::cases(folder.path(), &[("H-0", STRAIGHT), ("S-0", &thicker)]);
    let output = complete(study(&cases, &out, 3, &["--resume"]));
    assert_eq!(changed_at(&out.join("A-0/history.csv")), before);
    assert!(
        text(&output).contains("S-0: its case has changed"),
        "{}",
        text(&output)
    );
    assert_eq!(steps_done(&out.join("S-0.before-1")), 3);
    assert_eq!(
        [steps_done(&out.join("S-0")), steps_done(&out.join("H-0"))],
        [3, 3]
    );
    assert!(processes_about(&out).is_empty());
}

/// An interrupted and a killed study leave no process and continue exactly.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn interrupted_studies_continue_exactly() {
    let folder = tempfile::tempdir().unwrap();
    let cases = cases(folder.path(), &[("S-0", STRAIGHT), ("A-0", STRAIGHT)]);
    let out = folder.path().join("study");
    let runs = ["S-0", "A-0"].map(|name| out.join(name));
    for (kind, code, more) in [
        (Signal::INT, Some(130), None),
        (Signal::KILL, None, Some("--resume")),
    ] {
        let mut command = study(&cases, &out, 1000, &["--quiet"]);
        let mut child = command.args(more).stderr(Stdio::null()).spawn().unwrap();
        let before = runs.each_ref().map(|run| steps_done(run));
        eventually("both models work", Duration::from_secs(200), || {
            let now = runs.each_ref().map(|run| steps_done(run));
            child.try_wait().unwrap().is_some() || now[0] > before[0] && now[1] > before[1]
        });
        signal(child.id() as i32, kind);
        assert_eq!(child.wait().unwrap().code(), code);
        // After a kill, the runs finish their step by themselves.
        eventually("all processes are gone", Duration::from_secs(60), || {
            processes_about(&out).is_empty()
        });
        for run in &runs {
            assert_eq!(
                newest_checkpoint(run),
                Some(steps_done(run)),
                "{}",
                run.display()
            );
        }
    }
    let steps = runs.iter().map(|run| steps_done(run)).max().unwrap() + 2;
    complete(study(&cases, &out, steps, &["--resume"]));
    let straight = folder.path().join("straight");
    complete(study(&cases, &straight, steps, &["--models", "A-*"]));
    assert_same_run(&out.join("A-0"), &straight.join("A-0"));
}

/// A sweep leaves a table of parameters and measures and refuses keys that do nothing.
#[test]
fn sweep_writes_measures_and_refuses_idle_keys() {
    let folder = tempfile::tempdir().unwrap();
    let cases = cases(folder.path(), &[("own", STRAIGHT)]);
    let out = folder.path().join("out");
    let native = &crate::native_run::FEW[..2];
    let sweep = |out: &Path, more: &[&str]| {
        let all = [native, more].concat();
        study(&cases.join("own"), out, 3, &all).output().unwrap()
    };
    let done = sweep(
        &out,
        &[
            "--one-at-a-time",
            "--sweep",
            "wall.media.mu_Pa+wall.adventitia.mu_Pa=*0.5",
            "--sweep",
            "windkessel.compliance_m3_Pa=*2",
        ],
    );
    assert!(done.status.success(), "{}", text(&done));
    let mut reader = csv::Reader::from_path(out.join("measures.csv")).unwrap();
    let heads: Vec<String> = reader
        .headers()
        .unwrap()
        .iter()
        .map(str::to_owned)
        .collect();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(
        heads[..4],
        [
            "case",
            "wall.adventitia.mu_Pa",
            "wall.media.mu_Pa",
            "windkessel.compliance_m3_Pa"
        ]
    );
    let cells: Vec<[&str; 4]> = rows
        .iter()
        .map(|row| [0, 1, 2, 3].map(|i| &row[i]))
        .collect();
    assert_eq!(
        cells,
        [
            ["own", "5400.0", "54000.0", "1.83e-10"],
            ["own-mu_Pa=x0.5", "2700.0", "27000.0", "1.83e-10"],
            ["own-compliance_m3_Pa=x2", "5400.0", "54000.0", "3.66e-10"],
        ]
    );
    let displacement = heads
        .iter()
        .position(|head| head == "largest displacement / mm")
        .unwrap();
    let moved: Vec<f64> = rows
        .iter()
        .map(|row| row[displacement].parse().unwrap())
        .collect();
    assert!(moved[1] > 1.2 * moved[0], "a softer wall: {moved:?}");
    let page = Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .arg("report")
        .arg(&out)
        .output()
        .unwrap();
    assert!(page.status.success(), "{}", text(&page));
    let html = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(html.contains("largest displacement / mm over windkessel.compliance_m3_Pa."));

    let samples = folder.path().join("samples.csv");
    std::fs::write(&samples, "name,inflow.base_m3_s\nless,*0.5\n").unwrap();
    let sampled = folder.path().join("sampled");
    let done = sweep(&sampled, &["--samples", samples.to_str().unwrap()]);
    assert!(done.status.success(), "{}", text(&done));
    assert!(sampled.join("own-less/history.csv").is_file());

    let nowhere = folder.path().join("nowhere");
    let refused = sweep(&nowhere, &["--sweep", "geometry.helix_radius_m=*2,*3"]);
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused));
    let part = "`geometry.helix_radius_m` (--sweep) does nothing here";
    assert!(
        text(&refused).contains(part) && !nowhere.exists(),
        "{}",
        text(&refused)
    );
}
