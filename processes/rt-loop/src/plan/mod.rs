//! What the process was asked to do, checked against the rig.

mod error;
mod rendering;

use dynamics::knobs::Fixture;
use dynamics::{Axis, Calibration, Drive, Excitation, Model, knobs};
use hal::{Apparatus, Limits, RigDescription, RigFile};
use shared_types::rig::{monotonic_time_ns, wall_clock_time_ns};
use shared_types::{ClockMapping, RunDescription};

use crate::control::{ControlPlan, Holding, ServoGains};
use crate::realtime::call_numbers;
use crate::recomputation::ControlDescription;
use crate::request::{LONGEST_DURATION_S, RunRequest};
use crate::rigs::{self, Registry, Rig};
pub use error::PlanError;
pub use rendering::Rendering;

/// Slowest rate at which a knob is captured, Hz: the paper's sweep goes to some hertz, and detents pass tens of times a second.
const SLOWEST_RATE_HZ: f64 = 500.0;
/// Of a watchdog that was not read back.
const UNKNOWN_WATCHDOG: &str = "not read back: unless the amplifier has one, the torque stays on if this program dies";

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
    /// What readers of the capture should know of the servo, in a sentence.
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
            torque_late_ticks: Some(self.rig.torque_late_ticks + self.rig.angle_delay_s * self.control.rate_hz),
            excitation_toml: toml::to_string(&self.control.excitation)?,
            calibration_toml: self.rig.calibration_of_torque().to_toml(),
            simulated_knob_toml: self.simulated_knob.as_ref().map(Model::to_toml),
            rendered_model_toml: self.rendering.as_ref().map(|rendering| rendering.model.to_toml()),
            control_toml: Some(toml::to_string(&ControlDescription {
                rate_hz: self.control.rate_hz,
                planned_ticks: self.control.planned_ticks,
                limits: self.control.limits,
                torque_late_ticks: self.control.torque_late_ticks,
                guard_late_ticks: self.control.torque_late_ticks,
                servo_gains: self.control.gains,
                render_gains: self.rendering.as_ref().map(|rendering| rendering.gains),
            })?),
            device_codes: self.rig.codes.clone(),
            notes: self.notes().chain(self.rig.notes.iter().cloned()).chain(remarks).collect(),
        })
    }

    /// What the rig says once it is prepared, and what is to be known of the servo.
    fn notes(&self) -> impl Iterator<Item = (String, String)> {
        let watchdog = self.watchdog().map(|said| ("watchdog".to_owned(), said));
        let servo = self.servo_remark.clone().map(|remark| ("servo".to_owned(), remark));
        watchdog.into_iter().chain(servo)
    }

    /// What is known of the amplifier's watchdog; `None` for a rig that is no device.
    fn watchdog(&self) -> Option<String> {
        let read_back = self.rig.watchdog_s.map(|timeout_s| format!("{timeout_s} s, read back"));
        read_back.or_else(|| self.rig.device.is_some().then(|| UNKNOWN_WATCHDOG.to_owned()))
    }

    /// The remark on an amplifier of which no watchdog is known.
    pub(crate) fn watchdog_remark(&self) -> Option<String> {
        self.watchdog()
            .filter(|said| said == UNKNOWN_WATCHDOG)
            .map(|said| format!("the watchdog of the rig '{}' is {said}", self.rig.name))
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
            let is = rig.calibration.axis;
            if is != file.axis {
                return Err(PlanError::CalibrationOfOtherAxis {
                    path: path.clone(),
                    is,
                    rig: rig.name,
                    has: file.axis,
                });
            }
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
            torque_late_ticks: rig.late_ticks(rate_hz),
        };
        if let (None, Drive::Position) = (&request.rendering, drive) {
            // A real knob's inertia is unknown before its capture: the motor's stands in for it. Any inertia makes the servo's task easier than none.
            let inertia = simulated_knob.as_ref().map_or(rig.calibration.motor_inertia, Model::inertia);
            check_servo(&control, &rig, inertia, |rate_hz| gains(&rig, request, rate_hz))?;
        }
        let rendering = request.rendering.as_ref().map(|asked| Rendering::new(asked, &rig, rate_hz)).transpose()?;
        let knob = request.knob_name().to_owned();
        let has_servo = rendering.is_none() && simulated_knob.is_none();
        let servo_remark = has_servo.then(|| rattle(&control, &rig)).flatten();
        Ok(Self { apparatus, rig, control, knob, rendering, servo_remark, simulated_knob, core })
    }
}

/// The servo's gains on a rig at a rate.
fn gains(rig: &RigDescription, request: &RunRequest, rate_hz: f64) -> ServoGains {
    let gains = ServoGains::for_rig(&rig.calibration, rig.torque, rate_hz, rig.late_ticks(rate_hz));
    match request.knob.as_deref().and_then(Fixture::named) {
        Some(Fixture::None) => gains.for_free_gripper(&rig.calibration),
        Some(Fixture::Locked) | None => gains,
    }
}

/// Least jump of the torque to report, as a share of the motor's limit.
const REPORTED_SHARE: f64 = 0.02;

/// The jump of the servo's torque at a step of the encoder, in a sentence; `None` up to [`REPORTED_SHARE`].
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
    let holding = Holding { gains, rig, knob_inertia };
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

/// The model of what is put on a rig of that axis: a knob, or a fixture in its place.
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
