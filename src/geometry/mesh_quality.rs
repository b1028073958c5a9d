//! How good the cells of a mesh are.

use super::PolyMesh;
use crate::Vec3;

impl PolyMesh {
    /// Largest angle (degrees) between the normal of a face and the line between the centres of its two cells, as
    /// OpenFOAM's `checkMesh` has it; 0 where there is one cell.
    pub fn non_orthogonality_deg(&self) -> f64 {
        let cells = self.cell_geometry();
        let angle = |(face, &neighbour): (usize, &usize)| {
            let between: Vec3 = cells[neighbour].1 - cells[self.owner[face]].1;
            between.angle(&self.face_geometry(face).1)
        };
        let angles = self.neighbour.iter().enumerate().map(angle);
        angles.fold(0.0, f64::max).to_degrees()
    }

    /// The diagonal of Laplace's operator, mean of all cells, 1/m²: areas of a cell's faces to others over the
    /// distances of the centres and the cell's volume. By a kinematic viscosity and a time step it is how far momentum
    /// diffuses in the step, in cells.
    pub fn laplacian_diagonal(&self) -> f64 {
        let cells = self.cell_geometry();
        let mut sums = vec![0.0; cells.len()];
        for (face, &neighbour) in self.neighbour.iter().enumerate() {
            let owner = self.owner[face];
            let distance = (cells[neighbour].1 - cells[owner].1).norm();
            let share = self.face_geometry(face).1.norm() / distance;
            sums[owner] += share / cells[owner].0;
            sums[neighbour] += share / cells[neighbour].0;
        }
        sums.iter().sum::<f64>() / sums.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two cubes above each other, the upper one's roof shifted by `shift` along x.
    fn pile(shift: f64) -> PolyMesh {
        let square = |z: f64, x: f64| {
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            corners.map(|[a, b]| Vec3::new(a + x, b, z))
        };
        let points = [square(0.0, -shift), square(1.0, 0.0), square(2.0, shift)].concat();
        let cells = [[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]];
        let sides = |low: usize| {
            (0..4).map(move |i| {
                let j = (i + 1) % 4;
                [low + i, low + j, low + j + 4, low + i + 4]
            })
        };
        let mut faces: Vec<[usize; 4]> = sides(0).chain(sides(4)).collect();
        faces.push([0, 3, 2, 1]);
        faces.push([8, 9, 10, 11]);
        let patch = crate::geometry::poly_mesh::PatchFaces {
            name: "wall",
            kind: "wall",
            faces,
        };
        PolyMesh::from_hexes(points, &cells, &[patch])
    }

    #[test]
    fn a_sheared_pile_leans_by_its_angle() {
        assert!(pile(0.0).non_orthogonality_deg() < 1e-10);
        for degrees in [10.0_f64, 45.0, 56.0] {
            let found = pile(degrees.to_radians().tan()).non_orthogonality_deg();
            approx::assert_relative_eq!(found, degrees, max_relative = 1e-12);
        }
    }

    /// Two cubes have one face of area one at the distance one between them.
    #[test]
    fn two_cubes_share_one_face() {
        approx::assert_relative_eq!(pile(0.0).laplacian_diagonal(), 1.0, max_relative = 1e-12);
    }
}
