//! The study as it is computed: row by row, in a folder from which it goes on.

use super::cases::TestCase;
use super::compute;
use super::errors::EvaluatedSolution;
use super::figures;
use super::plan::{Choice, Plan};
use super::table::ConvergenceRow;
use crate::output::progress::human;
use crate::output::{terminal, write_atomically};
use crate::processes::peak_memory;
use crate::run::Failure;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What a study has come to.
pub struct StudyOutcome {
    /// Rows that are in its table.
    pub rows: usize,
    /// Computations that failed.
    pub failures: usize,
}

/// Computes what is not yet in the folder `out`, and draws the figures.
///
/// # Errors
/// If the folder is that of another study, or something cannot be written.
pub fn run(plans: &[Plan], out: &Path, quick: bool) -> Result<StudyOutcome, Failure> {
    let mut results = ResultsFolder::open(out, quick)?;
    let mut remaining = Remaining::new(plans, &results);
    let mut failures = 0;
    for plan in plans {
        let Some(reference) = results.reference(plan, &mut remaining)? else {
            failures += 1;
            continue;
        };
        for choice in &plan.choices {
            if results.row(choice).is_none() && !results.add(choice, &reference, &mut remaining)? {
                failures += 1;
            }
        }
        figures::write(&results.rows, out).map_err(|e| results.unwritten(&e))?;
    }
    Ok(StudyOutcome {
        rows: results.rows.len(),
        failures,
    })
}

/// Work that is left, and how fast this machine does it.
struct Remaining {
    /// Work that is left.
    left: f64,
    /// Seconds per work, of recent computations the most.
    pace: f64,
    /// Numbers of the computation that runs and of all.
    count: [usize; 2],
}

impl Remaining {
    fn new(plans: &[Plan], results: &ResultsFolder) -> Self {
        let choices = plans.iter().flat_map(|plan| &plan.choices);
        let rows = choices.filter(|choice| results.row(choice).is_none());
        let references = plans.iter().map(|plan| &plan.reference);
        let references = references.filter(|choice| !results.reference_path(choice.case).is_file());
        let open: Vec<&Choice> = rows.chain(references).collect();
        Self {
            left: open.iter().map(|choice| choice.work()).sum(),
            pace: 1.0,
            count: [0, open.len()],
        }
    }

    /// A computation ended; how long the others will take, in words.
    fn tick(&mut self, choice: &Choice, seconds: f64) -> String {
        let work = choice.work();
        self.left = (self.left - work).max(0.0);
        // Of a long computation the pace is known better than of a short one.
        let weight = work / (work + 0.3 * self.left.min(120.0)).max(1e-9);
        self.pace += weight * (seconds / work - self.pace);
        format!("{} left", human(self.pace * self.left))
    }
}

/// A reference solution as it is kept.
#[derive(Serialize, Deserialize)]
struct KeptReference {
    /// In words, so that another one is not mistaken for it.
    choice: String,
    solution: EvaluatedSolution,
}

/// The folder of the results.
struct ResultsFolder {
    folder: PathBuf,
    rows: Vec<ConvergenceRow>,
}

impl ResultsFolder {
    /// Takes up what is in the folder.
    fn open(folder: &Path, quick: bool) -> Result<Self, Failure> {
        let shown = folder.display();
        let input = |e: &dyn std::fmt::Display| Failure::Input(format!("{shown}: {e}"));
        fs::create_dir_all(folder).map_err(|e| input(&e))?;
        let mut results = Self {
            folder: folder.to_owned(),
            rows: Vec::new(),
        };
        for case in TestCase::ALL {
            let path = results.reference_path(case);
            let Ok(text) = fs::read(&path) else { continue };
            let kept: Option<KeptReference> = serde_json::from_slice(&text).ok();
            let wanted = Plan::new(case, quick).reference.to_string();
            if kept.is_none_or(|kept| kept.choice != wanted) {
                return Err(Failure::Input(format!(
                    "{}: not the reference of this study ({wanted}): with and without --quick the references differ; choose another --out",
                    path.display()
                )));
            }
        }
        if results.table_path().is_file() {
            let mut reader = csv::Reader::from_path(results.table_path()).map_err(|e| input(&e))?;
            for row in reader.deserialize() {
                results.rows.push(row.map_err(|e| {
                    Failure::Input(format!(
                        "{}: {e}; it is not a table of this study: choose another --out",
                        results.table_path().display()
                    ))
                })?);
            }
        }
        Ok(results)
    }

    fn table_path(&self) -> PathBuf {
        self.folder.join("convergence.csv")
    }

    fn reference_path(&self, case: TestCase) -> PathBuf {
        self.folder.join(format!("reference-{}.json", case.name()))
    }

    fn row(&self, choice: &Choice) -> Option<&ConvergenceRow> {
        self.rows.iter().find(|row| row.is_of(choice))
    }

    fn unwritten(&self, error: &dyn std::fmt::Display) -> Failure {
        let folder = self.folder.display();
        Failure::Run(format!(
            "the results could not be written to {folder}: {error}"
        ))
    }

    /// The reference of a plan, computed if it is not there; none if that fails.
    fn reference(
        &mut self,
        plan: &Plan,
        remaining: &mut Remaining,
    ) -> Result<Option<EvaluatedSolution>, Failure> {
        let path = self.reference_path(plan.reference.case);
        let kept = fs::read(&path).ok();
        let kept = kept.and_then(|text| serde_json::from_slice::<KeptReference>(&text).ok());
        if let Some(kept) = kept {
            return Ok(Some(kept.solution));
        }
        let Some(solution) = self.computed(&plan.reference, None, remaining)? else {
            return Ok(None);
        };
        let kept = KeptReference {
            choice: plan.reference.to_string(),
            solution,
        };
        let text = serde_json::to_vec_pretty(&kept).map_err(|e| self.unwritten(&e))?;
        write_atomically(&path, &text).map_err(|e| self.unwritten(&e))?;
        Ok(Some(kept.solution))
    }

    /// Computes a row; whether that succeeded.
    fn add(
        &mut self,
        choice: &Choice,
        reference: &EvaluatedSolution,
        remaining: &mut Remaining,
    ) -> Result<bool, Failure> {
        Ok(self.computed(choice, Some(reference), remaining)?.is_some())
    }

    /// Computes a choice and adds its row; without a reference it is one itself.
    fn computed(
        &mut self,
        choice: &Choice,
        reference: Option<&EvaluatedSolution>,
        remaining: &mut Remaining,
    ) -> Result<Option<EvaluatedSolution>, Failure> {
        remaining.count[0] += 1;
        let [number, all] = remaining.count;
        terminal::note(format_args!("[{number}/{all}] {choice}"));
        forget_peak_memory();
        let began = Instant::now();
        let outcome = compute(choice);
        let seconds = began.elapsed().as_secs_f64();
        let left = remaining.tick(choice, seconds);
        let computed = match outcome {
            Ok(computed) => computed,
            Err(error) => {
                terminal::note(format_args!(
                    "  failed after {seconds:.1} s: {error}; {left}"
                ));
                return Ok(None);
            }
        };
        let errors = computed
            .solution
            .errors(reference.unwrap_or(&computed.solution));
        terminal::note(format_args!(
            "  {} degrees of freedom, e_E {:.1e}, e_d {:.1e}, e_sv {:.1e}, {} iterations, {seconds:.1} s; {left}",
            computed.dofs,
            errors.energy,
            errors.displacement,
            errors.von_mises,
            computed.stats.iterations
        ));
        let memory = peak_memory(std::process::id()).unwrap_or(0.0) / 1e6;
        self.rows
            .push(ConvergenceRow::new(choice, &computed, &errors, memory));
        self.save()?;
        Ok(Some(computed.solution))
    }

    /// Writes the table again, in the order of cases, spaces, meshes and degrees; whole or not at all.
    fn save(&mut self) -> Result<(), Failure> {
        self.rows.sort_by(|a, b| a.order().cmp(&b.order()));
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in &self.rows {
            writer.serialize(row).map_err(|e| self.unwritten(&e))?;
        }
        let text = writer.into_inner().map_err(|e| self.unwritten(&e))?;
        write_atomically(&self.table_path(), &text).map_err(|e| self.unwritten(&e))
    }
}

/// Lets the kernel measure the largest memory from now on; where it refuses, the largest so far stands.
fn forget_peak_memory() {
    let _ = fs::write("/proc/self/clear_refs", "5");
}
