//! The registers that a run writes and reads: <https://mjbots.github.io/moteus/protocol/registers/>.

use moteus_protocol::command::{PositionCommand, PositionFormat, StopCommand};
use moteus_protocol::query::QueryFormat;
use moteus_protocol::{
    CanFdFrame, Mode, Register, Resolution, Subframe, SubframeType, Value, calculate_arbitration_id,
    parse_arbitration_id, parse_frame, scaling,
};

use crate::MOST_CHANNELS;

/// What a controller can tell: the names that a rig file has for it, and the register of each. Revolutions, revolutions a second,
/// N·m, A; what an analogue pin reads is a share of its range, 0 to 1.
pub(super) const CHANNELS: [(&str, Register); MOST_CHANNELS] = [
    ("position", Register::Position),
    ("velocity", Register::Velocity),
    ("torque", Register::Torque),
    ("q_current", Register::QCurrent),
    ("abs_position", Register::AbsPosition),
    ("encoder1_position", Register::Encoder1Position),
    ("aux1_analog1", Register::Aux1AnalogIn1),
    ("aux1_analog2", Register::Aux1AnalogIn2),
    ("aux1_analog3", Register::Aux1AnalogIn3),
    ("aux1_analog4", Register::Aux1AnalogIn4),
    ("aux1_analog5", Register::Aux1AnalogIn5),
    ("aux2_analog1", Register::Aux2AnalogIn1),
    ("aux2_analog2", Register::Aux2AnalogIn2),
    ("aux2_analog3", Register::Aux2AnalogIn3),
    ("aux2_analog4", Register::Aux2AnalogIn4),
    ("aux2_analog5", Register::Aux2AnalogIn5),
];

/// Most bytes of a reply.
const REPLY_BYTES: usize = 64;

/// What a controller is asked for at every tick.
#[derive(Clone)]
pub(super) struct Query {
    format: QueryFormat,
    /// Bit i: channel i.
    asked: u32,
}

impl Query {
    /// Asks for mode, fault, the millisecond counter and these channels; `None` where an answer cannot hold them all.
    pub(super) fn of(sources: &[&str]) -> Option<Self> {
        let mut format = nothing();
        (format.mode, format.fault) = (Resolution::Int8, Resolution::Int8);
        format.add_extra(Register::MillisecondCounter.address(), Resolution::Int32);
        let mut asked = 0;
        for (index, (name, register)) in CHANNELS.iter().enumerate() {
            if !sources.contains(name) {
                continue;
            }
            asked |= 1 << index;
            match register {
                Register::Position => format.position = Resolution::Float,
                Register::Velocity => format.velocity = Resolution::Float,
                Register::Torque => format.torque = Resolution::Float,
                Register::QCurrent => format.q_current = Resolution::Float,
                Register::AbsPosition => format.abs_position = Resolution::Float,
                other => format.add_extra(other.address(), Resolution::Float),
            }
        }
        let reply_bytes = usize::from(format.serialize(&mut CanFdFrame::new()));
        (reply_bytes <= REPLY_BYTES).then_some(Self { format, asked })
    }

    /// The channels that it asks for, bit by bit.
    pub(super) fn asked(&self) -> u32 {
        self.asked
    }

    /// A frame to the controller that asks and commands nothing.
    pub(super) fn frame(&self, address: Address) -> CanFdFrame {
        let mut frame = address.frame(0);
        self.format.serialize(&mut frame);
        frame
    }

    /// A frame that commands a torque and asks.
    pub(super) fn commanding(&self, address: Address, tag: i8, drive: &Drive, torque_nm: f64) -> CanFdFrame {
        let mut frame = address.frame(tag);
        drive.write(&mut frame, torque_nm);
        self.format.serialize(&mut frame);
        frame
    }
}

/// A query for nothing.
fn nothing() -> QueryFormat {
    let mut format = QueryFormat::minimal();
    let QueryFormat { mode, position, velocity, torque, .. } = &mut format;
    for resolution in [mode, position, velocity, torque] {
        *resolution = Resolution::Ignore;
    }
    format
}

/// Sender identifier of frames whose answers nobody waits for.
const UNHEARD: i8 = 126;

/// Whom frames go to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Address {
    /// The controller's identifier, 1 to 127.
    pub(super) id: i8,
    /// The upper half of CAN identifiers, as `can.prefix` of the controller has it.
    pub(super) prefix: u16,
}

impl Address {
    /// An empty frame to the controller from the sender `tag`, to which the answer is to go.
    fn frame(self, tag: i8) -> CanFdFrame {
        let mut frame = CanFdFrame::new();
        frame.arbitration_id = calculate_arbitration_id(tag, self.id, self.prefix, true);
        frame
    }

    /// A frame that switches the motor off, and clears a fault.
    pub(super) fn stop(self) -> CanFdFrame {
        let mut frame = self.frame(UNHEARD);
        StopCommand::serialize(&mut frame);
        frame
    }

    /// A frame that reads integers from `register` on.
    pub(super) fn read_integers(self, register: Register, count: u8) -> CanFdFrame {
        let mut frame = self.frame(0);
        let mut writer = moteus_protocol::WriteCanData::new(&mut frame);
        writer.write_u8(moteus_protocol::READ_INT32);
        writer.write_u8(count);
        writer.write_varuint(u32::from(register.address()));
        frame
    }

    /// A frame with these bytes.
    pub(super) fn bytes(self, fill: impl FnOnce(&mut [u8; 64]) -> u8) -> CanFdFrame {
        let mut frame = self.frame(0);
        frame.size = fill(&mut frame.data);
        frame
    }

    /// A frame, sent as `tag`.
    pub(super) fn sent_as(self, tag: i8, frame: &CanFdFrame) -> CanFdFrame {
        let mut sent = frame.clone();
        sent.arbitration_id = self.frame(tag).arbitration_id;
        sent
    }

    /// Whether a frame is the controller's answer to the sender `tag`. An answer addressed to nobody counts too, since it does not
    /// say what it answers.
    pub(super) fn answers(self, tag: i8, frame: &CanFdFrame) -> bool {
        let (from, to, _) = parse_arbitration_id(frame.arbitration_id);
        from == self.id && (to == tag || to == 0)
    }

    /// Whether a frame comes from the controller.
    pub(super) fn is_from(self, frame: &CanFdFrame) -> bool {
        parse_arbitration_id(frame.arbitration_id).0 == self.id
    }
}

/// How torque is commanded: position mode without position, where alone the controller takes a watchdog's time with every command.
#[derive(Clone)]
pub(super) struct Drive {
    format: PositionFormat,
    /// Most torque, N·m.
    most_torque_nm: f64,
    /// Time without a command after which the torque is to be gone, s.
    watchdog_s: f64,
}

impl Drive {
    pub(super) fn new(most_torque_nm: f64, watchdog_s: f64) -> Self {
        let mut format = PositionFormat::default();
        let PositionFormat { position, velocity, kp_scale, kd_scale, ilimit_scale, ignore_position_bounds, .. } =
            &mut format;
        for resolution in [position, velocity, kp_scale, kd_scale, ilimit_scale, ignore_position_bounds] {
            // These are only ever zero, one, or NaN for the present position: a byte holds them.
            *resolution = Resolution::Int8;
        }
        Self { format, most_torque_nm, watchdog_s }
    }

    fn write(&self, frame: &mut CanFdFrame, torque_nm: f64) {
        PositionCommand::new()
            .position(f32::NAN)
            .velocity(0.0)
            .feedforward_torque(torque_nm as f32)
            .kp_scale(0.0)
            .kd_scale(0.0)
            .ilimit_scale(0.0)
            .maximum_torque(self.most_torque_nm as f32)
            .watchdog_timeout(self.watchdog_s as f32)
            .ignore_position_bounds(1.0)
            .serialize(frame, &self.format);
    }
}

/// An answer to a query.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reply {
    pub(super) mode: Option<Mode>,
    pub(super) fault: i32,
    /// Milliseconds since the controller began, wrapping round.
    pub(super) counter_ms: Option<i32>,
    /// By channel.
    pub(super) values: [f64; MOST_CHANNELS],
    /// Bit i: channel i has a number.
    pub(super) valid: u32,
}

impl Reply {
    /// What a frame of the controller's answers.
    pub(super) fn of(frame: &CanFdFrame) -> Self {
        let mut reply = Self { mode: None, fault: 0, counter_ms: None, values: [f64::NAN; MOST_CHANNELS], valid: 0 };
        for (register, value) in registers(frame) {
            if register == Register::Mode.address() {
                reply.mode = u8::try_from(value.to_i32()).ok().and_then(|mode| Mode::try_from(mode).ok());
            } else if register == Register::Fault.address() {
                reply.fault = value.to_i32();
            } else if register == Register::MillisecondCounter.address() {
                reply.counter_ms = Some(value.to_i32());
            } else if let Some(index) = CHANNELS.iter().position(|(_, known)| known.address() == register) {
                // Channels are requested as floats, to which the crate applies no scaling.
                let number = f64::from(value.to_f32(&scaling::INT));
                reply.values[index] = number;
                reply.valid |= u32::from(number.is_finite()) << index;
            }
        }
        reply
    }
}

/// The registers that a frame answers with.
pub(super) fn registers(frame: &CanFdFrame) -> impl Iterator<Item = (u16, Value)> {
    parse_frame(frame.payload()).filter_map(|subframe| match subframe {
        Subframe::Register { subframe_type: SubframeType::Response, register, value, .. } => Some((register, value?)),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
    use super::*;

    const ADDRESS: Address = Address { id: 1, prefix: 0 };

    #[test]
    fn a_command_says_torque_limit_and_watchdog_and_nothing_else_that_drives() {
        let frame = Query::of(&["position", "torque"]).unwrap().commanding(ADDRESS, 3, &Drive::new(0.5, 0.1), 0.25);
        assert_eq!(frame.arbitration_id, 0x8301);
        let written: Vec<(u16, f32)> = parse_frame(frame.payload())
            .filter_map(|subframe| match subframe {
                Subframe::Register { subframe_type: SubframeType::Write, register, value, .. } => {
                    Some((register, value?.to_f32(&scaling::INT)))
                }
                _ => None,
            })
            .collect();
        assert_eq!((written[0], written[1].0), ((0x000, 10.0), 0x020));
        assert!(written[1].1.is_nan(), "no position is asked for");
        let rest: Vec<(u16, f32)> = written[2..].to_vec();
        assert_eq!(rest[..4], [(0x021, 0.0), (0x022, 0.25), (0x023, 0.0), (0x024, 0.0)]);
        assert_eq!(rest[4..6], [(0x025, 0.5), (0x027, 0.1)]);
    }

    #[test]
    fn an_answer_is_taken_apart_as_the_vendors_example_has_it() {
        let mut frame = CanFdFrame::new();
        frame.arbitration_id = 0x0105;
        let bytes = [0x21, 0x00, 0x0a, 0x2d, 0x01, 0x00, 0x00, 0x00, 0x3f, 0x21, 0x0f, 0x22, 0x31, 0x70, 0x01];
        frame.data[..bytes.len()].copy_from_slice(&bytes);
        frame.size = u8::try_from(bytes.len()).unwrap();
        let reply = Reply::of(&frame);
        assert_eq!((reply.mode, reply.fault, reply.counter_ms), (Some(Mode::Position), 34, None));
        assert!(ADDRESS.answers(5, &frame) && !ADDRESS.answers(4, &frame));
        assert_eq!((reply.values[0], reply.valid), (0.5, 1));
    }

    #[test]
    fn an_answer_holds_what_a_rig_needs_and_not_every_channel() {
        let all: Vec<&str> = CHANNELS.iter().map(|(name, _)| *name).collect();
        assert!(Query::of(&all).is_none());
        let usual = Query::of(&["position", "torque", "aux1_analog1", "aux2_analog5"]).unwrap();
        assert_eq!(usual.asked(), 1 | 1 << 2 | 1 << 6 | 1 << 15);
        assert!(usual.commanding(ADDRESS, 1, &Drive::new(1.0, 0.1), 0.0).size <= 64);
    }
}
