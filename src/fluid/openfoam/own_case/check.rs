//! Whether a user-supplied case can be coupled, and which lines would have to change.

use super::super::dictionary::{Dictionary, Entry};
use super::{OwnCaseError, OwnCaseFiles};
use crate::geometry::PolyMesh;
use std::fs;
use std::path::Path;

/// Files that the case must have, in addition to the start fields.
const NEEDED: [&str; 5] = [
    "system/controlDict",
    "system/fvSchemes",
    "system/fvSolution",
    "constant/transportProperties",
    "constant/turbulenceProperties",
];
/// Velocities of a wall at rest, which the wall's own takes the place of.
const AT_REST: [&str; 4] = [
    "noSlip",
    "fixedValue",
    "movingWallVelocity",
    "fsiWallVelocity",
];
/// Pressures at a wall.
const AT_WALL: [&str; 2] = ["zeroGradient", "fixedFluxPressure"];
/// Most bytes of a file that are looked at to find its header.
const HEADER: usize = 2000;

impl OwnCaseFiles<'_> {
    /// What keeps the case from being coupled, with the lines that would be right; empty if nothing is known.
    pub fn check(&self, mesh: &PolyMesh) -> Vec<OwnCaseError> {
        let folder = self.folder();
        let fields = self.start_fields();
        let mut errors = Vec::new();
        let mut wrong = |file: &str, reason: String| {
            errors.push(OwnCaseError::new(&folder.join(file), reason));
        };
        let known: Vec<&str> = mesh
            .patches
            .iter()
            .map(|patch| patch.name.as_str())
            .collect();
        for name in &self.keys.openings {
            if !known.contains(&name.as_str()) {
                let reason = format!(
                    "the mesh has no patch {name:?}, one of fluid.openings; it has \"{}\"",
                    known.join("\", \"")
                );
                wrong("constant/polyMesh/boundary", reason);
            }
        }
        let start = [format!("{fields}/U"), format!("{fields}/p")];
        let needed = NEEDED
            .iter()
            .copied()
            .chain(start.iter().map(String::as_str));
        for file in needed {
            if !folder.join(file).is_file() {
                wrong(file, "the case has no such file".into());
            }
        }
        let displacement = format!("{fields}/pointDisplacement");
        let others = [
            "system/blockMeshDict",
            "constant/dynamicMeshDict",
            &displacement,
        ];
        let included = NEEDED
            .iter()
            .copied()
            .chain(start.iter().map(String::as_str));
        for file in included.chain(others) {
            if let Err(error) = Dictionary::read(folder, Path::new(file))
                && error.leaves_the_case()
            {
                wrong(file, format!("line {}: {}", error.line, error.message));
            }
        }
        let read = |file: &str| -> Option<Dictionary> {
            let path = folder.join(file);
            (path.is_file() && !is_binary(&path))
                .then(|| Dictionary::read(folder, Path::new(file)).ok())?
        };

        if let Some(velocity) = read(&start[0]) {
            for patch in &self.keys.patches {
                if let Some(found) = condition(&velocity, patch)
                    && !AT_REST.contains(&found)
                {
                    let reason = format!(
                        "the patch {patch} is of the type {found}, and an elastic wall takes the fluid along: write {patch} \
                         {{ type noSlip; }}"
                    );
                    wrong(&start[0], reason);
                }
            }
        } else if folder.join(&start[0]).is_file() && is_binary(&folder.join(&start[0])) {
            wrong(
                &start[0],
                "it is binary, and the condition of the wall is to be set: write it in ascii (foamFormatConvert with \
                 writeFormat ascii; in system/controlDict)"
                    .into(),
            );
        }
        if let Some(pressure) = read(&start[1]) {
            for patch in &self.keys.patches {
                if let Some(found) = condition(&pressure, patch)
                    && !AT_WALL.contains(&found)
                {
                    let reason = format!(
                        "the patch {patch} is of the type {found}, which fixes the load on the wall: write {patch} {{ type \
                         zeroGradient; }}"
                    );
                    wrong(&start[1], reason);
                }
            }
        }
        if let Some(field) = read(&displacement) {
            for patch in &self.keys.patches {
                if let Some(found) = condition(&field, patch)
                    && found != "fixedValue"
                {
                    let reason = format!(
                        "the patch {patch} is of the type {found}, and the driver says how it moves: write {patch} {{ type \
                         fixedValue; value uniform (0 0 0); }}"
                    );
                    wrong(&displacement, reason);
                }
            }
        }
        if let Some(field) = read(&displacement) {
            for (patch, motion) in &self.moving {
                if condition(&field, patch) == Some("fixedValue") {
                    let reason = format!(
                        "the wall moves where it ends at the patch {patch}, and this holds it: write {patch} {{ type {}; }}, or \
                         leave the patch out for the driver to say it",
                        motion.condition()
                    );
                    wrong(&displacement, reason);
                }
            }
        }
        if let Some(motion) = read("constant/dynamicMeshDict")
            && let Some(reason) = motion_reason(&motion)
        {
            wrong("constant/dynamicMeshDict", reason);
        }
        if let Some(schemes) = read("system/fvSchemes")
            && let Some(scheme) = (schemes.dictionary("ddtSchemes")).and_then(|d| d.word("default"))
            && ["steadyState", "none", "localEuler"].contains(&scheme)
        {
            let reason = format!(
                "time derivatives are of the scheme {scheme}: write ddtSchemes {{ default Euler; }}"
            );
            wrong("system/fvSchemes", reason);
        }
        if let Some(solution) = read("system/fvSolution") {
            match solution.dictionary("PIMPLE") {
                None if solution.may_have("PIMPLE") => {}
                None => wrong(
                    "system/fvSolution",
                    "there is no PIMPLE, whose correctors are the coupling's iterations: write PIMPLE { nCorrectors 2; }".into(),
                ),
                Some(pimple) if pimple.get("residualControl").is_some() => wrong(
                    "system/fvSolution",
                    "residualControl in PIMPLE would end the outer correctors behind the driver's back: remove it (how many \
                     there are say fluid.max_correctors and fluid.pressure_residual)"
                        .into(),
                ),
                Some(_) => {}
            }
        }
        if self.ranks > 1
            && let Some(parts) = read("system/decomposeParDict")
            && let Some(number) = parts
                .word("numberOfSubdomains")
                .and_then(|n| n.parse::<usize>().ok())
            && number != self.ranks
        {
            let reason = format!(
                "it cuts the case into {number} parts, and fluid.ranks (--ranks) says {}: write the same number in both places",
                self.ranks
            );
            wrong("system/decomposeParDict", reason);
        }
        errors
    }
}

/// Why the mesh cannot move as this dictionary says.
fn motion_reason(motion: &Dictionary) -> Option<String> {
    let lines = "write dynamicFvMesh dynamicMotionSolverFvMesh; motionSolverLibs (fvMotionSolvers); motionSolver displacementLaplacian; with \
                 its coefficients, or remove the file for the driver's own";
    match motion.word("dynamicFvMesh")? {
        "staticFvMesh" => None,
        "dynamicMotionSolverFvMesh" | "fsiMotionFvMesh" => {
            let solver = motion.word("motionSolver").or(motion.word("solver"))?;
            let known = solver.starts_with("displacement") || solver == "referenceLaplacian";
            (!known).then(|| {
                format!("the motion solver is {solver}, and the wall's displacement is what is known: {lines}")
            })
        }
        other if other.starts_with(['$', '#']) => None,
        other => Some(format!("the mesh is of the type {other}: {lines}")),
    }
}

/// The type of the condition on a patch, where it is plain to see.
fn condition<'a>(field: &'a Dictionary, patch: &str) -> Option<&'a str> {
    let Some(Entry::Dictionary(condition)) = field.dictionary("boundaryField")?.get(patch) else {
        return None;
    };
    let found = condition.word("type")?;
    (!found.starts_with(['$', '#'])).then_some(found)
}

/// Whether the header of a file says that it is binary.
pub(super) fn is_binary(path: &Path) -> bool {
    let bytes = fs::read(path).unwrap_or_default();
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEADER)]).into_owned();
    let header = head
        .split_once("FoamFile")
        .and_then(|(_, rest)| rest.split_once('}'));
    header.is_some_and(|(header, _)| {
        let mut words = header.split(|c: char| c.is_whitespace() || c == ';');
        words.any(|word| word == "binary")
    })
}
