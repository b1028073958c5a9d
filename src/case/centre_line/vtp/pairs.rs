//! Trees of lines that join two points each. SimVascular's reduced-order models tell the branches apart by numbers of
//! the points: `CenterlineId` has a component for each outlet, 1 for points on the way there; `BranchId` numbers the
//! tracts between bifurcations, where it is -1.

use super::{MOST_NAMED, listed};
use crate::files::{Fault, fault};
use crate::polydata::PolyData;
use std::collections::{BTreeMap, HashMap};

/// Points joined by pairs.
pub struct Tree<'a> {
    data: &'a PolyData,
    neighbours: BTreeMap<usize, Vec<usize>>,
    /// Where all ways begin.
    root: usize,
    /// The other ends.
    ends: Vec<usize>,
}

/// The point before each one that can be reached from the root, and how many there are before it.
type Previous = BTreeMap<usize, Option<(usize, usize)>>;

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
        let first = first_at_its_place(&data.points);
        let mut neighbours: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for pair in &data.lines {
            let [a, b] = [first[pair[0]], first[pair[1]]];
            if a == b || neighbours.get(&a).is_some_and(|others| others.contains(&b)) {
                continue;
            }
            neighbours.entry(a).or_default().push(b);
            neighbours.entry(b).or_default().push(a);
        }
        let ends = neighbours.iter().filter(|(_, others)| others.len() == 1);
        let mut ends: Vec<usize> = ends.map(|(point, _)| *point).collect();
        // The first point of the file, or where a line begins and none ends.
        let begins = |point: &usize| data.lines.iter().any(|pair| first[pair[0]] == *point);
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
                [end] => self.way(end, &self.previous()),
                [] => Err("the lines form a cycle, which has no beginning: cut it open".into()),
                _ => Err(fault!(
                    "the file has a tree with {} ends: choose a branch by vessel.branch = {}",
                    self.ends.len(),
                    self.offered()
                )),
            };
        };
        self.find(name, &self.previous())
            .ok_or_else(|| fault!("there is no branch {name:?}; there is {}", self.offered()))
    }

    /// The ways to all ends.
    ///
    /// # Errors
    /// If one cannot be reached, or there are two ways to one.
    pub fn ways(&self) -> Result<Vec<Vec<usize>>, Fault> {
        let previous = self.previous();
        let ways = self.ends.iter().map(|end| self.way(*end, &previous));
        let ways = ways.collect::<Result<_, _>>()?;
        let follows = |a: usize, b: usize| {
            let before = previous.get(&b).copied().flatten();
            before.is_some_and(|(point, _)| point == a)
        };
        let pairs = self.neighbours.iter();
        let mut pairs = pairs.flat_map(|(a, others)| others.iter().map(|b| (*a, *b)));
        match pairs.find(|&(a, b)| !follows(a, b) && !follows(b, a)) {
            None => Ok(ways),
            Some((point, _)) => {
                let [x, y, z] = self.data.points[point];
                Err(fault!(
                    "the lines form a cycle, through ({x}, {y}, {z}): a tree has one way to each place, so cut it open"
                ))
            }
        }
    }

    /// The points of the branch of this name, downstream.
    fn find(&self, name: &str, previous: &Previous) -> Option<Vec<usize>> {
        let (array, value) = name.split_once('=')?;
        let value: i64 = value.trim().parse().ok()?;
        match array.trim() {
            "End" => {
                let end = usize::try_from(value).ok()?;
                let is_end = self.ends.contains(&end);
                is_end.then(|| self.way(end, previous).ok()).flatten()
            }
            WAYS => self.of_value(&format!("{WAYS}:{value}"), 1.0, previous),
            array => self.of_value(array, value as f64, previous),
        }
    }

    /// From the root to an end, by the point before each.
    fn way(&self, end: usize, previous: &Previous) -> Result<Vec<usize>, Fault> {
        let mut way = vec![end];
        while let Some((point, _)) = previous.get(&way[way.len() - 1]).copied().flatten() {
            way.push(point);
        }
        way.reverse();
        match way[0] == self.root {
            true => Ok(way),
            false => {
                let [x, y, z] = self.data.points[self.root];
                let [a, b, c] = self.data.points[end];
                Err(fault!(
                    "no line leads from ({x}, {y}, {z}), where the tree begins, to its end at ({a}, {b}, {c}): the tree is torn"
                ))
            }
        }
    }

    fn previous(&self) -> Previous {
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
    fn of_value(&self, array: &str, value: f64, previous: &Previous) -> Option<Vec<usize>> {
        let values = self.data.of_points.get(array)?;
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
        let previous = self.previous();
        let described = names.iter().enumerate().map(|(i, name)| {
            // The others are only counted.
            let shown = (i < MOST_NAMED).then(|| self.find(name, &previous));
            match shown.flatten() {
                Some(points) => format!(
                    "\"{name}\" ({} points, {:.4} long)",
                    points.len(),
                    self.length(&points)
                ),
                None => format!("\"{name}\""),
            }
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

/// For each point the first one at its place: programs that put lines together do not always join their points.
fn first_at_its_place(points: &[[f64; 3]]) -> Vec<usize> {
    let mut known = HashMap::new();
    let places = points.iter().enumerate();
    // Zero has two signs.
    let bits = |place: &[f64; 3]| place.map(|x| (x + 0.0).to_bits());
    places
        .map(|(i, place)| *known.entry(bits(place)).or_insert(i))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(points: &[[f64; 3]], lines: &[[usize; 2]]) -> PolyData {
        PolyData {
            points: points.to_vec(),
            lines: lines.iter().map(|pair| pair.to_vec()).collect(),
            ..PolyData::default()
        }
    }

    /// A Y each of whose lines has points of its own, in any order: points at one place are one.
    #[test]
    fn points_at_one_place_are_one() {
        let [root, fork, left, right] = [
            [0.0, 0.0, 0.0],
            [1.0, -0.0, 0.0],
            [2.0, 1.0, 0.0],
            [2.0, -1.0, 0.0],
        ];
        let again = [1.0, 0.0, 0.0];
        let data = pairs(
            &[root, fork, again, left, right, fork],
            &[[0, 1], [2, 3], [5, 4], [2, 5]],
        );
        let ways = Tree::new(&data).unwrap().ways().unwrap();
        assert_eq!(ways, [[0, 1, 3], [0, 1, 4]]);
    }

    /// What is not joined is not reached.
    #[test]
    fn a_torn_tree_says_where() {
        let points = [0.0, 1.0, 1.5, 2.0].map(|x| [x, 0.0, 0.0]);
        let data = pairs(&points, &[[0, 1], [2, 3]]);
        let reason = Tree::new(&data).unwrap().ways().unwrap_err().to_string();
        let expected = "no line leads from (0, 0, 0), where the tree begins, to its end at (1.5, 0, 0): the tree is torn";
        assert_eq!(reason, expected);
    }

    /// A tree has one way to each of its ends.
    #[test]
    fn a_cycle_is_refused() {
        let square = [
            [1.0, 0.0, 0.0],
            [2.0, 1.0, 0.0],
            [3.0, 0.0, 0.0],
            [2.0, -1.0, 0.0],
        ];
        let points = [&[[0.0; 3]][..], &square, &[[4.0, 0.0, 0.0]]].concat();
        let lines = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 1], [3, 5]];
        let data = pairs(&points, &lines);
        let reason = Tree::new(&data).unwrap().ways().unwrap_err().to_string();
        assert!(
            reason.contains("the lines form a cycle, through ("),
            "{reason}"
        );
        // Half of it is none.
        let data = pairs(&points, &lines[..4]);
        assert!(Tree::new(&data).unwrap().ways().is_ok());
    }
}
