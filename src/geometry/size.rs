//! How large a case is before anything is built.

use crate::case::{Case, FluidMesh, Native, Problem, Solver, WallMesh};

impl FluidMesh {
    /// Number of fluid cells.
    pub fn cells(&self) -> usize {
        self.core * (self.core + 4 * self.radial) * self.slices()
    }

    /// Number of cells along the centre-line.
    pub fn slices(&self) -> usize {
        self.axial_extension + 2 * self.axial_per_section
    }
}

impl Native {
    /// Number of elements.
    pub fn elements(&self) -> usize {
        self.core
            * (self.core + 4 * self.radial)
            * (self.axial_extension + 2 * self.axial_per_section)
    }

    /// Pairs of a node of the pressure and one of the velocity in the elements: what the matrix of the divergence has before
    /// elements share nodes.
    fn node_pairs(&self) -> usize {
        self.elements() * self.degree.pow(3) * (self.degree + 1).pow(3)
    }
}

impl WallMesh {
    /// Degrees of freedom of the wall in the trunk space of degree `p`, the clamped ones included.
    pub fn degrees_of_freedom(&self, p: usize) -> usize {
        let (a, c, r) = (
            2 * self.axial_per_section,
            self.circumferential,
            2 * self.radial_per_layer,
        );
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

impl Case {
    /// Number of cells of the fluid's mesh, or of its elements; none of a fluid of the user's own.
    pub fn fluid_cells(&self) -> usize {
        match (&self.problem, self.fluid.solver) {
            (_, Solver::External) => 0,
            (Problem::Anastomosis(vessel), Solver::OpenFoam) => vessel.fluid.mesh.cells(),
            (Problem::Anastomosis(vessel), Solver::Native) => vessel.fluid.native.elements(),
            (Problem::Flag(flag), _) => flag.cells(),
        }
    }

    /// Degrees of freedom of the structure, the held ones included.
    pub fn structure_degrees_of_freedom(&self) -> usize {
        let p = self.structure.p;
        match &self.problem {
            Problem::Anastomosis(vessel) => vessel.structure.degrees_of_freedom(p),
            Problem::Flag(flag) => flag.degrees_of_freedom(p),
        }
    }

    /// Memory that a run takes, bytes, within a quarter for the presets: 98 MB for each `pimpleFoam` and 2.1 kB a cell, or
    /// 150 kB an element of the driver's own solver and 130 bytes for each pair of a node of the pressure and one of the velocity
    /// in it; 10 MB for the driver and, for the factors of the tangent, a power of the degrees of freedom n (nested dissection
    /// of a body: n^(4/3)). All factors measured.
    pub fn memory(&self) -> f64 {
        self.memory_of().into_iter().map(|(bytes, _)| bytes).sum()
    }

    /// The parts of [`Case::memory`], bytes, each with what makes it less.
    pub fn memory_of(&self) -> Vec<(f64, &'static str)> {
        let wall = (self.structure_degrees_of_freedom() as f64).powf(4.0 / 3.0);
        let mut parts = vec![(
            10e6 + 600.0 * wall,
            "fewer elements (structure.*, or flag.mesh.elements) or a lower structure.p",
        )];
        match (&self.problem, self.fluid.solver) {
            (Problem::Anastomosis(vessel), Solver::Native) => parts.push((
                150e3 * self.fluid_cells() as f64 + 130.0 * vessel.fluid.native.node_pairs() as f64,
                "fewer elements or a lower degree (fluid.native.*)",
            )),
            _ => parts.extend([
                (
                    98e6 * self.fluid.ranks as f64,
                    "fewer MPI ranks (--ranks, fluid.ranks)",
                ),
                (
                    2.1e3 * self.fluid_cells() as f64,
                    "fewer cells (fluid.mesh.*, or flag.mesh.*)",
                ),
            ]),
        }
        parts
    }
}
