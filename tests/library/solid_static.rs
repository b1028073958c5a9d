//! `fsi-driver solid` against solutions of the radial boundary value problem, and what it writes.

use crate::pfem_support::radial;
use crate::solid_support::{TubeCase, example, number, with};
use fsi_driver::case::Material;
use std::fmt::Write;

/// Largest relative error of energy and radial displacements.
fn worst(summary: &serde_json::Value, length: f64, energy: f64, displacement: &[f64]) -> f64 {
    let found = crate::solid_support::radial(summary);
    assert_eq!(found.len(), displacement.len());
    let pairs = found.iter().zip(displacement);
    let errors = pairs.map(|(a, b)| (a / b - 1.0).abs());
    let energy = number(summary, "strain_energy_J") / (energy * length) - 1.0;
    errors.fold(energy.abs(), f64::max)
}

#[test]
fn the_example_meets_the_published_values_with_both_loads() {
    let follower = (
        0.1654547651,
        [1.2289883693e-3, 1.0972178946e-3, 0.9884289131e-3],
    );
    let dead = (
        0.1283939496,
        [1.1252110306e-3, 1.0019371086e-3, 0.9007622447e-3],
    );
    for (kind, (energy, displacement)) in [("follower", follower), ("dead", dead)] {
        let text = with(
            &example(),
            &[("kind = \"follower\"", &format!("kind = \"{kind}\""))],
        );
        let summary = TubeCase::new(&text).solve();
        let error = worst(&summary, 0.006, energy, &displacement);
        assert!(error < 1e-8, "{kind}: {error:e}");
        assert!((number(&summary, "min_jacobian") - 1.0).abs() < 1e-3);
        assert!((number(&summary, "max_jacobian") - 1.0).abs() < 1e-3);
    }
}

fn layer(thickness: f64, material: &Material) -> String {
    let mut text = format!("[[tube.layer]]\nthickness_m = {thickness:?}\n");
    text.push_str(&toml::to_string(material).unwrap());
    text
}

#[test]
fn other_radii_thicknesses_and_materials_are_met() {
    let neo_hooke = Material::NeoHooke {
        mu: 3.33e5,
        kappa: 1.67e9,
        viscosity: None,
    };
    let soft = Material::NeoHooke {
        mu: 4e4,
        kappa: 1e7,
        viscosity: None,
    };
    let kirchhoff = Material::SaintVenantKirchhoff {
        youngs_modulus: 3e5,
        poisson_ratio: 0.3,
        viscosity: None,
    };
    let linear = Material::LinearElastic {
        youngs_modulus: 3e5,
        poisson_ratio: 0.3,
    };
    let fibred = |k1, k2, fibre_angle_deg| Material::HolzapfelGasserOgden {
        mu: 2e4,
        kappa: 5e8,
        k1,
        k2,
        fibre_angle_deg,
        tension_only: true,
        dispersion: None,
        viscosity: None,
    };
    // Inner radius, layers, pressure, axial and circumferential elements. Thin is a tenth of the radius, thick a half.
    let tubes = [
        (3e-3, vec![(3e-4, neo_hooke.clone())], 1.6e4, [1, 4]),
        (4e-3, vec![(2e-3, neo_hooke.clone())], 6e4, [2, 4]),
        (2e-3, vec![(1e-3, soft)], 8e3, [3, 4]),
        (5e-3, vec![(5e-4, kirchhoff.clone())], 3e3, [2, 6]),
        (4e-3, vec![(2e-3, kirchhoff)], 2e4, [2, 5]),
        (4e-3, vec![(2e-3, linear)], 1.5e3, [2, 5]),
        (
            2e-3,
            vec![(1e-4, fibred(2e3, 5.0, 20.0)), (1e-4, neo_hooke)],
            1e4,
            [2, 4],
        ),
        (
            2e-3,
            vec![
                (6e-4, fibred(2e3, 5.0, 20.0)),
                (4e-4, fibred(4e3, 12.0, 35.0)),
            ],
            1.2e4,
            [2, 4],
        ),
    ];
    for (i, (radius, layers, pressure, [axial, around])) in tubes.into_iter().enumerate() {
        for kind in ["follower", "dead"] {
            let mut text = format!("[tube]\ninner_radius_m = {radius:?}\nlength_m = 0.01\n");
            layers
                .iter()
                .for_each(|(thickness, m)| text.push_str(&layer(*thickness, m)));
            write!(
                text,
                "[mesh]\naxial = {axial}\ncircumferential = {around}\nradial_per_layer = 1\n\
                 [space]\nkind = \"trunk\"\np = 6\n[load]\npressure_Pa = {pressure:?}\nkind = \"{kind}\"\n"
            )
            .unwrap();
            let summary = TubeCase::new(&text).solve();
            let exact = radial::inflate(radius, &layers, pressure, kind == "follower");
            let error = worst(&summary, 0.01, exact.energy, &exact.displacement);
            println!(
                "tube {i}, {kind}: {error:.1e}, widened by {:.2}",
                exact.displacement[0] / radius
            );
            assert!(error < 1e-6, "tube {i}, {kind}: {error:e}");
        }
    }
}

#[test]
fn stresses_and_fields_are_written() {
    let text = with(
        &example(),
        &[
            ("p = 6 ", "p = [2, 4, 3] "),
            ("p_geometry = 6", "p_geometry = \"exact\""),
        ],
    );
    let tube = TubeCase::new(&text);
    let summary = tube.solve();
    assert!(number(&summary, "free_dofs") < number(&summary, "dofs"));
    for key in [
        "newton_iterations",
        "assembly_s",
        "solve_s",
        "total_s",
        "peak_memory_MB",
    ] {
        assert!(number(&summary, key) > 0.0, "{key}");
    }
    let mut table = csv::Reader::from_path(tube.results().join("von_mises.csv")).unwrap();
    let headers = table.headers().unwrap().clone();
    let last: Vec<&str> = headers.iter().skip(8).collect();
    let expected = [
        "von_mises_Pa",
        "max_principal_Pa",
        "hoop_stress_Pa",
        "axial_stress_Pa",
    ];
    assert_eq!(last, expected);
    let stresses: Vec<f64> = table
        .records()
        .map(|r| r.unwrap()[8].parse().unwrap())
        .collect();
    assert_eq!(stresses.len(), 16);
    // Nothing varies along and around the tube.
    let spread = |layer: usize| {
        let of_layer = stresses.iter().skip(layer).step_by(2);
        of_layer.clone().fold(0.0, |a: f64, b| a.max(*b))
            / of_layer.fold(1e9, |a: f64, b| a.min(*b))
            - 1.0
    };
    assert!(spread(0) < 1e-6 && spread(1) < 1e-6);
    vtkio::Vtk::import(tube.results().join("tube.vtu")).unwrap();
}

/// The curve of radius over pressure follows the semi analytic solution through all load steps.
#[test]
fn radius_over_pressure_is_semi_analytic() {
    let tube = TubeCase::new(&with(&example(), &[("steps = 10", "steps = 4")]));
    let output = tube.run(&[]);
    assert!(output.status.success());
    let mut reader = csv::Reader::from_path(tube.results().join("curve.csv")).unwrap();
    let names: Vec<_> = reader
        .headers()
        .unwrap()
        .iter()
        .map(str::to_owned)
        .collect();
    let surfaces = ["inner_surface", "interface_1", "outer_surface"];
    assert_eq!(names[0], "pressure_Pa");
    assert_eq!(names[1..], surfaces.map(|s| format!("{s}_radius_m")));
    let rows: Vec<[f64; 4]> = reader.deserialize().map(Result::unwrap).collect();
    assert!(rows.len() >= 4, "{rows:?}");
    assert_eq!(rows[0], [0.0, 0.003, 0.0035, 0.004]);
    assert_eq!(rows[rows.len() - 1][0], 1.6e4);
    let published = [1.2289883693e-3, 1.0972178946e-3, 0.9884289131e-3];
    for i in 0..3 {
        let u = rows[rows.len() - 1][i + 1] - rows[0][i + 1];
        assert!((u / published[i] - 1.0).abs() < 1e-8, "{u}");
    }
    // A load of its own at a step amid the curve gives the same radius; steps on the way are solved to 1e-6.
    let [pressure, radius, ..] = rows[rows.len() / 2];
    let alone = with(&example(), &[("1.6e4", &format!("{pressure:?}"))]);
    let u = crate::solid_support::radial(&TubeCase::new(&alone).solve())[0];
    assert!((radius / (0.003 + u) - 1.0).abs() < 1e-6, "{radius}");

    let said = String::from_utf8(output.stdout).unwrap();
    for line in ["inner surface", "interface 1", "outer surface"] {
        assert!(said.contains(&format!("\n  {line}")), "{said}");
    }
    assert!(said.contains("at mid-length, mean around the circumference"));
}

#[test]
fn clamped_ends_hold_the_tube_back() {
    let free = [
        ("p = 6 ", "p = 4 "),
        ("p_geometry = 6", "p_geometry = 4"),
        ("quadrature_points = 8", ""),
    ];
    let text = with(&example(), &free);
    let sliding = crate::solid_support::radial(&TubeCase::new(&text).solve());
    let clamped =
        TubeCase::new(&with(&text, &[("ends = \"axial\"", "ends = \"clamped\"")])).solve();
    // The ends are a radius away: measured 0.918.
    assert!(crate::solid_support::radial(&clamped)[0] < 0.95 * sliding[0]);
}

#[test]
fn earlier_results_are_replaced_only_by_force() {
    let small = [
        ("p = 6 ", "p = 2 "),
        ("p_geometry = 6", ""),
        ("quadrature_points = 8", ""),
    ];
    let tube = TubeCase::new(&with(&example(), &small));
    tube.solve();
    let again = tube.run(&[]);
    assert_eq!(again.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&again.stderr).contains("--force"));
    assert!(tube.run(&["--force"]).status.success());
    assert!(tube.run(&["--out", "elsewhere"]).status.success());
}
