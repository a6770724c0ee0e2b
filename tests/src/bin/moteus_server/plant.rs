//! What the motor turns: a rotor with a knob, carried on by the clock.

use std::f64::consts::TAU;

/// Longest step, s.
const SUBSTEP_S: f64 = 10e-6;

/// Rotor and knob on one shaft; mNm, rad, s.
pub struct Plant {
    pub rotor_inertia: f64,
    pub knob_inertia: f64,
    pub coulomb_mnm: f64,
    pub viscous: f64,
    pub detent_mnm: f64,
    pub detents_per_turn: f64,
    pub angle_rad: f64,
    pub velocity_rad_s: f64,
    acceleration_rad_s2: f64,
    pub motor_mnm: f64,
    /// How far it has been carried on, s.
    time_s: f64,
}

impl Plant {
    /// At rest.
    pub fn new() -> Self {
        Self {
            rotor_inertia: 0.02,
            knob_inertia: 0.06,
            coulomb_mnm: 3.0,
            viscous: 0.25,
            detent_mnm: 4.0,
            detents_per_turn: 24.0,
            angle_rad: 0.0,
            velocity_rad_s: 0.0,
            acceleration_rad_s2: 0.0,
            motor_mnm: 0.0,
            time_s: 0.0,
        }
    }

    /// Carries it on to a time, s.
    pub fn turn_to(&mut self, time_s: f64) {
        while self.time_s < time_s {
            let step_s = SUBSTEP_S.min(time_s - self.time_s).max(1e-9);
            self.step(step_s);
            self.time_s += step_s;
        }
    }

    /// Kicked by the smooth torques, braked by Coulomb friction that never reverses it.
    fn step(&mut self, step_s: f64) {
        let inertia = self.rotor_inertia + self.knob_inertia;
        let before = self.velocity_rad_s;
        let smooth_mnm =
            self.motor_mnm - self.viscous * before - self.detent_mnm * (self.detents_per_turn * self.angle_rad).sin();
        let kicked = before + step_s * smooth_mnm / inertia;
        let brake = step_s * self.coulomb_mnm / inertia;
        self.velocity_rad_s = if kicked.abs() <= brake { 0.0 } else { kicked - brake.copysign(kicked) };
        self.angle_rad += 0.5 * step_s * (before + self.velocity_rad_s);
        self.acceleration_rad_s2 = (self.velocity_rad_s - before) / step_s;
    }

    /// Torque between rotor and knob, mNm.
    pub fn sensor_mnm(&self) -> f64 {
        self.motor_mnm - self.rotor_inertia * self.acceleration_rad_s2
    }

    /// Revolutions.
    pub fn position(&self) -> f64 {
        self.angle_rad / TAU
    }
}
