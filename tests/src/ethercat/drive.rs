//! The drive's own state machine (IEC 61800-7-201), and its objects.

use super::objects::Objects;

/// What a target of 1000 stands for, mNm.
pub const RATED_TORQUE_MNM: f64 = 100.0;
/// Increments of the encoder in a turn.
pub const COUNTS_PER_TURN: f64 = 524_288.0;
/// Time that the power stage takes to come on, ns.
const COMES_ON_NS: u64 = 3_000_000;
/// Cyclic synchronous position, in 0x6061.
const CYCLIC_POSITION: u32 = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    SwitchOnDisabled,
    ReadyToSwitchOn,
    SwitchedOn,
    OperationEnabled,
    Fault,
}

/// The drive.
#[derive(Debug)]
pub struct Drive {
    state: State,
    before: u16,
    enabling_since_ns: Option<u64>,
    pub enabled_since_ns: Option<u64>,
    /// Whether it is in another mode than it is asked for.
    pub leaves_mode: bool,
}

/// The objects of the drive, with a mapping that has no torque in it, as drives come.
pub fn objects() -> Objects {
    let mut objects = Objects::default();
    objects.constant(0x1000, 0, 4, 0x0002_0192);
    objects.list(0x1600, 4, &[0x6040_0010, 0x607a_0020], 8);
    objects.list(0x1a00, 4, &[0x6041_0010, 0x6064_0020], 8);
    objects.list(0x1c12, 2, &[0x1600], 4);
    objects.list(0x1c13, 2, &[0x1a00], 4);
    for (index, bytes, is_writable) in [
        (0x603f, 2, false),
        (0x6040, 2, true),
        (0x6041, 2, false),
        (0x6060, 1, true),
        (0x6061, 1, false),
        (0x6064, 4, false),
        (0x606c, 4, false),
        (0x6071, 2, true),
        (0x6077, 2, false),
        (0x607a, 4, true),
    ] {
        objects.exchanged(index, 0, bytes, is_writable);
    }
    objects.constant(0x6076, 0, 4, RATED_TORQUE_MNM as u32);
    objects.constant(0x608f, 0, 1, 2);
    objects.parameter(0x608f, 1, 4, COUNTS_PER_TURN as u32);
    objects.parameter(0x608f, 2, 4, 1);
    objects.parameter(0x60c2, 1, 1, 1);
    objects.parameter(0x60c2, 2, 1, 0xfd);
    objects.constant(0x6502, 0, 4, 0x0000_03ad);
    objects
}

impl Drive {
    pub fn new() -> Self {
        Self {
            state: State::SwitchOnDisabled,
            before: 0,
            enabling_since_ns: None,
            enabled_since_ns: None,
            leaves_mode: false,
        }
    }

    /// Goes on by the controlword; gives the torque that the motor makes, mNm.
    pub fn take(&mut self, objects: &mut Objects, is_operational: bool, now_ns: u64) -> f64 {
        use State as S;
        let word = objects.get(0x6040, 0) as u16;
        let mode = if self.leaves_mode { CYCLIC_POSITION } else { objects.get(0x6060, 0) };
        objects.set(0x6061, 0, mode);
        if self.state == S::Fault {
            if word & 0x80 != 0 && self.before & 0x80 == 0 && is_operational {
                self.state = S::SwitchOnDisabled;
                objects.set(0x603f, 0, 0);
            }
        } else if !is_operational || word & 2 == 0 {
            self.state = S::SwitchOnDisabled;
        } else {
            self.state = match (self.state, word & 0x0f) {
                (S::SwitchOnDisabled | S::SwitchedOn | S::OperationEnabled, 0x06) => S::ReadyToSwitchOn,
                (S::ReadyToSwitchOn | S::OperationEnabled, 0x07) => S::SwitchedOn,
                (S::ReadyToSwitchOn, 0x0f) => S::SwitchedOn,
                (S::SwitchedOn, 0x0f) => {
                    let since_ns = *self.enabling_since_ns.get_or_insert(now_ns);
                    if now_ns - since_ns > COMES_ON_NS { S::OperationEnabled } else { S::SwitchedOn }
                }
                (state, _) => state,
            };
        }
        self.before = word;
        if self.state != S::SwitchedOn {
            self.enabling_since_ns = None;
        }
        let is_enabled = self.state == S::OperationEnabled;
        self.enabled_since_ns = if is_enabled { Some(self.enabled_since_ns.unwrap_or(now_ns)) } else { None };
        let status = match self.state {
            S::SwitchOnDisabled => 0x0250,
            S::ReadyToSwitchOn => 0x0231,
            S::SwitchedOn => 0x0233,
            S::OperationEnabled => 0x0237,
            S::Fault => 0x0218,
        };
        objects.set(0x6041, 0, status);
        let makes_torque = is_enabled && objects.get(0x6061, 0) == 10;
        let target = objects.get(0x6071, 0) as u16;
        let torque = if makes_torque { f64::from(target.cast_signed()) } else { 0.0 };
        objects.set(0x6077, 0, u32::from((torque as i16).cast_unsigned()));
        torque / 1e3 * RATED_TORQUE_MNM
    }

    /// Its safe-torque-off input opens.
    pub fn open(&mut self) {
        self.state = State::SwitchOnDisabled;
    }

    /// Fails with a code.
    pub fn fail(&mut self, objects: &mut Objects, code: u16) {
        self.state = State::Fault;
        objects.set(0x603f, 0, u32::from(code));
    }
}
