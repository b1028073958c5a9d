//! Global numbering of the modes of all elements, continuous across elements of any orientation.
//!
//! Every mode belongs to a vertex, edge, face or the interior of its element. Edges run from their lower to their
//! higher global vertex; a face has its origin at its lowest vertex and its first axis towards the lower one of the two
//! neighbours of the origin. A mode that runs along an axis against its global direction changes its sign if its index
//! along it is odd; on faces the two indices may change places. Where neighbours have different degrees along a
//! shared edge or face, only the modes that all of them have are kept.

use super::super::SolidError;
use super::{Mode, Space};
use crate::mesh::HexMesh;
use std::collections::HashMap;

/// What a mode belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Entity {
    Vertex(usize),
    Edge([usize; 2]),
    Face([usize; 4]),
    Interior(usize),
}

/// Global function numbers and signs of the modes of each element.
#[derive(Debug, Clone)]
pub struct Numbering {
    /// The modes, the same for all elements.
    pub modes: Vec<Mode>,
    /// Number of global functions.
    pub functions: usize,
    /// `of_element[e][m]`: global function of mode `m`, `None` if a neighbour lacks it.
    pub of_element: Vec<Vec<Option<usize>>>,
    /// `signs[e][m]`: mode `m` of element `e` is this times the global function.
    pub signs: Vec<Vec<f64>>,
    /// Global function of each mesh vertex.
    pub of_vertex: Vec<usize>,
}

impl Numbering {
    /// Numbers the modes of `space` on `mesh`.
    pub fn new(mesh: &HexMesh, space: &Space) -> Result<Self, SolidError> {
        let modes = space.modes();
        let located: Vec<Vec<((Entity, Mode), f64)>> = (0..mesh.hexes.len())
            .map(|e| {
                let vertices = &mesh.hexes[e];
                modes.iter().map(|&m| locate(e, vertices, m)).collect()
            })
            .collect();

        let mut sharing: HashMap<Entity, usize> = HashMap::new();
        let mut having: HashMap<(Entity, Mode), usize> = HashMap::new();
        for element in &located {
            let mut entities: Vec<Entity> =
                element.iter().map(|((entity, _), _)| *entity).collect();
            entities.sort_unstable_by_key(|entity| format_key(*entity));
            entities.dedup();
            for entity in entities {
                *sharing.entry(entity).or_default() += 1;
            }
            for (key, _) in element {
                *having.entry(*key).or_default() += 1;
            }
        }

        let mut numbers: HashMap<(Entity, Mode), usize> = HashMap::new();
        let mut of_element = Vec::with_capacity(located.len());
        let mut signs = Vec::with_capacity(located.len());
        for element in &located {
            let mut functions = Vec::with_capacity(modes.len());
            for (key, _) in element {
                let everywhere = having[key] == sharing[&key.0];
                functions.push(everywhere.then(|| {
                    let next = numbers.len();
                    *numbers.entry(*key).or_insert(next)
                }));
            }
            of_element.push(functions);
            signs.push(element.iter().map(|(_, sign)| *sign).collect());
        }
        let of_vertex = (0..mesh.vertices.len())
            .map(|v| {
                let key = (Entity::Vertex(v), [0; 3]);
                numbers.get(&key).copied().ok_or_else(|| {
                    SolidError::Model(format!("vertex {v} of the mesh belongs to no element"))
                })
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            modes,
            functions: numbers.len(),
            of_element,
            signs,
            of_vertex,
        })
    }
}

/// A sortable stand-in for an entity.
fn format_key(entity: Entity) -> (u8, [usize; 4]) {
    match entity {
        Entity::Vertex(v) => (0, [v, 0, 0, 0]),
        Entity::Edge([a, b]) => (1, [a, b, 0, 0]),
        Entity::Face(v) => (2, v),
        Entity::Interior(e) => (3, [e, 0, 0, 0]),
    }
}

/// Entity, indices with respect to the entity's own axes, and sign of a mode of an element.
fn locate(element: usize, vertices: &[usize; 8], mode: Mode) -> ((Entity, Mode), f64) {
    let high: Vec<usize> = (0..3).filter(|&d| mode[d] > 1).collect();
    let corner: usize = (0..3).filter(|&d| mode[d] == 1).map(|d| 1 << d).sum();
    let parity = |index: usize, reversed: bool| {
        if reversed && index % 2 == 1 {
            -1.0
        } else {
            1.0
        }
    };
    match high[..] {
        [] => ((Entity::Vertex(vertices[corner]), [0; 3]), 1.0),
        [d] => {
            let (tail, head) = (vertices[corner], vertices[corner | 1 << d]);
            let edge = Entity::Edge([tail.min(head), tail.max(head)]);
            ((edge, [mode[d], 0, 0]), parity(mode[d], tail > head))
        }
        [a, b] => {
            let at = |i: usize, j: usize| vertices[corner | i << a | j << b];
            let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
            let (i, j) = corners
                .into_iter()
                .min_by_key(|&(i, j)| at(i, j))
                .unwrap_or((0, 0));
            let swapped = at(1 - i, j) > at(i, 1 - j);
            let mut key = corners.map(|(i, j)| at(i, j));
            key.sort_unstable();
            let indices = if swapped {
                [mode[b], mode[a], 0]
            } else {
                [mode[a], mode[b], 0]
            };
            let sign = parity(mode[a], i == 1) * parity(mode[b], j == 1);
            ((Entity::Face(key), indices), sign)
        }
        _ => ((Entity::Interior(element), mode), 1.0),
    }
}
