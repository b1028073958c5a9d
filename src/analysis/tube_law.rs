//! Pressure and radius of a long straight tube of hyperelastic layers: what a wall does before anything is meshed.
//!
//! The wall keeps its volume, `r² = r_i² + (R² - R_i²)/λ_z`, and its radial stress is small compared with the one
//! around, as in a membrane; each material finds its radial stretch from that. Virtual work then gives the pressure `p
//! = ∫ P_θθ/r dR`, exact for incompressible layers and right to the first order in the thickness for others.

use crate::Mat3;
use crate::Vec3;
use crate::case::{BloodVessel, Case, GivenShape, Material, TissueDirection};
use crate::geometry::{Section, Vessel};
use crate::pfem::material::{HyperelasticMaterial, Law, WallAxes};
use crate::quadrature::Rule;
use std::f64::consts::PI;
use std::sync::Arc;

/// Gauss points through a layer.
const POINTS: usize = 6;
/// Bisections of a radius: to 1e-12 of the range that is looked at.
const BISECTIONS: usize = 48;
/// A tube is looked at up to so many times its unloaded radius.
const WIDEST: f64 = 3.0;

/// A tube, unloaded.
pub struct TubeLaw {
    /// Materials with the radii (m) of both sides, from the inside out.
    layers: Vec<(Arc<dyn HyperelasticMaterial>, [f64; 2])>,
    /// Length relative to the unloaded one.
    axial_stretch: f64,
    /// Springs around the tube, Pa/m of the unloaded outer surface.
    spring: f64,
    /// Pressure around it, Pa.
    outside: f64,
}

impl TubeLaw {
    /// The middle of a section of a vessel; `None` if it has no layers, or is loaded in a way that no tube of these
    /// materials is.
    pub fn of(vessel: &BloodVessel, geometry: &Vessel, section: &Section) -> Option<Self> {
        let layers = geometry.layers_of(section);
        if layers.is_empty() {
            return None;
        }
        let tissue = vessel.surroundings.as_ref();
        let resists = tissue.is_some_and(|tissue| {
            matches!(
                tissue.direction.unwrap_or_default(),
                TissueDirection::Radial | TissueDirection::All
            )
        });
        let middle = 0.5 * (section.from + section.to);
        let mut radius = mean_radius(geometry, middle);
        let layers = layers.into_iter().map(|(material, thickness)| {
            let inner = radius;
            radius += thickness;
            (
                Law::from(&geometry.materials()[material]).elastic,
                [inner, radius],
            )
        });
        let mut tube = Self {
            layers: layers.collect(),
            axial_stretch: vessel.axial_stretch(),
            spring: tissue
                .and_then(|tissue| tissue.spring)
                .filter(|_| resists)
                .unwrap_or(0.0),
            outside: tissue.and_then(|tissue| tissue.pressure).unwrap_or(0.0),
        };
        match vessel.given_shape() {
            GivenShape::Unloaded => Some(tube),
            GivenShape::Loaded => {
                // Springs are at rest in the given shape, or nearly.
                tube.spring = 0.0;
                tube.unloaded(vessel.equilibrium_pressure())
            }
        }
    }

    /// A tube whose lumen has the radius 1 m, of layers with their thicknesses (m), with springs around it (Pa/m).
    pub fn of_layers(layers: &[(&Material, f64)], axial_stretch: f64, spring: f64) -> Self {
        let mut radius = 1.0;
        let layers = layers.iter().map(|(material, thickness)| {
            let inner = radius;
            radius += thickness;
            (Law::from(*material).elastic, [inner, radius])
        });
        Self {
            layers: layers.collect(),
            axial_stretch,
            spring,
            outside: 0.0,
        }
    }

    /// The tube that has the sizes of this one under a pressure (Pa); `None` if none of these materials has.
    pub fn unloaded(self, pressure: f64) -> Option<Self> {
        let loaded: Vec<[f64; 2]> = self.layers.iter().map(|(_, radii)| *radii).collect();
        let inner = loaded[0][0];
        let mut tube = self;
        let mut resize = |unloaded: f64| {
            let at = |r: f64| {
                (unloaded.powi(2) + tube.axial_stretch * (r.powi(2) - inner.powi(2))).sqrt()
            };
            for ((_, radii), loaded) in tube.layers.iter_mut().zip(&loaded) {
                *radii = loaded.map(at);
            }
            tube.pressure(inner)
        };
        // The wider the unloaded tube, the less it carries at this radius.
        let [mut narrow, mut wide] = [inner / WIDEST, inner * WIDEST];
        if resize(narrow) < pressure || resize(wide) > pressure {
            return None;
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (narrow + wide);
            match resize(middle) > pressure {
                true => narrow = middle,
                false => wide = middle,
            }
        }
        resize(0.5 * (narrow + wide));
        Some(tube)
    }

    /// Unloaded radius of the lumen, m.
    fn inner(&self) -> f64 {
        self.layers[0].1[0]
    }

    /// Thickness of the wall relative to the radius of the lumen, unloaded.
    pub fn thickness_ratio(&self) -> f64 {
        self.layers[self.layers.len() - 1].1[1] / self.inner() - 1.0
    }

    /// Pressure (Pa) inside under which the lumen has the radius `r` (m).
    pub fn pressure(&self, r: f64) -> f64 {
        let outward = |radius: f64| {
            (r.powi(2) + (radius.powi(2) - self.inner().powi(2)) / self.axial_stretch)
                .max(0.0)
                .sqrt()
        };
        let rule = Rule::gauss_legendre(POINTS);
        let mut pressure = self.outside;
        for (material, [from, to]) in &self.layers {
            for (x, weight) in rule.points.iter().zip(&rule.weights) {
                let radius = 0.5 * (from + to + (to - from) * x);
                let now = outward(radius);
                let stress = hoop_stress(material.as_ref(), self.axial_stretch, now / radius);
                pressure += 0.5 * (to - from) * weight * stress / now;
            }
        }
        let outer = self.layers[self.layers.len() - 1].1[1];
        pressure + self.spring * (outward(outer) - outer) * outer / outward(outer)
    }

    /// Radius (m) of the lumen under a pressure (Pa); `None` if it does not stand up to it.
    pub fn radius(&self, pressure: f64) -> Option<f64> {
        let [mut narrow, mut wide] = [0.3 * self.inner(), WIDEST * self.inner()];
        if !(self.pressure(narrow) < pressure && self.pressure(wide) > pressure) {
            return None;
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (narrow + wide);
            match self.pressure(middle) < pressure {
                true => narrow = middle,
                false => wide = middle,
            }
        }
        Some(0.5 * (narrow + wide))
    }

    /// Area that the lumen gains between two pressures (Pa), per pressure, m²/Pa; `None` if the tube does not stand up
    /// to them.
    pub fn compliance(&self, [lowest, highest]: [f64; 2]) -> Option<f64> {
        let [narrow, wide] = [self.radius(lowest)?, self.radius(highest)?];
        Some(PI * (wide.powi(2) - narrow.powi(2)) / (highest - lowest))
    }

    /// Speed of pulse waves (m/s) under a pressure (Pa) in blood of this density (kg/m³), the wall held along its axis:
    /// Bramwell and Hill (1922), `c² = (A/ρ) dp/dA`.
    pub fn wave_speed(&self, pressure: f64, density: f64) -> Option<f64> {
        let r = self.radius(pressure)?;
        let h = 1e-4 * r;
        let slope = (self.pressure(r + h) - self.pressure(r - h)) / (2.0 * h);
        Some((0.5 * r * slope / density).sqrt()).filter(|speed| speed.is_finite())
    }
}

/// Radius (m) of the lumen at an arc length (m), mean over the angle.
pub fn mean_radius(geometry: &Vessel, s: f64) -> f64 {
    const AROUND: usize = 16;
    let at = |i: usize| geometry.lumen_radius(s, std::f64::consts::TAU * i as f64 / AROUND as f64);
    (0..AROUND).map(at).sum::<f64>() / AROUND as f64
}

/// First Piola-Kirchhoff stress around (Pa) of a material stretched along and around by so much, without stress through
/// the wall.
fn hoop_stress(material: &dyn HyperelasticMaterial, along: f64, around: f64) -> f64 {
    let axes = WallAxes {
        axial: Vec3::x(),
        circumferential: Vec3::y(),
        normal: Vec3::z(),
    };
    let mut through = 1.0 / (along * around);
    let stretched = |through: f64| Mat3::from_diagonal(&Vec3::new(along, around, through));
    for _ in 0..20 {
        let now = stretched(through);
        let change = material.stress(&now, &axes)[(2, 2)] / material.tangent(&now, &axes)[(8, 8)];
        through = (through - change).max(0.2 * through);
        if change.abs() < 1e-13 {
            break;
        }
    }
    material.stress(&stretched(through), &axes)[(1, 1)]
}

/// The law of each elastic section of a case's vessel, with the section.
pub fn of_sections(case: &Case) -> Vec<(Section, TubeLaw)> {
    let Some(vessel) = case.vessel().filter(|vessel| !vessel.is_rigid()) else {
        return Vec::new();
    };
    let geometry = Vessel::new(vessel);
    let sections = geometry.elastic_sections();
    let laws = sections
        .filter_map(|section| Some((section.clone(), TubeLaw::of(vessel, &geometry, section)?)));
    laws.collect()
}

/// Compliance of a case's vessel between two pressures (Pa), as that of the tubes that its sections are, m³/Pa; without
/// those that do not stand up to them.
pub fn compliance(case: &Case, pressures: [f64; 2]) -> f64 {
    let of_section = |(section, law): (Section, TubeLaw)| {
        Some((section.to - section.from) * law.compliance(pressures)?)
    };
    of_sections(case).into_iter().filter_map(of_section).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Material;

    fn hgo(mu: f64, kappa: f64, k1: f64, k2: f64, fibre_angle_deg: f64) -> Material {
        Material::HolzapfelGasserOgden {
            mu,
            kappa,
            k1,
            k2,
            fibre_angle_deg,
            dispersion: None,
            tension_only: false,
            viscosity: None,
        }
    }

    fn tube(layers: &[(Material, [f64; 2])]) -> TubeLaw {
        let layers = layers
            .iter()
            .map(|(material, radii)| (Law::from(material).elastic, *radii));
        TubeLaw {
            layers: layers.collect(),
            axial_stretch: 1.0,
            spring: 0.0,
            outside: 0.0,
        }
    }

    /// The paper's artery under 16 kPa on the deformed area: 1.2289883693 mm by a semi-analytic solution.
    fn artery() -> TubeLaw {
        let (media, adventitia) = (
            hgo(5.4e4, 1e9, 640.0, 3.54, 10.0),
            hgo(5.4e3, 1e8, 5.1e3, 15.4, 40.0),
        );
        tube(&[(media, [3e-3, 3.5e-3]), (adventitia, [3.5e-3, 4e-3])])
    }

    #[test]
    fn a_layered_artery_widens_as_theory_says() {
        let widening = artery().radius(1.6e4).unwrap() - 3e-3;
        let error = widening / 1.2289883693e-3 - 1.0;
        // 1e-4: the bulk moduli are not infinite
        assert!(error.abs() < 3e-4, "{error:e}");
    }

    #[test]
    fn a_tube_of_its_loaded_sizes_goes_back_to_the_unloaded_ones() {
        let law = artery();
        let r = law.radius(1.2e4).unwrap();
        let grow = |radius: f64| (r.powi(2) + radius.powi(2) - 9e-6).sqrt();
        let (media, adventitia) = (
            hgo(5.4e4, 1e9, 640.0, 3.54, 10.0),
            hgo(5.4e3, 1e8, 5.1e3, 15.4, 40.0),
        );
        let loaded = tube(&[
            (media, [r, grow(3.5e-3)]),
            (adventitia, [grow(3.5e-3), grow(4e-3)]),
        ]);
        let found = loaded.unloaded(1.2e4).unwrap();
        assert!(
            (found.inner() / 3e-3 - 1.0).abs() < 1e-9,
            "{:e}",
            found.inner()
        );
    }

    #[test]
    fn the_wave_speed_of_a_thin_tube_is_of_moens_and_korteweg() {
        // Held along its axis: c² = E h/(2 ρ r (1 - ν²)); the tube of `pulse-wave`.
        for nu in [0.0, 0.3, 0.45] {
            let material = Material::SaintVenantKirchhoff {
                youngs_modulus: 6e5,
                poisson_ratio: nu,
                viscosity: None,
            };
            let h = 0.025e-3;
            let law = tube(&[(material, [5e-3, 5e-3 + h])]);
            let expected = (6e5 * h / (2.0 * 1000.0 * 5e-3 * (1.0 - nu * nu))).sqrt();
            let error = law.wave_speed(0.0, 1000.0).unwrap() / expected - 1.0;
            // Half of h/r
            assert!(error.abs() < 4e-3, "{nu}: {error:e}");
        }
    }
}
