//! Numbering of the unknowns: of plane quadrilaterals that are swept along a line, or of any conforming hexahedra.
//!
//! The local coordinates ξ, η and ζ of an element are in this order right-handed; local indices run fastest along ξ. In
//! a sweep ξ and η lie in the plane, and elements, faces of the mantle and nodes are numbered layer by layer.

use std::collections::HashMap;

/// A side of an element, by the local coordinate that is constant there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Side {
    /// The constant coordinate: 0, 1 or 2.
    pub axis: usize,
    /// Whether it is 1 there, not -1.
    pub upper: bool,
}

/// Part of the boundary that a face belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Boundary {
    /// A cross-section at an end, by its number: of a sweep 0 is the first one, 1 the last.
    End(usize),
    /// The rest, by a number of the mesh's own.
    Mantle(usize),
}

/// A face of the boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Face {
    /// Its element.
    pub element: usize,
    /// Which side of it.
    pub side: Side,
    /// Where it belongs.
    pub patch: Boundary,
}

/// A plane mesh of quadrilaterals with the nodes of some degree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plane {
    /// Number of nodes.
    pub nodes: usize,
    /// Nodes of each quadrilateral, `(degree + 1)²`, fastest along ξ.
    pub quads: Vec<Vec<usize>>,
    /// Sides (axis 0 or 1) on the boundary, with the number of their patch.
    pub edges: Vec<(usize, Side, usize)>,
}

impl Plane {
    /// A rectangle of `cells` quadrilaterals; the boundary's parts are 0 (ξ = -1), 1, 2 (η = -1) and 3.
    pub fn grid(cells: [usize; 2], degree: usize) -> Self {
        let [nx, ny] = cells;
        let row = nx * degree + 1;
        let mut plane = Self {
            nodes: row * (ny * degree + 1),
            quads: Vec::new(),
            edges: Vec::new(),
        };
        for y in 0..ny {
            for x in 0..nx {
                let quad = plane.quads.len();
                let of_row = |j: usize| {
                    let first = (y * degree + j) * row + x * degree;
                    first..=first + degree
                };
                plane.quads.push((0..=degree).flat_map(of_row).collect());
                for (is_edge, axis, upper, patch) in [
                    (x == 0, 0, false, 0),
                    (x + 1 == nx, 0, true, 1),
                    (y == 0, 1, false, 2),
                    (y + 1 == ny, 1, true, 3),
                ] {
                    if is_edge {
                        plane.edges.push((quad, Side { axis, upper }, patch));
                    }
                }
            }
        }
        plane
    }
}

/// Conforming hexahedra.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Hexahedra {
    /// Numbers of the eight corners of each, fastest along ξ.
    pub corners: Vec<[usize; 8]>,
    /// Faces of the boundary.
    pub faces: Vec<Face>,
}

/// Continuous piecewise polynomials on a mesh: velocity and geometry of degree `N`, pressure of degree `N - 1`.
#[derive(Debug, Clone, PartialEq)]
pub struct TaylorHoodSpace {
    /// Degree of the velocity.
    pub degree: usize,
    /// Number of elements.
    pub elements: usize,
    /// Number of nodes of the velocity.
    pub nodes: usize,
    /// Number of nodes of the pressure.
    pub pressures: usize,
    /// Nodes of each element, `(N + 1)³` each.
    pub of_element: Vec<u32>,
    /// Pressure nodes of each element, `N³` each.
    pub pressures_of_element: Vec<u32>,
    /// Where each node appears in `of_element`: places of node `i` from `starts[i]` on.
    pub starts: Vec<u32>,
    /// See `starts`.
    pub places: Vec<u32>,
    /// The same for the pressure.
    pub pressure_starts: Vec<u32>,
    /// See `pressure_starts`.
    pub pressure_places: Vec<u32>,
    /// Faces of the boundary.
    pub faces: Vec<Face>,
}

impl TaylorHoodSpace {
    /// Sweeps a plane mesh over `layers` elements; `velocity` has the nodes of degree `degree`, `pressure` those of one
    /// less.
    pub fn swept(velocity: &Plane, pressure: &Plane, degree: usize, layers: usize) -> Self {
        let quads = velocity.quads.len();
        let of_element = swept(velocity, degree, layers);
        let pressures_of_element = swept(pressure, degree - 1, layers);
        let mut faces = Vec::new();
        for layer in 0..layers {
            for &(quad, side, patch) in &velocity.edges {
                faces.push(Face {
                    element: layer * quads + quad,
                    side,
                    patch: Boundary::Mantle(patch),
                });
            }
        }
        for quad in 0..quads {
            for (layer, upper, patch) in [
                (0, false, Boundary::End(0)),
                (layers - 1, true, Boundary::End(1)),
            ] {
                faces.push(Face {
                    element: layer * quads + quad,
                    side: Side { axis: 2, upper },
                    patch,
                });
            }
        }
        Self::new(degree, [of_element, pressures_of_element], faces)
    }

    /// That of conforming hexahedra. Nodes on an edge are numbered from its corner of the smaller number, those on a
    /// face from its smallest corner towards the smaller one of the two next to that, so that elements that meet agree.
    pub fn of_hexahedra(mesh: Hexahedra, degree: usize) -> Self {
        let of_element = numbered(&mesh.corners, degree);
        let pressures_of_element = numbered(&mesh.corners, degree - 1);
        Self::new(degree, [of_element, pressures_of_element], mesh.faces)
    }

    fn new(
        degree: usize,
        [of_element, pressures_of_element]: [Vec<u32>; 2],
        faces: Vec<Face>,
    ) -> Self {
        let count = |list: &[u32]| list.iter().max().map_or(0, |last| *last as usize + 1);
        let (nodes, pressures) = (count(&of_element), count(&pressures_of_element));
        let (starts, places) = inverse(&of_element, nodes);
        let (pressure_starts, pressure_places) = inverse(&pressures_of_element, pressures);
        Self {
            degree,
            elements: of_element.len() / (degree + 1).pow(3),
            nodes,
            pressures,
            of_element,
            pressures_of_element,
            starts,
            places,
            pressure_starts,
            pressure_places,
            faces,
        }
    }

    /// Nodes of an element.
    pub fn element(&self, e: usize) -> &[u32] {
        let size = (self.degree + 1).pow(3);
        &self.of_element[e * size..(e + 1) * size]
    }

    /// Pressure nodes of an element.
    pub fn element_pressures(&self, e: usize) -> &[u32] {
        let size = self.degree.pow(3);
        &self.pressures_of_element[e * size..(e + 1) * size]
    }

    /// Faces of the parts of the boundary that `wanted` names.
    pub fn faces_of(&self, wanted: impl Fn(Boundary) -> bool) -> Vec<Face> {
        let faces = self.faces.iter().copied();
        faces.filter(|face| wanted(face.patch)).collect()
    }

    /// Nodes of faces, in ascending order.
    pub fn nodes_of(&self, faces: &[Face]) -> Vec<usize> {
        let pairs = self.inner_nodes(faces).into_iter();
        let mut nodes: Vec<usize> = pairs.map(|[node, _]| node).collect();
        nodes.dedup();
        nodes
    }

    /// Nodes of faces, in ascending order, each with the node on the opposite side of its element.
    pub fn inner_nodes(&self, faces: &[Face]) -> Vec<[usize; 2]> {
        let mut nodes: Vec<[usize; 2]> = (faces.iter())
            .flat_map(|face| {
                let (element, n) = (self.element(face.element), self.degree + 1);
                let across = if face.side.upper { -1 } else { 1 }
                    * (self.degree * n.pow(face.side.axis as u32)) as isize;
                (face.side.places(n).into_iter())
                    .map(move |i| [i, i.wrapping_add_signed(across)].map(|i| element[i] as usize))
            })
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }
}

impl Side {
    /// The axes along the side, in the order in which the product of their tangents points out of the element.
    pub fn axes(self) -> [usize; 2] {
        let [a, b] = [(self.axis + 1) % 3, (self.axis + 2) % 3];
        if self.upper { [a, b] } else { [b, a] }
    }

    /// Local indices of the side's nodes, for `n` nodes per direction; fastest along the first of its axes.
    pub fn places(self, n: usize) -> Vec<usize> {
        let strides = [1, n, n * n];
        let [a, b] = self.axes();
        let first = if self.upper {
            (n - 1) * strides[self.axis]
        } else {
            0
        };
        let place = |i: usize| first + (i % n) * strides[a] + (i / n) * strides[b];
        (0..n * n).map(place).collect()
    }
}

fn swept(plane: &Plane, degree: usize, layers: usize) -> Vec<u32> {
    let mut of_element = Vec::new();
    for layer in 0..layers {
        for quad in &plane.quads {
            for k in 0..=degree {
                let first = (layer * degree + k) * plane.nodes;
                of_element.extend(quad.iter().map(|node| (first + node) as u32));
            }
        }
    }
    of_element
}

/// Numbers of the nodes of this degree of conforming hexahedra with these corners, element by element.
fn numbered(corners: &[[usize; 8]], degree: usize) -> Vec<u32> {
    let n = degree + 1;
    // A node is known by the corners of the smallest part that it lies in, and its place there.
    let mut known: HashMap<([usize; 4], [usize; 2]), u32> = HashMap::new();
    let mut next = 0;
    let mut numbers = Vec::with_capacity(corners.len() * n.pow(3));
    for corners in corners {
        for k in 0..n.pow(3) {
            let at = [k % n, k / n % n, k / n / n];
            // The axes along which it lies within.
            let free: Vec<usize> = (0..3).filter(|&c| !at[c].is_multiple_of(degree)).collect();
            let corner = |along: &[usize]| {
                let upper = |c: usize| usize::from(at[c] == degree || along.contains(&c)) << c;
                corners[upper(0) + upper(1) + upper(2)]
            };
            let key = match free[..] {
                [] => ([corner(&[]), 0, 0, 0], [0, 0]),
                [a] => {
                    let (from, to) = (corner(&[]), corner(&[a]));
                    match from < to {
                        true => ([from, to, 1, 0], [at[a], 0]),
                        false => ([to, from, 1, 0], [degree - at[a], 0]),
                    }
                }
                [a, b] => {
                    let square = [corner(&[]), corner(&[a]), corner(&[a, b]), corner(&[b])];
                    let (p, q) = (at[a], at[b]);
                    on_face(square, [p, q], degree)
                }
                _ => {
                    numbers.push(next);
                    next += 1;
                    continue;
                }
            };
            let number = known.entry(key).or_insert_with(|| {
                next += 1;
                next - 1
            });
            numbers.push(*number);
        }
    }
    numbers
}

/// The corners of a square, around it, and a place in it, counted as all elements do that share it.
fn on_face(square: [usize; 4], [p, q]: [usize; 2], degree: usize) -> ([usize; 4], [usize; 2]) {
    let first = (0..4).min_by_key(|&i| square[i]).expect("four corners");
    // Distances from that corner along the two sides, in the order of the corners.
    let (p, q) = match first {
        0 => (p, q),
        1 => (q, degree - p),
        2 => (degree - p, degree - q),
        _ => (degree - q, p),
    };
    let around = |i: usize| square[(first + i) % 4];
    match around(1) < around(3) {
        true => ([around(0), around(1), around(2), around(3)], [p, q]),
        false => ([around(0), around(3), around(2), around(1)], [q, p]),
    }
}

/// For each number the places at which it stands in a list.
pub fn inverse(list: &[u32], count: usize) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; count + 1];
    for &i in list {
        starts[i as usize + 1] += 1;
    }
    for i in 0..count {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut places = vec![0; list.len()];
    for (place, &i) in list.iter().enumerate() {
        places[next[i as usize] as usize] = place as u32;
        next[i as usize] += 1;
    }
    (starts, places)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Eight cubes around a point, each turned in another way: as many nodes as a lattice has, and those of two
    /// elements that have the same number are at the same place.
    #[test]
    fn elements_that_are_turned_agree_on_their_nodes() {
        let lattice = |x: [usize; 3]| x[0] + 3 * x[1] + 9 * x[2];
        // Right-handed: cyclic permutations of the axes, and half turns about them.
        let cubes: Vec<[[usize; 3]; 8]> = (0..8)
            .map(|cube| {
                let turn = [
                    cube % 2 == 1,
                    cube % 4 > 1,
                    (cube % 2 == 1) != (cube % 4 > 1),
                ];
                std::array::from_fn(|corner| {
                    let mut x = [0; 3];
                    for c in 0..3 {
                        let to = (c + cube) % 3;
                        x[to] = (cube >> to & 1) + (usize::from(turn[c]) ^ (corner >> c & 1));
                    }
                    x
                })
            })
            .collect();
        let corners: Vec<[usize; 8]> = cubes.iter().map(|cube| cube.map(lattice)).collect();
        for degree in [1, 2, 3, 4] {
            let numbers = numbered(&corners, degree);
            let n = degree + 1;
            let mut places: BTreeMap<u32, [usize; 3]> = BTreeMap::new();
            for (e, cube) in cubes.iter().enumerate() {
                for k in 0..n.pow(3) {
                    let at = [k % n, k / n % n, k / n / n];
                    let x = std::array::from_fn(|c| {
                        let along = |i: usize| cube[1 << i][c] as isize - cube[0][c] as isize;
                        let sum: isize = (0..3).map(|i| along(i) * at[i] as isize).sum();
                        (cube[0][c] as isize * degree as isize + sum) as usize
                    });
                    let known = places.entry(numbers[e * n.pow(3) + k]).or_insert(x);
                    assert_eq!(*known, x, "degree {degree}, element {e}, node {k}");
                }
            }
            assert_eq!(places.len(), (2 * degree + 1).pow(3), "degree {degree}");
        }
    }
}
