//! What the process was asked to do, checked against the rig.

use std::path::PathBuf;

use clap::Parser;
use dynamics::excitation::ExcitationError;
use dynamics::knobs::Fixture;
use dynamics::{Calibration, CalibrationError, Drive, Excitation, Model, ModelError, knobs};
use hal::simulated::{RigParameters, SimulatedRig};
use hal::{Apparatus, RigDescription};
use shared_types::rig::{monotonic_time_ns, wall_clock_time_ns};
use shared_types::{ClockMapping, MODEL_MAX_BYTES, RunDescription};

use crate::admission::{Admission, Admitted};
use crate::control::rendering::{self, RenderGains, Renderer, Unrenderable};
use crate::control::{ControlPlan, Holding, ServoGains};
use crate::hand::hand;
use crate::motor_cogging::MotorCogging;
use crate::nearest::Nearest;
use crate::recomputation::ControlDescription;
use crate::stability::BoundExceeded;

/// Slowest rate at which the servo's velocity filter still does its work, Hz.
const SLOWEST_RATE_HZ: f64 = 2_000.0;
/// Longest run, s: a day.
const LONGEST_DURATION_S: f64 = 86_400.0;

/// Turns the knob under real-time control and publishes what it measures.
#[derive(Debug, Clone, Parser)]
#[command(name = "rt-loop", version, about)]
pub struct Options {
    /// The rig: `sim` is the simulated one.
    #[arg(long, default_value = "sim")]
    pub apparatus: String,
    /// The knob on the simulated rig: 1 to 5 for the paper's, a model file, or none or locked for the gripper alone.
    #[arg(long, default_value = "3")]
    pub knob: String,
    /// The rig's calibration, instead of the one that it comes with.
    #[arg(long, value_name = "CALIBRATION.toml")]
    pub calibration: Option<PathBuf>,
    /// The excitation: paper, linear-chirp, multisine, fast-multisine, stepped-amplitude, slow-turn,
    /// torque-ramp, tone or hold.
    #[arg(long, default_value = "linear-chirp")]
    pub sweep: String,
    /// Command a torque instead of an angle.
    #[arg(long)]
    pub torque: bool,
    /// Feel like this model instead of following a sweep: a model file, or 1 to 5 for the paper's knobs.
    #[arg(long, value_name = "MODEL.toml")]
    pub render: Option<String>,
    /// Where the rig cannot render the model, render the nearest that it can, and say what was clipped.
    #[arg(long, requires = "render")]
    pub nearest: bool,
    /// What the hand on the simulated rig wants while a model is rendered: a sweep's name, an angle column recorded in a
    /// CSV file, or `none` to let the gripper go.
    #[arg(long, default_value = "none", requires = "render", value_name = "SWEEP|FILE.csv|none")]
    pub hand: String,
    /// Torque that the hand on the simulated rig applies instead, mNm.
    #[arg(long, requires = "render", allow_negative_numbers = true, value_name = "MNM")]
    pub hand_torque: Option<f64>,
    /// Times by which the hand on the simulated rig is stiffer and more damped than a usual pinch grip.
    #[arg(long, requires = "render", default_value_t = 1.0, value_name = "FACTOR")]
    pub grip: f64,
    /// Largest commanded angle in rad, or torque in mNm [default: as the sweep has it].
    #[arg(long)]
    pub amplitude: Option<f64>,
    /// Samples per second.
    #[arg(long, default_value_t = 10_000.0)]
    pub rate_hz: f64,
    /// Length of the run, s.
    #[arg(long, default_value_t = 10.0)]
    pub duration_s: f64,
    /// Cogging of the simulated rig's motor, as periods per turn, mNm and rad; may be repeated.
    #[arg(long, value_name = "PER_TURN:MNM[:RAD]")]
    pub motor_cogging: Vec<MotorCogging>,
    /// Do not tell what is felt otherwise than the model says; the archive's notes have it all the same.
    #[arg(long, requires = "render")]
    pub without_remarks: bool,
    /// Seed of the simulated rig's noise.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Core for the real-time thread [default: the last one].
    #[arg(long)]
    pub core: Option<usize>,
}

/// A run that cannot be done as asked.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// A rig that is not there.
    #[error("there is no apparatus '{0}'; this program drives 'sim', the simulated rig")]
    UnknownApparatus(String),
    /// A knob that cannot be had.
    #[error(transparent)]
    Knob(#[from] ModelError),
    /// A knob that the simulated rig cannot turn.
    #[error("the knob cannot be put on the simulated rig: {0}")]
    Unmountable(String),
    /// A calibration that cannot be used.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// An excitation that cannot be had.
    #[error(transparent)]
    Excitation(#[from] ExcitationError),
    /// A rate outside what rig and servo hold.
    #[error("a rate of {asked} Hz cannot be held: the rig '{rig}' takes {slowest} to {fastest} Hz")]
    Rate {
        /// The rate asked for, Hz.
        asked: f64,
        /// The rig's name.
        rig: String,
        /// Slowest rate, Hz.
        slowest: f64,
        /// Fastest rate, Hz.
        fastest: f64,
    },
    /// A rate at which the servo makes the shaft swing.
    #[error("at {asked} Hz the servo would shake this knob instead of holding it: {remedy}")]
    Unstable {
        /// The rate asked for, Hz.
        asked: f64,
        /// What to do instead.
        remedy: String,
    },
    /// A hand that cannot be had.
    #[error("the hand cannot be had: {0}")]
    Hand(String),
    /// A model that cannot be rendered.
    #[error(transparent)]
    Unrenderable(#[from] Unrenderable),
    /// A model that this rig cannot render.
    #[error(transparent)]
    Unsafe(#[from] BoundExceeded),
    /// A model that does not fit what is sent to the loop and published.
    #[error(
        "the model takes {bytes} bytes as TOML, but at most {MODEL_MAX_BYTES} can be rendered; shorten its description"
    )]
    TooLong {
        /// Its length, bytes of TOML.
        bytes: usize,
    },
    /// A rig whose own friction is not known.
    #[error(
        "the calibration has no motor_coulomb_mnm, so that the rig's own friction would be felt with the model's; run \
         `haptic-camera calibrate friction` first"
    )]
    Uncalibrated,
    /// A duration that is no length of a run.
    #[error("a run of {0} s cannot be done; give a duration above 0 and up to a day (86400 s)")]
    Duration(f64),
    /// A core that the process may not use.
    #[error("core {asked} is not to be had; this process may run on cores up to {last}")]
    Core {
        /// The core asked for.
        asked: usize,
        /// The last one permitted.
        last: usize,
    },
}

/// A model ready to be rendered.
pub struct Rendering {
    /// The model as it is rendered: the one asked for, or the nearest to it that the rig renders.
    pub model: Model,
    /// The renderer with it.
    pub renderer: Renderer,
    /// The gains with which it is rendered.
    pub gains: RenderGains,
    /// What was changed or left out so that it can be rendered, in sentences.
    pub remarks: Vec<String>,
    /// What further models must pass.
    pub admission: Admission,
}

/// A run ready to be done.
pub struct Plan {
    /// The rig with the knob on it.
    pub apparatus: Box<dyn Apparatus>,
    /// What the rig says of itself.
    pub rig: RigDescription,
    /// The run itself.
    pub control: ControlPlan,
    /// The knob as the operator named it.
    pub knob: String,
    /// The model that the simulated rig turns.
    pub simulated_knob: Model,
    /// What is rendered instead of a sweep followed.
    pub rendering: Option<Rendering>,
    /// Core for the real-time thread.
    pub core: usize,
}

impl Plan {
    /// What a consumer must know about a run of this plan that begins now, without real-time permission so far.
    ///
    /// # Errors
    /// When excitation or gains have no TOML form.
    pub fn description(&self) -> Result<RunDescription, toml::ser::Error> {
        let remarks = self.rendering.iter().flat_map(|rendering| &rendering.remarks);
        let remarks = remarks.map(|remark| ("rendering".to_owned(), remark.clone()));
        Ok(RunDescription {
            run_id: wall_clock_time_ns() ^ (u64::from(std::process::id()) << 32),
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            apparatus: self.rig.name.clone(),
            knob: self.knob.clone(),
            rate_hz: self.control.rate_hz,
            planned_ticks: self.control.planned_ticks,
            clock: ClockMapping { monotonic_time_ns: monotonic_time_ns(), wall_clock_time_ns: wall_clock_time_ns() },
            realtime: 0,
            excitation_toml: toml::to_string(&self.control.excitation)?,
            calibration_toml: self.rig.calibration.to_toml(),
            simulated_knob_toml: Some(self.simulated_knob.to_toml()),
            rendered_model_toml: self.rendering.as_ref().map(|rendering| rendering.model.to_toml()),
            control_toml: Some(toml::to_string(&ControlDescription {
                rate_hz: self.control.rate_hz,
                planned_ticks: self.control.planned_ticks,
                limits: self.control.limits,
                servo_gains: self.control.gains,
                render_gains: self.rendering.as_ref().map(|rendering| rendering.gains),
            })?),
            notes: self.rig.notes.iter().cloned().chain(remarks).collect(),
        })
    }

    /// Checks the options against the rig.
    ///
    /// # Errors
    /// [`PlanError`], for whatever cannot be done as asked.
    pub fn new(options: &Options) -> Result<Self, PlanError> {
        if options.apparatus != "sim" {
            return Err(PlanError::UnknownApparatus(options.apparatus.clone()));
        }
        if !(options.duration_s > 0.0 && options.duration_s <= LONGEST_DURATION_S) {
            return Err(PlanError::Duration(options.duration_s));
        }
        let last = crate::realtime::last_core();
        let core = options.core.unwrap_or(last);
        if core > last {
            return Err(PlanError::Core { asked: core, last });
        }
        let drive = if options.torque { Drive::Torque } else { Drive::Position };
        let mut excitation = Excitation::named(&options.sweep, drive)?;
        if let Some(amplitude) = options.amplitude {
            excitation = excitation.with_amplitude(amplitude)?;
        }
        let knob = match options.render {
            // Whatever is rendered, nothing but a hand is on the gripper.
            Some(_) => Fixture::None.model()?,
            None => mounted_knob(&options.knob)?,
        };
        let hand = options.render.is_some().then(|| hand(options)).transpose()?.flatten();
        let parameters = RigParameters {
            motor_cogging: options.motor_cogging.iter().map(|harmonic| harmonic.0).collect(),
            ..RigParameters::default()
        };
        let apparatus = SimulatedRig::held(parameters, knob.clone(), hand, options.seed)
            .map_err(|error| PlanError::Unmountable(error.to_string()))?;
        let mut rig = apparatus.description().clone();
        if let Some(path) = &options.calibration {
            rig.calibration = Calibration::load(path)?;
        }
        if !(options.rate_hz >= SLOWEST_RATE_HZ && options.rate_hz <= rig.limits.rate_hz) {
            return Err(PlanError::Rate {
                asked: options.rate_hz,
                rig: rig.name,
                slowest: SLOWEST_RATE_HZ,
                fastest: rig.limits.rate_hz,
            });
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to lie within a day")]
        let planned_ticks = ((options.rate_hz * options.duration_s).round() as u64).max(1);
        let control = ControlPlan {
            excitation,
            gains: match Fixture::named(&options.knob) {
                Some(Fixture::None) => ServoGains::for_free_gripper(&rig.calibration),
                Some(Fixture::Locked) | None => ServoGains::default(),
            },
            limits: rig.limits,
            rate_hz: options.rate_hz,
            planned_ticks,
        };
        if options.render.is_none() && drive == Drive::Position {
            check_servo(&control, &rig, knob.inertia())?;
        }
        let rendering = options.render.as_deref().map(|name| make_rendering(name, &rig, options)).transpose()?;
        Ok(Self {
            apparatus: Box::new(apparatus),
            rig,
            control,
            knob: options.render.clone().unwrap_or_else(|| options.knob.clone()),
            rendering,
            simulated_knob: knob,
            core,
        })
    }
}

/// Makes sure that the servo holds a knob of this inertia.
fn check_servo(control: &ControlPlan, rig: &RigDescription, knob_inertia: f64) -> Result<(), PlanError> {
    let ControlPlan { gains, rate_hz, .. } = *control;
    let holding = Holding { gains, calibration: &rig.calibration, knob_inertia };
    if holding.is_stable(rate_hz) {
        return Ok(());
    }
    let fastest_hz = rig.limits.rate_hz;
    let remedy = match holding.slowest_stable_hz(fastest_hz) {
        Some(slowest_hz) => format!("give --rate-hz {slowest_hz} or more"),
        None => format!("with the rig's calibration it holds it at no rate up to {fastest_hz} Hz; calibrate it again"),
    };
    Err(PlanError::Unstable { asked: rate_hz, remedy })
}

/// The model called `name`, made ready to be rendered on the rig.
fn make_rendering(name: &str, rig: &RigDescription, options: &Options) -> Result<Rendering, PlanError> {
    let rate_hz = options.rate_hz;
    let model = mounted_knob(name)?;
    if rig.calibration.motor_coulomb_mnm.is_none() {
        return Err(PlanError::Uncalibrated);
    }
    let too_slow = || PlanError::Rate {
        asked: rate_hz,
        rig: rig.name.clone(),
        slowest: rendering::SLOWEST_RATE_HZ,
        fastest: rig.limits.rate_hz,
    };
    let gains = RenderGains::at_rate(rate_hz).ok_or_else(too_slow)?;
    let admission = Admission::new(&gains, &rig.calibration, &rig.limits, rate_hz);
    let (model, Admitted { rendered, remarks }) = if options.nearest {
        let Nearest { model, admitted, clipped } = admission.nearest(&model)?;
        let clipped = clipped.into_iter().map(|change| format!("clipped to what the rig renders: {change}"));
        (model, Admitted { remarks: clipped.chain(admitted.remarks).collect(), ..admitted })
    } else {
        let admitted = admission.admit(&model)?;
        (model, admitted)
    };
    let renderer =
        Renderer::new(rendered, gains, &rig.calibration, rig.limits.motor_torque_mnm, rate_hz).ok_or_else(too_slow)?;
    Ok(Rendering { model, renderer, gains, remarks, admission })
}

fn mounted_knob(name: &str) -> Result<Model, ModelError> {
    if let Some(fixture) = Fixture::named(name) {
        return fixture.model();
    }
    knobs::named(name)
}
