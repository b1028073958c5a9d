//! Files that import each other in a circle: how many there are, and that each stays inside one room.

use crate::architecture::sources;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The keys of a case and the types that they make know each other.
const ALLOWED: usize = 1;

/// A module: the names of its path below the crate.
type Module = Vec<String>;

fn names(path: &str) -> Module {
    path.split("::").map(str::to_owned).collect()
}

/// The code of a file, without comments, texts and the tests at its end.
fn code(source: &str) -> String {
    let source = source.replace("\\\"", "").replace("'\"'", "");
    let lines = source.lines().map(|line| {
        let mut comments = line.match_indices("//").map(|(at, _)| at);
        let begin = comments.find(|at| line[..*at].matches('"').count() % 2 == 0);
        &line[..begin.unwrap_or(line.len())]
    });
    let text = lines.collect::<Vec<_>>().join("\n");
    let end = text.find("#[cfg(test)]\nmod ").unwrap_or(text.len());
    text[..end].split('"').step_by(2).collect()
}

/// The paths of a `use` of this tree, each with the name by which it is known.
fn imported(before: &str, tree: &str, all: &mut Vec<(Module, String)>) {
    let tree = tree.trim();
    if let Some((path, group)) = tree.split_once('{') {
        let group = group.trim_end().trim_end_matches('}');
        let (mut depth, mut start) = (0, 0);
        for (i, c) in group.char_indices().chain([(group.len(), ',')]) {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    imported(&format!("{before}{path}"), &group[start..i], all);
                    start = i + 1;
                }
                _ => {}
            }
        }
    } else if !tree.is_empty() {
        let (path, alias) = tree.split_once(" as ").unwrap_or((tree, ""));
        let path = format!("{before}{path}");
        let path = names(path.trim_end_matches("::self"));
        let name = if alias.is_empty() {
            path.last().unwrap()
        } else {
            alias
        };
        all.push((path.clone(), name.to_owned()));
    }
}

/// The crate's modules, with what each imports and what it hands on.
struct Modules {
    code: BTreeMap<Module, String>,
    imports: BTreeMap<Module, Vec<Module>>,
    exports: BTreeMap<Module, Vec<(Module, String)>>,
}

impl Modules {
    fn of(root: &Path) -> Self {
        let is_own = |path: &Path| {
            let crates = path.ancestors().take_while(|at| *at != root);
            let within = path.strip_prefix(root).unwrap();
            !["tests", "examples", "benches"]
                .iter()
                .any(|name| within.starts_with(name))
                && !crates.skip(1).any(|at| at.join("Cargo.toml").is_file())
        };
        let files = sources(root).into_iter().filter(|path| is_own(path));
        let code = files.map(|path| {
            let below = path.strip_prefix(root).unwrap().with_extension("");
            let names = below.iter().map(|name| name.to_str().unwrap().to_owned());
            let module = names.filter(|name| !["mod", "lib", "main"].contains(&name.as_str()));
            (
                module.collect(),
                code(&std::fs::read_to_string(&path).unwrap()),
            )
        });
        let mut modules = Self {
            code: code.collect(),
            imports: BTreeMap::new(),
            exports: BTreeMap::new(),
        };
        for module in modules.code.keys().cloned().collect::<Vec<_>>() {
            let (imports, exports) = modules.read(&module);
            modules.imports.insert(module.clone(), imports);
            modules.exports.insert(module, exports);
        }
        modules
    }

    /// What a module imports, by `use` or by a path in its code, and what it hands on.
    fn read(&self, module: &Module) -> (Vec<Module>, Vec<(Module, String)>) {
        let (mut imports, mut exports, mut rest) = (Vec::new(), Vec::new(), String::new());
        let mut text = self.code[module].as_str();
        while let Some(at) = text.find("use ") {
            let line = text[..at].rfind('\n').map_or(0, |i| i + 1);
            let visibility = text[line..at].trim();
            let is_use = visibility.is_empty() || visibility.starts_with("pub");
            let end = at + text[at..].find(';').unwrap_or(text.len() - at);
            if is_use {
                rest += &text[..line];
                let mut all = Vec::new();
                imported("", &text[at + 4..end], &mut all);
                for (path, name) in all {
                    if let Some(path) = self.absolute(module, &path) {
                        match visibility.is_empty() {
                            true => imports.push(path),
                            false => exports.push((path, name)),
                        }
                    }
                }
                text = &text[end..];
            } else {
                rest += &text[..at + 4];
                text = &text[at + 4..];
            }
        }
        rest += text;
        let words = rest.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
        let paths = words.filter(|word| word.contains("::"));
        imports
            .extend(paths.filter_map(|path| self.absolute(module, &names(path.trim_matches(':')))));
        (imports, exports)
    }

    /// A path that begins in this crate, from its root.
    fn absolute(&self, module: &Module, path: &Module) -> Option<Module> {
        let climbs = path.iter().take_while(|name| *name == "super").count();
        let below = |from: &[String], path: &[String]| [from, path].concat();
        match path[0].as_str() {
            "crate" => Some(path[1..].to_vec()),
            "self" => Some(below(module, &path[1..])),
            "super" => Some(below(
                &module[..module.len().checked_sub(climbs)?],
                &path[climbs..],
            )),
            first => {
                let child = below(module, &[first.to_owned()]);
                self.code.contains_key(&child).then(|| below(module, path))
            }
        }
    }

    /// The module in which what a path names is defined.
    fn home(&self, path: &[String], patience: usize) -> Module {
        let mut module = path.to_vec();
        while !self.code.contains_key(&module) {
            module.pop();
        }
        let Some(name) = path.get(module.len()).filter(|_| patience > 0) else {
            return module;
        };
        let defines = |module: &Module| {
            let kinds = ["struct", "enum", "fn", "const", "type", "trait", "static"];
            kinds.iter().any(|kind| {
                let found = self.code[module].split(&format!("{kind} {name}")).nth(1);
                found.is_some_and(|rest| {
                    !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_')
                })
            })
        };
        for (path, export) in &self.exports[&module] {
            let whole = path[..path.len() - 1].to_vec();
            if export == name {
                return self.home(path, patience - 1);
            }
            if export == "*" && self.code.contains_key(&whole) && defines(&whole) {
                return whole;
            }
        }
        module
    }

    /// Whom each module imports, but for what lies around it: a file and its folder are one thing.
    fn arrows(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        let arrows = self.imports.iter().map(|(from, imports)| {
            let to = imports.iter().map(|path| self.home(path, 9));
            (
                from.clone(),
                to.filter(|to| !from.starts_with(to)).collect(),
            )
        });
        arrows.collect()
    }
}

/// The files that a file reaches by imports.
fn reached(arrows: &BTreeMap<Module, BTreeSet<Module>>, from: &Module) -> BTreeSet<Module> {
    let (mut seen, mut next) = (BTreeSet::new(), vec![from]);
    while let Some(at) = next.pop() {
        for to in arrows.get(at).into_iter().flatten() {
            if seen.insert(to.clone()) {
                next.push(to);
            }
        }
    }
    seen
}

fn circles(root: &Path) -> Vec<Vec<Module>> {
    let arrows = Modules::of(root).arrows();
    let reach: BTreeMap<&Module, _> = arrows.keys().map(|at| (at, reached(&arrows, at))).collect();
    let mut found: BTreeSet<Vec<Module>> = BTreeSet::new();
    for (at, seen) in reach.iter().filter(|(at, seen)| seen.contains(**at)) {
        let back = seen.iter().filter(|to| reach[to].contains(*at));
        found.insert(back.cloned().collect());
    }
    found.into_iter().collect()
}

#[test]
fn files_import_each_other_in_few_circles() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut all = circles(&src);
    for circle in &all {
        let rooms: BTreeSet<_> = circle.iter().map(|module| module.first()).collect();
        assert_eq!(rooms.len(), 1, "a circle through several rooms: {circle:?}");
    }
    for room in [
        "numerics",
        "coupling_core",
        "pfem",
        "spectral",
        "data",
        "case",
    ] {
        all.extend(circles(&src.join(room)));
    }
    let told = |circle: &Vec<Module>| {
        let files = circle.iter().map(|module| module.join("/"));
        files.collect::<Vec<_>>().join(", ")
    };
    let told: Vec<String> = all.iter().map(told).collect();
    assert!(
        all.len() <= ALLOWED,
        "circles of files:\n{}",
        told.join("\n")
    );
}

/// Two files that import each other, one through a name that the folder hands on.
#[test]
fn a_circle_is_seen_through_what_a_folder_hands_on() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("lib.rs", "mod a;\nmod b;\npub use a::One;\npub use b::*;\n");
    write("a.rs", "use crate::{Three, Two};\npub struct One(Two);\n");
    write(
        "b.rs",
        "pub struct Two;\n// crate::One\nfn say() { \"crate::One\"; }\n",
    );
    assert_eq!(circles(folder.path()), Vec::<Vec<Module>>::new());
    write("b.rs", "pub struct Two;\nfn f() { crate::One::new() }\n");
    assert_eq!(circles(folder.path()), [[names("a"), names("b")]]);
}
