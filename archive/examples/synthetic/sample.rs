//! Samples as a rig has them, without a rig: a slow sweep, detents, sensor noise and quantised sensors.

use shared_types::Sample;

/// Sample rate of the run that they might be of, Hz.
pub const RATE_HZ: f64 = 10_000.0;

/// The sample with this `seq`; `random` is the state of the noise, never 0.
pub fn sample(seq: u64, random: &mut u64) -> Sample {
    let mut noise = || {
        *random ^= *random << 13;
        *random ^= *random >> 7;
        *random ^= *random << 17;
        *random as f64 / u64::MAX as f64 - 0.5
    };
    let quantised = |value: f64, step: f64| (value / step).round() * step;
    let time = seq as f64 / RATE_HZ;
    let angle = (0.01 * time * time).sin() * 3.0;
    let velocity = 0.06 * time * (0.01 * time * time).cos();
    Sample {
        seq,
        tick: seq,
        monotonic_time_ns: 1_000_000_000 + seq * 100_000,
        lateness_ns: 60 + (noise() * 40.0 + 20.0) as u64,
        angle_rad: quantised(angle, 9.8e-6),
        velocity_rad_s: velocity + noise() * 1e-3,
        acceleration_rad_s2: quantised(noise() * 6.0, 2.8),
        torque_mnm: quantised((angle * 20.0).sin() * 8.0 + noise() * 0.5, 0.18),
        contact: f64::NAN,
        commanded_angle_rad: angle,
        commanded_torque_mnm: velocity * 3.0 + noise(),
        sensor_read_ns: 800 + (noise() * 100.0 + 50.0) as u32,
        control_ns: 300 + (noise() * 40.0 + 20.0) as u32,
        push_ns: 60 + (noise() * 20.0 + 10.0) as u32,
        state: 2,
        ..Sample::default()
    }
}
