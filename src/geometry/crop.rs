//! Which part of a domain a picture shows.

use super::{BoundingBox, Point, Vector};

/// Around what is shown, in parts of its longer side.
const MARGIN: f64 = 0.05;
/// The sides of the part that is shown lie on a grid of this number of lines across the domain, so that the part changes
/// in steps and seldom.
const PARTS: f64 = 40.0;

/// The part of a domain that holds something with a margin. A larger part for a larger thing; the same for things
/// that differ little.
pub fn crop(domain: &BoundingBox, content: &BoundingBox) -> BoundingBox {
    let unit = domain.extent() / PARTS;
    let margin = MARGIN * content.extent().max();
    let lines = |place: Point, outwards: f64, round: fn(f64) -> f64| {
        let steps = (place - domain.lower).add_scalar(outwards * margin);
        let steps = steps.component_div(&unit).map(round);
        domain.lower + steps.component_mul(&unit)
    };
    BoundingBox {
        lower: lines(content.lower, -1.0, f64::floor).sup(&domain.lower),
        upper: lines(content.upper, 1.0, f64::ceil).inf(&domain.upper),
    }
}

/// A part of a domain widened, or made higher, to an aspect (width by height), as far as the domain goes.
pub fn widened(part: &BoundingBox, domain: &BoundingBox, aspect: f64) -> BoundingBox {
    let extent = part.extent();
    let wanted = Vector::new(
        extent.x.max(aspect * extent.y),
        extent.y.max(extent.x / aspect),
    );
    let extent = wanted.inf(&domain.extent());
    // About the same middle, but within the domain.
    let lower = part.center() - 0.5 * extent;
    let lower = lower.inf(&(domain.upper - extent)).sup(&domain.lower);
    BoundingBox {
        lower,
        upper: lower + extent,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: BoundingBox = BoundingBox {
        lower: Point::new(0.0, 0.0),
        upper: Point::new(1.0, 1.0),
    };

    fn rectangle(lower: [f64; 2], upper: [f64; 2]) -> BoundingBox {
        let (lower, upper) = (Point::from(lower), Point::from(upper));
        BoundingBox { lower, upper }
    }

    #[test]
    fn what_is_shown_holds_its_content_with_a_margin_and_changes_in_steps() {
        let shown = crop(&UNIT, &rectangle([0.377, 0.18], [0.623, 0.82]));
        assert!(
            (shown.lower - Point::new(0.325, 0.125)).amax() < 1e-12,
            "{shown:?}"
        );
        assert!(
            (shown.upper - Point::new(0.675, 0.875)).amax() < 1e-12,
            "{shown:?}"
        );
        // What grows a little is shown in the same place; nothing reaches beyond the domain.
        assert_eq!(crop(&UNIT, &rectangle([0.377, 0.17], [0.623, 0.82])), shown);
        assert_eq!(
            crop(&UNIT, &rectangle([0.0, 0.1], [1.0, 0.9])).extent().x,
            1.0
        );
    }

    #[test]
    fn a_part_is_widened_about_its_middle_within_the_domain() {
        let high = rectangle([0.4, 0.2], [0.6, 0.8]);
        let square = widened(&high, &UNIT, 1.0);
        assert!(
            (square.lower - Point::new(0.2, 0.2)).amax() < 1e-12,
            "{square:?}"
        );
        assert!(
            (square.upper - Point::new(0.8, 0.8)).amax() < 1e-12,
            "{square:?}"
        );
        // At the left wall there is no room on the left.
        let aside = widened(&rectangle([0.0, 0.2], [0.2, 0.8]), &UNIT, 1.0);
        assert!(
            (aside.lower - Point::new(0.0, 0.2)).amax() < 1e-12,
            "{aside:?}"
        );
        assert!((aside.extent() - Vector::new(0.6, 0.6)).amax() < 1e-12);
        assert_eq!(widened(&high, &UNIT, 9.0).extent().x, 1.0);
    }
}
