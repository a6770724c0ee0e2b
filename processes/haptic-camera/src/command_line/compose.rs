//! The options of `compose`.

use std::path::PathBuf;

use clap::Args;

use crate::compose::{Assignment, Extra};

/// Options of `compose`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("parts").args(["inertia", "friction", "detents", "extra"]).required(true).multiple(true)))]
pub struct ComposeOptions {
    /// Take the inertia of this knob: 1 to 5 for the paper's, or a model file
    #[arg(long, value_name = "1…5|FILE.toml")]
    pub inertia: Option<String>,
    /// Take the friction of this knob, with static friction and everything that modulates friction
    #[arg(long, value_name = "1…5|FILE.toml")]
    pub friction: Option<String>,
    /// Take the detents of this knob, or of a table with the header angle_rad,torque_mnm over one period
    #[arg(long, value_name = "1…5|FILE.toml|FILE.csv")]
    pub detents: Option<String>,
    /// Add an effect of another knob, as in 5:backlash or springy.toml:return-spring; may be repeated
    #[arg(long, value_name = "KNOB:EFFECT")]
    pub extra: Vec<Extra>,
    /// Set a parameter, as in detent_amplitude=1.5; may be repeated
    #[arg(long, value_name = "NAME=NUMBER")]
    pub set: Vec<Assignment<f64>>,
    /// Take a parameter's value from another knob, as in detent_amplitude=4; may be repeated
    #[arg(long, value_name = "NAME=KNOB")]
    pub from: Vec<Assignment<String>>,
    /// The model's name [default: that of its file]
    #[arg(long)]
    pub name: Option<String>,
    /// Write the model here; an earlier composed model is replaced
    #[arg(long, value_name = "MODEL.toml")]
    pub out: PathBuf,
    /// Overwrite any existing file
    #[arg(long)]
    pub overwrite: bool,
}
