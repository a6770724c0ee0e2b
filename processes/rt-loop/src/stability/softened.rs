//! How firmly a rig may hold the virtual body at a rate.

use dynamics::Calibration;
use hal::Limits;

use super::bounds::Bounds;
use crate::control::rendering::RenderGains;

/// Gains under which a rig renders, and what it renders under them.
#[derive(Clone, Copy, Debug)]
pub struct Firmness {
    /// The gains.
    pub gains: RenderGains,
    /// What can be rendered under them.
    pub bounds: Bounds,
    /// Frequencies of the coupling as a share of those of [`RenderGains::at_rate`].
    pub share: f64,
}

/// Step from one share to the next.
const STEP: f64 = 0.95;
/// Softest coupling as a share of the usual stiffness: a softer one renders another knob, and one that a hand swings more easily.
const SOFTEST: f64 = 0.1;
/// Rate whose gains are the softest that are tried, Hz: the slowest at which anything is captured.
const SOFTEST_RATE_HZ: f64 = 500.0;

/// The firmest gains of a rig at a rate under which no hand can make a sticking knob swing, nor rotor and gripper alone, where a
/// torque is `later_s` late; `None` where even the softest gains do not hold.
///
/// The torque sensor is a spring that hardly damps. Rotor and gripper resonate over it at a frequency that a heavy hand lowers, and the
/// coupling must not drive them there. A delay makes damping negative at some frequencies and not at those above, and the delay depends
/// on the rate: so a rate may need softer gains than a lower rate.
#[must_use]
pub fn gains_for(calibration: &Calibration, limits: &Limits, rate_hz: f64, later_s: f64) -> Option<Firmness> {
    let [usual, softest] = [rate_hz, SOFTEST_RATE_HZ].map(RenderGains::at_rate);
    std::iter::successors(Some(1.0), |share| Some(STEP * share))
        .take_while(|share| share * share >= SOFTEST && share * usual.damping >= softest.damping)
        .map(|share| {
            let gains = usual.slower(share).on(calibration.axis);
            Firmness { gains, bounds: Bounds::of(&gains, calibration, limits, rate_hz).delayed(later_s), share }
        })
        .find(|tried| tried.bounds.holds_rest())
}
