//! What a run would refuse after it has written its first files, found before.

use super::initial_state::{InitialState, initial_state};
use super::surrogate::stations;
use super::{Domain, DomainError, own, prepared, sampling, transfer};
use crate::Vec3;
use crate::analysis;
use crate::analysis::{random_lumen, size};
use crate::case::{
    Case, CaseError, CaseErrors, ConvectionScheme, FluidMesh, FluidTimeScheme, InletEnd, OwnRegion,
    Problem, ResolvedCase, Solver, Start, SurrogateModel, VesselEnd,
};
use crate::coupling::transfer::{TransferError, likely_unit};
use crate::fluid::native::NativeFluid;
use crate::fluid::openfoam::templates::{self, TemplateError};
use crate::fluid::openfoam::trial;
use crate::fluid::{Fluid, FluidError, FluidInterface};
use crate::hemodynamics::{CrossSection, CrossSectionPlace, RegionExtent, WetSurface};
use crate::pfem::Solid;
use crate::pfem::evaluation::samples::Sampler;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Points of one key that are complained of one by one.
const MOST_COMPLAINTS: usize = 5;
/// A mesh with more cells is tried in a coarse form.
const CELLS_OF_A_TRIAL: usize = 20_000;
/// Cells of that along a side of the square in the middle, and from there to the wall.
const COARSE_CORE: usize = 4;
/// Cells of that along each section.
const COARSE_AXIAL: usize = 60;

/// Builds both meshes and the wall, and looks at all that a run reads: the templates, whether the two meshes have the
/// same wall, the probes on the wall and in the blood, the stations of the surrogate.
///
/// # Errors
/// All mistakes that were found, with the keys to blame.
pub fn check(case: &ResolvedCase) -> Result<(), CaseErrors> {
    let random = random_lumen::mistakes(case).into_iter();
    let random: Vec<CaseError> = random.map(|(key, what)| case.mistake(key, what)).collect();
    if !random.is_empty() {
        return Err(CaseErrors(random));
    }
    let domain = Domain::new(case)
        .map_err(|error| CaseErrors(vec![case.mistake(case.given(error.key), error.reason)]))?;
    let regions = analysis::regions(case).into_iter();
    let regions: Vec<String> = regions.map(|region| region.name.to_string()).collect();
    let measures = case.measure_mistakes(&regions).into_iter();
    let mut errors: Vec<CaseError> = measures
        .map(|(key, what)| case.mistake(&key, what))
        .collect();
    let points = case.output.fluid_probes.iter().copied();
    let points: Vec<Vec3> = points.map(Vec3::from).collect();
    let (interface, inside) = match case.fluid.solver {
        Solver::OpenFoam if let Some(own) = case.own().filter(|_| case.has_own_openfoam()) => {
            let found = own::own_case_files(case, own, &domain)
                .check(&domain.fluid)
                .into_iter();
            errors.extend(found.map(|error| case.mistake("fluid.case", error.to_string())));
            (Some(interface(&domain)), domain.fluid.contains(&points))
        }
        Solver::OpenFoam => {
            let found = template_mistakes(case, &domain).into_iter();
            errors.extend(found.map(|e| case.mistake("fluid.templates", e.to_string())));
            (Some(interface(&domain)), domain.fluid.contains(&points))
        }
        Solver::Native => match NativeFluid::new(case) {
            Ok(fluid) => {
                let probes = fluid.probes().into_iter();
                let inside = probes.map(|probe| !probe.pressure.is_nan());
                (Some(fluid.interface().clone()), inside.collect())
            }
            Err(error) => {
                let reason = format!("the native fluid cannot be made: {error}");
                return Err(CaseErrors(vec![CaseError::Whole(reason)]));
            }
        },
        // Its wall is not known before it has started.
        Solver::External => (None, Vec::new()),
    };
    check_wall(case, &domain, interface.as_ref(), &mut errors);
    let outside = points.iter().zip(inside).filter(|(_, inside)| !inside);
    let outside = outside.map(|(x, _)| {
        let x: [f64; 3] = (*x).into();
        format!("{x:?} does not lie in the fluid at rest; expected points within")
    });
    let key = case.key_of_points("output.fluid_probes_m");
    errors.extend(some(outside).map(|what| case.mistake(key, what)));
    if case.coupling.surrogate != SurrogateModel::None
        && let Some(interface) = &interface
        && let Problem::Vessel(vessel) = &case.problem
        && let Err(error) = stations(vessel, case.fluid.solver, &interface.points)
    {
        let key = match case.fluid.solver {
            Solver::Native => "fluid.native.axial_per_section",
            _ => "fluid.mesh.axial_per_section",
        };
        let advice = format!("write \"none\", or raise {key}");
        errors.push(case.mistake("coupling.surrogate", format!("{error}; {advice}")));
    }
    if errors.is_empty() {
        Ok(())
    } else {
        Err(CaseErrors(errors))
    }
}

/// What the templates of OpenFOAM lack for this case.
fn template_mistakes(case: &ResolvedCase, domain: &Domain) -> Vec<TemplateError> {
    let patches = domain.fluid.patches.iter();
    let patches: Vec<&str> = patches.map(|patch| patch.name.as_str()).collect();
    let mut found = templates::check(&case.fluid.templates, &patches, case.fluid.ranks);
    let folder = &case.fluid.templates;
    if case.time.scheme == FluidTimeScheme::Bdf2 {
        found.extend(templates::check_second_order(folder));
    }
    if case.fluid.convection != ConvectionScheme::LinearUpwind {
        found.extend(templates::check_convection(folder));
    }
    if case.tree().is_some() {
        found.extend(templates::check_openings(folder));
        found.extend(templates::check_walls(folder));
        if case.initial_wall().is_some() {
            found.extend(templates::check_equilibrium_start(folder));
        }
    }
    if let Some(vessel) = case.vessel() {
        if vessel.opening.is_some() {
            found.extend(templates::check_openings(folder));
        }
        if vessel.start() == Start::Equilibrium {
            found.extend(templates::check_equilibrium_start(folder));
        }
        if case.steps_before().is_some() {
            found.extend(templates::check_initial_velocity(folder));
        }
        for (opening, moves) in [
            ("inlet", vessel.inlet_end() != InletEnd::Clamped),
            ("outlet", vessel.outlet_end().0 != VesselEnd::Clamped),
        ] {
            if moves {
                found.extend(templates::check_moving_end(folder, opening));
            }
        }
    }
    found
}

/// Whether the wall finds its state at t = 0 and lies where the blood's is, with the probes on it.
fn check_wall(
    case: &ResolvedCase,
    domain: &Domain,
    interface: Option<&FluidInterface>,
    errors: &mut Vec<CaseError>,
) {
    match initial_state(case, domain) {
        Err(none) => errors.push(blamed(case, none.key.as_deref(), none.to_string())),
        Ok(InitialState { solid, .. }) => {
            if let Some(own) = case.own().filter(|_| case.has_elastic_wall())
                && let Err(error) = Sampler::new(solid.body(), case.structure.p + 1)
            {
                let (key, advice) = match own.wall.is_extruded() {
                    true => (
                        "wall.extrude.layers",
                        ": fewer faces per element (wall.extrude.faces_per_element), more averages of the normals \
                         (wall.extrude.smoothing) or a thinner wall help",
                    ),
                    false => ("wall.file.mesh", ""),
                };
                errors.push(case.mistake(key, format!("{error}{advice}")));
            }
            let related = interface.map(|interface| transfer(case, interface, &solid));
            let fits = !matches!(related, Some(Err(_)));
            if let Some(Err(error)) = related {
                errors.push(blamed(case, key_of(case, &error), apart(case, &error)));
            }
            if let Some(interface) = interface {
                check_places(case, domain, interface, errors);
            }
            let probes = case
                .output
                .probes
                .iter()
                .copied()
                .map(Vec3::from)
                .enumerate();
            // On a wall in another unit none would lie.
            let off = probes.filter(|(_, probe)| fits && solid.locate(&[*probe]).is_err());
            let off = off.map(|(i, probe)| off_the_wall(i, probe, interface));
            let key = case.key_of_points("output.probes_m");
            errors.extend(some(off).map(|what| case.mistake(key, what)));
        }
    }
}

/// Whether the cross-sections that the case watches part its wall, and its regions along branches have a face.
fn check_places(
    case: &ResolvedCase,
    domain: &Domain,
    interface: &FluidInterface,
    errors: &mut Vec<CaseError>,
) {
    let sections = analysis::cross_sections(case);
    let has_branch = |region: &OwnRegion| region.branch.is_some();
    let regions = case.own().and_then(|own| own.fluid.region.as_deref());
    let regions = regions.unwrap_or_default();
    if sections.is_empty() && !regions.iter().any(has_branch) {
        return;
    }
    let lines = domain
        .branches
        .as_ref()
        .map_or(&[][..], |branches| &branches.lines);
    let mesh = case.own().map(|_| domain.of_regions());
    let (points, faces) = (&interface.points, &interface.faces);
    let wall = analysis::wet_surface(case, points, faces, mesh, lines);
    check_sections(case, domain, &wall, &sections, errors);
    for region in analysis::regions(case) {
        let RegionExtent::Branch { patch, .. } = &region.extent else {
            continue;
        };
        if wall.shares(&region).is_empty()
            && let Some(i) = regions
                .iter()
                .position(|keys| keys.name == region.name.as_str())
        {
            let [first, last] = limits(&wall, Some(patch));
            let reason = format!(
                "the region has no face of the wall: those of the branch lie from {first:.4} to {last:.4} m"
            );
            errors.push(case.mistake(&format!("fluid.region[{i}].branch"), reason));
        }
    }
}

/// From where to where (m) along its line the faces of a branch lie, or those of the whole wall.
fn limits(wall: &WetSurface, patch: Option<&String>) -> [f64; 2] {
    let is_on = |face: &usize| patch.is_none_or(|patch| wall.is_of_patch(*face, patch));
    let along = (0..wall.faces.len())
        .filter(is_on)
        .map(|face| wall.along(face));
    along.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], s| {
        [a.min(s), b.max(s)]
    })
}

fn check_sections(
    case: &ResolvedCase,
    domain: &Domain,
    wall: &WetSurface,
    places: &[CrossSectionPlace],
    errors: &mut Vec<CaseError>,
) {
    if let Some(own) = case
        .own()
        .filter(|_| case.has_own_openfoam() && !places.is_empty())
        && let Err(DomainError { key, reason }) = own::flows_are_known(case, own, &domain.fluid)
    {
        return errors.push(case.mistake(key, reason));
    }
    for (i, place) in places.iter().enumerate() {
        if CrossSection::new(wall, place).is_some() {
            continue;
        }
        let [first, last] = limits(wall, place.patch.as_ref());
        let reason = format!(
            "no cross-section of the elastic wall is there: its faces lie from {first:.4} to {last:.4} m; expected a place \
             between, not within a junction"
        );
        errors.push(case.mistake(&format!("output.section[{i}].at_m"), reason));
    }
}

/// A mistake, with its key if there is one whose change is the cure.
fn blamed(case: &ResolvedCase, key: Option<&str>, reason: String) -> CaseError {
    match key {
        Some(key) => case.mistake(key, reason),
        None => CaseError::Whole(reason),
    }
}

/// The key to change where the two meshes do not fit together, if it is one.
fn key_of(case: &Case, error: &TransferError) -> Option<&'static str> {
    match (case.own(), error) {
        (None, _) => None,
        (Some(own), TransferError::Size { .. }) if own.tree.is_some() => Some("tree.unit"),
        (Some(own), _) if own.wall.file.is_none() => Some("fluid.patches"),
        (Some(_), TransferError::Size { .. }) => Some("wall.file.unit_m"),
        (Some(_), TransferError::Solid(_)) => Some("wall.file.mesh"),
        (Some(_), TransferError::Uncovered(_) | TransferError::Lost(_)) => Some("wall.file.wet"),
    }
}

/// Why two meshes do not fit together, and what helps.
fn apart(case: &Case, error: &TransferError) -> String {
    match (case.own(), error) {
        (None, _) => {
            format!(
                "{error}; take more elements of the wall around and along (structure), or more cells (fluid)"
            )
        }
        (Some(own), TransferError::Size { .. }) if own.tree.is_some() => {
            format!(
                "{error}; correct the unit, or scale the fluid's mesh, which must be in metres (transformPoints)"
            )
        }
        (Some(own), TransferError::Size { wall, fluid }) => {
            let unit = own.wall.file.as_ref().and_then(|file| file.unit);
            let (unit, ratio) = (unit.unwrap_or(1.0), wall / fluid);
            let advice = match likely_unit(ratio) {
                Some((factor, _)) if ratio > 1.0 => unit / factor,
                Some((factor, _)) => unit * factor,
                None => unit / ratio,
            };
            format!(
                "{error}; lengths of the wall's file are multiplied by wall.file.unit_m = {unit}: write {advice}, or scale the \
                 fluid's mesh, which must be in metres (transformPoints)"
            )
        }
        (Some(_), _) => error.to_string(),
    }
}

/// Why the trial start of a fluid did not succeed.
#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// The fluid refuses something of the case.
    #[error(transparent)]
    Refused(CaseErrors),
    /// The user ended it.
    #[error("interrupted")]
    Interrupted,
}

/// Starts OpenFOAM, if the case asks for it, for trial on the mesh and the templates of the case, in a folder that is
/// gone afterwards, also if `interrupt` is set meanwhile. A fine mesh of a vessel is replaced by a coarse one with the
/// same patches: the templates are read alike, and a trial on a million cells would take a minute.
///
/// # Errors
/// What OpenFOAM refuses, or that there was an interrupt.
pub fn try_fluid(case: &ResolvedCase, interrupt: Arc<AtomicBool>) -> Result<(), TrialError> {
    if case.fluid.solver != Solver::OpenFoam {
        return Ok(());
    }
    let refused = |key: &str, reason: String| {
        TrialError::Refused(CaseErrors(vec![case.mistake(key, reason)]))
    };
    let coarse = coarse(case);
    let domain = Domain::new(&coarse).map_err(|e| refused(case.given(e.key), e.reason))?;
    let prepared = prepared(&coarse, &domain);
    let prepared = prepared.map_err(|e| refused("inflow.file", e.to_string()))?;
    // The templates that come with the program are nobody's mistake.
    let key = match case.own() {
        Some(_) if case.has_own_openfoam() => Some("fluid.case"),
        _ => (!case.is_built_in("fluid.templates")).then_some("fluid.templates"),
    };
    trial::start(&prepared, sampling(case), interrupt).map_err(|error| match error {
        FluidError::Interrupted => TrialError::Interrupted,
        reason => {
            let it = if key.is_some() { "it" } else { "the case" };
            let reason = format!("OpenFOAM refuses {it}: {reason}");
            TrialError::Refused(CaseErrors(vec![blamed(case, key, reason)]))
        }
    })
}

/// The case with fewer cells, if its mesh is made from keys and nothing is watched at places in it.
fn coarse(case: &Case) -> Cow<'_, Case> {
    let mut coarse = Cow::Borrowed(case);
    if case.output.fluid_probes.is_empty()
        && let Some(vessel) = case.vessel()
        && size::fluid_cells(case) > CELLS_OF_A_TRIAL
    {
        let mesh = &vessel.fluid.mesh;
        let finest = FluidMesh {
            core: mesh.core.min(COARSE_CORE),
            radial: mesh.radial.min(COARSE_CORE),
            axial_extension: mesh.axial_extension.min(COARSE_AXIAL),
            axial_per_section: mesh.axial_per_section.min(COARSE_AXIAL),
            rim_parts: None,
            ..mesh.clone()
        };
        if let Problem::Vessel(vessel) = &mut coarse.to_mut().problem {
            vessel.fluid.mesh = finest;
        }
    }
    coarse
}

/// The wall as everybody but OpenFOAM sees it.
pub(super) fn interface(domain: &Domain) -> FluidInterface {
    let mesh = domain.surface();
    let wet = &domain.wet_patches;
    let wall = mesh
        .patches
        .iter()
        .filter(|patch| wet.contains(&patch.name));
    let faces: Vec<&Vec<usize>> = wall
        .flat_map(|patch| &mesh.faces[patch.start..patch.start + patch.size])
        .collect();
    let mut numbers = BTreeMap::new();
    let mut points = Vec::new();
    let mut number = |point: &usize| {
        *numbers.entry(*point).or_insert_with(|| {
            points.push(mesh.points[*point]);
            points.len() as u32 - 1
        })
    };
    let centre = |face: &&Vec<usize>| {
        let sum: Vec3 = face.iter().map(|point| mesh.points[*point]).sum();
        sum / face.len() as f64
    };
    FluidInterface {
        face_centres: faces.iter().map(centre).collect(),
        faces: faces
            .iter()
            .map(|face| face.iter().map(&mut number).collect())
            .collect(),
        points,
    }
}

/// The first few of many complaints, the last of which says how many more there are.
fn some(complaints: impl Iterator<Item = String>) -> impl Iterator<Item = String> {
    let mut complaints: Vec<String> = complaints.collect();
    let more = complaints.len().saturating_sub(MOST_COMPLAINTS);
    complaints.truncate(MOST_COMPLAINTS);
    if let (Some(last), 1..) = (complaints.last_mut(), more) {
        *last += &format!("; and {more} more points like this");
    }
    complaints.into_iter()
}

fn off_the_wall(index: usize, probe: Vec3, wall: Option<&FluidInterface>) -> String {
    let points = wall.map_or(&[][..], |wall| &wall.points).iter();
    let nearest = points.min_by(|a, b| {
        let [a, b] = [a, b].map(|point| (*point - probe).norm());
        a.total_cmp(&b)
    });
    let near = nearest.map_or(String::new(), |x| {
        format!(
            "; the point of the wall nearest to it, [{:.4e}, {:.4e}, {:.4e}], is {:.2e} m away",
            x.x,
            x.y,
            x.z,
            (x - probe).norm()
        )
    });
    format!(
        "probe {index}, [{:?}, {:?}, {:?}], does not lie on the unloaded surface that the blood touches{near}",
        probe.x, probe.y, probe.z
    )
}
