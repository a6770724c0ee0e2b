//! The encoder's zero may lie elsewhere in the held-out capture: that is no property of the knob, and said.

use crate::common::{Capture, table};
use hidden_effects::capture::Capture as Hidden;
use hidden_effects::family::Family;
use identification::diagnosis::{DiagnoseOptions, Diagnosis, diagnose};

/// A pair of captures of the plant under `tests/hidden-effects`.
fn hidden(seed: u64, asked: &str) -> [Capture; 2] {
    let folder = tempfile::tempdir().unwrap();
    let hidden = Hidden::new(seed, 0, Family::Standard, asked, 3.0).unwrap();
    hidden.write(folder.path()).unwrap();
    ["train.csv", "heldout.csv"].map(|file| table(&folder.path().join(&hidden.name).join(file)))
}

fn diagnosed(train: &Capture, heldout: &Capture) -> Diagnosis {
    diagnose(&train.samples(), Some(&heldout.samples()), &DiagnoseOptions::default()).unwrap()
}

fn zero_note(found: &Diagnosis) -> Option<&String> {
    found.notes.iter().find(|note| note.contains("another zero"))
}

#[test]
fn an_inertia_that_varies_is_not_taken_for_another_zero() {
    for seed in 4100..4106 {
        let [train, heldout] = hidden(seed, "angle-dependent-inertia");
        let found = diagnosed(&train, &heldout);
        assert!(zero_note(&found).is_none(), "{seed}: {:?}", zero_note(&found));
        assert_eq!(found.effects, ["angle-dependent-inertia"], "{seed}: {}", found.summary);
    }
}

#[test]
fn another_zero_of_the_encoder_is_told_and_changes_nothing_else() {
    let sorts = [("none", 0.1), ("stribeck", -1.7), ("mass-imbalance", -1.7), ("end-stop", -1.7)];
    for (seed, (asked, by_rad)) in (4000..).zip(sorts) {
        let [train, heldout] = hidden(seed, asked);
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
