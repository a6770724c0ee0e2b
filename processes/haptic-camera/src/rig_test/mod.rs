//! `rig-test`: compares what the rig measures with what it was commanded to do, as in the paper's Table 3.
//!
//! Three runs: the gripper alone through the paper's sweep for position, velocity and acceleration; the
//! locked gripper under a torque sweep; and both once more at 30 Hz, where the paper speaks of a lag.

mod channel;
mod table;

use dynamics::Excitation;
use loaded_capture::LoadedCapture;
use report::{CaptureFacts, RigTest};
use rt_loop::request::{Pace, RunRequest};

use anyhow::Context as _;

use crate::command_line::RigTestOptions;
use crate::load;
use crate::outcome::{Outcome, say};
use crate::outputs::{Kind, to_output, write, write_json};
use crate::rig_run;
use crate::supervision::listen_for_interrupt;
use channel::{Channel, LAG_HZ};

/// Length of the paper's sweep: 30,000 samples at 5 kHz, s.
const SWEEP_S: f64 = 6.0;
/// Length of the run at one frequency, s.
const TONE_S: f64 = 3.0;

/// Turns the rig and compares.
///
/// # Errors
/// Whatever keeps the rig from being turned, and a file that cannot be written.
pub fn run(options: &RigTestOptions) -> anyhow::Result<Outcome> {
    let free = |sweep: &str, duration_s| RunRequest {
        knob: Some("none".to_owned()),
        sweep: sweep.to_owned(),
        duration_s,
        pace: Pace { rate_hz: options.rate_hz, core: None },
        rig: options.rig.request.clone(),
        ..RunRequest::default()
    };
    let locked = |sweep: &str, duration_s| RunRequest {
        knob: Some("locked".to_owned()),
        torque: true,
        ..free(sweep, duration_s)
    };
    let interrupted = listen_for_interrupt()?;
    let mut outcome = Outcome::Done;
    let mut made = |request, purpose| {
        let (archive, whole) = rig_run::archive(request, &options.rig, purpose, &interrupted)?;
        outcome = outcome.worse(whole);
        load::load(&archive)
    };
    let sweep = options.sweep.as_str();
    let spun = [made(free(sweep, SWEEP_S), "rig-test-free")?, made(free("tone", TONE_S), "rig-test-free-30-hz")?];
    let held =
        [made(locked(sweep, SWEEP_S), "rig-test-locked")?, made(locked("tone", TONE_S), "rig-test-locked-30-hz")?];

    let axis = spun[0].capture.axis;
    let mut test = RigTest {
        axis,
        sweep: sweep.to_owned(),
        rate_hz: options.rate_hz,
        differences: Vec::new(),
        lag_at_30_hz: Vec::new(),
        lag_hz: LAG_HZ,
        filter_edges_hz: Channel::ALL.map(Channel::filter_edge_hz).to_vec(),
        captures: vec![
            facts("free gripper, sweep", &spun[0]),
            facts("free gripper, one frequency", &spun[1]),
            facts("locked gripper, sweep", &held[0]),
            facts("locked gripper, one frequency", &held[1]),
        ],
        traces: Vec::new(),
    };
    for channel in Channel::ALL {
        let [sweep, tone] = if channel == Channel::Torque { &held } else { &spun };
        let (commanded, commanded_tone) = (excitation(sweep)?, excitation(tone)?);
        test.differences.push(channel.compare(sweep, &commanded));
        test.lag_at_30_hz.push(channel.lag(tone, &commanded_tone));
        test.traces.push(channel.trace((sweep, &commanded), (tone, &commanded_tone)));
    }
    if !to_output(options.json.as_deref()) {
        say("");
        let scaled = if axis.is_rotary() { "" } else { "; the paper's rig 20 mm from its axis" };
        say(format!("original minus measured; filtered: its SD after the paper's low-pass filters{scaled}"));
        say(table::differences(&test.differences));
        say("");
        say(table::lags(&test.lag_at_30_hz));
    }
    write_json(options.json.as_deref(), &test)?;
    if let Some(path) = &options.report {
        write(path, Kind::Page, &report::rig_test_page(&test))?;
    }
    Ok(outcome)
}

/// A run of the rig under the name `title`.
fn facts(title: &str, loaded: &LoadedCapture) -> CaptureFacts {
    CaptureFacts { title: title.to_owned(), ..analysis::facts(loaded) }
}

/// The rig's command.
fn excitation(loaded: &LoadedCapture) -> anyhow::Result<Excitation> {
    let description = loaded.capture.description.as_ref().context("the run has no description")?;
    Ok(description.excitation()?)
}
