//! `fsi-driver preview DIR`: a vessel before anything is computed.

use super::{CaseArguments, Failure};
use crate::output::progress::tell_preparation;
use crate::output::report::Preview;
use crate::output::{terminal, write_atomically};
use std::path::PathBuf;

/// What is drawn, and where to.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of the case, with its case.toml.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Folder of preview.html, preview.png and preview.svg [default: that of the case].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    case: CaseArguments,
}

/// Writes page and pictures.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    tell_preparation();
    let case = arguments.case.selection()?.read(&arguments.folder)?;
    let name = arguments.folder.canonicalize().ok();
    let name = name.and_then(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
    let name = case.output.title.clone().or(name).unwrap_or_default();
    let preview = Preview::of(&case, &name).ok_or_else(|| {
        Failure::Input(
            "the case is not about a vessel, but about a flag or an OpenFOAM case of your own without [tree]: there is nothing to \
             draw; the page of a run shows its wall"
                .into(),
        )
    })?;
    let preview = preview.map_err(|e| match e.kind() {
        std::io::ErrorKind::InvalidInput => Failure::Input(e.to_string()),
        _ => Failure::Run(format!("cannot draw the vessel: {e}")),
    })?;
    let default_folder = match arguments.folder.is_dir() {
        true => arguments.folder.clone(),
        false => arguments
            .folder
            .parent()
            .map(PathBuf::from)
            .unwrap_or_default(),
    };
    let folder = arguments.out.clone().unwrap_or(default_folder);
    std::fs::create_dir_all(&folder)
        .map_err(|e| Failure::Run(format!("cannot make {}: {e}", folder.display())))?;
    for (name, bytes) in [
        ("preview.html", preview.html.as_bytes()),
        ("preview.png", &preview.png),
        ("preview.svg", preview.svg.as_bytes()),
    ] {
        let path = folder.join(name);
        write_atomically(&path, bytes).map_err(|e| Failure::Run(format!("cannot write {e}")))?;
        terminal::print(format_args!("{}\n", path.display()))?;
    }
    Ok(())
}
