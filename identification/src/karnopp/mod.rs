//! Karnopp's stick: the torques at which a resting knob breaks away, and the speed at which it comes to rest.
//!
//! While the knob rests its torque climbs a ramp; the knob breaks away at the instant when the ramp passes D₊ or D₋. The
//! instant comes from the motion afterwards, the torque from the ramp before. The peak of the torque channel would be
//! blurred by its filter and by the rig's motion after the breakaway; the ramp is not. Δv is the speed
//! with which the knob arrives at its rest, from the same trajectory run backwards.

mod slide;

use std::borrow::Cow;
use std::ops::Range;

use dynamics::{Direction, Effect, Minimum, ParameterKind, effects};

use crate::estimate::{Parameter, Parameters};
use crate::numerics::statistics::{NORMAL_95, mean, mean_and_error, student_95};
use crate::preparation::motion::KnobMotion;
use crate::preparation::uniform::Uniform;
use crate::regression::least_squares::LeastSquares;
use slide::{Border, Side, Slide};

/// Shortest rest that counts, s.
const REST_S: f64 = 0.004;
/// Time on either side of the end of a rest in which the instant of breakaway or arrival is looked for, s.
const BORDER_S: f64 = 0.003;
/// Length of the ramp that is read, s: three periods of the 1 kHz with which a shaft rings.
const RAMP_S: f64 = 0.003;
/// Length of a second reading, s: its difference from the first shows the error of fitting a parabola.
const SHORTER_RAMP_S: f64 = 0.002;
/// Fewest samples of a ramp or on either side of a border.
const FEWEST_SAMPLES: usize = 12;
/// Time in which the shaft stops ringing after the knob came to rest, s.
const RINGING_S: f64 = 0.001;
/// Fewest readings from which a value is given.
const FEWEST_READINGS: usize = 3;
/// Speed at rest, in standard deviations of the velocity's noise.
const AT_REST: f64 = 8.0;
/// Standard deviations of the angle's noise that a resting angle may span: a rest on the edge between two steps of the
/// encoder spans one step, which is 3.5 of them.
const SPAN: f64 = 6.0;
/// A rest must last longer than a turning point would stay within the tolerance, by this factor.
const LONGER: f64 = 2.0;
/// What rounding does to an angle without noise, rad.
const ROUNDING_RAD: f64 = 1e-9;

/// Readings at the ends of a capture's rests.
#[derive(Default)]
pub(crate) struct Stick {
    /// Torques at breakaway in the negative direction, magnitudes, mNm.
    negative_mnm: Readings,
    positive_mnm: Readings,
    /// Speeds at which the knob came to rest, rad/s.
    arrivals_rad_s: Readings,
    /// Speed below which this capture cannot distinguish motion from rest, rad/s.
    resolved_rad_s: f64,
    rests: usize,
}

impl Stick {
    /// Finds the rests and reads torque and speed at their ends; `fitted` are the effects fitted so far.
    pub(crate) fn of(uniform: &Uniform, motion: &KnobMotion, fitted: &[Effect]) -> Self {
        let rate_hz = uniform.rate_hz;
        let samples = |time_s: f64| ((time_s * rate_hz).round() as usize).max(FEWEST_SAMPLES);
        // An exact motion has the angle itself, and there is no twist.
        let angle_rad: Cow<'_, [f64]> = if motion.exact {
            (&*motion.angle_rad).into()
        } else {
            let twisted = uniform.angle_rad.iter().zip(&uniform.torque_mnm);
            twisted.map(|(angle, torque)| angle - motion.compliance_rad_mnm * torque).collect()
        };
        let slide = Slide {
            angle_rad: &angle_rad,
            noise_rad: (0.5 * rate_hz * motion.angle_density).sqrt(),
            torque_mnm: &uniform.torque_mnm,
            effects: fitted,
            rate_hz,
        };
        let tolerance_rad = SPAN * slide.noise_rad + ROUNDING_RAD;
        let mut stick = Self { resolved_rad_s: AT_REST * motion.velocity_noise_rad_s, ..Self::default() };
        // The encoder sits on the other side of the torque sensor's spring. The torque from which the twist follows is blurred
        // over one delay and one sample, in which a braked knob loses speed.
        let blur_s = (1.0 + uniform.received_torque().1.abs()) / rate_hz;
        for rest in rests(&angle_rad, tolerance_rad, &uniform.present, samples(REST_S)) {
            if !is_longer_than_a_turning_point(&angle_rad, &rest, tolerance_rad, samples(BORDER_S)) {
                continue;
            }
            stick.rests += 1;
            if let Some(arrival) = slide.border(&rest, Side::Before, samples(BORDER_S)) {
                let unsure_rad_s = arrival.acceleration_rad_s2 * blur_s;
                stick.arrivals_rad_s.push(arrival.speed_rad_s, arrival.speed_rad_s + unsure_rad_s);
            }
            let Some(away) = slide.border(&rest, Side::After, samples(BORDER_S)) else { continue };
            let read = |time_s: f64| breakaway(uniform, &slide, &rest, &away, samples(time_s), RINGING_S * rate_hz);
            if let (Some(torque_mnm), Some(shorter_mnm)) = (read(RAMP_S), read(SHORTER_RAMP_S)) {
                let readings = match away.direction {
                    Direction::Negative => &mut stick.negative_mnm,
                    Direction::Positive => &mut stick.positive_mnm,
                };
                readings.push(torque_mnm * away.direction.sign(), shorter_mnm * away.direction.sign());
            }
        }
        stick
    }

    /// Adds D₋, D₊ and Δv to the parameters, and the effect itself to `fitted` if a direction could be estimated.
    pub(crate) fn report(self, parameters: &mut Parameters, fitted: &mut Vec<Effect>) {
        let [negative, positive, speed] = [0, 1, 2].map(|index| &effects::karnopp_stick::KIND.parameters[index]);
        let estimated = [
            self.negative_mnm.parameter(negative, || self.too_few("negative", &self.negative_mnm)),
            self.positive_mnm.parameter(positive, || self.too_few("positive", &self.positive_mnm)),
            self.speed(speed),
        ];
        let [negative_mnm, positive_mnm, speed_rad_s] = [0, 1, 2].map(|index| estimated[index].value);
        if let Some(any) = negative_mnm.or(positive_mnm) {
            let limits =
                [negative_mnm.unwrap_or(any), positive_mnm.unwrap_or(any), speed_rad_s.unwrap_or(self.resolved_rad_s)];
            fitted.push(Effect::new(&effects::karnopp_stick::KIND, &limits));
        }
        parameters.0.extend(estimated);
    }

    fn too_few(&self, direction: &str, seen: &Readings) -> String {
        format!(
            "breakaways in the {direction} direction that can be read off: {} after {} rests of the knob, but {} are needed; hold it \
             still between slow sweeps",
            seen.values.len(),
            self.rests,
            FEWEST_READINGS
        )
    }

    /// Δv, or the bound that the data give.
    fn speed(&self, kind: &ParameterKind) -> Parameter {
        let parameter = self.arrivals_rad_s.parameter(kind, || {
            format!(
                "rests of the knob at which a speed can be read: {1} of {0}, but {2} are needed; \
                 a speed of {3:.4} rad/s or more can be told from rest",
                self.rests,
                self.arrivals_rad_s.values.len(),
                FEWEST_READINGS,
                self.resolved_rad_s
            )
        });
        match parameter.ci95 {
            Some([low, high]) if low <= 0.0 && high > 0.0 => Parameter::not_identifiable(
                kind,
                format!(
                    "the speed at which the knob comes to rest cannot be distinguished from zero: it is at most {high:.4} rad/s"
                ),
            ),
            _ => parameter,
        }
    }
}

/// The torque at a breakaway without detents; `None` for too short a ramp.
fn breakaway(
    uniform: &Uniform,
    slide: &Slide<'_>,
    rest: &Range<usize>,
    away: &Border,
    length: usize,
    ringing: f64,
) -> Option<f64> {
    let long_enough = away.instant - rest.start as f64 > length as f64 + ringing;
    if !long_enough {
        return None;
    }
    let (received_mnm, delay) = uniform.received_torque();
    Some(ramp_end(received_mnm, delay, away.instant, length)? - slide.angle_torque_mnm(away.rest_rad))
}

/// Whether a rest lasts longer than a mere turning point would stay within the tolerance. The turning point is made of two
/// parabolas, through the distances moved within `window` samples before and after the rest. `false` next to the capture's ends.
fn is_longer_than_a_turning_point(angle_rad: &[f64], rest: &Range<usize>, tolerance_rad: f64, window: usize) -> bool {
    let outside = [rest.start.checked_sub(window), Some(rest.end - 1 + window)];
    let inside = [rest.start, rest.end - 1];
    let turning: Option<f64> = outside
        .iter()
        .zip(inside)
        .map(|(outside, inside)| {
            let moved_rad = (angle_rad.get((*outside)?)? - angle_rad[inside]).abs();
            Some(window as f64 * (tolerance_rad / moved_rad).sqrt())
        })
        .sum();
    turning.is_some_and(|turning| rest.len() as f64 > LONGER * turning)
}

/// Stretches of at least `shortest` samples in which every window of that length spans no more than the tolerance.
fn rests(angle_rad: &[f64], tolerance_rad: f64, measured: &[bool], shortest: usize) -> Vec<Range<usize>> {
    let mut rests: Vec<Range<usize>> = Vec::new();
    let mut open = false;
    for (first, window) in angle_rad.windows(shortest.max(1)).enumerate() {
        let end = first + window.len();
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        // Gives up at the first sample that is too far away: a moving knob costs little.
        let spans_little = window.iter().all(|angle_rad| {
            (low, high) = (low.min(*angle_rad), high.max(*angle_rad));
            high - low <= tolerance_rad
        });
        let still = spans_little && measured[first..end].iter().all(|measured| *measured);
        match rests.last_mut() {
            Some(rest) if still && open => rest.end = end,
            _ if still => rests.push(first..end),
            _ => {}
        }
        open = still;
    }
    rests
}

/// Value of `received_mnm`, which comes `delay` samples late, at `instant` (in samples), from a parabola through the last
/// `length` samples received up to then, which nothing later has affected. `None` for too few samples.
fn ramp_end(received_mnm: &[f64], delay: f64, instant: f64, length: usize) -> Option<f64> {
    let last = instant.floor().max(0.0) as usize;
    let first = (last + 1).checked_sub(length)?;
    let torque = received_mnm.get(first..=last)?;
    let before: Vec<f64> = (first..=last).map(|index| (index as f64 - delay - instant) / length as f64).collect();
    let columns = [vec![1.0; length], before.clone(), before.iter().map(|time| time * time).collect()];
    let parabola = LeastSquares::solve(&columns, torque);
    Some(parabola.coefficients[0])
}

/// Readings of one quantity.
#[derive(Clone, Debug, Default)]
struct Readings {
    values: Vec<f64>,
    /// The same quantities read in a second way, whose difference shows the error of reading.
    others: Vec<f64>,
}

impl Readings {
    fn push(&mut self, value: f64, other: f64) {
        self.values.push(value);
        self.others.push(other);
    }

    /// Mean and interval; `why` says why there is none.
    ///
    /// The scatter counts with Student's quantile. The error that all readings share does not average out: it is taken to lie
    /// anywhere between plus and minus the difference of the two ways' means, so that its standard deviation is that
    /// difference over √3 (Guide to the Expression of Uncertainty in Measurement, 4.3.7). The textbook's interval is the
    /// scatter alone.
    fn parameter(&self, kind: &ParameterKind, why: impl FnOnce() -> String) -> Parameter {
        if self.values.len() < FEWEST_READINGS {
            return Parameter::not_identifiable(kind, why());
        }
        let (value, standard_error) = mean_and_error(&self.values);
        let scatter = student_95((self.values.len() - 1) as f64) * standard_error;
        let difference = mean(&self.others) - value;
        let half = scatter.hypot(NORMAL_95 * difference / 3.0_f64.sqrt());
        let lowest = if kind.minimum == Minimum::None { f64::NEG_INFINITY } else { 0.0 };
        if value + half < lowest {
            let reason = "the knob breaks away against what should hold it: a weight or a spring pulls harder; balance it, or fit in \
                          the middle of its travel";
            return Parameter::not_identifiable(kind, reason.to_owned());
        }
        let interval = |half: f64| [(value - half).max(lowest), value + half];
        Parameter {
            ci95_textbook: Some(interval(scatter)),
            ..Parameter::estimated(kind, value.max(lowest), Some(interval(half)))
        }
    }
}

#[cfg(test)]
mod tests {
    use dynamics::{Effect, effects};

    use super::slide::{Side, Slide};
    use super::{ramp_end, rests};

    #[test]
    fn a_bent_ramp_that_arrives_late_is_read_at_the_instant() {
        let torque = |time: f64| 3.0 + 0.2 * time - 0.001 * time * time;
        let received: Vec<f64> = (0..100).map(|n| torque(f64::from(n) - 1.7)).collect();
        let read = ramp_end(&received, 1.7, 60.4, 20).expect("the ramp lies within the samples");
        assert!((read - torque(60.4)).abs() < 1e-9, "{read}");
    }

    #[test]
    fn a_rest_between_two_motions_is_found_and_a_reversal_is_not_one() {
        // 100 samples of motion, 60 at rest, on again, then a parabola that only reverses.
        let moving = |n: usize| 1e-3 * f64::from(u32::try_from(n).unwrap_or(0));
        let angle: Vec<f64> = (0..400)
            .map(|n| match n {
                0..100 => moving(n),
                100..160 => moving(100),
                160..300 => moving(n - 60),
                _ => moving(240) - 1e-4 * (moving(n) * 1e3 - 350.0).powi(2),
            })
            .collect();
        let found = rests(&angle, 6e-5, &vec![true; angle.len()], 20);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].start.abs_diff(100) <= 1 && found[0].end.abs_diff(160) <= 1, "{found:?}");
    }

    #[test]
    fn a_knob_on_a_slow_ramp_leaves_where_the_torque_passes_the_friction() {
        // A coarse encoder shows the motion a window and more after it began.
        const STEP_RAD: f64 = 4e-4;
        let since_s = |n: u32| f64::from(n.saturating_sub(50)) * 1e-3;
        let angle: Vec<f64> =
            (0..120).map(|n| (1000.0 * since_s(n).powi(3) / 6.0 / STEP_RAD).round() * STEP_RAD).collect();
        let torque: Vec<f64> = (0..120).map(f64::from).collect();
        let noise_rad = STEP_RAD / 12.0_f64.sqrt();
        let slide = Slide {
            angle_rad: &angle,
            noise_rad,
            torque_mnm: &torque,
            effects: &[
                Effect::new(&effects::inertia::KIND, &[1.0]),
                Effect::new(&effects::friction::KIND, &[50.0, 50.0, 0.0, 0.0]),
            ],
            rate_hz: 1000.0,
        };
        let rest = rests(&angle, 6.0 * noise_rad, &[true; 120], 12).remove(0);
        let border = slide.border(&rest, Side::After, 12).expect("the knob leaves within the window");
        assert!((border.instant - 50.0).abs() < 3.0, "{} in {rest:?}", border.instant);
    }
}
