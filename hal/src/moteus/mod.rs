//! A motor behind a moteus controller, over an fdcanusb adapter, its UART, or SocketCAN.
//!
//! One frame a tick gives the torque of the tick before and asks for the sensors' readings. The loop waits for the answer, a
//! share of the period at most, and sleeps meanwhile: if it spun, it would keep the kernel's worker that carries a tty's bytes
//! off the core. Readings are dated half way between question and answer. If an answer takes much longer than usual, it or the
//! question was delayed; it counts as missing, since its date would be wrong. Successive frames have different sender
//! identifiers, so that a late answer is not taken for the next one.
//!
//! The torque goes in the controller's position mode with all gains at zero, since that mode alone takes the watchdog's time with
//! every command. [`MoteusRig::prepare`] lets the watchdog run out once and sees that it does.
//!
//! <https://mjbots.github.io/moteus/protocol/registers/>

mod bring_up;
mod can;
mod codes;
mod conversation;
mod link;
mod registers;
mod scan;
mod tty;

use std::time::Duration;

use bring_up::{BroughtUp, bring_up};
use conversation::{Conversation, gone};
use link::{CALLS, Heard, Link};
use moteus_protocol::Mode;
use nix::time::{ClockId, clock_gettime};
use registers::{Address, CHANNELS, Drive, Query, Reply};
pub use scan::{ScanError, is_port, scan};
use serde::Deserialize;

use crate::channels::Wiring;
use crate::{
    Apparatus, ApparatusError, DeclaredCalls, Measurement, RawMeasurement, RigDescription, RigFile, RigFileError,
};

/// A rig file to begin with.
pub const TEMPLATE: &str = include_str!("template.toml");

/// Bits a second of a controller's UART, as it comes.
const USUAL_BAUD: u32 = 921_600;
/// Sender identifiers of a run's frames, used in turn: 1 to this.
const TAGS: i8 = 16;
/// Share of a period for which an answer is waited for: the rest is for the control step, and for a loop that begins late.
const WAITED_SHARE: f64 = 0.6;
/// How often a stop is sent.
const STOPS: u32 = 3;
/// Most looks for an answer: `OK` comes before it, and either may come in pieces.
const MOST_LOOKS: u32 = 8;
/// System calls of a tick at most: a command, and each look's wait and read.
const CALLS_PER_TICK: u32 = 1 + 2 * MOST_LOOKS;
/// Typical round trips after which an answer is too late to be dated, unless that is less than this share of a period.
const LATE_ROUND_TRIPS: u64 = 2;
const DATED_SHARE: f64 = 0.125;
/// Each answer moves the typical round trip up or down by one part in this many, so that it settles at the median.
const FOLLOWS: u64 = 16;
/// Time in which the controller switches on, ns; then it must drive.
const SWITCHES_ON_WITHIN_NS: u64 = 500_000_000;

/// What the driver takes of a rig file's settings.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    port: String,
    id: i8,
    #[serde(default)]
    can_prefix: u16,
    #[serde(default = "usual_baud")]
    baud: u32,
}

fn usual_baud() -> u32 {
    USUAL_BAUD
}

/// A motor behind a moteus controller.
pub struct MoteusRig {
    description: RigDescription,
    settings: Settings,
    wiring: Wiring,
    query: Query,
    drive: Drive,
    watchdog_s: f64,
    longest_wait: Duration,
    /// Open once the rig is prepared.
    link: Option<Link>,
    /// Time from a question to its answer, which follows the median, ns.
    typical_ns: u64,
    /// Time after which an answer can be dated whatever is typical, ns.
    dated_ns: u64,
    /// Sender identifier of the newest frame.
    tag: i8,
    /// When it was switched on.
    enabled_ns: u64,
    is_on: bool,
    /// Whether it was seen driving since.
    drives: bool,
    /// Ticks in a row without an answer.
    unanswered: u32,
    /// Code of what came in place of an answer.
    unheard: i32,
    /// Exchanges in a row in which nothing at all was heard.
    silent: u32,
    counter_ms: Option<i32>,
    /// The torque of the newest command, mNm.
    torque_mnm: f64,
}

impl MoteusRig {
    /// The rig that a file describes, for a run at `rate_hz`; its port is opened when it is prepared.
    ///
    /// # Errors
    /// [`RigFileError`] for what is missing in the file, and for a port that is not there.
    pub fn new(file: &RigFile, rate_hz: f64) -> Result<Self, RigFileError> {
        let settings: Settings = file.settings()?;
        let Settings { port, id, .. } = &settings;
        if *id < 1 {
            return Err(file.error(format!("[settings] id is {id}, but a controller has one from 1 to 127")));
        }
        if !is_port(port) {
            return Err(file.error(format!(
                "[settings] port is '{port}', which is neither a tty nor a CAN interface of this machine; check the cable, or look for \
                 it in /dev/serial/by-id"
            )));
        }
        let channels = file.needed_channels()?;
        let names: Vec<String> = CHANNELS.iter().map(|(name, _)| (*name).to_owned()).collect();
        let wiring = channels.wire(&names).map_err(|error| file.error(error))?.held_between_exchanges(rate_hz);
        let sources: Vec<&str> = channels.sources().map(String::as_str).collect();
        let query = Query::of(&sources).ok_or_else(|| {
            file.error("[channels] names more channels than an answer of the controller holds; leave one out")
        })?;
        let described = file.description(&wiring)?;
        let most_torque_nm = wiring.of_motor(described.limits.motor_torque_mnm).abs();
        let own = [("port".to_owned(), port.clone()), ("controller".to_owned(), id.to_string())];
        let description = RigDescription {
            device: Some(port.clone()),
            calls: DeclaredCalls { names: CALLS.map(str::to_owned).into(), per_tick: CALLS_PER_TICK },
            codes: codes::all(),
            notes: described.notes.into_iter().chain(own).collect(),
            ..described
        };
        let watchdog_s = file.needed_watchdog()?.timeout_s;
        Ok(Self {
            description,
            wiring,
            query,
            drive: Drive::new(most_torque_nm, watchdog_s),
            watchdog_s,
            longest_wait: seconds(WAITED_SHARE / rate_hz),
            settings,
            link: None,
            typical_ns: 0,
            dated_ns: nanoseconds(seconds(DATED_SHARE / rate_hz)),
            tag: TAGS,
            enabled_ns: 0,
            is_on: false,
            drives: false,
            unanswered: 0,
            unheard: codes::SILENCE,
            silent: 0,
            counter_ms: None,
            torque_mnm: 0.0,
        })
    }

    fn address(&self) -> Address {
        Address { id: self.settings.id, prefix: self.settings.can_prefix }
    }

    /// Commands a torque, and asks what the sensors read.
    fn command(&mut self, torque_mnm: f64) -> Result<(), ApparatusError> {
        self.tag = self.tag % TAGS + 1;
        let frame = self.query.commanding(self.address(), self.tag, &self.drive, self.wiring.of_motor(torque_mnm));
        self.torque_mnm = torque_mnm;
        self.link.as_mut().ok_or(ApparatusError::Device(codes::NOT_OPENED))?.send(&frame).map_err(gone)
    }

    /// The answer to the newest command, if it has come; what came instead is noted.
    fn answer(&mut self) -> Result<Option<Reply>, ApparatusError> {
        let address = self.address();
        let Self { link, unheard, tag, .. } = self;
        let link = link.as_mut().ok_or(ApparatusError::Device(codes::NOT_OPENED))?;
        let mut newest = None;
        let received = link.receive(|heard| match heard {
            Heard::Frame(frame) if address.answers(*tag, &frame) => match Reply::of(&frame) {
                reply if reply.mode.is_some() => newest = Some(reply),
                _ => *unheard = codes::GARBAGE,
            },
            // An answer to an earlier command.
            Heard::Frame(frame) if address.is_from(&frame) => *unheard = codes::SLOW,
            Heard::Frame(_) => {}
            Heard::Refused => *unheard = codes::REFUSED,
            Heard::WrongChecksum => *unheard = codes::CHECKSUM,
            Heard::Garbage => *unheard = codes::GARBAGE,
        });
        received.map_err(gone)?;
        Ok(newest)
    }

    /// The answer to what was sent at `sent_ns`, and when it came, unless that is too late.
    fn wait(&mut self, sent_ns: u64) -> Result<Option<(Reply, u64)>, ApparatusError> {
        let longest_ns = nanoseconds(self.longest_wait);
        for _ in 0..MOST_LOOKS {
            let left_ns = (sent_ns + longest_ns).saturating_sub(now_ns());
            if let (Some(link), 1..) = (&self.link, left_ns) {
                link.wait(Duration::from_nanos(left_ns));
            }
            if let Some(reply) = self.answer()? {
                let came_ns = now_ns();
                self.check(&reply)?;
                let can_be_dated = self.is_timely(came_ns - sent_ns);
                return Ok(can_be_dated.then_some((reply, came_ns)));
            }
            if left_ns == 0 {
                return Ok(None);
            }
        }
        Ok(None)
    }

    /// Whether an answer after this time was not held up on the way.
    fn is_timely(&mut self, round_trip_ns: u64) -> bool {
        let longest_ns = self.dated_ns.max(LATE_ROUND_TRIPS * self.typical_ns);
        let step_ns = self.typical_ns / FOLLOWS;
        self.typical_ns = match round_trip_ns > self.typical_ns {
            true => self.typical_ns + step_ns,
            false => self.typical_ns - step_ns,
        };
        if round_trip_ns > longest_ns {
            self.unheard = codes::SLOW;
        }
        round_trip_ns <= longest_ns
    }

    /// Refuses an answer of a controller that does not drive as it was told to.
    fn check(&mut self, reply: &Reply) -> Result<(), ApparatusError> {
        bring_up::refuse_fault(reply)?;
        let began_anew = |before: i32| reply.counter_ms.is_some_and(|now| now.wrapping_sub(before) < 0);
        if self.counter_ms.is_some_and(began_anew) {
            return Err(ApparatusError::Device(codes::RESTARTED));
        }
        self.counter_ms = reply.counter_ms.or(self.counter_ms);
        match reply.mode {
            Some(Mode::Position) => self.drives = true,
            Some(Mode::Timeout) => return Err(ApparatusError::Device(codes::WATCHDOG)),
            _ if self.drives => return Err(ApparatusError::Device(codes::RESTARTED)),
            _ if now_ns().saturating_sub(self.enabled_ns) > SWITCHES_ON_WITHIN_NS => {
                return Err(ApparatusError::Device(codes::NOT_DRIVING));
            }
            _ => {}
        }
        Ok(())
    }
}

/// CLOCK_MONOTONIC, ns.
fn now_ns() -> u64 {
    // The clock is there on every Linux.
    clock_gettime(ClockId::CLOCK_MONOTONIC).map_or(0, |time| nanoseconds(time.into()))
}

/// Converts seconds to a duration, an invalid number to zero: invalid rates are refused elsewhere.
fn seconds(time_s: f64) -> Duration {
    Duration::try_from_secs_f64(time_s).unwrap_or_default()
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

impl Apparatus for MoteusRig {
    fn description(&self) -> &RigDescription {
        &self.description
    }

    fn prepare(&mut self, stop: &dyn Fn() -> bool) -> Result<(), ApparatusError> {
        let Settings { port, id, baud, .. } = &self.settings;
        let link = Link::open(port, *baud, Some(*id)).map_err(|_| ApparatusError::Device(codes::NOT_OPENED))?;
        let address = self.address();
        let mut talk = Conversation::new(self.link.insert(link), address, stop);
        let brought_up = bring_up(&mut talk, &self.query, &self.drive, self.watchdog_s, self.longest_wait);
        if brought_up.is_err() {
            // Whatever keeps it from coming up, it is not left driving.
            let _ = talk.stop_motor();
        }
        let BroughtUp { round_trip, notes } = brought_up?;
        self.typical_ns = nanoseconds(round_trip);
        self.description.notes.extend(notes);
        self.description.watchdog_s = Some(self.watchdog_s);
        Ok(())
    }

    fn enable(&mut self) -> Result<(), ApparatusError> {
        // Answers to what was asked while it was prepared are no measurements.
        self.answer()?;
        self.is_on = true;
        self.enabled_ns = now_ns();
        (self.unanswered, self.silent, self.unheard) = (0, 0, codes::SILENCE);
        (self.counter_ms, self.drives) = (None, false);
        self.command(0.0)
    }

    fn disable(&mut self) {
        if std::mem::take(&mut self.is_on) {
            let stop = self.address().stop();
            if let Some(link) = &mut self.link {
                // More than once: a serial port first sends the rest of the line before, and a frame may be lost. Where none goes out the
                // watchdog does the same.
                for _ in 0..STOPS {
                    let _ = link.send(&stop);
                }
            }
        }
    }

    fn exchange(&mut self, due_ns: u64, torque_mnm: f64) -> Result<Measurement, ApparatusError> {
        // The sensors are read while the previous command still acts.
        let acting_mnm = self.torque_mnm;
        let sent_ns = now_ns();
        let before = std::mem::replace(&mut self.unheard, codes::SILENCE);
        self.command(torque_mnm)?;
        let Some((reply, came_ns)) = self.wait(sent_ns)? else {
            self.unanswered += 1;
            self.silent = if self.unheard == codes::SILENCE { self.silent + 1 } else { 0 };
            // A short silence keeps the code from before; a longer one is reported as silence, whatever came before it.
            if (1..=self.description.stale_limit / 2).contains(&self.silent) {
                self.unheard = before;
            }
            if self.unanswered > self.description.stale_limit {
                return Err(ApparatusError::Device(self.unheard));
            }
            return Ok(Measurement::stale(self.unheard));
        };
        (self.unanswered, self.silent, self.unheard) = (0, 0, codes::SILENCE);
        let after_ns = (sent_ns.midpoint(came_ns)).wrapping_sub(due_ns).cast_signed();
        let read = RawMeasurement { values: reply.values, valid: reply.valid, after_s: after_ns as f64 * 1e-9 };
        Ok(self.wiring.measurement(&read, acting_mnm))
    }
}

impl Drop for MoteusRig {
    fn drop(&mut self) {
        self.disable();
    }
}
