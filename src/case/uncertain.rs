//! What of a case is not known exactly: the tables `[[uncertain]]` and `[[correlation]]`.

use super::Case;
use super::schema::{ValueKind, above, from};
use super::value::split_index;
use crate::uncertainty::{Distribution, Inputs};
use crate::{table, words};
use toml::Value;

/// Most characters of its name.
pub(super) const MOST_LETTERS: usize = 30;
/// Most keys of an input.
const MOST_KEYS: usize = 50;
/// Any number that a key has.
const ANY: ValueKind = from(-1e15, 1e15);
/// Where a standard normal input is cut off, in standard deviations.
const FAR: f64 = 3.0;
/// What of a normal distribution is left out where its range is told: samples beyond are not to be expected.
const TAIL: f64 = 1e-6;

table! {
    /// An input of a study that is not known exactly.
    pub struct Uncertain {
        name: String = "name", ValueKind::Text(MOST_LETTERS), "name of the input in tables and figures";
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
        /// Normal with the mean 0 and the standard deviation 1, cut off at -3 and 3 without bounds. Each number of a
        /// list is an input of its own.
        StandardNormal = "standard_normal",
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
        value_of(case, wanted)?.as_float()
    }

    /// The inputs that it stands for: one for each number of a list that is standard normal, otherwise itself.
    pub fn spread(&self, case: &Case) -> Vec<Self> {
        let list = match (self.distribution, self.keys.as_slice()) {
            (DistributionKind::StandardNormal, [key]) => value_of(case, key),
            _ => None,
        };
        let Some(numbers) = list.as_ref().and_then(Value::as_array) else {
            return vec![self.clone()];
        };
        let input = |i: usize| Self {
            name: format!("{} {}", self.name, i + 1),
            keys: vec![format!("{}[{i}]", self.keys[0])],
            ..self.clone()
        };
        (0..numbers.len()).map(input).collect()
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
        let is_standard = self.distribution == DistributionKind::StandardNormal;
        if self.variation.is_some() && mean == 0.0 && !is_standard {
            return wrong(
                "variation",
                "a variation is a share of the mean, which is 0: give a uniform distribution with low and high",
            );
        }
        let distribution = self.about(mean)?;
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

    /// Its distribution with this mean, whatever the bounds leave of it.
    fn about(&self, mean: f64) -> Result<Distribution, (&'static str, String)> {
        let wrong = |key, what: &str| Err((key, what.to_owned()));
        let deviation = |variation: f64| variation * mean.abs();
        Ok(
            match (self.distribution, self.variation, self.low, self.high) {
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
                (DistributionKind::StandardNormal, None, low, high) if self.mean.is_none() => {
                    let bounds = [low.unwrap_or(-FAR), high.unwrap_or(FAR)];
                    Distribution::normal(0.0, 1.0, bounds)
                }
                (DistributionKind::StandardNormal, ..) => {
                    return wrong(
                        "distribution",
                        "its mean is 0 and its standard deviation 1: leave out mean and variation, or take normal",
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
            },
        )
    }

    /// Between which values samples are to be expected.
    pub(super) fn range(distribution: &Distribution) -> [f64; 2] {
        [TAIL, 1.0 - TAIL].map(|u| distribution.quantile(u))
    }
}

/// The value of a key, which may have the index or the name of a table of a list, and the index of a number.
pub(super) fn value_of(case: &Case, wanted: &str) -> Option<Value> {
    let whole = |wanted: &str| {
        let values = case.values();
        let by_index = values.iter().find(|(path, ..)| path == wanted);
        match by_index {
            Some((.., value)) => Some(value.clone()),
            None => case.values_by_name().remove(wanted),
        }
    };
    whole(wanted).or_else(|| {
        let (list, index) = split_index(wanted)?;
        whole(list)?.as_array()?.get(index).cloned()
    })
}

impl Case {
    /// Each number of a list that is standard normal becomes an input of its own.
    pub(super) fn spread_inputs(&mut self) {
        if let Some(tables) = self.uncertain.take() {
            let inputs = tables.iter().flat_map(|input| input.spread(self));
            self.uncertain = Some(inputs.collect());
        }
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
