//! Calibrations and excitations.
#![no_main]

use dynamics::{Calibration, Excitation};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| fuzz::bounded(text.len(), || {
    if let Ok(calibration) = Calibration::from_toml(text) {
        let written = toml::to_string(&calibration).expect("a calibration can be written");
        Calibration::from_toml(&written).expect("what was written is read");
    }
    if let Ok(excitation) = toml::from_str::<Excitation>(text) {
        for time_s in [0.0, 1e-4, 0.5, 10.0, 1e9] {
            let _ = excitation.at(time_s);
        }
    }
}));
