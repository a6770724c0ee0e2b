//! `rig-test`: compares what the rig measures with what it was commanded to do, as in the paper's Table 3.
//!
//! Three runs: the gripper alone through the paper's sweep for position, velocity and acceleration; the
//! locked gripper under a torque sweep; and both once more at 30 Hz, where the paper speaks of a lag.

use std::io::IsTerminal as _;

use anyhow::Context as _;
use clap::Args;
use comfy_table::Table;
use dynamics::Axis;
use report::{ChannelDifference, ChannelLag};
use rt_loop::request::{Pace, RunRequest};

use crate::command_line::RigOptions;
use crate::command_line::outputs::ResultFiles;
use crate::outcome::{Outcome, say};
use crate::supervision::Interrupt;
use crate::terminal::table;
use crate::{load, rig_run};

#[derive(Debug, Args)]
pub struct RigTestOptions {
    /// Interpretation of the paper's sweep: paper (as printed) or linear-chirp
    #[arg(long, default_value = "paper")]
    pub sweep: String,
    /// Samples per second
    #[arg(long, default_value_t = 5_000.0, allow_negative_numbers = true)]
    pub rate_hz: f64,
    #[command(flatten)]
    pub results: ResultFiles,
    #[command(flatten)]
    pub rig: RigOptions,
}

/// Length of the paper's sweep: 30,000 samples at 5 kHz, s.
const SWEEP_S: f64 = 6.0;
/// Length of the run at one frequency, s.
const TONE_S: f64 = 3.0;

pub fn run(options: &RigTestOptions) -> anyhow::Result<Outcome> {
    let of = |on_it: &str, sweep: &str, duration_s| {
        let pace = Pace { rate_hz: options.rate_hz, core: None };
        rig_run::request(on_it, sweep, duration_s, pace, options.rig.request.clone())
    };
    let free = |sweep: &str, duration_s| of("none", sweep, duration_s);
    let locked = |sweep: &str, duration_s| RunRequest { torque: true, ..of("locked", sweep, duration_s) };
    let interrupt = Interrupt::listen()?;
    let mut outcome = Outcome::Done;
    let mut made = |request, purpose| -> anyhow::Result<analysis::Commanded> {
        let RigOptions { captures_in, offline, .. } = &options.rig;
        let (archive, whole) = rig_run::archive(request, captures_in, *offline, purpose, &interrupt)?;
        outcome = outcome.worse(whole);
        let loaded = load::load(&archive)?;
        let description = loaded.capture.description.as_ref().context("the run has no description")?;
        let excitation = description.excitation()?;
        Ok((loaded, excitation))
    };
    let sweep = options.sweep.as_str();
    let spun = [made(free(sweep, SWEEP_S), "rig-test-free")?, made(free("tone", TONE_S), "rig-test-free-30-hz")?];
    wait_until_locked(&options.rig)?;
    let held =
        [made(locked(sweep, SWEEP_S), "rig-test-locked")?, made(locked("tone", TONE_S), "rig-test-locked-30-hz")?];

    let test = analysis::rig_test(sweep, options.rate_hz, &spun, &held);
    let scaled = if test.axis.is_rotary() { "" } else { "; the paper's rig 20 mm from its axis" };
    let lines = [
        String::new(),
        format!("original minus measured; filtered: its SD after the paper's low-pass filters{scaled}"),
        differences(&test.differences).to_string(),
        String::new(),
        lags(&test.lag_at_30_hz).to_string(),
    ];
    // The channels' names and units are those of the axis already.
    options.results.tell(Axis::default(), lines, &test, || report::rig_test_page(&test))?;
    Ok(outcome)
}

/// Asks for the gripper to be locked, and waits for it where somebody can answer; the simulated rig locks its own.
fn wait_until_locked(rig: &RigOptions) -> anyhow::Result<()> {
    if rt_loop::rigs::file(&rig.request)?.driver == "simulated" {
        return Ok(());
    }
    say("lock the gripper so that it cannot turn, then press Enter");
    let input = std::io::stdin();
    if input.is_terminal() {
        input.read_line(&mut String::new()).context("the terminal cannot be read")?;
    }
    Ok(())
}

fn differences(differences: &[ChannelDifference]) -> Table {
    let rows = differences.iter().map(|row| {
        let [mean, sd, filtered] = [row.mean, row.sd, row.sd_filtered].map(|own| format!("{own:.5}"));
        let [paper_mean, paper_sd] = [row.paper_mean, row.paper_sd].map(|printed| format!("{printed:.4}"));
        [row.channel.to_owned(), mean, sd, filtered, paper_mean, paper_sd, row.unit.to_owned()]
    });
    table(["channel", "mean", "SD", "filtered", "paper's mean", "paper's SD", "unit"], 1..6, rows)
}

fn lags(lags: &[ChannelLag]) -> Table {
    let rows = lags.iter().map(|lag| {
        [
            lag.channel.to_owned(),
            format!("{:.4}", lag.phase_rad),
            format!("{:.3}", lag.delay_ms),
            format!("{:.4}", lag.gain),
            format!("< {} rad", lag.paper_phase_rad_below),
        ]
    });
    table(["lag at 30 Hz", "rad", "ms", "gain", "paper"], 1..5, rows)
}
