//! The samples of a study of uncertain inputs: what `[[uncertain]]` says at the points of a design, as a table.

use crate::case::{self, Override, ResolvedCase, ValuePlace};
use crate::output::report::SAMPLES;
use crate::run::{CaseSelection, Failure};
use crate::uncertainty::Design;
use std::fmt::Write as _;
use std::path::Path;

/// What its first line begins with, before the design.
const MARK: &str = "# ";

/// Samples of a case.
pub struct Samples {
    design: Design,
    /// Names of the inputs.
    names: Vec<String>,
    /// The keys of each input, joined by `+`.
    keys: Vec<String>,
    /// The mean that an input takes from the case: a sample no longer has that value.
    means: Vec<Option<f64>>,
    /// For each sample the value of each input; with `*`, a factor.
    rows: Vec<Vec<String>>,
}

impl Samples {
    /// Of a case at the points of a design.
    ///
    /// # Errors
    /// If the case has no uncertain inputs, or the design has more points than there can be.
    pub fn new(case: &ResolvedCase, path: &Path, design: Design) -> Result<Self, Failure> {
        let uncertain = case.uncertain.as_deref().unwrap_or_default();
        if uncertain.is_empty() {
            return Err(Failure::Input(format!(
                "--samples {design}: {} has no [[uncertain]] inputs to be sampled: add some, as `fsi-driver keys uncertain` \
                 shows, or name a table of samples",
                path.display()
            )));
        }
        let values: Vec<Option<f64>> = uncertain.iter().map(|i| i.value_in(case)).collect();
        let usual: Vec<f64> = values.iter().map(|value| value.unwrap_or(1.0)).collect();
        let correlations = case.correlation.as_deref().unwrap_or_default();
        let inputs = case::inputs(uncertain, correlations, &usual).map_err(Failure::Input)?;
        let points = design.points(inputs.count()).ok_or_else(|| {
            let count = inputs.count();
            Failure::Input(format!(
                "--samples {design}: more than 65536 samples of {count} inputs, or more than 256 inputs: take fewer"
            ))
        })?;
        let cell = |(value, x): (&Option<f64>, f64)| match value {
            Some(_) => nine_digits(x),
            None => format!("*{}", nine_digits(x)),
        };
        let row = |point: &Vec<f64>| {
            let sampled = inputs.values_at(point).into_iter();
            values.iter().zip(sampled).map(cell).collect()
        };
        Ok(Self {
            names: uncertain.iter().map(|input| input.name.clone()).collect(),
            keys: uncertain.iter().map(|input| input.keys.join("+")).collect(),
            means: (uncertain.iter().zip(&values))
                .map(|(input, value)| value.filter(|_| input.takes_mean_of_case()))
                .collect(),
            rows: points.iter().map(row).collect(),
            design,
        })
    }

    /// The selections, each with what it adds to the name of its run.
    pub fn variants(&self, selection: &CaseSelection) -> Vec<(String, CaseSelection)> {
        let set = |key: &str, value: &str| Override {
            place: ValuePlace::Sweep,
            key: key.to_owned(),
            value: value.to_owned(),
        };
        let variant = |(number, row): (usize, &Vec<String>)| {
            let mut chosen = selection.clone();
            for (i, value) in row.iter().enumerate() {
                chosen
                    .given
                    .extend(self.keys[i].split('+').map(|key| set(key, value)));
                if let Some(mean) = self.means[i] {
                    // By name: in the file an input may stand for several.
                    let key = format!("uncertain[{}].mean", self.names[i]);
                    chosen.given.push(set(&key, &format!("{mean:?}")));
                }
            }
            (format!("-{}", name(number)), chosen)
        };
        self.rows.iter().enumerate().map(variant).collect()
    }

    /// The inputs of a sample in words.
    pub fn told(&self, number: usize) -> String {
        let inputs = self.names.iter().zip(&self.rows[number]);
        let told: Vec<String> = inputs.map(|(name, x)| format!("{name} = {x}")).collect();
        told.join(", ")
    }

    /// The table, which `--samples` reads as well.
    fn to_csv(&self) -> String {
        let mut text = format!("{MARK}{}\nname", self.design);
        let quoted = |cell: &str| match cell.contains([',', '"']) {
            true => format!("\"{}\"", cell.replace('"', "\"\"")),
            false => cell.to_owned(),
        };
        self.keys
            .iter()
            .for_each(|key| text += &format!(",{}", quoted(key)));
        text.push('\n');
        for (number, row) in self.rows.iter().enumerate() {
            let _ = writeln!(text, "{},{}", name(number), row.join(","));
        }
        text
    }

    /// Writes the table. One that is there may lack samples that this one has, not more.
    ///
    /// # Errors
    /// If what is there are other samples, or it cannot be written.
    pub fn keep(&self, out: &Path) -> Result<(), Failure> {
        let path = out.join(SAMPLES);
        let text = self.to_csv();
        if let Ok(before) = std::fs::read_to_string(&path) {
            let rows = |text: &str| text.lines().skip(1).map(str::to_owned).collect::<Vec<_>>();
            let (before, now) = (rows(&before), rows(&text));
            if let Some(i) = (0..before.len()).find(|&i| now.get(i) != Some(&before[i])) {
                let now = now.get(i).map_or("nothing", String::as_str);
                return Err(Failure::Input(format!(
                    "{}:{}: the study has {}, and --samples {} with the [[uncertain]] of the case makes {now}: take back what \
                     has changed, or choose another folder with --out",
                    path.display(),
                    i + 2,
                    before[i],
                    self.design
                )));
            }
        }
        crate::output::write_atomically(&path, text.as_bytes())
            .map_err(|e| Failure::Run(format!("cannot write {e}")))
    }

    /// The design of the samples in the folder of a study; none if it has no such table.
    ///
    /// # Errors
    /// If the table does not say it.
    pub fn design_in(out: &Path) -> Result<Option<Design>, Failure> {
        let path = out.join(SAMPLES);
        let Ok(text) = std::fs::read_to_string(&path) else {
            return Ok(None);
        };
        let first = text.lines().next().and_then(|line| line.strip_prefix(MARK));
        let design = first.and_then(|design| design.parse().ok());
        design.map(Some).ok_or_else(|| {
            Failure::Input(format!(
                "{}:1: expected the samples of the study, such as `{MARK}sobol:64`: give them with --samples",
                path.display()
            ))
        })
    }
}

fn name(number: usize) -> String {
    format!("{:03}", number + 1)
}

/// Few enough digits to read, more than any input has.
fn nine_digits(x: f64) -> String {
    let rounded: f64 = format!("{x:.8e}").parse().unwrap_or(x);
    format!("{rounded:?}")
}
