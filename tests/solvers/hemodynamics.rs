//! Wall shear measures of a short real run: against OpenFOAM's own wall shear stress, and against their repetition from
//! what was stored.

use crate::run_support::*;
use std::path::Path;

const DENSITY: f64 = 1050.0;

/// The vectors on a patch in a binary field file of OpenFOAM.
fn patch_vectors(path: &Path, patch: &str) -> Vec<[f64; 3]> {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let find = |from: usize, what: &str| {
        let what = what.as_bytes();
        let at = bytes[from..].windows(what.len()).position(|w| w == what);
        from + at.unwrap_or_else(|| panic!("{}", path.display())) + what.len()
    };
    let entry = find(find(0, "boundaryField"), patch);
    let list = find(entry, "List<vector>");
    let open = find(list, "(");
    let digits = String::from_utf8_lossy(&bytes[list..open - 1]);
    let count: usize = digits.trim().parse().unwrap();
    let numbers = bytes[open..].chunks_exact(8).take(3 * count);
    let numbers: Vec<f64> = numbers
        .map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap()))
        .collect();
    numbers
        .chunks_exact(3)
        .map(|v| [v[0], v[1], v[2]])
        .collect()
}

/// The templates with OpenFOAM's function object next to the adapter.
fn templates(folder: &Path) {
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/base");
    for part in ["0", "constant", "system"] {
        std::fs::create_dir_all(folder.join(part)).unwrap();
        for file in std::fs::read_dir(base.join(part)).unwrap() {
            let file = file.unwrap();
            std::fs::copy(file.path(), folder.join(part).join(file.file_name())).unwrap();
        }
    }
    let control = folder.join("system/controlDict");
    let text = std::fs::read_to_string(&control).unwrap();
    let object = "functions\n{\n    shear { type wallShearStress; libs (fieldFunctionObjects); \
                  patches (wallFsi); writeControl timeStep; writeInterval 1; }\n";
    let text = text.replacen("functions\n{\n", object, 1);
    assert!(text.contains("wallShearStress"));
    std::fs::write(control, text).unwrap();
}

fn columns(path: &Path, names: [&str; 3]) -> Vec<[f64; 3]> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let headers = reader.headers().unwrap().clone();
    let at = names.map(|name| headers.iter().position(|header| header == name).unwrap());
    let rows = reader.records().map(Result::unwrap);
    rows.map(|row| at.map(|i| row[i].parse().unwrap()))
        .collect()
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn the_measures_agree_with_openfoams_own_wall_shear_stress() {
    let folder = tempfile::tempdir().unwrap();
    let (out, base) = (folder.path().join("run"), folder.path().join("base"));
    templates(&base);
    let chosen = format!("fluid.templates={}", base.display());
    let window = [
        "--set",
        "output.window_start_s=0.004",
        "output.window_end_s=0.016",
    ];
    let every_step = ["--set", "output.fluid_interval_s=0.002", "--set", &chosen];
    complete(driver(&out, 8, &[&window[..], &every_step].concat()));

    let found = columns(&out.join("wall-shear.csv"), ["TAWSS_Pa", "OSI", "RRT_1_Pa"]);
    let mut sums = vec![([0.0; 3], 0.0); found.len()];
    for n in 3..=8 {
        let time = (n as f64 * STEP * 1e4).round() / 1e4;
        let field = out.join(format!("openfoam/{time}/wallShearStress"));
        let shear = patch_vectors(&field, "wallFsi");
        assert_eq!(shear.len(), found.len());
        for ((vector, magnitude), v) in sums.iter_mut().zip(&shear) {
            let v = v.map(|c| DENSITY * c);
            (0..3).for_each(|d| vector[d] += v[d] / 6.0);
            *magnitude += v.iter().map(|c| c * c).sum::<f64>().sqrt() / 6.0;
        }
    }
    let largest = sums.iter().map(|(_, m)| *m).fold(0.0, f64::max);
    assert!(largest > 1e-3, "there is hardly any shear: {largest} Pa");
    for (face, ([tawss, osi, rrt], (vector, magnitude))) in found.iter().zip(&sums).enumerate() {
        let norm = vector.iter().map(|c| c * c).sum::<f64>().sqrt();
        let expected = [*magnitude, 0.5 * (1.0 - norm / magnitude), 1.0 / norm];
        // The stored shear has single precision.
        assert!(
            (tawss - expected[0]).abs() < 1e-6 * expected[0],
            "face {face}: TAWSS"
        );
        assert!(
            (osi - expected[1]).abs() < 1e-6,
            "face {face}: {osi} {expected:?}"
        );
        assert!(
            (rrt / expected[2] - 1.0).abs() < 1e-4,
            "face {face}: {rrt} {expected:?}"
        );
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn the_stored_wall_gives_what_was_gathered_while_running() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    complete(driver(&out, 6, &[]));
    let read =
        || ["hemodynamics.json", "wall-shear.csv"].map(|f| std::fs::read(out.join(f)).unwrap());
    let running = read();
    let again = |more: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
        command
            .arg("hemodynamics")
            .arg(&out)
            .args(more)
            .output()
            .unwrap()
    };
    let output = again(&[]);
    assert!(output.status.success(), "{}", text(&output));
    assert!(running == read(), "the repetition differs");

    // Another window gives other values, and says what it lacks.
    let output = again(&["--from", "0.004", "--to", "0.02"]);
    assert!(running == read(), "the run's own evaluation was replaced");
    let beside = std::fs::read(out.join("window-0.004-to-0.02/hemodynamics.json")).unwrap();
    let output_replaced = again(&["--from", "0.004", "--to", "0.02", "--replace"]);
    assert!(
        output_replaced.status.success(),
        "{}",
        text(&output_replaced)
    );
    assert!(beside == read()[0]);
    assert!(
        text(&output).contains("not every step"),
        "{}",
        text(&output)
    );
    let summary: serde_json::Value = serde_json::from_slice(&read()[0]).unwrap();
    assert_eq!(
        (summary["steps"].as_u64(), summary["complete"].as_bool()),
        (Some(4), Some(false))
    );
    let output = again(&["--from", "0.5", "--to", "0.4"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output).contains("--from 0.5 --to 0.4"),
        "{}",
        text(&output)
    );

    std::fs::remove_file(out.join("wall.bin")).unwrap();
    let output = again(&[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output).contains("wall_history"), "{}", text(&output));
}
