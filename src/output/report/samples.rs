//! Where single runs lie among the samples of uncertain inputs, from the tables of two studies: in numbers and drawn.

use super::page::{panel, significant};
use super::table::PageTable;
use crate::files::FileError;
use crate::output::figure::{Curve, Figure, Marker};
use std::path::Path;

/// The shares of the percentiles.
const PERCENTILES: [f64; 3] = [0.05, 0.5, 0.95];

/// A table with a name in the first column and numbers in others.
struct Table {
    heads: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn read(path: &Path) -> Result<Self, FileError> {
        let wrong = |e: csv::Error| FileError::new(path, e);
        let mut reader = csv::Reader::from_path(path).map_err(wrong)?;
        let cells = |row: &csv::StringRecord| row.iter().map(str::to_owned).collect::<Vec<_>>();
        let heads = cells(reader.headers().map_err(wrong)?);
        let rows = reader.records().map(|row| Ok(cells(&row.map_err(wrong)?)));
        let rows = rows.collect::<Result<_, FileError>>()?;
        Ok(Self { heads, rows })
    }

    /// The number of the column that is called so; a space counts as `_`.
    fn column(&self, name: &str) -> Option<usize> {
        let plain = |text: &str| text.replace(' ', "_");
        self.heads
            .iter()
            .position(|head| plain(head) == plain(name))
    }

    /// Names and values of a column.
    fn values(&self, column: usize) -> Vec<(&str, f64)> {
        let value = |row: &'_ Vec<String>| row[column].parse().ok();
        let rows = self.rows.iter();
        rows.filter_map(|row| Some((row[0].as_str(), value(row)?)))
            .collect()
    }
}

/// The distribution of these measures (with `_` for a space in their names) over the samples of the study in a folder,
/// with its `measures.csv` and `moments.csv`, and where the runs of the `others` lie: the share of the samples below
/// each.
///
/// # Errors
/// If a table cannot be read, or has no such measure.
pub fn distributions(
    samples: &Path,
    others: &Path,
    measures: &[&str],
) -> Result<(PageTable, Figure), FileError> {
    let paths = [samples, others].map(|folder| folder.join("measures.csv"));
    let [sampled, single] = [Table::read(&paths[0])?, Table::read(&paths[1])?];
    let moments = Table::read(&samples.join("moments.csv"))?;
    let names: Vec<&str> = single.rows.iter().map(|row| row[0].as_str()).collect();
    let labels = labels(&names);
    let heads = ["measure", "samples", "mean", "standard deviation"].map(str::to_owned);
    let percent = PERCENTILES.map(|share| format!("{:.0} %", 100.0 * share));
    let error = ["cross-validation error".to_owned()];
    let mut table = PageTable::new(
        (heads.into_iter().chain(percent).chain(error)).chain(labels.iter().cloned()),
    );
    let mut panels = Vec::new();
    for measure in measures {
        let column = |table: &Table, path: &Path| {
            table.column(measure).ok_or_else(|| {
                let known = table.heads[1..].join("; ");
                FileError::new(
                    path,
                    format!("no measure is called {measure}; there is {known}"),
                )
            })
        };
        let at = column(&sampled, &paths[0])?;
        let mut values: Vec<f64> = sampled.values(at).into_iter().map(|(_, x)| x).collect();
        values.sort_by(f64::total_cmp);
        if values.len() < 2 {
            return Err(FileError::new(
                &paths[0],
                format!("fewer than two runs have {measure}"),
            ));
        }
        let found = single.values(column(&single, &paths[1])?);
        let name = &sampled.heads[at];
        let mut row = vec![name.clone(), values.len().to_string()];
        row.extend(moments_of(&values).map(|x| significant(x, 3)));
        row.extend(PERCENTILES.map(|share| significant(percentile(&values, share), 3)));
        row.push(error_of(&moments, name));
        row.extend(names.iter().map(|name| {
            let value = found.iter().find(|(other, _)| other == name);
            value.map_or(String::new(), |(_, value)| {
                let below = 100.0 * share_below(&values, *value);
                format!("{} ({below:.0} % below)", significant(*value, 3))
            })
        }));
        table.push(row);
        let marked = found.iter().enumerate().map(|(i, (run, value))| Curve {
            name: (names.iter().zip(&labels))
                .find(|(name, _)| *name == run)
                .map_or(String::new(), |(_, label)| value_of(label).to_owned()),
            points: vec![(*value, 100.0 * share_below(&values, *value))],
            colour: i + 1,
            marker: Some(Marker::ALL[i % Marker::ALL.len()]),
            open: false,
        });
        let curves = std::iter::once(steps(&values)).chain(marked).collect();
        panels.push(panel("", name, "samples below / %", curves));
    }
    Ok((table, Figure { panels, columns: 2 }))
}

/// What the names of runs do not share at their beginning, after a separator.
fn labels(names: &[&str]) -> Vec<String> {
    let first = names.first().copied().unwrap_or_default();
    let shared = |n: usize| names.iter().all(|name| name.get(..n) == first.get(..n));
    let same = (0..=first.len()).filter(|n| first.is_char_boundary(*n) && shared(*n));
    let same = same.max().unwrap_or(0);
    let cut = first[..same].rfind(['-', '/', ' ']).map_or(0, |at| at + 1);
    names.iter().map(|name| name[cut..].to_owned()).collect()
}

/// What is behind the sign of equality: a legend is narrow.
fn value_of(label: &str) -> &str {
    label.rsplit_once('=').map_or(label, |(_, value)| value)
}

/// Mean and standard deviation of two values or more.
pub(super) fn moments_of(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    [mean, (squares / (count - 1.0)).sqrt()]
}

/// Of ascending values, linear between two.
fn percentile(values: &[f64], share: f64) -> f64 {
    let place = share * (values.len() - 1) as f64;
    let below = place as usize;
    let above = (below + 1).min(values.len() - 1);
    values[below] + (place - below as f64) * (values[above] - values[below])
}

/// Of ascending values.
fn share_below(values: &[f64], value: f64) -> f64 {
    values.partition_point(|x| *x < value) as f64 / values.len() as f64
}

/// How good the chaos of a measure is, in per cent of the variance.
fn error_of(moments: &Table, name: &str) -> String {
    let row = moments.rows.iter().find(|row| row[0] == name);
    let error = moments.column("cross-validation error").zip(row);
    let error = error.and_then(|(column, row)| row[column].parse::<f64>().ok());
    error.map_or(String::new(), |error| {
        format!("{} %", significant(100.0 * error, 2))
    })
}

/// The cumulative distribution of ascending values.
fn steps(values: &[f64]) -> Curve {
    let share = |count: usize| 100.0 * count as f64 / values.len() as f64;
    let points = values.iter().enumerate();
    Curve {
        name: "samples".into(),
        points: points
            .flat_map(|(i, x)| [(*x, share(i)), (*x, share(i + 1))])
            .collect(),
        colour: 0,
        marker: None,
        open: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_have_their_place_among_the_samples() {
        let folder = tempfile::tempdir().unwrap();
        let [study, four] = ["study", "four"].map(|name| folder.path().join(name));
        for folder in [&study, &four] {
            std::fs::create_dir(folder).unwrap();
        }
        let write = |path: &Path, text: &str| std::fs::write(path, text).unwrap();
        let samples: String = (1..=20)
            .map(|i| format!("\"own-{i:03}\",0.5,{i}\n"))
            .collect();
        let head = "\"case\",\"x\",\"mid_artery: TAWSS, mean / Pa\"\n";
        write(
            &study.join("measures.csv"),
            &format!("{head}{samples}\"own-021\",0.5,\n"),
        );
        write(
            &study.join("moments.csv"),
            "\"measure\",\"cross-validation error\"\n\"mid_artery: TAWSS, mean / Pa\",0.0123\n",
        );
        write(
            &four.join("measures.csv"),
            &format!("{head}\"own-d=1\",1,5.5\n\"own-d=2\",2,30\n"),
        );
        let measure = "mid_artery:_TAWSS,_mean_/_Pa";
        let (table, figure) = distributions(&study, &four, &[measure]).unwrap();
        let expected = "| measure | samples | mean | standard deviation | 5 % | 50 % | 95 % | cross-validation error | d=1 | d=2 |\n\
                        | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n\
                        | mid_artery: TAWSS, mean / Pa | 20 | 10.5 | 5.92 | 1.95 | 10.5 | 19.1 | 1.2 % | 5.50 (25 % below) | 30.0 \
                        (100 % below) |\n";
        assert_eq!(table.to_markdown(), expected);
        let curves = &figure.panels[0].curves;
        assert_eq!(curves[0].points[..3], [(1.0, 0.0), (1.0, 5.0), (2.0, 5.0)]);
        assert_eq!(
            (curves[1].name.as_str(), &curves[1].points[..]),
            ("1", &[(5.5, 25.0)][..])
        );
        let none = distributions(&study, &four, &["TAWSS"]).err().unwrap();
        assert!(
            none.to_string()
                .contains("there is x; mid_artery: TAWSS, mean / Pa"),
            "{none}"
        );
    }
}
