//! How large a case is before anything is built.

use crate::case::{Case, FluidMesh, Problem, RunEnds, Solver, WallMesh};
use crate::curve::SpaceCurve;
use crate::geometry::{Span, Vessel, flag};

/// Cells or elements in a slice of a vessel whose cross-section has `core` of them across its middle, and `radial`
/// layers around that.
fn of_slice(core: usize, radial: usize) -> usize {
    core * (core + 4 * radial)
}

/// Pairs of a node of the pressure and one of the velocity in an element of this degree: what the matrix of the
/// divergence has before elements share nodes.
fn node_pairs(degree: usize) -> usize {
    degree.pow(3) * (degree + 1).pow(3)
}

/// Bytes that a wall with so many degrees of freedom takes in a run, with its surrogate: most are two factors of
/// tangents, in double precision up to some 25,000 degrees of freedom. Measured of tubes from 2,160 to 13,536 in runs,
/// and to 401,760 alone; of walls that branch the factors have fewer entries.
pub fn wall_memory(degrees_of_freedom: usize) -> f64 {
    let n = degrees_of_freedom as f64;
    40e6 + f64::min(24e3 * n, 250e6 + 14.5e3 * n)
}

/// Pieces along a vessel.
fn along(spans: &[Span]) -> usize {
    spans.iter().map(|span| span.pieces).sum()
}

impl Vessel {
    /// Number of cells along the centre-line.
    pub fn slices(&self, mesh: &FluidMesh) -> usize {
        along(&self.spans(mesh))
    }

    /// Elements of the wall along, around and through it.
    fn wall_grid(&self, mesh: &WallMesh) -> [usize; 3] {
        let spans = self.spans(mesh).into_iter().filter(|span| span.is_elastic);
        [
            along(&spans.collect::<Vec<_>>()),
            mesh.circumferential,
            self.layers() * mesh.radial_per_layer,
        ]
    }

    /// Number of elements of the wall.
    pub fn wall_elements(&self, mesh: &WallMesh) -> usize {
        self.wall_grid(mesh).iter().product()
    }

    /// Degrees of freedom of the wall in the trunk space of degree `p`, the clamped ones included.
    fn degrees_of_freedom(&self, mesh: &WallMesh, p: usize) -> usize {
        let [a, c, r] = self.wall_grid(mesh);
        let (vertices, elements) = ((a + 1) * c * (r + 1), a * c * r);
        let edges = a * c * (r + 1) + (a + 1) * c * (r + 1) + (a + 1) * c * r;
        let faces = a * c * (r + 1) + (a + 1) * c * r + a * c * r;
        // Modes of the trunk space: i + j <= p on a face and i + j + k <= p inside, each at least 2.
        let edge = p - 1;
        let face = if p >= 4 { (p - 2) * (p - 3) / 2 } else { 0 };
        let inside = if p >= 6 {
            (p - 3) * (p - 4) * (p - 5) / 6
        } else {
            0
        };
        3 * (vertices + edges * edge + faces * face + elements * inside)
    }
}

/// The centre-line of a case's vessel; the x-axis if it has none.
pub fn centre_line(case: &Case) -> SpaceCurve {
    match &case.problem {
        Problem::Vessel(vessel) => Vessel::new(vessel).centre_line().clone(),
        Problem::Flag(_) | Problem::UserCase(_) => SpaceCurve::x_axis(0.0, 1.0),
    }
}

/// Number of cells of the fluid's mesh, or of its elements; none of a user-supplied fluid or mesh.
pub fn fluid_cells(case: &Case) -> usize {
    let keys = match &case.problem {
        _ if case.fluid.solver == Solver::External => return 0,
        Problem::Vessel(keys) => keys,
        Problem::Flag(flag) => return flag::cells(flag),
        Problem::UserCase(_) => return 0,
    };
    let (vessel, meshes) = (Vessel::new(keys), &keys.fluid);
    match case.fluid.solver {
        Solver::OpenFoam => {
            of_slice(meshes.mesh.core, meshes.mesh.radial) * vessel.slices(&meshes.mesh)
        }
        Solver::Native => {
            of_slice(meshes.native.core, meshes.native.radial)
                * along(&vessel.spans(&meshes.native))
        }
        Solver::External => 0,
    }
}

/// Seconds that the fluid takes for a time step on the machine of `docs/speed.md`, as far as they can be told from
/// the number of cells alone; absent for a user-supplied fluid or mesh.
pub fn fluid_seconds(case: &Case) -> Option<f64> {
    let cells = Some(fluid_cells(case)).filter(|&cells| cells > 0)? as f64;
    Some(match (&case.problem, case.fluid.solver) {
        (Problem::Vessel(vessel), Solver::Native) => {
            2.9e-4 * cells * (vessel.fluid.native.degree as f64 / 4.0).powi(4)
        }
        _ => 7.7e-6 * cells / case.fluid.ranks as f64,
    })
}

/// Seconds that a run takes on that machine while nothing else works there, until it may be over first, as far as they
/// can be told beforehand: the first beat, or a coupling that needs more than two iterations per step, takes longer.
pub fn run_seconds(case: &Case) -> Option<f64> {
    let wall = match case.has_elastic_wall() {
        true => structure_degrees_of_freedom(case) as f64,
        false => 0.0,
    };
    // 0.010 to 0.070 s of 3,024 to 12,576 degrees of freedom, 20 times as much of 190,000
    let structure = 5e-6 * wall * (1.0 + wall / 5e4);
    Some(RunEnds::of(case).from(0) as f64 * (fluid_seconds(case)? + structure))
}

/// Bytes that a run leaves on the disk that is over as soon as it may be: the wall at each step, fields of blood and
/// wall, two checkpoints. Measured with the presets; absent for a user-supplied mesh.
pub fn disk(case: &Case) -> Option<f64> {
    let cells = Some(fluid_cells(case)).filter(|&cells| cells > 0)? as f64;
    let degrees_of_freedom = structure_degrees_of_freedom(case) as f64;
    let (faces, field) = match (&case.problem, case.fluid.solver) {
        (Problem::Vessel(keys), solver) => {
            let (vessel, meshes) = (Vessel::new(keys), &keys.fluid);
            let elastic = |spans: Vec<Span>| -> f64 {
                let spans = spans.iter().filter(|span| span.is_elastic);
                spans.map(|span| span.pieces).sum::<usize>() as f64
            };
            match solver {
                Solver::Native => {
                    let degree = meshes.native.degree as f64;
                    let around = 4.0 * meshes.native.core as f64 * degree;
                    let rings = elastic(vessel.spans(&meshes.native)) * degree;
                    (rings * around, 104.0 * cells * degree.powi(3))
                }
                _ => {
                    let rings = elastic(vessel.spans(&meshes.mesh));
                    (rings * 4.0 * meshes.mesh.core as f64, 220.0 * cells)
                }
            }
        }
        _ => (0.0, 220.0 * cells),
    };
    let steps = RunEnds::of(case).from(0) as f64;
    let written = |interval: f64| (steps * case.time.step / interval).ceil();
    let every_step = match case.output.wall_history {
        true => 24.0 * faces + 16.0,
        false => 0.0,
    };
    Some(
        steps * (every_step + 1e3)
            + written(case.output.fluid_interval) * field
            + written(case.output.structure_interval) * 630.0 * degrees_of_freedom
            + 2.0 * (field + 300.0 * degrees_of_freedom),
    )
}

/// Degrees of freedom of the structure, the held ones included; none of a user-supplied wall.
pub fn structure_degrees_of_freedom(case: &Case) -> usize {
    let p = case.structure.p;
    match &case.problem {
        Problem::Vessel(keys) => Vessel::new(keys).degrees_of_freedom(&keys.structure, p),
        Problem::Flag(flag) => flag.degrees_of_freedom(p),
        Problem::UserCase(_) => 0,
    }
}

/// Memory that a run takes, bytes, within a quarter for the presets: 98 MB for each `pimpleFoam` and 2.1 kB a cell,
/// or for the driver's own solver 100 kB an element and 36 bytes for each pair of a node of the pressure and one of
/// the velocity in it; 10 MB for the driver and [`wall_memory`]. All factors measured.
pub fn memory(case: &Case) -> f64 {
    memory_of(case).into_iter().map(|(bytes, _)| bytes).sum()
}

/// The parts of [`memory`], bytes, each with what makes it less.
pub fn memory_of(case: &Case) -> Vec<(f64, &'static str)> {
    let wall = wall_memory(structure_degrees_of_freedom(case));
    memory_with(case, fluid_cells(case), wall)
}

/// The same for so many cells and bytes of the wall, where the meshes are the user's own.
pub fn memory_with(case: &Case, cells: usize, wall: f64) -> Vec<(f64, &'static str)> {
    let mut parts = vec![(
        10e6 + wall,
        "fewer elements (structure.*, or flag.mesh.elements) or a lower structure.p",
    )];
    match (case.native_degree(), case.fluid.solver) {
        (Some(degree), Solver::Native) => parts.push((
            cells as f64 * (100e3 + 36.0 * node_pairs(degree) as f64),
            "fewer elements or a lower degree (fluid.native.*, or tree.native.*)",
        )),
        _ => parts.extend([
            (
                98e6 * case.fluid.ranks as f64,
                "fewer MPI ranks (--ranks, fluid.ranks)",
            ),
            (
                2.1e3 * cells as f64,
                "fewer cells (fluid.mesh.*, or flag.mesh.*)",
            ),
        ]),
    }
    parts
}
