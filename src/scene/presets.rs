//! The scenes that are built in: the files of `presets/`.

use thiserror::Error;

use super::error::{DidYouMean, Quoted};
use super::suggest::nearest;

const PRESETS: [(&str, &str); 18] = [
    ("case1", include_str!("../../presets/case1.toml")),
    ("case2", include_str!("../../presets/case2.toml")),
    ("case3", include_str!("../../presets/case3.toml")),
    ("case4", include_str!("../../presets/case4.toml")),
    (
        "case1-draft",
        include_str!("../../presets/case1-draft.toml"),
    ),
    (
        "case2-draft",
        include_str!("../../presets/case2-draft.toml"),
    ),
    (
        "case3-draft",
        include_str!("../../presets/case3-draft.toml"),
    ),
    (
        "case4-draft",
        include_str!("../../presets/case4-draft.toml"),
    ),
    ("case1-fine", include_str!("../../presets/case1-fine.toml")),
    ("case2-fine", include_str!("../../presets/case2-fine.toml")),
    ("case3-fine", include_str!("../../presets/case3-fine.toml")),
    ("case4-fine", include_str!("../../presets/case4-fine.toml")),
    ("bending", include_str!("../../presets/bending.toml")),
    ("circle", include_str!("../../presets/circle.toml")),
    ("curvature", include_str!("../../presets/curvature.toml")),
    ("field", include_str!("../../presets/field.toml")),
    ("pull", include_str!("../../presets/pull.toml")),
    ("noise", include_str!("../../presets/noise.toml")),
];

/// There is no such preset.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("there is no preset {}{} Presets: {}", Quoted(name), DidYouMean(near),
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
