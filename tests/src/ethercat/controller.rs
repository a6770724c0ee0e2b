//! An EtherCAT controller: memory, sync managers, memory mapping, state machine, watchdog, clock (ET1100 data sheet).

use super::eeprom::{MAILBOX_IN, MAILBOX_OUT};
use super::objects::Objects;
use super::{double_word, word};

/// Registers.
const STATION: usize = 0x0010;
const ALIAS: usize = 0x0012;
const LINK: usize = 0x0110;
const CONTROL: usize = 0x0120;
pub const STATUS: usize = 0x0130;
pub const STATUS_CODE: usize = 0x0134;
const WATCHDOG_DIVIDER: usize = 0x0400;
const WATCHDOG_COUNT: usize = 0x0420;
const EEPROM_CONTROL: usize = 0x0502;
const EEPROM_ADDRESS: usize = 0x0504;
const EEPROM_DATA: usize = 0x0508;
const MAPPINGS: usize = 0x0600;
const MANAGERS: usize = 0x0800;
const CLOCK: usize = 0x0900;
const RECEIVE_TIME: usize = 0x0918;
const SYSTEM_TIME: usize = 0x0910;
const SYSTEM_OFFSET: usize = 0x0920;
const SYNC_ACTIVE: usize = 0x0981;
const SYNC_START: usize = 0x0990;
const SYNC_PERIOD: usize = 0x09a0;

/// States.
pub const INIT: u8 = 1;
const PRE_OP: u8 = 2;
pub const SAFE_OP: u8 = 4;
pub const OP: u8 = 8;
const ERROR: u8 = 0x10;

/// Status codes.
const INVALID_OUTPUTS: u16 = 0x001d;
const INVALID_INPUTS: u16 = 0x001e;
const INVALID_STATE: u16 = 0x0011;
pub const WATCHDOG: u16 = 0x001b;

/// Sync managers: outputs and inputs.
const OUTPUTS: usize = 2;
const INPUTS: usize = 3;

/// A controller with its device's objects.
pub struct Controller {
    pub memory: Vec<u8>,
    eeprom: Vec<u8>,
    pub objects: Objects,
    /// Parts per million by which its clock is fast; `None` for a device without one.
    clock_ppm: Option<f64>,
    /// Whether its watchdog can be set.
    pub has_watchdog: bool,
    fed_ns: u64,
    is_op_asked: bool,
    answer: Option<Vec<u8>>,
}

impl Controller {
    pub fn new(eeprom: Vec<u8>, objects: Objects, clock_ppm: Option<f64>, is_last: bool) -> Self {
        let mut memory = vec![0; 0x1_0000];
        memory[0] = 0x11;
        memory[4..8].copy_from_slice(&[8, 8, 8, 0x0f]);
        memory[8] = if clock_ppm.is_some() { 0x0c } else { 0 };
        memory[ALIAS] = eeprom[8];
        memory[ALIAS + 1] = eeprom[9];
        memory[LINK] = if is_last { 0x10 } else { 0x30 };
        memory[STATUS] = INIT;
        memory[WATCHDOG_DIVIDER..][..2].copy_from_slice(&2_498_u16.to_le_bytes());
        memory[WATCHDOG_COUNT..][..2].copy_from_slice(&1_000_u16.to_le_bytes());
        let has_watchdog = true;
        Self { memory, eeprom, objects, clock_ppm, has_watchdog, fed_ns: 0, is_op_asked: false, answer: None }
    }

    pub fn state(&self) -> u8 {
        self.memory[STATUS]
    }

    fn station(&self) -> u16 {
        word(&self.memory, STATION)
    }

    /// Takes part in a datagram: command, address and data; gives what is added to its working counter.
    pub fn datagram(&mut self, command: u8, address: &mut [u8; 4], data: &mut [u8], now_ns: u64) -> u16 {
        let place = u16::from_le_bytes([address[0], address[1]]);
        let offset = usize::from(u16::from_le_bytes([address[2], address[3]]));
        let is_positional = matches!(command, 1..=3 | 7..=9 | 13);
        if is_positional {
            address[..2].copy_from_slice(&place.wrapping_add(1).to_le_bytes());
        }
        let is_meant = match command {
            1..=3 | 13 => place == 0,
            4..=6 | 14 => place == self.station(),
            7..=9 => true,
            10..=12 => return self.logical(command, u32::from_le_bytes(*address), data, now_ns),
            _ => false,
        };
        // What one device reads, others write: the clock of the first goes to all behind it.
        if matches!(command, 13 | 14) {
            let does = if is_meant { self.read(offset, data, now_ns) } else { self.write(offset, data, now_ns) };
            return u16::from(does);
        }
        if !is_meant {
            return 0;
        }
        let before = data.to_vec();
        let mut counted = 0;
        if matches!(command, 1 | 3 | 4 | 6 | 7 | 9) && self.read(offset, data, now_ns) {
            counted += 1;
            if matches!(command, 7 | 9) {
                data.iter_mut().zip(&before).for_each(|(byte, before)| *byte |= before);
            }
        }
        if matches!(command, 2 | 3 | 5 | 6 | 8 | 9) && self.write(offset, &before, now_ns) {
            counted += if matches!(command, 3 | 6 | 9) { 2 } else { 1 };
        }
        counted
    }

    fn has_registers(&self, at: usize) -> bool {
        self.clock_ppm.is_some() || !(CLOCK..0x0a00).contains(&at)
    }

    fn read(&mut self, at: usize, data: &mut [u8], now_ns: u64) -> bool {
        if !self.has_registers(at) || at + data.len() > self.memory.len() {
            return false;
        }
        if at == usize::from(MAILBOX_OUT.0) {
            let Some(answer) = self.answer.take() else { return false };
            self.memory[at..at + usize::from(MAILBOX_OUT.1)].fill(0);
            self.memory[at..at + answer.len()].copy_from_slice(&answer);
            self.memory[MANAGERS + 8 + 5] &= !8;
        }
        if at == SYSTEM_TIME {
            let time = self.system_time(now_ns);
            self.memory[SYSTEM_TIME..][..8].copy_from_slice(&time.to_le_bytes());
        }
        data.copy_from_slice(&self.memory[at..at + data.len()]);
        true
    }

    fn write(&mut self, at: usize, data: &[u8], now_ns: u64) -> bool {
        if !self.has_registers(at) || at + data.len() > self.memory.len() {
            return false;
        }
        if at == usize::from(MAILBOX_IN.0) {
            if self.state() & 0x0f < PRE_OP || data.len() < 16 {
                return false;
            }
            self.answer = self.objects.answer(data);
            if self.answer.is_some() {
                self.memory[MANAGERS + 8 + 5] |= 8;
            }
            return true;
        }
        if at == SYSTEM_TIME {
            return true;
        }
        self.memory[at..at + data.len()].copy_from_slice(data);
        let touches = |register: usize| (at..at + data.len()).contains(&register);
        if touches(EEPROM_CONTROL + 1) {
            self.read_eeprom();
        }
        if touches(CONTROL) {
            self.ask_state(self.memory[CONTROL]);
        }
        if touches(CLOCK) {
            let time = self.local_time(now_ns);
            self.memory[CLOCK..][..4].copy_from_slice(&(time as u32).to_le_bytes());
            self.memory[CLOCK + 4..][..4].copy_from_slice(&(time as u32).wrapping_add(600).to_le_bytes());
            self.memory[RECEIVE_TIME..][..8].copy_from_slice(&time.to_le_bytes());
        }
        if touches(WATCHDOG_COUNT) && !self.has_watchdog {
            self.memory[WATCHDOG_COUNT..][..2].fill(0);
        }
        true
    }

    fn read_eeprom(&mut self) {
        if self.memory[EEPROM_CONTROL + 1] & 1 != 0 {
            let at = 2 * double_word(&self.memory, EEPROM_ADDRESS) as usize;
            for offset in 0..8 {
                self.memory[EEPROM_DATA + offset] = self.eeprom.get(at + offset).copied().unwrap_or(0xff);
            }
        }
        // Eight bytes at a time, never busy, no error.
        self.memory[EEPROM_CONTROL..][..2].copy_from_slice(&[0x40, 0]);
    }

    /// Moves to the state that is asked for, or says why not (ETG.1000.6, 6.4).
    fn ask_state(&mut self, asked: u8) {
        let now = self.state();
        if now & ERROR != 0 && asked & ERROR == 0 {
            return;
        }
        let (now, asked) = (now & 0x0f, asked & 0x0f);
        self.is_op_asked = false;
        let fits = |manager: usize, assignment: u16| {
            let length = usize::from(word(&self.memory, MANAGERS + 8 * manager + 2));
            length == self.objects.mapped_bytes(assignment)
        };
        let refused = match asked {
            INIT => None,
            PRE_OP => None,
            SAFE_OP if now == INIT => Some(INVALID_STATE),
            SAFE_OP if !fits(OUTPUTS, 0x1c12) => Some(INVALID_OUTPUTS),
            SAFE_OP if !fits(INPUTS, 0x1c13) => Some(INVALID_INPUTS),
            SAFE_OP => None,
            OP if now == SAFE_OP || now == OP => None,
            _ => Some(INVALID_STATE),
        };
        match (refused, asked) {
            (Some(code), _) => self.fall(now, code),
            (None, OP) if self.objects.mapped_bytes(0x1c12) > 0 => {
                // It waits for outputs.
                self.is_op_asked = true;
                self.settle(now);
            }
            (None, _) => self.settle(asked),
        }
    }

    fn settle(&mut self, state: u8) {
        self.memory[STATUS] = state;
        self.memory[STATUS_CODE..][..2].fill(0);
    }

    /// Drops to a state with an error.
    pub fn fall(&mut self, state: u8, code: u16) {
        self.memory[STATUS] = state | ERROR;
        self.memory[STATUS_CODE..][..2].copy_from_slice(&code.to_le_bytes());
        self.is_op_asked = false;
    }

    /// Whether process data have stayed away for longer than the watchdog has; 0 is never.
    pub fn is_starved(&self, now_ns: u64) -> bool {
        let divider = u64::from(word(&self.memory, WATCHDOG_DIVIDER)) + 2;
        let time_ns = u64::from(word(&self.memory, WATCHDOG_COUNT)) * divider * 40;
        let feeds = self.memory[MANAGERS + 8 * OUTPUTS + 4] & 0x40 != 0;
        self.state() == OP && feeds && time_ns > 0 && now_ns.saturating_sub(self.fed_ns) > time_ns
    }

    /// Reads and writes of process data, by the memory mapping.
    fn logical(&mut self, command: u8, address: u32, data: &mut [u8], now_ns: u64) -> u16 {
        let mut counted = 0;
        for mapping in 0..8 {
            let at = MAPPINGS + 16 * mapping;
            let (start, length) = (double_word(&self.memory, at), u32::from(word(&self.memory, at + 4)));
            let physical = usize::from(word(&self.memory, at + 8));
            let (kind, is_on) = (self.memory[at + 11], self.memory[at + 12] & 1 == 1);
            if !is_on || start < address || start + length > address + data.len() as u32 {
                continue;
            }
            let bytes = (start - address) as usize..(start + length - address) as usize;
            if kind & 1 == 1 && matches!(command, 10 | 12) && self.state() & 0x0f >= SAFE_OP {
                let length = length as usize;
                let mut inputs = vec![0; length];
                self.objects.pack(0x1c13, &mut inputs);
                self.memory[physical..physical + length].copy_from_slice(&inputs);
                data[bytes].copy_from_slice(&inputs);
                counted += 1;
            } else if kind & 2 == 2 && matches!(command, 11 | 12) && self.state() & 0x0f >= SAFE_OP {
                self.memory[physical..physical + length as usize].copy_from_slice(&data[bytes.clone()]);
                self.fed_ns = now_ns;
                if self.is_op_asked {
                    self.is_op_asked = false;
                    self.settle(OP);
                }
                if self.state() == OP {
                    self.objects.unpack(0x1c12, &data[bytes]);
                }
                counted += 2;
            }
        }
        counted
    }

    fn local_time(&self, now_ns: u64) -> u64 {
        now_ns + (now_ns as f64 * 1e-6 * self.clock_ppm.unwrap_or(0.0)) as u64
    }

    fn eight(&self, at: usize) -> u64 {
        u64::from(double_word(&self.memory, at)) | u64::from(double_word(&self.memory, at + 4)) << 32
    }

    fn system_time(&self, now_ns: u64) -> u64 {
        self.local_time(now_ns).wrapping_add(self.eight(SYSTEM_OFFSET))
    }

    /// How long ago SYNC0 was, ns, where it is on.
    pub fn since_sync_ns(&self, now_ns: u64) -> Option<u64> {
        let (start, period) = (self.eight(SYNC_START), u64::from(double_word(&self.memory, SYNC_PERIOD)));
        let time = self.system_time(now_ns);
        let is_on = self.memory[SYNC_ACTIVE] & 3 == 3 && period > 0 && time > start;
        is_on.then(|| (time - start) % period)
    }
}
