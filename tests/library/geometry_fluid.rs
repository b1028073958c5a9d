//! The fluid's mesh: topology, volumes, walls, files.

use approx::assert_relative_eq;
use fsi_driver::Vec3;
use fsi_driver::case::{BloodVessel, Case, FluidMesh, Preset};
use fsi_driver::geometry::{PolyMesh, Surfaces, Vessel, WallPolygons, fluid_mesh, solid_mesh};
use nalgebra::Rotation3;
use std::f64::consts::{PI, TAU};
use std::path::Path;

fn load(model: &str) -> BloodVessel {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("openfoam-case")
        .join(model);
    let case = Case::load(&folder, Preset::Demo, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    case.vessel().unwrap().clone()
}

fn patch_points(mesh: &PolyMesh, patch: &str) -> Vec<usize> {
    let mut points: Vec<usize> = mesh.patch_faces(patch).iter().flatten().copied().collect();
    points.sort_unstable();
    points.dedup();
    points
}

#[test]
fn faces_are_in_openfoams_order() {
    let mesh = fluid_mesh(&load("H-0.5"));
    let internal = mesh.neighbour.len();
    let pairs: Vec<_> = mesh.owner.iter().zip(&mesh.neighbour).collect();
    assert!(pairs.iter().all(|(owner, neighbour)| owner < neighbour));
    assert!(pairs.is_sorted(), "upper-triangular order");
    let mut next = internal;
    for patch in &mesh.patches {
        assert_eq!(patch.start, next);
        next += patch.size;
    }
    assert_eq!(next, mesh.faces.len());
    let kinds: Vec<_> = mesh
        .patches
        .iter()
        .map(|patch| (patch.name.as_str(), patch.kind.as_str()))
        .collect();
    assert_eq!(
        kinds,
        [
            ("inlet", "patch"),
            ("outlet", "patch"),
            ("wallRigid", "wall"),
            ("wallFsi", "wall")
        ]
    );
}

#[test]
fn cells_are_closed_and_have_positive_volumes() {
    for model in ["S-0.75", "H-0.75", "A-0.75"] {
        let case = load(model);
        let mesh = fluid_mesh(&case);
        let (cells, slices) = (
            &case.fluid.mesh,
            Vessel::new(&case).slices(&case.fluid.mesh),
        );
        assert_eq!(slices, cells.axial_extension + 2 * cells.axial_per_section);
        let per_slice = cells.core * (cells.core + 4 * cells.radial);
        assert_eq!(mesh.cells(), per_slice * slices);
        let mut closed = vec![Vec3::zeros(); mesh.cells()];
        for face in 0..mesh.faces.len() {
            let (_, area) = mesh.face_geometry(face);
            closed[mesh.owner[face]] += area;
            if let Some(&neighbour) = mesh.neighbour.get(face) {
                closed[neighbour] -= area;
            }
        }
        assert!(closed.iter().all(|area| area.norm() < 1e-18));
        assert!(mesh.cell_volumes().iter().all(|volume| *volume > 0.0));
    }
}

#[test]
fn the_volume_tends_to_the_lumens() {
    let case = load("S-0.75");
    let vessel = Vessel::new(&case);
    let exact = vessel.lumen_volume(0.0, 0.06) + PI * 16e-6 * 0.045;
    let error = |factor: usize| {
        let mesh = FluidMesh {
            core: 4 * factor,
            radial: 4,
            wall_grading: 3.0,
            axial_extension: 10,
            axial_per_section: 24 * factor,
            rim_parts: None,
            motion: None,
        };
        1.0 - vessel.fluid_mesh(&mesh).volume() / exact
    };
    let [coarse, fine] = [1, 2].map(error);
    assert!(coarse < 0.03, "{coarse}");
    assert_relative_eq!(coarse / fine, 4.0, max_relative = 0.1); // second order
}

/// Polygons that enclose what the wall does: of a round wall exactly, wherever it goes, of others to the order of their
/// sides.
#[test]
fn polygons_enclose_what_the_wall_does() {
    let case = load("S-0.75");
    let vessel = Vessel::new(&case);
    let error = |core: usize| {
        let mesh = FluidMesh {
            core,
            radial: 4,
            wall_grading: 3.0,
            axial_extension: 10,
            axial_per_section: 200,
            rim_parts: None,
            motion: None,
        };
        let mut grid = vessel.fluid_mesh(&mesh);
        let of_grid = grid.volume();
        let polygons = WallPolygons::of(&grid, &mesh);
        // Wider, bent aside and turned.
        let turn = Rotation3::from_axis_angle(&Vec3::x_axis(), 0.3);
        let bent = |x: &Vec3| {
            turn * Vec3::new(x.x, 1.1 * x.y, 1.1 * x.z) + 0.3 * x.x.powi(2) * Vec3::y() / 0.06
        };
        let on_wall: Vec<Vec3> = grid.points.iter().map(bent).collect();
        grid.points = polygons.fit(&grid, &mesh, &on_wall);
        assert!(grid.cell_volumes().iter().all(|volume| *volume > 0.0));
        let turn = TAU / (4 * core) as f64;
        let grown = grid.volume() / of_grid / 1.21 * turn.sin() / turn;
        assert!((grown - 1.0).abs() < 1e-12, "{grown}");
        let exact = vessel.lumen_volume(0.0, 0.06) + PI * 16e-6 * 0.045;
        grid.volume() / 1.21 / exact - 1.0
    };
    // The imperfection turns once around: its half a millimetre between sixteen corners is what is left.
    let [coarse, fine] = [4, 8].map(error);
    println!("{coarse:e} {fine:e}");
    assert!(
        coarse.abs() < 1e-3 && fine.abs() < coarse.abs(),
        "{coarse:e} {fine:e}"
    );
}

/// The points go with a wall that is shifted or widened evenly as a solid cross-section would.
#[test]
fn points_follow_the_wall() {
    let vessel = load("A-0.5");
    let (grid, mesh) = (fluid_mesh(&vessel), &vessel.fluid.mesh);
    let blend = WallPolygons::of(&grid, mesh).blend(&grid, mesh);
    let shift = Vec3::new(1e-4, -2e-4, 3e-4);
    for u in blend.spread(|_| shift) {
        assert!((u - shift).norm() < 1e-18);
    }
    let middles = Vessel::new(&vessel);
    let from_middle = |point: usize| {
        let x = grid.points[point];
        let beside = middles.centre_line().nearest(&x);
        x - middles.centre_line().frame(beside.s).origin
    };
    let largest = (0..grid.points.len()).map(|i| from_middle(i).norm());
    assert!(largest.fold(0.0, f64::max) > 3e-3);
    let wall: Vec<Vec3> = (0..grid.points.len()).map(from_middle).collect();
    // Rings of a wall with an imperfection have their middle a little next to the centre-line.
    for (u, x) in blend.spread(|point| 0.1 * wall[point]).iter().zip(&wall) {
        assert!((u - 0.1 * x).norm() < 1e-5, "{u} {x}");
    }
}

#[test]
fn walls_lie_on_the_lumen_and_patches_meet_at_the_section_ends() {
    for model in ["S-0.25", "H-0.75", "A-0.5"] {
        let case = load(model);
        let (vessel, mesh) = (Vessel::new(&case), fluid_mesh(&case));
        let fsi = patch_points(&mesh, "wallFsi");
        for &point in &fsi {
            let p = mesh.points[point];
            let radius = vessel.radius(0, p.x, p.z.atan2(p.y));
            assert!(
                (p.y.hypot(p.z) - radius).abs() < 1e-15,
                "{model}: {p:?} is off the lumen"
            );
            assert!((-1e-15..=0.06).contains(&p.x));
        }
        let rigid = patch_points(&mesh, "wallRigid");
        let around = 4 * case.fluid.mesh.core;
        assert_eq!(rigid.len(), around * (case.fluid.mesh.axial_extension + 1));
        assert_eq!(
            fsi.len(),
            around * (2 * case.fluid.mesh.axial_per_section + 1)
        );
        let shared: Vec<_> = rigid
            .iter()
            .filter(|point| fsi.binary_search(point).is_ok())
            .collect();
        assert_eq!(shared.len(), around);
        assert!(
            shared
                .iter()
                .all(|&&point| mesh.points[point].x.abs() < 1e-15)
        );
        // Normals out of the fluid.
        for face in mesh
            .patch("wallFsi")
            .map(|patch| patch.start..patch.start + patch.size)
            .unwrap()
        {
            let (centre, area) = mesh.face_geometry(face);
            assert!(area.y * centre.y + area.z * centre.z > 0.0);
        }
        for (name, direction) in [
            ("inlet", -vessel.centre_line().frame(-0.045).tangent),
            ("outlet", Vec3::x()),
        ] {
            let patch = mesh.patch(name).unwrap();
            for face in patch.start..patch.start + patch.size {
                assert_relative_eq!(
                    mesh.face_geometry(face).1.normalize().dot(&direction),
                    1.0,
                    max_relative = 1e-9
                );
            }
        }
    }
}

#[test]
fn the_walls_of_fluid_and_solid_are_the_same_surface() {
    let case = load("H-0.75");
    let (fluid, solid) = (fluid_mesh(&case), solid_mesh(&case));
    let nc = case.structure.circumferential;
    for &point in &patch_points(&fluid, "wallFsi") {
        let p = fluid.points[point];
        // The inner face that holds the point, and the local coordinates there.
        let turn = (-p.z.atan2(p.y)).rem_euclid(TAU) / TAU * nc as f64;
        let section = 0.03 / case.structure.axial_per_section as f64;
        let axial =
            (p.x.max(0.0) / section).min(2.0 * case.structure.axial_per_section as f64 - 1e-9);
        let face = axial as usize * nc + (turn as usize).min(nc - 1);
        let (element, side) = solid.surfaces["inner"][face];
        assert_eq!((side.axis, side.upper), (2, false));
        let xi = [
            2.0 * axial.fract() - 1.0,
            2.0 * (turn - ((turn as usize).min(nc - 1)) as f64) - 1.0,
            -1.0,
        ];
        let distance = (solid.shape.position(element, xi) - p).norm();
        assert!(distance < 1e-10, "{distance:e} m apart at {p:?}");
    }
}

#[test]
fn numbers_in_the_files_read_back_exactly() {
    let mesh = fluid_mesh(&load("A-0.25"));
    let scratch = tempfile::tempdir().unwrap();
    mesh.write(scratch.path()).unwrap();
    let folder = scratch.path().join("constant/polyMesh");
    let text = std::fs::read_to_string(folder.join("points")).unwrap();
    let points: Vec<Vec3> = text
        .lines()
        .filter(|line| line.starts_with('(') && line.len() > 1)
        .map(|line| {
            let numbers: Vec<f64> = line
                .trim_matches(['(', ')'])
                .split(' ')
                .map(|number| number.parse().unwrap())
                .collect();
            Vec3::from_column_slice(&numbers)
        })
        .collect();
    assert_eq!(points, mesh.points);
    let mut files: Vec<_> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|file| file.unwrap().file_name())
        .collect();
    files.sort();
    assert_eq!(files, ["boundary", "faces", "neighbour", "owner", "points"]);
    let error = mesh.write(&folder.join("points")).unwrap_err();
    assert!(error.to_string().contains("points"), "{error}");
}
