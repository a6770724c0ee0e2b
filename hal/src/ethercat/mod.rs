//! Servo drives with the profile CiA 402 on EtherCAT, and whatever else is on their bus.
//!
//! The drive runs in cyclic synchronous torque; angle, torque and acceleration come from any entry of any device's process data.
//! ethercrab speaks the protocol, without its `std` part: frames go out and come back over a socket of our own, so that a tick
//! costs one system call and no memory. Two threads have the bus in turn: from preparation until the rig is enabled, an ordinary
//! thread keeps the bus alive, since a device without process data takes itself out of operation.

mod bring_up;
mod bus;
mod codes;
mod drive;
mod entries;
mod interface;
mod keeper;
mod scan;
mod settings;
mod socket;
mod time;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

pub use bring_up::BringUpError;
use bring_up::{Asked, start};
use bus::{Bus, Cycle, DriveCommand};
use drive::{DISABLE_VOLTAGE, DriveState, ENABLE_OPERATION};
pub use entries::Entry;
use entries::Source;
use keeper::{Keeper, Pace};
pub use scan::{knows, scan};
pub use settings::{Device, Settings, Startup};
use shared_types::rig::monotonic_time_ns;

use crate::channels::Wiring;
use crate::{
    Apparatus, ApparatusError, DeclaredCalls, MOST_CHANNELS, Measurement, RawMeasurement, RigDescription, RigFile,
    RigFileError,
};

/// A rig file to begin with.
pub const TEMPLATE: &str = include_str!("template.toml");

/// Share of a period that a tick waits for its frame.
const WAIT_SHARE: f64 = 0.6;
/// Cycles within which a drive that is switched on enables its operation.
const ENABLE_CYCLES: u32 = 200;
/// Cycles in which the drive is asked to let go of the motor, until it says that it has.
const DISABLE_CYCLES: u32 = 3;
/// Calls in the tick of a fault, which makes the most: the exchange, and the question why a device left OP.
const MOST_CALLS: u32 = 2;
/// Time that the drive may take to be switched on.
const SWITCHING_ON: Duration = Duration::from_secs(15);

/// Who has the bus.
enum Stage {
    /// Nobody: it is not up.
    Down,
    /// The thread that keeps it alive.
    Kept(Keeper),
    /// The control loop.
    Running(Box<Bus>),
}

/// A CiA 402 drive on EtherCAT.
pub struct EthercatRig {
    description: RigDescription,
    settings: Settings,
    sources: Vec<Source>,
    wiring: Wiring,
    rate_hz: f64,
    asked_watchdog_s: f64,
    stage: Stage,
    /// The torque that a target of 1000 stands for, mNm; known once the rig is prepared.
    rated_torque_mnm: f64,
    /// Ticks in a row without a whole exchange.
    amiss: u32,
    pace: Pace,
    shift_ns: i64,
    /// The torques of the exchange before the last one and of the last one, mNm.
    sent_mnm: [f64; 2],
    is_on: bool,
}

impl EthercatRig {
    /// The rig of a file, for a run at `rate_hz`; the bus stays as it is.
    ///
    /// # Errors
    /// [`RigFileError`] for settings and channels that cannot be used.
    pub fn new(file: &RigFile, rate_hz: f64) -> Result<Self, RigFileError> {
        let settings: Settings = file.settings()?;
        let channels = file.needed_channels()?;
        let mut names = Vec::new();
        for name in channels.sources() {
            if !names.contains(name) {
                names.push(name.clone());
            }
        }
        let sources = names.iter().map(|name| name.parse()).collect::<Result<Vec<Source>, String>>();
        let sources = sources.map_err(|error| file.error(error))?;
        if channels.angle.wraps_at.is_some() && channels.angle.source.ends_with(".position") {
            return Err(file.error(format!(
                "[channels.angle] wraps_at is for the entry of an encoder, but {} goes on counting by itself; leave wraps_at out",
                channels.angle.source
            )));
        }
        let above_zero = |value: f64| value.is_finite() && value > 0.0;
        let scales = [("rated_torque_mnm", settings.rated_torque_mnm), ("counts_per_turn", settings.counts_per_turn)];
        if let Some((key, Some(value))) =
            scales.into_iter().find(|(_, value)| value.is_some_and(|value| !above_zero(value)))
        {
            return Err(file.error(format!("[settings] {key} is {value}, but it must be above zero, and finite")));
        }
        let wiring = channels.wire(&names).map_err(|error| file.error(error))?.held_between_exchanges(rate_hz);
        let description = file.description(&wiring)?;
        let asked_watchdog_s = file.needed_watchdog()?.timeout_s;
        let mut notes = description.notes;
        notes.push(("interface".to_owned(), settings.interface.clone()));
        // Devices whose clocks are kept together take inputs at the SYNC0 before a frame, and outputs at the one after it.
        let waits_ticks = if settings.distributed_clocks { 1.0 } else { 0.0 };
        let description = RigDescription {
            torque_late_ticks: description.torque_late_ticks + waits_ticks,
            // A scan knows the bus by this name too.
            device: Some(settings.interface.clone()),
            calls: DeclaredCalls { names: vec!["sendto".to_owned()], per_tick: MOST_CALLS },
            codes: codes::all(),
            notes,
            ..description
        };
        Ok(Self {
            description,
            settings,
            sources,
            wiring,
            rate_hz,
            asked_watchdog_s,
            stage: Stage::Down,
            rated_torque_mnm: 1.0,
            amiss: 0,
            pace: Pace::new(rate_hz),
            shift_ns: 0,
            sent_mnm: [0.0; 2],
            is_on: false,
        })
    }

    /// Takes the bus up and the drive to "switched on".
    fn bring_up(&mut self, stop: &dyn Fn() -> bool) -> Result<Bus, BringUpError> {
        let asked = Asked {
            settings: &self.settings,
            sources: &self.sources,
            rate_hz: self.rate_hz,
            watchdog_s: self.asked_watchdog_s,
        };
        let (mut bus, rest) = start(&asked, stop)?;
        self.rated_torque_mnm = rest.rated_torque_mnm;
        self.description.watchdog_s = Some(rest.watchdog_s);
        self.description.notes.extend(rest.notes);
        let switched_on = self.switch_on(&mut bus, stop);
        if switched_on.is_err() {
            bus.leave();
        }
        switched_on.map(|()| bus)
    }

    /// Exchanges process data until the drive is switched on.
    fn switch_on(&mut self, bus: &mut Bus, stop: &dyn Fn() -> bool) -> Result<(), BringUpError> {
        let until_ns = monotonic_time_ns() + SWITCHING_ON.as_nanos() as u64;
        let mut pace = Pace::new(self.rate_hz);
        let mut controlword = DISABLE_VOLTAGE;
        loop {
            let cycle = pace.cycle(bus, DriveCommand { controlword, target_torque: 0 });
            let is_late = monotonic_time_ns() > until_ns;
            if stop() {
                return Err(BringUpError::Stopped);
            }
            let Ok(cycle) = cycle else {
                match is_late {
                    true => return Err(BringUpError::Silent(self.settings.interface.clone())),
                    false => continue,
                }
            };
            let state = DriveState::of(bus.statusword());
            let is_operational = cycle.fallen.is_none() && cycle.is_complete;
            if is_operational && matches!(state, DriveState::SwitchedOn | DriveState::OperationEnabled) {
                return self.check_mode(bus);
            }
            if is_late {
                let code = match cycle.fallen {
                    Some(device) => bus.why_fallen(device, monotonic_time_ns() + 10_000_000),
                    None if state == DriveState::Fault => codes::of_drive(bus.error_code()),
                    None if !cycle.is_complete => codes::WORKING_COUNTER,
                    None => codes::NOT_SWITCHED_ON,
                };
                return Err(BringUpError::State {
                    device: entries::DRIVE.to_owned(),
                    state: "'switched on'",
                    reason: ApparatusError::Device(code).reason(&self.description.codes),
                });
            }
            if is_operational {
                controlword = state.towards_switched_on(controlword != DISABLE_VOLTAGE);
            }
        }
    }

    fn check_mode(&self, bus: &Bus) -> Result<(), BringUpError> {
        match bus.other_mode() {
            Some(mode) => Err(BringUpError::Unsuitable {
                device: entries::DRIVE.to_owned(),
                what: format!(
                    "stays in mode {mode} instead of cyclic synchronous torque ({}); check its settings",
                    bus.mode
                ),
            }),
            None => Ok(()),
        }
    }

    fn wait_ns(&self) -> u64 {
        (WAIT_SHARE * 1e9 / self.rate_hz) as u64
    }

    /// Counts a tick without a whole exchange, which is an error beyond the limit.
    fn tolerate(&mut self, code: i32) -> Result<Measurement, ApparatusError> {
        self.amiss += 1;
        match self.amiss > self.description.stale_limit {
            true => Err(ApparatusError::Device(code)),
            false => Ok(Measurement::stale(code)),
        }
    }

    /// What a whole exchange brought.
    fn measured(wiring: &mut Wiring, bus: &Bus, cycle: &Cycle, due_ns: u64, acting_mnm: f64) -> Measurement {
        let mut raw = RawMeasurement { values: [0.0; MOST_CHANNELS], valid: u32::MAX, after_s: 0.0 };
        for (index, value) in raw.values.iter_mut().enumerate().take(bus.channels.len()) {
            *value = bus.channel(index);
        }
        let after_ns = cycle.time_ns.wrapping_sub(due_ns).cast_signed();
        // Devices that are kept together take their inputs at SYNC0, others when they have the frame.
        raw.after_s = (after_ns - cycle.after_sync_ns.unwrap_or(0).cast_signed()) as f64 * 1e-9;
        wiring.measurement(&raw, acting_mnm)
    }
}

/// A torque as the drive takes it, in thousandths of the rated torque.
fn thousandths(torque_mnm: f64, rated_torque_mnm: f64) -> i16 {
    (torque_mnm / rated_torque_mnm * 1e3).round() as i16
}

impl Apparatus for EthercatRig {
    fn description(&self) -> &RigDescription {
        &self.description
    }

    fn prepare(&mut self, stop: &dyn Fn() -> bool) -> Result<(), ApparatusError> {
        // ethercrab 0.7 panics at a message that a device sends of its own accord between a question and its answer.
        let brought_up = catch_unwind(AssertUnwindSafe(|| self.bring_up(stop)));
        match brought_up.unwrap_or(Err(BringUpError::Interrupted)) {
            Ok(bus) => {
                self.stage = Stage::Kept(Keeper::start(bus, self.rate_hz));
                Ok(())
            }
            Err(BringUpError::Stopped) => Err(ApparatusError::Stopped),
            Err(error) => {
                self.description.codes.push((codes::BRING_UP, error.to_string()));
                Err(ApparatusError::Device(codes::BRING_UP))
            }
        }
    }

    fn enable(&mut self) -> Result<(), ApparatusError> {
        let Stage::Kept(keeper) = std::mem::replace(&mut self.stage, Stage::Down) else {
            return Err(ApparatusError::Amplifier);
        };
        let Some(mut bus) = keeper.hand_over() else { return Err(ApparatusError::Amplifier) };
        self.is_on = true;
        let mut enabled = Err(ApparatusError::Device(codes::NOT_SWITCHED_ON));
        for _ in 0..ENABLE_CYCLES {
            let Ok(cycle) = self.pace.cycle(&mut bus, DriveCommand { controlword: ENABLE_OPERATION, target_torque: 0 })
            else {
                enabled = Err(ApparatusError::Device(codes::LOST));
                continue;
            };
            if let Some(device) = cycle.fallen {
                enabled = Err(ApparatusError::Device(bus.why_fallen(device, monotonic_time_ns() + 10_000_000)));
                break;
            }
            match DriveState::of(bus.statusword()) {
                DriveState::OperationEnabled => {
                    enabled = Ok(());
                    break;
                }
                DriveState::Fault | DriveState::FaultReaction => {
                    enabled = Err(ApparatusError::Device(codes::of_drive(bus.error_code())));
                    break;
                }
                _ => enabled = Err(ApparatusError::Device(codes::NOT_SWITCHED_ON)),
            }
        }
        self.stage = Stage::Running(bus);
        enabled
    }

    fn disable(&mut self) {
        if !std::mem::take(&mut self.is_on) {
            return;
        }
        let wait_ns = self.wait_ns();
        let Stage::Running(bus) = &mut self.stage else { return };
        for _ in 0..DISABLE_CYCLES {
            let command = DriveCommand { controlword: DISABLE_VOLTAGE, target_torque: 0 };
            let has_let_go = bus.cycle(command, monotonic_time_ns() + wait_ns).is_ok()
                && !matches!(DriveState::of(bus.statusword()), DriveState::OperationEnabled | DriveState::QuickStop);
            if has_let_go {
                break;
            }
        }
        // No process data come from here on: a device that stayed in OP would report that its watchdog ran out.
        bus.leave();
    }

    fn exchange(&mut self, due_ns: u64, torque_mnm: f64) -> Result<Measurement, ApparatusError> {
        let target_torque = thousandths(self.wiring.of_motor(torque_mnm), self.rated_torque_mnm);
        let wait_ns = self.wait_ns();
        let [before_mnm, last_mnm] = self.sent_mnm;
        self.sent_mnm = [last_mnm, torque_mnm];
        // Devices whose clocks are kept together take their outputs a period later than others.
        let acting_mnm = if self.settings.distributed_clocks { before_mnm } else { last_mnm };
        // A tick that does not hear of the devices' clocks follows the machine's.
        self.shift_ns = 0;
        let Stage::Running(bus) = &mut self.stage else { return Err(ApparatusError::Amplifier) };
        let until_ns = monotonic_time_ns() + wait_ns;
        let cycle = match bus.cycle(DriveCommand { controlword: ENABLE_OPERATION, target_torque }, until_ns) {
            Ok(cycle) => cycle,
            Err(bus::Unanswered::GaveUp) => return self.tolerate(codes::LOST),
            Err(bus::Unanswered::NotSent) => return self.tolerate(codes::NOT_SENT),
        };
        if let Some(device) = cycle.fallen {
            return Err(ApparatusError::Device(bus.why_fallen(device, monotonic_time_ns() + wait_ns)));
        }
        if !cycle.is_complete {
            return self.tolerate(codes::WORKING_COUNTER);
        }
        match DriveState::of(bus.statusword()) {
            // In another mode the target is not taken, or is no torque.
            DriveState::OperationEnabled if bus.other_mode().is_some() => {
                return Err(ApparatusError::Device(codes::OTHER_MODE));
            }
            DriveState::OperationEnabled => {}
            DriveState::Fault | DriveState::FaultReaction => {
                return Err(ApparatusError::Device(codes::of_drive(bus.error_code())));
            }
            _ => return Err(ApparatusError::Device(codes::NOT_ENABLED)),
        }
        self.shift_ns = cycle.after_sync_ns.map_or(0, |after_ns| self.pace.shift_ns(after_ns));
        self.amiss = 0;
        let Stage::Running(bus) = &self.stage else { return Err(ApparatusError::Amplifier) };
        Ok(Self::measured(&mut self.wiring, bus, &cycle, due_ns, acting_mnm))
    }

    fn shift_ns(&self) -> i64 {
        self.shift_ns
    }

    fn obstacles(&self) -> Vec<String> {
        interface::obstacles(&self.settings.interface)
    }
}

impl Drop for EthercatRig {
    fn drop(&mut self) {
        self.disable();
        match std::mem::replace(&mut self.stage, Stage::Down) {
            Stage::Down => {}
            Stage::Kept(keeper) => {
                if let Some(mut bus) = keeper.hand_over() {
                    bus.leave();
                }
            }
            Stage::Running(mut bus) => bus.leave(),
        }
    }
}
