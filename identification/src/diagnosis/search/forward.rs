//! The motion that a model predicts from the measured torque.

use dynamics::simulate;

use crate::diagnosis::model_fit::structure::Structure;
use crate::diagnosis::search::Search;
use crate::diagnosis::search::acceptance::is_near_the_floor;
use crate::diagnosis::search::judged::Judged;

/// Time over which motion is predicted from torque before it is started anew, s.
pub const FORWARD_WINDOW_S: f64 = 0.1;
/// Share by which a coupling near the noise floor may worsen the predicted motion.
const WORSE: f64 = 0.2;

impl Search<'_> {
    /// Error of the held-out motion predicted from the torque, rad, with the first and with the last model.
    pub(crate) fn forward_angle_rms_rad(&self, first: &Structure, last: &Structure) -> Option<[f64; 2]> {
        let predicted = |structure: &Structure| {
            if self.train.is_map {
                return None;
            }
            let readings_mnm = self.heldout.torque_mnm(structure.skew_s);
            let (model, motions) = (structure.model(), &self.heldout.motions);
            let errors = simulate::forward_windows(&model, motions, &readings_mnm, FORWARD_WINDOW_S).ok()?;
            errors.angle_rms_rad.is_finite().then_some(errors.angle_rms_rad)
        };
        let (first, last) = rayon::join(|| predicted(first), || predicted(last));
        Some([first?, last?])
    }

    /// Whether a coupling that explains hardly more than noise predicts the motion clearly worse than the model without it: it then stands for
    /// something else in the torque, such as jitter or a hum above the band.
    pub(crate) fn moves_worse(&self, before: &Judged, after: &Judged) -> bool {
        let is_faint_coupling =
            after.structure.is_coupled() && !before.structure.is_coupled() && is_near_the_floor(before);
        is_faint_coupling
            && self
                .forward_angle_rms_rad(&before.structure, &after.structure)
                .is_some_and(|[before, after]| after > (1.0 + WORSE) * before)
    }
}
