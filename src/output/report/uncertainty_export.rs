//! Inputs, samples and measures of a study as other programs for uncertainty read them.

use super::uncertainty::Uncertainty;
use crate::uncertainty::Law;
use serde_json::{Map, Value, json};

/// Whose form.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ExportForm {
    /// SALib: one file with `problem`, `X` and `Y`.
    Salib,
    /// EasyVVUQ: `params.json`, `vary.json` with distributions of chaospy, and a file for each run.
    Easyvvuq,
}

impl Uncertainty {
    /// The files of a form, each with its path in the folder of the study.
    pub fn export(&self, form: ExportForm) -> Vec<(String, String)> {
        match form {
            ExportForm::Salib => vec![("salib.json".to_owned(), text(&self.of_salib()))],
            ExportForm::Easyvvuq => self.of_easyvvuq(),
        }
    }

    /// What SALib has no form for: a bounded lognormal distribution has its bounds in `truncated`.
    fn of_salib(&self) -> Value {
        let inputs = || (0..self.tables.len()).map(|i| self.inputs.marginal(i).law());
        let (dists, bounds): (Vec<&str>, Vec<Vec<f64>>) = inputs()
            .map(|law| match law {
                Law::Uniform(bounds) => ("unif", bounds.to_vec()),
                Law::Normal(parameters, bounds) if is_bounded(bounds) => {
                    let [low, high] = finite(bounds);
                    ("truncnorm", vec![low, high, parameters[0], parameters[1]])
                }
                Law::Normal(parameters, _) => ("norm", parameters.to_vec()),
                Law::Lognormal(parameters, _) => ("lognorm", parameters.to_vec()),
            })
            .unzip();
        let truncated: Map<String, Value> = (self.tables.iter().zip(inputs()))
            .filter_map(|(input, law)| match law {
                Law::Lognormal(_, bounds) if bounds[0] > 0.0 || bounds[1].is_finite() => {
                    Some((input.name.clone(), json!(finite(bounds))))
                }
                _ => None,
            })
            .collect();
        let x: Vec<&Vec<f64>> = self.points.iter().map(|(_, x)| x).collect();
        let runs: Vec<&String> = self.points.iter().map(|(name, _)| name).collect();
        let y: Map<String, Value> = (self.measures.iter())
            .map(|measure| (measure.name.clone(), json!(measure.of_runs)))
            .collect();
        json!({
            "problem": {
                "num_vars": self.tables.len(),
                "names": self.names(),
                "bounds": bounds,
                "dists": dists,
            },
            "truncated": truncated,
            "runs": runs,
            "X": x,
            "Y": y,
        })
    }

    fn of_easyvvuq(&self) -> Vec<(String, String)> {
        let mut params = Map::new();
        let mut vary = Map::new();
        for (i, name) in self.names().into_iter().enumerate() {
            let distribution = self.inputs.marginal(i);
            let median = distribution.quantile(0.5);
            params.insert(name.clone(), json!({"type": "float", "default": median}));
            let mut law = Map::new();
            let (word, parameters, bounds) = match distribution.law() {
                Law::Uniform(bounds) => ("Uniform", None, Some(bounds)),
                Law::Normal(p, bounds) => {
                    ("Normal", Some(p), Some(bounds).filter(|b| is_bounded(*b)))
                }
                Law::Lognormal(p, bounds) => {
                    let is_cut = bounds[0] > 0.0 || bounds[1].is_finite();
                    ("LogNormal", Some(p), Some(bounds).filter(|_| is_cut))
                }
            };
            law.insert("distribution".into(), json!(word));
            if let Some([mu, sigma]) = parameters {
                law.extend([
                    ("mu".to_owned(), json!(mu)),
                    ("sigma".to_owned(), json!(sigma)),
                ]);
            }
            if let Some([low, high]) = bounds.map(finite) {
                law.extend([
                    ("lower".to_owned(), json!(low)),
                    ("upper".to_owned(), json!(high)),
                ]);
            }
            vary.insert(name, Value::Object(law));
        }
        let mut files = vec![
            (
                "easyvvuq/params.json".to_owned(),
                text(&Value::Object(params)),
            ),
            ("easyvvuq/vary.json".to_owned(), text(&Value::Object(vary))),
        ];
        for (k, (run, x)) in self.points.iter().enumerate() {
            let inputs = self.names().into_iter().zip(x.iter().map(|x| json!(x)));
            let measures = self.measures.iter();
            let measures = measures.map(|m| (m.name.clone(), json!(m.of_runs[k])));
            let values: Map<String, Value> = inputs.chain(measures).collect();
            files.push((
                format!("easyvvuq/runs/{run}.json"),
                text(&Value::Object(values)),
            ));
        }
        files
    }
}

fn is_bounded(bounds: [f64; 2]) -> bool {
    bounds.iter().any(|bound| bound.is_finite())
}

/// Bounds as numbers that JSON has: what is infinite is as far as no sample comes.
fn finite(bounds: [f64; 2]) -> [f64; 2] {
    bounds.map(|bound| bound.clamp(-1e300, 1e300))
}

fn text(value: &Value) -> String {
    let mut text = serde_json::to_string_pretty(value).expect("numbers and texts alone");
    text.push('\n');
    text
}
