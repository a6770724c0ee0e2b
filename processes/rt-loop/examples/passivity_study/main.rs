//! How knobs behave in hands, inside the bounds of what is rendered and beyond them.
//!
//! `cargo run --release -p rt-loop --example passivity_study -- [KNOBS] [RATE_HZ] [cogging]`
//!
//! With `cogging` on a motor that cogs, its cogging taken out, and inside the bounds alone.

#![allow(clippy::unwrap_used, clippy::print_stdout, missing_docs, dead_code, reason = "a study may stop at a failure")]

#[path = "../../tests/rendering/held_knob.rs"]
mod held_knob;
#[path = "../../tests/rendering/numbers.rs"]
mod numbers;
#[path = "../../tests/rendering/passivity.rs"]
mod passivity;
#[path = "../../tests/rendering/random_knob.rs"]
mod random_knob;

use dynamics::Model;
use hal::simulated_rig::{Cogging, Hand};
use rt_loop::control::rendering::RenderGains;
use rt_loop::stability::Firmness;

fn main() {
    let argument =
        |index: usize, usual: f64| std::env::args().nth(index).and_then(|text| text.parse().ok()).unwrap_or(usual);
    let (knobs, rate_hz) = (argument(1, 1000.0), argument(2, 10_000.0));
    if std::env::args().nth(3).is_some_and(|motor| motor == "cogging") {
        inside("one body", passivity::inside, knobs, rate_hz, &passivity::SLOTTED);
    } else {
        inside("one body", passivity::inside, knobs, rate_hz, &[]);
        inside("a gap or a shaft", passivity::inside_with_two_bodies, knobs, rate_hz, &[]);
        outside();
    }
}

fn inside(what: &str, drawn: impl Fn(u64, f64) -> (Model, Hand), knobs: f64, rate_hz: f64, cogging: &[Cogging]) {
    let Some(Firmness { gains, .. }) = passivity::firmness(rate_hz) else {
        println!("the rig renders nothing at {rate_hz} Hz");
        return;
    };
    let (mut grown, mut given_out, mut guarded) = (0, Vec::new(), 0);
    for seed in 0..knobs as u64 {
        let (model, hand) = drawn(seed, rate_hz);
        let seen = passivity::behaviour_on(cogging, &model, gains, hand, rate_hz, seed);
        if passivity::grew(&seen) {
            grown += 1;
            println!("  seed {seed}: {seen:?}");
        }
        guarded += u32::from(seen.guarded > 0);
        given_out.push((-seen.least_energy).max(0.0));
    }
    given_out.sort_by(f64::total_cmp);
    let at = |share: f64| given_out[((given_out.len() - 1) as f64 * share) as usize];
    println!(
        "inside the bounds, {knobs} knobs with {what} and hands at {rate_hz} Hz: {grown} swings grow, the guard acts in {guarded}"
    );
    println!(
        "energy given out beyond what was put in, mNm·rad: median {:.2e}, 99 % {:.2e}, largest {:.2e} (slack {})",
        at(0.5),
        at(0.99),
        at(1.0),
        passivity::SLACK
    );
}

fn outside() {
    let gains = RenderGains::at_rate(10_000.0);
    let bounds = passivity::bounds(10_000.0);
    let grips = passivity::edge_of_the_class();
    println!(
        "in {} grips at the edge of the class, 10 kHz: swings that grow, without the guard and with it",
        grips.len()
    );
    let row = |what: String, inertia: f64, stiffness_mnm_rad: f64, gains: RenderGains| {
        let cells = [f64::INFINITY, gains.slack].map(|slack| {
            let gains = RenderGains { slack, ..gains };
            let seen = grips.iter().map(|grip| passivity::wheel(inertia, stiffness_mnm_rad, gains, *grip));
            let seen: Vec<_> = seen.collect();
            let grown = seen.iter().filter(|seen| passivity::grew(seen)).count();
            let least = seen.iter().map(|seen| seen.least_energy).fold(f64::INFINITY, f64::min);
            format!("{grown:2}, {:8.2e} mNm·rad given out", (-least).max(0.0))
        });
        println!("  {what}: {}; {}", cells[0], cells[1]);
    };
    for times in [0.3, 1.0, 2.0, 4.0, 10.0, 30.0] {
        let inertia = bounds.largest_inertia(0.0);
        row(format!("{times:4.1} times the largest inertia, {inertia:.3} mNm·s²/rad"), times * inertia, 0.0, gains);
    }
    for times in [1.0, 4.0, 16.0, 64.0] {
        let stiffness = bounds.largest_stiffness_mnm_rad(0.035, 0.0);
        row(
            format!("{times:4.1} times the largest stiffness, {stiffness:.0} mNm/rad"),
            0.035,
            times * stiffness,
            gains,
        );
    }
    println!("detents without friction, pushed and let go: energy soon after and two seconds later, without the guard");
    for times in [0.5, 1.0, 1.25, 1.5, 2.0, 4.0, 8.0, 16.0] {
        let stiffness = bounds.largest_stiffness_mnm_rad(0.035, 0.0);
        let [before, after] = passivity::let_go(times * stiffness, RenderGains { slack: f64::INFINITY, ..gains });
        println!("  {times:5.2} times the largest stiffness, {stiffness:.0} mNm/rad: {before:.4}, {after:.4} mNm·rad");
    }
    for times in [2.0, 4.0, 8.0, 16.0] {
        let stiffer =
            RenderGains { stiffness_mnm_rad: times * gains.stiffness_mnm_rad, damping: times * gains.damping, ..gains };
        row(format!("coupling {times:4.1} times as stiff"), 0.05, 0.0, stiffer);
    }
}
