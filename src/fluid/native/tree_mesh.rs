//! Elements in the lumen of a tree: stacks of cross-sections of an O-grid, which meet at its junctions.
//!
//! All nodes of a cross-section follow from those on the wall and from its middle, by a fixed blend. The middle goes
//! with the wall around it, at a junction with the two points of the wall where the axis of that ends: so the mesh
//! depends on the wall's displacement alone, and branches that meet agree.

use super::basis::Basis;
use super::lumen_mesh::LumenMesh;
use super::surface::face_values;
use super::taylor_hood_space::{Boundary, Face, Hexahedra, Side, TaylorHoodSpace};
use crate::Vec3;
use crate::fluid::FluidInterface;
use crate::fluid::field::equally_spaced;
use crate::geometry::tree::{Block, Displaced, Numbers, Outside, Tree};
use crate::lagrange;
use rayon::prelude::*;
use std::ops::Range;

/// Where the positions of nodes come from: those of a cross-section, or of a block at an end.
#[derive(Debug, Clone)]
struct Source {
    /// The stack.
    stack: usize,
    /// Number of the cross-section; those of the blocks at the two ends follow.
    section: usize,
    /// Nodes, and which of its points they are.
    nodes: Vec<(u32, u32)>,
}

/// The mesh of a tree's lumen.
#[derive(Debug, Clone)]
pub struct TreeMesh {
    space: TaylorHoodSpace,
    tree: Tree,
    sources: Vec<Source>,
    /// Places among the wall's nodes of those of the rims, by stack and cross-section, and of the tops; there is none
    /// in holes and plugs.
    rims: Vec<Vec<Vec<Option<u32>>>>,
    tops: Vec<Vec<Option<u32>>>,
    walls: Vec<Face>,
    /// For each node of the wall the face, and the place on it, that it takes its displacement from; the points of the
    /// lattice have the same order.
    of_walls: Vec<(u32, u32)>,
    /// Places of the nodes of each face among those.
    lattice_of_faces: Vec<Vec<u32>>,
    interface: FluidInterface,
    /// Row `i`: values at node `i` of an element's side from those at the lattice's points on it.
    from_lattice: Vec<Vec<f64>>,
}

impl TreeMesh {
    /// The mesh of a tree whose points are the nodes of elements of the degree `degree`.
    pub fn new(tree: Tree, degree: usize) -> Self {
        let basis = Basis::new(degree);
        let (_, numbers) = tree.points(1.0);
        let blocks = tree.blocks(&numbers);
        let space = TaylorHoodSpace::of_hexahedra(elements(&blocks, degree), degree);
        let walls = space.faces_of(|patch| matches!(patch, Boundary::Mantle(_)));
        let wall_nodes = space.nodes_of(&walls);
        let known = |node: usize| wall_nodes.binary_search(&node).ok().map(|i| i as u32);
        let place = |node: usize| known(node).expect("it is on the wall");
        let lattice_of_faces: Vec<Vec<u32>> = (walls.iter())
            .map(|face| {
                let nodes = face.side.places(degree + 1).into_iter();
                nodes
                    .map(|k| place(space.element(face.element)[k] as usize))
                    .collect()
            })
            .collect();
        let mut of_walls = vec![None; wall_nodes.len()];
        for (face, places) in lattice_of_faces.iter().enumerate() {
            for (k, &place) in places.iter().enumerate() {
                of_walls[place as usize].get_or_insert((face as u32, k as u32));
            }
        }
        let uniform = equally_spaced(degree);
        let mut node_of = vec![None; numbers.count];
        for (element, block) in blocks.iter().enumerate() {
            for (&point, &node) in block.points.iter().zip(space.element(element)) {
                node_of[point] = Some(node);
            }
        }
        let node = |point: usize| node_of.get(point).copied().flatten();
        let on_wall = |point: usize| known(node(point)? as usize);
        let (grid, outer) = (tree.grid(), tree.grid().rings.len());
        let rims = (tree.stacks().iter().zip(&numbers.sections))
            .map(|(stack, sections)| {
                let plugged = tree.plugged(stack);
                let rim = |(j, points): (usize, &Vec<usize>)| match j < plugged {
                    true => Vec::new(),
                    false => (0..grid.around())
                        .map(|a| on_wall(points[grid.ring_point(outer, a)]))
                        .collect(),
                };
                sections.iter().enumerate().map(rim).collect()
            })
            .collect();
        let top = |caps: &[Option<Vec<usize>>; 2]| -> Vec<Option<u32>> {
            let points = caps[1].iter().flatten().copied();
            let outside = points.skip(outer * (grid.core + 1).pow(2));
            outside.map(on_wall).collect()
        };
        let mut mesh = Self {
            sources: sources(&numbers, &node, space.nodes),
            rims,
            tops: numbers.caps.iter().map(top).collect(),
            of_walls: of_walls.into_iter().flatten().collect(),
            from_lattice: (basis.nodes.points.iter())
                .map(|&x| lagrange::values(&uniform, x))
                .collect(),
            interface: FluidInterface {
                points: Vec::new(),
                faces: Vec::new(),
                face_centres: Vec::new(),
            },
            walls,
            lattice_of_faces,
            space,
            tree,
        };
        mesh.interface = mesh.lattice(&basis.nodes.points, &uniform);
        mesh
    }

    /// The wall at rest at equal distances within each face, as the elements' polynomials have it.
    fn lattice(&self, nodes: &[f64], uniform: &[f64]) -> FluidInterface {
        let degree = uniform.len() - 1;
        let rest = self.nodes(&vec![Vec3::zeros(); self.of_walls.len()]);
        let rows = |places: &[f64]| -> Vec<Vec<f64>> {
            places.iter().map(|&x| lagrange::values(nodes, x)).collect()
        };
        let middles: Vec<f64> = (0..degree)
            .map(|i| 0.5 * (uniform[i] + uniform[i + 1]))
            .collect();
        let (at_points, at_middles) = (rows(uniform), rows(&middles));
        let mut points = vec![Vec3::zeros(); self.of_walls.len()];
        let (mut faces, mut face_centres) = (Vec::new(), Vec::new());
        for (number, (face, places)) in self.walls.iter().zip(&self.lattice_of_faces).enumerate() {
            let element = self.space.element(face.element);
            let of_face = face.side.places(degree + 1).into_iter();
            let positions: Vec<Vec3> = of_face.map(|k| rest[element[k] as usize]).collect();
            let on_lattice = face_values(&at_points, &at_points, &positions);
            for (k, (&place, x)) in places.iter().zip(on_lattice).enumerate() {
                if self.of_walls[place as usize] == (number as u32, k as u32) {
                    points[place as usize] = x;
                }
            }
            face_centres.extend(face_values(&at_middles, &at_middles, &positions));
            for part in 0..degree * degree {
                let (i, j) = (part % degree, part / degree);
                let at = |i: usize, j: usize| places[j * (degree + 1) + i];
                faces.push(vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        FluidInterface {
            points,
            faces,
            face_centres,
        }
    }

    /// Positions (m) of all nodes when those of the wall are displaced (m).
    fn nodes(&self, of_wall: &[Vec3]) -> Vec<Vec3> {
        let moved = |places: &[Option<u32>]| -> Vec<Vec3> {
            let all = places.iter();
            all.map(|i| i.map_or(Vec3::zeros(), |i| of_wall[i as usize]))
                .collect()
        };
        let positions = self.tree.positions(
            1.0,
            Some(&Displaced {
                rim: &|stack, section| moved(&self.rims[stack][section]),
                top: &|stack| moved(&self.tops[stack]),
            }),
        );
        let mut nodes = vec![Vec3::zeros(); self.space.nodes];
        for source in &self.sources {
            let sections = &positions.sections[source.stack];
            let at = match source.section.checked_sub(sections.len()) {
                None => &sections[source.section],
                Some(end) => positions.caps[source.stack][end]
                    .as_ref()
                    .expect("it has one"),
            };
            for &(node, point) in &source.nodes {
                nodes[node as usize] = at[point as usize];
            }
        }
        nodes
    }
}

impl LumenMesh for TreeMesh {
    fn space(&self) -> &TaylorHoodSpace {
        &self.space
    }

    fn interface(&self) -> &FluidInterface {
        &self.interface
    }

    fn moving_walls(&self) -> Vec<Face> {
        self.walls.clone()
    }

    fn parts(&self) -> Vec<(usize, usize)> {
        let parts = self.space.degree.pow(2);
        (0..self.interface.faces.len())
            .map(|face| (face / parts, face % parts))
            .collect()
    }

    fn elastic_elements(&self) -> Range<usize> {
        0..self.space.elements
    }

    fn positions(&self, displacement: &[Vec3]) -> Vec<f64> {
        let rows = &self.from_lattice;
        let of_faces: Vec<Vec<Vec3>> = (self.lattice_of_faces.par_iter())
            .map(|places| {
                let lattice: Vec<Vec3> = places.iter().map(|&i| displacement[i as usize]).collect();
                face_values(rows, rows, &lattice)
            })
            .collect();
        let of_wall: Vec<Vec3> = (self.of_walls.iter())
            .map(|&(face, k)| of_faces[face as usize][k as usize])
            .collect();
        let nodes = self.nodes(&of_wall);
        (0..3)
            .flat_map(|c| nodes.iter().map(move |x| x[c]))
            .collect()
    }
}

/// Where nodes have their positions from: the first cross-section, or block at an end, that has them.
fn sources(numbers: &Numbers, node: &dyn Fn(usize) -> Option<u32>, nodes: usize) -> Vec<Source> {
    let mut is_placed = vec![false; nodes];
    let mut all = Vec::new();
    for (stack, (sections, caps)) in numbers.sections.iter().zip(&numbers.caps).enumerate() {
        let ends = (caps.iter().enumerate())
            .filter_map(|(end, cap)| Some((sections.len() + end, cap.as_ref()?)));
        for (section, points) in sections.iter().enumerate().chain(ends) {
            let mut own = Vec::new();
            for (point, &number) in points.iter().enumerate() {
                if let Some(node) = node(number)
                    && !std::mem::replace(&mut is_placed[node as usize], true)
                {
                    own.push((node, point as u32));
                }
            }
            all.push(Source {
                stack,
                section,
                nodes: own,
            });
        }
    }
    all
}

/// The elements stack by stack, layer by layer downstream.
fn elements(blocks: &[Block], degree: usize) -> Hexahedra {
    let n = degree + 1;
    let mut mesh = Hexahedra::default();
    for (element, block) in blocks.iter().enumerate() {
        let corner = |v: usize| [v & 1, v >> 1 & 1, v >> 2].map(|bit| bit * degree);
        mesh.corners.push(std::array::from_fn(|v| {
            let [i, j, k] = corner(v);
            block.points[(k * n + j) * n + i]
        }));
        for &(axis, upper, outside) in &block.sides {
            mesh.faces.push(Face {
                element,
                side: Side { axis, upper },
                patch: match outside {
                    Outside::Opening(number) => Boundary::End(number),
                    Outside::Wall(number) => Boundary::Mantle(number),
                },
            });
        }
    }
    mesh
}
