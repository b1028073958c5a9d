//! What happens within one element, by sum factorization: products of tensors are contracted one direction at a time.
//!
//! With `J` the Jacobian of the mapping from local to spatial coordinates, `w` the weight of a Gauss point and
//! `G = w det J J⁻¹` (`G[d][k] = w det J ∂ξ_d/∂x_k`) an element contributes, for a velocity **u**, a pressure p, and a
//! convecting velocity **a**:
//! ```text
//! momentum:    ∫ rho v·(a·∇)u + mu ∇v:∇u - p div v,      continuity:   -∫ q div u.
//! ```

use super::basis::Basis;

/// What an element needs at its Gauss points, one component after the other.
#[derive(Debug, Clone, Copy)]
pub struct AtGauss<'a> {
    /// The nine components of `G`.
    pub cofactors: &'a [f64],
    /// `1/(w det J)`.
    pub inverse_weights: &'a [f64],
    /// `rho G a`, three components.
    pub convection: &'a [f64],
}

/// Working memory of one thread.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    contracted: [Vec<f64>; 2],
    values: Vec<f64>,
    gradient: [Vec<f64>; 3],
    pressure: Vec<f64>,
    divergence: Vec<f64>,
}

/// The operations of an element of some degree; fields are stored one component after the other.
pub trait Kernel: Send + Sync {
    /// Working memory.
    fn scratch(&self) -> Scratch;

    /// Values of a nodal field (one component) at the Gauss points.
    fn to_gauss(&self, nodal: &[f64], at_gauss: &mut [f64], scratch: &mut Scratch);

    /// Gradient of a nodal field (one component) at the Gauss points, in local coordinates.
    fn gradient(&self, nodal: &[f64], out: &mut [&mut [f64]; 3], scratch: &mut Scratch);

    /// Momentum and continuity of velocity and pressure, without the mass.
    fn oseen(
        &self,
        at: AtGauss,
        viscosity: f64,
        input: (&[f64], &[f64]),
        output: (&mut [f64], &mut [f64]),
        scratch: &mut Scratch,
    );

    /// `-∫ q div u`.
    fn minus_divergence(&self, cofactors: &[f64], u: &[f64], q: &mut [f64], scratch: &mut Scratch);

    /// `-∫ p div v`.
    fn minus_gradient(&self, cofactors: &[f64], p: &[f64], v: &mut [f64], scratch: &mut Scratch);
}

/// The kernel of a degree within [`Basis::DEGREES`].
pub fn kernel(basis: &Basis) -> Box<dyn Kernel> {
    match basis.degree() {
        3 => Box::new(Sized::<4, 5, 3>::new(basis)),
        4 => Box::new(Sized::<5, 6, 4>::new(basis)),
        5 => Box::new(Sized::<6, 8, 5>::new(basis)),
        6 => Box::new(Sized::<7, 9, 6>::new(basis)),
        7 => Box::new(Sized::<8, 11, 7>::new(basis)),
        8 => Box::new(Sized::<9, 12, 8>::new(basis)),
        other => unreachable!("the degree {other} was refused before"),
    }
}

/// A matrix that maps `A` values to `B`: `[a][b]`, so that the innermost loop runs over what is stored side by side.
type Map<const A: usize, const B: usize> = [[f64; B]; A];

fn map<const A: usize, const B: usize>(rows: &[Vec<f64>]) -> Map<A, B> {
    assert_eq!((rows.len(), rows[0].len()), (B, A));
    std::array::from_fn(|a| std::array::from_fn(|b| rows[b][a]))
}

fn transposed<const A: usize, const B: usize>(map: &Map<A, B>) -> Map<B, A> {
    std::array::from_fn(|b| std::array::from_fn(|a| map[a][b]))
}

/// Applies `map` along the fastest index: `count` rows of `A` values become rows of `B`.
fn along_first<const A: usize, const B: usize, const ADD: bool>(
    map: &Map<A, B>,
    count: usize,
    input: &[f64],
    output: &mut [f64],
) {
    let rows = input[..count * A].chunks_exact(A);
    for (row, out) in rows.zip(output[..count * B].chunks_exact_mut(B)) {
        let mut sum = [0.0; B];
        for a in 0..A {
            for b in 0..B {
                sum[b] += map[a][b] * row[a];
            }
        }
        for b in 0..B {
            out[b] = if ADD { out[b] + sum[b] } else { sum[b] };
        }
    }
}

/// Applies `map` along an index below which lie `INNER` values, `count` times.
fn along<const A: usize, const B: usize, const INNER: usize, const ADD: bool>(
    map: &Map<A, B>,
    count: usize,
    input: &[f64],
    output: &mut [f64],
) {
    let blocks = input[..count * A * INNER].chunks_exact(A * INNER);
    for (block, out) in blocks.zip(output[..count * B * INNER].chunks_exact_mut(B * INNER)) {
        for b in 0..B {
            let mut sum = [0.0; INNER];
            for a in 0..A {
                let row = &block[a * INNER..(a + 1) * INNER];
                for i in 0..INNER {
                    sum[i] += map[a][b] * row[i];
                }
            }
            let out = &mut out[b * INNER..(b + 1) * INNER];
            for i in 0..INNER {
                out[i] = if ADD { out[i] + sum[i] } else { sum[i] };
            }
        }
    }
}

/// A kernel for `N` nodes, `M` Gauss points and `P` pressure nodes per direction.
struct Sized<const N: usize, const M: usize, const P: usize> {
    to_gauss: Map<N, M>,
    from_gauss: Map<M, N>,
    pressure_to_gauss: Map<P, M>,
    pressure_from_gauss: Map<M, P>,
    derivative: Map<M, M>,
    derivative_transposed: Map<M, M>,
}

impl<const N: usize, const M: usize, const P: usize> Sized<N, M, P> {
    fn new(basis: &Basis) -> Self {
        let to_gauss = map(&basis.to_gauss);
        let pressure_to_gauss = map(&basis.pressure_to_gauss);
        let derivative = map(&basis.gauss_derivative);
        Self {
            from_gauss: transposed(&to_gauss),
            to_gauss,
            pressure_from_gauss: transposed(&pressure_to_gauss),
            pressure_to_gauss,
            derivative_transposed: transposed(&derivative),
            derivative,
        }
    }

    /// `A³` values become `B³`.
    fn interpolate<const A: usize, const B: usize>(
        map: &Map<A, B>,
        input: &[f64],
        output: &mut [f64],
        [first, second]: &mut [Vec<f64>; 2],
    ) {
        along_first::<A, B, false>(map, A * A, input, first);
        along::<A, B, B, false>(map, A, first, second);
        // Planes lie side by side
        let planes = B * B;
        for b in 0..B {
            let out = &mut output[b * planes..(b + 1) * planes];
            out.fill(0.0);
            for a in 0..A {
                let (c, row) = (map[a][b], &second[a * planes..(a + 1) * planes]);
                out.iter_mut().zip(row).for_each(|(o, r)| *o += c * r);
            }
        }
    }

    /// Local derivatives of values at the Gauss points.
    fn differentiate(&self, values: &[f64], [x, y, z]: &mut [&mut [f64]; 3]) {
        along_first::<M, M, false>(&self.derivative, M * M, values, x);
        along::<M, M, M, false>(&self.derivative, M, values, y);
        let planes = M * M;
        for b in 0..M {
            let out = &mut z[b * planes..(b + 1) * planes];
            out.fill(0.0);
            for a in 0..M {
                let (c, row) = (self.derivative[a][b], &values[a * planes..(a + 1) * planes]);
                out.iter_mut().zip(row).for_each(|(o, r)| *o += c * r);
            }
        }
    }

    /// Adds the transpose of [`Self::differentiate`].
    fn add_integrated(&self, [x, y, z]: [&[f64]; 3], values: &mut [f64]) {
        along_first::<M, M, true>(&self.derivative_transposed, M * M, x, values);
        along::<M, M, M, true>(&self.derivative_transposed, M, y, values);
        let planes = M * M;
        for b in 0..M {
            let out = &mut values[b * planes..(b + 1) * planes];
            for a in 0..M {
                let c = self.derivative_transposed[a][b];
                let row = &z[a * planes..(a + 1) * planes];
                out.iter_mut().zip(row).for_each(|(o, r)| *o += c * r);
            }
        }
    }
}

impl<const N: usize, const M: usize, const P: usize> Kernel for Sized<N, M, P> {
    fn scratch(&self) -> Scratch {
        let zeros = || vec![0.0; M * M * M];
        Scratch {
            contracted: [zeros(), zeros()],
            values: zeros(),
            gradient: [zeros(), zeros(), zeros()],
            pressure: zeros(),
            divergence: zeros(),
        }
    }

    fn to_gauss(&self, nodal: &[f64], at_gauss: &mut [f64], scratch: &mut Scratch) {
        Self::interpolate(&self.to_gauss, nodal, at_gauss, &mut scratch.contracted);
    }

    fn gradient(&self, nodal: &[f64], out: &mut [&mut [f64]; 3], scratch: &mut Scratch) {
        let Scratch {
            contracted, values, ..
        } = scratch;
        Self::interpolate(&self.to_gauss, nodal, values, contracted);
        self.differentiate(values, out);
    }

    fn oseen(
        &self,
        at: AtGauss,
        viscosity: f64,
        (u, p): (&[f64], &[f64]),
        (momentum, continuity): (&mut [f64], &mut [f64]),
        scratch: &mut Scratch,
    ) {
        let (n3, m3) = (N * N * N, M * M * M);
        let Scratch {
            contracted,
            values,
            gradient,
            pressure,
            divergence,
        } = scratch;
        Self::interpolate(&self.pressure_to_gauss, p, pressure, contracted);
        divergence.fill(0.0);
        let g = |i: usize| &at.cofactors[i * m3..(i + 1) * m3];
        let g: [&[f64]; 9] = std::array::from_fn(g);
        let a: [&[f64]; 3] = std::array::from_fn(|i| &at.convection[i * m3..(i + 1) * m3]);
        for c in 0..3 {
            Self::interpolate(&self.to_gauss, &u[c * n3..(c + 1) * n3], values, contracted);
            let [x, y, z] = gradient;
            self.differentiate(values, &mut [x, y, z]);
            let [x, y, z] = gradient;
            for q in 0..m3 {
                let d = [x[q], y[q], z[q]];
                values[q] = a[0][q] * d[0] + a[1][q] * d[1] + a[2][q] * d[2];
                let scale = viscosity * at.inverse_weights[q];
                let mut flux = [0.0; 3];
                for k in 0..3 {
                    let slope = g[k][q] * d[0] + g[3 + k][q] * d[1] + g[6 + k][q] * d[2];
                    flux[k] = scale * slope;
                    if k == c {
                        divergence[q] -= slope;
                        flux[k] -= pressure[q];
                    }
                }
                for (i, local) in [&mut *x, &mut *y, &mut *z].into_iter().enumerate() {
                    local[q] = g[3 * i][q] * flux[0]
                        + g[3 * i + 1][q] * flux[1]
                        + g[3 * i + 2][q] * flux[2];
                }
            }
            self.add_integrated([x, y, z], values);
            let out = &mut momentum[c * n3..(c + 1) * n3];
            Self::interpolate(&self.from_gauss, values, out, contracted);
        }
        Self::interpolate(
            &self.pressure_from_gauss,
            divergence,
            continuity,
            contracted,
        );
    }

    fn minus_divergence(&self, cofactors: &[f64], u: &[f64], q: &mut [f64], scratch: &mut Scratch) {
        let (n3, m3) = (N * N * N, M * M * M);
        let Scratch {
            contracted,
            values,
            gradient,
            divergence,
            ..
        } = scratch;
        divergence.fill(0.0);
        for c in 0..3 {
            Self::interpolate(&self.to_gauss, &u[c * n3..(c + 1) * n3], values, contracted);
            let [x, y, z] = gradient;
            self.differentiate(values, &mut [x, y, z]);
            for (i, local) in gradient.iter().enumerate() {
                let g = &cofactors[(3 * i + c) * m3..(3 * i + c + 1) * m3];
                for q in 0..m3 {
                    divergence[q] -= g[q] * local[q];
                }
            }
        }
        Self::interpolate(&self.pressure_from_gauss, divergence, q, contracted);
    }

    fn minus_gradient(&self, cofactors: &[f64], p: &[f64], v: &mut [f64], scratch: &mut Scratch) {
        let (n3, m3) = (N * N * N, M * M * M);
        let Scratch {
            contracted,
            values,
            gradient,
            pressure,
            ..
        } = scratch;
        Self::interpolate(&self.pressure_to_gauss, p, pressure, contracted);
        for c in 0..3 {
            for (i, local) in gradient.iter_mut().enumerate() {
                let g = &cofactors[(3 * i + c) * m3..(3 * i + c + 1) * m3];
                for q in 0..m3 {
                    local[q] = -g[q] * pressure[q];
                }
            }
            values.fill(0.0);
            let [x, y, z] = &*gradient;
            self.add_integrated([x, y, z], values);
            let out = &mut v[c * n3..(c + 1) * n3];
            Self::interpolate(&self.from_gauss, values, out, contracted);
        }
    }
}
