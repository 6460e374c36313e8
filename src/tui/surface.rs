//! The backend that ratatui draws on: it collects the bytes of a frame and never asks the terminal
//! anything.

use std::cell::RefCell;
use std::io::{self, Write};
use std::rc::Rc;

use ratatui::backend::{Backend, ClearType, CrosstermBackend, WindowSize};
use ratatui::buffer::Cell;
use ratatui::layout::{Position, Size};

/// The bytes of the frame that is being drawn, shared by those who write into it.
#[derive(Debug, Clone, Default)]
pub(super) struct Bytes(Rc<RefCell<Vec<u8>>>);

impl Bytes {
    /// Starts a frame in a given buffer.
    pub fn begin(&self, buffer: Vec<u8>) {
        *self.0.borrow_mut() = buffer;
    }

    /// Ends a frame: its bytes.
    pub fn end(&self) -> Vec<u8> {
        self.0.take()
    }

    /// Appends bytes.
    pub fn push(&self, bytes: &[u8]) {
        self.0.borrow_mut().extend_from_slice(bytes);
    }

    fn len(&self) -> usize {
        self.0.borrow().len()
    }
}

impl Write for Bytes {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.push(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

const BEGIN: &[u8] = b"\x1b[?2026h";
const END: &[u8] = b"\x1b[?2026l";

/// While this lives, what is drawn appears at once when it is dropped (DEC mode 2026). Where
/// nothing was drawn, nothing is written at all.
#[derive(Debug)]
pub(super) struct Synchronized {
    bytes: Bytes,
    from: usize,
}

impl Synchronized {
    /// Begins.
    pub fn begin(bytes: &Bytes) -> Self {
        let from = bytes.len();
        bytes.push(BEGIN);
        Self {
            bytes: bytes.clone(),
            from,
        }
    }
}

impl Drop for Synchronized {
    fn drop(&mut self) {
        if self.bytes.len() == self.from + BEGIN.len() {
            self.bytes.0.borrow_mut().truncate(self.from);
        } else {
            self.bytes.push(END);
        }
    }
}

/// The backend: crossterm's, but with a size that is given, and silent where nothing changes.
#[derive(Debug)]
pub(super) struct Surface {
    inner: CrosstermBackend<Bytes>,
    size: Size,
    /// Whether the cursor is visible; the guard of the terminal has hidden it.
    cursor: bool,
}

impl Surface {
    /// A surface of a size.
    pub fn new(bytes: Bytes, (width, height): (u16, u16)) -> Self {
        Self {
            inner: CrosstermBackend::new(bytes),
            size: Size { width, height },
            cursor: false,
        }
    }

    /// Takes another size; the next frame fills it again.
    pub fn set_size(&mut self, (width, height): (u16, u16)) {
        self.size = Size { width, height };
    }
}

impl Backend for Surface {
    type Error = io::Error;

    fn draw<'a, I>(&mut self, content: I) -> io::Result<()>
    where
        I: Iterator<Item = (u16, u16, &'a Cell)>,
    {
        let mut content = content.peekable();
        if content.peek().is_some() {
            self.inner.draw(content)?;
        }
        Ok(())
    }

    fn hide_cursor(&mut self) -> io::Result<()> {
        if std::mem::replace(&mut self.cursor, false) {
            self.inner.hide_cursor()?;
        }
        Ok(())
    }

    fn show_cursor(&mut self) -> io::Result<()> {
        if !std::mem::replace(&mut self.cursor, true) {
            self.inner.show_cursor()?;
        }
        Ok(())
    }

    fn get_cursor_position(&mut self) -> io::Result<Position> {
        // Only an inline viewport asks, and the answer would have to be read from the terminal.
        Ok(Position::ORIGIN)
    }

    fn set_cursor_position<P: Into<Position>>(&mut self, position: P) -> io::Result<()> {
        self.inner.set_cursor_position(position)
    }

    fn clear(&mut self) -> io::Result<()> {
        self.inner.clear()
    }

    fn clear_region(&mut self, region: ClearType) -> io::Result<()> {
        self.inner.clear_region(region)
    }

    fn size(&self) -> io::Result<Size> {
        Ok(self.size)
    }

    fn window_size(&mut self) -> io::Result<WindowSize> {
        Ok(WindowSize {
            columns_rows: self.size,
            pixels: Size::ZERO,
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::Terminal;
    use ratatui::widgets::Paragraph;

    fn frame(terminal: &mut Terminal<Surface>, bytes: &Bytes, text: &str) -> Vec<u8> {
        let guard = Synchronized::begin(bytes);
        terminal
            .draw(|frame| frame.render_widget(Paragraph::new(text), frame.area()))
            .unwrap();
        drop(guard);
        bytes.end()
    }

    #[test]
    fn a_frame_is_synchronised_and_an_unchanged_one_is_no_bytes() {
        let bytes = Bytes::default();
        let mut terminal = Terminal::new(Surface::new(bytes.clone(), (20, 2))).unwrap();
        let first = frame(&mut terminal, &bytes, "vesicle");
        assert!(first.starts_with(BEGIN) && first.ends_with(END));
        assert!(first.windows(7).any(|part| part == b"vesicle"));
        assert_eq!(frame(&mut terminal, &bytes, "vesicle"), b"");
        assert_ne!(frame(&mut terminal, &bytes, "vesicles"), b"");
    }

    #[test]
    fn another_size_fills_the_screen_anew() {
        let bytes = Bytes::default();
        let mut terminal = Terminal::new(Surface::new(bytes.clone(), (20, 2))).unwrap();
        frame(&mut terminal, &bytes, "vesicle");
        terminal.backend_mut().set_size((1, 1));
        let again = frame(&mut terminal, &bytes, "vesicle");
        assert!(again.windows(4).any(|part| part == b"\x1b[2J"), "cleared");
        assert!(again.contains(&b'v') && !again.contains(&b'e'));
    }

    #[test]
    fn the_cursor_is_shown_and_hidden_when_that_changes() {
        let bytes = Bytes::default();
        let mut terminal = Terminal::new(Surface::new(bytes.clone(), (20, 2))).unwrap();
        let mut typed = |column: Option<u16>| {
            let guard = Synchronized::begin(&bytes);
            terminal
                .draw(|frame| {
                    if let Some(column) = column {
                        frame.set_cursor_position((column, 0));
                    }
                })
                .unwrap();
            drop(guard);
            String::from_utf8(bytes.end()).unwrap()
        };
        assert_eq!(typed(None), "");
        assert_eq!(typed(Some(3)).matches("\x1b[?25h").count(), 1);
        assert_eq!(typed(Some(4)).matches("\x1b[?25h").count(), 0);
        assert_eq!(typed(None).matches("\x1b[?25l").count(), 1);
    }
}
