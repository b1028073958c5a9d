//! What is recorded at chosen points: of the wet surface for `probes.csv`, in the blood for `fluid-probes.csv`.

use super::tables::{FluidProbeRow, ProbeRow};
use crate::Vec3;
use crate::coupling::Step;
use crate::fluid::FluidProbe;
use crate::pfem::{Solid, SolidError};

/// Points of the wet surface of a structure.
pub struct Probes<S: Solid> {
    points: Vec<Vec3>,
    locations: Vec<S::Location>,
    /// The fluid's face whose centre is nearest to each.
    faces: Vec<usize>,
}

impl<S: Solid> Probes<S> {
    /// Finds the points (reference positions, m) on the wet surface of `solid`, and among the fluid's faces with these
    /// `centres` (m).
    pub fn new(points: Vec<Vec3>, solid: &S, centres: &[Vec3]) -> Result<Self, SolidError> {
        let nearest = |x: &Vec3| {
            let distance = |face: &usize| (centres[*face] - x).norm_squared();
            let order = |a: &usize, b: &usize| distance(a).total_cmp(&distance(b));
            (0..centres.len()).min_by(order).unwrap_or(0)
        };
        Ok(Self {
            locations: solid.locate(&points)?,
            faces: points.iter().map(nearest).collect(),
            points,
        })
    }

    /// A row for each point, in the accepted state of `solid` after `step`.
    pub fn rows(&self, solid: &S, step: &Step) -> Vec<ProbeRow> {
        let displacement = solid.accepted_displacement(&self.locations);
        let pairs = self.points.iter().zip(&displacement).enumerate();
        let row = |(probe, (x, u)): (usize, (&Vec3, &Vec3))| {
            let shear = step.fluid.wall_shear[self.faces[probe]];
            ProbeRow {
                time_s: step.fluid.time,
                probe,
                x_m: x.x,
                y_m: x.y,
                z_m: x.z,
                ux_m: u.x,
                uy_m: u.y,
                uz_m: u.z,
                wall_shear_x_Pa: shear.x,
                wall_shear_y_Pa: shear.y,
                wall_shear_z_Pa: shear.z,
                p_Pa: step.wall_pressure[self.faces[probe]],
            }
        };
        pairs.map(row).collect()
    }
}

/// A row for each point (m) in the blood.
pub fn fluid_rows(time: f64, points: &[[f64; 3]], found: &[FluidProbe]) -> Vec<FluidProbeRow> {
    let pairs = points.iter().zip(found).enumerate();
    let row =
        |(probe, (&[x_m, y_m, z_m], found)): (usize, (&[f64; 3], &FluidProbe))| FluidProbeRow {
            time_s: time,
            probe,
            x_m,
            y_m,
            z_m,
            p_Pa: found.pressure,
            ux_m_s: found.velocity.x,
            uy_m_s: found.velocity.y,
            uz_m_s: found.velocity.z,
        };
    pairs.map(row).collect()
}
