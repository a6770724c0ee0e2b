//! The options of `compose`.

use std::path::PathBuf;

use clap::Args;

use crate::compose::{Assignment, Extra};

/// Options of `compose`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("parts").args(["inertia", "friction", "detents", "extra"]).required(true).multiple(true)))]
pub struct ComposeOptions {
    /// The knob whose inertia it has: 1 to 5 for the paper's, or a model file
    #[arg(long, value_name = "1…5|FILE.toml")]
    pub inertia: Option<String>,
    /// The knob whose friction it has, with stick and all that modulates friction
    #[arg(long, value_name = "1…5|FILE.toml")]
    pub friction: Option<String>,
    /// The knob whose detents it has, or a table with the header angle_rad,torque_mnm over one period
    #[arg(long, value_name = "1…5|FILE.toml|FILE.csv")]
    pub detents: Option<String>,
    /// One more effect of another knob, as in 5:backlash or springy.toml:return-spring; may be repeated
    #[arg(long, value_name = "KNOB:EFFECT")]
    pub extra: Vec<Extra>,
    /// A value for a parameter, as in detent_amplitude=1.5; may be repeated
    #[arg(long, value_name = "NAME=NUMBER")]
    pub set: Vec<Assignment<f64>>,
    /// A parameter's value from another knob, as in detent_amplitude=4; may be repeated
    #[arg(long, value_name = "NAME=KNOB")]
    pub from: Vec<Assignment<String>>,
    /// What the model is called [default: as its file]
    #[arg(long)]
    pub name: Option<String>,
    /// Where the model goes; a model that was composed before is replaced
    #[arg(long, value_name = "MODEL.toml")]
    pub out: PathBuf,
    /// Write over whatever lies there
    #[arg(long)]
    pub overwrite: bool,
}
