//! Files of other people's testers: read, or refused in one sentence.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::fmt::Write as _;
use std::path::PathBuf;

use archive::testers::{Assignments, ColumnChoice, Curve};
use shared_types::Axis;

/// What is said of rows that do not belong to their header.
const LONGER: &str =
    "FILE: line 2: it has more cells than the header: name every column, and write numbers with a point, as in 1.5";
/// Gram-force, N.
const GF: f64 = 9.806_65e-3;

fn read(name: &str, text: &(impl AsRef<[u8]> + ?Sized), choice: Option<&ColumnChoice>) -> Result<Curve, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    let curve = Curve::load(&path, choice).map_err(|error| error.to_string().replace(path.to_str().unwrap(), "FILE"));
    curve.inspect_err(|error| assert_eq!(error.lines().count(), 1, "{error}"))
}

/// Twenty rows below a header, made of their number.
fn table(header: &str, row: impl Fn(f64) -> String) -> String {
    (0..20).fold(header.to_owned(), |mut text, number| {
        writeln!(text, "{}", row(f64::from(number))).unwrap();
        text
    })
}

#[test]
fn an_open_switch_curve_meter_is_read_in_newtons_and_seconds() {
    let text = table("Millis,Steps,Travel (mm),Scale raw,Scale (grams)\r\n", |n| {
        format!("{},{},{:.4},1.00,{n}.0\r", 1000.0 + 34.0 * n, 8.0 * n, 0.005 * n)
    });
    let curve = read("DataLog_1.csv", &text, None).unwrap();
    assert_eq!((curve.axis, curve.len(), curve.closed), (Axis::Linear, 20, None));
    assert!((curve.position[3] - 0.015).abs() < 1e-12 && (curve.load[3] - 3.0 * GF).abs() < 1e-12);
    assert!((curve.t_s.unwrap()[3] - 1.102).abs() < 1e-9);
}

#[test]
fn both_exports_of_a_force_recorder_are_read() {
    let head = "MAX FORCE = 199.5,4.320\nMIN FORCE = -0.3,-0.010\nAVERAGE FORCE = 57.64,\nUNIT = gf,mm\n\
                DATA COUNT = 20,\nRECORDING RATE = 0.0005,\nCOMMENT = ,\n1ST PEAK FORCE = ---,---\n";
    let curve = read("a_HighResolutionRaw.csv", &table(head, |n| format!("{n}.5,{}", 0.1 * n)), None).unwrap();
    assert!((curve.load[2] - 2.5 * GF).abs() < 1e-12 && (curve.position[2] - 0.2).abs() < 1e-12);
    assert!((curve.t_s.unwrap()[2] - 0.001).abs() < 1e-12);
    let head = "Maximum,194.3,@,No.1124,,,,,,\nMinimum,-0.2,@,No.4,,,,,,\nData Quantity,20,,,,,,,,\n\
                No.,Force,Unit,Displacement,Unit,Judge,Position,Time,Date,\n";
    let rows = table(head, |n| format!("{n},{n},gf,{},mm,OK,--,11:04:40 AM,3/2/2025,", 0.1 * n));
    let curve = read("a Raw Data CSV.csv", &rows, None).unwrap();
    assert!((curve.load[2] - 2.0 * GF).abs() < 1e-12 && (curve.position[2] - 0.2).abs() < 1e-12);
    assert_eq!(curve.t_s, None);
}

#[test]
fn a_button_bench_tells_time_by_its_clock_and_the_contact_by_its_voltage() {
    let text = table("Date Time , Index ,Force (N),Voltage (V),Linear (mm)\n", |n| {
        let (minute, second) = if n < 10.0 { (59, 59.99 + 0.001 * n) } else { (0, 0.001 * (n - 10.0)) };
        format!("{minute}.{second:07.4},{n},{n},{},{}", if (8.0..15.0).contains(&n) { 1.97 } else { 8.4 }, 0.1 * n)
    });
    let curve = read("bench.csv", &text, None).unwrap();
    assert_eq!(curve.load[4], 4.0);
    let closed: Vec<usize> = (0..20).filter(|row| curve.closed.as_ref().unwrap()[*row]).collect();
    assert_eq!(closed, (8..15).collect::<Vec<_>>());
    assert!((curve.t_s.unwrap()[19] - 0.019).abs() < 1e-6);
}

#[test]
fn two_columns_and_json_are_read_as_quasi_static() {
    let text = table("force,displacement,judge,name\n", |n| format!("{n},{},0,Some Switch", 0.1 * n));
    let curve = read("switch.csv", &text, None).unwrap();
    assert_eq!((curve.t_s, curve.closed), (None, None));
    assert!((curve.load[5] - 5.0 * GF).abs() < 1e-12);
    let list = |factor: f64| (0..20).map(|n| (factor * f64::from(n)).to_string()).collect::<Vec<_>>().join(",");
    let json = format!(
        r#"{{"name": "k", "down_x": [{x}], "down_y": [{y}], "up_x": [{x}], "up_y": [{y}]}}"#,
        x = list(0.1),
        y = list(2.0)
    );
    let curve = read("key.json", &json, None).unwrap();
    assert_eq!(curve.len(), 40);
    // The return is listed from the top on, and comes from the bottom.
    assert!((curve.position[20] - 1.9).abs() < 1e-12 && (curve.load[20] - 38.0 * GF).abs() < 1e-12);
}

#[test]
fn any_other_table_is_read_by_the_columns_that_its_owner_names() {
    let choice = |columns: &str, units: &str| {
        ColumnChoice::new(
            columns.parse().unwrap(),
            if units.is_empty() { Default::default() } else { units.parse().unwrap() },
        )
    };
    let text = table("Zeit;Winkel;M\n", |n| format!("{n},5;{n},0;0,25"));
    let chosen = choice("angle=Winkel,torque=M,time=Zeit", "angle=deg,torque=Ncm,time=ms").unwrap();
    let curve = read("bench.csv", &text, Some(&chosen)).unwrap();
    assert_eq!((curve.axis, curve.load[0]), (Axis::Rotary, 2.5));
    assert!((curve.position[18] - 18_f64.to_radians()).abs() < 1e-12 && (curve.t_s.unwrap()[1] - 1.5e-3).abs() < 1e-12);
    let numbers = table("", |n| format!("{n}\t{}", 2.0 * n));
    let curve = read("plain.txt", &numbers, Some(&choice("travel=1,force=2", "force=mN").unwrap())).unwrap();
    assert!((curve.load[3] - 0.006).abs() < 1e-12);

    let error = read("bench.csv", &text, Some(&choice("angle=Angle,torque=M", "").unwrap())).unwrap_err();
    assert_eq!(error, "FILE: it has no column `Angle`; it has the columns Zeit, Winkel, M");
    assert_eq!(
        choice("angle=W,torque=M", "torque=mm").unwrap_err().to_string(),
        "`mm` is not a unit of torque; known are mNm, Nm, uNm, µNm, cNm, Ncm, Nmm, gfcm, gcm, kgfcm, kgcm, ozin, inlb, lbin"
    );
    assert_eq!(
        choice("angle=W", "").unwrap_err().to_string(),
        "name the columns of angle and torque, or of travel and force"
    );
}

#[test]
fn a_table_is_read_as_spreadsheets_and_scripts_write_it() {
    let choice = |columns: &str| ColumnChoice::new(columns.parse().unwrap(), Default::default()).unwrap();
    let [named, numbered] = ["time=Zeit [s],angle=Winkel [°],torque=M [Nm]", "time=1,angle=2,torque=3"].map(choice);
    let german = table("Zeit [s];Winkel [°];M [Nm]\r\n", |n| format!("0,{n:03};{n},5;0,25\r"));
    let windows_1252: Vec<u8> = german.chars().map(|letter| u8::try_from(u32::from(letter)).unwrap()).collect();
    let utf_16: Vec<u8> = std::iter::once(0xfeff).chain(german.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    for bytes in [german.clone().into_bytes(), windows_1252, utf_16] {
        let curve = read("bench.csv", &bytes, Some(&named)).unwrap();
        assert!((curve.position[2] - 2.5_f64.to_radians()).abs() < 1e-12 && (curve.load[2] - 250.0).abs() < 1e-12);
    }
    // What stands above and below the rows decides nothing.
    let head = "Bench 7; Monday, with tea\nDate,21,11,2024\nLimits,0.5,10\n";
    let text = table(&format!("{head}Zeit [s],Winkel [°],M [Nm]\n"), |n| format!("0.{n:03},{n},0.25"));
    let curve = read("bench.csv", &format!("{text}Samples,20\nend of file\n"), Some(&named)).unwrap();
    assert_eq!((curve.len(), curve.load[19]), (20, 250.0));
    // A row may have more than most, and a name may contain blanks.
    let text = table("Zeit [s],Winkel [°],M [Nm],Max\n", |n| {
        if n < 2.0 { format!("{n},{n},1,7") } else { format!("{n},{n},1,") }
    });
    assert_eq!(read("bench.csv", &text, Some(&named)).unwrap().len(), 20);
    let text = table("Zeit (s) Winkel (deg) M Temp\n", |n| format!("{n} {n} 1 20"));
    let error = read("bench.txt", &text, Some(&choice("angle=Winkel,torque=M"))).unwrap_err();
    assert!(error.contains("has no column `Winkel`"), "{error}");
    // As `numpy.savetxt` writes it.
    for header in ["", "# t angle torque\n", "% t angle torque\n"] {
        let text = table(header, |n| format!("{:.18e} {n:.18e} {:.18e}", 1e-3 * n, 2.0 * n));
        assert_eq!(read("bench.txt", &text, Some(&numbered)).unwrap().load[3], 6.0);
    }
    // Our own names in a form that only this reader takes are still those of a capture of motion.
    for header in ["# t_s angle_rad torque_mnm\n", "# t_s travel_mm force_n\n"] {
        let curve = read("bench.txt", &table(header, |n| format!("{} {n} {}", 1e-3 * n, 2.0 * n)), None).unwrap();
        assert!(curve.is_of_motion && curve.t_s.is_some(), "{header}");
    }
    let text = table("# t angle torque\n", |n| format!("{} {n} {}", 1e-3 * n, 2.0 * n));
    assert_eq!(read("bench.txt", &text, Some(&choice("time=t,angle=angle,torque=torque"))).unwrap().load[3], 6.0);
}

#[test]
fn a_table_of_none_of_these_says_which_columns_it_has_and_what_to_do() {
    let error = read("other.csv", &table("Weg,Kraft\n", |n| format!("{n},{n}")), None).unwrap_err();
    assert_eq!(
        error,
        "FILE is not a known table: it has the columns `Weg`, `Kraft`; name its columns, as in \
         travel=NAME,force=NAME, and their units, as in travel=mm,force=gf"
    );
    // Units of their own, of which one is not known.
    let text = table("No.,Force,Unit,Displacement,Unit\n", |n| format!("{n},{n},KIPS,{n},mm"));
    assert!(read("recorder.csv", &text, None).unwrap_err().contains("is not a known table"));
    let text = table("force,displacement\n", |n| if n == 7.0 { "x,1".to_owned() } else { format!("{n},{n}") });
    let error = "FILE: line 9: `x` in the column force is not a number; correct it, or leave the line out";
    assert_eq!(read("switch.csv", &text, None).unwrap_err(), error);
    assert_eq!(
        read("still.csv", &table("force,displacement\n", |n| format!("{n},1")), None).unwrap_err(),
        "FILE: its travel never changes, so there is no curve"
    );
    assert!(read("key.json", "{\"down_x\": [1]", None).unwrap_err().contains("down_x, down_y, up_x and up_y"));
    assert!(read("words.txt", "some words\nand more\n", None).unwrap_err().contains("no columns of numbers"));
}

#[test]
fn thousands_are_refused_and_neither_read_as_decimals_nor_passed_over() {
    let choice = ColumnChoice::new("travel=x,force=F".parse().unwrap(), Default::default()).unwrap();
    let refusal = |text: &str| read("switch.csv", text, Some(&choice)).unwrap_err();
    let german = table("x;F\n", |n| if n < 10.0 { format!("{n},5;{n}") } else { format!("{n},5;1.{n}0") });
    assert!(refusal(&german).contains("line 12: `1.100` in the column F may have decimals or thousands; write"));
    let both = table("x;F\n", |n| format!("{n},5;1.0{n:02},5"));
    assert!(refusal(&both).contains("line 2: `1.000,5` in the column F is not a number; write it with a point, and"));
    // The last rows are no lines below the table.
    let quoted = table("x,F\n", |n| format!("{n},{}", if n < 15.0 { n.to_string() } else { format!("\"1,0{n}\"") }));
    assert!(refusal(&quoted).contains("line 17: `1,015` in the column F is not a number; write it with a point"));
    let numbers = table("x;F\n", |n| format!("{n},5;1,0{n:02}"));
    assert_eq!(read("switch.csv", &numbers, Some(&choice)).unwrap().load[19], 1.019);
}

#[test]
fn commas_for_both_decimals_and_cells_and_first_rows_without_values_are_refused_by_their_line() {
    let choice = ColumnChoice::new("travel=x,force=F".parse().unwrap(), Default::default()).unwrap();
    let refusal = |text: &str| read("switch.csv", text, Some(&choice)).unwrap_err();
    let parted = refusal(&table("t,x,F\n", |n| format!("0,{n},1,{n},2,5")));
    assert_eq!(parted, LONGER);
    for missing in ["NaN", "NA", ""] {
        let text =
            table("t,x,F\n", |n| format!("{n},{n}.5,{}", if n < 2.0 { missing.to_owned() } else { n.to_string() }));
        let expected =
            format!("line 2: `{missing}` in the column F is not a number; correct it, or leave the line out");
        assert!(refusal(&text).contains(&expected), "{}", refusal(&text));
    }
}

#[test]
fn decimal_commas_in_a_table_parted_by_blanks_are_no_commas_between_cells() {
    let choice = ColumnChoice::new("travel=x,force=F".parse().unwrap(), Default::default()).unwrap();
    let text = table("x F\n", |n| format!("0,{n} {},5", 120.0 + n));
    let curve = read("bench.txt", &text, Some(&choice)).unwrap();
    assert_eq!((curve.len(), curve.position[7], curve.load[19]), (20, 0.7, 139.5));
}

#[test]
fn last_rows_without_values_are_passed_over() {
    let choice = ColumnChoice::new("time=t,travel=x,force=F".parse().unwrap(), Default::default()).unwrap();
    let text = table("t,x,F\n", |n| format!("0.{n:03},{n},{n}.5"));
    for last in ["9.9,NaN,NaN\n", "NaN,NaN,NaN\n", "9.8,NA,n/a\n9.9,NaN,\n"] {
        let curve = read("merged.csv", &format!("{text}{last}"), Some(&choice)).unwrap();
        assert_eq!((curve.len(), curve.load[19]), (20, 19.5), "{last}");
    }
    let gap = format!("{text}0.020,NaN,20\n0.021,21,NaN\n0.022,22,22\n");
    let error = read("merged.csv", &gap, Some(&choice)).unwrap_err();
    assert!(error.contains("line 22: `NaN` in the column x is not a number; correct it"), "{error}");
}

#[test]
fn rows_that_are_all_longer_than_the_header_are_refused_and_odd_ones_are_not() {
    let choice = ColumnChoice::new("travel=x,force=F".parse().unwrap(), Default::default()).unwrap();
    let read = |text: &str| read("frame.csv", text, Some(&choice));
    // As R writes a table with the names of its rows.
    for name in ["", "row "] {
        let text = table("\"x\",\"F\"\n", |n| format!("\"{name}{}\",{n}.5,{}.25", n + 1.0, 2.0 * n));
        assert_eq!(read(&text).unwrap_err(), LONGER);
    }
    let with = |header: &str, end: &str, every: f64| {
        read(&table(header, |n| format!("{n}.5,{n}.25{}", if n % every == 0.0 { end } else { "" }))).unwrap()
    };
    for curve in [with("x,F\n", ",", 1.0), with("x,F,\n", ",1.5", 1.0), with("x,F\n", ",1.5", 7.0)] {
        assert_eq!((curve.len(), curve.position[3], curve.load[3]), (20, 3.5, 3.25));
    }
    // Rows without names, below what is none of them.
    let numbered = ColumnChoice::new("travel=1,force=2".parse().unwrap(), Default::default()).unwrap();
    let text = table("Rate,1000\n", |n| format!("{n}.5,{n}.25,1.5"));
    assert!(self::read("rows.csv", &text, Some(&numbered)).is_ok());
}

#[test]
fn a_contacts_two_levels_may_be_written_with_any_decimals() {
    let choice = ColumnChoice::new("travel=x,force=F,contact=U".parse().unwrap(), Default::default()).unwrap();
    let text = table("x;F;U\n", |n| format!("{n}.5;{n};{}", if n < 8.0 { "3.300" } else { "0" }));
    let closed = read("switch.csv", &text, Some(&choice)).unwrap().closed.unwrap();
    assert!((0..20).all(|row| closed[row] == (row >= 8)));
}

#[test]
fn what_is_said_of_a_wrong_date_is_not_what_is_said_of_a_number() {
    let choice = ColumnChoice::new("time=t,travel=x,force=F".parse().unwrap(), Default::default()).unwrap();
    let text = table("t;x;F\n", |n| {
        format!("2026-11-29T23:59:{:02}{};{n},5;{n}", 2.0 * n, if n == 9.0 { ",5,0" } else { "" })
    });
    let error = read("dated.csv", &text, Some(&choice)).unwrap_err();
    assert!(error.contains("is not a date and time, as the first is; correct it, or leave the line out"), "{error}");
}

#[test]
fn every_measured_force_curve_is_read() {
    let Some(sets) = measured_data::folder("force-curves") else { return };
    let sets = std::fs::read_dir(sets).unwrap();
    let mut read = 0;
    let mut folders: Vec<PathBuf> = sets.map(|set| set.unwrap().path()).filter(|path| path.is_dir()).collect();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                folders.push(entry);
            } else {
                let curve = Curve::load(&entry, None).unwrap();
                assert_eq!(curve.axis, Axis::Linear);
                read += 1;
            }
        }
    }
    assert!(read >= 33, "{read} files");
}

#[test]
fn a_contact_is_read_from_a_flag_whatever_its_column_is_called() {
    let rows = |header: &str| table(header, |n| format!("{},{n},{}", 0.1 * n, u8::from((5.0..12.0).contains(&n))));
    let closed: Vec<bool> = (0..20).map(|row| (5..12).contains(&row)).collect();
    let ours = read("ours.csv", &rows("travel_mm,force_n,contact\n"), None).unwrap();
    assert_eq!(ours.closed.as_ref(), Some(&closed));
    let chosen =
        ColumnChoice::new("travel=x,force=F,contact=switch".parse().unwrap(), "force=gf".parse().unwrap()).unwrap();
    assert_eq!(read("any.csv", &rows("x,F,switch\n"), Some(&chosen)).unwrap().closed, Some(closed.clone()));
    let contact = ours.into_capture().unwrap().contact.unwrap();
    assert!(contact.iter().zip(closed).all(|(value, closed)| *value == f64::from(u8::from(closed))));
}

#[test]
fn units_in_the_names_of_chosen_columns_are_converted() {
    let chosen = |columns: &str| ColumnChoice::new(columns.parse().unwrap(), Assignments::default()).unwrap();
    for (header, columns) in [
        ("Time [ms],Position [deg],Torque [N·m]\n", "time=Time [ms],angle=Position [deg],torque=Torque [N·m]"),
        ("t_ms,pos_deg,M (Nm)\n", "time=t_ms,angle=pos_deg,torque=M (Nm)"),
    ] {
        let text = table(header, |n| format!("{n},{},0.002", 180.0 * n));
        let curve = read("named.csv", &text, Some(&chosen(columns))).unwrap();
        assert!((curve.t_s.unwrap()[1] - 1e-3).abs() < 1e-12, "{header}");
        assert!((curve.position[1] - std::f64::consts::PI).abs() < 1e-12, "{header}");
        assert!((curve.load[1] - 2.0).abs() < 1e-12, "{header}");
    }
    // A row of units may lie under that of the names.
    let text =
        table("time,angle,torque,temperature\n[ms],[DEG],[Nm],[°C]\n", |n| format!("{n},{},0.002,20", 180.0 * n));
    for columns in
        ["time=[ms],angle=[DEG],torque=[Nm]", "time=time,angle=angle,torque=torque", "time=1,angle=2,torque=3"]
    {
        let curve = read("units.csv", &text, Some(&chosen(columns))).unwrap();
        assert!((curve.t_s.unwrap()[1] - 1e-3).abs() < 1e-12 && (curve.load[1] - 2.0).abs() < 1e-12);
        assert!((curve.position[1] - std::f64::consts::PI).abs() < 1e-12);
    }
    // Times may be dates, and a logger that was switched off may have left half a row.
    for zone in ["", "Z"] {
        let text =
            table("time,angle_deg,torque_Nm\n", |n| format!("2026-11-29T23:59:59.{:03}{zone},{n},0.002", 2.0 * n));
        let curve = read("dated.csv", &format!("{text}2026-11-2"), Some(&chosen("time=1,angle=2,torque=3"))).unwrap();
        assert_eq!(curve.len(), 20);
        assert!((curve.t_s.unwrap()[19] - 0.038).abs() < 1e-9);
    }
    let text = table("time (s),angle (counts),torque (N.m)\n", |n| format!("{n},{n},0.002"));
    assert_eq!(
        read("round.csv", &text, Some(&chosen("time=time (s),angle=angle (counts),torque=torque (N.m)"))).unwrap_err(),
        "FILE: the unit in `angle (counts)` is none of angle; give its unit, as in angle=rad"
    );
    let text = table("time,counts [counts],M\n", |n| format!("{n},{n},1"));
    assert_eq!(
        read("counts.csv", &text, Some(&chosen("time=time,angle=counts [counts],torque=M"))).unwrap_err(),
        "FILE: the unit in `counts [counts]` is none of angle; give its unit, as in angle=rad"
    );
}
