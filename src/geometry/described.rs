//! A vessel as the table `[vessel]` of a case describes it.

use super::Vessel;
use super::feature::{Bump, Feature};
use super::lumen::LumenTable;
use super::section::{Base, Section};
use crate::case::{Material, RIGID_SHARE, VesselDescription, VesselSection};
use crate::interpolation::MonotoneCubic;

/// Material of a wall that is rigid throughout: nothing strains it.
pub const ANY: Material = Material::SaintVenantKirchhoff {
    youngs_modulus: 1e6,
    poisson_ratio: 0.0,
    viscosity: None,
};

impl Vessel {
    /// Along any path, of any sections.
    pub(super) fn described(keys: &VesselDescription) -> Self {
        let curve = keys.curve();
        let length = curve.ends()[1];
        let places = keys.places(length);
        let of_section = keys.section.iter().zip(&places);
        let evaluated = of_section
            .clone()
            .find(|(section, _)| keys.is_evaluated(section));
        let start = evaluated.map_or(0.0, |(_, place)| place[0]);
        let vessel_law = keys.radius_law(&curve).shifted(-start);
        let layers = keys.section.iter().map(|section| section.layers.len());
        let layers = layers.max().unwrap_or(0);

        let section = |(keys_of, place): (&VesselSection, &[f64; 2])| {
            let law = keys_of
                .radius
                .map_or(vessel_law.clone(), MonotoneCubic::constant);
            let [from, to] = place.map(|s| s - start);
            let (surfaces, materials) = wall(keys, keys_of, law.mean(from, to), layers);
            Section {
                name: keys_of.name.clone(),
                from,
                to,
                is_elastic: keys.is_evaluated(keys_of),
                blend: keys.blend_length.unwrap_or(2.0 * law.at(from)),
                base: Base::Lumen(law),
                surfaces,
                materials,
            }
        };
        let mut sections: Vec<Section> = of_section.map(section).collect();
        share_thickness(&mut sections);
        add_tubes(keys, &mut sections);
        let bumps = keys.feature.iter().flatten();
        let bumps = bumps.map(|feature| Feature::Bump(Bump::new(feature)));
        let (materials, names) = match keys.is_rigid() {
            true => (vec![ANY], vec!["rigid".into()]),
            false => (keys.materials().iter())
                .map(|named| (named.material.clone(), named.name.clone()))
                .unzip(),
        };
        let lumen = !keys.lumen_radii.is_empty();
        let lumen = lumen.then(|| LumenTable::new(&keys.lumen_radii, [-start, length - start]));
        Self {
            line: curve.counted_from(start),
            sections,
            features: lumen.map(Feature::Lumen).into_iter().chain(bumps).collect(),
            materials,
            names,
            counts_radii: true,
        }
    }
}

/// A rigid wall has the thickness of its elastic neighbour, so that joints keep that.
fn share_thickness(sections: &mut [Section]) {
    for i in (1..sections.len()).rev() {
        if sections[i - 1].surfaces.len() == 1 {
            sections[i - 1].surfaces = sections[i].surfaces.clone();
        }
    }
    for i in 1..sections.len() {
        if sections[i].surfaces.len() == 1 {
            sections[i].surfaces = sections[i - 1].surfaces.clone();
        }
    }
}

/// Rigid tubes upstream and downstream of the vessel that is described.
fn add_tubes(keys: &VesselDescription, sections: &mut Vec<Section>) {
    let tube = |name: &str, [from, to]: [f64; 2], joint: f64, like: &Section| Section {
        name: name.into(),
        from,
        to,
        is_elastic: false,
        base: Base::Lumen(MonotoneCubic::constant(like.surface(0, joint))),
        materials: Vec::new(),
        blend: 0.0,
        surfaces: like.surfaces.clone(),
    };
    if let Some(long) = keys.upstream.filter(|long| *long > 0.0) {
        let from = sections[0].from;
        let upstream = tube("upstream", [from - long, from], from, &sections[0]);
        sections.insert(0, upstream);
        sections[1].blend = 0.0;
    }
    if let Some(long) = keys.downstream.filter(|long| *long > 0.0) {
        let last = &sections[sections.len() - 1];
        let downstream = tube("downstream", [last.to, last.to + long], last.to, last);
        sections.push(downstream);
    }
}

/// Distances of a section's surfaces from its lumen, and the materials between them, in so many `layers`: of a wall
/// with fewer the thickest one is split.
fn wall(
    keys: &VesselDescription,
    section: &VesselSection,
    mean_radius: f64,
    layers: usize,
) -> (Vec<f64>, Vec<usize>) {
    if keys.is_rigid() {
        return (vec![0.0, RIGID_SHARE * mean_radius], vec![0]);
    }
    if section.layers.is_empty() {
        return (vec![0.0], Vec::new());
    }
    let of_radius = section.shares.iter().map(|share| share * mean_radius);
    let thicknesses: Vec<f64> = section
        .thicknesses
        .iter()
        .copied()
        .chain(of_radius)
        .collect();
    let mut parts = vec![1; thicknesses.len()];
    for _ in thicknesses.len()..layers {
        let thickness = |i: &usize| thicknesses[*i] / parts[*i] as f64;
        let thickest = (0..parts.len())
            .rev()
            .max_by(|a, b| thickness(a).total_cmp(&thickness(b)));
        parts[thickest.unwrap_or(0)] += 1;
    }
    let (mut surfaces, mut materials, mut from) = (vec![0.0], Vec::new(), 0.0);
    for ((thickness, parts), name) in thicknesses.iter().zip(parts).zip(&section.layers) {
        let named = keys
            .materials()
            .iter()
            .position(|known| known.name == *name);
        for part in 1..=parts {
            surfaces.push(from + thickness * part as f64 / parts as f64);
            materials.push(named.unwrap_or(0));
        }
        from += thickness;
    }
    (surfaces, materials)
}
