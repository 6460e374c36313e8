//! Off is absent: a scene without an effect is the limit of the scene with it, bit for bit, and its
//! steps do no work for it. And substep 1 is solved where it matters, no more and no less.

use super::super::active_region::{ActiveRegion, Criterion};
use super::super::director::{DirectorStep, SolveOptions};
use super::super::*;
use crate::geometry::{Point, length};
use crate::linalg::op_counts::{self, Counts};

const STEPS: u32 = 4;
const DT: f64 = 1e-6;

/// A small vesicle with room around it, and the three effects of the paper.
const SMALL: &str = r#"
    [mesh]
    cells = 32
    [vesicle]
    shape = "ellipse"
    half_axes = [0.2, 0.14]
    angle = 70
    [membrane]
    interface_width = 0.025
    [area]
    target = 1.1
    [nematic]
    initial = [0.6, 0.8]
    [anchoring]
    kind = "parallel"
"#;

fn scene(settings: &[&str]) -> Scene {
    let settings: Vec<String> = settings.iter().map(|text| (*text).to_owned()).collect();
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    Scene::parse(SMALL, "the test", &settings, &mut no_files).expect("a scene")
}

fn scheme(scene: &Scene) -> Scheme {
    let mesh = Mesh::of(scene).expect("a fair mesh");
    let initial = initial_fields(scene, &mesh).expect("initial fields");
    Scheme::new(scene, mesh, initial.phi, initial.director).expect("a scheme")
}

/// A few steps: where they end, what they did, and how often the equations were linearised.
fn steps(settings: &[&str]) -> (Scheme, Counts, u64) {
    let mut scheme = scheme(&scene(settings));
    let mut jacobian = 0;
    let counts = op_counts::of(|| {
        for step in 1..=STEPS {
            let mut watch = |phase| jacobian += u64::from(phase == Phase::Linearisation);
            if let Err(error) = scheme.try_step(DT, &mut watch) {
                panic!("{settings:?} step {step}: {error}");
            }
            scheme.accept();
        }
    });
    (scheme, counts, jacobian)
}

const QUADRATURES: [&str; 2] = ["solver.quadrature=lumped", "solver.quadrature=consistent"];

/// Each effect off, and so weak that adding it changes no bit.
const LIMITS: [(&[&str], &[&str]); 8] = [
    (&["area=false"], &["area.penalty=1e300"]),
    (
        &["anchoring=false", "nematic=false"],
        &["anchoring.kind=none", "nematic.weight=0"],
    ),
    (&["anchoring=false"], &["anchoring.weight=0"]),
    (&["anchoring=false"], &["anchoring.kind=none"]),
    (&[], &["field.weight=0"]),
    (&[], &["field={ weight = 300, from = 1 }"]),
    (&[], &["pull.potential=0"]),
    (&[], &["membrane.spontaneous_curvature=1e-300"]),
];

#[test]
fn an_absent_effect_is_the_limit_of_a_weak_one() {
    for quadrature in QUADRATURES {
        for (off, weak) in LIMITS
            .into_iter()
            .chain([(&[][..], &["noise.strength=0"][..])])
        {
            let (without, counts, _) = steps(&[off, &[quadrature]].concat());
            let (with, counts_with, _) = steps(&[weak, &[quadrature]].concat());
            let (a, b) = (without.state(), with.state());
            assert_eq!(
                (&a.phi, &a.omega, &a.mu),
                (&b.phi, &b.omega, &b.mu),
                "{weak:?}"
            );
            if a.director.is_some() {
                assert_eq!(a.director, b.director, "{weak:?}");
            }
            for energy in &without.report().energies {
                assert!(
                    with.report().energies.contains(energy),
                    "{weak:?}: {energy:?}"
                );
            }
            assert!(
                counts.products <= counts_with.products
                    && counts.assemblies <= counts_with.assemblies,
                "{off:?} {counts:?}, {weak:?} {counts_with:?}"
            );
        }
    }
}

/// Three matrices whenever the equations are linearised, whatever the effects, and those of substep 1 only
/// where there is a director.
#[test]
fn an_absent_effect_does_no_work() {
    let without = ["anchoring=false", "nematic=false"];
    for off in [&["area=false"][..], &[]] {
        let (_, counts, jacobian) = steps(&[&[QUADRATURES[0]], off, &without].concat());
        assert_eq!(counts.assemblies, 3 * jacobian, "{off:?}");
    }
    let (_, counts, jacobian) = steps(&[QUADRATURES[0], "nematic.weight=0", "anchoring=false"]);
    assert_eq!(
        counts.assemblies,
        3 * jacobian,
        "nothing acts on the director"
    );
    let (scheme, counts, jacobian) = steps(&[QUADRATURES[0]]);
    // When a region is made, so are its stiffness matrix and nothing else.
    let regions = scheme
        .director
        .as_ref()
        .map_or(0, |step| step.region().parts_made);
    assert!(regions > 0);
    assert_eq!(counts.assemblies, 3 * jacobian + u64::from(STEPS) + regions);
    assert!(scheme.report().director_iterations > 0);
}

/// And not in every iteration of Newton's method: the last ones continue what the one before had.
#[test]
fn the_jacobian_is_assembled_less_often_than_systems_are_solved() {
    let mut scheme = scheme(&scene(&[QUADRATURES[0], "area=false"]));
    let (mut jacobian, mut newton) = (0, 0);
    for _ in 0..STEPS {
        let mut watch = |phase| jacobian += u32::from(phase == Phase::Linearisation);
        scheme.try_step(DT, &mut watch).expect("a step");
        newton += scheme.accept().newton;
    }
    assert!(
        jacobian >= STEPS && 4 * jacobian <= 3 * newton,
        "{jacobian} {newton}"
    );
}

/// The whole mesh, in place of the region, gives the same director up to what may be left out.
#[test]
fn substep_1_leaves_out_what_does_not_matter() {
    for (quadrature, dt) in [
        (QUADRATURES[0], 1e-7),
        (QUADRATURES[1], 1e-7),
        (QUADRATURES[0], 1e-6),
    ] {
        // Neighbours that differ: wherever anything acts there is something to do.
        let random = "nematic.initial={ kind = 'random', seed = 3, length = 1.2 }";
        let scheme = scheme(&scene(&[quadrature, random]));
        let energy_scale = scheme.energy_scale(&scheme.report.energies);
        let options = SolveOptions {
            dt,
            scheme: TimeScheme::FirstOrder,
            is_second: false,
            tolerance: 1e-14,
            law_tolerance: 1e-8,
            is_faint: false,
            energy_scale,
        };
        let mobility = 0.5;
        let mut part = DirectorStep::new(&scheme.space, mobility);
        let mut whole = DirectorStep::new(&scheme.space, mobility);
        whole.solve_everywhere();
        let from = scheme.state.director.clone().expect("a director");
        let mut ends = [from.clone(), from.clone()];
        for (step, to) in [&mut part, &mut whole].into_iter().zip(&mut ends) {
            let start = (&scheme.state.phi[..], &from);
            step.solve(&scheme.space, &scheme.effects, options, start, to)
                .expect("a solved substep");
        }
        let nodes = scheme.space.nodes();
        let still =
            (0..nodes).filter(|&n| ends[0][0][n] == from[0][n] && ends[0][1][n] == from[1][n]);
        let share = still.count() as f64 / nodes as f64;
        assert!(
            share > 0.3,
            "{quadrature} {dt:e}: {share} of the nodes left out"
        );
        // Substep 1 minimises ½ δᵀAδ − bᵀδ with A ≥ M/(γΔt), and the minimum over part of the nodes is
        // higher by ½ (δ' − δ)ᵀA(δ' − δ).
        let [fewer, more] = &ends;
        let lost: f64 = (0..2)
            .map(|axis| {
                let pairs = fewer[axis].iter().zip(&more[axis]);
                let off: Vec<f64> = pairs.map(|(fewer, more)| fewer - more).collect();
                scheme.space.mass().quadratic_form(&off) / (mobility * dt)
            })
            .sum();
        let lost = lost / energy_scale;
        assert!(lost < 1e-12, "{quadrature} {dt:e}: {lost:e}");
        let all = whole.dissipation(&scheme.space, dt);
        assert!(
            all / energy_scale > 1e-9,
            "{quadrature} {dt:e}: {:e}",
            all / energy_scale
        );
    }
}

/// A tweezer draws the vesicle away and disturbs φ all around it, so that the region becomes another: the
/// law closes all the same.
#[test]
fn the_law_closes_while_the_region_changes() {
    let settings = [
        QUADRATURES[0],
        "pull.potential='-200000*(x-0.7)^2'",
        "vesicle.center=[0.4, 0.5]",
        "solver.law_tolerance=1e-12",
        "solver.tolerance=1e-10",
    ];
    let mut scheme = scheme(&scene(&settings));
    let mut regions = std::collections::BTreeSet::new();
    for step in 1..=40 {
        match scheme.step(1e-5) {
            Ok(report) => assert!(report.law_residual.abs() <= 1e-12, "step {step}"),
            Err(error) => panic!("step {step}: {error}"),
        }
        let director = scheme.director.as_ref().expect("a director");
        regions.insert(director.region().nodes.clone());
    }
    assert!(regions.len() >= 2, "{} regions", regions.len());
}

/// The region follows a vesicle that is drawn over the mesh: nodes join before it and are left behind it,
/// what is inside is never left out, and what is far from it always.
#[test]
fn the_region_follows_the_vesicle() {
    let scheme = scheme(&scene(&[QUADRATURES[0]]));
    let (space, radius, width) = (&scheme.space, 0.15, 0.025);
    let criterion = Criterion {
        reach: scheme.effects.director_coupling(),
        largest_eigenvalue: space.stiffness().eigenvalue_bound(space.nodal_weights()),
        length: 1.0,
        energy_scale: scheme.energy_scale(&scheme.report.energies),
        inertia: 0.5 * DT,
        coupled: false,
    };
    let mut region = ActiveRegion::default();
    let mut before = vec![false; space.nodes()];
    for step in 0..=10 {
        let x = 0.35 + 0.03 * f64::from(step);
        let center = Point::new(x, 0.5);
        let outside = space.mesh().nodes().iter();
        let outside: Vec<f64> = outside.map(|node| length(node - center) - radius).collect();
        let profile = |outside: &f64| (-outside / (2.0_f64.sqrt() * width)).tanh();
        let phi: Vec<f64> = outside.iter().map(profile).collect();
        let moved = region.follow(space, &phi, &criterion).expect("a part");
        assert!(moved, "step {step}");
        assert!(!region.follow(space, &phi, &criterion).expect("the same"));
        let mut now = vec![false; space.nodes()];
        region
            .nodes
            .iter()
            .for_each(|&node| now[node as usize] = true);
        for (node, outside) in outside.iter().enumerate() {
            assert!(now[node] || *outside > 0.0, "step {step}: {node} is inside");
            assert!(!now[node] || *outside < 0.45, "step {step}: {node} is far");
        }
        let count = |came: bool| {
            let pairs = before.iter().zip(&now);
            pairs
                .filter(|(before, now)| **now == came && **before != came)
                .count()
        };
        let (joined, left) = (count(true), count(false));
        assert!(
            joined > 0 && (step == 0 || left > 0),
            "{joined} joined, {left} left"
        );
        before = now;
    }
}
