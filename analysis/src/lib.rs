//! What loaded captures tell: fits, diagnoses, simulations, checks, comparisons and studies, and their results as JSON.
//!
//! The command line and the Python package both take every result from here, as JSON or as a page, and so report the same
//! numbers.

mod calibration;
mod check;
mod comparison;
mod diagnosis;
mod error;
mod facts;
mod fit;
mod paper;
mod rendering;
mod result;
mod rig_check;
mod rig_test;
mod row;
mod sheet;
mod simulation;
mod studies;

pub use calibration::CalibrationKind;
pub use check::{Check, CheckedQuantity, LostMotionError, Shown, Threshold};
pub use comparison::Comparing;
pub use diagnosis::{DiagnosisResult, diagnose, diagnose_in_these_roles, diagnosed_model, refuse_drawn};
pub use error::{AnalysisError, common_axis};
pub use facts::{facts, fit_page};
pub use fit::{AverageResult, FitResult, common_truth, fit, fit_options, fit_with, mean_fit, titles};
pub use rendering::{RenderedCaptures, holding_torque_mnm, rendering};
pub use result::{MADE_BY, to_json, to_json_on};
pub use rig_check::{Reading, RigCheck};
pub use rig_test::{Commanded, rig_test};
pub use row::{CI95_ENDS, Cell, Row};
pub use sheet::{Judgements, curve_files, curves, ends_in, judged, leave_exports_out, load_specification, sheet_page};
pub use simulation::{Drive, Simulation, simulate};
use simulation::{along_motion, torque_at_knob};
pub use studies::{Study, StudyError};
