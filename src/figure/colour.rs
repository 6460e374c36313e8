//! Colours, and the maps from values to them.

use colorous::Gradient;

/// A colour of the screen: red, green, blue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Colour(pub [u8; 3]);

impl Colour {
    pub const BLACK: Colour = Colour([0, 0, 0]);
    pub const GREY: Colour = Colour([110, 110, 110]);
}

/// The colours of lines, by Okabe and Ito, which people tell apart however they see colours.
pub(super) const LINE_COLOURS: [Colour; 6] = [
    Colour([0, 114, 178]),
    Colour([213, 94, 0]),
    Colour([0, 158, 115]),
    Colour([204, 121, 167]),
    Colour([86, 180, 233]),
    Colour([230, 159, 0]),
];

/// How the values of a field become colours. Both are legible to the colour-blind and have their
/// white at zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColourMap {
    /// Blue below, red above.
    #[default]
    BlueRed,
    /// Purple below, orange above.
    PurpleOrange,
}

/// How much of a map is used on either side of its middle: its ends are so dark that nothing could
/// be read on them.
const REACH: f64 = 0.5;
/// Steps from the middle to either end: more than colours have.
const STEPS: usize = 256;

/// Colours for the values from −`bound` to `bound`, or from 0 where nothing can be negative.
#[derive(Debug, Clone)]
pub(super) struct Scale {
    low: f64,
    high: f64,
    colours: Vec<Colour>,
}

impl Scale {
    /// Diverging, its middle at 0.
    pub fn signed(map: ColourMap, bound: f64) -> Scale {
        let gradient = match map {
            ColourMap::BlueRed => colorous::RED_BLUE,
            ColourMap::PurpleOrange => colorous::PURPLE_ORANGE,
        };
        // Both run from what is to be above to what is to be below.
        let place = |share: f64| match map {
            ColourMap::BlueRed => 0.5 - 0.5 * REACH * share,
            ColourMap::PurpleOrange => 0.5 + 0.5 * REACH * share,
        };
        let colours = (0..=2 * STEPS)
            .map(|step| colour(gradient, place(step as f64 / STEPS as f64 - 1.0)))
            .collect();
        Scale {
            low: -bound,
            high: bound,
            colours,
        }
    }

    /// From 0 up, growing brighter.
    pub fn unsigned(bound: f64) -> Scale {
        let colours = (0..=2 * STEPS)
            .map(|step| {
                let share = step as f64 / (2 * STEPS) as f64;
                colour(colorous::VIRIDIS, 0.2 + 0.8 * share)
            })
            .collect();
        Scale {
            low: 0.0,
            high: bound,
            colours,
        }
    }

    /// The values at its ends.
    pub fn range(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// The colour of a value; what lies beyond an end has that end's, what is no number is grey.
    pub fn at(&self, value: f64) -> Colour {
        if value.is_nan() {
            return Colour::GREY;
        }
        let share = ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        let last = self.colours.len() - 1;
        // Within the table: the share is in [0, 1].
        self.colours[(share * last as f64).round() as usize]
    }
}

fn colour(gradient: Gradient, place: f64) -> Colour {
    let colour = gradient.eval_continuous(place);
    Colour([colour.r, colour.g, colour.b])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance(Colour([r, g, b]): Colour) -> f64 {
        let linear = |channel: u8| (f64::from(channel) / 255.0).powf(2.2);
        0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)
    }

    #[test]
    fn zero_is_nearly_white_and_either_side_grows_darker() {
        for map in [ColourMap::BlueRed, ColourMap::PurpleOrange] {
            let scale = Scale::signed(map, 2.0);
            let at = |value: f64| luminance(scale.at(value));
            assert!(at(0.0) > 0.9);
            for step in 0..20 {
                let (near, far) = (0.1 * f64::from(step), 0.1 * f64::from(step + 1));
                assert!(at(near) >= at(far) && at(-near) >= at(-far));
            }
            // Black lines are legible on the ends: contrast of at least 4.5 to 1.
            for end in [-2.0, 2.0] {
                assert!((at(end) + 0.05) / 0.05 > 4.5, "{}", at(end));
            }
        }
    }

    #[test]
    fn signs_differ_in_blue_against_red() {
        let scale = Scale::signed(ColourMap::BlueRed, 1.0);
        let (Colour([r, _, b]), Colour([red, _, blue])) = (scale.at(-1.0), scale.at(1.0));
        assert!(b > r && red > blue);
    }

    #[test]
    fn beyond_the_ends_the_colour_stays_and_no_number_is_grey() {
        let scale = Scale::signed(ColourMap::BlueRed, 1.0);
        assert_eq!(scale.at(1e300), scale.at(1.0));
        assert_eq!(scale.at(f64::NEG_INFINITY), scale.at(-1.0));
        assert_eq!(scale.at(f64::NAN), Colour::GREY);
        let scale = Scale::unsigned(1.0);
        assert!(luminance(scale.at(0.0)) < luminance(scale.at(1.0)));
    }
}
