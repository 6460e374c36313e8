//! The data of a figure as CSV.

use super::data::Snapshot;
use crate::fem::Mesh;
use crate::record::Number;
use crate::scheme::State;
use std::fmt::Write;

/// A table of numbers whose first column names the scene.
#[derive(Debug, Clone, PartialEq, Eq)]
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
        for cell in cells {
            self.text.push(',');
            if let Some(value) = cell.filter(|value| !value.is_nan()) {
                // Writing to a String cannot fail.
                let _ = write!(self.text, "{}", Number(value));
            }
        }
        self.text.push('\n');
    }

    pub fn text(&self) -> &str {
        &self.text
    }
}

/// The columns of a table of fields: a node a row.
pub(super) fn fields_table() -> Table {
    let columns = [
        "scene", "step", "t", "x", "y", "phi", "omega", "mu", "d_x", "d_y",
    ];
    Table::new(&columns.map(str::to_owned))
}

/// Appends a state, node by node.
pub(super) fn add_state(
    table: &mut Table,
    scene: &str,
    mesh: &Mesh,
    (step, t): (u64, f64),
    state: &State,
) {
    for (node, &[x, y]) in mesh.nodes().iter().enumerate() {
        let [dx, dy] = match &state.director {
            Some(director) => [0, 1].map(|axis| Some(director[axis][node])),
            None => [None, None],
        };
        let [phi, omega, mu] = [&state.phi, &state.omega, &state.mu].map(|field| Some(field[node]));
        let cells = [
            Some(step as f64),
            Some(t),
            Some(x),
            Some(y),
            phi,
            omega,
            mu,
            dx,
            dy,
        ];
        table.row(scene, cells);
    }
}

/// Appends a snapshot, node by node.
pub(super) fn add_snapshot(table: &mut Table, scene: &str, mesh: &Mesh, snapshot: &Snapshot) {
    add_state(
        table,
        scene,
        mesh,
        (snapshot.step, snapshot.t),
        &snapshot.state,
    );
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
