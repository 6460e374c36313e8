//! Which part of the domain is shown, and in how many cells.

use super::layout::fit;
use super::state::Zoom;
use crate::geometry::BoundingBox;

/// A part of the domain in its true shape on a rectangle of cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// What is shown.
    pub region: BoundingBox,
    /// Cells beside each other.
    pub columns: u16,
    /// Cells one below the other.
    pub rows: u16,
}

impl Window {
    /// What is shown of a domain within so many columns and rows: all of it, or the part around the vesicle and as
    /// much beside it as there is room for, or the middle half of that. `vesicle` is the rectangle around the
    /// vesicle at all times up to now.
    pub fn new(
        domain: BoundingBox,
        vesicle: Option<BoundingBox>,
        zoom: Zoom,
        room: (u16, u16),
    ) -> Self {
        // A cell is twice as high as it is wide.
        let aspect = 0.5 * f64::from(room.0.max(1)) / f64::from(room.1.max(1));
        let region = zoom.region(&domain, vesicle.as_ref(), aspect);
        let (columns, rows) = fit(region.aspect(), room.0, room.1);
        Self {
            region,
            columns,
            rows,
        }
    }

    /// Cells by the unit of length.
    pub fn scale(&self) -> f64 {
        f64::from(self.columns) / self.region.extent().x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    const UNIT: BoundingBox = BoundingBox {
        lower: Point::new(0.0, 0.0),
        upper: Point::new(1.0, 1.0),
    };
    const VESICLE: BoundingBox = BoundingBox {
        lower: Point::new(0.38, 0.18),
        upper: Point::new(0.62, 0.82),
    };

    #[test]
    fn the_vesicle_fills_its_window_and_keeps_its_shape() {
        let window = |zoom, room| Window::new(UNIT, Some(VESICLE), zoom, room);
        for room in [(62, 30), (31, 15), (17, 15), (100, 20)] {
            let [all, fitted, doubled] =
                [Zoom::Domain, Zoom::Fit, Zoom::Double].map(|zoom| window(zoom, room));
            assert_eq!(all.region, UNIT);
            assert!(fitted.scale() > 1.25 * all.scale(), "{room:?}: {fitted:?}");
            assert!((doubled.scale() / fitted.scale() - 2.0).abs() < 1e-9);
            assert!(fitted.region.union(&VESICLE) == fitted.region);
            for shown in [all, fitted, doubled] {
                assert!(shown.columns <= room.0 && shown.rows <= room.1);
                let cells = 0.5 * f64::from(shown.columns) / f64::from(shown.rows);
                // To a cell.
                let error = (cells / shown.region.aspect() - 1.0).abs();
                assert!(error < 0.1, "{room:?}: {shown:?}");
            }
        }
        // A narrow place shows little beside the vesicle.
        assert!(window(Zoom::Fit, (17, 17)).scale() > 2.0 * window(Zoom::Domain, (17, 17)).scale());
    }

    #[test]
    fn without_a_vesicle_the_domain_is_shown() {
        for zoom in [Zoom::Domain, Zoom::Fit, Zoom::Double] {
            assert_eq!(Window::new(UNIT, None, zoom, (40, 20)).region, UNIT);
        }
        Window::new(UNIT, Some(VESICLE), Zoom::Fit, (0, 0));
    }
}
