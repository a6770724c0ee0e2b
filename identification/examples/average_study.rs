//! What averaging captures wins: the mean of whole vectors against that of single parameters, and whether captures of
//! one knob are told to agree.
//!
//! `cargo run --release -p identification --example average_study -- [PAIRS]`
#![allow(clippy::print_stdout, reason = "an example speaks to its user")]

#[path = "../tests/all/common/mod.rs"]
mod common;

use common::{Failure, SLIDING, captured_at, true_value};
use dynamics::{Model, knobs};
use hal::simulated_rig::RigParameters;
use identification::statistics::nearest_turn;
use identification::{Fit, average, fit};

/// Captures of a pair: a sweep, and its amplitude in rad about which seeds vary by 5 %.
const PAIR: [(&str, f64); 2] = [("linear-chirp", 1.0), ("stepped-amplitude", 1.0)];
const DURATION_S: f64 = 8.0;

/// Errors of one parameter: of the first capture, of the mean of single parameters, of the mean of vectors.
#[derive(Default)]
struct Tally {
    squares: [f64; 3],
    held: u32,
    told: u32,
}

fn main() -> Result<(), Failure> {
    let pairs: u64 = std::env::args().nth(1).map_or(Ok(50), |text| text.parse())?;
    println!("knob  parameter             RMS error: one capture, mean of parameters, mean of vectors   held");
    for number in [2, 3, 4] {
        let knob = knobs::paper_knob(number)?;
        let names: Vec<&str> = SLIDING.into_iter().filter(|name| true_value(&knob, name).is_some()).collect();
        let mut tallies: Vec<Tally> = names.iter().map(|_| Tally::default()).collect();
        let (mut unlikely, mut birge) = ([0_u32; 2], 0.0);
        for pair in 0..pairs {
            let fits = [0, 1].map(|which| captured_fit(&knob, PAIR[which], 2 * pair + which as u64 + 1));
            let fits = fits.into_iter().collect::<Result<Vec<Fit>, Failure>>()?;
            let mean = average(&fits).ok_or("there are two captures")?;
            if let Some(agreement) = mean.agreement {
                birge += agreement.birge_ratio;
                unlikely[0] += u32::from(agreement.probability < 0.05);
                unlikely[1] += u32::from(agreement.probability < 1e-3);
            }
            for (name, tally) in names.iter().zip(&mut tallies) {
                tally.count(name, &fits, &mean.fit, true_value(&knob, name).unwrap_or(f64::NAN));
            }
        }
        for (name, tally) in names.iter().zip(&tallies) {
            let [one, scalar, vector] = tally.squares.map(|sum| (sum / f64::from(tally.told)).sqrt());
            println!(
                "{number:4}  {name:18} {one:12.3e} {scalar:12.3e} {vector:12.3e}   {:5.1} % of {}",
                100.0 * f64::from(tally.held) / f64::from(tally.told),
                tally.told
            );
        }
        println!(
            "knob {number}: of {pairs} pairs of captures of one knob {} are told to differ at 5 %, {} at 0.1 %; mean Birge ratio {:.2}",
            unlikely[0],
            unlikely[1],
            birge / pairs as f64
        );
    }
    Ok(())
}

fn captured_fit(knob: &Model, (sweep, amplitude_rad): (&str, f64), seed: u64) -> Result<Fit, Failure> {
    let amplitude_rad = amplitude_rad * (0.95 + 0.1 * (seed as f64 * 0.618_034).fract());
    let capture = captured_at(knob, sweep, amplitude_rad, RigParameters::default(), DURATION_S, seed)?;
    Ok(fit(&capture.samples(), &capture.options())?)
}

impl Tally {
    fn count(&mut self, name: &str, fits: &[Fit], mean: &Fit, truth: f64) {
        let told = |fit: &Fit| fit.parameters.get(name).and_then(|p| p.value.zip(p.ci95));
        let (Some(first), Some(second), Some((value, [low, high]))) = (told(&fits[0]), told(&fits[1]), told(mean))
        else {
            return;
        };
        let weight = |(_, [low, high]): (f64, [f64; 2])| (high - low).powi(-2);
        let (one, other) = (weight(first), weight(second));
        let error = |value: f64| if name == "detent_phase" { nearest_turn(value - truth, 0.0) } else { value - truth };
        let scalar = (one * error(first.0) + other * error(second.0)) / (one + other);
        for (sum, error) in self.squares.iter_mut().zip([error(first.0), scalar, error(value)]) {
            *sum += error * error;
        }
        self.held += u32::from((low..=high).contains(&(value - error(value))));
        self.told += 1;
    }
}
