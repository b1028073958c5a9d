//! Coupled runs with the driver's own solver for the blood.

use crate::run_support::*;
use rustix::process::Signal;
use std::collections::HashMap;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Few elements of degree 3.
pub const FEW: [&str; 7] = [
    "--fluid",
    "native",
    "--set",
    "fluid.native.degree=3",
    "fluid.native.core=1",
    "fluid.native.axial_extension=2",
    "fluid.native.axial_per_section=2",
];

/// On a machine without OpenFOAM: not even a shell is found.
fn alone(out: &Path, steps: usize, more: &[&str]) -> Command {
    let mut command = driver(out, steps, &[&FEW, more].concat());
    command.env("PATH", "");
    command
}

#[test]
fn a_resumed_native_run_is_the_uninterrupted_one() {
    let folder = tempfile::tempdir().unwrap();
    let [straight, resumed] = ["straight", "resumed"].map(|name| folder.path().join(name));
    let watched = "output.fluid_probes_m=[[0.01, 0.001, 0.0], [0.059, 0.0, -0.0011]]";
    complete(alone(&straight, 6, &[watched]));
    complete(alone(&resumed, 2, &[watched]));
    complete(alone(&resumed, 4, &[watched, "--resume"]));
    complete(alone(&resumed, 6, &[watched, "--resume"]));
    assert_same_run(&resumed, &straight);
    let probes = [&straight, &resumed].map(|run| rows(&run.join("fluid-probes.csv")));
    assert_eq!(probes[0], probes[1]);
    assert_eq!(probes[0].len(), 12);
    assert!(!straight.join("openfoam").exists());

    // What goes in and does not come out is in the vessel, to the last digits.
    let history = history(&straight);
    for row in &history {
        let kept = row.inflow - row.outflow;
        let error = (row.volume_rate - kept).abs() / row.volume_rate.abs();
        assert!(error < 1e-6, "at t = {}: {error:e}", row.time);
    }
    assert_eq!(history.len(), 6);
    regions_have_the_volume_of_the_whole(&straight);
}

/// Beats of six steps, from equilibrium: it ends with the first that is like the one before, also if it is stopped on
/// the way or loses its last step, and goes on where less of a difference counts.
#[test]
fn a_run_until_it_is_periodic_ends_alike_when_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let [straight, resumed] = ["straight", "resumed"].map(|name| folder.path().join(name));
    let beats = [
        "time.period_s=0.012",
        "inflow.systole_s=0.006",
        "ramp.duration_s=0.006",
        "initial.start=equilibrium",
        "windkessel.initial_pressure_Pa=1.3e4",
        "structure.time_scheme=bossak",
        "time.until_periodic=LIMIT",
    ];
    let run = |out: &Path, steps: usize, limit: &str, more: &[&str]| {
        let beats = beats.map(|setting| setting.replace("LIMIT", limit));
        let beats: Vec<&str> = beats.iter().map(String::as_str).collect();
        complete(alone(out, steps, &[&beats, more].concat()))
    };
    let summary = |out: &Path| -> serde_json::Value {
        let text = std::fs::read(out.join("summary.json")).unwrap();
        serde_json::from_slice(&text).unwrap()
    };
    let told = text(&run(&straight, 72, "0.1", &[]));
    let found = &summary(&straight)["periodic"];
    let beats = found["time_s"].as_f64().unwrap() / 0.012;
    let ended = beats.round() as usize;
    assert!((beats - ended as f64).abs() < 1e-9);
    println!("{found}");
    assert!((3..12).contains(&ended), "{found}");
    let ends = [steps_done(&straight), newest_checkpoint(&straight).unwrap()];
    assert_eq!(ends, [6 * ended; 2]);
    assert!(found["largest"].as_f64().unwrap() <= 0.1, "{found}");
    let sentence = format!(
        "periodic: at t = {} s and a beat earlier, nothing differs by more than ",
        found["time_s"]
    );
    assert!(told.contains(&sentence), "{told}");
    let hemodynamics = std::fs::read_to_string(straight.join("hemodynamics.json")).unwrap();
    let hemodynamics: serde_json::Value = serde_json::from_str(&hemodynamics).unwrap();
    let window = &hemodynamics["window"];
    let [start, end] = ["start_s", "end_s"].map(|key| window[key].as_f64().unwrap() / 0.012);
    assert!((start - (ended - 1) as f64).abs() < 1e-9 && (end - ended as f64).abs() < 1e-9);
    assert_eq!(hemodynamics["complete"], true);

    // Amid the third beat, which is no end, and without the step after which it ended.
    let told = text(&run(&resumed, 14, "0.1", &[]));
    assert!(
        told.contains(
            "warning: the run has ended before it was periodic: between t = 0.028 s and a beat earlier there is"
        ),
        "{told}"
    );
    run(&resumed, 72, "0.1", &["--resume"]);
    assert_same_run(&resumed, &straight);
    std::fs::remove_file(resumed.join(format!("checkpoints/{:08}.checkpoint", 6 * ended))).unwrap();
    run(&resumed, 72, "0.1", &["--resume"]);
    assert_same_run(&resumed, &straight);
    // Nothing is left to do, until less counts.
    run(&resumed, 72, "0.1", &["--resume"]);
    assert_same_run(&resumed, &straight);
    let smaller = format!("{}", 0.9 * found["largest"].as_f64().unwrap());
    run(&resumed, 72, &smaller, &["--resume"]);
    assert!(steps_done(&resumed) > 6 * ended);
}

const FLOWING: [&str; 4] = [
    "initial.start=equilibrium",
    "initial.steps_before=10",
    "ramp.duration_s=0",
    "windkessel.initial_pressure_Pa=1.3e4",
];

/// Its windows are beats that begin in the middle of one, and it ends with one of them, also if it is resumed.
#[test]
fn a_run_whose_blood_flows_at_once_ends_amid_a_beat() {
    let folder = tempfile::tempdir().unwrap();
    let [straight, resumed] = ["straight", "resumed"].map(|name| folder.path().join(name));
    let beats = [
        "time.period_s=0.012",
        "inflow.systole_s=0.006",
        "structure.time_scheme=bossak",
        "time.until_periodic=0.1",
    ];
    let run = |out: &Path, steps: usize, more: &[&str]| {
        complete(alone(out, steps, &[&FLOWING, &beats, more].concat()));
    };
    run(&straight, 75, &[]);
    let ended = steps_done(&straight);
    println!("{ended}");
    assert!(ended % 6 == 3 && (9..75).contains(&ended), "{ended}");
    let hemodynamics = std::fs::read_to_string(straight.join("hemodynamics.json")).unwrap();
    let hemodynamics: serde_json::Value = serde_json::from_str(&hemodynamics).unwrap();
    let window = ["start_s", "end_s"].map(|key| hemodynamics["window"][key].as_f64().unwrap());
    let end = ended as f64 * 0.002;
    assert!((window[0] - end + 0.012).abs() < 1e-9 && (window[1] - end).abs() < 1e-9);
    assert_eq!(hemodynamics["complete"], true);
    run(&resumed, 2, &[]);
    run(&resumed, 75, &["--resume"]);
    assert_same_run(&resumed, &straight);
}

/// Bypass and artery are the whole vessel, and its volume is the fluid's own, not that of flat faces.
fn regions_have_the_volume_of_the_whole(run: &Path) {
    let column = |file: &str, wanted: fn(&str) -> bool| -> Vec<f64> {
        let mut reader = csv::Reader::from_path(run.join(file)).unwrap();
        let headers = reader.headers().unwrap().clone();
        let at = |name| headers.iter().position(|header| header == name);
        let (volume, region) = (at("lumen_volume_m3").unwrap(), at("region"));
        let rows = reader.records().map(Result::unwrap);
        let rows = rows.filter(|row| region.is_none_or(|region| wanted(&row[region])));
        rows.map(|row| row[volume].parse().unwrap()).collect()
    };
    let whole = column("history.csv", |_| true);
    let bypass = column("regions.csv", |name| name == "bypass");
    let artery = column("regions.csv", |name| name == "artery");
    for ((whole, bypass), artery) in whole.iter().zip(bypass).zip(artery) {
        let error = (bypass + artery) / whole - 1.0;
        assert!(error.abs() < 1e-12, "{error:e}");
    }
}

/// With a constant inflow, which the beat before has made a steady flow: nothing has to be accelerated, and the middle
/// of the artery is about twice as fast as the mean. From rest the first step takes a surge of pressure, and moves the
/// blood as a plug.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn blood_flows_from_the_beginning_with_both_fluids() {
    let folder = tempfile::tempdir().unwrap();
    let watched = "output.fluid_probes_m=[[0.055, 0.0, 0.0]]";
    let usual = [
        "inflow.amplitude_m3_s=0",
        "fluid.mesh.axial_extension=21",
        "fluid.mesh.axial_per_section=21",
        "structure.axial_per_section=4",
        watched,
    ];
    // Pressure at the inlet above that at the outlet (Pa), and velocity (m/s), after the first step.
    let first = |name: &str, fluid: &str, more: &[&str]| -> [f64; 2] {
        let run = folder.path().join(name);
        let fluid = ["--fluid", fluid, "--set"];
        complete(driver(&run, 1, &[&fluid, &FEW[3..], &usual, more].concat()));
        let value = |file: &str, column: &str| -> f64 {
            let mut table = csv::Reader::from_path(run.join(file)).unwrap();
            let row = table.deserialize::<HashMap<String, String>>().next();
            row.unwrap().unwrap()[column].parse().unwrap()
        };
        let pressure = |column| value("history.csv", column);
        [
            pressure("p_in_Pa") - pressure("p_out_Pa"),
            value("fluid-probes.csv", "ux_m_s"),
        ]
    };
    let rest: Vec<&str> = FLOWING
        .into_iter()
        .filter(|key| !key.contains("before"))
        .collect();
    let found = [
        first("native", "native", &FLOWING),
        first("openfoam", "openfoam", &FLOWING),
        first("rest", "native", &rest),
    ];
    println!("{found:?}");
    let measured = [[38.3, 0.1778], [-16.1, 0.1705], [3274.1, 0.01003]];
    for (found, measured) in found.iter().zip(measured) {
        assert!((found[0] - measured[0]).abs() < 2.0, "{found:?}");
        assert!((found[1] / measured[1] - 1.0).abs() < 0.01, "{found:?}");
    }
}

/// They differ by the error of OpenFOAM's mesh.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn both_solvers_give_the_same_flow() {
    let folder = tempfile::tempdir().unwrap();
    let [native, openfoam] = ["native", "openfoam"].map(|name| folder.path().join(name));
    let still = [
        "--set",
        "fluid.mesh.axial_extension=21",
        "fluid.mesh.axial_per_section=21",
    ];
    let still = [&still[..], &["structure.axial_per_section=4"]].concat();
    complete(driver(
        &native,
        10,
        &[&["--fluid", "native"], &still[..]].concat(),
    ));
    complete(driver(&openfoam, 10, &still));
    for run in [&native, &openfoam] {
        regions_have_the_volume_of_the_whole(run);
    }
    let [native, openfoam] = [native, openfoam].map(|run| history(&run).pop().unwrap());
    // A wall of sixteen facets that enclose what the round one does. All three are measured: the inlet's is that of the
    // first steps, whose layers at the wall are thinner than a cell.
    let expected = [
        ("volume", native.volume / openfoam.volume, 1.0001, 5e-5),
        ("outflow", native.outflow / openfoam.outflow, 1.0046, 1e-3),
        (
            "inlet",
            native.inlet_pressure / openfoam.inlet_pressure,
            0.9875,
            1e-3,
        ),
    ];
    println!("{expected:?}");
    for (what, found, expected, within) in expected {
        assert!((found - expected).abs() < within, "{what}: {found}");
    }
}

#[test]
fn mistakes_in_the_keys_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let refused = |more: &[&str], expected: &[&str]| {
        let output = driver(&out, 1, more).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        for expected in expected {
            assert!(text(&output).contains(expected), "{}", text(&output));
        }
        assert!(!out.exists());
    };
    refused(
        &["--fluid", "neither"],
        &["--fluid", "\"openfoam\"", "\"native\""],
    );
    let native = ["--fluid", "native", "--set"];
    refused(
        &[&native[..], &["fluid.native.degree=9"]].concat(),
        &["fluid.native.degree", "3 to 8"],
    );
    let none = [&native[..], &["fluid.native.axial_extension=0"]].concat();
    refused(
        &none,
        &[
            "fluid.native.axial_extension",
            "both or neither must be zero",
        ],
    );
}

/// A row of `history.csv`.
pub struct Row {
    time: f64,
    inflow: f64,
    outflow: f64,
    pub volume: f64,
    volume_rate: f64,
    inlet_pressure: f64,
}

pub fn history(run: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(run.join("history.csv")).unwrap();
    let headers = reader.headers().unwrap().clone();
    let column = |name: &str| headers.iter().position(|header| header == name).unwrap();
    let row = |row: csv::StringRecord| {
        let value = |name: &str| row[column(name)].parse().unwrap();
        Row {
            time: value("time_s"),
            inflow: value("Q_in_m3_s"),
            outflow: value("Q_out_m3_s"),
            volume: value("lumen_volume_m3"),
            volume_rate: value("dVdt_m3_s"),
            inlet_pressure: value("p_in_Pa"),
        }
    };
    reader
        .records()
        .map(|record| row(record.unwrap()))
        .collect()
}

/// `nohup`, or a shell that ignores other signals too: what is ignored at the start does not end the run.
#[test]
fn signals_that_are_ignored_at_the_start_stay_ignored() {
    let folder = tempfile::tempdir().unwrap();
    for (trap, signals) in [
        ("HUP", &[Signal::HUP][..]),
        ("HUP INT TERM", &[Signal::HUP, Signal::INT, Signal::TERM]),
    ] {
        let out = folder.path().join(trap.replace(' ', "-"));
        let alone = driver(&out, 30, &FEW);
        let mut command = Command::new("sh");
        command
            .current_dir(alone.get_current_dir().unwrap())
            .args(["-c", &format!("trap '' {trap}; exec \"$@\""), "sh"])
            .arg(alone.get_program())
            .args(alone.get_args());
        let mut child = start(&mut command);
        wait_for_steps(&mut child, &out, 1);
        for by in signals {
            signal(child.id() as i32, *by);
        }
        let status = child.wait().unwrap();
        assert!(status.success(), "{trap}: {status}");
        assert_eq!(steps_done(&out), 30, "{trap}");
    }
    // The others still end it.
    let out = folder.path().join("heeded");
    let mut child = start(&mut driver(&out, 2000, &FEW));
    wait_for_steps(&mut child, &out, 1);
    signal(child.id() as i32, Signal::HUP);
    assert_eq!(child.wait().unwrap().code(), Some(130));
}

/// The run is asked to end while it takes a step that lasts longer than it may: thousands of coupling iterations.
#[test]
fn a_step_that_takes_long_is_given_up_at_a_signal() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let endless = [
        "coupling.acceleration=constant",
        "coupling.surrogate=none",
        "coupling.relaxation=1e-5",
        "coupling.max_iterations=10000",
        "coupling.e_rel=1e-9",
    ];
    let mut child = start(&mut driver(&out, 2, &[&FEW[..], &endless].concat()));
    let first = out.join("checkpoints/00000000.checkpoint");
    let begun = Instant::now();
    while !first.exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(20));
    }
    // It has begun with the step.
    std::thread::sleep(Duration::from_secs(1));
    let asked = Instant::now();
    signal(child.id() as i32, Signal::TERM);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let waited = asked.elapsed().as_secs_f64();
    assert!((4.0..20.0).contains(&waited), "{waited} s");
    assert_eq!(steps_done(&out), 0);
    // An existing run is told before anything is computed, or read.
    let mut again = driver(&out, 2, &FEW);
    let refused = again.args(["--set", "time.step_s=-1"]).output().unwrap();
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(
        said.contains("continue the run in it with --resume"),
        "{said}"
    );
}

/// Whether a time (s), of the run or of the clock on the wall, has at most twelve digits.
fn is_round(time: f64) -> bool {
    format!("{time:.11e}").parse() == Ok(time)
}

fn is_time(name: &str) -> bool {
    let is_rate = ["m_s", "m3_s", "1_s", "Pa_s"]
        .iter()
        .any(|unit| name.ends_with(unit));
    name.ends_with("_s") && !is_rate
}

/// Times (s) of all keys of a JSON file.
fn times_within(value: &serde_json::Value, name: &str, found: &mut Vec<f64>) {
    match value {
        serde_json::Value::Object(all) => {
            all.iter()
                .for_each(|(key, value)| times_within(value, key, found));
        }
        serde_json::Value::Array(all) => {
            all.iter()
                .for_each(|value| times_within(value, name, found));
        }
        number => found.extend(number.as_f64().filter(|_| is_time(name))),
    }
}

/// 0.018, not 0.018000000000000002.
#[test]
fn times_in_tables_and_json_have_no_rounding_of_sums() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    complete(alone(&out, 9, &[]));
    let mut seen = 0;
    for entry in std::fs::read_dir(&out).unwrap() {
        let path = entry.unwrap().path();
        let mut times = Vec::new();
        match path.extension().and_then(|end| end.to_str()) {
            Some("csv") => {
                let mut reader = csv::Reader::from_path(&path).unwrap();
                let names = reader.headers().unwrap().clone();
                for record in reader.records().map(Result::unwrap) {
                    let cells = names.iter().zip(&record).filter(|(name, _)| is_time(name));
                    times.extend(cells.map(|(_, cell)| cell.parse::<f64>().unwrap()));
                }
            }
            Some("json") => {
                let value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
                times_within(&value, "", &mut times);
            }
            _ => continue,
        }
        let odd: Vec<f64> = times.iter().copied().filter(|t| !is_round(*t)).collect();
        assert!(odd.is_empty(), "{}: {odd:?}", path.display());
        seen += times.len();
    }
    assert!(seen > 100, "{seen}");
}
