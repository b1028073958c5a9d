//! `system/fsiConnection`: the way to the driver, new at every start.

use super::dictionary::Dictionary;
use super::write_file::{CaseFilesError, write_file};
use std::path::Path;

/// Where the copy keeps what the user has written of files that were extended.
pub(super) const ORIGINALS: &str = "user";

/// The way from OpenFOAM to the driver.
#[derive(Debug, Clone, Copy)]
pub struct Connection<'a> {
    /// The adapter's library.
    pub library: Option<&'a Path>,
    /// `socket` or `files`.
    pub transport: &'a str,
    /// The socket, or the folder.
    pub address: &'a Path,
    /// Time from which to start, s; its folder must exist.
    pub start_time: f64,
}

impl Connection<'_> {
    /// No way: until the solver is started, enough for checkMesh and other utilities to read the case.
    pub fn none() -> Self {
        Self {
            library: None,
            transport: "none",
            address: Path::new("none"),
            start_time: 0.0,
        }
    }

    /// Writes `system/fsiConnection`.
    pub fn write(&self, folder: &Path) -> Result<(), CaseFilesError> {
        let library = self.library.map(|path| path.display().to_string());
        let libraries = libraries(folder).into_iter().chain(library);
        let libraries: Vec<String> = libraries.map(|path| format!("\"{path}\"")).collect();
        let text = format!(
            "// The way to the driver; written by fsi-driver at each start\n\
             libs            ({});\n\
             fsiTransport    {};\n\
             fsiAddress      \"{}\";\n\
             fsiDriver       {};\n\
             fsiStartTime    {};\n\
             // Pressure and velocity at output.fluid_probes_m; before the adapter, which reports the finished step\n\
             functions {{ #include \"$FOAM_CASE/system/fsiProbes\" }}\n",
            libraries.join(" "),
            self.transport,
            self.address.display(),
            std::process::id(),
            self.start_time,
        );
        write_file(&folder.join("system/fsiConnection"), &text)
    }
}

/// Libraries that the user's own `controlDict` loads, of a case that was written here.
fn libraries(case: &Path) -> Vec<String> {
    let file = Path::new(ORIGINALS).join("system/controlDict");
    let dictionary = Dictionary::read(case, &file).unwrap_or_default();
    dictionary.words("libs").to_vec()
}
