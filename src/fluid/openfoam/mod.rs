//! Blood by OpenFOAM's `pimpleFoam`, steered by the library of `of-adapter/`.
//!
//! [`OpenFoam::start`] starts the solver on a case that [`case_files`] has written, and from then on is a
//! [`Fluid`]. When the value is dropped, the solver has ended.

use super::conversation::partner::{Beginning, Partner};
use super::conversation::session::Terms;
use super::conversation::transport::Listener;
use super::{
    Fluid, FluidEffort, FluidError, FluidInterface, FluidMemory, FluidStep, FluidTrial, FluidUsage,
    Wanted,
};
use crate::Vec3;
use crate::case;
use crate::processes::Process;
pub use connection::Connection;
use probes::{ProbeFiles, Sampling};
use rustix::process::Signal;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

pub mod case_files;
mod connection;
mod dictionary;
pub(crate) mod fields;
pub mod install;
mod names;
pub mod own_case;
pub mod prepared;
pub(crate) mod probes;
mod profile;
pub(crate) mod templates;
pub(crate) mod times;
pub(crate) mod trial;
mod write_file;

/// How Open MPI is set, unless the environment says otherwise.
const OPEN_MPI: [(&str, &str); 4] = [
    // In containers one often is root
    ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
    ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
    // Ranks that wait for the master, which waits for the driver, leave their cores to the structure
    ("OMPI_MCA_mpi_yield_when_idle", "1"),
    // Needs a capability that containers lack, and warns without it
    ("OMPI_MCA_btl_vader_single_copy_mechanism", "none"),
];

/// What is needed to start `pimpleFoam`.
#[derive(Debug, Clone)]
pub struct OpenFoamSettings {
    /// The OpenFOAM case, with its mesh.
    pub case: PathBuf,
    /// File for the solver's output.
    pub log: PathBuf,
    /// MPI ranks.
    pub ranks: usize,
    /// How driver and solver talk.
    pub transport: case::TransportKind,
    /// Longest time to wait for an answer, unless one has taken more than a fiftieth of it already.
    pub answer_limit: Duration,
    /// Start time, time step and wall, which the solver must confirm.
    pub terms: Terms,
    /// Where the blood is sampled.
    pub sampling: Sampling,
    /// Ends every wait when set.
    pub interrupt: Arc<AtomicBool>,
}

/// A running `pimpleFoam`.
pub struct OpenFoam {
    settings: OpenFoamSettings,
    /// End and length of the last accepted step since the start, s.
    accepted: Option<(f64, f64)>,
    /// What it samples.
    probes: ProbeFiles,
    /// What processes before this one have used.
    earlier: FluidUsage,
    partner: Partner,
}

impl OpenFoam {
    /// Starts the solver and shakes hands with it. Call it from a thread that lives as long as the run.
    pub fn start(settings: OpenFoamSettings) -> Result<Self, FluidError> {
        let library = install::check(settings.ranks).map_err(solver_error)?;
        let (name, listener) = match settings.transport {
            case::TransportKind::Socket => ("socket", Listener::socket()),
            case::TransportKind::Files => {
                ("files", Listener::files(&settings.case.join("exchange")))
            }
        };
        let listener = listener.map_err(solver_error)?;
        let address = std::path::absolute(listener.address()).map_err(solver_error)?;
        Connection {
            library: Some(&library),
            transport: name,
            address: &address,
            start_time: settings.terms.start_time,
        }
        .write(&settings.case)
        .map_err(solver_error)?;
        times::clear_remains(&settings.case, settings.terms.start_time).map_err(solver_error)?;
        let probes = ProbeFiles::new(&settings.case, &settings.sampling).map_err(solver_error)?;
        let programs = Programs::new(&settings.case, &[&library, &address]);
        if settings.ranks > 1 {
            decompose(&settings, &programs)?;
        }
        let (command, death_signal) = programs.solver(settings.ranks);
        let beginning = Beginning {
            name: "pimpleFoam",
            listener,
            terms: &settings.terms,
            state: &[],
            answer_limit: settings.answer_limit,
            interrupt: &settings.interrupt,
        };
        let partner = Partner::start(beginning, command, death_signal, &settings.log)?;
        Ok(Self {
            settings,
            accepted: None,
            probes,
            earlier: FluidUsage::default(),
            partner,
        })
    }

    /// Starts the solver where it was when it gave `memory`, perhaps in an earlier process.
    ///
    /// # Errors
    /// If it cannot be started, or the memory is another solver's.
    pub fn resume(
        mut settings: OpenFoamSettings,
        memory: &FluidMemory,
    ) -> Result<Self, FluidError> {
        settings.terms.start_time = remembered_time(memory)?;
        Self::start(settings)
    }

    /// From now on the solver's answers are waited for whatever happens to `interrupt`.
    pub fn outlast_interrupts(&mut self) {
        self.settings.interrupt = Arc::default();
        self.partner.outlast_interrupts();
    }

    /// Number of the process that was started: `pimpleFoam`, or `mpirun` for more than one rank.
    pub fn process_id(&self) -> u32 {
        self.partner.process_id().expect("it was started from here")
    }

    fn usage(&self) -> FluidUsage {
        self.earlier.and(self.partner.usage())
    }

    /// The files of the written time `at` (s), the end of a step of the length `step` (s).
    fn files(&self, at: f64, step: f64) -> Result<times::TimeFiles, FluidError> {
        times::files(&self.settings.case, at, step).map_err(storage_error)
    }
}

impl Fluid for OpenFoam {
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
        let accepted = (self.partner).talk(|session, patience| session.accept(write, patience))?;
        let before = self
            .accepted
            .map_or(self.settings.terms.start_time, |(end, _)| end);
        let (end, length) = (accepted.time, accepted.time - before);
        self.accepted = Some((end, length));
        let seconds_by_part = match write {
            true => times::files(&self.settings.case, end, length)
                .and_then(|written| profile::seconds_by_part(&written.files))
                .unwrap_or_default(), // what is not whole is for `memory` to refuse
            false => Vec::new(),
        };
        Ok(FluidStep {
            probes: self.probes.read(end)?,
            usage: self.usage(),
            seconds_by_part,
            ..self.partner.session().step(accepted)
        })
    }

    /// The state stays where OpenFOAM has written it; the time as the name of that folder spells it leads back to it
    /// to the bit.
    fn memory(&mut self, needed: &dyn Fn(f64) -> bool) -> Result<FluidMemory, FluidError> {
        let start = self.settings.terms.start_time;
        let written = match self.accepted {
            Some((end, step)) => self.files(end, step)?,
            None if start > 0.0 => self.files(start, self.settings.terms.time_step)?,
            None => times::TimeFiles::default(), // what it began with can be made again
        };
        (written.files.iter())
            .try_for_each(|file| times::sync_whole(file))
            .and_then(|()| times::prune(&self.settings.case, needed))
            .map_err(storage_error)?;
        Ok(FluidMemory {
            state: written.time.to_le_bytes().to_vec(),
            files: written.files,
        })
    }

    fn recall(&mut self, memory: &FluidMemory) -> Result<(), FluidError> {
        let mut settings = self.settings.clone();
        settings.terms.start_time = remembered_time(memory)?;
        if !self.partner.is_at_work()
            && !self.partner.has_ended()
            && settings.terms.start_time == self.settings.terms.start_time
        {
            return Ok(());
        }
        let earlier = self.usage();
        self.partner.end_now();
        settings.terms.interface = Some(self.interface().clone());
        *self = Self::start(settings)?;
        self.earlier = earlier;
        Ok(())
    }
}

/// OpenFOAM's programs, to run in the folder of a case.
pub struct Programs {
    case: PathBuf,
    /// What OpenFOAM needs in the environment.
    environment: Vec<(OsString, OsString)>,
    /// Value of `FOAM_CONTROLDICT`.
    switches: Option<String>,
}

impl Programs {
    /// For a case that names other `paths` as well: all of them may have blanks.
    pub fn new(case: &Path, paths: &[&Path]) -> Self {
        // An absolute path, or every line of a stack trace comes with a warning
        let case = case.canonicalize().unwrap_or_else(|_| case.to_owned());
        let switches = install::with_blanks(&[&[case.as_path()], paths].concat());
        let environment = install::chosen().map(|openfoam| openfoam.environment());
        Self {
            case,
            environment: environment.unwrap_or_default(),
            switches,
        }
    }

    /// One of them.
    pub fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        // A floating point exception ends the solver: better than infinities in the history.
        command
            .current_dir(&self.case)
            .envs(self.environment.iter().map(|(name, value)| (name, value)))
            .env("FOAM_SIGFPE", "true")
            .env("PWD", &self.case);
        if let Some(switches) = &self.switches {
            command.env("FOAM_CONTROLDICT", switches);
        }
        command
    }

    /// The solver, and the signal by which it dies with the driver.
    fn solver(&self, ranks: usize) -> (Command, Signal) {
        if ranks == 1 {
            return (self.command("pimpleFoam"), Signal::KILL);
        }
        let mut command = self.command("mpirun");
        command
            .args(["-np", &ranks.to_string(), "--oversubscribe"])
            .args(["--bind-to", "none"]);
        // Ranks on other nodes of a job get no variables but those that are named
        let passed = ["PATH", "LD_LIBRARY_PATH", "LD_PRELOAD"].into_iter();
        let passed = passed.filter(|name| self.environment.iter().any(|(set, _)| set == name));
        for variable in ["WM_PROJECT_DIR", "FOAM_SIGFPE"]
            .into_iter()
            .chain(passed)
            .chain(self.switches.as_ref().map(|_| "FOAM_CONTROLDICT"))
        {
            command.args(["-x", variable]);
        }
        command.args(["pimpleFoam", "-parallel"]);
        for (variable, value) in OPEN_MPI {
            if std::env::var_os(variable).is_none() {
                command.env(variable, value);
            }
        }
        // mpirun ends its ranks on SIGTERM; a SIGKILL would leave its session folder behind
        (command, Signal::TERM)
    }
}

/// Cuts the case into one folder a rank, unless it is there from the run that is being continued.
fn decompose(settings: &OpenFoamSettings, programs: &Programs) -> Result<(), FluidError> {
    if settings.terms.start_time > 0.0
        && settings
            .case
            .join(format!("processor{}", settings.ranks - 1))
            .is_dir()
        && !settings
            .case
            .join(format!("processor{}", settings.ranks))
            .exists()
    {
        return Ok(());
    }
    let log = settings.log.with_file_name("log.decomposePar");
    let mut command = programs.command("decomposePar");
    command.arg("-force");
    let mut process = Process::start(command, &log, Signal::KILL).map_err(solver_error)?;
    while !process.wait(Duration::from_millis(100)) {
        if settings.interrupt.load(Ordering::Relaxed) {
            return Err(FluidError::Interrupted);
        }
    }
    if process.succeeded() {
        Ok(())
    } else {
        Err(solver_error(format!(
            "decomposePar failed: {}",
            process.exit_report()
        )))
    }
}

fn solver_error(error: impl std::fmt::Display) -> FluidError {
    FluidError::Died(error.to_string())
}

fn storage_error(error: std::io::Error) -> FluidError {
    FluidError::Storage(error.to_string())
}

/// The time (s) that [`Fluid::memory`] has stored.
fn remembered_time(memory: &FluidMemory) -> Result<f64, FluidError> {
    let bytes = memory.state.as_slice().try_into();
    let time = bytes
        .map(f64::from_le_bytes)
        .ok()
        .filter(|time| time.is_finite());
    time.ok_or_else(|| solver_error("the stored state of the fluid is not one of OpenFOAM"))
}
