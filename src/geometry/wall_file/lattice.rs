//! Nodes of a hexahedron in rows, whatever order a format has them in.

use crate::geometry::HexFace;

/// Nodes of a hexahedron of the order q: `nodes[i + (q + 1) (j + (q + 1) k)]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    /// Polynomial degree in each direction.
    pub order: usize,
    /// Indices into the nodes of the file.
    pub nodes: Vec<usize>,
}

/// Corners in the order of all formats: around the bottom, then above.
#[rustfmt::skip]
const CORNERS: [[usize; 3]; 8] = [
    [0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1],
];

/// Where a format has the nodes after the corners.
pub struct Order {
    /// Ends of the edges.
    pub edges: [[usize; 2]; 12],
    /// Corners around the faces.
    pub faces: [[usize; 4]; 6],
}

/// As Gmsh does.
#[rustfmt::skip]
pub const GMSH: Order = Order {
    edges: [
        [0, 1], [0, 3], [0, 4], [1, 2], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 7], [5, 6],
        [6, 7],
    ],
    faces: [
        [0, 3, 2, 1], [0, 1, 5, 4], [0, 4, 7, 3], [1, 2, 6, 5], [2, 3, 7, 6], [4, 5, 6, 7],
    ],
};

/// As VTK does, and Abaqus for the edges.
#[rustfmt::skip]
pub const VTK: Order = Order {
    edges: [
        [0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6],
        [3, 7],
    ],
    faces: [
        [0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2], [0, 3, 2, 1], [4, 5, 6, 7],
    ],
};

impl Lattice {
    /// From all `(q + 1)³` nodes in the order of a format: corners, nodes inside edges, faces, the volume; where there
    /// are several, each part in the order of a smaller one of its kind.
    pub fn full(order: usize, listed: &[usize], format: &Order) -> Self {
        let n = order + 1;
        let mut nodes = vec![0; n * n * n];
        let mut next = listed.iter().copied();
        let mut put =
            |x: [usize; 3]| nodes[x[0] + n * (x[1] + n * x[2])] = next.next().unwrap_or_default();
        let corner = |v: usize| CORNERS[v].map(|bit| order * bit);
        // The point at these shares of the way from the first of the corners to the others, in steps of the order.
        let between = |origin: usize, steps: &[(usize, usize)]| {
            let x = corner(origin);
            let mut moved = x;
            for &(towards, step) in steps {
                let y = corner(towards);
                for d in 0..3 {
                    moved[d] = moved[d] + y[d] / order * step - x[d] / order * step;
                }
            }
            moved
        };
        (0..8).for_each(|v| put(corner(v)));
        let inner: Vec<usize> = (1..order).collect();
        for [a, b] in format.edges {
            inner.iter().for_each(|&step| put(between(a, &[(b, step)])));
        }
        // Inside a face: a point, or four around it.
        let around: Vec<[usize; 2]> = match order {
            2 => vec![[1, 1]],
            3 => vec![[1, 1], [2, 1], [2, 2], [1, 2]],
            _ => Vec::new(),
        };
        for [a, b, _, d] in format.faces {
            around
                .iter()
                .for_each(|&[i, j]| put(between(a, &[(b, i), (d, j)])));
        }
        let inside: Vec<[usize; 3]> = match order {
            2 => vec![[1; 3]],
            3 => CORNERS.map(|x| x.map(|bit| 1 + bit)).into(),
            _ => Vec::new(),
        };
        inside.into_iter().for_each(&mut put);
        Self { order, nodes }
    }

    /// From 20 nodes, the corners and the middles of the edges; `middle` makes a node from weights of these.
    pub fn serendipity(
        listed: &[usize],
        format: &Order,
        mut middle: impl FnMut(&[(usize, f64)]) -> usize,
    ) -> Self {
        let mut all = listed[..20].to_vec();
        let edge = |a: usize, b: usize| {
            let is = |edge: &[usize; 2]| *edge == [a, b] || *edge == [b, a];
            let place = format.edges.iter().position(is);
            place.map(|place| listed[8 + place])
        };
        // The serendipity functions at the middle of a face and of the volume.
        for face in format.faces {
            let corners = face.iter().map(|&v| (listed[v], -0.25));
            let edges = (0..4).filter_map(|k| Some((edge(face[k], face[(k + 1) % 4])?, 0.5)));
            let weights: Vec<_> = corners.chain(edges).collect();
            all.push(middle(&weights));
        }
        let corners = listed[..8].iter().map(|&node| (node, -0.25));
        let edges = listed[8..20].iter().map(|&node| (node, 0.25));
        let weights: Vec<_> = corners.chain(edges).collect();
        all.push(middle(&weights));
        Self::full(2, &all, format)
    }

    fn at(&self, x: [usize; 3]) -> usize {
        let n = self.order + 1;
        self.nodes[x[0] + n * (x[1] + n * x[2])]
    }

    /// The node at the corner `i + 2 j + 4 k`.
    pub fn corner(&self, v: usize) -> usize {
        self.at([v & 1, v >> 1 & 1, v >> 2 & 1].map(|bit| bit * self.order))
    }

    /// The corners of a face.
    pub fn face(&self, face: HexFace) -> [usize; 4] {
        let axis = face.axis as usize;
        std::array::from_fn(|k| {
            let (low, bit) = ([1, 0, 0][axis], [2, 2, 1][axis]);
            let v = (k & 1) << low | (k >> 1) << bit | usize::from(face.upper) << axis;
            self.corner(v)
        })
    }

    /// The same with the first direction the other way round.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let n = self.order + 1;
        let nodes = (0..n * n * n).map(|p| self.at([self.order - p % n, p / n % n, p / (n * n)]));
        Self {
            order: self.order,
            nodes: nodes.collect(),
        }
    }
}
