//! A scene from its name: a preset's, or a file's.

use super::bounded_read::{read_bytes, read_file, read_file_text, read_text};
use super::folder::{SCENE, a_file_of};
use crate::scene::{Scene, SceneError, UnknownPreset, find_preset, preset, preset_names};
use std::ffi::{OsStr, OsString};
use std::io;
use std::path::{Path, PathBuf};

/// Bytes of a scene, which is text by hand, at most.
pub(crate) const LARGEST_SCENE: u64 = 4 << 20;
/// Bytes of a file of nodal values or of a mesh at most: enough for twenty million nodes.
pub(crate) const LARGEST_INPUT: u64 = 1 << 30;

/// A scene and what to call its runs.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedScene {
    /// The scene, with overrides.
    pub scene: Scene,
    /// The preset's name, or the file's without its extension.
    pub name: OsString,
}

/// Why a scene could not be had.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// There is no such preset and no such file.
    #[error("there is no file '{name}', and {preset}")]
    Unknown {
        /// As it was given.
        name: String,
        /// Names the presets and a near miss.
        #[source]
        preset: UnknownPreset,
    },
    /// Nothing was named.
    #[error("the scene's name is empty. Presets: {}", preset_names().collect::<Vec<_>>().join(", "))]
    Nameless,
    /// A folder is not a scene.
    #[error(
        "{} is a folder, not a scene{}",
        path.display(),
        if *is_run { "; to run its scene again, name the file scene.toml in it" } else { "" }
    )]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Whether it holds a run.
        is_run: bool,
    },
    /// The run in a folder is still computed.
    #[error(
        "the run in {} is in use by another process, or open here: end that first, or open {} to restart its \
         scene",
        folder.display(),
        folder.join("scene.toml").display()
    )]
    InUse {
        /// The folder.
        folder: PathBuf,
    },
    /// The file cannot be read.
    #[error("cannot read {}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        #[source]
        reason: io::Error,
    },
    /// A run's folder has no scene.
    #[error(
        "{0} holds a run, but no scene.toml, its scene: to resume it name the scene that it was begun \
         with, a preset or a TOML file: vesica run SCENE --out {0} --resume",
        folder.display()
    )]
    NoScene {
        /// The folder.
        folder: PathBuf,
    },
    /// The scene is wrong.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// Loads the scene that `source` names: a preset, or else a TOML file. `overrides` are
/// `KEY=VALUE`. Paths in the scene are relative to its file, for a preset to the working folder.
///
/// # Errors
/// [`LoadError`]: with a near miss for an unknown name, with the place in the text for a wrong
/// scene.
pub fn load_scene(source: &OsStr, overrides: &[String]) -> Result<LoadedScene, LoadError> {
    let found = source.to_str().and_then(|name| Some((name, preset(name)?)));
    if let Some((name, text)) = found {
        let origin = format!("preset {name}");
        let scene = Scene::parse(text, &origin, overrides, &mut |path| {
            read_bytes(Path::new(path), LARGEST_INPUT)
        })?;
        let name = source.to_owned();
        return Ok(LoadedScene { scene, name });
    }
    if source.is_empty() {
        return Err(LoadError::Nameless);
    }
    let path = Path::new(source);
    parse(path, &read_scene(path)?, overrides, read_bytes)
}

/// Loads the scene of the run in a folder. Its files are read where they are regular ones: nobody gives a
/// run's folder a pipe on purpose.
///
/// # Errors
/// [`LoadError`].
pub fn load_run_scene(folder: &Path, overrides: &[String]) -> Result<LoadedScene, LoadError> {
    let path = folder.join(SCENE);
    let text = read_file_text(&path, LARGEST_SCENE).map_err(|reason| match reason.kind() {
        io::ErrorKind::NotFound if a_file_of(folder).is_some() => LoadError::NoScene {
            folder: folder.to_owned(),
        },
        io::ErrorKind::NotFound => LoadError::Folder {
            path: folder.to_owned(),
            is_run: false,
        },
        _ => LoadError::Unreadable {
            path: path.clone(),
            reason,
        },
    })?;
    parse(&path, &text, overrides, read_file)
}

/// The scene that a file has. `read` reads what it names.
fn parse(
    path: &Path,
    text: &str,
    overrides: &[String],
    read: fn(&Path, u64) -> io::Result<Vec<u8>>,
) -> Result<LoadedScene, LoadError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let origin = path.display().to_string();
    let scene = Scene::parse(text, &origin, overrides, &mut |relative| {
        read(&folder.join(relative), LARGEST_INPUT)
    })?;
    let name = path.file_stem().unwrap_or(OsStr::new("scene")).to_owned();
    Ok(LoadedScene { scene, name })
}

fn read_scene(path: &Path) -> Result<String, LoadError> {
    if path.is_dir() {
        return Err(LoadError::Folder {
            path: path.to_owned(),
            is_run: path.join(SCENE).is_file(),
        });
    }
    read_text(path, LARGEST_SCENE).map_err(|reason| {
        // A word without a folder or an extension was meant as a preset's name.
        let is_word = path.extension().is_none() && path.parent() == Some(Path::new(""));
        let name = path.to_string_lossy().into_owned();
        match find_preset(&name) {
            Err(preset) if is_word && reason.kind() == io::ErrorKind::NotFound => {
                LoadError::Unknown { name, preset }
            }
            _ => LoadError::Unreadable {
                path: path.to_owned(),
                reason,
            },
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Shape, preset_names};
    use std::fs;

    fn error(source: impl AsRef<OsStr>) -> String {
        load_scene(source.as_ref(), &[]).unwrap_err().to_string()
    }

    #[test]
    fn presets_are_found_by_name() {
        for name in preset_names() {
            assert_eq!(load_scene(OsStr::new(name), &[]).unwrap().name, name);
        }
    }

    #[test]
    fn a_near_miss_is_told() {
        let text = error("Case-3");
        assert!(text.contains("did you mean 'case3'?"), "{text}");
        assert!(
            text.contains("Presets: case1, case2, case3, case4"),
            "{text}"
        );
    }

    #[test]
    fn a_file_that_is_not_there_is_an_error_with_the_path() {
        let text = error("no/such/scene.toml");
        assert!(
            text.starts_with("cannot read no/such/scene.toml: "),
            "{text}"
        );
        let text = error("scene-that-is-not-there.toml");
        assert!(text.starts_with("cannot read scene-that"), "{text}");
        assert!(error("").contains("is empty. Presets: case1, "));
    }

    #[test]
    fn a_folder_is_no_scene() {
        let folder = tempfile::tempdir().unwrap();
        assert!(error(folder.path()).ends_with("is a folder, not a scene"));
        fs::write(folder.path().join("scene.toml"), "").unwrap();
        assert!(error(folder.path()).contains("name the file scene.toml"));
    }

    #[test]
    fn bytes_that_are_no_text_are_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        fs::write(&path, [0xff, 0xfe, 0x00]).unwrap();
        assert!(error(&path).contains("UTF-8"), "{}", error(&path));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_without_end_is_an_error() {
        assert!(error("/dev/zero").contains("a device"));
    }

    #[test]
    fn paths_in_a_scene_are_relative_to_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let values: String = (0..81).map(|_| "0.5\n").collect();
        fs::write(folder.path().join("phi0.txt"), values).unwrap();
        let path = folder.path().join("small.toml");
        fs::write(
            &path,
            "[mesh]\ncells = 8\n[vesicle]\nshape = \"file\"\nvalues = \"phi0.txt\"\n",
        )
        .unwrap();
        let loaded = load_scene(path.as_os_str(), &[]).unwrap();
        assert_eq!(loaded.name, "small");
        let Shape::File(nodal) = loaded.scene.vesicle.shape else {
            panic!("the shape is from a file");
        };
        assert_eq!(&*nodal.values, &[0.5; 81]);
    }
}
