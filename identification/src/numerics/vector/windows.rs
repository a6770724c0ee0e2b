//! Columns' inner products within short stretches.

/// Groups that are summed side by side: their sums stay in registers, and the rows of a dozen columns in the first-level
/// cache.
const SIDE_BY_SIDE: usize = 32;

/// Inner products of every pair of columns, the pairs of the lower triangle row by row, over each `group` rows.
///
/// With the rows sorted by their place within the group, neighbouring groups are summed side by side.
pub(crate) fn grouped_products(columns: &[&[f64]], group: usize) -> Vec<Vec<f64>> {
    let rows = columns.first().map_or(0, |column| column.len());
    let groups = rows.div_ceil(group);
    let mut sorted = vec![[0.0; SIDE_BY_SIDE]; columns.len() * group];
    let mut products = vec![vec![0.0; groups]; columns.len() * (columns.len() + 1) / 2];
    widest!({
        for start in (0..groups).step_by(SIDE_BY_SIDE) {
            let block = start * group..((start + SIDE_BY_SIDE) * group).min(rows);
            for (column, sorted) in columns.iter().zip(sorted.chunks_exact_mut(group)) {
                sort(&column[block.clone()], group, sorted);
            }
            let mut pairs = products.iter_mut();
            for (row, left) in sorted.chunks_exact(group).enumerate() {
                for (right, products) in sorted.chunks_exact(group).take(row + 1).zip(&mut pairs) {
                    let mut sums = [0.0; SIDE_BY_SIDE];
                    for (left, right) in left.iter().zip(right) {
                        for place in 0..SIDE_BY_SIDE {
                            sums[place] += left[place] * right[place];
                        }
                    }
                    products[start..].iter_mut().zip(&sums).for_each(|(slot, sum)| *slot = *sum);
                }
            }
        }
    });
    products
}

/// Values by their place within the group; zero where there are none.
#[inline(always)]
fn sort(values: &[f64], group: usize, sorted: &mut [[f64; SIDE_BY_SIDE]]) {
    if values.len() < SIDE_BY_SIDE * group {
        sorted.fill([0.0; SIDE_BY_SIDE]);
    }
    for (place, values) in values.chunks(group).enumerate() {
        sorted.iter_mut().zip(values).for_each(|(slots, value)| slots[place] = *value);
    }
}

/// Sums of `width` neighbours, and of those sums again, at every place that any of the values reaches.
///
/// Value by value: for windows of some dozen neighbours, without the rounding of running sums.
pub(crate) fn triangle(values: &[f64], width: usize) -> Vec<f64> {
    let reach = width - 1;
    let mut boxes = vec![0.0; values.len() + reach];
    let mut triangles = vec![0.0; values.len() + 2 * reach];
    widest!({
        add_shifted(values, width, &mut boxes);
        add_shifted(&boxes, width, &mut triangles);
    });
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
    use super::{grouped_products, triangle};

    #[test]
    fn products_by_groups_are_those_of_the_rows_in_them() {
        for group in [1, 3, 8] {
            let columns: [Vec<f64>; 2] = [0.7, 1.9].map(|rate| (0..290).map(|n| (rate * f64::from(n)).sin()).collect());
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
        assert_eq!(triangle(&[1.0], 3), [1.0, 2.0, 3.0, 2.0, 1.0]);
        assert_eq!(triangle(&[2.0, 1.0], 1), [2.0, 1.0]);
    }
}
