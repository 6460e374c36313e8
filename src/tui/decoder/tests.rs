//! What terminals send, whole and in pieces.

use super::*;
use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use proptest::prelude::*;

/// What was reported of some bytes.
#[derive(Debug, Clone, PartialEq)]
enum Reported {
    Key(KeyEvent),
    Text(String),
    Remark,
}

fn report(decode: impl FnOnce(&mut dyn FnMut(AppEvent))) -> Vec<Reported> {
    let mut reported = Vec::new();
    decode(&mut |incoming| {
        reported.push(match incoming {
            AppEvent::Message(Message::Key(key)) => Reported::Key(key),
            AppEvent::Message(Message::Remark(_)) => Reported::Remark,
            AppEvent::Pasted(text) => Reported::Text(text),
            other => panic!("{other:?}"),
        });
    });
    reported
}

/// What is reported of pieces, after each of which a time passes that makes Escape a key.
fn of_pieces<'a>(pieces: impl IntoIterator<Item = &'a [u8]>) -> Vec<Reported> {
    let mut decoder = Decoder::default();
    report(|sink| {
        for piece in pieces {
            decoder.take(piece, sink);
            if decoder.patience() == Some(LONE) {
                decoder.lose_patience(sink);
            }
        }
    })
}

fn code(code: KeyCode) -> Reported {
    Reported::Key(code.into())
}

fn letter(letter: char) -> Reported {
    code(KeyCode::Char(letter))
}

fn codes(bytes: &[u8]) -> Vec<KeyCode> {
    let mut decoder = Decoder::default();
    let reported = report(|sink| decoder.take(bytes, sink));
    let code = |reported| match reported {
        Reported::Key(key) => key.code,
        other => panic!("{other:?}"),
    };
    reported.into_iter().map(code).collect()
}

#[test]
fn keys_of_all_kinds_are_known() {
    use KeyCode::{
        BackTab, Backspace, Char, Delete, End, Enter, F, Home, Left, PageUp, Right, Tab,
    };
    assert_eq!(codes(b"a "), [Char('a'), Char(' ')]);
    assert_eq!(codes("Gφ€😀".as_bytes()), ['G', 'φ', '€', '😀'].map(Char));
    assert_eq!(codes(b"\x1b[D\x1bOC\x1b[1;2D"), [Left, Right, Left]);
    assert_eq!(codes(b"\x1b[H\x1b[F\x1b[4~"), [Home, End, End]);
    assert_eq!(codes(b"\x1b[3~\x1b[5;5~"), [Delete, PageUp]);
    assert_eq!(codes(b"\x1bOP\x1b[15~\x1b[1;2Q"), [F(1), F(5), F(2)]);
    // Of terminals that are set to eight bits.
    assert_eq!(codes(b"\x9bD\x8fC"), [Left, Right]);
    assert_eq!(codes(b"\r\t\x7f\x1b[Z"), [Enter, Tab, Backspace, BackTab]);
    // The kitty protocol: a key that is pressed, and one that is let go.
    assert_eq!(codes(b"\x1b[97;1u\x1b[97;1:3u"), [Char('a')]);
    let mut decoder = Decoder::default();
    let with = |modifiers, letter| Reported::Key(KeyEvent::new(Char(letter), modifiers));
    assert_eq!(
        report(|sink| decoder.take("\x1a\x03\x1br\x1bé".as_bytes(), sink)),
        [
            with(KeyModifiers::CONTROL, 'z'),
            with(KeyModifiers::CONTROL, 'c'),
            with(KeyModifiers::ALT, 'r'),
            with(KeyModifiers::ALT, 'é'),
        ]
    );
}

#[test]
fn a_key_may_come_in_pieces_and_escape_alone_is_one() {
    let mut decoder = Decoder::default();
    for piece in [&b"\x1b"[..], b"[", b"1;5"] {
        assert_eq!(report(|sink| decoder.take(piece, sink)), []);
    }
    let right = KeyEvent::new(KeyCode::Right, KeyModifiers::CONTROL);
    assert_eq!(
        report(|sink| decoder.take(b"C", sink)),
        [Reported::Key(right)]
    );
    assert_eq!(decoder.patience(), None);

    assert_eq!(report(|sink| decoder.take(b"\x1b", sink)), []);
    assert_eq!(decoder.patience(), Some(LONE));
    let escape = [code(KeyCode::Esc)];
    assert_eq!(report(|sink| decoder.lose_patience(sink)), escape);
    // For a while it may be a sequence after all, and then no more.
    assert_eq!(decoder.patience(), Some(LATE));
    assert_eq!(report(|sink| decoder.lose_patience(sink)), []);
    assert_eq!(decoder.patience(), None);
    let bracket = [letter('[')];
    assert_eq!(report(|sink| decoder.take(b"[", sink)), bracket);

    assert_eq!(codes(b"\x1b\x1b[D"), [KeyCode::Esc, KeyCode::Left]);
    assert_eq!(
        of_pieces([&b"\x1b"[..], b"y"]),
        [code(KeyCode::Esc), letter('y')]
    );
}

/// What terminals send by themselves.
const ANSWERS: [&[u8]; 62] = [
    // Colours, the clipboard, a title: OSC, ended by ST, BEL and the ST of eight bits.
    b"\x1b]11;rgb:1e1e/1e1e/2e2e\x1b\\",
    b"\x1b]11;rgb:aaaa/aaaa/aaaa\x07",
    b"\x1b]11;rgb:1234/1234/1234\x9c",
    b"\x9d11;rgb:1234/1234/1234\x9c",
    b"\x1b]4;1;rgb:cdcd/0000/0000\x1b\\",
    b"\x1b]52;c;cXllMTIzNA==\x1b\\",
    b"\x1b]lnext q\x1b\\",
    // A check mark, which has the byte of ST in it.
    "\x1b]l✜ qe\x1b\\".as_bytes(),
    // Names and settings: DCS.
    b"\x1bP>|XTerm(370)\x1b\\",
    b"\x1bP1+r544e=787465726d\x1b\\",
    b"\x1bP!|00000000\x1b\\",
    b"\x1bP1$r0;1 q\x1b\\",
    b"\x90>|foot(1.2.3)\x9c",
    // Of DCS and the others BEL is a part.
    b"\x1bPq12\x0734e\x1b\\",
    // Graphics: APC. PM and SOS have no use.
    b"\x1b_Gi=31;OK\x1b\\",
    b"\x9fGi=31;ENOENT:q\x9c",
    b"\x1b^private q\x1b\\",
    b"\x1bXany string 1234 \t q\x1b\\",
    b"\x98any string\x9c",
    // Device attributes, status, modes, the cursor's place, sizes.
    b"\x1b[?62;1;2;4c",
    b"\x1b[>41;320;0c",
    b"\x1b[=1;2c",
    b"\x9b>1;4000;12c",
    b"\x1b[0n",
    b"\x1b[?997;1n",
    b"\x1b[?2026;2$y",
    b"\x1b[24;80R",
    b"\x1b[?24;80;1R",
    b"\x1b[8;24;80t",
    b"\x1b[?1u",
    b"\x1b[?1;0;256S",
    // The mouse, and the focus.
    b"\x1b[<0;10;10M",
    b"\x1b[<35;1;2m",
    b"\x1b[M qe",
    b"\x1b[I",
    // Character sets and the like: an intermediate before the last byte.
    b"\x1b(2",
    b"\x1b#2",
    b"\x1b%2",
    b"\x1b$(q",
    // A character of another set.
    b"\x1bN2",
    b"\x8e2",
    "\x1bN✜".as_bytes(),
    b"\x1bOx",
    b"\x1bO2\x07x",
    // Controls and bytes above ASCII in the midst; ESC and a byte that begins nothing.
    b"\x1b(\n\xff2",
    b"\x1bN\t\x802",
    b"\x1b[1\x012C",
    b"\x1b[1;\xff2C",
    b"\x1b[\x7f2C",
    "\x1b[1é2C".as_bytes(),
    "\x1b[1✜2C".as_bytes(),
    "\x1b[Û2C".as_bytes(),
    b"\x1b[1\x84\x9c2C",
    b"\x1bP2\x1b22\x1b\\",
    b"\x1bP2\x1b\x1b2\x1b(2\x1b\x1b\\",
    b"\x1b]2;\x03q\x1bq2\x07",
    b"\x1b_\xc3\x1b\x9c",
    b"\x1bXq\x032\x1b\\",
    b"\x1b[1 q",
    b"\x1b[1!2~",
    b"\x1b[2\x00 ~",
    // Longer than any key.
    b"\x1b[1;1111111111111111111111111111111111111111111111111111111111111111111111111111A",
];

/// The intermediates that are keys of the app: they are not part of a sequence whose ESC came long before.
const KEYS_AFTER_ESCAPE: [&[u8]; 3] = [b"\x1b 2", b"\x1b+2", b"\x1b-q"];

/// What is reported of an answer where it is cut, and of a key behind it.
fn assert_no_key(answer: &[u8], cuts: &[usize], expected: &[Reported]) {
    let mut pieces = Vec::new();
    let mut from = 0;
    for &cut in cuts.iter().chain([&answer.len()]) {
        pieces.push(&answer[from..cut]);
        from = cut;
    }
    pieces.push(b"z");
    let mut right = Vec::new();
    // Only time distinguishes an Escape that is cut off from the key.
    if cuts.contains(&1) && answer[0] == ESC {
        right.push(code(KeyCode::Esc));
    }
    right.extend_from_slice(expected);
    right.push(letter('z'));
    let words = String::from_utf8_lossy(answer);
    assert_eq!(of_pieces(pieces), right, "{words:?} cut at {cuts:?}");
}

#[test]
fn no_byte_of_an_answer_is_a_key_wherever_it_is_cut() {
    for answer in ANSWERS {
        assert_no_key(answer, &[], &[]);
        for first in 1..answer.len() {
            assert_no_key(answer, &[first], &[]);
            for second in first + 1..answer.len() {
                assert_no_key(answer, &[first, second], &[]);
            }
        }
        let everywhere: Vec<usize> = (1..answer.len()).collect();
        assert_no_key(answer, &everywhere, &[]);
    }
}

#[test]
fn an_intermediate_that_is_a_key_is_one_some_time_after_escape() {
    for sequence in KEYS_AFTER_ESCAPE {
        assert_no_key(sequence, &[], &[]);
        assert_no_key(sequence, &[2], &[]);
        let keys = [sequence[1], sequence[2]].map(|byte| letter(char::from(byte)));
        assert_no_key(sequence, &[1], &keys);
    }
}

#[test]
fn no_byte_of_a_paste_is_a_key_wherever_it_is_cut() {
    let pastes: [&[u8]; 4] = [
        b"\x1b[200~q\ny\x1b[201~",
        b"\x9b200~\x03\x1b[20\x1b\x1b[D\x1b]11;\x07\x1b[201~",
        b"\x1b[200~\x1b[200~2\x1b[201~",
        "\x1b[200~φ✜\u{9c}\x1b[201~".as_bytes(),
    ];
    let texts = [
        "q\ny",
        "\x03\x1b[20\x1b\x1b[D\x1b]11;\x07",
        "\x1b[200~2",
        "φ✜\u{9c}",
    ];
    for (paste, text) in pastes.into_iter().zip(texts) {
        let expected = [Reported::Text(text.to_owned())];
        assert_no_key(paste, &[], &expected);
        for first in 1..paste.len() {
            assert_no_key(paste, &[first], &expected);
            for second in first + 1..paste.len() {
                assert_no_key(paste, &[first, second], &expected);
            }
        }
        let everywhere: Vec<usize> = (1..paste.len()).collect();
        assert_no_key(paste, &everywhere, &expected);
    }
}

#[test]
fn a_paste_of_any_length_is_swallowed_and_its_begin_kept() {
    let mut paste = PASTE_BEGIN.to_vec();
    paste.extend(std::iter::repeat_n(b'2', 3 << 20));
    paste.extend_from_slice(PASTE_END);
    paste.push(b'z');
    let text = Reported::Text("2".repeat(LONGEST_TEXT));
    assert_eq!(of_pieces([&paste[..]]), [text, letter('z')]);
}

#[test]
fn what_does_not_end_is_reported_once_and_can_be_left() {
    let begins: [&[u8]; 6] = [
        b"\x1b]11;",
        b"\x1bP",
        b"\x1b_q",
        b"\x1b^",
        b"\x1bX",
        b"\x9d",
    ];
    for begin in begins {
        for way_out in [&b"\x03"[..], b"\x18", b"\x1a", b"\x1bq"] {
            let mut decoder = Decoder::default();
            // Before a silence Ctrl-C may be a part of it, and so may ESC.
            let begun = [begin, b"\x03\x1bq2\x1b"].concat();
            assert_eq!(report(|sink| decoder.take(&begun, sink)), []);
            assert_eq!(decoder.patience(), Some(QUIET));
            let remark = [Reported::Remark];
            assert_eq!(report(|sink| decoder.lose_patience(sink)), remark);
            assert_eq!(decoder.patience(), None);
            assert_eq!(report(|sink| decoder.take(b"qqq", sink)), []);
            assert_eq!(report(|sink| decoder.take(way_out, sink)), []);
            let key = report(|sink| decoder.take(b"q", sink));
            assert_eq!(key, [letter('q')], "{begin:?} {way_out:?}");
        }
        let mut decoder = Decoder::default();
        let arrow = report(|sink| decoder.take(&[begin, b"\x1b[A"].concat(), sink));
        assert_eq!(arrow, [code(KeyCode::Up)], "{begin:?}");
    }

    let mut decoder = Decoder::default();
    // In the midst of a paste it is text.
    let paste = b"\x1b[200~a\x03q";
    assert_eq!(report(|sink| decoder.take(paste, sink)), []);
    assert_eq!(decoder.patience(), Some(QUIET));
    let remark = [Reported::Remark];
    assert_eq!(report(|sink| decoder.lose_patience(sink)), remark);
    assert_eq!(report(|sink| decoder.take(b"\x03", sink)), []);
    assert_eq!(report(|sink| decoder.take(b"q", sink)), [letter('q')]);
    let begins: [&[u8]; 7] = [
        b"\x1b[",
        b"\x1b[1;2",
        b"\x1b[1\xc3",
        b"\x1bO",
        b"\x1b[M",
        b"\x1b(",
        b"\x1bN",
    ];
    for begin in begins {
        for way_out in [&b"\x03"[..], b"\x18", b"\x1a"] {
            let mut decoder = Decoder::default();
            let _ = report(|sink| decoder.take(&[begin, way_out].concat(), sink));
            assert_eq!(report(|sink| decoder.take(b"q", sink)), [letter('q')]);
        }
    }
}

#[test]
fn nonsense_does_not_hide_what_follows() {
    let nonsense: [&[u8]; 7] = [
        b"\xff\xfe",
        b"\xc3",
        b"\xf0\x9f",
        b"\x80\x85\x9c\xa0\xc0",
        b"\x1b[999;;;\xffx",
        b"\x1bOz",
        b"\x1b[[A",
    ];
    for bytes in nonsense {
        assert_eq!(of_pieces([bytes, b"q"]), [letter('q')], "{bytes:?}");
    }
}

/// A piece of what a terminal may send, and what is reported of it.
fn piece() -> impl Strategy<Value = (Vec<u8>, Vec<Reported>)> {
    let answer = prop::sample::select(&ANSWERS[..]).prop_map(|answer| (answer.to_vec(), vec![]));
    let typed = prop::sample::select(&['q', '2', 'e', ']', '[', 'O', 'P', 'φ', '✜'][..])
        .prop_map(|typed| (typed.to_string().into_bytes(), vec![letter(typed)]));
    let arrow = Just((b"\x1b[A".to_vec(), vec![code(KeyCode::Up)]));
    let text = prop::collection::vec(any::<u8>(), 0..40).prop_map(|text| {
        let text = String::from_utf8_lossy(&text).replace("\x1b[201~", "");
        let paste = format!("\x1b[200~{text}\x1b[201~").into_bytes();
        (paste, vec![Reported::Text(text)])
    });
    prop_oneof![answer, typed, arrow, text]
}

/// A sequence that is damaged, or that no key has: none of its bytes is one. The first is ESC or an introducer
/// of eight bits.
fn no_key() -> impl Strategy<Value = Vec<u8>> {
    let bytes = |allowed: fn(u8) -> bool, count: std::ops::Range<usize>| {
        let allowed: Vec<u8> = (0..=255).filter(|byte| allowed(*byte)).collect();
        prop::collection::vec(prop::sample::select(allowed), count)
    };
    fn is_skipped(byte: u8) -> bool {
        let leaves = matches!(byte, ETX | CAN | SUB | ESC);
        !leaves && !matches!(byte, b' '..=b'~' | 0x80..=0x9f)
    }
    let begin = |seven: &'static [u8], eight: &'static [u8]| {
        prop::sample::select(vec![seven.to_vec(), eight.to_vec()])
    };
    let sequence = (
        begin(b"\x1b[", b"\x9b"),
        bytes(|byte| matches!(byte, b'0'..=b'?') || is_skipped(byte), 0..6),
        bytes(is_skipped, 1..2),
        bytes(|byte| matches!(byte, b'0'..=b'?') || is_skipped(byte), 0..6),
        // Neither the mouse nor the Linux console, which have something behind it, nor a paste.
        bytes(
            |byte| matches!(byte, b'@'..=b'}') && !matches!(byte, b'M' | b'['),
            1..2,
        ),
    )
        .prop_map(|(begin, one, broken, other, end)| [begin, one, broken, other, end].concat());
    let string = (
        prop::sample::select(vec![
            &b"\x1bP"[..],
            b"\x1bX",
            b"\x1b^",
            b"\x1b_",
            b"\x1b]",
            b"\x90",
            b"\x9d",
        ]),
        prop::collection::vec(
            prop_oneof![
                bytes(|byte| !matches!(byte, BEL | CAN | SUB | ESC | ST), 1..4),
                bytes(
                    |byte| introduced(byte).is_none()
                        && !matches!(byte, BEL | CAN | SUB | ESC | ST | b'\\'),
                    1..2
                )
                .prop_map(|byte| [vec![ESC], byte].concat()),
            ],
            0..6,
        ),
    )
        .prop_map(|(begin, body)| [begin, &body.concat(), b"\x1b\\"].concat());
    let intermediate = (
        bytes(
            |byte| matches!(byte, b'!'..=b'*' | b',' | b'.' | b'/'),
            1..2,
        ),
        bytes(|byte| matches!(byte, b' '..=b'/'), 0..3),
        bytes(|byte| matches!(byte, b'0'..=b'~'), 1..2),
    )
        .prop_map(|(first, others, end)| [vec![ESC], first, others, end].concat());
    let shift = (
        begin(b"\x1bN", b"\x8e"),
        any::<char>().prop_filter("no control", |character| !character.is_control()),
    )
        .prop_map(|(begin, character)| [begin, character.to_string().into_bytes()].concat());
    prop_oneof![sequence, string, intermediate, shift]
}

proptest! {
    #[test]
    fn no_byte_of_a_damaged_sequence_is_a_key_wherever_it_is_cut(sequence in no_key()) {
        assert_no_key(&sequence, &[], &[]);
        for first in 1..sequence.len() {
            assert_no_key(&sequence, &[first], &[]);
            for second in first + 1..sequence.len() {
                assert_no_key(&sequence, &[first, second], &[]);
            }
        }
        let everywhere: Vec<usize> = (1..sequence.len()).collect();
        assert_no_key(&sequence, &everywhere, &[]);
    }

    #[test]
    fn in_any_stream_keys_are_what_was_typed(
        pieces in prop::collection::vec(piece(), 0..12),
        cuts in prop::collection::vec(any::<prop::sample::Index>(), 0..6),
    ) {
        let (bytes, reported): (Vec<_>, Vec<_>) = pieces.into_iter().unzip();
        let (bytes, expected) = (bytes.concat(), reported.concat());
        let mut cuts: Vec<usize> = cuts.iter().map(|cut| cut.index(bytes.len() + 1)).collect();
        cuts.sort_unstable();
        let mut decoder = Decoder::default();
        let reported = report(|sink| {
            let mut from = 0;
            for cut in cuts.into_iter().chain([bytes.len()]) {
                decoder.take(&bytes[from..cut], sink);
                from = cut;
            }
        });
        prop_assert_eq!(reported, expected);
    }

    #[test]
    fn any_bytes_and_pauses_can_be_left(
        pieces in prop::collection::vec((prop::collection::vec(any::<u8>(), 0..20), 0_u8..3), 0..8),
    ) {
        let mut decoder = Decoder::default();
        report(|sink| {
            for (piece, pauses) in &pieces {
                decoder.take(piece, sink);
                for _ in 0..*pauses {
                    decoder.lose_patience(sink);
                }
            }
        });
        // As a person would: waits for a word, presses Ctrl-C, and again.
        let last = report(|sink| {
            for _ in 0..2 {
                decoder.lose_patience(sink);
                decoder.lose_patience(sink);
                decoder.take(b"\x03", sink);
            }
            decoder.take(b"q", sink);
        });
        prop_assert_eq!(last.last(), Some(&letter('q')));
    }
}
