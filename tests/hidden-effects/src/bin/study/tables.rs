//! The study's tables, in plain text of 80 columns.

use std::collections::BTreeSet;

use hidden_effects::effect::catalogue;

use crate::diagnosis::Judged;

/// Prints everything about one family.
pub fn print(family: &str, judged: &[Judged]) {
    println!("\n=== {family}: {} pairs of captures ===", judged.len());
    let strengths = strengths(judged);
    by_effect(judged, &strengths);
    summary(judged, &strengths);
    confusion(judged);
    mistakes(judged);
}

/// The families side by side, one line each.
pub fn print_families(families: &[(&str, Vec<Judged>)]) {
    println!("\n=== families: first name and exact set right, of all with something to name ===");
    println!(
        "{:<18}{:>9}{:>9}{:>8}{:>9}{:>9}{:>9}{:>9}",
        "", "first", "exact", "none", "outside", "wrong*", "time s", "max s"
    );
    for (family, judged) in families {
        let all: Vec<&Judged> = judged.iter().collect();
        let named: Vec<&Judged> = judged.iter().filter(|j| !j.case.answer.effects.is_empty()).collect();
        let of = |verdict: &str| -> Vec<&Judged> { judged.iter().filter(|j| j.truth() == verdict).collect() };
        let times = sorted(all.iter().map(|j| j.outcome.seconds));
        println!(
            "{family:<18}{:>9}{:>9}{:>8}{:>9}{:>9}{:>9.2}{:>9.2}",
            share(&named, Judged::first_right),
            share(&named, Judged::exact),
            share(&of("none"), Judged::exact),
            share(&of("outside-library"), Judged::exact),
            share(&all, Judged::wrong_without_doubt),
            quantile(&times, 0.5),
            quantile(&times, 1.0),
        );
    }
}

fn strengths(judged: &[Judged]) -> Vec<Option<f64>> {
    let strengths: BTreeSet<u64> = judged.iter().filter_map(|j| j.case.answer.strength).map(f64::to_bits).collect();
    strengths.into_iter().map(|bits| Some(f64::from_bits(bits))).collect()
}

/// Captures of a strength; those that hide nothing belong to none.
fn of_strength(judged: &[Judged], strength: Option<f64>) -> Vec<&Judged> {
    judged.iter().filter(|j| j.case.answer.strength == strength).collect()
}

fn share(judged: &[&Judged], right: fn(&Judged) -> bool) -> String {
    if judged.is_empty() {
        return "-".to_owned();
    }
    format!("{}/{}", judged.iter().filter(|j| right(j)).count(), judged.len())
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

fn quantile(sorted: &[f64], place: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    sorted.get((place * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
}

fn by_effect(judged: &[Judged], strengths: &[Option<f64>]) {
    println!("\nright: first name, exact set, of how many; by strength (effect over noise)");
    print!("{:<24}", "");
    strengths.iter().flatten().for_each(|strength| print!("{strength:>13}"));
    println!();
    for truth in catalogue().iter().map(|kind| kind.name).chain(["pair", "triple"]) {
        if !judged.iter().any(|j| j.truth() == truth) {
            continue;
        }
        print!("{truth:<24}");
        for strength in strengths {
            let those: Vec<_> = of_strength(judged, *strength).into_iter().filter(|j| j.truth() == truth).collect();
            let count = |right: fn(&Judged) -> bool| those.iter().filter(|j| right(j)).count();
            if those.is_empty() {
                print!("{:>13}", "-");
            } else {
                print!("{:>5}{:>4}{:>4}", count(Judged::first_right), count(Judged::exact), those.len());
            }
        }
        println!();
    }
    let outside: BTreeSet<&String> = judged
        .iter()
        .filter(|j| j.truth() == "outside-library")
        .flat_map(|j| j.case.answer.parameters.keys())
        .collect();
    for kind in outside {
        print!("(outside) {kind:<14.14}");
        for strength in strengths {
            let those: Vec<_> = of_strength(judged, *strength)
                .into_iter()
                .filter(|j| j.truth() == "outside-library" && j.case.answer.parameters.contains_key(kind))
                .collect();
            print!("{:>13}", share(&those, Judged::exact));
        }
        println!();
    }
}

fn summary(judged: &[Judged], strengths: &[Option<f64>]) {
    type Measure = (&'static str, fn(&[&Judged]) -> String);
    let measures: [Measure; 13] = [
        ("one effect: first", |all| share(&of(all, 1), Judged::first_right)),
        ("one effect: exact", |all| share(&of(all, 1), Judged::exact)),
        ("two effects: first", |all| share(&of(all, 2), Judged::first_right)),
        ("two effects: exact", |all| share(&of(all, 2), Judged::exact)),
        ("three effects: first", |all| share(&of(all, 3), Judged::first_right)),
        ("three effects: exact", |all| share(&of(all, 3), Judged::exact)),
        ("outside called so", |all| share(&outside(all), Judged::exact)),
        ("wrong without doubt *", |all| share(all, Judged::wrong_without_doubt)),
        ("gap closed, median **", |all| {
            middle(of(all, 1).iter().chain(&of(all, 2)).filter_map(|j| j.gap_closed()), 0.5)
        }),
        ("gap closed, worst **", |all| {
            middle(of(all, 1).iter().chain(&of(all, 2)).filter_map(|j| j.gap_closed()), 0.0)
        }),
        ("floor / torque noise", |all| middle(all.iter().filter_map(|j| j.floor_ratio()), 0.5)),
        ("time s, median", |all| middle(all.iter().map(|j| j.outcome.seconds), 0.5)),
        ("time s, longest", |all| middle(all.iter().map(|j| j.outcome.seconds), 1.0)),
    ];
    println!();
    for (name, measure) in measures {
        print!("{name:<24}");
        strengths.iter().for_each(|strength| print!("{:>13}", measure(&of_strength(judged, *strength))));
        println!();
    }
    let none = of_strength(judged, None);
    let times = sorted(none.iter().map(|j| j.outcome.seconds));
    println!(
        "nothing hidden: {} false alarms; time {:.2} s, longest {:.2} s",
        share(&none, |j| !j.exact()),
        quantile(&times, 0.5),
        quantile(&times, 1.0)
    );
    println!("*  names an effect that is not there, and no rival that is there came within 5 % held out");
    println!("** (before - after) / (before - floor), RMS held out, where before > 1.1 floor");
}

fn of<'a>(judged: &[&'a Judged], effects: usize) -> Vec<&'a Judged> {
    judged.iter().copied().filter(|j| j.case.answer.effects.len() == effects).collect()
}

fn outside<'a>(judged: &[&'a Judged]) -> Vec<&'a Judged> {
    judged.iter().copied().filter(|j| j.truth() == "outside-library").collect()
}

fn middle(values: impl Iterator<Item = f64>, place: f64) -> String {
    let sorted = sorted(values);
    if sorted.is_empty() { "-".to_owned() } else { format!("{:.2}", quantile(&sorted, place)) }
}

fn confusion(judged: &[Judged]) {
    let names: Vec<&str> =
        catalogue().iter().map(|kind| kind.name).chain(["none", "outside-library", "failed"]).collect();
    println!("\nhidden (down) and the name said first (across, by number)");
    print!("{:<24}", "");
    (1..=names.len()).for_each(|number| print!("{number:>3}"));
    println!();
    for (truth, number) in names.iter().zip(1..) {
        let those: Vec<_> = judged.iter().filter(|j| j.truth() == *truth).collect();
        if those.is_empty() {
            continue;
        }
        print!("{number:>2} {truth:<21}");
        for name in &names {
            match those.iter().filter(|j| j.first_said() == *name).count() {
                0 => print!("  ."),
                count => print!("{count:>3}"),
            }
        }
        println!();
    }
}

fn mistakes(judged: &[Judged]) {
    let wrong: Vec<_> = judged.iter().filter(|j| !j.exact()).collect();
    if wrong.is_empty() {
        return;
    }
    println!("\nnot exactly right: strength, capture, hidden -> said");
    for j in wrong {
        let answer = &j.case.answer;
        let hidden: Vec<&String> = answer.parameters.keys().collect();
        let hidden: Vec<&str> = hidden.into_iter().map(String::as_str).collect();
        let hidden = if hidden.is_empty() { "none".to_owned() } else { hidden.join(" + ") };
        let strength = answer.strength.map_or("-".to_owned(), |strength| strength.to_string());
        println!("{strength:>4} {} {hidden} -> {}", j.case.name, j.words());
    }
}
