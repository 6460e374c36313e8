//! Inputs: good ones with a few changes, two of them spliced, or noise.

use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// What is put in: numbers at the edge, what opens and closes, words that a reader knows.
const WORDS: [&str; 40] = [
    "nan",
    "inf",
    "-inf",
    "1e999",
    "-1e308",
    "5e-324",
    "0",
    "-0.0",
    "-1",
    "1e9",
    "20000",
    "20001",
    "18446744073709551615",
    "9223372036854775808",
    "0x10",
    "1_000",
    "[",
    "]",
    "{",
    "}",
    "(",
    ")",
    "\"",
    "'''",
    "\n",
    "\r\n",
    "\0",
    ",",
    "=",
    ".",
    "#",
    "^",
    "\u{feff}",
    "φ",
    "[[vesicle.parts]]\n",
    "shape = 'random'\n",
    "{ file = 'k.txt' }",
    "<DataArray",
    "&#0;",
    "AAAAAAAA",
];

/// The generator of one input.
pub struct Mutation {
    generator: ChaCha8Rng,
}

impl Mutation {
    /// Of the input of this number.
    pub fn new(number: u64) -> Self {
        Self {
            generator: ChaCha8Rng::seed_from_u64(number),
        }
    }

    /// An input made from one of the seeds.
    pub fn of(mut self, seeds: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = seeds[self.below(seeds.len())].clone();
        match self.below(16) {
            0 => {
                let length = self.below(300);
                bytes = (0..length)
                    .map(|_| self.generator.next_u32() as u8)
                    .collect();
            }
            1 => {
                let other = &seeds[self.below(seeds.len())];
                let (cut, from) = (self.place(&bytes), self.place(other));
                bytes.truncate(cut);
                bytes.extend_from_slice(&other[from..]);
            }
            _ => {}
        }
        for _ in 0..=self.below(4) {
            self.change(&mut bytes);
        }
        bytes
    }

    fn below(&mut self, bound: usize) -> usize {
        self.generator.random_range(0..bound.max(1))
    }

    fn place(&mut self, bytes: &[u8]) -> usize {
        self.below(bytes.len() + 1)
    }

    fn change(&mut self, bytes: &mut Vec<u8>) {
        let from = self.place(bytes);
        let to = (from + self.below(24)).min(bytes.len());
        match self.below(7) {
            0 => bytes.truncate(from),
            1 => drop(bytes.drain(from..to)),
            2 => {
                let part = bytes[from..to].repeat(1 + self.below(200));
                bytes.splice(from..from, part);
            }
            3 => {
                if let Some(byte) = bytes.get_mut(from) {
                    *byte ^= 1 << (from % 8);
                }
            }
            4 => {
                let word = WORDS[self.below(WORDS.len())].repeat(1 + self.below(2000));
                bytes.splice(from..from, word.into_bytes());
            }
            _ => {
                let word = WORDS[self.below(WORDS.len())];
                bytes.splice(from..to, word.bytes());
            }
        }
    }
}
