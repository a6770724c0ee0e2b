//! What must hold of the plant for its captures to judge anything.

use hidden_effects::base_fit::{sliding, unexplained_rms};
use hidden_effects::capture::Capture;
use hidden_effects::draw::Draw;
use hidden_effects::effect::{Effect, catalogue, named, outside};
use hidden_effects::family::Family;
use hidden_effects::knob::{Knob, Wish};
use hidden_effects::motion::Motion;
use hidden_effects::plant::{Course, Rig, STEP_S, run};
use hidden_effects::sensors::ideal;

const RIG: Rig = Rig { rotor_inertia: 0.02, servo_hz: 60.0, servo_damping: 0.8, current_lag_s: 1e-4 };

fn knob(seed: u64, detents: bool) -> Knob {
    Knob::draw(&mut Draw::new(seed, "knob"), Wish { detents: Some(detents), ..Wish::default() })
}

fn effect(name: &str, knob: &Knob, size: f64) -> Effect {
    let kind = named(name).expect("a known name");
    let mut effect = Effect::draw(kind, knob, [-1.0, 1.0], [6.0, 4.0], &mut Draw::new(1, name));
    effect.size = size;
    effect
}

#[test]
fn a_knob_that_hides_nothing_follows_the_base_model() {
    for seed in 0..12 {
        let knob = knob(seed, seed % 2 == 0);
        let course = run(RIG, &knob, &[], &Motion::sweeps(6.0, &mut Draw::new(seed, "motion")), 6.0, 0);
        let left = unexplained_rms(&sliding(&ideal(&course, &[], 5000.0, 6.0), 5000.0), knob.detent_period);
        // The least torque noise is 0.2 mNm: a weakest effect of 0.3 times that must stand clear.
        assert!(left < 0.01, "{left} mNm of {knob:?}");
    }
}

/// Work through the sensor, and the kinetic and detent energy that the knob has in the end, both in mJ.
fn energies(course: &Course, knob: &Knob, until: usize) -> (f64, f64) {
    let work = (0..until)
        .map(|n| course.torque_mnm[n] * 0.5 * (course.velocity_rad_s[n] + course.velocity_rad_s[n + 1]) * STEP_S)
        .sum();
    let period = knob.detent_period.expect("detents");
    let potential = |n: usize| {
        -knob.detent_amplitude * period * (course.angle_rad[n] / period + knob.detent_phase.expect("detents")).cos()
    };
    let kinetic = |n: usize| 0.5 * knob.inertia * course.velocity_rad_s[n].powi(2);
    (work, kinetic(until) + potential(until) - kinetic(0) - potential(0))
}

#[test]
fn without_friction_the_work_through_the_sensor_is_the_knobs_energy() {
    for seed in 0..6 {
        let smooth = Knob {
            coulomb_negative: 0.0,
            coulomb_positive: 0.0,
            viscous_negative: 0.0,
            viscous_positive: 0.0,
            ..knob(seed, true)
        };
        let course = run(RIG, &smooth, &[], &Motion::sweeps(6.0, &mut Draw::new(seed, "motion")), 6.0, 0);
        let largest = 0.5 * smooth.inertia * 20.0_f64.powi(2);
        for until in [150_000, 310_000, 555_000] {
            let (work, energy) = energies(&course, &smooth, until);
            assert!((work - energy).abs() < 1e-3 * largest, "{work} mJ went in, {energy} mJ are there");
        }
    }
}

#[test]
fn a_knob_that_the_servo_pushes_too_weakly_stays_where_it_is() {
    let sticky = Knob { coulomb_negative: 46.0, coulomb_positive: 46.0, ..knob(3, false) };
    // A soft servo: 1 rad off it pushes with less than the friction.
    let soft = Rig { servo_hz: 0.3, ..RIG };
    let course = run(soft, &sticky, &[], &Motion::sweeps(6.0, &mut Draw::new(3, "motion")), 6.0, 0);
    assert!(course.velocity_rad_s.iter().all(|velocity| *velocity == 0.0));
    assert!(course.torque_mnm.iter().any(|torque| torque.abs() > 0.1), "the servo pushes");
}

#[test]
fn a_body_behind_a_shaft_rings_at_its_resonance() {
    let free = Knob {
        inertia: 0.1,
        coulomb_negative: 0.0,
        coulomb_positive: 0.0,
        viscous_negative: 0.0,
        viscous_positive: 0.0,
        ..knob(4, false)
    };
    let shaft = [effect("shaft-compliance", &free, 40.0)];
    // A rotor too heavy to be moved by the ring: the body swings against a wall.
    let heavy = Rig { rotor_inertia: 1000.0, ..RIG };
    let course = run(heavy, &free, &shaft, &Motion::sweeps(6.0, &mut Draw::new(4, "motion")), 6.0, 0);
    let from = 30_000;
    let late = &course.torque_mnm[from..60_000];
    let smooth = 5000;
    let wave: Vec<f64> =
        late.windows(smooth).map(|part| part[smooth / 2] - part.iter().sum::<f64>() / smooth as f64).collect();
    let crossings = wave.windows(2).filter(|pair| pair[0] < 0.0 && pair[1] >= 0.0).count();
    let frequency_hz = crossings as f64 / (wave.len() as f64 * STEP_S);
    assert!((frequency_hz - 40.0).abs() < 4.5, "{frequency_hz} Hz");
}

#[test]
fn every_effect_reaches_the_strength_asked_for() {
    for (index, kind) in catalogue().into_iter().chain(outside()).enumerate() {
        let name = kind.name;
        let capture = Capture::new(7, index, Family::Standard, name, 3.0).expect("reached");
        let ratio = capture.answer.effect_rms_mnm / capture.answer.torque_noise_rms_mnm;
        assert!((2.7..3.3).contains(&ratio), "{name}: {ratio}");
    }
}

#[test]
fn a_seed_decides_everything_and_another_seed_something_else() {
    let make = |seed| Capture::new(seed, 0, Family::TimeJitter, "backlash", 3.0).expect("reached");
    let (first, again, other) = (make(5), make(5), make(6));
    assert_eq!(first.name, again.name);
    assert_eq!(first.records[1].torque_mnm, again.records[1].torque_mnm);
    assert_ne!(first.name, other.name);
    assert_ne!(first.records[1].torque_mnm, other.records[1].torque_mnm);
}

#[test]
fn every_family_makes_captures_of_the_lengths_it_tells() {
    for family in Family::ALL {
        let capture = Capture::new(8, 0, family, "none", 1.0).expect("nothing to reach");
        let rate_hz = capture.answer.rig["rate_hz"].as_f64().expect("the answer states it");
        for record in &capture.records {
            let length_s = record.time_s.len() as f64 / rate_hz;
            assert!([3.0, 4.0, 6.0, 12.0].iter().any(|nominal_s| (nominal_s - length_s).abs() < 1e-6), "{length_s} s");
            let last = *record.time_s.last().expect("samples");
            assert!((last - length_s).abs() < 2.0 / rate_hz, "{last} s of {length_s} s");
        }
    }
}
