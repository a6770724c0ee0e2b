//! Real-time permission, the clock and the loop itself.

mod call_watch;
mod clock;
mod model_rings;
mod permission;
mod schedule;
mod seccomp;
mod tick_loop;
mod tick_record;

pub use call_watch::{
    CallWatch, CallWatchError, CallWatched, DeclaredCallsMade, PermittedCalls, WATCH_CALLS_VARIABLE, call_numbers,
};
pub use model_rings::{ModelEvent, ModelPort};
pub use permission::{
    OffCore, Permission, WakefulProcessors, block_signals, keep_off_core, last_core, prefer_publisher,
};
pub use schedule::{Schedule, Tick};
pub use tick_loop::{LoopPort, SharedState, TickLoop};
pub use tick_record::{TickLog, TickRecord};
