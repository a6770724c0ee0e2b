//! Recordings made by others.

/// The columns of a recording made by others, or `None` where it is not at hand, which is said.
#[allow(clippy::print_stderr, reason = "a test that skips says so")]
pub fn measured(file: &str) -> Option<Vec<Vec<f64>>> {
    let folder = std::env::var_os("HAPTIC_CAMERA_DATA").map_or_else(
        || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        std::path::PathBuf::from,
    );
    let path = folder.join("measured").join(file);
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: there is no {}; HAPTIC_CAMERA_DATA may name the folder", path.display());
        return None;
    };
    let number = |value: &str| value.parse().expect("a recording holds numbers below its header");
    let rows: Vec<Vec<f64>> = text.lines().skip(1).map(|line| line.split(',').map(number).collect()).collect();
    Some((0..rows[0].len()).map(|column| rows.iter().map(|row| row[column]).collect()).collect())
}
