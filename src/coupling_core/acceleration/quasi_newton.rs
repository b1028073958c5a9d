//! The quasi-Newton iteration: its columns come from the trials, its answers from a model of the inverse Jacobian.

use super::memory::SurrogateRecord;
use super::{
    Acceleration, AccelerationMemory, Columns, Identity, Prediction, SecantPair, Surrogate,
};
use nalgebra::DVector;

/// Steps by whose first changes the surrogate is judged.
const JUDGED: usize = 5;
/// Share of the relaxation factor of an iteration without any column once the surrogate is dropped.
const CAUTION: f64 = 0.1;
/// Changes of the residual count for what they are relative to the displacement since the unloaded shape, or to so many
/// times what the step moves, whichever is less: where little moves, small changes say something too.
const MOTIONS: f64 = 1e4;

/// An approximation of the inverse Jacobian that learns from columns: four verbs.
pub trait JacobianModel: Send {
    /// A new column of the current step.
    fn add(&mut self, column: SecantPair);

    /// The answer of all columns to a residual.
    fn predict(&mut self, residual: &DVector<f64>) -> Prediction;

    /// The columns of the current step become those of an earlier one.
    fn finish_step(&mut self);

    /// Forgets all columns.
    fn reset(&mut self);

    /// Nothing better answers for what the columns do not span: they are doubted no more.
    fn believe(&mut self);

    /// Columns in use and dropped.
    fn columns(&self) -> Columns;

    /// The columns of each of its fits, newest first, between two steps.
    fn fits(&self) -> Vec<Vec<SecantPair>>;

    /// Takes the columns of another one's fits in place of its own.
    fn recall(&mut self, fits: Vec<Vec<SecantPair>>);
}

/// `d + correction + P rest`: the model answers for what its columns span, the surrogate `P` for the rest.
///
/// With remembered columns or with a surrogate the first iteration of a step is a quasi-Newton step as well. Without
/// any column it is `d + relaxation P r`.
///
/// The surrogate is judged by the first change of each step, where it matters most: `|P δr + δd|` is 0 if it is exact;
/// the identity in its place leaves `|δr + δd|`, and no answer at all `|δd|`. One that usually leaves more than either,
/// or did so in a step that failed, is dropped. (More than `|δd|` alone is no fault: where the blood is so heavy that a
/// change comes back a hundred times as large, errors of a few percent leave that much.)
pub struct QuasiNewton<M> {
    model: M,
    relaxation: f64,
    surrogate: Box<dyn Surrogate>,
    record: SurrogateRecord,
    /// What is to be said of the surrogate.
    notice: Option<String>,
    /// The displacement that was accepted last.
    accepted: Option<DVector<f64>>,
    /// `d` and the residual of the last call.
    last: Option<(DVector<f64>, DVector<f64>)>,
    /// Changes in this step.
    changes: usize,
}

impl<M: JacobianModel> QuasiNewton<M> {
    /// The iteration without a surrogate: `P` is the identity, so that it continues as a fixed-point iteration in what
    /// the columns do not span.
    pub fn new(model: M, relaxation: f64) -> Self {
        Self {
            model,
            relaxation,
            surrogate: Box::new(Identity),
            record: SurrogateRecord::default(),
            notice: None,
            accepted: None,
            last: None,
            changes: 0,
        }
    }

    /// The same with the surrogate `P` in place of the identity.
    pub fn with_surrogate(self, surrogate: Box<dyn Surrogate>) -> Self {
        Self { surrogate, ..self }
    }

    /// Judges the surrogate by the first change of a step.
    fn judge(&mut self, change: &DVector<f64>, answer: &DVector<f64>) {
        if self.changes > 0 || self.surrogate.is_none() || change.norm() == 0.0 {
            return;
        }
        let without = (answer + change).norm().max(change.norm());
        let left = (self.surrogate.predict(answer) + change).norm() / without;
        self.record.left.insert(0, left);
        self.record.left.truncate(JUDGED);
    }

    /// Goes on without the surrogate, which was worse than none.
    fn drop_surrogate(&mut self) {
        self.surrogate = Box::new(Identity);
        self.model.believe();
        self.record.dropped = true;
        self.notice = Some(format!(
            "the surrogate left {:.1} times as much of the first change of a step as none would have: the coupling continues without it (as \
             with coupling.surrogate = \"none\")",
            self.record.left.first().copied().unwrap_or(f64::NAN)
        ));
    }

    fn usually_left(&self) -> f64 {
        let mut left = self.record.left.clone();
        left.sort_by(f64::total_cmp);
        left.get(JUDGED / 2)
            .copied()
            .filter(|_| left.len() == JUDGED)
            .unwrap_or(0.0)
    }
}

impl<M: JacobianModel> Acceleration for QuasiNewton<M> {
    fn next(&mut self, d: &DVector<f64>, d_tilde: &DVector<f64>) -> DVector<f64> {
        let residual = d_tilde - d;
        let accepted = self.accepted.get_or_insert_with(|| d.clone());
        let motion = (d_tilde - &*accepted).norm();
        if let Some((d_before, residual_before)) = self.last.take() {
            let (change, answer) = (d - d_before, &residual - residual_before);
            self.judge(&change, &answer);
            self.changes += 1;
            let scale = match d_tilde.norm().min(MOTIONS * motion) {
                0.0 => 1.0,
                scale => scale,
            };
            let column = SecantPair::new(change, answer, scale);
            column.into_iter().for_each(|column| self.model.add(column));
        }
        let Prediction { correction, rest } = self.model.predict(&residual);
        let factor = if self.model.columns().used == 0 {
            self.relaxation * if self.record.dropped { CAUTION } else { 1.0 }
        } else {
            1.0
        };
        let next = d + correction + factor * self.surrogate.predict(&rest);
        self.last = Some((d.clone(), residual));
        next
    }

    fn begin_step(&mut self, end: f64, length: f64) {
        self.surrogate.begin_step(end, length);
    }

    fn finish_step(&mut self) {
        self.model.finish_step();
        self.changes = 0;
        if let Some((d, _)) = self.last.take() {
            self.surrogate.finish_step(&d);
            self.accepted = Some(d);
        }
        if self.usually_left() > 1.0 && !self.record.dropped {
            self.drop_surrogate();
        }
    }

    fn reset(&mut self) {
        self.model.reset();
        self.last = None;
        let has_failed = std::mem::take(&mut self.changes) > 0;
        let left = self.record.left.first();
        if has_failed && left.is_some_and(|left| *left > 1.0) && !self.record.dropped {
            self.drop_surrogate();
        }
    }

    fn acquit(&mut self) {
        if std::mem::take(&mut self.changes) > 0 && !self.record.left.is_empty() {
            self.record.left.remove(0);
        }
    }

    fn set_relaxation(&mut self, factor: f64) {
        self.relaxation = factor;
    }

    fn memory(&self) -> AccelerationMemory {
        AccelerationMemory {
            factor: None,
            fits: self.model.fits(),
            surrogate: self.record.clone(),
        }
    }

    fn recall(&mut self, memory: AccelerationMemory, d: &DVector<f64>) {
        self.last = None;
        self.changes = 0;
        self.accepted = Some(d.clone());
        self.model.recall(memory.fits);
        self.surrogate.finish_step(d);
        self.record = memory.surrogate;
        if self.record.dropped {
            self.surrogate = Box::new(Identity);
            self.model.believe();
        }
    }

    fn columns(&self) -> Columns {
        self.model.columns()
    }

    fn notice(&mut self) -> Option<String> {
        self.notice.take()
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::reference::{Linear, Reference};
    use super::super::tests::{error, iterate};
    use super::super::{Filter, IqnLs};
    use super::*;

    /// Takes the blood for far lighter than it is, and the wall for softer.
    struct Wrong;

    impl Surrogate for Wrong {
        fn predict(&self, residual: &DVector<f64>) -> DVector<f64> {
            3.0 * residual
        }
    }

    fn model(surrogate: Box<dyn Surrogate>) -> QuasiNewton<IqnLs> {
        let model = IqnLs::new(5, Filter::new(1e-6, 0.0, !surrogate.is_none()), 100);
        QuasiNewton::new(model, 0.1).with_surrogate(surrogate)
    }

    /// Iterations of eight steps, the text of the report, and after how many steps.
    fn run(surrogate: Box<dyn Surrogate>) -> (Vec<usize>, Option<(usize, String)>) {
        let (mut problem, mut model) = (Linear::new(30, 20.0), model(surrogate));
        let (mut counted, mut told) = (Vec::new(), None);
        for step in 1..=8 {
            let (iterations, d) = iterate(&mut problem, &mut model, 200).unwrap();
            assert!(error(&problem, step - 1, &d) < 1e-7);
            counted.push(iterations);
            told = told.or(model.notice().map(|text| (step, text)));
        }
        (counted, told)
    }

    /// A surrogate that slows the iteration down is dropped, and the run reports it.
    #[test]
    fn a_surrogate_worse_than_none_is_dropped() {
        let (counted, told) = run(Box::new(Wrong));
        let (step, text) = told.expect("it is reported");
        assert_eq!(step, JUDGED);
        assert!(text.contains("coupling.surrogate = \"none\""), "{text}");
        let (without, none) = run(Box::new(Identity));
        assert!(none.is_none());
        assert!(
            counted[7] <= without[7] + 1,
            "{counted:?}, without {without:?}"
        );
    }

    #[test]
    fn one_that_is_only_rough_is_kept() {
        let (counted, told) = run(Linear::new(30, 20.0).surrogate());
        let (without, _) = run(Box::new(Identity));
        assert!(
            told.is_none() && counted[0] < without[0],
            "{counted:?}, {without:?}"
        );
    }

    #[test]
    fn a_failure_of_the_fluid_is_not_held_against_the_surrogate() {
        let (mut problem, mut model) = (Linear::new(30, 20.0), model(Box::new(Wrong)));
        assert!(iterate(&mut problem, &mut model, 3).is_none());
        model.acquit();
        model.reset();
        assert_eq!(model.notice(), None);
        assert!(!model.memory().surrogate.dropped);
    }

    #[test]
    fn a_step_that_fails_with_a_wrong_surrogate_is_tried_without() {
        let (mut problem, mut model) = (Linear::new(30, 20.0), model(Box::new(Wrong)));
        assert!(iterate(&mut problem, &mut model, 3).is_none());
        model.reset();
        assert!(
            model
                .notice()
                .is_some_and(|text| text.contains("of the first change of a step"))
        );
        let mut resumed = self::model(Box::new(Wrong));
        resumed.recall(model.memory(), &problem.at_rest());
        let again = iterate(&mut problem.clone(), &mut model, 200);
        assert!(again.is_some());
        assert_eq!(again, iterate(&mut problem, &mut resumed, 200));
    }
}
