//! The simulated rig driven offline: any knob, any excitation.
#![allow(dead_code, reason = "each test file uses its part")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use dynamics::{Calibration, Drive, Excitation, Model};
use hal::Apparatus;
use hal::simulated::{RigParameters, SimulatedRig};
use identification::Samples;

pub const RATE_HZ: f64 = 10_000.0;

/// A capture's columns and what its rig says of itself.
pub struct Bench {
    pub t_s: Vec<f64>,
    pub angle_rad: Vec<f64>,
    pub acceleration_rad_s2: Vec<f64>,
    pub torque_mnm: Vec<f64>,
    /// The rig's true calibration.
    pub truth: Calibration,
}

impl Bench {
    pub fn samples(&self) -> Samples<'_> {
        Samples {
            t_s: &self.t_s,
            angle_rad: &self.angle_rad,
            velocity_rad_s: None,
            acceleration_rad_s2: Some(&self.acceleration_rad_s2),
            torque_mnm: &self.torque_mnm,
        }
    }
}

/// Drives the default rig: a position excitation by a PD servo, a torque as it is.
pub fn run(knob: &Model, sweep: &str, drive: Drive, amplitude: Option<f64>, duration_s: f64, seed: u64) -> Bench {
    let mut rig = SimulatedRig::new(RigParameters::default(), knob.clone(), seed).unwrap();
    let truth = rig.description().calibration.clone();
    let mut excitation = Excitation::named(sweep, drive).unwrap();
    if let Some(amplitude) = amplitude {
        excitation = excitation.with_amplitude(amplitude).unwrap();
    }
    let inertia = truth.motor_inertia + truth.gripper_inertia;
    rig.enable().unwrap();
    let mut bench = Bench {
        t_s: Vec::new(),
        angle_rad: Vec::new(),
        acceleration_rad_s2: Vec::new(),
        torque_mnm: Vec::new(),
        truth,
    };
    let (mut previous, mut velocity) = (0.0, 0.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few seconds")]
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
        bench.t_s.push(time_s);
        bench.angle_rad.push(measured.angle_rad);
        bench.acceleration_rad_s2.push(measured.acceleration_rad_s2);
        bench.torque_mnm.push(measured.torque_mnm);
    }
    bench
}
