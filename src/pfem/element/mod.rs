//! Integrals over the elements: energy, internal forces, stiffness, mass.
//!
//! All elements share the values and gradients of the modes at the quadrature points of the reference hexahedron.
//! With `G` their matrix (modes times `3 n_q`), `H = Gᵀ U` holds the displacement gradients with respect to the local
//! coordinates of all points of an element, and everything that depends on its shape is pulled back to the points:
//! ```text
//! F       = 1 + H ∂ξ/∂X                                deformation gradient
//! f       = G Q,          Q_αi     = w Σ_j ∂ξ_α/∂X_j P_ij                            internal forces
//! K^{ik}  = G Â^{ik} Gᵀ,  Â^{ik}_αβ = w Σ_jl ∂ξ_α/∂X_j A_ijkl ∂ξ_β/∂X_l              stiffness
//! ```
//! with `w` the quadrature weight times `det ∂X/∂ξ`; so all work but the material is matrix products.
//!
//! A [prestretched](Fabric::prestretch) body is free of stress nowhere: what is, point by point, is the reference
//! configuration shortened along the vessel by a stretch `λ`, and widened so that its volume stays,
//! ```text
//! S = λ a aᵀ + λ^(-1/2) (1 - a aᵀ),      F = (1 + H ∂ξ/∂X) S
//! ```
//! with `a` the direction along the vessel (a deposition stretch: Mousavi and Avril, Biomech. Model. Mechanobiol. 16,
//! 2017). As `det S = 1`, all else stays with `∂ξ/∂X S` in place of `∂ξ/∂X`.

mod deformation;
mod extremes;
mod forces;
pub mod foundation;
mod groups;
pub mod mapping;
mod pool;
pub mod predicted_pressure;
mod states;
mod stiffness;
pub mod sum_factorization;
pub mod surface;
mod viscous;
pub mod volume;

pub use deformation::{gather, scatter};

use super::SolidError;
use super::material::{HyperelasticMaterial, KelvinVoigt, WallAxes};
use super::space::numbering::Numbering;
use super::space::shapes::Shapes;
use super::space::{Mode, Space};
use crate::mesh::WallDirections;
use crate::{Mat3, Vec3};
use fsi_numerics::quadrature::Rule;
use groups::Groups;
use mapping::{Mapping, lattice};
use pool::Pool;
use rayon::prelude::*;
use std::sync::Arc;
use sum_factorization::{SumFactorization, Workspace};
use volume::{Formulation, Projection};

/// The six blocks `K^{ik}`, `i <= k`, of a symmetric element matrix.
pub const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// What an element's shape contributes at a quadrature point.
#[derive(Debug, Clone, Copy)]
pub struct ElementPoint {
    /// `∂ξ/∂X S`, with the prestretch `S`.
    pub inverse_jacobian: Mat3,
    /// Quadrature weight times `det ∂X/∂ξ`, m³.
    pub weight: f64,
    /// Directions of the wall.
    pub frame: WallAxes,
}

/// What a body is like besides its shape.
#[derive(Debug, Clone, Copy)]
pub struct Fabric<'a> {
    /// Directions along and around.
    pub directions: &'a WallDirections,
    /// Stretch along the first of them in the reference configuration; 1 without.
    pub prestretch: f64,
}

/// `S` for a stretch where `along` points along the vessel.
fn prestretch(stretch: f64, along: &Vec3) -> Mat3 {
    if stretch == 1.0 {
        return Mat3::identity();
    }
    let across = 1.0 / stretch.sqrt();
    Mat3::identity() * across + along * along.transpose() * (stretch - across)
}

/// Tensor product Gauss quadrature over all elements of a mesh.
pub struct Elements {
    /// Modes at the quadrature points.
    pub shapes: Shapes,
    /// Element matrices.
    sums: SumFactorization,
    workspaces: Pool<Workspace>,
    /// Coordinates of the points along the three directions.
    axes: [Vec<f64>; 3],
    /// Quadrature points of the reference hexahedron.
    pub local: Vec<[f64; 3]>,
    /// `points[e][q]`.
    pub points: Vec<Vec<ElementPoint>>,
    /// See [`Fabric::prestretch`].
    prestretch: f64,
    /// Whence the volumetric energy takes the volume ratio; absent if from `det F` at each point.
    projection: Option<Projection>,
    /// The points once more, as internal forces take them.
    groups: Groups,
}

/// Everything that the integrals need besides the displacement.
#[derive(Clone, Copy)]
pub struct Body<'a> {
    /// Global numbers of the modes.
    pub numbering: &'a Numbering,
    /// Material of each region.
    pub materials: &'a [Arc<dyn HyperelasticMaterial>],
    /// Viscous part of it, if it has one.
    pub viscous: &'a [Option<KelvinVoigt>],
    /// Region of each element.
    pub regions: &'a [usize],
    /// Shape of the elements.
    pub mapping: &'a Mapping,
}

/// How a body moves.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// Velocity coefficients, m/s.
    pub velocity: &'a [f64],
    /// Derivative of the velocity by the displacement in the time integration, 1/s.
    pub slope: f64,
}

impl Elements {
    /// Prepares quadrature with `points` Gauss points in each local direction.
    pub fn gauss(
        numbering: &Numbering,
        space: &Space,
        mapping: &Mapping,
        fabric: Fabric,
        elements: usize,
        points: [usize; 3],
        formulation: Formulation,
    ) -> Result<Self, SolidError> {
        let rules = points.map(Rule::gauss_legendre);
        let mut prepared = Self::new(numbering, space, mapping, fabric, elements, &rules)?;
        if formulation == Formulation::Mixed {
            prepared.projection = Some(prepared.projection(&volume::modes(space)));
        }
        Ok(prepared)
    }

    /// Prepares the points of a tensor product of three rules.
    pub fn new(
        numbering: &Numbering,
        space: &Space,
        mapping: &Mapping,
        fabric: Fabric,
        elements: usize,
        rules: &[Rule; 3],
    ) -> Result<Self, SolidError> {
        let axes = [
            &rules[0].points[..],
            &rules[1].points[..],
            &rules[2].points[..],
        ];
        let weights: Vec<f64> = lattice([&rules[0].weights, &rules[1].weights, &rules[2].weights])
            .map(|[a, b, c]| a * b * c)
            .collect();
        let mapped = mapping.on(axes);
        let points = (0..elements)
            .into_par_iter()
            .map(|e| {
                let mapped = mapped(e);
                let place = lattice(axes);
                let point = |((m, w), xi): ((&mapping::MappedPoint, &f64), [f64; 3])| {
                    let determinant = m.jacobian.determinant();
                    let inverse = m.jacobian.try_inverse().filter(|_| determinant > 0.0);
                    let inverse_jacobian = inverse.ok_or_else(|| SolidError::Inverted {
                        element: e,
                        jacobian: determinant,
                        position: m.position.into(),
                    })?;
                    let [g0, g1] = [0, 1].map(|d| Vec3::from(m.jacobian.column(d)));
                    let [along, around] = fabric.directions.tangents(e, xi, g0, g1);
                    let frame = WallAxes::from_tangents(&along, &around);
                    Ok(ElementPoint {
                        inverse_jacobian: match fabric.prestretch == 1.0 {
                            true => inverse_jacobian,
                            false => inverse_jacobian * prestretch(fabric.prestretch, &frame.axial),
                        },
                        weight: w * determinant,
                        frame,
                    })
                };
                mapped.iter().zip(&weights).zip(place).map(point).collect()
            })
            .collect::<Result<Vec<_>, SolidError>>()?;
        let shapes = Shapes::new(&numbering.modes, space, axes);
        Ok(Self {
            groups: Groups::new(&shapes, &points, fabric.prestretch),
            shapes,
            sums: SumFactorization::new(&numbering.modes, space, axes, PAIRS.len()),
            workspaces: Pool::default(),
            local: lattice(axes).collect(),
            axes: axes.map(<[f64]>::to_vec),
            points,
            prestretch: fabric.prestretch,
            projection: None,
        })
    }

    /// The projection at the points onto products of Legendre polynomials.
    pub fn projection(&self, modes: &[Mode]) -> Projection {
        Projection::new(
            modes,
            self.axes.each_ref().map(|axis| &axis[..]),
            &self.points,
        )
    }
}
