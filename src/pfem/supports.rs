//! Which degrees of freedom are held, and whether that is enough.

use super::SolidError;
use super::element::mapping::Mapping;
use super::space::numbering::Numbering;
use crate::mesh::{HexFace, HexMesh};
use crate::{Mat3, Vec3};
use std::fmt;
use std::sync::Arc;

/// Components of displacement that are held at all functions of a body.
#[derive(Debug, Clone)]
pub struct Supports {
    held: Vec<bool>,
}

/// Something that holds a part of the body; see the variants.
#[derive(Debug, Clone)]
pub enum Support {
    /// All components on a named surface.
    Clamped(String),
    /// The given components (x, y, z) on a named surface.
    Surface(String, [bool; 3]),
    /// The component normal to the coordinate plane through the origin, for vertices, edges and faces that lie in it:
    /// 0 the plane x = 0, 1 the plane y = 0, 2 the plane z = 0.
    SymmetryPlane(usize),
    /// The given components of one vertex of the mesh.
    Vertex(usize, [bool; 3]),
    /// Springs and dampers on a named surface, which hold nothing fast.
    Foundation(Foundation),
}

/// Springs and dampers between a surface and a surrounding at rest; see
/// [`foundation`](super::element::foundation).
#[derive(Debug, Clone, Default)]
pub struct Foundation {
    /// Name of the surface.
    pub surface: String,
    /// Stiffness of the springs per area in the state of rest, Pa/m, along the axis.
    pub spring: Profile,
    /// The same of the dampers, Pa s/m.
    pub damping: Profile,
    /// Which displacement they resist.
    pub direction: Direction,
    /// The state in which springs exert nothing.
    pub at_rest: AtRest,
    /// The axis of `direction`; the x-axis if there is none.
    pub axis: Option<Arc<dyn Axis>>,
}

/// A line along a body, by which directions and strengths of springs are told.
pub trait Axis: fmt::Debug + Send + Sync {
    /// The line where it is nearest to the point `x` (m).
    fn nearest(&self, x: &Vec3) -> AxisPoint;
}

/// Arc length (m) of an axis next to the point `x` (m); the x-axis if there is none.
pub(super) fn arc_length(axis: Option<&Arc<dyn Axis>>, x: &Vec3) -> f64 {
    axis.map_or(x.x, |line| line.nearest(x).s)
}

/// A pressure (Pa) on a surface that varies along an axis.
#[derive(Debug, Clone)]
pub struct PressureAround {
    /// The pressure along the axis.
    pub pressure: Profile,
    /// The axis; the x-axis if there is none.
    pub axis: Option<Arc<dyn Axis>>,
}

impl PressureAround {
    /// The same everywhere.
    pub fn constant(pressure: f64) -> Self {
        Self {
            pressure: Profile::constant(pressure),
            axis: None,
        }
    }

    /// The pressure on the surface next to the point `x` (m).
    pub fn at(&self, x: &Vec3) -> f64 {
        self.pressure.at(arc_length(self.axis.as_ref(), x))
    }
}

/// A point of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisPoint {
    /// Arc length, m.
    pub s: f64,
    /// Position, m.
    pub position: Vec3,
    /// Direction of the line, a unit vector.
    pub tangent: Vec3,
}

/// Which displacement springs and dampers resist.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Direction {
    /// The distance from the axis of a vessel.
    #[default]
    Radial,
    /// The displacement around the axis, across the radius of the body at rest.
    Tangential,
    /// The displacement along the axis.
    Axial,
    /// All components alike.
    All,
}

/// The state in which springs exert nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AtRest {
    /// The reference configuration.
    #[default]
    Reference,
    /// One that is said later: see [`Structure::set_tissue_at_rest`](super::Structure::set_tissue_at_rest). Until then nothing is
    /// exerted.
    Loaded,
}

/// A value that varies along the axis: given at some places (m, ascending), linear in between, constant before the
/// first and after the last; zero without any.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Profile(pub Vec<(f64, f64)>);

impl Profile {
    /// The same everywhere.
    pub fn constant(value: f64) -> Self {
        Self(vec![(0.0, value)])
    }

    /// The value at `x` (m).
    pub fn at(&self, x: f64) -> f64 {
        let next = self.0.partition_point(|&(place, _)| place <= x);
        match (next.checked_sub(1).map(|i| self.0[i]), self.0.get(next)) {
            (None, None) => 0.0,
            (Some((_, value)), None) | (None, Some(&(_, value))) => value,
            (Some((a, u)), Some(&(b, v))) => u + (v - u) * (x - a) / (b - a),
        }
    }
}

/// Stiffness (Pa/m) with which guided ends are kept from turning, and from moving sideways or along their axis:
/// traction there moves them by 1e-12 m for each Pa. That is as stiff as the bulk of a wall that is nearly
/// incompressible.
const GUIDE: f64 = 1e12;

/// The surface `name` is a cross-section at an end of a vessel that slides in its plane.
pub fn sliding(name: &str) -> Support {
    Support::Surface(name.into(), [true, false, false])
}

/// The same of an end that slides radially.
pub fn sliding_radially(name: &str) -> [Support; 2] {
    [sliding(name), guide(name, Direction::Tangential, None)]
}

/// The surface `name` hardly moves in this direction of an axis, of the x-axis if there is none.
pub fn guide(name: &str, direction: Direction, axis: Option<Arc<dyn Axis>>) -> Support {
    Support::Foundation(Foundation {
        surface: name.into(),
        spring: Profile::constant(GUIDE),
        direction,
        axis,
        ..Foundation::default()
    })
}

impl Foundation {
    /// Whether it keeps its surface in the planes across its axis.
    pub fn keeps_in_plane(&self) -> bool {
        self.direction == Direction::Axial && self.spring == Profile::constant(GUIDE)
    }
}

/// The same of an end in springs (Pa/m) that resist all directions.
pub fn on_springs(name: &str, spring: f64) -> Support {
    Support::Foundation(Foundation {
        surface: name.into(),
        spring: Profile::constant(spring),
        direction: Direction::All,
        ..Foundation::default()
    })
}

impl Supports {
    /// Applies all supports.
    pub fn new(
        mesh: &HexMesh,
        numbering: &Numbering,
        mapping: &Mapping,
        supports: &[Support],
    ) -> Result<Self, SolidError> {
        let mut held = vec![false; 3 * numbering.functions];
        let mut hold = |function: usize, components: [bool; 3]| {
            (0..3)
                .filter(|&i| components[i])
                .for_each(|i| held[3 * function + i] = true);
        };
        for support in supports {
            match support {
                Support::Clamped(name) => {
                    functions_on(mesh, numbering, name)?.for_each(|f| hold(f, [true; 3]));
                }
                Support::Surface(name, components) => {
                    functions_on(mesh, numbering, name)?.for_each(|f| hold(f, *components));
                }
                Support::SymmetryPlane(axis) => {
                    let components = std::array::from_fn(|i| i == *axis);
                    for f in functions_in_plane(mesh, numbering, mapping, *axis) {
                        hold(f, components);
                    }
                }
                Support::Vertex(vertex, components) => {
                    let function = numbering.of_vertex.get(*vertex).ok_or_else(|| {
                        let count = numbering.of_vertex.len();
                        SolidError::Model(format!(
                            "vertex {vertex} is held, but the mesh has only {count}"
                        ))
                    })?;
                    hold(*function, *components);
                }
                Support::Foundation(_) => {}
            }
        }
        Ok(Self { held })
    }

    /// `held[3 f + i]`: whether component `i` of function `f` is held.
    pub fn held(&self) -> &[bool] {
        &self.held
    }

    /// An error that names a rigid motion which the supports and springs leave possible, if there is one.
    pub fn check_rigid_motions(
        &self,
        numbering: &Numbering,
        mapping: &Mapping,
        springs: impl Iterator<Item = (Vec3, Mat3)>,
    ) -> Result<(), SolidError> {
        let points: Vec<(Vec3, [bool; 3])> = self.sample(numbering, mapping);
        let centre: Vec3 = points.iter().map(|(x, _)| x).sum::<Vec3>() / points.len() as f64;
        let size = points
            .iter()
            .map(|(x, _)| (x - centre).norm())
            .fold(0.0, f64::max);
        let mut gram = nalgebra::Matrix6::<f64>::zeros();
        let components = |held: &[bool; 3]| Vec3::from_fn(|i, _| f64::from(held[i]));
        let held = (points.iter()).map(|(x, held)| (*x, Mat3::from_diagonal(&components(held))));
        for (x, directions) in held.chain(springs) {
            let turned = ((x - centre) / size).cross_matrix();
            let mut motions = nalgebra::Matrix3x6::zeros();
            motions
                .fixed_columns_mut::<3>(0)
                .copy_from(&Mat3::identity());
            motions.fixed_columns_mut::<3>(3).copy_from(&-turned);
            gram += motions.transpose() * directions * motions;
        }
        let eigen = gram.symmetric_eigen();
        let (smallest, value) = eigen.eigenvalues.argmin();
        if value > 1e-10 * eigen.eigenvalues.max().max(1.0) {
            return Ok(());
        }
        let mode = eigen.eigenvectors.column(smallest).into_owned();
        let names = [
            "translation along x",
            "translation along y",
            "translation along z",
            "rotation about an axis parallel to x",
            "rotation about an axis parallel to y",
            "rotation about an axis parallel to z",
        ];
        let name = names[mode.abs().imax()];
        Err(SolidError::Model(format!(
            "the supports leave a rigid motion possible, in the main a {name}: hold more components"
        )))
    }

    /// Positions of vertices and middles of edges with their held components.
    fn sample(&self, numbering: &Numbering, mapping: &Mapping) -> Vec<(Vec3, [bool; 3])> {
        let mut points = Vec::new();
        let mut seen = vec![false; numbering.functions];
        for (e, functions) in numbering.of_element.iter().enumerate() {
            for (mode, function) in numbering.modes.iter().zip(functions) {
                let middles = mode.iter().filter(|&&k| k == 2).count();
                let Some(f) = *function else { continue };
                if mode.iter().all(|&k| k <= 2) && middles <= 1 && !seen[f] {
                    seen[f] = true;
                    let position = mapping.at(e, mode.map(|k| [-1.0, 1.0, 0.0][k])).position;
                    points.push((position, std::array::from_fn(|i| self.held[3 * f + i])));
                }
            }
        }
        points
    }
}

/// Modes that do not vanish on a face of the reference hexahedron.
pub fn modes_on_face(numbering: &Numbering, face: HexFace) -> impl Iterator<Item = usize> {
    let modes = &numbering.modes;
    (0..modes.len()).filter(move |&m| modes[m][face.axis as usize] == face.upper as usize)
}

/// The faces of a named surface of the mesh.
pub fn surface<'a>(mesh: &'a HexMesh, name: &str) -> Result<&'a [(usize, HexFace)], SolidError> {
    mesh.surfaces.get(name).map(Vec::as_slice).ok_or_else(|| {
        let known: Vec<&str> = mesh.surfaces.keys().map(String::as_str).collect();
        SolidError::Model(format!(
            "the mesh of the structure has no surface `{name}`; it has {}",
            known.join(", ")
        ))
    })
}

fn functions_on<'a>(
    mesh: &'a HexMesh,
    numbering: &'a Numbering,
    name: &str,
) -> Result<impl Iterator<Item = usize> + 'a, SolidError> {
    let faces = surface(mesh, name)?;
    Ok(faces.iter().flat_map(move |&(e, face)| {
        modes_on_face(numbering, face).filter_map(move |m| numbering.of_element[e][m])
    }))
}

/// Functions of the vertices, edges and faces that lie in a coordinate plane through the origin.
fn functions_in_plane(
    mesh: &HexMesh,
    numbering: &Numbering,
    mapping: &Mapping,
    axis: usize,
) -> Vec<usize> {
    let size = mesh.vertices.iter().map(|x| x.norm()).fold(0.0, f64::max);
    let mut functions = Vec::new();
    for e in 0..mesh.hexes.len() {
        let in_plane = |xi: [f64; 3]| mapping.at(e, xi).position[axis].abs() < 1e-9 * size;
        for (m, mode) in numbering.modes.iter().enumerate() {
            let high: Vec<usize> = (0..3).filter(|&d| mode[d] > 1).collect();
            if high.len() > 2 {
                continue;
            }
            // Vertices, and points inside edges and faces, of the part that the mode belongs to.
            let steps = 3usize.pow(high.len() as u32);
            let all = (0..steps).all(|step| {
                let mut xi = mode.map(|k| if k == 0 { -1.0 } else { 1.0 });
                for (place, &d) in high.iter().enumerate() {
                    xi[d] = [-1.0, 0.25, 1.0][step / 3usize.pow(place as u32) % 3];
                }
                in_plane(xi)
            });
            if all {
                functions.extend(numbering.of_element[e][m]);
            }
        }
    }
    functions.sort_unstable();
    functions.dedup();
    functions
}
