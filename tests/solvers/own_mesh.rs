//! User-supplied meshes and dictionaries as others write them: one cell deep, renumbered, with files that include
//! others.

use crate::run_support::*;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn driver(words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command.args(words);
    command
}

fn run(case: &Path, out: &Path, more: &[&str]) -> Command {
    let mut command = driver(&["--quiet", "--case"]);
    command.arg(case).arg("--out").arg(out).args(more);
    command
}

fn check(case: &Path, more: &[&str]) -> Output {
    let mut command = driver(&["check"]);
    command.arg(case).args(more).output().unwrap()
}

/// A column of a table.
fn column(run: &Path, table: &str, name: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(run.join(table)).unwrap();
    let at = reader.headers().unwrap().iter().position(|n| n == name);
    let rows = reader
        .records()
        .map(|row| row.unwrap()[at.unwrap()].parse().unwrap());
    rows.collect()
}

/// A channel in two dimensions, one cell deep, over an elastic plate: that the cells are 20 times as deep as long makes
/// no difference.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn how_deep_the_cells_of_a_plane_case_are_makes_no_difference() {
    let folder = tempfile::tempdir().unwrap();
    for depth in ["1.0", "0.5", "0.2", "0.05"] {
        let [case, out] = ["case", "run"].map(|name| folder.path().join(format!("{name}-{depth}")));
        copy(&project("tests/data/deep-single-cell"), &case);
        edit(
            &case.join("fluid/system/blockMeshDict"),
            "depth 1.0;",
            &format!("depth {depth};"),
        );
        let probe = format!(
            "output.probes_m=[[0.5, 0.0, {}]]",
            0.5 * depth.parse::<f64>().unwrap()
        );
        complete(run(&case, &out, &["--set", &probe]));
        let u = column(&out, "probes.csv", "uy_m")[4];
        assert!((u / -1.38582e-3 - 1.0).abs() < 1e-4, "depth {depth}: {u:e}");
        let lost = column(&out, "history.csv", "force_mismatch");
        assert!(
            lost.iter().all(|lost| *lost < 1e-3),
            "depth {depth}: {lost:?}"
        );
    }
}

/// The flap as published, one cell of 1 m deep, bends as that of 0.1 m does.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_flap_bends_alike_in_a_cell_of_a_metre_and_of_a_tenth() {
    let folder = tempfile::tempdir().unwrap();
    let tips = ["flap", "flap-one-cell-deep"].map(|name| {
        let out = folder.path().join(name);
        complete(run(
            &project("examples/own-case").join(name),
            &out,
            &["--end-time", "0.03"],
        ));
        let lost = column(&out, "history.csv", "force_mismatch");
        assert!(lost.iter().all(|lost| *lost < 1e-3), "{name}: {lost:?}");
        column(&out, "probes.csv", "ux_m")[2]
    });
    println!("{tips:?}");
    assert!((tips[1] / tips[0] - 1.0).abs() < 1e-5, "{tips:?}");
}

/// A wall in millimetres next to a fluid in metres, and one of which a part has no fluid next to it.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_wall_in_another_unit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let flap = project("examples/own-case/flap-one-cell-deep");
    for (unit, words) in [
        (
            "1000.0",
            "times as large as the fluid: the wall seems to be in millimetres, the fluid in metres",
        ),
        (
            "0.001",
            "times as large as the wall: the fluid seems to be in millimetres, the wall in metres",
        ),
    ] {
        let output = check(&flap, &["--set", &format!("wall.file.unit_m={unit}")]);
        let said = text(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            said.contains(words)
                && said.contains(&format!("unit_m = {unit}: write 1,").replace(".0:", ":")),
            "{said}"
        );
        assert!(!said.contains("structure.p"), "{said}");
    }
    let said = text(&check(&flap, &[]));
    for words in [
        "0.0 % of the wall's wet surface has none next to it\n",
        "mesh    6.0000 m x 4.0000 m x 1.0000 m",
        "hydraulic diameters: inlet 8.0000 m, outlet 8.0000 m",
    ] {
        assert!(said.contains(words), "{said}");
    }

    // The flap is as deep again as the fluid.
    let deep = folder.path().join("deep");
    copy(&flap, &deep);
    let mesh = deep.join("flap.inp");
    let lines = fs::read_to_string(&mesh).unwrap();
    let deeper = lines.lines().map(|line| match line.strip_suffix(", 1") {
        Some(rest) if rest.matches(',').count() == 2 => format!("{rest}, 2\n"),
        _ => format!("{line}\n"),
    });
    fs::write(&mesh, deeper.collect::<String>()).unwrap();
    let output = check(&deep, &[]);
    let said = text(&output);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("50.0 % of the wall's wet surface has none next to it"),
        "{said}"
    );
}

/// The cell with the largest number owns no face.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_mesh_whose_last_cell_lies_inside_has_all_its_cells() {
    let folder = tempfile::tempdir().unwrap();
    let (case, out) = (
        project("tests/data/last-cell-inside"),
        folder.path().join("run"),
    );
    let said = text(&check(&case, &[]));
    assert!(said.contains("27 cells"), "{said}");
    complete(run(&case, &out, &[]));
    let volume = column(&out, "history.csv", "lumen_volume_m3");
    assert_eq!(volume.len(), 2);
    // A cube of 3 mm.
    assert!((volume[1] / 2.7e-8 - 1.0).abs() < 1e-12, "{volume:?}");
}

/// OpenFOAM looks for what a file includes next to that file, wherever the case is copied to.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn files_include_others_from_anywhere_in_the_case() {
    let folder = tempfile::tempdir().unwrap();
    let [case, plain, out] = ["case", "plain", "run"].map(|name| folder.path().join(name));
    copy(&project("tests/data/deep-single-cell"), &case);
    let fluid = case.join("fluid");
    fs::create_dir(fluid.join("include")).unwrap();
    fs::write(
        fluid.join("settings"),
        "start (0 0 0);\nbothEnds 1.0;\ncellsUp 8;\n",
    )
    .unwrap();
    fs::write(fluid.join("include/again"), "#include \"../settings\"\n").unwrap();
    fs::write(fluid.join("system/steps"), "correctors 2;\n").unwrap();
    for (file, from, to) in [
        ("0/U", "dimensions", "#include \"../settings\"\ndimensions"),
        (
            "0/U",
            "boundaryField\n{",
            "boundaryField\n{\n    #includeEtc \"caseDicts/setConstraintTypes\"",
        ),
        ("0/U", "uniform (0 0 0)", "uniform $start"),
        (
            "0/p",
            "dimensions",
            "#include \"../include/again\"\ndimensions",
        ),
        ("0/p", "uniform 1.0", "uniform $bothEnds"),
        (
            "system/fvSolution",
            "solvers\n",
            "#include \"steps\"\n#include \"$FOAM_CASE/settings\"\nsolvers\n",
        ),
        (
            "system/fvSolution",
            "nCorrectors 2",
            "nCorrectors $correctors",
        ),
        (
            "system/controlDict",
            "application",
            "#include \"../include/again\"\napplication",
        ),
        (
            "system/blockMeshDict",
            "convertToMeters",
            "#include \"../settings\"\nconvertToMeters",
        ),
        ("system/blockMeshDict", "20 8 1", "20 $cellsUp 1"),
    ] {
        edit(&fluid.join(file), from, to);
    }
    let said = text(&check(&case, &[]));
    assert!(said.contains("can be run"), "{said}");
    let few = ["--end-time", "0.02"];
    complete(run(&case, &out, &few));
    complete(run(&project("tests/data/deep-single-cell"), &plain, &few));
    assert_same_run(&out, &plain);
    // As often as one likes, and from a checkpoint.
    complete(run(&case, &out, &["--end-time", "0.03", "--resume"]));

    // What lies outside is not copied.
    fs::write(case.join("elsewhere"), "start (0 0 0);\n").unwrap();
    edit(&fluid.join("0/U"), "../settings", "../../elsewhere");
    let output = check(&case, &[]);
    let said = text(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("0/U") && said.contains("which lies outside the case"),
        "{said}"
    );
}

/// Cross-sections of the carotid, near the inlet and in the middle of each branch.
const SECTIONS: &str = "
[[output.section]]
name = \"near\"
branch = \"common\"
at_m = 1.5e-3
[[output.section]]
name = \"common\"
branch = \"common\"
at_m = 0.02
[[output.section]]
name = \"internal\"
branch = \"internal\"
at_m = 0.02
[[output.section]]
name = \"external\"
branch = \"external\"
at_m = 0.02
";

/// Column of a table in the rows of this name.
fn rows_of(run: &Path, table: &str, name: &str, title: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(run.join(table)).unwrap();
    let at = reader.headers().unwrap().iter().position(|n| n == title);
    let rows = reader.records().map(Result::unwrap);
    rows.filter(|row| &row[1] == name && !row[at.unwrap()].is_empty())
        .map(|row| row[at.unwrap()].parse().unwrap())
        .collect()
}

/// Cells of any shape, whose edges are in no rows: what passes cross-sections is what the openings and the wall make of
/// it.
fn cross_sections_balance(own: &Path, meshed: &Path) {
    let [near, common, internal, external] = ["near", "common", "internal", "external"]
        .map(|name| rows_of(own, "sections.csv", name, "flow_m3_s"));
    let inlet = rows_of(own, "openings.csv", "common", "flow_m3_s");
    let volume = column(own, "history.csv", "lumen_volume_m3");
    for n in 0..near.len() {
        let grows = (volume[n + 1] - volume[n]) / 0.005;
        // Next to the clamped inlet the vessel hardly grows, in the branches a part of the whole.
        let before = inlet[n + 1] - near[n];
        println!("{before:e} {grows:e}");
        assert!(
            before.abs() < 0.03 * grows.abs() + 2e-9,
            "{before:e} {grows:e}"
        );
        let between = common[n] - internal[n] - external[n];
        assert!(
            (0.5..0.9).contains(&(between / grows)),
            "{between:e} {grows:e}"
        );
    }
    for name in ["near", "common", "internal", "external"] {
        let [a, b] = [own, meshed].map(|run| rows_of(run, "sections.csv", name, "area_m2")[2]);
        println!("{name}: area {a:e} {b:e}");
        assert!((0.97..1.03).contains(&(a / b)), "{name}: {a:e} {b:e}");
    }
}

/// Of backward differences in the OpenFOAM case, cross-sections take the same.
fn cross_sections_know_backward_differences(case: &Path) {
    let schemes = case.join("fluid/system/fvSchemes");
    edit(
        &schemes,
        "default         Euler",
        "default         backward",
    );
    let out = case.join("backward");
    complete(run(case, &out, &["--end-time", "0.03"]));
    let near = rows_of(&out, "sections.csv", "near", "flow_m3_s");
    let inlet = rows_of(&out, "openings.csv", "common", "flow_m3_s");
    let volume = column(&out, "history.csv", "lumen_volume_m3");
    let mut apart: f64 = 0.0;
    // The second step has no earlier change of volume to compare with.
    for n in 2..6 {
        let rate = |n: usize| (volume[n] - volume[n - 1]) / 0.005;
        apart = apart.max((rate(n) - rate(n - 1)).abs() / 2.0);
        let before = inlet[n] - near[n - 1];
        println!("step {n}: {before:e}");
        assert!(before.abs() < 1e-8, "step {n}: {before:e}");
    }
    // Of first order, the flow would be off by so much.
    assert!((5e-8..2e-7).contains(&apart), "{apart:e}");
}

/// The carotid in cells of snappyHexMesh, with a wall around its centre-lines, beside the same surface in the driver's
/// own mesh; and what is refused of such a case.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_wall_around_centre_lines_fits_cells_of_any_shape() {
    let folder = tempfile::tempdir().unwrap();
    for part in ["own-case/carotid", "trees/carotid"] {
        copy(
            &project("examples").join(part),
            &folder.path().join("examples").join(part),
        );
    }
    let trees = folder.path().join("examples/trees");
    fs::copy(project("examples/trees/lumen.py"), trees.join("lumen.py")).unwrap();
    let case = folder.path().join("examples/own-case/carotid");
    let made = Command::new(case.join("make_mesh.sh")).output().unwrap();
    assert!(made.status.success(), "{}", text(&made));
    assert!(text(&made).contains("Mesh OK"), "{}", text(&made));
    for (words, said) in [
        (
            "tree.inlet=entry",
            "the wall ends at \"entry\", which is no patch of the OpenFOAM case: call each end as the patch there, one of \
             \"common\", \"internal\", \"external\"",
        ),
        ("tree.unit=m", "tree.unit"),
        ("fluid.solver=native", "a case of OpenFOAM is for OpenFOAM"),
        (
            "wall.mode=rigid",
            "only an elastic wall is made from [tree]",
        ),
        ("coupling.surrogate=tube", "write \"potential\" or \"none\""),
    ] {
        let output = check(&case, &["--set", words]);
        assert_eq!(output.status.code(), Some(2), "{words}: {}", text(&output));
        assert!(text(&output).contains(said), "{words}: {}", text(&output));
    }
    let said = text(&check(&case, &["--set", "wall.extrude.thicknesses=[0.45]"]));
    assert!(
        said.contains("the normals of its wall are averaged 16 times"),
        "{said}"
    );
    let mut preview = driver(&["preview"]);
    preview.arg(&case).arg("--out").arg(case.join("drawn"));
    complete(preview);
    let page = fs::read_to_string(case.join("drawn/preview.html")).unwrap();
    for part in [
        "cells of your OpenFOAM case; wall of 272 elements of degree 3",
        "common divides into internal, external.",
        "the wet patches of the OpenFOAM mesh in red",
    ] {
        assert!(page.contains(part), "{part}");
    }
    // What is known of the cells of a tree says nothing of these.
    assert!(!page.contains("Jacobian") && !page.contains("worst places"));
    for tree in [&case, &trees.join("carotid")] {
        let file = tree.join("case.toml");
        let with_sections = fs::read_to_string(&file).unwrap() + SECTIONS;
        fs::write(file, with_sections).unwrap();
    }
    for (words, said) in [
        (
            "fluid.openings=[\"common\",\"internal\"]",
            "all ends of the tree are needed here: add \"external\"",
        ),
        (
            "tree.leave_out=[\"external\"]",
            "expected a branch with an opening, one of \"common\", \"internal\"",
        ),
        (
            "output.section[0].at_m=0.05",
            "no cross-section of the elastic wall is there: its faces lie from 0.000",
        ),
    ] {
        let output = check(&case, &["--set", words]);
        assert_eq!(output.status.code(), Some(2), "{words}: {}", text(&output));
        assert!(text(&output).contains(said), "{words}: {}", text(&output));
    }
    let surface = case.join("fluid/constant/triSurface/lumen.stl");
    let lumen = format!("tree.lumen=\"{}\"", surface.display());
    let tree = trees.join("carotid");
    let ends = ["--end-time", "0.02"];
    let lumen = ["--set", &lumen, "--set", "tree.lumen_unit=m"];
    let with_lumen = [&ends[..], &lumen, &["--fluid", "openfoam"]].concat();
    let [own, meshed] = [(&case, &ends[..]), (&tree, &with_lumen)].map(|(case, words)| {
        let out = case.join("run");
        complete(run(case, &out, words));
        out
    });
    let lost = column(&own, "history.csv", "force_mismatch");
    assert!(lost.iter().all(|lost| *lost < 1e-3), "{lost:?}");
    for (name, within) in [
        ("lumen_volume_m3", 0.02),
        ("p_in_Pa", 5e-3),
        ("max_von_mises_Pa", 0.015),
    ] {
        let [own, meshed] = [&own, &meshed].map(|run| column(run, "history.csv", name));
        let ratio = own[3] / meshed[3];
        println!("{name}: {} {} {ratio}", own[3], meshed[3]);
        assert!((ratio - 1.0).abs() < within, "{name}: {own:?} {meshed:?}");
    }
    let regions = fs::read_to_string(own.join("regions.csv")).unwrap();
    for branch in ["common", "internal", "external"] {
        assert!(regions.contains(branch), "{branch}");
    }
    cross_sections_balance(&own, &meshed);
    cross_sections_know_backward_differences(&case);
}
