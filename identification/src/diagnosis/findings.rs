//! The result of a diagnosis.

use std::collections::BTreeMap;

use dynamics::Model;
use dynamics::simulate::RigMotor;
use serde::Deserialize as _;

use super::verdict::locate::Location;
use crate::regression::characteristic::CharacteristicPoint;

/// What is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Nothing: the model leaves what the sensors' noise leaves.
    None,
    /// The effects named.
    Effects,
    /// Something that no known effect explains.
    OutsideLibrary,
}

/// Where model and captures disagree, what is missing, and what adding it does.
///
/// Serialises to the JSON of `diagnose --json`, and deserialises from it except for the fields that the JSON leaves out.
/// RMS values are those of the rows: torque and model, masked where the
/// knob may stick and low-passed to [`Diagnosis::band_hz`], in mNm.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Diagnosis {
    /// What is missing.
    pub verdict: Verdict,
    /// Whether nothing else is missing: beside [`Verdict::Effects`] only if both captures are explained down to the sensors' noise, and the first
    /// model left clearly more of one.
    pub complete: bool,
    /// The effects that were added, strongest first. Beside [`Verdict::OutsideLibrary`] something else is left.
    #[serde(borrow)]
    pub effects: Vec<&'static str>,
    /// In one sentence.
    pub summary: String,
    /// RMS of what the model without further effects leaves of the training capture, mNm.
    pub train_rms_before: f64,
    /// RMS of what the final model leaves of it, mNm.
    pub train_rms_after: f64,
    /// RMS of what the model without further effects leaves of the held-out capture, mNm.
    pub heldout_rms_before: f64,
    /// RMS of what the final model leaves of it, mNm.
    pub heldout_rms_after: f64,
    /// RMS that the sensors' noise leaves of the held-out capture beside a complete model, mNm.
    pub noise_floor_rms: f64,
    /// 100 · ‖measured − model‖ / ‖measured‖ on the held-out capture, before and after.
    pub heldout_relative_error_percent: [f64; 2],
    /// RMS error of the held-out angle predicted from the measured torque, started anew every
    /// [`FORWARD_WINDOW_S`](super::FORWARD_WINDOW_S), before and after, rad; none where a model cannot be simulated forward.
    pub forward_angle_rms_rad: Option<[f64; 2]>,
    /// The same from the torque commanded from the rig's motor; none without a command, as the notes say.
    pub forward_from_command: Option<ForwardFromCommand>,
    /// What was added, in this order.
    pub steps: Vec<Step>,
    /// Torques without a name that are part of the final model: each measured over the coordinate on which it depends.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub characteristics: Vec<Characteristic>,
    /// Effects that explain part of what is outside the catalogue; not names of what is missing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub partial: Vec<Partial>,
    /// Where the model without further effects and the training capture disagree.
    #[serde(rename = "where")]
    pub locations: Vec<Location>,
    /// Where the final model and the training capture still disagree.
    pub where_after: Vec<Location>,
    /// What to capture next to tell rivals apart.
    pub next_experiment: Option<NextExperiment>,
    /// Whether the held-out samples are stretches of the training capture, which is weaker evidence.
    pub heldout_is_own: bool,
    /// Whether the capture given as held-out was trained on, and the training capture held out.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub captures_are_exchanged: bool,
    /// Upper edge of the comparison, Hz.
    pub band_hz: f64,
    /// What a reader of the numbers should know.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// The model with all that was added.
    #[serde(skip)]
    pub model: Model,
    /// Values of the model without further effects, refined on the training capture, with their intervals; empty unless a
    /// model was given to start from.
    #[serde(skip)]
    pub refined: BTreeMap<&'static str, Value>,
    /// The model without further effects, then with the effect of each step added in turn; each includes the gripper, as the sensor bears it.
    #[serde(skip)]
    pub chain: Vec<Model>,
    /// Rows of both captures for plots.
    #[serde(skip)]
    pub rows: [Vec<Row>; 2],
}

/// Share of the noise floor that the residual must reach: the fewest rows from which a floor is estimated determine it to one part in nine.
const DOUBTFUL: f64 = 0.7;

/// What is said of a noise floor that is doubtful.
pub const FLOOR_IS_DOUBTFUL: &str = "The residual is below the noise floor, so the floor is wrong: it is measured while the knob rests, \
     and more than noise acted there. Effects below that floor are not found: judge by the residual torque.";

impl Diagnosis {
    /// Whether the model leaves so little that the noise floor must have been overestimated.
    #[must_use]
    pub fn is_floor_doubtful(&self) -> bool {
        self.heldout_rms_after < DOUBTFUL * self.noise_floor_rms
    }

    /// What the effects of [`Diagnosis::partial`] are, as the heading of their list.
    #[must_use]
    pub fn partial_heading(&self) -> &'static str {
        match self.verdict {
            Verdict::OutsideLibrary => {
                "Effects that explain part of the residual, but cannot be what is missing or predict it too poorly:"
            }
            Verdict::None | Verdict::Effects => {
                "Effects that would explain part of what is left above the noise, too little or too unsteadily to be named:"
            }
        }
    }

    /// Exchanges the two values given for the training and the held-out capture if the captures were exchanged.
    pub fn in_their_roles<T>(&self, train: T, heldout: Option<T>) -> (T, Option<T>) {
        match heldout {
            Some(heldout) if self.captures_are_exchanged => (heldout, Some(train)),
            heldout => (train, heldout),
        }
    }
}

/// How well the held-out motion follows from the torque commanded from the rig's motor.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ForwardFromCommand {
    /// RMS error of the angle predicted over a window, rad: with the first model, then with each step's effect added in turn.
    pub angle_rms_rad: Vec<f64>,
    /// Time after which a prediction is started anew, s.
    pub window_s: f64,
    /// The rig's motor: inertia from the calibration, friction as the training capture shows it.
    pub motor: RigMotor,
}

impl ForwardFromCommand {
    /// The error with the first and with the final model, rad.
    #[must_use]
    pub fn before_and_after_rad(&self) -> Option<[f64; 2]> {
        Some([*self.angle_rms_rad.first()?, *self.angle_rms_rad.last()?])
    }
}

/// An effect that was added.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Step {
    /// Standard name.
    pub effect: &'static str,
    /// Its parameters in the final model; of unequal detents each has its own below.
    #[serde(borrow)]
    pub parameters: BTreeMap<&'static str, Value>,
    /// The detents one by one, where they are what differs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub detents: Vec<UnequalDetent>,
    /// RMS on the training capture before and after, mNm.
    pub train_rms_before: f64,
    /// See [`Step::train_rms_before`].
    pub train_rms_after: f64,
    /// RMS on the held-out capture before, mNm.
    pub heldout_rms_before: f64,
    /// And after, mNm.
    pub heldout_rms_after: f64,
    /// Gain in log-likelihood of both captures less the cost of the effect's freedom, nats.
    pub evidence: f64,
    /// Mean gain over the stretches of both captures, in standard errors.
    #[serde(deserialize_with = "number_or_nan")]
    pub steadiness: f64,
    /// Share of false discoveries among the effects tried in this step that predict stretches of the held-out capture as
    /// well as this one (Benjamini and Hochberg 1995).
    #[serde(deserialize_with = "number_or_nan")]
    pub false_discovery_rate: f64,
    /// RMS on the held-out capture with a null test of as many parameters: the effect's own columns at the wrong time, mNm.
    pub placebo_rms: f64,
    /// Other effects in its place, best first.
    pub rivals: Vec<Rival>,
    /// Those rivals that the captures cannot distinguish from this effect.
    pub ties: Vec<&'static str>,
}

/// A parameter of an effect that was added.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Value {
    /// Best value.
    pub value: f64,
    /// Unit.
    pub unit: &'static str,
    /// 95 % interval for correlated residuals, from the training capture; none where the data do not bound it.
    pub ci95: Option<[f64; 2]>,
}

/// One detent of a knob whose detents differ.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(bound(deserialize = "'de: 'static"))]
pub struct UnequalDetent {
    /// Angle at which the knob rests.
    pub rest: Value,
    /// Angle to the next rest.
    pub pitch: Value,
    /// Largest torque on the way to the next rest.
    pub peak: Value,
    /// Largest torque on the way to the rest before.
    pub trough: Value,
}

/// Another effect in the place of the one that was added.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Rival {
    /// Standard name.
    pub effect: &'static str,
    /// RMS that it leaves on the held-out capture, mNm.
    pub heldout_rms_after: f64,
    /// Gain in evidence, nats.
    pub evidence: f64,
    /// Posterior probability among the chosen effect and all rivals, with even prior odds.
    #[serde(deserialize_with = "number_or_nan")]
    pub probability: f64,
    /// The reason why it cannot be the missing effect, such as a parameter on its bound; `None` if it can be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub disqualified: Option<String>,
}

/// An effect that explains part of what remains.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Partial {
    /// Standard name.
    pub effect: &'static str,
    /// Share that it takes away of the mean square left of both captures above the noise, %; at most 100.
    pub explains_percent: f64,
    /// The reason why it cannot be the missing effect, such as a parameter on its bound; `None` if it can be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub disqualified: Option<String>,
}

/// A torque without a name, measured over one coordinate.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Characteristic {
    /// The effect of the model that holds it.
    pub effect: &'static str,
    /// The coordinate on which it depends.
    pub coordinate: &'static str,
    /// Points of the spline.
    pub points: Vec<CharacteristicPoint>,
    /// RMS on the training capture before and after, mNm.
    pub train_rms_before: f64,
    /// See [`Characteristic::train_rms_before`].
    pub train_rms_after: f64,
    /// RMS on the held-out capture before, mNm.
    pub heldout_rms_before: f64,
    /// And after, mNm.
    pub heldout_rms_after: f64,
    /// Share of false discoveries among the splines tried that predict stretches of the held-out capture as well.
    #[serde(deserialize_with = "number_or_nan")]
    pub false_discovery_rate: f64,
    /// RMS on the held-out capture with the same spline at the wrong time, mNm.
    pub placebo_rms: f64,
    /// The effect of the catalogue that explains most of the same rest, if any explains some.
    pub nearest: Option<&'static str>,
}

/// A capture on which rivals differ most.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct NextExperiment {
    /// Name of the excitation, as `capture --sweep` takes it.
    pub excitation: String,
    /// Its amplitude, rad.
    pub amplitude_rad: f64,
    /// The rivals.
    pub tells_apart: [String; 2],
    /// RMS of the difference of their torques, mNm.
    pub difference_rms_mnm: f64,
    /// The same in noise floors.
    pub difference_over_noise: f64,
    /// Evidence that a capture of 8 s would bring if either were true, nats.
    pub expected_evidence: f64,
    /// In one sentence.
    pub reason: String,
}

/// Reads a number from JSON, where null stands for one that is not finite.
pub(super) fn number_or_nan<'de, D: serde::Deserializer<'de>>(json: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(json)?.unwrap_or(f64::NAN))
}

/// One row of a comparison, for plots.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Row {
    /// Time, s.
    pub t_s: f64,
    /// Angle, rad.
    pub angle_rad: f64,
    /// Velocity, rad/s.
    pub velocity_rad_s: f64,
    /// Measured torque, mNm.
    pub torque_mnm: f64,
    /// Measured minus the first model's torque, mNm.
    pub residual_before_mnm: f64,
    /// Measured minus the final model's torque, mNm.
    pub residual_after_mnm: f64,
}

impl Characteristic {
    fn in_one_sentence(&self, decimals: usize) -> String {
        let nearest = self.nearest.map_or_else(String::new, |name| format!(", nearest to {name}"));
        format!(
            "; as measured over {} it is part of the model ({}{nearest}; {:.decimals$} to {:.decimals$} mNm)",
            self.coordinate, self.effect, self.heldout_rms_before, self.heldout_rms_after
        )
    }
}

impl Diagnosis {
    /// Decimals with which its torques are written: three, or as many as give the noise two digits.
    #[must_use]
    pub fn decimals(&self) -> usize {
        let is_shown = |decimals: &u8| self.noise_floor_rms * 10_f64.powi(i32::from(*decimals)) >= 10.0;
        (3..9).find(is_shown).map_or(3, usize::from)
    }

    /// The verdict as a person would say it.
    pub(crate) fn in_one_sentence(&self) -> String {
        let over_floor = self.heldout_rms_after / self.noise_floor_rms;
        let decimals = self.decimals();
        match self.verdict {
            Verdict::None => format!(
                "Nothing is missing: on held-out data the model leaves {:.decimals$} mNm, {over_floor:.2} times the noise.",
                self.heldout_rms_after
            ),
            Verdict::Effects => {
                let mut ties: Vec<&str> = self.steps.iter().flat_map(|step| step.ties.iter().copied()).collect();
                ties.sort_unstable();
                ties.dedup();
                let tie = if ties.is_empty() { String::new() } else { format!(" (or {}: a tie)", ties.join(", ")) };
                let open = if self.complete { "" } else { " That may not be all." };
                format!(
                    "Missing: {}{tie}. On held-out data the gap shrinks from {:.decimals$} to {:.decimals$} mNm, {over_floor:.2} times the \
                     noise.{open}",
                    self.effects.join(", "),
                    self.heldout_rms_before,
                    self.heldout_rms_after
                )
            }
            Verdict::OutsideLibrary => {
                let strongest = self.where_after.iter().find(|location| location.significant);
                let shape = strongest.map_or_else(String::new, |location| {
                    format!(
                        "; it goes with {} ({:.0} % of what is left)",
                        location.coordinate, location.explained_percent
                    )
                });
                let named = match self.effects.as_slice() {
                    [] => String::new(),
                    effects => format!(
                        "Added: {}; on held-out data the gap shrinks from {:.decimals$} to {:.decimals$} mNm. That is not all. ",
                        effects.join(", "),
                        self.heldout_rms_before,
                        self.heldout_rms_after
                    ),
                };
                let measured: String = self.characteristics.iter().map(|one| one.in_one_sentence(decimals)).collect();
                format!(
                    "{named}Something is missing that no known effect explains{measured}: {:.decimals$} mNm are left on held-out data, \
                     {over_floor:.1} times the noise{shape}.",
                    self.heldout_rms_after
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Rival;

    #[test]
    fn a_number_that_is_not_finite_is_read_from_what_json_makes_of_it() {
        let written = Rival {
            effect: "backlash",
            heldout_rms_after: 0.1,
            evidence: 3.0,
            probability: f64::INFINITY,
            disqualified: None,
        };
        let json = serde_json::to_string(&written).unwrap_or_default();
        let read = serde_json::from_str::<Rival>(json.leak());
        assert!(read.is_ok_and(|rival| rival.effect == "backlash" && rival.probability.is_nan()));
    }
}
