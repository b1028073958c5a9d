//! The program away from its sources: program and adapter below a prefix, the case anywhere, defaults and OpenFOAM's
//! dictionaries from the program.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A prefix such as `cargo install --root` and `setup.sh --prefix` make, and a home of its own.
struct Installation {
    folder: tempfile::TempDir,
}

impl Installation {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let bin = folder.path().join("prefix/bin");
        fs::create_dir_all(&bin).unwrap();
        fs::create_dir(folder.path().join("home")).unwrap();
        // By another process: while one test writes the file another one might fork, and hold it open for writing.
        let copied = Command::new("cp")
            .args([env!("CARGO_BIN_EXE_fsi-driver").as_ref(), bin.as_path()])
            .status();
        assert!(copied.unwrap().success());
        Self { folder }
    }

    fn prefix(&self) -> PathBuf {
        self.folder.path().join("prefix")
    }

    fn run(&self, arguments: &[&str]) -> Output {
        Command::new(self.prefix().join("bin/fsi-driver"))
            .current_dir(self.folder.path())
            .env("HOME", self.folder.path().join("home"))
            .env_remove("XDG_CACHE_HOME")
            .env_remove("FSI_DRIVER_ADAPTER")
            .env_remove("FSI_DRIVER_OPENFOAM")
            .args(arguments)
            .output()
            .unwrap()
    }

    fn said(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{error}");
        String::from_utf8(output.stdout).unwrap()
    }
}

fn setup(prefix: &Path) -> String {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("of-adapter/setup.sh");
    let output = Command::new(script)
        .arg("--prefix")
        .arg(prefix)
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn an_installed_program_runs_a_case_from_any_folder() {
    let installed = Installation::new();
    assert!(setup(&installed.prefix()).contains("installed: "));
    assert!(setup(&installed.prefix()).ends_with("libfsiAdapter.so is the same\n"));

    let library = installed
        .prefix()
        .join("lib/fsi-driver/v1912/libfsiAdapter.so");
    let version = installed.said(&["--version"]);
    assert!(version.starts_with(concat!(
        "fsi-driver ",
        env!("CARGO_PKG_VERSION"),
        "\nOpenFOAM 1912"
    )));
    assert!(
        version.ends_with(&format!("adapter {}\n", library.display())),
        "{version}"
    );

    let case = installed.folder.path().join("my case");
    fs::create_dir(&case).unwrap();
    let text = "extends = \"defaults\"\n[model]\nd_max_m = 0.25e-3\n";
    fs::write(case.join("case.toml"), text).unwrap();
    let run = [
        "--case",
        "my case",
        "--preset",
        "demo",
        "--end-time",
        "0.006",
        "--out",
        "run",
    ];
    installed.said(&run);
    let out = installed.folder.path().join("run");
    let history = fs::read_to_string(out.join("history.csv")).unwrap();
    assert_eq!(history.lines().count(), 1 + 3, "{history}");
    // The file of record is a case that needs no more than the program, either.
    let record = out.join("case.resolved.toml");
    let text = fs::read_to_string(&record).unwrap();
    assert!(text.contains("templates = \"built-in/vessel\""), "{text}");
    assert!(text.contains("; built-in defaults.toml:"), "{text}");
    fs::remove_dir_all(installed.folder.path().join("home")).unwrap();
    installed.said(&["check", "run/case.resolved.toml"]);
}

/// Where the user's cache cannot be written, the dictionaries go where temporary files do.
#[test]
fn a_home_that_cannot_be_written_does_not_matter() {
    let installed = Installation::new();
    let case = installed.folder.path().join("case.toml");
    fs::write(&case, "extends = \"defaults\"\n").unwrap();
    // A file where the cache should be: not even root can make a folder of it.
    fs::write(installed.folder.path().join("home/.cache"), "").unwrap();
    let output = Command::new(installed.prefix().join("bin/fsi-driver"))
        .env("HOME", installed.folder.path().join("home"))
        .env("TMPDIR", installed.folder.path())
        .env_remove("XDG_CACHE_HOME")
        .arg("check")
        .arg(installed.folder.path())
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let mut names = fs::read_dir(installed.folder.path()).unwrap();
    assert!(names.any(|entry| {
        let name = entry.unwrap().file_name();
        name.to_string_lossy().starts_with("fsi-driver-")
    }));
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn the_adapter_that_a_variable_names_comes_first() {
    let installed = Installation::new();
    setup(&installed.folder.path().join("elsewhere"));
    let library = installed
        .folder
        .path()
        .join("elsewhere/lib/fsi-driver/v1912/libfsiAdapter.so");
    for named in [
        "elsewhere",
        "elsewhere/lib/fsi-driver",
        "elsewhere/lib/fsi-driver/v1912",
        "elsewhere/lib/fsi-driver/v1912/libfsiAdapter.so",
    ] {
        let output = Command::new(installed.prefix().join("bin/fsi-driver"))
            .env("FSI_DRIVER_ADAPTER", installed.folder.path().join(named))
            .arg("--version")
            .output()
            .unwrap();
        let said = String::from_utf8(output.stdout).unwrap();
        assert!(
            said.ends_with(&format!("adapter {}\n", library.display())),
            "{said}"
        );
    }
}
