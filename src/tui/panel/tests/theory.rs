//! The shape at rest of theory over the field.

use std::f64::consts::PI;
use std::sync::Arc;

use ratatui::style::Modifier;

use super::{THEMES, characters, drawn, made_up};
use crate::theory::{CurveAtRest, ShapeAtRest};
use crate::tui::colour_map::COLOUR_MAPS;
use crate::tui::state::Zoom;
use crate::tui::theme::{ColorTier, Theme};

/// A circle that crosses the made-up vesicle: its dots are drawn, and few of them over the membrane's line.
#[test]
fn the_membrane_is_seen_where_theory_crosses_it() {
    let radius = 0.2;
    let circle = CurveAtRest::new(PI * radius * radius, None).expect("a circle");
    let mut app = made_up::app();
    // The part that is shown does not depend on what is drawn over it.
    app.view.zoom = Zoom::Domain;
    let theory = &mut made_up::run(&mut app).theory;
    theory.known = Some(Ok(Arc::new(ShapeAtRest::Curve(circle))));
    for (name, tier, unicode) in THEMES {
        let theme = Theme::new(tier, unicode);
        let [without, with] = [false, true].map(|is_shown| {
            app.view.theory = is_shown;
            drawn(&app, &theme, 120, 40)
        });
        let contour = theme.contour(&COLOUR_MAPS[0]);
        let (mut membrane, mut hidden, mut dots) = (0, 0, 0);
        for y in 0..40 {
            let row = characters(&with, ratatui::layout::Rect::new(0, y, 120, 1));
            // The title explains both lines.
            if row.contains("theory at rest") {
                continue;
            }
            for x in 0..120 {
                let (before, after) = (&without[(x, y)], &with[(x, y)]);
                let is_membrane = match tier {
                    ColorTier::True | ColorTier::Palette => {
                        [before.fg, before.bg].contains(&contour)
                    }
                    _ => before.fg == contour && before.modifier.contains(Modifier::BOLD),
                };
                membrane += usize::from(is_membrane);
                if before != after {
                    assert_eq!(after.symbol(), theme.glyphs().theory, "{name}: {x}, {y}");
                    hidden += usize::from(is_membrane);
                    dots += 1;
                }
            }
        }
        assert!(membrane > 20 && dots > 20, "{name}: {membrane}, {dots}");
        assert!(10 * hidden <= membrane, "{name}: {hidden} of {membrane}");
    }
}
