//! The curve through a table's points.

use dynamics::{TorqueTable, TorqueTableError};

use crate::drawing;

const DRAWINGS: u64 = 300;

/// Angles, torques and period, and what is said of them.
type Refused<'points> = (&'points [f64], &'points [f64], Option<f64>, &'points str);

/// Points with the first repeated after a period.
fn closed(angle_rad: &[f64], torque_mnm: &[f64], period_rad: f64) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> = angle_rad.iter().copied().zip(torque_mnm.iter().copied()).collect();
    points.push((angle_rad[0] + period_rad, torque_mnm[0]));
    points
}

#[test]
fn the_curve_passes_through_every_point_and_repeats() {
    for seed in 1..=DRAWINGS {
        let (angle_rad, torque_mnm, period_rad) = drawing(seed);
        let table = TorqueTable::kept(&angle_rad, &torque_mnm, Some(period_rad)).unwrap();
        let tolerance_mnm = 1e-9 * (1.0 + table.steepest_mnm_rad());
        for (angle, torque) in closed(&angle_rad, &torque_mnm, period_rad) {
            for turns in [-3.0, 0.0, 1.0, 7.0] {
                let found = table.torque_mnm(angle + turns * period_rad);
                assert!((found - torque).abs() < tolerance_mnm, "drawing {seed}: {found} for {torque}");
            }
        }
    }
}

#[test]
fn between_two_points_the_curve_goes_straight_from_one_torque_to_the_other_and_never_beyond() {
    for seed in 1..=DRAWINGS {
        let (angle_rad, torque_mnm, period_rad) = drawing(seed);
        let table = TorqueTable::kept(&angle_rad, &torque_mnm, Some(period_rad)).unwrap();
        for pair in closed(&angle_rad, &torque_mnm, period_rad).windows(2) {
            let [(from_rad, from_mnm), (to_rad, to_mnm)] = *pair else { unreachable!() };
            let rising = (to_mnm - from_mnm).signum();
            let along: Vec<f64> =
                (1..60).map(|step| table.torque_mnm(from_rad + (to_rad - from_rad) * f64::from(step) / 60.0)).collect();
            let (low, high) = (from_mnm.min(to_mnm) - 1e-9, from_mnm.max(to_mnm) + 1e-9);
            assert!(along.iter().all(|torque| (low..=high).contains(torque)), "drawing {seed} overshoots");
            assert!(along.windows(2).all(|two| rising * (two[1] - two[0]) >= -1e-9), "drawing {seed} turns back");
        }
    }
}

#[test]
fn the_slope_is_continuous_across_every_point_and_the_end_of_the_period() {
    for seed in 1..=DRAWINGS {
        let (angle_rad, torque_mnm, period_rad) = drawing(seed);
        let table = TorqueTable::kept(&angle_rad, &torque_mnm, Some(period_rad)).unwrap();
        let narrowest = closed(&angle_rad, &torque_mnm, period_rad)
            .windows(2)
            .map(|pair| pair[1].0 - pair[0].0)
            .fold(f64::INFINITY, f64::min);
        let slopes_apart = |step: f64| -> f64 {
            let apart = |angle: &f64| {
                let here = table.torque_mnm(*angle);
                let (before, after) = (table.torque_mnm(angle - step), table.torque_mnm(angle + step));
                ((after - here) - (here - before)).abs() / step
            };
            angle_rad.iter().map(apart).fold(0.0, f64::max)
        };
        // One-sided slopes differ by the curvature times the step: a tenth of the step, a tenth of the difference. At a
        // corner they would stay apart.
        let (coarse, fine) = (slopes_apart(1e-2 * narrowest), slopes_apart(1e-3 * narrowest));
        assert!(fine < 0.12 * coarse + 1e-6 * table.steepest_mnm_rad(), "drawing {seed}: {coarse} and {fine}");
    }
}

#[test]
fn a_drawn_sine_is_a_sine() {
    let tau = std::f64::consts::TAU;
    let angle_rad: Vec<f64> = (0..=64).map(|point| 0.3 * f64::from(point) / 64.0).collect();
    let torque_mnm: Vec<f64> = angle_rad.iter().map(|angle| 7.0 * (tau * angle / 0.3).sin()).collect();
    let table = TorqueTable::kept(&angle_rad, &torque_mnm, None).unwrap();
    for step in 0..1000 {
        let angle = 0.001 * f64::from(step) - 0.4;
        let expected = 7.0 * (tau * angle / 0.3).sin();
        assert!((table.torque_mnm(angle) - expected).abs() < 0.01, "{angle}");
    }
    let steepest = 7.0 * tau / 0.3;
    assert!((table.steepest_mnm_rad() / steepest - 1.0).abs() < 0.01);
}

#[test]
fn equal_tables_are_kept_once() {
    let kept = |last: f64| TorqueTable::kept(&[0.0, 0.1, 0.3], &[1.0, 5.0, last], Some(0.5)).unwrap();
    assert!(std::ptr::eq(kept(2.0), kept(2.0)) && !std::ptr::eq(kept(2.0), kept(2.5)));
    // The last point repeating the first says the same as a period.
    let repeated = TorqueTable::kept(&[0.0, 0.1, 0.3, 0.5], &[1.0, 5.0, 2.0, 1.0], None).unwrap();
    assert!(std::ptr::eq(repeated, kept(2.0)));
}

#[test]
fn what_is_no_periodic_function_is_refused_with_the_number_that_was_exceeded() {
    let cases: [Refused; 9] = [
        (&[0.0, 0.1, 0.2], &[0.0, 4.0, 1.0], None, "a jump of 1.000000 mNm where 0.004000 mNm is allowed"),
        (&[0.0, 0.1, 0.2], &[0.0, 4.0, 1.0], Some(0.2), "a jump of 1.000000 mNm where 0.004000 mNm is allowed"),
        (&[0.0, 0.1, 0.2], &[0.0, 4.0, 1.0], Some(0.15), "period_rad is 0.15, but its points lie over 0.2 rad"),
        (&[0.0, 0.1, 0.2], &[0.0, 4.0, 1.0], Some(f64::NAN), "period_rad is NaN"),
        (&[0.0, 0.2, 0.1], &[0.0, 4.0, 0.0], None, "point 3 of the table is at 0.1 rad, not beyond the 0.2 rad"),
        (&[0.0, 0.1, 0.1], &[0.0, 4.0, 0.0], None, "one for each"),
        (&[0.0, 0.1, 0.2], &[0.0, f64::NAN, 0.0], None, "point 2 of the table has torque_mnm NaN"),
        (&[0.0, 0.1], &[0.0, 0.0], None, "the table has 2 points, but it must have 3 to 10000"),
        (&[0.0, 0.1, 0.2], &[0.0, 0.0], None, "3 angles but 2 torques"),
    ];
    for (angle_rad, torque_mnm, period_rad, expected) in cases {
        let message = TorqueTable::kept(angle_rad, torque_mnm, period_rad).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    let steep = TorqueTable::kept(&[0.0, 1e-300, 1.0], &[-1e300, 1e300, 0.0], Some(2.0));
    assert_eq!(steep, Err(TorqueTableError::TooSteep));
}

#[test]
fn a_text_of_two_columns_is_a_table() {
    let text = "\u{feff}angle_rad,torque_mnm\r\n0.0, 0.0\r\n0.1,5\r\n\r\n0.2,-5\r\n0.3,0\r\n";
    let table = TorqueTable::kept_from_csv(text.as_bytes()).unwrap();
    assert_eq!(
        (table.period_rad(), table.points(), table.points_mnm()),
        (Some(0.3), &[0.0, 0.1, 0.2][..], &[0.0, 5.0, -5.0][..])
    );
    for (text, expected) in [
        ("", "they must be `angle_rad,torque_mnm`"),
        ("angle,torque\n0,0\n", "they must be `angle_rad,torque_mnm`"),
        ("angle_rad,torque_mnm\n0.0,1.0\n0.1;2\n", "line 3: "),
        ("angle_rad,torque_mnm\n0.0,1.0,2.0\n", "line 2: "),
    ] {
        let refused = TorqueTable::kept_from_csv(text.as_bytes()).unwrap_err();
        assert!(matches!(refused, TorqueTableError::Text(_)) && refused.to_string().contains(expected), "{refused}");
    }
}
