//! The fit of a shaft that twists, in a capture as it would be behind the shaft.
//!
//! The measured torque tells the twist of a shaft of known stiffness and damping at once, without simulating anything:
//! behind it everything is linear again, and the sum of squares has one wide valley over stiffness where a simulated
//! resonance has many narrow ones. The torque's noise above the resonance, which this makes louder, is turned down by
//! the shaft's own response.

use std::f64::consts::TAU;

use dynamics::{Coupling, Effect, EffectKind, Hypothesis, Part};
use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::capture::Capture;
use super::separable::Separable;
use super::structure::Structure;
use super::unequal;
use crate::numerics::fourier::Response;
use crate::preparation::motion::KnobMotion;

/// Ratios by which a shaft's values are changed at first and at last.
const COARSEST: f64 = 1.5;
const FINEST: f64 = 1.02;
/// How often a shaft's values and all others are fitted in turn.
const TWISTS: usize = 2;
/// Log-likelihood that the best start of a shaft must promise, nats.
const PROMISES: f64 = 1.0;

/// The best values for a shaft and all else, found without simulation, since the measured torque tells its twist; `None` if a stiff one
/// explains as much.
pub(crate) fn fitted(
    effects: &[Effect],
    hypothesis: &Hypothesis,
    base: &Structure,
    train: &Capture,
) -> Option<Structure> {
    let mut stiff = base.clone();
    let starts: Vec<(f64, Effect)> =
        effects.par_iter().map(|effect| Some((squares(effect, base, train)?, *effect))).collect::<Option<_>>()?;
    let (least, mut best) = starts.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    if 0.5 * train.weight * (Separable::new(base.clone(), train).squares() / least).ln() < PROMISES {
        return None;
    }
    for _ in 0..TWISTS {
        best = best_shaft(best, hypothesis, &stiff, train)?;
        // What moves behind a shaft of these values no longer looks like what moves with the cap.
        let capture = behind(&shaft(&best)?, stiff.inertia(), train);
        stiff = unequal::settled(stiff, &capture).structure;
    }
    Some(stiff.with(best, 0))
}

/// Whether a coupling has no gap: its bodies do not lose touch.
pub(crate) fn has_no_gap(kind: &'static EffectKind) -> bool {
    shaft(&Effect::new(kind, &[1.0; dynamics::MAX_PARAMETERS])).is_some()
}

/// The coupling that an effect makes, if bodies do not lose touch in it.
fn shaft(effect: &Effect) -> Option<Coupling> {
    match effect.kind().part {
        Part::Coupling(coupling) => Some(coupling(effect.values())).filter(|coupling| coupling.half_gap_rad == 0.0),
        _ => None,
    }
}

/// Sum of squares of what a structure leaves behind a shaft, mNm².
fn squares(effect: &Effect, base: &Structure, train: &Capture) -> Option<f64> {
    let capture = behind(&shaft(effect)?, base.inertia(), train);
    Some(Separable::new(base.clone(), &capture).squares())
}

/// The values of a shaft with which a structure leaves least, found by going along one after the other in ever smaller steps.
fn best_shaft(mut best: Effect, hypothesis: &Hypothesis, base: &Structure, train: &Capture) -> Option<Effect> {
    let mut least = squares(&best, base, train)?;
    let mut ratio = COARSEST;
    while ratio > FINEST {
        let mut moved = false;
        for search in hypothesis.searched {
            let at = |factor: f64| {
                let mut tried = best;
                tried.values_mut()[search.parameter] *= factor;
                Some((squares(&tried, base, train)?, tried))
            };
            let (up, down) = rayon::join(|| at(ratio), || at(1.0 / ratio));
            if let Some(better) = [up?, down?].into_iter().find(|(there, _)| *there < least) {
                ((least, best), moved) = (better, true);
            }
        }
        if !moved {
            ratio = ratio.sqrt();
        }
    }
    Some(best)
}

/// The capture of a knob of this inertia as it would be with the motion of the shaft's other end.
fn behind(shaft: &Coupling, inertia: f64, capture: &Capture) -> Capture {
    let mut behind = capture.with_motion(motion(shaft, capture));
    behind.row_filter.response = Some(turned_down(inertia, shaft, capture));
    behind
}

/// The motion of the body behind the shaft.
fn motion(shaft: &Coupling, capture: &Capture) -> KnobMotion {
    let mut motion = capture.motion.clone();
    let [torque, rate, curvature] = capture.torques();
    let sides = [
        (&mut motion.angle_rad, torque),
        (&mut motion.velocity_rad_s, rate),
        (&mut motion.acceleration_rad_s2, curvature),
    ];
    // Torque on a spring beside a damper: the twist follows it with this time constant.
    let kept = (-shaft.stiffness_mnm_rad / (shaft.damping * capture.rate_hz)).exp();
    for (values, torque) in sides {
        let mut twist = 0.0;
        for (value, torque_mnm) in values.iter_mut().zip(torque) {
            twist = kept * twist + (1.0 - kept) * torque_mnm / shaft.stiffness_mnm_rad;
            *value -= twist;
        }
    }
    motion
}

/// The response of an inertia on the shaft: torque at the sensor over torque on the inertia.
#[allow(clippy::cast_precision_loss, reason = "a decimation")]
fn turned_down(inertia: f64, shaft: &Coupling, capture: &Capture) -> Response {
    let row_filter = &capture.row_filter;
    let rate_hz = capture.rate_hz / row_filter.step as f64;
    Response::new(row_filter.mask.len().div_ceil(row_filter.step), &|cycles| {
        let turning = TAU * cycles * rate_hz;
        let spring = Complex::new(shaft.stiffness_mnm_rad, turning * shaft.damping);
        spring / (spring - inertia * turning * turning)
    })
}
