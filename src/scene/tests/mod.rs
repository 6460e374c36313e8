//! Tests of scenes as a whole; those of a part sit beside it.

use std::io;

use super::*;

mod errors;
mod guide;
mod overrides;
mod reading;
mod robustness;
mod round_trip;

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
    read_with(text, &[], &[]).unwrap_or_else(|error| panic!("{error}"))
}
