//! What a case is about: one of a few kinds, each with keys that no other has.
//!
//! In a file the keys of every kind stand at the root next to those that all cases have; which kind it is shows in the
//! table (or key) that only that kind has, and is the paper's vessel where there is none. In the types the keys of a
//! kind are in its variant of [`Problem`] and nowhere else. A further kind is a variant here, a word of [`ProblemKind`]
//! with the table that shows it, and an arm of the few `match`es that the compiler then asks for.

use super::error::CaseError;
use super::measured::{MOST_POINTS, MeasuredSeries, Measurements, Recorder};
use super::schema::{KeyTable, Schema};
use super::stack::{Stack, insert};
use super::value::shorten;
use super::{
    Anastomosis, BloodVessel, Case, Flag, Mistake, Output, OwnCase, Shape, TreeKeys,
    VesselDescription, WallMode,
};
use crate::files::{Fault, fault};
use crate::words;
use serde::{Deserialize, Serialize};
use std::path::Path;
use toml::Value;

/// What a case is about, with the keys of that alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Problem {
    /// A vessel with blood that flows through.
    Vessel(BloodVessel),
    /// A flag in a channel.
    Flag(Flag),
    /// An elastic wall on a mesh of any shape: a user-supplied OpenFOAM case, or a tree.
    #[serde(rename = "own")]
    UserCase(OwnCase),
}

words! {
    /// The kinds of [`Problem`], those of vessels by their [`Shape`](super::Shape).
    pub enum ProblemKind {
        /// A graft and an artery, end to end.
        Anastomosis = "anastomosis",
        /// A vessel along any path.
        Vessel = "vessel",
        /// A flag in a channel.
        Flag = "flag",
        /// An OpenFOAM case of your own with an elastic wall.
        UserCase = "own",
        /// A vessel that branches.
        Tree = "tree",
    }
}

impl ProblemKind {
    /// The table, or the key, by which a file shows that it is of this kind; none for the kind that it is without.
    pub fn mark(self) -> Option<&'static str> {
        match self {
            Self::Anastomosis => None,
            Self::Vessel => Some("vessel"),
            Self::Flag => Some("flag"),
            Self::UserCase => Some("fluid.case"),
            Self::Tree => Some("tree"),
        }
    }

    /// The same for a sentence.
    pub(super) fn shown(self) -> String {
        match self.mark() {
            None => "no table of its own".into(),
            Some(key) if key.contains('.') => format!("the key {key}"),
            Some(table) => format!("the table [{table}]"),
        }
    }

    /// Whose mark is mentioned among the tables at the root of files and all keys.
    pub(super) fn of<'a>(tables: impl IntoIterator<Item = &'a String>) -> Self {
        let shown = |table: &String| {
            let mut kinds = Self::ALL.into_iter();
            kinds.find(|kind| kind.mark() == Some(table))
        };
        tables
            .into_iter()
            .find_map(shown)
            .unwrap_or(Self::Anastomosis)
    }

    /// Where the value of a key that only these kinds have lies within a [`Case`].
    pub(super) fn place(kinds: &[Self], path: &str) -> String {
        match kinds {
            [] => path.to_owned(),
            [Self::Anastomosis] => format!("problem.vessel.shape.anastomosis.{path}"),
            // The table is called as the variant.
            [Self::Vessel] => format!("problem.vessel.shape.{path}"),
            [Self::Flag] => format!("problem.{path}"),
            [Self::UserCase, Self::Tree] => format!("problem.own.{path}"),
            _ => format!("problem.vessel.{path}"),
        }
    }
}

impl KeyTable for Problem {
    fn describe(_: &str, schema: &mut Schema) {
        use ProblemKind::{Anastomosis, Vessel};
        schema.of_problems(&[Anastomosis, Vessel], |schema| {
            BloodVessel::describe("", schema);
        });
        schema.of_problems(&[ProblemKind::Flag], |schema| {
            Flag::describe("flag", schema)
        });
        schema.of_problems(&[ProblemKind::UserCase, ProblemKind::Tree], |schema| {
            OwnCase::describe("", schema);
        });
    }
}

impl Case {
    /// The vessel, if the case is about one.
    pub fn vessel(&self) -> Option<&BloodVessel> {
        match &self.problem {
            Problem::Vessel(vessel) => Some(vessel),
            Problem::Flag(_) | Problem::UserCase(_) => None,
        }
    }

    /// The flag in a channel, if it has one.
    pub fn flag(&self) -> Option<&Flag> {
        match &self.problem {
            Problem::Flag(flag) => Some(flag),
            Problem::Vessel(_) | Problem::UserCase(_) => None,
        }
    }

    /// The wall on a mesh of any shape, if the case is about one.
    pub fn own(&self) -> Option<&OwnCase> {
        match &self.problem {
            Problem::UserCase(own) => Some(own),
            Problem::Vessel(_) | Problem::Flag(_) => None,
        }
    }

    /// The vessel that branches whose lumen the driver meshes, if the case is about one.
    pub fn tree(&self) -> Option<&TreeKeys> {
        self.own().and_then(OwnCase::meshed_tree)
    }

    /// Degree of the driver's own elements, if its shape can have some.
    pub fn native_degree(&self) -> Option<usize> {
        match &self.problem {
            Problem::Vessel(vessel) => Some(vessel.fluid.native.degree),
            Problem::Flag(_) => None,
            Problem::UserCase(_) => self.tree().map(|tree| tree.elements().degree()),
        }
    }

    /// Whether its fluid is a user-supplied OpenFOAM case.
    pub fn has_own_openfoam(&self) -> bool {
        self.own().is_some_and(|own| own.fluid.case.is_some())
    }

    /// Whether its wall is elastic.
    pub fn has_elastic_wall(&self) -> bool {
        match &self.problem {
            Problem::Vessel(vessel) => !vessel.is_rigid(),
            Problem::Flag(flag) => !flag.rigid,
            Problem::UserCase(own) => own.wall.mode() == WallMode::Elastic,
        }
    }

    /// The paper's vessel, if the case is about one.
    pub fn anastomosis(&self) -> Option<&Anastomosis> {
        self.vessel()?.anastomosis()
    }
}

impl Case {
    fn description(&mut self) -> Option<&mut VesselDescription> {
        match &mut self.problem {
            Problem::Vessel(BloodVessel {
                shape: Shape::Vessel(vessel),
                ..
            }) => Some(vessel),
            _ => None,
        }
    }

    /// Reads the files of the vessel's centre-line and of what was measured; their content then stands in the case.
    pub(super) fn read_files(&mut self, stack: &Stack, errors: &mut Vec<CaseError>) {
        if let Some(Err(mistake)) = self.description().map(VesselDescription::read_file) {
            errors.extend(refused(stack, mistake));
        }
        if let Problem::UserCase(own) = &mut self.problem
            && let Err(mistakes) = own.read_tree()
        {
            let refused = |(key, message): &Mistake| refused(stack, (key, message.clone()));
            errors.extend(mistakes.iter().filter_map(refused));
        }
        if let Some(Err(fault)) = self
            .output
            .measured
            .clone()
            .map(|path| self.output.record_where(&path))
        {
            errors.extend(refused(stack, ("output.measured", fault.to_string())));
        }
    }

    /// Reads the file of the lumen's surface once the centre-line is known to be one. Whether there was one.
    pub(super) fn read_lumen(&mut self, stack: &Stack, errors: &mut Vec<CaseError>) -> bool {
        let of_tree = match &mut self.problem {
            Problem::UserCase(own) => own.tree.as_mut().map(TreeKeys::read_lumen),
            _ => None,
        };
        let of_vessel = || self.description().map(VesselDescription::read_lumen);
        match of_tree.or_else(of_vessel) {
            Some(Err(mistake)) => {
                errors.extend(refused(stack, mistake));
                false
            }
            Some(Ok(has_surface)) => has_surface,
            None => false,
        }
    }

    /// Forgets the files whose content stands in the case, and how it was read from them.
    pub(super) fn forget_files(&mut self) {
        self.output.measured = None;
        if let Problem::UserCase(OwnCase {
            tree: Some(tree), ..
        }) = &mut self.problem
        {
            (tree.lines, tree.unit) = (None, None);
            (tree.least_radius, tree.junction_smoothing, tree.smoothing) = (None, None, None);
            tree.leave_out.clear();
            (tree.lumen, tree.lumen_unit, tree.lumen_smoothing) = (None, None, None);
        }
        if let Some(vessel) = self.description() {
            (vessel.centre_line, vessel.unit, vessel.branch) = (None, None, None);
            (vessel.is_reversed, vessel.smoothing, vessel.least_bend) = (None, None, None);
            (vessel.lumen, vessel.lumen_unit, vessel.lumen_smoothing) = (None, None, None);
        }
    }
}

impl Output {
    /// Adds the points of an experiment's file to those that are recorded.
    ///
    /// # Errors
    /// What is wrong with the file, in words.
    fn record_where(&mut self, path: &Path) -> Result<(), Fault> {
        let measured = Measurements::read(path)?;
        let has = |name: &str| (self.section.iter().flatten()).any(|section| section.name == name);
        let is_missing = |series: &&MeasuredSeries| {
            series.quantity.recorder() == Recorder::Section && !has(series.recorded_by())
        };
        if let Some(series) = measured.series.iter().find(is_missing) {
            return Err(fault!(
                "{}: `{}` is recorded by the cross-section {:?}, and the case has none; expected an [[output.section]] of this name",
                path.display(),
                series.name,
                series.recorded_by()
            ));
        }
        let kinds = [
            (&mut self.probes, Recorder::WallProbe),
            (&mut self.fluid_probes, Recorder::BloodProbe),
        ];
        for (probes, recorder) in kinds {
            for place in measured.places(recorder) {
                if !probes.contains(&place) {
                    probes.push(place);
                }
            }
            if probes.len() > MOST_POINTS {
                return Err(fault!(
                    "{}: with its points a run would record {} of one kind; expected {MOST_POINTS} at most",
                    path.display(),
                    probes.len()
                ));
            }
        }
        Ok(())
    }
}

/// A mistake that a file shows, at the key that names it.
fn refused(stack: &Stack, (key, message): (&str, String)) -> Option<CaseError> {
    stack.entry_within(key).map(|entry| CaseError::Nonsense {
        place: entry.place.clone(),
        key: entry.key.clone(),
        found: shorten(&entry.value),
        message,
    })
}

/// The values of a file, with those of its kind where the types have them; those of other kinds are left out.
pub(super) fn arranged(file: &toml::Table) -> toml::Table {
    let mut keys = Vec::new();
    visit(file, "", &mut |path, _| keys.push(path.to_owned()));
    let kind = ProblemKind::of(file.keys().chain(&keys));
    let mut root = toml::Table::new();
    visit(file, "", &mut |path, value| {
        // A list of tables is no key itself.
        match Case::schema().find(path) {
            Some(key) if key.is_foreign_to(kind) => {}
            _ => drop(insert(
                &mut root,
                &Case::schema().place(path),
                value.clone(),
            )),
        }
    });
    root
}

/// Shows `each` value of a table with its path.
fn visit(table: &toml::Table, above: &str, each: &mut dyn FnMut(&str, &Value)) {
    for (name, value) in table {
        let path = super::schema::join(above, name);
        match value {
            Value::Table(inner) => visit(inner, &path, each),
            value => each(&path, value),
        }
    }
}
