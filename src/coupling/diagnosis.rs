//! Words for a step that converges slowly or not at all: what was seen, and what to try.

use super::{CouplingError, FailedStep, Iteration};
use crate::geometry::CentreShift;
use crate::pfem::SolidError;

/// A residual that in the last third of the iterations stays within this factor stagnates.
const STAGNATION: f64 = 3.0;
/// A change this many times as large as the one before is a jump.
const JUMP: f64 = 10.0;
/// A residual that had fallen this far below the first, and that rose by as much of it again, met the accuracy of the
/// solvers.
const REBOUND: f64 = 1e3;
/// From this many times a change of the displacement on that comes back from the solvers, the blood's added mass is
/// what keeps the iteration from converging.
const HEAVY: f64 = 10.0;
/// A run is slow with more than this many iterations per step ...
const TIRING: f64 = 8.0;
/// ... over this many steps.
const LONG: usize = 20;
/// A step is slow with more than this many iterations ...
const MANY: usize = 12;
/// ... and this many times the usual number.
const SLOW: f64 = 3.0;

/// What keeps an iteration from converging.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Obstacle {
    /// A change of the displacement comes back so many times as large.
    AddedMass { times: f64 },
    /// It had fallen to this, m, and rose again.
    Rebounds { smallest: f64 },
    /// The residual is larger than at the beginning.
    Grows,
    /// It does not fall any more; whether the fluid used all the correctors that it may.
    Stagnates { fluid_at_its_limit: bool },
    /// The trial leapt in this iteration by this share of the displacement.
    Jumps { iteration: usize, change: f64 },
    /// So many columns were dropped, and so many left.
    ForgetsColumns { dropped: usize, left: usize },
    /// Nothing of that.
    FallsSlowly,
}

impl Obstacle {
    /// Everything that is true of these iterations, the gravest first.
    fn all(iterations: &[Iteration], max_sweeps: u32) -> Vec<Self> {
        let mut found = Vec::new();
        let residual = |i: &Iteration| i.measure.residual_rms;
        let length = iterations.len();
        let tail = &iterations[length - length.div_ceil(3).max(3).min(length)..];
        let low = tail.iter().map(residual).fold(f64::INFINITY, f64::min);
        let high = tail.iter().map(residual).fold(0.0, f64::max);
        let (Some(first), Some(last)) = (iterations.first(), iterations.last()) else {
            return found;
        };
        let times = returned(iterations);
        if times > HEAVY {
            found.push(Self::AddedMass { times });
        }
        let smallest = iterations
            .iter()
            .map(residual)
            .fold(f64::INFINITY, f64::min);
        let rebounds = residual(first) > REBOUND * smallest && residual(last) > REBOUND * smallest;
        if rebounds {
            found.push(Self::Rebounds { smallest });
        }
        let grows = residual(last).is_nan() || residual(last) > JUMP * residual(first);
        if grows {
            found.push(Self::Grows);
        } else if length > 3 && high < STAGNATION * low {
            found.push(Self::Stagnates {
                fluid_at_its_limit: tail.iter().all(|i| i.fluid_cost.sweeps >= max_sweeps),
            });
        }
        let jump = iterations.windows(2).find(|pair| {
            let [before, now] = [&pair[0], &pair[1]].map(|i| i.measure.change);
            now > 1.0 && now > JUMP * before
        });
        if let Some([_, at]) = jump {
            found.push(Self::Jumps {
                iteration: at.number,
                change: at.measure.change,
            });
        }
        // Columns made of noise are rightly dropped.
        if last.dropped > last.columns && !rebounds {
            found.push(Self::ForgetsColumns {
                dropped: last.dropped,
                left: last.columns,
            });
        }
        if found.is_empty() {
            found.push(Self::FallsSlowly);
        }
        found
    }

    /// What was seen, and what to try.
    fn advice(self) -> String {
        match self {
            Self::AddedMass { times } => format!(
                "a change of the displacement came back {times:.0} times as large, so the blood's added mass is what makes it hard; smaller steps make it \
                 worse, by their square: try a larger time.step_s, or coupling.surrogate = \"tube\" where it is \"none\""
            ),
            Self::Rebounds { smallest } => format!(
                "the residual had fallen to {smallest:.1e} m and rose again, since below that the solvers' answers are noise; try a larger \
                 coupling.e_rel, or a smaller fluid.pressure_residual and structure.newton_tolerance"
            ),
            Self::Grows => {
                "the residual grows; try a smaller coupling.relaxation, or coupling.acceleration = \"iqn_ls\"".into()
            }
            Self::Stagnates {
                fluid_at_its_limit: true,
            } => {
                "the residual stagnates while the fluid uses all its correctors, so the fluid's answers are not accurate enough; try a larger fluid.max_correctors".into()
            }
            Self::Stagnates {
                fluid_at_its_limit: false,
            } => {
                "the residual stagnates, which points to the tolerances of the solvers; try a smaller fluid.pressure_residual or structure.newton_tolerance".into()
            }
            Self::Jumps { iteration, change } => format!(
                "in iteration {iteration} the trial jumped by {change:.1e} of the displacement; try coupling.predictor = \"constant\", or a smaller coupling.reuse_steps"
            ),
            Self::ForgetsColumns { dropped, left } => format!(
                "{dropped} columns were dropped as dependent and {left} are left; try a smaller coupling.filter"
            ),
            Self::FallsSlowly => {
                "the residual falls slowly; try a larger coupling.reuse_steps or coupling.max_iterations".into()
            }
        }
    }
}

/// How many times as large as a change of the displacement the solvers' answer was at most: what it added to the
/// residual, at least.
fn returned(iterations: &[Iteration]) -> f64 {
    let pairs = iterations.windows(2);
    let times = pairs.map(|pair| {
        let [before, now] = [&pair[0], &pair[1]].map(|i| i.measure.residual_rms);
        (now - before).abs() / pair[0].measure.change_rms
    });
    times.filter(|times| times.is_finite()).fold(0.0, f64::max)
}

/// Says in words how a step failed to converge, and what to try. The fluid may spend `max_sweeps` an iteration.
pub fn diagnosis(iterations: &[Iteration], max_sweeps: u32) -> String {
    let (Some(first), Some(last)) = (iterations.first(), iterations.last()) else {
        return "no iteration was allowed; raise coupling.max_iterations".into();
    };
    let residuals = iterations.iter().map(|i| i.measure.residual_rms);
    format!(
        "residual {:.2e} m after {} iterations, {:.2e} m at the first (smallest {:.2e} m), change {:.2e} of the displacement: {}",
        last.measure.residual_rms,
        iterations.len(),
        first.measure.residual_rms,
        residuals.fold(f64::INFINITY, f64::min),
        last.measure.change,
        advice(iterations, max_sweeps)
    )
}

fn advice(iterations: &[Iteration], max_sweeps: u32) -> String {
    let found = Obstacle::all(iterations, max_sweeps).into_iter();
    found.map(Obstacle::advice).collect::<Vec<_>>().join("; ")
}

/// Why an accepted step was slow, if it took many more iterations than the `usual` number.
pub fn slowness(iterations: &[Iteration], usual: f64, max_sweeps: u32) -> Option<String> {
    let count = iterations.len();
    let slow = count > MANY && count as f64 > SLOW * usual;
    slow.then(|| {
        format!(
            "{count} coupling iterations, {usual:.1} are usual: {}",
            advice(iterations, max_sweeps)
        )
    })
}

/// What to try if a run of so many steps has needed so many iterations, many for long: said after 20 steps, and after
/// 40, 80, ...
pub fn tiring(
    steps: usize,
    coupling_iterations: usize,
    last: &[Iteration],
    max_sweeps: u32,
) -> Option<String> {
    let mean = coupling_iterations as f64 / steps as f64;
    let doublings = steps / LONG;
    let is_due = steps.is_multiple_of(LONG) && doublings.is_power_of_two();
    (is_due && mean > TIRING).then(|| {
        format!(
            "{mean:.1} coupling iterations per step over {steps} steps: {}",
            advice(last, max_sweeps)
        )
    })
}

/// Why a step failed. That the wall has moved sideways comes first, since whatever fails then, and what would help
/// against that alone, is only its consequence.
pub fn failure(failed: &FailedStep) -> String {
    let FailedStep {
        iterations, error, ..
    } = failed;
    match failed.centre_shift.as_deref() {
        Some(seen) if seen.is_large() => {
            format!("{}; then {}", moved_sideways(seen), consequence(failed))
        }
        _ => format!("{error}{}", circumstances(error, iterations)),
    }
}

/// What had happened before the structure failed, to be added to its error.
fn circumstances(error: &CouplingError, iterations: &[Iteration]) -> String {
    match (error, iterations.last()) {
        (CouplingError::Solid(_), None) => {
            " (in coupling iteration 1: the load on the predicted displacement is too much; try coupling.predictor = \"constant\" or a smaller time.step_s)".into()
        }
        (CouplingError::Solid(_), Some(last)) => format!(
            " (in coupling iteration {}, for a trial that had changed by {:.1e} of the displacement; try a smaller coupling.relaxation{})",
            last.number + 1,
            last.measure.change,
            // Smaller steps make the added mass heavier.
            if returned(iterations) > HEAVY { "" } else { " or time.step_s" }
        ),
        _ => String::new(),
    }
}

/// That the wall has moved sideways, and what usually helps.
fn moved_sideways(seen: &CentreShift) -> String {
    let mm = |metres: f64| 1e3 * metres;
    format!(
        "the wall has moved sideways, as a tube held at both ends does when it buckles under pressure: at ({:.1}, {:.1}, {:.1}) mm the centre of its cross-section lies {:.2} mm from where it was, {:.1} times the radius, of {:.2} mm that any point has moved. Smaller steps do not help; what holds arteries straight is axial prestretch and support by the tissue around them, else a thicker or shorter wall or less pressure helps (docs/limitations.md, \"Lateral buckling\"; `fsi-driver check DIR --wall` finds the pressure)",
        mm(seen.centre.x),
        mm(seen.centre.y),
        mm(seen.centre.z),
        mm(seen.shift),
        seen.shift / seen.radius,
        mm(seen.largest_displacement)
    )
}

/// What failed after the wall had moved sideways, without advice that would be in vain.
fn consequence(failed: &FailedStep) -> String {
    let iteration = failed.iterations.len() + 1;
    match &failed.error {
        CouplingError::Solid(SolidError::Inverted { element, .. }) => {
            format!("element {element} turned inside out in coupling iteration {iteration}")
        }
        CouplingError::Solid(_) => {
            format!("the structure found no equilibrium in coupling iteration {iteration}")
        }
        CouplingError::NotConverged(_) => {
            format!("{} coupling iterations did not converge", iteration - 1)
        }
        CouplingError::Fluid(error) => error.to_string(),
        CouplingError::Refused(refusal) | CouplingError::RefusedTooLate(refusal) => {
            refusal.to_string()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::acceptance::Limits;
    use super::super::convergence::ResidualMeasure;
    use super::*;
    use crate::fluid::{FluidCost, FluidError};

    /// Iterations with these residuals (m), which are changes of the displacement as well.
    fn iterations(residuals: &[f64]) -> Vec<Iteration> {
        let iteration = |(k, &residual): (usize, &f64)| Iteration {
            number: k + 1,
            measure: ResidualMeasure {
                change: residual,
                change_rms: residual,
                residual,
                residual_rms: residual,
                converged: false,
            },
            columns: k,
            dropped: 0,
            fluid_cost: FluidCost {
                sweeps: 2,
                residual: 1e-3,
            },
            force_mismatch: 0.0,
            fluid_seconds: 0.0,
            structure_seconds: 0.0,
            coupling_seconds: 0.0,
        };
        residuals.iter().enumerate().map(iteration).collect()
    }

    /// Correctors beyond their Courant number: what each coupling iteration left was more than the one before.
    #[test]
    fn sweeps_that_diverge_are_seen_before_the_wall_breaks() {
        let limits = Limits::of_any_liquid(1060.0, 1e-2);
        let judged = |left: &[f64], changes: f64| {
            let mut done = iterations(&vec![changes; left.len()]);
            for (iteration, &residual) in done.iter_mut().zip(left) {
                iteration.fluid_cost.residual = residual;
            }
            limits.of_iterations(&done, 2)
        };
        let seen = [0.038, 0.020, 0.021, 0.032, 0.049, 0.076, 0.116];
        assert_eq!(judged(&seen[..6], 1e-3), Ok(()));
        let refusal = judged(&seen, 1e-3).unwrap_err();
        assert!(refusal.to_string().contains("time.step_s"), "{refusal}");
        assert_eq!(judged(&seen, 0.1), Ok(()), "the wall moves");
        assert_eq!(judged(&seen.map(|r| 0.1 * r), 1e-3), Ok(()), "small");
        let mut saw = seen;
        saw[5] = 0.05;
        assert_eq!(judged(&saw, 1e-3), Ok(()), "not always");
    }

    fn says(iterations: &[Iteration], words: &str) {
        let text = diagnosis(iterations, 3);
        assert!(text.contains(words), "{text}");
    }

    #[test]
    fn every_cause_has_its_words_and_names_a_key() {
        says(&[], "coupling.max_iterations");
        says(&iterations(&[1e-3, 1e-2, 1e-1]), "coupling.relaxation");
        says(&iterations(&[1e-3, 1e-2, f64::NAN]), "the residual grows");
        says(
            &iterations(&[1e-1, 5e-2, 2e-2, 1e-2]),
            "coupling.reuse_steps",
        );

        let mut stuck = iterations(&[1e-1, 1e-3, 1e-6, 1.1e-6, 1e-6, 1.2e-6]);
        says(&stuck, "structure.newton_tolerance");
        stuck.iter_mut().for_each(|i| i.fluid_cost.sweeps = 3);
        says(&stuck, "fluid.max_correctors");

        let jump = iterations(&[1e-1, 1e-2, 5.0, 1e-2, 1e-4, 1e-7]);
        says(&jump, "in iteration 3 the trial jumped by 5.0e0");

        let mut rebounding = iterations(&[1e-1, 1e-3, 1e-9, 1e-5]);
        rebounding[3].dropped = 5;
        says(&rebounding, "had fallen to 1.0e-9 m and rose again");
        assert!(!diagnosis(&rebounding, 3).contains("coupling.filter"));

        let mut forgetful = iterations(&[1e-1, 5e-2, 2e-2, 1e-2]);
        (forgetful[3].columns, forgetful[3].dropped) = (2, 5);
        says(&forgetful, "5 columns were dropped");
    }

    #[test]
    fn added_mass_asks_for_larger_steps_never_for_smaller_ones() {
        let mut heavy = iterations(&[1e-6, 4.1e-5, 2e-5, 3e-5]);
        heavy.iter_mut().for_each(|i| i.measure.change_rms = 1e-6);
        says(&heavy, "came back 40 times as large");
        says(&heavy, "try a larger time.step_s");
        for light in [&heavy[..1], &iterations(&[1e-1, 5e-2, 2e-2, 1e-2])] {
            assert!(!diagnosis(light, 3).contains("time.step_s"));
        }
    }

    #[test]
    fn a_run_that_takes_many_iterations_for_long_says_what_to_try() {
        let last = iterations(&[1e-1, 5e-2, 2e-2, 1e-2]);
        let said = |steps, all| tiring(steps, all, &last, 3);
        let text = said(20, 180).unwrap();
        assert!(
            text.starts_with("9.0 coupling iterations per step over 20 steps: "),
            "{text}"
        );
        assert!(text.contains("try "), "{text}");
        assert!(said(20, 160).is_none() && said(19, 190).is_none());
        let due: Vec<usize> = (1..=200)
            .filter(|&steps| said(steps, 9 * steps).is_some())
            .collect();
        assert_eq!(due, [20, 40, 80, 160]);
    }

    #[test]
    fn a_step_is_slow_by_comparison() {
        let many = iterations(&[1e-1; 13]);
        assert!(slowness(&many, 6.0, 3).is_none());
        assert!(slowness(&many[..12], 2.0, 3).is_none());
        let text = slowness(&many, 4.0, 3).unwrap();
        assert!(text.starts_with("13 coupling iterations, 4.0 are usual: the residual stagnates"));
    }

    #[test]
    fn the_structures_error_names_iteration_and_trial() {
        let error = CouplingError::Solid(SolidError::Inverted {
            element: 7,
            jacobian: -0.1,
            position: [0.0; 3],
        });
        let failed = super::super::FailedStep {
            iterations: iterations(&[0.5]),
            centre_shift: None,
            error,
        };
        let text = failed.to_string();
        assert!(
            text.contains("element 7") && text.contains("coupling iteration 2"),
            "{text}"
        );
        assert!(!text.contains("aside"), "{text}");
    }

    #[test]
    fn a_wall_that_has_moved_sideways_is_reported_as_buckled() {
        let failed = |shift, error| {
            let failed = FailedStep {
                iterations: iterations(&[0.5, 0.1]),
                centre_shift: Some(Box::new(CentreShift {
                    centre: crate::Vec3::new(0.045, 0.0, 0.0),
                    shift,
                    radius: 2e-3,
                    largest_displacement: 1.03e-2,
                })),
                error,
            };
            failed.to_string()
        };
        let no_equilibrium =
            || CouplingError::Solid(SolidError::NoEquilibrium("take smaller steps".into()));
        let text = failed(9.9e-3, no_equilibrium());
        for words in [
            "the wall has moved sideways",
            "at (45.0, 0.0, 0.0) mm",
            "lies 9.90 mm from where it was, 5.0 times the radius",
            "axial prestretch",
            "support by the tissue",
            "; then the structure found no equilibrium in coupling iteration 3",
        ] {
            assert!(text.contains(words), "{text}");
        }
        for advice in ["take smaller steps", "time.step_s", "coupling.relaxation"] {
            assert!(!text.contains(advice), "{text}");
        }
        let little = failed(4e-3, no_equilibrium());
        assert!(!little.contains("aside") && little.contains("time.step_s"));

        let inverted = SolidError::Inverted {
            element: 7,
            jacobian: -0.1,
            position: [0.0; 3],
        };
        let dead = FluidError::Died("the last lines of its log".into());
        for (error, end) in [
            (
                CouplingError::Solid(inverted),
                "; then element 7 turned inside out in coupling iteration 3",
            ),
            (
                CouplingError::NotConverged("try".into()),
                "; then 2 coupling iterations did not converge",
            ),
            (
                CouplingError::Fluid(dead),
                "; then the last lines of its log",
            ),
        ] {
            let text = failed(9.9e-3, error);
            assert!(text.ends_with(end), "{text}");
        }
    }
}
