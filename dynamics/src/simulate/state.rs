//! The state that a simulation starts from.

use crate::{Model, Motion};

/// All that a knob remembers, at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Time, s.
    pub time_s: f64,
    /// Angle of what the torque acts on, rad.
    pub angle_rad: f64,
    /// Its velocity, rad/s.
    pub velocity_rad_s: f64,
    /// Deflection of friction's bristles from −1 to 1, each end meaning that they slip; see [`crate::Bristles`].
    pub deflection: f64,
    /// Angle of what friction and detents act on, rad; the same as `angle_rad` in a knob of one body.
    pub inner_angle_rad: f64,
    /// Its velocity, rad/s; the same as `velocity_rad_s` in a knob of one body.
    pub inner_velocity_rad_s: f64,
}

impl State {
    /// At rest at an angle at time zero: shaft untwisted, gap entered half way, bristles unbent.
    #[must_use]
    pub fn at_rest(angle_rad: f64) -> Self {
        Self { angle_rad, inner_angle_rad: angle_rad, ..Self::default() }
    }

    /// In steady sliding as `motion` has it: bristles fully bent, the inner body as fast as the cap and behind it by
    /// what carries its friction. At zero velocity it is at rest.
    #[must_use]
    pub fn sliding(model: &Model, motion: &Motion) -> Self {
        let Motion { time_s, angle_rad, velocity_rad_s, acceleration_rad_s2 } = *motion;
        let direction = if velocity_rad_s == 0.0 { 0.0 } else { velocity_rad_s.signum() };
        let behind_rad = model.coupling().map_or(0.0, |coupling| {
            let [cap_inertia, _] = coupling.inertias(model.inertia());
            let torque_mnm = model.torque_mnm(motion) - cap_inertia * acceleration_rad_s2;
            torque_mnm / coupling.stiffness_mnm_rad
                + if torque_mnm == 0.0 { 0.0 } else { torque_mnm.signum() * coupling.half_gap_rad }
        });
        Self {
            time_s,
            angle_rad,
            velocity_rad_s,
            deflection: direction,
            inner_angle_rad: angle_rad - behind_rad,
            inner_velocity_rad_s: velocity_rad_s,
        }
    }
}
