//! Where walls lose their stability: buckling loads against theory, and the paths beyond them.

use fsi_driver::case::Material;
use fsi_driver::geometry::tube_mesh;
use fsi_driver::pfem::discretization::{Discretization, Options};
use fsi_driver::pfem::element::surface::{LoadKind, Surface};
use fsi_driver::pfem::solution::stability::AtBifurcation;
use fsi_driver::pfem::solution::statics::{self, Equilibrated, Load, StaticOptions};
use fsi_driver::pfem::supports::{self, Support};
use fsi_driver::pfem::{Space, SpaceKind, SurfaceLoad};
use std::f64::consts::PI;

const YOUNG: f64 = 1e6;
const POISSON: f64 = 0.3;
const RADII: [f64; 2] = [0.95e-3, 1.05e-3];
const LENGTH: f64 = 120e-3;

/// A long, thin, clamped tube of a linear elastic material.
fn thin_tube(p: usize) -> Discretization {
    let mesh = tube_mesh(RADII[0], &[RADII[1] - RADII[0]], LENGTH, 6, 4, 1);
    let material = Material::SaintVenantKirchhoff {
        youngs_modulus: YOUNG,
        poisson_ratio: POISSON,
        viscosity: None,
    };
    let supports = ["start", "end"].map(|end| Support::Clamped(end.into()));
    let space = Space {
        kind: SpaceKind::Trunk,
        degrees: [p, p, 2],
    };
    Discretization::new(&mesh, &[material], &supports, &Options::new(space)).unwrap()
}

fn inflate(body: &Discretization, pressure: f64, at_bifurcation: AtBifurcation) -> Equilibrated {
    let mesh = tube_mesh(RADII[0], &[RADII[1] - RADII[0]], LENGTH, 6, 4, 1);
    let faces = supports::surface(&mesh, "inner").unwrap();
    let surface = Surface::new(&body.numbering, &body.space, &body.mapping, faces, 8).unwrap();
    let points = surface.points.len();
    let load = Load::Surface {
        before: None,
        surface: &surface,
        values: SurfaceLoad::uniform_pressure(pressure, points),
        kind: LoadKind::Follower,
    };
    let options = StaticOptions {
        at_bifurcation,
        ..Default::default()
    };
    statics::solve(body, &[load], None, &options).unwrap()
}

/// Pressure at which a clamped tube buckles sideways under inner pressure: the thrust `p A_i` of the fluid less the
/// tension `2 nu p A_i` of the wall whose ends cannot approach each other reaches Euler's load `4 pi² E I / L²`,
/// reduced by the compliance in shear (Haringx: *Instability of thin-walled cylinders subjected to internal pressure*,
/// 1952; shear: Timoshenko and Gere, *Theory of Elastic Stability*, 1961, section 2.17, coefficient 2 of a thin ring).
fn critical_pressure() -> f64 {
    let [inner, outer] = RADII;
    let inertia = PI / 4.0 * (outer.powi(4) - inner.powi(4));
    let wall = PI * (outer.powi(2) - inner.powi(2));
    let euler = 4.0 * PI * PI * YOUNG * inertia / (LENGTH * LENGTH);
    let shear = YOUNG / (2.0 * (1.0 + POISSON)) * wall / 2.0;
    euler / (1.0 + euler / shear) / (PI * inner * inner * (1.0 - 2.0 * POISSON))
}

/// Shift (m) of the middle of the inner surface at mid-length: mean over two opposite vertices.
fn shift(body: &Discretization, d: &[f64]) -> f64 {
    // Third of six slices of four elements: its upper end is at mid-length.
    let of = |around: usize| body.displacement_at(2 * 4 + around, [1.0, -1.0, -1.0], d);
    (0.5 * (of(0) + of(2))).yz().norm()
}

/// It does so at the pressure of Haringx's theory.
#[test]
fn a_thin_clamped_tube_buckles_under_inner_pressure() {
    let body = thin_tube(5);
    let theory = critical_pressure();
    let full = 1.3 * theory;

    let stopped = inflate(&body, full, AtBifurcation::Stop);
    let bifurcation = stopped.bifurcation.clone().expect("it buckles");
    let error = bifurcation.factor * full / theory - 1.0;
    println!("buckles at {:.4} of the theory", 1.0 + error);
    assert!(error.abs() < 0.03, "{error}");
    // It ends before, still straight; the mode is that of a beam, with its largest deflection at mid-length.
    let distance = stopped.factor - bifurcation.factor;
    assert!(distance.abs() < 3e-3, "{distance}");
    assert!(stopped.complete().is_err());
    assert!((shift(&body, &bifurcation.mode) - 1.0).abs() < 0.05);

    let straight = inflate(&body, full, AtBifurcation::Continue);
    let bent = inflate(&body, full, AtBifurcation::Switch);
    assert_eq!((straight.factor, bent.factor), (1.0, 1.0));
    let [straight, bent] = [straight, bent].map(|found| shift(&body, &found.displacement));
    println!("shift {straight:.2e} m on the unstable path, {bent:.2e} m on the stable one");
    assert!(straight < 1e-8, "{straight:e}");
    assert!(bent > RADII[0] && bent < LENGTH / 4.0, "{bent:e}");
}
