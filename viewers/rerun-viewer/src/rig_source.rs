//! The running rig as a source: its shared memory, and the viewer's own health in return.

use std::time::{Duration, Instant};

use anyhow::Context as _;
use shared_types::services::{self, MessagePublisher, MessageSubscriber, RigNode, SampleSubscriber};
use shared_types::{FitUpdate, LoopStatus, ProcessHealth, ProcessKind, RunDescription, rig};

use crate::source::{Event, Source};

/// How often the viewer tells how it fares.
const HEALTH_PERIOD: Duration = Duration::from_millis(500);

/// Reads every stream of the rig and publishes the viewer's health.
pub struct RigSource {
    samples: SampleSubscriber,
    description: services::MessageSubscriber<[u8]>,
    status: MessageSubscriber<LoopStatus>,
    fits: MessageSubscriber<FitUpdate>,
    health: MessageSubscriber<ProcessHealth>,
    own_health: MessagePublisher<ProcessHealth>,
    /// Ports live only as long as their node.
    _node: RigNode,
    restarts: u32,
    counts: Counts,
    next_health: Instant,
}

/// What went through, for the health report.
#[derive(Debug, Default)]
struct Counts {
    run_id: u64,
    next_seq: Option<u64>,
    received: u64,
    lost: u64,
    latency_ns: u64,
}

impl RigSource {
    /// Attaches to the rig; nothing need be running yet.
    ///
    /// # Errors
    /// When shared memory is not to be had or the running processes are of another build.
    pub fn attach(restarts: u32) -> anyhow::Result<Self> {
        let node = services::attach("rerun-viewer")?;
        Ok(Self {
            samples: services::sample_subscriber(&node)?,
            description: services::description_subscriber(&node)?,
            status: services::LOOP_STATUS.subscriber(&node)?,
            fits: services::FIT_UPDATES.subscriber(&node)?,
            health: services::PROCESS_HEALTH.subscriber(&node)?,
            own_health: services::PROCESS_HEALTH.publisher(&node)?,
            _node: node,
            restarts,
            counts: Counts::default(),
            next_health: Instant::now(),
        })
    }

    fn publish_health(&self) -> anyhow::Result<()> {
        let health = ProcessHealth {
            received_samples: self.counts.received,
            lost_samples: self.counts.lost,
            latency_ns: self.counts.latency_ns,
            ..ProcessHealth::of_this_process(ProcessKind::Viewer, self.restarts)
        };
        self.own_health
            .send_copy(health)
            .map_err(|error| anyhow::anyhow!("{error:?}"))
            .context("health was not sent")?;
        Ok(())
    }
}

impl Source for RigSource {
    fn poll(&mut self, samples_wanted: bool, take_in: &mut dyn FnMut(Event<'_>)) -> anyhow::Result<()> {
        while let Some(json) = self.description.receive()? {
            match serde_json::from_slice::<RunDescription>(json.payload()) {
                Ok(description) => take_in(Event::Description(&description)),
                Err(error) => tracing::error!("the run's description cannot be read and is not shown: {error}"),
            }
        }
        while let Some(status) = self.status.receive()? {
            take_in(Event::Status(&status));
        }
        while let Some(fit) = self.fits.receive()? {
            take_in(Event::Fit(&fit));
        }
        while let Some(health) = self.health.receive()? {
            take_in(Event::Health(&health));
        }
        if samples_wanted {
            while let Some(block) = self.samples.receive()? {
                let run_id = block.user_header().run_id;
                self.counts.count(run_id, block.payload());
                take_in(Event::Samples { run_id, samples: block.payload() });
            }
        }
        if Instant::now() >= self.next_health {
            self.next_health = Instant::now() + HEALTH_PERIOD;
            self.publish_health()?;
        }
        Ok(())
    }
}

impl Counts {
    fn count(&mut self, run_id: u64, samples: &[shared_types::Sample]) {
        if run_id != self.run_id {
            *self = Self { run_id, ..Self::default() };
        }
        for sample in samples {
            self.lost += self.next_seq.map_or(0, |expected| sample.seq.saturating_sub(expected));
            self.next_seq = Some(sample.seq + 1);
        }
        self.received += samples.len() as u64;
        if let Some(newest) = samples.last() {
            self.latency_ns = rig::monotonic_time_ns().saturating_sub(newest.monotonic_time_ns);
        }
    }
}

#[cfg(test)]
mod tests {
    use shared_types::Sample;

    use super::Counts;

    fn samples(seqs: std::ops::Range<u64>) -> Vec<Sample> {
        seqs.map(|seq| Sample { seq, ..Sample::default() }).collect()
    }

    #[test]
    fn a_jump_in_the_sequence_counts_as_lost_samples() {
        let mut counts = Counts::default();
        counts.count(7, &samples(100..110));
        counts.count(7, &samples(113..120));
        assert_eq!((counts.received, counts.lost), (17, 3));
    }

    #[test]
    fn a_new_run_begins_a_new_count() {
        let mut counts = Counts::default();
        counts.count(7, &samples(100..110));
        counts.count(8, &samples(0..5));
        assert_eq!((counts.received, counts.lost), (5, 0));
    }
}
