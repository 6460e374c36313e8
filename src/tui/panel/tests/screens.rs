//! Snapshots, sizes, characters.

use std::sync::Arc;

use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier};

use super::made_up::{self, notice};
use super::{THEMES, characters, drawn, with_styles};
use crate::fem::Mesh;
use crate::geometry::{Point, length};
use crate::record::KeptAt;
use crate::scene::{self, AnchoringKind};
use crate::simulation::RunSnapshot;
use crate::study::Offer;
use crate::tui::brake::Brake;
use crate::tui::colour_map::COLOUR_MAPS;
use crate::tui::glyphs::Parts;
use crate::tui::layout::divide;
use crate::tui::state::{
    App, Director, Field, Keeping, Overlay, Panel, PriceList, Question, Saving, Screen, Severity,
    Slot, Status, Zoom,
};
use crate::tui::theme::{ColorTier, Theme};

const SIZES: [(u16, u16); 2] = [(80, 24), (120, 40)];

/// A way to change the made-up app, with its name.
type Change = (&'static str, fn(&mut App));

/// Everything that can fill or cover the screen.
const CHANGES: &[Change] = &[
    ("running", |_| {}),
    ("paused", |app| made_up::run(app).status = Status::Paused),
    ("measuring", |app| made_up::measure(app, false)),
    ("measured", |app| {
        made_up::measure(app, true);
        app.focus = Panel::Cost;
    }),
    ("errors", |app| {
        made_up::measure(app, true);
        app.overlay = Some(Overlay::Measured);
    }),
    ("accuracy", |app| {
        let slot = app.active_slot().expect("one is shown");
        let mut list = PriceList {
            name: slot.name.clone(),
            rows: Offer::all(&slot.scene)
                .into_iter()
                .map(|it| (it, None))
                .collect(),
            chosen: 2,
        };
        for (index, seconds) in [0.3, 0.6, 1.4].into_iter().enumerate() {
            let words = format!("about {seconds} s and 14 MB, {} steps", 20 + 10 * index);
            list.rows[index].1 = Some(Ok(words));
        }
        app.overlay = Some(Overlay::Accuracy(list));
    }),
    ("quick", |app| {
        let slots = std::mem::take(&mut app.slots).into_iter();
        let quick = |mut slot: Slot| {
            slot.name = format!("{}-quick", slot.name);
            slot.preset = Some("case3-quick");
            slot.run.iter_mut().for_each(|run| {
                run.history.marks.clear();
            });
            slot
        };
        let printed = |name: &'static str| {
            let mut slot = Slot::new(name, None, made_up::scene(name));
            slot.preset = Some(name);
            slot
        };
        app.slots = slots.map(quick).collect();
        app.slots
            .extend(["case1", "case2", "case3", "case4"].map(printed));
        app.forms = 2;
        app.brake = Brake::new(8.0);
    }),
    ("starting", |app| {
        let run = made_up::run(app);
        run.status = Status::Starting;
        run.setting = None;
        run.picture = None;
    }),
    ("not-started", |app| app.active = 3),
    ("no-slots", |app| app.slots.clear()),
    ("looking-back", |app| app.looking_back = Some(1)),
    ("failed", |app| {
        let run = made_up::run(app);
        run.status = Status::Failed("the step was not solved".to_owned());
        let text = "the energy law misses by 2e-6 of the energy; solver.law_tolerance is 1e-8";
        run.notices
            .push_back(notice(Severity::Warning, "the wall is near"));
        run.notices.push_back(notice(Severity::Error, text));
    }),
    ("saved", |app| {
        app.saving = Saving::Saved(made_up::long_path())
    }),
    ("switched", |app| {
        let run = made_up::run(app);
        run.history
            .marks
            .push(made_up::change(400, "parallel", 1.0));
        app.slots[app.active].set_anchoring(AnchoringKind::Parallel);
        app.view.logarithmic = true;
        app.focus = Panel::Energy;
    }),
    ("area", |app| app.focus = Panel::Area),
    ("cost", |app| app.focus = Panel::Cost),
    ("arrows", |app| app.view.director = Director::Arrows),
    ("whole-domain", |app| app.view.zoom = Zoom::Domain),
    ("twice-as-large", |app| app.view.zoom = Zoom::Double),
    ("external-field", |app| {
        let scene = Arc::make_mut(&mut app.slots[2].scene);
        let angle = 120.0;
        scene.field = Some(scene::Field {
            angle,
            ..scene::Field::default()
        });
    }),
    ("external-field-off", |app| {
        let scene = Arc::make_mut(&mut app.slots[2].scene);
        let from = 5e-4;
        scene.field = Some(scene::Field {
            from,
            ..scene::Field::default()
        });
    }),
    ("omega", |app| app.view.field = Field::Omega),
    ("mu", |app| {
        app.view.field = Field::Mu;
        app.view.colour_map = 1;
    }),
    ("length", |app| app.view.field = Field::DirectorLength),
    ("density", |app| {
        app.view.field = Field::EnergyDensity;
        app.view.director = Director::Off;
    }),
    ("gallery", |app| app.screen = Screen::Gallery),
    ("help", |app| {
        app.overlay = Some(Overlay::Help { scroll: 0 })
    }),
    ("help-end", |app| {
        app.overlay = Some(Overlay::Help { scroll: 900 })
    }),
    ("quit", |app| {
        let run = made_up::run(app);
        run.unsaved = true;
        run.keeping = Keeping::Kept(KeptAt {
            folder: "saved/unfinished/case3-00000000".into(),
            step: 400,
            bytes: 2_700_000,
        });
        app.overlay = Some(Overlay::Confirm(Question::Quit));
    }),
    ("restart", |app| {
        app.overlay = Some(Overlay::Confirm(Question::Restart))
    }),
    ("reload", |app| {
        app.overlay = Some(Overlay::Confirm(Question::Reload))
    }),
    ("open", |app| {
        app.overlay = Some(Overlay::Open {
            text: "case".to_owned(),
            chosen: Some(1),
            error: Some("there is no such file".to_owned()),
        });
    }),
    ("message", |app| {
        app.overlay = Some(Overlay::Message {
            title: "scene.toml".to_owned(),
            text: "error: unknown key 'cels'\n  --> scene.toml:4:1\n   |\n 4 | cels = 120\n"
                .repeat(9),
            scroll: 0,
        });
    }),
    ("hostile", |app| {
        let slot = &mut app.slots[2];
        slot.name = "κύστη\u{1b}[31m\n漢字💧\u{200d}".repeat(9);
        app.remark = Some("a remark\nof two\tlines \u{7} with ".repeat(20));
    }),
];

fn changed(change: &Change) -> App {
    let mut app = made_up::app();
    change.1(&mut app);
    app
}

fn change(name: &str) -> App {
    let found = CHANGES.iter().find(|(known, _)| *known == name);
    changed(found.expect("a change of this name"))
}

#[test]
fn the_whole_screen() {
    for (name, tier, unicode) in THEMES {
        for (columns, rows) in SIZES {
            let buffer = drawn(
                &change("running"),
                &Theme::new(tier, unicode),
                columns,
                rows,
            );
            let text = with_styles(&buffer, buffer.area);
            insta::assert_snapshot!(format!("screen-{name}-{columns}x{rows}"), text);
        }
    }
}

#[test]
fn each_panel() {
    for (name, tier, unicode) in THEMES {
        for (columns, rows) in SIZES {
            let app = change("running");
            let buffer = drawn(&app, &Theme::new(tier, unicode), columns, rows);
            let shown = super::super::Shown::active(&app).expect("a run");
            let wishes = super::super::wishes(Some(&shown), buffer.area);
            let areas = divide(buffer.area, app.focus, 1, wishes);
            let panels = [
                ("header", areas.header),
                ("field", areas.field),
                ("energy", areas.energy),
                ("area", areas.area),
                ("cost", areas.cost),
                ("footer", areas.footer),
            ];
            for (panel, area) in panels {
                let text = characters(&buffer, area);
                insta::assert_snapshot!(format!("{panel}-{name}-{columns}x{rows}"), text);
            }
        }
    }
}

#[test]
fn all_that_fills_or_covers_the_screen() {
    for change in CHANGES {
        for (columns, rows) in SIZES {
            let theme = Theme::new(ColorTier::None, true);
            let mut app = changed(change);
            app.size = (columns, rows);
            let buffer = drawn(&app, &theme, columns, rows);
            let text = characters(&buffer, buffer.area);
            insta::assert_snapshot!(format!("{}-{columns}x{rows}", change.0), text);
        }
    }
}

#[test]
fn no_size_is_too_small_to_be_drawn() {
    let theme = Theme::new(ColorTier::Palette, true);
    for change in CHANGES {
        let app = changed(change);
        for columns in [1, 2, 7, 31, 59, 60, 61, 79, 103, 104, 159, 160, 220] {
            for rows in [1, 2, 5, 17, 18, 19, 31, 32, 47, 48, 70] {
                drawn(&app, &theme, columns, rows);
            }
        }
        for (_, tier, unicode) in THEMES {
            for (columns, rows) in [(1, 1), (60, 18), (220, 70)] {
                drawn(&app, &Theme::new(tier, unicode), columns, rows);
            }
        }
    }
}

#[test]
fn every_size_of_the_main_screen_is_drawn() {
    let app = change("running");
    let theme = Theme::new(ColorTier::None, true);
    for columns in 1..=220 {
        for rows in [1, 18, 24, 32, 48, 70] {
            drawn(&app, &theme, columns, rows);
        }
    }
}

#[test]
fn below_the_least_size_it_says_what_is_needed_and_what_is_there() {
    let theme = Theme::new(ColorTier::None, true);
    let buffer = drawn(&change("running"), &theme, 40, 10);
    let text = characters(&buffer, buffer.area);
    assert!(
        text.starts_with("too small\nneeds 60×18\nis 40×10"),
        "{text}"
    );
}

/// Box drawing, blocks, the eight arrows; Latin-1 and Greek letters in words; the integral sign.
fn is_common(character: char) -> bool {
    matches!(character,
        ' '..='~' | '\u{a0}'..='\u{ff}' | 'Α'..='ω' | '\u{2500}'..='\u{259f}' | '–' | '∫')
        || "←↑→↓↖↗↘↙".contains(character)
}

#[test]
fn only_characters_that_terminals_have() {
    for change in CHANGES.iter().filter(|change| change.0 != "hostile") {
        for (columns, rows) in [(80, 24), (120, 40), (200, 60)] {
            let buffer = drawn(
                &changed(change),
                &Theme::new(ColorTier::True, true),
                columns,
                rows,
            );
            for cell in buffer.content() {
                let rare = cell
                    .symbol()
                    .chars()
                    .find(|character| !is_common(*character));
                assert_eq!(rare, None, "{}", change.0);
            }
        }
    }
}

#[test]
fn a_locale_without_utf8_gets_ascii_whatever_is_shown() {
    for change in CHANGES {
        for tier in [
            ColorTier::True,
            ColorTier::Palette,
            ColorTier::Basic,
            ColorTier::None,
        ] {
            for (columns, rows) in [(40, 10), (80, 24), (120, 40)] {
                let buffer = drawn(&changed(change), &Theme::new(tier, false), columns, rows);
                let foreign = buffer
                    .content()
                    .iter()
                    .find(|cell| !cell.symbol().is_ascii());
                assert_eq!(foreign, None, "{}", change.0);
            }
        }
    }
}

#[test]
fn formulas_can_be_read_in_ascii() {
    let theme = Theme::new(ColorTier::None, false);
    let words = |name| {
        let buffer = drawn(&change(name), &theme, 120, 60);
        characters(&buffer, Rect::new(0, 0, 120, 60))
    };
    let help = words("help");
    assert!(help.contains("(B - beta)^2/(2 eta)"), "{help}");
    assert!(help.contains("integral of phi"), "{help}");
    assert!(!help.contains("??"), "{help}");
    let mut app = change("running");
    app.remark = Some("φ⁰ ≥ 0: take ε²".to_owned());
    let buffer = drawn(&app, &theme, 80, 24);
    let text = characters(&buffer, Rect::new(0, 0, 80, 24));
    assert!(text.contains("phi^0 >= 0: take eps^2"), "{text}");
}

/// Numbers of as many digits as they come to have.
#[test]
fn the_iterations_are_never_cut() {
    for (newton, krylov, director) in [(3, 17, 4), (12, 137, 24), (60, 4000, 200)] {
        let mut app = change("running");
        let index = app.active;
        let run = app.slots[index].run.as_mut().expect("a run");
        run.report.newton = newton;
        run.report.krylov = krylov;
        run.report.director_iterations = director;
        let buffer = drawn(&app, &Theme::new(ColorTier::None, true), 80, 24);
        let text = characters(&buffer, Rect::new(0, 0, 80, 24));
        let numbers = [newton, krylov, director].map(|it| it.to_string());
        let line = text.lines().find(|line| line.contains("Newton"));
        let line = line.unwrap_or_default();
        let words: Vec<&str> = line.split_whitespace().collect();
        for number in numbers {
            assert!(words.contains(&number.as_str()), "{number}: {line}");
        }
    }
}

#[test]
fn no_control_character_gets_through() {
    let buffer = drawn(
        &change("hostile"),
        &Theme::new(ColorTier::True, true),
        120,
        40,
    );
    let control = |cell: &&ratatui::buffer::Cell| cell.symbol().contains(char::is_control);
    assert_eq!(buffer.content().iter().find(control), None);
}

#[test]
fn the_contour_is_seen_in_every_tier() {
    for (name, tier, unicode) in THEMES {
        for field in [Field::Phase, Field::Omega] {
            let mut app = change("running");
            app.view.field = field;
            let theme = Theme::new(tier, unicode);
            let buffer = drawn(&app, &theme, 120, 40);
            let contour = theme.contour(&COLOUR_MAPS[0]);
            let on_contour = |cell: &&ratatui::buffer::Cell| match tier {
                ColorTier::True | ColorTier::Palette => cell.fg == contour || cell.bg == contour,
                _ if unicode => cell.modifier.contains(Modifier::BOLD) && cell.fg == contour,
                _ => cell.symbol() == theme.glyphs().contour && cell.fg == contour,
            };
            let count = buffer.content().iter().filter(on_contour).count();
            // The outline is about 2 × 0.64 long, the picture 0.75 high: 50 rows.
            assert!(count > 45, "{name} {field:?}: {count}");
        }
    }
}

#[test]
fn without_colours_none_is_sent_and_text_is_never_forced() {
    for change in CHANGES {
        let app = changed(change);
        let buffer = drawn(&app, &Theme::new(ColorTier::None, true), 120, 40);
        let coloured =
            |cell: &&ratatui::buffer::Cell| (cell.fg, cell.bg) != (Color::Reset, Color::Reset);
        assert_eq!(buffer.content().iter().find(coloured), None, "{}", change.0);
    }
    // In colour, letters stand on the terminal's own background, but for those over the field.
    let buffer = drawn(
        &change("help"),
        &Theme::new(ColorTier::Palette, true),
        120,
        40,
    );
    let letters = buffer
        .content()
        .iter()
        .filter(|cell| cell.symbol().chars().all(char::is_alphabetic));
    assert!(letters.clone().count() > 500);
    for cell in letters {
        assert_eq!(cell.bg, Color::Reset, "{cell:?}");
        assert!(
            matches!(cell.fg, Color::Reset | Color::Indexed(_)),
            "{cell:?}"
        );
    }
}

#[test]
fn lines_are_drawn_with_the_glyphs_that_are_asked_for() {
    let app = change("running");
    for (parts, first, last) in [
        (Parts::Quadrants, '\u{2580}', '\u{259f}'),
        (Parts::Braille, '\u{2801}', '\u{28ff}'),
        (Parts::Octants, '\u{1cd00}', '\u{1cde5}'),
    ] {
        let theme = Theme::new(ColorTier::Palette, true).with_parts(parts);
        let buffer = drawn(&app, &theme, 120, 40);
        let contour = theme.contour(&COLOUR_MAPS[0]);
        let cells = buffer.content().iter().filter(|cell| cell.fg == contour);
        let glyphs = cells.filter_map(|cell| cell.symbol().chars().next());
        let count = glyphs
            .filter(|glyph| (first..=last).contains(glyph))
            .count();
        assert!(count > 20, "{parts:?}: {count}");
    }
}

#[test]
fn the_vesicle_fills_the_picture_and_can_be_seen_in_the_whole_domain() {
    // Rows in which the membrane is seen.
    let rows = |zoom| {
        let mut app = change("running");
        app.view.zoom = zoom;
        let theme = Theme::new(ColorTier::Palette, true);
        let buffer = drawn(&app, &theme, 120, 40);
        let contour = theme.contour(&COLOUR_MAPS[0]);
        // Below the title, which says what the line is.
        let lines = (4..40).filter(|y| (0..60).any(|x| buffer[(x, *y)].fg == contour));
        lines.count()
    };
    let [fit, domain, double] = [Zoom::Fit, Zoom::Domain, Zoom::Double].map(rows);
    // This vesicle is nearly as long as the domain; the picture has 31 rows.
    assert!(domain < fit && fit < 31, "{fit} {domain}");
    assert_eq!(double, 31);
}

#[test]
fn a_circle_looks_round() {
    let mesh = Arc::new(Mesh::structured(60, 0.0, 0).expect("a regular mesh"));
    let mut app = made_up::app();
    app.slots[2] = made_up::slot("case3", &mesh);
    app.view.director = Director::Off;
    let mut state = made_up::state(&mesh, 0.0);
    let center = Point::new(0.5, 0.5);
    let circle = |node: &Point| (0.3 - length(node - center)) / 0.05;
    state.phi = mesh.nodes().iter().map(circle).map(f64::tanh).collect();
    let run = made_up::run(&mut app);
    run.picture = Some(Arc::new(RunSnapshot {
        run: run.id,
        anchoring: None,
        report: run.report.clone(),
        mesh: mesh.clone(),
        state: Arc::new(state),
    }));
    for (columns, rows) in [(80, 24), (100, 30), (120, 40), (200, 60)] {
        let buffer = drawn(&app, &Theme::new(ColorTier::Basic, true), columns, rows);
        let shown = super::super::Shown::active(&app);
        let wishes = super::super::wishes(shown.as_ref(), buffer.area);
        let mut field = divide(buffer.area, app.focus, 1, wishes).field;
        // Without the title, whose mark of the focus is a block, too.
        field.y += 1;
        let contour: Vec<(u16, u16)> = (0..rows)
            .flat_map(|y| (0..columns).map(move |x| (x, y)))
            .filter(|place| buffer[*place].modifier.contains(Modifier::BOLD))
            .filter(|place| buffer[*place].fg == Color::Red)
            .filter(|(x, y)| field.contains((*x, *y).into()))
            .collect();
        let extent = |values: Vec<u16>| {
            let (least, greatest) = (values.iter().min(), values.iter().max());
            f64::from(greatest.expect("a contour") - least.expect("a contour") + 1)
        };
        let width = extent(contour.iter().map(|place| place.0).collect());
        let height = extent(contour.iter().map(|place| place.1).collect());
        // To within the cells at both ends.
        assert!(
            (width - 2.0 * height).abs() <= 3.0,
            "{columns}×{rows}: {width} {height}"
        );
    }
}

#[test]
fn looking_back_shows_the_figures_of_that_time() {
    let theme = Theme::new(ColorTier::None, true);
    let live = drawn(&change("running"), &theme, 120, 40);
    let back = drawn(&change("looking-back"), &theme, 120, 40);
    let (live, back) = (characters(&live, live.area), characters(&back, back.area));
    assert!(live.contains("4.000e-5") && !live.contains("looking back"));
    assert!(back.contains("1.000e-5") && back.contains("looking back 2 of 5"));
}

#[test]
fn the_external_field_is_that_of_the_time_that_is_shown() {
    let theme = Theme::new(ColorTier::None, true);
    for (at, is_on) in [(2e-5, true), (2e-4, false)] {
        let mut app = made_up::app();
        let scene = Arc::make_mut(&mut app.slots[2].scene);
        scene.field = Some(scene::Field {
            strength: 0.0,
            ..scene::Field::default()
        });
        scene.changes.push(scene::Change {
            at,
            over: 0.0,
            set: vec![scene::Assignment {
                key: "field.strength".to_owned(),
                value: scene::ParameterValue::Number(1.0),
            }],
        });
        let screen = drawn(&app, &theme, 120, 40);
        let screen = characters(&screen, screen.area);
        assert_eq!(screen.contains(" H off "), !is_on, "{screen}");
        assert_eq!(screen.contains(" H → 0° "), is_on, "{screen}");
    }
}

#[test]
fn each_of_two_vesicles_has_its_sizes() {
    let theme = Theme::new(ColorTier::None, true);
    let mut app = made_up::app();
    for gallery in [false, true] {
        if gallery {
            app.screen = Screen::Gallery;
        }
        let one = drawn(&app, &theme, 120, 40);
        assert!(!characters(&one, one.area).contains("vesicles"));
        let report = &mut made_up::run(&mut app).report;
        let before = report.clone();
        let mut second = before.vesicles[0];
        if let Some(outline) = &mut second.outline {
            outline.waist = 0.0771;
        }
        second.is_at_wall = true;
        report.vesicles.push(second);
        let two = drawn(&app, &theme, 120, 40);
        let two = characters(&two, two.area);
        assert!(two.contains("2 vesicles"), "{two}");
        if !gallery {
            let row = |name: &str| {
                let mut rows = two.lines().filter(|row| row.contains(name));
                rows.next_back().unwrap_or_default().to_owned()
            };
            assert!(row("waist").ends_with(" 0.07710"), "{two}");
            // At the wall there is no reduced area.
            assert!(row("reduced area").ends_with("  -"), "{two}");
        }
        made_up::run(&mut app).report = before;
    }
}

#[test]
fn a_saved_path_is_shown_whole() {
    let path = made_up::long_path().display().to_string();
    for (columns, rows) in SIZES {
        let buffer = drawn(
            &change("saved"),
            &Theme::new(ColorTier::Palette, true),
            columns,
            rows,
        );
        let text = characters(
            &buffer,
            Rect {
                y: rows - 5,
                height: 5,
                ..buffer.area
            },
        );
        let joined: String = text.split_whitespace().collect();
        assert!(joined.contains(&path), "{text}");
    }
}

#[test]
fn text_never_stands_in_a_frame() {
    // In every row of an overlay's frame the left and the right border are where they should be.
    for name in ["help", "quit", "open", "message"] {
        for (columns, rows) in [(60, 18), (80, 24), (120, 40)] {
            let buffer = drawn(
                &change(name),
                &Theme::new(ColorTier::None, true),
                columns,
                rows,
            );
            let corner = |symbol: &str| {
                let places = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
                // The overlay's frame is the widest: its corners are the outermost of the dialog's.
                places
                    .filter(|place| buffer[*place].symbol() == symbol)
                    .collect::<Vec<_>>()
            };
            let (starts, ends) = (corner("╭"), corner("╯"));
            let framed = starts.iter().any(|(left, top)| {
                ends.iter().any(|(right, bottom)| {
                    right > left
                        && bottom > top
                        && buffer[(*right, *top)].symbol() == "╮"
                        && buffer[(*left, *bottom)].symbol() == "╰"
                        && (top + 1..*bottom).all(|y| {
                            buffer[(*left, y)].symbol() == "│" && buffer[(*right, y)].symbol() == "│"
                        })
                        // The middle of the screen is inside.
                        && (left..&(columns / 2)).contains(&left)
                        && (*top..*bottom).contains(&(rows / 2))
                })
            });
            assert!(
                framed,
                "{name} {columns}×{rows}\n{}",
                characters(&buffer, buffer.area)
            );
        }
    }
}
