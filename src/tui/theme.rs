//! Colours and glyphs for what the terminal can show. The colours of text are never forced: text is
//! in the terminal's own colour, on its own background, and what is set apart has a colour of middle
//! luminance, legible on dark and on light.

use std::borrow::Cow;

use ratatui::style::{Color, Modifier, Style};

use super::colour_map::{COLOUR_MAPS, ColourMap, LEVELS, luminance, palette_rgb};
use super::glyphs::{ASCII, Glyphs, Parts, UNICODE, spelt};

/// How many colours a terminal shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ColorTier {
    /// 24 bits.
    True,
    /// The palette of 256.
    Palette,
    /// The 16 of the terminal's own theme.
    Basic,
    /// None: glyphs alone.
    None,
}

/// What a colour is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// What has the focus; links a title to the eye.
    Accent,
    /// Runs; is as it should be.
    Good,
    /// Waits, is paused, or needs attention.
    Warning,
    /// Wrong.
    Bad,
    /// The total of the energies.
    Total,
    /// A curve of its own: the number counts through the colours there are.
    Curve(usize),
}

/// Colours and glyphs.
#[derive(Debug, Clone)]
pub struct Theme {
    /// How many colours.
    pub tier: ColorTier,
    /// Whether more than ASCII may be written.
    pub unicode: bool,
    /// What lines are drawn with, where more than ASCII may be written.
    parts: Parts,
}

/// A colour in every tier: 24 bits, number in the palette of 256, one of the 16.
type Shade = ([u8; 3], u8, Color);

const ACCENT: Shade = ([0x4f, 0x8c, 0xd6], 68, Color::Cyan);
const GOOD: Shade = ([0x2f, 0x95, 0x4e], 65, Color::Green);
const WARNING: Shade = ([0xb8, 0x86, 0x1f], 136, Color::Yellow);
const BAD: Shade = ([0xdb, 0x4f, 0x4f], 167, Color::Red);
const CURVES: [Shade; 6] = [
    ([0x17, 0x94, 0x8b], 30, Color::Green),
    ([0xb8, 0x86, 0x1f], 136, Color::Yellow),
    ([0x9b, 0x6d, 0xd3], 98, Color::Magenta),
    ([0xdb, 0x66, 0x2a], 166, Color::Red),
    ([0xcc, 0x5f, 0x9e], 168, Color::Magenta),
    ([0x6f, 0x8f, 0x2a], 64, Color::Green),
];
const MUTED: Shade = ([0x86, 0x86, 0x86], 244, Color::Reset);

impl Theme {
    /// The theme for given capabilities.
    pub fn new(tier: ColorTier, unicode: bool) -> Self {
        Self {
            tier,
            unicode,
            parts: Parts::default(),
        }
    }

    /// The same with lines drawn in this way.
    pub fn with_parts(self, parts: Parts) -> Self {
        Self { parts, ..self }
    }

    /// The parts of a cell that lines are drawn with; `None`: a cell has no parts.
    pub fn parts(&self) -> Option<Parts> {
        self.unicode.then_some(self.parts)
    }

    /// What the environment says (`variable` looks one up), unless a tier is asked for.
    pub fn detect(asked: Option<ColorTier>, variable: impl Fn(&str) -> Option<String>) -> Self {
        let tier = asked.unwrap_or_else(|| detect_tier(&variable));
        Self::new(tier, is_unicode(&variable))
    }

    /// The characters to draw with.
    pub fn glyphs(&self) -> &'static Glyphs {
        if self.unicode { &UNICODE } else { &ASCII }
    }

    /// The Greek word where it can be shown, the spelt one where not.
    pub fn word<'a>(&self, unicode: &'a str, ascii: &'a str) -> &'a str {
        if self.unicode { unicode } else { ascii }
    }

    /// Words as they can be shown: with their signs, or spelt out in ASCII.
    pub fn spelt<'a>(&self, words: &'a str) -> Cow<'a, str> {
        if self.unicode {
            Cow::Borrowed(words)
        } else {
            spelt(words)
        }
    }

    fn shade(&self, (rgb, palette, basic): Shade) -> Color {
        match self.tier {
            ColorTier::True => Color::Rgb(rgb[0], rgb[1], rgb[2]),
            ColorTier::Palette => Color::Indexed(palette),
            ColorTier::Basic => basic,
            ColorTier::None => Color::Reset,
        }
    }

    /// The colour for a purpose.
    pub fn colour(&self, role: Role) -> Color {
        self.shade(match role {
            Role::Accent | Role::Total => ACCENT,
            Role::Good => GOOD,
            Role::Warning => WARNING,
            Role::Bad => BAD,
            Role::Curve(number) => CURVES[number % CURVES.len()],
        })
    }

    /// Text for a purpose.
    pub fn style(&self, role: Role) -> Style {
        Style::default().fg(self.colour(role))
    }

    /// Text of less weight: units, axes, what is known anyway.
    pub fn muted(&self) -> Style {
        match self.tier {
            ColorTier::True | ColorTier::Palette => Style::default().fg(self.shade(MUTED)),
            ColorTier::Basic | ColorTier::None => Style::default().add_modifier(Modifier::DIM),
        }
    }

    /// Text of more weight.
    pub fn strong(&self) -> Style {
        Style::default().add_modifier(Modifier::BOLD)
    }

    /// A word on a ground of its colour.
    pub fn pill(&self, role: Role) -> Style {
        self.style(role)
            .add_modifier(Modifier::REVERSED | Modifier::BOLD)
    }

    /// A curve that has no colour of its own.
    pub fn curve(&self) -> Color {
        self.shade(MUTED)
    }

    /// The colour map that the view counts to.
    pub fn map(&self, count: usize) -> &'static ColourMap {
        &COLOUR_MAPS[count % COLOUR_MAPS.len()]
    }

    /// Whether fields are shown by colours; if not, by a ramp of glyphs.
    pub fn paints(&self) -> bool {
        matches!(self.tier, ColorTier::True | ColorTier::Palette)
    }

    /// The colour of a level of a map, where fields are painted.
    pub fn level(&self, map: &ColourMap, level: usize) -> Color {
        let level = level.min(LEVELS - 1);
        match self.tier {
            ColorTier::True => {
                let [red, green, blue] = map.rgb[level];
                Color::Rgb(red, green, blue)
            }
            ColorTier::Palette => Color::Indexed(map.palette[level]),
            ColorTier::Basic | ColorTier::None => Color::Reset,
        }
    }

    /// The colour of the contour φ = 0 over a map.
    pub fn contour(&self, map: &ColourMap) -> Color {
        self.shade((map.contour, map.contour_palette, Color::Red))
    }

    /// Ink on a level of a map, where fields are painted: dark on bright and bright on dark.
    pub fn ink(&self, map: &ColourMap, level: usize) -> Color {
        let level = level.min(LEVELS - 1);
        let rgb = match self.tier {
            ColorTier::Palette => palette_rgb(map.palette[level]).unwrap_or(map.rgb[level]),
            _ => map.rgb[level],
        };
        // At this luminance black and white have the same contrast.
        if luminance(rgb) > 0.18 {
            self.shade(([0x14, 0x1c, 0x28], 234, Color::Reset))
        } else {
            self.shade(([0xf4, 0xf4, 0xf4], 255, Color::Reset))
        }
    }
}

/// How many colours the environment promises.
fn detect_tier(variable: &impl Fn(&str) -> Option<String>) -> ColorTier {
    let set = |name: &str| variable(name).filter(|value| !value.is_empty());
    let terminal = set("TERM").unwrap_or_default();
    if set("NO_COLOR").is_some() || terminal.is_empty() || terminal == "dumb" {
        return ColorTier::None;
    }
    // GNU screen takes COLORTERM over from the terminal around it and cannot do what it promises.
    let screen = terminal.starts_with("screen") && set("TMUX").is_none();
    let promise = set("COLORTERM").unwrap_or_default();
    let promised = matches!(promise.as_str(), "truecolor" | "24bit") && !screen;
    let names = ["kitty", "alacritty", "foot", "wezterm", "ghostty", "direct"];
    if promised || names.iter().any(|name| terminal.contains(name)) {
        return ColorTier::True;
    }
    if terminal.contains("256") {
        return ColorTier::Palette;
    }
    let without = |name: &&str| terminal.starts_with(name);
    if ["vt1", "vt2", "vt3", "vt4", "vt5"].iter().any(without) {
        return ColorTier::None;
    }
    ColorTier::Basic
}

/// Whether the locale is one of UTF-8; LC_ALL is over LC_CTYPE, that over LANG.
fn is_unicode(variable: &impl Fn(&str) -> Option<String>) -> bool {
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"]
        .iter()
        .find_map(|name| variable(name).filter(|value| !value.is_empty()))
        .unwrap_or_default()
        .to_ascii_lowercase();
    locale.contains("utf-8") || locale.contains("utf8")
}

#[cfg(test)]
mod tests {
    use super::super::colour_map::contrast;
    use super::*;

    fn detect(variables: &[(&str, &str)]) -> Theme {
        let look_up = |name: &str| {
            let found = variables.iter().find(|(key, _)| *key == name);
            found.map(|(_, value)| (*value).to_owned())
        };
        Theme::detect(None, look_up)
    }

    #[test]
    fn the_environment_tells_the_tier() {
        use ColorTier::{Basic, None, Palette, True};
        let table: &[(&[(&str, &str)], ColorTier)] = &[
            (&[], None),
            (&[("TERM", "")], None),
            (&[("TERM", "dumb")], None),
            (&[("TERM", "dumb"), ("COLORTERM", "truecolor")], None),
            (&[("TERM", "xterm-256color")], Palette),
            (
                &[("TERM", "xterm-256color"), ("COLORTERM", "truecolor")],
                True,
            ),
            (&[("TERM", "xterm-256color"), ("COLORTERM", "24bit")], True),
            (&[("TERM", "xterm-256color"), ("COLORTERM", "yes")], Palette),
            (&[("TERM", "xterm-256color"), ("COLORTERM", "")], Palette),
            (&[("TERM", "xterm-256color"), ("NO_COLOR", "1")], None),
            (&[("TERM", "xterm-256color"), ("NO_COLOR", "")], Palette),
            (
                &[
                    ("TERM", "xterm"),
                    ("COLORTERM", "truecolor"),
                    ("NO_COLOR", "1"),
                ],
                None,
            ),
            (&[("TERM", "xterm")], Basic),
            (&[("TERM", "linux")], Basic),
            (&[("TERM", "screen")], Basic),
            (&[("TERM", "vt100")], None),
            (&[("TERM", "vt220")], None),
            (&[("TERM", "xterm-kitty")], True),
            (&[("TERM", "xterm-direct")], True),
            (&[("TERM", "tmux-256color")], Palette),
            (
                &[("TERM", "screen-256color"), ("COLORTERM", "truecolor")],
                Palette,
            ),
            (
                &[
                    ("TERM", "screen-256color"),
                    ("COLORTERM", "truecolor"),
                    ("TMUX", "x"),
                ],
                True,
            ),
        ];
        for (variables, tier) in table {
            assert_eq!(detect(variables).tier, *tier, "{variables:?}");
        }
        let asked = Theme::detect(Some(Basic), |_| Some("dumb".to_owned()));
        assert_eq!(asked.tier, Basic);
    }

    #[test]
    fn the_locale_tells_whether_more_than_ascii_can_be_shown() {
        let table: &[(&[(&str, &str)], bool)] = &[
            (&[], false),
            (&[("LANG", "C")], false),
            (&[("LANG", "C.UTF-8")], true),
            (&[("LANG", "de_DE.utf8")], true),
            (&[("LANG", "de_DE.ISO-8859-1")], false),
            (&[("LANG", "C"), ("LC_CTYPE", "C.UTF-8")], true),
            (&[("LANG", "C.UTF-8"), ("LC_CTYPE", "POSIX")], false),
            (&[("LC_CTYPE", "C.UTF-8"), ("LC_ALL", "C")], false),
            (&[("LC_CTYPE", "C"), ("LC_ALL", "en_US.UTF-8")], true),
            (&[("LANG", "C.UTF-8"), ("LC_ALL", "")], true),
        ];
        for (variables, unicode) in table {
            assert_eq!(detect(variables).unicode, *unicode, "{variables:?}");
        }
    }

    #[test]
    fn what_is_set_apart_is_legible_on_dark_and_on_light() {
        let shades = [ACCENT, GOOD, WARNING, BAD, MUTED];
        for (rgb, number, _) in shades.iter().chain(&CURVES) {
            let palette = palette_rgb(*number).expect("not one of the user's own");
            for colour in [*rgb, palette] {
                for ground in [[0; 3], [255; 3], [0x10, 0x10, 0x14], [0xfa, 0xfa, 0xf5]] {
                    let contrast = contrast(colour, ground);
                    assert!(
                        contrast >= 2.9,
                        "{colour:?} {number} on {ground:?}: {contrast}"
                    );
                }
            }
        }
    }

    #[test]
    fn ink_is_legible_on_every_level_of_every_map() {
        let rgb = |colour| match colour {
            Color::Rgb(red, green, blue) => [red, green, blue],
            Color::Indexed(number) => palette_rgb(number).expect("16 on"),
            other => unreachable!("{other} in a tier that paints"),
        };
        for tier in [ColorTier::True, ColorTier::Palette] {
            let theme = Theme::new(tier, true);
            for map in &COLOUR_MAPS {
                for level in 0..LEVELS {
                    let ground = rgb(theme.level(map, level));
                    let contrast = contrast(rgb(theme.ink(map, level)), ground);
                    assert!(contrast > 3.5, "{} {level}: {contrast}", map.name);
                }
            }
        }
    }

    #[test]
    fn without_colours_none_is_set() {
        let theme = Theme::new(ColorTier::None, true);
        for role in [Role::Accent, Role::Good, Role::Bad, Role::Curve(9)] {
            assert_eq!(theme.style(role).fg, Some(Color::Reset));
        }
        assert_eq!(theme.muted().fg, None);
    }
}
