//! Which settings of the acceleration a table compares.

use crate::case::{Case, SurrogateModel};
use crate::coupling::acceleration::AccelerationModel;
use crate::run::{CaseSelection, Failure};

/// Iterations that relaxation may take in a step, which the limit of a case is not made for.
const PATIENCE: usize = 500;

/// A model with its memory, with or without the surrogate: a row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// Acceleration model.
    pub kind: AccelerationModel,
    /// Number of steps that it remembers; 0 for models without memory.
    pub reuse: usize,
    /// Whether it is given the surrogate.
    pub surrogate: bool,
}

impl Variant {
    /// Every model, with memory of up to 40 steps for those that can have it, with and without the surrogate. Models
    /// that agree without memory are there once. The quick ones come first.
    fn all() -> Vec<Self> {
        use AccelerationModel::{Aitken, Constant, Hybrid, IqnLs, MultiVector};
        let models = [
            (IqnLs, 40),
            (IqnLs, 10),
            (IqnLs, 5),
            (IqnLs, 0),
            (MultiVector, 40),
            (MultiVector, 10),
            (Hybrid, 40),
            (Hybrid, 10),
            (Aitken, 0),
            (Constant, 0),
        ];
        let both = |(kind, reuse)| {
            [false, true].map(|surrogate| Self {
                kind,
                reuse,
                surrogate,
            })
        };
        models.into_iter().flat_map(both).collect()
    }

    /// Those of these names, in their order; all of them if there is no name.
    pub fn called(names: &[String]) -> Result<Vec<Self>, Failure> {
        let all = Self::all();
        if names.is_empty() {
            return Ok(all);
        }
        let find = |name: &String| {
            let found = all.iter().find(|variant| variant.name() == *name);
            found.copied().ok_or_else(|| {
                let names: Vec<_> = all.iter().map(|variant| variant.name()).collect();
                Failure::Input(format!(
                    "--only {name}: there is no such row; expected some of {}",
                    names.join(", ")
                ))
            })
        };
        names.iter().map(find).collect()
    }

    /// The name of its folder, and on the command line: `iqn_ls-10-surrogate`.
    pub fn name(self) -> String {
        let memory = if self.kind.remembers() {
            format!("-{}", self.reuse)
        } else {
            String::new()
        };
        let surrogate = if self.surrogate { "-surrogate" } else { "" };
        format!("{}{memory}{surrogate}", self.kind.name())
    }

    /// The arguments that make `case` a run with these settings.
    pub fn arguments(self, chosen: &CaseSelection, case: &Case) -> CaseSelection {
        let surrogate = match (self.surrogate, case.coupling.surrogate) {
            (false, _) => "none",
            (true, SurrogateModel::OpenTube) => "open_tube",
            (true, SurrogateModel::Potential) => "potential",
            (true, SurrogateModel::Tube | SurrogateModel::None) => "tube",
        };
        let patience = if self.kind.remembers() { 0 } else { PATIENCE };
        chosen
            .clone()
            .with("coupling.acceleration", self.kind.name())
            .with("coupling.reuse_steps", self.reuse)
            .with("coupling.surrogate", surrogate)
            .with(
                "coupling.max_iterations",
                case.coupling.max_iterations.max(patience),
            )
    }
}

#[cfg(test)]
mod tests {
    use super::Variant;

    #[test]
    fn every_row_has_a_name_of_its_own() {
        let mut names: Vec<_> = Variant::all().into_iter().map(Variant::name).collect();
        assert!(names.contains(&"iqn_ls-10-surrogate".to_owned()));
        assert!(names.contains(&"aitken".to_owned()));
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
