//! How the preparations compare: errors of the parameters over captures from the simulated rig.
//!
//! `cargo run --release -p identification --example preparations -- [SEEDS]`
#![allow(clippy::print_stdout, reason = "an example speaks to its user")]

#[path = "../tests/all/common/mod.rs"]
mod common;

use common::{Failure, Uniform, captured_at, true_value};
use dynamics::knobs;
use hal::simulated_rig::RigParameters;
use identification::{FitOptions, PreparationMethod, fit};

const PARAMETERS: [&str; 4] = ["inertia", "coulomb_positive", "viscous_positive", "detent_amplitude"];
const METHODS: [PreparationMethod; 3] =
    [PreparationMethod::Automatic, PreparationMethod::Paper, PreparationMethod::CentralDifferences];

fn main() -> Result<(), Failure> {
    let seeds: u64 = std::env::args().nth(1).map_or(Ok(20), |text| text.parse())?;
    println!("RMS error in % of the truth (captures that tell it); linear chirp, 6 s at 10 kHz, {seeds} seeds");
    println!("knob preparation          {}", PARAMETERS.map(|name| format!("{name:>24}")).concat());
    for number in [1, 3, 4] {
        let knob = knobs::paper_knob(number)?;
        let mut errors = vec![vec![Vec::new(); PARAMETERS.len()]; METHODS.len()];
        for seed in 1..=seeds {
            let amplitude_rad = 0.95 + 0.1 * Uniform(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)).next();
            let capture = captured_at(&knob, "linear-chirp", amplitude_rad, RigParameters::default(), 6.0, seed)?;
            for (method, errors) in METHODS.iter().zip(&mut errors) {
                let options = FitOptions { preparation: *method, ..capture.options() };
                let fit = fit(&capture.samples(), &options)?;
                for (name, errors) in PARAMETERS.iter().zip(errors) {
                    let truth = true_value(&knob, name).filter(|truth| *truth != 0.0);
                    let told = fit.parameters.get(name).and_then(|parameter| parameter.value);
                    errors.extend(told.zip(truth).map(|(value, truth)| (value / truth - 1.0_f64).powi(2)));
                }
            }
        }
        for (method, errors) in METHODS.iter().zip(&errors) {
            let cell = |squares: &Vec<f64>| {
                let count = squares.iter().map(|_| 1.0).sum::<f64>();
                if squares.is_empty() {
                    return format!("{:>24}", "-");
                }
                format!("{:>18.3} ({:3})", 100.0 * (squares.iter().sum::<f64>() / count).sqrt(), squares.len())
            };
            println!("{number:4} {:20} {}", method.name(), errors.iter().map(cell).collect::<String>());
        }
    }
    Ok(())
}
