//! What the operator's program asks of the control loop, and what it answers.

#[cfg(feature = "services")]
use iceoryx2::prelude::ZeroCopySend;

use crate::wire_code;

wire_message! {
    /// A request to the control loop.
    pub struct ControlRequest as "haptic_camera/msg/ControlRequest" {
        /// 0 state only, 1 start, 2 stop, 3 shut down.
        pub kind: u32,
        /// Always 0.
        pub reserved: u32,
    }
}

wire_message! {
    /// The control loop's answer.
    pub struct ControlResponse as "haptic_camera/msg/ControlResponse" {
        /// 1 when the request was taken up, 0 when the state does not permit it.
        pub accepted: u32,
        /// State of the loop when it answered.
        pub state: u32,
    }
}

wire_code! {
    /// What is asked of the control loop.
    pub enum CommandKind {
        /// Nothing: only tell the state.
        Query = 0,
        /// Begin the armed run.
        Start = 1,
        /// Ramp the torque down and end the run.
        Stop = 2,
        /// End the process, ramping the torque down first.
        Shutdown = 3,
    }
}
