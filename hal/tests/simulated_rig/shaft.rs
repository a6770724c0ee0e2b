//! The two masses: resonance, energy, and knobs that are hard to integrate.

use dynamics::{Effect, Model, effects, knobs};
use hal::Apparatus;
use hal::simulated_rig::{RigParameters, Truth};

use super::{Run, assert_close, flywheel, frictionless_motor};

#[test]
fn the_shaft_rings_at_the_resonance_of_two_masses_and_a_spring() {
    for knob_inertia in [0.0, 0.0019, 0.035, 0.28] {
        let parameters = RigParameters { torque_sensor_damping: 0.0, ..frictionless_motor() };
        let load = parameters.gripper_inertia + knob_inertia;
        let inverse_inertia = 1.0 / parameters.motor_inertia() + 1.0 / load;
        let expected_hz = (parameters.torque_sensor_stiffness_mnm_rad * inverse_inertia).sqrt() / std::f64::consts::TAU;
        let mut run = Run::new(parameters, flywheel(knob_inertia), 100_000);
        run.ticks(20, 50.0);
        run.rig.disable();
        run.ticks(100, 0.0);

        let mut crossings_s = Vec::new();
        let mut before: Option<(f64, f64)> = None;
        for _ in 0..20_000 {
            run.tick(0.0);
            let truth = run.rig.truth();
            let now = (truth.time_s, truth.motor_velocity_rad_s - truth.knob_velocity_rad_s);
            if let Some(before) = before
                && before.1 < 0.0
                && now.1 >= 0.0
            {
                crossings_s.push(before.0 + (now.0 - before.0) * before.1 / (before.1 - now.1));
            }
            before = Some(now);
        }
        let periods = (crossings_s.len() - 1) as f64;
        let measured_hz = periods / (crossings_s.last().unwrap() - crossings_s[0]);
        println!("knob inertia {knob_inertia}: {measured_hz:.1} Hz, analytic {expected_hz:.1} Hz");
        assert_close(measured_hz / expected_hz, 1.0, 0.003, "the resonance over the analytic one");
    }
}

/// Kinetic energy, spring energy and that of the detents, mJ.
fn energy(truth: &Truth, parameters: &RigParameters, knob: &Model) -> f64 {
    let load = parameters.gripper_inertia + knob.inertia();
    let twist_rad = truth.motor_angle_rad - truth.knob_angle_rad;
    let detents = knob.effect("detent").map_or(0.0, |detent| {
        let [amplitude, period, phase] = detent.values() else { panic!("a detent has three values") };
        amplitude * period * (1.0 - (truth.knob_angle_rad / period + phase).cos())
    });
    0.5 * parameters.motor_inertia() * truth.motor_velocity_rad_s.powi(2)
        + 0.5 * load * truth.knob_velocity_rad_s.powi(2)
        + 0.5 * parameters.torque_sensor_stiffness_mnm_rad * twist_rad * twist_rad
        + detents
}

#[test]
fn with_the_motor_off_energy_only_falls() {
    for number in [4, 5] {
        let knob = knobs::paper_knob(number).unwrap();
        let parameters = RigParameters::default();
        let mut run = Run::new(parameters.clone(), knob.clone(), 100_000);
        run.ticks(3000, 320.0);
        run.rig.disable();
        run.ticks(100, 0.0);
        let at_start = energy(&run.rig.truth(), &parameters, &knob);
        let (mut least, mut largest_rise) = (at_start, 0.0_f64);
        for _ in 0..100_000 {
            run.tick(0.0);
            let now = energy(&run.rig.truth(), &parameters, &knob);
            largest_rise = largest_rise.max(now - least);
            least = least.min(now);
        }
        println!("knob {number}: {at_start:.4} falls to {least:.4}, largest rise {largest_rise:.2e}");
        assert!(least < 0.9 * at_start, "knob {number} must lose energy");
        assert!(largest_rise < 1e-5 * (at_start - least), "knob {number}: energy rose by {largest_rise}");
    }
}

#[test]
fn without_losses_energy_stays_for_thousands_of_periods() {
    let parameters = RigParameters { torque_sensor_damping: 0.0, ..frictionless_motor() };
    let knob = flywheel(0.035);
    let mut run = Run::new(parameters.clone(), knob.clone(), 100_000);
    run.ticks(20, 100.0);
    run.rig.disable();
    run.ticks(100, 0.0);
    let at_start = energy(&run.rig.truth(), &parameters, &knob);
    run.ticks(500_000, 0.0);
    assert_close(
        energy(&run.rig.truth(), &parameters, &knob) / at_start,
        1.0,
        1e-9,
        "energy after 5 s over energy before",
    );
}

#[test]
fn a_knob_whose_friction_falls_with_speed_runs_away_only_to_the_rigs_speed_limit() {
    // Knob 1 when turning positively: 46 − 4.5·θ̇ mNm drives beyond 10.2 rad/s.
    let knob = knobs::paper_knob(1).unwrap();
    let mut run = Run::new(RigParameters::default(), knob, 10_000);
    while run.rig.truth().knob_velocity_rad_s < 15.0 {
        run.tick(200.0);
    }
    run.rig.disable();
    run.ticks(200, 0.0);
    assert!(run.rig.truth().knob_velocity_rad_s > 15.0, "the model's friction drives, and so must the rig's");
    run.ticks(100_000, 0.0);
    let speed_rad_s = run.rig.truth().knob_velocity_rad_s;
    assert!((0.0..61.0).contains(&speed_rad_s), "speed is {speed_rad_s} rad/s");
}

#[test]
fn a_drag_as_stiff_as_a_stop_does_not_make_the_integration_diverge() {
    let drag = Model {
        effects: vec![
            Effect::new(&effects::friction::KIND, &[20.0, 20.0, 300.0, 300.0]),
            Effect::new(&effects::detent::KIND, &[300.0, 0.01, 0.0]),
        ],
        ..flywheel(0.0)
    };
    let mut run = Run::new(RigParameters::default(), drag, 10_000);
    for tick in 0..20_000_u32 {
        run.tick(if tick % 2000 < 1000 { 300.0 } else { -300.0 });
        let truth = run.rig.truth();
        assert!(truth.knob_velocity_rad_s.abs() < 10.0, "{truth:?}");
    }
}
