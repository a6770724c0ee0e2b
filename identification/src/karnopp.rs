//! Karnopp's stick: the torques at which a resting knob breaks away.
//!
//! While the knob rests the torque ramps up; what is left of it without detents is friction, and its
//! peak when the knob breaks away is D₊ or D₋. The moment is read from the filtered acceleration, the
//! torque from the unfiltered channel.

use dynamics::{Direction, Effect, Part, effects};

use crate::estimate::{Parameter, Parameters};
use crate::motion::KnobMotion;
use crate::spectrum::median;

/// Shortest rest that counts, s.
const REST_S: f64 = 0.010;
/// Samples over which the torque is averaged before its peak is taken.
const AVERAGE: usize = 3;
/// Speed after a breakaway, in speeds that count as rest.
const CLEARLY_SLIDING: f64 = 3.0;
/// What averaging over this many samples takes off the peak is what sensor and sampling may have taken off.
const BLUR: usize = 5;
/// Fewest breakaways in one direction from which a value is given.
const FEWEST: usize = 3;
/// Speed at rest, in standard deviations of the velocity's noise.
const AT_REST: f64 = 8.0;
/// Standard deviation of a median over that of the mean, for normal errors.
const MEDIAN_COST: f64 = 1.253;

/// The breakaways of a capture.
pub(crate) struct Stick {
    /// Torques at breakaway in the negative direction, magnitudes, mNm.
    negative_mnm: Vec<f64>,
    positive_mnm: Vec<f64>,
    /// How far each peak is blurred, mNm.
    blurs_mnm: Vec<f64>,
    /// Speed below which this capture cannot tell motion from rest, rad/s.
    resolved_rad_s: f64,
    rests: usize,
}

impl Stick {
    /// Looks for rests and breakaways; `torque_mnm` is not filtered.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "lengths of a few samples")]
    pub(crate) fn of(
        torque_mnm: &[f64],
        motion: &KnobMotion,
        fitted: &[Effect],
        rate_hz: f64,
        measured: &[bool],
    ) -> Self {
        let resolved_rad_s = if motion.exact { 0.0 } else { AT_REST * motion.velocity_noise_rad_s };
        let smear = if motion.exact { 1 } else { (1.5 * rate_hz / motion.cutoff_hz).ceil() as usize };
        let rest = (REST_S * rate_hz) as usize;
        let mut stick = Self {
            negative_mnm: Vec::new(),
            positive_mnm: Vec::new(),
            blurs_mnm: Vec::new(),
            resolved_rad_s,
            rests: 0,
        };
        let mut start = None;
        for (index, velocity) in motion.velocity_rad_s.iter().enumerate() {
            let resting = velocity.abs() <= resolved_rad_s && measured[index];
            match (resting, start) {
                (true, None) => start = Some(index),
                (false, Some(first)) => {
                    start = None;
                    if index - first < rest.max(2 * smear + 4) {
                        continue;
                    }
                    stick.rests += 1;
                    let Some((away, direction)) = breakaway(motion, index, smear, resolved_rad_s) else { continue };
                    let near = away.saturating_sub(smear)..(away + smear / 2).min(motion.len());
                    let sign = direction.sign();
                    let rest: Vec<f64> = near
                        .map(|at| sign * (torque_mnm[at] - without_friction(motion, fitted, at, at > away)))
                        .collect();
                    let peak = |samples: usize| rest.windows(samples).map(mean).fold(f64::NEG_INFINITY, f64::max);
                    if rest.len() <= BLUR {
                        continue;
                    }
                    let friction = peak(AVERAGE);
                    stick.blurs_mnm.push(peak(1) - peak(BLUR));
                    match direction {
                        Direction::Positive => stick.positive_mnm.push(friction),
                        Direction::Negative => stick.negative_mnm.push(friction),
                    }
                }
                _ => {}
            }
        }
        stick
    }

    /// Adds D₋, D₊ and Δv to the parameters, and the effect itself to `effects` if a direction could be told.
    pub(crate) fn report(mut self, parameters: &mut Parameters, fitted: &mut Vec<Effect>) {
        let [negative, positive, speed] = [0, 1, 2].map(|index| &effects::karnopp_stick::KIND.parameters[index]);
        let told = [
            self.parameter(negative.name, negative.unit, "negative"),
            self.parameter(positive.name, positive.unit, "positive"),
        ];
        let values = [told[0].value, told[1].value];
        if let Some(any) = values[0].or(values[1]) {
            let limits = [values[0].unwrap_or(any), values[1].unwrap_or(any), self.resolved_rad_s];
            fitted.push(Effect::new(&effects::karnopp_stick::KIND, &limits));
        }
        parameters.0.extend(told);
        parameters.0.push(Parameter::untold(
            speed.name,
            speed.unit,
            format!(
                "the speed at which the knob comes to rest lies below the {:.4} rad/s that this capture can tell from rest",
                self.resolved_rad_s
            ),
        ));
    }

    #[allow(clippy::cast_precision_loss, reason = "a few events")]
    fn parameter(&mut self, name: &'static str, unit: &'static str, direction: &str) -> Parameter {
        let torques = if direction == "negative" { &mut self.negative_mnm } else { &mut self.positive_mnm };
        if torques.len() < FEWEST {
            let reason = format!(
                "the knob came to rest {} and broke away in the {direction} direction {}, but {FEWEST} breakaways are \
                 needed; hold it still between slow sweeps",
                times(self.rests),
                times(torques.len())
            );
            return Parameter::untold(name, unit, reason);
        }
        let value = median(torques);
        let mut distances: Vec<f64> = torques.iter().map(|torque| (torque - value).abs()).collect();
        let scatter = median(&mut distances) / 0.6745;
        let count = torques.len() as f64;
        // Student's quantile for few events, by its expansion about the normal one.
        let quantile = 1.96 * (1.0 + 1.21 / (count - 1.0) + 1.4 / (count - 1.0).powi(2));
        let half = quantile * MEDIAN_COST * scatter / count.sqrt() + median(&mut self.blurs_mnm);
        Parameter {
            name,
            value: Some(value.max(0.0)),
            unit,
            ci95: Some([(value - half).max(0.0), value + half]),
            ci95_textbook: None,
            reason: None,
        }
    }
}

/// A number of times in words that read well.
fn times(count: usize) -> String {
    match count {
        0 => "never".to_owned(),
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        more => format!("{more} times"),
    }
}

/// Torque of the angle (detents) at a sample and, once the knob moves, of its inertia, mNm.
fn without_friction(motion: &KnobMotion, fitted: &[Effect], index: usize, moving: bool) -> f64 {
    let at = motion.at(index);
    fitted
        .iter()
        .map(|effect| match effect.kind().part {
            Part::Torque(torque) => torque(effect.values(), &at),
            Part::Inertia(inertia) if moving => inertia(effect.values()) * at.acceleration_rad_s2,
            _ => 0.0,
        })
        .sum()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.iter().map(|_| 1.0).sum::<f64>()
}

/// The sample at which the knob broke away, and whither, if it truly slid off from its rest that ended at `index`.
///
/// A symmetric filter spreads a jump of the acceleration evenly to both sides: it is half way up at
/// the moment itself.
fn breakaway(motion: &KnobMotion, index: usize, smear: usize, resolved_rad_s: f64) -> Option<(usize, Direction)> {
    let end = (index + 3 * smear).min(motion.len().checked_sub(1)?);
    let start = index.saturating_sub(smear);
    let velocity = motion.velocity_rad_s[end];
    let direction = Direction::of(velocity);
    let sign = direction.sign();
    let peak = (start..end).map(|at| motion.acceleration_rad_s2[at] * sign).fold(0.0, f64::max);
    let half = (start..end).find(|at| motion.acceleration_rad_s2[*at] * sign >= 0.5 * peak)?;
    (velocity.abs() > CLEARLY_SLIDING * resolved_rad_s).then_some((half, direction))
}
