//! Real-time permission, the clock and the loop itself.

mod clock;
mod model_rings;
mod permission;
mod tick_loop;

pub use model_rings::{ModelEvent, ModelPort};
pub use permission::{Permission, WakefulProcessors, keep_off_core, last_core};
pub use tick_loop::{LoopPort, SharedState, TickLoop};
