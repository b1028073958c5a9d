//! Walls from files: hexahedra of any order with named regions and surfaces.
//!
//! Each format has a file with a function that makes a [`WallFile`] of a text; from there on all are alike.

mod abaqus;
mod gmsh;
mod lattice;
mod vtu;

use super::is_a_place;
use super::{HexFace, HexMesh, HexShape, WallDirections};
use crate::Vec3;
use crate::files::{Fault, FileError, fault, read_regular};
use lattice::Lattice;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;
use std::sync::Arc;

/// Far larger than any wall that can be computed.
const MOST_BYTES: u64 = 4 << 30;

/// What a file says of a wall, with lengths in its own unit.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WallFile {
    /// Positions of the nodes.
    nodes: Vec<Vec3>,
    /// Hexahedra.
    hexes: Vec<FileHex>,
    /// Names of the regions.
    pub regions: Vec<String>,
    /// Faces by the names of their surfaces, each by its corners in any order.
    surfaces: BTreeMap<String, BTreeSet<[usize; 4]>>,
    /// Directions along the wall and around it in each hexahedron, where the file has both.
    directions: Option<Vec<[Vec3; 2]>>,
}

/// A hexahedron of a file.
#[derive(Debug, Clone, PartialEq)]
struct FileHex {
    nodes: Lattice,
    /// Index of its region.
    region: usize,
    /// Its number in the file.
    label: String,
}

impl WallFile {
    /// Reads a file by the end of its name: `.msh`, `.inp` or `.vtu`.
    ///
    /// # Errors
    /// What of it is not understood, with the line.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let wrong = |fault: Fault| FileError::new(path, fault);
        let end = path
            .extension()
            .and_then(|end| end.to_str())
            .unwrap_or_default();
        let bytes =
            || read_regular(path, MOST_BYTES).map_err(|e| wrong(fault!("it cannot be read: {e}")));
        let file = match end.to_ascii_lowercase().as_str() {
            "msh" => gmsh::read(&bytes()?),
            "inp" => abaqus::read(path),
            _ => vtu::read(path),
        };
        let mut file = file.map_err(wrong)?;
        if file.hexes.is_empty() {
            return Err(wrong("it has no hexahedra".into()));
        }
        if let Some(node) = file.nodes.iter().position(|x| !is_a_place(x)) {
            let x = file.nodes[node];
            return Err(wrong(fault!(
                "node {node} of its list is at {:?}",
                [x.x, x.y, x.z]
            )));
        }
        file.turn_right_handed();
        file.refuse_folded().map_err(wrong)?;
        Ok(file)
    }

    /// # Errors
    /// Which hexahedron has its corners in another order than the format wants, or is there twice.
    fn refuse_folded(&self) -> Result<(), Fault> {
        const GAUSS: [f64; 2] = [-0.577_350_269_189_625_8, 0.577_350_269_189_625_8];
        const STEP: f64 = 1e-5;
        let mut known: HashMap<Vec<usize>, &str> = HashMap::new();
        for hex in &self.hexes {
            let nodes: Vec<Vec3> = hex
                .nodes
                .nodes
                .iter()
                .map(|&node| self.nodes[node])
                .collect();
            let position = |xi: [f64; 3]| interpolated(hex.nodes.order, &nodes, xi);
            let around = (0..8).map(|corner| [0, 1, 2].map(|d| GAUSS[corner >> d & 1]));
            for xi in around.chain([[0.0; 3]]) {
                let tangent = |d: usize| {
                    let at = |step: f64| {
                        let mut xi = xi;
                        xi[d] += step;
                        position(xi)
                    };
                    (at(STEP) - at(-STEP)) / (2.0 * STEP)
                };
                let [a, b, c] = [tangent(0), tangent(1), tangent(2)];
                if a.cross(&b).dot(&c) <= 1e-9 * a.norm() * b.norm() * c.norm() {
                    let x = position([0.0; 3]);
                    return Err(fault!(
                        "the hexahedron {} around ({}, {}, {}) is folded or flat: are its nodes in the order of the format, the \
                         corners around the bottom and then above them?",
                        hex.label,
                        x.x,
                        x.y,
                        x.z
                    ));
                }
            }
            let mut nodes = hex.nodes.nodes.clone();
            nodes.sort_unstable();
            if let Some(other) = known.insert(nodes, &hex.label) {
                return Err(fault!(
                    "the hexahedra {other} and {} have the same nodes: is a part there twice?",
                    hex.label
                ));
            }
        }
        Ok(())
    }

    /// Index of the region of this name, which is added if it is new.
    fn region(&mut self, name: &str) -> usize {
        let known = self.regions.iter().position(|region| region == name);
        known.unwrap_or_else(|| {
            self.regions.push(name.to_owned());
            self.regions.len() - 1
        })
    }

    fn add_face(&mut self, surface: &str, corners: [usize; 4]) {
        let faces = self.surfaces.entry(surface.to_owned()).or_default();
        faces.insert(sorted(corners));
    }

    /// Hexahedra of meshes that were mirrored or swept backwards.
    fn turn_right_handed(&mut self) {
        for hex in &mut self.hexes {
            let at = |corner: usize| self.nodes[hex.nodes.corner(corner)];
            let edge = |bit: usize| at(1 << bit) - at(0);
            if edge(0).cross(&edge(1)).dot(&edge(2)) < 0.0 {
                hex.nodes = hex.nodes.mirrored();
            }
        }
    }

    /// The wall with lengths in units of `unit` (m); `material` tells the region of the structure for a name. The
    /// surfaces `wet` become one, called so.
    ///
    /// # Errors
    /// What does not fit together.
    pub fn mesh(
        &self,
        unit: f64,
        wet: &[String],
        material: impl Fn(&str) -> Result<usize, Fault>,
    ) -> Result<HexMesh, Fault> {
        let regions = self.regions.iter().map(|name| material(name));
        let regions = regions.collect::<Result<Vec<usize>, Fault>>()?;
        let mut numbers: HashMap<usize, usize> = HashMap::new();
        let mut vertices = Vec::new();
        let mut hexes = Vec::new();
        let mut sides: HashMap<[usize; 4], (usize, HexFace)> = HashMap::new();
        for (element, hex) in self.hexes.iter().enumerate() {
            hexes.push(std::array::from_fn(|corner| {
                let node = hex.nodes.corner(corner);
                *numbers.entry(node).or_insert_with(|| {
                    vertices.push(self.nodes[node] * unit);
                    vertices.len() - 1
                })
            }));
            for axis in 0..3u8 {
                for upper in [false, true] {
                    let face = HexFace { axis, upper };
                    sides.insert(sorted(hex.nodes.face(face)), (element, face));
                }
            }
        }
        let surfaces = self.surfaces(&sides, wet)?;
        let nodes = self.hexes.iter().map(|hex| {
            let nodes = hex.nodes.nodes.iter().map(|&node| self.nodes[node] * unit);
            (hex.nodes.order, nodes.collect())
        });
        Ok(HexMesh {
            vertices,
            hexes,
            regions: self.hexes.iter().map(|hex| regions[hex.region]).collect(),
            surfaces,
            directions: (self.directions.clone())
                .map_or(WallDirections::Local, WallDirections::Given),
            shape: Arc::new(FileShape {
                nodes: nodes.collect(),
            }),
        })
    }

    /// Sides of elements by surface, from the `sides` with given corners; those of `wet` once more, as [`WET`].
    fn surfaces(
        &self,
        sides: &HashMap<[usize; 4], (usize, HexFace)>,
        wet: &[String],
    ) -> Result<Surfaces, Fault> {
        let mut surfaces: Surfaces = BTreeMap::new();
        for (name, faces) in &self.surfaces {
            let found: Option<Vec<_>> = faces.iter().map(|face| sides.get(face).copied()).collect();
            let found = found.ok_or_else(|| {
                format!("a face of the surface {name:?} is not the face of any hexahedron: mesh surfaces and volumes together")
            })?;
            surfaces.insert(name.clone(), found);
        }
        let known = || surfaces.keys().cloned().collect::<Vec<_>>().join("\", \"");
        let mut all_wet = Vec::new();
        for name in wet {
            let alike = |(known, _): &(&String, _)| known.eq_ignore_ascii_case(name);
            let faces = (surfaces.get(name))
                .or_else(|| surfaces.iter().find(alike).map(|(_, faces)| faces))
                .ok_or_else(|| format!("it has no surface {name:?}; it has \"{}\"", known()))?;
            all_wet.extend_from_slice(faces);
        }
        all_wet.sort_unstable();
        all_wet.dedup();
        surfaces.insert(WET.into(), all_wet);
        Ok(surfaces)
    }
}

/// Sides of elements by the name of their surface.
type Surfaces = BTreeMap<String, Vec<(usize, HexFace)>>;

/// Name of the surface that the fluid touches.
pub const WET: &str = "wet surface";

fn sorted(mut corners: [usize; 4]) -> [usize; 4] {
    corners.sort_unstable();
    corners
}

/// Lagrange's interpolation of the nodes of each element.
struct FileShape {
    nodes: Vec<(usize, Vec<Vec3>)>,
}

impl HexShape for FileShape {
    fn position(&self, element: usize, xi: [f64; 3]) -> Vec3 {
        let (order, nodes) = &self.nodes[element];
        interpolated(*order, nodes, xi)
    }
}

/// Lagrange's interpolation of the nodes of an element at local coordinates.
fn interpolated(order: usize, nodes: &[Vec3], xi: [f64; 3]) -> Vec3 {
    let places = super::extruded::equidistant(order);
    let values = xi.map(|x| crate::lagrange::values(&places, x));
    let n = order + 1;
    let weighted = nodes
        .iter()
        .enumerate()
        .map(|(p, x)| x * (values[0][p % n] * values[1][p / n % n] * values[2][p / (n * n)]));
    weighted.sum()
}

#[cfg(test)]
mod tests;
