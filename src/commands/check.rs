//! `fsi-driver check DIR`: everything that can be said of a case before it runs.

use super::wall::with_wall;
use super::{CaseArguments, Failure};
use crate::Vec3;
use crate::analysis;
use crate::analysis::Deviation;
use crate::analysis::case_figures::{self as figures, CaseFigures};
use crate::analysis::plausibility;
use crate::analysis::wall::WallFigures;
use crate::analysis::windkessel::Pressures;
use crate::analysis::{random_lumen, size};
use crate::case::{BloodVessel, Case, ConditionKeys, ResolvedCase, TreeKeys, VesselSide};
use crate::fluid::openfoam::install;
use crate::geometry::{Section, Vessel};
use crate::output::progress::{human, tell_preparation};
use crate::output::terminal;
use crate::pfem::SolidError;
use crate::processes::machine_memory;
use crate::run::{Interrupt, warn};
use crate::simulation::assembly::{Domain, Fit, preflight, surroundings, wave_speeds};
use crate::tabular::units::MMHG;
use std::path::PathBuf;

/// Options of the check.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of the case, with its case.toml.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Also compute the wall alone, in statics, under the mean and the highest pressure that the openings make, and
    /// find its buckling load; takes up to a minute.
    #[arg(long)]
    wall: bool,
    #[command(flatten)]
    case: CaseArguments,
}

/// Loads and checks a case and prints its size.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    tell_preparation();
    let case = arguments.case.load(&arguments.folder)?;
    let pressed = arguments.wall.then(|| elastic_wall(&case)).transpose()?;
    let openfoam = openfoam(&case)?;
    let fit = case.own().map(|_| fit(&case)).transpose()?;
    let (cells, degrees_of_freedom, wall) = match &fit {
        Some(fit) => (fit.cells, fit.degrees_of_freedom, fit.wall_memory),
        None => {
            let degrees_of_freedom = size::structure_degrees_of_freedom(&case);
            let wall = analysis::wall_memory(degrees_of_freedom);
            (size::fluid_cells(&case), degrees_of_freedom, wall)
        }
    };
    let memory: f64 = (size::memory_with(&case, cells, wall).iter())
        .map(|(bytes, _)| bytes)
        .sum();
    let blood = surroundings::described(&case, cells);
    let held = match fit {
        Some(_) => "",
        None => ", the held ones included",
    };
    let there = machine_memory().map_or(String::new(), |bytes| {
        format!(" of this machine's {:.1} GB", bytes / 1e9)
    });
    terminal::print(format_args!(
        "{} with --preset {} can be run:\n\
         blood   {blood}\n\
         wall    {degrees_of_freedom} degrees of freedom{held}, p = {}\n\
         time    {} of {} s\n\
         OpenFOAM {openfoam}\n\
         memory  about {:.2} GB{there}\n",
        arguments.folder.display(),
        arguments.case.preset,
        case.structure.p,
        case.steps_told(),
        case.time.step,
        memory / 1e9,
    ))?;
    if let Some(numbers) = analysis::flow_numbers(&case) {
        terminal::print(format_args!("flow    {numbers}\n"))?;
    }
    if let Some(fit) = &fit {
        terminal::print(extent(fit))?;
        if let Some((jacobian, x)) = fit.worst {
            terminal::print(format_args!(
                "quality the smallest scaled Jacobian of the blood's mesh is {jacobian:.2} (1 is a cube, 0 degenerate), at \
                 ({:.4}, {:.4}, {:.4}) m\n",
                x.x, x.y, x.z
            ))?;
        }
        for note in &fit.notes {
            terminal::print(format_args!("tree    {note}\n"))?;
        }
        terminal::print(format_args!(
            "fit     the {} faces of the fluid lie within {:.1e} m of the wall; {:.1} % of the wall's wet surface has none next to it{}\n",
            fit.faces,
            fit.distance,
            1e2 * fit.uncovered,
            fit.bare.map_or(String::new(), bare)
        ))?;
    }
    for (label, text) in expected(&case) {
        terminal::print(format_args!("{label:<8}{text}\n"))?;
    }
    if let Some(vessel) = case.vessel().filter(|vessel| !vessel.is_rigid()) {
        terminal::print(waves(&case, vessel))?;
    }
    warn(&case);
    for warning in plausibility::warnings(&case) {
        terminal::note(format_args!("warning: {warning}"));
    }
    if let Some(deviation) = Deviation::of_lumen(&case).filter(Deviation::is_large) {
        terminal::note(format_args!("warning: {}", told(&deviation)));
    }
    if let Some(wall) = pressed {
        terminal::print(in_figures(&case, &wall)?)?;
    }
    Ok(())
}

/// What OpenFOAM says to the case, where it is needed.
fn openfoam(case: &ResolvedCase) -> Result<String, Failure> {
    if !surroundings::needs_openfoam(case.fluid.solver) {
        return Ok("is not needed".into());
    }
    if let Err(missing) = install::check(case.fluid.ranks) {
        return Ok(format!("was left out: {missing}"));
    }
    let interrupt = Interrupt::listen(None)?;
    preflight::try_fluid(case, interrupt.of_the_start())?;
    interrupt.stop_listening()?;
    Ok(match case.has_own_openfoam() {
        true => "takes the case".into(),
        false => "takes the templates".into(),
    })
}

/// A wall that can be put under pressure alone.
enum Pressed<'a> {
    Vessel(&'a BloodVessel),
    Tree(&'a TreeKeys),
}

/// The wall of a case, if it can be put under pressure alone.
fn elastic_wall(case: &Case) -> Result<Pressed<'_>, Failure> {
    let reason = match (case.vessel(), case.tree()) {
        (Some(vessel), _) if !vessel.is_rigid() => return Ok(Pressed::Vessel(vessel)),
        (Some(_), _) => "no section of the vessel is elastic",
        (None, Some(tree)) if case.has_elastic_wall() => return Ok(Pressed::Tree(tree)),
        (None, Some(_)) => "the wall of the tree is not elastic",
        (None, None) => {
            "only a [vessel] and a [tree] can be put under pressure alone, and this case has none"
        }
    };
    Err(Failure::Input(format!(
        "--wall: {reason}; leave the option out"
    )))
}

/// What is to be expected of a case, a line each: its label and the text. Further lines belong here.
fn expected(case: &Case) -> Vec<(&'static str, String)> {
    let mut lines = of_files(case);
    if let Some(figures) = CaseFigures::of(case) {
        lines.extend(of_blood(&figures));
        lines.extend(figures.walls.iter().map(of_wall));
    }
    if let Some(deviation) = Deviation::of_lumen(case) {
        lines.push(("lumen", described(&deviation)));
    }
    if let Some(figures) = random_lumen::figures(case) {
        lines.push(("lumen", figures.to_string()));
    }
    let seconds = size::run_seconds(case);
    let disk = size::disk(case).map(|bytes| format!("{} on the disk", size(bytes)));
    let minutes = seconds.map(|seconds| {
        format!(
            "at least {} on two idle cores; the start, and steps of more than two coupling iterations, take longer",
            human(seconds)
        )
    });
    let cost: Vec<String> = minutes.into_iter().chain(disk).collect();
    if !cost.is_empty() {
        lines.push(("cost", cost.join("; ")));
    }
    lines
}

/// What was understood of the files with curves.
fn of_files(case: &Case) -> Vec<(&'static str, String)> {
    let Some(vessel) = case.vessel() else {
        return Vec::new();
    };
    let keys = vessel.opening_keys();
    let lines = keys.iter().filter_map(|keys| {
        let (_, path) = keys.condition.file()?;
        let condition = keys.condition.read(keys.end, case.time.period).ok()?;
        let table = condition.flow()?.table()?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Some(("read", format!("{name}: {}", table.understood())))
    });
    lines.collect()
}

/// Flow and pressures.
fn of_blood(figures: &CaseFigures) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    if let Some(flow) = figures.flow {
        lines.push((
            "flow",
            format!(
                "{:.1} ml/min on average, at most {:.2} ml/s ({:.3} m/s); Reynolds number {:.0} on average, at most {:.0} where it \
                 is narrowest; Womersley number {:.2}",
                6e7 * flow.mean,
                1e6 * flow.peak,
                flow.velocity[1],
                flow.reynolds[0],
                flow.reynolds[1],
                figures.womersley
            ),
        ));
    }
    if let Some(pressures) = figures.pressures {
        lines.push((
            "pressure",
            format!(
                " {:.1} mmHg on average to be expected, from {:.1} to {:.1}{}",
                pressures.mean / MMHG,
                pressures.lowest / MMHG,
                pressures.highest / MMHG,
                figures.as_tubes()
            ),
        ));
    }
    lines
}

/// A section's wall.
fn of_wall(wall: &figures::TubeFigures) -> (&'static str, String) {
    let mut text = format!(
        "{}: h/r {:.3} without load",
        wall.name, wall.thickness_ratio
    );
    match (wall.radius, wall.distension) {
        (Some(radius), Some(distension)) => {
            text += &format!(
                "; under these pressures as a long tube held along its axis radius {:.3} mm, distension {:.1} %",
                1e3 * radius,
                1e2 * distension
            );
        }
        _ => text += "; as a long tube it cannot carry these pressures",
    }
    ("wall", text)
}

fn described(deviation: &Deviation) -> String {
    format!(
        "the mesh's radii differ from those described by {:.2} % at most (s = {:.2} mm), its volume by {:.2} %",
        1e2 * deviation.share,
        1e3 * deviation.at,
        1e2 * deviation.volume
    )
    .replace("-0.00 %", "0.00 %")
}

/// What to do where a mesh does not have the described lumen.
fn told(deviation: &Deviation) -> String {
    format!(
        "{}, {:.2} mm there: what is described is finer than the mesh along the vessel; take more pieces along \
         (fluid.native.axial_per_section or fluid.mesh.axial_per_section), or a longer blend_length_m",
        described(deviation),
        1e3 * deviation.radius
    )
}

fn size(bytes: f64) -> String {
    match bytes {
        b if b < 1e9 => format!("{:.0} MB", 1e-6 * b),
        b => format!("{:.1} GB", 1e-9 * b),
    }
}

/// The wall of a vessel under pressures (Pa, ascending), with and without its imperfection.
fn figures(
    case: &Case,
    vessel: &BloodVessel,
    pressures: &[f64],
) -> Result<WallFigures, SolidError> {
    let perfect = case.without_imperfection();
    let sections: Vec<Section> = (Vessel::new(vessel).elastic_sections().cloned()).collect();
    with_wall(case, |wall| match &perfect {
        None => WallFigures::new(wall, None, &sections, pressures),
        Some(perfect) => with_wall(perfect, |perfect| {
            WallFigures::new(wall, Some(perfect), &sections, pressures)
        }),
    })
}

/// How large the user's mesh of the fluid is, so that a wrong unit is seen.
fn extent(fit: &Fit) -> String {
    let [low, high] = fit.bounds;
    let size = high - low;
    let openings = fit.openings.iter().filter_map(|(name, diameter)| {
        Some(format!("{name} {}", length(diameter.as_ref().copied()?)))
    });
    let openings = openings.collect::<Vec<_>>().join(", ");
    let openings = match openings.is_empty() {
        true => String::new(),
        false => format!("; hydraulic diameters: {openings}"),
    };
    format!(
        "mesh    {} x {} x {}, from ({:.4}, {:.4}, {:.4}) to ({:.4}, {:.4}, {:.4}) m{openings}\n",
        length(size.x),
        length(size.y),
        length(size.z),
        low.x,
        low.y,
        low.z,
        high.x,
        high.y,
        high.z
    )
}

/// A length (m) in the unit that a person would take.
fn length(metres: f64) -> String {
    match metres.abs() {
        size if size > 0.99999 => format!("{metres:.4} m"),
        size if size >= 1e-3 => format!("{:.2} mm", 1e3 * metres),
        _ => format!("{:.2} µm", 1e6 * metres),
    }
}

/// Where the fluid does not touch the wall.
fn bare([low, high]: [Vec3; 2]) -> String {
    format!(
        " and carries no load, between ({:.4e}, {:.4e}, {:.4e}) and ({:.4e}, {:.4e}, {:.4e}) m",
        low.x, low.y, low.z, high.x, high.y, high.z
    )
}

/// How fast pulses travel in each section, under the mean pressure to expect.
fn waves(case: &Case, vessel: &BloodVessel) -> String {
    let Ok(expected) = Pressures::expected(vessel, case.time.period, 0.0) else {
        return String::new();
    };
    let whole = Vessel::new(vessel);
    let line = |section: &Section| {
        let speeds = match wave_speeds(case, vessel, section, expected.mean) {
            Ok(speeds) => format!(
                "{:.2} m/s with the wall held along its axis (Bramwell and Hill), {:.2} m/s where it slides along itself",
                speeds.held, speeds.sliding
            ),
            Err(error) => format!("unknown: {error}"),
        };
        format!(
            "waves   in the {} under {:.0} mmHg: {speeds}\n",
            section.name,
            expected.mean / MMHG
        )
    };
    whole.elastic_sections().map(line).collect()
}

/// How the user's meshes fit together.
fn fit(case: &Case) -> Result<Fit, Failure> {
    let domain = Domain::new(case).map_err(|e| Failure::Input(e.to_string()))?;
    Fit::of(case, &domain).map_err(|e| Failure::Input(e.to_string()))
}

fn mmhg(pressure: f64) -> String {
    format!("{:.2} kPa ({:.0} mmHg)", 1e-3 * pressure, pressure / MMHG)
}

/// What `--wall` prints.
fn in_figures(case: &Case, pressed: &Pressed<'_>) -> Result<String, Failure> {
    // The wall's own compliance, which is not known yet, brings them closer together.
    let period = case.time.period;
    let (maker, expected) = match pressed {
        Pressed::Tree(tree) => (
            "the openings make",
            Pressures::expected_in_tree(tree, period, 0.0),
        ),
        Pressed::Vessel(vessel) => {
            let maker = match vessel.condition_at(VesselSide::End) {
                _ if !vessel.condition_at(VesselSide::Start).is_flow() => "the inlet makes",
                ConditionKeys::Windkessel { .. } => "the windkessel makes",
                _ => "the outlet makes",
            };
            (maker, Pressures::expected(vessel, period, 0.0))
        }
    };
    let expected = expected.map_err(|e| Failure::Input(e.to_string()))?;
    if expected.mean.min(expected.highest) <= 0.0 {
        return Err(Failure::Input(format!(
            "--wall: {maker} a mean pressure of {:.0} Pa; only walls under internal pressure are examined",
            expected.mean
        )));
    }
    let pressures = [expected.mean, expected.highest];
    let wall = match pressed {
        Pressed::Vessel(vessel) => figures(case, vessel, &pressures),
        Pressed::Tree(tree) => with_wall(case, |wall| {
            WallFigures::of_tree(wall, &tree.branches(), &pressures)
        }),
    };
    let wall = wall.map_err(|e| Failure::Run(e.to_string()))?;
    let mut text = format!(
        "the wall alone, in statics; {maker} {} on average and at most {}\n",
        mmhg(expected.mean),
        mmhg(expected.highest)
    );
    text += &radii(&wall);
    text += &widenings(&wall);
    if let Pressed::Tree(tree) = pressed {
        text += &storage(tree, &wall, &expected, period)?;
    }
    if wall.tissue_shares.iter().any(|share| *share != 0.0) {
        for (pressure, share) in wall.pressures.iter().zip(&wall.tissue_shares) {
            text += &format!(
                "  of {} the tissue around the wall carries {:.1} %\n",
                mmhg(*pressure),
                1e2 * share
            );
        }
    }
    let is_perfect = matches!(pressed, Pressed::Tree(_));
    text += &buckling(&wall, expected.highest, is_perfect);
    Ok(text)
}

/// What the wall of a tree stores between the mean and the highest of the pressures that were `expected` without it,
/// and the pressures to expect with that. Nothing if the pressure does not pulsate, or the wall does not carry it.
fn storage(
    tree: &TreeKeys,
    wall: &WallFigures,
    expected: &Pressures,
    period: f64,
) -> Result<String, Failure> {
    let [mean, highest] = wall.volumes[..] else {
        return Ok(String::new());
    };
    if highest <= mean {
        return Ok(String::new());
    }
    let own = (highest - mean) * wall.lumen_volume / (expected.highest - expected.mean);
    let stored = Pressures::expected_in_tree(tree, period, own);
    let stored = stored.map_err(|e| Failure::Input(e.to_string()))?;
    Ok(format!(
        "  so it stores {own:.2e} m³/Pa, with which the openings make {:.1} to {:.1} mmHg, without {:.1} to {:.1}\n",
        stored.lowest / MMHG,
        stored.highest / MMHG,
        expected.lowest / MMHG,
        expected.highest / MMHG
    ))
}

/// How far the wall of a tree is widened.
fn widenings(wall: &WallFigures) -> String {
    let mut text = String::new();
    for (i, (pressure, volume)) in wall.pressures.iter().zip(&wall.volumes).enumerate() {
        let parts = wall.parts.iter();
        let parts = parts.map(|part| format!("{} {:.3} mm", part.name, 1e3 * part.widenings[i]));
        text += &format!(
            "  under {} the lumen has {volume:.3} times the volume that it has without load; wider by: {}\n",
            mmhg(*pressure),
            parts.collect::<Vec<_>>().join(", ")
        );
    }
    text
}

/// How far the wall is widened and moved sideways in the middle of each section.
fn radii(wall: &WallFigures) -> String {
    let mut text = String::new();
    for section in &wall.sections {
        text += &format!(
            "  lumen in the middle of the {}: radius {:.3} mm without load\n",
            section.name,
            1e3 * section.radius
        );
        let loaded = wall
            .pressures
            .iter()
            .zip(&section.loaded_radii)
            .zip(&section.shifts);
        for ((pressure, radius), shift) in loaded {
            text += &format!(
                "    {:<20} {:.3} mm, stretch {:.3}, centre moved by {:.3} mm\n",
                mmhg(*pressure),
                1e3 * radius,
                radius / section.radius,
                1e3 * shift
            );
        }
    }
    text
}

/// Where the wall buckles, next to the highest pressure (Pa) that is expected; one that `is_perfect` has no
/// imperfection that it could be without.
fn buckling(wall: &WallFigures, highest: f64, is_perfect: bool) -> String {
    let mut text = String::new();
    let without = match is_perfect {
        true => "",
        false => "without its imperfection ",
    };
    if let Some(pressure) = wall.buckling.filter(|_| !is_perfect) {
        text += &format!("  it buckles at {}\n", mmhg(pressure));
    }
    text += &match wall.perfect_buckling {
        Some(pressure) => format!(
            "  {without}it buckles at {}, {:.2} times the highest pressure{}\n",
            mmhg(pressure),
            pressure / highest,
            if pressure < 1.25 * highest {
                ": so close, displacements are those of a buckling column (docs/wall.md)"
            } else {
                ""
            }
        ),
        None => format!(
            "  {without}it does not buckle up to {}{}\n",
            mmhg(wall.reach),
            if wall.is_cut_short {
                ", the highest pressure; no equilibrium was found at twice that"
            } else {
                ""
            }
        ),
    };
    text
}
