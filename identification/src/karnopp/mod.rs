//! Karnopp's stick: the torques at which a resting knob breaks away, and the speed at which it comes to rest.
//!
//! While the knob rests its torque climbs a ramp; it breaks away at the instant when the ramp passes D₊ or D₋. The
//! instant comes from the motion afterwards, the torque from the ramp before. The peak of the torque channel would be
//! blurred by its filter and by what the rig does once the knob is gone; the ramp is not. The speed Δv is the one
//! with which the knob arrives at its rest, by the same trajectory run backwards.

mod ramp;
mod readings;
mod rests;
mod slide;

use std::ops::Range;

use dynamics::{Direction, Effect, effects};

use crate::estimate::{Parameter, Parameters};
use crate::preparation::motion::KnobMotion;
use crate::preparation::uniform::Uniform;

use ramp::ramp_end;
use readings::Readings;
use rests::rests;
use slide::{Border, Side, Slide};

/// Shortest rest that counts, s.
const REST_S: f64 = 0.004;
/// Time on either side of the end of a rest in which the border is looked for, s.
const BORDER_S: f64 = 0.003;
/// Length of the ramp that is read, s: three periods of the 1 kHz with which a shaft rings.
const RAMP_S: f64 = 0.003;
/// Length of a second reading, s: what the two differ by is what a parabola lacks.
const SHORTER_RAMP_S: f64 = 0.002;
/// Fewest samples of a ramp or on either side of a border.
const FEWEST_SAMPLES: usize = 12;
/// Time that the shaft is given to calm down after the knob came to rest, s.
const CALM_S: f64 = 0.001;

/// Speed at rest, in standard deviations of the velocity's noise.
const AT_REST: f64 = 8.0;

/// The rests of a capture and what their ends tell.
pub(crate) struct Stick {
    /// Torques at breakaway in the negative direction, magnitudes, mNm.
    negative_mnm: Readings,
    positive_mnm: Readings,
    /// Speeds at which the knob came to rest, rad/s.
    arrivals_rad_s: Readings,
    /// Speed below which this capture cannot identify motion from rest, rad/s.
    resolved_rad_s: f64,
    rests: usize,
}

impl Stick {
    /// Looks for rests and at their ends; `fitted` is what has been fitted so far.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "lengths of a few samples")]
    pub(crate) fn of(uniform: &Uniform, motion: &KnobMotion, fitted: &[Effect]) -> Self {
        let rate_hz = uniform.rate_hz;
        let samples = |time_s: f64| ((time_s * rate_hz).round() as usize).max(FEWEST_SAMPLES);
        let twisted = uniform.angle_rad.iter().zip(&uniform.torque_mnm);
        let angle_rad: Vec<f64> = twisted.map(|(angle, torque)| angle - motion.compliance_rad_mnm * torque).collect();
        let slide = Slide {
            angle_rad: &angle_rad,
            noise_rad: (0.5 * rate_hz * motion.angle_density).sqrt(),
            torque_mnm: &uniform.torque_mnm,
            effects: fitted,
            rate_hz,
        };
        let mut stick = Self {
            negative_mnm: Readings::default(),
            positive_mnm: Readings::default(),
            arrivals_rad_s: Readings::default(),
            resolved_rad_s: AT_REST * motion.velocity_noise_rad_s,
            rests: 0,
        };
        // Encoder and torque sensor sit on the other side of the torque sensor's spring, and the torque that tells its
        // twist is one delay and one sample blurred: a braked knob loses speed meanwhile.
        let blur_s = (1.0 + uniform.received_torque().1.abs()) / rate_hz;
        for rest in rests(&angle_rad, slide.noise_rad, &uniform.present, samples(REST_S)) {
            stick.rests += 1;
            if let Some(arrival) = slide.border(&rest, Side::Before, samples(BORDER_S)) {
                let unsure_rad_s = arrival.acceleration_rad_s2 * blur_s;
                stick.arrivals_rad_s.push(arrival.speed_rad_s, arrival.speed_rad_s + unsure_rad_s);
            }
            let Some(away) = slide.border(&rest, Side::After, samples(BORDER_S)) else { continue };
            let read = |time_s: f64| breakaway(uniform, &slide, &rest, &away, samples(time_s), CALM_S * rate_hz);
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

    /// Adds D₋, D₊ and Δv to the parameters, and the effect itself to `effects` if a direction could be estimated.
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
            "the knob came to rest {} and broke away in the {direction} direction {} so that it could be read off, but \
             {} breakaways are needed; hold it still between slow sweeps",
            times(self.rests),
            times(seen.count()),
            readings::FEWEST
        )
    }

    /// Δv, or the bound that the data give.
    fn speed(&self, kind: &dynamics::ParameterKind) -> Parameter {
        let parameter = self.arrivals_rad_s.parameter(kind, || {
            format!(
                "the knob came to rest {}, of which {} can be read for its speed, but {} are needed; \
                 from {:.4} rad/s on this capture can tell it from rest",
                times(self.rests),
                self.arrivals_rad_s.count(),
                readings::FEWEST,
                self.resolved_rad_s
            )
        });
        match parameter.ci95 {
            Some([low, high]) if low <= 0.0 => Parameter::not_identifiable(
                kind.name,
                kind.unit,
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
    calm: f64,
) -> Option<f64> {
    let long_enough = away.instant - slide::to_f64(rest.start) > slide::to_f64(length) + calm;
    if !long_enough {
        return None;
    }
    let (received_mnm, delay) = uniform.received_torque();
    Some(ramp_end(received_mnm, delay, away.instant, length)? - slide.angle_torque_mnm(away.rest_rad))
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
