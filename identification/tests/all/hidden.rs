//! Captures of the plant under `tests/hidden-effects`, which shares nothing with the candidates.

use hidden_effects::capture::{Answer, Capture as Hidden};
use hidden_effects::family::Family;
use identification::diagnosis::{DiagnoseOptions, Diagnosis, diagnose};

use crate::common::{Capture, table};

/// A training and a held-out capture, and what they hide.
pub fn hidden(seed: u64, asked: &str, strength: f64) -> ([Capture; 2], Answer) {
    let folder = tempfile::tempdir().unwrap();
    let hidden = Hidden::new(seed, 0, Family::Standard, asked, strength).unwrap();
    hidden.write(folder.path()).unwrap();
    let captures = ["train.csv", "heldout.csv"].map(|file| table(&folder.path().join(&hidden.name).join(file)));
    (captures, hidden.answer)
}

pub fn diagnosed(train: &Capture, heldout: &Capture) -> Diagnosis {
    diagnose(&train.samples(), Some(&heldout.samples()), &DiagnoseOptions::default()).unwrap()
}
