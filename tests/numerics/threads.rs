//! A run gives the same bits in any number of threads: with both rules, every linear method, both schemes, and a director
//! whose region is a part of the mesh. (With sums over as many pieces as there are threads it would not.)

use crate::common::scene;
use vesica::Simulation;

/// Enough nodes for vectors to be divided.
const LARGE: &str = r#"
    [mesh]
    cells = 50
    [vesicle]
    shape = "ellipse"
    half_axes = [0.2, 0.14]
    angle = 70
    [time]
    step = 1e-6
    [membrane]
    interface_width = 0.02
    [area]
    target = 1.1
    [nematic]
    initial = [0.6, 0.8]
    [anchoring]
    kind = "parallel"
    [noise]
    strength = 0.1
"#;

#[test]
fn the_bits_are_the_same_in_any_number_of_threads() {
    for settings in [
        &["solver.quadrature=consistent"][..],
        &["solver.quadrature=lumped"],
        &["solver.linear=factor"],
        &["mesh.jitter=0.2"],
        &["time.tolerance=1e-2", "noise=false"],
    ] {
        let after_steps = |threads: usize| {
            let mut simulation = Simulation::new(&scene(LARGE, settings)).expect("a sound scene");
            simulation.set_threads(threads);
            assert_eq!(simulation.threads(), threads);
            for _ in 0..4 {
                simulation.advance().expect("a step");
            }
            let energies = simulation.report().energies.clone();
            let residual = simulation.report().law_residual;
            (
                format!("{:?} {energies:?} {residual}", simulation.state()),
                residual,
            )
        };
        let (alone, residual) = after_steps(1);
        assert!(residual.abs() <= 1e-8);
        for threads in [2, 3] {
            let (shared, _) = after_steps(threads);
            assert!(shared == alone, "{settings:?}, {threads} threads");
        }
    }
}
