//! Vessels from the files that people have: centre-lines of VMTK and in SWC, surfaces in STL and VTP.
//!
//! The files `*.vtp` next to this one were written by VTK 9 in each of its encodings: two noisy centre-lines from one
//! inlet, cut into tracts as `vmtkbranchextractor` does.

mod others;
pub(crate) mod shapes;

use fsi_driver::Vec3;
use fsi_driver::case::{Case, Preset, ResolvedCase, Shape, VesselDescription};
use fsi_driver::geometry::{Vessel, fluid_mesh, solid_mesh};
use others::pairs_vtp;
use shapes::{TubeSurface, vtp_of};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const REST: &str = r#"
[[vessel.section]]
name = "artery"
layers = ["wall"]
thicknesses = [0.2]
[[vessel.material]]
name = "wall"
material = "neo_hooke"
mu_Pa = 1.0e5
kappa_Pa = 1.0e8
"#;

fn try_load(folder: &Path, vessel: &str) -> Result<ResolvedCase, String> {
    let text = format!("extends = \"defaults\"\n[vessel]\n{vessel}{REST}");
    std::fs::write(folder.join("case.toml"), text).unwrap();
    Case::load(folder, Preset::Demo, &[]).map_err(|errors| {
        assert_eq!(errors.0.len(), 1, "{errors}");
        errors.to_string()
    })
}

fn load(folder: &Path, vessel: &str) -> ResolvedCase {
    try_load(folder, vessel).unwrap_or_else(|errors| panic!("{errors}\n{vessel}"))
}

fn described(case: &ResolvedCase) -> &VesselDescription {
    match &case.vessel().unwrap().shape {
        Shape::Vessel(vessel) => vessel,
        Shape::Anastomosis(_) => panic!("another vessel"),
    }
}

fn given(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/library/vessel_files")
        .join(name)
}

fn of_vmtk(name: &str, more: &str) -> String {
    format!("centre_line = {:?}\nunit = \"mm\"\n{more}", given(name))
}

#[test]
fn centre_lines_of_vmtk_are_the_same_in_all_encodings() {
    let folder = tempfile::tempdir().unwrap();
    let line = |name: &str| {
        let case = load(
            folder.path(),
            &of_vmtk(name, "branch = \"CenterlineIds=1\"\nsmoothing_m = 6e-3\n"),
        );
        let vessel = described(&case);
        (vessel.points.clone(), vessel.radii.clone())
    };
    let (points, radii) = line("ascii-plain-32.vtp");
    // From (10, 0, 5) to (57, 23.35, -8) mm, 3 to 1.5 mm wide, 51 mm and more long.
    let ends = [points[0], points[points.len() - 1]];
    for (found, exact) in ends.iter().zip([[10.0, 0.0, 5.0], [57.0, 23.35, -8.3]]) {
        let off = (Vec3::from(*found) * 1e3 - Vec3::from(exact)).norm();
        assert!(off < 0.6, "{found:?} {exact:?}");
    }
    assert!((radii[0] - 3e-3).abs() < 0.1e-3 && (radii[radii.len() - 1] - 1.5e-3).abs() < 0.1e-3);
    let others = [
        "binary-zlib-64.vtp",
        "binary-plain-32.vtp",
        "appended-zlib-32.vtp",
        "appended-plain-64.vtp",
        "appended-plain-base64-32.vtp",
        "big-endian.vtp",
    ];
    for name in others {
        let (others, of_others) = line(name);
        assert_eq!(others.len(), points.len(), "{name}");
        for (a, b) in points.iter().flatten().zip(others.iter().flatten()) {
            assert!((a - b).abs() < 2e-8, "{name}: {a} {b}"); // ASCII has seven digits
        }
        for (a, b) in radii.iter().zip(&of_others) {
            assert!((a - b).abs() < 1e-8, "{name}: {a} {b}");
        }
    }
}

#[test]
fn a_branch_is_chosen_and_the_others_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let file = |more: &str| of_vmtk("binary-zlib-64.vtp", more);
    let error = try_load(folder.path(), &file("")).unwrap_err();
    for part in [
        "several lines: choose one by vessel.branch =",
        "\"CenterlineIds=0\" (98 points, ",
        "\"GroupIds=3\" (51 points, ",
    ] {
        assert!(error.contains(part), "{error}");
    }
    let error = try_load(folder.path(), &file("branch = \"GroupIds=7\"\n")).unwrap_err();
    assert!(
        error.contains("there is no branch \"GroupIds=7\"; there is \"CenterlineIds=0\""),
        "{error}"
    );
    // A group that both centre-lines pass is one branch; so is the line of a number.
    let smooth = |branch: &str| file(&format!("branch = {branch:?}\nsmoothing_m = 6e-3\n"));
    let (bifurcation, left) = ([30.0, 8.0, 5.0], [57.0, 23.35, 17.9]);
    for (branch, start, end) in [
        ("GroupIds=0", [10.0, 0.0, 5.0], bifurcation),
        ("GroupIds=2", [32.0, 9.6, 5.4], left),
        ("Line=3", [32.0, 9.6, 5.4], left),
        ("CenterlineIds=0", [10.0, 0.0, 5.0], left),
    ] {
        let case = load(folder.path(), &smooth(branch));
        let points = &described(&case).points;
        for (found, exact) in [(points[0], start), (points[points.len() - 1], end)] {
            let off = (Vec3::from(found) * 1e3 - Vec3::from(exact)).norm();
            assert!(off < 0.3, "{branch}: {found:?} {exact:?}");
        }
    }
    let forward = load(folder.path(), &file("branch = \"GroupIds=2\"\n"));
    let back = load(
        folder.path(),
        &file("branch = \"GroupIds=2\"\nreverse = true\n"),
    );
    let (mut points, mut radii) = (
        described(&back).points.clone(),
        described(&back).radii.clone(),
    );
    points.reverse();
    radii.reverse();
    assert_eq!(
        (points, radii),
        (
            described(&forward).points.clone(),
            described(&forward).radii.clone()
        )
    );
}

#[test]
fn a_tree_in_swc_has_branches_by_their_ends() {
    let folder = tempfile::tempdir().unwrap();
    let swc = "# made by hand\n1 2 0 0 0 3.0 -1\n2 2 10 0 0 2.9 1\n3 2 20 1 0 2.8 2\n4 2 30 8 0 2.0 3\n5 2 30 -8 0 2.1 3\n6 2 40 -16 0 2.0 5\n";
    std::fs::write(folder.path().join("tree.swc"), swc).unwrap();
    let file = "centre_line = \"tree.swc\"\nunit = \"mm\"\n";
    let error = try_load(folder.path(), file).unwrap_err();
    assert!(
        error.contains("2 ends: choose one by vessel.branch = \"4\" (4 points), \"6\" (5 points)"),
        "{error}"
    );
    let case = load(folder.path(), &format!("{file}branch = \"6\"\n"));
    let vessel = described(&case);
    assert_eq!(vessel.points.len(), 5);
    assert_eq!(vessel.points[4], [0.04, -0.016, 0.0]);
    assert_eq!(vessel.radii, [3.0, 2.9, 2.8, 2.1, 2.0].map(|r| r * 1e-3));
}

#[test]
fn a_noisy_line_is_smoothed_to_what_it_was() {
    let folder = tempfile::tempdir().unwrap();
    // An arc of 30 mm radius over 60 mm, points every 0.25 mm that scatter by 0.1 mm.
    let mut seed = 1u64;
    let mut noise = || {
        seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (seed >> 33) as f64 / f64::from(1u32 << 31) - 0.5
    };
    let exact = |s: f64| {
        Vec3::new(
            30.0 * (s / 30.0).sin(),
            30.0 * (1.0 - (s / 30.0).cos()),
            0.0,
        )
    };
    let mut text = String::from("x,y,z\n");
    for i in 0..=240 {
        let p = exact(0.25 * f64::from(i)) + Vec3::from_fn(|_, _| 0.3 * noise());
        let _ = writeln!(text, "{},{},{}", p.x, p.y, p.z);
    }
    std::fs::write(folder.path().join("line.csv"), text).unwrap();
    let file = "centre_line = \"line.csv\"\nunit = \"mm\"\nradius_m = 2e-3\n";
    let error = try_load(folder.path(), file).unwrap_err();
    assert!(error.contains("vessel.smoothing_m"), "{error}");
    let case = load(folder.path(), &format!("{file}smoothing_m = 0.012\n"));
    let vessel = Vessel::new(case.vessel().unwrap());
    let line = vessel.centre_line();
    let length = line.ends()[1];
    assert!((length - 0.06).abs() < 3e-4, "{length}");
    let (mut off, mut bend) = (0.0f64, [f64::INFINITY, 0.0f64]);
    for i in 0..=100 {
        let s = length * f64::from(i) / 100.0;
        let p = line.frame(s).origin * 1e3;
        let radius = (p - Vec3::new(0.0, 30.0, 0.0)).xy().norm();
        off = off.max((radius - 30.0).hypot(p.z));
        if (10..=90).contains(&i) {
            let kappa = line.curvature(s).norm() * 0.03;
            bend = [bend[0].min(kappa), bend[1].max(kappa)];
        }
    }
    // Measured: 0.101 mm, at the ends, and between 0.49 and 1.30 of the arc's curvature.
    assert!((0.09..0.11).contains(&off), "{off}");
    assert!(bend[0] > 0.47 && bend[1] < 1.32, "{bend:?}");
}

/// Largest difference (m) between the lumen of a case and what the shape says.
fn off(case: &ResolvedCase, exact: &TubeSurface, from: f64) -> f64 {
    let vessel = Vessel::new(case.vessel().unwrap());
    let line = vessel.centre_line();
    let mut worst = 0.0f64;
    for i in 0..=60 {
        let s = from + (vessel.end() - 2.0 * from) * f64::from(i) / 60.0;
        for j in 0..40 {
            let phi = TAU * f64::from(j) / 40.0;
            let r = vessel.lumen_radius(s, phi);
            let point = line.frame(s).point(r * phi.cos(), r * phi.sin());
            worst = worst.max(exact.outside(&point).abs());
        }
    }
    worst
}

#[test]
fn a_lumen_is_that_of_its_surface_within_the_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let ellipse = |s: f64, phi: f64| {
        let (a, b) = (3.4e-3 - 0.01 * s, 2.6e-3);
        a * b / (b * phi.cos()).hypot(a * phi.sin())
    };
    let round = |_: f64, _: f64| 3e-3;
    // Measured: 24 sides leave 26 µm of a circle, 96 sides 1.6 µm; what smoothing takes off is less.
    for (name, tube, sides, most) in [
        (
            "a circle of 24 sides",
            TubeSurface::straight(0.05, round),
            24,
            27e-6,
        ),
        (
            "a circle of 96 sides",
            TubeSurface::straight(0.05, round),
            96,
            1.7e-6,
        ),
        ("an ellipse", TubeSurface::straight(0.05, ellipse), 96, 8e-6),
        ("a bend", TubeSurface::bent(0.05, 0.03, ellipse), 96, 12e-6),
    ] {
        let slices = sides * 3;
        tube.write_line(&folder.path().join("line.csv"), 40, 1e3);
        let mut found = Vec::new();
        for (file, is_closed) in [
            ("open.stl", false),
            ("closed.stl", true),
            ("ascii.stl", true),
            ("tube.vtp", false),
        ] {
            tube.write_surface(&folder.path().join(file), slices, sides, is_closed, 1e3);
            let text = format!("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = {file:?}\n");
            let case = load(folder.path(), &text);
            found.push(off(&case, &tube, 1e-3));
            let mesh = fluid_mesh(case.vessel().unwrap());
            assert!(mesh.cell_volumes().into_iter().all(|v| v > 0.0), "{name}");
            assert!(!solid_mesh(case.vessel().unwrap()).hexes.is_empty());
        }
        println!("{name}: {found:?}");
        for worst in found {
            assert!(worst < most, "{name}: {worst:e}");
        }
    }
}

#[test]
fn the_record_of_a_run_has_the_radii_in_place_of_the_surface() {
    let folder = tempfile::tempdir().unwrap();
    let tube = TubeSurface::bent(0.04, 0.03, |_, phi| 2.5e-3 + 0.3e-3 * (2.0 * phi).cos());
    tube.write_line(&folder.path().join("line.csv"), 30, 1e2);
    tube.write_surface(&folder.path().join("tube.stl"), 60, 40, false, 1e3);
    let text = "centre_line = \"line.csv\"\nunit = \"cm\"\nlumen = \"tube.stl\"\nlumen_unit = \"mm\"\nsmoothing_m = 2e-3\n";
    let case = load(folder.path(), text);
    let record = case.to_toml_string();
    assert!(
        !record.contains("tube.stl") && !record.contains("smoothing"),
        "{record}"
    );
    let again = tempfile::tempdir().unwrap();
    std::fs::write(again.path().join("case.toml"), &record).unwrap();
    let loaded = Case::load(again.path(), Preset::Paper, &[]).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(loaded.case, case.case);
    assert_eq!(
        Vessel::new(loaded.vessel().unwrap()),
        Vessel::new(case.vessel().unwrap())
    );
}

/// What stands in the case, and what the message must contain. The files are those of `broken_files`.
#[rustfmt::skip]
const MISTAKES: &[(&str, &str, &str)] = &[
    ("centre_line = \"line.vtu\"\nunit = \"mm\"\n", "vessel.centre_line", "expected a file that ends with .csv, .vtp or .swc"),
    ("centre_line = \"nowhere.vtp\"\nunit = \"mm\"\n", "vessel.centre_line", "No such file"),
    ("centre_line = \"nan.vtp\"\nunit = \"mm\"\n", "vessel.centre_line", "point 2 of 3 has a coordinate that is not a finite number"),
    ("centre_line = \"no-radius.vtp\"\nunit = \"mm\"\n", "vessel.centre_line", "the vessel has no radius"),
    ("centre_line = \"zero-radius.vtp\"\nunit = \"mm\"\n", "vessel.centre_line", "the radius of point 3 is 0.0"),
    ("centre_line = \"cut.vtp\"\nunit = \"mm\"\n", "vessel.centre_line", "cut off"),
    ("centre_line = \"damaged.vtp\"\nunit = \"mm\"\n", "vessel.centre_line", "damaged"),
    ("centre_line = \"text.vtp\"\nunit = \"mm\"\n", "vessel.centre_line", "not a VTK file in XML"),
    ("centre_line = \"empty.vtp\"\nunit = \"mm\"\n", "vessel.centre_line", "the file is empty"),
    ("centre_line = \"tube.vtp\"\nunit = \"mm\"\n", "vessel.centre_line", "triangles and no lines: is it the surface, which vessel.lumen names?"),
    ("centre_line = \"metres.vtp\"\nunit = \"m\"\n", "vessel.centre_line", "is the unit of the file the right one?"),
    ("centre_line = \"good.vtp\"\n", "vessel.centre_line", "expected its unit of length next to it"),
    ("centre_line = \"good.vtp\"\nunit = \"mm\"\nbranch = \"Line=2\"\n", "vessel.centre_line", "there is no branch \"Line=2\""),
    ("centre_line = \"good.vtp\"\nunit = \"mm\"\nbranch = \"left\"\n", "vessel.centre_line", "there is \"Line=1\" (3 points, 40.6155 long)"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nradius_m = 3e-3\nbranch = \"1\"\n", "vessel.centre_line", "leave out vessel.branch"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nradius_m = 3e-3\nbranch = \"1\"\n", "vessel.branch", "lines from a file"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nradius_m = 3e-3\nreverse = true\n", "vessel.reverse", "lines from a file"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nradius_m = 3e-3\nsmoothing_m = -1.0\n", "vessel.smoothing_m", "above 0.0"),
    ("centre_line = \"circle.swc\"\nunit = \"mm\"\n", "vessel.centre_line", "its own ancestor"),
    ("centre_line = \"orphan.swc\"\nunit = \"mm\"\n", "vessel.centre_line", "line 2: there is no point 7, its parent"),
    ("centre_line = \"short.swc\"\nunit = \"mm\"\n", "vessel.centre_line", "line 2: expected \"id type x y z radius parent\""),
    ("centre_line = \"twice.swc\"\nunit = \"mm\"\n", "vessel.centre_line", "line 2: there is another point 1"),
    ("centre_line = \"thin.swc\"\nunit = \"mm\"\n", "vessel.centre_line", "line 2: expected a radius above 0"),
    ("centre_line = \"nan.swc\"\nunit = \"mm\"\n", "vessel.centre_line", "line 2: expected"),
    ("centre_line = \"loop.csv\"\nunit = \"mm\"\nradius_m = 3e-3\n", "vessel.centre_line", "the vessel crosses itself"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"nowhere.stl\"\n", "vessel.lumen", "No such file"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"tube.3ds\"\n", "vessel.lumen", "ends with .vtp or .stl"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \".\"\n", "vessel.lumen", "ends with .vtp or .stl"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"good.vtp\"\n", "vessel.lumen", "the file has no triangles"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"cut.stl\"\n", "vessel.lumen", "announces 1920 triangles and has 1918 of them: it is cut off"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"short.stl\"\n", "vessel.lumen", "the STL has no triangles"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"none.stl\"\n", "vessel.lumen", "the STL has no triangles"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"nan.stl\"\n", "vessel.lumen", "not a finite number"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"word.stl\"\n", "vessel.lumen", "line 3: expected \"vertex\" and three numbers"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"facet.stl\"\n", "vessel.lumen", "ends within a facet"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"quad.stl\"\n", "vessel.lumen", "a facet of 4 corners, not 3"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nlumen = \"tube.stl\"\n", "vessel.lumen", "vessel.lumen_unit ="),
    ("points_m = [[0,0,0],[0.04,0,0]]\nlumen = \"tube.stl\"\nlumen_unit = \"m\"\n", "vessel.lumen", "the surface is a thousand times larger than the centre-line needs: in mm it fits, in m it does not"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nlumen = \"tube.stl\"\nlumen_unit = \"um\"\n", "vessel.lumen", "a thousand times smaller than the centre-line needs: in mm it fits"),
    ("points_m = [[0,0.1,0],[0.04,0.1,0]]\nlumen = \"tube.stl\"\nlumen_unit = \"mm\"\n", "vessel.lumen", "71 of 72 rays from it meet nothing"),
    ("points_m = [[0,0,0],[0.07,0,0]]\nlumen = \"tube.stl\"\nlumen_unit = \"mm\"\n", "vessel.lumen", "the line leaves the surface: 72 of 72 rays"),
    ("points_m = [[0,0,0],[0.04,0.006,0]]\nlumen = \"tube.stl\"\nlumen_unit = \"mm\"\n", "vessel.lumen", "the line leaves the surface"),
    ("points_m = [[0,2.85e-3,0],[0.04,2.85e-3,0]]\nlumen = \"tube.stl\"\nlumen_unit = \"mm\"\n", "vessel.lumen", "the line must run through the middle"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nlumen = \"hole.stl\"\nlumen_unit = \"mm\"\n", "vessel.lumen", "the surface has a hole"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nlumen = \"wall.stl\"\nlumen_unit = \"mm\"\n", "vessel.lumen", "it is closed there, or has a step"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nlumen = \"fold.stl\"\nlumen_unit = \"mm\"\n", "vessel.lumen", "not star-shaped"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nlumen = \"tube.stl\"\nlumen_unit = \"mm\"\nradius_m = 3e-3\n", "vessel.radius_m", "comes from vessel.lumen already"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nlumen = \"tube.stl\"\nlumen_unit = \"mm\"\nlumen_smoothing_m = -1\n", "vessel.lumen_smoothing_m", "a number from 0.0"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nradius_m = 3e-3\nlumen_unit = \"mm\"\n", "vessel.lumen_unit", "there is none: leave it out"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nlumen_radii_m = [[3e-3,3e-3,3e-3,3e-3],[3e-3,3e-3,3e-3]]\n", "vessel.lumen_radii_m", "rows of equally many numbers above 0"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nlumen_radii_m = [[3.0,3.0,3.0,3.0],[3.0,3.0,3.0,3.0]]\n", "vessel.lumen_radii_m", "is it in another unit"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nlumen_radii_m = [[3e-3,3e-3,-3e-3,3e-3],[3e-3,3e-3,3e-3,3e-3]]\n", "vessel.lumen_radii_m", "numbers above 0"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nlumen = \"tube.stl\"\nlumen_unit = \"cm\"\n", "vessel.lumen", "the surface is ten times larger than the centre-line needs: in mm it fits, in cm it does not"),
    ("points_m = [[0,0,0],[0.04,0,0]]\nlumen = \"crack.stl\"\nlumen_unit = \"mm\"\n", "vessel.lumen", "two parts of the surface do not meet"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"zip.stl\"\n", "vessel.lumen", "this is compressed by gzip"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"lfs.stl\"\n", "vessel.lumen", "a pointer of Git LFS"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"text.ply\"\n", "vessel.lumen", "no PLY that can be read"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"corner.ply\"\n", "vessel.lumen", "a polygon has the point 7, counted from 0, and there are 3"),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"text.vtk\"\n", "vessel.lumen", "which begins with \"# vtk DataFile\""),
    ("centre_line = \"line.csv\"\nunit = \"mm\"\nlumen = \"empty.obj\"\n", "vessel.lumen", "the file is empty"),
    ("centre_line = \"cm.csv\"\nunit = \"mm\"\n", "vessel.centre_line", "its header says cm, and mm was given"),
    ("centre_line = \"mixed.csv\"\nunit = \"mm\"\n", "vessel.centre_line", "in different units of length"),
    ("centre_line = \"inch.csv\"\nunit = \"mm\"\n", "vessel.centre_line", "line 1: \"ml/s\" is not a unit of length"),
    ("centre_line = \"two.csv\"\nunit = \"mm\"\n", "vessel.centre_line", "line 1: expected 3 or 4 numbers, found 2"),
    ("centre_line = \"five.csv\"\nunit = \"mm\"\n", "vessel.centre_line", "name the columns in a first line"),
    ("centre_line = \"seven.csv\"\nunit = \"mm\"\n", "vessel.centre_line", "is this a tree in SWC?"),
    ("centre_line = \"names.csv\"\nunit = \"mm\"\n", "vessel.centre_line", "line 1: expected the columns x,y,z or x,y,z,r"),
    ("centre_line = \"zero.csv\"\nunit = \"mm\"\n", "vessel.centre_line", "line 3: expected a radius above 0, found 0"),
    ("centre_line = \"jump.dat\"\nunit = \"mm\"\n", "vessel.centre_line", "line 5: here the points jump back to an earlier one"),
    ("centre_line = \"pairs.vtp\"\nunit = \"mm\"\n", "vessel.centre_line", "a tree with 2 ends: choose a branch by vessel.branch = \"End=2\" (3 points, 20.0000 long), \"End=3\""),
    ("centre_line = \"pairs.vtp\"\nunit = \"mm\"\nbranch = \"End=1\"\n", "vessel.centre_line", "there is no branch \"End=1\""),
    ("centre_line = \"scale.swc\"\nunit = \"mm\"\n", "vessel.centre_line", "line 1: expected SCALE and three numbers above 0"),
];

/// Files that are none, and good ones to go with them.
fn broken_files(folder: &Path) {
    let put = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
    put("line.csv", b"0,0,0\n20,0,0\n40,0,0\n");
    put(
        "good.vtp",
        vtp_of("0 0 0 20 0 0 40 5 0", "3 3 3").as_bytes(),
    );
    put(
        "metres.vtp",
        vtp_of("0 0 0 20 0 0 40 5 0", "3 3 3").as_bytes(),
    );
    put(
        "nan.vtp",
        vtp_of("0 0 0 nan 0 0 40 5 0", "3 3 3").as_bytes(),
    );
    put(
        "zero-radius.vtp",
        vtp_of("0 0 0 20 0 0 40 5 0", "3 3 0").as_bytes(),
    );
    put(
        "no-radius.vtp",
        vtp_of("0 0 0 20 0 0 40 5 0", "3 3 3")
            .replace("MaximumInscribedSphereRadius", "Width")
            .as_bytes(),
    );
    let vmtk = std::fs::read(given("appended-zlib-32.vtp")).unwrap();
    put("cut.vtp", &vmtk[..vmtk.len() - 3000]);
    let mut damaged = vmtk.clone();
    let at = damaged.iter().position(|byte| *byte == b'_').unwrap();
    let data = vmtk
        .windows(13)
        .position(|w| w == b"<AppendedData")
        .unwrap()
        .max(at);
    damaged[data + 100..]
        .iter_mut()
        .step_by(7)
        .for_each(|byte| *byte ^= 0x55);
    put("damaged.vtp", &damaged);
    put("text.vtp", b"x,y,z\n0,0,0\n");
    put("empty.vtp", b"");
    put("line.vtu", b"");
    put("tube.3ds", b"d");
    put(
        "cm.csv",
        b"x (cm),y (cm),z (cm),r (cm)\n0,0,0,0.3\n2,0,0,0.3\n4,0,0,0.3\n",
    );
    put(
        "mixed.csv",
        b"x (cm),y (cm),z (cm),r (mm)\n0,0,0,3\n2,0,0,3\n",
    );
    put("inch.csv", b"x (ml/s),y,z\n0,0,0\n2,0,0\n");
    put("two.csv", b"0,0\n2,0\n");
    put("five.csv", b"0,0,0,3,1\n20,0,0,3,1\n");
    put("seven.csv", b"1 1 0 0 0 3 -1\n2 1 20 0 0 3 1\n");
    put("names.csv", b"a,b,c\n0,0,0\n20,0,0\n");
    put("zero.csv", b"x,y,z,r\n0,0,0,3\n20,0,0,0\n");
    put(
        "jump.dat",
        b"X Y Z Radius\n0 0 0 3\n1 0 0 3\n40 0 0 3\n0 0 0 3\n1 0 0 3\n2 1 0 3\n",
    );
    put(
        "scale.swc",
        b"# SCALE 0 1 1\n1 2 0 0 0 3 -1\n2 2 10 0 0 3 1\n",
    );
    put("pairs.vtp", pairs_vtp("").as_bytes());
    put("zip.stl", b"\x1f\x8b\x08\x00");
    put(
        "lfs.stl",
        b"version https://git-lfs.github.com/spec/v1\noid sha256:7\nsize 9\n",
    );
    put("text.ply", b"solid x\n");
    put("corner.ply", b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n");
    put("text.vtk", b"solid x\n");
    put("empty.obj", b"");
    put("circle.swc", b"1 2 0 0 0 3 2\n2 2 10 0 0 3 1\n");
    put("orphan.swc", b"1 2 0 0 0 3 -1\n2 2 10 0 0 3 7\n");
    put("short.swc", b"1 2 0 0 0 3 -1\n2 2 10 0 0 3\n");
    put("twice.swc", b"1 2 0 0 0 3 -1\n1 2 10 0 0 3 1\n");
    put("thin.swc", b"1 2 0 0 0 3 -1\n2 2 10 0 0 -3 1\n");
    put("nan.swc", b"1 2 0 0 0 3 -1\n2 2 nan 0 0 3 1\n");
    let turn = |i: i32| {
        let t = TAU * 1.2 * f64::from(i) / 60.0;
        format!("{},{},{}\n", 20.0 * t.cos(), 20.0 * t.sin(), 0.2 * t)
    };
    put(
        "loop.csv",
        (0..=60).map(turn).collect::<String>().as_bytes(),
    );
    let tube = TubeSurface::straight(0.05, |_, _| 3e-3);
    let write =
        |name: &str, tube: &TubeSurface| tube.write_surface(&folder.join(name), 40, 24, false, 1e3);
    write("tube.stl", &tube);
    write("tube.vtp", &tube);
    let whole = std::fs::read(folder.join("tube.stl")).unwrap();
    put("cut.stl", &whole[..whole.len() - 77]);
    put("short.stl", &whole[..50]);
    let mut none = whole[..84].to_vec();
    none[80..].fill(0);
    put("none.stl", &none);
    let mut nan = whole.clone();
    nan[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    put("nan.stl", &nan);
    let facet = "facet normal 0 0 1\nouter loop\n";
    put(
        "word.stl",
        format!("solid\n{facet}vertex a b c\n")
            .replace("solid\n", "solid x\n")
            .replace("facet normal 0 0 1\n", "")
            .as_bytes(),
    );
    put(
        "facet.stl",
        format!("solid x\n{facet}vertex 0 0 0\nvertex 1 0 0\n").as_bytes(),
    );
    put(
        "quad.stl",
        format!(
            "solid x\n{facet}vertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\n"
        )
        .as_bytes(),
    );
    // Three triangles fewer in the middle, a wall across, and a fold that a ray leaves twice.
    let middle = 84 + 50 * (24 * 40 + 6);
    let mut hole = [&whole[..middle], &whole[middle + 150..]].concat();
    let count = u32::from_le_bytes(hole[80..84].try_into().unwrap()) - 3;
    hole[80..84].copy_from_slice(&count.to_le_bytes());
    put("hole.stl", &hole);
    // The triangles after the middle, moved by a hundredth of a millimetre.
    let mut crack = whole.clone();
    for corner in crack[84..]
        .chunks_exact_mut(50)
        .flat_map(|triangle| {
            triangle[12..48]
                .chunks_exact_mut(12)
                .map(|c| &mut c[..4])
                .collect::<Vec<_>>()
                .into_iter()
        })
        .skip(3 * 24 * 40)
    {
        let x = f32::from_le_bytes((&*corner).try_into().unwrap()) + 0.01;
        corner.copy_from_slice(&x.to_le_bytes());
    }
    put("crack.stl", &crack);
    let step = |s: f64, _: f64| if s < 0.02 { 3e-3 } else { 5e-3 };
    TubeSurface::straight(0.05, step).write_surface(&folder.join("wall.stl"), 400, 24, false, 1e3);
    let fold = |_: f64, phi: f64| {
        if (1.0..2.0).contains(&phi) {
            9e-3
        } else {
            3e-3
        }
    };
    write("fold.stl", &TubeSurface::straight(0.05, fold));
}

#[test]
fn every_mistake_in_a_file_is_one_clear_sentence() {
    let folder = tempfile::tempdir().unwrap();
    broken_files(folder.path());
    for (vessel, key, message) in MISTAKES {
        match try_load(folder.path(), vessel) {
            Ok(_) => panic!("accepted: {vessel}"),
            Err(text) => assert!(
                text.contains(&format!("`{key}`")) && text.contains(message),
                "{vessel}: {text}\nexpected {key}: {message}"
            ),
        }
    }
    assert!(MISTAKES.len() >= 70);
    let here: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .flatten()
        .filter(|e| e.path().is_dir())
        .collect();
    assert!(here.is_empty(), "{here:?}");
}
