//! Blood by a user-supplied solver: a program that speaks the protocol of `of-adapter/PROTOCOL.md`.
//!
//! It is started with the way to the driver in its environment ([`ExternalFluid::start`]), or waited for while the user
//! starts it elsewhere. Its state between two steps are the bytes that it hands over with ACCEPTED and gets back with
//! WELCOME.

use super::conversation::partner::{Beginning, Partner};
use super::conversation::session::{Session, Terms};
use super::conversation::transport::{Listener, Patience, TransportError};
use super::{
    Fluid, FluidEffort, FluidError, FluidInterface, FluidMemory, FluidStep, FluidTrial, FluidUsage,
    Wanted,
};
use crate::Vec3;
use crate::case::TransportKind;
use crate::files::write_atomically;
use rustix::process::Signal;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// In the fluid's folder: how to reach the driver, for a shell to read.
pub const CONNECTION: &str = "connection.env";
/// Likewise: the wet surface, for solvers without a mesh of their own.
pub const WALL: &str = "wall.obj";

/// Who starts the solver.
#[derive(Debug, Clone)]
pub enum Starter {
    /// The driver: a program and its arguments.
    Command(Vec<String>),
    /// The user; these words are printed when the driver waits for it.
    User(Option<fn(&str)>),
}

/// What is needed to start a solver, or to wait for it.
#[derive(Debug, Clone)]
pub struct ExternalSettings {
    /// Who starts it.
    pub starter: Starter,
    /// The folder that it works in, made if there is none.
    pub folder: PathBuf,
    /// File for its output.
    pub log: PathBuf,
    /// The case with all its values, for a solver that wants to read it.
    pub case_file: PathBuf,
    /// A mesh of the wet surface that the solver may take for its own.
    pub wall: FluidInterface,
    /// How driver and solver talk.
    pub transport: TransportKind,
    /// Longest time to wait for an answer, unless one has taken more than a fiftieth of it already.
    pub answer_limit: Duration,
    /// Time step, s, which the solver must confirm.
    pub time_step: f64,
    /// Ends every wait when set.
    pub interrupt: Arc<AtomicBool>,
}

/// Where a solver is between two steps.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct Resting {
    /// s
    time: f64,
    /// What it handed over; nothing at the beginning.
    state: Vec<u8>,
}

/// A solver that has been met.
pub struct ExternalFluid {
    settings: ExternalSettings,
    /// Where it started.
    begun: Resting,
    /// The last accepted step that it was asked to keep.
    kept: Option<Resting>,
    /// Its states that may still be needed.
    states: Vec<Resting>,
    /// What processes before this one have used.
    earlier: FluidUsage,
    partner: Partner,
}

impl ExternalFluid {
    /// Starts the solver, or waits for it, at rest or where it was when it gave `memory`. Call it from a thread that
    /// lives as long as the run.
    ///
    /// # Errors
    /// If it does not start, does not call, or is not the one that was expected.
    pub fn start(
        settings: ExternalSettings,
        memory: Option<&FluidMemory>,
    ) -> Result<Self, FluidError> {
        let begun = memory.map_or_else(|| Ok(Resting::default()), resting)?;
        Self::start_at(settings, begun, None)
    }

    fn start_at(
        settings: ExternalSettings,
        begun: Resting,
        interface: Option<FluidInterface>,
    ) -> Result<Self, FluidError> {
        std::fs::create_dir_all(&settings.folder).map_err(died)?;
        let listener = match settings.transport {
            TransportKind::Socket => Listener::socket(),
            TransportKind::Files => Listener::files(&settings.folder.join("exchange")),
        };
        let listener = listener.map_err(died)?;
        let way = way_to_the_driver(&settings, &begun, &listener).map_err(died)?;
        let wall = settings.folder.join(WALL);
        write_atomically(&wall, wavefront(&settings.wall).as_bytes()).map_err(died)?;
        let file = settings.folder.join(CONNECTION);
        write_atomically(&file, for_a_shell(&way).as_bytes()).map_err(died)?;
        let terms = Terms {
            start_time: begun.time,
            time_step: settings.time_step,
            interface,
        };
        let beginning = |name| Beginning {
            name,
            listener,
            terms: &terms,
            state: &begun.state,
            answer_limit: settings.answer_limit,
            interrupt: &settings.interrupt,
        };
        let partner = match &settings.starter {
            Starter::Command(words) => {
                let (program, arguments) =
                    (words.split_first()).ok_or_else(|| died("fluid.command names no program"))?;
                let mut command = Command::new(program);
                command.args(arguments).envs(way);
                command.current_dir(&settings.folder);
                let name = Path::new(program).file_name().unwrap_or_default();
                let name = name.to_string_lossy();
                Partner::start(beginning(&name), command, Signal::KILL, &settings.log)?
            }
            Starter::User(tell) => {
                if let Some(tell) = tell {
                    let file = std::path::absolute(&file).map_err(died)?;
                    tell(&format!(
                        "waiting for the fluid, from t = {} s; start it with what {} says in its environment",
                        begun.time,
                        file.display()
                    ));
                }
                Partner::wait_for(beginning("the fluid"))?
            }
        };
        Ok(Self {
            settings,
            begun,
            kept: None,
            states: Vec::new(),
            earlier: FluidUsage::default(),
            partner,
        })
    }

    /// From now on the solver's answers are waited for whatever happens to the interrupt.
    pub fn outlast_interrupts(&mut self) {
        self.settings.interrupt = Arc::default();
        self.partner.outlast_interrupts();
    }

    /// Tells the solver which of its states are no longer needed; one that cannot be reached is told another time.
    fn discard(&mut self, needed: &dyn Fn(f64) -> bool) {
        let partner = &mut self.partner;
        self.states.retain(|Resting { time, state }| {
            let mut is_told = || {
                partner
                    .talk(|session, patience| session.discard(state, patience))
                    .is_ok()
            };
            needed(*time) || !(state.is_empty() || is_told())
        });
    }

    fn usage(&self) -> FluidUsage {
        self.earlier.and(self.partner.usage())
    }

    /// Sends STOP and waits for the end of the process; what was found of it.
    pub(super) fn end(&mut self, limit: Duration) -> Result<String, String> {
        self.partner.end(limit)
    }

    /// Does something to the solver after which it must end, with an exit code that is not 0.
    pub(super) fn inject_fault(
        &mut self,
        fault: impl FnOnce(&mut Session, &mut Patience) -> Result<(), TransportError>,
        limit: Duration,
    ) -> Result<String, String> {
        self.partner.inject_fault(fault, limit)
    }

    /// Volumes at the start, m³: of the whole domain, and of the part of it whose wall is rigid.
    pub fn volumes(&self) -> [f64; 2] {
        self.partner.session().volumes()
    }
}

impl Fluid for ExternalFluid {
    fn interface(&self) -> &FluidInterface {
        self.partner.session().interface()
    }

    fn solve(
        &mut self,
        displacement: &[Vec3],
        time_step: f64,
        effort: FluidEffort,
    ) -> Result<FluidTrial, FluidError> {
        self.partner.solve(displacement, time_step, effort)
    }

    fn accept(&mut self, wanted: Wanted) -> Result<FluidStep, FluidError> {
        let write = wanted.anything();
        let mut accepted =
            (self.partner).talk(|session, patience| session.accept(write, patience))?;
        self.kept = write.then(|| Resting {
            time: accepted.time,
            state: std::mem::take(&mut accepted.state),
        });
        self.states.extend(self.kept.clone());
        Ok(FluidStep {
            usage: self.usage(),
            ..self.partner.session().step(accepted)
        })
    }

    fn memory(&mut self, needed: &dyn Fn(f64) -> bool) -> Result<FluidMemory, FluidError> {
        let resting = match &self.kept {
            Some(kept) if kept.state.is_empty() => {
                return Err(FluidError::Storage(format!(
                    "the fluid was asked to keep its state at t = {} s, but its ACCEPTED ends without one",
                    kept.time
                )));
            }
            Some(kept) => kept,
            None => &self.begun,
        };
        let state = postcard::to_stdvec(resting).map_err(|e| FluidError::Storage(e.to_string()))?;
        self.discard(needed);
        Ok(FluidMemory {
            state,
            files: Vec::new(),
        })
    }

    fn recall(&mut self, memory: &FluidMemory) -> Result<(), FluidError> {
        let resting = resting(memory)?;
        if !self.partner.is_at_work() && !self.partner.has_ended() && resting == self.begun {
            return Ok(());
        }
        let earlier = self.usage();
        self.partner.end_now();
        let interface = Some(self.interface().clone());
        let states = std::mem::take(&mut self.states);
        *self = Self::start_at(self.settings.clone(), resting, interface)?;
        (self.earlier, self.states) = (earlier, states);
        Ok(())
    }
}

/// The environment of the solver.
fn way_to_the_driver(
    settings: &ExternalSettings,
    begun: &Resting,
    listener: &Listener,
) -> std::io::Result<Vec<(&'static str, String)>> {
    let path =
        |path: &Path| Ok::<_, std::io::Error>(std::path::absolute(path)?.display().to_string());
    Ok(vec![
        ("FSI_TRANSPORT", settings.transport.to_string()),
        ("FSI_ADDRESS", path(&listener.address())?),
        ("FSI_DRIVER", std::process::id().to_string()),
        ("FSI_START_TIME_S", format!("{:?}", begun.time)),
        ("FSI_TIME_STEP_S", format!("{:?}", settings.time_step)),
        ("FSI_CASE", path(&settings.case_file)?),
        ("FSI_FOLDER", path(&settings.folder)?),
        ("FSI_WALL", path(&settings.folder.join(WALL))?),
    ])
}

/// The same as a script that a shell can read.
fn for_a_shell(way: &[(&str, String)]) -> String {
    let mut text = String::from("# The way to the driver; written by fsi-driver at each start\n");
    for (name, value) in way {
        let quoted = value.replace('\'', r"'\''");
        let _ = writeln!(text, "export {name}='{quoted}'");
    }
    text
}

/// Points and faces as a Wavefront OBJ file.
fn wavefront(wall: &FluidInterface) -> String {
    let mut text = String::from(
        "# The wet surface in the reference configuration, m; normals point out of the fluid\n",
    );
    for x in &wall.points {
        let _ = writeln!(text, "v {:?} {:?} {:?}", x.x, x.y, x.z);
    }
    for face in &wall.faces {
        text.push('f');
        for vertex in face {
            let _ = write!(text, " {}", vertex + 1);
        }
        text.push('\n');
    }
    text
}

fn resting(memory: &FluidMemory) -> Result<Resting, FluidError> {
    let found: Option<Resting> = postcard::from_bytes(&memory.state).ok();
    found
        .filter(|resting| resting.time.is_finite())
        .ok_or_else(|| died("the stored state of the fluid is that of another kind of solver"))
}

fn died(error: impl std::fmt::Display) -> FluidError {
    FluidError::Died(error.to_string())
}
