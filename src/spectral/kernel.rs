//! What happens within the elements, by sum factorization: products of tensors are contracted one direction at a time.
//!
//! With `J` the Jacobian of the mapping from local to spatial coordinates, `w` the weight of a Gauss point and
//! `G = w det J J⁻¹` (`G[d][k] = w det J ∂ξ_d/∂x_k`) an element contributes, for a velocity **u**, a pressure p, and a
//! convecting velocity **a**:
//! ```text
//! momentum:    ∫ rho v·(a·∇)u + mu ∇v:∇u - p div v,      continuity:   -∫ q div u.
//! ```
//! [`LANES`] elements are worked on side by side: all arrays hold the values of the first component at the first point,
//! of all of these elements, then those at the next point, and so on; then the next component.

use super::basis::Basis;
use super::contraction::{
    LANES, Map, add_integrated, differentiate, interpolate, map, registers, transposed, view,
    view_mut,
};
use pulp::{Arch, Simd, WithSimd};

/// What elements need at their Gauss points, one component after the other.
#[derive(Debug, Clone, Copy)]
pub struct AtGauss<'a> {
    /// The nine components of `G`.
    pub cofactors: &'a [f64],
    /// `G Gᵀ/(w det J)`: components 00, 01, 02, 11, 12, 22.
    pub stiffness: &'a [f64],
    /// `rho G a`, three components.
    pub convection: &'a [f64],
    /// Dynamic viscosity, Pa s.
    pub viscosity: Viscosity<'a>,
}

/// Dynamic viscosity, Pa s.
#[derive(Debug, Clone, Copy)]
pub enum Viscosity<'a> {
    /// The same everywhere.
    Constant(f64),
    /// At the Gauss points.
    AtGauss(&'a [f64]),
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

/// The working memory as registers: `contracted` for products in progress, the others with the values of all Gauss
/// points.
struct Views<'a, V> {
    contracted: [&'a mut [V]; 2],
    values: &'a mut [V],
    gradient: [&'a mut [V]; 3],
    pressure: &'a mut [V],
    divergence: &'a mut [V],
}

impl Scratch {
    #[inline(always)]
    fn views<S: Simd, const M: usize>(&mut self) -> Views<'_, S::f64s> {
        let m3 = M * M * M * registers::<S>();
        Views {
            contracted: self.contracted.each_mut().map(|v| view_mut::<S>(v)),
            values: &mut view_mut::<S>(&mut self.values)[..m3],
            gradient: (self.gradient.each_mut()).map(|v| &mut view_mut::<S>(v)[..m3]),
            pressure: &mut view_mut::<S>(&mut self.pressure)[..m3],
            divergence: &mut view_mut::<S>(&mut self.divergence)[..m3],
        }
    }
}

/// The operations of elements of some degree.
pub trait Kernel: Send + Sync {
    /// Working memory.
    fn scratch(&self) -> Scratch;

    /// Values of a nodal field (one component) at the Gauss points.
    fn to_gauss(&self, nodal: &[f64], at_gauss: &mut [f64], scratch: &mut Scratch);

    /// Gradient of a nodal field (one component) at the Gauss points, in local coordinates.
    fn gradient(&self, nodal: &[f64], out: [&mut [f64]; 3], scratch: &mut Scratch);

    /// Gradient of a nodal field (one component) at the nodes, in local coordinates.
    fn nodal_gradient(&self, nodal: &[f64], out: [&mut [f64]; 3]);

    /// Momentum and continuity of velocity and pressure, without the mass.
    fn oseen(
        &self,
        at: AtGauss,
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

/// A kernel for `N` nodes, `M` Gauss points and `P` pressure nodes per direction.
struct Sized<const N: usize, const M: usize, const P: usize> {
    processor: Arch,
    to_gauss: Map<N, M>,
    from_gauss: Map<M, N>,
    pressure_to_gauss: Map<P, M>,
    pressure_from_gauss: Map<M, P>,
    derivative: Map<M, M>,
    derivative_transposed: Map<M, M>,
    nodal_derivative: Map<N, N>,
}

impl<const N: usize, const M: usize, const P: usize> Sized<N, M, P> {
    fn new(basis: &Basis) -> Self {
        let to_gauss = map(&basis.to_gauss);
        let pressure_to_gauss = map(&basis.pressure_to_gauss);
        let derivative = map(&basis.gauss_derivative);
        Self {
            processor: Arch::new(),
            from_gauss: transposed(&to_gauss),
            to_gauss,
            pressure_from_gauss: transposed(&pressure_to_gauss),
            pressure_to_gauss,
            derivative_transposed: transposed(&derivative),
            derivative,
            nodal_derivative: map(&basis.nodal_derivative),
        }
    }
}

/// Elements of a kernel at work, for the instructions of a processor.
struct Work<'a, const N: usize, const M: usize, const P: usize, J> {
    kernel: &'a Sized<N, M, P>,
    job: J,
}

struct ToGauss<'a> {
    nodal: &'a [f64],
    at_gauss: &'a mut [f64],
    scratch: &'a mut Scratch,
}

impl<const N: usize, const M: usize, const P: usize> WithSimd for Work<'_, N, M, P, ToGauss<'_>> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let ToGauss {
            nodal,
            at_gauss,
            scratch,
        } = self.job;
        let [first, second] = &mut scratch.contracted;
        interpolate::<S, N, M>(
            simd,
            &self.kernel.to_gauss,
            view::<S>(nodal),
            view_mut::<S>(at_gauss),
            [view_mut::<S>(first), view_mut::<S>(second)],
        );
    }
}

struct Gradient<'a> {
    nodal: &'a [f64],
    out: [&'a mut [f64]; 3],
    scratch: &'a mut Scratch,
}

impl<const N: usize, const M: usize, const P: usize> WithSimd for Work<'_, N, M, P, Gradient<'_>> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Gradient {
            nodal,
            out,
            scratch,
        } = self.job;
        let [first, second] = &mut scratch.contracted;
        interpolate::<S, N, M>(
            simd,
            &self.kernel.to_gauss,
            view::<S>(nodal),
            view_mut::<S>(&mut scratch.values),
            [view_mut::<S>(first), view_mut::<S>(second)],
        );
        differentiate::<S, M>(
            simd,
            &self.kernel.derivative,
            view::<S>(&scratch.values),
            out.map(|out| view_mut::<S>(out)),
        );
    }
}

struct NodalGradient<'a> {
    nodal: &'a [f64],
    out: [&'a mut [f64]; 3],
}

impl<const N: usize, const M: usize, const P: usize> WithSimd
    for Work<'_, N, M, P, NodalGradient<'_>>
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let NodalGradient { nodal, out } = self.job;
        differentiate::<S, N>(
            simd,
            &self.kernel.nodal_derivative,
            view::<S>(nodal),
            out.map(|out| view_mut::<S>(out)),
        );
    }
}

struct Oseen<'a> {
    at: AtGauss<'a>,
    u: &'a [f64],
    p: &'a [f64],
    momentum: &'a mut [f64],
    continuity: &'a mut [f64],
    scratch: &'a mut Scratch,
}

impl<const N: usize, const M: usize, const P: usize> WithSimd for Work<'_, N, M, P, Oseen<'_>> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let r = registers::<S>();
        let (n3, m3) = (N * N * N * r, M * M * M * r);
        let Oseen {
            at,
            u,
            p,
            momentum,
            continuity,
            scratch,
        } = self.job;
        let Views {
            contracted: [first, second],
            values,
            gradient: [x, y, z],
            pressure,
            divergence,
        } = scratch.views::<S, M>();
        let kernel = self.kernel;
        let map = &kernel.pressure_to_gauss;
        interpolate::<S, P, M>(simd, map, view::<S>(p), pressure, [first, second]);
        divergence.fill(simd.splat_f64s(0.0));
        let g = view::<S>(at.cofactors);
        let k = view::<S>(at.stiffness);
        let a = view::<S>(at.convection);
        let k: [&[S::f64s]; 6] = std::array::from_fn(|i| &k[i * m3..(i + 1) * m3]);
        let a: [&[S::f64s]; 3] = std::array::from_fn(|i| &a[i * m3..(i + 1) * m3]);
        let (u, momentum) = (view::<S>(u), view_mut::<S>(momentum));
        let (constant, field) = match at.viscosity {
            Viscosity::Constant(viscosity) => (viscosity, None),
            Viscosity::AtGauss(field) => (0.0, Some(view::<S>(field))),
        };
        let constant = simd.splat_f64s(constant);
        for c in 0..3 {
            let input = &u[c * n3..(c + 1) * n3];
            interpolate::<S, N, M>(simd, &kernel.to_gauss, input, values, [first, second]);
            differentiate::<S, M>(simd, &kernel.derivative, values, [x, y, z]);
            let g = column(g, c, m3);
            for q in 0..m3 {
                let d = [x[q], y[q], z[q]];
                let g = [g[0][q], g[1][q], g[2][q]];
                let viscosity = field.map_or(constant, |field| field[q]);
                values[q] = dot(simd, [a[0][q], a[1][q], a[2][q]], d);
                divergence[q] = simd.sub_f64s(divergence[q], dot(simd, g, d));
                let rows = [
                    [k[0][q], k[1][q], k[2][q]],
                    [k[1][q], k[3][q], k[4][q]],
                    [k[2][q], k[4][q], k[5][q]],
                ];
                for (out, (g, row)) in [&mut x[q], &mut y[q], &mut z[q]]
                    .into_iter()
                    .zip(g.into_iter().zip(rows))
                {
                    let viscous = simd.mul_f64s(viscosity, dot(simd, row, d));
                    *out = simd.sub_f64s(viscous, simd.mul_f64s(g, pressure[q]));
                }
            }
            add_integrated::<S, M>(simd, &kernel.derivative_transposed, [x, y, z], values);
            let out = &mut momentum[c * n3..(c + 1) * n3];
            interpolate::<S, M, N>(simd, &kernel.from_gauss, values, out, [first, second]);
        }
        let map = &kernel.pressure_from_gauss;
        let out = view_mut::<S>(continuity);
        interpolate::<S, M, P>(simd, map, divergence, out, [first, second]);
    }
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: [S::f64s; 3], b: [S::f64s; 3]) -> S::f64s {
    let sum = simd.mul_add_e_f64s(a[1], b[1], simd.mul_f64s(a[0], b[0]));
    simd.mul_add_e_f64s(a[2], b[2], sum)
}

/// What belongs to component `c` of the velocity among nine components of `m3` values.
#[inline(always)]
fn column<V>(g: &[V], c: usize, m3: usize) -> [&[V]; 3] {
    std::array::from_fn(|d| &g[(3 * d + c) * m3..(3 * d + c + 1) * m3])
}

struct MinusDivergence<'a> {
    cofactors: &'a [f64],
    u: &'a [f64],
    q: &'a mut [f64],
    scratch: &'a mut Scratch,
}

impl<const N: usize, const M: usize, const P: usize> WithSimd
    for Work<'_, N, M, P, MinusDivergence<'_>>
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let r = registers::<S>();
        let (n3, m3) = (N * N * N * r, M * M * M * r);
        let MinusDivergence {
            cofactors,
            u,
            q,
            scratch,
        } = self.job;
        let Views {
            contracted: [first, second],
            values,
            gradient: [x, y, z],
            divergence,
            ..
        } = scratch.views::<S, M>();
        divergence.fill(simd.splat_f64s(0.0));
        let kernel = self.kernel;
        let (u, g) = (view::<S>(u), view::<S>(cofactors));
        for c in 0..3 {
            let input = &u[c * n3..(c + 1) * n3];
            interpolate::<S, N, M>(simd, &kernel.to_gauss, input, values, [first, second]);
            differentiate::<S, M>(simd, &kernel.derivative, values, [x, y, z]);
            let g = column(g, c, m3);
            for i in 0..m3 {
                let sum = dot(simd, [g[0][i], g[1][i], g[2][i]], [x[i], y[i], z[i]]);
                divergence[i] = simd.sub_f64s(divergence[i], sum);
            }
        }
        let map = &kernel.pressure_from_gauss;
        interpolate::<S, M, P>(simd, map, divergence, view_mut::<S>(q), [first, second]);
    }
}

struct MinusGradient<'a> {
    cofactors: &'a [f64],
    p: &'a [f64],
    v: &'a mut [f64],
    scratch: &'a mut Scratch,
}

impl<const N: usize, const M: usize, const P: usize> WithSimd
    for Work<'_, N, M, P, MinusGradient<'_>>
{
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let r = registers::<S>();
        let (n3, m3) = (N * N * N * r, M * M * M * r);
        let MinusGradient {
            cofactors,
            p,
            v,
            scratch,
        } = self.job;
        let Views {
            contracted: [first, second],
            values,
            gradient: [x, y, z],
            pressure,
            ..
        } = scratch.views::<S, M>();
        let kernel = self.kernel;
        let map = &kernel.pressure_to_gauss;
        interpolate::<S, P, M>(simd, map, view::<S>(p), pressure, [first, second]);
        let (g, v) = (view::<S>(cofactors), view_mut::<S>(v));
        for c in 0..3 {
            let g = column(g, c, m3);
            for i in 0..m3 {
                let minus = simd.neg_f64s(pressure[i]);
                x[i] = simd.mul_f64s(g[0][i], minus);
                y[i] = simd.mul_f64s(g[1][i], minus);
                z[i] = simd.mul_f64s(g[2][i], minus);
            }
            values.fill(simd.splat_f64s(0.0));
            add_integrated::<S, M>(simd, &kernel.derivative_transposed, [x, y, z], values);
            let out = &mut v[c * n3..(c + 1) * n3];
            interpolate::<S, M, N>(simd, &kernel.from_gauss, values, out, [first, second]);
        }
    }
}

impl<const N: usize, const M: usize, const P: usize> Kernel for Sized<N, M, P> {
    fn scratch(&self) -> Scratch {
        let zeros = || vec![0.0; M * M * M * LANES];
        Scratch {
            contracted: [zeros(), zeros()],
            values: zeros(),
            gradient: [zeros(), zeros(), zeros()],
            pressure: zeros(),
            divergence: zeros(),
        }
    }

    fn to_gauss(&self, nodal: &[f64], at_gauss: &mut [f64], scratch: &mut Scratch) {
        let job = ToGauss {
            nodal,
            at_gauss,
            scratch,
        };
        self.processor.dispatch(Work { kernel: self, job });
    }

    fn gradient(&self, nodal: &[f64], out: [&mut [f64]; 3], scratch: &mut Scratch) {
        let job = Gradient {
            nodal,
            out,
            scratch,
        };
        self.processor.dispatch(Work { kernel: self, job });
    }

    fn nodal_gradient(&self, nodal: &[f64], out: [&mut [f64]; 3]) {
        let job = NodalGradient { nodal, out };
        self.processor.dispatch(Work { kernel: self, job });
    }

    fn oseen(
        &self,
        at: AtGauss,
        (u, p): (&[f64], &[f64]),
        (momentum, continuity): (&mut [f64], &mut [f64]),
        scratch: &mut Scratch,
    ) {
        let job = Oseen {
            at,
            u,
            p,
            momentum,
            continuity,
            scratch,
        };
        self.processor.dispatch(Work { kernel: self, job });
    }

    fn minus_divergence(&self, cofactors: &[f64], u: &[f64], q: &mut [f64], scratch: &mut Scratch) {
        let job = MinusDivergence {
            cofactors,
            u,
            q,
            scratch,
        };
        self.processor.dispatch(Work { kernel: self, job });
    }

    fn minus_gradient(&self, cofactors: &[f64], p: &[f64], v: &mut [f64], scratch: &mut Scratch) {
        let job = MinusGradient {
            cofactors,
            p,
            v,
            scratch,
        };
        self.processor.dispatch(Work { kernel: self, job });
    }
}
