//! Rows and columns of a structure's effects that a separable fit keeps for one capture, recomputed only where a value changed.

use std::sync::Arc;

use dynamics::Part;

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::structure::Structure;

/// Rows, and columns at every sample, of a structure's effects.
#[derive(Clone, Default)]
pub(super) struct Kept {
    /// Rows of each effect's columns.
    pub(super) rows: Vec<Vec<Vec<f64>>>,
    pub(super) products: Vec<Product>,
    /// Columns at every sample of each effect of the load, by its index; none where no friction grows with the load.
    pub(super) loads: Vec<(usize, Arc<Vec<Vec<f64>>>)>,
}

/// Rows of the products of a friction's and a factor's columns, with the indices of both effects: the factor multiplies friction
/// levels that are coefficients too.
#[derive(Clone)]
pub(super) struct Product {
    pub(super) friction: usize,
    pub(super) factor: usize,
    /// One list for each column of the friction, with one product for each column of the factor.
    pub(super) rows: Arc<Vec<Vec<Vec<f64>>>>,
}

impl Kept {
    /// Updates what was kept for `before` to `after`, which may have other values and further effects at the end; only what
    /// changed is recomputed.
    pub(super) fn updated(mut self, before: &Structure, after: &Structure, capture: &Capture) -> Self {
        let changed = changed(before, after);
        self.rows.resize(after.effects.len(), Vec::new());
        for index in &changed {
            self.rows[*index] = match after.effects[*index].kind().part {
                // They follow from the coefficients.
                Part::LoadFriction(_) => vec![Vec::new()],
                _ => capture.rows_of(after, *index),
            };
        }
        let product = |friction: usize, factor: usize| {
            let known = self.products.iter().find(|product| product.friction == friction && product.factor == factor);
            let known = known.filter(|_| !changed.contains(&friction) && !changed.contains(&factor));
            known.cloned().unwrap_or_else(|| {
                let rows = Arc::new(after.product_rows(friction, factor, capture));
                Product { friction, factor, rows }
            })
        };
        let factors = after.factors();
        let frictions = after.frictions().into_iter();
        let products = frictions.flat_map(|friction| factors.iter().map(move |factor| (friction, *factor)));
        let products = products.map(|(friction, factor)| product(friction, factor)).collect();
        let load = |index: usize| {
            let known = self.loads.iter().find(|(known, _)| *known == index && !changed.contains(&index));
            known.cloned().unwrap_or_else(|| (index, Arc::new(after.columns_at_samples(index, capture))))
        };
        let is_load =
            |index: &usize| !after.load_frictions().is_empty() && after.effects[*index].kind().is_of_the_load();
        let loads = (0..after.effects.len()).filter(is_load).map(load).collect();
        Self { rows: self.rows, products, loads }
    }
}

/// Indices of the effects of `after` that `before` lacks, or whose values or friction differ there, so that their columns do.
pub(super) fn changed(before: &Structure, after: &Structure) -> Vec<usize> {
    let bristles = before.bristles() != after.bristles();
    let differs = |index: &usize| {
        let part = after.effects[*index].kind().part;
        let is_friction = matches!(part, Part::Friction(_) | Part::FrictionTable(_) | Part::Bristles(_));
        let of_friction = is_friction || part.changes_friction();
        before.effects.get(*index) != after.effects.get(*index) || bristles && of_friction
    };
    (0..after.effects.len()).filter(differs).collect()
}
