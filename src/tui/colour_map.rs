//! Colour maps: sixteen colours each, monotone in luminance, once for terminals of 24 bits and once,
//! chosen by eye and hand, out of the palette of 256, which is what most people see over SSH.

use crate::figure;

/// Levels that a field is quantised to before it is coloured: so few colours that most cells stay
/// what they were from one frame to the next.
pub const LEVELS: usize = 16;

/// A colour map.
#[derive(Debug, PartialEq)]
pub struct ColourMap {
    /// Its name.
    pub name: &'static str,
    /// The map of a saved figure that looks like it.
    pub figure: figure::ColourMap,
    /// Red, green and blue of each level.
    pub rgb: [[u8; 3]; LEVELS],
    /// The number in the palette of 256 of each level; 16 and above, since the first sixteen are the
    /// user's own.
    pub palette: [u8; LEVELS],
    /// The contour φ = 0 over it.
    pub contour: [u8; 3],
    /// The contour out of the palette.
    pub contour_palette: u8,
}

/// All maps; `View::colour_map` counts through them.
pub static COLOUR_MAPS: [ColourMap; 4] = [BLUE_AMBER, VIRIDIS, GREY, PAPER];

/// Blue below the middle, amber and cream above: two hues that fade into each other where the value
/// is nearly zero, and still monotone.
const BLUE_AMBER: ColourMap = ColourMap {
    name: "blue-amber",
    figure: figure::ColourMap::BlueRed,
    rgb: [
        [0x0e, 0x1a, 0x2b],
        [0x11, 0x27, 0x42],
        [0x12, 0x35, 0x5b],
        [0x19, 0x47, 0x73],
        [0x23, 0x5c, 0x8b],
        [0x36, 0x6e, 0x9b],
        [0x53, 0x79, 0x99],
        [0x6d, 0x84, 0x96],
        [0x98, 0x88, 0x75],
        [0xb1, 0x92, 0x6f],
        [0xca, 0x9c, 0x66],
        [0xdb, 0xab, 0x70],
        [0xe7, 0xbc, 0x82],
        [0xf1, 0xce, 0x9a],
        [0xf7, 0xe1, 0xbb],
        [0xfd, 0xf3, 0xdc],
    ],
    palette: [
        234, 235, 236, 238, 24, 25, 61, 67, 137, 173, 179, 215, 222, 223, 229, 230,
    ],
    contour: [0xe0, 0x4f, 0x2f],
    contour_palette: 166,
};

/// From violet to yellow, made to be read by everyone.
const VIRIDIS: ColourMap = ColourMap {
    name: "viridis",
    figure: figure::ColourMap::Viridis,
    rgb: [
        [0x44, 0x01, 0x54],
        [0x47, 0x1b, 0x69],
        [0x47, 0x2f, 0x7b],
        [0x41, 0x43, 0x86],
        [0x3a, 0x56, 0x8b],
        [0x31, 0x68, 0x8e],
        [0x2b, 0x78, 0x8e],
        [0x25, 0x88, 0x8d],
        [0x21, 0x98, 0x8a],
        [0x28, 0xa8, 0x83],
        [0x35, 0xb7, 0x79],
        [0x5a, 0xc5, 0x67],
        [0x7e, 0xd1, 0x52],
        [0xa8, 0xdb, 0x38],
        [0xd3, 0xe2, 0x29],
        [0xfd, 0xe7, 0x25],
    ],
    palette: [
        53, 54, 55, 24, 25, 60, 30, 31, 66, 36, 71, 77, 113, 148, 184, 220,
    ],
    contour: [0xff, 0x5f, 0x5f],
    contour_palette: 203,
};

/// Without hue, from dark to bright.
const GREY: ColourMap = ColourMap {
    name: "grey",
    figure: figure::ColourMap::Grey,
    rgb: [
        [0x12, 0x12, 0x12],
        [0x1e, 0x1e, 0x1e],
        [0x2b, 0x2b, 0x2b],
        [0x38, 0x38, 0x38],
        [0x46, 0x46, 0x46],
        [0x54, 0x54, 0x54],
        [0x62, 0x62, 0x62],
        [0x71, 0x71, 0x71],
        [0x81, 0x81, 0x81],
        [0x90, 0x90, 0x90],
        [0xa1, 0xa1, 0xa1],
        [0xb1, 0xb1, 0xb1],
        [0xc2, 0xc2, 0xc2],
        [0xd2, 0xd2, 0xd2],
        [0xe4, 0xe4, 0xe4],
        [0xf5, 0xf5, 0xf5],
    ],
    palette: [
        233, 234, 236, 237, 238, 240, 241, 243, 244, 246, 247, 249, 251, 252, 254, 255,
    ],
    contour: [0xe0, 0x4f, 0x2f],
    contour_palette: 166,
};

/// Ink on paper: bright outside, for bright backgrounds.
const PAPER: ColourMap = ColourMap {
    name: "paper",
    figure: figure::ColourMap::Ink,
    rgb: [
        [0xfa, 0xf8, 0xf2],
        [0xf0, 0xee, 0xe6],
        [0xe2, 0xe1, 0xdb],
        [0xd2, 0xd2, 0xcf],
        [0xc2, 0xc4, 0xc4],
        [0xb1, 0xb6, 0xb9],
        [0xa0, 0xa8, 0xae],
        [0x90, 0x9a, 0xa3],
        [0x80, 0x8c, 0x98],
        [0x70, 0x7e, 0x8c],
        [0x61, 0x70, 0x80],
        [0x52, 0x63, 0x74],
        [0x44, 0x55, 0x67],
        [0x37, 0x48, 0x5a],
        [0x2a, 0x3b, 0x4d],
        [0x1e, 0x2e, 0x40],
    ],
    palette: [
        255, 254, 253, 252, 251, 250, 249, 247, 246, 245, 243, 242, 240, 239, 237, 236,
    ],
    contour: [0xd7, 0x5f, 0x00],
    contour_palette: 166,
};

/// Red, green and blue of a number of the palette of 256, from 16 on; the first sixteen are the
/// user's own and have none.
pub fn palette_rgb(number: u8) -> Option<[u8; 3]> {
    const CUBE: [u8; 6] = [0, 95, 135, 175, 215, 255];
    match number {
        0..16 => None,
        16..232 => {
            let index = usize::from(number) - 16;
            Some([index / 36, index / 6 % 6, index % 6].map(|digit| CUBE[digit]))
        }
        232.. => Some([8 + 10 * (number - 232); 3]),
    }
}

/// Relative luminance of an sRGB colour, in [0, 1] (WCAG 2.1).
pub fn luminance(rgb: [u8; 3]) -> f64 {
    let [red, green, blue] = rgb.map(|channel| {
        let value = f64::from(channel) / 255.0;
        if value <= 0.04045 {
            value / 12.92
        } else {
            ((value + 0.055) / 1.055).powf(2.4)
        }
    });
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// Contrast of two colours, from 1 to 21 (WCAG 2.1).
#[cfg(test)]
pub fn contrast(one: [u8; 3], other: [u8; 3]) -> f64 {
    let (one, other) = (luminance(one) + 0.05, luminance(other) + 0.05);
    one.max(other) / one.min(other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_palette_is_the_one_of_terminals() {
        assert_eq!(palette_rgb(15), None);
        assert_eq!(palette_rgb(16), Some([0, 0, 0]));
        assert_eq!(palette_rgb(166), Some([215, 95, 0]));
        assert_eq!(palette_rgb(231), Some([255, 255, 255]));
        assert_eq!(palette_rgb(232), Some([8, 8, 8]));
        assert_eq!(palette_rgb(255), Some([238, 238, 238]));
        assert!((contrast([0, 0, 0], [255, 255, 255]) - 21.0).abs() < 1e-9);
    }

    #[test]
    fn every_map_is_strictly_monotone_in_luminance() {
        for map in &COLOUR_MAPS {
            let palette = map
                .palette
                .map(|number| palette_rgb(number).expect("16 on"));
            for ramp in [map.rgb, palette] {
                let bright = ramp.map(luminance);
                let upwards = bright[0] < bright[LEVELS - 1];
                for (level, pair) in bright.windows(2).enumerate() {
                    assert_eq!(pair[0] < pair[1], upwards, "{} at {level}", map.name);
                    assert_ne!(pair[0], pair[1], "{} at {level}", map.name);
                }
                let ends = contrast(ramp[0], ramp[LEVELS - 1]);
                assert!(ends > 8.0, "{}: {ends}", map.name);
            }
        }
    }

    #[test]
    fn the_contour_stands_out_from_both_sides() {
        for map in &COLOUR_MAPS {
            let palette = |number| palette_rgb(number).expect("16 on");
            let tiers = [
                (map.contour, map.rgb[0], map.rgb[LEVELS - 1]),
                (
                    palette(map.contour_palette),
                    palette(map.palette[0]),
                    palette(map.palette[LEVELS - 1]),
                ),
            ];
            for (contour, outside, inside) in tiers {
                for side in [outside, inside] {
                    let contrast = contrast(contour, side);
                    assert!(contrast > 2.0, "{}: {contrast}", map.name);
                }
            }
        }
    }
}
