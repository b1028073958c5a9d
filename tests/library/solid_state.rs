//! `fsi-driver solid` with ends moved apart and in a surrounding of springs, dampers and pressure.

use crate::pfem_support::radial::{self, Loading};
use crate::solid_support::{TubeCase, number};
use fsi_driver::case::Material;
use std::fmt::Write;

const LENGTH: f64 = 0.004;

/// The text of a file: tube, mesh and ansatz.
fn text(radius: f64, layers: &[(f64, Material)], formulation: &str) -> String {
    let mut text = format!("[tube]\ninner_radius_m = {radius:?}\nlength_m = {LENGTH:?}\n");
    for (thickness, material) in layers {
        let material = toml::to_string(material).unwrap();
        write!(
            text,
            "[[tube.layer]]\nthickness_m = {thickness:?}\n{material}"
        )
        .unwrap();
    }
    text + &format!(
        "[mesh]\naxial = 1\ncircumferential = 4\nradial_per_layer = 1\n\
         [space]\nkind = \"trunk\"\np = 6\nformulation = \"{formulation}\"\n"
    )
}

fn loaded(loading: &Loading) -> String {
    let kind = if loading.follower { "follower" } else { "dead" };
    format!(
        "[load]\npressure_Pa = {:?}\nkind = \"{kind}\"\n[supports]\naxial_stretch = {:?}\n\
         [outside]\nspring_Pa_m = {:?}\npressure_Pa = {:?}\n",
        loading.pressure, loading.axial_stretch, loading.spring, loading.outer_pressure
    )
}

fn fibred(k1: f64, k2: f64, fibre_angle_deg: f64) -> Material {
    Material::HolzapfelGasserOgden {
        mu: 2.7e4,
        kappa: 5e8,
        k1,
        k2,
        fibre_angle_deg,
        tension_only: false,
        dispersion: None,
        viscosity: None,
    }
}

fn dispersed(mut material: Material, kappa: f64) -> Material {
    if let Material::HolzapfelGasserOgden { dispersion, .. } = &mut material {
        *dispersion = Some(kappa);
    }
    material
}

#[test]
fn stretched_tubes_in_springs_meet_the_semi_analytic_solution() {
    let neo_hooke = Material::NeoHooke {
        mu: 1.5e5,
        kappa: 1e9,
        viscosity: None,
    };
    let kirchhoff = Material::SaintVenantKirchhoff {
        youngs_modulus: 3e5,
        poisson_ratio: 0.3,
        viscosity: None,
    };
    let tubes = [
        (2e-3, vec![(6e-4, fibred(2e3, 8.0, 35.0))]),
        (
            3e-3,
            vec![
                (5e-4, fibred(640.0, 3.5, 10.0)),
                (5e-4, dispersed(fibred(4e3, 6.0, 40.0), 0.2)),
            ],
        ),
        (3e-3, vec![(6e-4, neo_hooke)]),
        (4e-3, vec![(1e-3, kirchhoff)]),
    ];
    let base = Loading {
        pressure: 1.2e4,
        follower: true,
        axial_stretch: 1.0,
        outer_pressure: 0.0,
        spring: 0.0,
        rest: None,
    };
    let mut largest: f64 = 0.0;
    for (i, (radius, layers)) in tubes.iter().enumerate() {
        for (formulation, axial_stretch, spring, outer_pressure, follower) in [
            ("mixed", 1.0, 2e7, 0.0, true),
            ("mixed", 1.2, 0.0, 0.0, true),
            ("displacement", 1.35, 5e6, 2e3, true),
            ("mixed", 1.5, 2e7, -1e3, false),
        ] {
            {
                let loading = Loading {
                    axial_stretch,
                    spring,
                    outer_pressure,
                    follower,
                    ..base
                };
                let summary =
                    TubeCase::new(&(text(*radius, layers, formulation) + &loaded(&loading)))
                        .solve();
                let exact = radial::solve(*radius, layers, &loading);
                let outer = exact.displacement[layers.len()];
                let springs = std::f64::consts::PI
                    * spring
                    * (radius + layers.iter().map(|layer| layer.0).sum::<f64>())
                    * outer.powi(2);
                let mut errors: Vec<f64> = crate::solid_support::radial(&summary)
                    .iter()
                    .zip(&exact.displacement)
                    .map(|(a, b)| ((a - b) / radius).abs())
                    .collect();
                let energies = [
                    ("strain_energy_J", exact.energy),
                    ("spring_energy_J", springs),
                ];
                for (key, expected) in energies {
                    let error = number(&summary, key) - expected * LENGTH;
                    errors.push(error.abs() / (exact.energy * LENGTH));
                }
                let error = errors.iter().fold(0.0, |a: f64, b| a.max(*b));
                println!("tube {i}, {formulation}, stretch {axial_stretch}: {error:.1e}");
                assert!(
                    error < 1e-6,
                    "tube {i}, {formulation}, {axial_stretch}: {errors:?}"
                );
                largest = largest.max(error);
            }
        }
    }
    // Not a comparison of a thing with itself.
    assert!(largest > 1e-12);
}

#[test]
fn a_forced_vibration_is_damped_as_one_degree_of_freedom() {
    // A thin ring: m u'' + c u' + (E h/R² + k) u = p, with c = η h/R² if the wall is viscous.
    let (radius, thickness, modulus, density) = (1e-2, 2e-5, 3e5, 1100.0);
    let (mass, spring) = (density * thickness, 3e4);
    let stiffness = modulus * thickness / (radius * radius) + spring;
    let omega = f64::sqrt(stiffness / mass);
    let pressure = 1e-4 * radius * stiffness;
    // Pulses at a frequency near the resonance.
    let pulse = |t: f64| 0.5 - 0.5 * (0.9 * omega * t).cos();
    let step = std::f64::consts::TAU / omega / 50.0;
    let times: Vec<f64> = (0..=200).map(|i| i as f64 * step).collect();
    let factors: Vec<f64> = times.iter().map(|&t| pulse(t)).collect();
    let mut peaks = Vec::new();
    // The errors are those of 50 steps per period: measured 1.7e-2, 1.2e-2, 2.1e-3 and 1.2e-2.
    for (ratio, is_wall, expected) in [
        (0.0, false, 1.7e-2),
        (0.05, false, 1.2e-2),
        (0.5, false, 2.1e-3),
        (0.05, true, 1.2e-2),
    ] {
        let damping = 2.0 * ratio * omega * mass;
        let damper = if is_wall { 0.0 } else { damping };
        let material = Material::SaintVenantKirchhoff {
            youngs_modulus: modulus,
            poisson_ratio: 0.0,
            viscosity: is_wall.then_some(damping * radius * radius / thickness),
        };
        let file = text(radius, &[(thickness, material)], "mixed").replace("p = 6", "p = 4")
            + &format!(
                "[load]\npressure_Pa = {pressure:?}\nkind = \"follower\"\n\
                 [outside]\nspring_Pa_m = {spring:?}\ndamping_Pa_s_m = {damper:?}\n\
                 [dynamics]\ndensity_kg_m3 = {density:?}\nstep_s = {step:?}\nend_s = {:?}\n\
                 times_s = {times:?}\nload_factors = {factors:?}\n",
                200.0 * step
            );
        let tube = TubeCase::new(&file);
        tube.solve();
        let mut table = csv::Reader::from_path(tube.results().join("history.csv")).unwrap();
        let found: Vec<f64> = table
            .records()
            .map(|row| row.unwrap()[2].parse().unwrap())
            .collect();
        // The classical Runge-Kutta method with ten steps in each of the program's.
        let rate = |t: f64, [u, v]: [f64; 2]| {
            [
                v,
                (pressure * pulse(t) - damping * v - stiffness * u) / mass,
            ]
        };
        let ahead = |[u, v]: [f64; 2], [du, dv]: [f64; 2], h: f64| [u + h * du, v + h * dv];
        let (mut state, mut exact, h) = ([0.0; 2], Vec::new(), step / 10.0);
        for i in 0..2000 {
            let t = i as f64 * h;
            let a = rate(t, state);
            let b = rate(t + 0.5 * h, ahead(state, a, 0.5 * h));
            let c = rate(t + 0.5 * h, ahead(state, b, 0.5 * h));
            let d = rate(t + h, ahead(state, c, h));
            for k in 0..2 {
                state[k] += h / 6.0 * (a[k] + 2.0 * (b[k] + c[k]) + d[k]);
            }
            if i % 10 == 9 {
                exact.push(state[0]);
            }
        }
        let largest = exact.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let errors = found.iter().zip(&exact).map(|(a, b)| (a - b).abs());
        let error = errors.fold(0.0, f64::max) / largest;
        println!("damping ratio {ratio}: {error:.1e} of the peak {largest:.3e} m");
        assert_eq!(found.len(), 200);
        let share = error / expected;
        assert!(
            (0.9..1.1).contains(&share),
            "damping ratio {ratio}: {error:e}"
        );
        peaks.push(largest);
    }
    assert!(
        peaks[0] > 1.1 * peaks[1] && peaks[1] > 1.5 * peaks[2],
        "{peaks:?}"
    );
}

#[test]
fn the_curve_begins_with_the_stretched_tube() {
    let layers = [(6e-4, fibred(2e3, 8.0, 35.0))];
    let loading = Loading {
        pressure: 1.2e4,
        follower: true,
        axial_stretch: 1.2,
        outer_pressure: 0.0,
        spring: 0.0,
        rest: None,
    };
    let tube = TubeCase::new(&(text(2e-3, &layers, "mixed") + &loaded(&loading)));
    tube.solve();
    let mut table = csv::Reader::from_path(tube.results().join("curve.csv")).unwrap();
    let first: [f64; 3] = table.deserialize().next().unwrap().unwrap();
    let without_pressure = Loading {
        pressure: 0.0,
        ..loading
    };
    let exact = radial::solve(2e-3, &layers, &without_pressure).displacement;
    assert_eq!(first[0], 0.0);
    for (radius, (reference, u)) in first[1..].iter().zip([2e-3, 2.6e-3].iter().zip(exact)) {
        assert!((radius - reference - u).abs() < 1e-9, "{first:?}");
    }
}

/// Prestretch or tissue keeps a clamped artery straight that buckles without.
#[test]
fn prestretch_or_tissue_prevents_buckling() {
    let slack = text(2e-3, &[(6e-4, fibred(2e3, 8.0, 35.0))], "mixed")
        .replace("length_m = 0.004", "length_m = 0.05")
        .replace("axial = 1", "axial = 8")
        .replace("p = 6", "p = 4")
        + "[load]\npressure_Pa = 1.6e4\nkind = \"follower\"\n[supports]\nends = \"clamped\"\n";
    let output = TubeCase::new(&slack).run(&[]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    // Measured: 46 mmHg.
    let expected = "the tube loses its stability at 6115.4 Pa of 16000.0 Pa";
    assert!(said.contains(expected), "{said}");
    // Inner displacement at 120 mmHg, measured.
    for (what, expected) in [
        ("axial_stretch = 1.2\n", 7.1090e-4),
        ("[outside]\nspring_Pa_m = 2.0e7\n", 6.7022e-4),
    ] {
        let summary = TubeCase::new(&(slack.clone() + what)).solve();
        assert_eq!(number(&summary, "pressure_Pa"), 1.6e4);
        let inner = crate::solid_support::radial(&summary)[0];
        assert!((inner / expected - 1.0).abs() < 1e-4, "{what}: {inner:e}");
    }
}

#[test]
fn ends_that_slide_radially_leave_a_tube_in_plane_strain() {
    let layers = [(6e-4, fibred(2e3, 8.0, 35.0))];
    let loading = Loading {
        pressure: 1.2e4,
        follower: true,
        axial_stretch: 1.2,
        outer_pressure: 0.0,
        spring: 0.0,
        rest: None,
    };
    let file = text(2e-3, &layers, "mixed") + &loaded(&loading);
    let summary =
        TubeCase::new(&file.replace("[supports]", "[supports]\nends = \"radial\"")).solve();
    let exact = radial::solve(2e-3, &layers, &loading);
    let found = crate::solid_support::radial(&summary);
    for (found, exact) in found.iter().zip(&exact.displacement) {
        let error = (found - exact).abs() / 2e-3;
        println!("radial ends: {error:.1e}");
        assert!(error < 1e-6, "{found} {exact}");
    }
    // Nothing pulls at the guides: measured 3.2e-13 J compared with 2.9e-4 J.
    let guides = number(&summary, "spring_energy_J");
    assert!(guides > 0.0 && guides < 1e-12, "{guides:e}");
}

#[test]
fn ends_on_springs_lie_between_free_and_clamped() {
    // A material that gives way: what cannot change its volume locks in a single clamped element.
    let neo_hooke = Material::NeoHooke {
        mu: 1.5e5,
        kappa: 1e6,
        viscosity: None,
    };
    let file = text(2e-3, &[(6e-4, neo_hooke)], "mixed").replace("p = 6", "p = 4")
        + "[load]\npressure_Pa = 4e3\nkind = \"follower\"\n[supports]\n";
    let widening = |ends: &str| {
        let summary = TubeCase::new(&(file.clone() + ends)).solve();
        crate::solid_support::radial(&summary)[0]
    };
    let clamped = widening("ends = \"clamped\"\n");
    let springs =
        |stiffness: &str| widening(&format!("ends = \"springs\"\nspring_Pa_m = {stiffness}\n"));
    let [soft, middle, stiff] = ["1e8", "1e9", "1e14"].map(springs);
    println!("soft {soft:e}, middle {middle:e}, stiff {stiff:e}, clamped {clamped:e}");
    // Measured: 8.771e-5, 8.262e-5, and 7.1e-6 of the clamped tube's 7.917e-5.
    let gap = stiff / clamped - 1.0;
    assert!(gap > 1e-6 && gap < 2e-5, "{gap:e}");
    assert!(clamped < 0.97 * middle && middle < 0.97 * soft);
}

#[test]
fn ends_that_do_not_fit_are_refused() {
    let file = text(2e-3, &[(6e-4, fibred(2e3, 8.0, 35.0))], "mixed")
        + "[load]\npressure_Pa = 4e3\nkind = \"follower\"\n[supports]\n";
    for (supports, expected) in [
        ("ends = \"springs\"\n", "add supports.spring_Pa_m"),
        (
            "ends = \"clamped\"\nspring_Pa_m = 1e8\n",
            "write supports.ends = \"springs\"",
        ),
        (
            "ends = \"springs\"\nspring_Pa_m = 1e8\naxial_stretch = 1.2\n",
            "ends on springs are not moved to a place",
        ),
        ("ends = \"sliding\"\n", "\"radial\""),
    ] {
        let said = TubeCase::new(&(file.clone() + supports)).refused();
        assert!(said.contains(expected), "{supports}: {said}");
    }
}
