//! What a step is refused for, with a fluid in the driver's own process that answers wrongly.

use crate::coupling_loop::{Cushion, coupled};
use fsi_driver::Vec3;
use fsi_driver::case::{Case, Preset};
use fsi_driver::coupling::acceptance::{Balance, Limits};
use fsi_driver::coupling::{Coupling, CouplingError, Step};
use fsi_driver::fluid::native::NativeFluid;
use fsi_driver::fluid::{
    Fluid, FluidEffort, FluidError, FluidInterface, FluidMemory, FluidStep, FluidTrial,
    OpeningReport, Wanted,
};
use fsi_driver::pfem::Structure;
use fsi_driver::simulation::assembly::{Domain, couple};
use std::path::Path;

/// Volume of the cushion's domain, m³, which does not change.
const VOLUME: f64 = 1.0;
const FLOW: f64 = 1e-5;

/// The cushion with something wrong in its answers or in its reports.
struct Wrong {
    fluid: Cushion,
    answer: fn(&mut FluidTrial),
    report: fn(&mut FluidStep),
}

impl Fluid for Wrong {
    fn interface(&self) -> &FluidInterface {
        self.fluid.interface()
    }

    fn solve(&mut self, d: &[Vec3], dt: f64, e: FluidEffort) -> Result<FluidTrial, FluidError> {
        let mut trial = self.fluid.solve(d, dt, e)?;
        (self.answer)(&mut trial);
        Ok(trial)
    }

    fn accept(&mut self, wanted: Wanted) -> Result<FluidStep, FluidError> {
        let mut step = self.fluid.accept(wanted)?;
        let opening = |name: &str, flow| OpeningReport {
            name: name.into(),
            flow,
            mean_pressure: 0.0,
            model_pressure: None,
        };
        step.openings = vec![opening("in", FLOW), opening("out", -FLOW)];
        step.volume = VOLUME;
        step.wall_shear = vec![Vec3::zeros(); self.interface().faces.len()];
        (self.report)(&mut step);
        Ok(step)
    }

    fn memory(&mut self, needed: &dyn Fn(f64) -> bool) -> Result<FluidMemory, FluidError> {
        self.fluid.memory(needed)
    }

    fn recall(&mut self, memory: &FluidMemory) -> Result<(), FluidError> {
        self.fluid.recall(memory)
    }
}

fn tube(answer: fn(&mut FluidTrial), report: fn(&mut FluidStep)) -> Coupling<Wrong, Structure> {
    let fluid = Cushion::new();
    let mut coupling = coupled(Wrong {
        fluid,
        answer,
        report,
    });
    coupling.balance = Balance::of(VOLUME);
    coupling.settings.limits = Limits {
        residual: 0.1,
        // Healthy: 1,056 Pa
        pressure: 2e3,
        flow: 1e-3,
        is_closed: true,
        is_elastic: true,
    };
    coupling
}

fn step(answer: fn(&mut FluidTrial), report: fn(&mut FluidStep)) -> Result<Step, CouplingError> {
    let mut coupling = tube(answer, report);
    coupling.step().map_err(|failed| failed.error)
}

/// The fluid still has the state before the step.
fn refused(answer: fn(&mut FluidTrial), words: &str) {
    match step(answer, |_| ()) {
        Err(CouplingError::Refused(refusal)) => {
            let text = refusal.to_string();
            assert!(text.contains(words), "{text}");
        }
        other => panic!("{words}: {other:?}"),
    }
}

/// The fluid has kept the step.
fn refused_too_late(report: fn(&mut FluidStep), words: &str) {
    match step(|_| (), report) {
        Err(CouplingError::RefusedTooLate(refusal)) => {
            let text = refusal.to_string();
            assert!(text.contains(words), "{text}");
        }
        other => panic!("{words}: {other:?}"),
    }
}

#[test]
fn a_wrong_answer_is_refused_before_the_fluid_keeps_it() {
    let healthy = step(|_| (), |_| ()).unwrap();
    assert_eq!(healthy.mass_lost, 0.0);
    let mismatch = healthy.iterations.last().unwrap().force_mismatch;
    assert!(mismatch < 5e-3, "{mismatch:e}");

    refused(
        |trial| trial.tractions[7].y = f64::NAN,
        "the load on the wall is non-finite at (2.083e-3,",
    );
    refused(
        |trial| trial.tractions[7].y = f64::INFINITY,
        "non-finite at (2.083e-3,",
    );
    refused(
        |trial| trial.cost.residual = 0.11,
        "began with a residual of 0.110, where 0.1 is accepted",
    );
    refused(|trial| trial.cost.residual = f64::NAN, "a residual of NaN");
    assert!(step(|trial| trial.cost.residual = 0.09, |_| ()).is_ok());
    refused(|trial| trial.tractions[7] *= 6.0, "Pa at (2.083e-3,");
}

/// All of the load on one face of many, which interpolation to the wall's points cannot carry.
#[test]
fn a_load_that_does_not_reach_the_wall_is_refused() {
    let concentrated = |trial: &mut FluidTrial| {
        for (face, traction) in trial.tractions.iter_mut().enumerate() {
            if face != 7 {
                traction.fill(0.0);
            }
        }
    };
    refused(
        concentrated,
        "13.0 % of the fluid's force does not reach the wall, where 1 % is accepted",
    );
    refused(concentrated, "within 3.63e-3 m of (3.472e-3,");
}

#[test]
fn an_impossible_report_is_refused_and_the_fluid_rewound() {
    refused_too_late(
        |step| step.openings[1].flow = -0.97 * FLOW,
        "the difference is 3.0 % of what goes through, where 2 % is accepted",
    );
    assert!(step(|_| (), |step| step.openings[1].flow = -0.99 * FLOW).is_ok());
    refused_too_late(
        |step| step.openings[1].flow = -733.0,
        "the flow is -7.33e2 m3/s at the opening out",
    );
    refused_too_late(
        |step| step.openings[0].mean_pressure = 7e34,
        "the pressure is 7.00e34 Pa at the opening in",
    );
    refused_too_late(
        |step| step.openings[0].flow = f64::NAN,
        "the flow is non-finite at the opening in",
    );
    refused_too_late(
        |step| step.wall_shear[7].x = 1e6,
        "the wall shear stress is 1.00e6 Pa at (2.083e-3,",
    );
    refused_too_late(|step| step.volume = f64::NAN, "the volume is non-finite");
}

#[test]
fn a_fluid_with_openings_that_are_not_known_need_not_balance() {
    let mut coupling = tube(|_| (), |step| step.openings[1].flow = 0.0);
    coupling.settings.limits.is_closed = false;
    coupling.step().unwrap();
}

/// A volume that grows faster and faster, with flows as second-order schemes have them.
#[test]
fn second_order_flows_may_differ_from_the_change() {
    let balanced = |flow: fn(f64) -> f64| {
        fn volume(t: f64) -> f64 {
            VOLUME + 1e-3 * t * t * t
        }
        let mut balance = Balance::of(VOLUME);
        let mut largest = 0.0_f64;
        for i in 1..40 {
            let t = 0.01 * f64::from(i);
            let opening = OpeningReport {
                name: "in".into(),
                // The first step of such a scheme is one of Euler's
                flow: match i {
                    1 => (volume(t) - VOLUME) / t,
                    _ => flow(t),
                },
                mean_pressure: 0.0,
                model_pressure: None,
            };
            let (next, lost) = balance.after(
                &FluidStep {
                    time: t,
                    openings: vec![opening],
                    volume: volume(t),
                    ..FluidStep::default()
                },
                0.01,
            );
            balance = next;
            largest = largest.max(lost);
        }
        largest
    };
    // d/dt of the volume at the end of each step, as BDF2 has it to second order
    assert_eq!(balanced(|t| 3e-3 * t * t), 0.0);
    // Half of it
    assert!(balanced(|t| 1.5e-3 * t * t) > 0.3);
}

/// The limits of a case, with few elements.
fn limits_of(case: &str) -> Limits {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(case);
    let few = [
        ("structure.p", "3"),
        ("fluid.native.degree", "3"),
        ("fluid.native.core", "1"),
        ("fluid.native.axial_per_section", "2"),
        ("coupling.surrogate", "none"),
    ];
    let few = few.map(|(key, value)| (key.into(), value.into()));
    let case = Case::load(&folder, Preset::Demo, &few).unwrap();
    let domain = Domain::new(&case).unwrap();
    let coupling = couple(&case, &domain, NativeFluid::new(&case).unwrap()).unwrap();
    coupling.settings.limits
}

#[test]
fn pressures_and_flows_are_limited_by_what_drives_them() {
    // 46 kPa of the windkessel at t = 0, 25 kPa that it takes for the largest flow, and what a start within a
    // step of 2 ms would take; the wall's largest load in a beat is 1.7e4 Pa, the largest flow 1.4e-5 m³/s.
    let vessel = limits_of("tests/cases/S-0.25");
    println!("{vessel:?}");
    assert!((8e6..1.4e7).contains(&vessel.pressure), "{vessel:?}");
    assert!((2e-4..1e-3).contains(&vessel.flow), "{vessel:?}");
    assert_eq!(vessel.residual, 0.05);

    // Its templates prescribe a pressure of which the case knows nothing.
    let tube = limits_of("openfoam-case/elastic-tube");
    assert_eq!((tube.pressure, tube.flow), (2.25e9, f64::INFINITY));
}
