//! Plane meshes of quadrilateral blocks, one cell thick.

use super::poly_mesh::{PatchFaces, PolyMesh};
use crate::Vec3;
use std::collections::HashMap;

/// A point of the plane z = 0, m.
pub type PlanePoint = [f64; 2];

/// A side of a block: its points, and the patch that it belongs to if it is part of the boundary. Blocks are neighbours
/// where their sides have the same points.
#[derive(Debug, Clone, PartialEq)]
pub struct Side {
    /// The points, along x or along y as far as the block lies that way.
    pub points: Vec<PlanePoint>,
    /// Name of the patch.
    pub patch: Option<&'static str>,
}

impl Side {
    /// A side between two blocks.
    pub fn inner(points: &[PlanePoint]) -> Self {
        let points = points.to_vec();
        Self {
            points,
            patch: None,
        }
    }

    /// A side on the boundary.
    pub fn on(patch: &'static str, points: &[PlanePoint]) -> Self {
        Self {
            patch: Some(patch),
            ..Self::inner(points)
        }
    }
}

/// A block with as many cells as its sides have segments. South and north run from west to east, west and east from
/// south to north, and turning from east to north is counter-clockwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// The side where the second local coordinate is 0.
    pub south: Side,
    /// The side opposite to it.
    pub north: Side,
    /// The side where the first local coordinate is 0.
    pub west: Side,
    /// The side opposite to it.
    pub east: Side,
}

impl Block {
    /// Cells from west to east and from south to north.
    pub fn cells(&self) -> [usize; 2] {
        let cells = [&self.south, &self.west].map(|side| side.points.len() - 1);
        let opposite = [&self.north, &self.east].map(|side| side.points.len() - 1);
        assert_eq!(cells, opposite, "opposite sides have equally many cells");
        cells
    }

    /// Point `(i, j)`: on the sides theirs, inside by Coons' transfinite interpolation in the mean arc lengths of
    /// opposite sides.
    fn point(&self, i: usize, j: usize) -> PlanePoint {
        let [n, m] = self.cells();
        let [south, north, west, east] =
            [&self.south, &self.north, &self.west, &self.east].map(|side| &side.points);
        match (i, j) {
            (_, 0) => return south[i],
            (_, j) if j == m => return north[i],
            (0, _) => return west[j],
            (i, _) if i == n => return east[j],
            _ => {}
        }
        // Where the lines of constant share on opposite sides meet.
        let [a, b] = [share(south, i), share(north, i)];
        let [c, d] = [share(west, j), share(east, j)];
        let turn = 1.0 - (b - a) * (d - c);
        let (s, t) = ((a + c * (b - a)) / turn, (c + a * (d - c)) / turn);
        std::array::from_fn(|k| {
            let sides =
                (1.0 - t) * south[i][k] + t * north[i][k] + (1.0 - s) * west[j][k] + s * east[j][k];
            let corners = (1.0 - s) * ((1.0 - t) * south[0][k] + t * north[0][k])
                + s * ((1.0 - t) * south[n][k] + t * north[n][k]);
            sides - corners
        })
    }
}

/// Share of a line's length up to its point `i`.
fn share(line: &[PlanePoint], i: usize) -> f64 {
    let length = |points: &[PlanePoint]| -> f64 {
        let segments = points.windows(2);
        segments
            .map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]))
            .sum()
    };
    length(&line[..=i]) / length(line)
}

/// Points and quadrilaterals of blocks, and their edges on patches.
#[derive(Default)]
struct PlaneMesh {
    points: Vec<PlanePoint>,
    quads: Vec<[usize; 4]>,
    edges: Vec<(&'static str, [usize; 2])>,
}

impl PlaneMesh {
    fn new(blocks: &[Block]) -> Self {
        let mut known: HashMap<[u64; 2], usize> = HashMap::new();
        let mut mesh = Self::default();
        for block in blocks {
            let [n, m] = block.cells();
            let mut number = |i: usize, j: usize| {
                let point = block.point(i, j);
                // Sides that two blocks share have the same points to the last digit.
                *known.entry(point.map(f64::to_bits)).or_insert_with(|| {
                    mesh.points.push(point);
                    mesh.points.len() - 1
                })
            };
            let mut at = vec![vec![0; m + 1]; n + 1];
            for (i, column) in at.iter_mut().enumerate() {
                for (j, place) in column.iter_mut().enumerate() {
                    *place = number(i, j);
                }
            }
            for i in 0..n {
                for j in 0..m {
                    mesh.quads
                        .push([at[i][j], at[i + 1][j], at[i + 1][j + 1], at[i][j + 1]]);
                }
            }
            for (side, points) in [
                (&block.south, (0..=n).map(|i| at[i][0]).collect::<Vec<_>>()),
                (&block.north, (0..=n).map(|i| at[i][m]).collect()),
                (&block.west, at[0].clone()),
                (&block.east, at[n].clone()),
            ] {
                if let Some(patch) = side.patch {
                    mesh.edges
                        .extend(points.windows(2).map(|p| (patch, [p[0], p[1]])));
                }
            }
        }
        mesh
    }
}

/// One layer of cells between z = 0 and `depth` (m) over the blocks, with the given patches (name, OpenFOAM's type)
/// and, as the last one, `sides` of the type `empty`.
///
/// # Panics
/// If opposite sides of a block have different numbers of cells, or a side without a patch has no neighbour: mistakes
/// of the program that calls.
pub fn extruded(
    blocks: &[Block],
    depth: f64,
    patches: &[(&'static str, &'static str)],
) -> PolyMesh {
    let PlaneMesh {
        points: plane,
        quads,
        edges,
    } = PlaneMesh::new(blocks);
    let above = |point: usize| plane.len() + point;
    let points = [0.0, depth]
        .into_iter()
        .flat_map(|z| plane.iter().map(move |&[x, y]| Vec3::new(x, y, z)));
    let cells: Vec<[usize; 8]> = quads
        .iter()
        .map(|q| std::array::from_fn(|v| if v < 4 { q[v] } else { above(q[v - 4]) }))
        .collect();
    let mut faces: Vec<PatchFaces> = patches
        .iter()
        .map(|&(name, kind)| {
            let edges = edges.iter().filter(|(patch, _)| *patch == name);
            let faces = edges.map(|&(_, [a, b])| [a, b, above(b), above(a)]);
            PatchFaces {
                name,
                kind,
                faces: faces.collect(),
            }
        })
        .collect();
    let upper = quads.iter().map(|quad| quad.map(above));
    faces.push(PatchFaces {
        name: "sides",
        kind: "empty",
        faces: quads.iter().copied().chain(upper).collect(),
    });
    PolyMesh::from_hexes(points.collect(), &cells, &faces)
}
