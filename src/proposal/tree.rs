//! A case for a vessel that branches: an opening for each end, windkessels that share the flow.

use super::beat::{Beat, fitting};
use super::ends::{Ends, MURRAY, branch_name};
use super::files::rounded;
use super::smoothing::Smoothing;
use super::text::{FLOW, flow_file, name};
use super::wall::{BULK, SHEAR, THICKNESSES, Wall, pressure};
use super::{Figures, Like, Proposal, ProposalError, ProposalInput, impossible, sac, told};
use crate::case::{
    Case, FlowCurve, Inflow, LengthUnit, LineReading, MAX_ENDS, Preset, ResolvedCase, lines_of_tree,
};
use crate::curve::nearest_of;
use crate::geometry::tree::{Tree, TreeMeshes, TreeMistake};
use crate::polydata::PolyData;
use crate::tabular::units::MMHG;
use fsi_numerics::quadrature::Rule;
use fsi_numerics::twelve_digits;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The largest step, s: each costs several iterations.
const STEP: f64 = 5e-3;
/// Duration of systole and of the ramp, in beats.
const SYSTOLE: f64 = 0.4;
const RAMP: f64 = 0.1;
/// Lengths (radii) of the driver's own elements that are tried where those of usual length are inside out.
const SHORTER: [f64; 3] = [0.7, 0.5, 0.35];
/// The line that those follow.
const CELL_LENGTH: &str = "length = 0.4 # of a cell, in radii\n";
/// A cell whose scaled Jacobian is less than this is nearly flat ...
const FLAT: f64 = 0.05;
/// ... and lines are not smoothed more once it is better than this.
const GOOD: f64 = 0.15;

/// Whether the file of the centre-line is a tree of which no branch is chosen.
///
/// # Errors
/// If it has several lines that make no tree.
pub(super) fn is_meant(input: &ProposalInput) -> Result<bool, ProposalError> {
    if !input.branches.is_empty() {
        return Ok(true);
    }
    let Some(path) = input.line.as_ref().filter(|_| input.branch.is_none()) else {
        return Ok(false);
    };
    match lines_of_tree(path) {
        Ok(lines) => Ok(lines.len() > 1),
        // Of what cannot be read as one line either, what is wrong with the tree says more.
        Err(_) if LineReading::of(path, None).is_ok() => Ok(false),
        Err(fault) if has_several_lines(path) => Err(ProposalError::Input(format!(
            "--from {}: {fault} (--branch takes one line alone)",
            path.display()
        ))),
        Err(_) => Ok(false),
    }
}

fn has_several_lines(path: &Path) -> bool {
    let is_swc = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("swc"));
    is_swc || PolyData::read(path).is_ok_and(|data| data.lines.len() > 1)
}

/// Makes the case.
///
/// # Errors
/// What is missing, or all mistakes of the case.
pub(super) fn proposal(input: &ProposalInput) -> Result<Proposal, ProposalError> {
    let unit = only_trees(input)?;
    let (input, remarks) = sac::closed(input, unit)?;
    let found = of_ends(&input, unit, remarks.clone());
    let Some(bulges) = sac::as_bulges(&input).filter(|_| found.is_err()) else {
        return found;
    };
    let remark = format!(
        "sac       {}: as a branch it has no mesh, so it is a bulge of the wall that it lies at (tree.leave_out)",
        input.closed.join(", ")
    );
    let remarks = remarks.into_iter().chain([remark]).collect();
    of_ends(&bulges, unit, remarks).or(found)
}

/// Makes the case with these openings and sacs.
fn of_ends(
    input: &ProposalInput,
    unit: LengthUnit,
    of_sacs: Vec<String>,
) -> Result<Proposal, ProposalError> {
    let (input, ends, tried, left_out) = with_possible_ends(input, unit)?;
    let input = &input;
    let beat = Beat::of(input)?;
    let mut remarks = vec![format!(
        "read      {}: a tree with {} ends{}{}{}",
        input.shown_lines(),
        ends.lines.len(),
        match ends.lines.len() - ends.shares.len() {
            0 => String::new(),
            closed => format!(", {closed} of them closed,"),
        },
        input.least_radius.map_or(String::new(), |least| format!(
            " of vessels of at least {} mm",
            twelve_digits(1e3 * least)
        )),
        match input.branches.is_empty() {
            true => " (--branch takes one line alone)",
            false => "",
        }
    )];
    remarks.extend(of_sacs);
    remarks.extend(left_out);
    remarks.extend(beat.remarks);
    let pulse = FLOW
        .1
        .map(|flow| rounded(flow * (ends.radii[0] / FLOW.0).powi(2)));
    let inflow = Inflow {
        file: input.flow.clone(),
        unit: input.flow_unit,
        file_period: input.flow_period,
        ..Inflow::pulse(pulse[0], pulse[1], rounded(SYSTOLE * beat.period), 1.0)
    };
    let curve = FlowCurve::new(&inflow, beat.period)
        .map_err(|e| ProposalError::Input(told::in_options(&format!("--flow: {e}"))))?;
    let (figures, more) = figures(input, &ends, curve)?;
    remarks.extend(more);
    let mut files = Vec::new();
    let others = [&input.lumen, &input.flow].into_iter().flatten();
    for path in input.line.iter().chain(&input.branches).chain(others) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if !input.branches.is_empty() && files.iter().any(|(other, _)| *other == name) {
            let reason = format!("two files are called {name}: rename one of them");
            return Err(ProposalError::Input(reason));
        }
        files.push((name.into_owned(), path.clone()));
    }
    let text =
        |smoothing, wall: &Wall| text(input, unit, &ends, (pulse, smoothing), wall, &figures);
    let refused = |mistake: TreeMistake| {
        let smoother = match tried.len() {
            1 => "",
            _ => "; smoother lines have no mesh either",
        };
        let advice = impossible::advice(input, unit, &ends);
        let reason = format!(
            "--from {}: {mistake}{smoother}{advice}",
            input.shown_lines()
        );
        ProposalError::Input(reason)
    };
    let walls = Wall::tried(input, &figures);
    let found = with_mesh(input, &files, &tried, |way| text(way, &walls[0]), refused)?;
    remarks.extend(found.smoothing.remark(input, unit, &ends));
    remarks.extend(found.remarks);
    let faces = found.lumen.faces();
    let mut texts = walls.into_iter().map(|wall| {
        let text = text(found.smoothing, &wall.with_compliance(&faces));
        with_native_length(text, found.native_length)
    });
    let first = texts.next().expect("one wall at least is tried");
    let thinner = THICKNESSES[1..].iter().copied().zip(texts).collect();
    Ok(Proposal {
        text: first,
        thinner,
        files,
        remarks,
        way: found.smoothing.way,
        with_mesh: found.with_mesh,
        without_mesh: found.without_mesh,
    })
}

/// The ends of the tree, without those that have no mesh if these are to be left out: with the options that say so, how
/// the lines are smoothed, and what is to be said of what is left out.
fn with_possible_ends(
    input: &ProposalInput,
    unit: LengthUnit,
) -> Result<(ProposalInput, Ends, Vec<Smoothing>, Vec<String>), ProposalError> {
    let ends = Ends::of(input, unit)?;
    let count = ends.lines.len();
    if count > MAX_ENDS {
        return Err(ProposalError::Input(format!(
            "--from {}: {count} ends are more than {MAX_ENDS}: leave out thin vessels{}",
            input.shown_lines(),
            few_enough(input, unit, &ends)
        )));
    }
    let mut chosen = input.clone();
    if !input.leaves_impossible_out {
        let tried = Smoothing::tried(input, &ends);
        return Ok((chosen, ends, tried, Vec::new()));
    }
    let found = impossible::of(input, unit, &ends)?;
    found.put_into(&mut chosen, &ends);
    let possible = Ends::of(&chosen, unit)?;
    let remarks = found.remarks(count);
    Ok((chosen, possible, vec![found.smoothing], remarks))
}

fn two_digits(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}

/// The option with which few enough ends are left, in words.
fn few_enough(input: &ProposalInput, unit: LengthUnit, ends: &Ends) -> String {
    let left = |share: i32| {
        let mut input = input.clone();
        // These are for the number of ends that the file has.
        (input.names, input.split) = Default::default();
        (input.leave_out, input.closed) = Default::default();
        let least = two_digits(0.05 * f64::from(share) * ends.range[1]);
        input.least_radius = Some(least);
        let count = Ends::of(&input, unit).ok()?.lines.len();
        (count <= MAX_ENDS).then_some((least, count))
    };
    let found = (1..60).find_map(left);
    found.map_or(String::new(), |(least, count)| {
        format!(
            ", as --least-radius {}mm does, with which {count} ends are left",
            twelve_digits(1e3 * least)
        )
    })
}

/// How lines are smoothed so that they have a mesh.
struct Meshed {
    smoothing: Smoothing,
    lumen: MeshedLumen,
    /// Length (radii) of the driver's own elements, if it is not the usual one.
    native_length: Option<f64>,
    /// What is to be said of it.
    remarks: Vec<String>,
    /// The ways of smoothing that were tried and lead to a mesh, with its smallest scaled Jacobian.
    with_mesh: Vec<(usize, f64)>,
    /// Those that lead to none.
    without_mesh: Vec<usize>,
}

/// The best of the ways of smoothing that were tried.
struct Best {
    smoothing: Smoothing,
    /// The smallest scaled Jacobian of a cell.
    worst: f64,
    /// Case and mesh, unless only how good it is was known before.
    case: Option<(ResolvedCase, MeshedLumen)>,
}

/// The case whose lines have a mesh as they are, or the first one with a good one, or else the best, of those smoothed
/// as is tried. `text` writes it, `refused` says what is wrong with the first one.
fn with_mesh(
    input: &ProposalInput,
    files: &[(String, PathBuf)],
    tried: &[Smoothing],
    text: impl Fn(Smoothing) -> String,
    refused: impl Fn(TreeMistake) -> ProposalError,
) -> Result<Meshed, ProposalError> {
    let trial = tempfile::tempdir()?;
    for (name, path) in files {
        std::fs::copy(path, trial.path().join(name))
            .map_err(|error| ProposalError::Input(format!("{}: {error}", path.display())))?;
    }
    let made = |smoothing| -> Result<ResolvedCase, ProposalError> {
        let text = text(smoothing);
        let load = |preset| super::load(trial.path(), &text, input, preset);
        load(Preset::Paper).and_then(|_| load(Preset::Demo))
    };
    let mut first = None;
    let mut best: Option<Best> = None;
    let (mut with_mesh, mut without_mesh) = (Vec::new(), Vec::new());
    for &smoothing in tried {
        let known = input
            .known
            .iter()
            .find(|(way, _)| Some(*way) == smoothing.way);
        let (worst, case) = if let Some((_, worst)) = known {
            (*worst, None)
        } else {
            let case = match made(smoothing) {
                Ok(made) => made,
                // Smoother lines may leave the surface.
                Err(ProposalError::Case(_)) if !smoothing.is_none() && tried.len() > 1 => {
                    without_mesh.extend(smoothing.way);
                    continue;
                }
                Err(error) => return Err(error),
            };
            match MeshedLumen::of(&case) {
                Ok(lumen) => (lumen.worst, Some((case, lumen))),
                Err(mistake) if !mistake.is_of_shape() => return Err(refused(mistake)),
                Err(mistake) => {
                    without_mesh.extend(smoothing.way);
                    first.get_or_insert(mistake);
                    continue;
                }
            }
        };
        with_mesh.extend(smoothing.way.map(|way| (way, worst)));
        if best.as_ref().is_none_or(|known| worst > known.worst) {
            best = Some(Best {
                smoothing,
                worst,
                case,
            });
        }
        if worst > GOOD || smoothing.is_none() {
            break;
        }
    }
    let best = match (best, first) {
        (Some(best), _) => best,
        (None, Some(first)) => return Err(refused(first)),
        (None, None) => return Err("all ways of smoothing the lines were tried".into()),
    };
    let (case, lumen) = match best.case {
        Some(found) => found,
        None => {
            let case = made(best.smoothing)?;
            let lumen = MeshedLumen::of(&case).map_err(refused)?;
            (case, lumen)
        }
    };
    let (native_length, elements) = native_length(&case);
    let remarks = [Some(lumen.words.clone()), elements];
    Ok(Meshed {
        smoothing: best.smoothing,
        native_length,
        remarks: remarks.into_iter().flatten().collect(),
        lumen,
        with_mesh,
        without_mesh,
    })
}

/// That no option is given which only a single vessel has; and the unit of the lines.
fn only_trees(input: &ProposalInput) -> Result<LengthUnit, ProposalError> {
    let has_branches = !input.branches.is_empty();
    let given = [
        ("--branch", has_branches && input.branch.is_some()),
        ("--like", input.like != Like::Uniform),
        ("--reverse", input.is_reversed),
        ("--radius", input.radius.is_some()),
    ];
    if let Some((option, _)) = given.into_iter().find(|(_, is_given)| *is_given) {
        let other = match (has_branches, option) {
            (_, "--radius") => ": the radii of a tree are those along its lines, in the files",
            (true, _) => "",
            (false, _) => ", or choose one line with --branch",
        };
        return Err(ProposalError::Input(format!(
            "{option} is for a single vessel, and --from {} has several ends: leave it out{other}",
            input.shown_lines()
        )));
    }
    let of_header = |path: &PathBuf| LineReading::of(path, None).ok()?.unit;
    let of_header = || {
        input
            .line
            .as_ref()
            .filter(|_| has_branches)
            .and_then(of_header)
    };
    let advice = "--from needs the unit of its lengths: --unit mm, m, cm or um";
    input.unit.or_else(of_header).ok_or_else(|| advice.into())
}

/// What meshes and windkessels follow from, and what is to be said of it.
fn figures(
    input: &ProposalInput,
    ends: &Ends,
    curve: FlowCurve,
) -> Result<(Figures, Vec<String>), ProposalError> {
    let period = curve.period();
    let flows: Vec<f64> = (0..1000)
        .map(|i| curve.flow(period * f64::from(i) / 1000.0))
        .collect();
    let flows = [
        flows.iter().sum::<f64>() / 1000.0,
        flows.iter().fold(0.0f64, |most, q| most.max(q.abs())),
    ];
    let plausible = told::plausible(input, &curve, flows, ends.radii[0])?;
    let nu = viscosity_of_defaults()?;
    let omega = TAU / period;
    let of_outlets = ends.radii[1..].iter().zip(&ends.shares);
    let of_all = of_outlets.map(|(r, share)| 2.0 * share * flows[1] / (PI * r * nu));
    let reynolds = of_all.fold(2.0 * flows[1] / (PI * ends.radii[0] * nu), f64::max);
    let shares = ends.names[1..].iter().zip(&ends.shares);
    let shares: Vec<String> = shares
        .map(|(name, share)| format!("{name} {:.1} %", 100.0 * share))
        .collect();
    let origin = match (input.split.is_empty(), input.murray.unwrap_or(MURRAY)) {
        (true, exponent) => {
            format!("by the radius at the end to the power of {exponent} (--split gives your own)")
        }
        (false, _) => "as given".into(),
    };
    let mut remarks = vec![
        format!(
            "lumen     radius {:.2} mm at \"{}\", {:.2} mm at the narrowest place, {:.2} mm on average; lines up to {:.1} mm long",
            1e3 * ends.radii[0],
            ends.names[0],
            1e3 * ends.range[0],
            1e3 * ends.range[1],
            1e3 * ends.length
        ),
        format!(
            "flow      {:.0} ml/min on average{}, at most {:.1} ml/s; Reynolds number at most {reynolds:.0}",
            6e7 * flows[0],
            if input.flow.is_some() {
                ""
            } else {
                ", chosen for the radius (--flow gives your own)"
            },
            1e6 * flows[1]
        ),
        format!("split     {}: {origin}", shares.join(", ")),
    ];
    if reynolds > super::TURBULENT {
        remarks.push(super::turbulent());
    }
    remarks.extend(plausible);
    // A surface says how wide the lumen is.
    let scatter = ends.scatter.filter(|_| input.lumen.is_none());
    remarks.extend(scatter.map(|[jump, all]| {
        format!(
            "warning: the radii of the lines scatter, as radii in voxels do: {jump} of {all} are more than a quarter off from the one \
             before, and the lumen is as uneven; smooth them in the file, or give the surface (--lumen)"
        )
    }));
    let figures = Figures {
        radii: ends.range,
        curve,
        flows,
        layer: (2.0 * nu / omega).sqrt(),
        lengths: [ends.length; 2],
    };
    Ok((figures, remarks))
}

/// Kinematic viscosity, m²/s.
fn viscosity_of_defaults() -> Result<f64, ProposalError> {
    let folder = tempfile::tempdir()?;
    std::fs::write(folder.path().join("case.toml"), "extends = \"defaults\"\n")?;
    let case = Case::load(folder.path(), Preset::Paper, &[])
        .map_err(|errors| ProposalError::Case(errors.to_string()))?;
    Ok(case.blood.viscosity / case.blood.density)
}

/// The lumen of a case in cells.
struct MeshedLumen {
    /// The smallest scaled Jacobian.
    worst: f64,
    /// How well it is meshed.
    words: String,
    /// The patches of the wall.
    walls: Vec<String>,
    meshes: TreeMeshes,
}

impl MeshedLumen {
    fn of(case: &ResolvedCase) -> Result<Self, TreeMistake> {
        let tree = case.tree().expect("the text has a tree");
        let meshes = Tree::meshes(tree)?;
        let (worst, x) = meshes.worst;
        let flat = match worst < FLAT {
            true => format!(
                ", at ({:.4}, {:.4}, {:.4}) m: nearly flat, expect many iterations or a run that fails; smoother lines (--smoothing) or \
                 fewer branches (--leave-out) help",
                x.x, x.y, x.z
            ),
            false => String::new(),
        };
        let notes: String = (meshes.notes.iter())
            .map(|note| format!("\n          {note}"))
            .collect();
        let words = format!(
            "mesh      {} branches; demo has {} cells, whose smallest scaled Jacobian is {worst:.2}{flat}{notes}",
            meshes.lines.len(),
            meshes.outside.cells()
        );
        Ok(Self {
            worst,
            words,
            walls: tree.walls(),
            meshes,
        })
    }

    /// Area (m²) of each face of the wall, and radius (m) of the lumen there.
    fn faces(&self) -> Vec<[f64; 2]> {
        let (surface, lines) = (&self.meshes.surface, &self.meshes.lines);
        let mut faces = Vec::new();
        for wall in &self.walls {
            let patch = surface.patch(wall);
            let of_patch = patch.map_or(0..0, |patch| patch.start..patch.start + patch.size);
            let lines = lines.iter().filter(|(patch, _)| patch == wall);
            let lines: Vec<_> = lines.map(|(_, line)| line).collect();
            for face in of_patch {
                let (middle, area) = surface.face_geometry(face);
                if let Some((_, nearest)) = nearest_of(lines.iter().copied().enumerate(), &middle) {
                    faces.push([area.norm(), (middle - nearest.frame.origin).norm()]);
                }
            }
        }
        faces
    }
}

/// Length (radii) of the driver's own elements with which none is inside out, if the usual one is too long, and what is
/// to be said of them.
fn native_length(case: &ResolvedCase) -> (Option<f64>, Option<String>) {
    let keys = case.tree().expect("the text has a tree");
    let nodes = Rule::gauss_lobatto(keys.elements().degree() + 1).points;
    let mistake = match Tree::of_elements(keys, &nodes) {
        Ok(_) => return (None, None),
        Err(mistake) => mistake,
    };
    let is_whole = |length: &f64| {
        let mut keys = keys.clone();
        keys.native.get_or_insert_default().length = Some(*length);
        Tree::of_elements(&keys, &nodes).is_ok()
    };
    let length = SHORTER.into_iter().find(is_whole);
    let words = match length {
        Some(length) => format!(
            "elements  of the driver's own fluid are {length} radii long (tree.native.length): with 1, some would be inside out"
        ),
        None => format!(
            "warning: the driver's own elements (--fluid native) have no mesh here, OpenFOAM's cells do: {mistake}"
        ),
    };
    (length, Some(words))
}

/// A case with elements of the driver's own fluid of this length (radii), if it is given.
fn with_native_length(text: String, length: Option<f64>) -> String {
    let Some(length) = length else {
        return text;
    };
    let line = format!(
        "{CELL_LENGTH}native.length = {length} # of an element of the driver's own fluid\n"
    );
    text.replace(CELL_LENGTH, &line)
}

fn text(
    input: &ProposalInput,
    unit: LengthUnit,
    ends: &Ends,
    (pulse, smoothing): ([f64; 2], Smoothing),
    wall: &Wall,
    figures: &Figures,
) -> String {
    let period = figures.curve.period();
    let mut text = String::from(
        "# A vessel of your own that branches, as `fsi-driver new` proposes it. What is not here has the value of the\n\
         # defaults: `fsi-driver keys` lists all keys, docs/trees.md explains those of [tree].\n\
         extends = \"defaults\"\n\n[tree]\n",
    );
    if let Some(path) = input.line.as_ref().filter(|_| input.branches.is_empty()) {
        let _ = writeln!(text, "lines = {}", name(path));
    }
    let _ = writeln!(text, "unit = \"{}\" # of the files", unit.name());
    if let Some(length) = smoothing.waves {
        let _ = writeln!(
            text,
            "smoothing_m = {length:e} # waves of the lines of this length are halved"
        );
    }
    if let Some(radii) = smoothing.junctions {
        let _ = writeln!(
            text,
            "junction_smoothing = {radii:?} # radii next to where branches part within which smooth curves replace the lines"
        );
    }
    if let Some(least) = input.least_radius {
        let _ = writeln!(
            text,
            "least_radius_m = {least:e} # thinner vessels are left out"
        );
    }
    if let Some(path) = &input.lumen {
        let _ = writeln!(text, "lumen = {}", name(path));
        if let Some(unit) = input.lumen_unit {
            let _ = writeln!(text, "lumen_unit = \"{}\"", unit.name());
        }
        text += "# lumen_smoothing_m = 1e-3 # waves of this length are halved; if absent, three times that of an edge\n";
    }
    let quoted = |names: &[String]| -> Vec<String> {
        let all = names.iter().map(|name| toml::Value::from(name.as_str()));
        all.map(|name| name.to_string()).collect()
    };
    let in_file = quoted(&ends.in_file).join(", ");
    let list = |key: &str, names: &[String], comment: &str| match names {
        [] => String::new(),
        names => format!("{key} = [{}]{comment}\n", quoted(names).join(", ")),
    };
    let left_out = list("leave_out", &input.leave_out, "");
    let closed = list(
        "closed",
        &input.closed,
        " # no openings: half a sphere ends these lines",
    );
    let quoted = quoted(&ends.names);
    let (rings, grading) = figures.rings(5, 3.0);
    let _ = write!(
        text,
        "inlet = {} # rename the openings here and in the tables below\noutlets = [{in_file}]\n{left_out}{closed}\
         core = 4 # cells along a side of the square in the \
         middle of a cross-section\nradial = {rings} # rings of cells around it: the one at the wall is a quarter of the Stokes layer \
         thick\nwall_grading = {grading:?}\n{CELL_LENGTH}",
        quoted[0]
    );
    if !input.branches.is_empty() {
        for path in input.line.iter().chain(&input.branches) {
            let (line, file) = (toml::Value::from(branch_name(path)), name(path));
            let _ = writeln!(text, "\n[[tree.line]]\nname = {line}\nfile = {file}");
        }
    }
    openings(
        input,
        ends,
        &quoted,
        (pulse, wall.compliance),
        figures,
        &mut text,
    );
    let (thickness, pressure, springs) = (wall.line(), wall.pressure, wall.springs);
    let _ = write!(
        text,
        "\n[wall.extrude]\nlayers = [\"wall\"] # from the inside out\n{thickness}\nfaces_per_element = 2\n\n[[wall.material]] # put your own \
         here\nname = \"wall\"\nmaterial = \"neo_hooke\"\nmu_Pa = {SHEAR:e}\nkappa_Pa = {BULK:e}\n\n[[wall.support]] # the tissue around it: long \
         branches without would buckle\nsupport = \"springs\"\nsurfaces = [\"outer\"]\nspring_Pa_m = {springs:e} # per area: a tenth of the wall's \
         own stiffness against widening\n\n[[wall.support]]\nsupport = \
         \"clamped\"\nsurfaces = [{}]\n\n[wall.initial]\npressure_Pa = {pressure:?} # {:.0} mmHg, under which the vessel has the shape of the \
         files: there the run begins\n",
        quoted.join(", "),
        pressure / MMHG
    );
    let step = fitting(STEP, period);
    let _ = write!(
        text,
        "\n[ramp]\nduration_s = {:?} # of the flow\n\n[time]\nstep_s = {step:e} # {:.0} of them are a beat\nperiod_s = {period:?}\nend_s = {:?} # \
         three beats\n\n[structure]\np = 3\n\n[coupling]\nsurrogate = \"potential\"\ne_rel = 1.0e-4\n\n[output]\n\
         structure_interval_s = {:e}\nfluid_interval_s = {:e}\n",
        rounded(RAMP * period),
        period / step,
        twelve_digits(3.0 * period),
        10.0 * step,
        10.0 * step,
    );
    let _ = write!(
        text,
        "\n[preset.demo] # a coarse mesh and 50 steps\ntree.radial = 3\ntree.length = 0.6\ntime.end_s = {:e}\n\
         \n[preset.coarse]\ntree.radial = 4\ntree.length = 0.5\n",
        50.0 * step
    );
    text
}

fn openings(
    input: &ProposalInput,
    ends: &Ends,
    quoted: &[String],
    ([base, amplitude], compliance): ([f64; 2], f64),
    figures: &Figures,
    text: &mut String,
) {
    let period = figures.curve.period();
    let _ = writeln!(
        text,
        "\n[[tree.opening]]\nname = {}\ncondition = \"flow\"",
        quoted[0]
    );
    match &input.flow {
        Some(path) => flow_file(input, path, "flow_", text),
        None => {
            let _ = writeln!(
                text,
                "base_m3_s = {base:e} # a pulse with the velocity of the defaults; or flow_file = \"flow.csv\"\namplitude_m3_s = {amplitude:e}\n\
                 systole_s = {:?}",
                rounded(SYSTOLE * period)
            );
        }
    }
    let whole = figures.windkessel(RAMP * period, input.is_rcr, compliance);
    for ((name, share), radius) in quoted[1..].iter().zip(&ends.shares).zip(&ends.radii[1..]) {
        let _ = writeln!(
            text,
            "\n[[tree.opening]] # {:.1} % of the flow, radius {:.2} mm\nname = {name}",
            100.0 * share,
            1e3 * radius
        );
        let Some(whole) = &whole else {
            let _ = writeln!(
                text,
                "condition = \"pressure\"\npressure_Pa = {:?}",
                pressure(input)
            );
            continue;
        };
        let _ = writeln!(
            text,
            "condition = \"windkessel\" # all of them together make 80 to 120 mmHg of this flow{}\n\
             resistance_Pa_s_m3 = {:e}\ncompliance_m3_Pa = {:e}",
            whole.of_vessel(),
            rounded(whole.resistance / share),
            rounded(whole.compliance * share)
        );
        if let Some(proximal) = whole.proximal {
            let _ = writeln!(
                text,
                "proximal_resistance_Pa_s_m3 = {:e}",
                rounded(proximal / share)
            );
        }
        let _ = writeln!(text, "initial_pressure_Pa = {:?}", pressure(input));
    }
}
