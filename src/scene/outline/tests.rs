//! Distances against a brute-force search that shares no formula with the code.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::UnitComplex;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

const CIRCLE: Curve = Curve::Circle { radius: 0.25 };
const CASSINI: Curve = Curve::Cassini {
    ratio: 0.92,
    half_length: 0.32,
};
const DISCOCYTE: Curve = Curve::Discocyte { radius: 0.4 };

/// With an opening narrower than a half-plane, and as a bow.
const CUPS: [Curve; 2] = [
    Curve::Stomatocyte {
        radius: 0.25,
        thickness: 0.14,
        opening: 60.0,
    },
    Curve::Stomatocyte {
        radius: 0.35,
        thickness: 0.25,
        opening: 200.0,
    },
];

/// Every kind with two axes of symmetry, and the extremes that are legal.
const CURVES: [Curve; 11] = [
    CIRCLE,
    Curve::Ellipse {
        half_axes: [0.4, 0.2],
    },
    Curve::Ellipse {
        half_axes: [0.1, 0.3],
    },
    Curve::Ellipse {
        half_axes: [0.3, 0.3],
    },
    Curve::Ellipse {
        half_axes: [0.45, 0.009],
    },
    CASSINI,
    Curve::Cassini {
        ratio: 0.0,
        half_length: 0.3,
    },
    Curve::Cassini {
        ratio: 0.6,
        half_length: 0.3,
    },
    Curve::Cassini {
        ratio: 0.72,
        half_length: 0.3,
    },
    Curve::Cassini {
        ratio: 0.999,
        half_length: 0.4,
    },
    DISCOCYTE,
];

fn at_origin(curve: Curve) -> OutlineDistance {
    OutlineDistance::new(&Outline {
        curve,
        center: [0.0, 0.0],
        angle: 0.0,
    })
}

fn generator() -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(20)
}

fn random_point(generator: &mut ChaCha8Rng, half_width: f64) -> Point {
    Point::from([(); 2].map(|()| half_width * (2.0 * generator.random::<f64>() - 1.0)))
}

/// A point of the curve at a polar or eccentric angle, by the textbook's formula.
fn textbook_point(curve: Curve, angle: f64) -> Point {
    let (sine, cosine) = angle.sin_cos();
    match curve {
        Curve::Circle { radius } => Point::new(radius * cosine, radius * sine),
        Curve::Ellipse { half_axes: [a, b] } => Point::new(a * cosine, b * sine),
        Curve::Cassini { ratio, half_length } => {
            let a2 = half_length.powi(2) / (1.0 + ratio * ratio);
            let c2 = ratio * ratio * a2;
            let root = (a2 * a2 - (c2 * (2.0 * angle).sin()).powi(2)).sqrt();
            // Where cos 2θ < 0 the sum cancels: (a⁴ − c⁴)/(root − c² cos 2θ) is the same.
            let along = c2 * (2.0 * angle).cos();
            let r2 = if along >= 0.0 {
                along + root
            } else {
                (a2 - c2) * (a2 + c2) / (root - along)
            };
            Point::new(r2.sqrt() * cosine, r2.sqrt() * sine)
        }
        Curve::Discocyte { radius } => {
            let t = cosine;
            let thickness = 0.207 + 2.003 * t.powi(2) - 1.123 * t.powi(4);
            Point::new(radius * t, 0.5 * radius * sine * thickness)
        }
        // A quarter of the angle for each of the outer side, an end, the inner side and the other end: counter-clockwise.
        Curve::Stomatocyte {
            radius,
            thickness,
            opening,
        } => {
            let quarter = (angle.rem_euclid(TAU) / FRAC_PI_2).min(4.0 - 1e-15);
            let (side, share) = (quarter.floor(), quarter.fract());
            let half_arc = PI - 0.5 * opening.to_radians();
            let along =
                |distance: f64, angle: f64| distance * Vector::new(angle.sin(), -angle.cos());
            let half = 0.5 * thickness;
            let end = |angle: f64, turn: f64| {
                let (outwards, forwards) = (along(1.0, angle), along(1.0, angle + FRAC_PI_2));
                along(radius, angle) + half * (turn.cos() * outwards + turn.sin() * forwards)
            };
            let swept = half_arc * (2.0 * share - 1.0);
            Point::from(match side as u8 {
                0 => along(radius + half, swept),
                1 => end(half_arc, PI * share),
                2 => along(radius - half, -swept),
                _ => end(-half_arc, PI * (1.0 + share)),
            })
        }
    }
}

/// The curve sampled once, for many searches.
struct BruteForce {
    curve: Curve,
    samples: Vec<Point>,
}

impl BruteForce {
    const COUNT: usize = 40_000;

    fn new(curve: Curve) -> Self {
        let angle = |k: usize| TAU * k as f64 / Self::COUNT as f64;
        let samples = (0..Self::COUNT)
            .map(|k| textbook_point(curve, angle(k)))
            .collect();
        Self { curve, samples }
    }

    /// The distance: the samples' local minima, each narrowed by thirds without any derivative.
    /// What is left is rounding, since the distance is stationary.
    fn distance(&self, point: Point) -> f64 {
        let far = |at: Point| length(at - point);
        let sampled = |k: usize| far(self.samples[k % Self::COUNT]);
        let step = TAU / Self::COUNT as f64;
        let least = (0..Self::COUNT).map(sampled).fold(f64::INFINITY, f64::min);
        let longest_chord = 5e-3;
        let mut best = least;
        for k in Self::COUNT..2 * Self::COUNT {
            let here = sampled(k);
            if here > least + longest_chord || here > sampled(k - 1) || here > sampled(k + 1) {
                continue;
            }
            let (mut low, mut high) = (step * (k as f64 - 1.0), step * (k as f64 + 1.0));
            for _ in 0..60 {
                let third = (high - low) / 3.0;
                let at = |angle| far(textbook_point(self.curve, angle));
                let (left, right) = (at(low + third), at(high - third));
                best = best.min(left).min(right);
                if left < right {
                    high -= third
                } else {
                    low += third
                }
            }
        }
        best
    }

    /// Whether a ray from the point crosses the samples' polygon an odd number of times.
    fn encloses(&self, point: Point) -> bool {
        let [x, y] = point.into();
        let mut inside = false;
        for k in 0..Self::COUNT {
            let [[x0, y0], [x1, y1]]: [[f64; 2]; 2] =
                [k, (k + 1) % Self::COUNT].map(|sample| self.samples[sample].into());
            if (y0 > y) != (y1 > y) && x < x0 + (y - y0) / (y1 - y0) * (x1 - x0) {
                inside = !inside;
            }
        }
        inside
    }
}

#[test]
fn distances_are_those_of_a_brute_force_search() {
    let mut generator = generator();
    for curve in CURVES.into_iter().chain(CUPS) {
        let outline = at_origin(curve);
        let brute = BruteForce::new(curve);
        let mut inside = 0;
        for half_width in [0.5, 0.15, 0.02] {
            for _ in 0..60 {
                let point = random_point(&mut generator, half_width);
                let value = outline.signed_distance(point).value;
                let error = (value.abs() - brute.distance(point)).abs();
                assert!(
                    error < 1e-15,
                    "{curve:?} at {point:?}: {value}, off by {error:e}"
                );
                if value.abs() > 1e-6 {
                    assert_eq!(value > 0.0, brute.encloses(point), "{curve:?} at {point:?}");
                }
                inside += usize::from(value > 0.0);
            }
        }
        assert!(inside > 10 && inside < 180, "{curve:?}: {inside}");
    }
}

/// Points where two points of a discocyte of radius 1 compete, dense around where they part: at a
/// depth δ under the cusp of its evolute that region is about δ^(3/2) wide.
fn under_the_cusp(generator: &mut ChaCha8Rng) -> impl Iterator<Item = Point> {
    let cusp = Point::new(0.703_897_338_906_619_7, 0.077_233_284_893_151_07);
    let down = Vector::new(-0.283_369_128_534_363_75, -0.959_010_915_992_97);
    (0..1000).map(move |_| {
        let random = random_point(generator, 1.0);
        let depth = 10_f64.powf(-4.0 + 3.0 * random.y);
        let across = 3.0 * depth.powf(1.5) * random.x;
        let at = cusp + depth * down + across * Vector::new(-down.y, down.x);
        Point::new(at.x, at.y.abs())
    })
}

#[test]
fn distances_hold_where_minima_meet() {
    // On the axes and next to them; for the discocyte under the cusp of its evolute.
    let mut generator = generator();
    for curve in CURVES {
        let outline = at_origin(curve);
        let brute = BruteForce::new(curve);
        let mut points = vec![Point::origin()];
        for beside in [0.0, 1e-300, 1e-17, 1e-12, 1e-8, 1e-4] {
            for _ in 0..10 {
                let along = 0.5 * generator.random::<f64>();
                points.push(Point::new(along, beside));
                points.push(Point::new(beside, along));
            }
        }
        if let Curve::Discocyte { radius } = curve {
            points.extend(under_the_cusp(&mut generator).map(|point| radius * point));
        }
        for point in points {
            let SignedDistance { value, gradient } = outline.signed_distance(point);
            let error = (value.abs() - brute.distance(point)).abs();
            assert!(
                error < 1e-15,
                "{curve:?} at {point:?}: {value}, off by {error:e}"
            );
            assert!((length(gradient) - 1.0).abs() < 1e-15);
        }
    }
}

#[test]
fn the_gradient_is_a_unit_vector_and_the_slope_of_the_distance() {
    let mut generator = generator();
    let step = 1e-6;
    for curve in CURVES.into_iter().chain(CUPS) {
        let outline = at_origin(curve);
        let mut compared = 0;
        for _ in 0..500 {
            let point = random_point(&mut generator, 0.5);
            let gradient = outline.signed_distance(point).gradient;
            assert!((length(gradient) - 1.0).abs() < 1e-15);
            let beside = |k: usize, step: f64| {
                let mut moved = point;
                moved[k] += step;
                outline.signed_distance(moved)
            };
            // Where the slope itself turns over a step, at the medial axis or an end of it, a
            // difference says nothing.
            let turns = (0..2).any(|k| {
                let (before, after) = (beside(k, -step).gradient, beside(k, step).gradient);
                length(before - after) > 1e-3
            });
            if turns {
                continue;
            }
            compared += 1;
            for (k, component) in gradient.iter().enumerate() {
                let difference = (beside(k, step).value - beside(k, -step).value) / (2.0 * step);
                assert!(
                    (difference - component).abs() < 1e-5,
                    "{curve:?} at {point:?}"
                );
            }
        }
        assert!(compared >= 495, "{curve:?}: {compared}");
    }
}

#[test]
fn on_the_curve_the_distance_is_zero_and_the_gradient_the_inward_normal() {
    for curve in CURVES.into_iter().chain(CUPS) {
        let outline = at_origin(curve);
        for k in 0..1000 {
            let angle = TAU * (f64::from(k) + 0.3) / 1000.0;
            let on_curve = textbook_point(curve, angle);
            let SignedDistance { value, gradient } = outline.signed_distance(on_curve);
            assert!(value.abs() < 1e-14, "{curve:?} at {on_curve:?}: {value:e}");
            // A step inwards along the normal is a step in s.
            let step = 1e-4;
            let inside = on_curve + step * gradient;
            let value = outline.signed_distance(inside).value;
            assert!(
                (value - step).abs() < 1e-14,
                "{curve:?} at {on_curve:?}: {value:e}"
            );
        }
    }
}

#[test]
fn the_distance_moves_and_turns_with_the_outline() {
    let mut generator = generator();
    for curve in CURVES.into_iter().chain(CUPS) {
        let fixed = at_origin(curve);
        for angle in [0.0, 37.0, 90.0, -123.4, 360.0] {
            let center = Point::new(0.4, 0.6);
            let moved = OutlineDistance::new(&Outline {
                curve,
                center: center.into(),
                angle,
            });
            let turn = UnitComplex::new(f64::to_radians(angle));
            for _ in 0..50 {
                let point = random_point(&mut generator, 0.5);
                let expected = fixed.signed_distance(point);
                let actual = moved.signed_distance(center + turn * point.coords);
                assert!(
                    (actual.value - expected.value).abs() < 1e-15,
                    "{curve:?} at {point:?}"
                );
                let error = length(actual.gradient - turn * expected.gradient);
                assert!(error < 1e-9, "{curve:?} at {point:?}: {error:e}");
            }
        }
    }
}

#[test]
fn half_a_turn_changes_nothing_but_the_sign_of_the_gradient() {
    let mut generator = generator();
    for curve in CURVES {
        for angle in [0.0, 30.0, 90.0] {
            let center = Point::new(0.5, 0.5);
            let outline = OutlineDistance::new(&Outline {
                curve,
                center: center.into(),
                angle,
            });
            for _ in 0..50 {
                // Differences to 0.5 that are exact, so that the points are mirror images exactly.
                let offset = random_point(&mut generator, 0.5).coords;
                let offset = offset.map(|c| (c * 4096.0).round() / 4096.0);
                let there = outline.signed_distance(center + offset);
                let mirrored = outline.signed_distance(center - offset);
                assert_eq!(there.value, mirrored.value);
                if offset.x != 0.0 && offset.y != 0.0 {
                    assert_eq!(there.gradient, -mirrored.gradient);
                }
            }
        }
    }
}

#[test]
fn the_distance_is_continuous_across_the_axes() {
    for curve in CURVES {
        let outline = at_origin(curve);
        for k in 0..200 {
            let along = 0.5 * f64::from(k) / 200.0;
            for beside in [1e-14, 1e-10] {
                let value = |point| outline.signed_distance(point).value;
                for (on, near) in [
                    ([along, 0.0], [along, beside]),
                    ([0.0, along], [beside, along]),
                ]
                .map(|(on, near)| (Point::from(on), Point::from(near)))
                {
                    assert!(
                        (value(on) - value(near)).abs() <= beside + 1e-15,
                        "{curve:?} at {on:?}"
                    );
                    assert_eq!(value(near), value(-near));
                }
            }
        }
    }
}

#[test]
fn special_cases_are_circles() {
    let mut generator = generator();
    let circle = at_origin(Curve::Circle { radius: 0.3 });
    for curve in [
        Curve::Ellipse {
            half_axes: [0.3, 0.3],
        },
        Curve::Cassini {
            ratio: 0.0,
            half_length: 0.3,
        },
    ] {
        let outline = at_origin(curve);
        assert!((outline.signed_distance(Point::origin()).value - 0.3).abs() < 1e-16);
        for _ in 0..300 {
            let point = random_point(&mut generator, 0.5);
            let (actual, expected) = (
                outline.signed_distance(point),
                circle.signed_distance(point),
            );
            assert!(
                (actual.value - expected.value).abs() < 2e-16,
                "{curve:?} at {point:?}"
            );
            let error = actual.gradient - expected.gradient;
            assert!(error.abs().max() < 1e-13);
        }
        assert!((outline.length() / circle.length() - 1.0).abs() < 1e-15);
        assert!((outline.area() / circle.area() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn the_cassini_oval_has_its_waist_and_its_length() {
    let a_squared = 0.32_f64.powi(2) / (1.0 + 0.92 * 0.92);
    let half_waist = (a_squared * (1.0 - 0.92 * 0.92)).sqrt();
    assert!((2.0 * half_waist - 0.1846).abs() < 1e-4);
    let oval = at_origin(CASSINI);
    assert!((oval.signed_distance(Point::origin()).value - half_waist).abs() < 1e-16);
    assert!(
        oval.signed_distance(Point::new(0.0, half_waist))
            .value
            .abs()
            < 1e-16
    );
    assert!(oval.signed_distance(Point::new(-0.32, 0.0)).value.abs() < 1e-16);
    // Upright, its long axis is y.
    let outline = Outline {
        curve: CASSINI,
        center: [0.5, 0.5],
        angle: 90.0,
    };
    let upright = OutlineDistance::new(&outline);
    assert!(upright.signed_distance(Point::new(0.5, 0.82)).value.abs() < 2e-16);
    assert!(
        upright
            .signed_distance(Point::new(0.5 + half_waist, 0.5))
            .value
            .abs()
            < 2e-16
    );
}

/// What the distance must not be: a level-set value divided by the length of its gradient.
#[test]
fn a_scaled_level_set_is_not_the_distance() {
    let a2 = 0.32_f64.powi(2) / (1.0 + 0.92 * 0.92);
    let c2 = 0.92 * 0.92 * a2;
    let scaled = |x: f64, y: f64| {
        let r2 = x * x + y * y;
        let level = a2 * a2 - (r2 * r2 - 2.0 * c2 * (x * x - y * y) + c2 * c2);
        level / (4.0 * x * (r2 - c2)).hypot(4.0 * y * (r2 + c2))
    };
    let oval = at_origin(CASSINI);
    // At the curve the two agree to first order …
    for angle in [0.1, 0.8, 1.5] {
        let point = (1.0 - 1e-6) * textbook_point(CASSINI, angle);
        let ratio = scaled(point.x, point.y) / oval.signed_distance(point).value;
        assert!((ratio - 1.0).abs() < 1e-4, "{ratio}");
    }
    // … but within two interface widths of it they are far apart.
    let [x, y] = [0.3, 0.0];
    assert!((oval.signed_distance(Point::new(x, y)).value - 0.02).abs() < 1e-15);
    assert!((scaled(x, y) / 0.02 - 1.0).abs() > 0.05, "{}", scaled(x, y));
    let [x, y] = [0.0, 0.05];
    let ratio = scaled(x, y) / oval.signed_distance(Point::new(x, y)).value;
    assert!((ratio - 1.0).abs() > 0.2, "{ratio}");
}

#[test]
fn a_union_has_the_largest_distance() {
    let circle = |x: f64| {
        OutlineDistance::new(&Outline {
            curve: CIRCLE,
            center: [x, 0.5],
            angle: 0.0,
        })
    };
    let both = [circle(0.3), circle(0.7)];
    assert_eq!(union_distance(&both, Point::new(0.3, 0.5)).value, 0.25);
    assert_eq!(union_distance(&both, Point::new(0.7, 0.5)).value, 0.25);
    let right = union_distance(&both, Point::new(0.9, 0.5));
    assert!((right.value - 0.05).abs() < 1e-15);
    assert_eq!(right.gradient, -Vector::x());
    let left = union_distance(&both, Point::new(0.1, 0.5));
    assert_eq!(left.gradient, Vector::x());
    // Order does not matter, and a union of one is that one.
    let swapped = [circle(0.7), circle(0.3)];
    for point in [[0.45, 0.6], [0.2, 0.9], [0.6, 0.1]].map(Point::from) {
        assert_eq!(
            union_distance(&both, point),
            union_distance(&swapped, point)
        );
        assert_eq!(
            union_distance(&both[..1], point),
            both[0].signed_distance(point)
        );
    }
    assert_eq!(
        phase_profile(union_distance(&[], Point::new(0.5, 0.5)), 0.01),
        (-1.0, Vector::zeros())
    );
}

#[test]
fn the_profile_is_the_tanh_of_the_distance() {
    let outline = at_origin(CASSINI);
    let (width, step) = (0.01, 1e-6);
    let profile = |point| phase_profile(outline.signed_distance(point), width);
    for point in [[0.31, 0.02], [0.05, 0.1], [0.2, -0.15], [-0.33, 0.0]].map(Point::from) {
        let (value, gradient) = profile(point);
        let s = outline.signed_distance(point).value;
        assert!((value - (s / (2.0_f64.sqrt() * width)).tanh()).abs() < 1e-15);
        for k in 0..2 {
            let beside = |step: f64| {
                let mut moved = point;
                moved[k] += step;
                profile(moved).0
            };
            let difference = (beside(step) - beside(-step)) / (2.0 * step);
            assert!(
                (difference - gradient[k]).abs() < 1e-5,
                "{point:?}: {difference}"
            );
        }
    }
    // Far away: ±1 and no slope, however thin the interface.
    let distance = |value| SignedDistance {
        value,
        gradient: Vector::x(),
    };
    assert_eq!(phase_profile(distance(1.0), 1e-6), (1.0, Vector::zeros()));
    assert_eq!(phase_profile(distance(-1.0), 1e-6), (-1.0, Vector::zeros()));
    // On the curve: 0 and the slope 1/(√2 ε).
    let (value, gradient) = phase_profile(distance(0.0), width);
    assert_eq!(value, 0.0);
    assert!((gradient[0] * 2.0_f64.sqrt() * width - 1.0).abs() < 1e-15);
}

#[test]
fn bounding_boxes_are_tight() {
    for curve in CURVES.into_iter().chain(CUPS) {
        let brute = BruteForce::new(curve);
        for angle in [0.0, 90.0, 33.0, -60.0, 200.0] {
            let outline = Outline {
                curve,
                center: [0.5, 0.4],
                angle,
            };
            let BoundingBox { lower, upper } = OutlineDistance::new(&outline).bounding_box();
            let (sine, cosine) = f64::to_radians(angle).sin_cos();
            let reached = |x: f64, y: f64| {
                let at = |sample: &Point| sample.coords.dot(&Vector::new(x, y));
                brute
                    .samples
                    .iter()
                    .map(at)
                    .fold(f64::NEG_INFINITY, f64::max)
            };
            for (actual, sampled) in [
                (upper[0] - 0.5, reached(cosine, -sine)),
                (0.5 - lower[0], reached(-cosine, sine)),
                (upper[1] - 0.4, reached(sine, cosine)),
                (0.4 - lower[1], reached(-sine, -cosine)),
            ] {
                // The samples are at most 3e-5 apart around a radius of curvature of 1.8e-4.
                let excess = actual - sampled;
                assert!((-2e-16..1e-6).contains(&excess), "{outline:?}: {excess:e}");
            }
        }
    }
}

#[test]
fn the_wall_is_as_far_as_the_nearest_outline() {
    let outline = |curve, center, angle| {
        OutlineDistance::new(&Outline {
            curve,
            center,
            angle,
        })
    };
    let upright = outline(CASSINI, [0.5, 0.5], 90.0);
    assert!((wall_distance(std::slice::from_ref(&upright), Geometry::Planar) - 0.18).abs() < 1e-15);
    let across = outline(CIRCLE, [0.2, 0.5], 0.0);
    assert!((wall_distance(&[upright, across], Geometry::Planar) + 0.05).abs() < 1e-15);
    let above = outline(
        Curve::Ellipse {
            half_axes: [0.3, 0.1],
        },
        [0.5, 0.65],
        90.0,
    );
    assert!((wall_distance(&[above], Geometry::Planar) - 0.05).abs() < 1e-15);
}

#[test]
fn lengths_and_areas_are_those_of_the_curves() {
    let circle = at_origin(CIRCLE);
    assert_eq!(circle.isoperimetric_quotient(), 1.0);
    let ellipse = at_origin(Curve::Ellipse {
        half_axes: [0.4, 0.2],
    });
    assert!((ellipse.area() / (PI * 0.08) - 1.0).abs() < 1e-15);
    // 4a E(m) with the complete elliptic integral E(m = 3/4) = 1.211056027568459…
    assert!((ellipse.length() / (1.6 * 1.211_056_027_568_459_5) - 1.0).abs() < 1e-15);
    let quotient = at_origin(CASSINI).isoperimetric_quotient();
    assert!((quotient - 0.69).abs() < 0.005, "{quotient}");
    // The polygon of the samples is coarse, but independent.
    for curve in CURVES.into_iter().chain(CUPS) {
        let brute = BruteForce::new(curve);
        let (mut total, mut area) = (0.0, 0.0);
        for k in 0..BruteForce::COUNT {
            let (a, b) = (brute.samples[k], brute.samples[(k + 1) % BruteForce::COUNT]);
            total += length(b - a);
            area += 0.5 * a.coords.perp(&b.coords);
        }
        let outline = at_origin(curve);
        // A polygon of n sides falls short by about 1/n² of itself, more where they are unequal.
        for (exact, polygon) in [(outline.length(), total), (outline.area(), area)] {
            let excess = exact / polygon - 1.0;
            assert!((0.0..1e-6).contains(&excess), "{curve:?}: {excess:e}");
        }
        assert!(outline.isoperimetric_quotient() <= 1.0 + 1e-15);
    }
    // As the waist closes the oval becomes the lemniscate, whose length is twice the lemniscate
    // constant 2.622… times its half-length.
    let nearly = at_origin(Curve::Cassini {
        ratio: 1.0 - 1e-12,
        half_length: 1.0,
    });
    assert!((nearly.length() - 2.0 * 2.622_057_554_292_119_8).abs() < 1e-5);
}

#[test]
fn legal_extremes_do_not_break() {
    for curve in [
        Curve::Cassini {
            ratio: 1.0 - f64::EPSILON,
            half_length: 0.4,
        },
        Curve::Cassini {
            ratio: 1e-300,
            half_length: 0.4,
        },
        Curve::Ellipse {
            half_axes: [0.4, 1e-9],
        },
        Curve::Ellipse {
            half_axes: [1e-9, 0.4],
        },
        Curve::Circle { radius: 1e-300 },
        Curve::Discocyte { radius: 1e-9 },
        Curve::Stomatocyte {
            radius: 0.3,
            thickness: 1e-9,
            opening: 359.9,
        },
    ] {
        let outline = at_origin(curve);
        for x in [-0.5, -1e-9, 0.0, 1e-200, 0.3] {
            for y in [-0.4, 0.0, 1e-12, 0.4] {
                let SignedDistance { value, gradient } = outline.signed_distance(Point::new(x, y));
                assert!(value.is_finite(), "{curve:?} at {x}, {y}");
                assert!(
                    (length(gradient) - 1.0).abs() < 1e-15,
                    "{curve:?} at {x}, {y}: {gradient:?}"
                );
            }
        }
        assert!(outline.length() > 0.0 && outline.area() >= 0.0);
        assert!(outline.bounding_box().upper[0] > 0.0);
    }
}
