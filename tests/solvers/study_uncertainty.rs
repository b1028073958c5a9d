//! Studies of uncertain inputs: samples, measures, what is exported, calibration, numerical uncertainty beside it.

use crate::run_support::*;
use crate::study::{STRAIGHT, cases, changed_at, processes_about, study};
use fsi_driver::case::MeasureTable;
use rustix::process::Signal;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

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
    let file = few.join("control.csv");
    let measure = "largest displacement / mm";
    let of_few = |head: &str| cell(&file, measure, head);
    let mean = cell(&out.join("moments.csv"), measure, "mean");
    let table = read(&file);
    assert!(
        (of_few("mean with control") / mean - 1.0).abs() < 1e-4,
        "{table}"
    );
    assert!((of_few("mean") / mean - 1.0).abs() > 1e-3, "{table}");
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

/// The cell of a table in the row that begins with `name`, in the column `head`.
fn cell(path: &Path, name: &str, head: &str) -> f64 {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let column = reader.headers().unwrap().iter().position(|h| h == head);
    let column = column.unwrap_or_else(|| panic!("{path:?} has no {head}"));
    let mut rows = reader.records().map(Result::unwrap);
    let row = rows.find(|row| &row[0] == name);
    let row = row.unwrap_or_else(|| panic!("{path:?} has no {name}"));
    row[column].replace('\u{2212}', "-").parse().unwrap()
}

/// The columns that a measure may name are all those with numbers that the tables of a run have, but for the time.
fn the_columns_are_those_of_a_run(run: &Path) {
    for table in [
        MeasureTable::History,
        MeasureTable::Openings,
        MeasureTable::Sections,
        MeasureTable::Regions,
    ] {
        let file = run.join(format!("{}.csv", table.name()));
        let mut reader = csv::Reader::from_path(&file).unwrap();
        let heads = reader.headers().unwrap();
        let named = ["time_s", "opening", "section", "region"];
        // Where the largest value is: a place is no figure.
        let places = ["_x_m", "_y_m", "_z_m", "_r_m", "_phi_deg"];
        let numbers = heads.iter().filter(|head| !named.contains(head));
        let numbers: Vec<_> = numbers
            .filter(|head| !places.iter().any(|place| head.ends_with(place)))
            .collect();
        assert_eq!(table.columns(), numbers, "{}", file.display());
    }
}

/// What a case asks for is a measure, also of runs that are done; and refined runs of it give the numerical uncertainty
/// beside that by the inputs.
#[test]
fn measures_of_a_case_and_the_numerical_uncertainty() {
    const PHASE: &str = "inlet pressure at 3 ms / Pa";
    const MOVED: &str = "largest displacement / mm";
    const SECTION: &str = "[[output.section]]\nname = \"middle\"\nat_m = 0.05\n";
    let folder = tempfile::tempdir().unwrap();
    let cases = cases(
        folder.path(),
        &[("own", &format!("{}{SECTION}", uncertain()))],
    );
    let case = cases.join("own");
    let native = &crate::native_run::FEW[..2];
    let run = |out: &Path, more: &[&str]| {
        let all = [native, more].concat();
        study(&case, out, 4, &all).output().unwrap()
    };
    let out = folder.path().join("out");
    let done = run(&out, &["--samples", "sobol:5"]);
    assert!(done.status.success(), "{}", text(&done));
    let at = changed_at(&out.join("own-003/history.csv"));

    let file = case.join("case.toml");
    let before = std::fs::read_to_string(&file).unwrap();
    let measures = format!(
        "[[output.measure]]\nname = \"{PHASE}\"\ncolumn = \"p_in_Pa\"\nof = \"at_phase\"\nphase = 0.003\n\
         [[output.measure]]\nname = \"outflow, range\"\ntable = \"openings\"\nat = \"outlet\"\ncolumn = \"flow_m3_s\"\n\
         of = \"range\"\n[[output.measure]]\nname = \"RRT\"\ntable = \"wall\"\nat = \"artery\"\ncolumn = \"RRT_1_Pa\"\n"
    );
    std::fs::write(&file, format!("{before}\n{measures}")).unwrap();
    let done = run(&out, &["--resume"]);
    assert!(done.status.success(), "{}", text(&done));
    assert_eq!(
        changed_at(&out.join("own-003/history.csv")),
        at,
        "nothing is computed again"
    );
    let mut history = csv::Reader::from_path(out.join("own-003/history.csv")).unwrap();
    let rows: Vec<BTreeMap<String, f64>> = history.deserialize().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 4);
    // The beat lasts a second: 3 ms lie between the first two steps of 2 ms.
    let pressure = |i: usize| rows[i]["p_in_Pa"];
    let expected = 0.5 * (pressure(0) + pressure(1));
    let found = cell(&out.join("measures.csv"), "own-003", PHASE);
    assert!(
        (found / expected - 1.0).abs() < 1e-4 && (found / pressure(2) - 1.0).abs() > 1e-3,
        "{found} {expected}"
    );
    the_columns_are_those_of_a_run(&out.join("own-003"));
    let outflow: Vec<f64> = rows.iter().map(|row| row["Q_out_m3_s"]).collect();
    let range = outflow.iter().copied().fold(f64::MIN, f64::max)
        - outflow.iter().copied().fold(f64::MAX, f64::min);
    let found = cell(&out.join("measures.csv"), "own-003", "outflow, range");
    assert!((found / range - 1.0).abs() < 1e-4, "{found} {range}");
    assert!(cell(&out.join("measures.csv"), "own-003", "RRT") > 0.0);
    assert!(cell(&out.join("moments.csv"), PHASE, "standard deviation") > 0.0);

    // The same case in steps of 2, 1 and 0.5 ms: its numerical uncertainty is that of Richardson's extrapolation.
    let refined = ["0.002", "0.001", "0.0005"].map(|step| {
        let out = folder.path().join(format!("step-{step}"));
        let mut run = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
        run.args(["--preset", "demo", "--end-time", "0.008", "--case"]);
        run.arg(&case).arg("--out").arg(&out).args(SMALL);
        run.args(native)
            .args(["--set", &format!("time.step_s={step}")]);
        complete(run);
        out.to_str().unwrap().to_owned()
    });
    let total = |series: &str, more: &[&str]| {
        run(&out, &[&["--resume", "--refined", series], more].concat())
    };
    let series = format!("time_step={}", refined.join(","));
    let done = total(&series, &["--measured", &format!("{MOVED}=0.01,0.002")]);
    assert!(done.status.success(), "{}", text(&done));
    let file = out.join("total-uncertainty.csv");
    let found = |head: &str| cell(&file, MOVED, head);
    let moved = |run: &String| {
        let mut history = csv::Reader::from_path(Path::new(run).join("history.csv")).unwrap();
        let rows = history.deserialize::<BTreeMap<String, f64>>();
        rows.map(|row| 1e3 * row.unwrap()["max_displacement_m"])
            .fold(0.0, f64::max)
    };
    let values = refined.each_ref().map(moved);
    let (first, second) = (values[1] - values[0], values[2] - values[1]);
    let decay = second / first;
    let (limit, left) = match decay > 0.0 && decay < 0.5_f64.sqrt() {
        true => (
            values[2] + second * decay / (1.0 - decay),
            1.25 * (second * decay / (1.0 - decay)).abs(),
        ),
        false => (
            values[2],
            first.abs().max(second.abs()).max((first + second).abs()),
        ),
    };
    assert!(
        (found("where refinement leads") / limit - 1.0).abs() < 1e-3,
        "{values:?}"
    );
    assert!(
        (found("u numerical") / (0.5 * left) - 1.0).abs() < 0.01,
        "{values:?} {}",
        found("u numerical")
    );
    let of_inputs = cell(
        &out.join("moments.csv"),
        MOVED,
        "standard deviation of the chaos",
    );
    assert!((found("u inputs") / of_inputs - 1.0).abs() < 0.01);
    let both = found("u numerical").hypot(found("u inputs"));
    assert!(
        (found("u both") / both - 1.0).abs() < 0.01
            && (found("95 %") / (2.0 * both) - 1.0).abs() < 0.01
    );
    assert!((found("error E") - (limit - 0.01)).abs() < 0.01 * (limit - 0.01).abs());
    assert!((found("u of E") / both.hypot(0.002) - 1.0).abs() < 0.01);

    let other = format!("time_step={},{}", refined[1], refined[2]);
    for (series, more, part) in [
        (&other, &[][..], "differs from the samples in time.step_s"),
        (
            &format!("time_step={}", refined[0]),
            &[],
            "two runs or more",
        ),
        (&series, &["--measured", "pressure=1,2"], "no such measure"),
        (
            &series,
            &["--measured", "largest displacement=1"],
            "expected MEASURE=VALUE,UNCERTAINTY",
        ),
    ] {
        let refused = total(series, more);
        assert_eq!(refused.status.code(), Some(2), "{}", text(&refused));
        assert!(text(&refused).contains(part), "{}", text(&refused));
    }
}
