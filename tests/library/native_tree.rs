//! The driver's own elements in the lumen of a tree: their shape, and what they do when the wall moves.

use crate::trees;
use fsi_driver::Vec3;
use fsi_driver::case::Rheology;
use fsi_driver::curve::CentreLine;
use fsi_driver::fluid::native::lumen_mesh::LumenMesh;
use fsi_driver::fluid::native::metric::Metric;
use fsi_driver::fluid::native::spectral_elements::SpectralElements;
use fsi_driver::fluid::native::taylor_hood_space::Boundary;
use fsi_driver::fluid::native::tree_mesh::TreeMesh;
use fsi_driver::fluid::native::{BoundaryConditions, Flow, FlowSettings, FlowState, TimeScheme};
use fsi_driver::geometry::tree::{Lumen, SectionGrid, Tree};
use fsi_driver::pfem::Solid;
use fsi_driver::simulation::assembly::{Domain, structure};

/// A parent of radius 3 along x and two daughters whose directions enclose `angle`, both turned by `turned` (degrees),
/// the second one out of the plane by `fold`; lengths in mm.
fn y(angle: f64, radius: f64, turned: f64, fold: f64) -> Lumen {
    let line = |side: f64| {
        let a = (0.5 * side * angle + turned).to_radians();
        let out = if side > 0.0 {
            fold.to_radians().sin()
        } else {
            0.0
        };
        let direction = Vec3::new(a.cos(), a.sin(), out).normalize();
        let parent = (0..=15).map(|i| (Vec3::new(f64::from(i) - 15.0, 0.0, 0.0), 3.0));
        let daughter = (1..=18).map(|i| {
            let share = (f64::from(i) / 3.0).min(1.0);
            (direction * f64::from(i), 3.0 + (radius - 3.0) * share)
        });
        let (points, radii): (Vec<Vec3>, Vec<f64>) = parent.chain(daughter).unzip();
        CentreLine::new(&points, &radii)
    };
    Lumen::new(vec![line(-1.0), line(1.0)], None)
}

/// The mesh of elements of this degree, and the space on it.
fn meshed(lumen: Lumen, degree: usize) -> (TreeMesh, SpectralElements) {
    let nodes = fsi_numerics::quadrature::Rule::gauss_lobatto(degree + 1).points;
    let grid = SectionGrid::of_elements(2, 2, 1.5, &nodes);
    let mesh = TreeMesh::new(
        Tree::new(lumen, grid, 1.0).unwrap_or_else(|e| panic!("{e}")),
        degree,
    );
    let space = SpectralElements::new(mesh.space().clone()).unwrap();
    (mesh, space)
}

fn at_rest(mesh: &TreeMesh) -> Vec<f64> {
    mesh.positions(&vec![Vec3::zeros(); mesh.interface().points.len()])
}

/// Over Ys of 30° to 90°, radius ratios of 0.5 to 1, turned by 12° and folded by 30°: at all nodes of degree 4.
#[test]
fn elements_of_junctions_are_well_shaped() {
    let mut all = Vec::new();
    for angle in [30.0, 60.0, 90.0] {
        for radius in [1.5, 2.25, 3.0] {
            for (turned, fold) in [(0.0, 0.0), (12.0, 0.0), (0.0, 30.0)] {
                let (mesh, space) = meshed(y(angle, radius, turned, fold), 4);
                let (found, _) = space.worst_element(&at_rest(&mesh)).unwrap();
                println!("{angle} {radius} {turned} {fold}: {found:.3}");
                all.push(found);
            }
        }
    }
    all.sort_by(f64::total_cmp);
    assert!(all[0] > 0.3, "{:?}", &all[..4]);
    assert!(all[all.len() / 2] > 0.5, "{:?}", all[all.len() / 2]);
}

/// The volume of elements is that of the next degree, and that of cells.
#[test]
fn the_volume_converges_with_the_degree() {
    let volumes = [3, 4, 5, 6].map(|degree| {
        let (mesh, space) = meshed(y(60.0, 2.4, 0.0, 0.0), degree);
        Metric::new(&space, &at_rest(&mesh)).unwrap().volume
    });
    println!("{volumes:?}");
    for (pair, most) in volumes.windows(2).zip([6e-4, 3e-4, 1e-4]) {
        assert!((pair[0] / pair[1] - 1.0).abs() < most, "{volumes:?}");
    }
    let cells = Tree::new(
        y(60.0, 2.4, 0.0, 0.0),
        SectionGrid::of_cells(12, 8, 3.0),
        0.2,
    )
    .unwrap();
    let names = ["a", "b", "c"].map(str::to_owned);
    let cells = cells
        .mesh(&names, &names, cells.grid().growth_of_polygon())
        .unwrap()
        .volume();
    assert!(
        (volumes[3] / cells - 1.0).abs() < 2e-3,
        "{volumes:?} {cells}"
    );
}

/// A straight parent of radius 3 with a branch of radius `radius` at its side, closed as a ball of radius 3 or open.
fn side(radius: f64, is_closed: bool) -> Lumen {
    let parent = |x: i32| (Vec3::new(f64::from(x), 0.0, 0.0), 3.0);
    let whole: Vec<(Vec3, f64)> = (-15..=15).map(parent).collect();
    let branch = [0.5, 2.0, 3.5, 4.5, 6.0, 7.0, 8.0].map(|y| {
        let wide = if is_closed { 3.0 } else { radius };
        let share = ((y - 4.5) / 2.5f64).clamp(0.0, 1.0);
        (Vec3::new(0.2 * y, y, 0.0), radius + (wide - radius) * share)
    });
    let lines = [whole, (-15..=0).map(parent).chain(branch).collect()];
    let mut lines = lines.map(|line| {
        let (points, radii): (Vec<Vec3>, Vec<f64>) = line.into_iter().unzip();
        CentreLine::new(&points, &radii)
    });
    lines[1].is_closed = is_closed;
    Lumen::new(lines.into(), None)
}

/// Thin branches and sacs: the Jacobian at all nodes, and the volume of elements beside that of cells.
#[test]
fn elements_of_side_branches_are_well_shaped() {
    for (radius, is_closed) in [(0.6, false), (1.2, false), (1.8, false), (1.4, true)] {
        let (mesh, space) = meshed(side(radius, is_closed), 4);
        let (found, at) = space.worst_element(&at_rest(&mesh)).unwrap();
        let volume = Metric::new(&space, &at_rest(&mesh)).unwrap().volume;
        let grid = SectionGrid::of_cells(8, 6, 3.0);
        let cells = Tree::new(side(radius, is_closed), grid, 0.3).unwrap();
        let names = ["a", "b", "c"].map(str::to_owned);
        let cells = cells
            .mesh(&names, &names, cells.grid().growth_of_polygon())
            .unwrap();
        println!(
            "{radius} {is_closed}: {found:.3} at {at:?}, {:.5}",
            volume / cells.volume()
        );
        assert!(found > 0.3, "{radius} {is_closed}: {found}");
        assert!((volume / cells.volume() - 1.0).abs() < 4e-3, "{volume}");
    }
}

/// A wall that breathes and bends, nothing of which the free stream sees but the rounding of a few operations: 6e-15 of
/// the stream, here and at the sac.
#[test]
fn a_free_stream_stays_as_it_is_in_a_junction_that_moves() {
    stays_as_it_is(y(60.0, 2.4, 12.0, 30.0));
}

#[test]
fn a_free_stream_stays_as_it_is_at_a_sac_that_moves() {
    stays_as_it_is(side(1.4, true));
}

fn stays_as_it_is(lumen: Lumen) {
    let (mesh, space) = meshed(lumen, 3);
    let stream = Vec3::new(1.0, 0.2, 0.1);
    let velocity: Vec<f64> = (0..3)
        .flat_map(|c| vec![stream[c]; space.space.nodes])
        .collect();
    let moved = |t: f64| -> Vec<f64> {
        let points = mesh.interface().points.iter();
        let displacement: Vec<Vec3> = points
            .map(|x| {
                Vec3::new(
                    (0.3 * x.y).sin(),
                    0.4 * (0.2 * x.x + 3.0 * t).sin() - 0.1 * x.y,
                    0.2 * x.z,
                ) * (0.5 * t)
            })
            .collect();
        mesh.positions(&displacement)
    };
    let is_open = |patch| patch == Boundary::End(1);
    let fixed = space.space.faces_of(|patch| !is_open(patch));
    let settings = FlowSettings {
        density: 1.3,
        rheology: Rheology::Newtonian { viscosity: 0.5 },
        scheme: TimeScheme::Bdf2,
        tolerance: 1e-14,
        max_iterations: 400,
    };
    let pressure = vec![0.0; space.space.pressures];
    let mut state = FlowState {
        time: 0.0,
        before: None,
        positions: [moved(0.0), moved(0.0)],
        velocity: [velocity.clone(), velocity.clone()],
        pressure: [pressure.clone(), pressure],
        preconditioner: None,
    };
    let mut flow = Flow::new(space, settings, &fixed, Vec::new(), Vec::new(), &moved(0.0)).unwrap();
    let mut t = 0.0;
    for dt in [0.1, 0.1, 0.05, 0.2] {
        t += dt;
        let boundary = BoundaryConditions {
            velocity: velocity.clone(),
            ..BoundaryConditions::default()
        };
        let solution = flow.solve(&state, dt, moved(t), &boundary, None).unwrap();
        flow.accept(&mut state, solution);
    }
    let apart = moved(t)
        .iter()
        .zip(&moved(0.0))
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(apart > 0.2, "{apart}");
    let [now, _] = &state.velocity;
    let error = now
        .iter()
        .zip(&velocity)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    println!("{error:.1e}");
    assert!(error < 5e-14, "{error:e}");
}

/// The wall's faces and the elements are other interpolations of one surface: where daughters part at 50°, points of
/// the elements lie within 1.75 % of the radius of the wall. (If that met the surface at the corners of the cells
/// alone, 2.2 %.)
#[test]
fn the_wall_and_the_elements_lie_on_one_surface() {
    let folder = tempfile::tempdir().unwrap();
    let text = trees::TREE
        .replace("core = 2", "core = 4")
        .replace("length = 0.8", "length = 0.6")
        .replace("faces_per_element = 1", "faces_per_element = 2");
    let case = trees::load(folder.path(), &text, &trees::swc(&[-25.0, 25.0]));
    let case = case.unwrap_or_else(|e| panic!("{e}"));
    let domain = Domain::new(&case).unwrap();
    let wall = structure(&case, &domain).unwrap();
    let nodes = fsi_numerics::quadrature::Rule::gauss_lobatto(5).points;
    let tree = Tree::of_elements(case.tree().unwrap(), &nodes).unwrap();
    let mesh = TreeMesh::new(tree, 4);
    let found = wall.locate(&mesh.interface().points).unwrap();
    let off = found.iter().map(|place| place.distance / 3e-3);
    let off = off.fold(0.0, f64::max);
    assert!((1e-3..0.019).contains(&off), "{off:.2e}");
}
