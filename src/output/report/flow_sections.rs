//! The blood in cross-sections: velocity along the axis in colours, velocity across it as arrows.

use super::flow_field::{LumenFlow, Snapshot};
use super::page::figure;
use crate::output::figure::colour::Palette;
use crate::output::figure::section::{Arrow, Section};
use crate::output::results::Results;

/// Arrows along the diameter.
const ARROWS: usize = 13;

/// Cross-sections at the beginning of the graft, at the joint, in the middle of the artery and at the end of its evaluated
/// part, at the time of the fastest flow.
pub fn sections(run: &Results, flow: &LumenFlow) -> Vec<String> {
    let frames = flow.frames.iter();
    let Some(frame) = frames.max_by(|a, b| a.fastest().total_cmp(&b.fastest())) else {
        return Vec::new();
    };
    let geometry = &run.vessel.geometry;
    let [_, end] = super::maps::whole(run);
    let joint = geometry.graft_length;
    let places = [
        (0.02 * joint, "beginning of the graft"),
        (joint, "joint"),
        (joint + 0.5 * geometry.artery_length, "middle of the artery"),
        (end - 0.125 * geometry.artery_length, "distal artery"),
    ];
    let half = 1.05 * flow.widest();
    let high = frame.velocities().iter().map(|v| v.x).fold(0.0, f64::max);
    let all = places.map(|(x, _)| arrows(flow, frame, x, half));
    let across = |arrow: &Arrow| arrow.vector[0].hypot(arrow.vector[1]);
    let longest = all.iter().flatten().map(across).fold(0.0, f64::max);
    let draw = |((x, name), arrows): ((f64, &str), Vec<Arrow>)| {
        let field = |y: f64, z: f64| flow.velocity(frame, x, y, z).map_or(f64::NAN, |v| v.x);
        let svg = Section {
            title: format!("{name}, x = {:.1} mm", 1e3 * x),
            label: "axial velocity / (m/s)".into(),
            field: &field,
            half,
            range: [0.0, high],
            palette: Palette::sequential(),
            arrows,
            unit: longest,
        }
        .to_svg();
        let caption = format!(
            "Velocity at t = {:.3} s, seen against the stream. The longest arrow of the four cross-sections is {:.2} cm/s across the axis.",
            frame.time,
            1e2 * longest
        );
        figure(&svg, &caption, None)
    };
    places.into_iter().zip(all).map(draw).collect()
}

fn arrows(flow: &LumenFlow, frame: &Snapshot, x: f64, half: f64) -> Vec<Arrow> {
    let at = |i: usize| half * (2.0 * (i as f64 + 0.5) / ARROWS as f64 - 1.0);
    let places = (0..ARROWS * ARROWS).map(|i| [at(i % ARROWS), at(i / ARROWS)]);
    let arrow = |[y, z]: [f64; 2]| {
        let velocity = flow.velocity(frame, x, y, z)?;
        Some(Arrow {
            at: [y, z],
            vector: [velocity.y, velocity.z],
        })
    };
    places.filter_map(arrow).collect()
}
