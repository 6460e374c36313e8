//! What a scene is where it says nothing: Table 1 of the paper, case 3, homeotropic.
//!
//! The tables area, nematic, anchoring, field, pull and noise are effects: without its table, an
//! effect is absent. A
//! key that is left out of a table that is there has the value given here.

use super::model::{
    Anchoring, AnchoringKind, Area, Boundary, Curve, Field, InitialDirector, Iteration,
    LinearMethod, Membrane, Mesh, Nematic, Noise, Order, Outline, Projection, Quadrature,
    ScalarField, Scene, Shape, Solver, Time, Vesicle,
};

/// The centre of the domain.
pub(super) const CENTER: [f64; 2] = [0.5, 0.5];
/// The paper's vesicle, the Cassini oval, stands upright; every other shape lies along x.
pub(super) const CASSINI_ANGLE: f64 = 90.0;
pub(super) const ANGLE: f64 = 0.0;
/// c/a of the Cassini oval.
pub(super) const RATIO: f64 = 0.92;
/// sqrt(a² + c²) of the Cassini oval.
pub(super) const HALF_LENGTH: f64 = 0.32;
/// Of every generator.
pub(super) const SEED: u64 = 1;
/// 1/h.
pub(super) const CELLS: usize = 120;
/// h of a generated mesh.
pub(super) const SIZE: f64 = 1.0 / 120.0;

/// A scene that says nothing: bending alone.
impl Default for Scene {
    fn default() -> Self {
        Self {
            name: "Untitled".to_owned(),
            boundary: Boundary::Natural,
            mesh: Mesh::default(),
            vesicle: Vesicle::default(),
            time: Time::default(),
            membrane: Membrane::default(),
            area: None,
            nematic: None,
            anchoring: None,
            field: None,
            pull: None,
            noise: None,
            solver: Solver::default(),
        }
    }
}

impl Default for Mesh {
    fn default() -> Self {
        Self::Structured {
            cells: CELLS,
            jitter: 0.0,
            seed: SEED,
        }
    }
}

impl Default for Vesicle {
    fn default() -> Self {
        Self {
            shape: Shape::Outlines(vec![Outline::default()]),
            projection: Projection::Ritz,
            scale: 1.0,
        }
    }
}

impl Default for Outline {
    fn default() -> Self {
        let curve = Curve::Cassini {
            ratio: RATIO,
            half_length: HALF_LENGTH,
        };
        Self {
            curve,
            center: CENTER,
            angle: CASSINI_ANGLE,
        }
    }
}

impl Default for Time {
    fn default() -> Self {
        Self {
            step: 1e-7,
            tolerance: None,
            order: Order::First,
            end: 1e-3,
        }
    }
}

impl Default for Membrane {
    fn default() -> Self {
        Self {
            interface_width: 0.01,
            mobility: 0.01,
            spontaneous_curvature: ScalarField::Constant(0.0),
        }
    }
}

impl Default for Area {
    fn default() -> Self {
        Self {
            target: 1.25,
            penalty: 1e-3,
        }
    }
}

impl Default for Nematic {
    fn default() -> Self {
        Self {
            weight: 10.1,
            mobility: 0.5,
            penalty: 0.075,
            initial: InitialDirector::Uniform([0.0, 1.0]),
        }
    }
}

impl Default for Anchoring {
    fn default() -> Self {
        Self {
            kind: AnchoringKind::Homeotropic,
            weight: 10.1,
        }
    }
}

/// The paper has no field: this one is as strong as the elastic forces of a vesicle of Table 1.
impl Default for Field {
    fn default() -> Self {
        Self {
            weight: 1000.0,
            strength: 1.0,
            angle: 0.0,
            from: 0.0,
            until: None,
        }
    }
}

impl Default for Noise {
    fn default() -> Self {
        Self {
            strength: 1e-3,
            seed: SEED,
        }
    }
}

impl Default for Solver {
    fn default() -> Self {
        Self {
            quadrature: Quadrature::Consistent,
            iteration: Iteration::Newton,
            linear: LinearMethod::Automatic,
            tolerance: 1e-5,
            law_tolerance: 1e-8,
        }
    }
}
