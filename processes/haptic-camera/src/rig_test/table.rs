//! The rig test for a terminal.

use comfy_table::Table;
use report::{ChannelDifference, ChannelLag};

use crate::terminal::table;

/// Original minus measured, beside the paper's rig; `filtered` is the SD behind the filters that the paper fits with.
pub fn differences(differences: &[ChannelDifference]) -> Table {
    let mut table = table(["channel", "mean", "SD", "filtered", "paper's mean", "paper's SD", "unit"], 1..6);
    for row in differences {
        table.add_row([
            row.channel.to_owned(),
            format!("{:.5}", row.mean),
            format!("{:.5}", row.sd),
            format!("{:.5}", row.sd_filtered),
            format!("{:.4}", row.paper_mean),
            format!("{:.4}", row.paper_sd),
            row.unit.to_owned(),
        ]);
    }
    table
}

/// Phase lags at 30 Hz, beside what the paper says of its own.
pub fn lags(lags: &[ChannelLag]) -> Table {
    let mut table = table(["lag at 30 Hz", "rad", "ms", "gain", "paper"], 1..5);
    for lag in lags {
        table.add_row([
            lag.channel.to_owned(),
            format!("{:.4}", lag.phase_rad),
            format!("{:.3}", lag.delay_ms),
            format!("{:.4}", lag.gain),
            format!("< {} rad", lag.paper_phase_rad_below),
        ]);
    }
    table
}
