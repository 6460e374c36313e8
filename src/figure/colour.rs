//! Colours, and the maps from values to them.

use colorous::Color;
use plotters::style::RGBColor;

/// The colour of what is no number.
pub(super) const GREY: RGBColor = RGBColor(110, 110, 110);

/// The colours of lines, by Okabe and Ito, which people tell apart however they see colours.
pub(super) const LINE_COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
];

/// How the values of a field become colours, perceptually uniform. All are bright enough for black
/// lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColourMap {
    /// Blue below zero and red above, nearly white between: hues that the colour-blind tell apart.
    #[default]
    BlueRed,
    /// As that, in purple and orange.
    PurpleOrange,
    /// From green-blue to yellow (viridis without its dark end).
    Viridis,
    /// Without hue, growing brighter.
    Grey,
    /// Without hue, growing darker: ink on paper.
    Ink,
}

/// The middle of a diverging map.
const MIDDLE_LIGHTNESS: f64 = 0.975;
/// Its ends, of the same lightness and strength both: light enough for black lines.
const END_LIGHTNESS: f64 = 0.73;
const END_CHROMA: f64 = 0.105;
/// Steps from end to end: more than colours have.
const STEPS: usize = 512;

impl ColourMap {
    /// The colour at a share of the way from the middle to an end, from −1 to 1.
    fn at(self, share: f64) -> RGBColor {
        let lightness = |share: f64| MIDDLE_LIGHTNESS + share * (END_LIGHTNESS - MIDDLE_LIGHTNESS);
        // Below and above zero, in degrees.
        let diverging = |[below, above]: [f64; 2]| {
            let hue = if share < 0.0 { below } else { above };
            perceptual(lightness(share.abs()), END_CHROMA * share.abs(), hue)
        };
        match self {
            ColourMap::BlueRed => diverging([245.0, 35.0]),
            ColourMap::PurpleOrange => diverging([305.0, 65.0]),
            ColourMap::Viridis => viridis(0.5 * (1.0 + share)),
            ColourMap::Grey => perceptual(lightness(0.5 * (1.0 - share)), 0.0, 0.0),
            ColourMap::Ink => perceptual(lightness(0.5 * (1.0 + share)), 0.0, 0.0),
        }
    }
}

/// Viridis from 0 to 1, but not from its dark end, on which black lines are lost.
fn viridis(share: f64) -> RGBColor {
    let Color { r, g, b } = colorous::VIRIDIS.eval_continuous(0.25 + 0.75 * share);
    RGBColor(r, g, b)
}

/// The colour of a lightness, a strength and a hue in Oklab, where equal steps look equal
/// (B. Ottosson, "A perceptual color space for image processing", 2020).
fn perceptual(lightness: f64, chroma: f64, hue: f64) -> RGBColor {
    let (sin, cos) = hue.to_radians().sin_cos();
    let (a, b) = (chroma * cos, chroma * sin);
    let cone = |of_a: f64, of_b: f64| (lightness + of_a * a + of_b * b).powi(3);
    let l = cone(0.396_337_777_4, 0.215_803_757_3);
    let m = cone(-0.105_561_345_8, -0.063_854_172_8);
    let s = cone(-0.089_484_177_5, -1.291_485_548_0);
    let linear = [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ];
    // The curve of sRGB; what the screen cannot show is cut off.
    let encoded = |value: f64| match value {
        value if value <= 0.003_130_8 => 12.92 * value,
        value => 1.055 * value.powf(1.0 / 2.4) - 0.055,
    };
    let [r, g, b] = linear.map(|value| (255.0 * encoded(value)).round().clamp(0.0, 255.0) as u8);
    RGBColor(r, g, b)
}

/// Colours for the values from −`bound` to `bound`, or from 0 where nothing can be negative.
#[derive(Debug, Clone)]
pub(super) struct Scale {
    low: f64,
    high: f64,
    colours: Vec<RGBColor>,
}

impl Scale {
    /// Diverging, its middle at 0.
    pub fn signed(map: ColourMap, bound: f64) -> Scale {
        Scale::around(0.0, map, bound)
    }

    /// Diverging, from `middle` − `bound` to `middle` + `bound`.
    pub fn around(middle: f64, map: ColourMap, bound: f64) -> Scale {
        let ends = [middle - bound, middle + bound];
        Scale::new(ends, |share| map.at(2.0 * share - 1.0))
    }

    /// From 0 up, growing brighter.
    pub fn unsigned(bound: f64) -> Scale {
        Scale::new([0.0, bound], viridis)
    }

    /// From one value to another, growing brighter.
    pub fn between(ends: [f64; 2]) -> Scale {
        Scale::new(ends, viridis)
    }

    /// With a colour for each share of the way from the low end to the high one.
    fn new([low, high]: [f64; 2], colour: impl Fn(f64) -> RGBColor) -> Scale {
        let shares = (0..=STEPS).map(|step| step as f64 / STEPS as f64);
        let colours = shares.map(colour).collect();
        Scale { low, high, colours }
    }

    /// The values at its ends.
    pub fn range(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// The colour of a value; what lies beyond an end has that end's, what is no number is grey.
    pub fn at(&self, value: f64) -> RGBColor {
        if value.is_nan() {
            return GREY;
        }
        let share = ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        let last = self.colours.len() - 1;
        // Within the table: the share is in [0, 1].
        self.colours[(share * last as f64).round() as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance(RGBColor(r, g, b): RGBColor) -> f64 {
        let linear = |channel: u8| (f64::from(channel) / 255.0).powf(2.2);
        0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)
    }

    #[test]
    fn zero_is_nearly_white_and_either_side_grows_darker() {
        for map in [ColourMap::BlueRed, ColourMap::PurpleOrange] {
            let scale = Scale::signed(map, 2.0);
            let at = |value: f64| luminance(scale.at(value));
            assert!(at(0.0) > 0.9, "{}", at(0.0));
            for step in 0..20 {
                let (near, far) = (0.1 * f64::from(step), 0.1 * f64::from(step + 1));
                assert!(at(near) > at(far) && at(-near) > at(-far), "{near}");
                // What is as far from zero looks as far.
                assert!(
                    (at(far) - at(-far)).abs() < 0.06,
                    "{far}: {} {}",
                    at(far),
                    at(-far)
                );
            }
            // Black lines are legible on the ends: contrast of at least 4.5 to 1.
            for end in [-2.0, 2.0] {
                assert!((at(end) + 0.05) / 0.05 > 4.5, "{}", at(end));
            }
        }
    }

    #[test]
    fn the_others_grow_brighter_or_darker_and_bear_black_lines() {
        for (map, sign) in [
            (ColourMap::Viridis, 1.0),
            (ColourMap::Grey, 1.0),
            (ColourMap::Ink, -1.0),
        ] {
            let scale = Scale::around(1.0, map, 0.5);
            assert_eq!(scale.range(), [0.5, 1.5]);
            let at = |step: i32| luminance(scale.at(1.0 + 0.05 * f64::from(step)));
            for step in -10..10 {
                assert!(sign * (at(step + 1) - at(step)) > 0.0, "{map:?} {step}");
            }
            let darkest = at(-10).min(at(10));
            assert!((darkest + 0.05) / 0.05 > 2.0, "{map:?} {darkest}");
        }
    }

    #[test]
    fn signs_differ_in_blue_against_red() {
        let scale = Scale::signed(ColourMap::BlueRed, 1.0);
        let (RGBColor(r, _, b), RGBColor(red, _, blue)) = (scale.at(-1.0), scale.at(1.0));
        assert!(b > r && red > blue);
    }

    #[test]
    fn beyond_the_ends_the_colour_stays_and_no_number_is_grey() {
        let scale = Scale::signed(ColourMap::BlueRed, 1.0);
        assert_eq!(scale.at(1e300), scale.at(1.0));
        assert_eq!(scale.at(f64::NEG_INFINITY), scale.at(-1.0));
        assert_eq!(scale.at(f64::NAN), GREY);
        let scale = Scale::unsigned(1.0);
        assert!(luminance(scale.at(0.0)) < luminance(scale.at(1.0)));
    }
}
