//! The run that a consumer follows.

use std::time::Duration;

use anyhow::Context as _;
use shared_types::RunDescription;
use shared_types::services::TextSubscriber;

use crate::Stop;

/// Interval at which a description is looked for.
const POLL_INTERVAL: Duration = Duration::from_millis(5);

/// Waits until a run is described; `None` when asked to stop before. Meanwhile health is reported.
///
/// # Errors
/// When the description cannot be received or read, or health cannot be reported.
pub fn wait_for_run(
    descriptions: &TextSubscriber,
    stop: &Stop,
    mut report_health: impl FnMut() -> anyhow::Result<()>,
) -> anyhow::Result<Option<RunDescription>> {
    while !stop.is_asked() {
        if let Some(json) = descriptions.receive().context("the run's description cannot be received")? {
            let run = serde_json::from_slice(json.payload());
            return run.map(Some).context("the run's description cannot be read; use programs of the same build");
        }
        report_health()?;
        std::thread::sleep(POLL_INTERVAL);
    }
    Ok(None)
}
