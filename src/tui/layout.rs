//! Where everything goes, in named steps: a terminal is too small, narrow, normal or wide.

use ratatui::layout::Rect;

use super::state::Panel;

/// The least columns and rows that the app can be used in.
pub const LEAST: (u16, u16) = (60, 18);

/// How much there is room for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Step {
    /// Less than [`LEAST`]: a page says so.
    TooSmall,
    /// As in a terminal of 80 × 24: the field and the scalars that matter most.
    Narrow,
    /// As in one of 120 × 40: every panel with its curves.
    Normal,
    /// As in one of 200 × 60: curves of several rows, fine ticks.
    Wide,
}

impl Step {
    /// The step of a terminal's size.
    pub fn of(columns: u16, rows: u16) -> Self {
        if columns < LEAST.0 || rows < LEAST.1 {
            Self::TooSmall
        } else if columns < 104 || rows < 32 {
            Self::Narrow
        } else if columns < 160 || rows < 48 {
            Self::Normal
        } else {
            Self::Wide
        }
    }
}

/// The parts of the screen of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Areas {
    /// The step they are made for.
    pub step: Step,
    /// Scene, state, progress.
    pub header: Rect,
    /// The field with its axes.
    pub field: Rect,
    /// Energies, area, cost: where there is no room, an area is empty.
    pub energy: Rect,
    /// See `energy`.
    pub area: Rect,
    /// See `energy`.
    pub cost: Rect,
    /// Notices, remarks, what was saved.
    pub banner: Rect,
    /// Keys.
    pub footer: Rect,
}

/// How many rows a panel of scalars needs, would like, and can use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wish {
    /// Below this it is left out.
    pub least: u16,
    /// All of it is shown.
    pub full: u16,
}

/// Divides the screen: header above, banner and footer below, the field on the left as large as its
/// height allows, the panels of scalars on the right. The panel that has the focus gets the room
/// that the others can spare.
///
/// `banner` is the number of rows that the banner needs; `wishes` are those of energy, area and cost.
pub fn divide(screen: Rect, focus: Panel, banner: u16, wishes: [Wish; 3]) -> Areas {
    let step = Step::of(screen.width, screen.height);
    let mut left = screen;
    let header = take_top(&mut left, 2);
    let footer = take_bottom(&mut left, 1);
    let banner = take_bottom(&mut left, banner.clamp(1, 4));
    if step >= Step::Normal {
        take_top(&mut left, 1);
    }
    // A cell is twice as high as it is wide: a square field of n rows has 2n columns. Title, frame
    // and ticks take four rows; frame, labels and colour bar take up to 17 columns.
    let around = if step <= Step::Narrow { 14 } else { 17 };
    let natural = (2 * left.height.saturating_sub(4)).saturating_add(around);
    let least = match step {
        Step::TooSmall | Step::Narrow => 30,
        Step::Normal => 44,
        Step::Wide => 64,
    };
    // With the focus on the scalars, they take more than half.
    let least = if focus == Panel::Field {
        least
    } else {
        least.max(left.width / 2 + 2)
    };
    let gap = 2;
    let width = natural.min(left.width.saturating_sub(least + gap));
    let field = Rect { width, ..left };
    let right = Rect {
        x: left.x + width + gap.min(left.width - width),
        width: left.width.saturating_sub(width + gap),
        ..left
    };
    let [energy, area, cost] = stack(right, focus, step, wishes);
    Areas {
        step,
        header,
        field,
        energy,
        area,
        cost,
        banner,
        footer,
    }
}

/// Stacks the panels of scalars. Each gets what it needs, in the order of importance (the focus
/// first), then up to what it would like; what is left is the focused one's, or the energies'.
fn stack(column: Rect, focus: Panel, step: Step, wishes: [Wish; 3]) -> [Rect; 3] {
    let focused = match focus {
        Panel::Field => None,
        Panel::Energy => Some(0),
        Panel::Area => Some(1),
        Panel::Cost => Some(2),
    };
    let gap = u16::from(step >= Step::Normal);
    let mut order: Vec<usize> = (0..3).collect();
    order.sort_by_key(|panel| Some(*panel) != focused);
    let mut heights = [0_u16; 3];
    let mut room = column.height;
    for &panel in &order {
        let need = wishes[panel].least;
        // A panel that has not even its least is left out.
        if need + gap <= room {
            heights[panel] = need;
            room -= need + gap;
        }
    }
    for &panel in &order {
        if heights[panel] > 0 {
            let more = (wishes[panel].full.saturating_sub(heights[panel])).min(room);
            heights[panel] += more;
            room -= more;
        }
    }
    let greedy = focused.unwrap_or(0);
    if heights[greedy] > 0 {
        // Curves of a third of the screen are high enough, unless they are what is shown.
        let limit = if focused.is_some() {
            room
        } else {
            column.height / 3
        };
        heights[greedy] += room.min(limit);
    }
    let mut y = column.y;
    heights.map(|height| {
        let area = Rect {
            y,
            height,
            ..column
        };
        if height > 0 {
            y += height + gap;
        }
        area.intersection(column)
    })
}

/// Cuts rows off the top.
pub fn take_top(area: &mut Rect, rows: u16) -> Rect {
    let rows = rows.min(area.height);
    let top = Rect {
        height: rows,
        ..*area
    };
    area.y += rows;
    area.height -= rows;
    top
}

/// Cuts rows off the bottom.
pub fn take_bottom(area: &mut Rect, rows: u16) -> Rect {
    let rows = rows.min(area.height);
    area.height -= rows;
    Rect {
        y: area.y + area.height,
        height: rows,
        ..*area
    }
}

/// Cuts columns off the left.
pub fn take_left(area: &mut Rect, columns: u16) -> Rect {
    let columns = columns.min(area.width);
    let left = Rect {
        width: columns,
        ..*area
    };
    area.x += columns;
    area.width -= columns;
    left
}

/// A rectangle of at most this size in the middle of another.
pub fn centred(outer: Rect, width: u16, height: u16) -> Rect {
    let (width, height) = (width.min(outer.width), height.min(outer.height));
    Rect {
        x: outer.x + (outer.width - width) / 2,
        y: outer.y + (outer.height - height) / 2,
        width,
        height,
    }
}

/// Columns and rows of the cells that show a domain in its true shape within a size, a cell being
/// twice as high as it is wide; `aspect` is the domain's width over its height. Of many columns
/// there is an odd number, so that one stands in the middle.
pub fn fit(aspect: f64, columns: u16, rows: u16) -> (u16, u16) {
    let wanted = (2.0 * aspect * f64::from(rows)).round();
    let (columns, rows) = if wanted <= f64::from(columns) {
        (wanted.max(0.0) as u16, rows)
    } else {
        let rows_left = (0.5 * f64::from(columns) / aspect).round();
        (columns, (rows_left.max(0.0) as u16).min(rows))
    };
    let even = columns > 8 && columns.is_multiple_of(2);
    (columns - u16::from(even), rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WISHES: [Wish; 3] = [
        Wish { least: 6, full: 9 },
        Wish { least: 4, full: 9 },
        Wish { least: 3, full: 10 },
    ];

    const PANELS: [Panel; 4] = [Panel::Field, Panel::Energy, Panel::Area, Panel::Cost];

    #[test]
    fn the_steps_have_the_sizes_they_are_named_for() {
        assert_eq!(Step::of(80, 24), Step::Narrow);
        assert_eq!(Step::of(120, 40), Step::Normal);
        assert_eq!(Step::of(200, 60), Step::Wide);
        assert_eq!(Step::of(59, 60), Step::TooSmall);
        assert_eq!(Step::of(200, 17), Step::TooSmall);
        assert_eq!(Step::of(200, 30), Step::Narrow);
    }

    #[test]
    fn the_parts_lie_on_the_screen_and_do_not_overlap() {
        for columns in 1..=220 {
            for rows in 1..=70 {
                for focus in PANELS {
                    let screen = Rect::new(0, 0, columns, rows);
                    let areas = divide(screen, focus, 1, WISHES);
                    let parts = [
                        areas.header,
                        areas.field,
                        areas.energy,
                        areas.area,
                        areas.cost,
                        areas.banner,
                        areas.footer,
                    ];
                    for (index, part) in parts.iter().enumerate() {
                        assert_eq!(part.intersection(screen).area(), part.area());
                        for other in &parts[index + 1..] {
                            assert_eq!(part.intersection(*other).area(), 0, "{areas:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn every_panel_is_there_from_the_least_size_on() {
        for (columns, rows) in [LEAST, (80, 24), (120, 40), (200, 60)] {
            for focus in PANELS {
                let areas = divide(Rect::new(0, 0, columns, rows), focus, 1, WISHES);
                assert!(areas.field.width >= 26 && areas.field.height >= 12);
                for area in [areas.energy, areas.area] {
                    assert!(area.height >= 3 && area.width >= 28, "{columns} {focus:?}");
                }
            }
        }
    }

    #[test]
    fn the_focus_makes_a_panel_larger() {
        let screen = Rect::new(0, 0, 120, 40);
        let without = divide(screen, Panel::Field, 1, WISHES);
        let with = divide(screen, Panel::Cost, 1, WISHES);
        assert!(with.cost.area() > without.cost.area());
        assert!(with.field.area() < without.field.area());
    }

    #[test]
    fn a_square_has_about_twice_as_many_columns_as_rows() {
        assert_eq!(fit(1.0, 100, 20), (39, 20));
        assert_eq!(fit(1.0, 31, 20), (31, 16));
        assert_eq!(fit(2.0, 100, 20), (79, 20));
        assert_eq!(fit(1.0, 4, 20), (4, 2));
        assert_eq!(fit(1.0, 0, 20), (0, 0));
        assert_eq!(fit(1.0, 20, 0), (0, 0));
    }

    #[test]
    fn what_is_centred_stays_inside() {
        let outer = Rect::new(3, 4, 10, 5);
        assert_eq!(centred(outer, 4, 3), Rect::new(6, 5, 4, 3));
        assert_eq!(centred(outer, 40, 30), outer);
    }
}
