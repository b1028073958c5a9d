//! Whether a converged step is an answer: the fluid's equations were solved, mass balances, the wall got the fluid's
//! force, and nothing lies beyond what drives the flow.
//!
//! The limits were measured on the cases of this project: `docs/coupling.md`, "When a step is accepted".

use super::transfer::{Transfer, force_mismatch};
use super::{Answer, Iteration};
use crate::Vec3;
use crate::fluid::{FluidStep, FluidTrial};
use crate::pfem::Solid;
use serde::{Deserialize, Serialize};

/// Largest residual with which the fluid's last sweep may begin, unless the case asks for a larger one. Where OpenFOAM
/// uses up its correctors in a healthy step it is 0.037 at most, and the pressure 1.5 % off; with 0.074 that is 16 %
/// off.
const UNSOLVED: f64 = 0.05;
/// Largest share of the flow through the domain that a step may lose. Healthy steps lose 5e-3 at most.
const LOST: f64 = 0.02;
/// Largest share of the fluid's force that may be missing on the wall. Healthy steps miss 4e-4 at most.
const MISSING: f64 = 0.01;
/// A step resolves no flow that exchanges the whole domain more often than this; healthy ones exchange it once at most.
const EXCHANGES: f64 = 1e3;
/// A loss below this share of the largest flow that the drive explains is none.
const NEGLIGIBLE: f64 = 1e-6;
/// Sweeps diverge whose first residuals grow in so many coupling iterations in a row, by this factor at least, while
/// the wall moves by no more than this share of its displacement.
const GROWING: usize = 4;
const GROWTH: f64 = 1.2;
const STILL: f64 = 0.01;
/// Where a missing force acts is reported for as many faces as this.
const FEW_FACES: usize = 8;

/// What a step must not exceed. Pressures and flows are those of an incompressible fluid that obeys what drives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Residual with which the fluid's last sweep began.
    pub residual: f64,
    /// Load on the wall and pressure at the openings, Pa.
    pub pressure: f64,
    /// Flow through an opening, m³/s.
    pub flow: f64,
    /// Whether the fluid leaves the domain through its openings alone, so that mass must balance.
    pub is_closed: bool,
    /// Whether the wall is elastic, so that the fluid's force must reach it.
    pub is_elastic: bool,
}

impl Limits {
    /// Those that hold whatever drives the flow: above `density · (1500 m/s)²` no liquid is incompressible.
    pub fn of_any_liquid(density: f64, pressure_residual: f64) -> Self {
        Self {
            residual: UNSOLVED.max(pressure_residual),
            pressure: density * 1500.0 * 1500.0,
            flow: f64::INFINITY,
            is_closed: true,
            is_elastic: true,
        }
    }
}

/// Why a step is not accepted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The fluid gave up before its equations were solved.
    #[error(
        "the fluid's equations were not solved: the last of {sweeps} sweeps began with a residual of {residual:.3}, where {limit} is accepted at most; the largest load is {load:.2e} Pa at {place}. Try a smaller time.step_s or more cells where the lumen changes; in dictionaries of your own also `consistent yes` or `relaxationFactors`"
    )]
    Unsolved {
        /// Residual with which the last sweep began.
        residual: f64,
        /// Largest one that is accepted.
        limit: f64,
        /// Sweeps that were spent.
        sweeps: u32,
        /// Largest load on the wall, Pa.
        load: f64,
        /// Where it acts.
        place: FaultPlace,
    },
    /// The more the fluid works, the farther it is from a solution.
    #[error(
        "the fluid's sweeps diverge: in {GROWING} coupling iterations, in which the wall moved by less than {:.0} % of its displacement, the residual with which the last one began grew to {residual:.3}, where {limit} is accepted at most. Try a smaller time.step_s: most often fluid passes several cells in a step (the Courant number in openfoam.log)",
        100.0 * STILL
    )]
    Diverging {
        /// Residual with which the last sweep began.
        residual: f64,
        /// Largest one that is accepted.
        limit: f64,
    },
    /// A value is not a number.
    #[error("the fluid diverged: {quantity} is non-finite at {place}")]
    NonFinite {
        /// Which.
        quantity: &'static str,
        /// Where.
        place: FaultPlace,
    },
    /// A value is far beyond what drives the flow.
    #[error(
        "the fluid diverged: {quantity} is {value:.2e} {unit} at {place}, and what drives the flow explains {limit:.1e} {unit} at most. Try a smaller time.step_s or more cells; if the value is right, the units of the case are not"
    )]
    Beyond {
        /// Which.
        quantity: &'static str,
        /// How large it is.
        value: f64,
        /// How large it may be.
        limit: f64,
        /// Unit of both.
        unit: &'static str,
        /// Where.
        place: FaultPlace,
    },
    /// Mass does not balance.
    #[error(
        "the fluid loses mass: {inflow:.3e} m3/s flow in, {outflow:.3e} m3/s flow out, and its volume grows by {rate:.3e} m3/s; the difference is {:.1} % of what goes through, where {:.0} % is accepted at most. Try a smaller fluid.pressure_residual with a larger fluid.max_correctors, or a smaller time.step_s",
        100.0 * .share, 100.0 * LOST
    )]
    MassLost {
        /// Flow into the domain, m³/s.
        inflow: f64,
        /// Flow out of it, m³/s.
        outflow: f64,
        /// Rate of change of its volume, m³/s.
        rate: f64,
        /// Share of the flow through the domain that is missing.
        share: f64,
    },
    /// The wall did not get the fluid's force.
    #[error(
        "{:.1} % of the fluid's force does not reach the wall, where {:.0} % is accepted at most: most of it acts within {:.2e} m of {place}. Does the wall's mesh have a wet surface there, in the same unit of length, and as wide as the fluid's? `fsi-driver check` measures the gap",
        100.0 * .share, 100.0 * MISSING, .within
    )]
    ForceLost {
        /// Share of the force that is missing.
        share: f64,
        /// Middle of the faces whose load is missing.
        place: FaultPlace,
        /// How far they are from there, m.
        within: f64,
    },
}

/// Where something was seen.
#[derive(Debug, Clone, PartialEq)]
pub enum FaultPlace {
    /// A point of the wall at rest, m.
    Wall(Vec3),
    /// An opening, by its name.
    Opening(String),
    /// Nowhere in particular.
    Domain,
}

impl std::fmt::Display for FaultPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Wall(x) => write!(f, "({:.3e}, {:.3e}, {:.3e}) m", x.x, x.y, x.z),
            Self::Opening(name) => write!(f, "the opening {name}"),
            Self::Domain => f.write_str("the end of the step"),
        }
    }
}

/// What the balance of mass needs to know of the steps before.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// Volume of the whole domain, m³, if it is known.
    volume: Option<f64>,
    /// Rate of change of the volume in the last step, m³/s.
    rate: f64,
    /// Largest flow through the domain so far, m³/s.
    through: f64,
}

impl Balance {
    /// Of a domain that begins with a volume, m³.
    pub fn of(volume: f64) -> Self {
        Self {
            volume: Some(volume),
            ..Self::default()
        }
    }

    /// The balance after a step of the length `dt` (s), and the share of the flow through the domain that the step
    /// lost. What a time scheme of second order, or flows at the middle of the step, make of a rate that changes is not
    /// counted.
    pub fn after(&self, step: &FluidStep, dt: f64) -> (Self, f64) {
        let rate = self
            .volume
            .map_or(0.0, |volume| (step.volume - volume) / dt);
        let flows = || step.openings.iter().map(|opening| opening.flow);
        let one_way = |sign: f64| flows().map(|flow| (sign * flow).max(0.0)).sum::<f64>();
        let through = one_way(1.0).max(one_way(-1.0)).max(rate.abs());
        let through = through.max(self.through);
        let gap = (flows().sum::<f64>() - rate).abs() - (rate - self.rate).abs();
        let share = match self.volume {
            Some(_) if gap > 0.0 => gap / through,
            _ => 0.0,
        };
        let next = Self {
            volume: Some(step.volume),
            rate,
            through,
        };
        (next, share)
    }
}

impl Limits {
    /// Judges a step that has not converged yet.
    pub(super) fn of_iterations(&self, done: &[Iteration], max_sweeps: u32) -> Result<(), Refusal> {
        let tail = &done[done.len().saturating_sub(GROWING + 1)..];
        let grows = |pair: &[Iteration]| {
            let [before, now] = [&pair[0], &pair[1]].map(|iteration| iteration.fluid_cost.residual);
            now > GROWTH * before && pair[1].measure.change < STILL
        };
        let is_at_work = |iteration: &Iteration| iteration.fluid_cost.sweeps >= max_sweeps;
        match tail.last().map(|last| last.fluid_cost.residual) {
            Some(residual)
                if tail.len() > GROWING
                    && residual > self.residual
                    && tail.iter().all(is_at_work)
                    && tail.windows(2).all(grows) =>
            {
                Err(Refusal::Diverging {
                    residual,
                    limit: self.residual,
                })
            }
            _ => Ok(()),
        }
    }

    /// Judges a step that has converged, before the fluid keeps it. `needs_load`: the wall answers to the load.
    pub(super) fn of_trial<S: Solid>(
        &self,
        iteration: &Iteration,
        answer: &Answer<S::Trial>,
        transfer: &Transfer<S::Location>,
        solid: &S,
        needs_load: bool,
    ) -> Result<(), Refusal> {
        let (load, place) = largest(&answer.flow, transfer);
        let cost = iteration.fluid_cost;
        if cost.residual.is_nan() || cost.residual > self.residual {
            return Err(Refusal::Unsolved {
                residual: cost.residual,
                limit: self.residual,
                sweeps: cost.sweeps,
                load,
                place,
            });
        }
        self.bounded("the load on the wall", load, self.pressure, "Pa", || place)?;
        if needs_load && iteration.force_mismatch > MISSING {
            let wet_areas = solid.deformed_areas(&answer.trial);
            let (place, within) = missing_load(answer, transfer, &wet_areas);
            return Err(Refusal::ForceLost {
                share: iteration.force_mismatch,
                place: FaultPlace::Wall(place),
                within,
            });
        }
        Ok(())
    }

    /// Judges what the fluid reports of a step of the length `dt` (s) that it has kept. Returns the balance after it,
    /// and the share of the flow that it lost.
    pub(super) fn of_step<L>(
        &self,
        step: &FluidStep,
        dt: f64,
        balance: &Balance,
        transfer: &Transfer<L>,
    ) -> Result<(Balance, f64), Refusal> {
        let whole = || FaultPlace::Domain;
        self.bounded("the volume", step.volume, f64::INFINITY, "m3", whole)?;
        // A fluid that does not know its volume says 0
        let exchange = match step.volume {
            0.0 => f64::INFINITY,
            volume => EXCHANGES * volume.abs() / dt,
        };
        // A wall that moves drives a flow of its own: one that buckles pushes more blood out than the inlet brings.
        let pushed = balance
            .volume
            .map_or(0.0, |before| (step.volume - before).abs() / dt);
        let most = (self.flow + pushed).min(exchange);
        for opening in &step.openings {
            let place = || FaultPlace::Opening(opening.name.clone());
            self.bounded("the flow", opening.flow, most, "m3/s", place)?;
            let pressure = opening.mean_pressure;
            self.bounded("the pressure", pressure, self.pressure, "Pa", place)?;
        }
        for (i, shear) in step.wall_shear.iter().enumerate() {
            let place = || FaultPlace::Wall(transfer.face_centre(i));
            self.bounded(
                "the wall shear stress",
                shear.norm(),
                self.pressure,
                "Pa",
                place,
            )?;
        }
        let (next, share) = balance.after(step, dt);
        // What is lost counts against what drives the flow: when it begins from rest, next to nothing goes through.
        let negligible = match self.flow.is_finite() {
            true => NEGLIGIBLE * self.flow,
            false => 0.0,
        };
        let share = match share * next.through > negligible {
            true => share,
            false => 0.0,
        };
        if self.is_closed && share > LOST {
            return Err(Refusal::MassLost {
                inflow: step.inflow(),
                outflow: step.outflow(),
                rate: next.rate,
                share,
            });
        }
        Ok((next, share))
    }

    fn bounded(
        &self,
        quantity: &'static str,
        value: f64,
        limit: f64,
        unit: &'static str,
        place: impl FnOnce() -> FaultPlace,
    ) -> Result<(), Refusal> {
        match value {
            _ if !value.is_finite() => Err(Refusal::NonFinite {
                quantity,
                place: place(),
            }),
            _ if value.abs() > limit => Err(Refusal::Beyond {
                quantity,
                value,
                limit,
                unit,
                place: place(),
            }),
            _ => Ok(()),
        }
    }
}

/// Refuses a load that is not finite, of which the wall could make nothing.
pub(super) fn require_finite<L>(flow: &FluidTrial, transfer: &Transfer<L>) -> Result<(), Refusal> {
    let is_finite = |traction: &Vec3| traction.iter().all(|c| c.is_finite());
    match flow.tractions.iter().position(|t| !is_finite(t)) {
        Some(face) => Err(Refusal::NonFinite {
            quantity: "the load on the wall",
            place: FaultPlace::Wall(transfer.face_centre(face)),
        }),
        None => Ok(()),
    }
}

/// The largest load on the wall, Pa, and where it acts.
fn largest<L>(flow: &FluidTrial, transfer: &Transfer<L>) -> (f64, FaultPlace) {
    let loads = flow.tractions.iter().map(|traction| traction.norm());
    let (face, load) = (loads.enumerate())
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0, 0.0));
    (load, FaultPlace::Wall(transfer.face_centre(face)))
}

/// Where most of a missing force acts: the faces are halved again and again, and the half kept that misses more.
/// Returns their middle at rest and how far they are from it, m.
fn missing_load<T, L>(
    answer: &Answer<T>,
    transfer: &Transfer<L>,
    wet_areas: &[Vec3],
) -> (Vec3, f64) {
    let tractions = &answer.flow.tractions;
    let missing = |faces: &[usize]| {
        let mut part = vec![Vec3::zeros(); tractions.len()];
        for &face in faces {
            part[face] = tractions[face];
        }
        let load = transfer.load(&part, &answer.areas);
        let size = faces
            .iter()
            .map(|&f| tractions[f].norm() * answer.areas[f].norm());
        force_mismatch(&part, &answer.areas, &load, wet_areas) * size.sum::<f64>()
    };
    let mut faces: Vec<usize> = (0..tractions.len()).collect();
    let at = |face: usize| transfer.face_centre(face);
    while faces.len() > FEW_FACES {
        let (low, high) = faces
            .iter()
            .fold((at(faces[0]), at(faces[0])), |(a, b), &f| {
                (a.inf(&at(f)), b.sup(&at(f)))
            });
        let axis = (high - low).imax();
        faces.sort_by(|&a, &b| at(a)[axis].total_cmp(&at(b)[axis]));
        let upper = faces.split_off(faces.len() / 2);
        if missing(&upper) > missing(&faces) {
            faces = upper;
        }
    }
    let middle = faces.iter().map(|&f| at(f)).sum::<Vec3>() / faces.len().max(1) as f64;
    let within = faces.iter().map(|&f| (at(f) - middle).norm());
    (middle, within.fold(0.0, f64::max))
}
