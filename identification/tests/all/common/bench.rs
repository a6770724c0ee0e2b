//! The simulated rig driven by a plain PD servo: any knob, any excitation.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use dynamics::{Drive, Excitation, Model};
use hal::Apparatus;
use hal::simulated_rig::{RigParameters, SimulatedRig};

use super::{Capture, RATE_HZ};

/// Drives the default rig: a position excitation by a PD servo, a torque as it is.
pub fn run(knob: &Model, sweep: &str, drive: Drive, amplitude: Option<f64>, duration_s: f64, seed: u64) -> Capture {
    let mut rig = SimulatedRig::new(RigParameters::default(), knob.clone(), seed).unwrap();
    let calibration = rig.description().calibration.clone();
    let mut excitation = Excitation::named(sweep, drive).unwrap();
    if let Some(amplitude) = amplitude {
        excitation = excitation.with_amplitude(amplitude).unwrap();
    }
    let inertia = calibration.motor_inertia + calibration.gripper_inertia;
    rig.enable().unwrap();
    let mut capture = Capture { calibration: Some(calibration), ..Capture::default() };
    let mut acceleration_rad_s2 = Vec::new();
    let (mut previous, mut velocity) = (0.0, 0.0);
    let ticks = (duration_s * RATE_HZ) as u32;
    for tick in 0..ticks {
        let time_s = f64::from(tick) / RATE_HZ;
        let measured = rig.read(u64::from(tick) * 100_000).unwrap();
        let set = excitation.at(time_s);
        velocity += 0.3 * ((measured.angle_rad - previous) * RATE_HZ - velocity);
        previous = measured.angle_rad;
        rig.write_torque(match drive {
            Drive::Torque => set.value,
            Drive::Position => {
                inertia * set.acceleration + 3000.0 * (set.value - measured.angle_rad) + 20.0 * (set.rate - velocity)
            }
        })
        .unwrap();
        capture.t_s.push(time_s);
        capture.angle_rad.push(measured.angle_rad);
        acceleration_rad_s2.push(measured.acceleration_rad_s2);
        capture.torque_mnm.push(measured.torque_mnm);
    }
    Capture { acceleration_rad_s2: Some(acceleration_rad_s2), ..capture }
}
