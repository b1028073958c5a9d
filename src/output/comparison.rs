//! Differences between two runs: of the same model, on different meshes or by different solvers, or of models with
//! other parameters.

use super::figure::colour::Palette;
use super::figure::map::{Map, Up};
use super::figure::{Curve, Figure, Panel, Scale};
use super::place_histories::{self, PlaceHistory};
use super::results::Results;
use super::tables::HistoryRow;
use super::wall_fields::FaceRow;
use super::write_atomically;
use crate::Vec3;
use crate::analysis;
use crate::case::value::shorten;
use crate::case::{Anastomosis, BloodVessel, Case, Shape, VesselDescription};
use crate::geometry::Vessel;
use crate::hemodynamics::{Place, Region, RegionExtent, Rings, WetSurface};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Why two runs cannot be compared.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ComparisonError(String);

/// A quantity of both runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunDifference {
    /// What, with its unit.
    pub quantity: &'static str,
    /// The region of a field, or the opening or cross-section of a history; empty for those of the whole run.
    pub region: String,
    /// Mean of the first run.
    pub mean_a: f64,
    /// Mean of the second.
    pub mean_b: f64,
    /// Root mean square of the difference: over time, or over the area.
    pub rms: f64,
    /// The same over the root mean square of the first.
    pub relative_rms: f64,
    /// Largest difference.
    pub largest: f64,
    /// What `relative_rms` may be (`rms` of the oscillating shear index).
    pub limit: Option<f64>,
}

impl RunDifference {
    /// Whether it is more than allowed.
    pub fn is_beyond(&self) -> bool {
        let measure = if self.quantity == OSI {
            self.rms
        } else {
            self.relative_rms
        };
        // Not a number is beyond any limit.
        let is_within = |limit| measure <= limit;
        self.limit.is_some_and(|limit| !is_within(limit))
    }

    /// What, and where.
    pub fn name(&self) -> String {
        match self.region.as_str() {
            "" => self.quantity.to_owned(),
            region => format!("{} ({region})", self.quantity),
        }
    }

    fn of(quantity: &'static str, region: String, limit: Option<f64>, pairs: &[[f64; 3]]) -> Self {
        let weight: f64 = pairs.iter().map(|p| p[2]).sum();
        let mean = |value: &dyn Fn(&[f64; 3]) -> f64| {
            pairs.iter().map(|p| value(p) * p[2]).sum::<f64>() / weight
        };
        let rms = mean(&|p| (p[0] - p[1]).powi(2)).sqrt();
        let size = mean(&|p| p[0].powi(2)).sqrt();
        Self {
            quantity,
            region,
            mean_a: mean(&|p| p[0]),
            mean_b: mean(&|p| p[1]),
            rms,
            relative_rms: if rms == 0.0 { 0.0 } else { rms / size },
            largest: pairs
                .iter()
                .map(|p| (p[0] - p[1]).abs())
                .fold(0.0, f64::max),
            limit,
        }
    }
}

type HistoryColumn = (&'static str, fn(&HistoryRow) -> f64);
type FaceColumn = (&'static str, fn(&FaceRow) -> f64);

const HISTORIES: [HistoryColumn; 6] = [
    ("outflow / m³/s", |row| row.Q_out_m3_s),
    ("inlet pressure / Pa", |row| row.p_in_Pa),
    ("outlet pressure / Pa", |row| row.p_out_Pa),
    ("lumen volume / m³", |row| row.lumen_volume_m3),
    ("largest displacement / m", |row| row.max_displacement_m),
    ("largest von Mises stress / Pa", |row| row.max_von_mises_Pa),
];
const OSI: &str = "OSI";
const RADIUS: &str = "mean radius / m";
const FIELDS: [FaceColumn; 4] = [
    ("TAWSS / Pa", |row| row.TAWSS_Pa),
    (RADIUS, |row| row.mean_radius_m),
    (OSI, |row| row.OSI),
    ("RRT / 1/Pa", |row| row.RRT_1_Pa),
];

/// Two runs compared.
pub struct Comparison {
    /// All quantities: histories first, then fields by region.
    pub differences: Vec<RunDifference>,
    /// Time (s) with both values of each history.
    histories: Vec<(&'static str, Vec<[f64; 3]>)>,
    walls: Option<[WallOf; 2]>,
    length: f64,
    names: [&'static str; 2],
    /// Keys whose values differ, with both, if the runs are of different models: nothing is judged then.
    differing: Vec<String>,
    /// What could not be compared, and why.
    notes: Vec<String>,
}

/// The fields of a run on its own mesh.
struct WallOf {
    rings: Rings,
    faces: Vec<FaceRow>,
}

impl WallOf {
    fn new(run: &Results) -> Result<Self, ComparisonError> {
        let place = |row: &FaceRow| Place::on_tube(row.x_m, row.phi_deg);
        let places: Vec<Place> = run.faces.iter().map(place).collect();
        let rings = Rings::new(&places).ok_or_else(|| {
            ComparisonError(format!(
                "the faces of the wall of {} do not lie in rings around the axis",
                run.files.root().display()
            ))
        })?;
        Ok(Self {
            rings,
            faces: run.faces.clone(),
        })
    }

    fn values(&self, field: fn(&FaceRow) -> f64) -> Vec<f64> {
        self.faces.iter().map(field).collect()
    }
}

impl Comparison {
    /// Compares two runs; the limits of histories, of fields, and of the oscillating shear index.
    ///
    /// # Errors
    /// If one is about a vessel and the other is not, or they have no common time, or were evaluated over different
    /// windows.
    pub fn new(
        a: &Results,
        b: &Results,
        [history, wall, osi]: [f64; 3],
    ) -> Result<Self, ComparisonError> {
        let differing = differing(a, b)?;
        let is_judged = differing.is_empty();
        let [history, wall, osi] = [history, wall, osi].map(|limit| is_judged.then_some(limit));
        let mut notes = Vec::new();
        let mut differences = Vec::new();
        let mut histories = Vec::new();
        for (quantity, value) in HISTORIES {
            let points = |run: &Results| -> Vec<(f64, f64)> {
                (run.history.iter().map(|row| (row.time_s, value(row)))).collect()
            };
            let pairs = common_history(&points(a), &points(b));
            if pairs.is_empty() {
                return Err(ComparisonError("the runs have no common time".into()));
            }
            // Stresses depend on the mesh more than all else: they are shown, not judged.
            let limit = history.filter(|_| !quantity.contains("von Mises"));
            let weighted: Vec<[f64; 3]> = pairs.iter().map(|p| [p[1], p[2], 1.0]).collect();
            differences.push(RunDifference::of(quantity, String::new(), limit, &weighted));
            histories.push((quantity, pairs));
        }
        differences.extend(at_places([a, b], history, &mut notes)?);
        let mut walls = None;
        let [first, second] = [a.hemodynamics.window, b.hemodynamics.window];
        let far = |x: f64, y: f64| (x - y).abs() > 0.5 * a.case.time.step;
        let is_apart = far(first.start_s, second.start_s) || far(first.end_s, second.end_s);
        if is_apart {
            let windows = format!(
                "the windows differ: {} s to {} s, and {} s to {} s; fsi-driver hemodynamics RUN --from S --to S --replace evaluates a run again",
                first.start_s, first.end_s, second.start_s, second.end_s
            );
            match is_judged {
                true => return Err(ComparisonError(windows)),
                false => notes.push(format!("the wall is left out: {windows}")),
            }
        }
        if !a.faces.is_empty() && !b.faces.is_empty() && !is_apart {
            let common_points = anywhere(a, b)?;
            if a.vessel.is_some() {
                walls = Some([WallOf::new(a)?, WallOf::new(b)?]);
            }
            let pairs = |region: &Region, value| match (&walls, &common_points) {
                (Some(both), _) => common_field(both, region, value),
                (None, Some(common_points)) => common_points.pairs([a, b], region, value),
                (None, None) => Vec::new(),
            };
            for region in analysis::regions(&a.case) {
                for (quantity, value) in FIELDS {
                    let limit = match quantity {
                        OSI => osi,
                        "RRT / 1/Pa" => None,
                        // There is no radius without a centre-line.
                        RADIUS if a.vessel.is_none() => continue,
                        _ => wall,
                    };
                    let pairs = pairs(&region, value);
                    let name = region.name.to_string();
                    if !pairs.is_empty() {
                        differences.push(RunDifference::of(quantity, name, limit, &pairs));
                    }
                }
            }
        }
        Ok(Self {
            differences,
            histories,
            walls,
            length: a
                .vessel
                .as_ref()
                .map_or(0.0, |vessel| Vessel::new(vessel).end()),
            names: ["A", "B"],
            differing,
            notes,
        })
    }

    /// With names for the two runs in figures, in place of A and B.
    pub fn called(self, names: [&'static str; 2]) -> Self {
        Self { names, ..self }
    }

    /// Names of the two runs.
    pub fn names(&self) -> [&'static str; 2] {
        self.names
    }

    /// Writes the table `table`, a figure of each history and maps of each field into `folder`.
    pub fn write(&self, folder: &Path, table: &str) -> std::io::Result<()> {
        for (name, svg) in self.figures() {
            write_atomically(&folder.join(format!("{name}.svg")), svg.as_bytes())?;
        }
        self.write_table(&folder.join(table))
    }

    /// Writes the table alone.
    pub fn write_table(&self, path: &Path) -> std::io::Result<()> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for difference in &self.differences {
            writer
                .serialize(difference)
                .map_err(std::io::Error::other)?;
        }
        let bytes = writer
            .into_inner()
            .map_err(|e| std::io::Error::other(e.to_string()))?;
        write_atomically(path, &bytes)
    }

    /// Names and texts of all figures.
    pub fn figures(&self) -> Vec<(String, String)> {
        let mut figures = Vec::new();
        let [first, second] = self.names;
        let file = |quantity: &str| quantity.split(" / ").next().unwrap_or("").replace(' ', "-");
        for (quantity, pairs) in &self.histories {
            let curve = |name: &str, value: fn(&[f64; 3]) -> f64, colour: usize| Curve {
                name: name.into(),
                points: pairs.iter().map(|p| (p[0], value(p))).collect(),
                colour,
                marker: None,
                open: colour == 1,
            };
            let panel = |title: &str, curves| Panel {
                title: title.into(),
                x_label: "time / s".into(),
                y_label: (*quantity).into(),
                scales: [Scale::Linear; 2],
                curves,
            };
            let both = vec![curve(first, |p| p[1], 2), curve(second, |p| p[2], 1)];
            let difference = vec![curve("", |p| p[2] - p[1], 0)];
            let figure = Figure {
                panels: vec![
                    panel("both runs", both),
                    panel(&format!("{second} − {first}"), difference),
                ],
                columns: 2,
            };
            figures.push((file(quantity), figure.to_svg()));
        }
        for (quantity, value) in FIELDS {
            let Some([a, b]) = &self.walls else { break };
            let (of_a, of_b) = (a.values(value), b.values(value));
            let high = of_a.iter().chain(&of_b).copied().filter(|v| v.is_finite());
            let high = high.fold(0.0, f64::max);
            let at_a = |x: f64, phi: f64| a.rings.value(&of_a, x, phi);
            let at_b = |x: f64, phi: f64| b.rings.value(&of_b, x, phi);
            let gap = |x: f64, phi: f64| at_b(x, phi) - at_a(x, phi);
            let faces = a.faces.iter().map(|f| gap(f.x_m, f.phi_deg).abs());
            let widest = faces.filter(|gap| gap.is_finite()).fold(1e-300, f64::max);
            let (one, two) = ([0.0, high], [-widest, widest]);
            let map = |title: &str, field, range, palette| Map {
                title: title.into(),
                label: quantity.into(),
                field,
                x: [0.0, self.length],
                up: Up::Angle,
                range,
                palette,
                classes: Vec::new(),
                marks: Vec::new(),
            };
            for map in [
                map(
                    first,
                    &at_a as &dyn Fn(f64, f64) -> f64,
                    one,
                    Palette::sequential(),
                ),
                map(second, &at_b, one, Palette::sequential()),
                map("difference", &gap, two, Palette::diverging()),
            ] {
                figures.push((
                    format!("map-{}-{}", file(quantity), map.title),
                    map.to_svg(),
                ));
            }
        }
        figures
    }
}

/// Differences of flows and pressures at the openings and cross-sections of both runs; `notes` says what one has alone.
fn at_places(
    runs: [&Results; 2],
    limit: Option<f64>,
    notes: &mut Vec<String>,
) -> Result<Vec<RunDifference>, ComparisonError> {
    let mut differences = Vec::new();
    let [places, others] = runs.map(place_histories::all);
    let unreadable = |e: std::io::Error| ComparisonError(e.to_string());
    let (places, others) = (places.map_err(unreadable)?, others.map_err(unreadable)?);
    for own in places {
        let is_same = |it: &&PlaceHistory| (it.quantity, &it.place) == (own.quantity, &own.place);
        let Some(other) = others.iter().find(is_same) else {
            notes.push(format!(
                "{} at \"{}\" is left out: one run has it alone",
                own.quantity, own.place
            ));
            continue;
        };
        let pairs = common_history(&own.points, &other.points);
        // The first step has no flow through cross-sections.
        if pairs.is_empty() {
            continue;
        }
        let weighted: Vec<[f64; 3]> = pairs.iter().map(|p| [p[1], p[2], 1.0]).collect();
        differences.push(RunDifference::of(own.quantity, own.place, limit, &weighted));
    }
    Ok(differences)
}

/// Times of the first run that both have, with both values; the second linear between its steps.
fn common_history(a: &[(f64, f64)], b: &[(f64, f64)]) -> Vec<[f64; 3]> {
    let mut common = Vec::new();
    for &(t, own) in a {
        let next = b.partition_point(|(time, _)| *time < t * (1.0 - 1e-9));
        let Some(&(after, value)) = b.get(next) else {
            break;
        };
        let other = match next.checked_sub(1).map(|i| b[i]) {
            _ if (after - t).abs() <= 1e-9 * t => value,
            Some((before, earlier)) => {
                let share = (t - before) / (after - before);
                (1.0 - share) * earlier + share * value
            }
            None => continue,
        };
        common.push([t, own, other]);
    }
    common
}

/// Values of both runs at the first one's faces in a region, with the area as weight.
fn common_field(
    [a, b]: &[WallOf; 2],
    region: &Region,
    value: fn(&FaceRow) -> f64,
) -> Vec<[f64; 3]> {
    let other = b.values(value);
    let RegionExtent::Along { from_m, to_m } = region.extent else {
        return Vec::new();
    };
    let inside = (a.faces.iter()).filter(|face| (from_m..=to_m).contains(&face.x_m));
    let pair = |face: &FaceRow| {
        let there = b.rings.value(&other, face.x_m, face.phi_deg);
        [value(face), there, face.area_m2]
    };
    inside.map(pair).collect()
}

/// The wall of a run, and the face of another one that is nearest to each of its faces.
struct Correspondence {
    wall: WetSurface,
    face: Vec<usize>,
}

impl Correspondence {
    /// Values of both runs at the first one's faces in a region, with the area as weight.
    fn pairs(
        &self,
        [a, b]: [&Results; 2],
        region: &Region,
        value: fn(&FaceRow) -> f64,
    ) -> Vec<[f64; 3]> {
        let faces = self.wall.shares(region).into_iter();
        let pair = |(face, share): (usize, f64)| {
            let (here, there) = (&a.faces[face], &b.faces[self.face[face]]);
            [value(here), value(there), share * here.area_m2]
        };
        faces.map(pair).collect()
    }
}

/// What corresponds on two walls of any shape; none if the runs have not kept them.
fn anywhere(a: &Results, b: &Results) -> Result<Option<Correspondence>, ComparisonError> {
    if a.vessel.is_some() {
        return Ok(None);
    }
    let unread = |e: std::io::Error| ComparisonError(format!("cannot read {e}"));
    let (Some(wall), Some(other)) = (a.wall().map_err(unread)?, b.wall().map_err(unread)?) else {
        return Ok(None);
    };
    let there: Vec<Vec3> = other.middles().collect();
    let nearest = |x: Vec3| {
        let distances = there.iter().map(|y| (y - x).norm_squared()).enumerate();
        let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.map_or(0, |(face, _)| face)
    };
    let face = wall.middles().map(nearest).collect();
    Ok(Some(Correspondence { wall, face }))
}

/// A part of the paper's vessel, if it is one.
fn part_of<T>(vessel: &BloodVessel, part: fn(&Anastomosis) -> &T) -> Option<&T> {
    vessel.anastomosis().map(part)
}

/// The description of a vessel that is not the paper's.
fn description(vessel: &BloodVessel) -> Option<&VesselDescription> {
    match &vessel.shape {
        Shape::Vessel(description) => Some(description),
        Shape::Anastomosis(_) => None,
    }
}

/// What differs in the cases of runs of different models: vessels or loads, not only mesh, solver and numerics.
fn differing(first: &Results, second: &Results) -> Result<Vec<String>, ComparisonError> {
    let (a, b) = (&first.case, &second.case);
    let mut parts = vec![
        ("wall", a.wall == b.wall),
        ("blood", a.blood == b.blood),
        ("ramp", a.ramp == b.ramp),
        ("time.period_s", a.time.period == b.time.period),
    ];
    match ([a.vessel(), b.vessel()], [a.own(), b.own()]) {
        ([Some(v), Some(w)], _) => parts.extend([
            (
                "model",
                part_of(v, |v| &v.model) == part_of(w, |w| &w.model),
            ),
            (
                "geometry",
                part_of(v, |v| &v.geometry) == part_of(w, |w| &w.geometry),
            ),
            ("wall", part_of(v, |v| &v.wall) == part_of(w, |w| &w.wall)),
            ("vessel", description(v) == description(w)),
            ("inflow", v.inflow == w.inflow),
            ("inlet", v.inlet == w.inlet),
            ("windkessel", v.windkessel == w.windkessel),
            ("outlet", v.outlet == w.outlet),
            ("opening", v.opening == w.opening),
        ]),
        // What the OpenFOAM case says is the user's.
        (_, [Some(v), Some(w)]) => parts.extend([
            ("fluid.patches", v.fluid.patches == w.fluid.patches),
            ("fluid.openings", v.fluid.openings == w.fluid.openings),
            ("wall.mode", v.wall.mode() == w.wall.mode()),
            ("wall.material", v.wall.material == w.wall.material),
            ("wall.support", v.wall.support == w.wall.support),
        ]),
        _ => {
            let what = "one run is about a vessel and the other about your own OpenFOAM case: they cannot be compared";
            return Err(ComparisonError(what.into()));
        }
    }
    if parts.iter().all(|(_, same)| *same) {
        return Ok(Vec::new());
    }
    let values = |case: &Case| -> BTreeMap<String, String> {
        let all = case.values_by_name().into_iter();
        let all = all.filter(|(path, ..)| !path.starts_with("output."));
        all.map(|(path, value)| (path, shorten(&value))).collect()
    };
    let [a, b] = [values(a), values(b)];
    let keys: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
    let shown = |value: Option<&String>| value.map_or("absent".to_owned(), Clone::clone);
    let line = |key: &&String| format!("{key}: {} and {}", shown(a.get(*key)), shown(b.get(*key)));
    let differs = |key: &&&String| a.get(**key) != b.get(**key);
    Ok(keys.iter().filter(differs).map(line).collect())
}

impl std::fmt::Display for Comparison {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if !self.differing.is_empty() {
            writeln!(
                f,
                "different models, so that nothing is judged; A and B have"
            )?;
            for line in &self.differing {
                writeln!(f, "  {line}")?;
            }
        }
        for note in &self.notes {
            writeln!(f, "{note}")?;
        }
        writeln!(
            f,
            "{:<42} {:>12} {:>12} {:>11} {:>9} {:>11} {:>8}",
            "quantity", "mean A", "mean B", "rms diff.", "relative", "largest", "limit"
        )?;
        for d in &self.differences {
            let limit = d.limit.map_or("-".into(), |limit| format!("{limit}"));
            let mark = if d.is_beyond() { "  BEYOND" } else { "" };
            writeln!(
                f,
                "{:<42} {:>12.5e} {:>12.5e} {:>11.3e} {:>9.2e} {:>11.3e} {:>8}{mark}",
                d.name(),
                d.mean_a,
                d.mean_b,
                d.rms,
                d.relative_rms,
                d.largest,
                limit
            )?;
        }
        Ok(())
    }
}
