//! A study of very small models with the real OpenFOAM: done, failed, interrupted, killed, resumed.

use crate::run_support::*;
use rustix::process::Signal;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime};

/// A folder of cases, each with these lines.
fn cases(folder: &Path, models: &[(&str, &str)]) -> PathBuf {
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

fn study(cases: &Path, out: &Path, steps: usize, more: &[&str]) -> Command {
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
fn processes_about(out: &Path) -> Vec<String> {
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

fn changed_at(path: &Path) -> SystemTime {
    std::fs::metadata(path).unwrap().modified().unwrap()
}

const STRAIGHT: &str = "[model]\nextension = \"straight\"\nd_max_m = 0.0";

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

/// A straight artery whose wall and compliance are not known.
fn uncertain() -> String {
    format!(
        "{STRAIGHT}\n[[uncertain]]\nname = \"wall\"\nkeys = [\"wall.media.mu_Pa\", \"wall.adventitia.mu_Pa\"]\n\
         distribution = \"normal\"\nvariation = 0.2\nlow = 0.5\nhigh = 1.5\n[[uncertain]]\nname = \"C\"\n\
         keys = [\"windkessel.compliance_m3_Pa\"]\ndistribution = \"uniform\"\nvariation = 0.1\n"
    )
}

/// A study that is killed has the same samples and numbers after it was resumed, to the last digit.
#[test]
fn a_killed_study_of_samples_has_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let cases = cases(folder.path(), &[("own", &uncertain())]);
    let native = &crate::native_run::FEW[..2];
    let run =
        |out: &Path, more: &[&str]| study(&cases.join("own"), out, 6, &[native, more].concat());
    let [whole, killed] = ["whole", "killed"].map(|name| folder.path().join(name));
    complete(run(&whole, &["--samples", "lhs:6"]));
    let mut command = run(&killed, &["--samples", "lhs:6", "--quiet"]);
    let mut child = command.stderr(Stdio::null()).spawn().unwrap();
    eventually("the third sample works", Duration::from_secs(200), || {
        steps_done(&killed.join("own-003")) > 0
    });
    signal(child.id() as i32, Signal::KILL);
    child.wait().unwrap();
    eventually("all processes are gone", Duration::from_secs(60), || {
        processes_about(&killed).is_empty()
    });
    assert!(!killed.join("own-006").exists() && !killed.join("indices.csv").exists());
    // The rest in two parts, as on two machines; the measures are of all.
    complete(run(&killed, &["--resume", "--part", "1/2"]));
    assert!(!killed.join("own-006").exists() && !killed.join("indices.csv").exists());
    complete(run(&killed, &["--resume", "--part", "2/2"]));
    complete(run(&killed, &["--resume"]));
    for file in [
        "samples.csv",
        "measures.csv",
        "moments.csv",
        "indices.csv",
        "wall-uncertainty.csv",
    ] {
        let [a, b] = [&whole, &killed].map(|out| std::fs::read_to_string(out.join(file)).unwrap());
        assert!(a.lines().count() > 2 && a == b, "{file}");
    }
}

/// Samples of uncertain inputs: the same after an interruption, more of them later, one that fails named and counted.
#[test]
fn samples_of_uncertain_inputs_resume_and_extend() {
    let folder = tempfile::tempdir().unwrap();
    let cases = cases(folder.path(), &[("own", &uncertain())]);
    let case = cases.join("own");
    let native = &crate::native_run::FEW[..2];
    let run = |out: &Path, more: &[&str]| {
        let all = [native, more].concat();
        study(&case, out, 3, &all).output().unwrap()
    };
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    let out = folder.path().join("out");
    let done = run(&out, &["--samples", "sobol:5"]);
    assert!(done.status.success(), "{}", text(&done));
    assert!(text(&done).contains("of 5 of 5 samples"), "{}", text(&done));
    let before = read(&out.join("samples.csv"));
    let heads = "name,wall.media.mu_Pa+wall.adventitia.mu_Pa,windkessel.compliance_m3_Pa";
    assert_eq!(before.lines().nth(1), Some(heads));
    assert!(
        before.starts_with("# sobol:5\n") && before.contains("\n001,*"),
        "{before}"
    );
    let at = changed_at(&out.join("own-003/history.csv"));

    // Three more, and one of the earlier ones is lost and computed again to the last digit.
    let lost = read(&out.join("own-002/regions.csv"));
    std::fs::remove_dir_all(out.join("own-002")).unwrap();
    let done = run(&out, &["--extend", "3", "--export", "salib,easyvvuq"]);
    assert!(done.status.success(), "{}", text(&done));
    let after = read(&out.join("samples.csv"));
    assert!(
        after.starts_with("# sobol:5+3\n") && after.lines().count() == 10,
        "{after}"
    );
    assert!(
        after
            .lines()
            .skip(1)
            .zip(before.lines().skip(1))
            .all(|(a, b)| a == b)
    );
    assert_eq!(changed_at(&out.join("own-003/history.csv")), at);
    assert_eq!(read(&out.join("own-002/regions.csv")), lost);

    // A softer wall moves further, and the compliance has little time to do anything in three steps.
    let indices = read(&out.join("indices.csv"));
    let row = |input: &str| -> Vec<f64> {
        let start = format!("\"largest displacement / mm\",\"{input}\",");
        let line = indices.lines().find_map(|line| line.strip_prefix(&start));
        let cells = line
            .unwrap_or_else(|| panic!("{input}: {indices}"))
            .split(',');
        cells.map(|cell| cell.parse().unwrap()).collect()
    };
    let (wall, compliance) = (row("wall"), row("C"));
    assert!(
        wall[0] > 0.9 && compliance[3] < 0.1,
        "{wall:?} {compliance:?}"
    );
    assert_eq!(wall[6], 8.0);
    assert!(read(&out.join("moments.csv")).lines().count() > 5);
    let page = Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .arg("report")
        .arg(&out)
        .output();
    assert!(page.unwrap().status.success());
    let html = read(&out.join("report.html"));
    assert!(html.contains("8 of 8 samples were used") && html.contains("Which input moves what"));
    assert!(html.contains("a polynomial of degree 1 of all inputs"));
    other_programs_and_calibration(&out);

    // Runs of the same cost: with them as control variates five samples have the mean of all eight.
    let few = folder.path().join("few");
    let control = ["--samples", "sobol:5", "--control", out.to_str().unwrap()];
    complete(study(&case, &few, 3, &[native, &control].concat()));
    let cells = |text: &str, measure: &str, head: &str| -> f64 {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let column = reader.headers().unwrap().iter().position(|h| h == head);
        let row = reader.records().map(Result::unwrap);
        let row = row.into_iter().find(|row| &row[0] == measure).unwrap();
        row[column.unwrap()].parse().unwrap()
    };
    let (table, all) = (
        read(&few.join("control.csv")),
        read(&out.join("moments.csv")),
    );
    let measure = "largest displacement / mm";
    let of_few = |head: &str| cells(&table, measure, head);
    let mean = cells(&all, measure, "mean");
    assert!(
        (of_few("mean with control") / mean - 1.0).abs() < 1e-4,
        "{table}{all}"
    );
    assert!((of_few("mean") / mean - 1.0).abs() > 1e-3, "{table}{all}");
    assert!(of_few("correlation") > 0.999_99, "{table}");
    assert!(
        (of_few("variance reduction") - 8.0 / 5.0).abs() < 1e-3,
        "{table}"
    );

    // One fails: it is named with its inputs, and the indices are of the others.
    std::fs::remove_dir_all(out.join("own-004")).unwrap();
    std::fs::write(out.join("own-004"), "a file where the run should be").unwrap();
    let failed = run(&out, &["--resume"]);
    let said = text(&failed);
    assert_eq!(failed.status.code(), Some(1), "{said}");
    assert!(
        said.contains("own-004 (wall = *") && said.contains("of 7 of 8 samples"),
        "{said}"
    );
    std::fs::remove_file(out.join("own-004")).unwrap();

    // Other inputs, or none, are refused before anything is written.
    let other = ["--resume", "--samples", "lhs:8"];
    for (more, part) in [
        (&other[..], "take back what has changed"),
        (&["--samples", "sobol:x"], "expected sobol:N"),
    ] {
        let refused = run(&out, more);
        assert_eq!(refused.status.code(), Some(2), "{}", text(&refused));
        assert!(text(&refused).contains(part), "{}", text(&refused));
    }
    assert_eq!(read(&out.join("samples.csv")), after);
    let nowhere = folder.path().join("nowhere");
    for (more, part) in [
        (&["--extend", "3"][..], "holds no samples.csv"),
        (
            &["--samples", "lhs:4", "--part", "5/5"],
            "--part 5/5: the study has fewer models",
        ),
        (&["--samples", "lhs:4", "--part", "5/4"], "expected K/N"),
        (
            &["--samples", "lhs:4", "--control", "nowhere"],
            "that folder holds no samples.csv",
        ),
        (
            &["--export", "salib"],
            "only a study of [[uncertain]] inputs",
        ),
        (&["--samples", "lhs:70000"], "expected sobol:N"),
    ] {
        let refused = run(&nowhere, more);
        assert_eq!(refused.status.code(), Some(2), "{}", text(&refused));
        assert!(
            text(&refused).contains(part) && !nowhere.exists(),
            "{}",
            text(&refused)
        );
    }
}

/// What is exported has the numbers of the tables, and a target in reach is met by the run that confirms it.
fn other_programs_and_calibration(out: &Path) {
    let driver = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
        command.args(arguments).output().unwrap()
    };
    let json = |name: &str| -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(out.join(name)).unwrap()).unwrap()
    };
    let measures = std::fs::read_to_string(out.join("measures.csv")).unwrap();
    let mut reader = csv::Reader::from_reader(measures.as_bytes());
    let column = (reader.headers().unwrap().iter())
        .position(|head| head == "largest displacement / mm")
        .unwrap();
    let moved: Vec<f64> = (reader.records())
        .map(|row| row.unwrap()[column].parse().unwrap())
        .collect();

    let salib = json("salib.json");
    assert_eq!(salib["problem"]["names"], serde_json::json!(["wall", "C"]));
    assert_eq!(
        salib["problem"]["dists"],
        serde_json::json!(["truncnorm", "unif"])
    );
    assert_eq!(
        salib["problem"]["bounds"][0],
        serde_json::json!([0.5, 1.5, 1.0, 0.2])
    );
    let of_salib = salib["Y"]["largest displacement / mm"].as_array().unwrap();
    assert_eq!(
        (of_salib.len(), salib["X"].as_array().unwrap().len()),
        (8, 8)
    );
    for (a, b) in of_salib.iter().zip(&moved) {
        assert!((a.as_f64().unwrap() / b - 1.0).abs() < 1e-5, "{a} {b}");
    }
    let of_run = json("easyvvuq/runs/own-003.json");
    assert_eq!(of_run["wall"], salib["X"][2][0]);
    assert_eq!(of_run["largest displacement / mm"], of_salib[2]);
    assert_eq!(json("easyvvuq/vary.json")["C"]["distribution"], "Uniform");
    assert!(
        json("easyvvuq/params.json")["wall"]["default"]
            .as_f64()
            .unwrap()
            > 0.9
    );

    let [low, high] = [f64::min, f64::max].map(|f| moved.iter().copied().reduce(f).unwrap());
    let target = low + 0.3 * (high - low);
    let found = driver(&[
        "calibrate",
        out.to_str().unwrap(),
        "--target",
        &format!("largest displacement={target}"),
        "--within",
        "0.01",
        "--quiet",
    ]);
    assert!(found.status.success(), "{}", text(&found));
    let said = text(&found);
    assert!(said.contains("all targets are met within 1.0 %"), "{said}");
    let history = std::fs::read_to_string(out.join("calibrated-1/history.csv")).unwrap();
    let mut reader = csv::Reader::from_reader(history.as_bytes());
    let column = (reader.headers().unwrap().iter())
        .position(|head| head == "max_displacement_m")
        .unwrap();
    let last = reader
        .records()
        .map(|row| row.unwrap()[column].parse::<f64>().unwrap());
    let reached = 1e3 * last.fold(0.0, f64::max);
    assert!(
        (reached / target - 1.0).abs() < 0.01,
        "{reached} of {target}"
    );

    for (target, part) in [
        ("largest movement=1", "no such measure; the study has: "),
        ("largest displacement", "expected MEASURE=VALUE"),
        ("largest displacement=0", "a number that is not 0"),
    ] {
        let refused = driver(&["calibrate", out.to_str().unwrap(), "--target", target]);
        assert_eq!(refused.status.code(), Some(2), "{}", text(&refused));
        assert!(text(&refused).contains(part), "{}", text(&refused));
    }
    assert!(!out.join("calibrated-2").exists());
    std::fs::remove_dir_all(out.join("calibrated-1")).unwrap();
}
