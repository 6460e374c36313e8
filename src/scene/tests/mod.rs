//! Tests of scenes as a whole; those of a part sit beside it.

use std::io;

use super::*;

mod changes;
mod errors;
mod guide;
mod overrides;
mod reading;
mod robustness;
mod round_trip;

impl Scene {
    /// The scene of a text that is right and reads no files, with settings `KEY=VALUE`: for the tests of
    /// all modules.
    #[track_caller]
    pub(crate) fn of_text(text: &str, settings: &[&str]) -> Self {
        read_with(text, settings, &[]).unwrap_or_else(|error| panic!("{error}"))
    }
}

/// Reads `text` with overrides, and with files.
fn read_with(text: &str, overrides: &[&str], files: &[(&str, &str)]) -> Result<Scene, SceneError> {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    let mut read = |path: &str| {
        let file = files.iter().find(|(name, _)| *name == path);
        file.map(|(_, text)| text.as_bytes().to_vec())
            .ok_or_else(|| io::ErrorKind::NotFound.into())
    };
    Scene::parse(text, "a.toml", &overrides, &mut read)
}

fn read(text: &str) -> Scene {
    Scene::of_text(text, &[])
}
