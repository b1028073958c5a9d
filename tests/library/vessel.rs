//! Vessels along any path: the same shape however it is described, and one sentence for each mistake.

use fsi_driver::Vec3;
use fsi_driver::analysis::size;
use fsi_driver::case::{Case, Preset, ResolvedCase};
use fsi_driver::geometry::{Surfaces, Vessel, fluid_mesh, solid_mesh};
use nalgebra::Rotation3;
use std::fmt::Write as _;
use std::path::Path;

const SECTIONS: &str = r#"
[[vessel.section]]
name = "proximal"
length_m = 0.02
layers = ["media", "adventitia"]
thicknesses_m = [0.45e-3, 0.5e-3]

[[vessel.section]]
name = "distal"
radius_m = 2.6e-3
layers = ["stiff"]
thicknesses = [0.3]

[[vessel.feature]]
feature = "stenosis"
at_m = 0.008
length_m = 0.01
area_reduction = 0.5
eccentricity = 0.5
side_deg = 60.0

[[vessel.material]]
name = "media"
material = "holzapfel_gasser_ogden"
mu_Pa = 5.4e4
kappa_Pa = 1.0e9
k1_Pa = 0.64e3
k2 = 3.54
fibre_angle_deg = 10.0

[[vessel.material]]
name = "adventitia"
material = "neo_hooke"
mu_Pa = 5.4e3
kappa_Pa = 1.0e8

[[vessel.material]]
name = "stiff"
material = "neo_hooke"
mu_Pa = 3.33e5
kappa_Pa = 1.67e9
"#;

const ARC: &str = "[vessel]\nradius_m = 3e-3\nupstream_extension_m = 0.01\n[[vessel.piece]]\npiece = \"arc\"\nlength_m = 0.04\nbend_radius_m = 0.03\n";

fn load(folder: &Path, text: &str) -> ResolvedCase {
    std::fs::write(
        folder.join("case.toml"),
        format!("extends = \"defaults\"\n{text}"),
    )
    .unwrap();
    Case::load(folder, Preset::Demo, &[]).unwrap_or_else(|errors| panic!("{errors}\n{text}"))
}

/// Points of both meshes, and some inside the wall's elements.
fn points(case: &ResolvedCase) -> Vec<Vec3> {
    let vessel = case.vessel().unwrap();
    let (fluid, solid) = (fluid_mesh(vessel), solid_mesh(vessel));
    let inside = (0..solid.hexes.len()).map(|e| solid.shape.position(e, [0.3, -0.2, 0.7]));
    let vertices = solid.vertices.iter().copied();
    fluid
        .points
        .into_iter()
        .chain(vertices)
        .chain(inside.collect::<Vec<_>>())
        .collect()
}

fn largest_difference(a: &[Vec3], b: &[Vec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).norm());
    differences.fold(0.0, f64::max)
}

fn line_of(points: &[Vec3]) -> String {
    let mut text =
        String::from("[vessel]\nradius_m = 3e-3\nupstream_extension_m = 0.01\npoints_m = [");
    for p in points {
        let _ = write!(text, "[{:?}, {:?}, {:?}],", p.x, p.y, p.z);
    }
    text + "]\n"
}

/// A bow out of its plane, from the x-axis on.
fn bow() -> Vec<Vec3> {
    let point = |t: f64| Vec3::new(t, 0.2 * t * t * 20.0, 0.01 * (60.0 * t).sin());
    (0..=20)
        .map(|i| point(0.04 * f64::from(i) / 20.0))
        .collect()
}

#[test]
fn lumen_and_wall_fit_together_and_no_cell_is_inside_out() {
    let folder = tempfile::tempdir().unwrap();
    for shape in [ARC.to_owned(), line_of(&bow())] {
        let case = load(folder.path(), &(shape + SECTIONS));
        let vessel = case.vessel().unwrap();
        let (fluid, solid) = (fluid_mesh(vessel), solid_mesh(vessel));
        let smallest = fluid
            .cell_volumes()
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        assert!(smallest > 0.0, "{smallest:e}");
        assert_eq!(fluid.cells(), size::fluid_cells(&case));
        // Where the blood touches the elastic wall lies the wall's inner surface.
        let shape = Vessel::new(vessel);
        let patch = fluid
            .patches
            .iter()
            .find(|patch| patch.name == "wallFsi")
            .unwrap();
        let faces = &fluid.faces[patch.start..patch.start + patch.size];
        for point in faces.iter().flatten().map(|p| fluid.points[*p]) {
            let beside = shape.centre_line().nearest(&point);
            let [y, z] = beside.across;
            let radius = shape.lumen_radius(beside.s, z.atan2(y));
            assert!((y.hypot(z) - radius).abs() < 1e-12);
            assert!((-1e-12..shape.end() + 1e-12).contains(&beside.s));
        }
        let vertices = solid.surfaces["inner"]
            .iter()
            .map(|(e, _)| solid.hexes[*e][0]);
        for point in vertices.map(|v| solid.vertices[v]) {
            let beside = shape.centre_line().nearest(&point);
            let [y, z] = beside.across;
            assert!((y.hypot(z) - shape.lumen_radius(beside.s, z.atan2(y))).abs() < 1e-12);
        }
    }
}

/// The lumen has the area that the case asks for.
#[test]
fn a_stenosis_narrows_the_lumen_and_leaves_the_outside() {
    let folder = tempfile::tempdir().unwrap();
    let case = load(folder.path(), &(ARC.to_owned() + SECTIONS));
    let vessel = Vessel::new(case.vessel().unwrap());
    let area = |s: f64| {
        let angles = (0..360).map(|i| f64::from(i).to_radians());
        angles
            .map(|phi| 0.5 * vessel.lumen_radius(s, phi).powi(2))
            .sum::<f64>()
            * 1f64.to_radians()
    };
    let share = area(0.008) / area(0.0005);
    assert!((share - 0.5).abs() < 1e-12, "{share}");
    for phi in [0.0, 1.0, 4.0] {
        assert!((vessel.radius(2, 0.008, phi) - 3.95e-3).abs() < 1e-15);
    }
    // With one layer where others have two, half of it is in each; blended at the joint.
    for (surface, radius) in [(0, 2.6e-3), (1, 2.99e-3), (2, 3.38e-3)] {
        assert!((vessel.radius(surface, 0.035, 0.3) - radius).abs() < 1e-15);
    }
    let [before, after] = [0.02 - 2.6e-3, 0.02 + 2.6e-3].map(|s| vessel.radius(0, s, 0.3));
    assert!((before - 3e-3).abs() < 1e-12 && (after - 2.6e-3).abs() < 1e-12);
}

/// Volume of the lumen by the surface of the mesh against that by the description.
#[test]
fn a_bent_lumen_has_the_volume_of_its_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let more = "[fluid.mesh]\ncore = 8\naxial_per_section = 60\n[preset.demo.fluid.mesh]\ncore = 8\naxial_per_section = 60\n";
    let case = load(folder.path(), &(ARC.to_owned() + SECTIONS + more));
    let vessel = Vessel::new(case.vessel().unwrap());
    let mesh = fluid_mesh(case.vessel().unwrap());
    let volume: f64 = mesh.cell_volumes().into_iter().sum();
    // 32 facets around lose 1 - sin(2π/32)/(2π/32) = 0.64 % of a circle's area; measured 0.69 %.
    let share = volume / vessel.lumen_volume(-0.01, vessel.end());
    assert!((0.9925..0.9940).contains(&share), "{share}");
}

#[test]
fn a_vessel_that_is_rotated_has_rotated_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let rotation = Rotation3::from_euler_angles(0.7, -1.1, 2.3);
    let (bow, shift) = (bow(), Vec3::new(0.3, -0.2, 0.1));
    let turned: Vec<Vec3> = bow.iter().map(|p| rotation * p + shift).collect();
    let [straight, turned] =
        [&bow, &turned].map(|line| points(&load(folder.path(), &(line_of(line) + SECTIONS))));
    let back: Vec<Vec3> = turned
        .iter()
        .map(|p| rotation.inverse() * (p - shift))
        .collect();
    let difference = largest_difference(&straight, &back);
    assert!(difference < 1e-15 * 1e3, "{difference:e}");
}

/// A line, an arc, points and a file give the same vessel.
#[test]
fn a_straight_vessel_is_the_same_however_it_is_described() {
    let folder = tempfile::tempdir().unwrap();
    let head = "[vessel]\nradius_m = 3e-3\nupstream_extension_m = 0.01\n";
    let of = |text: &str| points(&load(folder.path(), &format!("{head}{text}{SECTIONS}")));
    let line = of("[[vessel.piece]]\npiece = \"line\"\nlength_m = 0.04\n");
    let arc = of("[[vessel.piece]]\npiece = \"arc\"\nlength_m = 0.04\nbend_radius_m = 1e6\n");
    // It leaves the line by 0.04²/2e6 = 8e-10 m, and turns outer points by 0.04/1e6 times 4 mm.
    let difference = largest_difference(&line, &arc);
    assert!((7e-10..9e-10).contains(&difference), "{difference:e}");
    let given = of("points_m = [[0.0, 0, 0], [0.013, 0, 0], [0.04, 0, 0]]\n");
    assert!(largest_difference(&line, &given) < 1e-16);
    let text = "x,y,z\n0,0,0\n13.0001,0,0\n20,0,0\n40,0,0\n";
    std::fs::write(folder.path().join("line.csv"), text).unwrap();
    let file = of("centre_line = \"line.csv\"\nunit = \"mm\"\n");
    let difference = largest_difference(&line, &file);
    assert!(difference < 1e-16, "{difference:e}");
}

/// The paper's joint is one vessel of many.
#[test]
fn the_papers_vessel_can_be_described_as_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"
[vessel]
radius_m = 4.0e-3
blend_length_m = 7.5e-3
upstream_extension_m = 0.045
[[vessel.piece]]
piece = "line"
length_m = 0.06
[[vessel.section]]
name = "graft"
length_m = 0.03
layers = ["stiff"]
thicknesses_m = [0.5e-3]
[[vessel.section]]
name = "artery"
radius_m = 3.2e-3
layers = ["media", "adventitia"]
thicknesses_m = [0.55e-3, 0.55e-3]
"#;
    let materials = &SECTIONS[SECTIONS.find("[[vessel.material]]").unwrap()..];
    let described = load(folder.path(), &(text.to_owned() + materials));
    let paper = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/S-0.0");
    let paper = Case::load(&paper, Preset::Demo, &[]).unwrap();
    let [a, b] = [&described, &paper].map(|case| Vessel::new(case.vessel().unwrap()));
    for i in 0..=210 {
        let s = -0.045 + 5e-4 * f64::from(i);
        for surface in 0..3 {
            let [r, q] = [&a, &b].map(|vessel| vessel.radius(surface, s, 0.7));
            assert!((r - q).abs() < 1e-15, "{surface} at {s}: {r} {q}");
        }
        assert!((a.point(s, 1e-3, 2e-3) - b.point(s, 1e-3, 2e-3)).norm() < 1e-16);
    }
    assert_eq!((a.end(), b.end()), (0.06, 0.06));
}

#[test]
fn the_record_of_a_run_is_the_case_without_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let text = "# of somebody\nx y z r\n0 0 0 3\n13 0 1 3\n40 2 0 2.5\n";
    std::fs::write(folder.path().join("line.csv"), text).unwrap();
    let case = load(
        folder.path(),
        &format!("[vessel]\ncentre_line = \"line.csv\"\nunit = \"mm\"\n{SECTIONS}"),
    );
    let record = case.to_toml_string();
    assert_eq!(Case::of_earlier_run(&record).unwrap(), case.case);
    let again = tempfile::tempdir().unwrap();
    std::fs::write(again.path().join("case.toml"), &record).unwrap();
    let loaded =
        Case::load(again.path(), Preset::Paper, &[]).unwrap_or_else(|e| panic!("{e}\n{record}"));
    assert_eq!(loaded.case, case.case);
}

/// What replaces what in a good case, and what the message must contain.
#[rustfmt::skip]
const MISTAKES: &[(&str, &str, &str, &str)] = &[
    ("radius_m = 3e-3\n", "radius_m = 3.0\n", "vessel.radius_m", "above 0.0, at most 0.1"),
    ("radius_m = 3e-3\n", "radius_m = 0.06\n", "vessel.radius_m", "is it in another unit (_m means metres)?"),
    ("radius_m = 3e-3\n", "radius_m = 3e-6\n", "vessel.radius_m", "is it in another unit"),
    ("radius_m = 3e-3\n", "radius_m = nan\n", "vessel.radius_m", "a number above"),
    ("radius_m = 3e-3\n", "", "vessel.section[0].name", "the vessel has no radius"),
    ("radius_m = 3e-3\n", "radius_m = 3e-3\nradii_m = [3e-3, 3e-3]\n", "vessel.radius_m", "the case has vessel.radii_m as well"),
    ("radius_m = 3e-3\n", "radii_m = [3e-3, 3e-3]\n", "vessel.radii_m", "as many radii as vessel.points_m has points, 0"),
    ("radius_m = 3e-3\n", "end_radius_m = 3e-3\n", "vessel.end_radius_m", "needs vessel.radius_m where it begins"),
    ("radius_m = 3e-3\n", "radius_m = 3e-3\nunit = \"mm\"\n", "vessel.unit", "all other lengths are in metres"),
    ("radius_m = 3e-3\n", "radius_m = 3e-3\nunit = \"inch\"\n", "vessel.unit", "one of \"m\", \"cm\", \"mm\", \"um\""),
    ("radius_m = 3e-3\n", "radius_m = 3e-3\nangle_zero = [0, 0, 0]\n", "vessel.angle_zero", "not all zero"),
    ("radius_m = 3e-3\n", "radius_m = 3e-3\nangle_zero = [1, 0]\n", "vessel.angle_zero", "three components"),
    ("radius_m = 3e-3\n", "radius_m = 3e-3\npoints_m = [[0, 0, 0], [1, 0, 0]]\n", "vessel.points_m", "tables [[vessel.piece]] as well"),
    ("radius_m = 3e-3\n", "radius_m = 3e-3\ncentre_line = \"nowhere.csv\"\nunit = \"mm\"\n", "vessel.centre_line", "nowhere.csv"),
    ("radius_m = 3e-3\n", "radius_m = 3e-3\ncentre_line = \"line.csv\"\n", "vessel.centre_line", "vessel.unit = one of"),
    ("radius_m = 3e-3\n", "radius_m = 3e-3\nradius_mm = 3\n", "vessel.radius_mm", "did you mean `vessel.radius_m`"),
    ("bend_radius_m = 0.03", "bend_radius_m = 0.004", "vessel.section[0].name", "the radius of the bend must be at least 1.111 times that"),
    ("length_m = 0.04\nbend_radius_m = 0.03", "length_m = 0.09\nbend_radius_m = 0.01", "vessel.section[0].name", "the vessel crosses itself"),
    ("piece = \"arc\"", "piece = \"ark\"", "vessel.piece[0].piece", "did you mean \"arc\"?"),
    ("piece = \"arc\"", "piece = \"line\"", "vessel.piece[0].bend_radius_m", "line has no such parameter"),
    ("piece = \"arc\"", "piece = \"helix\"", "vessel.piece[0].pitch_m", "rise of a helix in a turn"),
    ("length_m = 0.02\n", "length_m = 0.2\n", "vessel.section[0].name", "leave out the length_m of one of them"),
    ("length_m = 0.02\n", "", "vessel.section[0].name", "2 sections have no length_m"),
    ("radius_m = 2.6e-3", "length_m = 0.01", "vessel.section[0].name", "the sections are 3.0000e-2 m long together"),
    ("name = \"distal\"", "name = \"proximal\"", "vessel.section[1].name", "another section has this name"),
    ("name = \"distal\"", "name = \"distal\"\nwall = \"rigid\"", "vessel.section[1].layers", "a rigid section has no layers"),
    ("layers = [\"stiff\"]\nthicknesses = [0.3]", "", "vessel.section[1].name", "an elastic section needs its layers"),
    ("layers = [\"stiff\"]", "layers = [\"graft\"]", "vessel.section[1].layers", "no [[vessel.material]] is called \"graft\"; there is \"media\", \"adventitia\", \"stiff\""),
    ("layers = [\"stiff\"]", "layers = []", "vessel.section[1].layers", "1 to 20 names"),
    ("thicknesses = [0.3]", "", "vessel.section[1].layers", "the layers have no thickness"),
    ("thicknesses = [0.3]", "thicknesses = [-0.3]", "vessel.section[1].thicknesses", "numbers above 0"),
    ("thicknesses = [0.3]", "thicknesses = [0.3, 0.1]", "vessel.section[1].thicknesses", "a thickness for each of the 1 layers"),
    ("thicknesses = [0.3]", "thicknesses_m = [0.3]", "vessel.section[1].thicknesses_m", "a layer of 0.3 m"),
    ("thicknesses = [0.3]", "thicknesses = [0.3]\nthicknesses_m = [1e-3]", "vessel.section[1].thicknesses_m", "leave out one of the two"),
    ("at_m = 0.008", "at_m = 0.08", "vessel.feature[0].at_m", "the vessel reaches from s = "),
    ("at_m = 0.008\nlength_m = 0.01", "at_m = 0.008\nlength_m = 1e-3", "vessel.feature[0].length_m", "so short a feature is a step"),
    ("area_reduction = 0.5", "area_reduction = 1.5", "vessel.feature[0].area_reduction", "at most 0.99"),
    ("area_reduction = 0.5", "area_reduction = 0.5\ngrowth_m = 1e-3", "vessel.feature[0].growth_m", "stenosis has no such parameter"),
    ("[[vessel.material]]", "[[vessel.material]]\nname = \"stiff\"\nmaterial = \"neo_hooke\"\nmu_Pa = 1e5\nkappa_Pa = 1e8\n[[vessel.material]]", "vessel.material[3].name", "another material has this name"),
    ("mu_Pa = 5.4e4", "mu_Pa = 5.4e9", "vessel.material[0].kappa_Pa", "Poisson's ratio would not be positive"),
    ("radius_m = 3e-3\n", "radius_m = 3e-3\nblend_length_m = 0.05\n", "vessel.blend_length_m", "half of the blend must fit into each section"),
    ("[[vessel.material]]", "[[vessel.region]]\nname = \"a\"\nfrom_m = 0.01\nto_m = 0.005\n[[vessel.material]]", "vessel.region[0].to_m", "expected more than from_m = 0.01"),
    ("[[vessel.material]]", "[[vessel.region]]\nname = \"a\"\nfrom_m = 0.01\nto_m = 0.05\n[[vessel.material]]", "vessel.region[0].to_m", "at most 4.0000e-2, where the elastic part ends"),
    ("[[vessel.material]]", "[[vessel.region]]\nname = \"distal\"\nfrom_m = 0.01\nto_m = 0.02\n[[vessel.material]]", "vessel.region[0].name", "a section or another region has this name"),
    ("extends", "initial.axial_stretch = 1.1\nextends", "initial.axial_stretch", "its stretched shape must be the given one"),
    ("extends", "initial.axial_stretch = 1.1\ninitial.shape = \"loaded\"\ninitial.start = \"equilibrium\"\nsurroundings.spring_Pa_m = 1e6\nextends",
        "initial.axial_stretch", "surroundings.at_rest = \"loaded\""),
    ("extends", "structure.load = \"dead\"\ninitial.shape = \"loaded\"\ninitial.start = \"equilibrium\"\nextends", "structure.load",
        "leave out structure.load, or give the wall unloaded"),
    ("extends", "geometry.graft_length_m = 0.03\nextends", "geometry.graft_length_m", "a case with the table [vessel] has no such key"),
    ("extends", "surroundings.axial_spring_Pa_m = 1e6\nsurroundings.direction = \"all\"\nextends", "surroundings.axial_spring_Pa_m", "resists displacements along the axis already"),
];

/// Centre-lines that are none.
#[rustfmt::skip]
const BROKEN_LINES: &[(&str, &str)] = &[
    ("", "expected 2 to 5000 points, found 0"),
    ("x,y,z\n0,0,0\n", "found 1"),
    ("x,y,z\n0,0,0\nnan,0,0\n", "line 3: expected a number, found \"nan\""),
    ("x,y,z\n0,0,0\n1,0\n", "line 3: expected 3 numbers"),
    ("a,b,c\n0,0,0\n1,0,0\n", "line 1: expected the columns x,y,z or x,y,z,r"),
    ("0,0,0,1\n10,0,0,-1\n", "line 2: expected a radius above 0"),
    ("0,0\n10,0\n", "line 1: expected 3 or 4 numbers"),
    ("0,0,0\n0,0,0\n30,0,0\n", "points 1 and 2 coincide"),
    ("0,0,0\n30,0,0\n10,0.1,0\n", "the centre-line turns back at point 2 by 180°"),
    ("0,0,0\n30000,0,0\n", "is the unit of the file the right one?"),
    ("0,0,0\n1e-4,0,0\n", "is the unit of the file the right one?"),
];

#[test]
fn every_mistake_in_a_vessel_is_one_clear_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let good = format!("extends = \"defaults\"\n{ARC}{SECTIONS}");
    let refuse = |text: &str| {
        std::fs::write(folder.path().join("case.toml"), text).unwrap();
        match Case::load(folder.path(), Preset::Demo, &[]) {
            Ok(_) => panic!("accepted: {text}"),
            Err(errors) => errors,
        }
    };
    for (old, new, key, message) in MISTAKES {
        assert!(good.contains(old), "{old}");
        let errors = refuse(&good.replacen(old, new, 1));
        let text = errors.to_string();
        assert!(
            text.contains(&format!("`{key}`")) && text.contains(message),
            "{new}: {text}\nexpected {key}: {message}"
        );
        assert_eq!(errors.0.len(), 1, "{new}: {text}");
    }
    let file = "[vessel]\nradius_m = 3e-3\ncentre_line = \"line.csv\"\nunit = \"mm\"\n";
    let sections = SECTIONS.replace("length_m = 0.02\n", "length_m = 0.015\n");
    for (line, message) in BROKEN_LINES {
        std::fs::write(folder.path().join("line.csv"), line).unwrap();
        let errors = refuse(&format!("extends = \"defaults\"\n{file}{sections}"));
        let text = errors.to_string();
        assert!(
            text.contains("vessel.centre_line") && text.contains(message),
            "{line:?}: {text}"
        );
        assert_eq!(errors.0.len(), 1, "{line:?}: {text}");
    }
    assert!(MISTAKES.len() + BROKEN_LINES.len() >= 50);
}
