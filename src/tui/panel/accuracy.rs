//! The price list of accuracy: what a scene takes at several errors of φ.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::text;
use crate::tui::layout::centred;
use crate::tui::numbers::brief;
use crate::tui::state::PriceList;
use crate::tui::theme::{Role, Theme};

/// Columns that the dialog can use.
const WIDTH: u16 = 84;

/// Below the list.
const NOTE: &str = "The mesh follows the membrane, and time steps are chosen. About this error (of φ, in L2, at the end) \
                    is what both are chosen for; m measures the error that a run has.";

/// Draws the list.
pub fn draw(list: &PriceList, theme: &Theme, screen: Rect, buffer: &mut Buffer) {
    let width = WIDTH.min(screen.width.saturating_sub(4));
    let inner = usize::from(width).saturating_sub(4);
    let note = text::wrap(&theme.spelt(NOTE), inner);
    let height = list.rows.len() + note.len() + 4;
    let area = centred(screen, width, height as u16);
    let title = format!("What accuracy costs: {}", list.name);
    let inside = text::frame(buffer, area, theme, &title, theme.style(Role::Accent));
    let head = format!(
        " {:>8}  {:>7}  {:>6}  on this machine",
        "error", "edges", "nodes"
    );
    text::line(buffer, inside, 0, Span::styled(head, theme.muted()));
    let mut row = 1;
    for (index, (offer, price)) in list.rows.iter().enumerate() {
        let (mesh, words) = match (&offer.offered, price) {
            (Err(why), _) => (String::new(), why.to_string()),
            (Ok(offered), price) => {
                let edge = brief(offered.edge, 2);
                let words = match price {
                    Some(Ok(words) | Err(words)) => words.clone(),
                    None => "being measured".to_owned(),
                };
                (format!("{edge:>7}  {:>6}  ", offered.nodes), words)
            }
        };
        let style = match index == list.chosen {
            true => theme.pill(Role::Accent),
            false => theme.strong(),
        };
        let used = 11 + mesh.chars().count();
        let line = Line::from(vec![
            Span::styled(format!(" {:>8} ", format!("{:e}", offer.error)), style),
            Span::raw(format!(" {mesh}")),
            Span::raw(text::shorten(&words, inner.saturating_sub(used))),
        ]);
        text::line(buffer, inside, row, line);
        row += 1;
    }
    for line in note {
        row += 1;
        text::line(buffer, inside, row, Span::styled(line, theme.muted()));
    }
}
