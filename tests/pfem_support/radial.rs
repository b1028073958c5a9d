//! The thick-walled tube between planes that keep their distance, in a surrounding of springs, as a boundary value
//! problem in the radius alone, solved without any of the library's code: the radius `r(R)` of each layer is a
//! polynomial through Chebyshev points, equilibrium is the vanishing first variation of the energy, integrated with
//! many Gauss points (Golub-Welsch), Newton's method does the rest.

#![allow(non_snake_case)]

use fsi_driver::case::Material;
use nalgebra::{DMatrix, DVector};

/// Degree of the radius within a layer.
const DEGREE: usize = 14;
/// Gauss points per layer.
const POINTS: usize = 40;

/// Energy density and its derivatives by the radial and the circumferential stretch `a` and `b`; `c` is the axial one.
fn density(material: &Material, a: f64, b: f64, c: f64) -> (f64, [f64; 2], [[f64; 2]; 2]) {
    let J = a * b * c;
    match *material {
        Material::NeoHooke { mu, kappa, .. } => {
            let ln = J.ln();
            let w = 0.5 * mu * (a * a + b * b + c * c - 3.0) - mu * ln + 0.5 * kappa * ln * ln;
            let s = kappa * ln - mu;
            let first = [mu * a + s / a, mu * b + s / b];
            let diagonal = |x: f64| mu + (kappa - s) / (x * x);
            let mixed = kappa / (a * b);
            (w, first, [[diagonal(a), mixed], [mixed, diagonal(b)]])
        }
        Material::SaintVenantKirchhoff {
            youngs_modulus: e,
            poisson_ratio: nu,
            ..
        } => {
            let lambda = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
            let mu = e / (2.0 * (1.0 + nu));
            let [ea, eb, ec] = [a, b, c].map(|stretch| 0.5 * (stretch * stretch - 1.0));
            let trace = ea + eb + ec;
            let [sa, sb] = [ea, eb].map(|strain| lambda * trace + 2.0 * mu * strain);
            let w = 0.5 * lambda * trace.powi(2) + mu * (ea * ea + eb * eb + ec * ec);
            let stiffness = lambda + 2.0 * mu;
            let mixed = lambda * a * b;
            let second = [
                [sa + stiffness * a * a, mixed],
                [mixed, sb + stiffness * b * b],
            ];
            (w, [a * sa, b * sb], second)
        }
        Material::LinearElastic {
            youngs_modulus: e,
            poisson_ratio: nu,
        } => {
            let lambda = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
            let mu = e / (2.0 * (1.0 + nu));
            let strains = [a, b, c].map(|stretch| stretch - 1.0);
            let trace: f64 = strains.iter().sum();
            let squares: f64 = strains.iter().map(|strain| strain * strain).sum();
            let [sa, sb] = [0, 1].map(|i| lambda * trace + 2.0 * mu * strains[i]);
            let stiffness = lambda + 2.0 * mu;
            let second = [[stiffness, lambda], [lambda, stiffness]];
            (
                0.5 * lambda * trace.powi(2) + mu * squares,
                [sa, sb],
                second,
            )
        }
        Material::HolzapfelGasserOgden {
            mu,
            kappa,
            k1,
            k2,
            fibre_angle_deg,
            dispersion,
            tension_only,
            ..
        } => {
            // Isochoric part: mu/2 (J^{-2/3} I - 3).
            let i = a * a + b * b + c * c;
            let j = J.powf(-2.0 / 3.0);
            let mut w = 0.5 * mu * (j * i - 3.0) + 0.5 * kappa * (J - 1.0).powi(2);
            let x = [a, b];
            let other = [b, a];
            let mut first = [0.0; 2];
            let mut second = [[0.0; 2]; 2];
            for p in 0..2 {
                first[p] = 0.5 * mu * j * (2.0 * x[p] - 2.0 / 3.0 * i / x[p])
                    + kappa * (J - 1.0) * other[p] * c;
                for q in 0..2 {
                    // d/dx_q of j (2 x_p - 2/3 i / x_p)
                    let slope = j * (-2.0 / 3.0 / x[q]) * (2.0 * x[p] - 2.0 / 3.0 * i / x[p])
                        + j * (-2.0 / 3.0 * 2.0 * x[q] / x[p])
                        + if p == q {
                            j * (2.0 + 2.0 / 3.0 * i / (x[p] * x[p]))
                        } else {
                            0.0
                        };
                    let bulk =
                        other[p] * other[q] * c * c + if p == q { 0.0 } else { (J - 1.0) * c };
                    second[p][q] = 0.5 * mu * slope + kappa * bulk;
                }
            }
            // Both families of fibres stretch alike.
            let (sin, cos) = fibre_angle_deg.to_radians().sin_cos();
            let spread = dispersion.unwrap_or(0.0);
            let aligned = 1.0 - 3.0 * spread;
            let strain =
                spread * (i - 3.0) + aligned * (cos * cos * b * b + sin * sin * c * c - 1.0);
            if !(tension_only && strain < 0.0) {
                let exponential = (k2 * strain * strain).exp();
                let slopes = [2.0 * spread * a, 2.0 * (spread + aligned * cos * cos) * b];
                let curvatures = [2.0 * spread, 2.0 * (spread + aligned * cos * cos)];
                w += k1 / k2 * (exponential - 1.0);
                let psi = 2.0 * k1 * strain * exponential;
                let curvature = 2.0 * k1 * exponential * (1.0 + 2.0 * k2 * strain * strain);
                for p in 0..2 {
                    first[p] += psi * slopes[p];
                    second[p][p] += psi * curvatures[p];
                    (0..2).for_each(|q| second[p][q] += curvature * slopes[p] * slopes[q]);
                }
            }
            (w, first, second)
        }
    }
}

/// Points and weights on [-1, 1] from the eigenvalues of the Jacobi matrix of the Legendre polynomials.
fn gauss(n: usize) -> Vec<(f64, f64)> {
    let matrix = DMatrix::from_fn(n, n, |i, j| {
        let k = i.max(j) as f64;
        if i.abs_diff(j) == 1 {
            k / (4.0 * k * k - 1.0).sqrt()
        } else {
            0.0
        }
    });
    let eigen = matrix.symmetric_eigen();
    (0..n)
        .map(|i| {
            (
                eigen.eigenvalues[i],
                2.0 * eigen.eigenvectors[(0, i)].powi(2),
            )
        })
        .collect()
}

/// Solution of the tube.
pub struct RadialTube {
    /// Strain energy per length, J/m.
    pub energy: f64,
    /// Radial displacement at the inner radius, each interface and the outer radius, m.
    pub displacement: Vec<f64>,
}

/// What acts on a tube.
#[derive(Clone, Copy)]
pub struct Loading {
    /// Pressure inside, Pa.
    pub pressure: f64,
    /// Whether pressures act on the deformed area.
    pub follower: bool,
    /// Length between the planes relative to the unloaded one.
    pub axial_stretch: f64,
    /// Pressure outside, Pa.
    pub outer_pressure: f64,
    /// Springs outside, Pa/m of the reference area, or of the area where they are at rest.
    pub spring: f64,
    /// Displacement (m) of the outer surface with which they are at rest in a stretched tube, if that is not the
    /// unloaded one.
    pub rest: Option<f64>,
}

/// Inflates a tube of layers `(thickness, material)` from the inner radius outward by `pressure`, in plane strain.
pub fn inflate(
    inner_radius: f64,
    layers: &[(f64, Material)],
    pressure: f64,
    follower: bool,
) -> RadialTube {
    let loading = Loading {
        pressure,
        follower,
        axial_stretch: 1.0,
        outer_pressure: 0.0,
        spring: 0.0,
        rest: None,
    };
    solve(inner_radius, layers, &loading)
}

/// Equilibrium of a tube of layers `(thickness, material)` from the inner radius outward.
pub fn solve(inner_radius: f64, layers: &[(f64, Material)], loading: &Loading) -> RadialTube {
    let Loading {
        pressure,
        follower,
        outer_pressure,
        spring,
        rest,
        ..
    } = *loading;
    let nodes: Vec<f64> = (0..=DEGREE)
        .map(|i| -(std::f64::consts::PI * i as f64 / DEGREE as f64).cos())
        .collect();
    let lagrange = |i: usize, x: f64| -> (f64, f64) {
        let others = || (0..=DEGREE).filter(move |&j| j != i);
        let value = others()
            .map(|j| (x - nodes[j]) / (nodes[i] - nodes[j]))
            .product();
        let slope = others()
            .map(|k| {
                let rest = others().filter(|&j| j != k);
                rest.map(|j| (x - nodes[j]) / (nodes[i] - nodes[j]))
                    .product::<f64>()
                    / (nodes[i] - nodes[k])
            })
            .sum();
        (value, slope)
    };
    type Shapes = Vec<(f64, f64)>;
    let table: Vec<(f64, f64, Shapes)> = gauss(POINTS)
        .into_iter()
        .map(|(x, w)| (x, w, (0..=DEGREE).map(|i| lagrange(i, x)).collect()))
        .collect();
    let unknowns = layers.len() * DEGREE + 1;
    let mut starts = vec![inner_radius];
    layers
        .iter()
        .for_each(|(t, _)| starts.push(starts[starts.len() - 1] + t));
    let mut u = DVector::<f64>::zeros(unknowns);
    let outer_radius = starts[layers.len()];
    let evaluate = |u: &DVector<f64>, c: f64| {
        let mut energy = 0.0;
        let mut force = DVector::<f64>::zeros(unknowns);
        let mut stiffness = DMatrix::<f64>::zeros(unknowns, unknowns);
        for (layer, (thickness, material)) in layers.iter().enumerate() {
            for (x, weight, shapes) in &table {
                let R = starts[layer] + 0.5 * thickness * (1.0 + x);
                let dV = 2.0 * std::f64::consts::PI * R * weight * 0.5 * thickness;
                let scale = 2.0 / thickness;
                let [mut radial, mut hoop] = [0.0; 2];
                for (i, (value, slope)) in shapes.iter().enumerate() {
                    radial += slope * u[layer * DEGREE + i];
                    hoop += value * u[layer * DEGREE + i];
                }
                let (a, b) = (1.0 + scale * radial, 1.0 + hoop / R);
                let (w, first, second) = density(material, a, b, c);
                energy += w * dV;
                // Sums are spelt out: tests are not compiled for speed, and some spend most of their seconds here.
                for (i, si) in shapes.iter().enumerate() {
                    let bi = [scale * si.1 * dV, si.0 / R * dV];
                    force[layer * DEGREE + i] += first[0] * bi[0] + first[1] * bi[1];
                    let row = [0, 1].map(|q| bi[0] * second[0][q] + bi[1] * second[1][q]);
                    for (j, sj) in shapes.iter().enumerate() {
                        stiffness[(layer * DEGREE + i, layer * DEGREE + j)] +=
                            row[0] * scale * sj.1 + row[1] * sj.0 / R;
                    }
                }
            }
        }
        (energy, force, stiffness)
    };
    let steps = 40;
    let circumference = 2.0 * std::f64::consts::PI;
    for step in 1..=steps {
        let share = step as f64 / steps as f64;
        let stretch = 1.0 + share * (loading.axial_stretch - 1.0);
        let mut converged = 0;
        for iteration in 0.. {
            assert!(iteration < 100, "the radial reference does not converge");
            let (_, mut residual, mut stiffness) = evaluate(&u, stretch);
            // Per length of the reference: the deformed area is longer by the axial stretch.
            for (place, radius, p) in [
                (0, inner_radius, share * pressure),
                (unknowns - 1, outer_radius, -share * outer_pressure),
            ] {
                if follower {
                    residual[place] -= p * circumference * stretch * (radius + u[place]);
                    stiffness[(place, place)] -= p * circumference * stretch;
                } else {
                    residual[place] -= p * circumference * radius;
                }
            }
            let (at_rest, area) = match rest {
                None => (0.0, circumference * outer_radius),
                Some(rest) => (
                    rest,
                    circumference * (outer_radius + rest) * loading.axial_stretch,
                ),
            };
            let held = spring * area;
            residual[unknowns - 1] += held * (u[unknowns - 1] - share * at_rest);
            stiffness[(unknowns - 1, unknowns - 1)] += held;
            let change = stiffness.lu().solve(&residual).expect("regular");
            u -= &change;
            if change.norm() < 1e-11 * u.norm() {
                converged += 1;
            }
            if converged == 2 {
                break;
            }
        }
    }
    let places = (0..=layers.len()).map(|k| u[k * DEGREE]).collect();
    RadialTube {
        energy: evaluate(&u, loading.axial_stretch).0,
        displacement: places,
    }
}

/// The unloaded inner radius (m) and layers of a tube whose inner radius and layers `(thickness, material)` are these
/// under a loading, without springs.
pub fn unload(
    inner_radius: f64,
    layers: &[(f64, Material)],
    loading: &Loading,
) -> (f64, Vec<(f64, Material)>) {
    let mut given = vec![inner_radius];
    layers
        .iter()
        .for_each(|(t, _)| given.push(given[given.len() - 1] + t));
    let layers_of = |radii: &DVector<f64>| -> Vec<(f64, Material)> {
        let pairs = layers.iter().enumerate();
        pairs
            .map(|(k, (_, material))| (radii[k + 1] - radii[k], material.clone()))
            .collect()
    };
    let loaded = |radii: &DVector<f64>| {
        let tube = solve(radii[0], &layers_of(radii), loading);
        DVector::from_fn(radii.len(), |k, _| {
            radii[k] + tube.displacement[k] - given[k]
        })
    };
    // A tube of nearly the same volume that is three quarters as wide, then Newton's method with differences.
    let volume = |k: usize| given[k].powi(2) - inner_radius.powi(2);
    let wide =
        |k: usize| ((0.75 * inner_radius).powi(2) + loading.axial_stretch * volume(k)).sqrt();
    let mut radii = DVector::from_fn(given.len(), |k, _| wide(k));
    for iteration in 0.. {
        assert!(iteration < 50, "the radial reference is not unloaded");
        let error = loaded(&radii);
        let step = 1e-7 * inner_radius;
        let columns: Vec<DVector<f64>> = (0..radii.len())
            .map(|k| {
                let mut moved = radii.clone();
                moved[k] += step;
                (loaded(&moved) - &error) / step
            })
            .collect();
        let change = (DMatrix::from_columns(&columns).lu())
            .solve(&error)
            .expect("regular");
        let share = f64::min(1.0, 0.05 * inner_radius / change.amax());
        radii -= share * &change;
        if change.amax() < 1e-10 * inner_radius {
            break;
        }
    }
    (radii[0], layers_of(&radii))
}
