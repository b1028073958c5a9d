//! Trees of points in SWC: rows of `id type x y z radius parent`, where the root has a parent that there is not, -1
//! or 0. A branch is the way from the root to an end, by whose number it is called.

use super::LineFile;
use super::{CentreLine, MOST_NAMED, listed};
use crate::files::{Fault, fault, read_regular, text};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Far larger than any tree that was traced.
const MOST_BYTES: u64 = 64 << 20;

struct Node {
    point: [f64; 3],
    radius: f64,
    parent: i64,
    line: usize,
}

pub fn read(path: &Path, branch: Option<&str>) -> Result<LineFile, Fault> {
    let (nodes, scale) = load(path)?;
    let ends = ends(&nodes);
    let offered = || {
        let describe = |id: &i64| format!("\"{id}\" ({} points)", way(&nodes, *id).len());
        listed(&ends.iter().map(describe).collect::<Vec<_>>(), MOST_NAMED)
    };
    let end = match (branch, &ends[..]) {
        (None, [end]) => *end,
        (None, []) => return Ok(LineFile::default()),
        (None, _) => {
            return Err(fault!(
                "the tree has {} ends: choose one by vessel.branch = {}",
                ends.len(),
                offered()
            ));
        }
        (Some(branch), _) => {
            let known = branch
                .trim()
                .parse()
                .ok()
                .filter(|id| nodes.contains_key(id));
            known.ok_or_else(|| {
                format!("there is no point {branch:?}; the ends are {}", offered())
            })?
        }
    };
    let way = way(&nodes, end);
    if let Some(node) = way.iter().find(|node| node.radius <= 0.0) {
        return Err(fault!(
            "line {}: expected a radius above 0, found {}",
            node.line,
            node.radius
        ));
    }
    Ok(LineFile {
        line: scaled(&way, scale),
        unit: None,
        understood: format!(
            "SWC with {} points, {} of them from the root to point {end}{}",
            nodes.len(),
            way.len(),
            match scale {
                [1.0, 1.0, 1.0] => String::new(),
                [x, y, z] => format!("; multiplied by its SCALE {x} {y} {z}"),
            }
        ),
    })
}

/// The ways from the root to each end, as points and radii in the unit of the file.
pub fn all(path: &Path) -> Result<Vec<CentreLine>, Fault> {
    let (nodes, scale) = load(path)?;
    let line = |end: &i64| scaled(&way(&nodes, *end), scale);
    Ok(ends(&nodes).iter().map(line).collect())
}

/// The points of a file by their numbers, and what their coordinates are to be multiplied by.
fn load(path: &Path) -> Result<(BTreeMap<i64, Node>, [f64; 3]), Fault> {
    let bytes = read_regular(path, MOST_BYTES).map_err(|error| error.to_string())?;
    nodes(&text::decode(&bytes)?)
}

/// Points that are the parent of no other.
fn ends(nodes: &BTreeMap<i64, Node>) -> Vec<i64> {
    let parents: BTreeSet<i64> = nodes.values().map(|node| node.parent).collect();
    let ends = nodes.keys().filter(|id| !parents.contains(id));
    ends.copied().collect()
}

/// Points and radii of nodes.
fn scaled(way: &[&Node], scale: [f64; 3]) -> CentreLine {
    let mean = scale.iter().product::<f64>().cbrt();
    CentreLine {
        points: (way.iter())
            .map(|node| [0, 1, 2].map(|c| node.point[c] * scale[c]))
            .collect(),
        radii: way.iter().map(|node| node.radius * mean).collect(),
    }
}

/// All points by their numbers, and what their coordinates are to be multiplied by.
fn nodes(text: &str) -> Result<(BTreeMap<i64, Node>, [f64; 3]), Fault> {
    let mut nodes: BTreeMap<i64, Node> = BTreeMap::new();
    let mut scale = [1.0; 3];
    for (line, row) in text::lines(text) {
        let (row, comment) = row.split_once('#').unwrap_or((row, ""));
        if let Some(found) = scale_of(comment, line)? {
            scale = found;
        }
        let row = row.trim();
        let fields: Vec<&str> = (row.split(|c: char| c.is_whitespace() || c == ','))
            .filter(|field| !field.is_empty())
            .collect();
        if fields.is_empty()
            || nodes.is_empty() && fields[0].parse::<f64>().is_err() && fields.len() > 1
        {
            continue; // names of the columns
        }
        let wrong = || {
            Fault::at(
                line,
                format_args!("expected \"id type x y z radius parent\", found {row:?}"),
            )
        };
        // What follows the parent belongs to other programs.
        let [id, _, x, y, z, r, parent, ..] = fields[..] else {
            return Err(wrong());
        };
        let real = |word: &str| {
            let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
            number.ok_or_else(wrong)
        };
        let whole = |word: &str| {
            real(word).and_then(|x| {
                if x.fract() == 0.0 {
                    Ok(x as i64)
                } else {
                    Err(wrong())
                }
            })
        };
        let node = Node {
            point: [real(x)?, real(y)?, real(z)?],
            radius: real(r)?,
            parent: whole(parent)?,
            line,
        };
        if nodes.insert(whole(id)?, node).is_some() {
            return Err(Fault::at(line, format_args!("there is another point {id}")));
        }
    }
    let mut orphans = nodes
        .values()
        .filter(|node| node.parent > 0 && !nodes.contains_key(&node.parent));
    if let Some(node) = orphans.next() {
        let parent = node.parent;
        return Err(Fault::at(
            node.line,
            format_args!("there is no point {parent}, its parent"),
        ));
    }
    match in_a_cycle(&nodes) {
        Some(node) => Err(Fault::at(
            node.line,
            "this point is its own ancestor: a tree has no cycles, and its root has the parent -1",
        )),
        None => Ok((nodes, scale)),
    }
}

/// A point that is its own ancestor, unless it is a root that names itself.
fn in_a_cycle(nodes: &BTreeMap<i64, Node>) -> Option<&Node> {
    let mut seen_from: BTreeMap<i64, i64> = BTreeMap::new();
    for start in nodes.keys() {
        let mut at = *start;
        while let Some(node) = nodes.get(&at).filter(|node| node.parent != at) {
            match seen_from.insert(at, *start) {
                Some(other) if other == *start => return Some(node),
                Some(_) => break,
                None => at = node.parent,
            }
        }
    }
    None
}

/// The factors of a comment `SCALE x y z`.
fn scale_of(comment: &str, line: usize) -> Result<Option<[f64; 3]>, Fault> {
    let mut words = comment.split_whitespace();
    if words.next() != Some("SCALE") {
        return Ok(None);
    }
    let factors: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
    match factors[..] {
        [] => Ok(None),
        [all] if all > 0.0 && all.is_finite() => Ok(Some([all; 3])),
        [x, y, z] if [x, y, z].iter().all(|f| *f > 0.0 && f.is_finite()) => Ok(Some([x, y, z])),
        _ => Err(fault!(
            "line {line}: expected SCALE and three numbers above 0, found {comment:?}"
        )),
    }
}

/// From the root, which may name itself, to a point.
fn way(nodes: &BTreeMap<i64, Node>, end: i64) -> Vec<&Node> {
    let (mut way, mut next) = (Vec::new(), Some(end));
    while let Some((id, node)) = next.and_then(|id| nodes.get_key_value(&id)) {
        way.push(node);
        next = (node.parent != *id).then_some(node.parent);
    }
    way.reverse();
    way
}
