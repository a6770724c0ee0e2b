//! A capture prepared for diagnosis: motion, torque, the rows in which they are compared, and the noise that is left in them.

mod encoder_noise;
pub(crate) mod encoder_zero;
mod floor;
pub(crate) mod mains;
pub(crate) mod periodogram;
mod rest_noise;
pub(crate) mod rows;
mod scene;

use std::borrow::Cow;
use std::f64::consts::TAU;

use dynamics::{Axis, Calibration, Motion, Scene};

use self::mains::MainsSpectrum;
use crate::diagnosis::model_fit::structure::Structure;
use crate::numerics::derivative::gradient;
use crate::numerics::statistics::noise_deviation;
use crate::numerics::vector::{self, smallest_step, square};
use crate::options::AccelerationUse;
use crate::preparation::band::Band;
use crate::preparation::filter::Fir;
use crate::preparation::motion::KnobMotion;
use crate::preparation::row_filter::RowFilter;
use crate::preparation::sensor_noise::SensorNoise;
use crate::preparation::uniform::Uniform;
use crate::quasi_static::Map;
use crate::samples::{FitError, Samples};

/// Widest upper edge of the comparison, Hz: contact and shaft show below it, a rig's own resonances lie above.
pub(crate) const EDGE_HZ: f64 = 200.0;
/// Weight of the mask from which the knob surely slides.
pub(crate) const SLIDING: f64 = 0.9;
/// The edge is at most this share of the sample rate.
const WIDEST: f64 = 0.1;
/// Skew allowed between torque and motion, in samples.
const SKEW_SAMPLES: f64 = 0.5;
/// Length of the stretches into which a capture is divided if half of them are to be held out, s.
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
    /// Half of them, in which the second is.
    Odd,
    /// The other half.
    Even,
}

impl Stretches {
    fn weight(self, stretch: usize) -> f64 {
        let kept = match self {
            Self::All => true,
            Self::Odd => is_odd(stretch),
            Self::Even => !is_odd(stretch),
        };
        f64::from(u8::from(kept))
    }
}

/// Whether a stretch is odd by the sequence of Thue and Morse: its two halves share out every period alike, whereas every other stretch of a
/// motion that repeats with two of them would be the same half of the motion.
fn is_odd(stretch: usize) -> bool {
    stretch.count_ones() % 2 == 1
}

/// A capture ready for diagnosis.
#[derive(Clone)]
pub(crate) struct Capture {
    /// Time of the first sample, s. The motion's time counts from it, so that changes with time begin with the capture.
    pub(crate) start_s: f64,
    pub(crate) rate_hz: f64,
    pub(crate) band: Band,
    pub(crate) motion: KnobMotion,
    /// The motion at every sample.
    pub(crate) motions: Vec<Motion>,
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
    /// Spectra around the mains' frequencies, if these lie above the band.
    pub(crate) mains: Option<MainsSpectrum>,
    /// Effective number of rows: each row counts by the square of its weight.
    pub(crate) weight: f64,
    angle_step_rad: f64,
    /// Whether the knob was turned too slowly for its speed to be estimated: then only effects of the angle can be named.
    pub(crate) is_map: bool,
    /// Orthonormal rows of torques that cannot test a model here, since the capture it was fitted to does not determine them.
    pub(crate) undetermined: Vec<Vec<f64>>,
    /// What is wrong with sensors and samples, a sentence each.
    pub(crate) notes: Vec<String>,
    /// The scene without a structure.
    pub(crate) scene: Scene,
}

impl Capture {
    /// Removes from rows the components along [`Self::undetermined`].
    pub(crate) fn leave_undetermined_out(&self, rows: &mut [f64]) {
        vector::take_out(&self.undetermined, rows);
    }

    /// Prepares samples that are to be compared in a band no wider than `edge_hz`.
    pub(crate) fn of(
        samples: &Samples<'_>,
        axis: Axis,
        calibration: Option<&Calibration>,
        edge_hz: f64,
        stretches: Stretches,
    ) -> Result<Self, FitError> {
        samples.check()?;
        let start_s = samples.t_s[0];
        let mut uniform = Uniform::of(samples, axis, calibration);
        uniform.time_s.iter_mut().for_each(|time_s| *time_s -= start_s);
        let rate_hz = uniform.rate_hz;
        let count = uniform.time_s.len();
        // A line would not be one where stretches are left out.
        let kept = match stretches {
            Stretches::All => 0..count,
            Stretches::Odd => 0..count / 2,
            Stretches::Even => count / 2..count,
        };
        let exact = KnobMotion::exact(&mut uniform, calibration);
        let band = Band::of(&uniform, exact.is_some(), calibration);
        let mut band = Band { edge_hz: edge_hz.min(WIDEST * rate_hz).min(band.clear_hz), ..band };
        // An exact motion has no noise that would narrow the band.
        let mains = match exact {
            Some(_) => None,
            None => MainsSpectrum::of([&uniform.torque_mnm, &uniform.angle_rad], kept, rate_hz, band.edge_hz),
        };
        let motion =
            exact.unwrap_or_else(|| KnobMotion::measured(&uniform, &mut band, calibration, AccelerationUse::Best));
        let mut row_filter = RowFilter::new(&uniform, &motion, &band);
        let length = (STRETCH_S * rate_hz).round() as usize;
        row_filter
            .mask
            .iter_mut()
            .enumerate()
            .for_each(|(index, mask)| *mask *= stretches.weight(index / length.max(1)));
        row_filter.checked()?;
        let torque = motion.alike(&uniform.torque_mnm, rate_hz).into_owned();
        let passed = row_filter.fir.taps().iter().map(|tap| tap * tap).sum::<f64>();
        let white_mnm = (uniform.torque_density * 0.5 * rate_hz * passed).sqrt();
        let resting_mnm = rest_noise::in_rows_mnm(&uniform, &motion, &row_filter, &torque);
        let weight = row_filter.weight();
        let noise = SensorNoise::of(&row_filter, &motion, &band);
        let of_steps_rad_s2 = encoder_noise::acceleration_rows_rad_s2(samples.angle_rad, &motion, &row_filter);
        let squares_of_steps = of_steps_rad_s2.as_ref().map_or(0.0, |rows| square(rows));
        let acceleration_noise_rad_s2 = (noise.acceleration_squares.max(squares_of_steps) / weight).sqrt();
        let acceleration = row_filter.rows(&motion.acceleration_rad_s2);
        let capture = Self {
            torque_noise_mnm: resting_mnm.map_or(white_mnm, |resting| resting.max(white_mnm)),
            acceleration_noise_rad_s2,
            of_steps_rad_s2,
            acceleration_noise_share: acceleration_noise_rad_s2 / (square(&acceleration) / weight).sqrt(),
            angle_step_rad: smallest_step(samples.angle_rad),
            mains,
            notes: uniform.notes,
            ..Self::without_motion_noise(band, motion, row_filter, with_derivatives(torque, rate_hz), white_mnm)
        };
        Ok(capture.since(start_s, axis))
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
            mains: None,
            weight: row_filter.weight(),
            angle_step_rad: smallest_step(&motion.angle_rad),
            motions: (0..motion.len()).map(|index| motion.at(index)).collect(),
            motion,
            row_filter,
            torque,
            is_map: false,
            undetermined: Vec::new(),
            notes: Vec::new(),
            scene: Scene::default(),
        }
    }

    /// The same with the time of its first sample, s, and with its scene measured on this axis.
    fn since(self, start_s: f64, axis: Axis) -> Self {
        let scene = Scene { is_rotary: axis.is_rotary(), ..self.measured_scene() };
        Self { start_s, scene, ..self }
    }

    /// Takes a map, torque against angle and direction, row by row as it is.
    pub(crate) fn of_map(map: Map, axis: Axis, stretches: Stretches) -> Self {
        let notes = map.faults().collect();
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
        Self { is_map: true, notes, ..capture }.since(start_s, axis)
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

    /// Rows in a second, Hz.
    pub(crate) fn row_rate_hz(&self) -> f64 {
        self.rate_hz / self.row_filter.step as f64
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
        Cow::Owned(with_derivatives(self.torque_mnm(delay_s), self.rate_hz))
    }

    /// Density of the torque channel's noise in the band, mNm²/Hz.
    pub(crate) fn torque_density(&self) -> f64 {
        self.torque_noise_mnm.powi(2) / self.band.edge_hz
    }

    /// Rows of the columns of a structure's effect.
    pub(crate) fn rows_of(&self, structure: &Structure, effect: usize) -> Vec<Vec<f64>> {
        self.row_filter.rows_of(structure.widths()[effect], structure.columns_of(effect, self))
    }

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
}

/// A signal and its first two derivatives by time.
fn with_derivatives(signal: Vec<f64>, rate_hz: f64) -> [Vec<f64>; 3] {
    let rate = gradient(&signal, rate_hz);
    let curvature = gradient(&rate, rate_hz);
    [signal, rate, curvature]
}
