//! What crosses a process border about the model that is rendered: asked, answered, published.

use serde::{Deserialize, Serialize};

/// Longest model that can be sent to the control loop, bytes of TOML.
pub const MODEL_MAX_BYTES: usize = 32 * 1024;

/// What is asked of the control loop about the model that it renders, as JSON.
///
/// Whoever changes a model says which one he changed: of two changes at once the later one would undo the earlier.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "request", rename_all = "kebab-case")]
pub enum ModelRequest {
    /// Which model is it?
    Present,
    /// Feel like this one instead.
    Replace {
        /// Revision of the model that this one takes the place of.
        revision: u64,
        /// The model, as TOML.
        model_toml: String,
    },
}

/// The control loop's answer to a [`ModelRequest`], as JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "answer", rename_all = "kebab-case")]
pub enum ModelAnswer {
    /// The newest model that was taken: it is rendered, or is about to be.
    Rendered {
        /// Counts the models that were taken in this run.
        revision: u64,
        /// The model.
        model_toml: String,
    },
    /// Another was faster: this is the model now, and the one that was sent is not taken.
    Overtaken {
        /// Counts the models that were taken in this run.
        revision: u64,
        /// The model.
        model_toml: String,
    },
    /// The model is taken, and begins to be felt.
    Taken {
        /// What will be felt otherwise than the model says, in sentences.
        remarks: Vec<String>,
    },
    /// A model that was sent before has not begun to be felt: send this one again in a moment.
    Busy,
    /// The model is not taken.
    Refused {
        /// Why not, and what would do, in one sentence.
        reason: String,
    },
}

/// A model that begins to be felt in a run; published as JSON with history, kept in the archive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelChange {
    /// Identity of the run.
    pub run_id: u64,
    /// Tick from which the model is felt: there the one before begins to give way to it.
    pub tick: u64,
    /// CLOCK_MONOTONIC at which that tick was due, ns.
    pub monotonic_time_ns: u64,
    /// The model, as TOML.
    pub model_toml: String,
}

impl ModelChange {
    /// Schema name in an archive.
    pub const SCHEMA_NAME: &str = "haptic_camera/msg/ModelChange";
    /// The `ros2msg` schema of [`cdr_body`](Self::cdr_body).
    pub const SCHEMA_TEXT: &str = "uint64 run_id  # Identity of the run.\n\
        uint64 tick  # Tick from which the model is felt.\n\
        uint64 monotonic_time_ns  # CLOCK_MONOTONIC at which that tick was due, ns.\n\
        string model_toml  # The model, as TOML.\n";

    /// The message as a CDR body, without the header of four bytes.
    ///
    /// A string is its length with the closing zero, four bytes, its bytes and the zero (OMG DDS-XTypes 1.3, §7.4.3).
    #[must_use]
    pub fn cdr_body(&self) -> Vec<u8> {
        let Self { run_id, tick, monotonic_time_ns, model_toml } = self;
        let mut body = Vec::with_capacity(29 + model_toml.len());
        for count in [run_id, tick, monotonic_time_ns] {
            body.extend_from_slice(&count.to_le_bytes());
        }
        let length = u32::try_from(model_toml.len() + 1).unwrap_or(u32::MAX);
        body.extend_from_slice(&length.to_le_bytes());
        body.extend_from_slice(model_toml.as_bytes());
        body.push(0);
        body
    }

    /// The message from its CDR body; `None` where that is too short or no text.
    #[must_use]
    pub fn from_cdr_body(body: &[u8]) -> Option<Self> {
        let (counts, text) = body.split_at_checked(24)?;
        let count = |index: usize| Some(u64::from_le_bytes(*counts.get(8 * index..)?.first_chunk()?));
        let (length, text) = text.split_first_chunk()?;
        let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
        let text = text.get(..length)?.strip_suffix(&[0])?;
        Some(Self {
            run_id: count(0)?,
            tick: count(1)?,
            monotonic_time_ns: count(2)?,
            model_toml: String::from_utf8(text.to_vec()).ok()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::ModelChange;

    #[test]
    fn a_model_change_comes_back_from_its_bytes_and_a_cut_one_does_not() {
        let change =
            ModelChange { run_id: 5, tick: 1 << 40, monotonic_time_ns: 3, model_toml: "name = \"θ\"\n".into() };
        let body = change.cdr_body();
        assert_eq!(ModelChange::from_cdr_body(&body), Some(change));
        for length in 0..body.len() {
            assert_eq!(ModelChange::from_cdr_body(&body[..length]), None, "{length} bytes");
        }
    }
}
