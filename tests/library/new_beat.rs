//! Beats as hearts have them: `fsi-driver new` chooses a time step, an end and intervals that fit.

use crate::new_case::{driver, succeeds};
use fsi_driver::case::{Case, FlowCurve, Preset, Window};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

/// Rows of a curve of this period, its end among them or not.
fn write(path: &Path, period: f64, rows: usize, is_closed: bool, from: usize) {
    let mut text = String::from("time_s,flow_ml_s\n");
    for i in from..rows + usize::from(is_closed) {
        let share = i as f64 / rows as f64;
        let flow = 5.0 + 3.0 * (TAU * share).sin() + (2.0 * TAU * share).cos();
        let _ = writeln!(text, "{:.5},{flow:.4}", period * share);
    }
    std::fs::write(path, text).unwrap();
}

/// Whether a number of steps is whole.
fn is_whole(case: &Case, time: f64) -> bool {
    let steps = time / case.time.step;
    (steps - steps.round()).abs() < 1e-6 * steps && steps > 0.5
}

#[test]
fn any_period_gets_a_step_that_fits() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for (i, period) in [
        0.917, 0.955, 0.821, 0.857, 0.6, 1.1, 0.8571429, 0.7093, 0.9999, 1.0,
    ]
    .into_iter()
    .enumerate()
    {
        write(&here.join("flow.csv"), period, 20, false, 0);
        let name = format!("case-{i}");
        let shown = period.to_string();
        succeeds(
            here,
            &["new", &name, "--flow", "flow.csv", "--period", &shown],
        );
        for preset in Preset::ALL {
            let case = Case::load(&here.join(&name), preset, &[])
                .unwrap_or_else(|e| panic!("{period}: {e}"));
            assert_eq!(case.time.period, period);
            assert_eq!(case.adjusted, Vec::<String>::new(), "{period}");
            let window = Window::of(&case);
            let (output, step) = (&case.output, case.time.step);
            for time in [
                period,
                case.time.end,
                output.structure_interval,
                output.fluid_interval,
                window.end_s,
            ] {
                assert!(is_whole(&case, time), "{period}: {time} of {step}");
            }
            let (shortest, beats) = match preset {
                Preset::Fast => (3.6e-3, 10.0),
                _ => (1.8e-3, 3.0),
            };
            assert!(
                (shortest..=shortest / 0.9).contains(&step),
                "{period}: {step}"
            );
            let steps = case.steps();
            match preset {
                // 1350 before.
                Preset::Demo => assert_eq!(steps, 50, "{period}"),
                _ => {
                    assert!((case.time.end / period - beats).abs() < 1e-9, "{period}");
                    let begin = window.start_s / period;
                    assert!((begin + 1.0 - beats).abs() < 1e-9, "{period}");
                }
            }
        }
    }
}

#[test]
fn a_period_alone_takes_the_step_with_it() {
    let set = |pairs: &[(&str, &str)]| {
        let pairs: Vec<(String, String)> = (pairs.iter())
            .map(|(k, v)| (k.to_string(), v.to_string()))
            .collect();
        let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/S-0.25");
        Case::load(&model, Preset::Paper, &pairs)
    };
    let case = set(&[("time.period_s", "0.917")]).unwrap();
    assert!(
        (case.time.step - 0.917 / 459.0).abs() < 1e-15,
        "{}",
        case.time.step
    );
    // Ends and intervals are rounded to whole steps, and what the user has written is reported.
    let case = set(&[
        ("time.step_s", "0.0008"),
        ("output.structure_interval_s", "0.003"),
        ("time.end_s", "0.0101"),
    ])
    .unwrap();
    assert!((case.output.structure_interval - 0.0032).abs() < 1e-15);
    assert!((case.output.fluid_interval - 0.1).abs() < 1e-15);
    assert!((case.time.end - 0.0104).abs() < 1e-15);
    assert_eq!(case.adjusted.len(), 2, "{:?}", case.adjusted);
    assert!(case.adjusted[1].contains("output.structure_interval_s = 0.003 is taken as 0.0032: 4 steps of time.step_s = 0.0008"), "{:?}", case.adjusted);
    let exact = set(&[]).unwrap();
    assert_eq!(
        (exact.time.step, exact.time.end, exact.output.fluid_interval),
        (0.002, 3.0, 0.1)
    );
    // A step that the user has chosen for the period is not touched.
    let error = set(&[("time.step_s", "0.003")]).unwrap_err().to_string();
    assert!(error.contains("whole part of time.period_s"), "{error}");
}

#[test]
fn a_beat_is_as_long_as_its_curve() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let period = |name: &str| {
        Case::load(&here.join(name), Preset::Demo, &[])
            .unwrap()
            .time
            .period
    };
    for (name, given, rows, is_closed) in [
        ("closed", 0.857, 50, true),
        ("open", 0.857, 50, false),
        ("odd", 0.917, 20, false),
        ("second", 1.0, 50, true),
    ] {
        let file = format!("{name}.csv");
        write(&here.join(&file), given, rows, is_closed, 0);
        let said = succeeds(here, &["new", name, "--flow", &file]);
        assert!(
            (period(name) - given).abs() < 1e-5,
            "{name}: {}",
            period(name)
        );
        assert!(
            said.contains(&format!(
                "beat      {given} s, as long as the curve in {file}"
            )),
            "{said}"
        );
    }
    // Blood at rest at both ends: 0 to 0.98 s in steps of 0.02 are a second.
    let rests: String = (0..50)
        .map(|i| {
            format!(
                "{:.2},{:.3}\n",
                0.02 * f64::from(i),
                if i < 25 {
                    (TAU * f64::from(i) / 50.0).sin()
                } else {
                    0.0
                } + 1.0
            )
        })
        .collect();
    std::fs::write(here.join("rests.csv"), format!("time_s,flow_ml_s\n{rests}")).unwrap();
    succeeds(here, &["new", "rests", "--flow", "rests.csv"]);
    assert_eq!(period("rests"), 1.0);
    // A shorter curve in a longer beat is pointed out; a longer one can be stretched.
    let said = succeeds(
        here,
        &["new", "gap", "--flow", "closed.csv", "--period", "1.0"],
    );
    assert!(
        said.contains("warning: the curve in closed.csv is 0.857 s long, and the beat 1 s"),
        "{said}"
    );
    succeeds(
        here,
        &[
            "new",
            "stretched",
            "--flow",
            "second.csv",
            "--period",
            "0.8",
            "--flow-period",
            "1",
        ],
    );
    let case = Case::load(&here.join("stretched"), Preset::Demo, &[]).unwrap();
    let flow = FlowCurve::new(&case.vessel().unwrap().inflow, case.time.period).unwrap();
    assert!((flow.flow(0.4) - flow.flow(1.2)).abs() < 1e-15 && case.time.period == 0.8);
    std::fs::write(
        here.join("anyhow.csv"),
        "time_s,flow_ml_s\n0,1\n0.1,4\n0.35,3\n0.5,2\n",
    )
    .unwrap();
    std::fs::write(here.join("ms.csv"), "time,flow_ml_s\n0,1\n1000,4\n2000,1\n").unwrap();
    for (arguments, message) in [
        (
            &["--flow", "anyhow.csv"][..],
            "does not come back to its first value",
        ),
        (
            &["--flow", "second.csv", "--period", "0.8"],
            "--period 0.8: the curve in second.csv reaches to 1 s; --flow-period 1 stretches it",
        ),
        (
            &["--flow", "ms.csv"],
            "2000 s long, and beats are 0.001 to 1000 s",
        ),
    ] {
        let output = driver(here, &[&["new", "none"], arguments].concat());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.contains(message), "{arguments:?}: {error}");
    }
}
