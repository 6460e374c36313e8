//! Estimated errors of φ, in L2, side by side, so that one sees which is being overpaid.

use crate::scene::Scene;
use crate::scheme::Phase;
use serde::{Deserialize, Serialize};

/// The estimate of the mesh's error is trusted where ε is at least this number of edges long at the membrane.
const RESOLVED: f64 = 2.0;

/// Where an error comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ErrorPart {
    /// The length of the steps.
    Time,
    /// The mesh.
    Space,
    /// The iterations, which end before they are at their end.
    Algebra,
}

impl ErrorPart {
    /// What to turn to make it smaller.
    pub fn knob(self) -> &'static str {
        match self {
            Self::Time => "time.step or time.tolerance",
            Self::Space => "mesh.cells",
            Self::Algebra => "solver.tolerance",
        }
    }

    /// What its milliseconds are spent on: the phases of a step that a better value of its knob makes
    /// dearer. All are, with more cells or more steps; the tolerance of the solver takes iterations.
    pub fn phases(self) -> &'static [Phase] {
        match self {
            Self::Time | Self::Space => &Phase::ALL,
            Self::Algebra => &[Phase::Residual, Phase::Linearisation, Phase::Krylov],
        }
    }
}

/// Estimated errors of φ, in L2, at the time reached. `None`: not known.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ErrorEstimates {
    /// The sum of the errors of all steps so far. It is a bound if the equations damp what is passed
    /// on.
    pub time: Option<f64>,
    /// Of the interpolation of φ on the mesh at the time reached, by gradient recovery. What a coarse
    /// mesh has done to the path until there is not in it.
    pub space: Option<f64>,
    /// The sum of the last changes in the iterations of all steps so far, a bound.
    pub algebra: Option<f64>,
}

impl ErrorEstimates {
    /// Takes in a step.
    pub(super) fn add_step(&mut self, time: Option<f64>, algebra: f64) {
        if let Some(time) = time {
            *self.time.get_or_insert(0.0) += time;
        }
        *self.algebra.get_or_insert(0.0) += algebra;
    }

    /// The estimates that are within a factor of three of the error: that of the mesh where ε is at least two
    /// edges at the membrane (docs/guide/accuracy.md has the figures). The others are not known: those of the
    /// steps and of the iterations are bounds, by factors of up to some hundreds.
    pub fn trusted(&self, scene: &Scene) -> Self {
        let edges = scene
            .mesh
            .edge_at_membrane()
            .map(|edge| scene.membrane.interface_width / edge);
        let is_resolved = edges.is_some_and(|edges| edges >= RESOLVED);
        Self {
            time: None,
            space: self.space.filter(|_| is_resolved),
            algebra: None,
        }
    }

    /// The largest of those that are known and finite.
    pub fn largest(&self) -> Option<(ErrorPart, f64)> {
        let parts = [
            (ErrorPart::Time, self.time),
            (ErrorPart::Space, self.space),
            (ErrorPart::Algebra, self.algebra),
        ];
        parts
            .into_iter()
            .filter_map(|(part, error)| Some((part, error.filter(|it| it.is_finite())?)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_is_named() {
        let mut budget = ErrorEstimates::default();
        assert_eq!(budget.largest(), None);
        budget.space = Some(1e-3);
        for _ in 0..3 {
            budget.add_step(Some(4e-4), 1e-7);
        }
        assert_eq!(
            budget.largest().map(|(part, _)| part),
            Some(ErrorPart::Time)
        );
        budget.space = Some(2e-3);
        let (part, error) = budget.largest().expect("all are known");
        assert_eq!((part, error), (ErrorPart::Space, 2e-3));
        assert_eq!(part.knob(), "mesh.cells");
        budget.algebra = Some(f64::NAN);
        assert_eq!(budget.largest(), Some((ErrorPart::Space, 2e-3)));
    }

    #[test]
    fn the_mesh_error_is_trusted_where_the_interface_has_two_edges() {
        let all = ErrorEstimates {
            time: Some(1e-3),
            space: Some(2e-3),
            algebra: Some(1e-6),
        };
        let trusted = |mesh: &str| {
            let scene = Scene::of_text(&format!("membrane.interface_width = 0.05\n{mesh}"), &[]);
            let trusted = all.trusted(&scene);
            assert_eq!((trusted.time, trusted.algebra), (None, None));
            trusted.space
        };
        assert_eq!(trusted("mesh.cells = 40"), Some(2e-3));
        assert_eq!(trusted("mesh.cells = 39"), None);
        let graded = |size: f64| {
            format!(
                "mesh = {{ kind = 'delaunay', size = 0.1, refine = {{ band = 0.1, size = {size} }} }}"
            )
        };
        assert_eq!(trusted(&graded(0.025)), Some(2e-3));
        assert_eq!(trusted(&graded(0.03)), None);
    }
}
