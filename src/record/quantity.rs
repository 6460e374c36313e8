//! The names of what is recorded and shown: one for each quantity, on the screen, in the figures, and in the
//! guide's tables.

/// A quantity of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quantity {
    /// Its column in `history.csv` or `shape.csv`; "" where it has none.
    pub column: &'static str,
    /// What it is called.
    pub name: &'static str,
    /// What it is.
    pub words: &'static str,
}

const fn quantity(column: &'static str, name: &'static str, words: &'static str) -> Quantity {
    Quantity {
        column,
        name,
        words,
    }
}

/// All of them, in the order of the screen.
pub const QUANTITIES: [Quantity; 22] = [
    quantity(
        "step",
        "step",
        "number of the time step; 0 is the initial state",
    ),
    quantity("t", "t", "time, dimensionless like everything"),
    quantity("dt", "Δt", "length of the step"),
    quantity(
        "E_total",
        "total",
        "sum of the energies; only work from outside raises it",
    ),
    quantity("E_bending", "bending", "bending energy of the membrane"),
    quantity(
        "E_area",
        "area",
        "penalty (B - β)²/(2η): draws the surface area B to β",
    ),
    quantity(
        "E_nematic",
        "nematic",
        "energy of a director not uniform or not of length 1",
    ),
    quantity(
        "E_anchoring",
        "anchoring",
        "energy of a director not in the anchoring's direction",
    ),
    quantity(
        "E_field",
        "field",
        "energy of the director in the external field H",
    ),
    quantity(
        "E_pull",
        "pull",
        "energy of the vesicle in the potential of [pull]",
    ),
    quantity(
        "B",
        "surface area",
        "B: 0.943 times the membrane's length in this model, or in space its surface",
    ),
    quantity(
        "",
        "area/target",
        "B/β, surface area over its target: 1 when reached",
    ),
    quantity(
        "length",
        "length",
        "extent of the vesicle along its long axis",
    ),
    quantity("waist", "waist", "extent across, half way along the axis"),
    quantity("width", "width", "greatest extent across"),
    quantity(
        "",
        "reduced area",
        "4π·enclosed area/(membrane's length)², or in space the reduced volume: 1 for a circle, or a sphere",
    ),
    quantity(
        "A",
        "volume",
        "∫φ, conserved: its change since t = 0 is rounding",
    ),
    quantity(
        "law_residual",
        "energy law error",
        "what the energy law (3.26) misses by, relative",
    ),
    quantity(
        "newton",
        "Newton",
        "iterations of Newton's method in the step",
    ),
    quantity(
        "krylov",
        "linear",
        "iterations of the linear solver in the step",
    ),
    quantity("", "director", "iterations for the director in the step"),
    quantity("wall", "wall", "seconds of computing since the run began"),
];

impl Quantity {
    /// The quantity of a column.
    pub fn of_column(column: &str) -> Option<&'static Self> {
        QUANTITIES
            .iter()
            .find(|it| it.column == column && !column.is_empty())
    }

    /// The guide's table of the columns, which a test compares with it.
    #[cfg(test)]
    pub fn markdown() -> String {
        use std::fmt::Write as _;

        let mut table = "| column | name | what it is |\n| --- | --- | --- |\n".to_owned();
        for Quantity {
            column,
            name,
            words,
        } in QUANTITIES
        {
            let column = match column {
                "" => "–".to_owned(),
                column => format!("`{column}`"),
            };
            // Writing to a string cannot fail.
            let _ = writeln!(table, "| {column} | {name} | {words} |");
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::HISTORY_COLUMNS;

    #[test]
    fn every_column_has_a_name_and_no_name_stands_twice() {
        for column in HISTORY_COLUMNS.iter().chain(&["length", "waist", "width"]) {
            assert!(Quantity::of_column(column).is_some(), "{column}");
        }
        let mut names: Vec<_> = QUANTITIES.iter().map(|it| it.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), QUANTITIES.len());
        assert_eq!(Quantity::of_column(""), None);
    }

    #[test]
    fn the_guide_has_this_table() {
        let guide = include_str!("../../docs/guide/records.md");
        let table = Quantity::markdown();
        assert!(guide.contains(&table), "put this there:\n{table}");
    }
}
