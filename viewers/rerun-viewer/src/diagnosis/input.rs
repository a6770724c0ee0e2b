//! The JSON of a diagnosis and its captures' rows, as far as it is drawn: see the types of `identification::diagnosis`.
#![allow(missing_docs, reason = "documented where they are written")]

use std::collections::BTreeMap;

use serde::Deserialize;

/// What `haptic-camera diagnose --recording` hands over.
#[derive(Clone, Debug, Deserialize)]
pub struct DiagnosisInput {
    pub diagnosis: Diagnosis,
    /// The captures: training first, then held-out.
    pub captures: Vec<CaptureRows>,
}

/// The rows of a capture in the order of time.
#[derive(Clone, Debug, Deserialize)]
pub struct CaptureRows {
    /// `training` or `heldout`.
    pub role: String,
    /// The file that it is from.
    pub source: String,
    pub rows: Vec<Row>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
pub struct Row {
    pub t_s: f64,
    pub angle_rad: f64,
    pub velocity_rad_s: f64,
    pub torque_mnm: f64,
    pub residual_before_mnm: f64,
    pub residual_after_mnm: f64,
}

#[derive(Clone, Debug, Deserialize)]
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

#[derive(Clone, Debug, Deserialize)]
pub struct ForwardFromCommand {
    pub angle_rms_rad: Vec<f64>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Step {
    pub effect: String,
    pub parameters: BTreeMap<String, Value>,
    pub heldout_rms_before: f64,
    pub heldout_rms_after: f64,
    pub placebo_rms: f64,
    pub evidence: f64,
    pub rivals: Vec<Rival>,
    pub ties: Vec<String>,
}

impl Step {
    /// The effect itself, then its rivals.
    pub fn contenders(&self) -> Vec<Rival> {
        let Self { effect, heldout_rms_after, evidence, rivals, .. } = self;
        let (effect, heldout_rms_after, evidence) = (effect.clone(), *heldout_rms_after, *evidence);
        let mut contenders = vec![Rival { effect, heldout_rms_after, evidence, disqualified: None }];
        contenders.extend_from_slice(rivals);
        contenders
    }
}

#[derive(Clone, Debug, Deserialize)]
pub struct Value {
    pub value: f64,
    pub unit: String,
    pub ci95: Option<[f64; 2]>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Rival {
    pub effect: String,
    pub heldout_rms_after: f64,
    pub evidence: f64,
    pub disqualified: Option<String>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct Location {
    pub coordinate: String,
    pub unit: String,
    pub explained_percent: f64,
    pub significant: bool,
    pub map: Vec<[f64; 2]>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct NextExperiment {
    pub reason: String,
}
