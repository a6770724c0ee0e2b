//! Lines of text over a tty: an fdcanusb adapter, or a controller's own UART, which adds checksums.
//!
//! <https://mjbots.github.io/moteus/integration/uart/>

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt as _;

use moteus_protocol::CanFdFrame;
use moteus_protocol::fdcanusb::{
    EncodeOptions, Line, MAX_LINE_LENGTH, encode_can_send, is_checksum_error, parse_line, strip_checksum,
};
use nix::sys::termios::{BaudRate, FlushArg, SetArg, cfmakeraw, cfsetspeed, tcflush, tcgetattr, tcsetattr};

use super::link::Heard;

/// As much as a tty holds for whoever reads it (tty(4): 4096 bytes).
const BUFFER_BYTES: usize = 4096;

/// Opens a tty that passes bytes on as they are, and never waits.
pub(super) fn open(path: &str, baud: u32) -> io::Result<File> {
    let file = OpenOptions::new().read(true).write(true).custom_flags(libc::O_NOCTTY | libc::O_NONBLOCK).open(path)?;
    let mut settings = tcgetattr(&file)?;
    cfmakeraw(&mut settings);
    cfsetspeed(&mut settings, speed(baud)?)?;
    tcsetattr(&file, SetArg::TCSANOW, &settings)?;
    tcflush(&file, FlushArg::TCIOFLUSH)?;
    Ok(file)
}

/// The kernel's name for a rate of so many bits a second; USB adapters take none.
fn speed(baud: u32) -> io::Result<BaudRate> {
    Ok(match baud {
        115_200 => BaudRate::B115200,
        230_400 => BaudRate::B230400,
        460_800 => BaudRate::B460800,
        921_600 => BaudRate::B921600,
        1_000_000 => BaudRate::B1000000,
        2_000_000 => BaudRate::B2000000,
        3_000_000 => BaudRate::B3000000,
        _ => return Err(io::ErrorKind::InvalidInput.into()),
    })
}

/// Frames as lines and lines as frames.
pub(super) struct Lines {
    waiting: Box<[u8; BUFFER_BYTES]>,
    filled: usize,
    taken: usize,
    /// Whether the port is known as the controller's own UART, on which lines have checksums in both directions.
    checksums: bool,
    /// What is to be sent: a line, of which the port may have taken the first part only.
    line: [u8; MAX_LINE_LENGTH],
    sent: usize,
    length: usize,
}

impl Lines {
    pub(super) fn new() -> Self {
        Self {
            waiting: Box::new([0; BUFFER_BYTES]),
            filled: 0,
            taken: 0,
            checksums: false,
            line: [0; MAX_LINE_LENGTH],
            sent: 0,
            length: 0,
        }
    }

    /// Whether answers have checksums, as a controller's own UART has it.
    pub(super) fn has_checksums(&self) -> bool {
        self.checksums
    }

    /// What is to be written to send a frame. What is left of the line before goes first, and the frame is dropped: half a line
    /// would be taken for another command.
    pub(super) fn line_of(&mut self, frame: &CanFdFrame) -> &[u8] {
        if self.sent == self.length {
            let options = EncodeOptions { disable_brs: false, checksum: self.checksums };
            // A buffer of this length is always enough, as the codec promises.
            (self.sent, self.length) = (0, encode_can_send(frame, &options, &mut self.line).unwrap_or(0));
        }
        &self.line[self.sent..self.length]
    }

    /// So many bytes of it have gone.
    pub(super) fn went(&mut self, bytes: usize) {
        // Nothing has gone of a line that did not begin: the next frame may take its place.
        (self.sent, self.length) = if self.sent + bytes == 0 { (0, 0) } else { (self.sent + bytes, self.length) };
    }

    /// Where further bytes go.
    pub(super) fn room(&mut self) -> &mut [u8] {
        self.waiting.copy_within(self.taken..self.filled, 0);
        self.filled -= std::mem::take(&mut self.taken);
        if self.filled == BUFFER_BYTES {
            // A full buffer without an end of line holds no line of the protocol: it is discarded.
            self.filled = 0;
        }
        &mut self.waiting[self.filled..]
    }

    /// So many bytes have come.
    pub(super) fn came(&mut self, bytes: usize) {
        self.filled += bytes;
    }

    /// What the next whole line says; `None` when there is none.
    pub(super) fn next(&mut self) -> Option<Heard> {
        loop {
            let rest = &self.waiting[self.taken..self.filled];
            let length = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'))?;
            let line = &rest[..length];
            self.taken += length + 1;
            if line.is_empty() {
                continue;
            }
            let (content, has_checksum, is_right) = strip_checksum(line);
            if has_checksum && !is_right {
                return Some(Heard::WrongChecksum);
            }
            self.checksums |= has_checksum;
            return Some(match parse_line(content) {
                _ if self.checksums && !has_checksum => Heard::Garbage,
                Line::Ok => continue,
                Line::Rcv(frame) => Heard::Frame(frame),
                Line::Err(why) => {
                    self.checksums |= is_checksum_error(why);
                    Heard::Refused
                }
                Line::Other(_) => Heard::Garbage,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(lines: &mut Lines, text: &[u8]) -> Vec<&'static str> {
        lines.room()[..text.len()].copy_from_slice(text);
        lines.came(text.len());
        std::iter::from_fn(|| lines.next())
            .map(|heard| match heard {
                Heard::Frame(_) => "frame",
                Heard::Refused => "refused",
                Heard::WrongChecksum => "checksum",
                Heard::Garbage => "garbage",
            })
            .collect()
    }

    #[test]
    fn lines_come_in_pieces_and_several_at_once() {
        let mut lines = Lines::new();
        assert!(heard(&mut lines, b"OK\r\nrcv 100 2400").is_empty());
        assert_eq!(heard(&mut lines, b"0b F\r\nERR unknown\nrcv 100 zz\n"), ["frame", "refused", "garbage"]);
    }

    #[test]
    fn a_controllers_own_uart_is_known_by_its_checksums_which_are_then_asked_for() {
        let mut lines = Lines::new();
        assert!(!lines.has_checksums());
        // The vendor's own example of a checksum.
        assert_eq!(heard(&mut lines, b"rcv 0502 1234 *3C\n"), ["frame"]);
        assert!(lines.has_checksums());
        assert_eq!(heard(&mut lines, b"rcv 0502 1234 *3D\nrcv 0502 1234\n"), ["checksum", "garbage"]);
        let mut frame = CanFdFrame::new();
        frame.arbitration_id = 1;
        (frame.data[0], frame.size) = (0x20, 1);
        let line = lines.line_of(&frame).to_vec();
        assert!(line.starts_with(b"can send 0001 20 BF *") && line.ends_with(b"\n"));
        lines.went(3);
        assert_eq!(lines.line_of(&CanFdFrame::new()), &line[3..], "the rest of the line before goes first");
        lines.went(line.len() - 3);
        assert_ne!(lines.line_of(&CanFdFrame::new()), line);
    }

    #[test]
    fn a_flood_without_a_line_is_dropped() {
        let mut lines = Lines::new();
        for _ in 0..10 {
            let room = lines.room();
            room.fill(b'x');
            let length = room.len();
            lines.came(length);
            assert!(lines.next().is_none());
        }
        lines.room();
        assert_eq!(heard(&mut lines, b"\nrcv 100 2400\n"), ["frame"]);
    }
}
