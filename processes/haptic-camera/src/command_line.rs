//! The command line: names and options.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use rt_loop::motor_cogging::MotorCogging;

use crate::capture::Budget;
use crate::compose::{Assignment, Extra};

/// Captures how a mechanical knob feels, as numbers.
#[derive(Debug, Parser)]
#[command(name = "haptic-camera", version, propagate_version = true)]
#[command(after_help = "Exit status: 0 done, 1 failed, 2 wrong usage, 3 done but data was lost.")]
pub struct CommandLine {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What the program can do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Turn a knob through a sweep, watch it live, and keep an archive and a fitted model
    #[command(after_help = "Examples:\n  haptic-camera capture --knob 3 --duration-s 10 --out captures\n  \
        haptic-camera capture --knob 5 --diagnose --budget 5")]
    Capture(CaptureOptions),
    /// Make the rig feel like a model, and record what the hand does
    #[command(after_help = "Examples:\n  haptic-camera replay 3\n  \
        haptic-camera replay composed.toml --hand multisine --duration-s 10\n  \
        haptic-camera replay 5 --nearest\n\n\
        While it runs, `haptic-camera tune` turns the model's parameters.")]
    Replay(ReplayOptions),
    /// Turn a parameter of the model that a running replay renders, or change over to another model
    #[command(after_help = "Examples:\n  haptic-camera tune detent_amplitude=8 coulomb_positive=5\n  \
        haptic-camera tune --model 1\n  haptic-camera tune")]
    Tune(TuneOptions),
    /// Fit a model to a capture, or one model to several captures of the same knob
    #[command(after_help = "Example:\n  haptic-camera fit captures/20261121-101500-knob-3.mcap --report knob-3.html")]
    Fit(FitOptions),
    /// Find where a model and a capture disagree, name the missing effect, add it and show the gap shrink
    #[command(after_help = "Example:\n  \
        haptic-camera diagnose train.csv --heldout heldout.csv --report diagnosis.html")]
    Diagnose(DiagnoseOptions),
    /// Find the rig's zeros, gravity, delays, the gripper's inertia or the motor's friction
    #[command(
        after_help = "Takes given captures, or turns the rig itself (nothing on the gripper). In this order:\n  \
        haptic-camera calibrate zero --out rig.toml\n  \
        haptic-camera calibrate gravity --calibration rig.toml --out rig.toml\n  \
        haptic-camera calibrate latency --calibration rig.toml --out rig.toml\n  \
        haptic-camera calibrate gripper --calibration rig.toml --out rig.toml\n  \
        haptic-camera calibrate friction --calibration rig.toml --out rig.toml\n  \
        haptic-camera capture --calibration rig.toml --knob 3"
    )]
    Calibrate(CalibrateOptions),
    /// Try the rig without a knob: how far what it measures lies from what it was told to do
    #[command(after_help = "Example:\n  haptic-camera rig-test --offline --json rig-test.json")]
    RigTest(RigTestOptions),
    /// Check a fit by what a capture shows without one: detents counted, breakaways read off
    #[command(after_help = "Example:\n  \
        haptic-camera capture --knob 3 --sweep slow-turn --duration-s 15\n  \
        haptic-camera capture --knob 3 --sweep slow-turn --amplitude 0.1 --duration-s 15\n  \
        haptic-camera check TURN.mcap CREEP.mcap --model knob-3.toml")]
    Check(CheckOptions),
    /// Simulate a model along a capture's motion or torque
    #[command(after_help = "Example:\n  haptic-camera simulate model.toml --like capture.mcap --out simulated.mcap")]
    Simulate(SimulateOptions),
    /// Compose a model of one knob's inertia, another's friction and a third one's detents
    #[command(after_help = "Examples:\n  \
        haptic-camera compose --inertia 2 --friction 1 --detents 3 --out mix.toml\n  \
        haptic-camera compose --inertia 2 --friction 4 --detents drawn.csv --set table_scale=1.5 --out new.toml\n\n\
        Inertia is what resists acceleration; friction what resists turning, its stick and what modulates it; detents \
        are the torques that repeat along the angle, of every waveform. All else is taken one by one, by --extra.")]
    Compose(ComposeOptions),
    /// Open the live view of the running capture, or look at a finished one
    View(ViewOptions),
    /// Compute the torques of a recorded replay again and say whether they are equal, bit for bit
    #[command(after_help = "Example:\n  haptic-camera recompute captures/20261121-101500-replay-knob-3.mcap")]
    Recompute(RecomputeOptions),
    /// Make a whole archive of one that was cut short or damaged
    #[command(after_help = "Example:\n  haptic-camera recover broken.mcap --out whole.mcap")]
    Recover(RecoverOptions),
    /// Check what this machine permits: real-time priority, memory, shared memory, programs
    Doctor,
}

/// Options of what runs the control loop under supervision.
#[derive(Clone, Debug, Args)]
pub struct RunOptions {
    /// The rig: `sim` is the simulated one
    #[arg(long, default_value = "sim")]
    pub apparatus: String,
    /// The rig's calibration, instead of the one that it comes with
    #[arg(long, value_name = "CALIBRATION.toml")]
    pub calibration: Option<PathBuf>,
    /// Samples per second
    #[arg(long, default_value_t = 10_000.0, allow_negative_numbers = true)]
    pub rate_hz: f64,
    /// Folder for the archive, and for the model and the report that are made of a capture
    #[arg(long, default_value = "captures", value_name = "DIR")]
    pub out: PathBuf,
    /// Seed of the simulated rig's noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Cogging of the simulated rig's motor, as periods per turn, mNm and rad; may be repeated
    #[arg(long, value_name = "PER_TURN:MNM[:RAD]")]
    pub motor_cogging: Vec<MotorCogging>,
    /// Core for the real-time thread [default: the last one]
    #[arg(long)]
    pub core: Option<usize>,
    /// Do without the live view
    #[arg(long)]
    pub no_viewer: bool,
    /// Show the live view in a window of its own instead of a web page
    #[arg(long, conflicts_with = "no_viewer")]
    pub native_viewer: bool,
    /// Run the simulated rig as fast as the processor goes, without the real-time processes
    #[arg(long)]
    pub offline: bool,
}

impl RunOptions {
    /// The control loop's part of them.
    #[must_use]
    pub fn loop_arguments(&self) -> Vec<String> {
        let mut arguments = vec![
            format!("--apparatus={}", self.apparatus),
            format!("--rate-hz={}", self.rate_hz),
            format!("--seed={}", self.seed),
        ];
        if let Some(calibration) = &self.calibration {
            arguments.push(format!("--calibration={}", calibration.display()));
        }
        arguments.extend(self.motor_cogging.iter().map(|harmonic| format!("--motor-cogging={harmonic}")));
        if let Some(core) = self.core {
            arguments.push(format!("--core={core}"));
        }
        arguments
    }
}

/// Options of `capture`.
#[derive(Clone, Debug, Args)]
pub struct CaptureOptions {
    /// The knob on the simulated rig: 1 to 5 for the paper's, a model file, or none or locked for the gripper alone
    #[arg(long, default_value = "3", value_name = "1…5|FILE.toml|none|locked")]
    pub knob: String,
    /// The excitation: paper, linear-chirp, multisine, fast-multisine, stepped-amplitude, slow-turn,
    /// torque-ramp, tone or hold
    #[arg(long, default_value = "linear-chirp")]
    pub sweep: String,
    /// Command a torque instead of an angle
    #[arg(long)]
    pub torque: bool,
    /// Largest commanded angle in rad, or torque in mNm [default: as the sweep has it]
    #[arg(long, allow_negative_numbers = true)]
    pub amplitude: Option<f64>,
    /// Length of the capture, s
    #[arg(long, default_value_t = 10.0, allow_negative_numbers = true)]
    pub duration_s: f64,
    /// Rig, rate, archive and view
    #[command(flatten)]
    pub run: RunOptions,
    /// Diagnose what is captured, and run the experiments that tell rivals apart until one name is left.
    ///
    /// The first capture is the sweep asked for, the second another motion that is held out. While effects are tied,
    /// the experiment on which they differ most is run and joins the evidence. Every capture is kept as a file of
    /// its own; model and report page of the diagnosis lie beside the first.
    #[arg(long, conflicts_with = "torque")]
    pub diagnose: bool,
    /// Most that the knob is turned for a diagnosis: captures, as in 5, or seconds of turning, as in 60s. The first two
    /// captures count, and are made in any case
    #[arg(long, requires = "diagnose", default_value = "5", value_name = "CAPTURES|SECONDSs")]
    pub budget: Budget,
    /// How far from its start the knob may be turned to tell rivals apart, rad [default: as far as the first two captures]
    #[arg(long, requires = "diagnose", value_name = "RAD", allow_negative_numbers = true)]
    pub reach: Option<f64>,
    /// Write the diagnosis as JSON; `-` for standard output
    #[arg(long, requires = "diagnose", value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the report page of the diagnosis here, instead of beside the first capture
    #[arg(long, requires = "diagnose", value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Write the diagnosis as a rerun file
    #[arg(long, requires = "diagnose", value_name = "FILE.rrd")]
    pub recording: Option<PathBuf>,
}

/// Options of `replay`.
#[derive(Clone, Debug, Args)]
pub struct ReplayOptions {
    /// The model to feel like: a model file, or 1 to 5 for the paper's knobs
    #[arg(value_name = "1…5|MODEL.toml")]
    pub model: String,
    /// Render the nearest that the rig can instead of refusing a model that passes its bounds, and say what was clipped, from what
    /// to what
    #[arg(long)]
    pub nearest: bool,
    /// What the hand on the simulated rig wants: a sweep's name, the angles recorded in a CSV file, or none to let go
    #[arg(long, default_value = "none", value_name = "SWEEP|FILE.csv|none")]
    pub hand: String,
    /// Torque that the hand on the simulated rig applies instead, mNm
    #[arg(long, allow_negative_numbers = true, value_name = "MNM")]
    pub hand_torque: Option<f64>,
    /// Times by which the hand on the simulated rig is stiffer and more damped than a usual pinch grip
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true, value_name = "FACTOR")]
    pub grip: f64,
    /// Largest angle to which the hand's sweep goes, rad [default: as the sweep has it]
    #[arg(long, allow_negative_numbers = true)]
    pub amplitude: Option<f64>,
    /// Length, s [default: until Ctrl-C, a day at most; offline 10]
    #[arg(long, allow_negative_numbers = true)]
    pub duration_s: Option<f64>,
    /// Prove the rendering: a hand takes the rendered knob through the capture's sweeps, and what is captured is fitted,
    /// diagnosed and compared with the model, parameter by parameter
    #[arg(long, conflicts_with_all = ["hand", "hand_torque", "grip", "amplitude", "duration_s"])]
    pub verify: bool,
    /// Write the comparison as JSON; `-` for standard output
    #[arg(long, requires = "verify", value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the comparison as a report page
    #[arg(long, requires = "verify", value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Rig, rate, archive and view
    #[command(flatten)]
    pub run: RunOptions,
}

/// Options of `tune`.
#[derive(Clone, Debug, Args)]
pub struct TuneOptions {
    /// Change over to this model: a model file, or 1 to 5 for the paper's knobs
    #[arg(long, value_name = "1…5|MODEL.toml")]
    pub model: Option<String>,
    /// Parameters to set, by their names in a model file; with neither these nor a model, the present model is told
    #[arg(value_name = "NAME=VALUE")]
    pub settings: Vec<Assignment<f64>>,
}

/// Options of `fit`.
#[derive(Debug, Args)]
pub struct FitOptions {
    /// The capture, an archive or a CSV file; several of the same knob are made into one model
    #[arg(required = true, value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the fitted model
    #[arg(long, value_name = "MODEL.toml")]
    pub out: Option<PathBuf>,
    /// Write the report page
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// How the capture is filtered before the fit
    #[arg(long, value_enum, default_value = "automatic")]
    pub preparation: Preparation,
}

/// How a capture is filtered before a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Preparation {
    /// Every edge from the signals' own spectra.
    Automatic,
    /// As Swindells and MacLean 2007 did.
    Paper,
    /// Angle through a 100 Hz Butterworth low-pass, differenced twice, decimated to 100 Hz: common for robots.
    CentralDifferences,
}

impl From<Preparation> for identification::PreparationMethod {
    fn from(preparation: Preparation) -> Self {
        match preparation {
            Preparation::Automatic => Self::Automatic,
            Preparation::Paper => Self::Paper,
            Preparation::CentralDifferences => Self::CentralDifferences,
        }
    }
}

/// Options of `diagnose`.
#[derive(Debug, Args)]
pub struct DiagnoseOptions {
    /// The capture that models are fitted to, an archive or a CSV file
    #[arg(value_name = "CAPTURE")]
    pub train: PathBuf,
    /// A capture of the same knob with another motion, to judge by; without one, stretches of the first are held out
    #[arg(long, value_name = "CAPTURE")]
    pub heldout: Option<PathBuf>,
    /// The model to start from [default: inertia, friction and detents, fitted]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// Write the diagnosis as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the model with what was missing
    #[arg(long, value_name = "MODEL.toml")]
    pub out: Option<PathBuf>,
    /// Write the report page
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Write a rerun file: torque measured and predicted, the residual's maps, each effect beside its rivals
    #[arg(long, value_name = "FILE.rrd")]
    pub recording: Option<PathBuf>,
}

/// Options of what turns the rig without a knob.
#[derive(Debug, Args)]
pub struct RigOptions {
    /// The rig: `sim` is the simulated one
    #[arg(long, default_value = "sim")]
    pub apparatus: String,
    /// Run the simulated rig as fast as the processor goes, without the real-time processes
    #[arg(long)]
    pub offline: bool,
    /// Seed of the simulated rig's noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Cogging of the simulated rig's motor, as periods per turn, mNm and rad; may be repeated
    #[arg(long, value_name = "PER_TURN:MNM[:RAD]")]
    pub motor_cogging: Vec<MotorCogging>,
    /// Folder for the captures made on the way
    #[arg(long, default_value = "captures", value_name = "DIR")]
    pub captures_in: PathBuf,
}

/// Options of `calibrate`.
#[derive(Debug, Args)]
pub struct CalibrateOptions {
    /// What to calibrate
    #[arg(value_enum, value_name = "WHAT")]
    pub what: CalibrationKind,
    /// Captures made for it; without any the rig is turned, with nothing on the gripper
    #[arg(value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// Where the calibration goes; may be the file given as --calibration
    #[arg(long, value_name = "CALIBRATION.toml")]
    pub out: PathBuf,
    /// What is known so far, instead of what the captures say of their rig
    #[arg(long, value_name = "PREVIOUS.toml")]
    pub calibration: Option<PathBuf>,
    /// How the rig is turned where no capture is given
    #[command(flatten)]
    pub rig: RigOptions,
}

/// What `calibrate` can find.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum CalibrationKind {
    /// Gravity in the acceleration signal, from a slow turn of more than 360°.
    Gravity,
    /// The readings of torque sensor and accelerometer at rest, with nothing on the gripper.
    Zero,
    /// The gripper's inertia, from a sweep of the gripper alone.
    Gripper,
    /// How late torque and acceleration come, from fast sines of the gripper alone.
    Latency,
    /// The motor's cogging, from slow turns of the gripper alone in both directions.
    Cogging,
    /// The motor's own inertia and friction, from a sweep of the gripper alone.
    Friction,
}

/// Options of `rig-test`.
#[derive(Debug, Args)]
pub struct RigTestOptions {
    /// The reading of the paper's sweep: paper (as printed) or linear-chirp
    #[arg(long, default_value = "paper")]
    pub sweep: String,
    /// Samples per second
    #[arg(long, default_value_t = 5_000.0, allow_negative_numbers = true)]
    pub rate_hz: f64,
    /// The rig's calibration, instead of the one that it comes with
    #[arg(long, value_name = "CALIBRATION.toml")]
    pub calibration: Option<PathBuf>,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// How the rig is turned
    #[command(flatten)]
    pub rig: RigOptions,
}

/// Options of `check`.
#[derive(Debug, Args)]
pub struct CheckOptions {
    /// Captures to look at: a slow turn for the detents, a creep or a torque ramp for the breakaway
    #[arg(required = true, value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// The fitted model to check
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Options of `simulate`.
#[derive(Debug, Args)]
pub struct SimulateOptions {
    /// The model
    #[arg(value_name = "MODEL.toml")]
    pub model: PathBuf,
    /// The capture whose motion or torque is followed
    #[arg(long, value_name = "CAPTURE")]
    pub like: PathBuf,
    /// Where the simulated capture goes: an archive, or CSV if the name ends in .csv
    #[arg(long, value_name = "CAPTURE")]
    pub out: PathBuf,
    /// What is taken from the capture: its motion, giving the torque, or its torque, giving the motion
    #[arg(long, value_enum, default_value = "motion")]
    pub drive: SimulationDrive,
}

/// What a simulation takes from a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum SimulationDrive {
    /// The motion: the model's torque is simulated.
    Motion,
    /// The torque: the model's motion is simulated forward.
    Torque,
}

/// Options of `compose`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("parts").args(["inertia", "friction", "detents", "extra"]).required(true).multiple(true)))]
pub struct ComposeOptions {
    /// The knob whose inertia it has: 1 to 5 for the paper's, or a model file
    #[arg(long, value_name = "1…5|FILE.toml")]
    pub inertia: Option<String>,
    /// The knob whose friction it has, with stick and all that modulates friction
    #[arg(long, value_name = "1…5|FILE.toml")]
    pub friction: Option<String>,
    /// The knob whose detents it has, or a table with the header angle_rad,torque_mnm over one period
    #[arg(long, value_name = "1…5|FILE.toml|FILE.csv")]
    pub detents: Option<String>,
    /// One more effect of another knob, as in 5:backlash or springy.toml:return-spring; may be repeated
    #[arg(long, value_name = "KNOB:EFFECT")]
    pub extra: Vec<Extra>,
    /// A value for a parameter, as in detent_amplitude=1.5; may be repeated
    #[arg(long, value_name = "NAME=NUMBER")]
    pub set: Vec<Assignment<f64>>,
    /// A parameter's value from another knob, as in detent_amplitude=4; may be repeated
    #[arg(long, value_name = "NAME=KNOB")]
    pub from: Vec<Assignment<String>>,
    /// What the model is called [default: as its file]
    #[arg(long)]
    pub name: Option<String>,
    /// Where the model goes; a model that was composed before is replaced
    #[arg(long, value_name = "MODEL.toml")]
    pub out: PathBuf,
    /// Write over whatever lies there
    #[arg(long)]
    pub overwrite: bool,
}

/// Options of `view`.
#[derive(Debug, Args)]
pub struct ViewOptions {
    /// A finished capture; without it the running one is followed
    #[arg(value_name = "CAPTURE")]
    pub capture: Option<PathBuf>,
    /// Show it in a window of its own instead of a web page
    #[arg(long)]
    pub native: bool,
    /// Also print the ssh command with which another machine sees the page; nothing is opened to the network
    #[arg(long, conflicts_with = "native")]
    pub remote: bool,
}

/// Options of `recompute`.
#[derive(Debug, Args)]
pub struct RecomputeOptions {
    /// The archive of a replay
    #[arg(value_name = "CAPTURE")]
    pub capture: PathBuf,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Options of `recover`.
#[derive(Debug, Args)]
pub struct RecoverOptions {
    /// The archive that was cut short or damaged, or that a killed recorder left in parts; it is left as it is
    #[arg(value_name = "BROKEN.mcap")]
    pub broken: PathBuf,
    /// Where the whole archive goes
    #[arg(long, value_name = "FIXED.mcap")]
    pub out: PathBuf,
    /// Keep samples of a chunk that is cut off too, which no checksum covers
    #[arg(long)]
    pub keep_unchecked: bool,
}
