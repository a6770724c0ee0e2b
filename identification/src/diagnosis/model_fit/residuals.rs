//! The residual of a structure in a capture.

use dynamics::{Model, Resolution};

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::structure::Structure;
use crate::diagnosis::model_fit::twist;

/// Structures that are simulated together.
pub(crate) const TOGETHER: usize = 3;

/// Measured minus predicted torque, in rows.
pub(crate) fn residual(structure: &Structure, capture: &Capture) -> Vec<f64> {
    residuals(&[structure], capture, Resolution::Full).remove(0)
}

/// As [`residual`], for several structures.
pub(crate) fn residuals(structures: &[&Structure], capture: &Capture, resolution: Resolution) -> Vec<Vec<f64>> {
    if structures.iter().any(|structure| twist::of(structure).is_some()) {
        let unwound = structures.iter().map(|structure| match twist::unwound(structure, capture) {
            Some((bare, behind)) => residual(&bare, &behind),
            None => residual(structure, capture),
        });
        return unwound.collect();
    }
    let first_mnm = capture.torques(0.0)[0].first().copied().unwrap_or(0.0);
    let models: Vec<Model> = structures.iter().map(|structure| structure.model()).collect();
    let readings_mnm = models.chunks(TOGETHER).flat_map(|models| match models {
        [first, second, third] => {
            Model::readings_of_mnm([first, second, third], &capture.motions, first_mnm, resolution).to_vec()
        }
        [first, second] => Model::readings_of_mnm([first, second], &capture.motions, first_mnm, resolution).to_vec(),
        others => others
            .iter()
            .flat_map(|model| Model::readings_of_mnm([model], &capture.motions, first_mnm, resolution))
            .collect(),
    });
    // Structures seldom differ in their delay: the target is computed anew only if they do.
    let mut target: Option<(f64, Vec<f64>)> = None;
    let left = |(structure, readings_mnm): (&&Structure, Vec<f64>)| {
        let delay_s = structure.delay_s();
        let at_delay = target.take().filter(|(of_s, _)| *of_s == delay_s);
        let (_, target) = target.insert(at_delay.unwrap_or_else(|| (delay_s, capture.target(delay_s))));
        let readings = capture.row_filter.rows(&readings_mnm);
        target.iter().zip(&readings).map(|(target, reading)| target - reading).collect()
    };
    structures.iter().zip(readings_mnm).map(left).collect()
}
