//! Meshes of trees: quality, volume, symmetry, and what is refused.

use super::*;
use std::f64::consts::PI;

/// A straight parent of radius 3 and two daughters whose directions enclose `angle`, both turned by `turned` (degrees),
/// the second one out of the plane by `fold`. Lengths in mm.
fn y(angle: f64, radius: f64, turned: f64, fold: f64) -> Lumen {
    let line = |side: f64| {
        let a = (0.5 * side * angle + turned).to_radians();
        let out = if side > 0.0 {
            fold.to_radians().sin()
        } else {
            0.0
        };
        let direction = Vec3::new(a.cos(), a.sin(), out).normalize();
        let parent = (0..=20).map(|i| (Vec3::new(i as f64 - 20.0, 0.0, 0.0), 3.0));
        let daughter = (1..=20).map(|i| {
            let share = (i as f64 / 3.0).min(1.0);
            (direction * i as f64, 3.0 + (radius - 3.0) * share)
        });
        let (points, radii): (Vec<Vec3>, Vec<f64>) = parent.chain(daughter).unzip();
        CentreLine::new(&points, &radii)
    };
    Lumen {
        lines: vec![line(-1.0), line(1.0)],
        surface: None,
    }
}

fn walls(openings: &[String]) -> Vec<String> {
    let names = openings.iter().map(|name| format!("wall_{name}"));
    names.chain(["wall".to_owned()]).collect()
}

fn mesh(lumen: Lumen, core: usize) -> Result<PolyMesh, TreeError> {
    let names: Vec<String> = (0..=lumen.lines.len())
        .map(|i| format!("opening{i}"))
        .collect();
    let tree = Tree::new(
        lumen,
        SectionGrid::of_cells(core, core, 3.0),
        2.4 / core as f64,
    )?;
    tree.mesh(&names, &walls(&names), tree.grid().growth_of_polygon())
}

/// The smallest scaled Jacobian of a mesh of a tree, by its cells' points as they are handed out.
fn worst(lumen: Lumen) -> f64 {
    let names: Vec<String> = (0..=lumen.lines.len())
        .map(|i| format!("opening{i}"))
        .collect();
    let tree =
        Tree::new(lumen, SectionGrid::of_cells(6, 4, 3.0), 0.4).unwrap_or_else(|e| panic!("{e}"));
    tree.mesh(&names, &walls(&names), tree.grid().growth_of_polygon())
        .unwrap_or_else(|e| panic!("{e}"));
    let stacks = tree.stacks().iter();
    stacks
        .map(|stack| section::worst_between(tree.grid(), &stack.sections))
        .fold(f64::INFINITY, f64::min)
}

/// Over Ys of 30° to 90°, radius ratios of 0.5 to 1, turned by 12° and folded by 30°.
#[test]
fn hexahedra_of_junctions_are_well_shaped() {
    let mut all = Vec::new();
    for angle in [30.0, 45.0, 60.0, 90.0] {
        for radius in [1.5, 2.25, 3.0] {
            for (turned, fold) in [(0.0, 0.0), (12.0, 0.0), (0.0, 30.0)] {
                all.push((
                    worst(y(angle, radius, turned, fold)),
                    angle,
                    radius,
                    turned,
                    fold,
                ));
            }
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(all[0].0 > 0.29, "{:?}", &all[..3]);
    assert!(all[3].0 > 0.38, "{:?}", &all[..5]);
    assert!(all[all.len() / 2].0 > 0.47, "{:?}", all[all.len() / 2]);
}

/// Three cylinders overlap at the junction; the rest is known, and so is how the volume converges.
#[test]
fn the_volume_converges() {
    let volumes = [4, 8, 12].map(|core| mesh(y(60.0, 3.0, 0.0, 0.0), core).unwrap().volume());
    let [coarse, medium, fine] = volumes;
    assert!((coarse / fine - 1.0).abs() < 0.01, "{volumes:?}");
    assert!((medium / fine - 1.0).abs() < 0.002, "{volumes:?}");
    // Three arms of 20 mm, less what two of them share.
    let arms = 60.0 * PI * 9.0;
    assert!((0.94..1.0).contains(&(fine / arms)), "{}", fine / arms);
}

#[test]
fn a_symmetric_y_has_a_symmetric_mesh() {
    // Points of the lines far from each other: they bend before they part.
    let sparse = |side: f64| {
        let points = [-20.0, -10.0, 0.0].map(|x| Vec3::new(x, 0.0, 0.0));
        let daughter = [10.0, 20.0].map(|s| Vec3::new(0.866 * s, 0.5 * s * side, 0.0));
        CentreLine::new(
            &[&points[..], &daughter].concat(),
            &[3.0, 3.0, 3.0, 2.4, 2.4],
        )
    };
    is_symmetric(&mesh(y(60.0, 2.4, 0.0, 0.0), 4).unwrap());
    is_symmetric(
        &mesh(
            Lumen {
                lines: vec![sparse(-1.0), sparse(1.0)],
                surface: None,
            },
            4,
        )
        .unwrap(),
    );
}

fn is_symmetric(mesh: &PolyMesh) {
    for x in &mesh.points {
        let mirrored = Vec3::new(x.x, -x.y, x.z);
        let nearest = mesh.points.iter().map(|p| (p - mirrored).norm());
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-8, "{x:?}: {nearest:e}");
    }
    let area = |name: &str| {
        let patch = mesh.patch(name).unwrap();
        let faces = patch.start..patch.start + patch.size;
        faces
            .map(|face| mesh.face_geometry(face).1.norm())
            .sum::<f64>()
    };
    // Polygons as large as the circles.
    assert!((area("opening0") / (PI * 9.0) - 1.0).abs() < 1e-3);
    assert!((area("opening1") / (PI * 2.4f64.powi(2)) - 1.0).abs() < 1e-3);
    assert!((area("opening1") / area("opening2") - 1.0).abs() < 1e-9);
}

/// Eight ends, seven junctions, each in a plane turned by 40° from that of the one upstream.
#[test]
fn a_tree_of_three_generations_has_a_mesh() {
    type Line = Vec<(Vec3, f64)>;
    fn grow(
        x: Vec3,
        along: Vec3,
        normal: Vec3,
        r: f64,
        left: usize,
        line: &mut Line,
        all: &mut Vec<Line>,
    ) {
        let length = line.len();
        line.extend((1..=9).map(|i| (x + along * (r * i as f64), r)));
        match left {
            0 => all.push(line.clone()),
            _ => {
                for (angle, ratio) in [(35.0f64, 0.85), (-28.0, 0.7)] {
                    let side = normal.cross(&along);
                    let next = along * angle.to_radians().cos() + side * angle.to_radians().sin();
                    let (sin, cos) = 40f64.to_radians().sin_cos();
                    let turned = normal * cos + next.cross(&normal) * sin;
                    grow(
                        x + along * (9.0 * r),
                        next,
                        turned,
                        r * ratio,
                        left - 1,
                        line,
                        all,
                    );
                }
            }
        }
        line.truncate(length);
    }
    let mut lines = Vec::new();
    let root = (Vec3::zeros(), 3.0);
    grow(
        root.0,
        Vec3::x(),
        Vec3::z(),
        root.1,
        3,
        &mut vec![root],
        &mut lines,
    );
    let lines = lines.into_iter().map(|line| {
        let (points, radii): (Vec<Vec3>, Vec<f64>) = line.into_iter().unzip();
        CentreLine::new(&points, &radii)
    });
    let lumen = Lumen {
        lines: lines.collect(),
        surface: None,
    };
    let tree = Tree::new(lumen.clone(), SectionGrid::of_cells(4, 3, 2.0), 0.6).unwrap();
    assert_eq!((tree.junctions.len(), tree.branches.len()), (7, 15));
    assert!(worst(lumen) > 0.4);
}

#[test]
fn trees_that_cannot_be_meshed_are_refused() {
    // Daughters that stay within each other.
    assert!(matches!(
        mesh(y(2.0, 3.0, 0.0, 0.0), 4),
        Err(TreeError::Apex(_))
    ));
    let mut apart = y(60.0, 2.4, 0.0, 0.0);
    apart.lines[1] = CentreLine::new(
        &[Vec3::new(0.0, 50.0, 0.0), Vec3::new(20.0, 50.0, 0.0)],
        &[2.0, 2.0],
    );
    assert!(matches!(mesh(apart, 4), Err(TreeError::TwoTrees(_))));
}
