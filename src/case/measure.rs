//! What a case adds to the measures of a study: `[[output.measure]]`.

use super::Case;
use super::schema::{ValueKind, from};
use crate::{table, words};

table! {
    /// A figure of a run: what a column of one of its tables has within the window.
    pub struct OutputMeasure {
        name: String = "name", ValueKind::Text(60), "name of the measure, with its unit";
        table: MeasureTable = "table", ValueKind::Word(MeasureTable::WORDS), "the table of a run", absent "history";
        at: Option<String> = "at", ValueKind::Text(30), "the opening, cross-section or region whose rows count", absent "none: the table is history";
        column: String = "column", ValueKind::Text(30), "column of the table";
        of: MeasureOf = "of", ValueKind::Word(MeasureOf::WORDS), "what counts of it", absent "mean";
        phase: Option<f64> = "phase", from(0.0, 1.0), "time since the beat began over time.period_s", absent "none: of is another word than at_phase";
    }
}

words! {
    /// A table of a run.
    #[derive(Default)]
    pub enum MeasureTable {
        /// history.csv.
        History = "history" (default),
        /// openings.csv.
        Openings = "openings",
        /// sections.csv.
        Sections = "sections",
        /// regions.csv: a region of the wall over time.
        Regions = "regions",
        /// hemodynamics.json: a region of the wall over the window, its mean and extremes in space.
        Wall = "wall",
    }
}

words! {
    /// What counts of a column within the window.
    #[derive(Default)]
    pub enum MeasureOf {
        /// Mean.
        Mean = "mean" (default),
        /// Smallest value.
        Lowest = "lowest",
        /// Largest value.
        Highest = "highest",
        /// Their difference.
        Range = "range",
        /// Value at a time within the last beat, linear between two steps.
        AtPhase = "at_phase",
    }
}

impl MeasureTable {
    /// Its columns with numbers, but for the time.
    pub fn columns(self) -> &'static [&'static str] {
        match self {
            Self::History => &[
                "coupling_iterations",
                "residual",
                "fluid_s",
                "structure_s",
                "Q_in_m3_s",
                "Q_out_m3_s",
                "p_in_Pa",
                "p_out_Pa",
                "lumen_volume_m3",
                "dVdt_m3_s",
                "max_displacement_m",
                "max_von_mises_Pa",
                "p_windkessel_Pa",
                "force_mismatch",
                "wall_velocity_mismatch_m_s",
                "wall_s",
            ],
            Self::Openings => &["flow_m3_s", "p_Pa", "p_model_Pa"],
            Self::Sections => &["flow_m3_s", "p_Pa", "area_m2"],
            Self::Regions => &[
                "mean_wall_shear_Pa",
                "max_wall_shear_Pa",
                "lumen_volume_m3",
                "max_displacement_m",
                "max_von_mises_Pa",
                "max_principal_Pa",
                "max_hoop_stress_Pa",
                "max_axial_stress_Pa",
                "max_fibre_stretch",
            ],
            Self::Wall => &["TAWSS_Pa", "OSI", "RRT_1_Pa"],
        }
    }
}

/// A key of a measure, and what is wrong with it.
type Mistake = (&'static str, String);

impl OutputMeasure {
    fn column_mistake(&self) -> Option<Mistake> {
        let columns = self.table.columns();
        let known = columns.contains(&self.column.as_str());
        (!known).then(|| ("column", format!("expected one of {}", columns.join(", "))))
    }

    fn of_mistake(&self) -> Option<Mistake> {
        let at_phase = self.of == MeasureOf::AtPhase;
        let (key, what) = match (at_phase, self.phase) {
            (true, _) if self.table == MeasureTable::Wall => (
                "of",
                "this table is of the whole window: take mean, lowest, highest or range",
            ),
            (true, None) => ("of", "it needs a phase: add phase, from 0 to 1"),
            (false, Some(_)) => (
                "phase",
                "only of = \"at_phase\" reads it: leave it out, or write that",
            ),
            (true, Some(_)) | (false, None) => return None,
        };
        Some((key, what.to_owned()))
    }

    /// `rows` are those that its table has more than one of at each time.
    fn at_mistake(&self, rows: Option<&Rows>) -> Option<Mistake> {
        let Some(Rows { of, names }) = rows else {
            let what = "the history is of the whole vessel: leave it out";
            return self.at.is_some().then(|| ("at", what.to_owned()));
        };
        let Some(at) = &self.at else {
            return Some(("column", format!("of which {of}? Add at = its name")));
        };
        let names = names.as_ref().filter(|names| !names.contains(at))?;
        let what = match names.is_empty() {
            true => format!("the case has no {of}"),
            false => format!("expected one of \"{}\"", names.join("\", \"")),
        };
        Some(("at", what))
    }
}

impl Case {
    /// The measures that it adds.
    pub fn measures(&self) -> &[OutputMeasure] {
        self.output.measure.as_deref().unwrap_or_default()
    }

    /// What is wrong with them, each with its key; `regions` are those of its wall. What openings a user-supplied
    /// OpenFOAM case has may stand in its mesh alone: its names are believed.
    pub fn measure_mistakes(&self, regions: &[String]) -> Vec<(String, String)> {
        let all = self.measures();
        let mut mistakes = Vec::new();
        for (i, measure) in all.iter().enumerate() {
            let same = all[..i].iter().any(|other| other.name == measure.name);
            let taken = same.then(|| {
                let what = "another measure has this name: choose a different one";
                ("name", what.to_owned())
            });
            let rows = self.rows_of(measure.table, regions);
            let found = taken.into_iter().chain(measure.column_mistake());
            let found = found.chain(measure.of_mistake());
            let found = found.chain(measure.at_mistake(rows.as_ref()));
            mistakes.extend(found.map(|(key, what)| (format!("output.measure[{i}].{key}"), what)));
        }
        mistakes
    }

    fn rows_of(&self, table: MeasureTable, regions: &[String]) -> Option<Rows> {
        let (of, names) = match table {
            MeasureTable::History => return None,
            MeasureTable::Openings => ("opening", self.opening_names()),
            MeasureTable::Sections => {
                let sections = self.output.section.iter().flatten();
                let names = sections.map(|section| section.name.clone()).collect();
                ("cross-section", Some(names))
            }
            MeasureTable::Regions | MeasureTable::Wall => ("region", Some(regions.to_vec())),
        };
        Some(Rows { of, names })
    }

    /// Names of its openings; none if they are in an OpenFOAM mesh alone.
    pub fn opening_names(&self) -> Option<Vec<String>> {
        if let Some(vessel) = self.vessel() {
            let openings = vessel.opening_keys();
            return Some(openings.iter().map(|keys| keys.name().to_owned()).collect());
        }
        match (self.tree(), self.own()) {
            (Some(tree), _) => Some(tree.open_names()),
            (None, Some(own)) if own.fluid.openings.is_empty() => None,
            (None, Some(own)) => Some(own.fluid.openings.clone()),
            (None, None) => Some(Vec::new()),
        }
    }
}

/// What the rows of a table are of, and their names, if they are known.
struct Rows {
    of: &'static str,
    names: Option<Vec<String>>,
}
