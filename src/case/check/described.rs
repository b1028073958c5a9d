//! Whether centre-line, sections, materials and features of a vessel fit together.

use super::{Report, material};
use crate::Vec3;
use crate::case::{
    BloodVessel, CurvePiece, Feature, GivenShape, InletEnd, RIGID_SHARE, VesselDescription,
    VesselEnd,
};
use crate::curve::SpaceCurve;

/// Places along the vessel that are looked at.
const SAMPLES: usize = 600;
/// What is said of a line whose bends are too sharp for the wall.
pub const TOO_SHARP: &str = "the radius of the bend must be at least";
/// Lengths of vessels, m.
const LENGTHS: [f64; 2] = [1e-4, 5.0];
/// Radii of vessels, m.
const RADII: [f64; 2] = [1e-5, 0.05];
/// The wall may come so close to its centre of curvature, relative to the radius of that.
const MOST_BEND: f64 = 0.9;
/// A centre-line turns back where its direction changes by more than this between two points, degrees.
const MOST_TURN_DEG: f64 = 100.0;
/// Lengths of sections may miss that of the centre-line by this share.
const TOLERANCE: f64 = 1e-3;

pub(super) fn check(vessel: &BloodVessel, keys: &VesselDescription, report: &mut Report<'_>) {
    let mut clean = true;
    let mut watched = |keys: &[&str], nonsense: bool, message: String| {
        clean &= !nonsense;
        report(keys, nonsense, message);
    };
    centre_line(keys, &mut watched);
    materials(keys, &mut watched);
    for (i, section) in keys.section.iter().enumerate() {
        layers(
            keys,
            i,
            &format!("vessel.section[{i}]"),
            section,
            &mut watched,
        );
    }
    match keys.is_rigid() {
        true => of_elastic_walls(vessel, &mut watched),
        false => of_straight_ones(vessel, keys, &mut watched),
    }
    // What follows needs a curve; a file that cannot be read has been reported.
    let is_there = keys.points.len() > 1 || keys.piece.as_ref().is_some_and(|all| !all.is_empty());
    if clean && is_there {
        along(keys, report);
    }
}

/// The key that the centre-line comes from.
fn origin(keys: &VesselDescription) -> &'static str {
    match keys {
        _ if keys.centre_line.is_some() => "vessel.centre_line",
        _ if !keys.points.is_empty() => "vessel.points_m",
        _ => "vessel.section[0].name",
    }
}

fn centre_line(keys: &VesselDescription, report: &mut Report<'_>) {
    let pieces = keys.piece.as_ref().map_or(0, Vec::len);
    let key = origin(keys);
    report(
        &[key],
        keys.centre_line.is_none() && keys.points.is_empty() && pieces == 0,
        "the vessel has no centre-line: give vessel.centre_line (a file), vessel.points_m, or tables [[vessel.piece]]".into(),
    );
    report(
        &[key],
        !keys.points.is_empty() && pieces > 0,
        "the case has tables [[vessel.piece]] as well: leave out one of the two".into(),
    );
    report(
        &["vessel.points_m"],
        keys.points.len() == 1,
        "a centre-line needs 2 points at least".into(),
    );
    report(
        &["vessel.angle_zero"],
        !keys.first.is_empty() && (keys.first.len() != 3 || keys.first.iter().all(|x| *x == 0.0)),
        "expected the three components of a direction, not all zero".into(),
    );
    report(
        &["vessel.unit"],
        keys.unit.is_some() && keys.centre_line.is_none() && keys.lumen.is_none(),
        "the unit is that of the file vessel.centre_line, and there is none; all other lengths are in metres".into(),
    );
    report(
        &["vessel.radii_m"],
        keys.centre_line.is_none()
            && !keys.radii.is_empty()
            && keys.radius.is_none()
            && keys.radii.len() != keys.points.len(),
        format!(
            "expected as many radii as vessel.points_m has points, {}",
            keys.points.len()
        ),
    );
    let has_table = keys.lumen.is_some() || !keys.lumen_radii.is_empty();
    table(keys, report);
    let has_radius =
        has_table || keys.radius.is_some() || keys.end_radius.is_some() || !keys.radii.is_empty();
    report(
        &[
            key,
            "vessel.radius_m",
            "vessel.radii_m",
            "vessel.lumen_radii_m",
        ],
        !has_radius
            && (!keys.points.is_empty() || pieces > 0)
            && keys.section.iter().any(|section| section.radius.is_none()),
        "the vessel has no radius: give vessel.radius_m, a file with a column r, or radius_m to each section".into(),
    );
    report(
        &["vessel.end_radius_m"],
        keys.end_radius.is_some() && (keys.radius.is_none() || !keys.radii.is_empty()),
        "a taper needs vessel.radius_m where it begins, and no other radii".into(),
    );
    report(
        &["vessel.radius_m"],
        keys.radius.is_some() && !keys.radii.is_empty(),
        "the case has vessel.radii_m as well: leave out one of the two".into(),
    );
    let points = keys.curve_points();
    if let Some(i) = points
        .windows(2)
        .position(|pair| (pair[1] - pair[0]).norm() < 1e-9)
    {
        let message = format!(
            "points {} and {} coincide: leave out one of them",
            i + 1,
            i + 2
        );
        report(&[key], true, message);
        return;
    }
    let turn = |three: &[Vec3]| {
        (three[2] - three[1])
            .angle(&(three[1] - three[0]))
            .to_degrees()
    };
    if let Some(i) = points
        .windows(3)
        .position(|three| turn(three) > MOST_TURN_DEG)
    {
        report(
            &[key],
            true,
            format!(
                "the centre-line turns back at point {} by {:.0}°: are the points of one branch, in the order in which the blood \
                 passes them? What scatters is smoothed by vessel.smoothing_m",
                i + 2,
                turn(&points[i..i + 3])
            ),
        );
    }
    let polygon: f64 = points
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).norm())
        .sum();
    let [short, long] = LENGTHS;
    let is_long = points.len() > 1 && !(short..=long).contains(&polygon);
    report(
        &[key],
        is_long,
        format!(
            "the centre-line is {polygon:.3e} m long, and vessels are {short} to {long} m long: is the unit of the file the right \
             one?"
        ),
    );
    let all = keys
        .radii
        .iter()
        .chain(&keys.radius)
        .chain(&keys.end_radius);
    let all = all.chain(
        keys.section
            .iter()
            .filter_map(|section| section.radius.as_ref()),
    );
    let all = all.chain(keys.lumen_radii.iter().flatten());
    let [thin, wide] = RADII;
    let odd = all.copied().find(|radius| !(thin..=wide).contains(radius));
    // What is wrong with the unit of a file is said once.
    if let Some(radius) = odd.filter(|_| !is_long) {
        let from_table = keys.lumen_radii.iter().flatten().any(|r| *r == radius);
        let from_file = keys.centre_line.is_some() && keys.radii.contains(&radius);
        let key = match keys
            .section
            .iter()
            .position(|section| section.radius == Some(radius))
        {
            Some(i) => format!("vessel.section[{i}].radius_m"),
            None if keys.lumen.is_some() && from_table => "vessel.lumen".into(),
            None if from_table => "vessel.lumen_radii_m".into(),
            None if from_file => "vessel.centre_line".into(),
            None if keys.radii.contains(&radius) => "vessel.radii_m".into(),
            None if keys.radius == Some(radius) => "vessel.radius_m".into(),
            None => "vessel.end_radius_m".into(),
        };
        report(
            &[&key],
            true,
            format!(
                "a radius of {radius:.3e} m: vessels have {thin:e} to {wide} m; is it in another unit ({})?",
                if from_file || from_table && keys.lumen.is_some() {
                    "vessel.unit"
                } else {
                    "_m means metres"
                }
            ),
        );
    }
}

/// What is of files alone, and a lumen that is not a circle.
fn table(keys: &VesselDescription, report: &mut Report<'_>) {
    let of_files = [
        ("vessel.branch", keys.branch.is_some()),
        ("vessel.reverse", keys.is_reversed.is_some()),
    ];
    for (key, is_given) in of_files {
        let message =
            "is for lines from a file, vessel.centre_line, and there is none: leave it out";
        report(
            &[key],
            is_given && keys.centre_line.is_none(),
            message.into(),
        );
    }
    for (key, is_given) in [
        ("vessel.smoothing_m", keys.smoothing.is_some()),
        ("vessel.least_bend_m", keys.least_bend.is_some()),
    ] {
        report(
            &[key],
            is_given && keys.centre_line.is_none() && keys.points.is_empty(),
            "smooths points of the centre-line, and there are none: leave it out".into(),
        );
    }
    for (key, is_given) in [
        ("vessel.lumen_unit", keys.lumen_unit.is_some()),
        ("vessel.lumen_smoothing_m", keys.lumen_smoothing.is_some()),
    ] {
        let message = "is for a surface from a file, vessel.lumen, and there is none: leave it out";
        report(&[key], is_given && keys.lumen.is_none(), message.into());
    }
    report(
        &["vessel.lumen"],
        keys.lumen.is_some() && keys.lumen_unit.or(keys.unit).is_none(),
        "expected its unit of length next to it: vessel.lumen_unit = \"mm\", \"m\", \"cm\" or \"um\"".into(),
    );
    let (name, has_table) = match keys.lumen {
        Some(_) => ("vessel.lumen", true),
        None => ("vessel.lumen_radii_m", !keys.lumen_radii.is_empty()),
    };
    for (other, is_given) in [
        ("vessel.radius_m", keys.radius.is_some()),
        (
            "vessel.radii_m",
            !keys.radii.is_empty() && keys.centre_line.is_none(),
        ),
    ] {
        let message = format!("the radius comes from {name} already: leave out one of the two");
        report(&[other], has_table && is_given, message);
    }
    if let Some(i) = keys
        .section
        .iter()
        .position(|section| section.radius.is_some())
    {
        let message = format!("the radius of all sections comes from {name}: leave this one out");
        report(
            &[&format!("vessel.section[{i}].radius_m")],
            has_table,
            message,
        );
    }
}

fn materials(keys: &VesselDescription, report: &mut Report<'_>) {
    for (i, named) in keys.materials().iter().enumerate() {
        material(&format!("vessel.material[{i}]"), &named.material, report);
        let twice = keys.materials()[..i]
            .iter()
            .any(|other| other.name == named.name);
        report(
            &[&format!("vessel.material[{i}].name")],
            twice,
            "another material has this name: choose a different one".into(),
        );
    }
}

fn layers(
    keys: &VesselDescription,
    i: usize,
    table: &str,
    section: &crate::case::VesselSection,
    report: &mut Report<'_>,
) {
    let key = |name: &str| format!("{table}.{name}");
    let twice = keys.section[..i]
        .iter()
        .any(|other| other.name == section.name);
    report(
        &[&key("name")],
        twice,
        "another section has this name: choose a different one".into(),
    );
    let (thicknesses, shares) = (section.thicknesses.len(), section.shares.len());
    if !section.is_elastic() {
        let walls = [
            ("layers", section.layers.len()),
            ("thicknesses_m", thicknesses),
            ("thicknesses", shares),
        ];
        if let Some((name, _)) = walls.into_iter().find(|(_, count)| *count > 0) {
            let message = format!(
                "a rigid section has no layers: leave it out, or wall = \"rigid\" of {}",
                section.name
            );
            report(&[&key(name)], true, message);
        }
        return;
    }
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

/// What is for elastic walls.
fn of_elastic_walls(vessel: &BloodVessel, report: &mut Report<'_>) {
    let (tissue, ends) = (vessel.surroundings.as_ref(), vessel.ends.as_ref());
    for (key, is_given) in [
        ("ends.inlet", ends.is_some_and(|ends| ends.inlet.is_some())),
        (
            "ends.outlet",
            ends.is_some_and(|ends| ends.outlet.is_some() || ends.spring.is_some()),
        ),
        ("initial.axial_stretch", vessel.axial_stretch() != 1.0),
        ("initial.shape", vessel.given_shape() == GivenShape::Loaded),
        (
            "surroundings.spring_Pa_m",
            tissue.is_some_and(|tissue| tissue.spring.is_some()),
        ),
        (
            "surroundings.damping_Pa_s_m",
            tissue.is_some_and(|tissue| tissue.damping.is_some()),
        ),
        (
            "surroundings.axial_spring_Pa_m",
            tissue.is_some_and(|tissue| tissue.axial_spring.is_some()),
        ),
        (
            "surroundings.axial_damping_Pa_s_m",
            tissue.is_some_and(|tissue| tissue.axial_damping.is_some()),
        ),
        (
            "surroundings.pressure_Pa",
            tissue.is_some_and(|tissue| tissue.pressure.is_some()),
        ),
    ] {
        let message = "is for an elastic wall, and all sections of this vessel have wall = \"rigid\": leave it out";
        report(&[key], is_given, message.into());
    }
}

/// What is for vessels along the x-axis alone, where the arc length is x: a line from the origin on, with the first
/// elastic section at its beginning.
fn of_straight_ones(vessel: &BloodVessel, keys: &VesselDescription, report: &mut Report<'_>) {
    let is_line = |piece: &CurvePiece| matches!(piece, CurvePiece::Line { .. });
    let pieces = keys.piece.as_deref().unwrap_or_default();
    let begins_elastic = (keys.section.first()).is_some_and(|section| section.is_elastic());
    if !pieces.is_empty() && pieces.iter().all(is_line) && begins_elastic {
        return;
    }
    stretch_of_curved_ones(vessel, keys, report);
    const STRAIGHT: &str =
        "is for vessels of straight [[vessel.piece]] that begin with an elastic section";
    report(
        &["ends.inlet"],
        vessel.inlet_end() != InletEnd::Clamped,
        format!("{STRAIGHT}; the inlet of this one is \"clamped\""),
    );
    report(
        &["ends.outlet"],
        matches!(
            vessel.outlet_end().0,
            VesselEnd::Sliding | VesselEnd::Radial
        ),
        format!("{STRAIGHT}; the ends of this one are \"clamped\", or the outlet on \"springs\""),
    );
}

/// A curved vessel is stretched as an image shows it: its unloaded form, more curved and shorter, is found. What was
/// unloaded and given would leave its centre-line, along which tissue, places and sections are described.
fn stretch_of_curved_ones(vessel: &BloodVessel, keys: &VesselDescription, report: &mut Report<'_>) {
    if vessel.axial_stretch() == 1.0 {
        return;
    }
    report(
        &["initial.axial_stretch", "initial.shape"],
        vessel.given_shape() != GivenShape::Loaded,
        "a curved vessel leaves its centre-line when it is stretched, so its stretched shape must be the given one: write \
         initial.shape = \"loaded\""
            .into(),
    );
    let tissue = vessel.surroundings.as_ref();
    let is_held = tissue.is_some_and(|t| t.spring.is_some() || t.axial_spring.is_some());
    report(
        &["initial.axial_stretch", "surroundings.at_rest"],
        is_held && !vessel.tissue_rests_loaded(),
        "tissue around a curved vessel that is stretched is at rest in the given shape: write surroundings.at_rest = \"loaded\""
            .into(),
    );
    report(
        &["initial.axial_stretch", "vessel.section"],
        keys.section.iter().any(|section| !section.is_elastic()),
        "a rigid section of a curved vessel does not move with the end of the elastic wall: make all sections elastic, or leave \
         the stretch out"
            .into(),
    );
}

/// Sections, features and the wall on the curve.
fn along(keys: &VesselDescription, report: &mut Report<'_>) {
    let key = origin(keys);
    let curve = keys.curve();
    let length = curve.ends()[1];
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
    if open > 1 || elastic.is_empty() || open == 1 && given >= length {
        return;
    }
    let places = keys.places(length);
    let start = places[elastic[0]][0];
    let last = elastic[elastic.len() - 1];
    regions(keys, places[last][1] - start, report);
    let law = keys.radius_law(&curve);
    let widest = keys.table_laws(length).map(|[_, largest]| largest);
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
    let mut thickest: Vec<(f64, f64)> = Vec::new();
    for i in 0..=SAMPLES {
        let s = length * i as f64 / SAMPLES as f64;
        let number = places
            .iter()
            .position(|place| s <= place[1])
            .unwrap_or(places.len() - 1);
        let section = &keys.section[number];
        let [from, to] = places[number];
        let lumen = section
            .radius
            .unwrap_or_else(|| widest.as_ref().unwrap_or(&law).at(s));
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
        thickest.push((s, lumen + wall + widened.sum::<f64>()));
    }
    features(keys, [-start, length - start], &law, start, report);
    if !curvature(key, &curve, &thickest, report) {
        crossing(key, &curve, &thickest, report);
    }
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
    law: &crate::interpolation::MonotoneCubic,
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
