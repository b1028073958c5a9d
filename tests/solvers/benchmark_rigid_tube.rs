//! Flow in a straight rigid tube against Poiseuille's and Womersley's exact solutions.

use crate::fluid_support::{BIRD_CARREAU, correctors, keep, read_internal_field, use_bird_carreau};
use fsi_driver::Vec3;
use fsi_driver::case::{Case, FlowCurve, Preset, ResolvedCase};
use fsi_driver::fluid::conversation::session::Terms;
use fsi_driver::fluid::openfoam::case_files::{CaseFiles, Openings, VesselOpenings};
use fsi_driver::fluid::openfoam::{OpenFoam, OpenFoamSettings};
use fsi_driver::fluid::{Fluid, FluidStep};
use fsi_driver::geometry::{PolyMesh, WallPolygons, fluid_mesh};
use nalgebra::Complex;
use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::time::Duration;

type C = Complex<f64>;

fn load<T: ToString>(name: &str, overrides: &[(&str, T)]) -> ResolvedCase {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("openfoam-case")
        .join(name);
    let overrides: Vec<_> = overrides
        .iter()
        .map(|(key, value)| ((*key).to_owned(), value.to_string()))
        .collect();
    Case::load(&folder, Preset::Paper, &overrides).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The fluid of a case with its wall at rest, and its mesh.
struct RigidTube {
    fluid: OpenFoam,
    time_step: f64,
    mesh: PolyMesh,
    folder: tempfile::TempDir,
}

impl RigidTube {
    fn start(case: &Case) -> Self {
        Self::start_with(case, |_| ())
    }

    /// After a change of the files in OpenFOAM's case.
    fn start_with(case: &Case, change: fn(&Path)) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let vessel = case.vessel().unwrap();
        let mut mesh = fluid_mesh(vessel);
        let sides = WallPolygons::of(&mesh, &vessel.fluid.mesh);
        mesh.points = sides.fit(&mesh, &vessel.fluid.mesh, &mesh.points);
        mesh.write(folder.path()).unwrap();
        CaseFiles {
            walls: vec!["wallFsi"],
            templates: &case.fluid.templates,
            blood: &case.blood,
            openings: Openings::Vessel(VesselOpenings::flow_and_windkessel(
                FlowCurve::new(&vessel.inflow, case.time.period).unwrap(),
                &vessel.windkessel,
                fsi_driver::case::Start::Ramp,
            )),
            ramp: &case.ramp,
            time: &case.time,
            convection: case.fluid.convection,
            ranks: 1,
            non_orthogonality_deg: mesh.non_orthogonality_deg(),
            diffusion_number: case.blood.viscosity / case.blood.density
                * case.time.step
                * mesh.laplacian_diagonal(),
            blend: None,
        }
        .write(folder.path())
        .unwrap();
        change(folder.path());
        let fluid = OpenFoam::start(OpenFoamSettings {
            case: folder.path().to_owned(),
            log: folder.path().join("log"),
            ranks: 1,
            transport: case.fluid.transport,
            answer_limit: Duration::from_secs(120),
            terms: Terms {
                start_time: 0.0,
                time_step: case.time.step,
                interface: None,
            },
            sampling: Default::default(),
            interrupt: Default::default(),
        })
        .unwrap();
        Self {
            fluid,
            time_step: case.time.step,
            mesh,
            folder,
        }
    }

    fn step(&mut self, write: bool) -> FluidStep {
        let rest = vec![Vec3::zeros(); self.fluid.interface().points.len()];
        self.fluid
            .solve(&rest, self.time_step, correctors(4))
            .unwrap();
        self.fluid.accept(keep(write)).unwrap()
    }

    /// Axial velocity (m/s) with distance (m) from the axis and volume (m³) of each cell at a written time.
    fn profile(&self, time: &str) -> Vec<[f64; 3]> {
        let velocity = read_internal_field(&self.folder.path().join(time).join("U"));
        let volumes = self.mesh.cell_volumes();
        let mut centres = vec![(Vec3::zeros(), 0.0); volumes.len()];
        let sides = self.mesh.owner.iter().enumerate();
        for (face, &cell) in sides.chain(self.mesh.neighbour.iter().enumerate()) {
            for &point in &self.mesh.faces[face] {
                centres[cell].0 += self.mesh.points[point];
                centres[cell].1 += 1.0;
            }
        }
        (0..volumes.len())
            .map(|cell| {
                let (sum, count) = centres[cell];
                let r = (sum.y / count).hypot(sum.z / count);
                [velocity[3 * cell], r, volumes[cell]]
            })
            .collect()
    }
}

/// Errors of the steady state with their signs: of the pressure drop `8 mu L Q / (pi r⁴)`, and of the mean wall shear
/// stress `r dp / (2 L)`.
fn poiseuille_errors(core: usize, radial: usize) -> [f64; 2] {
    let mesh = [("fluid.mesh.core", core), ("fluid.mesh.radial", radial)];
    let case = load("poiseuille", &mesh);
    let g = &case.anastomosis().unwrap().geometry;
    let (radius, mu) = (g.graft_inner_radius, case.blood.viscosity);
    let length = g.extension_length + g.graft_length + g.artery_length;
    let mut tube = RigidTube::start(&case);
    let steps: Vec<_> = (0..case.steps()).map(|_| tube.step(false)).collect();
    let [before, last] = [&steps[steps.len() - 2], &steps[steps.len() - 1]];
    assert!(
        (last.inflow() / before.inflow() - 1.0).abs() < 1e-3,
        "steady"
    );

    let drop = last.inlet_pressure() - last.outlet_pressure();
    let exact_drop = 8.0 * mu * length * last.inflow() / (PI * radius.powi(4));

    // The force is the fluid's on the wall: along the flow.
    let exact_shear = 0.5 * radius * drop / length;
    let mean = last.wall_shear.iter().map(|t| t.x).sum::<f64>() / last.wall_shear.len() as f64;
    println!(
        "{core} {radial}: pressure drop {drop} Pa, exact {exact_drop} Pa; wall shear {mean} Pa, exact {exact_shear} Pa"
    );
    [drop / exact_drop - 1.0, mean / exact_shear - 1.0]
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn steady_flow_is_poiseuilles() {
    // The benchmark's own mesh, and those of the presets `paper`, `coarse` and `demo`. The shear is too low for the
    // drop, since a polygon has a longer side than the circle of its area.
    let meshes = [(12, 8), (8, 5), (5, 4), (4, 4)];
    let found = meshes.map(|(core, radial)| poiseuille_errors(core, radial));
    println!("{found:?}");
    let measured = [
        [0.0026, -0.0020],
        [-0.0001, -0.0029],
        [-0.0019, -0.0054],
        [-0.0008, -0.0077],
    ];
    for (found, measured) in found.iter().zip(measured) {
        assert!((found[0] - measured[0]).abs() < 2e-4, "{found:?}");
        assert!((found[1] - measured[1]).abs() < 2e-4, "{found:?}");
    }
}

/// Errors of the steady state with blood of this viscosity (Pa s, by the rate of shear), with their signs: of the flow
/// for the pressure drop, and of the mean wall shear stress `r dp / (2 L)`.
fn shear_thinning_errors(
    case: &Case,
    change: fn(&Path),
    viscosity: &dyn Fn(f64) -> f64,
) -> [f64; 2] {
    let g = &case.anastomosis().unwrap().geometry;
    let radius = g.graft_inner_radius;
    let length = g.extension_length + g.graft_length + g.artery_length;
    let mut tube = RigidTube::start_with(case, change);
    let last = (0..case.steps()).map(|_| tube.step(false)).last().unwrap();
    let drop = last.inlet_pressure() - last.outlet_pressure();
    let shear = 0.5 * radius * drop / length;

    // mu(g) g = shear r / R gives the rate g(r); Q = pi ∫ r² g dr after integration by parts.
    let rate = |r: f64| {
        let (mut low, mut high) = (0.0, 1e6);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if viscosity(middle) * middle < shear * r / radius {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    };
    let pieces = 2000;
    let flow: f64 = (0..pieces)
        .map(|i| {
            let r = radius * (i as f64 + 0.5) / pieces as f64;
            PI * r * r * rate(r) * radius / pieces as f64
        })
        .sum();
    let found = last.wall_shear.iter().map(|t| t.x).sum::<f64>() / last.wall_shear.len() as f64;
    let newtonian = PI * radius.powi(4) * drop / (8.0 * case.blood.viscosity * length);
    println!(
        "flow {}, exact {flow}, Newtonian {newtonian} m³/s",
        last.inflow()
    );
    println!("wall shear stress {found}, exact {shear} Pa");
    [last.inflow() / flow - 1.0, found / shear - 1.0]
}

/// Blood of Bird and Carreau, chosen in the templates: the viscosity follows the rate of shear, in the flow as in the
/// load on the wall.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn shear_thinning_flow_is_exact() {
    let case = load(
        "poiseuille",
        &[("fluid.mesh.core", 8), ("fluid.mesh.radial", 5)],
    );
    let viscosity = |rate: f64| {
        let [rest, high, time, n] = BIRD_CARREAU;
        let thinned = (1.0 + (time * rate).powi(2)).powf(0.5 * (n - 1.0));
        case.blood.density * (high + (rest - high) * thinned)
    };
    let [flow, shear] = shear_thinning_errors(&case, use_bird_carreau, &viscosity);
    assert!((flow - 0.0015).abs() < 5e-4, "{flow}");
    assert!((shear + 0.0017).abs() < 5e-4, "{shear}");
}

/// The models that the case chooses.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn casson_and_power_law_flow_is_exact() {
    let mesh = [
        ("fluid.mesh.core", "8"),
        ("fluid.mesh.radial", "5"),
        ("time.step_s", "0.01"),
    ];
    let casson = [
        ("blood.model", "casson"),
        ("blood.yield_stress_Pa", "0.02"),
        ("blood.zero_shear_viscosity_Pa_s", "0.1"),
    ];
    let power_law = [
        ("blood.model", "power_law"),
        ("blood.viscosity_Pa_s", "1e-4"),
        ("blood.zero_shear_viscosity_Pa_s", "0.1"),
        ("blood.consistency_Pa_sn", "0.017"),
        ("blood.exponent", "0.708"),
    ];
    for (model, [flow, shear]) in [
        (&casson[..], [0.0012, -0.0016]),
        (&power_law[..], [0.0029, -0.0017]),
    ] {
        let case = load("poiseuille", &[&mesh[..], model].concat());
        let blood = case.blood.rheology();
        let found = shear_thinning_errors(&case, |_| (), &|rate| blood.viscosity(rate));
        assert!((found[0] - flow).abs() < 5e-4, "{model:?}: {found:?}");
        assert!((found[1] - shear).abs() < 5e-4, "{model:?}: {found:?}");
    }
}

/// Bessel's function of order zero by its power series.
fn bessel_j0(z: C) -> C {
    let (mut term, mut sum) = (C::from(1.0), C::from(1.0));
    for k in 1..60 {
        term *= -z * z * 0.25 / (k * k) as f64;
        sum += term;
    }
    sum
}

/// Error of the velocity profile at the end of the run, root mean square over the cross-section relative to that of
/// the exact profile; and of the wall shear stress.
fn womersley_errors(core: usize, radial: usize) -> [f64; 2] {
    let mesh = [("fluid.mesh.core", core), ("fluid.mesh.radial", radial)];
    let case = load("womersley", &mesh);
    let mut tube = RigidTube::start(&case);
    let steps = case.steps();
    let last = (1..=steps).map(|n| tube.step(n == steps)).last().unwrap();

    // Womersley's solution, (s u = G + nu ∆u) with the symbol s of implicit Euler in place of i omega, so that only
    // the error in space remains.
    let g = &case.anastomosis().unwrap().geometry;
    let (radius, nu, dt) = (
        g.graft_inner_radius,
        case.blood.viscosity / case.blood.density,
        case.time.step,
    );
    let omega = TAU / case.time.period;
    let phase = |t: f64| C::from_polar(1.0, omega * t);
    let s = (C::from(1.0) - phase(-dt)) / dt;
    let lambda = (-s / nu).sqrt();
    let amplitude = 0.03 / (g.graft_length + g.artery_length);
    let swing = phase(last.time) * amplitude / s;
    let exact =
        |r: f64| (swing * (C::from(1.0) - bessel_j0(lambda * r) / bessel_j0(lambda * radius))).im;

    let (mut error, mut size) = (0.0, 0.0);
    for [u, r, volume] in tube.profile(&format!("{}", case.time.end)) {
        error += volume * (u - exact(r)).powi(2);
        size += volume * exact(r).powi(2);
    }
    let h = 1e-4 * radius;
    let exact_shear =
        case.blood.viscosity * (exact(radius - h) - exact(radius - 2.0 * h) * 0.25) * 4.0
            / (2.0 * h);
    let shear = last.wall_shear.iter().map(|t| t.x).sum::<f64>() / last.wall_shear.len() as f64;
    println!("{core} {radial}: shear {shear} Pa, exact {exact_shear} Pa");
    [(error / size).sqrt(), (shear / exact_shear - 1.0).abs()]
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn oscillating_flow_is_womersleys_to_second_order() {
    let coarse = womersley_errors(4, 3);
    let fine = womersley_errors(8, 6);
    let order = (coarse[0] / fine[0]).log2();
    println!("errors {coarse:?} {fine:?}, order {order}");
    // Profile and wall shear stress, as measured.
    for (found, measured) in [(coarse, [0.01639, 0.01671]), (fine, [0.003862, 0.007971])] {
        for (found, measured) in found.iter().zip(measured) {
            assert!((found / measured - 1.0).abs() < 0.02, "{found} {measured}");
        }
    }
    assert!((2.05..2.12).contains(&order), "{order}"); // measured 2.085
}
