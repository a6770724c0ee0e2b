//! The running rig as a source: its shared memory, and the viewer's own health in return.

use anyhow::Context as _;
use archive::SequenceLedger;
use consumer::{Health, SourceWatch};
use serde::de::DeserializeOwned;
use shared_types::services::{self, MessagePublisher, MessageSubscriber, RigNode, SampleSubscriber};
use shared_types::{FitUpdate, LoopStatus, ProcessHealth, ProcessKind, Sample, rig};

use crate::picture::Picture;
use crate::source::Source;

pub struct RigSource {
    samples: SampleSubscriber,
    description: MessageSubscriber<[u8]>,
    models: MessageSubscriber<[u8]>,
    status: MessageSubscriber<LoopStatus>,
    fits: MessageSubscriber<FitUpdate>,
    health: MessageSubscriber<ProcessHealth>,
    own_health: MessagePublisher<ProcessHealth>,
    /// Ports live only as long as their node.
    _node: RigNode,
    restarts: u32,
    /// The run that is counted.
    run_id: u64,
    counts: Counts,
    source: SourceWatch,
}

impl RigSource {
    /// Attaches to the rig; nothing need be running yet.
    /// Fails when shared memory is not available or the running processes are of another build.
    pub fn attach(restarts: u32) -> anyhow::Result<Self> {
        let node = services::attach("rerun-viewer")?;
        Ok(Self {
            samples: services::sample_subscriber(&node)?,
            description: services::RUN_DESCRIPTION.subscriber(&node)?,
            models: services::MODEL_CHANGES.subscriber(&node)?,
            status: services::LOOP_STATUS.subscriber(&node)?,
            fits: services::FIT_UPDATES.subscriber(&node)?,
            health: services::PROCESS_HEALTH.subscriber(&node)?,
            own_health: services::PROCESS_HEALTH.publisher(&node)?,
            _node: node,
            restarts,
            run_id: 0,
            counts: Counts::new(restarts),
            source: SourceWatch::default(),
        })
    }
}

/// Reads a message in JSON; one that cannot be read is reported and not shown.
fn read<T: DeserializeOwned>(json: &[u8], what: &str) -> Option<T> {
    let read = serde_json::from_slice(json);
    read.inspect_err(|error| tracing::error!("{what} cannot be read and is not shown: {error}")).ok()
}

impl Source for RigSource {
    fn poll(&mut self, samples_wanted: bool, picture: &mut Picture) -> anyhow::Result<()> {
        while let Some(json) = self.description.receive()? {
            read(json.payload(), "the run's description").iter().for_each(|run| picture.describe(run));
        }
        while let Some(json) = self.models.receive()? {
            read(json.payload(), "a rendered model").iter().for_each(|change| picture.take_rendered(change));
        }
        while let Some(status) = self.status.receive()? {
            self.source.hear(&status, rig::monotonic_time_ns());
            picture.take_status(&status);
        }
        picture.run.source_gone |= self.source.is_gone(rig::monotonic_time_ns());
        while let Some(fit) = self.fits.receive()? {
            picture.take_fit(&fit);
        }
        while let Some(health) = self.health.receive()? {
            picture.take_health(&health);
        }
        if samples_wanted {
            while let Some(block) = self.samples.receive()? {
                let run_id = block.user_header().run_id;
                if run_id != self.run_id {
                    (self.run_id, self.counts) = (run_id, Counts::new(self.restarts));
                }
                self.counts.count(block.payload());
                picture.take_samples(run_id, block.payload());
            }
        }
        if let Some(report) = self.counts.report() {
            self.own_health.send_copy(report).context("the viewer's health cannot be sent")?;
        }
        Ok(())
    }
}

/// The samples of a run that this viewer has received.
struct Counts {
    received: SequenceLedger,
    health: Health,
}

impl Counts {
    fn new(restarts: u32) -> Self {
        Self { received: SequenceLedger::default(), health: Health::new(ProcessKind::Viewer, restarts) }
    }

    fn count(&mut self, samples: &[Sample]) {
        self.health.received(samples);
        for sample in samples {
            let _ = self.received.admit(sample.seq);
        }
    }

    /// The viewer's health, when a report is due. Samples before the first one received do not count as lost.
    fn report(&mut self) -> Option<ProcessHealth> {
        self.health.report(self.received.missing() - self.received.first().unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_in_the_sequence_counts_as_lost_samples() {
        let samples =
            |seqs: std::ops::Range<u64>| seqs.map(|seq| Sample { seq, ..Sample::default() }).collect::<Vec<_>>();
        let mut counts = Counts::new(0);
        counts.count(&samples(100..110));
        counts.count(&samples(113..120));
        assert_eq!(counts.report().map(|report| (report.received_samples, report.lost_samples)), Some((17, 3)));
    }
}
