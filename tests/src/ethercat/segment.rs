//! The devices in a row, on the plant.

use std::io::Write as _;

use super::controller::{Controller, OP, SAFE_OP, STATUS, STATUS_CODE, WATCHDOG};
use super::drive::{COUNTS_PER_TURN, Drive, objects};
use super::eeprom::{MAILBOX_IN, MAILBOX_OUT, Manager, eeprom};
use super::objects::Objects;
use super::plant::Plant;
use super::word;

/// Torque that the terminal counts, mNm, and acceleration, rad/s².
pub const TORQUE_STEP_MNM: f64 = 0.001;
pub const ACCELERATION_STEP: f64 = 0.5;
/// Noise of both.
const TORQUE_NOISE_MNM: f64 = 0.25;
const ACCELERATION_NOISE: f64 = 1.0;

/// What is to go wrong, each so long after the drive was enabled, s.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Options {
    /// The drive fails with this code
    #[arg(long, value_parser = hexadecimal)]
    pub drive_error: Option<u16>,
    /// The terminal takes no part in the exchange
    #[arg(long)]
    pub terminal_absent: bool,
    /// The drive's safe-torque-off input opens
    #[arg(long)]
    pub safe_torque_off: bool,
    /// The drive goes over to another mode of operation
    #[arg(long)]
    pub other_mode: bool,
    /// When it does, s
    #[arg(long, default_value_t = 1.0)]
    pub after_s: f64,
    /// For how many frames; for ever without
    #[arg(long)]
    pub frames: Option<u32>,
    /// The drive's watchdog cannot be set
    #[arg(long)]
    pub no_watchdog: bool,
    /// Frames go back with the source that they came with
    #[arg(long)]
    pub same_source: bool,
    /// Nothing but an inertia is on the gripper
    #[arg(long)]
    pub bare: bool,
    /// By how much the drive's clock is fast, ppm
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    pub clock_ppm: f64,
}

fn hexadecimal(text: &str) -> Result<u16, String> {
    u16::from_str_radix(text.trim_start_matches("0x"), 16).map_err(|error| error.to_string())
}

/// Two devices and what they turn.
pub struct Segment {
    drive: Controller,
    terminal: Controller,
    machine: Drive,
    plant: Plant,
    /// When the sensors were read.
    sensed_ns: u64,
    options: Options,
    /// Frames that were not as they should be.
    amiss: u32,
    has_failed: bool,
    told: (u8, u16),
}

const DRIVE_MANAGERS: [Manager; 4] = [
    (MAILBOX_IN.0, MAILBOX_IN.1, 0x26, 1),
    (MAILBOX_OUT.0, MAILBOX_OUT.1, 0x22, 2),
    (0x1100, 0, 0x64, 3),
    (0x1180, 0, 0x20, 4),
];

fn terminal_objects() -> Objects {
    let mut objects = Objects::default();
    objects.constant(0x1000, 0, 4, 0x0000_1389);
    objects.list(0x1a00, 4, &[0x6000_0110, 0x6000_1120], 4);
    objects.list(0x1a01, 4, &[0x6010_1110], 4);
    objects.list(0x1c12, 2, &[], 0);
    objects.list(0x1c13, 2, &[0x1a00, 0x1a01], 4);
    objects.exchanged(0x6000, 0x01, 2, false);
    objects.exchanged(0x6000, 0x11, 4, false);
    objects.exchanged(0x6010, 0x11, 2, false);
    objects
}

impl Segment {
    /// Devices in INIT, at rest.
    #[must_use]
    pub fn new(options: Options, now_ns: u64) -> Self {
        let image = eeprom("HC-SERVO", 0x00ab_cdef, 0x0000_0402, 7, &DRIVE_MANAGERS, &[1, 2]);
        let mut drive = Controller::new(image, objects(), Some(options.clock_ppm), false);
        drive.has_watchdog = !options.no_watchdog;
        let image = eeprom("HC-ANALOG", 0x00ab_cdef, 0x0000_3104, 0, &DRIVE_MANAGERS, &[1, 2]);
        let terminal = Controller::new(image, terminal_objects(), None, true);
        let plant = Plant::at_rest(now_ns, options.bare);
        Self {
            drive,
            terminal,
            machine: Drive::new(),
            plant,
            sensed_ns: 0,
            options,
            amiss: 0,
            has_failed: false,
            told: (1, 0),
        }
    }

    /// Whether frames go back as they came but for their data.
    #[must_use]
    pub fn keeps_source(&self) -> bool {
        self.options.same_source
    }

    /// Lets time pass: the plant turns, the watchdog runs out.
    pub fn pass(&mut self, now_ns: u64) {
        if self.drive.is_starved(now_ns) {
            self.drive.fall(SAFE_OP, WATCHDOG);
        }
        // What is kept together by clocks takes its inputs at SYNC0.
        let sync_ns = self.drive.since_sync_ns(now_ns).map(|since_ns| now_ns - since_ns);
        if let Some(sync_ns) = sync_ns.filter(|sync_ns| *sync_ns > self.sensed_ns) {
            self.sense(sync_ns);
        }
        self.plant.turn_to(now_ns);
        let is_operational = self.drive.state() == OP;
        self.plant.motor_mnm = self.machine.take(&mut self.drive.objects, is_operational, now_ns);
        self.tell();
    }

    /// Says what the drive's state is whenever it has changed.
    fn tell(&mut self) {
        let now = (self.drive.memory[STATUS], word(&self.drive.memory, STATUS_CODE));
        if now != self.told {
            self.told = now;
            let line = format!("AL {:#04x} code {:#06x} torque {} mNm\n", now.0, now.1, self.plant.motor_mnm);
            let _ = std::io::stdout().write_all(line.as_bytes());
        }
    }

    fn is_amiss(&mut self, now_ns: u64) -> bool {
        let since_s = self.machine.enabled_since_ns.map_or(0.0, |since_ns| (now_ns - since_ns) as f64 * 1e-9);
        since_s > self.options.after_s && self.options.frames.is_none_or(|frames| self.amiss < frames)
    }

    /// Reads the sensors.
    fn sense(&mut self, now_ns: u64) {
        self.sensed_ns = now_ns;
        self.plant.turn_to(now_ns);
        let counts = (self.plant.angle_rad / std::f64::consts::TAU * COUNTS_PER_TURN).round() as i32;
        let speed = (self.plant.velocity_rad_s / std::f64::consts::TAU * COUNTS_PER_TURN).round() as i32;
        let torque_mnm = self.plant.sensor_mnm + TORQUE_NOISE_MNM * self.plant.noise();
        let acceleration = self.plant.acceleration_rad_s2 + ACCELERATION_NOISE * self.plant.noise();
        let objects = &mut self.drive.objects;
        objects.set(0x6064, 0, counts.cast_unsigned());
        objects.set(0x606c, 0, speed.cast_unsigned());
        let objects = &mut self.terminal.objects;
        objects.set(0x6000, 0x11, ((torque_mnm / TORQUE_STEP_MNM).round() as i32).cast_unsigned());
        objects.set(0x6010, 0x11, u32::from(((acceleration / ACCELERATION_STEP).round() as i16).cast_unsigned()));
    }

    /// Takes a frame through all devices, in place; `false` for one that is none of EtherCAT.
    pub fn process(&mut self, frame: &mut [u8], now_ns: u64) -> bool {
        if frame.len() < 28 || frame[12..14] != [0x88, 0xa4] || frame[15] >> 4 != 1 {
            return false;
        }
        self.pass(now_ns);
        let is_amiss = self.is_amiss(now_ns);
        if is_amiss
            && !self.has_failed
            && let Some(code) = self.options.drive_error
        {
            self.has_failed = true;
            self.machine.fail(&mut self.drive.objects, code);
        }
        if is_amiss && self.options.safe_torque_off {
            self.machine.open();
        }
        self.machine.leaves_mode |= is_amiss && self.options.other_mode;
        if self.drive.since_sync_ns(now_ns).is_none() {
            self.sense(now_ns);
        }
        let takes_part = !(is_amiss && self.options.terminal_absent);
        self.amiss += u32::from(!takes_part);
        let end = (16 + usize::from(word(frame, 14) & 0x07ff)).min(frame.len());
        let mut at = 16;
        while at + 12 <= end {
            let length = usize::from(word(frame, at + 6) & 0x07ff);
            let is_last = frame[at + 7] & 0x80 == 0;
            let (header, rest) = frame[at..].split_at_mut(10);
            if length + 2 > rest.len() {
                break;
            }
            let (data, counter) = rest.split_at_mut(length);
            let mut address = [header[2], header[3], header[4], header[5]];
            let mut counted = self.drive.datagram(header[0], &mut address, data, now_ns);
            if takes_part || header[0] < 10 {
                counted += self.terminal.datagram(header[0], &mut address, data, now_ns);
            }
            header[2..6].copy_from_slice(&address);
            let counter = &mut counter[..2];
            counter.copy_from_slice(&word(counter, 0).wrapping_add(counted).to_le_bytes());
            at += 12 + length;
            if is_last {
                break;
            }
        }
        self.pass(now_ns);
        true
    }
}
