//! The live fit against the fit of the whole capture on the simulated rig, and what it costs.
#![allow(clippy::print_stdout, reason = "an example speaks to its user")]

use dynamics::{Drive, Excitation, knobs};
use hal::Apparatus;
use hal::simulated::{RigParameters, SimulatedRig};
use identification::live::{LiveFit, LiveSample};
use identification::{FitOptions, Samples, fit};

const RATE_HZ: f64 = 10_000.0;

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "nanoseconds of a few seconds")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    for number in 1..=5 {
        let mut rig = SimulatedRig::new(RigParameters::default(), knobs::paper_knob(number)?, 1)?;
        let calibration = rig.description().calibration.clone();
        let sweep = Excitation::named("linear-chirp", Drive::Position)?;
        rig.enable()?;
        let inertia = calibration.motor_inertia + calibration.gripper_inertia;
        let (mut previous, mut velocity) = (0.0, 0.0);
        let (mut t_s, mut angle, mut torque, mut acceleration) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for tick in 0..100_000_u32 {
            let time_s = f64::from(tick) / RATE_HZ;
            let measured = rig.read((time_s * 1e9).round() as u64)?;
            let set = sweep.at(time_s);
            velocity += 0.3 * ((measured.angle_rad - previous) * RATE_HZ - velocity);
            previous = measured.angle_rad;
            rig.write_torque(
                inertia * set.acceleration + 3000.0 * (set.value - measured.angle_rad) + 20.0 * (set.rate - velocity),
            )?;
            t_s.push(time_s);
            angle.push(measured.angle_rad);
            acceleration.push(measured.acceleration_rad_s2);
            torque.push(measured.torque_mnm);
        }
        let mut live = LiveFit::new(RATE_HZ, Some(&calibration));
        let (mut pushing, mut estimating, mut slowest) = (0.0, 0.0, 0.0_f64);
        for block in 0..1000 {
            let start = std::time::Instant::now();
            for index in block * 100..(block + 1) * 100 {
                live.push(&LiveSample { time_s: t_s[index], angle_rad: angle[index], torque_mnm: torque[index] });
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
        let samples = Samples {
            t_s: &t_s,
            angle_rad: &angle,
            velocity_rad_s: None,
            acceleration_rad_s2: Some(&acceleration),
            torque_mnm: &torque,
        };
        let whole = fit(&samples, &FitOptions { calibration: Some(calibration), ..FitOptions::default() })?;
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
