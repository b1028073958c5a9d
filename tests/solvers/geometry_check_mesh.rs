//! OpenFOAM's own opinion of the fluid meshes: all twelve models, the presets, the flag.

use fsi_driver::analysis::size;
use fsi_driver::case::{Case, Preset, Problem};
use fsi_driver::fluid::openfoam::Programs;
use fsi_driver::geometry::flag;
use fsi_driver::geometry::fluid_mesh;
use fsi_driver::simulation::assembly::Domain;
use std::path::Path;

const MODELS: [&str; 12] = [
    "S-0.0", "S-0.25", "S-0.5", "S-0.75", "H-0.0", "H-0.25", "H-0.5", "H-0.75", "A-0.0", "A-0.25",
    "A-0.5", "A-0.75",
];
const MAX_NON_ORTHOGONALITY: f64 = 65.0;

/// Runs `checkMesh` on the model's mesh and returns the largest non-orthogonality in degrees.
fn check(model: &str, preset: Preset) -> f64 {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case");
    check_in(&models, model, preset, MAX_NON_ORTHOGONALITY)
}

/// The same of a case in the folder `models`.
fn check_in(models: &Path, model: &str, preset: Preset, most: f64) -> f64 {
    check_with(
        &["-allGeometry", "-allTopology"],
        models,
        model,
        preset,
        most,
    )
}

/// The same with these options of `checkMesh`.
fn check_with(options: &[&str], models: &Path, model: &str, preset: Preset, most: f64) -> f64 {
    let folder = models.join(model);
    let case = Case::load(&folder, preset, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    let mesh = match &case.problem {
        Problem::Vessel(vessel) => fluid_mesh(vessel),
        Problem::Flag(flag) => flag::fluid_mesh(flag),
        Problem::UserCase(_) => Domain::new(&case).unwrap().fluid,
    };
    if case.own().is_none() {
        assert_eq!(mesh.cells(), size::fluid_cells(&case));
    }
    let scratch = tempfile::tempdir().unwrap();
    mesh.write(scratch.path()).unwrap();
    let system = scratch.path().join("system");
    std::fs::create_dir(&system).unwrap();
    let header = |object: &str| {
        format!("FoamFile {{ version 2.0; format ascii; class dictionary; object {object}; }}\n")
    };
    let control = "application pimpleFoam; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;\n\
                   writeControl timeStep; writeInterval 1;\n";
    std::fs::write(system.join("controlDict"), header("controlDict") + control).unwrap();
    let schemes = "divSchemes {} gradSchemes {} laplacianSchemes {}\n";
    std::fs::write(system.join("fvSchemes"), header("fvSchemes") + schemes).unwrap();
    std::fs::write(system.join("fvSolution"), header("fvSolution")).unwrap();
    let output = Programs::new(scratch.path(), &[])
        .command("checkMesh")
        .args(options)
        .output()
        .expect("OpenFOAM's checkMesh: install Debian's package openfoam");
    let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert!(
        output.status.success() && text.contains("\nMesh OK."),
        "{model} {preset}: {text}"
    );
    assert!(!text.contains("***"), "{model} {preset}: {text}");
    let number = |label: &str| -> f64 {
        let after = text
            .split(label)
            .nth(1)
            .unwrap_or_else(|| panic!("no {label:?} in {text}"));
        after
            .split_whitespace()
            .next()
            .unwrap()
            .trim_end_matches(['.', ','])
            .parse()
            .unwrap()
    };
    let non_orthogonality = number("Mesh non-orthogonality Max: ");
    let (skewness, aspect, volume) = (
        number("Max skewness = "),
        number("Max aspect ratio = "),
        number("Total volume = "),
    );
    println!(
        "{model:6} {preset:6} {:6} cells, non-orthogonality {non_orthogonality:.1}°, skewness {skewness:.2}, aspect ratio {aspect:.1}",
        mesh.cells()
    );
    assert!(
        non_orthogonality < most,
        "{model} {preset}: {non_orthogonality}°"
    );
    // checkMesh prints six digits.
    approx::assert_relative_eq!(mesh.volume(), volume, max_relative = 1e-5);
    approx::assert_relative_eq!(
        mesh.non_orthogonality_deg(),
        non_orthogonality,
        max_relative = 1e-5
    );
    non_orthogonality
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn all_twelve_models_are_good_meshes_at_the_coarse_preset() {
    for model in MODELS {
        check(model, Preset::Coarse);
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn the_hardest_models_are_good_meshes_at_the_other_presets() {
    for model in ["S-0.75", "H-0.75", "A-0.75", "S-0.25"] {
        check(model, Preset::Demo);
    }
    for model in ["S-0.25", "H-0.75"] {
        check(model, Preset::Paper);
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn the_flag_in_its_channel_passes() {
    check("turek-hron", Preset::Paper);
}

/// A vessel of one section of 3 mm, of these lines.
fn described(folder: &Path, name: &str, lines: &str) {
    std::fs::create_dir(folder.join(name)).unwrap();
    let text = format!(
        "extends = \"defaults\"\n[vessel]\nradius_m = 3e-3\nupstream_extension_m = 0.006\n{lines}\n[[vessel.section]]\nname = \
         \"artery\"\nlayers = [\"wall\"]\nthicknesses_m = [0.9e-3]\n[[vessel.material]]\nname = \"wall\"\nmaterial = \
         \"neo_hooke\"\nmu_Pa = 1e5\nkappa_Pa = 1e8\n"
    );
    std::fs::write(folder.join(name).join("case.toml"), text).unwrap();
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn narrow_and_bent_vessels_have_good_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let bend = "[[vessel.piece]]\npiece = \"arc\"\nlength_m = 0.028\nbend_radius_m = 9e-3";
    let narrow = "[[vessel.feature]]\nfeature = \"stenosis\"\nat_m = 0.014\nlength_m = 0.012\narea_reduction = 0.75\neccentricity = 0.5";
    let line = "[[vessel.piece]]\npiece = \"line\"\nlength_m = 0.028";
    let cone = "end_radius_m = 1.5e-3\n[[vessel.piece]]\npiece = \"line\"\nlength_m = 0.028";
    for (name, lines) in [
        ("stenosis", format!("{line}\n{narrow}")),
        ("bend", bend.to_owned()),
        ("both", format!("{bend}\n{narrow}")),
        ("cone", cone.to_owned()),
    ] {
        described(folder.path(), name, &lines);
        for preset in [Preset::Demo, Preset::Coarse, Preset::Paper] {
            check_in(folder.path(), name, preset, MAX_NON_ORTHOGONALITY);
        }
    }
    // From surfaces and centre-lines of segmentations.
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/vessels");
    for name in ["surface", "carotid"] {
        check_in(&examples, name, Preset::Demo, MAX_NON_ORTHOGONALITY);
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn openfoam_accepts_the_meshes_of_trees() {
    let trees = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/trees");
    // Next to an apex; OpenFOAM warns from 70° on.
    for (tree, range) in [("carotid", 47.0..52.0), ("arteries", 45.0..70.0)] {
        let degrees = check_in(&trees, tree, Preset::Demo, range.end);
        assert!(range.contains(&degrees), "{tree}: {degrees}");
    }
}

/// The meshes that `new` proposes for lines. The check of all geometry, which otherwise passes, finds faces that cannot
/// be divided into tetrahedra as the tracking of particles would need them in `paper`: 2 of the carotid's, 14 of the
/// other tree's.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn openfoam_accepts_proposed_trees_in_all_presets() {
    let folder = tempfile::tempdir().unwrap();
    let trees = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/trees");
    for (lines, range) in [
        ("carotid/lines.vtp", 47.0..53.0),
        ("arteries/tree.swc", 44.0..48.0),
    ] {
        let tree = lines.split('/').next().unwrap();
        let mut new = std::process::Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
        new.current_dir(folder.path()).args(["new", tree, "--from"]);
        new.arg(trees.join(lines)).args(["--unit", "mm"]);
        crate::run_support::complete(new);
        for preset in [Preset::Demo, Preset::Coarse, Preset::Paper] {
            let options: &[&str] = match preset {
                Preset::Paper => &["-allTopology"],
                _ => &["-allGeometry", "-allTopology"],
            };
            let degrees = check_with(options, folder.path(), tree, preset, range.end);
            assert!(range.contains(&degrees), "{tree} {preset}: {degrees}");
        }
    }
}
