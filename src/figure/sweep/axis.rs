//! An axis of a sweep: the values of a key at their places, numbers at theirs, words in their order.

use super::{Dimension, numeric};
use crate::figure::number::number;
use crate::figure::text::Label;
use crate::study::sweep::{Spacing, plain};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use std::ops::Range;

/// Digits of a number on an axis, at most.
pub(super) const DIGITS: usize = 4;

/// Letters of a word on an axis, at most.
const LONGEST: usize = 14;

/// The places of the values, of logarithms where the scale is that; edges half way between them.
#[derive(Debug, Clone)]
pub(super) struct PlaceAxis {
    /// Where the values are.
    pub places: Vec<f64>,
    /// The edges of the cells around them: one more.
    pub edges: Vec<f64>,
    labels: Vec<Label>,
    /// From one value with a tick to the next.
    stride: usize,
}

impl PlaceAxis {
    pub fn new(dimension: &Dimension) -> PlaceAxis {
        let values: Option<Vec<f64>> = dimension.values.iter().map(|it| numeric(it)).collect();
        let is_logarithmic = |values: &[f64]| {
            let all_positive = values.iter().all(|value| *value > 0.0);
            all_positive && (dimension.spacing == Spacing::Logarithmic || is_geometric(values))
        };
        let places: Vec<f64> = match values {
            Some(values) if is_logarithmic(&values) => values.iter().map(|it| it.log10()).collect(),
            Some(values) => values,
            None => (0..dimension.values.len()).map(|it| it as f64).collect(),
        };
        let labels = dimension.values.iter().map(|value| match numeric(value) {
            Some(value) => number(value, DIGITS),
            None => Label::text(&shortened(&plain(value))),
        });
        Self::of(places, labels.collect())
    }

    /// Where there is nothing to tell apart.
    pub fn nothing() -> PlaceAxis {
        Self::of(vec![0.0], vec![Label::default()])
    }

    fn of(places: Vec<f64>, labels: Vec<Label>) -> PlaceAxis {
        let middle = |pair: &[f64]| 0.5 * (pair[0] + pair[1]);
        let inner: Vec<f64> = places.windows(2).map(middle).collect();
        let (first, last) = (places[0], places[places.len() - 1]);
        let edges = match (inner.first(), inner.last()) {
            (Some(low), Some(high)) => std::iter::once(2.0 * first - low)
                .chain(inner.iter().copied())
                .chain([2.0 * last - high])
                .collect(),
            _ => vec![first - 0.5, first + 0.5],
        };
        PlaceAxis {
            places,
            edges,
            labels,
            stride: 1,
        }
    }

    /// With as many ticks as have room on an axis of this length: of numbers beside each other, or, where it stands,
    /// above each other.
    pub fn fitted(mut self, length: f64, size: f64, stands: bool) -> PlaceAxis {
        let widths = self.labels.iter().map(|label| match stands {
            true => 1.3 * size,
            false => label.width(size) + 0.8 * size,
        });
        let widest = widths.fold(1.0, f64::max);
        let narrowest = length * self.narrowest();
        let stride = (widest / narrowest.max(f64::MIN_POSITIVE)).ceil();
        // The cast saturates.
        self.stride = (stride as usize).clamp(1, self.places.len());
        self
    }

    /// The least distance of two places, as a part of the axis.
    pub fn narrowest(&self) -> f64 {
        let [low, high] = self.ends();
        let distances = self.places.windows(2).map(|pair| pair[1] - pair[0]);
        distances.fold(high - low, f64::min) / (high - low)
    }

    /// The width of the widest label.
    pub fn widest(&self, size: f64) -> f64 {
        let widths = self.labels.iter().map(|label| label.width(size));
        widths.fold(0.0, f64::max)
    }

    fn ends(&self) -> [f64; 2] {
        [self.edges[0], self.edges[self.edges.len() - 1]]
    }
}

/// Whether all neighbours have about the same ratio, and not the same distance.
fn is_geometric(values: &[f64]) -> bool {
    let spread = |parts: Vec<f64>| {
        let greatest = parts.iter().copied().fold(f64::MIN, f64::max);
        let least = parts.iter().copied().fold(f64::MAX, f64::min);
        greatest / least
    };
    let pairs = || values.windows(2);
    values.len() > 2
        && spread(pairs().map(|pair| (pair[1] / pair[0]).ln()).collect()) < 1.6
        && spread(pairs().map(|pair| pair[1] - pair[0]).collect()) > 2.0
}

/// A word that is not too long for an axis.
fn shortened(word: &str) -> String {
    match word.chars().count() > LONGEST {
        true => word.chars().take(LONGEST - 1).chain(['…']).collect(),
        false => word.to_owned(),
    }
}

impl Ranged for PlaceAxis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limits: (i32, i32)) -> i32 {
        RangedCoordf64::from(self.range()).map(value, limits)
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.places.iter().step_by(self.stride).copied().collect()
    }

    fn range(&self) -> Range<f64> {
        let [low, high] = self.ends();
        low..high
    }
}

impl ValueFormatter<f64> for PlaceAxis {
    fn format_ext(&self, place: &f64) -> String {
        let found = self.places.iter().position(|it| it == place);
        found.map_or_else(String::new, |it| self.labels[it].clone().into())
    }
}
