//! How to look for an effect in a capture whose model lacks it.

use std::f64::consts::TAU;

/// What is known of a capture and its knob before an effect is looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scene {
    /// Smallest angle of the capture, rad.
    pub lowest_rad: f64,
    /// Largest angle, rad.
    pub highest_rad: f64,
    /// Speed that half of the sliding samples exceed, rad/s.
    pub median_speed_rad_s: f64,
    /// Highest speed, rad/s.
    pub highest_speed_rad_s: f64,
    /// Length of the capture, s.
    pub duration_s: f64,
    /// Upper edge of the band in which torque is compared, Hz.
    pub band_hz: f64,
    /// Time between samples, s.
    pub sample_s: f64,
    /// Smallest change of angle that the encoder tells, rad.
    pub angle_step_rad: f64,
    /// Moment of inertia of the model so far, mNm·s²/rad.
    pub inertia: f64,
    /// RMS of the measured torque, mNm.
    pub torque_rms_mnm: f64,
    /// Period P of the detents, rad, if there are any.
    pub detent_period_rad: Option<f64>,
    /// Whether the knob turns, so that effects may repeat with each turn.
    pub is_rotary: bool,
    /// Whether the residual is close to the noise floor; a search then needs closely spaced starts.
    pub is_faint: bool,
}

impl Scene {
    /// Stiffnesses with which the knob would resonate between two frequencies, mNm/rad; `None` without inertia.
    #[must_use]
    pub fn resonant_stiffnesses(&self, lowest_hz: f64, highest_hz: f64) -> Option<(f64, f64)> {
        let stiffness = |hertz: f64| (TAU * hertz).powi(2) * self.inertia;
        (self.inertia > 0.0).then(|| (stiffness(lowest_hz), stiffness(highest_hz)))
    }

    /// Range of a coupling's damping, mNm·s/rad, from ringing to creeping: rates of 1 to 500 Hz for the inertia.
    #[must_use]
    pub fn coupling_dampings(&self) -> Option<(f64, f64)> {
        Some((TAU * 1.0 * self.inertia, TAU * 500.0 * self.inertia))
    }

    /// Angle between the two ends of the motion, rad.
    #[must_use]
    pub fn travel_rad(&self) -> f64 {
        self.highest_rad - self.lowest_rad
    }
}

/// The search for one effect.
#[derive(Clone, Copy, Debug)]
pub struct Hypothesis {
    /// The parameters that must be searched, since the torque is no linear function of them.
    pub searched: &'static [Search],
    /// Numbers of leading columns that make a smaller version of the effect, rising; empty if it comes as a whole.
    pub nested: &'static [usize],
    /// How many times the law may occur in one effect, each time with its own share of the columns and of the parameters; an
    /// occurrence whose parameters are zero does not count.
    pub lines: usize,
    /// Least part of a turn that distinguishes it from a spring, an offset or friction that rises with the angle, rad; `None` for
    /// an effect that does not repeat with each turn. One that does applies to a rotary axis only.
    pub least_turn_rad: Option<f64>,
    /// Whether the coefficients belong to the capture and not to the knob, like the phase of mains hum.
    pub per_capture: bool,
}

impl Hypothesis {
    /// The hypothesis of an effect that is linear in its parameters, occurs once and as a whole, on any axis, and belongs to the knob.
    pub const PLAIN: Self = Self { searched: &[], nested: &[], lines: 1, least_turn_rad: None, per_capture: false };
}

/// The search for one parameter.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Index of the parameter among the effect's.
    pub parameter: usize,
    /// Least and largest value that this capture could show; `None` if it can show none.
    pub range: fn(&Scene) -> Option<(f64, f64)>,
    /// Number of values tried over the range before the best are refined.
    pub starts: fn(&Scene) -> usize,
    /// Whether values are tried in equal ratios rather than at equal distances.
    pub logarithmic: bool,
    /// The end of the range at which the effect is a straight line over the capture, which it stays beyond that end: where a time constant is
    /// much longer than the capture, or the period of an inertia than the travel.
    pub straight_end: Option<RangeEnd>,
    /// Whether the effect at the least value, and below it, is Coulomb friction or none: where a speed is too low to show.
    pub is_coulomb_at_least: bool,
    /// The parameter of another effect that this one is always equal to.
    pub same_as: Option<&'static str>,
}

/// An end of a parameter's range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RangeEnd {
    /// The lower one.
    Least,
    /// The upper one.
    Largest,
}

impl Search {
    /// A search at equal distances for a parameter that is not tied to another effect; its range is still to be given.
    pub const PLAIN: Self = Self {
        parameter: 0,
        range: |_| None,
        starts: |_| 1,
        logarithmic: false,
        straight_end: None,
        is_coulomb_at_least: false,
        same_as: None,
    };

    /// Number of values to try over `widths` widths of a spectral peak: three to a width.
    #[must_use]
    pub fn starts_over(widths: f64) -> usize {
        (3.0 * widths).ceil().clamp(1.0, 4000.0) as usize
    }

    /// The range; `None` if this capture cannot show the parameter, or only one value of it.
    #[must_use]
    pub fn range_in(&self, scene: &Scene) -> Option<(f64, f64)> {
        (self.range)(scene).filter(|(least, largest)| least < largest)
    }

    /// The values to try, in rising order; none if the capture cannot show the parameter.
    #[must_use]
    pub fn values(&self, scene: &Scene) -> Vec<f64> {
        let Some((least, largest)) = self.range_in(scene) else {
            return Vec::new();
        };
        let count = (self.starts)(scene).max(1);
        let share = |index: usize| (index as f64 + 0.5) / count as f64;
        let at = |share: f64| {
            if self.logarithmic { least * (largest / least).powf(share) } else { least + (largest - least) * share }
        };
        (0..count).map(|index| at(share(index))).collect()
    }
}
