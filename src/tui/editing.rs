//! The scene in the user's editor.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::state::Slot;
use crate::scene::{Scene, preset};

/// The editor that POSIX systems have.
const USUAL: &str = "vi";

/// The editor that the environment asks for (`variable` looks one up): a command, maybe with
/// arguments.
pub(super) fn editor(variable: impl Fn(&str) -> Option<String>) -> String {
    ["VISUAL", "EDITOR"]
        .into_iter()
        .filter_map(variable)
        .find(|command| !command.trim().is_empty())
        .unwrap_or_else(|| USUAL.to_owned())
}

/// A file that is edited.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct SceneFile {
    /// Where it is.
    pub path: PathBuf,
    /// What was written to it, if it was made to be edited.
    made: Option<String>,
}

impl SceneFile {
    /// Removes it if it was made to be edited and nothing was changed in it; returns whether it is still there.
    pub fn stays(&self) -> bool {
        let is_unchanged = self.made.as_ref().is_some_and(|text| {
            std::fs::read_to_string(&self.path).is_ok_and(|there| there == *text)
        });
        !(is_unchanged && std::fs::remove_file(&self.path).is_ok())
    }
}

/// The file to edit: the scene's own, or for a preset a new one in `folder`, which never takes the
/// place of another.
///
/// # Errors
/// What could not be written, and why.
pub(super) fn file(slot: &Slot, folder: &Path) -> Result<SceneFile, String> {
    if let Some(file) = &slot.file {
        let (path, made) = (file.clone(), None);
        return Ok(SceneFile { path, made });
    }
    let text = text(slot);
    for number in 1_u64.. {
        let path = folder.join(match number {
            1 => format!("{}.toml", slot.name),
            _ => format!("{}-{number}.toml", slot.name),
        });
        let tell = |reason| format!("cannot write {}: {reason}", path.display());
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(mut file) => {
                file.write_all(text.as_bytes()).map_err(tell)?;
                let made = Some(text);
                return Ok(SceneFile { path, made });
            }
            Err(reason) if reason.kind() == io::ErrorKind::AlreadyExists => {}
            Err(reason) => return Err(tell(reason)),
        }
    }
    Err("all names are taken".to_owned())
}

/// A preset's own text with its remarks, as long as the scene is what it says.
fn text(slot: &Slot) -> String {
    let unchanged = preset(&slot.name).filter(|text| {
        let mut no_files = |_: &str| Err(io::ErrorKind::NotFound.into());
        Scene::parse(text, &slot.name, &[], &mut no_files).is_ok_and(|scene| scene == *slot.scene)
    });
    unchanged.map_or_else(|| slot.scene.to_toml(), str::to_owned)
}

/// Runs the editor on the terminal and waits until it ends.
///
/// # Errors
/// It could not be started, or reports that it failed.
pub(super) fn edit(editor: &str, file: &Path) -> Result<(), String> {
    // As git does it: the shell splits the command, and the path stays one word.
    let status = Command::new("sh")
        .arg("-c")
        .arg(format!("{editor} \"$@\""))
        .arg(editor)
        .arg(file)
        .stdin(Stdio::inherit())
        .stdout(Stdio::inherit())
        .stderr(Stdio::inherit())
        .status()
        .map_err(|reason| format!("cannot start the editor '{editor}': {reason}"))?;
    if status.success() {
        return Ok(());
    }
    Err(format!(
        "the editor '{editor}' failed ({status}); set VISUAL or EDITOR to the one you want. The \
         scene stays as it was"
    ))
}

#[cfg(test)]
mod tests {
    use super::super::opening::open;
    use super::*;
    use std::ffi::OsStr;
    use std::fs;
    use std::sync::Arc;

    #[test]
    fn the_environment_names_the_editor() {
        let given = |visual: &str, command: &str| {
            let variables = [
                ("VISUAL", visual.to_owned()),
                ("EDITOR", command.to_owned()),
            ];
            editor(move |name| {
                let found = variables.iter().find(|(known, _)| *known == name);
                found.map(|(_, value)| value.clone())
            })
        };
        assert_eq!(given("code --wait", "nano"), "code --wait");
        assert_eq!(given("", "nano"), "nano");
        assert_eq!(given(" ", ""), "vi");
        assert_eq!(editor(|_| None), "vi");
    }

    #[test]
    fn a_preset_is_written_with_its_remarks_and_overwrites_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut slot = open(OsStr::new("case3"), &[]).unwrap();
        fs::write(folder.path().join("case3.toml"), "mine").unwrap();
        let made = file(&slot, folder.path()).unwrap();
        let path = folder.path().join("case3-2.toml");
        assert_eq!(made.path, path);
        assert_eq!(fs::read_to_string(&path).unwrap(), preset("case3").unwrap());
        // A copy in which nothing was changed does not stay; one with a change does.
        assert!(!made.stays() && !path.exists());
        let made = file(&slot, folder.path()).unwrap();
        fs::write(&path, "changed").unwrap();
        assert!(made.stays() && path.exists());
        assert_eq!(
            fs::read_to_string(folder.path().join("case3.toml")).unwrap(),
            "mine"
        );

        Arc::make_mut(&mut slot.scene).time.end = 5e-4;
        let changed = file(&slot, folder.path()).unwrap();
        assert_eq!(changed.path, folder.path().join("case3-3.toml"));
        assert_eq!(
            *open(changed.path.as_os_str(), &[]).unwrap().scene,
            *slot.scene
        );

        // A scene's own file stays whatever is done to it.
        slot.file = Some(changed.path.clone());
        let own = file(&slot, Path::new("/nowhere")).unwrap();
        assert!(own.path == changed.path && own.stays() && changed.path.exists());
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_told() {
        let slot = open(OsStr::new("case3"), &[]).unwrap();
        let error = file(&slot, Path::new("/nowhere")).unwrap_err();
        assert!(
            error.starts_with("cannot write /nowhere/case3.toml: "),
            "{error}"
        );
    }

    #[test]
    fn the_editor_gets_the_path_as_one_word() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a b'c.toml");
        edit("true && echo changed >", &path).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "changed\n");
        let error = edit("false", &path).unwrap_err();
        assert!(error.contains("'false' failed (exit status: 1)"), "{error}");
        assert!(edit("no-such-editor-anywhere 2>/dev/null", &path).is_err());
    }
}
