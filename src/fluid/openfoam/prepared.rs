//! An OpenFOAM case that can be written: of the driver's own making, or the user's.

use super::case_files::{CaseFiles, CaseFilesError};
use super::own_case::OwnCaseFiles;
use crate::geometry::PolyMesh;
use std::path::Path;

/// Dictionaries with a mesh.
#[derive(Debug, Clone)]
pub struct Prepared<'a> {
    /// Where the dictionaries come from.
    pub files: MeshSource<'a>,
    /// The mesh.
    pub mesh: &'a PolyMesh,
}

/// Where the dictionaries of a case come from.
#[derive(Debug, Clone)]
pub enum MeshSource<'a> {
    /// Templates, with the numbers of the case next to them.
    Templates(CaseFiles<'a>),
    /// A user-supplied case, with its own mesh.
    Own(OwnCaseFiles<'a>),
}

impl Prepared<'_> {
    /// Writes all of it into `folder`.
    ///
    /// # Errors
    /// What could not be written.
    pub fn write(&self, folder: &Path) -> Result<(), CaseFilesError> {
        match &self.files {
            MeshSource::Templates(files) => {
                let failed = |source| CaseFilesError::Io {
                    action: "write",
                    path: folder.to_owned(),
                    source,
                };
                self.mesh.write(folder).map_err(failed)?;
                files.write(folder)
            }
            MeshSource::Own(files) => files.write(folder, self.mesh),
        }
    }

    /// The folder that the dictionaries come from.
    pub fn folder(&self) -> &Path {
        match &self.files {
            MeshSource::Templates(files) => files.templates,
            MeshSource::Own(files) => files.folder,
        }
    }

    /// Time step, s.
    pub fn time_step(&self) -> f64 {
        match &self.files {
            MeshSource::Templates(files) => files.time.step,
            MeshSource::Own(files) => files.time_step,
        }
    }

    /// The same for a single rank.
    #[must_use]
    pub fn on_one_rank(mut self) -> Self {
        match &mut self.files {
            MeshSource::Templates(files) => files.ranks = 1,
            MeshSource::Own(files) => files.ranks = 1,
        }
        self
    }
}
