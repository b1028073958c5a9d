//! `fsi-driver windkessel`, as a user types it.

use std::process::{Command, Output};

fn windkessel(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .arg("windkessel")
        .args(arguments)
        .output()
        .unwrap()
}

fn said(arguments: &[&str]) -> String {
    let output = windkessel(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    String::from_utf8(output.stdout).unwrap()
}

fn value(text: &str, key: &str) -> f64 {
    let (_, rest) = text.split_once(&format!("{key} = ")).expect(key);
    rest.lines().next().unwrap().parse().unwrap()
}

/// The curve of 1.35 + 5.2 ml/s as a file, and as keys of a case whose own wall takes a share.
#[test]
fn the_keys_are_proposed_for_a_file_and_for_a_case() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("flow.csv");
    let mut text = "# resting\ntime_s,flow_m3_s\n".to_owned();
    for i in 0..=500 {
        let t = 0.002 * f64::from(i);
        let pulse = match t < 0.5 {
            true => (std::f64::consts::PI * (t / 0.5).powf(0.8)).sin().powi(2),
            false => 0.0,
        };
        text += &format!("{t:.3},{:e}\n", 1.35e-6 + 5.2e-6 * pulse);
    }
    std::fs::write(&file, text).unwrap();
    let alone = said(&["--flow", file.to_str().unwrap()]);
    assert!(alone.contains("from 80.0 to 120.0 mmHg"), "{alone}");
    // A lumped model of it with 1.51e-10 m³/Pa in all had 81 to 120 mmHg at 4.94e9 Pa s/m³.
    let [resistance, all] =
        ["resistance_Pa_s_m3", "compliance_m3_Pa"].map(|key| value(&alone, key));
    assert!((resistance / 4.94e9 - 1.0).abs() < 0.02, "{alone}");
    assert!((all / 1.51e-10 - 1.0).abs() < 0.05, "{alone}");

    let set = ["inflow.base_m3_s=1.35e-6", "inflow.amplitude_m3_s=5.2e-6"];
    let case = ["--case", "tests/cases/S-0.0", "--preset", "demo", "--set"];
    let within = said(&[&case[..], &set[..]].concat());
    let ratio = value(&within, "resistance_Pa_s_m3") / value(&alone, "resistance_Pa_s_m3");
    assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
    let own = value(&alone, "compliance_m3_Pa") - value(&within, "compliance_m3_Pa");
    println!("{within}the vessel's own compliance {own:e} m³/Pa");
    assert!((OWN * 0.99..OWN * 1.01).contains(&own), "{own:e}");
}

/// Compliance of the wall of S-0.0 between 80 and 120 mmHg with the mesh of `demo`, m³/Pa.
const OWN: f64 = 6.085e-11;

#[test]
fn what_makes_no_sense_is_refused() {
    let case = ["--case", "tests/cases/S-0.0"];
    for (arguments, expected) in [
        (vec![], "--flow"),
        (vec!["--flow", "nowhere.csv"], "nowhere.csv"),
        (
            [&case[..], &["--systolic", "70"]].concat(),
            "must be below --systolic 70",
        ),
        (
            [&case[..], &["--systolic", "12000"]].concat(),
            "--systolic 12000: expected",
        ),
        (
            [&case[..], &["--diastolic", "NaN"]].concat(),
            "--diastolic NaN: expected",
        ),
        (vec!["--case", "openfoam-case/turek-hron"], "no vessel"),
        (
            [&case[..], &["--set", "inflow.amplitude_m3_s=1e-9"]].concat(),
            "further apart than 0 %",
        ),
    ] {
        let output = windkessel(&arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.contains(expected), "{arguments:?}: {error}");
    }
}

/// A vessel whose end widens with it stores what it does elsewhere: 2 % more than one with a clamped end.
#[test]
fn a_vessel_with_an_end_that_widens_stores_a_little_more() {
    let folder = tempfile::tempdir().unwrap();
    let stored = |end: &str| -> f64 {
        let text = format!(
            "extends = \"defaults\"\n[vessel]\nradius_m = 3.1e-3\n[[vessel.piece]]\npiece = \"line\"\nlength_m = 0.075\n\
             [[vessel.section]]\nname = \"artery\"\nlayers = [\"wall\"]\nthicknesses = [0.25]\n[[vessel.material]]\n\
             name = \"wall\"\nmaterial = \"neo_hooke\"\nmu_Pa = 2e5\nkappa_Pa = 1e7\n[inflow]\nbase_m3_s = 4e-6\n\
             amplitude_m3_s = 1.2e-5\nsystole_s = 0.35\n[windkessel]\nresistance_Pa_s_m3 = 1.753e9\n\
             compliance_m3_Pa = 7e-10\ninitial_pressure_Pa = 1e4\n[surroundings]\nspring_Pa_m = 5e6\n\
             [initial]\nstart = \"equilibrium\"\nshape = \"loaded\"\npressure_Pa = 1e4\n[structure]\np = 3\n\
             [ends]\noutlet = \"{end}\"\n"
        );
        std::fs::write(folder.path().join("case.toml"), text).unwrap();
        let case = folder.path().to_str().unwrap();
        let text = said(&["--case", case, "--preset", "demo", "--fluid", "native"]);
        let (_, rest) = text.split_once("the vessel itself has ").expect(&text);
        rest.split_whitespace().next().unwrap().parse().unwrap()
    };
    let [clamped, radial] = ["clamped", "radial"].map(stored);
    println!("{clamped:e} {radial:e} {}", radial / clamped);
    assert!((radial / clamped - 1.02).abs() < 0.01, "{clamped} {radial}");
}
