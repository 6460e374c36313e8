//! The shape at rest that theory foresees, over the field.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Modifier;

use super::plot::Drawn;
use crate::geometry::{BoundingBox, Point};
use crate::tui::theme::{Role, Theme};

/// Draws the outline as dots on the cells that show the region. A cell that the membrane goes through stays as it is: the
/// membrane is what the run says, and there both agree.
pub fn draw(
    outline: &[Point],
    region: BoundingBox,
    drawn: &Drawn,
    theme: &Theme,
    buffer: &mut Buffer,
) {
    let cells = drawn.cells;
    let style = theme.style(Role::Good).add_modifier(Modifier::BOLD);
    let is_free = |&(column, row): &(u16, u16)| {
        let [column, row] = [column - cells.x, row - cells.y].map(usize::from);
        let number = row * usize::from(cells.width) + column;
        !drawn.membrane.get(number).copied().unwrap_or(false)
    };
    let positions = outline.iter().map(|point| cell_of(*point, region, cells));
    for position in positions.flatten().filter(is_free) {
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
