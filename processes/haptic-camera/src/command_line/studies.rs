//! The options of `capability` and `gauge`.

use std::path::PathBuf;

use clap::Args;

use super::columns::ColumnOptions;

/// Units and the figures to study.
#[derive(Debug, Args)]
pub struct StudyOptions {
    /// Captures or testers' files
    #[arg(required_unless_present = "values", value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// A table of values instead of captures, with the columns part, operator (numbers) and value; needs --figure
    #[arg(long, value_name = "FILE.csv", conflicts_with = "captures", requires = "figure")]
    pub values: Option<PathBuf>,
    /// The figure to study, such as collapse_force [default: those that the specification limits]
    #[arg(long, value_name = "NAME")]
    pub figure: Option<String>,
    /// What the columns are
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// Write the study as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Options of `capability`.
#[derive(Debug, Args)]
pub struct CapabilityOptions {
    /// Units in the order in which they were made
    #[command(flatten)]
    pub study: StudyOptions,
    /// Limits on the figures
    #[arg(long, value_name = "SPEC.toml")]
    pub spec: PathBuf,
    /// Consecutive units in a subgroup; 1 for single units
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub subgroup: usize,
    /// Write the figures as a Q-DAS file
    #[arg(long, value_name = "FILE.dfq")]
    pub dfq: Option<PathBuf>,
}

/// Options of `gauge`.
#[derive(Debug, Args)]
pub struct GaugeOptions {
    /// Captures in folders PART/OPERATOR/
    #[command(flatten)]
    pub study: StudyOptions,
    /// Limits on the figures, for %GRR of the tolerance
    #[arg(long, value_name = "SPEC.toml")]
    pub spec: Option<PathBuf>,
    /// Every operator measured different parts
    #[arg(long)]
    pub nested: bool,
}
