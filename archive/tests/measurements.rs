//! Measurements in ASAM MDF 4: read as asammdf reads them, or refused in one sentence.
//!
//! asammdf is a Python package that `scripts/set-up tests` installs; `HAPTIC_CAMERA_PYTHON` names its interpreter.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::path::{Path, PathBuf};
use std::process::Command;

use archive::Capture;
use archive::testers::{ColumnChoice, Curve};
use falcon_mdf::{Mf4Writer, SignalValues};
use shared_types::Axis;

/// Writes measurements with asammdf, and beside each what asammdf reads of it: times, angles, torques.
const WRITE: &str = r"
import sys, numpy
from asammdf import MDF, Signal
folder = sys.argv[1]
t = numpy.arange(3000) / 1000 + 0.25
angle, torque = 90 * numpy.sin(3 * t), 5 * numpy.cos(7 * t) + 1
slow = numpy.arange(50) / 20
def signal(name, unit, samples, times=t, **more):
    return Signal(samples=samples, timestamps=times, name=name, unit=unit, **more)
def bench(kind):
    if kind == 'float32': return angle.astype('<f4'), torque.astype('<f4'), None, None
    if kind == 'big-endian': return angle.astype('>f8'), torque.astype('>f4'), None, None
    if kind == 'int16':
        counts = lambda x, step: numpy.round(x / step).astype('<i2')
        return counts(angle, 0.01), counts(torque, 0.001), {'a': 0.01, 'b': 0.5}, {'a': 0.001, 'b': -0.25}
    return angle, torque, None, None
def write(name, kind='float64', version='4.10', compression=0, parts=1):
    angle, torque, of_angle, of_torque = bench(kind)
    file = MDF(version=version)
    file.append([signal('Temp', 'degC', numpy.arange(50.0), slow)])
    of_all = [signal('Winkel', 'deg', angle, conversion=of_angle), signal('Moment', 'Ncm', torque, conversion=of_torque)]
    file.append(of_all + [signal('Zustand', '', numpy.arange(3000, dtype='u1'))])
    for part in range(1, parts):
        values = [(t + 3 * part, None), (angle, None), (torque, None), (numpy.arange(3000, dtype='u1'), None)]
        file.extend(1, values)
    file.save(f'{folder}/{name}.mf4', overwrite=True, compression=compression)
for name, more in [
    ('plain', {}), ('float32', {'kind': 'float32'}), ('int16', {'kind': 'int16'}), ('big-endian', {'kind': 'big-endian'}),
    ('deflated', {'compression': 1}), ('transposed', {'compression': 2, 'kind': 'int16'}), ('old', {'version': '4.00'}),
    ('columns', {'version': '4.20', 'compression': 2}), ('extended', {'parts': 3}),
]:
    write(name, **more)
invalid = numpy.arange(3000) % 7 == 3
file = MDF(version='4.10')
file.append([signal('Winkel', 'deg', angle), signal('Moment', 'Ncm', torque, invalidation_bits=invalid)])
file.save(f'{folder}/invalid.mf4', overwrite=True)
";

/// Reads measurements with asammdf, as 64-bit numbers: times, angles, torques.
const READ: &str = r"
import glob, sys, numpy
from asammdf import MDF
for path in glob.glob(f'{sys.argv[1]}/*.mf4'):
    with MDF(path) as file:
        angle, torque = file.get('Winkel'), file.get('Moment')
        # It leaves out what is invalid, of each channel by itself.
        valid = numpy.isin(angle.timestamps, torque.timestamps)
        numpy.concatenate([torque.timestamps, angle.samples[valid], torque.samples]).astype('<f8').tofile(path + '.f64')
";

/// A Python with asammdf; `None` where there is none, which is said.
#[allow(clippy::print_stderr, reason = "a test that skips says so")]
fn python() -> Option<PathBuf> {
    let interpreter = std::env::var_os("HAPTIC_CAMERA_PYTHON")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/python/bin/python"), Into::into);
    let found = Command::new(&interpreter).args(["-c", "import asammdf"]).output();
    if found.is_ok_and(|output| output.status.success()) {
        return Some(interpreter);
    }
    eprintln!("skipped: {} lacks asammdf; run scripts/set-up tests", interpreter.display());
    None
}

fn run(python: &Path, program: &str, folder: &Path) {
    let output = Command::new(python).args(["-c", program]).arg(folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn choice(columns: &str, units: &str) -> ColumnChoice {
    let units = if units.is_empty() { Default::default() } else { units.parse().unwrap() };
    ColumnChoice::new(columns.parse().unwrap(), units).unwrap()
}

/// Times, angles in degrees and torques in Ncm of `samples` rows.
fn columns(samples: u32) -> [Vec<f64>; 3] {
    let of = |value: &dyn Fn(f64) -> f64| (0..samples).map(|row| value(f64::from(row))).collect();
    [of(&|n| 1e-3 * n), of(&|n| 90.0 * (0.01 * n).sin()), of(&|n| 3.0 + (0.03 * n).cos())]
}

/// A measurement whose second group has angle and torque, its records among those of the first.
fn unsorted(samples: u32) -> Mf4Writer {
    let [times, angle, torque] = columns(samples);
    let mut file = Mf4Writer::new();
    file.add_group(&times[..20]).unwrap().add_channel("Temp", "degC", &angle[..20]).unwrap();
    let group = file.add_group_in(0, &times).unwrap();
    group.add_channel("Winkel", "deg", &angle).unwrap();
    let torque = torque.iter().map(|torque| *torque as f32).collect();
    group.add_channel_typed("Moment", "N·cm", SignalValues::F32(torque)).unwrap();
    file
}

fn load(folder: &Path, file: &Mf4Writer, choice: Option<&ColumnChoice>) -> Result<Curve, String> {
    let path = folder.join("bench.mf4");
    file.write_to_file(&path).unwrap();
    let curve = Curve::load(&path, choice).map_err(|error| error.to_string().replace(path.to_str().unwrap(), "FILE"));
    curve.inspect_err(|error| assert_eq!(error.lines().count(), 1, "{error}"))
}

#[test]
fn measurements_are_read_as_asammdf_reads_them() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    run(&python, WRITE, folder.path());
    unsorted(600).write_to_file(folder.path().join("unsorted.mf4")).unwrap();
    let mut deflated = unsorted(600);
    deflated.set_compression(true);
    deflated.write_to_file(folder.path().join("unsorted-deflated.mf4")).unwrap();
    run(&python, READ, folder.path());
    let mut files = 0;
    for path in std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path()) {
        if path.extension().is_none_or(|ending| ending != "mf4") {
            continue;
        }
        let bytes = std::fs::read(format!("{}.f64", path.display())).unwrap();
        let expected: Vec<f64> = bytes.chunks(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect();
        let rows = expected.len() / 3;
        let capture = Capture::load(&path).unwrap();
        assert_eq!((capture.len(), &capture.source), (rows, &path));
        let unit = [1.0, std::f64::consts::PI / 180.0, 10.0];
        for ((found, expected), unit) in
            [&capture.t_s, &capture.angle_rad, &capture.torque_mnm].into_iter().zip(expected.chunks(rows)).zip(unit)
        {
            for (row, (found, expected)) in found.iter().zip(expected).enumerate() {
                let expected = expected * unit;
                let close = (found - expected).abs() <= 1e-12 * expected.abs().max(1.0);
                assert!(close, "{}, row {row}: {found} instead of {expected}", path.display());
            }
        }
        files += 1;
    }
    assert_eq!(files, 12);
}

#[test]
fn channels_are_known_by_name_or_unit_or_are_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let curve = load(folder.path(), &unsorted(600), None).unwrap();
    assert_eq!((curve.axis, curve.len()), (Axis::Rotary, 600));
    assert!((curve.load[0] - 40.0).abs() < 1e-12 && (curve.t_s.as_ref().unwrap()[599] - 0.599).abs() < 1e-12);
    assert_eq!(load(folder.path(), &unsorted(600), Some(&choice("angle=2/Winkel,torque=Moment", ""))).unwrap(), curve);
    // A given unit takes precedence over the file's.
    let chosen = choice("angle=Winkel,torque=Moment", "torque=Nm");
    assert!((load(folder.path(), &unsorted(600), Some(&chosen)).unwrap().load[0] - 4000.0).abs() < 1e-9);

    // The second angle is not called so, and a contact closes.
    let [times, angle, torque] = columns(300);
    let volts: Vec<f64> = (0..300).map(|row| if row < 100 { 5.0 } else { 0.1 }).collect();
    let mut file = Mf4Writer::new();
    let group = file.add_group(&times).unwrap();
    for (name, unit, values) in [
        ("Soll", "deg", &torque),
        ("Angle", "rad", &angle),
        ("F", "Nm", &torque),
        ("U", "V", &volts),
        ("Uhr", "ms", &times),
    ] {
        group.add_channel(name, unit, values).unwrap();
    }
    let curve = load(folder.path(), &file, None).unwrap();
    assert_eq!((&curve.position, curve.closed), (&angle, None));
    let curve = load(folder.path(), &file, Some(&choice("angle=Angle,torque=F,contact=U,time=Uhr", ""))).unwrap();
    assert_eq!(curve.closed.unwrap().iter().position(|closed| *closed), Some(100));
    assert!((curve.t_s.unwrap()[200] - 2e-4).abs() < 1e-12);
}

#[test]
fn readings_that_were_not_timed_are_a_curve() {
    let folder = tempfile::tempdir().unwrap();
    let [_, angle, torque] = columns(300);
    let mut file = Mf4Writer::new();
    let group = file.add_group(&[0.0; 300]).unwrap();
    group.add_channel("Angle", "rad", &angle).unwrap();
    group.add_channel("Torque", "Nm", &torque).unwrap();
    let curve = load(folder.path(), &file, None).unwrap();
    assert_eq!((curve.t_s, curve.is_of_motion, curve.position), (None, false, angle));
    let error = Capture::load(&folder.path().join("bench.mf4")).unwrap_err().to_string();
    assert!(error.contains("has no time, so it is a curve"), "{error}");
}

#[test]
fn an_ambiguous_channel_is_refused_with_a_list_of_the_channels() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |file: &Mf4Writer, choice: Option<&ColumnChoice>| load(folder.path(), file, choice).unwrap_err();
    let [times, angle, torque] = columns(300);
    let mut file = Mf4Writer::new();
    file.add_group(&times).unwrap().add_channel("Winkel", "deg", &angle).unwrap();
    file.add_group(&times[..100]).unwrap().add_channel("M", "Nm", &torque[..100]).unwrap();
    assert_eq!(
        refused(&file, None),
        "FILE: `Winkel` (group 1, 300 samples) and `M` (group 2, 100 samples) were not sampled at the same times; name channels \
         of one group, or resample the file to one raster first"
    );
    assert!(refused(&file, Some(&choice("angle=Winkel,torque=M", ""))).contains("not sampled at the same times"));
    let missing = refused(&file, Some(&choice("angle=Winkel,torque=Moment", "")));
    assert!(missing.starts_with("FILE: it has no channel `Moment`; it has the channels `1/"), "{missing}");
    assert!(missing.contains("`1/Winkel` in deg") && missing.contains("`2/M` in Nm"), "{missing}");

    // Groups with the same times belong together.
    file.add_group(&times).unwrap().add_channel("Drehmoment", "Nm", &torque).unwrap();
    let both = load(folder.path(), &file, Some(&choice("angle=Winkel,torque=Drehmoment", ""))).unwrap();
    assert_eq!(both.len(), 300);
    let several = refused(&file, None);
    assert!(several.contains("several of its channels match, `2/M`, `3/Drehmoment`: name one"), "{several}");

    let mut file = Mf4Writer::new();
    let group = file.add_group(&times).unwrap();
    group.add_channel("Winkel", "Grad", &angle).unwrap();
    group.add_channel("M", "", &torque).unwrap();
    assert!(refused(&file, None).contains("it has no unambiguous channels for angle and torque, or travel and force"));
    let unit = refused(&file, Some(&choice("angle=Winkel,torque=M", "")));
    assert_eq!(
        unit,
        "FILE: the unit of `Winkel` is unknown (`Grad` is not a unit of angle; known are rad, mrad, deg, degree, degrees, °, turn, turns, rev); name \
         the columns, as in angle=NAME,…, and their units, as in angle=rad"
    );
    let chosen = choice("angle=Winkel,torque=M", "angle=deg,torque=Nm");
    assert_eq!(load(folder.path(), &file, Some(&chosen)).unwrap().len(), 300);
    let mut holes = angle.clone();
    holes[7] = f64::NAN;
    file.add_group(&times).unwrap().add_channel("Loch", "deg", &holes).unwrap();
    let hole = refused(&file, Some(&choice("angle=Loch,torque=M", "torque=Nm")));
    assert_eq!(hole, "FILE: row 8: `Loch` is NaN");
}

/// Every reading of damaged bytes ends, with a curve or with one sentence; how many were refused.
fn refused(bytes: impl Iterator<Item = Vec<u8>>) -> (u32, u32) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.mf4");
    let (mut refused, mut all) = (0, 0);
    for bytes in bytes {
        std::fs::write(&path, bytes).unwrap();
        all += 1;
        if let Err(error) = Curve::load(&path, None) {
            let error = error.to_string();
            assert!(!error.is_empty() && error.lines().count() == 1, "{error}");
            refused += 1;
        }
    }
    (refused, all)
}

#[test]
fn damaged_measurements_are_refused_and_none_ends_the_program() {
    for deflated in [false, true] {
        let mut file = unsorted(40);
        file.set_compression(deflated);
        let mut whole = Vec::new();
        file.write(&mut whole).unwrap();
        // Every cut is reported: no curve is silently shorter.
        let (cut, cuts) = refused((0..whole.len()).step_by(5).map(|length| whole[..length].to_vec()));
        assert_eq!(cut, cuts, "deflated: {deflated}");
        let flipped = (0..whole.len()).step_by(3).map(|place| {
            let mut bytes = whole.clone();
            bytes[place] ^= 1 << (place % 8);
            bytes
        });
        let (of_bits, _) = refused(flipped);
        // What is written over bytes are numbers as they stand for sizes, links and counts.
        let written_over = (0..whole.len().saturating_sub(8)).step_by(8).flat_map(|place| {
            [u64::MAX, 0, 1 << 40, place as u64].map(|number| {
                let mut bytes = whole.clone();
                bytes[place..place + 8].copy_from_slice(&number.to_le_bytes());
                bytes
            })
        });
        let (of_numbers, _) = refused(written_over);
        assert!(of_bits > 0 && of_numbers > 0, "{of_bits} {of_numbers}");
    }
}

#[test]
fn another_version_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("old.mdf");
    let mut bytes = b"MDF     3.30    bench   ".to_vec();
    bytes.extend([0_u8; 400]);
    bytes[28..30].copy_from_slice(&330_u16.to_le_bytes());
    std::fs::write(&path, bytes).unwrap();
    let error = Capture::load(&path).unwrap_err().to_string().replace(path.to_str().unwrap(), "FILE");
    assert_eq!(error, "FILE: it is MDF 3.30, and only MDF 4 is read; save it as MDF 4.10");
}
