//! A cantilever under its own weight: `cargo run --release -p fsi-pfem --example cantilever`.
//!
//! A square bar, ten times as long as it is thick, is clamped at one end. For small displacements Timoshenko's theory
//! has the displacement of the tip under the weight `w` per length,
//! ```text
//! w L⁴/(8 E I) + w L²/(2 k G A)        (bending and shear; k = 10 (1 + ν)/(12 + 11 ν) for a rectangle)
//! ```
//! The program raises the degree of the elements on a mesh of four, and then the weight, until the bar hangs down and
//! only large deformations describe it.

use fsi_pfem::discretization::{Discretization, Options};
use fsi_pfem::material::SaintVenantKirchhoff;
use fsi_pfem::mesh::block_mesh;
use fsi_pfem::solution::statics::{self, Load, StaticOptions};
use fsi_pfem::supports::Support;
use fsi_pfem::{SolidError, Space, SpaceKind, Vec3};

const LENGTH: f64 = 1.0; // m
const SIDE: f64 = 0.1; // m
const YOUNG: f64 = 1e6; // Pa
const POISSON: f64 = 0.0; // as in beam theory, cross-sections keep their shape
const ELEMENTS: usize = 4;

fn main() -> Result<(), SolidError> {
    // 1. Timoshenko's beam.
    let (area, inertia) = (SIDE.powi(2), SIDE.powi(4) / 12.0);
    let shear_modulus = 0.5 * YOUNG / (1.0 + POISSON);
    let k = 10.0 * (1.0 + POISSON) / (12.0 + 11.0 * POISSON);
    let exact = |weight: f64| {
        let bending = weight * LENGTH.powi(4) / (8.0 * YOUNG * inertia);
        bending + weight * LENGTH.powi(2) / (2.0 * k * shear_modulus * area)
    };

    // 2. The same with elements of rising degree, for a weight that hardly bends it.
    let light = 1e-3; // N/m
    println!("degree   unknowns   tip of the beam's");
    for degree in 1..=6 {
        let (unknowns, tip) = hang(degree, light)?;
        let ratio = -tip.z / exact(light);
        println!("{degree:>6}{unknowns:>11}{:>15.3} %", 100.0 * ratio);
        assert!(degree < 3 || (ratio - 1.0).abs() < 5e-4, "{ratio}");
    }

    // 3. More and more weight: the tip comes back towards the clamp, and no beam theory of small displacements has it.
    println!("weight, N/m   down, m   back, m   (small displacements: down, m)");
    for weight in [0.1, 1.0, 10.0, 40.0] {
        let (_, tip) = hang(5, weight)?;
        println!(
            "{weight:>11}{:>10.4}{:>10.4}{:>21.4}",
            -tip.z,
            -tip.x,
            exact(weight)
        );
    }
    Ok(())
}

/// Unknowns, and the displacement (m) of the middle of the free end, under a weight (N/m).
fn hang(degree: usize, weight: f64) -> Result<(usize, Vec3), SolidError> {
    let mesh = block_mesh([LENGTH, SIDE, SIDE], [ELEMENTS, 1, 1]);
    let material = SaintVenantKirchhoff::new(YOUNG, POISSON);
    let clamp = [Support::Clamped("start".into())];
    let options = Options::new(Space::isotropic(SpaceKind::Trunk, degree));
    let body = Discretization::new(&mesh, &[material], &clamp, &options)?;
    let load = Load::Forces(body.body_forces(-Vec3::z() * weight / SIDE.powi(2)));
    let result = statics::solve(&body, &[load], None, &StaticOptions::default())?;
    let tip = body.displacement_at(ELEMENTS - 1, [1.0, 0.0, 0.0], &result.displacement);
    Ok((body.degrees_of_freedom(), tip))
}
