//! The quasi-Newton iteration: its columns come from the trials, its answers from a model of the inverse Jacobian.

use super::{Acceleration, AccelerationMemory, Column, Columns, Identity, Surrogate};
use nalgebra::DVector;

/// What a model says about a residual.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// The change of the displacement that would remove what the model knows of the residual.
    pub correction: DVector<f64>,
    /// What it knows nothing about.
    pub rest: DVector<f64>,
}

/// An approximation of the inverse Jacobian that learns from columns: four verbs.
pub trait JacobianModel: Send {
    /// A new column of the current step.
    fn add(&mut self, column: Column);

    /// The answer of all columns to a residual.
    fn predict(&mut self, residual: &DVector<f64>) -> Prediction;

    /// The columns of the current step become those of an earlier one.
    fn finish_step(&mut self);

    /// Forgets all columns.
    fn reset(&mut self);

    /// Columns in use and dropped.
    fn columns(&self) -> Columns;

    /// The columns of each of its fits, newest first, between two steps.
    fn fits(&self) -> Vec<Vec<Column>>;

    /// Takes the columns of another one's fits in place of its own.
    fn recall(&mut self, fits: Vec<Vec<Column>>);
}

/// `d + correction + P rest`: the model answers for what its columns span, the surrogate `P` for the rest.
///
/// With remembered columns or with a surrogate the first iteration of a step is a quasi-Newton step as well. Without
/// any column it is `d + relaxation P r`.
pub struct QuasiNewton<M> {
    model: M,
    relaxation: f64,
    surrogate: Box<dyn Surrogate>,
    /// `d` and the residual of the last call.
    last: Option<(DVector<f64>, DVector<f64>)>,
}

impl<M: JacobianModel> QuasiNewton<M> {
    /// The iteration without a surrogate: `P` is the identity, so that it continues as a fixed-point iteration in what
    /// the columns do not span.
    pub fn new(model: M, relaxation: f64) -> Self {
        Self {
            model,
            relaxation,
            surrogate: Box::new(Identity),
            last: None,
        }
    }

    /// The same with the surrogate `P` in place of the identity.
    pub fn with_surrogate(self, surrogate: Box<dyn Surrogate>) -> Self {
        Self { surrogate, ..self }
    }
}

impl<M: JacobianModel> Acceleration for QuasiNewton<M> {
    fn next(&mut self, d: &DVector<f64>, d_tilde: &DVector<f64>) -> DVector<f64> {
        let residual = d_tilde - d;
        if let Some((d_before, residual_before)) = &self.last {
            let column = Column::new(d - d_before, &residual - residual_before, d_tilde.norm());
            column.into_iter().for_each(|column| self.model.add(column));
        }
        let Prediction { correction, rest } = self.model.predict(&residual);
        let factor = if self.model.columns().used == 0 {
            self.relaxation
        } else {
            1.0
        };
        let next = d + correction + factor * self.surrogate.predict(&rest);
        self.last = Some((d.clone(), residual));
        next
    }

    fn finish_step(&mut self) {
        self.model.finish_step();
        if let Some((d, _)) = self.last.take() {
            self.surrogate.finish_step(&d);
        }
    }

    fn reset(&mut self) {
        self.model.reset();
        self.last = None;
    }

    fn set_relaxation(&mut self, factor: f64) {
        self.relaxation = factor;
    }

    fn memory(&self) -> AccelerationMemory {
        AccelerationMemory {
            factor: None,
            fits: self.model.fits(),
        }
    }

    fn recall(&mut self, memory: AccelerationMemory, d: &DVector<f64>) {
        self.last = None;
        self.model.recall(memory.fits);
        self.surrogate.finish_step(d);
    }

    fn columns(&self) -> Columns {
        self.model.columns()
    }
}
