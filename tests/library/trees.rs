//! Vessels that branch: what is read, and what is refused.

use crate::new_case::driver;
use fsi_driver::case::{Case, CaseErrors, Preset};
use fsi_driver::simulation::assembly::Domain;
use std::collections::BTreeSet;
use std::path::Path;

pub const TREE: &str = "extends = \"defaults\"\n[tree]\nlines = \"y.swc\"\nunit = \"mm\"\noutlets = [\"left\", \"right\"]\ncore = 2\n\
                    radial = 2\nlength = 0.8\n[[tree.opening]]\nname = \"inlet\"\ncondition = \"flow\"\nbase_m3_s = 1e-6\n\
                    [[tree.opening]]\nname = \"left\"\ncondition = \"resistance\"\nresistance_Pa_s_m3 = 1e9\n[[tree.opening]]\n\
                    name = \"right\"\ncondition = \"pressure\"\npressure_Pa = 0.0\n[wall.extrude]\nlayers = [\"wall\"]\n\
                    thicknesses = [0.2]\nfaces_per_element = 1\n[[wall.material]]\nname = \"wall\"\nmaterial = \"neo_hooke\"\n\
                    mu_Pa = 1e5\nkappa_Pa = 1e7\n[coupling]\nsurrogate = \"none\"\n";

/// A parent of 3 mm along x, 20 mm long, and two daughters of 2.4 mm at these angles (degrees), as SWC.
pub fn swc(angles: &[f64]) -> String {
    let mut text = String::from("# id type x y z radius parent\n");
    let mut row = |x: f64, y: f64, r: f64, parent: i64| {
        let id = text.lines().count() as i64;
        text += &format!("{id} 0 {x} {y} 0 {r} {parent}\n");
        id
    };
    let mut trunk = row(-20.0, 0.0, 3.0, -1);
    for i in 1..=20 {
        trunk = row(f64::from(i) - 20.0, 0.0, 3.0, trunk);
    }
    for angle in angles {
        let (sin, cos) = angle.to_radians().sin_cos();
        let mut parent = trunk;
        for i in 1..=16 {
            let s = f64::from(i);
            parent = row(s * cos, s * sin, 3.0 - 0.6 * (s / 3.0).min(1.0), parent);
        }
    }
    text
}

pub fn load(folder: &Path, text: &str, lines: &str) -> Result<Case, CaseErrors> {
    std::fs::write(folder.join("y.swc"), lines).unwrap();
    std::fs::write(folder.join("case.toml"), text).unwrap();
    Case::load(folder, Preset::Demo, &[]).map(|resolved| resolved.case)
}

/// The mesh from a file, and from the lines in the case of record, which need no file.
#[test]
fn the_case_of_record_has_the_same_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let case = load(folder.path(), TREE, &swc(&[-30.0, 30.0])).unwrap_or_else(|e| panic!("{e}"));
    let tree = case.tree().unwrap();
    assert_eq!(tree.names(), ["inlet", "left", "right"]);
    let domain = Domain::new(&case).unwrap();
    let patches: Vec<&str> = domain
        .fluid
        .patches
        .iter()
        .map(|patch| patch.name.as_str())
        .collect();
    assert_eq!(
        patches,
        [
            "inlet",
            "left",
            "right",
            "wallFsi_inlet",
            "wallFsi_left",
            "wallFsi_right"
        ]
    );
    // Cylinders of 20 and 16 mm, less what they share.
    let cylinders = std::f64::consts::PI * 1e-9 * (9.0 * 20.0 + 2.0 * 5.76 * 16.0);
    let share = domain.fluid.volume() / cylinders;
    assert!((0.97..1.03).contains(&share), "{share}");

    let other = tempfile::tempdir().unwrap();
    let lines: String = (tree.line.iter().flatten().zip(["left", "right"]))
        .map(|(line, name)| {
            format!(
                "[[tree.line]]\nname = \"{name}\"\npoints_m = {:?}\nradii_m = {:?}\n",
                line.points, line.radii
            )
        })
        .collect();
    let text = TREE.replace(
        "lines = \"y.swc\"\nunit = \"mm\"\noutlets = [\"left\", \"right\"]\n",
        "",
    ) + &lines;
    let same = load(other.path(), &text, "").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(Domain::new(&same).unwrap().fluid, domain.fluid);
}

/// What is replaced in the case, by what, the key to blame and a part of the reason.
#[rustfmt::skip]
const MISTAKES: &[(&str, &str, &str, &str)] = &[
    ("unit = \"mm\"\n", "", "tree.lines", "expected its unit of length next to it"),
    ("unit = \"mm\"", "unit = \"inch\"", "tree.unit", "\"um\""),
    ("lines = \"y.swc\"", "lines = \"z.swc\"", "tree.lines", "z.swc"),
    ("lines = \"y.swc\"", "lines = \"y.csv\"", "tree.lines", "ends with .vtp, .vtk or .swc"),
    ("outlets = [\"left\", \"right\"]", "outlets = [\"left\"]", "tree.outlets", "a name for each of the 2 ends, found 1"),
    ("outlets = [\"left\", \"right\"]", "outlets = [\"left\", \"left\"]", "tree.outlets", "two openings are called \"left\""),
    ("outlets = [\"left\", \"right\"]", "outlets = [\"left\", \"inlet\"]", "tree.outlets", "two openings are called \"inlet\""),
    ("outlets = [\"left\", \"right\"]", "outlets = [\"left\", \"to the right\"]", "tree.outlets", "letters, digits"),
    ("outlets = [\"left\", \"right\"]", "outlets = [\"left\", \"wallFsi\"]", "tree.outlets", "neither \"wallFsi\" nor"),
    ("core = 2", "core = 3", "tree.core", "an even number"),
    ("core = 2", "core = 0", "tree.core", "from 2 to 40"),
    ("length = 0.8", "length = 0.0", "tree.length", "above 0.0"),
    ("name = \"left\"", "name = \"middle\"", "tree.opening[1].name", "there is \"inlet\", \"left\", \"right\""),
    ("name = \"left\"", "name = \"right\"", "tree.opening[2].name", "said twice"),
    ("[[tree.opening]]\nname = \"right\"\ncondition = \"pressure\"\npressure_Pa = 0.0\n", "", "tree.lines", "what is prescribed at \"right\"?"),
    ("condition = \"resistance\"\nresistance_Pa_s_m3 = 1e9", "condition = \"resistance\"", "tree.opening[1].resistance_Pa_s_m3", "is missing"),
    ("condition = \"flow\"", "condition = \"flow_split\"\nfraction = 0.5", "tree.opening[0].base_m3_s", ""),
    ("base_m3_s = 1e-6", "flow_file = \"q.csv\"", "tree.opening[0].flow_file", "q.csv"),
    ("[tree]", "[fluid]\ncase = \"here\"\n[tree]", "tree.opening[0].name", "stands in the OpenFOAM case"),
    ("[tree]", "[fluid]\nsolver = \"external\"\ncommand = [\"sh\"]\n[tree]", "fluid.solver", "by the driver's own solver"),
    ("[tree]", "[tree.native]\ncore = 3\n[tree]", "tree.native.core", "an even number"),
    ("[tree]", "[tree.native]\ndegree = 2\n[tree]", "tree.native.degree", ""),
    ("[tree]", "[tree.native]\nlength = 0.0\n[tree]", "tree.native.length", ""),
    ("[tree]", "[tree.native]\ntime_scheme = \"euler\"\n[tree]", "tree.native.time_scheme", ""),
    ("[tree]", "[wall.initial]\npressure_Pa = 1e4\n[tree]", "wall.initial.pressure_Pa", "the blood is at rest under one pressure"),
    ("[tree]", "[wall.initial]\nshape = \"loaded\"\n[tree]", "wall.initial.pressure_Pa", "is missing"),
    ("[tree]", "[wall.initial]\npressure_Pa = 0.0\nshape = \"unloaded\"\n[tree]", "wall.initial.shape", "OpenFOAM's mesh is that of the given shape"),
    ("[tree]", "[wall.initial]\npressure_Pa = 0.0\naxial_stretch = 2.5\n[tree]", "wall.initial.axial_stretch", ""),
    ("[tree]", "[wall.initial]\npressure_Pa = 1e3\nshape = \"unloaded\"\naxial_stretch = 1.2\n[tree]", "wall.initial.axial_stretch", "in equilibrium in the loaded shape"),
    ("[tree]", "[wall.initial]\npressure_Pa = 2e6\n[tree]", "wall.initial.pressure_Pa", ""),
    ("surrogate = \"none\"", "surrogate = \"tube\"", "coupling.surrogate", "write \"potential\" or \"none\""),
    ("[tree]", "[[wall.extrude.branch]]\nname = \"middle\"\n[tree]", "wall.extrude.branch[0].name", "it has \"inlet\", \"left\", \"right\""),
    ("[tree]", "[[wall.extrude.branch]]\nname = \"left\"\n[[wall.extrude.branch]]\nname = \"left\"\n[tree]", "wall.extrude.branch[1].name", "another table has this name"),
    ("[tree]", "[[wall.extrude.branch]]\nname = \"left\"\nlayers = [\"media\"]\n[tree]", "wall.extrude.branch[0].layers", "there is \"wall\""),
    ("[tree]", "[[wall.extrude.branch]]\nname = \"left\"\nlayers = [\"wall\", \"wall\"]\n[tree]", "wall.extrude.branch[0].layers", "as many layers as the wall, 1"),
    ("[tree]", "[[wall.extrude.branch]]\nname = \"left\"\nthicknesses = [0.1]\nthicknesses_m = [1e-3]\n[tree]", "wall.extrude.branch[0].thicknesses_m", "leave out one of the two"),
    ("[tree]", "[[fluid.region]]\nname = \"a\"\nbranch = \"top\"\n[tree]", "fluid.region[0].branch", "one of \"inlet\", \"left\", \"right\""),
    ("[tree]", "[[fluid.region]]\nname = \"left\"\nbranch = \"left\"\n[tree]", "fluid.region[0].name", "is a region already"),
    ("[tree]", "[[fluid.region]]\nname = \"a\"\nbranch = \"left\"\nfrom_m = 0.01\nto_m = 0.01\n[tree]", "fluid.region[0].to_m", "more than from_m, 0.01"),
    ("[tree]", "[[fluid.region]]\nname = \"a\"\npatch = \"wallFsi_left\"\nto_m = 0.01\n[tree]", "fluid.region[0].to_m", "write branch as well"),
    ("[tree]", "[[output.section]]\nname = \"a\"\nat_m = 0.01\n[tree]", "output.section[0].at_m", "on which branch?"),
    ("[tree]", "[[output.section]]\nname = \"a\"\nbranch = \"between\"\nat_m = 0.01\n[tree]", "output.section[0].branch", "a branch with an opening"),
    ("thicknesses = [0.2]", "", "wall.extrude.layers", "how thick are they?"),
    ("layers = [\"wall\"]", "layers = [\"media\"]", "wall.extrude.layers", "there is \"wall\""),
    ("[tree]", "[vessel]\nradius_m = 3e-3\n[tree]", "", "no such key"),
    ("[tree]", "[[tree.line]]\npoints_m = [[0.0, 0.0, 0.0]]\nradii_m = [1e-3]\n[tree]", "tree.line", "leave out one of the two"),
    ("unit = \"mm\"", "unit = \"m\"", "tree.lines", "a radius of 3e0 m: vessels have 1e-5 to 0.05 m; are the lengths in m?"),
    ("unit = \"mm\"", "unit = \"um\"", "tree.lines", "are the lengths in um?"),
    ("unit = \"mm\"", "unit = \"mm\"\nlumen = \"none.stl\"", "tree.lumen", "none.stl: No such file"),
    ("unit = \"mm\"", "unit = \"mm\"\nlumen = \"y.swc\"", "tree.lumen", "ends with .vtp or .stl"),
    ("unit = \"mm\"", "unit = \"mm\"\nlumen_unit = \"cm\"", "tree.lumen_unit", "there is no tree.lumen"),
    ("unit = \"mm\"", "unit = \"mm\"\nlumen_smoothing_m = 1e-3", "tree.lumen_smoothing_m", "there is no tree.lumen"),
    ("unit = \"mm\"", "unit = \"mm\"\nlumen_smoothing_m = -1e-3", "tree.lumen_smoothing_m", "from 0.0 to 1.0"),
    ("unit = \"mm\"", "unit = \"mm\"\nlumen_points_m = [[0,0,0],[1,0,0],[0,1,0]]\nlumen_triangles = [[0, 1, 3]]", "tree.lumen_triangles", "the point 3, counted from 0, and there are 3"),
    ("unit = \"mm\"", "unit = \"mm\"\nlumen_points_m = [[0,0,0],[1,0,0],[0,1,0]]\nlumen_triangles = [[0, 1, -2]]", "tree.lumen_triangles", "three whole numbers from 0"),
    ("unit = \"mm\"", "unit = \"mm\"\nlumen_points_m = [[0,0,0],[1,0,0],[0,1,0]]\nlumen_triangles = [[0, 1]]", "tree.lumen_triangles", "three whole numbers from 0"),
    ("unit = \"mm\"", "unit = \"mm\"\nsmoothing_m = 0.5", "tree.smoothing_m", "expected at most 3.6e-2, the length of the longest line"),
    ("[tree]", "[[wall.support]]\nsupport = \"clamped\"\nsurfaces = [\"left\", \"left\"]\n[tree]", "wall.support[0].surfaces", "\"left\" is listed twice"),
    ("[tree]", "[[wall.support]]\nsupport = \"clamped\"\nsurfaces = [\"left\"]\n[[wall.support]]\nsupport = \"sliding\"\nheld = [\"x\"]\nsurfaces = [\"left\"]\n[tree]", "wall.support[1].surfaces", "wall.support[0] holds \"left\" already, and what is clamped does not move"),
    ("[tree]", "[[wall.support]]\nsupport = \"springs\"\nspring_Pa_m = 1e6\nsurfaces = [\"outer\"]\n[[wall.support]]\nsupport = \"springs\"\nspring_Pa_m = 1e6\nsurfaces = [\"outer\"]\n[tree]", "wall.support[1].surfaces", "springs of both add up"),
    ("[tree]", "[[output.probe]]\npoint_m = [0, 0, 0]\n[tree]", "output.probe[0].point_m", "did you mean `output.probes_m` or `output.fluid_probes_m`?"),
    ("radial = 2", "radial = 0", "tree.radial", "from 1 to 100"),
    ("radial = 2", "radial = 2\nwall_grading = 0.0", "tree.wall_grading", "from 0.1"),
    ("[[tree.opening]]\nname = \"left\"", "[[tree.opening]]", "tree.opening[1].name", "is missing"),
    ("name = \"left\"\ncondition = \"resistance\"\nresistance_Pa_s_m3 = 1e9", "name = \"left\"\ncondition = \"flow_split\"\nfraction = 1.5", "tree.opening[1].fraction", "from 0.0 to 1.0"),
    ("condition = \"resistance\"\nresistance_Pa_s_m3 = 1e9", "condition = \"resistance\"\nresistance_Pa_s_m3 = -1e9", "tree.opening[1].resistance_Pa_s_m3", "above 0.0"),
    ("condition = \"resistance\"\nresistance_Pa_s_m3 = 1e9", "condition = \"windkessel\"\nresistance_Pa_s_m3 = 1e9", "tree.opening[1].compliance_m3_Pa", "is missing"),
    ("condition = \"resistance\"", "condition = \"rcr\"", "tree.opening[1].condition", "\"windkessel\""),
    ("condition = \"resistance\"\nresistance_Pa_s_m3 = 1e9\n[[tree.opening]]\nname = \"right\"\ncondition = \"pressure\"\npressure_Pa = 0.0", "condition = \"flow_split\"\nfraction = 0.7\n[[tree.opening]]\nname = \"right\"\ncondition = \"flow_split\"\nfraction = 0.5", "tree.opening[1].fraction", "add up to 1.2"),
    ("inlet\"\ncondition = \"flow\"\nbase_m3_s = 1e-6", "inlet\"\ncondition = \"flow\"", "tree.opening[0].condition", "needs the flow"),
    ("outlets = [\"left\", \"right\"]", "outlets = [\"left\", \"right\", \"up\"]", "tree.outlets", "each of the 2 ends, found 3"),
    ("outlets = [\"left\", \"right\"]", "outlets = [\"left\", \"between\"]", "tree.outlets", "nor \"between\""),
    ("faces_per_element = 1", "faces_per_element = 0", "wall.extrude.faces_per_element", "from 1 to 8"),
    ("thicknesses = [0.2]", "thicknesses = [0.2, 0.1]", "wall.extrude", ""),
    ("[tree]", "[tree]\nlumen_colour = 1", "tree.lumen_colour", "unknown key"),
];

/// That `check`, a run and `preview` of the case in this folder end with exit code 2 and this reason, and write
/// nothing.
fn is_refused_by_all(folder: &Path, reason: &str, fluid: &[&str]) {
    let names = || {
        let all = std::fs::read_dir(folder).unwrap();
        all.map(|entry| entry.unwrap().file_name())
            .collect::<BTreeSet<_>>()
    };
    let before = names();
    for arguments in [
        [&["check", "."], fluid].concat(),
        [&["--case", ".", "--out", "run"], fluid].concat(),
        vec!["preview", ".", "--out", "pictures"],
    ] {
        let output = driver(folder, &arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(
            said.contains(reason),
            "{arguments:?}: {said}\nexpected {reason}"
        );
        assert_eq!(names(), before, "{arguments:?}");
    }
}

#[test]
fn mistakes_in_a_tree_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let lines = swc(&[-30.0, 30.0]);
    for (old, new, key, reason) in MISTAKES {
        assert!(TREE.contains(old), "{old}");
        let Err(errors) = load(folder.path(), &TREE.replacen(old, new, 1), &lines) else {
            panic!("accepted: {new}");
        };
        let text = errors.to_string();
        assert!(
            text.contains(key) && text.contains(reason),
            "{new}: {text}\nexpected {key}: {reason}"
        );
        is_refused_by_all(folder.path(), reason, &[]);
    }
    // One cause, one mistake.
    let misnamed = TREE.replacen("name = \"left\"", "name = \"middle\"", 1);
    let errors = load(folder.path(), &misnamed, &lines).unwrap_err();
    assert_eq!(errors.0.len(), 1, "{errors}");
    let far = "[[tree.line]]\npoints_m = [[-0.02, 0, 0], [0, 0, 0], [0.01, 1e300, 0]]\nradii_m = [3e-3, 3e-3, 2e-3]\n\
               [[tree.line]]\npoints_m = [[-0.02, 0, 0], [0, 0, 0], [0.01, -0.01, 0]]\nradii_m = [3e-3, 3e-3, 2e-3]\n";
    let text = TREE.replace("lines = \"y.swc\"\nunit = \"mm\"\n", "") + far;
    let errors = load(folder.path(), &text, "").unwrap_err().to_string();
    assert!(
        errors.contains("a coordinate is 1e300 m: expected at most 100 m"),
        "{errors}"
    );
}

/// Lines that cannot be read, or be meshed, with a part of the reason.
#[test]
fn lines_that_make_no_tree_are_reported() {
    let one = swc(&[20.0]);
    let inside = swc(&[-1.0, 1.0]);
    let crossed = swc(&[-30.0, 30.0]).replace("2 0 -19 0 0 3 1", "2 0 -19 0 0 0 1");
    let apart = swc(&[-30.0, 30.0]) + "99 0 0 90 0 2 -1\n100 0 9 90 0 2 99\n";
    let negative = swc(&[-30.0, 30.0]).replace("2 0 -19 0 0 3 1", "2 0 -19 0 0 -3 1");
    let twice = swc(&[-30.0, 30.0, 30.0]);
    let beside = swc(&[-30.0, 30.0]) + "98 0 0 90 0 2 99\n99 0 9 90 0 2 98\n";
    let bulge = swc(&[-30.0, 30.0]).replace("11 0 -10 0 0 3 10", "11 0 -10 0 0 30 10");
    let far = swc(&[-30.0, 30.0]).replace("11 0 -10 0 0 3 10", "11 0 -10 1e300 0 3 10");
    let folder = tempfile::tempdir().unwrap();
    for (lines, reason) in [
        ("", "found 0"),
        (
            one.as_str(),
            "found 1; a vessel of one is a table [vessel], which fsi-driver new writes from the same file",
        ),
        (&crossed, "expected one above 0"),
        ("1 0 0 0 0 x 1\n", "found \"1 0 0 0 0 x 1\""),
        (
            "1 0 0 0 0 nan -1\n2 0 1 0 0 1 1\n",
            "found \"1 0 0 0 0 nan -1\"",
        ),
        (
            "1 0 0 0 0 1 2\n2 0 1 0 0 1 1\n3 0 2 0 0 1 2\n",
            "its own ancestor",
        ),
        (&beside, "line 55: this point is its own ancestor"),
        (
            &bulge,
            "at (-1.0000e-2, 0.0000e0, 0.0000e0) m the line to \"left\" has a radius of 3.000e-2 m",
        ),
        (
            &far,
            "a point lies at (-10.0, 1e300, 0.0): expected coordinates of less than 1e8",
        ),
        ("1 0 0 0 0 1 -1\n2 0 1 0 0 1 7\n", "there is no point 7"),
        ("1 0 0 0 0 1 -1\n1 0 1 0 0 1 1\n", "another point 1"),
        ("1 0 0 0 0 3 -1\n", "found 0"),
        (&negative, "expected one above 0"),
        (&twice, "end at the same place"),
        (
            &apart,
            "line 3 of 3 begins at (0, 90, 0), on none of the others",
        ),
    ] {
        let Err(errors) = load(folder.path(), TREE, lines) else {
            panic!("accepted: {lines}");
        };
        assert!(
            errors.to_string().contains(reason),
            "{errors}\nexpected {reason}"
        );
        is_refused_by_all(folder.path(), reason, &[]);
    }
    let open = TREE.replace("outlets = [\"left\", \"right\"]\n", "inlet = \"inlet\"\n");
    let text = open
        .replace("\"left\"", "\"outlet1\"")
        .replace("\"right\"", "\"outlet2\"");
    let case = load(folder.path(), &text, &inside).unwrap_or_else(|e| panic!("{e}"));
    let error = Domain::new(&case).map(|_| ()).unwrap_err();
    assert_eq!(error.key, "tree.lines");
    assert!(
        error.reason.contains("stays within the lumen around"),
        "{}",
        error.reason
    );
    is_refused_by_all(
        folder.path(),
        "stays within the lumen around",
        &["--fluid", "native"],
    );
}
