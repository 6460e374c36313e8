//! Closed surfaces of rotation of least bending energy ½∫(2H)² dA at a given area and volume, and the branches that they form.
//!
//! By arc length s from a pole, with the radius X, the angle ψ of the profile to the plane of the equator and U = ψ', the
//! meridian of such a surface obeys
//!
//!   U' = −U cos ψ/X + sin ψ cos ψ/X² + (P/2) X cos ψ + γ sin ψ/X,
//!   γ' = U²/2 − sin²ψ/(2X²) + P X sin ψ + Σ,   X' = cos ψ,
//!
//! where P and Σ are pressure and tension over the bending rigidity, and γ the multiplier of X' = cos ψ
//! (Seifert, Berndl and Lipowsky 1991). Lengths are in parts of R₀, with the area 4πR₀².

use std::f64::consts::{FRAC_PI_2, PI};

use differential_equations::prelude::{BVP, Boundary, ExplicitRungeKutta, ODE, Shooting};

use super::root::root;
use crate::geometry::Point;

/// The integration begins so far from a pole, by the series about it, whose next terms are below 1e-13.
const POLE: f64 = 2e-3;
/// The residual of the boundary conditions, and the error of the integration.
const TOLERANCE: f64 = 1e-10;
/// Pieces of either half of the meridian.
const PIECES: usize = 128;
/// The reduced volume from which a branch begins beside the sphere, and how far it is followed at a time.
const NEAR_SPHERE: f64 = 0.995;
const VOLUME_STEP: f64 = 0.01;
/// P and Σ of a sphere whose mode of two is marginal.
const MARGINAL: [f64; 2] = [12.0, -6.0];
/// Where cups branch off from the oblate shapes, nearly, and how far the difference of the curvatures at the poles is
/// followed at a time.
const CUPS_FROM: f64 = 0.5105;
const DIFFERENCE_STEP: f64 = 0.05;
/// How far the branch of the cups is followed at a time from there on, in the L2 norm of the state beside the poles, and where
/// so short a step finds no shape it ends.
const LONGEST_STEP: f64 = 0.15;
const LEAST_STEP: f64 = 1e-3;
/// Below this reduced volume the poles of an oblate shape would meet (0.5027); prolate shapes are followed as far.
pub const LEAST_REDUCED_VOLUME: f64 = 0.505;

/// Two branches, the reduced volume at which they have the same energy, and that energy W.
pub const CROSSINGS: [([Branch; 2], f64, f64); 2] = [
    ([Branch::Prolate, Branch::Oblate], 0.65108, 1.82347),
    ([Branch::Oblate, Branch::Stomatocyte], 0.59119, 1.97872),
];

/// A family of surfaces of rotation, by their reduced volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branch {
    /// Long along the axis; with a neck below v = 0.76 or so.
    Prolate,
    /// Short along the axis, biconcave below v = 0.892.
    Oblate,
    /// A cup: one of the poles is within. There are none above v = 0.66085.
    Stomatocyte,
}

/// A closed surface of rotation at which the bending energy is stationary, of the area 4π.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedSurface {
    /// v = V/(4π/3).
    pub reduced_volume: f64,
    /// W = ½∫(2H)² dA/(8π): 1 for a sphere.
    pub energy: f64,
    /// From pole to pole, along the axis.
    pub height: f64,
    /// The radius of the equator.
    pub radius: f64,
    /// The curvatures at the poles, the lower one last.
    pub pole_curvatures: [f64; 2],
    /// P, over the bending rigidity: −6 dW/dv along its branch.
    pub pressure: f64,
    /// The meridian in (r, z) from the upper pole to the lower one, with the equator at z = 0.
    pub meridian: Vec<Point>,
}

/// A surface that was not found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ClosedSurfaceError {
    /// The branch does not reach this volume.
    #[error(
        "no {} surface of the reduced volume {reduced_volume:.4} is known: {}", branch.name(), branch.reach()
    )]
    NotOnBranch {
        /// Which.
        branch: Branch,
        /// v.
        reduced_volume: f64,
    },
    /// The vesicle encloses nothing.
    #[error("the vesicle encloses no volume: V = {enclosed}")]
    NoVolume {
        /// V.
        enclosed: f64,
    },
    /// The boundary value problem was not solved.
    #[error("the surface with {condition} was not found: {reason}")]
    Unsolved {
        /// What was asked for.
        condition: String,
        /// What the solver says.
        reason: String,
    },
}

/// What singles a surface out of those that obey the equations.
#[derive(Debug, Clone, Copy)]
enum Condition<'a> {
    /// The reduced volume.
    Volume(f64),
    /// The curvature at the upper pole less that at the lower one.
    Difference(f64),
    /// On a family, where its tangent leads: what the state beside the poles misses this guess by is normal to the tangent.
    Along {
        guess: &'a State,
        tangent: &'a State,
    },
}

impl std::fmt::Display for Condition<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Volume(volume) => write!(formatter, "the reduced volume {volume}"),
            Self::Difference(difference) => {
                write!(
                    formatter,
                    "the difference {difference} of the curvatures at its poles"
                )
            }
            Self::Along { .. } => write!(formatter, "the next place on its branch"),
        }
    }
}

/// ψ, U, γ, X, the height below the pole, the area, the volume and the energy W up to s: of the upper half of the meridian and
/// of the lower one, each from its pole; then P, Σ and the lengths of both halves.
type State = [f64; 20];
const HALVES: [usize; 2] = [0, 8];
const PRESSURE: usize = 16;
const TENSION: usize = 17;
const LENGTHS: [usize; 2] = [18, 19];

/// Both halves of a meridian at once, to their common equator (ψ = π/2) at "time" 1.
struct Halves<'a> {
    condition: Condition<'a>,
}

/// The state beside a pole of this curvature, by the series.
fn beside_pole(curvature: f64, [pressure, tension]: [f64; 2]) -> [f64; 8] {
    let (s, u) = (POLE, curvature);
    let second = 0.375 * (tension * u + 0.5 * pressure);
    let third = (2.0 / 3.0 * u * second + pressure * u) / 3.0;
    [
        u * s + second / 3.0 * s.powi(3),
        u + second * s * s,
        tension * s + third * s.powi(3),
        s - u * u * s.powi(3) / 6.0,
        0.5 * u * s * s,
        PI * s * s * (1.0 - u * u * s * s / 12.0),
        0.25 * PI * u * s.powi(4),
        0.25 * u * u * s * s,
    ]
}

/// The curvature of a pole, from U beside it.
fn pole_curvature(state: &State, half: usize) -> f64 {
    let square = 0.375 * POLE * POLE;
    (state[half + 1] - square * 0.5 * state[PRESSURE]) / (1.0 + square * state[TENSION])
}

impl ODE<f64, State> for Halves<'_> {
    fn diff(&self, _time: f64, state: &State, derivative: &mut State) {
        *derivative = [0.0; 20];
        let (pressure, tension) = (state[PRESSURE], state[TENSION]);
        for (half, length) in HALVES.into_iter().zip(LENGTHS) {
            let [psi, u, gamma, x] = [0, 1, 2, 3].map(|number| state[half + number]);
            let (sine, cosine) = psi.sin_cos();
            // The curvature along the circle of latitude.
            let other = sine / x;
            let slopes = [
                u,
                (other - u) * cosine / x + 0.5 * pressure * x * cosine + gamma * other,
                0.5 * (u * u - other * other) + pressure * x * sine + tension,
                cosine,
                sine,
                2.0 * PI * x,
                PI * x * x * sine,
                0.125 * (u + other).powi(2) * x,
            ];
            for (number, slope) in slopes.into_iter().enumerate() {
                derivative[half + number] = (state[length] - POLE) * slope;
            }
        }
    }
}

impl Boundary<f64, State> for Halves<'_> {
    fn boundary(&self, start: &State, end: &State, residual: &mut State) {
        let curvatures = HALVES.map(|half| pole_curvature(start, half));
        for (half, curvature) in HALVES.into_iter().zip(curvatures) {
            let series = beside_pole(curvature, [start[PRESSURE], start[TENSION]]);
            for number in 0..8 {
                residual[half + number] = start[half + number] - series[number];
            }
            // U is free there; what holds instead is the angle at the equator.
            residual[half + 1] = end[half] - FRAC_PI_2;
        }
        let [upper, lower] = HALVES;
        residual[16] = end[upper + 3] - end[lower + 3];
        residual[17] = end[upper + 2] + end[lower + 2];
        residual[18] = (end[upper + 5] + end[lower + 5]) / (4.0 * PI) - 1.0;
        residual[19] = match self.condition {
            Condition::Volume(volume) => volume_of(end) - volume,
            Condition::Difference(difference) => curvatures[0] - curvatures[1] - difference,
            Condition::Along { guess, tangent } => {
                let misses = start.iter().zip(guess).zip(tangent);
                misses
                    .map(|((own, guess), part)| part * (own - guess))
                    .sum()
            }
        };
    }
}

/// v of the state at the equator.
fn volume_of(end: &State) -> f64 {
    HALVES.iter().map(|half| end[half + 6]).sum::<f64>() / (4.0 * PI / 3.0)
}

/// The states along both halves, from a first guess of that beside the poles.
fn solve(condition: Condition<'_>, start: State) -> Result<Vec<State>, ClosedSurfaceError> {
    let integrator = ExplicitRungeKutta::dop853()
        .rtol(0.1 * TOLERANCE)
        .atol(0.1 * TOLERANCE);
    let ends: Vec<f64> = (0..=PIECES)
        .map(|piece| piece as f64 / PIECES as f64)
        .collect();
    let method = Shooting::single(integrator)
        .tolerance(TOLERANCE)
        .max_iterations(30);
    let solution = BVP::ode(&Halves { condition }, 0.0, 1.0, start)
        .method(method)
        .t_eval(ends)
        .solve();
    let unsolved = |reason: String| ClosedSurfaceError::Unsolved {
        condition: condition.to_string(),
        reason,
    };
    match solution {
        Ok(solution) if solution.y.len() == PIECES + 1 => Ok(solution.y),
        Ok(_) => Err(unsolved("the integration ended early".to_owned())),
        Err(error) => Err(unsolved(format!("{error:?}"))),
    }
}

impl Branch {
    /// All branches.
    pub const ALL: [Self; 3] = [Self::Prolate, Self::Oblate, Self::Stomatocyte];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Prolate => "prolate",
            Self::Oblate => "oblate",
            Self::Stomatocyte => "stomatocyte",
        }
    }

    /// From where to where it is followed, in words.
    fn reach(self) -> &'static str {
        match self {
            Self::Prolate | Self::Oblate => "the branch is followed from the sphere down to 0.505",
            Self::Stomatocyte => {
                "the branch begins at 0.661, and is followed down to where the neck is nearly closed, about 0.51"
            }
        }
    }

    /// Its surfaces in steps of v of about 0.01, from the greatest v down to `least`, and no farther than they are known.
    ///
    /// # Errors
    /// [`ClosedSurfaceError::Unsolved`].
    pub fn surfaces(self, least: f64) -> Result<Vec<ClosedSurface>, ClosedSurfaceError> {
        let solutions = self.follow(least)?;
        Ok(solutions.iter().map(|it| ClosedSurface::of(it)).collect())
    }

    /// Its surface of a reduced volume.
    ///
    /// # Errors
    /// [`ClosedSurfaceError`].
    pub fn surface(self, reduced_volume: f64) -> Result<ClosedSurface, ClosedSurfaceError> {
        let not_on_branch = ClosedSurfaceError::NotOnBranch {
            branch: self,
            reduced_volume,
        };
        if !(LEAST_REDUCED_VOLUME..NEAR_SPHERE).contains(&reduced_volume) {
            return Err(not_on_branch);
        }
        let solutions = self.follow(reduced_volume)?;
        let volume = |states: &Vec<State>| volume_of(&states[PIECES]);
        // The last on the way, and where that has no greater volume there is none.
        let is_reached = solutions
            .first()
            .is_some_and(|it| volume(it) >= reduced_volume);
        let Some(last) = solutions.last().filter(|_| is_reached) else {
            return Err(not_on_branch);
        };
        let states = solve(Condition::Volume(reduced_volume), last[0])?;
        Ok(ClosedSurface::of(&states))
    }

    /// The branch of a vesicle by its extents: the heights of its poles, the least and the greatest height, and the greatest radius.
    /// The poles of a cup are both on one side of the middle, or one is far nearer to it.
    pub fn of_extents(poles: [f64; 2], [lowest, highest]: [f64; 2], radius: f64) -> Self {
        let middle = 0.5 * (lowest + highest);
        let height = highest - lowest;
        if (0.5 * (poles[0] + poles[1]) - middle).abs() > 0.1 * height {
            Self::Stomatocyte
        } else if height > 2.0 * radius {
            Self::Prolate
        } else {
            Self::Oblate
        }
    }

    /// The surface at which a force is zero that is negative on rounder ones; `least` is a reduced volume at which it is positive.
    /// A sphere where it is positive already there.
    ///
    /// # Errors
    /// [`ClosedSurfaceError`]: `NotOnBranch` where the force is negative as far as the branch is known, or positive all along
    /// a branch that does not begin at the sphere.
    pub fn balanced(
        self,
        least: f64,
        force: impl Fn(&ClosedSurface) -> f64,
    ) -> Result<ClosedSurface, ClosedSurfaceError> {
        let sign = match self {
            Self::Prolate => Some(1.0),
            Self::Oblate => Some(-1.0),
            Self::Stomatocyte => None,
        };
        let sphere = ClosedSurface::sphere();
        if sign.is_some() && force(&sphere) >= 0.0 {
            return Ok(sphere);
        }
        let mut solutions = self.follow(least)?;
        if let Some(last) = solutions.last().filter(|_| least >= LEAST_REDUCED_VOLUME)
            && volume_of(&last[PIECES]) > least
        {
            let end = solve(Condition::Volume(least), last[0])?;
            solutions.push(end);
        }
        let not_on_branch = ClosedSurfaceError::NotOnBranch {
            branch: self,
            reduced_volume: least,
        };
        let surfaces: Vec<ClosedSurface> =
            solutions.iter().map(|it| ClosedSurface::of(it)).collect();
        let Some(longer) = surfaces.iter().position(|it| force(it) >= 0.0) else {
            return Err(not_on_branch);
        };
        let (rounder, start) = match (longer, sign) {
            (0, Some(_)) => (&sphere, None),
            (0, None) => return Err(not_on_branch),
            _ => (&surfaces[longer - 1], Some(solutions[longer][0])),
        };
        let mut found = surfaces[longer].clone();
        let ends = [rounder, &found].map(|it| (it.reduced_volume, force(it)));
        root(ends, |volume| {
            let start = start.unwrap_or_else(|| beside_sphere(sign.unwrap_or(1.0), volume));
            found = ClosedSurface::of(&solve(Condition::Volume(volume), start)?);
            Ok(force(&found))
        })?;
        Ok(found)
    }

    fn follow(self, least: f64) -> Result<Vec<Vec<State>>, ClosedSurfaceError> {
        match self {
            Self::Prolate => symmetric(1.0, least),
            Self::Oblate => symmetric(-1.0, least),
            Self::Stomatocyte => stomatocytes(least),
        }
    }
}

/// A guess of the state beside the poles of r = 1 + a P₂(cos θ) with a small a of this sign: v = 1 − 3a²/5, the curvature of a pole
/// is 1 + 2a, the meridian's length π(1 + a/4).
fn beside_sphere(sign: f64, volume: f64) -> State {
    let amplitude = sign * ((1.0 - volume) / 0.6).sqrt();
    let mut start = [0.0; 20];
    for (half, length) in HALVES.into_iter().zip(LENGTHS) {
        let series = beside_pole(1.0 + 2.0 * amplitude, MARGINAL);
        start[half..half + 8].copy_from_slice(&series);
        start[length] = FRAC_PI_2 * (1.0 + 0.25 * amplitude);
    }
    [start[PRESSURE], start[TENSION]] = MARGINAL;
    start
}

/// The shapes with a plane of symmetry that begin beside the sphere, r = 1 + a P₂(cos θ), with a of this sign.
fn symmetric(sign: f64, least: f64) -> Result<Vec<Vec<State>>, ClosedSurfaceError> {
    let mut volume = NEAR_SPHERE;
    let mut start = beside_sphere(sign, volume);
    let mut solutions = Vec::new();
    loop {
        let states = solve(Condition::Volume(volume), start)?;
        start = states[0];
        solutions.push(states);
        volume -= VOLUME_STEP;
        if volume < least.max(LEAST_REDUCED_VOLUME) {
            return Ok(solutions);
        }
    }
}

/// The cups of the stable kind, from where they begin with the greatest volume: those that branch off from the oblate shapes have a
/// growing volume up to there. They end where a shape is not found: its neck is nearly closed.
fn stomatocytes(least: f64) -> Result<Vec<Vec<State>>, ClosedSurfaceError> {
    let flat = symmetric(-1.0, CUPS_FROM)?;
    let mut start = flat[flat.len() - 1][0];
    let mut difference = -DIFFERENCE_STEP;
    let [upper, lower] = HALVES;
    start[upper + 1] += 0.5 * difference;
    start[lower + 1] -= 0.5 * difference;
    let mut solutions = vec![solve(Condition::Difference(difference), start)?];
    let mut before = flat[flat.len() - 1][0];
    // Along the branch, once the difference does not grow any more.
    let mut step: Option<f64> = None;
    loop {
        let last = solutions[solutions.len() - 1][0];
        let way: State = std::array::from_fn(|number| last[number] - before[number]);
        let length = way.iter().map(|part| part * part).sum::<f64>().sqrt();
        let solved = match step {
            None => solve(Condition::Difference(difference - DIFFERENCE_STEP), last),
            Some(step) => {
                let tangent = &way.map(|part| part / length);
                let guess = &std::array::from_fn(|number| last[number] + step * tangent[number]);
                solve(Condition::Along { guess, tangent }, *guess)
            }
        };
        let Ok(states) = solved else {
            let shorter = step.map_or(LONGEST_STEP, |step| 0.5 * step);
            if shorter < LEAST_STEP {
                break;
            }
            step = Some(shorter);
            continue;
        };
        before = last;
        difference -= DIFFERENCE_STEP;
        step = step.map(|step| (1.5 * step).min(LONGEST_STEP));
        let [volume, so_far] =
            [&states, &solutions[solutions.len() - 1]].map(|states| volume_of(&states[PIECES]));
        if volume > so_far {
            solutions.clear();
        } else if volume < least {
            break;
        }
        solutions.push(states);
    }
    Ok(solutions)
}

impl ClosedSurface {
    fn of(states: &[State]) -> Self {
        let (start, end) = (&states[0], &states[PIECES]);
        let [upper, lower] = HALVES;
        let heights = HALVES.map(|half| end[half + 4]);
        let above = states
            .iter()
            .map(|it| (it[upper + 3], heights[0] - it[upper + 4]));
        let below = states.iter().rev().skip(1);
        let below = below.map(|it| (it[lower + 3], it[lower + 4] - heights[1]));
        let inner = above.chain(below).map(|(x, z)| Point::new(x, z));
        let poles = [heights[0], -heights[1]].map(|z| Point::new(0.0, z));
        let meridian = [poles[0]].into_iter().chain(inner).chain([poles[1]]);
        Self {
            reduced_volume: volume_of(end),
            energy: HALVES.iter().map(|half| end[half + 7]).sum(),
            height: heights[0] + heights[1],
            radius: end[upper + 3],
            pole_curvatures: HALVES.map(|half| pole_curvature(start, half)),
            pressure: start[PRESSURE],
            meridian: meridian.collect(),
        }
    }

    /// A sphere under the pressure at which its mode of two is marginal: there prolate and oblate shapes begin.
    pub fn sphere() -> Self {
        let angles = (0..=2 * PIECES).map(|piece| PI * piece as f64 / (2 * PIECES) as f64);
        Self {
            reduced_volume: 1.0,
            energy: 1.0,
            height: 2.0,
            radius: 1.0,
            pole_curvatures: [1.0; 2],
            pressure: MARGINAL[0],
            meridian: angles.map(|it| Point::new(it.sin(), it.cos())).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// v, W, the height from pole to pole and the radius of the equator in parts of R₀: computed by another program by the same
    /// equations (docs/guide/rotation.md).
    type Row = (f64, f64, f64, f64);
    const PROLATE: [Row; 8] = [
        (0.95, 1.095565, 2.59308, 0.82923),
        (0.90, 1.189644, 2.85857, 0.73834),
        (0.85, 1.285676, 3.07976, 0.65622),
        (0.80, 1.387440, 3.28893, 0.57512),
        (0.75, 1.501834, 3.51370, 0.49303),
        (0.70, 1.643270, 3.81088, 0.42500),
        (0.65, 1.827930, 4.19769, 0.40141),
        (0.60, 2.060293, 4.61447, 0.39513),
    ];
    const OBLATE: [Row; 8] = [
        (0.95, 1.106115, 1.42202, 1.12293),
        (0.90, 1.217860, 1.17652, 1.16206),
        (0.85, 1.333543, 0.98282, 1.18742),
        (0.80, 1.452539, 0.81459, 1.20552),
        (0.75, 1.574480, 0.66160, 1.21881),
        (0.70, 1.699111, 0.51854, 1.22852),
        (0.65, 1.826233, 0.38217, 1.23531),
        (0.60, 1.955680, 0.25025, 1.23960),
    ];

    #[test]
    fn the_symmetric_branches_are_those_of_another_program() {
        for (branch, rows) in [(Branch::Prolate, PROLATE), (Branch::Oblate, OBLATE)] {
            for (v, energy, height, radius) in rows {
                let own = branch.surface(v).expect("it is on the branch");
                for (own, other, bound) in [
                    (own.reduced_volume, v, 1e-9),
                    (own.energy, energy, 1e-6),
                    (own.height, height, 1.1e-5),
                    (own.radius, radius, 1.1e-5),
                ] {
                    assert!(
                        (own - other).abs() <= bound,
                        "{branch:?} {v}: {own} {other}"
                    );
                }
            }
        }
    }

    #[test]
    fn stomatocytes_have_their_energies_and_begin_at_their_greatest_volume() {
        for (v, energy) in [(0.65, 1.96680), (0.60, 1.97738), (0.59, 1.97889)] {
            let own = Branch::Stomatocyte.surface(v).expect("it is on the branch");
            assert!((own.energy - energy).abs() < 1e-5, "{v}: {}", own.energy);
            let [inner, outer] = own.pole_curvatures;
            assert!(inner < -0.5 && outer > 0.5, "{v}: {inner} {outer}");
        }
        let all = Branch::Stomatocyte.surfaces(0.55).expect("it is solved");
        let first = &all[0];
        // The fold is at 0.66085, W = 1.963053; the steps come near it.
        assert!((first.reduced_volume - 0.66085).abs() < 5e-4, "{first:?}");
        assert!(
            all.windows(2)
                .all(|pair| pair[0].reduced_volume > pair[1].reduced_volume)
        );
        assert!(all[all.len() - 1].reduced_volume < 0.57);
    }

    /// Where two branches have the same energy.
    #[test]
    fn the_crossings_are_those_of_the_literature() {
        let difference = |one: Branch, other: Branch, v: f64| {
            let [one, other] = [one, other].map(|it| it.surface(v).expect("it is there").energy);
            one - other
        };
        for ([one, other], v, energy) in CROSSINGS {
            let [below, above] = [v - 1e-4, v + 1e-4].map(|v| difference(one, other, v));
            assert!(below * above < 0.0, "{v}: {below} {above}");
            let own = one.surface(v).expect("it is there").energy;
            assert!((own - energy).abs() < 2e-5, "{v}: {own}");
        }
    }

    /// Surface and volume of the meridian itself, as a polygon.
    #[test]
    fn the_meridian_has_the_area_and_the_volume() {
        for (branch, v) in [
            (Branch::Prolate, 0.7),
            (Branch::Oblate, 0.6),
            (Branch::Stomatocyte, 0.6),
        ] {
            let own = branch.surface(v).expect("it is on the branch");
            let (mut area, mut volume) = (0.0, 0.0);
            for pair in own.meridian.windows(2) {
                let (a, b) = (pair[0], pair[1]);
                area += PI * (a.x + b.x) * (b - a).norm();
                volume += PI / 3.0 * (a.x * a.x + a.x * b.x + b.x * b.x) * (a.y - b.y);
            }
            assert!((area / (4.0 * PI) - 1.0).abs() < 2e-4, "{branch:?}: {area}");
            assert!(
                (0.75 * volume / PI - v).abs() < 2e-4,
                "{branch:?}: {volume}"
            );
        }
    }

    #[test]
    fn what_is_on_no_branch_is_an_error() {
        for (branch, v) in [
            (Branch::Prolate, 1.0),
            (Branch::Oblate, 0.4),
            (Branch::Oblate, f64::NAN),
            (Branch::Stomatocyte, 0.67),
        ] {
            let error = branch.surface(v).expect_err("there is none");
            assert!(
                matches!(error, ClosedSurfaceError::NotOnBranch { .. }),
                "{error}"
            );
        }
    }
}
