//! The JSON of a diagnosis and its captures' rows, as far as it is drawn.

use serde::Deserialize;

/// A diagnosis with the rows that it compared.
#[derive(Clone, Debug, Deserialize)]
pub struct DiagnosisInput {
    /// What `diagnose --json` writes.
    pub diagnosis: Diagnosis,
    /// The captures: training first, then held-out.
    pub captures: Vec<CaptureRows>,
}

/// The rows of a capture.
#[derive(Clone, Debug, Deserialize)]
pub struct CaptureRows {
    /// `training` or `heldout`.
    pub role: String,
    /// The file that it is from.
    pub source: String,
    /// The rows in the order of time.
    pub rows: Vec<Row>,
}

/// One row; see `identification::diagnosis::Row`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[allow(missing_docs, reason = "documented where they are written")]
pub struct Row {
    pub t_s: f64,
    pub angle_rad: f64,
    pub velocity_rad_s: f64,
    pub torque_mnm: f64,
    pub residual_before_mnm: f64,
    pub residual_after_mnm: f64,
}

/// A diagnosis; see `identification::diagnosis::Diagnosis`.
#[derive(Clone, Debug, Deserialize)]
#[allow(missing_docs, reason = "documented where they are written")]
pub struct Diagnosis {
    pub summary: String,
    pub heldout_rms_before: f64,
    pub heldout_rms_after: f64,
    pub noise_floor_rms: f64,
    pub forward_angle_rms_rad: Option<[f64; 2]>,
    pub forward_from_command: Option<ForwardFromCommand>,
    pub steps: Vec<Step>,
    #[serde(rename = "where")]
    pub locations: Vec<Location>,
    pub where_after: Vec<Location>,
    pub next_experiment: Option<NextExperiment>,
    #[serde(default)]
    pub notes: Vec<String>,
}

/// See `identification::diagnosis::ForwardFromCommand`.
#[derive(Clone, Debug, Deserialize)]
#[allow(missing_docs, reason = "documented where they are written")]
pub struct ForwardFromCommand {
    pub angle_rms_rad: Vec<f64>,
}

/// See `identification::diagnosis::Step`.
#[derive(Clone, Debug, Deserialize)]
#[allow(missing_docs, reason = "documented where they are written")]
pub struct Step {
    pub effect: String,
    pub parameters: std::collections::BTreeMap<String, Value>,
    pub heldout_rms_before: f64,
    pub heldout_rms_after: f64,
    pub placebo_rms: f64,
    pub evidence: f64,
    pub rivals: Vec<Rival>,
    pub ties: Vec<String>,
}

/// See `identification::diagnosis::Value`.
#[derive(Clone, Debug, Deserialize)]
#[allow(missing_docs, reason = "documented where they are written")]
pub struct Value {
    pub value: f64,
    pub unit: String,
    pub ci95: Option<[f64; 2]>,
}

/// See `identification::diagnosis::Rival`.
#[derive(Clone, Debug, Deserialize)]
#[allow(missing_docs, reason = "documented where they are written")]
pub struct Rival {
    pub effect: String,
    pub heldout_rms_after: f64,
    pub evidence: f64,
    pub disqualified: Option<String>,
}

/// See `identification::diagnosis::Location`.
#[derive(Clone, Debug, Deserialize)]
#[allow(missing_docs, reason = "documented where they are written")]
pub struct Location {
    pub coordinate: String,
    pub unit: String,
    pub explained_percent: f64,
    pub significant: bool,
    pub map: Vec<[f64; 2]>,
}

/// See `identification::diagnosis::NextExperiment`.
#[derive(Clone, Debug, Deserialize)]
#[allow(missing_docs, reason = "documented where they are written")]
pub struct NextExperiment {
    pub reason: String,
}
