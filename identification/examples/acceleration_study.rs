//! What the encoder alone and both sensors together make of the inertia.
//!
//! `cargo run --release -p identification --example acceleration_study -- [SEEDS] [rig|coarse|recorded]`
#![allow(clippy::print_stdout, reason = "an example speaks to its user")]

#[path = "../tests/all/common/mod.rs"]
mod common;

use std::f64::consts::TAU;

use common::{Failure, Uniform, captured_at};
use dynamics::knobs;
use hal::simulated_rig::RigParameters;
use identification::{AccelerationUse, FitOptions, Samples, fit};

/// Noise of the acceleration that the paper states for its sensor, rad/s².
const PAPER_NOISE_RAD_S2: f64 = 2.8;

/// Errors and intervals of the inertia over many captures.
#[derive(Default)]
struct Errors {
    errors: Vec<f64>,
    held: u32,
    asked: u32,
}

impl Errors {
    fn take(&mut self, samples: &Samples<'_>, options: &FitOptions, truth: f64) -> Result<(), Failure> {
        self.asked += 1;
        let fit = fit(samples, options)?;
        if let Some((value, [low, high])) = fit.parameters.get("inertia").and_then(|p| p.value.zip(p.ci95)) {
            self.errors.push(value / truth - 1.0);
            self.held += u32::from(low <= truth && truth <= high);
        }
        Ok(())
    }

    fn line(&self) -> String {
        let count = self.errors.len() as f64;
        let mean = self.errors.iter().sum::<f64>() / count;
        let rms = (self.errors.iter().map(|e| e * e).sum::<f64>() / count).sqrt();
        format!(
            "told {:4} of {:3}   mean error {:+9.5} %   RMS error {:9.5} %   held {:5.1} %",
            self.errors.len(),
            self.asked,
            100.0 * mean,
            100.0 * rms,
            100.0 * f64::from(self.held) / count
        )
    }
}

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().map_or(Ok(50), |text| text.parse())?;
    let part = arguments.next();
    let asked = |name: &str| part.as_deref().is_none_or(|part| part == name);
    if asked("rig") {
        let cases = [(1, "paper"), (2, "paper"), (3, "paper"), (2, "linear-chirp")];
        sensors("the rig as it is", &RigParameters::default(), None, &cases, seeds)?;
    }
    let cases = [(1, "paper"), (2, "linear-chirp"), (3, "linear-chirp")];
    let noisy = RigParameters { acceleration_noise_rms_rad_s2: PAPER_NOISE_RAD_S2, ..RigParameters::default() };
    for lines in [16_384.0, 4096.0] {
        let words = format!("an encoder of {lines} steps a turn, {PAPER_NOISE_RAD_S2} rad/s² of noise");
        if asked("coarse") {
            let rig = RigParameters { angle_step_rad: TAU / lines, ..noisy.clone() };
            sensors(&format!("{words}; the servo has that encoder"), &rig, None, &cases, seeds)?;
        }
        if asked("recorded") {
            sensors(&format!("{words}; the servo has a fine one"), &noisy, Some(TAU / lines), &cases, seeds)?;
        }
    }
    Ok(())
}

/// The encoder alone and both sensors, on a simulated rig; the angle is recorded in steps of `recorded_step_rad`, if that is coarser than
/// the rig's own.
fn sensors(
    title: &str,
    rig: &RigParameters,
    recorded_step_rad: Option<f64>,
    cases: &[(u32, &str)],
    seeds: u64,
) -> Result<(), Failure> {
    println!("{title}; 10 s at 10 kHz, {seeds} captures each");
    let uses = [("encoder", AccelerationUse::Encoder), ("blend", AccelerationUse::Best)];
    for (number, name) in cases {
        let knob = knobs::paper_knob(*number)?;
        let truth = knob.parameter("inertia").unwrap_or_default();
        let mut results: [Errors; 2] = Default::default();
        for seed in 1..=seeds {
            let mut random = Uniform(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            let amplitude_rad = 0.95 + 0.1 * random.next();
            let mut capture = captured_at(&knob, name, amplitude_rad, rig.clone(), 10.0, seed)?;
            if let Some(step_rad) = recorded_step_rad {
                capture.angle_rad.iter_mut().for_each(|angle| *angle = (*angle / step_rad).round() * step_rad);
            }
            for (result, (_, acceleration)) in results.iter_mut().zip(uses) {
                let options = FitOptions { acceleration, ..capture.options() };
                result.take(&capture.samples(), &options, truth)?;
            }
        }
        for ((source, _), result) in uses.iter().zip(&results) {
            println!("knob {number} {name:13} {source:14} {}", result.line());
        }
    }
    println!();
    Ok(())
}
