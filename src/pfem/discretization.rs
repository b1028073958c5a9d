//! A body divided into elements: mesh, space, mapping, quadrature, materials and supports put together.

use super::SolidError;
use super::element::foundation::Foundation;
use super::element::mapping::{Mapping, MappingKind};
use super::element::predicted_pressure::{Origin, VolumeGradients, Volumes};
use super::element::surface::Surface;
use super::element::volume::Formulation;
use super::element::{Body, Elements, Fabric, Motion, gather, scatter};
use super::linear_algebra::factor::{Factorization, LARGE, Precision, Symbolic};
use super::linear_algebra::ordering;
use super::linear_algebra::sparse::Pattern;
use super::material::{HyperelasticMaterial, KelvinVoigt, Law};
use super::solid::SurfaceLoad;
use super::space::Space;
use super::space::numbering::Numbering;
use super::space::shapes::Shapes;
use super::supports::{self, Support, Supports};
use crate::Vec3;
use crate::mesh::{HexFace, HexMesh, WallDirections};
use fsi_numerics::quadrature::Rule;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Memory for element matrices that wait to be added, bytes.
const WAITING: usize = 64 << 20;

/// Choices of the discretization.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Ansatz space.
    pub space: Space,
    /// Shape of the elements.
    pub mapping: MappingKind,
    /// Gauss points in each local direction.
    pub quadrature_points: [usize; 3],
    /// Which volume ratio the volumetric energy sees.
    pub formulation: Formulation,
    /// Operations of a factorization from which on the body counts as large: its factors are stored in single precision
    /// at rest too.
    pub large: f64,
    /// Stretch along the vessel in the reference configuration (1 without): see [`Fabric`].
    pub prestretch: f64,
}

impl Options {
    /// Mapping of the largest degree of the space, and one Gauss point more than the degree in each direction.
    pub fn new(space: Space) -> Self {
        Self {
            space,
            mapping: MappingKind::Blended(space.max_degree()),
            quadrature_points: space.degrees.map(|p| p + 1),
            formulation: Formulation::default(),
            large: LARGE,
            prestretch: 1.0,
        }
    }
}

/// A body with everything that does not change when it deforms.
pub struct Discretization {
    /// Ansatz space.
    pub space: Space,
    /// Global functions.
    pub numbering: Numbering,
    /// Shape of the elements.
    pub mapping: Mapping,
    /// Directions along and around, for fibres.
    pub directions: WallDirections,
    /// Quadrature over the elements.
    pub elements: Elements,
    /// Held degrees of freedom.
    pub supports: Supports,
    /// Equations.
    pub pattern: Arc<Pattern>,
    /// Elimination order.
    pub symbolic: Symbolic,
    /// Precision of factors without inertia.
    at_rest: Precision,
    formulation: Formulation,
    quadrature_points: [usize; 3],
    foundations: Vec<Foundation>,
    materials: Arc<[Arc<dyn HyperelasticMaterial>]>,
    viscous: Vec<Option<KelvinVoigt>>,
    regions: Vec<usize>,
    prestretch: f64,
}

impl Discretization {
    /// Puts a body together; `materials` by region.
    pub fn new<M>(
        mesh: &HexMesh,
        materials: &[M],
        supports: &[Support],
        options: &Options,
    ) -> Result<Self, SolidError>
    where
        for<'a> Law: From<&'a M>,
    {
        let laws: Vec<Law> = materials.iter().map(Law::from).collect();
        Self::of_laws(mesh, &laws, supports, options)
    }

    fn of_laws(
        mesh: &HexMesh,
        materials: &[Law],
        supports: &[Support],
        options: &Options,
    ) -> Result<Self, SolidError> {
        if let Some(&region) = mesh.regions.iter().find(|&&r| r >= materials.len()) {
            return Err(SolidError::Model(format!(
                "the mesh has an element of region {region}, but only {} materials are given",
                materials.len()
            )));
        }
        let numbering = Numbering::new(mesh, &options.space)?;
        let mapping = Mapping::new(mesh, options.mapping);
        let count = mesh.hexes.len();
        let (points, formulation) = (options.quadrature_points, options.formulation);
        let elements = Elements::gauss(
            &numbering,
            &options.space,
            &mapping,
            Fabric {
                directions: &mesh.directions,
                prestretch: options.prestretch,
            },
            count,
            points,
            formulation,
        )?;
        let most = points.into_iter().max().unwrap_or(1);
        let foundations = (supports.iter())
            .filter_map(|support| match support {
                Support::Foundation(described) => Some(described),
                _ => None,
            })
            .map(|described| {
                let faces = supports::surface(mesh, &described.surface)?;
                let space = &options.space;
                Foundation::new(&numbering, space, &mapping, faces, most, described)
            })
            .collect::<Result<_, SolidError>>()?;
        let supports = Supports::new(mesh, &numbering, &mapping, supports)?;
        let centres: Vec<Vec3> = (0..count)
            .map(|e| mapping.at(e, [0.0; 3]).position)
            .collect();
        let (pattern, symbolic) = ordered(&numbering, supports.held(), &centres)?;
        Ok(Self {
            space: options.space,
            numbering,
            mapping,
            directions: mesh.directions.clone(),
            elements,
            supports,
            pattern: Arc::new(pattern),
            at_rest: match symbolic.operations() < options.large {
                true => Precision::Double,
                false => Precision::Single,
            },
            symbolic,
            formulation,
            quadrature_points: points,
            foundations,
            materials: materials.iter().map(|law| law.elastic.clone()).collect(),
            viscous: materials.iter().map(|law| law.viscous).collect(),
            regions: mesh.regions.clone(),
            prestretch: options.prestretch,
        })
    }

    /// The elements with the lattice `axis`³ of local coordinates in place of their quadrature, for values that are
    /// looked at.
    pub fn elements_at(&self, axis: &[f64]) -> Result<Elements, SolidError> {
        let rule = Rule {
            points: axis.to_vec(),
            weights: vec![0.0; axis.len()],
        };
        Elements::new(
            &self.numbering,
            &self.space,
            &self.mapping,
            self.fabric(),
            self.regions.len(),
            &[rule.clone(), rule.clone(), rule],
        )
    }

    /// The body before `displacement` (m, all coefficients) led it to the shape that is given: the same numbers of
    /// functions and equations, another reference configuration.
    ///
    /// # Errors
    /// If the displacement turns an element inside out.
    pub fn unloaded_by(&self, displacement: &[f64]) -> Result<Self, SolidError> {
        self.unloaded_with(displacement, 1.0)
    }

    /// As [`Discretization::unloaded_by`], with this power of the prestretch.
    pub(super) fn unloaded_with(
        &self,
        displacement: &[f64],
        power: f64,
    ) -> Result<Self, SolidError> {
        let (numbering, space) = (&self.numbering, &self.space);
        let mapping = self.mapping.unloaded_by(numbering, space, displacement);
        let foundations = self.foundations.iter();
        let foundations =
            foundations.map(|foundation| foundation.reshaped(numbering, space, &mapping));
        let foundations = foundations.collect::<Result<_, _>>()?;
        self.with(mapping, foundations, self.prestretch.powf(power))
    }

    /// The same body with this power of its prestretch.
    ///
    /// # Errors
    /// None that the body itself has not.
    pub fn prestretched_by(&self, power: f64) -> Result<Self, SolidError> {
        let (mapping, foundations) = (self.mapping.clone(), self.foundations.clone());
        self.with(mapping, foundations, self.prestretch.powf(power))
    }

    fn with(
        &self,
        mapping: Mapping,
        foundations: Vec<Foundation>,
        prestretch: f64,
    ) -> Result<Self, SolidError> {
        let (numbering, space) = (&self.numbering, &self.space);
        Ok(Self {
            space: self.space,
            elements: Elements::gauss(
                numbering,
                space,
                &mapping,
                Fabric {
                    directions: &self.directions,
                    prestretch,
                },
                self.regions.len(),
                self.quadrature_points,
                self.formulation,
            )?,
            prestretch,
            foundations,
            mapping,
            directions: self.directions.clone(),
            numbering: numbering.clone(),
            supports: self.supports.clone(),
            pattern: self.pattern.clone(),
            symbolic: self.symbolic.clone(),
            at_rest: self.at_rest,
            formulation: self.formulation,
            quadrature_points: self.quadrature_points,
            materials: self.materials.clone(),
            viscous: self.viscous.clone(),
            regions: self.regions.clone(),
        })
    }

    fn fabric(&self) -> Fabric<'_> {
        Fabric {
            directions: &self.directions,
            prestretch: self.prestretch,
        }
    }

    /// Whether it is free of stress nowhere.
    pub fn is_prestretched(&self) -> bool {
        self.prestretch != 1.0
    }

    /// What integrals over the elements need.
    pub fn body(&self) -> Body<'_> {
        Body {
            numbering: &self.numbering,
            materials: &self.materials,
            viscous: &self.viscous,
            regions: &self.regions,
            mapping: &self.mapping,
        }
    }

    /// Bytes that a moving structure of this body takes, at most: its tangent in use with its factor, and another one
    /// that is being made.
    pub fn memory(&self) -> f64 {
        // Of the matrix: places, two sets of values, and the mass of both triangles with one scalar per block.
        let matrix = (8.0 + 16.0 + 32.0 / 9.0) * self.pattern.entries() as f64;
        // Shape, and the volumes and their gradients of two tangents.
        let points: usize = self.elements.points.iter().map(Vec::len).sum();
        let factor = 4.0 * self.symbolic.entries() as f64;
        matrix + 560.0 * points as f64 + factor + self.symbolic.bytes(Precision::Single)
    }

    /// Which volume ratio the volumetric energy sees.
    pub fn formulation(&self) -> Formulation {
        self.formulation
    }

    /// Region of each element.
    pub fn regions(&self) -> &[usize] {
        &self.regions
    }

    /// Number of displacement coefficients, held ones included.
    pub fn coefficients(&self) -> usize {
        3 * self.numbering.functions
    }

    /// Number of degrees of freedom: coefficients that are not held.
    pub fn degrees_of_freedom(&self) -> usize {
        self.supports.held().iter().filter(|&&held| !held).count()
    }

    /// An error that names a rigid motion which supports and springs leave possible, if there is one.
    pub fn check_rigid_motions(&self) -> Result<(), SolidError> {
        let springs = self.foundations.iter().flat_map(Foundation::held);
        (self.supports).check_rigid_motions(&self.numbering, &self.mapping, springs)
    }

    /// Energy (J) of the springs that hold the body.
    pub fn spring_energy(&self, displacement: &[f64]) -> f64 {
        let foundations = self.foundations.iter();
        foundations
            .map(|foundation| foundation.energy(&self.numbering, displacement))
            .sum()
    }

    /// Force (N) with which springs press the surface `outer` and parts of it inwards, summed over its area.
    pub fn inward_spring_force(&self, displacement: &[f64]) -> f64 {
        let outside = (self.foundations.iter()).filter(|it| it.surface().starts_with("outer"));
        outside
            .map(|foundation| foundation.inward_force(&self.numbering, displacement))
            .sum()
    }

    /// Springs whose state of rest was not known yet exert nothing where the body has this displacement (m, all
    /// coefficients).
    pub fn set_tissue_at_rest(&mut self, displacement: &[f64]) {
        let numbering = &self.numbering;
        let foundations = self.foundations.iter_mut();
        foundations.for_each(|foundation| foundation.set_at_rest(numbering, displacement));
    }

    /// Strain energy of the body itself (J) with `points` Gauss points per direction; a fine rule keeps a nearly
    /// incompressible material from hiding errors of the volume between the points.
    pub fn energy(&self, displacement: &[f64], points: [usize; 3]) -> Result<f64, SolidError> {
        self.quadrature(points)?.energy(self.body(), displacement)
    }

    /// Other quadrature over the same elements: `points` Gauss points per direction.
    pub fn quadrature(&self, points: [usize; 3]) -> Result<Elements, SolidError> {
        Elements::gauss(
            &self.numbering,
            &self.space,
            &self.mapping,
            self.fabric(),
            self.regions.len(),
            points,
            self.formulation,
        )
    }

    /// Internal forces and those of springs at all coefficients, N.
    pub fn internal_forces(&self, displacement: &[f64]) -> Result<Vec<f64>, SolidError> {
        Ok(self.forces_from(displacement, None)?.0)
    }

    /// The same with the pressure that the step from its `origin` predicts, and the volumes.
    pub fn forces_from(
        &self,
        displacement: &[f64],
        origin: Option<Origin>,
    ) -> Result<(Vec<f64>, Option<Volumes>), SolidError> {
        let elements = &self.elements;
        let (mut forces, volumes) = elements.forces_from(self.body(), displacement, origin)?;
        for foundation in &self.foundations {
            foundation.add_spring_forces(&self.numbering, displacement, &mut forces);
        }
        Ok((forces, volumes))
    }

    /// Where a tangent is assembled, what the pressure of later iterates is predicted with, if the body has one.
    pub fn volume_gradients(
        &self,
        displacement: &[f64],
    ) -> Result<Option<VolumeGradients>, SolidError> {
        let mut materials = self.materials.iter();
        if !materials.any(|material| material.volumetric(0.0).curvature != 0.0) {
            return Ok(None);
        }
        let gradients = self.elements.volume_gradients(self.body(), displacement)?;
        Ok(Some(gradients))
    }

    /// Whether a material has a viscous part.
    pub fn is_viscous(&self) -> bool {
        self.viscous.iter().any(Option::is_some)
    }

    /// Forces of viscous stresses and dampers, N at all coefficients; none where nothing resists a velocity.
    pub fn viscous_forces(&self, displacement: &[f64], velocity: &[f64]) -> Option<Vec<f64>> {
        let damps = self.foundations.iter().any(Foundation::damps);
        if !damps && !self.is_viscous() {
            return None;
        }
        let mut forces = if self.is_viscous() {
            (self.elements).viscous_forces(self.body(), displacement, velocity)
        } else {
            vec![0.0; velocity.len()]
        };
        for foundation in &self.foundations {
            foundation.add_damper_forces(&self.numbering, velocity, &mut forces);
        }
        Some(forces)
    }

    /// Displacement (m) at local coordinates of an element.
    pub fn displacement_at(&self, element: usize, xi: [f64; 3], displacement: &[f64]) -> Vec3 {
        let shapes = Shapes::new(
            &self.numbering.modes,
            &self.space,
            [&xi[0..1], &xi[1..2], &xi[2..3]],
        );
        let n = shapes.modes;
        let mut local = vec![0.0; 3 * n];
        gather(&self.numbering, element, displacement, &mut local);
        Vec3::from_fn(|i, _| {
            shapes
                .values
                .iter()
                .zip(&local[i * n..])
                .map(|(v, u)| v * u)
                .sum()
        })
    }

    /// Forces (N) of a constant force per reference volume (N/m³) at all coefficients.
    pub fn body_forces(&self, density: Vec3) -> Vec<f64> {
        let n = self.numbering.modes.len();
        let shapes = &self.elements.shapes;
        let mut forces = vec![0.0; self.coefficients()];
        for (e, points) in self.elements.points.iter().enumerate() {
            let mut local = vec![0.0; 3 * n];
            for (values, point) in shapes.values.chunks_exact(n).zip(points) {
                for i in 0..3 {
                    for m in 0..n {
                        local[i * n + m] += values[m] * point.weight * density[i];
                    }
                }
            }
            scatter(&self.numbering, e, &local, &mut forces);
        }
        forces
    }

    /// Values of the tangent of the forces of elements and springs and of following pressures; see
    /// [`Elements::stiffness`] for `linearized_at`.
    pub fn tangent(
        &self,
        displacement: &[f64],
        linearized_at: Option<&[f64]>,
        following: &[(&Surface, &SurfaceLoad)],
    ) -> Result<Vec<f64>, SolidError> {
        self.moving_tangent(displacement, linearized_at, following, None)
    }

    /// The same with the forces that resist a motion; of those of viscous stresses the symmetric part.
    pub fn moving_tangent(
        &self,
        displacement: &[f64],
        linearized_at: Option<&[f64]>,
        following: &[(&Surface, &SurfaceLoad)],
        motion: Option<&Motion>,
    ) -> Result<Vec<f64>, SolidError> {
        let mut values = vec![0.0; self.pattern.entries()];
        let modes = self.numbering.modes.len();
        let slope = motion.map_or(0.0, |motion| motion.slope);
        let tangents = |f: &Foundation| f.tangents(&self.numbering, displacement, slope);
        let foundations: Vec<_> = self.foundations.iter().map(tangents).collect();
        let size = 48 * modes.pow(2);
        let batch = (WAITING / size).max(rayon::current_num_threads());
        let elements: Vec<usize> = (0..self.regions.len()).collect();
        for batch in elements.chunks(batch) {
            let matrices = batch
                .par_iter()
                .map(|&e| {
                    let mut blocks = self.elements.stiffness(
                        self.body(),
                        e,
                        displacement,
                        linearized_at,
                        motion,
                    )?;
                    for (surface, load) in following {
                        surface.add_stiffness(&self.numbering, displacement, load, e, &mut blocks);
                    }
                    for (foundation, tangents) in self.foundations.iter().zip(&foundations) {
                        foundation.add_stiffness(e, tangents, modes, &mut blocks);
                    }
                    Ok((e, blocks))
                })
                .collect::<Result<Vec<_>, SolidError>>()?;
            self.pattern.add(&matrices, &mut values);
        }
        Ok(values)
    }

    /// Factorizes an assembled tangent with single components held.
    pub fn factorize(&self, tangent: &[f64]) -> Result<Factorization, SolidError> {
        let wanted = AtomicBool::new(false);
        (self.symbolic).factorize(&self.pattern, tangent, self.at_rest, &wanted)
    }

    /// The same of a body that moves, unless it is `cancelled`. Inertia keeps its tangent well enough conditioned for
    /// single precision.
    pub fn factorize_moving(
        &self,
        cancelled: &AtomicBool,
        tangent: &[f64],
    ) -> Result<Factorization, SolidError> {
        (self.symbolic).factorize(&self.pattern, tangent, Precision::Single, cancelled)
    }

    /// Whether an assembled tangent with single components held is positive definite.
    pub fn is_positive_definite(&self, tangent: &[f64]) -> bool {
        (self.symbolic).is_positive_definite(&self.pattern, tangent)
    }

    /// The entries of a vector of all coefficients that belong to equations; zero where a component is held.
    pub fn restrict(&self, full: &[f64]) -> Vec<f64> {
        let held = self.supports.held();
        self.pattern
            .functions
            .iter()
            .flat_map(|&f| (3 * f..3 * f + 3).map(|dof| if held[dof] { 0.0 } else { full[dof] }))
            .collect()
    }

    /// `full + scale * reduced`.
    pub fn moved(&self, full: &[f64], reduced: &[f64], scale: f64) -> Vec<f64> {
        let mut moved = full.to_vec();
        for (&f, step) in self.pattern.functions.iter().zip(reduced.chunks_exact(3)) {
            for i in 0..3 {
                moved[3 * f + i] += scale * step[i];
            }
        }
        moved
    }

    /// Norm of the internal forces below which they are round-off, N: the rounding of strains of order one times the
    /// stiffness of the undeformed body.
    pub fn round_off(&self) -> Result<f64, SolidError> {
        let tangent = self.tangent(&vec![0.0; self.coefficients()], None, &[])?;
        let matrix = self.pattern.matrix(&tangent);
        let diagonal: f64 = (0..matrix.ncols())
            .map(|j| matrix.val_of_col(j)[0].powi(2))
            .sum::<f64>()
            .sqrt();
        Ok(4.0 * f64::EPSILON * diagonal * self.element_size())
    }

    /// Volume, m³.
    pub fn volume(&self) -> f64 {
        let points = self.elements.points.iter().flatten();
        points.map(|point| point.weight).sum()
    }

    /// Edge of a cube with the mean volume of an element, m.
    pub fn element_size(&self) -> f64 {
        (self.volume() / self.regions.len() as f64).cbrt()
    }

    /// The force (N) that a part of the boundary is held with: the sum of the internal forces, those of springs
    /// included, at a named surface.
    ///
    /// # Errors
    /// If there is no such surface, or the displacement turns an element inside out.
    pub fn resultant(
        &self,
        surface: &[(usize, HexFace)],
        displacement: &[f64],
    ) -> Result<Vec3, SolidError> {
        let forces = self.internal_forces(displacement)?;
        let on_faces = surface.iter().flat_map(|&(e, face)| {
            let modes = supports::modes_on_face(&self.numbering, face);
            modes.filter_map(move |m| {
                // Only functions of vertices do not vanish in the sum of a constant.
                let is_vertex = self.numbering.modes[m].iter().all(|&k| k <= 1);
                self.numbering.of_element[e][m].filter(|_| is_vertex)
            })
        });
        let functions: std::collections::BTreeSet<usize> = on_faces.collect();
        let force = |f: usize| Vec3::new(forces[3 * f], forces[3 * f + 1], forces[3 * f + 2]);
        Ok(functions.into_iter().map(force).sum())
    }
}

/// The equations in the best one of three orders of elimination, by minimum degree as a whole or in two halves (long
/// tubes) and by nested dissection (high degrees), balanced for two threads, and the structure of their factor.
fn ordered(
    numbering: &Numbering,
    held: &[bool],
    centres: &[Vec3],
) -> Result<(Pattern, Symbolic), SolidError> {
    let natural: Vec<usize> = (0..numbering.functions).collect();
    let pattern = Pattern::new(numbering, held, &natural);
    if pattern.is_empty() {
        return Err(SolidError::Model("the supports hold the whole body".into()));
    }
    let analyzed = |order: &[usize]| -> Result<(Pattern, Symbolic), SolidError> {
        let pattern = Pattern::new(numbering, held, order);
        let symbolic = Symbolic::new(&pattern)?;
        Ok((pattern, symbolic))
    };
    let orders = [
        ordering::minimum_degree(&pattern)?,
        ordering::two_halves(&pattern, numbering, centres)?,
        ordering::nested_dissection(numbering, centres),
    ];
    let mut best = analyzed(&orders[0])?;
    for order in &orders[1..] {
        let other = analyzed(order)?;
        if other.1.entries() < best.1.entries() {
            best = other;
        }
    }
    let (pattern, symbolic) = best;
    // A function has three rows, next to each other.
    let rows = symbolic.balanced().into_iter();
    let mut order: Vec<usize> = rows.map(|row| pattern.functions[row / 3]).collect();
    let mut is_listed = vec![false; numbering.functions];
    order.retain(|&function| !std::mem::replace(&mut is_listed[function], true));
    analyzed(&order)
}
