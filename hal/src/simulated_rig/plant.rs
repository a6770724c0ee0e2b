//! The plant: drive, shaft and knob, one substep at a time.

use dynamics::Model;

use super::RigParameters;
use super::cogging::{Cogging, cogging_mnm};
use super::contact::{Braked, Contact, MotorFriction};
use super::drive::Drive;
use super::inner::Cap;
use super::knob::Knob;
use super::shaft::{Shaft, Sides};

/// The plant's true state, which no sensor shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Plant time since the first reading, s.
    pub time_s: f64,
    /// Angle of motor and encoder, rad.
    pub motor_angle_rad: f64,
    /// Speed of the motor, rad/s.
    pub motor_velocity_rad_s: f64,
    /// Angle of gripper and knob; of its cap, if something gives way inside it, rad.
    pub knob_angle_rad: f64,
    /// Speed of gripper and knob, rad/s.
    pub knob_velocity_rad_s: f64,
    /// Acceleration of gripper and knob, mean over the last substep, rad/s².
    pub knob_acceleration_rad_s2: f64,
    /// Angle of what friction and detents act on, rad: the knob's, unless lost motion or a shaft lies between.
    pub inner_angle_rad: f64,
    /// Speed of what friction and detents act on, rad/s.
    pub inner_velocity_rad_s: f64,
    /// Torque through the sensor, mean over the last substep, mNm.
    pub sensor_torque_mnm: f64,
    /// Current in the winding, A.
    pub current_a: f64,
    /// Whether friction holds the knob, or its inner part, at rest.
    pub knob_stuck: bool,
}

/// Most solutions tried for one substep: each contact may change twice, to rest and on, or apart and together.
const MAX_SOLUTIONS: u32 = 8;

/// Everything that moves.
#[derive(Debug)]
pub(super) struct Plant {
    substep_s: f64,
    coulomb_mnm: f64,
    viscous: f64,
    cogging: Vec<Cogging>,
    knob: Knob,
    drive: Drive,
    shaft: Shaft,
    motor_contact: Contact,
    steps: u64,
    knob_acceleration_rad_s2: f64,
    sensor_torque_mnm: f64,
}

impl Plant {
    /// `hand_inertia` turns with the gripper beside the knob's, mNm·s²/rad.
    pub(super) fn new(parameters: &RigParameters, model: Model, hand_inertia: f64) -> Self {
        let knob = Knob::new(parameters, model);
        Self {
            substep_s: parameters.substep_s(),
            coulomb_mnm: parameters.motor_coulomb_mnm,
            viscous: parameters.motor_viscous,
            cogging: parameters.motor_cogging.clone(),
            drive: Drive::new(parameters),
            shaft: Shaft::new(parameters, knob.cap_inertia() + hand_inertia),
            motor_contact: Contact::Stuck,
            knob,
            steps: 0,
            knob_acceleration_rad_s2: 0.0,
            sensor_torque_mnm: 0.0,
        }
    }

    pub(super) fn steps(&self) -> u64 {
        self.steps
    }

    fn time_s(&self) -> f64 {
        self.steps as f64 * self.substep_s
    }

    fn cap(&self) -> Cap {
        Cap { angle_rad: self.shaft.angle_rad.load, velocity_rad_s: self.shaft.velocity_rad_s.load }
    }

    pub(super) fn truth(&self) -> Truth {
        let Shaft { angle_rad, velocity_rad_s, .. } = &self.shaft;
        let (inner_angle_rad, inner_velocity_rad_s) = self.knob.inner_motion(&self.cap());
        Truth {
            time_s: self.time_s(),
            motor_angle_rad: angle_rad.motor,
            motor_velocity_rad_s: velocity_rad_s.motor,
            knob_angle_rad: angle_rad.load,
            knob_velocity_rad_s: velocity_rad_s.load,
            knob_acceleration_rad_s2: self.knob_acceleration_rad_s2,
            inner_angle_rad,
            inner_velocity_rad_s,
            sensor_torque_mnm: self.sensor_torque_mnm,
            current_a: self.drive.current_a(),
            knob_stuck: self.knob.is_stuck(),
        }
    }

    /// One substep under the commanded motor torque (none with the amplifier off) and a hand's
    /// torque on the knob, mNm.
    pub(super) fn step(&mut self, command_mnm: Option<f64>, hand_mnm: f64) {
        let start_rad_s = self.shaft.velocity_rad_s;
        let middle_rad = self.shaft.angle_rad.motor + 0.5 * self.substep_s * start_rad_s.motor;
        let motor_mnm = self.drive.step(command_mnm, start_rad_s.motor) - cogging_mnm(&self.cogging, middle_rad);
        let motor_friction =
            MotorFriction { coulomb_mnm: self.coulomb_mnm, viscous_mnm: self.viscous * start_rad_s.motor };
        let mut motor = Braked::new(self.motor_contact, motor_friction);
        let mut load = self.knob.begin(self.time_s(), self.cap(), self.shaft.spring_mnm(), hand_mnm);

        let mut solutions = 0;
        let end_rad_s = loop {
            let onto_cap = load.onto_cap();
            let applied_mnm = Sides { motor: motor_mnm - motor.braking_mnm, load: onto_cap.applied_mnm };
            let at_rest = Sides { motor: motor.at_rest(), load: onto_cap.at_rest };
            let outcome = self.shaft.solve(applied_mnm, at_rest, onto_cap.reaction);
            let (end_rad_s, holding_mnm) = (outcome.velocity_rad_s, outcome.holding_mnm);
            let corrected =
                motor.correct(end_rad_s.motor, holding_mnm.motor) | load.correct(end_rad_s.load, holding_mnm.load);
            solutions += 1;
            if !corrected || solutions == MAX_SOLUTIONS {
                break end_rad_s;
            }
        };

        let ended = load.ended(end_rad_s.load);
        self.knob.advance(&ended);
        self.motor_contact = motor.contact.settled(end_rad_s.motor, 0.0);
        self.sensor_torque_mnm = self.shaft.advance(end_rad_s);
        self.knob_acceleration_rad_s2 = (end_rad_s.load - start_rad_s.load) / self.substep_s;
        self.steps += 1;
    }
}
