//! The file of `fsi-driver solid`: a tube, its discretization and its load. In the file every name carries its unit;
//! in these types all values are SI. All mistakes of a file are reported at once.

mod keys;
mod plausibility;

use super::motion::Dynamics;
use super::tube::{Surrounding, Tube, TubeEnds, TubeGrid};
use crate::case::schema::Schema;
use crate::case::source::{self, Base, CaseValue};
use crate::case::stack::Stack;
use crate::case::{CaseErrors, Material};
use crate::pfem::Space;
use crate::pfem::discretization::Options;
use crate::pfem::element::mapping::MappingKind;
use crate::pfem::element::surface::LoadKind;
use crate::pfem::solution::stability::AtBifurcation;
use keys::Keys;
use std::path::Path;
use std::sync::LazyLock;
use toml::Value;

/// Load steps to begin with.
const STEPS: usize = 10;

/// A tube with everything that its analysis needs.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidFile {
    /// Inner radius, m.
    pub inner_radius: f64,
    /// Length, m.
    pub length: f64,
    /// Layers from the inside out: thickness (m) and material.
    pub layers: Vec<(f64, Material)>,
    /// Elements.
    pub grid: TubeGrid,
    /// Space, mapping and quadrature.
    pub options: Options,
    /// Pressure inside, Pa.
    pub pressure: f64,
    /// On which area.
    pub kind: LoadKind,
    /// Load steps to begin with.
    pub steps: usize,
    /// What to do where the tube loses its stability.
    pub at_bifurcation: AtBifurcation,
    /// What holds the ends.
    pub ends: TubeEnds,
    /// Stiffness of ends on springs, Pa/m.
    pub end_spring: f64,
    /// Length between the ends relative to the unloaded one.
    pub axial_stretch: f64,
    /// What surrounds the tube.
    pub outside: Surrounding,
    /// The load over time; static if absent.
    pub dynamics: Option<Dynamics>,
}

impl SolidFile {
    /// All keys of a file.
    pub fn schema() -> &'static Schema {
        static SCHEMA: LazyLock<Schema> = LazyLock::new(Schema::of::<Keys>);
        &SCHEMA
    }

    /// Reads and checks a file.
    ///
    /// # Errors
    /// All mistakes at once, each with file, line, key, what was found and what is allowed.
    pub fn load(file: &Path) -> Result<Self, CaseErrors> {
        let mut errors = Vec::new();
        let source = source::read(file, "docs/solid.toml is an example", &mut errors);
        let readable = errors.is_empty();
        let mut entries = source.plain;
        // What a case may have and this file may not.
        entries.extend(source.extends.map(|(base, place)| CaseValue {
            key: "extends".into(),
            value: match base {
                Base::File(path) => path.display().to_string().into(),
                Base::Defaults => "defaults".into(),
            },
            place,
            folder: Default::default(),
        }));
        entries.extend(source.presets.into_iter().map(|(name, entry)| CaseValue {
            key: format!("preset.{name}.{}", entry.key),
            ..entry
        }));
        let mut stack = Stack::new(Self::schema(), source::tables(&entries));
        stack.lay(entries, &mut errors);
        stack.sort_out_choices(&mut errors);
        if readable {
            stack.require_all(file, &mut errors);
        }
        if errors.is_empty()
            && let Some(keys) = stack.build::<Keys>(file, &mut errors)
        {
            let solid = Self::from(keys);
            plausibility::check(&solid, &stack, &mut errors);
            if errors.is_empty() {
                return Ok(solid);
            }
        }
        Err(CaseErrors(errors))
    }

    /// Radii of the inner surface, the interfaces and the outer surface, m.
    pub fn radii(&self) -> Vec<f64> {
        let mut radii = vec![self.inner_radius];
        for (thickness, _) in &self.layers {
            radii.push(radii[radii.len() - 1] + thickness);
        }
        radii
    }

    /// The tube under its full load.
    pub fn tube(&self) -> Tube {
        Tube::circular(
            self.inner_radius,
            self.length,
            &self.layers,
            self.grid,
            self.ends,
        )
        .on_springs(self.ends, self.end_spring)
        .loaded(self.pressure, self.kind)
        .stretched(self.axial_stretch)
        .surrounded(&self.outside)
    }
}

impl From<Keys> for SolidFile {
    fn from(keys: Keys) -> Self {
        let space = Space {
            kind: keys.space.kind,
            degrees: keys.space.p,
        };
        Self {
            inner_radius: keys.tube.inner_radius,
            length: keys.tube.length,
            grid: TubeGrid {
                axial: keys.mesh.axial,
                circumferential: keys.mesh.circumferential,
                radial_per_layer: keys.mesh.radial_per_layer,
                layers: keys.tube.layer.len(),
            },
            layers: (keys.tube.layer.into_iter())
                .map(|layer| (layer.thickness, layer.material))
                .collect(),
            options: Options {
                space,
                mapping: match keys.space.p_geometry {
                    Some(Value::Integer(degree)) => MappingKind::Blended(degree as usize),
                    Some(_) => MappingKind::Exact,
                    None => MappingKind::Blended(space.max_degree()),
                },
                quadrature_points: match keys.space.quadrature_points {
                    Some(points) => [points; 3],
                    None => space.degrees.map(|p| p + 2),
                },
                formulation: keys.space.formulation,
                ..Options::new(space)
            },
            pressure: keys.load.pressure,
            kind: keys.load.kind,
            steps: keys.load.steps.unwrap_or(STEPS),
            at_bifurcation: keys.load.at_bifurcation.unwrap_or_default(),
            ends: (keys.supports.as_ref()).map_or(TubeEnds::default(), |held| held.ends),
            end_spring: (keys.supports.as_ref())
                .and_then(|held| held.spring)
                .unwrap_or(0.0),
            axial_stretch: (keys.supports.as_ref())
                .and_then(|held| held.axial_stretch)
                .unwrap_or(1.0),
            outside: keys
                .outside
                .map_or(Surrounding::default(), |outside| Surrounding {
                    spring: outside.spring.unwrap_or(0.0),
                    damping: outside.damping.unwrap_or(0.0),
                    pressure: outside.pressure.unwrap_or(0.0),
                }),
            dynamics: keys.dynamics.map(|dynamics| Dynamics {
                density: dynamics.density,
                damping: dynamics.damping,
                step: dynamics.step,
                steps: (dynamics.end / dynamics.step).round() as usize,
                times: dynamics.times,
                factors: dynamics.load_factors,
            }),
        }
    }
}
