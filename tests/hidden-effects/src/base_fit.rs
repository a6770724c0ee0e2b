//! The best base model of noise-free data, by least squares: what it leaves is the size of the effect.

use nalgebra::{SMatrix, SVector};

/// One noise-free sample as the sensors would tell it: angle, velocity, acceleration, torque.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Angle, rad.
    pub angle_rad: f64,
    /// Velocity, rad/s.
    pub velocity_rad_s: f64,
    /// Acceleration, rad/s².
    pub acceleration_rad_s2: f64,
    /// Torque, mNm.
    pub torque_mnm: f64,
}

/// Below this speed the knob counts as at rest.
const SLIDING_RAD_S: f64 = 0.05;
/// This long before and after, too.
const MARGIN_S: f64 = 0.002;
/// About so many evenly spaced samples determine an RMS to one percent.
const ENOUGH_SAMPLES: usize = 8000;
const COLUMNS: usize = 7;

/// The samples that slide, away from any rest.
pub fn sliding(samples: &[Sample], rate_hz: f64) -> Vec<Sample> {
    let margin = (MARGIN_S * rate_hz).ceil() as usize;
    let mut slides = vec![true; samples.len()];
    for (index, sample) in samples.iter().enumerate() {
        if sample.velocity_rad_s.abs() < SLIDING_RAD_S {
            slides[index.saturating_sub(margin)..(index + margin + 1).min(samples.len())].fill(false);
        }
    }
    samples.iter().zip(slides).filter_map(|(sample, slides)| slides.then_some(*sample)).collect()
}

/// RMS in mNm of what the best base model leaves of these sliding samples. `period` is the true one of the knob's
/// detents, around which the best is sought; without it the model has no detents.
pub fn unexplained_rms(samples: &[Sample], period: Option<f64>) -> f64 {
    let every = (samples.len() / ENOUGH_SAMPLES).max(1);
    let samples: Vec<Sample> = samples.iter().copied().step_by(every).collect();
    let Some(period) = period else { return residual_rms(&samples, None) };
    // An effect may draw the fitted period away from the true one, by a fraction of a turn of phase over the travel.
    let mut best = (f64::INFINITY, period);
    let mut half_width = 0.02;
    for _ in 0..3 {
        let centre = best.1;
        for step in -7..=7_i32 {
            let candidate = centre * (1.0 + half_width * f64::from(step) / 7.0);
            let rms = residual_rms(&samples, Some(candidate));
            if rms < best.0 {
                best = (rms, candidate);
            }
        }
        half_width /= 6.0;
    }
    best.0
}

fn row(sample: &Sample, period: Option<f64>) -> SVector<f64, COLUMNS> {
    let v = sample.velocity_rad_s;
    let (up, down) = (f64::from(v > 0.0), f64::from(v < 0.0));
    let (sine, cosine) = period.map_or((0.0, 0.0), |period| (sample.angle_rad / period).sin_cos());
    SVector::from([sample.acceleration_rad_s2, -down, up, v * down, v * up, sine, cosine])
}

fn residual_rms(samples: &[Sample], period: Option<f64>) -> f64 {
    let mut gram = SMatrix::<f64, COLUMNS, COLUMNS>::zeros();
    let mut projection = SVector::<f64, COLUMNS>::zeros();
    let mut square = 0.0;
    for sample in samples {
        let row = row(sample, period);
        gram.syger(1.0, &row, &row, 1.0);
        projection.axpy(sample.torque_mnm, &row, 1.0);
        square += sample.torque_mnm * sample.torque_mnm;
    }
    // Coulomb friction cannot be negative: a column whose coefficient would be is left out.
    let mut left_out = [false; COLUMNS];
    loop {
        let mut reduced = gram;
        let mut side = projection;
        for column in 0..COLUMNS {
            if left_out[column] || gram[(column, column)] <= 0.0 {
                reduced.row_mut(column).fill(0.0);
                reduced.column_mut(column).fill(0.0);
                reduced[(column, column)] = 1.0;
                side[column] = 0.0;
            }
        }
        let Some(solved) = reduced.cholesky().map(|factor| factor.solve(&side)) else { return f64::NAN };
        match [1, 2].into_iter().find(|column| solved[*column] < 0.0) {
            Some(column) => left_out[column] = true,
            None => return ((square - solved.dot(&side)).max(0.0) / samples.len() as f64).sqrt(),
        }
    }
}
