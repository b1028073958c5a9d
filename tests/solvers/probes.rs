//! Probes on the wall and in the blood, and averages over beats.

use crate::run_support::*;
use fsi_driver::Vec3;
use fsi_driver::geometry::PolyMesh;
use fsi_driver::output::vtu::VtuSeries;
use fsi_driver::output::wall_history::WallHistoryReader;
use std::collections::HashMap;
use std::path::Path;
use std::process::Command;
use vtkio::Vtk;
use vtkio::model::{Attribute, DataSet, Piece};

type Row = HashMap<String, String>;

fn table(path: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

fn number(row: &Row, name: &str) -> f64 {
    row[name].parse().unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// All components of a field at the points of a grid.
fn point_data(path: &Path, name: &str) -> Vec<f64> {
    let DataSet::UnstructuredGrid { pieces, .. } = Vtk::import(path).unwrap().data else {
        panic!("{}: no grid", path.display());
    };
    let Some(Piece::Inline(piece)) = pieces.into_iter().next() else {
        panic!("{}: no data within", path.display());
    };
    let mut arrays = piece
        .data
        .point
        .into_iter()
        .filter_map(|field| match field {
            Attribute::DataArray(array) if array.name == name => array.data.into_vec(),
            _ => None,
        });
    arrays.next().unwrap()
}

/// The numbers of all cells in a binary field file of OpenFOAM.
fn cell_values(path: &Path) -> Vec<f64> {
    let bytes = std::fs::read(path).unwrap();
    let after = |from: usize, what: &[u8]| {
        let found = bytes[from..].windows(what.len()).position(|w| w == what);
        from + found.unwrap() + what.len()
    };
    let list = after(after(0, b"internalField"), b"List<");
    let (count, open) = (after(list, b">"), after(list, b"("));
    let count = String::from_utf8_lossy(&bytes[count..open - 1]);
    let components = if bytes[list..].starts_with(b"vector") {
        3
    } else {
        1
    };
    let count = components * count.trim().parse::<usize>().unwrap();
    let numbers = bytes[open..].chunks_exact(8).take(count);
    numbers
        .map(|n| f64::from_le_bytes(n.try_into().unwrap()))
        .collect()
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn probes_see_the_flow_and_a_resumed_run_sees_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let (straight, resumed) = (
        folder.path().join("straight"),
        folder.path().join("resumed"),
    );
    let probes = [
        "--set",
        "output.probes_m=[[0.0125, 3.2e-3, 2.4e-3]]",
        // The last one is in the cell before the probe on the wall.
        "output.fluid_probes_m=[[-0.02, 0.0, 0.0], [0.0525, 0.0, 0.0], [0.0125, 3.04e-3, 2.28e-3]]",
    ];
    complete(driver(&straight, 6, &probes));
    complete(driver(&resumed, 3, &probes));
    complete(driver(&resumed, 6, &[&["--resume"], &probes[..]].concat()));
    for name in ["probes.csv", "fluid-probes.csv"] {
        let [a, b] = [&straight, &resumed].map(|run| std::fs::read(run.join(name)).unwrap());
        assert!(a == b, "{name} differs");
    }
    let history = table(&straight.join("history.csv"));
    let found = table(&straight.join("fluid-probes.csv"));
    assert_eq!(found.len(), 3 * history.len());
    for (step, probes) in history.iter().zip(found.chunks(3)) {
        assert_eq!(step["time_s"], probes[0]["time_s"]);
        // On the axis of the rigid extension (its radius is 4 mm) the blood is faster than on average, in a
        // starting flow hardly: measured 1.02 to 1.13 of the mean.
        let mean = number(step, "Q_in_m3_s") / (std::f64::consts::PI * 16e-6);
        let ratio = number(&probes[0], "ux_m_s") / mean;
        assert!((1.0..1.3).contains(&ratio), "{ratio}");
        // 7.5 mm before the outlet, through which blood enters at first: measured 0.46 to 0.76 of its pressure, the
        // rest accelerates the blood that the ramp presses in from there, and 0.63 to 0.91 of its velocity, the rest
        // has widened the wall.
        let [near, outlet] = [number(&probes[1], "p_Pa"), number(step, "p_out_Pa")];
        assert!(
            (0.44..0.78).contains(&(near / outlet)),
            "{near} {outlet} Pa"
        );
        let flow = number(step, "Q_out_m3_s") / (std::f64::consts::PI * 3.2e-3_f64.powi(2));
        let ratio = number(&probes[1], "ux_m_s") / flow;
        assert!((0.61..0.93).contains(&ratio), "{ratio}");
    }

    // In the middle of a cell, here of the rigid extension, it is what OpenFOAM has written of that cell.
    let mesh = PolyMesh::read(&straight.join("openfoam")).unwrap();
    let cells: Vec<Vec3> = (mesh.cell_geometry().into_iter())
        .map(|(_, centre)| centre)
        .collect();
    let nearest = |place: Vec3| {
        let order = |a: &usize, b: &usize| {
            let away = |cell: &usize| (cells[*cell] - place).norm();
            away(a).total_cmp(&away(b))
        };
        (0..cells.len()).min_by(order).unwrap()
    };
    let cell = nearest(Vec3::new(-0.02, 1e-3, 2e-3));
    let middle: [f64; 3] = cells[cell].into();
    let out = folder.path().join("middle");
    let probe = format!("output.fluid_probes_m=[{middle:?}]");
    complete(driver(&out, 6, &["--set", &probe]));
    let fields = out.join("openfoam/0.012");
    let (p, u) = (
        cell_values(&fields.join("p")),
        cell_values(&fields.join("U")),
    );
    assert_eq!(3 * p.len(), u.len());
    let probed = table(&out.join("fluid-probes.csv"));
    let probed = probed.last().unwrap();
    for (found, name) in u[3 * cell..3 * cell + 3]
        .iter()
        .zip(["ux_m_s", "uy_m_s", "uz_m_s"])
        .chain([(&(1050.0 * p[cell]), "p_Pa")])
    {
        let probed = number(probed, name);
        assert!(
            (probed - found).abs() < 1e-9 * found.abs() + 1e-12,
            "{name}: {probed} {found}"
        );
    }

    // The wall's shear is that of the face there.
    let reader = WallHistoryReader::open(&straight.join("wall.bin")).unwrap();
    let wall = reader.wall.clone();
    let face = (0..wall.faces.len()).min_by(|a, b| {
        let distance = |face: &usize| {
            let points = &wall.faces[*face];
            let sum: fsi_driver::Vec3 = points.iter().map(|p| wall.points[*p as usize]).sum();
            (sum / points.len() as f64 - fsi_driver::Vec3::new(0.0125, 3.2e-3, 2.4e-3)).norm()
        };
        distance(a).total_cmp(&distance(b))
    });
    let rows = table(&straight.join("probes.csv"));
    // The pressure there is that of the cell.
    let pressure = 1050.0
        * cell_values(&straight.join("openfoam/0.012/p"))
            [nearest(Vec3::new(0.0125, 3.04e-3, 2.28e-3))];
    let probed = number(rows.last().unwrap(), "p_Pa");
    assert!(
        (probed / pressure - 1.0).abs() < 1e-6,
        "{probed} {pressure} Pa"
    );
    for (state, row) in reader.map(Result::unwrap).zip(&rows) {
        let shear = state.shear[face.unwrap()];
        assert!(shear[0].abs() > 1e-7, "{shear:?}");
        for (component, name) in shear.iter().zip(["x", "y", "z"]) {
            let probed = number(row, &format!("wall_shear_{name}_Pa"));
            assert_eq!(*component, probed as f32);
        }
    }
}

/// Nothing is written before.
#[test]
fn points_outside_the_blood_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let outside = [
        "--set",
        "output.fluid_probes_m=[[0.01, 0.0, 0.0], [0.01, 0.0, 4e-3]]",
    ];
    let refused = driver(&out, 1, &outside).output().unwrap();
    let said = text(&refused);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(
        said.contains("output.fluid_probes_m") && said.contains("[0.01, 0.0, 0.004] does not lie"),
        "{said}"
    );
    assert!(!out.exists());
}

#[test]
fn of_many_points_outside_the_first_few_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let points: Vec<[f64; 3]> = (0..1000).map(|i| [0.06, 0.01, 1e-3 * i as f64]).collect();
    for key in ["output.fluid_probes_m", "output.probes_m"] {
        let outside = format!("{key}={points:?}");
        let run = driver(&folder.path().join("run"), 1, &["--set", &outside]).output();
        let said = text(&run.unwrap());
        assert!(said.contains("; and 995 more points like this"), "{said}");
        assert_eq!(said.lines().count(), 6, "{said}");
    }
}

/// The templates of the vessel, with a change of `controlDict`.
fn templates(folder: &Path, name: &str, change: impl Fn(String) -> String) -> String {
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/base");
    let copy = folder.join(name);
    for part in ["0", "constant", "system"] {
        std::fs::create_dir_all(copy.join(part)).unwrap();
        for file in std::fs::read_dir(base.join(part)).unwrap().flatten() {
            std::fs::copy(file.path(), copy.join(part).join(file.file_name())).unwrap();
        }
    }
    let dictionary = copy.join("system/controlDict");
    let text = change(std::fs::read_to_string(&dictionary).unwrap());
    std::fs::write(dictionary, text).unwrap();
    format!("fluid.templates={copy:?}")
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn templates_of_ones_own_need_nothing_for_points_in_the_blood() {
    let folder = tempfile::tempdir().unwrap();
    let probe = "output.fluid_probes_m=[[0.01, 0.0, 0.0]]";
    // As templates were before: they bring the file of the points themselves.
    let include = "#include \"$FOAM_CASE/system/fsiProbes\"\n    fsiAdapter\n    {\n";
    let own = templates(folder.path(), "own", |text| {
        assert!(!text.contains("fsiProbes") && text.contains("    fsiAdapter\n    {\n"));
        text.replace("fsiAdapter\n    {\n", include)
    });
    let out = folder.path().join("run");
    complete(driver(&out, 2, &["--set", &own, probe]));
    assert_eq!(table(&out.join("fluid-probes.csv")).len(), 2);

    // Where they lose the points, the check says so.
    let connection = "#include \"$FOAM_CASE/system/fsiConnection\"\n";
    let lost = templates(folder.path(), "lost", |text| {
        assert!(text.contains(connection));
        text.replace(connection, &format!("{connection}#remove functions\n"))
    });
    let out = folder.path().join("lost-run");
    let refused = driver(&out, 2, &["--set", &lost, probe]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused));
    let advice = "must include system/fsiConnection above its functions";
    assert!(text(&refused).contains(advice), "{}", text(&refused));
    assert!(!out.exists());
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn phases_are_averaged_over_beats() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    // Two beats of three steps.
    let beats = ["--set", "time.period_s=0.006", "inflow.systole_s=0.004"];
    complete(driver(&out, 6, &beats));
    let evaluate = |phases: &str| {
        Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
            .args([
                "hemodynamics",
                "--from",
                "0",
                "--to",
                "0.012",
                "--replace",
                "--phases",
                phases,
            ])
            .arg(&out)
            .output()
            .unwrap()
    };
    let refused = evaluate("4");
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        text(&refused).contains("--phases 4: expected 1 to 3"),
        "{}",
        text(&refused)
    );
    let output = evaluate("3");
    assert!(output.status.success(), "{}", text(&output));
    let (history, phases) = (
        table(&out.join("history.csv")),
        table(&out.join("phases.csv")),
    );
    assert_eq!(phases.len(), 3);
    for (i, phase) in phases.iter().enumerate() {
        assert_eq!(phase["beats"], "2");
        assert!((number(phase, "phase_s") - 0.002 * (i + 1) as f64).abs() < 1e-12);
        for name in ["Q_out_m3_s", "p_out_Pa", "max_displacement_m"] {
            let [a, b] = [&history[i], &history[i + 3]].map(|row| number(row, name));
            let close =
                |found: f64, expected: f64| (found - expected).abs() <= 1e-12 * expected.abs();
            assert!(close(number(phase, name), 0.5 * (a + b)), "{name}");
            let deviation = number(phase, &format!("{name}_std"));
            assert!(close(deviation, (a - b).abs() / 2.0_f64.sqrt()), "{name}");
        }
    }
    let states: Vec<_> = WallHistoryReader::open(&out.join("wall.bin"))
        .unwrap()
        .map(Result::unwrap)
        .collect();
    let grids = VtuSeries::read(&out.join("phases.pvd")).unwrap();
    assert_eq!(grids.len(), 3);
    for (i, (_, file)) in grids.iter().enumerate() {
        let found = point_data(&out.join(file), "mean_displacement_m");
        let [a, b] = [&states[i], &states[i + 3]].map(|state| state.displacement.as_flattened());
        let largest = a.iter().chain(b).fold(0.0_f32, |m, u| m.max(u.abs()));
        assert!(largest > 0.0 && found.len() == a.len());
        for ((found, a), b) in found.iter().zip(a).zip(b) {
            let mean = 0.5 * (f64::from(*a) + f64::from(*b));
            assert!(
                (found - mean).abs() < 1e-6 * f64::from(largest),
                "{found} {mean}"
            );
        }
    }
}
