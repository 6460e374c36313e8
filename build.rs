//! Tells the program from which source, by which compiler and for which processors it is built; `run.json` has it of
//! every run.
//!
//! Git is asked where it is there. Without it the commit is that of the package (`.cargo_vcs_info.json`), or the one that
//! the variable VESICA_COMMIT names, or unknown.

use std::env;
use std::fs;
use std::path::Path;
use std::process::Command;

/// What the program is made of; files of documentation and tests do not count.
const SOURCES: [&str; 6] = [
    "src",
    "presets",
    "build.rs",
    "Cargo.toml",
    "Cargo.lock",
    ".cargo",
];

fn main() {
    for source in SOURCES {
        if Path::new(source).exists() {
            println!("cargo:rerun-if-changed={source}");
        }
    }
    println!("cargo:rerun-if-env-changed=VESICA_COMMIT");
    let (commit, changed) = commit();
    let compiler = env::var("RUSTC").ok();
    let compiler = compiler.and_then(|compiler| output(&compiler, &["--version"]));
    let cargo = |name| env::var(name).unwrap_or_default();
    for (name, value) in [
        ("COMMIT", commit),
        ("CHANGED", changed),
        ("COMPILER", compiler.unwrap_or_default()),
        ("TARGET", cargo("TARGET")),
        ("FEATURES", cargo("CARGO_CFG_TARGET_FEATURE")),
        ("PROFILE", cargo("PROFILE")),
    ] {
        println!("cargo:rustc-env=VESICA_BUILD_{name}={value}");
    }
}

/// The commit of the source, and whether the source was changed since ("true", "false"); empty where it is unknown.
fn commit() -> (String, String) {
    if let Ok(commit) = env::var("VESICA_COMMIT")
        && !commit.is_empty()
    {
        return (commit, "false".to_owned());
    }
    // In another project's repository the commit would be that project's.
    let is_own = Path::new(".git").exists();
    if is_own && let Some(commit) = output("git", &["rev-parse", "HEAD"]) {
        let mut status = vec!["status", "--porcelain", "--"];
        status.extend(SOURCES);
        let changed = output("git", &status).map(|lines| (!lines.is_empty()).to_string());
        return (commit, changed.unwrap_or_default());
    }
    let packaged = fs::read_to_string(".cargo_vcs_info.json").unwrap_or_default();
    let hash = packaged
        .split('"')
        .find(|part| part.len() == 40 && part.bytes().all(|byte| byte.is_ascii_hexdigit()));
    let changed = packaged.contains("\"dirty\": true");
    hash.map(|hash| (hash.to_owned(), changed.to_string()))
        .unwrap_or_default()
}

/// What a program prints, if it is there and succeeds.
fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
