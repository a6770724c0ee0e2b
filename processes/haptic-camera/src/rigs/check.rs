//! `rig check`: a rig brought up without torque, and what its channels read meanwhile.

use std::path::PathBuf;

use analysis::{Reading, RigCheck};
use clap::Args;
use dynamics::Axis;
use hal::RigFile;

use super::RigFileOptions;
use crate::command_line::outputs::write_json;
use crate::outcome::{Outcome, remark, show};
use crate::supervision::Interrupt;
use crate::terminal::table;
use crate::{load, rig_run};

#[derive(Debug, Args)]
pub struct RigCheckOptions {
    #[command(flatten)]
    pub rig: RigFileOptions,
    /// Duration, s
    #[arg(long, default_value_t = 3.0, allow_negative_numbers = true)]
    pub duration_s: f64,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

pub fn run(options: &RigCheckOptions) -> anyhow::Result<Outcome> {
    let interrupt = Interrupt::listen()?;
    let folder = tempfile::tempdir()?;
    let request = options.rig.torque_request(options.duration_s)?;
    let (archive, outcome) = rig_run::archive(request, folder.path(), false, "rig-check", &interrupt)?;
    let capture = load::load(&archive)?.capture;
    let axis = capture.axis;
    let mut found = RigCheck::of(&capture);
    found.doubts.extend(doubts(&RigFile::load(&options.rig.file)?)?);
    show(lines(&found, axis));
    write_json(axis, &options.json, &found)?;
    found.doubts.iter().chain(&found.amiss).for_each(|told| remark(axis.words(told)));
    Ok(if found.amiss.is_empty() { outcome } else { Outcome::Failed })
}

/// What in a rotary rig's file looks like another unit, in sentences: what is out of a range that a slip of three decimal places
/// leaves.
fn doubts(file: &RigFile) -> anyhow::Result<Vec<String>> {
    let inertia = file.calibration()?.map(|calibration| calibration.motor_inertia);
    let usual = [
        ("[limits] motor_torque_mnm", file.limits.map(|limits| limits.motor_torque_mnm), 5.0..=2e4, "mNm"),
        ("[limits] speed_rad_s", file.limits.map(|limits| limits.speed_rad_s), 1.0..=1e3, "rad/s"),
        ("[watchdog] timeout_s", file.watchdog.map(|watchdog| watchdog.timeout_s), 1e-3..=5.0, "s"),
        ("[calibration] motor_inertia", inertia, 2e-4..=5.0, "mNm·s²/rad (1 g·cm² is 0.0001)"),
    ];
    let odd = usual.into_iter().filter_map(|(key, value, usual, unit)| {
        let value = value.filter(|value| file.axis == Axis::Rotary && !usual.contains(value))?;
        Some(format!("{key} is {value}, which is unusual: is it in {unit}?"))
    });
    Ok(odd.collect())
}

fn lines(found: &RigCheck, axis: Axis) -> Vec<String> {
    let RigCheck { rig, rate_hz, samples, missed_ticks, stale_ticks, channels, .. } = found;
    let rows = channels.iter().map(|Reading { channel, unit, mean, span, noise_rms }| {
        [*channel, &format!("{mean:.6}"), &format!("{span:.3e}"), &format!("{noise_rms:.3e}"), unit].map(str::to_owned)
    });
    let table = table(["channel", "mean", "span", "noise RMS", "unit"], 1..4, rows).to_string();
    let mut lines = vec![format!("rig      {rig}"), axis.words(&table).into_owned()];
    lines.push(format!(
        "rate     {rate_hz} Hz: {samples} ticks read, {missed_ticks} missed, {stale_ticks} without new data"
    ));
    let read = found.read_after_us.zip(found.read_after_sd_us);
    lines.extend(read.map(|(mean, sd)| format!("read     {mean:.1} µs after the tick, ± {sd:.1} µs")));
    lines.extend(found.watchdog.iter().map(|watchdog| format!("watchdog {watchdog}")));
    lines
}
