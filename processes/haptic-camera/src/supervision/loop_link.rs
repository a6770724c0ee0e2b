//! The supervisor's link to the control loop and to what the consumers say.

use std::time::{Duration, Instant};

use shared_types::services::{
    self, ControlClient, FIT_UPDATES, LOOP_STATUS, MessageSubscriber, PROCESS_HEALTH, RigNode, TextSubscriber,
};
use shared_types::{
    CommandKind, ControlRequest, FitUpdate, LoopStatus, ModelChange, ProcessHealth, ProcessKind, RunDescription, rig,
};

/// Longest wait for the loop's answer to a request.
const ANSWER: Duration = Duration::from_secs(2);

pub(crate) fn unsent(error: impl std::fmt::Debug) -> anyhow::Error {
    anyhow::anyhow!("{error:?}").context("the request could not be sent to the control loop")
}

pub(crate) struct LoopLink {
    control: ControlClient,
    statuses: MessageSubscriber<LoopStatus>,
    fits: MessageSubscriber<FitUpdate>,
    healths: MessageSubscriber<ProcessHealth>,
    descriptions: TextSubscriber,
    model_changes: TextSubscriber,
    loop_process: u32,
    pub(super) status: LoopStatus,
    fit: Option<FitUpdate>,
    pub(super) health: Vec<ProcessHealth>,
    /// Longest silence of the recorder between two of its reports.
    pub(super) longest_absence: Duration,
    pub(super) run: RunDescription,
    /// The models that began to be felt so far.
    pub(super) models: Vec<(u64, String)>,
    // Last, since ports go before the node they belong to.
    _node: RigNode,
}

impl LoopLink {
    /// Attaches to the rig on which process `loop_process` runs the loop.
    pub(crate) fn open(loop_process: u32) -> anyhow::Result<Self> {
        let node = services::attach("haptic-camera")?;
        Ok(Self {
            control: services::control_client(&node)?,
            statuses: LOOP_STATUS.subscriber(&node)?,
            fits: FIT_UPDATES.subscriber(&node)?,
            healths: PROCESS_HEALTH.subscriber(&node)?,
            descriptions: services::RUN_DESCRIPTION.subscriber(&node)?,
            model_changes: services::MODEL_CHANGES.subscriber(&node)?,
            loop_process,
            status: LoopStatus::default(),
            fit: None,
            health: Vec::new(),
            longest_absence: Duration::ZERO,
            run: RunDescription::default(),
            models: Vec::new(),
            _node: node,
        })
    }

    /// Takes in all that was said since the last time.
    pub(crate) fn listen(&mut self) {
        while let Ok(Some(status)) = self.statuses.receive() {
            if status.process_id == self.loop_process {
                self.status = *status;
            }
        }
        while let Ok(Some(fit)) = self.fits.receive() {
            self.fit = Some(*fit);
        }
        while let Ok(Some(health)) = self.healths.receive() {
            if health.process == ProcessKind::Recorder.code() {
                self.longest_absence = self.longest_absence.max(self.absence_of_recorder());
            }
            self.health.retain(|known| known.process != health.process);
            self.health.push(*health);
        }
        while let Ok(Some(json)) = self.descriptions.receive() {
            if let Ok(run) = serde_json::from_slice(json.payload()) {
                self.run = run;
            }
        }
        while let Ok(Some(json)) = self.model_changes.receive() {
            // A message that cannot be read is reported by the recorder, which needs it.
            let change = serde_json::from_slice::<ModelChange>(json.payload()).ok();
            if let Some((tick, Ok(model))) = change.map(|change| (change.tick, change.model())) {
                self.models.push((tick, model.name));
            }
        }
    }

    /// Time in the run at the loop's last status, s.
    pub(crate) fn elapsed_s(&self) -> f64 {
        (self.status.published_samples + self.status.missed_ticks) as f64 / self.status.rate_hz.max(1.0)
    }

    /// The live fitter's last word on this run.
    pub(crate) fn fit(&self) -> Option<&FitUpdate> {
        self.fit.as_ref().filter(|fit| fit.run_id == self.status.run_id)
    }

    pub(crate) fn health_of(&self, kind: ProcessKind) -> Option<&ProcessHealth> {
        self.health.iter().find(|health| health.process == kind.code())
    }

    /// Time since the recorder's last report; zero before its first.
    pub(crate) fn absence_of_recorder(&self) -> Duration {
        let last_ns = self.health_of(ProcessKind::Recorder).map(|health| health.monotonic_time_ns);
        last_ns.map_or(Duration::ZERO, |last_ns| Duration::from_nanos(rig::monotonic_time_ns().saturating_sub(last_ns)))
    }

    pub(crate) fn request(&self, kind: CommandKind) -> anyhow::Result<()> {
        let request = ControlRequest { kind: kind.code(), reserved: 0 };
        let pending = self.control.send_copy(request).map_err(unsent)?;
        let deadline = Instant::now() + ANSWER;
        while Instant::now() < deadline {
            if let Ok(Some(answer)) = pending.receive() {
                // A refusal means that the run has just ended by itself, which the status tells.
                tracing::debug!("{kind:?} answered: accepted {} in state {}", answer.accepted, answer.state);
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        anyhow::bail!("the control loop did not answer within {} s", ANSWER.as_secs())
    }
}
