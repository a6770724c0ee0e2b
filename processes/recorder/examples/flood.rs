//! Stands in for the control loop and publishes samples at any rate, to find out what a recorder keeps up with.
//!
//! Blocks go out full, evenly in time, through the same service with the same queue as the control loop's. Prints how
//! many samples a second were really sent, on average from the first to the last.

#![allow(clippy::print_stdout, reason = "a measurement prints its figures")]

use std::time::Duration;

use anyhow::anyhow;
use clap::Parser;
use iceoryx2::port::update_connections::UpdateConnections as _;
use shared_types::rig::{monotonic_time_ns, wall_clock_time_ns};
use shared_types::services::{self, LOOP_STATUS, SAMPLES_PER_BLOCK};
use shared_types::{ClockMapping, LoopState, LoopStatus, RunDescription, Sample};
use synthetic::sample;

#[path = "../../../archive/examples/synthetic/sample.rs"]
mod synthetic;

const RUN_ID: u64 = 0xf10d;
/// Samples made before anything is sent; they are sent again and again with new numbers and times.
const PREPARED: usize = 1 << 16;
/// Time for consumers to attach, s.
const SETTLING_S: f64 = 1.0;

/// Publishes samples at a given rate.
#[derive(Parser)]
struct Options {
    /// Samples per second.
    #[arg(long)]
    rate_hz: f64,
    /// Length, s.
    #[arg(long)]
    duration_s: f64,
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse();
    let mut random = 88_172_645_463_325_252;
    let mut prepared: Vec<Sample> = (0..PREPARED as u64).map(|seq| sample(seq, &mut random)).collect();
    let node = services::attach("flood")?;
    let samples = services::sample_publisher(&node)?;
    let status = LOOP_STATUS.publisher(&node)?;
    let description = services::RUN_DESCRIPTION.publisher(&node)?;
    let run = RunDescription {
        run_id: RUN_ID,
        rate_hz: options.rate_hz,
        clock: ClockMapping { monotonic_time_ns: monotonic_time_ns(), wall_clock_time_ns: wall_clock_time_ns() },
        ..blank_description()
    };
    let json = serde_json::to_vec(&run)?;
    let place = description.loan_slice_uninit(json.len()).map_err(|error| anyhow!("{error:?}"))?;
    place.write_from_slice(&json).send().map_err(|error| anyhow!("{error:?}"))?;
    let tell = |state: LoopState, published: u64, finished: u32| {
        let _ = description.update_connections();
        let _ = samples.update_connections();
        let message = LoopStatus {
            run_id: RUN_ID,
            monotonic_time_ns: monotonic_time_ns(),
            published_samples: published,
            rate_hz: options.rate_hz,
            state: state.code(),
            process_id: std::process::id(),
            finished,
            ..LoopStatus::default()
        };
        status.send_copy(message).map(drop).map_err(|error| anyhow!("{error:?}"))
    };
    let settled_ns = monotonic_time_ns() + (SETTLING_S * 1e9) as u64;
    while monotonic_time_ns() < settled_ns {
        tell(LoopState::Armed, 0, 0)?;
        std::thread::sleep(Duration::from_millis(50));
    }

    let started_ns = monotonic_time_ns();
    let mut published = 0_u64;
    let mut next_status_ns = started_ns;
    let last = (options.rate_hz * options.duration_s) as u64;
    while published < last {
        let now_ns = monotonic_time_ns();
        if now_ns >= next_status_ns {
            tell(LoopState::Running, published, 0)?;
            next_status_ns = now_ns + 100_000_000;
        }
        let due = ((now_ns - started_ns) as f64 * 1e-9 * options.rate_hz) as u64;
        while published + SAMPLES_PER_BLOCK as u64 <= due.min(last + SAMPLES_PER_BLOCK as u64) {
            let at = usize::try_from(published)? % PREPARED;
            let block = &mut prepared[at..at + SAMPLES_PER_BLOCK];
            for (sample, seq) in block.iter_mut().zip(published..) {
                (sample.seq, sample.tick, sample.monotonic_time_ns) = (seq, seq, monotonic_time_ns());
            }
            let mut place = samples.loan_slice_uninit(block.len()).map_err(|error| anyhow!("{error:?}"))?;
            place.user_header_mut().run_id = RUN_ID;
            place.write_from_slice(block).send().map_err(|error| anyhow!("{error:?}"))?;
            published += SAMPLES_PER_BLOCK as u64;
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    println!("{:.0}", published as f64 / ((monotonic_time_ns() - started_ns) as f64 * 1e-9));
    // Until the recorder has heard of the end and gone.
    for _ in 0..30 {
        tell(LoopState::Idle, published, 1)?;
        std::thread::sleep(Duration::from_millis(100));
    }
    Ok(())
}

fn blank_description() -> RunDescription {
    RunDescription {
        software_version: env!("CARGO_PKG_VERSION").to_owned(),
        apparatus: "none".to_owned(),
        knob: "none".to_owned(),
        ..RunDescription::default()
    }
}
