//! The shape at rest that theory foresees, over the field.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Modifier;

use super::plot::Drawn;
use crate::geometry::{BoundingBox, Point};
use crate::tui::theme::{Role, Theme};

/// Of the cells that the outline and the membrane share, every one of so many has a dot: both are seen where they agree.
const SHARED: usize = 3;

/// Draws the outline as dots on the cells that show the region; where the membrane goes through them too, on a few of them.
pub fn draw(
    outline: &[Point],
    region: BoundingBox,
    drawn: &Drawn,
    theme: &Theme,
    buffer: &mut Buffer,
) {
    let cells = drawn.cells;
    let style = theme.style(Role::Good).add_modifier(Modifier::BOLD);
    let is_shared = |(column, row): (u16, u16)| {
        let [column, row] = [column - cells.x, row - cells.y].map(usize::from);
        let number = row * usize::from(cells.width) + column;
        drawn.membrane.get(number).copied().unwrap_or(false)
    };
    let positions = outline.iter().map(|point| cell_of(*point, region, cells));
    let mut positions: Vec<(u16, u16)> = positions.flatten().collect();
    positions.dedup();
    let mut shared = 0;
    for position in positions {
        if is_shared(position) {
            shared += 1;
            if shared % SHARED != 0 {
                continue;
            }
        }
        if let Some(cell) = buffer.cell_mut(position) {
            cell.set_symbol(theme.glyphs().theory).set_style(style);
        }
    }
}

/// The cell in which a point of the region lies.
fn cell_of(point: Point, region: BoundingBox, cells: Rect) -> Option<(u16, u16)> {
    let extent = region.extent();
    let share = [
        (point.x - region.lower.x) / extent.x,
        (region.upper.y - point.y) / extent.y,
    ];
    if !share.iter().all(|share| (0.0..1.0).contains(share)) {
        return None;
    }
    let [column, row] = [
        share[0] * f64::from(cells.width),
        share[1] * f64::from(cells.height),
    ];
    Some((cells.x + column as u16, cells.y + row as u16))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tui::theme::ColorTier;

    #[test]
    fn where_theory_and_membrane_agree_both_are_seen() {
        let region = BoundingBox {
            lower: Point::new(0.0, 0.0),
            upper: Point::new(12.0, 1.0),
        };
        let theme = Theme::new(ColorTier::True, true);
        let outline: Vec<Point> = (0..120)
            .map(|i| Point::new(0.1 * f64::from(i), 0.5))
            .collect();
        let cells = Rect::new(0, 0, 12, 1);
        for (is_membrane, dots) in [(false, 12), (true, 4)] {
            let drawn = Drawn {
                cells,
                range: [-1.0, 1.0],
                membrane: vec![is_membrane; 12],
            };
            let mut buffer = Buffer::empty(cells);
            draw(&outline, region, &drawn, &theme, &mut buffer);
            let found = buffer.content().iter();
            let found = found.filter(|cell| cell.symbol() == theme.glyphs().theory);
            assert_eq!(found.count(), dots);
        }
    }

    #[test]
    fn a_point_lies_in_its_cell() {
        let region = BoundingBox {
            lower: Point::new(0.0, 0.0),
            upper: Point::new(2.0, 1.0),
        };
        let cells = Rect::new(5, 3, 20, 10);
        let cell = |x, y| cell_of(Point::new(x, y), region, cells);
        assert_eq!(cell(0.05, 0.95), Some((5, 3)));
        assert_eq!(cell(1.99, 0.01), Some((24, 12)));
        for (x, y) in [(-0.1, 0.5), (2.0, 0.5), (1.0, 1.1), (f64::NAN, 0.5)] {
            assert_eq!(cell(x, y), None);
        }
    }
}
