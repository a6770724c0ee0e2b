//! Captures and models in the formats of other programs, and folders of captures listed.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::program::{call, command, done, errors, json};
use archive::Capture;
use dynamics::{Motion, knobs};
use serde_json::Value;

fn refused(folder: &Path, line: &str, status: i32, words: &str) {
    let output = call(folder, line);
    let said = errors(&output);
    assert_eq!(output.status.code(), Some(status), "{line}: {said}");
    assert!(said.contains(words), "{line}: '{words}' is missing in {said}");
    assert_eq!(said.lines().filter(|line| line.starts_with("error:")).count(), 1, "reported once: {said}");
}

/// Captures a knob offline and gives the archive's name.
fn captured(folder: &Path, knob: &str) -> String {
    archive_of(&done(folder, &format!("capture --offline --knob {knob} --duration-s 3 --rate-hz 5000 --out .")))
}

/// The archive's name, as a run says it.
fn archive_of(said: &str) -> String {
    let line = said.lines().find(|line| line.starts_with("archive")).unwrap();
    line.split_whitespace().nth(1).unwrap().trim_start_matches("./").to_owned()
}

#[test]
fn an_exported_table_has_the_contract_s_columns_and_is_fitted_like_the_archive() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let archive = captured(folder, "3");
    done(folder, &format!("export {archive} --out table.csv"));
    let text = std::fs::read_to_string(folder.join("table.csv")).unwrap();
    assert_eq!(text.lines().next().unwrap(), "t_s,angle_rad,velocity_rad_s,acceleration_rad_s2,torque_mnm");
    let (whole, table) =
        (Capture::load(&folder.join(&archive)).unwrap(), Capture::load(&folder.join("table.csv")).unwrap());
    assert_eq!((&whole.t_s, &whole.angle_rad, &whole.torque_mnm), (&table.t_s, &table.angle_rad, &table.torque_mnm));
    done(folder, &format!("fit {archive} --json archive.json"));
    done(folder, "fit table.csv --json table.json");
    let [of_archive, of_table] = ["archive.json", "table.json"].map(|name| fitted(folder, name));
    assert_eq!(of_archive, of_table);
    // Without the rig's calibration there would be another inertia: the file beside the table counts.
    std::fs::remove_file(folder.join("table.calibration.toml")).unwrap();
    done(folder, "fit table.csv --json bare.json");
    assert_ne!(fitted(folder, "bare.json"), of_table);
}

#[test]
fn an_exported_replay_is_fitted_like_its_archive() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let said = done(folder, "replay --offline 4 --hand linear-chirp --duration-s 3 --out .");
    let archive = archive_of(&said);
    done(folder, &format!("export {archive} --out table.csv"));
    done(folder, &format!("fit {archive} --json archive.json"));
    done(folder, "fit table.csv --json table.json");
    let [of_archive, of_table] = ["archive.json", "table.json"].map(|name| fitted(folder, name));
    assert_eq!(of_archive["parameters"], of_table["parameters"]);
}

/// A fit's numbers, without what an archive knows besides: where it comes from and what was mounted.
fn fitted(folder: &Path, name: &str) -> Value {
    let mut json = json(&folder.join(name));
    let all = json.as_object_mut().unwrap();
    assert!(all.contains_key("parameters") && all.contains_key("residual_rms_mnm"));
    all.remove("capture");
    all.remove("true_values");
    json
}

/// A Python with pyarrow; says so when there is none.
#[allow(clippy::print_stderr, reason = "a test that skips says so")]
fn python_with_pyarrow() -> Option<PathBuf> {
    let python = std::env::var_os("HAPTIC_CAMERA_PYTHON").map_or_else(|| PathBuf::from("python3"), PathBuf::from);
    let found = Command::new(&python).args(["-c", "import pyarrow.parquet, numpy"]).output();
    if found.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    eprintln!("skipped: no Python with pyarrow and numpy; scripts/test installs them, HAPTIC_CAMERA_PYTHON names it");
    None
}

#[test]
fn pyarrow_reads_an_exported_parquet_file_to_the_last_bit_with_its_units() {
    let Some(python) = python_with_pyarrow() else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let archive = captured(folder, "3");
    done(folder, &format!("export {archive} --out capture.parquet"));
    let script = "import pyarrow.parquet as parquet, json, sys\n\
        table = parquet.read_table('capture.parquet')\n\
        real = [name for name in table.column_names if str(table.schema.field(name).type) == 'double']\n\
        with open('columns.bin', 'wb') as file:\n    \
            for name in real: file.write(table[name].to_numpy().astype('<f8').tobytes())\n\
        metadata = {key.decode(): value.decode() for key, value in parquet.read_metadata('capture.parquet').metadata.items()}\n\
        print(json.dumps({'columns': table.column_names, 'real': real, 'rows': table.num_rows, 'metadata': metadata,\n    \
            'ticks': [table['tick'][0].as_py(), table['tick'][-1].as_py()]}))";
    let output = Command::new(python).args(["-c", script]).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    let capture = Capture::load(&folder.join(&archive)).unwrap();
    assert_eq!(result["rows"], capture.len());
    assert_eq!(result["ticks"][1].as_u64(), capture.tick.last().copied());
    assert_eq!(result["metadata"]["unit.acceleration_rad_s2"], "rad/s^2");
    assert_eq!(result["metadata"]["unit.torque_mnm"], "mNm");
    assert_eq!(result["metadata"]["rate_hz"], "5000");
    assert!(result["metadata"]["run.json"].as_str().unwrap().contains("\"knob\": \"3\""));
    let columns = [
        ("t_s", Some(&capture.t_s)),
        ("angle_rad", Some(&capture.angle_rad)),
        ("velocity_rad_s", capture.velocity_rad_s.as_ref()),
        ("acceleration_rad_s2", capture.acceleration_rad_s2.as_ref()),
        ("torque_mnm", Some(&capture.torque_mnm)),
        ("commanded_angle_rad", capture.commanded_angle_rad.as_ref()),
        ("commanded_torque_mnm", capture.commanded_torque_mnm.as_ref()),
    ];
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let real: Vec<&str> = result["real"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    assert_eq!(names, real);
    let expected: Vec<u8> =
        columns.iter().flat_map(|(_, column)| column.unwrap()).flat_map(|value| value.to_le_bytes()).collect();
    assert!(std::fs::read(folder.join("columns.bin")).unwrap() == expected, "the columns differ");
}

#[test]
fn an_exported_header_compiles_and_gives_the_model_s_torque() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (knob, prefix) in [(3, "KNOB_3"), (4, "KNOB_4")] {
        let name = format!("knob-{knob}.h");
        done(folder, &format!("export {knob} --out {name} --points 200"));
        let lower = prefix.to_lowercase();
        let program = format!(
            "#include <stdio.h>\n#include \"{name}\"\n\
             int main(void) {{\n  printf(\"%.9g %.9g\\n\", {prefix}_INERTIA_MNM_S2_PER_RAD, {prefix}_COULOMB_POSITIVE_MNM);\n  \
             printf(\"%.9g %.9g %.9g\\n\", {prefix}_SMARTKNOB_POSITION_WIDTH_RADIANS, {prefix}_DETENT_STIFFNESS_MNM_PER_RAD,\n  \
             {prefix}_SMARTKNOB_DETENT_STRENGTH_UNIT(10.0f));\n  \
             for (int i = -{prefix}_TABLE_POINTS; i < 2 * {prefix}_TABLE_POINTS; i++) {{\n    \
             float angle = (float)i * {prefix}_TABLE_SPAN_RAD / {prefix}_TABLE_POINTS;\n    \
             printf(\"%.9g %.9g\\n\", angle, {lower}_torque_at_mnm(angle));\n  }}\n  return 0;\n}}\n"
        );
        std::fs::write(folder.join("table.c"), program).unwrap();
        let compiler = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-o", "table", "table.c"];
        let compiled = Command::new("cc").args(compiler).current_dir(folder).output().unwrap();
        assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
        let output = Command::new(folder.join("table")).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let rows: Vec<Vec<f64>> =
            text.lines().map(|line| line.split(' ').map(|number| number.parse().unwrap()).collect()).collect();
        let model = knobs::paper_knob(knob).unwrap();
        let value = |name: &str| model.parameter(name).unwrap();
        let near = |one: f64, other: f64, tolerance: f64| {
            assert!((one - other).abs() <= tolerance, "knob {knob}: {one} against {other}");
        };
        near(rows[0][0], value("inertia"), 1e-7);
        near(rows[0][1], value("coulomb_positive"), 1e-5);
        let (amplitude, period) = (value("detent_amplitude").abs(), value("detent_period"));
        near(rows[1][0], std::f64::consts::TAU * period, 1e-6);
        near(rows[1][1], amplitude / period, 1e-3 * amplitude / period);
        near(rows[1][2], amplitude / period / 40.0, 1e-3 * amplitude / period);
        assert_eq!(rows.len(), 2 + 600);
        for row in &rows[2..] {
            let motion = Motion { angle_rad: row[0], ..Motion::default() };
            // Single precision of the angle, three periods around zero.
            near(row[1], model.free_torque_mnm(&motion), 1e-5 * amplitude);
        }
    }
    // A knob without detents has inertia and friction all the same.
    done(folder, "export 1 --out knob-1.h");
    let header = std::fs::read_to_string(folder.join("knob-1.h")).unwrap();
    assert!(header.contains("KNOB_1_COULOMB_NEGATIVE_MNM 46.0f") && !header.contains("TABLE"), "{header}");
}

#[test]
fn an_exported_torque_table_is_a_detent_that_compose_takes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    done(folder, "export 4 --out detents.csv --points 100");
    done(folder, "compose --inertia 4 --friction 4 --detents detents.csv --out again.toml");
    let (original, again) = (knobs::paper_knob(4).unwrap(), dynamics::Model::load(&folder.join("again.toml")).unwrap());
    for step in 0..500 {
        let motion = Motion { angle_rad: 0.01 * f64::from(step), ..Motion::default() };
        let (one, other) = (original.free_torque_mnm(&motion), again.free_torque_mnm(&motion));
        assert!((one - other).abs() < 0.01, "{one} against {other} at {} rad", motion.angle_rad);
    }
}

#[test]
fn what_cannot_be_exported_so_is_reported_with_what_can() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    refused(folder, "export 3 --out knob.xyz", 2, "exported as .csv, .h, .xml, .urdf, .fmu or .json");
    refused(folder, "export capture.mcap --out capture.h", 2, "exported as .csv or .parquet");
    refused(folder, "export 3 --out knob.h --points 1", 2, "4..=65536");
    for (line, option) in [
        ("3 --out knob.xml --points 9", "--points"),
        ("3 --out knob.urdf --over turn", "--over"),
        ("3 --out knob.csv --along capture.mcap", "--along"),
        ("3 --out knob.xml --motor-mnm-per-v 9", "--motor-mnm-per-v"),
        ("3 --out knob.csv --columns angle=1,torque=2", "--columns"),
        ("capture.mcap --out capture.csv --points 9", "--points"),
    ] {
        refused(folder, &format!("export {line}"), 2, &format!("{option} has no effect on a "));
    }
    refused(folder, "export nowhere.mcap --out capture.csv", 1, "does not exist");
    refused(folder, "export 1 --out knob.csv", 1, "no torque that depends on the angle");
    refused(folder, "export 1 --out knob.csv --over period", 1, "--over turn");
    std::fs::write(folder.join("same.csv"), "t_s,angle_rad,torque_mnm\n0,0,0\n1,1,1\n2,2,2\n").unwrap();
    refused(folder, "export same.csv --out ./same.csv", 2, "name another file");
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), 1, "nothing is left behind");
}

#[test]
fn a_folder_is_listed_by_time_with_what_is_damaged_and_what_is_foreign() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // Names that sort the other way round than the times.
    let first = captured(folder, "3");
    std::fs::rename(folder.join(&first), folder.join("z-first.mcap")).unwrap();
    std::fs::rename(folder.join(&first).with_extension("json"), folder.join("z-first.json")).unwrap();
    let second = captured(folder, "1");
    std::fs::rename(folder.join(&second), folder.join("a-second.mcap")).unwrap();
    let bytes = std::fs::read(folder.join("a-second.mcap")).unwrap();
    std::fs::write(folder.join("cut.mcap"), &bytes[..bytes.len() / 2]).unwrap();
    let mut flipped = bytes.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 0x10;
    std::fs::write(folder.join("flipped.mcap"), flipped).unwrap();
    std::fs::write(folder.join("notes.txt"), "knob bought in May").unwrap();
    std::fs::write(folder.join("20261121-101500-a-knob-with-a-long-name.mcap"), "").unwrap();
    let text = done(folder, "list .");
    assert!(text.contains("20261121-1015…ong-name.mcap"), "{text}");
    assert!(text.lines().all(|line| line.starts_with("- ") || line.chars().count() <= 80), "{text}");
    assert!(!text.contains('\u{1b}'), "no colours where it is no terminal: {text}");
    assert!(text.contains("haptic-camera recover ./cut.mcap"), "{text}");
    let listing: Value = serde_json::from_str(&done(folder, "list . --json")).unwrap();
    let entries = listing["captures"].as_array().unwrap();
    let of =
        |file: &str| entries.iter().find(|entry| entry["file"] == file).unwrap_or_else(|| panic!("{file}: {text}"));
    let place = |file: &str| entries.iter().position(|entry| entry["file"] == file).unwrap();
    assert!(place("z-first.mcap") < place("a-second.mcap"));
    assert_eq!(of("z-first.mcap")["health"], "whole");
    assert_eq!(of("z-first.mcap")["knob"], "3");
    assert_eq!(of("z-first.mcap")["samples"], 15_000);
    assert_eq!(of("z-first.mcap")["lost_samples"], 0);
    let fit = json(&folder.join("z-first.json"));
    assert_eq!(of("z-first.mcap")["relative_error_percent"], fit["relative_error_percent"]);
    assert_eq!(of("z-first.mcap")["duration_s"], fit["capture"]["duration_s"]);
    // Without the JSON beside it a capture is fitted for the list.
    assert!(of("a-second.mcap")["mean_ci95_mnm"].as_f64().unwrap() > 0.0);
    assert_eq!(of("cut.mcap")["health"], "truncated");
    assert_eq!(of("flipped.mcap")["health"], "damaged");
    assert_eq!(of("notes.txt")["health"], "foreign");
    assert_eq!(entries.len(), 6, "results of a fit are no captures: {text}");
    refused(folder, "list nowhere", 1, "nowhere");
    std::fs::create_dir(folder.join("empty")).unwrap();
    assert!(done(folder, "list empty").contains("holds no captures"));
}

#[test]
fn captures_of_one_second_have_names_that_sort_by_time() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let names: Vec<String> = (0..3).map(|_| captured(folder, "3")).collect();
    assert!(names.windows(2).all(|pair| pair[0] < pair[1]), "{names:?}");
}

#[test]
fn captures_begun_at_once_into_one_folder_are_all_kept_each_with_its_own_results() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let begun: Vec<_> = (1..=6)
        .map(|seed: u64| {
            let line = format!("capture --offline --knob 3 --duration-s 2 --rate-hz 2000 --seed {seed} --out shared");
            (seed, command(folder, &line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap())
        })
        .collect();
    for (seed, capture) in begun {
        let output = capture.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
        let archive = said.lines().find_map(|line| line.strip_prefix("archive  ")).unwrap();
        let archive = folder.join(archive.split(" (").next().unwrap());
        let capture = Capture::load(&archive).unwrap();
        let notes = capture.description.unwrap().notes;
        assert!(notes.iter().any(|(name, value)| name == "seed" && *value == seed.to_string()), "{seed}: {notes:?}");
        let json = json(&archive.with_extension("json"));
        assert_eq!(json["capture"]["source"].as_str(), archive.file_name().unwrap().to_str());
        assert!(archive.with_extension("toml").exists() && archive.with_extension("html").exists());
    }
    assert_eq!(std::fs::read_dir(folder.join("shared")).unwrap().count(), 6 * 4, "nothing else is left");
}
