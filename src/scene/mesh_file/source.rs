//! Numbers from a file, whether it is text or binary.

use super::error::{MeshFileError, MeshFileProblem, MeshPlace};

/// Characters of a word that a message repeats.
const LONGEST_WORD: usize = 40;

/// How the numbers of the sections stand in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    /// As words.
    Text,
    /// As bytes, in the machine's order or in the other one.
    Binary { is_little: bool },
}

/// A place in a file, from which numbers are read.
#[derive(Debug, Clone)]
pub(super) struct Source<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    pub(super) encoding: Encoding,
}

impl<'a> Source<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            line: 1,
            encoding: Encoding::Text,
        }
    }

    /// Where the next thing stands.
    pub(super) fn place(&self) -> MeshPlace {
        match self.encoding {
            Encoding::Text => MeshPlace::Line(self.line),
            Encoding::Binary { .. } => MeshPlace::Byte(self.at),
        }
    }

    pub(super) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn advance(&mut self, count: usize) -> &'a [u8] {
        let passed = &self.bytes[self.at..self.at + count];
        self.at += count;
        if self.encoding == Encoding::Text {
            self.line += passed.iter().filter(|byte| **byte == b'\n').count();
        }
        passed
    }

    /// Goes to the next word.
    pub(super) fn skip_blanks(&mut self) {
        let rest = &self.bytes[self.at..];
        let blanks = rest.iter().take_while(|byte| byte.is_ascii_whitespace());
        let count = blanks.count();
        self.advance(count);
    }

    /// Goes to the next word of a text; binary data have no blanks.
    pub(super) fn skip_blanks_of_text(&mut self) {
        if self.encoding == Encoding::Text {
            self.skip_blanks();
        }
    }

    /// Whether a section's end is next. Of binary data too: nothing else begins with these bytes but a
    /// number above 6·10⁸.
    pub(super) fn is_at_end_of_section(&mut self) -> bool {
        self.skip_blanks_of_text();
        let rest = &self.bytes[self.at..];
        let rest = match self.encoding {
            Encoding::Text => rest,
            Encoding::Binary { .. } => rest.strip_prefix(b"\n").unwrap_or(rest),
        };
        rest.starts_with(b"$End")
    }

    /// Goes on behind the end of a line, where binary data begin.
    pub(super) fn skip_line_end(&mut self) {
        let rest = &self.bytes[self.at..];
        let end = match rest {
            [b'\r', b'\n', ..] => 2,
            [b'\n', ..] => 1,
            _ => 0,
        };
        self.advance(end);
    }

    /// The next word; `None` at the end.
    pub(super) fn word(&mut self) -> Option<(MeshPlace, &'a [u8])> {
        self.skip_blanks();
        let rest = &self.bytes[self.at..];
        let length = rest.iter().take_while(|byte| !byte.is_ascii_whitespace());
        let length = length.count();
        let place = self.place();
        (length > 0).then(|| (place, self.advance(length)))
    }

    /// The next word as a number of a text.
    fn parsed<T: std::str::FromStr>(&mut self, expected: &'static str) -> Result<T, MeshFileError> {
        let Some((place, word)) = self.word() else {
            return Err(MeshFileProblem::Ends { expected }.at(self.place()));
        };
        let text = std::str::from_utf8(word).ok();
        text.and_then(|text| text.parse().ok())
            .ok_or_else(|| Self::unexpected(expected, word).at(place))
    }

    /// The next bytes of binary data.
    fn raw<const N: usize>(&mut self, expected: &'static str) -> Result<[u8; N], MeshFileError> {
        match self.bytes[self.at..].first_chunk::<N>() {
            Some(bytes) => {
                self.at += N;
                Ok(*bytes)
            }
            None => Err(MeshFileProblem::Ends { expected }.at(self.place())),
        }
    }

    /// An integer of four bytes, or a word.
    pub(super) fn int(&mut self, expected: &'static str) -> Result<i64, MeshFileError> {
        match self.encoding {
            Encoding::Text => self.parsed(expected),
            Encoding::Binary { is_little: true } => {
                Ok(i32::from_le_bytes(self.raw(expected)?).into())
            }
            Encoding::Binary { is_little: false } => {
                Ok(i32::from_be_bytes(self.raw(expected)?).into())
            }
        }
    }

    /// A size of eight bytes, or a word.
    pub(super) fn size(&mut self, expected: &'static str) -> Result<u64, MeshFileError> {
        match self.encoding {
            Encoding::Text => self.parsed(expected),
            Encoding::Binary { is_little: true } => Ok(u64::from_le_bytes(self.raw(expected)?)),
            Encoding::Binary { is_little: false } => Ok(u64::from_be_bytes(self.raw(expected)?)),
        }
    }

    /// A floating-point number of eight bytes, or a word.
    pub(super) fn double(&mut self, expected: &'static str) -> Result<f64, MeshFileError> {
        match self.encoding {
            Encoding::Text => self.parsed(expected),
            Encoding::Binary { is_little: true } => Ok(f64::from_le_bytes(self.raw(expected)?)),
            Encoding::Binary { is_little: false } => Ok(f64::from_be_bytes(self.raw(expected)?)),
        }
    }

    /// A number of things of which each takes so many bytes at least, so that there is room for them
    /// in the file: nothing is allocated that a wrong number asks for.
    pub(super) fn count(
        &mut self,
        what: &'static str,
        least_bytes: usize,
    ) -> Result<usize, MeshFileError> {
        let place = self.place();
        let count = self.size(what)?;
        let left = self.left();
        match usize::try_from(count) {
            Ok(count) if count <= left / least_bytes + 1 => Ok(count),
            _ => Err(MeshFileProblem::TooMany { count, what, left }.at(place)),
        }
    }

    /// Expects a word.
    pub(super) fn expect(&mut self, wanted: &'static str) -> Result<(), MeshFileError> {
        let Some((place, word)) = self.word() else {
            return Err(MeshFileProblem::Ends { expected: wanted }.at(self.place()));
        };
        if word == wanted.as_bytes() {
            return Ok(());
        }
        Err(Self::unexpected(wanted, word).at(place))
    }

    /// Goes on behind the end of a section whose content does not matter.
    pub(super) fn skip_section(&mut self, name: &[u8]) -> Result<(), MeshFileError> {
        let end = [b"$End", name].concat();
        let rest = &self.bytes[self.at..];
        let found = rest.windows(end.len()).position(|window| window == end);
        match found {
            Some(position) => {
                self.advance(position + end.len());
                Ok(())
            }
            None => Err(MeshFileProblem::Ends {
                expected: "the end of the section",
            }
            .at(self.place())),
        }
    }

    /// The problem that a word is not what should stand there.
    pub(super) fn unexpected(expected: &'static str, word: &[u8]) -> MeshFileProblem {
        let text = String::from_utf8_lossy(&word[..word.len().min(LONGEST_WORD)]);
        let found = text.replace(char::is_control, "\u{fffd}");
        MeshFileProblem::Unexpected { expected, found }
    }
}
