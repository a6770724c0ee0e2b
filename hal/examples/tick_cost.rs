//! What a tick of the simulated rig costs: time of read and write together, and the speed of an offline run.
//!
//! `cargo run --release -p hal --example tick_cost`
#![allow(clippy::print_stdout, reason = "the figures are what the example is for")]

use std::time::Instant;

use dynamics::{Drive, Excitation, knobs};
use hal::Apparatus;
use hal::simulated_rig::{RigParameters, SimulatedRig};

const OFFLINE_S: u64 = 10;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("knob  rate     median    p99.9      max     10 s offline");
    let sweep = Excitation::named("linear-chirp", Drive::Position)?;
    for number in 1..=5 {
        for rate_hz in [5_000_u64, 10_000, 20_000] {
            let mut rig = SimulatedRig::new(RigParameters::default(), knobs::paper_knob(number)?, 1)?;
            rig.enable()?;
            let period_ns = 1_000_000_000 / rate_hz;
            let mut durations_ns = Vec::with_capacity(usize::try_from(OFFLINE_S * rate_hz)?);
            let (mut torque_mnm, mut previous_rad) = (0.0, 0.0);
            let begin = Instant::now();
            for tick in 0..OFFLINE_S * rate_hz {
                let start = Instant::now();
                let measurement = rig.read(tick * period_ns)?;
                rig.write_torque(torque_mnm)?;
                durations_ns.push(start.elapsed().as_nanos());
                let (time_s, rate) = (tick as f64 / rate_hz as f64, rate_hz as f64);
                let wanted = sweep.at(time_s);
                let velocity_rad_s = (measurement.angle_rad - previous_rad) * rate;
                previous_rad = measurement.angle_rad;
                torque_mnm = 3000.0 * (wanted.value - measurement.angle_rad) + 15.0 * (wanted.rate - velocity_rad_s);
            }
            let run_s = begin.elapsed().as_secs_f64();
            durations_ns.sort_unstable();
            let at = |thousandths: usize| durations_ns[(durations_ns.len() - 1) * thousandths / 1000];
            let factor = OFFLINE_S as f64 / run_s;
            println!(
                "{number:>4}  {rate_hz:>5} Hz  {:>5} ns  {:>5} ns  {:>7} ns  {factor:>5.0} x real time",
                at(500),
                at(999),
                at(1000)
            );
        }
    }
    Ok(())
}
