//! The equations of a time step, linear in velocity and pressure, with their preconditioner.

use super::FlowError;
use super::clock::{Clock, SolverPart};
use super::flux::Flux;
use super::gmres::{self, Outcome, System, Workspace};
use super::kernel::{AtGauss, Viscosity};
use super::local::{Local, sizes};
use super::metric::Metric;
use super::patience::Patience;
use super::pressure::{SchurComplement, SchurProduct};
use super::rheology::ViscosityField;
use super::spectral_elements::{CHUNK, SpectralElements, at_each_node};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::time::Instant;

/// `A u + Bᵀ p = f`, `B u = g` at one moment. Vectors hold the velocity, one component after the other, then the
/// pressure.
pub struct Oseen<'a> {
    /// The elements.
    pub space: &'a SpectralElements,
    /// The geometry at the end of the step.
    pub metric: &'a Metric,
    /// What changes from step to step.
    pub terms: Terms,
    /// Nodes with prescribed velocity: their rows are left out.
    pub fixed: &'a [bool],
    /// Flow out of each open end.
    pub fluxes: &'a [Flux],
    /// Inverse of the diagonal `D` of the preconditioner, zero at fixed nodes.
    pub inverse_diagonal: Vec<f64>,
    /// Schur complement of the preconditioner, made for a diagonal that was `scale` times as large.
    pub schur: &'a SchurComplement,
    /// See `schur`.
    pub scale: f64,
    /// Weights of the norm.
    pub weights: Vec<f64>,
    /// What pressures at the open ends add to the preconditioner; `solve` makes it where there is none.
    pub ends: Option<EndResponses>,
    /// Results of the elements.
    pub local: &'a mut Local,
    /// Seconds by part.
    pub clock: &'a mut Clock,
    /// How long a solution is waited for.
    pub patience: &'a Patience,
}

/// What the preconditioner makes of the pressures that answer to the flow through open ends, `A += Σ R_e q_e q_eᵀ`:
/// what is left of its answer `z` without them is `z - Y (R⁻¹ + Qᵀ Y)⁻¹ Qᵀ z`, `Y` its answers to the `q_e` (Woodbury
/// 1950).
pub struct EndResponses {
    /// Number of the end, and its column of `Y`.
    answers: Vec<(usize, Vec<f64>)>,
    /// `(R⁻¹ + Qᵀ Y)⁻¹`, Pa s/m³.
    inverse: DMatrix<f64>,
}

/// Terms of the equations, linearized about a velocity **a** relative to the mesh.
pub struct Terms {
    /// `rho G a` at the Gauss points.
    pub convection: Vec<f64>,
    /// Dynamic viscosity, Pa s.
    pub viscosity: ViscosityField,
    /// What stands on the diagonal of `A` in addition to convection and viscosity, for each node.
    pub mass: Vec<f64>,
    /// Pressure at each open end for each unit of flow out of it, Pa s/m³.
    pub resistances: Vec<f64>,
    /// Right-hand sides.
    pub rhs: Vec<f64>,
}

/// Corrections of the mass balance after a solution. One would do if the mesh had not moved since the factor of the
/// corners' equations was made.
const BALANCINGS: usize = 2;

impl Oseen<'_> {
    /// Improves `x` until the estimated error is below `tolerance`, relative to the size of the solution, with the
    /// nodes at `positions` (m): iterations, and the relative error.
    pub fn solve(
        &mut self,
        x: &mut [f64],
        positions: &[f64],
        (tolerance, most): (f64, usize),
        workspace: &mut Workspace,
    ) -> Result<Outcome, FlowError> {
        let (begin, then) = (Instant::now(), *self.clock);
        let nodes = self.fixed.len();
        let place = |i: usize| [0, 1, 2].map(|c| positions[c * nodes + i % nodes]);
        if self.ends.is_none() {
            self.ends = self.end_responses();
        }
        let mut first = vec![0.0; x.len()];
        self.preconditioned_residual(x, &mut first);
        // The preconditioned residual estimates the error: the solution is about as large as the sum
        let size = gmres::norm(&self.weights, x) + gmres::norm(&self.weights, &first);
        if !size.is_finite() {
            // The first residual spreads what is lost over the whole fluid.
            let lost = [&*x, &first].map(|v| v[..3 * nodes].iter().position(|v| !v.is_finite()));
            return Err(FlowError::NotFinite {
                position: place(lost[0].or(lost[1]).unwrap_or(0)),
            });
        }
        let Outcome {
            iterations,
            residual,
        } = gmres::solve(self, x, &first, tolerance * size, most, workspace);
        self.clock
            .add_rest(SolverPart::Orthogonalization, begin, &then);
        if self.patience.is_over() {
            return Err(FlowError::Interrupted);
        }
        if residual.is_nan() || residual > tolerance * size {
            self.preconditioned_residual(x, &mut first);
            let share = |i: &usize| self.weights[*i] * first[*i] * first[*i];
            let worst = (0..3 * nodes).max_by(|a, b| share(a).total_cmp(&share(b)));
            return Err(FlowError::NotSolved {
                iterations,
                residual: residual / size,
                position: place(worst.unwrap_or(0)),
            });
        }
        self.balance_mass(x);
        Ok(Outcome {
            iterations,
            residual: if size > 0.0 { residual / size } else { 0.0 },
        })
    }

    /// The left-hand sides; rows of fixed nodes are zero.
    pub fn product(&mut self, x: &[f64], out: &mut [f64]) {
        let begin = Instant::now();
        self.full_product(x, out);
        at_each_node(&mut out[..3 * self.fixed.len()], |i, out| {
            if self.fixed[i] {
                out.into_iter().for_each(|out| *out = 0.0);
            }
        });
        self.clock.add(SolverPart::Products, begin);
    }

    /// Forces (N) that hold the velocity of the fixed nodes, one component after the other: what the equations of
    /// momentum lack there.
    pub fn reactions(&mut self, x: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; x.len()];
        self.full_product(x, &mut forces);
        let nodes = self.fixed.len();
        forces.truncate(3 * nodes);
        for (k, force) in forces.iter_mut().enumerate() {
            *force = match self.fixed[k % nodes] {
                true => *force - self.terms.rhs[k],
                false => 0.0,
            };
        }
        forces
    }

    /// The left-hand sides, those of fixed nodes too.
    fn full_product(&mut self, x: &[f64], out: &mut [f64]) {
        let space = self.space;
        let [n3, m3, p3] = sizes(space);
        let velocities = 3 * space.space.nodes;
        let (u, p) = x.split_at(velocities);
        let metric = self.metric;
        let Terms {
            convection,
            viscosity,
            ..
        } = &self.terms;
        let Local {
            momentum,
            continuity,
            ..
        } = &mut *self.local;
        momentum
            .par_chunks_mut(3 * n3)
            .zip(continuity.par_chunks_mut(p3))
            .enumerate()
            .for_each_init(
                || (space.kernel.scratch(), vec![0.0; 3 * n3], vec![0.0; p3]),
                |(scratch, u_local, p_local), (e, (momentum, continuity))| {
                    space.gather_group(e, u, u_local);
                    space.gather_pressures(e, p, p_local);
                    let at = AtGauss {
                        cofactors: &metric.cofactors[9 * m3 * e..9 * m3 * (e + 1)],
                        stiffness: &metric.stiffness[6 * m3 * e..6 * m3 * (e + 1)],
                        convection: &convection[3 * m3 * e..3 * m3 * (e + 1)],
                        viscosity: match viscosity {
                            ViscosityField::Constant(viscosity) => Viscosity::Constant(*viscosity),
                            ViscosityField::AtGauss(field) => {
                                Viscosity::AtGauss(&field[m3 * e..m3 * (e + 1)])
                            }
                        },
                    };
                    let output = (momentum, continuity);
                    space.kernel.oseen(at, (u_local, p_local), output, scratch);
                },
            );
        let (out_u, out_p) = out.split_at_mut(velocities);
        let nodes = self.fixed.len();
        space.sum_vectors(momentum, out_u, |i, sums, out| {
            let mass = self.terms.mass[i];
            for (c, (out, sum)) in out.into_iter().zip(sums).enumerate() {
                *out = sum + mass * u[c * nodes + i];
            }
        });
        space.sum_pressures(continuity, out_p, |_, sum, out| *out = sum);
        for (flux, resistance) in self.fluxes.iter().zip(&self.terms.resistances) {
            if *resistance != 0.0 {
                flux.add_force(nodes, resistance * flux.of(nodes, u), out_u);
            }
        }
    }

    /// What lets the preconditioner know of the pressures that answer to flows. Where the resistance is large, a
    /// pressure that is off by the same everywhere hardly shows in the residual of the flow that it drives: without
    /// this, GMRES ended with pressures that were off by a thousand times its tolerance.
    fn end_responses(&mut self) -> Option<EndResponses> {
        let resistances = self.terms.resistances.iter().enumerate();
        let ends: Vec<(usize, f64)> = resistances
            .filter(|(_, resistance)| **resistance > 0.0)
            .map(|(end, resistance)| (end, *resistance))
            .collect();
        let unknowns = self.weights.len();
        let answers: Vec<(usize, Vec<f64>)> = (ends.iter())
            .map(|&(end, _)| {
                let mut answer = vec![0.0; unknowns];
                self.fluxes[end].add_force(self.fixed.len(), 1.0, &mut answer);
                self.precondition_without_ends(&mut answer);
                self.balance(&mut answer, None);
                (end, answer)
            })
            .collect();
        let matrix = DMatrix::from_fn(ends.len(), ends.len(), |i, j| {
            let own = if i == j { 1.0 / ends[i].1 } else { 0.0 };
            own + self.through(ends[i].0, &answers[j].1)
        });
        let inverse = matrix.try_inverse()?;
        Some(EndResponses { answers, inverse })
    }

    /// Flow of a velocity through an open end, m³/s.
    fn through(&self, end: usize, u: &[f64]) -> f64 {
        self.fluxes[end].of(self.fixed.len(), u)
    }

    /// Flows of a velocity through the ends whose pressures answer to them, m³/s.
    fn flows(&self, u: &[f64]) -> DVector<f64> {
        let ends = self.ends.iter().flat_map(|ends| &ends.answers);
        let flows: Vec<f64> = ends.map(|(end, _)| self.through(*end, u)).collect();
        DVector::from_vec(flows)
    }

    /// Adds to `x` what the pressures at the ends make of these flows (m³/s).
    fn answer_to(&self, flows: &DVector<f64>, x: &mut [f64]) {
        let Some(ends) = &self.ends else {
            return;
        };
        let pressures = &ends.inverse * flows;
        let chunks = x.par_chunks_mut(CHUNK).enumerate();
        chunks.for_each(|(chunk, x)| {
            for ((_, answer), pressure) in ends.answers.iter().zip(&pressures) {
                let answer = &answer[chunk * CHUNK..][..x.len()];
                x.iter_mut()
                    .zip(answer)
                    .for_each(|(x, y)| *x -= pressure * y);
            }
        });
    }

    /// Solves with the preconditioner, in place.
    fn precondition(&mut self, r: &mut [f64]) {
        self.precondition_without_ends(r);
        let flows = self.flows(r);
        self.answer_to(&flows, r);
    }

    /// Solves with the factors of the preconditioner, in place: `u* = D⁻¹ r_u`, `p = S⁻¹ (B u* - r_p)`,
    /// `u = u* - D⁻¹ Bᵀ p`.
    fn precondition_without_ends(&mut self, r: &mut [f64]) {
        let (begin, then) = (Instant::now(), *self.clock);
        let (u, p) = r.split_at_mut(3 * self.fixed.len());
        at_each_node(u, |i, u| {
            let d = self.inverse_diagonal[i];
            u.into_iter().for_each(|u| *u *= d);
        });
        self.excess(u, p);
        self.project(u, p, SchurComplement::solve);
        self.clock
            .add_rest(SolverPart::Preconditioner, begin, &then);
    }

    /// Puts the excess `B u - r_p` of the equation of continuity in place of its right-hand side `r_p`.
    fn excess(&mut self, u: &[f64], p: &mut [f64]) {
        let at = (self.space, &self.metric.cofactors[..]);
        (self.local).minus_divergence(at, u, p, |_, product, p| *p = product - *p);
    }

    /// Puts the pressure `S⁻¹ p` in place of an excess `p`, and takes its gradient off the velocity: `u - D⁻¹ Bᵀ p`.
    fn project(
        &mut self,
        u: &mut [f64],
        p: &mut [f64],
        solve: fn(&SchurComplement, &mut [f64], f64, SchurProduct),
    ) {
        let (space, g) = (self.space, &self.metric.cofactors);
        let inverse = Instant::now();
        let now = SchurProduct {
            space,
            cofactors: g,
            inverse_diagonal: &self.inverse_diagonal,
            local: self.local,
        };
        solve(self.schur, p, self.scale, now);
        self.clock.add(SolverPart::Pressure, inverse);
        (self.local).minus_gradient((space, g), p, u, |i, gradient, u| {
            let d = self.inverse_diagonal[i];
            u.into_iter().zip(gradient).for_each(|(u, g)| *u -= d * g);
        });
    }

    /// Corrects the solution so that the equation of continuity holds for the functions of the elements' corners, and
    /// with them for the whole. GMRES stops on the preconditioned residual, in which an approximate `S⁻¹` hides a part
    /// of the error of that equation.
    fn balance_mass(&mut self, x: &mut [f64]) {
        let before = self.flows(x);
        let swept = self.terms.rhs[3 * self.fixed.len()..].to_vec();
        self.balance(x, Some(&swept));
        let more = self.flows(x) - before;
        self.answer_to(&more, x);
    }

    /// The same for a right-hand side of that equation (zero if there is none), as if the pressures at the ends did not
    /// answer.
    fn balance(&mut self, x: &mut [f64], rhs: Option<&[f64]>) {
        let (begin, then) = (Instant::now(), *self.clock);
        let (u, p) = x.split_at_mut(3 * self.fixed.len());
        for _ in 0..BALANCINGS {
            let mut excess = rhs.map_or_else(|| vec![0.0; p.len()], <[f64]>::to_vec);
            self.excess(u, &mut excess);
            self.project(u, &mut excess, SchurComplement::solve_coarse);
            p.iter_mut().zip(&excess).for_each(|(p, more)| *p += more);
        }
        self.clock
            .add_rest(SolverPart::Preconditioner, begin, &then);
    }
}

impl System for Oseen<'_> {
    fn preconditioned_residual(&mut self, x: &[f64], out: &mut [f64]) {
        self.product(x, out);
        for (i, (out, b)) in out.iter_mut().zip(&self.terms.rhs).enumerate() {
            let nodes = self.fixed.len();
            *out = if i < 3 * nodes && self.fixed[i % nodes] {
                0.0
            } else {
                b - *out
            };
        }
        self.precondition(out);
    }

    fn preconditioned_product(&mut self, v: &[f64], out: &mut [f64]) {
        self.product(v, out);
        self.precondition(out);
    }

    fn weights(&self) -> &[f64] {
        &self.weights
    }

    fn is_given_up(&self) -> bool {
        self.patience.is_over()
    }
}
