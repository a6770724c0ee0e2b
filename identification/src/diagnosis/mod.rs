//! What a model lacks to explain a capture: located, named and tested.
//!
//! `capture` prepares the two captures, `model_fit` fits a model to one, `search` tries effect after effect, and `verdict`
//! reports the result. [`diagnose`] calls them in this order.

mod capture;
mod comparison;
mod error;
mod findings;
mod model_fit;
mod search;
mod verdict;
mod workflow;

pub use error::DiagnosisError;
pub use findings::{
    Characteristic, Diagnosis, FLOOR_IS_DOUBTFUL, ForwardFromCommand, NextExperiment, Partial, Rival, Row, Step, Value,
    Verdict,
};
pub use search::forward::FORWARD_WINDOW_S;
pub use verdict::commanded::CommandedTorque;
pub use verdict::locate::Location;
pub use workflow::{DiagnoseOptions, Progress, diagnose, diagnose_either_way};
