//! The profile CiA 402 (IEC 61800-7-201): states, words and objects of a servo drive.

use super::entries::Object;

/// Objects of the profile that are used here.
pub(super) mod object {
    use super::Object;

    pub(in super::super) const ERROR_CODE: Object = Object::new(0x603f, 0);
    pub(in super::super) const CONTROLWORD: Object = Object::new(0x6040, 0);
    pub(in super::super) const STATUSWORD: Object = Object::new(0x6041, 0);
    pub(in super::super) const MODE: Object = Object::new(0x6060, 0);
    pub(in super::super) const MODE_DISPLAY: Object = Object::new(0x6061, 0);
    /// Increments.
    pub(in super::super) const POSITION: Object = Object::new(0x6064, 0);
    /// Increments a second.
    pub(in super::super) const VELOCITY: Object = Object::new(0x606c, 0);
    /// Thousandths of the rated torque.
    pub(in super::super) const TARGET_TORQUE: Object = Object::new(0x6071, 0);
    /// mNm.
    pub(in super::super) const RATED_TORQUE: Object = Object::new(0x6076, 0);
    /// Thousandths of the rated torque.
    pub(in super::super) const TORQUE: Object = Object::new(0x6077, 0);
    /// Increments.
    pub(in super::super) const ENCODER_INCREMENTS: Object = Object::new(0x608f, 1);
    /// Turns of the motor to which the encoder increments correspond.
    pub(in super::super) const ENCODER_TURNS: Object = Object::new(0x608f, 2);
    pub(in super::super) const INTERPOLATION_TIME: Object = Object::new(0x60c2, 1);
    pub(in super::super) const INTERPOLATION_EXPONENT: Object = Object::new(0x60c2, 2);
    pub(in super::super) const SUPPORTED_MODES: Object = Object::new(0x6502, 0);
    pub(in super::super) const DEVICE_TYPE: Object = Object::new(0x1000, 0);
}

/// Cyclic synchronous torque, in 0x6060; bit 9 of 0x6502.
pub(super) const CYCLIC_SYNCHRONOUS_TORQUE: u8 = 10;
/// The profile's number, in the low half of 0x1000.
pub(super) const PROFILE: u32 = 402;

/// The states of the drive's state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DriveState {
    NotReady,
    SwitchOnDisabled,
    ReadyToSwitchOn,
    SwitchedOn,
    OperationEnabled,
    QuickStop,
    FaultReaction,
    Fault,
}

impl DriveState {
    /// The state that a statusword tells (IEC 61800-7-201, table of 0x6041).
    pub(super) fn of(statusword: u16) -> Self {
        match statusword & 0x6f {
            0x21 => Self::ReadyToSwitchOn,
            0x23 => Self::SwitchedOn,
            0x27 => Self::OperationEnabled,
            0x07 => Self::QuickStop,
            _ => match statusword & 0x4f {
                0x40 => Self::SwitchOnDisabled,
                0x0f => Self::FaultReaction,
                0x08 => Self::Fault,
                _ => Self::NotReady,
            },
        }
    }

    /// The controlword that leads on towards `SwitchedOn`.
    ///
    /// A fault is reset by a rising edge of bit 7: `was_reset` says whether it was up before.
    pub(super) fn towards_switched_on(self, was_reset: bool) -> u16 {
        match self {
            Self::Fault if !was_reset => FAULT_RESET,
            Self::NotReady | Self::FaultReaction | Self::Fault | Self::QuickStop => DISABLE_VOLTAGE,
            Self::SwitchOnDisabled => SHUTDOWN,
            Self::ReadyToSwitchOn | Self::SwitchedOn | Self::OperationEnabled => SWITCH_ON,
        }
    }
}

/// Controlwords.
pub(super) const DISABLE_VOLTAGE: u16 = 0x0000;
const SHUTDOWN: u16 = 0x0006;
pub(super) const SWITCH_ON: u16 = 0x0007;
pub(super) const ENABLE_OPERATION: u16 = 0x000f;
const FAULT_RESET: u16 = 0x0080;

/// 0x60C2 for a period: a number and the power of ten that it counts, s; `None` where no byte has it.
pub(super) fn interpolation_period(rate_hz: f64) -> Option<(u8, i8)> {
    (-6..=-3_i8).rev().find_map(|exponent| {
        let units = 1.0 / rate_hz / 10_f64.powi(i32::from(exponent));
        let is_whole = (units - units.round()).abs() < 1e-6 * units && (1.0..=255.0).contains(&units.round());
        is_whole.then_some((units.round() as u8, exponent))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statuswords_tell_the_state_and_what_leads_on() {
        use DriveState as S;
        let cases = [
            (0x0000, S::NotReady, 0x00),
            (0x0250, S::SwitchOnDisabled, 0x06),
            (0x0231, S::ReadyToSwitchOn, 0x07),
            (0x0233, S::SwitchedOn, 0x07),
            (0x0237, S::OperationEnabled, 0x07),
            (0x0217, S::QuickStop, 0x00),
            (0x021f, S::FaultReaction, 0x00),
            (0x0218, S::Fault, 0x80),
        ];
        for (statusword, state, controlword) in cases {
            assert_eq!(S::of(statusword), state, "{statusword:#06x}");
            assert_eq!(state.towards_switched_on(false), controlword, "{statusword:#06x}");
        }
        assert_eq!(S::Fault.towards_switched_on(true), 0, "an edge, not a level");
    }

    #[test]
    fn periods_are_given_as_drives_take_them() {
        let periods = [1_000.0, 2_000.0, 4_000.0, 500.0, 3_000.0].map(interpolation_period);
        assert_eq!(periods, [Some((1, -3)), Some((5, -4)), Some((25, -5)), Some((2, -3)), None]);
    }
}
