//! Times the whole fit; `scripts/bench-fit` compares with scipy on the columns written here.
//!
//! `cargo run --release -p identification --example bench_fit -- COLUMNS [MOST_SAMPLES]`
#![allow(clippy::print_stdout, reason = "an example speaks to its user")]

#[path = "../tests/all/common/mod.rs"]
mod common;

use std::time::{Duration, Instant};

use common::{TABLE_2, Uniform, knob, sweep};
use dynamics::Motion;
use identification::{FitOptions, Samples, fit};
use nix::time::ClockId;

const RATE_HZ: f64 = 5000.0;
/// Fits of the capture that scipy fits too.
const RUNS: u32 = 41;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("name the file to which the columns shall be written")?;
    let most: usize = arguments.next().map_or(Ok(10_000_000), |text| text.parse())?;
    let columns = capture(30_000);
    let bytes: Vec<u8> = columns.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    std::fs::write(path, bytes)?;
    let before = processor_seconds();
    let (times, period_rad) = timed(&columns, RUNS)?;
    let processor = (processor_seconds() - before) / f64::from(RUNS);
    println!(
        "{{\"samples\": 30000, \"all_seconds\": {times:?}, \"processor_seconds\": {processor}, \"period_rad\": {period_rad}}}"
    );
    let mut samples = 10_000;
    while samples <= most {
        let columns = capture(samples);
        let runs = if samples < 1_000_000 { 15 } else { 1 };
        let before = processor_seconds();
        let (times, _) = timed(&columns, runs)?;
        let processor = (processor_seconds() - before) / f64::from(runs);
        let seconds = times[times.len() / 2];
        println!(
            "{{\"samples\": {samples}, \"seconds\": {seconds}, \"processor_seconds\": {processor}, \"peak_kib\": {}}}",
            peak_kib()
        );
        samples *= 10;
    }
    Ok(())
}

/// Time, angle, velocity, acceleration and noisy torque.
fn capture(samples: usize) -> [Vec<f64>; 5] {
    let knob = knob(&TABLE_2);
    let paper = sweep("paper");
    let mut random = Uniform(7);
    let mut columns: [Vec<f64>; 5] = std::array::from_fn(|_| Vec::with_capacity(samples));
    for index in 1..=samples {
        let time_s = index as f64 / RATE_HZ;
        // The frequency of a sweep would grow with the number of samples.
        let motion = if samples == 30_000 { paper(time_s) } else { two_sines(time_s) };
        let torque_mnm = knob.torque_mnm(&motion) + 4.0 * (random.next() - 0.5);
        let row = [motion.time_s, motion.angle_rad, motion.velocity_rad_s, motion.acceleration_rad_s2, torque_mnm];
        columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
    }
    columns
}

fn two_sines(time_s: f64) -> Motion {
    let sines = [(1.0, 3.0), (0.4, 8.1)];
    let sum = |of: fn(f64, f64, f64) -> f64| sines.iter().map(|(size, rate)| of(*size, *rate, time_s)).sum();
    Motion {
        time_s,
        angle_rad: sum(|size, rate, t| size * (rate * t).sin()),
        velocity_rad_s: sum(|size, rate, t| size * rate * (rate * t).cos()),
        acceleration_rad_s2: sum(|size, rate, t| -size * rate * rate * (rate * t).sin()),
    }
}

/// Times of fits, s, in order, and the period they found.
fn timed(columns: &[Vec<f64>; 5], runs: u32) -> Result<(Vec<f64>, f64), Box<dyn std::error::Error>> {
    let [t_s, angle_rad, velocity, acceleration, torque_mnm] = columns;
    let samples =
        Samples { t_s, angle_rad, velocity_rad_s: Some(velocity), acceleration_rad_s2: Some(acceleration), torque_mnm };
    let mut times = Vec::new();
    let mut period_rad = f64::NAN;
    for _ in 0..runs {
        let start = Instant::now();
        let fit = fit(&samples, &FitOptions::default())?;
        times.push(start.elapsed().as_secs_f64());
        period_rad = fit.parameters.get("detent_period").and_then(|p| p.value).unwrap_or(f64::NAN);
    }
    times.sort_by(f64::total_cmp);
    Ok((times, period_rad))
}

/// Time that processors have spent on this process, s; 0 where the system does not tell.
fn processor_seconds() -> f64 {
    ClockId::CLOCK_PROCESS_CPUTIME_ID.now().map_or(0.0, |time| Duration::from(time).as_secs_f64())
}

/// Most memory that this process ever held, KiB; 0 where the system does not tell.
fn peak_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|rest| rest.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
