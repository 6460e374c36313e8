//! Near misses: which of the allowed words a wrong one was meant to be.

/// A longer word is no slip of the pen, and comparing costs the product of the lengths.
const LONGEST_WORD: usize = 64;

/// The candidate that `word` is most likely a slip of, if any is close enough: one letter in three
/// wrong, missing, doubled or swapped, or the beginning of exactly one candidate.
pub(crate) fn nearest<'a>(
    word: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    if word.is_empty() || word.len() > LONGEST_WORD {
        return None;
    }
    let word = normal(word);
    let letters = word.chars().count();
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let closest = candidates
        .iter()
        .map(|candidate| {
            (
                strsim::damerau_levenshtein(&word, &normal(candidate)),
                *candidate,
            )
        })
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, _)| *distance <= (letters / 3).max(1))
        .filter(|(distance, candidate)| *distance < letters.max(candidate.chars().count()));
    if let Some((_, candidate)) = closest {
        return Some(candidate);
    }
    let mut begun = candidates
        .into_iter()
        .filter(|candidate| normal(candidate).starts_with(&word));
    match (begun.next(), begun.next()) {
        (Some(candidate), None) => Some(candidate),
        _ => None,
    }
}

/// Capitals and the kind of dash are not worth a difference.
fn normal(word: &str) -> String {
    word.to_lowercase().replace('-', "_")
}

#[cfg(test)]
mod tests {
    use super::nearest;

    const WORDS: [&str; 5] = ["target", "penalty", "tolerance", "law_tolerance", "x"];

    #[test]
    fn slips_find_their_word() {
        assert_eq!(nearest("penality", WORDS), Some("penalty"));
        assert_eq!(nearest("tagret", WORDS), Some("target"));
        assert_eq!(nearest("Target", WORDS), Some("target"));
        assert_eq!(nearest("law-tolerance", WORDS), Some("law_tolerance"));
        assert_eq!(nearest("tol", WORDS), Some("tolerance"));
    }

    #[test]
    fn strangers_find_none() {
        assert_eq!(nearest("banana", WORDS), None);
        assert_eq!(nearest("", WORDS), None);
        assert_eq!(nearest("t", WORDS), None, "the beginning of two words");
        assert_eq!(nearest("z", WORDS), None, "all letters of a word differ");
        assert_eq!(nearest(&"target".repeat(100_000), WORDS), None);
    }
}
