//! Waveforms of the angle against their definitions written otherwise, and tables against what a curve through drawn
//! points promises.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

mod curve;
mod files;
mod lines;
mod shapes;
mod steepness;

use dynamics::{Effect, Motion, effects};

/// Torque of an effect at an angle, mNm.
fn torque_mnm(effect: &Effect, angle_rad: f64) -> f64 {
    effect.free_torque_mnm(&Motion { angle_rad, ..Motion::default() })
}

fn effect(name: &str, values: &[f64]) -> Effect {
    Effect::new(effects::by_name(name).unwrap(), values)
}

/// Marsaglia's xorshift, evenly from 0 to 1.
fn random(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 11) as f64 / (1_u64 << 53) as f64
}

/// A drawing by chance: angles, torques and period.
fn drawing(seed: u64) -> (Vec<f64>, Vec<f64>, f64) {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let points = 3 + (random(&mut state) * 30.0) as usize;
    let mut angle_rad = vec![random(&mut state) * 20.0 - 10.0];
    for _ in 1..points {
        let gap_rad = 10.0_f64.powf(3.0 * random(&mut state) - 4.0);
        angle_rad.push(angle_rad.last().unwrap() + gap_rad);
    }
    let torque_mnm = (0..points)
        // Plateaus too: some torques are those of the point before.
        .scan(0.0, |torque, _| {
            if random(&mut state) > 0.2 {
                *torque = 40.0 * random(&mut state) - 20.0;
            }
            Some(*torque)
        })
        .collect();
    let period_rad = angle_rad.last().unwrap() - angle_rad[0] + 0.01 + 0.1 * random(&mut state);
    (angle_rad, torque_mnm, period_rad)
}
