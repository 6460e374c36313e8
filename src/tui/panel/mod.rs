//! The screen, one file a panel: each a pure function of the state.

use ratatui::Frame;

use super::state::App;
use super::theme::Theme;

/// Draws everything.
pub fn draw(app: &App, theme: &Theme, frame: &mut Frame<'_>) {
    let _ = (app, theme, frame);
}
