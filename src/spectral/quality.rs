//! How well shaped elements are.

use super::spectral_elements::SpectralElements;
use crate::Vec3;

impl SpectralElements {
    /// The smallest scaled Jacobian at a node (the triple product of unit vectors along the element's axes), and where
    /// that is (m), of the elements whose nodes have these positions (m, one component after the other).
    pub fn worst_element(&self, positions: &[f64]) -> Option<(f64, Vec3)> {
        let (n, slopes) = (self.basis.nodes.len(), &self.basis.nodal_derivative);
        let of_element = |e: usize| {
            let nodes = self.space.element(e).iter();
            let x: Vec<Vec3> = nodes.map(|&i| self.vector(positions, i as usize)).collect();
            let at = |k: usize| {
                let place = [k % n, k / n % n, k / n / n];
                let [a, b, c]: [Vec3; 3] = std::array::from_fn(|axis| {
                    let stride = n.pow(axis as u32);
                    let first = k - place[axis] * stride;
                    let slopes = &slopes[place[axis]];
                    let sum: Vec3 = (0..n).map(|j| x[first + j * stride] * slopes[j]).sum();
                    sum.normalize()
                });
                (a.cross(&b).dot(&c), x[k])
            };
            let all = (0..x.len()).map(at);
            all.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let all = (0..self.space.elements).filter_map(of_element);
        all.min_by(|a, b| a.0.total_cmp(&b.0))
    }
}
