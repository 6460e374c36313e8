//! A given scalar function on Ω: a number, a formula, or nodal values from a file.

use super::document::Value as Toml;
use super::error::{Problem, SceneError};
use super::expression::Expression;
use super::nodal_file::{Context, NodalKey, NodalValues, read_nodal_values};
use super::parameter::{ParameterValue, Value};
use super::reader::{FINITE, Field};
use super::tables::Mesh;
use super::write::{number, quoted};

/// Formulas are tried at the nodes of the mesh, or of this one if that is finer.
const MOST_TRIED_CELLS: usize = 256;

/// A given scalar function on Ω.
#[derive(Debug, Clone, PartialEq)]
pub enum ScalarField {
    /// The same everywhere.
    Constant(f64),
    /// A formula in x and y, parsed and known to be finite.
    Expression(Expression),
    /// Nodal values from a file.
    File(NodalValues),
}

impl ScalarField {
    /// The value at the node of this index, which is at (x, y).
    ///
    /// # Panics
    ///
    /// If the values come from a file and there is no such node: a scene's file has exactly as
    /// many values as its mesh has nodes.
    pub fn at(&self, node: usize, x: f64, y: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Expression(expression) => expression.evaluate(x, y),
            Self::File(nodal) => nodal.values[node],
        }
    }
}

impl Value for ScalarField {
    type Bound = NodalKey;

    fn read(
        field: &Field<'_>,
        key: &NodalKey,
        context: &mut Context<'_>,
    ) -> Result<Self, SceneError> {
        match field.value() {
            Toml::Number { .. } => field.number(FINITE).map(Self::Constant),
            Toml::Text(text) => read_expression(field, text, &context.mesh).map(Self::Expression),
            Toml::Table(_) => {
                let table = field.table()?;
                table.allow(&["file"])?;
                let file = table.require("file", &field.path)?;
                read_nodal_values(&file, *key, context).map(Self::File)
            }
            _ => Err(field.wrong_type(Self::words(key))),
        }
    }

    fn write(&self) -> Option<String> {
        Some(match self {
            Self::Constant(value) => number(*value),
            Self::Expression(expression) => quoted(expression.text()),
            Self::File(nodal) => format!("{{ file = {} }}", quoted(&nodal.path)),
        })
    }

    fn words(_: &NodalKey) -> String {
        "a number, an expression in x and y such as \"sin(pi*x)\", or { file = \"k.txt\" }"
            .to_owned()
    }

    fn nodal_key(key: &NodalKey) -> Option<NodalKey> {
        Some(*key)
    }

    fn nodal_values(&mut self) -> Option<&mut NodalValues> {
        match self {
            Self::File(file) => Some(file),
            Self::Constant(_) | Self::Expression(_) => None,
        }
    }

    fn to_parameter(&self) -> Option<ParameterValue> {
        match self {
            Self::Constant(value) => Some(ParameterValue::Number(*value)),
            Self::Expression(formula) => Some(ParameterValue::Text(formula.text().to_owned())),
            Self::File(_) => None,
        }
    }

    fn set_parameter(&mut self, value: &ParameterValue) -> bool {
        let new = match value {
            ParameterValue::Number(value) => Some(Self::Constant(*value)),
            ParameterValue::Text(text) => text.parse().ok().map(Self::Expression),
            ParameterValue::Switch(_) => None,
        };
        new.map(|new| *self = new).is_some()
    }
}

fn read_expression(field: &Field<'_>, text: &str, mesh: &Mesh) -> Result<Expression, SceneError> {
    let expression = text.parse::<Expression>().and_then(|expression| {
        match mesh {
            Mesh::Structured { cells, .. } => {
                expression.check_finite((*cells).min(MOST_TRIED_CELLS))
            }
            Mesh::Delaunay { .. } | Mesh::Adaptive { .. } => {
                expression.check_finite(MOST_TRIED_CELLS)
            }
            Mesh::File(file) => expression.check_finite_at(&file.triangulation.nodes),
        }
        .map(|()| expression)
    });
    expression.map_err(|error| {
        let (key, range) = (field.path.clone(), error.range.clone());
        field.error_within(text, range, Problem::Expression { key, error })
    })
}
