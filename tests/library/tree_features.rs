//! Narrowings and widenings of branches: `[[tree.feature]]`.

use fsi_driver::Vec3;
use fsi_driver::case::{Case, CaseErrors, Preset};
use fsi_driver::simulation::assembly::Domain;
use std::f64::consts::TAU;
use std::path::Path;

/// The example of this name with more in its case.
fn load(name: &str, more: &str) -> Result<Case, CaseErrors> {
    let folder = tempfile::tempdir().unwrap();
    let from = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("examples/trees")
        .join(name);
    for file in std::fs::read_dir(from).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), folder.path().join(file.file_name())).unwrap();
    }
    let path = folder.path().join("case.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, format!("{text}\n{more}")).unwrap();
    Case::load(folder.path(), Preset::Demo, &[]).map(|resolved| resolved.case)
}

/// Arc length along the branch to an end, and distance from its line (m), of the inner and the outer side of the wall
/// there.
fn wall(domain: &Domain, end: &str) -> [Vec<(f64, f64)>; 2] {
    let branches = domain.branches.as_ref().unwrap();
    let (_, line) = (branches.lines.iter())
        .find(|(wall, _)| wall.ends_with(end))
        .unwrap();
    let [inner, outer] = [("inner", 0), (&*format!("outer:{end}"), 4)].map(|(surface, first)| {
        let faces = domain.solid.surfaces[surface].iter();
        let corners = faces.flat_map(|(e, _)| domain.solid.hexes[*e][first..first + 4].to_vec());
        let mut corners: Vec<usize> = corners.collect();
        corners.sort_unstable();
        corners.dedup();
        let of = corners.into_iter().map(|i| {
            let x: Vec3 = domain.solid.vertices[i];
            let s = line.nearest(&x).s;
            (s, (x - line.frame(s).origin).norm())
        });
        let [_, length] = line.ends();
        // Beyond the junction, where other branches are far.
        of.filter(|(s, off)| (4e-3..length - 1e-4).contains(s) && *off < 5e-3)
            .collect()
    });
    [inner, outer]
}

/// The largest relative difference between distances and those that are expected by arc length.
fn off(all: &[(f64, f64)], expected: impl Fn(f64) -> f64) -> f64 {
    let all = all
        .iter()
        .map(|(s, found)| (found / expected(*s) - 1.0).abs());
    all.fold(0.0, f64::max)
}

/// A feature of the example Y's left branch, whose radius is 2.4 mm, in the middle of what is beyond the junction.
fn feature(word: &str, size: &str) -> String {
    let place = "branch = \"left\"\nat_m = 8e-3\nlength_m = 8e-3";
    format!("[[tree.feature]]\nfeature = \"{word}\"\n{place}\n{size}")
}

/// The radius of that branch if its middle has this one (m).
fn radius(s: f64, middle: f64) -> f64 {
    let u = ((s - 8e-3) / 8e-3).clamp(-0.5, 0.5);
    2.4e-3 + (middle - 2.4e-3) * 0.5 * (1.0 + (TAU * u).cos())
}

/// The lumen has the radius that is asked for. A stenosis leaves the outer side of the wall where it is, an aneurysm
/// takes the whole wall with it. Next to the junction the outer side is 0.9 % off.
#[test]
fn branches_are_narrower_and_wider() {
    let stenosis = feature("stenosis", "area_reduction = 0.75");
    let domain = Domain::new(&load("y", &stenosis).unwrap()).unwrap();
    let [inner, outer] = wall(&domain, "left");
    let narrowest = inner
        .iter()
        .map(|(_, off)| *off)
        .fold(f64::INFINITY, f64::min);
    let found = [
        off(&inner, |s| radius(s, 1.2e-3)),
        off(&outer, |_| 1.2 * 2.4e-3),
    ];
    println!("stenosis: {narrowest:.3e} m, {found:?}");
    assert!((1.2e-3..1.23e-3).contains(&narrowest), "{narrowest}");
    assert!(found[0] < 2e-3 && found[1] < 0.011, "{found:?}");
    let [inner, outer] = wall(&domain, "right");
    let found = [off(&inner, |_| 2.4e-3), off(&outer, |_| 1.2 * 2.4e-3)];
    assert!(found[0] < 1e-4 && found[1] < 0.011, "{found:?}");

    let aneurysm = feature("aneurysm", "growth_m = 1e-3");
    let domain = Domain::new(&load("y", &aneurysm).unwrap()).unwrap();
    let [inner, outer] = wall(&domain, "left");
    let found = off(&inner, |s| radius(s, 3.4e-3));
    let widest = |all: &[(f64, f64)]| all.iter().map(|(_, off)| *off).fold(0.0, f64::max);
    let thickness = widest(&outer) - widest(&inner);
    println!("aneurysm: {found:.1e}, {thickness:.3e} m thick");
    assert!(found < 3e-3, "{found}");
    assert!((0.6e-3..0.75e-3).contains(&thickness), "{thickness}");
}

/// Wrong keys are refused, with what is allowed.
#[test]
fn features_that_are_nowhere_are_refused() {
    let stenosis = feature("stenosis", "area_reduction = 0.75");
    let known = "expected a branch with an end of its own, one of \"inlet\", \"left\", \"right\"";
    for (from, to, expected) in [
        ("\"left\"", "\"middle\"", known),
        (
            "at_m = 8e-3",
            "at_m = 0.02",
            "lies beyond its end: it is 0.0148 m long",
        ),
        (
            "area_reduction = 0.75",
            "area_reduction = 1.0",
            "at most 0.99",
        ),
        ("stenosis", "bulge", "tree.feature"),
        ("at_m = 8e-3", "at = 8e-3", "at_m"),
    ] {
        let said = match load("y", &stenosis.replace(from, to)) {
            Err(errors) => errors.to_string(),
            Ok(case) => Domain::new(&case).err().unwrap().reason,
        };
        assert!(said.contains(expected), "{to}: {said}");
    }
}
