//! The angle at which phases of detents are compared.
//!
//! θ/P + S turns about the angle around which a capture lies, and S, the phase at angle zero, follows P wherever that
//! is elsewhere. So phases are compared and combined at the mean angle of all captures, on the circle, and taken back
//! to angle zero with the combined period.

use super::observation::Observation;
use super::position;
use super::scalar::wrapped;
use crate::estimate::Fit;
use crate::uncertainty::statistics::mean;

pub(super) const PHASE: &str = "detent_phase";
pub(super) const PERIOD: &str = "detent_period";

/// Mean angle of all captures, rad.
pub(super) fn common_angle_rad(fits: &[Fit]) -> f64 {
    mean(fits.iter().map(|fit| mean(fit.points.iter().map(|point| point.angle_rad))))
}

/// Takes every capture's phase from angle zero to `angle_rad`, all on the same turn of the circle.
pub(super) fn to_angle(observations: &mut [Observation], angle_rad: f64) {
    let (mut sine, mut cosine) = (0.0, 0.0);
    for observation in observations.iter_mut() {
        let Some((phase, weight)) = observation.move_phase(angle_rad) else { continue };
        sine += weight * phase.sin();
        cosine += weight * phase.cos();
    }
    let centre_rad = sine.atan2(cosine);
    for observation in observations {
        let Some(at) = position(&observation.names, PHASE) else { continue };
        observation.values[at] = centre_rad + wrapped(observation.values[at] - centre_rad);
    }
}

/// Takes a phase at `angle_rad` to angle zero, within half a turn of it.
pub(super) fn back_to_zero(mean: &mut Observation, angle_rad: f64) {
    mean.move_phase(-angle_rad);
    if let Some(at) = position(&mean.names, PHASE) {
        mean.values[at] = wrapped(mean.values[at]);
    }
}
