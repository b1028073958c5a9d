//! The defaults that are built into the program, with what they say of each value: `openfoam-case/defaults.toml`.

use fsi_numerics::words;
use std::collections::BTreeMap;
use std::sync::LazyLock;
use toml::Value;

/// The file.
pub const TEXT: &str = include_str!("openfoam-case/defaults.toml");
/// What messages call it.
pub const SHOWN_AS: &str = "built-in defaults.toml";

words! {
    /// Where a default value comes from.
    pub enum Origin {
        /// Stated in the paper.
        Paper = "paper",
        /// Ours, because the paper leaves it to sources that are not at hand.
        Assumed = "assumed",
        /// A setting of this program's method, without a counterpart in the paper.
        Ours = "ours",
    }
}

/// What the defaults say of a key.
#[derive(Debug, Clone, PartialEq)]
pub struct Explained {
    /// Its value; none if the key only stands in a comment, because it may be absent.
    pub value: Option<Value>,
    /// Where the value, or its absence, comes from.
    pub origin: Option<Origin>,
    /// The comment next to it, without origins.
    pub remark: String,
}

/// What the defaults say of each key, by path.
pub fn explained() -> &'static BTreeMap<String, Explained> {
    static EXPLAINED: LazyLock<BTreeMap<String, Explained>> = LazyLock::new(explain);
    &EXPLAINED
}

fn explain() -> BTreeMap<String, Explained> {
    let values: Value = toml::from_str(TEXT).expect("a test reads the defaults");
    let mut all = BTreeMap::new();
    for line in lines() {
        let mut names = line.path.split('.');
        let value = names.try_fold(&values, |table, name| table.get(name));
        let origin = origin(&line.remark).or(origin(&line.remark_of_table));
        let explained = Explained {
            value: value.cloned(),
            origin,
            remark: without_origins(&line.remark),
        };
        // A key in a comment is an example where there is a value as well.
        if value.is_none() || !line.is_example {
            all.insert(line.path, explained);
        }
    }
    all
}

/// A line of the defaults that gives a value to a key, or shows in a comment how to.
struct Line {
    path: String,
    is_example: bool,
    /// The line without its comment.
    #[cfg_attr(not(test), expect(dead_code, reason = "a test reads the examples"))]
    text: String,
    /// Number of the paragraph, where that shows whole tables.
    #[cfg_attr(not(test), expect(dead_code, reason = "a test reads the examples"))]
    paragraph: Option<usize>,
    remark: String,
    remark_of_table: String,
}

/// The lines of all keys outside the presets. A comment goes on in the lines below that hold nothing else and are
/// indented.
fn lines() -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    let (mut table, mut remark_of_table) = (String::new(), String::new());
    let mut example_of = None;
    let mut in_header = false;
    let mut paragraph = 0;
    for line in TEXT.lines() {
        if line.trim().is_empty() {
            paragraph += 1;
            example_of = None;
        }
        if let Some(more) = line
            .trim()
            .strip_prefix('#')
            .filter(|_| line.starts_with(' '))
        {
            let remark = match lines.last_mut().filter(|_| !in_header) {
                Some(last) => &mut last.remark,
                None => &mut remark_of_table,
            };
            *remark = format!("{remark} {}", more.trim());
            continue;
        }
        let (text, is_example) = match line.strip_prefix("# ") {
            Some(text) => (text, true),
            None => (line, false),
        };
        let (text, remark) = text.split_once(" #").unwrap_or((text, ""));
        let (text, remark) = (text.trim_end(), remark.trim().to_owned());
        // A list of tables is known by `[]`.
        let list = text
            .strip_prefix("[[")
            .and_then(|text| text.strip_suffix("]]"));
        let list = list.map(|name| format!("{name}[]"));
        let single = text
            .strip_prefix('[')
            .and_then(|text| text.strip_suffix(']'));
        if let Some(name) = list.or(single.map(str::to_owned)) {
            if name.starts_with("preset") {
                break;
            }
            if is_example {
                example_of = Some(name);
            } else {
                (table, remark_of_table) = (name, remark);
                in_header = true;
            }
            continue;
        }
        let is_name = |name: &str| name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if let Some((name, _)) = text.split_once(" = ").filter(|(name, _)| is_name(name)) {
            let of = example_of.clone().filter(|_| is_example);
            in_header = false;
            lines.push(Line {
                path: format!("{}.{name}", of.as_ref().unwrap_or(&table)),
                is_example,
                text: text.to_owned(),
                paragraph: of.as_ref().map(|_| paragraph),
                remark,
                remark_of_table: of.map_or(remark_of_table.clone(), |_| String::new()),
            });
        }
    }
    lines
}

/// A comment without the origins that it names.
fn without_origins(remark: &str) -> String {
    let names = Origin::ALL.iter();
    let bare = names.fold(remark.to_owned(), |text, origin| {
        text.replace(&format!(" [{origin}]"), "")
            .replace(&format!("[{origin}]"), "")
    });
    bare.trim().to_owned()
}

/// The last of the origins that a comment names.
fn origin(remark: &str) -> Option<Origin> {
    let named = Origin::ALL.map(|origin| (remark.rfind(&format!("[{origin}]")), origin));
    let last = named.into_iter().filter(|(place, _)| place.is_some());
    last.max_by_key(|(place, _)| *place)
        .map(|(_, origin)| origin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Case, Preset, ProblemKind};
    use std::collections::BTreeSet;
    use std::fmt::Write as _;

    /// Every key of the types stands in the defaults, as a value or as an example, and nothing else does.
    #[test]
    fn the_defaults_name_every_key_and_no_other() {
        let lines = lines();
        let named: BTreeSet<_> = lines.iter().map(|line| line.path.as_str()).collect();
        for path in &named {
            assert!(
                Case::schema().find(path).is_some(),
                "no key is called {path}"
            );
        }
        for key in Case::schema().keys() {
            // A material's parameter need not be shown in each of the tables that can have it.
            let elsewhere = |path: &&&str| {
                !key.choices.is_empty() && path.rsplit('.').next() == Some(key.name())
            };
            let shown = named.contains(key.path.as_str()) || named.iter().any(|p| elsewhere(&p));
            assert!(shown, "defaults.toml lacks {}", key.path);
            let has_value = explained()
                .get(&key.path)
                .is_some_and(|e| e.value.is_some());
            let needed = key.absent.is_none()
                && key.choices.is_empty()
                && Case::schema().optional_tables(&key.path).next().is_none()
                && (key.problems.is_empty() || key.problems.contains(&ProblemKind::Anastomosis));
            assert!(
                has_value || !needed,
                "defaults.toml gives no value to {}",
                key.path
            );
        }
    }

    /// What stands in comments is no less valid than the rest: keys together, and each paragraph of tables by itself.
    #[test]
    fn the_examples_in_comments_can_be_used() {
        // A run that ends when it is periodic has no window of its own: one of the two is left out. The surface of a
        // lumen must fit to its lines, and an end that is left out has no opening: tests of such trees have some. Blood
        // that flows from the beginning has no ramp, as the defaults have.
        let is_left_out = |path: &str| {
            let paths = [
                "time.until_periodic",
                "tree.leave_out",
                "initial.steps_before",
            ];
            paths.contains(&path) || path.starts_with("tree.lumen")
        };
        let is_used = |line: &Line| line.is_example && !is_left_out(&line.path);
        let mut examples: Vec<_> = lines().into_iter().filter(is_used).collect();
        examples.sort_by(|a, b| parent(&a.path).cmp(parent(&b.path)));
        let paragraphs: BTreeSet<_> = examples.iter().map(|line| line.paragraph).collect();
        let (mut flags, mut vessels, mut own, mut probes) = (0, 0, 0, 0);
        for paragraph in paragraphs {
            let lines = examples.iter().filter(|line| line.paragraph == paragraph);
            let case = load(lines);
            own += usize::from(case.own().is_some());
            flags += usize::from(case.vessel().is_none() && case.own().is_none());
            vessels += usize::from(case.vessel().is_some() && case.anastomosis().is_none());
            probes += case.output.probes.len();
        }
        assert_eq!((flags, vessels, own, probes), (1, 6, 8, 1));
    }

    fn load<'a>(lines: impl Iterator<Item = &'a Line>) -> Case {
        let folder = tempfile::tempdir().unwrap();
        let mut text = String::from("extends = \"defaults\"\n");
        let (mut table, mut seen) = ("", BTreeSet::new());
        for line in lines {
            // A key that is there already begins the next table of a list.
            if table != parent(&line.path) || !seen.insert(&line.path) {
                table = parent(&line.path);
                seen = BTreeSet::from([&line.path]);
                let _ = match table.strip_suffix("[]") {
                    Some(list) => writeln!(text, "[[{list}]]"),
                    None => writeln!(text, "[{table}]"),
                };
            }
            let _ = writeln!(text, "{}", line.text);
        }
        std::fs::write(folder.path().join("case.toml"), &text).unwrap();
        let curve = "t,value\n0,60\n0.3,300\n0.6,60\n0.8,60\n";
        for name in ["flow.csv", "pressure.csv"] {
            std::fs::write(folder.path().join(name), curve).unwrap();
        }
        let measured = "series,quantity,x_m,y_m,z_m,value\na,speed_m_s,0,0,0,1\n";
        std::fs::write(folder.path().join("experiment.csv"), measured).unwrap();
        let line = "x,y,z,r\n0,0,0,3\n20,0,0,3\n40,5,0,2.5\n";
        std::fs::write(folder.path().join("line.csv"), line).unwrap();
        let system = folder.path().join("my-case/system");
        std::fs::create_dir_all(&system).unwrap();
        for file in [
            system.join("controlDict"),
            folder.path().join("factors.csv"),
            folder.path().join("motion.csv"),
            folder.path().join("factor.csv"),
            folder.path().join("wall.msh"),
        ] {
            std::fs::write(file, "").unwrap();
        }
        let examples =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/vessels");
        let put = |from: &str, to: &str| {
            std::fs::copy(examples.join(from), folder.path().join(to)).unwrap()
        };
        put("carotid/lines.vtp", "lines.vtp");
        put("../trees/carotid/lines.vtp", "tree.vtp");
        put("../trees/y/trunk.csv", "common.csv");
        put("../trees/y/left.csv", "internal.csv");
        put("../trees/y/right.csv", "external.csv");
        put("surface/lumen.stl", "lumen.stl");
        put("surface/centre-line.csv", "middle.csv");
        let case = Case::load(folder.path(), Preset::Paper, &[]);
        case.unwrap_or_else(|errors| panic!("{errors}\n{text}"))
            .case
    }

    fn parent(path: &str) -> &str {
        path.rsplit_once('.').unwrap().0
    }

    /// Every default says where it comes from.
    #[test]
    fn every_default_has_an_origin() {
        for (path, explained) in explained() {
            let known = explained.value.is_none() || explained.origin.is_some();
            assert!(known, "defaults.toml does not say where {path} comes from");
        }
        let origin = |path: &str| explained()[path].origin;
        assert_eq!(origin("time.step_s"), Some(Origin::Paper));
        assert_eq!(origin("geometry.blend_length_m"), Some(Origin::Assumed));
        assert_eq!(origin("wall.media.mu_Pa"), Some(Origin::Paper)); // by its table
        assert_eq!(origin("coupling.e_rel"), Some(Origin::Ours)); // by its table
        assert_eq!(origin("inflow.base_m3_s"), Some(Origin::Assumed)); // by the second line of its table
    }
}
