//! What every consumer of the sample stream does alike: stop in order, say how it is, log.
//!
//! A consumer may crash, hang, be killed or be restarted at any moment; the control loop does not
//! notice. It ends at SIGTERM, which also comes when the process that started it dies. SIGINT, which
//! a terminal sends to everyone at once, is left to the supervisor.

mod health;
mod stop;

pub use health::Health;
pub use stop::{Stop, StopError};

/// Sends the process's log to standard error, as much of it as `RUST_LOG` asks for (warnings unless told).
pub fn start_log() {
    let filter = tracing_subscriber::EnvFilter::builder()
        .with_default_directive(tracing_subscriber::filter::LevelFilter::WARN.into())
        .from_env_lossy();
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).with_target(false).without_time().init();
}
