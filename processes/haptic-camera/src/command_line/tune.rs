//! The options of `tune`.

use clap::Args;

use crate::compose::Assignment;

/// Options of `tune`.
#[derive(Clone, Debug, Args)]
pub struct TuneOptions {
    /// Switch to this model: a model file, or 1 to 5 for the paper's knobs
    #[arg(long, value_name = "1…5|MODEL.toml")]
    pub model: Option<String>,
    /// Parameters to set, by their names in a model file; without these or a model, show the present model
    #[arg(value_name = "NAME=VALUE")]
    pub settings: Vec<Assignment<f64>>,
}
