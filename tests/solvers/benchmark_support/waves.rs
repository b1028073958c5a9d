//! Waves of one frequency in a tube: what probes say of them, and their exact wave numbers.

use nalgebra::Complex;
use std::f64::consts::TAU;
use std::path::Path;

type C = Complex<f64>;

/// Complex amplitude of the pressure at each probe of `fluid-probes.csv` over the last period.
pub fn harmonics(path: &Path, dt: f64, period: f64) -> Vec<C> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let headers = reader.headers().unwrap().clone();
    let column = |name: &str| headers.iter().position(|header| header == name).unwrap();
    let columns = ["time_s", "probe", "p_Pa"].map(column);
    let rows: Vec<[f64; 3]> = (reader.records().map(Result::unwrap))
        .map(|row| columns.map(|column| row[column].parse().unwrap()))
        .collect();
    let end = rows[rows.len() - 1][0];
    let last = rows.iter().filter(|row| row[0] > end - period + 0.5 * dt);
    let mut sums: Vec<C> = Vec::new();
    for [t, probe, p] in last {
        let probe = *probe as usize;
        sums.resize(sums.len().max(probe + 1), C::new(0.0, 0.0));
        sums[probe] += C::new(0.0, -TAU / period * t).exp() * p * (2.0 * dt / period);
    }
    sums
}

/// The γ with `p(x) = A exp(-γ x) + B exp(γ x)`, from `p(x - h) + p(x + h) = 2 cosh(γ h) p(x)` by least squares.
pub fn wave_number(pressures: &[C], spacing: f64) -> C {
    let triples = || pressures.windows(3);
    let sums: C = triples().map(|p| p[1].conj() * (p[0] + p[2])).sum();
    let squares: f64 = triples().map(|p| p[1].norm_sqr()).sum();
    let wave_number = (0.5 * sums / squares).acosh() / spacing;
    if wave_number.re < 0.0 {
        -wave_number
    } else {
        wave_number
    }
}

/// The same pressures without the waves of a known γ, at all probes but the first and the last.
pub fn without(pressures: &[C], known: C, spacing: f64) -> Vec<C> {
    let share = 2.0 * (known * spacing).cosh();
    let triples = pressures.windows(3);
    triples.map(|p| p[0] + p[2] - share * p[1]).collect()
}

/// Bessel functions J0 and J1 by their series.
pub fn bessel(z: C) -> [C; 2] {
    let q = -0.25 * z * z;
    let (mut term, mut sums) = (C::new(1.0, 0.0), [C::new(0.0, 0.0); 2]);
    for k in 0..60 {
        sums[0] += term;
        sums[1] += term * 0.5 * z / (k as f64 + 1.0);
        term *= q / ((k as f64 + 1.0) * (k as f64 + 1.0));
    }
    sums
}

/// A tube of a linear elastic material whose outside is free, and the fluid in it.
#[derive(Clone, Copy)]
pub struct Tube {
    /// Inner radius, m.
    pub radius: f64,
    /// Thickness of the wall, m.
    pub thickness: f64,
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Density of both, kg/m3.
    pub density: f64,
    /// Dynamic viscosity, Pa s.
    pub viscosity: f64,
}

/// Rates of fields like `exp(s t)`: what d/dt of the fluid and d²/dt² of the wall are.
#[derive(Clone, Copy)]
pub struct Rates {
    /// d/dt.
    pub first: C,
    /// d²/dt².
    pub second: C,
}

impl Rates {
    /// Of continuous time.
    pub fn exact(period: f64) -> Self {
        let first = C::new(0.0, TAU / period);
        Self {
            first,
            second: first * first,
        }
    }

    /// Of BDF2 in the fluid and Bossak's method in the wall, with α = -1/3 as the driver has it.
    pub fn of_steps(period: f64, dt: f64) -> Self {
        const ALPHA: f64 = -1.0 / 3.0;
        let (beta, gamma) = (0.25 * (1.0 - ALPHA).powi(2), 0.5 - ALPHA);
        let z = C::new(0.0, TAU / period * dt).exp();
        let newmark = z * z * beta + z * (0.5 + gamma - 2.0 * beta) + (0.5 - gamma + beta);
        let acceleration = (z - 1.0) * (z - 1.0) / (newmark * dt * dt);
        Self {
            first: (1.5 - 2.0 / z + 0.5 / (z * z)) / dt,
            second: acceleration * (1.0 - ALPHA + ALPHA / z),
        }
    }
}

impl Tube {
    /// γ of the waves that are like `exp(s t - γ z)`, found from a first guess: a root of [`Self::mismatch`] by the
    /// secant method.
    pub fn wave_number(&self, rates: Rates, guess: C) -> C {
        let f = |gamma| self.mismatch(gamma, rates);
        let (mut a, mut b) = (guess, guess * 1.001);
        let (mut at_a, mut at_b) = (f(a), f(b));
        for _ in 0..50 {
            if (b - a).norm() < 1e-13 * b.norm() || at_a == at_b {
                return b;
            }
            let next = b - at_b * (b - a) / (at_b - at_a);
            (a, at_a) = (b, at_b);
            (b, at_b) = (next, f(next));
        }
        panic!("no wave near {guess}");
    }

    /// Zero where the outer surface is free of traction: the determinant of its two components for the fluid's two
    /// regular solutions. The linear Navier-Stokes equations have pressures `J0(γ r)` and rotational velocities
    /// `J0(κ r)` along the axis, `κ² = γ² - ρ s/μ`; the equations of the wall are integrated from the inside out.
    fn mismatch(&self, gamma: C, rates: Rates) -> C {
        let (r, mu, s) = (self.radius, self.viscosity, rates.first);
        let mass = s * self.density;
        let kappa = (gamma * gamma - mass / mu).sqrt();
        let potential = bessel(gamma * r);
        let rotational = bessel(kappa * r);
        // Velocities, then their derivatives along r, and the pressure.
        let [u, w] = [gamma * potential[1] / mass, gamma * potential[0] / mass];
        let du = gamma * gamma * (potential[0] - potential[1] / (gamma * r)) / mass;
        let dw = -gamma * gamma * potential[1] / mass;
        let first = [u, w, du, dw, potential[0]];
        let [u, w] = [gamma * rotational[1] / kappa, rotational[0]];
        let du = gamma * (rotational[0] - rotational[1] / (kappa * r));
        let second = [u, w, du, -kappa * rotational[1], C::new(0.0, 0.0)];
        let [a, b] = [first, second].map(|[u, w, du, dw, p]| {
            let tractions = [2.0 * mu * du - p, mu * (dw - gamma * u)];
            let state = [u / s, w / s, tractions[0], tractions[1]];
            let scale = tractions[0].norm().max(tractions[1].norm());
            self.outer_traction(state.map(|x| x / scale), gamma, rates.second)
        });
        a[0] * b[1] - a[1] * b[0]
    }

    /// Radial and axial traction of the outer surface, from radial and axial displacement and traction at the inner
    /// one: linear elasticity, integrated by the classical method of Runge and Kutta.
    fn outer_traction(&self, inner: [C; 4], gamma: C, second: C) -> [C; 2] {
        const STEPS: usize = 100;
        let (e, nu) = (self.youngs_modulus, self.poisson_ratio);
        let (lambda, g) = (
            e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
            0.5 * e / (1.0 + nu),
        );
        let stiff = lambda + 2.0 * g;
        let inertia = second * self.density;
        let rhs = |r: f64, [u, w, normal, shear]: [C; 4]| {
            let du = (normal - (u / r - gamma * w) * lambda) / stiff;
            let dw = shear / g + gamma * u;
            let hoop = (du - gamma * w) * lambda + u * stiff / r;
            let axial = (du + u / r) * lambda - gamma * w * stiff;
            let dnormal = inertia * u - (normal - hoop) / r + gamma * shear;
            [du, dw, dnormal, inertia * w - shear / r + gamma * axial]
        };
        let h = self.thickness / STEPS as f64;
        let plus = |y: [C; 4], k: [C; 4], by: f64| [0, 1, 2, 3].map(|i| y[i] + k[i] * by);
        let mut y = inner;
        for step in 0..STEPS {
            let r = self.radius + h * step as f64;
            let a = rhs(r, y);
            let b = rhs(r + 0.5 * h, plus(y, a, 0.5 * h));
            let c = rhs(r + 0.5 * h, plus(y, b, 0.5 * h));
            let d = rhs(r + h, plus(y, c, h));
            y = [0, 1, 2, 3].map(|i| y[i] + (a[i] + (b[i] + c[i]) * 2.0 + d[i]) * (h / 6.0));
        }
        [y[2], y[3]]
    }

    /// γ of the two waves of a long thin tube (Womersley 1957; Morgan and Kiely 1954), pressure's and the wall's.
    pub fn of_a_thin_wall(&self, s: C) -> [C; 2] {
        let nu = self.poisson_ratio;
        let lambda = (-s * self.density / self.viscosity).sqrt() * self.radius;
        let [j0, j1] = bessel(lambda);
        let g = 2.0 * j1 / (lambda * j0);
        let mass = self.thickness / self.radius;
        let a = (g - 1.0) * (nu * nu - 1.0);
        let b = (g - 1.0) * mass + g * (2.0 * nu - 0.5) - 2.0;
        let root = (b * b - a * (g + 2.0 * mass) * 4.0).sqrt();
        let stiffness = self.youngs_modulus * mass / (self.density * (1.0 - nu * nu));
        [1.0, -1.0].map(|sign| {
            let gamma = s / (stiffness / ((-b + root * sign) / (2.0 * a))).sqrt();
            if gamma.re < 0.0 { -gamma } else { gamma }
        })
    }
}
