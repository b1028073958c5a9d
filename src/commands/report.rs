//! `fsi-driver report RUN|STUDY`: one page that shows everything, by itself.

use super::Failure;
use crate::output::report::{self, Study};
use crate::output::results::{Results, ResultsError};
use crate::output::run_files::{MARK, RunFiles};
use crate::output::{figure, terminal, write_atomically};
use crate::paper;
use crate::run::{Interrupt, at_work};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Pixels of a picture's PNG per pixel of its SVG: a picture is 1012 pixels wide.
const PIXELS_PER_UNIT: f32 = 1.15;

/// A page is followed by the next one after at least this time, and this many times what it took to make.
const PAUSE: (Duration, u32) = (Duration::from_secs(5), 10);

/// Options of the report.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of a run, or of a study.
    #[arg(value_name = "RUN|STUDY")]
    folder: PathBuf,
    /// The page [default: report.html in the folder].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Writes one picture of a run as well: its wall cut open, above pressure and flow (.png or .svg).
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Show it in the browser.
    #[arg(long)]
    open: bool,
    /// Makes the page of a run that is going on again and again, until the run has ended or Ctrl-C.
    #[arg(long)]
    follow: bool,
}

/// Writes the page.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = &arguments.folder;
    if arguments.follow {
        if !folder.join(MARK).is_file() {
            return Err(Failure::Input(format!(
                "--follow: {} is not the folder of a run (it holds no {MARK}); name that of a run that is going on",
                folder.display()
            )));
        }
        return follow(arguments);
    }
    let (page, size) = make(arguments)?;
    tell(&page, size)?;
    match arguments.open {
        true => open(&page),
        false => Ok(()),
    }
}

/// Makes the page as the history of the run grows, until the run has ended or the user asks to end.
fn follow(arguments: &Arguments) -> Result<(), Failure> {
    let interrupt = Interrupt::listen(None)?;
    let folder = &arguments.folder;
    let history = RunFiles::new(folder).history();
    let reached = || std::fs::metadata(&history).map_or(0, |file| file.len());
    let (mut shown, mut next, mut is_open) = (0, Instant::now(), !arguments.open);
    loop {
        let goes_on = at_work(folder).is_some();
        let length = reached();
        if !goes_on || length > shown && Instant::now() > next {
            let begun = Instant::now();
            let (page, size) = make(arguments)?;
            if shown == 0 || !goes_on {
                tell(&page, size)?;
            }
            if !is_open {
                open(&page)?;
                is_open = true;
            }
            if !goes_on {
                return Ok(());
            }
            (shown, next) = (
                length,
                Instant::now() + PAUSE.0.max(PAUSE.1 * begun.elapsed()),
            );
        }
        if interrupt.asked() {
            return Ok(());
        }
        std::thread::sleep(Duration::from_millis(200));
    }
}

/// Says where the page is.
fn tell(page: &Path, size: f64) -> Result<(), Failure> {
    let line = format_args!("{} ({size:.1} MB)\n", page.display());
    Ok(terminal::print(line)?)
}

/// Writes the page; returns where it is, and its size in MB.
fn make(arguments: &Arguments) -> Result<(PathBuf, f64), Failure> {
    let folder = &arguments.folder;
    let unreadable = |e: std::io::Error| {
        Failure::Input(format!(
            "cannot read the results in {}: {e}",
            folder.display()
        ))
    };
    let html = if folder.join(MARK).is_file() {
        let run = match at_work(folder) {
            Some(_) => Results::load_unfinished(folder),
            None => Results::load(folder),
        };
        let run = run.map_err(|error| Failure::Input(error.to_string()))?;
        if let Some(file) = &arguments.picture {
            write_picture(file, &report::picture(&run).map_err(unreadable)?)?;
        }
        report::of_run(&run).map_err(unreadable)?
    } else {
        if let Some(file) = &arguments.picture {
            return Err(Failure::Input(format!(
                "--picture {}: {} is not the folder of a run; name one of the runs of the study",
                file.display(),
                folder.display()
            )));
        }
        let study = study(folder, Results::load)?;
        let page = match paper::PaperStudy::is_that_of(&study) {
            true => paper::study::page(&paper::PaperStudy::new(study)),
            false => report::of_study(&study),
        };
        page.map_err(unreadable)?
    };
    let page = arguments
        .out
        .clone()
        .unwrap_or_else(|| folder.join("report.html"));
    write("--out", &page, html.as_bytes())?;
    Ok((page, html.len() as f64 / 1e6))
}

/// Writes the file that an `option` names.
fn write(option: &str, file: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let parent = file.parent().filter(|p| !p.as_os_str().is_empty());
    if let Some(parent) = parent.filter(|parent| !parent.is_dir()) {
        return Err(Failure::Input(format!(
            "{option} {}: there is no folder {}; create it, or choose another",
            file.display(),
            parent.display()
        )));
    }
    write_atomically(file, bytes).map_err(|e| Failure::Run(format!("cannot write {e}")))
}

/// Writes a picture in the format that the ending of its file asks for.
fn write_picture(file: &Path, svg: &str) -> Result<(), Failure> {
    let ending = file.extension().and_then(|e| e.to_str());
    match ending.map(str::to_lowercase).as_deref() {
        Some("svg") => write("--picture", file, svg.as_bytes()),
        Some("png") => {
            let png = figure::to_png(svg, PIXELS_PER_UNIT);
            let png = png.map_err(|e| Failure::Run(format!("cannot draw the picture: {e}")))?;
            write("--picture", file, &png)
        }
        _ => Err(Failure::Input(format!(
            "--picture {}: a picture is a .png or a .svg; name the file so",
            file.display()
        ))),
    }
}

/// The run in a folder.
///
/// # Errors
/// If there is none, or it has not ended; one that is going on is said to be.
pub(super) fn load(folder: &Path) -> Result<Results, Failure> {
    Results::load(folder).map_err(|error| match at_work(folder) {
        Some(holder) => Failure::Input(format!(
            "the run in {} is going on ({holder}): its results can be read once it has ended; history.csv and ParaView's files are \
             there already",
            folder.display()
        )),
        None => Failure::Input(error.to_string()),
    })
}

/// The runs in the folders below `folder`, each read by `load`.
pub(super) fn study(
    folder: &Path,
    load: fn(&Path) -> Result<Results, ResultsError>,
) -> Result<Study, Failure> {
    let entries = std::fs::read_dir(folder)
        .map_err(|e| Failure::Input(format!("cannot read the folder {}: {e}", folder.display())))?;
    let folders = entries.flatten().map(|entry| entry.path());
    let mut folders: Vec<PathBuf> = folders.filter(|path| path.join(MARK).is_file()).collect();
    // Results that a study has set aside are not models.
    folders.retain(|path| !path.to_string_lossy().contains(".before-"));
    folders.sort();
    let (mut runs, mut missing) = (Vec::new(), Vec::new());
    for path in &folders {
        match load(path) {
            Ok(run) => runs.push(run),
            Err(error) => missing.push(error.to_string()),
        }
    }
    if runs.is_empty() {
        let why = match missing.as_slice() {
            [] => format!(
                "{} is neither the folder of a run nor of a study (no folder in it holds {MARK})",
                folder.display()
            ),
            some => some.join("\n"),
        };
        return Err(Failure::Input(why));
    }
    let name = folder.canonicalize().ok();
    let name = name.and_then(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
    Ok(Study {
        title: name.map_or("Study".into(), |name| format!("Study {name}")),
        runs,
        missing,
        folder: folder.to_owned(),
    })
}

/// Hands the page to the browser of this desktop.
fn open(page: &Path) -> Result<(), Failure> {
    let shown = Command::new("xdg-open")
        .arg(page)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    shown.map(drop).map_err(|e| {
        Failure::Run(format!(
            "the page is written, but xdg-open cannot show it: {e}; open {} yourself",
            page.display()
        ))
    })
}
