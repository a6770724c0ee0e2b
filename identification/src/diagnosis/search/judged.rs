//! How well a fitted structure explains the capture to which it was fitted, and another one.

use dynamics::Effect;

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::nonlinear::Nonlinear;
use crate::diagnosis::model_fit::residuals;
use crate::diagnosis::model_fit::separable::Separable;
use crate::diagnosis::model_fit::structure::Structure;
use crate::numerics::statistics::{mean_over_error, student_above};
use crate::numerics::vector::{square, sum};
use crate::regression::least_squares::LeastSquares;

/// Stretches over which a comparison of two structures is repeated.
const BLOCKS: usize = 60;
/// How much louder than the quietest tenth of a residual's stretches noise alone may be.
const QUIET: f64 = 1.25;
/// Change of the logarithm of a stretch's mean square above which two structures differ there …
const DIFFERS: f64 = 0.02;
/// … and fewest such stretches from which anything is concluded.
const FEWEST_DIFFERING: usize = 4;

/// A structure with what it leaves of both captures.
#[derive(Clone, Debug)]
pub(crate) struct Judged {
    pub(crate) structure: Structure,
    pub(crate) train_residual: Vec<f64>,
    pub(crate) heldout_residual: Vec<f64>,
    pub(crate) train_rms_mnm: f64,
    pub(crate) heldout_rms_mnm: f64,
    /// RMS that the sensors' noise leaves of either capture beside this structure, mNm.
    pub(crate) train_floor_mnm: f64,
    pub(crate) heldout_floor_mnm: f64,
    /// Log-likelihood of both captures less what the structure's freedom costs, nats.
    pub(crate) evidence: f64,
}

impl Judged {
    pub(crate) fn separable(fit: &Separable<'_>, heldout: &Capture) -> Self {
        Self::of(fit.structure.clone(), fit.residual.clone(), fit.capture, heldout)
    }

    /// Judges a fit in which everything was searched.
    pub(crate) fn nonlinear(fit: &Nonlinear<'_>, train: &Capture, heldout: &Capture) -> Self {
        Self::of(fit.structure.clone(), fit.residual.clone(), train, heldout)
    }

    pub(super) fn of(structure: Structure, train_residual: Vec<f64>, train: &Capture, heldout: &Capture) -> Self {
        let heldout_residual = residual_elsewhere(&structure, heldout);
        let rms = |residual: &[f64], capture: &Capture| (square(residual) / capture.weight).sqrt();
        let train_rms_mnm = rms(&train_residual, train);
        let heldout_rms_mnm = rms(&heldout_residual, heldout);
        let likelihood = -train.weight * train_rms_mnm.max(f64::MIN_POSITIVE).ln()
            - heldout.weight * heldout_rms_mnm.max(f64::MIN_POSITIVE).ln();
        let inertia = structure.inertia();
        Self {
            // A servo pushing against a stuck knob makes rests louder than the sensors, but true noise is in every stretch.
            train_floor_mnm: train.floor_of_mnm(&structure).min(QUIET * train.quiet_rms_mnm(&train_residual, inertia)),
            heldout_floor_mnm: heldout
                .floor_of_mnm(&structure)
                .min(QUIET * heldout.quiet_rms_mnm(&heldout_residual, inertia)),
            evidence: likelihood - cost(&structure, train, heldout),
            structure,
            train_residual,
            heldout_residual,
            train_rms_mnm,
            heldout_rms_mnm,
        }
    }

    /// The same structure judged by another held-out capture.
    pub(crate) fn judged_by(&self, train: &Capture, heldout: &Capture) -> Self {
        Self::of(self.structure.clone(), self.train_residual.clone(), train, heldout)
    }

    /// The same judgement for an equivalent structure, which leaves the same residuals; only the cost of its freedom differs.
    pub(crate) fn with_structure(self, structure: Structure, train: &Capture, heldout: &Capture) -> Self {
        let cost = |structure: &Structure| cost(structure, train, heldout);
        Self { evidence: self.evidence + cost(&self.structure) - cost(&structure), structure, ..self }
    }

    /// Name of the structure's newest effect, the last one; empty without effects.
    pub(crate) fn newest(&self) -> &'static str {
        self.structure.effects.last().map_or("", |effect| effect.kind().name)
    }

    /// Whether the newest effect is fitted to each capture anew.
    pub(crate) fn newest_is_per_capture(&self) -> bool {
        self.structure.effects.last().is_some_and(is_per_capture)
    }

    /// The same judgement with the effect of that name moved to the end; `None` if there is none.
    pub(crate) fn with_newest(mut self, name: &str) -> Option<Self> {
        let index = self.structure.position(name)?;
        let (effect, columns) = (self.structure.effects[index], self.structure.columns[index]);
        self.structure = self.structure.without(index).with(effect, columns);
        Some(self)
    }

    /// Whether it predicts anything: a simulated body can overshoot beyond all numbers.
    pub(crate) fn is_finite(&self) -> bool {
        [self.evidence, self.heldout_rms_mnm, self.train_floor_mnm, self.heldout_floor_mnm]
            .iter()
            .all(|value| value.is_finite())
    }

    /// RMS left of the held-out capture, in floors.
    pub(crate) fn heldout_over_floor(&self) -> f64 {
        self.heldout_rms_mnm / self.heldout_floor_mnm
    }

    /// RMS left of the training capture, in floors.
    pub(crate) fn train_over_floor(&self) -> f64 {
        self.train_rms_mnm / self.train_floor_mnm
    }

    /// Share of this structure's training residual above the floor that another structure explains.
    pub(crate) fn explained_by(&self, other: &Self) -> f64 {
        let above = |level_mnm: f64| self.train_rms_mnm.powi(2) - level_mnm.powi(2);
        above(other.train_rms_mnm) / above(self.train_floor_mnm)
    }

    /// The larger RMS left of the two captures, in floors.
    pub(crate) fn most_over_floor(&self) -> f64 {
        self.train_over_floor().max(self.heldout_over_floor())
    }

    /// Mean square above the floor, averaged over both captures, mNm².
    pub(crate) fn excess(&self) -> f64 {
        self.excess_above(self.floors_mnm())
    }

    /// Mean square above given floors of the training and the held-out capture, mNm².
    pub(crate) fn excess_above(&self, floors_mnm: [f64; 2]) -> f64 {
        let above = |rms: f64, floor: f64| rms * rms - floor * floor;
        0.5 * (above(self.train_rms_mnm, floors_mnm[0]) + above(self.heldout_rms_mnm, floors_mnm[1]))
    }

    /// Mean square above the lower of this one's floors and another's, mNm².
    pub(crate) fn excess_above_lower_floor(&self, other: &Self) -> f64 {
        let (own, other) = (self.floors_mnm(), other.floors_mnm());
        self.excess_above([own[0].min(other[0]), own[1].min(other[1])])
    }

    /// Floors of the training and the held-out capture, mNm.
    pub(crate) fn floors_mnm(&self) -> [f64; 2] {
        [self.train_floor_mnm, self.heldout_floor_mnm]
    }

    /// Probability that chance alone makes this structure predict the held-out capture, stretch after stretch, as much better
    /// than `other` as it does; one where the two differ in too few stretches to say.
    pub(crate) fn heldout_p_value(&self, other: &Self) -> f64 {
        p_value(&other.heldout_residual, &self.heldout_residual)
    }

    /// Share of this structure's gains over `other` in stretches of the held-out capture that it does not lose in other stretches.
    pub(crate) fn kept_share(&self, other: &Self) -> f64 {
        let gains = stretches(&other.heldout_residual, &self.heldout_residual);
        let (won, lost): (Vec<f64>, Vec<f64>) = gains.into_iter().partition(|gain| *gain > 0.0);
        1.0 + sum(&lost) / sum(&won).max(f64::MIN_POSITIVE)
    }

    /// Mean gain of this structure over `other`, in standard errors, over the stretches of both captures in which the two differ
    /// at all: an end stop does not act everywhere.
    pub(crate) fn steadily_better_than(&self, other: &Self) -> f64 {
        let mut gains = stretches(&other.train_residual, &self.train_residual);
        gains.extend(stretches(&other.heldout_residual, &self.heldout_residual));
        where_differing(gains).map_or(0.0, |gains| mean_over_error(&gains))
    }
}

/// What a structure's freedom costs, nats.
fn cost(structure: &Structure, train: &Capture, heldout: &Capture) -> f64 {
    0.5 * structure.freedom() as f64 * (train.weight + heldout.weight).ln()
}

/// Probability that chance alone makes `after` as much smaller than `before` as observed, stretch after stretch; 1 if they differ
/// in too few stretches.
pub(crate) fn p_value(before: &[f64], after: &[f64]) -> f64 {
    let gains = where_differing(stretches(before, after));
    gains.map_or(1.0, |gains| student_above(mean_over_error(&gains), (gains.len() - 1) as f64))
}

/// The gains of stretches in which two structures differ; `None` for too few.
fn where_differing(mut gains: Vec<f64>) -> Option<Vec<f64>> {
    gains.retain(|gain| gain.abs() > DIFFERS);
    (gains.len() >= FEWEST_DIFFERING).then_some(gains)
}

/// By how much the logarithm of the mean square falls in each stretch.
fn stretches(before: &[f64], after: &[f64]) -> Vec<f64> {
    let length = before.len().div_ceil(BLOCKS).max(1);
    // Stretches with hardly any rows must not weigh as much as whole ones.
    let typical = 0.1 * square(before).min(square(after)) / BLOCKS as f64;
    before
        .chunks(length)
        .zip(after.chunks(length))
        .map(|(before, after)| ((square(before) + typical) / (square(after) + typical)).ln())
        .collect()
}

/// Whether an effect belongs to a capture and not to the knob, as a hum does.
fn is_per_capture(effect: &Effect) -> bool {
    effect.kind().hypothesis.is_some_and(|hypothesis| hypothesis.per_capture)
}

/// Residual of a structure in a capture that it was not fitted to, without the components that the other capture leaves undetermined.
/// Effects that belong to a capture and not to the knob are fitted anew.
fn residual_elsewhere(structure: &Structure, capture: &Capture) -> Vec<f64> {
    let own: Vec<usize> =
        (0..structure.effects.len()).filter(|index| is_per_capture(&structure.effects[*index])).collect();
    let mut left = residuals::residual(&structure.without_all(&own), capture);
    if !own.is_empty() {
        let rows: Vec<Vec<f64>> = own.iter().flat_map(|index| capture.rows_of(structure, *index)).collect();
        left = LeastSquares::held(&rows, &left, &vec![false; rows.len()], &[]).residual;
    }
    capture.leave_undetermined_out(&mut left);
    left
}
