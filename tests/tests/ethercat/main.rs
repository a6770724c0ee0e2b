//! The EtherCAT driver on a segment that shares no code with it: frames on a pair of virtual interfaces, in a network of their own.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test may stop at a failure, and says when it skips")]

mod allocation;
mod captures;
mod commands;
mod faults;

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use archive::Capture;
use nix::sched::{CloneFlags, unshare};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use tests::{Bench, printed, program};

/// The interface that the driver has, and the one that the segment has.
const OURS: &str = "hc0";
const THEIRS: &str = "hc1";

/// The rig's file: the torque from a sensor's amplifier, the acceleration from the same terminal.
const RIG: &str = r#"
name = "servo"
driver = "ethercat"

[settings]
interface = "hc0"

[settings.drive]
vendor = 0xabcdef
product = 0x402
outputs = ["0x6040:00/16", "0x6071:00/16", "0x6060:00/8"]
inputs = ["0x6041:00/16", "0x6064:00/32", "0x6077:00/16", "0x603f:00/16", "0x6061:00/8"]

[settings.terminals.sensor]
position = 1

[channels.angle]
source = "drive.position"

[channels.torque]
source = "sensor.0x6000:11"
scale = 0.001

[channels.acceleration]
source = "sensor.0x6010:11"
scale = 0.5

[channels.motor]

[limits]
motor_torque_mnm = 300.0
sensor_torque_mnm = 1000.0
speed_rad_s = 60.0
angle_rad = 60.0
following_error_rad = 0.5
rate_hz = 8000.0

[rates]
slowest_hz = 500.0
fastest_hz = 8000.0

[watchdog]
timeout_s = 0.5
stale_ticks = 400

[calibration]
motor_inertia = 0.02
angle_step_rad = 1.1984224905356571e-5
torque_step_mnm = 0.001
acceleration_step_rad_s2 = 0.5
"#;

/// A bench in a network of its own, with the segment on the other end of the wire.
struct Wired {
    segment: Running,
    bench: Bench,
    /// One bench at a time: all pin their loops to the same core.
    _turn: MutexGuard<'static, ()>,
}

/// A running segment; killed when this is dropped.
struct Running {
    child: Child,
    lines: Receiver<String>,
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Running {
    fn start(options: &[&str]) -> Self {
        let mut command = Command::new(program("ethercat_segment").unwrap());
        let mut child = command.args(["--interface", THEIRS]).args(options).stdout(Stdio::piped()).spawn().unwrap();
        let output = BufReader::new(child.stdout.take().unwrap());
        let (tell, lines) = channel();
        std::thread::spawn(move || output.lines().map_while(Result::ok).try_for_each(|line| tell.send(line)));
        Self { child, lines }
    }

    fn pid(&self) -> Pid {
        Pid::from_raw(self.child.id().cast_signed())
    }

    fn signal(&self, signal: Signal) {
        kill(self.pid(), signal).unwrap();
    }

    /// Waits until the drive says so.
    fn wait_for(&self, words: &str) -> String {
        let mut said = Vec::new();
        loop {
            match self.lines.recv_timeout(Duration::from_secs(20)) {
                Ok(line) if line.contains(words) => return line,
                Ok(line) => said.push(line),
                Err(error) => panic!("'{words}' was never said ({error}), but {said:?}"),
            }
        }
    }
}

fn ip(arguments: &str) -> bool {
    Command::new("ip").args(arguments.split(' ')).status().is_ok_and(|status| status.success())
}

impl Wired {
    /// `None`, which is said, where this process may not have a network of its own.
    fn new(options: &[&str]) -> Option<Self> {
        static TURN: Mutex<()> = Mutex::new(());
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let bench = Bench::new().unwrap();
        // Of this thread, and of whatever it starts.
        if let Err(error) = unshare(CloneFlags::CLONE_NEWNET) {
            eprintln!("SKIPPED: no network of its own can be had ({error}); run the tests as root");
            return None;
        }
        let made = ip(&format!("link add {OURS} type veth peer name {THEIRS}"))
            && ip(&format!("link set {OURS} up"))
            && ip(&format!("link set {THEIRS} up"));
        if !made {
            eprintln!("SKIPPED: no pair of virtual interfaces can be had (`ip link add type veth`)");
            return None;
        }
        let wired = Self { segment: Running::start(options), bench, _turn: turn };
        wired.rig(|text| text);
        Some(wired)
    }

    /// Writes the rig's file, changed by `edit`.
    fn rig(&self, edit: impl Fn(String) -> String) {
        std::fs::write(self.bench.path("rig.toml"), edit(RIG.to_owned())).unwrap();
    }

    /// Captures; the error output, its exit status, and the archive if there is one.
    fn capture(&self, rate_hz: &str, duration_s: &str) -> (String, Option<i32>, Option<Capture>) {
        let _ = std::fs::remove_dir_all(self.bench.path("out"));
        let mut arguments = vec!["capture", "--rig", "rig.toml", "--rate-hz", rate_hz, "--duration-s", duration_s];
        arguments.extend(["--no-viewer", "--out", "out"]);
        let output = self.bench.run(&arguments).unwrap();
        let archive = self.bench.only_archive("out").ok().map(|archive| Capture::load(&archive).unwrap());
        (printed(&output), output.status.code(), archive)
    }
}
