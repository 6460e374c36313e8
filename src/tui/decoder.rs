//! Keys and pasted texts in the bytes that a terminal sends.
//!
//! Not all that a terminal sends was typed: it also answers questions, perhaps those of a program that has
//! ended, and it sends what is pasted. Such bytes must never count as keys, however many there are, wherever
//! a slow link cuts them, and however long it pauses. So the decoder is the state machine of the control
//! sequences (ECMA-48, as the VT500 parses them): what belongs to a sequence is decided by its bytes alone,
//! and only what is kept of it is bounded.
//!
//! It differs from the VT500 where that would make keys of damaged sequences. A control or a byte above ASCII
//! within a sequence is skipped, and what it broke is not a key. In a control string Escape begins something
//! else only before the byte of an introducer; before another byte both are a part of the string.
//!
//! CAN, SUB and Ctrl-C leave a sequence at once, and any letter ends it. CAN and SUB leave a control string,
//! too; in a paste they are text. Ctrl-C may be a part of a string or a paste. It leaves them, and Escape
//! leaves a string, when they have been silent for [`QUIET`]: then a message says that they have not ended.
//!
//! Time decides one more thing, for bytes cannot. Escape is a key where nothing follows it for [`LONE`]; if
//! the rest of a sequence follows after all, within [`LATE`], it is still one.

use rustix::event::Timespec;
use terminput::Event;
use terminput_crossterm::to_crossterm;

use super::event::AppEvent;
use super::message::Message;

/// How long the rest of a sequence may take before Escape counts as the key: links cut sequences in two.
const LONE: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 40_000_000,
};
/// How long the rest may take after that and still be the rest.
const LATE: Timespec = Timespec {
    tv_sec: 3,
    tv_nsec: 0,
};
/// How long a string or a paste may pause before that is reported, and the user can leave it.
const QUIET: Timespec = Timespec {
    tv_sec: 1,
    tv_nsec: 0,
};

/// A key's sequence is shorter than this.
const LONGEST_KEY: usize = 64;
/// Bytes of a pasted text that are kept: it goes into a line for a path, and this is the longest path.
const LONGEST_TEXT: usize = 4096;

const PASTE_BEGIN: &[u8] = b"\x1b[200~";
const PASTE_END: &[u8] = b"\x1b[201~";

const ETX: u8 = 0x03;
const BEL: u8 = 0x07;
const CAN: u8 = 0x18;
const SUB: u8 = 0x1a;
const ESC: u8 = 0x1b;
/// String terminator, as one byte.
const ST: u8 = 0x9c;

const UNENDED_STRING: &str = "the terminal began an answer and has not ended it: until then nothing counts \
                              as a key; Ctrl-C ends it";
const UNENDED_PASTE: &str = "the terminal began a paste and has not ended it: until then nothing counts as \
                             a key; Ctrl-C ends it";

/// Takes keys out of a stream of bytes.
#[derive(Debug, Default)]
pub(super) struct Decoder {
    state: State,
    /// The character or sequence that has begun, or the pasted text: what is kept of it.
    pending: Vec<u8>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
enum State {
    /// Between keys.
    #[default]
    Ground,
    /// In a character, with this many bytes still to come.
    Character(u8),
    /// Behind ESC: the key, or the begin of a sequence.
    Escape,
    /// Behind an ESC that counted as the key a short time ago.
    LateEscape,
    /// Behind ESC and an intermediate, as in `ESC ( B`.
    EscapeIntermediate,
    /// Behind SS2: one character belongs to it.
    SingleShift2,
    /// In a key's sequence that begins with SS3, as in `ESC O A`.
    SingleShift3,
    /// In a control sequence, as in `ESC [ 1 ; 5 C`.
    ControlSequence {
        /// Whether it contained something that it cannot: it is not a key then.
        is_broken: bool,
        /// Bytes still to come of a character in it.
        continuation: u8,
    },
    /// Bytes still to come that follow a sequence and belong to it.
    Appendix(u8),
    /// In a control string.
    String(ControlString),
    /// Behind an ESC in a control string: its end, the begin of something else, or a part of it.
    StringEscape {
        string: ControlString,
        /// Whether ESC came after it was reported that the string does not end: then it ends it.
        is_way_out: bool,
    },
    /// In a pasted text.
    Paste {
        /// Bytes of [`PASTE_END`] that have come.
        matched: usize,
        /// Whether it was reported that it does not end.
        is_reported: bool,
    },
}

/// OSC, DCS, SOS, PM or APC.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ControlString {
    /// Whether it is an OSC, which BEL ends, too.
    is_osc: bool,
    /// Bytes still to come of a character in it.
    continuation: u8,
    /// Whether it was reported that it does not end.
    is_reported: bool,
}

impl Decoder {
    /// Takes bytes, and reports the keys and texts that they complete.
    pub fn take(&mut self, bytes: &[u8], sink: &mut dyn FnMut(AppEvent)) {
        for &byte in bytes {
            self.state = self.next(byte, sink);
        }
    }

    /// How long to wait for the next byte before [`lose_patience`](Self::lose_patience).
    pub fn patience(&self) -> Option<Timespec> {
        match self.state {
            State::Escape => Some(LONE),
            State::LateEscape => Some(LATE),
            State::String(ControlString { is_reported, .. })
            | State::StringEscape {
                string: ControlString { is_reported, .. },
                ..
            }
            | State::Paste { is_reported, .. } => (!is_reported).then_some(QUIET),
            State::Ground
            | State::Character(_)
            | State::EscapeIntermediate
            | State::SingleShift2
            | State::SingleShift3
            | State::ControlSequence { .. }
            | State::Appendix(_) => None,
        }
    }

    /// No byte came for that long.
    pub fn lose_patience(&mut self, sink: &mut dyn FnMut(AppEvent)) {
        match &mut self.state {
            State::Escape => {
                self.report_key(sink);
                self.state = State::LateEscape;
            }
            State::LateEscape => self.state = State::Ground,
            State::String(string) | State::StringEscape { string, .. } => {
                string.is_reported = true;
                sink(AppEvent::Message(Message::Remark(UNENDED_STRING.into())));
            }
            State::Paste { is_reported, .. } => {
                *is_reported = true;
                sink(AppEvent::Message(Message::Remark(UNENDED_PASTE.into())));
            }
            _ => {}
        }
    }

    /// The state after a byte.
    fn next(&mut self, byte: u8, sink: &mut dyn FnMut(AppEvent)) -> State {
        match self.state {
            State::Ground => self.begin(byte, sink),
            State::Character(left) => match byte {
                0x80..=0xbf if left > 1 => self.keep(byte, State::Character(left - 1)),
                0x80..=0xbf => self.end_key(byte, sink),
                _ => self.begin(byte, sink),
            },
            State::Escape => match (introduced(byte), byte) {
                (Some(state), _) => self.keep(byte, state),
                // The first was a key.
                (None, ESC) => {
                    self.report_key(sink);
                    self.begin(byte, sink)
                }
                // The end of a string that was left before.
                (None, b'\\') => State::Ground,
                (None, b' '..=b'/') => State::EscapeIntermediate,
                (None, 0x80..) => match self.begin(byte, sink) {
                    State::Character(left) => {
                        self.pending.insert(0, ESC);
                        State::Character(left)
                    }
                    other => other,
                },
                // With Alt.
                (None, _) => self.end_key(byte, sink),
            },
            State::LateEscape => match (introduced(byte), byte) {
                (Some(state), _) => {
                    self.pending.clear();
                    self.pending.extend([ESC, byte]);
                    state
                }
                // Keys of the app, which are pressed after Escape; no terminal sends such a sequence by itself.
                (None, b' ' | b'+' | b'-') => self.begin(byte, sink),
                (None, b' '..=b'/') => State::EscapeIntermediate,
                (None, _) => self.begin(byte, sink),
            },
            State::EscapeIntermediate => match byte {
                b' '..=b'/' => State::EscapeIntermediate,
                b'0'..=b'~' => State::Ground,
                _ => self.within(byte, State::EscapeIntermediate, sink),
            },
            State::SingleShift2 => match byte {
                b' '..=b'~' => State::Ground,
                _ => self.within(byte, State::SingleShift2, sink),
            },
            State::SingleShift3 => match byte {
                b' '..=b'?' => self.keep(byte, State::SingleShift3),
                b'@'..=b'~' => self.end_key(byte, sink),
                _ => self.within(byte, State::SingleShift3, sink),
            },
            State::ControlSequence {
                is_broken,
                continuation,
            } => {
                let broken = |continuation| State::ControlSequence {
                    is_broken: true,
                    continuation,
                };
                let goes_on = State::ControlSequence {
                    is_broken,
                    continuation: 0,
                };
                match (byte, continuations(byte)) {
                    (0x80..=0xbf, _) if continuation > 0 => broken(continuation - 1),
                    (_, Some(continuation)) => broken(continuation),
                    (b' '..=b'?', _) => self.keep(byte, goes_on),
                    (b'@'..=b'~', _) => self.end_control_sequence(byte, is_broken, sink),
                    _ => self.within(byte, broken(0), sink),
                }
            }
            State::Appendix(left) => match byte {
                0..b' ' => self.begin(byte, sink),
                _ if left > 1 => State::Appendix(left - 1),
                _ => State::Ground,
            },
            State::String(string) => self.string(byte, string),
            State::StringEscape { string, is_way_out } => match (introduced(byte), byte) {
                (Some(state), _) => {
                    self.pending.clear();
                    self.pending.extend([ESC, byte]);
                    state
                }
                (None, b'\\') => State::Ground,
                (None, ESC) => self.string(byte, string),
                // A person who reads that the string does not end.
                (None, _) if is_way_out => State::Ground,
                (None, _) => self.string(byte, string),
            },
            State::Paste {
                matched,
                is_reported,
            } => self.paste(byte, matched, is_reported, sink),
        }
    }

    /// The state after the first byte of something.
    fn begin(&mut self, byte: u8, sink: &mut dyn FnMut(AppEvent)) -> State {
        self.pending.clear();
        match byte {
            ESC => self.keep(ESC, State::Escape),
            0..0x80 => self.end_key(byte, sink),
            // The introducers that are ESC and a byte may be one byte, which UTF-8 has within characters only.
            0x80..=0x9f => match introduced(byte - 0x40) {
                Some(state) => {
                    self.pending.extend([ESC, byte - 0x40]);
                    state
                }
                None => State::Ground,
            },
            _ => match continuations(byte) {
                Some(left) => self.keep(byte, State::Character(left)),
                None => State::Ground,
            },
        }
    }

    /// The state after a byte that does not belong to the sequence which has begun: that continues in `state`,
    /// or is left.
    fn within(&mut self, byte: u8, state: State, sink: &mut dyn FnMut(AppEvent)) -> State {
        match byte {
            CAN | SUB | ETX => State::Ground,
            ESC => self.begin(byte, sink),
            0x80..=0x9f if introduced(byte - 0x40).is_some() => self.begin(byte, sink),
            _ => continuations(byte).map_or(state, State::Appendix),
        }
    }

    /// The state after a byte of a control string.
    fn string(&self, byte: u8, string: ControlString) -> State {
        let inside = |continuation| {
            State::String(ControlString {
                continuation,
                ..string
            })
        };
        match byte {
            0x80..=0xbf if string.continuation > 0 => inside(string.continuation - 1),
            ESC => State::StringEscape {
                string: ControlString {
                    continuation: 0,
                    ..string
                },
                is_way_out: string.is_reported,
            },
            ST | CAN | SUB => State::Ground,
            ETX if string.is_reported => State::Ground,
            BEL if string.is_osc => State::Ground,
            _ => inside(continuations(byte).unwrap_or(0)),
        }
    }

    fn keep(&mut self, byte: u8, state: State) -> State {
        if self.pending.len() < LONGEST_KEY {
            self.pending.push(byte);
        }
        state
    }

    /// The last byte of what may be a key.
    fn end_key(&mut self, byte: u8, sink: &mut dyn FnMut(AppEvent)) -> State {
        self.keep(byte, State::Ground);
        self.report_key(sink);
        State::Ground
    }

    /// The last byte of a control sequence.
    fn end_control_sequence(
        &mut self,
        byte: u8,
        is_broken: bool,
        sink: &mut dyn FnMut(AppEvent),
    ) -> State {
        self.keep(byte, State::Ground);
        if self.pending == PASTE_BEGIN {
            self.pending.clear();
            return State::Paste {
                matched: 0,
                is_reported: false,
            };
        }
        match &self.pending[2..] {
            // The mouse of old: button, column, row. The function keys of the Linux console: one letter.
            b"M" => return State::Appendix(3),
            b"[" => return State::Appendix(1),
            _ => {}
        }
        // Those of keys have nothing but numbers before their last byte. What begins with one of <=>? is an
        // answer or the mouse, what ends otherwise too: R is the cursor's place before it is F3.
        let numbers = &self.pending[2..self.pending.len() - 1];
        let is_key = !is_broken
            && numbers
                .iter()
                .all(|byte| matches!(byte, b'0'..=b'9' | b';' | b':'))
            && matches!(
                byte,
                b'A'..=b'D' | b'F' | b'H' | b'P' | b'Q' | b'S' | b'Z' | b'~' | b'u'
            );
        if is_key && self.pending.len() < LONGEST_KEY {
            self.report_key(sink);
        }
        State::Ground
    }

    /// The state after a byte of a pasted text.
    fn paste(
        &mut self,
        byte: u8,
        matched: usize,
        is_reported: bool,
        sink: &mut dyn FnMut(AppEvent),
    ) -> State {
        // A person who reads that the paste does not end.
        if is_reported && byte == ETX {
            return State::Ground;
        }
        if byte == PASTE_END[matched] {
            if matched + 1 < PASTE_END.len() {
                return State::Paste {
                    matched: matched + 1,
                    is_reported,
                };
            }
            let text = String::from_utf8_lossy(&self.pending).into_owned();
            sink(AppEvent::Pasted(text));
            return State::Ground;
        }
        // Text that began like the end; ESC stands in the end but once.
        let begun = &PASTE_END[..matched];
        let matched = usize::from(byte == ESC);
        let text = begun.iter().chain((matched == 0).then_some(&byte));
        let room = LONGEST_TEXT - self.pending.len();
        self.pending.extend(text.take(room));
        State::Paste {
            matched,
            is_reported: false,
        }
    }

    /// Reports what is pending, if it is a key.
    fn report_key(&mut self, sink: &mut dyn FnMut(AppEvent)) {
        use crossterm::event::{Event::Key, KeyCode, KeyEventKind};
        if let Ok(Some(event)) = Event::parse_from(&self.pending)
            && let Ok(Key(key)) = to_crossterm(event)
            && key.kind != KeyEventKind::Release
            && !matches!(key.code, KeyCode::Char(letter) if letter.is_control())
        {
            sink(AppEvent::Message(Message::Key(key)));
        }
        self.pending.clear();
    }
}

/// The state after ESC and this byte, where they begin a sequence.
fn introduced(byte: u8) -> Option<State> {
    match byte {
        b'N' => Some(State::SingleShift2),
        b'O' => Some(State::SingleShift3),
        b'[' => Some(State::ControlSequence {
            is_broken: false,
            continuation: 0,
        }),
        b'P' | b'X' | b']' | b'^' | b'_' => Some(State::String(ControlString {
            is_osc: byte == b']',
            continuation: 0,
            is_reported: false,
        })),
        _ => None,
    }
}

/// How many bytes follow the first one of a character in UTF-8, if it is one and they are any.
fn continuations(byte: u8) -> Option<u8> {
    match byte {
        0xc2..=0xdf => Some(1),
        0xe0..=0xef => Some(2),
        0xf0..=0xf4 => Some(3),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
