//! Layers of the sections of a vessel, and how sections, features and the wall lie along its centre-line.

use super::line::RADII;
use super::{TOO_SHARP, origin};
use crate::Vec3;
use crate::check::Report;
use crate::curve::SpaceCurve;
use crate::interpolation::MonotoneCubic;
use crate::{Feature, RIGID_SHARE, VesselDescription, VesselSection};

/// Places along the vessel that are looked at.
const SAMPLES: usize = 600;
/// The wall may come so close to its centre of curvature, relative to the radius of that.
const MOST_BEND: f64 = 0.9;
/// Lengths of sections may miss that of the centre-line by this share.
const TOLERANCE: f64 = 1e-3;

/// Name, layers and thicknesses of a section.
pub(super) fn layers(keys: &VesselDescription, i: usize, report: &mut Report<'_>) {
    let section = &keys.section[i];
    let key = |name: &str| format!("vessel.section[{i}].{name}");
    let twice = (keys.section[..i].iter()).any(|other| other.name == section.name);
    report(
        &[&key("name")],
        twice,
        "another section has this name: choose a different one".into(),
    );
    if section.is_elastic() {
        elastic(keys, section, &key, report);
        return;
    }
    let walls = [
        ("layers", section.layers.len()),
        ("thicknesses_m", section.thicknesses.len()),
        ("thicknesses", section.shares.len()),
    ];
    if let Some((name, _)) = walls.into_iter().find(|(_, count)| *count > 0) {
        let message = format!(
            "a rigid section has no layers: leave it out, or wall = \"rigid\" of {}",
            section.name
        );
        report(&[&key(name)], true, message);
    }
}

/// Each layer of an elastic section is of a known material and has a thickness.
fn elastic(
    keys: &VesselDescription,
    section: &VesselSection,
    key: &dyn Fn(&str) -> String,
    report: &mut Report<'_>,
) {
    let (thicknesses, shares) = (section.thicknesses.len(), section.shares.len());
    report(
        &[&key("name"), &key("layers")],
        section.layers.is_empty(),
        "an elastic section needs its layers, such as layers = [\"media\"] and thicknesses_m = [1e-3]; or wall = \"rigid\"".into(),
    );
    let one = if thicknesses > 0 {
        "thicknesses_m"
    } else {
        "thicknesses"
    };
    let given = thicknesses.max(shares);
    report(
        &[&key("layers"), &key("thicknesses_m"), &key("thicknesses")],
        !section.layers.is_empty() && given == 0,
        format!(
            "the layers have no thickness: give thicknesses_m, or thicknesses as shares of the radius, {} of them",
            section.layers.len()
        ),
    );
    report(
        &[&key("thicknesses_m")],
        thicknesses > 0 && shares > 0,
        "the section has `thicknesses` as well: leave out one of the two".into(),
    );
    report(
        &[&key(one), &key("layers")],
        given > 0 && given != section.layers.len(),
        format!(
            "expected a thickness for each of the {} layers",
            section.layers.len()
        ),
    );
    let names: Vec<&str> = keys
        .materials()
        .iter()
        .map(|known| known.name.as_str())
        .collect();
    if let Some(layer) = (section.layers.iter()).find(|layer| !names.contains(&layer.as_str())) {
        report(
            &[&key("layers")],
            true,
            format!(
                "no [[vessel.material]] is called {layer:?}; there is {}",
                match names.is_empty() {
                    true => "none".into(),
                    false => format!("\"{}\"", names.join("\", \"")),
                }
            ),
        );
    }
    let thickest = section.thicknesses.iter().copied().fold(0.0, f64::max);
    report(
        &[&key("thicknesses_m")],
        thickest > RADII[1],
        format!("a layer of {thickest:?} m: is it in another unit (_m means metres)?"),
    );
}

/// Sections, features and the wall on the curve.
pub(super) fn along(keys: &VesselDescription, report: &mut Report<'_>) {
    let key = origin(keys);
    let curve = keys.curve();
    let length = curve.ends()[1];
    let has_places = lengths(keys, length, report);
    let elastic: Vec<usize> = (0..keys.section.len())
        .filter(|i| keys.is_evaluated(&keys.section[*i]))
        .collect();
    if let Some(gap) = elastic.windows(2).find(|pair| pair[1] != pair[0] + 1) {
        report(
            &[&format!("vessel.section[{}].wall", gap[0] + 1)],
            true,
            "a rigid section between elastic ones: rigid sections must be upstream or downstream of all elastic ones".into(),
        );
        return;
    }
    if !has_places || elastic.is_empty() {
        return;
    }
    let places = keys.places(length);
    let start = places[elastic[0]][0];
    let last = elastic[elastic.len() - 1];
    regions(keys, places[last][1] - start, report);
    let blend = keys.blend_length.unwrap_or(0.0);
    let lengths: Vec<f64> = places.iter().map(|[from, to]| to - from).collect();
    if let Some(i) = lengths.iter().position(|length| 0.5 * blend > *length)
        && places.len() > 1
    {
        let message = format!(
            "half of the blend must fit into each section, and {:?} is {:.3e} m long",
            keys.section[i].name, lengths[i]
        );
        report(&["vessel.blend_length_m"], true, message);
    }
    let law = keys.radius_law(&curve);
    let thickest = outside(keys, &places, &law, start, length);
    features(keys, [-start, length - start], &law, start, report);
    if !curvature(key, &curve, &thickest, report) {
        crossing(key, &curve, &thickest, report);
    }
}

/// The sections fill the centre-line. Whether each then has its place.
fn lengths(keys: &VesselDescription, length: f64, report: &mut Report<'_>) -> bool {
    let open = keys
        .section
        .iter()
        .filter(|section| section.length.is_none());
    let open = open.count();
    // A length that was refused is no length that was left out.
    let own: Vec<String> = (0..keys.section.len())
        .map(|i| format!("vessel.section[{i}].length_m"))
        .collect();
    let mut lengths = vec!["vessel.section[0].name"];
    lengths.extend(own.iter().map(String::as_str));
    let given: f64 = keys
        .section
        .iter()
        .filter_map(|section| section.length)
        .sum();
    report(
        &lengths,
        open > 1,
        format!(
            "{open} sections have no length_m: only one can take what the others leave of the centre-line's {length:.4e} m"
        ),
    );
    report(
        &lengths,
        open == 0 && (given / length - 1.0).abs() > TOLERANCE || open == 1 && given >= length,
        format!(
            "the sections are {given:.4e} m long together, and the centre-line {length:.4e} m: leave out the length_m of one of \
             them, or correct them"
        ),
    );
    open == 0 || open == 1 && given < length
}

/// How far the outside of the wall is from the centre-line at most: pairs of arc length and distance, m.
fn outside(
    keys: &VesselDescription,
    places: &[[f64; 2]],
    law: &MonotoneCubic,
    start: f64,
    length: f64,
) -> Vec<(f64, f64)> {
    let widest = keys.table_laws(length).map(|[_, largest]| largest);
    let at = |i: usize| {
        let s = length * i as f64 / SAMPLES as f64;
        let number = places
            .iter()
            .position(|place| s <= place[1])
            .unwrap_or(places.len() - 1);
        let section = &keys.section[number];
        let [from, to] = places[number];
        let lumen = section
            .radius
            .unwrap_or_else(|| widest.as_ref().unwrap_or(law).at(s));
        let mean = section.radius.unwrap_or_else(|| law.mean(from, to));
        let shares = match keys.is_rigid() {
            true => RIGID_SHARE,
            false => section.shares.iter().sum(),
        };
        let wall: f64 = section.thicknesses.iter().sum::<f64>() + mean * shares;
        let widened = keys
            .feature
            .iter()
            .flatten()
            .map(|feature| widening(feature, s - start));
        (s, lumen + wall + widened.sum::<f64>())
    };
    (0..=SAMPLES).map(at).collect()
}

/// Parts that are evaluated lie on the elastic part, which ends at this arc length (m), and have names of their own.
fn regions(keys: &VesselDescription, end: f64, report: &mut Report<'_>) {
    let regions = keys.region.as_deref().unwrap_or_default();
    for (i, region) in regions.iter().enumerate() {
        let key = |name: &str| format!("vessel.region[{i}].{name}");
        report(
            &[&key("to_m"), &key("from_m")],
            region.to <= region.from || region.to > end * (1.0 + 1e-9),
            format!(
                "expected more than from_m = {:?}, and at most {end:.4e}, where the elastic part ends",
                region.from
            ),
        );
        let sections = keys.section.iter().map(|section| &section.name);
        let mut others = sections.chain(regions[..i].iter().map(|other| &other.name));
        report(
            &[&key("name")],
            others.any(|other| *other == region.name),
            "a section or another region has this name: choose a different one".into(),
        );
    }
}

/// By how much a feature widens the outside at most.
fn widening(feature: &Feature, s: f64) -> f64 {
    match feature {
        Feature::Aneurysm {
            at,
            length,
            growth,
            eccentricity,
            ..
        } if (s - at).abs() < *length => growth * (1.0 + eccentricity.unwrap_or(0.0)),
        _ => 0.0,
    }
}

fn features(
    keys: &VesselDescription,
    [from, to]: [f64; 2],
    law: &MonotoneCubic,
    start: f64,
    report: &mut Report<'_>,
) {
    for (i, feature) in keys.feature.iter().flatten().enumerate() {
        let (Feature::Stenosis { at, length, .. } | Feature::Aneurysm { at, length, .. }) = feature;
        report(
            &[&format!("vessel.feature[{i}].at_m")],
            !(from..=to).contains(at),
            format!(
                "the vessel reaches from s = {from:.4e} to {to:.4e} m, counted from where its first elastic section begins"
            ),
        );
        let radius = law.at(at + start);
        report(
            &[&format!("vessel.feature[{i}].length_m")],
            *length < 0.5 * radius,
            format!(
                "so short a feature is a step: expected at least half the radius there, {:.3e} m",
                0.5 * radius
            ),
        );
    }
}

/// Nothing of the wall may reach its centre of curvature. Whether it does.
fn curvature(
    key: &str,
    curve: &SpaceCurve,
    thickest: &[(f64, f64)],
    report: &mut Report<'_>,
) -> bool {
    let bend = |(s, radius): &&(f64, f64)| curve.curvature(*s).norm() * radius;
    let Some(worst) = thickest.iter().max_by(|a, b| bend(a).total_cmp(&bend(b))) else {
        return false;
    };
    let (s, radius) = *worst;
    let reaches = bend(&worst) > MOST_BEND;
    report(
        &[key],
        reaches,
        format!(
            "the centre-line bends with the radius {:.3e} m at {s:.4e} m from its beginning, and the outside of the wall lies \
             {radius:.3e} m from it: {TOO_SHARP} {:.3} times that; round it off \
             (vessel.least_bend_m = {:.1e}), or make the wall thinner",
            1.0 / curve.curvature(s).norm(),
            1.0 / MOST_BEND,
            1.15 * radius
        ),
    );
    reaches
}

/// Parts that are far from each other along the vessel must not touch.
fn crossing(key: &str, curve: &SpaceCurve, thickest: &[(f64, f64)], report: &mut Report<'_>) {
    let points: Vec<Vec3> = thickest
        .iter()
        .map(|(s, _)| curve.frame(*s).origin)
        .collect();
    for (i, (s, radius)) in thickest.iter().enumerate() {
        for (j, (t, other)) in thickest.iter().enumerate().skip(i + 1) {
            // Neighbours on a bend are closer than along it, but no closer than half of that.
            let touching = (points[i] - points[j]).norm() < radius + other;
            if touching && t - s > std::f64::consts::PI * (radius + other) {
                report(
                    &[key],
                    true,
                    format!(
                        "the vessel crosses itself: {s:.4e} m and {t:.4e} m from its beginning the centre-line is {:.3e} m from \
                         itself, and the walls reach {:.3e} m",
                        (points[i] - points[j]).norm(),
                        radius + other
                    ),
                );
                return;
            }
        }
    }
}
