//! `sheet`: the figures of a data sheet, from captures or from other people's testers' files.

mod files;
mod table;

use sheet::Sheet;

use crate::command_line::SheetOptions;
use crate::outcome::{Outcome, say};
use crate::outputs::{to_output, write_json};
pub use files::{curves, files_of};

/// Reads the curves, makes the sheet, and writes what was asked for.
///
/// # Errors
/// One sentence on what is wrong with a file.
pub fn run(options: &SheetOptions) -> anyhow::Result<Outcome> {
    let choice = options.table.choice()?;
    let files = files_of(&options.captures)?;
    let sheet = Sheet::of(&curves(&files, choice.as_ref())?)?;
    if !to_output(options.json.as_deref()) {
        say(table::heading(&sheet, &files));
        say(table::figures(&sheet));
        table::untold(&sheet).iter().for_each(say);
    }
    write_json(options.json.as_deref(), &sheet)?;
    Ok(Outcome::Done)
}
