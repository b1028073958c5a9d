//! The wall that the instances of an Abaqus model make together.

use super::super::gmsh::weighted;
use super::super::lattice::{Lattice, VTK};
use super::super::{FileHex, WallFile};
use super::part::{Instance, Label, Part};
use super::{Model, Vec3};
use crate::files::{Fault, fault};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Corners of the faces S1 to S6.
#[rustfmt::skip]
const FACES: [[usize; 4]; 6] = [
    [0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0],
];
/// Where VTK's nodes after the twentieth stand in C3D27: the middles of the faces S6, S4, S3, S5, S1, S2, then that of
/// the volume, which is the first of them.
const MIDDLES: [usize; 7] = [26, 24, 23, 25, 21, 22, 20];

pub fn of(mut model: Model) -> Result<WallFile, Fault> {
    // A file without instances is one.
    let is_flat = model.instances.is_empty();
    if is_flat {
        let mut part = std::mem::take(&mut model.top);
        if part.solids.is_empty()
            && let [(_, only)] = &mut model.parts[..]
        {
            part = std::mem::take(only);
        }
        model.instances.push(Instance {
            name: String::new(),
            part,
            translation: Vec3::zeros(),
            rotation: None,
            lines: 0,
        });
    }
    let mut wall = Wall::default();
    for (index, instance) in model.instances.iter().enumerate() {
        wall.add(index, instance, is_flat || model.instances.len() == 1)?;
    }
    for (index, instance) in model.instances.iter().enumerate() {
        let part = &instance.part;
        for (name, of, side, place) in &part.surfaces {
            let members = members(part, of)
                .ok_or_else(|| format!("{place}: there is no set of elements {of:?}"))?;
            wall.add_faces(name, *side, members.into_iter().map(|tag| (index, tag)));
        }
        for (name, tags) in &part.element_sets.0 {
            let quads = tags.iter().filter_map(|tag| part.quads.get(tag));
            for corners in quads {
                wall.add_quad(name, corners[..4].iter().map(|tag| (index, *tag)))?;
            }
        }
        for (name, tags) in &part.node_sets.0 {
            wall.add_nodes(name, tags.iter().map(|tag| (index, *tag)));
        }
    }
    for (name, of, side, place) in &model.surfaces {
        let members = model.found(of, false);
        if members.is_empty() {
            return Err(fault!("{place}: there is no set of elements {of:?}"));
        }
        wall.add_faces(name, *side, members);
    }
    for (name, labels) in &model.node_sets.0 {
        wall.add_nodes(name, labels.iter().copied());
    }
    for (name, labels) in &model.element_sets.0 {
        for &(index, tag) in labels {
            let instance = model.instances.get(index);
            if let Some(corners) = instance.and_then(|i| i.part.quads.get(&tag)) {
                wall.add_quad(name, corners[..4].iter().map(|node| (index, *node)))?;
            }
        }
    }
    Ok(wall.file)
}

/// An element by its number, or those of a set.
fn members(part: &Part, of: &str) -> Option<Vec<usize>> {
    match of.parse::<usize>() {
        Ok(tag) => Some(vec![tag]),
        Err(_) => part
            .element_sets
            .find(of)
            .map(|set| set.iter().copied().collect()),
    }
}

#[derive(Default)]
struct Wall {
    file: WallFile,
    /// Nodes by their labels, and by their places, so that parts that meet share them.
    nodes: HashMap<Label, usize>,
    places: HashMap<[u64; 3], usize>,
    corners: BTreeMap<Label, [usize; 8]>,
}

impl Wall {
    /// Nodes and hexahedra of an instance.
    fn add(&mut self, index: usize, instance: &Instance, is_only: bool) -> Result<(), Fault> {
        let part = &instance.part;
        let region_of = regions(part);
        // Nodes of parts that touch are one; a part itself is as it was written.
        let sizes = part.nodes.values().map(|x| x.amax());
        let size = sizes.fold(0.0, f64::max);
        let grid = 1e-7 * size.max(f64::MIN_POSITIVE);
        for (tag, x) in &part.nodes {
            let x = instance.place(x);
            let key = [x.x, x.y, x.z].map(|x| (x / grid).round() as i64 as u64);
            let known = self.places.get(&key).copied().filter(|_| !is_only);
            let node = known.unwrap_or_else(|| {
                self.file.nodes.push(x);
                self.file.nodes.len() - 1
            });
            self.places.insert(key, node);
            self.nodes.insert((index, *tag), node);
        }
        for (tag, listed) in &part.solids {
            let known = listed.iter().map(|node| {
                let known = self.nodes.get(&(index, *node)).copied();
                known.ok_or_else(|| {
                    fault!("the element {tag} has the node {node}, which there is not")
                })
            });
            let known = known.collect::<Result<Vec<usize>, Fault>>()?;
            let corners = known
                .first_chunk()
                .ok_or_else(|| format!("the element {tag} has no eight corners"))?;
            self.corners.insert((index, *tag), *corners);
            let region = region_of.get(tag).copied().unwrap_or_default();
            let region = self.file.region(region);
            let nodes = match known.len() {
                27 => {
                    let mut all = known[..20].to_vec();
                    all.extend(MIDDLES.map(|place| known[place]));
                    Lattice::full(2, &all, &VTK)
                }
                20 => {
                    let positions = &mut self.file.nodes;
                    Lattice::serendipity(&known, &VTK, |weights| weighted(positions, weights))
                }
                _ => Lattice::full(1, &known, &VTK),
            };
            let label = match instance.name.as_str() {
                "" => tag.to_string(),
                name => format!("{name}.{tag}"),
            };
            self.file.hexes.push(FileHex {
                nodes,
                region,
                label,
            });
        }
        Ok(())
    }

    fn add_faces(&mut self, name: &str, side: usize, members: impl IntoIterator<Item = Label>) {
        for label in members {
            if let Some(corners) = self.corners.get(&label) {
                self.file.add_face(name, FACES[side].map(|v| corners[v]));
            }
        }
    }

    fn add_quad(&mut self, name: &str, corners: impl Iterator<Item = Label>) -> Result<(), Fault> {
        let corners: Option<Vec<usize>> = corners
            .map(|label| self.nodes.get(&label).copied())
            .collect();
        let corners = corners.as_deref().and_then(<[usize]>::first_chunk);
        let corners =
            corners.ok_or_else(|| format!("a face of {name:?} has a node that there is not"))?;
        self.file.add_face(name, *corners);
        Ok(())
    }

    /// A set of nodes is a surface of the faces of which it has all corners.
    fn add_nodes(&mut self, name: &str, members: impl Iterator<Item = Label>) {
        let members: BTreeSet<usize> = members
            .filter_map(|label| self.nodes.get(&label).copied())
            .collect();
        for corners in self.corners.values() {
            for face in FACES.map(|face| face.map(|v| corners[v])) {
                if face.iter().all(|corner| members.contains(corner)) {
                    self.file.add_face(name, face);
                }
            }
        }
    }
}

/// The region of each element: the material of its section, or the last set that it is in.
fn regions(part: &Part) -> HashMap<usize, &str> {
    let mut region_of: HashMap<usize, &str> = HashMap::new();
    let of_sets = part
        .element_sets
        .0
        .iter()
        .map(|(name, members)| (name.as_str(), members));
    let sections = part.sections.iter();
    let of_sections = sections
        .filter_map(|(set, material)| Some((material.as_str(), part.element_sets.find(set)?)));
    for (name, members) in of_sets.chain(of_sections) {
        region_of.extend(members.iter().map(|tag| (*tag, name)));
    }
    region_of
}
