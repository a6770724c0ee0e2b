//! A rendering follows from its recording: fed through again it gives the same torques.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
#![allow(clippy::print_stdout, reason = "figures for who asks for them")]

mod common;

use common::Bench;
use hal::Measurement;
use rt_loop::control::Request;
use rt_loop::control::rendering::RenderedModel;
use shared_types::wire::WireMessage as _;
use shared_types::{LoopState, Sample};

/// Ticks at which models are sent: the second while the first still gives way to it.
const SENT: [u64; 2] = [9_000, 10_000];

/// Longer than one model gives way to the next.
const FADE_TICKS: u64 = 3_000;
/// Tick at which a knob that slides changes over to another.
const CHANGED: u64 = 9_000;

/// The models that are changed over to.
fn models(bench: &Bench) -> [Box<RenderedModel>; 2] {
    [bench.two_bodies(), bench.tuned("friction", 1, 6.0)]
}

/// What a recorder would have of a rendering with stalls and two changes of its model.
fn recorded() -> Vec<Sample> {
    let mut bench = Bench::new();
    let mut waiting: Vec<_> = SENT.into_iter().zip(models(&bench)).collect();
    bench.start();
    let mut samples = Vec::new();
    let mut tick = 0;
    while bench.control.state() == LoopState::Running {
        // A stall now and then, of 2 to 6 ticks.
        let elapsed_ticks = if samples.len() % 997 == 500 { 2 + samples.len() as u64 % 5 } else { 1 };
        let measurement = bench.read(elapsed_ticks);
        if waiting.first().is_some_and(|(sent, _)| tick >= *sent) {
            bench.control.take_model(waiting.remove(0).1).unwrap();
        }
        let output = bench.step(elapsed_ticks, measurement);
        bench.write(&output);
        drop(bench.control.retired_model());
        let sample: Sample = output.sample.unwrap();
        tick = sample.tick;
        samples.push(sample);
    }
    samples
}

#[test]
fn a_recording_fed_through_again_gives_the_same_torques_bit_for_bit() {
    let recorded = recorded();
    let felt: Vec<u64> =
        recorded.iter().filter(|sample| sample.flags & Sample::MODEL_TAKEN != 0).map(|sample| sample.tick).collect();
    assert!(
        felt.len() == 2 && felt[0] >= SENT[0] && felt[1] > SENT[1] + 1_000,
        "both models, one after the other: {felt:?}"
    );
    let stalls = recorded.iter().filter(|sample| sample.missed_ticks > 0).count();
    assert!(stalls > 20, "{stalls} stalls");
    assert!(recorded.iter().any(|sample| sample.flags & Sample::STUCK != 0), "it sticks at times");
    assert!(recorded.iter().any(|sample| sample.flags & Sample::STUCK == 0), "and slides");

    let mut again = Bench::new();
    let mut models = models(&again).into_iter();
    again.step(1, measured(&recorded[0]));
    assert!(again.control.request(Request::Start));
    for sample in &recorded {
        if sample.flags & Sample::MODEL_TAKEN != 0 {
            again.control.take_model(models.next().unwrap()).unwrap();
        }
        let output = again.step(u64::from(sample.missed_ticks) + 1, measured(sample));
        drop(again.control.retired_model());
        assert_eq!(output.torque_mnm.to_bits(), sample.commanded_torque_mnm.to_bits(), "tick {}", sample.tick);
        assert_eq!(output.sample.unwrap().wire_bytes(), sample.wire_bytes(), "tick {}", sample.tick);
    }
    assert_ne!(again.control.state(), LoopState::Running, "the run ends where it ended");
}

#[test]
fn a_model_gives_way_to_the_next_without_a_step_in_torque() {
    // Readings without noise or steps, and knobs that never stick: every step is the change's. Beside it the same
    // without the change.
    let reading = |tick: u64| Measurement {
        angle_rad: 0.5 * (std::f64::consts::TAU * tick as f64 / 10_000.0).sin(),
        ..Measurement::default()
    };
    let (mut with, mut without) = (Bench::new(), Bench::new());
    for bench in [&mut with, &mut without] {
        bench.step(1, reading(0));
        assert!(bench.control.request(Request::Start));
        let first = bench.sliding(0.05, 0.5, 1.0);
        bench.control.take_model(first).unwrap();
    }
    let (mut largest_mnm, mut peak_mnm, mut before_mnm) = (0.0_f64, 0.0_f64, 0.0);
    for tick in 0..CHANGED + FADE_TICKS {
        if tick == CHANGED {
            let second = with.sliding(0.1, 2.0, 4.0);
            with.control.take_model(second).unwrap();
        }
        let [one_mnm, other_mnm] = [&mut with, &mut without].map(|bench| bench.step(1, reading(tick)).torque_mnm);
        let difference_mnm = one_mnm - other_mnm;
        assert!(tick > CHANGED || difference_mnm == 0.0, "alike up to the change");
        largest_mnm = largest_mnm.max((difference_mnm - before_mnm).abs());
        peak_mnm = peak_mnm.max(one_mnm.abs());
        before_mnm = difference_mnm;
    }
    println!("largest step while one gives way to the other {largest_mnm:.4} mNm, peak torque {peak_mnm:.1} mNm");
    // Changed over at once it would be four times as much as this bar.
    assert!(largest_mnm > 0.0 && largest_mnm < 0.001 * peak_mnm, "{largest_mnm} mNm of {peak_mnm} mNm");
}

fn measured(sample: &Sample) -> Measurement {
    Measurement {
        angle_rad: sample.angle_rad,
        torque_mnm: sample.torque_mnm,
        acceleration_rad_s2: Some(sample.acceleration_rad_s2),
        contact: None,
        after_s: sample.measured_after_s,
        is_stale: sample.flags & Sample::STALE != 0,
        stale_code: 0,
    }
}
