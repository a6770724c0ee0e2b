//! Drawn torques: an accepted table is finite wherever it is asked.
#![no_main]

use dynamics::TorqueTable;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| fuzz::bounded(text.len(), || {
    let Ok(table) = TorqueTable::kept_from_csv(text.as_bytes()) else { return };
    let first = table.points()[0];
    for share in [-1e6, -1.0, 0.0, 0.1, 0.5, 0.999, 1.0, 7.3] {
        let angle_rad = first + share * table.period_rad().unwrap_or(1.0);
        if angle_rad.is_finite() {
            assert!(table.torque_mnm(angle_rad).is_finite(), "{table:?} at {angle_rad}");
        }
    }
}));
