//! A field on a rectangle of cells: colours or a ramp of glyphs, the contour φ = 0, the director.

use std::sync::Arc;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::widgets::{Block, Widget};

use crate::fem::Mesh;
use crate::scene::Geometry;
use crate::scheme::State;
use crate::simulation::Setting;
use crate::tui::canvas::Canvas;
use crate::tui::colour_map::{ColourMap, LEVELS};
use crate::tui::field_image::FieldImage;
use crate::tui::glyphs::Glyphs;
use crate::tui::state::{Director, Field, View};
use crate::tui::theme::{ColorTier, Role, Theme};

/// Below this |d| the director has no direction worth showing.
const VANISHING: f64 = 0.05;
/// Below this |d| the director is drawn faintly, above the other boldly.
const WEAK: f64 = 0.85;
const STRONG: f64 = 1.15;

/// What is drawn, and how.
#[derive(Debug, Clone, Copy)]
pub struct Plot<'a> {
    /// The mesh.
    pub mesh: &'a Arc<Mesh>,
    /// The fields.
    pub state: &'a State,
    /// Their scene.
    pub setting: &'a Setting,
    /// Which field, which colours, which director.
    pub view: View,
}

/// The level, out of [`LEVELS`], of a share of the range: fields are quantised before they are
/// coloured.
pub fn level(share: f64) -> usize {
    ((share * LEVELS as f64) as usize).min(LEVELS - 1)
}

impl Plot<'_> {
    /// Draws a frame and fills it; returns the cells within it, and the values at the ends of the colour bar.
    pub fn draw(
        &self,
        theme: &Theme,
        canvas: &mut Canvas,
        frame: Rect,
        buffer: &mut Buffer,
    ) -> (Rect, [f64; 2]) {
        let block = Block::bordered()
            .border_set(theme.glyphs().border)
            .border_style(theme.muted());
        let cells = block.inner(frame);
        block.render(frame, buffer);
        let area = cells.intersection(buffer.area);
        let (columns, rows) = (usize::from(area.width), usize::from(area.height));
        let half = theme.glyphs().upper_half.filter(|_| theme.paints());
        let samples_a_cell = if half.is_some() { 2 } else { 1 };
        let raster = canvas.raster(self.mesh, columns, rows * samples_a_cell);
        let sampled = FieldImage::new(
            self.view.field,
            self.state,
            self.setting.scene.membrane.interface_width,
            &raster,
        );
        let mut contour = contour(&sampled.phase, columns);
        if self.view.field != Field::Phase {
            // What lies on the membrane must be visible too.
            dash(&mut contour, columns);
        }
        let map = theme.map(self.view.colour_map);
        match half {
            Some(half) => paint(&sampled, &contour, map, theme, half, area, buffer),
            None => self.fill(&sampled, &contour, theme, area, buffer),
        }
        self.director(&sampled, &contour, theme, canvas, area, buffer);
        if self.mesh.geometry() == Geometry::Axisymmetric {
            mark_axis(theme, area, buffer);
        }
        (cells, sampled.range)
    }

    /// One sample a cell: colours in a locale without blocks; without colours a ramp of glyphs, the contour above
    /// all.
    fn fill(
        &self,
        sampled: &FieldImage,
        contour: &[bool],
        theme: &Theme,
        area: Rect,
        buffer: &mut Buffer,
    ) {
        let columns = usize::from(area.width);
        let map = theme.map(self.view.colour_map);
        for (index, (value, on_contour)) in sampled.values.iter().zip(contour).enumerate() {
            let Some(share) = value.map(|value| sampled.share(value)) else {
                continue;
            };
            let Some(cell) = cell_of(buffer, area, index, columns) else {
                continue;
            };
            match (theme.paints(), on_contour) {
                (true, true) => cell.set_bg(theme.contour(map)),
                (true, false) => cell.set_bg(theme.level(map, level(share))),
                (false, true) => {
                    let style = Style::default()
                        .fg(theme.contour(map))
                        .add_modifier(Modifier::BOLD);
                    cell.set_symbol(theme.glyphs().contour).set_style(style)
                }
                (false, false) => cell
                    .set_symbol(ramp_glyph(share, self.view, theme))
                    .set_style(ramp_style(share, theme)),
            };
        }
    }

    /// The director on a lattice of cells inside the vesicle.
    fn director(
        &self,
        sampled: &FieldImage,
        contour: &[bool],
        theme: &Theme,
        canvas: &mut Canvas,
        area: Rect,
        buffer: &mut Buffer,
    ) {
        let drawn = self.view.director != Director::Off
            && matches!(self.view.field, Field::Phase | Field::DirectorLength);
        let Some([dx, dy]) = self.state.director.as_ref().filter(|_| drawn) else {
            return;
        };
        let (columns, rows) = (usize::from(area.width), usize::from(area.height));
        let samples_a_cell = sampled.values.len() / (columns * rows).max(1);
        let raster = canvas.raster(self.mesh, columns, rows);
        // About twenty in the height of the domain, as far apart in x as in y; two columns at least,
        // since the glyphs touch each other otherwise.
        let every = (rows / 20).max(1);
        let map = theme.map(self.view.colour_map);
        // A line and a column of the lattice go through the middle.
        let (first_row, first_column) = (rows / 2 % every, columns / 2 % (2 * every));
        for row in (first_row..rows).step_by(every) {
            for column in (first_column..columns).step_by(2 * every) {
                let top = row * samples_a_cell;
                let inside = (top..top + samples_a_cell)
                    .all(|row| is_inside(sampled, contour, columns, column, row));
                let director = raster
                    .at_across(dx, column, row)
                    .zip(raster.at(dy, column, row));
                let Some((x, y)) = director.filter(|_| inside) else {
                    continue;
                };
                let length = x.hypot(y);
                if !length.is_finite() {
                    continue;
                }
                let glyphs = theme.glyphs();
                let symbol = match self.view.director {
                    _ if length < VANISHING => glyphs.dot,
                    Director::Strokes => glyphs.stroke(x, y),
                    _ => glyphs.arrow(x, y),
                };
                let value = sampled.values.get(top * columns + column);
                let share = value
                    .copied()
                    .flatten()
                    .map_or(0.0, |value| sampled.share(value));
                let style = director_style(length, level(share), map, theme);
                let position = (area.x + column as u16, area.y + row as u16);
                if let Some(cell) = buffer.cell_mut(position) {
                    cell.set_symbol(symbol);
                    cell.set_style(style);
                }
            }
        }
    }
}

/// Marks the axis of rotation, in the middle, in every other row of cells that has no director.
fn mark_axis(theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let column = area.x + area.width / 2;
    for row in (area.y..area.bottom()).step_by(2) {
        let half = theme.glyphs().upper_half.unwrap_or(" ");
        if let Some(cell) = buffer.cell_mut((column, row))
            && (!theme.paints() || [half, " "].contains(&cell.symbol()))
        {
            cell.set_symbol(theme.glyphs().bar);
            if theme.paints() {
                cell.set_style(theme.muted());
            }
        }
    }
}

/// Whether a sample lies inside the vesicle with both its neighbours, and not on the contour.
fn is_inside(
    sampled: &FieldImage,
    contour: &[bool],
    columns: usize,
    column: usize,
    row: usize,
) -> bool {
    let start = row * columns;
    let positive = |column: usize| {
        let phase = sampled.phase.get(start + column.min(columns - 1));
        phase.copied().flatten().is_some_and(|phase| phase > 0.0)
    };
    (column.saturating_sub(1)..=column + 1).all(positive)
        && !contour.get(start + column).copied().unwrap_or(false)
}

/// How a director of this length is drawn on a level.
fn director_style(length: f64, level: usize, map: &ColourMap, theme: &Theme) -> Style {
    let weak = length < WEAK;
    let strength = if length > STRONG {
        Modifier::BOLD
    } else {
        Modifier::empty()
    };
    if theme.paints() {
        return Style::default()
            .fg(theme.ink(map, level, weak))
            .bg(theme.level(map, level))
            .add_modifier(strength);
    }
    let strength = if weak { Modifier::DIM } else { strength };
    Style::reset().add_modifier(strength)
}

/// The glyph of a share of the range where there are no colours.
pub fn ramp_glyph(share: f64, view: View, theme: &Theme) -> &'static str {
    let glyphs = theme.glyphs();
    // The inside of the vesicle is left white, so that the director can be read; every other colour
    // map turns it round.
    let reversed = (view.field == Field::Phase) != (view.colour_map % 2 == 1);
    let share = if reversed { 1.0 - share } else { share };
    if view.field == Field::Phase {
        Glyphs::pick(glyphs.phase, share)
    } else {
        Glyphs::pick(glyphs.ramp, share)
    }
}

/// The colour of that glyph where there are at least the 16 of the terminal: by sign.
pub fn ramp_style(share: f64, theme: &Theme) -> Style {
    match theme.tier {
        ColorTier::Basic if share < 0.5 => theme.style(Role::Accent),
        _ => Style::default(),
    }
}

/// Two samples a cell, one above the other.
fn paint(
    sampled: &FieldImage,
    contour: &[bool],
    map: &ColourMap,
    theme: &Theme,
    half: &'static str,
    area: Rect,
    buffer: &mut Buffer,
) {
    let columns = usize::from(area.width);
    let colour = |index: usize| {
        let value = sampled.values.get(index).copied().flatten()?;
        Some(if contour.get(index).copied().unwrap_or(false) {
            theme.contour(map)
        } else {
            theme.level(map, level(sampled.share(value)))
        })
    };
    for row in 0..usize::from(area.height) {
        for column in 0..columns {
            let upper = 2 * row * columns + column;
            let Some(cell) = cell_of(buffer, area, row * columns + column, columns) else {
                continue;
            };
            match (colour(upper), colour(upper + columns)) {
                // One colour needs no glyph: fewer bytes.
                (Some(upper), Some(lower)) if upper == lower => {
                    cell.set_bg(upper);
                }
                (Some(upper), Some(lower)) => {
                    cell.set_symbol(half).set_fg(upper).set_bg(lower);
                }
                (Some(upper), None) => {
                    cell.set_symbol(half).set_fg(upper);
                }
                (None, Some(lower)) => {
                    cell.set_symbol("▄").set_fg(lower);
                }
                (None, None) => {}
            }
        }
    }
}

fn cell_of(
    buffer: &mut Buffer,
    area: Rect,
    index: usize,
    columns: usize,
) -> Option<&mut ratatui::buffer::Cell> {
    let (row, column) = (index / columns, index % columns);
    buffer.cell_mut((area.x + column as u16, area.y + row as u16))
}

/// The samples that the contour φ = 0 goes through: of two neighbours with different signs, the one
/// that is nearer to it.
fn contour(phase: &[Option<f64>], columns: usize) -> Vec<bool> {
    let mut on_contour = vec![false; phase.len()];
    let mut compare = |one: usize, other: usize| {
        if let (Some(a), Some(b)) = (phase[one], phase[other])
            && (a > 0.0) != (b > 0.0)
        {
            on_contour[if a.abs() <= b.abs() { one } else { other }] = true;
        }
    };
    for index in 0..phase.len() {
        if (index + 1) % columns != 0 {
            compare(index, index + 1);
        }
        if index + columns < phase.len() {
            compare(index, index + columns);
        }
    }
    on_contour
}

/// Removes every other piece of a contour, in any direction.
fn dash(on_contour: &mut [bool], columns: usize) {
    for (index, on_contour) in on_contour.iter_mut().enumerate() {
        let (row, column) = (index / columns, index % columns);
        *on_contour &= (column + 2 * row) % 4 < 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_contour_is_on_the_nearer_side_of_each_change_of_sign() {
        let phase: Vec<Option<f64>> = [
            [-1.0, -0.1, 0.9, 1.0],
            [-1.0, -0.8, 0.2, 1.0],
            [-1.0, -1.0, -1.0, -0.3],
        ]
        .iter()
        .flatten()
        .map(|value| Some(*value))
        .collect();
        let on: Vec<usize> = contour(&phase, 4)
            .iter()
            .enumerate()
            .filter_map(|(index, on)| on.then_some(index))
            .collect();
        assert_eq!(on, [1, 6, 11]);
        // Nothing wraps from the end of a row to the start of the next.
        let rows = [None, Some(-0.5), Some(1.0), None];
        assert_eq!(contour(&rows, 2), [false; 4]);
    }

    #[test]
    fn sixteen_levels() {
        assert_eq!(
            [level(0.0), level(0.499), level(0.5), level(1.0)],
            [0, 7, 8, 15]
        );
        assert_eq!(level(f64::NAN), 0);
    }
}
