//! From an open port to a controller that is known to answer in time and to let go of the torque when nobody commands.

use std::time::{Duration, Instant};

use moteus_protocol::{CURRENT_REGISTER_MAP_VERSION, Mode, Register};

use super::codes;
use super::conversation::{Conversation, PATIENCE};
use super::registers::{Drive, Query, Reply};
use super::seconds;
use crate::ApparatusError;

/// Longest time in which a controller switches on: it measures the zero of its current sensors meanwhile.
const SWITCHES_ON_WITHIN: Duration = Duration::from_secs(2);
/// Time within which the watchdog must run out, relative to its setting, and how much later an answer may come.
const WATCHDOG_SHARE: f64 = 1.25;
const WATCHDOG_LEEWAY: Duration = Duration::from_millis(20);
/// Questions by which the way to the controller and back is timed, and the rest between two: as in a run, in which both ends sleep.
const TIMED_QUESTIONS: u16 = 64;
const REST: Duration = Duration::from_millis(1);
/// What is known of a controller that is up.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct BroughtUp {
    /// Time from a question to its answer, as [`round_trip`] has it.
    pub(super) round_trip: Duration,
    /// Facts worth keeping with a capture.
    pub(super) notes: Vec<(String, String)>,
}

/// Brings a controller up and leaves it stopped; a quarter of its answers at least must come within `longest_wait`.
pub(super) fn bring_up(
    talk: &mut Conversation<'_>,
    query: &Query,
    drive: &Drive,
    watchdog_s: f64,
    longest_wait: Duration,
) -> Result<BroughtUp, ApparatusError> {
    let identity = match identify(talk) {
        // A controller that does not say what it is may still drive: the next question shows whether it answers at all.
        Err(ApparatusError::Device(codes::SILENCE)) => format!("moteus {}", talk.address.id),
        identified => identified?,
    };
    talk.stop_motor()?;
    let reply = ask(talk, query)?;
    refuse_fault(&reply)?;
    if reply.valid & query.asked() != query.asked() {
        return Err(ApparatusError::Device(codes::NO_CHANNEL));
    }
    let on_timeout = let_go_on_timeout(talk)?;
    let round_trip = round_trip(talk, query)?;
    if round_trip >= longest_wait {
        return Err(ApparatusError::Device(codes::SLOW));
    }
    try_watchdog(talk, query, drive, watchdog_s)?;
    talk.stop_motor()?;
    let notes = [
        ("device", identity),
        ("link", talk.link.in_words().to_owned()),
        ("round trip", format!("{:.0} µs, lower quartile", 1e6 * round_trip.as_secs_f64())),
        ("when the watchdog runs out", on_timeout),
    ];
    let notes = notes.map(|(name, value)| (name.to_owned(), value)).into();
    Ok(BroughtUp { round_trip, notes })
}

/// Who answers, in words.
///
/// # Errors
/// When nobody does, or one whose registers mean something else.
pub(super) fn identify(talk: &mut Conversation<'_>) -> Result<String, ApparatusError> {
    let found = talk.integers(Register::ModelNumber, 3)?;
    let of =
        |wanted: Register| found.iter().find(|(register, _)| *register == wanted.address()).map(|(_, value)| *value);
    if of(Register::RegisterMapVersion)
        .is_some_and(|version| version > 0 && version != i32::from(CURRENT_REGISTER_MAP_VERSION))
    {
        return Err(ApparatusError::Device(codes::OTHER_REGISTERS));
    }
    let firmware = of(Register::FirmwareVersion).unwrap_or(0).to_le_bytes();
    Ok(format!(
        "moteus {}, model {:#x}, firmware {}.{}.{}",
        talk.address.id,
        of(Register::ModelNumber).unwrap_or(0),
        firmware[2],
        firmware[1],
        firmware[0]
    ))
}

fn ask(talk: &mut Conversation<'_>, query: &Query) -> Result<Reply, ApparatusError> {
    let answer = talk.ask(&query.frame(talk.address))?;
    Ok(Reply::of(&answer))
}

/// Tells a fault by its code.
pub(super) fn refuse_fault(reply: &Reply) -> Result<(), ApparatusError> {
    match (reply.mode, reply.fault) {
        (Some(Mode::Fault), 0) => Err(ApparatusError::Device(codes::UNNAMED_FAULT)),
        (Some(Mode::Fault), code) => Err(ApparatusError::Device(code)),
        _ => Ok(()),
    }
}

/// Has the controller let go of the motor when its watchdog runs out, rather than brake or hold it, until it is switched off.
fn let_go_on_timeout(talk: &mut Conversation<'_>) -> Result<String, ApparatusError> {
    const LETS_GO: &str = "0";
    let mode = talk.command_line("conf get servo.timeout_mode\n")?;
    match mode.as_deref().filter(|mode| mode.parse::<i32>().is_ok()) {
        // The controller says nothing over its stream, or has no such setting; whether it lets go is tried all the same.
        None => Ok("not given by the controller".to_owned()),
        Some(LETS_GO) => Ok("the motor is let go".to_owned()),
        Some(before) => {
            talk.command_line("conf set servo.timeout_mode 0\n")?;
            match talk.command_line("conf get servo.timeout_mode\n")?.as_deref() {
                Some(LETS_GO) => Ok(format!("the motor is let go; servo.timeout_mode was {before}")),
                _ => Err(ApparatusError::Device(codes::HOLDS_ON_TIMEOUT)),
            }
        }
    }
}

/// Switches the controller on at zero torque, sends nothing until its watchdog must have run out, and checks that it has.
fn try_watchdog(
    talk: &mut Conversation<'_>,
    query: &Query,
    drive: &Drive,
    watchdog_s: f64,
) -> Result<(), ApparatusError> {
    let command = query.commanding(talk.address, 1, drive, 0.0);
    let begun = Instant::now();
    loop {
        let reply = Reply::of(&talk.ask(&command)?);
        refuse_fault(&reply)?;
        match reply.mode {
            Some(Mode::Position) => break,
            // The host stalled for longer than the watchdog bears.
            Some(Mode::Timeout) => talk.stop_motor()?,
            _ => {}
        }
        if begun.elapsed() > SWITCHES_ON_WITHIN {
            return Err(ApparatusError::Device(codes::NOT_DRIVING));
        }
    }
    talk.rest(seconds(WATCHDOG_SHARE * watchdog_s).saturating_add(WATCHDOG_LEEWAY))?;
    match ask(talk, query)?.mode {
        Some(Mode::Timeout | Mode::Stopped) => Ok(()),
        _ => Err(ApparatusError::Device(codes::NO_WATCHDOG)),
    }
}

/// Time from a question to its answer: the lower quartile, since the ordinary thread that asks is held up by others itself.
pub(super) fn round_trip(talk: &mut Conversation<'_>, query: &Query) -> Result<Duration, ApparatusError> {
    let mut times = Vec::new();
    let mut unheard = codes::SILENCE;
    let question = query.frame(talk.address);
    for _ in 0..TIMED_QUESTIONS {
        std::thread::sleep(REST);
        let asked = Instant::now();
        if talk.ask_once(&question, PATIENCE, &mut unheard)?.is_some() {
            times.push(asked.elapsed());
        }
    }
    times.sort_unstable();
    times.get(times.len() / 4).copied().ok_or(ApparatusError::Device(unheard))
}
