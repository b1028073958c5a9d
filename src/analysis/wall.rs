//! The wall of a case in figures, without blood: how wide it stands under the pressures that its windkessel will make, and
//! how far they are from buckling.

use crate::Vec3;
use crate::case::{self, BloodVessel, Shape};
use crate::curve::SpaceCurve;
use crate::geometry::{self, HexFace, HexMesh, Vessel};
use crate::pfem::discretization::{Discretization, Options};
use crate::pfem::element::mapping::MappingKind;
use crate::pfem::element::surface::{LoadKind, Surface, on_face};
use crate::pfem::solution::statics::{self, Load, StaticOptions};
use crate::pfem::supports::{self, Profile};
use crate::pfem::{SolidError, Space, SpaceKind, SurfaceLoad};
use nalgebra::Vector2;

/// Pieces of a side of an element in which the volume of the lumen is measured.
const PIECES: usize = 8;
/// Up to this multiple of the highest pressure buckling is looked for.
const REACH: f64 = 2.0;

/// The lumen in the middle of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// What the section is called.
    pub name: String,
    /// Mean radius without load, m.
    pub radius: f64,
    /// Mean radius under each pressure, m.
    pub loaded_radii: Vec<f64>,
    /// Shift of the centre under each pressure, m.
    pub shifts: Vec<f64>,
}

/// The wall under its pressures.
#[derive(Debug, Clone, PartialEq)]
pub struct WallFigures {
    /// Pressures of the figures, Pa, as far as the wall carries them.
    pub pressures: Vec<f64>,
    /// In the middle of the graft and of the artery.
    pub sections: Vec<Section>,
    /// Pressure (Pa) at which this wall loses its stability, if below [`Self::reach`].
    pub buckling: Option<f64>,
    /// The same for the wall without its imperfection: an imperfect wall bends more and more on the way there.
    pub perfect_buckling: Option<f64>,
    /// Highest pressure that was tried, Pa.
    pub reach: f64,
}

/// A discretized wall that can be put under pressure.
struct LoadedWall {
    mesh: HexMesh,
    body: Discretization,
    surface: Surface,
    /// The pressure around it, if there is any.
    outer: Option<(Surface, SurfaceLoad)>,
    /// Length between the ends relative to the unloaded one.
    axial_stretch: f64,
    /// The centre-line.
    line: SpaceCurve,
}

impl LoadedWall {
    fn new(vessel: &BloodVessel, settings: &case::StructureSettings) -> Result<Self, SolidError> {
        let mesh = geometry::solid_mesh(vessel);
        let space = Space::isotropic(SpaceKind::Trunk, settings.p);
        let mut options = Options::new(space);
        options.formulation = settings.formulation;
        if let Some(degree) = settings.p_geometry {
            options.mapping = MappingKind::Blended(degree);
        }
        if let Some(points) = settings.quadrature_points {
            options.quadrature_points = [points; 3];
        }
        let materials = Vessel::new(vessel).materials().to_vec();
        let supports = supports::of_vessel(vessel);
        let body = Discretization::new(&mesh, &materials, &supports, &options)?;
        let faces = supports::surface(&mesh, "inner")?;
        let points = options.quadrature_points[0];
        let new = |faces| Surface::new(&body.numbering, &body.space, &body.mapping, faces, points);
        let surface = new(faces)?;
        let around = supports::pressure_around(vessel);
        let outer = if around == Profile::default() {
            None
        } else {
            let outer = new(supports::surface(&mesh, "outer")?)?;
            let places = outer.points.iter().map(|point| point.position.x);
            let load = SurfaceLoad {
                pressure: places.map(|x| around.at(x)).collect(),
                shear: vec![Vec3::zeros(); outer.points.len()],
            };
            Some((outer, load))
        };
        Ok(Self {
            outer,
            axial_stretch: vessel.axial_stretch(),
            line: Vessel::new(vessel).centre_line().clone(),
            mesh,
            body,
            surface,
        })
    }

    /// Equilibrium under a pressure (Pa) inside and the one around, which grow together, or up to where stability is lost.
    fn inflate(&self, pressure: f64) -> Result<statics::Equilibrated, SolidError> {
        let points = self.surface.points.len();
        let inside = SurfaceLoad::uniform_pressure(pressure, points);
        let outside = self.outer.as_ref();
        let loads: Vec<Load> = std::iter::once((&self.surface, &inside))
            .chain(outside.map(|(surface, load)| (surface, load)))
            .map(|(surface, values)| Load::Surface {
                surface,
                values: values.clone(),
                kind: LoadKind::Follower,
            })
            .collect();
        let options = StaticOptions {
            tolerance: 1e-6,
            ..Default::default()
        };
        if self.axial_stretch == 1.0 {
            return statics::solve(&self.body, &loads, None, &options);
        }
        let mut guess = vec![0.0; self.body.coefficients()];
        for (vertex, &function) in self.body.numbering.of_vertex.iter().enumerate() {
            guess[3 * function] = (self.axial_stretch - 1.0) * self.mesh.vertices[vertex].x;
        }
        let stretched = statics::stretch(&self.body, &guess, &options)?.displacement;
        statics::solve_onto(&self.body, stretched, &loads, &options)
    }

    /// Volume (m³) between the lumen's surface and the origin, for a displacement: by the theorem of Gauss that of the
    /// lumen, but for what the clamped ends close, which no displacement changes.
    fn lumen_volume(&self, displacement: &[f64]) -> Result<f64, SolidError> {
        let mut volume = 0.0;
        for &(e, face) in supports::surface(&self.mesh, "inner")? {
            let place = |i: usize, j: usize| {
                let [a, b] = [i, j].map(|i| 2.0 * i as f64 / PIECES as f64 - 1.0);
                let xi = on_face(face, a, b);
                self.body.mapping.at(e, xi).position
                    + self.body.displacement_at(e, xi, displacement)
            };
            for (i, j) in (0..PIECES * PIECES).map(|n| (n / PIECES, n % PIECES)) {
                let [a, b, c, d] =
                    [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| place(i, j));
                volume += (a.dot(&b.cross(&c)) + a.dot(&c.cross(&d))) / 6.0;
            }
        }
        Ok(volume.abs())
    }

    /// Mean radius and centre of the lumen around `x` (m), for a displacement.
    fn lumen(&self, x: f64, displacement: &[f64]) -> Result<(f64, Vector2<f64>), SolidError> {
        let faces = supports::surface(&self.mesh, "inner")?;
        let middle = |&(e, face): &(usize, HexFace)| {
            let place = self.body.mapping.at(e, on_face(face, 0.0, 0.0)).position;
            (self.line.beside(&place).s - x).abs()
        };
        let frame = self.line.frame(x);
        let nearest = faces.iter().map(middle).fold(f64::INFINITY, f64::min);
        // The ring of elements whose middle is closest.
        let ring = faces
            .iter()
            .filter(|face| middle(face) < nearest * (1.0 + 1e-6) + 1e-9);
        let mut places = Vec::new();
        for &(e, face) in ring {
            for (a, b) in [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)] {
                let xi = on_face(face, a, b);
                let place = self.body.mapping.at(e, xi).position
                    + self.body.displacement_at(e, xi, displacement);
                places.push(Vector2::from(frame.across(&(place - frame.origin))));
            }
        }
        let count = places.len() as f64;
        let centre = places.iter().sum::<Vector2<f64>>() / count;
        let radius = places
            .iter()
            .map(|place| (place - centre).norm())
            .sum::<f64>()
            / count;
        Ok((radius, centre))
    }
}

impl WallFigures {
    /// The wall of a vessel, discretized with these `settings`, under these `pressures` (Pa, ascending).
    ///
    /// # Errors
    /// If the wall is not well posed, or finds no equilibrium.
    pub fn new(
        keys: &BloodVessel,
        settings: &case::StructureSettings,
        pressures: &[f64],
    ) -> Result<Self, SolidError> {
        let wall = LoadedWall::new(keys, settings)?;
        let vessel = Vessel::new(keys);
        let zero = vec![0.0; wall.body.coefficients()];
        let places = vessel.elastic_sections();
        let places =
            places.map(|section| (section.name.clone(), 0.5 * (section.from + section.to)));
        let section =
            |(name, x): (String, f64)| -> Result<(Section, f64, Vector2<f64>), SolidError> {
                let (radius, centre) = wall.lumen(x, &zero)?;
                let empty = Section {
                    name,
                    radius,
                    loaded_radii: Vec::new(),
                    shifts: Vec::new(),
                };
                Ok((empty, x, centre))
            };
        let mut sections: Vec<_> = places.map(section).collect::<Result<_, _>>()?;
        let (mut reached, mut buckling) = (Vec::new(), None);
        for &pressure in pressures {
            let found = wall.inflate(pressure)?;
            if let Some(bifurcation) = &found.bifurcation {
                buckling = Some(bifurcation.factor * pressure);
                break;
            }
            reached.push(pressure);
            for (section, x, old) in &mut sections {
                let (radius, centre) = wall.lumen(*x, &found.displacement)?;
                section.loaded_radii.push(radius);
                section.shifts.push((centre - *old).norm());
            }
        }
        let reach = REACH * pressures.last().copied().unwrap_or(0.0);
        let mut perfect = keys.clone();
        let is_perfect = match &mut perfect.shape {
            Shape::Anastomosis(vessel) => std::mem::take(&mut vessel.model.d_max) == 0.0,
            Shape::Vessel(_) => true,
        };
        let straight = LoadedWall::new(&perfect, settings)?.inflate(reach)?;
        let perfect_buckling = straight.bifurcation.map(|found| found.factor * reach);
        Ok(Self {
            pressures: reached,
            sections: sections.into_iter().map(|(section, ..)| section).collect(),
            buckling: buckling.or(perfect_buckling.filter(|_| is_perfect)),
            perfect_buckling,
            reach,
        })
    }
}

/// Volume that the lumen of a vessel gains by pressure between `lowest` and `highest` (Pa), per pressure, m³/Pa; its wall
/// is discretized with these `settings`. `None` if the wall buckles on the way.
///
/// # Errors
/// If the wall is not well posed, or finds no equilibrium.
pub fn compliance(
    keys: &BloodVessel,
    settings: &case::StructureSettings,
    lowest: f64,
    highest: f64,
) -> Result<Option<f64>, SolidError> {
    let wall = LoadedWall::new(keys, settings)?;
    let mut volumes = [0.0; 2];
    for (volume, pressure) in volumes.iter_mut().zip([lowest, highest]) {
        let found = wall.inflate(pressure)?;
        if found.bifurcation.is_some() {
            return Ok(None);
        }
        *volume = wall.lumen_volume(&found.displacement)?;
    }
    Ok(Some((volumes[1] - volumes[0]) / (highest - lowest)))
}
