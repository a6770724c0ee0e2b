//! The motion of a knob at one moment.

/// Angle, velocity, acceleration and time: all that an effect's torque can depend on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Time since the start of the capture, s.
    pub time_s: f64,
    /// Angle, rad.
    pub angle_rad: f64,
    /// Velocity, rad/s.
    pub velocity_rad_s: f64,
    /// Acceleration, rad/s².
    pub acceleration_rad_s2: f64,
}

impl Motion {
    /// Sign of the velocity; 0 at rest.
    #[must_use]
    pub fn velocity_sign(&self) -> f64 {
        if self.velocity_rad_s == 0.0 { 0.0 } else { self.velocity_rad_s.signum() }
    }
}
