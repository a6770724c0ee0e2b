//! A thousand simulated knobs near a limit: how often a verdict is wrong, how many stay undecided, and how much longer a capture
//! decides them. Prints the table of `docs/sheet.md`.
//!
//! A knob has four detents in a turn, friction of 2 mNm and a sensor with 0.2 mNm of noise; its detent's amplitude is drawn evenly
//! about that with which its peak torque lies on the limit. The knob is turned there and back by the plain equation, not by
//! this project's simulation.
#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a study that prints its table")]

use std::f64::consts::TAU;

use archive::testers::Curve;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore as _, SeedableRng as _};
use shared_types::Axis;
use sheet::{Sheet, Specification, Verdict};

const UNITS: u64 = 1000;
const RISK: f64 = 0.05;
const FRICTION_MNM: f64 = 2.0;
const NOISE_MNM: f64 = 0.2;
const LIMIT_MNM: f64 = 12.0;
/// Largest distance of a unit's peak from the limit, mNm: some four standard errors of the shortest capture.
const REACH_MNM: f64 = 0.08;
const DETENTS: f64 = 4.0;
/// Rows of one way in the shortest capture.
const ROWS: u32 = 1500;
const LENGTHS: [u32; 3] = [1, 4, 16];

struct Random(Xoshiro256PlusPlus);

impl Random {
    fn even(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A normal value (Box and Muller 1958).
    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.even()).ln()).sqrt() * (TAU * self.even()).cos()
    }
}

fn turn(amplitude_mnm: f64, length: u32, random: &mut Random) -> Curve {
    let rows = ROWS * length;
    let span = 1.2 * TAU;
    let (mut position, mut load) = (Vec::new(), Vec::new());
    for row in 0..2 * rows {
        let share = f64::from(if row < rows { row } else { 2 * rows - 1 - row }) / f64::from(rows);
        let friction = if row < rows { FRICTION_MNM } else { -FRICTION_MNM };
        let angle = span * share;
        position.push(angle);
        load.push(friction + amplitude_mnm * (DETENTS * angle).sin() + NOISE_MNM * random.normal());
    }
    Curve { axis: Axis::Rotary, position, load, ..Curve::default() }
}

/// The verdict on a unit by captures of each length, and whether its peak truly is within the limit.
fn judge(unit: u64, specification: &Specification) -> (bool, [Verdict; LENGTHS.len()]) {
    let mut random = Random(Xoshiro256PlusPlus::seed_from_u64(unit));
    let off_mnm = REACH_MNM * (2.0 * random.even() - 1.0);
    let amplitude_mnm = LIMIT_MNM - FRICTION_MNM + off_mnm;
    let verdicts = LENGTHS.map(|length| {
        let sheet = Sheet::of(&[turn(amplitude_mnm, length, &mut random)]).unwrap();
        specification.judge(&sheet).verdict
    });
    (off_mnm >= 0.0, verdicts)
}

fn main() {
    let text = format!("risk = {RISK}\n[figures.peak_torque]\nmin = {LIMIT_MNM}\n");
    let specification = Specification::from_toml(&text).unwrap();
    let threads = std::thread::available_parallelism().map_or(1, |cores| cores.get() as u64);
    let judged: Vec<(bool, [Verdict; LENGTHS.len()])> = std::thread::scope(|scope| {
        let parts: Vec<_> = (0..threads)
            .map(|part| {
                let specification = &specification;
                scope.spawn(move || {
                    (part..UNITS).step_by(threads as usize).map(|unit| judge(unit, specification)).collect::<Vec<_>>()
                })
            })
            .collect();
        parts.into_iter().flat_map(|part| part.join().unwrap()).collect()
    });
    println!(
        "{UNITS} units, peak torque within ±{REACH_MNM} mNm of the limit of {LIMIT_MNM} mNm, stated risk {RISK}\n"
    );
    println!("| length of the capture | pass | fail | undecided | wrongly passed | wrongly failed |");
    println!("|---|---|---|---|---|---|");
    for (index, length) in LENGTHS.iter().enumerate() {
        let count = |verdict, within: &[bool]| {
            judged.iter().filter(|(truly, verdicts)| verdicts[index] == verdict && within.contains(truly)).count()
        };
        println!(
            "| {length} | {} | {} | {} | {} | {} |",
            count(Verdict::Pass, &[true, false]),
            count(Verdict::Fail, &[true, false]),
            count(Verdict::Undecided, &[true, false]),
            count(Verdict::Pass, &[false]),
            count(Verdict::Fail, &[true])
        );
    }
}
