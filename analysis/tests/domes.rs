//! Measured domes and switches, fitted: what is pressed has a characteristic, not detents.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::path::{Path, PathBuf};

use identification::PreparationMethod;
use loaded_capture::LoadedCapture;

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn the_fit_of_a_measured_dome_leaves_less_than_three_percent_of_its_force() {
    let Some(folder) = measured_data::folder("force-curves") else { return };
    let sets = files(&folder.join("dome-lab"));
    assert!(sets.len() >= 10);
    for file in sets.iter().flat_map(|set| files(set)) {
        let fit =
            analysis::fit(&LoadedCapture::load_measured(&file, None).unwrap(), PreparationMethod::default()).unwrap();
        assert!(fit.relative_error_percent < 3.0, "{}: {} %", file.display(), fit.relative_error_percent);
        let friction = fit.parameters.get("coulomb_positive").unwrap();
        assert!(friction.value.unwrap() > 0.0 && friction.ci95.is_some(), "{}", file.display());
        let model = fit.model("dome");
        let read = dynamics::Model::from_toml(&model.to_toml(), "a fitted dome").unwrap();
        assert_eq!((read.axis, &read.effects), (dynamics::Axis::Linear, &model.effects));
        let json = analysis::to_json_on(fit.axis, &fit).unwrap();
        assert!(json.contains("\"force_n\"") && !json.contains("mnm") && !json.contains("mNm"), "{json}");
    }
}

#[test]
fn switches_are_fitted_or_refused_in_a_sentence() {
    let Some(folder) = measured_data::folder("force-curves") else { return };
    for file in files(&folder.join("switches")) {
        match analysis::fit(&LoadedCapture::load_measured(&file, None).unwrap(), PreparationMethod::default()) {
            Ok(fit) => assert!(fit.relative_error_percent.is_finite(), "{}", file.display()),
            Err(error) => assert!(error.to_string().lines().count() == 1, "{error}"),
        }
    }
}
