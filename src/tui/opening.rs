//! Scenes for the app: a preset's name, a TOML file, or a run's folder.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::state::Slot;
use crate::record::{LoadError, load_scene};

/// The scene in a run's folder.
const SCENE_FILE: &str = "scene.toml";

/// Opens a scene, with overrides (`KEY=VALUE`).
///
/// # Errors
/// [`LoadError`]: with a near miss for an unknown name, with the place in the text for a wrong
/// scene.
pub fn open(source: &OsStr, overrides: &[String]) -> Result<Slot, LoadError> {
    let path = Path::new(source);
    let inside = path.join(SCENE_FILE);
    let is_preset = source
        .to_str()
        .is_some_and(|name| crate::scene::preset(name).is_some());
    if !is_preset && inside.is_file() {
        let mut slot = open_file(&inside, overrides)?;
        // A run is known by its folder: "." has a name only when it is written out.
        let whole = std::path::absolute(path).unwrap_or_else(|_| path.into());
        if let Some(name) = whole.file_name() {
            slot.name = name.to_string_lossy().into_owned();
        }
        return Ok(slot);
    }
    if is_preset {
        return slot(source, None, overrides);
    }
    open_file(path, overrides)
}

/// What a person typed: `~` is the home folder, as in a shell.
pub(super) fn typed_path(text: &str, home: Option<PathBuf>) -> PathBuf {
    let text = text.trim();
    match (text.strip_prefix("~/"), home) {
        (Some(rest), Some(home)) => home.join(rest),
        _ => text.into(),
    }
}

/// Opens a scene's file, even one that is called as a preset is.
///
/// # Errors
/// Those of [`open`].
pub(super) fn open_file(path: &Path, overrides: &[String]) -> Result<Slot, LoadError> {
    slot(path.as_os_str(), Some(path.to_owned()), overrides)
}

fn slot(source: &OsStr, file: Option<PathBuf>, overrides: &[String]) -> Result<Slot, LoadError> {
    let loaded = load_scene(source, overrides)?;
    Ok(Slot {
        name: loaded.name.to_string_lossy().into_owned(),
        file,
        scene: Arc::new(loaded.scene),
        run: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn presets_files_and_the_folders_of_runs_are_opened() {
        let overrides = ["time.end=5e-4".to_owned()];
        let preset = open(OsStr::new("case2"), &overrides).unwrap();
        assert_eq!((preset.name.as_str(), &preset.file), ("case2", &None));
        assert_eq!(preset.scene.time.end, 5e-4);

        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("long run");
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("scene.toml"), "[mesh]\ncells = 8\n").unwrap();
        let run = open(folder.as_os_str(), &[]).unwrap();
        assert_eq!(run.name, "long run");
        assert_eq!(run.file, Some(folder.join("scene.toml")));

        let file = open(run.file.unwrap().as_os_str(), &[]).unwrap();
        assert_eq!(file.name, "scene");
        assert_eq!(*file.scene, *run.scene);
    }

    #[test]
    fn what_is_none_of_them_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let error = open(folder.path().as_os_str(), &[])
            .unwrap_err()
            .to_string();
        assert!(error.contains("is a folder"), "{error}");
        let error = open(OsStr::new("case33"), &[]).unwrap_err().to_string();
        assert!(error.contains("did you mean 'case3'?"), "{error}");
    }

    #[test]
    fn a_typed_path_may_begin_at_home() {
        let home = || Some(PathBuf::from("/home/ada"));
        assert_eq!(
            typed_path(" ~/a.toml ", home()),
            Path::new("/home/ada/a.toml")
        );
        assert_eq!(typed_path("~/a.toml", None), Path::new("~/a.toml"));
        assert_eq!(typed_path("b~/a.toml", home()), Path::new("b~/a.toml"));
    }
}
