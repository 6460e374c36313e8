//! A field on a rectangle of cells: colours or a ramp of glyphs, the contour φ = 0, the director.

use std::sync::Arc;

use ratatui::buffer::{Buffer, Cell};
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use ratatui::widgets::{Block, Widget};

use super::director::{Grid, lines};
use crate::fem::{Mesh, Raster};
use crate::geometry::BoundingBox;
use crate::scene::Geometry;
use crate::scheme::State;
use crate::simulation::Setting;
use crate::tui::canvas::Canvas;
use crate::tui::colour_map::LEVELS;
use crate::tui::field_image::FieldImage;
use crate::tui::glyphs::{Glyphs, Parts};
use crate::tui::state::{Director, Field, View};
use crate::tui::theme::{ColorTier, Role, Theme};

/// Where the director is shorter there is a dot in place of an arrow.
pub const SHORT: f64 = 0.5;
/// A longer one is bold.
const LONG: f64 = 1.15;

/// What is drawn, and how.
#[derive(Debug, Clone, Copy)]
pub struct Plot<'a> {
    /// The mesh.
    pub mesh: &'a Arc<Mesh>,
    /// The fields.
    pub state: &'a State,
    /// Their scene.
    pub setting: &'a Setting,
    /// The part of the domain.
    pub region: BoundingBox,
    /// Which field, which colours, which director.
    pub view: View,
}

/// Levels of φ: it is one of two values nearly everywhere, and what is between them moves with the membrane.
const PHASE_LEVELS: usize = 6;

/// The level, out of [`LEVELS`], of a share of the range: fields are quantised before they are
/// coloured.
pub fn level(field: Field, share: f64) -> usize {
    let levels = match field {
        Field::Phase => PHASE_LEVELS,
        _ => LEVELS,
    };
    let level = ((share * levels as f64) as usize).min(levels - 1);
    // From the first colour to the last.
    (level * (LEVELS - 1) + (levels - 1) / 2) / (levels - 1)
}

/// What was drawn.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// The cells within the frame.
    pub cells: Rect,
    /// The values at the ends of the colour bar.
    pub range: [f64; 2],
    /// Which of the cells the membrane goes through, row by row from above.
    pub membrane: Vec<bool>,
}

impl Plot<'_> {
    /// Draws a frame and fills it.
    pub fn draw(
        &self,
        theme: &Theme,
        canvas: &mut Canvas,
        frame: Rect,
        buffer: &mut Buffer,
    ) -> Drawn {
        let block = Block::bordered()
            .border_set(theme.glyphs().border)
            .border_style(theme.muted());
        let cells = block.inner(frame);
        block.render(frame, buffer);
        let area = cells.intersection(buffer.area);
        let a_cell = (theme.parts()).map_or([1, 1], |parts| [Parts::COLUMNS, parts.rows()]);
        let grid = Grid {
            size: [
                usize::from(area.width) * a_cell[0],
                usize::from(area.height) * a_cell[1],
            ],
            a_cell,
        };
        let [columns, rows] = grid.size;
        let raster = canvas.raster(self.mesh, self.region, (columns, rows));
        let image = FieldImage::new(
            self.view.field,
            self.state,
            self.setting.scene.membrane.interface_width,
            &raster,
        );
        let contour = contour(&image.phase, columns);
        let mut samples = Samples {
            grid,
            image,
            contour,
            lines: vec![false; columns * rows],
        };
        let director = (self.state.director.as_ref()).filter(|_| self.view.shows_director());
        let has_lines = self.view.director == Director::Strokes && theme.parts().is_some();
        if let Some(director) = director.filter(|_| has_lines) {
            let is_free = |x: usize, y: usize| {
                samples.is_inside(x, y) && !samples.has_contour([x / a_cell[0], y / a_cell[1]])
            };
            samples.lines = lines(grid, &raster, director, is_free);
        }
        for row in 0..area.height {
            for column in 0..area.width {
                if let Some(cell) = buffer.cell_mut((area.x + column, area.y + row)) {
                    let place = [usize::from(column), usize::from(row)];
                    self.fill(&samples, place, theme, cell);
                }
            }
        }
        if let Some(director) = director.filter(|_| !has_lines) {
            self.directions(&samples, (&raster, director), theme, area, buffer);
        }
        if self.mesh.geometry() == Geometry::Axisymmetric {
            mark_axis(self.region, &samples, theme, area, buffer);
        }
        let places =
            (0..cells.height).flat_map(|row| (0..cells.width).map(move |column| [column, row]));
        let membrane = places.map(|[column, row]| {
            let is_seen = column < area.width && row < area.height;
            is_seen && samples.has_contour([column, row].map(usize::from))
        });
        Drawn {
            cells,
            range: samples.image.range,
            membrane: membrane.collect(),
        }
    }

    /// A cell: the contour above all, or a piece of a line along the director, over the colour of the field; without colours over a
    /// ramp of glyphs.
    fn fill(&self, samples: &Samples, place: [usize; 2], theme: &Theme, cell: &mut Cell) {
        let map = theme.map(self.view.colour_map);
        let share = samples.share(place, |_| true);
        let level = |share: f64| level(self.view.field, share);
        let colour = |share: f64| theme.level(map, level(share));
        let [contour, lines] =
            [&samples.contour, &samples.lines].map(|line| samples.bits(line, place));
        let ink = match share {
            _ if contour != 0 => Some((contour, theme.contour(map), Modifier::BOLD)),
            Some(share) if lines != 0 => {
                let ink = theme.ink(map, level(share));
                Some((lines, ink, Modifier::empty()))
            }
            _ => None,
        };
        match (theme.parts(), ink) {
            (Some(parts), Some((bits, ink, weight))) => {
                cell.set_char(parts.glyph(bits)).set_fg(ink);
                // The colour of the rest of the cell, if anything is left.
                let rest = samples.share(place, |sample| !samples.contour[sample]);
                if let Some(rest) = rest.or(share).filter(|_| theme.paints()) {
                    cell.set_bg(colour(rest));
                } else {
                    cell.set_style(Style::default().add_modifier(weight));
                }
            }
            (None, Some((_, ink, weight))) => {
                if theme.paints() {
                    cell.set_bg(ink);
                } else {
                    let style = Style::default().fg(ink).add_modifier(weight);
                    cell.set_symbol(theme.glyphs().contour).set_style(style);
                }
            }
            (_, None) if theme.paints() => {
                let [upper, lower] = samples.halves(place).map(|share| share.map(colour));
                paint(upper, lower, theme, cell);
                // Not seen in an empty cell, but it need not be sent for a line beside it.
                if let Some(share) = share.filter(|_| upper == lower) {
                    cell.set_fg(theme.ink(map, level(share)));
                }
            }
            (_, None) => {
                if let Some(share) = share {
                    cell.set_symbol(ramp_glyph(share, self.view, theme))
                        .set_style(ramp_style(share, theme));
                }
            }
        }
    }

    /// The director as one glyph each, on a lattice of cells inside the vesicle.
    fn directions(
        &self,
        samples: &Samples,
        (raster, [dx, dy]): (&Raster, &[Vec<f64>; 2]),
        theme: &Theme,
        area: Rect,
        buffer: &mut Buffer,
    ) {
        let (columns, rows) = (usize::from(area.width), usize::from(area.height));
        let [samples_across, samples_down] = samples.grid.a_cell;
        // About twenty in the height of the picture, as far apart in x as in y; two columns at least,
        // since the glyphs touch each other otherwise.
        let every = (rows / 20).max(1);
        let map = theme.map(self.view.colour_map);
        // A line and a column of the lattice go through the middle.
        let (first_row, first_column) = (rows / 2 % every, columns / 2 % (2 * every));
        for row in (first_row..rows).step_by(every) {
            for column in (first_column..columns).step_by(2 * every) {
                let place = [column, row];
                let (x, y) = (
                    samples_across * column + samples_across / 2,
                    samples_down * row + samples_down / 2,
                );
                let director = raster.at_across(dx, x, y).zip(raster.at(dy, x, y));
                let Some((x, y)) = director.filter(|_| samples.is_deep_inside(place)) else {
                    continue;
                };
                let length = x.hypot(y);
                if !length.is_finite() {
                    continue;
                }
                let glyphs = theme.glyphs();
                let symbol = match self.view.director {
                    _ if length < SHORT => glyphs.dot,
                    Director::Strokes => glyphs.stroke(x, y),
                    _ => glyphs.arrow(x, y),
                };
                let share = samples.share(place, |_| true).unwrap_or(0.0);
                let level = level(self.view.field, share);
                let mut style = Style::reset();
                if theme.paints() {
                    style = style.fg(theme.ink(map, level)).bg(theme.level(map, level));
                }
                if length > LONG {
                    style = style.add_modifier(Modifier::BOLD);
                }
                let position = (area.x + column as u16, area.y + row as u16);
                if let Some(cell) = buffer.cell_mut(position) {
                    cell.set_symbol(symbol);
                    cell.set_style(style);
                }
            }
        }
    }
}

/// Marks the axis of rotation, in every other row of cells that has nothing else but the field.
fn mark_axis(
    region: BoundingBox,
    samples: &Samples,
    theme: &Theme,
    area: Rect,
    buffer: &mut Buffer,
) {
    let share = -region.lower.x / region.extent().x;
    if !(0.0..1.0).contains(&share) {
        return;
    }
    let column = area.x + (share * f64::from(area.width)) as u16;
    for row in (area.y..area.bottom()).step_by(2) {
        let half = theme.glyphs().upper_half.unwrap_or(" ");
        if let Some(cell) = buffer.cell_mut((column, row))
            && !samples.has_contour([usize::from(column - area.x), usize::from(row - area.y)])
            && (!theme.paints() || [half, " "].contains(&cell.symbol()))
        {
            cell.set_symbol(theme.glyphs().bar);
            if theme.paints() {
                cell.set_style(theme.muted());
            }
        }
    }
}

/// The samples of a picture, some a cell.
struct Samples {
    grid: Grid,
    image: FieldImage,
    /// Which of them the contour φ = 0 goes through.
    contour: Vec<bool>,
    /// Which of them lines along the director go through.
    lines: Vec<bool>,
}

impl Samples {
    /// Those of a cell, from the left to the right, then the row below.
    fn of(&self, [column, row]: [usize; 2]) -> impl Iterator<Item = usize> {
        let Grid { size, a_cell } = self.grid;
        let first = row * a_cell[1] * size[0] + column * a_cell[0];
        (0..a_cell[1])
            .flat_map(move |down| (0..a_cell[0]).map(move |right| first + down * size[0] + right))
    }

    /// Which of those of a cell are on a line, one bit each.
    fn bits(&self, line: &[bool], place: [usize; 2]) -> u8 {
        let samples = self.of(place).enumerate();
        samples.fold(0, |bits, (number, sample)| {
            bits | u8::from(line[sample]) << number
        })
    }

    fn has_contour(&self, place: [usize; 2]) -> bool {
        self.of(place).any(|sample| self.contour[sample])
    }

    /// Where the mean over some samples of a cell lies in the range, if any of them has a value.
    fn share(&self, place: [usize; 2], counts: impl Fn(usize) -> bool) -> Option<f64> {
        let samples = self.of(place).filter(|sample| counts(*sample));
        self.mean(samples)
    }

    /// The same of the upper and of the lower half of a cell, as far as it has halves.
    fn halves(&self, place: [usize; 2]) -> [Option<f64>; 2] {
        let [across, down] = self.grid.a_cell;
        let half = across * (down / 2).max(1);
        let upper = self.mean(self.of(place).take(half));
        if down < 2 {
            return [upper; 2];
        }
        [upper, self.mean(self.of(place).skip(half))]
    }

    fn mean(&self, samples: impl Iterator<Item = usize>) -> Option<f64> {
        let values = samples.filter_map(|sample| self.image.values[sample]);
        let (sum, count) =
            values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
        (count > 0.0).then(|| self.image.share(sum / count))
    }

    fn is_inside(&self, x: usize, y: usize) -> bool {
        self.image.phase[y * self.grid.size[0] + x].is_some_and(|phase| phase > 0.0)
    }

    /// Whether a cell lies inside the vesicle with both its neighbours, and not on the contour.
    fn is_deep_inside(&self, [column, row]: [usize; 2]) -> bool {
        let [columns, a_cell] = [self.grid.size[0], self.grid.a_cell[0]];
        let last = (columns / a_cell).saturating_sub(1);
        let inside = |column: usize| {
            self.of([column.min(last), row])
                .all(|sample| self.is_inside(sample % columns, sample / columns))
        };
        (column.saturating_sub(1)..=column + 1).all(inside) && !self.has_contour([column, row])
    }
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

/// The colours of the upper and of the lower half of a cell; the same where it has no halves.
fn paint(upper: Option<Color>, lower: Option<Color>, theme: &Theme, cell: &mut Cell) {
    match (upper, lower, theme.glyphs().upper_half) {
        // One colour needs no glyph: fewer bytes.
        (Some(upper), Some(lower), _) if upper == lower => {
            cell.set_bg(upper);
        }
        (Some(upper), Some(lower), Some(half)) => {
            cell.set_symbol(half).set_fg(upper).set_bg(lower);
        }
        (Some(upper), None, Some(half)) => {
            cell.set_symbol(half).set_fg(upper);
        }
        (None, Some(lower), Some(_)) => {
            cell.set_symbol("▄").set_fg(lower);
        }
        _ => {}
    }
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
    fn sixteen_levels_and_six_of_the_phase() {
        let levels = |field| [0.0, 0.499, 0.5, 1.0].map(|share| level(field, share));
        assert_eq!(levels(Field::Mu), [0, 7, 8, 15]);
        assert_eq!(levels(Field::Phase), [0, 6, 9, 15]);
        assert_eq!(level(Field::Mu, f64::NAN), 0);
    }
}
