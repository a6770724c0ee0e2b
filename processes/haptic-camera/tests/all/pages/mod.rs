//! A report page beside the JSON of the same command.

use roxmltree::{Document, Node};
use serde_json::Value;

/// Percentages of intervals, and other figures of speech that measure nothing.
const WORDS: [&str; 4] = ["95\u{a0}%", "95 %", "0 to ", "in twenty"];

/// Numbers of the page's tables, facts and captions that are not in the JSON, rounded as the page rounds them.
///
/// In a row that begins with the name of a parameter, a channel or a key, only what the JSON has under that name counts.
pub fn not_in_json(page: &str, json: &Value) -> Vec<String> {
    let xml = well_formed(page);
    let document = Document::parse(&xml).unwrap();
    let known = Known::of(json);
    let mut missing = Vec::new();
    let texts = document.descendants().filter(|node| node.is_text() && tells_numbers(*node));
    for node in texts {
        let text = node.text().unwrap();
        if known.texts.iter().any(|known| known == text.trim()) {
            continue;
        }
        let name = row_name(node).filter(|name| known.names(name));
        for shown in numbers(text) {
            if !known.has(&shown, name.as_deref()) {
                missing.push(format!("{} in “{}” of {name:?}", shown.text, text.trim()));
            }
        }
    }
    missing
}

/// How many numbers of the page are compared.
pub fn compared(page: &str) -> usize {
    let xml = well_formed(page);
    let document = Document::parse(&xml).unwrap();
    let texts = document.descendants().filter(|node| node.is_text() && tells_numbers(*node));
    texts.map(|node| numbers(node.text().unwrap()).len()).sum()
}

/// The page as XML: its only element without an end is `meta`.
fn well_formed(page: &str) -> String {
    let body = page.strip_prefix("<!DOCTYPE html>").unwrap();
    let closed = |piece: &str| if piece.contains("<meta") { piece.replace('>', "/>") } else { piece.to_owned() };
    body.split_inclusive('>').map(closed).collect()
}

/// Whether a text belongs to a cell of a table's body, a fact, a caption or the verdict.
fn tells_numbers(node: Node<'_, '_>) -> bool {
    let class = |node: Node<'_, '_>, name: &str| {
        node.attribute("class").is_some_and(|classes| classes.split(' ').any(|class| class == name))
    };
    let within = |of: &dyn Fn(Node<'_, '_>) -> bool| node.ancestors().any(of);
    let excluded = |node: Node<'_, '_>| {
        ["svg", "thead", "style"].iter().any(|tag| node.has_tag_name(*tag))
            || class(node, "meaning")
            || class(node, "legend")
    };
    let included = |node: Node<'_, '_>| {
        ["td", "th", "dd", "figcaption"].iter().any(|tag| node.has_tag_name(*tag))
            || ["verdict", "completeness", "map"].iter().any(|name| class(node, name))
    };
    within(&included) && !within(&excluded)
}

/// The name with which a row begins.
fn row_name(node: Node<'_, '_>) -> Option<String> {
    let row = node.ancestors().find(|node| node.has_tag_name("tr"))?;
    let code =
        row.children().find(|cell| cell.has_tag_name("th"))?.children().find(|node| node.has_tag_name("code"))?;
    code.text().map(str::to_owned)
}

/// A number as the page writes it.
struct Shown {
    text: String,
    value: f64,
    /// Half a unit of its last digit.
    rounding: f64,
}

/// The numbers of a text.
fn numbers(text: &str) -> Vec<Shown> {
    let mut plain = text.replace('−', "-").replace('\u{202f}', "");
    WORDS.iter().for_each(|word| plain = plain.replace(word, " "));
    let power = plain.split_once("×\u{a0}10").map_or(0, |(_, raised)| superscript(raised));
    if let Some((before, raised)) = plain.clone().split_once("×\u{a0}10") {
        let rest = raised.trim_start_matches(|letter: char| "⁰¹²³⁴⁵⁶⁷⁸⁹⁻".contains(letter));
        plain = format!("{before} {rest}");
    }
    let words: Vec<&str> = plain.split(|letter: char| !(letter.is_alphanumeric() || "-._".contains(letter))).collect();
    let mut found = Vec::new();
    for (index, word) in words.iter().enumerate() {
        // The number of a figure measures nothing.
        if index > 0 && words[index - 1] == "figure" {
            continue;
        }
        found.extend(shown(word.trim_matches('.').trim_end_matches('-'), power));
    }
    found
}

fn shown(word: &str, power: i32) -> Option<Shown> {
    // A name or a file is no number.
    let value: f64 = word.parse().ok().filter(|_| word.chars().any(|letter| letter.is_ascii_digit()))?;
    let (whole, decimals) = word.split_once('.').unwrap_or((word, ""));
    let zeros = whole.len() - whole.trim_end_matches('0').len();
    // What ends in zeros without a point may be rounded to tens or hundreds.
    let tens = if decimals.is_empty() && value != 0.0 { i32::try_from(zeros).unwrap() } else { 0 };
    let last = i32::try_from(decimals.len()).unwrap();
    let scale = 10_f64.powi(power);
    let rounding = 0.5 * 10_f64.powi(tens - last) * scale * (1.0 + 1e-6);
    Some(Shown { text: word.to_owned(), value: value * scale, rounding })
}

fn superscript(raised: &str) -> i32 {
    let digits: String = raised
        .chars()
        .map_while(|letter| match letter {
            '⁻' => Some('-'),
            letter => "⁰¹²³⁴⁵⁶⁷⁸⁹"
                .chars()
                .position(|digit| digit == letter)
                .and_then(|digit| char::from_digit(u32::try_from(digit).unwrap(), 10)),
        })
        .collect();
    digits.parse().unwrap_or(0)
}

/// Numbers of a JSON with the way to each, and its texts.
#[derive(Default)]
struct Known {
    numbers: Vec<(Vec<String>, f64)>,
    texts: Vec<String>,
}

impl Known {
    fn of(json: &Value) -> Self {
        let mut known = Self::default();
        known.add(json, &[]);
        known
    }

    fn add(&mut self, value: &Value, way: &[String]) {
        match value {
            Value::Number(number) => self.numbers.push((way.to_vec(), number.as_f64().unwrap())),
            Value::String(text) => self.texts.push(text.clone()),
            Value::Array(items) => items.iter().for_each(|item| self.add(item, way)),
            Value::Object(fields) => {
                // What an object is called counts like a key.
                let called = ["name", "channel", "effect"].iter().filter_map(|key| fields.get(*key)?.as_str());
                let way: Vec<String> = way.iter().cloned().chain(called.map(str::to_owned)).collect();
                for (key, item) in fields {
                    self.add(item, &[way.as_slice(), std::slice::from_ref(key)].concat());
                }
            }
            Value::Bool(_) | Value::Null => {}
        }
    }

    fn names(&self, name: &str) -> bool {
        self.numbers.iter().any(|(way, _)| way.iter().any(|key| key == name))
    }

    fn has(&self, shown: &Shown, name: Option<&str>) -> bool {
        let under = |way: &Vec<String>| name.is_none_or(|name| way.iter().any(|key| key == name));
        self.numbers.iter().any(|(way, number)| under(way) && (number - shown.value).abs() <= shown.rounding)
            || self.texts.iter().any(|text| name.is_some() && text.contains(&shown.text))
    }
}
