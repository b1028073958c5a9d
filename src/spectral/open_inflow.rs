//! Backflow and inflow at an open end: the velocity of the blood that enters.

use super::flux::Flux;
use super::spectral_elements::SpectralElements;
use super::taylor_hood_space::Face;
use crate::Vec3;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// Degree of the polynomials over an end that a profile is made of which enters.
const PROFILE_DEGREE: i32 = 6;
/// What makes them determined where an end has few nodes; their squares have means up to 1.
const RIDGE: f64 = 1e-12;

/// A part of the boundary through which fluid comes and goes under a pressure.
#[derive(Debug, Clone)]
pub struct OpenEnd {
    /// Its faces.
    pub faces: Vec<Face>,
    /// What fluid brings that enters here.
    pub inflow: OpenInflow,
}

/// What the fluid brings that enters at an open end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OpenInflow {
    /// No energy: it comes from a place at rest, whose pressure the prescribed one is then (directional do-nothing
    /// condition: Braack and Mucha 2014).
    NoEnergy,
    /// The velocity along the normal that it has beyond the first elements, as if the vessel went on in front of the
    /// end, and across it that of the end itself. The prescribed pressure is the static one, and nothing grows: see
    /// [`along_normal`].
    AlongNormal,
}

/// Fluid that enters at a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodalInflow {
    /// The node.
    pub node: usize,
    /// Half of the mass that enters, kg/s.
    pub rate: f64,
    /// The velocity that it brings, m/s: `rate` times what the fluid's own differs from it by is a force on the fluid.
    pub velocity: Vec3,
}

/// Velocities at a moment.
pub struct Moving<'a> {
    /// Density of the fluid, kg/m³.
    pub density: f64,
    /// Positions of the nodes, m.
    pub positions: &'a [f64],
    /// Velocity of the fluid relative to the mesh, m/s.
    pub relative: &'a [f64],
    /// Velocity of the mesh, m/s.
    pub mesh: &'a [f64],
}

impl OpenEnd {
    /// Where fluid enters through the end, through which the flow is `flux`, and what it brings.
    pub fn entries(
        &self,
        space: &SpectralElements,
        flux: &Flux,
        moving: &Moving<'_>,
    ) -> Vec<NodalInflow> {
        let mut entries: Vec<NodalInflow> = (space.space.nodes_of(&self.faces).into_iter())
            .map(|node| {
                let through = space.vector(moving.relative, node);
                let through = through.dot(&flux.share(node));
                NodalInflow {
                    node,
                    rate: 0.5 * moving.density * (-through).max(0.0),
                    velocity: Vec3::zeros(),
                }
            })
            .filter(|entry| entry.rate > 0.0)
            .collect();
        if self.inflow == OpenInflow::AlongNormal && !entries.is_empty() {
            along_normal(space, &self.faces, flux, moving, &mut entries);
        }
        entries
    }
}

/// Gives entries the velocity `w + (ū + f - f̄) n`: **w** is that of the end, `f` the velocity along its normal **n**
/// beyond the first elements, and the bar a mean over what enters.
///
/// With the velocity `u` of the fluid at the node itself in place of `ū + f - f̄` the equations would say nothing of
/// what enters. What is rough in it then grows, as fast as the fluid passes an element, where viscosity does not stop
/// it. With that from beyond the elements, what grows differs from what is brought, and the pressure resists it. `f` is
/// smooth, the polynomial nearest to the velocity over the cross-section: with all that is found there what is rough
/// would come back through the elements as strong as it was. What flows as it would in a long tube is brought as it is.
/// The means leave the force of the prescribed pressure on the end as it is.
fn along_normal(
    space: &SpectralElements,
    faces: &[Face],
    flux: &Flux,
    moving: &Moving<'_>,
    entries: &mut [NodalInflow],
) {
    let inner = space.space.inner_nodes(faces);
    let area: Vec3 = inner.iter().map(|&[node, _]| flux.share(node)).sum();
    let out = area.normalize();
    let share = |node: usize| flux.share(node).dot(&out) / area.norm();
    let middle: Vec3 = (inner.iter())
        .map(|&[node, _]| share(node) * space.vector(moving.positions, node))
        .sum();
    let aside = out.cross(&Vec3::ith(out.iamin(), 1.0)).normalize();
    let across = [aside, out.cross(&aside)];
    let radius = (area.norm() / PI).sqrt();
    let exponents: Vec<[i32; 2]> = (0..=PROFILE_DEGREE)
        .flat_map(|n| (0..=n).map(move |k| [k, n - k]))
        .collect();
    let terms = exponents.len();
    let monomials = |node: usize| {
        let place = (space.vector(moving.positions, node) - middle) / radius;
        let [x, y] = across.map(|axis| axis.dot(&place));
        let monomials = exponents.iter().map(|[i, j]| x.powi(*i) * y.powi(*j));
        DVector::from_iterator(terms, monomials)
    };
    let normal = |node: usize| flux.share(node).normalize();

    let mut gram = DMatrix::from_diagonal_element(terms, terms, RIDGE);
    let mut moments = DVector::zeros(terms);
    for &[node, inner] in &inner {
        let (weight, monomials) = (share(node), monomials(node));
        gram += weight * &monomials * monomials.transpose();
        moments += weight * space.vector(moving.relative, inner).dot(&normal(node)) * monomials;
    }
    let coefficients =
        (gram.cholesky()).map_or_else(|| DVector::zeros(terms), |gram| gram.solve(&moments));

    let total: f64 = entries.iter().map(|entry| entry.rate).sum();
    let profile: Vec<f64> = (entries.iter())
        .map(|entry| coefficients.dot(&monomials(entry.node)))
        .collect();
    let lacking = (entries.iter().zip(&profile))
        .map(|(entry, profile)| {
            let own = space.vector(moving.relative, entry.node);
            entry.rate * (own.dot(&normal(entry.node)) - profile)
        })
        .sum::<f64>()
        / total;
    for (entry, profile) in entries.iter_mut().zip(profile) {
        let along = (profile + lacking) * normal(entry.node);
        entry.velocity = space.vector(moving.mesh, entry.node) + along;
    }
}
