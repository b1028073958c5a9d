//! What a case is about: one of a few kinds, each with keys that no other has.
//!
//! In a file the keys of every kind stand at the root beside those that all cases have; which kind it is shows in the
//! table that only that kind has, and is the paper's vessel where there is none. In the types the keys of a kind are in its
//! variant of [`Problem`] and nowhere else. A further kind is a variant here, a word of [`ProblemKind`] with the table that
//! shows it, and an arm of the few `match`es that the compiler then asks for.

use super::schema::{Schema, Table};
use super::stack::insert;
use super::table::words;
use super::{Anastomosis, Case, Flag};
use serde::{Deserialize, Serialize};
use toml::Value;

/// What a case is about, with the keys of that alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(clippy::large_enum_variant, reason = "there is one of them in a run")]
pub enum Problem {
    /// The paper's vessel, with blood that flows through.
    Anastomosis(Anastomosis),
    /// A flag in a channel.
    Flag(Flag),
}

words! {
    /// The kinds of [`Problem`].
    pub enum ProblemKind {
        /// A graft and an artery, end to end.
        Anastomosis = "anastomosis",
        /// A flag in a channel.
        Flag = "flag",
    }
}

impl ProblemKind {
    /// The table by which a file shows that it is of this kind; none for the kind that it is without such a table.
    pub fn table(self) -> Option<&'static str> {
        match self {
            Self::Anastomosis => None,
            Self::Flag => Some("flag"),
        }
    }

    /// Whose table is mentioned among those at the root of files.
    pub(super) fn of<'a>(tables: impl IntoIterator<Item = &'a String>) -> Self {
        let shown = |table: &String| {
            let mut kinds = Self::ALL.into_iter();
            kinds.find(|kind| kind.table() == Some(table))
        };
        tables
            .into_iter()
            .find_map(shown)
            .unwrap_or(Self::Anastomosis)
    }

    /// Where the value of one of its keys lies within a [`Case`].
    pub(super) fn place(self, path: &str) -> String {
        match self {
            Self::Anastomosis => format!("problem.anastomosis.{path}"),
            Self::Flag => format!("problem.{path}"),
        }
    }
}

impl Table for Problem {
    fn describe(_: &str, schema: &mut Schema) {
        schema.of_problem(ProblemKind::Anastomosis, |schema| {
            Anastomosis::describe("", schema);
        });
        schema.of_problem(ProblemKind::Flag, |schema| Flag::describe("flag", schema));
    }
}

impl Case {
    /// The vessel, if the case is about one.
    pub fn anastomosis(&self) -> Option<&Anastomosis> {
        match &self.problem {
            Problem::Anastomosis(vessel) => Some(vessel),
            Problem::Flag(_) => None,
        }
    }
}

/// The values of a file, with those of its kind where the types have them; those of other kinds are left out.
pub(super) fn arranged(file: &toml::Table) -> toml::Table {
    let kind = ProblemKind::of(file.keys());
    let mut root = toml::Table::new();
    visit(file, "", &mut |path, value| {
        let place = match Case::schema().find(path).and_then(|key| key.problem) {
            Some(other) if other != kind => return,
            Some(kind) => kind.place(path),
            None => path.to_owned(),
        };
        insert(&mut root, &place, value.clone());
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
