//! What the sensors say from tick to tick: whether it is new, whether it can be, and how fast the knob turns.

use hal::{Limits, Measurement};
use shared_types::Fault;

use super::lowpass::ButterworthLowPass;
use super::step::ControlPlan;

/// Forward jump of a rig's own clock against the ticks that no stall of a host explains, s. If the clock stands still, nothing is new.
const CLOCK_JUMP_S: f64 = 0.5;
/// Multiple of the rig's largest speed beyond which a change of the angle between two readings is a jump.
const JUMP_SPEEDS: f64 = 10.0;
/// Edge of the published velocity's filter, Hz: the paper's 10th-order Butterworth.
const VELOCITY_EDGE_HZ: f64 = 500.0;
/// Its edge at most, as a share of the rate.
const VELOCITY_EDGE_SHARE: f64 = 0.25;
/// Time over which the speed is averaged for the rig's speed limit, s: so long that neither an encoder's step nor an angle that
/// was read a fraction of a tick late looks like a runaway, and so short that no runaway gets far.
const LIMITED_SPEED_OVER_S: f64 = 2e-3;

/// The newest measurement, and the motion that measurements make.
#[derive(Clone, Debug)]
pub(super) struct Tracked {
    limits: Limits,
    rate_hz: f64,
    /// Most ticks in a row in which the sensors may bring nothing new.
    stale_limit: u32,
    previous_angle_rad: Option<f64>,
    newest: Option<Measurement>,
    /// Ticks since the newest measurement.
    unmeasured_ticks: u64,
    stale_ticks: u32,
    stale_code: i32,
    velocity_filter: ButterworthLowPass<5>,
    velocity_rad_s: f64,
    difference_rad_s: f64,
    limited_speed_rad_s: f64,
}

impl Tracked {
    /// Before the first reading; `None` when the rate is too low for the filter.
    pub(super) fn new(plan: &ControlPlan) -> Option<Self> {
        let ControlPlan { limits, rate_hz, stale_limit, .. } = *plan;
        let edge_hz = VELOCITY_EDGE_HZ.min(VELOCITY_EDGE_SHARE * rate_hz);
        Some(Self {
            limits,
            rate_hz,
            stale_limit,
            previous_angle_rad: None,
            newest: None,
            unmeasured_ticks: 0,
            stale_ticks: 0,
            stale_code: 0,
            velocity_filter: ButterworthLowPass::new(edge_hz, rate_hz)?,
            velocity_rad_s: 0.0,
            difference_rad_s: 0.0,
            limited_speed_rad_s: 0.0,
        })
    }

    /// Takes the next angle for the first one.
    pub(super) fn forget_angle(&mut self) {
        self.previous_angle_rad = None;
    }

    /// Takes the next angle for the first one, and no speed from before it.
    pub(super) fn forget_motion(&mut self) {
        self.forget_angle();
        self.limited_speed_rad_s = 0.0;
        self.velocity_filter.forget();
    }

    /// Whether this tick brought nothing new.
    pub(super) fn is_stale(&self) -> bool {
        self.stale_ticks > 0
    }

    /// Ticks up to this one without new data.
    pub(super) fn stale_ticks(&self) -> u32 {
        self.stale_ticks
    }

    /// The rig's own code for why there are no new data.
    pub(super) fn stale_code(&self) -> i32 {
        self.stale_code
    }

    /// Filtered, as published.
    pub(super) fn velocity_rad_s(&self) -> f64 {
        self.velocity_rad_s
    }

    /// The velocity as the difference of two angles: half a tick late, less than behind any filter.
    pub(super) fn difference_rad_s(&self) -> f64 {
        self.difference_rad_s
    }

    /// The mean of these differences over [`LIMITED_SPEED_OVER_S`], to which the rig's speed limit applies.
    pub(super) fn limited_speed_rad_s(&self) -> f64 {
        self.limited_speed_rad_s
    }

    /// Takes in a tick's measurement. Returns the newest one and the angle turned since the one before it, rad; `None` before the
    /// first.
    ///
    /// A measurement is new unless the rig calls it stale or its time is that of an earlier one. Where it is not, the newest is an
    /// earlier tick's, and the angle turned is 0.
    pub(super) fn take(
        &mut self,
        measurement: &Measurement,
        elapsed_ticks: u64,
    ) -> Result<Option<(Measurement, f64)>, Fault> {
        let Measurement { angle_rad, acceleration_rad_s2, torque_mnm, contact: _, after_s, is_stale, stale_code } =
            *measurement;
        let numbers = [angle_rad, acceleration_rad_s2.unwrap_or(0.0), torque_mnm, after_s];
        if !is_stale && !numbers.iter().all(|number| number.is_finite()) {
            return Err(Fault::Sensor);
        }
        self.unmeasured_ticks += elapsed_ticks;
        let before_s = self.newest.map_or(after_s, |newest| newest.after_s);
        let step_s = self.unmeasured_ticks as f64 / self.rate_hz + (after_s - before_s);
        if !is_stale && after_s - before_s > CLOCK_JUMP_S {
            return Err(Fault::Clock);
        }
        if is_stale || step_s <= 0.0 {
            self.stale_ticks = self.stale_ticks.saturating_add(1);
            self.stale_code = stale_code;
            let newest = self.newest.map(|newest| (newest, 0.0));
            return if self.stale_ticks > self.stale_limit { Err(Fault::Stale) } else { Ok(newest) };
        }
        (self.newest, self.unmeasured_ticks) = (Some(*measurement), 0);
        (self.stale_ticks, self.stale_code) = (0, 0);
        let turned_rad = angle_rad - self.previous_angle_rad.unwrap_or(angle_rad);
        let farthest_rad = self.limits.following_error_rad.max(JUMP_SPEEDS * self.limits.speed_rad_s * step_s);
        if turned_rad.abs() > farthest_rad {
            return Err(Fault::Jump);
        }
        self.previous_angle_rad = Some(angle_rad);
        let velocity_rad_s = turned_rad / step_s;
        self.velocity_rad_s = self.velocity_filter.run(velocity_rad_s);
        self.difference_rad_s = velocity_rad_s;
        self.limited_speed_rad_s +=
            (velocity_rad_s - self.limited_speed_rad_s) * -(-step_s / LIMITED_SPEED_OVER_S).exp_m1();
        Ok(Some((*measurement, turned_rad)))
    }
}
