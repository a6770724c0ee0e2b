//! Forward simulation against closed solutions and against itself at other step sizes.

use dynamics::simulate::{ForwardSimulation, SimulationError};
use dynamics::{Model, knobs};

use crate::model;

/// Angle and velocity after driving `knob` for `duration_s` with `torque(t)` in steps of `step_s`.
fn driven(knob: &Model, duration_s: f64, step_s: f64, torque: impl Fn(f64) -> f64) -> (f64, f64) {
    let mut simulation = ForwardSimulation::at_rest(knob, 0.0, 0.0).unwrap();
    let steps = (duration_s / step_s).round() as usize;
    for index in 0..steps {
        let now = index as f64 * step_s;
        simulation.advance(step_s, torque(now), torque(now + step_s)).unwrap();
    }
    let motion = simulation.motion(torque(duration_s));
    (motion.angle_rad, motion.velocity_rad_s)
}

#[test]
fn a_knob_with_viscous_friction_approaches_its_final_speed_exponentially() {
    let (inertia, coulomb, viscous, torque) = (0.05, 2.0, 0.5, 10.0);
    let knob = model(&[("inertia", &[inertia]), ("friction", &[coulomb, coulomb, viscous, viscous])]);
    let (_, velocity) = driven(&knob, 0.3, 1e-4, |_| torque);
    let exact = (torque - coulomb) / viscous * (1.0 - (-viscous / inertia * 0.3_f64).exp());
    assert!((velocity - exact).abs() < 1e-9 * exact, "{velocity} against {exact}");
}

#[test]
fn a_knob_coasts_to_rest_where_coulomb_friction_has_taken_its_energy() {
    let knob = model(&[("inertia", &[0.1]), ("friction", &[3.0, 3.0, 0.0, 0.0])]);
    let mut simulation = ForwardSimulation::at_rest(&knob, 0.0, 0.0).unwrap();
    // 1 s at 13 mNm: 100 rad/s and 50 rad; then without torque v²·M/2C = 166.67 rad more.
    for step in 0..60_000 {
        let torque = if step < 10_000 { 13.0 } else { 0.0 };
        simulation.advance(1e-4, torque, torque).unwrap();
    }
    let motion = simulation.motion(0.0);
    assert_eq!(motion.velocity_rad_s, 0.0);
    let exact = 50.0 + 100.0 * 100.0 * 0.1 / 6.0;
    assert!((motion.angle_rad - exact).abs() < 1e-6, "{} against {exact}", motion.angle_rad);
}

#[test]
fn a_knob_at_rest_holds_below_its_static_friction_and_breaks_away_at_it() {
    let knob = knobs::paper_knob(1).unwrap();
    let (angle, _) = driven(&knob, 2.0, 1e-4, |_| 149.9);
    assert_eq!(angle, 0.0, "held for two seconds without creeping");
    // A ramp of 100 mNm/s passes 150 mNm at 1.5 s.
    let mut simulation = ForwardSimulation::at_rest(&knob, 0.0, 0.0).unwrap();
    let mut broke_away = None;
    for index in 0..20_000 {
        let now = f64::from(index) * 1e-4;
        simulation.advance(1e-4, 100.0 * now, 100.0 * (now + 1e-4)).unwrap();
        if !simulation.is_stuck() && broke_away.is_none() {
            broke_away = Some(now + 1e-4);
        }
    }
    assert!((broke_away.unwrap() - 1.5).abs() < 2e-4, "{broke_away:?}");
}

#[test]
fn the_motion_does_not_depend_on_the_step_size_up_to_200_microseconds() {
    for number in 1..=5 {
        let knob = knobs::paper_knob(number).unwrap();
        let static_mnm = knob.parameter("static_positive").unwrap();
        let torque = |t: f64| 1.6 * static_mnm * (std::f64::consts::TAU * 2.0 * t).sin();
        // The torque itself is a polygon with corners at the steps; corners 200 µs apart for all.
        let polygon = |t: f64| {
            let corner = (t / 2e-4 + 1e-9).floor() * 2e-4;
            let fraction = (t - corner) / 2e-4;
            torque(corner) * (1.0 - fraction) + torque(corner + 2e-4) * fraction
        };
        let (coarse, _) = driven(&knob, 0.4, 2e-4, polygon);
        let (fine, _) = driven(&knob, 0.4, 1e-5, polygon);
        assert!((coarse - fine).abs() < 1e-5 * (1.0 + fine.abs()), "knob {number}: {coarse} against {fine}");
    }
}

#[test]
fn a_detent_without_friction_swings_at_its_natural_frequency() {
    let (inertia, amplitude, period) = (0.049, 11.0, 0.076);
    let knob = model(&[("inertia", &[inertia]), ("detent", &[amplitude, period, 0.0])]);
    let omega = (amplitude / (period * inertia)).sqrt();
    // A small constant torque makes it swing about its shifted rest: θ = (τ/k)·(1 − cos ωt).
    let (torque, stiffness) = (0.01, amplitude / period);
    let (angle, _) = driven(&knob, 0.25, 1e-4, |_| torque);
    let exact = torque / stiffness * (1.0 - (omega * 0.25).cos());
    assert!((angle - exact).abs() < 1e-5 * exact.abs(), "{angle} against {exact}");
}

#[test]
fn a_knob_without_inertia_is_refused() {
    let knob = model(&[("friction", &[1.0, 1.0, 0.0, 0.0])]);
    let error = ForwardSimulation::at_rest(&knob, 0.0, 0.0).unwrap_err();
    assert_eq!(error, SimulationError::NoInertia { inertia: 0.0 });
}
