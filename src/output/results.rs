//! What a run has left: evaluated at its end, and read again later.

use super::run_files::{MARK, RunFiles, draft, replace};
use super::tables::{self, HistoryRow};
use super::wall_fields::{self, FaceRow};
use super::wall_history::WallHistoryReader;
use super::{phases, record, wall_record, write_atomically};
use crate::analysis;
use crate::analysis::centre_line;
use crate::case::{BloodVessel, Case, Window, Windows};
use crate::files::named;
use crate::geometry::PolyMesh;
use crate::geometry::tree::Tree;
use crate::hemodynamics::summary::{HistorySeries, WallFields};
use crate::hemodynamics::{
    Agreement, HemodynamicsSummary, RegionStep, Steadiness, WetSurface, WindowStatistics,
};
use std::io;
use std::path::Path;

/// Evaluates a run over a window: writes `hemodynamics.json` and the fields on the wall `into` a folder, perhaps the
/// run's own. If no step of the window was seen there are no fields, and an earlier evaluation stays as it is.
pub fn evaluate(
    files: &RunFiles,
    into: &RunFiles,
    case: &Case,
    wall: &WetSurface,
    statistics: &WindowStatistics,
) -> io::Result<HemodynamicsSummary> {
    let rows: Vec<RegionStep> = tables::read(&files.regions())?;
    let history: Vec<HistoryRow> = tables::read(&files.history())?;
    let times = [case.time.step, case.time.period];
    let series = series(&tables::whole_steps(&history, case.time.step));
    let summary = HemodynamicsSummary::new(
        wall,
        &analysis::regions(case),
        statistics,
        &rows,
        &series,
        times,
    );
    let fields = WallFields::new(wall, statistics);
    if fields.is_none() && into.hemodynamics().exists() {
        return Ok(summary);
    }
    // Whole files next to the earlier ones, then in their place: a full disk spoils nothing.
    let folder = draft(into)?;
    let draft = RunFiles::new(folder.path());
    if let Some(fields) = &fields {
        let rows = wall_fields::rows(wall, fields);
        wall_fields::write_table(&draft.wall_shear_table(), &rows)?;
        wall_fields::write_series(&draft.wall_shear(), statistics.window.end_s, wall, fields)?;
    }
    let history = files.wall_history();
    if history.try_exists().map_err(named(&history))? {
        let times = [case.time.step, case.output.structure_interval];
        wall_fields::write_over_time(&draft.wall_shear_over_time(), &history, times)?;
    }
    let json = serde_json::to_string_pretty(&summary).map_err(io::Error::other)?;
    write_atomically(&draft.hemodynamics(), json.as_bytes())?;
    if into.root() == files.root() {
        write_atomically(&draft.view(), include_bytes!("view.py"))?;
    }
    replace(folder.path(), into.root())?;
    folder.close()?;
    // Its earlier name hid ParaView's own module of that name.
    let former = into.root().join("paraview.py");
    match std::fs::remove_file(&former) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(named(&former)(e)),
        _ => {}
    }
    Ok(summary)
}

/// The columns of a history that the summary needs.
fn series(history: &[&HistoryRow]) -> HistorySeries {
    let column = |value: fn(&HistoryRow) -> f64| history.iter().map(|row| value(row)).collect();
    HistorySeries {
        time: column(|row| row.time_s),
        inflow: column(|row| row.Q_in_m3_s),
        outflow: column(|row| row.Q_out_m3_s),
        outlet_pressure: column(|row| row.p_out_Pa),
        displacement: column(|row| row.max_displacement_m),
    }
}

/// Why a folder cannot be read as a run.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ResultsError(String);

/// A run that was read again.
#[derive(Debug, Clone)]
pub struct Results {
    /// Its files.
    pub files: RunFiles,
    /// Every value that was used.
    pub case: Case,
    /// The vessel that it is about; none of a user-supplied OpenFOAM case.
    pub vessel: Option<BloodVessel>,
    /// The run in figures, if it has ended.
    pub summary: Option<record::RunSummary>,
    /// One row per time step.
    pub history: Vec<HistoryRow>,
    /// One row per time step and region.
    pub regions: Vec<RegionStep>,
    /// The hemodynamics in figures.
    pub hemodynamics: HemodynamicsSummary,
    /// One row per face; empty if no step of the window was seen.
    pub faces: Vec<FaceRow>,
    /// Whether it was read while the run was going on.
    pub is_going_on: bool,
}

impl Results {
    /// What its case is called: its `output.title`, or else the name of the run's folder, or of the case's where the
    /// run lies within it.
    pub fn name(&self) -> String {
        if let Some(title) = &self.case.output.title {
            return title.clone();
        }
        let root = self.files.root();
        let root = root.canonicalize().unwrap_or_else(|_| root.to_owned());
        let name = |path: &Path| path.file_name().map(|n| n.to_string_lossy().into_owned());
        let own = name(&root).unwrap_or_else(|| "a run".into());
        // Without `--out` a run lies in `<case>/run-<preset>`.
        match root.parent().and_then(name) {
            Some(case) if own.starts_with("run-") => case,
            _ => own,
        }
    }

    /// What its case is called by itself: its `output.title`, or the folder (or the file) that was run, wherever the
    /// results are.
    pub fn case_name(&self) -> String {
        let ran = self
            .summary
            .as_ref()
            .map(|summary| Path::new(&summary.case));
        let own = ran.and_then(|case| match case.file_name() {
            Some(name) if name == "case.toml" => case.parent()?.file_name(),
            Some(_) if case.extension().is_some_and(|ending| ending == "toml") => case.file_stem(),
            name => name,
        });
        let (None, Some(own)) = (&self.case.output.title, own) else {
            return self.name();
        };
        let own = own.to_string_lossy();
        // Of several runs of a case each has a folder that tells it.
        let folder = self.files.root().canonicalize().ok();
        let folder = folder.and_then(|root| Some(root.file_name()?.to_string_lossy().into_owned()));
        match folder {
            Some(run) if run != own && !run.starts_with("run-") => format!("{own}, run {run}"),
            _ => own.into_owned(),
        }
    }

    /// The unloaded wet surface, where it lies; none if the run has not kept it.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn wall(&self) -> io::Result<Option<WetSurface>> {
        let path = self.files.wall_history();
        if !path.is_file() {
            return Ok(None);
        }
        let wall = WallHistoryReader::open(&path)?.wall;
        placed(wall, &self.case, &self.files).map(Some)
    }

    /// Why its averages may not be those of a beat, and whether it alternates from step to step, a sentence each; what
    /// a user-supplied OpenFOAM case prescribes need not have any.
    pub fn warnings(&self) -> Vec<String> {
        if self.vessel.is_none() {
            return Vec::new();
        }
        let window = self.hemodynamics.window;
        let (case, is_steady) = (&self.case, self.case.is_driven_steadily());
        let of_window = window.warning(&case.ramp, case.time.period, is_steady);
        let mut warnings = Vec::from_iter(of_window);
        warnings.extend(self.hemodynamics.alternates());
        if let Some(summary) = &self.summary {
            let findings = summary.resolution.iter().flat_map(|found| &found.findings);
            warnings.extend(findings.map(|finding| finding.text.clone()));
            warnings.extend(summary.steadiness.as_ref().and_then(Steadiness::warning));
            warnings.extend(summary.periodic.as_ref().and_then(Agreement::warning));
        }
        warnings
    }

    /// Reads the case and the figures of the run in the folder `root`, without its tables, which stay empty.
    ///
    /// # Errors
    /// If there is none, or it has not ended yet, or a file of it is damaged, or it is one of a flag.
    pub fn load_figures(root: &Path) -> Result<Self, ResultsError> {
        let files = RunFiles::new(root);
        let case = case_with_page(&files)?;
        Self::figures_of(case, files)
    }

    /// The same of a run of any case: what was recorded at points is compared for flags too.
    ///
    /// # Errors
    /// If there is none, or it has not ended yet, or a file of it is damaged.
    pub fn load_figures_of_any(root: &Path) -> Result<Self, ResultsError> {
        let files = RunFiles::new(root);
        Self::figures_of(read_case(&files)?, files)
    }

    fn figures_of(case: Case, files: RunFiles) -> Result<Self, ResultsError> {
        let vessel = case.vessel().cloned();
        let failed = |path: &Path, error: &dyn std::fmt::Display| {
            ResultsError(format!("cannot read {}: {error}", path.display()))
        };
        let path = files.hemodynamics();
        if !path.is_file() {
            return Err(ResultsError(format!(
                "{} holds no hemodynamics.json: the run has not ended in order yet; continue it with --resume",
                files.root().display()
            )));
        }
        let text = std::fs::read(&path).map_err(|e| failed(&path, &e))?;
        let hemodynamics = serde_json::from_slice(&text).map_err(|e| failed(&path, &e))?;
        let summary = std::fs::read(files.summary()).ok();
        Ok(Self {
            history: Vec::new(),
            summary: summary.and_then(|text| serde_json::from_slice(&text).ok()),
            regions: Vec::new(),
            faces: Vec::new(),
            hemodynamics,
            case,
            vessel,
            files,
            is_going_on: false,
        })
    }

    /// Reads the run in the folder `root` while it is going on, as far as it has come: what is averaged is so over the
    /// steps of the window until now.
    ///
    /// # Errors
    /// If it has no step yet, or a file cannot be read, or it is the run of a flag.
    pub fn load_unfinished(root: &Path) -> Result<Self, ResultsError> {
        let files = RunFiles::new(root);
        let case = case_with_page(&files)?;
        let unread = |e: io::Error| ResultsError(format!("cannot read {e}"));
        let history: Vec<HistoryRow> = match files.history() {
            path if path.is_file() => tables::read(&path).map_err(unread)?,
            _ => Vec::new(),
        };
        if history.is_empty() {
            return Err(ResultsError(format!(
                "the run in {} has not finished its first step yet",
                root.display()
            )));
        }
        let regions: Vec<RegionStep> = tables::read(&files.regions()).map_err(unread)?;
        let reached = history.last().map_or(0.0, |row| row.time_s);
        let (window, path) = (Windows::of(&case).at(reached), files.wall_history());
        let (wall, statistics) = match path.is_file() {
            true => {
                let gathered = wall_record::gather(&path, window, case.time.step, &[]);
                let (wall, statistics) = gathered.map_err(|e| ResultsError(e.to_string()))?;
                (placed(wall, &case, &files).map_err(unread)?, statistics)
            }
            false => (
                WetSurface::new(Vec::new(), Vec::new()),
                WindowStatistics::new(window, 0, 0),
            ),
        };
        let series = series(&tables::whole_steps(&history, case.time.step));
        let times = [case.time.step, case.time.period];
        let (parts, fields) = (
            analysis::regions(&case),
            WallFields::new(&wall, &statistics),
        );
        Ok(Self {
            hemodynamics: HemodynamicsSummary::new(
                &wall,
                &parts,
                &statistics,
                &regions,
                &series,
                times,
            ),
            faces: fields.map_or(Vec::new(), |fields| wall_fields::rows(&wall, &fields)),
            vessel: case.vessel().cloned(),
            summary: None,
            is_going_on: true,
            history,
            regions,
            case,
            files,
        })
    }

    /// Reads the run in the folder `root`.
    ///
    /// # Errors
    /// If there is none, or it has not ended yet, or a file of it is damaged, or it is one of a flag.
    pub fn load(root: &Path) -> Result<Self, ResultsError> {
        let mut run = Self::load_figures(root)?;
        let files = &run.files;
        let unread = |e: io::Error| ResultsError(format!("cannot read {e}"));
        let empty = |path: &Path| {
            ResultsError(format!(
                "{} holds no row: it is damaged; restore it from a copy, or compute the run again",
                path.display()
            ))
        };
        run.faces = match tables::read(&files.wall_shear_table()) {
            Ok(rows) if rows.is_empty() => return Err(empty(&files.wall_shear_table())),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Vec::new(),
            found => found.map_err(unread)?,
        };
        run.history = tables::read(&files.history()).map_err(unread)?;
        if run.history.is_empty() {
            return Err(empty(&files.history()));
        }
        run.regions = tables::read(&files.regions()).map_err(unread)?;
        Ok(run)
    }
}

/// The case of a run that pages and comparisons are about.
fn case_with_page(files: &RunFiles) -> Result<Case, ResultsError> {
    let case = read_case(files)?;
    match case.flag() {
        Some(_) => Err(ResultsError(format!(
            "{} is the run of a [flag], but reports and comparisons are about vessels and OpenFOAM cases of your own; look at its \
             probes.csv and history.csv, and open structure.pvd and openfoam/fluid.foam in ParaView",
            files.root().display()
        ))),
        None => Ok(case),
    }
}

/// The case of a run.
///
/// # Errors
/// If the folder is not that of a run.
pub fn read_case(files: &RunFiles) -> Result<Case, ResultsError> {
    let (root, path) = (files.root().display(), files.resolved_case());
    if !path.is_file() {
        return Err(ResultsError(format!(
            "{root} is not the folder of a run (it holds no {MARK})"
        )));
    }
    let text = std::fs::read_to_string(&path);
    let text = text.map_err(|e| ResultsError(format!("cannot read {}: {e}", path.display())))?;
    Case::of_earlier_run(&text).map_err(|e| {
        ResultsError(format!(
            "{} was written by another version of the program: {e}",
            path.display()
        ))
    })
}

/// A stored wall around the centre-line of its case, and on its patches where regions are made of them.
fn placed(wall: WetSurface, case: &Case, files: &RunFiles) -> io::Result<WetSurface> {
    let wall = wall.around(centre_line(case));
    let regions = analysis::regions(case).into_iter();
    match case.own() {
        Some(own) if regions.into_iter().any(|region| region.is_on_patch()) => {
            if let Some(tree) = &own.tree {
                let meshes = Tree::meshes(tree).map_err(io::Error::other)?;
                let wall = wall.on_patches(&meshes.surface, &tree.walls());
                return Ok(wall.along_branches(&meshes.lines));
            }
            let mesh = PolyMesh::read(&files.fluid()).map_err(io::Error::other)?;
            Ok(wall.on_patches(&mesh, &own.fluid.patches))
        }
        _ => Ok(wall),
    }
}

/// The folder, next to a run's own evaluation, for that of another window.
pub fn window_files(files: &RunFiles, window: Window) -> RunFiles {
    let Window { start_s, end_s } = window;
    RunFiles::new(&files.root().join(format!("window-{start_s}-to-{end_s}")))
}

/// Evaluates a run again from its stored wall, over another window if one is given, and averages it over its beats at
/// `count` phases of the period; all of it goes `into` a folder, which is created, perhaps the run's own.
///
/// # Errors
/// If the run did not keep its wall, or a file cannot be read or written.
pub fn reevaluate(
    files: &RunFiles,
    into: &RunFiles,
    window: Option<Window>,
    count: Option<usize>,
) -> Result<HemodynamicsSummary, ResultsError> {
    let case = read_case(files)?;
    let steps = (case.time.period / case.time.step).round().max(1.0) as usize;
    if let Some(count) = count.filter(|count| !(1..=steps).contains(count)) {
        return Err(ResultsError(format!(
            "--phases {count}: expected 1 to {steps}, the steps of a period (time.period_s = {}, time.step_s = {})",
            case.time.period, case.time.step
        )));
    }
    let path = files.wall_history();
    if !path.is_file() {
        return Err(ResultsError(format!(
            "{} is not there: the run did not keep its wall (output.wall_history = false)",
            path.display()
        )));
    }
    let failed = |error: &dyn std::fmt::Display| {
        let root = files.root().display();
        ResultsError(format!("cannot evaluate {root}: {error}"))
    };
    let history: Vec<HistoryRow> = tables::read(&files.history()).map_err(|e| failed(&e))?;
    let times: Vec<f64> = history.iter().map(|row| row.time_s).collect();
    let reached = times.last().copied().unwrap_or(0.0);
    let window = window.unwrap_or_else(|| Windows::of(&case).at(reached));
    let gathered = wall_record::gather(&path, window, case.time.step, &times);
    let (wall, statistics) = gathered.map_err(|e| failed(&e))?;
    let wall = placed(wall, &case, files).map_err(|e| failed(&e))?;
    if statistics.steps == 0 {
        let Window { start_s, end_s } = window;
        return Err(failed(&format!(
            "the run has no step in {start_s} s < t <= {end_s} s; it has reached t = {reached} s"
        )));
    }
    let create = std::fs::create_dir_all(into.root()).map_err(named(into.root()));
    create.map_err(|e| failed(&e))?;
    let summary = evaluate(files, into, &case, &wall, &statistics).map_err(|e| failed(&e))?;
    if let Some(count) = count {
        phases::write(files, into, &case, window, count).map_err(|e| failed(&e))?;
    }
    Ok(summary)
}
