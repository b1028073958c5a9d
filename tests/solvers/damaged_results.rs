//! Results that were damaged, lost, or asked for beyond what was computed: refused with their place, and nothing that
//! is good is replaced.

use crate::run_support::*;
use fsi_driver::output::wall_history::{WallHistory, WallHistoryReader};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn evaluate(out: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .arg("hemodynamics")
        .arg(out)
        .args(more)
        .output()
        .unwrap()
}

/// Content of the files of the evaluation.
fn evaluation(out: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = vec![out.join("hemodynamics.json"), out.join("wall-shear.csv")];
    files.push(out.join("wall-shear.pvd"));
    for file in std::fs::read_dir(out.join("wall-shear")).unwrap() {
        files.push(file.unwrap().path());
    }
    let read = |path: PathBuf| (path.clone(), std::fs::read(path).unwrap());
    files.into_iter().map(read).collect()
}

/// The message names the place.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_damaged_wall_is_refused_and_good_results_stay() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    complete(driver(&out, 6, &[]));
    let path = out.join("wall.bin");
    let (good, kept) = (std::fs::read(&path).unwrap(), evaluation(&out));
    let reader = WallHistoryReader::open(&path).unwrap();
    let record = 16 + 12 * (reader.wall.faces.len() + reader.wall.points.len());
    let head = good.len() - 6 * record;

    let with = |at: usize, bytes: &[u8]| {
        let mut damaged = good.clone();
        damaged[at..at + bytes.len()].copy_from_slice(bytes);
        damaged
    };
    let third = format!(
        "record 2 (bytes {} to {}), after t = 0.004 s: its checksum is wrong",
        head + 2 * record,
        head + 3 * record
    );
    let amid = head + 2 * record + 100;
    let short = good.len() * 6 / 100;
    let cut = format!(
        "its 2 whole records end at byte {} (t = 0.004 s), but history.csv has a step at t = 0.006 s",
        head + 2 * record
    );
    let begin = "is damaged";
    let cases = [
        (with(amid, &[0xff; 4096]), third.as_str()),
        (with(amid, &1e30_f32.to_le_bytes()), &third),
        (with(amid, &[good[amid] ^ 1]), &third),
        (with(1000, &[0xff; 64]), "has changed"),
        (good[..head + 2 * record + 7].to_vec(), &cut),
        (good[..short].to_vec(), begin),
        (Vec::new(), "it has 0 bytes, too few for its head"),
    ];
    for (bytes, expected) in cases {
        std::fs::write(&path, bytes).unwrap();
        let output = evaluate(&out, &[]);
        let said = text(&output);
        assert_eq!(output.status.code(), Some(2), "{expected}: {said}");
        assert!(said.contains(expected), "{expected}: {said}");
        assert!(
            said.contains("wall.bin") && said.contains("restore it"),
            "{said}"
        );
        assert!(evaluation(&out) == kept, "{expected}: results have changed");
    }
    std::fs::write(&path, &good).unwrap();

    // Beyond the run.
    let output = evaluate(&out, &["--from", "5", "--to", "6"]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    let expected = "no step in 5 s < t <= 6 s; it has reached t = 0.012 s";
    assert!(text(&output).contains(expected), "{}", text(&output));
    assert!(evaluation(&out) == kept);
    assert!(evaluate(&out, &[]).status.success());
    assert!(evaluation(&out) == kept);
    let left = std::fs::read_dir(&out).unwrap().flatten();
    let hidden = left.filter(|file| file.file_name().to_string_lossy().starts_with('.'));
    assert_eq!(hidden.count(), 0, "a temporary folder is left");

    // Without any shear, the relative residence time is infinite, and can be read and reported.
    let states: Vec<_> = WallHistoryReader::open(&path)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    let wall = WallHistoryReader::open(&path).unwrap().wall;
    let mut history = WallHistory::create(&path, &wall).unwrap();
    for mut state in states {
        state.shear.fill([0.0; 3]);
        history.append(&state).unwrap();
    }
    assert!(evaluate(&out, &[]).status.success());
    let json = std::fs::read_to_string(out.join("hemodynamics.json")).unwrap();
    assert!(
        json.contains("\"Infinity\"") && !json.contains("null"),
        "{json}"
    );
    for command in ["report", "hemodynamics"] {
        let output = Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
            .arg(command)
            .arg(&out)
            .output()
            .unwrap();
        assert!(output.status.success(), "{command}: {}", text(&output));
    }

    // Tables without a row make no page.
    let report = |page: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
        let output = command
            .arg("report")
            .arg(&out)
            .arg("--out")
            .arg(page)
            .output();
        let output = output.unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(!page.exists());
        text(&output)
    };
    let said = report(&folder.path().join("nowhere/page.html"));
    assert!(said.contains("there is no folder"), "{said}");
    for table in ["history.csv", "wall-shear.csv"] {
        let (path, page) = (out.join(table), folder.path().join("page.html"));
        let good = std::fs::read(&path).unwrap();
        for damaged in ["", "rubbish\n"] {
            std::fs::write(&path, damaged).unwrap();
            let said = report(&page);
            assert!(
                said.contains(table) && said.contains("holds no row"),
                "{said}"
            );
        }
        std::fs::write(&path, good).unwrap();
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn an_earlier_end_is_refused_at_resume() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    complete(driver(&out, 4, &[]));
    let kept = evaluation(&out);
    let case = std::fs::read(out.join("case.resolved.toml")).unwrap();
    let refused = driver(&out, 2, &["--resume"]).output().unwrap();
    let said = text(&refused);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    for part in [
        "time.end_s (--end-time): 0.004 s",
        "has reached t = 0.008 s",
    ] {
        assert!(said.contains(part), "{said}");
    }
    assert!(evaluation(&out) == kept);
    assert_eq!(std::fs::read(out.join("case.resolved.toml")).unwrap(), case);
    complete(driver(&out, 4, &["--resume"]));
    assert!(evaluation(&out) == kept);
}

/// A lost or damaged table is named and the run can go on with new ones.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn damaged_tables_are_named_and_replaceable() {
    let folder = tempfile::tempdir().unwrap();
    let (out, straight) = (folder.path().join("run"), folder.path().join("straight"));
    complete(driver(&straight, 6, &[]));
    complete(driver(&out, 4, &[]));
    let tables = ["history.csv", "iterations.csv", "regions.csv", "wall.bin"];
    let good = tables.map(|name| std::fs::read(out.join(name)).unwrap());
    let resume = |more: &[&str]| {
        driver(&out, 6, &[&["--resume"], more].concat())
            .output()
            .unwrap()
    };
    for (name, good) in tables.iter().zip(&good) {
        let mut changed = good.clone();
        changed[good.len() / 3] ^= 1;
        for bytes in [None, Some(&good[..good.len() / 2]), Some(&changed)] {
            match bytes {
                Some(bytes) => std::fs::write(out.join(name), bytes).unwrap(),
                None => std::fs::remove_file(out.join(name)).unwrap(),
            }
            let refused = resume(&[]);
            let said = text(&refused);
            assert_eq!(refused.status.code(), Some(2), "{name}: {said}");
            assert!(
                said.contains(name) && said.contains("--resume --new-tables"),
                "{said}"
            );
        }
        std::fs::write(out.join(name), good).unwrap();
    }
    std::fs::remove_file(out.join("regions.csv")).unwrap();
    std::fs::write(out.join("history.csv"), "rubbish").unwrap();
    let output = resume(&["--new-tables"]);
    assert!(output.status.success(), "{}", text(&output));
    let said = text(&output);
    assert!(said.contains("starts again: history.csv"), "{said}");
    assert!(said.contains("starts again: regions.csv"), "{said}");
    assert_eq!(
        std::fs::read(out.join("history.csv.damaged-1")).unwrap(),
        b"rubbish"
    );
    // The steps to come are those of the uninterrupted run.
    for (name, rows_a_step) in [("history.csv", 1), ("regions.csv", 3)] {
        let all = rows(&straight.join(name));
        assert_eq!(rows(&out.join(name)), all[4 * rows_a_step..], "{name}");
    }
    assert_eq!(
        rows(&out.join("iterations.csv")),
        rows(&straight.join("iterations.csv"))
    );
    let walls = [&out, &straight].map(|run| std::fs::read(run.join("wall.bin")).unwrap());
    assert!(walls[0] == walls[1]);
    // And it is an ordinary run again.
    complete(driver(&out, 7, &["--resume"]));

    // Lost before the first step: there is nothing to lose.
    let early = folder.path().join("early");
    let mut child = start(&mut driver(
        &early,
        1000,
        &["--set", "output.checkpoint_interval_min=9"],
    ));
    eventually(
        "the first checkpoint",
        std::time::Duration::from_secs(100),
        || newest_checkpoint(&early).is_some(),
    );
    child.kill().unwrap();
    child.wait().unwrap();
    eventually(
        "the solver has gone",
        std::time::Duration::from_secs(20),
        || processes_in(&early).is_empty(),
    );
    std::fs::remove_file(early.join("history.csv")).unwrap();
    complete(driver(&early, 1, &["--resume"]));
}
