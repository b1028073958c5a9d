//! What of a case is not known exactly: the tables `[[uncertain]]` and `[[correlation]]`.

use super::Case;
use super::schema::{ValueKind, above, from};
use super::table::{table, words};
use crate::uncertainty::{Distribution, Inputs};

/// Most keys of an input.
const MOST_KEYS: usize = 50;
/// Any number that a key has.
const ANY: ValueKind = from(-1e15, 1e15);
/// What of a normal distribution is left out where its range is told: samples beyond are not to be expected.
const TAIL: f64 = 1e-6;

table! {
    /// An input of a study that is not known exactly.
    pub struct Uncertain {
        name: String = "name", ValueKind::Text(30), "name of the input in tables and figures";
        /// Several keys, or one that has a list, are multiplied by the input, which is then a factor.
        keys: Vec<String> = "keys", ValueKind::Names(MOST_KEYS), "the key, or the keys that scale together";
        distribution: DistributionKind = "distribution", ValueKind::Word(DistributionKind::WORDS), "how likely its values are";
        mean: Option<f64> = "mean", ANY, "mean, before bounds cut anything off",
            absent "the value of the case; 1 of a factor";
        variation: Option<f64> = "variation", above(0.0, 10.0), "standard deviation over mean, before bounds cut anything off",
            absent "none: a uniform distribution has its bounds";
        low: Option<f64> = "low", ANY, "lower bound", absent "none";
        high: Option<f64> = "high", ANY, "upper bound", absent "none";
    }
}

words! {
    /// How likely the values of an uncertain input are.
    pub enum DistributionKind {
        /// Equally likely between low and high, or with a mean and a variation.
        Uniform = "uniform",
        /// Normal; with bounds, cut off there.
        Normal = "normal",
        /// The logarithm is normal: for what is never negative.
        Lognormal = "lognormal",
    }
}

table! {
    /// Two uncertain inputs that depend on each other (by a Gaussian copula).
    pub struct Correlation {
        first: String = "first", ValueKind::Text(30), "name of one of the inputs";
        second: String = "second", ValueKind::Text(30), "name of the other one";
        coefficient: f64 = "coefficient", from(-0.999, 0.999), "correlation of the normal variables behind the two";
    }
}

impl Uncertain {
    /// The value that a case has of its key, if it has one alone with a number: otherwise the input is a factor.
    pub fn value_in(&self, case: &Case) -> Option<f64> {
        let [wanted] = self.keys.as_slice() else {
            return None;
        };
        let values = case.values();
        let by_index = values.iter().find(|(path, ..)| path == wanted);
        let value = match by_index {
            Some((.., value)) => value.clone(),
            None => case.values_by_name().remove(wanted)?,
        };
        value.as_float()
    }

    /// Whether its distribution lies about the value of the case.
    pub fn takes_mean_of_case(&self) -> bool {
        self.mean.is_none() && self.variation.is_some()
    }

    /// Its distribution where `usual` is its mean if it has none itself.
    ///
    /// # Errors
    /// What is wrong with it: a key and a sentence.
    pub fn distribution(&self, usual: f64) -> Result<Distribution, (&'static str, String)> {
        let mean = self.mean.unwrap_or(usual);
        let wrong = |key, what: &str| Err((key, what.to_owned()));
        if let (Some(low), Some(high)) = (self.low, self.high)
            && low >= high
        {
            return Err(("high", format!("it must be above low = {low:?}")));
        }
        let deviation = |variation: f64| variation * mean.abs();
        if self.variation.is_some() && mean == 0.0 {
            return wrong(
                "variation",
                "a variation is a share of the mean, which is 0: give a uniform distribution with low and high",
            );
        }
        let distribution = match (self.distribution, self.variation, self.low, self.high) {
            (DistributionKind::Uniform, None, Some(low), Some(high)) if self.mean.is_none() => {
                Distribution::uniform(low, high)
            }
            (DistributionKind::Uniform, Some(variation), None, None) => {
                let half = 3.0_f64.sqrt() * deviation(variation);
                Distribution::uniform(mean - half, mean + half)
            }
            (DistributionKind::Uniform, ..) => {
                return wrong(
                    "distribution",
                    "it needs either low and high, or variation (with a mean, if that is not the value of the case)",
                );
            }
            (_, None, ..) => return wrong("distribution", "it needs a variation, such as 0.1"),
            (DistributionKind::Normal, Some(variation), low, high) => {
                let bounds = [
                    low.unwrap_or(f64::NEG_INFINITY),
                    high.unwrap_or(f64::INFINITY),
                ];
                Distribution::normal(mean, deviation(variation), bounds)
            }
            (DistributionKind::Lognormal, Some(variation), low, high) => {
                if mean < 0.0 || low.is_some_and(|low| low < 0.0) {
                    return wrong(
                        "distribution",
                        "its values are above 0, and its mean and bounds must be: take normal, or change them",
                    );
                }
                let bounds = [low.unwrap_or(0.0), high.unwrap_or(f64::INFINITY)];
                Distribution::lognormal(mean, deviation(variation), bounds)
            }
        };
        if distribution.kept() < 1e-3 {
            let key = if self.low.is_some() { "low" } else { "high" };
            return Err((
                key,
                format!(
                    "the bounds leave less than a thousandth of the distribution with mean {mean:?}: move them towards it"
                ),
            ));
        }
        Ok(distribution)
    }

    /// Between which values samples are to be expected.
    pub(super) fn range(distribution: &Distribution) -> [f64; 2] {
        [TAIL, 1.0 - TAIL].map(|u| distribution.quantile(u))
    }
}

/// The inputs of a study; `usual` are their means where the tables have none.
///
/// # Errors
/// The index of the input (or of the correlation, if that is to blame) with the key and what is wrong.
pub fn inputs(
    uncertain: &[Uncertain],
    correlations: &[Correlation],
    usual: &[f64],
) -> Result<Inputs, String> {
    let distributions = (uncertain.iter().zip(usual))
        .map(|(input, &usual)| {
            let of_input = |(key, what)| format!("{}: {key}: {what}", input.name);
            input.distribution(usual).map_err(of_input)
        })
        .collect::<Result<_, _>>()?;
    let place = |name: &str| uncertain.iter().position(|input| input.name == name);
    let pairs = correlations.iter();
    let pairs: Vec<_> = pairs
        .filter_map(|c| Some((place(&c.first)?, place(&c.second)?, c.coefficient)))
        .collect();
    Inputs::new(distributions, &pairs).ok_or_else(|| NOT_DEFINITE.to_owned())
}

/// That no variables have such correlations.
pub(super) const NOT_DEFINITE: &str = "no inputs have all these correlations at once (their matrix is not positive definite): \
                                       make some of them smaller";
