//! The state machine and the torque of one tick.

use dynamics::{Calibration, Drive, Excitation, Setpoint};
use hal::{ApparatusError, Limits, Measurement};
use shared_types::{Fault, LoopState, Sample};

use super::cogging::CoggingCompensation;
use super::rendering::{RenderedModel, Renderer, StepInput};
use super::servo::{Servo, ServoGains};
use super::tracking::Tracked;

/// A stall so long that the servo does not catch up with what was commanded meanwhile, s.
const STALL_S: f64 = 5e-3;
/// Time over which the angle that the excitation turns about returns to where the run began, s.
const RETURN_S: f64 = 0.2;
/// Time over which the torque comes up when the rig is armed, s.
const ARMING_S: f64 = 0.05;
/// Time over which the last torque gives way to braking at a stop, s.
const RELEASE_S: f64 = 0.02;
/// Time over which braking fades until the rig is torque-free, s.
const STOPPING_S: f64 = 0.2;

/// What a tick without an answer from the sensors measured: nothing.
const UNMEASURED: Measurement = Measurement {
    angle_rad: f64::NAN,
    acceleration_rad_s2: None,
    torque_mnm: f64::NAN,
    contact: None,
    after_s: 0.0,
    is_stale: true,
    stale_code: 0,
};

/// What a run consists of; plain data, made outside the real-time thread.
#[derive(Clone, Copy, Debug)]
pub struct ControlPlan {
    /// What is commanded.
    pub excitation: Excitation,
    /// The servo's gains.
    pub gains: ServoGains,
    /// What the rig must not exceed.
    pub limits: Limits,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Ticks of the run.
    pub planned_ticks: u64,
    /// Most ticks in a row in which the sensors may bring nothing new.
    pub stale_limit: u32,
    /// Ticks by which the effect of a torque shows later than on a rig that reads and drives at the tick.
    pub torque_late_ticks: f64,
}

/// What is asked of the state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Begin the run.
    Start,
    /// End it, ramping the torque down.
    Stop,
}

/// What was read at a tick.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Ticks since the previous step: one, or more after a stall.
    pub elapsed_ticks: u64,
    /// The sensors, or why there is nothing to read.
    pub measurement: Result<Measurement, ApparatusError>,
}

/// What a step gives.
#[derive(Clone, Copy, Debug)]
pub struct StepOutput {
    /// Torque for the motor, mNm, clipped to its limit.
    pub torque_mnm: f64,
    /// The sample to publish; `None` outside a run. Times and durations are left for the loop to fill in.
    pub sample: Option<Sample>,
}

/// What the motor is to do, and what is recorded of it.
struct Driven {
    torque_mnm: f64,
    commanded_angle_rad: f64,
    flags: u32,
}

/// Everything that one step passes to the next.
#[derive(Clone, Debug)]
pub struct ControlState {
    plan: ControlPlan,
    /// Feels like a model instead of following the excitation.
    renderer: Option<Renderer>,
    state: LoopState,
    fault: Option<Fault>,
    /// Ticks since the state was entered; within a run, the scheduled tick.
    tick: u64,
    missed_ticks: u64,
    next_seq: u64,
    start_angle_rad: f64,
    /// What the excitation turns about: where the run began, and for a while after a stall elsewhere.
    centre_rad: f64,
    /// Whether a stall has been, after which nothing new was measured yet.
    is_resuming: bool,
    tracked: Tracked,
    /// The rig's own code for the fault.
    device_code: i32,
    /// What the motor has done to the knob since the rig was armed, by its command, mNm·rad.
    work: f64,
    servo: Servo,
    cogging: CoggingCompensation,
    release_torque_mnm: f64,
    last_torque_mnm: f64,
}

impl ControlState {
    /// Idle, ready for `plan` on a rig with this calibration; `None` when the rate is too low for the filters.
    #[must_use]
    pub fn new(plan: ControlPlan, calibration: &Calibration) -> Option<Self> {
        Some(Self {
            plan,
            renderer: None,
            state: LoopState::Idle,
            fault: None,
            tick: 0,
            missed_ticks: 0,
            next_seq: 0,
            start_angle_rad: 0.0,
            centre_rad: 0.0,
            is_resuming: false,
            tracked: Tracked::new(&plan)?,
            device_code: 0,
            work: 0.0,
            servo: Servo::new(plan.gains, calibration, plan.rate_hz)?,
            cogging: CoggingCompensation::new(calibration, plan.rate_hz, plan.torque_late_ticks),
            release_torque_mnm: 0.0,
            last_torque_mnm: 0.0,
        })
    }

    /// The same, rendering a model instead of following the excitation.
    #[must_use]
    pub fn with_renderer(self, renderer: Renderer) -> Self {
        Self { renderer: Some(renderer), ..self }
    }

    /// Takes a model that is to be felt from now on; `Err` gives it back while the one before still waits, or when
    /// nothing is rendered.
    ///
    /// # Errors
    /// The model, when it is not taken.
    pub fn take_model(&mut self, model: Box<RenderedModel>) -> Result<(), Box<RenderedModel>> {
        match &mut self.renderer {
            Some(renderer) => renderer.take(model),
            None => Err(model),
        }
    }

    /// A model that is no longer rendered, to be freed outside the real-time thread.
    pub fn retired_model(&mut self) -> Option<Box<RenderedModel>> {
        self.renderer.as_mut().and_then(Renderer::retired)
    }

    /// What is rendered, if anything.
    #[must_use]
    pub fn renderer(&self) -> Option<&Renderer> {
        self.renderer.as_ref()
    }

    /// The state the loop is in.
    #[must_use]
    pub fn state(&self) -> LoopState {
        self.state
    }

    /// Whether it is armed and nothing was read so far: there is no angle to hold, nor one to begin a run at.
    #[must_use]
    pub fn awaits_reading(&self) -> bool {
        self.state == LoopState::Armed && self.tick == 0
    }

    /// Why the loop went torque-free, if it did.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// The rig's own code for the fault, 0 for none.
    #[must_use]
    pub fn device_code(&self) -> i32 {
        self.device_code
    }

    /// Arms the loop, which holds the angle found at the next step. The amplifier must be on.
    pub fn arm(&mut self) {
        if self.state == LoopState::Idle {
            self.enter(LoopState::Armed);
            self.work = 0.0;
            self.tracked.forget_angle();
        }
    }

    /// Takes up a request; `false` when the state does not permit it.
    pub fn request(&mut self, request: Request) -> bool {
        match (request, self.state) {
            (Request::Start, LoopState::Armed) if !self.awaits_reading() => {
                self.next_seq = 0;
                if self.renderer.is_some() {
                    // A rendering follows from its samples alone: nothing from before the run has a part in it.
                    self.tracked.forget_motion();
                }
                self.enter(LoopState::Running);
                true
            }
            // No torque was given.
            (Request::Stop, LoopState::Armed) if self.awaits_reading() => {
                self.enter(LoopState::Idle);
                true
            }
            (Request::Stop, LoopState::Armed | LoopState::Running) => {
                self.release_torque_mnm = self.last_torque_mnm;
                self.enter(LoopState::Stopping);
                true
            }
            _ => false,
        }
    }

    /// One tick: torque and sample from what was read.
    pub fn step(&mut self, reading: &Reading) -> StepOutput {
        // The rig is off, so that its not answering is no fault.
        if self.state == LoopState::Idle {
            return StepOutput { torque_mnm: 0.0, sample: None };
        }
        self.account_for_missed_ticks(reading.elapsed_ticks);
        let measurement = match reading.measurement {
            Ok(measurement) => measurement,
            Err(error) => {
                if self.state != LoopState::Fault {
                    self.device_code = error.device_code().unwrap_or(0);
                }
                let is_watchdog = error == ApparatusError::Watchdog;
                return self.fail(if is_watchdog { Fault::Watchdog } else { Fault::Apparatus }, &UNMEASURED);
            }
        };
        let measurement = match self.tracked.take(&measurement, reading.elapsed_ticks) {
            Ok(Some((measurement, turned_rad))) => {
                self.work += self.last_torque_mnm * turned_rad;
                measurement
            }
            // Before the first one there is nothing to hold.
            Ok(None) => return StepOutput { torque_mnm: 0.0, sample: None },
            Err(Fault::Stale) => return self.fail(Fault::Stale, &UNMEASURED),
            Err(fault) => return self.fail(fault, &measurement),
        };

        match self.state {
            LoopState::Idle | LoopState::Fault => self.silent(0.0),
            LoopState::Armed => {
                if self.tick == 0 {
                    self.start_angle_rad = measurement.angle_rad;
                    self.centre_rad = measurement.angle_rad;
                }
                let rise = (self.seconds(self.tick) / ARMING_S).min(1.0);
                // A motor or an encoder of the wrong sign shows here first.
                let held_rad = if self.holds() { self.start_angle_rad } else { f64::NAN };
                if let Some(fault) = self.exceeded(&measurement, held_rad) {
                    return self.fail(fault, &measurement);
                }
                let hold = Setpoint { value: self.start_angle_rad, ..Setpoint::default() };
                let torque = match self.plan.excitation.drive {
                    // Free, until the run begins where the hand holds it.
                    _ if self.renderer.is_some() => 0.0,
                    Drive::Position => rise * self.follow(&hold, &measurement, reading.elapsed_ticks),
                    Drive::Torque => 0.0,
                };
                self.silent(torque)
            }
            LoopState::Running => self.run(&measurement, reading),
            LoopState::Stopping => {
                if let Some(fault) = self.exceeded(&measurement, f64::NAN) {
                    return self.fail(fault, &measurement);
                }
                let time_s = self.seconds(self.tick);
                if time_s >= if self.holds() { STOPPING_S } else { RELEASE_S } {
                    self.enter(LoopState::Idle);
                    return StepOutput { torque_mnm: 0.0, sample: None };
                }
                let release = (1.0 - time_s / RELEASE_S).max(0.0);
                let brake = (1.0 - time_s / STOPPING_S) * (1.0 - release);
                // A run without a servo ends without one: a motor or an encoder of the wrong sign would turn ever faster.
                let braking_mnm = match self.holds() {
                    true => self.servo.braking_mnm(self.tracked.difference_rad_s(), reading.elapsed_ticks),
                    false => 0.0,
                };
                self.silent(release * self.release_torque_mnm + brake * braking_mnm)
            }
        }
    }

    fn run(&mut self, measurement: &Measurement, reading: &Reading) -> StepOutput {
        self.is_resuming |= self.seconds(self.missed_ticks) > STALL_S;
        if self.is_resuming {
            self.resume_at(measurement.angle_rad);
        }
        let Driven { torque_mnm: torque, commanded_angle_rad, flags } = self.driven(measurement, reading.elapsed_ticks);
        if let Some(fault) = self.exceeded(measurement, commanded_angle_rad) {
            return self.fail(fault, measurement);
        }
        let clipped = self.clip(torque);
        let flags = if clipped == torque { flags } else { flags | Sample::TORQUE_CLIPPED };
        let sample = self.sample(measurement, clipped, commanded_angle_rad, flags);
        self.last_torque_mnm = clipped;
        self.next_seq += 1;
        self.tick += 1;
        if self.tick >= self.plan.planned_ticks {
            self.release_torque_mnm = clipped;
            self.enter(LoopState::Stopping);
        }
        StepOutput { torque_mnm: clipped, sample: Some(sample) }
    }

    /// Continues after a stall from where the knob is, and returns from there little by little: making up for the missed motion at
    /// once would take more than the limits allow. The motor's work during the stall is not known either, so that no runaway is
    /// reported after it.
    fn resume_at(&mut self, angle_rad: f64) {
        self.centre_rad = angle_rad - self.plan.excitation.at(self.seconds(self.tick)).value;
        self.work = f64::INFINITY;
        self.is_resuming = self.tracked.is_stale();
    }

    /// What the motor is to do in this tick of a run.
    fn driven(&mut self, measurement: &Measurement, elapsed_ticks: u64) -> Driven {
        let (time_s, step_s) = (self.seconds(self.tick), self.seconds(1));
        if let Some(renderer) = &mut self.renderer {
            if self.tick == 0 {
                renderer.begin(measurement.angle_rad);
            }
            let rendered = renderer.step(&StepInput {
                measurement,
                velocity_rad_s: self.tracked.difference_rad_s(),
                // As it is recorded: what passed before the run is no part of it.
                elapsed_ticks: self.missed_ticks + 1,
                time_s,
                step_s,
            });
            return Driven {
                torque_mnm: rendered.torque_mnm + self.against_cogging_mnm(measurement),
                commanded_angle_rad: rendered.angle_rad,
                flags: rendered.flags(),
            };
        }
        let setpoint = self.plan.excitation.at(time_s);
        match self.plan.excitation.drive {
            Drive::Position => {
                let back_rad_s = (self.start_angle_rad - self.centre_rad) / RETURN_S;
                self.centre_rad += back_rad_s * step_s;
                let absolute =
                    Setpoint { value: self.centre_rad + setpoint.value, rate: setpoint.rate + back_rad_s, ..setpoint };
                Driven {
                    torque_mnm: self.follow(&absolute, measurement, elapsed_ticks),
                    commanded_angle_rad: absolute.value,
                    flags: 0,
                }
            }
            Drive::Torque => Driven { torque_mnm: setpoint.value, commanded_angle_rad: f64::NAN, flags: 0 },
        }
    }

    fn follow(&mut self, setpoint: &Setpoint, measurement: &Measurement, elapsed_ticks: u64) -> f64 {
        self.servo.torque_mnm(setpoint, measurement, self.tracked.difference_rad_s(), elapsed_ticks)
            + self.against_cogging_mnm(measurement)
    }

    fn against_cogging_mnm(&self, measurement: &Measurement) -> f64 {
        self.cogging.torque_mnm(measurement.angle_rad, self.tracked.difference_rad_s())
    }

    /// The limit that the measurement exceeds. A measurement of an earlier tick was judged in that tick: the command has moved on
    /// since, and the number of ticks without new data has a limit of its own.
    fn exceeded(&self, measurement: &Measurement, commanded_angle_rad: f64) -> Option<Fault> {
        if self.tracked.is_stale() {
            return None;
        }
        let limits = &self.plan.limits;
        let turned_rad = measurement.angle_rad - self.start_angle_rad;
        let behind_rad = measurement.angle_rad - commanded_angle_rad;
        if measurement.torque_mnm.abs() > limits.sensor_torque_mnm {
            Some(Fault::Torque)
        } else if self.tracked.limited_speed_rad_s().abs() > limits.speed_rad_s {
            Some(Fault::Speed)
        } else if turned_rad.abs() > limits.angle_rad {
            Some(Fault::Angle)
        } else if behind_rad.abs() > limits.following_error_rad {
            Some(Fault::FollowingError)
        } else {
            None
        }
        .map(|fault| if self.has_run_away(fault) { Fault::Runaway } else { fault })
    }

    /// Whether an angle is to be followed.
    fn holds(&self) -> bool {
        self.renderer.is_none() && self.plan.excitation.drive == Drive::Position
    }

    /// Whether the fault is a runaway: the motor's work on the knob is negative. A knob gives back no more energy than it received,
    /// so that something else turns it against the motor, or the motor or the encoder has the wrong sign.
    fn has_run_away(&self, fault: Fault) -> bool {
        self.holds() && fault != Fault::Torque && self.work < 0.0
    }

    /// Goes torque-free; within a run the sample that shows the cause is the last one.
    fn fail(&mut self, fault: Fault, measurement: &Measurement) -> StepOutput {
        self.last_torque_mnm = 0.0;
        if self.state == LoopState::Fault {
            return StepOutput { torque_mnm: 0.0, sample: None };
        }
        if fault == Fault::Stale {
            self.device_code = self.tracked.stale_code();
        }
        let running = self.state == LoopState::Running;
        self.state = LoopState::Fault;
        self.fault = Some(fault);
        let sample = running.then(|| self.sample(measurement, 0.0, f64::NAN, 0));
        self.next_seq += u64::from(running);
        StepOutput { torque_mnm: 0.0, sample }
    }

    /// Moves the tick on over what was missed.
    ///
    /// Nothing is missed between a request and the first tick of the state it leads to. A stall
    /// over the end of a run ends it at its last tick, so that samples and missed ticks add up to
    /// what was planned.
    fn account_for_missed_ticks(&mut self, elapsed_ticks: u64) {
        let skipped = if self.tick == 0 { 0 } else { elapsed_ticks.saturating_sub(1) };
        let expected = self.tick;
        self.tick += skipped;
        if self.state == LoopState::Running {
            self.tick = self.tick.min(self.plan.planned_ticks.saturating_sub(1));
        }
        self.missed_ticks = self.tick - expected;
    }

    fn silent(&mut self, torque_mnm: f64) -> StepOutput {
        self.tick += 1;
        self.last_torque_mnm = self.clip(torque_mnm);
        StepOutput { torque_mnm: self.last_torque_mnm, sample: None }
    }

    fn sample(
        &self,
        measurement: &Measurement,
        commanded_torque_mnm: f64,
        commanded_angle_rad: f64,
        flags: u32,
    ) -> Sample {
        let Measurement { angle_rad, acceleration_rad_s2, torque_mnm, contact, after_s, is_stale: _, stale_code: _ } =
            *measurement;
        Sample {
            seq: self.next_seq,
            tick: self.tick,
            angle_rad,
            velocity_rad_s: self.tracked.velocity_rad_s(),
            acceleration_rad_s2: acceleration_rad_s2.unwrap_or(f64::NAN),
            torque_mnm,
            contact: contact.map_or(f64::NAN, |closed| f64::from(u8::from(closed))),
            measured_after_s: after_s,
            commanded_angle_rad,
            commanded_torque_mnm,
            missed_ticks: u32::try_from(self.missed_ticks).unwrap_or(u32::MAX),
            state: self.state.code(),
            fault: self.fault.map_or(0, Fault::code),
            flags: if self.tracked.is_stale() { flags | Sample::STALE } else { flags },
            device_code: if self.device_code == 0 { self.tracked.stale_code() } else { self.device_code }
                .cast_unsigned(),
            stale_ticks: self.tracked.stale_ticks(),
            ..Sample::default()
        }
    }

    fn clip(&self, torque_mnm: f64) -> f64 {
        let limit = self.plan.limits.motor_torque_mnm;
        torque_mnm.clamp(-limit, limit)
    }

    fn enter(&mut self, state: LoopState) {
        self.state = state;
        self.tick = 0;
    }

    fn seconds(&self, ticks: u64) -> f64 {
        ticks as f64 / self.plan.rate_hz
    }
}
