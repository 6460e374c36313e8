//! The data of a figure as CSV.

use super::data::Snapshot;
use crate::fem::Mesh;
use crate::record::push_cells;
use crate::scheme::State;
use std::io;

/// A table of numbers whose first column names the scene.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Table {
    text: String,
}

impl Table {
    pub fn new(columns: &[String]) -> Table {
        Table {
            text: columns.join(",") + "\n",
        }
    }

    /// Appends a row. What is not there or no number is an empty cell.
    pub fn row(&mut self, scene: &str, cells: impl IntoIterator<Item = Option<f64>>) {
        // Names of scenes for files have no comma.
        self.text.push_str(scene);
        self.text.push(',');
        let cells = cells.into_iter();
        push_cells(
            &mut self.text,
            cells.map(|cell| cell.filter(|value| !value.is_nan())),
        );
        self.text.push('\n');
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    /// Writes what there is and goes on empty, once that is much: what has a row a node is large.
    fn pour(&mut self, file: &mut dyn io::Write, least: usize) -> io::Result<()> {
        if self.text.len() >= least {
            file.write_all(self.text.as_bytes())?;
            self.text.clear();
        }
        Ok(())
    }
}

/// Bytes of rows that are gathered before they are written.
const GATHERED: usize = 1 << 16;

/// Writes everything of a state: a node a row.
///
/// # Errors
/// The system's.
pub(super) fn write_state(
    file: &mut dyn io::Write,
    scene: &str,
    mesh: &Mesh,
    (step, t): (u64, f64),
    state: &State,
) -> io::Result<()> {
    let columns = [
        "scene", "step", "t", "x", "y", "phi", "d_x", "d_y", "omega", "mu",
    ];
    let mut table = Table::new(&columns.map(str::to_owned));
    for node in mesh.outer_order() {
        let [x, y] = mesh.nodes()[node].into();
        let [dx, dy] = director_at(state, node);
        let [phi, omega, mu] = [&state.phi, &state.omega, &state.mu].map(|field| Some(field[node]));
        let place = [Some(step as f64), Some(t), Some(x), Some(y)];
        table.row(scene, place.into_iter().chain([phi, dx, dy, omega, mu]));
        table.pour(file, GATHERED)?;
    }
    table.pour(file, 0)
}

/// Writes what strips show of their snapshots, φ and d, a node a row: for each scene, by its name in files.
///
/// # Errors
/// The system's.
pub(super) fn write_strips<'a>(
    file: &mut dyn io::Write,
    strips: impl Iterator<Item = (&'a str, &'a [&'a Snapshot])>,
) -> io::Result<()> {
    let columns = ["scene", "step", "t", "x", "y", "phi", "d_x", "d_y"];
    let mut table = Table::new(&columns.map(str::to_owned));
    for (scene, snapshots) in strips {
        for snapshot in snapshots {
            let (mesh, state) = (&snapshot.mesh, &snapshot.state);
            for node in mesh.outer_order() {
                let [x, y] = mesh.nodes()[node].into();
                let place = [
                    Some(snapshot.step as f64),
                    Some(snapshot.t),
                    Some(x),
                    Some(y),
                ];
                let [dx, dy] = director_at(state, node);
                let cells = place.into_iter().chain([Some(state.phi[node]), dx, dy]);
                table.row(scene, cells);
                table.pour(file, GATHERED)?;
            }
        }
    }
    table.pour(file, 0)
}

fn director_at(state: &State, node: usize) -> [Option<f64>; 2] {
    match &state.director {
        Some(director) => [0, 1].map(|axis| Some(director[axis][node])),
        None => [None, None],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_an_empty_cell() {
        let mut table = Table::new(&["scene", "a", "b", "c"].map(str::to_owned));
        table.row("case3", [Some(1e-7), None, Some(f64::NAN)]);
        assert_eq!(table.text(), "scene,a,b,c\ncase3,1e-7,,\n");
    }
}
