//! The flag in its channel: both meshes, on their own and together.

use fsi_driver::Vec3;
use fsi_driver::case::{Case, Flag, Preset, Problem};
use fsi_driver::geometry;
use fsi_driver::geometry::PolyMesh;
use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::path::Path;

fn flag(set: &[(&str, &str)]) -> Flag {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/turek-hron");
    let set: Vec<_> = set
        .iter()
        .map(|(key, value)| (key.to_string(), value.to_string()))
        .collect();
    let case = Case::load(&folder, Preset::Paper, &set).unwrap_or_else(|errors| panic!("{errors}"));
    match case.case.problem {
        Problem::Flag(flag) => flag,
        other => panic!("the case has a flag, not {other:?}"),
    }
}

/// Turek and Hron's geometry on a coarse mesh, and one that differs in everything: off-centre, long, thick, near the
/// wall.
fn flags() -> [Flag; 2] {
    let coarse = ("flag.mesh.cell_size_m", "5e-3");
    let other = [
        ("flag.channel_length_m", "4.0"),
        ("flag.channel_height_m", "0.8"),
        ("flag.depth_m", "0.3"),
        ("flag.cylinder_x_m", "0.7"),
        ("flag.cylinder_y_m", "0.25"),
        ("flag.cylinder_radius_m", "0.08"),
        ("flag.length_m", "1.1"),
        ("flag.thickness_m", "0.06"),
        ("flag.mesh.cell_size_m", "0.01"),
        ("flag.mesh.growth", "1.0"),
    ];
    [flag(&[coarse]), flag(&other)]
}

fn points_of(mesh: &PolyMesh, patch: &str) -> Vec<Vec3> {
    let points: BTreeSet<usize> = mesh.patch_faces(patch).iter().flatten().copied().collect();
    points.into_iter().map(|point| mesh.points[point]).collect()
}

/// Area between the flag's beginning on the circle and the vertical through the circle's rearmost point.
fn gap(flag: &Flag) -> f64 {
    let (r, h) = (flag.cylinder_radius, 0.5 * flag.thickness);
    2.0 * h * r - (h * (r * r - h * h).sqrt() + r * r * (h / r).asin())
}

#[test]
fn the_cells_fill_the_channel_around_cylinder_and_flag() {
    for flag in flags() {
        let mesh = geometry::flag::fluid_mesh(&flag);
        assert_eq!(mesh.cells(), geometry::flag::cells(&flag));
        assert!(mesh.cell_volumes().iter().all(|&volume| volume > 0.0));
        let solid = PI * flag.cylinder_radius.powi(2) + flag.length * flag.thickness + gap(&flag);
        let exact = (flag.channel_length * flag.channel_height - solid) * flag.depth;
        // Polygons in place of the circle.
        let volume = mesh.volume();
        assert!(
            volume > exact && volume < exact * (1.0 + 1e-4),
            "{volume} {exact}"
        );
        let names: Vec<_> = mesh
            .patches
            .iter()
            .map(|patch| patch.name.as_str())
            .collect();
        assert_eq!(
            names,
            [
                "inlet",
                "outlet",
                "wallRigid",
                "cylinder",
                "wallFsi",
                "sides"
            ]
        );
        let around = points_of(&mesh, "cylinder");
        let centre = [flag.cylinder_x, flag.cylinder_y];
        let off = |p: &Vec3| (p.x - centre[0]).hypot(p.y - centre[1]) - flag.cylinder_radius;
        assert!(around.iter().all(|p| off(p).abs() < 1e-12));
    }
}

#[test]
fn neighbouring_cells_are_of_similar_size_and_small_at_the_flag() {
    let [flag, _] = flags();
    let mesh = geometry::flag::fluid_mesh(&flag);
    let volumes = mesh.cell_volumes();
    for (face, &neighbour) in mesh.neighbour.iter().enumerate() {
        let ratio = volumes[mesh.owner[face]] / volumes[neighbour];
        assert!(
            (0.2..5.0).contains(&ratio),
            "{ratio} at {:?}",
            mesh.face_geometry(face).0
        );
    }
    let wet = mesh.patch("wallFsi").unwrap();
    for face in wet.start..wet.start + wet.size {
        let length = mesh.face_geometry(face).1.norm() / flag.depth;
        assert!(length < 3.5 * flag.mesh.cell_size, "{length}");
    }
}

#[test]
fn the_wet_surface_of_the_fluid_is_that_of_the_solid() {
    for flag in flags() {
        let (fluid, solid) = (
            geometry::flag::fluid_mesh(&flag),
            geometry::flag::solid_mesh(&flag),
        );
        let (end, middle, half) = (flag.end(), flag.cylinder_y, 0.5 * flag.thickness);
        let begin = flag.cylinder_x + (flag.cylinder_radius.powi(2) - half * half).sqrt();
        for p in points_of(&fluid, "wallFsi") {
            let on_side = ((p.y - middle).abs() - half).abs() < 1e-12 && p.x >= begin - 1e-12;
            let on_end = (p.x - end).abs() < 1e-12 && (p.y - middle).abs() <= half + 1e-12;
            assert!(on_side || on_end, "{p}");
        }
        // Every face of the solid's wet surface lies on the same lines, and all faces of the boundary have a name.
        let wet = &solid.surfaces["wet"];
        assert_eq!(wet.len(), 2 * flag.mesh.elements + 1);
        let named: usize = solid.surfaces.values().map(Vec::len).sum();
        assert_eq!(named, 4 * flag.mesh.elements + 2);
        for &(element, face) in wet {
            let mut xi = [0.3; 3];
            xi[face.axis as usize] = if face.upper { 1.0 } else { -1.0 };
            let p = solid.shape.position(element, xi);
            let distance = ((p.y - middle).abs() - half).abs().min((p.x - end).abs());
            assert!(distance < 1e-12, "{p}");
        }
    }
}
