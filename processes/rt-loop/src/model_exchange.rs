//! Models in and out of a running replay: sent, checked, handed to the loop, published once they are felt.

use dynamics::Model;
use iceoryx2::port::update_connections::UpdateConnections as _;
use operator::remark;
use shared_types::services::{self, ModelServer, RigNode, ServiceError, TextPublisher};
use shared_types::{LoopState, ModelAnswer, ModelChange, ModelRequest, RunDescription};

use crate::admission::Admission;
use crate::realtime::{ModelEvent, ModelPort};

/// How messages call a model that was sent.
const ORIGIN: &str = "the model";

/// The publisher's part in models.
pub(crate) struct ModelExchange {
    server: ModelServer,
    changes: TextPublisher,
    port: ModelPort,
    /// What a model must pass; `None` where no model is rendered.
    admission: Option<Admission>,
    run_id: u64,
    /// The newest model that was taken, as TOML.
    newest_toml: String,
    /// Counts the models that were taken.
    revision: u64,
    /// Whether the newest model is not felt so far.
    newest_waits: bool,
}

impl ModelExchange {
    /// Opens the services and publishes the model with which the run begins.
    pub(crate) fn open(
        node: &RigNode,
        port: ModelPort,
        run: &RunDescription,
        admission: Option<Admission>,
    ) -> Result<Self, ServiceError> {
        let exchange = Self {
            server: services::model_server(node)?,
            changes: services::MODEL_CHANGES.publisher(node)?,
            port,
            admission,
            run_id: run.run_id,
            newest_toml: run.rendered_model_toml.clone().unwrap_or_default(),
            revision: 0,
            newest_waits: false,
        };
        if run.is_rendered() {
            exchange.publish(0, run.clock.monotonic_time_ns);
        }
        Ok(exchange)
    }

    /// Publishes what is felt, frees what is no longer, and answers who asks.
    pub(crate) fn serve(&mut self, state: LoopState) {
        while let Ok(event) = self.port.events.pop() {
            match event {
                ModelEvent::Rendered { tick, monotonic_time_ns } => {
                    self.newest_waits = false;
                    self.publish(tick, monotonic_time_ns);
                }
                ModelEvent::Retired(model) => drop(model),
            }
        }
        while let Ok(Some(request)) = self.server.receive() {
            let answer = self.answer(request.payload(), state);
            let text = serde_json::to_vec(&answer).unwrap_or_default();
            let sent = request
                .loan_slice_uninit(text.len())
                .map_err(|error| format!("{error:?}"))
                .and_then(|place| place.write_from_slice(&text).send().map_err(|error| format!("{error:?}")));
            if let Err(reason) = sent {
                tracing::warn!("a model was received, but the answer could not be sent ({reason})");
            }
        }
    }

    /// Gives consumers that came meanwhile the history.
    pub(crate) fn greet(&self) {
        let _ = self.changes.update_connections();
    }

    /// Says if a model was taken that is never felt, since the run is over.
    pub(crate) fn close(&self) {
        if self.newest_waits {
            remark("the run ended before the last model could be rendered");
        }
    }

    fn answer(&mut self, request: &[u8], state: LoopState) -> ModelAnswer {
        let refused = |reason: String| ModelAnswer::Refused { reason };
        let Some(admission) = &self.admission else {
            return refused(
                "nothing is rendered: the run is a capture; start a replay with `haptic-camera replay MODEL`"
                    .to_owned(),
            );
        };
        let (revision, model_toml) = match serde_json::from_slice(request) {
            Ok(ModelRequest::Present) => {
                return ModelAnswer::Rendered { revision: self.revision, model_toml: self.newest_toml.clone() };
            }
            Ok(ModelRequest::Replace { revision, model_toml }) => (revision, model_toml),
            Err(error) => {
                return refused(format!("the request cannot be read ({error}); use programs of the same build"));
            }
        };
        if !matches!(state, LoopState::Armed | LoopState::Running) {
            return refused("the replay is ending; start another with `haptic-camera replay MODEL`".to_owned());
        }
        if revision != self.revision {
            return ModelAnswer::Overtaken { revision: self.revision, model_toml: self.newest_toml.clone() };
        }
        if self.newest_waits {
            return ModelAnswer::Busy;
        }
        let admitted =
            Model::from_toml(&model_toml, ORIGIN).map_err(|error| error.to_string()).and_then(|model| match admission
                .admit(&model)
            {
                Ok(admitted) => Ok((model, admitted)),
                Err(error) => Err(error.to_string()),
            });
        let (model, admitted) = match admitted {
            Ok(admitted) => admitted,
            Err(reason) => return refused(reason),
        };
        if self.port.models.push(admitted.rendered).is_err() {
            return ModelAnswer::Busy;
        }
        self.newest_toml = model.to_toml();
        self.revision += 1;
        self.newest_waits = true;
        ModelAnswer::Taken { remarks: admitted.remarks }
    }

    /// Publishes that the newest model is felt from `tick` on.
    fn publish(&self, tick: u64, monotonic_time_ns: u64) {
        let change = ModelChange { run_id: self.run_id, tick, monotonic_time_ns, model_toml: self.newest_toml.clone() };
        let text = serde_json::to_vec(&change).unwrap_or_default();
        let sent = self
            .changes
            .loan_slice_uninit(text.len())
            .map_err(|error| format!("{error:?}"))
            .and_then(|place| place.write_from_slice(&text).send().map_err(|error| format!("{error:?}")));
        if let Err(reason) = sent {
            tracing::error!("the model rendered from tick {tick} on could not be published ({reason})");
        }
    }
}
