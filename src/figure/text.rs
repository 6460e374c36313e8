//! Text as outlines, from fonts in the program.
//!
//! A picture's text is drawn as filled outlines, in PNG and SVG alike: neither making a picture nor
//! looking at it needs a font on the machine, and what is measured here is what is seen.

use super::canvas::Rectangle;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::sync::LazyLock;
use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// What a line of text takes above its base line, in sizes.
const ASCENT: f64 = 0.94;
/// What it takes below.
const DESCENT: f64 = 0.30;
/// The size of an index.
const INDEX_SIZE: f64 = 0.72;
/// How far an index below stands under the base line, in sizes of the text.
const LOWER: f64 = 0.12;
/// How far one above stands over it.
const UPPER: f64 = 0.36;
/// Half the height of a figure, in sizes.
const MIDDLE: f64 = 0.365;

static UPRIGHT: LazyLock<Font> = LazyLock::new(|| Font::new(dejavu::sans::regular()));
static SLANTED: LazyLock<Font> = LazyLock::new(|| Font::new(dejavu::sans::oblique()));

struct Font {
    face: Face<'static>,
    units_per_size: f64,
}

impl Font {
    /// # Panics
    /// If the font in the program is broken, which no run of it can cause.
    fn new(data: &'static [u8]) -> Font {
        let face = Face::parse(data, 0).expect("the fonts in the program are sound");
        let units_per_size = f64::from(face.units_per_em());
        Font {
            face,
            units_per_size,
        }
    }

    /// The glyph of a character; the box of the font for one that it does not have.
    fn glyph(&self, character: char) -> GlyphId {
        self.face.glyph_index(character).unwrap_or(GlyphId(0))
    }

    fn advance(&self, character: char) -> f64 {
        let advance = self.face.glyph_hor_advance(self.glyph(character));
        f64::from(advance.unwrap_or(0)) / self.units_per_size
    }
}

/// How a letter of a label is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Set {
    Upright,
    Slanted,
    Below,
    Above,
}

impl Set {
    const ALL: [Set; 4] = [Set::Upright, Set::Slanted, Set::Below, Set::Above];

    /// The control character before letters that are set so.
    fn mark(self) -> char {
        char::from(0x11 + self as u8)
    }

    fn font(self) -> &'static Font {
        match self {
            Set::Slanted => &SLANTED,
            Set::Upright | Set::Below | Set::Above => &UPRIGHT,
        }
    }

    /// The size, and how far above the base line it stands, both in sizes of the text.
    fn size_and_rise(self) -> (f64, f64) {
        match self {
            Set::Upright | Set::Slanted => (1.0, 0.0),
            Set::Below => (INDEX_SIZE, -LOWER),
            Set::Above => (INDEX_SIZE, UPPER),
        }
    }
}

/// A line of text with symbols and indices.
///
/// Symbols are slanted, indices upright, as print has them. It is a string in which a control character
/// tells how the letters after it are set: plotters hands strings from its charts to the back end.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Label(String);

impl From<Label> for String {
    fn from(label: Label) -> String {
        label.0
    }
}

impl Label {
    /// Plain text. Characters that control (a line break, say) become spaces.
    pub fn text(text: &str) -> Label {
        Label::default().and(text)
    }

    /// A symbol.
    pub fn symbol(text: &str) -> Label {
        Label::default().and_symbol(text)
    }

    /// A label again that was made a string.
    pub fn of_string(text: &str) -> Label {
        Label(text.to_owned())
    }

    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Followed by plain text.
    pub fn and(self, text: &str) -> Label {
        self.with(Set::Upright, text)
    }

    /// Followed by a symbol.
    pub fn and_symbol(self, text: &str) -> Label {
        self.with(Set::Slanted, text)
    }

    /// Followed by an index below.
    pub fn below(self, text: &str) -> Label {
        self.with(Set::Below, text)
    }

    /// Followed by an index above.
    pub fn above(self, text: &str) -> Label {
        self.with(Set::Above, text)
    }

    /// Followed by another label.
    pub fn and_label(self, label: Label) -> Label {
        label.letters().fold(self, Label::push)
    }

    fn with(self, set: Set, text: &str) -> Label {
        let visible = |c: char| if c.is_control() { ' ' } else { c };
        let letters = text.chars().map(|c| (set, visible(c)));
        letters.fold(self, Label::push)
    }

    fn push(mut self, (set, character): Letter) -> Label {
        let last = self.letters().last().map_or(Set::Upright, |(set, _)| set);
        if set != last {
            self.0.push(set.mark());
        }
        self.0.push(character);
        self
    }

    fn letters(&self) -> impl Iterator<Item = Letter> {
        let mut now = Set::Upright;
        self.0.chars().filter_map(move |character| {
            let set = Set::ALL.into_iter().find(|set| set.mark() == character);
            now = set.unwrap_or(now);
            set.is_none().then_some((now, character))
        })
    }

    /// The text without its setting.
    pub fn plain(&self) -> String {
        self.letters().map(|(_, character)| character).collect()
    }

    /// The width at a size.
    pub fn width(&self, size: f64) -> f64 {
        let advance = |(set, c): Letter| set.size_and_rise().0 * set.font().advance(c);
        size * self.letters().map(advance).sum::<f64>()
    }

    /// The lines of a label that is to be no wider than `width`: broken at spaces, and where a
    /// word is too wide, within it.
    pub fn wrapped(&self, size: f64, width: f64) -> Vec<Label> {
        let fits = |label: &Label| label.width(size) <= width;
        if fits(self) {
            return vec![self.clone()];
        }
        let letters: Vec<Letter> = self.letters().collect();
        let mut lines = vec![Label::default()];
        let words = letters.split(|letter| *letter == SPACE);
        for word in words.filter(|word| !word.is_empty()) {
            let word: Label = word.iter().copied().fold(Label::default(), Label::push);
            let last = lines.pop().unwrap_or_default();
            let longer = match last.0.is_empty() {
                true => word.clone(),
                false => last.clone().push(SPACE).and_label(word.clone()),
            };
            if fits(&longer) {
                lines.push(longer);
                continue;
            }
            lines.push(last);
            let mut line = Label::default();
            for letter in word.letters() {
                let longer = line.clone().push(letter);
                if !line.0.is_empty() && !fits(&longer) {
                    lines.push(std::mem::take(&mut line));
                }
                line = line.push(letter);
            }
            lines.push(line);
        }
        lines.retain(|line| !line.0.is_empty());
        lines
    }

    /// Its pieces of letters that are set in the same way, in the frame that it takes at a size.
    pub fn pieces(&self, size: f64, frame: Rectangle) -> Vec<TextPiece> {
        let letters: Vec<Letter> = self.letters().collect();
        let mut left = frame.left;
        let base = frame.top + ASCENT * size;
        let groups = letters.chunk_by(|one, other| one.0 == other.0);
        let piece = |group: &[Letter]| {
            let set = group[0].0;
            let (scale, rise) = set.size_and_rise();
            let advance = group.iter().map(|(_, letter)| set.font().advance(*letter));
            let at = [left, base - rise * size];
            left += advance.sum::<f64>() * scale * size;
            TextPiece {
                text: group.iter().map(|(_, letter)| *letter).collect(),
                at,
                size: scale * size,
                is_slanted: set == Set::Slanted,
            }
        };
        groups.map(piece).collect()
    }

    /// The frame that the label takes at a size and a place, and its outlines in one path: none if there is
    /// nothing to see.
    pub fn set(&self, size: f64, [x, y]: [f64; 2], anchor: Pos) -> (Rectangle, Option<Path>) {
        let width = self.width(size);
        let left = match anchor.h_pos {
            HPos::Left => x,
            HPos::Center => x - 0.5 * width,
            HPos::Right => x - width,
        };
        let base = match anchor.v_pos {
            VPos::Top => y + ASCENT * size,
            VPos::Center => y + MIDDLE * size,
            VPos::Bottom => y - DESCENT * size,
        };
        let frame = Rectangle::new([left, base - ASCENT * size], [width, line_height(size)]);
        let mut outline = Outline {
            path: PathBuilder::new(),
            origin: [left, base],
            scale: 0.0,
        };
        for (set, character) in self.letters() {
            let (scale, rise) = set.size_and_rise();
            let font = set.font();
            outline.scale = scale * size / font.units_per_size;
            outline.origin[1] = base - rise * size;
            // Nothing is drawn where there is nothing to see, such as a space.
            let glyph = font.glyph(character);
            font.face.outline_glyph(glyph, &mut outline);
            outline.origin[0] += font.advance(character) * scale * size;
        }
        (frame, outline.path.finish())
    }
}

/// Letters of one size.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TextPiece {
    pub text: String,
    /// Where they begin, on their base line.
    pub at: [f64; 2],
    pub size: f64,
    pub is_slanted: bool,
}

/// A character and how it is set.
type Letter = (Set, char);

const SPACE: Letter = (Set::Upright, ' ');

/// The height of a line of text.
pub(super) fn line_height(size: f64) -> f64 {
    (ASCENT + DESCENT) * size
}

/// Takes the outlines of glyphs into a path.
struct Outline {
    path: PathBuilder,
    origin: [f64; 2],
    scale: f64,
}

impl Outline {
    fn place(&self, x: f32, y: f32) -> (f32, f32) {
        let [left, base] = self.origin;
        let (x, y) = (self.scale * f64::from(x), self.scale * f64::from(y));
        ((left + x) as f32, (base - y) as f32)
    }
}

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.place(x1, y1), self.place(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2)) = (self.place(x1, y1), self.place(x2, y2));
        let (x, y) = self.place(x, y);
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn energy() -> Label {
        Label::symbol("λ")
            .below("nem")
            .and_symbol("E")
            .below("nem")
            .and(" / 10")
            .above("−4")
    }

    #[test]
    fn every_character_of_the_figures_has_a_glyph() {
        for font in [&UPRIGHT, &SLANTED] {
            for character in "tφωμλβηEABdxy∫−×·–…0123456789()/|√".chars() {
                assert!(font.face.glyph_index(character).is_some(), "{character}");
            }
        }
    }

    #[test]
    fn pieces_follow_each_other_on_their_base_lines() {
        let (label, size) = (energy(), 10.0);
        let at = [3.0, 5.0];
        let (frame, _) = label.set(size, at, Pos::new(HPos::Left, VPos::Top));
        let pieces = label.pieces(size, frame);
        let text: Vec<&str> = pieces.iter().map(|piece| &*piece.text).collect();
        assert_eq!(text, ["λ", "nem", "E", "nem", " / 10", "−4"]);
        let [first, index, .., last] = &pieces[..] else {
            panic!("six pieces");
        };
        assert_eq!(first.at, [3.0, 5.0 + ASCENT * size]);
        assert!(first.is_slanted && !index.is_slanted && index.size < size);
        assert!(index.at[1] > first.at[1] && last.at[1] < first.at[1]);
        let end = last.at[0] + Label::text("−4").width(last.size);
        assert!((end - frame.right).abs() < 1e-9);
    }

    #[test]
    fn all_ink_is_within_the_frame() {
        for label in [energy(), Label::text("Égy (j) |d| ∫φ"), Label::text("0.5")] {
            let middle = Pos::new(HPos::Center, VPos::Center);
            let (frame, outlines) = label.set(20.0, [100.0, 50.0], middle);
            let ink = outlines.expect("something to see").bounds();
            let [left, top, right, bottom] =
                [ink.left(), ink.top(), ink.right(), ink.bottom()].map(f64::from);
            // Glyphs may reach over their advance by a little, as slanted ones do.
            let slack = 0.08 * 20.0;
            assert!(
                left >= frame.left - slack && right <= frame.right + slack,
                "{ink:?}"
            );
            assert!(
                top >= frame.top && bottom <= frame.bottom,
                "{ink:?} in {frame:?}"
            );
        }
    }

    #[test]
    fn the_width_is_that_of_the_font() {
        // DejaVu Sans: the advance of a figure is 1303 of 2048.
        let width = Label::text("0123456789").width(2.048);
        assert!((width - 13.03).abs() < 1e-9, "{width}");
        let frame = |h_pos| {
            let (frame, _) = Label::text("00").set(10.0, [0.0; 2], Pos::new(h_pos, VPos::Top));
            [frame.left, frame.right, frame.top]
        };
        let width = Label::text("00").width(10.0);
        assert_eq!(frame(HPos::Left), [0.0, width, 0.0]);
        assert_eq!(frame(HPos::Right), [-width, 0.0, 0.0]);
    }

    #[test]
    fn what_is_too_wide_is_broken() {
        let long =
            Label::text("a scene with a name of many words andonethatisfarlongerthantheline");
        let lines = long.wrapped(10.0, 80.0);
        assert!(lines.len() > 3);
        assert!(lines.iter().all(|line| line.width(10.0) <= 80.0));
        let without_spaces = |label: &Label| label.plain().replace(' ', "");
        let text: String = lines.iter().map(without_spaces).collect();
        assert_eq!(text, without_spaces(&long), "nothing is lost");
        assert_eq!(energy().wrapped(10.0, 500.0), [energy()]);
        // What is set above stays there.
        let lines = energy().wrapped(10.0, 60.0);
        assert_eq!(
            lines.last(),
            Some(&Label::text("10").above("−4")),
            "{lines:?}"
        );
    }

    #[test]
    fn what_controls_is_a_space() {
        assert_eq!(Label::text("a\nb\0").plain(), "a b ");
        let marks: String = Set::ALL.map(Set::mark).into_iter().collect();
        assert_eq!(Label::text(&marks), Label::text("    "));
    }

    #[test]
    fn a_label_survives_being_a_string() {
        let string = String::from(energy());
        assert_eq!(Label::of_string(&string), energy());
        assert_eq!(energy().plain(), "λnemEnem / 10−4");
        let twice = Label::text("a ").and_label(energy()).and_label(energy());
        assert_eq!(twice.plain(), "a λnemEnem / 10−4λnemEnem / 10−4");
    }
}
