//! The live fitter: fits the model while the run goes on.
//!
//! **Reads** the samples (those of the last seconds first) and the run's description. **Publishes**
//! the model fitted so far, 25 times a second, and its own health twice a second.
//!
//! **When it dies** nothing but the estimates stops. Restarted it begins anew with the samples that
//! the stream keeps as history, and says so by the number of samples its estimates rest on.

mod streams;
mod update;

use std::process::ExitCode;
use std::time::Duration;

use consumer::Stop;
use identification::live::{LiveFit, LiveSample, USUAL_SHARE};
use streams::Streams;
use update::Cadence;

/// How often the queue is looked at. It holds sixteen seconds.
const POLL_INTERVAL: Duration = Duration::from_micros(250);

/// Fits the model to the stream while the run goes on.
#[derive(clap::Parser)]
#[command(version)]
struct Arguments {
    /// Times this process was restarted during the run, for its health report.
    #[arg(long, default_value_t = 0)]
    restarts: u32,
    /// Share of its value within which half the 95 % interval of each parameter is asked for.
    #[arg(long, default_value_t = USUAL_SHARE)]
    share: f64,
}

fn main() -> ExitCode {
    let arguments: Arguments = match operator::parse() {
        Ok(arguments) => arguments,
        Err(status) => return status,
    };
    operator::start_log(operator::LevelFilter::WARN);
    consumer::raise_priority();
    match fit_stream(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            operator::tell_error(&error);
            ExitCode::FAILURE
        }
    }
}

fn fit_stream(arguments: &Arguments) -> anyhow::Result<()> {
    let stop = Stop::listen()?;
    let mut streams = Streams::attach(arguments.restarts)?;
    let Some(run) = streams.wait_for_run(&stop)? else { return Ok(()) };
    // On a rig that renders a hand drives, and the sensor reads what the knob gives instead of what it takes.
    let sign = if run.is_rendered() { -1.0 } else { 1.0 };
    let mut fit =
        LiveFit::new(run.rate_hz, run.axis, run.calibration_at_knob()?.as_ref()).converging_to(arguments.share);
    let mut cadence = Cadence::new();
    while !stop.is_asked() {
        streams.take_samples(run.run_id, |sample| {
            // A stale sample repeats the values of an earlier one.
            if sample.flags & shared_types::Sample::STALE != 0 {
                return;
            }
            fit.push(&LiveSample {
                time_s: sample.time_s(run.rate_hz),
                angle_rad: sample.angle_rad,
                torque_mnm: sign * sample.torque_mnm,
            });
        })?;
        if cadence.is_due(streams.newest()) {
            let update = update::measured(run.run_id, || fit.estimate());
            streams.publish(update)?;
        }
        if streams.source_is_gone(run.run_id)? {
            tracing::warn!("the control loop died before the end of the run: the fit ends here");
            break;
        }
        streams.report_health()?;
        std::thread::sleep(POLL_INTERVAL);
    }
    Ok(())
}
