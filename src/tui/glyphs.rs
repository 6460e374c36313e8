//! Character sets as data. Beyond ASCII there are box drawing, block elements and the eight arrows
//! alone, which the fonts of terminals have; words may also have Greek letters and those of Latin-1.

use std::borrow::Cow;

use ratatui::symbols::border;
use ratatui::symbols::braille::BRAILLE;
use ratatui::symbols::pixel::{OCTANTS, QUADRANTS};

/// The parts of a cell that lines are drawn with: any of them together are one glyph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Parts {
    /// Two by two, of Block Elements, which every font has.
    #[default]
    Quadrants,
    /// Two beside each other, four rows: glyphs of Unicode 16, which few fonts have.
    Octants,
    /// As many, as dots.
    Braille,
}

impl Parts {
    /// Parts beside each other.
    pub const COLUMNS: usize = 2;

    /// Parts one below the other.
    pub fn rows(self) -> usize {
        match self {
            Self::Quadrants => 2,
            Self::Octants | Self::Braille => 4,
        }
    }

    /// The glyph of the parts whose bits are set: from the left to the right, then the row below.
    pub fn glyph(self, bits: u8) -> char {
        let bits = usize::from(bits);
        match self {
            Self::Quadrants => QUADRANTS[bits % QUADRANTS.len()],
            Self::Octants => OCTANTS[bits],
            Self::Braille => BRAILLE[bits],
        }
    }
}

/// The characters that the screen is drawn with.
#[derive(Debug, PartialEq)]
pub struct Glyphs {
    /// Frames.
    pub border: border::Set<'static>,
    /// The line that a panel's title stands in.
    pub rule: &'static str,
    /// A vertical line: marks in curves, separators.
    pub bar: &'static str,
    /// Ticks of an axis below and to the left of a frame.
    pub ticks: [&'static str; 2],
    /// The eight directions, counter-clockwise from +x.
    pub arrows: [&'static str; 8],
    /// The four directions without a head, counter-clockwise from +x.
    pub strokes: [&'static str; 4],
    /// A line of one cell by the heights that it has there, the sum of 1 (bottom), 2 (middle) and 4 (top): what
    /// curves are drawn with.
    pub line: [&'static str; 8],
    /// Bars of one cell's breadth, from empty to full: what shares are drawn with.
    pub shares: &'static [&'static str],
    /// What is left of a bar of shares.
    pub rest: &'static str,
    /// Ink of a cell, from none to all: a field where there are no colours.
    pub ramp: &'static [&'static str],
    /// The same for φ, which is one of two values nearly everywhere: light, so that the contour and
    /// the director stand out.
    pub phase: &'static [&'static str],
    /// The contour φ = 0 where a cell has no parts.
    pub contour: &'static str,
    /// The upper half of a cell, where two samples share it; `None`: they cannot.
    pub upper_half: Option<&'static str>,
    /// The outline that theory foresees.
    pub theory: &'static str,
    /// Separates things in a line.
    pub dot: &'static str,
    /// Before what has the focus.
    pub focus: &'static str,
}

/// Box drawing, blocks, arrows.
pub static UNICODE: Glyphs = Glyphs {
    border: border::ROUNDED,
    rule: "─",
    bar: "│",
    ticks: ["┬", "┤"],
    arrows: ["→", "↗", "↑", "↖", "←", "↙", "↓", "↘"],
    strokes: ["─", "╱", "│", "╲"],
    line: [" ", "▁", "─", "╷", "▔", "│", "╵", "│"],
    shares: &[" ", "▏", "▎", "▍", "▌", "▋", "▊", "▉", "█"],
    rest: "░",
    ramp: &[" ", "░", "▒", "▓", "█"],
    phase: &[" ", "░"],
    contour: "█",
    upper_half: Some("▀"),
    theory: "•",
    dot: "·",
    focus: "█",
};

/// ASCII alone.
pub static ASCII: Glyphs = Glyphs {
    border: border::Set {
        top_left: "+",
        top_right: "+",
        bottom_left: "+",
        bottom_right: "+",
        vertical_left: "|",
        vertical_right: "|",
        horizontal_top: "-",
        horizontal_bottom: "-",
    },
    rule: "-",
    bar: "|",
    ticks: ["+", "+"],
    // A diagonal has no head in ASCII.
    arrows: [">", "/", "^", "\\", "<", "/", "v", "\\"],
    strokes: ["-", "/", "|", "\\"],
    line: [" ", "_", "-", "|", "'", "|", "|", "|"],
    shares: &[" ", "#"],
    rest: ".",
    ramp: &[" ", ".", ":", "-", "=", "+", "*", "#", "%", "@"],
    phase: &[" ", "."],
    contour: "#",
    upper_half: None,
    theory: "o",
    dot: "-",
    focus: "*",
};

/// Where ink covers more of a cell the number is greater: the order of the glyphs of ramps
/// and shares, roughly in percent.
#[cfg(test)]
fn coverage(glyph: &str) -> u32 {
    match glyph {
        " " => 0,
        "." => 4,
        ":" => 8,
        "-" => 9,
        "=" => 17,
        "+" => 18,
        "*" => 20,
        "#" => 34,
        "%" => 36,
        "@" => 42,
        "░" => 25,
        "▒" => 50,
        "▓" => 75,
        "▏" => 12,
        "▎" => 25,
        "▍" => 37,
        "▌" => 50,
        "▋" => 62,
        "▊" => 75,
        "▉" => 87,
        "█" => 100,
        other => unreachable!("no coverage of {other:?}"),
    }
}

/// Which of eight directions is nearest to an angle, counted counter-clockwise from +x.
fn eighth(x: f64, y: f64) -> usize {
    let turns = y.atan2(x) / std::f64::consts::TAU;
    (8.0 * turns).round().rem_euclid(8.0) as usize % 8
}

impl Glyphs {
    /// The arrow nearest to a direction; y points up.
    pub fn arrow(&self, x: f64, y: f64) -> &'static str {
        self.arrows[eighth(x, y)]
    }

    /// The stroke nearest to a direction: the same for its opposite.
    pub fn stroke(&self, x: f64, y: f64) -> &'static str {
        self.strokes[eighth(x, y) % 4]
    }

    /// The glyph of a share in [0, 1] out of a ramp or shares: the nearest.
    pub fn pick(set: &'static [&'static str], share: f64) -> &'static str {
        let last = set.len().saturating_sub(1);
        // A NaN becomes 0.
        let index = (share * last as f64).round().max(0.0) as usize;
        set.get(index.min(last)).copied().unwrap_or(" ")
    }
}

/// A text in ASCII as one writes it there: Greek letters by their names, powers as ^2, signs as in a program. What has
/// no such form stays, for [`ascii`].
pub fn spelt(text: &str) -> Cow<'_, str> {
    if text.is_ascii() {
        return Cow::Borrowed(text);
    }
    let mut spelt = String::with_capacity(text.len() + 8);
    let mut is_after_name = false;
    for character in text.chars() {
        let mut own = [0; 4];
        let words = spelling(character).unwrap_or(character.encode_utf8(&mut own));
        // A name of more than a letter is a word of its own: 4 pi A, not 4piA.
        let is_name = !character.is_ascii()
            && words.len() > 1
            && words.chars().all(|letter| letter.is_ascii_alphabetic());
        let is_letter = |it: char| it.is_ascii_alphanumeric();
        let runs_on = spelt.ends_with(is_letter) && words.starts_with(is_letter);
        if runs_on && (is_name || is_after_name) {
            spelt.push(' ');
        }
        spelt.push_str(words);
        is_after_name = is_name;
    }
    Cow::Owned(spelt)
}

/// How a character is written in ASCII, where that is more than another character.
fn spelling(character: char) -> Option<&'static str> {
    Some(match character {
        'α' => "alpha",
        'β' => "beta",
        'γ' => "gamma",
        'δ' => "delta",
        'Δ' => "d",
        'ε' => "eps",
        'η' => "eta",
        'θ' => "theta",
        'κ' => "kappa",
        'λ' => "lambda",
        'μ' | 'µ' => "mu",
        'ξ' => "xi",
        'π' => "pi",
        'σ' => "sigma",
        'τ' => "tau",
        'φ' | 'Φ' => "phi",
        'χ' => "chi",
        'ω' | 'Ω' => "omega",
        '²' => "^2",
        '³' => "^3",
        '⁰' => "^0",
        '½' => "1/2",
        '√' => "sqrt ",
        '∫' => "integral of ",
        '∂' => "d",
        '≤' => "<=",
        '≥' => ">=",
        '≠' => "!=",
        '≈' => "about ",
        '∞' => "infinity",
        '·' => "*",
        '×' => "x",
        '±' => "+-",
        '−' | '–' | '—' => "-",
        '°' => " deg",
        '→' => "->",
        '←' => "<-",
        '…' => "...",
        _ => return None,
    })
}

/// One ASCII character in place of any other: the last resort for words that are not our own (a
/// scene's name, an error's text), one cell for one cell.
pub fn ascii(character: char) -> char {
    match character {
        ' '..='~' => character,
        'φ' | 'Φ' => 'f',
        'ω' | 'Ω' => 'w',
        'μ' | 'µ' => 'u',
        'β' => 'b',
        'ε' => 'e',
        'η' => 'n',
        'λ' => 'l',
        'γ' => 'g',
        'δ' | 'Δ' => 'd',
        'π' => 'p',
        '·' | '–' | '—' | '−' | '─' => '-',
        '×' => 'x',
        '…' => '.',
        '“' | '”' | '„' => '"',
        '‘' | '’' => '\'',
        '│' => '|',
        'ä' | 'á' | 'à' | 'â' => 'a',
        'ö' | 'ó' | 'ò' | 'ô' => 'o',
        'ü' | 'ú' | 'ù' | 'û' => 'u',
        'é' | 'è' | 'ê' | 'ë' => 'e',
        'ß' => 's',
        '²' => '2',
        '³' => '3',
        '⁰' | '°' => '0',
        _ => '?',
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_ink_means_more() {
        for set in [&UNICODE, &ASCII] {
            for glyphs in [set.shares, set.ramp, set.phase] {
                let ink: Vec<u32> = glyphs.iter().map(|glyph| coverage(glyph)).collect();
                assert!(ink.windows(2).all(|pair| pair[0] < pair[1]), "{glyphs:?}");
                assert_eq!(ink[0], 0);
            }
        }
    }

    #[test]
    fn parts_are_counted_row_by_row() {
        let glyphs = |parts: Parts, bits: [u8; 4]| bits.map(|bits| parts.glyph(bits));
        assert_eq!(
            glyphs(Parts::Quadrants, [0, 1, 2, 12]),
            [' ', '▘', '▝', '▄']
        );
        assert_eq!(
            glyphs(Parts::Braille, [1, 2, 64, 255]),
            ['⠁', '⠈', '⡀', '⣿']
        );
        assert_eq!(
            glyphs(Parts::Octants, [0, 0x0f, 0x55, 255]),
            [' ', '▀', '▌', '█']
        );
    }

    #[test]
    fn arrows_point_where_they_should_and_strokes_forget_the_head() {
        let directions = [
            (1.0, 0.0, "→", "─"),
            (1.0, 1.0, "↗", "╱"),
            (0.0, 1.0, "↑", "│"),
            (-1.0, 1.0, "↖", "╲"),
            (-1.0, 0.0, "←", "─"),
            (-1.0, -1.0, "↙", "╱"),
            (0.0, -1.0, "↓", "│"),
            (1.0, -1.0, "↘", "╲"),
            (1.0, -0.1, "→", "─"),
            (-1.0, -1e-12, "←", "─"),
        ];
        for (x, y, arrow, stroke) in directions {
            assert_eq!((UNICODE.arrow(x, y), UNICODE.stroke(x, y)), (arrow, stroke));
        }
        assert_eq!(ASCII.arrow(-1.0, 0.1), "<");
        assert_eq!(ASCII.stroke(0.1, -1.0), "|");
        // Neither a vanishing director nor one that is not a number has a direction; both get a glyph.
        assert_eq!(UNICODE.arrow(0.0, 0.0), "→");
        assert_eq!(UNICODE.arrow(f64::NAN, 1.0), "→");
    }

    #[test]
    fn the_ascii_set_is_ascii_and_every_character_has_a_substitute() {
        let set = &ASCII;
        let mut glyphs = vec![
            set.rule,
            set.bar,
            set.rest,
            set.contour,
            set.dot,
            set.theory,
        ];
        glyphs.extend(set.arrows.iter().chain(&set.strokes).chain(&set.ticks));
        glyphs.extend(set.line.iter().chain(set.shares).chain(set.ramp));
        assert!(glyphs.iter().all(|glyph| glyph.is_ascii()));
        for character in ['φ', '…', '漢', '\u{7f}', '\n', 'é', '💧'] {
            assert!((' '..='~').contains(&ascii(character)));
        }
    }

    #[test]
    fn formulas_are_spelt_out() {
        for (text, expected) in [
            ("penalty (B - β)²/(2η)", "penalty (B - beta)^2/(2 eta)"),
            ("∫φ, conserved", "integral of phi, conserved"),
            ("4π·area/(length)²: 1", "4 pi*area/(length)^2: 1"),
            ("ε/2 ω²", "eps/2 omega^2"),
            ("φ⁰ ≥ −1", "phi^0 >= -1"),
            ("Δt", "dt"),
            ("4πA/L²", "4 pi A/L^2"),
            ("plain", "plain"),
            ("漢", "漢"),
        ] {
            assert_eq!(spelt(text), expected);
        }
    }

    #[test]
    fn shares_beyond_the_ends_have_the_glyph_of_the_end() {
        let pick = |share| Glyphs::pick(UNICODE.shares, share);
        assert_eq!([pick(-1.0), pick(0.0), pick(0.5)], [" ", " ", "▌"]);
        assert_eq!([pick(1.0), pick(7.0), pick(f64::NAN)], ["█", "█", " "]);
    }
}
