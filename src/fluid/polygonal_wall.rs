//! A fluid with plane faces in a round wall, which may be loaded already at t = 0.
//!
//! Everybody else knows the points of the fluid's wall as points of the unloaded wall that move with it. Those of the
//! mesh are the corners of [polygons](WallPolygons) that enclose as much as the wall does, and have been moved with it
//! before the first step.

use super::{
    Fluid, FluidEffort, FluidError, FluidInterface, FluidMemory, FluidStep, FluidTrial, Wanted,
    face_areas,
};
use crate::Vec3;
use crate::geometry::WallPolygons;

/// The wall of a fluid's mesh compared with that of the structure, at t = 0.
pub struct RoundWall {
    /// The points on the unloaded wall, m.
    pub unloaded: Vec<Vec3>,
    /// Where the mesh has them, m.
    pub in_mesh: Vec<Vec3>,
    /// Which of them are the corners of a cross-section.
    pub polygons: WallPolygons,
}

/// A fluid, with the way from points on the wall to those of its mesh.
pub struct PolygonalWall<F> {
    fluid: F,
    wall: RoundWall,
    /// What everybody else knows of the fluid's wall.
    unloaded: FluidInterface,
    /// Number in `wall` of each point of the fluid.
    on_wall: Vec<usize>,
}

impl<F: Fluid> PolygonalWall<F> {
    /// The fluid whose mesh has this wall, in whichever order.
    pub fn new(fluid: F, wall: RoundWall) -> Self {
        let mesh = fluid.interface();
        let nearest = |x: &Vec3| {
            let far = |i: &usize| (wall.in_mesh[*i] - x).norm_squared();
            let all = 0..wall.in_mesh.len();
            all.min_by(|a, b| far(a).total_cmp(&far(b)))
                .expect("a fluid with points at its wall has a wall")
        };
        let on_wall: Vec<usize> = mesh.points.iter().map(nearest).collect();
        let moved = |&point: &u32| {
            let i = on_wall[point as usize];
            wall.in_mesh[i] - wall.unloaded[i]
        };
        let centre = |(face, centre): (&Vec<u32>, &Vec3)| {
            centre - face.iter().map(moved).sum::<Vec3>() / face.len() as f64
        };
        Self {
            unloaded: FluidInterface {
                points: on_wall.iter().map(|&i| wall.unloaded[i]).collect(),
                faces: mesh.faces.clone(),
                face_centres: (mesh.faces.iter().zip(&mesh.face_centres))
                    .map(centre)
                    .collect(),
            },
            fluid,
            wall,
            on_wall,
        }
    }

    /// Where the points of the wall are in the mesh (m, as in `wall`) after a displacement (m) of those on the wall.
    fn in_mesh(&self, displacement: &[Vec3]) -> Vec<Vec3> {
        let mut points = self.wall.unloaded.clone();
        for (&i, u) in self.on_wall.iter().zip(displacement) {
            points[i] = self.wall.unloaded[i] + u;
        }
        self.wall.polygons.widen(&mut points);
        points
    }

    /// Tractions (Pa) whose part along the normals of the mesh's faces goes along those of the wall: the sides of a
    /// wider polygon are a little steeper, and what presses there is not to shear the wall.
    fn turn(&self, tractions: &mut [Vec3], displacement: &[Vec3], in_mesh: &[Vec3]) {
        let of_mesh = face_areas(&self.unloaded.faces, |point| in_mesh[self.on_wall[point]]);
        let of_wall = self.unloaded.face_areas(displacement);
        for ((traction, mesh), wall) in tractions.iter_mut().zip(of_mesh).zip(of_wall) {
            let mesh = mesh.normalize();
            *traction += traction.dot(&mesh) * (wall.normalize() - mesh);
        }
    }
}

impl<F: Fluid> Fluid for PolygonalWall<F> {
    fn interface(&self) -> &FluidInterface {
        &self.unloaded
    }

    fn solve(
        &mut self,
        displacement: &[Vec3],
        time_step: f64,
        effort: FluidEffort,
    ) -> Result<FluidTrial, FluidError> {
        let in_mesh = self.in_mesh(displacement);
        let moved = |&i: &usize| in_mesh[i] - self.wall.in_mesh[i];
        let moved: Vec<Vec3> = self.on_wall.iter().map(moved).collect();
        let mut trial = self.fluid.solve(&moved, time_step, effort)?;
        self.turn(&mut trial.tractions, displacement, &in_mesh);
        Ok(trial)
    }

    fn accept(&mut self, wanted: Wanted) -> Result<FluidStep, FluidError> {
        self.fluid.accept(wanted)
    }

    fn memory(&mut self, needed: &dyn Fn(f64) -> bool) -> Result<FluidMemory, FluidError> {
        self.fluid.memory(needed)
    }

    fn recall(&mut self, memory: &FluidMemory) -> Result<(), FluidError> {
        self.fluid.recall(memory)
    }
}
