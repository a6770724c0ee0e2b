//! Recordings made by others.

use std::path::Path;

use super::Capture;

/// The columns of a recording made by others, or `None` where it is not at hand, which is said.
pub fn measured(file: &str) -> Option<Vec<Vec<f64>>> {
    let text =
        std::fs::read_to_string(measured_data::folder("measured")?.join(file)).expect("the folder holds the recording");
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
