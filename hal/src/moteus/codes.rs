//! What a controller, or the way to it, reports by a number.
//!
//! Up to 255 the controller's own fault codes: register 0x00f of its reference, <https://mjbots.github.io/moteus/protocol/registers/>.
//! From 1000 on what this driver finds out by itself.

/// The port cannot be opened.
pub(super) const NOT_OPENED: i32 = 1000;
/// Reading or writing the port failed.
pub(super) const PORT_GONE: i32 = 1001;
/// No answer came.
pub(super) const SILENCE: i32 = 1002;
/// What came was no answer.
pub(super) const GARBAGE: i32 = 1003;
/// Answers came with wrong checksums.
pub(super) const CHECKSUM: i32 = 1004;
/// The adapter or the controller did not take what was sent.
pub(super) const REFUSED: i32 = 1005;
/// The controller's watchdog ran out.
pub(super) const WATCHDOG: i32 = 1006;
/// The controller began anew.
pub(super) const RESTARTED: i32 = 1007;
/// It does not drive though it was told to.
pub(super) const NOT_DRIVING: i32 = 1008;
/// Without commands it goes on driving.
pub(super) const NO_WATCHDOG: i32 = 1009;
/// It would keep its torque when its watchdog runs out.
pub(super) const HOLDS_ON_TIMEOUT: i32 = 1010;
/// Answers take longer than a period.
pub(super) const SLOW: i32 = 1011;
/// Its registers mean something else.
pub(super) const OTHER_REGISTERS: i32 = 1012;
/// It reports no number for a channel that the rig file names.
pub(super) const NO_CHANNEL: i32 = 1013;
/// It says that it is in a fault and gives no code.
pub(super) const UNNAMED_FAULT: i32 = 1014;

/// Every code with its meaning, as a half sentence that says what to do.
const MEANINGS: [(i32, &str); 32] = [
    (32, "calibration fault: the encoder saw no magnet; check the magnet and run `moteus_tool --calibrate`"),
    (33, "motor driver fault: most often the supply sagged; check supply and wiring of the motor"),
    (
        34,
        "over voltage: braking raised the supply; use one that takes current back, or set servo.max_voltage and flux braking",
    ),
    (35, "encoder fault: its readings fit no magnet; check the magnet's distance and centre"),
    (36, "motor not configured: run `moteus_tool --calibrate`"),
    (37, "PWM cycle overrun: an error of the firmware; update it"),
    (38, "over temperature: let it cool, and lower [limits] motor_torque_mnm"),
    (39, "outside limit: the position lies beyond servopos.position_min and position_max"),
    (40, "under voltage: check the supply"),
    (41, "a configuration value was changed while it was driving; start the run again"),
    (42, "theta invalid: no encoder for commutation; check the encoder's cable and configuration"),
    (43, "position invalid: no encoder for the output; check the encoder's cable and configuration"),
    (44, "the gate driver could not be switched on; check the supply"),
    (45, "stop position deprecated; update the firmware"),
    (46, "timing violation: an error of the firmware; update it"),
    (47, "servo.bemf_feedforward asks for an acceleration limit; set it to 0"),
    (48, "invalid limits: servopos.position_min or position_max lie outside what the position can be"),
    (
        NOT_OPENED,
        "its port cannot be opened; check [settings] port, the cable, and that this user may use it (group dialout)",
    ),
    (PORT_GONE, "its port is gone, or its CAN interface is down; check the cable of the adapter, and `ip link`"),
    (SILENCE, "the controller does not answer; check its supply, its cable and [settings] id"),
    (GARBAGE, "what came from the port is no answer; check that [settings] port is a moteus adapter, and the baud"),
    (CHECKSUM, "answers came with wrong checksums; check the UART's wiring, ground and baud"),
    (REFUSED, "the adapter answered with errors; check the CAN cable and its termination"),
    (WATCHDOG, "its watchdog ran out and took the torque away; start the run again, or raise [watchdog] timeout_s"),
    (RESTARTED, "the controller began anew, or stopped by itself; check its supply"),
    (NOT_DRIVING, "the controller does not switch on; look at its fault with tview"),
    (NO_WATCHDOG, "the controller goes on driving without commands: its watchdog does not work; update the firmware"),
    (
        HOLDS_ON_TIMEOUT,
        "its servo.timeout_mode is not 0 and cannot be set: it would not let go of the torque; set it with tview",
    ),
    (SLOW, "answers take too long; give a lower rate, a faster adapter, or the machine less to do"),
    (OTHER_REGISTERS, "its firmware has another register map than this program knows (5); update the one or the other"),
    (
        NO_CHANNEL,
        "it gives no number for a channel that the rig file names; check [channels] and the pins' configuration",
    ),
    (UNNAMED_FAULT, "it is in a fault and gives no code; look at it with tview"),
];

/// Every code with its meaning, which begins with the code where it is the controller's.
pub(super) fn all() -> Vec<(i32, String)> {
    let told = |code: i32, meaning: &str| match code < NOT_OPENED {
        true => format!("fault code {code}: {meaning}"),
        false => meaning.to_owned(),
    };
    MEANINGS.iter().map(|(code, meaning)| (*code, told(*code, meaning))).collect()
}
