//! Text and numbers within XML.

/// The text as it may stand in an attribute.
pub(crate) fn attribute(text: &str) -> String {
    let visible: String = text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect();
    visible.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The text as it may stand in a comment, where two hyphens would end it.
pub(crate) fn comment(text: &str) -> String {
    // Twice, since the space may stand beside one hyphen more.
    attribute(text).replace("--", "- -").replace("--", "- -")
}

/// The number in SI units, of one in units of a thousandth: N m of mNm. It reads back to the last bit.
pub(crate) fn si(thousandths: f64) -> String {
    (1e-3 * thousandths).to_string()
}
