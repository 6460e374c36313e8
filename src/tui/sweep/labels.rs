//! Values of an axis in few letters, but so that no two look the same.

use crate::study::sweep::plain;
use crate::tui::numbers::{brief, significant};
use std::collections::HashSet;

/// Letters of a word, at most, if words can be told apart by them.
const LONGEST: usize = 12;

/// Significant digits of a number: at least so many,
const LEAST_DIGITS: usize = 3;
/// all of them where there are no more than so many,
const WHOLE: usize = 5;
/// and so many are enough to tell any two numbers apart.
const MOST_DIGITS: usize = 17;

/// The values of an axis, as TOML, as short as they can be told apart.
pub(super) fn labels(values: &[String]) -> Vec<String> {
    let different = count_different(values);
    let are_told_apart = |labels: &Vec<String>| count_different(labels) == different;
    let mut ways = (LEAST_DIGITS..=MOST_DIGITS)
        .map(|digits| (digits, shortened as fn(&str) -> String))
        .chain([(MOST_DIGITS, ending as fn(&str) -> String)]);
    let labels = ways.find_map(|(digits, shorten)| {
        let labels = values.iter().map(|value| match value.parse() {
            Ok(value) => number(value, digits),
            Err(_) => shorten(&plain(value)),
        });
        Some(labels.collect()).filter(are_told_apart)
    });
    labels.unwrap_or_else(|| values.iter().map(|value| plain(value)).collect())
}

/// How many there are of which no two mean the same: 1 and 1.00 do.
fn count_different(values: &[String]) -> usize {
    let meaning = |value: &String| match value.parse::<f64>() {
        Ok(number) => format!("{number:e}"),
        Err(_) => plain(value),
    };
    values.iter().map(meaning).collect::<HashSet<_>>().len()
}

/// A single value, where there is nothing to tell it from.
pub(super) fn label(value: &str) -> String {
    match value.parse() {
        Ok(value) => number(value, LEAST_DIGITS),
        Err(_) => shortened(&plain(value)),
    }
}

/// Two numbers, such as the ends of a range.
pub(super) fn both(ends: [f64; 2]) -> [String; 2] {
    let digits = (LEAST_DIGITS..MOST_DIGITS).find(|digits| {
        let [low, high] = ends.map(|end| number(end, *digits));
        low != high || ends[0] == ends[1]
    });
    ends.map(|end| number(end, digits.unwrap_or(MOST_DIGITS)))
}

/// A number with all its digits if they are few, or else to so many.
fn number(value: f64, digits: usize) -> String {
    let whole = brief(value, WHOLE);
    match whole.parse() == Ok(value) {
        true => whole,
        false => significant(value, digits),
    }
}

/// The beginning of a word.
fn shortened(word: &str) -> String {
    word.chars().take(LONGEST).collect()
}

/// The end of a word, as of a path.
fn ending(word: &str) -> String {
    let letters = word.chars().count();
    word.chars().skip(letters.saturating_sub(LONGEST)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels_of(values: &[&str]) -> Vec<String> {
        let values: Vec<String> = values.iter().map(|it| (*it).to_owned()).collect();
        labels(&values)
    }

    #[test]
    fn values_of_an_axis_are_told_apart() {
        assert_eq!(
            labels_of(&["1.0", "1.0625", "1.125"]),
            ["1", "1.0625", "1.125"]
        );
        assert_eq!(
            labels_of(&["1", "4.6415888336128", "21.544346900319", "1e-7"]),
            ["1", "4.64", "21.5", "1e-7"]
        );
        assert_eq!(
            labels_of(&["1.000001", "1.000002", "1"]),
            ["1.000001", "1.000002", "1"]
        );
        assert_eq!(labels_of(&["1", "1.000001"]), ["1", "1.000001"]);
        assert_eq!(labels_of(&["1", "1.0"]), ["1", "1"]);
        assert_eq!(
            labels_of(&["\"parallel\"", "'none'", "true"]),
            ["parallel", "none", "true"]
        );
        assert_eq!(
            labels_of(&["[0.70711, 0.70711]", "[0.70711, -0.70711]"]),
            ["[0.70711, 0.", "[0.70711, -0"]
        );
        assert_eq!(
            labels_of(&["\"meshes/vesicle-1.msh\"", "\"meshes/vesicle-2.msh\""]),
            ["esicle-1.msh", "esicle-2.msh"]
        );
        let ends = [
            "\"1-one-long-word-1\"",
            "\"1-one-long-word-2\"",
            "\"2-one-long-word-1\"",
        ];
        assert_eq!(labels_of(&ends)[2], "2-one-long-word-1");
        assert_eq!(label("4.6415888336128"), "4.64");
    }

    #[test]
    fn the_ends_of_a_range_differ() {
        assert_eq!(both([0.112_345, 0.341_9]), ["0.112", "0.3419"]);
        assert_eq!(both([0.999_123_4, 0.999_223_4]), ["0.9991", "0.9992"]);
        assert_eq!(both([0.123_456_7; 2]), ["0.123", "0.123"]);
    }
}
