//! What to change in a scene, from the errors that its run estimates while it goes.
//!
//! Of the errors of the mesh and of the steps the larger one is what accuracy is lost by, and what makes
//! the smaller one so small is paid for nothing. So where the mesh dominates by far the first thing to do
//! is to take longer steps, which costs no accuracy; then to refine the mesh. Where the steps dominate,
//! they are to be shorter, as long as the mesh can use that.

use super::advice::Knob;
use super::discretisation::{Discretisation, StepControl, fixed_mesh};
use super::error_size::ErrorSize;
use crate::scene::{Mesh, Scene};
use crate::simulation::{ErrorEstimates, ErrorPart};
use std::fmt;

/// Chosen steps cost more than they bring if their error is this part of the mesh's or less.
const OVERPAID: f64 = 0.1;

/// Steps whose error is this part of the mesh's are not noticed beside it: together the two are 3 % more
/// than the mesh's alone.
const UNNOTICED: f64 = 0.25;

/// A change at once is at most by this factor: estimates are estimates.
const AT_MOST: f64 = 10.0;

/// The error of φ at the end, over the tolerance: cases 3 and 4 at 120 cells have 0.8 to 2.1 (docs/guide/accuracy.md).
const ERROR_TO_TOLERANCE: f64 = 2.0;

/// A change of a scene, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Recommendation {
    /// Mesh and steps.
    choice: Discretisation,
    /// solver.tolerance.
    tolerance: f64,
    /// What is changed, as it is set.
    what: String,
    why: Why,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Why {
    /// The error of the iterations is the largest.
    Algebra(ErrorSize),
    /// The errors of the mesh and of the steps; which is to be turned.
    Parts {
        space: ErrorSize,
        time: ErrorSize,
        knob: Knob,
    },
    /// The same, and the steps are overpaid.
    Overpaid { space: ErrorSize, time: ErrorSize },
}

impl Recommendation {
    /// What to change in a scene whose run has these errors; `None` where they are not known, or nothing
    /// can be changed.
    pub fn of(scene: &Scene, budget: &ErrorEstimates) -> Option<Self> {
        let own = Discretisation::of(scene);
        let tolerance = scene.solver.tolerance;
        if let Some((ErrorPart::Algebra, error)) = budget.largest()
            && let Some(error) = ErrorSize::new(error)
        {
            let tolerance = round(0.1 * tolerance);
            return Some(Self {
                choice: own,
                tolerance,
                what: format!("solver.tolerance={tolerance:e}"),
                why: Why::Algebra(error),
            });
        }
        let (space, time) = (
            ErrorSize::new(budget.space?)?,
            ErrorSize::new(budget.time?)?,
        );
        let finer = fixed_mesh(scene).is_none().then_some(2 * own.cells);
        let paced = |wanted: f64| Discretisation {
            pace: match own.pace {
                // Δt by its error is cheaper than any fixed one.
                StepControl::Step(_) => StepControl::Tolerance(round(wanted / ERROR_TO_TOLERANCE)),
                StepControl::Tolerance(tolerance) => {
                    let factor = (wanted / time.get()).clamp(AT_MOST.recip(), AT_MOST);
                    StepControl::Tolerance(round(factor * tolerance))
                }
            },
            ..own
        };
        // Fixed steps are overpaid wherever the mesh dominates: chosen ones are cheaper.
        let overpaid =
            matches!(own.pace, StepControl::Step(_)) || time.get() <= OVERPAID * space.get();
        let (choice, why) = match Knob::of(space, time) {
            Knob::Mesh if overpaid => (
                paced(UNNOTICED * space.get()),
                Why::Overpaid { space, time },
            ),
            knob => {
                let choice = match knob {
                    Knob::Steps => paced(0.5 * space.get()),
                    Knob::Mesh => Discretisation {
                        cells: finer?,
                        ..own
                    },
                    Knob::Both => Discretisation {
                        cells: finer?,
                        ..paced(0.25 * time.get())
                    },
                };
                (choice, Why::Parts { space, time, knob })
            }
        };
        let mut what = Vec::new();
        if choice.cells != own.cells {
            what.extend(mesh_settings(&choice.applied_to(scene).mesh));
        }
        if let StepControl::Tolerance(tolerance) = choice.pace
            && choice.pace != own.pace
        {
            what.push(format!("time.tolerance={tolerance:e}"));
        }
        (!what.is_empty()).then(|| Self {
            choice,
            tolerance,
            what: what.join(", "),
            why,
        })
    }

    /// What is changed, as `--set` takes it.
    pub fn what(&self) -> &str {
        &self.what
    }

    /// The scene with the change.
    pub fn applied_to(&self, scene: &Scene) -> Scene {
        let mut changed = if self.choice == Discretisation::of(scene) {
            scene.clone()
        } else {
            self.choice.applied_to(scene)
        };
        changed.solver.tolerance = self.tolerance;
        changed.name = format!("{}, {}", scene.name, self.what);
        changed
    }
}

/// What makes a mesh as fine as this one, as it is set.
fn mesh_settings(mesh: &Mesh) -> Vec<String> {
    match mesh {
        Mesh::Structured { cells, .. } => vec![format!("mesh.cells={cells}")],
        Mesh::Delaunay { size, refine, .. } => {
            let mut settings = vec![format!("mesh.size={size:e}")];
            settings.extend(refine.map(|it| format!("mesh.refine.size={:e}", it.size)));
            settings
        }
        Mesh::Adaptive { size, refine, .. } => vec![
            format!("mesh.size={size:e}"),
            format!("mesh.interface={:e}", refine.size),
        ],
        Mesh::File(_) => Vec::new(),
    }
}

impl fmt::Display for Recommendation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.why {
            Why::Algebra(error) => write!(
                f,
                "The iterations leave the largest error, {error:.1e}: a smaller tolerance."
            ),
            Why::Overpaid { space, time } => write!(
                f,
                "The error of the mesh, {space:.1e}, is {:.0} times that of the steps, {time:.1e}: steps \
                 chosen by their error cost less, and the mesh does not notice.",
                space.get() / time.get()
            ),
            Why::Parts { space, time, knob } => write!(
                f,
                "The error is {space:.1e} from the mesh and {time:.1e} from the steps: {}.",
                match knob {
                    Knob::Mesh => "a finer mesh",
                    Knob::Steps => "shorter steps",
                    Knob::Both => "both together",
                }
            ),
        }
    }
}

/// 1, 2 or 5 times a power of ten, not above the value.
fn round(value: f64) -> f64 {
    let mut exponent = value.log10().floor() as i32;
    let mut digit = value / 10f64.powi(exponent);
    // What rounding of the logarithm has left below 1.
    if digit < 1.0 {
        (exponent, digit) = (exponent - 1, 10.0 * digit);
    }
    let digit = match digit {
        digit if digit >= 5.0 => 5,
        digit if digit >= 2.0 => 2,
        _ => 1,
    };
    // As it is read from a text: 5e-4 and not 5.000000000000001e-4.
    format!("{digit}e{exponent}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(settings: &[&str]) -> Scene {
        let text = crate::scene::preset("case3").expect("a preset");
        Scene::of_text(text, settings)
    }

    fn what(settings: &[&str], [time, space, algebra]: [f64; 3]) -> Option<String> {
        let budget = ErrorEstimates {
            time: Some(time),
            space: Some(space),
            algebra: Some(algebra),
        };
        let suggestion = Recommendation::of(&scene(settings), &budget)?;
        Some(suggestion.what().to_owned())
    }

    #[test]
    fn what_is_overpaid_is_made_cheaper_before_the_mesh_is_refined() {
        let chosen = |tolerance: &str| what(&[tolerance], [1e-4, 1e-2, 1e-9]);
        assert_eq!(
            what(&[], [1e-4, 1e-2, 1e-9]).as_deref(),
            Some("time.tolerance=1e-3")
        );
        assert_eq!(
            chosen("time.tolerance=1e-5").as_deref(),
            Some("time.tolerance=1e-4")
        );
        // Not overpaid: the mesh.
        assert_eq!(
            what(&["time.tolerance=1e-4"], [3e-3, 1e-2, 1e-9]).as_deref(),
            Some("mesh.cells=240")
        );
    }

    #[test]
    fn the_knob_of_the_largest_error_is_turned() {
        assert_eq!(
            what(&["time.tolerance=1e-2"], [1e-1, 1e-2, 1e-9]).as_deref(),
            Some("time.tolerance=1e-3")
        );
        assert_eq!(
            what(&["time.tolerance=1e-2"], [1e-2, 1e-2, 1e-9]).as_deref(),
            Some("mesh.cells=240, time.tolerance=2e-3")
        );
        assert_eq!(
            what(&[], [1e-3, 1e-2, 1e-1]).as_deref(),
            Some("solver.tolerance=1e-6")
        );
    }

    #[test]
    fn nothing_is_suggested_where_nothing_is_known_or_can_be_changed() {
        assert_eq!(
            Recommendation::of(&scene(&[]), &ErrorEstimates::default()),
            None
        );
        for [time, space, algebra] in [
            [f64::NAN, 1e-2, 1e-9],
            [1e-4, f64::NAN, 1e-9],
            [1e-4, f64::INFINITY, 1e-9],
            [0.0, 1e-2, 1e-9],
        ] {
            assert_eq!(what(&[], [time, space, algebra]), None);
        }
        assert_eq!(
            what(&[], [1e-4, 1e-2, f64::NAN]).as_deref(),
            Some("time.tolerance=1e-3")
        );
        let own_mesh = &["mesh.jitter=0.1", "time.tolerance=1e-4"];
        assert_eq!(what(own_mesh, [3e-3, 1e-2, 1e-9]), None);
    }

    #[test]
    fn the_change_and_nothing_else_is_applied() {
        let scene = scene(&[]);
        let budget = ErrorEstimates {
            time: Some(1e-4),
            space: Some(1e-2),
            algebra: None,
        };
        let suggestion = Recommendation::of(&scene, &budget).expect("both are known");
        let mut changed = suggestion.applied_to(&scene);
        assert_eq!(changed.time.tolerance, Some(1e-3));
        assert_eq!(changed.time.end, scene.time.end);
        assert_eq!(changed.name, "Case 3, time.tolerance=1e-3");
        (changed.time, changed.name) = (scene.time, scene.name.clone());
        assert_eq!(changed, scene);
    }

    #[test]
    fn numbers_are_rounded_down_to_one_digit() {
        for (value, rounded) in [(1e-3, 1e-3), (9.9e-4, 5e-4), (2.1, 2.0), (0.05, 0.05)] {
            assert_eq!(round(value), rounded);
        }
    }
}
