//! `compare`: several captures or knobs side by side, as the paper's Tables 4 to 6 have them.

mod table;

use std::path::Path;

use analysis::Comparing;
use clap::Args;
use dynamics::knobs;

use crate::command_line::ColumnOptions;
use crate::command_line::outputs::ResultFiles;
use crate::load;

#[derive(Debug, Args)]
pub struct CompareOptions {
    /// What to compare: captures, model files, or 1 to 5 for the paper's knobs; captures of one knob are averaged
    #[arg(required = true, value_name = "CAPTURE|MODEL.toml")]
    pub subjects: Vec<String>,
    #[command(flatten)]
    pub columns: ColumnOptions,
    #[command(flatten)]
    pub results: ResultFiles,
}

pub fn run(options: &CompareOptions) -> anyhow::Result<()> {
    let mut comparing = Comparing::default();
    for name in &options.subjects {
        if load::names_model(name) {
            comparing.add_model(name, knobs::named(name)?);
        } else {
            comparing.add_capture(load::load_measured(Path::new(name), &options.columns)?)?;
        }
    }
    let compared = comparing.comparison();
    let axes = compared.knobs.iter().filter_map(|knob| knob.model.as_ref()).map(|model| model.axis);
    let axis = analysis::common_axis(axes)?;
    options.results.tell(axis, table::lines(&compared), &compared, || report::comparison_page(&compared))
}
