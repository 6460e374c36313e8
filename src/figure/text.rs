//! Text as outlines, from fonts in the program.
//!
//! A picture's text is drawn as filled outlines, in PNG and SVG alike: neither making a picture nor
//! looking at it needs a font on the machine, and what is measured here is what is seen.

use super::drawing::Rectangle;
use std::sync::LazyLock;
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
/// A curve of an outline is drawn with so many straight pieces.
const PIECES: usize = 6;

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

/// How a piece of a label is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Set {
    Upright,
    Slanted,
    Below,
    Above,
}

impl Set {
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
/// Symbols are slanted, indices upright, as print has them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Label {
    pieces: Vec<(Set, String)>,
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
    pub fn and_label(mut self, label: Label) -> Label {
        self.pieces.extend(label.pieces);
        self
    }

    fn with(mut self, set: Set, text: &str) -> Label {
        let visible = |c: char| if c.is_control() { ' ' } else { c };
        let text: String = text.chars().map(visible).collect();
        if !text.is_empty() {
            self.pieces.push((set, text));
        }
        self
    }

    /// The text without its setting.
    pub fn plain(&self) -> String {
        self.pieces.iter().map(|(_, text)| text.as_str()).collect()
    }

    /// The width at a size.
    pub fn width(&self, size: f64) -> f64 {
        let width = |(set, text): &(Set, String)| {
            let advances: f64 = text.chars().map(|c| set.font().advance(c)).sum();
            advances * set.size_and_rise().0
        };
        size * self.pieces.iter().map(width).sum::<f64>()
    }

    /// The lines of a label that is to be no wider than `width`: broken at spaces, and where a
    /// word is too wide, within it.
    pub fn wrapped(&self, size: f64, width: f64) -> Vec<Label> {
        let fits = |letters: &[Letter]| Label::of(letters).width(size) <= width;
        let letters: Vec<Letter> = self
            .pieces
            .iter()
            .flat_map(|(set, text)| text.chars().map(|character| (*set, character)))
            .collect();
        if fits(&letters) {
            return vec![self.clone()];
        }
        let mut lines: Vec<Vec<Letter>> = vec![Vec::new()];
        for word in letters
            .split(|letter| *letter == SPACE)
            .filter(|word| !word.is_empty())
        {
            let last = lines.last().map_or(&[][..], Vec::as_slice);
            let longer = match last {
                [] => word.to_vec(),
                line => [line, &[SPACE], word].concat(),
            };
            if fits(&longer) {
                lines.pop();
                lines.push(longer);
                continue;
            }
            let mut line = Vec::new();
            for &letter in word {
                line.push(letter);
                if line.len() > 1 && !fits(&line) {
                    line.pop();
                    lines.push(std::mem::replace(&mut line, vec![letter]));
                }
            }
            lines.push(line);
        }
        lines.retain(|line| !line.is_empty());
        lines.iter().map(|line| Label::of(line)).collect()
    }

    fn of(letters: &[Letter]) -> Label {
        let same_set = letters.chunk_by(|(a, _), (b, _)| a == b);
        let pieces = same_set.map(|piece| (piece[0].0, piece.iter().map(|(_, c)| c).collect()));
        Label {
            pieces: pieces.collect(),
        }
    }
}

/// A character and how it is set.
type Letter = (Set, char);

const SPACE: Letter = (Set::Upright, ' ');

/// The height of a line of text.
pub(super) fn line_height(size: f64) -> f64 {
    (ASCENT + DESCENT) * size
}

/// Where a label stands to a point, horizontally.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Across {
    /// It begins there.
    Left,
    /// It is centred there.
    Middle,
    /// It ends there.
    Right,
}

/// Where a label stands to a point, vertically.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Along {
    /// Its top is there.
    Top,
    /// The middle of its figures is there.
    Middle,
}

/// Sets a label: the frame that it takes, and its outlines, closed curves in one.
pub(super) fn set_label(
    label: &Label,
    size: f64,
    [x, y]: [f64; 2],
    across: Across,
    along: Along,
) -> (Rectangle, Vec<Vec<[f64; 2]>>) {
    let width = label.width(size);
    let left = match across {
        Across::Left => x,
        Across::Middle => x - 0.5 * width,
        Across::Right => x - width,
    };
    // Figures are 0.73 sizes high.
    let base = match along {
        Along::Top => y + ASCENT * size,
        Along::Middle => y + 0.365 * size,
    };
    let frame = Rectangle {
        left,
        top: base - ASCENT * size,
        right: left + width,
        bottom: base + DESCENT * size,
    };
    let mut outlines = Vec::new();
    let mut pen = left;
    for (set, text) in &label.pieces {
        let (scale, rise) = set.size_and_rise();
        let font = set.font();
        for character in text.chars() {
            let mut outline = Outline {
                origin: [pen, base - rise * size],
                scale: scale * size / font.units_per_size,
                curves: &mut outlines,
            };
            // Nothing is drawn where there is nothing to see, such as a space.
            font.face.outline_glyph(font.glyph(character), &mut outline);
            pen += font.advance(character) * scale * size;
        }
    }
    (frame, outlines)
}

/// Takes the outline of a glyph as polygons.
struct Outline<'a> {
    origin: [f64; 2],
    scale: f64,
    curves: &'a mut Vec<Vec<[f64; 2]>>,
}

impl Outline<'_> {
    fn place(&self, x: f32, y: f32) -> [f64; 2] {
        [
            self.origin[0] + self.scale * f64::from(x),
            self.origin[1] - self.scale * f64::from(y),
        ]
    }

    fn last(&self) -> [f64; 2] {
        let last = self.curves.last().and_then(|curve| curve.last());
        last.copied().unwrap_or(self.origin)
    }

    fn push(&mut self, point: [f64; 2]) {
        if let Some(curve) = self.curves.last_mut() {
            curve.push(point);
        }
    }

    /// A Bézier curve, by repeated interpolation.
    fn bend(&mut self, controls: &[[f64; 2]]) {
        for piece in 1..=PIECES {
            let share = piece as f64 / PIECES as f64;
            let mut points = controls.to_vec();
            while points.len() > 1 {
                let between = |pair: &[[f64; 2]]| {
                    [0, 1].map(|axis| pair[0][axis] + share * (pair[1][axis] - pair[0][axis]))
                };
                points = points.windows(2).map(between).collect();
            }
            self.push(points[0]);
        }
    }
}

impl OutlineBuilder for Outline<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let start = self.place(x, y);
        self.curves.push(vec![start]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.push(self.place(x, y));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let controls = [self.last(), self.place(x1, y1), self.place(x, y)];
        self.bend(&controls);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let [second, third, end] = [self.place(x1, y1), self.place(x2, y2), self.place(x, y)];
        let controls = [self.last(), second, third, end];
        self.bend(&controls);
    }

    fn close(&mut self) {}
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
    fn all_ink_is_within_the_frame() {
        for label in [energy(), Label::text("Égy (j) |d| ∫φ"), Label::text("0.5")] {
            let (frame, outlines) =
                set_label(&label, 20.0, [100.0, 50.0], Across::Middle, Along::Middle);
            assert!(!outlines.is_empty());
            // Glyphs may reach over their advance by a little, as slanted ones do.
            let slack = 0.08 * 20.0;
            for [x, y] in outlines.into_iter().flatten() {
                assert!(x >= frame.left - slack && x <= frame.right + slack, "{x}");
                assert!(y >= frame.top && y <= frame.bottom, "{y} in {frame:?}");
            }
        }
    }

    #[test]
    fn the_width_is_that_of_the_font() {
        // DejaVu Sans: the advance of a figure is 1303 of 2048.
        let width = Label::text("0123456789").width(2.048);
        assert!((width - 13.03).abs() < 1e-9, "{width}");
        let frame = |across| {
            let (frame, _) = set_label(&Label::text("00"), 10.0, [0.0; 2], across, Along::Top);
            [frame.left, frame.right, frame.top]
        };
        let width = Label::text("00").width(10.0);
        assert_eq!(frame(Across::Left), [0.0, width, 0.0]);
        assert_eq!(frame(Across::Right), [-width, 0.0, 0.0]);
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
    }
}
