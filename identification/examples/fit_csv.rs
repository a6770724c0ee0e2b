//! Fits CSV captures and prints the JSON: `cargo run --release --example fit_csv -- FILE…`.
#![allow(clippy::print_stdout, reason = "an example speaks to its user")]

use identification::{FitOptions, Samples, fit};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for path in std::env::args().skip(1) {
        let text = std::fs::read_to_string(&path)?;
        let mut lines = text.lines();
        let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let mut columns = vec![Vec::new(); header.len()];
        for line in lines {
            for (column, value) in columns.iter_mut().zip(line.split(',')) {
                column.push(value.parse::<f64>()?);
            }
        }
        let column = |name: &str| header.iter().position(|found| *found == name).map(|index| columns[index].as_slice());
        let required = |name: &str| column(name).ok_or_else(|| format!("{path} has no column {name}"));
        let samples = Samples {
            t_s: required("t_s")?,
            angle_rad: required("angle_rad")?,
            velocity_rad_s: column("velocity_rad_s"),
            acceleration_rad_s2: column("acceleration_rad_s2"),
            torque_mnm: required("torque_mnm")?,
        };
        let start = std::time::Instant::now();
        let fit = fit(&samples, &FitOptions::default());
        let elapsed = start.elapsed();
        match fit {
            Ok(fit) => println!("{path} in {elapsed:.1?}\n{}", serde_json::to_string_pretty(&fit)?),
            Err(error) => println!("{path}: {error}"),
        }
    }
    Ok(())
}
