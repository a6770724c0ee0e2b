//! What every consumer of the sample stream does alike: stop in order, say how it is, log.
//!
//! A consumer may crash, hang, be killed or be restarted at any moment; the control loop does not
//! notice. It ends with the process that started it, by its [lease](shared_types::lease); signals are left to that
//! process, unless an operator started the consumer.

mod arrivals;
mod health;
mod priority;
mod source;
mod stop;

pub use health::Health;
pub use priority::prefer;
pub use source::SourceWatch;
use std::io::IsTerminal as _;
pub use stop::{Stop, StopError};

use tracing_subscriber::EnvFilter;
use tracing_subscriber::filter::LevelFilter;

/// Sends the process's log to standard error, as much of it as `RUST_LOG` asks for (warnings unless told).
pub fn start_log() {
    let filter = EnvFilter::builder().with_default_directive(LevelFilter::WARN.into()).from_env_lossy();
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        // A terminal that is gone takes no complaint about it either.
        .log_internal_errors(false)
        .with_ansi(std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|set| set.is_empty()))
        .with_target(false)
        .without_time()
        .init();
}
