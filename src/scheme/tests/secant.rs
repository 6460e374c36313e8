//! What the secant scheme does not damp.

use super::super::{STARTING_STEPS, Scheme, initial_fields};
use crate::fem::Mesh;
use crate::scene::Scene;

/// Steps so long that what is stiff in φ⁰ is far from resolved.
const DT: f64 = 4e-6;

fn scheme(starting: u32) -> Scheme {
    let text = "
        mesh.cells = 24
        vesicle = { shape = 'ellipse', half_axes = [0.3, 0.2], angle = 70 }
        membrane.interface_width = 0.05
        time.scheme = 'secant'
        solver = { tolerance = 1e-9, law_tolerance = 1e-12 }
        area.target = 1.1
    ";
    let scene = Scene::of_text(text, &[]);
    let mesh = Mesh::of(&scene).expect("a mesh");
    let initial = initial_fields(&scene, &mesh).expect("fields");
    let mut scheme = Scheme::new(&scene, mesh, initial.phi, None).expect("a scheme");
    scheme.starting = starting;
    scheme
}

/// φ at the time 10 DT, reached in `steps` equal steps.
fn end(starting: u32, steps: u32) -> Vec<f64> {
    let mut scheme = scheme(starting);
    for _ in 0..steps {
        scheme.step(10.0 * DT / f64::from(steps)).expect("a step");
    }
    scheme.state.phi
}

/// Without the steps of first order what is stiff in φ⁰ rings on: it keeps its size and changes its sign in every step.
#[test]
fn what_is_stiff_rings_without_the_starting_steps() {
    let exact = end(STARTING_STEPS, 320);
    let error = |starting| {
        let phi = end(starting, 10);
        let squares = phi.iter().zip(&exact).map(|(a, b)| (a - b).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let (damped, ringing) = (error(STARTING_STEPS), error(0));
    assert!(ringing > 10.0 * damped, "{ringing:e} {damped:e}");
}
