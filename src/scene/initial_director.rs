//! Initial values at the nodes: the director d⁰, and a random phase field.

use std::f64::consts::TAU;

use nalgebra::UnitComplex;
use rand::distr::Open01;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::tables::{Defect, InitialDirector};
use crate::geometry::{Point, Vector, direction, length};

/// A node closer than this to a defect's centre is at it: coordinates of nodes carry rounding.
const CORE_RADIUS: f64 = 1e-12;

/// d⁰ at the nodes: its x components and its y components.
///
/// Values from a file are copied; that there are two of them a node is the reader's to check.
/// The random director depends on its seed and on the number of a node only.
pub fn initial_director(initial: &InitialDirector, nodes: &[Point]) -> [Vec<f64>; 2] {
    let (x, y) = match initial {
        InitialDirector::Uniform([x, y]) => (vec![*x; nodes.len()], vec![*y; nodes.len()]),
        InitialDirector::Defects { at, angle } => {
            let turn = direction(*angle);
            nodes
                .iter()
                .map(|&node| around_defects(at, turn, node))
                .map(|d| (d.x, d.y))
                .unzip()
        }
        InitialDirector::Random { seed, length } => {
            let mut generator = ChaCha8Rng::seed_from_u64(*seed);
            nodes
                .iter()
                .map(|_| {
                    let (sine, cosine) = (TAU * generator.random::<f64>()).sin_cos();
                    (length * cosine, length * sine)
                })
                .unzip()
        }
        InitialDirector::File(file) => file
            .values
            .chunks_exact(2)
            .map(|pair| (pair[0], pair[1]))
            .unzip(),
    };
    [x, y]
}

/// The unit vector at the angle Σ winding·atan2(y − y_c, x − x_c), turned by `turn`; zero at a
/// defect's centre, where no direction is the right one.
fn around_defects(defects: &[Defect], turn: Vector, node: Point) -> Vector {
    let mut angle = 0.0;
    for Defect { center, winding } in defects {
        let offset = node - Point::from(*center);
        if length(offset) < CORE_RADIUS {
            return Vector::zeros();
        }
        angle += winding * offset.y.atan2(offset.x);
    }
    UnitComplex::new(angle) * turn
}

/// Independent values, uniform in the open interval (−amplitude, amplitude); the same for the
/// same seed.
pub fn random_phase(amplitude: f64, seed: u64, count: usize) -> Vec<f64> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    (0..count)
        .map(|_| amplitude * (2.0 * generator.sample::<f64, _>(Open01) - 1.0))
        .collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::nodal_file::NodalValues;
    use super::*;

    const NODES: [Point; 4] = [
        Point::new(0.5, 0.5),
        Point::new(0.75, 0.5),
        Point::new(0.5, 0.75),
        Point::new(0.25, 0.25),
    ];

    fn assert_close(actual: &[f64], expected: &[f64]) {
        assert_eq!(actual.len(), expected.len());
        for (a, b) in actual.iter().zip(expected) {
            assert!((a - b).abs() < 4e-16, "{actual:?} against {expected:?}");
        }
    }

    #[test]
    fn a_uniform_director_keeps_its_length() {
        let [x, y] = initial_director(&InitialDirector::Uniform([0.3, -2.0]), &NODES);
        assert_eq!(x, [0.3; 4]);
        assert_eq!(y, [-2.0; 4]);
    }

    #[test]
    fn a_defect_turns_the_director_as_often_as_it_winds() {
        let field = |winding, angle| {
            let at = vec![Defect {
                center: [0.5, 0.5],
                winding,
            }];
            initial_director(&InitialDirector::Defects { at, angle }, &NODES)
        };
        let diagonal = 0.5_f64.sqrt();
        let [x, y] = field(1.0, 0.0);
        assert_close(&x, &[0.0, 1.0, 0.0, -diagonal]);
        assert_close(&y, &[0.0, 0.0, 1.0, -diagonal]);
        let [x, y] = field(1.0, 90.0);
        assert_close(&x, &[0.0, 0.0, -1.0, diagonal]);
        assert_close(&y, &[0.0, 1.0, 0.0, -diagonal]);
        let [x, y] = field(-1.0, 0.0);
        assert_close(&x, &[0.0, 1.0, 0.0, -diagonal]);
        assert_close(&y, &[0.0, 0.0, -1.0, diagonal]);
        let [x, y] = field(0.5, 0.0);
        assert_close(&x[..3], &[0.0, 1.0, diagonal]);
        assert_close(&y[..3], &[0.0, 0.0, diagonal]);
    }

    #[test]
    fn the_angles_of_several_defects_add_up() {
        let at = vec![
            Defect {
                center: [0.5, 0.5],
                winding: 0.5,
            },
            Defect {
                center: [0.5, 0.5],
                winding: 0.5,
            },
        ];
        let twice = initial_director(&InitialDirector::Defects { at, angle: 20.0 }, &NODES);
        let at = vec![Defect {
            center: [0.5, 0.5],
            winding: 1.0,
        }];
        let once = initial_director(&InitialDirector::Defects { at, angle: 20.0 }, &NODES);
        assert_close(&twice[0], &once[0]);
        assert_close(&twice[1], &once[1]);
    }

    #[test]
    fn a_center_that_rounding_moved_is_still_a_center() {
        let at = vec![Defect {
            center: [0.3, 0.3],
            winding: 1.0,
        }];
        let node = Point::new(3.0 * 0.1, 0.3);
        assert_ne!(node.x, 0.3);
        let [x, y] = initial_director(&InitialDirector::Defects { at, angle: 0.0 }, &[node]);
        assert_eq!((x[0], y[0]), (0.0, 0.0));
    }

    #[test]
    fn a_random_director_has_its_length_and_repeats() {
        let nodes = vec![Point::origin(); 4000];
        let field = |seed| initial_director(&InitialDirector::Random { seed, length: 0.7 }, &nodes);
        let [x, y] = field(1);
        for (x, y) in x.iter().zip(&y) {
            assert!((x.hypot(*y) - 0.7).abs() < 1e-15);
        }
        // Of n random directions the mean is about n^(-1/2) long.
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        assert!(mean(&x).hypot(mean(&y)) < 0.7 * 4.0 / 4000_f64.sqrt());
        assert_eq!(field(1), [x, y]);
        assert_ne!(field(1), field(2));
        let few = InitialDirector::Random {
            seed: 1,
            length: 0.7,
        };
        assert_eq!(initial_director(&few, &nodes[..10])[0], field(1)[0][..10]);
    }

    #[test]
    fn values_from_a_file_are_copied() {
        let file = NodalValues {
            path: "d0.txt".into(),
            values: Arc::from([1.0, 2.0, 3.0, 4.0]),
            columns: 2,
        };
        let [x, y] = initial_director(&InitialDirector::File(file), &NODES[..2]);
        assert_eq!((x, y), (vec![1.0, 3.0], vec![2.0, 4.0]));
    }

    #[test]
    fn a_random_phase_is_uniform_in_its_interval_and_repeats() {
        let count = 20_000;
        let values = random_phase(0.3, 7, count);
        assert!(values.iter().all(|value| value.abs() < 0.3));
        let moment = |power| values.iter().map(|v| v.powi(power)).sum::<f64>() / count as f64;
        let deviation = 0.3 / 3_f64.sqrt();
        assert!(moment(1).abs() < 4.0 * deviation / (count as f64).sqrt());
        assert!((moment(2) / (deviation * deviation) - 1.0).abs() < 0.03);
        assert_eq!(values, random_phase(0.3, 7, count));
        assert_ne!(values, random_phase(0.3, 8, count));
    }
}
