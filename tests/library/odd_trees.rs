//! Lines of trees as others write them: what is understood, and the sentence where they make no mesh.

use crate::new_case::succeeds;
use crate::trees::{TREE, load, swc};
use fsi_driver::case::{Case, CaseErrors};
use fsi_driver::geometry::tree::Tree;
use std::path::Path;

/// The case for lines in this file, with these ends, and what else `[tree]` has.
fn read(
    folder: &Path,
    file: &str,
    text: &str,
    ends: &[&str],
    more: &str,
) -> Result<Case, CaseErrors> {
    std::fs::write(folder.join(file), text).unwrap();
    let begin = TREE.find("[[tree.opening]]\nname = \"left\"").unwrap();
    let rest = TREE.find("[wall.extrude]").unwrap();
    let end = |name: &&str| {
        format!(
            "[[tree.opening]]\nname = \"{name}\"\ncondition = \"resistance\"\nresistance_Pa_s_m3 = 1e9\n"
        )
    };
    let ends: String = ends.iter().map(end).collect();
    let head = TREE[..begin]
        .replace("y.swc", file)
        .replace("outlets = [\"left\", \"right\"]\n", more);
    load(folder, &format!("{head}{ends}{}", &TREE[rest..]), "")
}

/// The smallest scaled Jacobian of the cells, and the names of the walls' patches; or what is wrong.
fn mesh(case: &Case) -> Result<(f64, Vec<String>), String> {
    let meshes = Tree::meshes(case.tree().unwrap()).map_err(|e| e.to_string())?;
    let walls = meshes
        .surface
        .patches
        .iter()
        .map(|patch| patch.name.clone());
    let walls = walls.filter(|name| name.starts_with("wallFsi"));
    Ok((meshes.worst.0, walls.collect()))
}

fn points(case: &Case) -> Vec<Vec<[f64; 3]>> {
    let lines = case.tree().unwrap().line.iter().flatten();
    lines.map(|line| line.points.clone()).collect()
}

/// Lines in VTK's old format with an array of the points.
fn vtk(lines: &[Vec<[f64; 4]>], array: &str, factor: f64) -> String {
    let all: Vec<&[f64; 4]> = lines.iter().flatten().collect();
    let mut text = format!(
        "# vtk DataFile Version 3.0\nlines\nASCII\nDATASET POLYDATA\nPOINTS {} float\n",
        all.len()
    );
    for [x, y, z, _] in &all {
        text += &format!("{x} {y} {z}\n");
    }
    text += &format!("LINES {} {}\n", lines.len(), lines.len() + all.len());
    let mut from = 0;
    for line in lines {
        text += &line.len().to_string();
        for i in from..from + line.len() {
            text += &format!(" {i}");
        }
        from += line.len();
        text += "\n";
    }
    text += &format!(
        "POINT_DATA {}\nSCALARS {array} double\nLOOKUP_TABLE default\n",
        all.len()
    );
    for [.., r] in &all {
        text += &format!("{}\n", r * factor);
    }
    text
}

/// A parent of 3 mm and daughters of 2 mm at these angles (degrees), as lines from the inlet to each end, mm.
fn lines(angles: &[f64]) -> Vec<Vec<[f64; 4]>> {
    let line = |angle: &f64| {
        let (sin, cos) = angle.to_radians().sin_cos();
        let parent = (-20..=0).map(|i| [f64::from(i), 0.0, 0.0, 3.0]);
        let daughter = (1..=16)
            .map(f64::from)
            .map(|s| [s * cos, s * sin, 0.0, 3.0 - (s / 3.0).min(1.0)]);
        parent.chain(daughter).collect()
    };
    angles.iter().map(line).collect()
}

const ENDS: [&str; 4] = ["outlet1", "outlet2", "outlet3", "outlet4"];

#[test]
fn radii_have_many_names() {
    let folder = tempfile::tempdir().unwrap();
    let lines = lines(&[-40.0, 40.0]);
    let mut all = Vec::new();
    for (array, factor) in [
        ("MaximumInscribedSphereRadius", 1.0),
        ("radiiScalars", 1.0),
        ("VesselRadius_mm", 1.0),
        ("Diameter", 2.0),
    ] {
        let case = read(
            folder.path(),
            "l.vtk",
            &vtk(&lines, array, factor),
            &ENDS[..2],
            "",
        );
        all.push(
            case.unwrap_or_else(|e| panic!("{array}: {e}"))
                .tree()
                .unwrap()
                .line
                .clone(),
        );
    }
    assert!(all.windows(2).all(|pair| pair[0] == pair[1]));
    let Err(errors) = read(
        folder.path(),
        "l.vtk",
        &vtk(&lines, "scalars", 1.0),
        &ENDS[..2],
        "",
    ) else {
        panic!("accepted");
    };
    let text = errors.to_string();
    assert!(
        text.contains("whose name has \"radius\" or \"diameter\" in it, found scalars"),
        "{text}"
    );
}

/// From the outlets to the inlet, as they are if the outlets were taken for the sources; and ids of SWC in any order.
#[test]
fn the_order_of_points_does_not_matter() {
    let folder = tempfile::tempdir().unwrap();
    let whole = lines(&[-40.0, 40.0]);
    let turned: Vec<Vec<[f64; 4]>> = whole
        .iter()
        .map(|line| line.iter().rev().copied().collect())
        .collect();
    let [one, other] = [&whole, &turned].map(|lines| {
        let case = read(
            folder.path(),
            "l.vtk",
            &vtk(lines, "Radius", 1.0),
            &ENDS[..2],
            "",
        );
        points(&case.unwrap_or_else(|e| panic!("{e}")))
    });
    assert_eq!(one, other);
    let sorted = swc(&[-40.0, 40.0]);
    let mut rows: Vec<&str> = sorted.lines().collect();
    rows.reverse();
    let [one, other] = [sorted.clone(), rows.join("\n")].map(|text| {
        let case = read(folder.path(), "l.swc", &text, &ENDS[..2], "");
        points(&case.unwrap_or_else(|e| panic!("{e}")))
    });
    assert_eq!(one, other);
}

/// A spur that ends within the lumen is named, and is left out by its name.
#[test]
fn spurs_can_be_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut spurs = lines(&[-40.0, 40.0]);
    let mut spur = spurs[0][..15].to_vec();
    spur.push([-5.5, 1.0, 0.0, 1.0]);
    spurs.insert(1, spur);
    let text = vtk(&spurs, "Radius", 1.0);
    let case =
        read(folder.path(), "l.vtk", &text, &ENDS[..3], "").unwrap_or_else(|e| panic!("{e}"));
    let said = mesh(&case).unwrap_err();
    assert!(
        said.contains("the line to \"outlet2\" stays within the lumen around that to \"outlet1\"")
            && said.contains("tree.leave_out = [\"outlet2\"]"),
        "{said}"
    );
    let without = "leave_out = [\"outlet2\"]\n";
    let case = read(
        folder.path(),
        "l.vtk",
        &text,
        &["outlet1", "outlet3"],
        without,
    );
    let case = case.unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(
        case.tree().unwrap().names(),
        ["inlet", "outlet1", "outlet3"]
    );
    let (worst, walls) = mesh(&case).unwrap();
    assert_eq!(
        walls,
        ["wallFsi_inlet", "wallFsi_outlet1", "wallFsi_outlet3"]
    );
    assert!((0.3..0.7).contains(&worst), "{worst}");
    let wrong = read(
        folder.path(),
        "l.vtk",
        &text,
        &ENDS[..3],
        "leave_out = [\"outlet7\"]\n",
    );
    let said = wrong.map(|_| ()).unwrap_err().to_string();
    assert!(
        said.contains("tree.leave_out") && said.contains("no line ends at \"outlet7\""),
        "{said}"
    );
}

/// Daughters with a thin twig each, one of which becomes thin itself: lines end where they are last as wide.
#[test]
fn thin_vessels_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut whole = lines(&[-40.0, 40.0]);
    let twig = |line: &[[f64; 4]], towards: f64| {
        let [x, y, ..] = line[30];
        let thin = (1..=8).map(|i| [x + 0.5 * f64::from(i), y + towards * f64::from(i), 0.0, 0.7]);
        line[..=30].iter().copied().chain(thin).collect()
    };
    let twigs: Vec<Vec<[f64; 4]>> = vec![twig(&whole[0], -1.0), twig(&whole[1], 1.0)];
    let [x, y, z, _] = whole[1][36];
    let tail = (1..=5).map(|i| {
        [
            x + f64::from(i),
            y + 0.8 * f64::from(i),
            z,
            2.0 - 0.35 * f64::from(i),
        ]
    });
    let tail: Vec<_> = tail.collect();
    whole[1].extend(&tail[..2]); // 1.65 and 1.3 mm
    let mut longer = whole[1].clone();
    longer.extend(&tail[2..]);
    let file = [whole[0].clone(), twigs[0].clone(), longer, twigs[1].clone()];
    let whole_case = |lines: &[Vec<[f64; 4]>], more: &str| {
        let text = vtk(lines, "Radius", 1.0);
        read(folder.path(), "l.vtk", &text, &ENDS[..2], more).unwrap_or_else(|e| panic!("{e}"))
    };
    let cut = whole_case(&file, "least_radius_m = 1.2e-3\n");
    assert_eq!(points(&cut), points(&whole_case(&whole, "")));
    assert_eq!(cut.tree().unwrap().names(), ["inlet", "outlet1", "outlet2"]);
    assert!((0.3..0.7).contains(&mesh(&cut).unwrap().0));
    let text = vtk(&file, "Radius", 1.0);
    let none = read(
        folder.path(),
        "l.vtk",
        &text,
        &ENDS[..2],
        "least_radius_m = 3.5e-3\n",
    );
    let said = none.map(|_| ()).unwrap_err().to_string();
    assert!(
        said.contains("tree.least_radius_m")
            && said.contains("no line is as wide as 3.5 mm: the widest place has 3 mm"),
        "{said}"
    );
}

/// A line that turns back at its end, as traced ones do, is named with its bend, and carried once it is smoothed.
#[test]
fn a_hook_is_named_and_can_be_smoothed() {
    let folder = tempfile::tempdir().unwrap();
    let mut hooked = lines(&[-40.0, 40.0]);
    let last = hooked[1].len() - 1;
    let [x, y, ..] = hooked[1][last];
    for (dx, dy) in [(0.5, 0.2), (0.6, -0.4), (0.1, -0.8), (-0.4, -0.9)] {
        hooked[1].push([x + dx, y + dy, 0.0, 2.0]);
    }
    let text = vtk(&hooked, "Radius", 1.0);
    let case =
        read(folder.path(), "l.vtk", &text, &ENDS[..2], "").unwrap_or_else(|e| panic!("{e}"));
    let said = mesh(&case).unwrap_err();
    assert!(
        said.contains("\"outlet2\"") && said.contains("bends with a radius of"),
        "{said}"
    );
    assert!(said.contains("tree.smoothing_m"), "{said}");
    let case = read(
        folder.path(),
        "l.vtk",
        &text,
        &ENDS[..2],
        "smoothing_m = 8e-3\n",
    );
    let (worst, _) = mesh(&case.unwrap_or_else(|e| panic!("{e}"))).unwrap();
    assert!((0.1..0.7).contains(&worst), "{worst}");
}

/// Daughters whose traced lines begin with a hook, from the middle of the parent's lumen: the mesh is much better where
/// a smooth curve leads past it. Elsewhere the lines keep their points, and the curve stays within a third of a radius
/// of the lines without hooks.
#[test]
fn hooks_next_to_junctions_are_smoothed_away() {
    let folder = tempfile::tempdir().unwrap();
    let straight = lines(&[-40.0, 40.0]);
    let mut hooked = straight.clone();
    let hook = [
        [-1.2, 1.5, 0.8, 3.0],
        [-0.6, 2.6, 1.6, 2.6],
        [1.2, 1.4, 1.2, 2.3],
    ];
    hooked[1].splice(21..24, hook);
    let text = vtk(&hooked, "Radius", 1.0);
    let with = |more: &str| {
        let case = read(folder.path(), "l.vtk", &text, &ENDS[..2], more);
        case.unwrap_or_else(|e| panic!("{e}"))
    };
    let quality = |case: &Case| mesh(case).unwrap_or_else(|e| panic!("{e}")).0;
    let as_traced = quality(&with(""));
    assert!((0.3..0.4).contains(&as_traced), "{as_traced}");
    let smooth = with("junction_smoothing = 1.5\n");
    let worst = quality(&smooth);
    assert!((0.55..0.7).contains(&worst), "{worst}");
    let found = points(&smooth);
    for (line, given) in found.iter().zip(&straight) {
        let curve = smooth.tree().unwrap().line.iter().flatten();
        let curve = curve
            .filter(|it| it.points == *line)
            .find_map(|it| it.curve());
        let curve = curve.unwrap();
        for [x, y, z, r] in given {
            let place = [x, y, z].map(|x| x * 1e-3);
            let foot = curve.foot(&place.into());
            assert!(foot.distance < 0.33e-3 * r, "{place:?} {foot:?}");
            let is_far = x.hypot(*y) > 9.0;
            assert!(!is_far || foot.distance < 1e-9, "{place:?} {foot:?}");
        }
    }
}

/// One junction of three and of four daughters: no wall lies between two junctions.
#[test]
fn several_daughters_leave_at_one_place() {
    let folder = tempfile::tempdir().unwrap();
    for (angles, least) in [
        (&[-50.0, 0.0, 50.0][..], 0.3),
        (&[-75.0, -25.0, 25.0, 75.0], 0.2),
    ] {
        let ends = &ENDS[..angles.len()];
        let case = read(
            folder.path(),
            "l.vtk",
            &vtk(&lines(angles), "Radius", 1.0),
            ends,
            "",
        );
        let case = case.unwrap_or_else(|e| panic!("{e}"));
        let notes = Tree::meshes(case.tree().unwrap()).unwrap().notes;
        let [note] = &notes[..] else {
            panic!("{notes:?}")
        };
        let said = format!("{} branches, on the way to \"outlet", angles.len());
        assert!(note.starts_with(&said), "{note}");
        let (worst, walls) = mesh(&case).unwrap();
        assert_eq!(walls.len(), 1 + angles.len());
        assert!(!walls.contains(&"wallFsi".into()), "{walls:?}");
        println!("{} daughters: {worst}", angles.len());
        assert!((least..0.7).contains(&worst), "{worst}");
    }
}

/// `check` says where a tree's mesh is not the usual one: branches that share a junction, averages of the wall's
/// normals, a wall that follows the lumen at the corners of the cells alone.
#[test]
fn check_notes_what_is_unusual_of_a_tree() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let notes = |text: &str, lines: &str| {
        load(here, text, lines).unwrap_or_else(|e| panic!("{e}"));
        let said = succeeds(here, &["check", ".", "--fluid", "native"]);
        let notes = said.lines().filter(|line| line.starts_with("tree "));
        notes.map(str::to_owned).collect::<Vec<_>>()
    };
    let thick = |share: &str| {
        let text = TREE.replace("thicknesses = [0.2]", &format!("thicknesses = [{share}]"));
        notes(&text, &swc(&[-30.0, 30.0]))
    };
    assert_eq!(thick("0.2"), [""; 0]);
    let averaged = "tree    the normals of its wall are averaged 16 times";
    let corners = "tree    its wall lies on the lumen at the corners of the cells alone";
    let begin_with = |notes: &[String], expected: &[&str]| {
        let pairs = notes.iter().zip(expected);
        let all = pairs.clone().all(|(note, begin)| note.starts_with(begin));
        assert!(all && notes.len() == expected.len(), "{notes:?}");
    };
    begin_with(&thick("0.9"), &[averaged]);
    begin_with(&thick("1.0"), &[averaged, corners]);

    let middle = "[[tree.opening]]\nname = \"middle\"\ncondition = \"resistance\"\nresistance_Pa_s_m3 = 1e9\n[wall.extrude]";
    let three = TREE
        .replace("\"left\", \"right\"", "\"left\", \"middle\", \"right\"")
        .replace("core = 2", "core = 4")
        .replace("[0.2]", "[0.1]")
        .replace("[wall.extrude]", middle);
    let shared = "tree    3 branches, on the way to \"right\", \"middle\", \"left\", part within 1.5 radii: they leave at one \
                  junction, at (";
    begin_with(&notes(&three, &swc(&[-50.0, 0.0, 50.0])), &[shared]);
}
