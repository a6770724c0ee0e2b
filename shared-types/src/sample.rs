//! What the control loop publishes at every tick.

#[cfg(feature = "services")]
use iceoryx2::prelude::ZeroCopySend;

use crate::wire_code;

wire_message! {
    /// One tick of the control loop: what was measured, commanded and how the tick went.
    ///
    /// `seq` counts published samples without a gap; `tick` counts scheduled ticks, so that
    /// `tick - seq` is the number of ticks the loop has missed so far. Time in the run is
    /// `tick / rate`, which follows the clock even where ticks were missed.
    pub struct Sample as "haptic_camera/msg/Sample" {
        /// Samples published before this one in the run; a jump means that samples were lost.
        pub seq: u64,
        /// Scheduled tick, counted from the start of the run; time in the run is tick / rate.
        pub tick: u64,
        /// CLOCK_MONOTONIC at which the tick was due, ns.
        pub monotonic_time_ns: u64,
        /// How long after the due time the loop began the tick, ns.
        pub lateness_ns: u64,
        /// Encoder angle, rad.
        pub angle_rad: f64,
        /// Encoder angle differentiated and low-passed (causal Butterworth, late), rad/s.
        pub velocity_rad_s: f64,
        /// Accelerometer as read, gravity included; NaN on a rig without one, rad/s^2.
        pub acceleration_rad_s2: f64,
        /// Torque sensor as read: what the knob and its gripper take from the rig, mNm.
        pub torque_mnm: f64,
        /// Whether the contact in what is turned or pressed is closed: 1, or 0; NaN on a rig that watches none.
        pub contact: f64,
        /// Angle that the excitation asks for; NaN in torque mode, rad.
        pub commanded_angle_rad: f64,
        /// Torque commanded from the motor in this tick, mNm.
        pub commanded_torque_mnm: f64,
        /// How long after the tick was due the encoder was read, by the rig's own clock where it has one, s.
        pub measured_after_s: f64,
        /// Duration of reading the sensors, ns.
        pub sensor_read_ns: u32,
        /// Duration of the control step, ns.
        pub control_ns: u32,
        /// Duration of writing the torque and pushing the previous sample, ns.
        pub push_ns: u32,
        /// Ticks missed directly before this one.
        pub missed_ticks: u32,
        /// Samples lost directly before this one because the ring to the publisher was full.
        pub dropped_samples: u32,
        /// State of the loop: 0 idle, 1 armed, 2 running, 3 stopping, 4 fault.
        pub state: u32,
        /// Cause of the fault, 0 for none: 1 torque, 2 speed, 3 angle, 4 following error, 5 sensor, 6 apparatus,
        /// 7 nothing new from the rig, 8 runaway, 9 jump of the angle, 10 jump of the rig's clock, 11 watchdog
        /// (a rig with codes of its own reports 6 and its code).
        pub fault: u32,
        /// Bits: 1 the torque command was clipped at the motor's limit; of a rendering: 2 another model begins to be
        /// felt, 4 the virtual knob sticks, 8 the passivity guard dissipated energy; 16 the sensors delivered no new data.
        pub flags: u32,
        /// The rig's own code for the fault, or the reason for no new data, 0 for none: the bits of a signed number.
        pub device_code: u32,
        /// Ticks up to this one without new data from the sensors.
        pub stale_ticks: u32,
    }
}

wire_message! {
    /// Header of a block of samples in shared memory.
    pub struct BlockHeader as "haptic_camera/msg/BlockHeader" {
        /// Identity of the run; see [`RunDescription`](crate::RunDescription).
        pub run_id: u64,
    }
}

impl Sample {
    /// Bit of [`Sample::flags`]: the torque command was clipped at the motor's limit.
    pub const TORQUE_CLIPPED: u32 = 1;
    /// Bit of [`Sample::flags`]: another model begins to be felt in this tick.
    pub const MODEL_TAKEN: u32 = 2;
    /// Bit of [`Sample::flags`]: the virtual knob sticks.
    pub const STUCK: u32 = 4;
    /// Bit of [`Sample::flags`]: the passivity guard took energy back.
    pub const GUARDED: u32 = 8;
    /// Bit of [`Sample::flags`]: the sensors delivered no new data; angle and torque are those of an earlier tick.
    pub const STALE: u32 = 16;

    /// Time since the start of the run at which the sensors were read, s.
    #[must_use]
    pub fn time_s(&self, rate_hz: f64) -> f64 {
        self.tick as f64 / rate_hz + self.measured_after_s
    }

    /// By how much the loop was late, ns: after a stall, for the first tick that it missed.
    #[must_use]
    pub fn whole_lateness_ns(&self, rate_hz: f64) -> u64 {
        self.lateness_ns + u64::from(self.missed_ticks) * (1e9 / rate_hz) as u64
    }
}

wire_code! {
    /// State of the control loop.
    pub enum LoopState {
        /// Torque-free, not sampling for anyone.
        Idle = 0,
        /// Amplifier on, holding the start position, waiting for the start command.
        Armed = 1,
        /// The excitation runs and samples are published.
        Running = 2,
        /// The torque is being ramped down.
        Stopping = 3,
        /// A limit was passed or the apparatus failed; torque-free until cleared.
        Fault = 4,
    }
}

wire_code! {
    /// Why the loop went torque-free.
    pub enum Fault {
        /// The torque sensor read more than the rig's limit.
        Torque = 1,
        /// The shaft turned faster than the rig's limit.
        Speed = 2,
        /// The shaft left the permitted range of angles.
        Angle = 3,
        /// The shaft fell too far behind the commanded angle.
        FollowingError = 4,
        /// A sensor gave a value that is not a number.
        Sensor = 5,
        /// The apparatus reported a failure of its own.
        Apparatus = 6,
        /// The sensors delivered no new data for more ticks than the rig permits.
        Stale = 7,
        /// The knob turned against the motor.
        Runaway = 8,
        /// The angle changed by more than a knob can turn between two readings.
        Jump = 9,
        /// The rig's own clock did not go on with the ticks.
        Clock = 10,
        /// The amplifier's watchdog ran out because no torque was commanded in time.
        Watchdog = 11,
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Torque => "the measured torque exceeded the rig's limit",
            Self::Speed => "the speed exceeded the rig's limit",
            Self::Angle => "the angle left the permitted range",
            Self::FollowingError => "the knob fell too far behind the commanded angle",
            Self::Sensor => "a sensor gave a value that is not a number",
            Self::Apparatus => "the apparatus reported a failure; check its cables and supply, and start the run again",
            Self::Runaway => {
                "the knob turned against the motor: unless a hand did that, motor and encoder have opposite signs; \
                 invert one `sign` in the rig file, and run `haptic-camera rig commission`"
            }
            Self::Jump => {
                "the angle jumped by more than a knob can turn between two readings; check the encoder's cable and supply, and its scale \
                 in the rig file"
            }
            Self::Clock => "its own clock jumped by half a second or more; check what sets that clock",
            Self::Watchdog => {
                "the amplifier's watchdog ran out and took the torque away, because the loop sent no command in time; start the run again, and if \
                 this happens often, run `haptic-camera doctor`"
            }
            Self::Stale => "the sensors delivered no new data for more ticks than the rig file permits; check cable and bus",
        })
    }
}
