//! `fsi-driver new` of aneurysms: lines that end within a sac of the surface.

use crate::new_case::{driver, succeeds};
use fsi_driver::case::{Case, Preset};
use fsi_driver::polydata::{PolyData, Surface};
use fsi_driver::simulation::assembly::Domain;
use std::path::Path;
use std::process::Command;

/// A point of a line (mm), its radius (mm), and the number of the one before it, from 1 on.
type Node = (f64, f64, f64, i32);

/// A vessel of this radius (mm) along x from -14 mm to the origin.
fn trunk(radius: f64) -> Vec<Node> {
    (0..8)
        .map(|i| (2.0 * f64::from(i) - 14.0, 0.0, radius, i))
        .collect()
}

/// Goes on from a node with points (mm) and radii (mm).
fn goes_on(nodes: &mut Vec<Node>, from: i32, points: &[(f64, f64, f64)]) {
    for (i, (x, y, radius)) in points.iter().enumerate() {
        let before = if i == 0 { from } else { nodes.len() as i32 };
        nodes.push((*x, *y, *radius, before));
    }
}

/// As [`goes_on`], by 1.8 mm each at an angle (degrees) with the trunk.
fn leaves(nodes: &mut Vec<Node>, angle: f64, radii: [f64; 7]) {
    let (sin, cos) = angle.to_radians().sin_cos();
    let points = radii.iter().enumerate().map(|(i, radius)| {
        let s = 1.8 * (i + 1) as f64;
        (s * cos, s * sin, *radius)
    });
    goes_on(nodes, 8, &points.collect::<Vec<_>>());
}

/// Lines, and a closed surface around them that is round where the last one ends.
fn written(folder: &Path, nodes: &[Node]) {
    let rows = nodes.iter().enumerate().map(|(i, (x, y, r, before))| {
        let before = if *before == 0 { -1 } else { *before };
        format!("{} 5 {x} {y} 0 {r} {before}\n", i + 1)
    });
    std::fs::write(folder.join("lines.swc"), rows.collect::<String>()).unwrap();
    let (x, y, ..) = nodes[nodes.len() - 1];
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/trees/lumen.py");
    let made = Command::new("python3")
        .arg(script)
        .args([folder.join("lines.swc"), folder.join("tree.stl")])
        .args(["--closed", "--spacing", "0.3"])
        .arg(format!("--sac={x},{y},0"))
        .status();
    assert!(made.unwrap().success());
}

fn proposed(folder: &Path) -> String {
    let options = "new case --from lines.swc --lumen tree.stl --unit mm";
    succeeds(folder, &options.split(' ').collect::<Vec<_>>())
}

/// The cells fill the surface: within 1 % of its volume, with a scaled Jacobian above this.
fn is_filled(folder: &Path, worst: f64) -> Case {
    let case = Case::load(&folder.join("case"), Preset::Demo, &[]);
    let case = case.unwrap_or_else(|e| panic!("{e}")).case;
    let domain = Domain::new(&case).unwrap();
    let file = PolyData::read(&folder.join("tree.stl")).unwrap();
    let surface = Surface::new(&file, 1e-3).unwrap();
    let corners = surface.corners();
    let volume = corners.map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0);
    let share = domain.fluid.volume() / volume.sum::<f64>().abs();
    let branches = domain.branches.as_ref().unwrap();
    let (jacobian, _) = branches.meshed.as_ref().unwrap().worst;
    println!("volume {share:.4}, scaled Jacobian {jacobian:.3}");
    assert!((share - 1.0).abs() < 0.01, "{share}");
    assert!(jacobian > worst, "{jacobian}");
    case
}

/// A neck as wide as the artery, and a dome next to it.
#[test]
fn a_sac_with_a_wide_neck_is_found_and_closed() {
    let folder = tempfile::tempdir().unwrap();
    let mut nodes = trunk(2.0);
    goes_on(
        &mut nodes,
        8,
        &[2.0, 4.0, 6.0, 8.0, 10.0].map(|x| (x, 0.0, 2.0)),
    );
    let sac = [(1.0, 1.8), (2.0, 2.0), (3.0, 2.8), (4.0, 3.4), (4.5, 3.5)];
    goes_on(&mut nodes, 7, &sac.map(|(y, radius)| (-1.0, y, radius)));
    written(folder.path(), &nodes);
    let said = proposed(folder.path());
    assert!(
        said.contains("sac       \"outlet2\" lies behind a neck"),
        "{said}"
    );
    assert!(said.contains("split     outlet1 100.0 %"), "{said}");
    let case = is_filled(folder.path(), 0.15);
    assert_eq!(case.tree().unwrap().closed, ["outlet2"]);
}

/// At the end of a vessel that divides.
#[test]
fn a_sac_at_the_end_of_a_vessel_that_divides() {
    let folder = tempfile::tempdir().unwrap();
    let mut nodes = trunk(1.6);
    leaves(&mut nodes, 75.0, [1.2; 7]);
    leaves(&mut nodes, -75.0, [1.2; 7]);
    let sac = [(1.0, 1.5), (2.0, 1.3), (3.0, 1.5), (4.0, 2.2), (4.6, 2.4)];
    goes_on(&mut nodes, 8, &sac.map(|(x, radius)| (x, 0.0, radius)));
    written(folder.path(), &nodes);
    let said = proposed(folder.path());
    assert!(
        said.contains("sac       \"outlet3\" lies behind a neck"),
        "{said}"
    );
    let case = is_filled(folder.path(), 0.3);
    assert_eq!(case.tree().unwrap().closed, ["outlet3"]);
    // Its share of the flow is refused with its name
    let options = "new other --from lines.swc --lumen tree.stl --unit mm --split 0.4,0.4,0.2";
    let refused = driver(folder.path(), &options.split(' ').collect::<Vec<_>>());
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    let reason = "--split: expected 2 shares, for outlet1, outlet2 in this order (no openings: outlet3), found 3";
    assert!(said.contains(reason), "{said}");
}

/// A daughter leaves from the sac: the sac is no branch but a bulge of that one's wall.
#[test]
fn a_sac_within_a_branch_is_a_bulge_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut nodes = trunk(1.6);
    leaves(&mut nodes, 50.0, [1.7, 2.2, 1.8, 1.1, 1.1, 1.1, 1.1]);
    leaves(&mut nodes, -50.0, [1.2; 7]);
    let (x, y, ..) = nodes[9];
    goes_on(
        &mut nodes,
        10,
        &[(x + 0.5, y - 0.1, 2.2), (x + 0.9, y - 0.2, 2.2)],
    );
    written(folder.path(), &nodes);
    let said = proposed(folder.path());
    let remark = "sac       outlet3: as a branch it has no mesh, so it is a bulge of the wall that it lies at";
    assert!(said.contains(remark), "{said}");
    let case = is_filled(folder.path(), 0.4);
    assert!(case.tree().unwrap().closed.is_empty());
    // Of lines alone there is no such bulge.
    let options = "new other --from lines.swc --unit mm --closed outlet3";
    let refused = driver(folder.path(), &options.split(' ').collect::<Vec<_>>());
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(
        said.contains("the line to \"outlet3\" stays within the lumen"),
        "{said}"
    );
}
