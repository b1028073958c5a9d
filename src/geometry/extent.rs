//! How large a mesh and its openings are.

use super::PolyMesh;
use crate::Vec3;
use std::collections::HashMap;

/// Types of patches that are not walls: the cross-section goes on beyond them.
const NO_WALL: [&str; 5] = ["empty", "symmetry", "symmetryPlane", "wedge", "cyclic"];

impl PolyMesh {
    /// Two opposite corners (m) of a box around the mesh.
    pub fn bounds(&self) -> [Vec3; 2] {
        let first = self.points.first().copied().unwrap_or_default();
        (self.points.iter()).fold([first; 2], |[low, high], x| [low.inf(x), high.sup(x)])
    }

    /// Area (m²) of a patch, and four times that over the length of its edge, as far as that lies at no plane of
    /// symmetry: the hydraulic diameter (m), which is the diameter of a circle, and twice the height of a plane
    /// channel. None if it has no edge.
    pub fn opening_size(&self, name: &str) -> (f64, Option<f64>) {
        let edges_of = |face: &Vec<usize>| -> Vec<[usize; 2]> {
            let next = face.iter().cycle().skip(1);
            face.iter()
                .zip(next)
                .map(|(&a, &b)| [a.min(b), a.max(b)])
                .collect()
        };
        let mut counts: HashMap<[usize; 2], usize> = HashMap::new();
        let mut area = 0.0;
        if let Some(patch) = self.patch(name) {
            for face in patch.start..patch.start + patch.size {
                area += self.face_geometry(face).1.norm();
                for edge in edges_of(&self.faces[face]) {
                    *counts.entry(edge).or_default() += 1;
                }
            }
        }
        let beyond = self
            .patches
            .iter()
            .filter(|patch| NO_WALL.contains(&patch.kind.as_str()));
        for edge in beyond
            .flat_map(|patch| self.patch_faces(&patch.name))
            .flat_map(edges_of)
        {
            counts.remove(&edge);
        }
        let rim = counts.iter().filter(|(_, count)| **count == 1);
        let length: f64 = rim
            .map(|([a, b], _)| (self.points[*a] - self.points[*b]).norm())
            .sum();
        (area, (length > 0.0).then(|| 4.0 * area / length))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::poly_mesh::PatchFaces;

    /// A channel of 2 m by 0.5 m, a cell of 3 m deep.
    fn channel(sides: &'static str) -> PolyMesh {
        let corner = |v: usize| {
            let [x, y] = [[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.0, 0.5]][v % 4];
            Vec3::new(x, y, if v < 4 { 0.0 } else { 3.0 })
        };
        let patch = |name, kind, faces: &[[usize; 4]]| PatchFaces {
            name,
            kind,
            faces: faces.to_vec(),
        };
        let patches = [
            patch("inlet", "patch", &[[0, 4, 7, 3]]),
            patch("outlet", "patch", &[[1, 2, 6, 5]]),
            patch("walls", "wall", &[[0, 1, 5, 4], [3, 7, 6, 2]]),
            patch("sides", sides, &[[0, 3, 2, 1], [4, 5, 6, 7]]),
        ];
        PolyMesh::from_hexes(
            (0..8).map(corner).collect(),
            &[[0, 1, 2, 3, 4, 5, 6, 7]],
            &patches,
        )
    }

    /// A plane channel has twice its height and a duct four areas over its edge.
    #[test]
    fn hydraulic_diameters_of_channel_and_duct() {
        assert_eq!(
            channel("empty").bounds(),
            [Vec3::zeros(), Vec3::new(2.0, 0.5, 3.0)]
        );
        assert_eq!(channel("empty").opening_size("inlet"), (1.5, Some(1.0)));
        assert_eq!(
            channel("wall").opening_size("outlet"),
            (1.5, Some(6.0 / 7.0))
        );
        assert_eq!(channel("wall").opening_size("none"), (0.0, None));
    }
}
