//! What a capture shows, and what a model lacks, is the same whenever it began, in any unit of torque and seen from either end of
//! the shaft.

use crate::common::{Capture, run};
use crate::hidden::{diagnosed, hidden};
use dynamics::{Direction, Drive, knobs};
use identification::checks::{Breakaway, FreeTravel, breakaways, count_detents, free_travel};

/// A capture of another beginning, unit of torque or sense of rotation.
struct Changed {
    name: &'static str,
    change: fn(&Capture) -> Capture,
    torque: f64,
    angle: f64,
}

const CHANGES: [Changed; 5] = [
    Changed { name: "5 s later", change: |capture| capture.later(5.0), torque: 1.0, angle: 1.0 },
    Changed { name: "a million seconds later", change: |capture| capture.later(1e6), torque: 1.0, angle: 1.0 },
    Changed { name: "a thousandth of the torque", change: |capture| capture.louder(1e-3), torque: 1e-3, angle: 1.0 },
    Changed { name: "30 times the torque", change: |capture| capture.louder(30.0), torque: 30.0, angle: 1.0 },
    Changed { name: "both axes turned round", change: Capture::turned, torque: -1.0, angle: -1.0 },
];

/// All of them in two captures, for what takes long.
const CHANGES_TOGETHER: [Changed; 2] = [
    Changed {
        name: "a million seconds later, a thousandth of the torque",
        change: |capture| capture.later(1e6).louder(1e-3),
        torque: 1e-3,
        angle: 1.0,
    },
    Changed {
        name: "5 s later, 30 times the torque, both axes turned round",
        change: |capture| capture.later(5.0).louder(30.0).turned(),
        torque: -30.0,
        angle: -1.0,
    },
];

/// What the rig says of itself in the units of a changed capture.
fn changed(capture: &Capture, Changed { change, torque, angle, .. }: &Changed) -> Capture {
    let mut changed = change(capture);
    if let Some(known) = &mut changed.calibration {
        known.torque_zero_mnm *= torque;
        known.torque_sensor_stiffness_mnm_rad *= torque / angle;
    }
    changed
}

#[test]
fn the_same_detents_are_counted() {
    let turn = run(&knobs::paper_knob(3).unwrap(), "slow-turn", Drive::Position, None, 15.0, 1);
    let expected = count_detents(&turn.samples()).unwrap();
    for change in CHANGES {
        let found = count_detents(&changed(&turn, &change).samples()).unwrap();
        assert_eq!(found.detents, expected.detents, "{}", change.name);
        let [low, high] = expected.period_ci95_rad;
        let same = 0.05 * (high - low);
        assert!((found.period_rad - expected.period_rad).abs() < same, "{}: {found:?}, {expected:?}", change.name);
    }
}

#[test]
fn the_same_breakaways_are_read_off() {
    let ramp = run(&knobs::paper_knob(3).unwrap(), "torque-ramp", Drive::Torque, Some(16.0), 9.6, 1);
    let seen = |capture: &Capture| breakaways(&capture.samples(), Some(capture.rig())).unwrap();
    let expected = seen(&ramp);
    assert!(expected.len() > 2, "{expected:?}");
    for change in CHANGES {
        let found = seen(&changed(&ramp, &change));
        assert_eq!(found.len(), expected.len(), "{}: {found:?}, {expected:?}", change.name);
        for (found, expected) in found.iter().zip(&expected) {
            let Breakaway { angle_rad, direction, torque_mnm, .. } = *found;
            let turned = if change.angle < 0.0 { opposite(expected.direction) } else { expected.direction };
            assert_eq!(direction, turned, "{}", change.name);
            assert!((angle_rad / change.angle - expected.angle_rad).abs() < 1e-9, "{}: {found:?}", change.name);
            assert!(
                (torque_mnm / change.torque / expected.torque_mnm - 1.0).abs() < 1e-9,
                "{}: {found:?}",
                change.name
            );
        }
    }
}

fn opposite(direction: Direction) -> Direction {
    Direction::of(-direction.sign())
}

#[test]
fn the_same_lost_motion_is_seen() {
    let creep = run(&knobs::paper_knob(5).unwrap(), "slow-turn", Drive::Position, Some(0.1), 15.0, 2);
    let ways = |capture: &Capture| -> Vec<f64> {
        let found = free_travel(&capture.samples(), Some(capture.rig())).unwrap();
        found.iter().map(FreeTravel::travel_rad).collect()
    };
    let expected = ways(&creep);
    assert!(expected.len() > 1);
    for change in CHANGES {
        let found = ways(&changed(&creep, &change));
        assert_eq!(found.len(), expected.len(), "{}", change.name);
        assert!(
            found.iter().zip(&expected).all(|(found, expected)| (found - expected).abs() < 1e-9),
            "{}: {found:?}, {expected:?}",
            change.name
        );
    }
}

#[test]
fn the_same_is_missing() {
    for (seed, asked) in [(2, "none"), (4, "friction-drift"), (6, "mains-hum"), (7, "stribeck"), (8, "end-stop")] {
        let ([train, heldout], _) = hidden(3000 + seed, asked, 3.0);
        let expected = diagnosed(&train, &heldout);
        for change in CHANGES_TOGETHER {
            let found = diagnosed(&changed(&train, &change), &changed(&heldout, &change));
            let name = format!("{asked}, {}: {} | {}", change.name, found.summary, expected.summary);
            assert_eq!(found.verdict, expected.verdict, "{name}");
            assert_eq!((&found.effects, found.complete), (&expected.effects, expected.complete), "{name}");
            let left = [found.train_rms_after, found.heldout_rms_after];
            for (left, expected) in left.iter().zip([expected.train_rms_after, expected.heldout_rms_after]) {
                assert!((left / change.torque.abs() / expected - 1.0).abs() < 0.01, "{name}: {left} for {expected}");
            }
        }
    }
}
