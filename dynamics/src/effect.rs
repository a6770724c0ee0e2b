//! An effect of one knob: its kind, and the values of its parameters.

use crate::{Direction, EffectKind, MAX_PARAMETERS, Minimum, Motion, ParameterKind, Part, Search, TorqueTable};

/// An effect with its values on one knob.
///
/// It is copied freely, also in the real-time loop, which must neither allocate nor free memory: a drawn table and a
/// note on the origin are therefore kept for as long as the program runs, each of them once.
#[derive(Clone, Copy, Debug)]
pub struct Effect {
    kind: &'static EffectKind,
    values: [f64; MAX_PARAMETERS],
    table: Option<&'static TorqueTable>,
    origin: Option<&'static str>,
}

/// Compares kind, values and table; the note on the origin does not count.
impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        self.kind.name == other.kind.name && self.values() == other.values() && self.table == other.table
    }
}

impl Effect {
    /// An effect of `kind` with the values given, in the order of the kind's parameters; values left out are zero.
    #[must_use]
    pub fn new(kind: &'static EffectKind, values: &[f64]) -> Self {
        let mut stored = [0.0; MAX_PARAMETERS];
        for (slot, value) in stored.iter_mut().zip(values) {
            *slot = *value;
        }
        Self { kind, values: stored, table: None, origin: None }
    }

    /// The same effect with a table, for a kind whose part is [`Part::TorqueTable`] or [`Part::FrictionTable`].
    #[must_use]
    pub fn with_table(self, table: &'static TorqueTable) -> Self {
        Self { table: Some(table), ..self }
    }

    /// The same effect with a note on where it comes from.
    #[must_use]
    pub fn with_origin(self, origin: &str) -> Self {
        Self { origin: Some(crate::interned::text(origin)), ..self }
    }

    /// The same effect without that note, for values that were fitted since.
    #[must_use]
    pub fn without_origin(self) -> Self {
        Self { origin: None, ..self }
    }

    /// What effect this is.
    #[must_use]
    pub fn kind(&self) -> &'static EffectKind {
        self.kind
    }

    /// The drawn table, if it has one.
    #[must_use]
    pub fn table(&self) -> Option<&'static TorqueTable> {
        self.table
    }

    /// Origin of the effect in a composed model, as noted in its file.
    #[must_use]
    pub fn origin(&self) -> Option<&'static str> {
        self.origin
    }

    /// The values in the order of the kind's parameters.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values[..self.kind.parameters.len()]
    }

    /// The values, to be changed.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values[..self.kind.parameters.len()]
    }

    /// The parameters with their values, of the lines that occur.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static ParameterKind, f64)> + '_ {
        let occurring = self.kind.parameters_of_a_line() * self.lines();
        self.kind.parameters.iter().zip(self.values().iter().copied()).take(occurring)
    }

    /// Whether a parameter is absent: zero, and one that a file may leave out.
    #[must_use]
    pub fn is_absent(&self, parameter: usize) -> bool {
        self.kind().parameters[parameter].minimum == Minimum::ZeroOrAbsent && self.values()[parameter] == 0.0
    }

    /// The searches for parameters of the first `columns` columns that are neither absent nor tied to another effect; none without a hypothesis.
    pub fn free_searches(&self, columns: usize) -> impl Iterator<Item = &'static Search> + '_ {
        let used = self.kind().parameters_in(columns);
        let is_free = move |search: &&Search| {
            search.same_as.is_none() && search.parameter < used && !self.is_absent(search.parameter)
        };
        self.kind().searches().iter().filter(is_free)
    }

    /// Number of its columns in a fit, of the lines that occur.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.kind.columns_of_a_line() * self.lines()
    }

    /// How many times its law occurs; at least once.
    fn lines(&self) -> usize {
        let occurs = |line: &[f64]| line.iter().any(|value| *value != 0.0);
        let last = self.values().chunks_exact(self.kind.parameters_of_a_line().max(1)).rposition(occurs);
        last.map_or(1, |last| last + 1).min(self.kind.lines())
    }

    /// Its torque that depends on neither acceleration nor the direction of sliding, mNm; zero where it has none.
    #[must_use]
    pub fn free_torque_mnm(&self, motion: &Motion) -> f64 {
        match (self.kind.part, self.table) {
            (Part::Torque(torque), _) => torque(self.values(), motion),
            (Part::TorqueTable(of), Some(table)) => self.values[0] * of.torque_mnm(table, motion),
            (Part::VaryingInertia(inertia), _) => {
                0.5 * inertia(self.values(), motion.angle_rad)[1] * motion.velocity_rad_s.powi(2)
            }
            _ => 0.0,
        }
    }

    /// Its friction while sliding in `direction`, mNm; zero where it has none.
    #[must_use]
    pub fn friction_mnm(&self, motion: &Motion, direction: Direction) -> f64 {
        match (self.kind.part, self.table) {
            (Part::Friction(friction), _) => friction(self.values(), motion, direction),
            (Part::FrictionTable(of), Some(table)) => direction.sign() * self.values[0] * of.torque_mnm(table, motion),
            _ => 0.0,
        }
    }

    /// Writes the column of an effect whose table's scale is fitted: its torque while turning as given, at scale 1.
    pub(crate) fn table_column(&self, motion: &Motion, row: &mut [f64]) {
        let unscaled = Self { values: [1.0; MAX_PARAMETERS], ..*self };
        row[0] = match self.kind.part {
            Part::FrictionTable(_) if motion.velocity_rad_s == 0.0 => 0.0,
            Part::FrictionTable(_) => unscaled.friction_mnm(motion, Direction::of(motion.velocity_rad_s)),
            _ => unscaled.free_torque_mnm(motion),
        };
    }
}
