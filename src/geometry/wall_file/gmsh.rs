//! Gmsh's MSH 4.1 in ASCII: hexahedra of the orders 1 to 3, physical groups as regions and surfaces.

use super::lattice::{GMSH, Lattice};
use super::{FileHex, WallFile, number};
use crate::Vec3;
use std::collections::HashMap;

/// Order and number of nodes of Gmsh's hexahedra by type; 20 nodes are of the second order.
const HEXAHEDRA: [(usize, usize, usize); 4] = [(5, 1, 8), (12, 2, 27), (17, 2, 20), (92, 3, 64)];
/// Number of nodes of Gmsh's quadrilaterals by type.
const QUADRILATERALS: [(usize, usize); 4] = [(3, 4), (10, 9), (16, 8), (36, 16)];
/// Names of element data that hold the directions of fibres.
const DIRECTIONS: [&str; 2] = ["axial", "circumferential"];

/// Lines with their numbers, section by section.
struct Lines<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Result<(usize, std::str::SplitWhitespace<'a>), String> {
        let (i, line) = self.lines.next().ok_or("it ends before it is complete")?;
        Ok((i + 1, line.split_whitespace()))
    }

    /// The numbers of the next line.
    fn numbers<T: std::str::FromStr>(&mut self) -> Result<(usize, Vec<T>), String> {
        let (line, words) = self.next()?;
        let numbers = words.map(|word| number(Some(word), line));
        Ok((line, numbers.collect::<Result<_, _>>()?))
    }

    /// The first `N` numbers of the next line.
    fn first<const N: usize>(&mut self) -> Result<(usize, [usize; N]), String> {
        let (line, numbers) = self.numbers::<usize>()?;
        let first = numbers.get(..N).and_then(|first| first.try_into().ok());
        Ok((
            line,
            first.ok_or_else(|| format!("line {line}: expected {N} numbers"))?,
        ))
    }
}

pub fn read(text: &str) -> Result<WallFile, String> {
    let mut lines = Lines {
        lines: text.lines().enumerate(),
    };
    let mut file = WallFile::default();
    let mut names: HashMap<(usize, i64), String> = HashMap::new();
    let mut groups: HashMap<(usize, i64), Vec<i64>> = HashMap::new();
    let mut nodes: HashMap<usize, usize> = HashMap::new();
    let mut elements: HashMap<usize, usize> = HashMap::new();
    let mut directions: [HashMap<usize, Vec3>; 2] = Default::default();
    let mut has_format = false;
    while let Some((_, line)) = lines.lines.next() {
        match line.trim() {
            "$MeshFormat" => {
                let (_, mut words) = lines.next()?;
                let version = words.next().unwrap_or_default();
                if version != "4.1" {
                    return Err(format!(
                        "it is of the version {version}: expected 4.1 (gmsh -format msh41, or Mesh.MshFileVersion = 4.1)"
                    ));
                }
                if words.next() != Some("0") {
                    return Err("it is binary: expected ASCII (Mesh.Binary = 0)".into());
                }
                has_format = true;
            }
            "$PhysicalNames" => {
                let (_, [count]) = lines.first()?;
                for _ in 0..count {
                    let (line, mut words) = lines.next()?;
                    let place = (number(words.next(), line)?, number(words.next(), line)?);
                    let name = words.collect::<Vec<_>>().join(" ");
                    names.insert(place, name.trim_matches('"').to_owned());
                }
            }
            "$Entities" => entities(&mut lines, &mut groups)?,
            "$Nodes" => {
                let (_, [blocks, _]) = lines.first()?;
                for _ in 0..blocks {
                    let (_, [_, _, _, count]) = lines.first()?;
                    let tags = (0..count).map(|_| Ok(lines.first::<1>()?.1[0]));
                    let tags = tags.collect::<Result<Vec<usize>, String>>()?;
                    for tag in tags {
                        let (line, x) = lines.numbers::<f64>()?;
                        if x.len() < 3 {
                            return Err(format!("line {line}: expected three coordinates"));
                        }
                        nodes.insert(tag, file.nodes.len());
                        file.nodes.push(Vec3::new(x[0], x[1], x[2]));
                    }
                }
            }
            "$Elements" => {
                let (_, [blocks, _]) = lines.first()?;
                for _ in 0..blocks {
                    let (line, head) = lines.numbers::<i64>()?;
                    let [dimension, entity, kind, count] = head[..] else {
                        return Err(format!("line {line}: expected four numbers"));
                    };
                    let (dimension, kind) = (dimension as usize, kind as usize);
                    let in_groups: Vec<String> =
                        (groups.get(&(dimension, entity)).into_iter().flatten())
                            .map(|tag| {
                                names
                                    .get(&(dimension, *tag))
                                    .cloned()
                                    .unwrap_or(tag.to_string())
                            })
                            .collect();
                    for _ in 0..count {
                        let (line, listed) = lines.numbers::<usize>()?;
                        element(
                            &mut file,
                            kind,
                            &listed,
                            &nodes,
                            &in_groups,
                            dimension,
                            &mut elements,
                        )
                        .map_err(|reason| format!("line {line}: {reason}"))?;
                    }
                }
            }
            "$ElementData" => {
                let (_, [strings]) = lines.first()?;
                let mut tags = (0..strings).map(|_| {
                    lines
                        .next()
                        .map(|(_, words)| words.collect::<Vec<_>>().join(" "))
                });
                let tags = tags.by_ref().collect::<Result<Vec<_>, _>>()?;
                let name = tags
                    .first()
                    .map_or("", |name| name.trim_matches('"'))
                    .to_owned();
                let (_, [reals]) = lines.first()?;
                (0..reals).try_for_each(|_| lines.next().map(drop))?;
                let (_, [wholes]) = lines.first()?;
                let wholes = (0..wholes).map(|_| Ok(lines.first::<1>()?.1[0]));
                let wholes = wholes.collect::<Result<Vec<usize>, String>>()?;
                for _ in 0..wholes.get(2).copied().unwrap_or(0) {
                    let (line, row) = lines.numbers::<f64>()?;
                    let which = DIRECTIONS.iter().position(|known| *known == name);
                    let (Some(which), [tag, x, y, z]) = (which, &row[..]) else {
                        if which.is_some() {
                            return Err(format!("line {line}: a direction has three components"));
                        }
                        continue;
                    };
                    directions[which].insert(*tag as usize, Vec3::new(*x, *y, *z));
                }
            }
            _ => {}
        }
    }
    if !has_format {
        return Err("it has no $MeshFormat: expected a mesh of Gmsh, version 4.1 in ASCII".into());
    }
    let [axial, around] = &directions;
    if !axial.is_empty() && !around.is_empty() {
        let mut all = vec![None; file.hexes.len()];
        for (tag, &hex) in &elements {
            all[hex] = axial
                .get(tag)
                .copied()
                .zip(around.get(tag).copied())
                .map(|(a, c)| [a, c]);
        }
        let all: Option<Vec<_>> = all.into_iter().collect();
        file.directions =
            Some(all.ok_or("the element data axial and circumferential leave out some hexahedra")?);
    }
    Ok(file)
}

/// The physical groups of surfaces and volumes.
fn entities(
    lines: &mut Lines<'_>,
    groups: &mut HashMap<(usize, i64), Vec<i64>>,
) -> Result<(), String> {
    let (_, counts) = lines.first::<4>()?;
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let (line, mut words) = lines.next()?;
            let tag: i64 = number(words.next(), line)?;
            // The position of a point, the box around others.
            let sizes = if dimension == 0 { 3 } else { 6 };
            let mut words = words.skip(sizes);
            let physical: usize = number(words.next(), line)?;
            let of_entity = (0..physical).map(|_| number::<i64>(words.next(), line).map(i64::abs));
            groups.insert((dimension, tag), of_entity.collect::<Result<_, _>>()?);
        }
    }
    Ok(())
}

/// Adds an element: its tag and its nodes.
fn element(
    file: &mut WallFile,
    kind: usize,
    listed: &[usize],
    nodes: &HashMap<usize, usize>,
    groups: &[String],
    dimension: usize,
    elements: &mut HashMap<usize, usize>,
) -> Result<(), String> {
    if dimension < 2 {
        return Ok(());
    }
    let corners = listed.iter().skip(1).map(|tag| {
        nodes
            .get(tag)
            .copied()
            .ok_or_else(|| format!("there is no node {tag}"))
    });
    let corners = corners.collect::<Result<Vec<usize>, String>>()?;
    if dimension == 2 {
        let Some((_, count)) = QUADRILATERALS.iter().find(|(known, _)| *known == kind) else {
            return match groups {
                [] => Ok(()),
                _ => Err("a surface has elements that are no quadrilaterals: recombine it (Recombine Surface)".into()),
            };
        };
        if corners.len() != *count {
            return Err(format!("expected {count} nodes, found {}", corners.len()));
        }
        let corners = corners[..4].try_into().expect("there are four");
        groups.iter().for_each(|name| file.add_face(name, corners));
        return Ok(());
    }
    let Some(&(_, order, count)) = HEXAHEDRA.iter().find(|(known, ..)| *known == kind) else {
        return Err(format!(
            "an element of the type {kind} is no hexahedron of the order 1, 2 or 3: recombine and sweep the volume"
        ));
    };
    if corners.len() != count {
        return Err(format!("expected {count} nodes, found {}", corners.len()));
    }
    let region = file.region(groups.first().map_or("", String::as_str));
    let nodes = match count {
        20 => {
            let positions = &mut file.nodes;
            Lattice::serendipity(&corners, &GMSH, |weights| weighted(positions, weights))
        }
        _ => Lattice::full(order, &corners, &GMSH),
    };
    elements.insert(listed[0], file.hexes.len());
    file.hexes.push(FileHex { nodes, region });
    Ok(())
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
