//! The encoder's zero may lie elsewhere in the held-out capture: that is no property of the knob, and said.

use crate::hidden::{diagnosed, hidden};
use identification::diagnosis::Diagnosis;

fn zero_note(found: &Diagnosis) -> Option<&String> {
    found.notes.iter().find(|note| note.contains("another zero"))
}

#[test]
fn an_inertia_that_varies_is_not_taken_for_another_zero() {
    for seed in 4100..4106 {
        let ([train, heldout], _) = hidden(seed, "angle-dependent-inertia", 3.0);
        let found = diagnosed(&train, &heldout);
        assert!(zero_note(&found).is_none(), "{seed}: {:?}", zero_note(&found));
        assert_eq!(found.effects, ["angle-dependent-inertia"], "{seed}: {}", found.summary);
    }
}

#[test]
fn another_zero_of_the_encoder_is_told_and_changes_nothing_else() {
    let sorts = [("none", 0.1), ("stribeck", -1.7), ("mass-imbalance", -1.7), ("end-stop", -1.7)];
    for (seed, (asked, by_rad)) in (4000..).zip(sorts) {
        let ([train, heldout], _) = hidden(seed, asked, 3.0);
        let expected = diagnosed(&train, &heldout);
        assert!(zero_note(&expected).is_none(), "{asked}: {:?}", zero_note(&expected));
        let mut elsewhere = heldout.clone();
        elsewhere.angle_rad.iter_mut().for_each(|angle| *angle += by_rad);
        let found = diagnosed(&train, &elsewhere);
        let case = format!("{asked}: {} | {} | {:?}", found.summary, expected.summary, zero_note(&found));
        println!("{case}");
        assert!(zero_note(&found).is_some(), "{case}");
        assert_eq!(found.verdict, expected.verdict, "{case}");
        assert_eq!((&found.effects, found.complete), (&expected.effects, expected.complete), "{case}");
        assert!((found.heldout_rms_after / expected.heldout_rms_after - 1.0).abs() < 0.03, "{case}");
    }
}
