//! PNG files: pixels, their physical size, and where they come from.

use super::provenance::Provenance;
use super::{FigureError, MILLIMETRES_AN_INCH};
use png::{BitDepth, ColorType, Compression, Encoder, PixelDimensions, SrgbRenderingIntent, Unit};

/// Encodes pixels (red, green, blue).
///
/// # Errors
/// [`FigureError::Encode`].
pub(super) fn encode(
    pixels: &[u8],
    width: u32,
    height: u32,
    dpi: u32,
    provenance: &Provenance,
) -> Result<Vec<u8>, FigureError> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    let a_metre = (f64::from(dpi) * 1000.0 / MILLIMETRES_AN_INCH).round() as u32;
    encoder.set_pixel_dims(Some(PixelDimensions {
        xppu: a_metre,
        yppu: a_metre,
        unit: Unit::Meter,
    }));
    for (keyword, text) in provenance.entries() {
        // The plain chunk holds Latin-1 only, and is what every program reads.
        match text.is_ascii() {
            true => encoder.add_text_chunk(keyword.to_owned(), text.to_owned())?,
            false => encoder.add_itxt_chunk(keyword.to_owned(), text.to_owned())?,
        }
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(file)
}

/// Encodes an image for use within another file: nothing but its pixels.
///
/// # Errors
/// [`FigureError::Encode`].
pub(super) fn encode_plain(pixels: &[u8], width: u32, height: u32) -> Result<Vec<u8>, FigureError> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(file)
}
