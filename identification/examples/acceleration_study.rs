//! What noise in the acceleration does to the inertia, and what each sensor and estimator makes of it.
//!
//! `cargo run --release -p identification --example acceleration_study -- [SEEDS]`
#![allow(clippy::print_stdout, reason = "an example speaks to its user")]

mod common;

use common::{Uniform, capture};
use dynamics::{Drive, Excitation, Motion, knobs};
use hal::simulated::RigParameters;
use identification::{AccelerationUse, FitOptions, Samples, fit};

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Errors and intervals of the inertia over many captures.
#[derive(Default)]
struct Errors {
    errors: Vec<f64>,
    held: u32,
}

impl Errors {
    fn take(&mut self, samples: &Samples<'_>, options: &FitOptions, truth: f64) -> Result<(), Failure> {
        let fit = fit(samples, options)?;
        if let Some((value, [low, high])) = fit.parameters.get("inertia").and_then(|p| p.value.zip(p.ci95)) {
            self.errors.push(value / truth - 1.0);
            self.held += u32::from(low <= truth && truth <= high);
        }
        Ok(())
    }

    #[allow(clippy::cast_precision_loss, reason = "few captures")]
    fn line(&self) -> String {
        let count = self.errors.len() as f64;
        let mean = self.errors.iter().sum::<f64>() / count;
        let rms = (self.errors.iter().map(|e| e * e).sum::<f64>() / count).sqrt();
        format!(
            "told {:4}   mean error {:+9.5} %   RMS error {:9.5} %   held {:5.1} %",
            self.errors.len(),
            100.0 * mean,
            100.0 * rms,
            100.0 * f64::from(self.held) / count
        )
    }
}

fn main() -> Result<(), Failure> {
    let seeds: u64 = std::env::args().nth(1).map_or(Ok(200), |text| text.parse())?;
    noisy_column(seeds)?;
    println!();
    sensors(seeds)
}

/// A noisy acceleration column as the only source, plain and instrumented by the encoder.
fn noisy_column(seeds: u64) -> Result<(), Failure> {
    println!("a noisy acceleration column as the only source; knob 2, linear chirp, 6 s at 5 kHz, {seeds} seeds");
    let knob = knobs::paper_knob(2)?;
    let truth = knob.parameter("inertia").unwrap_or_default();
    let sweep = Excitation::named("linear-chirp", Drive::Position)?;
    for noise_rad_s2 in [50.0, 200.0, 500.0] {
        let mut results = [Errors::default(), Errors::default()];
        for seed in 1..=seeds {
            let mut random = Uniform(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            let (mut t_s, mut angle, mut acceleration, mut torque) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
            for tick in 1..=30_000 {
                let time_s = f64::from(tick) / 5000.0;
                let set = sweep.at(time_s);
                let motion = Motion {
                    time_s,
                    angle_rad: set.value,
                    velocity_rad_s: set.rate,
                    acceleration_rad_s2: set.acceleration,
                };
                t_s.push(time_s);
                angle.push((set.value / 9.8e-6).round() * 9.8e-6);
                acceleration.push(set.acceleration + noise_rad_s2 * random.normal());
                torque.push(knob.torque_mnm(&motion) + 0.25 * random.normal());
            }
            let samples = Samples {
                t_s: &t_s,
                angle_rad: &angle,
                velocity_rad_s: None,
                acceleration_rad_s2: Some(&acceleration),
                torque_mnm: &torque,
            };
            for (result, acceleration) in
                results.iter_mut().zip([AccelerationUse::Column, AccelerationUse::ColumnInstrumented])
            {
                let options = FitOptions { acceleration, without_detents: true, ..FitOptions::default() };
                result.take(&samples, &options, truth)?;
            }
        }
        for (name, result) in ["least squares", "instrumented"].iter().zip(&results) {
            println!("noise {noise_rad_s2:5.0} rad/s²   {name:14} {}", result.line());
        }
    }
    Ok(())
}

/// Encoder alone, accelerometer alone, and both, on the simulated rig.
fn sensors(seeds: u64) -> Result<(), Failure> {
    println!("the sensors on the simulated rig, 10 s at 10 kHz, {} captures each", seeds / 4);
    for (number, name) in [(1, "paper"), (2, "paper"), (3, "paper"), (2, "linear-chirp")] {
        let knob = knobs::paper_knob(number)?;
        let truth = knob.parameter("inertia").unwrap_or_default();
        let uses = [AccelerationUse::Encoder, AccelerationUse::Column, AccelerationUse::Best];
        let mut results = [Errors::default(), Errors::default(), Errors::default()];
        for seed in 1..=seeds / 4 {
            let mut random = Uniform(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            let amplitude_rad = 0.95 + 0.1 * random.next();
            let sweep = Excitation::named(name, Drive::Position)?.with_amplitude(amplitude_rad)?;
            let capture = capture(&knob, sweep, RigParameters::default(), 10.0, seed)?;
            for (result, acceleration) in results.iter_mut().zip(uses) {
                let calibration = Some(capture.calibration.clone());
                let options = FitOptions { calibration, acceleration, ..FitOptions::default() };
                result.take(&capture.samples(), &options, truth)?;
            }
        }
        for (source, result) in ["encoder", "accelerometer", "both"].iter().zip(&results) {
            println!("knob {number} {name:13} {source:14} {}", result.line());
        }
    }
    Ok(())
}
