//! What to simulate.

mod error;
mod expression;
mod model;
mod near;

pub use error::{Origin, Place, Problem, SceneError};
pub use expression::{Expression, ExpressionError, ExpressionProblem};
pub use model::*;
