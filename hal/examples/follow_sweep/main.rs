//! How well a position servo follows the sweeps on the simulated rig, knob by knob.
//!
//! `cargo run --release -p hal --example follow_sweep`
#![allow(clippy::print_stdout, reason = "the figures are what the example is for")]

mod drive;
mod servo;

use drive::{Conditions, drive};
use dynamics::{Drive, Effect, Excitation, Model, effects, knobs};
use hal::simulated_rig::RigParameters;
use servo::Gains;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let knobs = (1..=5).map(knobs::paper_knob).collect::<Result<Vec<_>, _>>()?;
    let recommended = Gains::RECOMMENDED;
    let late = || Conditions { delay_ticks: 1, ..Conditions::default() };
    let plain = Gains { integral: 0.0, notch_width: 0.0, load_share: 0.0, ..recommended };
    let variants = [
        ("PD 6000/50", Gains { derivative: 50.0, proportional: 6000.0, ..plain }, Conditions::default()),
        ("PD 6000/50, late", Gains { derivative: 50.0, proportional: 6000.0, ..plain }, late()),
        ("PD, late", plain, late()),
        ("PD + notch, late", Gains { integral: 0.0, load_share: 0.0, ..recommended }, late()),
        ("PID + notch", Gains { load_share: 0.0, ..recommended }, Conditions::default()),
        ("PID + notch + load", recommended, Conditions::default()),
    ];
    println!("linear-chirp, 10 s at 10 kHz");
    println!("servo               knob    peak       rms   clipped  command change  sensor     speed  limits");
    let chirp = Excitation::named("linear-chirp", Drive::Position)?;
    for (name, gains, conditions) in &variants {
        for knob in &knobs {
            report(name, knob, &chirp, *gains, conditions)?;
        }
    }
    for name in ["paper", "multisine", "stepped-amplitude"] {
        println!("{name}, recommended servo");
        let excitation = Excitation::named(name, Drive::Position)?;
        for knob in &knobs {
            report(name, knob, &excitation, recommended, &Conditions::default())?;
        }
    }
    println!("other rates, one tick of delay, recommended servo");
    for rate_hz in [5_000.0, 10_000.0, 20_000.0] {
        for knob in &knobs {
            let conditions = Conditions { rate_hz, delay_ticks: 1, ..Conditions::default() };
            report(&format!("{rate_hz} Hz, 1 tick late"), knob, &chirp, recommended, &conditions)?;
        }
    }
    println!("other loads, recommended servo");
    for inertia in [0.0, 0.5, 1.0, 2.0] {
        let flywheel = Model {
            name: format!("{inertia}"),
            description: String::new(),
            effects: vec![Effect::new(&effects::inertia::KIND, &[inertia])],
            ..Model::default()
        };
        report("flywheel", &flywheel, &chirp, recommended, &Conditions::default())?;
    }
    for peak_current_a in [20.0, 22.0, 24.0] {
        let parameters = RigParameters { peak_current_a, ..RigParameters::default() };
        let conditions = Conditions { parameters, ..Conditions::default() };
        let (mut runs, mut stopped) = (0, 0);
        for name in ["linear-chirp", "paper", "stepped-amplitude", "multisine"] {
            for step in 0..20 {
                let amplitude_rad = 0.5 + 0.05 * f64::from(step);
                let excitation = Excitation::named(name, Drive::Position)?.with_amplitude(amplitude_rad)?;
                runs += 1;
                stopped += u32::from(drive(&knobs[4], &excitation, recommended, &conditions)?.limit_passed);
            }
        }
        println!("knob 5 at {peak_current_a} A: {stopped} of {runs} sweeps of 0.5 to 1.45 rad pass a limit");
    }
    Ok(())
}

fn report(
    name: &str,
    knob: &Model,
    excitation: &Excitation,
    gains: Gains,
    conditions: &Conditions,
) -> Result<(), Box<dyn std::error::Error>> {
    let following = drive(knob, excitation, gains, conditions)?;
    println!(
        "{name:19} {:6} {:.4} rad {:.5} rad {:5.1} % {:8.1} mNm {:6.0} mNm {:5.1} rad/s  {}",
        knob.name,
        following.peak_rad,
        following.rms_rad,
        100.0 * following.clipped,
        following.command_change_mnm,
        following.sensor_mnm,
        following.speed_rad_s,
        if following.limit_passed { "PASSED" } else { "kept" }
    );
    Ok(())
}
