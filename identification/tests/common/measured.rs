//! Recordings made by others.

use std::path::{Path, PathBuf};

use super::Capture;

/// Folder of the captures that others made, or `None` where it is not at hand, which is said.
#[allow(clippy::print_stderr, reason = "a test that skips says so")]
pub fn recordings() -> Option<PathBuf> {
    let folder = std::env::var_os("HAPTIC_CAMERA_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: there is no {}; HAPTIC_CAMERA_DATA may name the folder", folder.display());
    None
}

/// The columns of a recording made by others, or `None` where it is not at hand, which is said.
pub fn measured(file: &str) -> Option<Vec<Vec<f64>>> {
    let text =
        std::fs::read_to_string(recordings()?.join("measured").join(file)).expect("the folder holds the recording");
    Some(columns(&text).1)
}

/// A capture from a table with a header.
pub fn table(path: &Path) -> Capture {
    let text = std::fs::read_to_string(path).expect("the table is there");
    let (header, columns) = columns(&text);
    let column = |name: &str| header.iter().position(|found| *found == name).map(|index| columns[index].clone());
    Capture {
        t_s: column("t_s").expect("a time"),
        angle_rad: column("angle_rad").expect("an angle"),
        velocity_rad_s: column("velocity_rad_s"),
        acceleration_rad_s2: column("acceleration_rad_s2"),
        torque_mnm: column("torque_mnm").expect("a torque"),
        calibration: None,
    }
}

fn columns(text: &str) -> (Vec<&str>, Vec<Vec<f64>>) {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut columns = vec![Vec::new(); header.len()];
    for line in lines {
        for (column, value) in columns.iter_mut().zip(line.split(',')) {
            column.push(value.parse().expect("a recording holds numbers below its header"));
        }
    }
    (header, columns)
}
