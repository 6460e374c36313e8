//! SVG files of drawings.

use super::canvas::{Drawing, Image, PlacedText, Shape};
use super::png::encode_plain;
use super::provenance::Provenance;
use super::{FigureError, MILLIMETRES_AN_INCH};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plotters::style::RGBColor;
use std::fmt::{self, Write};
use tiny_skia::{PathSegment, Point};

/// The text of the SVG file; its letters are outlines, or text in a font that the reader must have.
///
/// # Errors
/// [`FigureError::Encode`].
pub(super) fn encode(
    drawing: &Drawing,
    has_text: bool,
    dpi: u32,
    provenance: &Provenance,
) -> Result<String, FigureError> {
    let mut text = String::new();
    let (width, height) = (drawing.width, drawing.height);
    let [across, down] =
        [width, height].map(|pixels| f64::from(pixels) * MILLIMETRES_AN_INCH / f64::from(dpi));
    writeln!(text, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(
        text,
        r#"<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="{across:.3}mm" height="{down:.3}mm" viewBox="0 0 {width} {height}" stroke-linecap="round" stroke-linejoin="round">"#,
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
    for image in &drawing.images {
        let uri = data_uri(image)?;
        let place = image.place;
        writeln!(
            text,
            r#"<image x="{}" y="{}" width="{}" height="{}" preserveAspectRatio="none" xlink:href="{uri}"/>"#,
            place.left,
            place.top,
            place.width(),
            place.height(),
        )?;
    }
    for shape in &drawing.shapes {
        let placed = shape.text.and_then(|number| drawing.texts.get(number));
        match placed.filter(|_| has_text) {
            Some(placed) => write_text(&mut text, placed, shape.colour)?,
            None => write_shape(&mut text, shape)?,
        }
    }
    text.push_str("</svg>\n");
    Ok(text)
}

fn hexadecimal(RGBColor(r, g, b): RGBColor) -> String {
    format!("#{r:02X}{g:02X}{b:02X}")
}

/// A text whose letters stay letters: a line of it is one element.
fn write_text(text: &mut String, placed: &PlacedText, colour: RGBColor) -> fmt::Result {
    let colour = hexadecimal(colour);
    let fonts = "DejaVu Sans, Verdana, sans-serif";
    write!(
        text,
        r#"<text xml:space="preserve" fill="{colour}" font-family="{fonts}">"#
    )?;
    for piece in &placed.pieces {
        let [x, y] = piece.at.map(|it| short(it as f32));
        let (size, style) = (
            short(piece.size as f32),
            if piece.is_slanted { "italic" } else { "normal" },
        );
        let words = Escaped(&piece.text);
        write!(
            text,
            r#"<tspan x="{x}" y="{y}" font-size="{size}" font-style="{style}">{words}</tspan>"#
        )?;
    }
    writeln!(text, "</text>")
}

fn write_shape(text: &mut String, shape: &Shape) -> fmt::Result {
    let colour = hexadecimal(shape.colour);
    match shape.stroke.map(short) {
        Some(width) => write!(
            text,
            r#"<path fill="none" stroke="{colour}" stroke-width="{width}" d=""#
        )?,
        None => write!(text, r#"<path fill="{colour}" d=""#)?,
    }
    let at = |point: Point| format!("{} {}", short(point.x), short(point.y));
    for segment in shape.path.segments() {
        match segment {
            PathSegment::MoveTo(end) => write!(text, "M{}", at(end)),
            PathSegment::LineTo(end) => write!(text, "L{}", at(end)),
            PathSegment::QuadTo(a, end) => write!(text, "Q{} {}", at(a), at(end)),
            PathSegment::CubicTo(a, b, end) => write!(text, "C{} {} {}", at(a), at(b), at(end)),
            PathSegment::Close => write!(text, "Z"),
        }?;
    }
    writeln!(text, r#""/>"#)
}

/// A length in pixels to a hundredth.
fn short(pixels: f32) -> f32 {
    (100.0 * pixels).round() / 100.0
}

fn data_uri(image: &Image) -> Result<String, FigureError> {
    let bytes: Vec<u8> = (image.cells.iter())
        .flat_map(|&RGBColor(r, g, b)| [r, g, b])
        .collect();
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
