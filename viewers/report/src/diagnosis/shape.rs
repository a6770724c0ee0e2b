//! A map in words.

use identification::diagnosis::Location;

use crate::numbers::three;

/// Share of the largest magnitude that a bin must have for its sign to count.
const COUNTS: f64 = 0.25;
/// Share of the power that makes a map odd or even, and of all ups and downs that makes it a slope.
const MOSTLY: f64 = 0.85;
/// Points at which the two halves of a map are compared.
const COMPARED: u32 = 40;

/// Where a map is highest and lowest, how often it changes sign, and whether its halves mirror each other; `None` for a map
/// without finite values.
pub(super) fn shape(location: &Location) -> Option<String> {
    let mut map: Vec<[f64; 2]> =
        location.map.iter().copied().filter(|bin| bin[0].is_finite() && bin[1].is_finite()).collect();
    map.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let [low_at, low] = map.iter().copied().min_by(|a, b| a[1].total_cmp(&b[1]))?;
    let [high_at, high] = map.iter().copied().max_by(|a, b| a[1].total_cmp(&b[1]))?;
    let unit = location.unit;
    let trend = trend(&map);
    let changes = match sign_changes(&map, high.abs().max(low.abs())) {
        0 => "never changes sign".to_owned(),
        1 => "changes sign once".to_owned(),
        2 => "changes sign twice".to_owned(),
        many => format!("changes sign {many} times"),
    };
    let mirrored = mirrored(&map).unwrap_or("");
    Some(format!(
        "Highest {} mNm at {} {unit}, lowest {} mNm at {} {unit}; {trend}{changes}{mirrored}.",
        three(high),
        three(high_at),
        three(low),
        three(low_at)
    ))
}

/// Whether the map goes one way from end to end.
fn trend(map: &[[f64; 2]]) -> &'static str {
    let (Some(first), Some(last)) = (map.first(), map.last()) else { return "" };
    let up_and_down: f64 = map.windows(2).map(|pair| (pair[1][1] - pair[0][1]).abs()).sum();
    let rise = last[1] - first[1];
    if rise > MOSTLY * up_and_down {
        "rises from end to end, "
    } else if -rise > MOSTLY * up_and_down {
        "falls from end to end, "
    } else {
        ""
    }
}

fn sign_changes(map: &[[f64; 2]], largest: f64) -> usize {
    let signs: Vec<bool> = map.iter().filter(|bin| bin[1].abs() > COUNTS * largest).map(|bin| bin[1] > 0.0).collect();
    signs.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

/// Whether the map's two halves about zero are opposite or alike, if zero lies well within it.
fn mirrored(map: &[[f64; 2]]) -> Option<&'static str> {
    let (first, last) = (map.first()?[0], map.last()?[0]);
    let reach = last.min(-first);
    if reach < 0.5 * last.max(-first) {
        return None;
    }
    let (mut odd, mut even) = (0.0, 0.0);
    for step in 1..=COMPARED {
        let at = reach * f64::from(step) / f64::from(COMPARED);
        let (right, left) = (level(map, at)?, level(map, -at)?);
        odd += (right - left).powi(2);
        even += (right + left).powi(2);
    }
    let total = odd + even;
    if odd > MOSTLY * total {
        Some("; opposite for either sign")
    } else if even > MOSTLY * total {
        Some("; the same for either sign")
    } else {
        None
    }
}

/// The map between its bins.
fn level(map: &[[f64; 2]], at: f64) -> Option<f64> {
    let after = map.partition_point(|bin| bin[0] < at);
    let [right_at, right] = *map.get(after.min(map.len() - 1))?;
    let [left_at, left] = *map.get(after.saturating_sub(1))?;
    let share = if right_at > left_at { ((at - left_at) / (right_at - left_at)).clamp(0.0, 1.0) } else { 0.0 };
    Some(left + share * (right - left))
}
