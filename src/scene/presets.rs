//! The scenes that are built in: the files of `presets/`.

use thiserror::Error;

use super::error::{Quoted, did_you_mean};
use super::suggest::nearest;

macro_rules! presets {
    ($($name:literal)+) => {
        const PRESETS: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../presets/", $name, ".toml")))),+];
    };
}

// In the order in which they are listed.
presets! {
    "case1" "case2" "case3" "case4"
    "case1-quick" "case2-quick" "case3-quick" "case4-quick"
    "case1-fine" "case2-fine" "case3-fine" "case4-fine"
    "bending" "circle" "relaxation" "curvature" "field" "pull" "noise"
    "switch" "squeeze" "fredericks"
    "sphere" "redcell" "prolate" "stomatocyte" "redcell-nematic"
}

/// There is no such preset.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("there is no preset {}{} Presets: {}", Quoted(name), did_you_mean(near.map(Quoted)),
    preset_names().collect::<Vec<_>>().join(", "))]
pub struct UnknownPreset {
    /// What was asked for.
    pub name: String,
    /// What was probably meant.
    pub near: Option<&'static str>,
}

/// The names of the presets, in the order in which they are listed.
pub fn preset_names() -> impl Iterator<Item = &'static str> {
    PRESETS.iter().map(|(name, _)| *name)
}

/// The TOML of a preset.
pub fn preset(name: &str) -> Option<&'static str> {
    PRESETS
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, text)| *text)
}

/// The TOML of a preset, or an error that names the ones there are.
///
/// # Errors
///
/// If there is no preset of this name.
pub fn find_preset(name: &str) -> Result<&'static str, UnknownPreset> {
    preset(name).ok_or_else(|| UnknownPreset {
        name: name.to_owned(),
        near: nearest(name, preset_names()),
    })
}

/// One line about a preset: the first line of its file, a comment.
pub fn preset_description(name: &str) -> Option<&'static str> {
    preset(name)?.lines().next()?.strip_prefix("# ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_has_a_description() {
        for name in preset_names() {
            let description = preset_description(name).expect(name);
            assert!(
                (20..100).contains(&description.len()),
                "{name}: {description}"
            );
        }
    }

    #[test]
    fn a_near_miss_is_offered() {
        assert_eq!(preset("case5"), None);
        let error = find_preset("case-3")
            .expect_err("no such preset")
            .to_string();
        assert!(
            error.contains("did you mean 'case3'? Presets: case1, case2"),
            "{error}"
        );
    }
}
