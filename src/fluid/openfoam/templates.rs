//! The templates of an OpenFOAM case: what there must be, and that OpenFOAM can read it.

use super::dictionary::{Dictionary, DictionaryError};
use super::names::{
    CONVECTION, FIELDS, INITIAL_VELOCITY, OPENINGS, TIME_DERIVATIVE, WALLS, included,
};
use std::fs;
use std::path::{Path, PathBuf};

/// Files that every case needs, with the class in their header.
const NEEDED: [(&str, &str); 9] = [
    ("system/controlDict", "dictionary"),
    ("system/fvSchemes", "dictionary"),
    ("system/fvSolution", "dictionary"),
    ("constant/dynamicMeshDict", "dictionary"),
    ("constant/transportProperties", "dictionary"),
    ("constant/turbulenceProperties", "dictionary"),
    ("0/U", "volVectorField"),
    ("0/p", "volScalarField"),
    ("0/pointDisplacement", "pointVectorField"),
];
/// The one that several ranks need.
const OF_RANKS: (&str, &str) = ("system/decomposeParDict", "dictionary");
/// Folders within folders, at most.
const MAX_DEPTH: usize = 16;

/// What is wrong with templates.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TemplateError {
    /// Files are missing.
    #[error("it lacks {}; the folder base of openfoam-case has one to start from", .0.join(", "))]
    Missing(Vec<String>),
    /// A file cannot be copied.
    #[error("{}: {}", .0.display(), .1)]
    File(PathBuf, String),
    /// A file is not a dictionary.
    #[error(transparent)]
    Dictionary(#[from] DictionaryError),
}

/// What OpenFOAM would refuse of the templates in `folder`, for a mesh with these `patches` on so many `ranks`; empty
/// if nothing is known against them.
pub fn check(folder: &Path, patches: &[&str], ranks: usize) -> Vec<TemplateError> {
    let mut errors = Vec::new();
    let mut needed = NEEDED.to_vec();
    if ranks > 1 {
        needed.push(OF_RANKS);
    }
    let compressed = |file: &str| folder.join(format!("{file}.gz")).is_file();
    needed.retain(|(file, _)| !compressed(file));
    let (there, missing): (Vec<_>, Vec<_>) = needed
        .into_iter()
        .partition(|(file, _)| folder.join(file).exists());
    if !missing.is_empty() {
        let names = missing.iter().map(|(file, _)| file.to_string());
        errors.push(TemplateError::Missing(names.collect()));
    }
    for (file, class) in there {
        match Dictionary::read(folder, Path::new(file)) {
            Ok(dictionary) => {
                let reasons = content(&dictionary, file, class, patches);
                let path = folder.join(file);
                errors.extend(reasons.map(|reason| TemplateError::File(path, reason)));
            }
            Err(error) => errors.push(error.into()),
        }
    }
    check_copy(folder, 0, &mut errors);
    errors
}

/// What a start from equilibrium misses in the templates in `folder`: parameters that `0/p` must read.
pub fn check_equilibrium_start(folder: &Path) -> Option<TemplateError> {
    let effect = "the blood begins under its pressure (initial.start = \"equilibrium\")";
    let parameters: &[&str] = match without_openings(folder).contains(&"p") {
        true => &["initialPressure", "pressureRampStart"],
        false => &["initialPressure"],
    };
    check_reads(folder, "0/p", parameters, effect)
}

/// What blood that flows from the beginning misses in the templates in `folder`.
pub fn check_initial_velocity(folder: &Path) -> Option<TemplateError> {
    let path = folder.join("0/U");
    let text = fs::read_to_string(&path).ok()?;
    let reason = format!(
        "it does not include \"$FOAM_CASE/{INITIAL_VELOCITY}\", by which the blood flows from the beginning (initial.steps_before); \
         openfoam-case/base/0/U shows how"
    );
    (!text.contains(INITIAL_VELOCITY)).then_some(TemplateError::File(path, reason))
}

/// The fields of the templates in `folder` that do not include what is prescribed at the openings, but prescribe
/// something themselves. Of one that is compressed or not there nothing is known.
pub fn without_openings(folder: &Path) -> Vec<&'static str> {
    let says_it_itself = |field: &&str| {
        let text = fs::read_to_string(folder.join("0").join(field));
        text.is_ok_and(|text| !text.contains(&included(field)))
    };
    FIELDS.into_iter().filter(says_it_itself).collect()
}

/// What `[[opening]]` of a case misses in the templates in `folder`.
pub fn check_openings(folder: &Path) -> Vec<TemplateError> {
    let missing = without_openings(folder).into_iter().map(|field| {
        let path = folder.join("0").join(field);
        let reason = format!(
            "it does not include \"$FOAM_CASE/{}\", by which it knows the case's tables [[opening]]; openfoam-case/base/0/{field} \
             shows how",
            included(field)
        );
        TemplateError::File(path, reason)
    });
    let effect = "the adapter knows the names of tables [[opening]]";
    let names = check_reads(folder, "system/controlDict", &[OPENINGS], effect);
    missing.chain(names).collect()
}

/// What a wall of several patches misses in the templates in `folder`.
pub fn check_walls(folder: &Path) -> Option<TemplateError> {
    let effect = "the adapter knows the patches of the wall of a tree";
    check_reads(folder, "system/controlDict", &[WALLS], effect)
}

/// What an end of the wall that moves, at this `opening` ("inlet" or "outlet"), misses in the templates in `folder`: a
/// parameter that `0/pointDisplacement` must read.
pub fn check_moving_end(folder: &Path, opening: &str) -> Option<TemplateError> {
    let effect = format!("the {opening} goes with the end of the wall (ends.{opening})");
    if !without_openings(folder).contains(&"pointDisplacement") {
        return None;
    }
    let parameter = format!("{opening}Motion");
    check_reads(folder, "0/pointDisplacement", &[&parameter], &effect)
}

/// What second order in time misses in the templates in `folder`: a parameter that `system/fvSchemes` must read.
pub fn check_second_order(folder: &Path) -> Option<TemplateError> {
    let effect = "time derivatives are of second order (time.scheme = \"bdf2\")";
    check_reads(folder, "system/fvSchemes", &[TIME_DERIVATIVE], effect)
}

/// What another scheme of convection than their own misses in the templates in `folder`: a parameter that
/// `system/fvSchemes` must read.
pub fn check_convection(folder: &Path) -> Option<TemplateError> {
    let effect = "velocities are interpolated (fluid.convection)";
    check_reads(folder, "system/fvSchemes", &[CONVECTION], effect)
}

/// Says which `parameters` a `file` of the templates does not read, and what they would do.
fn check_reads(
    folder: &Path,
    file: &str,
    parameters: &[&str],
    effect: &str,
) -> Option<TemplateError> {
    let path = folder.join(file);
    // One that cannot be read is reported elsewhere; a compressed one is not looked into.
    let text = fs::read_to_string(&path).ok()?;
    let missing = parameters.iter().filter(|name| !text.contains(**name));
    let missing: Vec<String> = missing.map(|name| format!("$:{name}")).collect();
    let reason = format!(
        "it does not read {}, by which {effect}; openfoam-case/base/{file} shows how",
        missing.join(" and ")
    );
    (!missing.is_empty()).then_some(TemplateError::File(path, reason))
}

/// What is wrong with a file that can be read.
fn content(file: &Dictionary, name: &str, class: &str, patches: &[&str]) -> Option<String> {
    let Some(header) = file.dictionary("FoamFile") else {
        return Some("it has no header: expected FoamFile { … } at the top".into());
    };
    match header.word("class") {
        Some(found) if found == class => {}
        found => {
            let found = found.unwrap_or("none");
            return Some(format!("its header says class {found}: expected {class}"));
        }
    }
    match name {
        "system/controlDict" => {
            let known = file.dictionary("functions");
            let adapter = known.is_some_and(|functions| {
                let mut all = functions.dictionaries();
                functions.may_have("") || all.any(|f| f.word("type") == Some("fsiAdapter"))
            });
            let unseen = known.is_none() && file.may_have("functions");
            (!adapter && !unseen).then(|| {
                "`functions` has none of the type fsiAdapter, which is the way to the driver".into()
            })
        }
        "constant/dynamicMeshDict" => match file.word("dynamicFvMesh") {
            Some("fsiMotionFvMesh") => None,
            Some(macro_) if macro_.starts_with(['$', '#']) => None,
            None if file.may_have("dynamicFvMesh") => None,
            _ => Some(
                "expected dynamicFvMesh fsiMotionFvMesh, which moves the mesh with the wall".into(),
            ),
        },
        field if field.starts_with("0/") => boundary(file, patches),
        _ => None,
    }
}

/// What is wrong with a field.
fn boundary(field: &Dictionary, patches: &[&str]) -> Option<String> {
    let entries = ["dimensions", "internalField", "boundaryField"];
    if let Some(missing) = entries.iter().find(|entry| !field.may_have(entry)) {
        return Some(format!("it has no entry {missing}"));
    }
    let conditions = field.dictionary("boundaryField")?;
    for patch in patches {
        let untyped = conditions.get(patch).is_some_and(|_| {
            !conditions
                .dictionary(patch)
                .is_some_and(|c| c.may_have("type"))
        });
        // No opening is called so.
        let is_wall = patch.starts_with("wall");
        if conditions.has_openings() && !is_wall && !untyped {
            continue;
        }
        if !conditions.may_have(patch) || untyped {
            return Some(format!(
                "boundaryField has no condition for the patch {patch}; the mesh has {}",
                patches.join(", ")
            ));
        }
    }
    None
}

/// All that lies in the folder is copied: it must be files and folders that can be read.
fn check_copy(folder: &Path, depth: usize, errors: &mut Vec<TemplateError>) {
    let mut wrong =
        |path: &Path, reason: String| errors.push(TemplateError::File(path.to_owned(), reason));
    if depth > MAX_DEPTH {
        return wrong(
            folder,
            format!("more than {MAX_DEPTH} folders within each other"),
        );
    }
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) => return wrong(folder, error.to_string()),
    };
    let mut folders = Vec::new();
    for path in entries.flatten().map(|entry| entry.path()) {
        match fs::metadata(&path) {
            Ok(kind) if kind.is_dir() => folders.push(path),
            Ok(kind) if kind.is_file() => {
                if let Err(error) = fs::File::open(&path) {
                    wrong(&path, error.to_string());
                }
            }
            Ok(_) => wrong(
                &path,
                "this is a device, a pipe or a socket, not a file".into(),
            ),
            Err(error) => wrong(&path, error.to_string()),
        }
    }
    for folder in folders.iter().filter(|folder| !holds_a_run(folder)) {
        check_copy(folder, depth + 1, errors);
    }
}

/// Copies the templates; what is a run, or holds the folder `to`, is left out.
///
/// # Errors
/// What could not be done, with the path.
pub fn copy(from: &Path, to: &Path) -> Result<(), (&'static str, PathBuf, std::io::Error)> {
    copy_but(from, to, &|_| false)
}

/// The same without what is `left_out` by its name at the top of the folder.
///
/// # Errors
/// What could not be done, with the path.
pub fn copy_but(
    from: &Path,
    to: &Path,
    left_out: &dyn Fn(&str) -> bool,
) -> Result<(), (&'static str, PathBuf, std::io::Error)> {
    fs::create_dir_all(to).map_err(|e| ("make", to.to_owned(), e))?;
    let target = to.canonicalize().map_err(|e| ("make", to.to_owned(), e))?;
    copy_folder(from, to, &target, left_out)
}

/// Makes a symbolic link to `target`, if there is nothing yet.
///
/// # Errors
/// What the system refuses.
pub fn link(target: &Path, link: &Path) -> Result<(), (&'static str, PathBuf, std::io::Error)> {
    match link.symlink_metadata() {
        Ok(_) => Ok(()),
        Err(_) => {
            std::os::unix::fs::symlink(target, link).map_err(|e| ("link", link.to_owned(), e))
        }
    }
}

/// Makes links in `to` to all that lies in `from` and is not left out, found as `seen/name`.
///
/// # Errors
/// What the system refuses.
pub fn link_others(
    from: &Path,
    to: &Path,
    seen: &Path,
    left_out: &dyn Fn(&str) -> bool,
) -> Result<(), (&'static str, PathBuf, std::io::Error)> {
    fs::create_dir_all(to).map_err(|e| ("make", to.to_owned(), e))?;
    let read = |e| ("read", from.to_owned(), e);
    for entry in fs::read_dir(from).map_err(read)? {
        let name = entry.map_err(read)?.file_name();
        if !left_out(&name.to_string_lossy()) && !holds_a_run(&from.join(&name)) {
            link(&seen.join(&name), &to.join(&name))?;
        }
    }
    Ok(())
}

fn copy_folder(
    from: &Path,
    to: &Path,
    target: &Path,
    left_out: &dyn Fn(&str) -> bool,
) -> Result<(), (&'static str, PathBuf, std::io::Error)> {
    fs::create_dir_all(to).map_err(|e| ("make", to.to_owned(), e))?;
    let read = |e| ("read", from.to_owned(), e);
    for entry in fs::read_dir(from).map_err(read)? {
        let entry = entry.map_err(read)?;
        let (source, copy) = (entry.path(), to.join(entry.file_name()));
        if left_out(&entry.file_name().to_string_lossy()) {
            continue;
        }
        if source.is_dir() {
            let inside = source
                .canonicalize()
                .is_ok_and(|source| target.starts_with(source));
            if !inside && !holds_a_run(&source) {
                copy_folder(&source, &copy, target, &|_| false)?;
            }
        } else {
            fs::copy(&source, &copy).map_err(|e| ("copy", source, e))?;
        }
    }
    Ok(())
}

/// The templates may be the folder of a case, next to its runs.
fn holds_a_run(folder: &Path) -> bool {
    folder.join("openfoam/system").is_dir()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATCHES: [&str; 4] = ["inlet", "outlet", "wallRigid", "wallFsi"];

    fn base() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/base")
    }

    #[test]
    fn the_templates_of_the_project_are_in_order() {
        let cases = base().with_file_name("");
        for (folder, patches) in [
            ("base", &PATCHES[..]),
            ("elastic-tube/fluid", &PATCHES),
            ("womersley/fluid", &PATCHES),
            ("poiseuille/fluid", &PATCHES),
            ("pulse-wave/fluid", &PATCHES),
            (
                "turek-hron/fluid",
                &[
                    "inlet",
                    "outlet",
                    "wallRigid",
                    "cylinder",
                    "wallFsi",
                    "sides",
                ],
            ),
        ] {
            assert_eq!(check(&cases.join(folder), patches, 2), [], "{folder}");
        }
    }

    /// Every change of the templates is found, and named with the file.
    #[test]
    fn what_openfoam_would_refuse_is_named() {
        type Change = fn(&Path);
        #[rustfmt::skip]
        let changes: [(Change, &str); 11] = [
            (|t| fs::remove_file(t.join("0/p")).unwrap(), "it lacks 0/p;"),
            (
                |t| fs::remove_dir_all(t.join("system")).unwrap(),
                "it lacks system/controlDict, system/fvSchemes, system/fvSolution, system/decomposeParDict;",
            ),
            (|t| fs::write(t.join("0/U"), "rubbish").unwrap(), "0/U:1: the entry `rubbish`"),
            (|t| fs::write(t.join("0/U"), [0xff; 4096]).unwrap(), "0/U:1: "),
            (|t| fs::write(t.join("0/U"), "").unwrap(), "0/U: it has no header"),
            (
                |t| {
                    fs::copy(t.join("0/p"), t.join("0/U")).unwrap();
                },
                "0/U: its header says class volScalarField: expected volVectorField",
            ),
            (
                |t| edit(&t.join("0/p"), "\"wallFsi.*\"", "wall"),
                "0/p: boundaryField has no condition for the patch wallFsi; the mesh has inlet, ",
            ),
            (|t| edit(&t.join("0/U"), "internalField", "inner"), "0/U: it has no entry internalField"),
            (
                |t| {
                    edit(
                        &t.join("constant/dynamicMeshDict"),
                        "fsiMotionFvMesh",
                        "staticFvMesh",
                    )
                },
                "constant/dynamicMeshDict: expected dynamicFvMesh fsiMotionFvMesh",
            ),
            (
                |t| edit(&t.join("system/controlDict"), "fsiAdapter;", "probes;"),
                "system/controlDict: `functions` has none of the type fsiAdapter",
            ),
            (
                |t| {
                    edit(
                        &t.join("system/controlDict"),
                        "system/fsiConnection",
                        "system/other",
                    )
                },
                "system/controlDict:14: it includes \"$FOAM_CASE/system/other\", which is not there",
            ),
        ];
        for (change, message) in changes {
            let folder = tempfile::tempdir().unwrap();
            let templates = folder.path().join("templates");
            copy(&base(), &templates).unwrap();
            assert_eq!(check(&templates, &PATCHES, 2), []);
            change(&templates);
            let errors = check(&templates, &PATCHES, 2);
            assert_eq!(errors.len(), 1, "{errors:?}");
            let text = errors[0].to_string();
            assert!(text.contains(message), "{text}");
        }
    }

    #[test]
    fn templates_that_would_ignore_what_the_case_asks_for_are_named() {
        type Check = fn(&Path) -> Option<TemplateError>;
        const INCLUDED: &str = "system/fsiOpenings/pointDisplacement";
        let moving = "0/pointDisplacement";
        #[rustfmt::skip]
        let checks: [(Check, &str, &str, &str); 5] = [
            (check_equilibrium_start, "0/p", "initialPressure", "initialPressure"),
            (|t| check_moving_end(t, "inlet"), moving, INCLUDED, "inletMotion"),
            (|t| check_moving_end(t, "outlet"), moving, INCLUDED, "outletMotion"),
            (check_second_order, "system/fvSchemes", TIME_DERIVATIVE, TIME_DERIVATIVE),
            (check_convection, "system/fvSchemes", CONVECTION, CONVECTION),
        ];
        for (check, file, there, parameter) in checks {
            let folder = tempfile::tempdir().unwrap();
            let templates = folder.path().join("templates");
            copy(&base(), &templates).unwrap();
            assert_eq!(check(&templates), None);
            edit(&templates.join(file), there, "another");
            let text = check(&templates).unwrap().to_string();
            assert!(
                text.contains(&format!("{file}: it does not read $:{parameter},")),
                "{text}"
            );
        }
    }

    #[test]
    fn templates_that_know_no_initial_velocity_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let templates = folder.path().join("templates");
        copy(&base(), &templates).unwrap();
        assert_eq!(check_initial_velocity(&templates), None);
        edit(&templates.join("0/U"), "fsiInitialVelocity", "another");
        let text = check_initial_velocity(&templates).unwrap().to_string();
        let said =
            "0/U: it does not include \"$FOAM_CASE/system/fsiInitialVelocity\", by which the blood";
        assert!(text.contains(said), "{text}");
    }

    fn edit(path: &Path, from: &str, to: &str) {
        let text = fs::read_to_string(path).unwrap();
        assert!(text.contains(from));
        fs::write(path, text.replace(from, to)).unwrap();
    }

    /// A user of OpenFOAM has the templates in the folder of the case, and the runs come to lie within.
    #[test]
    fn runs_within_the_templates_are_not_copied_into_themselves() {
        let folder = tempfile::tempdir().unwrap();
        let case = folder.path();
        copy(&base(), case).unwrap();
        fs::create_dir_all(case.join("run-demo/openfoam/system")).unwrap();
        let new = case.join("run-paper/openfoam");
        copy(case, &new).unwrap();
        assert!(new.join("0/U").is_file() && new.join("system/controlDict").is_file());
        assert!(!new.join("run-demo").exists() && !new.join("run-paper").exists());
    }
}
