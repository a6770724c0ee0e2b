//! The words for an axis.
//!
//! In the mathematics position and load are one quantity each, and the program calls them by the names of what is turned: `angle_rad`,
//! `torque_mnm`. Whatever leaves the program about what is pressed or slid (texts, pages, columns, keys) has each of these words
//! replaced by its counterpart, from the one list here.

use std::borrow::Cow;

use super::Axis;

/// Words for a rotary axis, each with its counterpart for a linear one.
const WORDS: [(&str, &str); 13] = [
    ("angle", "travel"),
    ("angles", "travels"),
    ("angular", "linear"),
    ("torque", "force"),
    ("torques", "forces"),
    ("knob", "control"),
    ("knobs", "controls"),
    ("turned", "moved"),
    ("turning", "moving"),
    ("turns", "moves"),
    ("rad", "mm"),
    ("mnm", "n"),
    ("mNm", "N"),
];

/// Where a line, a row of a table or a piece of a page ends.
const ENDS: [&str; 5] = ["\n", "</tr>", "</p>", "</text>", "</svg>"];
/// The word beside which `rad` stays as it is: a phase is an angle on every axis.
const PHASE: &str = "phase";

impl Axis {
    /// Translates a text about a rotary axis into one about this axis: names, units, whole sentences and pages.
    ///
    /// File names stay as they are, and so does `rad` in a line or a row of a table that names a phase.
    ///
    /// ```
    /// use dynamics::Axis;
    ///
    /// assert_eq!(Axis::Linear.words("torque_mnm"), "force_n");
    /// assert_eq!(Axis::Linear.words("stiffness 3 mNm/rad at an angle of 1 rad"), "stiffness 3 N/mm at a travel of 1 mm");
    /// assert_eq!(Axis::Linear.words("detent_phase 0.1 rad, see knob.csv"), "detent_phase 0.1 rad, see knob.csv");
    /// assert_eq!(Axis::Rotary.words("torque_mnm"), "torque_mnm");
    /// ```
    #[must_use]
    pub fn words(self, text: &str) -> Cow<'_, str> {
        if self.is_rotary() {
            return Cow::Borrowed(text);
        }
        let mut said = String::with_capacity(text.len());
        for line in
            ENDS.iter().fold(vec![text], |parts, end| parts.iter().flat_map(|part| part.split_inclusive(end)).collect())
        {
            let has_phase = line.contains(PHASE);
            for chunk in line.split_inclusive(|letter: char| letter.is_whitespace() || "\"'<>()=,;".contains(letter)) {
                if is_file_name(chunk) {
                    said.push_str(chunk);
                } else {
                    say(chunk, has_phase, &mut said);
                }
            }
        }
        for (article, counterpart) in [("an travel", "a travel"), ("An travel", "A travel")] {
            if said.contains(article) {
                said = said.replace(article, counterpart);
            }
        }
        Cow::Owned(said)
    }

    /// The program's own name for a key or a column of a file about this axis; `None` if it belongs to the other axis.
    ///
    /// ```
    /// use dynamics::Axis;
    ///
    /// assert_eq!(Axis::Linear.name_within("force_n").as_deref(), Some("torque_mnm"));
    /// assert_eq!(Axis::Linear.name_within("torque_mnm"), None);
    /// assert_eq!(Axis::Linear.name_within("inertia").as_deref(), Some("inertia"));
    /// ```
    #[must_use]
    pub fn name_within(self, key: &str) -> Option<String> {
        if self.is_rotary() {
            return Some(key.to_owned());
        }
        let within = |word: &str| {
            let known = WORDS.iter().find(|(_, said)| *said == word);
            known.map_or_else(|| word.to_owned(), |(name, _)| (*name).to_owned())
        };
        let name = key.split('_').map(within).collect::<Vec<_>>().join("_");
        (self.words(&name) == key).then_some(name)
    }

    /// A table of a file about this axis with its keys, nested ones included, replaced by the program's own names.
    ///
    /// # Errors
    /// The name of a key that belongs to the other axis.
    pub fn table_within(self, table: toml::Table) -> Result<toml::Table, String> {
        let entry =
            |(key, value): (String, toml::Value)| Ok((self.name_within(&key).ok_or(key)?, self.value_within(value)?));
        table.into_iter().map(entry).collect()
    }

    fn value_within(self, value: toml::Value) -> Result<toml::Value, String> {
        Ok(match value {
            toml::Value::Table(table) => toml::Value::Table(self.table_within(table)?),
            toml::Value::Array(values) => {
                toml::Value::Array(values.into_iter().map(|value| self.value_within(value)).collect::<Result<_, _>>()?)
            }
            other => other,
        })
    }
}

/// Whether a text has a full stop between a letter or digit and a letter, as a file name has.
fn is_file_name(chunk: &str) -> bool {
    let bytes = chunk.as_bytes();
    bytes.windows(3).any(|three| three[0].is_ascii_alphanumeric() && three[1] == b'.' && three[2].is_ascii_alphabetic())
}

fn say(chunk: &str, has_phase: bool, said: &mut String) {
    let mut rest = chunk;
    while !rest.is_empty() {
        let letters = rest.find(|letter: char| !letter.is_ascii_alphabetic()).unwrap_or(rest.len());
        if letters == 0 {
            let others = rest.find(|letter: char| letter.is_ascii_alphabetic()).unwrap_or(rest.len());
            said.push_str(&rest[..others]);
            rest = &rest[others..];
            continue;
        }
        let (word, behind) = rest.split_at(letters);
        rest = behind;
        if has_phase && word == "rad" {
            said.push_str(word);
        } else {
            said.push_str(&counterpart(word));
        }
    }
}

/// The counterpart of a word on a linear axis, capitalised like the word.
fn counterpart(word: &str) -> Cow<'_, str> {
    if let Some((_, said)) = WORDS.iter().find(|(name, _)| *name == word) {
        return Cow::Borrowed(said);
    }
    let Some(first) = word.chars().next().filter(char::is_ascii_uppercase) else { return Cow::Borrowed(word) };
    let lower = format!("{}{}", first.to_ascii_lowercase(), &word[1..]);
    WORDS.iter().find(|(name, _)| *name == lower).map_or(Cow::Borrowed(word), |(_, said)| {
        let mut letters = said.chars();
        Cow::Owned(
            letters.next().map_or_else(String::new, |first| first.to_ascii_uppercase().to_string() + letters.as_str()),
        )
    })
}
