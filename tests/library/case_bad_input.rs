//! A table of mistakes: each is reported with its key, and quickly.

use fsi_driver::case::{Case, CaseError, CaseErrors, Override, Preset, RunEnds, ValuePlace};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case")
}

fn refuse(file: &Path, set: &[(&str, &str)]) -> CaseErrors {
    refuse_within(Duration::from_secs(1), file, set)
}

fn refuse_within(limit: Duration, file: &Path, set: &[(&str, &str)]) -> CaseErrors {
    let set: Vec<_> = set
        .iter()
        .map(|(key, value)| (key.to_string(), value.to_string()))
        .collect();
    let start = Instant::now();
    let result = Case::load(file, Preset::Demo, &set);
    assert!(start.elapsed() < limit, "took {:?}", start.elapsed());
    match result {
        Ok(_) => panic!("{}: {set:?} was accepted", file.display()),
        Err(errors) => errors,
    }
}

/// `--set key=value` on the model, and what the message must contain besides the key.
#[rustfmt::skip]
const SINGLE: &[(&str, &str, &str, &str)] = &[
    // model, key, value, message
    ("S-0.0", "inlet.condition", "pressure", "add inlet.pressure_Pa, or inlet.file"),
    ("S-0.0", "inlet.condition", "presure", "\"pressure\""),
    ("S-0.0", "inlet.pressure_Pa", "100.0", "write inlet.condition = \"pressure\""),
    ("S-0.0", "inlet.unit", "mmHg", "there is none: leave it out"),
    ("S-0.0", "inflow.unit", "ml/min", "there is none: leave it out"),
    ("S-0.0", "outlet.condition", "resistance", "add outlet.resistance_Pa_s_m3"),
    ("S-0.0", "outlet.condition", "pressure", "add outlet.pressure_Pa, or outlet.file"),
    ("S-0.0", "outlet.resistance_Pa_s_m3", "1e8", "does not belong to the outlet's condition \"windkessel\""),
    ("S-0.0", "outlet.pressure_Pa", "1e3", "does not belong to the outlet's condition \"windkessel\""),
    ("S-0.0", "windkessel.proximal_resistance_Pa_s_m3", "-1.0", "expected a number from 0.0"),
    ("turek-hron", "flag.cylinder_x_m", "0.05", "downstream of the inlet"),
    ("turek-hron", "flag.cylinder_y_m", "0.37", "less than 0.36"),
    ("turek-hron", "flag.channel_height_m", "0.05", "flag.cylinder_y_m"),
    ("turek-hron", "flag.thickness_m", "0.06", "at most flag.cylinder_radius_m"),
    ("turek-hron", "flag.length_m", "2.3", "flag.channel_length_m"),
    ("turek-hron", "flag.lenght_m", "0.3", "did you mean `flag.length_m`?"),
    ("turek-hron", "flag.mesh.cell_size_m", "1e-9", "a thousandth of"),
    ("turek-hron", "flag.mesh.largest_cell_m", "1e-3", "at least flag.mesh.cell_size_m"),
    ("turek-hron", "flag.solid.mu_Pa", "1e6", "it has viscosity_Pa_s, youngs_modulus_Pa"),
    ("turek-hron", "coupling.surrogate", "tube", "write \"potential\" or \"none\""),
    ("S-0.0", "coupling.surrogate", "potential", "write \"tube\""),
    ("S-0.25", "model.extension", "spiral", "\"straight\", \"helix\", \"arc\""),
    ("S-0.25", "model.extension", "strait", "did you mean \"straight\"?"),
    ("S-0.25", "model.extension", "3", "one of"),
    ("S-0.25", "model.d_max_m", "-1e-4", "a number from 0.0"),
    ("S-0.25", "model.d_max_m", "0.25", "a number from 0.0"),
    ("S-0.25", "model.d_max_m", "3.1e-3", "closes the lumen"),
    ("S-0.25", "model.d_max_m", "nan", "a number from"),
    ("S-0.25", "model.d_max_m", "\"0.25 mm\"", "a number from"),
    ("S-0.25", "model.dmax_m", "1e-4", "did you mean `model.d_max_m`?"),
    ("S-0.25", "geometry.graft_length_m", "0", "above 0.0"),
    ("S-0.25", "geometry.artery_length_m", "inf", "a number above"),
    ("S-0.25", "geometry.graft_inner_radius_m", "3.0", "at most 0.1"),
    ("S-0.25", "geometry.graft_thickness_m", "0", "above 0.0"),
    ("S-0.25", "geometry.graft_thickness_m", "-0.5e-3", "above 0.0"),
    ("S-0.25", "geometry.artery_inner_radius_m", "0.2e-3", "closes the lumen"),
    ("S-0.25", "geometry.media_thickness_m", "0.0", "above 0.0"),
    ("S-0.25", "geometry.adventitia_thickness_m", "true", "a number above"),
    ("S-0.25", "geometry.blend_length_m", "0.0", "above 0.0"),
    ("S-0.25", "geometry.blend_length_m", "0.1", "fit into each section"),
    ("S-0.25", "geometry.extension_length_m", "-0.1", "from 0.0"),
    ("H-0.25", "geometry.helix_radius_m", "8e-3", "one turn is longer"),
    ("H-0.25", "geometry.helix_radius_m", "7.15e-3", "turns are"),
    ("H-0.25", "geometry.helix_radius_m", "0.1e-3", "turns are"),
    ("H-0.25", "geometry.extension_length_m", "0.018", "geometry.helix_radius_m"),
    ("A-0.25", "geometry.arc_angle_deg", "0", "above 0.0"),
    ("A-0.25", "geometry.arc_angle_deg", "300", "at most 270.0"),
    ("A-0.25", "geometry.extension_length_m", "0.006", "geometry.arc_angle_deg"),
    ("A-0.25", "fluid.mesh.axial_extension", "3", "at least 4 cells"),
    ("S-0.25", "geometry.imperfection", "1", "rows of equally many"),
    ("S-0.25", "geometry.imperfection", "[]", "rows of equally many"),
    ("S-0.25", "geometry.imperfection", "[[0,0,0],[1,1,1]]", "at least 3 by 3"),
    ("S-0.25", "geometry.imperfection", "[[0,0,0],[1,1],[0,0,0]]", "equally many"),
    ("S-0.25", "geometry.imperfection", "[[0,0,0],[1,2,1],[0,0,0]]", "from 0 to 1"),
    ("S-0.25", "geometry.imperfection", "[[0,0,0],[1,-0.5,1],[0,0,0]]", "from 0 to 1"),
    ("S-0.25", "geometry.imperfection", "[[0,0.1,0],[1,1,1],[0,0,0]]", "first and the last row zero"),
    ("S-0.25", "geometry.imperfection", "[[0,0,0],[0,0,0],[0,0,0]]", "all support values are zero"),
    ("S-0.25", "geometry.imperfection", "[[0,0,0,0],[0,0,1,0],[0,0,0,0],[0,0,0,0]]", "dips to"),
    ("S-0.25", "wall.density_kg_m3", "0", "above 0.0"),
    ("S-0.25", "wall.damping_1_s", "-0.01", "from 0.0"),
    ("S-0.25", "wall.graft.material", "neo_hook", "did you mean \"neo_hooke\"?"),
    ("S-0.25", "wall.graft.k1_Pa", "1.0", "neo_hooke has no such parameter; it has mu_Pa, kappa_Pa"),
    ("S-0.25", "wall.graft.mu_Pa", "0", "above 0.0"),
    ("S-0.25", "wall.media.kappa_Pa", "1e4", "2/3 of wall.media.mu_Pa"),
    ("S-0.25", "wall.media.fibre_angle_deg", "100", "from 0.0 to 90.0"),
    ("S-0.25", "wall.media.tension_only", "1", "true or false"),
    ("S-0.25", "wall.adventitia.k2", "-1", "from 0.0"),
    ("S-0.25", "wall.intima.mu_Pa", "1e4", "unknown key"),
    ("S-0.25", "blood.density_kg_m3", "-1050", "above 0.0"),
    ("S-0.25", "blood.viscosity_Pa_s", "0", "above 0.0"),
    ("S-0.25", "inflow.systole_s", "1.5", "time.period_s"),
    ("S-0.25", "inflow.mean_m3_s", "2.0", "from -1.0 to 1.0"),
    ("S-0.25", "inflow.exponent", "0", "from 0.1"),
    ("S-0.25", "inflow.file", "no-such-curve.csv", "no-such-curve.csv"),
    ("S-0.25", "inflow.file", "", "a path in quotes"),
    ("S-0.25", "windkessel.resistance_Pa_s_m3", "0", "above 0.0"),
    ("S-0.25", "windkessel.compliance_m3_Pa", "-1.2e-10", "above 0.0"),
    ("S-0.25", "windkessel.initial_pressure_Pa", "1e9", "from -1e6 to 1e6"),
    ("S-0.25", "windkessel.resistence_Pa_s_m3", "1e9", "did you mean `windkessel.resistance_Pa_s_m3`?"),
    ("S-0.25", "ramp.duration_s", "-0.5", "from 0.0"),
    ("S-0.25", "time.step_s", "0", "above 0.0"),
    ("S-0.25", "time.step_s", "0.003", "whole part of time.period_s"),
    ("S-0.25", "time.end_s", "0.0009", "a time.step_s = 0.002 at least"),
    ("S-0.25", "time.period_s", "0", "above 0.0"),
    ("S-0.25", "time.dt_s", "0.001", "unknown key"),
    ("S-0.25", "structure.step_s", "0.001", "did you mean `time.step_s`?"),
    ("S-0.25", "max_iterations", "9", "did you mean `coupling.max_iterations`?"),
    ("S-0.25", "time", "0.002", "unknown key"),
    ("S-0.25", "structure.p", "2", "a whole number from 3 to 10"),
    ("S-0.25", "structure.p", "3.0", "a whole number from 3 to 10"),
    ("S-0.25", "structure.p_geometry", "5", "structure.p = 4"),
    ("S-0.25", "structure.p_geometry", "1", "straight edges"),
    ("S-0.25", "structure.circumferential", "2", "from 3 to 1000"),
    ("S-0.25", "structure.axial_per_section", "-8", "from 1 to 1000"),
    ("S-0.25", "structure.newton_tolerance", "0", "from 1e-14"),
    ("S-0.25", "fluid.ranks", "0", "from 1 to 1024"),
    ("S-0.25", "fluid.command", "[]", "1 to 100 words in brackets"),
    ("S-0.25", "fluid.command", "\"python3 my_fluid.py\"", "a program and its arguments"),
    ("S-0.25", "fluid.command", "[\"python3\", 3]", "a program and its arguments"),
    ("S-0.25", "fluid.command", "[\"\"]", "a program and its arguments"),
    ("S-0.25", "fluid.await", "1", "true or false"),
    ("S-0.25", "fluid.solver", "external", "needs the program, fluid.command"),
    ("turek-hron", "fluid.solver", "native", "knows no flag in a channel"),
    ("silicone-filament", "wall.gravity.acceleration_m_s2", "[0.97]", "expected three numbers, along x, y and z, found 1"),
    ("silicone-filament", "wall.gravity.acceleration_m_s2", "[0.0, nan, 0.0]", "expected 1 to 3 numbers in brackets"),
    ("silicone-filament", "wall.gravity.ramp_s", "-0.5", "expected a number from 0.0"),
    ("silicone-filament", "wall.initial.pressure_Pa", "1e3", "leave out [wall.gravity] or [wall.initial]"),
    ("S-0.25", "wall.gravity.ramp_s", "0.5", "wall.gravity.ramp_s"),
    ("../examples/own-case/bifurcation", "time.scheme", "bdf2", "ddtSchemes { default backward; }"),
    ("S-0.25", "fluid.transport", "pipe", "\"socket\", \"files\""),
    ("S-0.25", "fluid.templates", "7", "a path in quotes"),
    ("S-0.25", "fluid.templates", "no-such-folder", "there is no folder"),
    ("S-0.25", "fluid.mesh.core", "1", "from 2 to 200"),
    ("S-0.25", "fluid.mesh.radial", "0", "from 1 to 200"),
    ("S-0.25", "fluid.mesh.wall_grading", "0", "from 0.1"),
    ("S-0.25", "fluid.mesh.axial_extension", "99999999999999999999", "whole number"),
    ("S-0.25", "coupling.acceleration", "iqn-ls", "did you mean \"iqn_ls\"?"),
    ("S-0.25", "coupling.relaxation", "1.5", "at most 1.0"),
    ("S-0.25", "coupling.predictor", "cubic", "\"quadratic\""),
    ("S-0.25", "coupling.e_rel", "0", "above 0.0"),
    ("S-0.25", "coupling.max_iterations", "0", "from 1"),
    ("S-0.25", "coupling.reuse_steps", "-1", "from 0 to 1000"),
    ("S-0.25", "output.fluid_interval_s", "0", "above 0.0"),
    ("S-0.25", "output.window_start_s", "0.5", "less than the end of the window, 0.1 s"),
    ("S-0.25", "output.window_end_s", "0", "above 0.0"),
    ("S-0.25", "initial.steps_before", "9", "a whole number from 10 to 1000"),
    ("S-0.25", "initial.steps_before", "2.5", "a whole number"),
    ("S-0.25", "time.until_periodic", "0", "above 0.0"),
    ("S-0.25", "time.until_periodic", "-1e-3", "above 0.0"),
    ("S-0.25", "time.until_periodic", "5", "at most 0.1"),
    ("S-0.25", "time.until_periodic", "true", "a number above 0.0"),
    ("S-0.25", "output.wall_history", "2", "true or false"),
    ("S-0.25", "output.title", "\" \"", "a line of 1 to 100 characters"),
    ("S-0.25", "output.title", "\"two\\nlines\"", "a line of 1 to 100 characters"),
    ("S-0.25", "output.title", "7", "a line of 1 to 100 characters"),
    ("S-0.25", "preset.demo.time.end_s", "1", "unknown key"),
    ("S-0.25", "", "1", "unknown key"),
    ("S-0.25", "time.step_s", "1e-12", "1.0e11 steps until time.end_s = 0.1 are more than a run can take: expected 1e-8 s or more"),
    ("S-0.25", "time.step_s", "5e-7", "steps until time.period_s = 1.0 are more than"),
    ("S-0.25", "fluid.ranks", "64", "there are 63 cells along it: at most 63"),
    ("S-0.25", "geometry.length_m", "0.3", "did you mean `geometry.graft_length_m`, `geometry.artery_length_m`, `geometry.blend_length_m` or `geometry.extension_length_m`?"),
    ("turek-hron", "geometry.graft_length_m", "0.03", "a case with the table [flag] has no such key: leave out one of the two"),
    ("turek-hron", "wall.graft.mu_Pa", "1e5", "a case with the table [flag] has no such key"),
    ("turek-hron", "structure.circumferential", "4", "a case with the table [flag] has no such key"),
    ("turek-hron", "fluid.mesh.core", "4", "a case with the table [flag] has no such key"),
    ("turek-hron", "inflow.file", "flow.csv", "a case with the table [flag] has no such key"),
    ("S-0.25", "flag.length_m", "0.3", "the table [flag] makes it another kind of case, which needs 13 keys more, `flag.channel_length_m` the first of them"),
    ("turek-hron", "geometry.thickness_m", "0.3", "did you mean `flag.thickness_m`?"),
    ("S-0.25", "wall.mu_Pa", "1e4", "did you mean `wall.graft.mu_Pa`, `wall.media.mu_Pa` or `wall.adventitia.mu_Pa`?"),
];

#[test]
fn every_single_mistake_is_named() {
    assert!(SINGLE.len() >= 60);
    for &(model, key, value, message) in SINGLE {
        // The model with every preset as in the defaults.
        let folder = match model {
            "S-0.25" => "../tests/cases/S-0.25",
            other => other,
        };
        let errors = refuse(&project().join(folder), &[(key, value)]);
        let text = errors.to_string();
        assert!(
            text.contains(key) && text.contains(message),
            "{key} = {value}: {text}"
        );
        assert_eq!(errors.0.len(), 1, "{key} = {value}: {text}");
    }
}

#[test]
fn what_a_fluid_of_ones_own_cannot_do_is_refused() {
    let own = ("fluid.command", "[\"python3\"]");
    for (key, value, message) in [
        (
            "fluid.await",
            "true",
            "either starts the fluid or waits for it",
        ),
        ("time.scheme", "bdf2", "chooses its time integration"),
        ("fluid.ranks", "2", "fluid.command starts the MPI ranks"),
        (
            "output.fluid_probes_m",
            "[[0.01, 0.0, 0.0]]",
            "is not asked for values at points",
        ),
        (
            "initial.axial_stretch",
            "1.1",
            "leave out the table [initial]",
        ),
        (
            "initial.start",
            "equilibrium",
            "leave out the table [initial]",
        ),
    ] {
        let text = refuse(&project().join("S-0.25"), &[own, (key, value)]).to_string();
        assert!(
            text.contains(key) && text.contains(message),
            "{key}: {text}"
        );
    }
}

#[test]
fn all_mistakes_are_reported_at_once_with_file_and_line() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("case.toml");
    let defaults = project().join("defaults.toml").display().to_string();
    let text = format!(
        "extends = {defaults:?}\n\n[model]\nextension = \"helixx\"\nd_max_m = 5e-3\n\n[structure]\np = 2\nshape = 3\n\n[time]\nstep_s = 0.003\n\
         [preset.coarse]\nstructure.p = 1\n[preset.corse]\ntime.end_s = 1.0\n"
    );
    std::fs::write(&file, text).unwrap();
    let errors = refuse(scratch.path(), &[("windkessel.compliance_m3_Pa", "0")]);
    let text = errors.to_string();
    for expected in [
        ":4: `model.extension` = \"helixx\"",
        "did you mean \"helix\"?",
        ":5: `model.d_max_m`",
        "closes the lumen",
        ":8: `structure.p` = 2",
        ":9: unknown key `structure.shape`",
        ":12: `time.step_s` = 0.003",
        ":14: `structure.p` = 1",
        ":16: unknown key `preset.corse`; did you mean `preset.coarse`?",
        "--set: `windkessel.compliance_m3_Pa` = 0",
    ] {
        assert!(text.contains(expected), "{expected:?} is not in {text}");
    }
    assert!(
        text.starts_with(&format!("{} mistakes", errors.0.len())),
        "{text}"
    );
}

#[test]
fn files_that_are_no_case_are_refused() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("case.toml");
    let missing = refuse(scratch.path(), &[]).to_string();
    assert!(
        missing.contains("case.toml") && missing.contains("a case is a folder"),
        "{missing}"
    );
    for (text, message) in [
        (&b"[model\nd_max_m = 1\n"[..], "case.toml:1: not valid TOML"),
        (b"[model]\nd_max_m = = 1\n", "case.toml:2: not valid TOML"),
        (
            b"[model]\nd_max_m = 1\nd_max_m = 2\n",
            "case.toml:3: not valid TOML",
        ),
        (
            b"[model]\nd_max_m = 0,001\n",
            "decimals have a point, not a comma",
        ),
        (
            "[model]\nextension = “arc”\n".as_bytes(),
            "quotation marks must be straight",
        ),
        (b"\xff\xfe\x00", "not UTF-8"),
        (b"", "write `extends = "),
        (b"[model]\nextension = \"arc\"\n", "keys are missing"),
        (b"extends = \"case.toml\"\n", "is it a cycle?"),
        (b"extends = \"nowhere.toml\"\n", "nowhere.toml"),
        (b"extends = 3\n", "`extends` = 3"),
    ] {
        std::fs::write(&file, text).unwrap();
        let errors = refuse(scratch.path(), &[]).to_string();
        assert!(errors.contains(message), "{message:?} is not in {errors}");
    }
}

#[test]
fn a_missing_key_of_a_new_material_is_named() {
    let errors = refuse(
        &project().join("S-0.0"),
        &[("wall.media.material", "saint_venant_kirchhoff")],
    );
    let keys = errors.0.iter().filter_map(|error| match error {
        CaseError::Missing { key, .. } => Some(key.as_str()),
        _ => None,
    });
    let keys: Vec<_> = keys.collect();
    assert_eq!(
        keys,
        ["wall.media.youngs_modulus_Pa", "wall.media.poisson_ratio"],
        "{errors}"
    );
}

#[test]
fn flow_curves_are_refused_with_the_line() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("flow.csv");
    for (text, message) in [
        (
            &b"t,Q\n0,1\n"[..],
            ":1: expected the header time_s,flow_m3_s",
        ),
        (b"time_s,flow_m3_s\n", "at least 3"),
        (b"time_s,flow_m3_s\n0,1e-6\n0.5,2e-6\n", "at least 3"),
        (
            b"time_s,flow_m3_s\n0,1e-6\n0.5,x\n",
            ":3: expected a number, found \"x\"",
        ),
        (
            b"time_s,flow_m3_s\n0,1e-6\n0.5,nan\n",
            ":3: expected a number",
        ),
        (
            b"# one\ntime_s,flow_m3_s\n0,1e-6\n0.5,1e-6,7\n",
            ":4: expected 2 numbers, found 3",
        ),
        (
            b"time_s,flow_m3_s\n0,1e-6\n0.5,1e-6\n0.4,1e-6\n",
            ":4: times must increase",
        ),
        (
            b"time_s,flow_m3_s\n0,1e-6\n0.5,1e-6\n1.4,1e-6\n",
            ":4: the time 1.4 s is outside the period",
        ),
        (b"time_s,flow_m3_s\n-0.1,1e-6\n", ":2: the time -0.1 s"),
        (
            b"time_s,flow_m3_s\n0,1e-6\n0.5,3e-6\n0.7,1e-6\n1.0,2e-6\n",
            "must repeat itself",
        ),
        (
            b"time_s,flow_m3_s\n0,1e-6\n0.5,\xff\xff\n",
            ":3: expected a number",
        ),
        (b"", ":1: expected the header"),
        (
            b"t (s),Q (gal/min)\n0,1\n0.5,2\n0.7,1\n",
            ":1: \"gal/min\" is not a known unit of flow: expected m3/s, cm3/s, mm3/s, ml/s, ml/min, l/s, l/min",
        ),
        (
            b"t (s),v (cm/s)\n0,1\n0.5,2\n0.7,1\n",
            ":1: \"v (cm/s)\" is a velocity (cm/s), and a flow is expected: multiply it by the area of the lumen",
        ),
        (
            b"t (s),p (mmHg)\n0,80\n0.5,120\n0.7,90\n",
            "is a pressure (mmHg), and a flow is expected",
        ),
        (
            b"t (furlong/s),Q (ml/s)\n0,1\n0.5,2\n0.7,1\n",
            ":1: \"furlong/s\" is not a unit of time: expected s, ms, min",
        ),
        (
            b"t (s),Q left (ml/s),Q right (ml/s)\n0,1,2\n0.5,2,3\n0.7,1,2\n",
            ":1: several columns may be the flow: \"Q left (ml/s)\", \"Q right (ml/s)\"; leave only the times and one of them",
        ),
        (
            b"4 2\n0 1e-6\n0.5 2e-6\n0.7 1e-6\n",
            ":1: this line seems to count the rows, 4, but 3 follow",
        ),
        (
            b"t (s);Q (ml/s)\n0,0;1,5\n0.5;2,5\n",
            "line 2 has a comma within a number and line 3 a point",
        ),
        (
            b"t (s);Q (ml/s)\n0,0;1.234,5\n0,5;2,5\n",
            ":2: expected a number, found \"1.234,5\": write no marks between thousands",
        ),
        (
            b"t (s),Q (ml/s)\n0,5.5\n400,6\n850,5.5\n",
            ":3: the time 400.0 s is outside the period from 0 to 1.0 s: if the times are in milliseconds, call their column \"t (ms)\"",
        ),
        (
            b"t (s),Q (ml/s)\n7.0,5.5\n7.4,6\n7.8,5.5\n",
            ":2: the time 7.0 s is outside the period from 0 to 1.0 s: the first time is 7.0 s, and a period begins at 0",
        ),
        (
            b"0 5.5\n0.4 6.5\n0.8 5.5\n",
            ":1: expected the header time_s,flow_m3_s, or the unit of the column (inflow.unit: m3/s,",
        ),
        (
            b"0 5.5e-6\n0.4 6.5e-6\n0.8 5.5e-6\n",
            "with values up to 0.0000065, m3/s would fit a vessel",
        ),
        (
            b"PK\x03\x04\0\0\0",
            "such as a workbook of Excel or LibreOffice: save the sheet as CSV",
        ),
        (
            b"\xd0\xcf\x11\xe0\xa1",
            "an old workbook of Excel: save the sheet as CSV",
        ),
        (
            b"<!DOCTYPE html>\n<html></html>",
            "this is a web page, not the file itself",
        ),
        (
            b"version https://git-lfs.github.com/spec/v1\noid sha256:7\n",
            "fetch it with `git lfs pull`",
        ),
        (b"\x1f\x8b\x08\x00", "compressed by gzip: unpack it"),
        (b"0,1\n\0\x01\x02", "this is a binary file, not text"),
    ] {
        std::fs::write(&file, text).unwrap();
        let errors = refuse(
            &project().join("S-0.0"),
            &[("inflow.file", file.to_str().unwrap())],
        )
        .to_string();
        assert!(
            errors.contains("inflow.file") && errors.contains(message),
            "{message:?} is not in {errors}"
        );
    }
}

#[test]
fn what_is_prescribed_at_the_ends_must_fit_together() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("curve.csv");
    let path = file.to_str().unwrap();
    let curve = "t,p\n0,80\n0.4,120\n1,80\n";
    let inlet = ("inlet.condition", "pressure");
    for (text, set, message) in [
        (
            curve,
            vec![inlet, ("inlet.file", path)],
            ":1: expected the header time_s,pressure_Pa, or the unit of the column",
        ),
        (
            curve,
            vec![
                inlet,
                ("inlet.file", path),
                ("inlet.unit", "mmHg"),
                ("inlet.pressure_Pa", "1e4"),
            ],
            "leave out one of the two",
        ),
        (
            curve,
            vec![
                inlet,
                ("inlet.pressure_Pa", "1e4"),
                ("inlet.profile", "parabolic"),
            ],
            "the profile follows from the pressure",
        ),
        (
            "t,p (kPa)\n0,80\n0.4,120\n1,80\n",
            vec![inlet, ("inlet.file", path), ("inlet.unit", "mmHg")],
            "says another unit than",
        ),
        (
            "t,Q [ml/min]\n0,80\n400,120\n1000,80\n",
            vec![("inflow.file", path)],
            ":3: the time 400.0 s is outside the period",
        ),
        (
            "t (ms),Q [ml/min]\n0,80\n400,120\n850,80\n",
            vec![("inflow.file", path), ("inflow.file_period_s", "0.8")],
            ":4: the time 0.85 s is outside the period from 0 to 0.8 s",
        ),
        (
            curve,
            vec![
                ("outlet.condition", "pressure"),
                ("outlet.file", path),
                ("outlet.unit", "mmHg"),
                ("initial.start", "equilibrium"),
            ],
            "no equilibrium to start from",
        ),
    ] {
        std::fs::write(&file, text).unwrap();
        let errors = refuse(&project().join("S-0.0"), &set).to_string();
        assert!(errors.contains(message), "{message:?} is not in {errors}");
    }
}

#[test]
fn an_inlet_moves_with_the_wall_only_if_nothing_holds_it() {
    for (case, set, message) in [
        (
            "S-0.0",
            &[("ends.inlet", "radial")][..],
            "a prescribed flow needs an inlet at rest: write \"clamped\"",
        ),
        (
            "S-0.0",
            &[("ends.inlet", "radial")],
            "or geometry.extension_length_m = 0.0",
        ),
        (
            "neo-hookean-tube",
            &[("vessel.upstream_extension_m", "0.01")],
            "the rigid tube upstream holds this end",
        ),
        (
            "neo-hookean-tube",
            &[("ends.inlet", "sliding"), ("ends.outlet", "sliding")],
            "nothing keeps a wall from moving sideways",
        ),
        (
            "neo-hookean-tube",
            &[("ends.inlet", "springs")],
            "\"clamped\", \"sliding\", \"radial\"",
        ),
    ] {
        let errors = refuse(&project().join(case), set).to_string();
        assert!(errors.contains("ends.inlet"), "{errors}");
        assert!(errors.contains(message), "{message:?} is not in {errors}");
    }
}

#[test]
fn files_that_never_end_are_not_opened() {
    let scratch = tempfile::tempdir().unwrap();
    let pipe = scratch.path().join("flow.csv");
    rustix::fs::mknodat(
        rustix::fs::CWD,
        &pipe,
        rustix::fs::FileType::Fifo,
        rustix::fs::Mode::RUSR,
        0,
    )
    .unwrap();
    for path in [Path::new("/dev/zero"), &pipe] {
        let text = format!(
            "extends = \"{}\"\ninflow.file = \"{}\"\n",
            project().join("defaults.toml").display(),
            path.display()
        );
        std::fs::write(scratch.path().join("case.toml"), text).unwrap();
        let errors = refuse(scratch.path(), &[]).to_string();
        assert!(errors.contains("inflow.file"), "{errors}");
        assert!(errors.contains("not a file"), "{errors}");
    }
}

#[test]
fn a_key_that_is_given_twice_is_refused() {
    let model = project().join("S-0.25");
    let both = refuse(&model, &[("time.end_s", "0.02"), ("time.end_s", "0.04")]).to_string();
    assert_eq!(
        both,
        "--set: `time.end_s` is given twice, as 0.02 by --set and as 0.04 by --set: leave one of them out"
    );
    let table = refuse(
        &model,
        &[("fluid.mesh", "{ core = 4 }"), ("fluid.mesh.core", "5")],
    );
    assert!(
        table
            .to_string()
            .contains("`fluid.mesh.core` is given twice"),
        "{table}"
    );
}

#[test]
fn options_are_blamed_by_their_name() {
    let given = |place, key: &str, value: &str| Override {
        place,
        key: key.into(),
        value: value.into(),
    };
    let zero = given(ValuePlace::Option("--end-time"), "time.end_s", "0.0");
    let model = project().join("S-0.25");
    let errors = Case::load_with(&model, Preset::Demo, &[zero]).unwrap_err();
    assert!(
        errors
            .to_string()
            .starts_with("--end-time: `time.end_s` = 0.0: expected a number above 0.0"),
        "{errors}"
    );
    // What a command chooses for itself takes the place of what the user chose.
    let chosen = [
        given(ValuePlace::Set, "time.end_s", "0.02"),
        given(ValuePlace::Command, "time.end_s", "0.04"),
    ];
    let case = Case::load_with(&model, Preset::Demo, &chosen).unwrap();
    assert_eq!(case.time.end, 0.04);
}

fn cpu_seconds_of_this_thread() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    1e-9 * text.split(' ').next().unwrap().parse::<f64>().unwrap()
}

/// Lists are as long as what they describe needs them, and what is allowed is dealt with quickly.
#[test]
fn long_lists_are_refused() {
    let model = project().join("S-0.25");
    // Flat but for its ends: every sample is as high as its neighbours.
    let flat = |rows: usize, columns: usize| {
        let row = |i: usize| vec![f64::from(u8::from(i > 0 && i + 1 < rows)); columns];
        format!("{:?}", (0..rows).map(row).collect::<Vec<_>>())
    };
    for (rows, columns) in [(302, 300), (101, 3), (3, 101)] {
        let text = refuse(&model, &[("geometry.imperfection", &flat(rows, columns))]).to_string();
        assert!(text.contains("at most 100 by 100"), "{text}");
    }
    let before = cpu_seconds_of_this_thread();
    let largest = [("geometry.imperfection".into(), flat(100, 100))];
    Case::load(&model, Preset::Demo, &largest).unwrap();
    let seconds = cpu_seconds_of_this_thread() - before;
    // Measured: 1.1 s on a slow machine; 9.7 s on a fast one if the top were searched for around every sample.
    assert!(seconds < 4.0, "took {seconds} s");
    let points = format!("{:?}", vec![[0.01, 2e-3, 0.0]; 1001]);
    for key in ["output.probes_m", "output.fluid_probes_m"] {
        let text = refuse(&model, &[(key, &points)]).to_string();
        assert!(
            text.contains(key) && text.contains("at most 1000 points"),
            "{text}"
        );
    }
}

/// What `neo_hooke` has is Lamé's first parameter, which makes Poisson's ratio positive however small it is.
#[test]
fn a_compressible_neo_hookean_wall_is_accepted() {
    let soft = ("wall.graft.kappa_Pa".to_owned(), "1e5".to_owned());
    let case = Case::load(&project().join("S-0.25"), Preset::Demo, &[soft]);
    assert!(case.is_ok(), "{case:?}");
}

/// Points of an experiment are recorded next to those that the case gives, each once; a file that holds none, and a run
/// that would record too many, are refused.
#[test]
fn points_of_an_experiment_are_recorded() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("experiment.csv");
    let measured = |rows: &str| {
        std::fs::write(&file, format!("series,quantity,x_m,y_m,z_m,value\n{rows}")).unwrap();
        ("output.measured", format!("{file:?}"))
    };
    let model = project().join("S-0.25");
    let (key, value) = measured(
        "axis,velocity_x_m_s,0.01,0,0,0.3\naxis,velocity_x_m_s,0.02,0,0,0.3\nwall,wall_shear_Pa,0.01,0.0032,0,1\n",
    );
    let given = [
        (key.to_owned(), value.clone()),
        (
            "output.fluid_probes_m".to_owned(),
            "[[0.05, 0.0, 0.0], [0.02, 0.0, 0.0]]".to_owned(),
        ),
    ];
    let case = Case::load(&model, Preset::Demo, &given).unwrap();
    assert_eq!(
        case.output.fluid_probes,
        [[0.05, 0.0, 0.0], [0.02, 0.0, 0.0], [0.01, 0.0, 0.0]]
    );
    assert_eq!(case.output.probes, [[0.01, 0.0032, 0.0]]);
    assert_eq!(case.output.measured, None, "its points stand in the case");

    let own = ("fluid.command", "[\"python3\"]");
    let text = refuse(&model, &[own, (key, &value)]).to_string();
    assert!(
        text.contains("`output.measured`") && text.contains("measurements of the wall only"),
        "{text}"
    );
    let (key, value) = measured("axis,velocity_m_s,0.01,0,0,0.3\n");
    let text = refuse(&model, &[(key, &value)]).to_string();
    assert!(
        text.contains("`output.measured`")
            && text.contains("experiment.csv:2: unknown variant `velocity_m_s`"),
        "{text}"
    );
    let rows = (0..1001).map(|i| format!("a,speed_m_s,{i}e-6,0,0,1\n"));
    let (key, value) = measured(&rows.collect::<String>());
    let text = refuse(&model, &[(key, &value)]).to_string();
    assert!(text.contains("would record 1001 of one kind"), "{text}");
    let text = refuse(&model, &[(key, "\"nowhere.csv\"")]).to_string();
    assert!(text.contains("nowhere.csv: cannot read it"), "{text}");
}

/// A file that is no case at all is refused as quickly as another, however much there is of it.
#[test]
fn endless_mistakes_take_no_time() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("case.toml");
    let defaults = project().join("defaults.toml");
    let case = |lines: &str| {
        std::fs::write(&file, format!("extends = {defaults:?}\n{lines}")).unwrap();
        // A minute and more, if each were compared with all keys or its line were counted.
        refuse_within(Duration::from_secs(10), scratch.path(), &[])
    };
    let keys: String = (0..40_000).map(|i| format!("key_{i:05} = 1\n")).collect();
    let errors = case(&keys);
    assert_eq!(errors.0.len(), 40_000);
    let text = errors.to_string();
    assert!(
        text.ends_with("\n  and 39975 more"),
        "{}",
        &text[text.len() - 200..]
    );
    assert!(text.contains(":26: unknown key `key_00024`"), "{text}");
    let large: String = (0..2_000_000)
        .map(|i| format!("key_{i:08} = 1\n"))
        .collect();
    let text = case(&large).to_string();
    assert!(text.contains("case.toml: larger than 1 MiB"), "{text}");
    let long = format!("{} = 1\n", "a".repeat(900_000));
    assert_eq!(case(&long).0.len(), 1);
    for nested in [
        format!("{}a = 1\n", "a.".repeat(100_000)),
        format!("a = {}{}\n", "[".repeat(10_000), "]".repeat(10_000)),
        format!("a = {}1{}\n", "{a = ".repeat(10_000), "}".repeat(10_000)),
    ] {
        assert!(!case(&nested).0.is_empty());
    }
}

/// It needs a wall under pressure and no ramp, and begins so with either of the program's own fluids.
#[test]
fn blood_that_flows_at_once_is_refused_where_it_is_stopped() {
    let model = project().join("S-0.25");
    let steps = ("initial.steps_before", "25");
    let at_once = ("ramp.duration_s", "0");
    let equilibrium = ("initial.start", "equilibrium");
    #[rustfmt::skip]
    let wrong = [
        ([steps, at_once, ("initial.start", "ramp")], "initial.start", "write initial.start = \"equilibrium\""),
        ([steps, equilibrium, ("ramp.duration_s", "0.05")], "ramp.duration_s", "write ramp.duration_s = 0, and into windkessel.initial_pressure_Pa"),
    ];
    for (set, key, said) in wrong {
        let text = refuse(&model, &set).to_string();
        assert!(text.contains(key) && text.contains(said), "{text}");
    }
    let own = [
        steps,
        equilibrium,
        at_once,
        ("fluid.command", "[\"./solver\"]"),
    ];
    let text = refuse(&model, &own).to_string();
    assert!(
        text.contains("a program of your own begins as it likes: leave initial.steps_before out"),
        "{text}"
    );
    for solver in ["openfoam", "native"] {
        let set = [steps, equilibrium, at_once, ("fluid.solver", solver)];
        let set = set.map(|(key, value)| (key.to_owned(), value.to_owned()));
        let case =
            Case::load(&model, Preset::Demo, &set).unwrap_or_else(|errors| panic!("{errors}"));
        assert_eq!((case.steps_before(), case.unread.len()), (Some(25), 0));
        // A whole run, and of one until it is periodic 1.5, 2.5 and so on of beats of 100 steps.
        assert_eq!(RunEnds::of(&case).from(0), 25);
        let set = [
            &set[..],
            &[("time.until_periodic", "1e-3"), ("time.end_s", "3")]
                .map(|(key, value)| (key.to_owned(), value.to_owned())),
        ]
        .concat();
        let case =
            Case::load(&model, Preset::Demo, &set).unwrap_or_else(|errors| panic!("{errors}"));
        let ends = RunEnds::of(&case);
        let ends = [0, 150, 151, 250, 251].map(|step| ends.from(step));
        assert_eq!(ends, [150, 150, 250, 250, 300]);
        assert_eq!(case.steps_told(), "150 to 300 steps");
    }
}

/// Its window is its last whole beat; one of a case that is driven steadily has none, and ends when it is to.
#[test]
fn a_run_until_it_is_periodic_has_no_window_of_its_own() {
    let model = project().join("S-0.25");
    for key in ["output.window_start_s", "output.window_end_s"] {
        let set = [("time.until_periodic", "1e-3"), (key, "0.1")];
        let text = refuse(&model, &set).to_string();
        for expected in [
            key,
            "0.1",
            "(time.until_periodic) is its last whole beat: leave it out",
        ] {
            assert!(text.contains(expected), "{expected} is not in {text}");
        }
        let set = [&set[..], &[("inflow.amplitude_m3_s", "0")]].concat();
        let set: Vec<_> = set
            .iter()
            .map(|(key, value)| (key.to_string(), value.to_string()))
            .collect();
        let case =
            Case::load(&model, Preset::Demo, &set).unwrap_or_else(|errors| panic!("{errors}"));
        assert_eq!(
            (case.until_periodic(), case.steps_told()),
            (None, "25 steps".to_owned())
        );
    }
}

/// A model with these tables of uncertain inputs.
fn refuse_uncertain(tables: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("extends = \"defaults\"\n{tables}\n");
    std::fs::write(folder.path().join("case.toml"), text).unwrap();
    refuse(folder.path(), &[]).to_string()
}

/// What cannot be uncertain so, and what is to be done.
#[test]
fn impossible_uncertain_inputs_are_refused() {
    const C: &str = "\"windkessel.compliance_m3_Pa\"";
    let input = |name: &str, keys: &str, more: &str| {
        format!("[[uncertain]]\nname = \"{name}\"\nkeys = [{keys}]\ndistribution = {more}\n")
    };
    for (keys, more, key, part) in [
        (
            C,
            "\"normal\"",
            "distribution",
            "it needs a variation, such as 0.1",
        ),
        (
            C,
            "\"uniform\"\nlow = 1e-10",
            "distribution",
            "either low and high, or variation",
        ),
        (
            C,
            "\"uniform\"\nlow = 2e-10\nhigh = 1e-10",
            "high",
            "above low = 2e-10",
        ),
        (
            C,
            "\"normal\"\nvariation = 0.1\nlow = 1e-9",
            "low",
            "less than a thousandth",
        ),
        (
            C,
            "\"normal\"\nvariation = 0.4",
            "distribution",
            "take lognormal",
        ),
        (
            C,
            "\"lognormal\"\nmean = -1.0\nvariation = 0.1",
            "distribution",
            "above 0",
        ),
        (
            "\"fluid.ranks\"",
            "\"uniform\"\nlow = 1\nhigh = 2",
            "keys",
            "only what is a real number",
        ),
        (
            "\"time.scheme\"",
            "\"uniform\"\nlow = 1\nhigh = 2",
            "keys",
            "only what is a real number",
        ),
        (
            "\"windkessel.complience_m3_Pa\"",
            "\"normal\"\nvariation = 0.1",
            "keys",
            "did you mean windkessel.compliance_m3_Pa?",
        ),
        (
            "\"output.window_start_s\"",
            "\"normal\"\nvariation = 0.1",
            "keys",
            "no value for output.window_start_s",
        ),
        (
            "\"geometry.imperfection\"",
            "\"normal\"\nvariation = 0.5",
            "distribution",
            "a factor is above 0",
        ),
    ] {
        let message = refuse_uncertain(&input("x", keys, more));
        let named = "case.toml:".to_owned();
        let key = format!("`uncertain[0].{key}` = ");
        for part in [named.as_str(), &key, part] {
            assert!(message.contains(part), "{keys} {more}: {message}");
        }
    }
    let two = input("a", C, "\"normal\"\nvariation = 0.1")
        + &input(
            "b",
            "\"windkessel.resistance_Pa_s_m3\"",
            "\"normal\"\nvariation = 0.1",
        )
        + &input(
            "c",
            "\"blood.viscosity_Pa_s\"",
            "\"normal\"\nvariation = 0.1",
        );
    let pair = |first: &str, second: &str, coefficient: f64| {
        format!(
            "[[correlation]]\nfirst = \"{first}\"\nsecond = \"{second}\"\ncoefficient = {coefficient}\n"
        )
    };
    for (tables, part) in [
        (two.replace("\"b\"", "\"a\""), "another input has this name"),
        (
            two.replace("blood.viscosity_Pa_s", "windkessel.compliance_m3_Pa"),
            "listed twice",
        ),
        (two.clone() + &pair("a", "d", 0.5), "there is a, b, c"),
        (
            two.clone() + &pair("a", "a", 0.5),
            "a pair of two different inputs",
        ),
        (
            two + &pair("a", "b", 0.9) + &pair("b", "c", 0.9) + &pair("a", "c", -0.9),
            "not positive definite",
        ),
    ] {
        let message = refuse_uncertain(&tables);
        assert!(
            message.contains(part) && message.contains("case.toml:"),
            "{message}"
        );
    }
}

/// A measure that a run cannot have is refused with its key and what to write instead.
#[test]
fn measures_that_no_run_has_are_refused() {
    #[rustfmt::skip]
    let wrong: [(&str, &str, &str); 10] = [
        ("column = \"pressure\"", "column", "expected one of coupling_iterations, residual, "),
        ("column = \"p_in_Pa\"\nat = \"inlet\"", "at", "the history is of the whole vessel"),
        ("column = \"p_in_Pa\"\nof = \"at_phase\"", "of", "add phase, from 0 to 1"),
        ("column = \"p_in_Pa\"\nphase = 0.3", "phase", "only of = \"at_phase\" reads it"),
        ("table = \"openings\"\ncolumn = \"p_Pa\"", "column", "of which opening? Add at"),
        ("table = \"openings\"\ncolumn = \"p_Pa\"\nat = \"exit\"", "at", "expected one of \"inlet\", \"outlet\""),
        ("table = \"sections\"\ncolumn = \"area_m2\"\nat = \"middle\"", "at", "the case has no cross-section"),
        ("table = \"regions\"\ncolumn = \"OSI\"\nat = \"artery\"", "column", "expected one of mean_wall_shear_Pa, "),
        ("table = \"wall\"\ncolumn = \"OSI\"\nat = \"graft\"", "at", "expected one of \"artery\", \"bypass\""),
        ("table = \"wall\"\ncolumn = \"OSI\"\nat = \"artery\"\nof = \"at_phase\"\nphase = 0.3", "of",
            "of the whole window"),
    ];
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.toml");
    let mistakes = |measures: &str| {
        let base = project().join("S-0.25/case.toml");
        std::fs::write(&file, format!("extends = {base:?}\n{measures}\n")).unwrap();
        let case = Case::load(folder.path(), Preset::Demo, &[]).unwrap();
        case.measure_mistakes(&["artery".to_owned(), "bypass".to_owned()])
    };
    let table = |keys: &str| format!("[[output.measure]]\nname = \"m\"\n{keys}\n");
    for (keys, key, message) in wrong {
        let found = mistakes(&table(keys));
        assert_eq!(found.len(), 1, "{keys}: {found:?}");
        assert_eq!(found[0].0, format!("output.measure[0].{key}"), "{keys}");
        assert!(found[0].1.contains(message), "{keys}: {}", found[0].1);
    }
    let good = table("table = \"wall\"\ncolumn = \"OSI\"\nat = \"artery\"\nof = \"highest\"");
    assert_eq!(mistakes(&good), []);
    let found = mistakes(&good.repeat(2));
    assert_eq!(found.len(), 1);
    assert!(
        found[0].0 == "output.measure[1].name" && found[0].1.contains("choose a different one")
    );
}
