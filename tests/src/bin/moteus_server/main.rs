//! A moteus controller on a pty or a CAN interface, compiled, for rates that an interpreter does not hold: it shares no code with the driver, and its
//! plant goes by the clock. What happens to it is printed, a line each.
#![allow(clippy::print_stdout, reason = "what happens is this program's output")]

mod can;
mod controller;
mod plant;
mod wire;

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::os::fd::{AsFd as _, OwnedFd};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context as _;
use clap::Parser;
use controller::{Controller, Trouble};
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::pty::openpty;
use nix::sys::termios::{SetArg, cfmakeraw, tcgetattr, tcsetattr};
use wire::{crc8, parse_line, requests};

#[derive(Parser)]
struct Arguments {
    /// Where the port is to be found.
    #[arg(long, required_unless_present = "can")]
    link: Option<PathBuf>,
    /// A CAN interface instead.
    #[arg(long, conflicts_with = "link")]
    can: Option<String>,
    #[arg(long, default_value_t = 1)]
    id: u32,
    /// Speaks as over a controller's own UART, with checksums.
    #[arg(long)]
    uart: bool,
    /// Counts of the encoder a turn; 0 for none.
    #[arg(long, default_value_t = 65_536.0)]
    counts: f64,
    #[arg(long)]
    trouble: Option<Trouble>,
    /// Time from the first torque to the trouble, s.
    #[arg(long, default_value_t = 1.0)]
    after: f64,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    // The other end of a pty is held, so that the port is there before a host and after it.
    let (port, _held) = match (&arguments.can, &arguments.link) {
        (Some(interface), _) => (can::open(interface)?, None),
        (None, Some(link)) => tty(link).map(|(port, other)| (port, Some(other)))?,
        (None, None) => anyhow::bail!("neither a link nor a CAN interface was given"),
    };
    let mut controller = Controller::new();
    controller.counts_per_turn = arguments.counts;
    controller.trouble = arguments.trouble;
    controller.trouble_after_s = arguments.after;
    println!("ready");
    let mut server = Server {
        port,
        is_can: arguments.can.is_some(),
        id: arguments.id,
        uart: arguments.uart,
        begun: Instant::now(),
        controller,
    };
    let mut waiting = Vec::new();
    loop {
        let timeout = PollTimeout::from(1_u8);
        let heard = poll(&mut [PollFd::new(server.port.as_fd(), PollFlags::POLLIN)], timeout)?;
        server.controller.turn_to(server.now_s());
        server.tell();
        if heard == 0 {
            continue;
        }
        if server.is_can {
            let (identifier, data) = can::receive(&mut server.port)?;
            server.serve(identifier, &data)?;
            continue;
        }
        let mut bytes = [0; 4096];
        let length = server.port.read(&mut bytes)?;
        waiting.extend_from_slice(&bytes[..length]);
        while let Some(end) = waiting.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = waiting.drain(..=end).collect();
            server.take(String::from_utf8_lossy(&line).trim())?;
        }
    }
}

/// A pty that passes bytes on as they are, and its other end, which `link` leads to.
fn tty(link: &Path) -> anyhow::Result<(File, OwnedFd)> {
    let ends = openpty(None, None)?;
    let mut raw = tcgetattr(&ends.slave)?;
    cfmakeraw(&mut raw);
    tcsetattr(&ends.slave, SetArg::TCSANOW, &raw)?;
    let path = nix::unistd::ttyname(&ends.slave)?;
    let _ = std::fs::remove_file(link);
    std::os::unix::fs::symlink(&path, link).context("no link to the port can be made")?;
    Ok((File::from(ends.master), ends.slave))
}

struct Server {
    port: File,
    is_can: bool,
    id: u32,
    uart: bool,
    begun: Instant,
    controller: Controller,
}

impl Server {
    fn now_s(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }

    fn tell(&mut self) {
        for event in self.controller.events.drain(..) {
            println!("{event}");
        }
    }

    /// Serves a line.
    fn take(&mut self, line: &str) -> anyhow::Result<()> {
        if line.is_empty() {
            return Ok(());
        }
        let now_s = self.now_s();
        let silent = self.controller.has_trouble(now_s, Trouble::Silence);
        let Some((identifier, data, checksum)) = parse_line(line) else { return self.say("ERR unknown command") };
        if checksum == Some(false) {
            return self.say("ERR checksum mismatch");
        }
        if !silent {
            self.say("OK")?;
        }
        self.serve(identifier, &data)
    }

    /// Serves a frame.
    fn serve(&mut self, identifier: u32, data: &[u8]) -> anyhow::Result<()> {
        let now_s = self.now_s();
        if identifier & 0x7f != self.id || self.controller.has_trouble(now_s, Trouble::Silence) {
            return Ok(());
        }
        let reply = self.controller.serve(&requests(data), now_s);
        self.tell();
        if self.controller.trouble == Some(Trouble::Slow) {
            std::thread::sleep(Duration::from_millis(5));
        }
        if identifier & 0x8000 == 0 {
            return Ok(());
        }
        let source = identifier >> 8 & 0x7f;
        if self.is_can {
            return Ok(can::send(&mut self.port, self.id << 8 | source, &reply)?);
        }
        let digits: String = reply.iter().map(|byte| format!("{byte:02x}")).collect();
        self.say(&format!("rcv {:x} {digits} E B F", self.id << 8 | source))
    }

    fn say(&mut self, line: &str) -> anyhow::Result<()> {
        let now_s = self.now_s();
        let mut line = line.to_owned();
        if self.controller.has_trouble(now_s, Trouble::Garbage) {
            line = "\u{7f}[xq7 what!?".to_owned();
        }
        if self.uart {
            line.push(' ');
            let wrong = u8::from(self.controller.has_trouble(now_s, Trouble::Checksum));
            line = format!("{line}*{:02X}", crc8(line.as_bytes()).wrapping_add(wrong));
        }
        line.push_str("\r\n");
        // A host that is gone takes nothing, and the next one finds the port as it was.
        let _ = self.port.write(line.as_bytes());
        Ok(())
    }
}
