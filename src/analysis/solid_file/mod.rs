//! The file of `fsi-driver solid`: a tube, its discretization and its load. In the file every name carries its unit;
//! in these types all values are SI. All mistakes of a file are reported at once.

mod keys;
mod sense;

use super::motion::Dynamics;
use super::tube::{Ends, Grid, Tube};
use crate::case::source::{self, Entry};
use crate::case::value::{self, shorten};
use crate::case::{CaseError, CaseErrors, Material, schema, spelling};
use crate::pfem::discretization::Options;
use crate::pfem::mapping::MappingKind;
use crate::pfem::surface::LoadKind;
use crate::pfem::{Space, SpaceKind};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use toml::Value;

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
    pub grid: Grid,
    /// Space, mapping and quadrature.
    pub options: Options,
    /// Pressure inside, Pa.
    pub pressure: f64,
    /// On which area.
    pub kind: LoadKind,
    /// Load steps to begin with.
    pub steps: usize,
    /// What holds the ends.
    pub ends: Ends,
    /// The load over time; static if absent.
    pub dynamics: Option<Dynamics>,
}

impl SolidFile {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// All mistakes at once, each with file, line, key, what was found and what is allowed.
    pub fn load(file: &Path) -> Result<Self, CaseErrors> {
        let mut errors = Vec::new();
        let values = Values::read(file, &mut errors);
        if !errors.is_empty() {
            return Err(CaseErrors(errors));
        }
        let solid = values.build();
        sense::check(&solid, &values, &mut errors);
        if errors.is_empty() {
            Ok(solid)
        } else {
            Err(CaseErrors(errors))
        }
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
        .loaded(self.pressure, self.kind)
    }
}

/// Checked values by their dotted paths; complete unless errors were reported.
struct Values {
    entries: BTreeMap<String, Entry>,
    layers: usize,
    /// Whether there is a table `[dynamics]`.
    is_dynamic: bool,
}

impl Values {
    fn read(file: &Path, errors: &mut Vec<CaseError>) -> Self {
        let source = source::read(file, "docs/solid.toml is an example", errors);
        let readable = errors.is_empty();
        let mut found = source.plain;
        // What a case may have and this file may not.
        if let Some((path, place)) = source.extends {
            let value = Value::String(path.display().to_string());
            found.push(Entry {
                key: "extends".into(),
                value,
                place,
                folder: Default::default(),
            });
        }
        found.extend(source.presets.into_iter().map(|(name, entry)| Entry {
            key: format!("preset.{name}.{}", entry.key),
            ..entry
        }));
        let mut values = Self {
            entries: BTreeMap::new(),
            layers: 0,
            is_dynamic: false,
        };
        let mut refused = BTreeSet::new();
        for entry in found {
            // A dot, so that an empty table is one of its kind.
            let path = entry.key.clone();
            let table = format!("{path}.");
            let empty = entry.value.as_table().is_some_and(|table| table.is_empty());
            values.is_dynamic |= table.starts_with("dynamics.");
            if let Some((index, _)) = keys::in_layer(&table) {
                values.layers = values.layers.max(index + 1);
            }
            if empty
                && keys::alternatives(&table)
                    .iter()
                    .any(|key| key.starts_with(&table))
            {
                continue;
            }
            let checked = match keys::find(&path) {
                Some(key) => value::check(entry, key, errors),
                None => {
                    errors.push(CaseError::UnknownKey {
                        suggestion: spelling::suggest(&path, &keys::alternatives(&path)),
                        place: entry.place,
                        key: entry.key,
                    });
                    None
                }
            };
            match checked {
                Some(entry) => drop(values.entries.insert(path, entry)),
                None => drop(refused.insert(path)),
            }
        }
        values.check_parameters(errors);
        if readable {
            values.require(file, &refused, errors);
        }
        values
    }

    /// A layer has the parameters of its material and no others.
    fn check_parameters(&self, errors: &mut Vec<CaseError>) {
        for (path, entry) in &self.entries {
            let Some((layer, name)) = keys::in_layer(path) else {
                continue;
            };
            let Some(material) = self.material(layer) else {
                continue;
            };
            let known = schema::parameters(material);
            if ["material", "thickness_m"].contains(&name) || known.iter().any(|k| k.path == name) {
                continue;
            }
            let names: Vec<&str> = known.iter().map(|key| key.path).collect();
            errors.push(CaseError::Nonsense {
                place: entry.place.clone(),
                key: path.clone(),
                found: shorten(&entry.value),
                message: format!(
                    "{material} has no such parameter; it has {}",
                    names.join(", ")
                ),
            });
        }
    }

    /// Every key needs a value, but for the optional ones.
    fn require(&self, file: &Path, refused: &BTreeSet<String>, errors: &mut Vec<CaseError>) {
        let mut require = |path: String, key: &schema::Key| {
            if !self.entries.contains_key(&path) && !refused.contains(&path) {
                errors.push(CaseError::Missing {
                    file: file.to_owned(),
                    key: path,
                    allowed: key.kind.to_string(),
                    about: key.about.to_owned(),
                });
            }
        };
        let dynamic = self.is_dynamic;
        for key in keys::KEYS {
            if !key.optional || dynamic && keys::DYNAMICS.contains(&key.path) {
                require(key.path.to_owned(), key);
            }
        }
        for layer in 0..self.layers.max(1) {
            let own = self.material(layer).map_or(&[][..], schema::parameters);
            for key in [&keys::THICKNESS, &schema::MATERIAL].into_iter().chain(own) {
                if !key.optional {
                    require(format!("{}[{layer}].{}", keys::LAYER, key.path), key);
                }
            }
        }
    }

    fn value(&self, path: &str) -> Option<&Value> {
        self.entries.get(path).map(|entry| &entry.value)
    }

    fn material(&self, layer: usize) -> Option<&str> {
        self.value(&format!("{}[{layer}].material", keys::LAYER))?
            .as_str()
    }

    fn real(&self, path: &str) -> f64 {
        self.value(path).and_then(Value::as_float).unwrap_or(0.0)
    }

    fn whole(&self, path: &str) -> Option<usize> {
        self.value(path)?.as_integer().map(|i| i as usize)
    }

    fn is(&self, path: &str, word: &str) -> bool {
        self.value(path).and_then(Value::as_str) == Some(word)
    }

    fn numbers(&self, path: &str) -> Vec<f64> {
        let values = self.value(path).and_then(Value::as_array);
        let numbers = values.into_iter().flatten().filter_map(Value::as_float);
        numbers.collect()
    }

    fn layer(&self, index: usize) -> Option<(f64, Material)> {
        let mut table = toml::Table::new();
        for (path, entry) in &self.entries {
            match keys::in_layer(path) {
                Some((layer, name)) if layer == index && name != "thickness_m" => {
                    table.insert(name.to_owned(), entry.value.clone());
                }
                _ => {}
            }
        }
        let thickness = self.real(&format!("{}[{index}].thickness_m", keys::LAYER));
        Some((thickness, table.try_into().ok()?))
    }

    /// The typed form of a complete set of values.
    fn build(&self) -> SolidFile {
        let degrees = self.value("space.p").and_then(Value::as_array);
        let degrees: Vec<usize> = degrees
            .into_iter()
            .flatten()
            .filter_map(|p| p.as_integer().map(|p| p as usize))
            .collect();
        let space = Space {
            kind: match self.is("space.kind", "trunk") {
                true => SpaceKind::Trunk,
                false => SpaceKind::TensorProduct,
            },
            degrees: std::array::from_fn(|d| degrees.get(d).copied().unwrap_or(1)),
        };
        let mapping = match self.whole("space.p_geometry") {
            Some(degree) => MappingKind::Blended(degree),
            None if self.is("space.p_geometry", "exact") => MappingKind::Exact,
            None => MappingKind::Blended(space.max_degree()),
        };
        let points = self.whole("space.quadrature_points");
        let layers: Vec<_> = (0..self.layers).filter_map(|i| self.layer(i)).collect();
        let count = |path: &str| self.whole(path).unwrap_or(1);
        SolidFile {
            inner_radius: self.real("tube.inner_radius_m"),
            length: self.real("tube.length_m"),
            grid: Grid {
                axial: count("mesh.axial"),
                circumferential: count("mesh.circumferential"),
                radial_per_layer: count("mesh.radial_per_layer"),
                layers: layers.len(),
            },
            layers,
            options: Options {
                space,
                mapping,
                quadrature_points: match points {
                    Some(points) => [points; 3],
                    None => space.degrees.map(|p| p + 2),
                },
            },
            pressure: self.real("load.pressure_Pa"),
            kind: match self.is("load.kind", "dead") {
                true => LoadKind::Dead,
                false => LoadKind::Follower,
            },
            steps: self.whole("load.steps").unwrap_or(10),
            ends: match self.is("supports.ends", "clamped") {
                true => Ends::Clamped,
                false => Ends::Axial,
            },
            dynamics: self.is_dynamic.then(|| self.dynamics()),
        }
    }

    fn dynamics(&self) -> Dynamics {
        let step = self.real("dynamics.step_s");
        Dynamics {
            density: self.real("dynamics.density_kg_m3"),
            damping: self.real("dynamics.damping_1_s"),
            step,
            steps: (self.real("dynamics.end_s") / step).round() as usize,
            times: self.numbers("dynamics.times_s"),
            factors: self.numbers("dynamics.load_factors"),
        }
    }
}
