//! Abaqus' input files: C3D8 and C3D20 of any kind; sets of elements as regions; surfaces of elements, sets of nodes, and
//! sets of quadrilaterals (which Gmsh writes) as surfaces.

use super::gmsh::weighted;
use super::lattice::{Lattice, VTK};
use super::{FileHex, WallFile, number};
use crate::Vec3;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Corners of the faces S1 to S6.
const FACES: [[usize; 4]; 6] = [
    [0, 1, 2, 3],
    [4, 7, 6, 5],
    [0, 4, 5, 1],
    [1, 5, 6, 2],
    [2, 6, 7, 3],
    [3, 7, 4, 0],
];

/// Quadrilaterals with four or eight nodes.
const SHELLS: [&str; 10] = [
    "CPS4", "CPE4", "S4", "M3D4", "SFM3D4", "CPS8", "CPE8", "S8", "M3D8", "SFM3D8",
];

/// What the lines behind a keyword are.
enum Section {
    Ignored,
    Nodes,
    Elements {
        count: usize,
        is_solid: bool,
        set: String,
    },
    NodeSet {
        name: String,
        is_range: bool,
    },
    ElementSet {
        name: String,
        is_range: bool,
    },
    Surface(String),
}

pub fn read(text: &str) -> Result<WallFile, String> {
    let mut file = WallFile::default();
    let mut nodes: HashMap<usize, usize> = HashMap::new();
    let mut elements: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let mut quads: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let (mut element_sets, mut node_sets) = (Sets::default(), Sets::default());
    let mut surfaces: Vec<(String, String, usize, usize)> = Vec::new();
    let mut sections: Vec<(String, String)> = Vec::new();
    let mut section = Section::Ignored;
    let mut pending: Vec<usize> = Vec::new();
    for (i, text) in text.lines().enumerate() {
        let line = i + 1;
        let text = text.trim();
        if text.is_empty() || text.starts_with("**") {
            continue;
        }
        if let Some(keyword) = text.strip_prefix('*') {
            let mut parts = keyword.split(',').map(str::trim);
            let word = parts.next().unwrap_or_default().to_ascii_uppercase();
            let options: HashMap<String, String> = parts
                .map(|part| part.split_once('=').unwrap_or((part, "")))
                .map(|(key, value)| {
                    (
                        key.trim().to_ascii_uppercase(),
                        value.trim().trim_matches('"').to_owned(),
                    )
                })
                .collect();
            let option = |key: &str| options.get(key).cloned().unwrap_or_default();
            let is_range = options.contains_key("GENERATE");
            section = match word.as_str() {
                "NODE" => Section::Nodes,
                "ELEMENT" => {
                    let kind = option("TYPE").to_ascii_uppercase();
                    let count = match kind.as_str() {
                        kind if kind.starts_with("C3D20") => 20,
                        "C3D8" | "C3D8R" | "C3D8I" | "C3D8H" | "C3D8RH" | "C3D8IH" => 8,
                        kind if kind.starts_with("C3D") => {
                            return Err(format!(
                                "line {line}: elements of the type {kind} are no hexahedra: expected C3D8 or C3D20"
                            ));
                        }
                        kind if SHELLS.iter().any(|shell| kind.starts_with(shell)) => {
                            if kind.contains('8') { 8 } else { 4 }
                        }
                        _ => 0,
                    };
                    match count {
                        0 => Section::Ignored,
                        count => Section::Elements {
                            count,
                            is_solid: kind.starts_with("C3D"),
                            set: option("ELSET"),
                        },
                    }
                }
                "NSET" => Section::NodeSet {
                    name: option("NSET"),
                    is_range,
                },
                "ELSET" => Section::ElementSet {
                    name: option("ELSET"),
                    is_range,
                },
                "SURFACE"
                    if option("TYPE").is_empty()
                        || option("TYPE").eq_ignore_ascii_case("ELEMENT") =>
                {
                    Section::Surface(option("NAME"))
                }
                "SOLID SECTION" => {
                    sections.push((option("ELSET"), option("MATERIAL")));
                    Section::Ignored
                }
                "INCLUDE" => {
                    return Err(format!(
                        "line {line}: *INCLUDE is not followed: put its lines into this file"
                    ));
                }
                _ => Section::Ignored,
            };
            pending.clear();
            continue;
        }
        let mut words = text
            .split(',')
            .map(str::trim)
            .filter(|word| !word.is_empty());
        match &section {
            Section::Ignored => {}
            Section::Nodes => {
                let tag = number(words.next(), line)?;
                let x = [words.next(), words.next(), words.next()];
                nodes.insert(tag, file.nodes.len());
                let [x, y, z] = x.map(|word| number(word, line));
                file.nodes.push(Vec3::new(x?, y?, z?));
            }
            Section::Elements {
                count,
                is_solid,
                set,
            } => {
                // An element goes on in further lines until it is complete.
                for word in words {
                    pending.push(number(Some(word), line)?);
                }
                if pending.len() > *count {
                    let tag = pending[0];
                    let corners = pending[1..=*count].to_vec();
                    let list = if *is_solid { &mut elements } else { &mut quads };
                    if pending.len() > count + 1 || list.insert(tag, corners).is_some() {
                        return Err(format!(
                            "line {line}: the element {tag} has too many nodes, or stands there twice"
                        ));
                    }
                    element_sets.members(set).insert(tag);
                    pending.clear();
                }
            }
            Section::NodeSet { name, is_range } => {
                add(&mut node_sets, name, *is_range, words, line)?;
            }
            Section::ElementSet { name, is_range } => {
                add(&mut element_sets, name, *is_range, words, line)?;
            }
            Section::Surface(name) => {
                let (of, side) = (
                    words.next().unwrap_or_default(),
                    words.next().unwrap_or_default(),
                );
                let side = side.trim_start_matches(['S', 's']).parse::<usize>().ok();
                let side = side.filter(|side| (1..=6).contains(side));
                let side = side
                    .ok_or_else(|| format!("line {line}: expected a face S1 to S6 of elements"))?;
                surfaces.push((name.clone(), of.to_owned(), side - 1, line));
            }
        }
    }

    // The region of an element: the material of its section, or the last set that it is in.
    let mut region_of: HashMap<usize, &str> = HashMap::new();
    let of_sets = element_sets
        .0
        .iter()
        .map(|(name, members)| (name.as_str(), members));
    let of_sections = (sections.iter())
        .filter_map(|(set, material)| Some((material.as_str(), element_sets.find(set)?)));
    for (name, members) in of_sets.chain(of_sections) {
        region_of.extend(members.iter().map(|tag| (*tag, name)));
    }
    let mut corners_of: HashMap<usize, [usize; 8]> = HashMap::new();
    for (tag, listed) in &elements {
        let known = listed.iter().map(|node| {
            nodes
                .get(node)
                .copied()
                .ok_or_else(|| format!("the element {tag} has the node {node}, which there is not"))
        });
        let known = known.collect::<Result<Vec<usize>, String>>()?;
        corners_of.insert(*tag, known[..8].try_into().expect("there are eight"));
        let region = file.region(region_of.get(tag).copied().unwrap_or_default());
        let nodes = match known.len() {
            20 => {
                let positions = &mut file.nodes;
                Lattice::serendipity(&known, &VTK, |weights| weighted(positions, weights))
            }
            _ => Lattice::full(1, &known, &VTK),
        };
        file.hexes.push(FileHex { nodes, region });
    }
    for (name, of, side, line) in surfaces {
        let members: Vec<usize> = match of.parse::<usize>() {
            Ok(tag) => vec![tag],
            Err(_) => {
                let set = element_sets.find(&of);
                let set =
                    set.ok_or_else(|| format!("line {line}: there is no set of elements {of:?}"))?;
                set.iter().copied().collect()
            }
        };
        for tag in members {
            if let Some(corners) = corners_of.get(&tag) {
                file.add_face(&name, FACES[side].map(|v| corners[v]));
            }
        }
    }
    for (name, members) in &element_sets.0 {
        for corners in members.iter().filter_map(|tag| quads.get(tag)) {
            let corners = corners[..4].iter().map(|node| nodes.get(node).copied());
            let corners = corners.collect::<Option<Vec<usize>>>();
            let corners = corners
                .ok_or_else(|| format!("a face of {name:?} has a node that there is not"))?;
            file.add_face(name, corners.try_into().expect("there are four"));
        }
    }
    // A set of nodes is a surface of the faces of which it has all corners.
    for (name, members) in &node_sets.0 {
        let members: BTreeSet<usize> = members
            .iter()
            .filter_map(|tag| nodes.get(tag).copied())
            .collect();
        for corners in corners_of.values() {
            for face in FACES.map(|face| face.map(|v| corners[v])) {
                if face.iter().all(|corner| members.contains(corner)) {
                    file.add_face(name, face);
                }
            }
        }
    }
    Ok(file)
}

/// Sets by their names, in the order of the file; upper and lower case are the same.
#[derive(Default)]
struct Sets(Vec<(String, BTreeSet<usize>)>);

impl Sets {
    fn find(&self, name: &str) -> Option<&BTreeSet<usize>> {
        let mut sets = self.0.iter();
        let found = sets.find(|(known, _)| known.eq_ignore_ascii_case(name));
        found.map(|(_, members)| members)
    }

    /// Those of a set, which is added if it is new.
    fn members(&mut self, name: &str) -> &mut BTreeSet<usize> {
        let mut sets = self.0.iter();
        let known = sets.position(|(known, _)| known.eq_ignore_ascii_case(name));
        let place = known.unwrap_or_else(|| {
            self.0.push((name.to_owned(), BTreeSet::new()));
            self.0.len() - 1
        });
        &mut self.0[place].1
    }
}

/// Adds the members of a set on one line.
fn add<'a>(
    sets: &mut Sets,
    name: &str,
    is_range: bool,
    words: impl Iterator<Item = &'a str>,
    line: usize,
) -> Result<(), String> {
    let mut members = BTreeSet::new();
    let words: Vec<&str> = words.collect();
    if is_range {
        let numbers = words.iter().map(|word| number(Some(word), line));
        let numbers = numbers.collect::<Result<Vec<usize>, _>>()?;
        let [first, last, step @ ..] = &numbers[..] else {
            return Err(format!(
                "line {line}: expected the first and the last of a range"
            ));
        };
        let step = step.first().copied().unwrap_or(1).max(1);
        members.extend((*first..=*last).step_by(step));
    } else {
        for word in words {
            match word.parse::<usize>() {
                Ok(tag) => drop(members.insert(tag)),
                // Another set.
                Err(_) => members.extend(sets.find(word).into_iter().flatten().copied()),
            }
        }
    }
    sets.members(name).extend(members);
    Ok(())
}
