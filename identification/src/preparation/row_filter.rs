//! Mask, low-pass and decimation by which samples become rows: the mask comes first, so that the relation between torque and
//! motion stays exactly linear.

use std::f64::consts::PI;
use std::ops::Range;

use dynamics::{Effect, effects};

use super::band::Band;
use super::clock::whole;
use super::filter::Fir;
use super::motion::KnobMotion;
use super::uniform::Uniform;
use crate::numerics::fourier::Response;
use crate::numerics::statistics::{rms, runs};
use crate::numerics::vector;
use crate::samples::{FEWEST_SAMPLES, FitError};

/// Time around stick and reversals that is left out beyond the reach of the filters, s: the smoothed speed rises
/// before the knob breaks away, and contact rings.
pub(crate) const GUARD_S: f64 = 0.002;
/// Time over which the mask fades in and out, s: at a hard edge, noise from beyond the band would fold into it.
const FADE_S: f64 = 0.002;
/// Speed below which a knob may be sticking, as a share of the RMS speed.
pub(crate) const SLOW: f64 = 0.01;
/// Half length of the low-pass in periods of its edge: a Hamming window's transition is then as wide as the edge.
const HALF_LENGTH_PERIODS: f64 = 1.65;
/// Rows are kept at this multiple of the band's edge.
pub(crate) const ROWS_PER_EDGE: f64 = 2.5;
/// Samples that are filtered together: few enough to stay in a processor's cache.
const BLOCK: usize = 2048;

/// The mask, the common filter and the decimation through which torque and every column pass.
#[derive(Clone, Debug)]
pub(crate) struct RowFilter {
    pub(crate) rate_hz: f64,
    /// 1 where the knob surely slides, 0 where it may stick, fading from one to the other.
    pub(crate) mask: Vec<f64>,
    pub(crate) fir: Fir,
    /// Every how many samples a row is kept.
    pub(crate) step: usize,
    /// Speed below which samples are masked, rad/s.
    pub(crate) threshold_rad_s: f64,
    /// A further linear response that the rows pass after decimation.
    pub(crate) response: Option<Response>,
}

impl RowFilter {
    pub(crate) fn new(uniform: &Uniform, motion: &KnobMotion, band: &Band) -> Self {
        let rate_hz = uniform.rate_hz;
        let (threshold_rad_s, guard_s) = if motion.exact {
            (1e-6 * rms(&motion.velocity_rad_s), 0.0)
        } else {
            let slow = SLOW * rms(&motion.velocity_rad_s);
            (slow.max(8.0 * motion.velocity_noise_rad_s), GUARD_S)
        };
        let guard = samples(guard_s, rate_hz) + motion.reach;
        let mut mask = mask(uniform, motion, threshold_rad_s, |_| guard);
        if !motion.exact {
            fade(&mut mask, samples(FADE_S, rate_hz));
        }
        Self {
            rate_hz,
            mask,
            fir: row_low_pass(band.edge_hz, rate_hz),
            step: row_step(band.edge_hz, rate_hz),
            threshold_rad_s,
            response: None,
        }
    }

    /// The same filter for other samples: those that the mask leaves out only because the filters reach from there to a turning point
    /// at which the knob does not rest. `None` if there are none.
    pub(crate) fn next_to_turning_points(&self, uniform: &Uniform, motion: &KnobMotion) -> Option<Self> {
        if motion.exact {
            return None;
        }
        let guard = samples(GUARD_S, self.rate_hz);
        let is_rest = |run: usize| run > motion.reach;
        let mut mask =
            mask(uniform, motion, self.threshold_rad_s, |run| if is_rest(run) { guard + motion.reach } else { guard });
        fade(&mut mask, samples(FADE_S, self.rate_hz));
        mask.iter_mut().zip(&self.mask).for_each(|(wider, mask)| *wider -= mask);
        let is_empty = mask.iter().all(|share| *share == 0.0);
        (!is_empty).then(|| Self { mask, ..self.clone() })
    }

    /// Masks, filters and decimates a full-rate column.
    pub(crate) fn rows(&self, column: &[f64]) -> Vec<f64> {
        self.rows_of(1, |range, columns| columns[0].copy_from_slice(&column[range])).remove(0)
    }

    /// Masks, filters and decimates `count` columns that `fill` writes for a range of samples: none is ever held whole.
    pub(crate) fn rows_of(&self, count: usize, mut fill: impl FnMut(Range<usize>, &mut [Vec<f64>])) -> Vec<Vec<f64>> {
        let (samples, half) = (self.mask.len(), self.fir.half_length());
        let total = samples.div_ceil(self.step);
        let mut rows = vec![vec![0.0; total]; count];
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); count];
        let block = (BLOCK / self.step).max(1) + half / self.step;
        for start in (0..total).step_by(block) {
            let end = (start + block).min(total);
            let range = (start * self.step).saturating_sub(half)..((end - 1) * self.step + half + 1).min(samples);
            if self.mask[range.clone()].iter().all(|share| *share == 0.0) {
                continue;
            }
            columns.iter_mut().for_each(|column| column.resize(range.len(), 0.0));
            fill(range.clone(), &mut columns);
            let first = start * self.step - range.start;
            // A column that is zero over the whole range adds nothing to the rows.
            let acting =
                rows.iter_mut().zip(&mut columns).filter(|(_, column)| column.iter().any(|value| *value != 0.0));
            for (rows, column) in acting {
                vector::multiply_by(column, &self.mask[range.clone()]);
                self.fir.decimate_part(column, first, self.step, &mut rows[start..end]);
            }
        }
        match &self.response {
            Some(response) => rows.into_iter().map(|rows| response.of(rows)).collect(),
            None => rows,
        }
    }

    /// The same of columns whose values `write` gives sample by sample; where the mask is zero they are zero.
    pub(crate) fn rows_by_sample(&self, count: usize, write: impl FnMut(usize, &mut [f64])) -> Vec<Vec<f64>> {
        self.rows_of(count, self.by_sample(count, write))
    }

    /// Writes `count` columns for a range of samples, whose values `write` gives sample by sample; where the mask is zero they are zero.
    pub(crate) fn by_sample(
        &self,
        count: usize,
        mut write: impl FnMut(usize, &mut [f64]),
    ) -> impl FnMut(Range<usize>, &mut [Vec<f64>]) {
        let mut values = vec![0.0; count];
        move |range, columns| {
            for (place, at) in range.enumerate() {
                if self.mask[at] == 0.0 {
                    values.fill(0.0);
                } else {
                    write(at, &mut values);
                }
                columns.iter_mut().zip(&values).for_each(|(column, value)| column[place] = *value);
            }
        }
    }

    /// Rows of an effect's columns; none if it has no part in a fit.
    pub(crate) fn effect_rows(&self, effect: &Effect, motion: &KnobMotion) -> Vec<Vec<f64>> {
        let count = effect.kind().regressors.map_or(0, |regressors| regressors.columns);
        let is_unmasked = |index: usize| self.mask[index] != 0.0;
        self.rows_of(count, |range, columns| fill(effect, motion, is_unmasked, range, columns))
    }

    /// The adjoint of [`RowFilter::rows`] without a response.
    pub(crate) fn spread(&self, rows: &[f64]) -> Vec<f64> {
        let mut spread = self.fir.spread(rows, self.step, self.mask.len());
        spread.iter_mut().zip(&self.mask).for_each(|(value, mask)| *value *= mask);
        spread
    }

    /// Number of rows that the mask leaves, each counted by the square of its weight.
    pub(crate) fn weight(&self) -> f64 {
        vector::square(&self.mask) / self.step as f64
    }

    /// Speeds at the rows where the knob slides, rad/s.
    pub(crate) fn sliding_speeds_rad_s(&self, motion: &KnobMotion) -> Vec<f64> {
        let rows = motion.velocity_rad_s.iter().zip(&self.mask).step_by(self.step);
        rows.filter(|(_, mask)| **mask > 0.0).map(|(velocity, _)| velocity.abs()).collect()
    }

    /// An error if the knob slides in too few samples for a fit.
    pub(crate) fn checked(&self) -> Result<(), FitError> {
        let samples = self.sliding();
        if samples < FEWEST_SAMPLES / 2 {
            return Err(FitError::HardlyMoving { threshold_rad_s: self.threshold_rad_s, samples });
        }
        Ok(())
    }

    /// Number of samples that the mask does not set to zero.
    pub(crate) fn sliding(&self) -> usize {
        self.mask.iter().filter(|mask| **mask > 0.0).count()
    }
}

/// The low-pass before rows are kept in a band.
pub(crate) fn row_low_pass(edge_hz: f64, rate_hz: f64) -> Fir {
    Fir::low_pass((HALF_LENGTH_PERIODS * rate_hz / edge_hz).round() as usize, edge_hz, rate_hz)
}

/// Every how many samples a row is kept in a band.
pub(crate) fn row_step(edge_hz: f64, rate_hz: f64) -> usize {
    whole(rate_hz / (ROWS_PER_EDGE * edge_hz)).max(1)
}

fn samples(duration_s: f64, rate_hz: f64) -> usize {
    (duration_s * rate_hz).round() as usize
}

/// The mask without fading. It is zero at lost samples and both ends and within the filters' reach of them, and at runs of slow samples and
/// as many samples around each as `guard` gives for its length.
///
/// Where a measured velocity changes its sign from one sample to the next, both count as slow.
fn mask(uniform: &Uniform, motion: &KnobMotion, threshold_rad_s: f64, guard: impl Fn(usize) -> usize) -> Vec<f64> {
    let length = motion.len();
    let mut mask = vec![1.0; length];
    let reach = motion.reach.min(length);
    let velocity = &motion.velocity_rad_s;
    let mut is_slow: Vec<bool> = velocity.iter().map(|velocity| velocity.abs() <= threshold_rad_s).collect();
    let turns = |after: &usize| !motion.exact && velocity[after - 1] * velocity[*after] < 0.0;
    (1..length).filter(turns).for_each(|after| is_slow[after - 1..=after].fill(true));
    blank_runs(&mut mask, &is_slow, |is_slow| *is_slow, guard);
    blank_runs(&mut mask, &uniform.present, |is_present| !is_present, |_| reach);
    mask[..reach].fill(0.0);
    mask[length - reach..].fill(0.0);
    mask
}

/// Sets the mask to zero at every run of samples to be `left_out`, and as many samples around it as `guard` gives for its length.
pub(super) fn blank_runs<T>(
    mask: &mut [f64],
    samples: &[T],
    left_out: impl Fn(&T) -> bool,
    guard: impl Fn(usize) -> usize,
) {
    let runs = runs(samples, |one, other| left_out(one) == left_out(other));
    for run in runs.filter(|run| left_out(&samples[run.start])) {
        let guard = guard(run.len());
        mask[run.start.saturating_sub(guard)..(run.end + guard).min(samples.len())].fill(0.0);
    }
}

/// Lets the mask rise as a squared sine over `length` samples from where it was zero.
fn fade(mask: &mut [f64], length: usize) {
    let rise: Vec<f64> =
        (0..=length).map(|since| (0.5 * PI * (since as f64 / (length + 1) as f64)).sin().powi(2)).collect();
    let sweep = |mask: &mut dyn Iterator<Item = &mut f64>| {
        let mut since = rise.len();
        for value in mask {
            since = if *value == 0.0 { 0 } else { since + 1 };
            *value = rise.get(since).map_or(*value, |rise| value.min(*rise));
        }
    };
    sweep(&mut mask.iter_mut());
    sweep(&mut mask.iter_mut().rev());
}

/// Writes an effect's leading columns for a range of samples; samples that take no part may be zero.
pub(crate) fn fill(
    effect: &Effect,
    motion: &KnobMotion,
    takes_part: impl Fn(usize) -> bool,
    range: Range<usize>,
    columns: &mut [Vec<f64>],
) {
    let Some(regressors) = effect.kind().regressors else { return };
    // The base model's effects and sinusoids by whole columns; the others sample by sample, as they define themselves.
    let name = effect.kind().name;
    match columns {
        [acceleration] if name == effects::inertia::KIND.name => {
            acceleration.copy_from_slice(&motion.acceleration_rad_s2[range]);
            return;
        }
        [sine, cosine] if name == effects::detent::KIND.name => {
            vector::sines(&motion.angle_rad[range], 1.0 / effect.values()[1], sine, cosine);
            return;
        }
        lines if name == effects::cogging::KIND.name => {
            for (line, parameter) in lines.chunks_exact_mut(2).zip(regressors.searched) {
                let per_turn = effect.values()[*parameter];
                match line {
                    [sine, cosine] if per_turn != 0.0 => {
                        vector::sines(&motion.angle_rad[range.clone()], per_turn, sine, cosine);
                    }
                    absent => absent.iter_mut().for_each(|column| column.fill(0.0)),
                }
            }
            return;
        }
        [coulomb_negative, coulomb_positive, viscous_negative, viscous_positive]
            if name == effects::friction::KIND.name =>
        {
            let columns = [coulomb_negative, coulomb_positive, viscous_negative, viscous_positive];
            vector::friction(&motion.velocity_rad_s[range], columns.map(Vec::as_mut_slice));
            return;
        }
        _ => {}
    }
    let free_rad = effects::end_stop::free_rad(effect);
    let mut row = vec![0.0; columns.len()];
    for (place, index) in range.enumerate() {
        if !takes_part(index) || free_rad.contains(&motion.angle_rad[index]) {
            columns.iter_mut().for_each(|column| column[place] = 0.0);
            continue;
        }
        (regressors.fill)(effect, &motion.at(index), &mut row);
        columns.iter_mut().zip(&row).for_each(|(column, value)| column[place] = *value);
    }
}
