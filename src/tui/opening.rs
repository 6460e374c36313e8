//! Scenes for the app: a preset's name, a TOML file, or a run's folder.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::state::{App, Slot};
use crate::record::{LoadError, RunFolder, load_run_scene, load_scene};

/// The scene in a run's folder.
const SCENE_FILE: &str = "scene.toml";

/// The four cases of the paper's Table 2, each of them a preset.
const CASES: [&str; App::CASES] = ["case1", "case2", "case3", "case4"];

/// The slots that the app begins with, and which of them is shown: the four cases, and the
/// scene behind them where it is none of them. Overrides hold for the scene, and where it is a case
/// for the other cases too: they are there to be compared.
///
/// # Errors
/// Those of [`open`], and [`LoadError::InUse`].
pub fn open_with_cases(
    source: &OsStr,
    overrides: &[String],
) -> Result<(Vec<Slot>, usize), LoadError> {
    let place = CASES.iter().position(|case| source == OsStr::new(case));
    let cases = if place.is_some() { overrides } else { &[] };
    let mut slots = CASES
        .iter()
        .map(|case| open(OsStr::new(case), cases))
        .collect::<Result<Vec<Slot>, LoadError>>()?;
    if let Some(place) = place {
        return Ok((slots, place));
    }
    let slot = open(source, overrides)?;
    check_free(&slot)?;
    slots.push(slot);
    Ok((slots, App::CASES))
}

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
        let loaded = load_run_scene(path, overrides)?;
        let mut slot = Slot::new(String::new(), Some(inside), loaded.scene);
        // A run is known by its folder: "." has a name only when it is written out.
        let whole = std::path::absolute(path).unwrap_or_else(|_| path.into());
        slot.name = match whole.file_name() {
            Some(name) => name.to_string_lossy().into_owned(),
            None => loaded.name.to_string_lossy().into_owned(),
        };
        slot.folder = Some(path.to_owned());
        return Ok(slot);
    }
    if is_preset {
        return slot(source, None, overrides);
    }
    open_file(path, overrides)
}

/// Checks that no other process computes the run whose folder was opened: a user who names it means that run and not
/// another of its scene.
///
/// # Errors
/// [`LoadError::InUse`].
pub(super) fn check_free(slot: &Slot) -> Result<(), LoadError> {
    match &slot.folder {
        Some(folder) if RunFolder::is_in_use(folder) => Err(LoadError::InUse {
            folder: folder.clone(),
        }),
        _ => Ok(()),
    }
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
    let name = loaded.name.to_string_lossy().into_owned();
    Ok(Slot::new(name, file, loaded.scene))
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
    fn the_cases_come_first_and_share_the_overrides_of_one_of_them() {
        let overrides = ["time.end=5e-4".to_owned()];
        let (slots, active) = open_with_cases(OsStr::new("case3"), &overrides).unwrap();
        let names: Vec<&str> = slots.iter().map(|slot| slot.name.as_str()).collect();
        assert_eq!((names, active), (CASES.to_vec(), 2));
        assert!(slots.iter().all(|slot| slot.scene.time.end == 5e-4));

        let (slots, active) = open_with_cases(OsStr::new("circle"), &overrides).unwrap();
        assert_eq!((slots.len(), active), (5, 4));
        assert_eq!(slots[4].scene.time.end, 5e-4);
        assert_eq!(slots[2].scene.time.end, 1e-3);
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
    fn the_folder_of_a_run_that_goes_on_is_refused() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("long");
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("scene.toml"), "[mesh]\ncells = 8\n").unwrap();
        let held = fs::File::open(&folder).unwrap();
        held.try_lock().unwrap();
        let error = open_with_cases(folder.as_os_str(), &[]).unwrap_err();
        let scene = folder.join("scene.toml");
        assert!(matches!(error, LoadError::InUse { .. }), "{error}");
        assert!(error.to_string().contains(scene.to_str().unwrap()));
        // Its scene can be started again.
        assert!(open_with_cases(scene.as_os_str(), &[]).is_ok());
        drop(held);
        assert!(open_with_cases(folder.as_os_str(), &[]).is_ok());
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
