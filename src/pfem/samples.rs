//! Values of a body on a fine lattice of points, for files that others look at.

use super::SolidError;
use super::discretization::Discretization;
use super::elements::{Elements, Extremes};
use super::mapping::lattice;
use super::quadrature::Rule;
use crate::Vec3;

/// Largest von Mises stress at the quadrature points of an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StressPeak {
    /// Reference position of the element's middle, m.
    pub element: Vec3,
    /// The stress, Pa.
    pub von_mises: f64,
    /// Reference position of the point, m.
    pub position: Vec3,
}

/// The largest stress of each element for a displacement.
pub fn stress_peaks(
    body: &Discretization,
    displacement: &[f64],
) -> Result<Vec<StressPeak>, SolidError> {
    let all = body.elements.element_extremes(body.body(), displacement)?;
    let at = |element, local| body.mapping.at(element, local).position;
    let peak = |found: Extremes| StressPeak {
        element: at(found.element, [0.0; 3]),
        von_mises: found.von_mises,
        position: at(found.element, found.local),
    };
    Ok(all.into_iter().map(peak).collect())
}

/// Points of a lattice in every element, and the small hexahedra between them.
pub struct Sampler {
    elements: Elements,
    /// Reference positions, m, element by element; points of neighbouring elements are not shared, so that stresses may
    /// jump between them.
    pub points: Vec<Vec3>,
    /// Corners of the small hexahedra in the order of VTK: four around the bottom, four around the top.
    pub hexes: Vec<[usize; 8]>,
    /// Material region of each small hexahedron.
    pub regions: Vec<usize>,
    /// Element of each small hexahedron.
    pub element_of_hex: Vec<usize>,
}

/// Values at the points of a [`Sampler`].
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    /// Displacement, m.
    pub displacement: Vec<Vec3>,
    /// Von Mises stress, Pa.
    pub von_mises: Vec<f64>,
}

impl Sampler {
    /// A lattice of `n >= 2` points in each local direction.
    pub fn new(body: &Discretization, n: usize) -> Result<Self, SolidError> {
        let n = n.max(2);
        let axis: Vec<f64> = (0..n)
            .map(|i| 2.0 * i as f64 / (n - 1) as f64 - 1.0)
            .collect();
        let rule = Rule {
            weights: vec![0.0; n],
            points: axis.clone(),
        };
        let count = body.regions().len();
        let rules = [rule.clone(), rule.clone(), rule];
        let elements = Elements::new(&body.numbering, &body.space, &body.mapping, count, &rules)?;
        let mut sampler = Self {
            elements,
            points: Vec::with_capacity(count * n.pow(3)),
            hexes: Vec::new(),
            regions: Vec::new(),
            element_of_hex: Vec::new(),
        };
        for e in 0..count {
            let first = sampler.points.len();
            let mapped = body.mapping.at_lattice(e, [&axis, &axis, &axis]);
            sampler.points.extend(mapped.iter().map(|m| m.position));
            let steps: Vec<f64> = (0..n - 1).map(|i| i as f64).collect();
            for cell in lattice([&steps, &steps, &steps]) {
                let [i, j, k] = cell.map(|x| x as usize);
                let at = |a: usize, b: usize, c: usize| first + i + a + n * (j + b + n * (k + c));
                sampler.hexes.push([
                    at(0, 0, 0),
                    at(1, 0, 0),
                    at(1, 1, 0),
                    at(0, 1, 0),
                    at(0, 0, 1),
                    at(1, 0, 1),
                    at(1, 1, 1),
                    at(0, 1, 1),
                ]);
                sampler.regions.push(body.regions()[e]);
                sampler.element_of_hex.push(e);
            }
        }
        Ok(sampler)
    }

    /// Values for a displacement.
    pub fn sample(
        &self,
        body: &Discretization,
        displacement: &[f64],
    ) -> Result<Samples, SolidError> {
        let fields = self.elements.fields(body.body(), displacement)?;
        let (displacement, von_mises) = fields.into_iter().unzip();
        Ok(Samples {
            displacement,
            von_mises,
        })
    }
}
