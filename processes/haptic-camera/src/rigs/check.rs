//! `rig check`: a rig brought up without torque, and what its channels read meanwhile.

use std::path::PathBuf;

use archive::Capture;
use clap::Args;
use dynamics::Axis;
use hal::RigFile;
use serde::Serialize;

use super::{span, torque_request};
use crate::command_line::RigOptions;
use crate::outcome::{Outcome, remark, show};
use crate::outputs::write_json;
use crate::supervision::listen_for_interrupt;
use crate::terminal::table;
use crate::{load, rig_run};

#[derive(Debug, Args)]
pub struct RigCheckOptions {
    /// The rig's file
    #[arg(value_name = "FILE.toml")]
    pub file: PathBuf,
    /// Samples per second [default: the fastest that the file permits]
    #[arg(long, allow_negative_numbers = true)]
    pub rate_hz: Option<f64>,
    /// Duration, s
    #[arg(long, default_value_t = 3.0, allow_negative_numbers = true)]
    pub duration_s: f64,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// Share of the ticks that may be missed or stale before the rate counts as not held.
const MISSED_SHARE: f64 = 0.01;

/// Share of a period from which on the exchange with the rig is what misses ticks.
const SLOW_SHARE: f64 = 0.5;

/// What a channel read while nothing moved it.
#[derive(Clone, Debug, Serialize)]
struct Reading {
    channel: &'static str,
    unit: &'static str,
    mean: f64,
    /// From its least to its most.
    span: f64,
    /// RMS of the noise of one reading, from the differences of neighbours.
    noise_rms: f64,
}

#[derive(Clone, Debug, Serialize)]
struct Checked {
    rig: String,
    rate_hz: f64,
    samples: u64,
    missed_ticks: u64,
    stale_ticks: u64,
    /// Mean time from when a tick was due to when the encoder was read, µs; `None` where every tick was read when it was due.
    read_after_us: Option<f64>,
    /// Standard deviation of the same, µs.
    read_after_sd_us: Option<f64>,
    /// Time of the amplifier's watchdog as it was read back; `None` where the rig does not say.
    watchdog: Option<String>,
    channels: Vec<Reading>,
    /// What in its file looks like another unit, or is counted twice, in sentences.
    doubts: Vec<String>,
    amiss: Vec<String>,
}

pub fn run(options: &RigCheckOptions) -> anyhow::Result<Outcome> {
    let interrupted = listen_for_interrupt()?;
    let folder = tempfile::tempdir()?;
    let request = torque_request(&options.file, options.rate_hz, options.duration_s)?;
    let rig = RigOptions { request: request.rig.clone(), offline: false, captures_in: folder.path().to_owned() };
    let (archive, _) = rig_run::archive(request, &rig, "rig-check", &interrupted)?;
    let capture = load::load(&archive)?.capture;
    let axis = capture.axis;
    let mut found = check(&capture);
    found.doubts.extend(doubts(&RigFile::load(&options.file)?)?);
    show(lines(&found, axis));
    write_json(axis, &options.json, &found)?;
    found.doubts.iter().chain(&found.amiss).for_each(|told| remark(axis.words(told)));
    Ok(if found.amiss.is_empty() { Outcome::Done } else { Outcome::Failed })
}

fn check(capture: &Capture) -> Checked {
    let run = capture.description.as_ref();
    let angle = reading("angle", "rad", &capture.angle_rad);
    let torque = reading("torque", "mNm", &capture.torque_mnm);
    let acceleration = capture.acceleration_rad_s2.as_ref().map(|column| reading("acceleration", "rad/s²", column));
    let contact = capture.contact.as_ref().map(|column| reading("contact", "1 if closed", column));
    let after_us = |after_s: &Vec<f64>| (1e6 * mean(after_s), 1e6 * deviation(after_s));
    let (read_after_us, read_after_sd_us) = capture.measured_after_s.as_ref().map(after_us).unzip();
    let missed_ticks = capture.ticks_without_sample().saturating_sub(capture.unmeasured_samples);
    let ticks = capture.len() as f64 + capture.unmeasured_samples as f64 + missed_ticks as f64;
    let mut amiss = Vec::new();
    if torque.span == 0.0 {
        amiss.push("the torque is constant; check its source, and the sensor's cable and supply".to_owned());
    }
    if acceleration.as_ref().is_some_and(|channel| channel.span == 0.0) {
        amiss.push("the acceleration is constant; check it, or omit [channels.acceleration]".to_owned());
    }
    if missed_ticks as f64 > MISSED_SHARE * ticks {
        let (exchange_ms, period_ms) = (1e3 * capture.rig.mean_exchange_s, 1e3 / capture.rate_hz);
        let cause = if exchange_ms > SLOW_SHARE * period_ms {
            format!(
                "an exchange with the rig takes {exchange_ms:.2} ms of a period of {period_ms:.2} ms: its driver or library \
                 waits; have it return at once, or"
            )
        } else {
            "this machine cannot hold the rate;".to_owned()
        };
        amiss.push(format!("{missed_ticks} of {ticks} ticks were missed: {cause} try a lower --rate-hz"));
    }
    if capture.unmeasured_samples as f64 > MISSED_SHARE * ticks {
        let stale = capture.unmeasured_samples;
        amiss.push(format!(
            "{stale} of {ticks} ticks had no new data: the device is slower than the rate; lower [rates] fastest_hz"
        ));
    }
    let notes = run.map(|run| run.notes.as_slice()).unwrap_or_default();
    let note = |name: &str| notes.iter().find(|(known, _)| known == name).map(|(_, value)| value.clone());
    let watchdog = note("watchdog");
    if watchdog.is_none() {
        amiss.push(
            "the rig does not read back its watchdog: make sure that killing the program removes the torque".to_owned(),
        );
    }
    Checked {
        rig: run.map(|run| run.apparatus.clone()).unwrap_or_default(),
        rate_hz: capture.rate_hz,
        samples: capture.len() as u64,
        missed_ticks,
        stale_ticks: capture.unmeasured_samples,
        read_after_us,
        read_after_sd_us,
        watchdog,
        doubts: note("delay").into_iter().collect(),
        channels: [angle, torque].into_iter().chain(acceleration).chain(contact).collect(),
        amiss,
    }
}

/// Numbers of a rig that turns a knob which a slip of three places would make of usual ones: table and key, what is usual, and the unit.
static USUAL: [(&str, &str, std::ops::RangeInclusive<f64>, &str); 4] = [
    ("limits", "motor_torque_mnm", 5.0..=2e4, "mNm"),
    ("limits", "speed_rad_s", 1.0..=1e3, "rad/s"),
    ("watchdog", "timeout_s", 1e-3..=5.0, "s"),
    ("calibration", "motor_inertia", 2e-4..=5.0, "mNm·s²/rad (1 g·cm² is 0.0001)"),
];

/// What in a rig's file looks like another unit, in sentences.
fn doubts(file: &RigFile) -> anyhow::Result<Vec<String>> {
    let values = [
        file.limits.map(|limits| limits.motor_torque_mnm),
        file.limits.map(|limits| limits.speed_rad_s),
        file.watchdog.map(|watchdog| watchdog.timeout_s),
        file.calibration()?.map(|calibration| calibration.motor_inertia),
    ];
    let odd = USUAL.iter().zip(values).filter_map(|((table, key, usual, unit), value)| {
        let value = value.filter(|value| file.axis == Axis::Rotary && !usual.contains(value))?;
        Some(format!("[{table}] {key} is {value}, which is unusual: is it in {unit}?"))
    });
    Ok(odd.collect())
}

fn reading(channel: &'static str, unit: &'static str, values: &[f64]) -> Reading {
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // The difference of two readings has the noise of both.
    let noise_rms = deviation(&steps) / std::f64::consts::SQRT_2;
    Reading { channel, unit, mean: mean(values), span: span(values.iter().copied()), noise_rms }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn deviation(values: &[f64]) -> f64 {
    let mean = mean(values);
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn lines(found: &Checked, axis: Axis) -> Vec<String> {
    let Checked { rig, rate_hz, samples, missed_ticks, stale_ticks, channels, .. } = found;
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
