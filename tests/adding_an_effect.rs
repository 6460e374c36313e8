//! The example of the guide, "Adding an effect": the file that is printed there is compiled here, put
//! beside the effects of a scene, and keeps the energy law.

mod common;

// What the file finds around it in src/physics/: that folder's own names as `super`, and fem and scene.
use vesica::physics::{
    DirectorCoupling, Effect, EffectContext, Effects, LedgerTerms, MembraneForce, MembraneJacobian,
    PatchFields,
};
use vesica::{fem, geometry, scene};

#[path = "../docs/effect/tension.rs"]
mod tension;

use common::{SMALL, TIGHT, energy_scale, named, scheme};
use tension::Tension;

#[test]
fn the_effect_of_the_guide_keeps_the_energy_law() {
    for quadrature in ["solver.quadrature=consistent", "solver.quadrature=lumped"] {
        let settings = [&TIGHT[..], &[quadrature]].concat();
        let mut scheme = scheme(&common::scene(SMALL, &settings));
        let without = scheme.report().total_energy;
        scheme.add_effect(Tension { weight: 3.0 });
        scheme.set_anchoring(None);
        assert!(scheme.report().total_energy != without);
        for step in 1..=4 {
            let report = match scheme.step(1e-6) {
                Ok(report) => report,
                Err(error) => panic!("{quadrature} step {step}: {error}"),
            };
            let residual = report.law_residual;
            assert!(
                residual.abs() <= 1e-12,
                "{quadrature} step {step}: {residual:e}"
            );
            assert!(named(&report.energies, "tension") > 0.1);
            assert!(named(&report.ledger, "ND_tension") > 0.0);
            assert!(named(&report.ledger, "dE") < 0.0);
            assert!(energy_scale(report) > 0.0);
        }
    }
}

/// What the line in the list does: it asks the file whether the scene has the effect.
#[test]
fn the_line_of_the_readme_brings_it_in() {
    let scene = common::scene(SMALL, &[] as &[&str]);
    let mesh = common::mesh(&scene);
    let space = fem::Space::new(mesh, fem::QuadratureRule::Lumped);
    let phi = vec![0.5; space.nodes()];
    let context = EffectContext {
        scene: &scene,
        space: &space,
        phi: &phi,
    };
    let effect = tension::of_scene(&context).expect("an effect");
    assert_eq!(effect.name(), "tension");
    let others = Effects::from_scene(&scene, &space, &phi);
    let names: Vec<_> = others.iter().map(|effect| effect.name()).collect();
    assert_eq!(names, ["bending", "area", "nematic", "anchoring"]);
    // The guide has the line, and the place where such lines stand.
    let guide = include_str!("../docs/guide/effects.md");
    assert!(guide.contains("in the list `effects!` of `src/physics/mod.rs`:\n\n    tension,\n"));
    let list = include_str!("../src/physics/mod.rs");
    assert!(list.contains("effects! {\n    area,\n"));
}

#[test]
fn the_guide_prints_the_file_that_is_compiled() {
    let file = include_str!("../docs/effect/tension.rs");
    let guide = include_str!("../docs/guide/effects.md");
    let printed = guide.split("```rust\n").nth(1).expect("an example");
    let printed = printed.split("```").next().expect("its end");
    assert_eq!(printed, file);
}
