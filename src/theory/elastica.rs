//! The closed curve of least bending energy ½∫κ² ds among those of the same length and enclosed area: an elastica.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use differential_equations::prelude::{BVP, Boundary, ExplicitRungeKutta, ODE, Shooting};
use nalgebra::Rotation2;

use crate::geometry::{Point, Vector};

/// Below this reduced area opposite sides of the curve would meet (0.27095): the elastica crosses itself.
pub const LEAST_REDUCED_AREA: f64 = 0.271;
/// Nearer to 1 than this the curve is a circle for every purpose: its amplitude is √(2(1 − α)/3).
const CIRCLE: f64 = 1e-9;
/// The reduced area is lowered by this much at a time: each curve is the start for the next.
const CONTINUATION: f64 = 0.25;
/// The residual of the boundary conditions, and the error of the integration, at a length of 2π.
const TOLERANCE: f64 = 1e-11;
/// Pieces of a quarter of the outline.
const PIECES: usize = 256;

/// The closed elastica of a reduced area α = 4πA/L², with two mirror axes. Lengths are in parts of L.
#[derive(Debug, Clone, PartialEq)]
pub struct Elastica {
    /// α = 4πA/L²: 1 for a circle.
    pub reduced_area: f64,
    /// Ê = (½∫κ² ds)·L/(2π²): 1 for a circle.
    pub energy: f64,
    /// λL²: the derivative of ½∫κ² ds by the length is −λ, at constant area.
    pub tension: f64,
    /// The extent along the long axis.
    pub length: f64,
    /// The extent across it, half way along it.
    pub waist: f64,
    /// The greatest extent across it.
    pub width: f64,
    /// Curvatures times L: at the middle of a long side, and at a tip.
    pub curvatures: [f64; 2],
    /// A quarter of the curve about its centre, by arc length, from the middle of the long side y < 0 to the tip x > 0.
    quarter: Vec<Vector>,
}

/// Why there is no elastica.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ElasticaError {
    /// No curve encloses more than a circle.
    #[error(
        "the reduced area 4πA/L² = {reduced_area} is no number from 0 to 1: no curve of this length encloses so much"
    )]
    TooRound {
        /// α.
        reduced_area: f64,
    },
    /// The vesicle encloses nothing.
    #[error("the vesicle encloses no area: A = {enclosed}")]
    NoArea {
        /// A.
        enclosed: f64,
    },
    /// Opposite sides would meet.
    #[error(
        "at the reduced area 4πA/L² = {reduced_area:.4} opposite sides of the membrane would cross: the theory of one \
         curve holds down to {LEAST_REDUCED_AREA}"
    )]
    Touching {
        /// α.
        reduced_area: f64,
    },
    /// The boundary value problem was not solved.
    #[error("the elastica of the reduced area {reduced_area:.4} was not found: {reason}")]
    Unsolved {
        /// α.
        reduced_area: f64,
        /// What the solver says.
        reason: String,
    },
}

/// x, y, θ, κ, κ', the area and the energy up to s, λ and p.
type State = [f64; 9];

/// κ'' + κ³/2 − λκ − p = 0 by arc length s, from the middle of a long side to a tip, where the length is 2π.
///
/// With x' = cos θ, y' = sin θ, θ' = κ; λ and p are constant, and are found with the curve.
struct Quarter {
    reduced_area: f64,
}

impl ODE<f64, State> for Quarter {
    fn diff(&self, _s: f64, state: &State, derivative: &mut State) {
        let [x, _, theta, kappa, slope, _, _, lambda, p] = *state;
        let (sine, cosine) = theta.sin_cos();
        *derivative = [
            cosine,
            sine,
            kappa,
            slope,
            lambda * kappa + p - 0.5 * kappa.powi(3),
            x * sine,
            0.5 * kappa * kappa,
            0.0,
            0.0,
        ];
    }
}

impl Boundary<f64, State> for Quarter {
    fn boundary(&self, start: &State, end: &State, residual: &mut State) {
        // The whole area is α L²/(4π) = α π.
        let area = 0.25 * PI * self.reduced_area;
        *residual = [
            start[0],
            start[1],
            start[2],
            start[4],
            start[5],
            start[6],
            end[2] - FRAC_PI_2,
            end[4],
            end[5] - area,
        ];
    }
}

impl Quarter {
    /// The states at the ends of the pieces, from a first guess of that at s = 0.
    fn solve(&self, start: State) -> Result<Vec<State>, ElasticaError> {
        let integrator = ExplicitRungeKutta::dop853()
            .rtol(0.1 * TOLERANCE)
            .atol(0.1 * TOLERANCE);
        let ends: Vec<f64> = (0..=PIECES)
            .map(|piece| FRAC_PI_2 * piece as f64 / PIECES as f64)
            .collect();
        let method = Shooting::single(integrator)
            .tolerance(TOLERANCE)
            .max_iterations(30);
        let solution = BVP::ode(self, 0.0, FRAC_PI_2, start)
            .method(method)
            .t_eval(ends)
            .solve();
        match solution {
            Ok(solution) if solution.y.len() == PIECES + 1 => Ok(solution.y),
            Ok(_) => Err(self.unsolved("the integration ended early".to_owned())),
            Err(error) => Err(self.unsolved(format!("{error:?}"))),
        }
    }

    fn unsolved(&self, reason: String) -> ElasticaError {
        ElasticaError::Unsolved {
            reduced_area: self.reduced_area,
            reason,
        }
    }
}

impl Elastica {
    /// Of this reduced area.
    ///
    /// # Errors
    /// [`ElasticaError`]: there is none, or it was not found.
    pub fn new(reduced_area: f64) -> Result<Self, ElasticaError> {
        if !(reduced_area > 0.0 && reduced_area <= 1.0 + CIRCLE) {
            return Err(ElasticaError::TooRound { reduced_area });
        }
        if reduced_area < LEAST_REDUCED_AREA {
            return Err(ElasticaError::Touching { reduced_area });
        }
        let missing = 1.0 - reduced_area;
        if missing < CIRCLE {
            return Ok(Self::circle());
        }
        let steps = (missing / CONTINUATION).ceil() as usize;
        // Near the circle κ is 1 − √(6(1 − α)) cos 2s: the mode n = 2, which has λ = 3/2 − n² and p = 1/2 − λ.
        let first = missing / steps as f64;
        let mut start = [
            0.0,
            0.0,
            0.0,
            1.0 - (6.0 * first).sqrt(),
            0.0,
            0.0,
            0.0,
            -2.5,
            3.0,
        ];
        let mut states = Vec::new();
        for step in 1..=steps {
            let reduced_area = 1.0 - missing * step as f64 / steps as f64;
            states = Quarter { reduced_area }.solve(start)?;
            start = states[0];
        }
        Ok(Self::of_states(reduced_area, &states))
    }

    /// α = 1.
    pub fn circle() -> Self {
        let angle = |piece: usize| FRAC_PI_2 * (piece as f64 / PIECES as f64 - 1.0);
        let quarter =
            (0..=PIECES).map(|piece| Vector::new(angle(piece).cos(), angle(piece).sin()) / TAU);
        let diameter = 2.0 / TAU;
        Self {
            reduced_area: 1.0,
            energy: 1.0,
            tension: -2.5 * TAU * TAU,
            length: diameter,
            waist: diameter,
            width: diameter,
            curvatures: [TAU; 2],
            quarter: quarter.collect(),
        }
    }

    fn of_states(reduced_area: f64, states: &[State]) -> Self {
        let (first, last) = (&states[0], &states[PIECES]);
        let [tip_x, tip_y, _, tip_curvature, _, _, energy, lambda, _] = *last;
        let quarter: Vec<Vector> = states
            .iter()
            .map(|state| Vector::new(state[0], state[1] - tip_y) / TAU)
            .collect();
        // The point where θ = 0 lies between two ends of pieces, on the osculating circle of each.
        let depth = |state: &State| {
            let rise = if state[3] > 0.0 {
                0.5 * state[2] * state[2] / state[3]
            } else {
                0.0
            };
            tip_y - state[1] + rise
        };
        let lowest = states
            .iter()
            .max_by(|one, other| (tip_y - one[1]).total_cmp(&(tip_y - other[1])));
        Self {
            reduced_area,
            // Four quarters, at L = 2π: Ê = 4 E/π.
            energy: 4.0 * energy / PI,
            tension: lambda * TAU * TAU,
            length: 2.0 * tip_x / TAU,
            waist: 2.0 * tip_y / TAU,
            width: 2.0 * lowest.map_or(tip_y, depth) / TAU,
            curvatures: [first[3], tip_curvature].map(|curvature| curvature * TAU),
            quarter,
        }
    }

    /// The closed curve of this length about a centre, with its long axis along a unit vector; counter-clockwise, the last point
    /// is the first one.
    pub fn outline(&self, length: f64, center: Point, axis: Vector) -> Vec<Point> {
        let turn = Rotation2::rotation_between(&Vector::x(), &axis);
        let place = |x: f64, y: f64| center + turn * Vector::new(x, y) * length;
        let quarter = || self.quarter.iter();
        // From the middle of the lower side: each of the other quarters without its first point, which it shares.
        let lower_right = quarter().map(|at| place(at.x, at.y));
        let upper_right = quarter().rev().skip(1).map(|at| place(at.x, -at.y));
        let upper_left = quarter().skip(1).map(|at| place(-at.x, -at.y));
        let lower_left = quarter().rev().skip(1).map(|at| place(-at.x, at.y));
        lower_right
            .chain(upper_right)
            .chain(upper_left)
            .chain(lower_left)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn elastica(reduced_area: f64) -> Elastica {
        Elastica::new(reduced_area).expect("it is in the range")
    }

    /// α, Ê, length/L, waist/L, and the curvatures at a length of 2π: computed by another program by the same equations
    /// (docs/guide/shapes.md).
    const TABLE: [(f64, f64, [f64; 2], [f64; 2]); 11] = [
        (0.99, 1.030085, [0.34310, 0.29113], [0.75840, 1.24914]),
        (0.95, 1.152154, [0.37036, 0.25423], [0.46680, 1.57174]),
        (0.90, 1.308801, [0.38821, 0.22413], [0.25137, 1.82792]),
        (0.85, 1.470242, [0.40032, 0.19957], [0.08690, 2.03556]),
        (0.80, 1.636809, [0.40939, 0.17781], [-0.05162, 2.21991]),
        (0.70, 1.986839, [0.42207, 0.13906], [-0.28449, 2.55356]),
        (0.60, 2.362388, [0.43002, 0.10399], [-0.48189, 2.86620]),
        (0.50, 2.767871, [0.43466, 0.07108], [-0.65675, 3.17435]),
        (0.40, 3.208969, [0.43666, 0.03952], [-0.81519, 3.48903]),
        (0.35, 3.445121, [0.43680, 0.02409], [-0.88927, 3.65185]),
        (0.30, 3.693159, [0.43641, 0.00881], [-0.96020, 3.81999]),
    ];

    #[test]
    fn the_elastica_is_that_of_another_program() {
        for (alpha, energy, extents, curvatures) in TABLE {
            let own = elastica(alpha);
            let pairs = [
                (own.energy, energy, 6e-7),
                (own.length, extents[0], 1.1e-5),
                (own.waist, extents[1], 1.1e-5),
                (own.curvatures[0] / TAU, curvatures[0], 1.1e-5),
                (own.curvatures[1] / TAU, curvatures[1], 1.1e-5),
            ];
            for (number, (own, other, bound)) in pairs.into_iter().enumerate() {
                assert!(
                    (own - other).abs() <= bound,
                    "{alpha}, {number}: {own} {other}"
                );
            }
        }
    }

    /// The fit of Ê over z = 1 − α, by the same program.
    #[test]
    fn the_energy_is_the_fitted_one_to_four_millionths() {
        let coefficients = [
            1.0,
            2.99983839,
            0.8476068,
            0.31462224,
            0.2802542,
            -0.12965449,
            0.20851884,
        ];
        for alpha in [0.28, 0.33, 0.42, 0.55, 0.67, 0.78, 0.86, 0.93, 0.98, 0.999] {
            let powers = coefficients.iter().rev();
            let fit = powers.fold(0.0, |sum, coefficient| sum * (1.0 - alpha) + coefficient);
            let own = elastica(alpha).energy;
            assert!((own - fit).abs() <= 4e-6, "{alpha}: {own} {fit}");
        }
    }

    /// Length, area and bending energy of the outline itself.
    #[test]
    fn the_outline_has_the_length_and_the_area() {
        for alpha in [1.0, 1.0 - 1e-6, 0.9, 0.6, 0.28] {
            let own = elastica(alpha);
            let (length, center) = (1.7, Point::new(0.3, -0.2));
            let outline = own.outline(length, center, Vector::new(0.6, 0.8));
            assert!((outline[0] - outline[outline.len() - 1]).norm() < 1e-12);
            let pairs = || {
                outline
                    .windows(2)
                    .map(|pair| [pair[0] - center, pair[1] - center])
            };
            let sum: f64 = pairs().map(|[from, to]| (to - from).norm()).sum();
            let area: f64 = pairs().map(|[from, to]| 0.5 * from.perp(&to)).sum();
            assert!((sum / length - 1.0).abs() < 1e-5, "{alpha}: {sum}");
            let quotient = 4.0 * PI * area / (length * length);
            assert!((quotient - alpha).abs() < 3e-5, "{alpha}: {quotient}");
            // Long along the axis.
            let along = |at: &Point| (at - center).dot(&Vector::new(0.6, 0.8));
            let most = outline.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
            assert!((2.0 * most - own.length * length).abs() < 1e-9, "{alpha}");
            // λ is the derivative of the energy: d(½∫κ²)/dL at constant A is (2π²/L²)(−Ê − 2αÊ').
            if (0.3..0.999).contains(&alpha) {
                let [below, above] = [-1e-3, 1e-3].map(|step| elastica(alpha + step).energy);
                let slope = (above - below) / 2e-3;
                let tension = 2.0 * PI * PI * (own.energy + 2.0 * alpha * slope);
                assert!(
                    (own.tension / tension - 1.0).abs() < 1e-4,
                    "{alpha}: {} {tension}",
                    own.tension
                );
            }
        }
    }

    #[test]
    fn the_waist_appears_where_the_curvature_changes_its_sign() {
        let convex = elastica(0.8196);
        let waisted = elastica(0.8193);
        assert!(convex.curvatures[0] > 0.0 && convex.width == convex.waist);
        assert!(waisted.curvatures[0] < 0.0 && waisted.width > waisted.waist);
        for (alpha, width) in [(0.8, 0.17818), (0.6, 0.12919), (0.3, 0.09307)] {
            let own = elastica(alpha).width;
            assert!((own - width).abs() < 1e-4, "{alpha}: {own}");
        }
    }

    #[test]
    fn what_is_no_curve_is_an_error() {
        for alpha in [f64::NAN, 0.0, -1.0, 1.01, f64::INFINITY] {
            assert!(
                matches!(Elastica::new(alpha), Err(ElasticaError::TooRound { .. })),
                "{alpha}"
            );
        }
        let error = Elastica::new(0.2).expect_err("its sides would cross");
        assert!(
            error.to_string().contains("0.2000 opposite sides"),
            "{error}"
        );
        assert!(elastica(LEAST_REDUCED_AREA).waist > 0.0);
    }
}
