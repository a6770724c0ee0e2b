//! Which lines of cogging a travel can tell apart.

use std::f64::consts::TAU;

use dynamics::Scene;
use dynamics::effects::cogging::{is_apart_from_the_detents, is_of_the_detents, lines_are_resolved};

#[test]
fn lines_differ_by_half_a_period_over_the_travel() {
    // A quarter of a turn: lines are two periods per turn apart.
    let scene = Scene { lowest_rad: 0.0, highest_rad: 0.25 * TAU, ..Scene::default() };
    let with = |second_per_turn: f64| [0.2, 7.0, 0.0, 0.1, second_per_turn, 0.0, 0.0, 7.0, 0.0];
    assert!(lines_are_resolved(&with(9.1), &scene) && lines_are_resolved(&with(4.9), &scene));
    assert!(!lines_are_resolved(&with(8.9), &scene) && !lines_are_resolved(&with(5.1), &scene));
}

#[test]
fn a_multiple_of_the_detents_is_of_them_and_their_own_period_is_not_asked() {
    let scene = Scene { highest_rad: TAU, detent_period_rad: Some(0.1), ..Scene::default() };
    assert!(is_of_the_detents(20.4, &scene) && is_of_the_detents(29.6, &scene));
    assert!(!is_of_the_detents(20.6, &scene) && !is_of_the_detents(10.0, &scene));
}

#[test]
fn a_line_beside_the_detents_differs_from_them_by_half_a_period_over_the_travel() {
    let scene = Scene { highest_rad: TAU, detent_period_rad: Some(0.1), ..Scene::default() };
    assert!(is_apart_from_the_detents(10.6, &scene) && is_apart_from_the_detents(9.4, &scene));
    assert!(!is_apart_from_the_detents(10.4, &scene) && !is_apart_from_the_detents(9.6, &scene));
    assert!(is_apart_from_the_detents(10.0, &Scene { detent_period_rad: None, ..scene }));
}
