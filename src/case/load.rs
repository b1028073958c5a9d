//! From files, preset and command line to a checked [`Case`]: layers of values, the last one wins.

mod unread;

use super::error::{CaseError, CaseErrors, ValuePlace};
use super::schema::Schema;
use super::source::{self, Base, CaseValue, Source};
use super::stack::Stack;
use super::{Case, Solver, check, defaults, relative, spelling, value};
use crate::words;
use std::collections::BTreeMap;
use std::ops::Deref;
use std::path::Path;
use std::sync::LazyLock;
pub use unread::Unread;

words! {
    /// Resolution and length of a run, with everything else unchanged.
    #[derive(Default, clap::ValueEnum)]
    pub enum Preset {
        /// About 5000 fluid cells and a short time: to see that everything runs.
        Demo = "demo",
        /// About 10,000 fluid cells, three beats.
        Coarse = "coarse",
        /// The meshes of coarse in fewer steps: of second order in time, until two beats agree.
        Fast = "fast",
        /// 30,000 fluid cells, the structure at the order and mesh of the paper's study, three beats.
        Paper = "paper" (default),
    }
}

/// A checked case that remembers where each value came from. Use it like a [`Case`].
#[derive(Debug, Clone, PartialEq)]
pub struct ResolvedCase {
    /// The values.
    pub case: Case,
    /// Where each value was written, by dotted path.
    pub origins: BTreeMap<String, ValuePlace>,
    /// What the user has written and this case does not read.
    pub unread: Vec<Unread>,
    /// What the user has written and was fitted to something else, a sentence each.
    pub adjusted: Vec<String>,
}

impl ResolvedCase {
    /// A mistake in the value of `key` that only shows when the case is built.
    pub fn mistake(&self, key: &str, message: String) -> CaseError {
        let values = self.case.values();
        let found = values.iter().find(|(path, ..)| path == key);
        // A list of tables has no line of its own, but its first key has.
        let is_within = |(path, _): &(&String, &ValuePlace)| {
            path.strip_prefix(key)
                .is_some_and(|rest| rest.starts_with(['[', '.']))
        };
        let place = self.origins.get(key);
        let place = place.or_else(|| self.origins.iter().find(is_within).map(|(_, place)| place));
        if let (Some(place), None) = (place, found) {
            return CaseError::Whole(format!("{}: `{key}`: {message}", place.told()));
        }
        if place.is_none() && found.is_none() {
            return CaseError::Whole(format!("`{key}`, which is not given: {message}"));
        }
        CaseError::Nonsense {
            place: place.cloned().unwrap_or(ValuePlace::Absent),
            key: key.to_owned(),
            found: found.map_or("(not given)".into(), |(.., value)| value::shorten(value)),
            message,
        }
    }

    /// Whether the value of `key` is that of the defaults in the program.
    pub fn is_built_in(&self, key: &str) -> bool {
        self.origins.get(key).is_none_or(ValuePlace::is_built_in)
    }

    /// As [`Case::warnings`], and what was adjusted.
    pub fn warnings(&self, cores: usize) -> Vec<String> {
        let adjusted = self.adjusted.iter().cloned();
        adjusted.chain(self.case.warnings(cores)).collect()
    }

    /// The key to blame where `key` is: that which the case gives in its place.
    pub fn given<'a>(&self, key: &'a str) -> &'a str {
        match key {
            "tree.lines" if !self.origins.contains_key(key) => "tree.line",
            "tree.lumen" if !self.origins.contains_key(key) => "tree.lumen_triangles",
            key => key,
        }
    }

    /// The key to blame for a point of `key`: that of the file with what was measured, if that alone gives points.
    pub fn key_of_points(&self, key: &'static str) -> &'static str {
        const MEASURED: &str = "output.measured";
        match !self.origins.contains_key(key) && self.origins.contains_key(MEASURED) {
            true => MEASURED,
            false => key,
        }
    }
}

impl Deref for ResolvedCase {
    type Target = Case;

    fn deref(&self) -> &Case {
        &self.case
    }
}

/// A value of the command line, which replaces that of the files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    /// The option that gives it.
    pub place: ValuePlace,
    /// Dotted key.
    pub key: String,
    /// The value in TOML; a bare word is a string.
    pub value: String,
}

/// Files that extend one another, at most.
const MAX_DEPTH: usize = 10;

impl Case {
    /// All keys of a case.
    pub fn schema() -> &'static Schema {
        static SCHEMA: LazyLock<Schema> = LazyLock::new(|| {
            let schema = Schema::of::<Case>().with_defaults();
            schema.in_the_order_of(defaults::TEXT)
        });
        &SCHEMA
    }

    /// Reads and checks the case in the folder `dir` (or a file of any name): the file that its `extends` names, the
    /// preset, its own values, then `overrides` (pairs of a dotted key and a value in TOML; a bare word is a string).
    ///
    /// # Errors
    /// All mistakes at once, each with file, line, key, what was found and what is allowed.
    pub fn load(
        dir: &Path,
        preset: Preset,
        overrides: &[(String, String)],
    ) -> Result<ResolvedCase, CaseErrors> {
        let set = |(key, value): &(String, String)| Override {
            place: ValuePlace::Set,
            key: key.clone(),
            value: value.clone(),
        };
        let overrides: Vec<Override> = overrides.iter().map(set).collect();
        Self::load_with(dir, preset, &overrides)
    }

    /// As [`Case::load`], with overrides that know the option they come from.
    ///
    /// # Errors
    /// As [`Case::load`]; also a key that is given twice.
    pub fn load_with(
        dir: &Path,
        preset: Preset,
        overrides: &[Override],
    ) -> Result<ResolvedCase, CaseErrors> {
        let file = if dir.is_file() {
            dir.to_owned()
        } else {
            dir.join("case.toml")
        };
        let mut errors = Vec::new();
        let mut layers = Vec::new();
        let mut others = Vec::new();
        let sources = chain(&file, &mut errors);
        let extends = sources.len() > 1;
        for source in sources {
            layers.push(source.plain);
            let (chosen, unchosen) = presets(source.presets, preset, &mut errors);
            layers.push(chosen);
            others.extend(unchosen);
        }
        let given = overrides
            .iter()
            .map(|given| source::read_option(given.place.clone(), &given.key, &given.value));
        let given: Vec<CaseValue> = given.flat_map(source::split_tables).collect();
        refuse_repeated(&given, &mut errors);
        let readable = errors.is_empty();

        let mut stack = Stack::new(
            Case::schema(),
            source::tables(layers.iter().flatten().chain(&given)),
        );
        // Mistakes in presets that are not asked for are mistakes too.
        for entry in others {
            stack.check(entry, &mut errors);
        }
        for layer in layers {
            stack.lay(layer, &mut errors);
        }
        let given = relative::resolve(given, &stack, &mut errors);
        stack.lay(given, &mut errors);
        stack.sort_out_kinds(&mut errors);
        stack.sort_out_choices(&mut errors);
        if readable {
            stack.require_all(&file, &mut errors);
        }
        if let Some(mut case) = stack.build::<Case>(&file, &mut errors) {
            let has_own = !case.fluid.command.is_empty() || case.fluid.is_awaited;
            if has_own && stack.entry("fluid.solver").is_none() {
                case.fluid.solver = Solver::External;
            }
            let adjusted = case.fit_times(&stack);
            case.fill_amplitudes();
            case.read_files(&stack, &mut errors);
            check::check(&case, &stack, &mut errors);
            if errors.is_empty() && case.read_lumen(&stack, &mut errors) {
                check::check(&case, &stack, &mut errors);
            }
            if errors.is_empty() {
                case.forget_files();
                case.spread_inputs();
                let origins = stack.places();
                let mut case = ResolvedCase {
                    case,
                    origins,
                    unread: Vec::new(),
                    adjusted,
                };
                case.find_unread(&file, extends);
                return Ok(case);
            }
        }
        Err(CaseErrors(errors))
    }
}

/// The file and those it stands on, the lowest first.
fn chain(file: &Path, errors: &mut Vec<CaseError>) -> Vec<Source> {
    let mut sources: Vec<Source> = Vec::new();
    let mut next = Some((Base::File(file.to_owned()), None));
    while let Some((base, named_by)) = next {
        let Base::File(path) = base else {
            sources.push(source::read_defaults(errors));
            break;
        };
        let advice = match &named_by {
            Some(place) => format!(
                "`extends` in {place} must name a file, relative to its own, or be \"defaults\""
            ),
            None => "a case is a folder with a `case.toml`".to_owned(),
        };
        let source = source::read(&path, &advice, errors);
        next = source
            .extends
            .as_ref()
            .map(|(base, place)| (base.clone(), Some(place.clone())));
        if sources.len() == MAX_DEPTH {
            let reason = format!(
                "more than {MAX_DEPTH} files extend one another by `extends`: is it a cycle?"
            );
            errors.push(CaseError::Unreadable { path, reason });
            break;
        }
        sources.push(source);
    }
    sources.reverse();
    sources
}

/// Values of the chosen preset, and of the others.
fn presets(
    found: Vec<(String, CaseValue)>,
    chosen: Preset,
    errors: &mut Vec<CaseError>,
) -> (Vec<CaseValue>, Vec<CaseValue>) {
    let names = Preset::ALL.map(Preset::name);
    let mut values = (Vec::new(), Vec::new());
    for (name, entry) in found {
        if !names.contains(&name.as_str()) {
            errors.push(CaseError::UnknownKey {
                place: entry.place,
                suggestions: spelling::closest(&name, names)
                    .map(|near| format!("preset.{near}"))
                    .into_iter()
                    .collect(),
                key: format!("preset.{name}"),
            });
        } else if name == chosen.name() {
            values.0.push(entry);
        } else {
            values.1.push(entry);
        }
    }
    values
}

/// Of two values for a key nobody knows which one is meant.
fn refuse_repeated(given: &[CaseValue], errors: &mut Vec<CaseError>) {
    let mut seen: BTreeMap<&str, &CaseValue> = BTreeMap::new();
    for entry in given
        .iter()
        .filter(|entry| entry.place != ValuePlace::Command)
    {
        if let Some(first) = seen.insert(&entry.key, entry) {
            let shown = |entry: &CaseValue| (entry.place.clone(), value::shorten(&entry.value));
            errors.push(CaseError::Repeated {
                key: entry.key.clone(),
                first: shown(first),
                second: shown(entry),
            });
        }
    }
}
