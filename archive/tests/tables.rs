//! Error messages about files that are not captures.

#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::path::{Path, PathBuf};

use archive::{ArchiveError, Capture};
use tempfile::TempDir;

struct Bench {
    directory: TempDir,
}

impl Bench {
    fn new() -> Self {
        Self { directory: tempfile::tempdir().unwrap() }
    }

    /// What `Capture::load` says about a file with this content, without the directory.
    fn refusal(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.put(name, content);
        let text = Capture::load(&path).unwrap_err().to_string();
        assert!(!text.contains('\n'), "one sentence: {text}");
        text.replace(&format!("{}/", self.directory.path().display()), "")
    }

    fn put(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.directory.path().join(name);
        std::fs::write(&path, content).unwrap();
        path
    }
}

#[test]
fn a_missing_file_is_named() {
    let refused = Capture::load(Path::new("/nowhere/at/all.csv")).unwrap_err();
    assert_eq!(refused.to_string(), "/nowhere/at/all.csv does not exist; check the path");
}

#[test]
fn a_directory_is_not_a_capture() {
    let bench = Bench::new();
    assert!(matches!(Capture::load(bench.directory.path()), Err(ArchiveError::File { .. })));
}

#[test]
fn an_empty_file_is_called_empty() {
    let bench = Bench::new();
    assert_eq!(bench.refusal("a.csv", ""), "a.csv is empty: it holds neither an MCAP archive nor a CSV table");
    assert_eq!(bench.refusal("a.mcap", ""), "a.mcap is empty: it holds neither an MCAP archive nor a CSV table");
}

#[test]
fn a_wrong_header_is_shown_beside_the_right_one() {
    let bench = Bench::new();
    assert_eq!(
        bench.refusal("a.csv", "time,angle,torque\n0,0,0\n"),
        "a.csv: it has the columns `time,angle,torque`, but they must be \
         `t_s,angle_rad[,velocity_rad_s][,acceleration_rad_s2],torque_mnm[,contact]`; name other \
         columns, as in time=NAME,angle=NAME,torque=NAME"
    );
    for header in ["t_s,angle_rad", "t_s,angle_rad,torque_mnm,torque_mnm", "t_s,angle_rad,torque_mnm,colour", "0,1,2"] {
        assert!(bench.refusal("b.csv", format!("{header}\n1,2,3\n")).contains(&format!("columns `{header}`")));
    }
}

#[test]
fn a_value_that_is_not_finite_is_reported_with_line_and_column() {
    let bench = Bench::new();
    let table = |cell: &str| format!("t_s,angle_rad,torque_mnm\n0,0,0\n0.1,0,{cell}\n0.2,0,0\n");
    assert_eq!(
        bench.refusal("a.csv", table("NaN")),
        "a.csv: line 3: torque_mnm is NaN, but it must be a finite number"
    );
    assert_eq!(
        bench.refusal("a.csv", table("-inf")),
        "a.csv: line 3: torque_mnm is -inf, but it must be a finite number"
    );
    assert_eq!(
        bench.refusal("a.csv", table("1e999")),
        "a.csv: line 3: torque_mnm is inf, but it must be a finite number"
    );
    assert_eq!(
        bench.refusal("a.csv", table("")),
        "a.csv: line 3: the column torque_mnm has no value; fill it in, or leave the line out"
    );
    assert_eq!(
        bench.refusal("a.csv", table("1,5")),
        "a.csv: line 3: it has 4 cells, but the header has 3; write numbers with a point, as in 1.5"
    );
}

#[test]
fn time_that_stands_still_or_runs_back_is_reported_with_its_row() {
    let bench = Bench::new();
    let table = |time: &str| format!("t_s,angle_rad,torque_mnm\n0,0,0\n0.1,0,0\n{time},0,0\n0.3,0,0\n");
    for time in ["0.1", "0.05"] {
        let refused = bench.refusal("a.csv", table(time));
        assert!(
            refused.starts_with(&format!("a.csv, row 3: t_s = {time} s comes after 0.1 s; time must increase")),
            "{refused}"
        );
    }
}

#[test]
fn too_few_rows_are_counted() {
    let bench = Bench::new();
    let header = "t_s,angle_rad,torque_mnm\n";
    assert_eq!(bench.refusal("a.csv", header), "a.csv has no rows; a capture needs at least three");
    assert_eq!(bench.refusal("a.csv", format!("{header}0,0,0\n")), "a.csv has one row; a capture needs at least three");
    assert_eq!(
        bench.refusal("a.csv", format!("{header}0,0,0\n1,0,0\n")),
        "a.csv has two rows; a capture needs at least three"
    );
    assert_eq!(
        bench.refusal("a.mcap", common::recording(0..2, 9)),
        "a.mcap has two rows; a capture needs at least three"
    );
}

#[test]
fn content_and_not_the_name_tells_an_archive_from_a_table() {
    let bench = Bench::new();
    assert_eq!(Capture::load(&bench.put("archive.csv", common::recording(0..9, 9))).unwrap().len(), 9);
    let table = "t_s,angle_rad,torque_mnm\n0,0,0\n1,0,0\n2,0,0\n";
    assert_eq!(Capture::load(&bench.put("table.txt", table)).unwrap().len(), 3);
    let not_one = "is not an MCAP archive (its first bytes are not MCAP's) and not a CSV table either; save a table as UTF-8 text, or name \
                   its columns, as in time=NAME,angle=NAME,torque=NAME";
    assert_eq!(bench.refusal("a.mcap", "hello, this is text"), format!("a.mcap {not_one}"));
    assert_eq!(bench.refusal("a.csv", [0xff, 0xd8, 0xff, 0xe0, 0, 0x10, 1, 2, 3, 0, 0]), format!("a.csv {not_one}"));
    assert_eq!(bench.refusal("b.csv", b"t_s,angle_rad\xff\xfe,torque_mnm\n"), format!("b.csv {not_one}"));
}

#[test]
fn times_that_were_rounded_are_those_of_an_even_clock() {
    let bench = Bench::new();
    for (rate_hz, decimals) in [(700.0, 3), (860.0, 3), (7000.0, 4)] {
        let mut table = "t_s,angle_rad,torque_mnm\n".to_owned();
        for tick in 0..2000 {
            let time_s = f64::from(tick) / rate_hz;
            table += &format!("{time_s:.decimals$},{tick},1\n");
        }
        let capture = Capture::load(&bench.put("rounded.csv", table)).unwrap();
        assert!((capture.rate_hz / rate_hz - 1.0).abs() < 1e-4, "{} for {rate_hz} Hz", capture.rate_hz);
        assert_eq!((capture.tick[1999], capture.ticks_without_sample()), (1999, 0));
        assert!(capture.t_s.windows(2).all(|pair| ((pair[1] - pair[0]) * rate_hz - 1.0).abs() < 1e-4));
    }
}

#[test]
fn a_truncated_archive_leads_to_recover_at_every_length() {
    let bench = Bench::new();
    let file = common::recording(0..60, 20);
    for length in (1..file.len()).step_by(37) {
        let path = bench.put("cut.mcap", &file[..length]);
        let refused = Capture::load(&path).unwrap_err();
        assert!(matches!(refused, ArchiveError::Truncated { .. }), "at {length}: {refused}");
        let advice = format!("run `haptic-camera recover {} --out FIXED.mcap`", path.display());
        assert!(refused.to_string().ends_with(&advice), "{refused}");
    }
}

#[test]
fn a_damaged_archive_is_never_taken_for_a_sound_one() {
    let bench = Bench::new();
    let file = common::recording(0..60, 20);
    let sound = Capture::load(&bench.put("sound.mcap", &file)).unwrap();
    for bit in (0..file.len() * 8).step_by(29) {
        let mut flipped = file.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        // A flip where it does not matter, such as in an index, may pass; the columns may not differ.
        if let Ok(read) = Capture::load(&bench.put("flipped.mcap", &flipped)) {
            assert_eq!((&read.seq, &read.tick), (&sound.seq, &sound.tick), "bit {bit}");
            assert_eq!((&read.angle_rad, &read.torque_mnm), (&sound.angle_rad, &sound.torque_mnm), "bit {bit}");
        }
    }
}

#[test]
fn the_rate_of_a_table_is_that_of_its_rounded_times() {
    let bench = Bench::new();
    let rows: String = (0..4000).map(|row| format!("{:.6},0,0\n", f64::from(row) / 6_000.0)).collect();
    let capture = Capture::load(&bench.put("a.csv", format!("t_s,angle_rad,torque_mnm\n{rows}"))).unwrap();
    assert_eq!(capture.rate_hz, 6_000.0);
    assert_eq!(capture.tick.last(), Some(&3999));
}

#[test]
fn columns_may_stand_in_any_order_behind_a_byte_order_mark() {
    let bench = Bench::new();
    let table = "\u{feff}torque_mnm, t_s ,angle_rad,velocity_rad_s\r\n5,0,1,7\r\n6,1,2,8\r\n7,2,3,9\r\n";
    let capture = Capture::load(&bench.put("a.csv", table)).unwrap();
    assert_eq!(capture.torque_mnm, [5.0, 6.0, 7.0]);
    assert_eq!(capture.angle_rad, [1.0, 2.0, 3.0]);
    assert_eq!(capture.velocity_rad_s, Some(vec![7.0, 8.0, 9.0]));
    assert_eq!(capture.acceleration_rad_s2, None);
}
