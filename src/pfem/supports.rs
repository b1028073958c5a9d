//! Which degrees of freedom are held, and whether that is enough.

use super::SolidError;
use super::element::mapping::Mapping;
use super::space::numbering::Numbering;
use crate::Vec3;
use crate::geometry::{HexFace, HexMesh};

/// Components of displacement that are held at all functions of a body.
#[derive(Debug, Clone)]
pub struct Supports {
    held: Vec<bool>,
}

/// Something that holds a part of the body; see the variants.
#[derive(Debug, Clone, PartialEq)]
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
            }
        }
        Ok(Self { held })
    }

    /// `held[3 f + i]`: whether component `i` of function `f` is held.
    pub fn held(&self) -> &[bool] {
        &self.held
    }

    /// An error that names a rigid motion which the supports leave possible, if there is one.
    pub fn check_rigid_motions(
        &self,
        numbering: &Numbering,
        mapping: &Mapping,
    ) -> Result<(), SolidError> {
        let points: Vec<(Vec3, [bool; 3])> = self.sample(numbering, mapping);
        let centre: Vec3 = points.iter().map(|(x, _)| x).sum::<Vec3>() / points.len() as f64;
        let size = points
            .iter()
            .map(|(x, _)| (x - centre).norm())
            .fold(0.0, f64::max);
        let mut gram = nalgebra::Matrix6::<f64>::zeros();
        for (x, held) in &points {
            for i in (0..3).filter(|&i| held[i]) {
                let mut row = nalgebra::Vector6::zeros();
                row[i] = 1.0;
                for k in 0..3 {
                    row[3 + k] = Vec3::ith(k, 1.0).cross(&((x - centre) / size))[i];
                }
                gram += row * row.transpose();
            }
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
