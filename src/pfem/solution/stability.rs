//! Where a path of equilibria loses its stability: the tangent is no longer positive definite.

use super::super::SolidError;
use super::super::discretization::Discretization;
use super::super::linear_algebra::factor::Factorization;
use fsi_numerics::{dot, words};

/// Relative change of an eigenvalue at which the iteration ends.
const TOLERANCE: f64 = 1e-8;
/// Most iterations; those with a nearly singular tangent take a few.
const MAX_ITERATIONS: usize = 500;

words! {
    /// What to do where the path of equilibria loses its stability.
    #[derive(Default)]
    pub enum AtBifurcation {
        /// End there.
        Stop = "stop" (default),
        /// Stay on the same path, which is unstable from there on.
        Continue = "continue",
        /// Leave it for the stable path that branches off in the direction of the buckling mode.
        Switch = "switch",
    }
}

/// A point where a path of equilibria loses its stability.
#[derive(Debug, Clone, PartialEq)]
pub struct Bifurcation {
    /// Share of the full load.
    pub factor: f64,
    /// The last stable displacement on the way there.
    pub displacement: Vec<f64>,
    /// The buckling mode: displacement coefficients, the largest displacement of a vertex 1 m.
    pub mode: Vec<f64>,
}

/// The eigenvalue of a tangent that is closest to zero.
#[derive(Debug, Clone, PartialEq)]
pub struct LowestMode {
    /// The eigenvalue, N/m, with respect to the Euclidean norm of the coefficients.
    pub eigenvalue: f64,
    /// Displacement coefficients, the largest displacement of a vertex 1 m.
    pub shape: Vec<f64>,
    /// Forces on the coefficients that displace a body with this tangent by the shape, N.
    pub force: Vec<f64>,
}

/// The mode of a factorized tangent whose eigenvalue is closest to zero, by inverse iteration.
pub fn lowest_mode(
    body: &Discretization,
    factorization: &Factorization,
) -> Result<LowestMode, SolidError> {
    let zero = vec![0.0; body.coefficients()];
    // No mode is orthogonal to such a start; components that are held stay zero.
    let start: Vec<f64> = (0..zero.len())
        .map(|i| ((i as f64 + 1.0) * 0.618_033_988_749_895).fract() - 0.5)
        .collect();
    let mut x = normalized(body.restrict(&start));
    let mut eigenvalue = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let mut image = x.clone();
        factorization.solve(&mut image)?;
        // The Rayleigh quotient of the inverse.
        let new = 1.0 / dot(&x, &image);
        x = normalized(image);
        let converged = (new - eigenvalue).abs() <= TOLERANCE * new.abs();
        eigenvalue = new;
        if converged {
            break;
        }
    }
    let shape = body.moved(&zero, &x, 1.0);
    let of_vertex = |&f: &usize| dot(&shape[3 * f..3 * f + 3], &shape[3 * f..3 * f + 3]).sqrt();
    let largest =
        (body.numbering.of_vertex.iter().map(of_vertex)).fold(f64::MIN_POSITIVE, f64::max);
    let scaled = |scale: f64| shape.iter().map(|s| scale * s).collect();
    Ok(LowestMode {
        eigenvalue,
        force: scaled(eigenvalue / largest),
        shape: scaled(1.0 / largest),
    })
}

fn normalized(mut x: Vec<f64>) -> Vec<f64> {
    let norm = dot(&x, &x).sqrt();
    x.iter_mut().for_each(|x| *x /= norm);
    x
}
