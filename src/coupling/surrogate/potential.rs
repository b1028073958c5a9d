//! Potential flow in a lumen of any shape as surrogate, in the structure's own wall.
//!
//! Within a time step the blood answers to an acceleration of the wall, `x/dt²` where it has moved by `x`, by a
//! pressure whose Laplacian is zero (the added mass). Of pressures on the wall it knows some shapes `φ_i` (which add
//! up to 1 almost everywhere), and the wall's answer `A_i` to each:
//! ```text
//! P_j: ∇²P_j = 0,  ∂P_j/∂n = φ_j at the wall,  P_j = -Z dt/rho ∫∂P_j/∂n dS at an opening of impedance Z
//! p = -rho/dt² Σ_ij (M⁻¹ G M⁻¹)_ij w_j φ_i,   M_ij = ∮ φ_i φ_j dS,  G_ij = ∮ φ_i P_j dS,  w_j = ∮ φ_j x·n dS
//! x = residual + Σ_i A_i p_i
//! ```
//! Laplace's equation is solved by finite volumes in the cells of a mesh of the lumen at rest. What the shapes do
//! not express passes unchanged.

use crate::Vec3;
use crate::coupling::acceleration::Surrogate;
use crate::curve::SpaceCurve;
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

/// A pressure at an opening that answers to a flow.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureEnd {
    /// Patch of the mesh.
    pub patch: String,
    /// Pressure over flow within a time step, Pa s/m³.
    pub impedance: f64,
}

/// The blood, for the surrogate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PotentialBlood {
    /// Density, kg/m³.
    pub density: f64,
    /// Displacement over velocity, and velocity over acceleration, of what happens within a time step, s.
    pub time_step: f64,
}

/// A node along a branch.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    /// Arc length, m.
    s: f64,
    /// Number of the shape that is 1 there and the same all around; nodes of several branches at a junction share it,
    /// and open ends have none.
    whole: Option<usize>,
    /// Number of the node for waves around the circumference; likewise, but junctions have one for each branch.
    own: Option<usize>,
}

/// Shapes of pressures on the walls of branches: along each centre-line they are linear from node to node; around it
/// they are waves: 1, and for each number of periods cosine and sine.
#[derive(Debug, Clone)]
pub struct PressureShapes {
    lines: Vec<(SpaceCurve, Vec<Node>)>,
    whole: usize,
    /// Positions (m) of the nodes that waves have.
    own: Vec<Vec3>,
    periods: usize,
}

impl PressureShapes {
    /// Nodes at distances of about `spacing` (m) along branches; where ends of lines are nearer to each other than
    /// `near` (m), they are one node. Waves have up to so many `periods`.
    pub fn along(lines: &[SpaceCurve], spacing: f64, near: f64, periods: usize) -> Self {
        let ends: Vec<Vec3> = (lines.iter())
            .flat_map(|line| line.ends().map(|s| line.frame(s).origin))
            .collect();
        let junction = |x: &Vec3| {
            let mut all = (0..ends.len()).filter(|i| (ends[*i] - x).norm() < near);
            let first = all.next();
            all.next().and(first)
        };
        let mut numbers = vec![None; ends.len()];
        let mut shapes = Self {
            lines: Vec::new(),
            whole: 0,
            own: Vec::new(),
            periods,
        };
        for line in lines {
            let mut nodes = Vec::new();
            for (s, is_end) in places(line, spacing, |s| {
                junction(&line.frame(s).origin).map_or(spacing, |_| spacing.max(near))
            }) {
                let at = line.frame(s).origin;
                let junction = junction(&at).filter(|_| is_end);
                let (whole, own) = match (is_end, junction) {
                    (true, None) => (None, None),
                    (_, junction) => {
                        let known = junction.and_then(|end| numbers[end]);
                        let number = known.unwrap_or(shapes.whole);
                        shapes.whole = shapes.whole.max(number + 1);
                        if let Some(end) = junction {
                            numbers[end] = Some(number);
                        }
                        shapes.own.push(at);
                        (Some(number), Some(shapes.own.len() - 1))
                    }
                };
                nodes.push(Node { s, whole, own });
            }
            shapes.lines.push((line.clone(), nodes));
        }
        shapes
    }

    /// Number of shapes.
    pub fn count(&self) -> usize {
        self.whole + 2 * self.periods * self.own.len()
    }

    /// Number of shapes that are the same all around; they come first.
    pub fn whole(&self) -> usize {
        self.whole
    }

    /// Positions (m) of the nodes that waves have.
    pub fn nodes(&self) -> &[Vec3] {
        &self.own
    }

    /// The shape of a wave at a node: waves 0 and 1 are cosine and sine of one period, 2 and 3 of two, …
    pub fn wave(&self, wave: usize, node: usize) -> usize {
        self.whole + wave * self.own.len() + node
    }

    /// The shapes that are not zero at `x` (m), with their values.
    pub fn at(&self, x: &Vec3) -> Vec<(usize, f64)> {
        let places = self.lines.iter().map(|(line, nodes)| {
            let (nearest, [from, to]) = (line.nearest(x), line.ends());
            // Not from where the line would go on.
            let on_line = line.frame(nearest.s.clamp(from, to)).origin;
            ((on_line - x).norm(), nearest, nodes)
        });
        let Some((_, nearest, nodes)) = places.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return Vec::new();
        };
        let s = nearest.s;
        let after = nodes
            .partition_point(|node| node.s < s)
            .clamp(1, nodes.len() - 1);
        let (before, after) = (nodes[after - 1], nodes[after]);
        let share = ((s - before.s) / (after.s - before.s)).clamp(0.0, 1.0);
        let angle = nearest.across[1].atan2(nearest.across[0]);
        let mut found = Vec::new();
        for (node, value) in [(before, 1.0 - share), (after, share)] {
            found.extend(node.whole.map(|number| (number, value)));
            for period in 1..=self.periods {
                let (sine, cosine) = (period as f64 * angle).sin_cos();
                let number = |wave: usize| Some(self.wave(2 * (period - 1) + wave, node.own?));
                found.extend(number(0).map(|number| (number, value * cosine)));
                found.extend(number(1).map(|number| (number, value * sine)));
            }
        }
        found
    }

    /// Groups of nodes that are further apart than `apart` (m) from each other.
    pub fn groups(&self, apart: f64) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (node, x) in self.own.iter().enumerate() {
            let is_far = |other: &usize| (self.own[*other] - x).norm() > apart;
            match groups.iter_mut().find(|group| group.iter().all(is_far)) {
                Some(group) => group.push(node),
                None => groups.push(vec![node]),
            }
        }
        groups
    }
}

/// Arc lengths (m) of the nodes of a line, and whether it ends there: the first and the last one between lie as far
/// from the ends as `first` says, since near a junction most of the wall is nearer to other lines.
fn places(line: &SpaceCurve, spacing: f64, first: impl Fn(f64) -> f64) -> Vec<(f64, bool)> {
    let [from, to] = line.ends();
    let (begin, end) = (from + first(from), to - first(to));
    let pieces = ((end - begin) / spacing).round().max(1.0) as usize;
    let between = (0..=pieces).map(|i| (begin + (end - begin) * i as f64 / pieces as f64, false));
    let between = between.filter(|(s, _)| from < *s && *s < to);
    [(from, true)]
        .into_iter()
        .chain(between)
        .chain([(to, true)])
        .collect()
}

/// The surrogate.
pub struct PotentialSurrogate {
    /// From the displacement of all points (m) to `w`, m³.
    widening: DMatrix<f64>,
    /// From there to the pressures (Pa) that remove a residual.
    pressures: DMatrix<f64>,
    /// The wall's answer to each shape, m/Pa.
    answers: DMatrix<f64>,
}

impl PotentialSurrogate {
    /// Of a lumen at rest that is divided into the cells of `mesh`, with the wall on its `patches`; `wall` has the
    /// points (m) and faces whose displacement is coupled, `answers` (m/Pa) the displacement of these points by each
    /// shape.
    ///
    /// # Errors
    /// If no opening determines the pressure.
    pub fn new(
        shapes: &PressureShapes,
        (mesh, patches): (&PolyMesh, &[String]),
        ends: &[PressureEnd],
        wall: (&[Vec3], &[Vec<u32>]),
        blood: PotentialBlood,
        answers: &[DVector<f64>],
    ) -> Result<Self, PotentialError> {
        let n = shapes.count();
        let widening = widening(shapes, wall);
        let (mass, response) = responses(shapes, mesh, patches, ends, blood)?;
        let inverse = inverse_of_what_is_told_apart(&mass);
        let factor = -blood.density / blood.time_step.powi(2);
        let caused = &inverse * response * &inverse * factor;
        let answers = DMatrix::from_columns(answers);
        let both = DMatrix::identity(n, n) - &caused * &widening * &answers;
        let pressures = both.lu().solve(&caused).ok_or(PotentialError::Dependent)?;
        Ok(Self {
            widening,
            pressures,
            answers,
        })
    }
}

impl Surrogate for PotentialSurrogate {
    fn predict(&self, residual: &DVector<f64>) -> DVector<f64> {
        residual + &self.answers * (&self.pressures * (&self.widening * residual))
    }
}

/// `w` of each coordinate of each point.
fn widening(shapes: &PressureShapes, (points, faces): (&[Vec3], &[Vec<u32>])) -> DMatrix<f64> {
    let mut widening = DMatrix::zeros(shapes.count(), 3 * points.len());
    for face in faces {
        let at = |i: usize| points[face[i % face.len()] as usize];
        let area: Vec3 = (0..face.len()).map(|i| 0.5 * at(i).cross(&at(i + 1))).sum();
        let share = 1.0 / face.len() as f64;
        let middle = (0..face.len()).map(at).sum::<Vec3>() * share;
        for (shape, value) in shapes.at(&middle) {
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
/// shapes, others would be guessed.
fn inverse_of_what_is_told_apart(mass: &DMatrix<f64>) -> DMatrix<f64> {
    let size = mass
        .diagonal()
        .map(|own| 1.0 / own.max(f64::MIN_POSITIVE).sqrt());
    let size = DMatrix::from_diagonal(&size.map(|size| if size < 1e100 { size } else { 0.0 }));
    let mut eigen = (&size * mass * &size).symmetric_eigen();
    for value in eigen.eigenvalues.iter_mut() {
        *value = if *value < LEAST_SHARE {
            0.0
        } else {
            1.0 / *value
        };
    }
    &size * eigen.recompose() * &size
}

/// Laplace's operator by finite volumes: what flows out of each cell for a pressure of 1 in it and its neighbours, and
/// through the openings.
fn fluxes(
    mesh: &PolyMesh,
    cells: &[(f64, Vec3)],
    ends: &[PressureEnd],
    blood: PotentialBlood,
) -> Result<Vec<Triplet<usize, usize, f64>>, PotentialError> {
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
    let mut is_determined = false;
    for end in ends {
        let Some(patch) = mesh.patch(&end.patch) else {
            continue;
        };
        let faces: Vec<(usize, Vec3, Vec3)> = (patch.start..patch.start + patch.size)
            .map(|face| {
                let (centre, area) = mesh.face_geometry(face);
                (mesh.owner[face], centre, area)
            })
            .collect();
        let whole: f64 = faces.iter().map(|(_, _, area)| area.norm()).sum();
        for (owner, centre, area) in faces {
            let size = area.norm();
            let distance = (centre - cells[owner].1).dot(&area).abs() / size;
            let behind = end.impedance * blood.time_step / blood.density * whole;
            entries.push(Triplet::new(owner, owner, size / (distance + behind)));
            is_determined = true;
        }
    }
    if !is_determined {
        return Err(PotentialError::Undetermined);
    }
    Ok(entries)
}

/// `M` and `G`.
fn responses(
    shapes: &PressureShapes,
    mesh: &PolyMesh,
    patches: &[String],
    ends: &[PressureEnd],
    blood: PotentialBlood,
) -> Result<(DMatrix<f64>, DMatrix<f64>), PotentialError> {
    let n = shapes.count();
    let cells = mesh.cell_geometry();
    let entries = fluxes(mesh, &cells, ends, blood)?;
    let mut sources = faer::Mat::<f64>::zeros(cells.len(), n);
    let mut mass = DMatrix::zeros(n, n);
    let mut wall = Vec::new();
    for patch in patches.iter().filter_map(|name| mesh.patch(name)) {
        for face in patch.start..patch.start + patch.size {
            let (centre, area) = mesh.face_geometry(face);
            let (owner, size) = (mesh.owner[face], area.norm());
            let distance = (centre - cells[owner].1).dot(&area) / size;
            let values = shapes.at(&centre);
            for &(i, value) in &values {
                sources[(owner, i)] += value * size;
                for &(j, other) in &values {
                    mass[(i, j)] += value * other * size;
                }
            }
            wall.push((owner, size, distance, values));
        }
    }
    let matrix =
        SparseColMat::<usize, f64>::try_new_from_triplets(cells.len(), cells.len(), &entries);
    let factor = matrix
        .ok()
        .and_then(|matrix| matrix.sp_cholesky(faer::Side::Lower).ok());
    let factor = factor.ok_or(PotentialError::Undetermined)?;
    let potentials = factor.solve(&sources);
    let mut response = DMatrix::zeros(n, n);
    for (owner, size, distance, values) in &wall {
        for &(i, value) in values {
            for j in 0..n {
                response[(i, j)] += value * size * potentials[(*owner, j)];
            }
            // From the middle of the cell to the wall.
            for &(j, other) in values {
                response[(i, j)] += value * size * distance * other;
            }
        }
    }
    Ok((mass, response))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tree::{CentreLine, Lumen, SectionGrid, Tree};
    use std::f64::consts::PI;

    const RADIUS: f64 = 5e-3;
    const LENGTH: f64 = 0.05;
    const STIFFNESS: f64 = 1.2e7;

    /// A tube that divides, whose wall answers point by point, along the radius.
    #[test]
    fn a_standing_wave_meets_the_added_mass_of_a_tube() {
        let names = ["inlet", "end"].map(String::from);
        let line = [Vec3::zeros(), Vec3::x() * 0.5 * LENGTH, Vec3::x() * LENGTH];
        let lumen = Lumen {
            lines: vec![CentreLine::new(&line, &[RADIUS; 3])],
            surface: None,
        };
        let tree = Tree::new(lumen, SectionGrid::of_cells(6, 6, 1.0), 0.1).unwrap();
        let walls = vec!["wall".to_owned(); 1];
        let mesh = tree.mesh(&names, &walls, 1.0).unwrap();
        let ends = names.map(|patch| PressureEnd {
            patch,
            impedance: 0.0,
        });
        let lines: Vec<SpaceCurve> = tree.lines().into_iter().map(|(_, line)| line).collect();
        let shapes = PressureShapes::along(&lines, LENGTH / 50.0, 1e-6, 0);
        assert_eq!(shapes.count(), 49);
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
        let answers: Vec<DVector<f64>> = (0..shapes.count())
            .map(|i| {
                field(&|x| {
                    let value = shapes.at(x).into_iter().find(|(shape, _)| *shape == i);
                    value.map_or(0.0, |(_, value)| value / STIFFNESS)
                })
            })
            .collect();
        let blood = PotentialBlood {
            density: 1000.0,
            time_step: 1e-3,
        };
        let of_wall = (&points[..], &faces[..]);
        let mesh = (&mesh, &walls[..]);
        let surrogate =
            PotentialSurrogate::new(&shapes, mesh, &ends, of_wall, blood, &answers).unwrap();
        // rho I0(kr)/(k I1(kr)): kr = 0.314159, 1.256637, 2.513274
        for (half_waves, bessel) in [(1.0, 6.444_4), (4.0, 1.886_9), (8.0, 1.304_7)] {
            let k = half_waves * PI / LENGTH;
            let expected = 1.0 / (1.0 + 1000.0 * bessel / k / 1e-6 / STIFFNESS);
            let wave = field(&|x| (k * x.x).sin());
            let left = surrogate.predict(&wave);
            let share = left.dot(&wave) / wave.norm_squared();
            assert!(
                (share / expected - 1.0).abs() < 0.04,
                "{half_waves}: {share} {expected}"
            );
        }
        let closed = PotentialSurrogate::new(&shapes, mesh, &[], of_wall, blood, &answers);
        assert_eq!(closed.err(), Some(PotentialError::Undetermined));
    }
}
