//! Where the numbers of a run come from: which program computed them, where, by which command, from which files.

use super::RecordError;
use super::bounded_read::open_file;
use super::folder::scene_files;
use super::summary::{Ending, now};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io::{self, Read};
use std::path::Path;
use sysinfo::{CpuRefreshKind, RefreshKind, System};

/// The program that computes. What is not known is `null`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Build {
    /// Of vesica.
    pub version: String,
    /// The commit of its source.
    pub commit: Option<String>,
    /// Whether the source was changed since that commit.
    pub changed: Option<bool>,
    /// With version and commit.
    pub compiler: Option<String>,
    /// The system that it was built for, as compilers name it.
    pub target: String,
    /// What processors it was built for, beyond the least of the target: `avx2` and the like.
    pub target_features: Vec<String>,
    /// "release" or "debug".
    pub profile: String,
}

impl Build {
    /// Of the running program.
    pub fn present() -> Build {
        let known = |text: &str| (!text.is_empty()).then(|| text.to_owned());
        let features = env!("VESICA_BUILD_FEATURES").split(',');
        Build {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: known(env!("VESICA_BUILD_COMMIT")),
            changed: env!("VESICA_BUILD_CHANGED").parse().ok(),
            compiler: known(env!("VESICA_BUILD_COMPILER")),
            target: env!("VESICA_BUILD_TARGET").to_owned(),
            target_features: features.filter_map(known).collect(),
            profile: env!("VESICA_BUILD_PROFILE").to_owned(),
        }
    }
}

/// The variable of the environment that keeps the computer's name out of all records, unless it is empty.
const NO_HOST: &str = "VESICA_NO_HOST";

/// Whether the environment allows that records name the computer.
pub(super) fn host_is_allowed() -> bool {
    std::env::var_os(NO_HOST).is_none_or(|value| value.is_empty())
}

/// What one process computed of a run: the first began it, each further one resumed it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Session {
    /// When it began.
    pub started: String,
    /// When it ended; `null`: it computes, or was killed.
    pub ended: Option<String>,
    /// Why it ended: "done", "failed: …", "killed", or what ended it, such as "SIGTERM".
    pub reason: Option<String>,
    /// The step that it began at.
    pub from_step: u64,
    /// The last step that it made, as far as that is known.
    pub to_step: u64,
    /// In how many threads it computed, where that is known.
    pub threads: Option<usize>,
    /// The program and its arguments.
    pub command: Vec<String>,
    /// The computer's name; `null` with `--no-host` and where VESICA_NO_HOST is set.
    pub host: Option<String>,
    /// The model of the processor; `None` where the system does not report it.
    pub processor: Option<String>,
    /// The program.
    pub program: Build,
}

impl Session {
    /// Of this process, which begins at a step. `host`: whether the computer is named.
    pub(super) fn begin(from_step: u64, host: bool) -> Session {
        let arguments = std::env::args_os();
        Session {
            started: now(),
            ended: None,
            reason: None,
            from_step,
            to_step: from_step,
            threads: None,
            command: arguments
                .map(|argument| argument.to_string_lossy().into_owned())
                .collect(),
            host: host.then(|| System::host_name().ok()).flatten(),
            processor: processor(),
            program: Build::present(),
        }
    }

    /// It ends.
    pub(super) fn end(&mut self, ending: &Ending) {
        self.ended = Some(now());
        self.reason = Some(match ending {
            Ending::Done => "done".to_owned(),
            Ending::Interrupted(by) => (*by).to_owned(),
            Ending::Failed(error) => format!("failed: {error}"),
        });
    }

    /// Its process has gone without a word, if it did not end.
    pub(super) fn end_if_killed(&mut self) {
        self.reason.get_or_insert_with(|| "killed".to_owned());
    }
}

/// The name of the processor's model, where the system tells it.
fn processor() -> Option<String> {
    let refresh = RefreshKind::nothing().with_cpu(CpuRefreshKind::nothing());
    let system = System::new_with_specifics(refresh).ok()?;
    let brand = system.cpus().first()?.brand().trim().to_owned();
    (!brand.is_empty()).then_some(brand)
}

/// A file that a run is computed from, as it stands in the run's folder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputRecord {
    /// Relative to the folder.
    pub path: String,
    /// The SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
}

/// The files that the run in a folder is computed from: the scene, and nodal values and meshes from files.
///
/// # Errors
/// [`RecordError::Read`].
pub(super) fn inputs(folder: &Path) -> Result<Vec<InputRecord>, RecordError> {
    let files = scene_files().filter(|file| folder.join(file).exists());
    files
        .map(|path| {
            let file = folder.join(&path);
            let sha256 = sha256(&file).map_err(RecordError::read(&file))?;
            Ok(InputRecord { path, sha256 })
        })
        .collect()
}

/// The inputs of the run in a folder that are not the files that were recorded, or are gone.
///
/// # Errors
/// [`RecordError::Read`].
pub fn changed_inputs(folder: &Path, recorded: &[InputRecord]) -> Result<Vec<String>, RecordError> {
    let present = inputs(folder)?;
    let changed = recorded.iter().filter(|input| !present.contains(input));
    Ok(changed.map(|input| input.path.clone()).collect())
}

/// The SHA-256 of a file, in hexadecimal digits.
///
/// # Errors
/// The system's, or that it is not a regular file.
pub(crate) fn sha256(path: &Path) -> io::Result<String> {
    let mut file = open_file(path)?;
    let mut hash = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer)? {
            0 => break,
            length => hash.update(&buffer[..length]),
        }
    }
    let digits = hash.finalize();
    Ok(digits.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_that_of_the_standard() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a");
        std::fs::write(&path, "abc").expect("it is written");
        // FIPS 180-2, appendix B.1.
        let wanted = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(&path).expect("it is there"), wanted);
    }

    #[test]
    fn the_program_knows_what_it_is() {
        let build = Build::present();
        assert_eq!(build.version, env!("CARGO_PKG_VERSION"));
        let compiler = build.compiler.expect("a compiler has built it");
        assert!(compiler.starts_with("rustc "), "{compiler}");
        assert!(build.target.starts_with(std::env::consts::ARCH));
        if let Some(commit) = build.commit {
            assert_eq!(commit.len(), 40, "{commit}");
        }
    }
}
