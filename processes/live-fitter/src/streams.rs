//! The streams that the live fitter receives and publishes.

use anyhow::Context as _;
use consumer::{Health, SourceWatch, Stop};
use shared_types::services::{
    self, FIT_UPDATES, LOOP_STATUS, MessagePublisher, MessageSubscriber, PROCESS_HEALTH, RUN_DESCRIPTION, RigNode,
    SampleSubscriber,
};
use shared_types::{FitUpdate, LoopStatus, ProcessHealth, ProcessKind, RunDescription, Sample, rig};

/// The newest sample that was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Newest {
    /// Its tick.
    pub tick: u64,
    /// Its time on CLOCK_MONOTONIC, ns.
    pub monotonic_time_ns: u64,
}

/// The rig's streams, from the fitter's side.
pub struct Streams {
    samples: SampleSubscriber,
    statuses: MessageSubscriber<LoopStatus>,
    source: SourceWatch,
    updates: MessagePublisher<FitUpdate>,
    own_health: MessagePublisher<ProcessHealth>,
    health: Health,
    newest: Option<Newest>,
    next_seq: Option<u64>,
    lost_samples: u64,
    // Last, since ports go before the node they belong to.
    node: RigNode,
}

impl Streams {
    /// Attaches to the rig.
    ///
    /// # Errors
    /// When shared memory is not available.
    pub fn attach(restarts: u32) -> anyhow::Result<Self> {
        let node = services::attach("live-fitter")?;
        Ok(Self {
            samples: services::sample_subscriber(&node)?,
            statuses: LOOP_STATUS.subscriber(&node)?,
            source: SourceWatch::default(),
            updates: FIT_UPDATES.publisher(&node)?,
            own_health: PROCESS_HEALTH.publisher(&node)?,
            health: Health::new(ProcessKind::LiveFitter, restarts),
            newest: None,
            next_seq: None,
            lost_samples: 0,
            node,
        })
    }

    /// Waits until a run is described; `None` when asked to stop before.
    ///
    /// # Errors
    /// When the description cannot be had or understood.
    pub fn wait_for_run(&mut self, stop: &Stop) -> anyhow::Result<Option<RunDescription>> {
        let descriptions = RUN_DESCRIPTION.subscriber(&self.node)?;
        consumer::wait_for_run(&descriptions, stop, || self.report_health())
    }

    /// Hands over every sample of the run that waits in the queue.
    ///
    /// # Errors
    /// When the stream cannot be received.
    pub fn take_samples(&mut self, run_id: u64, mut take: impl FnMut(&Sample)) -> anyhow::Result<()> {
        while let Some(block) = self.samples.receive().context("samples cannot be received")? {
            if block.user_header().run_id != run_id {
                continue;
            }
            self.health.received(block.payload());
            for sample in block.payload() {
                if let Some(expected) = self.next_seq {
                    self.lost_samples += sample.seq.saturating_sub(expected);
                }
                self.next_seq = Some(sample.seq + 1);
                self.newest = Some(Newest { tick: sample.tick, monotonic_time_ns: sample.monotonic_time_ns });
                take(sample);
            }
        }
        Ok(())
    }

    /// Whether the control loop of this run died before the run had ended: no more samples will come.
    ///
    /// # Errors
    /// When its status cannot be received.
    pub fn source_is_gone(&mut self, run_id: u64) -> anyhow::Result<bool> {
        let now_ns = rig::monotonic_time_ns();
        while let Some(status) = self.statuses.receive().context("the loop's status cannot be received")? {
            if status.run_id == run_id {
                self.source.hear(&status, now_ns);
            }
        }
        Ok(self.source.is_gone(now_ns))
    }

    /// The newest sample taken so far.
    pub fn newest(&self) -> Option<Newest> {
        self.newest
    }

    /// Fills in what the streams know of an update, and publishes it.
    ///
    /// # Errors
    /// When it cannot be sent.
    pub fn publish(&mut self, update: FitUpdate) -> anyhow::Result<()> {
        let newest = self.newest.unwrap_or(Newest { tick: 0, monotonic_time_ns: 0 });
        let update = FitUpdate {
            latest_tick: newest.tick,
            monotonic_time_ns: newest.monotonic_time_ns,
            lost_samples: self.lost_samples,
            ..update
        };
        self.updates.send_copy(update).context("the estimate cannot be sent")?;
        Ok(())
    }

    /// Publishes the health of this process when a report is due.
    ///
    /// # Errors
    /// When it cannot be sent.
    pub fn report_health(&mut self) -> anyhow::Result<()> {
        if let Some(report) = self.health.report(self.lost_samples) {
            self.own_health.send_copy(report).context("the live fitter's health cannot be sent")?;
        }
        Ok(())
    }
}
