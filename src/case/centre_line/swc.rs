//! Trees of points in SWC: rows of `id type x y z radius parent`, where the root has the parent -1. A branch is the way from
//! the root to an end, by whose number it is called.

use super::{CentreLine, listed};
use crate::case::text_file;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

struct Node {
    point: [f64; 3],
    radius: f64,
    parent: i64,
    line: usize,
}

pub fn read(path: &Path, branch: Option<&str>) -> Result<CentreLine, String> {
    let text = text_file::read(path, text_file::OF_A_CURVE).map_err(|error| error.to_string())?;
    let mut nodes: BTreeMap<i64, Node> = BTreeMap::new();
    for (number, row) in text.lines().enumerate() {
        let line = number + 1;
        let row = row.split('#').next().unwrap_or_default().trim();
        if row.is_empty() {
            continue;
        }
        let fields: Vec<&str> = row.split_whitespace().collect();
        let wrong =
            || format!("line {line}: expected \"id type x y z radius parent\", found {row:?}");
        let [id, _, x, y, z, r, parent] = fields[..] else {
            return Err(wrong());
        };
        let whole = |word: &str| word.parse::<i64>().map_err(|_| wrong());
        let real = |word: &str| {
            let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
            number.ok_or_else(wrong)
        };
        let node = Node {
            point: [real(x)?, real(y)?, real(z)?],
            radius: real(r)?,
            parent: whole(parent)?,
            line,
        };
        if node.radius <= 0.0 {
            return Err(format!("line {line}: expected a radius above 0, found {r}"));
        }
        if nodes.insert(whole(id)?, node).is_some() {
            return Err(format!("line {line}: there is another point {id}"));
        }
    }
    if let Some(node) =
        (nodes.values()).find(|node| node.parent >= 0 && !nodes.contains_key(&node.parent))
    {
        return Err(format!(
            "line {}: there is no point {}, its parent",
            node.line, node.parent
        ));
    }
    let parents: BTreeSet<i64> = nodes.values().map(|node| node.parent).collect();
    let ends: Vec<i64> = nodes
        .keys()
        .copied()
        .filter(|id| !parents.contains(id))
        .collect();
    let offered = || {
        let describe = |id: &i64| match way(&nodes, *id) {
            Ok(way) => format!("\"{id}\" ({} points)", way.len()),
            Err(_) => format!("\"{id}\""),
        };
        listed(&ends.iter().map(describe).collect::<Vec<_>>())
    };
    let end = match (branch, &ends[..]) {
        (None, [end]) => *end,
        (None, []) if nodes.is_empty() => return Ok(CentreLine::default()),
        (None, []) => {
            return Err("the points form a circle: the root must have the parent -1".into());
        }
        (None, _) => {
            return Err(format!(
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
    let way = way(&nodes, end)?;
    Ok(CentreLine {
        points: way.iter().map(|node| node.point).collect(),
        radii: way.iter().map(|node| node.radius).collect(),
    })
}

/// From the root to a point.
fn way(nodes: &BTreeMap<i64, Node>, end: i64) -> Result<Vec<&Node>, String> {
    let (mut way, mut next) = (Vec::new(), end);
    while let Some(node) = nodes.get(&next) {
        way.push(node);
        next = node.parent;
        if way.len() > nodes.len() {
            return Err(format!(
                "line {}: this point is its own ancestor",
                node.line
            ));
        }
    }
    way.reverse();
    Ok(way)
}
