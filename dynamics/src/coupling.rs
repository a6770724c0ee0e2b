//! Two bodies in one knob: a cap that the sensor turns and an inner body that friction and detents act on.

/// The coupling that joins the cap to the inner body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// Half of the angle in which the bodies do not touch, rad; zero for a shaft that merely twists.
    pub half_gap_rad: f64,
    /// Share of the knob's inertia that is inside.
    pub inner_share: f64,
    /// Stiffness of shaft or contact, mNm/rad.
    pub stiffness_mnm_rad: f64,
    /// Damping of shaft or contact, mNm·s/rad.
    pub damping: f64,
}

impl Coupling {
    /// Inertia of the cap and of the inner body of a knob with this inertia.
    #[must_use]
    pub fn inertias(&self, inertia: f64) -> [f64; 2] {
        [1.0 - self.inner_share, self.inner_share].map(|share| share * inertia)
    }

    /// Torque that the cap passes on to the inner body, `ahead_rad` in front of it and faster by `faster_rad_s`.
    #[must_use]
    pub fn torque_mnm(&self, ahead_rad: f64, faster_rad_s: f64) -> f64 {
        let beyond_rad = ahead_rad - ahead_rad.clamp(-self.half_gap_rad, self.half_gap_rad);
        if beyond_rad == 0.0 && self.half_gap_rad > 0.0 {
            return 0.0;
        }
        let torque_mnm = self.stiffness_mnm_rad * beyond_rad + self.damping * faster_rad_s;
        // A contact pushes and does not pull.
        if self.half_gap_rad > 0.0 && torque_mnm * beyond_rad < 0.0 { 0.0 } else { torque_mnm }
    }
}
