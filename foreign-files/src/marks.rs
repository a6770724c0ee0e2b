//! Commas and points in numbers, which stand before decimals or between thousands.

/// The two marks.
const MARKS: [char; 2] = [',', '.'];

/// The numbers of a column, as far as they show what the marks in them mean. Only a table whose cells are not separated by commas
/// leaves that open.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    /// Line and cell in which each mark came first.
    seen: [Option<(u64, String)>; 2],
    /// Whether each mark stands before decimals for certain.
    is_decimal: [bool; 2],
    /// Whether there are whole numbers below 1000 …
    has_whole: bool,
    /// … and such above it without a mark.
    has_long: bool,
}

impl Marks {
    /// Takes note of a number as it stands in a line.
    pub fn note(&mut self, cell: &str, line: u64) {
        let digits = cell.trim_start_matches(['+', '-']);
        let Some((place, (whole, rest))) =
            MARKS.iter().enumerate().find_map(|(place, mark)| Some((place, digits.split_once(*mark)?)))
        else {
            let is_long = digits.len() > 3;
            self.has_long |= is_long;
            self.has_whole |= !is_long;
            return;
        };
        let may_be_thousands = (1..=3).contains(&whole.len()) && !whole.starts_with('0') && is_group(rest);
        self.is_decimal[place] |= !may_be_thousands;
        self.seen[place].get_or_insert_with(|| (line, cell.to_owned()));
    }

    /// Why the numbers of a column could also mean others, with the line in which that shows; `None` if they could not.
    #[must_use]
    pub fn doubt(&self, column: &str) -> Option<(u64, String)> {
        let [comma, point] = &self.seen;
        let is_open = self.has_whole || comma.is_some() && point.is_some();
        let mut seen = self.seen.iter().zip(self.is_decimal).filter(|(_, is_decimal)| !is_decimal && !self.has_long);
        let (line, cell) = seen.find_map(|(first, _)| first.as_ref()).filter(|_| is_open)?;
        let reason = format!(
            "`{cell}` in the column {column} may have decimals or thousands; write its numbers without separators of thousands, \
             all with a point and equally many decimals"
        );
        Some((*line, reason))
    }
}

/// Whether a cell is a number with separators of thousands for certain, as in `1,234.5`, `1.234.567` and `1'234`.
#[must_use]
pub fn has_thousands(cell: &str) -> bool {
    let digits = cell.trim_start_matches(['+', '-']);
    let mut parts = digits.split([',', '.', '\'', '’', ' ', '\u{a0}', '\u{202f}']);
    let first = parts.next().unwrap_or_default();
    let parts: Vec<&str> = parts.collect();
    let Some((&last, groups)) = parts.split_last() else { return false };
    let is_certain = !groups.is_empty() || !digits.contains(MARKS) && is_group(last);
    let is_digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    is_certain && first.len() <= 3 && is_digits(first) && is_digits(last) && groups.iter().all(|group| is_group(group))
}

fn is_group(part: &str) -> bool {
    part.len() == 3 && part.bytes().all(|byte| byte.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::{Marks, has_thousands};

    fn is_doubtful(cells: &[&str]) -> bool {
        let mut marks = Marks::default();
        cells.iter().for_each(|cell| marks.note(cell, 1));
        marks.doubt("force").is_some()
    }

    #[test]
    fn a_mark_that_may_part_thousands_is_doubtful_unless_another_number_tells() {
        for cells in [["999", "1,000"], ["0", "-1.234"], ["0,5", "1.234"], ["999.5", "1,234"]] {
            assert!(is_doubtful(&cells), "{cells:?}");
        }
        for cells in [
            ["999", "1,5"],
            ["0.001", "1.000"],
            ["1500", "1.234"],
            ["2,5", "0.3"],
            ["1,234", "5,678"],
            ["1e-3", "2.5e-3"],
        ] {
            assert!(!is_doubtful(&cells), "{cells:?}");
        }
    }

    #[test]
    fn separators_of_thousands_are_known_and_dates_and_times_are_none() {
        for cell in ["1,234.5", "-1.234,56", "1.234.567", "1'234", "1\u{a0}234,5"] {
            assert!(has_thousands(cell), "{cell}");
        }
        for cell in ["1.234", "1,234", "29.11.2026", "59.12.3450", "1234", "", "-", "a,bcd.e", "1,2,3"] {
            assert!(!has_thousands(cell), "{cell}");
        }
    }
}
