//! Files whose columns are named on the command line are captures like any other.

use std::fmt::Write as _;

use crate::program::{done, json, only, refused};
use archive::Capture;

/// Time, angle and torque of a capture as our own table and as somebody else's.
fn tables(capture: &Capture) -> [String; 2] {
    let [mut own, mut foreign] = ["t_s,angle_rad,torque_mnm\n", "Zeit;Winkel;Moment\n"].map(str::to_owned);
    for ((t_s, angle_rad), torque_mnm) in capture.t_s.iter().zip(&capture.angle_rad).zip(&capture.torque_mnm) {
        writeln!(own, "{t_s},{angle_rad},{torque_mnm}").unwrap();
        writeln!(foreign, "{};{};{}", 1e3 * t_s, angle_rad.to_degrees(), 0.1 * torque_mnm).unwrap();
    }
    [own, foreign]
}

#[test]
fn a_table_with_named_columns_is_fitted_diagnosed_and_exported_as_a_capture() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    done(folder, "capture --knob 3 --duration-s 4 --offline --no-viewer --out made");
    let archive = only(&folder.join("made"), "mcap");
    let capture = Capture::load(&archive).unwrap();
    for (name, text) in ["own.csv", "bench.csv"].iter().zip(tables(&capture)) {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let named = "--columns angle=Winkel,torque=Moment,time=Zeit --units angle=deg,torque=Ncm,time=ms";
    done(folder, "fit own.csv --json own.json");
    done(folder, &format!("fit bench.csv --json bench.json {named}"));
    let inertia = |name: &str| json(&folder.join(name))["parameters"]["inertia"]["value"].as_f64().unwrap();
    assert!((inertia("bench.json") / inertia("own.json") - 1.0).abs() < 1e-6);
    done(folder, &format!("export bench.csv --out again.csv {named}"));
    let again = Capture::load(&folder.join("again.csv")).unwrap();
    let same = |found: &[f64], own: &[f64]| found.iter().zip(own).all(|(found, own)| (found - own).abs() < 1e-9);
    assert!(again.len() == capture.len() && same(&again.angle_rad, &capture.angle_rad));
    assert!(same(&again.torque_mnm, &capture.torque_mnm) && same(&again.t_s, &capture.t_s));

    // Without its time it is no capture, and that is said.
    let timeless = "--columns angle=Winkel,torque=Moment --units angle=deg,torque=Ncm";
    let said = refused(folder, &format!("diagnose bench.csv {timeless}"));
    assert!(said.contains("bench.csv has no time, so it is a curve and not a capture"), "{said}");
}
