//! A lumen with random radii: one vessel for the wall and both fluids, nothing outside its part, and what is refused.

use fsi_driver::analysis::random_lumen;
use fsi_driver::case::{BloodVessel, Case, Preset, ResolvedCase};
use fsi_driver::fluid::Fluid;
use fsi_driver::fluid::native::NativeFluid;
use fsi_driver::geometry::{Surfaces, Vessel, fluid_mesh, solid_mesh};
use std::f64::consts::PI;

const RANDOM: &str = "[random_lumen]\nstandard_deviation_m = 0.25e-3\nlength_along_m = 7.5e-3\nangle_around_deg = 90.0\n\
                      from_m = 0.03\nto_m = 0.06\nfade_m = 3.75e-3\nmodes = 14\n";
const INPUT: &str = "[[uncertain]]\nname = \"lumen\"\nkeys = [\"random_lumen.amplitudes\"]\ndistribution = \"standard_normal\"\n";

/// A straight model with these tables.
fn load(tables: &str, set: &[(&str, &str)]) -> Result<ResolvedCase, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.toml");
    std::fs::write(&file, format!("extends = \"defaults\"\n{tables}\n")).unwrap();
    let set: Vec<_> = (set.iter())
        .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
        .collect();
    Case::load(folder.path(), Preset::Coarse, &set).map_err(|errors| errors.to_string())
}

fn with_amplitudes(amplitudes: &str) -> ResolvedCase {
    load(&format!("{RANDOM}amplitudes = {amplitudes}\n"), &[]).unwrap()
}

fn vessel(case: &Case) -> &BloodVessel {
    case.vessel().unwrap()
}

const SOME: &str = "[1.0, -0.5, 1.5, 0.3, -2.0, 0.7, 0.0, 1.0]";

/// The points of OpenFOAM's wall, of the native fluid's and of the elastic one lie on one lumen, which is another one
/// than the smooth one.
#[test]
fn wall_and_both_fluids_have_the_same_random_lumen() {
    let case = with_amplitudes(SOME);
    let keys = vessel(&case);
    let shape = Vessel::new(keys);
    let cells = fluid_mesh(keys);
    let patch = cells
        .patches
        .iter()
        .find(|patch| patch.name == "wallFsi")
        .unwrap();
    let faces = &cells.faces[patch.start..patch.start + patch.size];
    let of_cells: Vec<_> = faces.iter().flatten().map(|p| cells.points[*p]).collect();
    let native = NativeFluid::new(&case).unwrap().interface().points.clone();
    let solid = solid_mesh(keys);
    let inner = solid.surfaces["inner"]
        .iter()
        .map(|(e, _)| solid.hexes[*e][0]);
    let of_wall: Vec<_> = inner.map(|v| solid.vertices[v]).collect();
    for points in [of_cells, native, of_wall] {
        let mut largest: f64 = 0.0;
        for point in &points {
            let phi = point.z.atan2(point.y);
            let radius = point.y.hypot(point.z);
            let off = (radius - shape.lumen_radius(point.x, phi)).abs();
            assert!(off < 1e-12, "{off:e} at {point:?}");
            if point.x > 0.034 && point.x < 0.056 {
                largest = largest.max((radius - 3.2e-3).abs());
            }
        }
        // Three standard deviations are 0.75 mm.
        assert!((0.3e-3..0.75e-3).contains(&largest), "{largest:e}");
    }
    // Both meshes have the lumen's volume: 32 facets around lose 0.6 % of a circle's area.
    let volume: f64 = cells.cell_volumes().into_iter().sum();
    let described = shape.lumen_volume(-0.045, 0.06);
    let share = volume / described;
    assert!((0.983..0.994).contains(&share), "{share}");
    let [native, _] = NativeFluid::new(&case).unwrap().volumes().unwrap();
    let share = native / described;
    println!("native {share}");
    assert!((0.999..1.001).contains(&share), "{share}");
}

/// A realization of circles: the volume is that of the radii, which are those of the smooth vessel where it fades.
#[test]
fn a_realization_has_its_radii_and_volume() {
    let round = RANDOM
        .replace("angle_around_deg = 90.0\n", "")
        .replace("14", "4");
    let case = load(&format!("{round}amplitudes = [1.0]\n"), &[]).unwrap();
    let shape = Vessel::new(vessel(&case));
    let smooth = Vessel::new(vessel(&load("", &[]).unwrap()));
    let pieces = 4000;
    let h = 0.03 / f64::from(pieces);
    let middle = |i: i32| 0.03 + h * (f64::from(i) + 0.5);
    let volume: f64 = (0..pieces)
        .map(|i| PI * shape.lumen_radius(middle(i), 1.0).powi(2) * h)
        .sum();
    let found = shape.lumen_volume(0.03, 0.06);
    assert!((found / volume - 1.0).abs() < 1e-6, "{found:e} {volume:e}");
    // The first mode is one bulge, of which amplitude 1 is a standard deviation in the middle at most.
    let change = |s: f64| shape.lumen_radius(s, 0.4) - smooth.lumen_radius(s, 0.4);
    let bulge = change(0.045);
    assert!((0.15e-3..0.25e-3).contains(&bulge), "{bulge:e}");
    assert_eq!(
        change(0.045),
        shape.lumen_radius(0.045, 3.0) - smooth.lumen_radius(0.045, 3.0)
    );
    for s in [-0.02, 0.01, 0.03, 0.06] {
        assert_eq!(change(s), 0.0, "{s}");
    }
    assert!((0..300).all(|i| change(0.03 + 1e-4 * f64::from(i)) >= 0.0));
    // Wider with the amplitude, in proportion.
    let twice = load(&format!("{round}amplitudes = [2.0]\n"), &[]).unwrap();
    let twice =
        Vessel::new(vessel(&twice)).lumen_radius(0.045, 0.4) - smooth.lumen_radius(0.045, 0.4);
    assert!((twice / bulge - 2.0).abs() < 1e-12);
}

/// The wall's surfaces have the shares of the imperfection (1, 1/3, 0), or all of the field.
#[test]
fn the_wall_thickens_or_moves() {
    let smooth = Vessel::new(vessel(&load("", &[]).unwrap()));
    for (wall, shares) in [("thickens", [1.0, 1.0 / 3.0, 0.0]), ("moves", [1.0; 3])] {
        let tables = format!("{RANDOM}amplitudes = {SOME}\nwall = \"{wall}\"\n");
        let shape = Vessel::new(vessel(&load(&tables, &[]).unwrap()));
        let change = |k: usize| shape.radius(k, 0.042, 2.0) - smooth.radius(k, 0.042, 2.0);
        let lumen = change(0);
        assert!(lumen.abs() > 1e-5, "{lumen:e}");
        for (k, share) in shares.iter().enumerate() {
            assert!((change(k) - share * lumen).abs() < 1e-15, "{wall} {k}");
        }
    }
    // A described vessel of one layer.
    let described = "[vessel]\nradius_m = 3e-3\n[[vessel.piece]]\npiece = \"line\"\nlength_m = 0.06\n[[vessel.section]]\n\
                     name = \"artery\"\nlayers = [\"wall\"]\nthicknesses_m = [1e-3]\n[[vessel.material]]\nname = \"wall\"\n\
                     material = \"neo_hooke\"\nmu_Pa = 1e5\nkappa_Pa = 1e8\n";
    let case = load(&format!("{described}{RANDOM}amplitudes = {SOME}\n"), &[]).unwrap();
    let shape = Vessel::new(vessel(&case));
    let change = shape.radius(0, 0.042, 2.0) - 3e-3;
    assert!(change.abs() > 1e-5 && (shape.radius(1, 0.042, 2.0) - 4e-3).abs() < 1e-15);
}

/// All amplitudes zero, or none given: the vessel without the table, bit for bit.
#[test]
fn zero_amplitudes_change_no_bit() {
    let without = load("", &[]).unwrap();
    for amplitudes in ["", "amplitudes = [0.0, 0, -0.0]\n"] {
        let case = load(&format!("{RANDOM}{amplitudes}"), &[]).unwrap();
        assert_eq!(Vessel::new(vessel(&case)), Vessel::new(vessel(&without)));
        assert_eq!(
            vessel(&case).random_lumen.as_ref().unwrap().amplitudes,
            [0.0; 14]
        );
    }
}

/// Single numbers of a list on the command line, and an input for each of them.
#[test]
fn each_mode_is_an_input() {
    let set = [
        ("random_lumen.amplitudes[2]", "0.7"),
        ("random_lumen.amplitudes[0]", "-1"),
        ("random_lumen.amplitudes[2]", "*2"),
    ];
    let twice = load(RANDOM, &set).unwrap_err();
    assert!(twice.contains("is given twice"), "{twice}");
    let case = load(&format!("{RANDOM}{INPUT}"), &set[..2]).unwrap();
    let amplitudes = &vessel(&case).random_lumen.as_ref().unwrap().amplitudes;
    assert_eq!(amplitudes[..4], [-1.0, 0.0, 0.7, 0.0]);
    let inputs = case.uncertain.as_ref().unwrap();
    assert_eq!(inputs.len(), 14);
    assert_eq!(
        (inputs[2].name.as_str(), inputs[2].value_in(&case)),
        ("lumen 3", Some(0.7))
    );
    let normal = inputs[2].distribution(0.7).unwrap();
    assert!(
        (normal.quantile(0.975) - 1.9385).abs() < 1e-3,
        "{}",
        normal.quantile(0.975)
    );
    assert!((normal.quantile(1.0) - 3.0).abs() < 1e-12);
    // The file of record has them one by one, and is read as the same.
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.toml");
    std::fs::write(&file, case.to_toml_string()).unwrap();
    let again = Case::load(folder.path(), Preset::Paper, &[]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(again.uncertain, case.uncertain);
    assert_eq!(vessel(&again), vessel(&case));
    // Of any list: a multiple of one of its numbers, and a number that it does not have.
    let list = "[vessel]\npoints_m = [[0, 0, 0], [0.03, 0, 0], [0.06, 0, 0]]\nradii_m = [3e-3, 3e-3, 2e-3]\n[[vessel.section]]\n\
                name = \"artery\"\nwall = \"rigid\"\n";
    let case = load(list, &[("vessel.radii_m[1]", "*0.5")]).unwrap();
    let radius = Vessel::new(vessel(&case)).lumen_radius(0.03, 0.0);
    assert!((radius - 1.5e-3).abs() < 1e-12, "{radius:e}");
    let none = load(list, &[("vessel.radii_m[3]", "1e-3")]).unwrap_err();
    assert!(
        none.contains("the list has 3 numbers, from [0] to [2]"),
        "{none}"
    );
}

/// What it says of itself: modes, their share of the variance, three standard deviations, the realization.
#[test]
fn figures_are_those_of_the_field() {
    let figures = random_lumen::figures(&with_amplitudes(SOME)).unwrap();
    assert_eq!(figures.modes, 14);
    assert!((0.89..0.92).contains(&figures.share), "{figures:?}");
    assert!(
        (0.23e-3..0.25e-3).contains(&figures.deviation),
        "{figures:?}"
    );
    assert!((0.072..0.079).contains(&figures.relative), "{figures:?}");
    let [low, high] = figures.change;
    assert!(
        (-0.75e-3..-0.2e-3).contains(&low) && (0.2e-3..0.75e-3).contains(&high),
        "{figures:?}"
    );
    assert_eq!(random_lumen::figures(&load("", &[]).unwrap()), None);
}

/// One sentence for each mistake.
#[test]
fn what_cannot_be_a_random_lumen_is_refused() {
    let change = |from: &str, to: &str| RANDOM.replace(from, to);
    for (tables, key, part) in [
        (
            change("to_m = 0.06", "to_m = 0.03"),
            "to_m",
            "it must be above random_lumen.from_m = 0.03",
        ),
        (
            change("fade_m = 3.75e-3", "fade_m = 0.02"),
            "fade_m",
            "at most half of the part, 0.015 m",
        ),
        (
            change("modes = 14", "modes = 2\namplitudes = [0, 1, 2]"),
            "amplitudes",
            "3 amplitudes for random_lumen.modes = 2",
        ),
        (
            change("length_along_m = 7.5e-3", "length_along_m = 1e-4"),
            "length_along_m",
            "300 times as long",
        ),
        (
            change("angle_around_deg = 90.0\n", "").replace("modes = 14", "modes = 40"),
            "modes",
            "the field has only",
        ),
        (
            change("standard_deviation_m = 0.25e-3", "standard_deviation_m = 0"),
            "standard_deviation_m",
            "above 0.0",
        ),
        (
            change("angle_around_deg = 90.0", "angle_around_deg = 200"),
            "angle_around_deg",
            "at most 180",
        ),
        (
            RANDOM.to_owned() + "amplitudes = []\n",
            "amplitudes",
            "1 to 100 numbers",
        ),
        (
            RANDOM.to_owned() + "wall = \"moved\"\n",
            "wall",
            "did you mean \"moves\"",
        ),
        (change("modes = 14\n", ""), "modes", "from 1 to 100"),
    ] {
        let message = load(&tables, &[]).unwrap_err();
        for part in ["case.toml", &format!("random_lumen.{key}"), part] {
            assert!(message.contains(part), "{key}: {message}");
        }
    }
    for (input, part) in [
        (
            INPUT.to_owned() + "mean = 1.0\n",
            "leave out mean and variation",
        ),
        (INPUT.to_owned() + "low = 4.0\n", "less than a thousandth"),
        (
            INPUT.replace("lumen\"", "the lumen of the artery, one\""),
            "more than 30 characters",
        ),
        (INPUT.replace("lumen\"", "lu]men\""), "a name has no ]"),
        (
            INPUT.to_owned() + &INPUT.replace("lumen\"", "more\""),
            "listed twice",
        ),
        (
            INPUT.replace("amplitudes\"", "amplitudes[20]\""),
            "has 14 numbers, from [0] to [13]",
        ),
        (
            INPUT.replace("random_lumen.amplitudes", "blood.density_kg_m3"),
            "a number above 0",
        ),
    ] {
        let message = load(&format!("{RANDOM}{input}"), &[]).unwrap_err();
        assert!(
            message.contains("`uncertain[") && message.contains(part),
            "{part}: {message}"
        );
    }
    let tree = "[random_lumen]\nmodes = 3\n[flag]\nlength_m = 0.35\n";
    assert!(load(tree, &[]).unwrap_err().contains("random_lumen"));
}

/// What shows in the vessel alone: places beyond it, long elements, a lumen that closes, a layer that vanishes.
#[test]
fn a_field_that_does_not_fit_the_vessel_is_refused() {
    let change = |from: &str, to: &str| RANDOM.replace(from, to);
    let with = |amplitudes: &str| format!("{RANDOM}amplitudes = {amplitudes}\n");
    for (tables, key, part) in [
        (
            change("to_m = 0.06", "to_m = 0.07"),
            "to_m",
            "from s = -0.045000 to 0.060000 m",
        ),
        (
            change("length_along_m = 7.5e-3", "length_along_m = 1.5e-3"),
            "length_along_m",
            "resolves 2.500e-3 m and more",
        ),
        (
            change("angle_around_deg = 90.0", "angle_around_deg = 25.0"),
            "angle_around_deg",
            "resolves 30.0 degrees and more",
        ),
        (
            with("[-10]").replace("0.25e-3", "1e-3"),
            "amplitudes",
            "the radius of the lumen is",
        ),
        (
            with("[7]"),
            "amplitudes",
            "the thickness of layer 1 of the wall is",
        ),
    ] {
        let case = load(&tables, &[("fluid.solver", "native")]).unwrap();
        let mistakes = random_lumen::mistakes(&case);
        let found = mistakes
            .iter()
            .find(|(found, _)| *found == format!("random_lumen.{key}"));
        let (_, sentence) = found.unwrap_or_else(|| panic!("{key}: {mistakes:?}"));
        assert!(sentence.contains(part), "{key}: {sentence}");
    }
    let fine = load(&with(SOME), &[("fluid.solver", "native")]).unwrap();
    assert_eq!(random_lumen::mistakes(&fine), []);
    let cells = load(RANDOM, &[("fluid.mesh.axial_per_section", "4")]).unwrap();
    let mistakes = random_lumen::mistakes(&cells);
    assert_eq!(mistakes.len(), 1);
    assert!(
        mistakes[0].1.contains("fluid.mesh.axial_per_section"),
        "{mistakes:?}"
    );
    let folder = tempfile::tempdir().unwrap();
    let text = format!("extends = \"defaults\"\n{}", with("[7]"));
    std::fs::write(folder.path().join("case.toml"), text).unwrap();
    let out = folder.path().join("out");
    let refused = std::process::Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .args(["--fluid", "native", "--preset", "coarse", "--case"])
        .arg(folder.path())
        .arg("--out")
        .arg(&out)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(
        said.contains("random_lumen.amplitudes") && said.contains("layer 1"),
        "{said}"
    );
    assert!(!out.exists());
}
