//! A thin layer of hexahedra on faces of any number of corners: a wall that has no shape of its own, since it is rigid
//! or its motion is prescribed.

use super::{HexFace, HexMesh, HexShape, PolyMesh, SurfaceError, WallDirections};
use crate::Vec3;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// Thickness of the layer as a share of the shortest edge at each point.
const THICKNESS: f64 = 0.1;

/// Hexahedra with straight edges.
struct Straight(Vec<[Vec3; 8]>);

impl HexShape for Straight {
    fn position(&self, element: usize, xi: [f64; 3]) -> Vec3 {
        let weight = |v: usize| -> f64 {
            let half = |d: usize| 0.5 * (1.0 + if v >> d & 1 == 1 { xi[d] } else { -xi[d] });
            (0..3).map(half).product()
        };
        let corners = self.0[element].iter().enumerate();
        corners.map(|(v, x)| x * weight(v)).sum()
    }
}

impl PolyMesh {
    /// A layer on the outer side of the patches of these `names`, with the surfaces `inner` and `outer`. Over a
    /// quadrilateral stands one hexahedron; if any face has another number of corners, over each corner of each face
    /// one. The first half of the vertices is that of the inner side, the second that above it, in the same order.
    ///
    /// # Errors
    /// If a patch is missing or empty.
    pub fn lining(&self, names: &[String]) -> Result<HexMesh, SurfaceError> {
        let mut faces: Vec<&Vec<usize>> = Vec::new();
        for name in names {
            faces.extend(self.wet_faces(name)?);
        }
        let quads = match faces.iter().all(|face| face.len() == 4) {
            true => Quads::of(self, &faces),
            false => Quads::of_corners(self, &faces),
        };
        Ok(quads.raised())
    }
}

/// Quadrilaterals whose normals point into the wall.
#[derive(Default)]
struct Quads {
    points: Vec<Vec3>,
    faces: Vec<[usize; 4]>,
}

impl Quads {
    /// The faces themselves.
    fn of(mesh: &PolyMesh, faces: &[&Vec<usize>]) -> Self {
        let mut quads = Self::default();
        let mut numbers = HashMap::new();
        for face in faces {
            let number = |k: usize| quads.number(&mut numbers, face[k], || mesh.points[face[k]]);
            let corners = [0, 1, 2, 3].map(number);
            quads.faces.push(corners);
        }
        quads
    }

    /// A quadrilateral at each corner of each face: it, the middles of the edges next to it, and that of the face.
    fn of_corners(mesh: &PolyMesh, faces: &[&Vec<usize>]) -> Self {
        let mut quads = Self::default();
        let mut numbers = HashMap::new();
        for face in faces {
            let n = face.len();
            let middle = face.iter().map(|&p| mesh.points[p]).sum::<Vec3>() / n as f64;
            let centre = quads.points.len();
            quads.points.push(middle);
            for k in 0..n {
                let [before, at, next] = [face[(k + n - 1) % n], face[k], face[(k + 1) % n]];
                let mut number = |a: usize, b: usize| {
                    let middle = || 0.5 * (mesh.points[a] + mesh.points[b]);
                    quads.number(&mut numbers, (a.min(b), a.max(b)), middle)
                };
                let corners = [number(at, at), number(at, next), centre, number(before, at)];
                quads.faces.push(corners);
            }
        }
        quads
    }

    fn number<K: Eq + std::hash::Hash>(
        &mut self,
        numbers: &mut HashMap<K, usize>,
        key: K,
        point: impl FnOnce() -> Vec3,
    ) -> usize {
        *numbers.entry(key).or_insert_with(|| {
            self.points.push(point());
            self.points.len() - 1
        })
    }

    /// The layer above.
    fn raised(self) -> HexMesh {
        let count = self.points.len();
        let mut normals = vec![Vec3::zeros(); count];
        let mut shortest = vec![f64::INFINITY; count];
        for face in &self.faces {
            let corners = face.map(|p| self.points[p]);
            let area = (corners[2] - corners[0]).cross(&(corners[3] - corners[1]));
            for k in 0..4 {
                let (a, b) = (face[k], face[(k + 1) % 4]);
                normals[a] += area;
                let edge = (self.points[a] - self.points[b]).norm();
                (shortest[a], shortest[b]) = (shortest[a].min(edge), shortest[b].min(edge));
            }
        }
        let above = |i: usize| {
            // Where two sides of a thin body meet, any direction will do.
            let normal = normals[i].try_normalize(0.0).unwrap_or_else(Vec3::z);
            self.points[i] + normal * (THICKNESS * shortest[i])
        };
        let raised: Vec<Vec3> = (0..count).map(above).collect();
        let vertices: Vec<Vec3> = self.points.iter().copied().chain(raised).collect();
        let hex = |[a, b, c, d]: &[usize; 4]| {
            let below = [*a, *b, *d, *c];
            std::array::from_fn(|v| below[v & 3] + count * (v >> 2))
        };
        let hexes: Vec<[usize; 8]> = self.faces.iter().map(hex).collect();
        let side = |upper| {
            let face = HexFace { axis: 2, upper };
            (0..hexes.len()).map(|element| (element, face)).collect()
        };
        HexMesh {
            surfaces: BTreeMap::from([("inner".into(), side(false)), ("outer".into(), side(true))]),
            regions: vec![0; hexes.len()],
            directions: WallDirections::Local,
            shape: Arc::new(Straight(
                hexes.iter().map(|hex| hex.map(|v| vertices[v])).collect(),
            )),
            vertices,
            hexes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Patch;

    /// A prism over a triangle, whose sides are the patch `sides` and whose top is the patch `top`.
    fn prism() -> PolyMesh {
        let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let points = [0.0, 1.0]
            .iter()
            .flat_map(|z| points.map(|[x, y]| Vec3::new(x, y, *z)));
        let patch = |name: &str, start, size| Patch {
            name: name.into(),
            kind: "wall".into(),
            start,
            size,
        };
        PolyMesh {
            points: points.collect(),
            faces: vec![
                vec![0, 1, 4, 3],
                vec![1, 2, 5, 4],
                vec![2, 0, 3, 5],
                vec![3, 4, 5],
                vec![0, 2, 1],
            ],
            owner: vec![0; 5],
            neighbour: vec![],
            patches: vec![
                patch("sides", 0, 3),
                patch("top", 3, 1),
                patch("bottom", 4, 1),
            ],
        }
    }

    /// Quadrilaterals have one element each and other faces one at each corner.
    #[test]
    fn faces_have_their_elements() {
        let names = |names: &[&str]| {
            names
                .iter()
                .map(|&name| name.to_owned())
                .collect::<Vec<_>>()
        };
        for (patches, elements, points) in [
            (names(&["sides"]), 3, 6),
            // Corners, middles of edges and of faces
            (names(&["sides", "top"]), 15, 6 + 9 + 4),
            (names(&["top"]), 3, 3 + 3 + 1),
        ] {
            let mesh = prism().lining(&patches).unwrap();
            assert_eq!(
                (mesh.hexes.len(), mesh.vertices.len()),
                (elements, 2 * points)
            );
            for (element, hex) in mesh.hexes.iter().enumerate() {
                let at = |xi: [f64; 3]| mesh.shape.position(element, xi);
                for (v, &vertex) in hex.iter().enumerate() {
                    let xi = [0, 1, 2].map(|d| if v >> d & 1 == 1 { 1.0 } else { -1.0 });
                    assert_eq!(at(xi), mesh.vertices[vertex]);
                }
                // Outward, and right-handed
                let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                    .map(|xi| at(xi) - at(xi.map(|c: f64| -c)));
                assert!(x.cross(&y).dot(&z) > 0.0);
                assert!(z.dot(&(at([0.0; 3]) - Vec3::new(0.25, 0.25, 0.5))) > 0.0);
            }
        }
        assert!(matches!(
            prism().lining(&names(&["lid"])),
            Err(SurfaceError::NoPatch { .. })
        ));
    }
}
