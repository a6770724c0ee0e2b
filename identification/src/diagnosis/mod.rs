//! Where a model and a capture disagree, what is missing in the words of the field, and whether adding it helps.

mod both_cores;
mod capture;
mod commanded;
mod experiment;
mod findings;
mod hypotheses;
mod intervals;
mod judged;
mod locate;
mod nonlinear;
mod normal;
mod periodogram;
mod placebo;
mod rows;
mod separable;
mod structure;
mod twist;
mod workflow;

pub use commanded::CommandedTorque;
pub use findings::{Diagnosis, ForwardFromCommand, NextExperiment, Partial, Rival, Row, Step, Value, Verdict};
pub use locate::Location;
pub use workflow::{DiagnoseOptions, DiagnosisError, FORWARD_WINDOW_S, Progress, diagnose};
