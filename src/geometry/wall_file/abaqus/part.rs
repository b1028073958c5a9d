//! What a part of an Abaqus model has, before it is put into the wall.

use crate::Vec3;
use nalgebra::{Rotation3, Unit};
use std::collections::{BTreeMap, BTreeSet};

/// Numbers within an instance: its index and the label there.
pub type Label = (usize, usize);

/// Nodes, elements, sets and surfaces that were written together.
#[derive(Default, Clone)]
pub struct Part {
    pub nodes: BTreeMap<usize, Vec3>,
    pub solids: BTreeMap<usize, Vec<usize>>,
    pub quads: BTreeMap<usize, Vec<usize>>,
    pub element_sets: Sets<usize>,
    pub node_sets: Sets<usize>,
    /// Name, set or element, face, and the place.
    pub surfaces: Vec<(String, String, usize, String)>,
    /// Set and material.
    pub sections: Vec<(String, String)>,
}

/// A part at its place.
pub struct Instance {
    pub name: String,
    pub part: Part,
    pub translation: Vec3,
    /// Two points of the axis, and the angle, degrees.
    pub rotation: Option<([Vec3; 2], f64)>,
    /// Lines of its position that were read.
    pub lines: usize,
}

impl Instance {
    /// Where a node comes to lie: translated first, then turned.
    pub fn place(&self, x: &Vec3) -> Vec3 {
        let x = x + self.translation;
        match &self.rotation {
            None => x,
            Some(([a, b], angle)) => {
                let turn =
                    Rotation3::from_axis_angle(&Unit::new_normalize(b - a), angle.to_radians());
                a + turn * (x - a)
            }
        }
    }
}

/// Sets by their names, in the order of the file; upper and lower case are the same.
#[derive(Clone)]
pub struct Sets<T>(pub Vec<(String, BTreeSet<T>)>);

impl<T> Default for Sets<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Ord + Copy> Sets<T> {
    pub fn find(&self, name: &str) -> Option<&BTreeSet<T>> {
        let mut sets = self.0.iter();
        let found = sets.find(|(known, _)| known.eq_ignore_ascii_case(name));
        found.map(|(_, members)| members)
    }

    /// Those of a set, which is added if it is new.
    pub fn members(&mut self, name: &str) -> &mut BTreeSet<T> {
        let mut sets = self.0.iter();
        let known = sets.position(|(known, _)| known.eq_ignore_ascii_case(name));
        let place = known.unwrap_or_else(|| {
            self.0.push((name.to_owned(), BTreeSet::new()));
            self.0.len() - 1
        });
        &mut self.0[place].1
    }
}
