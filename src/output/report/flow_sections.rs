//! The blood in cross-sections: velocity along the axis in colours, velocity across it as arrows.

use super::flow_field::{LumenFlow, Snapshot};
use super::page::figure;
use crate::Vec3;
use crate::geometry::{self, Vessel};
use crate::output::figure::colour::Palette;
use crate::output::figure::section::{Arrow, FlowSection};
use crate::output::results::Results;

/// Arrows along the diameter.
const ARROWS: usize = 13;

/// Places along the vessel: at the beginning of the graft, at the joint, in the middle of the artery and at the end of
/// its evaluated part; in other vessels the middle of each section, or what lies a fifth from either end of a single
/// one.
fn places(run: &Results) -> Vec<(f64, String)> {
    let Some(vessel) = run.vessel.as_ref().map(Vessel::new) else {
        return Vec::new();
    };
    if let Some(keys) = run.case.anastomosis() {
        let (g, end) = (&keys.geometry, vessel.end());
        let joint = g.graft_length;
        return vec![
            (0.02 * joint, "beginning of the graft".into()),
            (joint, "joint".into()),
            (joint + 0.5 * g.artery_length, "middle of the artery".into()),
            (end - 0.125 * g.artery_length, "distal artery".into()),
        ];
    }
    let sections: Vec<&geometry::Section> = vessel.elastic_sections().collect();
    let shares: &[f64] = if sections.len() == 1 {
        &[0.2, 0.5, 0.8]
    } else {
        &[0.5]
    };
    let place = |section: &&geometry::Section| {
        let (from, length, name) = (
            section.from,
            section.to - section.from,
            section.name.clone(),
        );
        shares
            .iter()
            .map(move |share| (from + share * length, name.clone()))
    };
    sections.iter().flat_map(place).collect()
}

/// Cross-sections at these places at the time of the fastest flow.
pub fn sections(run: &Results, flow: &LumenFlow) -> Vec<String> {
    let frames = flow.frames.iter();
    let Some(frame) = frames.max_by(|a, b| a.fastest().total_cmp(&b.fastest())) else {
        return Vec::new();
    };
    let places = places(run);
    let half = 1.05 * flow.widest();
    let sampled = places.iter().map(|(x, _)| samples(flow, frame, *x, half));
    let sampled: Vec<Vec<([f64; 2], Vec3)>> = sampled.collect();
    let axial = sampled.iter().flatten().map(|(_, velocity)| velocity.x);
    let high = axial.fold(0.0, f64::max);
    let all: Vec<Vec<Arrow>> = sampled.iter().map(|found| arrows(found)).collect();
    let across = |arrow: &Arrow| arrow.vector[0].hypot(arrow.vector[1]);
    let longest = all.iter().flatten().map(across).fold(0.0, f64::max);
    let draw = |((x, name), arrows): ((f64, String), Vec<Arrow>)| {
        let field = |y: f64, z: f64| flow.velocity(frame, x, y, z).map_or(f64::NAN, |v| v.x);
        let svg = FlowSection {
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
            "Velocity at t = {:.3} s, seen against the stream. The longest arrow of these cross-sections is {:.2} cm/s across the axis.",
            frame.time,
            1e2 * longest
        );
        figure(&svg, &caption, None)
    };
    places.into_iter().zip(all).map(draw).collect()
}

/// Places in the cross-section at `x` and the velocity there.
fn samples(flow: &LumenFlow, frame: &Snapshot, x: f64, half: f64) -> Vec<([f64; 2], Vec3)> {
    let at = |i: usize| half * (2.0 * (i as f64 + 0.5) / ARROWS as f64 - 1.0);
    let places = (0..ARROWS * ARROWS).map(|i| [at(i % ARROWS), at(i / ARROWS)]);
    let sample = |[y, z]: [f64; 2]| Some(([y, z], flow.velocity(frame, x, y, z)?));
    places.filter_map(sample).collect()
}

fn arrows(samples: &[([f64; 2], Vec3)]) -> Vec<Arrow> {
    let arrow = |(at, velocity): &([f64; 2], Vec3)| Arrow {
        at: *at,
        vector: [velocity.y, velocity.z],
    };
    samples.iter().map(arrow).collect()
}
