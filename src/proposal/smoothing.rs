//! How the lines of a tree are smoothed so that they have a mesh.

use super::ends::Ends;
use super::{ProposalInput, files};
use crate::case::{LengthUnit, TreeKeys};

/// What is tried, each further from the lines of the file: radii next to where branches part within which smooth curves
/// replace the lines, and waves that are halved, in mean radii.
const TRIED: [(f64, f64); 10] = [
    (0.0, 0.0),
    (2.0, 0.0),
    (0.0, 1.0),
    (0.0, 2.0),
    (2.0, 2.0),
    (0.0, 4.0),
    (2.0, 4.0),
    (0.0, 8.0),
    (2.0, 8.0),
    (0.0, 16.0),
];

/// How lines are smoothed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Smoothing {
    /// Which of those that are tried it is; none if it was given.
    pub way: Option<usize>,
    /// Radii next to where branches part within which smooth curves replace the lines.
    pub junctions: Option<f64>,
    /// Waves that are halved, m.
    pub waves: Option<f64>,
}

impl Smoothing {
    /// What the options say, or what is tried in turn for these lines, without waves that are longer than they are, and
    /// without what is known to lead to no mesh or to no wall.
    pub fn tried(input: &ProposalInput, ends: &Ends) -> Vec<Self> {
        if [input.smoothing, input.junction_smoothing] != [None; 2] {
            return vec![Self {
                way: None,
                junctions: input.junction_smoothing,
                waves: input.smoothing,
            }];
        }
        let positive = |x: f64| (x > 0.0).then_some(x);
        let radius = ends.range[1];
        let all = TRIED.iter().enumerate();
        let left = all.filter(|(way, _)| !input.ruled_out.contains(way));
        let possible = left.filter(|(_, (_, waves))| waves * radius <= ends.length);
        possible
            .map(|(way, (junctions, waves))| Self {
                way: Some(way),
                junctions: positive(*junctions),
                waves: positive(files::rounded(waves * radius)),
            })
            .collect()
    }

    /// Whether the lines are as they were given.
    pub fn is_none(self) -> bool {
        (self.junctions, self.waves) == (None, None)
    }

    /// Puts it into keys.
    pub fn put_into(self, keys: &mut TreeKeys) {
        (keys.junction_smoothing, keys.smoothing) = (self.junctions, self.waves);
    }

    /// What is to be said of it, unless it was given or nothing is smoothed.
    pub fn remark(self, input: &ProposalInput, unit: LengthUnit, ends: &Ends) -> Option<String> {
        if self.is_none() || self.way.is_none() {
            return None;
        }
        let waves = self
            .waves
            .map(|length| format!("waves of {:.2} mm of the lines are halved", 1e3 * length));
        let junctions = (self.junctions).map(|radii| {
            format!("smooth curves replace the lines within {radii} radii of where branches part")
        });
        let parts: Vec<String> = junctions.into_iter().chain(waves).collect();
        let [moved, radii] = self.moved(ends.keys(input, unit))?;
        Some(format!(
            "smoothing {}, since the lines as they are have no mesh or no wall: points move by up to {:.2} mm ({radii:.1} radii)",
            parts.join(", "),
            1e3 * moved
        ))
    }

    /// How far points of the lines that are kept move at most, m and in radii there.
    fn moved(self, mut keys: TreeKeys) -> Option<[f64; 2]> {
        let mut smooth = keys.clone();
        self.put_into(&mut smooth);
        keys.read().and_then(|()| smooth.read()).ok()?;
        let mut most = [0.0f64; 2];
        for (given, line) in keys.line.iter().flatten().zip(smooth.line.iter().flatten()) {
            let (given, line) = (given.curve()?, line.curve()?);
            for (x, radius) in given.points.iter().zip(&given.radii) {
                let distance = line.foot(x).distance;
                most[0] = most[0].max(distance);
                most[1] = most[1].max(distance / radius);
            }
        }
        Some(most)
    }
}
