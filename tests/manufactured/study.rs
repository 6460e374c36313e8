//! Runs towards an exact solution, and how far they end from it.

use std::sync::Arc;

use vesica::internal::fem::{QuadratureRule, Space, ritz_projection};
use vesica::internal::scene::Boundary;
use vesica::{Mesh, Point, Scene, Scheme, State};

use super::fields::{DirectorField, Mode, PhaseField};
use super::model::{CURVATURE, Flaw, Model};
use super::source::{Clock, Source};

/// Where every run ends.
const END: f64 = 0.2;

/// Newton's method stops where every field's relative change and the energy law's miss are below.
const TOLERANCE: f64 = 1e-9;

/// φ between about −0.65 and 1.4: beyond 1 the indicator I is cut off.
const MOVING: PhaseField = PhaseField {
    modes: &[
        mode([0, 0], 0.1, 0.0),
        mode([1, 1], 0.6, 0.3),
        mode([2, 0], 0.0, 0.3),
        mode([0, 1], -0.3, 0.2),
    ],
    is_rotated: false,
};

/// φ at rest, for substep 1 alone.
const STEADY: PhaseField = PhaseField {
    modes: &[
        mode([0, 0], 0.1, 0.0),
        mode([1, 1], 0.8, 0.0),
        mode([2, 0], 0.3, 0.0),
    ],
    is_rotated: false,
};

/// −1 + 1.2 sin²(πx) sin²(πy) + 3.2 e^(−t) sin²(πx) cos(πx) sin²(πy): φ = −1 and ∇φ·n = 0 on the wall.
const CLAMPED: PhaseField = PhaseField {
    modes: &[
        mode([0, 0], -0.7, 0.0),
        mode([2, 0], -0.3, 0.0),
        mode([0, 2], -0.3, 0.0),
        mode([2, 2], 0.3, 0.0),
        mode([1, 0], 0.0, 0.4),
        mode([3, 0], 0.0, -0.4),
        mode([1, 2], 0.0, -0.4),
        mode([3, 2], 0.0, 0.4),
    ],
    is_rotated: false,
};

const fn mode(waves: [u32; 2], steady: f64, fading: f64) -> Mode {
    Mode {
        waves,
        steady,
        fading,
    }
}

/// What is solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Problem {
    /// Substep 2 alone: bending with k ≠ 0 and the area penalty.
    Membrane,
    /// The same with φ = −1 on the wall.
    Clamped,
    /// Substep 1 alone: φ at rest, nematic and homeotropic anchoring.
    Director,
    /// Both substeps with every effect.
    Parallel,
    /// Both substeps with every effect.
    Homeotropic,
    /// The same by rotation about x = 0.
    Rotated,
    /// Substep 1 alone, by rotation.
    RotatedDirector,
}

impl Problem {
    fn is_director_alone(self) -> bool {
        matches!(self, Self::Director | Self::RotatedDirector)
    }

    fn model(self, run: Run, flaw: Option<Flaw>) -> Model {
        // A membrane that moves by some 1e-10: substep 2 runs, but is not what is tested.
        let mobility = if self.is_director_alone() {
            1e-12
        } else {
            1e-3
        };
        let boundary = if self == Self::Clamped {
            "clamped"
        } else {
            "natural"
        };
        let is_rotated = matches!(self, Self::Rotated | Self::RotatedDirector);
        let geometry = if is_rotated { "axisymmetric" } else { "planar" };
        let Run {
            quadrature,
            cells,
            mesh,
            ..
        } = run;
        let mesh = mesh.tables(cells);
        let mut text = format!(
            "[domain]\nboundary = \"{boundary}\"\ngeometry = \"{geometry}\"\n\
             {mesh}\
             [membrane]\ninterface_width = 0.2\nmobility = {mobility:?}\n\
             spontaneous_curvature = \"{CURVATURE}\"\n\
             [area]\ntarget = 0.8\npenalty = 0.1\n\
             [solver]\nquadrature = \"{quadrature}\"\ntolerance = {TOLERANCE:?}\nlaw_tolerance = {TOLERANCE:?}\n"
        );
        let anchoring = match self {
            Self::Membrane | Self::Clamped => None,
            Self::Parallel => Some("parallel"),
            Self::Director | Self::Homeotropic | Self::Rotated | Self::RotatedDirector => {
                Some("homeotropic")
            }
        };
        if let Some(kind) = anchoring {
            text.push_str(&format!(
                "[nematic]\nweight = 4.0\nmobility = 0.8\npenalty = 0.5\n\
                 [anchoring]\nkind = \"{kind}\"\nweight = 1.0\n"
            ));
        }
        let mut no_files = |path: &str| panic!("no scene of this test reads {path}");
        let scene = Scene::parse(&text, "the scene of a test", &[], &mut no_files)
            .unwrap_or_else(|error| panic!("{error}\n{text}"));
        Model {
            scene,
            phase: PhaseField {
                is_rotated,
                ..match self {
                    Self::Director | Self::RotatedDirector => STEADY,
                    Self::Clamped => CLAMPED,
                    _ => MOVING,
                }
            },
            director: anchoring.map(|_| DirectorField {
                swing: 0.5,
                is_rotated,
            }),
            flaw,
        }
    }
}

/// A family of meshes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MeshKind {
    /// Where substep 2 takes the fast path unless the wall is clamped.
    Regular,
    /// Its interior nodes moved by up to so much of h.
    Jittered(f64),
    /// Delaunay, of one size.
    Delaunay,
    /// Delaunay, of half that size about an ellipse.
    Graded,
}

impl MeshKind {
    /// In the table of errors.
    pub fn name(self) -> &'static str {
        match self {
            Self::Regular => "regular",
            Self::Jittered(_) => "jittered",
            Self::Delaunay => "delaunay",
            Self::Graded => "graded",
        }
    }

    /// The tables [mesh] and [vesicle] of a scene.
    fn tables(self, cells: usize) -> String {
        let size = 1.0 / cells as f64;
        match self {
            Self::Regular => format!("[mesh]\ncells = {cells}\n"),
            Self::Jittered(jitter) => format!("[mesh]\ncells = {cells}\njitter = {jitter:?}\n"),
            Self::Delaunay => format!("[mesh]\nkind = \"delaunay\"\nsize = {size:?}\n"),
            Self::Graded => format!(
                "[mesh]\nkind = \"delaunay\"\nsize = {size:?}\n\
                 refine = {{ band = 0.05, size = {:?} }}\n\
                 [vesicle]\nshape = \"ellipse\"\nhalf_axes = [0.35, 0.25]\nangle = 90\n",
                0.5 * size
            ),
        }
    }
}

/// One run: a problem and how it is solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// What is solved.
    pub problem: Problem,
    /// Of every integral.
    pub quadrature: &'static str,
    /// Of which kind the mesh is.
    pub mesh: MeshKind,
    /// 1/h.
    pub cells: usize,
    /// Equal steps from t = 0 to t = 0.2.
    pub steps: usize,
}

/// The fields of which errors are taken.
pub const FIELDS: [&str; 4] = ["phi", "omega", "mu", "director"];

/// The L2 norms of the errors of the [`FIELDS`]; `None` where the problem does not test a field.
pub type Errors = [Option<f64>; 4];

/// What came of a run.
pub struct Outcome {
    run: Run,
    model: Model,
    mesh: Arc<Mesh>,
    /// The fields at the end.
    pub state: State,
}

impl Run {
    /// Makes it, every step solved to far below the errors that are measured.
    pub fn solve(self, flaw: Option<Flaw>) -> Outcome {
        let model = self.problem.model(self, flaw);
        let mesh = Mesh::of(&model.scene).expect("a fair mesh");
        let clamped = model.scene.boundary == Boundary::Clamped;
        let [phi, d_x, d_y] = initial_values(&model, &mesh, clamped);
        let director = d_x.zip(d_y).map(|(x, y)| [x, y]);
        let phi = phi.expect("there is always a membrane");
        let mut scheme = Scheme::new(&model.scene, mesh.clone(), phi, director).expect("a scheme");
        assert_eq!(
            scheme.uses_transform(),
            self.mesh == MeshKind::Regular && !clamped
        );

        let clock = Clock::default();
        let source = Source::new(model.clone(), clock.clone(), scheme.space());
        scheme.effects_mut().add(source);
        scheme.forget();
        let dt = END / self.steps as f64;
        for step in 1..=self.steps {
            clock.set(model.source_time(step as f64 * dt, dt));
            let report = scheme
                .step(dt)
                .unwrap_or_else(|error| panic!("{self:?}, step {step}: {error}"));
            assert_eq!(report.fallback, None, "{self:?}, step {step}");
        }
        Outcome {
            run: self,
            model,
            mesh,
            state: scheme.state().clone(),
        }
    }
}

/// The Ritz projections of φ, d_x and d_y at t = 0.
fn initial_values(model: &Model, mesh: &Arc<Mesh>, clamped: bool) -> [Option<Vec<f64>>; 3] {
    let phase = |place: Point| {
        let phase = model.phase.at(place, 0.0);
        (phase.value, phase.gradient)
    };
    let wall = clamped.then_some(-1.0);
    let phi = ritz_projection(mesh, &phase, wall).expect("solvable");
    let [d_x, d_y] = [0, 1].map(|i: usize| {
        let field = model.director?;
        let component = |place: Point| {
            let director = field.at(place, 0.0);
            (director.value[i], director.gradient[i])
        };
        let mut projected = ritz_projection(mesh, &component, None).expect("solvable");
        for (value, on_axis) in projected.iter_mut().zip(mesh.on_axis()) {
            if on_axis && i == 0 {
                *value = 0.0;
            }
        }
        Some(projected)
    });
    [Some(phi), d_x, d_y]
}

impl Outcome {
    /// The distance to the exact solution.
    pub fn errors(&self) -> Errors {
        let space = Space::new(self.mesh.clone(), QuadratureRule::Consistent);
        let places = space.point_positions();
        let distance = |nodal: &[f64], exact: &dyn Fn(Point) -> f64| {
            let mut values = vec![0.0; space.points()];
            space.whole().interpolate(nodal, &mut values);
            for (value, place) in values.iter_mut().zip(&places) {
                *value = (*value - exact(*place)).powi(2);
            }
            space.whole().integrate(&values)
        };
        let model = &self.model;
        let phase = |place: Point| model.phase.at(place, END);
        let phi = distance(&self.state.phi, &|place| phase(place).value);
        let omega = distance(&self.state.omega, &|place| {
            model.omega(place, &phase(place)).0
        });
        let mu = distance(&self.state.mu, &|place| model.mu(&phase(place)));
        let director = self
            .state
            .director
            .as_ref()
            .zip(model.director)
            .map(|(d, field)| {
                let component = |i: usize| distance(&d[i], &|place| field.at(place, END).value[i]);
                component(0) + component(1)
            });
        self.tested([Some(phi), Some(omega), Some(mu), director])
    }

    /// The distance to nodal values on the same mesh.
    pub fn distance_to(&self, other: &State) -> Errors {
        let space = Space::new(self.mesh.clone(), QuadratureRule::Consistent);
        let distance = |nodal: &[f64], other: &[f64]| {
            let difference: Vec<f64> = nodal.iter().zip(other).map(|(a, b)| a - b).collect();
            space.mass().quadratic_form(&difference)
        };
        let state = &self.state;
        let director = state.director.as_ref().zip(other.director.as_ref());
        self.tested([
            Some(distance(&state.phi, &other.phi)),
            Some(distance(&state.omega, &other.omega)),
            Some(distance(&state.mu, &other.mu)),
            director.map(|(a, b)| distance(&a[0], &b[0]) + distance(&a[1], &b[1])),
        ])
    }

    fn tested(&self, squares: [Option<f64>; 4]) -> Errors {
        let [phi, omega, mu, director] = squares.map(|square| square.map(f64::sqrt));
        match self.run.problem {
            problem if problem.is_director_alone() => [None, None, None, director],
            _ => [phi, omega, mu, director],
        }
    }
}

/// 2·fine − coarse, field by field: the limit Δt → 0 but for terms of second order, where the fine
/// run takes twice as many steps.
pub fn extrapolated(coarse: &State, fine: &State) -> State {
    let combine = |coarse: &[f64], fine: &[f64]| -> Vec<f64> {
        let pairs = fine.iter().zip(coarse);
        pairs.map(|(fine, coarse)| 2.0 * fine - coarse).collect()
    };
    let directors = coarse.director.as_ref().zip(fine.director.as_ref());
    State {
        phi: combine(&coarse.phi, &fine.phi),
        omega: combine(&coarse.omega, &fine.omega),
        mu: combine(&coarse.mu, &fine.mu),
        director: directors.map(|(coarse, fine)| [0, 1].map(|i| combine(&coarse[i], &fine[i]))),
    }
}
