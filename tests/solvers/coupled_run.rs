//! The command of the README, with the real OpenFOAM, on a coarse mesh for a few steps.

use crate::pfem_support::{artery, radial};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

const STEP: f64 = 0.002;

fn driver(out: &Path, end_time: f64, more: &[&str]) -> Command {
    let usual = [
        "fluid.mesh.axial_extension=10",
        "fluid.mesh.axial_per_section=12",
        "structure.axial_per_section=4",
        "output.structure_interval_s=0.01",
    ];
    // A key may be given once only.
    let key = |value: &str| value.split('=').next().unwrap().to_owned();
    let usual = usual
        .into_iter()
        .filter(|value| more.iter().all(|m| key(m) != key(value)));
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["--case", "tests/cases/S-0.25", "--preset", "demo"])
        .arg("--out")
        .arg(out)
        .args(["--end-time", &end_time.to_string()])
        .arg("--set")
        .args(usual)
        .args(more);
    command
}

/// The columns of a CSV file by name.
fn columns(path: &Path) -> BTreeMap<String, Vec<f64>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let names: Vec<String> = reader
        .headers()
        .unwrap()
        .iter()
        .map(str::to_owned)
        .collect();
    let mut columns: BTreeMap<String, Vec<f64>> =
        names.iter().map(|n| (n.clone(), Vec::new())).collect();
    for row in reader.records() {
        for (name, value) in names.iter().zip(&row.unwrap()) {
            columns.get_mut(name).unwrap().push(value.parse().unwrap());
        }
    }
    columns
}

fn text(output: &Output) -> String {
    format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}

/// Processes that work in a folder below `root`.
fn processes_in(root: &Path) -> Vec<String> {
    let in_root = |process: &PathBuf| {
        std::fs::read_link(process.join("cwd")).is_ok_and(|cwd| cwd.starts_with(root))
    };
    let all = std::fs::read_dir("/proc")
        .unwrap()
        .flatten()
        .map(|entry| entry.path());
    all.filter(in_root)
        .map(|process| process.display().to_string())
        .collect()
}

fn prescribed_flow(t: f64) -> f64 {
    let ramp = if t < 0.5 {
        0.5 * (1.0 - (PI * t / 0.5).cos())
    } else {
        1.0
    };
    let pulse = if t < 0.5 {
        (PI * (t / 0.5).powf(0.8)).sin().powi(2)
    } else {
        0.0
    };
    ramp * (5.0e-6 + 9.0e-6 * pulse)
}

/// What is lost of the flow, as a share of the larger of inflow and outflow.
fn imbalance(q_in: f64, q_out: f64, dvdt: f64) -> f64 {
    (q_in - q_out - dvdt).abs() / q_in.abs().max(q_out.abs())
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn blood_and_wall_are_in_balance_and_their_files_readable() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let output = driver(&out, 0.04, &[]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    for file in [
        "history.csv",
        "iterations.csv",
        "summary.json",
        "structure.pvd",
        "case.resolved.toml",
    ] {
        assert!(
            text(&output).contains(file) && out.join(file).is_file(),
            "{file} is not there, or not named"
        );
    }

    let history = columns(&out.join("history.csv"));
    let [time, q_in, q_out, dvdt] =
        ["time_s", "Q_in_m3_s", "Q_out_m3_s", "dVdt_m3_s"].map(|name| &history[name]);
    assert_eq!(time.len(), 20);
    let mut balance = 0.0_f64;
    for (i, &t) in time.iter().enumerate() {
        assert!((t - STEP * (i + 1) as f64).abs() < 1e-9);
        let prescribed = prescribed_flow(t);
        assert!(
            (q_in[i] - prescribed).abs() < 1e-6 * prescribed,
            "inflow {} instead of {prescribed}",
            q_in[i]
        );
        balance = balance.max(imbalance(q_in[i], q_out[i], dvdt[i]));
        assert!(history["wall_velocity_mismatch_m_s"][i] < 1e-9);
        assert!(history["force_mismatch"][i] < 1e-3);
    }
    println!("largest imbalance {balance:e} of the flow");
    assert!(balance < 1e-4, "{balance:e}");
    assert!(
        history["max_displacement_m"][19] > 1e-6,
        "the wall did not move"
    );
    assert!(history["max_von_mises_Pa"][19] > 1.0);

    // C dp/dt + p/R = Q, implicit Euler, with the pressure before the ramp.
    let (r, c) = (1.785e9, 1.83e-10);
    let p = &history["p_windkessel_Pa"];
    for i in 1..time.len() {
        let left = c * (p[i] - p[i - 1]) / STEP + p[i] / r;
        let size = p[i] / r;
        assert!(
            (left - q_out[i]).abs() < 1e-4 * size,
            "windkessel at {} s: {left} instead of {}",
            time[i],
            q_out[i]
        );
    }

    let iterations = columns(&out.join("iterations.csv"));
    assert_eq!(
        iterations["time_s"].len() as f64,
        history["coupling_iterations"].iter().sum::<f64>()
    );
    let summary: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    assert_eq!(
        (summary["status"].as_str(), summary["steps"].as_u64()),
        (Some("complete"), Some(20))
    );

    let wall = vtkio::Vtk::import(out.join("structure/00003.vtu")).unwrap();
    let vtkio::model::DataSet::UnstructuredGrid { pieces, .. } = wall.data else {
        panic!("not an unstructured grid")
    };
    let vtkio::model::Piece::Inline(piece) = &pieces[0] else {
        panic!("no piece")
    };
    assert!(piece.num_points() > 1000);
    assert!(
        processes_in(&out).is_empty(),
        "a process is still at work in {}",
        out.display()
    );

    let again = driver(&out, 0.04, &[]).output().unwrap();
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again).contains("--force"), "{}", text(&again));
    assert_eq!(
        columns(&out.join("history.csv")),
        history,
        "a refused run must not touch the earlier one"
    );
}

/// The smooth artery at 107 mmHg, where its fibres carry the load: filled from the windkessel within a ramp of 0.1 s,
/// then compared with the boundary value problem of the radius in plane strain.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn stiff_fibres_hold_the_wall_at_arterial_pressure() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let coarse = [
        "--set",
        "model.d_max_m=0",
        "fluid.mesh.axial_extension=4",
        "fluid.mesh.axial_per_section=6",
        "structure.axial_per_section=2",
        "time.step_s=0.005",
        "ramp.duration_s=0.1",
        "windkessel.initial_pressure_Pa=2.2e4",
        "output.probes_m=[[0.045,3.2e-3,0],[0.045,0,-3.2e-3]]",
    ];
    let output = driver(&out, 0.15, &coarse).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    let history = columns(&out.join("history.csv"));
    let [q_in, q_out, dvdt, p_in, p_out] = [
        "Q_in_m3_s",
        "Q_out_m3_s",
        "dVdt_m3_s",
        "p_in_Pa",
        "p_out_Pa",
    ]
    .map(|name| &history[name]);
    let balances = (0..30).map(|i| imbalance(q_in[i], q_out[i], dvdt[i]));
    let balance = balances.fold(0.0, f64::max);
    println!("largest imbalance {balance:e} of the flow");
    assert!(balance < 1e-4, "{balance:e}");

    let pressure = 0.5 * (p_in[29] + p_out[29]);
    let mmhg = pressure / 133.322;
    assert!((105.0..118.0).contains(&mmhg), "{mmhg}");
    let layers: Vec<_> = artery().into_iter().map(|m| (0.55e-3, m)).collect();
    let exact = radial::inflate(3.2e-3, &layers, pressure, true).displacement[0];
    let probes = columns(&out.join("probes.csv"));
    let [y, z] = [probes["uy_m"][58], -probes["uz_m"][59]];
    println!("{mmhg} mmHg: widened by {y} and {z} m, in plane strain by {exact} m");
    // The fibres carry it: what is isotropic in the layers bears at most Σ mu ln(r_o/r_i) = 9.3 kPa = 70 mmHg.
    // Measured 0.964 times the exact widening: too stiff on elements of 15 mm.
    for found in [y, z] {
        assert!((0.95..0.98).contains(&(found / exact)), "{found} {exact}");
    }
    let iterations = history["coupling_iterations"].iter().sum::<f64>() / 30.0;
    println!("{iterations} coupling iterations per step");
    // Measured 4.9.
    assert!((4.0..6.0).contains(&iterations), "{iterations}");
}

/// With tolerances so tight that the order of the sums in the linear solvers no longer matters (measured: 2e-8), and
/// not tighter: displacements of 7 µm, as in the first step, have a round-off of 1e-13 m.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn one_and_two_ranks_and_both_transports_agree() {
    let folder = tempfile::tempdir().unwrap();
    let tight = [
        "--set",
        "fluid.pressure_residual=1e-7",
        "fluid.max_correctors=60",
        "coupling.e_rel=1e-7",
        "coupling.e_abs_m=1e-14",
        "ramp.duration_s=0.05",
        "structure.newton_tolerance=1e-12",
    ];
    let history = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let output = driver(&out, 0.008, &[&tight, more].concat()).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{}", text(&output));
        columns(&out.join("history.csv"))
    };
    let one = history("one", &[]);
    let two = history("two", &["--ranks", "2"]);
    let files = history("files", &["fluid.transport=files"]);
    for name in [
        "Q_out_m3_s",
        "p_in_Pa",
        "p_out_Pa",
        "lumen_volume_m3",
        "max_displacement_m",
    ] {
        assert_eq!(one[name], files[name], "{name} over files");
        let size = one[name].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for (a, b) in one[name].iter().zip(&two[name]) {
            assert!(
                (a - b).abs() < 1e-6 * size,
                "{name}: {a} on one rank, {b} on two"
            );
        }
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn an_interrupt_ends_openfoam_and_leaves_the_run_readable() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let mut child = driver(&out, 10.0, &["--quiet"]).spawn().unwrap();
    let begun = Instant::now();
    while std::fs::read_to_string(out.join("history.csv")).map_or(0, |text| text.lines().count())
        < 3
    {
        assert!(
            child.try_wait().unwrap().is_none() && begun.elapsed() < Duration::from_secs(120),
            "no step was done"
        );
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(!processes_in(&out).is_empty());
    let id = rustix::process::Pid::from_child(&child);
    rustix::process::kill_process(id, rustix::process::Signal::INT).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(processes_in(&out).is_empty(), "OpenFOAM is still at work");
    let steps = columns(&out.join("history.csv"))["time_s"].len() as u64;
    let summary: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    assert_eq!(
        (summary["status"].as_str(), summary["steps"].as_u64()),
        (Some("interrupted"), Some(steps))
    );
}

/// Without OpenFOAM or the adapter one sentence names the command that mends it.
#[test]
fn missing_openfoam_is_named_with_its_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    for (variable, value) in [
        ("PATH", "/nowhere"),
        ("FSI_DRIVER_ADAPTER", "/nowhere/lib.so"),
    ] {
        let output = driver(&out, 0.01, &[])
            .env(variable, value)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        let said = text(&output);
        assert!(
            said.contains("of-adapter/setup.sh") && said.trim().lines().count() == 1,
            "{said}"
        );
        assert!(!out.exists());
    }
}

#[test]
fn bad_input_is_refused_with_nothing_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    for (argument, named) in [
        ("coupling.e_rle=1e-3", "e_rle"),
        ("time.step_s=-1", "time.step_s"),
        ("structure.p=2", "structure.p"),
        ("nonsense", "KEY=VALUE"),
    ] {
        let output = driver(&out, 0.01, &["--set", argument]).output().unwrap();
        assert_eq!(
            output.status.code(),
            Some(2),
            "{argument}: {}",
            text(&output)
        );
        assert!(
            text(&output).contains(named),
            "{argument}: {}",
            text(&output)
        );
        assert!(!out.exists());
    }
}

/// Curves as people have them: with comments, over a part of the period, over another period than a second.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_curve_that_is_accepted_drives_the_inflow() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("flow.csv");
    let curve = format!("inflow.file={}", file.display());
    for (period, rows, expected) in [
        (
            1.0,
            "# measured by ultrasound\ntime_s,flow_m3_s\n0,1e-6\n0.004,4e-6\n# and on\n0.008,3e-6\n0.5,2e-6\n1,1e-6\n",
            [(0.004, 4e-6), (0.008, 3e-6)],
        ),
        // Flat from the last time to the first one of the next period.
        (
            1.0,
            "time_s,flow_m3_s\n0.025,2e-6\n0.3,5e-6\n0.975,2e-6\n",
            [(0.002, 2e-6), (0.01, 2e-6)],
        ),
        (
            0.8,
            "time_s,flow_m3_s\n0,3e-6\n0.006,5e-6\n0.2,4e-6\n0.476,3e-6\n",
            [(0.006, 5e-6), (0.006, 5e-6)],
        ),
    ] {
        std::fs::write(&file, rows).unwrap();
        let period = format!("time.period_s={period}");
        let more = ["--set", &curve, &period, "--force"];
        let out = folder.path().join("run");
        let output = driver(&out, 0.01, &more).output().unwrap();
        assert!(output.status.success(), "{}", text(&output));
        let history = columns(&out.join("history.csv"));
        for (t, flow) in expected {
            let i = (t / STEP).round() as usize - 1;
            let ramp = 0.5 * (1.0 - (PI * t / 0.5).cos());
            let found = history["Q_in_m3_s"][i] / ramp;
            assert!((found / flow - 1.0).abs() < 1e-6, "{t} s: {found} {flow}");
        }
    }
}

/// `check` and the run look at the same: what a run would refuse after its first files is found before.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn what_a_run_reads_is_checked_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let templates = |name: &str, change: &dyn Fn(&Path)| {
        let to = folder.path().join(name);
        for part in ["0", "constant", "system"] {
            let from = Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("openfoam-case/base")
                .join(part);
            std::fs::create_dir_all(to.join(part)).unwrap();
            for file in std::fs::read_dir(from).unwrap().flatten() {
                std::fs::copy(file.path(), to.join(part).join(file.file_name())).unwrap();
            }
        }
        change(&to);
        format!("fluid.templates={}", to.display())
    };
    let no_system = templates("a", &|t| std::fs::remove_dir_all(t.join("system")).unwrap());
    let no_p = templates("b", &|t| std::fs::remove_file(t.join("0/p")).unwrap());
    let rubbish = templates("c", &|t| {
        std::fs::write(t.join("0/U"), "rubbish\n").unwrap()
    });
    let unknown = templates("d", &|t| {
        let text = std::fs::read_to_string(t.join("0/U")).unwrap();
        std::fs::write(t.join("0/U"), text.replace("noSlip", "noSlop")).unwrap();
    });
    let no_scheme = templates("e", &|t| {
        let text = std::fs::read_to_string(t.join("system/fvSchemes")).unwrap();
        std::fs::write(
            t.join("system/fvSchemes"),
            text.replace("div(phi,U)", "div(phi,V)"),
        )
        .unwrap();
    });
    let mistakes: [(&[&str], &[&str]); 11] = [
        (
            &["--set", &unknown],
            &[
                "`fluid.templates` = ",
                "OpenFOAM refuses it: ",
                "/d/0/U",
                "noSlop",
            ],
        ),
        (
            &["--set", &no_scheme],
            &[
                "`fluid.templates` = ",
                "OpenFOAM refuses it: ",
                "/e/system/fvSchemes",
                "div(phi,U)",
            ],
        ),
        (
            &["--set", &no_system],
            &["`fluid.templates` = ", "it lacks system/controlDict"],
        ),
        (
            &["--set", &no_p],
            &["`fluid.templates` = ", "it lacks 0/p;"],
        ),
        (
            &["--set", &rubbish],
            &["`fluid.templates` = ", "0/U:1: the entry `rubbish`"],
        ),
        (
            &[
                "--set",
                "output.probes_m=[[0.045,3.2e-3,0.0],[15.0,0.0,0.0]]",
            ],
            &[
                "--set: `output.probes_m`",
                "probe 1, [15.0, 0.0, 0.0], does not lie on",
                "1.49e1 m away",
            ],
        ),
        (&["--ranks", "0"], &["--ranks: `fluid.ranks` = 0"]),
        (
            &["--ranks", "64"],
            &["--ranks: `fluid.ranks` = 64", "at most 34"],
        ),
        (
            &["--set", "time.step_s=1e-12"],
            &["`time.step_s`", "more than a run can take"],
        ),
        (
            &[
                "--set",
                "coupling.e_rel=1e-5",
                "--set",
                "coupling.e_rel=1e-6",
            ],
            &["`coupling.e_rel` is given twice"],
        ),
        (
            &["--set", "time.end_s=0.02"],
            &["`time.end_s` is given twice, as 0.01 by --end-time and as 0.02 by --set"],
        ),
    ];
    for (arguments, messages) in mistakes {
        let run = driver(&out, 0.01, arguments);
        let words: Vec<_> = run.get_args().map(|word| word.to_str().unwrap()).collect();
        // The words of the run without its folders.
        let check = Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .args(["check", words[1], words[2], words[3]])
            .args(&words[6..])
            .output()
            .unwrap();
        let mut run = run;
        let run = run.output().unwrap();
        for output in [&check, &run] {
            let said = text(output);
            assert_eq!(output.status.code(), Some(2), "{said}");
            assert!(messages.iter().all(|m| said.contains(m)), "{said}");
        }
        assert_eq!(text(&check), text(&run));
        assert!(!out.exists());
    }
}
