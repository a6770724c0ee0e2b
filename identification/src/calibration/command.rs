//! How late the motor's torque follows its command, from a sweep without a knob.
//!
//! What of a command is the motor's own share acts the delay later, so that a slow command shows to second order
//!
//! ```text
//! command − sensor = J·(θ̈ + D·θ⃛) ± C + B·θ̇
//! ```
//!
//! D is the ratio of the two coefficients. Where the motor turns around, its friction changes over earlier in the command by the
//! same delay, which has a column of its own.

use dynamics::Calibration;

use super::estimate::Estimate;
use super::friction::acting_mnm;
use super::regression::Band;
use crate::Samples;
use crate::motion::gradient;
use crate::uniform::{Uniform, advance};

/// Band of the comparison, Hz: above a sweep, below where the encoder gets noisy.
const EDGE_HZ: f64 = 40.0;
/// Longest delay that is believed, s.
const LONGEST_DELAY_S: f64 = 2e-3;
/// Share of what the motor takes that may be something else.
const UNEXPLAINED: f64 = 0.2;

/// The delay `command_delay_s`, the holding of a command over a tick apart; `None` where the capture does not tell it.
///
/// Takes the torque channel's zero and delay, and cogging, from `known`.
pub(super) fn delay(samples: &Samples<'_>, commanded_mnm: &[f64], known: &Calibration) -> Option<Estimate> {
    let acting_mnm: Vec<f64> = (0..commanded_mnm.len()).map(|index| acting_mnm(commanded_mnm, index)).collect();
    let plain = Samples { acceleration_rad_s2: None, velocity_rad_s: None, ..*samples };
    let command = Uniform::of(&Samples { torque_mnm: &acting_mnm, ..plain }, None);
    let sensor = Uniform::of(&plain, None);
    let rate_hz = sensor.rate_hz;
    let prompt_mnm = advance(&sensor.torque_mnm, known.torque_delay_s * rate_hz);
    let cogging = known.motor_cogging.as_deref().unwrap_or_default();
    let taken_mnm: Vec<f64> = command
        .torque_mnm
        .iter()
        .zip(&prompt_mnm)
        .zip(&sensor.angle_rad)
        .map(|((command_mnm, sensor_mnm), angle_rad)| {
            let cogging_mnm: f64 = cogging.iter().map(|harmonic| harmonic.at_mnm(*angle_rad)).sum();
            command_mnm - (sensor_mnm - known.torque_zero_mnm) - cogging_mnm
        })
        .collect();
    let band = Band { edge_hz: EDGE_HZ.min(0.2 * rate_hz), rate_hz };
    let angle_rad = band.smooth(&sensor.angle_rad);
    let velocity = gradient(&angle_rad, rate_hz);
    let acceleration = gradient(&velocity, rate_hz);
    let jerk = gradient(&acceleration, rate_hz);
    let direction = band.smooth(&velocity.iter().map(|velocity| velocity.signum()).collect::<Vec<f64>>());
    let turning = gradient(&direction, rate_hz);
    let constant = vec![1.0; angle_rad.len()];
    let columns = [acceleration, jerk, direction, turning, velocity, constant];
    let solved = band.solve(&columns, &band.smooth(&taken_mnm));
    let [inertia, late] = [0, 1].map(|index| solved.coefficients[index]);
    let value = late / inertia;
    let half_width = solved.half_width(&[-late / (inertia * inertia), 1.0 / inertia, 0.0, 0.0, 0.0, 0.0]);
    let told = solved.unexplained < UNEXPLAINED && value.abs() < LONGEST_DELAY_S && half_width < LONGEST_DELAY_S;
    told.then_some(Estimate { quantity: "command_delay_s", value, half_width, unit: "s" })
}
