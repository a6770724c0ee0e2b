//! The recorder: writes everything that a run publishes into one MCAP archive.
//!
//! **Reads** the samples (those of the last seconds first), the run's description, the control
//! loop's status, the models that a replay renders, the live fitter's estimates and every consumer's
//! health. **Publishes** its own health twice a second.
//!
//! **When it dies**, even by SIGKILL, the control loop does not notice, and all samples until half a second before are on the
//! disk. Restarted with the same `--out` it goes on in a new part, `FILE.mcap.part-001` and so on; the samples of the meantime
//! reach it as history. At the end of the run the parts become `FILE.mcap`, each sample once. **When the disk is full**, or the
//! folder is removed, it goes on in a folder of its own in the temporary directory; without room there either, it keeps 100 s in
//! memory and looks for room. **When the control loop dies** it ends the archive properly.
//!
//! Exit status: 0 done, 1 failed, 2 wrong usage, 3 done but samples are missing.

mod ending;
mod part;
mod parts;
mod recording;
mod rescue;
mod streams;

use std::process::ExitCode;
use std::time::Duration;

/// How often the queues are looked at. They hold sixteen seconds. With the publisher's cycle of a millisecond, this keeps a
/// sample's latency below two milliseconds.
const POLL_INTERVAL: Duration = Duration::from_micros(250);

/// Writes what a run publishes into one MCAP archive.
#[derive(clap::Parser)]
#[command(version)]
struct Arguments {
    /// The archive to write; where another run holds the name, the archive goes to the temporary directory.
    #[arg(long, value_name = "FILE.mcap")]
    out: std::path::PathBuf,
    /// Times this process was restarted during the run, for its health report.
    #[arg(long, default_value_t = 0)]
    restarts: u32,
}

fn main() -> ExitCode {
    let arguments: Arguments = match operator::parse() {
        Ok(arguments) => arguments,
        Err(status) => return status,
    };
    operator::start_log(operator::LevelFilter::WARN);
    consumer::raise_priority();
    shared_types::rig::keep_files_private();
    match record(&arguments) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_missing_samples) => ExitCode::from(3),
        Err(error) => {
            operator::tell_error(&error);
            ExitCode::FAILURE
        }
    }
}

/// Records one run; gives the number of samples that are missing in the archive.
fn record(arguments: &Arguments) -> anyhow::Result<u64> {
    let stop = consumer::Stop::listen()?;
    let mut streams = streams::Streams::attach(arguments.restarts)?;
    let Some(run) = streams.wait_for_run(&stop)? else {
        tracing::info!("stopped before a run began; nothing recorded");
        return Ok(0);
    };
    let mut ending = ending::Ending::of_run(run.run_id);
    let mut recording = recording::Recording::begin(&arguments.out, run)?;
    while !ending.has_come(&recording, &stop) {
        streams.drain_into(&mut recording, &mut ending)?;
        std::thread::sleep(POLL_INTERVAL);
    }
    streams.drain_into(&mut recording, &mut ending)?;
    recording.finish(ending.taken_samples())
}
