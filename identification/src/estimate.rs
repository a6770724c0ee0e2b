//! The result of a fit: values with intervals, or the reasons why there are none.

use serde::ser::{Serialize, Serializer};

use dynamics::{Axis, Effect, Model, Motion, ParameterKind, effects};

use crate::numerics::statistics::{half_width, mean};
use crate::regression::characteristic::MeasuredCurve;

/// A fitted parameter, or the reason why the data cannot identify it.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Parameter {
    /// Standard name, as in model files.
    #[serde(skip)]
    pub name: &'static str,
    /// Fitted value; `None` if the data cannot identify it.
    pub value: Option<f64>,
    /// Unit of value and intervals.
    pub unit: &'static str,
    /// 95 % interval that allows for autocorrelated residuals of varying size.
    pub ci95: Option<[f64; 2]>,
    /// The textbooks' 95 % interval, for independent and homoscedastic residuals; mostly too narrow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ci95_textbook: Option<[f64; 2]>,
    /// Why there is no value, in a sentence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl Parameter {
    pub(crate) fn estimated(kind: &ParameterKind, value: f64, ci95: Option<[f64; 2]>) -> Self {
        Self { name: kind.name, value: Some(value), unit: kind.unit, ci95, ci95_textbook: None, reason: None }
    }

    /// A parameter that the data cannot identify.
    pub(crate) fn not_identifiable(kind: &ParameterKind, reason: String) -> Self {
        Self { name: kind.name, value: None, unit: kind.unit, ci95: None, ci95_textbook: None, reason: Some(reason) }
    }

    /// From the value to the farther end of its 95 % interval; `None` where one of them is missing.
    #[must_use]
    pub fn half_width(&self) -> Option<f64> {
        Some(half_width(self.value?, self.ci95?))
    }
}

/// The parameters of a fit in the order of the effects; serialises as a map from name to parameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameters(pub Vec<Parameter>);

impl Parameters {
    /// The parameter called `name`.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Parameter> {
        self.0.iter().find(|parameter| parameter.name == name)
    }
}

impl Serialize for Parameters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|parameter| (parameter.name, parameter)))
    }
}

/// Covariance of a fit's parameters for residuals that are correlated and of varying size.
///
/// Parameters are left out that the data cannot identify, that are held at zero, or that were read off the capture
/// (`static_*`): their intervals are not those of a regression.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Covariance {
    /// Names of the parameters, in the order of rows and columns.
    pub order: Vec<&'static str>,
    /// The symmetric matrix, row by row, in the products of the parameters' units.
    pub rows: Vec<Vec<f64>>,
    /// Half width of a 95 % interval over the standard deviation: more than 1.96, since the covariance is itself estimated.
    /// This is Student's quantile for the harmonic mean of the parameters' degrees of freedom; each parameter's interval has its own.
    pub critical: f64,
    /// Degrees of freedom of Student's distribution with the same uncertainty: how well the variances themselves are known.
    pub degrees_of_freedom: f64,
}

/// One sinusoid of the angle.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Harmonic {
    /// Which multiple of the detent's wavenumber this one is, 1 for the detent itself; `None` if it is no multiple.
    pub order: Option<u32>,
    /// Periods per turn: the wavenumber in 1/rad. Restricted to whole numbers only where a quasi-static fit covered a turn.
    pub per_turn: f64,
    /// Amplitude, mNm.
    pub amplitude_mnm: f64,
    /// 95 % interval of the amplitude, mNm; given by quasi-static fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_ci95_mnm: Option<[f64; 2]>,
    /// Phase in amplitude·sin(per_turn·θ + phase), rad.
    pub phase_rad: f64,
    /// 95 % interval of the phase, rad; given by quasi-static fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase_ci95_rad: Option<[f64; 2]>,
    /// Share that it explains of the sum of squares which friction and the stronger sinusoids leave, %.
    pub explains_percent: f64,
    /// Relative error of the model with this and all stronger sinusoids, %; given by quasi-static fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_error_percent: Option<f64>,
}

/// One point of the comparison between capture and model, for plots.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Point {
    /// Time, s.
    pub t_s: f64,
    /// Angle, rad.
    pub angle_rad: f64,
    /// Velocity, rad/s.
    pub velocity_rad_s: f64,
    /// Acceleration, rad/s².
    pub acceleration_rad_s2: f64,
    /// Torque as measured, filtered to the fit's band, mNm.
    pub torque_mnm: f64,
    /// Torque of the fitted model, filtered alike, mNm.
    pub torque_model_mnm: f64,
    /// Half width of the 95 % interval of the model's torque, mNm.
    pub torque_model_ci95_mnm: f64,
    /// Measured minus model, mNm.
    pub residual_mnm: f64,
}

impl Point {
    /// At a motion, with the half width of the model's 95 % interval.
    pub(crate) fn of(motion: Motion, torque_mnm: f64, residual_mnm: f64, torque_model_ci95_mnm: f64) -> Self {
        let Motion { time_s: t_s, angle_rad, velocity_rad_s, acceleration_rad_s2 } = motion;
        let torque_model_mnm = torque_mnm - residual_mnm;
        Self {
            t_s,
            angle_rad,
            velocity_rad_s,
            acceleration_rad_s2,
            torque_mnm,
            torque_model_mnm,
            torque_model_ci95_mnm,
            residual_mnm,
        }
    }

    /// Its motion, as a model takes it.
    #[must_use]
    pub fn motion(&self) -> Motion {
        let Self { t_s: time_s, angle_rad, velocity_rad_s, acceleration_rad_s2, .. } = *self;
        Motion { time_s, angle_rad, velocity_rad_s, acceleration_rad_s2 }
    }
}

/// How the data were prepared: every choice that the fit made by itself.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Preparation {
    /// How the capture was prepared: `automatic`, `paper`, `central-differences`, or `quasi-static` where the knob
    /// turned too slowly for anything else.
    pub method: &'static str,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Samples that were lost in gaps, as the sample times tell.
    pub lost_samples: usize,
    /// Whether velocity and acceleration were taken as given, since they are the angle's exact derivatives.
    pub exact_motion: bool,
    /// Whether the accelerometer took part.
    pub accelerometer: bool,
    /// Edge of the zero-phase low-pass on the encoder, Hz.
    pub angle_cutoff_hz: f64,
    /// Edge of the zero-phase low-pass through which torque and all columns passed, Hz.
    pub band_hz: f64,
    /// Speed below which the knob may stick and samples are left out, rad/s.
    pub stick_threshold_rad_s: f64,
    /// Share of the samples that were compared with the model, %.
    pub sliding_percent: f64,
    /// Noise of the encoder, if white, rad.
    pub angle_noise_rad: f64,
    /// Noise of the torque channel at full rate, if white, mNm.
    pub torque_noise_mnm: f64,
}

/// A fitted model with its uncertainty.
///
/// Serialises to the JSON that `fit --json` gives. Residual, relative error and mean interval are
/// those of the `rows`: torque and model, both masked where the knob may stick, low-passed to
/// [`Preparation::band_hz`] and decimated.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Fit {
    /// The parameters with intervals or reasons.
    pub parameters: Parameters,
    /// Covariance of the parameters' errors.
    pub covariance: Covariance,
    /// RMS of measured minus model torque, mNm.
    pub residual_rms_mnm: f64,
    /// 100 · ‖measured − model‖ / ‖measured‖.
    pub relative_error_percent: f64,
    /// Mean half width of the 95 % interval of the model's torque (as `nlpredci` gives it), mNm.
    pub mean_ci95_mnm: f64,
    /// Mean half width with the textbook covariance, mNm.
    pub mean_ci95_textbook_mnm: f64,
    /// Samples of the capture.
    pub samples: usize,
    /// Rows that were compared after filtering and decimation.
    pub rows: usize,
    /// How much later than the motion the torque was seen, s; zero where the data show no difference.
    pub torque_delay_s: f64,
    /// Sinusoids of the angle, strongest first. Of a moving knob: overtones of the detents that the residual holds, which
    /// are not part of the model. Of a quasi-static map: all that it holds, the detent itself first, all in the model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub detent_harmonics: Vec<Harmonic>,
    /// Other detent periods that explain the data nearly as well, rad.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub detent_aliases_rad: Vec<f64>,
    /// How the data were prepared.
    pub preparation: Preparation,
    /// What a reader of the numbers should know.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// The comparison row by row, for plots; only where the knob slides.
    #[serde(skip)]
    pub points: Vec<Point>,
    /// Torque over the angle where it was measured point by point, the mean of both directions and half their difference.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub characteristics: Vec<MeasuredCurve>,
    /// Whether the knob turned.
    #[serde(skip_serializing_if = "Axis::is_rotary")]
    pub axis: Axis,
    /// The effects as fitted.
    #[serde(skip)]
    pub(crate) effects: Vec<Effect>,
}

impl Fit {
    /// Sets the points, their number, and the residual, relative error and mean interval over all of them.
    pub(crate) fn compared(self, points: Vec<Point>) -> Self {
        let (residual_rms_mnm, relative_error_percent) = residual_of(&points);
        Self {
            residual_rms_mnm,
            relative_error_percent,
            mean_ci95_mnm: mean(points.iter().map(|point| point.torque_model_ci95_mnm)),
            rows: points.len(),
            points,
            ..self
        }
    }

    /// The fitted model.
    ///
    /// A friction that the data did not identify in one direction is taken from the other; other
    /// parameters that could not be estimated are zero. Both are said in the description.
    #[must_use]
    pub fn model(&self, name: &str) -> Model {
        let estimated = |parameter: &str| self.parameters.get(parameter).and_then(|parameter| parameter.value);
        let mut description = format!(
            "fitted to {} samples: residual {:.3} mNm, relative error {:.2} %",
            self.samples, self.residual_rms_mnm, self.relative_error_percent
        );
        let mut model = Model { name: name.to_owned(), axis: self.axis, ..Model::default() };
        for effect in &self.effects {
            let mut effect = *effect;
            let kind = effect.kind();
            for (slot, parameter) in effect.values_mut().iter_mut().zip(kind.parameters) {
                // A stick limit without an estimate keeps its value of the fit, a bound that the capture sets; what is not among the
                // parameters, such as the scale of a curve that was measured point by point, is as it was fitted.
                let is_told = self.parameters.get(parameter.name).is_none_or(|known| known.value.is_some());
                if is_told || kind.name == effects::karnopp_stick::KIND.name {
                    continue;
                }
                let opposite =
                    opposite_direction(parameter.name).and_then(|other| estimated(&other).map(|v| (other, v)));
                *slot = opposite.as_ref().map_or(0.0, |(_, value)| *value);
                description.push_str(&match opposite {
                    Some((other, _)) => format!("; {} taken from {other}", parameter.name),
                    None => format!("; {} is not identifiable", parameter.name),
                });
            }
            if kind.name == effects::inertia::KIND.name {
                let value = estimated("inertia").unwrap_or(0.0).max(0.0);
                effect.values_mut().iter_mut().for_each(|inertia| *inertia = value);
            }
            model.effects.push(effect);
        }
        model.description = self.axis.words(&description).into_owned();
        model
    }

    /// The effects as fitted, gripper included; parameters that could not be estimated hold what the fit left there.
    #[must_use]
    pub fn effects(&self) -> &[Effect] {
        &self.effects
    }
}

/// RMS of the residual, mNm, and the relative error, %, of rows; zero for none.
pub(crate) fn residual_of<'a>(points: impl IntoIterator<Item = &'a Point>) -> (f64, f64) {
    let (mut rows, mut residual, mut torque) = (0.0_f64, 0.0, 0.0_f64);
    for point in points {
        rows += 1.0;
        residual += point.residual_mnm.powi(2);
        torque += point.torque_mnm.powi(2);
    }
    ((residual / rows.max(1.0)).sqrt(), 100.0 * (residual / torque.max(f64::MIN_POSITIVE)).sqrt())
}

fn opposite_direction(name: &str) -> Option<String> {
    name.strip_suffix("_negative")
        .map(|stem| format!("{stem}_positive"))
        .or_else(|| name.strip_suffix("_positive").map(|stem| format!("{stem}_negative")))
}
