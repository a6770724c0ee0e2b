//! Filters against coefficients and outputs of `scipy.signal` (`fixtures/scipy_filters.py` made them).

use identification::filter::{Fir, Sections, butterworth_low_pass, chebyshev1_low_pass, chebyshev2_low_pass};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn scipy() -> Value {
    serde_json::from_str(include_str!("fixtures/scipy_filters.json")).unwrap()
}

fn worst(left: &[f64], right: &[f64]) -> f64 {
    assert_eq!(left.len(), right.len());
    left.iter().zip(right).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn each_design(mut check: impl FnMut(&Value, &Value, &Sections)) {
    let scipy = scipy();
    for design in scipy["designs"].as_array().unwrap() {
        let number = |key: &str| design[key].as_f64().unwrap();
        let order = usize::try_from(design["order"].as_u64().unwrap()).unwrap();
        let sections = match design["kind"].as_str().unwrap() {
            "butterworth" => butterworth_low_pass(order, number("edge_hz"), number("rate_hz")).unwrap(),
            "chebyshev1" => chebyshev1_low_pass(order, 0.05, number("edge_hz"), number("rate_hz")).unwrap(),
            _ => chebyshev2_low_pass(order, 20.0, number("edge_hz"), number("rate_hz")).unwrap(),
        };
        check(&scipy["input"], design, &sections);
    }
}

#[test]
fn designs_have_the_sections_that_scipy_gives() {
    each_design(|_, design, sections| {
        for (ours, theirs) in sections.rows().iter().zip(design["sections"].as_array().unwrap()) {
            assert!(worst(ours, &numbers(theirs)) < 1e-9, "{ours:?} against {theirs}");
        }
    });
}

#[test]
fn filtering_gives_what_scipy_gives() {
    each_design(|input, design, sections| {
        assert!(worst(&sections.filter(&numbers(input), 0.0), &numbers(&design["filtered"])) < 1e-9);
    });
}

#[test]
fn zero_phase_filtering_gives_what_scipy_gives() {
    each_design(|input, design, sections| {
        assert!(worst(&sections.filter_zero_phase(&numbers(input)), &numbers(&design["zero_phase"])) < 1e-9);
    });
}

#[test]
fn the_windowed_low_pass_has_the_taps_that_scipy_gives() {
    assert!(worst(Fir::low_pass(20, 200.0, 5000.0).taps(), &numbers(&scipy()["firwin"])) < 1e-12);
}

#[test]
fn a_filter_that_cannot_be_is_none() {
    assert!(butterworth_low_pass(4, 3000.0, 5000.0).is_none());
    assert!(chebyshev2_low_pass(0, 20.0, 100.0, 5000.0).is_none());
}

#[test]
fn the_kaiser_low_pass_has_the_taps_that_scipy_gives() {
    // scipy.signal.firwin(21, 200.0, window=("kaiser", 7.857), fs=5000.0)[:11], scipy 1.17.1
    let expected = [
        7.962182419160167e-05,
        0.0008033273272385551,
        0.0032362035892677964,
        0.00897335556255359,
        0.019670986371218852,
        0.03625340604902998,
        0.05807900264780902,
        0.08251087537969291,
        0.10525008023740072,
        0.12146644955669457,
        0.1273533829098048,
    ];
    assert!(worst(&Fir::kaiser_low_pass(10, 200.0, 5000.0, 7.857).taps()[..11], &expected) < 1e-12);
}
