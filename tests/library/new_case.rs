//! `fsi-driver new` and `preview`: from files that are not in the project to a case that can be run, and pictures of
//! it.

use crate::vessel_files::shapes::TubeSurface;
use fsi_driver::Vec3;
use fsi_driver::case::{Case, FlowCurve, Preset};
use fsi_driver::geometry::{Vessel, fluid_mesh};
use nalgebra::Rotation3;
use std::path::Path;
use std::process::{Command, Output};

pub(crate) fn driver(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

pub(crate) fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = driver(folder, arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    String::from_utf8(output.stdout).unwrap()
}

/// Centre-line and surface of a tube, turned in space, in a unit of which so many are a metre; the line scatters.
fn write(tube: TubeSurface, folder: &Path, [slices, sides]: [usize; 2], scale: f64, scatter: f64) {
    let rotation = Rotation3::from_euler_angles(1.1, -0.4, 2.0);
    let turned = tube
        .placed(rotation, Vec3::new(0.12, -0.3, 1.4))
        .scattering(scatter);
    turned.write_line(&folder.join("line.csv"), 150, scale);
    turned.write_surface(&folder.join("lumen.stl"), slices, sides, true, scale);
}

#[test]
fn two_files_of_any_vessel_become_a_case() {
    let wavy = |s: f64, phi: f64| 4e-3 - 0.02 * s + 0.4e-3 * (2.0 * phi + 60.0 * s).cos();
    let wide = |s: f64, _: f64| 11e-3 + 5e-3 * (-((s - 0.06) / 0.02).powi(2)).exp();
    let thin = |_: f64, phi: f64| 1.2e-3 + 0.1e-3 * phi.sin();
    let plaque = |s: f64, phi: f64| {
        3e-3 - 0.9e-3 * (-((s - 0.03) / 0.005).powi(2)).exp() * (1.0 + phi.cos())
    };
    type Shape = (
        &'static str,
        TubeSurface,
        [usize; 2],
        &'static str,
        f64,
        f64,
    );
    let shapes: [Shape; 5] = [
        (
            "tapering and wavy",
            TubeSurface::bent(0.08, 0.03, wavy),
            [120, 40],
            "mm",
            1e3,
            0.1e-3,
        ),
        (
            "an aorta with a sac",
            TubeSurface::straight(0.12, wide),
            [60, 24],
            "cm",
            1e2,
            0.5e-3,
        ),
        (
            "thin, of coarse triangles",
            TubeSurface::bent(0.03, 0.015, thin),
            [40, 12],
            "mm",
            1e3,
            0.05e-3,
        ),
        (
            "a plaque",
            TubeSurface::bent(0.06, 0.05, plaque),
            [150, 60],
            "m",
            1.0,
            0.0,
        ),
        (
            "a bend of four radii",
            TubeSurface::bent(0.03, 0.012, |_, _| 3e-3),
            [60, 30],
            "mm",
            1e3,
            0.02e-3,
        ),
    ];
    for (name, tube, triangles, unit, scale, scatter) in shapes {
        let folder = tempfile::tempdir().unwrap();
        let here = folder.path();
        write(tube, here, triangles, scale, scatter);
        let said = succeeds(
            here,
            &[
                "new",
                "my-vessel",
                "--from",
                "line.csv",
                "--lumen",
                "lumen.stl",
                "--unit",
                unit,
            ],
        );
        assert!(
            said.contains("Womersley number") && said.contains("fsi-driver preview my-vessel"),
            "{name}: {said}"
        );
        let case = Case::load(&here.join("my-vessel"), Preset::Demo, &[])
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        let keys = case.vessel().unwrap();
        let volumes = fluid_mesh(keys).cell_volumes();
        assert!(volumes.iter().all(|v| *v > 0.0), "{name}");
        assert!(Vessel::new(keys).end() > 0.02, "{name}");
        let pages = succeeds(here, &["preview", "my-vessel", "--preset", "demo"]);
        assert_eq!(
            pages,
            "my-vessel/preview.html\nmy-vessel/preview.png\nmy-vessel/preview.svg\n"
        );
    }
}

/// With cells taken for a 4.5th of the narrowest radius the narrow end asked for 0.1 ms, in which the blood's added
/// mass is 6,800 times the wall's.
#[test]
fn long_slender_arteries_get_steps_that_the_coupling_can_take() {
    for (length, radii, expected) in [
        (130.0, [2.0, 0.55], 0.002),
        (250.0, [3.0, 0.5], 0.002),
        (20.0, [2.0, 0.45], 0.0002),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let row = |i: i32| {
            let share = f64::from(i) / 60.0;
            let r = radii[0] + share * (radii[1] - radii[0]);
            format!("{},0,0,{r}\n", share * length)
        };
        let line: String = (0..=60).map(row).collect();
        std::fs::write(folder.path().join("line.csv"), format!("x,y,z,r\n{line}")).unwrap();
        succeeds(
            folder.path(),
            &["new", "slender", "--from", "line.csv", "--unit", "mm"],
        );
        let case = Case::load(&folder.path().join("slender"), Preset::Demo, &[]).unwrap();
        assert_eq!(case.time.step, expected, "{length} mm, {radii:?} mm");
    }
}

#[test]
fn a_case_for_the_examples_files_says_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/vessels");
    let lines = examples.join("carotid/lines.vtp");
    let from = [
        "new",
        "carotid",
        "--from",
        lines.to_str().unwrap(),
        "--unit",
        "mm",
    ];
    let unknown = [&from[..], &["--branch", "left"]].concat();
    let output = driver(folder.path(), &unknown);
    assert_eq!(output.status.code(), Some(2));
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        error.contains("\"CenterlineIds=0\"") && error.contains("\"GroupIds=3\""),
        "{error}"
    );
    let said = succeeds(
        folder.path(),
        &[
            &from[..],
            &["--branch", "CenterlineIds=0", "--like", "stenosis"],
        ]
        .concat(),
    );
    assert!(said.contains("radius 2.29 to 3.21 mm"), "{said}"); // half the area of the bulb
    let text = std::fs::read_to_string(folder.path().join("carotid/case.toml")).unwrap();
    assert!(
        text.contains("centre_line = \"lines.vtp\"") && text.contains("feature = \"stenosis\""),
        "{text}"
    );
    assert!(folder.path().join("carotid/lines.vtp").is_file());
    // The page shows materials by name, and stands on nothing else.
    succeeds(folder.path(), &["preview", "carotid", "--out", "pictures"]);
    let page = std::fs::read_to_string(folder.path().join("pictures/preview.html")).unwrap();
    assert!(
        page.contains("media") && page.contains("adventitia") && page.contains("class=\"viewer\"")
    );
    let png = std::fs::read(folder.path().join("pictures/preview.png")).unwrap();
    assert!(
        png.starts_with(b"\x89PNG") && png.len() > 20_000,
        "{}",
        png.len()
    );
}

/// SimVascular's flows and those in other units and periods: the same case, the same windkessel.
#[test]
fn a_flow_comes_as_the_user_has_it() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let curve = |row: &dyn Fn(f64, f64) -> String| -> String {
        (0..=50)
            .map(|i| {
                let t = f64::from(i) / 50.0;
                row(t, 3.0 + 2.0 * (std::f64::consts::TAU * t).sin())
            })
            .collect()
    };
    let write = |name: &str, text: String| std::fs::write(here.join(name), text).unwrap();
    write(
        "si.csv",
        "time_s,flow_m3_s\n".to_owned() + &curve(&|t, q| format!("{t},{:e}\n", 1e-6 * q)),
    );
    write("sv.flow", curve(&|t, q| format!("{t} {}\n", -q)));
    write(
        "slow.csv",
        "t (s),Q\n".to_owned() + &curve(&|t, q| format!("{},{}\n", 2.0 * t, 60.0 * q)),
    );
    let slow = ["--flow-unit", "ml/min", "--flow-period", "2"];
    let cases = [("si.csv", &[][..]), ("sv.flow", &[]), ("slow.csv", &slow)].map(|(file, more)| {
        let name = file.replace('.', "-");
        succeeds(here, &[&["new", &name, "--flow", file], more].concat());
        assert!(here.join(&name).join(file).is_file());
        Case::load(&here.join(name), Preset::Demo, &[]).unwrap()
    });
    let [si, others @ ..] = &cases;
    let found = |case: &Case| {
        let keys = case.vessel().unwrap();
        let windkessel = &keys.windkessel;
        let flow = FlowCurve::new(&keys.inflow, case.time.period).unwrap();
        [
            windkessel.resistance,
            windkessel.compliance,
            1e15 * flow.flow(0.2),
        ]
    };
    for other in others {
        for (a, b) in found(other).iter().zip(found(si)) {
            approx::assert_relative_eq!(*a, b, max_relative = 1e-6);
        }
    }
    let [resistance, ..] = found(si);
    // 100 mmHg by 3 ml/s
    approx::assert_relative_eq!(resistance, 13332.2 / 3e-6, max_relative = 0.02);
}

/// What was understood is said, and what cannot be meant is refused with the likely cause.
#[test]
fn new_says_what_it_understood_of_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let curve = |factor: f64| -> String {
        let row = |i: i32| {
            let t = f64::from(i) / 20.0;
            format!(
                "{t} {}\n",
                factor * (4.0 + 2.0 * (std::f64::consts::TAU * t).sin())
            )
        };
        (0..=20).map(row).collect()
    };
    let put = |name: &str, text: String| std::fs::write(here.join(name), text).unwrap();
    put("positive.flow", curve(1.0));
    put("negative.flow", curve(-1.0));
    put(
        "cubic-mm.flow",
        format!("# (s) (mm^3/s)\n{}", curve(-1000.0)),
    );
    for file in ["positive.flow", "negative.flow", "cubic-mm.flow"] {
        let said = succeeds(here, &["new", &format!("of-{file}"), "--flow", file]);
        assert!(
            said.contains("flow      240 ml/min on average"),
            "{file}: {said}"
        );
        assert!(said.contains(&format!("read      {file}: 21 rows, columns separated by blanks; times in column 1 (s), flow in column 2")), "{file}: {said}");
        let case = std::fs::read_to_string(here.join(format!("of-{file}/case.toml"))).unwrap();
        assert!(case.contains("[windkessel]"), "{file}");
    }
    // In the header of the line stands its unit, and the surface has another one.
    let tube = TubeSurface::straight(0.04, |_, _| 3e-3);
    tube.write_line(&here.join("line.csv"), 20, 1e3);
    let line = std::fs::read_to_string(here.join("line.csv")).unwrap();
    let rows = line
        .lines()
        .filter(|line| line.starts_with(|c: char| c.is_ascii_digit() || c == '-'));
    put(
        "line-mm.csv",
        "x (mm),y (mm),z (mm)\n".to_owned()
            + &rows.map(|row| format!("{row}\n")).collect::<String>(),
    );
    tube.write_surface(&here.join("lumen-cm.stl"), 40, 24, false, 1e2);
    let both = ["--from", "line-mm.csv", "--lumen", "lumen-cm.stl"];
    let said = succeeds(
        here,
        &[&["new", "two-units"], &both[..], &["--lumen-unit", "cm"]].concat(),
    );
    assert!(
        said.contains("x, y, z in \"x (mm)\", \"y (mm)\", \"z (mm)\", no radii")
            && said.contains("lumen-cm.stl: 1920 triangles"),
        "{said}"
    );
    let case = Case::load(&here.join("two-units"), Preset::Demo, &[]).unwrap();
    let radius = Vessel::new(case.vessel().unwrap()).lumen_radius(0.02, 0.3);
    assert!((radius - 3e-3).abs() < 3e-5, "{radius}");

    put(
        "backwards.csv",
        "t (s),Q (ml/s)\n0,-4\n0.3,-6\n0.5,-5\n0.7,-4\n".into(),
    );
    put("no-unit.flow", curve(-1000.0));
    put(
        "velocity.csv",
        "t (s),v (m/s)\n0,0.4\n0.3,0.6\n0.5,0.5\n0.7,0.4\n".into(),
    );
    put("bare.csv", "0,4e-6\n0.3,6e-6\n0.5,5e-6\n0.7,4e-6\n".into());
    put(
        "huge.csv",
        "t (s),Q (l/s)\n0,4\n0.3,6\n0.5,5\n0.7,4\n".into(),
    );
    put(
        "doubtful.csv",
        "t (s),Q (ml/s)\n0,400\n0.3,600\n0.5,500\n0.7,400\n".into(),
    );
    for (arguments, message) in [
        (&["--flow", "backwards.csv"][..], "the mean flow is -"),
        (
            &["--flow", "no-unit.flow"],
            "which no vessel has: is it in mm3/s",
        ),
        (
            &["--flow", "velocity.csv"],
            "is a velocity (m/s), and a flow is expected",
        ),
        (
            &["--flow", "bare.csv"],
            "the unit of the column (--flow-unit: m3/s",
        ),
        (&["--flow", "huge.csv"], "which no vessel has"),
        (
            &["--from", "line-mm.csv", "--unit", "cm", "--radius", "3e-3"],
            "its header says mm, and cm was given (--unit)",
        ),
        (
            &both,
            "the surface is ten times smaller than the centre-line needs: in cm it fits, in mm it does not; correct its unit (--lumen-unit, or --unit of the line)",
        ),
        (&["--lumen-unit", "cm"], "--lumen <FILE>"),
    ] {
        let output = driver(here, &[&["new", "a"], arguments].concat());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(
            error.contains(message),
            "{arguments:?}: {error}\nexpected {message}"
        );
        // Nothing of a case that was never written.
        for word in ["case.toml", "defaults.toml", "inflow.", "vessel."] {
            assert!(!error.contains(word), "{arguments:?}: {error}");
        }
        assert!(!here.join("a").exists(), "{arguments:?}");
    }
    let said = succeeds(here, &["new", "fast", "--flow", "doubtful.csv"]);
    assert!(said.contains("warning: the flow reaches"), "{said}");
    let said = succeeds(here, &["windkessel", "--flow", "positive.flow"]);
    assert!(
        said.contains("positive values enter, as in SimVascular's 0-D and 1-D solvers")
            && said.contains("mean flow 240.0 ml/min"),
        "{said}"
    );
}

/// Files of kinds that people have, with what `new` says of them; an exclamation mark is before what is refused.
#[test]
fn odd_files_are_read_or_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let line = |separator: &str, head: &str, width: f64| -> String {
        let row = |i: i32| {
            let s = f64::from(i);
            let cells = [s, 0.02 * s, 100.0, width];
            cells.map(|x| format!("{x:.3}")).join(separator) + "\n"
        };
        head.to_owned() + "\n" + &(0..=40).map(row).collect::<String>()
    };
    let there = line(",", "x,y,z,r", 3.0);
    let back: Vec<&str> = there.lines().skip(1).collect();
    let back = back.iter().rev().skip(1).map(|row| format!("{row}\n"));
    let there_and_back = there.clone() + &back.collect::<String>();
    let curve = |head: &str, unit: f64, more: f64| -> String {
        let row = |i: i32| {
            let t = f64::from(i) / 20.0;
            let flow = 5.0 + 4.0 * (std::f64::consts::TAU * t).sin();
            format!("{},{}\n", unit * t + more, flow)
        };
        head.to_owned() + "\n" + &(0..=20).map(row).collect::<String>()
    };
    let path_point = |i: i32| {
        format!("<path_point id=\"{i}\">\n<pos x=\"{i}\" y=\"0\" z=\"1.5e1\" />\n</path_point>\n")
    };
    let path = |foot: &str| {
        let points: String = (0..=40).map(path_point).collect();
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\" ?>\n<format version=\"1.0\" />\n<path id=\"1\">\n<timestep id=\"0\">\n<path_element>\n\
             <control_points>\n<point id=\"0\" x=\"9\" y=\"9\" z=\"9\" />\n</control_points>\n<path_points>\n{points}{foot}"
        )
    };
    let mm = ["--unit", "mm"];
    let with_radius = ["--unit", "mm", "--radius", "3mm"];
    let lines: [(&str, Vec<u8>, &[&str], &str); 8] = [
        (
            "deutsch.csv",
            line(";", "Länge X [mm];Y [mm];Z [mm];Durchmesser [mm]", 6.0)
                .replace('.', ",")
                .chars()
                .map(|c| c as u8) // Latin-1
                .collect(),
            &[],
            "radius 3.00 to 3.00 mm",
        ),
        (
            "path.pth",
            path("</path_points>\n</path_element>\n</timestep>\n</path>\n").into(),
            &with_radius,
            "SimVascular's path: 41 points, no radii",
        ),
        (
            "cut.pth",
            path("").into(),
            &with_radius,
            "!--from cut.pth: the file ends within its points",
        ),
        (
            "none.pth",
            "<path></path>".into(),
            &with_radius,
            "!no path of SimVascular",
        ),
        (
            "width.csv",
            line(",", "x,y,z,w", 3.0).into(),
            &mm,
            "!the file has no radii (41 rows, columns separated by commas; x, y, z in \"x\", \"y\", \"z\", no radii; \"w\" left out): give",
        ),
        (
            "metres.csv",
            line(",", "x,y,z,r", 3.0).into(),
            &["--unit", "um"],
            "!--unit mm would fit",
        ),
        (
            "radii-in-um.csv",
            line(",", "x,y,z,r", 3000.0).into(),
            &mm,
            "!no unit fits both: are points and radii in different ones?",
        ),
        (
            "back.csv",
            there_and_back.into(),
            &mm,
            "!What scatters is smoothed by --smoothing",
        ),
    ];
    let flows = [
        (
            "phase.csv",
            curve("phase [%],Q [ml/s]", 100.0, 0.0),
            "!\"phase [%]\" has no times: write seconds",
        ),
        (
            "later.csv",
            curve("t [s],Q [ml/s]", 1.0, 3.0),
            "!--flow later.csv: line 2: the time 3.0 s is outside the period",
        ),
        (
            "tens.csv",
            curve("t [s],Q [10^-6 m^3/s]", 1.0, 0.0),
            "300 ml/min on average",
        ),
        (
            "pressure.csv",
            curve("time_s,pressure_mmHg", 1.0, 0.0),
            "!\"pressure_mmHg\" is a pressure, and a flow is expected",
        ),
        (
            "minutes.csv",
            curve("t [min],Q [ml/s]", 1.0 / 60.0, 0.0),
            "times in \"t [min]\" (min)",
        ),
        (
            "gap.csv",
            "t [s],Q [ml/s]\n0,5\n0.5,\n1,5\n".into(),
            "!gap.csv:3: expected 2 numbers, found 1",
        ),
    ];
    let lines = lines
        .map(|(name, text, more, said)| (name, text, [&["--from", name], more].concat(), said));
    let flows =
        flows.map(|(name, text, said)| (name, text.into_bytes(), vec!["--flow", name], said));
    for (name, text, options, expected) in lines.into_iter().chain(flows) {
        std::fs::write(here.join(name), text).unwrap();
        let case = format!("of-{name}");
        let output = driver(here, &[&["new", &case], &options[..]].concat());
        let is_refused = expected.starts_with('!');
        let said = [&output.stdout, &output.stderr][usize::from(is_refused)];
        let said = String::from_utf8_lossy(said);
        assert_eq!(
            output.status.code(),
            Some(if is_refused { 2 } else { 0 }),
            "{name}: {said}"
        );
        assert!(
            said.contains(expected.trim_start_matches('!')),
            "{name}: {said}"
        );
        assert_eq!(here.join(&case).exists(), !is_refused, "{name}");
    }
}

#[test]
fn what_is_refused_leaves_no_folder() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    TubeSurface::straight(0.04, |_, _| 3e-3).write_line(&here.join("line.csv"), 20, 1e3);
    TubeSurface::straight(0.04, |_, _| 3e-3).write_surface(
        &here.join("lumen.stl"),
        20,
        20,
        false,
        1e3,
    );
    std::fs::create_dir(here.join("full")).unwrap();
    std::fs::write(here.join("full/notes"), "mine").unwrap();
    std::fs::write(here.join("flow.csv"), "time_s,flow_m3_s\n0,1e-6\n").unwrap();
    for (arguments, message) in [
        (&["full"][..], "not an empty folder"),
        (&["a", "--from", "line.csv"], "--unit mm, m, cm or um"),
        (
            &["a", "--from", "line.csv", "--unit", "inch"],
            "expected m, cm, mm or um",
        ),
        (
            &["a", "--from", "line.csv", "--unit", "mm"],
            "give --lumen, the surface, or --radius",
        ),
        (
            &["a", "--from", "line.csv", "--unit", "m", "--radius", "3e-3"],
            "--unit m: with it the centre-line is 4.000e1 m long",
        ),
        (
            &["a", "--from", "line.csv", "--unit", "mm", "--radius", "3"],
            "--radius 3: expected metres",
        ),
        (
            &[
                "a",
                "--from",
                "line.csv",
                "--unit",
                "mm",
                "--lumen",
                "lumen.stl",
                "--radius",
                "3e-3",
            ],
            "comes from --lumen already",
        ),
        (
            &[
                "a",
                "--from",
                "line.csv",
                "--unit",
                "mm",
                "--lumen",
                "nowhere.stl",
            ],
            "--lumen nowhere.stl: No such file",
        ),
        (
            &["a", "--from", "nowhere.vtp", "--unit", "mm"],
            "--from nowhere.vtp: No such file",
        ),
        (
            &["a", "--lumen", "lumen.stl", "--unit", "mm"],
            "--lumen needs its centre-line",
        ),
        (&["a", "--branch", "1"], "--from <FILE>"),
        (&["a", "--like", "leg"], "invalid value 'leg'"),
        (&["a", "--period", "0"], "--period 0"),
        (&["a", "--flow", "flow.csv"], "flow.csv"),
        (&["a", "--flow", "nowhere.csv"], "nowhere.csv"),
        (&["a", "--flow-unit", "ml/s"], "--flow <FILE>"),
        (
            &["a", "--flow", "flow.csv", "--flow-unit", "pints"],
            "expected one of m3/s, cm3/s",
        ),
        (
            &["a", "--flow", "flow.csv", "--flow-period", "0"],
            "--flow-period 0",
        ),
    ] {
        let output = driver(here, &[&["new"], arguments].concat());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(
            error.contains(message),
            "{arguments:?}: {error}\nexpected {message}"
        );
        assert!(!here.join("a").exists(), "{arguments:?}");
    }
    let names = || std::fs::read_dir(here).unwrap().count();
    assert_eq!(names(), 4);
    let flag = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/turek-hron");
    let output = driver(here, &["preview", flag.to_str().unwrap(), "--out", "a"]);
    assert_eq!((output.status.code(), names()), (Some(2), 4));
    let study = ["study", "--cases", "full", "--sweep"];
    for (sweep, message) in [
        ("wall.media.k1_Pa", "expected KEY=VALUE,VALUE"),
        ("wall.media.k1_Pa=500,,2000", "a value is missing"),
        ("wall.media.k1_Pa=500,500", "is listed twice"),
    ] {
        let output = driver(here, &[&study[..], &[sweep]].concat());
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(
            output.status.code() == Some(2) && error.contains(message),
            "{error}"
        );
    }
}

/// Thin, long and without tissue: the search for its unloaded shape would end in a bent equilibrium.
#[test]
fn a_vessel_that_bends_under_its_pressure_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let said = |name: &str, more: &[&str]| {
        let vessel = ["new", name, "--like", "stenosis", "--loaded", "80mmHg"];
        let output = driver(folder.path(), &[&vessel[..], more].concat());
        assert!(output.status.success());
        String::from_utf8(output.stdout).unwrap()
    };
    const WARNING: &str = "warning: the pressure of the given shape, 80 mmHg, pushes the vessel sideways by 2.4 times";
    let thin = said("thin", &["--thickness", "0.5mm"]);
    assert!(thin.contains(WARNING), "{thin}");
    let held = said("held", &["--thickness", "0.5mm", "--tissue"]);
    assert!(!held.contains("sideways"), "{held}");
}
