//! The surrogate of a case: a tube with the structure's compliance.

use crate::Vec3;
use crate::case::{
    self, BloodVessel, Case, FluidTimeScheme, PressureModel, Problem, Solver, TableError,
    VesselSide,
};
use crate::coupling::acceleration::{Identity, Surrogate};
use crate::coupling::flatten;
use crate::coupling::surrogate::{
    Axis, Comb, NoRings, StationOptions, Stations, SurrogateBlood, SurrogateWall, TubeEnd,
    TubePlace, TubeSurrogate,
};
use crate::coupling::transfer::Transfer;
use crate::fluid::FluidInterface;
use crate::geometry::Vessel;
use crate::pfem::{Solid, SolidError, SurfaceLoad};
use nalgebra::DVector;

/// Pressure (Pa) that probes the wall without load: so small that one tangent serves for all stations.
const PROBE: f64 = 1.0;
/// Share of the pressure in a loaded wall that probes it: likewise, and above the rounding errors of what it adds to.
const SHARE: f64 = 1e-3;
/// Relative residual of the answers: a surrogate need not be accurate.
const PROBE_TOLERANCE: f64 = 1e-3;
/// Most stations between the ends: each costs a solution of the structure.
const MOST_STATIONS: usize = 63;
/// Most periods of a wave around the circumference.
const MOST_PERIODS: usize = 8;
/// Waves are left out from that number of periods on where the blood's added mass is below this share of what the wall
/// sets against it: they hardly disturb the iteration.
const LEAST_ADDED_MASS: f64 = 0.2;
/// The wall's answer to such waves is felt up to half so many radii from where they press.
const FELT: f64 = 2.0;

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
    /// The wall gives no answer.
    #[error(transparent)]
    Wall(#[from] SolidError),
}

/// The surrogate that the case asks for. Its wall is what `solid`, which is at rest under a `pressure` (Pa), answers to
/// a little more within a time step.
pub fn surrogate<S: Solid>(
    case: &Case,
    interface: &FluidInterface,
    solid: &mut S,
    transfer: &Transfer<S::Location>,
    pressure: f64,
) -> Result<Box<dyn Surrogate>, SurrogateError> {
    let vessel = match &case.problem {
        _ if case.coupling.surrogate == case::SurrogateModel::None => {
            return Ok(Box::new(Identity));
        }
        // Nothing moves.
        Problem::Vessel(vessel) if vessel.is_rigid() => return Ok(Box::new(Identity)),
        Problem::Vessel(vessel) => vessel,
        Problem::Flag(_) | Problem::UserCase(_) => {
            return Err(SurrogateError::NoTube);
        }
    };
    let geometry = Vessel::new(vessel);
    let [first, last] = [0, geometry.sections().len() - 1].map(|i| &geometry.sections()[i]);
    let [upstream, downstream] = [-first.from, last.to - geometry.end()];
    let open = |rigid_length| TubeEnd::Pressure { rigid_length };
    let (inlet, outlet) = match case.coupling.surrogate {
        case::SurrogateModel::None => return Ok(Box::new(Identity)),
        case::SurrogateModel::Tube => ends(vessel, case.time.period, upstream, downstream)?,
        case::SurrogateModel::OpenTube => (open(upstream), open(downstream)),
    };
    let stations = stations(vessel, case.fluid.solver, &interface.points)?;

    let probe = PROBE.max(SHARE * pressure.abs());
    // The residual is measured against the whole load.
    let tolerance = match pressure {
        0.0 => PROBE_TOLERANCE,
        _ => PROBE_TOLERANCE * SHARE / (stations.count() as f64).sqrt(),
    };
    let rest = flatten(&transfer.accepted_displacement(solid));
    let wet = solid.wet_points().iter();
    let places: Vec<TubePlace> = wet.map(|point| stations.place(&point.position)).collect();
    let mut answer = |shape: &dyn Fn(TubePlace) -> f64| {
        let at = |place: &TubePlace| pressure + probe * shape(*place);
        let load = SurfaceLoad {
            pressure: places.iter().map(at).collect(),
            shear: vec![Vec3::zeros(); places.len()],
        };
        let trial = solid.solve(&load, case.time.step, tolerance, None)?;
        Ok::<_, SurrogateError>((flatten(&transfer.displacement(solid, &trial)) - &rest) / probe)
    };
    let blood = SurrogateBlood {
        density: case.blood.density,
        viscosity: case.blood.viscosity,
        time_step: match case.time.scheme {
            FluidTimeScheme::ImplicitEuler => case.time.step,
            FluidTimeScheme::Bdf2 => case.time.step / 1.5,
        },
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
