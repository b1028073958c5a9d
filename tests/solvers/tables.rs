//! Tables of pages that are made again from stored runs: those of this repository.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn tables(options: &[&str], pages: &[&Path]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command.arg("tables").args(options).args(pages);
    command.output().unwrap()
}

fn said(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn results() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/results")
}

#[test]
fn the_pages_say_what_the_stored_runs_say() {
    let pages = [
        "docs/results/README.md",
        "docs/results/random-lumen.md",
        "docs/credibility.md",
        "docs/speed.md",
        "openfoam-case/elastic-tube/README.md",
        "openfoam-case/slow-inflation/README.md",
        "openfoam-case/fda-nozzle/README.md",
        "openfoam-case/silicone-filament/README.md",
        "openfoam-case/single-arteries/README.md",
        "openfoam-case/turek-hron/README.md",
        "examples/own-case/flap/README.md",
        "examples/trees/aorta/README.md",
    ];
    let pages = pages.map(|page| Path::new(env!("CARGO_MANIFEST_DIR")).join(page));
    let output = tables(&["--check"], &pages.each_ref().map(PathBuf::as_path));
    assert!(output.status.success(), "{}", said(&output.stderr));
}

#[test]
fn a_page_is_filled_once_and_then_unchanged() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    let native = results().join("native");
    let around = |inside: &str| {
        format!(
            "before\n<!-- table: changes {0}/S-0.0 {0} -->\n{inside}<!-- end of table -->\nafter\n",
            native.display()
        )
    };
    std::fs::write(&page, around("something\n")).unwrap();
    let stale = tables(&["--check"], &[&page]);
    assert_eq!(stale.status.code(), Some(1), "{}", said(&stale.stderr));
    assert_eq!(
        std::fs::read_to_string(&page).unwrap(),
        around("something\n")
    );

    let written = tables(&[], &[&page]);
    assert!(said(&written.stdout).ends_with("page.md: 1 table(s), written\n"));
    let filled = std::fs::read_to_string(&page).unwrap();
    let rows: Vec<&str> = filled.lines().collect();
    assert!(
        rows[2].starts_with("| case | S-0.0 | S-0.25 | S-0.5 | S-0.75 | H-0.0 "),
        "{}",
        rows[2]
    );
    // A run does not differ from itself; a narrower lumen has a smaller volume, by a fifth at 0.75 mm.
    let volume = rows
        .iter()
        .find(|row| row.starts_with("| artery volume / ml |"))
        .unwrap();
    let cells: Vec<&str> = volume.split(" | ").collect();
    assert_eq!((cells[1], cells[4]), ("0 %", "\u{2212}19 %"), "{volume}");

    assert!(tables(&["--check"], &[&page]).status.success());
    assert!(said(&tables(&[], &[&page]).stdout).ends_with("unchanged\n"));
}

#[test]
fn a_mark_without_answer_is_refused_and_nothing_written() {
    let folder = tempfile::tempdir().unwrap();
    let good = folder.path().join("good.md");
    let page = folder.path().join("page.md");
    let native = results().join("native").display().to_string();
    let with = |words: &str| format!("a\n<!-- table: {words} -->\n<!-- end of table -->\n");
    std::fs::write(&good, with(&format!("models {native}"))).unwrap();
    for (mark, reason) in [
        (
            with("models nowhere"),
            "page.md: line 2: cannot read the folder",
        ),
        (
            with("model x"),
            "line 2: `model x` is not a table; expected `models STUDY`",
        ),
        (
            with("changes nowhere/S-0.0 nowhere"),
            "nowhere/S-0.0 is not the folder of a run",
        ),
        (
            with(&format!("models {native}")).replace("<!-- end of table -->", ""),
            "line 2: the table has no end",
        ),
        ("a page\n".to_owned(), "page.md has no place for a table"),
    ] {
        std::fs::write(&page, &mark).unwrap();
        let output = tables(&[], &[&good, &page]);
        let error = said(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(
            error.contains(reason) && error.matches("error:").count() == 1,
            "{error}"
        );
        assert_eq!(std::fs::read_to_string(&page).unwrap(), mark);
        assert_eq!(
            std::fs::read_to_string(&good).unwrap(),
            with(&format!("models {native}"))
        );
    }
}
