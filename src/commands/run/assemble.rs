//! From a case to everything that a running case consists of.

use super::domain::Domain;
use super::interrupt::Interrupt;
use super::rescue::Trouble;
use super::surrogate::surrogate;
use super::{run_failure, written};
use crate::Vec3;
use crate::case::{self, Case, FlowCurve, Window};
use crate::checkpoint::Checkpoint;
use crate::commands::Failure;
use crate::commands::run_folder::RunFolder;
use crate::coupling::acceleration::{self, Acceleration, Filter, Surrogate};
use crate::coupling::cadence::Cadence;
use crate::coupling::convergence::Criterion;
use crate::coupling::predictor::Predictor;
use crate::coupling::transfer::Transfer;
use crate::coupling::{Coupling, Settings, flatten};
use crate::fluid::openfoam::case_files::CaseFiles;
use crate::fluid::openfoam::probes::Sampling;
use crate::fluid::openfoam::session::Terms;
use crate::fluid::openfoam::{OpenFoam, OpenFoamSettings};
use crate::fluid::{Fluid, FluidEffort, FluidError};
use crate::hemodynamics::{Monitor, Region, Wall};
use crate::output::probes::Probes;
use crate::output::record::{Record, RecordSettings};
use crate::output::wall_record::WallRecordSettings;
use crate::pfem::mapping::MappingKind;
use crate::pfem::newton::NewtonOptions;
use crate::pfem::samples::Sampler;
use crate::pfem::{SolidError, Structure, StructureOptions, discretization};
use std::path::Path;
use std::time::{Duration, Instant};

/// Everything that a running case consists of.
pub struct Run {
    pub case: Case,
    pub folder: RunFolder,
    pub interrupt: Interrupt,
    pub coupling: Coupling<OpenFoam, Structure>,
    pub sampler: Sampler,
    pub record: Record,
    pub probes: Probes<Structure>,
    pub cells: usize,
    pub fluid_peak_memory: f64,
    /// How long the next step is.
    pub cadence: Cadence,
    /// The step that makes trouble, if one does.
    pub trouble: Option<Trouble>,
    /// The step after which the run ends with a checkpoint, and why, if the next one has been given up.
    pub last_good: Option<(usize, String)>,
    /// When the last checkpoint was written.
    pub saved: Instant,
}

impl Run {
    /// Builds meshes and solvers and starts OpenFOAM, in the state of `checkpoint` or at rest.
    pub fn assemble(
        path: &Path,
        case: &Case,
        folder: RunFolder,
        checkpoint: Option<&Checkpoint>,
        interrupt: Interrupt,
    ) -> Result<Self, Failure> {
        let inflow = FlowCurve::new(&case.inflow, case.time.period).map_err(run_failure)?;
        let domain = Domain::new(case);
        let mut solid = structure(case, &domain).map_err(run_failure)?;
        let mesh = &domain.fluid;
        mesh.write(&folder.openfoam()).map_err(written)?;
        case_files(case, &inflow)
            .write(&folder.openfoam())
            .map_err(run_failure)?;
        let settings = OpenFoamSettings {
            case: folder.openfoam(),
            log: folder.openfoam_log(),
            ranks: case.fluid.ranks,
            transport: case.fluid.transport,
            answer_limit: Duration::from_secs_f64(case.fluid.answer_limit),
            terms: Terms {
                start_time: 0.0,
                time_step: case.time.step,
                interface: None,
            },
            sampling: Sampling {
                points: case.output.fluid_probes.clone(),
                density: case.blood.density,
            },
            interrupt: interrupt.of_the_start(),
        };
        let started = match checkpoint {
            Some(checkpoint) => OpenFoam::resume(settings, &checkpoint.fluid),
            None => OpenFoam::start(settings),
        };
        let mut fluid = started.map_err(|error| match error {
            FluidError::Interrupted => Failure::Interrupted("no step was taken".into()),
            error => run_failure(error),
        })?;
        fluid.outlast_interrupts();
        let transfer = Transfer::new(fluid.interface(), &solid).map_err(run_failure)?;
        let volumes = mesh.cell_volumes();
        let points = case.output.probes.iter().map(|&x| x.into()).collect();
        let probes = Probes::new(points, &solid, &fluid.interface().face_centres)
            .map_err(|e| run_failure(format!("output.probes_m: {e}")))?;
        let settings = RecordSettings {
            history: folder.history(),
            iterations: folder.iterations(),
            probes: (!case.output.probes.is_empty()).then(|| folder.probes()),
            fluid_probes: (!case.output.fluid_probes.is_empty()).then(|| folder.fluid_probes()),
            structure: folder.structure(),
            wall: WallRecordSettings {
                regions: folder.regions(),
                history: case.output.wall_history.then(|| folder.wall_history()),
                monitor: Monitor::new(
                    Wall {
                        points: fluid.interface().points.clone(),
                        faces: fluid.interface().faces.clone(),
                    },
                    &Region::of(case),
                ),
                window: Window::of(case),
                time_step: case.time.step,
            },
            case: path.to_owned(),
            rigid_volume: volumes[..domain.rigid_cells].iter().sum(),
            volume: volumes.iter().sum(),
            fluid_cells: volumes.len(),
            structure_dofs: solid.body().degrees_of_freedom(),
        };
        let record = match checkpoint {
            Some(checkpoint) => Record::resume(settings, checkpoint.record.clone()),
            None => Record::create(settings),
        };
        // As many pieces per element and direction as the degree, so that its curves can be seen.
        let sampler = Sampler::new(solid.body(), case.structure.p + 1).map_err(run_failure)?;
        let rest = flatten(&vec![Vec3::zeros(); fluid.interface().points.len()]);
        let surrogate =
            surrogate(case, fluid.interface(), &mut solid, &transfer).map_err(run_failure)?;
        let coupling = Coupling {
            fluid,
            solid,
            transfer,
            acceleration: acceleration(&case.coupling, surrogate),
            predictor: Predictor::new(case.coupling.predictor, rest),
            criterion: Criterion {
                quantity: case.coupling.criterion,
                relative: case.coupling.e_rel,
                absolute: case.coupling.e_abs,
                max_iterations: case.coupling.max_iterations,
                share: 1.0,
            },
            settings: Settings {
                time_step: case.time.step,
                fluid_effort: FluidEffort {
                    max_sweeps: case.fluid.max_correctors,
                    residual: case.fluid.pressure_residual,
                },
                newton_tolerance: case.structure.newton_tolerance,
                relaxation: case.coupling.relaxation(),
            },
        };
        let mut run = Self {
            case: case.clone(),
            folder,
            interrupt,
            coupling,
            sampler,
            probes,
            record: record.map_err(written)?,
            cells: volumes.len(),
            fluid_peak_memory: 0.0,
            cadence: Cadence::default(),
            trouble: None,
            last_good: None,
            saved: Instant::now(),
        };
        match checkpoint {
            Some(checkpoint) => {
                run.recall(checkpoint)?;
                run.record.totals.resumed += 1;
            }
            None => run.save()?, // so that there is always one to go back to
        }
        Ok(run)
    }
}

/// The OpenFOAM case of a case.
pub(super) fn case_files<'a>(case: &'a Case, inflow: &'a FlowCurve) -> CaseFiles<'a> {
    CaseFiles {
        templates: &case.fluid.templates,
        blood: &case.blood,
        inflow,
        windkessel: &case.windkessel,
        ramp: &case.ramp,
        time: &case.time,
        flag: case.flag.as_ref(),
        ranks: case.fluid.ranks,
    }
}

/// The solid of a domain.
pub(super) fn structure(case: &Case, domain: &Domain) -> Result<Structure, SolidError> {
    let settings = &case.structure;
    let mut discretization = discretization::Options::new(domain.space);
    if let Some(degree) = settings.p_geometry {
        discretization.mapping = MappingKind::Blended(degree);
    }
    if let Some(points) = settings.quadrature_points {
        discretization.quadrature_points = [points; 3];
    }
    let options = StructureOptions {
        discretization,
        density: case.wall.density,
        damping: case.wall.damping,
        time_scheme: settings.time_scheme,
        newton: NewtonOptions {
            max_iterations: settings.newton_max_iterations,
            ..NewtonOptions::default()
        },
        wet_surface: domain.wet_surface.into(),
        supports: domain.supports.clone(),
    };
    Structure::new(&domain.solid, &domain.materials, &options)
}

fn acceleration(settings: &case::Coupling, surrogate: Box<dyn Surrogate>) -> Box<dyn Acceleration> {
    let numerics = acceleration::Settings {
        relaxation: settings.relaxation(),
        reuse: settings.reuse_steps,
        // What is smaller than the accepted error is noise of the solvers, not a column.
        filter: Filter::new(
            settings.filter,
            settings.e_rel,
            settings.surrogate != case::Surrogate::None,
        ),
        max_columns: 200,
    };
    settings.acceleration.build(&numerics, surrogate)
}
