//! The noise floor: what the sensors' noise leaves of a capture beside a structure.

use dynamics::Motion;
use rand_distr::{Distribution as _, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng as _;

use super::Capture;
use crate::diagnosis::model_fit::structure::Structure;
use crate::numerics::derivative::gradient;
use crate::numerics::statistics::quantile;
use crate::numerics::vector::square;

/// Most and fewest rows of a stretch whose mean square is taken: within these limits, a capture is divided into twice …
const STRETCH_ROWS: usize = 60;
const SHORT_STRETCH_ROWS: usize = 16;
/// … the fewest stretches that determine the quietest tenth.
const FEWEST_STRETCHES: usize = 8;

impl Capture {
    /// RMS of the residual that noise alone leaves beside a knob of this inertia, mNm.
    pub(crate) fn floor_mnm(&self, inertia: f64) -> f64 {
        self.torque_noise_mnm.hypot(inertia * self.acceleration_noise_rad_s2)
    }

    /// RMS of the residual that noise alone leaves beside a structure, mNm.
    pub(crate) fn floor_of_mnm(&self, structure: &Structure) -> f64 {
        // A simulated inner body is driven by the angle; only the cap's share feels the acceleration's noise.
        let gap = structure.model().coupling().filter(|coupling| coupling.half_gap_rad > 0.0);
        let Some(coupling) = gap else { return self.floor_mnm(structure.inertia()) };
        let [cap, _] = coupling.inertias(structure.inertia());
        self.floor_mnm(cap).hypot(self.driven_noise_mnm(structure))
    }

    /// RMS of the noise in a residual beside a knob of this inertia, mNm, estimated from the quietest tenth of its stretches, relative to the
    /// noise expected in each: all stretches have noise, but a wrong model errs by different amounts in different stretches.
    pub(crate) fn quiet_rms_mnm(&self, residual: &[f64], inertia: f64) -> f64 {
        let weights: Vec<f64> =
            self.row_filter.mask.iter().step_by(self.row_filter.step).map(|mask| mask * mask).collect();
        let of_torque = self.white_torque_noise_mnm.powi(2);
        let even = (of_torque + (inertia * self.acceleration_noise_rad_s2).powi(2)).max(f64::MIN_POSITIVE);
        let length = (residual.len() / (2 * FEWEST_STRETCHES)).clamp(SHORT_STRETCH_ROWS, STRETCH_ROWS);
        let expected = |stretch: usize, weight: f64| match &self.of_steps_rad_s2 {
            Some(rows) => {
                let rows = &rows[stretch * length..rows.len().min((stretch + 1) * length)];
                weight * of_torque + inertia * inertia * square(rows)
            }
            None => weight * even,
        };
        let mut ratios: Vec<f64> = residual
            .chunks(length)
            .zip(weights.chunks(length))
            .map(|(rows, weights)| (square(rows), weights.iter().sum::<f64>()))
            .enumerate()
            .filter(|(_, (_, weight))| 2.0 * weight > length as f64)
            .map(|(stretch, (square, weight))| square / expected(stretch, weight))
            .collect();
        if ratios.len() < FEWEST_STRETCHES { f64::INFINITY } else { (quantile(&mut ratios, 0.1) * even).sqrt() }
    }

    /// RMS in the rows of the error that the angle's noise causes in a simulation driven by the angle, mNm: the difference
    /// between a simulation with as much noise added to the angle and one without.
    fn driven_noise_mnm(&self, structure: &Structure) -> f64 {
        let deviation = (self.motion.angle_density * 0.5 * self.rate_hz).sqrt();
        let units = StandardNormal.sample_iter(Xoshiro256PlusPlus::seed_from_u64(1));
        let white: Vec<f64> = units.take(self.motion.len()).map(|unit: f64| deviation * unit).collect();
        let angle = self.motion.smoother(self.rate_hz).filter(&white);
        let velocity = gradient(&angle, self.rate_hz);
        let noisy: Vec<Motion> = self
            .motions
            .iter()
            .zip(angle.iter().zip(&velocity))
            .map(|(motion, (angle, velocity))| Motion {
                angle_rad: motion.angle_rad + angle,
                velocity_rad_s: motion.velocity_rad_s + velocity,
                ..*motion
            })
            .collect();
        let model = structure.model();
        let [here, there] = [&self.motions, &noisy].map(|motions| self.row_filter.rows(&model.readings_mnm(motions)));
        let difference: Vec<f64> = here.iter().zip(&there).map(|(here, there)| here - there).collect();
        (square(&difference) / self.weight).sqrt()
    }
}
