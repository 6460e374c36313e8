//! What the map of a sweep shows, and what keys do to it.

use super::help;
use crate::figure::{Arranged, SweepFigureError, SweepView};
use crate::study::sweep::{SweepFolder, Table};
use crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use std::collections::HashMap;

/// Samples of a small picture along each side.
pub(super) const SAMPLES: usize = 128;

/// φ of a vesicle on a grid of [`SAMPLES`] × [`SAMPLES`], row by row from above: whether it is positive.
pub(super) type Thumbnail = Vec<bool>;

/// The map, and where its cursor is.
#[derive(Debug)]
pub struct SweepMap {
    pub(super) table: Table,
    pub(super) arranged: Arranged,
    /// By the row of the point.
    pub(super) thumbnails: HashMap<usize, Thumbnail>,
    /// The part of the domain that the vesicles take, in samples: the first and the last column, and row.
    pub(super) region: [[usize; 2]; 2],
    pub(super) panel: usize,
    /// Along x and y.
    pub(super) cursor: [usize; 2],
    /// The column that colours the vesicles.
    pub(super) column: String,
    /// How often another page of the point's values was asked for.
    pub(super) page: usize,
    /// How far the list of all keys is scrolled, if it is shown.
    pub(super) help: Option<u16>,
    /// Something to say in passing.
    pub remark: Option<String>,
}

/// What a key asks of the loop.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Wish {
    Quit,
    Stop,
    /// Open the run of a row.
    Open(usize),
}

impl SweepMap {
    /// The map of a sweep as it is at present, without pictures yet.
    ///
    /// # Errors
    /// [`SweepFigureError`]: nothing varies, or too much.
    pub fn new(folder: &SweepFolder) -> Result<SweepMap, SweepFigureError> {
        let table = Table::read(folder);
        let column = "waist/length".to_owned();
        Ok(SweepMap {
            arranged: arrange(folder, &table, &column)?,
            table,
            thumbnails: HashMap::new(),
            region: [[0, SAMPLES - 1]; 2],
            panel: 0,
            cursor: [0, 0],
            column,
            page: 0,
            help: None,
            remark: None,
        })
    }

    /// Takes over a table that was read again.
    pub(super) fn renew(&mut self, folder: &SweepFolder, table: Table) {
        if let Ok(arranged) = arrange(folder, &table, &self.column) {
            self.arranged = arranged;
            self.table = table;
        }
    }

    /// Takes over small pictures.
    pub(super) fn show(&mut self, pictures: impl IntoIterator<Item = (usize, Thumbnail)>) {
        self.thumbnails.extend(pictures);
        let mut region = [[SAMPLES, 0]; 2];
        for picture in self.thumbnails.values() {
            for sample in (0..picture.len()).filter(|sample| picture[*sample]) {
                for (bounds, at) in region.iter_mut().zip([sample % SAMPLES, sample / SAMPLES]) {
                    *bounds = [bounds[0].min(at), bounds[1].max(at)];
                }
            }
        }
        if region.iter().all(|[low, high]| low <= high) {
            self.region = region;
        }
    }

    /// The row of the point under the cursor.
    pub(super) fn selected(&self) -> Option<usize> {
        let panel = self.arranged.panels.get(self.panel)?;
        let [x, y] = self.cursor;
        self.arranged.cell(panel, x, y).row
    }

    /// Takes a key.
    pub(super) fn key(&mut self, key: KeyEvent) -> Option<Wish> {
        self.remark = None;
        let is_control = key.modifiers.contains(KeyModifiers::CONTROL);
        match key.code {
            KeyCode::Char('c') if is_control => return Some(Wish::Quit),
            KeyCode::Char('z') if is_control => return Some(Wish::Stop),
            _ => {}
        }
        if let Some(scroll) = self.help {
            self.help = help::scrolled(scroll, key.code);
            return None;
        }
        let most = [self.arranged.x.values.len() - 1, self.arranged.rows() - 1];
        let panels = self.arranged.panels.len();
        let [x, y] = &mut self.cursor;
        match key.code {
            KeyCode::Char('?') | KeyCode::F(1) => self.help = Some(0),
            KeyCode::Char(' ') => self.page += 1,
            KeyCode::Char('q') | KeyCode::Esc => return Some(Wish::Quit),
            KeyCode::Left | KeyCode::Char('h') => *x = x.saturating_sub(1),
            KeyCode::Right | KeyCode::Char('l') => *x = (*x + 1).min(most[0]),
            KeyCode::Down | KeyCode::Char('j') => *y = y.saturating_sub(1),
            KeyCode::Up | KeyCode::Char('k') => *y = (*y + 1).min(most[1]),
            KeyCode::Home => *x = 0,
            KeyCode::End => *x = most[0],
            KeyCode::Tab | KeyCode::PageDown => self.panel = (self.panel + 1) % panels,
            KeyCode::BackTab | KeyCode::PageUp => self.panel = (self.panel + panels - 1) % panels,
            KeyCode::Enter => match self.selected() {
                Some(row) => return Some(Wish::Open(row)),
                None => self.remark = Some("there is no point here".to_owned()),
            },
            _ => {}
        }
        None
    }
}

fn arrange(
    folder: &SweepFolder,
    table: &Table,
    column: &str,
) -> Result<Arranged, SweepFigureError> {
    let view = SweepView {
        column: column.to_owned(),
        ..SweepView::default()
    };
    Arranged::new(folder, table, &view)
}
