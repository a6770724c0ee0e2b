//! What the process was asked to do, checked against the rig.

use dynamics::excitation::ExcitationError;
use dynamics::knobs::Fixture;
use dynamics::{Axis, Calibration, CalibrationError, Drive, Excitation, Model, ModelError, knobs};
use hal::plugin::PluginRigError;
use hal::{Apparatus, Limits, RigDescription, RigFile, RigFileError, TorqueSource};
use shared_types::rig::{monotonic_time_ns, wall_clock_time_ns};
use shared_types::{ClockMapping, MODEL_MAX_BYTES, RunDescription};

use crate::admission::{Admission, Admitted};
use crate::control::rendering::{RenderGains, Renderer, Unrenderable};
use crate::control::{ControlPlan, Holding, ServoGains};
use crate::nearest::Nearest;
use crate::realtime::call_numbers;
use crate::recomputation::ControlDescription;
use crate::request::{LONGEST_DURATION_S, RenderingRequest, RunRequest};
use crate::rigs::{self, Registry, Rig};
use crate::stability::{BoundExceeded, Firmness, gains_for};

/// Slowest rate at which a knob is captured, Hz: the paper's sweep goes to some hertz, and detents pass tens of times a second.
const SLOWEST_RATE_HZ: f64 = 500.0;

/// Rates that are tried where one is too slow to render at, Hz.
const RENDERING_RATES_HZ: [f64; 12] =
    [500.0, 750.0, 1_000.0, 1_500.0, 2_000.0, 2_500.0, 3_000.0, 4_000.0, 5_000.0, 7_500.0, 10_000.0, 20_000.0];

/// A run that cannot be done as asked.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// A rig that is not there.
    #[error("there is no shipped rig '{asked}'; --apparatus takes {known}, and --rig a file")]
    UnknownRig {
        /// The name asked for.
        asked: String,
        /// Those that ship.
        known: String,
    },
    /// A driver that is not there.
    #[error("the rig '{rig}' has an unknown driver '{asked}'; known are {known}")]
    UnknownDriver {
        /// The rig's name.
        rig: String,
        /// The driver asked for.
        asked: String,
        /// Those that there are, each with what it is.
        known: String,
    },
    /// A rig file that cannot be used.
    #[error(transparent)]
    RigFile(#[from] RigFileError),
    /// A library that cannot be used.
    #[error(transparent)]
    Plugin(#[from] PluginRigError),
    /// Something that only the simulated rig has.
    #[error("{what} only applies to the simulated rig, and not to '{rig}'; omit it")]
    NotSimulated {
        /// The rig's name.
        rig: String,
        /// The option.
        what: String,
    },
    /// A system call that the loop cannot look for.
    #[error("the rig '{rig}' declares an unknown system call '{call}'; known are {known}")]
    UnknownCall {
        /// The rig's name.
        rig: String,
        /// The call.
        call: String,
        /// Those that are.
        known: String,
    },
    /// A rig that cannot feel a hand.
    #[error("the rig '{0}' has no torque sensor, which a replay needs to measure the hand; it can only capture")]
    NoTorqueSensor(String),
    /// A rate at which nothing can be rendered.
    #[error("at {asked} Hz the rig '{rig}' cannot render a knob stably in a hand: {remedy}")]
    TooSlow {
        /// The rate asked for, Hz.
        asked: f64,
        /// The rig's name.
        rig: String,
        /// What to do instead.
        remedy: String,
    },
    /// A knob that cannot be had.
    #[error(transparent)]
    Knob(#[from] ModelError),
    /// A model of what moves along the other axis.
    #[error(
        "the model '{model}' is of a control with a {is} axis, and the rig '{rig}' has a {has} one; choose another of either"
    )]
    OtherAxis {
        /// The model's name.
        model: String,
        /// Its axis.
        is: Axis,
        /// The rig's name.
        rig: String,
        /// The rig's axis.
        has: Axis,
    },
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
    #[error("at {asked} Hz the servo would be unstable with this knob: {remedy}")]
    Unstable {
        /// The rate asked for, Hz.
        asked: f64,
        /// What to do instead.
        remedy: String,
    },
    /// A hand that cannot be had.
    #[error("the hand is invalid: {0}")]
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
        "the calibration has no motor_coulomb_mnm, so that the rig's own friction would add to the model's; run \
         `haptic-camera calibrate friction` first"
    )]
    Uncalibrated,
    /// What cannot be done on a rig that presses or slides, in the words of that.
    #[error("{0}")]
    OnLinearAxis(String),
    /// A duration that is no length of a run.
    #[error("a run cannot last {0} s; give a duration above 0 and up to a day ({LONGEST_DURATION_S} s)")]
    Duration(f64),
    /// A core that the process may not use.
    #[error("core {asked} is not available; this process may run on cores up to {last}")]
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
    /// Whether to suppress the remarks.
    without_remarks: bool,
}

impl Rendering {
    /// The remarks to print for the operator.
    pub fn remarks_to_print(&self) -> impl Iterator<Item = &String> {
        self.remarks.iter().filter(|_| !self.without_remarks)
    }
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
    /// The model that a simulated rig turns; `None` on real hardware.
    pub simulated_knob: Option<Model>,
    /// What is rendered instead of a sweep followed.
    pub rendering: Option<Rendering>,
    /// What the servo does that whoever reads the capture should know, in a sentence.
    pub servo_remark: Option<String>,
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
            axis: self.rig.calibration.axis,
            contact: self.rig.has_contact,
            knob: self.knob.clone(),
            rate_hz: self.control.rate_hz,
            planned_ticks: self.control.planned_ticks,
            clock: ClockMapping { monotonic_time_ns: monotonic_time_ns(), wall_clock_time_ns: wall_clock_time_ns() },
            realtime: 0,
            torque_late_ticks: Some(self.rig.torque_late_ticks),
            excitation_toml: toml::to_string(&self.control.excitation)?,
            calibration_toml: self.rig.calibration_of_torque().to_toml(),
            simulated_knob_toml: self.simulated_knob.as_ref().map(Model::to_toml),
            rendered_model_toml: self.rendering.as_ref().map(|rendering| rendering.model.to_toml()),
            control_toml: Some(toml::to_string(&ControlDescription {
                rate_hz: self.control.rate_hz,
                planned_ticks: self.control.planned_ticks,
                limits: self.control.limits,
                servo_gains: self.control.gains,
                render_gains: self.rendering.as_ref().map(|rendering| rendering.gains),
            })?),
            device_codes: self.rig.codes.clone(),
            notes: self.notes().chain(self.rig.notes.iter().cloned()).chain(remarks).collect(),
        })
    }

    /// What the rig says once it is prepared, and what is to be known of the servo.
    fn notes(&self) -> impl Iterator<Item = (String, String)> {
        let watchdog_s =
            self.rig.watchdog_s.map(|timeout_s| ("watchdog".to_owned(), format!("{timeout_s} s, read back")));
        let servo = self.servo_remark.clone().map(|remark| ("servo".to_owned(), remark));
        watchdog_s.into_iter().chain(servo)
    }

    /// Makes the rig and checks the request against it.
    ///
    /// # Errors
    /// [`PlanError`], for whatever cannot be done as asked.
    pub fn new(request: &RunRequest) -> Result<Self, PlanError> {
        Self::with_drivers(request, &rigs::ALL)
    }

    /// The same with other drivers to choose from.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_drivers(request: &RunRequest, registry: Registry<'_>) -> Result<Self, PlanError> {
        let file = rigs::file(&request.rig)?;
        Self::on_rig(request, registry, &file).map_err(|error| match file.axis {
            Axis::Rotary => error,
            Axis::Linear => PlanError::OnLinearAxis(Axis::Linear.words(&error.to_string()).into_owned()),
        })
    }

    fn on_rig(request: &RunRequest, registry: Registry<'_>, file: &RigFile) -> Result<Self, PlanError> {
        let kind = rigs::driver(registry, file)?;
        if !(request.duration_s > 0.0 && request.duration_s <= LONGEST_DURATION_S) {
            return Err(PlanError::Duration(request.duration_s));
        }
        let last = crate::realtime::last_core();
        let core = request.pace.core.unwrap_or(last);
        if core > last {
            return Err(PlanError::Core { asked: core, last });
        }
        let drive = if request.torque { Drive::Torque } else { Drive::Position };
        let mut excitation = Excitation::named(&request.sweep, drive)?.on(file.axis);
        if let Some(amplitude) = request.amplitude {
            excitation = excitation.with_amplitude(amplitude)?;
        }
        let Rig { apparatus, simulated_knob } = (kind.make)(file, request)?;
        let mut rig = RigDescription { name: file.name.clone(), ..apparatus.description().clone() };
        if simulated_knob.is_some() {
            if let Some(limits) = file.limits {
                rig.limits = Limits { rate_hz: limits.rate_hz.min(rig.limits.rate_hz), ..limits };
            }
            if let Some(calibration) = file.calibration()? {
                rig.calibration = calibration;
            }
        }
        call_numbers(&rig)?;
        if let Some(path) = &request.rig.calibration {
            rig.calibration = Calibration::load(path)?;
        }
        rig.calibration.axis = file.axis;
        let rate_hz = request.pace.rate_hz;
        let slowest = rig.slowest_rate_hz.max(SLOWEST_RATE_HZ);
        if !(rate_hz >= slowest && rate_hz <= rig.limits.rate_hz) {
            return Err(PlanError::Rate { asked: rate_hz, rig: rig.name, slowest, fastest: rig.limits.rate_hz });
        }
        let control = ControlPlan {
            excitation,
            gains: gains(&rig, request, rate_hz),
            limits: rig.limits,
            rate_hz,
            planned_ticks: request.ticks(),
            stale_limit: rig.stale_limit,
        };
        if let (None, Drive::Position) = (&request.rendering, drive) {
            // What inertia a real knob has is not known before it is captured: with more than none the servo has it easier.
            let inertia = simulated_knob.as_ref().map_or(rig.calibration.motor_inertia, Model::inertia);
            check_servo(&control, &rig, inertia, |rate_hz| gains(&rig, request, rate_hz))?;
        }
        let rendering = request.rendering.as_ref().map(|asked| make_rendering(asked, &rig, rate_hz)).transpose()?;
        let knob = request.knob_name().to_owned();
        let has_servo = rendering.is_none() && simulated_knob.is_none();
        let servo_remark = has_servo.then(|| rattle(&control, &rig)).flatten();
        Ok(Self { apparatus, rig, control, knob, rendering, servo_remark, simulated_knob, core })
    }
}

/// The servo's gains on a rig at a rate.
fn gains(rig: &RigDescription, request: &RunRequest, rate_hz: f64) -> ServoGains {
    let gains = ServoGains::for_rig(&rig.calibration, rig.torque, rate_hz, rig.torque_late_ticks);
    match request.knob.as_deref().and_then(Fixture::named) {
        Some(Fixture::None) => gains.for_free_gripper(&rig.calibration),
        Some(Fixture::Locked) | None => gains,
    }
}

/// Least jump of the torque to report, as a share of the motor's limit.
const REPORTED_SHARE: f64 = 0.02;

/// What the encoder's step makes of the servo's torque, where it is more than a little.
fn rattle(control: &ControlPlan, rig: &RigDescription) -> Option<String> {
    let step_rad = rig.calibration.angle_step_rad;
    let jump_mnm = control.gains.jump_mnm(step_rad, control.rate_hz);
    (jump_mnm > REPORTED_SHARE * rig.limits.motor_torque_mnm).then(|| {
        format!(
            "each step of the encoder ({step_rad:.2e} rad) makes the servo's torque jump by {jump_mnm:.1} mNm; an \
             encoder with more counts reduces that"
        )
    })
}

/// Makes sure that the servo holds a knob of this inertia.
fn check_servo(
    control: &ControlPlan,
    rig: &RigDescription,
    knob_inertia: f64,
    gains_at: impl Fn(f64) -> ServoGains,
) -> Result<(), PlanError> {
    let ControlPlan { gains, rate_hz, .. } = *control;
    let holding = Holding { gains, calibration: &rig.calibration, knob_inertia };
    if holding.is_stable(rate_hz) {
        return Ok(());
    }
    let fastest_hz = rig.limits.rate_hz;
    let remedy = match holding.slowest_stable_hz(fastest_hz, gains_at) {
        Some(slowest_hz) => format!("give --rate-hz {slowest_hz} or more"),
        None => format!(
            "with a motor_inertia of {:.4} mNm·s²/rad it is unstable at every rate up to {fastest_hz} Hz; \
             `haptic-camera rig commission` measures the motor_inertia for [calibration]",
            rig.calibration.motor_inertia
        ),
    };
    Err(PlanError::Unstable { asked: rate_hz, remedy })
}

/// The model asked for, made ready to be rendered on the rig.
fn make_rendering(asked: &RenderingRequest, rig: &RigDescription, rate_hz: f64) -> Result<Rendering, PlanError> {
    let axis = rig.calibration.axis;
    let model = mounted_knob(&asked.model, axis, &rig.name)?;
    if rig.torque == TorqueSource::Motor {
        return Err(PlanError::NoTorqueSensor(rig.name.clone()));
    }
    if rig.calibration.motor_coulomb_mnm.is_none() {
        return Err(PlanError::Uncalibrated);
    }
    let firmness = |rate_hz| gains_for(&rig.calibration, &rig.limits, rate_hz, rig.torque_late_ticks / rate_hz);
    let rates = RENDERING_RATES_HZ.into_iter().filter(|other| *other <= rig.limits.rate_hz);
    let too_slow = || PlanError::TooSlow {
        asked: rate_hz,
        rig: rig.name.clone(),
        remedy: {
            let mut rates = rates.clone().filter(|other| firmness(*other).is_some());
            match (rates.clone().find(|other| *other > rate_hz), rates.next_back()) {
                (Some(other), _) | (None, Some(other)) => format!("give --rate-hz {other}"),
                (None, None) => "it cannot render at any rate that it holds; calibrate it again".to_owned(),
            }
        },
    };
    let Firmness { gains, bounds, share } = firmness(rate_hz).ok_or_else(too_slow)?;
    let softer = (share < 1.0).then(|| {
        let damping = |rate_hz| firmness(rate_hz).map_or(0.0, |other| other.gains.damping);
        let firmest = rates.clone().rev().max_by(|one, other| damping(*one).total_cmp(&damping(*other)));
        let remedy = firmest.filter(|other| damping(*other) > gains.damping);
        format!(
            "at {rate_hz} Hz rotor and gripper would oscillate on the torque sensor at the usual coupling stiffness: \
             the model is coupled by {:.2} of it{}",
            share * share,
            remedy.map_or_else(String::new, |other| format!("; --rate-hz {other} couples it more firmly"))
        )
    });
    let admission = Admission::new(bounds, &rig.calibration);
    let (model, Admitted { rendered, remarks }) = if asked.nearest {
        let Nearest { model, admitted, clipped } = admission.nearest(&model)?;
        let clipped = clipped.into_iter().map(|change| format!("clipped to the rig's limits: {change}"));
        (model, Admitted { remarks: clipped.chain(admitted.remarks).collect(), ..admitted })
    } else {
        let admitted = admission.admit(&model)?;
        (model, admitted)
    };
    let renderer =
        Renderer::new(rendered, gains, &rig.calibration, rig.limits.motor_torque_mnm, rate_hz).ok_or_else(too_slow)?;
    let remarks = softer.iter().chain(&remarks).map(|remark| axis.words(remark).into_owned()).collect();
    Ok(Rendering { model, renderer, gains, remarks, admission, without_remarks: asked.without_remarks })
}

/// The model of what is put on a rig of that axis: a knob, or what it is tried with instead.
///
/// # Errors
/// [`PlanError::Knob`], for a number that no shipped knob has and a file that is no model; [`PlanError::OtherAxis`].
pub(crate) fn mounted_knob(name: &str, axis: Axis, rig: &str) -> Result<Model, PlanError> {
    let model = match Fixture::named(name) {
        Some(fixture) => fixture.model_on(axis)?,
        None => knobs::named(name)?,
    };
    if model.axis == axis {
        return Ok(model);
    }
    Err(PlanError::OtherAxis { model: model.name, is: model.axis, rig: rig.to_owned(), has: axis })
}
