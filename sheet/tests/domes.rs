//! Measured domes: the figures that Dome Lab and a plain computation by its definitions have of them.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::path::{Path, PathBuf};

use archive::testers::Curve;
use sheet::{Figure, Sheet};

fn curves(folder: &Path) -> Vec<Curve> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.iter().map(|file| Curve::load(file, None).unwrap()).collect()
}

/// A row of the table: set, collapse in gf and mm, snap in %, travel in mm, energy in gf mm.
fn rows(readme: &str) -> Vec<(String, [f64; 5])> {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split('|').map(str::trim).filter(|cell| !cell.is_empty()).collect();
        let [set, _, collapse, snap, travel, energy, _] = cells.try_into().ok()?;
        let (force, place) = collapse.split_once(" @ ")?;
        let numbers: Result<Vec<f64>, _> =
            [force, place, snap, travel, energy].iter().map(|text| text.parse()).collect();
        Some((set.to_owned(), numbers.ok()?.try_into().ok()?))
    };
    readme.lines().filter_map(row).collect()
}

fn figures(sheet: &Sheet) -> [f64; 5] {
    let gram_force = shared_types::Quantity::Force.factor("gf").unwrap();
    [
        ("collapse_force", gram_force),
        ("collapse_travel", 1.0),
        ("snap", 0.01),
        ("travel", 1.0),
        ("total_energy", gram_force),
    ]
    .map(|(name, unit)| sheet.figures[name].value.unwrap() / unit)
}

fn assert_equal(set: &str, found: [f64; 5], published: [f64; 5]) {
    for (index, (found, published)) in found.into_iter().zip(published).enumerate() {
        // Travels within 0.02 mm, the rest within 1 %.
        let most = if [1, 3].contains(&index) { 0.02 } else { 0.01 * published };
        assert!((found - published).abs() <= most, "{set}: {found} instead of {published}");
    }
}

#[test]
fn the_figures_of_measured_domes_are_those_that_their_tester_publishes() {
    let Some(folder) = measured_data::folder("force-curves") else { return };
    let readme = std::fs::read_to_string(folder.join("README.md")).unwrap();
    let table = rows(&readme);
    assert!(table.len() >= 10, "the table has {} sets", table.len());
    for (set, published) in table {
        assert_equal(&set, figures(&Sheet::of(&curves(&folder.join("dome-lab").join(&set))).unwrap()), published);
    }
    // The one row of the published table whose measurement has not been made again since.
    let bare = Sheet::of(&curves(&folder.join("dome-lab/Topre_Slider_Black"))).unwrap();
    assert_equal("Topre Slider, bare", figures(&bare), [62.9, 1.13, 23.4, 3.99, 207.0]);
}

#[test]
fn the_interval_of_repeated_runs_holds_each_of_them_and_that_of_all_but_one_holds_the_one_as_often_as_it_says() {
    let Some(folder) = measured_data::folder("force-curves") else { return };
    let (mut own, mut next) = ([0_u32; 2], [0_u32; 2]);
    for set in std::fs::read_dir(folder.join("dome-lab")).unwrap() {
        let curves = curves(&set.unwrap().path());
        let whole = Sheet::of(&curves).unwrap();
        for index in 0..curves.len() {
            let run = Sheet::of(&curves[index..=index]).unwrap();
            let rest: Vec<Curve> =
                curves.iter().enumerate().filter(|(at, _)| *at != index).map(|(_, curve)| curve.clone()).collect();
            let rest = (rest.len() > 1).then(|| Sheet::of(&rest).unwrap());
            for (name, figure) in &run.figures {
                let Some(value) = figure.value else { continue };
                count(&mut own, &whole.figures[name], value);
                if let Some(rest) = &rest {
                    count(&mut next, &rest.figures[name], value);
                }
            }
        }
    }
    assert!(own[0] == own[1] && own[1] > 300, "{own:?}");
    let held = f64::from(next[0]) / f64::from(next[1]);
    assert!((0.92..=0.99).contains(&held) && next[1] > 200, "{next:?} held: {held}");
}

fn count(held: &mut [u32; 2], figure: &Figure, value: f64) {
    let Some([low, high]) = figure.ci95 else { return };
    held[0] += u32::from((low..=high).contains(&value));
    held[1] += 1;
}
