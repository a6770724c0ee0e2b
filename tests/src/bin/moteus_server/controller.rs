//! A controller: registers, modes, a watchdog, and the faults that it is told to have.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore as _, SeedableRng as _};

use crate::plant::Plant;
use crate::wire::{Request, answer};

const STOPPED: u8 = 0;
const FAULT: u8 = 1;
const ENABLING: u8 = 2;
const POSITION: u8 = 10;
const TIMEOUT: u8 = 11;

/// Time that switching on takes, s.
const SWITCHES_ON_S: f64 = 0.02;
/// RMS of the torque's noise, mNm.
const TORQUE_NOISE_MNM: f64 = 0.1;

/// What goes wrong, some time after the first torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Trouble {
    /// The motor driver gives up.
    DriverFault,
    /// It stops answering, and goes on living.
    Silence,
    /// What it answers is no answer.
    Garbage,
    /// Its answers have wrong checksums.
    Checksum,
    /// It begins anew.
    Restart,
    /// It refuses to switch on, from the beginning.
    Unconfigured,
    /// Without commands it goes on, from the beginning.
    NoWatchdog,
    /// It answers too late, from the beginning.
    Slow,
}

/// What a controller is made of, and does wrong.
pub struct Controller {
    pub plant: Plant,
    pub trouble: Option<Trouble>,
    pub trouble_after_s: f64,
    /// Counts of the encoder a turn; 0 for none.
    pub counts_per_turn: f64,
    pub timeout_mode: u8,
    mode: u8,
    fault: u8,
    switched_on_s: f64,
    commanded_s: f64,
    watchdog_s: f64,
    feedforward_nm: f64,
    most_torque_nm: f64,
    first_torque_s: Option<f64>,
    began_s: f64,
    origin_rev: f64,
    stream: Vec<u8>,
    noise: Xoshiro256PlusPlus,
    /// What happened, for whoever watches.
    pub events: Vec<String>,
}

/// What a control cycle measured.
struct Measured {
    mode: u8,
    torque_nm: f64,
    sensor_mnm: f64,
}

impl Controller {
    pub fn new() -> Self {
        Self {
            plant: Plant::new(),
            trouble: None,
            trouble_after_s: 1.0,
            counts_per_turn: 0.0,
            timeout_mode: 12,
            mode: STOPPED,
            fault: 0,
            switched_on_s: 0.0,
            commanded_s: 0.0,
            watchdog_s: f64::NAN,
            feedforward_nm: 0.0,
            most_torque_nm: f64::INFINITY,
            first_torque_s: None,
            began_s: 0.0,
            origin_rev: 0.0,
            stream: Vec::new(),
            noise: Xoshiro256PlusPlus::seed_from_u64(1),
            events: Vec::new(),
        }
    }

    /// Carries controller and plant on to now.
    pub fn turn_to(&mut self, now_s: f64) {
        let has_expired = self.mode == POSITION && self.trouble != Some(Trouble::NoWatchdog);
        if has_expired && now_s - self.commanded_s > self.watchdog_s {
            self.plant.turn_to(self.commanded_s + self.watchdog_s);
            self.plant.motor_mnm = 0.0;
            self.enter(TIMEOUT);
            self.events.push(format!("timeout {:.4} s after the last command", self.watchdog_s));
        }
        if self.has_trouble(now_s, Trouble::DriverFault) && self.mode == POSITION {
            self.fault = 33;
            self.plant.motor_mnm = 0.0;
            self.enter(FAULT);
        }
        if self.has_trouble(now_s, Trouble::Restart) {
            self.trouble = None;
            (self.began_s, self.origin_rev, self.plant.motor_mnm) = (now_s, self.plant.position(), 0.0);
            self.enter(STOPPED);
        }
        self.plant.turn_to(now_s);
    }

    /// Whether it has this trouble now.
    pub fn has_trouble(&self, now_s: f64, trouble: Trouble) -> bool {
        self.trouble == Some(trouble)
            && self.first_torque_s.is_some_and(|first_s| now_s - first_s > self.trouble_after_s)
    }

    fn enter(&mut self, mode: u8) {
        if mode != self.mode {
            self.events.push(format!("mode {mode}"));
        }
        self.mode = mode;
    }

    /// What it answers to these requests at this time.
    pub fn serve(&mut self, requests: &[Request], now_s: f64) -> Vec<u8> {
        self.turn_to(now_s);
        // What is told is what was measured in the last control cycle, before this command.
        let measured = Measured {
            mode: self.mode,
            torque_nm: 1e-3 * (self.plant.motor_mnm + TORQUE_NOISE_MNM * self.normal()),
            sensor_mnm: self.plant.sensor_mnm(),
        };
        let commanded: Vec<(u32, f64)> = requests
            .iter()
            .filter_map(|request| match request {
                Request::Write { register, value } => Some((*register, *value)),
                _ => None,
            })
            .collect();
        self.command(&commanded, now_s);
        let mut reply = Vec::new();
        for request in requests {
            match request {
                Request::Read { kind, first, count } => {
                    let values: Vec<f64> =
                        (*first..first + count).map(|register| self.told(register, &measured, now_s)).collect();
                    answer(&mut reply, *kind, *first, &values);
                }
                Request::Said { channel: 1, text } => self.hear(&String::from_utf8_lossy(text)),
                Request::Poll { channel: 1, most } => {
                    let length = self.stream.len().min(usize::from(*most));
                    let text: Vec<u8> = self.stream.drain(..length).collect();
                    reply.extend([0x41, 1, u8::try_from(length).unwrap_or(0)]);
                    reply.extend(text);
                }
                _ => {}
            }
        }
        reply
    }

    fn command(&mut self, commanded: &[(u32, f64)], now_s: f64) {
        let of = |wanted: u32| commanded.iter().find(|(register, _)| *register == wanted).map(|(_, value)| *value);
        let Some(mode) = of(0x000) else { return };
        if mode == f64::from(STOPPED) {
            (self.fault, self.plant.motor_mnm) = (0, 0.0);
            return self.enter(STOPPED);
        }
        if mode != f64::from(POSITION) || matches!(self.mode, FAULT | TIMEOUT) {
            return;
        }
        if self.trouble == Some(Trouble::Unconfigured) {
            self.fault = 36;
            return self.enter(FAULT);
        }
        if self.mode == STOPPED {
            self.switched_on_s = now_s + SWITCHES_ON_S;
            self.enter(ENABLING);
        }
        if self.mode == ENABLING && now_s >= self.switched_on_s {
            self.enter(POSITION);
        }
        (self.feedforward_nm, self.commanded_s) = (of(0x022).unwrap_or(0.0), now_s);
        self.most_torque_nm = of(0x025).filter(|most_nm| most_nm.is_finite()).unwrap_or(f64::INFINITY);
        self.watchdog_s = of(0x027).filter(|time_s| *time_s != 0.0).unwrap_or(0.1);
        if self.mode == POSITION {
            self.plant.motor_mnm = 1e3 * self.feedforward_nm.clamp(-self.most_torque_nm, self.most_torque_nm);
            if self.plant.motor_mnm != 0.0 {
                self.first_torque_s.get_or_insert(now_s);
            }
        }
    }

    fn told(&self, register: u32, measured: &Measured, now_s: f64) -> f64 {
        let &Measured { mode, torque_nm, sensor_mnm } = measured;
        let turned = self.plant.position() - self.origin_rev;
        match register {
            0x000 => f64::from(mode),
            0x001 if self.counts_per_turn > 0.0 => (turned * self.counts_per_turn).floor() / self.counts_per_turn,
            0x001 => turned,
            0x002 => self.plant.velocity_rad_s / std::f64::consts::TAU,
            0x003 => torque_nm,
            0x004 => torque_nm / 0.0164,
            0x00d => 24.0,
            0x00e => 30.0,
            0x00f => f64::from(self.fault),
            // A torque sensor of ±500 mNm on the pin's whole range.
            0x060 => 0.5 + sensor_mnm / 1000.0,
            0x070 => (1e3 * (now_s - self.began_s)).floor(),
            0x100 => 1.0,
            0x101 => f64::from(0x01_03_04),
            0x102 => 5.0,
            _ => 0.0,
        }
    }

    /// The stream for people: two commands of its many.
    fn hear(&mut self, line: &str) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let said = match words[..] {
            ["conf", "get", "servo.timeout_mode"] => format!("{}\r\n", self.timeout_mode),
            ["conf", "set", "servo.timeout_mode", value] => {
                self.timeout_mode = value.parse().unwrap_or(self.timeout_mode);
                "OK\r\n".to_owned()
            }
            _ => "ERR unknown command\r\n".to_owned(),
        };
        self.stream.extend(said.bytes());
    }

    /// Standard normal, as the sum of twelve uniform numbers.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| f64::from(self.noise.next_u32()) / f64::from(u32::MAX)).sum::<f64>() - 6.0
    }
}
