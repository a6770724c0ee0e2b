//! What to do after a diagnosis: another experiment, or nothing.

use identification::diagnosis::Diagnosis;

use super::Budget;

/// Relative difference of amplitudes below which two experiments are the same.
const SAME_AMPLITUDE: f64 = 0.01;

/// A motion that the knob is turned through.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Experiment {
    pub(super) sweep: String,
    /// Its amplitude, rad; the sweep's own if none.
    pub(super) amplitude_rad: Option<f64>,
}

impl Experiment {
    fn is_like(&self, other: &Self) -> bool {
        let close = match (self.amplitude_rad, other.amplitude_rad) {
            (Some(one), Some(other)) => (one / other - 1.0).abs() < SAME_AMPLITUDE,
            (None, None) => true,
            _ => false,
        };
        self.sweep == other.sweep && close
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Next {
    Experiment(Experiment, [String; 2]),
    /// Nothing is in doubt.
    Settled,
    /// Rivals are left, and the budget is spent.
    BudgetSpent,
    /// Rivals are left that no experiment within reach tells apart, or that the best one, already made, did not.
    Undecidable,
}

/// Decides what comes after `found`, which rests on the experiments `made`.
pub(super) fn next(found: &Diagnosis, made: &[Experiment], duration_s: f64, budget: Budget) -> Next {
    let tied = found.steps.iter().any(|step| !step.ties.is_empty());
    let Some(proposed) = &found.next_experiment else {
        return if tied { Next::Undecidable } else { Next::Settled };
    };
    let experiment = Experiment { sweep: proposed.excitation.clone(), amplitude_rad: Some(proposed.amplitude_rad) };
    let turned_s = made.len() as f64 * duration_s;
    if made.iter().any(|done| done.is_like(&experiment)) {
        Next::Undecidable
    } else if budget.permits(made.len(), turned_s, duration_s) {
        Next::Experiment(experiment, proposed.tells_apart.clone())
    } else {
        Next::BudgetSpent
    }
}
