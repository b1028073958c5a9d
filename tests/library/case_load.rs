//! Layers of a case, its file of record, and the formulas that belong to it.

use approx::assert_relative_eq;
use fsi_driver::analysis::size;
use fsi_driver::case::{
    Anastomosis, BloodVessel, Case, Extension, FlowCurve, FlowUnit, Inflow, Material, Preset,
    Problem, Ramp, ResolvedCase, Shape, Solver,
};
use std::path::{Path, PathBuf};

/// The models with every preset as in the defaults.
fn tests() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases")
}

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case")
}

fn load(folder: &Path, preset: Preset, set: &[(&str, &str)]) -> ResolvedCase {
    let set: Vec<_> = set
        .iter()
        .map(|(key, value)| (key.to_string(), value.to_string()))
        .collect();
    Case::load(folder, preset, &set).unwrap_or_else(|errors| panic!("{errors}"))
}

fn vessel(case: &Case) -> &BloodVessel {
    case.vessel().unwrap()
}

/// All twelve models load with every preset and differ in the model only.
#[test]
fn all_twelve_models_load_with_every_preset() {
    let reference = load(&project().join("S-0.0"), Preset::Paper, &[]);
    for (letter, extension) in [
        ("S", Extension::Straight),
        ("H", Extension::Helix),
        ("A", Extension::Arc),
    ] {
        for d_max in ["0.0", "0.25", "0.5", "0.75"] {
            let folder = project().join(format!("{letter}-{d_max}"));
            for preset in Preset::ALL {
                let case = load(&folder, preset, &[]);
                let model = &case.anastomosis().unwrap().model;
                assert_eq!(model.extension, extension);
                assert_relative_eq!(
                    model.d_max,
                    d_max.parse::<f64>().unwrap() * 1e-3,
                    epsilon = 1e-15
                );
                assert!(case.structure.p >= 3);
                let step = match preset {
                    Preset::Demo => 0.01,
                    Preset::Fast => 0.005,
                    Preset::Coarse | Preset::Paper => 0.002,
                };
                assert_eq!((case.time.step, case.time.period), (step, 1.0));
            }
            let paper = load(&folder, Preset::Paper, &[]);
            let same_model = Case {
                problem: Problem::Vessel(BloodVessel {
                    shape: Shape::Anastomosis(Anastomosis {
                        model: reference.anastomosis().unwrap().model.clone(),
                        ..paper.anastomosis().unwrap().clone()
                    }),
                    ..vessel(&paper).clone()
                }),
                ..paper.case
            };
            assert_eq!(same_model, reference.case);
        }
    }
}

#[test]
fn presets_differ_in_resolution_and_length_only() {
    let [demo, coarse, paper] = [Preset::Demo, Preset::Coarse, Preset::Paper]
        .map(|preset| load(&tests().join("S-0.25"), preset, &[]));
    assert!(
        (4000..6000).contains(&size::fluid_cells(&demo)),
        "{}",
        size::fluid_cells(&demo)
    );
    assert!(
        (9000..11_000).contains(&size::fluid_cells(&coarse)),
        "{}",
        size::fluid_cells(&coarse)
    );
    assert!(
        size::fluid_cells(&paper) >= 30_000,
        "{}",
        size::fluid_cells(&paper)
    );
    assert_eq!(
        [demo.time.end, coarse.time.end, paper.time.end],
        [0.1, 3.0, 3.0]
    );
    assert_eq!(
        [demo.steps(), coarse.steps(), paper.steps()],
        [50, 1500, 1500]
    );
    for case in [demo, coarse] {
        let resolved = BloodVessel {
            structure: vessel(&paper).structure.clone(),
            fluid: vessel(&paper).fluid.clone(),
            ..vessel(&case).clone()
        };
        let like_paper = Case {
            problem: Problem::Vessel(resolved),
            time: paper.time.clone(),
            structure: paper.structure.clone(),
            fluid: paper.fluid.clone(),
            output: paper.output.clone(),
            ..case.case
        };
        assert_eq!(like_paper, paper.case);
    }
}

#[test]
fn the_degrees_of_freedom_are_those_of_the_trunk_space() {
    let coarse = [
        "structure.axial_per_section=1",
        "structure.circumferential=4",
        "structure.radial_per_layer=1",
    ];
    let coarse = coarse.map(|set| set.split_once('=').unwrap());
    // 2 by 4 by 2 elements: 36 vertices, 84 edges, 64 faces, 16 elements (Euler: 36 - 84 + 64 - 16 = 0).
    for (p, scalar) in [
        (3, 36 + 84 * 2),
        (4, 36 + 84 * 3 + 64),
        (6, 36 + 84 * 5 + 64 * 6 + 16),
    ] {
        let degree = p.to_string();
        let set = [&coarse[..], &[("structure.p", degree.as_str())]].concat();
        let case = load(&project().join("S-0.25"), Preset::Paper, &set);
        assert_eq!(size::structure_degrees_of_freedom(&case), 3 * scalar);
    }
}

#[test]
fn values_of_the_paper_arrive() {
    let case = load(&project().join("H-0.5"), Preset::Paper, &[]);
    assert_eq!(
        case.anastomosis().unwrap().wall.graft,
        Material::NeoHooke {
            mu: 3.33e5,
            kappa: 1.67e9,
            viscosity: None,
        }
    );
    let media = Material::HolzapfelGasserOgden {
        mu: 5.4e4,
        kappa: 1e9,
        k1: 640.0,
        k2: 3.54,
        fibre_angle_deg: 10.0,
        tension_only: false,
        dispersion: None,
        viscosity: None,
    };
    assert_eq!(case.anastomosis().unwrap().wall.media, media);
    assert_eq!(case.wall.damping, 0.01);
    assert_eq!(case.anastomosis().unwrap().geometry.imperfection.len(), 7);
    assert!(
        case.anastomosis()
            .unwrap()
            .geometry
            .imperfection
            .iter()
            .all(|row| row.len() == 5)
    );
    let templates = case.fluid.templates.join("system/fvSolution");
    let base = project().join("base/system/fvSolution");
    assert_eq!(
        std::fs::read(templates).unwrap(),
        std::fs::read(base).unwrap()
    );
}

#[test]
fn the_last_layer_wins() {
    let scratch = tempfile::tempdir().unwrap();
    let defaults = project().join("defaults.toml");
    let text = format!(
        "extends = {:?}\ntime.end_s = 0.5\n[fluid]\nmesh.core = 7\ntemplates = \"mine\"\n[preset.demo]\nfluid.mesh.radial = 9\n",
        defaults.display().to_string()
    );
    std::fs::write(scratch.path().join("case.toml"), text).unwrap();
    std::fs::create_dir(scratch.path().join("mine")).unwrap();
    let case = load(
        scratch.path(),
        Preset::Demo,
        &[("coupling.reuse_steps", "3"), ("fluid.transport", "files")],
    );
    assert_eq!(case.time.end, 0.5); // the case wins over the preset
    assert_eq!(
        (
            vessel(&case).fluid.mesh.core,
            vessel(&case).fluid.mesh.radial
        ),
        (7, 9)
    ); // the case's own preset over its plain value
    assert_eq!(case.coupling.reuse_steps, 3);
    assert_eq!(
        case.fluid.templates,
        scratch.path().canonicalize().unwrap().join("mine")
    );
    assert_eq!(
        case.origins["time.end_s"].to_string(),
        format!("{}:2", scratch.path().join("case.toml").display())
    );
    assert_eq!(case.origins["coupling.reuse_steps"].to_string(), "--set");
    assert!(
        case.origins["time.step_s"]
            .to_string()
            .contains("defaults.toml:")
    );
    // A key that is blamed and has no value stands in no line; a list of tables does.
    let own = project().join("../examples/own-case/flap");
    let own = load(&own, Preset::Paper, &[]);
    let blamed = own.mistake("wall.file.unit_m", "why".into()).to_string();
    assert_eq!(blamed, "`wall.file.unit_m`, which is not given: why");
    let blamed = own.mistake("wall.support", "why".into()).to_string();
    assert!(
        blamed.ends_with("case.toml:26: `wall.support`: why"),
        "{blamed}"
    );
    let coarse = load(
        scratch.path(),
        Preset::Coarse,
        &[("fluid.mesh", "{ core = 3, axial_extension = 8 }")],
    );
    assert_eq!(
        (
            vessel(&coarse).fluid.mesh.core,
            vessel(&coarse).fluid.mesh.radial,
            vessel(&coarse).fluid.mesh.axial_extension
        ),
        (3, 4, 8)
    );
}

#[test]
fn another_material_drops_the_old_ones_parameters() {
    let set = [
        ("wall.media.material", "saint_venant_kirchhoff"),
        ("wall.media.youngs_modulus_Pa", "3e5"),
        ("wall.media.poisson_ratio", "0.3"),
    ];
    let case = load(&project().join("S-0.0"), Preset::Demo, &set);
    assert_eq!(
        case.anastomosis().unwrap().wall.media,
        Material::SaintVenantKirchhoff {
            youngs_modulus: 3e5,
            poisson_ratio: 0.3,
            viscosity: None,
        }
    );
    let stiffer = load(
        &project().join("S-0.0"),
        Preset::Demo,
        &[("wall.graft.mu_Pa", "400000")],
    );
    assert_eq!(
        stiffer.anastomosis().unwrap().wall.graft,
        Material::NeoHooke {
            mu: 4e5,
            kappa: 1.67e9,
            viscosity: None,
        }
    );
}

#[test]
fn the_file_of_record_gives_the_same_case_whatever_the_preset() {
    let scratch = tempfile::tempdir().unwrap();
    for (model, set) in [
        ("S-0.25", vec![]),
        (
            "A-0.75",
            vec![
                ("structure.p_geometry", "2"),
                ("structure.quadrature_points", "6"),
                ("time.step_s", "0.001"),
            ],
        ),
        (
            "H-0.0",
            vec![
                ("wall.media.tension_only", "true"),
                ("inflow.base_m3_s", "1.23456789012345e-6"),
            ],
        ),
        ("turek-hron", vec![("flag.solid.poisson_ratio", "0.3")]),
    ] {
        let case = load(&project().join(model), Preset::Demo, &set);
        for text in [case.to_toml_string(), case.case.to_toml_string()] {
            assert!(text.starts_with(&format!(
                "# Every value of a run of fsi-driver {}",
                env!("CARGO_PKG_VERSION")
            )));
            // A case says nothing about what it has not.
            let tables = ["flag", "geometry", "wall.graft", "inflow", "fluid.mesh"];
            let there = tables.map(|table| text.contains(&format!("\n[{table}]\n")));
            let is_flag = model == "turek-hron";
            assert_eq!(there, [is_flag, !is_flag, !is_flag, !is_flag, !is_flag]);
            assert_eq!(text.contains("circumferential = "), !is_flag);
            let file = scratch.path().join("case.resolved.toml");
            std::fs::write(&file, &text).unwrap();
            for preset in Preset::ALL {
                assert_eq!(load(&file, preset, &[]).case, case.case);
            }
        }
    }
}

#[test]
fn the_pulse_has_the_mean_and_peak_of_its_description() {
    let case = load(&project().join("S-0.0"), Preset::Paper, &[]);
    let curve = FlowCurve::new(&vessel(&case).inflow, case.time.period).unwrap();
    let samples: Vec<f64> = (0..10_000)
        .map(|i| curve.flow(f64::from(i) * 1e-4))
        .collect();
    let mean = samples.iter().sum::<f64>() / 10_000.0;
    let peak = samples.iter().fold(0.0f64, |most, flow| most.max(*flow));
    assert_relative_eq!(mean, 7.33e-6, max_relative = 5e-3);
    assert_relative_eq!(peak, 14.0e-6, max_relative = 1e-6);
    assert_eq!(curve.flow(0.0), 5.0e-6);
    assert_eq!(curve.flow(0.7), 5.0e-6);
    assert_relative_eq!(curve.flow(0.13), curve.flow(2.13), max_relative = 1e-9);
    // Continuous where the pulse ends, with a slope that stays finite at the beginning.
    assert!((curve.flow(0.5 - 1e-6) - curve.flow(0.5)).abs() < 1e-14);
}

fn table(text: &str, period: f64) -> FlowCurve {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("flow.csv");
    std::fs::write(&file, text).unwrap();
    let inflow = Inflow::of_file(file);
    FlowCurve::new(&inflow, period).unwrap_or_else(|error| panic!("{error}"))
}

/// As hospitals, spreadsheets and SimVascular write them.
#[test]
fn flow_curves_come_in_any_unit_and_with_any_separator() {
    let scratch = tempfile::tempdir().unwrap();
    let of = |name: &str, text: &str, unit: Option<FlowUnit>, file_period: Option<f64>| {
        let file = scratch.path().join(name);
        std::fs::write(&file, text).unwrap();
        let inflow = Inflow {
            base: 0.0,
            amplitude: 0.0,
            systole: 1.0,
            exponent: 1.0,
            file: Some(file),
            unit,
            file_period,
            mean: None,
        };
        FlowCurve::new(&inflow, 0.8).unwrap_or_else(|error| panic!("{name}: {error}"))
    };
    let minute = Some(FlowUnit::MillilitreMinute);
    for curve in [
        of(
            "a.csv",
            "time_s,flow_m3_s\n0,1e-6\n0.2,5e-6\n0.4,1e-6\n0.8,1e-6\n",
            None,
            None,
        ),
        of(
            "b.csv",
            "% a comment\nt [ms];Q [ml/s]\n0;1\n200;5\n400;1\n800;1\n",
            None,
            None,
        ),
        of(
            "c.txt",
            "time\tflow_ml_min\n0\t60\n0.2\t300\n0.4\t60\n",
            None,
            None,
        ),
        of(
            "d.csv",
            "0 60\n0.25 300\n0.5 60\n1.0 60\n",
            minute,
            Some(1.0),
        ),
        // What enters is negative there
        of("e.flow", "0 -1\n0.2 -5\n0.4 -1\n0.8 -1\n", None, None),
        of(
            "f.flow",
            "0 -1000\n0.2 -5000\n0.4 -1000\n0.8 -1000\n",
            Some(FlowUnit::CubicMillimetreSecond),
            None,
        ),
    ] {
        for (t, flow) in [
            (0.0, 1e-6),
            (0.1, 3e-6),
            (0.2, 5e-6),
            (1.0, 5e-6),
            (0.5, 1e-6),
        ] {
            assert_relative_eq!(curve.flow(t), flow, max_relative = 1e-12);
        }
    }
}

/// A steady beat of 1 to 5 ml/s in every shape that files come in.
#[test]
fn the_same_flow_is_read_from_every_shape_of_table() {
    let scratch = tempfile::tempdir().unwrap();
    let rows = [(0.0, 1.0), (0.2, 5.0), (0.4, 1.25)];
    let table = |head: &str, between: &str, factor: f64, more: &str| -> String {
        let rows = rows.map(|(t, q)| format!("{t}{between}{}{more}\n", q * factor));
        format!("{head}{}", rows.concat())
    };
    let commas = |text: String| text.replace('.', ",");
    for (name, text, said) in [
        (
            "tab.txt",
            table("time (s)\tflow (ml/s)\n", "\t", 1.0, ""),
            "separated by tabs",
        ),
        (
            "german.csv",
            commas(table("Zeit (s);Fluss (ml/s)\n", ";", 1.0, "")),
            "semicolons, decimal commas",
        ),
        (
            "bom.csv",
            table("\u{feff}time (s),Q (mL/sec)\r\n", ",", 1.0, "\r"),
            "flow in \"Q (mL/sec)\"",
        ),
        (
            "two-lines.csv",
            table("time,flow\ns,ml/s\n", ",", 1.0, ""),
            "3 rows",
        ),
        (
            "superscript.csv",
            table("time (s),Q (cm³/s)\n", ",", 1.0, ""),
            "(cm3/s)",
        ),
        (
            "micro.csv",
            table("time (s),Q (µl/s)\n", ",", 1000.0, ""),
            "(mm3/s)",
        ),
        (
            "greek.csv",
            table("time (s),Q (μl/s)\n", ",", 1000.0, ""),
            "(mm3/s)",
        ),
        (
            "third.csv",
            table("time_s,flow_ml_s,sd\n", ",", 1.0, ",0.1"),
            "\"sd\" left out",
        ),
        (
            "pandas.csv",
            ",time_s,flow_ml_s\n0,0.0,1\n1,0.2,5\n2,0.4,1.25\n".into(),
            "\"time_s\"",
        ),
        (
            "swapped.csv",
            "flow_ml_s,time_s\n1,0.0\n5,0.2\n1.25,0.4\n".into(),
            "times in \"time_s\"",
        ),
        (
            "counts.flow",
            table("3 2\n", " ", -1.0, ""),
            "negative values enter",
        ),
        (
            "positive.flow",
            table("", " ", 1.0, ""),
            "positive values enter, as in SimVascular's 0-D and 1-D solvers",
        ),
        (
            "negative.flow",
            table("", "   ", -1.0, ""),
            "as in SimVascular's 3-D solver: their sign is changed",
        ),
        (
            "cubic-mm.flow",
            table(
                "#\n# time\tflow  \n#  (s)\t(mm^3/sec)\n#\n",
                "\t",
                -1000.0,
                "",
            ),
            "(mm3/s)",
        ),
        (
            "words.flow",
            table("# inflow in mm^3/s\n", " ", -1000.0, ""),
            "(mm3/s)",
        ),
        (
            "minutes.csv",
            table("t [ms],Q / ml/min\n", ",", 60.0, "")
                .replace("\n0.2,", "\n200,")
                .replace("\n0.4,", "\n400,"),
            "(ms)",
        ),
        (
            "latin1.csv",
            table("time (s),Q (cm3/s)\n", ",", 1.0, ""),
            "(cm3/s)",
        ),
    ] {
        let file = scratch.path().join(name);
        let mut bytes = text.into_bytes();
        if name == "latin1.csv" {
            bytes = String::from_utf8(bytes)
                .unwrap()
                .replace("cm3", "cm\u{b3}")
                .chars()
                .map(|c| c as u8)
                .collect();
        }
        std::fs::write(&file, bytes).unwrap();
        let inflow = Inflow::of_file(file);
        let curve = FlowCurve::new(&inflow, 0.8).unwrap_or_else(|e| panic!("{name}: {e}"));
        let understood = curve.table().unwrap().understood();
        assert!(understood.contains(said), "{name}: {understood}");
        for (t, q) in rows {
            assert_relative_eq!(curve.flow(t), 1e-6 * q, max_relative = 1e-12);
        }
    }
    // What a file of two equal values says is a steady flow.
    let steady = table_of(
        &scratch.path().join("steady.flow"),
        "0 -2000\n0.8 -2000\n",
        Some(FlowUnit::CubicMillimetreSecond),
    );
    assert_relative_eq!(steady.flow(0.3), 2e-6, max_relative = 1e-12);
    assert_eq!(steady.gap(3.0), None);
}

fn table_of(file: &Path, text: &str, unit: Option<FlowUnit>) -> FlowCurve {
    std::fs::write(file, text).unwrap();
    let inflow = Inflow {
        unit,
        ..Inflow::of_file(file.to_owned())
    };
    FlowCurve::new(&inflow, 0.8).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_flow_curve_interpolates_repeats_and_never_overshoots() {
    let text = "# measured\ntime_s, flow_m3_s\n0.0,1e-6\n0.1,5e-6\n0.2,5e-6\n\n0.5,2e-6\r\n0.8,1e-6\n1.0,1e-6\n";
    let curve = table(text, 1.0);
    for (t, flow) in [
        (0.0, 1e-6),
        (0.1, 5e-6),
        (0.5, 2e-6),
        (1.0, 1e-6),
        (2.2, 5e-6),
        (-0.5, 2e-6),
    ] {
        assert_relative_eq!(curve.flow(t), flow, max_relative = 1e-12);
    }
    for i in 0..3000 {
        let flow = curve.flow(f64::from(i) * 1e-3);
        assert!((1e-6 * (1.0 - 1e-12)..=5e-6 * (1.0 + 1e-12)).contains(&flow));
    }
    // Straight between equal values.
    assert_relative_eq!(curve.flow(0.15), 5e-6, max_relative = 1e-12);
    // Neither the beginning nor the end of the period need be named.
    let inner = table("time_s,flow_m3_s\n0.1,1e-6\n0.4,3e-6\n0.7,2e-6\n", 0.8);
    assert_relative_eq!(inner.flow(0.1), inner.flow(0.9), max_relative = 1e-12);
    let (before, after) = (inner.flow(0.8 - 1e-9), inner.flow(0.8 + 1e-9));
    assert_relative_eq!(before, after, max_relative = 1e-6);
}

#[test]
fn a_dense_table_reproduces_a_smooth_curve() {
    let smooth = |t: f64| 4e-6 + 2e-6 * (std::f64::consts::TAU * t).sin();
    let rows: String = (0..200)
        .map(|i| {
            format!(
                "{},{}\n",
                f64::from(i) / 200.0,
                smooth(f64::from(i) / 200.0)
            )
        })
        .collect();
    let curve = table(&format!("time_s,flow_m3_s\n{rows}"), 1.0);
    for i in 0..1000 {
        let t = f64::from(i) / 1000.0;
        assert_relative_eq!(curve.flow(t), smooth(t), max_relative = 2e-4);
    }
}

#[test]
fn the_ramp_is_continuously_differentiable() {
    let ramp = Ramp { duration: 0.5 };
    assert_eq!(
        (
            ramp.factor(-1.0),
            ramp.factor(0.0),
            ramp.factor(0.5),
            ramp.factor(2.0)
        ),
        (0.0, 0.0, 1.0, 1.0)
    );
    assert_relative_eq!(ramp.factor(0.25), 0.5, max_relative = 1e-12);
    let h = 1e-6;
    for t in [0.0, 0.5] {
        assert!((ramp.factor(t + h) - ramp.factor(t - h)).abs() / h < 1e-4);
    }
    assert_eq!(Ramp { duration: 0.0 }.factor(0.0), 1.0);
}

#[test]
fn what_makes_results_doubtful_is_said() {
    let warnings = |set: &[(&str, &str)], cores: usize| {
        load(&project().join("S-0.25"), Preset::Coarse, set).warnings(cores)
    };
    assert_eq!(warnings(&[], 1), Vec::<String>::new());
    let start = warnings(&[("time.end_s", "0.75")], 1);
    assert!(
        start.len() == 1 && start[0].contains("smooth start"),
        "{start:?}"
    );
    let part = [("time.end_s", "1.5"), ("output.window_start_s", "0.75")];
    let window = warnings(&part, 1);
    assert!(
        window.len() == 1 && window[0].contains("covers 0.75 periods"),
        "{window:?}"
    );
    // The first look at a model shows a quarter of a beat, without a warning.
    let demo = load(&project().join("S-0.25"), Preset::Demo, &[]);
    assert_eq!(demo.warnings(1), Vec::<String>::new());
    let ranks = warnings(&[("fluid.ranks", "3")], 2);
    assert!(
        ranks.len() == 1 && ranks[0].contains("--ranks") && ranks[0].contains("2 core(s)"),
        "{ranks:?}"
    );
    // Nobody evaluates the wall shear of a flag.
    let flag = load(&project().join("turek-hron"), Preset::Demo, &[]);
    assert_eq!(flag.warnings(1), Vec::<String>::new());

    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("flow.csv");
    let curve = ("inflow.file", file.to_str().unwrap());
    std::fs::write(
        &file,
        "time_s,flow_m3_s\n0,1e-6\n0.1,3e-6\n0.2,2e-6\n0.5,1e-6\n",
    )
    .unwrap();
    assert_eq!(warnings(&[curve], 1), Vec::<String>::new());
    let gap = warnings(&[curve, ("time.period_s", "1.5"), ("time.end_s", "3.0")], 1);
    assert!(
        gap.len() == 1 && gap[0].contains("from 0.5 to 1.5 s"),
        "{gap:?}"
    );
}

/// A program for the blood is found next to its case and chooses the solver.
#[test]
fn a_fluid_program_is_found_next_to_its_case() {
    let folder = tempfile::tempdir().unwrap();
    let base = tests().join("S-0.25/case.toml");
    let write = |fluid: &str| {
        let text = format!(
            "extends = {:?}\n[fluid]\n{fluid}\n",
            base.display().to_string()
        );
        std::fs::write(folder.path().join("case.toml"), text).unwrap();
    };
    std::fs::write(folder.path().join("my_fluid.py"), "").unwrap();
    write("command = [\"python3\", \"my_fluid.py\", \"--not-a-file\"]");
    let load = |set: &[(String, String)]| Case::load(folder.path(), Preset::Demo, set).unwrap();
    let case = load(&[]);
    let script = folder.path().join("my_fluid.py").display().to_string();
    assert_eq!(case.fluid.command, ["python3", &script, "--not-a-file"]);
    assert_eq!(case.fluid.solver, Solver::External);
    // What is written is read as the same, and who is chosen by name counts.
    std::fs::write(folder.path().join("case.toml"), case.to_toml_string()).unwrap();
    assert_eq!(load(&[]).case, case.case);
    let chosen = load(&[("fluid.solver".into(), "openfoam".into())]);
    assert_eq!(chosen.fluid.solver, Solver::OpenFoam);
    write("command = [\"./solver\"]");
    let solver = folder.path().join("solver").display().to_string();
    assert_eq!(load(&[]).fluid.command, [solver]);
    write("await = true");
    assert_eq!(load(&[]).fluid.solver, Solver::External);
}

/// What a file says of cross-sections is recorded by those of the case, by the names up to a colon.
#[test]
fn measured_cross_sections_are_those_of_the_case() {
    let case = project().join("../examples/trees/aorta");
    let published = case.join("published.csv").display().to_string();
    let measured = ("output.measured", published.as_str());
    load(&case, Preset::Paper, &[measured]);
    let renamed = [measured, ("output.section[0].name", "elsewhere")];
    let renamed: Vec<_> = renamed
        .map(|(key, value)| (key.into(), value.into()))
        .to_vec();
    let error = Case::load(&case, Preset::Paper, &renamed).unwrap_err();
    let error = error.to_string();
    assert!(
        error.contains("`mid-aorta: pressure` is recorded by the cross-section \"mid-aorta\""),
        "{error}"
    );
}
