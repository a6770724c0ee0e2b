//! Rows that wait until it is their turn to be sent: a browser pays for each message, not for each row.

use crate::frame::SeriesRows;

/// Rows by the entity that shows them.
#[derive(Clone, Debug, Default)]
pub struct WaitingRows(Vec<SeriesRows>);

impl WaitingRows {
    /// Adds a row; all rows of an entity have equally many values.
    pub fn push(&mut self, entity: String, time_ns: i64, values: &[f64]) {
        let place = self.0.iter().position(|rows| rows.entity == entity).unwrap_or_else(|| {
            let values_per_row = values.len();
            self.0.push(SeriesRows { entity, times_ns: Vec::new(), values: Vec::new(), values_per_row });
            self.0.len() - 1
        });
        self.0[place].times_ns.push(time_ns);
        self.0[place].values.extend_from_slice(values);
    }

    /// All rows, each handed out once.
    pub fn take(&mut self) -> Vec<SeriesRows> {
        std::mem::take(&mut self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_one_entity_go_together() {
        let mut waiting = WaitingRows::default();
        for time_ns in [1, 2] {
            waiting.push("fit/inertia".to_owned(), time_ns, &[0.5, 0.25, 0.75]);
            waiting.push("fit/detent_phase".to_owned(), time_ns, &[0.1, 0.0, 0.2]);
        }
        let rows = waiting.take();
        assert_eq!(rows.len(), 2);
        assert_eq!((rows[0].times_ns.as_slice(), rows[0].values.len()), ([1, 2].as_slice(), 6));
        assert!(waiting.take().is_empty());
    }
}
