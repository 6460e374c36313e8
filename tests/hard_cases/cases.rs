//! The scenes, each as what it changes in a common one.

/// A vesicle with every effect on a mesh that is as coarse for it as the paper's.
pub const BASE: &str = r#"
    [mesh]
    cells = 24
    [vesicle]
    shape = "cassini"
    [time]
    step = 1e-6
    end = 1
    [membrane]
    interface_width = 0.04
    [area]
    target = 1.25
    [nematic]
    [anchoring]
"#;

/// A hard case.
#[derive(Debug)]
pub struct Case {
    pub name: &'static str,
    /// KEY=VALUE.
    pub settings: &'static [&'static str],
    /// Of the quick part.
    pub steps: u64,
    /// Whether scene and mesh share the turn by 180° about the centre. (The diagonals of the mesh break
    /// the mirrors.)
    pub symmetric: bool,
    /// Whether the anchoring is switched every ten steps.
    pub switching: bool,
}

const fn case(name: &'static str, steps: u64, settings: &'static [&'static str]) -> Case {
    Case {
        name,
        settings,
        steps,
        symmetric: false,
        switching: false,
    }
}

const fn symmetric(name: &'static str, steps: u64, settings: &'static [&'static str]) -> Case {
    Case {
        symmetric: true,
        ..case(name, steps, settings)
    }
}

const RANDOM_DIRECTOR: &str = r#"nematic.initial={ kind = "random", seed = 2, length = 1.0 }"#;
const RANDOM: &str = r#"vesicle={ shape = "random", amplitude = 1.0, seed = 3 }"#;
const HEDGEHOG: &str =
    r#"nematic.initial={ kind = "defects", at = [{ center = [0.5, 0.5], winding = 1.0 }] }"#;
const HALF_PAIR: &str = r#"nematic.initial={ kind = "defects", at = [{ center = [0.5, 0.35], winding = -0.5 }, { center = [0.5, 0.65], winding = -0.5 }] }"#;
const MERGING: &str = r#"vesicle={ parts = [{ shape = "circle", radius = 0.15, center = [0.33, 0.5] }, { shape = "circle", radius = 0.15, center = [0.67, 0.5] }] }"#;

/// All of them.
pub const CASES: &[Case] = &[
    symmetric("as it is", 20, &[]),
    symmetric("Δt = 1e-4", 5, &["time.step=1e-4"]),
    symmetric("Δt = 1e-2", 3, &["time.step=1e-2"]),
    case("Δt = 1", 2, &["time.step=1", "time.end=10"]),
    case("random φ and d, Δt = 1e-6", 10, &[RANDOM, RANDOM_DIRECTOR]),
    case(
        "random φ and d, Δt = 1e-3",
        2,
        &[RANDOM, RANDOM_DIRECTOR, "time.step=1e-3"],
    ),
    symmetric("φ · 1.5", 10, &["vesicle.scale=1.5"]),
    symmetric("φ · 3", 3, &["vesicle.scale=3"]),
    symmetric("ε = h/2", 5, &["membrane.interface_width=0.0208"]),
    symmetric("ε = h/8", 3, &["membrane.interface_width=0.0052"]),
    symmetric("ε = 20 h", 5, &["membrane.interface_width=0.83"]),
    symmetric("η = 1e-6", 3, &["area.penalty=1e-6"]),
    case("η = 1e-8", 1, &["area.penalty=1e-8"]),
    symmetric("η_d = 5e-3", 10, &["nematic.penalty=5e-3", HEDGEHOG]),
    symmetric("η_d = 1e-3", 10, &["nematic.penalty=1e-3", HEDGEHOG]),
    symmetric("hedgehog", 10, &[HEDGEHOG]),
    case("two defects of −1/2", 10, &[HALF_PAIR]),
    symmetric("d⁰ = 0", 10, &["nematic.initial=[0.0, 0.0]"]),
    case("random d⁰", 10, &[RANDOM_DIRECTOR]),
    symmetric("|d⁰| = 3", 10, &["nematic.initial=[1.8, 2.4]"]),
    symmetric("λ_nem = 0", 10, &["nematic.weight=0"]),
    symmetric("λ_nem = 1e4", 10, &["nematic.weight=1e4", HEDGEHOG]),
    symmetric("λ_anch = 0", 10, &["anchoring.weight=0"]),
    symmetric("λ_anch = 1e4", 10, &["anchoring.weight=1e4"]),
    symmetric("k = 50", 5, &["membrane.spontaneous_curvature=50"]),
    case(
        "k(x) steep",
        5,
        &[r#"membrane.spontaneous_curvature="10*tanh(1000*(x - 0.5))""#],
    ),
    symmetric("β = 0.2 B", 5, &["area.target=0.2"]),
    symmetric("β = 3 B", 5, &["area.target=3"]),
    symmetric(
        "two that merge",
        10,
        &[MERGING, "time.step=1e-4", "area.target=0.9"],
    ),
    symmetric(
        "one that pinches off",
        10,
        &[
            "vesicle.ratio=0.99",
            "time.step=1e-4",
            "anchoring.weight=100",
        ],
    ),
    symmetric("at the wall, natural", 5, &["vesicle.half_length=0.5"]),
    symmetric(
        "at the wall, clamped",
        5,
        &["vesicle.half_length=0.5", r#"domain.boundary="clamped""#],
    ),
    case("distorted mesh", 5, &["mesh.jitter=0.3", "mesh.seed=5"]),
    symmetric("lumped", 20, &[r#"solver.quadrature="lumped""#]),
    symmetric("lagged iteration", 10, &[r#"solver.iteration="lagged""#]),
    symmetric("tiny steps", 100, &["time.step=1e-12"]),
    Case {
        switching: true,
        ..symmetric("anchoring switched", 40, &[])
    },
];
