//! The columns that a structure's effects make of a motion, in rows.

use std::ops::Range;

use dynamics::{Bristles, Direction, Effect, Motion, Part, Regressors};

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::structure::Structure;
use crate::preparation::motion::KnobMotion;
use crate::preparation::row_filter;

/// Writes columns for a range of samples.
pub(crate) type Columns<'a> = Box<dyn FnMut(Range<usize>, &mut [Vec<f64>]) + 'a>;

impl Structure {
    /// The columns of the effect at an index, unfiltered; at samples that are masked they may be zero.
    pub(crate) fn columns_of<'a>(&'a self, index: usize, capture: &'a Capture) -> Columns<'a> {
        let Capture { motion, row_filter, .. } = capture;
        let effect = &self.effects[index];
        let width = self.widths()[index];
        match (effect.kind().part, effect.kind().regressors) {
            (Part::Bristles(bristles), _) => {
                let deflections = deflections(bristles(effect.values()), motion);
                Box::new(row_filter.by_sample(width, move |at, row| {
                    row[0] = Bristles::bending_rad_s(deflections[at], motion.velocity_rad_s[at]);
                }))
            }
            (Part::LoadFriction(_), _) => {
                let model = self.model();
                Box::new(row_filter.by_sample(width, move |at, row| {
                    let now = motion.at(at);
                    row[0] = now.velocity_sign() * model.load_mnm(&now).abs();
                }))
            }
            (Part::Friction(_) | Part::FrictionTable(_), Some(regressors)) if self.bristles().is_some() => {
                Box::new(row_filter.by_sample(width, self.friction_columns(effect, regressors, motion, false)))
            }
            (part @ (Part::CoulombFactor(_) | Part::FrictionFactor(_)), Some(regressors)) => {
                let friction_mnm = self.friction_mnm(motion, matches!(part, Part::CoulombFactor(_)));
                Box::new(row_filter.by_sample(width, move |at, row| {
                    let (friction_mnm, factors) = (friction_mnm(at), filled(effect, regressors, &motion.at(at)));
                    row.iter_mut().zip(factors).for_each(|(slot, factor)| *slot = friction_mnm * factor);
                }))
            }
            _ => Box::new(move |range, columns| {
                row_filter::fill(effect, motion, |at| row_filter.mask[at] != 0.0, range, columns);
            }),
        }
    }

    /// Rows of the products of a friction's columns with those of a factor on it: one list for each column of the friction,
    /// with one product for each column of the factor.
    pub(crate) fn product_rows(&self, friction: usize, factor: usize, capture: &Capture) -> Vec<Vec<Vec<f64>>> {
        let [effect, by] = [friction, factor].map(|index| &self.effects[index]);
        let (Some(own), Some(others)) = (effect.kind().regressors, by.kind().regressors) else { return Vec::new() };
        let of_coulomb = matches!(by.kind().part, Part::CoulombFactor(_));
        let columns_at = self.friction_columns(effect, own, &capture.motion, of_coulomb);
        let (width, depth) = (self.columns[friction], self.columns[factor]);
        let mut frictions = vec![0.0; width];
        let rows = capture.row_filter.rows_by_sample(width * depth, |at, products| {
            columns_at(at, &mut frictions);
            let factors = filled(by, others, &capture.motion.at(at));
            for (products, friction) in products.chunks_mut(depth).zip(&frictions) {
                products.iter_mut().zip(factors).for_each(|(product, factor)| *product = friction * factor);
            }
        });
        rows.chunks(depth).map(<[_]>::to_vec).collect()
    }

    /// The columns of the effect at an index at every sample that is compared, unfiltered.
    pub(crate) fn columns_at_samples(&self, index: usize, capture: &Capture) -> Vec<Vec<f64>> {
        let samples = capture.motion.len();
        let mut columns = vec![vec![0.0; samples]; self.columns[index]];
        self.columns_of(index, capture)(0..samples, &mut columns);
        columns
    }

    /// Friction that grows with the load, as a signed share of the load's torque at every sample; `None` without such friction.
    pub(crate) fn load_factor(&self, motion: &KnobMotion) -> Option<Vec<f64>> {
        let model = self.model();
        let coefficient = model.load_friction();
        let at = |index: usize| {
            let now = motion.at(index);
            coefficient * now.velocity_sign() * model.load_mnm(&now).signum()
        };
        (coefficient != 0.0).then(|| (0..motion.angle_rad.len()).map(at).collect())
    }

    /// Writes the leading columns of a friction effect at a sample, or with `coulomb_only` its Coulomb columns alone. With bristles, the
    /// Coulomb columns follow the deflection.
    fn friction_columns<'a>(
        &self,
        effect: &'a Effect,
        regressors: Regressors,
        motion: &'a KnobMotion,
        coulomb_only: bool,
    ) -> impl Fn(usize, &mut [f64]) + use<'a> {
        let deflections = self.bristles().map(|bristles| deflections(bristles, motion));
        move |at: usize, row: &mut [f64]| {
            let now = motion.at(at);
            let mut columns = [0.0; dynamics::MAX_PARAMETERS];
            row.fill(0.0);
            let mut add = |motion: &Motion, by: f64| {
                (regressors.fill)(effect, motion, &mut columns[..regressors.columns]);
                row.iter_mut().zip(&columns).for_each(|(row, column)| *row += by * column);
            };
            let still = slowest(now.velocity_rad_s, &now);
            match deflections.as_ref().map(|deflections| deflections[at]) {
                None => add(if coulomb_only { &still } else { &now }, 1.0),
                Some(bent) => {
                    add(&slowest(bent, &now), bent.abs());
                    if !coulomb_only {
                        add(&now, 1.0);
                        add(&still, -1.0);
                    }
                }
            }
        }
    }

    /// Returns the torque of friction at a sample, mNm, without the factors on it.
    pub(crate) fn friction_mnm(&self, motion: &KnobMotion, coulomb_only: bool) -> impl Fn(usize) -> f64 {
        let deflections = self.bristles().map(|bristles| deflections(bristles, motion));
        let frictions: Vec<&Effect> = self.frictions().into_iter().map(|index| &self.effects[index]).collect();
        let sum = move |motion: &Motion, direction| -> f64 {
            frictions.iter().map(|effect| effect.friction_mnm(motion, direction)).sum()
        };
        move |index: usize| {
            let now = motion.at(index);
            let still = Motion { velocity_rad_s: 0.0, ..now };
            let direction = Direction::of(now.velocity_rad_s);
            match &deflections {
                Some(bent) => {
                    let coulomb = bent[index].abs() * sum(&still, Direction::of(bent[index]));
                    if coulomb_only { coulomb } else { coulomb + sum(&now, direction) - sum(&still, direction) }
                }
                None if now.velocity_rad_s == 0.0 => 0.0,
                None if coulomb_only => sum(&still, direction),
                None => sum(&now, direction),
            }
        }
    }
}

/// An effect's columns at a motion.
fn filled(effect: &Effect, regressors: Regressors, motion: &Motion) -> [f64; dynamics::MAX_PARAMETERS] {
    let mut row = [0.0; dynamics::MAX_PARAMETERS];
    (regressors.fill)(effect, motion, &mut row[..regressors.columns]);
    row
}

/// The motion at the lowest speed with the sign of `sign`.
fn slowest(sign: f64, motion: &Motion) -> Motion {
    Motion { velocity_rad_s: if sign == 0.0 { 0.0 } else { sign.signum() * f64::MIN_POSITIVE }, ..*motion }
}

/// Deflection z of the bristles at every sample; unbent at the start.
fn deflections(bristles: Bristles, motion: &KnobMotion) -> Vec<f64> {
    let bent = motion.angle_rad.windows(2).scan(0.0, |deflection, pair| {
        *deflection = bristles.bent(*deflection, pair[1] - pair[0]);
        Some(*deflection)
    });
    std::iter::once(0.0).chain(bent).collect()
}
