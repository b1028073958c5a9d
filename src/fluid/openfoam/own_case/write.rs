//! The copy of a user-supplied case, with what coupling adds.

use super::super::connection::{Connection, ORIGINALS};
use super::super::dictionary::Dictionary;
use super::super::write_file::{CaseFilesError, write_file};
use super::super::{probes, templates};
use super::{CONSTRAINTS, OwnCaseFiles, make_blocks};
use crate::Vec3;
use crate::geometry::{Patch, PolyMesh};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Folders that no dictionary includes a file from, and that may be large.
const BULKY: [&str; 3] = ["polyMesh", "triSurface", "extendedFeatureEdgeMesh"];

impl OwnCaseFiles<'_> {
    /// Writes the copy into `folder`; what a run has left there at times after 0 stays.
    ///
    /// # Errors
    /// What the system refuses, or `blockMesh`.
    pub fn write(&self, folder: &Path, mesh: &PolyMesh) -> Result<(), CaseFilesError> {
        let refused = |(action, path, source)| CaseFilesError::Io {
            action,
            path,
            source,
        };
        templates::copy_but(self.folder(), folder, &is_result).map_err(refused)?;
        let fields = self.start_fields();
        if fields != "0" {
            templates::copy(&self.folder().join(fields), &folder.join("0")).map_err(refused)?;
        }
        self.keep_originals(folder).map_err(refused)?;
        if self.needs_blocks() && !folder.join("constant/polyMesh/faces").is_file() {
            make_blocks(folder).map_err(|fault| CaseFilesError::Io {
                action: "make the mesh of",
                path: folder.to_owned(),
                source: std::io::Error::other(fault),
            })?;
        }
        write_file(&folder.join("fluid.foam"), "")?;
        write_file(&folder.join("system/fsiProbes"), &probes::dictionary(&[]))?;
        self.extend(
            folder,
            "system/controlDict",
            "dictionary",
            &self.control(mesh),
        )?;
        self.extend(
            folder,
            "system/fvSolution",
            "dictionary",
            &self.solution(folder),
        )?;
        self.motion(folder)?;
        self.extend(folder, "0/U", "volVectorField", &self.velocity())?;
        self.displacement(folder, mesh)?;
        if self.ranks > 1 && !folder.join("system/decomposeParDict").is_file() {
            let text = header("system/decomposeParDict", "dictionary") + &self.parts(mesh);
            write_file(&folder.join("system/decomposeParDict"), &text)?;
        }
        Connection::none().write(folder)
    }

    /// Copies what the user has written to where extended files include it from. Around it everything else of the case
    /// is found, since includes in it may name other files from where they stand.
    fn keep_originals(&self, folder: &Path) -> Result<(), (&'static str, PathBuf, std::io::Error)> {
        let originals = folder.join(ORIGINALS);
        let fields = self.start_fields();
        for (from, to) in [
            ("system", "system"),
            ("constant", "constant"),
            (fields, "0"),
        ] {
            let from = self.folder().join(from);
            if from.is_dir() {
                let to = originals.join(to);
                templates::copy_but(&from, &to, &|name| BULKY.contains(&name))?;
            }
        }
        for name in BULKY {
            let constant = Path::new("constant").join(name);
            if folder.join(&constant).exists() && originals.join("constant").is_dir() {
                let target = Path::new("../..").join(&constant);
                templates::link(&target, &originals.join(&constant))?;
            }
        }
        templates::link_others(self.folder(), &originals, Path::new(".."), &|name| {
            is_result(name) || ["system", "constant", "0"].contains(&name)
        })
    }

    /// Writes a file that includes the user's and goes on with `more`.
    fn extend(
        &self,
        folder: &Path,
        file: &str,
        class: &str,
        more: &str,
    ) -> Result<(), CaseFilesError> {
        let text = header(file, class)
            + &format!(
                "#include \"$FOAM_CASE/{ORIGINALS}/{file}\"\n\n// What coupling adds; written by fsi-driver\n{more}"
            );
        write_file(&folder.join(file), &text)
    }

    fn control(&self, mesh: &PolyMesh) -> String {
        format!(
            "#include \"$FOAM_CASE/system/fsiConnection\"\n\n\
             application         pimpleFoam;\n\
             startFrom           startTime;\n\
             startTime           $fsiStartTime;\n\
             stopAt              endTime;\n\
             endTime             1e9;\n\
             deltaT              {:e};\n\
             adjustTimeStep      no;\n\
             writeControl        timeStep;\n\
             writeInterval       1000000000;\n\
             purgeWrite          0;\n\
             writeFormat         binary;\n\
             writePrecision      17;\n\
             writeCompression    off;\n\
             timeFormat          general;\n\
             timePrecision       12;\n\
             runTimeModifiable   no;\n\n\
             profiling\n{{\n    active          true;\n    cpuInfo         false;\n    memInfo         false;\n    sysInfo         false;\n}}\n\n\
             functions\n{{\n    fsiAdapter\n    {{\n        type            fsiAdapter;\n        walls           ({});\n        \
             openings        ({});\n        density         {:e};\n        transport       $:fsiTransport;\n        \
             address         $:fsiAddress;\n        driver          $:fsiDriver;\n    }}\n}}\n",
            self.time_step,
            self.keys.patches.join(" "),
            self.openings(mesh).join(" "),
            self.density,
        )
    }

    fn solution(&self, folder: &Path) -> String {
        let file = Path::new(ORIGINALS).join("system/fvSolution");
        let read = Dictionary::read(folder, &file).unwrap_or_default();
        let solvers = read.dictionary("solvers");
        let mut own = (solvers.iter()).flat_map(|solvers| solvers.keywords());
        let has_own = own.any(|name| name.starts_with("cellDisplacement"));
        let has = |name: &str| solvers.is_some_and(|solvers| solvers.get(name).is_some());
        let mut text = String::new();
        // A trial of a single corrector is a final one at once.
        if has("cellDisplacement") && !has("cellDisplacementFinal") {
            text += "solvers\n{\n    cellDisplacementFinal\n    {\n        $:solvers.cellDisplacement;\n    }\n}\n\n";
        }
        if !has_own {
            text += "solvers\n{\n    \"cellDisplacement.*\"\n    {\n        solver          PCG;\n        preconditioner  DIC;\n        \
                     tolerance       1e-10;\n        relTol          0.01;\n    }\n}\n\n";
        }
        text += "PIMPLE\n{\n    // The first corrector of each trial moves the mesh; what it makes of fluxes is corrected by p\n    \
                 correctPhi      no;\n    checkMeshCourantNo no;\n}\n";
        text
    }

    /// The user's way to move the mesh, if there is one.
    fn motion(&self, folder: &Path) -> Result<(), CaseFilesError> {
        let file = "constant/dynamicMeshDict";
        let own = Dictionary::read(self.folder(), Path::new(file)).unwrap_or_default();
        let moves = own
            .word("dynamicFvMesh")
            .is_some_and(|mesh| mesh != "staticFvMesh");
        if moves {
            return self.extend(
                folder,
                file,
                "dictionary",
                "dynamicFvMesh       fsiMotionFvMesh;\n",
            );
        }
        let text = header(file, "dictionary")
            + "dynamicFvMesh       fsiMotionFvMesh;\n\nmotionSolver        referenceLaplacian;\n";
        write_file(&folder.join(file), &text)
    }

    fn velocity(&self) -> String {
        let mut text = String::from("boundaryField\n{\n");
        for patch in &self.keys.patches {
            let _ = writeln!(
                text,
                "    {patch}\n    {{\n        type            fsiWallVelocity;\n        value           uniform (0 0 0);\n    }}"
            );
        }
        text + "}\n"
    }

    /// The displacement of points, of patches of which the user's does not say it: they rest, or go with the rim of the
    /// wall.
    fn displacement(&self, folder: &Path, mesh: &PolyMesh) -> Result<(), CaseFilesError> {
        let file = "0/pointDisplacement";
        let is_there = folder.join(file).is_file();
        let own = match Dictionary::read(folder, Path::new(file)) {
            Ok(own) => own,
            // Binary, for example: OpenFOAM will read it.
            Err(_) if is_there => return Ok(()),
            Err(_) => Dictionary::default(),
        };
        let known = own.dictionary("boundaryField");
        let is_missing = |patch: &&Patch| match known {
            Some(known) => !known.may_have(&patch.name),
            None => !own.may_have("boundaryField"),
        };
        let mut text = String::from("boundaryField\n{\n");
        for patch in mesh.patches.iter().filter(is_missing) {
            let condition = match self.moving.get(&patch.name) {
                _ if CONSTRAINTS.contains(&patch.kind.as_str()) => format!("type {};", patch.kind),
                Some(motion) => format!("type {};", motion.condition()),
                None => "type fixedValue; value uniform (0 0 0);".into(),
            };
            let _ = writeln!(text, "    {} {{ {condition} }}", patch.name);
        }
        text += "}\n";
        if !is_there {
            let fields = "dimensions      [0 1 0 0 0 0 0];\n\ninternalField   uniform (0 0 0);\n\n";
            let text = header(file, "pointVectorField") + fields + &text;
            return write_file(&folder.join(file), &text);
        }
        match mesh.patches.iter().any(|patch| is_missing(&patch)) {
            true => self.extend(folder, file, "pointVectorField", &text),
            false => Ok(()),
        }
    }

    /// Equal parts along the longest direction.
    fn parts(&self, mesh: &PolyMesh) -> String {
        let fold = |pick: fn(f64, f64) -> f64, start: f64| {
            let corner = |corner: Vec3, x: &Vec3| Vec3::from_fn(|i, _| pick(corner[i], x[i]));
            mesh.points.iter().fold(Vec3::repeat(start), corner)
        };
        let size = fold(f64::max, f64::NEG_INFINITY) - fold(f64::min, f64::INFINITY);
        let mut numbers = [1; 3];
        numbers[size.imax()] = self.ranks;
        let [a, b, c] = numbers;
        format!(
            "numberOfSubdomains  {};\n\nmethod              simple;\n\nsimpleCoeffs\n{{\n    n               ({a} {b} {c});\n    \
             delta           0.001;\n}}\n",
            self.ranks
        )
    }
}

/// What lies in a case that was run: nothing that a new run needs.
pub(super) fn is_result(name: &str) -> bool {
    let is_time = name.starts_with(|c: char| c.is_ascii_digit())
        && name.parse::<f64>().is_ok_and(|time| time != 0.0);
    is_time || name.starts_with("processor") || name == "postProcessing" || name == ORIGINALS
}

fn header(file: &str, class: &str) -> String {
    let (folder, object) = file.rsplit_once('/').unwrap_or(("", file));
    format!(
        "FoamFile\n{{\n    version     2.0;\n    format      ascii;\n    class       {class};\n    location    \"{folder}\";\n    \
         object      {object};\n}}\n\n"
    )
}
