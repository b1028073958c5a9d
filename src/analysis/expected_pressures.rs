//! The pressures that a case lets expect, before anything is computed.

use super::three_elements::ThreeElements;
use super::windkessel::{Pressures, STEPS, TwoElements};
use crate::case::{
    BloodVessel, Condition, Opening, PressureModel, TableError, TreeKeys, VesselSide,
};

/// Periods after which a tree's pressures count as periodic at the latest: of a time constant of 250 periods a
/// fiftieth is left then.
const MOST_PERIODS: usize = 1000;
/// Change of the mean pressure over a period, relative to it, with which they do.
const STEADY: f64 = 1e-6;

impl Pressures {
    /// Those to expect in a vessel of the compliance `own` (m³/Pa), in the periodic state of beats of `period` (s): of
    /// what is prescribed at the outlet for the flow, or of the pressure at the inlet.
    ///
    /// # Errors
    /// If a curve cannot be read.
    pub fn expected(vessel: &BloodVessel, period: f64, own: f64) -> Result<Self, TableError> {
        let times = (0..STEPS).map(|i| period * i as f64 / STEPS as f64);
        let [inlet, outlet] = [
            vessel.prescribed_at(VesselSide::Start, period)?,
            vessel.prescribed_at(VesselSide::End, period)?,
        ];
        let (curve, model) = match (inlet, outlet) {
            (Condition::Flow(curve, _), Condition::Pressure(model)) => (curve, model),
            (Condition::Pressure(PressureModel { downstream, .. }), _) => {
                return Ok(Self::of(
                    &times.map(|t| downstream.pressure(t)).collect::<Vec<_>>(),
                ));
            }
            _ => unreachable!("one of the openings of a checked case is under a pressure"),
        };
        let PressureModel {
            proximal,
            distal,
            downstream,
            ..
        } = model;
        let Some((resistance, compliance)) = distal else {
            let at = |t: f64| downstream.pressure(t) + proximal * curve.flow(t);
            return Ok(Self::of(&times.map(at).collect::<Vec<_>>()));
        };
        if proximal == 0.0 {
            let two = TwoElements {
                resistance,
                compliance: compliance + own,
            };
            return Ok(two.pressures(&curve));
        }
        let all = ThreeElements {
            proximal,
            resistance,
            compliance,
            vessel: own,
        };
        Ok(all.pressures(&curve))
    }

    /// The pressure that the openings of a tree of the compliance `own` (m³/Pa) make in it, in the periodic state of
    /// beats of `period` (s): the same everywhere, without the tree's own resistance and inertia. By Euler's implicit
    /// method.
    ///
    /// # Errors
    /// If a curve cannot be read.
    pub fn expected_in_tree(tree: &TreeKeys, period: f64, own: f64) -> Result<Self, TableError> {
        let openings = tree.openings(period)?;
        let step = period / STEPS as f64;
        let (mut stored, mut mean) = (vec![0.0; openings.len()], f64::INFINITY);
        for (opening, stored) in openings.iter().zip(&mut stored) {
            if let Condition::Pressure(model) = &opening.condition {
                *stored = model.at_start();
            }
        }
        let initial: f64 = stored.iter().sum::<f64>() / stored.len().max(1) as f64;
        let (mut found, mut last) = (Vec::new(), initial);
        for _ in 0..MOST_PERIODS {
            let at = |i: usize| {
                // The wall stores what lies between this pressure and the last.
                let wall = (own > 0.0).then(|| (last, step / own));
                last = common(&openings, &mut stored, wall, step * i as f64, step);
                last
            };
            found = (1..=STEPS).map(at).collect();
            let next = found.iter().sum::<f64>() / STEPS as f64;
            if (next - mean).abs() <= STEADY * next.abs() {
                break;
            }
            mean = next;
        }
        Ok(Self::of(&found))
    }
}

/// The pressure (Pa) that these openings share at the end of a step (s) at `time` (s), with which the pressures
/// `stored` in windkessels (Pa) go on. An elastic `wall` acts
/// within a step as a resistance (Pa s/m³) towards the last pressure (Pa).
fn common(
    openings: &[Opening],
    stored: &mut [f64],
    wall: Option<(f64, f64)>,
    time: f64,
    step: f64,
) -> f64 {
    let conditions = || openings.iter().map(|opening| &opening.condition);
    let inflow = |condition: &Condition| match condition {
        Condition::Flow(curve, _) => curve.flow(time),
        _ => 0.0,
    };
    let entering = openings.iter().map(|opening| match opening.end {
        VesselSide::Start => inflow(&opening.condition),
        VesselSide::End => -inflow(&opening.condition),
    });
    let shares = conditions().map(|condition| match condition {
        Condition::FlowSplit(share) => *share,
        _ => 0.0,
    });
    let flow = entering.sum::<f64>() * (1.0 - shares.sum::<f64>());
    // Each opening takes (p - base)/resistance.
    let taken = |(condition, stored): (&Condition, &f64)| match condition {
        Condition::Pressure(model) => Some(match model.distal {
            Some((resistance, compliance)) => {
                let store = compliance / step;
                let whole = 1.0 / (store + 1.0 / resistance);
                (store * whole * stored, model.proximal + whole)
            }
            None => (model.downstream.pressure(time), model.proximal),
        }),
        _ => None,
    };
    let takers: Vec<Option<(f64, f64)>> = conditions().zip(&*stored).map(taken).collect();
    let given = takers
        .iter()
        .flatten()
        .find(|(_, resistance)| *resistance == 0.0);
    let pressure = match given {
        Some((pressure, _)) => *pressure,
        None => {
            let all = || takers.iter().flatten().chain(&wall);
            let base: f64 = all().map(|(base, r)| base / r).sum();
            let conductance: f64 = all().map(|(_, r)| 1.0 / r).sum();
            (flow + base) / conductance
        }
    };
    for ((condition, stored), taker) in conditions().zip(stored).zip(&takers) {
        if let (Condition::Pressure(PressureModel { proximal, .. }), Some((base, resistance))) =
            (condition, taker)
        {
            *stored = pressure - proximal * (pressure - base) / resistance.max(f64::MIN_POSITIVE);
        }
    }
    pressure
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two windkessels side by side make the pressures of one with half their resistances and twice their compliance,
    /// also downstream of an elastic wall.
    #[test]
    fn windkessels_side_by_side_are_one() {
        let windkessel = "condition = \"windkessel\"\nproximal_resistance_Pa_s_m3 = 2e8\nresistance_Pa_s_m3 = 3.8e9\n\
                          compliance_m3_Pa = 2.5e-10\ninitial_pressure_Pa = 3e3\n";
        let line = "points_m = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]]\nradii_m = [0.003, 0.003]\n";
        let text = format!(
            "[[line]]\nname = \"left\"\n{line}[[line]]\nname = \"right\"\n{line}[[opening]]\nname = \"inlet\"\n\
             condition = \"flow\"\nbase_m3_s = 1e-6\namplitude_m3_s = 4e-6\nsystole_s = 0.4\n[[opening]]\n\
             name = \"left\"\n{windkessel}[[opening]]\nname = \"right\"\n{windkessel}"
        );
        let tree: TreeKeys = toml::from_str(&text).unwrap();
        let openings = tree.openings(0.9).unwrap();
        let Condition::Flow(curve, _) = &openings[0].condition else {
            panic!("{openings:?}")
        };
        for vessel in [0.0, 2e-10] {
            let found = Pressures::expected_in_tree(&tree, 0.9, vessel).unwrap();
            let both = ThreeElements {
                proximal: 1e8,
                resistance: 1.9e9,
                compliance: 5e-10,
                vessel,
            };
            let whole = both.pressures(curve);
            let pairs = [
                (found.mean, whole.mean),
                (found.lowest, whole.lowest),
                (found.highest, whole.highest),
            ];
            for (a, b) in pairs {
                assert!((a / b - 1.0).abs() < 5e-4, "{found:?} {whole:?}");
            }
        }
    }
}
