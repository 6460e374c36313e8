//! Numbers on pictures: where ticks stand, and how they are written.

use super::canvas::LARGEST;
use super::text::Label;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use std::ops::Range;

/// The least part of a value that ticks resolve: below it is rounding.
const LEAST_SPAN: f64 = 1e-9;

/// An axis: its ends, and a tick at every multiple of a round step between them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    /// The values at its ends.
    pub range: [f64; 2],
    /// The ticks' values.
    pub ticks: Vec<f64>,
    /// The power of ten that the ticks' numbers leave out.
    pub exponent: i32,
    decimals: usize,
    is_logarithmic: bool,
}

impl Axis {
    /// An axis that holds `low` and `high`, with at most so many ticks.
    pub fn new([low, high]: [f64; 2], most_ticks: usize) -> Axis {
        let size = low.abs().max(high.abs());
        // Not the shortest form of the number but its logarithm: 1e-3 is a power of ten exactly.
        let order = decimal_order(size);
        let exponent = if (-2..5).contains(&order) { 0 } else { order };
        let step = round_step((high - low) / most_ticks.max(1) as f64);
        let (first, last) = ((low / step).ceil(), (high / step).floor());
        // By counting, so that no tick is lost to rounding; the casts saturate.
        let count = (last - first).max(0.0) as usize;
        let ticks = (0..=count.min(most_ticks))
            .map(|number| (first + number as f64) * step)
            .filter(|tick| *tick <= high * (1.0 + f64::EPSILON) || *tick <= high)
            // Not −0.
            .map(|tick| tick + 0.0)
            .collect();
        let decimals = (exponent - decimal_order(step)).max(0);
        Axis {
            range: [low, high],
            ticks,
            exponent,
            decimals: decimals as usize,
            is_logarithmic: false,
        }
    }

    /// A logarithmic axis from `low` > 0 to `high`, with at most `most_ticks` ticks at powers of ten; if there are fewer
    /// than two powers of ten, also at 2 and 5 times a power.
    pub fn logarithmic([low, high]: [f64; 2], most_ticks: usize) -> Axis {
        let orders = decimal_order(low)..=decimal_order(high);
        let is_on = |tick: &f64| (low..=high).contains(tick);
        let ticks = |factors: &'static [f64]| {
            let powers = orders.clone().map(|order| 10_f64.powi(order));
            let all = powers.flat_map(|power| factors.iter().map(move |factor| factor * power));
            all.filter(is_on).collect::<Vec<f64>>()
        };
        let powers = ticks(&[1.0]);
        let every = powers.len().div_ceil(most_ticks.max(1)).max(1);
        let ticks = match powers.len() {
            0 | 1 => ticks(&[1.0, 2.0, 5.0]),
            _ => powers.into_iter().step_by(every).collect(),
        };
        Axis {
            range: [low, high],
            ticks,
            exponent: 0,
            decimals: 0,
            is_logarithmic: true,
        }
    }

    /// The number at a tick.
    pub fn label(&self, tick: f64) -> Label {
        if self.is_logarithmic {
            return number(tick, 1);
        }
        let decimals = self.decimals;
        let value = tick / 10_f64.powi(self.exponent);
        Label::text(&with_minus(&format!("{value:.decimals$}")))
    }

    /// The width of the widest of its numbers, in a text of this size.
    pub fn widest(&self, size: f64) -> f64 {
        let widths = self.ticks.iter().map(|tick| self.label(*tick).width(size));
        widths.fold(0.0, f64::max)
    }

    /// The name of what the axis shows, with what its numbers leave out.
    pub fn name(&self, symbol: Label) -> Label {
        match self.exponent {
            0 => symbol,
            exponent => symbol
                .and(" / 10")
                .above(&with_minus(&exponent.to_string())),
        }
    }

    /// Where a value is, from 0 at the low end to 1 at the high end.
    pub fn place(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        match self.is_logarithmic {
            true => (value / low).ln() / (high / low).ln(),
            false => (value - low) / (high - low),
        }
    }
}

/// At most `most` round numbers within a range, or `most` + 1 if both ends of the range are round.
pub(crate) fn round_ticks(range: [f64; 2], most: usize) -> Vec<f64> {
    Axis::new(range, most).ticks
}

/// A coordinate of plotters, with ticks of its own that are written as print has them.
impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limits: (i32, i32)) -> i32 {
        match self.is_logarithmic {
            true => RangedCoordf64::from(0.0..1.0).map(&self.place(*value), limits),
            false => RangedCoordf64::from(self.range()).map(value, limits),
        }
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        let [low, high] = self.range;
        low..high
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, tick: &f64) -> String {
        self.label(*tick).into()
    }
}

/// The least and the greatest of the values that can have a place in a chart, if there is one.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let values = values.filter(|value| value.abs() <= LARGEST);
    values.fold(None, |extent, value| {
        let [low, high] = extent.unwrap_or([value; 2]);
        Some([low.min(value), high.max(value)])
    })
}

/// A range that shows all values with a little room on both sides; not less than their rounding.
pub(super) fn roomy_range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let Some([low, high]) = extent(values) else {
        return [0.0, 1.0];
    };
    let size = low.abs().max(high.abs());
    let span = high - low;
    if span <= LEAST_SPAN * size || span == 0.0 {
        let room = if size == 0.0 { 1.0 } else { 0.1 * size };
        return [low - room, high + room];
    }
    [low - 0.05 * span, high + 0.05 * span]
}

/// The least of 1, 2, 5, 10, 20, … times a power of ten that is not below `least`.
fn round_step(least: f64) -> f64 {
    if !(least.is_finite() && least > 0.0) {
        return 1.0;
    }
    let order = decimal_order(least);
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * 10_f64.powi(order))
        .find(|step| *step >= least * (1.0 - 1e-12))
        .unwrap_or(10_f64.powi(order + 1))
}

/// n with 10ⁿ ≤ size < 10ⁿ⁺¹; 0 for no size.
fn decimal_order(size: f64) -> i32 {
    if size == 0.0 || !size.is_finite() {
        return 0;
    }
    // The digits are those that print: no rounding of a logarithm.
    let text = format!("{:e}", size.abs());
    text.rsplit('e')
        .next()
        .and_then(|order| order.parse().ok())
        .unwrap_or(0)
}

/// The letter of one of several pictures, counted from 0, with a space after it: (a), …, (z), (aa), ….
pub(super) fn letter(mut number: usize) -> Label {
    let mut letters = Vec::new();
    loop {
        letters.push(char::from(b'a' + (number % 26) as u8));
        match number / 26 {
            0 => break,
            more => number = more - 1,
        }
    }
    let word: String = letters.iter().rev().collect();
    Label::text(&format!("({word}) "))
}

/// A number as print has it, to `digits` digits: 2.5×10⁻⁴.
pub(super) fn number(value: f64, digits: usize) -> Label {
    if !value.is_finite() || value == 0.0 {
        return Label::text(if value == 0.0 { "0" } else { "no number" });
    }
    let scientific = format!("{value:.*e}", digits.saturating_sub(1));
    let (mantissa, order) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let order: i32 = order.parse().unwrap_or(0);
    if (-2..5).contains(&order) {
        let decimals = (digits as i32 - 1 - order).max(0) as usize;
        return Label::text(&with_minus(trimmed(&format!("{value:.decimals$}"))));
    }
    let power = |label: Label| label.above(&with_minus(&order.to_string()));
    match trimmed(mantissa) {
        "1" => power(Label::text("10")),
        "-1" => power(Label::text("−10")),
        mantissa => power(Label::text(&with_minus(mantissa)).and("×10")),
    }
}

/// Without zeros at the end of what follows the point.
fn trimmed(text: &str) -> &str {
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => text,
    }
}

fn with_minus(text: &str) -> String {
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn written(low: f64, high: f64, most: usize) -> Vec<String> {
        let axis = Axis::new([low, high], most);
        axis.ticks
            .iter()
            .map(|tick| axis.label(*tick).plain())
            .collect()
    }

    #[test]
    fn ticks_stand_at_round_numbers() {
        assert_eq!(written(0.0, 1.0, 2), ["0.0", "0.5", "1.0"]);
        assert_eq!(
            written(-1.03, 1.03, 5),
            ["−1.0", "−0.5", "0.0", "0.5", "1.0"]
        );
        assert_eq!(written(36.25, 36.98, 4), ["36.4", "36.6", "36.8"]);
        assert_eq!(written(98.0, 512.0, 5), ["100", "200", "300", "400", "500"]);
        assert_eq!(
            written(0.0, 1e-3, 5),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(Axis::new([0.0, 1e-3], 5).exponent, -3);
    }

    #[test]
    fn ticks_of_a_logarithmic_axis_are_powers_of_ten() {
        let axis = Axis::logarithmic([2e-7, 1e-3], 5);
        let labels: Vec<String> = (axis.ticks.iter())
            .map(|tick| axis.label(*tick).plain())
            .collect();
        assert_eq!(labels, ["10−6", "10−5", "10−4", "10−3"]);
        assert!(axis.place(2e-7).abs() < 1e-12 && (axis.place(1e-3) - 1.0).abs() < 1e-12);
        assert!((Axis::logarithmic([1e-4, 1.0], 5).place(1e-2) - 0.5).abs() < 1e-12);
        assert_eq!(Axis::logarithmic([1e-8, 1.0], 3).ticks.len(), 3);
        // Within one decade.
        let ticks = Axis::logarithmic([1.5, 8.0], 5).ticks;
        assert_eq!(ticks, [2.0, 5.0]);
    }

    #[test]
    fn a_factor_that_is_left_out_is_told() {
        let axis = Axis::new([-2e-15, 3e-15], 4);
        assert_eq!(axis.name(Label::symbol("A")).plain(), "A / 10−15");
        assert_eq!(axis.label(axis.ticks[0]).plain(), "−2");
        let axis = Axis::new([0.1, 0.9], 4);
        assert_eq!(axis.name(Label::symbol("A")).plain(), "A");
    }

    #[test]
    fn numbers_are_written_as_print_has_them() {
        for (value, text) in [
            (0.0, "0"),
            (2.5e-4, "2.5×10−4"),
            (1e-3, "10−3"),
            (7.5e-4 + 1e-19, "7.5×10−4"),
            (0.25, "0.25"),
            (104.146419, "104.1"),
            (-3.0, "−3"),
            (12345.6, "12346"),
            (1.5e7, "1.5×107"),
            (f64::NAN, "no number"),
        ] {
            assert_eq!(number(value, 4).plain(), text);
        }
    }

    #[test]
    fn pictures_have_letters() {
        let letters = [0, 1, 25, 26, 27, 52].map(|number| letter(number).plain());
        assert_eq!(letters, ["(a) ", "(b) ", "(z) ", "(aa) ", "(ab) ", "(ba) "]);
    }

    #[test]
    fn a_constant_has_room_around_it() {
        assert_eq!(roomy_range([0.0, 0.0].into_iter()), [-1.0, 1.0]);
        assert_eq!(roomy_range([2.0].into_iter()), [1.8, 2.2]);
        assert_eq!(roomy_range([f64::NAN].into_iter()), [0.0, 1.0]);
        let [low, high] = roomy_range([1.0, f64::NAN, 2.0].into_iter());
        assert!((low - 0.95).abs() < 1e-12 && (high - 2.05).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn ticks_are_on_the_axis_and_differ(
            low in -1e6..1e6_f64, span in 1e-3..1e6_f64, power in -12..6_i32, most in 1..9_usize,
        ) {
            let scale = 10_f64.powi(power);
            let [low, high] = [low * scale, (low + span) * scale];
            let axis = Axis::new([low, high], most);
            prop_assert!(axis.ticks.len() <= most + 1);
            let slack = 1e-9 * (high - low) + 4.0 * f64::EPSILON * low.abs().max(high.abs());
            prop_assert!(axis.ticks.iter().all(|t| *t >= low - slack && *t <= high + slack));
            let labels: Vec<_> = axis.ticks.iter().map(|t| axis.label(*t).plain()).collect();
            for pair in labels.windows(2) {
                prop_assert_ne!(&pair[0], &pair[1]);
            }
            // What is written is where it stands.
            for (tick, label) in axis.ticks.iter().zip(&labels) {
                let read: f64 = label.replace('−', "-").parse().unwrap();
                let read = read * 10_f64.powi(axis.exponent);
                prop_assert!((read - tick).abs() <= slack, "{label} at {tick}");
            }
        }
    }
}
