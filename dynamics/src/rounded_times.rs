//! Times of an even clock that were rounded when they were written.

/// Times that are finer than this share of the period are as good as exact.
const FINE: f64 = 0.01;
/// Share of the rounding's width by which a time may deviate from the even clock: half of it, and what the estimate of the period leaves.
const WITHIN: f64 = 0.6;
/// Share of the times that must do so.
const NEARLY_ALL: f64 = 0.99;
/// Periods that a time must come late for samples to count as missing: rounding makes it half a period late at most.
const SURELY_MISSING: f64 = 0.75;
/// Share of a time's deviation by which the clock follows it, as far as the period is not known.
const FOLLOWED: f64 = 0.004;
/// Periods over which the first estimate of the period is taken.
const BLOCK: usize = 64;

/// The times of the even clock behind times that were rounded to decimals, as milliseconds of a sensor that is read 860 times a second are; `None`
/// if they were not rounded, or not by a clock that is even but for missing samples, and for times that do not rise.
///
/// ```
/// let written: Vec<f64> = (0..1000).map(|tick| (f64::from(tick) / 0.86).round() * 1e-3).collect();
/// let even = dynamics::even_times(&written).unwrap_or_default();
/// assert!((1..1000).all(|tick| (even[tick] - even[tick - 1] - 1.0 / 860.0).abs() < 1e-6));
/// ```
#[must_use]
pub fn even_times(time_s: &[f64]) -> Option<Vec<f64>> {
    let first_s = *time_s.first()?;
    if time_s.windows(2).any(|pair| pair[1] <= pair[0]) {
        return None;
    }
    let mut slopes_s: Vec<f64> =
        time_s.windows(BLOCK + 1).step_by(BLOCK).map(|block| (block[BLOCK] - block[0]) / BLOCK as f64).collect();
    slopes_s.sort_by(f64::total_cmp);
    let typical_s = *slopes_s.get(slopes_s.len() / 2)?;
    if time_s.windows(2).all(|pair| (pair[1] - pair[0] - typical_s).abs() < FINE * typical_s) {
        return None;
    }
    let unit_s = decimal_unit_s(time_s, typical_s)?;
    let counted: Vec<f64> = (0..time_s.len()).map(|tick| tick as f64).collect();
    if let Some(even_s) = near_line(&counted, time_s, unit_s, 1.0) {
        return Some(even_s);
    }
    // Rounding changes a block's slope by a unit at most, a missing sample by a period; the mean of the others is fine.
    slopes_s.retain(|slope_s| (slope_s - typical_s).abs() * (BLOCK as f64) < 1.5 * unit_s.min(typical_s));
    let period_s = slopes_s.iter().sum::<f64>() / slopes_s.len() as f64;
    // The number of each sample, by the clock as it was a few samples ago.
    let mut offset_s =
        centre(time_s[..BLOCK].iter().enumerate().map(|(tick, time)| time - first_s - tick as f64 * period_s));
    let mut tick = 0.0;
    let mut ticks = Vec::with_capacity(time_s.len());
    for (index, time) in time_s.iter().enumerate() {
        let missing = (time - first_s - offset_s) / period_s - tick - 1.0;
        if index > 0 {
            tick += if missing > SURELY_MISSING { 1.0 + missing.round() } else { 1.0 };
        }
        let deviation_s = time - first_s - offset_s - tick * period_s;
        offset_s += deviation_s.clamp(-unit_s, unit_s) * FOLLOWED;
        ticks.push(tick);
    }
    near_line(&ticks, time_s, unit_s, NEARLY_ALL)
}

/// The times of the straight line over the ticks; `None` unless at least such a share of the times lies near it. A jitter of the same width fills
/// the rounding's in the same way, and the even clock is then as good as any other.
fn near_line(ticks: &[f64], time_s: &[f64], unit_s: f64, share: f64) -> Option<Vec<f64>> {
    let [start_s, period_s] = line(ticks, time_s)?;
    let even = |tick: &f64| start_s + tick * period_s;
    let is_near = |(time, tick): &(&f64, &f64)| (*time - even(tick)).abs() < WITHIN * unit_s;
    let near = time_s.iter().zip(ticks).filter(is_near).count();
    let farthest_s = time_s.iter().zip(ticks).map(|(time, tick)| (time - even(tick)).abs()).fold(0.0, f64::max);
    (farthest_s > FINE * period_s && near as f64 >= share * time_s.len() as f64)
        .then(|| ticks.iter().map(even).collect())
}

/// The coarsest power of ten of which all times are multiples, s; `None` if that is fine beside the period.
fn decimal_unit_s(time_s: &[f64], period_s: f64) -> Option<f64> {
    let first_s = time_s[0];
    let is_unit = |unit_s: &f64| {
        time_s.iter().all(|time| {
            let units = (time - first_s) / unit_s;
            (units - units.round()).abs() < 1e-3
        })
    };
    (0..12).map(|decimals| 0.1_f64.powi(decimals)).find(is_unit).filter(|unit_s| *unit_s > FINE * period_s)
}

fn centre(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    0.5 * (low + high)
}

/// Start and slope of the straight line through the times over their ticks.
fn line(ticks: &[f64], time_s: &[f64]) -> Option<[f64; 2]> {
    let count = ticks.len() as f64;
    let [mean_tick, mean_s] = [ticks, time_s].map(|values| values.iter().sum::<f64>() / count);
    let (mut square, mut product) = (0.0, 0.0);
    for (tick, time) in ticks.iter().zip(time_s) {
        square += (tick - mean_tick).powi(2);
        product += (tick - mean_tick) * (time - mean_s);
    }
    let period_s = product / square;
    (period_s > 0.0 && period_s.is_finite()).then_some([mean_s - mean_tick * period_s, period_s])
}

#[cfg(test)]
mod tests {
    use super::even_times;

    fn written(rate_hz: f64, decimals: i32, samples: u32, is_lost: impl Fn(u32) -> bool) -> Vec<f64> {
        let unit = 10_f64.powi(decimals);
        let times = (0..samples).filter(|tick| !is_lost(*tick)).map(|tick| f64::from(tick) / rate_hz + 3.0);
        times.map(|time| (time * unit).floor() / unit).collect()
    }

    #[test]
    fn rates_that_are_no_multiple_of_the_rounding_are_found() {
        for (rate_hz, decimals) in
            [(99.0, 2), (670.0, 3), (700.0, 3), (860.0, 3), (990.0, 3), (7000.0, 4), (8192.0, 4), (96.7, 3)]
        {
            let even = even_times(&written(rate_hz, decimals, 20_000, |_| false)).unwrap_or_default();
            assert_eq!(even.len(), 20_000, "{rate_hz}");
            for pair in even.windows(2) {
                assert!(((pair[1] - pair[0]) * rate_hz - 1.0).abs() < 1e-4, "{rate_hz}");
            }
        }
    }

    #[test]
    fn a_short_record_is_even_too() {
        for (samples, rate_hz) in [(100, 860.0), (300, 860.0), (300, 990.0), (500, 960.0)] {
            let even = even_times(&written(rate_hz, 3, samples, |_| false)).unwrap_or_default();
            let length_s = even.last().unwrap_or(&0.0) - even.first().unwrap_or(&0.0);
            assert!((length_s * rate_hz / f64::from(samples - 1) - 1.0).abs() < 0.01, "{samples} at {rate_hz} Hz");
        }
    }

    #[test]
    fn samples_that_are_missing_leave_gaps_of_whole_periods() {
        let is_lost = |tick: u32| tick % 997 == 400 || (7000..7100).contains(&tick);
        let even = even_times(&written(860.0, 3, 20_000, is_lost)).unwrap_or_default();
        let missing: f64 = even.windows(2).map(|pair| ((pair[1] - pair[0]) * 860.0).round() - 1.0).sum();
        assert!(
            (missing - f64::from((0..20_000).filter(|tick| is_lost(*tick)).count() as u32)).abs() < 0.5,
            "{missing}"
        );
    }

    #[test]
    fn exact_times_and_uneven_clocks_stay_as_they_are() {
        assert!(even_times(&written(1000.0, 9, 5000, |_| false)).is_none());
        assert!(even_times(&written(860.0, 9, 5000, |_| false)).is_none());
        // A logger that waits a random time after each sample.
        let mut time_ms = 0.0;
        let noise = |at: f64| (0.5 + 0.5 * (at * 12.9898).sin() * 43_758.545).fract().abs();
        let uneven: Vec<f64> = (0..5000)
            .map(|at| {
                time_ms += 1.0 + (3.0 * noise(f64::from(at))).floor();
                1e-3 * time_ms
            })
            .collect();
        assert!(even_times(&uneven).is_none());
        assert!(even_times(&[]).is_none() && even_times(&[0.0, 1.0, 2.0]).is_none());
    }
}
