//! How often the 95 % intervals hold the truth, over whole captures of the paper's knobs on the simulated rig.
//!
//! `cargo run --release -p identification --example coverage -- [--captures N] [--knobs 1,2] [--sweeps paper,…]
//! [--ideal noise,steps,compliance,lags,servo] [--first-seed N] [--duration S] [--errors FILE.csv]`
#![allow(clippy::print_stdout, reason = "an example speaks to its user")]

#[path = "../tests/all/common/mod.rs"]
mod common;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{Failure, Uniform, captured_at, true_value};
use dynamics::knobs;
use hal::simulated_rig::RigParameters;
use identification::{Fit, fit};

/// What of the rig is made ideal.
const IMPERFECTIONS: [&str; 5] = ["noise", "steps", "compliance", "lags", "servo"];

struct Study {
    captures: usize,
    knobs: Vec<u32>,
    sweeps: Vec<String>,
    first_seed: u64,
    duration_s: f64,
    parameters: RigParameters,
    /// Step of the encoder in the recording alone, rad: the servo sees the angle without steps.
    recorded_step_rad: Option<f64>,
    /// Where every single error is written, if anywhere.
    errors: Option<String>,
}

/// One fit of one capture.
struct Outcome {
    knob: u32,
    sweep: String,
    seed: u64,
    fit: Fit,
}

/// How the intervals of one parameter fared.
#[derive(Default)]
struct Tally {
    told: u32,
    held: u32,
    held_textbook: u32,
    errors: Vec<f64>,
    half_widths: Vec<f64>,
}

fn main() -> Result<(), Failure> {
    let study = Study::from_arguments()?;
    let outcomes = study.run()?;
    if let Some(path) = &study.errors {
        std::fs::write(path, errors_csv(&outcomes)?)?;
    }
    println!(
        "parameter            knob  told  held           textbook  mean error  SD of error  half width/1.96  z of the bias"
    );
    let mut names: Vec<&str> = Vec::new();
    for outcome in &outcomes {
        for parameter in &outcome.fit.parameters.0 {
            if !names.contains(&parameter.name) {
                names.push(parameter.name);
            }
        }
    }
    for name in names {
        let mut all = Tally::default();
        for knob in &study.knobs {
            let truth = true_value(&knobs::paper_knob(*knob)?, name);
            let mut tally = Tally::default();
            for outcome in outcomes.iter().filter(|outcome| outcome.knob == *knob) {
                tally.take(&outcome.fit, name, truth);
            }
            tally.print(name, &knob.to_string());
            all.told += tally.told;
            all.held += tally.held;
            all.held_textbook += tally.held_textbook;
        }
        if study.knobs.len() > 1 {
            all.print(name, "all");
        }
    }
    Ok(())
}

/// Every error with both half widths, one per line.
fn errors_csv(outcomes: &[Outcome]) -> Result<String, Failure> {
    let mut text = "knob,sweep,seed,parameter,error,half_width,half_width_textbook\n".to_owned();
    for Outcome { knob, sweep, seed, fit } in outcomes {
        for parameter in &fit.parameters.0 {
            let truth = true_value(&knobs::paper_knob(*knob)?, parameter.name);
            let (Some(value), Some([low, high]), Some(truth)) = (parameter.value, parameter.ci95, truth) else {
                continue;
            };
            let half = |[low, high]: [f64; 2]| 0.5 * (high - low);
            let textbook = parameter.ci95_textbook.map_or_else(String::new, |interval| half(interval).to_string());
            let (name, error, half) = (parameter.name, value - truth, half([low, high]));
            text += &format!("{knob},{sweep},{seed},{name},{error:e},{half:e},{textbook}\n");
        }
    }
    Ok(text)
}

impl Study {
    fn from_arguments() -> Result<Self, Failure> {
        let mut study = Self {
            captures: 40,
            knobs: vec![1, 2, 3, 4],
            sweeps: vec!["linear-chirp".to_owned()],
            first_seed: 1,
            duration_s: 10.0,
            parameters: RigParameters::default(),
            recorded_step_rad: None,
            errors: None,
        };
        let mut arguments = std::env::args().skip(1);
        while let Some(argument) = arguments.next() {
            let value = arguments.next().ok_or_else(|| format!("{argument} needs a value"))?;
            match argument.as_str() {
                "--captures" => study.captures = value.parse()?,
                "--knobs" => study.knobs = value.split(',').map(str::parse).collect::<Result<_, _>>()?,
                "--sweeps" => study.sweeps = value.split(',').map(str::to_owned).collect(),
                "--first-seed" => study.first_seed = value.parse()?,
                "--duration" => study.duration_s = value.parse()?,
                "--errors" => study.errors = Some(value),
                "--ideal" => value.split(',').try_for_each(|what| study.idealise(what))?,
                _ => return Err(format!("there is no option {argument}").into()),
            }
        }
        Ok(study)
    }

    fn idealise(&mut self, what: &str) -> Result<(), Failure> {
        let parameters = &mut self.parameters;
        match what {
            "noise" => parameters.noise_scale = 0.0,
            "steps" => {
                parameters.angle_step_rad = 0.0;
                parameters.torque_step_mnm = 0.0;
                parameters.acceleration_step_rad_s2 = 0.0;
            }
            "compliance" => parameters.torque_sensor_stiffness_mnm_rad = 3e6,
            "lags" => {
                parameters.torque_bandwidth_hz = 2e4;
                parameters.acceleration_bandwidth_hz = 2e4;
            }
            "servo" => {
                self.recorded_step_rad = Some(parameters.angle_step_rad);
                parameters.angle_step_rad = 0.0;
            }
            _ => return Err(format!("'{what}' is none of {}", IMPERFECTIONS.join(", ")).into()),
        }
        Ok(())
    }

    /// All captures and their fits, on as many threads as the machine has cores; seeds go round over knobs and sweeps.
    fn run(&self) -> Result<Vec<Outcome>, Failure> {
        let next = AtomicUsize::new(0);
        let outcomes = Mutex::new(Vec::new());
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads).map(|_| scope.spawn(|| self.work(&next, &outcomes))).collect();
            workers.into_iter().try_for_each(|worker| worker.join().map_err(|_| "a worker panicked")?)
        })?;
        outcomes.into_inner().map_err(|_| "a worker panicked".into())
    }

    fn work(&self, next: &AtomicUsize, outcomes: &Mutex<Vec<Outcome>>) -> Result<(), Failure> {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= self.captures {
                return Ok(());
            }
            let knob = self.knobs[index % self.knobs.len()];
            let sweep = &self.sweeps[index / self.knobs.len() % self.sweeps.len()];
            let seed = self.first_seed + index as u64;
            let amplitude_rad = amplitude_rad(seed);
            let model = knobs::paper_knob(knob)?;
            let mut capture =
                captured_at(&model, sweep, amplitude_rad, self.parameters.clone(), self.duration_s, seed)?;
            if let Some(step_rad) = self.recorded_step_rad {
                capture.angle_rad.iter_mut().for_each(|angle| *angle = (*angle / step_rad).round() * step_rad);
            }
            let fit = fit(&capture.samples(), &capture.options())?;
            if index < self.knobs.len() * self.sweeps.len() {
                println!(
                    "knob {knob} {sweep}: residual {:.3} mNm, {:.3} %, delay {:.2} µs, {:?} {:?}",
                    fit.residual_rms_mnm,
                    fit.relative_error_percent,
                    1e6 * fit.torque_delay_s,
                    fit.preparation,
                    fit.notes
                );
            }
            if let Ok(mut outcomes) = outcomes.lock() {
                outcomes.push(Outcome { knob, sweep: sweep.clone(), seed, fit });
            }
        }
    }
}

/// A sweep's amplitude, 0.95 to 1.05 rad: with one and the same motion the encoder's steps would make the same error
/// in every capture, and count as a bias.
fn amplitude_rad(seed: u64) -> f64 {
    let mut random = Uniform(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    random.next();
    0.95 + 0.1 * random.next()
}

impl Tally {
    fn take(&mut self, fit: &Fit, name: &str, truth: Option<f64>) {
        let Some(parameter) = fit.parameters.get(name) else { return };
        let (Some(value), Some(interval), Some(truth)) = (parameter.value, parameter.ci95, truth) else { return };
        let holds = |[low, high]: [f64; 2]| u32::from(low <= truth && truth <= high);
        self.told += 1;
        self.held += holds(interval);
        self.held_textbook += parameter.ci95_textbook.map_or(0, holds);
        self.errors.push(value - truth);
        self.half_widths.push(0.5 * (interval[1] - interval[0]));
    }

    fn print(&self, name: &str, knob: &str) {
        if self.told == 0 {
            return;
        }
        let percent = |count: u32| 100.0 * f64::from(count) / f64::from(self.told);
        let mut line = format!(
            "{name:20} {knob:4} {:5}  {:4} = {:5.1} %  {:5.1} %",
            self.told,
            self.held,
            percent(self.held),
            percent(self.held_textbook)
        );
        if !self.errors.is_empty() {
            let count = f64::from(self.told);
            let mean = self.errors.iter().sum::<f64>() / count;
            let spread = (self.errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0)).sqrt();
            let half = self.half_widths.iter().sum::<f64>() / count;
            line += &format!(
                "   {mean:+.2e}   {spread:.2e}    {:.2e}       {:+.2}",
                half / 1.96,
                mean / (spread / count.sqrt()).max(1e-12 * mean.abs())
            );
        }
        println!("{line}");
    }
}
