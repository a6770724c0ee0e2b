//! The real-time process: it turns the knob and publishes what it measures.
//!
//! Constraints first. The real-time thread runs on a core of its own under SCHED_FIFO with its
//! memory locked. Between two ticks it allocates nothing, locks nothing, logs nothing and makes no
//! system call but its sleep; it never touches iceoryx2, whose `send` opens shared memory when a
//! subscriber comes or goes. It hands samples to the publisher thread through a wait-free ring and
//! takes commands from it through another. A model to be rendered comes boxed through a third, and
//! goes back through a fourth to be freed.
//!
//! - [`control`]: the control step, a pure function of state, measurement and tick.
//! - [`realtime`]: permission, clock and the loop itself.
//! - [`publisher`]: the other thread; ring to shared memory, status, commands, models.
//! - [`admission`]: what a model must pass before it is rendered.
//! - [`nearest`]: the nearest model that passes.
//! - [`recomputation`]: a recorded rendering fed through the control step again.
//! - [`stability`]: what can be rendered on a rig without shaking.
//! - [`request`]: what the process is asked to do, and the options that ask it.
//! - [`rigs`]: the drivers that there are.
//! - [`run`], [`program`]: a run from its request to its end, with the drivers of whoever calls.
//! - [`plan`]: a request checked against its rig.
//!
//! It reads nothing but control requests and models, publishes samples, status, the run's description
//! and each model that begins to be felt, and when it dies the amplifier's watchdog takes the torque away; consumers see the stream end.

pub mod admission;
pub mod control;
mod model_exchange;
pub mod nearest;
pub mod panicking_apparatus;
pub mod plan;
pub mod publisher;
pub mod realtime;
pub mod recomputation;
pub mod request;
pub mod rig_lock;
pub mod rigs;
mod run;
pub mod stability;

pub use run::{LONGEST_PREPARATION_S, program, run};
