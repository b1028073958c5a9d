//! The surrogate of a case, with the structure's compliance: a tube, or potential flow in the cells of any mesh.

use super::Domain;
use super::domain::own;
use crate::Vec3;
use crate::case::{
    BloodVessel, Case, FluidTimeScheme, Opening, PressureModel, Problem, Ramp, Solver,
    SurrogateModel, TableError, VesselSide,
};
use crate::coupling::acceleration::{Identity, Surrogate};
use crate::coupling::flatten;
use crate::coupling::surrogate::{
    Axis, BranchShapes, Comb, NoRings, PotentialBlood, PotentialError, PotentialSurrogate,
    PressureEnd, PressureShapes, StationOptions, Stations, SurfaceShapes, SurrogateBlood,
    SurrogateWall, TubeEnd, TubePlace, TubeSurrogate,
};
use crate::coupling::transfer::Transfer;
use crate::curve::SpaceCurve;
use crate::fluid::FluidInterface;
use crate::geometry::{PolyMesh, Vessel};
use crate::pfem::solution::listener::{self, Work};
use crate::pfem::{Solid, SolidError, SurfaceLoad};
use nalgebra::DVector;
use std::f64::consts::PI;
use std::ops::Range;

/// Pressure (Pa) that probes the wall without load: so small that one tangent serves for all stations.
const PROBE: f64 = 1.0;
/// Share of the pressure in a loaded wall that probes it: likewise, and above the rounding errors of what it adds to.
const SHARE: f64 = 1e-3;
/// Relative residual of the answers: a surrogate need not be accurate.
const PROBE_TOLERANCE: f64 = 1e-3;
/// Most stations between the ends: each costs a solution of the structure.
const MOST_STATIONS: usize = 63;
/// Shapes of pressures along branches are at least so many radii apart: shorter waves hardly disturb the iteration.
const LEAST_SPACING: f64 = 0.5;
/// Patch of a flag's channel where the pressure is given.
const FLAG_OUTLET: &str = "outlet";
/// Most periods of a wave around the branches of a tree.
const MOST_TREE_PERIODS: usize = 2;
/// Most periods of a wave around the circumference.
const MOST_PERIODS: usize = 8;
/// Waves are left out from that number of periods on where the blood's added mass is below this share of what the wall
/// sets against it: they hardly disturb the iteration.
const LEAST_ADDED_MASS: f64 = 0.2;
/// The wall's answer to such waves is felt up to half so many radii from where they press.
const FELT: f64 = 2.0;

/// What the user is told of it.
const TOLD: &str = "trying the wall for the surrogate";

/// Why a case has no surrogate.
#[derive(Debug, thiserror::Error)]
pub enum SurrogateError {
    /// It is not that of a vessel.
    #[error("the surrogate is a tube, and the case has none")]
    NoTube,
    /// A curve of flow or pressure cannot be read.
    #[error(transparent)]
    Curve(#[from] TableError),
    /// The wall does not lie in rings.
    #[error(transparent)]
    Rings(#[from] NoRings),
    /// The pressure is not determined.
    #[error(transparent)]
    Potential(#[from] PotentialError),
    /// The wall gives no answer.
    #[error(transparent)]
    Wall(#[from] SolidError),
}

/// The surrogate that the case asks for. Its wall is what `solid`, which is at rest under a `pressure` (Pa), answers to
/// a little more within a time step.
pub fn surrogate<S: Solid>(
    case: &Case,
    domain: &Domain,
    interface: &FluidInterface,
    solid: &mut S,
    transfer: &Transfer<S::Location>,
    pressure: f64,
) -> Result<Box<dyn Surrogate>, SurrogateError> {
    let model = case.coupling.surrogate;
    let (false, true) = (model == SurrogateModel::None, case.has_elastic_wall()) else {
        return Ok(Box::new(Identity));
    };
    let Problem::Vessel(vessel) = &case.problem else {
        return match model {
            SurrogateModel::Potential => potential(case, domain, interface, solid, transfer),
            _ => Err(SurrogateError::NoTube),
        };
    };
    let geometry = Vessel::new(vessel);
    let [first, last] = [0, geometry.sections().len() - 1].map(|i| &geometry.sections()[i]);
    let [upstream, downstream] = [-first.from, last.to - geometry.end()];
    let open = |rigid_length| TubeEnd::Pressure { rigid_length };
    let (inlet, outlet) = match model {
        SurrogateModel::None | SurrogateModel::Potential => return Ok(Box::new(Identity)),
        SurrogateModel::Tube => ends(vessel, case.time.period, upstream, downstream)?,
        SurrogateModel::OpenTube => (open(upstream), open(downstream)),
    };
    let stations = stations(vessel, case.fluid.solver, &interface.points)?;

    let mut wall = WallAnswers::new(case, solid, transfer, pressure, stations.count());
    let rest = wall.rest.clone();
    let wet = wall.solid.wet_points().iter();
    let places: Vec<TubePlace> = wet.map(|point| stations.place(&point.position)).collect();
    let mut answer = |shape: &dyn Fn(TubePlace) -> f64| {
        wall.to(&places.iter().map(|place| shape(*place)).collect::<Vec<_>>())
    };
    let blood = SurrogateBlood {
        density: case.blood.density,
        viscosity: case.blood.viscosity,
        time_step: time_step(case),
        radial_inertia: true,
    };

    let to_waves = waves(&stations, &blood, &mut answer)?;
    let stations = stations.with_periods(to_waves.len() / 2);
    let answers: Result<Vec<_>, SurrogateError> = (0..stations.count())
        .map(|station| answer(&|x| stations.share(station, x)))
        .collect();
    let mut surrogate = TubeSurrogate::new(stations, &answers?, to_waves, blood, inlet, outlet);
    // The blood of the initial state.
    surrogate.finish_step(&rest);
    Ok(Box::new(surrogate))
}

/// Displacement over velocity, and velocity over acceleration, of what happens within a time step, s.
fn time_step(case: &Case) -> f64 {
    match case.time.scheme {
        FluidTimeScheme::ImplicitEuler => case.time.step,
        FluidTimeScheme::Bdf2 => case.time.step / 1.5,
    }
}

/// A wall at rest under a pressure, which is asked what a little more does to it within a time step.
struct WallAnswers<'a, S: Solid> {
    solid: &'a mut S,
    transfer: &'a Transfer<S::Location>,
    /// Displacement of all points at rest, m.
    rest: DVector<f64>,
    pressure: f64,
    /// The pressure more, Pa.
    probe: f64,
    time_step: f64,
    tolerance: f64,
    /// How many questions were asked, and how many will be.
    asked: usize,
    expected: usize,
    _work: Work,
}

impl<'a, S: Solid> WallAnswers<'a, S> {
    /// For so many questions.
    fn new(
        case: &Case,
        solid: &'a mut S,
        transfer: &'a Transfer<S::Location>,
        pressure: f64,
        questions: usize,
    ) -> Self {
        Self {
            rest: flatten(&transfer.accepted_displacement(solid)),
            probe: PROBE.max(SHARE * pressure.abs()),
            // The residual is measured against the whole load.
            tolerance: match pressure {
                0.0 => PROBE_TOLERANCE,
                _ => PROBE_TOLERANCE * SHARE / (questions as f64).sqrt(),
            },
            time_step: case.time.step,
            solid,
            transfer,
            pressure,
            asked: 0,
            expected: questions,
            _work: Work::begin(TOLD),
        }
    }

    /// The displacement (m/Pa) by a pressure of this shape at the wet points.
    fn to(&mut self, shape: &[f64]) -> Result<DVector<f64>, SurrogateError> {
        Ok((self.displacement(shape)? - &self.rest) / self.probe)
    }

    /// The answers to each of `shapes` at the wet points, where all of them are `at`.
    fn answers(
        &mut self,
        at: &[Vec<(usize, f64)>],
        shapes: Range<usize>,
    ) -> Result<Vec<DVector<f64>>, SurrogateError> {
        shapes
            .map(|shape| self.to(&sum(at, |number| number == shape)))
            .collect()
    }

    /// The displacement (m) of all points under the pressure with so much more of this shape.
    fn displacement(&mut self, shape: &[f64]) -> Result<DVector<f64>, SurrogateError> {
        let more = shape.iter().map(|share| self.pressure + self.probe * share);
        let load = SurfaceLoad {
            pressure: more.collect(),
            shear: vec![Vec3::zeros(); shape.len()],
        };
        let trial = (self.solid).solve(&load, self.time_step, self.tolerance, None)?;
        self.asked += 1;
        if self.asked < self.expected {
            listener::tell(TOLD, self.asked as f64 / self.expected as f64);
        }
        Ok(flatten(&self.transfer.displacement(self.solid, &trial)))
    }
}

/// The part of an `answer` (m/Pa) to all nodes of a group at once that is due to one of them: at the `points` (m) to
/// which it is the nearest.
fn next_to(
    answer: &DVector<f64>,
    node: usize,
    group: &[usize],
    shapes: &BranchShapes,
    points: &[Vec3],
) -> DVector<f64> {
    let far = |node: usize, x: &Vec3| (shapes.nodes()[node] - x).norm_squared();
    let mut own = answer.clone();
    for (i, x) in points.iter().enumerate() {
        if group.iter().any(|other| far(*other, x) < far(node, x)) {
            own.rows_mut(3 * i, 3).fill(0.0);
        }
    }
    own
}

/// The sum of some of the shapes `at` the wet points.
fn sum(at: &[Vec<(usize, f64)>], is_wanted: impl Fn(usize) -> bool) -> Vec<f64> {
    let of_point = |values: &Vec<(usize, f64)>| {
        let wanted = values.iter().filter(|(number, _)| is_wanted(*number));
        wanted.map(|(_, value)| value).sum()
    };
    at.iter().map(of_point).collect()
}

/// What the wall answers (m/Pa, at these `points`) to each shape, where all of them are `at` the wet points; to waves
/// of nodes that are further apart than `felt` (m) at once.
fn answers_along_branches<S: Solid>(
    wall: &mut WallAnswers<'_, S>,
    shapes: &BranchShapes,
    at: &[Vec<(usize, f64)>],
    felt: f64,
    points: &[Vec3],
) -> Result<Vec<DVector<f64>>, SurrogateError> {
    let groups = shapes.groups(felt);
    wall.expected = 1 + shapes.whole() + 2 * MOST_TREE_PERIODS * groups.len();
    let mut answers = wall.answers(at, 0..shapes.whole())?;
    for wave in 0..2 * MOST_TREE_PERIODS {
        let first = shapes.wave(wave, 0);
        let mut of_nodes = vec![DVector::zeros(0); shapes.nodes().len()];
        for group in &groups {
            let is_of_group = |number: usize| number >= first && group.contains(&(number - first));
            let answer = wall.to(&sum(at, is_of_group))?;
            for &node in group {
                of_nodes[node] = next_to(&answer, node, group, shapes, points);
            }
        }
        answers.extend(of_nodes);
    }
    Ok(answers)
}

/// Where the pressure of the blood is given or answers to its flow.
fn pressure_ends(case: &Case, domain: &Domain) -> Result<Vec<PressureEnd>, SurrogateError> {
    let end = |patch: String, proximal: f64, distal: Option<(f64, f64)>, ramp: Ramp| PressureEnd {
        patch,
        impedance: Box::new(move |end, step| {
            let distal = distal.map_or(0.0, |(resistance, compliance)| {
                1.0 / (compliance / step + 1.0 / resistance)
            });
            ramp.factor(end) * (proximal + distal)
        }),
    };
    let none = Ramp { duration: 0.0 };
    Ok(match &case.problem {
        Problem::UserCase(own) if case.has_own_openfoam() => {
            let ends = own::files(case, own).pressures(&domain.fluid).into_iter();
            let ends = ends.map(|(patch, windkessel)| match windkessel {
                Some([proximal, resistance, compliance]) => end(
                    patch,
                    proximal,
                    Some((resistance, compliance)),
                    none.clone(),
                ),
                None => end(patch, 0.0, None, none.clone()),
            });
            ends.collect()
        }
        _ => match case.tree() {
            Some(tree) => {
                let openings = tree.openings(case.time.period)?.into_iter();
                let ends = openings.filter_map(|opening: Opening| {
                    let model = opening.condition.pressure()?;
                    // At the ends of a wall in equilibrium the whole pressure acts from the beginning.
                    let is_whole = case.initial_wall().is_some() && opening.end == VesselSide::End;
                    let ramp = if is_whole { &none } else { &case.ramp };
                    Some(end(
                        opening.name.clone(),
                        model.proximal,
                        model.distal,
                        ramp.clone(),
                    ))
                });
                ends.collect()
            }
            None => vec![end(FLAG_OUTLET.into(), 0.0, None, none)],
        },
    })
}

/// How far a face of the wall reaches along the branches, mean of all, m.
fn face_length(lines: &[SpaceCurve], mesh: &PolyMesh, wall: &[String]) -> f64 {
    let faces = wall.iter().flat_map(|patch| mesh.patch_faces(patch));
    let (mut sum, mut count) = (0.0, 0.0);
    for face in faces {
        let corners = face.iter().map(|&point| mesh.points[point]);
        let middle = corners.clone().sum::<Vec3>() / face.len() as f64;
        let nearest = lines.iter().map(|line| {
            let frame = line.frame(line.nearest(&middle).s);
            ((frame.origin - middle).norm(), frame.tangent)
        });
        let Some((_, tangent)) = nearest.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            continue;
        };
        let along = corners.map(|x| tangent.dot(&x));
        let [low, high] = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
            [low.min(x), high.max(x)]
        });
        sum += high - low;
        count += 1.0;
    }
    sum / count
}

/// Potential flow in the cells of a tree, of a channel, or of a user-supplied case.
fn potential<S: Solid>(
    case: &Case,
    domain: &Domain,
    interface: &FluidInterface,
    solid: &mut S,
    transfer: &Transfer<S::Location>,
) -> Result<Box<dyn Surrogate>, SurrogateError> {
    let mesh = domain.surface();
    let (wet, wet_points) = (&domain.wet_patches, &interface.points);
    let length = |line: &SpaceCurve| {
        let [from, to] = line.ends();
        to - from
    };
    let branches = domain.branches.as_ref().map(|branches| {
        let lines = branches.lines.iter().map(|(_, line)| line.clone());
        let lines: Vec<SpaceCurve> = lines.collect();
        let whole: f64 = lines.iter().map(length).sum();
        let radius = (mesh.volume() / (PI * whole)).sqrt();
        let spacing = (whole / MOST_STATIONS as f64)
            .max(LEAST_SPACING * radius)
            .max(face_length(&lines, mesh, wet));
        let shapes = BranchShapes::along(&lines, spacing, radius, MOST_TREE_PERIODS);
        (shapes, FELT * radius)
    });
    let surface;
    let shapes: &dyn PressureShapes = match &branches {
        Some((shapes, _)) => shapes,
        None => {
            let faces = wet.iter().filter_map(|patch| mesh.patch(patch));
            let faces = faces.flat_map(|patch| patch.start..patch.start + patch.size);
            let faces: Vec<_> = faces.map(|face| mesh.face_geometry(face)).collect();
            surface = SurfaceShapes::on(&faces, MOST_STATIONS);
            &surface
        }
    };
    let at: Vec<_> = (solid.wet_points().iter())
        .map(|point| shapes.at(&point.position, &-point.normal))
        .collect();
    let pressure = case.initial_wall().map_or(0.0, |initial| initial.pressure);
    let mut wall = WallAnswers::new(case, solid, transfer, pressure, shapes.count());
    // An unloaded shape is found to a tolerance, by which the wall still moves.
    wall.rest = wall.displacement(&vec![0.0; at.len()])?;
    let answers = match &branches {
        Some((shapes, felt)) => answers_along_branches(&mut wall, shapes, &at, *felt, wet_points)?,
        None => wall.answers(&at, 0..shapes.count())?,
    };
    let surrogate = PotentialSurrogate::new(
        shapes,
        (mesh, wet),
        pressure_ends(case, domain)?,
        (wet_points, &interface.faces),
        PotentialBlood {
            density: case.blood.density,
            share: time_step(case) / case.time.step,
        },
        &answers,
        case.time.step,
    )?;
    Ok(Box::new(surrogate))
}

/// What the wall answers to a pressure of this shape, for a unit of it.
type Answer<'a> = dyn FnMut(&dyn Fn(TubePlace) -> f64) -> Result<DVector<f64>, SurrogateError> + 'a;

/// The wall's answers to waves around the circumference, those of a cosine and of a sine for each number of periods, as
/// far as the blood's added mass counts there. Stations so far apart that none feels the next one's press at once.
fn waves(
    stations: &Stations,
    blood: &SurrogateBlood,
    answer: &mut Answer<'_>,
) -> Result<Vec<Vec<Comb>>, SurrogateError> {
    let reference = stations.reference_radius();
    let radius = reference.iter().sum::<f64>() / reference.len() as f64;
    let step = (FELT * radius / stations.length() * (stations.count() + 1) as f64).ceil() as usize;
    let step = step.clamp(1, stations.count());
    let mut to_waves = Vec::new();
    for periods in 1..=stations.periods() {
        let [cosine, sine] = [2 * periods - 1, 2 * periods];
        let d = answer(&|x| stations.uniform(cosine, x))?;
        let compliance = stations.amplitudes(&d).column(cosine).amax();
        let added_mass = blood.density * radius / periods as f64;
        if compliance * added_mass / blood.time_step.powi(2) < LEAST_ADDED_MASS {
            break;
        }
        for wave in [cosine, sine] {
            let mut combs = Vec::new();
            for first in 0..step {
                let teeth = |x: TubePlace| -> f64 {
                    let teeth = (first..stations.count()).step_by(step);
                    teeth.map(|station| stations.share(station, x)).sum()
                };
                let answer = answer(&|x| teeth(x) * stations.uniform(wave, x))?;
                combs.push(Comb::new(stations, first, step, answer));
            }
            to_waves.push(combs);
        }
    }
    Ok(to_waves)
}

/// What happens at the ends of the tube, beyond rigid pieces of these lengths (m), in beats of `period` (s).
fn ends(
    vessel: &BloodVessel,
    period: f64,
    upstream: f64,
    downstream: f64,
) -> Result<(TubeEnd, TubeEnd), TableError> {
    let end = |end, rigid_length| {
        let condition = vessel.prescribed_at(end, period)?;
        let Some(PressureModel {
            proximal, distal, ..
        }) = condition.pressure()
        else {
            return Ok(TubeEnd::Flow);
        };
        Ok(match (*distal, *proximal) {
            (Some((resistance, compliance)), proximal) => TubeEnd::Windkessel {
                proximal,
                resistance,
                compliance,
                rigid_length,
            },
            (None, 0.0) => TubeEnd::Pressure { rigid_length },
            (None, resistance) => TubeEnd::Resistance {
                resistance,
                rigid_length,
            },
        })
    };
    Ok((
        end(VesselSide::Start, upstream)?,
        end(VesselSide::End, downstream)?,
    ))
}

/// The stations of the surrogate of a case whose wall has these `points` (m).
pub fn stations(
    vessel: &BloodVessel,
    solver: Solver,
    points: &[Vec3],
) -> Result<Stations, NoRings> {
    let geometry = Vessel::new(vessel);
    let axis = Axis {
        line: geometry.centre_line().clone(),
        length: geometry.end(),
    };
    let options = StationOptions {
        shape: match solver {
            Solver::Native => SurrogateWall::Elements(vessel.fluid.native.degree),
            Solver::OpenFoam | Solver::External => SurrogateWall::Faces,
        },
        most: MOST_STATIONS,
        around: MOST_PERIODS,
    };
    Stations::new(points, axis, options)
}
