//! The fit of a shaft that twists, in a capture as it would be behind the shaft.
//!
//! The measured torque tells the twist of a shaft of known stiffness and damping at once, without simulating anything:
//! behind it everything is linear again, and the sum of squares has one wide valley over stiffness where a simulated
//! resonance has many narrow ones. The torque's noise above the resonance, which this makes louder, is turned down by
//! the shaft's own response.

use std::f64::consts::TAU;

use dynamics::{Coupling, Effect, EffectKind, Part};
use rayon::prelude::*;
use realfft::num_complex::Complex;

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::separable::Separable;
use crate::diagnosis::model_fit::structure::Structure;
use crate::diagnosis::model_fit::unequal;
use crate::numerics::derivative::gradient;
use crate::numerics::fourier::Response;
use crate::numerics::lag::lagged;
use crate::preparation::motion::KnobMotion;

/// Ratios by which a shaft's values are changed at first and at last.
const COARSEST: f64 = 1.5;
const FINEST: f64 = 1.02;
/// How often a shaft's values and all others are fitted in turn.
const TWISTS: usize = 2;
/// Log-likelihood that the best start of a shaft must promise, nats.
const PROMISES: f64 = 1.0;

/// The best values of a shaft and of everything else, found without simulation, since the measured torque gives the twist; `None`
/// if a stiff shaft explains about as much.
pub(crate) fn fitted(effects: &[Effect], base: &Structure, train: &Capture) -> Option<Structure> {
    let mut stiff = base.clone();
    let starts: Vec<(f64, Effect)> =
        effects.par_iter().map(|effect| Some((squares(effect, base, train)?, *effect))).collect::<Option<_>>()?;
    let (least, mut best) = starts.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
    if 0.5 * train.weight * (Separable::new(base.clone(), train).squares() / least).ln() < PROMISES {
        return None;
    }
    for _ in 0..TWISTS {
        best = best_shaft(best, &stiff, train)?;
        // Behind a shaft of these values the motion is not the cap's, so everything else is fitted again.
        let capture = behind(&shaft(&best)?, &stiff, train);
        stiff = unequal::settled(stiff, &capture).structure;
    }
    Some(stiff.with(best, 0))
}

/// A structure with all effects but its shaft fitted behind the shaft; a structure without a shaft that twists is returned as it is.
pub(crate) fn settled(structure: Structure, train: &Capture) -> Structure {
    let Some(((index, effect), (bare, behind))) = of(&structure).zip(unwound(&structure, train)) else {
        return structure;
    };
    unequal::settled(bare, &behind).structure.with_at(index, effect, 0)
}

/// Whether a coupling is a shaft, whose bodies do not lose touch.
pub(crate) fn is_shaft(kind: &'static EffectKind) -> bool {
    shaft(&Effect::new(kind, &[1.0; dynamics::MAX_PARAMETERS])).is_some()
}

/// The coupling that an effect makes, if bodies do not lose touch in it.
fn shaft(effect: &Effect) -> Option<Coupling> {
    match effect.kind().part {
        Part::Coupling(coupling) => Some(coupling(effect.values())).filter(|coupling| coupling.half_gap_rad == 0.0),
        _ => None,
    }
}

/// Whether a structure's last effect is a shaft with more than critical damping. It does not resonate, and in the band it is like a filter or a
/// delay of the torque.
pub(crate) fn is_overdamped(structure: &Structure) -> bool {
    let shaft = structure.effects.last().and_then(shaft);
    shaft.is_some_and(|shaft| {
        let [_, inner] = shaft.inertias(structure.inertia());
        shaft.damping > 2.0 * (shaft.stiffness_mnm_rad * inner).sqrt()
    })
}

/// Sum of squares of the residual that a structure leaves behind a shaft, mNm²; `None` if `effect` is no shaft.
fn squares(effect: &Effect, base: &Structure, train: &Capture) -> Option<f64> {
    let shaft = shaft(effect)?;
    let capture = behind(&shaft, base, train);
    Some(Separable::new(base.clone(), &capture).squares())
}

/// The shaft with which a structure leaves the smallest residual, found by changing one value after the other in ever smaller
/// steps.
fn best_shaft(mut best: Effect, base: &Structure, train: &Capture) -> Option<Effect> {
    let mut least = squares(&best, base, train)?;
    let scene = train.scene_of(base);
    let mut ratio = COARSEST;
    while ratio > FINEST {
        let mut moved = false;
        for search in best.free_searches(0).collect::<Vec<_>>() {
            let (lowest, highest) = search.range_in(&scene)?;
            let at = |factor: f64| {
                let mut tried = best;
                let value = &mut tried.values_mut()[search.parameter];
                let moved =
                    if search.logarithmic { *value * factor } else { *value + factor.ln() * (highest - lowest) };
                *value = moved.clamp(lowest, highest);
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

/// Index of a structure's shaft that twists, and the shaft; `None` if the body behind it is simulated.
pub(crate) fn of(structure: &Structure) -> Option<(usize, Effect)> {
    if structure.shaft_is_simulated {
        return None;
    }
    structure.effects.iter().copied().enumerate().find(|(_, effect)| shaft(effect).is_some())
}

/// A structure without its shaft that twists, and a capture as it would be behind this shaft; `None` if the structure has no such shaft.
pub(crate) fn unwound(structure: &Structure, capture: &Capture) -> Option<(Structure, Capture)> {
    let (index, effect) = of(structure)?;
    let bare = structure.without(index);
    let capture = behind(&shaft(&effect)?, &bare, capture);
    Some((bare, capture))
}

/// The capture of a knob as it would be with the motion of the shaft's other end, its inertias at both ends taken together.
fn behind(shaft: &Coupling, knob: &Structure, capture: &Capture) -> Capture {
    let [outer, _] = shaft.inertias(knob.inertia());
    let mut behind = capture.with_motion(motion(shaft, outer, knob.delay_s(), capture));
    behind.row_filter.response = Some(response(shaft, knob.inertia(), capture));
    behind
}

/// The motion of the body behind the shaft, if the torque channel is late by `delay_s` and the inertia `outer` is in front of it; the acceleration
/// is the mean over both inertias.
fn motion(shaft: &Coupling, outer: f64, delay_s: f64, capture: &Capture) -> KnobMotion {
    let mut motion = capture.motion.clone();
    let mut torques = capture.torques(delay_s);
    if outer > 0.0 {
        let mut acceleration = capture.motion.acceleration_rad_s2.clone();
        for torque in torques.to_mut() {
            torque.iter_mut().zip(&acceleration).for_each(|(torque, acceleration)| *torque -= outer * acceleration);
            acceleration = gradient(&acceleration, capture.rate_hz);
        }
    }
    let sides = [
        (&mut motion.angle_rad, 1.0),
        (&mut motion.velocity_rad_s, 1.0),
        (&mut motion.acceleration_rad_s2, shaft.inner_share),
    ];
    // The torque acts on a spring parallel to a damper, so the twist lags behind it. The torque is interpolated linearly between samples: if it
    // were held, it would act half a sample off, and its noise would seem smaller behind a shaft than it is.
    let lag = shaft.damping * capture.rate_hz / shaft.stiffness_mnm_rad;
    for ((values, share), torque) in sides.into_iter().zip(torques.iter()) {
        let twists_mnm = lagged(torque, lag);
        values.iter_mut().zip(twists_mnm).for_each(|(value, mnm)| *value -= share * mnm / shaft.stiffness_mnm_rad);
    }
    motion
}

/// Frequency response of the rows behind a shaft: torque at the sensor over torque on the inner inertia, scaled so that the noise of both
/// sensors has the same power as without the shaft. The angle's noise acts through the effective inertia of both bodies at the sensor.
fn response(shaft: &Coupling, inertia: f64, capture: &Capture) -> Response {
    let row_filter = &capture.row_filter;
    let rate_hz = capture.row_rate_hz();
    let [outer, inner] = shaft.inertias(inertia);
    let of_torque = capture.torque_density();
    Response::new(row_filter.mask.len().div_ceil(row_filter.step), &|cycles| {
        let frequency_hz = cycles * rate_hz;
        let turning = TAU * frequency_hz;
        let spring = Complex::new(shaft.stiffness_mnm_rad, turning * shaft.damping);
        let torque = spring / (spring - inner * turning * turning);
        let felt = torque * (outer + inner * (1.0 - outer * turning * turning / spring));
        let of_angle = capture.motion.acceleration_density(frequency_hz, capture.motion.angle_density);
        let without = of_torque + inertia * inertia * of_angle;
        let noise_power = if without > 0.0 { (of_torque + felt.norm_sqr() * of_angle) / without } else { 1.0 };
        torque / noise_power.sqrt()
    })
}
