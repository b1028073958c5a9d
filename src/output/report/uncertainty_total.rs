//! What is not known of a result in all: by its inputs, by its discretization, and by what it is compared with (ASME
//! V&V 20, 2009).

use super::page::significant;
use super::refined::{RefinementSeries, refined};
use super::sweep;
use super::table::PageTable;
use super::uncertainty::Uncertainty;
use crate::case::{Case, Uncertain};
use std::path::Path;

/// The table, in the folder of the study.
pub const TOTAL: &str = "total-uncertainty.csv";
/// Standard uncertainties in an expanded one of 95 %.
const COVERAGE: f64 = 2.0;
/// Differing keys that are named, at most.
const MOST_KEYS: usize = 3;

/// A measured value with its standard uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredValue {
    /// Of which measure.
    pub measure: String,
    /// In its unit.
    pub value: f64,
    /// In its unit.
    pub uncertainty: f64,
}

impl Uncertainty {
    /// Of each measure the value where refinement leads to, and its standard uncertainties: numerical (half of what
    /// the `series` leave open, whose first run is the same, at the resolution of the samples), by the inputs (standard
    /// deviation), both together; and where it was `measured` the comparison error and its uncertainty.
    ///
    /// # Errors
    /// A sentence if the series do not begin with the same run, or that differs from the samples in more than their
    /// inputs.
    pub fn total(
        &self,
        sample: &Case,
        series: &[RefinementSeries],
        measured: &[MeasuredValue],
    ) -> Result<PageTable, String> {
        let Some(base) = series.first().and_then(|series| series.runs.first()) else {
            return Err("it has no runs".to_owned());
        };
        if let Some(other) = series
            .iter()
            .find(|s| s.runs[0].files.root() != base.files.root())
        {
            return Err(format!(
                "{} begins with {} and {} with {}: expected the same run, with the resolution of the samples",
                series[0].name,
                base.name(),
                other.name,
                other.runs[0].name()
            ));
        }
        self.refuse_other_case(sample, &base.case)?;
        let mut table = PageTable::new(heads(series, !measured.is_empty()));
        for (name, values) in sweep::values_of_measures(&[base]) {
            let of_inputs = self.measures.iter().find(|measure| measure.name == name);
            let (Some(of_inputs), Some(value)) = (of_inputs, values[0]) else {
                continue;
            };
            let (moved, limit) = refined(value, |run| self.value(run, &name), series);
            let (numerical, inputs) = (limit.uncertainty / COVERAGE, of_inputs.deviation());
            let mut row = vec![name.clone(), significant(value, 5)];
            row.extend(moved.into_iter().map(|moved| match moved {
                Some(moved) => format!(
                    "{} ± {}",
                    significant(moved.value, 2),
                    significant(moved.uncertainty, 2)
                ),
                None => "–".into(),
            }));
            row.push(significant(limit.value, 5));
            let both = numerical.hypot(inputs);
            row.extend([numerical, inputs, both, COVERAGE * both].map(|x| significant(x, 3)));
            if !measured.is_empty() {
                row.extend(match measured.iter().find(|found| found.measure == name) {
                    None => ["–"; 5].map(str::to_owned),
                    Some(found) => {
                        let error = limit.value - found.value;
                        let of_error = both.hypot(found.uncertainty);
                        let is_within = error.abs() <= COVERAGE * of_error;
                        [
                            significant(found.value, 5),
                            significant(found.uncertainty, 3),
                            significant(error, 3),
                            significant(of_error, 3),
                            if is_within { "yes" } else { "no" }.to_owned(),
                        ]
                    }
                });
            }
            table.push(row);
        }
        Ok(table)
    }

    /// Refuses a case that differs from that of a sample in other keys than the inputs.
    fn refuse_other_case(&self, sample: &Case, base: &Case) -> Result<(), String> {
        let (sample, base) = (sweep::values(sample), sweep::values(base));
        let of_inputs = |key: &str| self.tables.iter().any(|input| is_of(input, key));
        let other: Vec<&str> = (sample.keys().chain(base.keys()))
            .filter(|key| sample.get(*key) != base.get(*key))
            .map(String::as_str)
            .filter(|key| !key.starts_with("uncertain") && !key.starts_with("output."))
            .filter(|key| !of_inputs(key))
            .take(MOST_KEYS)
            .collect();
        match other.is_empty() {
            true => Ok(()),
            false => Err(format!(
                "its first run differs from the samples in {}: expected the case of the samples",
                other.join(", ")
            )),
        }
    }
}

/// Whether a key is of an input, whose keys may name an element of a list otherwise.
fn is_of(input: &Uncertain, key: &str) -> bool {
    let plain = |key: &str| {
        let mut is_inside = false;
        let outside = key.chars().filter(|letter| {
            is_inside = (is_inside || *letter == '[') && *letter != ']';
            !is_inside && *letter != ']'
        });
        outside.collect::<String>()
    };
    input.keys.iter().any(|own| plain(own) == plain(key))
}

fn heads(series: &[RefinementSeries], has_measured: bool) -> Vec<String> {
    let mut heads = vec!["measure".to_owned(), "simulated".to_owned()];
    heads.extend(series.iter().map(|series| series.name.clone()));
    heads.extend(
        [
            "where refinement leads",
            "u numerical",
            "u inputs",
            "u both",
            "95 %",
        ]
        .map(str::to_owned),
    );
    if has_measured {
        let of_measured = [
            "measured",
            "u measured",
            "error E",
            "u of E",
            "E within 95 %",
        ];
        heads.extend(of_measured.map(str::to_owned));
    }
    heads
}

/// The table of an earlier call as HTML; nothing if there is none.
pub(super) fn kept(folder: &Path) -> String {
    let Some(table) = PageTable::stored(&folder.join(TOTAL)) else {
        return String::new();
    };
    format!(
        "<h3>Inputs and discretization together</h3>\n<p>Standard uncertainties u in the sense of ASME V&amp;V 20: by the \
         discretization half of what refining one thing at a time leaves open, by the inputs the standard deviation. What \
         refinement changes is added to the simulated value; 95 % is twice the uncertainty of both.</p>\n{}",
        table.to_html()
    )
}
