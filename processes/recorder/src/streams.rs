//! What the recorder listens to.

use anyhow::Context as _;
use consumer::{Health, Stop};
use shared_types::services::{
    self, FIT_UPDATES, LOOP_STATUS, MODEL_CHANGES, MessagePublisher, MessageSubscriber, PROCESS_HEALTH,
    RUN_DESCRIPTION, RigNode, SampleSubscriber, TextSubscriber,
};
use shared_types::{FitUpdate, LoopStatus, ModelChange, ProcessHealth, ProcessKind, RunDescription, rig};

use crate::ending::Ending;
use crate::recording::{Entry, Recording};

/// The rig's streams, from the recorder's side.
pub(crate) struct Streams {
    node: RigNode,
    samples: SampleSubscriber,
    status: MessageSubscriber<LoopStatus>,
    fits: MessageSubscriber<FitUpdate>,
    healths: MessageSubscriber<ProcessHealth>,
    models: TextSubscriber,
    own_health: MessagePublisher<ProcessHealth>,
    health: Health,
}

impl Streams {
    /// Attaches to the rig. From now on nothing that is published is missed.
    pub(crate) fn attach(restarts: u32) -> anyhow::Result<Self> {
        let node = services::attach("recorder")?;
        Ok(Self {
            samples: services::sample_subscriber(&node)?,
            status: LOOP_STATUS.subscriber(&node)?,
            fits: FIT_UPDATES.subscriber(&node)?,
            healths: PROCESS_HEALTH.subscriber(&node)?,
            models: MODEL_CHANGES.subscriber(&node)?,
            own_health: PROCESS_HEALTH.publisher(&node)?,
            health: Health::new(ProcessKind::Recorder, restarts),
            node,
        })
    }

    /// Waits until a run is described; `None` when asked to stop before.
    pub(crate) fn wait_for_run(&mut self, stop: &Stop) -> anyhow::Result<Option<RunDescription>> {
        let descriptions = RUN_DESCRIPTION.subscriber(&self.node)?;
        consumer::wait_for_run(&descriptions, stop, || self.report_health(0))
    }

    /// Writes everything that waits in the queues.
    pub(crate) fn drain_into(&mut self, recording: &mut Recording, ending: &mut Ending) -> anyhow::Result<()> {
        while let Some(block) = self.samples.receive().context("samples cannot be received")? {
            if block.user_header().run_id != recording.run_id() {
                continue;
            }
            self.health.received(block.payload());
            ending.hear_samples(rig::monotonic_time_ns());
            for sample in block.payload() {
                recording.write(Entry::Sample(*sample));
            }
            recording.flush_if_due();
        }
        while let Some(status) = self.status.receive().context("the loop's status cannot be received")? {
            if ending.hear(status.payload(), rig::monotonic_time_ns()) {
                recording.write(Entry::Status(Box::new(*status.payload())));
            }
        }
        while let Some(update) = self.fits.receive().context("estimates cannot be received")? {
            if update.payload().run_id == recording.run_id() {
                recording.write(Entry::Fit(Box::new(*update.payload())));
            }
        }
        while let Some(health) = self.healths.receive().context("health reports cannot be received")? {
            recording.write(Entry::Health(*health.payload()));
        }
        while let Some(json) = self.models.receive().context("rendered models cannot be received")? {
            match serde_json::from_slice::<ModelChange>(json.payload()) {
                Ok(change) if change.run_id == recording.run_id() => recording.write(Entry::Model(Box::new(change))),
                Ok(_) => {}
                // The samples are worth more than a model.
                Err(error) => {
                    tracing::warn!("a rendered model is not recorded ({error}); use programs of the same build");
                }
            }
        }
        recording.flush_if_due();
        self.report_health(recording.lost_samples())
    }

    fn report_health(&mut self, lost_samples: u64) -> anyhow::Result<()> {
        if let Some(report) = self.health.report(lost_samples) {
            self.own_health.send_copy(report).context("the recorder's health cannot be sent")?;
        }
        Ok(())
    }
}
