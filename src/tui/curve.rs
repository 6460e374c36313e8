//! A scalar over the time of the whole run as a line, one row or several: a column shows the least and
//! the greatest value of its steps, so that nothing that happened can fall between two columns.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};

use super::series::Series;
use super::theme::{Role, Theme};
use crate::record::RunMark;

/// Heights that a row of the screen has for a line: bottom, middle, top.
const LEVELS: usize = 3;
/// A range below this part of the values is widened to it: what hardly changes is level.
const LEAST_RANGE: f64 = 0.01;

/// The time up to which curves are shown: one of the end's fractions by powers of 1.1, so that a curve fills the
/// width from the first step on, and yet its past does not move with every step.
pub fn horizon(t: f64, end: f64) -> f64 {
    const RATIO: f64 = 1.1;
    if !(t > 0.0 && end > 0.0 && (end / t).is_finite()) {
        return if end > 0.0 { end } else { 1.0 };
    }
    let power = ((end / t).ln() / RATIO.ln()).floor() as i32;
    // Not below t by rounding.
    (end * RATIO.powi(-power)).max(t)
}

/// What all curves of a run have in common.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// The time at the right end; that at the left one is 0.
    pub end: f64,
    /// What happened on the way, in the order of time.
    pub marks: &'a [RunMark],
    /// The time that is shown, if it is not the present.
    pub cursor: Option<f64>,
    /// Whether the scale is logarithmic.
    pub logarithmic: bool,
}

/// Draws a curve into an area, from its least to its greatest value.
pub fn draw(
    series: &Series,
    frame: &Frame<'_>,
    colour: Color,
    theme: &Theme,
    area: Rect,
    buffer: &mut Buffer,
) {
    let area = area.intersection(buffer.area);
    let columns = series.columns(usize::from(area.width), frame.end);
    if let Some(scale) = Scale::of(&columns, frame.logarithmic) {
        line(&columns, &scale, colour, theme, area, buffer);
    }
    cursor(frame, theme, area, buffer);
}

/// The same on an axis with round ends; returns their values, or nothing where there is no curve.
pub fn draw_to_round_ends(
    series: &Series,
    frame: &Frame<'_>,
    colour: Color,
    theme: &Theme,
    area: Rect,
    buffer: &mut Buffer,
) -> Option<[f64; 2]> {
    let area = area.intersection(buffer.area);
    let columns = series.columns(usize::from(area.width), frame.end);
    let scale = Scale::of(&columns, frame.logarithmic)?.rounded();
    line(&columns, &scale, colour, theme, area, buffer);
    cursor(frame, theme, area, buffer);
    Some(scale.ends())
}

/// The column of a time, counted from the left end of an area.
pub fn column(t: f64, frame: &Frame<'_>, area: Rect) -> u16 {
    let share = (t / frame.end).clamp(0.0, 1.0);
    ((share * f64::from(area.width)) as u16).min(area.width.saturating_sub(1))
}

/// Marks the time that is looked at: the curve stays seen.
fn cursor(frame: &Frame<'_>, theme: &Theme, area: Rect, buffer: &mut Buffer) {
    let Some(t) = frame.cursor.filter(|_| !area.is_empty()) else {
        return;
    };
    let x = area.x + column(t, frame, area);
    for y in area.top()..area.bottom() {
        if let Some(cell) = buffer.cell_mut((x, y)) {
            if cell.symbol() == " " {
                cell.set_symbol(theme.glyphs().bar);
            }
            cell.set_style(theme.style(Role::Accent));
        }
    }
}

/// Draws the line through the columns.
fn line(
    columns: &[Option<[f64; 2]>],
    scale: &Scale,
    colour: Color,
    theme: &Theme,
    area: Rect,
    buffer: &mut Buffer,
) {
    let glyphs = theme.glyphs().line;
    let last = (LEVELS * usize::from(area.height)).saturating_sub(1);
    let style = Style::default().fg(colour);
    let mut before: Option<[usize; 2]> = None;
    for (x, column) in (area.left()..area.right()).zip(columns) {
        let heights = column.map(|values| values.map(|value| scale.share(value)));
        let Some(shares) = heights.filter(|shares| shares.iter().all(|share| share.is_finite()))
        else {
            before = None;
            continue;
        };
        let mut levels = shares.map(|share| (share * last as f64).round() as usize);
        // A logarithmic scale has the least value, if it is negative, above the greatest.
        levels.sort_unstable();
        let [mut low, mut high] = levels;
        if high - low < 2 {
            // What varies by less is level.
            (low, high) = (high, high);
        }
        let own = [low, high];
        if let Some([below, above]) = before {
            // Joined to the column before.
            low = low.min(above + 1);
            high = high.max(below.saturating_sub(1));
        }
        before = Some(own);
        for (row, y) in (area.top()..area.bottom()).rev().enumerate() {
            let is_drawn = |level: usize| {
                let level = row * LEVELS + level;
                (low..=high).contains(&level)
            };
            let mask = (0..LEVELS).map(|level| usize::from(is_drawn(level)) << level);
            let mask: usize = mask.sum();
            if mask > 0
                && let Some(cell) = buffer.cell_mut((x, y))
            {
                cell.set_symbol(glyphs[mask]).set_style(style);
            }
        }
    }
}

/// How values become heights.
#[derive(Debug, Clone, Copy)]
struct Scale {
    /// The heights of the ends.
    low: f64,
    high: f64,
    logarithmic: bool,
    /// The least value above zero: a logarithm needs one.
    floor: f64,
}

impl Scale {
    /// The scale of the values that are there; a logarithmic one shows absolute values.
    fn of(columns: &[Option<[f64; 2]>], logarithmic: bool) -> Option<Self> {
        let values = || columns.iter().flatten().flatten().filter(|v| v.is_finite());
        let positive = values()
            .map(|value| value.abs())
            .filter(|value| *value > 0.0);
        let floor = positive.reduce(f64::min);
        let mut scale = Self {
            low: 0.0,
            high: 0.0,
            logarithmic: logarithmic && floor.is_some(),
            floor: floor.unwrap_or(1.0),
        };
        let heights = || values().map(|value| scale.height(*value));
        let (low, high) = (heights().reduce(f64::min)?, heights().reduce(f64::max)?);
        let size = match scale.logarithmic {
            true => 1.0,
            false => low.abs().max(high.abs()),
        };
        let missing = (LEAST_RANGE * size - (high - low)).max(0.0);
        (scale.low, scale.high) = (low - 0.5 * missing, high + 0.5 * missing);
        Some(scale)
    }

    /// The same to round ends, with zero where it is near.
    fn rounded(self) -> Self {
        if self.logarithmic {
            let (low, high) = (self.low.floor(), self.high.ceil());
            return Self { low, high, ..self };
        }
        let [mut low, mut high] = [self.low, self.high];
        let is_near = |end: f64, other: f64| end.abs() < 0.3 * other.abs() && end * other > 0.0;
        if is_near(low, high) {
            low = 0.0;
        } else if is_near(high, low) {
            high = 0.0;
        }
        let power = 10_f64.powf((0.5 * (high - low)).log10().floor());
        let steps = [1.0, 2.0, 5.0].map(|step| step * power);
        let step = steps.into_iter().rfind(|step| *step <= 0.5 * (high - low));
        let step = step.filter(|step| step.is_normal());
        if let Some(step) = step {
            (low, high) = ((low / step).floor() * step, (high / step).ceil() * step);
        }
        Self { low, high, ..self }
    }

    /// The values at the ends.
    fn ends(&self) -> [f64; 2] {
        [self.low, self.high].map(|end| match self.logarithmic {
            true => 10_f64.powf(end),
            false => end,
        })
    }

    fn height(&self, value: f64) -> f64 {
        if self.logarithmic {
            value.abs().max(self.floor).log10()
        } else {
            value
        }
    }

    /// Where a value lies between the ends, from 0 to 1; a curve of zeros lies at 0. NaN for what is no number.
    fn share(&self, value: f64) -> f64 {
        let range = self.high - self.low;
        if !value.is_finite() {
            return f64::NAN;
        }
        match range > 0.0 {
            true => ((self.height(value) - self.low) / range).clamp(0.0, 1.0),
            false => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tui::theme::ColorTier;

    const PLAIN: Frame<'_> = Frame {
        end: 10.0,
        marks: &[],
        cursor: None,
        logarithmic: false,
    };

    fn series(values: &[f64]) -> Series {
        let mut series = Series::default();
        for (step, value) in values.iter().enumerate() {
            series.push(step as f64, *value);
        }
        series
    }

    fn rows(buffer: &Buffer) -> Vec<String> {
        let row = |y| {
            (0..buffer.area.width)
                .map(|x| buffer[(x, y)].symbol())
                .collect()
        };
        (0..buffer.area.height).map(row).collect()
    }

    fn drawn(series: &Series, frame: &Frame<'_>, theme: &Theme, height: u16) -> Vec<String> {
        let area = Rect::new(0, 0, 10, height);
        let mut buffer = Buffer::empty(area);
        draw(series, frame, Color::Reset, theme, area, &mut buffer);
        rows(&buffer)
    }

    #[test]
    fn a_line_rises_over_one_row_and_over_two() {
        let rising = series(&(0..8).map(f64::from).collect::<Vec<_>>());
        let unicode = Theme::new(ColorTier::None, true);
        assert_eq!(drawn(&rising, &PLAIN, &unicode, 1), ["▁▁────▔▔  "]);
        let two = ["    ▁──▔  ", "▁──▔      "];
        assert_eq!(drawn(&rising, &PLAIN, &unicode, 2), two);
        let ascii = Theme::new(ColorTier::None, false);
        assert_eq!(drawn(&rising, &PLAIN, &ascii, 1), ["__----''  "]);
    }

    #[test]
    fn a_jump_is_an_upright_line_and_a_line_has_no_gaps() {
        let theme = Theme::new(ColorTier::None, true);
        let mut jump = Series::default();
        jump.push(0.0, 0.0);
        jump.push(5.0, 0.0);
        jump.push(5.0, 8.0);
        jump.push(9.0, 8.0);
        assert_eq!(drawn(&jump, &PLAIN, &theme, 1), ["▁▁▁▁▁│▔▔▔▔"]);
        assert_eq!(
            drawn(&jump, &PLAIN, &theme, 2),
            ["     │▔▔▔▔", "▁▁▁▁▁│    "]
        );
    }

    #[test]
    fn what_hardly_changes_is_level_and_nothing_is_nothing() {
        let theme = Theme::new(ColorTier::None, true);
        assert_eq!(
            drawn(&series(&[3.0; 4]), &PLAIN, &theme, 1)[0]
                .trim_end()
                .len(),
            4 * 3
        );
        assert_eq!(
            drawn(&series(&[100.0, 100.001, 100.0]), &PLAIN, &theme, 1),
            ["───       "]
        );
        assert_eq!(drawn(&series(&[]), &PLAIN, &theme, 1), ["          "]);
        assert_eq!(drawn(&series(&[0.0; 3]), &PLAIN, &theme, 1), ["▁▁▁       "]);
        let broken = series(&[f64::NAN, 1.0, f64::INFINITY, 2.0]);
        assert_eq!(drawn(&broken, &PLAIN, &theme, 1), [" ▁ ▔      "]);
    }

    #[test]
    fn a_logarithm_makes_a_decay_straight_and_bears_zero_and_signs() {
        let theme = Theme::new(ColorTier::None, true);
        let frame = Frame {
            logarithmic: true,
            ..PLAIN
        };
        let decay: Vec<f64> = (0..9).map(|n| 10_f64.powi(-n)).collect();
        let rows = drawn(&series(&decay), &frame, &theme, 3);
        for (row, glyphs) in rows.iter().zip(["▔─▁       ", "   ▔─▁    ", "      ▔─▁ "])
        {
            assert_eq!(row, glyphs);
        }
        let values: Vec<f64> = (0..40)
            .map(|n| if n % 4 == 0 { -100.0 } else { 0.1 })
            .collect();
        let frame = Frame { end: 40.0, ..frame };
        let rows = drawn(&series(&values), &frame, &theme, 2);
        assert!(rows.iter().all(|row| row == "││││││││││"), "{rows:?}");
        assert_eq!(drawn(&series(&[0.0, 0.0]), &frame, &theme, 1).len(), 1);
    }

    #[test]
    fn the_ends_of_a_plot_are_round_and_have_zero_where_it_is_near() {
        let ends = |values: [f64; 2], logarithmic| {
            let scale = Scale::of(&[Some(values)], logarithmic).expect("values");
            scale.rounded().ends()
        };
        for (values, expected) in [
            ([263.0, 640.0], [200.0, 700.0]),
            ([26.0, 640.0], [0.0, 800.0]),
            ([-640.0, -26.0], [-800.0, 0.0]),
            ([-3.0, 4.0], [-4.0, 4.0]),
            ([0.0, 0.0], [0.0, 0.0]),
        ] {
            assert_eq!(ends(values, false), expected, "{values:?}");
        }
        assert_eq!(ends([0.02, 5.0], true), [0.01, 10.0]);
    }

    #[test]
    fn the_horizon_is_near_and_moves_seldom() {
        let end = 1e-3;
        let mut horizons = Vec::new();
        for step in 1..=10_000 {
            let t = end * f64::from(step) / 1e4;
            let horizon = horizon(t, end);
            assert!(horizon >= t && horizon <= 1.1001 * t, "{t} {horizon}");
            if horizons.last() != Some(&horizon) {
                horizons.push(horizon);
            }
        }
        assert!(horizons.len() < 110, "{}", horizons.len());
        assert!((horizons[horizons.len() - 1] / end - 1.0).abs() < 1e-12);
        assert!(horizon(2.5e-3, end) >= 2.5e-3);
        for (t, end) in [
            (0.0, 1.0),
            (0.0, 0.0),
            (1.0, 0.0),
            (f64::NAN, 1.0),
            (1e-300, 1e300),
        ] {
            assert!(horizon(t, end) > 0.0, "{t} {end}");
        }
    }

    #[test]
    fn an_area_off_the_screen_is_left_alone() {
        let mut buffer = Buffer::empty(Rect::new(0, 0, 4, 2));
        let theme = Theme::new(ColorTier::True, true);
        let values = series(&[1.0, 2.0]);
        for area in [Rect::new(3, 1, 40, 9), Rect::new(9, 9, 3, 3)] {
            draw(&values, &PLAIN, Color::Red, &theme, area, &mut buffer);
            draw_to_round_ends(&values, &PLAIN, Color::Red, &theme, area, &mut buffer);
        }
    }
}
