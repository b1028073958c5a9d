//! The lines after keywords.

use super::lines::Line;
use super::part::Label;
use super::{AbaqusSection, Model, Scope};
use crate::Vec3;
use crate::files::{Fault, fault};

impl Model {
    pub fn data(&mut self, line: &Line) -> Result<(), Fault> {
        let words: Vec<&str> = line.text.split(',').map(str::trim).collect();
        match &self.section {
            AbaqusSection::Ignored => Ok(()),
            AbaqusSection::Nodes { set, system } => {
                let (set, system) = (set.clone(), *system);
                self.node(&words, &set, system)
            }
            AbaqusSection::Elements {
                count,
                is_solid,
                set,
            } => {
                let (count, is_solid, set) = (*count, *is_solid, set.clone());
                self.element(&words, count, is_solid, &set)
            }
            AbaqusSection::NodeSet {
                name,
                is_range,
                instance,
            } => {
                let (name, is_range, instance) = (name.clone(), *is_range, instance.clone());
                self.set(&words, &name, is_range, &instance, true)
            }
            AbaqusSection::ElementSet {
                name,
                is_range,
                instance,
            } => {
                let (name, is_range, instance) = (name.clone(), *is_range, instance.clone());
                self.set(&words, &name, is_range, &instance, false)
            }
            AbaqusSection::NodeSurface(name) => {
                let name = name.clone();
                self.set(&words[..1], &name, false, "", true)
            }
            AbaqusSection::Surface(name) => {
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
            AbaqusSection::Position => self.position(&words),
        }
    }

    fn node(&mut self, words: &[&str], set: &str, system: char) -> Result<(), Fault> {
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
    ) -> Result<(), Fault> {
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
            return Err(fault!(
                "the element {tag} has too many nodes, or is listed twice"
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
    ) -> Result<(), Fault> {
        let words = words.iter().copied().filter(|word| !word.is_empty());
        let words: Vec<&str> = words.collect();
        let tags: Vec<usize> = match is_range {
            false => words.iter().filter_map(|word| word.parse().ok()).collect(),
            true => range(&words)?,
        };
        let others = || words.iter().filter(|word| word.parse::<usize>().is_err());
        if let Some(part) = self.part() {
            let sets = match of_nodes {
                true => &mut part.node_sets,
                false => &mut part.element_sets,
            };
            let mut members = tags;
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
            (None, other) => return Err(fault!("there is no instance {other:?}")),
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
    pub fn found(&self, name: &str, of_nodes: bool) -> Vec<Label> {
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

    fn position(&mut self, words: &[&str]) -> Result<(), Fault> {
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

fn number<T: std::str::FromStr>(word: &str) -> Result<T, Fault> {
    // Fortran's exponents
    let plain = word.replace(['D', 'd'], "e");
    plain
        .parse()
        .map_err(|_| Fault::unexpected("a number", word))
}

/// The numbers of a range: the first, the last, and perhaps the step.
fn range(words: &[&str]) -> Result<Vec<usize>, Fault> {
    let numbers: Result<Vec<usize>, _> = words.iter().map(|word| number(word)).collect();
    let [first, last, step @ ..] = &numbers?[..] else {
        return Err("expected the first and the last of a range".into());
    };
    if last.saturating_sub(*first) > 100_000_000 {
        return Err(fault!(
            "the range from {first} to {last} is longer than any mesh"
        ));
    }
    let step = step.first().copied().unwrap_or(1).max(1);
    Ok((*first..=*last).step_by(step).collect())
}
