//! Where a model and a capture disagree, what is missing in the words of the field, and whether adding it helps.

mod acceptance;
mod capture;
mod characteristic;
mod columns;
mod commanded;
mod encoder_zero;
mod error;
mod experiment;
mod findings;
mod hypotheses;
mod intervals;
mod judged;
mod lobes;
mod locate;
mod nonlinear;
mod null_test;
mod pairs;
mod periodogram;
mod revision;
mod rows;
mod search;
mod separable;
mod sticking;
mod structure;
mod trials;
mod twist;
mod undetermined;
mod unequal;
mod verdict;
mod workflow;

pub use commanded::CommandedTorque;
pub use error::DiagnosisError;
pub use findings::{
    Characteristic, Diagnosis, ForwardFromCommand, NextExperiment, Partial, Rival, Row, Step, Value, Verdict,
};
pub use locate::Location;
pub use verdict::FORWARD_WINDOW_S;
pub use workflow::{DiagnoseOptions, Progress, diagnose};
