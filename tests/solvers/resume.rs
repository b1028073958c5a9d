//! Runs that are stopped, resumed, extended, or must not be.

use crate::run_support::*;
use rustix::process::Signal;
use std::path::Path;
use std::time::{Duration, Instant};

/// This holds for the newest checkpoint and for the one before.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn an_extended_run_is_the_longer_run() {
    let folder = tempfile::tempdir().unwrap();
    let (straight, resumed) = (
        folder.path().join("straight"),
        folder.path().join("resumed"),
    );
    complete(driver(
        &straight,
        16,
        &["--set", "output.checkpoint_interval_min=5"],
    ));
    complete(driver(&resumed, 8, &[]));

    // A machine that was switched off: the newest checkpoint is cut off, and a file of the fluid.
    let newest = resumed.join("checkpoints/00000008.checkpoint");
    let bytes = std::fs::read(&newest).unwrap();
    std::fs::write(&newest, &bytes[..bytes.len() - 1]).unwrap();
    let output = complete(driver(&resumed, 12, &["--resume"]));
    assert!(text(&output).contains("passed over"), "{}", text(&output));
    assert!(text(&output).contains("7 steps"), "{}", text(&output));
    std::fs::write(resumed.join("openfoam/0.024/U"), "").unwrap();
    assert!(!text(&output).contains("computed by"), "{}", text(&output));
    let summary = std::fs::read_to_string(resumed.join("summary.json")).unwrap();
    let before = summary.replace("\"openfoam\": \"", "\"openfoam\": \"2406 and ");
    std::fs::write(resumed.join("summary.json"), before).unwrap();
    let output = complete(driver(&resumed, 16, &["--resume"]));
    let warned = text(&output).contains("computed by OpenFOAM 2406 and ");
    assert!(warned, "{}", text(&output));
    assert!(text(&output).contains("0.024/U"), "{}", text(&output));
    assert!(text(&output).contains("11 steps"), "{}", text(&output));
    assert_same_run(&resumed, &straight);

    // Only what was asked for and what the checkpoints need is kept.
    let mut times: Vec<String> = std::fs::read_dir(resumed.join("openfoam"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| name.starts_with('0'))
        .collect();
    times.sort();
    assert_eq!(times, ["0", "0.02", "0.03", "0.032"]);

    let other = driver(&resumed, 16, &["--resume", "--set", "coupling.e_rel=1e-4"])
        .output()
        .unwrap();
    assert_eq!(other.status.code(), Some(2));
    let expected = "coupling.e_rel: 0.00001 in the run, 0.0001 now";
    assert!(text(&other).contains(expected), "{}", text(&other));
    assert_same_run(&resumed, &straight);
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_signal_saves_the_last_step_a_second_one_ends_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let seldom = ["--set", "output.checkpoint_interval_min=5"];
    for (i, kind) in [Signal::TERM, Signal::HUP, Signal::INT]
        .into_iter()
        .enumerate()
    {
        let mut command = driver(&out, 1000, &seldom);
        if i > 0 {
            command.arg("--resume");
        }
        let mut child = start(&mut command);
        let before = steps_done(&out);
        wait_for_steps(&mut child, &out, before + 2);
        signal(child.id() as i32, kind);
        assert_eq!(child.wait().unwrap().code(), Some(130));
        assert_eq!(newest_checkpoint(&out), Some(steps_done(&out)), "{kind:?}");
        assert!(processes_in(&out).is_empty());
    }
    let mut child = start(driver(&out, 1000, &seldom).arg("--resume"));
    let before = steps_done(&out);
    wait_for_steps(&mut child, &out, before + 1);
    // Amid a step, which a stopped solver never ends.
    processes_in(&out)
        .into_iter()
        .for_each(|p| signal(p, Signal::STOP));
    signal(child.id() as i32, Signal::INT);
    std::thread::sleep(Duration::from_millis(300));
    assert!(
        child.try_wait().unwrap().is_none(),
        "one signal waits for the step"
    );
    signal(child.id() as i32, Signal::INT);
    let since = Instant::now();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(since.elapsed() < Duration::from_secs(1));
    eventually("the solver has gone", Duration::from_secs(5), || {
        processes_in(&out).is_empty()
    });
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn two_processes_cannot_work_in_the_folder_of_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let mut child = start(&mut driver(&out, 1000, &[]));
    wait_for_steps(&mut child, &out, 1);
    for how in ["--force", "--resume"] {
        let output = driver(&out, 1000, &[how]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        let name = format!("process {}", child.id());
        assert!(text(&output).contains(&name), "{}", text(&output));
    }
    let before = steps_done(&out);
    wait_for_steps(&mut child, &out, before + 1);
    child.kill().unwrap();
    child.wait().unwrap();
    complete(driver(&out, 1, &["--force"]));
}

/// A step that never converges ends the run after all attempts and can be resumed.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_step_that_never_converges_ends_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let hopeless = [
        "--set",
        "coupling.e_abs_m=1e-14",
        "coupling.max_iterations=3",
        "time.max_halvings=1",
    ];
    let output = driver(&out, 3, &hopeless).output().unwrap();
    let said = text(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    for part in [
        "step 1 ",
        "All 4 attempts",
        "residual",
        "--resume continues from",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let iterations = rows(&out.join("iterations.csv"));
    let attempts: Vec<&str> = iterations.iter().map(|row| row[1].as_str()).collect();
    assert_eq!(attempts.iter().filter(|a| **a == "attempt=4").count(), 3);
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    assert!(summary.contains("\"failed_attempts\": 4"), "{summary}");
    let again = [
        "--resume",
        "--set",
        "coupling.e_abs_m=1e-14",
        "coupling.max_iterations=60",
    ];
    complete(driver(&out, 3, &again));
}

/// A small file system in memory.
struct SmallDisk(tempfile::TempDir);

impl SmallDisk {
    /// None without the right to mount.
    fn new(megabytes: usize) -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let size = format!("size={megabytes}m");
        let mounted = std::process::Command::new("mount")
            .args(["-t", "tmpfs", "-o", &size, "tmpfs"])
            .arg(folder.path())
            .output();
        let mounted = mounted.is_ok_and(|output| output.status.success());
        mounted.then_some(Self(folder))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = std::process::Command::new("umount")
            .arg("-l")
            .arg(self.0.path())
            .output();
    }
}

/// The full disk is reported, and the run goes on once there is space.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_run_continues_after_a_full_disk() {
    let Some(disk) = SmallDisk::new(16) else {
        println!("not tested: mounting a small file system needs root");
        return;
    };
    let (out, ballast) = (disk.0.path().join("run"), disk.0.path().join("ballast"));
    let straight = tempfile::tempdir().unwrap();
    complete(driver(&straight.path().join("run"), 12, &[]));

    let mut child = start(&mut driver(&out, 12, &[]));
    wait_for_steps(&mut child, &out, 3);
    // As much as there is.
    let _ = std::fs::write(&ballast, vec![1; 32 << 20]);
    assert_eq!(child.wait().unwrap().code(), Some(1));
    assert!(processes_in(&out).is_empty());
    let still = driver(&out, 12, &["--resume"]).output().unwrap();
    assert!(!still.status.success());
    let said = text(&still);
    println!("{said}");
    assert!(
        said.contains("No space left on device") || said.contains("is the disk full?"),
        "{said}"
    );
    std::fs::remove_file(ballast).unwrap();
    complete(driver(&out, 12, &["--resume"]));
    assert_same_run(&out, &straight.path().join("run"));
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_folder_may_have_a_blank_in_its_name_but_no_quotes() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("my runs/first");
    complete(driver(&out, 1, &[]));
    complete(driver(
        &out,
        2,
        &["--resume", "--set", "fluid.transport=\"files\""],
    ));
    let quoted = folder.path().join("Jane's runs/first");
    let refused = driver(&quoted, 1, &[]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        text(&refused).contains("no path with quotes"),
        "{}",
        text(&refused)
    );
    assert!(!quoted.exists());
}

/// What an ended solver has half written is not taken for the next ones.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn half_written_files_are_not_taken() {
    let folder = tempfile::tempdir().unwrap();
    let (straight, resumed) = (
        folder.path().join("straight"),
        folder.path().join("resumed"),
    );
    complete(driver(&straight, 6, &[]));
    complete(driver(&resumed, 3, &[]));
    // OpenFOAM writes this file when the step after the one that it belongs to begins.
    let late = |time: &str| {
        let time = resumed.join("openfoam").join(time);
        time.join("uniform/functionObjects/functionObjectProperties")
    };
    let whole = std::fs::read(late("0.006")).unwrap();
    for (time, length) in [("0.006", 700), ("0.008", 0)] {
        std::fs::create_dir_all(late(time).parent().unwrap()).unwrap();
        std::fs::write(late(time), &whole[..length]).unwrap();
    }
    complete(driver(&resumed, 6, &["--resume"]));
    assert_same_run(&resumed, &straight);
}

/// The result comes closer to what short steps give.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_step_that_fails_is_cut() {
    let folder = tempfile::tempdir().unwrap();
    let run = |name: &str, step: &str, newton: usize| {
        let out = folder.path().join(name);
        let seldom = "output.structure_interval_s=0.04";
        let mut command = driver(&out, 20, &["--set", "ramp.duration_s=0.1", seldom]);
        // A gentle load, so that the time step is what the result depends on.
        command.args(["--set", "windkessel.initial_pressure_Pa=1.07e4"]);
        command.args([
            "--set",
            "coupling.e_rel=1e-7",
            &format!("time.step_s={step}"),
        ]);
        command.arg(format!("structure.newton_max_iterations={newton}"));
        complete(command);
        out
    };
    let numbers = |out: &Path, column: &str| -> Vec<f64> {
        let cells = rows(&out.join("history.csv")).into_iter().flatten();
        let mine = cells.filter_map(|cell| Some(cell.strip_prefix(column)?.parse().unwrap()));
        mine.collect()
    };
    let last = |out: &Path, column: &str| *numbers(out, column).last().unwrap();

    let long = run("long", "0.02", 25);
    assert_eq!(numbers(&long, "time_s="), [0.02, 0.04]);
    let short = run("short", "0.005", 25);
    // Too few Newton iterations for a long step; how many are too few is the structure's business.
    let cut = (1..=5)
        .rev()
        .map(|newton| run(&format!("cut-{newton}"), "0.02", newton))
        .find(|out| numbers(out, "time_s=").len() >= 4)
        .expect("both long steps fail if the structure may hardly iterate");
    let times = numbers(&cut, "time_s=");
    assert!((times[times.len() - 1] - 0.04).abs() < 1e-12, "{times:?}");
    for column in ["Q_out_m3_s=", "p_out_Pa="] {
        let [long, cut, short] = [&long, &cut, &short].map(|out| last(out, column));
        // The short step is a quarter of the long one. Long steps that succeeded keep their error: measured 0.51.
        assert!(
            (cut - short).abs() < 0.6 * (long - short).abs(),
            "{column} {long} in long steps, {cut} where they failed, {short} in short steps"
        );
    }
    // Every row knows how long its step was.
    let [inflow, outflow, growth] =
        ["Q_in_m3_s=", "Q_out_m3_s=", "dVdt_m3_s="].map(|name| numbers(&cut, name));
    for i in 0..times.len() {
        let gap = inflow[i] - outflow[i] - growth[i];
        assert!(
            gap.abs() < 1e-3 * growth[i].abs(),
            "{gap} m3/s at {} s",
            times[i]
        );
    }
    let summary = std::fs::read_to_string(cut.join("summary.json")).unwrap();
    assert!(summary.contains("\"steps\": 2"), "{summary}");
    assert!(summary.contains("\"fluid_restarts\": 0"), "{summary}");
    assert!(!summary.contains("\"failed_attempts\": 0"), "{summary}");
}
