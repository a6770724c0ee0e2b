//! `check`: what captures show without a fit, beside a fitted model.

use std::path::PathBuf;

use analysis::{Check, CheckedQuantity, Shown, Threshold};
use clap::Args;
use comfy_table::Table;
use dynamics::Axis;

use crate::command_line::ColumnOptions;
use crate::command_line::outputs::write_json;
use crate::load;
use crate::outcome::show;
use crate::terminal::{self, digits, interval, number};

#[derive(Debug, Args)]
pub struct CheckOptions {
    /// Captures to look at: a slow turn for the detents, a creep or a torque ramp for the breakaway
    #[arg(required = true, value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// The fitted model to check
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

pub fn run(options: &CheckOptions) -> anyhow::Result<()> {
    let model = options.model.as_deref().map(load::model).transpose()?;
    let (mut captures, mut axes) = (Vec::new(), Vec::new());
    for path in &options.captures {
        let loaded = load::load_chosen(path, &options.columns)?;
        axes.push(loaded.capture.axis);
        captures.push(Shown::of(&loaded, model.as_ref())?);
    }
    let axis = analysis::common_axis(axes)?;
    let check = Check::of(axis, captures, model.as_ref());
    let found = if check.agreement.is_empty() {
        "found neither detents nor breakaways".to_owned()
    } else {
        axis.words(&table(&check.agreement).to_string()).into_owned()
    };
    let shown = |shown: &Shown| format!("- {}: {}", shown.capture, axis.words(&words(axis, shown)));
    show(std::iter::once(found).chain(check.captures.iter().map(shown)));
    write_json(axis, &options.json, &check)
}

fn words(axis: Axis, shown: &Shown) -> String {
    let mut words: Vec<String> = shown.no_detents.iter().cloned().collect();
    words.extend(shown.detents.as_ref().map(|count| match axis {
        Axis::Rotary => format!("{} detents in {:.0}°", count.detents, count.turned_rad.to_degrees()),
        Axis::Linear => format!("{} detents in {:.3} mm", count.detents, count.turned_rad),
    }));
    for (threshold, direction) in [(&shown.static_negative, "negative"), (&shown.static_positive, "positive")] {
        words.extend(threshold.as_ref().map(|Threshold { times, .. }| {
            let times = if *times == 1 { "once".to_owned() } else { format!("{times} times") };
            format!("broke away {times} in the {direction} direction")
        }));
    }
    words.extend(shown.no_static.map(|reason| reason.to_string()));
    words.join("; ")
}

fn table(agreement: &[CheckedQuantity]) -> Table {
    let rows = agreement.iter().map(|row| {
        let digits = digits(row.ci95.map_or(1e-3 * row.checked.abs(), |[low, high]| high - low));
        [
            row.quantity.to_owned(),
            format!("{:.digits$}", row.checked),
            interval(row.ci95, digits),
            number(row.model, digits),
            row.difference_percent.map_or_else(String::new, |percent| format!("{percent:+.1} %")),
            row.unit.to_owned(),
        ]
    });
    terminal::table(["quantity", "seen", "95 % interval", "fitted", "difference", "unit"], 1..5, rows)
}
