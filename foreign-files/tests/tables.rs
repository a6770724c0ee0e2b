//! One reader for every table of numbers.
#![allow(clippy::unwrap_used, reason = "tests")]

use foreign_files::{Column, OtherColumns, TableError, read_columns};

fn read(text: &str, others: OtherColumns) -> Result<[Option<Vec<f64>>; 3], TableError> {
    let wanted = [Column::required("t_s"), Column::required("angle_rad"), Column::optional("torque_mnm")];
    read_columns(text.as_bytes(), wanted, others)
}

fn refusal(text: &str) -> String {
    read(text, OtherColumns::Refused).unwrap_err().to_string()
}

#[test]
fn what_spreadsheets_and_people_add_is_passed_over() {
    let expected = [Some(vec![0.0, 1.0]), Some(vec![2.5, -3e-1]), None];
    for text in [
        "t_s,angle_rad\n0,2.5\n1,-3e-1\n",
        "\u{feff}t_s,angle_rad\r\n0,2.5\r\n1,-3e-1",
        "angle_rad,t_s\n2.5,0\n-3e-1,1\n",
        ",t_s,angle_rad\n0,0,2.5\n1,1,-3e-1\n",
        "\"t_s\",\"angle_rad\"\n\"0\",\"2.5\"\n 1 , -3e-1 \n",
        "# drawn by hand\nt_s,angle_rad\n\n0,2.5\n# half way\n\n1,-3e-1\n\n",
        "t_s,angle_rad,\n0,2.5,\n1,-3e-1,,\n",
        "t_s;angle_rad\n0;2,5\n1;-3e-1\n",
        "% MATLAB\nt_s,angle_rad\n0,2.5\n1,-3e-1\n",
        "Recorded by rig 7, on Monday\n\"Rate: 1000 Hz\"\n\nt_s;angle_rad\n0;2,5\n1;-3e-1\n",
        "# by NumPy\n# t_s,angle_rad\n0,2.5\n1,-3e-1\n",
        "# drawn; by hand\nT_S\tAngle_rad\n0\t2,5\n1\t-0.3\n",
    ] {
        assert_eq!(read(text, OtherColumns::Refused).unwrap(), expected, "{text:?}");
    }
}

#[test]
fn other_columns_are_passed_over_only_where_that_was_said() {
    let text = "t_s,colour,angle_rad\n0,red,1\n";
    assert_eq!(read(text, OtherColumns::Ignored).unwrap(), [Some(vec![0.0]), Some(vec![1.0]), None]);
    assert_eq!(
        refusal(text),
        "it has the columns `t_s,colour,angle_rad`, but they must be `t_s,angle_rad[,torque_mnm]`"
    );
}

#[test]
fn a_wrong_table_is_reported_with_its_line() {
    for (text, expected) in [
        ("", "it has the columns ``, but they must be `t_s,angle_rad[,torque_mnm]`"),
        ("t_s,angle_rad,t_s\n", "it has the columns `t_s,angle_rad,t_s`, but"),
        (
            "t_s;angle_rad\n0;2.000,5\n",
            "line 2: `2.000,5` in the column angle_rad is not a number; write it with a point",
        ),
        (
            "t_s;angle_rad\n0;999\n1;1,000\n",
            "line 3: `1,000` in the column angle_rad may have decimals or thousands; write",
        ),
        (
            "t_s\tangle_rad\n0\t0,5\n1\t1.500\n",
            "line 3: `1.500` in the column angle_rad may have decimals or thousands",
        ),
        ("t_s,angle_rad\n0,1\n0,2,5\n", "line 3: it has 3 cells, but the header has 2; write numbers with a point"),
        ("t_s,angle_rad\n0\n", "line 2: it has 1 cells, but the header has 2"),
        ("// rig 7\nt_s,angle_rad\n0\n", "line 3: it has 1 cells, but the header has 2"),
        ("t_s,angle_rad\n0,\"2,5\"\n", "line 2: `2,5` in the column angle_rad is not a number; write it with a point"),
        ("t_s,angle_rad\n0,\n", "line 2: the column angle_rad has no value; fill it in, or leave the line out"),
        ("t_s,angle_rad\n0,NaN\n", "line 2: angle_rad is NaN, but it must be a finite number"),
        ("t_s,angle_rad\n0,1e999\n", "line 2: angle_rad is inf, but it must be a finite number"),
    ] {
        assert!(refusal(text).contains(expected), "{text:?}: {}", refusal(text));
    }
    let bytes: &[u8] = b"t_s,angle_rad\n0,\xff\n";
    let wanted = [Column::required("t_s")];
    assert!(matches!(read_columns(bytes, wanted, OtherColumns::Ignored), Err(TableError::NotText)));
}

#[test]
fn a_whole_file_in_one_cell_is_quoted_shortened() {
    let long = "x".repeat(1_000_000);
    for text in [long.clone(), format!("t_s,angle_rad\n0,{long}\n"), format!("t_s,angle_rad\n\u{1b}[2J{long}\n")] {
        assert!(refusal(&text).len() < 400);
        assert!(!refusal(&text).contains('\u{1b}'));
    }
}
