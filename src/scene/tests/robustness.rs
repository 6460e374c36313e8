//! No text makes the reader panic, and every error can be printed.

use proptest::prelude::*;

use super::read_with;
use crate::scene::{preset, preset_names};

const FILES: [(&str, &str); 1] = [("k.txt", "1\n2 # three\n")];

/// Reads, prints what comes of it; a scene that is read must be written and read again.
fn exercise(text: &str, overrides: &[&str]) {
    match read_with(text, overrides, &FILES) {
        Err(error) => assert!(error.to_string().contains('^')),
        Ok(scene) => {
            let written = scene.to_toml();
            let again = read_with(&written, &[], &FILES).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(again, scene, "{written}");
        }
    }
}

/// One change of a text: at a place (a fraction of its length), so many characters give way to
/// some others.
fn change() -> impl Strategy<Value = (f64, usize, String)> {
    let inserted = prop_oneof![
        "[\\PC\n]{0,4}",
        "[-0-9.e=\\[\\]{}\"',# \n]{0,4}",
        Just("inf".to_owned()),
        Just("{ file = 'k.txt' }".to_owned()),
        Just("[[vesicle.parts]]\n".to_owned()),
        Just("shape = 'random'\n".to_owned()),
    ];
    (0.0..1.0, 0_usize..6, inserted)
}

fn mutated(text: &str, changes: &[(f64, usize, String)]) -> String {
    let mut characters: Vec<char> = text.chars().collect();
    for (place, removed, inserted) in changes {
        let start = (place * characters.len() as f64) as usize;
        let end = (start + removed).min(characters.len());
        characters.splice(start..end, inserted.chars());
    }
    characters.into_iter().collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn any_text(text in any::<String>(), bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        exercise(&text, &[]);
        exercise(&String::from_utf8_lossy(&bytes), &[]);
    }

    #[test]
    fn presets_with_a_few_changes(
        preset_index in 0_usize..6,
        changes in proptest::collection::vec(change(), 1..4),
    ) {
        let name = preset_names().nth(preset_index).expect("six presets");
        exercise(&mutated(preset(name).expect(name), &changes), &[]);
    }

    #[test]
    fn any_override(
        text in any::<String>(),
        key in "(mesh|vesicle|area|nematic|x)(\\.(cells|shape|parts|initial|target|y)){0,2}",
        value in "[-0-9.e=\\[\\]{}\"',# \na-z]{0,12}",
    ) {
        exercise("", &[&text]);
        exercise("", &[&format!("{key}={value}")]);
    }
}

#[test]
fn nesting_is_bounded() {
    for (open, close) in [("[", "]"), ("{ a = ", "}")] {
        let deep = format!("a = {}1{}", open.repeat(100_000), close.repeat(100_000));
        exercise(&deep, &[]);
        exercise("", &[&deep]);
    }
    exercise(&format!("{}a = 1", "a.".repeat(100_000)), &[]);
    exercise(&format!("[{}a]", "a.".repeat(100_000)), &[]);
}
