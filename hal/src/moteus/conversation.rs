//! Questions to a controller and their answers, on an ordinary thread that may wait.

use std::time::{Duration, Instant};

use moteus_protocol::{CanFdFrame, Register, diagnostic};

use super::codes;
use super::link::{Heard, Link, PortGone};
use super::registers::{Address, registers};
use crate::ApparatusError;

/// Longest wait for an answer.
pub(super) const PATIENCE: Duration = Duration::from_millis(50);
/// How often a question is asked until it is given up.
const TRIES: u32 = 5;
/// Sender identifiers of the questions, used in turn; a run uses others.
const TAGS: std::ops::RangeInclusive<i8> = 32..=95;
/// The controller's stream for people, over which its configuration is read and set.
const STREAM: u8 = 1;

/// A controller that is asked.
pub(super) struct Conversation<'a> {
    pub(super) link: &'a mut Link,
    pub(super) address: Address,
    pub(super) stop: &'a dyn Fn() -> bool,
    tag: i8,
}

impl<'a> Conversation<'a> {
    pub(super) fn new(link: &'a mut Link, address: Address, stop: &'a dyn Fn() -> bool) -> Self {
        Self { link, address, stop, tag: *TAGS.start() }
    }

    /// The controller's answer to a question, asked until it comes.
    pub(super) fn ask(&mut self, question: &CanFdFrame) -> Result<CanFdFrame, ApparatusError> {
        let mut unheard = codes::SILENCE;
        for _ in 0..TRIES {
            if let Some(answer) = self.ask_once(question, PATIENCE, &mut unheard)? {
                return Ok(answer);
            }
        }
        Err(ApparatusError::Device(unheard))
    }

    /// The answer to a question that is asked once. If something else comes, `unheard` is set to its code.
    pub(super) fn ask_once(
        &mut self,
        question: &CanFdFrame,
        patience: Duration,
        unheard: &mut i32,
    ) -> Result<Option<CanFdFrame>, ApparatusError> {
        if (self.stop)() {
            return Err(ApparatusError::Stopped);
        }
        self.tag = if self.tag == *TAGS.end() { *TAGS.start() } else { self.tag + 1 };
        self.link.send(&self.address.sent_as(self.tag, question)).map_err(gone)?;
        let until = Instant::now() + patience;
        loop {
            let mut answer = None;
            let (address, tag) = (self.address, self.tag);
            self.link
                .receive(|heard| match heard {
                    Heard::Frame(frame) if address.answers(tag, &frame) => answer = Some(frame),
                    Heard::Frame(_) => {}
                    Heard::Refused => *unheard = codes::REFUSED,
                    Heard::WrongChecksum => *unheard = codes::CHECKSUM,
                    Heard::Garbage => *unheard = codes::GARBAGE,
                })
                .map_err(gone)?;
            let left = until.saturating_duration_since(Instant::now());
            if answer.is_some() || left.is_zero() {
                return Ok(answer);
            }
            self.link.wait(left);
        }
    }

    /// Sends nothing for `time`, unless asked to stop.
    pub(super) fn rest(&self, time: Duration) -> Result<(), ApparatusError> {
        let begun = Instant::now();
        while begun.elapsed() < time {
            if (self.stop)() {
                return Err(ApparatusError::Stopped);
            }
            std::thread::sleep(PATIENCE.min(time.saturating_sub(begun.elapsed())));
        }
        Ok(())
    }

    /// Integers of `count` registers from `register` on, as far as the controller has them.
    pub(super) fn integers(&mut self, register: Register, count: u8) -> Result<Vec<(u16, i32)>, ApparatusError> {
        let answer = self.ask(&self.address.read_integers(register, count))?;
        Ok(registers(&answer).map(|(register, value)| (register, value.to_i32())).collect())
    }

    /// Switches the motor off, and clears a fault.
    pub(super) fn stop_motor(&mut self) -> Result<(), ApparatusError> {
        self.link.send(&self.address.stop()).map_err(gone)
    }

    /// The controller's answer to a line of text on its diagnostic stream; `None` if it does not listen there.
    pub(super) fn command_line(&mut self, line: &str) -> Result<Option<String>, ApparatusError> {
        let mut unheard = 0;
        let said = self.address.bytes(|data| diagnostic::write_client_to_server(STREAM, line.as_bytes(), data));
        self.ask_once(&said, Duration::ZERO, &mut unheard)?;
        let poll = self.address.bytes(|data| diagnostic::write_client_poll(STREAM, 48, data));
        let mut heard = String::new();
        for _ in 0..TRIES {
            let Some(answer) = self.ask_once(&poll, PATIENCE, &mut unheard)? else { return Ok(None) };
            let Some(bytes) = diagnostic::parse_server_to_client(answer.payload(), STREAM) else { continue };
            heard.push_str(&String::from_utf8_lossy(bytes));
            if heard.ends_with(['\n', '\r']) {
                return Ok(Some(heard.trim().to_owned()));
            }
        }
        Ok(None)
    }
}

pub(super) fn gone(_: PortGone) -> ApparatusError {
    ApparatusError::Device(codes::PORT_GONE)
}
