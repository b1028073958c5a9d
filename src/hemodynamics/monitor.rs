//! The regions of a vessel at the end of a step, in figures.

use super::place::Place;
use super::region::{Region, RegionExtent, RegionName, is_in_box};
use super::wall::{WallState, WetSurface, widened};
use crate::Vec3;
use crate::geometry::PolyMesh;
use serde::{Deserialize, Serialize};

/// A region at the end of a step; a row of `regions.csv`. Field names are the headers: they carry the unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the headers of the CSV file carry the units")]
pub struct RegionStep {
    /// Time at the end of the step.
    pub time_s: f64,
    /// Which region.
    pub region: RegionName,
    /// Magnitude of the wall shear stress, mean over the deformed area.
    pub mean_wall_shear_Pa: f64,
    /// Its largest value over the faces.
    pub max_wall_shear_Pa: f64,
    /// Where that is on the unloaded wall.
    pub max_wall_shear_x_m: f64,
    /// Where that is around the axis.
    pub max_wall_shear_phi_deg: f64,
    /// Volume of the lumen within; not a number where the region encloses none.
    pub lumen_volume_m3: f64,
    /// Largest displacement of the wet surface.
    pub max_displacement_m: f64,
    /// Largest von Mises stress at the quadrature points of the elements whose middle lies within.
    pub max_von_mises_Pa: f64,
    /// Where that is in the unloaded wall, along the axis.
    pub max_von_mises_x_m: f64,
    /// Around the axis.
    pub max_von_mises_phi_deg: f64,
    /// Distance from the axis.
    pub max_von_mises_r_m: f64,
    /// Largest principal Cauchy stress at the quadrature points of these elements.
    #[serde(default)]
    pub max_principal_Pa: f64,
    /// Largest Cauchy stress around the deformed vessel there.
    #[serde(default)]
    pub max_hoop_stress_Pa: f64,
    /// Largest Cauchy stress along it.
    #[serde(default)]
    pub max_axial_stress_Pa: f64,
    /// Largest stretch of fibres, where there are any.
    #[serde(default)]
    pub max_fibre_stretch: Option<f64>,
    /// Where the wall shear stress is largest, in space.
    #[serde(default)]
    pub max_wall_shear_at_x_m: Option<f64>,
    /// Likewise.
    #[serde(default)]
    pub max_wall_shear_at_y_m: Option<f64>,
    /// Likewise.
    #[serde(default)]
    pub max_wall_shear_at_z_m: Option<f64>,
    /// Where the von Mises stress is largest, in space.
    #[serde(default)]
    pub max_von_mises_at_x_m: Option<f64>,
    /// Likewise.
    #[serde(default)]
    pub max_von_mises_at_y_m: Option<f64>,
    /// Likewise.
    #[serde(default)]
    pub max_von_mises_at_z_m: Option<f64>,
}

impl RegionStep {
    /// Where the wall shear stress is largest.
    pub fn place_of_wall_shear(&self) -> Place {
        Place {
            position_m: point([
                self.max_wall_shear_at_x_m,
                self.max_wall_shear_at_y_m,
                self.max_wall_shear_at_z_m,
            ]),
            ..Place::on_tube(self.max_wall_shear_x_m, self.max_wall_shear_phi_deg)
        }
    }

    /// Where the von Mises stress is largest.
    pub fn place_of_von_mises(&self) -> Place {
        Place {
            position_m: point([
                self.max_von_mises_at_x_m,
                self.max_von_mises_at_y_m,
                self.max_von_mises_at_z_m,
            ]),
            ..Place::on_tube(self.max_von_mises_x_m, self.max_von_mises_phi_deg)
        }
    }
}

fn point([x, y, z]: [Option<f64>; 3]) -> Option<[f64; 3]> {
    Some([x?, y?, z?])
}

/// Largest stresses and stretches of a part of the wall, an element for example.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallStress {
    /// Unloaded position of the middle of the part, m.
    pub middle: Vec3,
    /// Von Mises stress, Pa.
    pub von_mises: f64,
    /// Largest principal Cauchy stress there, Pa.
    pub max_principal: f64,
    /// Largest stress around the deformed vessel, Pa.
    pub max_hoop: f64,
    /// Largest stress along it, Pa.
    pub max_axial: f64,
    /// Largest stretch of fibres, if there are any.
    pub max_fibre_stretch: Option<f64>,
    /// Unloaded position of the point of the largest von Mises stress, m.
    pub position: Vec3,
}

/// A wall with its regions.
#[derive(Debug, Clone)]
pub struct Monitor {
    wall: WetSurface,
    places: Vec<Place>,
    /// Centres of the unloaded faces, m.
    middles: Vec<Vec3>,
    regions: Vec<MonitoredRegion>,
}

#[derive(Debug, Clone)]
struct MonitoredRegion {
    region: Region,
    shares: Vec<(usize, f64)>,
    points: Vec<usize>,
    /// Volume of the fluid within at rest, m³, where the wall alone does not say it.
    volume_at_rest: Option<f64>,
}

impl Monitor {
    /// Prepares the regions of a wall; those that are no part of a tube enclose cells of the `fluid` at rest.
    pub fn new(wall: WetSurface, regions: &[Region], fluid: Option<&PolyMesh>) -> Self {
        let part = |region: &Region| MonitoredRegion {
            region: region.clone(),
            shares: wall.shares(region),
            points: wall.points_in(region),
            volume_at_rest: fluid.and_then(|mesh| region.volume_at_rest(mesh)),
        };
        let parts = regions.iter().map(part);
        Self {
            regions: parts.collect(),
            places: wall.places(),
            middles: wall.middles().collect(),
            wall,
        }
    }

    /// The wall.
    pub fn wall(&self) -> &WetSurface {
        &self.wall
    }

    /// Every region at the end of a step, with the stresses of all its parts. Flat faces enclose less than the fluid's
    /// curved ones: of the volume `lumen` (m³) of the whole vessel each region between cross-sections has the share
    /// that it has of theirs.
    pub fn observe(
        &self,
        state: &WallState,
        stresses: &[WallStress],
        lumen: f64,
    ) -> Vec<RegionStep> {
        let extents = self.wall.extents(&self.wall.displaced(&state.displacement));
        let flat: f64 = extents.iter().map(|extent| extent.volume).sum();
        let shear: Vec<f64> = state.shear.iter().map(|v| widened(v).norm()).collect();
        let swept = match self
            .regions
            .iter()
            .any(|part| part.volume_at_rest.is_some())
        {
            true => self.wall.swept(&state.displacement),
            false => Vec::new(),
        };
        let neighbours = self.adjacent_faces(stresses);
        let observe = |part: &MonitoredRegion| {
            let (mut area, mut volume, mut mean) = (0.0, 0.0, 0.0);
            let mut most = (0.0, Place::default());
            for &(face, share) in &part.shares {
                area += share * extents[face].area;
                volume += share * extents[face].volume;
                mean += share * extents[face].area * shear[face];
                if share >= 0.5 && shear[face] > most.0 {
                    most = (shear[face], self.places[face]);
                }
            }
            let lengths = part.points.iter().map(|&p| widened(&state.displacement[p]));
            let within: Vec<&WallStress> = (stresses.iter().enumerate())
                .filter(|(i, peak)| self.holds(&part.region, &peak.middle, neighbours.get(*i)))
                .map(|(_, peak)| peak)
                .collect();
            let stress = (within.iter()).max_by(|a, b| a.von_mises.total_cmp(&b.von_mises));
            let largest = |value: fn(&WallStress) -> Option<f64>| {
                let values = within.iter().filter_map(|peak| value(peak));
                values.max_by(f64::total_cmp)
            };
            let at = stress.map_or(Vec3::zeros(), |peak| peak.position);
            let (place, radius) = self.wall.place(&at);
            RegionStep {
                time_s: state.time,
                region: part.region.name,
                mean_wall_shear_Pa: if area > 0.0 { mean / area } else { 0.0 },
                max_wall_shear_Pa: most.0,
                max_wall_shear_x_m: most.1.x_m,
                max_wall_shear_phi_deg: most.1.phi_deg,
                lumen_volume_m3: match (&part.region.extent, part.volume_at_rest) {
                    (RegionExtent::Along { .. }, _) => volume / flat * lumen,
                    (_, None) => f64::NAN,
                    (_, Some(at_rest)) => {
                        at_rest
                            + part
                                .shares
                                .iter()
                                .map(|(face, _)| swept[*face])
                                .sum::<f64>()
                    }
                },
                max_displacement_m: lengths.map(|u| u.norm()).fold(0.0, f64::max),
                max_von_mises_Pa: stress.map_or(0.0, |peak| peak.von_mises),
                max_von_mises_x_m: place.x_m,
                max_von_mises_phi_deg: place.phi_deg,
                max_von_mises_r_m: radius,
                max_principal_Pa: largest(|peak| Some(peak.max_principal)).unwrap_or(0.0),
                max_hoop_stress_Pa: largest(|peak| Some(peak.max_hoop)).unwrap_or(0.0),
                max_axial_stress_Pa: largest(|peak| Some(peak.max_axial)).unwrap_or(0.0),
                max_fibre_stretch: largest(|peak| peak.max_fibre_stretch),
                max_wall_shear_at_x_m: most.1.position_m.map(|at| at[0]),
                max_wall_shear_at_y_m: most.1.position_m.map(|at| at[1]),
                max_wall_shear_at_z_m: most.1.position_m.map(|at| at[2]),
                max_von_mises_at_x_m: stress.map(|_| at.x),
                max_von_mises_at_y_m: stress.map(|_| at.y),
                max_von_mises_at_z_m: stress.map(|_| at.z),
            }
        };
        self.regions.iter().map(observe).collect()
    }

    /// The face nearest to each part of the wall, if a region asks for it.
    fn adjacent_faces(&self, stresses: &[WallStress]) -> Vec<usize> {
        let mut regions = self.regions.iter().map(|part| &part.region);
        if !regions.any(Region::is_on_patch) {
            return Vec::new();
        }
        let nearest = |peak: &WallStress| {
            let distances = self
                .middles
                .iter()
                .map(|x| (x - peak.middle).norm_squared());
            let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
            nearest.map_or(0, |(face, _)| face)
        };
        stresses.iter().map(nearest).collect()
    }

    /// Whether a region holds the part of the wall with this `middle` (m), whose nearest face is `nearest`.
    fn holds(&self, region: &Region, middle: &Vec3, nearest: Option<&usize>) -> bool {
        match &region.extent {
            RegionExtent::Whole {} => true,
            RegionExtent::Box { box_m } => is_in_box(box_m, middle),
            RegionExtent::Along { from_m, to_m } => {
                (*from_m..=*to_m).contains(&self.wall.place(middle).0.x_m)
            }
            RegionExtent::Patch { patch } => {
                nearest.is_some_and(|face| self.wall.is_of_patch(*face, patch))
            }
            RegionExtent::Branch { patch, .. } => nearest.is_some_and(|face| {
                let [from, to] = region.along_branch().unwrap_or_default();
                self.wall.is_of_patch(*face, patch) && (from..=to).contains(&self.wall.along(*face))
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemodynamics::wall::tests::tube;
    use approx::assert_relative_eq;
    use std::f64::consts::PI;

    #[test]
    fn mean_and_largest_values_of_a_region_are_those_within() {
        let wall = tube(40, 100);
        let places = wall.places();
        // Shear that grows along the tube, one face apart; the tube is blown up to twice its radius.
        let shear: Vec<Vec3> = places.iter().map(|p| Vec3::x() * p.x_m).collect();
        let displacement: Vec<Vec3> = wall.points.iter().map(|x| x - Vec3::x() * x.x).collect();
        let regions = [("bypass", 0.0, 2.0), ("artery", 2.0, 4.0)];
        let regions = regions.map(|(name, from, to)| Region::along(name.into(), from, to));
        let stress = |x: f64, von_mises: f64| WallStress {
            middle: Vec3::new(x, 2.0, 0.0),
            von_mises,
            max_principal: 2.0 * von_mises - x,
            max_hoop: 3.0 * von_mises - x,
            max_axial: von_mises + x,
            max_fibre_stretch: Some(x).filter(|x| *x > 3.0),
            position: Vec3::new(x, 0.0, -2.0),
        };
        let found = Monitor::new(wall, &regions, None).observe(
            &WallState::new(0.5, &shear, &displacement),
            &[stress(1.0, 7.0), stress(3.0, 5.0), stress(3.5, 6.0)],
            PI * 16.0 * 4.0,
        );
        assert_relative_eq!(found[0].mean_wall_shear_Pa, 1.0, max_relative = 1e-6);
        assert_relative_eq!(found[1].mean_wall_shear_Pa, 3.0, max_relative = 1e-6);
        assert_relative_eq!(found[0].max_wall_shear_Pa, 1.95, max_relative = 1e-6);
        assert_relative_eq!(found[1].max_wall_shear_x_m, 3.95, max_relative = 1e-6);
        assert_relative_eq!(
            found[1].lumen_volume_m3,
            PI * 16.0 * 2.0,
            max_relative = 1e-12
        );
        assert_relative_eq!(found[1].max_displacement_m, 2.0, max_relative = 1e-6);
        assert_eq!(
            (found[0].max_von_mises_Pa, found[1].max_von_mises_Pa),
            (7.0, 6.0)
        );
        assert_eq!(
            (found[1].max_von_mises_x_m, found[1].max_von_mises_r_m),
            (3.5, 2.0)
        );
        assert_eq!(found[1].max_von_mises_phi_deg, -90.0);
        let principal = found.iter().map(|step| step.max_principal_Pa);
        assert!(principal.eq([13.0, 8.5]));
        assert_eq!(
            (found[1].max_hoop_stress_Pa, found[1].max_axial_stress_Pa),
            (14.5, 9.5)
        );
        let fibres = found.iter().map(|step| step.max_fibre_stretch);
        assert!(fibres.eq([None, Some(3.5)]));
    }
}
