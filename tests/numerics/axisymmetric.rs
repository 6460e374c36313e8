//! Bodies of rotation: every identity of the plane holds with the measure 2πr dr dz, and what is known of spheres comes out.

use std::f64::consts::PI;

use crate::common::{TIGHT, energy_scale, greatest, named, scene, scheme};
use vesica::internal::fem::Contour;
use vesica::internal::simulation::Schedule;
use vesica::internal::theory::Branch;
use vesica::{Scene, Scheme, Simulation, find_preset};

const QUADRATURES: [&str; 2] = ["solver.quadrature=consistent", "solver.quadrature=lumped"];

/// A spheroid on the axis, above the middle, with every effect.
const SPHEROID: &str = r#"
    [domain]
    geometry = "axisymmetric"
    [mesh]
    cells = 12
    [vesicle]
    shape = "ellipse"
    half_axes = [0.3, 0.22]
    center = [0.0, 0.53]
    [time]
    step = 1e-6
    end = 1e-5
    [membrane]
    interface_width = 0.08
    spontaneous_curvature = "2*sin(3*x) - y"
    [area]
    target = 1.1
    [nematic]
    initial = { kind = "random", seed = 3, length = 1.3 }
    [anchoring]
    kind = "homeotropic"
    [field]
    weight = 300
    angle = 90
    [pull]
    potential = "100*x - 300*y^2"
    [noise]
    strength = 1e-4
    seed = 5
"#;

/// What a step must obey, and that d is along the axis on it.
#[track_caller]
fn check_step(scheme: &mut Scheme, dt: f64, place: &str) {
    let before = scheme.report().total_energy;
    let report = match scheme.step(dt) {
        Ok(report) => report.clone(),
        Err(error) => panic!("{place}: {error}"),
    };
    assert_eq!(report.fallback, None, "{place}");
    assert!(
        report.law_residual.abs() <= 1e-12,
        "{place}: {:e}",
        report.law_residual
    );
    let scale = energy_scale(&report);
    let mut given = 0.0;
    for term in &report.ledger {
        match term.name {
            "noise_work" => given -= term.value,
            "dE" => {}
            _ => assert!(term.value >= -1e-14 * scale, "{place}: {term:?}"),
        }
    }
    let rise = report.total_energy - before;
    assert!(rise <= given + 1e-12 * scale, "{place}: {rise:e}");
    if let Some([radial, _]) = &scheme.state().director {
        let on_axis = scheme.space().mesh().on_axis();
        let there = radial.iter().zip(on_axis).filter(|(_, on)| *on);
        assert!(there.map(|(d, _)| *d).all(|d| d == 0.0), "{place}");
        assert!(greatest(radial) > 0.1, "{place}");
    }
}

/// All effects together, and those of the membrane alone, by every way to solve the equations.
#[test]
fn the_law_closes_with_every_effect_mesh_and_solver() {
    let without = [
        "field=false",
        "noise=false",
        "anchoring=false",
        "nematic=false",
    ];
    for quadrature in QUADRATURES {
        for settings in [
            &[][..],
            &["field.weight=-300", "anchoring.kind=parallel"],
            &without,
            &["solver.linear=factor"],
            &["domain.boundary=clamped"],
            &["mesh.jitter=0.3"],
            &["time.scheme=secant", "time.step=1e-5"],
            &["solver.iteration=lagged"],
            &["mesh={ kind = 'delaunay', size = 0.08 }"],
            &["mesh={ kind = 'adaptive', size = 0.15, interface = 0.06, band = 0.1 }"],
        ] {
            let settings = [settings, &[quadrature], &TIGHT].concat();
            let scene = scene(SPHEROID, &settings);
            let mut scheme = scheme(&scene);
            let start = scheme.report().phase_integral;
            for step in 1..=4 {
                let place = format!("{settings:?}, step {step}");
                check_step(&mut scheme, scene.time.step, &place);
                let drift = scheme.report().phase_integral - start;
                assert!(drift.abs() <= 1e-12, "{place}: ∫φ by {drift:e}");
            }
        }
    }
}

/// Chosen steps on a mesh that follows the membrane.
#[test]
fn chosen_steps_keep_the_law_on_a_mesh_that_follows() {
    let scene = scene(
        SPHEROID,
        &[
            "mesh={ kind = 'adaptive', size = 0.15, interface = 0.05, band = 0.1 }",
            "pull.potential='3000*y'",
            "noise=false",
            "time={ tolerance = 1e-3, end = 4e-4 }",
        ],
    );
    let mut simulation = Simulation::new(&scene).expect("a simulation");
    let volume = simulation.report().phase_integral;
    for _ in 0..12 {
        simulation.advance().expect("a step");
        let report = simulation.report();
        assert!(report.law_residual.abs() <= 1e-8);
        assert!((report.phase_integral - volume).abs() < 1e-12);
    }
    assert!(simulation.renew_mesh().expect("a mesh"));
    assert!((simulation.report().phase_integral - volume).abs() < 1e-12);
    let on_axis = simulation.mesh().on_axis().filter(|on| *on).count();
    assert!(on_axis > 4);
}

fn sphere(radius: f64, width: f64, settings: &[&str]) -> Scene {
    let edge = width / 3.0;
    let text = format!(
        "domain.geometry = \"axisymmetric\"\n\
         mesh = {{ kind = \"delaunay\", size = 0.1, refine = {{ band = 0.06, size = {edge} }} }}\n\
         vesicle = {{ shape = \"circle\", radius = {radius}, center = [0.0, 0.5] }}\n\
         membrane.interface_width = {width}\n\
         area.target = 1.0"
    );
    scene(&text, settings)
}

/// E_ben = (2√2/3)·8π = 23.695 whatever the radius, and B = (2√2/3)·4πR². (In the plane the same φ would have 2.96/R.)
#[test]
fn a_sphere_has_the_bending_energy_of_a_sphere() {
    let factor = 8.0_f64.sqrt() / 3.0;
    for quadrature in QUADRATURES {
        for radius in [0.2, 0.3] {
            let scheme = scheme(&sphere(radius, 0.02, &[quadrature]));
            let bending = named(&scheme.report().energies, "bending");
            let place = format!("{quadrature} {radius}");
            assert!(
                (bending / (factor * 8.0 * PI) - 1.0).abs() < 0.02,
                "{place}: {bending}"
            );
            let area = scheme.report().surface_area / (factor * 4.0 * PI * radius * radius);
            assert!((area - 1.0).abs() < 0.02, "{place}: {area}");
        }
    }
}

/// A hedgehog d = e_r, from its centre: ½|∇d|² = 1/r², so that E_nem = 4πλ_nem ∫ I(φ) dr = 4πλ_nem R. Half of it is the part of
/// ∇d along the circle.
#[test]
fn a_hedgehog_has_its_elastic_energy() {
    let settings = [
        "nematic={ weight = 2, penalty = 0.01, initial = { kind = 'defects', at = [{ center = [0.0, 0.5] }] } }",
        "mesh={ kind = 'delaunay', size = 0.02 }",
    ];
    for quadrature in QUADRATURES {
        let scene = sphere(0.3, 0.03, &[&settings[..], &[quadrature]].concat());
        let mut without_core = scene.clone();
        let nematic = without_core.nematic.as_mut().expect("a nematic");
        // Next to the centre d cannot have the length 1 on triangles: without what that costs.
        nematic.penalty = 1e3;
        let energy = named(&scheme(&without_core).report().energies, "nematic");
        let exact = 4.0 * PI * 2.0 * 0.3;
        assert!(
            (energy / exact - 1.0).abs() < 0.05,
            "{quadrature}: {energy}, not {exact}"
        );
    }
}

/// A spheroid of examples/vesicles-in-space.toml, with ε/R₀ = 0.06 and ε/h = 3 at the membrane.
struct Spheroid {
    half_axes: [f64; 2],
    interface_width: f64,
    mobility: f64,
    area_penalty: f64,
}

/// Those that are soon at rest: prolate with v = 0.85, and oblate with 0.8.
const PROLATE: Spheroid = Spheroid {
    half_axes: [0.1823, 0.4293],
    interface_width: 0.01536,
    mobility: 3.52e-4,
    area_penalty: 8.2e-6,
};
const OBLATE: Spheroid = Spheroid {
    half_axes: [0.6234, 0.2573],
    interface_width: 0.03,
    mobility: 1e-2,
    area_penalty: 1.2e-4,
};

/// v of the surface φ = 0, and W, at rest.
fn at_rest(spheroid: &Spheroid) -> [f64; 2] {
    let Spheroid {
        half_axes,
        interface_width,
        mobility,
        area_penalty,
    } = spheroid;
    let [interface, band] = [1.0 / 3.0, 3.05].map(|widths| widths * interface_width);
    let text = format!(
        "domain.geometry = \"axisymmetric\"\n\
         mesh = {{ kind = \"adaptive\", size = 0.1, interface = {interface}, band = {band} }}\n\
         vesicle = {{ shape = \"ellipse\", half_axes = {half_axes:?}, center = [0.0, 0.5] }}\n\
         membrane = {{ interface_width = {interface_width}, mobility = {mobility} }}\n\
         area = {{ target = 1.0, penalty = {area_penalty} }}\n\
         time = {{ tolerance = 2e-2, end = 1.0, scheme = \"first-order\" }}\n\
         rest.tolerance = 1e-3"
    );
    let scene = scene::<&str>(&text, &[]);
    let schedule = Schedule::new(&scene.time, 1, 1);
    let mut simulation = Simulation::new(&scene).expect("a vesicle");
    simulation.follow(&schedule);
    while !schedule.is_done(simulation.report()) {
        simulation.advance().expect("a step");
    }
    assert!(simulation.report().is_at_rest);
    let contour = Contour::new(simulation.mesh(), &simulation.state().phi);
    let volume = contour.reduced_size().expect("a vesicle");
    let bending = named(&simulation.report().energies, "bending");
    [volume, bending / (8.0_f64.sqrt() / 3.0 * 8.0 * PI)]
}

/// Above the branch of the sharp interface, for ε is not small, by less than 2 %, and not above the other one, which is 3 to 5 % away.
#[test]
fn spheroids_come_to_rest_on_their_branches() {
    for (branch, other, spheroid) in [
        (Branch::Prolate, Branch::Oblate, PROLATE),
        (Branch::Oblate, Branch::Prolate, OBLATE),
    ] {
        let [volume, energy] = at_rest(&spheroid);
        let off = |branch: Branch| {
            let theory = branch.surface(volume).expect("it is on the branch");
            energy / theory.energy - 1.0
        };
        let [own, other] = [branch, other].map(off);
        assert!((0.78..0.88).contains(&volume), "{branch:?}: {volume}");
        let above = 0.0..0.02;
        assert!(
            above.contains(&own) && !above.contains(&other),
            "{branch:?} at {volume}: {own} {other}"
        );
    }
}

/// A fine mesh and a stiff area: what a linear system leaves in the equations of μ and ω may not keep the residual from falling.
/// (Where it never counts more than at first, as in `STRICTER` = 1 in scheme/membrane/iteration.rs, these are 147 steps.)
#[test]
fn the_steps_of_a_stiff_body_at_rest_become_long() {
    let text = find_preset("prolate").expect("a preset");
    let mut no_files = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    let scene = Scene::parse(text, "prolate", &["time.end=3e-3".into()], &mut no_files);
    let scene = scene.expect("a scene");
    let mut simulation = Simulation::new(&scene).expect("it can be set up");
    let mut refused = Vec::new();
    while simulation.report().t < scene.time.end {
        simulation.advance().expect("a step");
        let report = simulation.report();
        refused.extend((report.refused > 0).then_some((report.step, report.refused)));
    }
    assert!(refused.len() <= 2, "(step, attempts): {refused:?}");
    let steps = simulation.report().step;
    assert!(steps <= 45, "{steps}");
}
