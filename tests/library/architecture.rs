//! The order of the rooms, as ARCHITECTURE.md declares it, against the source: no arrow runs against it, and so the
//! graph has no cycle.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Level of each room by the list in ARCHITECTURE.md: rooms on one line know nothing of each other.
fn declared() -> BTreeMap<String, usize> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    let (_, list) = text.split_once("```rooms\n").expect("a list of rooms");
    let (list, _) = list.split_once("```").unwrap();
    let levels = list.lines().enumerate();
    let rooms = levels.flat_map(|(level, line)| {
        let names = line.split('#').next().unwrap().split_whitespace();
        names.map(move |name| (name.to_owned(), level))
    });
    rooms.collect()
}

pub fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path());
    entries
        .flat_map(|path| match path.is_dir() {
            true => sources(&path),
            false => vec![path],
        })
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .collect()
}

/// Names of the crate's top level that a piece of source mentions: `crate::name`, those in `crate::{…}`, and
/// `super::super::name` where it climbs out of a module `depth` levels deep.
fn mentioned(source: &str, depth: usize) -> Vec<String> {
    let code: Vec<&str> = (source.lines())
        .map(|line| line.split("//").next().unwrap())
        .collect();
    let code = code.join("\n");
    let first = |text: &str| -> String {
        let name = text
            .chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_');
        name.collect()
    };
    let mut names = Vec::new();
    for after in code.split("crate::").skip(1) {
        match after.strip_prefix('{') {
            None => names.push(first(after)),
            Some(group) => {
                let mut nested = 0;
                let mut start = true;
                for (i, c) in group.char_indices() {
                    match c {
                        '}' if nested == 0 => break,
                        '{' => nested += 1,
                        '}' => nested -= 1,
                        ',' if nested == 0 => start = true,
                        c if start && !c.is_whitespace() => {
                            names.push(first(&group[i..]));
                            start = false;
                        }
                        _ => {}
                    }
                }
            }
        }
    }
    let crates = code.match_indices("fsi_").map(|(at, _)| first(&code[at..]));
    names.extend(crates);
    let climb = "super::".repeat(depth);
    for after in code.split(&climb).skip(1) {
        names.push(first(after.trim_start_matches("super::")));
    }
    names
}

/// Rooms that know nothing of another one although it comes before them.
const STRANGERS: [(&str, &str); 2] = [("fluid", "pfem"), ("fluid", "fsi_pfem")];

/// Arrows of a source file in `room` that run against the declared order, or to a stranger.
fn wrong_arrows(
    room: &str,
    source: &str,
    depth: usize,
    rooms: &BTreeMap<String, usize>,
) -> Vec<String> {
    let here = rooms[room];
    let mut wrong: Vec<String> = mentioned(source, depth)
        .into_iter()
        .filter(|name| {
            let is_late = rooms.get(name).is_some_and(|there| *there >= here);
            name != room && is_late || STRANGERS.contains(&(room, name.as_str()))
        })
        .collect();
    wrong.dedup();
    wrong
}

#[test]
fn no_room_knows_one_that_comes_after_it() {
    let rooms = declared();
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut wrong = Vec::new();
    let mut seen = 0;
    for path in sources(&src) {
        let below = path.strip_prefix(&src).unwrap();
        let parts: Vec<String> = (below.iter())
            .map(|part| part.to_str().unwrap().trim_end_matches(".rs").to_owned())
            .filter(|part| part != "mod")
            .collect();
        let room = parts[0].as_str();
        if room == "lib" || room == "main" || src.join(room).join("Cargo.toml").is_file() {
            continue;
        }
        assert!(
            rooms.contains_key(room),
            "{room} is not in ARCHITECTURE.md's list of rooms"
        );
        let source = std::fs::read_to_string(&path).unwrap();
        let arrows = wrong_arrows(room, &source, parts.len(), &rooms);
        wrong.extend(
            arrows
                .into_iter()
                .map(|to| format!("{} → {to}", below.display())),
        );
        seen += 1;
    }
    assert!(seen > 150, "{seen} files");
    assert!(
        wrong.is_empty(),
        "against the order in ARCHITECTURE.md:\n{}",
        wrong.join("\n")
    );
    for room in rooms.keys() {
        let exists = src.join(room).is_dir() || src.join(format!("{room}.rs")).is_file();
        assert!(exists, "ARCHITECTURE.md lists {room}, which is not there");
    }
}

/// The compiler keeps the order of the crates; here it is that of ARCHITECTURE.md.
#[test]
fn crates_come_first_and_in_order() {
    let rooms = declared();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let workspace = std::fs::read_to_string(root.join("Cargo.toml")).unwrap();
    // `fsi-pfem = { version = "0.2.0", path = "src/pfem" }`
    let crates: BTreeMap<&str, &str> = (workspace.lines())
        .filter_map(|line| {
            let (name, rest) = line.split_once(" = { version")?;
            let (_, room) = rest.split_once("path = \"src/")?;
            Some((name, room.split('"').next()?))
        })
        .collect();
    assert!(crates.len() > 1, "{crates:?}");
    for room in crates.values() {
        let manifest = std::fs::read_to_string(root.join("src").join(room).join("Cargo.toml"));
        let manifest = manifest.unwrap();
        for (name, used) in &crates {
            let uses = manifest.contains(&format!("\n{name}."));
            assert!(!uses || rooms[*used] < rooms[*room], "{room} → {used}");
        }
        let of_the_driver = rooms.iter().filter(|(name, _)| {
            let is_crate = crates.values().any(|room| room == name);
            !is_crate
        });
        for (name, level) in of_the_driver {
            assert!(
                rooms[*room] < *level,
                "{name} stands above the crate {room}"
            );
        }
    }
}

#[test]
fn a_wrong_arrow_is_seen_however_it_is_written() {
    let rooms = declared();
    let wrong = |room: &str, source: &str| !wrong_arrows(room, source, 2, &rooms).is_empty();
    assert!(wrong("case", "use crate::output::record;"));
    assert!(wrong(
        "case",
        "use crate::{Vec3, files::below, output::{record, vtu}};"
    ));
    assert!(wrong("case", "let x = crate::commands::main();"));
    assert!(wrong("case", "use super::super::simulation::Clock;"));
    assert!(
        wrong("coupling", "use crate::analysis::tube;"),
        "neighbours know nothing of each other"
    );
    assert!(wrong("fluid", "use crate::pfem::Solid;"));
    assert!(wrong("fluid", "use fsi_pfem::Solid;"));
    assert!(!wrong("output", "use crate::{case::Case, output::vtu};"));
    assert!(!wrong("case", "// use crate::output::record;"));
    assert!(!wrong("case", "use super::output;"));
}

/// What a case is, and which solver it chooses, is asked where cases are read, analysed and assembled.
#[test]
fn kinds_of_cases_and_solvers_are_asked_in_three_rooms() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let doors = ["case/", "analysis/", "simulation/assembly/"];
    for path in sources(&src) {
        let below = path.strip_prefix(&src).unwrap().to_str().unwrap();
        let source = std::fs::read_to_string(&path).unwrap();
        let words = source.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
        for word in words {
            let is_kind = ["Solver::", "Problem::"]
                .iter()
                .any(|kind| word.starts_with(kind));
            let asks = is_kind && !doors.iter().any(|door| below.starts_with(door));
            assert!(!asks, "{below} asks for {word}");
            let knows = word == "Case" && below.starts_with("hemodynamics/");
            assert!(!knows, "{below} knows a case");
        }
    }
}

#[test]
fn only_its_own_room_knows_openfoam() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    // Who chooses the fluid, and who says to the user which OpenFOAM is installed.
    let doors = [
        "simulation/assembly",
        "commands/check.rs",
        "commands/shell.rs",
    ];
    for path in sources(&src) {
        let below = path.strip_prefix(&src).unwrap().to_str().unwrap();
        if below.starts_with("fluid/") || doors.iter().any(|door| below.starts_with(door)) {
            continue;
        }
        let source = std::fs::read_to_string(&path).unwrap();
        let code = source.lines().map(|line| line.split("//").next().unwrap());
        let code: Vec<&str> = code.collect();
        assert!(!code.join("\n").contains("fluid::openfoam"), "{below}");
    }
}
