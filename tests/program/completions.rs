//! Completions as a person has them: bash in a terminal, with the script that the program prints, and Tab.

use super::cli::folder_with_scene;
use portable_pty::{CommandBuilder, PtySize, native_pty_system};
use std::io::{Read, Write};
use std::path::Path;
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

/// Waits until the terminal has shown `part`.
fn wait_for(part: &str, output: &Receiver<Vec<u8>>) {
    let begun = Instant::now();
    let mut shown = String::new();
    while !shown.contains(part) {
        let left = Duration::from_secs(60).saturating_sub(begun.elapsed());
        match output.recv_timeout(left) {
            Ok(bytes) => shown += &String::from_utf8_lossy(&bytes),
            Err(_) => panic!("no {part:?} in {shown:?}"),
        }
    }
}

/// For bash `=` ends a word, so a value of `--set` is a word of its own there.
#[cfg(target_os = "linux")]
#[test]
fn bash_completes_commands_scenes_keys_and_values() {
    if !Path::new("/bin/bash").exists() {
        println!("completions in bash are not tested: there is no /bin/bash");
        return;
    }
    let folder = folder_with_scene();
    let size = PtySize {
        rows: 24,
        cols: 200,
        ..PtySize::default()
    };
    let pair = native_pty_system().openpty(size).expect("a terminal");
    let mut bash = CommandBuilder::new("/bin/bash");
    bash.args(["--norc", "--noprofile", "-i"]);
    bash.cwd(folder.path());
    let program = Path::new(env!("CARGO_BIN_EXE_vesica")).parent();
    let path = std::env::var("PATH").unwrap_or_default();
    bash.env(
        "PATH",
        format!("{}:{path}", program.expect("a folder").display()),
    );
    for (name, value) in [("PS1", "$ "), ("TERM", "dumb"), ("INPUTRC", "/dev/null")] {
        bash.env(name, value);
    }
    let mut child = pair.slave.spawn_command(bash).expect("bash starts");
    drop(pair.slave);
    let mut reader = pair.master.try_clone_reader().expect("its output");
    let mut writer = pair.master.take_writer().expect("its input");
    let (sender, output) = mpsc::channel();
    thread::spawn(move || {
        let mut bytes = [0; 4096];
        while let Ok(count @ 1..) = reader.read(&mut bytes) {
            if sender.send(bytes[..count].to_vec()).is_err() {
                break;
            }
        }
    });
    let mut type_in = |text: &str| writer.write_all(text.as_bytes()).expect("it is typed");
    type_in("source <(vesica completions bash); complete -p vesica\n");
    wait_for("-F _vesica vesica", &output);
    for (typed, completed) in [
        ("vesica veri\t", "vesica verify "),
        ("vesica run case3-q\t", "vesica run case3-quick "),
        ("vesica run sma\t", "vesica run small.toml "),
        ("vesica sweep stat\t", "vesica sweep status "),
        (
            "vesica run case3 --set anchoring.k\t",
            "--set anchoring.kind=",
        ),
        (
            "vesica run case3 --set anchoring.kind=p\t",
            "--set anchoring.kind=parallel ",
        ),
        (
            "vesica run case3 --set=anchoring.kind=hom\t",
            "--set=anchoring.kind=homeotropic ",
        ),
    ] {
        type_in(typed);
        wait_for(completed, &output);
        // Ctrl-U: the line is wiped.
        type_in("\u{15}");
    }
    type_in("exit\n");
    child.wait().expect("it ends");
}
