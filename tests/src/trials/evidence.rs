//! What an archive says of its run, read message by message and without the reader that the instrument uses.

use std::path::Path;

use anyhow::Context as _;
use shared_types::{LoopStatus, ProcessHealth, Sample};
use zerocopy::FromBytes;

/// Bytes before a CDR body.
const CDR_HEADER: usize = 4;

/// The messages of an archive, in the order of the file.
#[derive(Clone, Debug, Default)]
pub struct Evidence {
    /// The samples.
    pub samples: Vec<Sample>,
    /// The control loop's words about itself.
    pub statuses: Vec<LoopStatus>,
    /// The consumers' words about themselves.
    pub healths: Vec<ProcessHealth>,
}

impl Evidence {
    /// Reads an archive.
    ///
    /// # Errors
    /// When it is not a whole MCAP file or a message has another length than its type.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let bytes = std::fs::read(path)?;
        let mut evidence = Self::default();
        for message in mcap::MessageStream::new(&bytes)? {
            let message = message?;
            let body = message.data.get(CDR_HEADER..).unwrap_or_default();
            match message.channel.topic.as_str() {
                "/sample" => evidence.samples.push(parsed(body)?),
                "/status" => evidence.statuses.push(parsed(body)?),
                "/health" => evidence.healths.push(parsed(body)?),
                _ => {}
            }
        }
        Ok(evidence)
    }

    /// Samples that the run published, as far as the archive knows: by the control loop's last word and by the numbers
    /// of the samples themselves.
    #[must_use]
    pub fn published_samples(&self) -> u64 {
        let published = self.statuses.iter().map(|status| status.published_samples).max().unwrap_or(0);
        let seen = self.samples.iter().map(|sample| sample.seq + 1).max().unwrap_or(0);
        published.max(seen)
    }

    /// Ranges of `seq` that are missing between two samples, each as first and last.
    #[must_use]
    pub fn holes(&self) -> Vec<(u64, u64)> {
        let pairs = self.samples.windows(2).filter(|pair| pair[1].seq != pair[0].seq + 1);
        pairs.map(|pair| (pair[0].seq + 1, pair[1].seq.saturating_sub(1))).collect()
    }

    /// Reports of a consumer of this kind in the order of time: process id and time, ns of CLOCK_MONOTONIC.
    #[must_use]
    pub fn reports(&self, kind: shared_types::ProcessKind) -> Vec<(u32, u64)> {
        let of_kind = self.healths.iter().filter(|health| health.process == kind.code());
        let mut reports: Vec<_> = of_kind.map(|health| (health.process_id, health.monotonic_time_ns)).collect();
        reports.sort_unstable_by_key(|&(_, time_ns)| time_ns);
        reports
    }

    /// Where the half second from `fault_ns` on stands among the other half seconds of the run, by the 99th percentile
    /// of lateness: 0 the calmest, 1 the most disturbed; `None` when the fault was not within the run.
    ///
    /// If the fault does not reach the loop, this is uniform over many trials.
    #[must_use]
    pub fn rank_of_lateness(&self, fault_ns: u64) -> Option<f64> {
        const WINDOW_NS: u64 = 500_000_000;
        let first_ns = self.samples.first()?.monotonic_time_ns;
        let last_ns = self.samples.last()?.monotonic_time_ns;
        if fault_ns < first_ns || fault_ns + WINDOW_NS > last_ns {
            return None;
        }
        // Windows on the grid that the fault's own belongs to.
        let origin_ns = fault_ns - (fault_ns - first_ns) / WINDOW_NS * WINDOW_NS;
        let windows = (last_ns - origin_ns) / WINDOW_NS;
        let lateness: Vec<u64> = (0..windows)
            .filter_map(|window| {
                let from_ns = origin_ns + window * WINDOW_NS;
                let from = self.samples.partition_point(|sample| sample.monotonic_time_ns < from_ns);
                let to = self.samples.partition_point(|sample| sample.monotonic_time_ns < from_ns + WINDOW_NS);
                percentile_99(self.samples[from..to].iter().map(|sample| sample.lateness_ns).collect())
            })
            .collect();
        let own = *lateness.get(((fault_ns - origin_ns) / WINDOW_NS) as usize)?;
        let below = lateness.iter().filter(|&&other| other < own).count();
        let same = lateness.iter().filter(|&&other| other == own).count();
        Some((below as f64 + same as f64 / 2.0) / lateness.len() as f64)
    }

    /// Ticks missed in the half second from `fault_ns` on, and in the whole run.
    #[must_use]
    pub fn missed_ticks(&self, fault_ns: u64) -> (u64, u64) {
        let missed = |from_ns: u64, to_ns: u64| {
            let within = self.samples.iter().filter(|sample| (from_ns..to_ns).contains(&sample.monotonic_time_ns));
            within.map(|sample| u64::from(sample.missed_ticks)).sum()
        };
        (missed(fault_ns, fault_ns + 500_000_000), missed(0, u64::MAX))
    }
}

fn parsed<Payload: FromBytes>(body: &[u8]) -> anyhow::Result<Payload> {
    Payload::read_from_bytes(body).ok().context("a message has another length than its type")
}

fn percentile_99(mut values: Vec<u64>) -> Option<u64> {
    values.sort_unstable();
    values.get(values.len() * 99 / 100).copied()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "test")]
mod tests {
    use super::*;

    fn run(disturbed: std::ops::Range<u64>) -> Evidence {
        let sample = |seq: u64| Sample {
            seq,
            monotonic_time_ns: 7_000_000_000 + seq * 1_000_000,
            lateness_ns: if disturbed.contains(&seq) { 5_000 } else { 20 + seq % 7 },
            ..Sample::default()
        };
        Evidence { samples: (0..5_000).map(sample).collect(), ..Evidence::default() }
    }

    #[test]
    fn a_disturbance_by_the_fault_has_the_highest_rank_and_one_elsewhere_does_not() {
        let fault_ns = 7_000_000_000 + 2_200 * 1_000_000;
        assert!(run(2_200..2_700).rank_of_lateness(fault_ns).unwrap() > 0.9);
        assert!(run(1_000..1_400).rank_of_lateness(fault_ns).unwrap() < 0.9);
        assert_eq!(run(0..0).rank_of_lateness(6_000_000_000), None);
    }

    #[test]
    fn holes_are_found_with_their_bounds() {
        let mut evidence = run(0..0);
        evidence.samples.drain(100..150);
        assert_eq!(evidence.holes(), [(100, 149)]);
    }
}
