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
use crate::geometry::tree::{CrossSection, Middle, Tree};
use crate::lagrange;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;

/// The number of the opening where the root begins; a line ends at that of its own number plus one. Those of the mantle
/// are the numbers of the branches' walls.
const ROOT: usize = 0;

/// A cross-section of the mesh.
#[derive(Debug, Clone)]
struct MeshedSection {
    /// At rest.
    shape: CrossSection,
    middle: Middle,
    /// Places of the rim's nodes among the nodes of the wall.
    rim: Vec<u32>,
    /// Nodes that take their position from this cross-section, and which of its points they are.
    nodes: Vec<(u32, u32)>,
}

/// The mesh of a tree's lumen.
#[derive(Debug, Clone)]
pub struct TreeMesh {
    space: TaylorHoodSpace,
    tree: Tree,
    sections: Vec<MeshedSection>,
    /// Shares of the points of a rim in the mean over the angle.
    around: Vec<f64>,
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
        let space = TaylorHoodSpace::of_hexahedra(elements(&tree, degree), degree);
        let walls = space.faces_of(|patch| matches!(patch, Boundary::Mantle(_)));
        let wall_nodes = space.nodes_of(&walls);
        let place =
            |node: usize| wall_nodes.binary_search(&node).expect("it is on the wall") as u32;
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
        let grid = tree.grid();
        let angle = |a: usize| grid.angle(a);
        let n = grid.around();
        let around = (0..n).map(|a| {
            let (from, to) = (angle((a + n - 1) % n), angle((a + 1) % n));
            0.5 * (to - from).rem_euclid(TAU) / TAU
        });
        let mut mesh = Self {
            around: around.collect(),
            sections: Vec::new(),
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
        mesh.sections = mesh.meshed_sections(&place);
        mesh.interface = mesh.lattice(&basis.nodes.points, &uniform);
        mesh
    }

    /// The cross-sections with the nodes that they place: a node belongs to the first element that has it.
    fn meshed_sections(&self, place: &dyn Fn(usize) -> u32) -> Vec<MeshedSection> {
        let (grid, space) = (self.tree.grid(), &self.space);
        let degree = grid.degree();
        let quads = element_quads(&self.tree);
        let outer = grid.rings.len();
        let mut sections = Vec::new();
        let mut is_placed = vec![false; space.nodes];
        let mut first = 0;
        for stack in self.tree.stacks() {
            let mut nodes_of: Vec<Vec<u32>> =
                vec![vec![u32::MAX; grid.points()]; stack.sections.len()];
            let layers = (stack.sections.len() - 1) / degree;
            for layer in 0..layers {
                for (q, quad) in quads.iter().enumerate() {
                    let element = space.element(first + layer * quads.len() + q);
                    for (k, layer_nodes) in element.chunks_exact(quad.len()).enumerate() {
                        let section = &mut nodes_of[layer * degree + k];
                        for (&point, &node) in quad.iter().zip(layer_nodes) {
                            section[point] = node;
                        }
                    }
                }
            }
            first += layers * quads.len();
            let all = nodes_of
                .into_iter()
                .zip(&stack.sections)
                .zip(&stack.middles);
            for ((nodes, shape), middle) in all {
                let mut own = Vec::new();
                for (point, &node) in nodes.iter().enumerate() {
                    if !std::mem::replace(&mut is_placed[node as usize], true) {
                        own.push((node, point as u32));
                    }
                }
                let rim =
                    (0..grid.around()).map(|a| place(nodes[grid.ring_point(outer, a)] as usize));
                sections.push(MeshedSection {
                    shape: shape.clone(),
                    middle: *middle,
                    rim: rim.collect(),
                    nodes: own,
                });
            }
        }
        sections
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
        let grid = self.tree.grid();
        let half = grid.around() / 2;
        let place = |section: &MeshedSection| {
            let MeshedSection {
                shape,
                middle: Middle { axis, share },
                rim,
                nodes,
            } = section;
            let moved: Vec<Vec3> = rim.iter().map(|&i| of_wall[i as usize]).collect();
            let whole: Vec3 = moved
                .iter()
                .zip(&self.around)
                .map(|(u, share)| u * *share)
                .sum();
            let ends = (moved[*axis % moved.len()] + moved[(axis + half) % moved.len()]) * 0.5;
            let displaced = CrossSection {
                centre: shape.centre + whole * *share + ends * (1.0 - share),
                rim: shape.rim.iter().zip(&moved).map(|(x, u)| x + u).collect(),
            };
            let at = grid.positions(&displaced, 1.0);
            let placed = nodes
                .iter()
                .map(|&(node, point)| (node, at[point as usize]));
            placed.collect::<Vec<(u32, Vec3)>>()
        };
        let placed: Vec<_> = self.sections.par_iter().map(place).collect();
        let mut nodes = vec![Vec3::zeros(); self.space.nodes];
        for (node, x) in placed.into_iter().flatten() {
            nodes[node as usize] = x;
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

/// Points of a cross-section that are the nodes of each element in it, fastest along ξ, which points outward in the
/// rings; η turns counter-clockwise about the flow.
fn element_quads(tree: &Tree) -> Vec<Vec<usize>> {
    let grid = tree.grid();
    let degree = grid.degree();
    let core = grid.core / degree;
    let nodes = |at: &dyn Fn(usize, usize) -> usize| -> Vec<usize> {
        let n = degree + 1;
        (0..n * n).map(|k| at(k % n, k / n)).collect()
    };
    let mut quads = Vec::new();
    for element in 0..core * core {
        let (x, y) = (element % core * degree, element / core * degree);
        quads.push(nodes(&|i, j| grid.core_point(x + i, y + j)));
    }
    for element in 0..grid.rings.len() / degree * 4 * core {
        let (ring, a) = (element / (4 * core) * degree, element % (4 * core) * degree);
        quads.push(nodes(&|i, j| grid.ring_point(ring + i, a + j)));
    }
    quads
}

/// The elements stack by stack, layer by layer downstream.
fn elements(tree: &Tree, degree: usize) -> Hexahedra {
    let (_, numbers) = tree.points(1.0);
    let quads = element_quads(tree);
    let in_core = (tree.grid().core / degree).pow(2);
    let around = 4 * tree.grid().core / degree;
    let n = degree + 1;
    let of_quad = |quad: &Vec<usize>| [quad[0], quad[degree], quad[degree * n], quad[n * n - 1]];
    let mut mesh = Hexahedra::default();
    for (chain, (stack, numbers)) in tree.stacks().iter().zip(&numbers).enumerate() {
        let last = (numbers.len() - 1) / degree - 1;
        for layer in 0..=last {
            let [below, above] = [layer, layer + 1].map(|layer| &numbers[layer * degree]);
            for (q, quad) in quads.iter().enumerate() {
                let element = mesh.corners.len();
                let [a, b, c, d] = of_quad(quad);
                mesh.corners.push([
                    below[a], below[b], below[c], below[d], above[a], above[b], above[c], above[d],
                ]);
                mesh.layers.push((chain, layer));
                let mut add = |axis, upper, patch| {
                    mesh.faces.push(Face {
                        element,
                        side: Side { axis, upper },
                        patch,
                    });
                };
                if q >= in_core && q + around >= quads.len() {
                    add(0, true, Boundary::Mantle(stack.wall));
                }
                if layer == 0 && stack.from.is_none() {
                    add(2, false, Boundary::End(ROOT));
                }
                if layer == last
                    && let Some(line) = stack.end
                {
                    add(2, true, Boundary::End(1 + line));
                }
            }
        }
    }
    mesh
}
