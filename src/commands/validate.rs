//! `fsi-driver validate FILE RUN…`: runs compared with what an experiment has measured.

use super::Failure;
use crate::output::terminal;
use crate::output::validation::Validation;
use std::path::PathBuf;

/// What the cells of a run say.
const LEGEND: &str = "of each run: root mean square of its difference from the reference (mean; points between the lowest and the highest \
                      value, where several were measured), as a share of the largest reference value of the series";

/// Options of the comparison with an experiment.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// What was measured: a CSV file with the columns series,quantity,x_m,y_m,z_m,value and, as they are known,
    /// statistic,time_s,sd,lowest,highest.
    #[arg(value_name = "FILE")]
    measured: PathBuf,
    /// Folders of runs whose case names the file as output.measured.
    #[arg(value_name = "RUN", required = true)]
    runs: Vec<PathBuf>,
    /// Show one series point by point; `all` shows each.
    #[arg(long, value_name = "NAME")]
    series: Option<String>,
    /// The runs are refined by the same factor from each to the next: show also where their statistics over time lead.
    #[arg(long)]
    refined: bool,
    /// Draw all series side by side: FILE.svg and FILE.png.
    #[arg(long, value_name = "FILE")]
    figure: Option<PathBuf>,
}

/// Prints a table of all series, or of the points of one, in Markdown.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.refined && arguments.runs.len() < 2 {
        let found = arguments.runs.len();
        return Err(Failure::Input(format!(
            "--refined: found {found} run, expected two or more, from coarse to fine"
        )));
    }
    let validation = Validation::read(&arguments.measured, &arguments.runs)?;
    if let Some(path) = &arguments.figure {
        let written = validation.figure().write(path);
        written.map_err(|e| Failure::Run(format!("cannot write {e}")))?;
    }
    let names: Vec<&str> = match arguments.series.as_deref() {
        None => {
            if validation.series().next().is_some() {
                let table = validation.summary().to_markdown();
                terminal::print(format_args!("{table}\n{LEGEND}\n"))?;
            }
            if let Some(table) = validation.statistics(arguments.refined) {
                terminal::print(format_args!("{}\n", table.to_markdown()))?;
            }
            return Ok(());
        }
        Some("all") => validation.series().collect(),
        Some(name) => vec![name],
    };
    for name in names {
        let table = validation.points(name)?;
        terminal::print(format_args!("{name}\n\n{}\n", table.to_markdown()))?;
    }
    Ok(())
}
