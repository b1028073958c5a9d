//! Whether a user-supplied case can be coupled, and which lines would have to change.

use super::super::dictionary::{Dictionary, Entry};
use super::OwnCaseFiles;
use crate::files::FileError;
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

/// What keeps a case from being coupled, as it is found.
struct Mistakes<'a> {
    folder: &'a Path,
    found: Vec<FileError>,
}

impl Mistakes<'_> {
    fn add(&mut self, file: &str, reason: impl Into<String>) {
        let path = self.folder.join(file);
        self.found.push(FileError::new(&path, reason.into()));
    }

    /// A file that is there, in ascii, and can be understood.
    fn read(&self, file: &str) -> Option<Dictionary> {
        let path = self.folder.join(file);
        (path.is_file() && !is_binary(&path))
            .then(|| Dictionary::read(self.folder, Path::new(file)).ok())?
    }

    /// Complains of patches of a field whose condition, where it is plain to see, is none of the `allowed` ones.
    fn conditions(
        &mut self,
        file: &str,
        patches: &[String],
        allowed: &[&str],
        advice: impl Fn(&str) -> String,
    ) {
        let Some(field) = self.read(file) else { return };
        for patch in patches {
            if let Some(found) = condition(&field, patch).filter(|found| !allowed.contains(found)) {
                let reason = format!(
                    "the patch {patch} is of the type {found}, {}",
                    advice(patch)
                );
                self.add(file, reason);
            }
        }
    }
}

impl OwnCaseFiles<'_> {
    /// What keeps the case from being coupled, with the lines that would be right; empty if nothing is known.
    pub fn check(&self, mesh: &PolyMesh) -> Vec<FileError> {
        let mut wrong = Mistakes {
            folder: self.folder(),
            found: Vec::new(),
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
                wrong.add("constant/polyMesh/boundary", reason);
            }
        }
        let fields = self.start_fields();
        let [velocity, pressure, displacement] =
            ["U", "p", "pointDisplacement"].map(|field| format!("{fields}/{field}"));
        let needed: Vec<&str> = NEEDED.into_iter().chain([&*velocity, &*pressure]).collect();
        for file in &needed {
            if !wrong.folder.join(file).is_file() {
                wrong.add(file, "the case has no such file");
            }
        }
        let others = [
            "system/blockMeshDict",
            "constant/dynamicMeshDict",
            &displacement,
        ];
        for file in needed.into_iter().chain(others) {
            if let Err(error) = Dictionary::read(wrong.folder, Path::new(file))
                && error.leaves_the_case()
            {
                wrong.add(file, format!("line {}: {}", error.line, error.message));
            }
        }
        self.check_fields([&velocity, &pressure, &displacement], &mut wrong);
        check_solution(&mut wrong);
        if self.ranks > 1
            && let Some(parts) = wrong.read("system/decomposeParDict")
            && let Some(number) = parts
                .word("numberOfSubdomains")
                .and_then(|n| n.parse::<usize>().ok())
            && number != self.ranks
        {
            let reason = format!(
                "it cuts the case into {number} parts, and fluid.ranks (--ranks) says {}: write the same number in both places",
                self.ranks
            );
            wrong.add("system/decomposeParDict", reason);
        }
        wrong.found
    }

    /// Conditions of the start fields on the patches that an elastic wall moves.
    fn check_fields(
        &self,
        [velocity, pressure, displacement]: [&str; 3],
        wrong: &mut Mistakes<'_>,
    ) {
        let patches = &self.keys.patches;
        wrong.conditions(velocity, patches, &AT_REST, |patch| {
            format!("and an elastic wall takes the fluid along: write {patch} {{ type noSlip; }}")
        });
        let path = wrong.folder.join(velocity);
        if path.is_file() && is_binary(&path) {
            wrong.add(
                velocity,
                "it is binary, and the condition of the wall is to be set: write it in ascii (foamFormatConvert with \
                 writeFormat ascii; in system/controlDict)",
            );
        }
        wrong.conditions(pressure, patches, &AT_WALL, |patch| {
            format!("which fixes the load on the wall: write {patch} {{ type zeroGradient; }}")
        });
        wrong.conditions(displacement, patches, &["fixedValue"], |patch| {
            format!(
                "and the driver says how it moves: write {patch} {{ type fixedValue; value uniform (0 0 0); }}"
            )
        });
        let Some(field) = wrong.read(displacement) else {
            return;
        };
        for (patch, motion) in &self.moving {
            if condition(&field, patch) == Some("fixedValue") {
                let reason = format!(
                    "the wall moves where it ends at the patch {patch}, and this holds it: write {patch} {{ type {}; }}, or \
                     leave the patch out for the driver to say it",
                    motion.condition()
                );
                wrong.add(displacement, reason);
            }
        }
    }
}

/// How the mesh moves, the derivatives in time, and the correctors.
fn check_solution(wrong: &mut Mistakes<'_>) {
    if let Some(motion) = wrong.read("constant/dynamicMeshDict")
        && let Some(reason) = motion_reason(&motion)
    {
        wrong.add("constant/dynamicMeshDict", reason);
    }
    if let Some(schemes) = wrong.read("system/fvSchemes")
        && let Some(scheme) = (schemes.dictionary("ddtSchemes")).and_then(|d| d.word("default"))
        && ["steadyState", "none", "localEuler"].contains(&scheme)
    {
        let reason = format!(
            "time derivatives are of the scheme {scheme}: write ddtSchemes {{ default Euler; }}"
        );
        wrong.add("system/fvSchemes", reason);
    }
    let Some(solution) = wrong.read("system/fvSolution") else {
        return;
    };
    match solution.dictionary("PIMPLE") {
        None if solution.may_have("PIMPLE") => {}
        None => wrong.add(
            "system/fvSolution",
            "there is no PIMPLE, whose correctors are the coupling's iterations: write PIMPLE { nCorrectors 2; }",
        ),
        Some(pimple) if pimple.get("residualControl").is_some() => wrong.add(
            "system/fvSolution",
            "residualControl in PIMPLE would end the outer correctors behind the driver's back: remove it (how many \
             there are say fluid.max_correctors and fluid.pressure_residual)",
        ),
        Some(_) => {}
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
