//! Where the centre-line of a vessel and its radii come from, and whether they are those of a vessel.

use super::origin;
use crate::Vec3;
use crate::VesselDescription;
use crate::check::Report;

/// Lengths of vessels, m.
const LENGTHS: [f64; 2] = [1e-4, 5.0];
/// Radii of vessels, m.
pub(super) const RADII: [f64; 2] = [1e-5, 0.05];
/// A centre-line turns back where its direction changes by more than this between two points, degrees.
const MOST_TURN_DEG: f64 = 100.0;

pub(super) fn check(keys: &VesselDescription, report: &mut Report<'_>) {
    let key = origin(keys);
    sources(keys, key, report);
    table(keys, report);
    radius(keys, key, report);
    let points = keys.curve_points();
    if is_a_line(&points, key, report) {
        sizes(keys, &points, key, report);
    }
}

/// Where the centre-line comes from.
fn sources(keys: &VesselDescription, key: &str, report: &mut Report<'_>) {
    let pieces = keys.piece.as_ref().map_or(0, Vec::len);
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
}

/// One radius everywhere, a taper, or one at each point.
fn radius(keys: &VesselDescription, key: &str, report: &mut Report<'_>) {
    let pieces = keys.piece.as_ref().map_or(0, Vec::len);
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
}

/// Whether no two neighbours coincide; where the line turns back is reported as well.
fn is_a_line(points: &[Vec3], key: &str, report: &mut Report<'_>) -> bool {
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
        return false;
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
    true
}

/// Length and radii of a vessel in metres.
fn sizes(keys: &VesselDescription, points: &[Vec3], key: &str, report: &mut Report<'_>) {
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
    const LINES: &str =
        "is for lines from a file, vessel.centre_line, and there is none: leave it out";
    const POINTS: &str = "smooths points of the centre-line, and there are none: leave it out";
    const SURFACE: &str =
        "is for a surface from a file, vessel.lumen, and there is none: leave it out";
    let no_file = keys.centre_line.is_none();
    let no_points = no_file && keys.points.is_empty();
    #[rustfmt::skip]
    let lonely = [
        ("vessel.branch", keys.branch.is_some() && no_file, LINES),
        ("vessel.reverse", keys.is_reversed.is_some() && no_file, LINES),
        ("vessel.smoothing_m", keys.smoothing.is_some() && no_points, POINTS),
        ("vessel.least_bend_m", keys.least_bend.is_some() && no_points, POINTS),
        ("vessel.lumen_unit", keys.lumen_unit.is_some() && keys.lumen.is_none(), SURFACE),
        ("vessel.lumen_smoothing_m", keys.lumen_smoothing.is_some() && keys.lumen.is_none(), SURFACE),
    ];
    for (key, is_wrong, reason) in lonely {
        report(&[key], is_wrong, reason.into());
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
