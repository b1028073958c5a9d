//! `fsi-driver couple-test --case`: models compared on a real case, and what the surrogate is good for.

use std::collections::HashMap;
use std::path::Path;
use std::process::{Command, Output};

/// The elastic tube on a very small mesh for a few steps.
fn couple_test(out: &Path, rows: &[&str], more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args([
            "couple-test",
            "--case",
            "openfoam-case/elastic-tube",
            "--preset",
            "demo",
        ])
        .arg("--out")
        .arg(out)
        .arg("--only")
        .args(rows)
        .args(["--set", "fluid.mesh.core=3", "fluid.mesh.radial=2"])
        .args(["fluid.mesh.axial_per_section=12"])
        .args(["structure.axial_per_section=4", "coupling.e_rel=1e-5"])
        // Aitken's factor makes the change of (14) small where the error is not.
        .arg("coupling.criterion=residual")
        .args(more)
        .output()
        .unwrap()
}

fn text(output: &Output) -> String {
    format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}

fn table(out: &Path) -> Vec<HashMap<String, String>> {
    let path = out.join("elastic-tube-demo.csv");
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().collect::<Result<_, _>>().unwrap()
}

/// All models reach the same solution and the surrogate saves iterations.
#[test]
fn all_acceleration_models_reach_one_solution() {
    let folder = tempfile::tempdir().unwrap();
    let rows = ["iqn_ls-0", "iqn_ls-0-surrogate", "aitken-surrogate"];
    let output = couple_test(folder.path(), &rows, &["--steps", "4"]);
    assert!(output.status.success(), "{}", text(&output));

    let found = table(folder.path());
    let number = |row: usize, column: &str| found[row][column].parse::<f64>().unwrap();
    for row in 0..rows.len() {
        assert_eq!(found[row]["complete"], "true");
        assert_eq!(number(row, "steps"), 4.0);
        // Ten times the tolerance
        assert!(number(row, "difference") < 1e-4, "{found:?}");
        assert!(number(row, "mean_iterations_by_residual") >= 1.0);
    }
    let [without, with] = [0, 1].map(|row| number(row, "mean_iterations"));
    assert!(with < 0.8 * without, "{without} without, {with} with it");
    assert!(folder.path().join("elastic-tube-demo.md").exists());

    // What is there already is not computed again.
    let seconds = |row: usize| found[row]["s_per_step"].clone();
    let output = couple_test(folder.path(), &rows, &["--steps", "4"]);
    assert!(output.status.success(), "{}", text(&output));
    assert_eq!(table(folder.path())[1]["s_per_step"], seconds(1));

    // Another number of steps is another run, but not of another case: it goes on.
    let output = couple_test(folder.path(), &rows[1..2], &["--steps", "5"]);
    assert!(output.status.success(), "{}", text(&output));
    assert_eq!(table(folder.path())[0]["steps"], "5");

    // Another case in the same folder is refused.
    let other = ["--steps", "5", "--set", "blood.density_kg_m3=1010"];
    let output = couple_test(folder.path(), &rows[1..2], &other);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    assert!(text(&output).contains("blood.density_kg_m3"));
}

#[test]
fn unknown_rows_are_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("table");
    let output = couple_test(&out, &["iqn_ls-7"], &[]);
    assert_eq!(output.status.code(), Some(2));
    let said = text(&output);
    assert!(said.contains("iqn_ls-7") && said.contains("aitken-surrogate"));
    assert!(!out.exists());
}
