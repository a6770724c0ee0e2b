//! `recompute`: the torques of a replay computed again from what its archive recorded, bit for bit.

use std::path::PathBuf;

use anyhow::Context as _;
use archive::Capture;
use clap::Args;
use hal::Measurement;
use rt_loop::recomputation::{Recomputation, RecordedTick};
use serde::Serialize;
use shared_types::{LoopState, ModelChange, RunDescription, Sample};

use crate::command_line::outputs::{show_on, write_json};
use crate::outcome::{Outcome, remark};

#[derive(Debug, Args)]
pub struct RecomputeOptions {
    /// The archive of a replay
    #[arg(value_name = "CAPTURE")]
    pub capture: PathBuf,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

#[derive(Debug, Default, Serialize)]
pub struct Recomputed {
    pub capture: PathBuf,
    pub ticks: usize,
    pub models: usize,
    /// Whether every torque command is equal, bit for bit.
    pub equal: bool,
    /// The first tick at which the torque commands differ.
    pub first_difference: Option<Difference>,
    pub different_ticks: usize,
    pub largest_difference_mnm: f64,
    /// Number of the first sample missing from the archive; nothing after it can be computed.
    pub missing_from_sample: Option<u64>,
}

/// A tick whose computed torque command differs from the recorded one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    pub tick: u64,
    /// Its time in the run, s.
    pub t_s: f64,
    pub recorded_mnm: f64,
    pub computed_mnm: f64,
}

/// Computes a replay again and says whether all torque commands are equal; failed where they are not.
pub fn run(options: &RecomputeOptions) -> anyhow::Result<Outcome> {
    let capture = Capture::load(&options.capture)?;
    let table = "the capture is a table; give its archive: only the archive of a replay holds what is needed";
    let description = capture.description.as_ref().context(table)?;
    let version = &description.software_version;
    if version != env!("CARGO_PKG_VERSION") {
        remark(format!("the replay was made by version {version}, which may compute differently"));
    }
    let recomputed = recompute(&capture, description)?;
    show_on(capture.axis, lines(&recomputed, description.rate_hz));
    write_json(capture.axis, &options.json, &recomputed)?;
    Ok(match (recomputed.equal, recomputed.missing_from_sample) {
        (false, _) => Outcome::Failed,
        (true, Some(_)) => Outcome::DataLost,
        (true, None) => Outcome::Done,
    })
}

/// Feeds what was recorded through the control step.
fn recompute(capture: &Capture, run: &RunDescription) -> anyhow::Result<Recomputed> {
    let lacks = |column: &str| {
        let column = capture.axis.words(column);
        format!("the archive's samples have no {column}, which the control step needs; record the replay again")
    };
    let commanded_mnm = capture.commanded_torque_mnm.as_ref().with_context(|| lacks("commanded_torque_mnm"))?;
    let acceleration = capture.acceleration_rad_s2.as_ref();
    let missed_ticks = capture.missed_ticks.as_ref().with_context(|| lacks("missed_ticks"))?;
    let flags = capture.flags.as_ref().with_context(|| lacks("flags"))?;
    let state = capture.state.as_ref().with_context(|| lacks("state"))?;
    let mut step = Recomputation::new(run)?;
    let mut result = Recomputed { capture: capture.source.clone(), models: 1, equal: true, ..Recomputed::default() };
    let model_of = |tick: u64| capture.models.iter().find(|model| model.tick == tick && tick > 0);
    let take_model = |step: &mut Recomputation, change: &ModelChange| {
        anyhow::ensure!(step.take_model(change)?, "the model of tick {} came while another was waiting", change.tick);
        Ok(())
    };
    let mut next_sample = 0;
    'samples: for row in 0..capture.len() {
        let tick = capture.tick[row];
        // Samples without a measurement are not among a capture's rows, but the control step had them.
        for sample in std::mem::replace(&mut next_sample, capture.seq[row] + 1)..capture.seq[row] {
            if capture.gaps.iter().any(|gap| (gap.first_missing_seq..=gap.last_missing_seq).contains(&sample)) {
                result.missing_from_sample = Some(sample);
                break 'samples;
            }
            let place = capture.unmeasured.binary_search_by_key(&sample, |one| one.seq).ok();
            let absent = || format!("the archive has no sample {sample}, and does not say that it was lost");
            let one = &capture.unmeasured[place.with_context(absent)?];
            if let Some(change) = model_of(one.tick) {
                take_model(&mut step, change)?;
                result.models += 1;
            }
            let measurement = Measurement {
                angle_rad: one.angle_rad,
                acceleration_rad_s2: acceleration.map(|_| one.acceleration_rad_s2),
                torque_mnm: one.torque_mnm,
                after_s: one.measured_after_s,
                ..Measurement::stale(one.device_code.cast_signed())
            };
            step.step(&RecordedTick { measurement, missed_ticks: one.missed_ticks });
        }
        if flags[row] & Sample::MODEL_TAKEN != 0 {
            let change = model_of(tick).with_context(|| {
                format!("a model is rendered from tick {tick} on, but the archive does not have it")
            })?;
            take_model(&mut step, change)?;
            result.models += 1;
        }
        let measurement = Measurement {
            angle_rad: capture.angle_rad[row],
            acceleration_rad_s2: acceleration.map(|column| column[row]),
            torque_mnm: capture.torque_mnm[row],
            after_s: capture.measured_after_s.as_ref().map_or(0.0, |column| column[row]),
            ..Measurement::default()
        };
        // A run that ends in a fault goes torque-free with its last sample, whatever the limit was.
        let at_fault = state[row] == LoopState::Fault.code();
        let output = step.step(&RecordedTick { measurement, missed_ticks: missed_ticks[row] });
        let computed_mnm = if at_fault { 0.0 } else { output.torque_mnm };
        let computed_tick = output.sample.map_or(tick, |sample| sample.tick);
        result.ticks += 1;
        if computed_mnm.to_bits() != commanded_mnm[row].to_bits() || computed_tick != tick {
            let recorded_mnm = commanded_mnm[row];
            result.equal = false;
            result.different_ticks += 1;
            result.largest_difference_mnm = result.largest_difference_mnm.max((recorded_mnm - computed_mnm).abs());
            let t_s = capture.t_s[row];
            result.first_difference.get_or_insert(Difference { tick, t_s, recorded_mnm, computed_mnm });
        }
    }
    Ok(result)
}

fn lines(result: &Recomputed, rate_hz: f64) -> Vec<String> {
    let Recomputed { ticks, models, different_ticks, largest_difference_mnm, .. } = result;
    let noun = if *models == 1 { "model" } else { "models" };
    let mut lines = vec![format!("recomputed {ticks} ticks at {rate_hz} Hz of {models} {noun}")];
    if let Some(missing) = result.missing_from_sample {
        lines.push(format!("missing  sample {missing} is not in the archive: nothing can be computed after it"));
    }
    lines.push(match result.first_difference {
        None => "equal    every torque command, bit for bit".to_owned(),
        Some(Difference { tick, t_s, recorded_mnm, computed_mnm }) => format!(
            "differs  from tick {tick} ({t_s} s) on: {recorded_mnm} mNm recorded, {computed_mnm} mNm computed; \
             {different_ticks} ticks, by at most {largest_difference_mnm:.3e} mNm"
        ),
    });
    lines
}
