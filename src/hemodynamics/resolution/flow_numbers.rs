//! What is known of a vessel's flow, and of its meshes, before it is computed.

use super::{Doubt, ResolutionFinding};
use crate::geometry::{Span, Vessel};
use fsi_spectral::TimeScheme;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Cross-sections that are looked at.
const STATIONS: usize = 400;
/// Directions in each.
const AROUND: usize = 16;
/// Flow in a straight tube may be turbulent from this Reynolds number on.
const TUBE: f64 = 2000.0;
/// Downstream of a narrow place it is sooner: share of the area that is lost in it, and Reynolds number of the wide
/// part. With half of the area or less lost, disturbances were weak up to 1000 (Ahmed and Giddens 1983, J. Biomech.
/// 16); 75 % become unstable at 722 in steady and at 389 in pulsatile flow (Sherwin and Blackburn 2005, J. Fluid Mech.
/// 533).
const WIDENING: [(f64, f64); 3] = [(0.25, TUBE), (0.5, 1000.0), (0.75, 400.0)];
/// A vessel that widens over more of its wider radii has no jet.
const JET_LENGTH: f64 = 10.0;
/// From this share of the area on a widening is a jet ...
const JET_REDUCTION: f64 = 0.5;
/// ... at this Reynolds number of its narrow part.
const JET_REYNOLDS: f64 = 50.0;
/// Cells from the axis to the edge of a jet: 32 mm downstream the FDA nozzle's is too slow by 1.5/n².
const JET_CELLS: f64 = 6.0;
/// The same for distances of nodes, on average: with 5.0, 3.3, 2.5, 2.1 and 1.7 velocities on the axis were off by 0.2,
/// 1.4, 6, 6 and 8 %.
const JET_NODES: f64 = 3.0;
/// Cells in the layer at the wall: with 2.8, 1.4, 0.7 and 0.4 the mean wall shear was 5, 8, 20 and 42 % too low.
const LAYER_CELLS: f64 = 2.5;
/// Distances of nodes in it, on average: with 1.0, 0.9, 0.7 and 0.5 it was off by 0.5, 2, 7 and 7 to 10 %.
const LAYER_NODES: f64 = 0.75;
/// A flow that swings by less of its mean has no layer of its own.
const STEADY: f64 = 0.05;
/// Share by which a time step may damp what swings.
const STEP_ERROR: f64 = 0.05;

/// The most severe widening of a vessel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Jet {
    /// Where its narrow part is, along the centre-line.
    pub at_m: f64,
    /// Area of the wide part that is lost there.
    pub area_reduction: f64,
    /// Peak Reynolds number of the wide part.
    pub reynolds: f64,
    /// That at which laminar flow becomes doubtful.
    pub reynolds_limit: f64,
    /// Fewest cells, or distances of nodes, from the axis to the edge of a jet in a wide part.
    pub points: Option<f64>,
}

/// Sizes of a flow, and of cells or distances of nodes in it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FlowNumbers {
    /// Largest flow.
    pub peak_flow_m3_s: f64,
    /// Largest Reynolds number (of mean velocity and diameter) along the vessel at that flow.
    pub reynolds: f64,
    /// Where that is, along the centre-line.
    pub reynolds_at_m: f64,
    /// Frequency with which the flow swings, a full turn of a sine: root mean squares of its slope over its deviation
    /// from the mean. Absent where it is steady.
    pub frequency_1_s: Option<f64>,
    /// Thickness `sqrt(2 nu/omega)` of Stokes' layer at that frequency, or half the least radius if that is thinner.
    pub layer_m: Option<f64>,
    /// Cells (distances of nodes, on average) in that layer where the wall's cells are thickest.
    pub points_in_layer: Option<f64>,
    /// Time steps in a period.
    pub steps_per_period: f64,
    /// Share by which the time scheme damps or delays what swings.
    pub step_error: Option<f64>,
    /// Largest Courant number of the mean velocity.
    pub courant: Option<f64>,
    /// Largest Reynolds number of the mean velocity and the width of a cell across.
    pub cell_reynolds: Option<f64>,
    /// The widening where laminar flow is most doubtful, if there is one.
    pub jet: Option<Jet>,
    /// Whether the fluid has elements of high degree instead of cells.
    has_elements: bool,
}

/// Sizes of cells or distances of nodes, as shares of the radius.
#[derive(Debug, Clone, Copy)]
pub struct PointSpacing {
    /// Across the lumen.
    pub across: f64,
    /// At the wall.
    pub at_wall: f64,
    /// Whether the fluid has elements of high degree instead of cells.
    pub has_elements: bool,
}

/// A vessel, and how its flow is computed.
pub struct FlowSetting<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// Kinematic viscosity, m²/s.
    pub viscosity: f64,
    /// Length of a time step, s.
    pub time_step: f64,
    /// Duration of a beat, s.
    pub period: f64,
    /// Time integration.
    pub scheme: TimeScheme,
    /// Points across the lumen, if they are known.
    pub spacing: Option<PointSpacing>,
    /// Cells along the vessel.
    pub cells: Vec<Span>,
}

impl FlowNumbers {
    /// With a flow of these samples, pairs of time (s) and flow (m³/s); none if nothing flows.
    pub fn new(setting: &FlowSetting<'_>, samples: &[[f64; 2]]) -> Option<Self> {
        let (peak, swing) = course(samples)?;
        let (vessel, nu, time_step) = (setting.vessel, setting.viscosity, setting.time_step);
        let sections = vessel.sections();
        let [from, to] = [sections.first()?.from, sections.last()?.to];
        let stations: Vec<[f64; 2]> = (0..=STATIONS)
            .map(|i| from + (to - from) * i as f64 / STATIONS as f64)
            .map(|s| [s, mean_radius(vessel, s)])
            .collect();
        let narrowest = stations.iter().min_by(|a, b| a[1].total_cmp(&b[1]))?;
        let reynolds = |radius: f64| 2.0 * peak / (PI * radius * nu);
        let velocity = |radius: f64| peak / (PI * radius * radius);
        let points = setting.spacing;
        let omega = swing.map(|swing| swing * TAU);
        let layer = omega.map(|omega| (2.0 * nu / omega).sqrt().min(0.5 * narrowest[1]));
        let widest = stations.iter().map(|[_, r]| *r).fold(0.0, f64::max);
        let cells = points.filter(|points| !points.has_elements);
        Some(Self {
            peak_flow_m3_s: peak,
            reynolds: reynolds(narrowest[1]),
            reynolds_at_m: narrowest[0],
            frequency_1_s: swing,
            layer_m: layer,
            points_in_layer: layer
                .zip(points)
                .map(|(layer, points)| layer / (points.at_wall * widest)),
            steps_per_period: setting.period / time_step,
            step_error: omega.map(|omega| step_error(setting.scheme, omega * time_step)),
            courant: cells.map(|_| {
                let number = |span: &Span| {
                    let middle = 0.5 * (span.from + span.to);
                    let speed = [span.from, middle, span.to]
                        .map(|s| velocity(mean_radius(vessel, s)))
                        .into_iter()
                        .fold(0.0, f64::max);
                    speed * time_step * span.pieces as f64 / (span.to - span.from)
                };
                setting.cells.iter().map(number).fold(0.0, f64::max)
            }),
            cell_reynolds: cells.map(|cells| 0.5 * reynolds(narrowest[1]) * cells.across),
            jet: jet(&stations, reynolds, points),
            has_elements: points.is_some_and(|points| points.has_elements),
        })
    }

    /// What is doubtful.
    pub fn findings(&self) -> Vec<ResolutionFinding> {
        let some = [
            self.turbulent(),
            self.thin_layer(),
            self.coarse_jet(),
            self.long_step(),
        ];
        some.into_iter().flatten().collect()
    }

    fn turbulent(&self) -> Option<ResolutionFinding> {
        let advice = "Only laminar flow is computed, and where the real one is not laminar, its wall shear may be off by any amount: check \
                      the flow, the radius and blood.viscosity_Pa_s, or take fluid.templates with a turbulence model";
        let jet = self.jet.filter(|jet| jet.reynolds > jet.reynolds_limit);
        match (jet, self.reynolds > TUBE) {
            (Some(jet), false) => Some(ResolutionFinding {
                doubt: Doubt::Laminar,
                value: jet.reynolds,
                limit: jet.reynolds_limit,
                text: format!(
                    "the Reynolds number is {:.0} at peak flow, and the vessel widens downstream of x = {:.4} m, where {:.0} % of its area are lost: \
                     there flow may be turbulent from about {:.0} on. {advice}",
                    jet.reynolds,
                    jet.at_m,
                    100.0 * jet.area_reduction,
                    jet.reynolds_limit
                ),
            }),
            (_, true) => Some(ResolutionFinding {
                doubt: Doubt::Laminar,
                value: self.reynolds,
                limit: TUBE,
                text: format!(
                    "the Reynolds number is {:.0} at peak flow, at x = {:.4} m: from about {TUBE:.0} on, flow in a tube may be turbulent. \
                     {advice}",
                    self.reynolds, self.reynolds_at_m
                ),
            }),
            (_, false) => None,
        }
    }

    fn thin_layer(&self) -> Option<ResolutionFinding> {
        let (points, layer, frequency) =
            (self.points_in_layer?, self.layer_m?, self.frequency_1_s?);
        let limit = match self.has_elements {
            true => LAYER_NODES,
            false => LAYER_CELLS,
        };
        (points < limit).then(|| ResolutionFinding {
            doubt: Doubt::Layer,
            value: points,
            limit,
            text: format!(
                "the layer at the wall in which the pulse is felt is {:.2} mm thick (at {frequency:.2} Hz), and {points:.1} {} lie in it; \
                 with fewer than {limit} the wall shear is off by more than 5 %: raise {}",
                1e3 * layer,
                self.what(),
                match self.has_elements {
                    true => "fluid.native.radial or fluid.native.degree",
                    false => "fluid.mesh.radial or fluid.mesh.wall_grading",
                }
            ),
        })
    }

    fn coarse_jet(&self) -> Option<ResolutionFinding> {
        let jet = self.jet?;
        let points = jet.points?;
        let limit = match self.has_elements {
            true => JET_NODES,
            false => JET_CELLS,
        };
        (points < limit).then(|| ResolutionFinding {
            doubt: Doubt::Jet,
            value: points,
            limit,
            text: format!(
                "downstream of x = {:.4} m the vessel widens, and {points:.1} {} lie between the axis and the edge of the jet; with fewer than \
                 {limit} its velocity is off by more than 5 %: raise {}",
                jet.at_m,
                self.what(),
                match self.has_elements {
                    true => "fluid.native.core or fluid.native.degree",
                    false => "fluid.mesh.core",
                }
            ),
        })
    }

    fn long_step(&self) -> Option<ResolutionFinding> {
        let (error, frequency) = (self.step_error?, self.frequency_1_s?);
        (error > STEP_ERROR).then(|| ResolutionFinding {
            doubt: Doubt::Step,
            value: error,
            limit: STEP_ERROR,
            text: format!(
                "a period has {:.0} steps, and what swings in the flow (at {frequency:.2} Hz) is damped by about {:.0} %: shorten \
                 time.step_s, or take time.scheme = \"bdf2\"",
                self.steps_per_period,
                100.0 * error
            ),
        })
    }

    fn what(&self) -> &'static str {
        match self.has_elements {
            true => "distances of nodes",
            false => "cells",
        }
    }
}

impl std::fmt::Display for FlowNumbers {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let what = self.what();
        write!(f, "{:.0} steps per period", self.steps_per_period)?;
        if let (Some(layer), Some(points)) = (self.layer_m, self.points_in_layer) {
            write!(
                f,
                "; layer at the wall {:.2} mm, {points:.1} {what} in it",
                1e3 * layer
            )?;
        }
        if let Some(points) = self.jet.and_then(|jet| jet.points) {
            write!(
                f,
                "; {points:.1} {what} from the axis of the jet to its edge"
            )?;
        }
        if let (Some(courant), Some(reynolds)) = (self.courant, self.cell_reynolds) {
            write!(
                f,
                "; Courant number {courant:.1} and cell Reynolds number {reynolds:.0} at peak flow"
            )?;
        }
        Ok(())
    }
}

/// The largest flow (m³/s), and the frequency (1/s) with which it swings, if it does; none if nothing flows.
fn course(samples: &[[f64; 2]]) -> Option<(f64, Option<f64>)> {
    let peak = samples.iter().map(|[_, q]| q.abs()).fold(0.0, f64::max);
    let duration = samples.last()?[0] - samples.first()?[0];
    if peak <= 0.0 || duration <= 0.0 {
        return None;
    }
    let pieces = || {
        samples
            .windows(2)
            .map(|w| (w[1][0] - w[0][0], w[0][1], w[1][1]))
    };
    let mean = pieces().map(|(dt, a, b)| 0.5 * dt * (a + b)).sum::<f64>() / duration;
    let deviation: f64 = pieces()
        .map(|(dt, a, b)| dt * (0.5 * (a + b) - mean).powi(2))
        .sum();
    let slope: f64 = pieces().map(|(dt, a, b)| (b - a).powi(2) / dt).sum();
    let swings = (deviation / duration).sqrt() > STEADY * mean.abs();
    Some((peak, swings.then(|| (slope / deviation).sqrt() / TAU)))
}

/// Relative error of a time scheme for a swing of the phase `phase` (radians) in a step.
fn step_error(scheme: TimeScheme, phase: f64) -> f64 {
    match scheme {
        TimeScheme::ImplicitEuler => 0.5 * phase,
        TimeScheme::Bdf2 => phase * phase / 3.0,
    }
}

/// Radius (m) of the circle with the area of a cross-section.
fn mean_radius(vessel: &Vessel, s: f64) -> f64 {
    let square = |j: usize| {
        vessel
            .lumen_radius(s, TAU * j as f64 / AROUND as f64)
            .powi(2)
    };
    ((0..AROUND).map(square).sum::<f64>() / AROUND as f64).sqrt()
}

/// The Reynolds number of the wide part from which on flow downstream of a place that loses this share of the area is
/// doubtful.
fn laminar_limit(reduction: f64) -> f64 {
    let [first, .., last] = WIDENING;
    if reduction <= first.0 {
        return first.1;
    }
    let piece = WIDENING.windows(2).find(|pair| reduction <= pair[1].0);
    piece.map_or(last.1, |pair| {
        let t = (reduction - pair[0].0) / (pair[1].0 - pair[0].0);
        pair[0].1 * (pair[1].1 / pair[0].1).powf(t)
    })
}

/// The widening where the Reynolds number is largest compared with its limit, with radii (m) along the vessel.
fn jet(
    stations: &[[f64; 2]],
    reynolds: impl Fn(f64) -> f64,
    points: Option<PointSpacing>,
) -> Option<Jet> {
    let mut worst: Option<Jet> = None;
    for (i, &[at, narrow]) in stations.iter().enumerate() {
        for &[s, wide] in &stations[i..] {
            let reduction = 1.0 - (narrow / wide).powi(2);
            let near = s - at <= JET_LENGTH * wide;
            if !near || reduction < WIDENING[0].0 {
                continue;
            }
            let found = Jet {
                at_m: at,
                area_reduction: reduction,
                reynolds: reynolds(wide),
                reynolds_limit: laminar_limit(reduction),
                points: points
                    .filter(|_| reduction >= JET_REDUCTION && reynolds(narrow) > JET_REYNOLDS)
                    .map(|points| narrow / (points.across * wide)),
            };
            let severity = |jet: &Jet| jet.reynolds / jet.reynolds_limit;
            let fewest = worst.and_then(|worst| worst.points).into_iter();
            let points = fewest.chain(found.points).reduce(f64::min);
            worst = match worst {
                Some(worst) if severity(&worst) >= severity(&found) => {
                    Some(Jet { points, ..worst })
                }
                _ => Some(Jet { points, ..found }),
            };
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_frequency_of_a_sine_is_its_own_and_a_constant_has_none() {
        let samples = |swing: f64| -> Vec<[f64; 2]> {
            let value = |t: f64| [t, 2.0 + swing * (3.0 * TAU * t).sin()];
            (0..=3000).map(|n| value(f64::from(n) / 3000.0)).collect()
        };
        let (peak, frequency) = course(&samples(1.0)).unwrap();
        assert_relative_eq!(peak, 3.0, max_relative = 1e-5);
        assert_relative_eq!(frequency.unwrap(), 3.0, max_relative = 1e-4);
        assert_eq!(course(&samples(0.1)).unwrap().1, None);
        assert_eq!(course(&[[0.0, 0.0], [1.0, 0.0]]), None);
    }

    /// The more pressure a narrow place loses, the lower the limit is.
    #[test]
    fn a_stenosis_lowers_the_limit_of_laminar_flow() {
        assert_eq!(laminar_limit(0.0), 2000.0);
        assert_relative_eq!(laminar_limit(0.5), 1000.0, max_relative = 1e-12);
        assert_relative_eq!(laminar_limit(0.75), 400.0, max_relative = 1e-12);
        assert_eq!(laminar_limit(0.9), 400.0);
        let between = laminar_limit(0.6);
        assert!((400.0..1000.0).contains(&between));
    }
}
