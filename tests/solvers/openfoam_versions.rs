//! Which OpenFOAM of several is used, by `setup.sh` and by the program. The trees hold only what says which they are.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder with an OpenFOAM of this number, whose `etc/bashrc` puts a `pimpleFoam` onto the path.
fn tree(folder: &Path, api: u32) -> PathBuf {
    let tree = folder.join(format!("openfoam{api}"));
    for below in ["META-INFO", "etc", "bin"] {
        fs::create_dir_all(tree.join(below)).unwrap();
    }
    fs::write(
        tree.join("META-INFO/api-info"),
        format!("api={api}\npatch=7\n"),
    )
    .unwrap();
    let bashrc = format!("export PATH={}/bin:$PATH\n", tree.display());
    fs::write(tree.join("etc/bashrc"), bashrc).unwrap();
    let solver = tree.join("bin/pimpleFoam");
    fs::write(&solver, "#!/bin/sh\nexit 3\n").unwrap();
    fs::set_permissions(&solver, fs::Permissions::from_mode(0o755)).unwrap();
    tree
}

/// Runs a program without any OpenFOAM but what `variables` say.
fn output(program: &Path, arguments: &[&str], variables: &[(&str, &Path)]) -> (Output, String) {
    let output = Command::new(program)
        .env_remove("WM_PROJECT_DIR")
        .env_remove("FSI_DRIVER_OPENFOAM")
        .env_remove("FSI_DRIVER_ADAPTER")
        .envs(variables.iter().copied())
        .args(arguments)
        .output()
        .unwrap();
    let both = [output.stdout.as_slice(), &output.stderr].concat();
    let text = String::from_utf8(both).unwrap();
    (output, text)
}

/// `setup.sh` up to where it misses the headers of a tree.
fn chosen(arguments: &[&str], variables: &[(&str, &Path)]) -> String {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("of-adapter/setup.sh");
    let (output, text) = output(&script, arguments, variables);
    assert!(!output.status.success(), "{text}");
    text
}

#[test]
fn setup_prefers_what_is_named_then_loaded_then_the_newest() {
    let folder = tempfile::tempdir().unwrap();
    let several = folder.path();
    let (older, newer) = (tree(several, 9901), tree(several, 9902));
    let using = |how: &str, tree: &Path, api: u32| {
        format!(
            "using the OpenFOAM that is {how}: {api}.7 in {}\n",
            tree.display()
        )
    };
    let loaded = ("WM_PROJECT_DIR", older.as_path());
    let named = ("FSI_DRIVER_OPENFOAM", newer.as_path());

    let text = chosen(&[], &[("FSI_DRIVER_OPENFOAM", several)]);
    assert!(text.contains(&using("installed", &newer, 9902)), "{text}");
    assert!(text.contains("install openfoam9902-dev"), "{text}");
    let text = chosen(&[], &[loaded]);
    assert!(text.contains(&using("loaded", &older, 9901)), "{text}");
    let text = chosen(&[], &[loaded, named]);
    let by_variable = using("named by FSI_DRIVER_OPENFOAM", &newer, 9902);
    assert!(text.contains(&by_variable), "{text}");
    for wanted in ["9901", "v9901", older.to_str().unwrap()] {
        let text = chosen(&["--openfoam", wanted], &[("FSI_DRIVER_OPENFOAM", several)]);
        assert!(
            text.contains(&using("named by --openfoam", &older, 9901)),
            "{text}"
        );
    }
}

#[test]
fn setup_says_why_it_takes_no_other_openfoam() {
    let folder = tempfile::tempdir().unwrap();
    let foundation = folder.path().join("openfoam11");
    fs::create_dir_all(foundation.join("etc")).unwrap();
    fs::write(
        foundation.join("etc/bashrc"),
        "export WM_PROJECT_VERSION=11\n",
    )
    .unwrap();
    let text = chosen(&[], &[("WM_PROJECT_DIR", &foundation)]);
    for part in [
        "not an OpenFOAM of openfoam.com",
        "openfoam.org has no pimpleFoam",
        "--openfoam debian",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let text = chosen(&[], &[("WM_PROJECT_DIR", &tree(folder.path(), 1806))]);
    assert!(
        text.contains("OpenFOAM 1806") && text.contains("older than 1912"),
        "{text}"
    );
    let nothing = folder.path().join("nothing");
    let text = chosen(&[], &[("WM_PROJECT_DIR", &nothing)]);
    assert!(text.contains("there is no OpenFOAM in"), "{text}");
    let text = chosen(&["--openfoam", "9903"], &[]);
    assert!(
        text.contains("there is no /usr/lib/openfoam/openfoam9903"),
        "{text}"
    );
}

#[test]
fn an_adapter_for_another_openfoam_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (older, newer) = (tree(folder.path(), 9901), tree(folder.path(), 9902));
    let adapters = folder.path().join("adapters");
    let library = adapters.join("v9901/libfsiAdapter.so");
    fs::create_dir_all(library.parent().unwrap()).unwrap();
    fs::write(&library, "").unwrap();
    let stamp = |of: &Path| {
        let text = format!("openfoam 9901.7 in {}\nadapter 0\n", of.display());
        fs::write(library.with_file_name("stamp"), text).unwrap();
    };
    stamp(&older);
    let program = Path::new(env!("CARGO_BIN_EXE_fsi-driver"));
    let with = |openfoam: &Path, arguments: &[&str]| {
        let variables = [
            ("FSI_DRIVER_OPENFOAM", openfoam),
            ("FSI_DRIVER_ADAPTER", &adapters),
        ];
        output(program, arguments, &variables)
    };
    // Of two the one that has an adapter, and the other one after it.
    let (_, text) = with(folder.path(), &["--version"]);
    let first = format!(
        "OpenFOAM 9901.7 in {} (installed)\nadapter {}\n",
        older.display(),
        library.display()
    );
    let (before, after) = text.split_once(&first).unwrap_or_else(|| panic!("{text}"));
    assert_eq!(
        before,
        concat!("fsi-driver ", env!("CARGO_PKG_VERSION"), "\n")
    );
    let missing = format!(
        "OpenFOAM 9902.7 in {} (installed)\nadapter FSI_DRIVER_ADAPTER names",
        newer.display()
    );
    assert!(after.starts_with(&missing), "{text}");

    let case = folder.path().join("case.toml");
    fs::write(&case, "extends = \"defaults\"\n").unwrap();
    let out = folder.path().join("run");
    let run = [
        "--case",
        case.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ];
    let refused = |openfoam: &Path, parts: &[&str]| {
        let (output, text) = with(openfoam, &run);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(
            parts.iter().all(|part| text.contains(part)) && !out.exists(),
            "{text}"
        );
    };
    let mended = format!("run of-adapter/setup.sh --openfoam {}", newer.display());
    refused(&newer, &["no libfsiAdapter.so for OpenFOAM 9902", &mended]);
    stamp(&newer);
    let mended = format!("run of-adapter/setup.sh --openfoam {}", older.display());
    let built = format!("was built for 9901.7 in {}", newer.display());
    refused(&older, &[&built, &mended]);
    let foundation = folder.path().join("openfoam11");
    fs::create_dir_all(&foundation).unwrap();
    refused(&foundation, &["openfoam.org is another program"]);
}
