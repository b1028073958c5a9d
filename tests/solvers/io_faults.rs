//! Each call by which driver or solver uses a file fails once, as on a full disk or a broken one (`io_fault.c`): either
//! the run is none the worse for it, or it ends with a sentence that names the file, leaves no process behind, and goes
//! on by `--resume` to the results of a run that nothing has hindered, to the last digit.
//!
//! The whole campaign, `cargo test --release --test solvers io_faults -- --ignored`, fails every call.

use crate::native_run::FEW;
use crate::run_support::*;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What calls do; `stat` is what asks for a file's length or whether it is there.
const KINDS: [&str; 7] = ["open", "read", "write", "sync", "rename", "folder", "stat"];

/// Everything that a run can write, after each step.
const ALL: [&str; 5] = [
    "--set",
    "output.structure_interval_s=0.002",
    "output.fluid_interval_s=0.002",
    "output.probes_m=[[0.045, 3.2e-3, 0.0]]",
    "output.fluid_probes_m=[[0.01, 0.001, 0.0]]",
];

/// What a command leaves in whose calls one fails.
struct Struck {
    code: Option<i32>,
    said: String,
    /// The call that failed, or all that were counted.
    report: String,
}

/// Runs of three steps with one fluid.
struct Bench {
    folder: tempfile::TempDir,
    fluid: &'static [&'static str],
    /// Whether the calls fail when a run of two steps goes on, instead of a new one.
    resumed: bool,
}

impl Bench {
    /// None where processes may not be traced, or there is no compiler for these few lines of C.
    fn new(fluid: &'static [&'static str], resumed: bool) -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/solvers/io_fault.c");
        let compiled = Command::new("cc")
            .args(["-std=gnu11", "-O2", "-Wall", "-Wextra", "-Werror", "-o"])
            .args([&folder.path().join("io_fault"), Path::new(source)])
            .output()
            .unwrap();
        assert!(compiled.status.success(), "{}", text(&compiled));
        let bench = Self {
            folder,
            fluid,
            resumed,
        };
        let traced = bench.struck(&Command::new("/bin/true"), ["driver", "read"], 0);
        if traced.code != Some(0) {
            println!("not tested: {}", traced.said);
            return None;
        }
        complete(bench.run("straight", 3, &[]));
        if resumed {
            complete(bench.run("two", 2, &[]));
        }
        Some(bench)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, name: &str, steps: usize, more: &[&str]) -> Command {
        let temporary = self.path("tmp");
        std::fs::create_dir_all(&temporary).unwrap();
        let words = [&ALL, self.fluid, more].concat();
        let (sets, others): (Vec<&str>, Vec<&str>) =
            (words.iter().filter(|word| **word != "--set")).partition(|word| word.contains('='));
        let mut run = driver(
            &self.path(name),
            steps,
            &[&others, &["--set"][..], &sets].concat(),
        );
        // The number of threads decides the last digits.
        run.env("RAYON_NUM_THREADS", "1").env("TMPDIR", temporary);
        run
    }

    /// `command` with the `k`-th call failing; with none if `k` is 0.
    fn struck(&self, command: &Command, [whose, kind]: [&str; 2], k: usize) -> Struck {
        let report = self.path("report");
        let case = concat!(env!("CARGO_MANIFEST_DIR"), "/openfoam-case");
        let mut fault = Command::new(self.path("io_fault"));
        fault.arg(&report);
        fault.arg(format!("{}:{case}", self.folder.path().display()));
        fault.args([whose, kind, &k.to_string()]);
        fault.arg(command.get_program()).args(command.get_args());
        fault.current_dir(command.get_current_dir().unwrap_or(Path::new("/")));
        fault.envs(command.get_envs().filter_map(|(k, v)| Some((k, v?))));
        let output = fault.output().unwrap();
        Struck {
            code: output.status.code(),
            said: text(&output),
            report: std::fs::read_to_string(report).unwrap(),
        }
    }

    /// A run of three steps from its start, or of its third step, in which one call fails.
    fn strike(&self, calls: [&str; 2], k: usize) -> Struck {
        let out = self.path("run");
        let _ = std::fs::remove_dir_all(&out);
        if self.resumed {
            copy(&self.path("two"), &out);
            return self.struck(&self.run("run", 3, &["--resume"]), calls, k);
        }
        self.struck(&self.run("run", 3, &[]), calls, k)
    }

    /// The run is that which nothing has hindered, and nothing else is left.
    fn assert_same(&self) {
        let [straight, out] = ["straight", "run"].map(|name| self.path(name));
        assert_same_run(&out, &straight);
        for table in ["probes.csv", "fluid-probes.csv"] {
            assert_eq!(rows(&out.join(table)), rows(&straight.join(table)));
        }
        // Each start of OpenFOAM has a folder of its own for its probes; nobody reads the state of its function
        // objects.
        let is_result = |name: &PathBuf| {
            let name = name.to_string_lossy();
            !name.contains("openfoam/postProcessing") && !name.contains("functionObject")
        };
        let results = |run| BTreeSet::from_iter(names(run).into_iter().filter(is_result));
        let [expected, found] = [&straight, &out].map(|run| results(run));
        let odd: Vec<_> = found.symmetric_difference(&expected).collect();
        assert!(odd.is_empty(), "left, or not there: {odd:?}");
        let temporary = names(&self.path("tmp"));
        assert!(temporary.is_empty(), "left: {temporary:?}");
    }

    /// What comes of the `k`-th call's failure; panics if it is not what it should be.
    fn check(&self, calls: [&str; 2], k: usize) -> &'static str {
        let Struck { code, said, report } = self.strike(calls, k);
        println!("{calls:?} {k}: {report} -> {code:?} {said}");
        assert!(!report.contains("left a process") && !report.contains("took too long"));
        assert!(!said.contains("panicked at"));
        assert!(processes_in(self.folder.path()).is_empty());
        if code == Some(0) {
            self.assert_same();
            return "harmless";
        }
        assert!(code == Some(1) || code == Some(2));
        let error = said.split_once("error: ").expect("an error is reported").1;
        let (what, _) = error.split_once("; --resume").unwrap_or((error, ""));
        let folders = [&*self.folder.path().to_string_lossy(), "openfoam-case"];
        assert!(folders.iter().any(|folder| what.contains(folder)), "{what}");
        let resumed = self.run("run", 3, &["--resume"]).output().unwrap();
        let how = if text(&resumed).contains("start it without --resume") {
            assert_eq!(code, Some(2), "it says that nothing was written");
            complete(self.run("run", 3, &[]));
            "started again"
        } else {
            assert!(resumed.status.success(), "{}", text(&resumed));
            "resumed"
        };
        self.assert_same();
        how
    }

    /// Fails those of the calls that are `chosen` by their number among all of their kind, from 0, and their name and
    /// file.
    fn campaign(&self, whose: &str, kinds: &[&str], chosen: &dyn Fn(usize, &str) -> bool) {
        let (mut wrong, mut before) = (Vec::new(), 0);
        for kind in kinds {
            let counted = self.strike([whose, kind], 0);
            assert_eq!(counted.code, Some(0), "{}", counted.said);
            self.assert_same();
            let calls: Vec<&str> = counted.report.lines().collect();
            let struck = (1..=calls.len()).filter(|k| chosen(before + k - 1, calls[k - 1]));
            let mut outcomes = Vec::new();
            for k in struck {
                let outcome = catch_unwind(AssertUnwindSafe(|| self.check([whose, kind], k)));
                match outcome {
                    Ok(outcome) => outcomes.push(outcome),
                    Err(_) => wrong.push(calls[k - 1].to_owned()),
                }
            }
            let of = |what| outcomes.iter().filter(|outcome| **outcome == what).count();
            println!(
                "{whose}, {kind}: {} of {} calls failed: {} harmless, {} resumed, {} started again",
                outcomes.len(),
                calls.len(),
                of("harmless"),
                of("resumed"),
                of("started again")
            );
            before += calls.len();
        }
        assert!(wrong.is_empty(), "after:\n{}", wrong.join("\n"));
        assert!(before > 0, "no call was counted");
    }
}

/// Names of all files and folders in a folder.
fn names(root: &Path) -> BTreeSet<PathBuf> {
    let (mut all, mut folders) = (BTreeSet::new(), vec![root.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            all.insert(path.strip_prefix(root).unwrap().to_owned());
            if path.is_dir() {
                folders.push(path);
            }
        }
    }
    all
}

#[test]
fn a_call_for_a_file_that_fails_once_changes_no_result() {
    for resumed in [false, true] {
        let Some(bench) = Bench::new(&FEW, resumed) else {
            return;
        };
        let sample = |n: usize, call: &str| {
            // After the last checkpoint the older ones are looked for.
            let looks = call.contains("getdents") && call.contains("/checkpoints ");
            n % 47 == 11 || looks && n % 3 == 1
        };
        bench.campaign("driver", &KINDS, &sample);
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_file_call_that_fails_once_changes_nothing_with_openfoam() {
    let Some(bench) = Bench::new(&[], false) else {
        return;
    };
    // What the solver stops at is in its log; what it does not notice is found by the driver.
    bench.campaign("solver", &["write"], &|n, call| {
        call.contains("0.004/U ") && n % 2 == 0 || call.contains("0.004/uniform/time") && n % 3 == 0
    });
    bench.campaign("solver", &["read"], &|n, call| {
        call.contains("run/openfoam/constant/inflow ") && n % 20 == 0
    });
    bench.campaign("driver", &["sync", "folder"], &|_, call| {
        call.contains("0.004/phi ") || call.contains("run/openfoam/constant/polyMesh ")
    });
}

#[test]
#[ignore = "about half an hour"]
fn every_call_for_a_file_fails_once() {
    for resumed in [false, true] {
        let Some(bench) = Bench::new(&FEW, resumed) else {
            return;
        };
        bench.campaign("driver", &KINDS, &|_, _| true);
    }
}

#[test]
#[ignore = "some hours"]
#[cfg(feature = "openfoam")]
fn every_call_for_a_file_fails_once_with_openfoam() {
    for resumed in [false, true] {
        let Some(bench) = Bench::new(&[], resumed) else {
            return;
        };
        // Two hundred times the same: it ends when it cannot write its log.
        let is_log = |call: &str| call.contains("openfoam.log");
        bench.campaign("solver", &KINDS, &|n, call| !is_log(call) || n % 25 == 0);
        bench.campaign("driver", &KINDS, &|_, _| true);
    }
}
