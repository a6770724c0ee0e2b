//! Rotor and knob on one shaft, as numbers: Coulomb and viscous friction, and detents.

use crate::rotary_plant::{COULOMB_MNM, DETENT_MNM, DETENTS_PER_TURN, KNOB_INERTIA, ROTOR_INERTIA, VISCOUS};

/// Longest step, s.
const STEP_S: f64 = 10e-6;
/// Most time that is made up at once, s: who was stopped for longer goes on from there.
const LONGEST_S: f64 = 0.5;

/// The plant; mNm, rad, s.
#[derive(Clone, Debug)]
pub struct Plant {
    pub angle_rad: f64,
    pub velocity_rad_s: f64,
    pub acceleration_rad_s2: f64,
    /// What the motor makes of what it is told.
    pub motor_mnm: f64,
    /// Between rotor and knob.
    pub sensor_mnm: f64,
    /// Whether nothing but an inertia is on the gripper.
    is_bare: bool,
    at_ns: u64,
    random: u64,
}

impl Plant {
    pub fn at_rest(now_ns: u64, is_bare: bool) -> Self {
        Self {
            angle_rad: 0.0,
            velocity_rad_s: 0.0,
            acceleration_rad_s2: 0.0,
            motor_mnm: 0.0,
            sensor_mnm: 0.0,
            is_bare,
            at_ns: now_ns,
            random: now_ns,
        }
    }

    /// Lets it turn until `now_ns`; time does not go back.
    pub fn turn_to(&mut self, now_ns: u64) {
        let mut left_s = (now_ns.saturating_sub(self.at_ns) as f64 * 1e-9).min(LONGEST_S);
        self.at_ns = self.at_ns.max(now_ns);
        while left_s > 0.0 {
            let step_s = left_s.min(STEP_S);
            self.step(step_s);
            left_s -= step_s;
        }
    }

    /// Kicks by the smooth torques, brakes by Coulomb friction without ever turning round, then drifts. The
    /// sensors see the acceleration at the end of the step.
    fn step(&mut self, step_s: f64) {
        let inertia = ROTOR_INERTIA + KNOB_INERTIA;
        let before = self.velocity_rad_s;
        let [amplitude_mnm, viscous, coulomb_mnm] =
            if self.is_bare { [0.0; 3] } else { [DETENT_MNM, VISCOUS, COULOMB_MNM] };
        let detent_mnm = |angle_rad: f64| amplitude_mnm * (DETENTS_PER_TURN * angle_rad).sin();
        let kicked = before + step_s * (self.motor_mnm - viscous * before - detent_mnm(self.angle_rad)) / inertia;
        let brake = step_s * coulomb_mnm / inertia;
        self.velocity_rad_s = if kicked.abs() <= brake { 0.0 } else { kicked - brake.copysign(kicked) };
        self.angle_rad += 0.5 * step_s * (before + self.velocity_rad_s);
        let free_mnm = self.motor_mnm - viscous * self.velocity_rad_s - detent_mnm(self.angle_rad);
        let friction_mnm = if self.velocity_rad_s == 0.0 {
            free_mnm.clamp(-coulomb_mnm, coulomb_mnm)
        } else {
            coulomb_mnm.copysign(self.velocity_rad_s)
        };
        self.acceleration_rad_s2 = (free_mnm - friction_mnm) / inertia;
        self.sensor_mnm = self.motor_mnm - ROTOR_INERTIA * self.acceleration_rad_s2;
    }

    /// Noise of unit variance.
    pub fn noise(&mut self) -> f64 {
        let mut uniform = || {
            self.random = self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.random >> 11) as f64 / 9_007_199_254_740_992.0
        };
        let (radius, turn) = (1.0 - uniform(), uniform());
        (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * turn).cos()
    }
}
