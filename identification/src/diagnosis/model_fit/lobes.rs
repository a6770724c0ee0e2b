//! Detents with a place and a height each, as half sines from one zero of their torque to the next.

use std::f64::consts::{PI, TAU};

use dynamics::{Coordinate, Curve, Effect, TableUse, TorqueTable, effects};

/// A step moves a zero by at most this share of the distance between two.
const LARGEST_STEP: f64 = 0.3;
/// The detents repeat after a turn if their number in a turn differs from a whole number by less than this.
const WHOLE: f64 = 0.15;
/// Most lobes, two to a detent: hardly any knob has more than forty detents, but a motor's cogging has.
const MOST_LOBES: usize = 80;
/// Relative difference up to which two heights are one.
const EQUAL: f64 = 1e-9;

/// The part of the detents that has a place and a height of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unit {
    /// A detent from one rest to the next: peak and trough are equally high, and half way between the rests is the wall.
    BetweenRests,
    /// A detent from one wall to the next.
    BetweenWalls,
    /// Each lobe: peaks and troughs differ.
    Lobe,
}

/// Detents as lobes: half a sine from each zero to the next, of alternating sign.
#[derive(Clone)]
pub(crate) struct Lobes {
    unit: Unit,
    /// Zeros in rising order, within one period, rad; the knob rests at every other one, from the first on.
    pub(crate) zeros_rad: Vec<f64>,
    /// Height of the lobe that begins at each zero, mNm; every other one is a trough.
    pub(crate) heights_mnm: Vec<f64>,
    /// Angle after which they repeat, rad.
    pub(crate) period_rad: f64,
}

impl Lobes {
    /// Equal lobes in the place of a detent, over the angles of a capture; `None` for too few or too many of them.
    pub(crate) fn equal(unit: Unit, detent: &Effect, lowest_rad: f64, highest_rad: f64) -> Option<Self> {
        let [amplitude_mnm, period, phase] = *detent.values() else { return None };
        let in_turn = (1.0 / period).round();
        let repeats = (1.0 / period - in_turn).abs() < WHOLE;
        let detents = if repeats { in_turn } else { ((highest_rad - lowest_rad) / (TAU * period)).ceil() + 1.0 };
        let count = 2 * detents as usize;
        if !(4..=MOST_LOBES).contains(&count) {
            return None;
        }
        let period_rad = if repeats { TAU } else { detents * TAU * period };
        let middle_rad = 0.5 * (lowest_rad + highest_rad);
        // A zero with rising torque half a period below the middle of the travel.
        let turns = ((middle_rad / period + phase) / TAU).round();
        let first_rad = period * (TAU * turns - phase) - (0.5 * detents).floor() * period_rad / detents;
        Some(Self {
            unit,
            zeros_rad: (0..count).map(|lobe| first_rad + lobe as f64 * period_rad / count as f64).collect(),
            heights_mnm: vec![amplitude_mnm; count],
            period_rad,
        })
    }

    /// The lobes of an effect, with the unit determined by which heights are equal; `None` for an effect without lobes.
    pub(crate) fn of(effect: &Effect) -> Option<Self> {
        if !std::ptr::eq(effect.kind(), &effects::unequal_detents::KIND) {
            return None;
        }
        let (scale, table) = (effect.values()[0], effect.table()?);
        let every_other =
            |values: &[f64], first: usize| values.iter().skip(first).step_by(2).copied().collect::<Vec<_>>();
        let heights = every_other(table.points_mnm(), 1).into_iter().enumerate();
        let lobes = Self {
            unit: Unit::Lobe,
            zeros_rad: every_other(table.points(), 0),
            heights_mnm: heights.map(|(lobe, height)| scale * sign(lobe) * height).collect(),
            period_rad: table.period_rad()?,
        };
        let tied = [Unit::BetweenRests, Unit::BetweenWalls].map(|unit| Self { unit, ..lobes.clone() });
        Some(tied.into_iter().find(Self::is_tied).unwrap_or(lobes))
    }

    /// Whether lobes of one unit are equally high.
    fn is_tied(&self) -> bool {
        let count = self.lobes();
        count.is_multiple_of(2)
            && (0..count).all(|lobe| {
                let other = self.heights_mnm[self.first_lobe(self.unit_of(lobe))];
                (self.heights_mnm[lobe] - other).abs() <= EQUAL * other.abs()
            })
    }

    /// The same with a height and a place of each lobe's own.
    pub(crate) fn each_by_itself(self) -> Self {
        Self { unit: Unit::Lobe, ..self }
    }

    pub(crate) fn lobes(&self) -> usize {
        self.zeros_rad.len()
    }

    /// Number of units: each has a height and a place.
    pub(crate) fn units(&self) -> usize {
        if self.unit == Unit::Lobe { self.lobes() } else { self.lobes() / 2 }
    }

    /// The unit that a lobe belongs to.
    pub(crate) fn unit_of(&self, lobe: usize) -> usize {
        match self.unit {
            Unit::BetweenRests => lobe / 2,
            Unit::BetweenWalls => lobe.div_ceil(2) % self.units(),
            Unit::Lobe => lobe,
        }
    }

    fn first_lobe(&self, unit: usize) -> usize {
        match self.unit {
            Unit::BetweenRests => 2 * unit,
            Unit::BetweenWalls => (2 * unit + self.lobes() - 1) % self.lobes(),
            Unit::Lobe => unit,
        }
    }

    /// The units that move a zero, with their shares: a unit moves the zero at its start alone, and the one in its middle with the next unit.
    pub(crate) fn decided_by(&self, zero: usize) -> [(usize, f64); 2] {
        let unit = self.unit_of(zero);
        if self.first_lobe(unit) == zero {
            [(unit, 1.0), (unit, 0.0)]
        } else {
            [(unit, 0.5), ((unit + 1) % self.units(), 0.5)]
        }
    }

    /// The lobe in which an angle lies, the share of the way from the lobe's first zero to its second, and their distance, rad.
    fn place(&self, angle_rad: f64) -> (usize, f64, f64) {
        let first_rad = self.zeros_rad[0];
        let within_rad = first_rad + (angle_rad - first_rad).rem_euclid(self.period_rad);
        let lobe = self.zeros_rad.partition_point(|zero| *zero <= within_rad).max(1) - 1;
        let width_rad = self.next_zero_rad(lobe) - self.zeros_rad[lobe];
        (lobe, (within_rad - self.zeros_rad[lobe]) / width_rad, width_rad)
    }

    pub(crate) fn next_zero_rad(&self, lobe: usize) -> f64 {
        self.zeros_rad.get(lobe + 1).copied().unwrap_or(self.zeros_rad[0] + self.period_rad)
    }

    /// Derivatives of the torque at an angle, each with its column: one by the height of a unit, four by places of units.
    pub(crate) fn derivatives(&self, angle_rad: f64) -> [(usize, f64); 5] {
        let (lobe, share, width_rad) = self.place(angle_rad);
        let sign = sign(lobe);
        let (sine, cosine) = (PI * share).sin_cos();
        // sin(π·(θ − z)/w), w the distance to the next zero: its derivatives by both zeros.
        let slope = -sign * self.heights_mnm[lobe] * PI * cosine / width_rad;
        let of_zero =
            |zero: usize, share: f64| self.decided_by(zero).map(|(unit, by)| (self.units() + unit, slope * share * by));
        let [first, second] = of_zero(lobe, 1.0 - share);
        let [third, fourth] = of_zero((lobe + 1) % self.lobes(), share);
        [(self.unit_of(lobe), sign * sine), first, second, third, fourth]
    }

    /// The lobes moved by a share of a Gauss–Newton step: new heights of the units, and shifts of their places, rad. `None` if
    /// zeros would overtake each other.
    pub(crate) fn moved(&self, heights_mnm: &[f64], shifts_rad: &[f64], share: f64) -> Option<Self> {
        let most_rad = LARGEST_STEP * self.period_rad / self.lobes() as f64;
        let shift_rad = |(unit, by): (usize, f64)| by * shifts_rad[unit].clamp(-most_rad, most_rad);
        let mut moved = self.clone();
        for lobe in 0..self.lobes() {
            moved.heights_mnm[lobe] += share * (heights_mnm[self.unit_of(lobe)] - moved.heights_mnm[lobe]);
            moved.zeros_rad[lobe] += share * self.decided_by(lobe).map(shift_rad).iter().sum::<f64>();
        }
        // Zeros that overtake each other are no detents.
        (0..self.lobes()).all(|lobe| moved.next_zero_rad(lobe) > moved.zeros_rad[lobe]).then_some(moved)
    }

    /// The same with other heights of the units, mNm.
    pub(crate) fn with_heights(mut self, heights_mnm: &[f64]) -> Self {
        for lobe in 0..self.lobes() {
            self.heights_mnm[lobe] = heights_mnm[self.unit_of(lobe)];
        }
        self
    }

    /// The effect: zeros, and extremes half way between them.
    pub(crate) fn effect(&self) -> Option<Effect> {
        let (mut points, mut torque_mnm) = (Vec::new(), Vec::new());
        for lobe in 0..self.lobes() {
            let zero_rad = self.zeros_rad[lobe];
            points.extend([zero_rad, 0.5 * (zero_rad + self.next_zero_rad(lobe))]);
            torque_mnm.extend([0.0, sign(lobe) * self.heights_mnm[lobe]]);
        }
        let of = TableUse { curve: Curve::Sine, over: Coordinate::Angle, holds: false };
        let table = TorqueTable::kept_for(of, &points, &torque_mnm, Some(self.period_rad)).ok()?;
        Some(Effect::new(&effects::unequal_detents::KIND, &[1.0]).with_table(table))
    }
}

/// Sign of a lobe's torque: from the first zero on it rises.
fn sign(lobe: usize) -> f64 {
    if lobe.is_multiple_of(2) { 1.0 } else { -1.0 }
}
