//! A moteus controller that shares no code with the driver, on a pty: from `rig scan` to a fitted model, and all that can go wrong.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
#![allow(clippy::print_stderr, reason = "a test that skips says so")]

mod allocation;
mod can;
mod captures;
mod commands;
mod faults;
mod vendor;

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use tests::{Bench, printed};

/// A server at work on a bench; ended when this is dropped.
struct Server {
    child: Child,
    lines: Receiver<String>,
}

impl Server {
    /// The compiled server, at the bench's `port`.
    fn start(bench: &Bench, arguments: &[&str]) -> Self {
        let server = env!("CARGO_BIN_EXE_moteus_server");
        // Like a controller it waits for no other task, where that is permitted.
        let may_go_first =
            Command::new("chrt").args(["-f", "60", "true"]).status().is_ok_and(|status| status.success());
        let mut command = Command::new(if may_go_first { "chrt" } else { server });
        if may_go_first {
            command.args(["-f", "60", server]);
        }
        command.args(["--link", &bench.path("port").to_string_lossy()]).args(arguments);
        Self::of(command)
    }

    /// A server that says `ready` once its port is there.
    fn of(mut command: Command) -> Self {
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().unwrap();
        let (tell, lines) = channel();
        let output = BufReader::new(child.stdout.take().unwrap());
        std::thread::spawn(move || {
            for line in output.lines().map_while(Result::ok) {
                let _ = tell.send(line);
            }
        });
        let server = Self { child, lines };
        assert!(server.says("ready"), "the server did not begin");
        server
    }

    /// Whether a line that begins so comes within ten seconds.
    fn says(&self, beginning: &str) -> bool {
        self.line(beginning).is_some()
    }

    /// The next line that begins so, within ten seconds.
    fn line(&self, beginning: &str) -> Option<String> {
        let next = || self.lines.recv_timeout(Duration::from_secs(10)).ok();
        std::iter::from_fn(next).find(|line| line.starts_with(beginning))
    }

    /// The lines up to now.
    fn told(&self) -> Vec<String> {
        self.lines.try_iter().collect()
    }

    fn kill(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.kill();
    }
}

/// The rig file that `rig scan` writes for the bench's port, changed by `edit`; its name.
///
/// Stalls of the host are to cost ticks and not the run, those too of the kernel's worker that carries a pty's bytes: the watchdog is a
/// slow one.
fn rig(bench: &Bench, edit: impl Fn(String) -> String) -> String {
    let port = bench.path("port");
    let _ = std::fs::remove_file(bench.path("rig.toml"));
    let output = bench.run(&["rig", "scan", &port.to_string_lossy(), "--out", "rig.toml"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let text = std::fs::read_to_string(bench.path("rig.toml")).unwrap();
    let slow = text.replace("timeout_s = 0.1 ", "timeout_s = 1.0 ").replace("stale_ticks = 20 ", "stale_ticks = 800 ");
    let slow = slow.replace("following_error_rad = 0.5", "following_error_rad = 5.0");
    let slow = slow.replace("speed_rad_s = 60.0", "speed_rad_s = 200.0");
    assert_ne!(slow, text);
    std::fs::write(bench.path("rig.toml"), edit(slow)).unwrap();
    "rig.toml".to_owned()
}

/// The same with a torque sensor on an analogue pin.
fn with_sensor(text: &str) -> String {
    let from_current = "source = \"torque\"";
    assert!(text.contains(from_current) && text.contains("of_motor = true"));
    text.replace(from_current, "source = \"aux1_analog1\"\noffset = -500.0")
        .replace("of_motor = true", "of_motor = false")
}
