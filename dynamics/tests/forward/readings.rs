//! What the torque sensor reads along a motion, against a knob simulated by other means.

use std::f64::consts::TAU;

use dynamics::{Motion, shifted};

use crate::model;
use crate::plant::{Knob, Link};

const SAMPLE_S: f64 = 1e-4;
const SAMPLES: usize = 15_000;

/// Torques at the samples, two sinusoids that stop and turn the knob.
fn torque_mnm() -> Vec<f64> {
    let sine = |amplitude: f64, hertz: f64, time_s: f64| amplitude * (std::f64::consts::TAU * hertz * time_s).sin();
    (0..SAMPLES).map(|index| index as f64 * SAMPLE_S).map(|t| sine(10.0, 1.3, t) + sine(6.0, 7.1, t)).collect()
}

/// Effects and the knob that has them.
type Case<'a> = (&'a [(&'a str, &'a [f64])], Knob);

#[test]
fn a_knob_at_the_end_of_a_shaft_is_read_right_whether_it_sticks_slips_or_bends() {
    let torque_mnm = torque_mnm();
    let shafts: [(Link, &[f64]); 2] =
        [(Link::Shaft(800.0, 0.3), &[800.0, 0.3]), (Link::Cap(0.0, 0.02, 800.0, 0.3), &[800.0, 0.3, 0.4])];
    let cases = shafts.into_iter().flat_map(|(link, shaft)| {
        let cases: [Case; 3] = [
            (&[], Knob { link, ..Knob::default() }),
            (&[("karnopp-stick", &[12.0, 12.0, 0.05])], Knob { link, stick: Some((12.0, 0.05)), ..Knob::default() }),
            (
                &[("presliding-hysteresis", &[0.03, 0.02])],
                Knob { link, bristles: Some((0.03, 0.02)), ..Knob::default() },
            ),
        ];
        cases.map(|case| (shaft, case))
    });
    for (shaft, (effects, knob)) in cases {
        let base: [(&str, &[f64]); 3] =
            [("inertia", &[0.05]), ("friction", &[4.0, 4.0, 0.6, 0.6]), ("shaft-compliance", shaft)];
        let course = crate::plant::run(&knob, SAMPLE_S, &torque_mnm, 100);
        let motion = |(index, (angle_rad, velocity_rad_s)): (usize, &(f64, f64))| Motion {
            time_s: index as f64 * SAMPLE_S,
            angle_rad: *angle_rad,
            velocity_rad_s: *velocity_rad_s,
            acceleration_rad_s2: {
                let speed = |at: usize| course[at.min(SAMPLES - 1)].1;
                (speed(index + 1) - speed(index.saturating_sub(1))) / (2.0 * SAMPLE_S)
            },
        };
        let motions: Vec<Motion> = course.iter().enumerate().map(motion).collect();
        let off = |effects: &[(&str, &[f64])]| {
            let read = model(&base.iter().chain(effects).copied().collect::<Vec<_>>()).readings_mnm(&motions);
            let squares: f64 = read.iter().zip(&torque_mnm).map(|(read, torque)| (read - torque).powi(2)).sum();
            (squares / SAMPLES as f64).sqrt()
        };
        let (right, wrong) = (off(effects), off(&[]));
        // A tenth of what the paper's sensor tells, 0.18 mNm.
        assert!(right < 0.018, "{effects:?}: {right:.2e} mNm");
        assert!(effects.is_empty() || wrong > 10.0 * right, "{effects:?}: {right:.2e} and without it {wrong:.2e} mNm");
    }
}

#[test]
fn a_resting_knob_bears_at_least_the_friction_that_it_slides_with() {
    let stribeck = model(&[
        ("friction", &[4.0, 5.0, 0.1, 0.1]),
        ("karnopp-stick", &[6.0, 9.0, 0.01]),
        ("stribeck", &[3.0, 1.0, 1.0]),
    ]);
    let limits = stribeck.stick_limits(&Motion::default());
    assert_eq!((limits.negative_mnm, limits.positive_mnm, limits.velocity_rad_s), (7.0, 9.0, 0.01));
}

#[test]
fn an_end_stop_pushes_and_does_not_pull() {
    let stop = model(&[("end-stop", &[-1.0, 1.0, 100.0, 200.0, 5.0])]);
    let torque = |angle_rad: f64, velocity_rad_s: f64| {
        stop.torque_mnm(&Motion { angle_rad, velocity_rad_s, ..Motion::default() })
    };
    assert!((torque(1.01, 0.2) - (2.0 + 1.0)).abs() < 1e-9);
    assert!((torque(-1.02, -0.2) + (2.0 + 1.0)).abs() < 1e-9);
    assert_eq!((torque(1.01, -2.0), torque(-1.02, 2.0), torque(0.0, 3.0)), (0.0, 0.0, 0.0));
}

#[test]
fn late_readings_are_brought_back_to_their_torque() {
    let knob = model(&[
        ("inertia", &[0.05]),
        ("torque-offset", &[1.5]),
        ("mains-hum", &[0.4, 50.0, 0.2]),
        ("sensor-delay", &[2.34e-3]),
    ]);
    let motions: Vec<Motion> = (0..3_000)
        .map(|index| f64::from(index) * SAMPLE_S)
        .map(|time_s| Motion { time_s, acceleration_rad_s2: 200.0 * (40.0 * time_s).sin(), ..Motion::default() })
        .collect();
    let time_s: Vec<f64> = motions.iter().map(|motion| motion.time_s).collect();
    let readings_mnm = shifted(&time_s, &knob.readings_mnm(&motions), -knob.reading_delay_s());
    assert_eq!(readings_mnm[10], readings_mnm[0], "nothing has arrived yet");
    let known = knob.readings_within(&motions);
    assert_eq!(known, 0..2_976);
    let torque_mnm = knob.knob_torque_mnm(&motions, &readings_mnm);
    // The first reading stands for what came before it, which bends the curve at the first two.
    for index in known.skip(2) {
        let exact = 0.05 * motions[index].acceleration_rad_s2;
        assert!((torque_mnm[index] - exact).abs() < 1e-3, "{index}: {} against {exact}", torque_mnm[index]);
    }
}

#[test]
fn a_signal_is_shifted_along_a_cubic_and_held_at_its_ends() {
    let time_s: Vec<f64> = (0..40).map(|index| f64::from(index) + 0.3 * f64::from(index % 3)).collect();
    let cubic = |time: f64| 0.01 * time.powi(3) - 0.2 * time * time + time;
    let values: Vec<f64> = time_s.iter().map(|time| cubic(*time)).collect();
    for ahead_s in [-1.7, 0.4] {
        for (time, value) in time_s.iter().zip(shifted(&time_s, &values, ahead_s)) {
            let at = time + ahead_s;
            // With three points only, at the second and the last interval, no cubic can be fitted.
            if at >= time_s[1] && at < time_s[38] {
                assert!((value - cubic(at)).abs() < 1e-9, "at {at}: {value}");
            } else if at < time_s[0] {
                assert_eq!(value, values[0]);
            }
        }
    }
    assert!(shifted(&[], &[], 0.1).is_empty());
}

#[test]
fn a_stiff_shaft_reads_as_none_where_friction_and_inertia_depend_on_the_motion() {
    let [swing_rad, omega, sample_s] = [1.0, TAU * 6.0, 5e-5];
    let motions: Vec<Motion> = (0..10_000)
        .map(|n| {
            let time_s = f64::from(n) * sample_s;
            let (sine, cosine) = (omega * time_s).sin_cos();
            Motion {
                time_s,
                angle_rad: swing_rad * (1.0 - cosine),
                velocity_rad_s: swing_rad * omega * sine,
                acceleration_rad_s2: swing_rad * omega * omega * cosine,
            }
        })
        .collect();
    for (further, values) in
        [("load-dependent-friction", &[0.3][..]), ("angle-dependent-inertia", &[0.01, 2.0, 0.4][..])]
    {
        let one_body: [(&str, &[f64]); 4] = [
            ("inertia", &[0.05]),
            ("friction", &[2.0, 3.0, 0.1, 0.1]),
            ("detent", &[8.0, 0.1, 0.0]),
            (further, values),
        ];
        let with_shaft = [&one_body[..], &[("shaft-compliance", &[1e5, 40.0][..])]].concat();
        let [expected, readings] = [&one_body[..], &with_shaft].map(|effects| model(effects).readings_mnm(&motions));
        let slides = |n: &usize| motions[*n].velocity_rad_s.abs() > 0.1 * swing_rad * omega;
        let rms = |of: &dyn Fn(usize) -> f64| {
            let squares: Vec<f64> = (2000..motions.len()).filter(slides).map(|n| of(n).powi(2)).collect();
            (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
        };
        let [torque, difference] = [rms(&|n| expected[n]), rms(&|n| expected[n] - readings[n])];
        assert!(difference < 0.05 * torque, "{further}: {difference} of {torque} mNm");
    }
}
