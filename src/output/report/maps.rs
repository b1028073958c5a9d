//! Maps of the unrolled wall.

use super::page::figure;
use crate::analysis;
use crate::geometry::Vessel;
use crate::hemodynamics::{Place, RegionExtent, Rings, WetSurface};
use crate::output::figure::colour::Palette;
use crate::output::figure::map::{Map, Up};
use crate::output::results::Results;
use crate::output::wall_fields::FaceRow;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::io;

/// A field that maps show.
#[derive(Clone, Copy)]
pub struct MapField {
    /// Name with unit.
    pub label: &'static str,
    /// Name of files.
    pub file: &'static str,
    /// Value of a face.
    pub value: fn(&FaceRow) -> f64,
}

/// Time-averaged wall shear stress.
pub const TAWSS: MapField = MapField {
    label: "TAWSS / Pa",
    file: "TAWSS",
    value: |f| f.TAWSS_Pa,
};
/// Oscillating shear index.
pub const OSI: MapField = MapField {
    label: "OSI / 1",
    file: "OSI",
    value: |f| f.OSI,
};
/// Relative residence time.
pub const RRT: MapField = MapField {
    label: "RRT / (1/Pa)",
    file: "RRT",
    value: |f| f.RRT_1_Pa,
};
/// Mean radius of the lumen.
pub const RADIUS: MapField = MapField {
    label: "mean radius / mm",
    file: "radius",
    value: |f| 1e3 * f.mean_radius_m,
};

/// The colours of a map leave out the largest values beyond this share of the faces where they are so many times
/// as large.
const SHOWN: f64 = 0.95;
const FAR: f64 = 4.0;

/// A map of a field over a part of a run; `range`: values of the first and the last colour.
pub fn map(run: &Results, field: MapField, title: &str, x: [f64; 2], range: [f64; 2]) -> String {
    let values: Vec<f64> = run.faces.iter().map(field.value).collect();
    let inside = |f: &&FaceRow| (x[0]..=x[1]).contains(&f.x_m);
    let largest = run
        .faces
        .iter()
        .filter(inside)
        .max_by(|a, b| (field.value)(a).total_cmp(&(field.value)(b)));
    let marks = largest.map(|f| [f.x_m, f.phi_deg]).into_iter().collect();
    draw(&places(run), &values, title, field.label, x, range, marks)
}

/// Centres of the faces.
pub fn places(run: &Results) -> Vec<Place> {
    let place = |f: &FaceRow| Place::on_tube(f.x_m, f.phi_deg);
    run.faces.iter().map(place).collect()
}

pub(super) fn draw(
    places: &[Place],
    values: &[f64],
    title: &str,
    label: &str,
    x: [f64; 2],
    range: [f64; 2],
    marks: Vec<[f64; 2]>,
) -> String {
    let Some(rings) = Rings::new(places) else {
        return "<p>The faces do not lie in rings.</p>\n".into();
    };
    Map {
        title: title.into(),
        label: label.into(),
        field: &|x, phi| rings.value(values, x, phi),
        x,
        up: Up::Angle,
        range,
        palette: Palette::sequential(),
        classes: Vec::new(),
        marks,
    }
    .to_svg()
}

/// Least and largest value of a field in a part of some runs; `from_zero` begins at zero.
pub fn range(runs: &[&Results], field: MapField, x: [f64; 2], from_zero: bool) -> [f64; 2] {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for face in runs.iter().flat_map(|run| &run.faces) {
        let value = (field.value)(face);
        if (x[0]..=x[1]).contains(&face.x_m) && value.is_finite() {
            (low, high) = (low.min(value), high.max(value));
        }
    }
    [if from_zero { 0.0 } else { low }, high]
}

/// The whole deformable part of a vessel; nothing of what is none.
pub fn whole(run: &Results) -> [f64; 2] {
    let end = run.vessel.as_ref().map(|vessel| Vessel::new(vessel).end());
    [0.0, end.unwrap_or(0.0)]
}

/// The middle part of the artery, or the whole vessel if there is none.
pub fn middle(run: &Results) -> [f64; 2] {
    analysis::middle_of_artery(&run.case).unwrap_or_else(|| whole(run))
}

/// The values of a field on the faces as a table.
pub fn numbers(run: &Results, field: MapField) -> String {
    let mut csv = format!("x_m,phi_deg,\"{}\"\n", field.label);
    for face in &run.faces {
        let _ = writeln!(
            csv,
            "{:.6},{:.3},{:.6e}",
            face.x_m,
            face.phi_deg,
            (field.value)(face)
        );
    }
    csv
}

/// All fields of a run, over the whole wall and over the middle of the artery.
pub fn of_run(run: &Results, name: &str) -> Vec<String> {
    let fields = [(RADIUS, false), (TAWSS, true), (OSI, true), (RRT, true)];
    let parts = match run.case.anastomosis() {
        Some(_) => vec![
            ("graft and artery", whole(run)),
            ("middle of the artery", middle(run)),
        ],
        None => vec![("elastic part", whole(run))],
    };
    let mut figures = Vec::new();
    for (part, x) in parts {
        for (field, from_zero) in fields {
            // In the middle of the artery the differences are small.
            let range = range(&[run], field, x, from_zero && x == whole(run));
            let svg = map(run, field, &format!("{name}, {part}"), x, range);
            let caption = format!(
                "{} on the unrolled wall, {part}; the cross marks the largest value.",
                field.label
            );
            let csv = (x == whole(run)).then(|| (field.file, numbers(run, field)));
            figures.push(figure(&svg, &caption, csv));
        }
    }
    figures
}

/// Where the colours of a map end: at the largest of these values, or far below single ones that are much larger.
pub fn upper_end(mut values: Vec<f64>) -> (f64, bool) {
    values.sort_by(f64::total_cmp);
    let Some(&largest) = values.last() else {
        return (0.0, false);
    };
    let most = values[((values.len() - 1) as f64 * SHOWN) as usize];
    match largest > FAR * most {
        true => (most, true),
        false => (largest, false),
    }
}

/// Time-averaged shear, its oscillation and the relative residence time on each branch of a tree.
pub fn of_branches(run: &Results, branches: &[UnrolledPart]) -> Vec<String> {
    let mut figures = Vec::new();
    for branch in branches {
        for field in [TAWSS, OSI, RRT] {
            let values: Vec<f64> = run.faces.iter().map(field.value).collect();
            let own = branch.faces.iter().map(|&face| values[face]);
            let (upper, is_cut) = upper_end(own.collect());
            let svg = Map {
                title: branch.name.clone(),
                label: field.label.into(),
                field: &|x, phi| branch.value(&values, x, phi),
                x: branch.x,
                up: Up::Angle,
                range: [0.0, upper],
                palette: Palette::sequential(),
                classes: Vec::new(),
                marks: Vec::new(),
            }
            .to_svg();
            let mut caption = format!(
                "{} on the unrolled branch {}. x counts along the branch from where it begins; φ = 0° is across the plane of the \
                 junction.",
                field.label, branch.name
            );
            if is_cut {
                caption += " The colours end at the 95th percentile of the faces.";
            }
            let mut csv = format!("x_m,phi_deg,\"{}\"\n", field.label);
            for &face in &branch.faces {
                let Place { x_m, phi_deg, .. } = branch.place(face);
                let _ = writeln!(csv, "{x_m:.6},{phi_deg:.3},{:.6e}", values[face]);
            }
            let file = format!("{}-{}", field.file, branch.name);
            figures.push(figure(&svg, &caption, Some((&file, csv))));
        }
    }
    figures
}

/// A part of a wall that a map shows unrolled.
pub struct UnrolledPart<'a> {
    /// Its name.
    pub name: String,
    /// Limits of x, m: of a tree along the branch from the junction, or from the opening where the blood enters.
    pub x: [f64; 2],
    /// Its faces.
    pub faces: Vec<usize>,
    places: Vec<Place>,
    lookup: Lookup<'a>,
}

/// How the face at a place is found.
enum Lookup<'a> {
    /// On a wall whose faces lie in rings.
    Rings(Rings),
    /// Among any faces.
    Nearest(NearestFace<'a>),
}

impl UnrolledPart<'_> {
    /// Where one of its faces is.
    pub fn place(&self, face: usize) -> &Place {
        &self.places[face]
    }

    /// What is there of values on the faces of the whole wall; not a number outside the part.
    pub fn value(&self, values: &[f64], x: f64, phi: f64) -> f64 {
        match &self.lookup {
            Lookup::Rings(rings) => rings.value(values, x, phi),
            Lookup::Nearest(faces) => {
                (faces.at(&self.places, x, phi)).map_or(f64::NAN, |face| values[face])
            }
        }
    }
}

/// The parts of a run's wall: the whole vessel, or the branches of a tree; none of another geometry.
pub fn parts(run: &Results) -> io::Result<Vec<UnrolledPart<'_>>> {
    if run.vessel.is_some() {
        let places = places(run);
        let part = Rings::new(&places).map(|rings| UnrolledPart {
            name: String::new(),
            x: whole(run),
            faces: (0..places.len()).collect(),
            lookup: Lookup::Rings(rings),
            places,
        });
        return Ok(part.into_iter().collect());
    }
    if run.case.own().is_none_or(|own| own.tree.is_none()) {
        return Ok(Vec::new());
    }
    let wall = run.wall()?.filter(|w| w.faces.len() == run.faces.len());
    Ok(wall.map_or(Vec::new(), |wall| branches(run, &wall)))
}

/// The branches of a tree, whose faces are on patches. Those that share a patch are numbered.
fn branches<'a>(run: &'a Results, wall: &WetSurface) -> Vec<UnrolledPart<'a>> {
    let places = wall.places();
    let mut parts = Vec::new();
    for region in analysis::regions(&run.case) {
        let RegionExtent::Patch { patch } = &region.extent else {
            continue;
        };
        let mut by_line: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let own = (0..places.len()).filter(|face| wall.is_of_patch(*face, patch));
        own.for_each(|face| {
            by_line
                .entry(wall.line_number(face))
                .or_default()
                .push(face)
        });
        let count = by_line.len();
        for (number, faces) in by_line.into_values().enumerate() {
            let xs = faces.iter().map(|&face| places[face].x_m);
            let x = xs.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                [low.min(x), high.max(x)]
            });
            let name = match count {
                1 => region.name.to_string(),
                _ => format!("{} {}", region.name, number + 1),
            };
            if x[1] > x[0] {
                parts.push(UnrolledPart {
                    name,
                    x,
                    lookup: Lookup::Nearest(NearestFace::new(run, &places, &faces)),
                    faces,
                    places: places.clone(),
                });
            }
        }
    }
    parts
}

/// How far the nearest face may be, in face widths.
const NEAR: f64 = 1.2;

/// Finds the nearest of some faces to a place on an unrolled wall.
struct NearestFace<'a> {
    run: &'a Results,
    /// The faces by x: a picture asks for every pixel, and most faces of a long branch are too far away in x alone.
    by_x: Vec<usize>,
    /// How far in x a face may be at most, m.
    reach_m: f64,
}

impl<'a> NearestFace<'a> {
    fn new(run: &'a Results, places: &[Place], faces: &[usize]) -> Self {
        let mut by_x = faces.to_vec();
        by_x.sort_by(|a, b| places[*a].x_m.total_cmp(&places[*b].x_m));
        let widths = faces.iter().map(|&face| run.faces[face].area_m2.sqrt());
        Self {
            run,
            by_x,
            reach_m: NEAR * widths.fold(0.0, f64::max),
        }
    }

    /// The face, if it is not farther than [`NEAR`]; of several, the first of the wall.
    fn at(&self, places: &[Place], x: f64, phi: f64) -> Option<usize> {
        let first = (self.by_x).partition_point(|&face| places[face].x_m < x - self.reach_m);
        let candidates = self.by_x[first..].iter().copied();
        let candidates = candidates.take_while(|&face| places[face].x_m <= x + self.reach_m);
        let distances = candidates.map(|face| (face, self.distance(&places[face], face, x, phi)));
        let found = distances.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        found.filter(|(_, far)| *far < NEAR).map(|(face, _)| face)
    }

    /// Distance of a face from a place, in face widths.
    fn distance(&self, place: &Place, face: usize, x: f64, phi: f64) -> f64 {
        let row = &self.run.faces[face];
        let around = (phi - place.phi_deg + 540.0).rem_euclid(360.0) - 180.0;
        let across = around.to_radians() * row.mean_radius_m;
        (x - place.x_m).hypot(across) / row.area_m2.sqrt()
    }
}

/// Maps of the radius (mm) at some times (s), with the same colours.
pub fn radii(run: &Results, places: &[Place], found: &[(f64, Vec<f64>)]) -> Vec<String> {
    let all = found.iter().flat_map(|(_, values)| values).copied();
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = all.fold(ends, |(low, high), r| (low.min(r), high.max(r)));
    let draw = |(time, values): &(f64, Vec<f64>)| {
        let title = format!("t = {time:.3} s");
        let svg = draw(
            places,
            values,
            &title,
            "radius / mm",
            whole(run),
            [low, high],
            Vec::new(),
        );
        let mut csv = String::from("x_m,phi_deg,radius_mm\n");
        for (place, value) in places.iter().zip(values) {
            let _ = writeln!(csv, "{:.6},{:.3},{value:.6}", place.x_m, place.phi_deg);
        }
        let file = format!("radius-{time:.3}s");
        figure(
            &svg,
            "Distance of the lumen's surface from the centre of its cross-section.",
            Some((&file, csv)),
        )
    };
    found.iter().map(draw).collect()
}
