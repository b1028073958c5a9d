//! From a case to the two solvers and their coupling. The only place that knows which fluids there are.

mod domain;
mod fit;
mod initial_state;
mod limits;
pub mod preflight;
mod ring;
mod surrogate;
pub(crate) mod surroundings;

use crate::analysis::size;
use domain::own;
pub use domain::{Domain, DomainError, RoundLumen};
pub use fit::Fit;
pub use initial_state::{UnloadedWall, Unloading, unloaded_wall};
pub use ring::{WaveSpeeds, sideways_warning, wave_speeds};

use self::initial_state::{InitialState, fitted_lumen, initial_state};
use super::checkpoint::Store;
use super::clock::Clock;
use super::{Checkpoints, Simulation, SimulationSettings};
use crate::Vec3;
use crate::case::{
    self, BloodVessel, Case, CaseIdentity, FluidTimeScheme, MeshMotion, Problem, RunEnds,
    TableError,
};
use crate::coupling::acceleration::{self, Acceleration, Filter, Surrogate};
use crate::coupling::acceptance::Balance;
use crate::coupling::common_refinement::CommonRefinement;
use crate::coupling::convergence::Criterion;
use crate::coupling::fixed_point::FixedPoint;
use crate::coupling::predictor::Predictor;
use crate::coupling::transfer::{Transfer, TransferError};
use crate::coupling::{self, Coupling, flatten};
use crate::curve::SpaceCurve;
use crate::fluid::conversation::session::Terms;
use crate::fluid::external::{ExternalFluid, ExternalSettings, Starter};
use crate::fluid::native::NativeFluid;
use crate::fluid::openfoam::case_files::{
    CaseFiles, CaseFilesError, Openings, VesselOpenings, write_velocities,
};
use crate::fluid::openfoam::prepared::{MeshSource, Prepared};
use crate::fluid::openfoam::probes::Sampling;
use crate::fluid::openfoam::{OpenFoam, OpenFoamSettings};
use crate::fluid::polygonal_wall::{PolygonalWall, RoundWall};
use crate::fluid::{Fluid, FluidEffort, FluidError, FluidInterface, FluidMemory};
use crate::geometry::{MotionBlend, PolyMesh, WallPolygons};
use crate::pfem::element::mapping::MappingKind;
use crate::pfem::evaluation::locate::Location;
use crate::pfem::solution::listener::{self, Work};
use crate::pfem::solution::newton::NewtonOptions;
use crate::pfem::{
    Discretization, Formulation, Gravity, Solid, SolidError, Structure, StructureOptions,
    discretization,
};
use crate::processes::machine_memory;
use crate::simulation::observer::Observer;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Where a fluid works that needs files, and who may end its start.
#[derive(Debug, Clone, Default)]
pub struct Workplace {
    /// Folder of the fluid's own files.
    pub folder: PathBuf,
    /// File for what it says.
    pub log: PathBuf,
    /// The case with all its values, for a fluid that wants to read it.
    pub case_file: PathBuf,
    /// Tells the user what the start waits for.
    pub tell: Option<fn(&str)>,
    /// Ends the wait for a solver that is starting, once it is set.
    pub interrupt: Arc<AtomicBool>,
}

/// The coupled solvers of a case, and what is known of the blood's mesh.
pub struct CoupledModel {
    /// The solvers, at rest or in the state of a checkpoint.
    pub coupling: Coupling<Box<dyn Fluid>, Structure>,
    /// Cells of the fluid's mesh, or its elements; for a user-supplied solver the faces of its wall.
    pub fluid_cells: usize,
    /// Volume of the fluid at rest, m³.
    pub volume: f64,
    /// Volume of the part of it whose wall is rigid, m³.
    pub rigid_volume: f64,
    /// Where the unloaded shape of the wall comes from, if it is not the given one.
    pub unloading: Option<Unloading>,
    /// Mesh of the fluid at rest, of a user-supplied OpenFOAM case or a tree: its patches and cells are what regions
    /// are made of.
    pub own_mesh: Option<PolyMesh>,
    /// Centre-lines of the branches of a tree, each with the patch of its wall.
    pub branch_lines: Vec<(String, SpaceCurve)>,
    /// Whether the blood's time derivatives are of second order.
    pub is_second_order: bool,
}

/// Why a case could not be made ready.
#[derive(Debug, thiserror::Error)]
pub enum AssemblyError {
    /// A mesh that the case names cannot be used.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// A curve of flow or pressure cannot be read.
    #[error(transparent)]
    Curve(#[from] TableError),
    /// The mesh of the fluid could not be written.
    #[error("cannot write the results: {0}")]
    Mesh(#[from] io::Error),
    /// The case of the fluid could not be written.
    #[error(transparent)]
    CaseFiles(#[from] CaseFilesError),
    /// The fluid did not start.
    #[error(transparent)]
    Fluid(#[from] FluidError),
    /// The structure is not well posed.
    #[error(transparent)]
    Solid(#[from] SolidError),
    /// The two meshes do not fit together.
    #[error(transparent)]
    Transfer(#[from] TransferError),
    /// The surrogate cannot be made.
    #[error(transparent)]
    Surrogate(#[from] surrogate::SurrogateError),
}

impl CoupledModel {
    /// Builds meshes and solvers and starts the fluid, where it was when it gave `memory`, or at rest.
    ///
    /// # Errors
    /// If one of them cannot be made; [`FluidError::Interrupted`] if the start was ended.
    pub fn new(
        case: &Case,
        workplace: Workplace,
        memory: Option<&FluidMemory>,
    ) -> Result<Self, AssemblyError> {
        let mut model = Self::assembled(case, workplace, memory)?;
        model.coupling.settings.limits.is_elastic = case.has_elastic_wall();
        model.coupling.balance = Balance::of(model.volume);
        if let (Some(own), Some(mesh)) = (case.own(), &model.own_mesh) {
            model.coupling.settings.limits.is_closed = own::all_openings_are_known(own, mesh);
        }
        Ok(model)
    }

    fn assembled(
        case: &Case,
        workplace: Workplace,
        memory: Option<&FluidMemory>,
    ) -> Result<Self, AssemblyError> {
        let mut domain = Domain::new(case)?;
        let work = Work::begin("preparing the wall");
        let InitialState { solid, unloading } =
            initial_state(case, &domain).map_err(|none| none.error)?;
        drop(work);
        let work = Work::begin("preparing the blood");
        let (fluid_cells, [volume, rigid_volume], fluid): (_, _, Box<dyn Fluid>) =
            match case.fluid.solver {
                case::Solver::OpenFoam => {
                    let mut wall = None;
                    if let Some(vessel) = case.vessel() {
                        let (lumen, round) = fitted_lumen(vessel, &domain.fluid, &solid)?;
                        (domain.fluid, wall) = (lumen, Some(round));
                    } else if let Some(branches) = &domain.branches
                        && let Some(round) = &branches.meshed
                    {
                        wall = Some(round_wall(&domain, &branches.surface, round));
                    }
                    let volumes = domain.fluid.cell_volumes();
                    let mut fluid = openfoam(case, &domain, &solid, workplace, memory)?;
                    if let Some(wall) = wall {
                        fluid = Box::new(PolygonalWall::new(fluid, wall));
                    }
                    let all = [volumes.iter().sum(), rigid_volume(&volumes, &domain)];
                    (volumes.len(), all, fluid)
                }
                case::Solver::External => {
                    let fluid = external(case, workplace, memory)?;
                    let faces = fluid.interface().faces.len();
                    (faces, fluid.volumes(), Box::new(fluid))
                }
                case::Solver::Native => {
                    let fluid = native(case, &solid, workplace.interrupt, memory)?;
                    (fluid.elements(), fluid.volumes()?, Box::new(fluid))
                }
            };
        drop(work);
        Ok(Self {
            fluid_cells,
            volume,
            rigid_volume,
            unloading,
            coupling: join(case, &domain, fluid, solid, unloading)?,
            own_mesh: case.own().map(|_| domain.of_regions().clone()),
            is_second_order: match case.own().filter(|_| case.has_own_openfoam()) {
                Some(own) => own::files(case, own).is_second_order(),
                None => case.fluid_time_scheme() == FluidTimeScheme::Bdf2,
            },
            branch_lines: domain
                .branches
                .map_or_else(Vec::new, |branches| branches.lines),
        })
    }
}

/// How the wall of a mesh is related to the round `surface`.
fn round_wall(domain: &Domain, surface: &PolyMesh, round: &RoundLumen) -> RoundWall {
    let fluid = &domain.fluid;
    let patches = domain.wet_patches.iter();
    let faces = patches.flat_map(|patch| fluid.patch_faces(patch));
    let mut numbers: Vec<usize> = faces.flatten().copied().collect();
    numbers.sort_unstable();
    numbers.dedup();
    let of = |mesh: &PolyMesh| numbers.iter().map(|&i| mesh.points[i]).collect();
    RoundWall {
        unloaded: of(surface),
        in_mesh: of(fluid),
        polygons: (round.polygons).renumbered(|point| numbers.binary_search(&point).ok()),
    }
}

/// Couples any fluid to the structure of a case, with the numerics of the case.
///
/// # Errors
/// If the structure is not well posed, or the wall of the fluid is not that of the structure.
pub fn couple<F: Fluid>(
    case: &Case,
    domain: &Domain,
    fluid: F,
) -> Result<Coupling<F, Structure>, AssemblyError> {
    let InitialState { solid, unloading } =
        initial_state(case, domain).map_err(|none| none.error)?;
    join(case, domain, fluid, solid, unloading)
}

/// What relates the two meshes of the wet surface: those that are made here are made for each other, those of others
/// may be any.
fn transfer(
    case: &Case,
    interface: &FluidInterface,
    solid: &Structure,
) -> Result<(Transfer<Location>, Option<CommonRefinement>), TransferError> {
    let solver = case.fluid.solver;
    let of_others = case.own().is_some() || solver == case::Solver::External;
    // The lining of a rigid wall is made of the faces of the cells, which the driver's own elements do not have.
    let is_lined = !case.has_elastic_wall() && solver != case::Solver::Native;
    match of_others && !is_lined {
        true => Transfer::conserving(interface, solid)
            .map(|(transfer, common)| (transfer, Some(common))),
        false => Transfer::new(interface, solid).map(|transfer| (transfer, None)),
    }
}

/// Couples a fluid to the structure in its initial state.
fn join<F: Fluid>(
    case: &Case,
    domain: &Domain,
    fluid: F,
    mut solid: Structure,
    unloading: Option<Unloading>,
) -> Result<Coupling<F, Structure>, AssemblyError> {
    let work = Work::begin("joining the two meshes");
    let (transfer, _) = transfer(case, fluid.interface(), &solid)?;
    drop(work);
    let vessel = case.vessel();
    let pressure = vessel.map_or(0.0, |vessel| vessel.equilibrium_pressure());
    let surrogate = surrogate::surrogate(
        case,
        domain,
        fluid.interface(),
        &mut solid,
        &transfer,
        pressure,
    )?;
    let rest = flatten(&transfer.accepted_displacement(&solid));
    let numerics = &case.coupling;
    Ok(Coupling {
        fluid,
        solid,
        transfer,
        fixed_point: FixedPoint::new(
            acceleration(numerics, surrogate),
            numerics.relaxation(),
            Predictor::new(numerics.predictor, rest),
            Criterion {
                quantity: numerics.criterion,
                relative: numerics.e_rel,
                absolute: numerics.e_abs,
                displaced: unloading.map_or(0.0, |found| found.rms_displacement_m),
                max_iterations: numerics.max_iterations,
                share: 1.0,
            },
        ),
        settings: coupling::StepSettings {
            time_step: case.time.step,
            fluid_effort: FluidEffort {
                max_sweeps: case.fluid.max_correctors,
                residual: case.fluid.pressure_residual,
                from_old_state: false,
            },
            newton_tolerance: case.structure.newton_tolerance,
            limits: limits::limits(case)?,
        },
        balance: Balance::default(),
    })
}

impl Checkpoints {
    /// Of the run of a case whose checkpoints are in `store`.
    ///
    /// # Errors
    /// If a file that the case names cannot be read.
    pub fn of(case: &Case, store: Store) -> io::Result<Self> {
        Ok(Self {
            store,
            interval_minutes: case.output.checkpoint_interval,
            case: CaseIdentity::of(case)?,
        })
    }
}

impl<F: Fluid, O: Observer<Structure>> Simulation<F, Structure, O> {
    /// The simulation of a case at the start of its first step.
    pub fn of(case: &Case, coupling: Coupling<F, Structure>, observer: O) -> Self {
        let settings = SimulationSettings {
            max_halvings: case.time.max_halvings,
            fluid_interval: case.output.fluid_interval,
        };
        let clock = Clock::new(case.time.step, RunEnds::of(case));
        Self::new(coupling, clock, settings, observer)
    }
}

/// The native fluid between walls as they are now: where it was when it gave `memory`, or as the run begins.
fn native(
    case: &Case,
    solid: &Structure,
    interrupt: Arc<AtomicBool>,
    memory: Option<&FluidMemory>,
) -> Result<NativeFluid, AssemblyError> {
    let mut fluid = NativeFluid::new(case)?;
    fluid.give_up_at(interrupt);
    if solid.is_displaced() {
        let places = solid.locate(&fluid.interface().points)?;
        fluid.begin_at(solid.accepted_displacement(&places));
    }
    if let Some(memory) = memory {
        fluid.recall(memory)?;
    } else if let Some(steps) = case.steps_before() {
        let tell = |share| listener::tell("the beat before the first", share);
        fluid.begin_after_a_beat(case.time.period, steps, tell)?;
    }
    Ok(fluid)
}

/// Writes the OpenFOAM case and starts the solver.
fn openfoam(
    case: &Case,
    domain: &Domain,
    solid: &Structure,
    workplace: Workplace,
    memory: Option<&FluidMemory>,
) -> Result<Box<dyn Fluid>, AssemblyError> {
    prepared(case, domain)?.write(&workplace.folder)?;
    if memory.is_none() && case.steps_before().is_some() {
        let fluid = native(case, solid, workplace.interrupt.clone(), None)?;
        let cells = domain.fluid.cell_geometry().into_iter();
        let centres: Vec<Vec3> = cells.map(|(_, centre)| centre).collect();
        let velocities = fluid.velocities(&centres);
        write_velocities(&velocities, &workplace.folder)?;
    }
    let settings = OpenFoamSettings {
        case: workplace.folder,
        log: workplace.log,
        ranks: case.fluid.ranks,
        transport: case.fluid.transport,
        answer_limit: Duration::from_secs_f64(case.fluid.answer_limit),
        terms: Terms {
            start_time: 0.0,
            time_step: case.time.step,
            interface: None,
        },
        sampling: sampling(case),
        interrupt: workplace.interrupt,
    };
    let mut fluid = match memory {
        Some(memory) => OpenFoam::resume(settings, memory),
        None => OpenFoam::start(settings),
    }?;
    fluid.outlast_interrupts();
    Ok(Box::new(fluid))
}

/// Starts the user-supplied solver, or waits for it.
fn external(
    case: &Case,
    workplace: Workplace,
    memory: Option<&FluidMemory>,
) -> Result<ExternalFluid, AssemblyError> {
    let settings = external_settings(case, workplace)?;
    let mut fluid = ExternalFluid::start(settings, memory)?;
    fluid.outlast_interrupts();
    Ok(fluid)
}

/// How the user-supplied solver is started. What it leaves lies next to the folder that OpenFOAM would have.
///
/// # Errors
/// If a mesh that the case names cannot be used.
pub(crate) fn external_settings(
    case: &Case,
    workplace: Workplace,
) -> Result<ExternalSettings, DomainError> {
    let domain = Domain::new(case)?;
    Ok(ExternalSettings {
        starter: match case.fluid.is_awaited {
            true => Starter::User(workplace.tell),
            false => Starter::Command(case.fluid.command.clone()),
        },
        folder: workplace.folder.with_file_name(surroundings::OWN_FLUID),
        log: workplace.log.with_file_name(surroundings::EXTERNAL_LOG),
        case_file: workplace.case_file,
        wall: preflight::interface(&domain),
        transport: case.fluid.transport,
        answer_limit: Duration::from_secs_f64(case.fluid.answer_limit),
        time_step: case.time.step,
        interrupt: workplace.interrupt,
    })
}

/// The points in the blood that a case watches.
fn sampling(case: &Case) -> Sampling {
    Sampling {
        points: case.output.fluid_probes.clone(),
        density: case.blood.density,
    }
}

/// Volume (m³) of the cells upstream and downstream of the deformable part.
fn rigid_volume(volumes: &[f64], domain: &Domain) -> f64 {
    let elastic = &domain.elastic_cells;
    let sum = |cells: &[f64]| cells.iter().sum::<f64>();
    sum(&volumes[..elastic.start]) + sum(&volumes[elastic.end..])
}

/// The OpenFOAM case of a case.
fn prepared<'a>(case: &'a Case, domain: &'a Domain) -> Result<Prepared<'a>, TableError> {
    let files = match &case.problem {
        Problem::UserCase(own) if case.has_own_openfoam() => {
            MeshSource::Own(own::own_case_files(case, own, domain))
        }
        _ => MeshSource::Templates(case_files(case, domain)?),
    };
    Ok(Prepared {
        files,
        mesh: &domain.fluid,
    })
}

/// The templates of a case with this mesh, and the numbers for them.
fn case_files<'a>(case: &'a Case, domain: &'a Domain) -> Result<CaseFiles<'a>, TableError> {
    let mesh = &domain.fluid;
    Ok(CaseFiles {
        templates: &case.fluid.templates,
        blood: &case.blood,
        openings: match &case.problem {
            Problem::Vessel(vessel) => Openings::Vessel(VesselOpenings::new(case, vessel, mesh)?),
            Problem::Flag(flag) => Openings::Channel(flag),
            Problem::UserCase(own) => {
                let tree = own.tree.as_ref();
                let openings = tree.expect("a user-supplied case has no templates");
                let openings = openings.openings(case.time.period)?;
                let moving = own::moving_patches(own, domain);
                Openings::Vessel(VesselOpenings::of_tree(case, openings, &moving, mesh))
            }
        },
        walls: domain.wet_patches.iter().map(String::as_str).collect(),
        ramp: &case.ramp,
        time: &case.time,
        convection: case.fluid.convection,
        ranks: case.fluid.ranks,
        non_orthogonality_deg: mesh.non_orthogonality_deg(),
        diffusion_number: case.blood.viscosity / case.blood.density
            * case.time.step
            * mesh.laplacian_diagonal(),
        blend: case.vessel().and_then(|vessel| blend(vessel, mesh)),
    })
}

/// How the points of a vessel's mesh follow its wall, if it is by shares.
fn blend(vessel: &BloodVessel, mesh: &PolyMesh) -> Option<MotionBlend> {
    let keys = &vessel.fluid.mesh;
    match keys.motion.unwrap_or_default() {
        MeshMotion::Blend => Some(WallPolygons::of(mesh, keys).blend(mesh, keys)),
        MeshMotion::Laplace => None,
    }
}

/// Refuses a wall that does not fit into a machine with so many bytes, before its first factorization.
fn fits(body: &Discretization, there: Option<f64>) -> Result<(), SolidError> {
    match there {
        Some(there) if body.memory() > there => Err(SolidError::Model(format!(
            "its {} degrees of freedom need about {:.1} GB of memory, and this machine has {:.1} GB: take fewer elements \
             (structure.*, tree.core, tree.length, wall.extrude.faces_per_element) or a lower structure.p",
            body.degrees_of_freedom(),
            body.memory() / 1e9,
            there / 1e9
        ))),
        _ => Ok(()),
    }
}

/// The structure of a case, without displacement.
pub fn structure(case: &Case, domain: &Domain) -> Result<Structure, SolidError> {
    let settings = &case.structure;
    let mut discretization = discretization::Options::new(domain.space);
    if let Some(degree) = settings.p_geometry {
        discretization.mapping = MappingKind::Blended(degree);
    }
    // In a space of degree 1 nothing is solved for that could lock.
    discretization.formulation = match domain.space.max_degree() {
        1 => Formulation::Displacement,
        _ => settings.formulation,
    };
    if let Some(points) = settings.quadrature_points {
        discretization.quadrature_points = [points; 3];
    }
    discretization.prestretch = case.prestretch();
    let options = StructureOptions {
        discretization,
        density: case.wall.density,
        damping: case.wall.damping,
        time_scheme: settings.time_scheme,
        load: settings.load,
        newton: NewtonOptions {
            max_iterations: settings.newton_max_iterations,
            ..NewtonOptions::default()
        },
        wet_surface: domain.wet_surface.into(),
        supports: domain.supports.clone(),
        outer_pressure: domain.outer_pressure.clone(),
        gravity: gravity(case),
    };
    let mut solid = Structure::new(&domain.solid, &domain.materials, &options)?;
    fits(solid.body(), machine_memory())?;
    if let Some(seconds) = size::fluid_seconds(case) {
        solid = solid.with_background_seconds(seconds);
    }
    Ok(match &domain.motion {
        Some(motion) => solid.moving_as(motion),
        None => solid,
    })
}

/// The weight of the wall of a user-supplied case.
fn gravity(case: &Case) -> Option<Gravity> {
    let keys = case.own()?.wall.gravity.as_ref()?;
    Some(Gravity {
        acceleration: Vec3::from_column_slice(&keys.acceleration),
        ramp: keys.ramp.unwrap_or(0.0),
    })
}

fn acceleration(
    settings: &case::CouplingSettings,
    surrogate: Box<dyn Surrogate>,
) -> Box<dyn Acceleration> {
    let numerics = acceleration::AccelerationSettings {
        relaxation: settings.relaxation(),
        reuse: settings.reuse_steps,
        // What is smaller than the accepted error is noise of the solvers, not a column.
        filter: Filter::new(
            settings.filter,
            settings.e_rel,
            settings.surrogate != case::SurrogateModel::None,
        ),
        max_columns: 200,
    };
    settings.acceleration.build(&numerics, surrogate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Preset;
    use std::path::Path;

    /// The wall of `demo` takes 35 MB.
    #[test]
    fn a_wall_beyond_the_machine_is_refused() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/S-0.25");
        let case = Case::load(&folder, Preset::Demo, &[]).unwrap();
        let wall = structure(&case, &Domain::new(&case).unwrap()).unwrap();
        let (bytes, body) = (wall.body().memory(), wall.body());
        assert!((2e7..6e7).contains(&bytes), "{bytes:e}");
        assert!(fits(body, Some(1.01 * bytes)).is_ok() && fits(body, None).is_ok());
        let refused = fits(body, Some(0.99 * bytes)).unwrap_err().to_string();
        for part in ["degrees of freedom need about 0.0 GB", "structure.p"] {
            assert!(refused.contains(part), "{refused}");
        }
    }
}
