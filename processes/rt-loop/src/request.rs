//! What a run is to be: the one request that commands make, the supervisor passes on and the control loop takes.
//!
//! Its parts are at once what commands take as options, so that an option is declared here alone. Between processes it goes
//! as TOML, where a number keeps all its bits, and NaN reaches the plan, which says what is wrong with it.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Parser};
use dynamics::Axis;
use dynamics::knobs::DOME;
use hal::simulated_rig::Cogging;
use serde::{Deserialize, Serialize};

/// Longest run, s: a day. Also the length of a run that the operator ends.
pub const LONGEST_DURATION_S: f64 = 86_400.0;

/// The default knob of the simulated rig.
pub(crate) fn default_knob(axis: Axis) -> &'static str {
    if axis.is_rotary() { "3" } else { DOME }
}

/// The request for a run.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunRequest {
    /// What is on the rig: 1 to 5 for the paper's knobs, a model file, or none or locked for the gripper alone [default: 3];
    /// on a real rig its name
    #[arg(long, value_name = "1…5|FILE.toml|none|locked|NAME")]
    pub knob: Option<String>,
    /// Name of the knob or the rendered model in the archive [default: as given]
    #[arg(long)]
    pub name: Option<String>,
    /// The excitation: paper, linear-chirp, multisine, fast-multisine, stepped-amplitude, slow-turn,
    /// torque-ramp, tone or hold
    #[arg(long, default_value = "linear-chirp")]
    pub sweep: String,
    /// Command a torque instead of an angle
    #[arg(long)]
    pub torque: bool,
    /// Largest commanded angle in rad or travel in mm, or torque in mNm or force in N [default: that of the sweep]
    #[arg(long, allow_negative_numbers = true)]
    pub amplitude: Option<f64>,
    /// Length of the run, s
    // As long as `LONGEST_DURATION_S` where the operator ends it.
    #[arg(long, default_value_t = 10.0, allow_negative_numbers = true)]
    pub duration_s: f64,
    /// Rate and core
    #[command(flatten)]
    pub pace: Pace,
    /// The rig
    #[command(flatten)]
    pub rig: RigRequest,
    /// The model to render instead of following a sweep
    #[arg(skip)]
    pub rendering: Option<RenderingRequest>,
}

impl Default for RunRequest {
    /// The default run of the control loop.
    fn default() -> Self {
        Options::parse_from(["rt-loop"]).into()
    }
}

/// Rate and processor core of the control loop.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pace {
    /// Samples per second
    #[arg(long, default_value_t = 10_000.0, allow_negative_numbers = true)]
    pub rate_hz: f64,
    /// Core for the real-time thread [default: the last one]
    #[arg(long)]
    pub core: Option<usize>,
}

/// The rig of a run.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigRequest {
    /// The rig file [default: the simulated rig]
    #[arg(long, value_name = "FILE.toml")]
    pub rig: Option<PathBuf>,
    /// A shipped rig: `sim`, the simulated one, or `sim-linear`, with a linear axis
    #[arg(long, default_value = "sim", conflicts_with = "rig")]
    pub apparatus: String,
    /// The rig's calibration, instead of the rig file's
    #[arg(long, value_name = "CALIBRATION.toml")]
    pub calibration: Option<PathBuf>,
    /// Options of the simulated rig
    #[command(flatten)]
    pub simulated: SimulatedRequest,
}

/// Options of the simulated rig.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulatedRequest {
    /// Seed of the simulated rig's noise [default: 1]
    #[arg(long)]
    pub seed: Option<u64>,
    /// Cogging of the simulated rig's motor, as periods per turn, mNm and rad; may be repeated
    #[arg(long, value_name = "PER_TURN:MNM[:RAD]")]
    pub motor_cogging: Vec<Cogging>,
    /// The hand on the gripper during a replay
    #[arg(skip)]
    pub hand: Option<HandRequest>,
}

/// The hand on the simulated rig.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandRequest {
    /// Motion that the simulated hand follows: a sweep's name, a CSV file of angles, or none to let go
    #[arg(long, default_value = "none", requires = "model", value_name = "SWEEP|FILE.csv|none")]
    pub hand: String,
    /// Torque in mNm, or force in N, that the simulated hand applies instead
    #[arg(long, requires = "model", allow_negative_numbers = true, value_name = "MNM")]
    pub hand_torque: Option<f64>,
    /// Stiffness and damping of the simulated hand, relative to a usual pinch grip
    #[arg(long, default_value_t = 1.0, requires = "model", allow_negative_numbers = true, value_name = "FACTOR")]
    pub grip: f64,
}

/// The model to render.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RenderingRequest {
    /// Render this model instead of following a sweep: a model file, or 1 to 5 for the paper's knobs
    #[arg(long = "render", required = false, value_name = "MODEL.toml")]
    pub model: String,
    /// Render the nearest model within the rig's limits instead of refusing one that exceeds them, and list the changes
    #[arg(long, requires = "model")]
    pub nearest: bool,
    /// Do not print remarks on deviations from the model; the archive's notes have them in any case
    #[arg(long, requires = "model")]
    pub without_remarks: bool,
}

/// Turns the knob under real-time control and publishes the samples.
#[derive(Debug, Clone, Parser)]
#[command(name = "rt-loop", version, about)]
pub struct Options {
    /// All options in one argument, as the supervisor gives them
    #[arg(long, exclusive = true, value_name = "TOML")]
    request: Option<RunRequest>,
    /// List the drivers that a rig file may name
    #[arg(long, exclusive = true)]
    pub(crate) drivers: bool,
    #[command(flatten)]
    run: RunRequest,
    #[command(flatten)]
    rendering: Option<RenderingRequest>,
    #[command(flatten)]
    hand: HandRequest,
}

impl From<Options> for RunRequest {
    fn from(options: Options) -> Self {
        let Options { request, drivers: _, mut run, rendering, hand } = options;
        run.rig.simulated.hand = rendering.is_some().then_some(hand);
        run.rendering = rendering;
        request.unwrap_or(run)
    }
}

impl RunRequest {
    /// The mounted knob or the rendered model, as the operator named it.
    #[must_use]
    pub fn knob_name(&self) -> &str {
        let model = self.rendering.as_ref().map(|rendering| &rendering.model);
        match (self.name.as_ref().or(model).or(self.knob.as_ref()), crate::rigs::file(&self.rig)) {
            (Some(name), _) => name,
            (None, Ok(file)) if file.driver == "simulated" => default_knob(file.axis),
            (None, _) => "unnamed",
        }
    }

    /// Whether the run lasts until the operator ends it.
    #[must_use]
    pub fn is_open_ended(&self) -> bool {
        self.duration_s >= LONGEST_DURATION_S
    }

    /// Ticks of the run, at least one.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        ((self.pace.rate_hz * self.duration_s).round() as u64).max(1)
    }
}

impl FromStr for RunRequest {
    type Err = toml::de::Error;

    fn from_str(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
mod tests {
    use super::*;

    #[test]
    fn a_request_comes_through_as_it_was_asked_for_numbers_that_are_none_too() {
        let line = "rt-loop --knob none --torque --amplitude 0.1 --rate-hz nan --duration-s 2.3 --core 1 --calibration rig.toml \
            --seed 18446744073709551615 --motor-cogging 48:0.3:1 --motor-cogging 7:0.1 --render 5 --nearest --hand multisine \
            --hand-torque -3 --grip 1e300 --without-remarks";
        let asked = RunRequest::from(Options::try_parse_from(line.split_whitespace()).unwrap());
        let passed_on = toml::to_string(&asked).unwrap();
        let taken = RunRequest::from(Options::try_parse_from(["rt-loop", "--request", &passed_on]).unwrap());
        assert_eq!(format!("{taken:?}"), format!("{asked:?}"));
        assert_eq!(asked.rig.simulated.hand.unwrap().hand_torque, Some(-3.0));
    }

    #[test]
    fn a_hand_without_a_model_to_feel_is_wrong_usage_and_so_is_a_request_beside_options() {
        for line in
            ["--hand multisine", "--grip 2", "--nearest", "--without-remarks", "--request x", "--request a=1 --torque"]
        {
            assert!(Options::try_parse_from(["rt-loop"].into_iter().chain(line.split(' '))).is_err(), "{line}");
        }
        assert_eq!(RunRequest::default().rendering, None);
    }
}
