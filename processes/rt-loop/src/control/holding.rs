//! Whether the servo holds a knob at a rate: the loop is simulated without friction, steps or noise to see whether its swings die
//! away.

use std::collections::VecDeque;

use dynamics::{Calibration, Setpoint};
use hal::{Measurement, RigDescription};

use super::servo::{Servo, ServoGains};
use crate::stability::{ACTUATOR_DELAY_S, SENSOR_DAMPING_RATIO};

/// Step in which the shaft is integrated, s: fifty to a period of a resonance at 2 kHz.
const SUBSTEP_S: f64 = 10e-6;
/// Most that the phase of a swing may advance in a substep, rad.
const RIGID_RAD_PER_SUBSTEP: f64 = 0.5;
/// Distance from the setpoint at the start, rad: so little that no limit of the servo's is reached.
const START_RAD: f64 = 1e-6;
/// Length of a stretch whose largest swing is compared with that of the next, s: several periods of the slowest swing.
const STRETCH_S: f64 = 0.5;
/// Number of stretches. The last two are compared: by then all swings but the slowest to decay have died away.
const STRETCHES: usize = 4;
/// Inertia that stands for a sticking knob, and for the heaviest knob that the gains are for, mNm·s²/rad: to the shaft both are a
/// wall.
const HEAVIEST: f64 = 2.0;
/// Steps in which a slowest rate is looked for, Hz.
const RATE_STEP_HZ: f64 = 100.0;

/// What the servo is to hold.
#[derive(Clone, Copy, Debug)]
pub struct Holding<'a> {
    /// The servo's gains.
    pub gains: ServoGains,
    /// The rig.
    pub rig: &'a RigDescription,
    /// Inertia of the knob while it turns, mNm·s²/rad; zero for the bare gripper.
    pub knob_inertia: f64,
}

impl Holding<'_> {
    /// Whether every swing dies away at this rate, while the knob turns and, unless the gripper is bare, while it sticks.
    #[must_use]
    pub fn is_stable(&self, rate_hz: f64) -> bool {
        let heaviest = HEAVIEST / self.rig.calibration.axis.fingertip_travel().powi(2);
        self.calms(self.knob_inertia, rate_hz) && (self.gains.free_gripper || self.calms(heaviest, rate_hz))
    }

    /// The slowest rate from which the servo is stable at every rate up to `fastest_hz`, with that rate's gains; `None` if there is none.
    #[must_use]
    pub fn slowest_stable_hz(&self, fastest_hz: f64, gains_at: impl Fn(f64) -> ServoGains) -> Option<f64> {
        let down = std::iter::successors(Some(fastest_hz), |rate_hz| Some(rate_hz - RATE_STEP_HZ));
        let holds = |rate_hz: f64| Self { gains: gains_at(rate_hz), ..*self }.is_stable(rate_hz);
        down.take_while(|rate_hz| *rate_hz > 0.0 && holds(*rate_hz)).last()
    }

    fn calms(&self, knob_inertia: f64, rate_hz: f64) -> bool {
        let calibration = &self.rig.calibration;
        let Some(mut servo) = Servo::new(self.gains, calibration, rate_hz) else { return false };
        let step_s = rate_hz.recip();
        let mut shaft = Shaft::new(calibration, knob_inertia);
        let mut before_rad = START_RAD;
        let late_ticks = self.rig.late_ticks(rate_hz);
        let mut under_way_mnm = VecDeque::from(vec![0.0; late_ticks as usize + 1]);
        // A command that is late by a part of a tick leaves that part to the one before.
        let before_s = late_ticks.fract() * step_s;
        let ticks = (STRETCH_S * rate_hz) as usize;
        let mut largest_rad = [0.0_f64; STRETCHES];
        for largest_rad in &mut largest_rad {
            for _ in 0..ticks {
                let angle_rad = shaft.rotor_rad;
                let torque_mnm = calibration.torque_zero_mnm + shaft.sensor_mnm();
                let measurement = Measurement { angle_rad, torque_mnm, ..Measurement::default() };
                let velocity_rad_s = (angle_rad - before_rad) / step_s;
                before_rad = angle_rad;
                let command = servo.torque_mnm(&Setpoint::default(), &measurement, velocity_rad_s, 1);
                under_way_mnm.push_back(command);
                shaft.turn(under_way_mnm.pop_front().unwrap_or_default(), before_s);
                shaft.turn(under_way_mnm.front().copied().unwrap_or_default(), step_s - before_s);
                *largest_rad = largest_rad.max(shaft.rotor_rad.abs());
            }
        }
        // A swing that overflows becomes NaN, which `max` ignores: the last angle is therefore checked too.
        let [.., before_rad, last_rad] = largest_rad;
        last_rad < before_rad && shaft.rotor_rad.is_finite()
    }
}

/// Rotor and gripper with a knob on it, joined by the torque sensor, and the motor's current.
struct Shaft {
    rotor_inertia: f64,
    gripper_inertia: f64,
    viscous: f64,
    stiffness_mnm_rad: f64,
    damping: f64,
    command_delay_s: f64,
    rotor_rad: f64,
    rotor_rad_s: f64,
    gripper_rad: f64,
    gripper_rad_s: f64,
    motor_mnm: f64,
}

impl Shaft {
    fn new(calibration: &Calibration, knob_inertia: f64) -> Self {
        let (rotor_inertia, gripper_inertia) = (calibration.motor_inertia, calibration.gripper_inertia + knob_inertia);
        // Without anything behind the torque sensor it carries nothing.
        let gripper_inertia = gripper_inertia.max(1e-3 * rotor_inertia);
        let reduced_inertia = rotor_inertia * gripper_inertia / (rotor_inertia + gripper_inertia);
        // A shaft that swings faster than the steps resolve is rigid at every rate.
        let rigid_mnm_rad = reduced_inertia * (RIGID_RAD_PER_SUBSTEP / SUBSTEP_S).powi(2);
        let stiffness_mnm_rad = calibration.torque_sensor_stiffness_mnm_rad.min(rigid_mnm_rad);
        Self {
            rotor_inertia,
            gripper_inertia,
            viscous: calibration.motor_viscous.unwrap_or(0.0),
            stiffness_mnm_rad,
            damping: 2.0 * SENSOR_DAMPING_RATIO * (stiffness_mnm_rad * reduced_inertia).sqrt(),
            command_delay_s: calibration.command_delay_s.unwrap_or(ACTUATOR_DELAY_S),
            rotor_rad: START_RAD,
            rotor_rad_s: 0.0,
            gripper_rad: START_RAD,
            gripper_rad_s: 0.0,
            motor_mnm: 0.0,
        }
    }

    fn sensor_mnm(&self) -> f64 {
        self.stiffness_mnm_rad * (self.rotor_rad - self.gripper_rad)
            + self.damping * (self.rotor_rad_s - self.gripper_rad_s)
    }

    /// Lets a tick pass under a command: semi-implicit Euler, which adds no damping of its own.
    fn turn(&mut self, command_mnm: f64, step_s: f64) {
        let substeps = (step_s / SUBSTEP_S).ceil();
        let substep_s = step_s / substeps;
        let taken_up = if self.command_delay_s > 0.0 { -(-substep_s / self.command_delay_s).exp_m1() } else { 1.0 };
        for _ in 0..substeps as u32 {
            self.motor_mnm += taken_up * (command_mnm - self.motor_mnm);
            let sensor_mnm = self.sensor_mnm();
            let accelerating_mnm = self.motor_mnm - self.viscous * self.rotor_rad_s - sensor_mnm;
            self.rotor_rad_s += substep_s / self.rotor_inertia * accelerating_mnm;
            self.gripper_rad_s += substep_s / self.gripper_inertia * sensor_mnm;
            self.rotor_rad += substep_s * self.rotor_rad_s;
            self.gripper_rad += substep_s * self.gripper_rad_s;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
    use dynamics::knobs;
    use hal::Apparatus as _;
    use hal::simulated_rig::{RigParameters, SimulatedRig};

    use super::*;

    #[test]
    fn an_angle_that_is_late_makes_the_servo_swing_as_a_torque_that_is_late_does() {
        let knob = knobs::paper_knob(3).unwrap();
        let knob_inertia = knob.inertia();
        let rig = SimulatedRig::new(RigParameters::default(), knob, 1).unwrap().description().clone();
        let gains = ServoGains::for_rig(&rig.calibration, rig.torque, 10_000.0, 0.0);
        let holds = |torque_late_ticks: f64, angle_delay_s: f64| {
            let rig = RigDescription { torque_late_ticks, angle_delay_s, ..rig.clone() };
            Holding { gains, rig: &rig, knob_inertia }.is_stable(10_000.0)
        };
        assert!(holds(0.0, 0.0));
        assert!(!holds(100.0, 0.0) && !holds(0.0, 1e-2) && !holds(0.5, 9.95e-3));
    }
}
