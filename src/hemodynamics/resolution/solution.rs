//! What the solution of a run shows of its resolution.

use super::{Doubt, FlowNumbers, ResolutionFinding};
use crate::fluid::HighestModes;
use crate::hemodynamics::summary::WallFields;
use crate::hemodynamics::{WetSurface, WindowStatistics};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Share of the velocity that may stand in the highest polynomials of the elements at the wall ...
const AT_WALL: f64 = 0.025;
/// ... and of all elements.
const IN_DOMAIN: f64 = 0.02;
/// Root mean square of the difference between the wall shear of a face and that of its neighbours, as a share of its
/// mean. Cells have such jumps at the corners of their square (0.5 in a stenosis whose mean is known to 1 %), and are
/// not judged by them.
const JUMP: f64 = 0.3;

/// `summary.json`: how well the flow of a run is resolved.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Resolution {
    /// Sizes of the flow; absent where there is no vessel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub numbers: Option<FlowNumbers>,
    /// Root mean square of the highest polynomials' part of the velocity in the elements at the wall, relative to that
    /// of all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub highest_modes_at_wall: Option<f64>,
    /// The same in the whole domain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub highest_modes: Option<f64>,
    /// Root mean square of [`jumps`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jumps: Option<f64>,
    /// What is doubtful.
    pub findings: Vec<ResolutionFinding>,
}

impl Resolution {
    /// From what was gathered over the window of a run; `jumps` are those of its faces, `advice` says which keys make
    /// elements finer.
    pub fn new(
        numbers: Option<FlowNumbers>,
        fields: &WallFields,
        jumps: &[Option<f64>],
        statistics: &WindowStatistics,
        advice: &str,
    ) -> Self {
        let faces = || jumps.iter().zip(&fields.areas);
        let (mut area, mut squares) = (0.0, 0.0);
        for (jump, of_face) in faces().filter_map(|(jump, area)| Some(((*jump)?, area))) {
            area += of_face;
            squares += jump * jump * of_face;
        }
        let jumps = (area > 0.0).then(|| (squares / area).sqrt());
        let mut at_wall = HighestModes::default();
        for (modes, area) in statistics.modes_at_wall.iter().zip(&fields.areas) {
            at_wall.add(modes, *area);
        }
        let share = |modes: &HighestModes| (modes.all > 0.0).then(|| modes.share());
        let mut found = Self {
            numbers,
            highest_modes_at_wall: share(&at_wall),
            highest_modes: share(&statistics.modes),
            jumps,
            findings: numbers.map_or(Vec::new(), |numbers| numbers.findings()),
        };
        let shown = found.shown(advice).into_iter().flatten();
        found.findings.extend(shown.collect::<Vec<_>>());
        found
    }

    fn shown(&self, advice: &str) -> [Option<ResolutionFinding>; 3] {
        let finding = |value: Option<f64>, doubt, limit: f64, text: &dyn Fn(f64) -> String| {
            value
                .filter(|value| *value > limit)
                .map(|value| ResolutionFinding {
                    doubt,
                    value,
                    limit,
                    text: text(value),
                })
        };
        [
            finding(
                self.highest_modes_at_wall,
                Doubt::ElementsAtWall,
                AT_WALL,
                &|share| {
                    format!(
                        "{:.1} % of the velocity in the elements at the wall is in their highest polynomials; with more than {:.1} % errors of \
                     3 to 10 % were measured in the mean wall shear: {advice}",
                        100.0 * share,
                        100.0 * AT_WALL
                    )
                },
            ),
            finding(self.highest_modes, Doubt::Elements, IN_DOMAIN, &|share| {
                format!(
                    "{:.1} % of the velocity is in the highest polynomials of the elements; with more than {:.1} % errors of 5 to 10 % were \
                     measured: {advice}",
                    100.0 * share,
                    100.0 * IN_DOMAIN
                )
            }),
            finding(
                self.highest_modes.and(self.jumps),
                Doubt::Jumps,
                JUMP,
                &|share| {
                    format!(
                        "the wall shear jumps from face to face by {:.0} % of its mean (root mean square), more than {:.0} %: the mesh is too coarse \
                     for what its map shows, {advice}",
                        100.0 * share,
                        100.0 * JUMP
                    )
                },
            ),
        ]
    }
}

/// Difference between the time-averaged wall shear stress of each face and the mean of the faces next to it, as a share
/// of the mean over the wall; none of faces at a rim.
pub fn jumps(wall: &WetSurface, fields: &WallFields) -> Vec<Option<f64>> {
    let mut sides: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    let side = |face: &[u32], i: usize| {
        let [a, b] = [face[i], face[(i + 1) % face.len()]];
        [a.min(b), a.max(b)]
    };
    for (number, face) in wall.faces.iter().enumerate() {
        for i in 0..face.len() {
            sides.entry(side(face, i)).or_default().push(number);
        }
    }
    let shear = &fields.time_averaged;
    let area: f64 = fields.areas.iter().sum();
    let sum: f64 = fields.areas.iter().zip(shear).map(|(a, t)| a * t).sum();
    let jump = |(number, face): (usize, &Vec<u32>)| {
        let neighbours: Vec<f64> = (0..face.len())
            .flat_map(|i| &sides[&side(face, i)])
            .filter(|other| **other != number)
            .map(|other| shear[*other])
            .collect();
        let mean = neighbours.iter().sum::<f64>() / neighbours.len() as f64;
        (neighbours.len() == face.len() && sum > 0.0)
            .then(|| (shear[number] - mean).abs() / (sum / area))
    };
    wall.faces.iter().enumerate().map(jump).collect()
}
