//! Torque and angle around the mains' frequencies at the full rate: a hum may lie above the band in which models are compared.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};
use std::ops::Range;

use realfft::num_complex::Complex;

use crate::numerics::fourier;
use crate::numerics::statistics::mean;

/// Frequencies of the mains, Hz, …
const MAINS_HZ: [f64; 2] = [50.0, 60.0];
/// … and by which share a grid and the capture's clock may be off.
const OFF: f64 = 0.01;
/// Frequencies, as shares of the mains', between which no other line may be as high: a harmonic of the motion has others beside it.
const BESIDE: Range<f64> = 0.6..1.4;
/// Distance on either side within which the noise at a line is measured, Hz.
const NOISE_HZ: f64 = 4.0;
/// Distance of what is not part of a line through Hann's window, in lines.
const LOBE: f64 = 2.5;
/// Distance from the other mains' frequency within which a line is not compared with it, Hz.
const OTHER_HZ: f64 = 1.0;
/// Highest frequency, as a share of the sample rate.
const HIGHEST: f64 = 0.45;
/// By how much zeros lengthen the samples, so that a line's height hardly depends on its frequency.
const PADDING: usize = 4;
/// Standard deviation of the frequency of a line through Hann's window, times duration and root of the line's power over the noise's.
const FREQUENCY_DEVIATION: f64 = 0.487;

/// A part of the spectra of torque and angle through Hann's window.
#[derive(Clone)]
pub(crate) struct MainsSpectrum {
    spacing_hz: f64,
    /// Index of the first line.
    first: usize,
    /// Torque, mNm, and angle, rad, of each line: complex amplitude in the middle of the samples.
    lines: Vec<[Complex<f64>; 2]>,
    duration_s: f64,
    /// Time of the middle of the samples since the capture's start, s.
    middle_s: f64,
}

/// A line near the mains' frequency, U·sin(2πft + υ).
#[derive(Clone, Copy, Debug)]
pub(crate) struct MainsLine {
    /// U, f and υ: mNm, Hz and rad at the capture's start.
    pub(crate) values: [f64; 3],
    /// Their standard deviations.
    pub(crate) deviations: [f64; 3],
    /// Logarithm of the probability that noise makes a line as high at one of the frequencies looked at.
    pub(crate) ln_p_value: f64,
}

impl MainsSpectrum {
    /// Of a range of samples; `None` where all mains' frequencies lie in the band below `edge_hz`, or too near half the rate.
    pub(super) fn of(
        [torque_mnm, angle_rad]: [&[f64]; 2],
        samples: Range<usize>,
        rate_hz: f64,
        edge_hz: f64,
    ) -> Option<Self> {
        let [lowest_hz, highest_hz] = MAINS_HZ;
        if edge_hz > highest_hz || lowest_hz > HIGHEST * rate_hz {
            return None;
        }
        let count = samples.len() as f64;
        let middle = 0.5 * (count - 1.0);
        let length = PADDING * samples.len().next_power_of_two();
        let spacing_hz = rate_hz / length as f64;
        let first = (BESIDE.start * lowest_hz / spacing_hz).floor() as usize;
        let last = ((BESIDE.end * highest_hz).min(0.5 * rate_hz) / spacing_hz) as usize;
        let spectrum = |column: &[f64]| {
            let column = &column[samples.clone()];
            let mean = mean(column);
            let bins = fourier::through_hann(column.iter().map(|value| value - mean), length)?;
            // The window's sum is half the number of samples.
            let line = |index: usize| {
                let turned = Complex::from_polar(4.0 / count, TAU * index as f64 / length as f64 * middle);
                bins[index] * turned * Complex::I
            };
            Some((first..=last).map(line).collect::<Vec<_>>())
        };
        let (torque, angle) = (spectrum(torque_mnm)?, spectrum(angle_rad)?);
        let lines = torque.into_iter().zip(angle).map(|(torque, angle)| [torque, angle]).collect();
        let middle_s = (samples.start as f64 + middle) / rate_hz;
        Some(Self { spacing_hz, first, lines, duration_s: count / rate_hz, middle_s })
    }

    fn hertz(&self, index: usize) -> f64 {
        (self.first + index) as f64 * self.spacing_hz
    }

    /// The line above `edge_hz` that stands out most of the torque that inertia leaves; near `beside_hz` if that is given. `None` if another line
    /// beside it is as high.
    pub(crate) fn line(&self, inertia: f64, delay_s: f64, edge_hz: f64, beside_hz: Option<f64>) -> Option<MainsLine> {
        let hertz = |index: usize| self.hertz(index);
        let balance = |(index, [torque, angle]): (usize, &[Complex<f64>; 2])| {
            let rad_s = TAU * hertz(index);
            torque * Complex::from_polar(1.0, rad_s * delay_s) + angle * inertia * rad_s * rad_s
        };
        let amplitudes: Vec<Complex<f64>> = self.lines.iter().enumerate().map(balance).collect();
        let power = |index: usize| amplitudes[index].norm_sqr();
        let lobe_hz = LOBE / self.duration_s;
        let near = |mains_hz: f64| match beside_hz {
            Some(beside_hz) => beside_hz - lobe_hz..beside_hz + lobe_hz,
            None => mains_hz * (1.0 - OFF)..mains_hz * (1.0 + OFF),
        };
        let found = MAINS_HZ.into_iter().filter_map(|mains_hz| {
            let range_hz = near(mains_hz);
            let is_searched = |index: &usize| {
                range_hz.contains(&hertz(*index))
                    && hertz(*index) > edge_hz
                    && (hertz(*index) - mains_hz).abs() < OTHER_HZ
            };
            let inner = 1..amplitudes.len().saturating_sub(1);
            let peak = inner.filter(is_searched).max_by(|one, other| power(*one).total_cmp(&power(*other)))?;
            let away_hz = |index: &usize| (hertz(*index) - hertz(peak)).abs();
            let is_other = |index: &usize| {
                let hertz = hertz(*index);
                away_hz(index) > lobe_hz
                    && MAINS_HZ.iter().all(|at_hz| at_hz == &mains_hz || (at_hz - hertz).abs() > OTHER_HZ)
            };
            let others = (0..amplitudes.len()).filter(is_other);
            let beside = BESIDE.start * mains_hz..BESIDE.end * mains_hz;
            // The noise of an angle grows with the square of the frequency, and must not hide what lies below.
            let height = |index: usize| power(index) * (hertz(peak) / hertz(index)).powi(4).min(1.0);
            let is_highest = others.clone().all(|index| !beside.contains(&hertz(index)) || height(index) < power(peak));
            let noise: Vec<f64> = others.filter(|index| away_hz(index) < NOISE_HZ).map(power).collect();
            let noises = noise.len() as f64 * self.spacing_hz * self.duration_s;
            let ratio = power(peak) / mean(&noise);
            let trials = ((range_hz.end - range_hz.start) * self.duration_s).max(1.0);
            (is_highest && ratio.is_finite() && noises >= 2.0)
                .then(|| (trials.ln() - noises * (ratio / noises).ln_1p(), peak, ratio))
        });
        let (ln_p_value, peak, ratio) = found.min_by(|one, other| one.0.total_cmp(&other.0))?;
        Some(self.measured(&amplitudes, peak, ratio, ln_p_value))
    }

    /// The line at a peak of the amplitudes whose power is `ratio` times the noise's.
    fn measured(&self, amplitudes: &[Complex<f64>], peak: usize, ratio: f64, ln_p_value: f64) -> MainsLine {
        // A parabola through the logarithms of three lines.
        let [before, at, after] = [peak - 1, peak, peak + 1].map(|index| amplitudes[index].norm_sqr().ln());
        let offset = 0.5 * (before - after) / (before - 2.0 * at + after);
        let frequency_hz = self.hertz(peak) + offset * self.spacing_hz;
        let amplitude_mnm = (0.5 * (at - 0.25 * (before - after) * offset)).exp();
        let phase_rad = (amplitudes[peak].arg() - TAU * frequency_hz * self.middle_s).rem_euclid(TAU);
        let root = ratio.sqrt();
        let frequency_deviation_hz = FREQUENCY_DEVIATION / (self.duration_s * root);
        let relative = FRAC_1_SQRT_2 / root;
        let phase_deviation_rad = relative.hypot(TAU * self.middle_s * frequency_deviation_hz);
        MainsLine {
            values: [amplitude_mnm, frequency_hz, phase_rad],
            deviations: [relative * amplitude_mnm, frequency_deviation_hz, phase_deviation_rad],
            ln_p_value,
        }
    }
}
