//! A scalar over the whole run as a filled curve, one row or several: a column shows the least and
//! the greatest value of its steps, so that nothing that happened can fall between two columns.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};

use super::glyphs::Glyphs;
use super::series::Series;
use super::theme::{ColorTier, Role, Theme};

/// The stretch of steps that curves show: it doubles when it is full, so that a curve moves from the
/// first second on, and yet its past does not shift with every step.
pub fn horizon(step: u64, steps: u64) -> u64 {
    const SHORTEST: u64 = 64;
    let doubled = step.saturating_add(1).checked_next_power_of_two();
    let doubled = doubled.unwrap_or(u64::MAX).max(SHORTEST) - 1;
    if steps > 0 && step <= steps {
        doubled.min(steps)
    } else {
        doubled
    }
}

/// Why there is a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// The mesh has followed the membrane.
    Mesh,
    /// The anchoring was switched.
    Switch,
}

/// What all curves of a run have in common.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// The last step that there is room for.
    pub horizon: u64,
    /// Steps with a mark; a later one covers an earlier one.
    pub marks: &'a [(u64, Mark)],
    /// The step that is shown, if it is not the last.
    pub cursor: Option<u64>,
    /// Whether the scale is logarithmic.
    pub logarithmic: bool,
}

/// Draws a curve into an area. Returns the least and the greatest value that it shows.
pub fn draw(
    series: &Series,
    frame: &Frame<'_>,
    colour: Color,
    theme: &Theme,
    area: Rect,
    buffer: &mut Buffer,
) -> Option<[f64; 2]> {
    let area = area.intersection(buffer.area);
    if area.is_empty() {
        return None;
    }
    let glyphs = theme.glyphs();
    let columns = series.columns(usize::from(area.width), frame.horizon);
    let scale = Scale::of(&columns, frame.logarithmic);
    let resolution = glyphs.levels.len() - 1;
    let full = usize::from(area.height) * resolution;
    for (x, column) in (area.left()..area.right()).zip(&columns) {
        let Some((column, scale)) = column.zip(scale.as_ref()) else {
            continue;
        };
        // At least one level, so that the curve is seen where it is lowest.
        let mut levels = column.map(|value| {
            let level = 1.0 + scale.share(value) * (full - 1) as f64;
            (level.round() as usize).clamp(1, full)
        });
        // A logarithmic scale has the least value, if it is negative, above the greatest.
        levels.sort_unstable();
        let [low, high] = levels;
        for (row, y) in (area.top()..area.bottom()).rev().enumerate() {
            let within = |level: usize| level.saturating_sub(row * resolution).min(resolution);
            let (symbol, style) = fill(within(low), within(high), colour, theme);
            if let Some(cell) = buffer.cell_mut((x, y)) {
                cell.set_symbol(symbol).set_style(style);
            }
        }
    }
    let style = |mark: Mark| match mark {
        Mark::Mesh => theme.muted(),
        Mark::Switch => theme.style(Role::Warning),
    };
    let marks = frame.marks.iter().map(|(step, mark)| (*step, style(*mark)));
    let cursor = frame.cursor.map(|step| (step, theme.style(Role::Accent)));
    for (step, style) in marks.chain(cursor) {
        let share = step as f64 / (frame.horizon as f64 + 1.0);
        let offset = (share * f64::from(area.width)) as u16;
        let x = area.x + offset.min(area.width - 1);
        for y in area.top()..area.bottom() {
            if let Some(cell) = buffer.cell_mut((x, y)) {
                cell.reset();
                cell.set_symbol(glyphs.bar).set_style(style);
            }
        }
    }
    scale.map(|scale| scale.ends)
}

/// A cell of a column that is filled for certain up to `low` and at times up to `high` levels.
fn fill(low: usize, high: usize, colour: Color, theme: &Theme) -> (&'static str, Style) {
    let glyphs: &'static Glyphs = theme.glyphs();
    let full = glyphs.levels.len() - 1;
    let style = Style::default().fg(colour);
    if high - low < 2 || high < full {
        // What varies by less is shown at its greatest; the difference would hardly be seen.
        return (glyphs.levels[high.min(full)], style);
    }
    match theme.tier {
        ColorTier::True | ColorTier::Palette if theme.unicode => {
            (glyphs.levels[low], style.bg(theme.band(colour)))
        }
        _ if low == 0 => (glyphs.band, style),
        _ => (glyphs.levels[low], style),
    }
}

/// How values become heights.
struct Scale {
    ends: [f64; 2],
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
        let least = values().copied().reduce(f64::min)?;
        let greatest = values().copied().reduce(f64::max)?;
        let positive = values()
            .map(|value| value.abs())
            .filter(|value| *value > 0.0);
        let floor = positive.reduce(f64::min);
        let mut scale = Self {
            ends: [least, greatest],
            low: least,
            high: greatest,
            logarithmic: logarithmic && floor.is_some(),
            floor: floor.unwrap_or(1.0),
        };
        if scale.logarithmic {
            let heights = || values().map(|value| scale.height(*value));
            let (low, high) = (heights().reduce(f64::min)?, heights().reduce(f64::max)?);
            (scale.low, scale.high) = (low, high);
        }
        Some(scale)
    }

    fn height(&self, value: f64) -> f64 {
        if self.logarithmic {
            value.abs().max(self.floor).log10()
        } else {
            value
        }
    }

    /// Where a value lies between the ends, from 0 to 1; a curve that is constant lies at 0.
    fn share(&self, value: f64) -> f64 {
        let range = self.high - self.low;
        let share = (self.height(value) - self.low) / range;
        if range > 0.0 && share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Frame<'_> = Frame {
        horizon: 9,
        marks: &[],
        cursor: None,
        logarithmic: false,
    };

    fn series(values: &[f64]) -> Series {
        let mut series = Series::default();
        for (step, value) in values.iter().enumerate() {
            series.push(step as u64, *value);
        }
        series
    }

    fn drawn(series: &Series, frame: &Frame<'_>, theme: &Theme, rows: u16) -> Vec<String> {
        let area = Rect::new(0, 0, 10, rows);
        let mut buffer = Buffer::empty(area);
        draw(series, frame, Color::Reset, theme, area, &mut buffer);
        let row = |y| (0..10).map(|x| buffer[(x, y)].symbol()).collect();
        (0..rows).map(row).collect()
    }

    #[test]
    fn a_logarithmic_scale_bears_both_signs_in_a_column() {
        let values: Vec<f64> = (0..40)
            .map(|n| if n % 4 == 0 { -100.0 } else { 0.1 })
            .collect();
        let frame = Frame {
            horizon: 39,
            logarithmic: true,
            ..PLAIN
        };
        let theme = Theme::new(ColorTier::None, true);
        let rows = drawn(&series(&values), &frame, &theme, 2);
        assert!(rows.iter().all(|row| row.chars().count() == 10), "{rows:?}");
    }

    #[test]
    fn a_line_rises_over_one_row_and_over_two() {
        let rising = series(&(0..8).map(f64::from).collect::<Vec<_>>());
        let unicode = Theme::new(ColorTier::None, true);
        assert_eq!(drawn(&rising, &PLAIN, &unicode, 1), ["▁▂▃▄▅▆▇█  "]);
        let two = drawn(&rising, &PLAIN, &unicode, 2);
        assert_eq!(two[1].chars().next(), Some('▁'));
        assert_eq!(two[0].chars().nth(7), Some('█'));
        assert_eq!(two[1].chars().nth(7), Some('█'));
        let ascii = Theme::new(ColorTier::None, false);
        assert_eq!(drawn(&rising, &PLAIN, &ascii, 1), ["..::++##  "]);
    }

    #[test]
    fn a_constant_lies_on_the_ground_and_nothing_is_nothing() {
        let theme = Theme::new(ColorTier::None, true);
        assert_eq!(drawn(&series(&[3.0; 4]), &PLAIN, &theme, 1), ["▁▁▁▁      "]);
        assert_eq!(drawn(&series(&[]), &PLAIN, &theme, 1), ["          "]);
        let broken = series(&[f64::NAN, 1.0, f64::INFINITY, 2.0]);
        assert_eq!(drawn(&broken, &PLAIN, &theme, 1), ["▁▁▁█      "]);
    }

    #[test]
    fn the_extremes_of_a_column_are_both_seen() {
        let theme = Theme::new(ColorTier::None, true);
        let frame = Frame {
            horizon: 39,
            ..PLAIN
        };
        // Four steps a column; in the second column one step falls to the ground.
        let mut values = vec![8.0; 12];
        values[5] = 0.0;
        let rows = drawn(&series(&values), &frame, &theme, 2);
        assert_eq!(rows, ["█░█       ", "█▁█       "]);
    }

    #[test]
    fn a_logarithm_makes_a_decay_straight_and_bears_zero() {
        let theme = Theme::new(ColorTier::None, true);
        let frame = Frame {
            logarithmic: true,
            ..PLAIN
        };
        let decay: Vec<f64> = (0..8).map(|n| 10_f64.powi(-n)).collect();
        assert_eq!(drawn(&series(&decay), &frame, &theme, 1), ["█▇▆▅▄▃▂▁  "]);
        let signs = series(&[0.0, -1e-3, 1.0]);
        assert_eq!(drawn(&signs, &frame, &theme, 1), ["▁▁█       "]);
        let zeros = series(&[0.0, 0.0]);
        assert_eq!(drawn(&zeros, &frame, &theme, 1), ["▁▁        "]);
    }

    #[test]
    fn marks_and_the_cursor_stand_at_their_steps() {
        let theme = Theme::new(ColorTier::None, true);
        let frame = Frame {
            marks: &[(2, Mark::Switch)],
            cursor: Some(4),
            ..PLAIN
        };
        let values = series(&[1.0; 6]);
        assert_eq!(drawn(&values, &frame, &theme, 1), ["▁▁│▁│▁    "]);
    }

    #[test]
    fn the_horizon_doubles_up_to_the_end() {
        let table = [
            (0, 10_000, 63),
            (63, 10_000, 63),
            (64, 10_000, 127),
            (9000, 10_000, 10_000),
            (10_000, 10_000, 10_000),
            (10_001, 10_000, 16_383),
            (5, 20, 20),
            (5, 0, 63),
        ];
        for (step, steps, end) in table {
            assert_eq!(horizon(step, steps), end, "{step} of {steps}");
        }
        assert!(horizon(u64::MAX, 0) >= 1);
    }

    #[test]
    fn an_area_off_the_screen_is_left_alone() {
        let mut buffer = Buffer::empty(Rect::new(0, 0, 4, 2));
        let theme = Theme::new(ColorTier::True, true);
        let area = Rect::new(3, 1, 40, 9);
        let values = series(&[1.0, 2.0]);
        let ends = draw(&values, &PLAIN, Color::Red, &theme, area, &mut buffer);
        assert_eq!(ends, Some([1.0, 2.0]));
        let outside = Rect::new(9, 9, 3, 3);
        assert_eq!(
            draw(&values, &PLAIN, Color::Red, &theme, outside, &mut buffer),
            None
        );
    }
}
