//! The supervisor's link to the control loop and to what the consumers say.

use std::time::{Duration, Instant};

use anyhow::Context as _;
use shared_types::services::{
    self, ControlClient, FIT_UPDATES, LOOP_STATUS, MessageSubscriber, PROCESS_HEALTH, RigNode,
};
use shared_types::{CommandKind, ControlRequest, FitUpdate, LoopStatus, ProcessHealth, ProcessKind};

/// Longest wait for the loop's answer to a request.
const ANSWER: Duration = Duration::from_secs(2);

/// What the supervisor hears and says.
pub(crate) struct LoopLink {
    control: ControlClient,
    statuses: MessageSubscriber<LoopStatus>,
    fits: MessageSubscriber<FitUpdate>,
    healths: MessageSubscriber<ProcessHealth>,
    loop_process: u32,
    status: LoopStatus,
    fit: Option<FitUpdate>,
    health: Vec<ProcessHealth>,
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
            loop_process,
            status: LoopStatus::default(),
            fit: None,
            health: Vec::new(),
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
            self.health.retain(|known| known.process != health.process);
            self.health.push(*health);
        }
    }

    /// The loop's last status.
    pub(crate) fn status(&self) -> &LoopStatus {
        &self.status
    }

    /// The live fitter's last word on this run.
    pub(crate) fn fit(&self) -> Option<&FitUpdate> {
        self.fit.as_ref().filter(|fit| fit.run_id == self.status.run_id)
    }

    /// Whether a consumer has reported.
    pub(crate) fn has_heard_from(&self, kind: ProcessKind) -> bool {
        self.health.iter().any(|health| health.process == kind.code())
    }

    /// Asks something of the loop.
    pub(crate) fn request(&self, kind: CommandKind) -> anyhow::Result<()> {
        let pending = self
            .control
            .send_copy(ControlRequest { kind: kind.code(), reserved: 0 })
            .map_err(|error| anyhow::anyhow!("{error:?}"))
            .context("the control loop could not be asked")?;
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
