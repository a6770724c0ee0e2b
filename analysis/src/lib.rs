//! What is made of loaded captures: fits, diagnoses, simulations, and all that is told of them.
//!
//! The command line and the Python package are two ways to the same numbers. Whatever either tells as JSON or as a page is made
//! here, once; how it reaches its reader is theirs.

mod diagnosis;
mod error;
mod facts;
mod fit;
mod result;
mod row;
mod sheet;
mod simulation;

pub use diagnosis::{ToldDiagnosis, diagnose, diagnosed_model, refuse_drawn};
pub use error::AnalysisError;
pub use facts::{facts, fit_page, title};
pub use fit::{ToldAverage, ToldFit, common_truth, fit, fit_options, fit_with, titles};
pub use result::{MADE_BY, to_json, to_json_on};
pub use row::{Cell, Row};
pub use sheet::{Judgements, curve_files, curves, judged, load_specification, sheet_page};
pub use simulation::{Drive, Simulation, along_motion, simulate, torque_at_knob};
