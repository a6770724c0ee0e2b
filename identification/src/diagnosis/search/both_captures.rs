//! A structure's values from both captures: the training capture alone may leave open what the two together show.

use std::collections::BTreeMap;

use crate::diagnosis::capture::Capture;
use crate::diagnosis::findings::Value;
use crate::diagnosis::model_fit::nonlinear::Nonlinear;
use crate::diagnosis::model_fit::{intervals, residuals};
use crate::diagnosis::search::judged::Judged;
use crate::regression::least_squares::{LeastSquares, residual};

/// Most steps from the values of the training capture to those of both.
const ROUNDS: usize = 3;

impl Judged {
    /// The same effects with values fitted to both captures, by Gauss–Newton steps from the values of the training capture. A structure with
    /// coupled bodies is taken as it is.
    pub(crate) fn fitted_to_both(&self, train: &Capture, heldout: &Capture) -> Self {
        let mut best = self.clone();
        if self.structure.is_coupled() {
            return best;
        }
        for _ in 0..ROUNDS {
            match best.step_to_both(train, heldout) {
                Some(next) if next.evidence > best.evidence => best = next,
                _ => break,
            }
        }
        best
    }

    /// Values with intervals of each effect, from both captures; values that have a straight end are held fixed.
    pub(crate) fn intervals_from_both(&self, train: &Capture, heldout: &Capture) -> Vec<BTreeMap<&'static str, Value>> {
        let fit = Nonlinear::new(self.structure.clone(), train);
        let (columns, target) = self.linear_problem(&fit, heldout);
        intervals::given_straight_ends_of(&fit, columns, &target)
    }

    /// One Gauss–Newton step towards the values that explain both captures best; `None` where no value can be fitted.
    fn step_to_both(&self, train: &Capture, heldout: &Capture) -> Option<Self> {
        let fit = Nonlinear::new(self.structure.clone(), train);
        let (columns, target) = self.linear_problem(&fit, heldout);
        let collinear = LeastSquares::solve(&columns, &target).collinear;
        // Steps are counted from each value's lower bound: a coefficient that cannot be negative then keeps the value above it.
        let lowest: Vec<Option<f64>> = fit
            .lowest_steps()
            .into_iter()
            .zip(&collinear)
            .map(|(step, is_collinear)| Some(step).filter(|step| step.is_finite() && !is_collinear))
            .collect();
        let is_bounded: Vec<bool> = lowest.iter().map(Option::is_some).collect();
        let lowest: Vec<f64> = lowest.into_iter().map(Option::unwrap_or_default).collect();
        let above = LeastSquares::corrected(&columns, &residual(&columns, &target, &lowest), &is_bounded, &[]);
        let step: Vec<f64> = above.coefficients.iter().zip(&lowest).map(|(above, lowest)| above + lowest).collect();
        let moved = fit.moved(&step);
        let train_residual = residuals::residual(&moved, train);
        (above.fitted() > 0).then(|| Self::of(moved, train_residual, train, heldout))
    }

    /// The derivatives by all values as columns, and the residual as target: the rows of one capture after those of the other, each in units
    /// of its RMS.
    fn linear_problem(&self, fit: &Nonlinear<'_>, heldout: &Capture) -> (Vec<Vec<f64>>, Vec<f64>) {
        let (of_train, mut of_heldout) = (fit.secants(), fit.in_capture(heldout).secants());
        of_heldout.iter_mut().for_each(|column| heldout.leave_undetermined_out(column));
        let joined = |train: &[f64], heldout: &[f64]| -> Vec<f64> {
            let train = train.iter().map(|value| value / self.train_rms_mnm);
            train.chain(heldout.iter().map(|value| value / self.heldout_rms_mnm)).collect()
        };
        let columns = of_train.iter().zip(&of_heldout).map(|(train, heldout)| joined(train, heldout)).collect();
        (columns, joined(&self.train_residual, &self.heldout_residual))
    }
}
