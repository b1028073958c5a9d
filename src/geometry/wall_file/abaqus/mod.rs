//! Abaqus' input files: C3D8, C3D20 and C3D27 of any kind, in parts and instances or without; sets of elements as
//! regions; surfaces of elements, sets of nodes, and sets of quadrilaterals (which Gmsh writes) as surfaces.

mod data;
mod lines;
mod part;
mod wall;

use super::WallFile;
use crate::Vec3;
use crate::files::{Fault, fault};
use lines::{Line, keyword};
use part::{Instance, Label, Part, Sets};
use std::path::Path;

/// Quadrilaterals with four or eight nodes.
const SHELLS: [&str; 10] = [
    "CPS4", "CPE4", "S4", "M3D4", "SFM3D4", "CPS8", "CPE8", "S8", "M3D8", "SFM3D8",
];
/// Keywords that make nodes or elements by a rule, or move those that follow.
const RULES: [&str; 8] = [
    "NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "IMPORT",
];

/// What the lines after a keyword are.
enum AbaqusSection {
    Ignored,
    Nodes {
        set: String,
        system: char,
    },
    Elements {
        count: usize,
        is_solid: bool,
        set: String,
    },
    NodeSet {
        name: String,
        is_range: bool,
        instance: String,
    },
    ElementSet {
        name: String,
        is_range: bool,
        instance: String,
    },
    Surface(String),
    NodeSurface(String),
    Position,
}

/// Where the lines stand.
#[derive(Clone, Copy, PartialEq)]
enum Scope {
    /// Outside of parts, as where there are none.
    Top,
    Part(usize),
    Assembly,
    Instance(usize),
}

/// A model as it is read.
struct Model {
    /// What stands outside of parts.
    top: Part,
    parts: Vec<(String, Part)>,
    instances: Vec<Instance>,
    /// Sets and surfaces of the assembly.
    element_sets: Sets<Label>,
    node_sets: Sets<Label>,
    surfaces: Vec<(String, String, usize, String)>,
    scope: Scope,
    section: AbaqusSection,
    /// Numbers of an element that goes on in the next line.
    pending: Vec<usize>,
}

pub fn read(path: &Path) -> Result<WallFile, Fault> {
    let mut model = Model {
        top: Part::default(),
        parts: Vec::new(),
        instances: Vec::new(),
        element_sets: Sets::default(),
        node_sets: Sets::default(),
        surfaces: Vec::new(),
        scope: Scope::Top,
        section: AbaqusSection::Ignored,
        pending: Vec::new(),
    };
    for line in lines::read(path)? {
        let read = match line.text.starts_with('*') {
            true => model.keyword(&line),
            false => model.data(&line),
        };
        read.map_err(|reason| format!("{}: {reason}", line.place))?;
    }
    wall::of(model)
}

impl Model {
    /// The part that lines belong to; none in the assembly.
    fn part(&mut self) -> Option<&mut Part> {
        match self.scope {
            Scope::Top => Some(&mut self.top),
            Scope::Part(i) => Some(&mut self.parts[i].1),
            Scope::Instance(i) => Some(&mut self.instances[i].part),
            Scope::Assembly => None,
        }
    }

    fn keyword(&mut self, line: &Line) -> Result<(), Fault> {
        let (word, options) = keyword(&line.text);
        let option = |key: &str| {
            let found = options.iter().find(|(known, _)| known == key);
            found.map_or(String::new(), |(_, value)| value.clone())
        };
        let is_range = options.iter().any(|(key, _)| key == "GENERATE");
        let instance = option("INSTANCE");
        self.pending.clear();
        self.section = match word.as_str() {
            "PART" => return self.begin_part(&option("NAME")),
            "INSTANCE" => {
                return self.begin_instance(option("NAME"), &option("PART"), &option("LIBRARY"));
            }
            "END PART" | "END ASSEMBLY" | "ASSEMBLY" | "END INSTANCE" => {
                self.scope = match word.starts_with("END") && word != "END INSTANCE" {
                    true => Scope::Top,
                    false => Scope::Assembly,
                };
                AbaqusSection::Ignored
            }
            "NODE" => AbaqusSection::Nodes {
                set: option("NSET"),
                system: (option("SYSTEM").to_ascii_uppercase().chars().next()).unwrap_or('R'),
            },
            "ELEMENT" => elements(&option("TYPE").to_ascii_uppercase(), option("ELSET"))?,
            "NSET" if !option("ELSET").is_empty() => {
                self.nodes_of_elements(&option("NSET"), &option("ELSET"))?;
                AbaqusSection::Ignored
            }
            "NSET" => AbaqusSection::NodeSet {
                name: option("NSET"),
                is_range,
                instance,
            },
            "ELSET" => AbaqusSection::ElementSet {
                name: option("ELSET"),
                is_range,
                instance,
            },
            "SURFACE" => match option("TYPE").to_ascii_uppercase().as_str() {
                "" | "ELEMENT" => AbaqusSection::Surface(option("NAME")),
                "NODE" => AbaqusSection::NodeSurface(option("NAME")),
                _ => AbaqusSection::Ignored,
            },
            "SOLID SECTION" => {
                let section = (option("ELSET"), option("MATERIAL"));
                if let Some(part) = self.part() {
                    part.sections.push(section);
                }
                AbaqusSection::Ignored
            }
            rule if RULES.contains(&rule) => {
                return Err(fault!(
                    "*{rule} makes or moves nodes and elements by a rule, which is not followed: write the mesh itself into the file"
                ));
            }
            _ => AbaqusSection::Ignored,
        };
        Ok(())
    }

    fn begin_part(&mut self, name: &str) -> Result<(), Fault> {
        if self
            .parts
            .iter()
            .any(|(known, _)| known.eq_ignore_ascii_case(name))
        {
            return Err(fault!("there is another part {name:?}"));
        }
        self.parts.push((name.to_owned(), Part::default()));
        self.scope = Scope::Part(self.parts.len() - 1);
        self.section = AbaqusSection::Ignored;
        Ok(())
    }

    fn begin_instance(&mut self, name: String, part: &str, library: &str) -> Result<(), Fault> {
        if !library.is_empty() {
            return Err(fault!(
                "the instance {name:?} comes from the results of another analysis: write its mesh into the file"
            ));
        }
        if self
            .instances
            .iter()
            .any(|known| known.name.eq_ignore_ascii_case(&name))
        {
            return Err(fault!("there is another instance {name:?}"));
        }
        let known = self
            .parts
            .iter()
            .find(|(known, _)| known.eq_ignore_ascii_case(part));
        let (_, part) = known.ok_or_else(|| format!("there is no part {part:?}"))?;
        self.instances.push(Instance {
            name,
            part: part.clone(),
            translation: Vec3::zeros(),
            rotation: None,
            lines: 0,
        });
        self.scope = Scope::Instance(self.instances.len() - 1);
        self.section = AbaqusSection::Position;
        Ok(())
    }

    /// `*NSET, NSET=…, ELSET=…`: the nodes of the elements of a set.
    fn nodes_of_elements(&mut self, name: &str, of: &str) -> Result<(), Fault> {
        let Some(part) = self.part() else {
            return Ok(());
        };
        let members = part
            .element_sets
            .find(of)
            .ok_or_else(|| format!("there is no set of elements {of:?}"))?;
        let nodes = members
            .iter()
            .filter_map(|tag| part.solids.get(tag).or(part.quads.get(tag)));
        let nodes: Vec<usize> = nodes.flatten().copied().collect();
        part.node_sets.members(name).extend(nodes);
        Ok(())
    }
}

fn elements(kind: &str, set: String) -> Result<AbaqusSection, Fault> {
    let is_solid = kind.starts_with("C3D") || kind.starts_with("SC8");
    let count = match kind {
        kind if kind.starts_with("C3D27") => 27,
        kind if kind.starts_with("C3D20") => 20,
        kind if kind.starts_with("C3D8") || kind.starts_with("SC8") => 8,
        kind if kind.starts_with("C3D") => {
            return Err(fault!(
                "elements of the type {kind} are not hexahedra: expected C3D8, C3D20 or C3D27"
            ));
        }
        kind if SHELLS.iter().any(|shell| kind.starts_with(shell)) => match kind.contains('8') {
            true => 8,
            false => 4,
        },
        _ => return Ok(AbaqusSection::Ignored),
    };
    Ok(AbaqusSection::Elements {
        count,
        is_solid,
        set,
    })
}
