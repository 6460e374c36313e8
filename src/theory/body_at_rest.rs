//! The body of rotation that a membrane without nematic takes at rest.

use std::f64::consts::PI;

use super::MEMBRANE_FACTOR;
use super::closed_surface::{Branch, ClosedSurface, ClosedSurfaceError};
use super::shape_at_rest::{AreaPenalty, strain};
use crate::geometry::Point;

/// A closed surface of rotation about the volume V at which c/2 ∫(2H)² dS + (cS − β)²/(2η) is stationary, with S its area.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyAtRest {
    /// On which branch.
    pub branch: Branch,
    /// Whether the branch's surface is upside down: a cup that is open downwards.
    pub is_turned: bool,
    /// The surface, its lengths in parts of R₀.
    pub surface: ClosedSurface,
    /// R₀: S = 4πR₀².
    pub radius: f64,
    /// V.
    pub enclosed: f64,
    /// σ = c(cS − β)/η: negative where the membrane is compressed.
    pub tension: f64,
    /// c/2 ∫(2H)² dS: the limit of E_ben.
    pub bending: f64,
    /// (cS − β)²/(2η).
    pub stretching: f64,
}

impl BodyAtRest {
    /// On a branch about this volume; without a penalty the membrane may have any area, and the body is a sphere.
    ///
    /// # Errors
    /// [`ClosedSurfaceError`].
    pub fn new(
        (branch, is_turned): (Branch, bool),
        enclosed: f64,
        penalty: Option<AreaPenalty>,
    ) -> Result<Self, ClosedSurfaceError> {
        if !(enclosed > 0.0 && enclosed.is_finite()) {
            return Err(ClosedSurfaceError::NoVolume { enclosed });
        }
        // R₀ of a surface about the volume.
        let sphere = (0.75 * enclosed / PI).cbrt();
        let radius = |surface: &ClosedSurface| sphere / surface.reduced_volume.cbrt();
        let strain_of = |radius: f64| strain(4.0 * PI * MEMBRANE_FACTOR * radius * radius, penalty);
        // dE/dS at constant V, over c: with E_ben = 8πc W(v), v = 3V/(4πR₀³) and W' = −P/6.
        let force = |surface: &ClosedSurface| {
            let radius = radius(surface);
            strain_of(radius) + 0.5 * surface.reduced_volume * surface.pressure / (radius * radius)
        };
        let surface = match penalty {
            None => ClosedSurface::sphere(),
            Some(penalty) => {
                let aimed = (penalty.target / (4.0 * PI * MEMBRANE_FACTOR)).sqrt();
                branch.balanced((sphere / aimed).powi(3), force)?
            }
        };
        let radius = radius(&surface);
        // At rest the membrane resists what the pressure does; a sphere may be under any.
        let strain = match surface.reduced_volume {
            1.0 => strain_of(radius),
            volume => -0.5 * volume * surface.pressure / (radius * radius),
        };
        Ok(Self {
            branch,
            is_turned,
            bending: 8.0 * PI * MEMBRANE_FACTOR * surface.energy,
            tension: MEMBRANE_FACTOR * strain,
            stretching: penalty.map_or(0.0, |it| 0.5 * it.penalty * strain * strain),
            surface,
            radius,
            enclosed,
        })
    }

    /// S.
    pub fn surface_area(&self) -> f64 {
        4.0 * PI * self.radius * self.radius
    }

    /// Its height along the axis, from pole to pole, and the diameter of its equator.
    pub fn extents(&self) -> [f64; 2] {
        [self.surface.height, 2.0 * self.surface.radius].map(|extent| extent * self.radius)
    }

    /// The closed curve of its cross-section, with the middle between its least and its greatest height at a centre.
    pub fn outline(&self, center: Point) -> Vec<Point> {
        let heights = || self.surface.meridian.iter().map(|at| at.y);
        let lowest = heights().fold(f64::INFINITY, f64::min);
        let highest = heights().fold(f64::NEG_INFINITY, f64::max);
        let upwards = if self.is_turned { -1.0 } else { 1.0 };
        let place = |side: f64, at: &Point| {
            let height = upwards * (at.y - 0.5 * (lowest + highest));
            Point::new(
                center.x + side * self.radius * at.x,
                center.y + self.radius * height,
            )
        };
        let right = self.surface.meridian.iter().map(|at| place(1.0, at));
        let left = self.surface.meridian.iter().rev().skip(1);
        right.chain(left.map(|at| place(-1.0, at))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_rest(
        branch: Branch,
        target: f64,
        penalty: f64,
    ) -> Result<BodyAtRest, ClosedSurfaceError> {
        // The target in parts of that of the unit sphere.
        let target = 4.0 * PI * MEMBRANE_FACTOR * target;
        let volume = 4.0 * PI / 3.0;
        BodyAtRest::new(
            (branch, false),
            volume,
            Some(AreaPenalty { target, penalty }),
        )
    }

    /// The energy on the branch about the same volume at another area, in place of the force's formula.
    #[test]
    fn the_area_at_rest_has_the_least_energy() {
        for (branch, target, penalty) in [
            (Branch::Prolate, 1.2, 1e-2),
            (Branch::Oblate, 1.3, 0.1),
            (Branch::Stomatocyte, 1.4, 1e-2),
        ] {
            let shape = at_rest(branch, target, penalty).expect("there is one");
            let energy = |area: f64| {
                let surface = branch
                    .surface(area.powf(-1.5))
                    .expect("it is near one that there is");
                let excess = 4.0 * PI * MEMBRANE_FACTOR * (area - target);
                8.0 * PI * MEMBRANE_FACTOR * surface.energy + excess * excess / (2.0 * penalty)
            };
            let area = shape.radius * shape.radius;
            let own = shape.bending + shape.stretching;
            assert!((own - energy(area)).abs() < 1e-8 * own, "{branch:?}");
            for step in [-1e-3, 1e-3] {
                let other = energy(area * (1.0 + step));
                assert!(other > own, "{branch:?} {step}: {other} {own}");
            }
            assert!(
                shape.tension < 0.0 && area < target,
                "{branch:?}: {shape:?}"
            );
        }
    }

    #[test]
    fn a_membrane_that_is_too_short_or_free_is_a_sphere() {
        let free = BodyAtRest::new((Branch::Oblate, false), 4.0 * PI / 3.0, None);
        let short = at_rest(Branch::Prolate, 0.9, 1e-2);
        // Compressed, but by less than what makes it leave the sphere.
        let pressed = at_rest(Branch::Prolate, 1.0 + 1e-3, 1e-2);
        for (shape, tension) in [(free, 0.0), (short, 1.0), (pressed, -1.0)] {
            let shape = shape.expect("a sphere");
            assert!((shape.radius - 1.0).abs() < 1e-12 && shape.surface.energy == 1.0);
            assert_eq!(
                shape.tension.total_cmp(&0.0),
                f64::total_cmp(&tension, &0.0)
            );
        }
        // Nearer to the sphere than the branch's first surface.
        let nearly = at_rest(Branch::Oblate, 1.001, 1e-5).expect("it is on the branch");
        assert!(
            (0.9952..0.999).contains(&nearly.surface.reduced_volume),
            "{nearly:?}"
        );
        assert!(nearly.surface.radius > 1.0);
    }

    #[test]
    fn the_section_is_closed_and_has_its_extents() {
        let shape = at_rest(Branch::Stomatocyte, 1.4, 1e-4).expect("a cup");
        let center = Point::new(0.0, 0.4);
        let outline = shape.outline(center);
        assert_eq!(outline.first(), outline.last());
        let heights = || outline.iter().map(|at| at.y - center.y);
        let [low, high] = [
            heights().fold(f64::INFINITY, f64::min),
            heights().fold(f64::NEG_INFINITY, f64::max),
        ];
        assert!((low + high).abs() < 1e-12);
        // Open upwards: the pole that is higher is far below the rim.
        let poles = || {
            outline
                .iter()
                .filter(|at| at.x == 0.0)
                .map(|at| at.y - center.y)
        };
        assert!(poles().fold(f64::NEG_INFINITY, f64::max) < high - 0.3);
        let turned = BodyAtRest {
            is_turned: true,
            ..shape.clone()
        };
        let mirrored = turned.outline(center);
        let pairs = outline.iter().zip(&mirrored);
        assert!(
            pairs
                .into_iter()
                .all(|(one, other)| (one.y + other.y - 0.8).abs() < 1e-12)
        );
    }

    #[test]
    fn what_the_branches_do_not_reach_is_an_error() {
        let error = at_rest(Branch::Oblate, 2.0, 1e-6).expect_err("its poles would meet");
        assert!(error.to_string().contains("oblate"), "{error}");
        let error = at_rest(Branch::Stomatocyte, 1.1, 1e-6).expect_err("too round for a cup");
        assert!(error.to_string().contains("0.86"), "{error}");
        for enclosed in [0.0, -1.0, f64::NAN] {
            let error = BodyAtRest::new((Branch::Oblate, false), enclosed, None);
            assert!(
                matches!(error, Err(ClosedSurfaceError::NoVolume { .. })),
                "{error:?}"
            );
        }
    }
}
