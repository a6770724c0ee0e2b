//! One long capture in which the consumers are killed again and again: does shared memory grow?

use std::time::Duration;

use anyhow::{Context as _, ensure};
use nix::sys::signal::{Signal, kill};

use super::Evidence;
use super::outcome::shared_memory_bytes;
use super::watched::Watched;
use crate::Bench;

/// Time between two kills: each of three consumers then lives longer than what counts as a short life.
const BETWEEN_KILLS: Duration = Duration::from_millis(450);
/// Programs that are killed in turn.
const CONSUMERS: [&str; 3] = ["recorder", "live-fitter", "rerun-viewer"];

/// Shared memory over a capture with many restarts.
#[derive(Clone, Debug, Default)]
pub struct Restarts {
    /// Consumers killed so far and memory that the rig's files held then, bytes.
    pub shared_memory_bytes: Vec<(u32, u64)>,
    /// Samples that were published and are not in the archive.
    pub lost_samples: u64,
    /// Samples in the archive.
    pub samples: u64,
}

/// Makes a capture with `kills` kills.
///
/// # Errors
/// When the capture fails or a consumer is not brought back.
pub fn capture_with_restarts(bench: &Bench, kills: u32) -> anyhow::Result<Restarts> {
    let duration = format!("{}", (BETWEEN_KILLS * kills).as_secs() + 10);
    let program = Watched::start(bench.command(&["capture", "--duration-s", &duration, "--out", "out"])?)?;
    for consumer in CONSUMERS {
        bench.wait_for_process(consumer)?;
    }
    std::thread::sleep(Duration::from_secs(2));
    let mut restarts = Restarts::default();
    for killed in 0..kills {
        let consumer = CONSUMERS[killed as usize % CONSUMERS.len()];
        restarts.shared_memory_bytes.push((killed, shared_memory_bytes(&bench.path("rig"))));
        kill(bench.wait_for_process(consumer)?, Signal::SIGKILL)?;
        std::thread::sleep(BETWEEN_KILLS);
    }
    let (status, said) = program.wait(Duration::from_secs(180))?;
    ensure!(status.success(), "the capture ended with {status}: {said:?}");
    let evidence = Evidence::read(&bench.only_archive("out")?).context("the archive is not whole")?;
    restarts.samples = evidence.samples.len() as u64;
    restarts.lost_samples = evidence.published_samples() - restarts.samples;
    let left = bench.leftovers();
    ensure!(left.is_empty(), "left behind: {left:?}");
    Ok(restarts)
}
