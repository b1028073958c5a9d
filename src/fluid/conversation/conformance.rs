//! Plays the driver to a fluid solver and looks whether it keeps to `of-adapter/PROTOCOL.md`.
//!
//! Every check has processes of its own, so that one mistake does not hide the next. The wall is bulged a little, with
//! its rim held, which is enough to tell the direction of normals, volumes, the conservation of mass, and whether a
//! repeated trial is the same trial.

use super::protocol::{FRAME_SIZE, MessageKind, ToFluid, message};
use super::session::Session;
use super::transport::{Patience, TransportError};
use crate::Vec3;
use crate::fluid::external::{ExternalFluid, ExternalSettings};
use crate::fluid::{Fluid, FluidEffort, FluidError, FluidInterface, FluidStep, FluidTrial, Wanted};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::time::Duration;

/// The wall moves by this share of the smallest extent of its points in a step.
const BULGE: f64 = 2e-3;
/// A wild trial moves it by so many times that.
const WILD: f64 = 20.0;
/// Answers that should be the same may differ by this share of the largest of their components.
const SAME: f64 = 1e-12;
/// Volumes and flows may differ by this share.
const ALIKE: f64 = 0.02;
/// A solver ends within this time when it should.
const END_LIMIT: Duration = Duration::from_secs(10);

/// What came of a check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RuleFinding {
    /// What was looked at.
    pub what: String,
    /// What was found: as it should be, or not.
    pub found: Result<String, String>,
}

/// Checks a solver; `tell` hears each finding as it is made.
///
/// # Errors
/// [`FluidError::Interrupted`] if the user ended it; whatever else goes wrong is a finding.
pub fn examine(
    settings: &ExternalSettings,
    tell: &mut dyn FnMut(&RuleFinding),
) -> Result<Vec<RuleFinding>, FluidError> {
    let mut examination = Examination {
        settings,
        tell,
        findings: Vec::new(),
    };
    examination.conversation()?;
    if examination.findings.iter().all(|f| f.found.is_ok()) {
        examination.hostile_driver()?;
    }
    Ok(examination.findings)
}

struct Examination<'a> {
    settings: &'a ExternalSettings,
    tell: &'a mut dyn FnMut(&RuleFinding),
    findings: Vec<RuleFinding>,
}

/// What ends an examination early: a finding has been made of it, or the user has.
enum EarlyEnd {
    Found,
    Interrupted,
}

impl Examination<'_> {
    fn note(&mut self, what: &str, found: Result<String, String>) {
        let finding = RuleFinding {
            what: what.to_owned(),
            found,
        };
        (self.tell)(&finding);
        self.findings.push(finding);
    }

    /// A value that the solver should have given.
    fn get<T>(&mut self, what: &str, result: Result<T, FluidError>) -> Result<T, EarlyEnd> {
        match result {
            Ok(value) => Ok(value),
            Err(FluidError::Interrupted) => Err(EarlyEnd::Interrupted),
            Err(error) => {
                self.note(what, Err(error.to_string()));
                Err(EarlyEnd::Found)
            }
        }
    }

    fn start(&self) -> Result<ExternalFluid, FluidError> {
        ExternalFluid::start(self.settings.clone(), None)
    }

    /// Everything a run does.
    fn conversation(&mut self) -> Result<(), FluidError> {
        match self.run() {
            Err(EarlyEnd::Interrupted) => Err(FluidError::Interrupted),
            Ok(()) | Err(EarlyEnd::Found) => Ok(()),
        }
    }

    fn run(&mut self) -> Result<(), EarlyEnd> {
        let mut fluid = self.introduction()?;
        let bulge = bulge(fluid.interface());
        self.trials(&mut fluid, &bulge)?;
        self.first_step(&mut fluid, &bulge)?;
        self.restart(fluid, &bulge)
    }

    /// It starts with a wall that makes sense.
    fn introduction(&mut self) -> Result<ExternalFluid, EarlyEnd> {
        let what = "it starts and introduces itself";
        let started = self.start();
        let fluid = self.get(what, started)?;
        let wall = fluid.interface();
        self.note(
            what,
            Ok(format!(
                "{} points, {} faces, {:.4e} m³ ({:.4e} of them rigid)",
                wall.points.len(),
                wall.faces.len(),
                fluid.volumes()[0],
                fluid.volumes()[1]
            )),
        );
        self.note(
            "the centres of faces lie between their points",
            centres(wall),
        );
        Ok(fluid)
    }

    /// Trials from the old state, of several displacements and lengths of the step; the last one is as the first.
    fn trials(&mut self, fluid: &mut ExternalFluid, bulge: &[Vec3]) -> Result<(), EarlyEnd> {
        let dt = self.settings.time_step;
        let what = "it answers trials";
        let first = ask(fluid, bulge, dt, true);
        let first = self.get(what, first)?;
        let strayed = ask(fluid, &scaled(bulge, WILD), dt, false);
        self.get(what, strayed)?;
        self.note(what, Ok(String::new()));
        let what = "from the old state it repeats a trial, whatever came between";
        let again = ask(fluid, bulge, dt, true);
        let again = self.get(what, again)?;
        self.note(what, same(&first.tractions, &again.tractions));
        let what = "from the old state a step may change its length";
        let half = ask(fluid, bulge, 0.5 * dt, true);
        self.get(what, half)?;
        let whole = ask(fluid, bulge, dt, true);
        let whole = self.get(what, whole)?;
        self.note(what, same(&first.tractions, &whole.tractions));
        Ok(())
    }

    /// A step that is kept: what it says of volumes and flows goes together with the motion of the wall.
    fn first_step(&mut self, fluid: &mut ExternalFluid, bulge: &[Vec3]) -> Result<(), EarlyEnd> {
        let dt = self.settings.time_step;
        let before = fluid.volumes()[0];
        let what = "it accepts a step";
        let accepted = fluid.accept(Wanted::default());
        let step = self.get(what, accepted)?;
        self.note(what, report(&step, dt));
        let wall = fluid.interface();
        let at_rest = vec![Vec3::zeros(); bulge.len()];
        let grown = volume_below(wall, bulge) - volume_below(wall, &at_rest);
        self.note(
            "its volume grows as the wall moves outwards",
            alike(step.volume - before, grown, "m³"),
        );
        self.note(
            "what flows in stays or flows out",
            alike(
                step.openings.iter().map(|opening| opening.flow).sum(),
                grown / dt,
                "m³/s",
            ),
        );
        Ok(())
    }

    /// A second step that is kept, and a third one that is repeated after a restart.
    fn restart(&mut self, mut fluid: ExternalFluid, bulge: &[Vec3]) -> Result<(), EarlyEnd> {
        let dt = self.settings.time_step;
        let what = "it gives its state when it is asked to";
        let solved = ask(&mut fluid, &scaled(bulge, 1.5), dt, false);
        self.get(what, solved)?;
        let state = Wanted {
            state: true,
            field: false,
        };
        let accepted = fluid.accept(state);
        self.get(what, accepted)?;
        let memory = fluid.memory(&|_| true);
        let memory = self.get(what, memory)?;
        self.note(what, Ok(format!("{} bytes", memory.state.len())));
        let third = scaled(bulge, 1.2);
        let what = "it continues after a restart from that state, to the last digit";
        let straight = ask(&mut fluid, &third, dt, true).and_then(|t| Ok((t, finish(&mut fluid)?)));
        let (straight, end) = self.get(what, straight)?;
        let discarded = fluid.memory(&|_| false);
        self.get("it takes DISCARD", discarded)?;
        let after = ask(&mut fluid, &third, dt, true);
        self.get("it takes DISCARD", after)?;
        self.note("it takes DISCARD", Ok(String::new()));
        let ended = fluid.end(END_LIMIT);
        self.note("after STOP it ends with exit code 0", ended);

        let resumed = ExternalFluid::start(self.settings.clone(), Some(&memory));
        let mut fluid = self.get(what, resumed)?;
        let resumed = ask(&mut fluid, &third, dt, true).and_then(|t| Ok((t, finish(&mut fluid)?)));
        let (resumed, its_end) = self.get(what, resumed)?;
        let answers = same(&straight.tractions, &resumed.tractions);
        let whole = answers.and_then(|text| match its_end == end {
            true => Ok(text),
            false => Err(format!(
                "it reported {end:?}, after the restart {its_end:?}"
            )),
        });
        self.note(what, whole);
        Ok(())
    }

    /// Drivers that say what they must not say, or go.
    fn hostile_driver(&mut self) -> Result<(), FluidError> {
        let fluid = self.start()?;
        let points = fluid.interface().points.len();
        drop(fluid);
        let dt = self.settings.time_step;
        let still = vec![Vec3::zeros(); points];
        let mut not_finite = still.clone();
        not_finite[points / 2].y = f64::NAN;
        let solve = |displacement: &[Vec3], time_step| {
            ToFluid::Solve {
                max_correctors: 1,
                from_old_state: false,
                pressure_residual: 1e-2,
                time_step,
                displacement,
            }
            .encode()
        };
        let good = solve(&still, dt);
        let with = |at: usize, byte: u8| {
            let mut bytes = good.clone();
            bytes[at] = byte;
            bytes
        };
        let accept = ToFluid::Accept { write: false }.encode();
        let attacks: [(&str, Vec<u8>); 11] = [
            (
                "bytes that are not a message",
                b"GET / HTTP/1.1\r\n\r\n".to_vec(),
            ),
            ("another version", with(4, 77)),
            ("an unknown kind", with(6, 77)),
            ("a promise of 2⁶² bytes", with(15, 0x40)),
            ("a SOLVE for another wall", solve(&still[1..], dt)),
            ("a displacement that is not finite", solve(&not_finite, dt)),
            ("a time step below zero", solve(&still, -dt)),
            ("flags that nobody knows", with(FRAME_SIZE + 4, 0x80)),
            ("ACCEPT between two steps", accept),
            ("a HELLO", message(MessageKind::Hello, &[0; 48])),
            ("FAILURE", ToFluid::Failure("the test is over").encode()),
        ];
        for (name, bytes) in &attacks {
            self.attack(&format!("it ends after {name}"), |session, patience| {
                session.send_anything(bytes, patience)
            })?;
        }
        self.attack("it ends when the driver disconnects", |session, _| {
            session.disconnect();
            Ok(())
        })
    }

    fn attack(
        &mut self,
        what: &str,
        fault: impl FnOnce(&mut Session, &mut Patience) -> Result<(), TransportError>,
    ) -> Result<(), FluidError> {
        let found = match self.start() {
            Err(FluidError::Interrupted) => return Err(FluidError::Interrupted),
            Err(error) => Err(error.to_string()),
            Ok(mut fluid) => fluid.inject_fault(fault, END_LIMIT),
        };
        self.note(what, found);
        Ok(())
    }
}

fn ask(
    fluid: &mut ExternalFluid,
    displacement: &[Vec3],
    time_step: f64,
    from_old_state: bool,
) -> Result<FluidTrial, FluidError> {
    let effort = FluidEffort {
        max_sweeps: 1000,
        residual: 1e-6,
        from_old_state,
    };
    fluid.solve(displacement, time_step, effort)
}

fn finish(fluid: &mut ExternalFluid) -> Result<FluidStep, FluidError> {
    Ok(fluid.accept(Wanted::default())?.without_costs())
}

/// A smooth displacement outwards of points that keeps the rim of the surface.
fn bulge(wall: &FluidInterface) -> Vec<Vec3> {
    let mut normals = vec![Vec3::zeros(); wall.points.len()];
    let mut neighbours = vec![Vec::new(); wall.points.len()];
    let mut faces_at: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for face in &wall.faces {
        let area = area_vector(face, &wall.points);
        for (k, &a) in face.iter().enumerate() {
            let b = face[(k + 1) % face.len()];
            normals[a as usize] += area;
            neighbours[a as usize].push(b as usize);
            neighbours[b as usize].push(a as usize);
            *faces_at.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    let rim = faces_at.iter().filter(|(_, faces)| **faces == 1);
    let mut front: Vec<usize> = rim.flat_map(|(edge, _)| edge.map(|i| i as usize)).collect();
    let mut distance = vec![usize::MAX; wall.points.len()];
    front.iter().for_each(|&i| distance[i] = 0);
    let mut steps = 0;
    while !front.is_empty() {
        steps += 1;
        let mut next = Vec::new();
        for &j in front.iter().flat_map(|&i| &neighbours[i]) {
            if distance[j] == usize::MAX {
                distance[j] = steps;
                next.push(j);
            }
        }
        front = next;
    }
    let farthest = distance.iter().filter(|d| **d != usize::MAX).max();
    let farthest = farthest.copied().unwrap_or(0).max(1) as f64;
    let share = |d: usize| match d {
        usize::MAX => 1.0, // a closed surface has no rim
        d => (FRAC_PI_2 * d as f64 / farthest).sin().powi(2),
    };
    let extent = (0..3).map(|d| {
        let x = || wall.points.iter().map(|x| x[d]);
        x().fold(f64::MIN, f64::max) - x().fold(f64::MAX, f64::min)
    });
    let size = BULGE * extent.filter(|e| *e > 0.0).fold(f64::MAX, f64::min);
    let outwards = normals.iter().zip(distance);
    outwards
        .map(|(n, d)| size * share(d) * n.try_normalize(0.0).unwrap_or_default())
        .collect()
}

fn area_vector(face: &[u32], points: &[Vec3]) -> Vec3 {
    let at = |k: usize| points[face[k % face.len()] as usize];
    let corners = 1..face.len() - 1;
    corners
        .map(|k| 0.5 * (at(k) - at(0)).cross(&(at(k + 1) - at(0))))
        .sum()
}

/// The volume between the displaced wall and any surface that its rim bounds, up to a constant, m³.
fn volume_below(wall: &FluidInterface, displacement: &[Vec3]) -> f64 {
    let moved: Vec<Vec3> = (wall.points.iter().zip(displacement))
        .map(|(x, u)| x + u)
        .collect();
    let of_face = |face: &Vec<u32>| -> f64 {
        let at = |k: usize| moved[face[k] as usize];
        let corners = 1..face.len() - 1;
        corners
            .map(|k| at(0).dot(&at(k).cross(&at(k + 1))) / 6.0)
            .sum()
    };
    wall.faces.iter().map(of_face).sum()
}

fn centres(wall: &FluidInterface) -> Result<String, String> {
    for (i, (face, centre)) in wall.faces.iter().zip(&wall.face_centres).enumerate() {
        let corners = face.iter().map(|&vertex| wall.points[vertex as usize]);
        let mean = corners.clone().sum::<Vec3>() / face.len() as f64;
        let size = corners.map(|x| (x - mean).norm()).fold(0.0, f64::max);
        if (centre - mean).norm() > 0.5 * size {
            return Err(format!(
                "that of face {i} is {:.2e} m from the middle of its points, which are {size:.2e} m away from there",
                (centre - mean).norm()
            ));
        }
    }
    Ok(String::new())
}

fn report(step: &FluidStep, time: f64) -> Result<String, String> {
    if (step.time - time).abs() > 1e-9 * time {
        return Err(format!("the time is {} s, expected {time} s", step.time));
    }
    let openings = step.openings.iter();
    let openings =
        openings.map(|o| format!("{} {:.3e} m³/s, {:.1} Pa", o.name, o.flow, o.mean_pressure));
    Ok(openings.collect::<Vec<_>>().join("; "))
}

fn scaled(displacement: &[Vec3], times: f64) -> Vec<Vec3> {
    displacement.iter().map(|u| times * u).collect()
}

fn same(first: &[Vec3], second: &[Vec3]) -> Result<String, String> {
    let largest = first
        .iter()
        .map(|t| t.amax())
        .fold(f64::MIN_POSITIVE, f64::max);
    let difference = (first.iter().zip(second)).map(|(a, b)| (a - b).amax());
    let difference = difference.fold(0.0, f64::max) / largest;
    let text = format!("tractions differ by {difference:.1e} of the largest");
    if difference <= SAME {
        Ok(text)
    } else {
        Err(text)
    }
}

fn alike(found: f64, expected: f64, unit: &str) -> Result<String, String> {
    let text = format!("{found:.4e} {unit}, expected {expected:.4e} {unit}");
    let is_alike = (found - expected).abs() <= ALIKE * expected.abs();
    if is_alike { Ok(text) } else { Err(text) }
}
