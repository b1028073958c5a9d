//! Potential flow in a lumen of any shape as surrogate, in the structure's own wall.
//!
//! Within a time step the blood answers to an acceleration of the wall, `x/dt²` where it has moved by `x`, by a
//! pressure whose Laplacian is zero (the added mass). Of pressures on the wall it knows some shapes `φ_i` (which add
//! up to 1 almost everywhere), and the wall's answer `A_i` to each:
//! ```text
//! P_j: ∇²P_j = 0,  ∂P_j/∂n = φ_j at the wall,  P_j = Z dt/rho q_j at an opening of impedance Z,  q_j = -∫∂P_j/∂n dS
//! p = -rho/dt² Σ_ij (M⁻¹ G M⁻¹)_ij w_j φ_i,   M_ij = ∮ φ_i φ_j dS,  G_ij = ∮ φ_i P_j dS,  w_j = ∮ φ_j x·n dS
//! x = residual + Σ_i A_i p_i
//! ```
//! Laplace's equation is solved by finite volumes in the cells of a mesh of the lumen at rest, once: impedances change
//! with the time (while their pressures are ramped) and with the length of the step. With the `Q_ej` that leave through
//! each opening `e` where all have the pressure zero, and `F_ef`, what a pressure of 1 at `f` alone draws in at `e`,
//! ```text
//! G = G(Z = 0) + Qᵀ ζ (1 + F ζ)⁻¹ Q,  ζ = Z dt/rho
//! ```
//! What the shapes do not express passes unchanged.

use crate::Vec3;
use crate::coupling::acceleration::Surrogate;
use crate::coupling::surrogate::shapes::PressureShapes;
use crate::geometry::PolyMesh;
use faer::linalg::solvers::Solve;
use faer::sparse::{SparseColMat, Triplet};
use nalgebra::{DMatrix, DVector};

/// Linear shapes at equal distances have eigenvalues of their scaled `M` between 0.5 and 1.5; those below this are of
/// combinations that the faces cannot tell from zero.
const LEAST_SHARE: f64 = 0.2;

/// Why there is no surrogate.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PotentialError {
    /// The pressure is not determined.
    #[error("no opening of the lumen determines the pressure")]
    Undetermined,
    /// Shapes of pressures that cannot be told apart on the mesh.
    #[error("the mesh of the lumen is too coarse for the surrogate")]
    Dependent,
}

/// Pressure over flow (Pa s/m³) within a step: from the time at which it ends, s, and displacement over velocity in it,
/// s.
pub type Impedance = Box<dyn Fn(f64, f64) -> f64 + Send>;

/// A pressure at an opening that answers to a flow.
pub struct PressureEnd {
    /// Patch of the mesh.
    pub patch: String,
    /// How it answers.
    pub impedance: Impedance,
}

/// The blood, for the surrogate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PotentialBlood {
    /// Density, kg/m³.
    pub density: f64,
    /// Displacement over velocity, and velocity over acceleration, of what happens within a time step, as a share of
    /// its length.
    pub share: f64,
}

/// The blood's answers where the openings have the pressure zero, and what pressures there add to them.
struct Responses {
    /// `G`, m³.
    at_wall: DMatrix<f64>,
    /// `Q`, m², a row for each opening.
    outflow: DMatrix<f64>,
    /// `F`, m.
    between: DMatrix<f64>,
}

/// The surrogate.
pub struct PotentialSurrogate {
    blood: PotentialBlood,
    impedances: Vec<Impedance>,
    /// With `M⁻¹ G M⁻¹` in place of `G`, and `Q M⁻¹` in place of `Q`.
    responses: Responses,
    /// From the displacement of all points (m) to `w`, m³.
    widening: DMatrix<f64>,
    /// The wall's answer to each shape, m/Pa.
    answers: DMatrix<f64>,
    /// `w` of these answers, m³/Pa.
    widened: DMatrix<f64>,
    /// From `w` to the pressures (Pa) that remove a residual, in a step like this; none if they are not determined.
    pressures: Option<DMatrix<f64>>,
    /// `ζ` of each opening, and `dt²/rho`, of that step.
    step: (DVector<f64>, f64),
}

impl PotentialSurrogate {
    /// Of a lumen at rest that is divided into the cells of `mesh`, with the wall on its `patches`; `wall` has the
    /// points (m) and faces whose displacement is coupled, `answers` (m/Pa) the displacement of these points by each
    /// shape. The first step has the length `step` (s).
    ///
    /// # Errors
    /// If no opening determines the pressure, or the shapes cannot be told apart.
    pub fn new(
        shapes: &dyn PressureShapes,
        (mesh, patches): (&PolyMesh, &[String]),
        ends: Vec<PressureEnd>,
        wall: (&[Vec3], &[Vec<u32>]),
        blood: PotentialBlood,
        answers: &[DVector<f64>],
        step: f64,
    ) -> Result<Self, PotentialError> {
        let widening = widening(shapes, wall);
        let (mass, found) = responses(shapes, mesh, patches, &ends)?;
        let inverse = inverse_of_what_is_told_apart(&mass, &shapes.one());
        let answers = DMatrix::from_columns(answers);
        let mut surrogate = Self {
            blood,
            impedances: ends.into_iter().map(|end| end.impedance).collect(),
            responses: Responses {
                at_wall: &inverse * found.at_wall * &inverse,
                outflow: found.outflow * inverse,
                between: found.between,
            },
            widened: &widening * &answers,
            widening,
            answers,
            pressures: None,
            step: (DVector::zeros(0), 0.0),
        };
        surrogate.begin_step(step, step);
        let found = surrogate.pressures.is_some();
        found.then_some(surrogate).ok_or(PotentialError::Dependent)
    }

    /// From `w` to the pressures (Pa) that remove a residual, with these `ζ` (m) of the openings and `dt²/rho`.
    fn pressures(&self, behind: &DVector<f64>, square: f64) -> Option<DMatrix<f64>> {
        let Responses {
            at_wall,
            outflow,
            between,
        } = &self.responses;
        let behind = DMatrix::from_diagonal(behind);
        let ends = DMatrix::identity(behind.nrows(), behind.nrows()) + between * &behind;
        let caused = at_wall + outflow.transpose() * behind * ends.lu().solve(outflow)?;
        let caused = -caused / square;
        let n = caused.nrows();
        let both = DMatrix::identity(n, n) - &caused * &self.widened;
        both.lu().solve(&caused)
    }
}

impl Surrogate for PotentialSurrogate {
    fn begin_step(&mut self, end: f64, length: f64) {
        let PotentialBlood { density, share } = self.blood;
        let time = share * length;
        let behind = |impedance: &Impedance| impedance(end, time) * time / density;
        let step = (
            DVector::from_iterator(self.impedances.len(), self.impedances.iter().map(behind)),
            time.powi(2) / density,
        );
        if step != self.step {
            self.pressures = self.pressures(&step.0, step.1);
            self.step = step;
        }
    }

    fn predict(&self, residual: &DVector<f64>) -> DVector<f64> {
        match &self.pressures {
            Some(pressures) => residual + &self.answers * (pressures * (&self.widening * residual)),
            None => residual.clone(),
        }
    }
}

/// `w` of each coordinate of each point.
fn widening(shapes: &dyn PressureShapes, (points, faces): (&[Vec3], &[Vec<u32>])) -> DMatrix<f64> {
    let mut widening = DMatrix::zeros(shapes.count(), 3 * points.len());
    for face in faces {
        let at = |i: usize| points[face[i % face.len()] as usize];
        let area: Vec3 = (0..face.len()).map(|i| 0.5 * at(i).cross(&at(i + 1))).sum();
        let share = 1.0 / face.len() as f64;
        let middle = (0..face.len()).map(at).sum::<Vec3>() * share;
        for (shape, value) in shapes.at(&middle, &area) {
            for point in face {
                for (k, component) in area.iter().enumerate() {
                    widening[(shape, 3 * *point as usize + k)] += value * share * component;
                }
            }
        }
    }
    widening
}

/// The inverse of `M` among combinations of shapes that its faces tell apart: where there are hardly more faces than
/// shapes, others would be guessed. Exact for the combination `one` that is 1 everywhere: by a pressure that is not
/// uniform where the blood's is, a wall would answer to what it hardly resists.
fn inverse_of_what_is_told_apart(mass: &DMatrix<f64>, one: &DVector<f64>) -> DMatrix<f64> {
    let own = mass.diagonal();
    let size = own.map(|own| if own > 0.0 { 1.0 / own.sqrt() } else { 0.0 });
    let size = DMatrix::from_diagonal(&size);
    let loads = mass * one;
    let whole = one.dot(&loads);
    if whole == 0.0 {
        // As many hats as faces, so that none reaches beyond its node: this surrogate knows no pressure.
        return mass.clone();
    }
    let rest = mass - &loads * loads.transpose() / whole;
    let mut eigen = (&size * rest * &size).symmetric_eigen();
    for value in eigen.eigenvalues.iter_mut() {
        *value = if *value < LEAST_SHARE {
            0.0
        } else {
            1.0 / *value
        };
    }
    let n = own.len();
    let without_one = DMatrix::identity(n, n) - one * loads.transpose() / whole;
    let inverse = &size * eigen.recompose() * &size;
    one * one.transpose() / whole + &without_one * inverse * without_one.transpose()
}

/// Laplace's operator by finite volumes: what flows out of each cell for a pressure of 1 in it and its neighbours.
fn fluxes(mesh: &PolyMesh, cells: &[(f64, Vec3)]) -> Vec<Triplet<usize, usize, f64>> {
    let mut entries = Vec::new();
    for (face, &neighbour) in mesh.neighbour.iter().enumerate() {
        let owner = mesh.owner[face];
        let (_, area) = mesh.face_geometry(face);
        let apart = cells[neighbour].1 - cells[owner].1;
        // Over-relaxed: as if the cells' centres lay across the face.
        let link = area.norm_squared() / area.dot(&apart).abs().max(f64::MIN_POSITIVE);
        for (i, j, value) in [
            (owner, owner, link),
            (neighbour, neighbour, link),
            (owner, neighbour, -link),
            (neighbour, owner, -link),
        ] {
            entries.push(Triplet::new(i, j, value));
        }
    }
    entries
}

/// The cells at the faces of an opening, with what flows out there for a pressure of 1 in them, m.
fn links(mesh: &PolyMesh, cells: &[(f64, Vec3)], end: &PressureEnd) -> Vec<(usize, f64)> {
    let Some(patch) = mesh.patch(&end.patch) else {
        return Vec::new();
    };
    let link = |face: usize| {
        let (centre, area) = mesh.face_geometry(face);
        let owner = mesh.owner[face];
        let distance = (centre - cells[owner].1).dot(&area).abs() / area.norm();
        (owner, area.norm() / distance)
    };
    (patch.start..patch.start + patch.size).map(link).collect()
}

/// `M`, and the blood's responses.
fn responses(
    shapes: &dyn PressureShapes,
    mesh: &PolyMesh,
    patches: &[String],
    ends: &[PressureEnd],
) -> Result<(DMatrix<f64>, Responses), PotentialError> {
    let n = shapes.count();
    let cells = mesh.cell_geometry();
    let mut entries = fluxes(mesh, &cells);
    // A column for each shape, then one for a pressure of 1 at each opening.
    let mut sources = faer::Mat::<f64>::zeros(cells.len(), n + ends.len());
    let mut mass = DMatrix::zeros(n, n);
    let mut wall = Vec::new();
    for patch in patches.iter().filter_map(|name| mesh.patch(name)) {
        for face in patch.start..patch.start + patch.size {
            let (centre, area) = mesh.face_geometry(face);
            let (owner, size) = (mesh.owner[face], area.norm());
            let distance = (centre - cells[owner].1).dot(&area) / size;
            let values = shapes.at(&centre, &area);
            for &(i, value) in &values {
                sources[(owner, i)] += value * size;
                for &(j, other) in &values {
                    mass[(i, j)] += value * other * size;
                }
            }
            wall.push((owner, size, distance, values));
        }
    }
    let links: Vec<_> = ends.iter().map(|end| links(mesh, &cells, end)).collect();
    for (e, links) in links.iter().enumerate() {
        for &(cell, link) in links {
            entries.push(Triplet::new(cell, cell, link));
            sources[(cell, n + e)] += link;
        }
    }
    if links.iter().all(Vec::is_empty) {
        return Err(PotentialError::Undetermined);
    }
    let matrix =
        SparseColMat::<usize, f64>::try_new_from_triplets(cells.len(), cells.len(), &entries);
    let factor = matrix
        .ok()
        .and_then(|matrix| matrix.sp_cholesky(faer::Side::Lower).ok());
    let factor = factor.ok_or(PotentialError::Undetermined)?;
    let potentials = factor.solve(&sources);
    let mut at_wall = DMatrix::zeros(n, n);
    for (owner, size, distance, values) in &wall {
        for &(i, value) in values {
            for j in 0..n {
                at_wall[(i, j)] += value * size * potentials[(*owner, j)];
            }
            // From the middle of the cell to the wall.
            for &(j, other) in values {
                at_wall[(i, j)] += value * size * distance * other;
            }
        }
    }
    let out = |e: usize, column: usize| -> f64 {
        let links = links[e].iter();
        links
            .map(|&(cell, link)| link * potentials[(cell, column)])
            .sum()
    };
    let own = |e: usize| links[e].iter().map(|(_, link)| link).sum::<f64>();
    let responses = Responses {
        at_wall,
        outflow: DMatrix::from_fn(ends.len(), n, out),
        between: DMatrix::from_fn(ends.len(), ends.len(), |e, f| {
            if e == f {
                own(e) - out(e, n + f)
            } else {
                -out(e, n + f)
            }
        }),
    };
    Ok((mass, responses))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coupling::surrogate::{BranchShapes, SurfaceShapes};
    use crate::curve::CentreLine;
    use crate::curve::SpaceCurve;
    use crate::geometry::tree::{Lumen, SectionGrid, Tree};
    use std::f64::consts::PI;

    const RADIUS: f64 = 5e-3;
    const LENGTH: f64 = 0.05;
    const STIFFNESS: f64 = 1.2e7;

    /// A tube that divides, whose wall answers point by point, along the radius.
    #[test]
    fn a_standing_wave_meets_the_added_mass_of_a_tube() {
        let names = ["inlet", "end"].map(String::from);
        let line = [Vec3::zeros(), Vec3::x() * 0.5 * LENGTH, Vec3::x() * LENGTH];
        let lumen = Lumen::new(vec![CentreLine::new(&line, &[RADIUS; 3])], None);
        let tree = Tree::new(lumen, SectionGrid::of_cells(6, 6, 1.0), 0.1).unwrap();
        let walls = vec!["wall".to_owned(); 1];
        let mesh = tree.mesh(&names, &walls, 1.0).unwrap();
        // Ramped over the first millisecond.
        let ends = |impedance: f64| -> Vec<PressureEnd> {
            let ends = names.iter().map(|patch| PressureEnd {
                patch: patch.clone(),
                impedance: Box::new(move |end, _| impedance * (end / 1e-3)),
            });
            ends.collect()
        };
        let lines: Vec<SpaceCurve> = tree.lines().into_iter().map(|(_, line)| line).collect();
        let along = BranchShapes::along(&lines, LENGTH / 50.0, 1e-6, 0);
        assert_eq!(along.count(), 51);
        let patch = mesh.patch("wall").unwrap();
        let wall = patch.start..patch.start + patch.size;
        let wall: Vec<_> = wall.map(|face| mesh.face_geometry(face)).collect();
        let on = SurfaceShapes::on(&wall, 200);
        assert_eq!(on.count(), 200);
        let mut numbers = std::collections::BTreeMap::new();
        let mut points: Vec<Vec3> = Vec::new();
        let faces: Vec<Vec<u32>> = (mesh.patch_faces("wall").iter())
            .map(|face| {
                let number = |p: &usize| {
                    *numbers.entry(*p).or_insert_with(|| {
                        points.push(mesh.points[*p]);
                        points.len() as u32 - 1
                    })
                };
                face.iter().map(number).collect()
            })
            .collect();
        let radial = |x: &Vec3| Vec3::new(0.0, x.y, x.z) / RADIUS;
        let field = |size: &dyn Fn(&Vec3) -> f64| {
            let all = points.iter().flat_map(|x| (size(x) * radial(x)).data.0[0]);
            DVector::from_iterator(3 * points.len(), all)
        };
        let blood = PotentialBlood {
            density: 1000.0,
            share: 1.0,
        };
        let of_wall = (&points[..], &faces[..]);
        let mesh = (&mesh, &walls[..]);
        let surrogate = |shapes: &dyn PressureShapes, ends: Vec<PressureEnd>| {
            let answer = |i: usize| {
                field(&|x| {
                    let mut values = shapes.at(x, &radial(x)).into_iter();
                    let value = values.find(|(shape, _)| *shape == i);
                    value.map_or(0.0, |(_, value)| value / STIFFNESS)
                })
            };
            let answers: Vec<_> = (0..shapes.count()).map(answer).collect();
            PotentialSurrogate::new(shapes, mesh, ends, of_wall, blood, &answers, 1e-3)
        };
        let all: [(&dyn PressureShapes, usize, f64); 2] = [(&along, 3, 2e-3), (&on, 2, 0.01)];
        for (shapes, waves, tolerance) in all {
            let surrogate = surrogate(shapes, ends(0.0)).unwrap();
            // rho I0(kr)/(k I1(kr)): kr = 0.314159, 1.256637, 2.513274
            let waves = &[(1.0, 6.444_4), (4.0, 1.886_9), (8.0, 1.304_7)][..waves];
            for (half_waves, bessel) in waves {
                let k = half_waves * PI / LENGTH;
                let expected = 1.0 / (1.0 + 1000.0 * bessel / k / 1e-6 / STIFFNESS);
                let wave = field(&|x| (k * x.x).sin());
                let left = surrogate.predict(&wave);
                let share = left.dot(&wave) / wave.norm_squared();
                assert!(
                    (share / expected - 1.0).abs() < tolerance,
                    "{half_waves}: {share} {expected}"
                );
            }
        }
        // Between resistances that keep the blood in, the vessel widens in all by what it takes to raise the pressure
        // by Z/2 dV/dt, wherever that is.
        for shapes in [&along as &dyn PressureShapes, &on] {
            let mut surrogate = surrogate(shapes, ends(1e11)).unwrap();
            let widened = field(&|_| 1.0);
            for (end, length) in [(1e-3, 1e-3), (5e-4, 1e-3), (1e-3, 5e-4)] {
                surrogate.begin_step(end, length);
                let left = (&surrogate.widening * surrogate.predict(&widened)).sum();
                let raised = 1e11 * (end / 1e-3) * 0.5 * left / length / STIFFNESS;
                assert!((raised - 1.0).abs() < 3e-3, "{raised}");
            }
        }
        let closed = surrogate(&along, Vec::new());
        assert_eq!(closed.err(), Some(PotentialError::Undetermined));
    }
}
