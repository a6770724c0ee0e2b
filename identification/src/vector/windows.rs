//! Columns' inner products within short stretches.

use super::filters::sort_by_phase;
use super::widest;

/// Inner products of every pair of columns, the pairs of the lower triangle row by row, over each `group` rows.
///
/// With the rows sorted by their place within the group, neighbouring groups are summed side by side.
pub(crate) fn grouped_products(columns: &[&[f64]], group: usize) -> Vec<Vec<f64>> {
    let groups = columns.first().map_or(0, |column| column.len()).div_ceil(group);
    let mut sorted = vec![0.0; columns.len() * groups * group];
    let mut products = vec![vec![0.0; groups]; columns.len() * (columns.len() + 1) / 2];
    if groups == 0 {
        return products;
    }
    widest(
        #[inline(always)]
        || {
            for (column, sorted) in columns.iter().zip(sorted.chunks_exact_mut(groups * group)) {
                match group {
                    // The group of the least bandwidth of a long capture: whole vectors are sorted at once.
                    8 => sort_by_phase::<8>(column, groups, sorted),
                    _ => {
                        for (phase, sorted) in sorted.chunks_exact_mut(groups).enumerate() {
                            let values = column.iter().skip(phase).step_by(group);
                            sorted.iter_mut().zip(values).for_each(|(slot, value)| *slot = *value);
                        }
                    }
                }
            }
            let mut pairs = products.iter_mut();
            for (row, left) in sorted.chunks_exact(groups * group).enumerate() {
                for (right, products) in sorted.chunks_exact(groups * group).take(row + 1).zip(&mut pairs) {
                    for (left, right) in left.chunks_exact(groups).zip(right.chunks_exact(groups)) {
                        for ((slot, left), right) in products.iter_mut().zip(left).zip(right) {
                            *slot += left * right;
                        }
                    }
                }
            }
        },
    );
    products
}

/// Sums of `width` neighbours, and of those sums again, at every place that any of the values reaches.
///
/// Value by value: for windows of a few neighbours.
pub(crate) fn short_triangle(values: &[f64], width: usize) -> Vec<f64> {
    let reach = width - 1;
    let mut boxes = vec![0.0; values.len() + reach];
    let mut triangles = vec![0.0; values.len() + 2 * reach];
    widest(
        #[inline(always)]
        || {
            add_shifted(values, width, &mut boxes);
            add_shifted(&boxes, width, &mut triangles);
        },
    );
    triangles
}

#[inline(always)]
fn add_shifted(values: &[f64], width: usize, sums: &mut [f64]) {
    for shift in 0..width {
        sums[shift..].iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
    }
}

#[cfg(test)]
mod tests {
    use super::{grouped_products, short_triangle};

    #[test]
    fn products_by_groups_are_those_of_the_rows_in_them() {
        for group in [1, 3, 8] {
            let columns: [Vec<f64>; 2] = [0.7, 1.9].map(|rate| (0..29).map(|n| (rate * f64::from(n)).sin()).collect());
            let [a, b] = &columns;
            let found = grouped_products(&[a, b], group);
            for (pair, (left, right)) in [(a, a), (b, a), (b, b)].into_iter().enumerate() {
                for (place, (left, right)) in left.chunks(group).zip(right.chunks(group)).enumerate() {
                    let product: f64 = left.iter().zip(right).map(|(left, right)| left * right).sum();
                    assert!((found[pair][place] - product).abs() < 1e-12, "pair {pair}, place {place}, {group} rows");
                }
            }
        }
    }

    #[test]
    fn a_single_value_becomes_a_triangle() {
        assert_eq!(short_triangle(&[1.0], 3), [1.0, 2.0, 3.0, 2.0, 1.0]);
        assert_eq!(short_triangle(&[2.0, 1.0], 1), [2.0, 1.0]);
    }
}
