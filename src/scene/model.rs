//! A scene as the rest of the program sees it: every default filled in, every value checked.
//!
//! The TOML that a user writes is read in `schema`; this is what it becomes. All quantities are
//! dimensionless; the domain is Ω = [0,1]², or the polygon that a mesh from a file covers. Symbols are those of Table 1 of the paper.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::expression::Expression;
use super::mesh_file::MeshFile;
use crate::geometry::{Vector, direction};

/// One simulation, complete.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// A title for people.
    pub name: String,
    /// What holds on ∂Ω.
    pub boundary: Boundary,
    /// The triangulation.
    pub mesh: Mesh,
    /// φ⁰.
    pub vesicle: Vesicle,
    /// Δt and T.
    pub time: Time,
    /// The membrane and its bending: ε, γ_ben, k(x).
    pub membrane: Membrane,
    /// The penalty of the surface area; `None`: the area is free.
    pub area: Option<Area>,
    /// The nematic order; `None`: there is no director at all.
    pub nematic: Option<Nematic>,
    /// The anchoring of the director at the membrane; `None` where the scene has no such table.
    pub anchoring: Option<Anchoring>,
    /// An external field on the director; `None`: there is none.
    pub field: Option<Field>,
    /// A given potential that moves the membrane; `None`: there is none.
    pub pull: Option<Pull>,
    /// Thermal noise on the director; `None`: none.
    pub noise: Option<Noise>,
    /// How the equations are solved.
    pub solver: Solver,
}

/// The condition on φ at ∂Ω.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Boundary {
    /// ∇φ·n = ∇μ·n = 0, as the weak form (3.16) has it.
    Natural,
    /// φ = −1 on ∂Ω, as (2.13) states.
    Clamped,
}

/// The triangulation of Ω.
#[derive(Debug, Clone, PartialEq)]
pub enum Mesh {
    /// Right triangles, `cells` squares along each side, diagonals from lower left to upper right.
    Structured {
        /// 1/h.
        cells: usize,
        /// Interior nodes are moved by up to this fraction of h in x and in y.
        jitter: f64,
        /// Of the generator that moves them.
        seed: u64,
    },
    /// A Delaunay triangulation of the unit square, by its size, graded where it is asked for.
    Delaunay {
        /// The wanted length of an edge.
        size: f64,
        /// Of the generator that scatters the nodes.
        seed: u64,
        /// Finer about the initial membrane.
        refine: Option<Refinement>,
    },
    /// From a file.
    File(MeshFile),
}

impl Mesh {
    /// Squares along a side of the structured mesh.
    pub fn cells(&self) -> Option<usize> {
        match self {
            Self::Structured { cells, .. } => Some(*cells),
            Self::Delaunay { .. } | Self::File(_) => None,
        }
    }

    /// Whether it is the structured mesh with every node in its place.
    pub fn is_grid(&self) -> bool {
        matches!(self, Self::Structured { jitter, .. } if *jitter == 0.0)
    }
}

/// Smaller triangles about the initial membrane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refinement {
    /// So far from the membrane, on either side.
    pub band: f64,
    /// The wanted length of an edge there.
    pub size: f64,
}

/// The initial phase field φ⁰.
#[derive(Debug, Clone, PartialEq)]
pub struct Vesicle {
    /// Where φ⁰ comes from.
    pub shape: Shape,
    /// How φ⁰ is brought onto the P1 space.
    pub projection: Projection,
    /// φ⁰ is multiplied by this (1 but in tests).
    pub scale: f64,
}

/// Where φ⁰ comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// tanh(s/(√2 ε)) of the largest signed distance s to any of the outlines.
    Outlines(Vec<Outline>),
    /// Independent nodal values, uniform in (−amplitude, amplitude).
    Random {
        /// Bound of the values.
        amplitude: f64,
        /// Of the generator.
        seed: u64,
    },
    /// Nodal values from a file.
    File(NodalValues),
}

/// A closed curve in the plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// Its kind and size.
    pub curve: Curve,
    /// Its centre.
    pub center: [f64; 2],
    /// The angle to the x axis of the axis that the curve has along x, in degrees.
    pub angle: f64,
}

impl Outline {
    /// The direction of its long axis, a unit vector.
    pub fn long_axis(&self) -> Vector {
        let axis = direction(self.angle);
        match self.curve {
            Curve::Ellipse {
                half_axes: [first, second],
            } if first < second => Vector::new(-axis.y, axis.x),
            _ => axis,
        }
    }
}

/// The kind and the size of a closed curve, centred at the origin; its long axis is along x, but for an
/// ellipse whose second axis is the longer one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Curve {
    /// A circle.
    Circle {
        /// Its radius.
        radius: f64,
    },
    /// An ellipse.
    Ellipse {
        /// Half its axes; the first is the one along [`Outline::angle`].
        half_axes: [f64; 2],
    },
    /// A Cassini oval: the points whose distances to the foci (±c, 0) have the product a².
    Cassini {
        /// c/a, in [0, 1): at 1 the oval falls into two.
        ratio: f64,
        /// sqrt(a² + c²).
        half_length: f64,
    },
    /// The Evans–Fung discocyte: half-thickness ½·R·sqrt(1−t²)(0.207 + 2.003 t² − 1.123 t⁴), t = x/R.
    Discocyte {
        /// R.
        radius: f64,
    },
}

/// How φ⁰ is brought onto the P1 space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Projection {
    /// (∇φ_h, ∇v) = (∇φ⁰, ∇v) with ∫φ_h = ∫φ⁰.
    Ritz,
    /// (φ_h, v) = (φ⁰, v): the paper's (3.15).
    L2,
    /// Interpolation at the nodes.
    Nodal,
}

/// The time axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Time {
    /// Δt; with a `tolerance` the Δt that is tried first.
    pub step: f64,
    /// Bound of the estimated error of φ in one step, in L2, by which Δt is chosen; `None`: Δt is
    /// `step` throughout.
    pub tolerance: Option<f64>,
    /// Of the method in time.
    pub order: Order,
    /// T.
    pub end: f64,
}

impl Time {
    /// The number of steps: T/Δt, rounded. `None` where Δt is chosen on the way.
    pub fn steps(&self) -> Option<u64> {
        // A cast from f64 saturates; Δt and T are positive and finite.
        let is_fixed = self.tolerance.is_none();
        is_fixed.then(|| (self.end / self.step).round() as u64)
    }
}

/// The order of the method in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// The scheme as it is, (3.20)–(3.21).
    First,
    /// Each step is taken whole and in halves, and the two are combined so that the error of first
    /// order falls out.
    Second,
    /// In thirds as well, so that the error of second order falls out too.
    Third,
}

impl Order {
    /// As a number.
    pub fn number(self) -> u8 {
        match self {
            Self::First => 1,
            Self::Second => 2,
            Self::Third => 3,
        }
    }

    /// In how many ways an extrapolated step is taken: at least two, for the estimate of its error.
    pub fn chains(self) -> usize {
        usize::from(self.number()).max(2)
    }
}

/// The membrane.
#[derive(Debug, Clone, PartialEq)]
pub struct Membrane {
    /// ε.
    pub interface_width: f64,
    /// γ_ben.
    pub mobility: f64,
    /// k(x).
    pub spontaneous_curvature: ScalarField,
}

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

/// Nodal values that were read from a file, one line a node.
#[derive(Debug, Clone, PartialEq)]
pub struct NodalValues {
    /// The path as the scene gives it.
    pub path: String,
    /// The values, `columns` of them a node, node by node.
    pub values: Arc<[f64]>,
    /// Values a node: 1 (a scalar) or 2 (a vector).
    pub columns: usize,
}

/// The penalty of the surface area, E_pen = (B − β)²/(2η).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// β as a fraction of B(φ⁰).
    pub target: f64,
    /// η.
    pub penalty: f64,
}

/// The nematic order.
#[derive(Debug, Clone, PartialEq)]
pub struct Nematic {
    /// λ_nem.
    pub weight: f64,
    /// γ_nem.
    pub mobility: f64,
    /// η_d.
    pub penalty: f64,
    /// d⁰.
    pub initial: InitialDirector,
}

/// The initial director d⁰.
#[derive(Debug, Clone, PartialEq)]
pub enum InitialDirector {
    /// The same vector everywhere; its length is kept.
    Uniform([f64; 2]),
    /// Unit vectors at the angle Σ winding·atan2(y − y_c, x − x_c) + angle.
    Defects {
        /// The defects.
        at: Vec<Defect>,
        /// In degrees.
        angle: f64,
    },
    /// Vectors of a given length at independent random angles.
    Random {
        /// Of the generator.
        seed: u64,
        /// |d⁰|.
        length: f64,
    },
    /// Nodal values from a file, x and y a line.
    File(NodalValues),
}

/// A point defect of the director.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Defect {
    /// Where it is.
    pub center: [f64; 2],
    /// How often the director turns around it.
    pub winding: f64,
}

/// The anchoring of the director at the membrane.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Anchoring {
    /// Which direction it prefers.
    pub kind: AnchoringKind,
    /// λ_anch.
    pub weight: f64,
}

/// The direction that the membrane prefers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum AnchoringKind {
    /// (δ1, δ2) = (0, 0).
    None,
    /// Along the membrane: (δ1, δ2) = (0, 1).
    Parallel,
    /// Across the membrane: (δ1, δ2) = (1, −1).
    Homeotropic,
}

/// A magnetic or electric field, E = −½ χ Σ_T |T| ⟨I(φ)⟩ ⟨(d·H)²⟩ with means over the triangles T: but for
/// the order h² it is −½ χ ∫ I(φ)(d·H)².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Field {
    /// χ: the director turns along the field where it is positive, across it where it is negative.
    pub weight: f64,
    /// |H|.
    pub strength: f64,
    /// Of H to the x axis, in degrees.
    pub angle: f64,
    /// When it is switched on.
    pub from: f64,
    /// When it is switched off; `None`: never.
    pub until: Option<f64>,
}

impl Field {
    /// H.
    pub fn vector(&self) -> Vector {
        self.strength * direction(self.angle)
    }
}

/// A pull on the membrane, E = −∫ φ U: the vesicle is drawn to where U is large.
#[derive(Debug, Clone, PartialEq)]
pub struct Pull {
    /// U(x).
    pub potential: ScalarField,
}

/// Thermal noise on the director inside the vesicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// The temperature k_B T, in units of the energy.
    pub strength: f64,
    /// Of the random numbers.
    pub seed: u64,
}

/// How the equations are solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solver {
    /// The rule of every integral.
    pub quadrature: Quadrature,
    /// The iteration for (3.21).
    pub iteration: Iteration,
    /// How the linear systems of substep 2 are solved.
    pub linear: LinearMethod,
    /// Bound of the relative L2 change of each field in the last iteration.
    pub tolerance: f64,
    /// Bound of |law_residual|.
    pub law_tolerance: f64,
}

/// The rule of every integral.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quadrature {
    /// Seven points a triangle, exact to degree 5.
    Consistent,
    /// The three vertices of a triangle.
    Lumped,
}

/// The iteration for the nonlinear system (3.21).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Iteration {
    /// Newton's method, damped.
    Newton,
    /// (4.35): G_sec and B are those of the last iterate.
    Lagged,
}

/// How the linear systems of substep 2 are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinearMethod {
    /// The fast one where it applies, the factor where it does not or fails.
    Automatic,
    /// Krylov iteration, preconditioned by cosine transforms: structured meshes.
    Transform,
    /// Krylov iteration, preconditioned by sparse factors of three shifted Laplacians: any mesh, the
    /// natural boundary.
    Shifted,
    /// Krylov iteration, preconditioned by a sparse LDLᵀ factor: any mesh.
    Factor,
}
