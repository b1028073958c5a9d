//! `fsi-driver new`, `preview` and `windkessel` of vessels that branch.

use crate::new_case::{driver, succeeds};
use fsi_driver::case::{Case, ConditionKeys, Preset};
use std::path::Path;

const EXAMPLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/trees");

fn copied(folder: &Path, name: &str) {
    let from = Path::new(EXAMPLES).join(name);
    std::fs::copy(&from, folder.join(from.file_name().unwrap())).unwrap();
}

/// Shares of the flow as the resistances (Pa s/m³) of a text divide it, the proximal ones included.
fn divided(folder: &Path) -> (Vec<String>, Vec<f64>, f64) {
    let case = Case::load(folder, Preset::Demo, &[]).unwrap_or_else(|e| panic!("{e}"));
    let tree = case.tree().unwrap();
    let conductance = tree
        .opening
        .iter()
        .flatten()
        .filter_map(|keys| match keys.condition {
            ConditionKeys::Windkessel {
                resistance,
                proximal,
                ..
            } => Some(1.0 / (resistance + proximal.unwrap_or(0.0))),
            _ => None,
        });
    let all: Vec<f64> = conductance.collect();
    let sum: f64 = all.iter().sum();
    (
        tree.names(),
        all.iter().map(|g| g / sum).collect(),
        1.0 / sum,
    )
}

/// Fifteen branches in less than ten seconds; flow by Murray's law, which the example's radii obey.
#[test]
fn a_tree_becomes_a_case() {
    let folder = tempfile::tempdir().unwrap();
    copied(folder.path(), "arteries/tree.swc");
    let said = succeeds(
        folder.path(),
        &[
            "new", "arteries", "--from", "tree.swc", "--unit", "mm", "--rcr",
        ],
    );
    assert!(
        said.contains("a tree with 8 ends") && said.contains("15 branches"),
        "{said}"
    );
    let (names, shares, _) = divided(&folder.path().join("arteries"));
    assert_eq!(names[0], "inlet");
    assert_eq!(names[8], "outlet8");
    // r0³ = r1³ + r2³ with r2 = 0.8 r1, three times.
    let larger = 1.0 / (1.0 + 0.8f64.powi(3));
    let [most, least] = [larger.powi(3), (1.0 - larger).powi(3)];
    assert!(
        (shares[0] - most).abs() < 2e-3 && (shares[7] - least).abs() < 2e-3,
        "{shares:?}"
    );
}

/// A carotid by its names and a given split; the windkessels that take off the wall's compliance; pictures.
#[test]
fn a_carotid_becomes_a_case_with_pictures() {
    let folder = tempfile::tempdir().unwrap();
    copied(folder.path(), "carotid/lines.vtp");
    let here = folder.path();
    let said = succeeds(
        here,
        &[
            "new",
            "c",
            "--from",
            "lines.vtp",
            "--unit",
            "mm",
            "--names",
            "common,internal,external",
            "--split",
            "65,35",
        ],
    );
    assert!(
        said.contains("internal 65.0 %, external 35.0 %: as given"),
        "{said}"
    );
    let (names, shares, whole) = divided(&here.join("c"));
    assert_eq!(names, ["common", "internal", "external"]);
    assert!((shares[0] - 0.65).abs() < 3e-3, "{shares:?}");
    let told = succeeds(
        here,
        &[
            "windkessel",
            "--case",
            "c",
            "--split",
            "65,35",
            "--preset",
            "demo",
        ],
    );
    assert!(
        told.contains("name = \"internal\"") && told.contains("from 80.0 to 120.0 mmHg"),
        "{told}"
    );
    let numbers = |key: &str| -> Vec<f64> {
        let lines = told
            .lines()
            .filter_map(|line| line.strip_prefix(&format!("{key} = ")));
        lines.map(|number| number.parse().unwrap()).collect()
    };
    let resistances = numbers("resistance_Pa_s_m3");
    let parallel = 1.0 / resistances.iter().map(|r| 1.0 / r).sum::<f64>();
    assert!((parallel / whole - 1.0).abs() < 5e-3, "{parallel} {whole}");
    let (_, rest) = told.split_once("the vessel itself has ").unwrap();
    let own: f64 = rest.split(' ').next().unwrap().parse().unwrap();
    println!("{told}");
    assert!(own > 0.0);

    succeeds(
        here,
        &["preview", "c", "--preset", "demo", "--out", "pictures"],
    );
    let page = std::fs::read_to_string(here.join("pictures/preview.html")).unwrap();
    for part in [
        "The worst places of the blood",
        "3 branches",
        "internal",
        "class=\"viewer\"",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(
        std::fs::metadata(here.join("pictures/preview.png"))
            .unwrap()
            .len()
            > 50_000
    );
}

/// One sentence each, exit code 2, nothing written.
#[test]
fn what_does_not_fit_a_tree_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    copied(folder.path(), "carotid/lines.vtp");
    let here = folder.path();
    let from = ["new", "c", "--from", "lines.vtp"];
    for (more, reason) in [
        (&[][..], "--unit mm"),
        (&["--unit", "m"], "--unit mm would fit"),
        (&["--unit", "mm", "--names", "a,b"], "--names: expected 3"),
        (
            &["--unit", "mm", "--names", "a,b,b"],
            "two openings are called \"b\"",
        ),
        (&["--unit", "mm", "--names", "a,b,c d"], "letters, digits"),
        (
            &["--unit", "mm", "--split", "1"],
            "--split: expected 2 shares",
        ),
        (
            &["--unit", "mm", "--split", "0.5,-0.5"],
            "--split -0.5: expected shares above 0",
        ),
        (
            &["--unit", "mm", "--split", "1,1", "--murray", "2"],
            "leave out --murray",
        ),
        (
            &["--unit", "mm", "--murray", "-1"],
            "--murray -1: expected an exponent",
        ),
        (
            &["--unit", "mm", "--like", "stenosis"],
            "--like is for a single vessel",
        ),
        (
            &["--unit", "mm", "--reverse"],
            "--reverse is for a single vessel",
        ),
        (
            &["--unit", "mm", "--radius", "3mm"],
            "--radius is for a single vessel",
        ),
        (
            &["--unit", "mm", "--lumen", "none.stl"],
            "none.stl: No such file",
        ),
        (&["--unit", "mm", "--flow", "none.csv"], "none.csv"),
    ] {
        let output = driver(here, &[&from[..], more].concat());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{more:?}: {error}");
        assert!(
            error.contains(reason),
            "{more:?}: {error}\nexpected {reason}"
        );
        assert!(!here.join("c").exists());
    }
    let output = driver(
        here,
        &[
            "new",
            "tube",
            "--split",
            "1,1",
            "--from",
            "lines.vtp",
            "--branch",
            "CenterlineIds=0",
            "--unit",
            "mm",
        ],
    );
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2) && error.contains("--split is for a vessel that branches"),
        "{error}"
    );
}
