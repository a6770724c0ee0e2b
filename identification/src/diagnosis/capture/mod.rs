//! A capture prepared for diagnosis: motion, torque, the rows in which they are compared, and the noise that is left in them.

mod encoder_noise;
pub(crate) mod encoder_zero;
pub(crate) mod periodogram;
mod rest_noise;
pub(crate) mod rows;

use std::borrow::Cow;
use std::f64::consts::TAU;

use dynamics::{Axis, Calibration, Motion, Scene};
use rand_distr::{Distribution as _, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng as _;

use crate::diagnosis::model_fit::structure::Structure;
use crate::numerics::derivative::gradient;
use crate::numerics::vector::{self, dot, smallest_step};
use crate::options::AccelerationUse;
use crate::preparation::band::Band;
use crate::preparation::filter::Fir;
use crate::preparation::motion::KnobMotion;
use crate::preparation::row_filter::RowFilter;
use crate::preparation::sensor_noise::SensorNoise;
use crate::preparation::uniform::Uniform;
use crate::quasi_static::Map;
use crate::samples::{FitError, Samples, span};
use crate::uncertainty::statistics::{noise_deviation, quantile, rms};

/// Widest upper edge of the comparison, Hz: contact and shaft show below it, a rig's own resonances lie above.
pub(crate) const EDGE_HZ: f64 = 200.0;
/// Weight of the mask from which the knob surely slides.
pub(crate) const SLIDING: f64 = 0.9;
/// The edge is at most this share of the sample rate.
const WIDEST: f64 = 0.1;
/// Skew allowed between torque and motion, in samples.
const SKEW_SAMPLES: f64 = 0.5;
/// Most and fewest rows of a stretch whose mean square is taken: within these limits, a capture is divided into twice …
const STRETCH_ROWS: usize = 60;
const SHORT_STRETCH_ROWS: usize = 16;
/// … the fewest stretches that determine the quietest tenth.
const FEWEST_STRETCHES: usize = 8;

/// Length of the stretches into which a capture is divided if every other one is to be held out, s.
const STRETCH_S: f64 = 0.5;
/// Stretches into which a map is divided.
const MAP_STRETCHES: usize = 32;
/// Most periods per turn that a map is searched for: of slots times poles, few motors have more.
const MAP_PER_TURN: f64 = 256.0;

/// Which stretches of a capture take part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stretches {
    /// All.
    All,
    /// Every other one, beginning with the second.
    Odd,
    /// Every other one, beginning with the first.
    Even,
}

impl Stretches {
    fn weight(self, stretch: usize) -> f64 {
        let kept = match self {
            Self::All => true,
            Self::Odd => !stretch.is_multiple_of(2),
            Self::Even => stretch.is_multiple_of(2),
        };
        f64::from(u8::from(kept))
    }
}

/// A capture ready for diagnosis.
#[derive(Clone)]
pub(crate) struct Capture {
    /// Time of the first sample, s. The motion's time counts from it, so that changes with time begin with the capture.
    pub(crate) start_s: f64,
    pub(crate) rate_hz: f64,
    pub(crate) band: Band,
    pub(crate) motion: KnobMotion,
    motions: Vec<Motion>,
    pub(crate) row_filter: RowFilter,
    /// Torque filtered as the motion is, mNm, and its first two derivatives by time.
    torque: [Vec<f64>; 3],
    /// RMS in the rows of the torque channel's noise, mNm.
    torque_noise_mnm: f64,
    /// RMS in the rows of the torque channel's noise, mNm, if it is white with the density at the upper end of its spectrum.
    white_torque_noise_mnm: f64,
    /// RMS in the rows of the acceleration's noise, rad/s².
    acceleration_noise_rad_s2: f64,
    /// RMS of the acceleration's noise as a share of the acceleration's RMS.
    pub(crate) acceleration_noise_share: f64,
    /// Rows of the acceleration error that the encoder's steps cause, rad/s²; `None` where there is no such error.
    of_steps_rad_s2: Option<Vec<f64>>,
    /// Effective number of rows: each row counts by the square of its weight.
    pub(crate) weight: f64,
    angle_step_rad: f64,
    /// Whether the knob was turned too slowly for its speed to be estimated: then only effects of the angle can be named.
    pub(crate) is_map: bool,
    /// Orthonormal rows of torques that cannot test a model here, since the capture it was fitted to does not determine them.
    pub(crate) undetermined: Vec<Vec<f64>>,
    scene: Scene,
}

impl Capture {
    /// Removes from rows the components along [`Self::undetermined`].
    pub(crate) fn leave_undetermined_out(&self, rows: &mut [f64]) {
        vector::take_out(&self.undetermined, rows);
    }

    /// Prepares samples that are to be compared in a band no wider than `edge_hz`.
    pub(crate) fn of(
        samples: &Samples<'_>,
        calibration: Option<&Calibration>,
        edge_hz: f64,
        stretches: Stretches,
    ) -> Result<Self, FitError> {
        samples.check()?;
        let start_s = samples.t_s[0];
        let mut uniform = Uniform::of(samples, calibration);
        uniform.time_s.iter_mut().for_each(|time_s| *time_s -= start_s);
        let rate_hz = uniform.rate_hz;
        let exact = KnobMotion::exact(&mut uniform, calibration);
        let band = Band::of(&uniform, exact.is_some(), calibration);
        let band = Band { edge_hz: edge_hz.min(WIDEST * rate_hz).min(band.clear_hz), ..band };
        let motion = exact.unwrap_or_else(|| KnobMotion::measured(&uniform, &band, calibration, AccelerationUse::Best));
        let mut row_filter = RowFilter::new(&uniform, &motion, &band);
        let length = (STRETCH_S * rate_hz).round() as usize;
        row_filter
            .mask
            .iter_mut()
            .enumerate()
            .for_each(|(index, mask)| *mask *= stretches.weight(index / length.max(1)));
        row_filter.checked()?;
        let torque = motion.alike(&uniform.torque_mnm, rate_hz).into_owned();
        let rate = gradient(&torque, rate_hz);
        let curvature = gradient(&rate, rate_hz);
        let passed = row_filter.fir.taps().iter().map(|tap| tap * tap).sum::<f64>();
        let white_mnm = (uniform.torque_density * 0.5 * rate_hz * passed).sqrt();
        let resting_mnm = rest_noise::in_rows_mnm(&uniform, &motion, &row_filter, &torque);
        let weight = row_filter.weight();
        let noise = SensorNoise::of(&row_filter, &motion, &band);
        let of_steps_rad_s2 = encoder_noise::acceleration_rows_rad_s2(samples.angle_rad, &motion, &row_filter);
        let squares_of_steps = of_steps_rad_s2.as_ref().map_or(0.0, |rows| dot(rows, rows));
        let acceleration_noise_rad_s2 = (noise.acceleration_squares.max(squares_of_steps) / weight).sqrt();
        let acceleration = row_filter.rows(&motion.acceleration_rad_s2);
        let capture = Self {
            torque_noise_mnm: resting_mnm.map_or(white_mnm, |resting| resting.max(white_mnm)),
            acceleration_noise_rad_s2,
            of_steps_rad_s2,
            acceleration_noise_share: acceleration_noise_rad_s2 / (dot(&acceleration, &acceleration) / weight).sqrt(),
            angle_step_rad: smallest_step(samples.angle_rad),
            ..Self::without_motion_noise(band, motion, row_filter, [torque, rate, curvature], white_mnm)
        };
        Ok(capture.since(start_s))
    }

    /// A capture whose motion has no noise and whose torque has white noise of this RMS in the rows, mNm; not yet with a scene.
    fn without_motion_noise(
        band: Band,
        motion: KnobMotion,
        row_filter: RowFilter,
        torque: [Vec<f64>; 3],
        torque_noise_mnm: f64,
    ) -> Self {
        Self {
            start_s: 0.0,
            rate_hz: row_filter.rate_hz,
            band,
            torque_noise_mnm,
            white_torque_noise_mnm: torque_noise_mnm,
            acceleration_noise_rad_s2: 0.0,
            of_steps_rad_s2: None,
            acceleration_noise_share: 0.0,
            weight: row_filter.weight(),
            angle_step_rad: smallest_step(&motion.angle_rad),
            motions: (0..motion.len()).map(|index| motion.at(index)).collect(),
            motion,
            row_filter,
            torque,
            is_map: false,
            undetermined: Vec::new(),
            scene: Scene::default(),
        }
    }

    /// The same with the time of its first sample, s, and with its scene measured.
    fn since(self, start_s: f64) -> Self {
        Self { start_s, scene: self.measured_scene(), ..self }
    }

    /// Takes a map, torque against angle and direction, row by row as it is.
    pub(crate) fn of_map(map: Map, stretches: Stretches) -> Self {
        let Map { mut motion, torque_mnm, .. } = map;
        let (count, start_s) = (motion.len(), motion.time_s[0]);
        motion.time_s.iter_mut().for_each(|time_s| *time_s -= start_s);
        let rate_hz = 2.0 * motion.cutoff_hz;
        let length = count.div_ceil(MAP_STRETCHES).max(1);
        let mask = (0..count).map(|row| stretches.weight(row / length)).collect();
        let row_filter =
            RowFilter { rate_hz, mask, fir: Fir::identity(), step: 1, threshold_rad_s: 0.0, response: None };
        let torque_noise_mnm = noise_deviation(&torque_mnm);
        // All rows are compared as they are; the edge is the frequency of the finest torque of the angle that is looked for.
        let speed_rad_s = motion.velocity_rad_s.first().map_or(0.0, |velocity| velocity.abs());
        let edge_hz = (MAP_PER_TURN * speed_rad_s / TAU).min(0.5 * rate_hz);
        let band = Band::fixed(edge_hz, torque_noise_mnm);
        let torque = [torque_mnm, vec![0.0; count], vec![0.0; count]];
        let capture = Self::without_motion_noise(band, motion, row_filter, torque, torque_noise_mnm);
        Self { is_map: true, ..capture }.since(start_s)
    }

    /// The same of an axis.
    pub(crate) fn on(mut self, axis: Axis) -> Self {
        self.scene.is_rotary = axis.is_rotary();
        self
    }

    /// The capture without the rows beyond the angles of another capture; `None` if there are no such rows, or too few others.
    pub(crate) fn within(&self, other: &Self) -> Option<Self> {
        let range = other.scene.lowest_rad..=other.scene.highest_rad;
        let mut within = self.clone();
        within.row_filter.mask.iter_mut().zip(&self.motion.angle_rad).for_each(|(mask, angle_rad)| {
            if !range.contains(angle_rad) {
                *mask = 0.0;
            }
        });
        if within.row_filter.sliding() == self.row_filter.sliding() || within.row_filter.checked().is_err() {
            return None;
        }
        if let Some(rows) = &mut within.of_steps_rad_s2 {
            let masks = within.row_filter.mask.iter().step_by(within.row_filter.step);
            rows.iter_mut().zip(masks).filter(|(_, mask)| **mask == 0.0).for_each(|(row, _)| *row = 0.0);
        }
        within.weight = within.row_filter.weight();
        within.scene = within.measured_scene();
        Some(within)
    }

    /// Skew allowed between torque and motion, s: clocks and conversions differ by less.
    pub(crate) fn largest_skew_s(&self) -> f64 {
        SKEW_SAMPLES / self.rate_hz
    }

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
                weight * of_torque + inertia * inertia * dot(rows, rows)
            }
            None => weight * even,
        };
        let mut ratios: Vec<f64> = residual
            .chunks(length)
            .zip(weights.chunks(length))
            .map(|(rows, weights)| (dot(rows, rows), weights.iter().sum::<f64>()))
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
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let white: Vec<f64> = (0..self.motion.len())
            .map(|_| {
                let unit: f64 = StandardNormal.sample(&mut random);
                deviation * unit
            })
            .collect();
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
        (dot(&difference, &difference) / self.weight).sqrt()
    }

    /// Rows in a second, Hz.
    pub(crate) fn row_rate_hz(&self) -> f64 {
        self.rate_hz / self.row_filter.step as f64
    }

    /// The motion at every sample.
    pub(crate) fn motions(&self) -> &[Motion] {
        &self.motions
    }

    /// The same torque beside another motion.
    pub(crate) fn with_motion(&self, motion: KnobMotion) -> Self {
        Self { motions: (0..motion.len()).map(|index| motion.at(index)).collect(), motion, ..self.clone() }
    }

    /// The torque as it would have been read `delay_s` earlier, filtered as the motion is, mNm, and its first two derivatives by time.
    pub(crate) fn torques(&self, delay_s: f64) -> Cow<'_, [Vec<f64>; 3]> {
        if delay_s == 0.0 {
            return Cow::Borrowed(&self.torque);
        }
        let torque = self.torque_mnm(delay_s);
        let rate = gradient(&torque, self.rate_hz);
        let curvature = gradient(&rate, self.rate_hz);
        Cow::Owned([torque, rate, curvature])
    }

    /// Density of the torque channel's noise in the band, mNm²/Hz.
    pub(crate) fn torque_density(&self) -> f64 {
        self.torque_noise_mnm.powi(2) / self.band.edge_hz
    }

    /// Rows of the columns of a structure's effect.
    pub(crate) fn rows_of(&self, structure: &Structure, effect: usize) -> Vec<Vec<f64>> {
        structure.rows(effect, &self.motion, &self.row_filter)
    }

    /// Number of rows.
    pub(crate) fn row_count(&self) -> usize {
        self.motion.len().div_ceil(self.row_filter.step)
    }

    /// Rows of the torque as it would have been read `delay_s` earlier.
    pub(crate) fn target(&self, delay_s: f64) -> Vec<f64> {
        self.row_filter.rows(&self.torque_mnm(delay_s))
    }

    /// The torque as it would have been read `delay_s` earlier, mNm.
    pub(crate) fn torque_mnm(&self, delay_s: f64) -> Vec<f64> {
        let whole = (delay_s * self.rate_hz).round();
        let rest_s = delay_s - whole / self.rate_hz;
        let last = self.motion.len() as isize - 1;
        (0..=last)
            .map(|index| {
                let at = (index + whole as isize).clamp(0, last) as usize;
                let [torque, rate, curvature] = &self.torque;
                torque[at] + rest_s * (rate[at] + 0.5 * rest_s * curvature[at])
            })
            .collect()
    }

    /// Time of every row, s, with the motion there and the weight of the mask.
    pub(crate) fn row_motions(&self) -> Vec<(Motion, f64)> {
        (0..self.motion.len())
            .step_by(self.row_filter.step)
            .map(|index| (self.motion.at(index), self.row_filter.mask[index]))
            .collect()
    }

    /// What is known of capture and knob before an effect is looked for.
    pub(crate) fn scene_of(&self, structure: &Structure) -> Scene {
        Scene { inertia: structure.inertia(), detent_period_rad: structure.parameter("detent_period"), ..self.scene }
    }

    /// What is known of the capture alone.
    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The same, from the motion where the knob slides.
    fn measured_scene(&self) -> Scene {
        let sliding: Vec<usize> = (0..self.motion.len()).filter(|index| self.row_filter.mask[*index] > 0.0).collect();
        let angles: Vec<f64> = sliding.iter().map(|index| self.motion.angle_rad[*index]).collect();
        let mut speeds: Vec<f64> = sliding.iter().map(|index| self.motion.velocity_rad_s[*index].abs()).collect();
        let lowest_rad = angles.iter().copied().fold(f64::INFINITY, f64::min);
        Scene {
            lowest_rad,
            highest_rad: lowest_rad + span(&angles),
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
