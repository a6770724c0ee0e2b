//! Looking for controllers on a port: every identifier is asked, and all of them again if none answers.

use std::os::unix::fs::FileTypeExt as _;
use std::time::Duration;

use super::bring_up::{identify, round_trip};
use super::conversation::{Conversation, PATIENCE};
use super::link::Link;
use super::registers::{Address, Query, Reply};
use super::{TEMPLATE, USUAL_BAUD, can, codes};
use crate::{ApparatusError, Scanned};

/// How long an answer of each identifier is waited for.
const EACH: Duration = Duration::from_millis(6);
/// The last identifier.
const LAST_ID: i8 = 127;

/// Why nothing could be found out about a port.
#[derive(Debug, thiserror::Error)]
pub enum ScanError {
    /// It cannot be opened.
    #[error("{port} cannot be opened ({reason}); check the cable, and that this user may use it (group dialout)")]
    NotOpened {
        /// The port.
        port: String,
        /// The system's word for it.
        reason: std::io::Error,
    },
    /// Something went wrong on the way.
    #[error("{port}: {reason}")]
    Failed {
        /// The port.
        port: String,
        /// What it was.
        reason: String,
    },
}

/// Whether this is a port that a controller may be behind: a tty by its path, or a CAN interface by its name.
#[must_use]
pub fn is_port(port: &str) -> bool {
    can::is_interface(port) || std::fs::metadata(port).is_ok_and(|found| found.file_type().is_char_device())
}

/// The controllers on a port, and a rig file for the first of them. Nothing moves.
///
/// # Errors
/// [`ScanError`].
pub fn scan(port: &str, stop: &dyn Fn() -> bool) -> Result<Scanned, ScanError> {
    let mut link =
        Link::open(port, USUAL_BAUD, None).map_err(|reason| ScanError::NotOpened { port: port.to_owned(), reason })?;
    look(&mut link, port, stop).map_err(|error| {
        let code = error.device_code();
        let meaning = codes::all().into_iter().find(|(known, _)| Some(*known) == code).map(|(_, meaning)| meaning);
        ScanError::Failed { port: port.to_owned(), reason: meaning.unwrap_or_else(|| error.to_string()) }
    })
}

fn look(link: &mut Link, port: &str, stop: &dyn Fn() -> bool) -> Result<Scanned, ApparatusError> {
    // It asks for little, and always fits.
    let Some(query) = Query::of(&["position"]) else { return Ok(Scanned::default()) };
    let mut found = Scanned::default();
    let mut unheard = codes::SILENCE;
    // A busy machine may miss the only answer.
    for id in (1..=LAST_ID).chain(1..=LAST_ID) {
        if id == 1 && !found.lines.is_empty() {
            break;
        }
        let address = Address { id, prefix: 0 };
        let mut talk = Conversation::new(link, address, stop);
        // The first is waited for longer: what it is answered with tells whether the port asks for checksums.
        let patience = if id == 1 { PATIENCE } else { EACH };
        let question = query.frame(address);
        let before = unheard;
        let mut answer = talk.ask_once(&question, patience, &mut unheard)?;
        if answer.is_none() && unheard != before {
            answer = talk.ask_once(&question, patience, &mut unheard)?;
        }
        let Some(answer) = answer else { continue };
        let reply = Reply::of(&answer);
        let identity = identify(&mut talk)?;
        let round_trip_us = 1e6 * round_trip(&mut talk, &query)?.as_secs_f64();
        let mode = reply.mode.map_or_else(|| "unknown".to_owned(), |mode| mode.to_string());
        found.lines.push(format!(
            "{identity}: {} at {:.4} revolutions, mode {mode}, {round_trip_us:.0} µs there and back",
            talk.link.in_words(),
            reply.values[0]
        ));
        found.rig_file.get_or_insert_with(|| rig_file(port, id));
    }
    if found.lines.is_empty() {
        let (_, meaning) = codes::all().into_iter().find(|(code, _)| *code == unheard).unwrap_or_default();
        found.lines.push(format!("no controller answers on {port}: {meaning}"));
    }
    Ok(found)
}

/// The template for a controller that was found.
fn rig_file(port: &str, id: i8) -> String {
    let port = toml::Value::String(port.to_owned());
    TEMPLATE
        .replace("port = \"/dev/ttyACM0\"", &format!("port = {port}"))
        .replace("\nid = 1\n", &format!("\nid = {id}\n"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
    use super::rig_file;
    use crate::RigFile;

    #[test]
    fn the_rig_file_names_what_was_found() {
        let file = RigFile::parse(&rig_file("/dev/ttyACM3", 9), std::path::Path::new("")).unwrap();
        assert_eq!(file.settings["port"].as_str(), Some("/dev/ttyACM3"));
        assert_eq!(file.settings["id"].as_integer(), Some(9));
        assert!(file.calibration().unwrap().is_some());
    }
}
