//! The live fit against the fit of the whole capture on the simulated rig, and what it costs.
#![allow(clippy::print_stdout, reason = "an example speaks to its user")]

#[path = "../tests/all/common/mod.rs"]
mod common;

use common::{Capture, RATE_HZ, run};
use dynamics::{Drive, knobs};
use identification::fit;
use identification::live::{LiveFit, LiveSample};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for number in 1..=5 {
        let capture = run(&knobs::paper_knob(number)?, "linear-chirp", Drive::Position, None, 10.0, 1);
        let Capture { t_s, angle_rad, torque_mnm, .. } = &capture;
        let mut live = LiveFit::new(RATE_HZ, capture.calibration.as_ref());
        let (mut pushing, mut estimating, mut slowest) = (0.0, 0.0, 0.0_f64);
        for block in 0..1000 {
            let start = std::time::Instant::now();
            for index in block * 100..(block + 1) * 100 {
                live.push(&LiveSample {
                    time_s: t_s[index],
                    angle_rad: angle_rad[index],
                    torque_mnm: torque_mnm[index],
                });
            }
            pushing += start.elapsed().as_secs_f64();
            if block % 5 == 4 {
                let start = std::time::Instant::now();
                let _ = live.estimate();
                let elapsed = start.elapsed().as_secs_f64();
                estimating += elapsed;
                slowest = slowest.max(elapsed);
            }
            if [99, 199, 399].contains(&block) {
                let estimate = live.estimate();
                let told: Vec<_> = estimate.parameters.iter().map(|p| (p.name, p.value, p.verdict)).collect();
                println!("knob {number} after {} s: {told:?}", (block + 1) / 100);
            }
        }
        println!(
            "knob {number}: per 10 ms of samples {:.1} µs pushing, {:.1} µs estimating at 20 Hz, slowest estimate {:.2} ms",
            1e3 * pushing,
            1e3 * estimating,
            1e3 * slowest
        );
        let estimate = live.estimate();
        let whole = fit(&capture.samples(), &capture.options())?;
        println!("  residual {:?} against {:.4}", estimate.residual_rms_mnm, whole.residual_rms_mnm);
        for live in &estimate.parameters {
            let whole = whole.parameters.get(live.name);
            println!(
                "  {:18} {:?} ± {:?} {:?}; whole {:?} ± {:?}",
                live.name,
                live.value,
                live.ci95.map(|[low, high]| 0.5 * (high - low)),
                live.verdict,
                whole.and_then(|p| p.value),
                whole.and_then(|p| p.ci95).map(|[low, high]| 0.5 * (high - low))
            );
        }
    }
    Ok(())
}
