//! Ten minutes of a restless person.

use super::pty::{LIMIT, Pty, resident, threads};
use super::{SMALL, VESICA, folder};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::time::{Duration, Instant};

/// Keys that lead nowhere from where they could not be left by Escape, and what follows them. That `i` makes
/// another run of what it suggests is left out: each is finer than the one before, and stays. (Answered by
/// Escape, with `y` of another question within 40 ms, it would be Alt-r and a yes.)
const KEYS: [&str; 41] = [
    "1",
    "2",
    "3",
    "4",
    "5",
    " ",
    " ",
    " ",
    "n",
    "a",
    "a",
    "g",
    "g",
    "\t",
    "\x1b[Z",
    "s",
    "S",
    "d",
    "c",
    "l",
    "v",
    "+",
    "-",
    "?",
    "\x1b",
    "\x1b[D",
    "\x1b[D",
    "\x1b[C",
    "\x1b[H",
    "\x1b[F",
    "\x1b[5~",
    "\x1b[6~",
    "ry",
    "rn",
    "ocircle\r",
    "onowhere\r\x1b",
    "qn",
    "p",
    "w",
    "in",
    "\x1a",
];

/// Switches, resizes, pauses and saves at random, seeded. The app must not panic, its memory must
/// not grow beyond what its past may have, and the terminal must be intact in the end. For ten
/// minutes, with any other seed and length:
///
/// ```text
/// VESICA_SOAK_SECONDS=600 VESICA_SOAK_SEED=1 \
///     cargo test --release --test app -- --ignored --nocapture soak
/// ```
#[test]
#[ignore = "it takes ten minutes"]
fn soak() {
    let number = |name: &str, usual: u64| {
        std::env::var(name).map_or(usual, |text| text.parse().expect("a whole number"))
    };
    let duration = Duration::from_secs(number("VESICA_SOAK_SECONDS", 600));
    let mut random = ChaCha8Rng::seed_from_u64(number("VESICA_SOAK_SEED", 1));
    let folder = folder();
    // Pictures of 150 kB: the past has its full 64 MB within a minute.
    let scene = SMALL.replace("cells = 20", "cells = 60");
    std::fs::write(folder.path().join("small.toml"), scene).expect("it can be written");
    let overrides = [
        "--set",
        "mesh.cells=60",
        "--set",
        "membrane.interface_width=0.02",
    ];
    let mut program = vec![VESICA, "case3", "--fps", "30"];
    program.extend(overrides);
    let mut app = Pty::start((120, 40), folder.path(), &program, &[]);
    app.wait_text("running");
    app.type_keys("osmall.toml\r");
    app.wait_text("small");

    let begun = Instant::now();
    let mut memory: Vec<(Duration, u64)> = Vec::new();
    let mut most_runs = 0;
    let mut bytes = 0;
    while begun.elapsed() < duration {
        match random.random_range(0..100) {
            0..=7 => app.resize(random.random_range(1..200), random.random_range(1..60)),
            8..=11 => {
                for _ in 0..20 {
                    app.resize(random.random_range(1..200), random.random_range(1..60));
                }
            }
            12..=14 => app.resize(120, 40),
            15 => drop(std::fs::remove_dir_all(folder.path().join("saved"))),
            16 => {
                let noise: Vec<u8> = (0..20).map(|_| random.random_range(1..127)).collect();
                let noise = String::from_utf8(noise).expect("ASCII");
                // Nothing that ends, stops, edits or makes more runs.
                let harmless = noise.replace(['q', 'e', 'y', 'i', '\x03', '\x1a', '\r'], "");
                app.type_keys(&harmless);
            }
            _ => app.type_keys(KEYS.choose(&mut random).expect("a key")),
        }
        std::thread::sleep(Duration::from_millis(random.random_range(5..150)));
        let exited = app.child.try_wait().expect("a child");
        assert!(
            exited.is_none(),
            "it ended: {exited:?}\n{}",
            app.seen().text()
        );
        let elapsed = begun.elapsed();
        if memory
            .last()
            .is_none_or(|(at, _)| *at + Duration::from_secs(5) < elapsed)
        {
            memory.push((elapsed, resident(app.pid())));
            most_runs = most_runs.max(threads(app.pid(), "vesica run").len());
            bytes += app.seen().bytes.len();
            app.forget_bytes();
        }
    }
    for (at, resident) in &memory {
        println!("{:>4} s  {:>5} MB", at.as_secs(), resident >> 20);
    }
    println!("{bytes} bytes in {duration:?}; at most {most_runs} runs at a time");
    // Of six scenes; some may be ending.
    assert!(most_runs < 12, "{most_runs} runs");
    // Once the past is full memory is flat: the last third is no larger than the middle one.
    let greatest = |part: &[(Duration, u64)]| part.iter().map(|(_, size)| *size).max();
    let third = memory.len() / 3;
    let (middle, last) = (
        greatest(&memory[third..2 * third]),
        greatest(&memory[2 * third..]),
    );
    if duration >= Duration::from_secs(600) {
        assert!(
            last <= middle.map(|size| size + (size >> 4)),
            "it grows: {middle:?}, {last:?}"
        );
    }

    app.resize(120, 40);
    // Whatever lies over the screen goes, and then the app.
    app.type_keys("\x1b");
    std::thread::sleep(Duration::from_millis(200));
    app.type_keys("\x1b");
    std::thread::sleep(Duration::from_millis(200));
    app.type_keys("\x03");
    std::thread::sleep(Duration::from_millis(200));
    if app.child.try_wait().expect("a child").is_none() {
        app.type_keys("y");
    }
    let _ = app.exit_status(LIMIT);
    app.assert_restored(0);
}
