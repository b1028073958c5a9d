//! Gmsh's MSH of the versions 2 and 4.1, in ASCII or binary: hexahedra of the orders 1 to 3, physical groups as regions
//! and surfaces.

mod cursor;

use super::lattice::{GMSH, Lattice};
use super::{FileHex, WallFile};
use crate::Vec3;
use crate::files::{Fault, fault};
use cursor::Cursor;
use std::collections::{HashMap, HashSet};

/// Order and number of nodes of Gmsh's hexahedra by type; 20 nodes are of the second order.
const HEXAHEDRA: [(usize, usize, usize); 4] = [(5, 1, 8), (12, 2, 27), (17, 2, 20), (92, 3, 64)];
/// Gmsh's quadrilaterals by type.
const QUADRILATERALS: [usize; 4] = [3, 10, 16, 36];
/// Dimension and number of nodes of Gmsh's elements by type.
const ELEMENTS: [(usize, usize, usize); 35] = [
    (1, 1, 2),
    (2, 2, 3),
    (3, 2, 4),
    (4, 3, 4),
    (5, 3, 8),
    (6, 3, 6),
    (7, 3, 5),
    (8, 1, 3),
    (9, 2, 6),
    (10, 2, 9),
    (11, 3, 10),
    (12, 3, 27),
    (13, 3, 18),
    (14, 3, 14),
    (15, 0, 1),
    (16, 2, 8),
    (17, 3, 20),
    (18, 3, 15),
    (19, 3, 13),
    (20, 2, 9),
    (21, 2, 10),
    (22, 2, 12),
    (23, 2, 15),
    (24, 2, 15),
    (25, 2, 21),
    (26, 1, 4),
    (27, 1, 5),
    (28, 1, 6),
    (29, 3, 20),
    (30, 3, 35),
    (31, 3, 56),
    (36, 2, 16),
    (37, 2, 25),
    (38, 2, 36),
    (92, 3, 64),
];
/// Names of element data that hold the directions of fibres.
const DIRECTIONS: [&str; 2] = ["axial", "circumferential"];

/// What was read so far.
#[derive(Default)]
struct Reader {
    file: WallFile,
    /// Names of physical groups by dimension and number.
    names: HashMap<(usize, i64), String>,
    /// Physical groups of entities by dimension and number.
    groups: HashMap<(usize, i64), Vec<i64>>,
    nodes: HashMap<usize, usize>,
    /// Hexahedra by their numbers.
    elements: HashMap<usize, usize>,
    /// Nodes of the hexahedra, each once.
    known: HashSet<Vec<usize>>,
    directions: [HashMap<usize, Vec3>; 2],
}

pub fn read(bytes: &[u8]) -> Result<WallFile, Fault> {
    if bytes.trim_ascii_start().starts_with(b"<?xml") {
        return Err("this is XML, as SimVascular's description of a mesh, not a mesh of Gmsh: save the mesh itself as .vtu".into());
    }
    let mut cursor = Cursor::new(bytes);
    let mut reader = Reader::default();
    let mut version = None;
    while let Some(line) = cursor.text() {
        let Some(section) = line
            .strip_prefix('$')
            .filter(|word| !word.starts_with("End"))
        else {
            continue;
        };
        match (section, version) {
            ("MeshFormat", _) => version = Some(format(&mut cursor)?),
            ("Comments", _) => cursor.skip(section),
            (_, None) => break,
            ("PhysicalNames", _) => reader.physical_names(&mut cursor)?,
            ("Entities", Some(4)) => reader.entities(&mut cursor)?,
            ("Nodes", Some(4)) => reader.nodes_of_4(&mut cursor)?,
            ("Nodes", _) => reader.nodes_of_2(&mut cursor)?,
            ("Elements", Some(4)) => reader.elements_of_4(&mut cursor)?,
            ("Elements", _) => reader.elements_of_2(&mut cursor)?,
            ("ElementData", _) => reader.element_data(&mut cursor)?,
            (other, _) => cursor.skip(other),
        }
    }
    match version {
        None => Err("it has no $MeshFormat: expected a mesh of Gmsh, version 2.2 or 4.1".into()),
        Some(_) => reader.finish(),
    }
}

/// The version, 2 or 4.
fn format(cursor: &mut Cursor<'_>) -> Result<usize, Fault> {
    let line = cursor.text().unwrap_or_default();
    let mut words = line.split_whitespace();
    let version = words.next().unwrap_or_default().to_owned();
    let major = match version.as_str() {
        "4.1" => 4,
        "2" | "2.0" | "2.1" | "2.2" => 2,
        _ => {
            return Err(fault!(
                "it is of the version {version}: expected 2.2 or 4.1 (gmsh FILE -save -format msh41, or Mesh.MshFileVersion = 4.1)"
            ));
        }
    };
    if words.next() == Some("1") {
        cursor.is_binary = true;
        if words.next() != Some("8") {
            return Err(
                "its numbers are not of 8 bytes: save it in ASCII (Mesh.Binary = 0)".into(),
            );
        }
        if cursor.int()? != 1 {
            return Err(
                "its bytes are in the order of another machine: save it in ASCII (Mesh.Binary = 0)"
                    .into(),
            );
        }
    }
    Ok(major)
}

impl Reader {
    fn physical_names(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Fault> {
        // In words in any case.
        let count = cursor.text().and_then(|line| line.parse::<usize>().ok());
        let count = count.ok_or_else(|| cursor.wrong(&"expected the number of names"))?;
        for _ in 0..count {
            let line = cursor.text().unwrap_or_default();
            let mut parts = line.splitn(3, char::is_whitespace);
            let mut number = || parts.next().and_then(|word| word.parse::<i64>().ok());
            let (Some(dimension), Some(tag)) = (number(), number()) else {
                return Err(cursor.wrong(&format_args!(
                    "expected dimension, number and name of a group, found {line:?}"
                )));
            };
            let name = parts.next().unwrap_or_default().trim().trim_matches('"');
            self.names
                .insert((dimension.clamp(0, 3) as usize, tag), name.to_owned());
        }
        Ok(())
    }

    /// The physical groups of surfaces and volumes.
    fn entities(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Fault> {
        let counts = cursor.sizes::<4>()?;
        for (dimension, count) in counts.into_iter().enumerate() {
            for _ in 0..count {
                let tag = cursor.int()?;
                // The position of a point, the box around others.
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    cursor.real()?;
                }
                let mut physical = Vec::new();
                for _ in 0..cursor.size()? {
                    physical.push(cursor.int()?.abs());
                }
                self.groups.insert((dimension, tag), physical);
                if dimension > 0 {
                    for _ in 0..cursor.size()? {
                        cursor.int()?;
                    }
                }
            }
        }
        cursor.end_line();
        Ok(())
    }

    fn add_node(&mut self, tag: usize, [x, y, z]: [f64; 3]) {
        self.nodes.insert(tag, self.file.nodes.len());
        self.file.nodes.push(Vec3::new(x, y, z));
    }

    fn nodes_of_4(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Fault> {
        let [blocks, ..] = cursor.sizes::<4>()?;
        for _ in 0..blocks {
            let [dimension, _, is_parametric] = [cursor.int()?, cursor.int()?, cursor.int()?];
            let count = cursor.size()?;
            let count = cursor.count(count as i64)?;
            let tags: Vec<usize> = (0..count)
                .map(|_| cursor.size())
                .collect::<Result<_, _>>()?;
            for tag in tags {
                self.add_node(tag, cursor.point()?);
                for _ in 0..if is_parametric == 0 { 0 } else { dimension } {
                    cursor.real()?;
                }
            }
        }
        cursor.end_line();
        Ok(())
    }

    fn nodes_of_2(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Fault> {
        // The number of nodes is a line of its own in any case.
        let count = cursor.text().and_then(|line| line.parse::<i64>().ok());
        let count = count.ok_or_else(|| cursor.wrong(&"expected the number of nodes"))?;
        for _ in 0..cursor.count(count)? {
            let tag = cursor.int()?;
            self.add_node(tag.max(0) as usize, cursor.point()?);
        }
        cursor.end_line();
        Ok(())
    }

    fn elements_of_4(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Fault> {
        let [blocks, ..] = cursor.sizes::<4>()?;
        for _ in 0..blocks {
            let [dimension, entity, kind] = [cursor.int()?, cursor.int()?, cursor.int()?];
            let count = cursor.size()?;
            let count = cursor.count(count as i64)?;
            let groups = self
                .groups
                .get(&(dimension.clamp(0, 3) as usize, entity))
                .cloned()
                .unwrap_or_default();
            for _ in 0..count {
                let tag = cursor.size()?;
                let nodes = node_count(cursor, kind)?;
                let nodes: Vec<usize> = (0..nodes)
                    .map(|_| cursor.size())
                    .collect::<Result<_, _>>()?;
                self.element(kind as usize, tag, &nodes, &groups)
                    .map_err(|e| cursor.wrong(&e))?;
            }
        }
        cursor.end_line();
        Ok(())
    }

    fn elements_of_2(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Fault> {
        let count = cursor.text().and_then(|line| line.parse::<i64>().ok());
        let count = count.ok_or_else(|| cursor.wrong(&"expected the number of elements"))?;
        let mut left = cursor.count(count)?;
        while left > 0 {
            // In bytes, elements of one type have a header in common.
            let (mut kind, mut block, mut tags) = (0, 1, 0);
            if cursor.is_binary {
                (kind, block, tags) = (cursor.int()?, cursor.int()?, cursor.int()?);
                block = cursor.count(block)?.clamp(1, left) as i64;
            }
            for _ in 0..block {
                let tag = cursor.int()?;
                if !cursor.is_binary {
                    (kind, tags) = (cursor.int()?, cursor.int()?);
                }
                let groups: Vec<i64> = (0..cursor.count(tags)?)
                    .map(|_| cursor.int())
                    .collect::<Result<_, _>>()?;
                let nodes = node_count(cursor, kind)?;
                let nodes: Vec<i64> = (0..nodes).map(|_| cursor.int()).collect::<Result<_, _>>()?;
                let nodes: Vec<usize> =
                    nodes.into_iter().map(|node| node.max(0) as usize).collect();
                // The first is the physical group, 0 if there is none.
                let group: Vec<i64> = groups
                    .first()
                    .copied()
                    .filter(|group| *group != 0)
                    .into_iter()
                    .collect();
                self.element(kind as usize, tag.max(0) as usize, &nodes, &group)
                    .map_err(|e| cursor.wrong(&e))?;
                left -= 1;
            }
        }
        cursor.end_line();
        Ok(())
    }

    /// Adds an element of these nodes and physical groups.
    fn element(
        &mut self,
        kind: usize,
        tag: usize,
        listed: &[usize],
        groups: &[i64],
    ) -> Result<(), Fault> {
        let dimension = ELEMENTS
            .iter()
            .find(|(known, ..)| *known == kind)
            .map_or(0, |(_, dimension, _)| *dimension);
        if dimension < 2 {
            return Ok(());
        }
        let named = |group: &i64| {
            let name = self.names.get(&(dimension, *group));
            name.cloned().unwrap_or_else(|| group.to_string())
        };
        let groups: Vec<String> = groups.iter().map(named).collect();
        let corners = listed.iter().map(|node| {
            let known = self.nodes.get(node).copied();
            known.ok_or_else(|| fault!("there is no node {node}"))
        });
        let corners = corners.collect::<Result<Vec<usize>, Fault>>()?;
        if dimension == 2 {
            return match (QUADRILATERALS.contains(&kind), &groups[..], corners.first_chunk()) {
                (true, names, Some(corners)) => {
                    names.iter().for_each(|name| self.file.add_face(name, *corners));
                    Ok(())
                }
                (_, [], _) => Ok(()),
                _ => Err("a surface has elements that are not quadrilaterals: recombine it (Recombine Surface)".into()),
            };
        }
        let hexahedron = HEXAHEDRA.iter().find(|(known, ..)| *known == kind);
        let &(_, order, count) = hexahedron.ok_or("no hexahedron")?;
        // Version 2 lists an element once for each of its groups.
        let mut all = corners.clone();
        all.sort_unstable();
        if !self.known.insert(all) {
            return Ok(());
        }
        let region = self.file.region(groups.first().map_or("", String::as_str));
        let nodes = match count {
            20 => {
                let positions = &mut self.file.nodes;
                Lattice::serendipity(&corners, &GMSH, |weights| weighted(positions, weights))
            }
            _ => Lattice::full(order, &corners, &GMSH),
        };
        self.elements.insert(tag, self.file.hexes.len());
        self.file.hexes.push(FileHex {
            nodes,
            region,
            label: tag.to_string(),
        });
        Ok(())
    }

    /// Vectors of elements.
    fn element_data(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Fault> {
        // Everything but the rows is in words, a line each.
        let lines = |cursor: &mut Cursor<'_>| -> Result<Vec<String>, Fault> {
            let count = cursor.text().and_then(|line| line.parse::<usize>().ok());
            let count = count.ok_or_else(|| cursor.wrong(&"expected a number of tags"))?;
            (0..count)
                .map(|_| {
                    cursor
                        .text()
                        .ok_or_else(|| Fault::whole("it ends before it is complete"))
                })
                .collect()
        };
        let [texts, _, wholes] = [lines(cursor)?, lines(cursor)?, lines(cursor)?];
        let name = texts
            .first()
            .map_or("", |name| name.trim_matches('"'))
            .to_owned();
        let whole = |i: usize| {
            wholes
                .get(i)
                .and_then(|word| word.parse::<i64>().ok())
                .unwrap_or(0)
        };
        let which = DIRECTIONS.iter().position(|known| *known == name);
        let Some(which) = which else {
            cursor.skip("ElementData");
            return Ok(());
        };
        if whole(1) != 3 {
            return Err(cursor.wrong(&"a direction has three components"));
        }
        for _ in 0..cursor.count(whole(2))? {
            let tag = cursor.int()?.max(0) as usize;
            self.directions[which].insert(tag, cursor.point()?.into());
        }
        cursor.end_line();
        Ok(())
    }

    fn finish(self) -> Result<WallFile, Fault> {
        let mut file = self.file;
        let [axial, around] = &self.directions;
        if !axial.is_empty() && !around.is_empty() {
            let mut all = vec![None; file.hexes.len()];
            for (tag, &hex) in &self.elements {
                let both = axial.get(tag).copied().zip(around.get(tag).copied());
                all[hex] = both.map(|(a, c)| [a, c]);
            }
            let all: Option<Vec<_>> = all.into_iter().collect();
            file.directions = Some(
                all.ok_or("the element data axial and circumferential leave out some hexahedra")?,
            );
        }
        Ok(file)
    }
}

/// Number of nodes of an element of this type, which must be a hexahedron if it has a volume.
fn node_count(cursor: &Cursor<'_>, kind: i64) -> Result<usize, Fault> {
    let known = ELEMENTS.iter().find(|(known, ..)| *known as i64 == kind);
    let is_hexahedron = HEXAHEDRA.iter().any(|(known, ..)| *known as i64 == kind);
    match known {
        None => Err(cursor.wrong(&format_args!("elements of the type {kind} are not known"))),
        Some((_, 3, _)) if !is_hexahedron => Err(cursor.wrong(&format_args!(
            "an element of the type {kind} is not a hexahedron of order 1, 2 or 3: recombine and sweep the volume"
        ))),
        Some((.., count)) => Ok(*count),
    }
}

/// A new node at the weighted sum of others.
pub(super) fn weighted(nodes: &mut Vec<Vec3>, weights: &[(usize, f64)]) -> usize {
    let position = weights
        .iter()
        .map(|(node, weight)| nodes[*node] * *weight)
        .sum();
    nodes.push(position);
    nodes.len() - 1
}
