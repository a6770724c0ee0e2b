//! The control loop that renders, asked for its model and sent another.

use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use dynamics::Model;
use shared_types::services::{self, ModelClient, RigNode};
use shared_types::{MODEL_MAX_BYTES, ModelAnswer, ModelRequest};

use crate::supervision::clear_shared_memory;

/// Longest wait for one answer, after which the request is sent again. Checking a model takes a tenth of a second of a core that the
/// loop's publisher may have to share.
const ANSWER: Duration = Duration::from_secs(2);
/// Times that a request is sent. One that was taken without the answer coming back is answered by its own model.
const ATTEMPTS: u32 = 5;
/// Longest wait until the loop can take a model: it takes one in a quarter of a second.
const PATIENCE: Duration = Duration::from_secs(2);
/// Pause before a model is sent again.
const PAUSE: Duration = Duration::from_millis(10);

pub(super) struct LoopModels {
    client: ModelClient,
    // Last, since ports go before the node they belong to.
    _node: RigNode,
}

/// The model that a replay renders, or is about to.
pub(super) struct Present {
    pub(super) model: Model,
    revision: u64,
}

impl Present {
    fn read(revision: u64, model_toml: &str) -> anyhow::Result<Self> {
        Ok(Self { model: Model::from_toml(model_toml, "the rendered model")?, revision })
    }
}

/// What became of a model that was sent.
pub(super) enum Sent {
    /// It is felt; in sentences, what of it otherwise than it says.
    Taken(Vec<String>),
    /// Another was faster; this is the model now.
    Overtaken(Present),
}

enum Asked {
    Answer(ModelAnswer),
    /// Nobody is there, or who was there let go of the request.
    Nobody,
    Silence,
}

impl LoopModels {
    pub(super) fn open() -> anyhow::Result<Self> {
        let node = services::attach("tune")?;
        Ok(Self { client: services::model_client(&node)?, _node: node })
    }

    /// The model that is rendered, or is about to be.
    pub(super) fn present(&self) -> anyhow::Result<Present> {
        match self.ask(&ModelRequest::Present)? {
            Some(ModelAnswer::Rendered { revision, model_toml }) => Present::read(revision, &model_toml),
            Some(ModelAnswer::Refused { reason }) => bail!(reason),
            Some(other) => bail!("the control loop did not report its model, but {other:?}"),
            None => {
                clear_shared_memory();
                bail!("no replay is running on this rig; start one with `haptic-camera replay MODEL`")
            }
        }
    }

    /// Sends a model that is to take the place of `present`.
    pub(super) fn send(&self, model: &Model, present: &Present) -> anyhow::Result<Sent> {
        let model_toml = model.to_toml();
        anyhow::ensure!(
            model_toml.len() <= MODEL_MAX_BYTES,
            "the model takes {} bytes, but at most {MODEL_MAX_BYTES} can be sent; shorten its description",
            model_toml.len()
        );
        let request = ModelRequest::Replace { revision: present.revision, model_toml };
        let deadline = Instant::now() + PATIENCE;
        loop {
            match self.ask(&request)? {
                Some(ModelAnswer::Taken { remarks }) => return Ok(Sent::Taken(remarks)),
                Some(ModelAnswer::Overtaken { revision, model_toml }) => {
                    return Present::read(revision, &model_toml).map(Sent::Overtaken);
                }
                Some(ModelAnswer::Refused { reason }) => bail!(reason),
                Some(ModelAnswer::Busy) if Instant::now() < deadline => std::thread::sleep(PAUSE),
                Some(ModelAnswer::Busy) => {
                    bail!("the replay has yet to start rendering an earlier model; try again in a moment")
                }
                Some(other) => bail!("the control loop gave an unexpected answer to the model: {other:?}"),
                None => bail!("the replay ended before it could take the model"),
            }
        }
    }

    /// A request and its answer; `None` when nobody is there to answer.
    fn ask(&self, request: &ModelRequest) -> anyhow::Result<Option<ModelAnswer>> {
        let mut nobody = false;
        for _ in 0..ATTEMPTS {
            match self.ask_once(request)? {
                Asked::Answer(answer) => return Ok(Some(answer)),
                Asked::Nobody if nobody => return Ok(None),
                Asked::Nobody => nobody = true,
                Asked::Silence => {}
            }
        }
        bail!("the control loop did not answer within {} s", (ATTEMPTS * ANSWER).as_secs())
    }

    fn ask_once(&self, request: &ModelRequest) -> anyhow::Result<Asked> {
        let text = serde_json::to_vec(request).context("the model has no text form")?;
        let unasked =
            |error: String| anyhow::anyhow!(error).context("the request could not be sent to the control loop");
        let place = self.client.loan_slice_uninit(text.len()).map_err(|error| unasked(format!("{error:?}")))?;
        let pending = place.write_from_slice(&text).send().map_err(|error| unasked(format!("{error:?}")))?;
        if pending.number_of_server_connections() == 0 {
            return Ok(Asked::Nobody);
        }
        let deadline = Instant::now() + ANSWER;
        while Instant::now() < deadline {
            // Asked before: an answer comes before its sender lets go.
            let connected = pending.is_connected();
            if let Ok(Some(answer)) = pending.receive() {
                let answer = serde_json::from_slice(answer.payload())
                    .context("the control loop's answer cannot be read; use programs of the same build")?;
                return Ok(Asked::Answer(answer));
            }
            if !connected {
                return Ok(Asked::Nobody);
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(Asked::Silence)
    }
}
