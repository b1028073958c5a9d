//! Trees of lines that join two points each. SimVascular's reduced-order models tell the branches apart by numbers of
//! the points: `CenterlineId` has a component for each outlet, 1 for points on the way there; `BranchId` numbers the
//! tracts between bifurcations, where it is -1.

use super::{MOST_NAMED, listed};
use crate::files::{Fault, fault};
use crate::polydata::PolyData;
use std::collections::BTreeMap;

/// Points joined by pairs.
pub struct Tree<'a> {
    data: &'a PolyData,
    neighbours: BTreeMap<usize, Vec<usize>>,
    /// Where all ways begin.
    root: usize,
    /// The other ends.
    ends: Vec<usize>,
}

/// Arrays of the points, and their components, that number ways from the root.
const WAYS: &str = "CenterlineId";
/// Arrays of the points that number tracts.
const TRACTS: [&str; 3] = ["BranchId", "GroupIds", "BranchIdTmp"];

impl<'a> Tree<'a> {
    /// The tree, if all lines have two points and there are several.
    pub fn new(data: &'a PolyData) -> Option<Self> {
        if data.lines.len() < 2 || data.lines.iter().any(|line| line.len() != 2) {
            return None;
        }
        let mut neighbours: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for pair in &data.lines {
            neighbours.entry(pair[0]).or_default().push(pair[1]);
            neighbours.entry(pair[1]).or_default().push(pair[0]);
        }
        let ends = neighbours.iter().filter(|(_, others)| others.len() == 1);
        let mut ends: Vec<usize> = ends.map(|(point, _)| *point).collect();
        // The first point of the file, or where a line begins and none ends.
        let begins = |point: &usize| data.lines.iter().any(|pair| pair[0] == *point);
        let place = (ends.iter().position(|end| *end == 0))
            .or_else(|| ends.iter().position(begins))
            .unwrap_or(0);
        let root = match ends.is_empty() {
            true => *neighbours.keys().next()?,
            false => ends.remove(place),
        };
        Some(Self {
            data,
            neighbours,
            root,
            ends,
        })
    }

    /// The points of a branch, downstream.
    ///
    /// # Errors
    /// Which there are, if there is none of this name, or none is named and there are several.
    pub fn branch(&self, name: Option<&str>) -> Result<Vec<usize>, Fault> {
        let Some(name) = name else {
            return match self.ends[..] {
                [end] => self.way(end),
                [] => Err("the lines form a cycle, which has no beginning: cut it open".into()),
                _ => Err(fault!(
                    "the file has a tree with {} ends: choose a branch by vessel.branch = {}",
                    self.ends.len(),
                    self.offered()
                )),
            };
        };
        self.find(name)
            .ok_or_else(|| fault!("there is no branch {name:?}; there is {}", self.offered()))
    }

    /// The ways to all ends.
    ///
    /// # Errors
    /// If one cannot be reached.
    pub fn ways(&self) -> Result<Vec<Vec<usize>>, Fault> {
        self.ends.iter().map(|end| self.way(*end)).collect()
    }

    /// The points of the branch of this name, downstream.
    fn find(&self, name: &str) -> Option<Vec<usize>> {
        let (array, value) = name.split_once('=')?;
        let value: i64 = value.trim().parse().ok()?;
        match array.trim() {
            "End" => {
                let end = usize::try_from(value).ok()?;
                let is_end = self.ends.contains(&end);
                is_end.then(|| self.way(end).ok()).flatten()
            }
            WAYS => self.of_value(&format!("{WAYS}:{value}"), 1.0),
            array => self.of_value(array, value as f64),
        }
    }

    /// From the root to an end.
    fn way(&self, end: usize) -> Result<Vec<usize>, Fault> {
        let previous = self.previous();
        let mut way = vec![end];
        while let Some((point, _)) = previous.get(&way[way.len() - 1]).copied().flatten() {
            way.push(point);
        }
        way.reverse();
        match way[0] == self.root {
            true => Ok(way),
            false => Err(fault!(
                "no line leads from the point {} to the point {end}: the tree is torn",
                self.root
            )),
        }
    }

    /// The point before each one that can be reached from the root, and how many there are before it.
    fn previous(&self) -> BTreeMap<usize, Option<(usize, usize)>> {
        let mut previous = BTreeMap::from([(self.root, None)]);
        let mut open = vec![(self.root, 1)];
        while let Some((point, depth)) = open.pop() {
            for next in self.neighbours.get(&point).into_iter().flatten() {
                if !previous.contains_key(next) {
                    previous.insert(*next, Some((point, depth)));
                    open.push((*next, depth + 1));
                }
            }
        }
        previous
    }

    /// The points that have a value, if they are one way downstream.
    fn of_value(&self, array: &str, value: f64) -> Option<Vec<usize>> {
        let values = self.data.of_points.get(array)?;
        let previous = self.previous();
        let has = |point: &usize| values.get(*point) == Some(&value);
        // The farthest of them, and from there up as long as they have it.
        let depth = |point: &usize| previous[point].map_or(0, |(_, depth)| depth);
        let last = (previous.keys().copied().filter(has)).max_by_key(depth)?;
        let mut way = vec![last];
        while let Some((above, _)) = previous[&way[way.len() - 1]].filter(|(above, _)| has(above)) {
            way.push(above);
        }
        way.reverse();
        (way.len() > 1).then_some(way)
    }

    /// The branches that there are.
    fn offered(&self) -> String {
        let mut names: Vec<String> = (0..)
            .map_while(|i| {
                self.data
                    .of_points
                    .get(&format!("{WAYS}:{i}"))
                    .map(|_| format!("{WAYS}={i}"))
            })
            .collect();
        if names.is_empty() {
            names = self.ends.iter().map(|end| format!("End={end}")).collect();
        }
        let tracts = TRACTS
            .iter()
            .find_map(|name| Some((*name, self.data.of_points.get(*name)?)));
        if let Some((name, values)) = tracts {
            let mut values: Vec<i64> = values
                .iter()
                .map(|value| *value as i64)
                .filter(|v| *v >= 0)
                .collect();
            values.sort_unstable();
            values.dedup();
            names.extend(values.iter().map(|value| format!("{name}={value}")));
        }
        let described = names.iter().map(|name| match self.find(name) {
            Some(points) => format!(
                "\"{name}\" ({} points, {:.4} long)",
                points.len(),
                self.length(&points)
            ),
            None => format!("\"{name}\""),
        });
        listed(&described.collect::<Vec<_>>(), MOST_NAMED)
    }

    fn length(&self, points: &[usize]) -> f64 {
        let at = |i: usize| crate::Vec3::from(self.data.points[i]);
        points
            .windows(2)
            .map(|pair| (at(pair[1]) - at(pair[0])).norm())
            .sum()
    }
}
