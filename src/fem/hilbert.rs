//! In which order nodes and triangles are numbered: neighbours close to each other, along a Hilbert
//! curve, so that products with matrices find what they need in the cache.

use crate::geometry::{BoundingBox, Point};

/// Steps of the curve along each side, as a power of two.
const ORDER: u32 = 16;

/// The numbers 0, 1, … of places in the order in which a Hilbert curve through the square about them
/// meets them; of those that it meets at once, in their own order.
pub(super) fn along_curve(places: &[Point]) -> Vec<u32> {
    let hull = BoundingBox::around(places);
    let extent = hull.extent().max().max(f64::MIN_POSITIVE);
    let scale = f64::from((1_u32 << ORDER) - 1) / extent;
    let mut order: Vec<(u64, u32)> = places
        .iter()
        .enumerate()
        .map(|(number, place)| {
            let cell = (place - hull.lower) * scale;
            (position([cell.x as u32, cell.y as u32]), number as u32)
        })
        .collect();
    order.sort_unstable();
    order.into_iter().map(|(_, number)| number).collect()
}

/// Where on the curve a cell lies: quadrant by quadrant, each turned such that the curve goes on.
fn position([mut x, mut y]: [u32; 2]) -> u64 {
    let mut position = 0;
    for level in (0..ORDER).rev() {
        let side = 1_u32 << level;
        let (right, upper) = (x & side != 0, y & side != 0);
        let quadrant = match (right, upper) {
            (false, false) => 0,
            (false, true) => 1,
            (true, true) => 2,
            (true, false) => 3,
        };
        position = 4 * position + quadrant;
        (x, y) = (x & (side - 1), y & (side - 1));
        match quadrant {
            0 => (x, y) = (y, x),
            3 => (x, y) = (side - 1 - y, side - 1 - x),
            _ => {}
        }
    }
    position
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_goes_from_neighbour_to_neighbour() {
        let places: Vec<Point> = (0..256)
            .map(|n| Point::new(f64::from(n % 16), f64::from(n / 16)))
            .collect();
        let order = along_curve(&places);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(
            sorted
                .iter()
                .enumerate()
                .all(|(at, number)| at == *number as usize)
        );
        for pair in order.windows(2) {
            let step = places[pair[1] as usize] - places[pair[0] as usize];
            assert_eq!(step.abs().sum(), 1.0, "{pair:?}");
        }
    }
}
