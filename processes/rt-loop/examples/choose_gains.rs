//! Gains of the coupling drawn at random, and how much each lets be rendered on the simulated rig.
//!
//! `cargo run --release -p rt-loop --example choose_gains -- [RATE_HZ] [DRAWS]` prints the gains in use, then the ten best of those
//! drawn gains under which no hand of the class can make a knob swing, whether the knob sticks or has an inertia up to
//! 0.42 mNm·s²/rad. The gains that carry most of a slow load come last.

#![allow(clippy::unwrap_used, clippy::print_stdout, missing_docs, reason = "a study may stop at a failure")]

#[path = "../tests/rendering/numbers.rs"]
mod numbers;

use dynamics::knobs::Fixture;
use hal::Apparatus as _;
use hal::simulated_rig::{RigParameters, SimulatedRig};
use numbers::Numbers;
use rt_loop::control::rendering::RenderGains;
use rt_loop::stability::{Bounds, Hands, LinearModel, Port};

/// Inertias that every choice must hold, mNm·s²/rad.
const INERTIAS: [f64; 5] = [0.0199, 0.05, 0.15, 0.28, 0.42];

fn main() {
    let argument =
        |index: usize, usual: f64| std::env::args().nth(index).and_then(|text| text.parse().ok()).unwrap_or(usual);
    let (rate_hz, draws) = (argument(1, 10_000.0), argument(2, 20_000.0) as usize);
    let rig = SimulatedRig::new(RigParameters::default(), Fixture::None.model().unwrap(), 1).unwrap();
    let (calibration, limits) = (&rig.description().calibration, &rig.description().limits);
    let in_use = RenderGains::at_rate(rate_hz);
    let tell = |gains: &RenderGains| {
        let bounds = Bounds::of(gains, calibration, limits, rate_hz);
        let stiffness = bounds.largest_stiffness_mnm_rad(INERTIAS[0], 0.0);
        println!("{:6.1}  largest stiffness {stiffness:4.0} mNm/rad  {gains:?}", carried(gains));
    };
    tell(&in_use);
    let mut numbers = Numbers(1);
    let mut safe: Vec<RenderGains> = Vec::new();
    for _ in 0..draws {
        let damping = numbers.between(15.0, 75.0);
        let gains = RenderGains {
            stiffness_mnm_rad: damping * numbers.between(30.0, 240.0),
            damping,
            slow_edge_hz: numbers.between(15.0, 240.0),
            slow_damping: numbers.between(0.7, 5.6),
            notch_hz: numbers.between(800.0, 2_500.0),
            notch_depth: numbers.between(0.02, 1.0),
            notch_width: numbers.between(0.3, 4.8),
            ..in_use
        };
        let port = Port::new(gains, calibration, rate_hz);
        let holds = |inertia: f64| {
            let wheel = LinearModel::Sliding { inertia, damping: 0.0, stiffness_mnm_rad: 0.0 };
            port.is_safe(&wheel, &Hands::default())
        };
        if port.is_safe(&LinearModel::Stuck, &Hands::default()) && INERTIAS.into_iter().all(holds) {
            safe.push(gains);
        }
    }
    safe.sort_by(|one, other| carried(one).total_cmp(&carried(other)));
    safe.iter().rev().take(10).rev().for_each(tell);
}

/// How much of a load that changes slowly does not bend the coupling: the edge of what bends it, times a root of its stiffness.
fn carried(gains: &RenderGains) -> f64 {
    gains.slow_edge_hz * gains.slow_damping * (gains.stiffness_mnm_rad / 7_000.0).sqrt()
}
