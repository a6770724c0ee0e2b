//! Captures of the paper's knobs on the simulated rig under a PD servo: does every interval hold the truth?
//!
//! `cargo run --release -p identification --example rig_study -- [SEEDS] [KNOB…]`
#![allow(clippy::print_stdout, reason = "an example speaks to its user")]

use std::collections::BTreeMap;

use dynamics::effects::detent;
use dynamics::{Drive, Excitation, knobs};
use hal::Apparatus;
use hal::simulated::{RigParameters, SimulatedRig};
use identification::{FitOptions, Samples, fit};

const RATE_HZ: f64 = 10_000.0;
const DURATION_S: f64 = 10.0;

#[derive(Default)]
struct Capture {
    t_s: Vec<f64>,
    angle_rad: Vec<f64>,
    acceleration_rad_s2: Vec<f64>,
    torque_mnm: Vec<f64>,
    calibration: Option<dynamics::Calibration>,
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "nanoseconds of a few seconds")]
fn capture(number: u32, seed: u64) -> Result<Capture, Box<dyn std::error::Error>> {
    let mut rig = SimulatedRig::new(RigParameters::default(), knobs::paper_knob(number)?, seed)?;
    let calibration = rig.description().calibration.clone();
    let sweep = Excitation::named("linear-chirp", Drive::Position)?;
    rig.enable()?;
    let (stiffness, damping) = (3000.0, 20.0);
    let inertia = calibration.motor_inertia + calibration.gripper_inertia;
    let (mut previous, mut velocity) = (0.0, 0.0);
    let mut capture = Capture { calibration: Some(calibration), ..Capture::default() };
    for tick in 0..(DURATION_S * RATE_HZ) as u32 {
        let time_s = f64::from(tick) / RATE_HZ;
        let measured = rig.read((time_s * 1e9).round() as u64)?;
        let set = sweep.at(time_s);
        velocity += 0.3 * ((measured.angle_rad - previous) * RATE_HZ - velocity);
        previous = measured.angle_rad;
        let torque =
            inertia * set.acceleration + stiffness * (set.value - measured.angle_rad) + damping * (set.rate - velocity);
        rig.write_torque(torque)?;
        capture.t_s.push(time_s);
        capture.angle_rad.push(measured.angle_rad);
        capture.acceleration_rad_s2.push(measured.acceleration_rad_s2);
        capture.torque_mnm.push(measured.torque_mnm);
    }
    Ok(capture)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().map_or(Ok(20), |text| text.parse())?;
    let chosen: Vec<u32> = arguments.map(|text| text.parse()).collect::<Result<_, _>>()?;
    for number in (1..=5).filter(|number| chosen.is_empty() || chosen.contains(number)) {
        let knob = knobs::paper_knob(number)?;
        let (amplitude, phase) = knob
            .effect("detent")
            .map_or((0.0, 0.0), |effect| detent::canonical(effect.values()[0], effect.values()[2]));
        let mut cover: BTreeMap<&str, (u64, u64, f64, f64)> = BTreeMap::new();
        for seed in 1..=seeds {
            let capture = capture(number, seed)?;
            let samples = Samples {
                t_s: &capture.t_s,
                angle_rad: &capture.angle_rad,
                velocity_rad_s: None,
                acceleration_rad_s2: Some(&capture.acceleration_rad_s2),
                torque_mnm: &capture.torque_mnm,
            };
            let options = FitOptions { calibration: capture.calibration.clone(), ..FitOptions::default() };
            let start = std::time::Instant::now();
            let fit = fit(&samples, &options)?;
            if seed == 1 {
                println!(
                    "knob {number} in {:?}: residual {:.4} mNm, relative {:.3} %, mean ±{:.4} mNm, delay {:.1} µs\n{:?} {:?}",
                    start.elapsed(),
                    fit.residual_rms_mnm,
                    fit.relative_error_percent,
                    fit.mean_ci95_mnm,
                    1e6 * fit.torque_delay_s,
                    fit.preparation,
                    fit.notes
                );
            }
            for parameter in &fit.parameters.0 {
                let truth = match parameter.name {
                    "detent_amplitude" => amplitude,
                    "detent_phase" => phase,
                    name => knob.parameter(name).unwrap_or(f64::NAN),
                };
                match parameter.value.zip(parameter.ci95) {
                    Some((value, [low, high])) => {
                        let entry = cover.entry(parameter.name).or_default();
                        entry.0 += 1;
                        entry.1 += u64::from(low <= truth && truth <= high);
                        entry.2 += value - truth;
                        entry.3 += 0.5 * (high - low);
                        if seed == 1 {
                            println!("  {:18} {value:.6} ± {:.6}, truth {truth}", parameter.name, 0.5 * (high - low));
                        }
                    }
                    None if seed == 1 => println!("  {:18} untold: {:?}", parameter.name, parameter.reason),
                    None => {}
                }
            }
        }
        #[allow(clippy::cast_precision_loss, reason = "small counts")]
        for (name, (told, inside, error, half)) in cover {
            let count = told as f64;
            println!(
                "    {name:18} {inside:3} of {told:3} intervals hold; mean error {:+.2e}, mean half width {:.2e}",
                error / count,
                half / count
            );
        }
    }
    Ok(())
}
