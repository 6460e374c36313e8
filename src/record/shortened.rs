//! Parts of files in messages.

use std::borrow::Cow;

/// At most this many letters of a file's content are quoted.
const MOST: usize = 40;

/// The beginning of a text, which may be megabytes long.
pub(super) fn shortened(text: &str) -> Cow<'_, str> {
    shortened_to(text, MOST)
}

/// As [`shortened`], for what has words around what it quotes.
pub(super) fn shortened_to(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
        None => Cow::Borrowed(text),
    }
}

#[cfg(test)]
mod tests {
    use super::shortened;

    #[test]
    fn a_long_text_is_cut_between_letters() {
        assert_eq!(shortened(""), "");
        let exact = "é".repeat(40);
        assert_eq!(shortened(&exact), exact);
        assert_eq!(shortened(&"é".repeat(5_000_000)), exact + "…");
    }
}
