//! The plant: drive, shaft and knob, one substep at a time.

use dynamics::{Model, Motion};

use super::RigParameters;
use super::contact::{Braked, Contact, Friction, KnobFriction, MotorFriction};
use super::drive::Drive;
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
    /// Angle of knob and gripper, rad.
    pub knob_angle_rad: f64,
    /// Speed of the knob, rad/s.
    pub knob_velocity_rad_s: f64,
    /// Acceleration of the knob, mean over the last substep, rad/s².
    pub knob_acceleration_rad_s2: f64,
    /// Torque through the sensor, mean over the last substep, mNm.
    pub sensor_torque_mnm: f64,
    /// Current in the winding, A.
    pub current_a: f64,
    /// Whether the knob is stuck.
    pub knob_stuck: bool,
}

/// Most solutions tried for one substep: each side's contact may change twice, to rest and on.
const MAX_SOLUTIONS: u32 = 6;

/// Everything that moves.
#[derive(Debug)]
pub(super) struct Plant {
    substep_s: f64,
    coulomb_mnm: f64,
    viscous: f64,
    coast_speed_rad_s: f64,
    stick_velocity_rad_s: f64,
    knob: Model,
    drive: Drive,
    shaft: Shaft,
    contact: Sides<Contact>,
    steps: u64,
    knob_acceleration_rad_s2: f64,
    sensor_torque_mnm: f64,
}

impl Plant {
    pub(super) fn new(parameters: &RigParameters, knob: Model) -> Self {
        Self {
            substep_s: parameters.substep_s(),
            coulomb_mnm: parameters.motor_coulomb_mnm,
            viscous: parameters.motor_viscous,
            coast_speed_rad_s: parameters.speed_limit_rad_s,
            stick_velocity_rad_s: knob.stick_limits(&Motion::default()).velocity_rad_s,
            drive: Drive::new(parameters),
            shaft: Shaft::new(parameters, knob.inertia()),
            contact: Sides { motor: Contact::Stuck, load: Contact::Stuck },
            knob,
            steps: 0,
            knob_acceleration_rad_s2: 0.0,
            sensor_torque_mnm: 0.0,
        }
    }

    pub(super) fn steps(&self) -> u64 {
        self.steps
    }

    #[allow(clippy::cast_precision_loss, reason = "2^53 substeps of 10 µs are 2800 years")]
    fn time_s(&self) -> f64 {
        self.steps as f64 * self.substep_s
    }

    pub(super) fn truth(&self) -> Truth {
        let Shaft { angle_rad, velocity_rad_s, .. } = &self.shaft;
        Truth {
            time_s: self.time_s(),
            motor_angle_rad: angle_rad.motor,
            motor_velocity_rad_s: velocity_rad_s.motor,
            knob_angle_rad: angle_rad.load,
            knob_velocity_rad_s: velocity_rad_s.load,
            knob_acceleration_rad_s2: self.knob_acceleration_rad_s2,
            sensor_torque_mnm: self.sensor_torque_mnm,
            current_a: self.drive.current_a(),
            knob_stuck: self.contact.load == Contact::Stuck,
        }
    }

    /// One substep under the commanded motor torque (none with the amplifier off) and a hand's
    /// torque on the knob, mNm.
    pub(super) fn step(&mut self, command_mnm: Option<f64>, hand_mnm: f64) {
        let start_rad_s = self.shaft.velocity_rad_s;
        let motor_mnm = self.drive.step(command_mnm, start_rad_s.motor);
        let motion = self.middle_of_substep();
        let driving_mnm = hand_mnm - self.knob.free_torque_mnm(&motion);
        let motor_friction =
            MotorFriction { coulomb_mnm: self.coulomb_mnm, viscous_mnm: self.viscous * start_rad_s.motor };
        let knob_friction = KnobFriction { knob: &self.knob, motion, coast_speed_rad_s: self.coast_speed_rad_s };
        let mut motor = Braked::new(self.contact.motor, motor_friction);
        let mut load = Braked::new(self.contact.load, knob_friction);
        if let Some(braking_mnm) = self.coming_to_rest_mnm(driving_mnm, &load.friction) {
            load.braking_mnm = braking_mnm;
        }

        let mut solutions = 0;
        let end_rad_s = loop {
            let applied_mnm = Sides { motor: motor_mnm - motor.braking_mnm, load: driving_mnm - load.braking_mnm };
            let outcome = self.shaft.solve(applied_mnm, Sides { motor: motor.at_rest(), load: load.at_rest() });
            let (end_rad_s, holding_mnm) = (outcome.velocity_rad_s, outcome.holding_mnm);
            let corrected =
                motor.correct(end_rad_s.motor, holding_mnm.motor) | load.correct(end_rad_s.load, holding_mnm.load);
            solutions += 1;
            if !corrected || solutions == MAX_SOLUTIONS {
                break end_rad_s;
            }
        };

        self.contact = Sides {
            motor: motor.contact.settled(end_rad_s.motor, 0.0),
            load: load.contact.settled(end_rad_s.load, self.stick_velocity_rad_s),
        };
        self.sensor_torque_mnm = self.shaft.advance(end_rad_s);
        self.knob_acceleration_rad_s2 = (end_rad_s.load - start_rad_s.load) / self.substep_s;
        self.steps += 1;
    }

    /// The knob's motion in the middle of the substep to come, as far as it can be told beforehand.
    fn middle_of_substep(&self) -> Motion {
        let half_s = self.substep_s / 2.0;
        let velocity_rad_s = self.shaft.velocity_rad_s.load;
        Motion {
            time_s: self.time_s() + half_s,
            angle_rad: self.shaft.angle_rad.load + half_s * velocity_rad_s,
            velocity_rad_s: velocity_rad_s + half_s * self.knob_acceleration_rad_s2,
            acceleration_rad_s2: self.knob_acceleration_rad_s2,
        }
    }

    /// Karnopp's rule: a knob that has become slower than its stick velocity, and that its static
    /// friction can hold, is brought to rest by that friction.
    fn coming_to_rest_mnm(&self, driving_mnm: f64, friction: &KnobFriction<'_>) -> Option<f64> {
        let Contact::Sliding(direction) = self.contact.load else { return None };
        if self.shaft.velocity_rad_s.load.abs() >= self.stick_velocity_rad_s {
            return None;
        }
        let limits = friction.limits();
        let holding_mnm = self.shaft.spring_mnm() + driving_mnm;
        let holds = (-limits.negative_mnm..=limits.positive_mnm).contains(&holding_mnm);
        holds.then(|| match direction {
            dynamics::Direction::Negative => -limits.negative_mnm,
            dynamics::Direction::Positive => limits.positive_mnm,
        })
    }
}
