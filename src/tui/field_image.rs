//! A field as a picture needs it: sampled on a grid, with its name and the range of its colours.

use super::colour_map::LEVELS;
use super::numbers::round_up;
use super::state::Field;
use super::theme::Theme;
use crate::fem::Raster;
use crate::figure::LEAST_DEPARTURE;
use crate::physics::bending_energy_density;
use crate::scheme::State;

/// A field's values at the samples of a raster, row after row from the top, and the values that the
/// ends of the colour bar stand for.
#[derive(Debug, Default)]
pub struct FieldImage {
    /// The values; `None` outside the domain and, of the director, outside the vesicle, and everywhere where there
    /// is no such field.
    pub values: Vec<Option<f64>>,
    /// φ at the same samples.
    pub phase: Vec<Option<f64>>,
    /// From the first colour to the last.
    pub range: [f64; 2],
}

impl FieldImage {
    /// Samples a field of a state; ε is needed for the energy density.
    pub fn new(field: Field, state: &State, interface_width: f64, raster: &Raster) -> Self {
        let mut phase = Vec::new();
        raster.gather(&state.phi, &mut phase);
        let mut values = Vec::new();
        match field {
            Field::Phase => values.clone_from(&phase),
            Field::Omega => raster.gather(&state.omega, &mut values),
            Field::Mu => raster.gather(&state.mu, &mut values),
            Field::EnergyDensity => {
                raster.gather(&state.omega, &mut values);
                for omega in values.iter_mut().flatten() {
                    *omega = bending_energy_density(interface_width, *omega);
                }
            }
            Field::DirectorLength => match &state.director {
                None => values.resize(phase.len(), None),
                Some([x, y]) => {
                    let mut across = Vec::new();
                    raster.gather(x, &mut across);
                    raster.gather(y, &mut values);
                    for ((y, x), phase) in values.iter_mut().zip(across).zip(&phase) {
                        let is_inside = phase.is_some_and(|phase| phase > 0.0);
                        *y = y.zip(x).filter(|_| is_inside).map(|(y, x)| x.hypot(y));
                    }
                }
            },
        }
        let range = range(field, &values);
        if field == Field::DirectorLength {
            // What is 1 but for the scheme's own errors lies in the middle, where two colours meet, and
            // would be speckled with both.
            let nearly = (range[1] - range[0]) / (2 * LEVELS) as f64;
            for length in values.iter_mut().flatten() {
                if (*length - 1.0).abs() < nearly {
                    *length = 1.0;
                }
            }
        }
        Self {
            values,
            phase,
            range,
        }
    }

    /// Where a value lies between the ends of the range, from 0 to 1.
    pub fn share(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        ((value - low) / (high - low)).clamp(0.0, 1.0)
    }
}

/// The values of the first and of the last colour. The ends are round numbers, so that the colours
/// of a field do not change with every frame.
fn range(field: Field, values: &[Option<f64>]) -> [f64; 2] {
    let greatest = |of: &mut dyn Iterator<Item = f64>, least: f64| {
        let finite = of.filter(|value| value.is_finite());
        round_up(finite.map(f64::abs).fold(least, f64::max))
    };
    let mut all = values.iter().flatten().copied();
    match field {
        Field::Phase => [-1.0, 1.0],
        Field::Omega | Field::Mu => {
            let end = greatest(&mut all, 0.0);
            [-end, end]
        }
        Field::EnergyDensity => [0.0, greatest(&mut all, 0.0)],
        Field::DirectorLength => {
            // About 1, where the penalty pulls it.
            let departure = greatest(&mut all.map(|length| length - 1.0), LEAST_DEPARTURE);
            let end = departure.min(1.0);
            [1.0 - end, 1.0 + end]
        }
    }
}

/// A field's symbol and its name in words.
pub fn names(field: Field, theme: &Theme) -> (&'static str, &'static str) {
    match field {
        Field::Phase => (theme.word("φ", "phi"), "phase field"),
        Field::DirectorLength => ("|d|", "length of the director"),
        Field::Omega => (theme.word("ω", "omega"), "bending variable"),
        Field::Mu => (theme.word("μ", "mu"), "chemical potential"),
        Field::EnergyDensity => (
            theme.word("ε/2 ω²", "eps/2 omega^2"),
            "bending energy density",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Mesh;
    use crate::geometry::Point;

    fn sampled(field: Field, director: Option<[Vec<f64>; 2]>) -> FieldImage {
        let mesh = Mesh::structured(8, 0.0, 0).expect("a regular mesh");
        let nodes = mesh.nodes();
        let state = State {
            phi: nodes.iter().map(|at| 4.0 * at.x - 2.0).collect(),
            omega: nodes.iter().map(|at| 30.0 * at.y - 10.0).collect(),
            mu: nodes.iter().map(|at| -(at.x + at.y)).collect(),
            director,
        };
        let raster = Raster::new(&mesh, mesh.bounding_box(), 8, 8);
        FieldImage::new(field, &state, 0.1, &raster)
    }

    fn close(one: [f64; 2], other: [f64; 2]) -> bool {
        (one[0] - other[0]).abs() < 1e-12 && (one[1] - other[1]).abs() < 1e-12
    }

    #[test]
    fn every_field_has_its_values_and_its_range() {
        let phase = sampled(Field::Phase, None);
        assert!(close(phase.range, [-1.0, 1.0]) && phase.values == phase.phase);
        let omega = sampled(Field::Omega, None);
        // The uppermost samples have y = 15/16: ω = 18.125.
        assert!(close(omega.range, [-20.0, 20.0]), "{:?}", omega.range);
        assert!((omega.values[0].expect("inside") - 18.125).abs() < 1e-12);
        assert!((omega.share(0.0) - 0.5).abs() < 1e-15);
        let mu = sampled(Field::Mu, None);
        assert!(close(mu.range, [-2.0, 2.0]));
        let density = sampled(Field::EnergyDensity, None);
        let exact = 0.05 * 18.125 * 18.125;
        assert!((density.values[0].expect("inside") - exact).abs() < 1e-12);
        assert!(close(density.range, [0.0, 20.0]), "{:?}", density.range);
    }

    #[test]
    fn the_strength_of_the_director_is_measured_from_one_inside_the_vesicle() {
        let mesh = Mesh::structured(8, 0.0, 0).expect("a regular mesh");
        let left = |at: &Point| if at.x < 0.5 { 7.0 } else { 0.8 };
        let x: Vec<f64> = mesh.nodes().iter().map(left).collect();
        let y = vec![0.6; x.len()];
        let length = sampled(Field::DirectorLength, Some([x, y]));
        assert!(close(length.range, [0.9, 1.1]), "{:?}", length.range);
        assert!((length.values[7].expect("inside") - 1.0).abs() < 1e-12);
        // φ = 4x − 2: outside there is no director to look at.
        assert_eq!(length.values[3], None);
        let none = sampled(Field::DirectorLength, None);
        assert!(none.values.iter().all(Option::is_none) && none.values.len() == 64);
    }

    #[test]
    fn a_field_that_is_not_a_number_has_a_range_all_the_same() {
        let mut sampled = sampled(Field::Omega, None);
        sampled.values.fill(Some(f64::NAN));
        let range = range(Field::Omega, &sampled.values);
        assert!(close(range, [-1.0, 1.0]));
    }
}
