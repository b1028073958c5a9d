//! A fluid whose mesh has the shape of a wall that is loaded already when time begins.
//!
//! Everybody else counts displacements from the unloaded wall; such a fluid counts them from its own mesh.

use super::{
    Fluid, FluidEffort, FluidError, FluidField, FluidInterface, FluidMemory, FluidProbe, FluidStep,
    FluidTrial, FluidUsage,
};
use crate::Vec3;

/// A fluid, with the way from the unloaded wall to that of its mesh.
pub struct LoadedShape<F> {
    fluid: F,
    /// The wet surface in the unloaded configuration.
    unloaded: FluidInterface,
    /// Displacement of the points that the mesh of the fluid has already, m.
    displacement: Vec<Vec3>,
}

impl<F: Fluid> LoadedShape<F> {
    /// The fluid in a mesh whose wall points are given in both shapes, `(unloaded, loaded)`, m.
    pub fn new(fluid: F, wall: &[(Vec3, Vec3)]) -> Self {
        let mesh = fluid.interface();
        let nearest = |x: &Vec3| {
            let far = |pair: &&(Vec3, Vec3)| (pair.1 - x).norm_squared();
            let pairs = wall.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
            pairs.map_or(Vec3::zeros(), |(unloaded, loaded)| loaded - unloaded)
        };
        let displacement: Vec<Vec3> = mesh.points.iter().map(nearest).collect();
        let centre = |(face, centre): (&Vec<u32>, &Vec3)| {
            let sum: Vec3 = face.iter().map(|&point| displacement[point as usize]).sum();
            centre - sum / face.len() as f64
        };
        Self {
            unloaded: FluidInterface {
                points: (mesh.points.iter().zip(&displacement))
                    .map(|(x, u)| x - u)
                    .collect(),
                faces: mesh.faces.clone(),
                face_centres: (mesh.faces.iter().zip(&mesh.face_centres))
                    .map(centre)
                    .collect(),
            },
            displacement,
            fluid,
        }
    }
}

impl<F: Fluid> Fluid for LoadedShape<F> {
    fn interface(&self) -> &FluidInterface {
        &self.unloaded
    }

    fn solve(
        &mut self,
        displacement: &[Vec3],
        time_step: f64,
        effort: FluidEffort,
    ) -> Result<FluidTrial, FluidError> {
        let pairs = displacement.iter().zip(&self.displacement);
        let rest: Vec<Vec3> = pairs.map(|(all, mesh)| all - mesh).collect();
        self.fluid.solve(&rest, time_step, effort)
    }

    fn forget_trial(&mut self) {
        self.fluid.forget_trial();
    }

    fn accept(&mut self, write: bool) -> Result<FluidStep, FluidError> {
        self.fluid.accept(write)
    }

    fn memory(&mut self) -> Result<FluidMemory, FluidError> {
        self.fluid.memory()
    }

    fn recall(&mut self, memory: &FluidMemory) -> Result<(), FluidError> {
        self.fluid.recall(memory)
    }

    fn discard(&mut self, wanted: &dyn Fn(f64) -> bool) -> Result<(), FluidError> {
        self.fluid.discard(wanted)
    }

    fn usage(&self) -> FluidUsage {
        self.fluid.usage()
    }

    fn probes(&mut self) -> Result<Vec<FluidProbe>, FluidError> {
        self.fluid.probes()
    }

    fn field(&mut self) -> Result<Option<FluidField>, FluidError> {
        self.fluid.field()
    }

    fn seconds_by_part(&self) -> Result<Vec<(String, f64)>, FluidError> {
        self.fluid.seconds_by_part()
    }
}
