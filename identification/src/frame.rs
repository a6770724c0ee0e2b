//! Mask first, then filter: the relation between torque and motion stays exactly linear.

use std::f64::consts::PI;

use dynamics::{Effect, Motion};

use crate::filter::Fir;
use crate::motion::{Band, KnobMotion, ROWS_PER_EDGE, rms};
use crate::uniform::Uniform;

/// Time around stick and reversals that is left out besides what the filters reach, s: the smoothed speed rises
/// before the knob breaks away, and contact rings.
const GUARD_S: f64 = 0.002;
/// Time over which the mask fades in and out, s: at a hard edge, noise from beyond the band would fold into it.
const FADE_S: f64 = 0.002;
/// Speed below which a knob may be sticking, as a share of the RMS speed.
const SLOW: f64 = 0.01;
/// Half length of the low-pass in periods of its edge: a Hamming window's transition is then as wide as the edge.
const HALF_LENGTH_PERIODS: f64 = 1.65;

/// The mask, the common filter and the decimation through which torque and every column pass.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    pub(crate) rate_hz: f64,
    /// 1 where the knob surely slides, 0 where it may stick, fading from one to the other.
    pub(crate) mask: Vec<f64>,
    pub(crate) fir: Fir,
    /// Every how many samples a row is kept.
    pub(crate) step: usize,
    /// Speed below which samples are masked, rad/s.
    pub(crate) threshold_rad_s: f64,
}

impl Frame {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "lengths of a few samples")]
    pub(crate) fn new(uniform: &Uniform, motion: &KnobMotion, band: &Band) -> Self {
        let rate_hz = uniform.rate_hz;
        let (threshold_rad_s, guard_s) = if motion.exact {
            (1e-6 * rms(&motion.velocity_rad_s), 0.0)
        } else {
            let slow = SLOW * rms(&motion.velocity_rad_s);
            (slow.max(8.0 * motion.velocity_noise_rad_s), GUARD_S)
        };
        let guard = (guard_s * rate_hz).round() as usize + motion.reach;
        let mut mask = mask(uniform, motion, threshold_rad_s, guard, motion.reach);
        if !motion.exact {
            fade(&mut mask, (FADE_S * rate_hz).round() as usize);
        }
        let step = ((rate_hz / (ROWS_PER_EDGE * band.edge_hz)) as usize).max(1);
        let half_length = (HALF_LENGTH_PERIODS * rate_hz / band.edge_hz).round() as usize;
        Self { rate_hz, mask, fir: Fir::low_pass(half_length, band.edge_hz, rate_hz), step, threshold_rad_s }
    }

    /// Masks, filters and decimates a full-rate column.
    pub(crate) fn rows(&self, column: &[f64]) -> Vec<f64> {
        let masked: Vec<f64> = column.iter().zip(&self.mask).map(|(value, mask)| value * mask).collect();
        self.fir.decimate(&masked, self.step)
    }

    /// The adjoint of [`Frame::rows`].
    pub(crate) fn spread(&self, rows: &[f64]) -> Vec<f64> {
        let mut spread = self.fir.spread(rows, self.step, self.mask.len());
        spread.iter_mut().zip(&self.mask).for_each(|(value, mask)| *value *= mask);
        spread
    }

    /// Number of samples that are not masked.
    pub(crate) fn sliding(&self) -> usize {
        self.mask.iter().filter(|mask| **mask > 0.0).count()
    }
}

fn mask(uniform: &Uniform, motion: &KnobMotion, threshold_rad_s: f64, guard: usize, settle: usize) -> Vec<f64> {
    let length = motion.len();
    let mut mask = vec![1.0; length];
    let blank = |mask: &mut [f64], index: usize, reach: usize| {
        mask[index.saturating_sub(reach)..(index + reach + 1).min(length)].fill(0.0);
    };
    // A run of slow samples is blanked as one, so that the cost stays linear in the samples.
    for index in 0..length {
        let slow = motion.velocity_rad_s[index].abs() <= threshold_rad_s;
        let edge = index == 0
            || index + 1 == length
            || (motion.velocity_rad_s[index - 1].abs() <= threshold_rad_s) != slow
            || (motion.velocity_rad_s[index + 1].abs() <= threshold_rad_s) != slow;
        if slow {
            blank(&mut mask, index, if edge { guard } else { 0 });
        }
        if !uniform.present[index] {
            let edge = index == 0 || index + 1 == length || uniform.present[index - 1] || uniform.present[index + 1];
            blank(&mut mask, index, if edge { settle } else { 0 });
        }
    }
    mask[..settle.min(length)].fill(0.0);
    mask[length - settle.min(length)..].fill(0.0);
    mask
}

/// Lets the mask rise as a squared sine over `length` samples from where it was zero.
#[allow(clippy::cast_precision_loss, reason = "a few samples")]
fn fade(mask: &mut [f64], length: usize) {
    let rise = |since: usize| (0.5 * PI * (since as f64 / (length + 1) as f64)).sin().powi(2);
    let sweep = |mask: &mut dyn Iterator<Item = &mut f64>| {
        let mut since = length + 1;
        for value in mask {
            since = if *value == 0.0 { 0 } else { (since + 1).min(length + 1) };
            *value = value.min(rise(since));
        }
    };
    sweep(&mut mask.iter_mut());
    sweep(&mut mask.iter_mut().rev());
}

/// An effect's full-rate columns; none if it has no part in a fit.
pub(crate) fn columns(effect: &Effect, motion: &KnobMotion) -> Vec<Vec<f64>> {
    let Some(regressors) = effect.kind().regressors else {
        return Vec::new();
    };
    let mut columns = vec![Vec::with_capacity(motion.len()); regressors.columns];
    let mut row = vec![0.0; regressors.columns];
    for index in 0..motion.len() {
        (regressors.fill)(effect.values(), &motion.at(index), &mut row);
        columns.iter_mut().zip(&row).for_each(|(column, value)| column.push(*value));
    }
    columns
}

/// Torque of an effect's columns with the coefficients given, at full rate.
pub(crate) fn torque(effect: &Effect, coefficients: &[f64], motion: &KnobMotion) -> Vec<f64> {
    let Some(regressors) = effect.kind().regressors else {
        return vec![0.0; motion.len()];
    };
    let mut row = vec![0.0; regressors.columns];
    let mut at = |motion: &Motion| {
        (regressors.fill)(effect.values(), motion, &mut row);
        row.iter().zip(coefficients).map(|(value, coefficient)| value * coefficient).sum()
    };
    (0..motion.len()).map(|index| at(&motion.at(index))).collect()
}
