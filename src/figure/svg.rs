//! SVG files, drawn by plotters; what it does not write is written here: the physical size, where
//! the picture comes from, the images, and round corners of lines.

use super::drawing::{Drawing, Image};
use super::paint::{paint, units_a_pixel};
use super::png::encode_plain;
use super::provenance::Provenance;
use super::{FigureError, MILLIMETRES_AN_INCH};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plotters::prelude::SVGBackend;
use std::fmt::{self, Write};

/// The text of the SVG file.
///
/// # Errors
/// [`FigureError::Encode`], [`FigureError::Draw`].
pub(super) fn encode(
    drawing: &Drawing,
    dpi: u32,
    provenance: &Provenance,
) -> Result<String, FigureError> {
    let units = units_a_pixel(drawing);
    let size = (drawing.width * units, drawing.height * units);
    let mut shapes = String::new();
    paint(drawing, units, SVGBackend::with_string(&mut shapes, size))
        .map_err(|error| FigureError::Draw(error.to_string()))?;
    // The first line is the tag of the whole.
    let (_, shapes) = shapes.split_once('\n').unwrap_or(("", &shapes));
    let images: Vec<String> = drawing
        .images
        .iter()
        .map(data_uri)
        .collect::<Result<_, _>>()?;
    let mut text = head(drawing, units, dpi, provenance, &images)
        .map_err(|error| FigureError::Draw(error.to_string()))?;
    text.push_str(shapes);
    Ok(text)
}

fn head(
    drawing: &Drawing,
    units: u32,
    dpi: u32,
    provenance: &Provenance,
    images: &[String],
) -> Result<String, fmt::Error> {
    let millimetres = |pixels: u32| f64::from(pixels) * MILLIMETRES_AN_INCH / f64::from(dpi);
    let mut text = String::new();
    writeln!(text, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(
        text,
        r#"<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="{:.3}mm" height="{:.3}mm" viewBox="0 0 {} {}" stroke-linecap="round" stroke-linejoin="round">"#,
        millimetres(drawing.width),
        millimetres(drawing.height),
        drawing.width * units,
        drawing.height * units,
    )?;
    writeln!(text, "<title>{}</title>", Escaped(provenance.title()))?;
    // The letters are outlines; for search and for those who listen, here they are again.
    let words: Vec<&str> = drawing.texts.iter().map(|placed| &*placed.text).collect();
    writeln!(text, "<desc>{}</desc>", Escaped(&words.join("; ")))?;
    writeln!(text, r#"<metadata xmlns:vesica="urn:vesica:figure">"#)?;
    for (keyword, entry) in provenance.entries() {
        writeln!(
            text,
            r#"<vesica:entry name="{}">{}</vesica:entry>"#,
            Escaped(keyword),
            Escaped(entry)
        )?;
    }
    writeln!(text, "</metadata>")?;
    writeln!(
        text,
        r##"<rect width="100%" height="100%" fill="#FFFFFF"/>"##
    )?;
    for (image, uri) in drawing.images.iter().zip(images) {
        let scale = f64::from(units);
        let place = image.place;
        writeln!(
            text,
            r#"<image x="{}" y="{}" width="{}" height="{}" preserveAspectRatio="none" xlink:href="{uri}"/>"#,
            place.left * scale,
            place.top * scale,
            place.width() * scale,
            place.height() * scale,
        )?;
    }
    Ok(text)
}

fn data_uri(image: &Image) -> Result<String, FigureError> {
    let bytes: Vec<u8> = image.cells.iter().flat_map(|colour| colour.0).collect();
    let [columns, rows] = image
        .size
        .map(|cells| u32::try_from(cells).unwrap_or(u32::MAX));
    let png = encode_plain(&bytes, columns, rows)?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(png)))
}

/// Text in XML. Characters that XML cannot hold become U+FFFD.
struct Escaped<'a>(&'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for character in self.0.chars() {
            match character {
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '&' => f.write_str("&amp;")?,
                '"' => f.write_str("&quot;")?,
                '\n' | '\t' => f.write_char(character)?,
                '\r' => f.write_str("&#13;")?,
                '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => f.write_char('\u{fffd}')?,
                _ => f.write_char(character)?,
            }
        }
        Ok(())
    }
}
