//! A tube inflated by internal pressure: the model, its static equilibrium, and what is measured on it.

use crate::Vec3;
use crate::case::Material;
use crate::case::words;
use crate::geometry::{HexMesh, tube_mesh};
use crate::pfem::discretization::{Discretization, Options};
use crate::pfem::element::mapping::{EXACT_DEGREE, MappingKind, lattice};
use crate::pfem::element::surface::{LoadKind, Surface};
use crate::pfem::element::volume::{self, Basis};
use crate::pfem::evaluation::extremes::Extremes;
use crate::pfem::evaluation::stress::StressState;
use crate::pfem::solution::statics::{self, Equilibrated, Load, StaticOptions};
use crate::pfem::supports::{self, Direction, Foundation, Profile, Support};
use crate::pfem::{SolidError, SurfaceLoad};
use crate::quadrature::Rule;

/// Gauss points per direction beyond the degree of space or mapping with which energies and Jacobians are evaluated.
/// With a bulk modulus of 2·10⁴ shear moduli, the energy at `p + 1` points can look a hundred times better than it is:
/// the volume errs between the points.
const FINE: usize = 4;

/// Elements along the axis, around the circumference, and through all layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TubeGrid {
    /// Along the axis.
    pub axial: usize,
    /// Around the circumference.
    pub circumferential: usize,
    /// Through each layer.
    pub radial_per_layer: usize,
    /// Number of layers.
    pub layers: usize,
}

impl TubeGrid {
    /// Elements through the wall.
    pub fn radial(&self) -> usize {
        self.layers * self.radial_per_layer
    }
}

impl std::fmt::Display for TubeGrid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}x{}x{}",
            self.axial,
            self.circumferential,
            self.radial()
        )
    }
}

/// A tube, what holds it and what loads it.
pub struct Tube {
    /// Resolution of the mesh.
    pub grid: TubeGrid,
    /// The mesh.
    pub mesh: HexMesh,
    /// Material of each region.
    pub materials: Vec<Material>,
    /// What holds it.
    pub supports: Vec<Support>,
    /// Pressure on the inner surface, Pa.
    pub pressure: f64,
    /// On which area, inside and outside.
    pub kind: LoadKind,
    /// Distance of the ends relative to the unloaded length, held while pressures act.
    pub axial_stretch: f64,
    /// Pressure on the outer surface, Pa.
    pub outer_pressure: f64,
}

/// What surrounds a tube: per reference area of its outer surface, and along its radius.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Surrounding {
    /// Stiffness of springs, Pa/m.
    pub spring: f64,
    /// The same of dampers, Pa s/m.
    pub damping: f64,
    /// Pressure on the area that the load inside acts on, Pa.
    pub pressure: f64,
}

words! {
    /// What holds the two ends.
    #[derive(Default)]
    pub enum TubeEnds {
        /// `u_x = 0`: plane strain.
        Axial = "axial" (default),
        /// No displacement.
        Clamped = "clamped",
        /// `u_x = 0`, and each point moves along its radius only.
        Radial = "radial",
        /// Springs in all directions.
        Springs = "springs",
    }
}

impl Tube {
    /// A circular tube of layers `(thickness in m, material)` from the inside out, from x = 0 to `length`.
    pub fn circular(
        inner_radius: f64,
        length: f64,
        layers: &[(f64, Material)],
        grid: TubeGrid,
        ends: TubeEnds,
    ) -> Self {
        let thickness: Vec<f64> = layers.iter().map(|layer| layer.0).collect();
        let mesh = tube_mesh(
            inner_radius,
            &thickness,
            length,
            grid.axial,
            grid.circumferential,
            grid.radial_per_layer,
        );
        let supports = match ends {
            TubeEnds::Clamped => ["start", "end"].map(|s| Support::Clamped(s.into())).into(),
            TubeEnds::Axial => sliding_and_symmetric(&mesh, grid.circumferential),
            TubeEnds::Radial => ["start", "end"].map(supports::sliding_radially).concat(),
            TubeEnds::Springs => Vec::new(),
        };
        Self {
            grid,
            mesh,
            materials: layers.iter().map(|layer| layer.1.clone()).collect(),
            supports,
            pressure: 0.0,
            kind: LoadKind::Follower,
            axial_stretch: 1.0,
            outer_pressure: 0.0,
        }
    }

    /// The same tube, with ends on springs of this stiffness (Pa/m) if that is what holds it.
    pub fn on_springs(mut self, ends: TubeEnds, spring: f64) -> Self {
        if ends == TubeEnds::Springs {
            let springs = ["start", "end"].map(|name| supports::on_springs(name, spring));
            self.supports.extend(springs);
        }
        self
    }

    /// The same tube with its ends moved apart.
    pub fn stretched(self, axial_stretch: f64) -> Self {
        Self {
            axial_stretch,
            ..self
        }
    }

    /// The same tube in a surrounding.
    pub fn surrounded(mut self, by: &Surrounding) -> Self {
        if by.spring != 0.0 || by.damping != 0.0 {
            self.supports.push(Support::Foundation(Foundation {
                surface: "outer".into(),
                spring: Profile::constant(by.spring),
                damping: Profile::constant(by.damping),
                direction: Direction::Radial,
                ..Foundation::default()
            }));
        }
        self.outer_pressure = by.pressure;
        self
    }

    /// The same tube under a pressure (Pa).
    pub fn loaded(self, pressure: f64, kind: LoadKind) -> Self {
        Self {
            pressure,
            kind,
            ..self
        }
    }

    /// Puts space, mapping and quadrature on the mesh.
    pub fn discretize(&self, options: &Options) -> Result<Discretization, SolidError> {
        Discretization::new(&self.mesh, &self.materials, &self.supports, options)
    }

    /// A surface of a discretized tube with `points` quadrature points a direction.
    fn surface(
        &self,
        body: &Discretization,
        name: &str,
        points: usize,
    ) -> Result<Surface, SolidError> {
        let faces = supports::surface(&self.mesh, name)?;
        Surface::new(&body.numbering, &body.space, &body.mapping, faces, points)
    }

    /// A pressure (Pa) on a surface.
    fn load<'a>(&self, surface: &'a Surface, pressure: f64) -> Load<'a> {
        Load::Surface {
            before: None,
            values: SurfaceLoad::uniform_pressure(pressure, surface.points.len()),
            surface,
            kind: self.kind,
        }
    }

    /// Displacement coefficients of the tube with its ends moved apart, without pressures: the one at x = 0 stays.
    fn stretch(
        &self,
        body: &Discretization,
        statics: &StaticOptions,
    ) -> Result<Vec<f64>, SolidError> {
        let mut guess = vec![0.0; body.coefficients()];
        if self.axial_stretch == 1.0 {
            return Ok(guess);
        }
        for (vertex, &function) in body.numbering.of_vertex.iter().enumerate() {
            guess[3 * function] = (self.axial_stretch - 1.0) * self.mesh.vertices[vertex].x;
        }
        statics::stretch(body, &guess, statics).map(|found| found.displacement)
    }

    /// Displacement coefficients in equilibrium without the pressure inside: under stretch and outer pressure.
    pub fn rest(
        &self,
        body: &Discretization,
        options: &Options,
        statics: &StaticOptions,
    ) -> Result<Vec<f64>, SolidError> {
        let stretched = self.stretch(body, statics)?;
        if self.outer_pressure == 0.0 {
            return Ok(stretched);
        }
        let points = options.quadrature_points.into_iter().max().unwrap_or(1);
        let outer = self.surface(body, "outer", points)?;
        let loads = [self.load(&outer, self.outer_pressure)];
        let found = statics::solve_onto(body, stretched, &loads, statics)?;
        Ok(found.complete()?.displacement)
    }

    /// Static equilibrium; `body` is [`Tube::discretize`]d with `options`. First the ends are moved, then both
    /// pressures grow together. From a `start` all is tried at once, and the steps only if that fails.
    pub fn inflate(
        &self,
        body: &Discretization,
        options: &Options,
        statics: &StaticOptions,
        start: Option<Vec<f64>>,
    ) -> Result<Equilibrated, SolidError> {
        let points = options.quadrature_points.into_iter().max().unwrap_or(1);
        let inner = self.surface(body, "inner", points)?;
        let outer = self.surface(body, "outer", points)?;
        let mut loads = vec![self.load(&inner, self.pressure)];
        if self.outer_pressure != 0.0 {
            loads.push(self.load(&outer, self.outer_pressure));
        }
        if let Some(start) = start
            && let Ok(found) = statics::solve_from(body, &loads, start, statics)
        {
            return Ok(found);
        }
        statics::solve_onto(body, self.stretch(body, statics)?, &loads, statics)
    }

    /// Radial displacement (m) at mid-length, mean over the circumference: inner surface, interfaces, outer surface.
    /// For tubes of [`Tube::circular`].
    pub fn radial_displacement(&self, body: &Discretization, displacement: &[f64]) -> Vec<f64> {
        let grid = self.grid;
        // Mid-length is the middle of an element, or the end of one.
        let (slice, along) = match grid.axial % 2 {
            1 => (grid.axial / 2, 0.0),
            _ => (grid.axial / 2 - 1, 1.0),
        };
        let rule = Rule::gauss_legendre(body.space.max_degree() + FINE);
        let mean = |layer: usize, end: f64| -> f64 {
            let radial = match end {
                e if e < 0.0 => layer * grid.radial_per_layer,
                _ => (layer + 1) * grid.radial_per_layer - 1,
            };
            let (mut sum, mut length) = (0.0, 0.0);
            for around in 0..grid.circumferential {
                let element = (slice * grid.circumferential + around) * grid.radial() + radial;
                for (&point, weight) in rule.points.iter().zip(&rule.weights) {
                    let xi = [along, point, end];
                    let mapped = body.mapping.at(element, xi);
                    let u = body.displacement_at(element, xi, displacement);
                    let radius = mapped.position.y.hypot(mapped.position.z);
                    let radial = (u.y * mapped.position.y + u.z * mapped.position.z) / radius;
                    let arc = weight * mapped.jacobian.column(1).norm();
                    sum += arc * radial;
                    length += arc;
                }
            }
            sum / length
        };
        let outer = (0..grid.layers).map(|layer| mean(layer, 1.0));
        std::iter::once(mean(0, -1.0)).chain(outer).collect()
    }
}

/// `u_x = 0` at both ends, and in the x-y and x-z planes no displacement out of them. Where the mesh has no nodes in
/// the x-z plane (it has if four divides the number of elements around) one vertex is held in y instead: nothing pulls
/// there, so that stresses are the same, but the tube moves sideways as it widens.
fn sliding_and_symmetric(mesh: &HexMesh, circumferential: usize) -> Vec<Support> {
    let ends = ["start", "end"].map(supports::sliding);
    let mut supports: Vec<Support> = ends.into();
    supports.push(Support::SymmetryPlane(2));
    supports.push(match circumferential % 4 {
        0 => Support::SymmetryPlane(1),
        _ => Support::Vertex(
            nearest_vertex(mesh, &mesh.vertices[0]),
            [false, true, false],
        ),
    });
    supports
}

/// The vertex of the mesh nearest to a point.
pub fn nearest_vertex(mesh: &HexMesh, point: &Vec3) -> usize {
    let distance = |v: &usize| (mesh.vertices[*v] - point).norm_squared();
    (0..mesh.vertices.len())
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap_or(0)
}

/// Gauss points per direction with which energies and Jacobians are evaluated: four more than the highest degree of
/// space and mapping, and at least two more than the solution was computed with.
pub fn fine_rule(options: &Options) -> [usize; 3] {
    let geometry = match options.mapping {
        MappingKind::Blended(degree) => degree,
        MappingKind::Exact => EXACT_DEGREE - FINE,
    };
    let degree = options.space.max_degree().max(geometry);
    options
        .quadrature_points
        .map(|points| (degree + FINE).max(points + 2))
}

/// Energy and range of the Jacobian `det F` of a displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measures {
    /// Strain energy, J.
    pub energy: f64,
    /// Jacobian.
    pub extremes: Extremes,
}

/// Evaluates energy and Jacobians with the [`fine_rule`].
pub fn measure(
    body: &Discretization,
    options: &Options,
    displacement: &[f64],
) -> Result<Measures, SolidError> {
    let fine = body.quadrature(fine_rule(options))?;
    Ok(Measures {
        energy: fine.energy(body.body(), displacement)?,
        extremes: fine.extremes(body.body(), displacement)?,
    })
}

/// Displacement (m), stress and strain at the lattice `axis`³ of every element, element by element.
pub fn fields(
    body: &Discretization,
    axis: &[f64],
    displacement: &[f64],
) -> Result<Vec<(Vec3, StressState)>, SolidError> {
    let elements = body.elements_at(axis)?;
    let pressures = body.elements.pressures(body.body(), displacement)?;
    let basis = Basis::new(&volume::modes(&body.space), [axis; 3]);
    let pressures = pressures.as_ref().map(|found| (&basis, &found[..]));
    let states = elements.states(body.body(), displacement, pressures)?;
    let displacements = elements.displacement(&body.numbering, displacement);
    Ok(displacements.into_iter().zip(states).collect())
}

/// Positions (m) of the lattice `axis`³ of every element in the exact shape of the mesh, element by element.
pub fn positions(mesh: &HexMesh, axis: &[f64]) -> Vec<Vec3> {
    (0..mesh.hexes.len())
        .flat_map(|e| lattice([axis; 3]).map(move |xi| mesh.shape.position(e, xi)))
        .collect()
}
