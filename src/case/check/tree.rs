//! Whether a vessel that branches is described completely.

use super::Report;
use crate::ConditionKeys;
use crate::Vec3;
use crate::tree::{BETWEEN, FAR, MAX_ENDS, WALL};
use crate::{Case, InitialWall, Solver, TreeKeys, TreeLine, VesselSide};

/// Radii of vessels, m.
const RADII: [f64; 2] = [1e-5, 0.05];
/// The radius of a single point that is larger than those of its neighbours by this factor is a mistake.
const BULGE: f64 = 4.0;

pub(super) fn check(case: &Case, tree: &TreeKeys, report: &mut Report<'_>) {
    if check_vessel(tree, report) {
        openings(case, tree, report);
        beginning(case, tree, report);
    }
}

/// What is said of the vessel, not of the blood in it. Whether its lines are known.
pub(super) fn check_vessel(tree: &TreeKeys, report: &mut Report<'_>) -> bool {
    for (key, core) in [
        ("tree.core", tree.core),
        ("tree.native.core", tree.elements().core),
    ] {
        report(
            &[key],
            core.is_some_and(|core| !core.is_multiple_of(2)),
            "branches meet along a line through the middle of the square: expected an even number"
                .into(),
        );
    }
    // What is wrong with lines that could not be read is known.
    if tree.line.is_none() {
        return false;
    }
    lines(tree, report);
    places(tree, report);
    surface(tree, report);
    names(tree, report);
    features(tree, report);
    true
}

/// Whether the branches of features are known.
fn features(tree: &TreeKeys, report: &mut Report<'_>) {
    let ends = tree.names();
    for (i, feature) in tree.feature.iter().flatten().enumerate() {
        report(
            &[&format!("tree.feature[{i}].branch")],
            !ends.iter().any(|end| end == feature.branch()),
            format!(
                "expected a branch with an end of its own, one of \"{}\"",
                ends.join("\", \"")
            ),
        );
    }
}

/// Whether all that is prescribed begins under the pressure of the wall's equilibrium.
fn beginning(case: &Case, tree: &TreeKeys, report: &mut Report<'_>) {
    let Some(InitialWall { pressure, .. }) = case.initial_wall() else {
        return;
    };
    for (i, keys) in tree.opening.iter().flatten().enumerate() {
        if tree.side(&keys.name) == VesselSide::Start {
            continue;
        }
        if let Some(("pressure_file", _)) = keys.condition.file() {
            let key = format!("tree.opening[{i}].pressure_file");
            report(
                &[&key],
                true,
                "a pressure that changes in time gives no equilibrium to start from: leave out [wall.initial], or write \
                 pressure_Pa here"
                    .into(),
            );
        } else if let Some((found, name)) = keys.condition.start_pressure() {
            report(
                &[
                    &format!("tree.opening[{i}].{name}"),
                    "wall.initial.pressure_Pa",
                ],
                found != pressure,
                format!(
                    "at t = 0 the blood is at rest under one pressure, wall.initial.pressure_Pa = {pressure:?}: expected the same here"
                ),
            );
        }
    }
}

/// The key that the lines come from.
pub(super) fn origin(tree: &TreeKeys) -> &'static str {
    match tree.lines {
        Some(_) => "tree.lines",
        None => "tree.line",
    }
}

fn lines(tree: &TreeKeys, report: &mut Report<'_>) {
    let lines = tree.line.as_deref().unwrap_or_default();
    let found = lines.len();
    report(
        &[origin(tree)],
        found < 2,
        format!(
            "expected the centre-lines of two branches at least, found {found}; a vessel of one is a table [vessel], \
             which fsi-driver new writes from the same file"
        ),
    );
    report(
        &[origin(tree)],
        found > MAX_ENDS,
        format!("expected at most {MAX_ENDS} ends, found {found}: leave out small branches"),
    );
    for (i, line) in lines.iter().enumerate() {
        let (points, radii) = (line.points.len(), line.radii.len());
        report(
            &[&format!("tree.line[{i}]")],
            radii != points || points < 2,
            format!(
                "expected a file, or two points at least and a radius for each, found {points} points and {radii} radii"
            ),
        );
        let same = line.points.windows(2).position(|pair| pair[0] == pair[1]);
        report(
            &[&format!("tree.line[{i}].points_m")],
            same.is_some(),
            format!(
                "points {} and the next one are the same: leave out one of the two",
                same.unwrap_or(0) + 1
            ),
        );
    }
}

/// Whether radii are those of vessels, and each line ends at another place.
fn places(tree: &TreeKeys, report: &mut Report<'_>) {
    let lines = tree.line.as_deref().unwrap_or_default();
    let [thin, wide] = RADII;
    let radii = || lines.iter().flat_map(|line| line.radii.iter().copied());
    let odd = radii().find(|r| !(thin..=wide).contains(r));
    let unit = match tree.unit {
        Some(unit) => format!(" in {}", unit.name()),
        None => String::new(),
    };
    report(
        &[origin(tree), "tree.unit"],
        odd.is_some(),
        format!(
            "a radius of {:e} m: vessels have {thin:e} to {wide} m; are the lengths{unit}?",
            odd.unwrap_or(0.0)
        ),
    );
    let names = tree.names();
    let told = |i: usize| names.get(i + 1).map_or("", String::as_str);
    let mut coordinates = lines.iter().flat_map(|line| line.points.iter().flatten());
    let far = coordinates.find(|x| x.abs() > FAR);
    report(
        &[origin(tree), "tree.unit"],
        far.is_some(),
        format!(
            "a coordinate is {:e} m: expected at most {FAR} m; correct it, or the unit",
            far.unwrap_or(&0.0)
        ),
    );
    let bulge = (0..lines.len()).find_map(|i| Some((i, bulge(&lines[i])?)));
    report(
        &[origin(tree)],
        bulge.is_some(),
        bulge.map_or(String::new(), |(i, point)| {
            let (radii, [x, y, z]) = (&lines[i].radii, lines[i].points[point]);
            format!(
                "at ({x:.4e}, {y:.4e}, {z:.4e}) m the line to \"{}\" has a radius of {:.3e} m, and {:.3e} and {:.3e} m at the \
                 points next to it, which lie within that: correct it",
                told(i),
                radii[point],
                radii[point - 1],
                radii[point + 1]
            )
        }),
    );
    let end = |i: usize| {
        let line = &lines[i];
        let x = line.points.last().map(|x| Vec3::from(*x));
        x.zip(line.radii.last().copied())
    };
    let is_same = |&(i, j): &(usize, usize)| match (end(i), end(j)) {
        (Some((x, r)), Some((y, q))) => (x - y).norm() < 0.1 * r.min(q),
        _ => false,
    };
    let pairs = (0..lines.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
    let same = pairs.clone().find(is_same);
    let (i, j) = same.unwrap_or((0, 0));
    report(
        &[origin(tree)],
        same.is_some(),
        format!(
            "the lines to \"{}\" and \"{}\" end at the same place: leave out one of them",
            told(i),
            told(j)
        ),
    );
}

/// A point of a line whose radius is far larger than those of its neighbours, although they lie within it.
fn bulge(line: &TreeLine) -> Option<usize> {
    let at = |i: usize| Some((Vec3::from(*line.points.get(i)?), *line.radii.get(i)?));
    (1..line.points.len()).find(|&i| {
        let (Some((x, radius)), Some(before), Some(after)) = (at(i), at(i - 1), at(i + 1)) else {
            return false;
        };
        let is_thin = |(y, other): (Vec3, f64)| radius > BULGE * other && (y - x).norm() < radius;
        is_thin(before) && is_thin(after)
    })
}

/// Whether triangles have the points that they name.
fn surface(tree: &TreeKeys, report: &mut Report<'_>) {
    let wrong = tree.lumen_surface().err();
    report(
        &["tree.lumen_triangles"],
        wrong.is_some(),
        wrong.map_or(String::new(), |fault| fault.to_string()),
    );
    for (key, is_given) in [
        ("tree.lumen_unit", tree.lumen_unit.is_some()),
        ("tree.lumen_smoothing_m", tree.lumen_smoothing.is_some()),
    ] {
        report(
            &[key],
            is_given && tree.lumen.is_none(),
            "there is no tree.lumen that it belongs to: leave it out".into(),
        );
    }
}

fn names(tree: &TreeKeys, report: &mut Report<'_>) {
    let key = match tree.outlets.is_empty() {
        true => origin(tree),
        false => "tree.outlets",
    };
    let ends = tree.line.iter().flatten().count();
    report(
        &[key],
        !tree.outlets.is_empty() && tree.outlets.len() != ends,
        format!(
            "expected a name for each of the {ends} ends, found {}",
            tree.outlets.len()
        ),
    );
    let names = tree.names();
    let is_allowed = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
    let is_name =
        |name: &str| name.chars().all(is_allowed) && !name.starts_with(WALL) && name != BETWEEN;
    let odd = names.iter().find(|name| !is_name(name));
    report(
        &[key],
        odd.is_some(),
        format!(
            "{:?} cannot be the name of an opening: expected letters, digits, _, - and ., and neither \"{WALL}\" nor \
             \"{BETWEEN}\"",
            odd.map_or("", String::as_str)
        ),
    );
    let twice = (names.iter().enumerate()).find(|(i, name)| names[..*i].contains(name));
    report(
        &[key],
        twice.is_some(),
        format!(
            "two openings are called {:?}",
            twice.map_or("", |(_, name)| name)
        ),
    );
    let unknown = (tree.closed.iter()).find(|name| !names[1..].contains(name));
    report(
        &["tree.closed"],
        unknown.is_some(),
        format!(
            "no line ends at {:?}; they end at \"{}\"",
            unknown.map_or("", String::as_str),
            names[1..].join("\", \"")
        ),
    );
    report(
        &["tree.closed"],
        unknown.is_none() && tree.open_names().len() < 2,
        "all lines end closed: where does the blood leave? Leave one of the names out".into(),
    );
}

fn openings(case: &Case, tree: &TreeKeys, report: &mut Report<'_>) {
    let period = case.time.period;
    let names = tree.open_names();
    let listed = format!("\"{}\"", names.join("\", \""));
    let given = tree.opening.as_deref().unwrap_or_default();
    let path = |i: usize, name: &str| format!("tree.opening[{i}].{name}");
    for (i, keys) in given.iter().enumerate() {
        let path = |name: &str| path(i, name);
        report(
            &[&path("name")],
            !names.contains(&keys.name),
            format!("no opening is called {:?}; there is {listed}", keys.name),
        );
        report(
            &[&path("name")],
            given[..i].iter().any(|other| other.name == keys.name),
            "what is prescribed at this opening is said twice: leave out one of the two".into(),
        );
        for (wrong, reason) in keys.condition.mistakes(tree.side(&keys.name), period) {
            let wrong: Vec<String> = wrong.into_iter().map(path).collect();
            let wrong: Vec<&str> = wrong.iter().map(String::as_str).collect();
            report(&wrong, true, reason);
        }
    }
    let is_open = |name: &&String| !given.iter().any(|keys| keys.name == **name);
    let open: Vec<&str> = (names.iter().filter(is_open)).map(String::as_str).collect();
    // One that is called wrongly may be meant for this opening.
    let misnamed = given.iter().filter(|keys| !names.contains(&keys.name));
    report(
        &[origin(tree)],
        open.len() > misnamed.count(),
        format!(
            "what is prescribed at \"{}\"? Add a table [[tree.opening]] with its name and a condition",
            open.join("\", \"")
        ),
    );
    let inflow = given
        .iter()
        .find(|keys| tree.side(&keys.name) == VesselSide::Start);
    let shares = given
        .iter()
        .position(|keys| matches!(keys.condition, ConditionKeys::FlowSplit { .. }));
    report(
        &[&path(shares.unwrap_or(0), "condition")],
        case.fluid.solver == Solver::Native
            && shares.is_some()
            && inflow.is_some_and(|keys| !keys.condition.is_flow()),
        "the driver's own solver takes a share of an inflow that is prescribed: give the opening where the lines begin a flow, \
         or this one a pressure, a resistance or a windkessel"
            .into(),
    );
    let shared = given.iter().filter_map(|keys| match keys.condition {
        ConditionKeys::FlowSplit { fraction } => Some(fraction),
        _ => None,
    });
    let shared: f64 = shared.sum();
    report(
        &[&path(shares.unwrap_or(0), "fraction")],
        shared > 1.0 + 1e-9,
        format!("the shares of all openings add up to {shared}: expected 1 at most"),
    );
    report(
        &[origin(tree)],
        open.is_empty() && given.iter().all(|keys| keys.condition.is_flow()),
        "the flow is prescribed at all openings, so nothing says what the pressure is: give one of them a pressure, a resistance \
         or a windkessel"
            .into(),
    );
}
