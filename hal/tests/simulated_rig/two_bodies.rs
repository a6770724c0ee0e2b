//! Knobs with something that gives way inside: lost motion, a shaft that twists, bristles.

use dynamics::{Effect, Model, effects, knobs};
use hal::Apparatus;
use hal::simulated_rig::{RigParameters, Truth};

use super::{Run, assert_close, flywheel, frictionless_motor};

const INERTIA: f64 = 0.02;
const INNER_SHARE: f64 = 0.6;
const STIFFNESS_MNM_RAD: f64 = 5e4;

/// A knob of two bodies with the gap and damping given, and further effects on the inner one.
fn loose(half_gap_rad: f64, damping: f64, further: &[Effect]) -> Model {
    let backlash = Effect::new(&effects::backlash::KIND, &[half_gap_rad, INNER_SHARE, STIFFNESS_MNM_RAD, damping]);
    let mut model = flywheel(INERTIA);
    model.effects.push(backlash);
    model.effects.extend_from_slice(further);
    model
}

fn friction(values: [f64; 4]) -> Effect {
    Effect::new(&effects::friction::KIND, &values)
}

#[test]
fn a_gap_is_crossed_without_torque() {
    let half_gap_rad = 0.2;
    let parameters = frictionless_motor();
    let cap_inertia = parameters.gripper_inertia + (1.0 - INNER_SHARE) * INERTIA;
    let mut run = Run::new(parameters, loose(half_gap_rad, 0.5, &[friction([5.0, 5.0, 0.0, 0.0])]), 100_000);
    let mut crossed_rad = 0.0;
    while run.rig.truth().knob_angle_rad < 0.99 * half_gap_rad {
        run.tick(3.0);
        let truth = run.rig.truth();
        // All that the sensor carries is what it takes to speed up gripper and cap.
        let inertial_mnm = cap_inertia * truth.knob_acceleration_rad_s2;
        assert_close(truth.sensor_torque_mnm, inertial_mnm, 1e-6, "the sensor's torque in mNm");
        assert_eq!(truth.inner_angle_rad.to_bits(), 0.0_f64.to_bits(), "the inner body moved");
        crossed_rad = truth.knob_angle_rad;
    }
    assert!(crossed_rad > 0.9 * half_gap_rad);
    run.ticks(30_000, 30.0);
    let truth = run.rig.truth();
    let ahead_rad = truth.knob_angle_rad - truth.inner_angle_rad;
    assert!(truth.inner_velocity_rad_s > 0.0, "the cap takes the inner body along: {truth:?}");
    assert_close(ahead_rad, half_gap_rad, 0.01 * half_gap_rad, "the cap's lead in rad");
}

/// Turns the motor at a constant speed for a while; gives the sensor's mean torque over the last part of it.
fn torque_at(run: &mut Run, speed_rad_s: f64) -> f64 {
    let (mut sum, mut count, mut integral_mnm) = (0.0, 0.0, 0.0);
    for tick in 0..20_000 {
        let behind_rad_s = speed_rad_s - run.rig.truth().motor_velocity_rad_s;
        integral_mnm += 0.02 * behind_rad_s;
        run.tick(2.0 * behind_rad_s + integral_mnm);
        if tick >= 15_000 {
            sum += run.rig.truth().sensor_torque_mnm;
            count += 1.0;
        }
    }
    sum / count
}

#[test]
fn at_a_constant_speed_the_contact_passes_on_the_inner_bodys_friction() {
    let mut run = Run::new(frictionless_motor(), loose(0.02, 1.0, &[friction([8.0, 12.0, 3.0, 2.0])]), 10_000);
    for (speed_rad_s, expected_mnm) in [(2.0, 12.0 + 2.0 * 2.0), (-1.5, -8.0 - 3.0 * 1.5), (0.5, 12.0 + 2.0 * 0.5)] {
        let torque_mnm = torque_at(&mut run, speed_rad_s);
        println!("{torque_mnm:.5} mNm at {speed_rad_s} rad/s, expected {expected_mnm}");
        assert_close(torque_mnm, expected_mnm, 2e-3, "the sensor's torque in mNm");
    }
}

/// Energy of both springs and all three bodies, mJ.
fn energy(truth: &Truth, parameters: &RigParameters, knob: &Model) -> f64 {
    let coupling = knob.effect("backlash").unwrap().values().to_vec();
    let [half_gap_rad, share, stiffness, _] = coupling[..] else { panic!("backlash has four values") };
    let twist_rad = truth.motor_angle_rad - truth.knob_angle_rad;
    let beyond_rad = ((truth.knob_angle_rad - truth.inner_angle_rad).abs() - half_gap_rad).max(0.0);
    let cap_inertia = parameters.gripper_inertia + (1.0 - share) * knob.inertia();
    let detents = knob.effect("detent").map_or(0.0, |detent| {
        let [amplitude, period, phase] = detent.values() else { panic!("a detent has three values") };
        amplitude * period * (1.0 - (truth.inner_angle_rad / period + phase).cos())
    });
    0.5 * parameters.motor_inertia() * truth.motor_velocity_rad_s.powi(2)
        + 0.5 * cap_inertia * truth.knob_velocity_rad_s.powi(2)
        + 0.5 * share * knob.inertia() * truth.inner_velocity_rad_s.powi(2)
        + 0.5 * parameters.torque_sensor_stiffness_mnm_rad * twist_rad * twist_rad
        + 0.5 * stiffness * beyond_rad * beyond_rad
        + detents
}

#[test]
fn bodies_that_bounce_in_their_gap_never_gain_energy() {
    let parameters = RigParameters { torque_sensor_damping: 0.0, ..frictionless_motor() };
    let detent = Effect::new(&effects::detent::KIND, &[10.0, 0.1, 0.0]);
    // The largest rise that is left to rounding, and, where detents act, to their explicit integration.
    let cases: [(&str, f64, &[Effect], f64); 3] = [
        ("without any loss", 0.0, &[], 1e-9),
        ("with a contact that damps", 0.5, &[], 1e-9),
        ("with detents and friction", 0.5, &[detent, friction([0.5, 0.5, 0.0, 0.0])], 1e-5),
    ];
    for (what, damping, further, tolerance) in cases {
        let knob = loose(0.003, damping, further);
        let mut run = Run::new(parameters.clone(), knob.clone(), 100_000);
        run.ticks(3000, 60.0);
        run.rig.disable();
        run.ticks(100, 0.0);
        let at_start = energy(&run.rig.truth(), &parameters, &knob);
        let (mut least, mut largest_rise) = (at_start, 0.0_f64);
        let (mut side, mut meetings) = (0.0, 0);
        for _ in 0..200_000 {
            run.tick(0.0);
            let truth = run.rig.truth();
            let ahead_rad = truth.knob_angle_rad - truth.inner_angle_rad;
            if ahead_rad.abs() > 0.003 && ahead_rad * side <= 0.0 {
                (side, meetings) = (ahead_rad, meetings + 1);
            }
            let now = energy(&truth, &parameters, &knob);
            largest_rise = largest_rise.max(now - least);
            least = least.min(now);
        }
        println!(
            "{what}: {at_start:.5} falls to {least:.5} over {meetings} changes of side, largest rise {largest_rise:.1e}"
        );
        assert!(meetings >= 2, "{what}: the bodies met {meetings} times");
        assert!(largest_rise <= tolerance * at_start, "{what}: energy rose by {largest_rise} of {at_start}");
    }
}

#[test]
fn an_inner_body_sticks_exactly_while_the_cap_goes_through_its_gap() {
    let knob = knobs::paper_knob(5).unwrap();
    let half_gap_rad = knob.parameter("backlash_half_gap").unwrap();
    let mut run = Run::new(RigParameters::default(), knob, 10_000);
    let (mut rests, mut resting_travel_rad) = (0, 0.0_f64);
    let mut rest: Option<(f64, f64)> = None;
    for _ in 0..40_000 {
        let wanted_rad = 0.4 * (5.0 * run.time_s()).sin();
        let truth = run.rig.truth();
        run.tick(3000.0 * (wanted_rad - truth.motor_angle_rad) - 10.0 * truth.motor_velocity_rad_s);
        let truth = run.rig.truth();
        assert_eq!(truth.knob_stuck, truth.inner_velocity_rad_s == 0.0, "stuck means at rest: {truth:?}");
        rest = match (rest, truth.knob_stuck) {
            (_, false) => None,
            (None, true) => {
                rests += 1;
                Some((truth.inner_angle_rad, truth.knob_angle_rad))
            }
            (Some((inner_rad, cap_rad)), true) => {
                resting_travel_rad = resting_travel_rad.max((truth.knob_angle_rad - cap_rad).abs());
                // It may have broken away and come to rest again between two ticks, but not crept.
                let moved = truth.inner_angle_rad.to_bits() != inner_rad.to_bits();
                Some(if moved { (truth.inner_angle_rad, truth.knob_angle_rad) } else { (inner_rad, cap_rad) })
            }
        };
    }
    println!("{rests} rests, the cap turned by up to {resting_travel_rad:.4} rad over one of them");
    assert!(rests >= 5, "the inner body came to rest {rests} times");
    assert!(resting_travel_rad > half_gap_rad, "the cap must have turned while the inner body rested");
}

#[test]
fn a_shaft_that_twists_rings_at_the_resonance_of_three_bodies() {
    for (stiffness_mnm_rad, inertia) in [(2000.0, 0.1), (20_000.0, 0.035)] {
        let parameters = RigParameters { torque_sensor_damping: 0.0, ..frictionless_motor() };
        let (m1, m2, m3) = (parameters.motor_inertia(), parameters.gripper_inertia, inertia);
        let (k1, k2) = (parameters.torque_sensor_stiffness_mnm_rad, stiffness_mnm_rad);
        // ω⁴ − b·ω² + c = 0 for three bodies on two springs; the slower one.
        let b = k1 * (1.0 / m1 + 1.0 / m2) + k2 * (1.0 / m2 + 1.0 / m3);
        let c = k1 * k2 * (m1 + m2 + m3) / (m1 * m2 * m3);
        let expected_hz = (2.0 * c / (b + (b * b - 4.0 * c).sqrt())).sqrt() / std::f64::consts::TAU;
        let mut knob = flywheel(inertia);
        knob.effects.push(Effect::new(&effects::shaft_compliance::KIND, &[stiffness_mnm_rad, 0.0]));
        let mut run = Run::new(parameters, knob, 10_000);
        // Laid on and taken off slowly enough not to wake the torque sensor's own resonance.
        for tick in 0..400 {
            run.tick(40.0 * (f64::from(tick) / 400.0 * std::f64::consts::PI).sin());
        }
        run.rig.disable();
        run.ticks(10, 0.0);
        let mut crossings_s = Vec::new();
        let mut before: Option<(f64, f64)> = None;
        for _ in 0..10_000 {
            run.tick(0.0);
            let truth = run.rig.truth();
            let now = (truth.time_s, truth.knob_angle_rad - truth.inner_angle_rad);
            if let Some(before) = before
                && before.1 < 0.0
                && now.1 >= 0.0
            {
                crossings_s.push(before.0 + (now.0 - before.0) * before.1 / (before.1 - now.1));
            }
            before = Some(now);
        }
        let measured_hz = (crossings_s.len() - 1) as f64 / (crossings_s.last().unwrap() - crossings_s[0]);
        println!("{stiffness_mnm_rad} mNm/rad: {measured_hz:.2} Hz, analytic {expected_hz:.2} Hz");
        assert_close(measured_hz / expected_hz, 1.0, 0.003, "the resonance over the analytic one");
    }
}

#[test]
fn a_stiff_contact_and_a_light_inner_body_do_not_make_the_integration_diverge() {
    for (half_gap_rad, share, stiffness, damping) in
        [(0.01, 0.02, 1e7, 0.0), (0.001, 0.98, 1e7, 50.0), (1e-5, 0.5, 1e6, 0.0)]
    {
        let mut knob = knobs::paper_knob(5).unwrap();
        let values = [half_gap_rad, share, stiffness, damping];
        for effect in &mut knob.effects {
            if effect.kind().name == "backlash" {
                effect.values_mut().copy_from_slice(&values);
            }
        }
        let parameters = RigParameters::default();
        // The motor itself cannot turn faster.
        let no_load_rad_s = 1e3 * parameters.supply_v / parameters.torque_constant_mnm_a;
        let mut run = Run::new(parameters, knob, 10_000);
        for tick in 0..20_000_u32 {
            run.tick(if tick % 2000 < 1000 { 355.0 } else { -355.0 });
            let truth = run.rig.truth();
            let speed_rad_s = truth.inner_velocity_rad_s.abs().max(truth.knob_velocity_rad_s.abs());
            assert!(speed_rad_s < no_load_rad_s, "{values:?}: {truth:?}");
        }
    }
}

/// A knob whose friction of `coulomb_mnm` builds up over `deflection_rad`.
fn bristly(coulomb_mnm: f64, deflection_rad: f64) -> Model {
    let mut knob = flywheel(INERTIA);
    knob.effects.push(friction([coulomb_mnm, coulomb_mnm, 0.0, 0.0]));
    knob.effects.push(Effect::new(&effects::presliding_hysteresis::KIND, &[deflection_rad, 0.2]));
    knob
}

#[test]
fn bristles_build_friction_up_as_dahls_solution_says() {
    let (coulomb_mnm, deflection_rad) = (20.0, 0.004);
    let mut run = Run::new(frictionless_motor(), bristly(coulomb_mnm, deflection_rad), 10_000);
    // There, back and there again, so slowly that inertia is nothing: 0.02 rad in 2 s.
    let (mut turning_rad, mut at_turn, mut way) = (0.0, 0.0, 1.0);
    let mut worst_mnm = 0.0_f64;
    for (leg, from_rad) in [0.0, 0.02, 0.0].into_iter().enumerate() {
        for tick in 0..20_000 {
            let wanted_rad = from_rad + way * 0.02 * f64::from(tick) / 20_000.0;
            let truth = run.rig.truth();
            run.tick(2e4 * (wanted_rad - truth.motor_angle_rad) - 30.0 * truth.motor_velocity_rad_s);
            let truth = run.rig.truth();
            let turned_rad = way * (truth.knob_angle_rad - turning_rad);
            if turned_rad < 0.0 {
                // It has not turned round yet.
                at_turn = -way + (at_turn + way) * (turned_rad / deflection_rad).exp();
                turning_rad = truth.knob_angle_rad;
            } else if tick > 1000 {
                let bent = way + (at_turn - way) * (-turned_rad / deflection_rad).exp();
                worst_mnm = worst_mnm.max((truth.sensor_torque_mnm - coulomb_mnm * bent).abs());
            }
        }
        let truth = run.rig.truth();
        let turned_rad = way * (truth.knob_angle_rad - turning_rad);
        at_turn = way + (at_turn - way) * (-turned_rad / deflection_rad).exp();
        turning_rad = truth.knob_angle_rad;
        way = -way;
        println!("leg {leg}: bent to {at_turn:.4}, worst difference so far {worst_mnm:.3} mNm");
    }
    assert!(worst_mnm < 0.01 * coulomb_mnm, "the torque is off by {worst_mnm} mNm");
}

#[test]
fn bristles_hold_a_torque_below_coulombs_at_the_angle_where_they_bear_it() {
    let (coulomb_mnm, deflection_rad, torque_mnm) = (20.0, 0.004, 12.0);
    // Damped: bristles creep under a torque that trembles.
    let parameters = RigParameters { motor_viscous: 5.0, ..frictionless_motor() };
    let mut run = Run::new(parameters, bristly(coulomb_mnm, deflection_rad), 10_000);
    for tick in 0..20_000_u32 {
        run.tick(torque_mnm * (f64::from(tick) / 1e4).min(1.0));
    }
    let expected_rad = -deflection_rad * (1.0 - torque_mnm / coulomb_mnm).ln();
    assert_close(run.rig.truth().knob_angle_rad, expected_rad, 0.02 * expected_rad, "the angle in rad");
}
