//! Scenes for the app: a preset's name, a TOML file, or a run's folder.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::app::set_anchoring;
use super::state::{App, Slot};
use crate::record::{LoadError, RunFolder, load_run_scene, load_scene};
use crate::scene::{Scene, preset_names};

/// The scene in a run's folder.
const SCENE_FILE: &str = "scene.toml";

/// The four cases of the paper's Table 2, each of them a preset: quick, and as Table 1 has them.
const CASES: [[&str; App::CASES]; 2] = [
    ["case1-quick", "case2-quick", "case3-quick", "case4-quick"],
    ["case1", "case2", "case3", "case4"],
];

/// How many forms each of them has.
pub(super) const FORMS: usize = CASES.len();

/// What the app opens without a scene.
pub const DEFAULT: &str = "case3-quick";

/// The slots that the app begins with, and which of them is shown: the four quick cases, the four as printed, and the
/// scene behind them where it is none of them. Overrides hold for the scene, and where it is a case
/// for the other cases too: they are there to be compared. A case of the other form that cannot have them is opened
/// without them, and says so.
///
/// # Errors
/// Those of [`open`], and [`LoadError::InUse`].
pub fn open_with_cases(
    source: &OsStr,
    overrides: &[String],
) -> Result<(Vec<Slot>, usize), LoadError> {
    let all = CASES.as_flattened();
    let place = all.iter().position(|case| source == OsStr::new(case));
    let form = place.map(|place| place / App::CASES);
    let mut slots = Vec::new();
    for (index, cases) in CASES.iter().enumerate() {
        for case in cases {
            let case = OsStr::new(case);
            slots.push(match form {
                None => open(case, &[])?,
                Some(form) if form == index => open(case, overrides)?,
                Some(_) => open_in_other_form(case, overrides)?,
            });
        }
    }
    if let Some(place) = place {
        return Ok((slots, place));
    }
    let slot = open(source, overrides)?;
    check_free(&slot)?;
    slots.push(slot);
    Ok((slots, all.len()))
}

/// Opens a case with overrides that were meant for its other form.
fn open_in_other_form(case: &OsStr, overrides: &[String]) -> Result<Slot, LoadError> {
    open(case, overrides).or_else(|_| {
        let mut slot = open(case, &[])?;
        slot.remark = Some(format!(
            "{} is as built in: {} cannot be set there",
            slot.name,
            overrides.join(", ")
        ));
        Ok(slot)
    })
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
        let mut slot = slot(source, None, overrides)?;
        slot.preset = preset_of(source, &slot.scene);
        return Ok(slot);
    }
    open_file(path, overrides)
}

/// The preset that a scene is, but for its anchoring; `None` where more was overridden.
fn preset_of(name: &OsStr, scene: &Scene) -> Option<&'static str> {
    let name = preset_names().find(|known| name == OsStr::new(known))?;
    let mut preset = load_scene(OsStr::new(name), &[]).ok()?.scene;
    if let Some(anchoring) = scene.anchoring {
        set_anchoring(&mut preset, anchoring.kind);
    }
    (preset == *scene).then_some(name)
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
        assert_eq!((names, active), (CASES.as_flattened().to_vec(), 6));
        assert!(slots.iter().all(|slot| slot.scene.time.end == 5e-4));
        assert!(slots.iter().all(|slot| slot.preset.is_none()));

        let (slots, active) = open_with_cases(OsStr::new("circle"), &overrides).unwrap();
        assert_eq!((slots.len(), active), (9, 8));
        assert_eq!(slots[8].scene.time.end, 5e-4);
        assert_eq!(slots[2].scene.time.end, 1e-3);
        assert_eq!(slots[2].preset, Some("case3-quick"));
    }

    #[test]
    fn an_override_that_the_other_form_cannot_have_is_left_out_there_and_said() {
        let overrides = ["mesh.cells=20".to_owned()];
        let (slots, active) = open_with_cases(OsStr::new("case3"), &overrides).unwrap();
        assert_eq!((active, slots[2].preset), (6, Some("case3-quick")));
        let remark = slots[2].remark.as_deref().expect("a remark");
        assert!(remark.contains("case3-quick is as built in: mesh.cells=20"));
        assert_eq!((&slots[6].remark, slots[6].preset), (&None, None));
        assert!(open_with_cases(OsStr::new("case3-quick"), &overrides).is_err());
    }

    #[test]
    fn a_preset_with_another_anchoring_is_still_that_preset() {
        let overrides = ["anchoring.kind=parallel".to_owned()];
        let (slots, active) = open_with_cases(OsStr::new(DEFAULT), &overrides).unwrap();
        assert_eq!((active, slots[2].preset), (2, Some("case3-quick")));
        assert_eq!(
            slots[7].anchoring(),
            Some(crate::scene::AnchoringKind::Parallel)
        );
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
