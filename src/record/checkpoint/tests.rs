use super::*;
use crate::record::scene_file::{identity, tests::scene};
use crate::simulation::Simulation;
use proptest::prelude::*;
use std::fs;
use std::sync::LazyLock;

fn content() -> Content {
    let scene = scene("[nematic]\n[anchoring]\n");
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.advance().unwrap();
    let mut content = Content {
        scene: identity(&scene),
        every: 3,
        written: vec![(0.0, "step-0000000.vtu".into())],
        ..Content::default()
    };
    simulation.save(&mut content.simulation);
    content
}

fn bytes_of(content: &Content) -> Vec<u8> {
    let mut bytes = vec![7; 3];
    encode(RUN, content, &mut bytes).unwrap();
    bytes
}

static BYTES: LazyLock<Vec<u8>> = LazyLock::new(|| bytes_of(&content()));

#[test]
fn what_is_read_back_is_what_was_written() {
    let read = decode::<Content>(RUN, &BYTES).unwrap();
    assert_eq!(bytes_of(&read), *BYTES);
    assert_eq!((read.simulation.step(), read.every), (1, 3));
}

#[test]
fn every_kind_of_damage_has_its_name() {
    let changed = |place: usize, value: u8| {
        let mut bytes = BYTES.clone();
        bytes[place] ^= value;
        decode::<Content>(RUN, &bytes).unwrap_err()
    };
    assert!(matches!(changed(0, 1), Problem::NotACheckpoint));
    assert!(matches!(changed(8, 1), Problem::Checksum));
    assert!(matches!(changed(19, 0x40), Problem::CutShort { .. }));
    assert!(matches!(changed(BYTES.len() / 2, 4), Problem::Checksum));
    assert!(matches!(
        decode::<Content>(RUN, b""),
        Err(Problem::NotACheckpoint)
    ));
    let short = &BYTES[..BYTES.len() - 1];
    assert!(matches!(
        decode::<Content>(RUN, short),
        Err(Problem::CutShort { .. })
    ));

    // A whole file of the next version.
    let mut next = BYTES[..BYTES.len() - CHECKSUM].to_vec();
    next[8] = VERSION as u8 + 1;
    let checksum = crc32fast::hash(&next);
    next.extend_from_slice(&checksum.to_le_bytes());
    let version = decode::<Content>(RUN, &next).unwrap_err();
    assert!(matches!(version, Problem::Version { version } if version == VERSION + 1));
}

#[test]
fn two_generations_are_kept_and_a_damaged_one_takes_no_place() {
    let folder = tempfile::tempdir().unwrap();
    let [newest, older] = Keeper::names().map(|name| folder.path().join(name));
    assert!(matches!(
        Keeper::read::<Content>(RUN, &newest),
        Err(Problem::Missing)
    ));
    let mut keeper = Keeper::of_run(folder.path(), true);
    let mut content = Content::default();
    for every in 1..=3 {
        content.every = every;
        keeper.write(&content).unwrap();
    }
    let every = |path| Keeper::read::<Content>(RUN, path).unwrap().every;
    assert_eq!((every(&newest), every(&older)), (3, 2));

    fs::write(&newest, "damaged").unwrap();
    let mut keeper = Keeper::of_run(folder.path(), false);
    content.every = 4;
    keeper.write(&content).unwrap();
    assert_eq!((every(&newest), every(&older)), (4, 2));
    content.every = 5;
    keeper.write(&content).unwrap();
    assert_eq!((every(&newest), every(&older)), (5, 4));

    fs::remove_file(&newest).unwrap();
    fs::create_dir(&newest).unwrap();
    assert!(matches!(
        Keeper::read::<Content>(RUN, &newest),
        Err(Problem::NotACheckpoint)
    ));
}

/// Bytes with a right header and a right checksum around any content: what no accident makes, but what
/// the decoder must bear all the same.
fn sealed(content: &[u8]) -> Vec<u8> {
    let mut bytes = RUN.to_vec();
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&(content.len() as u64).to_le_bytes());
    bytes.extend_from_slice(content);
    let checksum = crc32fast::hash(&bytes);
    bytes.extend_from_slice(&checksum.to_le_bytes());
    bytes
}

/// Decodes it, and if that succeeds restores it into a run.
fn survive(bytes: &[u8]) -> bool {
    let Ok(content) = decode::<Content>(RUN, bytes) else {
        return false;
    };
    let mut simulation = Simulation::new(&scene("[nematic]\n[anchoring]\n")).unwrap();
    if simulation.restore(&content.simulation).is_ok() {
        // Whatever the numbers were: an error or a step, no panic.
        let _ = simulation.advance();
    }
    true
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn flipped_bits_are_seen(place in 0..BYTES.len() * 8) {
        let mut bytes = BYTES.clone();
        bytes[place / 8] ^= 1 << (place % 8);
        prop_assert!(decode::<Content>(RUN, &bytes).is_err());
    }

    #[test]
    fn a_cut_is_seen(length in 0..BYTES.len()) {
        prop_assert!(decode::<Content>(RUN, &BYTES[..length]).is_err());
    }

    #[test]
    fn any_bytes_are_an_error(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(decode::<Content>(RUN, &bytes).is_err());
        survive(&sealed(&bytes));
    }

    #[test]
    fn a_wrong_content_with_a_right_checksum_does_no_harm(
        changes in prop::collection::vec((0..BYTES.len() - HEADER - CHECKSUM, any::<u8>()), 1..4),
    ) {
        let mut content = BYTES[HEADER..BYTES.len() - CHECKSUM].to_vec();
        for (place, value) in changes {
            content[place] = value;
        }
        survive(&sealed(&content));
    }
}
