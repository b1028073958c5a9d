//! Vessels that branch, whose centre-lines are a table for each branch.

use crate::new_case::{driver, succeeds};
use fsi_driver::Vec3;
use fsi_driver::case::{Case, CaseErrors, Preset, TreeKeys};
use fsi_driver::geometry::tree::Tree;
use fsi_driver::simulation::assembly::Domain;
use std::path::Path;

const EXAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/trees/y");
const BRANCHES: [&str; 3] = ["trunk", "left", "right"];
/// The lines of the example's case.
const LINES: &str = "[[tree.line]]\nname = \"trunk\"\nfile = \"trunk.csv\"\n\n[[tree.line]]\nname = \"left\"\nfile = \"left.csv\"\nfrom = \"trunk\"                  # begins on it, at the place nearest to its first point\n\n[[tree.line]]\nname = \"right\"\nfile = \"right.csv\"\nfrom = \"trunk\"\n";

/// The case of the example, and its tables, in a folder of their own.
fn copied() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    for name in BRANCHES {
        let file = format!("{name}.csv");
        std::fs::copy(Path::new(EXAMPLE).join(&file), folder.path().join(file)).unwrap();
    }
    let text = std::fs::read_to_string(Path::new(EXAMPLE).join("case.toml")).unwrap();
    assert!(
        text.contains(LINES),
        "the lines of the example have changed"
    );
    (folder, text)
}

fn load(folder: &Path, text: &str) -> Result<Case, CaseErrors> {
    std::fs::write(folder.join("case.toml"), text).unwrap();
    Case::load(folder, Preset::Demo, &[]).map(|resolved| resolved.case)
}

fn loaded(folder: &Path, text: &str) -> Case {
    load(folder, text).unwrap_or_else(|errors| panic!("{errors}\n{text}"))
}

/// Points (m) and radii (m) of a table in millimetres.
fn table(name: &str) -> (Vec<[f64; 3]>, Vec<f64>) {
    let mut rows = csv::Reader::from_path(format!("{EXAMPLE}/{name}.csv")).unwrap();
    let rows = rows.deserialize().map(|row| {
        let [x, y, z, r]: [f64; 4] = row.unwrap();
        ([x * 1e-3, y * 1e-3, z * 1e-3], r * 1e-3)
    });
    rows.unzip()
}

/// A Y of tables has the very mesh of the Y of points in the case, whether branches or whole lines are given, the
/// parent is named or the nearest, the root comes first or last, and the unit stands in the header too.
#[test]
fn a_tree_of_tables_has_the_mesh_of_one_of_points() {
    let (folder, text) = copied();
    let folder = folder.path();
    let of_tables = loaded(folder, &text);
    assert_eq!(
        of_tables.tree().unwrap().names(),
        ["inlet", "left", "right"]
    );
    let domain = Domain::new(&of_tables).unwrap().fluid;

    let [trunk, left, right] = BRANCHES.map(table);
    let line = |name: &str, parts: &[&(Vec<[f64; 3]>, Vec<f64>)]| {
        let points: Vec<_> = parts.iter().flat_map(|part| part.0.clone()).collect();
        let radii: Vec<_> = parts.iter().flat_map(|part| part.1.clone()).collect();
        format!("[[tree.line]]\nname = \"{name}\"\npoints_m = {points:?}\nradii_m = {radii:?}\n")
    };
    let branches = line("trunk", &[&trunk]) + &line("left", &[&left]) + &line("right", &[&right]);
    let rest =
        |(points, radii): &(Vec<[f64; 3]>, Vec<f64>)| (points[1..].to_vec(), radii[1..].to_vec());
    let whole = line("left", &[&trunk, &rest(&left)]) + &line("right", &[&trunk, &rest(&right)]);
    let nearest = LINES.replace("from = \"trunk\"", "");
    let (first, others) = LINES.split_at(LINES.find("\n\n").unwrap() + 2);
    let last = format!("{others}\n{first}");
    for lines in [&branches, &whole, &nearest, &last] {
        let same = loaded(folder, &text.replace(LINES, lines));
        assert_eq!(
            same.tree().unwrap().line,
            of_tables.tree().unwrap().line,
            "{lines}"
        );
        assert!(Domain::new(&same).unwrap().fluid == domain, "{lines}");
    }
    let rows = std::fs::read_to_string(folder.join("left.csv")).unwrap();
    std::fs::write(
        folder.join("left.csv"),
        rows.replace("x,y,z,r", "x [mm],y [mm],z [mm],r [mm]"),
    )
    .unwrap();
    assert!(Domain::new(&loaded(folder, &text)).unwrap().fluid == domain);
}

/// The smallest scaled Jacobian of the cells.
fn worst(tree: &TreeKeys) -> f64 {
    Tree::meshes(tree).unwrap_or_else(|e| panic!("{e}")).worst.0
}

/// A trunk of two points that goes on as an outlet, and a side branch that begins between them, on the wall's side of
/// its line. The mesh is as good as that of a trunk with many points (0.34).
#[test]
fn a_branch_may_begin_between_two_points() {
    let (folder, text) = copied();
    let folder = folder.path();
    std::fs::write(folder.join("trunk.csv"), "x,y,z,r\n-18,0,0,3\n18,0,0,3\n").unwrap();
    let rows: String = (0..16)
        .map(|i| format!("1,{},0,2\n", f64::from(i) + 1.0))
        .collect();
    std::fs::write(folder.join("left.csv"), format!("x,y,z,r\n{rows}")).unwrap();
    let (lines, _) = LINES.rsplit_once("[[tree.line]]").unwrap();
    let case = loaded(
        folder,
        &text.replace(LINES, lines).replace("\"right\"", "\"trunk\""),
    );
    let tree = case.tree().unwrap();
    assert_eq!(tree.names(), ["inlet", "trunk", "left"]);
    let left = &tree.line.as_ref().unwrap()[1];
    // A quarter of a radius upstream of its place, then that, then its own points.
    for (i, x, y) in [
        (0, -0.018, 0.0),
        (1, 0.00025, 0.0),
        (2, 0.001, 0.0),
        (3, 0.001, 0.002),
    ] {
        let off = Vec3::from(left.points[i]) - Vec3::new(x, y, 0.0);
        assert!(off.norm() < 1e-12, "{i}: {off}");
    }
    let many: String = (-18..=18).map(|x| format!("{x},0,0,3\n")).collect();
    std::fs::write(folder.join("trunk.csv"), format!("x,y,z,r\n{many}")).unwrap();
    let fine = worst(
        loaded(
            folder,
            &std::fs::read_to_string(folder.join("case.toml")).unwrap(),
        )
        .tree()
        .unwrap(),
    );
    let found = worst(tree);
    assert!(found > 0.95 * fine && fine > 0.33, "{found} {fine}");
}

/// What is replaced in the case, by what, the key to blame and a part of the reason.
#[rustfmt::skip]
const MISTAKES: &[(&str, &str, &str, &str)] = &[
    ("unit = \"mm\"                     # of the files\n", "", "`tree.line[0].file`", "expected its unit of length next to it: tree.unit"),
    ("unit = \"mm\"", "unit = \"m\"", "`tree.line[0].file`", "a radius of 3e0 m: vessels have 1e-5 to 0.05 m; are the lengths in m?"),
    ("\"left.csv\"", "\"none.csv\"", "`tree.line[1].file`", "none.csv: No such file"),
    ("\"left.csv\"", "\"left.vtp\"", "`tree.line[1].file`", "are for tree.lines"),
    ("\"left.csv\"", "\"no-radius.csv\"", "`tree.line[1].file`", "no-radius.csv: expected the columns x,y,z,r with the radius, found 2 rows"),
    ("\"left.csv\"", "\"no-z.csv\"", "`tree.line[1].file`", "no-z.csv: line 1: expected the columns x,y,z or x,y,z,r"),
    ("\"left.csv\"", "\"in-cm.csv\"", "`tree.line[1].file`", "its header says cm, and mm was given (tree.unit)"),
    ("\"left.csv\"", "\"one-point.csv\"", "`tree.line[1].file`", "one-point.csv: expected two points at least, found 1"),
    ("\"left.csv\"", "\"nan.csv\"", "`tree.line[1].file`", "nan.csv: line 3: expected a radius above 0, found -1"),
    ("\"left.csv\"", "\"far.csv\"", "`tree.line[1].from`", "far.csv: line \"left\" begins at (0.004, 0.009, 0) m, 9.849 mm from line \"trunk\", whose radius there is 3.000 mm"),
    ("file = \"right.csv\"\nfrom = \"trunk\"", "file = \"far.csv\"", "`tree.line[2].file`", "far.csv: line \"right\" begins at (0.004, 0.009, 0) m, 5.078 mm from line \"left\""),
    ("from = \"trunk\"", "from = \"aorta\"", "`tree.line[1].from`", "no line is called \"aorta\"; there is \"trunk\", \"left\", \"right\""),
    ("from = \"trunk\"", "from = \"left\"", "`tree.line[1].from`", "line \"left\" on \"left\": lines that begin on each other"),
    ("name = \"trunk\"\n", "name = \"trunk\"\nfrom = \"left\"\n", "`tree.line[0].from`", "line \"trunk\" on \"left\" on \"trunk\": lines that begin on each other in a circle have no inlet"),
    ("name = \"right\"\nfile", "name = \"trunk\"\nfile", "`tree.line[1].from`", "two lines are called \"trunk\""),
    ("file = \"left.csv\"\n", "", "`tree.line[1].from`", "expected a file, or two points at least and a radius for each, found 0 points and 0 radii"),
    ("file = \"left.csv\"\n", "file = \"left.csv\"\nradii_m = [1e-3, 1e-3]\n", "`tree.line[1].file`", "has points_m or radii_m as well"),
    ("[[tree.line]]\nname = \"right\"\nfile = \"right.csv\"\nfrom = \"trunk\"\n", "", "`tree.line[0].file`", "expected the centre-lines of two branches at least, found 1"),
    (LINES, "", "`tree.core`", "expected its centre-lines next to it: tree.lines, or tables [[tree.line]]"),
    ("unit = \"mm\"", "unit = \"mm\"\nlines = \"left.csv\"", "`tree.lines`", "leave out one of the two"),
    ("unit = \"mm\"", "unit = \"mm\"\noutlets = [\"a\"]", "`tree.outlets`", "a name for each of the 2 ends, found 1"),
    ("name = \"left\"\ncondition", "name = \"trunk\"\ncondition", "`tree.opening[1].name`", "there is \"inlet\", \"left\", \"right\""),
];

#[test]
fn mistakes_in_tables_of_branches_are_reported() {
    let (folder, text) = copied();
    let here = folder.path();
    for (name, rows) in [
        ("no-radius", "x,y,z\n0,0,0\n9,9,0\n"),
        ("no-z", "x,y,r\n0,0,1\n9,9,1\n"),
        (
            "in-cm",
            "x [cm],y [cm],z [cm],r [cm]\n0,0,0,0.2\n1,1,0,0.2\n",
        ),
        ("one-point", "x,y,z,r\n0,0,0,3\n"),
        ("nan", "x,y,z,r\n0,0,0,3\n9,9,0,-1\n"),
        ("far", "x,y,z,r\n4,9,0,2\n9,19,0,2\n"),
    ] {
        std::fs::write(here.join(format!("{name}.csv")), rows).unwrap();
    }
    for (old, new, key, reason) in MISTAKES {
        assert!(text.contains(old), "{old}");
        let Err(errors) = load(here, &text.replacen(old, new, 1)) else {
            panic!("accepted: {new}");
        };
        let said = errors.to_string();
        assert!(
            said.contains(key) && said.contains(reason),
            "{new}: {said}\nexpected {key}: {reason}"
        );
    }
    // Of several files all that is wrong is said, and nothing is left behind.
    let two = text
        .replace("left.csv", "none.csv")
        .replace("right.csv", "no-z.csv");
    std::fs::write(here.join("case.toml"), two).unwrap();
    let output = driver(here, &["--case", ".", "--out", "run"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("none.csv: No such file") && said.contains("no-z.csv: line 1:"),
        "{said}"
    );
    assert!(!here.join("run").exists());
}

/// `new` takes a table for each branch; the branches are called as their files.
#[test]
fn tables_of_branches_become_a_case() {
    let (folder, _) = copied();
    let here = folder.path();
    let of_three = |name: &'static str, more: &[&'static str]| {
        let files = [
            "new",
            name,
            "--from",
            "trunk.csv",
            "--from",
            "left.csv",
            "--from",
            "right.csv",
        ];
        [&files, more].concat()
    };
    let said = succeeds(here, &of_three("y", &["--unit", "mm"]));
    assert!(said.contains("a tree with 2 ends\n"), "{said}");
    assert!(
        said.contains("split     left 50.0 %, right 50.0 %"),
        "{said}"
    );
    let case = Case::load(&here.join("y"), Preset::Demo, &[]).unwrap();
    assert_eq!(case.tree().unwrap().names(), ["inlet", "left", "right"]);
    succeeds(
        here,
        &of_three(
            "z",
            &["--unit", "mm", "--names", "in,a,b", "--split", "75,25"],
        ),
    );
    let case = Case::load(&here.join("z"), Preset::Demo, &[]).unwrap();
    assert_eq!(case.tree().unwrap().names(), ["in", "a", "b"]);

    std::fs::create_dir(here.join("other")).unwrap();
    std::fs::copy(here.join("left.csv"), here.join("other/left.csv")).unwrap();
    std::fs::write(here.join("far.csv"), "x,y,z,r\n4,9,0,2\n9,19,0,2\n").unwrap();
    let two = [
        "new",
        "c",
        "--from",
        "trunk.csv",
        "--from",
        "left.csv",
        "--unit",
        "mm",
    ];
    for (arguments, reason) in [
        (of_three("c", &[]), "--from needs the unit of its lengths"),
        (
            of_three("c", &["--unit", "m"]),
            "--unit m: with it the centre-line is",
        ),
        (
            of_three("c", &["--unit", "mm", "--branch", "left"]),
            "--branch is for a single vessel",
        ),
        (
            of_three("c", &["--unit", "mm", "--from", "other/left.csv"]),
            "two files are called left.csv",
        ),
        (
            of_three("c", &["--unit", "mm", "--from", "far.csv"]),
            "--from far.csv: line \"far\" begins at (0.004, 0.009, 0) m",
        ),
        (
            of_three("c", &["--unit", "mm", "--from", "none.csv"]),
            "--from none.csv: No such file",
        ),
        (two.to_vec(), "--from: a tree has two ends at least"),
    ] {
        let output = driver(here, &arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(reason), "{said}\nexpected {reason}");
        assert!(!here.join("c").exists());
    }
}
