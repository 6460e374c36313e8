//! Files that are read whole, within bounds: whatever a name stands for, nobody waits for ever, and
//! memory has an end.

use std::fs::{self, File};
use std::io::{self, IsTerminal, Read};
use std::path::Path;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

/// How long a pipe may have nobody who writes.
const PATIENCE: Duration = Duration::from_secs(5);

/// The text of a file that a person names: see [`read_bytes`].
///
/// # Errors
/// Those of [`read_bytes`], or that it is not text.
pub(crate) fn read_text(path: &Path, limit: u64) -> io::Result<String> {
    text(read_bytes(path, limit)?)
}

/// The text of a file of a run's folder: see [`read_file`].
///
/// # Errors
/// Those of [`read_file`], or that it is not text.
pub(crate) fn read_file_text(path: &Path, limit: u64) -> io::Result<String> {
    text(read_file(path, limit)?)
}

/// As [`read_file_text`], but what is not a letter becomes �.
///
/// # Errors
/// Those of [`read_file`].
pub(super) fn read_file_lossy(path: &Path, limit: u64) -> io::Result<String> {
    let bytes = read_file(path, limit)?;
    Ok(match utf_16_unit(&bytes) {
        Some(unit) => {
            let units = bytes.as_chunks().0.iter().map(|pair| unit(*pair));
            let letters = char::decode_utf16(units);
            let letter = |letter: Result<char, _>| letter.unwrap_or(char::REPLACEMENT_CHARACTER);
            letters.map(letter).collect()
        }
        None => match String::from_utf8(bytes) {
            Ok(text) => text,
            Err(wrong) => String::from_utf8_lossy(wrong.as_bytes()).into_owned(),
        },
    })
}

fn text(bytes: Vec<u8>) -> io::Result<String> {
    let text = match utf_16_unit(&bytes) {
        Some(unit) => utf_16(&bytes, unit)
            .ok_or("it is no text in UTF-8, nor in UTF-16 with a byte-order mark".to_owned()),
        None => String::from_utf8(bytes).map_err(|wrong| {
            let before = &wrong.as_bytes()[..wrong.utf8_error().valid_up_to()];
            let line_start = before
                .iter()
                .rposition(|byte| *byte == b'\n')
                .map_or(0, |at| at + 1);
            let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
            let column = 1 + String::from_utf8_lossy(&before[line_start..])
                .chars()
                .count();
            format!(
                "it is no text in UTF-8 (at {line}:{column}), nor in UTF-16 with a byte-order mark"
            )
        }),
    };
    text.map_err(|wrong| io::Error::new(io::ErrorKind::InvalidData, wrong))
}

/// How the bytes of a unit make it, where a byte-order mark says that the text is in UTF-16, as some
/// spreadsheets save it.
fn utf_16_unit(bytes: &[u8]) -> Option<fn([u8; 2]) -> u16> {
    match bytes.first_chunk() {
        Some([0xff, 0xfe]) => Some(u16::from_le_bytes),
        Some([0xfe, 0xff]) => Some(u16::from_be_bytes),
        _ => None,
    }
}

fn utf_16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Option<String> {
    let (pairs, []) = bytes.as_chunks() else {
        return None;
    };
    let units = pairs.iter().map(|pair| unit(*pair));
    char::decode_utf16(units).collect::<Result<_, _>>().ok()
}

/// Opens a file for reading that must be a regular one: a pipe would wait for a writer, and some devices
/// have no end.
///
/// # Errors
/// What the system says, or that it is not a regular file.
pub(super) fn open_file(path: &Path) -> io::Result<File> {
    let metadata = fs::metadata(path)?;
    if metadata.is_dir() {
        return Err(io::Error::new(
            io::ErrorKind::IsADirectory,
            "it is a folder",
        ));
    }
    if !metadata.is_file() {
        let message = "it is a pipe, a socket or a device, not a file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    File::open(path)
}

/// The bytes of a regular file, at most `limit` of them.
///
/// # Errors
/// Those of [`open_file`], or that it is too large.
pub(super) fn read_file(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    read_all(open_file(path)?, limit)
}

/// The bytes of a file, at most `limit` of them. A pipe will do where somebody writes into it, as what
/// the shell makes of `<(…)`; a device will not.
///
/// # Errors
/// What the system says, or that it is too large, a device, or a pipe without a writer.
pub(crate) fn read_bytes(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let metadata = fs::metadata(path)?;
    if metadata.is_dir() || metadata.is_file() {
        return read_file(path, limit);
    }
    if is_pipe(&metadata) {
        return read_all(open_pipe(path)?, limit);
    }
    let file = File::open(path)?;
    if !file.is_terminal() {
        let message = "it is a device, not a file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    read_all(file, limit)
}

fn read_all(file: File, limit: u64) -> io::Result<Vec<u8>> {
    if file.metadata()?.len() > limit {
        return Err(too_large(limit));
    }
    let mut bytes = Vec::new();
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(too_large(limit));
    }
    Ok(bytes)
}

fn too_large(limit: u64) -> io::Error {
    let message = format!("it is larger than {} MB", limit >> 20);
    io::Error::new(io::ErrorKind::FileTooLarge, message)
}

#[cfg(unix)]
fn is_pipe(metadata: &fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    metadata.file_type().is_fifo()
}

#[cfg(not(unix))]
fn is_pipe(_metadata: &fs::Metadata) -> bool {
    false
}

/// Opens a pipe. That waits until somebody opens it for writing, so it is done beside: a thread that
/// waits in vain ends with the process.
fn open_pipe(path: &Path) -> io::Result<File> {
    let (sender, opened) = mpsc::channel();
    let path = path.to_owned();
    thread::Builder::new().spawn(move || {
        // The receiver may have given up waiting.
        let _ = sender.send(File::open(path));
    })?;
    opened.recv_timeout(PATIENCE).unwrap_or_else(|_| {
        let seconds = PATIENCE.as_secs();
        let message = format!("it is a pipe, and for {seconds} s nobody has written into it");
        Err(io::Error::new(io::ErrorKind::TimedOut, message))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_within_the_limit_is_read_and_no_other() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        fs::write(&path, "four").expect("it is written");
        assert_eq!(read_text(&path, 4).expect("four bytes"), "four");
        let error = read_text(&path, 3).expect_err("too large");
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
        for text in [b"\xff\xfef\0\xb1\x03", b"\xfe\xff\0f\x03\xb1"] {
            fs::write(&path, text).expect("it is written");
            assert_eq!(read_text(&path, 9).expect("text"), "\u{feff}fα");
        }
        for text in [&b"\xff\xfef"[..], b"\xff\xfe\0\xd8", b"\xff"] {
            fs::write(&path, text).expect("it is written");
            let error = read_text(&path, 9).expect_err("no text");
            assert_eq!(error.kind(), io::ErrorKind::InvalidData);
        }
        assert_eq!(read_file_lossy(&path, 9).expect("bytes"), "\u{fffd}");
        fs::write(&path, b"a\n\xce\xb1b\xff").expect("it is written");
        let told = read_text(&path, 9).expect_err("no text").to_string();
        assert!(told.contains("(at 2:3)"), "{told}");
        fs::write(&path, b"\xff\xfef\0\0\xd8x\0\0").expect("it is written");
        assert_eq!(
            read_file_lossy(&path, 9).expect("bytes"),
            "\u{feff}f\u{fffd}x"
        );
        let error = read_text(folder.path(), 9).expect_err("a folder");
        assert_eq!(error.kind(), io::ErrorKind::IsADirectory);
        let error = read_text(&path.join("b"), 9).expect_err("below a file");
        assert_eq!(error.kind(), io::ErrorKind::NotADirectory);
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_refused_and_a_pipe_needs_a_writer() {
        let error = read_text(Path::new("/dev/zero"), 9).expect_err("no end");
        assert!(error.to_string().contains("a device"), "{error}");
        let folder = tempfile::tempdir().expect("a folder");
        let pipe = |name: &str| {
            let path = folder.path().join(name);
            let made = std::process::Command::new("mkfifo").arg(&path).status();
            assert!(made.expect("mkfifo").success());
            path
        };
        let error = read_text(&pipe("one"), 9).expect_err("nobody writes");
        assert_eq!(error.kind(), io::ErrorKind::TimedOut, "{error}");
        // Of a run's folder not even one that somebody writes into.
        let begun = std::time::Instant::now();
        let error = read_file_text(&pipe("third"), 9).expect_err("no file");
        assert_eq!(error.kind(), io::ErrorKind::InvalidInput, "{error}");
        assert!(begun.elapsed() < PATIENCE);
        let path = pipe("other");
        let written = {
            let path = path.clone();
            thread::spawn(move || fs::write(path, "told"))
        };
        assert_eq!(read_text(&path, 9).expect("a writer"), "told");
        written.join().expect("a thread").expect("it is written");
    }
}
