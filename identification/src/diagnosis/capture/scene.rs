//! The scene of a capture: travel, speeds and band, which bound what it could show.

use dynamics::Scene;

use super::Capture;
use crate::diagnosis::model_fit::structure::Structure;
use crate::numerics::statistics::{quantile, rms};
use crate::numerics::vector;

impl Capture {
    /// The scene beside a structure, whose inertia and detents also bound an effect.
    pub(crate) fn scene_of(&self, structure: &Structure) -> Scene {
        Scene { inertia: structure.inertia(), detent_period_rad: structure.parameter("detent_period"), ..self.scene }
    }

    /// The scene from the motion in which the knob slides.
    pub(super) fn measured_scene(&self) -> Scene {
        let mask = &self.row_filter.mask;
        let sliding = self.motion.velocity_rad_s.iter().zip(mask).filter(|(_, mask)| **mask > 0.0);
        let mut speeds: Vec<f64> = sliding.map(|(velocity, _)| velocity.abs()).collect();
        let extent = vector::extent_where(&self.motion.angle_rad, mask);
        let (lowest_rad, highest_rad) = extent.unwrap_or((f64::INFINITY, f64::INFINITY));
        Scene {
            lowest_rad,
            highest_rad,
            highest_speed_rad_s: speeds.iter().copied().fold(0.0, f64::max),
            median_speed_rad_s: quantile(&mut speeds, 0.5),
            duration_s: self.motion.time_s.last().copied().unwrap_or(0.0) - self.motion.time_s[0],
            band_hz: self.band.edge_hz,
            sample_s: 1.0 / self.rate_hz,
            angle_step_rad: self.angle_step_rad,
            torque_rms_mnm: rms(&self.torque[0]),
            is_rotary: self.scene.is_rotary,
            ..Scene::default()
        }
    }
}
