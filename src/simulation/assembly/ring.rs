//! What statics of a short ring say of a section: how fast pulses travel along it, with the wall held along its axis
//! and with a wall that slides along itself; and whether the vessel bends sideways.
//!
//! # Waves
//! Per unloaded length let `A` be the lumen's area, `λ` the axial stretch, `T` the axial force in the wall and `m` its
//! mass. Long waves `exp(i ω (t - z/c))` of small size on a uniform state under the pressure `p`, with an inviscid
//! blood of density `ρ`, obey
//! ```text
//! blood    c² a = (A/ρ) dp,                          wall, across   dp = p_A a + p_λ e,
//! wall, along   m C² e = T_A a + T_λ e - p a,        C = c/λ
//! ```
//! for changes `a` of the area, `e` of the stretch, `dp` of the pressure; subscripts are derivatives by the area at
//! constant stretch and the other way round. The last term is the pressure on a wall that widens. With `T_A - p = λ p_λ
//! = B`, since both follow from one energy,
//! ```text
//! (C² - C_BH²) (m C² - T_λ) = A B²/(ρ λ³),           C_BH² = A p_A/(ρ λ²)
//! ```
//! A wall that is held along its axis has `e = 0` and the speed `λ C_BH` of Bramwell and Hill (1922); one that slides
//! has the lower root (incremental theory: Atabek and Lew, *Wave propagation through a viscous incompressible fluid
//! contained in an initially stressed elastic tube*, Biophys. J. 6, 1966).
//!
//! # Bending sideways
//! The pressure pushes a straight tube between clamps sideways with the thrust `p A - T`, as an axial force does a
//! column (Han, *A biomechanical model of artery buckling*, J. Biomech. 40, 2007). Over the length `L` it bears
//! `4 π² EI/L²`, with the bending stiffness `EI = λ T_λ (a² + b²)/4` of the wall, where `T_λ` is that at constant
//! pressure and `a` and `b` are the inner and the outer radius. Shear and imperfections let it bend before.

use super::initial_state::{along_axis, in_state, on_x_axis};
use crate::case::{BloodVessel, Case, GivenShape, InletEnd, Material, VesselEnd};
use crate::geometry::supports as vessel_supports;
use crate::geometry::{HexFace, Section, Vessel, tube_mesh};
use crate::pfem::element::mapping::MappingKind;
use crate::pfem::solution::newton::NewtonOptions;
use crate::pfem::supports::{self, Direction, Foundation, PressureAround, Profile, Support};
use crate::pfem::{SolidError, Space, SpaceKind, Structure, StructureOptions, discretization};
use crate::tabular::units::MMHG;
use std::f64::consts::PI;

/// Degree of the ring's elements: its radii are exact to 1e-4.
const DEGREE: usize = 4;
/// Length of the ring, in radii.
const LENGTH: f64 = 0.5;
/// Relative changes of pressure and stretch from which derivatives are taken.
const CHANGE: f64 = 1e-3;
/// Least pressure (Pa) of which that is the share: next to none, differences would be lost in the errors of equilibria.
const LEAST_PRESSURE: f64 = 1e3;

/// The share of a column's thrust from which a vessel is said to bend. Shear, which that leaves out, makes arteries
/// buckle at 0.53 to 0.56 of it (tests below).
const OF_A_COLUMN: f64 = 0.5;

/// Speeds (m/s) of pulses in a section of a vessel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaveSpeeds {
    /// With the wall held along its axis, as tissue does: that of Bramwell and Hill.
    pub held: f64,
    /// With a wall that slides along itself.
    pub sliding: f64,
}

/// A ring of a section in equilibrium.
struct Ring {
    solid: Structure,
    /// That equilibrium.
    base: Vec<f64>,
    /// Its pressure, Pa.
    pressure: f64,
    /// Its stretch along the axis.
    stretch: f64,
    /// Unloaded length, m.
    length: f64,
    /// Faces of its end.
    end: Vec<(usize, HexFace)>,
    /// Displacement by axial stretch of a ring that keeps its cross-section, m.
    along: Vec<f64>,
}

/// Lumen's area (m²) and the axial force in the wall (N) of a ring.
#[derive(Debug, Clone, Copy)]
struct State {
    area: f64,
    force: f64,
}

/// Speeds of pulses in a `section` of a vessel under a pressure (Pa), with the tissue in its middle.
///
/// # Errors
/// If the ring finds no equilibrium there.
pub fn wave_speeds(
    case: &Case,
    keys: &BloodVessel,
    section: &Section,
    pressure: f64,
) -> Result<WaveSpeeds, SolidError> {
    let ring = Ring::new(case, keys, section, pressure)?;
    ring.speeds(case.wall.density, case.blood.density)
}

/// Says before a long search that a vessel will probably not be found in its given, loaded shape, because it bends
/// sideways as a straight one of its sections would: the search ends in a bent equilibrium after minutes.
pub fn sideways_warning(case: &Case) -> Option<String> {
    let keys = case.vessel()?;
    let share = sideways_share(case, keys).filter(|share| *share > OF_A_COLUMN)?;
    Some(format!(
        "the pressure of the given shape, {:.0} mmHg, pushes the vessel sideways by {:.1} times what a straight one of this wall bears between \
         clamped ends: it probably bends, and no unloaded shape is found. Tissue ([surroundings]; `fsi-driver new --tissue`), prestretch \
         (initial.axial_stretch) or a thicker wall keeps it straight",
        keys.image_pressure() / MMHG,
        share / OF_A_COLUMN
    ))
}

/// What pushes a vessel sideways in its given, loaded shape, as a share of what a straight one of its sections bears
/// between clamps. None if tissue or its ends hold it in another way, or a section does not bear the pressure.
fn sideways_share(case: &Case, keys: &BloodVessel) -> Option<f64> {
    let is_clamped =
        keys.inlet_end() == InletEnd::Clamped && keys.outlet_end().0 == VesselEnd::Clamped;
    let is_meant = keys.given_shape() == GivenShape::Loaded && keys.surroundings.is_none();
    if !(is_clamped && is_meant) {
        return None;
    }
    share_under(case, keys, keys.image_pressure())
}

/// The same under a pressure (Pa), whatever holds the vessel.
fn share_under(case: &Case, keys: &BloodVessel, pressure: f64) -> Option<f64> {
    let vessel = Vessel::new(keys);
    let (mut length, mut thrust, mut stiffness) = (0.0, 0.0, 0.0);
    for section in vessel.elastic_sections() {
        let ring = Ring::new(case, keys, section, pressure).ok()?;
        let [pushes, bends] = ring.column().ok()?;
        let own = section.to - section.from;
        length += own;
        thrust += own * pushes;
        stiffness += own * bends;
    }
    // The means of both along the vessel.
    (length > 0.0).then(|| thrust * length.powi(2) / (4.0 * PI.powi(2) * stiffness))
}

/// Derivatives of area and force by what was changed by so much down and up.
fn slopes([low, high]: [State; 2], change: f64) -> [f64; 2] {
    let by = |f: fn(&State) -> f64| (f(&high) - f(&low)) / (2.0 * change);
    [by(|state| state.area), by(|state| state.force)]
}

/// Planes at both ends that keep their distance, and what of the tissue acts across.
fn ring_supports(keys: &BloodVessel, vessel: &Vessel, middle: f64) -> Vec<Support> {
    let ends = ["start", "end"].map(supports::sliding_radially);
    let tissue = vessel_supports::tissue(keys, vessel.centre_line()).into_iter();
    let across = tissue.filter(|tissue| tissue.direction != Direction::Axial);
    let here = across.map(|tissue| {
        Support::Foundation(Foundation {
            spring: Profile::constant(tissue.spring.at(middle)),
            damping: Profile::default(),
            direction: Direction::Radial,
            axis: None,
            ..tissue
        })
    });
    ends.into_iter().flatten().chain(here).collect()
}

impl Ring {
    /// In the middle of a section, under a pressure (Pa).
    fn new(
        case: &Case,
        keys: &BloodVessel,
        section: &Section,
        pressure: f64,
    ) -> Result<Self, SolidError> {
        let vessel = Vessel::new(keys);
        let middle = 0.5 * (section.from + section.to);
        let radius = vessel.lumen_radius(middle, 0.0);
        let layers = vessel.layers_of(section);
        let thicknesses: Vec<f64> = layers.iter().map(|(_, thickness)| *thickness).collect();
        let materials: Vec<Material> = (layers.iter())
            .map(|(index, _)| vessel.materials()[*index].clone())
            .collect();
        let given_length = LENGTH * radius;
        let mesh = tube_mesh(radius, &thicknesses, given_length, 1, 4, 1);
        let mut discretization =
            discretization::Options::new(Space::isotropic(SpaceKind::Trunk, DEGREE));
        discretization.mapping = MappingKind::Blended(DEGREE);
        let around = vessel_supports::pressure_around(keys, vessel.centre_line());
        let around = around.map_or(0.0, |around| around.pressure.at(middle));
        let options = StructureOptions {
            discretization,
            density: case.wall.density,
            damping: 0.0,
            time_scheme: case.structure.time_scheme,
            load: case.structure.load,
            newton: NewtonOptions::default(),
            wet_surface: "inner".into(),
            supports: ring_supports(keys, &vessel, middle),
            outer_pressure: Some(PressureAround::constant(around)),
            gravity: None,
        };
        let solid = Structure::new(&mesh, &materials, &options)?;
        let initial = keys.initial_wall();
        let moved = along_axis(&initial, solid.body(), &mesh, on_x_axis);
        let (solid, unloaded) = in_state(&initial, solid, moved.as_deref(), None)?;
        let base = solid.equilibrium(pressure, moved.as_deref())?;
        let stretch = keys.axial_stretch();
        let length = match unloaded.found {
            Some(_) => given_length / stretch,
            None => given_length,
        };
        // The ring begins at x = 0, and so does its unloaded shape.
        let mut along = vec![0.0; base.len()];
        for (vertex, &function) in solid.body().numbering.of_vertex.iter().enumerate() {
            along[3 * function] = mesh.vertices[vertex].x * length / given_length;
        }
        Ok(Self {
            end: supports::surface(&mesh, "end")?.to_vec(),
            solid,
            base,
            pressure,
            stretch,
            length,
            along,
        })
    }

    /// The ring under another pressure (Pa), stretched by so much more than in its equilibrium.
    fn state(&self, pressure: f64, more: f64) -> Result<State, SolidError> {
        let start: Vec<f64> = (self.base.iter().zip(&self.along))
            .map(|(u, along)| u + more * along)
            .collect();
        let found = self.solid.equilibrium_from(pressure, start)?;
        // Of a tube between planes that are `length` apart.
        let length = self.length * (self.stretch + more);
        let radius = self.solid.wet_area(&found) / (std::f64::consts::TAU * length);
        Ok(State {
            area: PI * radius * radius,
            force: self.solid.body().resultant(&self.end, &found)?.x,
        })
    }

    /// Derivatives of area and force by the pressure (1/Pa) at constant stretch.
    fn by_pressure(&self) -> Result<[f64; 2], SolidError> {
        let change = CHANGE * self.pressure.abs().max(LEAST_PRESSURE);
        let at = |change: f64| self.state(self.pressure + change, 0.0);
        Ok(slopes([at(-change)?, at(change)?], change))
    }

    /// Derivatives of area and force by the stretch at constant pressure.
    fn by_stretch(&self) -> Result<[f64; 2], SolidError> {
        let change = CHANGE * self.stretch;
        let at = |change: f64| self.state(self.pressure, change);
        Ok(slopes([at(-change)?, at(change)?], change))
    }

    /// Thrust (N) and bending stiffness (N m²); see the module.
    fn column(&self) -> Result<[f64; 2], SolidError> {
        let here = self.state(self.pressure, 0.0)?;
        let [_, force_l] = self.by_stretch()?;
        let of_the_wall = self.solid.body().volume() / (self.length * self.stretch);
        let squares = 2.0 * here.area / PI + of_the_wall / PI;
        Ok([
            self.pressure * here.area - here.force,
            self.stretch * force_l * squares / 4.0,
        ])
    }

    /// See the module; densities in kg/m³.
    fn speeds(&self, of_the_wall: f64, density: f64) -> Result<WaveSpeeds, SolidError> {
        let stretch = self.stretch;
        let mass = self.solid.body().volume() / self.length * of_the_wall;
        let here = self.state(self.pressure, 0.0)?;
        let [[area_p, force_p], [area_l, force_l]] = [self.by_pressure()?, self.by_stretch()?];
        let (slope, cross) = (1.0 / area_p, -stretch * area_l / area_p);
        let along = force_l - force_p * area_l / area_p;
        let held = here.area * slope / (density * stretch.powi(2));
        let coupling = here.area * cross * cross / (density * stretch.powi(3));
        // m x² - (m C_BH² + T_λ) x + T_λ C_BH² - A B²/(ρ λ³) = 0 for x = C²; the lower root without cancellation.
        let (b, c) = (mass * held + along, along * held - coupling);
        let sliding = 2.0 * c / (b + (b * b - 4.0 * mass * c).sqrt());
        if !(held > 0.0 && sliding > 0.0) {
            return Err(SolidError::NoEquilibrium(format!(
                "waves do not travel under {:.2} kPa: the wall is not stable there",
                1e-3 * self.pressure
            )));
        }
        Ok(WaveSpeeds {
            held: stretch * held.sqrt(),
            sliding: stretch * sliding.sqrt(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Preset;
    use std::path::Path;

    /// Statics finds that the artery of the defaults buckles at 26.7 kPa, and a narrow one at 15.3 kPa (docs/wall.md).
    #[test]
    fn arteries_buckle_at_half_of_the_thrust_of_a_column() {
        let narrow = [
            ("geometry.artery_inner_radius_m", "2.35e-3"),
            ("geometry.graft_inner_radius_m", "2.35e-3"),
            ("geometry.media_thickness_m", "0.45e-3"),
            ("geometry.adventitia_thickness_m", "0.45e-3"),
        ];
        for (settings, pressure) in [(&[][..], 26.7e3), (&narrow, 15.3e3)] {
            let settings = settings
                .iter()
                .map(|(key, value)| ((*key).into(), (*value).into()));
            let settings: Vec<(String, String)> = settings.collect();
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/S-0.0");
            let case = Case::load(&folder, Preset::Paper, &settings).unwrap();
            let share = share_under(&case, case.vessel().unwrap(), pressure).unwrap();
            assert!((share - 0.54).abs() < 0.03, "{pressure} Pa: {share}");
            assert!(share > OF_A_COLUMN);
        }
    }
}
