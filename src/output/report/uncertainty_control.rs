//! Means of a study by the samples of a cheaper study of the same inputs.

use super::page::significant;
use super::table::PageTable;
use super::uncertainty::Uncertainty;
use crate::uncertainty::ControlledMean;
use std::path::Path;

/// The table, in the folder of the study.
pub const CONTROL: &str = "control.csv";
/// Inputs that differ by less, relatively, are the same: tables have nine digits.
const SAME: f64 = 1e-7;

impl Uncertainty {
    /// Of each measure that both studies have the mean by the samples of this one, and by those of a cheaper study that
    /// contains them as well; `costs` are the mean seconds of a run of each.
    ///
    /// # Errors
    /// A sentence if the cheaper study does not contain the samples of this one, or has no more.
    pub fn controlled_by(&self, cheap: &Self, costs: [f64; 2]) -> Result<PageTable, String> {
        let is_same = |x: &[f64], y: &[f64]| {
            x.len() == y.len()
                && x.iter()
                    .zip(y)
                    .all(|(a, b)| (a - b).abs() <= SAME * a.abs())
        };
        let place = |x: &[f64]| cheap.points.iter().position(|(_, y)| is_same(x, y));
        let places: Option<Vec<usize>> = self.points.iter().map(|(_, x)| place(x)).collect();
        let places = places
            .filter(|places| self.names() == cheap.names() && places.len() < cheap.points.len());
        let Some(places) = places else {
            return Err(format!(
                "it must have the {} samples of this study and more, of the same [[uncertain]] inputs: begin it with the same \
                 --samples, with more of them (Sobol's sequence only)",
                self.points.len()
            ));
        };
        let mut table = PageTable::new([
            "measure",
            "mean",
            "standard error",
            "mean with control",
            "its standard error",
            "correlation",
            "variance reduction",
            "cost in runs",
            "worth in runs",
        ]);
        let (few, many) = (self.points.len() as f64, cheap.points.len() as f64);
        for measure in &self.measures {
            let Some(cheaper) = cheap.measures.iter().find(|m| m.name == measure.name) else {
                continue;
            };
            let pairs = measure.of_runs.iter().zip(&places);
            let pairs = pairs.filter_map(|(value, &at)| Some(((*value)?, cheaper.of_runs[at]?)));
            let (values, controls): (Vec<f64>, Vec<f64>) = pairs.unzip();
            let all: Vec<f64> = cheaper.of_runs.iter().flatten().copied().collect();
            let Some(mean) = ControlledMean::new(&values, &controls, &all) else {
                continue;
            };
            let figures = [
                mean.plain[0],
                mean.plain[1],
                mean.controlled[0],
                mean.controlled[1],
                mean.correlation,
                mean.variance_reduction(),
                few + many * costs[1] / costs[0],
                few * mean.variance_reduction(),
            ];
            let name = std::iter::once(measure.name.clone());
            table.push(name.chain(figures.map(|x| significant(x, 5))).collect());
        }
        Ok(table)
    }
}

/// The table of an earlier call as HTML; nothing if there is none.
pub(super) fn kept(folder: &Path) -> String {
    let Some(table) = PageTable::stored(&folder.join(CONTROL)) else {
        return String::new();
    };
    format!(
        "<h3>Means with cheaper runs as control variates</h3>\n<p>The cheaper study has the same samples and more; what it \
         says more of the mean counts as far as both are correlated. Standard errors are those of independent samples. \
         Cost and worth are in runs of this study.</p>\n{}",
        table.to_html()
    )
}
