//! Values of a body on a fine lattice of points, for files that others look at.

use super::super::discretization::Discretization;
use super::super::element::mapping::lattice;
use super::super::element::volume::{self, Basis, Formulation, Projection};
use super::super::element::{Elements, PAIRS};
use super::super::solid::{SolidError, StressPeak};
use super::extremes::Extremes;
use super::stress::StressState;
use crate::{Mat3, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;

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
        max_principal: found.max_principal,
        max_hoop: found.max_hoop,
        max_axial: found.max_axial,
        max_fibre_stretch: Some(found.max_fibre_stretch).filter(|stretch| stretch.is_finite()),
        position: at(found.element, found.local),
    };
    Ok(all.into_iter().map(peak).collect())
}

/// Points of a lattice in every element, and the small hexahedra between them.
pub struct Sampler {
    elements: Elements,
    /// The pressure's functions at the points, in the mixed form.
    pressure: Option<Basis>,
    /// Onto the space of the smooth stress, in each element, and its functions at the points.
    smoothing: (Projection, Basis),
    /// Points that coincide in the same material have the same number.
    places: Vec<usize>,
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
    /// Stresses and strains as the displacement has them.
    pub raw: Vec<StressState>,
    /// The same strains with smooth stresses: projected onto polynomials of the total degree of the displacement in
    /// each element, and the mean of neighbouring elements of the same material.
    pub smooth: Vec<StressState>,
}

impl Sampler {
    /// A lattice of `n >= 2` points in each local direction.
    pub fn new(body: &Discretization, n: usize) -> Result<Self, SolidError> {
        let n = n.max(2);
        let axis: Vec<f64> = (0..n)
            .map(|i| 2.0 * i as f64 / (n - 1) as f64 - 1.0)
            .collect();
        let count = body.regions().len();
        let elements = body.elements_at(&axis)?;
        let axes = [&axis[..]; 3];
        let smooth = volume::polynomials(body.space.degrees, body.space.max_degree());
        let mut sampler = Self {
            elements,
            pressure: (body.formulation() == Formulation::Mixed)
                .then(|| Basis::new(&volume::modes(&body.space), axes)),
            smoothing: (body.elements.projection(&smooth), Basis::new(&smooth, axes)),
            places: Vec::new(),
            points: Vec::with_capacity(count * n.pow(3)),
            hexes: Vec::new(),
            regions: Vec::new(),
            element_of_hex: Vec::new(),
        };
        let mapped_in = body.mapping.on(axes);
        for e in 0..count {
            let first = sampler.points.len();
            let mapped = mapped_in(e);
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
        sampler.places = sampler.places();
        Ok(sampler)
    }

    /// Equal numbers for points of the same material that coincide.
    fn places(&self) -> Vec<usize> {
        let mut numbers = HashMap::new();
        let size = self
            .points
            .iter()
            .map(|x| x.amax())
            .fold(f64::MIN_POSITIVE, f64::max);
        let per_element = self.points.len() / self.elements.points.len();
        let cells = self.hexes.len() / self.elements.points.len();
        let number = |(i, x): (usize, &Vec3)| {
            let place: [i64; 3] = x.map(|x| (x / size * 1e8).round() as i64).into();
            let next = numbers.len();
            *numbers
                .entry((self.regions[i / per_element * cells], place))
                .or_insert(next)
        };
        self.points.iter().enumerate().map(number).collect()
    }

    /// The smooth stress at the points, from `states` at the quadrature points.
    fn smooth(&self, body: &Discretization, states: &[StressState]) -> Vec<Mat3> {
        let (projection, basis) = &self.smoothing;
        let per_element = states.len() / body.elements.points.len();
        let of_element = |(e, own): (usize, &[StressState])| {
            let points = &body.elements.points[e];
            let component = |(i, j): (usize, usize)| {
                let field: Vec<f64> = own.iter().map(|state| state.cauchy[(i, j)]).collect();
                basis.evaluate(&projection.coefficients(e, points, &field))
            };
            let fields = PAIRS.map(component);
            let at = |q: usize| {
                let [xx, yy, zz, xy, xz, yz] = [0, 1, 2, 3, 4, 5].map(|c| fields[c][q]);
                Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
            };
            (0..fields[0].len()).map(at).collect::<Vec<_>>()
        };
        let elements = states.par_chunks_exact(per_element).enumerate();
        let local: Vec<Mat3> = elements.flat_map_iter(of_element).collect();
        let count = self.places.iter().max().map_or(0, |most| most + 1);
        let mut means = vec![(Mat3::zeros(), 0.0); count];
        for (&place, stress) in self.places.iter().zip(&local) {
            means[place].0 += stress;
            means[place].1 += 1.0;
        }
        let mean = |&place: &usize| means[place].0 / means[place].1;
        self.places.iter().map(mean).collect()
    }

    /// Values for a displacement.
    pub fn sample(
        &self,
        body: &Discretization,
        displacement: &[f64],
    ) -> Result<Samples, SolidError> {
        let pressures = body.elements.pressures(body.body(), displacement)?;
        let pressures = self.pressure.as_ref().zip(pressures.as_deref());
        let raw = self.elements.states(body.body(), displacement, pressures)?;
        let states = body.elements.states(body.body(), displacement, None)?;
        let stresses = self.smooth(body, &states);
        Ok(Samples {
            displacement: self.displacement(body, displacement),
            smooth: (raw.iter().zip(stresses))
                .map(|(state, stress)| state.with_cauchy(stress))
                .collect(),
            raw,
        })
    }

    /// Displacements (m) alone, such as those of a mode.
    pub fn displacement(&self, body: &Discretization, displacement: &[f64]) -> Vec<Vec3> {
        self.elements.displacement(&body.numbering, displacement)
    }
}
