//! `fsi-driver new DIR`: a commented case for a vessel of one's own.

use super::Failure;
use super::quantity::{self, Given};
use crate::Vec3;
use crate::case::{Case, FlowUnit, LengthUnit, Preset};
use crate::output::progress::tell_preparation;
use crate::output::terminal;
use crate::pfem::solution::listener::Work;
use crate::proposal::{Like, Proposal, ProposalError, ProposalInput};
use crate::simulation::assembly::{Domain, sideways_warning};
use rayon::prelude::*;
use std::ops::Range;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const CASE_FILE: &str = "case.toml";
/// Those that have meshes of their own.
const PRESETS: [Preset; 3] = [Preset::Demo, Preset::Coarse, Preset::Paper];

/// What the case is made from.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder to write, which must not exist or be empty.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Centre-line: a table (.csv, .txt, .dat: x,y,z or x,y,z,r), paths of SimVascular (.pth), .vtp of VMTK or
    /// SimVascular, or .swc; of a vessel that branches also a table for each branch, --from again for each, the one at
    /// the inlet first [default: a straight one].
    #[arg(long, value_name = "FILE")]
    from: Vec<PathBuf>,
    /// Surface of the lumen: .stl, .vtp, .vtk, .ply or .obj [default: circles of the centre-line's radii].
    #[arg(long, value_name = "FILE")]
    lumen: Option<PathBuf>,
    /// Names of the openings of a tree: that where its lines begin, then those of their ends in the order of the file
    /// [default: inlet, outlet1, outlet2 and so on].
    #[arg(
        long,
        value_name = "NAME,NAME,...",
        requires = "from",
        value_delimiter = ','
    )]
    names: Vec<String>,
    /// Ends of a tree whose lines are left out, by their names [default: none].
    #[arg(
        long,
        value_name = "NAME,NAME,...",
        requires = "from",
        value_delimiter = ','
    )]
    leave_out: Vec<String>,
    /// Ends of a tree that lie within a sac, such as an aneurysm, and are no openings, by their names [default: those
    /// behind a neck where the surface is closed and round].
    #[arg(
        long,
        value_name = "NAME,NAME,...",
        requires = "from",
        value_delimiter = ','
    )]
    closed: Vec<String>,
    /// Vessels of a tree that are thinner are left out: each line ends where it is last as wide [default: all vessels].
    #[arg(long, value_name = "LENGTH", requires = "from", value_parser = quantity::length, allow_hyphen_values = true)]
    least_radius: Option<Given>,
    /// Smooth curves replace a tree's lines within so many radii of where branches part [default: chosen where the
    /// lines as they are have no mesh or no wall].
    #[arg(
        long,
        value_name = "RADII",
        requires = "from",
        allow_hyphen_values = true
    )]
    junction_smoothing: Option<f64>,
    /// Leave out the ends of a tree without which the others have a mesh, of those that hinder each other that with the
    /// least flow, and say which and why.
    #[arg(long, requires = "from")]
    leave_out_impossible: bool,
    /// Shares of the flow that leave by the ends of a tree, in their order, such as 0.65,0.35 or 65,35 [default: by
    /// --murray].
    #[arg(
        long,
        value_name = "SHARE,...",
        requires = "from",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    split: Vec<f64>,
    /// Flow goes with this power of the radius at the end of a branch [default: 3].
    #[arg(
        long,
        value_name = "EXPONENT",
        requires = "from",
        allow_hyphen_values = true
    )]
    murray: Option<f64>,
    /// Unit of the lengths in these files, unless the header of the line says it.
    #[arg(long, value_name = "m|cm|mm|um", value_parser = unit)]
    unit: Option<LengthUnit>,
    /// Unit of the lengths in the file of the surface [default: --unit].
    #[arg(long, value_name = "m|cm|mm|um", requires = "lumen", value_parser = unit)]
    lumen_unit: Option<LengthUnit>,
    /// Which of several lines, such as CenterlineIds=0; an error lists them.
    #[arg(long, value_name = "NAME", requires = "from")]
    branch: Option<String>,
    /// The blood flows from the end of the line to its beginning.
    #[arg(long, requires = "from")]
    reverse: bool,
    /// Radius of the lumen, such as 3mm (metres without a unit), if no file knows it.
    #[arg(long, value_name = "LENGTH", value_parser = quantity::length, allow_hyphen_values = true)]
    radius: Option<Given>,
    /// Thickness of the artery's wall, such as 0.7mm [default: 0.3 of the radius].
    #[arg(long, value_name = "LENGTH", value_parser = quantity::length, allow_hyphen_values = true)]
    thickness: Option<Given>,
    /// Waves of the centre-line's points of this length are halved [default: one radius, four if the points scatter; in
    /// a tree as short as its mesh needs].
    #[arg(long, value_name = "LENGTH", requires = "from", value_parser = quantity::length, allow_hyphen_values = true)]
    smoothing: Option<Given>,
    /// The vessel has its shape under this pressure, such as 80mmHg [default: it is unloaded].
    #[arg(long, value_name = "PRESSURE", value_parser = quantity::pressure, allow_hyphen_values = true)]
    loaded: Option<Given>,
    /// A windkessel of three elements: a tenth of the resistance is proximal.
    #[arg(long)]
    rcr: bool,
    /// Tissue around the wall: springs and dampers.
    #[arg(long)]
    tissue: bool,
    /// What the vessel is like.
    #[arg(long, value_enum, default_value_t)]
    like: Like,
    /// Flow at the inlet over a period: a table with times and flows, or SimVascular's .flow (cm³/s unless it says
    /// otherwise).
    #[arg(long, value_name = "FILE")]
    flow: Option<PathBuf>,
    /// Unit of the flows in that file [default: that in its header; of a .flow of SimVascular cm3/s].
    #[arg(long, value_name = "UNIT", requires = "flow", value_parser = super::windkessel::unit)]
    flow_unit: Option<FlowUnit>,
    /// Duration of a period of that file, s: the curve is stretched to the beat.
    #[arg(long, value_name = "S", requires = "flow")]
    flow_period: Option<f64>,
    /// Duration of a beat, s [default: that of the curve in the file of the flow, or 1].
    #[arg(long, value_name = "S")]
    period: Option<f64>,
    /// Preset with which the commands that come next are shown: a new case has all of them.
    #[arg(long, value_enum, default_value_t = Preset::Demo)]
    preset: Preset,
}

fn unit(word: &str) -> Result<LengthUnit, String> {
    LengthUnit::spelled(word).ok_or_else(|| "expected m, cm, mm or um".to_owned())
}

/// Writes the folder and says what comes next.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = &arguments.folder;
    let shown = folder.display();
    let is_taken = match std::fs::read_dir(folder) {
        Ok(mut entries) => entries.next().is_some(),
        Err(_) => folder.exists(),
    };
    if is_taken {
        return Err(Failure::Input(format!(
            "{shown} is there already and not an empty folder: choose another name"
        )));
    }
    arguments.check_numbers()?;
    tell_preparation();
    let work = Work::begin("reading the vessel, and trying its mesh and wall");
    let failed = |e: std::io::Error| Failure::Run(format!("cannot write {shown}: {e}"));
    let mut input = arguments.input();
    let mut first = None;
    let (written, mut proposal) = loop {
        let proposed = Proposal::new(&input).map_err(|reason| match reason {
            ProposalError::Io(error) => Failure::Run(error.to_string()),
            other => Failure::Input(other.to_string()),
        });
        // Once the lines have a mesh, but no wall grows on it, what is said is why.
        let mut proposal = match (proposed, first) {
            (Ok(proposal), known) => {
                first = known;
                proposal
            }
            (Err(failure), known) => return Err(known.unwrap_or(failure)),
        };
        let written = written(folder, &proposal).map_err(failed)?;
        let tried = try_wall(
            written.path(),
            &mut proposal,
            arguments.leave_out_impossible,
        );
        match (tried, proposal.way) {
            (Ok(()), _) => break (written, proposal),
            // Of smoother lines one may.
            (Err(failure @ Failure::Input(_)), Some(way)) if arguments.thickness.is_none() => {
                terminal::note(format_args!(
                    "no wall grows on these lines: trying smoother ones"
                ));
                first.get_or_insert(failure);
                input.ruled_out.push(way);
                input.ruled_out.append(&mut proposal.without_mesh);
                input.known = proposal.with_mesh;
            }
            (Err(failure), _) => return Err(failure),
        }
    };
    // Unloaded vessels and those in tissue are not warned of, and not read once more for it.
    if arguments.loaded.is_some()
        && !arguments.tissue
        && let Ok(case) = Case::load(written.path(), Preset::Paper, &[])
    {
        let warning = sideways_warning(&case);
        proposal
            .remarks
            .extend(warning.map(|it| format!("warning: {it}")));
    }
    drop(work);
    put(written, folder).map_err(failed)?;
    let (remarks, preset) = (proposal.remarks.join("\n"), arguments.preset);
    Ok(terminal::print(format_args!(
        "{}\n{remarks}\n\n\
         next:     fsi-driver preview {shown}\n          \
         fsi-driver --case {shown} --preset {preset}      (--fluid native without OpenFOAM)\n          \
         fsi-driver report {shown}/run-{preset} --open\n",
        folder.join("case.toml").display()
    ))?)
}

impl Arguments {
    fn check_numbers(&self) -> Result<(), Failure> {
        const DURATION: &str = "a duration from 0.001 to 1000 s";
        let plain = |number: Option<f64>| {
            number.map(|si| Given {
                si,
                typed: si.to_string(),
            })
        };
        #[rustfmt::skip]
        let numbers = [
            ("--radius", self.radius.clone(), [1e-5, 0.05], "metres, from 1e-5 to 0.05"),
            ("--thickness", self.thickness.clone(), [1e-6, 0.02], "a length from 1e-6 to 0.02 m"),
            ("--smoothing", self.smoothing.clone(), [0.0, 1.0], "a length from 0 to 1 m"),
            ("--junction-smoothing", plain(self.junction_smoothing), [0.0, 10.0], "radii, from 0 to 10"),
            ("--least-radius", self.least_radius.clone(), [1e-6, 0.05], "a length from 1e-6 to 0.05 m"),
            ("--loaded", self.loaded.clone(), [1.0, 1e5], "a pressure from 1 Pa to 100 kPa (750 mmHg)"),
            ("--period", plain(self.period), [1e-3, 1e3], DURATION),
            ("--flow-period", plain(self.flow_period), [1e-3, 1e3], DURATION),
        ];
        for (option, value, [least, most], allowed) in numbers {
            if let Some(value) = value.filter(|value| !(least..=most).contains(&value.si)) {
                let reason = format!("{option} {}: expected {allowed}", value.typed);
                return Err(Failure::Input(reason));
            }
        }
        Ok(())
    }

    fn input(&self) -> ProposalInput {
        let si = |given: &Option<Given>| given.as_ref().map(|given| given.si);
        ProposalInput {
            line: self.from.first().cloned(),
            branches: self.from.iter().skip(1).cloned().collect(),
            lumen: self.lumen.clone(),
            unit: self.unit,
            lumen_unit: self.lumen_unit,
            branch: self.branch.clone(),
            is_reversed: self.reverse,
            radius: si(&self.radius),
            like: self.like,
            flow: self.flow.clone(),
            flow_unit: self.flow_unit,
            flow_period: self.flow_period,
            period: self.period,
            smoothing: si(&self.smoothing),
            junction_smoothing: self.junction_smoothing,
            thickness: si(&self.thickness),
            loaded: si(&self.loaded),
            is_rcr: self.rcr,
            has_tissue: self.tissue,
            names: self.names.clone(),
            leave_out: self.leave_out.clone(),
            closed: self.closed.clone(),
            least_radius: si(&self.least_radius),
            ruled_out: Vec::new(),
            known: Vec::new(),
            leaves_impossible_out: self.leave_out_impossible,
            split: self.split.clone(),
            murray: self.murray,
        }
    }
}

/// The folder under another name, until it is whole.
fn written(folder: &Path, proposal: &Proposal) -> std::io::Result<TempDir> {
    let parent = folder
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    std::fs::create_dir_all(parent)?;
    let whole = tempfile::Builder::new()
        .prefix(".new-")
        .tempdir_in(parent)?;
    for (name, path) in &proposal.files {
        std::fs::copy(path, whole.path().join(name))?;
    }
    std::fs::write(whole.path().join(CASE_FILE), &proposal.text)?;
    Ok(whole)
}

/// The folder under its name.
fn put(whole: TempDir, folder: &Path) -> std::io::Result<()> {
    let permissions = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(whole.path(), permissions)?;
    let _ = std::fs::remove_dir(folder);
    std::fs::rename(whole.keep(), folder)
}

/// Makes the wall of a vessel that branches so thin that no element is inside out in any preset, unless its thickness
/// is given.
fn try_wall(
    folder: &Path,
    proposal: &mut Proposal,
    leaves_impossible_out: bool,
) -> Result<(), Failure> {
    let mut meshed: Vec<(Preset, Option<Domain>)> = PRESETS.map(|preset| (preset, None)).into();
    let mut inside_out_of = |proposal: &Proposal, presets: Range<usize>| -> Result<_, Failure> {
        std::fs::write(folder.join(CASE_FILE), &proposal.text)
            .map_err(|e| Failure::Run(format!("cannot write {CASE_FILE}: {e}")))?;
        inside_out(folder, &mut meshed[presets])
    };
    let refused = |(preset, x): (Preset, Vec3), thinnest: Option<f64>| {
        let advice = match thinnest {
            Some(share) => format!(
                "even one of {share} of the radius; smoother lines (--smoothing), or fewer of the branches that part there \
                 (--leave-out{}), help",
                match leaves_impossible_out {
                    true => "",
                    false => ", or --leave-out-impossible, which chooses them",
                }
            ),
            None => {
                "a smaller --thickness, or none, helps (0.05 to 0.2 of the radius are tried then)"
                    .into()
            }
        };
        Failure::Input(format!(
            "the wall would be inside out near ({:.4e}, {:.4e}, {:.4e}) m with --preset {preset}, where branches part or one bends \
             sharply: {advice}",
            x.x, x.y, x.z
        ))
    };
    let mut thickness = None;
    // The first preset has the fewest cells, and the thinnest wall says at once whether there is any: on these cells
    // first.
    for (untried, presets) in [(0..1, 0..1), (1..PRESETS.len(), 0..PRESETS.len())] {
        let Some(place) = inside_out_of(proposal, untried)? else {
            continue;
        };
        let mut thinnest = proposal.clone();
        let Some(share) = std::iter::from_fn(|| thinnest.make_thinner()).last() else {
            return Err(refused(place, thickness));
        };
        for presets in [0..1, presets.clone()] {
            if let Some(place) = inside_out_of(&thinnest, presets)? {
                return Err(refused(place, Some(share)));
            }
        }
        thickness = loop {
            match proposal.make_thinner() {
                Some(_) if inside_out_of(proposal, presets.clone())?.is_some() => {}
                found => break found,
            }
        };
    }
    proposal.remarks.extend(thickness.map(|share| {
        format!("wall      {share} of the radius thick: with more, elements would be inside out where branches part or bend")
    }));
    Ok(())
}

/// The first preset with which the wall of the case of a vessel that branches is inside out, and where, m. The lumen is
/// `meshed` once for all thicknesses.
fn inside_out(
    folder: &Path,
    meshed: &mut [(Preset, Option<Domain>)],
) -> Result<Option<(Preset, Vec3)>, Failure> {
    let found = |(preset, domain): &mut (Preset, Option<Domain>)| -> Result<_, String> {
        let case = Case::load(folder, *preset, &[]).map_err(|e| e.to_string())?;
        if case.tree().is_none() {
            return Ok(None);
        }
        match domain {
            None => *domain = Some(Domain::new(&case).map_err(|e| e.to_string())?),
            Some(domain) => domain.extrude_again(&case).map_err(|e| e.to_string())?,
        }
        let inside_out = domain.as_ref().and_then(|it| it.wall_inside_out(&case));
        Ok(inside_out.map(|x| (*preset, x)))
    };
    let all: Vec<_> = meshed.par_iter_mut().map(found).collect();
    let found = all.into_iter().collect::<Result<Vec<_>, _>>();
    let found = found.map_err(Failure::Input)?;
    Ok(found.into_iter().flatten().next())
}
