//! Ansatz spaces on the hexahedron: which products of one-dimensional shape functions span them.
//!
//! A mode is a product `N_i(ξ) N_j(η) N_k(ζ)` of the functions in [`basis`]. Indices 0 and 1 are the
//! linear functions of the two ends, so the number of indices above 1 tells a vertex (0), edge (1), face (2) or
//! internal mode (3).
//!
//! With the degrees `p = [p_ξ, p_η, p_ζ]` the **tensor product space** has all modes whose indices do not exceed the
//! degree of their direction. The **trunk space** of Szabó and Babuška has of these only the face modes with
//! `i + j <= max(p_i, p_j)` and the internal modes with `i + j + k <= max(p)`: the polynomials of total degree `max(p)`
//! and the few that continuity needs. Number of modes per element with equal degrees:
//!
//! | p | trunk | tensor product |
//! | --- | --- | --- |
//! | 1 | 8 | 8 |
//! | 2 | 20 | 27 |
//! | 3 | 32 | 64 |
//! | 4 | 50 | 125 |
//! | 5 | 74 | 216 |
//! | 6 | 105 | 343 |
//! | 7 | 144 | 512 |
//! | 8 | 192 | 729 |
//! | 9 | 250 | 1000 |
//! | 10 | 319 | 1331 |

pub mod basis;
pub mod numbering;
pub mod prolongation;
pub mod shapes;

use fsi_numerics::words;

words! {
    /// Which products of one-dimensional functions belong to a space.
    pub enum SpaceKind {
        /// Total degree bounded (serendipity).
        Trunk = "trunk",
        /// Degree bounded in each direction.
        TensorProduct = "tensor_product",
    }
}

/// A polynomial space on the hexahedron with its own degree in each local direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Space {
    /// Trunk or tensor product.
    pub kind: SpaceKind,
    /// Degree in each local direction, at least 1.
    pub degrees: [usize; 3],
}

/// Indices of the three one-dimensional factors of a mode.
pub type Mode = [usize; 3];

impl Space {
    /// The same degree in all directions.
    pub fn isotropic(kind: SpaceKind, p: usize) -> Self {
        Self {
            kind,
            degrees: [p; 3],
        }
    }

    /// Largest degree.
    pub fn max_degree(&self) -> usize {
        self.degrees.into_iter().max().unwrap_or(1)
    }

    /// Whether a mode belongs to the space.
    pub fn contains(&self, mode: Mode) -> bool {
        let high = (0..3).filter(|&d| mode[d] > 1);
        let inside = (0..3).all(|d| mode[d] <= self.degrees[d].max(1));
        let bound = high.clone().map(|d| self.degrees[d]).max().unwrap_or(0);
        let total: usize = high.clone().map(|d| mode[d]).sum();
        inside && (self.kind == SpaceKind::TensorProduct || high.count() < 2 || total <= bound)
    }

    /// The modes of the space: first index fastest, so that vertices, edges, faces and interior are mixed.
    pub fn modes(&self) -> Vec<Mode> {
        let [p0, p1, p2] = self.degrees.map(|p| p.max(1));
        let mut modes = Vec::new();
        for k in 0..=p2 {
            for j in 0..=p1 {
                for i in 0..=p0 {
                    if self.contains([i, j, k]) {
                        modes.push([i, j, k]);
                    }
                }
            }
        }
        modes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed formula for the trunk space (Szabó, Babuška 1991, section 6.1).
    fn trunk_size(p: usize) -> usize {
        let edges = 12 * (p - 1);
        let faces = if p >= 4 { 3 * (p - 2) * (p - 3) } else { 0 };
        let interior = if p >= 6 {
            (p - 3) * (p - 4) * (p - 5) / 6
        } else {
            0
        };
        8 + edges + faces + interior
    }

    #[test]
    fn number_of_modes_follows_the_closed_formulas() {
        for p in 1..=12 {
            let trunk = Space::isotropic(SpaceKind::Trunk, p).modes().len();
            let tensor = Space::isotropic(SpaceKind::TensorProduct, p).modes().len();
            assert_eq!(trunk, trunk_size(p));
            assert_eq!(tensor, (p + 1).pow(3));
        }
        assert_eq!(trunk_size(3), 32);
        assert_eq!(trunk_size(4), 50);
        assert_eq!(trunk_size(10), 319);
        let anisotropic = Space {
            kind: SpaceKind::TensorProduct,
            degrees: [5, 4, 2],
        };
        assert_eq!(anisotropic.modes().len(), 6 * 5 * 3);
    }

    #[test]
    fn the_trunk_space_contains_all_polynomials_of_its_degree() {
        // The number of modes with which x^a y^b z^c, a + b + c <= p, can be built is at least their number.
        for p in 1..=10 {
            let monomials = (p + 1) * (p + 2) * (p + 3) / 6;
            assert!(Space::isotropic(SpaceKind::Trunk, p).modes().len() >= monomials);
        }
    }
}
