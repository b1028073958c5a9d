//! Errors of the wall against degrees of freedom and CPU seconds, a row of a table for each choice of form, mesh and
//! degree: `cargo bench --bench wall_table -- FILE [ROW ...]`. Rows that `FILE` has already are left alone, so that a
//! table can be interrupted. A row is `WALL:Pa:FORM:AXIALxAROUNDxRADIAL:p[:POINTS]`, such as
//! `S-0.5:15700:mixed:16x8x2:4`; without any, the rows of `docs/wall.md` are computed. `FORM` is `mixed` or `pure`, in
//! the trunk space, or with `-tensor` after it in that of all products. `WALL` is
//!
//! - `tube`: the two-layer artery of table 1, inner radius 3 mm, layers of 0.5 mm, 6 mm long between planes; its radial
//!   displacement is known (`tests/library/pfem_static_tube.rs`);
//! - `irregular`: 12 mm of the same artery with the imperfection of `tests/library/near_buckling.rs`, 0.5 mm deep, over
//!   its whole length, between planes;
//! - a model of `openfoam-case`, clamped, elements along graft and artery together;
//! - such a model with `narrow-` before its name: with the sizes of `tests/library/near_buckling.rs`, which buckle at
//!   15.3 kPa.
//!
//! Columns: seconds are CPU time of the whole program (`RAYON_NUM_THREADS=1` for one thread), for the preparation and
//! for the statics. Displacement, von Mises and largest principal stress (smooth and raw) are the largest on a lattice
//! of 7³ points per element; those with `middle` are within 3 mm of the middle of the artery, or 1.5 mm of that of a
//! tube; means are over the lattice there. `pressure_jump` is the root mean square of the jump of the mean Cauchy
//! stress at points that elements of the same material share. The last two are the largest smooth von Mises stress of
//! the evaluated part of a model's artery, within 11.25 mm of its middle: on the lattice, and in the elements' centres
//! alone, where the paper's convergence study takes it.

use fsi_driver::Vec3;
use fsi_driver::case::{Case, Material, Preset};
use fsi_driver::geometry::{HexMesh, Imperfection, irregular_tube_mesh, solid_mesh, tube_mesh};
use fsi_driver::pfem::discretization::{Discretization, Options};
use fsi_driver::pfem::element::surface::{LoadKind, Surface};
use fsi_driver::pfem::solution::statics::{self, Load, StaticOptions};
use fsi_driver::pfem::supports::{self, Support};
use fsi_driver::pfem::{Formulation, Sampler, Space, SpaceKind, SurfaceLoad};
use std::collections::HashMap;
use std::io::Write;
use std::path::Path;

#[path = "../tests/library/near_buckling.rs"]
mod near_buckling;
use near_buckling::NEAR_BUCKLING;

/// Points of the lattice along an edge of an element.
const LATTICE: usize = 7;
const HEADER: &str = "row,degrees_of_freedom,factor_entries,iterations,preparation_s,statics_s,lost_stability_Pa,\
    displacement_mm,lumen_mm3,middle_von_mises_kPa,middle_principal_kPa,middle_raw_von_mises_kPa,\
    middle_raw_principal_kPa,middle_mean_von_mises_kPa,middle_mean_principal_kPa,largest_principal_kPa,\
    largest_raw_principal_kPa,middle_pressure_jump_kPa,pressure_jump_kPa,middle_least_mean_stress_kPa,\
    middle_largest_mean_stress_kPa,evaluated_von_mises_kPa,evaluated_von_mises_in_centres_kPa";
/// Half the length of the part of a model's artery that the study evaluates, m.
const EVALUATED: f64 = 11.25e-3;

/// CPU seconds of all threads of this process, those that have ended included.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").expect("Linux");
    let fields: Vec<&str> = stat.rsplit(") ").next().unwrap_or("").split(' ').collect();
    let ticks = |field: usize| fields[field].parse::<f64>().expect("a number");
    (ticks(11) + ticks(12)) / 100.0
}

/// A wall, and where the middle is that its stresses are taken from.
struct Wall {
    mesh: HexMesh,
    materials: Vec<Material>,
    supports: Vec<Support>,
    middle: f64,
    width: f64,
}

/// The models' meshes have as many elements along each section.
fn wall(name: &str, [axial, around, radial]: [usize; 3]) -> Wall {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case");
    let model = if ["tube", "irregular"].contains(&name) {
        "narrow-S-0.5"
    } else {
        name
    };
    let mut sets = [
        ("axial_per_section", axial / 2),
        ("circumferential", around),
        ("radial_per_layer", radial / 2),
    ]
    .map(|(key, value)| (format!("structure.{key}"), value.to_string()))
    .to_vec();
    let narrow = model.strip_prefix("narrow-");
    if narrow.is_some() {
        sets.extend(NEAR_BUCKLING.map(|(key, value)| (key.to_owned(), value.to_owned())));
    }
    let folder = folder.join(narrow.unwrap_or(model));
    let case = Case::load(&folder, Preset::Paper, &sets);
    let case = case.unwrap_or_else(|e| panic!("{e}"));
    let vessel = case.vessel().expect("an artery");
    let parts = &case.anastomosis().expect("the paper's vessel").wall;
    let layers = [&parts.media, &parts.adventitia].map(Clone::clone);
    let between = ["start", "end"].map(|end| Support::Surface(end.into(), [true, false, false]));
    match name {
        "tube" => Wall {
            mesh: tube_mesh(3e-3, &[5e-4, 5e-4], 6e-3, axial, around, radial / 2),
            materials: layers.to_vec(),
            supports: [
                &between[..],
                &[Support::SymmetryPlane(1), Support::SymmetryPlane(2)],
            ]
            .concat(),
            middle: 3e-3,
            width: 1.5e-3,
        },
        "irregular" => {
            let support = &case
                .anastomosis()
                .expect("the paper's vessel")
                .geometry
                .imperfection;
            let imperfection = Imperfection::new(support, [0.0, 12e-3], 0.5e-3);
            let mesh =
                irregular_tube_mesh(3e-3, [5e-4; 2], imperfection, axial, around, radial / 2);
            let nearest = |y: f64, z: f64| {
                let away = |v: &usize| (mesh.vertices[*v] - Vec3::new(0.0, y, z)).norm();
                let all = 0..mesh.vertices.len();
                all.min_by(|a, b| away(a).total_cmp(&away(b)))
                    .expect("vertices")
            };
            let held = [
                Support::Vertex(nearest(4e-3, 0.0), [false, false, true]),
                Support::Vertex(nearest(-4e-3, 0.0), [false, false, true]),
                Support::Vertex(nearest(0.0, 4e-3), [false, true, false]),
            ];
            Wall {
                materials: layers.to_vec(),
                supports: [&between[..], &held].concat(),
                middle: 6e-3,
                width: 1.5e-3,
                mesh,
            }
        }
        _ => Wall {
            mesh: solid_mesh(vessel),
            materials: vec![
                parts.graft.clone(),
                parts.media.clone(),
                parts.adventitia.clone(),
            ],
            supports: ["start", "end"]
                .map(|end| Support::Clamped(end.into()))
                .to_vec(),
            middle: 45e-3,
            width: 3e-3,
        },
    }
}

/// Root mean square, over the points that several elements of a material share, of the largest difference of the mean
/// stress.
fn jump(points: &[(Vec3, usize, f64)]) -> f64 {
    let mut shared: HashMap<(usize, [i64; 3]), (usize, f64, f64)> = HashMap::new();
    for &(x, region, stress) in points.iter().filter(|point| point.2.is_finite()) {
        let place = x.map(|x| (x * 1e10).round() as i64).into();
        let entry = (shared.entry((region, place))).or_insert((0, stress, stress));
        *entry = (entry.0 + 1, entry.1.min(stress), entry.2.max(stress));
    }
    let shared: Vec<f64> = (shared.into_values())
        .filter(|&(count, ..)| count > 1)
        .map(|(_, least, largest)| (largest - least).powi(2))
        .collect();
    (shared.iter().sum::<f64>() / shared.len() as f64).sqrt()
}

fn row(name: &str) -> String {
    let words: Vec<&str> = name.split(':').collect();
    let [model, pressure, form, elements, p, ..] = words[..] else {
        panic!("{name}: WALL:Pa:FORM:AXIALxAROUNDxRADIAL:p[:POINTS]")
    };
    let pressure: f64 = pressure.parse().expect("a pressure in Pa");
    let p: usize = p.parse().expect("a degree");
    let counts: Vec<usize> = (elements.split('x'))
        .map(|n| n.parse().expect("numbers of elements"))
        .collect();
    let points = (words.get(5)).map_or(p + 1, |word| word.parse().expect("a number of points"));
    let (form, kind) = match form.strip_suffix("-tensor") {
        Some(form) => (form, SpaceKind::TensorProduct),
        None => (form, SpaceKind::Trunk),
    };
    let options = Options {
        formulation: match form {
            "mixed" => Formulation::Mixed,
            "pure" => Formulation::Displacement,
            other => panic!("{other}: mixed or pure, with -tensor or without"),
        },
        quadrature_points: [points; 3],
        ..Options::new(Space::isotropic(kind, p))
    };
    let wall = wall(model, counts.try_into().expect("three numbers of elements"));

    let begin = cpu_seconds();
    let body = Discretization::new(&wall.mesh, &wall.materials, &wall.supports, &options)
        .expect("well posed");
    let faces = supports::surface(&wall.mesh, "inner").expect("walls have one");
    let new = |points| {
        Surface::new(&body.numbering, &body.space, &body.mapping, faces, points).expect("regular")
    };
    let surface = new(points);
    let prepared = cpu_seconds();
    let load = Load::Surface {
        before: None,
        values: SurfaceLoad::uniform_pressure(pressure, surface.points.len()),
        surface: &surface,
        kind: LoadKind::Follower,
    };
    let options = StaticOptions {
        tolerance: 1e-8,
        ..Default::default()
    };
    let found =
        statics::solve(&body, &[load], None, &options).unwrap_or_else(|e| panic!("{name}: {e}"));
    let seconds = [prepared - begin, cpu_seconds() - prepared];
    let start = format!(
        "{name},{},{},{},{:.2},{:.2}",
        body.degrees_of_freedom(),
        body.symbolic.entries(),
        found.stats.iterations,
        seconds[0],
        seconds[1]
    );
    if let Some(bifurcation) = &found.bifurcation {
        return format!(
            "{start},{:.0}{}",
            bifurcation.factor * pressure,
            ",".repeat(16)
        );
    }

    let d = &found.displacement;
    let fine = new(p + 4);
    let areas = fine.deformed_areas(&body.numbering, d);
    let moved = fine.values(&body.numbering, d);
    let volumes = (fine.points.iter().zip(moved).zip(areas)).map(|((point, u), area)| {
        let x = point.position + u;
        0.5 * (x.y * area.y + x.z * area.z)
    });
    let volume = volumes.sum::<f64>().abs();
    let sampler = Sampler::new(&body, LATTICE).expect("regular");
    let samples = sampler.sample(&body, d).expect("regular");
    let largest = |values: &mut dyn Iterator<Item = f64>| {
        values
            .filter(|v| v.is_finite())
            .fold(f64::NEG_INFINITY, f64::max)
    };
    let displacement = largest(&mut samples.displacement.iter().map(|u| u.norm()));
    let is_middle = |x: &Vec3| (x.x - wall.middle).abs() <= wall.width;
    let (mut smooth, mut raw, mut means) = (Vec::new(), Vec::new(), Vec::new());
    for (i, x) in sampler.points.iter().enumerate() {
        let region = body.regions()[i / LATTICE.pow(3)];
        means.push((*x, region, samples.raw[i].cauchy.trace() / 3.0));
        if is_middle(x) {
            smooth.push(samples.smooth[i]);
            raw.push(samples.raw[i]);
        }
    }
    let principal = |state: &_| -> f64 {
        let state: &fsi_driver::pfem::StressState = state;
        state.principal_stresses()[0]
    };
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / raw.len() as f64;
    let of_middle: Vec<_> = (means.iter().filter(|(x, ..)| is_middle(x)))
        .copied()
        .collect();
    let finite = || {
        of_middle
            .iter()
            .map(|point| point.2)
            .filter(|v| v.is_finite())
    };
    let is_evaluated = |x: &Vec3| (x.x - wall.middle).abs() <= EVALUATED;
    let evaluated = || {
        let points = sampler.points.iter().zip(&samples.smooth).enumerate();
        points.filter(|(_, (x, _))| is_evaluated(x))
    };
    let in_an_element = LATTICE.pow(3);
    let centres = || evaluated().filter(|(i, _)| i % in_an_element == in_an_element / 2);
    let values = [
        displacement * 1e3,
        volume * 1e9,
        largest(&mut smooth.iter().map(|s| s.von_mises())) / 1e3,
        largest(&mut smooth.iter().map(principal)) / 1e3,
        largest(&mut raw.iter().map(|s| s.von_mises())) / 1e3,
        largest(&mut raw.iter().map(principal)) / 1e3,
        mean(&mut smooth.iter().map(|s| s.von_mises())) / 1e3,
        mean(&mut smooth.iter().map(principal)) / 1e3,
        largest(&mut samples.smooth.iter().map(principal)) / 1e3,
        largest(&mut samples.raw.iter().map(principal)) / 1e3,
        jump(&of_middle) / 1e3,
        jump(&means) / 1e3,
        finite().fold(f64::INFINITY, f64::min) / 1e3,
        finite().fold(f64::NEG_INFINITY, f64::max) / 1e3,
        largest(&mut evaluated().map(|(_, (_, s))| s.von_mises())) / 1e3,
        largest(&mut centres().map(|(_, (_, s))| s.von_mises())) / 1e3,
    ];
    let values: Vec<String> = values.iter().map(|value| format!("{value:.7}")).collect();
    format!("{start},,{}", values.join(","))
}

/// The rows of `docs/wall.md`, the cheapest first.
fn plan() -> Vec<String> {
    let mut rows = Vec::new();
    for p in 2..=8 {
        for (wall, elements) in [
            ("tube:16000", "2x4x2"),
            ("irregular:16000", "4x8x2"),
            ("S-0.5:15700", "16x8x2"),
            ("narrow-S-0.5:15700", "16x8x2"),
        ] {
            rows.push(format!("{wall}:mixed:{elements}:{p}"));
            rows.push(format!("{wall}:pure:{elements}:{p}"));
        }
        for wall in ["S-0.5:15700", "narrow-S-0.5:15700"] {
            rows.push(format!("{wall}:mixed:16x6x2:{p}"));
        }
    }
    rows
}

fn main() {
    let words: Vec<String> = std::env::args().filter(|word| word != "--bench").collect();
    let Some(file) = words.get(1) else {
        panic!("name the file of the table")
    };
    let rows = match &words[2..] {
        [] => plan(),
        rows => rows.to_vec(),
    };
    let text = std::fs::read_to_string(file).unwrap_or_default();
    let done: Vec<&str> = text
        .lines()
        .filter_map(|line| line.split(',').next())
        .collect();
    let mut table = (std::fs::OpenOptions::new()
        .create(true)
        .append(true)
        .open(file))
    .unwrap_or_else(|e| panic!("{file}: {e}"));
    if done.is_empty() {
        writeln!(table, "{HEADER}").expect("writable");
    }
    for name in rows.iter().filter(|name| !done.contains(&name.as_str())) {
        writeln!(table, "{}", row(name)).expect("writable");
        println!("{name}");
    }
}
