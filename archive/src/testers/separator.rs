//! What stands between the cells of a table, from its first lines.

use std::borrow::Cow;
use std::cmp::Reverse;

/// Stands for blanks, however many, between cells.
pub(super) const BLANKS: u8 = b' ';
/// Lines at a table's beginning that show how it is written.
pub(super) const LOOKED_AT: usize = 1000;

/// What stands between the cells of a table: that with which the lines have the most numbers, and the fewest other cells beside them. Lines above
/// the rows, which hold next to no numbers, do not decide.
pub(super) fn separator(text: &str) -> u8 {
    let lines = text.lines().filter(|line| !line.starts_with('#')).take(LOOKED_AT);
    let numbers_and_others = |separator: u8| {
        let (mut numbers, mut others) = (0, 0);
        for line in lines.clone() {
            let line = if separator == BLANKS { Cow::Owned(with_tabulators(line)) } else { Cow::Borrowed(line) };
            let cells = line.split(if separator == BLANKS { '\t' } else { char::from(separator) });
            let cells = cells.map(|cell| cell.trim().trim_matches('"')).filter(|cell| !cell.is_empty());
            let (of_line, all) = cells.fold((0, 0), |(numbers, all), cell| {
                // Between commas a blank parts cells of another table: `0,5 120,3`.
                let may_have_thousands = separator != b',' || !cell.contains(' ');
                let is_number = foreign_files::with_point(cell, separator).parse::<f64>().is_ok_and(f64::is_finite)
                    || may_have_thousands && foreign_files::has_thousands(cell);
                (numbers + usize::from(is_number), all + 1)
            });
            if of_line > 1 {
                (numbers, others) = (numbers + of_line, others + all - of_line);
            }
        }
        (numbers, Reverse(others))
    };
    // Of equals the last: a comma beside tabulators or semicolons is a decimal comma.
    let fits = [BLANKS, b',', b'\t', b';'].map(|separator| (numbers_and_others(separator), separator));
    let best = fits.into_iter().max_by_key(|(fit, _)| *fit).filter(|((numbers, _), _)| *numbers > 0);
    best.map_or(b',', |(_, separator)| separator)
}

/// A line with tabulators in place of blanks.
pub(super) fn with_tabulators(line: &str) -> String {
    line.split_whitespace().collect::<Vec<_>>().join("\t") + "\n"
}
