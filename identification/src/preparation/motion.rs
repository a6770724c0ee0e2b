//! The knob's motion from encoder and accelerometer.

use std::borrow::Cow;
use std::f64::consts::TAU;

use dynamics::{Axis, Calibration, Motion};

use super::band::Band;
use super::compliance::{compliance_rad_mnm, knob_angle_rad};
use super::filter::{Fir, low_pass};
use super::fusion::{Sensors, blend};
use super::uniform::Uniform;
use crate::numerics::derivative::{GRADIENT_REACH, gradient};
use crate::numerics::statistics::{MEDIAN_FOURTH_DIFFERENCE, rms};
use crate::numerics::vector::{self, dot};
use crate::options::AccelerationUse;
use crate::samples::{FitError, Samples};

/// Noise in the acceleration's power up to which the encoder does alone: an accelerometer's limited bandwidth costs more.
const CLEAR: f64 = 1e-4;
/// The encoder's low-pass lies well clear of the band in which the fit compares: flat up to the band's edge.
const CUTOFF_PER_EDGE: f64 = 3.0;
/// Kaiser's parameter and, in periods of the cutoff, the half length that make it flat to 10⁻⁴ (80 dB) up to a third
/// of the cutoff. Its memory is finite: nothing that happens further away than that touches a sample.
const SMOOTH_BETA: f64 = 7.857;
const SMOOTH_PERIODS: f64 = 1.9;
/// Share of the filters' length that carries all but 10⁻⁴ of a step: with the whole length left out around stick,
/// no parameter of the simulated rig's knobs differs.
const EFFECTIVE: f64 = 0.4;
/// Scatter of an exact derivative column, relative to its RMS: rounding, not measurement.
const EXACT: f64 = 1e-7;

/// Angle, velocity and acceleration of the knob at every grid point, and how well they are known.
#[derive(Clone, Debug)]
pub(crate) struct KnobMotion {
    pub(crate) time_s: Vec<f64>,
    pub(crate) angle_rad: Vec<f64>,
    pub(crate) velocity_rad_s: Vec<f64>,
    pub(crate) acceleration_rad_s2: Vec<f64>,
    /// Whether velocity and acceleration are the angle's exact derivatives, without noise.
    pub(crate) exact: bool,
    /// Standard deviation of the velocity's noise, rad/s.
    pub(crate) velocity_noise_rad_s: f64,
    /// Edge of the encoder's zero-phase low-pass, Hz; half the sample rate where none was needed.
    pub(crate) cutoff_hz: f64,
    /// Samples on each side that the motion at a sample depends on.
    pub(crate) reach: usize,
    /// Whether the accelerometer took part.
    pub(crate) accelerometer: bool,
    /// White density of the encoder's noise, rad²/Hz.
    pub(crate) angle_density: f64,
    /// Twist of the torque sensor that was taken out of the angle, rad/mNm.
    pub(crate) compliance_rad_mnm: f64,
    /// White density of the accelerometer's noise, rad²/s⁴ per Hz; 0 if it took no part.
    pub(crate) accelerometer_density: f64,
    /// Time constant of the accelerometer's lag that was undone, s.
    pub(crate) lag_s: f64,
    /// Frequency from which the accelerometer has the greater share, Hz; infinite if it took no part.
    pub(crate) equal_hz: f64,
}

impl KnobMotion {
    /// Time, angle, velocity and acceleration as they are given, without noise, up to `cutoff_hz`.
    pub(crate) fn as_given(columns: [Vec<f64>; 4], cutoff_hz: f64) -> Self {
        let [time_s, angle_rad, velocity_rad_s, acceleration_rad_s2] = columns;
        Self {
            time_s,
            angle_rad,
            velocity_rad_s,
            acceleration_rad_s2,
            exact: true,
            velocity_noise_rad_s: 0.0,
            cutoff_hz,
            reach: 0,
            accelerometer: false,
            angle_density: 0.0,
            compliance_rad_mnm: 0.0,
            accelerometer_density: 0.0,
            lag_s: 0.0,
            equal_hz: f64::INFINITY,
        }
    }

    /// The given velocity and acceleration, if they are the angle's derivatives to within rounding.
    ///
    /// The columns move out of `uniform`, which is left without motion.
    pub(crate) fn exact(uniform: &mut Uniform, calibration: Option<&Calibration>) -> Option<Self> {
        let rate_hz = uniform.rate_hz;
        let velocity = uniform.velocity_rad_s.as_ref().filter(|_| compliance_rad_mnm(calibration) == 0.0)?;
        if uniform.lost > 0 || !is_exact_derivative(velocity, &uniform.angle_rad, rate_hz) {
            return None;
        }
        let accelerometer =
            uniform.acceleration_rad_s2.as_ref().is_some_and(|given| is_exact_derivative(given, velocity, rate_hz));
        let velocity_rad_s = uniform.velocity_rad_s.take()?;
        let given = uniform.acceleration_rad_s2.take().filter(|_| accelerometer);
        let acceleration_rad_s2 = given.unwrap_or_else(|| gradient(&velocity_rad_s, rate_hz));
        let (time_s, angle_rad) = (std::mem::take(&mut uniform.time_s), std::mem::take(&mut uniform.angle_rad));
        let columns = [time_s, angle_rad, velocity_rad_s, acceleration_rad_s2];
        Some(Self { accelerometer, ..Self::as_given(columns, 0.5 * rate_hz) })
    }

    /// The motion as the sensors saw it, every cutoff chosen from the signals' own spectra. Where the acceleration takes no part, the band becomes
    /// that of the encoder.
    pub(crate) fn measured(
        uniform: &Uniform,
        band: &mut Band,
        calibration: Option<&Calibration>,
        acceleration_use: AccelerationUse,
    ) -> Self {
        // A band with a clear edge is the encoder's already.
        if acceleration_use != AccelerationUse::Best
            && uniform.acceleration_rad_s2.is_some()
            && band.clear_hz.is_infinite()
        {
            *band = band.of_encoder(uniform);
        }
        let rate_hz = uniform.rate_hz;
        let cutoff_hz = (CUTOFF_PER_EDGE * band.edge_hz).min(0.3 * rate_hz);
        let angle = knob_angle_rad(&uniform.angle_rad, &uniform.torque_mnm, calibration);
        let smoother = smoother(cutoff_hz, rate_hz);
        let mut smooth = smoother.filter(&angle);
        let mut velocity = gradient(&smooth, rate_hz);
        let mut acceleration = gradient(&velocity, rate_hz);
        let noise = band.angle_density * TAU.powi(4) * band.edge_hz.powi(5) / 5.0;
        let clear = noise < CLEAR * rms(&low_pass(4, band.edge_hz, rate_hz, &acceleration)).powi(2);
        let lag_s = uniform.acceleration_lag_s;
        let may_take_part = acceleration_use == AccelerationUse::Best && !clear;
        let sensors = uniform.acceleration_rad_s2.as_ref().filter(|_| may_take_part).and_then(|acceleration| {
            let (encoder, present) = (&uniform.angle_rad, &uniform.present);
            Sensors::of(&angle, encoder, acceleration, present, lag_s, rate_hz, cutoff_hz)
        });
        if sensors.is_none() && may_take_part && uniform.acceleration_rad_s2.is_some() {
            return Self::measured(uniform, band, calibration, AccelerationUse::Encoder);
        }
        let (mut angle_density, mut accelerometer_density, mut equal_hz) = (band.angle_density, 0.0, f64::INFINITY);
        if let Some(sensors) = &sensors {
            smooth = smoother.filter(&blend(sensors));
            velocity = gradient(&smooth, rate_hz);
            acceleration = gradient(&velocity, rate_hz);
            (angle_density, accelerometer_density) = (sensors.angle_density, sensors.sensor_density);
            equal_hz = sensors.equal_hz;
        }
        Self {
            time_s: uniform.time_s.clone(),
            angle_rad: smooth,
            velocity_rad_s: velocity,
            acceleration_rad_s2: acceleration,
            exact: false,
            velocity_noise_rad_s: velocity_noise_rad_s(angle_density, cutoff_hz, equal_hz),
            cutoff_hz,
            reach: (EFFECTIVE * (smoother.half_length() + 2 * GRADIENT_REACH) as f64) as usize,
            accelerometer: sensors.is_some(),
            angle_density,
            compliance_rad_mnm: compliance_rad_mnm(calibration),
            accelerometer_density,
            lag_s,
            equal_hz,
        }
    }

    /// The low-pass that angle and torque passed.
    pub(crate) fn smoother(&self, rate_hz: f64) -> Fir {
        if self.exact { Fir::identity() } else { smoother(self.cutoff_hz, rate_hz) }
    }

    /// Share of the encoder in the acceleration at a frequency.
    pub(crate) fn encoder_share(&self, frequency_hz: f64) -> f64 {
        encoder_share(frequency_hz, self.equal_hz)
    }

    /// White density of the acceleration's noise at a frequency, as far as it is known, rad²/s⁴ per Hz; `angle_density` is
    /// that of the encoder, with all that was added to it.
    pub(crate) fn acceleration_density(&self, frequency_hz: f64, angle_density: f64) -> f64 {
        let square = (TAU * frequency_hz).powi(2);
        let encoder = self.encoder_share(frequency_hz);
        angle_density * (square * encoder).powi(2)
            + self.accelerometer_density * (1.0 - encoder).powi(2) * (1.0 + square * self.lag_s.powi(2))
    }

    /// Standard deviation of the acceleration's noise up to a frequency, as far as it is known, rad/s².
    pub(crate) fn acceleration_noise_rad_s2(&self, edge_hz: f64) -> f64 {
        if self.exact {
            return 0.0;
        }
        let [square] = integrals(edge_hz, |frequency_hz| [self.acceleration_density(frequency_hz, self.angle_density)]);
        square.sqrt()
    }

    /// A torque filtered as the motion is: ringing beyond the cutoff must not remain in only one of the two.
    pub(crate) fn alike<'a>(&self, torque_mnm: &'a [f64], rate_hz: f64) -> Cow<'a, [f64]> {
        if self.exact { torque_mnm.into() } else { self.smoother(rate_hz).filter(torque_mnm).into() }
    }

    pub(crate) fn at(&self, index: usize) -> Motion {
        Motion {
            time_s: self.time_s[index],
            angle_rad: self.angle_rad[index],
            velocity_rad_s: self.velocity_rad_s[index],
            acceleration_rad_s2: self.acceleration_rad_s2[index],
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.time_s.len()
    }
}

/// The knob's motion at every sample, prepared as [`fit`](crate::fit()) prepares it: encoder without
/// phase shift, accelerometer where it is quieter, the twist of the torque sensor taken out.
///
/// Gives one [`Motion`] per sample, in rad, rad/s and rad/s², its time in s since the first sample.
///
/// # Errors
/// [`FitError`] for samples that are not a capture of a motion.
pub fn knob_motion(
    samples: &Samples<'_>,
    axis: Axis,
    calibration: Option<&Calibration>,
) -> Result<Vec<Motion>, FitError> {
    samples.check()?;
    let mut uniform = Uniform::of(samples, axis, calibration);
    let exact = KnobMotion::exact(&mut uniform, calibration);
    let mut band = Band::of(&uniform, exact.is_some(), calibration);
    let motion = exact.unwrap_or_else(|| KnobMotion::measured(&uniform, &mut band, calibration, AccelerationUse::Best));
    // Where samples were lost, the grid has more points than the capture: each sample takes the nearest point.
    let mut point = 0;
    let nearest = samples.t_s.iter().map(|&time_s| {
        while point + 1 < motion.time_s.len()
            && (motion.time_s[point + 1] - time_s).abs() <= (motion.time_s[point] - time_s).abs()
        {
            point += 1;
        }
        // Time counts from the start of the capture, as effects that change with time require.
        Motion { time_s: time_s - samples.t_s[0], ..motion.at(point) }
    });
    Ok(nearest.collect())
}

/// Standard deviation of the velocity's noise up to `cutoff_hz`: white angle noise differentiated, of which the
/// accelerometer leaves the share 1/(1 + (f/f₀)⁴) where it takes part from `equal_hz` on.
fn velocity_noise_rad_s(angle_density: f64, cutoff_hz: f64, equal_hz: f64) -> f64 {
    let [square] =
        integrals(cutoff_hz, |frequency_hz| [(TAU * frequency_hz).powi(2) * encoder_share(frequency_hz, equal_hz)]);
    (angle_density * square).sqrt()
}

/// Share of the encoder in the acceleration at a frequency, if both sensors have the same at `equal_hz`.
fn encoder_share(frequency_hz: f64, equal_hz: f64) -> f64 {
    1.0 / (1.0 + (frequency_hz / equal_hz).powi(4))
}

/// Integrals of densities from zero to `edge_hz`.
pub(super) fn integrals<const COUNT: usize>(edge_hz: f64, densities: impl Fn(f64) -> [f64; COUNT]) -> [f64; COUNT] {
    const STEPS: u32 = 256;
    let width_hz = edge_hz / f64::from(STEPS);
    let mut sums = [0.0; COUNT];
    for step in 0..STEPS {
        let densities = densities((f64::from(step) + 0.5) * width_hz);
        sums.iter_mut().zip(densities).for_each(|(sum, density)| *sum += width_hz * density);
    }
    sums
}

/// The common low-pass of angle and torque before anything is masked.
fn smoother(cutoff_hz: f64, rate_hz: f64) -> Fir {
    Fir::kaiser_low_pass((SMOOTH_PERIODS * rate_hz / cutoff_hz).ceil() as usize, cutoff_hz, rate_hz, SMOOTH_BETA)
}

/// Whether a column is the derivative of another to within rounding: smooth, and neither early nor late.
fn is_exact_derivative(column: &[f64], of: &[f64], rate_hz: f64) -> bool {
    /// Samples that are differentiated together.
    const BLOCK: usize = 2048;
    let (length, size) = (column.len(), rms(column));
    // A motion's fourth differences are small. Where most are large, the column is noisy, so it was measured.
    let smooth = vector::small_fourth_differences(column, EXACT * size * MEDIAN_FOURTH_DIFFERENCE);
    if !(size > 0.0 && 2 * smooth > length.saturating_sub(4)) {
        return false;
    }
    let (mut lag, mut weight, mut square) = (0.0, 0.0, 0.0);
    for start in (0..length).step_by(BLOCK) {
        let end = (start + BLOCK).min(length);
        let around = start.saturating_sub(2 * GRADIENT_REACH)..(end + 2 * GRADIENT_REACH).min(length);
        let derivative = gradient(&of[around.clone()], rate_hz);
        let rate = gradient(&derivative, rate_hz);
        let inside = start.max(1)..end.min(length - 1);
        let shifted = inside.start - around.start..inside.end - around.start;
        let difference: Vec<f64> =
            column[inside].iter().zip(&derivative[shifted.clone()]).map(|(column, rate)| column - rate).collect();
        let rate = &rate[shifted];
        lag += dot(&difference, rate);
        weight += vector::square(rate);
        square += vector::square(&difference);
    }
    let difference = (square / weight.max(f64::MIN_POSITIVE)).sqrt();
    (lag / weight.max(f64::MIN_POSITIVE)).abs() < 0.01 / rate_hz && difference < 0.1 / rate_hz
}
