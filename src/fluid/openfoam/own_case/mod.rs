//! A user-supplied OpenFOAM case: a copy of it, and in the copy what coupling needs.
//!
//! Nothing of the user's is edited. A file that needs more than it says is copied to `user/`, and one that includes it
//! and adds the rest takes its place: OpenFOAM merges entries of the same name, the last one counts.

mod check;
mod write;

pub use super::case_files::PatchMotion;
use super::dictionary::{Dictionary, Entry};
use super::{Programs, templates};
use crate::case::OwnFluid;
use crate::files::{Fault, FileError, fault};
use crate::geometry::{Patch, PolyMesh};
use crate::processes::Process;
use rustix::process::Signal;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Duration;

/// Types of patches that every field must have as well.
const CONSTRAINTS: [&str; 9] = [
    "cyclic",
    "cyclicAMI",
    "cyclicACMI",
    "empty",
    "nonuniformTransformCyclic",
    "processor",
    "symmetry",
    "symmetryPlane",
    "wedge",
];

/// Conditions under which the pressure at a patch neither is given nor answers to the flow.
const NO_PRESSURE: [&str; 5] = [
    "calculated",
    "fixedFluxPressure",
    "fixedGradient",
    "uniformFixedGradient",
    "zeroGradient",
];

/// A user-supplied case with what the driver must tell OpenFOAM in addition.
#[derive(Debug, Clone)]
pub struct OwnCaseFiles<'a> {
    /// Folder of the case.
    pub folder: &'a Path,
    /// Its wet patches and openings.
    pub keys: &'a OwnFluid,
    /// Density, kg/m³: OpenFOAM's pressure is divided by it.
    pub density: f64,
    /// Time step, s.
    pub time_step: f64,
    /// MPI ranks.
    pub ranks: usize,
    /// Patches that move with the rims of the wall.
    pub moving: BTreeMap<String, PatchMotion>,
}

impl OwnCaseFiles<'_> {
    fn folder(&self) -> &Path {
        self.folder
    }

    /// The folder with the fields at the start: `0`, or `0.orig`.
    fn start_fields(&self) -> &'static str {
        match self.folder().join("0").is_dir() {
            true => "0",
            false => "0.orig",
        }
    }

    /// Whether the mesh is still to be made by `blockMesh`.
    fn needs_blocks(&self) -> bool {
        let constant = self.folder().join("constant/polyMesh");
        let has_mesh = ["faces", "faces.gz"]
            .iter()
            .any(|name| constant.join(name).exists());
        !has_mesh && self.folder().join("system/blockMeshDict").is_file()
    }

    /// The mesh of the case. Where there is none but a `blockMeshDict`, `blockMesh` makes it in a folder that is gone
    /// afterwards.
    ///
    /// # Errors
    /// If there is neither, it cannot be read or made, or the blocks are those that `snappyHexMesh` cuts.
    pub fn mesh(&self) -> Result<PolyMesh, FileError> {
        if !self.needs_blocks() {
            let folder = self.folder().join("constant/polyMesh");
            if !folder.is_dir() {
                let reason = "there is no mesh, and no system/blockMeshDict to make it from";
                return Err(FileError::new(&folder, reason));
            }
            return PolyMesh::read(self.folder());
        }
        let cuts = self.folder().join("system/snappyHexMeshDict");
        if cuts.is_file() {
            let script = self.folder().join("../make_mesh.sh");
            let remedy = match script.is_file() {
                true => "run make_mesh.sh beside the case",
                false => "run blockMesh and snappyHexMesh -overwrite in the case",
            };
            let reason = format!(
                "there is no mesh yet in constant/polyMesh, and the driver runs blockMesh alone: {remedy}"
            );
            return Err(FileError::new(&cuts, reason));
        }
        let dictionary = self.folder().join("system/blockMeshDict");
        let wrong = |reason: String| FileError::new(&dictionary, reason);
        let folder = tempfile::Builder::new().prefix("fsi-mesh-").tempdir();
        let folder = folder.map_err(|e| wrong(format!("no folder to make the mesh in: {e}")))?;
        let root = folder.path().join("case");
        for part in ["system", "constant"] {
            let from = self.folder().join(part);
            if from.is_dir() {
                templates::copy(&from, &root.join(part)).map_err(|(action, path, e)| {
                    wrong(format!("cannot {action} {}: {e}", path.display()))
                })?;
            }
        }
        // Its dictionary may include others from anywhere in the case.
        let case = self.folder().canonicalize();
        let case = case.map_err(|e| FileError::new(self.folder(), e))?;
        templates::link_others(&case, &root, &case, &|name| {
            write::is_result(name) || ["system", "constant", "0", "0.orig"].contains(&name)
        })
        .map_err(|(action, path, e)| wrong(format!("cannot {action} {}: {e}", path.display())))?;
        make_blocks(&root).map_err(|fault| {
            let root = root.canonicalize().unwrap_or(root.clone());
            wrong(
                fault
                    .to_string()
                    .replace(&*root.to_string_lossy(), &self.folder().to_string_lossy()),
            )
        })?;
        PolyMesh::read(&root)
    }

    /// Patches at which the pressure is given or answers to the flow, each with the resistances (proximal and distal,
    /// Pa s/m³) and the compliance (m³/Pa) of its windkessel, if it has the adapter's.
    pub fn pressures(&self, mesh: &PolyMesh) -> Vec<(String, Option<[f64; 3]>)> {
        let file = Path::new(self.start_fields()).join("p");
        let Ok(field) = Dictionary::read(self.folder, &file) else {
            return Vec::new();
        };
        let given = |patch: &Patch| {
            let conditions = field.dictionary("boundaryField")?;
            let Entry::Dictionary(condition) = conditions.matching(&patch.name)? else {
                return None;
            };
            let number = |key| condition.word(key)?.parse().ok();
            let windkessel = || {
                Some([
                    number("proximalResistance").unwrap_or(0.0),
                    number("resistance")?,
                    number("compliance")?,
                ])
            };
            match condition.word("type")? {
                "windkesselPressure" => Some((patch.name.clone(), windkessel())),
                hidden if hidden.starts_with(['$', '#']) => None,
                no_pressure if NO_PRESSURE.contains(&no_pressure) => None,
                _ => Some((patch.name.clone(), None)),
            }
        };
        let open = mesh.patches.iter().filter(|patch| patch.kind == "patch");
        open.filter_map(given).collect()
    }

    /// Whether its time derivatives are backward differences of second order, those of the moving mesh included.
    pub fn is_second_order(&self) -> bool {
        let schemes = Dictionary::read(self.folder, Path::new("system/fvSchemes"));
        let schemes = schemes
            .ok()
            .and_then(|all| all.dictionary("ddtSchemes").cloned());
        schemes.is_some_and(|schemes| schemes.word("default") == Some("backward"))
    }

    /// Where it flows in or out: the patches that the user names, or all of the type `patch`, one that is called
    /// `inlet…` first.
    pub fn openings(&self, mesh: &PolyMesh) -> Vec<String> {
        if !self.keys.openings.is_empty() {
            return self.keys.openings.clone();
        }
        let open = mesh.patches.iter().filter(|patch| {
            patch.kind == "patch" && patch.size > 0 && !self.keys.patches.contains(&patch.name)
        });
        let mut names: Vec<String> = open.map(|patch| patch.name.clone()).collect();
        names.sort_by_key(|name| !name.to_lowercase().starts_with("inlet"));
        names
    }
}

/// Runs `blockMesh` in a case.
fn make_blocks(case: &Path) -> Result<(), Fault> {
    let log = case.join("log.blockMesh");
    let command = Programs::new(case, &[]).command("blockMesh");
    let mut process = Process::start(command, &log, Signal::KILL).map_err(Fault::whole)?;
    while !process.wait(Duration::from_millis(20)) {}
    if process.succeeded() {
        return Ok(());
    }
    let said = fs::read_to_string(&log).unwrap_or_default();
    let said = match said.split_once("FATAL") {
        Some((_, reason)) => reason
            .split_whitespace()
            .take(60)
            .collect::<Vec<_>>()
            .join(" "),
        None => process.exit_report(),
    };
    Err(fault!("blockMesh refuses it: {said}"))
}
