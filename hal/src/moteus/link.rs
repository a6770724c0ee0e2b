//! The way to a controller: lines over a tty, or frames over SocketCAN.

use std::fs::File;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::os::fd::AsFd as _;
use std::time::Duration;

use moteus_protocol::CanFdFrame;
use nix::poll::{PollFd, PollFlags, ppoll};

use super::can;
use super::tty::{self, Lines};

/// The system calls that are made: to send, to wait until something comes, and to look what it is.
pub(super) const CALLS: [&str; 3] = ["write", "ppoll", "read"];

/// What came.
pub(super) enum Heard {
    /// A frame.
    Frame(CanFdFrame),
    /// The adapter, or the controller, did not take what it was sent.
    Refused,
    /// A line whose checksum is wrong.
    WrongChecksum,
    /// A line that is none of the protocol's.
    Garbage,
}

/// The port is gone.
#[derive(Debug)]
pub(super) struct PortGone;

/// An open port.
pub(super) struct Link {
    port: File,
    /// `None` over CAN.
    lines: Option<Lines>,
}

impl Link {
    /// Opens a tty by its path, or a CAN interface by its name, where it hears `id` alone if one is given.
    pub(super) fn open(port: &str, baud: u32, id: Option<i8>) -> io::Result<Self> {
        match can::is_interface(port) {
            true => Ok(Self { port: can::open(port, id)?, lines: None }),
            false => Ok(Self { port: tty::open(port, baud)?, lines: Some(Lines::new()) }),
        }
    }

    /// What carries the frames, for people.
    pub(super) fn in_words(&self) -> &'static str {
        match &self.lines {
            None => "SocketCAN",
            Some(lines) if lines.has_checksums() => "UART",
            Some(_) => "fdcanusb",
        }
    }

    /// Sends a frame, as far as the port takes it at once: what does not go out shows as an answer that does not come.
    pub(super) fn send(&mut self, frame: &CanFdFrame) -> Result<(), PortGone> {
        let written = match &mut self.lines {
            Some(lines) => self.port.write(lines.line_of(frame)),
            None => self.port.write(&can::encode(frame)),
        };
        let bytes = match written {
            Ok(bytes) => bytes,
            Err(error) if is_momentary(&error) => 0,
            Err(_) => return Err(PortGone),
        };
        if let Some(lines) = &mut self.lines {
            lines.went(bytes);
        }
        Ok(())
    }

    /// Sleeps until something comes, so long at most.
    pub(super) fn wait(&self, most: Duration) {
        // A wait that a signal ends early is looked at again by whoever waits.
        let _ = ppoll(&mut [PollFd::new(self.port.as_fd(), PollFlags::POLLIN)], Some(most.into()), None);
    }

    /// Gives what has come to `take`, without waiting for more.
    pub(super) fn receive(&mut self, mut take: impl FnMut(Heard)) -> Result<(), PortGone> {
        let Self { port, lines } = self;
        let Some(lines) = lines else { return receive_frame(port, take) };
        match port.read(lines.room()) {
            // A tty that has nothing says so; one that ends is unplugged.
            Ok(0) => return Err(PortGone),
            Ok(bytes) => lines.came(bytes),
            Err(error) if is_momentary(&error) => {}
            Err(_) => return Err(PortGone),
        }
        while let Some(heard) = lines.next() {
            take(heard);
        }
        Ok(())
    }
}

fn receive_frame(port: &mut File, take: impl FnOnce(Heard)) -> Result<(), PortGone> {
    let mut wire = [0; can::WIRE_BYTES];
    match port.read(&mut wire) {
        Ok(length) => take(can::decode(&wire[..length]).map_or(Heard::Refused, Heard::Frame)),
        Err(error) if is_momentary(&error) => {}
        Err(_) => return Err(PortGone),
    }
    Ok(())
}

/// Whether another try may do better: nothing there, no room, or a CAN queue that is full.
fn is_momentary(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
        || error.raw_os_error() == Some(libc::ENOBUFS)
}
