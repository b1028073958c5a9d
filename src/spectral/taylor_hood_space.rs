//! Numbering of the unknowns: plane quadrilaterals, swept along a line.
//!
//! The local coordinates of an element are ξ and η in the plane and ζ along the sweep, in this order right-handed;
//! local indices run fastest along ξ. Elements, faces and nodes are numbered layer by layer along the sweep
//! ([`Layers`]).

use fsi_numerics::Layers;

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
    /// First cross-section of the sweep.
    Start,
    /// Last cross-section of the sweep.
    End,
    /// The rest, by a number of the plane mesh's own.
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

/// Continuous piecewise polynomials on the swept mesh: velocity and geometry of degree `N`, pressure of degree `N - 1`.
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
    /// The order of the elements.
    pub layers: Layers,
    /// The order of the faces of the mantle, which are the first of `faces`.
    pub mantle: Layers,
    /// The order of the nodes, cross-section by cross-section.
    pub sections: Layers,
    /// That of the pressure's nodes.
    pub pressure_sections: Layers,
}

impl TaylorHoodSpace {
    /// Sweeps a plane mesh over `layers` elements; `velocity` has the nodes of degree `degree`, `pressure` those of one
    /// less.
    pub fn swept(velocity: &Plane, pressure: &Plane, degree: usize, layers: usize) -> Self {
        let quads = velocity.quads.len();
        let of_element = swept(velocity, degree, layers);
        let pressures_of_element = swept(pressure, degree - 1, layers);
        let nodes = velocity.nodes * (layers * degree + 1);
        let pressures = pressure.nodes * (layers * (degree - 1) + 1);
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
                (0, false, Boundary::Start),
                (layers - 1, true, Boundary::End),
            ] {
                faces.push(Face {
                    element: layer * quads + quad,
                    side: Side { axis: 2, upper },
                    patch,
                });
            }
        }
        let (starts, places) = inverse(&of_element, nodes);
        let (pressure_starts, pressure_places) = inverse(&pressures_of_element, pressures);
        Self {
            degree,
            elements: quads * layers,
            nodes,
            pressures,
            of_element,
            pressures_of_element,
            starts,
            places,
            pressure_starts,
            pressure_places,
            faces,
            layers: Layers { each: quads },
            mantle: Layers {
                each: velocity.edges.len(),
            },
            sections: Layers {
                each: velocity.nodes,
            },
            pressure_sections: Layers {
                each: pressure.nodes,
            },
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

/// For each number the places at which it stands in a list.
fn inverse(list: &[u32], count: usize) -> (Vec<u32>, Vec<u32>) {
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
