//! The speed of the blood in a longitudinal cut.

use super::flow_field::{LumenFlow, Snapshot};
use super::page::figure;
use crate::Vec3;
use crate::output::figure::colour::Palette;
use crate::output::figure::map::{Map, Up};
use crate::output::results::Results;

/// Cuts along the centre-line through the angles 0 and 180°, one a frame.
pub fn cuts(run: &Results, flow: &LumenFlow) -> Vec<String> {
    let high = flow
        .frames
        .iter()
        .map(Snapshot::fastest)
        .fold(0.0, f64::max);
    let most = flow.widest();
    let draw = |frame: &Snapshot| {
        let field = |x: f64, y: f64| {
            let velocity = flow.velocity(frame, x, y, 0.0);
            velocity.as_ref().map_or(f64::NAN, Vec3::norm)
        };
        let svg = Map {
            title: format!("t = {:.3} s", frame.time),
            label: "speed / (m/s)".into(),
            field: &field,
            x: super::maps::whole(run),
            up: Up::Length([-1.05 * most, 1.05 * most]),
            range: [0.0, high],
            palette: Palette::sequential(),
            classes: Vec::new(),
            marks: Vec::new(),
        }
        .to_svg();
        figure(
            &svg,
            "Speed of the blood in the cut along the centre-line at the angles 0° (above) and 180° (below); lengths across are magnified.",
            None,
        )
    };
    flow.frames.iter().map(draw).collect()
}
