//! Supervisors that are killed before, while and just after they start their processes.

use std::time::Duration;

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore as _, SeedableRng as _};

use crate::Bench;

/// Kills of a supervisor in its first moments.
#[derive(Clone, Copy, Debug)]
pub struct EarlyKills {
    /// How many.
    pub kills: u32,
    /// The latest moment after the start; each is drawn from the time up to it.
    pub latest: Duration,
    /// Draws the moments.
    pub seed: u64,
}

impl EarlyKills {
    /// Makes the kills one after the other; the number of processes that did not end with their supervisor.
    ///
    /// # Errors
    /// When a capture cannot be started.
    pub fn orphans(&self, bench: &Bench) -> anyhow::Result<usize> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let mut orphans = 0;
        for _ in 0..self.kills {
            let moment = self.latest.mul_f64(random.next_u64() as f64 / u64::MAX as f64);
            let mut supervisor = bench.start(&["capture", "--duration-s", "60", "--no-viewer", "--out", "early"])?;
            std::thread::sleep(moment);
            supervisor.kill()?;
            supervisor.wait()?;
            orphans += bench.end_orphans();
        }
        Ok(orphans)
    }
}
