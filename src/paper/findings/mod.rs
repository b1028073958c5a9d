//! What the paper found, and what a study found, judged from its numbers.

mod judge;

use super::runs::PaperStudy;
use crate::analysis::{BYPASS, MID_ARTERY};
use crate::output::report::PageTable;
use crate::output::report::page::{escape, table};
use judge::Judged;
pub use judge::series;

/// Differences between models that are smaller than this share of their values are not told from errors of the mesh.
const RESOLVED: f64 = 0.02;
/// Least coefficient of determination of what counts as linear.
const LINEAR: f64 = 0.98;
/// Least coefficient of determination of what counts as close to exponential.
const EXPONENTIAL: f64 = 0.9;
/// Values are nearly alike that differ by at most this share of the largest of their series.
const ALIKE: f64 = 0.1;

/// How a finding of the paper stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The numbers say the same.
    Agrees,
    /// They say something else.
    Disagrees,
    /// The differences are too small to tell.
    Unresolved,
    /// Models are missing.
    Missing,
}

impl Verdict {
    /// In words.
    fn words(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Disagrees => "disagrees",
            Self::Unresolved => "not resolved",
            Self::Missing => "not computed",
        }
    }

    fn html(self) -> String {
        let class = match self {
            Self::Agrees => "agrees",
            Self::Disagrees => "disagrees",
            Self::Unresolved => "unresolved",
            Self::Missing => "missing",
        };
        format!("<span class=\"{class}\">{}</span>", self.words())
    }

    fn of(agrees: bool) -> Self {
        if agrees {
            Self::Agrees
        } else {
            Self::Disagrees
        }
    }
}

/// A finding of the paper, next to that of the study.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperFinding {
    /// What the paper found.
    pub paper: &'static str,
    /// What the study found.
    pub ours: String,
    /// How they agree.
    pub verdict: Verdict,
    /// The section with the figure.
    pub section: &'static str,
}

/// All findings as a table.
pub fn html(study: &PaperStudy) -> String {
    let row = |finding: PaperFinding| {
        vec![
            format!("<span>{}</span>", escape(finding.paper)),
            format!("<span>{}</span>", escape(&finding.ours)),
            finding.verdict.html(),
            format!("<a href=\"#{}\">figure</a>", finding.section),
        ]
    };
    let rows: Vec<Vec<String>> = all(study).into_iter().map(row).collect();
    let (share, alike) = (100.0 * RESOLVED, 100.0 * ALIKE);
    format!(
        "<p>Judged from the numbers alone. Differences between models below {share} % of their values count as not resolved by \
         the mesh; linear means R² ≥ {LINEAR}, close to exponential R² ≥ {EXPONENTIAL} for the logarithm at equal phases of the \
         beat, nearly alike {alike} % of the largest value of the models. The middle of the artery is the paper's \
         0.03375 m ≤ x ≤ 0.05625 m.</p>\n<div class=\"findings\">{}</div>\n",
        table(
            &["what the paper found", "what this study found", "", ""],
            &rows
        )
    )
}

/// All findings, numbered, in words alone.
pub fn plain(study: &PaperStudy) -> PageTable {
    let mut table = PageTable::new(["", "what the paper found", "what this study found", ""]);
    for (i, finding) in all(study).into_iter().enumerate() {
        let verdict = finding.verdict.words().to_owned();
        table.push(vec![
            (i + 1).to_string(),
            finding.paper.to_owned(),
            finding.ours,
            verdict,
        ]);
    }
    table
}

/// All findings.
pub fn all(study: &PaperStudy) -> Vec<PaperFinding> {
    #[rustfmt::skip]
    let found = [
        ("periodicity", judge::periodicity(study),
            "Difference between successive periods of outflow and largest displacement decays close to exponentially and is small after the second period (fig. 11)."),
        ("flow", judge::balance(study),
            "The outflow lags behind the inflow; their difference is the rate of change of the lumen volume (fig. 11)."),
        ("influence", judge::linear(study, |r| r.mean_volume(), -1.0, "volume"),
            "The lumen volume of the artery falls linearly with d_max (fig. 14)."),
        ("influence", judge::linear(study, |r| r.mean_wall_shear_Pa.mean, 1.0, "mean wall shear stress"),
            "The mean wall shear stress of the artery grows linearly with d_max (fig. 14)."),
        ("influence", judge::monotonic(study),
            "The largest displacement depends monotonically on d_max (fig. 14)."),
        ("largest", judge::lowest_shear(study),
            "The lowest largest wall shear stress in the middle of the artery belongs to the largest d_max, whatever the extension (fig. 15)."),
        ("stress", judge::stress(study),
            "The largest von Mises stress in the middle of the artery grows with d_max although the wall thickens (fig. 16)."),
        ("stress", judge::stress_at_rest(study),
            "While the load is nearly constant at the end of the first period (0.5 s ≤ t ≤ 1 s), the smooth model has the largest von Mises stress (fig. 16)."),
        ("alike", judge::alike(study),
            "Where the lumen is locally wide, the OSI is raised: maps of radius and OSI look alike (fig. 17)."),
        ("osi", judge::osi_range(study, BYPASS, [0.2, 0.4], true),
            "The largest OSI in the bypass lies between 0.2 and 0.4 downstream of curved extensions (fig. 18)."),
        ("osi", judge::osi_range(study, MID_ARTERY, [0.005, 0.025], false),
            "The largest OSI in the artery, here its middle, lies between 0.005 and 0.025 (fig. 18)."),
        ("osi", judge::osi_order(study),
            "The largest OSI in the artery, here its middle, grows with d_max, whatever the extension; 0 and 0.25 mm are nearly alike (fig. 18)."),
        ("distance", judge::distance(study),
            "The influence of the extension's shape is gone after about five diameters."),
    ];
    let missing = || {
        (
            "the models for it have not been computed".into(),
            Verdict::Missing,
        )
    };
    let finding = |(section, judged, paper): (_, Judged, _)| {
        let (ours, verdict) = judged.unwrap_or_else(missing);
        PaperFinding {
            paper,
            ours,
            verdict,
            section,
        }
    };
    found.into_iter().map(finding).collect()
}
