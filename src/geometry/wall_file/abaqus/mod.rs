//! Abaqus' input files: C3D8, C3D20 and C3D27 of any kind, in parts and instances or without; sets of elements as regions;
//! surfaces of elements, sets of nodes, and sets of quadrilaterals (which Gmsh writes) as surfaces.

mod lines;
mod part;
mod wall;

use super::WallFile;
use crate::Vec3;
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

/// What the lines behind a keyword are.
enum Section {
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
    section: Section,
    /// Numbers of an element that goes on in the next line.
    pending: Vec<usize>,
}

pub fn read(path: &Path) -> Result<WallFile, String> {
    let mut model = Model {
        top: Part::default(),
        parts: Vec::new(),
        instances: Vec::new(),
        element_sets: Sets::default(),
        node_sets: Sets::default(),
        surfaces: Vec::new(),
        scope: Scope::Top,
        section: Section::Ignored,
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

    fn keyword(&mut self, line: &Line) -> Result<(), String> {
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
            "END PART" | "END ASSEMBLY" => {
                self.scope = Scope::Top;
                Section::Ignored
            }
            "ASSEMBLY" => {
                self.scope = Scope::Assembly;
                Section::Ignored
            }
            "INSTANCE" => {
                return self.begin_instance(option("NAME"), &option("PART"), &option("LIBRARY"));
            }
            "END INSTANCE" => {
                self.scope = Scope::Assembly;
                Section::Ignored
            }
            "NODE" => Section::Nodes {
                set: option("NSET"),
                system: option("SYSTEM")
                    .to_ascii_uppercase()
                    .chars()
                    .next()
                    .unwrap_or('R'),
            },
            "ELEMENT" => elements(&option("TYPE").to_ascii_uppercase(), option("ELSET"))?,
            "NSET" if !option("ELSET").is_empty() => {
                self.nodes_of_elements(&option("NSET"), &option("ELSET"))?;
                Section::Ignored
            }
            "NSET" => Section::NodeSet {
                name: option("NSET"),
                is_range,
                instance,
            },
            "ELSET" => Section::ElementSet {
                name: option("ELSET"),
                is_range,
                instance,
            },
            "SURFACE" => match option("TYPE").to_ascii_uppercase().as_str() {
                "" | "ELEMENT" => Section::Surface(option("NAME")),
                "NODE" => Section::NodeSurface(option("NAME")),
                _ => Section::Ignored,
            },
            "SOLID SECTION" => {
                let section = (option("ELSET"), option("MATERIAL"));
                if let Some(part) = self.part() {
                    part.sections.push(section);
                }
                Section::Ignored
            }
            rule if RULES.contains(&rule) => {
                return Err(format!(
                    "*{rule} makes or moves nodes and elements by a rule, which is not followed: write the mesh itself into the file"
                ));
            }
            _ => Section::Ignored,
        };
        Ok(())
    }

    fn begin_part(&mut self, name: &str) -> Result<(), String> {
        if self
            .parts
            .iter()
            .any(|(known, _)| known.eq_ignore_ascii_case(name))
        {
            return Err(format!("there is another part {name:?}"));
        }
        self.parts.push((name.to_owned(), Part::default()));
        self.scope = Scope::Part(self.parts.len() - 1);
        self.section = Section::Ignored;
        Ok(())
    }

    fn begin_instance(&mut self, name: String, part: &str, library: &str) -> Result<(), String> {
        if !library.is_empty() {
            return Err(format!(
                "the instance {name:?} comes from the results of another analysis: write its mesh into the file"
            ));
        }
        if self
            .instances
            .iter()
            .any(|known| known.name.eq_ignore_ascii_case(&name))
        {
            return Err(format!("there is another instance {name:?}"));
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
        self.section = Section::Position;
        Ok(())
    }

    /// `*NSET, NSET=…, ELSET=…`: the nodes of the elements of a set.
    fn nodes_of_elements(&mut self, name: &str, of: &str) -> Result<(), String> {
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

    fn data(&mut self, line: &Line) -> Result<(), String> {
        let words: Vec<&str> = line.text.split(',').map(str::trim).collect();
        match &self.section {
            Section::Ignored => Ok(()),
            Section::Nodes { set, system } => {
                let (set, system) = (set.clone(), *system);
                self.node(&words, &set, system)
            }
            Section::Elements {
                count,
                is_solid,
                set,
            } => {
                let (count, is_solid, set) = (*count, *is_solid, set.clone());
                self.element(&words, count, is_solid, &set)
            }
            Section::NodeSet {
                name,
                is_range,
                instance,
            } => {
                let (name, is_range, instance) = (name.clone(), *is_range, instance.clone());
                self.set(&words, &name, is_range, &instance, true)
            }
            Section::ElementSet {
                name,
                is_range,
                instance,
            } => {
                let (name, is_range, instance) = (name.clone(), *is_range, instance.clone());
                self.set(&words, &name, is_range, &instance, false)
            }
            Section::NodeSurface(name) => {
                let name = name.clone();
                self.set(&words[..1], &name, false, "", true)
            }
            Section::Surface(name) => {
                let name = name.clone();
                let side = words.get(1).copied().unwrap_or_default();
                let side = side.trim_start_matches(['S', 's']).parse::<usize>().ok();
                let side = side
                    .filter(|side| (1..=6).contains(side))
                    .ok_or("expected a face S1 to S6 of elements")?;
                let surface = (name, words[0].to_owned(), side - 1, line.place.clone());
                match self.part() {
                    Some(part) => part.surfaces.push(surface),
                    None => self.surfaces.push(surface),
                }
                Ok(())
            }
            Section::Position => self.position(&words),
        }
    }

    fn node(&mut self, words: &[&str], set: &str, system: char) -> Result<(), String> {
        let tag = number(words.first().copied().unwrap_or_default())?;
        let mut x = [0.0f64; 3];
        for (x, word) in x.iter_mut().zip(words.iter().skip(1)) {
            *x = if word.is_empty() { 0.0 } else { number(word)? };
        }
        if words.len() < 3 {
            return Err("ends too early: expected a number and three coordinates".into());
        }
        if x.iter().any(|x| !x.is_finite()) {
            return Err("expected finite coordinates".into());
        }
        let [a, b, c] = x;
        let (angle, height) = (b.to_radians(), c.to_radians());
        let place = match system {
            'C' => Vec3::new(a * angle.cos(), a * angle.sin(), c),
            'S' => Vec3::new(
                a * angle.cos() * height.cos(),
                a * angle.sin() * height.cos(),
                a * height.sin(),
            ),
            _ => Vec3::new(a, b, c),
        };
        // Reference points of the assembly are none of the mesh.
        if let Some(part) = self.part() {
            part.nodes.insert(tag, place);
            if !set.is_empty() {
                part.node_sets.members(set).insert(tag);
            }
        }
        Ok(())
    }

    /// An element goes on in further lines until it is complete.
    fn element(
        &mut self,
        words: &[&str],
        count: usize,
        is_solid: bool,
        set: &str,
    ) -> Result<(), String> {
        for word in words.iter().filter(|word| !word.is_empty()) {
            self.pending.push(number(word)?);
        }
        if self.pending.len() <= count {
            return Ok(());
        }
        let listed = std::mem::take(&mut self.pending);
        let tag = listed[0];
        let Some(part) = self.part() else {
            return Ok(());
        };
        let known = if is_solid {
            &mut part.solids
        } else {
            &mut part.quads
        };
        if listed.len() > count + 1 || known.insert(tag, listed[1..].to_vec()).is_some() {
            return Err(format!(
                "the element {tag} has too many nodes, or stands there twice"
            ));
        }
        if !set.is_empty() {
            part.element_sets.members(set).insert(tag);
        }
        Ok(())
    }

    /// Members of a set of nodes or elements.
    fn set(
        &mut self,
        words: &[&str],
        name: &str,
        is_range: bool,
        instance: &str,
        of_nodes: bool,
    ) -> Result<(), String> {
        let words: Vec<&str> = words
            .iter()
            .copied()
            .filter(|word| !word.is_empty())
            .collect();
        let tags: Vec<usize> = match is_range {
            false => words.iter().filter_map(|word| word.parse().ok()).collect(),
            true => {
                let numbers = words
                    .iter()
                    .map(|word| number(word))
                    .collect::<Result<Vec<usize>, _>>()?;
                let [first, last, step @ ..] = &numbers[..] else {
                    return Err("expected the first and the last of a range".into());
                };
                if last.saturating_sub(*first) > 100_000_000 {
                    return Err(format!(
                        "the range from {first} to {last} is longer than any mesh"
                    ));
                }
                (*first..=*last)
                    .step_by(step.first().copied().unwrap_or(1).max(1))
                    .collect()
            }
        };
        let others = || words.iter().filter(|word| word.parse::<usize>().is_err());
        if let Some(part) = self.part() {
            let sets = if of_nodes {
                &mut part.node_sets
            } else {
                &mut part.element_sets
            };
            let mut members: Vec<usize> = tags;
            for other in others() {
                members.extend(sets.find(other).into_iter().flatten());
            }
            sets.members(name).extend(members);
            return Ok(());
        }
        // In the assembly: of an instance, or each with the name of its own.
        let mut members: Vec<Label> = Vec::new();
        let known =
            (self.instances.iter()).position(|known| known.name.eq_ignore_ascii_case(instance));
        let index = match (known, instance) {
            (Some(index), _) => index,
            (None, "") if self.instances.len() == 1 => 0,
            (None, "") => usize::MAX,
            (None, other) => return Err(format!("there is no instance {other:?}")),
        };
        members.extend(tags.into_iter().map(|tag| (index, tag)));
        for other in others() {
            members.extend(self.found(other, of_nodes));
        }
        let sets = if of_nodes {
            &mut self.node_sets
        } else {
            &mut self.element_sets
        };
        sets.members(name).extend(members);
        Ok(())
    }

    /// What `instance.label`, `instance.set` or a set of the assembly stands for.
    fn found(&self, name: &str, of_nodes: bool) -> Vec<Label> {
        let sets = if of_nodes {
            &self.node_sets
        } else {
            &self.element_sets
        };
        if let Some(members) = sets.find(name) {
            return members.iter().copied().collect();
        }
        let Some((instance, rest)) = name.split_once('.') else {
            return Vec::new();
        };
        let index =
            (self.instances.iter()).position(|known| known.name.eq_ignore_ascii_case(instance));
        let Some(index) = index else {
            return Vec::new();
        };
        if let Ok(tag) = rest.parse() {
            return vec![(index, tag)];
        }
        let part = &self.instances[index].part;
        let sets = if of_nodes {
            &part.node_sets
        } else {
            &part.element_sets
        };
        sets.find(rest)
            .into_iter()
            .flatten()
            .map(|tag| (index, *tag))
            .collect()
    }

    fn position(&mut self, words: &[&str]) -> Result<(), String> {
        let Scope::Instance(index) = self.scope else {
            return Ok(());
        };
        let mut numbers = Vec::new();
        for word in words {
            numbers.push(if word.is_empty() {
                0.0
            } else {
                number::<f64>(word)?
            });
        }
        let instance = &mut self.instances[index];
        instance.lines += 1;
        match (instance.lines, &numbers[..]) {
            (1, [x, y, z, ..]) => instance.translation = Vec3::new(*x, *y, *z),
            (2, [a, b, c, d, e, f, angle, ..]) => {
                let axis = [Vec3::new(*a, *b, *c), Vec3::new(*d, *e, *f)];
                if (axis[1] - axis[0]).norm() == 0.0 {
                    return Err("the two points of the axis of rotation are the same".into());
                }
                instance.rotation = Some((axis, *angle));
            }
            _ => return Err("expected the translation of an instance, three numbers, or two points and an angle".into()),
        }
        Ok(())
    }
}

fn elements(kind: &str, set: String) -> Result<Section, String> {
    let is_solid = kind.starts_with("C3D") || kind.starts_with("SC8");
    let count = match kind {
        kind if kind.starts_with("C3D27") => 27,
        kind if kind.starts_with("C3D20") => 20,
        kind if kind.starts_with("C3D8") || kind.starts_with("SC8") => 8,
        kind if kind.starts_with("C3D") => {
            return Err(format!(
                "elements of the type {kind} are no hexahedra: expected C3D8, C3D20 or C3D27"
            ));
        }
        kind if SHELLS.iter().any(|shell| kind.starts_with(shell)) => match kind.contains('8') {
            true => 8,
            false => 4,
        },
        _ => return Ok(Section::Ignored),
    };
    Ok(Section::Elements {
        count,
        is_solid,
        set,
    })
}

fn number<T: std::str::FromStr>(word: &str) -> Result<T, String> {
    // Fortran's exponents
    let plain = word.replace(['D', 'd'], "e");
    plain
        .parse()
        .map_err(|_| format!("expected a number, found {word:?}"))
}
