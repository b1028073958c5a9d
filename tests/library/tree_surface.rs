//! Trees whose lumen is a surface from a file: how close the meshes are to it, and what is refused.

use fsi_driver::Vec3;
use fsi_driver::case::{Case, CaseErrors, Preset, TreeKeys};
use fsi_driver::curve::CentreLine;
use fsi_driver::geometry::tree::Tree;
use fsi_driver::polydata::{PolyData, Surface, SurfaceSearch};
use fsi_driver::simulation::assembly::Domain;
use std::path::Path;
use std::process::Command;

const EXAMPLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/trees");

/// An example's case with a surface around its lines, which a script makes that knows nothing of the driver.
fn example(folder: &Path, name: &str, lines: &str, more: &[&str], keys: &str) {
    let from = Path::new(EXAMPLES).join(name);
    std::fs::copy(from.join(lines), folder.join(lines)).unwrap();
    let mut command = Command::new("python3");
    command.arg(Path::new(EXAMPLES).join("lumen.py"));
    command.arg(folder.join(lines)).arg(folder.join("tree.stl"));
    let made = command.args(more).output().unwrap();
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    let text = std::fs::read_to_string(from.join("case.toml")).unwrap();
    let keys = format!(
        "unit = \"mm\"
lumen = \"tree.stl\"
{keys}"
    );
    let text = text.replacen("unit = \"mm\"", &keys, 1);
    std::fs::write(folder.join("case.toml"), text).unwrap();
}

fn load(folder: &Path) -> Result<Case, CaseErrors> {
    Case::load(folder, Preset::Demo, &[]).map(|resolved| resolved.case)
}

/// The surface of the file, m.
fn original(folder: &Path) -> Surface {
    let data = PolyData::read(&folder.join("tree.stl")).unwrap();
    Surface::new(&data, 1e-3).unwrap()
}

/// Volume (m³) within a closed surface.
fn volume(surface: &Surface) -> f64 {
    let corners = surface.corners();
    corners
        .map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0)
        .sum::<f64>()
        .abs()
}

/// Distances of these points from a surface, in radii of the nearest line, ascending.
fn distances(points: &[Vec3], surface: Surface, tree: &TreeKeys) -> Vec<f64> {
    let search = SurfaceSearch::new(surface);
    let lines = tree.line.iter().flatten().map(|line| {
        let points: Vec<Vec3> = line.points.iter().map(|x| Vec3::from(*x)).collect();
        CentreLine::new(&points, &line.radii)
    });
    let lines: Vec<CentreLine> = lines.collect();
    let of_point = |x: &Vec3| {
        let feet = lines.iter().map(|line| line.foot(x));
        let nearest =
            feet.min_by(|a, b| (a.distance - a.radius).total_cmp(&(b.distance - b.radius)));
        (search.nearest(x) - x).norm() / nearest.unwrap().radius
    };
    let mut all: Vec<f64> = points.iter().map(of_point).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Points of the walls of a case's cells.
fn wall(domain: &Domain) -> Vec<Vec3> {
    let mesh = domain.surface();
    let patches = domain
        .wet_patches
        .iter()
        .map(|name| mesh.patch(name).unwrap());
    let faces = patches.flat_map(|patch| patch.start..patch.start + patch.size);
    let mut numbers: Vec<usize> = faces.flat_map(|face| mesh.faces[face].clone()).collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers.iter().map(|i| mesh.points[*i]).collect()
}

/// Within 1 % of the volume, and 99 % of the wall's points within a share of the radius.
fn is_close(folder: &Path, worst: f64, farthest: f64) -> Case {
    let case = load(folder).unwrap_or_else(|e| panic!("{e}"));
    let domain = Domain::new(&case).unwrap();
    let of_file = original(folder);
    let share = domain.fluid.volume() / volume(&of_file);
    let off = distances(&wall(&domain), of_file, case.tree().unwrap());
    let at = |share: f64| off[(share * (off.len() - 1) as f64) as usize];
    let branches = domain.branches.as_ref().unwrap();
    let (jacobian, _) = branches.meshed.as_ref().unwrap().worst;
    println!(
        "volume {share:.4}, 99 % {:.4}, all {:.4}, scaled Jacobian {jacobian:.3}",
        at(0.99),
        at(1.0)
    );
    assert!((share - 1.0).abs() < 0.01, "{share}");
    assert!(at(0.99) < farthest, "{}", at(0.99));
    assert!(jacobian > worst, "{jacobian}");
    case
}

fn closed_carotid(folder: &Path) {
    example(
        folder,
        "carotid",
        "lines.vtp",
        &["--closed", "--spacing", "0.3"],
        "",
    );
}

/// Within 1 % of the volume and 2 % of the radius; the case of record needs no file.
#[test]
fn cells_of_a_carotid_fill_its_surface() {
    let folder = tempfile::tempdir().unwrap();
    closed_carotid(folder.path());
    let case = is_close(folder.path(), 0.3, 0.02);
    let record = Case::of_earlier_run(&case.to_toml_string()).unwrap();
    std::fs::remove_file(folder.path().join("tree.stl")).unwrap();
    assert_eq!(
        Domain::new(&record).unwrap().fluid,
        Domain::new(&case).unwrap().fluid
    );
}

#[test]
fn cells_of_a_tree_with_seven_junctions_fill_its_surface() {
    let folder = tempfile::tempdir().unwrap();
    example(
        folder.path(),
        "arteries",
        "tree.swc",
        &["--closed", "--spacing", "0.35"],
        "lumen_smoothing_m = 4e-4",
    );
    is_close(folder.path(), 0.2, 0.02);
}

/// A vessel of this radius (mm) along x up to the origin, where daughters leave it in a plane, each with its angle
/// (degrees), length and radius (mm); around them a closed surface.
fn fork(folder: &Path, parent: f64, daughters: &[[f64; 3]]) {
    let mut points: Vec<(f64, f64, f64, i32)> = Vec::new();
    for i in 0..8 {
        points.push((2.0 * f64::from(i) - 14.0, 0.0, parent, i));
    }
    for [angle, length, radius] in daughters {
        let (sin, cos) = angle.to_radians().sin_cos();
        for i in 1..=6 {
            let before = if i == 1 { 8 } else { points.len() as i32 };
            let s = length * f64::from(i) / 6.0;
            points.push((s * cos, s * sin, *radius, before));
        }
    }
    let rows = points.iter().enumerate().map(|(i, (x, y, r, before))| {
        let before = if *before == 0 { -1 } else { *before };
        format!("{} 5 {x} {y} 0 {r} {before}\n", i + 1)
    });
    let lines = folder.join("lines.swc");
    std::fs::write(&lines, rows.collect::<String>()).unwrap();
    let mut command = Command::new("python3");
    command.arg(Path::new(EXAMPLES).join("lumen.py"));
    command.arg(&lines).arg(folder.join("tree.stl"));
    let made = command.args(["--closed", "--spacing", "0.3"]).output();
    assert!(made.unwrap().status.success());
    let case = r#"extends = "defaults"
[tree]
lines = "lines.swc"
unit = "mm"
lumen = "tree.stl"
core = 4
[[tree.opening]]
name = "inlet"
condition = "flow"
base_m3_s = 1e-6
[[tree.opening]]
name = "outlet1"
condition = "pressure"
pressure_Pa = 0.0
[[tree.opening]]
name = "outlet2"
condition = "pressure"
pressure_Pa = 0.0
[wall.extrude]
layers = ["wall"]
thicknesses = [0.1]
[[wall.material]]
name = "wall"
material = "neo_hooke"
mu_Pa = 1.5e5
kappa_Pa = 1e7
[coupling]
surrogate = "none"
[output]
structure_interval_s = 0.1
fluid_interval_s = 0.1
"#;
    std::fs::write(folder.join("case.toml"), case).unwrap();
}

/// The parent's wall lies across the short one's direction, next to its end: it does not close it.
#[test]
fn the_end_of_a_short_branch_is_next_to_its_parents_wall() {
    let folder = tempfile::tempdir().unwrap();
    fork(folder.path(), 1.6, &[[40.0, 12.0, 1.4], [-80.0, 3.4, 1.3]]);
    is_close(folder.path(), 0.4, 0.04);
}

/// What lies between the lines never leaves the surface.
#[test]
fn daughters_may_leave_in_opposite_directions() {
    let folder = tempfile::tempdir().unwrap();
    fork(folder.path(), 1.75, &[[83.0, 9.0, 1.5], [-83.0, 9.0, 1.5]]);
    is_close(folder.path(), 0.4, 0.02);
}

/// The points of the native elements' wall, and their volume.
#[test]
fn elements_of_a_carotid_fill_its_surface() {
    use fsi_driver::fluid::native::lumen_mesh::LumenMesh;
    use fsi_driver::fluid::native::metric::Metric;
    use fsi_driver::fluid::native::spectral_elements::SpectralElements;
    use fsi_driver::fluid::native::tree_mesh::TreeMesh;
    let folder = tempfile::tempdir().unwrap();
    closed_carotid(folder.path());
    let case = load(folder.path()).unwrap_or_else(|e| panic!("{e}"));
    let tree = case.tree().unwrap();
    let nodes = fsi_numerics::quadrature::Rule::gauss_lobatto(5).points;
    let mesh = TreeMesh::new(Tree::of_elements(tree, &nodes).unwrap(), 4);
    let space = SpectralElements::new(mesh.space().clone()).unwrap();
    let positions = mesh.positions(&vec![Vec3::zeros(); mesh.interface().points.len()]);
    let of_file = original(folder.path());
    let share = Metric::new(&space, &positions).unwrap().volume / volume(&of_file);
    let points = &mesh.interface().points;
    let off = distances(points, of_file, tree);
    let most = off[(0.99 * off.len() as f64) as usize];
    let (worst, _) = space.worst_element(&positions).unwrap();
    println!("volume {share:.4}, 99 % {most:.4}, scaled Jacobian {worst:.3}");
    assert!((share - 1.0).abs() < 0.01, "{share}");
    assert!(most < 0.02, "{most}");
    assert!(worst > 0.24, "{worst}");
}

/// The same file with other triangles.
fn changed(
    data: &[[[f32; 3]; 3]],
    change: impl Fn([f32; 3]) -> [f32; 3],
    keep: impl Fn([f32; 3]) -> bool,
) -> Vec<u8> {
    let kept: Vec<_> = data
        .iter()
        .filter(|three| three.iter().all(|x| keep(*x)))
        .collect();
    let mut bytes = vec![b' '; 80];
    bytes.extend((kept.len() as u32).to_le_bytes());
    for three in kept {
        bytes.extend([0; 12]);
        bytes.extend(
            three
                .iter()
                .flat_map(|x| change(*x))
                .flat_map(f32::to_le_bytes),
        );
        bytes.extend([0; 2]);
    }
    bytes
}

fn triangles(stl: &[u8]) -> Vec<[[f32; 3]; 3]> {
    let number = |at: &[u8]| f32::from_le_bytes(at.try_into().unwrap());
    let of_triangle = |bytes: &[u8]| -> [[f32; 3]; 3] {
        std::array::from_fn(|i| {
            std::array::from_fn(|c| number(&bytes[12 * (i + 1) + 4 * c..][..4]))
        })
    };
    stl[84..].chunks_exact(50).map(of_triangle).collect()
}

/// Surfaces that do not fit the lines, with a part of the reason; nothing but the case is needed to see it.
#[test]
fn surfaces_that_do_not_fit_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    example(
        folder.path(),
        "carotid",
        "lines.vtp",
        &["--spacing", "0.5"],
        "",
    );
    let file = folder.path().join("tree.stl");
    let whole = triangles(&std::fs::read(&file).unwrap());
    // Within the parent alone it is round the lines.
    let narrower: Vec<[[f32; 3]; 3]> = whole
        .iter()
        .map(|three| three.map(|[x, y, z]| [0.8 * x, 0.8 * y, z]))
        .collect();
    let same = |x: [f32; 3]| x;
    let all = |_: [f32; 3]| true;
    assert!(load(folder.path()).is_ok());
    let away =
        |x: [f32; 3], from: [f32; 3]| (0..3).map(|c| (x[c] - from[c]).powi(2)).sum::<f32>().sqrt();
    let aside = changed(&whole, |[x, y, z]| [x, y + 2.0, z], all);
    std::fs::write(&file, aside).unwrap();
    let case = load(folder.path()).unwrap_or_else(|e| panic!("{e}"));
    let meshes = Tree::meshes(case.tree().unwrap()).unwrap_or_else(|e| panic!("{e}"));
    let beside = "radii beside the middle of the surface (tree.lumen)";
    assert!(
        matches!(&meshes.notes[..], [note] if note.contains(beside)),
        "{:?}",
        meshes.notes
    );
    let text = std::fs::read_to_string(folder.path().join("case.toml")).unwrap();
    let text = text.replacen("unit = ", "lumen_smoothing_m = 1.0\nunit = ", 1);
    std::fs::write(folder.path().join("smooth.toml"), text).unwrap();
    let errors = load(&folder.path().join("smooth.toml"))
        .unwrap_err()
        .to_string();
    assert!(
        errors.contains("4 times the median radius of the lumen"),
        "{errors}"
    );
    for (bytes, reason) in [
        (
            changed(&whole, |x| x.map(|c| 0.1 * c), all),
            "ten times smaller than the centre-lines need: in cm it fits",
        ),
        (
            changed(&whole, |x| x.map(|c| 1e-3 * c), all),
            "a thousand times smaller than the centre-lines need: in m it fits",
        ),
        (
            changed(&whole, |x| x.map(|c| 1e3 * c), all),
            "in um it fits",
        ),
        (
            changed(&whole, |x| [x[0] + 60.0, x[1], x[2]], all),
            "the surface does not enclose the line to \"internal\", 100 % of which lie outside",
        ),
        (
            changed(&whole, |x| [x[0] + 20.0, x[1], x[2]], all),
            "does not enclose the line to",
        ),
        (
            changed(&whole, |x| [x[0], x[1], x[2] + 20.0], all),
            "65 % of which lie outside, first 5.00 mm from its beginning. The surface reaches from",
        ),
        (
            changed(&whole, |x| x.map(|c| 0.5 * c), all),
            "are both in the same coordinates and units (tree.lumen_unit, or tree.unit of the lines)?",
        ),
        (
            changed(&whole, |x| [x[0] + 2.5, x[1], x[2]], all),
            "does not enclose the line to \"external\"",
        ),
        (
            changed(&[&whole[..], &narrower].concat(), same, all),
            "one surface lies within another",
        ),
        (
            changed(&whole, same, |x| away(x, [3.3, 0.0, -20.0]) > 2.0),
            "the surface has a hole of",
        ),
        (
            changed(&whole, same, |x| x[2] < 20.0),
            "in the branch to \"internal\" the surface ends at",
        ),
        (
            changed(&whole, same, |x| x[2] < 20.0 || x[0] > 0.0),
            "in the branch to \"external\" the surface ends at",
        ),
        (
            changed(&whole, same, |x| x[2] > -25.0),
            "at \"common\" the surface begins only",
        ),
        (
            changed(&whole, same, |x| (x[2] + 20.0).abs() > 4.0),
            "leaves the surface at",
        ),
        (changed(&whole, same, |_| false), "no triangles"),
        (vec![], "the file is empty"),
        (b"solid nothing\nfacet".to_vec(), "tree.stl"),
    ] {
        std::fs::write(&file, bytes).unwrap();
        let Err(errors) = load(folder.path()) else {
            panic!("accepted: {reason}");
        };
        let text = errors.to_string();
        assert!(
            text.contains("tree.lumen") && text.contains(reason),
            "{text}\nexpected {reason}"
        );
    }
}
